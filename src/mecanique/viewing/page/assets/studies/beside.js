// A second motion from another start: what it starts with, and how the two part.

import { measure } from "../data/numbers.js";

const DISTANCE = "log₁₀ of the distance";
const PARTED = 1000; // times the first distance: the motions have parted

// Whether there is a second motion that has not ended at a row.
const goesOn = ({ other }, k) => other && other.time(k) <= other.path.last;

// Distance of the states of two motions at each row.
export function apart(table, k, columns) {
  if (!goesOn(table, k)) return NaN;
  return Math.hypot(...columns.map((j) => table.value(k, j) - table.other.value(k, j)));
}

// The columns of a row that hold coordinates and velocities.
const stateColumns = (scene, layout) =>
  scene.series.flatMap((each, i) =>
    ["Coordinates", "Velocities"].includes(each.group) ? [layout.series + i] : [],
  );

// What can be plotted of a second motion: how far it is from the first, and its coordinates.
export function quantitiesBeside(scene, layout) {
  if (!scene.engine) return [];
  const columns = stateColumns(scene, layout);
  const list = columns.flatMap((column) => {
    const { name, unit, group } = scene.series[column - layout.series];
    if (group !== "Coordinates") return [];
    const text = `${name}, second`;
    const value = (data, k) => (goesOn(data, k) ? data.other.value(k, column) : NaN);
    return [{ name: text, text, unit, group: "Second motion", value }];
  });
  const text = DISTANCE;
  const value = (data, k) => Math.log10(Math.max(apart(data, k, columns), 1e-17));
  return [{ name: text, text, unit: "", group: "Second motion", value }, ...list];
}

// In words: how far the motions are apart at the end, and when they had parted.
export function describeParting(table, columns) {
  const first = apart(table, 0, columns);
  let end = table.n;
  while (!goesOn(table, end - 1)) end -= 1;
  const last = apart(table, end - 1, columns);
  let parted = 0;
  while (parted < end && apart(table, parted, columns) < PARTED * first) parted += 1;
  const begun = `The starts are ${measure(first, 2)} apart, the ends ${measure(last, 2)}`;
  if (parted === end) return `${begun}.`;
  return `${begun}; after ${table.time(parted).toFixed(2)} s the distance has grown ${PARTED} times.`;
}

export class Beside {
  constructor(setup, scene, layout, plots) {
    Object.assign(this, { setup, plots });
    this.distance = plots.list.find(({ text }) => text === DISTANCE).id;
    this.columns = stateColumns(scene, layout);
    const find = (id) => document.getElementById(id);
    this.names = find("beside-name");
    this.by = find("beside-by");
    this.off = find("beside-off");
    this.told = find("beside-told");
    for (const name of setup.bench.machine.names) this.names.append(new Option(name, name));
    find("beside-on").onclick = () => this.set(Number(this.by.value));
    this.off.onclick = () => {
      const names = Object.keys(setup.bench.neighbor);
      setup.change(names.map((name) => ["beside", name, 0]));
    };
    this.names.onchange = () => this.showDifference();
  }

  set(by) {
    this.setup.change([["beside", this.names.value, by]]);
  }

  // By how much the chosen number differs, where it does.
  showDifference() {
    const by = this.setup.bench.neighbor?.[this.names.value];
    if (by !== undefined && document.activeElement !== this.by) this.by.value = by;
  }

  // After every motion: shows which second one there is.
  show(table) {
    const { neighbor } = this.setup.bench;
    // with a second motion comes the plot of the distance
    const shown = !this.off.disabled;
    if (shown !== Boolean(neighbor)) {
      const { chosen } = this.plots;
      const others = [...chosen].filter((id) => id !== this.distance);
      this.plots.choose(neighbor ? [...others, this.distance] : others);
    }
    this.off.disabled = !neighbor;
    if (neighbor && !(this.names.value in neighbor)) [this.names.value] = Object.keys(neighbor);
    this.showDifference();
    this.told.textContent = table?.other ? describeParting(table, this.columns) : "";
  }
}
