// How much room a motion takes, and where to look at it from, in plain numbers: the sketch asks
// before the viewer is there, the stage afterwards.

import { cross, dot, unit } from "../data/vectors.js";

// How many times the first box the start of a motion that goes far may fill; a streamed motion, whose
// future is unknown, may stay near after all.
const SPREAD = 1.2;
const STREAMED = 1.8;
const FAR = 5; // times the mechanism's own size: a motion that goes far

const NEAR = 0.3; // of the room in which bodies move: how far around it what rests is framed

const FOOT = 0.054; // of the size of a box: how far its feet reach

export const FIELD = 26; // of the camera, from top to bottom [degrees]

const DIRECTIONS = {
  front: [0, -1, 0.16],
  side: [1, 0, 0.12],
  top: [0, -0.0001, 1],
  free: [0.75, -1.25, 0.62],
};

// Boxes along the axes, empty at first.
export const emptyBox = () => ({
  low: [Infinity, Infinity, Infinity],
  high: [-Infinity, -Infinity, -Infinity],
});

const isEmpty = ({ low, high }) => low.some((x, i) => x > high[i]);
const sizeOf = (box) => (isEmpty(box) ? 0 : Math.hypot(...box.high.map((x, i) => x - box.low[i])));
const copyOf = ({ low, high }) => ({ low: [...low], high: [...high] });

export function unite(box, { low, high }) {
  for (let i = 0; i < 3; i++) {
    box.low[i] = Math.min(box.low[i], low[i]);
    box.high[i] = Math.max(box.high[i], high[i]);
  }
  return box;
}

// The box around a box that is turned, row by row of the matrix, and shifted.
export function turned({ low, high }, m, shift) {
  const out = { low: [...shift], high: [...shift] };
  for (let i = 0; i < 3; i++)
    for (let j = 0; j < 3; j++) {
      const [a, b] = [m[3 * i + j] * low[j], m[3 * i + j] * high[j]];
      out.low[i] += Math.min(a, b);
      out.high[i] += Math.max(a, b);
    }
  return out;
}

// The matrix of a unit quaternion, row by row.
export function matrixOf(x, y, z, w) {
  return [
    1 - 2 * (y * y + z * z),
    2 * (x * y - z * w),
    2 * (x * z + y * w),
    2 * (x * y + z * w),
    1 - 2 * (x * x + z * z),
    2 * (y * z - x * w),
    2 * (x * z - y * w),
    2 * (y * z + x * w),
    1 - 2 * (x * x + y * y),
  ];
}

// The box of the bodies that count, empty if there are none; boxes are those of the bodies in their
// own axes, null for one that is not drawn.
function boundsOfBodies(boxes, rows, counts = () => true) {
  const box = emptyBox();
  boxes.forEach((own, b) => {
    if (!own || !counts(b)) return;
    for (const row of rows) {
      const [x, y, z, qx, qy, qz, qw] = row.subarray(7 * b, 7 * b + 7);
      unite(box, turned(own, matrixOf(qx, qy, qz, qw), [x, y, z]));
    }
  });
  return box;
}

// The box around all that moves in rows of the table, and around what rests as far as that is near,
// so that a wide floor leaves no small picture of what rolls on it; no side of it is very short.
function bounds(boxes, rows, layout, moves) {
  const box = boundsOfBodies(boxes, rows, (b) => moves[b]);
  const rest = boundsOfBodies(boxes, [rows[0]], (b) => !moves[b]);
  if (isEmpty(box)) unite(box, rest);
  else if (!isEmpty(rest)) {
    const near = NEAR * sizeOf(box);
    const clip = (x, i) => Math.min(Math.max(x, box.low[i] - near), box.high[i] + near);
    unite(box, { low: rest.low.map(clip), high: rest.high.map(clip) });
  }
  for (const row of rows)
    for (let j = layout.lines; j < layout.series; j += 3) {
      const point = row.subarray(j, j + 3);
      // what a program does not know is not a number
      if (!Number.isNaN(point[0])) unite(box, { low: point, high: point });
    }
  if (isEmpty(box)) return { low: [-0.5, -0.5, -0.5], high: [0.5, 0.5, 0.5] };
  const sides = box.high.map((x, i) => x - box.low[i]);
  const least = 0.1 * Math.max(...sides, 1e-3);
  const grow = sides.map((side) => 0.5 * Math.max(0, least - side));
  return {
    low: box.low.map((x, i) => x - grow[i]),
    high: box.high.map((x, i) => x + grow[i]),
  };
}

// How large the bodies that move are together. What rests says nothing of how large that is which
// moves away from it, nor do lines, such as the slides along which it goes.
const ownSize = (boxes, rows, moves) =>
  Math.max(...rows.map((row) => sizeOf(boundsOfBodies(boxes, [row], (b) => moves[b]))));

// Which bodies are not at the same place in all rows.
function findMoving(boxes, rows) {
  const changes = (i) => rows.some((row) => row[i] !== rows[0][i]);
  return boxes.map((_, b) => [0, 1, 2, 3, 4, 5, 6].some((i) => changes(7 * b + i)));
}

// The box to begin with: all that the first rows sweep, unless that is much larger than the
// mechanism as it starts.
function startBox(boxes, rows, layout, moves, spread) {
  let swept = bounds(boxes, [rows[0]], layout, moves);
  const largest = sizeOf(swept);
  for (const row of rows) {
    const wider = unite(copyOf(swept), bounds(boxes, [row], layout, moves));
    if (sizeOf(wider) > spread * largest) break;
    swept = wider;
  }
  return swept;
}

// A box widened by the feet on which pins and springs stand; they point away from these.
function withFeet(box, joints) {
  const reach = FOOT * sizeOf(box);
  for (const { foot } of joints) {
    if (!foot?.length) continue;
    const sole = [0, 1, 2].map((i) => foot[i] + reach * foot[i + 3]);
    unite(box, { low: sole, high: sole });
  }
  return box;
}

// The box to frame, and whether the camera must keep up with a motion that leaves any such box, as
// one does that goes so far that the mechanism would be small in a picture of all of it.
export function frame(boxes, rows, layout, { bounds: given, streamed, joints = [] } = {}) {
  if (given) return { box: { low: given[0], high: given[1] }, far: Boolean(streamed) };
  const moves = findMoving(boxes, rows);
  const whole = bounds(boxes, rows, layout, moves);
  const size = ownSize(boxes, rows, moves);
  const far = Boolean(streamed) || (size > 0 && sizeOf(whole) > FAR * size);
  if (!far) return { box: withFeet(whole, joints), far };
  // what rests is left behind by a motion that is known to go far
  const shown = streamed ? boxes : boxes.map((box, b) => (moves[b] ? box : null));
  const spread = streamed ? STREAMED : SPREAD;
  return { box: startBox(shown, rows, layout, moves, spread), far };
}

// Where to look, and from where: every corner of the box is in the picture, with a margin.
export function aim(preset, { low, high }, { aspect, share }) {
  const toEye = unit(DIRECTIONS[preset]);
  const right = preset === "top" ? [1, 0, 0] : unit([-toEye[1], toEye[0], 0]);
  const up = cross(toEye, right);
  const tan = Math.tan((FIELD * Math.PI) / 360);
  const tanV = 0.94 * tan * share;
  const tanH = 0.84 * tan * Math.max(aspect, 0.2);
  const half = low.map((x, i) => (high[i] - x) / 2);
  let distance = 0;
  for (const x of [-half[0], half[0]])
    for (const y of [-half[1], half[1]])
      for (const z of [-half[2], half[2]]) {
        const d = [x, y, z];
        const reach = Math.max(Math.abs(dot(d, right)) / tanH, Math.abs(dot(d, up)) / tanV);
        distance = Math.max(distance, reach + dot(d, toEye));
      }
  const target = low.map((x, i) => (x + high[i]) / 2);
  const eye = target.map((x, i) => x + distance * toEye[i]);
  return { target, eye, right, up, toEye, distance };
}

// The mechanism stands between the bars of buttons, which take up to half of a low picture: which
// share of the height it has, and how far it is shifted down [px].
export function room(pane) {
  const { clientWidth: w, clientHeight: h } = pane;
  const [above, below] = ["tools", "forces"].map(
    (id) => 14 + document.getElementById(id).offsetHeight,
  );
  const most = Math.min(1, (0.5 * h) / (above + below));
  const share = 1 - (most * (above + below)) / h;
  return { w, h, share, shift: (most * (above - below)) / 2 };
}
