// A spring from a point of a body to the hand that pulls it, while the mechanism moves: stiff enough
// to be felt whatever the body weighs, damped so that it comes to rest.

import { dot, subtract } from "../data/vectors.js";
import { Grip } from "./grip.js";

const STIFFNESS = 40; // per mass that the point shows along the spring [1/s²]
const DRAG = 6; // [1/s]
const LONGEST_FRAME = 0.05; // of a frame [s]
const PARTS = 4; // of a frame, over each of which the pull is constant

export class Pull {
  constructor(computed, t, state, body, point) {
    this.grip = new Grip(computed, t, state, body, point);
    Object.assign(this, { computed, machine: computed.machine, t });
    this.y = Float64Array.from(state);
    this.target = this.grip.at(this.y);
  }

  get place() {
    return this.grip.at(this.y);
  }

  // Lets so much time pass.
  advance(seconds) {
    const { machine, computed } = this;
    const part = Math.min(seconds, LONGEST_FRAME) / PARTS;
    const { setting } = computed;
    for (let k = 0; k < PARTS && part > 0; k++) {
      machine.force = this.force();
      try {
        const gentle = { ...setting, first: this.t, rtol: Math.max(setting.rtol, 1e-8) };
        const path = machine.move(gentle, this.y, this.t + part);
        this.corners = path.corners;
        // at a limit it is held
        if (path.stopped) this.rest();
        else path.at(path.last, this.y);
      } catch {
        this.rest(); // where friction determines no motion
      } finally {
        machine.force = null;
      }
      this.t += part;
    }
    return this.y;
  }

  rest() {
    const { nq, nv } = this.machine;
    this.y.fill(0, nq, nq + nv);
  }

  // Generalized forces of the spring, Jᵀ F.
  force() {
    const { grip, machine, y, target } = this;
    const { nq, nv, program } = machine;
    grip.t = this.t;
    const columns = grip.columns(y);
    const place = grip.at(y);
    const arm = subtract(target, place);
    const distance = Math.hypot(...arm);
    const force = new Float64Array(nv + 1);
    if (!(distance > 0)) return force;
    const along = arm.map((x) => x / distance);
    const unit = new Float64Array(nv + 1);
    columns.forEach((each, k) => (unit[k] = dot(each, along)));
    const slopes = (push) => {
      const out = new Float64Array(y.length);
      program.rates(this.t, y, grip.p, out, push);
      return out;
    };
    const [rest, pushed] = [slopes(null), slopes(unit)];
    let [gain, speed] = [0, 0];
    for (let k = 0; k < nv; k++) {
      gain += unit[k] * (pushed[nq + k] - rest[nq + k]);
      speed += unit[k] * y[nq + k];
    }
    if (!(gain > 0)) return force;
    const size = (STIFFNESS * distance - DRAG * speed) / gain;
    return unit.map((x) => size * x);
  }
}
