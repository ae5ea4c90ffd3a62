// The series of the remote that is chosen: small charts over the last minute.

export const SPAN_S = 60;
const APART_S = 2; // what was not seen in between is not drawn: a log that was wound on says nothing of it
const CHARTS = [
  { key: "error", name: "Error", unit: "m", digits: 2 },
  { key: "age", name: "Age of the model", unit: "s", digits: 1 },
  { key: "silent", name: "Silence", unit: "s", digits: 1 },
  { key: "messages", name: "Messages", unit: "", digits: 0 },
  { key: "loss", name: "Loss", unit: "%", digits: 0, scale: 100 },
  { key: "model", name: "Sub-model", unit: "" },
];

export class Series {
  constructor(place, colours, colourOf) {
    this.colours = colours;
    this.colourOf = colourOf;
    this.rows = [];
    this.charts = CHARTS.map((chart) => {
      const figure = document.createElement("figure");
      const caption = document.createElement("figcaption");
      const name = document.createElement("span");
      const value = document.createElement("b");
      const canvas = document.createElement("canvas");
      name.textContent = chart.name;
      canvas.setAttribute("role", "img");
      canvas.setAttribute("aria-label", chart.name);
      caption.append(name, value);
      figure.append(caption, canvas);
      place.append(figure);
      return { ...chart, figure, value, canvas };
    });
  }

  /** Begin anew, with what is known of the remote's past. */
  restart(rows) {
    this.rows = rows;
  }

  /** Add what a snapshot says of the remote; time that goes back begins anew. */
  add(t, remote) {
    if (this.rows.length && t <= this.rows[this.rows.length - 1].t) this.rows = [];
    this.rows.push({ ...remote, t });
    while (this.rows.length && this.rows[0].t < t - SPAN_S) this.rows.shift();
  }

  draw() {
    if (!this.rows.length) return;
    for (const chart of this.charts) {
      const values = this.rows.map((row) => row[chart.key]);
      const known = values.filter((value) => value !== null && value !== undefined);
      chart.figure.hidden = known.length === 0;
      if (!known.length) continue;
      const last = values[values.length - 1];
      const text = last === null ? "unknown"
        : chart.key === "model" ? last : `${(last * (chart.scale ?? 1)).toFixed(chart.digits)} ${chart.unit}`;
      chart.value.textContent = text;
      chart.canvas.setAttribute("aria-label", `${chart.name} over the last minute; now ${text}`);
      this.#plot(chart, values);
    }
  }

  #plot(chart, values) {
    const { canvas } = chart;
    const ratio = window.devicePixelRatio || 1;
    const [wide, high] = [canvas.clientWidth, canvas.clientHeight];
    if (canvas.width !== Math.round(wide * ratio) || canvas.height !== Math.round(high * ratio)) {
      canvas.width = Math.round(wide * ratio);
      canvas.height = Math.round(high * ratio);
    }
    const pen = canvas.getContext("2d");
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    pen.clearRect(0, 0, wide, high);
    const end = this.rows[this.rows.length - 1].t;
    const x = (t) => wide - ((end - t) / SPAN_S) * wide;
    const colours = this.colours();
    if (chart.key === "model") {
      for (let k = 0; k < values.length; k++) {
        const from = x(this.rows[k].t);
        const to = k + 1 < values.length ? x(Math.min(this.rows[k + 1].t, this.rows[k].t + APART_S)) : wide;
        pen.fillStyle = this.colourOf(values[k]);
        pen.fillRect(from, 14, Math.max(to - from, 1.5) + 0.5, 16);
      }
      return;
    }
    const numbers = values.filter((value) => value !== null);
    const top = Math.max(...numbers, 1e-9);
    const low = chart.key === "messages" ? Math.min(...numbers) : 0;
    const y = (value) => high - 4 - ((value - low) / Math.max(top - low, 1e-9)) * (high - 12);
    pen.strokeStyle = colours.rule;
    pen.beginPath();
    pen.moveTo(0, high - 3.5);
    pen.lineTo(wide, high - 3.5);
    pen.stroke();
    pen.strokeStyle = colours.accent;
    pen.lineWidth = 1.6;
    pen.beginPath();
    pen.lineCap = "round";
    let open = false;
    for (let k = 0; k < values.length; k++) {
      const [place, height] = [x(this.rows[k].t), y(values[k])];
      open = open && values[k] !== null && this.rows[k].t - this.rows[k - 1].t <= APART_S;
      if (!open && values[k] !== null) pen.moveTo(place, height);
      if (values[k] !== null) pen.lineTo(place, height);
      open = values[k] !== null;
    }
    pen.stroke();
    pen.fillStyle = colours.soft;
    pen.font = "11px system-ui, 'DejaVu Sans', sans-serif";
    pen.textBaseline = "top";
    pen.fillText(`${(top * (chart.scale ?? 1)).toFixed(chart.digits)}`, 2, 0);
  }
}
