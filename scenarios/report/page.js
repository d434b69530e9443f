// Tables sort by a click on a heading; the gallery draws B on A by each answer's matrix, with rectmerge/view/widget.js.

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

function draw(canvas, pair, pictures, answer, at) {
  const alpha = fades(at);
  const screen = fitted(boxOf(pair, [answer.matrix, pair.truth].filter(Boolean)), canvas.width, canvas.height);
  const layers = [{ picture: pictures.a, matrix: pair.to_a, alpha: alpha.a }];
  if (answer.matrix) layers.push({ picture: pictures.b, matrix: compose(answer.matrix, pair.to_b), alpha: alpha.b });
  if (pair.truth) layers.push({ picture: pictures.b, matrix: compose(pair.truth, pair.to_b), alpha: alpha.truth });
  paint(canvas, screen, layers);
}

// The gallery's data: JSON, compressed by gzip and written in base64.
async function unpacked(id) {
  const text = document.getElementById(id).textContent;
  const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Response(stream).json();
}

let data = { pairs: {}, answers: [] };
const loaded = new Map();

function pictures(id) {
  if (!loaded.has(id)) loaded.set(id, loadPictures(data.pairs[id]));
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

function showGallery() {
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

unpacked("gallery-data").then((content) => {
  data = content;
  if (data.answers.length) showGallery();
});
