// The mechanism in flat colors, which moves until the viewer, whose own start takes several times as
// long, has drawn its first picture.

import { dot } from "../data/vectors.js";
import { aim, FIELD, frame, matrixOf, room } from "./framing.js";
import { boxAround, solidOf } from "./solids.js";

export const SAMPLES = 240; // instants of a motion that are looked at to frame it
const TURNS = 9; // of a spring
export const UNSEEN = 300; // a page that has no picture after that is in the background [ms]
const GRAY = "#66707c";

// The points around all others, in order.
export function hull(points) {
  const sorted = [...points].sort((a, b) => a[0] - b[0] || a[1] - b[1]);
  const side = (a, b, c) => (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
  const chain = (list) => {
    const kept = [];
    for (const point of list) {
      while (kept.length > 1 && side(kept.at(-2), kept.at(-1), point) <= 0) kept.pop();
      kept.push(point);
    }
    return kept.slice(0, -1);
  };
  return [...chain(sorted), ...chain(sorted.reverse())];
}

// From where the mechanism is seen: a point of the world to pixels, and how far it is.
export function lens({ target, right, up, toEye, distance }, { w, h, shift }) {
  const scale = h / 2 / Math.tan((FIELD * Math.PI) / 360);
  return (point) => {
    const d = point.map((x, i) => x - target[i]);
    const far = distance - dot(d, toEye);
    const size = scale / far;
    return [w / 2 + size * dot(d, right), h / 2 + shift - size * dot(d, up), far, size];
  };
}

export class Sketch {
  constructor(canvas, scene, layout, table, clock) {
    Object.assign(this, { canvas, scene, layout, table, clock, next: null, waiting: [] });
    this.bodies = scene.bodies.map(({ solids }) => solids.map(solidOf));
    // drawn by the processor itself, which need not wait for a graphics card
    this.pen = canvas.getContext("2d", { willReadFrequently: true });
    const count = scene.bodies.length;
    this.row = new Float64Array(layout.series); // bodies and lines alone
    const rows = table.sample(SAMPLES, count, layout.series);
    this.box = frame(this.bodies.map(boxAround), rows, layout, scene).box;
    canvas.hidden = false;
    this.fit();
    this.draw();
  }

  fit() {
    const { canvas, pen, scene } = this;
    const pane = canvas.parentElement;
    const here = room(pane);
    const ratio = devicePixelRatio;
    [canvas.width, canvas.height] = [here.w * ratio, here.h * ratio];
    pen.scale(ratio, ratio);
    pen.lineJoin = "round";
    const view = aim(scene.planar ? "front" : "free", this.box, {
      aspect: here.w / here.h,
      share: here.share,
    });
    this.see = lens(view, here);
  }

  // Goes on until the viewer has a picture.
  play() {
    this.clock.play();
    if (this.clock.playing) this.step();
  }

  step() {
    this.next = requestAnimationFrame((now) => {
      this.clock.tick(now);
      this.draw();
      if (this.clock.time > this.clock.first) this.told();
      this.step();
    });
  }

  // The picture must be on the screen before what waits for it begins.
  told() {
    if (!performance.getEntriesByName("moving").length) performance.mark("moving");
    for (const done of this.waiting.splice(0)) setTimeout(done);
  }

  // When another picture of the motion has been drawn; at once where there is none to come.
  moved() {
    if (!this.next) return null;
    return new Promise((done) => {
      this.waiting.push(done);
      setTimeout(() => this.waiting.includes(done) && this.end(), UNSEEN);
    });
  }

  draw() {
    const { canvas, pen, table, clock, row, bodies } = this;
    table.row(clock.time, bodies.length, row);
    pen.clearRect(0, 0, canvas.width, canvas.height);
    const pieces = bodies.flatMap((solids, b) =>
      this.project(solids, row.subarray(7 * b, 7 * b + 7)),
    );
    for (const piece of pieces.sort((a, b) => b.far - a.far)) this.fill(piece);
    this.scene.lines.forEach(({ kind }, k) => this.stroke(kind, this.layout.lines + 6 * k));
  }

  project(solids, [x, y, z, ...turn]) {
    const m = matrixOf(...turn);
    const at = [x, y, z];
    const put = (p) =>
      this.see(at.map((o, i) => o + m[3 * i] * p[0] + m[3 * i + 1] * p[1] + m[3 * i + 2] * p[2]));
    return solids.map(({ points, radius, color, opacity }) => {
      const seen = points.map(put);
      const far = seen.reduce((sum, point) => sum + point[2], 0) / seen.length;
      return { seen, far, radius: radius * seen[0][3], color, opacity };
    });
  }

  fill({ seen, radius, color, opacity }) {
    const { pen } = this;
    pen.beginPath();
    if (radius) pen.arc(seen[0][0], seen[0][1], radius, 0, 2 * Math.PI);
    else for (const [x, y] of hull(seen)) pen.lineTo(x, y);
    pen.closePath();
    pen.globalAlpha = opacity;
    pen.fillStyle = color;
    pen.fill();
    pen.globalAlpha = 1;
  }

  // Springs go to and fro, dampers and rods straight.
  stroke(kind, column) {
    const { pen, row } = this;
    const [a, b] = [column, column + 3].map((o) => this.see([...row.subarray(o, o + 3)]));
    const [dx, dy] = [b[0] - a[0], b[1] - a[1]];
    const length = Math.hypot(dx, dy) || 1;
    const wide = kind === "spring" ? 0.022 * a[3] * Math.hypot(...this.sides()) : 0;
    pen.beginPath();
    pen.moveTo(a[0], a[1]);
    for (let k = 1; k < 2 * TURNS; k++) {
      const [part, off] = [k / (2 * TURNS), (k % 2 ? wide : -wide) / length];
      pen.lineTo(a[0] + part * dx - off * dy, a[1] + part * dy + off * dx);
    }
    pen.lineTo(b[0], b[1]);
    pen.strokeStyle = GRAY;
    pen.lineWidth = kind === "spring" ? 1.5 : 3;
    pen.stroke();
  }

  sides() {
    return this.box.high.map((x, i) => x - this.box.low[i]);
  }

  // The viewer has a picture.
  end() {
    cancelAnimationFrame(this.next);
    this.next = null;
    this.canvas.remove();
    this.told();
  }
}
