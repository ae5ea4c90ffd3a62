// The socket: opens again by itself, and hands on what comes by its kind.

const LEAST_WAIT_MS = 500;
const MOST_WAIT_MS = 5000;
const HALF_MS = 0.0005; // times are whole milliseconds: what rounding took away does not choose the one before
const SNAPSHOT = /^\{"kind":"snapshot","t_s":(-?[0-9.]+),/;

export function connect(listener) {
  let socket = null;
  let waitMs = LEAST_WAIT_MS;
  let pending = null; // one request at a time; the newest waits
  let waiting = false;

  function open() {
    const scheme = location.protocol === "https:" ? "wss" : "ws";
    socket = new WebSocket(`${scheme}://${location.host}/watch`);
    socket.addEventListener("message", ({ data }) => {
      waitMs = LEAST_WAIT_MS;
      const found = SNAPSHOT.exec(data);
      if (found) {
        waiting = false;
        listener.snapshot(Number(found[1]), data);
        if (pending !== null) {
          const t = pending;
          pending = null;
          ask(t);
        }
        return;
      }
      const given = JSON.parse(data);
      if (given.kind === "hello") listener.hello(given);
      else if (given.kind === "road") listener.road(given.lines_dm.map((line) => line.map((one) => one / 10)));
      else if (given.kind === "fault") {
        waiting = false;
        listener.fault(given.text);
      }
    });
    socket.addEventListener("close", () => {
      waiting = false;
      listener.lost();
      setTimeout(open, waitMs);
      waitMs = Math.min(2 * waitMs, MOST_WAIT_MS);
    });
  }

  function ask(t) {
    if (waiting) {
      pending = t;
      return;
    }
    if (socket.readyState !== WebSocket.OPEN) return;
    waiting = true;
    socket.send(JSON.stringify({ at_s: t + HALF_MS }));
  }

  open();
  return { ask };
}
