// Plays a trip: one time for map, errors, messages and figures; nothing moves before it is asked to.

const STILL_STEP_S = 0.5;

const startPlayback = () => {
  const section = document.getElementById("playback");
  if (!section) return;
  const part = (name) => document.getElementById(`playback-${name}`);
  const trip = readTrip(JSON.parse(part("data").textContent));
  const still = window.matchMedia("(prefers-reduced-motion: reduce)");
  let channel = Number(part("channel").value), waiting = false, before = null, owed = 0;
  section.hidden = false;

  const state = {
    t: Math.min(Math.max(trip.at - 2, trip.start), trip.end),
    follow: true,
    playing: false,
    pointed: null,
    runs: () => trip.channels[channel].runs,
    changed: () => {
      if (waiting) return;
      waiting = true;
      requestAnimationFrame(show);
    },
    seek: (t) => {
      state.t = Math.min(Math.max(t, trip.start), trip.end);
      state.changed();
    },
    point: (t) => {
      if (t === state.pointed) return;
      state.pointed = t;
      state.changed();
    },
    setFollow: (follow) => {
      state.follow = follow;
      part("follow").setAttribute("aria-pressed", String(follow));
    },
  };

  // Figures of every receiver at the time pointed at, else at the time played.
  const cells = trip.senders.map((sender, at) => {
    const row = part("figures").tBodies[0].rows[at];
    row.cells[0].querySelector("i").style.background = sender.colour;
    return [...row.cells].slice(1);
  });
  const tell = () => {
    const t = state.pointed === null ? state.t : state.pointed;
    part("when").textContent = `${state.pointed === null ? "At" : "Pointed at:"} ${t.toFixed(1)} s`;
    state.runs().forEach((run, at) => {
      const held = trip.beliefAt(run, t), cell = cells[at];
      cell[0].textContent = held.error === null ? "–" : `${held.error.toFixed(2)} m`;
      cell[1].textContent = held.age === null ? "–" : `${held.age.toFixed(1)} s ago`;
      cell[2].textContent = held.member === null ? "–" : trip.senders[at].members[held.member];
      cell[3].textContent = String(held.sent);
      cell[4].textContent = String(held.lost);
    });
  };

  const map = makeMap(part("map"), trip, state);
  const timeline = makeTimeline(part("timeline"), trip, state);
  const slider = part("time"), play = part("play");
  slider.min = trip.start;
  slider.max = trip.end;

  function show() {
    waiting = false;
    map.draw();
    timeline.draw();
    tell();
    slider.value = state.t;
    slider.setAttribute("aria-valuetext", `${state.t.toFixed(1)} seconds`);
    part("now").textContent = `${state.t.toFixed(1)} s`;
  }

  const setPlaying = (playing) => {
    state.playing = playing;
    play.textContent = playing ? "Pause" : "Play";
    if (!playing) return;
    if (state.t >= trip.end) state.t = trip.start;
    before = null;
    owed = 0;
    requestAnimationFrame(step);
  };
  const step = (now) => {
    if (!state.playing) return;
    if (before !== null) owed += (now - before) / 1000 * Number(part("speed").value);
    before = now;
    // Who prefers stillness gets a picture now and then in place of one that glides.
    if (owed >= (still.matches ? STILL_STEP_S * Math.max(Number(part("speed").value), 1) : 0)) {
      state.seek(state.t + owed);
      owed = 0;
    }
    if (state.t >= trip.end) setPlaying(false); else requestAnimationFrame(step);
  };

  play.addEventListener("click", () => setPlaying(!state.playing));
  slider.addEventListener("input", () => state.seek(Number(slider.value)));
  part("channel").addEventListener("change", (event) => {
    channel = Number(event.target.value);
    timeline.changeChannel();
    state.changed();
  });
  part("follow").addEventListener("click", () => { state.setFollow(!state.follow); state.changed(); });
  part("map-in").addEventListener("click", () => map.zoom(1.6));
  part("map-out").addEventListener("click", () => map.zoom(1 / 1.6));
  part("map-all").addEventListener("click", () => map.whole());
  part("time-in").addEventListener("click", () => timeline.zoom(2));
  part("time-out").addEventListener("click", () => timeline.zoom(0.5));
  part("time-all").addEventListener("click", () => timeline.whole());
  section.addEventListener("keydown", (event) => {
    if (event.key !== " " || ["BUTTON", "SELECT"].includes(event.target.tagName)) return;
    event.preventDefault();
    setPlaying(!state.playing);
  });
  state.changed();
};

startPlayback();
