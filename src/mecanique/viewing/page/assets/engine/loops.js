// Closes the loops of a mechanism and keeps what rolls on its plane: at the start by Newton's
// method, and after each step of a motion by projection, which costs no accuracy.

import { dot } from "../data/vectors.js";

const ROUNDS = 60;
const CLOSED = 1e-13;
const FARTHEST = 0.4; // of a round, in the units of the coordinates
const DEPENDENT = 1e-8;
const DRIFTED = 1e-15;

export class Loops {
  // If weighed, steps of velocities are the shortest by kinetic energy: M⁻¹Jᵀ of each row comes after
  // J. Those of positions are rounding.
  constructor(program, { loops, restrained = [], weighed = false, nq, nv }, p) {
    Object.assign(this, { program, count: loops, weighed, nq, nv, p });
    // rows that restrain velocities alone have no say in where the coordinates are
    this.free = Array.from({ length: loops }, (_, r) => restrained.includes(r));
    this.found = new Float64Array(loops * (2 + nv * (weighed ? 2 : 1)));
    this.moved = new Float64Array(nq + nv + 1);
    this.slopes = new Float64Array(nq + nv + 1);
  }

  evaluate(t, y) {
    return this.program.closure(t, y, this.p, this.found);
  }

  // Unit vectors that span the rows of J, each with its step and the part of it that J x = b asks for,
  // b being the numbers from `first` on; zero where something is held.
  basis(first, held) {
    const { count, nv, found } = this;
    const basis = [];
    for (let r = 0; r < count; r++) {
      if (first === 0 && this.free[r]) continue;
      const row = Array.from({ length: nv }, (_, k) =>
        held?.[k] ? 0 : found[2 * count + r * nv + k],
      );
      const at = (2 + nv) * count + r * nv;
      const step = this.weighed && first > 0 ? [...found.subarray(at, at + nv)] : [...row];
      const size = Math.sqrt(dot(row, step));
      let part = found[first + r];
      for (let pass = 0; pass < 2; pass++)
        for (const { axis, step: way, share } of basis) {
          const along = dot(way, row);
          for (let k = 0; k < nv; k++) {
            row[k] -= along * axis[k];
            step[k] -= along * way[k];
          }
          part -= along * share;
        }
      const rest = Math.sqrt(Math.max(dot(row, step), 0));
      const [axis, way] = [row, step].map((vector) => vector.map((x) => x / rest));
      if (rest > DEPENDENT * size) basis.push({ axis, step: way, share: part / rest });
    }
    return basis;
  }

  // The shortest x with J x = b.
  solve(first, held) {
    const x = new Float64Array(this.nv);
    for (const { step, share } of this.basis(first, held))
      for (let k = 0; k < this.nv; k++) x[k] += share * step[k];
    return x;
  }

  // Moves the coordinates by what velocities x would do in a unit of time.
  move(t, y, x, factor) {
    const { nq, nv, moved, slopes } = this;
    moved.set(y.subarray(0, nq));
    for (let k = 0; k < nv; k++) moved[nq + k] = factor * x[k];
    this.program.rates(t, moved, this.p, slopes);
    for (let k = 0; k < nq; k++) y[k] += slopes[k];
  }

  get miss() {
    let worst = 0;
    for (let r = 0; r < this.count; r++) worst = Math.max(worst, Math.abs(this.found[r]));
    return worst;
  }

  // Closes a state, keeping the velocities' numbers that are held; says whether that was possible.
  close(t, y, held = null) {
    for (let round = 0; round < ROUNDS; round++) {
      this.evaluate(t, y);
      if (this.miss <= CLOSED) break;
      const x = this.solve(0, held);
      const size = Math.hypot(...x);
      this.move(t, y, x, -Math.min(1, FARTHEST / (size || 1)));
    }
    this.evaluate(t, y);
    if (!(this.miss <= 1e3 * CLOSED)) return false;
    this.closeRates(y, held);
    return true;
  }

  closeRates(y, held = null) {
    const x = this.solve(this.count, held);
    for (let k = 0; k < this.nv; k++) y[this.nq + k] -= x[k];
  }

  // Puts a state that has drifted back onto the loops.
  settle(t, y) {
    this.evaluate(t, y);
    if (this.miss > DRIFTED) {
      this.move(t, y, this.solve(0, null), -1);
      this.evaluate(t, y);
    }
    this.closeRates(y);
    return true;
  }
}
