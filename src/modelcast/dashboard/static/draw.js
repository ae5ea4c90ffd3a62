// The map on its canvas: the road, then ellipses, paths, remotes, the host, labels, the scale.

const CHI_95 = Math.sqrt(5.991); // 95 % of a normal distribution in two dimensions
const FRESH_S = 1;
const STALE_S = 3;
const [PEDESTRIAN, CYCLIST, ROAD_WORKER, ROADSIDE] = [1, 2, 3, 4]; // modelcast.core.kinds.Kind
const DASHES = [[], [4, 2.5], [1.5, 3]];

/** Class of a remote's age: 0 fresh, 1 older, 2 stale. */
export function ageClass(silent) {
  return silent === null || silent > STALE_S ? 2 : silent > FRESH_S ? 1 : 0;
}

/** Where a remote is some time after its snapshot, along its predicted path. */
export function placeAt(remote, ahead, later) {
  let [t0, e0, n0] = [0, remote.east, remote.north];
  for (let k = 0; k < ahead.length; k++) {
    const [e1, n1] = remote.path[k];
    if (later <= ahead[k]) {
      const share = (later - t0) / (ahead[k] - t0);
      return [e0 + share * (e1 - e0), n0 + share * (n1 - n0)];
    }
    [t0, e0, n0] = [ahead[k], e1, n1];
  }
  return [e0, n0];
}

function arrow(pen, x, y, heading, size) {
  if (heading === null) {
    pen.moveTo(x + size * 0.7, y);
    pen.arc(x, y, size * 0.7, 0, 2 * Math.PI);
    return;
  }
  const [s, c] = [Math.sin(heading) * size, -Math.cos(heading) * size];
  pen.moveTo(x + s * 1.25, y + c * 1.25);
  pen.lineTo(x - s * 0.85 - c * 0.75, y - c * 0.85 + s * 0.75);
  pen.lineTo(x - s * 0.4, y - c * 0.4);
  pen.lineTo(x - s * 0.85 + c * 0.75, y - c * 0.85 - s * 0.75);
  pen.closePath();
}

/** A body by its kind: an arrow, a disc with a nose, a slim arrow on two wheels, a square. */
function body(pen, x, y, remote, size) {
  const heading = remote.heading ?? 0;
  const [s, c] = [Math.sin(heading), -Math.cos(heading)];
  if (remote.kind === PEDESTRIAN || remote.kind === ROAD_WORKER) {
    const r = size * 0.55;
    pen.moveTo(x + r, y);
    pen.arc(x, y, r, 0, 2 * Math.PI);
    if (remote.heading !== null) {
      pen.moveTo(x + s * r * 2, y + c * r * 2);
      pen.lineTo(x + c * r * 0.6 + s * r * 0.8, y - s * r * 0.6 + c * r * 0.8);
      pen.lineTo(x - c * r * 0.6 + s * r * 0.8, y + s * r * 0.6 + c * r * 0.8);
      pen.closePath();
    }
  } else if (remote.kind === CYCLIST) {
    const r = size * 0.42;
    for (const end of [-0.8, 0.8]) {
      const [wx, wy] = [x + s * size * end, y + c * size * end];
      pen.moveTo(wx + r, wy);
      pen.arc(wx, wy, r, 0, 2 * Math.PI);
    }
    const [w, l] = [size * 0.18, size * 0.8];
    pen.moveTo(x + s * l + c * w, y + c * l - s * w);
    pen.lineTo(x + s * l - c * w, y + c * l + s * w);
    pen.lineTo(x - s * l - c * w, y - c * l + s * w);
    pen.lineTo(x - s * l + c * w, y - c * l - s * w);
    pen.closePath();
  } else if (remote.kind === ROADSIDE) {
    pen.rect(x - size * 0.7, y - size * 0.7, size * 1.4, size * 1.4);
  } else {
    arrow(pen, x, y, remote.heading, size);
  }
}

function roadLines(pen, camera, lines, colours) {
  pen.strokeStyle = colours.road;
  pen.lineWidth = Math.max(2, Math.min(3.2 * camera.scale, 40));
  pen.lineCap = pen.lineJoin = "round";
  pen.beginPath();
  for (const line of lines) {
    pen.moveTo(camera.x(line[0]), camera.y(line[1]));
    for (let k = 2; k < line.length; k += 2) pen.lineTo(camera.x(line[k]), camera.y(line[k + 1]));
  }
  pen.stroke();
}

function groups(shown, colourOf) {
  const found = new Map();
  for (const one of shown) {
    const colour = colourOf(one.remote.model);
    const key = `${colour}${ageClass(one.remote.silent)}`;
    if (!found.has(key)) found.set(key, { colour, age: ageClass(one.remote.silent), items: [] });
    found.get(key).items.push(one);
  }
  return found.values();
}

function ellipsesOf(pen, camera, group) {
  pen.fillStyle = pen.strokeStyle = group.colour;
  pen.lineWidth = 1;
  for (const { remote, x, y } of group.items) {
    const a = Math.min(CHI_95 * remote.major * camera.scale, 4000);
    const b = Math.min(CHI_95 * remote.minor * camera.scale, 4000);
    if (a < 3) continue;
    pen.beginPath();
    pen.ellipse(x, y, a, Math.max(b, 0.5), -remote.angle, 0, 2 * Math.PI);
    pen.globalAlpha = 0.16;
    pen.fill();
    pen.globalAlpha = 0.8;
    pen.stroke();
  }
  pen.globalAlpha = 1;
}

function pathsOf(pen, camera, group) {
  pen.beginPath();
  for (const { remote, x, y } of group.items) {
    pen.moveTo(x, y);
    for (const [e, n] of remote.path) pen.lineTo(camera.x(e), camera.y(n));
  }
  pen.lineWidth = 2;
  pen.strokeStyle = group.colour;
  pen.stroke();
}

function bodiesOf(pen, group, size, colours) {
  pen.beginPath();
  for (const { remote, x, y } of group.items) body(pen, x, y, remote, size);
  pen.fillStyle = group.age === 2 ? colours.field : group.colour;
  pen.fill();
  pen.setLineDash(DASHES[group.age]);
  pen.lineWidth = group.age === 2 ? 1.8 : 1.2;
  pen.strokeStyle = group.age === 2 ? group.colour : colours.ink;
  pen.stroke();
  pen.setLineDash([]);
}

/** Labels that overlap no other: the chosen one and warned ones first, then the nearest to the middle. */
function labels(pen, camera, shown, state, colours) {
  const rank = (one) =>
    one.remote.id === state.chosen ? -2 : state.warned.has(one.remote.id) ? -1
      : Math.hypot(one.x - camera.width / 2, one.y - camera.height / 2);
  const order = shown.map((one) => [rank(one), one]).sort((a, b) => a[0] - b[0]).slice(0, 60);
  const bodies = shown.length > 60 ? [] : shown;
  const taken = [];
  pen.font = "12px system-ui, 'DejaVu Sans', sans-serif";
  pen.textBaseline = "middle";
  pen.lineWidth = 3;
  pen.lineJoin = "round";
  for (const [first, one] of order) {
    const text = String(one.remote.id);
    const wide = pen.measureText(text).width;
    const spots = [[11, -11], [11, 11], [-11 - wide, -11], [-11 - wide, 11]];
    for (const [dx, dy] of spots) {
      const box = [one.x + dx - 2, one.y + dy - 8, one.x + dx + wide + 2, one.y + dy + 8];
      const clash = (b) => box[0] < b[2] && b[0] < box[2] && box[1] < b[3] && b[1] < box[3];
      const covers = bodies.some((b) => b !== one && clash([b.x - 7, b.y - 7, b.x + 7, b.y + 7]));
      if ((covers || taken.some(clash)) && first >= 0) continue;
      taken.push(box);
      pen.strokeStyle = colours.field;
      pen.strokeText(text, one.x + dx, one.y + dy);
      pen.fillStyle = colours.ink;
      pen.fillText(text, one.x + dx, one.y + dy);
      break;
    }
  }
}

function scaleBar(pen, camera, colours) {
  const target = 110 / camera.scale;
  const power = 10 ** Math.floor(Math.log10(target));
  const length = power * (target / power >= 5 ? 5 : target / power >= 2 ? 2 : 1);
  const [x, y, wide] = [16, camera.height - 16, length * camera.scale];
  pen.strokeStyle = pen.fillStyle = colours.ink;
  pen.lineWidth = 2;
  pen.beginPath();
  pen.moveTo(x, y - 6);
  pen.lineTo(x, y);
  pen.lineTo(x + wide, y);
  pen.lineTo(x + wide, y - 6);
  pen.stroke();
  pen.font = "12px system-ui, 'DejaVu Sans', sans-serif";
  pen.textBaseline = "bottom";
  pen.fillText(length >= 1000 ? `${length / 1000} km` : `${length} m`, x + 6, y - 4);
}

function measureLine(pen, camera, points, colours) {
  if (!points.length) return;
  pen.strokeStyle = pen.fillStyle = colours.accent;
  pen.lineWidth = 2;
  pen.setLineDash([7, 4]);
  pen.beginPath();
  pen.moveTo(camera.x(points[0][0]), camera.y(points[0][1]));
  for (const [e, n] of points.slice(1)) pen.lineTo(camera.x(e), camera.y(n));
  pen.stroke();
  pen.setLineDash([]);
  for (const [e, n] of points) {
    pen.beginPath();
    pen.arc(camera.x(e), camera.y(n), 4, 0, 2 * Math.PI);
    pen.fill();
  }
}

/** Draw everything; returns what is on the screen, to be found again by a click. */
export function drawMap(pen, camera, state, colours, colourOf) {
  const { snapshot, later } = state;
  pen.fillStyle = colours.field;
  pen.fillRect(0, 0, camera.width, camera.height);
  roadLines(pen, camera, state.road, colours);
  const shown = [];
  if (snapshot) {
    for (const remote of snapshot.remotes) {
      const [east, north] = later ? placeAt(remote, snapshot.ahead, later) : [remote.east, remote.north];
      const [x, y] = [camera.x(east), camera.y(north)];
      if (x > -80 && y > -80 && x < camera.width + 80 && y < camera.height + 80) shown.push({ remote, x, y });
    }
    const size = Math.max(6, Math.min(2.4 * camera.scale, 12));
    const parts = [...groups(shown, colourOf)];
    for (const group of parts) ellipsesOf(pen, camera, group);
    for (const group of parts) pathsOf(pen, camera, group);
    for (const one of shown) {
      if (!state.warned.has(one.remote.id) && one.remote.id !== state.chosen) continue;
      pen.beginPath();
      pen.arc(one.x, one.y, size + 7, 0, 2 * Math.PI);
      pen.lineWidth = one.remote.id === state.chosen ? 3 : 2;
      pen.strokeStyle = state.warned.has(one.remote.id) ? colours.alarm : colours.accent;
      pen.stroke();
    }
    for (const group of parts) bodiesOf(pen, group, size, colours);
    if (snapshot.host) {
      const { host } = snapshot;
      const step = (host.speed ?? 0) * later;
      const x = camera.x(host.east + step * Math.sin(host.heading ?? 0));
      const y = camera.y(host.north + step * Math.cos(host.heading ?? 0));
      pen.beginPath();
      arrow(pen, x, y, host.heading, size * 1.25);
      pen.fillStyle = colours.host;
      pen.fill();
      pen.beginPath();
      pen.arc(x, y, size * 1.25 + 6, 0, 2 * Math.PI);
      pen.lineWidth = 1.5;
      pen.strokeStyle = colours.host;
      pen.stroke();
    }
    labels(pen, camera, shown, state, colours);
  }
  measureLine(pen, camera, state.measuring ?? [], colours);
  scaleBar(pen, camera, colours);
  return shown;
}
