// Names and values written over the picture, each at a point that moves.

import { turn } from "../data/unpack.js";
import { measure } from "../data/numbers.js";
import { make } from "../panels/elements.js";

const LINE = 22; // from one label to the next below it [px]

export class Labels {
  constructor(stage, layer, scene, arrows) {
    this.stage = stage;
    this.layer = layer;
    this.arrows = arrows;
    this.bodies = scene.bodies.map((body, b) => {
      const box = stage.boxes[b];
      if (!box) return null;
      const at = box.getCenter(new stage.three.Vector3()).toArray();
      const half = box.getSize(new stage.three.Vector3()).multiplyScalar(0.5).toArray();
      return { b, at, half, mark: this.mark(body.name, "body") };
    });
    this.joints = scene.joints.map((joint) => ({
      b: joint.body,
      at: joint.point,
      mark: this.mark(joint.name, "joint"),
    }));
    this.forces = arrows.items.map((item) => ({ item, mark: this.mark("", "force") }));
    this.compass = document.getElementById("compass");
    this.shown = { bodies: false, joints: false, values: false };
  }

  mark(text, kind) {
    const short = text.length > 40 ? text.slice(0, 39) + "…" : text;
    const mark = make("span", { className: `label ${kind}`, dir: "auto" }, short);
    this.layer.append(mark);
    return mark;
  }

  put(mark, on, point) {
    const place = on ? this.stage.project(point) : null;
    mark.hidden = !place;
    if (!place) return;
    const wide = 7 * mark.textContent.length + 12;
    const left = mark.classList.contains("body") ? place[0] - wide / 2 : place[0];
    const top = this.free(left, place[1], wide);
    const middle = mark.classList.contains("body") ? " translateX(-50%)" : "";
    mark.style.transform = `translate(${place[0].toFixed(1)}px, ${top.toFixed(1)}px)${middle}`;
  }

  // The next height at which a label covers none that was put before it.
  free(left, top, wide) {
    const covers = (other) =>
      Math.abs(other.top - top) < LINE &&
      left < other.left + other.wide &&
      other.left < left + wide;
    for (let tries = 0; tries < 8 && this.taken.some(covers); tries++) top += LINE;
    this.taken.push({ left, top, wide });
    return top;
  }

  // The middle of a body, raised to its top.
  above(row, { b, half }, middle) {
    const o = 7 * b;
    const q = row.subarray(o + 3, o + 7);
    const axes = [
      [half[0], 0, 0],
      [0, half[1], 0],
      [0, 0, half[2]],
    ];
    const height = axes.reduce((sum, axis) => sum + Math.abs(turn(q, axis)[2]), 0);
    return [middle[0], middle[1], middle[2] + Math.min(height, 0.06 * this.stage.size)];
  }

  pose(row) {
    this.taken = [];
    const world = ({ b, at }) => {
      const o = 7 * b;
      const moved = turn(row.subarray(o + 3, o + 7), at);
      return [row[o] + moved[0], row[o + 1] + moved[1], row[o + 2] + moved[2]];
    };
    for (const each of this.bodies) {
      if (!each) continue;
      const on = this.shown.bodies && this.stage.nodes[each.b].visible;
      this.put(each.mark, on, this.above(row, each, world(each)));
    }
    for (const each of this.joints)
      this.put(each.mark, this.shown.joints && this.stage.nodes[each.b].visible, world(each));
    for (const { item, mark } of this.forces) {
      const on = this.shown.values && item.group.visible;
      if (on) mark.textContent = `${item.name} ${measure(item.strength, 3)} ${item.unit}`;
      this.put(mark, on, on ? item.tip.toArray() : null);
    }
    this.point();
  }

  // The world's axes in the corner; the farthest is drawn first.
  point() {
    const order = this.stage.directions().map((d, i) => ({ d, i }));
    order.sort((a, b) => a.d[2] - b.d[2]);
    for (const { d, i } of order) {
      const arm = this.compass.querySelector(`.arm-${"xyz"[i]}`);
      const [x, y] = [30 * d[0], -30 * d[1]];
      arm.querySelector("line").setAttribute("x2", x);
      arm.querySelector("line").setAttribute("y2", y);
      arm.querySelector("text").setAttribute("x", 1.33 * x);
      arm.querySelector("text").setAttribute("y", 1.33 * y + 4);
      arm.style.opacity = Math.hypot(d[0], d[1]) < 0.25 ? 0 : 1;
      this.compass.append(arm);
    }
  }
}
