// What came: snapshots, kept as texts of a bounded size, and the one that is shown.

const MOST_SNAPSHOTS = 1200;
const MOST_CHARACTERS = 32 * 1024 * 1024;

/** A snapshot whose columns are in metres, seconds and radians. */
export function readSnapshot(text) {
  const given = JSON.parse(text);
  const columns = given.remotes;
  const count = columns.id.length;
  const remotes = [];
  for (let k = 0; k < count; k++) {
    const part = (name, scale) => (columns[name][k] === null ? null : columns[name][k] / scale);
    const east = columns.east_cm[k] / 100;
    const north = columns.north_cm[k] / 100;
    remotes.push({
      id: columns.id[k],
      east,
      north,
      heading: part("heading_mrad", 1000),
      speed: part("speed_cmps", 100),
      major: columns.major_cm[k] / 100,
      minor: columns.minor_cm[k] / 100,
      angle: (columns.angle_mrad[k] ?? 0) / 1000,
      path: columns.path_cm[k].map(([e, n]) => [east + e / 100, north + n / 100]),
      model: columns.names[columns.model[k]],
      age: part("age_ms", 1000),
      silent: part("silent_ms", 1000),
      messages: columns.messages[k],
      loss: part("loss_permille", 1000),
      error: part("error_mm", 1000),
      kind: columns.kind ? columns.kind[k] : 0,
    });
  }
  const host = given.host && {
    id: given.host.id,
    east: given.host.east_cm / 100,
    north: given.host.north_cm / 100,
    heading: given.host.heading_mrad === null ? null : given.host.heading_mrad / 1000,
    speed: given.host.speed_cmps === null ? null : given.host.speed_cmps / 100,
    inputs: given.host.inputs,
  };
  return {
    t: given.t_s,
    host,
    remotes,
    byId: new Map(remotes.map((one) => [one.id, one])),
    ahead: columns.ahead_ms.map((one) => one / 1000),
    names: columns.names,
    warnings: given.warnings,
    counters: given.counters,
  };
}

/** Texts of the last snapshots by time, no more than a bound holds. */
export class History {
  constructor() {
    this.items = [];
    this.characters = 0;
  }

  /** Keep a text; time that goes back begins anew, and what is too old for the bounds goes. */
  add(t, text) {
    if (this.items.length && t === this.items[this.items.length - 1].t) return;
    if (this.items.length && t <= this.items[this.items.length - 1].t) {
      this.items = [];
      this.characters = 0;
    }
    this.items.push({ t, text });
    this.characters += text.length;
    let gone = 0;
    while (this.items.length - gone > MOST_SNAPSHOTS || this.characters > MOST_CHARACTERS) {
      this.characters -= this.items[gone].text.length;
      gone += 1;
    }
    if (gone) this.items.splice(0, gone);
  }

  /** The text that is no later than a time, or the first. */
  at(t) {
    let low = 0;
    let high = this.items.length;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.items[middle].t <= t + 1e-6) low = middle + 1;
      else high = middle;
    }
    return this.items[Math.max(low - 1, 0)];
  }
}
