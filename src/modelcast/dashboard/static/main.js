// The page: brings the socket, the camera, the drawing and the panels together.

import { Camera } from "./camera.js";
import { connect } from "./connection.js";
import { drawMap, placeAt } from "./draw.js";
import { Panels } from "./panels.js";
import { pointers } from "./pointers.js";
import { Series, SPAN_S } from "./series.js";
import { History, readSnapshot } from "./snapshots.js";

const MOST_READ = 300; // snapshots of the past that are read again when a remote is chosen: more would be felt
const MOST_AHEAD_S = 0.5; // drawn on along the predicted path for no longer than this, where nothing new comes
const FIRST_SIGHT_M = 360; // across the map at first, round the host
const PALETTE = ["--m0", "--m1", "--m2", "--m3", "--m4", "--m5", "--m6", "--m7"];
const find = (id) => document.getElementById(id);

const canvas = find("map");
// Drawn by the processor: benchmarks/page_frames.py has what that gives where the graphics processor is simulated.
const pen = canvas.getContext("2d", { alpha: false, willReadFrequently: true });
const camera = new Camera();
const history = new History();
const modelPlaces = new Map();
let colours = {};

const state = {
  snapshot: null,
  arrivedMs: 0,
  later: 0,
  road: [],
  chosen: null,
  warned: new Set(),
  measuring: null,
  follow: true,
  paused: false,
  span: null,
  newestT: null,
  drawn: [],
  fitted: false,
  dirty: true,
};

function readColours() {
  const style = getComputedStyle(document.documentElement);
  const one = (name) => style.getPropertyValue(name).trim();
  colours = Object.fromEntries(
    ["paper", "field", "ink", "soft", "rule", "road", "host", "alarm", "accent"].map((name) => [name, one(`--${name}`)]),
  );
  colours.models = PALETTE.map(one);
  state.dirty = true;
}

function colourOf(model) {
  if (!modelPlaces.has(model)) modelPlaces.set(model, modelPlaces.size % PALETTE.length);
  return colours.models[modelPlaces.get(model)];
}

const series = new Series(find("series"), () => colours, colourOf);
const panels = new Panels(find, colourOf);

function show(text, parsed = null) {
  const snapshot = parsed ?? readSnapshot(text);
  state.snapshot = snapshot;
  state.arrivedMs = performance.now();
  for (const name of snapshot.names) colourOf(name);
  state.warned = new Set(snapshot.warnings.map((one) => one.id));
  const chosen = snapshot.byId.get(state.chosen);
  if (chosen) series.add(snapshot.t, chosen);
  panels.show(snapshot, state.chosen, state.paused);
  if (!state.fitted && snapshot.remotes.length) {
    state.fitted = true;
    if (snapshot.host) camera.scale = Math.min(camera.width, camera.height) / FIRST_SIGHT_M;
    else fit();
  }
  timeline();
  state.dirty = true;
}

function timeline() {
  const scrub = find("scrub");
  const items = history.items;
  const [first, last] = state.span ? state.span : items.length ? [items[0].t, items[items.length - 1].t] : [0, 0];
  scrub.min = first;
  scrub.max = Math.max(last, first);
  scrub.step = state.span ? Math.max(state.span[2], 0.001) : 0.1;
  const t = state.snapshot ? state.snapshot.t : 0;
  if (document.activeElement !== scrub || !state.paused) scrub.value = t;
  scrub.setAttribute("aria-valuetext", `${t.toFixed(1)} seconds`);
  find("time").textContent = `${t.toFixed(1)} s`;
  find("live").hidden = Boolean(state.span) || !state.paused;
}

function pause(paused) {
  state.paused = paused;
  const button = find("pause");
  button.setAttribute("aria-pressed", String(paused));
  button.textContent = paused ? (state.span ? "Play" : "Go on") : "Pause";
  if (paused && state.snapshot) panels.show(state.snapshot, state.chosen, true);
  if (!paused && !state.span && history.items.length) show(history.items[history.items.length - 1].text);
  panels.state(paused ? "paused" : state.span ? "playing" : "live", false);
  timeline();
}

function goTo(t) {
  if (!state.paused) pause(true);
  if (state.span) {
    const [first, last] = state.span;
    socket.ask(Math.min(Math.max(t, first), last));
  } else if (history.items.length) show(history.at(t).text);
}

function step(way) {
  const by = state.span ? state.span[2] : 0.1;
  if (state.snapshot) goTo(state.snapshot.t + way * by);
}

function fit() {
  const places = [];
  if (state.snapshot) {
    for (const one of state.snapshot.remotes) places.push([one.east, one.north]);
    if (state.snapshot.host) places.push([state.snapshot.host.east, state.snapshot.host.north]);
  }
  setFollow(false);
  camera.fit(places);
}

function setFollow(follow) {
  state.follow = follow;
  find("follow").setAttribute("aria-pressed", String(follow));
  state.dirty = true;
}

function choose(id) {
  state.chosen = id;
  const rows = [];
  if (id !== null) {
    const now = state.snapshot ? state.snapshot.t : Infinity;
    const recent = history.items.filter((item) => item.t <= now && item.t >= now - SPAN_S);
    const every = Math.ceil(recent.length / MOST_READ);
    recent.reverse().forEach((item, place) => {
      const past = place % every ? null : readSnapshot(item.text).byId.get(id);
      if (past) rows.unshift({ ...past, t: item.t });
    });
  }
  series.restart(rows);
  panels.choose(state.snapshot, id);
  state.dirty = true;
}

/** The next remote by distance from the host, or from the middle of the map. */
function chooseNext(way) {
  if (!state.snapshot?.remotes.length) return;
  const from = state.snapshot.host ?? camera;
  const order = [...state.snapshot.remotes].sort(
    (a, b) => Math.hypot(a.east - from.east, a.north - from.north) - Math.hypot(b.east - from.east, b.north - from.north),
  );
  const at = order.findIndex((one) => one.id === state.chosen);
  const next = at < 0 ? (way > 0 ? 0 : order.length - 1) : (at + way + order.length) % order.length;
  choose(order[next].id);
}

function measure(on) {
  state.measuring = on ? [] : null;
  find("measure").setAttribute("aria-pressed", String(on));
  canvas.style.cursor = on ? "crosshair" : "";
  panels.measured(state.measuring);
  state.dirty = true;
}

function tap(x, y) {
  const place = camera.place(x, y);
  if (state.measuring) {
    state.measuring = state.measuring.length >= 2 ? [place] : [...state.measuring, place];
    panels.measured(state.measuring);
    state.dirty = true;
    return;
  }
  let best = null;
  for (const one of state.drawn) {
    const far = Math.hypot(one.x - x, one.y - y);
    if (far < 24 && (!best || far < best.far)) best = { far, id: one.remote.id };
  }
  choose(best ? best.id : null);
}

function setNight(night) {
  document.documentElement.dataset.night = String(night);
  find("night").setAttribute("aria-pressed", String(night));
  readColours();
}

function help() {
  const keys = find("keys");
  keys.hidden = !keys.hidden;
  find("help").setAttribute("aria-expanded", String(!keys.hidden));
  if (!keys.hidden) keys.scrollIntoView({ block: "nearest" });
}

function moveBy(dx, dy) {
  setFollow(false);
  camera.move(dx, dy);
  state.dirty = true;
}

function zoomBy(factor, x, y) {
  camera.zoom(factor, state.follow ? undefined : x, state.follow ? undefined : y);
  state.dirty = true;
}

const KEYS = {
  " ": () => pause(!state.paused),
  "[": () => step(-1),
  "]": () => step(1),
  l: () => pause(false),
  n: () => chooseNext(1),
  p: () => chooseNext(-1),
  f: () => setFollow(!state.follow),
  m: () => measure(!state.measuring),
  d: () => setNight(document.documentElement.dataset.night !== "true"),
  "0": fit,
  "+": () => zoomBy(1.25),
  "=": () => zoomBy(1.25),
  "-": () => zoomBy(0.8),
  "?": help,
  Escape: () => (state.measuring ? measure(false) : choose(null)),
};
const MAP_KEYS = {
  ArrowLeft: () => moveBy(60, 0),
  ArrowRight: () => moveBy(-60, 0),
  ArrowUp: () => moveBy(0, 60),
  ArrowDown: () => moveBy(0, -60),
  Enter: () => tap(camera.width / 2, camera.height / 2),
};

document.addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.metaKey || event.altKey) return;
  const focus = document.activeElement;
  if (focus?.matches("button, summary") && (event.key === " " || event.key === "Enter")) return;
  const name = event.key.length === 1 ? event.key.toLowerCase() : event.key;
  const action = KEYS[name] ?? (focus === canvas ? MAP_KEYS[name] : undefined);
  if (!action) return;
  event.preventDefault();
  action();
});

find("pause").addEventListener("click", KEYS[" "]);
find("follow").addEventListener("click", KEYS.f);
find("measure").addEventListener("click", KEYS.m);
find("night").addEventListener("click", KEYS.d);
find("help").addEventListener("click", help);
find("zoom-in").addEventListener("click", KEYS["+"]);
find("zoom-out").addEventListener("click", KEYS["-"]);
find("fit").addEventListener("click", fit);
find("live").addEventListener("click", () => pause(false));
find("let-go").addEventListener("click", () => choose(null));
find("scrub").addEventListener("input", (event) => goTo(Number(event.target.value)));
pointers(canvas, { tap, moveBy, zoomBy });

const dark = matchMedia("(prefers-color-scheme: dark)");
dark.addEventListener("change", () => setNight(dark.matches));
setNight(dark.matches);

function resize() {
  const ratio = Math.min(window.devicePixelRatio || 1, 2);
  camera.width = canvas.clientWidth;
  camera.height = canvas.clientHeight;
  canvas.width = Math.round(camera.width * ratio);
  canvas.height = Math.round(camera.height * ratio);
  pen.setTransform(ratio, 0, 0, ratio, 0, 0);
  state.dirty = true;
}
resize(); // now: the first snapshot may come before the observer is asked
new ResizeObserver(resize).observe(canvas);

const socket = connect({
  hello(given) {
    find("source").textContent = given.name;
    state.span = given.span_s;
    panels.state(state.span ? "playing" : "live", false);
    timeline();
  },
  road(lines) {
    state.road = lines;
    state.dirty = true;
  },
  snapshot(t, text) {
    history.add(t, text);
    if (!state.paused || state.span) show(text);
    else timeline();
  },
  fault(text) {
    pause(true);
    panels.state(text, true);
  },
  lost() {
    panels.state("connection lost; trying again", true);
  },
});

let playedMs = 0;

/** A log plays by itself: the page asks for the next snapshot when its time has come. */
function play(nowMs) {
  if (!state.span || state.paused || !state.snapshot) return;
  const [, last, by] = state.span;
  if (nowMs - playedMs < by * 1000) return;
  const passed = Math.min((nowMs - playedMs) / 1000, 4 * by);
  playedMs = nowMs;
  if (state.snapshot.t >= last - 1e-9) pause(true);
  else socket.ask(Math.min(state.snapshot.t + Math.max(passed, by), last));
}

function frame(nowMs) {
  play(nowMs);
  const moving = state.snapshot && !state.paused;
  state.later = moving ? Math.min((nowMs - state.arrivedMs) / 1000, MOST_AHEAD_S) : 0;
  if (state.follow && state.snapshot) {
    const chosen = state.snapshot.byId.get(state.chosen);
    const { host } = state.snapshot;
    if (chosen) [camera.east, camera.north] = placeAt(chosen, state.snapshot.ahead, state.later);
    else if (host) {
      const way = (host.speed ?? 0) * state.later;
      camera.east = host.east + way * Math.sin(host.heading ?? 0);
      camera.north = host.north + way * Math.cos(host.heading ?? 0);
    }
  }
  if (state.dirty || moving) {
    state.drawn = drawMap(pen, camera, state, colours, colourOf);
    if (state.dirty && state.chosen !== null) series.draw();
    state.dirty = false;
    document.documentElement.dataset.frames = String(Number(document.documentElement.dataset.frames ?? 0) + 1);
  }
  requestAnimationFrame(frame);
}
requestAnimationFrame(frame);
