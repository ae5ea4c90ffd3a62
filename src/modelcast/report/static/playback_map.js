// The trip from above: the true path, the vehicle, where each receiver believes it to be, messages beside the path.

const CAR_M = [4.6, 1.8], FIRST_SIGHT_M = 40, TRAIL_S = 3, FRESH_S = 0.35, LANE_PX = 7, LANE_M = 1, SMALL_PX_PER_M = 1.5;
const INK = "#222222", PATH = "#9a9a9a", GRID = "#e6e6e6", SOFT = "#555555";

// A round number of metres at least so many.
const roundStep = (least) => {
  const power = 10 ** Math.floor(Math.log10(least));
  return [1, 2, 5, 10].map((one) => one * power).find((one) => one >= least * 0.999);
};

const makeMap = (canvas, trip, state) => {
  const context = canvas.getContext("2d");
  let scale = 1, centre = trip.truthAt(state.t), width = 0, height = 0;

  const toPixels = ([e, n]) => [width / 2 + (e - centre[0]) * scale, height / 2 - (n - centre[1]) * scale];
  const toMetres = (x, y) => [centre[0] + (x - width / 2) / scale, centre[1] - (y - height / 2) / scale];

  const resize = () => {
    const before = width ? Math.min(width, height) : 0;
    width = canvas.clientWidth;
    height = canvas.clientHeight;
    const ratio = window.devicePixelRatio || 1;
    canvas.width = Math.round(width * ratio);
    canvas.height = Math.round(height * ratio);
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    scale = before ? scale * Math.min(width, height) / before : Math.min(width, height) / FIRST_SIGHT_M;
  };

  const line = (points, colour, thickness) => {
    context.strokeStyle = colour;
    context.lineWidth = thickness;
    context.beginPath();
    points.forEach((one, at) => {
      if (one === null) return;
      const [x, y] = toPixels(one);
      if (at === 0 || points[at - 1] === null) context.moveTo(x, y); else context.lineTo(x, y);
    });
    context.stroke();
  };

  const drawGrid = () => {
    const step = roundStep(60 / scale);
    const [left, top] = toMetres(0, 0), [right, bottom] = toMetres(width, height);
    context.strokeStyle = GRID;
    context.lineWidth = 1;
    context.beginPath();
    for (let e = Math.ceil(left / step) * step; e < right; e += step) {
      const [x] = toPixels([e, 0]);
      context.moveTo(x, 0);
      context.lineTo(x, height);
    }
    for (let n = Math.ceil(bottom / step) * step; n < top; n += step) {
      const [, y] = toPixels([0, n]);
      context.moveTo(0, y);
      context.lineTo(width, y);
    }
    context.stroke();
    return step;
  };

  const drawScale = (step) => {
    const long = step * scale;
    context.fillStyle = "rgba(255, 255, 255, .85)";
    context.fillRect(8, height - 30, long + 56, 24);
    context.strokeStyle = context.fillStyle = INK;
    context.lineWidth = 2;
    context.beginPath();
    context.moveTo(12, height - 16);
    context.lineTo(12, height - 12);
    context.lineTo(12 + long, height - 12);
    context.lineTo(12 + long, height - 16);
    context.stroke();
    context.font = "12px system-ui, sans-serif";
    context.textAlign = "left";
    context.fillText(`${step} m`, 18 + long, height - 11);
  };

  // A sign beside the path for every message up to now, a lane a sender; hollow where it was lost.
  const drawMessages = () => {
    const runs = state.runs();
    // Seen from afar, where a lane of pixels would be a road of its own, the signs lie on the path.
    const lane = Math.min(LANE_PX, LANE_M * scale);
    context.lineWidth = 1.2;
    // The first sender is on top.
    for (let sender = runs.length - 1; sender >= 0; sender--) {
      const run = runs[sender], aside = (runs.length === 1 ? 1 : sender - (runs.length - 1) / 2) * lane;
      const filled = new Path2D(), hollow = new Path2D();
      for (let at = lastAt(run.sent, state.t + 1e-6); at >= 0; at--) {
        const { place, across } = run.marks[at];
        const [x, y] = toPixels(place);
        if (x < -20 || y < -20 || x > width + 20 || y > height + 20) continue;
        const fresh = state.t - run.sent[at] < FRESH_S, into = run.lost[at] ? hollow : filled;
        const left = x + aside * across[0], top = y + aside * across[1], wide = fresh ? 6 : 2.6;
        if (scale < SMALL_PX_PER_M && !fresh) into.rect(left - 1, top - 1, 2, 2);
        else {
          into.moveTo(left + wide, top);
          into.arc(left, top, wide, 0, 2 * Math.PI);
        }
      }
      context.strokeStyle = context.fillStyle = trip.senders[sender].colour;
      context.fill(filled);
      context.stroke(hollow);
    }
  };

  const vehicle = (place, filled, outlined) => {
    const [x, y] = toPixels(place);
    context.save();
    context.translate(x, y);
    context.rotate(trip.courseAt(state.t));
    const long = Math.max(CAR_M[0] * scale, 8), wide = Math.max(CAR_M[1] * scale, 5);
    context.fillStyle = filled;
    context.strokeStyle = outlined;
    context.lineWidth = 1.4;
    context.beginPath();
    context.rect(-wide / 2, -long / 2, wide, long);
    context.fill();
    context.stroke();
    context.restore();
  };

  // The signs of the senders differ in shape as well as in colour.
  const SHAPES = [
    (x, y) => context.arc(x, y, 4, 0, 2 * Math.PI),
    (x, y) => context.rect(x - 3.5, y - 3.5, 7, 7),
    (x, y) => {
      context.moveTo(x, y - 5);
      [[5, 0], [0, 5], [-5, 0]].forEach(([dx, dy]) => context.lineTo(x + dx, y + dy));
      context.closePath();
    },
  ];

  const drawBeliefs = () => {
    const truth = trip.truthAt(state.t), from = Math.max(lastAt(trip.t, state.t - TRAIL_S), 0);
    const to = lastAt(trip.t, state.t + 1e-6), runs = state.runs();
    // The first sender is on top.
    for (let sender = runs.length - 1; sender >= 0; sender--) {
      const run = runs[sender], colour = trip.senders[sender].colour, trail = [];
      for (let at = from; at <= to; at++) {
        if (trip.afterLeftOut.has(at)) trail.push(null);
        trail.push(run.error[at] === null ? null : [trip.east[at] + run.offEast[at], trip.north[at] + run.offNorth[at]]);
      }
      line(trail, colour, 1.2);
      const { place } = trip.beliefAt(run, state.t);
      if (place === null) continue;
      line([truth, place], colour, 1);
      vehicle(place, "rgba(255, 255, 255, 0)", colour);
      context.beginPath();
      SHAPES[sender % SHAPES.length](...toPixels(place));
      context.fillStyle = colour;
      context.fill();
      context.strokeStyle = "#ffffff";
      context.lineWidth = 1;
      context.stroke();
    }
  };

  const draw = () => {
    if (!width) return;
    if (state.follow) centre = trip.truthAt(state.t);
    context.clearRect(0, 0, width, height);
    const step = drawGrid();
    const path = [];
    for (let at = 0; at < trip.t.length; at++) {
      if (trip.begins.has(at)) path.push(null);
      path.push([trip.east[at], trip.north[at]]);
    }
    line(path, PATH, 2);
    drawMessages();
    vehicle(trip.truthAt(state.t), "rgba(34, 34, 34, .22)", "rgba(34, 34, 34, 0)");
    drawBeliefs();
    if (state.pointed !== null) {
      const [x, y] = toPixels(trip.truthAt(state.pointed));
      context.beginPath();
      context.arc(x, y, 9, 0, 2 * Math.PI);
      context.strokeStyle = SOFT;
      context.lineWidth = 1.5;
      context.stroke();
    }
    drawScale(step);
  };

  const zoom = (factor, x = width / 2, y = height / 2) => {
    const held = toMetres(x, y), most = Math.min(width, height);
    scale = Math.min(Math.max(scale * factor, most / 50_000), most / 2);
    if (!state.follow) centre = [held[0] - (x - width / 2) / scale, held[1] + (y - height / 2) / scale];
    state.changed();
  };

  const move = (dx, dy) => {
    state.setFollow(false);
    centre = [centre[0] - dx / scale, centre[1] + dy / scale];
    state.changed();
  };

  const whole = () => {
    const span = (values) => values.reduce(([low, high], one) => [Math.min(low, one), Math.max(high, one)], [Infinity, -Infinity]);
    const [west, eastmost] = span(trip.east), [south, northmost] = span(trip.north);
    state.setFollow(false);
    centre = [(west + eastmost) / 2, (south + northmost) / 2];
    scale = 0.9 * Math.min(width / Math.max(eastmost - west, 10), height / Math.max(northmost - south, 10));
    state.changed();
  };

  // The instant at which the vehicle came nearest to a place on the screen; null farther than 14 pixels away.
  const instantAt = (x, y) => {
    let best = null, nearest = 14;
    for (let at = 0; at < trip.t.length; at++) {
      const [px, py] = toPixels([trip.east[at], trip.north[at]]);
      const far = Math.hypot(px - x, py - y);
      if (far < nearest) [best, nearest] = [trip.t[at], far];
    }
    return best;
  };

  const held = new Map();
  const placeOf = (event) => [event.offsetX, event.offsetY];
  canvas.addEventListener("pointerdown", (event) => {
    held.set(event.pointerId, { at: placeOf(event), moved: false });
    canvas.setPointerCapture(event.pointerId);
  });
  canvas.addEventListener("pointermove", (event) => {
    const one = held.get(event.pointerId), [x, y] = placeOf(event);
    if (!one) return state.point(instantAt(x, y));
    const dx = x - one.at[0], dy = y - one.at[1];
    if (!one.moved && Math.hypot(dx, dy) < 4) return undefined;
    if (held.size === 2) {
      const other = [...held.values()].find((item) => item !== one);
      const before = Math.hypot(one.at[0] - other.at[0], one.at[1] - other.at[1]);
      const after = Math.hypot(x - other.at[0], y - other.at[1]);
      if (before > 0) zoom(after / before, (x + other.at[0]) / 2, (y + other.at[1]) / 2);
    } else move(dx, dy);
    one.at = [x, y];
    one.moved = true;
    return undefined;
  });
  const release = (event) => {
    const one = held.get(event.pointerId);
    held.delete(event.pointerId);
    if (!one || one.moved || event.type !== "pointerup") return;
    const at = instantAt(...placeOf(event));
    if (at !== null) state.seek(at);
  };
  canvas.addEventListener("pointerup", release);
  canvas.addEventListener("pointercancel", release);
  canvas.addEventListener("pointerleave", () => state.point(null));
  // The wheel scrolls the page unless the map was chosen, by click or Tab, or Ctrl is held.
  canvas.addEventListener("wheel", (event) => {
    if (!event.ctrlKey && document.activeElement !== canvas) return;
    event.preventDefault();
    zoom(Math.exp(-event.deltaY * (event.deltaMode ? 0.05 : 0.0015)), ...placeOf(event));
  }, { passive: false });
  const STEPS = { ArrowLeft: [40, 0], ArrowRight: [-40, 0], ArrowUp: [0, 40], ArrowDown: [0, -40] };
  canvas.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (STEPS[event.key]) move(...STEPS[event.key]);
    else if (event.key === "+" || event.key === "=") zoom(1.4);
    else if (event.key === "-") zoom(1 / 1.4);
    else if (event.key === "0") whole();
    else return;
    event.preventDefault();
  });
  resize();
  new ResizeObserver(() => { resize(); draw(); }).observe(canvas);
  return { draw, zoom, whole };
};
