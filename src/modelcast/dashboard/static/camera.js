// Where the map looks: a middle in metres, pixels a metre; east is right, north is up.

const LEAST = 0.02;
const MOST = 60;

export class Camera {
  constructor() {
    this.east = 0;
    this.north = 0;
    this.scale = 3;
    this.width = 1;
    this.height = 1;
  }

  x(east) {
    return this.width / 2 + (east - this.east) * this.scale;
  }

  y(north) {
    return this.height / 2 - (north - this.north) * this.scale;
  }

  place(x, y) {
    return [this.east + (x - this.width / 2) / this.scale, this.north - (y - this.height / 2) / this.scale];
  }

  move(dx, dy) {
    this.east -= dx / this.scale;
    this.north += dy / this.scale;
  }

  /** Zoom by a factor round a point of the screen. */
  zoom(factor, x = this.width / 2, y = this.height / 2) {
    const [east, north] = this.place(x, y);
    this.scale = Math.min(MOST, Math.max(LEAST, this.scale * factor));
    const [east2, north2] = this.place(x, y);
    this.east += east - east2;
    this.north += north - north2;
  }

  /** Show all these places, [east, north] each. */
  fit(places) {
    if (!places.length) return;
    let [west, east, south, north] = [Infinity, -Infinity, Infinity, -Infinity];
    for (const [e, n] of places) {
      west = Math.min(west, e);
      east = Math.max(east, e);
      south = Math.min(south, n);
      north = Math.max(north, n);
    }
    this.east = (west + east) / 2;
    this.north = (south + north) / 2;
    const wide = Math.max(east - west, 40);
    const high = Math.max(north - south, 40);
    this.scale = Math.min(MOST, Math.max(LEAST, 0.88 * Math.min(this.width / wide, this.height / high)));
  }
}
