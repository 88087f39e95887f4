// A second motion beside the first: the same bodies, seen through.

const SECOND = 0xd55e00;
const OPACITY = 0.42;

export class Ghost {
  constructor(stage, width) {
    this.stage = stage;
    this.row = new Float64Array(width);
    this.nodes = null;
    this.shown = false;
  }

  // Copies the bodies as they are drawn now.
  build() {
    const { stage } = this;
    const { MeshLambertMaterial } = stage.three;
    for (const node of this.nodes ?? []) node.parent.remove(node);
    const material = { color: SECOND, transparent: true, opacity: OPACITY, depthWrite: false };
    // where both are at the same place the first is seen
    Object.assign(material, { polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1 });
    const paint = new MeshLambertMaterial(material);
    this.nodes = stage.nodes.map((node) => {
      const copy = node.clone(true);
      copy.traverse((part) => {
        if (!part.material) return;
        part.material = paint;
        part.castShadow = false;
      });
      node.parent.add(copy);
      return copy;
    });
  }

  show(on) {
    if (on) this.build();
    this.shown = on;
    for (const node of this.nodes ?? []) node.visible = on;
    this.stage.viewer.set_dirty();
  }

  pose() {
    if (!this.shown) return;
    this.nodes.forEach((node, b) => {
      const o = 7 * b;
      const still = this.row.subarray(o, o + 3).every((x, i) => x === this.stage.row[o + i]);
      // what does not move apart is drawn once
      node.visible = this.stage.nodes[b].visible && !(still && this.alike(o));
      node.position.set(...this.row.subarray(o, o + 3));
      node.quaternion.set(...this.row.subarray(o + 3, o + 7));
    });
  }

  alike(o) {
    for (let j = o + 3; j < o + 7; j++) if (this.row[j] !== this.stage.row[j]) return false;
    return true;
  }
}
