// A section after Poincaré: the states at which a coordinate or velocity passes through zero upwards,
// angles modulo a turn, gathered from a motion that goes on for long, a little at a time.

import { findEvents } from "./dop853.js";

const STRETCH = 40; // turns of the clock that are computed at a time, in steps of the motion
const MOST_PASSES = 2000;

const REGULAR = 1e-3; // two periods differ by less than this part

// In words, what a single coordinate does: how long it takes to and fro, or that it goes one way.
export function describeSwing({ nq, nv }, path) {
  if (nq !== 1 || nv !== 1) return "";
  const turns = findEvents(path, (t, y) => y[1], 0);
  if (!turns.length) {
    const state = new Float64Array(path.size);
    const [from, to] = [path.first, path.last].map((t) => path.at(t, state)[0]);
    return Math.abs(to - from) > 2 * Math.PI ? "Swings through. " : "";
  }
  const [a, b, c, d] = turns;
  if (d === undefined || Math.abs(c - a - (d - b)) > REGULAR * (c - a)) return "";
  return `Period ${(c - a).toPrecision(3)} s. `;
}

export class Section {
  // `turns` says whether the number of the state that is watched is an angle; angles are the columns
  // of angles in a row.
  constructor(computed, watched, turns, angles = []) {
    Object.assign(this, { computed, watched, turns, angles, rows: [], times: [], done: false });
    const { machine, setting } = computed;
    this.y = machine.begin(setting);
    this.t = setting.first;
    this.stretch = Math.max(setting.duration / STRETCH, 1e-3);
  }

  // Goes on for a while; says whether there are new points.
  extend() {
    const { machine, setting } = this.computed;
    const path = machine.move({ ...setting, first: this.t }, this.y, this.t + this.stretch);
    const at = (y) => y[this.watched];
    const passed = this.turns ? (t, y) => Math.sin(at(y)) : (t, y) => at(y);
    const before = this.n;
    const state = new Float64Array(path.size);
    for (const t of path.steps ? findEvents(path, passed, 1) : []) {
      path.at(t, state);
      if (this.turns && Math.cos(at(state)) < 0) continue;
      const row = new Float64Array(this.computed.layout.end);
      this.computed.fill(t, state, row, path.corners);
      for (const j of this.angles) row[j] -= 2 * Math.PI * Math.round(row[j] / (2 * Math.PI));
      this.rows.push(row);
      this.times.push(t);
    }
    path.at(path.last, this.y);
    this.t = path.last;
    this.done = this.n >= MOST_PASSES || path.stopped !== "" || !path.steps;
    return this.n > before;
  }

  get n() {
    return this.rows.length;
  }

  time(k) {
    return this.times[k];
  }

  value(k, j) {
    return this.rows[k][j];
  }
}
