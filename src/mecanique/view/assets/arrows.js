// Forces as straight arrows, moments as bent ones; which are shown, how long they are, what they say when pointed at.

import { powerOfTen } from "./scales.js";

export const KINDS = {
  weight: { label: "Weight", color: 0x0072b2 },
  spring: { label: "Springs", color: 0x009e73 },
  damper: { label: "Dampers", color: 0xcc79a7 },
  load: { label: "Loads", color: 0xd55e00 },
  reaction: { label: "Reactions", color: 0xe69f00 },
  inertia: { label: "Inertia (d’Alembert)", color: 0x56b4e9 },
};

export function colorOf(kind) {
  return "#" + KINDS[kind].color.toString(16).padStart(6, "0");
}

export function measure(x, digits = 4) {
  if (!x) return "0";
  const size = Math.abs(x);
  const text = size >= 1e5 || size < 1e-3 ? x.toExponential(digits - 2) : x.toPrecision(digits);
  return text.replaceAll("-", "−").replace(/e\+?(.*)/, (_, exponent) => `·${powerOfTen(exponent.replace("−", "-"))}`);
}

export class Arrows {
  constructor(stage, scene, layout) {
    this.stage = stage;
    this.first = layout.arrows;
    this.factor = 1;
    this.kinds = new Set(["weight", "spring", "damper", "load"]);
    this.body = null;
    this.values = false;
    this.greatest = { N: 0, "N·m": 0 };
    this.items = scene.arrows.map((arrow, i) => this.build(arrow, this.first + 6 * i));
    this.meshes = this.items.flatMap((item) => item.parts);
  }

  build(arrow, column) {
    const { Group, Mesh, MeshLambertMaterial, CylinderGeometry, ConeGeometry, TorusGeometry } = this.stage.three;
    const paint = new MeshLambertMaterial({ color: KINDS[arrow.kind].color, emissive: KINDS[arrow.kind].color });
    Object.assign(paint, { emissiveIntensity: 0.35, depthTest: false, transparent: true });
    const r = 0.0055 * this.stage.size;
    const group = new Group();
    const bent = arrow.unit !== "N";
    const shaft = new Mesh(bent ? new TorusGeometry(1, 0.09, 10, 48, 4.6) : new CylinderGeometry(r, r, 1, 16), paint);
    const head = new Mesh(new ConeGeometry(2.7 * r, 8 * r, 20), paint);
    group.add(shaft, head);
    for (const part of [shaft, head]) Object.assign(part, { renderOrder: 10, userData: { arrow: column } });
    this.stage.root.add(group);
    return { ...arrow, column, group, shaft, head, bent, headLength: 8 * r, parts: [shaft, head], vector: [0, 0, 0] };
  }

  // Arrows of one unit share a scale: the longest of the motion is a third of the scene.
  learn(row) {
    for (const { column, unit } of this.items) {
      const length = Math.hypot(row[column + 3], row[column + 4], row[column + 5]);
      this.greatest[unit] = Math.max(this.greatest[unit], length);
    }
  }

  survey(table) {
    for (const { column, unit } of this.items)
      for (let k = 0; k < table.n; k++) {
        const length = Math.hypot(...[3, 4, 5].map((c) => table.value(k, column + c)));
        this.greatest[unit] = Math.max(this.greatest[unit], length);
      }
  }

  visible(item) {
    return this.body === null ? this.kinds.has(item.kind) : item.body === this.body && item.kind !== "inertia";
  }

  pose(row) {
    const { Vector3, Quaternion } = this.stage.three;
    const { size } = this.stage;
    for (const item of this.items) {
      const o = item.column;
      const vector = (item.vector = [row[o + 3], row[o + 4], row[o + 5]]);
      const strength = Math.hypot(...vector);
      item.strength = strength;
      const share = this.greatest[item.unit] ? strength / this.greatest[item.unit] : 0;
      const length = (item.bent ? 0.1 : 0.34) * size * this.factor * share;
      item.length = length;
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
  }

  stretch({ shaft, head, headLength }, length) {
    const short = Math.min(1, length / (1.6 * headLength));
    const top = headLength * short;
    shaft.scale.set(Math.sqrt(short), Math.max(length - top, 1e-9), Math.sqrt(short));
    shaft.position.y = (length - top) / 2;
    head.scale.setScalar(short);
    head.position.y = length - top / 2;
  }

  bend({ shaft, head, headLength }, radius) {
    shaft.scale.setScalar(radius);
    const end = 4.6;
    const scale = Math.min(1, (0.8 * radius) / headLength);
    head.scale.setScalar(scale);
    head.position.set(radius * Math.cos(end), radius * Math.sin(end), 0);
    head.rotation.set(0, 0, end);
  }

  describe(item) {
    const [x, y, z] = item.vector.map((c) => measure(c));
    return `${item.name}: ${measure(item.strength)} ${item.unit}  (${x}, ${y}, ${z})`;
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
