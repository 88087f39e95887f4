// Energies as bars over the picture, and what the energy is at the start, in a common scale.

import { measure } from "../data/numbers.js";
import { make } from "../panels/elements.js";

const TITLES = { kinetic: "T", potential: "V", total: "T + V" };

export class EnergyBars {
  constructor(scene, layout) {
    this.holder = document.getElementById("energies");
    const at = (name) => scene.series.findIndex((each) => each.name === `energy ${name}`);
    this.columns = Object.keys(TITLES).map((name) => [name, layout.series + at(name), at(name)]);
    this.known = this.columns.every(([, , found]) => found >= 0);
    this.bars = Object.entries(TITLES).map(([name, title]) => {
      const fill = make("b", { className: name });
      const value = make("output");
      this.holder.append(make("div", {}, make("span", {}, title), make("i", {}, fill), value));
      return { fill, value };
    });
  }

  // Takes the largest energies of a motion as the scale; potential energy counts from its least.
  survey(table) {
    const [kinetic, potential] = this.columns.map(([, column]) => column);
    let [most, low, high] = [0, Infinity, -Infinity];
    const every = Math.max(1, Math.floor(table.n / 400));
    for (let k = 0; k < table.n; k += every) {
      most = Math.max(most, table.value(k, kinetic));
      const V = table.value(k, potential);
      [low, high] = [Math.min(low, V), Math.max(high, V)];
    }
    Object.assign(this, { least: low, size: Math.max(most, high - low) || 1 });
  }

  turn(on) {
    this.holder.hidden = !on;
  }

  // Called for every picture.
  show(row) {
    if (this.holder.hidden || !this.known) return;
    const values = this.columns.map(([, column]) => row[column]);
    const heights = [values[0], values[1] - this.least, values[2] - this.least];
    this.bars.forEach(({ fill, value }, k) => {
      const share = Math.min(1, Math.max(0, heights[k] / (1.02 * this.size)));
      fill.style.width = `${(100 * share).toFixed(1)}%`;
      value.textContent = `${measure(values[k], 3)} J`;
    });
  }
}
