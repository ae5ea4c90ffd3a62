// The figures beside the map. Text is set as text, never as markup.

const LEVELS = ["", "caution", "warning"];
const KINDS = { fcw: "Forward collision", eebl: "Brake light", ima: "Intersection", vru: "Vulnerable road user" };
const EVERY_MS = 200; // figures change no oftener: they are to be read
const SVG = "http://www.w3.org/2000/svg";

const shown = (value, digits, unit) => (value === null || value === undefined ? "unknown" : `${value.toFixed(digits)} ${unit}`);
const percent = (value) => (value === null || value === undefined ? "unknown" : `${(100 * value).toFixed(0)} %`);

/** Write rows into a list of terms; elements stay, so that nothing jumps. */
function facts(list, rows) {
  while (list.children.length > 2 * rows.length) list.lastChild.remove();
  while (list.children.length < 2 * rows.length) {
    list.append(document.createElement(list.children.length % 2 ? "dd" : "dt"));
  }
  rows.forEach(([term, value], k) => {
    const [dt, dd] = [list.children[2 * k], list.children[2 * k + 1]];
    if (dt.textContent !== term) dt.textContent = term;
    if (dd.textContent !== value) dd.textContent = value;
  });
}

export class Panels {
  constructor(find, colourOf) {
    this.find = find;
    this.colourOf = colourOf;
    this.lastMs = -1e9;
    this.said = new Set();
  }

  state(text, bad) {
    const place = this.find("state");
    place.textContent = text;
    place.dataset.bad = String(bad);
  }

  /** Show a snapshot; its figures at once where asked for, or where the last change is long enough ago. */
  show(snapshot, chosen, atOnce) {
    this.#warnings(snapshot);
    const now = performance.now();
    if (!atOnce && now - this.lastMs < EVERY_MS) return;
    this.lastMs = now;
    this.#counters(snapshot);
    this.#legend(snapshot);
    this.#facts(snapshot, chosen);
  }

  choose(snapshot, id) {
    this.find("chosen").hidden = id === null;
    this.find("chosen-none").hidden = id !== null;
    this.find("chosen-title").textContent = id === null ? "Remote" : `Remote ${id}`;
    const remote = snapshot?.byId.get(id);
    this.find("chosen-said").textContent = remote
      ? `Remote ${id}, ${remote.model}, ${shown(remote.speed, 1, "metres a second")}` : "No remote chosen";
    this.#facts(snapshot, id);
  }

  measured(points) {
    const place = this.find("measured");
    place.hidden = points === null;
    if (points === null) return;
    if (points.length < 2) {
      place.textContent = points.length ? "Choose the second point" : "Choose two points, by click or with Enter at the middle";
      return;
    }
    const [[e0, n0], [e1, n1]] = points;
    const far = Math.hypot(e1 - e0, n1 - n0);
    const bearing = ((Math.atan2(e1 - e0, n1 - n0) * 180) / Math.PI + 360) % 360;
    place.textContent = `${far.toFixed(far < 100 ? 2 : 0)} m, bearing ${bearing.toFixed(0)}°`;
  }

  #warnings(snapshot) {
    const list = this.find("warnings");
    const rows = snapshot.warnings.slice(0, 5).map((one) => ({
      level: String(one.level),
      text: `${KINDS[one.kind] ?? one.kind} ${LEVELS[one.level]}: remote ${one.id}, ${Math.max(0, snapshot.t - one.begun_s).toFixed(1)} s`,
    }));
    if (!rows.length) rows.push({ level: "0", text: "none" });
    if (snapshot.warnings.length > 5) rows.push({ level: "0", text: `and ${snapshot.warnings.length - 5} more` });
    while (list.children.length > rows.length) list.lastChild.remove();
    while (list.children.length < rows.length) list.append(document.createElement("li"));
    rows.forEach((row, k) => {
      const item = list.children[k];
      item.dataset.level = row.level;
      if (item.textContent !== row.text) item.textContent = row.text;
    });
    const urgent = snapshot.warnings.filter((one) => one.level > 1);
    const keys = new Set(urgent.map((one) => `${one.kind} ${one.id}`));
    const fresh = urgent.filter((one) => !this.said.has(`${one.kind} ${one.id}`));
    if (fresh.length) {
      this.find("announce").textContent = fresh
        .slice(0, 3)
        .map((one) => `${KINDS[one.kind] ?? one.kind} warning, remote ${one.id}`)
        .join(". ");
    }
    this.said = keys;
  }

  #counters(snapshot) {
    const { counters, host } = snapshot;
    const rate = (messages, bytes) =>
      messages === null ? "unknown" : `${messages.toFixed(1)} /s, ${bytes === null ? "?" : (bytes / 1000).toFixed(1)} kB/s`;
    facts(this.find("counters"), [
      ["Host", host ? `${host.id}, ${shown(host.speed, 1, "m/s")}` : "no place"],
      ["Inputs", host?.inputs || "unknown"],
      ["Remotes", String(snapshot.remotes.length)],
      ["In", rate(counters.received_per_s, counters.received_bytes_per_s)],
      ["Out", rate(counters.sent_per_s, counters.sent_bytes_per_s)],
      ["Lost", percent(counters.loss_ratio)],
      ["Channel load", percent(counters.channel_busy_ratio)],
    ]);
    const refused = Object.entries(counters.rejected);
    this.find("rejected-sum").textContent = String(refused.reduce((sum, [, count]) => sum + count, 0));
    facts(this.find("rejected").querySelector("dl"), refused.map(([reason, count]) => [reason, String(count)]));
  }

  #legend(snapshot) {
    const counts = new Map(snapshot.names.map((name) => [name, 0]));
    for (const one of snapshot.remotes) counts.set(one.model, (counts.get(one.model) ?? 0) + 1);
    const list = this.find("legend");
    const rows = [...counts];
    while (list.children.length > rows.length) list.lastChild.remove();
    while (list.children.length < rows.length) {
      const item = document.createElement("li");
      const mark = document.createElementNS(SVG, "svg");
      mark.setAttribute("viewBox", "0 0 16 16");
      mark.setAttribute("aria-hidden", "true");
      const dot = document.createElementNS(SVG, "circle");
      for (const [name, value] of [["cx", "8"], ["cy", "8"], ["r", "6.5"]]) dot.setAttribute(name, value);
      mark.append(dot);
      const count = document.createElement("span");
      count.className = "count";
      item.append(mark, document.createElement("span"), count);
      list.append(item);
    }
    rows.forEach(([name, count], k) => {
      const [mark, label, number] = list.children[k].children;
      mark.firstChild.setAttribute("fill", this.colourOf(name));
      label.textContent = name;
      number.textContent = String(count);
    });
  }

  #facts(snapshot, id) {
    if (id === null || !snapshot) return;
    const remote = snapshot.byId.get(id);
    const { host } = snapshot;
    facts(this.find("chosen-facts"), remote ? [
      ["Sub-model", remote.model],
      ["Speed", shown(remote.speed, 1, "m/s")],
      ["Distance", host ? shown(Math.hypot(remote.east - host.east, remote.north - host.north), 0, "m") : "unknown"],
      ["Last message", `${shown(remote.silent, 1, "s")} ago`],
      ["Ellipse (1 σ)", `${remote.major.toFixed(2)} × ${remote.minor.toFixed(2)} m`],
      ["Error", shown(remote.error, 2, "m")],
      ["Loss", percent(remote.loss)],
    ] : [["State", "no longer on the map"]]);
  }
}
