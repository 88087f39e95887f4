// Names and values written over the picture, each at a point that moves.

import { turn } from "./unpack.js";
import { measure } from "./arrows.js";

export class Labels {
  constructor(stage, layer, scene, arrows) {
    this.stage = stage;
    this.layer = layer;
    this.arrows = arrows;
    this.bodies = scene.bodies.map((body, b) => {
      const box = stage.boxes[b];
      const middle = box ? box.getCenter(new stage.three.Vector3()).toArray() : [0, 0, 0];
      return box && { b, at: middle, mark: this.mark(body.name, "body") };
    });
    this.joints = scene.joints.map((joint) => ({ b: joint.body, at: joint.point, mark: this.mark(joint.name, "joint") }));
    this.forces = arrows.items.map((item) => ({ item, mark: this.mark("", "force") }));
    this.axes = ["x", "y", "z"].map((name, i) => ({ i, mark: this.mark(name, "axis") }));
    this.shown = { bodies: false, joints: false, values: false };
  }

  mark(text, kind) {
    const mark = document.createElement("span");
    mark.className = `label ${kind}`;
    mark.dir = "auto";
    mark.textContent = text.length > 40 ? text.slice(0, 39) + "…" : text;
    this.layer.append(mark);
    return mark;
  }

  put(mark, on, point) {
    const place = on ? this.stage.project(point) : null;
    mark.hidden = !place;
    if (place) mark.style.transform = `translate(${place[0].toFixed(1)}px, ${place[1].toFixed(1)}px)`;
  }

  pose(row) {
    const world = ({ b, at }) => {
      const o = 7 * b;
      const moved = turn(row.subarray(o + 3, o + 7), at);
      return [row[o] + moved[0], row[o + 1] + moved[1], row[o + 2] + moved[2]];
    };
    for (const each of this.bodies)
      if (each) this.put(each.mark, this.shown.bodies && this.stage.nodes[each.b].visible, world(each));
    for (const each of this.joints)
      this.put(each.mark, this.shown.joints && this.stage.nodes[each.b].visible, world(each));
    for (const { item, mark } of this.forces) {
      const on = this.shown.values && item.group.visible;
      if (on) mark.textContent = `${item.name} ${measure(item.strength, 3)} ${item.unit}`;
      this.put(mark, on, on ? item.tip.toArray() : null);
    }
    for (const { i, mark } of this.axes) {
      const point = [0, 0, 0];
      point[i] = 1.22 * this.stage.axisLength;
      this.put(mark, this.stage.axes.visible, point);
    }
  }
}
