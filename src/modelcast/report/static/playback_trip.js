// The trip that is played, read from the page: plain arrays, and what holds at an instant.

const summed = (steps, unit) => {
  let whole = 0;
  return steps.map((step) => (step === null ? null : (whole += step) * unit));
};

// Place of the last number that is at most t, or -1.
const lastAt = (sorted, t) => {
  let low = 0, high = sorted.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (sorted[middle] <= t) low = middle + 1; else high = middle;
  }
  return low - 1;
};

const readTrip = (given) => {
  const t = summed(given.t_ms, 1e-3), east = summed(given.east_cm, 1e-2), north = summed(given.north_cm, 1e-2);
  const begins = new Set(given.parts), afterLeftOut = new Set(given.after_left_out);
  // The truth at any time: between samples on the straight line, in a gap where it was last seen.
  const truthAt = (at_s) => {
    const at = Math.max(lastAt(t, at_s + 1e-6), 0), next = at + 1;
    if (next >= t.length || begins.has(next)) return [east[at], north[at]];
    const share = Math.min(Math.max((at_s - t[at]) / (t[next] - t[at]), 0), 1);
    return [east[at] + share * (east[next] - east[at]), north[at] + share * (north[next] - north[at])];
  };
  // The course, clockwise from north: towards a place a metre away, so that it holds through standstill.
  const courseAt = (at_s) => {
    const [e, n] = truthAt(at_s);
    const start = lastAt(t, at_s + 1e-6);
    for (let at = start + 1; at < t.length && !begins.has(at); at++)
      if (Math.hypot(east[at] - e, north[at] - n) > 1) return Math.atan2(east[at] - e, north[at] - n);
    for (let at = start; at >= 0; at--)
      if (Math.hypot(east[at] - e, north[at] - n) > 1) return Math.atan2(e - east[at], n - north[at]);
    return 0;
  };
  const readRun = (run) => {
    const offEast = summed(run.off_east_mm, 1e-3), offNorth = summed(run.off_north_mm, 1e-3);
    const error = offEast.map((one, at) => (one === null ? null : Math.hypot(one, offNorth[at])));
    const sent = summed(run.sent_ms, 1e-3), lost = [...run.lost].map((one) => one === "1");
    const heard = sent.filter((_, at) => !lost[at]);
    // Where the vehicle was at each message, and the direction across its course on the screen.
    const marks = sent.map((at_s) => {
      const course = courseAt(at_s);
      return { place: truthAt(at_s), across: [Math.cos(course), Math.sin(course)] };
    });
    return { offEast, offNorth, error, sent, lost, heard, marks, what: run.what, member: run.member };
  };
  const channels = given.channels.map((one) => ({ ratio: one.packet_error_ratio, runs: one.runs.map(readRun) }));
  // What a receiver holds at a time: where it believes the sender to be, by what, and how old that is.
  const beliefAt = (run, at_s) => {
    const at = Math.max(lastAt(t, at_s + 1e-6), 0);
    const [e, n] = truthAt(at_s);
    // Of samples that were left out no error is known, nor a place.
    const kept = !afterLeftOut.has(at + 1) || at_s < t[at] + given.step_ms * 1e-3 - 1e-6;
    const known = kept && run.error[at] !== null;
    const heard = lastAt(run.heard, at_s + 1e-6), sent = lastAt(run.sent, at_s + 1e-6);
    const last = heard < 0 ? -1 : lastAt(run.sent, run.heard[heard] + 1e-6);
    return {
      place: known ? [e + run.offEast[at], n + run.offNorth[at]] : null,
      error: known ? run.error[at] : null,
      member: last < 0 ? null : run.member[last],
      age: heard < 0 ? null : at_s - run.heard[heard],
      sent: sent + 1,
      lost: sent - heard,
    };
  };
  return {
    name: given.trip, threshold: given.threshold_m, at: given.at_s, senders: given.senders, channels, begins, afterLeftOut,
    t, east, north, start: t[0], end: t[t.length - 1], truthAt, courseAt, beliefAt,
  };
};
