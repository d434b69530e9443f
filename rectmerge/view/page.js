// The page of one answer: which placement is shown, what is drawn, and what the panel tells of it.

const data = JSON.parse(document.getElementById("answer-data").textContent);
const byId = (id) => document.getElementById(id);
const canvas = byId("maps");
const COLOURS = { a: "#3c9ad0", b: "#e07b39" }; // of rectangles: lighter than walls
const HANDLE_AWAY = 84; // of the handle from B's middle, in CSS pixels
const HINTS = {
  view: "Drag to pan, turn the wheel or pinch to zoom. To place map B yourself, let a drag move map B.",
  hand: "Drag moves B. The round handle, Shift-drag or Shift-wheel turns it; Ctrl-wheel scales it; two fingers do all"
    + " three. Arrow keys nudge it. The wheel alone zooms the view.",
};

const candidates = data.candidates.map((one) => ({ ...one, place: one.pixels }));
const [wb, hb] = data.maps.size.slice(2);
const middleOfB = applied(data.maps.to_b, [(wb - 1) / 2, (hb - 1) / 2]); // in B's pixels
const state = {
  shown: candidates.length ? 0 : "hand", // a candidate's index, or "hand"
  from: 0, // the candidate that the hand started from
  hand: candidates.length ? null : data.start, // B's place by hand, once there is one
  screen: [1, 0, 0, 0, 1, 0], // from A's pixels to CSS pixels of the canvas
  isFitted: true, // until the view is moved
  tool: candidates.length ? "view" : "hand",
};
const REFUSED = "Four numbers a,b,tx,ty or three x,y,yaw, with a scale from 0.001 to 1000.";
let pictures = null;

const place = () => (state.shown === "hand" ? state.hand : candidates[state.shown].place);
const middle = () => applied(compose(state.screen, place()), middleOfB);
const entries = () => [...candidates.keys(), ...(state.hand ? ["hand"] : [])];

function handle() {
  const [u, v] = middle();
  const m = compose(state.screen, place());
  const turn = Math.atan2(m[3], m[0]);
  return [u + HANDLE_AWAY * Math.sin(turn), v - HANDLE_AWAY * Math.cos(turn)];
}

function outline(context, matrix, boxes, colour, alpha) {
  context.globalAlpha = alpha;
  context.strokeStyle = colour;
  for (const box of boxes) {
    context.beginPath();
    cornersOf(matrix, box).forEach(([u, v], k) => (k ? context.lineTo(u, v) : context.moveTo(u, v)));
    context.closePath();
    context.stroke();
  }
}

function drawHandle(context) {
  const [[u, v], [hu, hv]] = [middle(), handle()];
  context.globalAlpha = 1;
  context.fillStyle = "#fff";
  context.strokeStyle = "#333";
  context.beginPath();
  context.moveTo(u, v);
  context.lineTo(hu, hv);
  context.stroke();
  for (const [x, y, radius] of [[u, v, 4], [hu, hv, 9]]) {
    context.beginPath();
    context.arc(x, y, radius, 0, 2 * Math.PI);
    context.fill();
    context.stroke();
  }
}

function show() {
  if (!pictures) return;
  const ratio = canvas.width / canvas.clientWidth;
  const alpha = fades(Number(byId("fade").value));
  byId("bending").hidden = !(pictures.bent && state.shown === 0);
  const bent = byId("bending").hidden ? 0 : Number(byId("bend").value); // how far B is shown without its bend, 0 to 1
  const context = paint(canvas, compose([ratio, 0, 0, 0, ratio, 0], state.screen), [
    { picture: pictures.a, matrix: data.maps.to_a, alpha: alpha.a },
    { picture: pictures.b, matrix: compose(place(), data.maps.to_b), alpha: alpha.b * (1 - bent) },
    ...(bent ? [{ picture: pictures.bent, matrix: compose(place(), data.maps.to_bent), alpha: alpha.b * bent }] : []),
  ]);
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.globalCompositeOperation = "source-over";
  context.lineWidth = 1.5;
  if (byId("rectangles").checked) {
    outline(context, state.screen, data.rectangles.a, COLOURS.a, alpha.a);
    outline(context, compose(state.screen, place()), data.rectangles.b, COLOURS.b, alpha.b);
  }
  if (state.tool === "hand" && alpha.b > 0) drawHandle(context);
  canvas.dataset.zoom = state.screen[0]; // CSS pixels per cell of A
}

function fit() {
  state.isFitted = true;
  const box = boxOf(data.maps, [place()]);
  const margin = 0.03 * Math.max(box.right - box.left, box.bottom - box.top);
  const [low, high] = [[box.left - margin, box.top - margin], [box.right + margin, box.bottom + margin]];
  const wider = { left: low[0], top: low[1], right: high[0], bottom: high[1] };
  state.screen = fitted(wider, canvas.clientWidth, canvas.clientHeight);
}

const fixed = (x, digits) => (Object.is(Number(x.toFixed(digits)), -0) ? 0 : x).toFixed(digits);
const told = (x, digits, unit = "") => (x === null ? "not known" : `${x.toFixed(digits)}${unit}`);
const percent = (x, digits = 0) => told(x === null ? null : 100 * x, digits, " %");
const turned = (m) => degrees(yawOf(inMapFrames(m, data.frames)));
const shape = (m) => `scale ${fixed(scaleOf(m), 4)}, ${turned(m) < 0 ? "" : "+"}${fixed(turned(m), 2)}°`;

function label(entry) {
  if (entry === "hand") return ["✥", "by hand, not judged", shape(state.hand)];
  const one = candidates[entry];
  const measured = `overlap ${percent(one.overlap)}, conflict ${percent(one.conflict, 1)}`;
  return [String(entry + 1), `confidence ${told(one.confidence, 2)}`, `${measured}, ${shape(one.place)}`];
}

function listCandidates() {
  byId("candidates").replaceChildren(...entries().map((entry) => {
    const button = document.createElement("button");
    button.type = "button";
    button.setAttribute("aria-current", String(entry === state.shown));
    ["b", "span", "small"].forEach((tag, k) => {
      const part = document.createElement(tag);
      part.textContent = label(entry)[k];
      button.append(part);
    });
    button.addEventListener("click", () => choose(entry));
    const item = document.createElement("li");
    item.append(button);
    return item;
  }));
  const shown = byId("candidates").querySelector('[aria-current="true"]');
  if (shown) shown.scrollIntoView?.({ block: "nearest" });
}

function tell() {
  const m = place();
  const [x, y] = applied(data.frames.a, applied(m, middleOfB));
  const values = { x: fixed(x, 4), y: fixed(y, 4), rotation: fixed(turned(m), 4), scale: fixed(scaleOf(m), 6) };
  for (const [id, value] of Object.entries(values)) if (document.activeElement !== byId(id)) byId(id).value = value;
  const option = pixelsOption(m);
  byId("pixels").value = option;
  byId("guess").value = guessOption(m, data.frames);
  byId("check").value = `rectmerge check ${data.words} ${option}`;
  byId("merge").value = `rectmerge merge ${data.words} ${option} -o by-hand`;
  byId("told").textContent = candidates.length ? "" : "There is no candidate: place map B by hand.";
  byId("reset").disabled = state.shown !== "hand";
  byId("reset").textContent = candidates.length ? `Reset to candidate ${state.from + 1}` : "Reset";
  byId("previous").disabled = byId("next").disabled = entries().length < 2;
}

function refresh() {
  listCandidates();
  tell();
  show();
}

function choose(entry) {
  state.shown = entry;
  if (entry !== "hand") state.from = entry;
  if (state.isFitted) fit();
  refresh();
}

function step(by) {
  const all = entries();
  if (all.length > 1) choose(all[(all.indexOf(state.shown) + by + all.length) % all.length]);
}

// Lay B by hand; what would be no placement is left undone.
function lay(wanted) {
  const m = wanted && asSimilarity(wanted);
  if (!m) return false;
  state.hand = m;
  state.shown = "hand";
  refresh();
  return true;
}

const act = {
  middle,
  handle,
  isHand: () => state.tool === "hand",
  moveB: (s) => lay(compose(inverse(state.screen), compose(s, compose(state.screen, place())))),
  moveView: (s) => {
    const screen = compose(s, state.screen);
    if (screen[0] < 1e-4 || screen[0] > 200) return;
    [state.screen, state.isFitted] = [screen, false];
    show();
  },
};

function chooseTool(tool) {
  state.tool = tool;
  document.querySelector(`[name="tool"][value="${tool}"]`).checked = true;
  canvas.classList.toggle("hand", tool === "hand");
  byId("hint").textContent = HINTS[tool];
  show();
}

function resize() {
  const ratio = window.devicePixelRatio || 1;
  canvas.width = Math.max(1, Math.round(ratio * canvas.clientWidth));
  canvas.height = Math.max(1, Math.round(ratio * canvas.clientHeight));
  if (state.isFitted) fit();
  show();
}

function listenToView() {
  const zoom = (factor) => act.moveView(about([canvas.clientWidth / 2, canvas.clientHeight / 2], 0, factor));
  for (const radio of document.querySelectorAll('[name="tool"]')) {
    radio.addEventListener("change", () => chooseTool(radio.value));
  }
  for (const id of ["fade", "bend", "rectangles"]) byId(id).addEventListener("input", show);
  byId("zoom-in").addEventListener("click", () => zoom(1.25));
  byId("zoom-out").addEventListener("click", () => zoom(0.8));
  byId("fit").addEventListener("click", () => { fit(); show(); });
  byId("previous").addEventListener("click", () => step(-1));
  byId("next").addEventListener("click", () => step(1));
  new ResizeObserver(resize).observe(canvas);
}

// Counter-clockwise to the eye, and larger, about B's middle.
const turnedBy = (angle) => compose(about(applied(place(), middleOfB), (-angle * Math.PI) / 180), place());
const scaledBy = (factor) => compose(about(applied(place(), middleOfB), 0, factor), place());

// Each field changes one thing about B's middle and leaves the others.
const FIELDS = {
  x: (value, [x]) => inPixels(compose(moving(value - x, 0), inMapFrames(place(), data.frames)), data.frames),
  y: (value, [, y]) => inPixels(compose(moving(0, value - y), inMapFrames(place(), data.frames)), data.frames),
  rotation: (value) => turnedBy(value - turned(place())),
  scale: (value) => value > 0 && scaledBy(value / scaleOf(place())),
};

function listenToHand() {
  for (const [id, change] of Object.entries(FIELDS)) {
    byId(id).addEventListener("change", () => {
      const value = byId(id).valueAsNumber;
      if (Number.isFinite(value)) lay(change(value, applied(data.frames.a, applied(place(), middleOfB))));
    });
    byId(id).addEventListener("blur", tell);
  }
  const listen = (name, change) => {
    for (const button of document.querySelectorAll(`[data-${name}]`)) {
      button.addEventListener("click", () => change(button.dataset[name].split(",").map(Number)));
    }
  };
  listen("move", ([u, v]) => lay(compose(moving(u, v), place())));
  listen("turn", ([angle]) => lay(turnedBy(angle)));
  listen("scale", ([factor]) => lay(scaledBy(factor)));
  byId("reset").addEventListener("click", () => {
    state.hand = candidates.length ? null : data.start;
    choose(candidates.length ? state.from : "hand");
  });
  byId("paste").addEventListener("submit", (event) => {
    event.preventDefault();
    const isPlaced = lay(parsePlacement(byId("pasted").value, data.frames, scaleOf(place())));
    byId("refused").textContent = isPlaced ? "" : REFUSED;
  });
}

async function copy(field) {
  try {
    await navigator.clipboard.writeText(field.value);
  } catch { // pages from disk may not be given the clipboard
    field.select();
    document.execCommand("copy");
  }
  byId("copied").textContent = `Copied: ${field.value}`;
}

for (const button of document.querySelectorAll("[data-copy]")) {
  button.addEventListener("click", () => copy(byId(button.dataset.copy)));
}
listenToView();
listenToHand();
listenToPointers(canvas, act);
listenToWheel(canvas, act);
listenToKeys(canvas, act, step);
chooseTool(state.tool);
loadPictures(data.maps).then((both) => {
  pictures = both;
  resize();
  refresh();
});
