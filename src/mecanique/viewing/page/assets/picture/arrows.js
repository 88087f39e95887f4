// Forces as straight arrows, moments as bent ones: which are shown, how long, and their tooltips.

import { Gauge } from "./gauge.js";
import { measure } from "../data/numbers.js";

export const KINDS = {
  weight: { label: "Weight", color: 0x7a3e9d },
  spring: { label: "Springs", color: 0x009e73 },
  damper: { label: "Dampers", color: 0xcc79a7 },
  load: { label: "Loads", color: 0xd55e00 },
  reaction: { label: "Reactions", color: 0xe69f00 },
  inertia: { label: "Inertia (d’Alembert)", color: 0x56b4e9 },
};

export function colorOf(kind) {
  return "#" + KINDS[kind].color.toString(16).padStart(6, "0");
}

// How much larger the rim behind an arrow is.
const HALO = { shaft: [1.8, 1.02, 1.8], head: [1.3, 1.2, 1.3] };

export class Arrows {
  constructor(stage, scene, layout) {
    this.stage = stage;
    this.first = layout.arrows;
    this.kinds = new Set(["weight", "spring", "damper", "load"]);
    this.body = null;
    this.values = false;
    this.items = scene.arrows.map((arrow, i) => this.build(arrow, this.first + 6 * i));
    this.gauge = new Gauge(this.items);
  }

  build(arrow, column) {
    const { Group, Mesh, MeshLambertMaterial, CylinderGeometry, ConeGeometry, TorusGeometry } =
      this.stage.three;
    const paint = new MeshLambertMaterial({
      color: KINDS[arrow.kind].color,
      emissive: KINDS[arrow.kind].color,
    });
    Object.assign(paint, { emissiveIntensity: 0.35, depthTest: false, transparent: true });
    const r = 0.0055 * this.stage.size;
    const group = new Group();
    const bent = arrow.unit !== "N";
    const ring = (thick) => new TorusGeometry(1, thick, 10, 48, 4.6);
    const shaft = new Mesh(bent ? ring(0.09) : new CylinderGeometry(r, r, 1, 16), paint);
    const head = new Mesh(new ConeGeometry(2.7 * r, 8 * r, 20), paint);
    group.add(shaft, head);
    for (const part of [shaft, head])
      Object.assign(part, { renderOrder: 10, userData: { arrow: column } });
    // a rim around it tells an arrow from a body of its color
    const rims = [
      new Mesh(bent ? ring(0.15) : shaft.geometry, this.stage.rimPaint),
      new Mesh(head.geometry, this.stage.rimPaint),
    ];
    if (!bent) rims[0].scale.set(...HALO.shaft);
    rims[1].scale.set(...HALO.head);
    shaft.add(rims[0]);
    head.add(rims[1]);
    for (const rim of rims) rim.renderOrder = 9;
    const cut = this.buildCut(r);
    group.add(cut);
    this.stage.root.add(group);
    return {
      ...arrow,
      column,
      group,
      shaft,
      head,
      cut,
      bent,
      headLength: 8 * r,
      parts: [shaft, head],
      vector: [0, 0, 0],
    };
  }

  // Two strokes across a shaft: it is not drawn at full length.
  buildCut(r) {
    const { Group, Mesh, CylinderGeometry } = this.stage.three;
    const cut = new Group();
    for (const side of [-1, 1]) {
      const stroke = new Mesh(
        new CylinderGeometry(2.2 * r, 2.2 * r, 0.9 * r, 16),
        this.stage.rimPaint,
      );
      stroke.position.y = 1.3 * r * side;
      stroke.renderOrder = 11;
      cut.add(stroke);
    }
    return cut;
  }

  learn(row) {
    this.gauge.learn(row);
  }

  survey(table) {
    this.gauge.survey(table);
  }

  visible(item) {
    return this.kinds.has(item.kind) && (this.body === null || item.body === this.body);
  }

  pose(row) {
    const { Vector3, Quaternion } = this.stage.three;
    const { size } = this.stage;
    this.gauge.fit((item) => this.visible(item));
    for (const item of this.items) {
      const o = item.column;
      const vector = (item.vector = [row[o + 3], row[o + 4], row[o + 5]]);
      const strength = Math.hypot(...vector);
      item.strength = strength;
      const share = this.gauge.share(item, strength);
      const length = this.gauge.length(item, strength, size);
      item.length = length;
      item.cut.visible = share > 1 + 1e-4;
      item.group.visible = this.visible(item) && share > 1e-6;
      if (!item.group.visible) continue;
      const along = new Vector3(...vector).divideScalar(strength);
      item.group.position.set(row[o], row[o + 1], row[o + 2]);
      const from = item.bent ? new Vector3(0, 0, 1) : new Vector3(0, 1, 0);
      item.group.quaternion.copy(new Quaternion().setFromUnitVectors(from, along));
      if (item.bent) this.bend(item, Math.max(length, 0.015 * size));
      else this.stretch(item, length);
      item.tip = item.group.position.clone().addScaledVector(along, item.bent ? 0 : length);
    }
    this.onscale?.(this.gauge.describe(size, KINDS));
  }

  stretch({ shaft, head, cut, headLength }, length) {
    const short = Math.min(1, length / (1.6 * headLength));
    const top = headLength * short;
    shaft.scale.set(Math.sqrt(short), Math.max(length - top, 1e-9), Math.sqrt(short));
    shaft.position.y = (length - top) / 2;
    head.scale.setScalar(short);
    head.position.y = length - top / 2;
    cut.position.y = (length - top) / 2;
    cut.rotation.z = 0.5;
  }

  bend({ shaft, head, cut, headLength }, radius) {
    shaft.scale.setScalar(radius);
    const end = 4.6;
    const scale = Math.min(1, (0.8 * radius) / headLength);
    head.scale.setScalar(scale);
    head.position.set(radius * Math.cos(end), radius * Math.sin(end), 0);
    head.rotation.set(0, 0, end);
    cut.position.set(radius * Math.cos(end / 2), radius * Math.sin(end / 2), 0);
    cut.rotation.set(0, 0, end / 2 + 0.5);
  }

  describe(item) {
    const [x, y, z] = item.vector.map((c) => measure(c));
    const cut = item.cut.visible ? "; drawn shorter" : "";
    return `${item.name}: ${measure(item.strength)} ${item.unit}  (${x}, ${y}, ${z})${cut}`;
  }

  // The arrow under a point of the pane, both from −1 to 1.
  under(x, y) {
    const { Raycaster, Vector2 } = this.stage.three;
    const ray = new Raycaster();
    ray.setFromCamera(new Vector2(x, y), this.stage.viewer.camera);
    const shown = this.items.filter((item) => item.group.visible).flatMap((item) => item.parts);
    const hit = ray.intersectObjects(shown)[0];
    return hit ? this.items.find((item) => item.column === hit.object.userData.arrow) : null;
  }
}
