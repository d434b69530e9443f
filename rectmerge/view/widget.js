"use strict";
// Two maps as pictures, laid on each other by matrices between the maps' pixels; knows nothing of the page it serves.
// A matrix [a, b, c, d, e, f] takes (u, v) to (a u + b v + c, d u + e v + f). Pixel centres are at integers.

const compose = (m, n) => [
  m[0] * n[0] + m[1] * n[3], m[0] * n[1] + m[1] * n[4], m[0] * n[2] + m[1] * n[5] + m[2],
  m[3] * n[0] + m[4] * n[3], m[3] * n[1] + m[4] * n[4], m[3] * n[2] + m[4] * n[5] + m[5],
];

const applied = (m, [u, v]) => [m[0] * u + m[1] * v + m[2], m[3] * u + m[4] * v + m[5]];

const clamp = (x, low = 0, high = 1) => Math.min(high, Math.max(low, x));

function inverse(m) {
  const det = m[0] * m[4] - m[1] * m[3];
  const [a, b, d, e] = [m[4] / det, -m[1] / det, -m[3] / det, m[0] / det];
  return [a, b, -a * m[2] - b * m[5], d, e, -d * m[2] - e * m[5]];
}

// The pictures of a pair, once they are decoded.
function loadPictures(pair) {
  const load = (address) => new Promise((resolve, reject) => {
    const image = new Image();
    image.onload = () => resolve(image);
    image.onerror = reject;
    image.src = address;
  });
  return Promise.all([pair.a, pair.b, pair.bent].map((address) => address && load(address)))
    .then(([a, b, bent]) => ({ a, b, bent }));
}

// Where the corners of cells x .. x + w - 1, y .. y + h - 1 come to lie.
const cornersOf = (m, [x, y, w, h]) =>
  [[x, y], [x + w, y], [x + w, y + h], [x, y + h]].map(([u, v]) => applied(m, [u - 0.5, v - 0.5]));

// The box in A's pixels that holds what is known of map A, and of map B as the matrices place it.
function boxOf(pair, places) {
  const ours = cornersOf(pair.to_a, [0, 0, ...pair.size]); // a picture is cut to what is known
  const around = (m, hull) => hull.flatMap(([u, v]) => cornersOf(m, [u, v, 1, 1]));
  const all = [ours, ...places.map((m) => around(compose(m, pair.to_b), pair.hull_b))].flat();
  const far = 4 * Math.max(ours[2][0] - ours[0][0], ours[2][1] - ours[0][1]);
  // what lies far away must not shrink the maps to nothing
  const reach = (k, most) => clamp(most(...all.map((p) => p[k])), ours[0][k] - far, ours[2][k] + far);
  return { left: reach(0, Math.min), top: reach(1, Math.min), right: reach(0, Math.max), bottom: reach(1, Math.max) };
}

// From A's pixels to those of a screen that shows a box whole.
function fitted(box, width, height) {
  const zoom = Math.min(width / (box.right - box.left), height / (box.bottom - box.top));
  return [zoom, 0, (width - zoom * (box.left + box.right)) / 2, 0, zoom, (height - zoom * (box.top + box.bottom)) / 2];
}

// How strongly A, B, and B where it truly lies, are drawn at a place of the slider: 0 A, 1 both, 2 B, 3 both by truth.
const fades = (at) => ({
  a: at <= 2 ? clamp(2 - at) : clamp(at - 2), b: at <= 2 ? clamp(at) : clamp(3 - at), truth: clamp(at - 2),
});

// Draw layers { picture, matrix, alpha }; a matrix takes a picture's pixels to A's, and `screen` these to the canvas.
function paint(canvas, screen, layers) {
  const context = canvas.getContext("2d");
  context.setTransform(1, 0, 0, 1, 0, 0);
  context.globalCompositeOperation = "source-over";
  context.clearRect(0, 0, canvas.width, canvas.height);
  context.globalCompositeOperation = "multiply";
  for (const { picture, matrix, alpha } of layers) {
    if (alpha <= 0) continue;
    const m = compose(screen, matrix);
    context.globalAlpha = alpha;
    context.imageSmoothingEnabled = Math.hypot(m[0], m[3]) < 1; // thin walls stay when shrunk, cells when enlarged
    context.setTransform(m[0], m[3], m[1], m[4], m[2], m[5]);
    context.drawImage(picture, -0.5, -0.5); // a picture's corner lies half a pixel before the centre of its first
  }
  return context;
}
