// The mechanism itself: its program, with parameters and a start, and the motion that follows.

import { Bounds, findBeyond } from "./bounds.js";
import { Corners } from "./corners.js";
import { Integrator } from "./dop853.js";
import { Loops } from "./loops.js";

// A motion that needs more steps stops there: the page must not stand still.
const MOST_STEPS = 20_000;

export class Machine {
  constructor(engine, program) {
    Object.assign(this, { engine, program });
    this.nq = engine.coordinates.length;
    this.nv = engine.velocities.length;
    this.names = [...engine.coordinates, ...engine.velocities];
    this.force = null; // generalized forces besides those of the mechanism
  }

  // What a page starts with.
  initial() {
    const { values, start, first, duration, rtol } = this.engine;
    return { p: [...values], start: [...start], first, duration, rtol };
  }

  // Of a state: coordinates, velocities, the work done, and what each kind of loss has taken.
  get size() {
    return this.nq + this.nv + 1 + (this.engine.switching?.losses.length ?? 0);
  }

  normalize(y) {
    for (const at of this.engine.quaternions) {
      const size = Math.hypot(y[at], y[at + 1], y[at + 2], y[at + 3]) || 1;
      for (let k = at; k < at + 4; k++) y[k] /= size;
    }
    return this.engine.quaternions.length > 0;
  }

  loopsWith(p) {
    if (!this.engine.loops) return null;
    return new Loops(this.program, { ...this.engine, nq: this.nq, nv: this.nv }, p);
  }

  // The state to start from: unit quaternions, closed loops, within the limits; held are numbers of
  // the state that should stay as they are.
  begin(setting, held = []) {
    const y = this.assemble(setting, held);
    const beyond = this.beyond(Float64Array.from(setting.p), [setting.first, y]);
    if (beyond) throw new Error(`${beyond.must}.`);
    return y;
  }

  beyond(p, state, apart = false) {
    return this.bounded ? findBeyond(this, p, state, apart) : null;
  }

  get bounded() {
    return this.engine.bounds?.length > 0;
  }

  assemble({ p, start, first }, held) {
    const y = new Float64Array(this.size);
    y.set(start);
    this.normalize(y);
    const loops = this.loopsWith(p);
    if (!loops) return y;
    const kept = Array.from({ length: this.nv }, (_, k) =>
      held.some(
        (name) => this.engine.velocities[k] === `${name}'` || this.engine.velocities[k] === name,
      ),
    );
    const trial = y.slice();
    if (kept.includes(true) && loops.close(first, trial, kept)) return trial;
    if (!loops.close(first, y)) throw new Error("The loops cannot be closed with these values.");
    return y;
  }

  // The motion from a start, as a path of states with the work done as their last number.
  move(setting, y, end) {
    const { program, nq, nv } = this;
    const p = Float64Array.from(setting.p);
    const loops = this.loopsWith(p);
    const unit = this.engine.quaternions.length > 0;
    const start = y.slice();
    const span = [setting.first, end];
    const corners = this.engine.switching ? new Corners(this, p, span, start) : null;
    const held = loops ?? corners;
    const settle = (t, state) => {
      if (unit) this.normalize(state);
      return held ? held.settle(t, state) : unit;
    };
    const rates = corners
      ? (t, state, out) => corners.rates(t, state, out, this.force)
      : (t, state, out) => program.rates(t, state, p, out, this.force);
    const integrator = new Integrator(rates, {
      rtol: setting.rtol * (loops ? 0.1 : 1),
      counted: nq + nv,
      settle: held || unit ? settle : null,
      bounds: corners ?? (this.bounded ? new Bounds(this, p, span, start) : null),
      hops: loops !== null,
      most: MOST_STEPS,
    });
    const path = integrator.run(setting.first, start, end);
    return Object.assign(path, { corners });
  }
}
