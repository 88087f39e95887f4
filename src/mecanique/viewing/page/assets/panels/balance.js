// The sums below the tables: virtual work by coordinate, forces and moments on a body cut free.

import { measure } from "../data/numbers.js";
import { add, cross, subtract } from "../data/vectors.js";

// A sum smaller than this part of its terms is what rounding of the key frames leaves.
const NOISE = { work: 2e-5, force: 1e-4 };

const negate = (a) => a.map((x) => -x);

function measureSum(sum, size, rounding) {
  return Math.abs(sum) < rounding * size ? "0" : measure(sum);
}

function measureVector(vector, size) {
  return `(${vector.map((x) => measureSum(x, size, NOISE.force)).join(", ")})`;
}

// Sum the columns of a ledger, given row by row, as it is written.
export function totalWork(entries, columns) {
  const sums = new Array(columns).fill(0);
  const sizes = new Array(columns).fill(0);
  entries.forEach((work, i) => {
    sums[i % columns] += work;
    sizes[i % columns] += Math.abs(work);
  });
  return sums.map((sum, c) => measureSum(sum, sizes[c], NOISE.work));
}

// Sum forces and moments about a point, and the sizes of their terms.
function resultant(loads, about) {
  const total = { force: [0, 0, 0], moment: [0, 0, 0], forceSize: 0, momentSize: 0 };
  for (const { unit, at, vector } of loads) {
    const size = Math.hypot(...vector);
    if (unit === "N") {
      const arm = subtract(at, about);
      total.force = add(total.force, vector);
      total.forceSize += size;
      total.moment = add(total.moment, cross(arm, vector));
      // what rounding leaves grows with arm and force, even where they are parallel
      total.momentSize += Math.hypot(...arm) * size;
    } else {
      total.moment = add(total.moment, vector);
      total.momentSize += size;
    }
  }
  return total;
}

// Compare Σ F with m a, and Σ M about the center of mass with the change of angular momentum.
// Loads are { unit, at, vector }; those of inertia −m a [N] and −(I α + ω × I ω) [N·m].
export function balance(loads, inertia) {
  const push = inertia.find(({ unit }) => unit === "N");
  const spin = inertia.find(({ unit }) => unit !== "N");
  const { force, moment, forceSize, momentSize } = resultant(loads, push?.at ?? [0, 0, 0]);
  const lines = [["Σ F", `${measureVector(force, forceSize)} N`]];
  if (push) {
    const size = Math.max(forceSize, Math.hypot(...push.vector));
    lines.push(["m a", `${measureVector(negate(push.vector), size)} N`]);
    lines.push(["Σ M about the center of mass", `${measureVector(moment, momentSize)} N·m`]);
  }
  if (spin) {
    const size = Math.max(momentSize, Math.hypot(...spin.vector));
    lines.push(["I α + ω × I ω", `${measureVector(negate(spin.vector), size)} N·m`]);
  }
  return lines;
}
