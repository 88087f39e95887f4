// Sections after Poincaré in the plots: points gathered a little in every picture.

import { Section } from "../engine/section.js";

const BUDGET = 24; // of a picture [ms]

export class Sections {
  constructor(setup, plots, scene, layout) {
    Object.assign(this, { setup, plots });
    this.select = document.getElementById("plot-at");
    this.label = this.select.closest("label");
    this.label.hidden = false;
    const { machine } = setup.bench;
    machine.names.forEach((name, k) => this.select.append(new Option(`${name} = 0, rising`, k)));
    this.turning = machine.names.map((name) =>
      scene.series.some((each) => each.name === name && each.unit === "rad"),
    );
    this.angles = scene.series.flatMap((each, i) =>
      each.unit === "rad" && each.group === "Coordinates" ? [layout.series + i] : [],
    );
    this.select.onchange = () => this.choose();
  }

  choose() {
    const watched = this.select.value === "" ? -1 : Number(this.select.value);
    if (watched >= 0) this.suggest(watched);
    this.begin(watched);
  }

  // Another coordinate and its velocity, where nothing is chosen to be plotted over.
  suggest(watched) {
    const { plots } = this;
    if (plots.over >= 0) return;
    const { engine, nq } = this.setup.bench.machine;
    const other = engine.coordinates.findIndex((_, k) => k !== watched && k !== watched - nq);
    const name = engine.coordinates[Math.max(other, 0)];
    const find = (wanted) => plots.list.find((each) => each.name === wanted);
    const [x, y] = [find(name), find(`${name}'`)];
    if (!x || !y) return;
    plots.setOver(x.id);
    plots.choose([y.id]);
  }

  begin(watched = this.watched) {
    this.watched = watched;
    const on = watched >= 0;
    this.section = on ? this.compute(watched) : null;
    this.plots.section = this.section;
    this.plots.draw();
  }

  compute(watched) {
    const { turning, angles } = this;
    return new Section(this.setup.computed(), watched, turning[watched], angles);
  }

  // Another motion has another section.
  show() {
    if (this.section) this.begin();
  }

  // Called once a picture.
  extend() {
    const { section } = this;
    if (!section || section.done) return;
    const until = performance.now() + BUDGET;
    let found = false;
    while (!section.done && performance.now() < until) found = section.extend() || found;
    if (found) this.plots.draw();
  }
}
