// The tracking errors over time (uPlot), and below them a row of messages a sender.

const ROW_PX = 14, AXIS_PX = 72, SPAN_S = 30, BETWEEN_PX = 16;
const ERRORS_M = [0, ...[0.01, 0.1, 1, 10, 100, 1000].flatMap((one) => [1, 2, 3, 5].map((times) => Number((times * one).toPrecision(1))))];
const DASHES = [[], [6, 3], [2, 3]];

const makeTimeline = (place, trip, state) => {
  const t = [], gaps = [];
  trip.t.forEach((one, at) => {
    // A row of nothing breaks the lines at a gap of the recording, and where samples were left out.
    if (trip.begins.has(at) || trip.afterLeftOut.has(at)) { gaps.push(at); t.push((trip.t[at - 1] + one) / 2); }
    t.push(one);
  });
  const broken = new Set(gaps);
  const withGaps = (values) => values.flatMap((value, at) => (broken.has(at) ? [null, value] : [value]));
  // Samples without a neighbour make no line: they are dots.
  const alone = (self, series) => {
    const values = self.data[series], found = [];
    values.forEach((value, at) => {
      if (value != null && values[at - 1] == null && values[at + 1] == null) found.push(at);
    });
    return found;
  };
  const rowsOf = () => [t, ...state.runs().map((run) => withGaps(run.error)), t.map(() => trip.threshold)];
  const metres = (value) => (value === null || value === undefined ? "–" : `${value.toFixed(2)} m`);
  let plot = null;
  // Round errors up to the largest, as far apart as their figures need.
  const marksOf = (self) => {
    const found = [];
    for (const mark of ERRORS_M) {
      if (mark > self.scales.y.max) break;
      const last = found[found.length - 1];
      if (last === undefined || self.valToPos(last, "y") - self.valToPos(mark, "y") >= BETWEEN_PX) found.push(mark);
    }
    return found;
  };
  const head = document.createElement("div");
  head.className = "playback-head";
  const options = {
    width: 600,
    height: 210,
    padding: [8, 8, 0, 0],
    legend: { show: false },
    cursor: { y: false, drag: { x: true, y: false, setScale: true }, points: { size: 7 } },
    scales: {
      x: { time: false },
      // Straight up to two thresholds, logarithmic beyond: losses make errors of many metres.
      y: { distr: 4, asinh: 2 * trip.threshold, range: (_, __, most) => [0, Math.max(most || 0, 2 * trip.threshold) * 1.05] },
    },
    axes: [
      { label: "Time [s]", labelSize: 18, size: 34, stroke: INK, grid: { stroke: GRID }, ticks: { stroke: GRID } },
      {
        label: "Tracking error [m]", labelSize: 18, size: AXIS_PX - 18, stroke: INK, grid: { stroke: GRID }, ticks: { stroke: GRID },
        splits: (self) => marksOf(self), values: (_, marks) => marks.map(String), filter: (_, marks) => marks,
      },
    ],
    series: [
      {},
      ...trip.senders.map((one, at) => ({
        label: one.name, stroke: one.colour, width: 1.6, dash: DASHES[at % DASHES.length],
        points: { show: false, size: 3, fill: one.colour, filter: alone },
        value: (_, value) => metres(value),
      })),
      { label: "Threshold", stroke: INK, width: 1, dash: [1, 3], points: { show: false } },
    ],
    hooks: {
      setCursor: [({ cursor: { left, idx } }) => {
        state.point(left < 0 || idx === null || idx === undefined ? null : t[idx]);
      }],
      setScale: [() => drawMessages()],
      setSize: [() => drawMessages()],
    },
  };
  const errors = document.createElement("div");
  const strip = document.createElement("canvas");
  strip.setAttribute("aria-hidden", "true");
  place.append(errors, strip);
  const context = strip.getContext("2d");
  plot = new uPlot(options, rowsOf(), errors);
  plot.over.append(head);

  const shownSpan = () => [plot.scales.x.min, plot.scales.x.max];
  const show = (from, to) => {
    const span = Math.min(Math.max(to - from, 0.5), trip.end - trip.start || 1);
    const low = Math.min(Math.max(from, trip.start), trip.end - span);
    plot.setScale("x", { min: low, max: low + span });
  };
  const zoom = (factor) => {
    const [low, high] = shownSpan(), half = (high - low) / factor / 2;
    const middle = state.t >= low && state.t <= high ? state.t : (low + high) / 2;
    show(middle - half, middle + half);
  };

  function drawMessages() {
    if (!plot || !plot.over.clientWidth) return;
    const ratio = window.devicePixelRatio || 1, wide = place.clientWidth, tall = ROW_PX * trip.senders.length + 4;
    strip.style.height = `${tall}px`;
    strip.width = Math.round(wide * ratio);
    strip.height = Math.round(tall * ratio);
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    const left = plot.bbox.left / ratio, right = left + plot.bbox.width / ratio;
    const [low, high] = shownSpan();
    state.runs().forEach((run, sender) => {
      const middle = 2 + ROW_PX * (sender + 0.5);
      context.fillStyle = INK;
      context.font = "11px system-ui, sans-serif";
      context.textAlign = "right";
      context.textBaseline = "middle";
      context.fillText(trip.senders[sender].name.split(" ")[0].slice(0, 8), left - 5, middle);
      context.strokeStyle = context.fillStyle = trip.senders[sender].colour;
      context.lineWidth = 1;
      for (let at = lastAt(run.sent, low - 1e-9) + 1; at < run.sent.length && run.sent[at] <= high; at++) {
        const x = left + (run.sent[at] - low) / (high - low) * (right - left);
        const tallness = run.what[at] === "i" ? 3 : 5;
        if (run.lost[at]) context.strokeRect(x - 1.5, middle - tallness, 3, 2 * tallness);
        else context.fillRect(x - 1, middle - tallness, 2, 2 * tallness);
      }
    });
  }

  const draw = () => {
    const [low, high] = shownSpan();
    if (state.playing && (state.t > high || state.t < low)) show(state.t, state.t + (high - low));
    head.style.transform = `translateX(${plot.valToPos(state.t, "x")}px)`;
  };
  const changeChannel = () => {
    const [low, high] = shownSpan();
    plot.setData(rowsOf(), false);
    plot.setScale("x", { min: low, max: high });
    drawMessages();
  };
  // A click goes to its time; a drag has chosen a span before.
  let pressed = 0;
  plot.over.addEventListener("mousedown", (event) => { pressed = event.clientX; });
  plot.over.addEventListener("click", (event) => {
    if (Math.abs(event.clientX - pressed) < 4) state.seek(plot.posToVal(event.offsetX, "x"));
  });
  strip.addEventListener("click", (event) => {
    state.seek(plot.posToVal(event.offsetX - plot.bbox.left / (window.devicePixelRatio || 1), "x"));
  });
  place.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const step = event.shiftKey ? 1 : 0.1;
    if (event.key === "ArrowLeft") state.seek(state.t - step);
    else if (event.key === "ArrowRight") state.seek(state.t + step);
    else if (event.key === "+" || event.key === "=") zoom(2);
    else if (event.key === "-") zoom(0.5);
    else if (event.key === "0") show(trip.start, trip.end);
    else return;
    event.preventDefault();
  });
  new ResizeObserver(() => {
    const wide = place.clientWidth;
    if (wide > 0 && wide !== plot.width) plot.setSize({ width: wide, height: options.height });
    drawMessages();
    draw();
  }).observe(place);
  plot.setSize({ width: Math.max(place.clientWidth, 240), height: options.height });
  show(trip.at - SPAN_S / 2, trip.at + SPAN_S / 2);
  return { draw, zoom, whole: () => show(trip.start, trip.end), changeChannel };
};
