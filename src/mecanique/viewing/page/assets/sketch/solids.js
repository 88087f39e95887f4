// Solids as points in their bodies' axes: boxes, cylinders and spheres need no viewer.

import { emptyBox, turned, unite } from "./framing.js";

const AROUND = 24; // points of a circle

const HALVES = {
  box: ([x, y, z]) => [x / 2, y / 2, z / 2],
  cylinder: ([radius, length]) => [radius, radius, length / 2],
  sphere: ([radius]) => [radius, radius, radius],
};

const SIGNS = [-1, 1];

function ring(radius, z) {
  return Array.from({ length: AROUND }, (_, k) => {
    const angle = (2 * Math.PI * k) / AROUND;
    return [radius * Math.cos(angle), radius * Math.sin(angle), z];
  });
}

// The corners of what is drawn; of a sphere its middle alone.
function cornersOf(kind, [a, b, c]) {
  if (kind === "sphere") return [[0, 0, 0]];
  if (kind === "cylinder") return SIGNS.flatMap((sign) => ring(a, (sign * b) / 2));
  return SIGNS.flatMap((x) =>
    SIGNS.flatMap((y) => SIGNS.map((z) => [(x * a) / 2, (y * b) / 2, (z * c) / 2])),
  );
}

export function solidOf({ kind, size, turn, place, color, opacity }) {
  const half = HALVES[kind](size);
  const points = cornersOf(kind, size).map((p) =>
    place.map((x, i) => x + turn[3 * i] * p[0] + turn[3 * i + 1] * p[1] + turn[3 * i + 2] * p[2]),
  );
  const box = turned({ low: half.map((x) => -x), high: half }, turn, place);
  return { points, box, radius: kind === "sphere" ? size[0] : 0, color, opacity };
}

// The box around a body in its own axes, null for one that is not drawn.
export const boxAround = (solids) =>
  solids.length ? solids.reduce((box, solid) => unite(box, solid.box), emptyBox()) : null;
