// Solids as points in their bodies' axes: boxes, cylinders and spheres need no viewer.

import { emptyBox, unite } from "./framing.js";

const AROUND = 24; // points of a circle

const SIGNS = [-1, 1];

function ring(radius, z) {
  return Array.from({ length: AROUND }, (_, k) => {
    const angle = (2 * Math.PI * k) / AROUND;
    return [radius * Math.cos(angle), radius * Math.sin(angle), z];
  });
}

// The corners of what is drawn; of a sphere its middle alone.
function cornersOf(kind, [a, b, c], profile) {
  if (kind === "sphere") return [[0, 0, 0]];
  if (kind === "cylinder") return profile.flatMap(([radius, z]) => ring(radius, z));
  return SIGNS.flatMap((x) =>
    SIGNS.flatMap((y) => SIGNS.map((z) => [(x * a) / 2, (y * b) / 2, (z * c) / 2])),
  );
}

export function solidOf({ kind, size, profile, turn, place, color, opacity }) {
  const points = cornersOf(kind, size, profile).map((p) =>
    place.map((x, i) => x + turn[3 * i] * p[0] + turn[3 * i + 1] * p[1] + turn[3 * i + 2] * p[2]),
  );
  const radius = kind === "sphere" ? size[0] : 0;
  const grown = (sign) => (p) => p.map((x) => x + sign * radius);
  const [low, high] = [points.map(grown(-1)), points.map(grown(1))];
  const box = low.concat(high).reduce((all, p) => unite(all, { low: p, high: p }), emptyBox());
  return { points, box, radius, color, opacity };
}

// The box around a body in its own axes, null for one that is not drawn.
export const boxAround = (solids) =>
  solids.length ? solids.reduce((box, solid) => unite(box, solid.box), emptyBox()) : null;
