// Mouse and touch on the map: drag moves, wheel and pinch zoom, a short press chooses.

const STILL_PX = 6;

export function pointers(canvas, { tap, moveBy, zoomBy }) {
  const down = new Map();
  let moved = false;
  const at = (event) => {
    const box = canvas.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  };

  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    const place = at(event);
    down.set(event.pointerId, { place, first: place });
    if (down.size === 1) moved = false;
  });

  canvas.addEventListener("pointermove", (event) => {
    const held = down.get(event.pointerId);
    if (!held) return;
    const place = at(event);
    const [dx, dy] = [place[0] - held.place[0], place[1] - held.place[1]];
    if (down.size === 1) {
      moved ||= Math.hypot(place[0] - held.first[0], place[1] - held.first[1]) > STILL_PX;
      if (moved) moveBy(dx, dy);
    } else {
      moved = true;
      const [other] = [...down.entries()].filter(([id]) => id !== event.pointerId).map(([, one]) => one.place);
      const before = Math.hypot(held.place[0] - other[0], held.place[1] - other[1]);
      const after = Math.hypot(place[0] - other[0], place[1] - other[1]);
      const middle = [(place[0] + other[0]) / 2, (place[1] + other[1]) / 2];
      if (before > 1 && after > 1) zoomBy(after / before, ...middle);
      moveBy(dx / 2, dy / 2);
    }
    if (moved) held.place = place;
  });

  const up = (event) => {
    const held = down.get(event.pointerId);
    down.delete(event.pointerId);
    if (held && !moved && event.type === "pointerup") tap(...at(event));
  };
  canvas.addEventListener("pointerup", up);
  canvas.addEventListener("pointercancel", up);
  canvas.addEventListener(
    "wheel",
    (event) => {
      event.preventDefault();
      zoomBy(Math.exp(-event.deltaY * 0.0015), ...at(event));
    },
    { passive: false },
  );
}
