// What pointers, the wheel and keys do on the canvas. All is told as similarities of the screen, in CSS pixels.
// `act` has: isHand(), middle() of B, handle() that turns it, moveView(similarity), moveB(similarity).

const HANDLE_REACH = 22; // from the handle's middle, in CSS pixels: as wide as a finger
const WHEEL_ZOOM = 0.0015; // per pixel of the wheel
const WHEEL_TURN = 0.0006; // radians

const at = (canvas, event) => {
  const box = canvas.getBoundingClientRect();
  return [event.clientX - box.left - canvas.clientLeft, event.clientY - box.top - canvas.clientTop];
};

const pixelsOf = (event) => (event.deltaMode === 1 ? 16 : event.deltaMode === 2 ? 400 : 1);

function chosenDrag(act, event, point) {
  if (!act.isHand() || event.button === 1) return "view";
  const [u, v] = act.handle();
  if (Math.hypot(point[0] - u, point[1] - v) <= HANDLE_REACH) return "turn";
  return event.shiftKey ? "turn" : "hand";
}

function turnBetween(act, from, to) {
  const middle = act.middle();
  const angle = (p) => Math.atan2(p[1] - middle[1], p[0] - middle[0]);
  return about(middle, angle(to) - angle(from));
}

function pinch(act, from, to) {
  const whole = between(from, to);
  if (act.isHand()) return act.moveB(whole);
  const middle = (pair) => [(pair[0][0] + pair[1][0]) / 2, (pair[0][1] + pair[1][1]) / 2];
  const [m, n] = [middle(from), middle(to)];
  return act.moveView(compose(moving(n[0] - m[0], n[1] - m[1]), about(m, 0, scaleOf(whole)))); // a view is not turned
}

function listenToPointers(canvas, act) {
  const held = new Map(); // pointers that are down: where they were last
  let drag = null;
  const end = (event) => {
    held.delete(event.pointerId);
    canvas.classList.remove("turning");
  };
  canvas.addEventListener("pointerdown", (event) => {
    if (event.button > 1) return;
    canvas.setPointerCapture(event.pointerId);
    const point = at(canvas, event);
    if (held.size === 0) drag = chosenDrag(act, event, point);
    held.set(event.pointerId, point);
    canvas.classList.toggle("turning", drag === "turn");
    if (event.button === 1) event.preventDefault(); // no scrolling by the middle button
  });
  canvas.addEventListener("pointermove", (event) => {
    if (!held.has(event.pointerId)) return;
    const [from, to] = [held.get(event.pointerId), at(canvas, event)];
    const other = [...held].find(([id]) => id !== event.pointerId);
    held.set(event.pointerId, to);
    if (other && held.size === 2) pinch(act, [other[1], from], [other[1], to]);
    else if (drag === "turn") act.moveB(turnBetween(act, from, to));
    else (drag === "hand" ? act.moveB : act.moveView)(moving(to[0] - from[0], to[1] - from[1]));
  });
  for (const name of ["pointerup", "pointercancel"]) canvas.addEventListener(name, end);
}

function listenToWheel(canvas, act) {
  canvas.addEventListener("wheel", (event) => {
    event.preventDefault();
    const turned = (event.deltaY || event.deltaX) * pixelsOf(event); // with Shift some browsers tell it sideways
    const factor = Math.exp(-clamp(turned, -300, 300) * WHEEL_ZOOM);
    if (act.isHand() && event.ctrlKey) act.moveB(about(act.middle(), 0, factor));
    else if (act.isHand() && event.shiftKey) act.moveB(about(act.middle(), turned * WHEEL_TURN));
    else act.moveView(about(at(canvas, event), 0, factor));
  }, { passive: false });
}

const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };

// Arrows move B by hand while the canvas has the focus, else step through the candidates; never what is typed.
function listenToKeys(canvas, act, step) {
  document.addEventListener("keydown", (event) => {
    const arrow = ARROWS[event.key];
    if (!arrow || event.altKey || event.ctrlKey || event.metaKey || event.target.closest("input")) return;
    if (event.target === canvas && act.isHand()) {
      const far = event.shiftKey ? 10 : 1;
      act.moveB(moving(far * arrow[0], far * arrow[1]));
    } else if (arrow[0]) step(arrow[0]);
    else return;
    event.preventDefault();
  });
}
