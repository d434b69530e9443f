// Where map B lies: similarities [a, -b, tx, b, a, ty] from B's pixels to A's, and the same in map frames.

const LEAST_SCALE = 0.001;
const MOST_SCALE = 1000;

const moving = (u, v) => [1, 0, u, 0, 1, v];

// A turn by radians, towards v and so clockwise to the eye, and a scaling, about a point.
function about([u, v], turn, factor = 1) {
  const [a, b] = [factor * Math.cos(turn), factor * Math.sin(turn)];
  return [a, -b, u - a * u + b * v, b, a, v - b * u - a * v];
}

// The similarity that takes two points to two others.
function between([p, q], [r, s]) {
  const [pu, pv, ru, rv] = [q[0] - p[0], q[1] - p[1], s[0] - r[0], s[1] - r[1]];
  const square = Math.max(pu * pu + pv * pv, 1e-9);
  const [a, b] = [(pu * ru + pv * rv) / square, (pu * rv - pv * ru) / square];
  return [a, -b, r[0] - a * p[0] + b * p[1], b, a, r[1] - b * p[0] - a * p[1]];
}

const scaleOf = (m) => Math.hypot(m[0], m[3]);

// The same to the last bit a similarity; a scale out of bounds is none: null.
function asSimilarity(m) {
  const [a, b] = [(m[0] + m[4]) / 2, (m[3] - m[1]) / 2];
  const scale = Math.hypot(a, b);
  if (!(scale >= LEAST_SCALE && scale <= MOST_SCALE && Number.isFinite(m[2]) && Number.isFinite(m[5]))) return null;
  return [a, -b, m[2], b, a, m[5]];
}

// From B's map frame to A's.
const inMapFrames = (m, frames) => compose(frames.a, compose(m, inverse(frames.b)));
const inPixels = (m, frames) => compose(inverse(frames.a), compose(m, frames.b));

const degrees = (radians) => (radians * 180) / Math.PI;
const yawOf = (m) => Math.atan2(m[3], m[0]);
const plainNumber = (x) => String(Number((x === 0 ? 0 : x).toPrecision(10)));

// The numbers as options take them.
const pixelsOption = (m) => `--pixels=${[m[0], m[3], m[2], m[5]].map(plainNumber).join(",")}`;

function guessOption(m, frames) {
  const placed = inMapFrames(m, frames);
  return `--guess=${[placed[2], placed[5], yawOf(placed)].map(plainNumber).join(",")}`;
}

// What was pasted: a,b,tx,ty between pixels, or x,y,yaw between map frames, which leaves the scale; else null.
function parsePlacement(text, frames, scale) {
  const words = text.replace(/^\s*--\w+[=\s]/, "").replace(/["']/g, "").split(/[\s,;]+/).filter(Boolean);
  const numbers = words.map(Number);
  if (!numbers.every(Number.isFinite)) return null;
  if (numbers.length === 4) {
    const [a, b, tx, ty] = numbers;
    return asSimilarity([a, -b, tx, b, a, ty]);
  }
  if (numbers.length !== 3) return null;
  const [x, y, yaw] = numbers;
  const size = (scale * scaleOf(frames.a)) / scaleOf(frames.b);
  const [a, b] = [size * Math.cos(yaw), size * Math.sin(yaw)];
  return asSimilarity(inPixels([a, -b, x, b, a, y], frames));
}
