// What ends a motion or sends it back: limits of coordinates and joints, events that stop, impacts.

import { dot } from "../data/vectors.js";
import { bisect, findDip, LOOKS } from "./dop853.js";

const SHORTEST_FLIGHT = 1e-9; // of the motion; impacts closer together are a lasting contact
const TINY = 1e-300; // zero with a sign

// The bound that a state lies beyond, where no motion starts, or what is nearer to it than counts as
// reached. A coordinate must not be at its very limit, a joint may.
export function findBeyond({ engine, program }, p, [t, y], apart = false) {
  const out = new Float64Array(2 * engine.bounds.length);
  program.bounds(t, y, p, out);
  return engine.bounds.find(({ must }, k) => {
    const [distance, margin] = out.subarray(2 * k, 2 * k + 2);
    const inside = margin > 0 ? distance > 0 : distance >= 0;
    return must && !(inside && distance >= (apart ? margin : 0));
  });
}

export class Bounds {
  // Of a motion from a state to a time. One that starts near a limit may come half as near.
  constructor(machine, p, [first, last], start) {
    const { bounds } = machine.engine;
    Object.assign(this, { machine, p, bounds, length: last - first });
    this.out = new Float64Array(2 * bounds.length);
    this.state = start.slice();
    machine.program.bounds(first, start, p, this.out);
    this.near = bounds.map((_, k) => Math.min(this.out[2 * k + 1], Math.abs(this.out[2 * k]) / 2));
    this.before = this.measure(first, start);
    this.struck = bounds.map(() => -Infinity);
  }

  measure(t, y) {
    this.machine.program.bounds(t, y, this.p, this.out);
    return this.near.map((near, k) => this.out[2 * k] - near);
  }

  // The first bound that the last piece of a path passes: its number, when, and from which side.
  find(path) {
    const [from, to] = path.times.slice(-2);
    const at = (t) => this.measure(t, path.follow(path.steps - 1, t, this.state));
    let low = from;
    const looks = [[from, this.before]];
    for (let look = 1; look <= LOOKS; look++) {
      const high = look === LOOKS ? to : from + ((to - from) * look) / LOOKS;
      const now = at(high);
      looks.push([high, now]);
      const passed = this.bounds.flatMap(({ direction }, k) => {
        const sign = Math.sign(this.before[k]);
        if (sign * direction > 0 || !sign) return [];
        const value = (t) => sign * at(t)[k];
        if (now[k] * sign > 0) {
          const three = looks.slice(-3).map(([t, values]) => [t, sign * values[k]]);
          const turn = look > 1 ? findDip(value, ...three) : null;
          return turn === null ? [] : [{ k, sign, t: bisect(value, three[0][0], turn) }];
        }
        return [{ k, sign, t: bisect(value, this.leave(value, low, high), high) }];
      });
      if (passed.length) return passed.reduce((a, b) => (b.t < a.t ? b : a));
      [this.before, low] = [now, high];
    }
    return null;
  }

  // Just after an impact a number is zero to rounding: a time at which it has left zero.
  leave(value, low, high) {
    let width = high - low;
    let t = low;
    for (let k = 0; k < 50 && !(value(t) > 0); k++) {
      width /= 2;
      t = low + width;
    }
    return t;
  }

  // What a bound does to the state there; in words, if it ends the motion.
  strike({ k, sign, t }, y) {
    const { words, restitution } = this.bounds[k];
    if (restitution === null) return words;
    if (t - this.struck[k] < SHORTEST_FLIGHT * this.length)
      return `${words}, where impacts follow one another without end`;
    this.struck[k] = t;
    if (!this.rebound(k, t, y)) return `${words}, where nothing can move`;
    this.before = this.measure(t, y);
    this.before[k] = sign * TINY; // it goes back to where it came from
    return "";
  }

  // Newton's law of restitution: v⁺ = v − W n (1 + e) ġ / (nᵀ W n), with n the gradient of what
  // passes zero, and W n the velocities that an impulse along it causes.
  rebound(k, t, y) {
    const { machine, p, bounds } = this;
    const { program, nq, nv } = machine;
    const place = bounds.slice(0, k).filter(({ restitution }) => restitution !== null).length;
    const slopes = new Float64Array(bounds.length * (1 + nq));
    program.gradients(t, y, p, slopes);
    const [byTime, ...byPlace] = slopes.subarray(place * (1 + nq), (place + 1) * (1 + nq));
    const rates = (v, push) => {
      const [state, out] = [y.slice(), new Float64Array(y.length)];
      state.set(v, nq);
      program.rates(t, state, p, out, push);
      return out;
    };
    const n = new Float64Array(nv + 1);
    for (let i = 0; i < nv; i++) {
      const v = new Float64Array(nv);
      v[i] = 1;
      n[i] = dot(byPlace, rates(v, null));
    }
    const v = y.slice(nq, nq + nv);
    const [rest, pushed] = [rates(v, null), rates(v, n)];
    const W = v.map((_, i) => pushed[nq + i] - rest[nq + i]);
    const gain = dot(W, n);
    if (!(gain > 0)) return false;
    const rate = dot(v, n);
    const impulse = ((1 + bounds[k].restitution) * (rate + byTime)) / gain;
    for (let i = 0; i < nv; i++) y[nq + i] -= impulse * W[i];
    // the energy that it takes counts as work done
    y[nq + nv] -= (impulse * (rate + dot(y.slice(nq, nq + nv), n))) / 2;
    return true;
  }
}
