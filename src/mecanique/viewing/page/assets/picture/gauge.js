// How long forces are drawn: those that are shown share one linear scale, or each kind has its own.

import { measure } from "../data/numbers.js";

const LONGEST = { N: 0.28, "N·m": 0.1 }; // of the scene: a force's length, a moment's radius
const USUAL = 0.9; // of the time a force is no larger than it usually is
const PEAK = 1.25; // times that is drawn; what is larger is cut, and marked as cut

export class Gauge {
  constructor(items) {
    this.items = items;
    this.common = true;
    this.factor = 1;
    this.reaches = new Map();
    for (const item of items) Object.assign(item, { greatest: 0, usual: 0 });
  }

  survey(table) {
    const sizes = new Float64Array(table.n);
    for (const item of this.items) {
      const columns = [3, 4, 5].map((i) => item.column + i);
      for (let k = 0; k < table.n; k++)
        sizes[k] = Math.hypot(...columns.map((j) => table.value(k, j)));
      sizes.sort();
      item.greatest = sizes[table.n - 1];
      item.usual = sizes[Math.floor(USUAL * (table.n - 1))];
    }
  }

  // A stream tells the largest only as it comes.
  learn(row) {
    for (const item of this.items) {
      const [x, y, z] = row.subarray(item.column + 3, item.column + 6);
      item.greatest = Math.max(item.greatest, Math.hypot(x, y, z));
      item.usual = Math.max(item.usual, item.greatest / PEAK);
    }
  }

  // The forces that are shown decide: the largest of them is as long as any.
  fit(shown) {
    this.reaches.clear();
    for (const item of this.items) {
      if (!shown(item)) continue;
      const reach = item.usual ? Math.min(item.greatest, PEAK * item.usual) : item.greatest;
      this.reaches.set(this.key(item), Math.max(reach, this.reaches.get(this.key(item)) ?? 0));
    }
  }

  key({ kind, unit }) {
    return this.common ? unit : `${kind} ${unit}`;
  }

  // The part of the longest that a force takes up; beyond 1 it is cut.
  share(item, strength) {
    const reach = this.reaches.get(this.key(item));
    return reach ? strength / reach : 0;
  }

  length(item, strength, size) {
    return LONGEST[item.unit] * size * this.factor * Math.min(1, this.share(item, strength));
  }

  // The scale in words.
  describe(size, kinds) {
    const parts = [];
    for (const [key, reach] of this.reaches) {
      if (!(reach > 0)) continue;
      const unit = key.split(" ").pop();
      const whose = this.common ? "" : `${kinds[key.split(" ")[0]].label}: `;
      const what = unit === "N" ? "" : "radius ";
      const perMeter = measure(reach / (LONGEST[unit] * size * this.factor), 3);
      parts.push(`${whose}${what}1 m ≙ ${perMeter} ${unit}`);
    }
    return parts.join(" · ");
  }
}
