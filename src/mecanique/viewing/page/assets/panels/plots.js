// Plots of any quantity over time: one chart for each unit, a cursor on the clock, zoom, CSV.

import { measure } from "../data/numbers.js";
import { isNothing, rangeOf } from "../data/scales.js";
import { MARGIN, drawAxes, stack, svg } from "./drawing.js";
import { make, swatch } from "./elements.js";
import { drawPhase } from "./phase.js";
import { save } from "./tabs.js";

const COLORS = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9"];
const HEIGHT = 168;

// Everything that can be plotted: the scene's series, then each arrow's length and components.
export function quantities(scene, layout, more = []) {
  const list = scene.series.map((series, i) => {
    const column = layout.series + i;
    return {
      ...series,
      group: series.group || "Quantities",
      value: (data, k) => data.value(k, column),
    };
  });
  scene.arrows.forEach((arrow, i) => {
    const column = layout.arrows + 6 * i + 3;
    const title = arrow.unit === "N" ? "Forces" : "Moments";
    const part = (name, value) =>
      list.push({ name, text: name, unit: arrow.unit, group: title, shown: false, value });
    part(`|${arrow.name}|`, (data, k) =>
      Math.hypot(...[0, 1, 2].map((c) => data.value(k, column + c))),
    );
    ["x", "y", "z"].forEach((axis, c) =>
      part(`${arrow.name}, ${axis}`, (data, k) => data.value(k, column + c)),
    );
  });
  return [...list, ...more].map((each, id) => ({ ...each, id }));
}

export class Plots {
  constructor(data, clock, list, fileName) {
    Object.assign(this, { data, clock, list, fileName });
    this.holder = document.getElementById("charts");
    this.chosen = new Set(list.filter((each) => each.shown).map((each) => each.id));
    if (!this.chosen.size && list.length) this.chosen.add(0);
    this.range = null;
    this.width = 0;
    // an angle has a scale of its own; other units have that of the largest quantity
    this.peaks = new Map([["rad", 1]]);
    this.unknown = true;
    this.buildPicker();
    document.getElementById("zoom-in").onclick = () => this.zoom(0.5);
    document.getElementById("zoom-out").onclick = () => this.zoom(2);
    document.getElementById("zoom-all").onclick = () => this.setRange(null);
    document.getElementById("csv").onclick = () => save(`${fileName}.csv`, this.csv(), "text/csv");
    document.getElementById("svg").onclick = () =>
      save(`${fileName}.svg`, stack(this.charts), "image/svg+xml");
    const over = document.getElementById("plot-x");
    for (const { id, text, unit } of list)
      over.append(new Option(unit ? `${text} [${unit}]` : text, id));
    over.onchange = () => this.setOver(over.value === "" ? -1 : Number(over.value));
    this.wirePhase(document.getElementById("portrait"));
    this.folding = document.getElementById("fold");
    this.folding.onchange = () => this.draw();
    this.over = -1;
    this.section = null; // the states of a section, where one is shown
    this.holder.closest("[role=tabpanel]").addEventListener("opened", () => this.refresh());
    new ResizeObserver(() => this.resize()).observe(this.holder);
  }

  // Shows another motion.
  take(data) {
    this.data = data;
    this.range = null;
    const size = this.peaks.get("m");
    this.peaks = new Map([["rad", 1], ...(size ? [["m", size]] : [])]);
    this.unknown = true;
    this.refresh();
  }

  // Draws anew if the panel is wider or narrower than what is drawn.
  resize() {
    if (this.holder.clientWidth !== this.width) this.refresh();
  }

  // Draws anew if the plots are seen; when their panel is opened, they are drawn.
  refresh() {
    if (this.holder.closest(".off")) Object.assign(this, { charts: [], unknown: true });
    else this.draw();
  }

  setOver(id) {
    this.over = id;
    document.getElementById("plot-x").value = id < 0 ? "" : String(id);
    this.folding.parentElement.hidden = this.list[id]?.unit !== "rad";
    this.draw();
  }

  // A coordinate's rate over it; a further press shows the next coordinate, then time again.
  wirePhase(button) {
    const pairs = this.list.flatMap((angle) => {
      const rate = this.list.find(({ name }) => name === `${angle.name}'`);
      return angle.group === "Coordinates" && rate ? [[angle.id, rate.id]] : [];
    });
    button.hidden = !pairs.length;
    button.onclick = () => {
      const [place, rate] = pairs[pairs.findIndex(([id]) => id === this.over) + 1] ?? [-1];
      this.before ??= [...this.chosen];
      this.setOver(place);
      this.choose(rate === undefined ? this.before : [rate]);
      if (rate === undefined) this.before = null;
    };
  }

  // Whether what lies across is an angle that starts anew after each turn.
  folds({ unit }) {
    return unit === "rad" && this.folding.checked;
  }

  // Shows some quantities and no others.
  choose(ids) {
    this.chosen = new Set(ids);
    for (const [id, box] of this.boxes) box.checked = this.chosen.has(id);
    this.draw();
  }

  buildPicker() {
    this.boxes = new Map();
    const picker = document.getElementById("picker");
    const groups = new Map();
    for (const each of this.list) {
      if (!groups.has(each.group)) {
        const set = make("fieldset", {}, make("legend", {}, each.group));
        groups.set(each.group, set);
        picker.append(set);
      }
      const box = make("input", { type: "checkbox", checked: this.chosen.has(each.id) });
      box.onchange = () => {
        if (box.checked) this.chosen.add(each.id);
        else this.chosen.delete(each.id);
        this.draw();
      };
      this.boxes.set(each.id, box);
      const unit = each.unit ? ` [${each.unit}]` : "";
      groups.get(each.group).append(make("label", {}, box, this.caption(each), unit));
    }
  }

  // Labels come from the page's maker, which lets MathML through and nothing else.
  caption(each) {
    const text = each.html ? { innerHTML: each.html } : { textContent: each.text };
    return make("span", { dir: "auto", ...text });
  }

  survey() {
    this.unknown = false;
    for (let k = 0; k < this.data.n; k += Math.ceil(this.data.n / 200)) this.learn(k);
  }

  // Takes note of the largest quantity of each unit: what is nothing beside it is drawn as nothing.
  learn(k) {
    for (const { unit, value } of this.list) {
      const size = Math.abs(value(this.data, k));
      if (size > (this.peaks.get(unit) ?? 0)) this.peaks.set(unit, size);
    }
  }

  // At the start of a stream there is room for what is to come.
  span() {
    const { first, last, room = 1e-6 } = this.clock;
    return this.range ?? [first, Math.max(last, first + room)];
  }

  setRange(range) {
    const { first, last } = this.clock;
    if (range) range = [Math.max(first, range[0]), Math.min(last, range[1])];
    this.range = range && range[1] - range[0] < last - first ? range : null;
    this.draw();
  }

  zoom(factor, around = this.clock.time) {
    const [a, b] = this.span();
    const middle = Math.min(b, Math.max(a, around));
    this.setRange([middle - (middle - a) * factor, middle + (b - middle) * factor]);
  }

  draw() {
    if (this.unknown) this.survey();
    else if (this.data.n) this.learn(this.data.n - 1);
    const width = (this.width = Math.max(this.holder.clientWidth, 200));
    const units = new Map();
    let order = 0;
    for (const each of this.list)
      if (this.chosen.has(each.id)) {
        const color = COLORS[order % COLORS.length];
        const dash = ["", "6 3", "2 2"][Math.floor(order / COLORS.length) % 3];
        if (!units.has(each.unit)) units.set(each.unit, []);
        units.get(each.unit).push({ ...each, color, dash });
        order += 1;
      }
    this.charts = [...units].map(([unit, members]) => this.chart(unit, members, width));
    this.holder.replaceChildren(...this.charts.map((chart) => chart.figure));
    this.follow(true);
  }

  chart(unit, members, width) {
    const readings = members.map(() => make("output"));
    const entries = members.map((each, k) =>
      make("span", {}, swatch(each.color), this.caption(each), " = ", readings[k]),
    );
    const over = this.list[this.over];
    const drawn = over
      ? drawPhase(this, over, members, width)
      : this.overTime(unit, members, width);
    const figure = make("figure", {}, make("figcaption", {}, ...entries), drawn.picture);
    return { ...drawn, figure, members, readings };
  }

  overTime(unit, members, width) {
    const [a, b] = this.span();
    const inner = width - MARGIN.left - MARGIN.right;
    const sx = (t) => MARGIN.left + ((t - a) / (b - a)) * inner;
    const paths = members.map((each) => this.samples(each, a, b, Math.floor(inner)));
    let [low, high] = [Infinity, -Infinity];
    for (const path of paths)
      for (const [, y] of path) [low, high] = [Math.min(low, y), Math.max(high, y)];
    [low, high] = rangeOf(low, high, this.peaks.get(unit) ?? 0);
    const bottom = HEIGHT - MARGIN.bottom;
    const sy = (y) => MARGIN.top + ((high - y) / (high - low)) * (bottom - MARGIN.top);
    const label = `${members.map((each) => each.text).join(", ")} over time`;
    const attributes = { viewBox: `0 0 ${width} ${HEIGHT}`, role: "img", "aria-label": label };
    const picture = svg("svg", attributes);
    drawAxes(picture, { from: a, to: b, at: sx }, { from: low, to: high, at: sy }, "t [s]");
    paths.forEach((path, i) => {
      const points = path.map(([t, y]) => `${sx(t).toFixed(1)},${sy(y).toFixed(1)}`).join(" ");
      const { color, dash } = members[i];
      svg("polyline", { class: "curve", points, stroke: color, "stroke-dasharray": dash }, picture);
    });
    const cursor = svg("line", { class: "cursor", y1: MARGIN.top, y2: bottom }, picture);
    const dots = members.map(({ color }) =>
      svg("circle", { class: "dot", r: 4, fill: color }, picture),
    );
    this.listen(picture, (x) => a + ((x - MARGIN.left) / inner) * (b - a), width);
    const move = (t) => {
      const inside = t >= a && t <= b;
      for (const mark of [cursor, ...dots]) mark.style.display = inside ? "" : "none";
      cursor.setAttribute("x1", sx(t));
      cursor.setAttribute("x2", sx(t));
      dots.forEach((dot, i) => {
        const y = this.at(members[i], t);
        if (Number.isNaN(y)) return;
        dot.setAttribute("cx", sx(t));
        dot.setAttribute("cy", sy(y));
      });
    };
    return { picture, move, cursor, sx, sy };
  }

  // At most two points a pixel: the least and the greatest of what falls there.
  samples({ value }, a, b, pixels) {
    const { data } = this;
    const from = Math.max(0, Math.floor(data.index(a)));
    const to = Math.min(data.n - 1, Math.ceil(data.index(b)));
    const bin = Math.max(1, Math.floor((to - from + 1) / (2 * Math.max(pixels, 50))));
    const path = [];
    for (let k = from; k <= to; k += bin) {
      let [low, high] = [k, k];
      for (let i = k; i < Math.min(k + bin, to + 1); i++) {
        if (value(data, i) < value(data, low)) low = i;
        if (value(data, i) > value(data, high)) high = i;
      }
      for (const i of low === high ? [low] : [Math.min(low, high), Math.max(low, high)])
        if (!Number.isNaN(value(data, i))) path.push([data.time(i), value(data, i)]);
    }
    return path;
  }

  listen(picture, timeAt, width) {
    const time = (event) => {
      const box = picture.getBoundingClientRect();
      return timeAt(((event.clientX - box.left) / box.width) * width);
    };
    let from = null;
    picture.onpointerdown = (event) => {
      picture.setPointerCapture(event.pointerId);
      from = { time: time(event), zooming: event.shiftKey };
      if (!from.zooming) this.seek(time(event));
    };
    picture.onpointermove = (event) => from && !from.zooming && this.seek(time(event));
    picture.onpointerup = (event) => {
      const to = time(event);
      if (from?.zooming && to !== from.time)
        this.setRange([Math.min(from.time, to), Math.max(from.time, to)]);
      from = null;
    };
    picture.ondblclick = () => this.setRange(null);
    picture.onwheel = (event) => {
      if (!event.ctrlKey && !event.shiftKey) return;
      event.preventDefault();
      this.zoom(event.deltaY + event.deltaX > 0 ? 1.25 : 0.8, time(event));
    };
  }

  seek(t) {
    if (!this.clock.seekable) return;
    this.clock.pause();
    this.clock.seek(t);
  }

  at({ value }, t, data = this.data) {
    if (!data.n) return NaN;
    const x = data.index(t);
    const k = Math.floor(x);
    const low = value(data, k);
    return k + 1 < data.n ? low + (value(data, k + 1) - low) * (x - k) : low;
  }

  follow(anew = false) {
    const t = this.clock.time;
    if (!this.charts || (t === this.followed && !anew)) return;
    this.followed = t;
    for (const { members, readings, move } of this.charts) {
      move(t);
      members.forEach((each, i) => {
        const y = this.at(each, t);
        readings[i].textContent = Number.isNaN(y)
          ? "–"
          : `${isNothing(y, this.peaks.get(each.unit)) ? "0" : measure(y)} ${each.unit}`;
      });
    }
  }

  csv() {
    const chosen = this.list.filter((each) => this.chosen.has(each.id));
    const quote = (text) => `"${text.replaceAll('"', '""').replace(/^([=+\-@\t\r])/, "'$1")}"`;
    const heads = [
      "t [s]",
      ...chosen.map((each) => (each.unit ? `${each.name} [${each.unit}]` : each.name)),
    ];
    const rows = [heads.map(quote).join(",")];
    for (let k = 0; k < this.data.n; k++)
      rows.push(
        [this.data.time(k), ...chosen.map((each) => each.value(this.data, k))]
          .map((x) => +x.toPrecision(7))
          .join(","),
      );
    return rows.join("\r\n") + "\r\n";
  }
}
