// A hand that moves a point of a body: coordinates follow as far as joints and loops let them.

import { Corners } from "./corners.js";
import { cross, dot, subtract } from "../data/vectors.js";

const PULLS = 12;
const NUDGE = 1e-6;
const DAMPING_SHARE = 1e-3; // of the squares of the rows, so that stretched arms do not jerk
const SHORTEST_PULL = 1e-9;
const FARTHEST_TURN = 0.5; // of a round, in the units of the coordinates

// x with (A + damping) x = b for a symmetric 3×3 matrix, by Cramer's rule.
function solve3(A, b) {
  const det = ([first, second, third]) => dot(first, cross(second, third));
  const whole = det(A);
  return [0, 1, 2].map(
    (k) => det(A.map((row, i) => row.map((x, j) => (j === k ? b[i] : x)))) / whole,
  );
}

export class Grip {
  // The state is where the hand takes hold; the point is in the body's own axes.
  constructor(computed, t, state, body, point) {
    const { machine, p } = computed;
    Object.assign(this, { computed, machine, p, t, body, point });
    this.y = Float64Array.from(state);
    this.y.fill(0, machine.nq);
    this.loops = machine.loopsWith(p);
    this.corners = computed.path?.corners;
    this.raw = new Float64Array(computed.raw.length);
    this.slopes = new Float64Array(this.y.length);
  }

  // Where the point is.
  at(y) {
    this.machine.program.row(this.t, y, this.p, this.raw, null);
    const pose = this.raw.subarray(12 * this.body, 12 * this.body + 12);
    return [0, 1, 2].map((i) => {
      const row = pose.subarray(3 + 3 * i, 6 + 3 * i);
      return pose[i] + row[0] * this.point[0] + row[1] * this.point[1] + row[2] * this.point[2];
    });
  }

  // The coordinates after velocities x have acted for so long.
  moved(y, x, time) {
    const { nq } = this.machine;
    const trial = Float64Array.from(y);
    x.forEach((value, k) => (trial[nq + k] = value));
    this.machine.program.rates(this.t, trial, this.p, this.slopes, null);
    trial.fill(0, nq);
    for (let k = 0; k < nq; k++) trial[k] += time * this.slopes[k];
    this.machine.normalize(trial);
    return trial;
  }

  // How the point moves with each velocity.
  columns(y) {
    const here = this.at(y);
    return Array.from({ length: this.machine.nv }, (_, k) => {
      const x = Array.from({ length: this.machine.nv }, (__, j) => (j === k ? 1 : 0));
      return subtract(this.at(this.moved(y, x, NUDGE)), here).map((d) => d / NUDGE);
    });
  }

  // Brings the point as near to a target as it goes; the state it then has.
  pull(target) {
    for (let round = 0; round < PULLS; round++) {
      const here = this.at(this.y);
      const gap = subtract(target, here);
      const columns = this.columns(this.y);
      const rows = [0, 1, 2].map((i) => this.free(columns.map((column) => column[i])));
      const squares = rows.map((a) => rows.map((b) => dot(a, b)));
      const size = squares[0][0] + squares[1][1] + squares[2][2];
      if (!(size > 0)) break;
      for (let i = 0; i < 3; i++) squares[i][i] += DAMPING_SHARE * size;
      const weights = solve3(squares, gap);
      const x = columns.map((_, k) => rows.reduce((sum, row, i) => sum + weights[i] * row[k], 0));
      if (!this.advance(x, target, Math.hypot(...gap))) break;
    }
    return this.y;
  }

  // Goes along x as far as that brings the point nearer; says whether it did.
  advance(x, target, distance) {
    const length = Math.hypot(...x);
    if (length < SHORTEST_PULL) return false;
    for (let part = Math.min(1, FARTHEST_TURN / length); part * length > SHORTEST_PULL; part /= 2) {
      const next = this.moved(this.y, x, part);
      if (this.loops && !this.loops.close(this.t, next)) continue;
      if (this.corners && !this.corners.part(this.t, next)) continue;
      next.fill(0, this.machine.nq);
      if (this.machine.beyond(this.p, [this.t, next], true)) continue;
      if (Math.hypot(...subtract(target, this.at(next))) >= distance) continue;
      if (this.corners && !this.begin(next)) continue;
      this.y = next;
      return true;
    }
    return false;
  }

  // Whether a motion begins at a state, by the mode that then holds.
  begin(y) {
    try {
      this.corners = new Corners(this.machine, this.p, [this.t, this.t], y);
    } catch {
      return false;
    }
    return true;
  }

  // The part of a row along motions that the loops leave free.
  free(row) {
    if (!this.loops) return row;
    this.loops.evaluate(this.t, this.y);
    for (const { axis } of this.loops.basis(0, null)) {
      const along = dot(axis, row);
      row = row.map((x, k) => x - along * axis[k]);
    }
    return row;
  }
}
