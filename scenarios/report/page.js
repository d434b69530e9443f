"use strict";
// Tables sort by a click on a heading; the gallery draws B on A by each answer's matrix.

const STOPS = 3; // of the slider: A, both, B, both by the truth
const STEP = 24; // cards that are added at a time

function sortBy(table, column) {
  const heads = [...table.tHead.rows[0].cells];
  const ascending = heads[column].getAttribute("aria-sort") === "descending";
  heads.forEach((head, k) => {
    if (k === column) head.setAttribute("aria-sort", ascending ? "ascending" : "descending");
    else head.removeAttribute("aria-sort");
  });
  const body = table.tBodies[0];
  const key = (row) => {
    const cell = row.cells[column];
    if (cell.dataset.value === undefined) return cell.textContent;
    return cell.dataset.value === "" ? null : Number(cell.dataset.value);
  };
  const rows = [...body.rows].sort((one, two) => {
    const [x, y] = [key(one), key(two)];
    if (x === null || y === null) return (x === null) - (y === null); // what is not there comes last
    const order = typeof x === "string" ? y.localeCompare(x) : x - y;
    return ascending ? order : -order;
  });
  body.append(...rows);
}

for (const table of document.querySelectorAll("table.sortable")) {
  [...table.tHead.rows[0].cells].forEach((head, column) => {
    head.querySelector("button").addEventListener("click", () => sortBy(table, column));
  });
}

const compose = (m, n) => [
  m[0] * n[0] + m[1] * n[3], m[0] * n[1] + m[1] * n[4], m[0] * n[2] + m[1] * n[5] + m[2],
  m[3] * n[0] + m[4] * n[3], m[3] * n[1] + m[4] * n[4], m[3] * n[2] + m[4] * n[5] + m[5],
];

function inverse(m) {
  const det = m[0] * m[4] - m[1] * m[3];
  const [a, b, d, e] = [m[4] / det, -m[1] / det, -m[3] / det, m[0] / det];
  return [a, b, -a * m[2] - b * m[5], d, e, -d * m[2] - e * m[5]];
}

// Where picture B lies on picture A, between pixel centres, and the box that holds both.
function laid(pair, matrix) {
  return compose(inverse(pair.to_a), compose(matrix, pair.to_b));
}

function boxOf(pair, matrices) {
  const [wa, ha, wb, hb] = pair.size;
  const points = [[0, 0], [wa, ha]];
  for (const m of matrices) {
    for (const [u, v] of [[0, 0], [wb, 0], [0, hb], [wb, hb]]) {
      points.push([m[0] * u + m[1] * v + m[2], m[3] * u + m[4] * v + m[5]]);
    }
  }
  const [us, vs] = [points.map((p) => p[0]), points.map((p) => p[1])];
  const far = 4 * Math.max(wa, ha); // an answer far away must not shrink the maps to nothing
  const low = [Math.max(Math.min(...us), -far), Math.max(Math.min(...vs), -far)];
  const high = [Math.min(Math.max(...us), far), Math.min(Math.max(...vs), far)];
  const side = Math.max(high[0] - low[0], high[1] - low[1]);
  return { u: (low[0] + high[0] - side) / 2, v: (low[1] + high[1] - side) / 2, side };
}

function draw(canvas, pair, pictures, answer, at) {
  const context = canvas.getContext("2d");
  const given = answer.matrix && laid(pair, answer.matrix);
  const truth = pair.truth && laid(pair, pair.truth);
  const box = boxOf(pair, [given, truth].filter(Boolean));
  const zoom = canvas.width / box.side;
  context.setTransform(1, 0, 0, 1, 0, 0);
  context.globalCompositeOperation = "source-over";
  context.clearRect(0, 0, canvas.width, canvas.height);
  context.globalCompositeOperation = "multiply";
  context.imageSmoothingEnabled = false;
  const put = (picture, m, alpha) => {
    if (alpha <= 0) return;
    context.globalAlpha = alpha;
    // pixel centres are at integers in the matrices, and at halves on a canvas
    context.setTransform(zoom * m[0], zoom * m[3], zoom * m[1], zoom * m[4],
      zoom * (m[2] - box.u + 0.5), zoom * (m[5] - box.v + 0.5));
    context.drawImage(picture, -0.5, -0.5);
  };
  const clamp = (x) => Math.min(1, Math.max(0, x));
  put(pictures.a, [1, 0, 0, 0, 1, 0], at <= 1 ? 1 : at <= 2 ? clamp(2 - at) : clamp(at - 2));
  if (given) put(pictures.b, given, at <= 2 ? clamp(at) : clamp(3 - at));
  if (truth) put(pictures.b, truth, clamp(at - 2));
}

const data = JSON.parse(document.getElementById("gallery-data").textContent);
const loaded = new Map();

function pictures(id) {
  if (!loaded.has(id)) {
    const load = (address) => new Promise((resolve) => {
      const image = new Image();
      image.onload = () => resolve(image);
      image.src = address;
    });
    loaded.set(id, Promise.all([load(data.pairs[id].a), load(data.pairs[id].b)]).then(([a, b]) => ({ a, b })));
  }
  return loaded.get(id);
}

function element(tag, text, name) {
  const made = document.createElement(tag);
  if (text !== undefined) made.textContent = text;
  if (name) made.className = name;
  return made;
}

function card(answer) {
  const pair = data.pairs[answer.pair];
  const box = element("article", undefined, "card");
  const canvas = element("canvas");
  canvas.width = canvas.height = 512;
  const slider = element("input");
  Object.assign(slider, { type: "range", min: 0, max: STOPS, step: 0.05, value: 1 });
  slider.setAttribute("aria-label", `fade between map A, both, map B and the truth: ${answer.pair}, ${answer.method}`);
  const stops = element("div", undefined, "stops");
  for (const stop of ["A", "both", "B", pair.truth ? "truth" : "no truth"]) stops.append(element("span", stop));
  const told = (value, digits) => (value === null || value === undefined ? "-" : value.toFixed(digits));
  const about = Object.entries(pair.about).map(([key, value]) =>
    `${key} ${typeof value === "number" && value % 1 ? value.toFixed(2) : value}`).join(", ");
  box.append(canvas, slider, stops, element("h4", `${answer.method}: ${answer.pair}`));
  box.append(element("p", answer.outcome, "outcome"));
  box.append(element("p", `confidence ${told(answer.confidence, 3)}, e ${told(answer.e, 2)} cells`
    + ` (${answer.eL === null || answer.eL === undefined ? "-" : (100 * answer.eL).toFixed(2)} % of L)`));
  box.append(element("p", `${answer.suite}; ${about}`), element("p", answer.reason));
  pictures(answer.pair).then((both) => {
    const show = () => draw(canvas, pair, both, answer, Number(slider.value));
    slider.addEventListener("input", show);
    show();
  });
  return box;
}

function fill(select, values) {
  for (const value of [...new Set(values)].sort()) select.append(new Option(value, value));
}

if (data.answers.length) {
  const filters = ["suite", "method", "outcome"].map((key) => ({ key, select: document.getElementById(`filter-${key}`) }));
  const cards = document.getElementById("cards");
  const more = document.getElementById("more");
  let chosen = [];
  const add = () => {
    cards.append(...chosen.slice(cards.childElementCount, cards.childElementCount + STEP).map(card));
    more.hidden = cards.childElementCount >= chosen.length;
  };
  const choose = () => {
    chosen = data.answers.filter((one) => filters.every(({ key, select }) => !select.value || one[key] === select.value));
    document.getElementById("shown-count").textContent = `${chosen.length} answers`;
    cards.replaceChildren();
    add();
  };
  for (const { key, select } of filters) {
    fill(select, data.answers.map((one) => one[key]));
    select.addEventListener("change", choose);
  }
  more.addEventListener("click", add);
  choose();
}
