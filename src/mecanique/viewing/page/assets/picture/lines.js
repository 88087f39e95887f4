// Springs, dampers and rods, which stretch; traces, which are left behind; and marks at the joints.

const PAINT = { spring: 0x66707c, damper: 0x8a939e, rod: 0x7a838e, pull: 0x9aa4b0 };
const TRACES = [0xd55e00, 0x0072b2, 0x009e73, 0xcc79a7, 0xe69f00, 0x56b4e9];

export class Lines {
  constructor(stage, scene, layout, row) {
    this.stage = stage;
    this.shown = true;
    const { MeshPhongMaterial } = stage.three;
    const r = (this.radius = 0.022 * stage.size);
    this.shift = this.beside(scene.lines, layout, row);
    this.items = scene.lines.map((line, i) => {
      const column = layout.lines + 6 * i;
      const rest = Math.max(this.ends(row, column).length, 2 * r);
      const paint = new MeshPhongMaterial({ color: PAINT[line.kind], shininess: 30, side: 2 });
      const drawn = { spring: this.coil, damper: this.dashpot, rod: this.rod, pull: this.thread };
      const group = drawn[line.kind].call(this, paint, rest);
      group.traverse((part) => (part.castShadow = true));
      stage.root.add(group);
      return { ...line, column, group, rest, shift: this.shift[i] };
    });
  }

  ends(row, o) {
    const { Vector3 } = this.stage.three;
    const a = new Vector3(row[o], row[o + 1], row[o + 2]);
    const along = new Vector3(row[o + 3], row[o + 4], row[o + 5]).sub(a);
    return { a, along, length: along.length() };
  }

  // Lines that share both ends, such as a spring and a damper, are drawn side by side.
  beside(lines, layout, row) {
    const keys = lines.map((_, i) => {
      const o = layout.lines + 6 * i;
      return [...row.subarray(o, o + 6)]
        .map((x) => Math.round(x / (0.01 * this.stage.size)))
        .join();
    });
    return keys.map((key, i) => {
      const count = keys.filter((other) => other === key).length;
      const rank = keys.slice(0, i).filter((other) => other === key).length;
      return (rank - (count - 1) / 2) * 3.2 * this.radius;
    });
  }

  coil(paint, rest) {
    const { Group, Mesh, TubeGeometry, Curve, Vector3 } = this.stage.three;
    const r = this.radius;
    const turns = Math.max(4, Math.min(14, Math.round(rest / (1.3 * r))));
    const lead = Math.min(0.12 * rest, 1.5 * r);
    class Helix extends Curve {
      getPoint(s) {
        const y = s * rest;
        const inside = Math.min(1, Math.max(0, (y - lead) / (rest - 2 * lead)));
        const wide = r * Math.min(1, 6 * Math.min(inside, 1 - inside) * (turns / 6));
        const angle = 2 * Math.PI * turns * inside;
        return new Vector3(wide * Math.sin(angle), y, wide * Math.cos(angle));
      }
    }
    const group = new Group();
    group.add(new Mesh(new TubeGeometry(new Helix(), turns * 18, 0.14 * r, 8), paint));
    group.userData.pose = (length) => group.scale.set(1, length / rest, 1);
    return group;
  }

  dashpot(paint, rest) {
    const { Group, Mesh, CylinderGeometry } = this.stage.three;
    const r = this.radius;
    const unit = (radius, open) =>
      new Mesh(new CylinderGeometry(radius, radius, 1, 24, 1, open), paint);
    const [foot, cup, base, piston, rod] = [
      unit(0.2 * r),
      unit(r, true),
      unit(r),
      unit(0.85 * r),
      unit(0.2 * r),
    ];
    const group = new Group();
    group.add(foot, cup, base, piston, rod);
    const set = (part, from, to) => {
      part.position.y = (from + to) / 2;
      part.scale.y = Math.max(to - from, 1e-9);
    };
    cup.material = Object.assign(paint.clone(), { transparent: true, opacity: 0.55 });
    group.userData.pose = (length) => {
      const start = 0.22 * Math.min(rest, length);
      const deep = Math.min(0.42 * rest, length - start);
      const head = Math.min(Math.max(length - 0.5 * rest, start + 0.08 * rest), start + deep);
      set(foot, 0, start);
      set(cup, start, start + deep);
      set(base, start, start + 0.12 * r);
      set(piston, head - 0.15 * r, head + 0.15 * r);
      set(rod, head, length);
    };
    return group;
  }

  thread(paint, rest) {
    return this.rod(paint, rest, 0.07);
  }

  rod(paint, rest, share = 0.25) {
    const { Group, Mesh, CylinderGeometry } = this.stage.three;
    const group = new Group();
    const r = share * this.radius;
    const bar = new Mesh(new CylinderGeometry(r, r, 1, 16), paint);
    group.add(bar);
    group.userData.pose = (length) => {
      bar.scale.y = Math.max(length, 1e-9);
      bar.position.y = length / 2;
    };
    return group;
  }

  pose(row) {
    const { Vector3, Quaternion } = this.stage.three;
    for (const { group, column, shift } of this.items) {
      const { a, along, length } = this.ends(row, column);
      group.visible = this.shown && length > 1e-4 * this.stage.size;
      if (!group.visible) continue;
      along.divideScalar(length);
      const across = new Vector3(0, 1, 0).cross(along);
      if (across.length() < 1e-6) across.set(1, 0, 0);
      group.position.copy(a).addScaledVector(across.normalize(), shift);
      group.quaternion.copy(new Quaternion().setFromUnitVectors(new Vector3(0, 1, 0), along));
      group.userData.pose(length);
    }
  }
}

// A trace is a thin square tube through its points; how much of it is drawn follows the clock.
export class Traces {
  constructor(stage, scene, layout, capacity) {
    const { Mesh, BufferGeometry, BufferAttribute, MeshBasicMaterial } = stage.three;
    this.thick = 0.0022 * stage.size;
    this.capacity = capacity;
    this.shown = true;
    this.items = scene.traces.map((trace, i) => {
      const geometry = new BufferGeometry();
      geometry.setAttribute("position", new BufferAttribute(new Float32Array(12 * capacity), 3));
      const index = new Uint32Array(24 * Math.max(capacity - 1, 0));
      for (let k = 0; k < capacity - 1; k++)
        for (let s = 0; s < 4; s++) {
          const [a, b] = [4 * k + s, 4 * k + ((s + 1) % 4)];
          index.set([a, b, a + 4, b, b + 4, a + 4], 24 * k + 6 * s);
        }
      geometry.setIndex(new BufferAttribute(index, 1));
      const paint = new MeshBasicMaterial({
        color: TRACES[i % TRACES.length],
        transparent: true,
        opacity: 0.75,
        side: 2,
      });
      const mesh = new Mesh(geometry, paint);
      mesh.frustumCulled = false;
      stage.root.add(mesh);
      return { ...trace, column: layout.traces + 3 * i, mesh, count: 0 };
    });
  }

  append(item, point) {
    if (item.count === this.capacity) {
      const array = item.mesh.geometry.attributes.position.array;
      array.copyWithin(0, 12 * (this.capacity >> 1));
      item.count -= this.capacity >> 1;
    }
    const t = this.thick;
    const [x, y, z] = point;
    const corners = [x + t, y, z + t, x + t, y, z - t, x - t, y, z - t, x - t, y, z + t];
    item.mesh.geometry.attributes.position.array.set(corners, 12 * item.count);
    item.mesh.geometry.attributes.position.needsUpdate = true;
    item.count += 1;
  }

  add(row) {
    for (const item of this.items) this.append(item, row.subarray(item.column, item.column + 3));
  }

  // Adds places that were passed between two pictures: of all traces, instant by instant.
  pass(points) {
    const width = 3 * this.items.length;
    for (let o = 0; width && o + width <= points.length; o += width)
      this.items.forEach((item, i) => this.append(item, points.subarray(o + 3 * i, o + 3 * i + 3)));
  }

  clear() {
    for (const item of this.items) item.count = 0;
  }

  reveal(upTo) {
    for (const { mesh, count } of this.items) {
      mesh.visible = this.shown && count > 1;
      mesh.geometry.setDrawRange(0, 24 * Math.max(0, Math.min(upTo, count) - 1));
    }
  }
}

export class JointMarks {
  constructor(stage, scene) {
    const {
      Group,
      Mesh,
      CylinderGeometry,
      SphereGeometry,
      BoxGeometry,
      MeshPhongMaterial,
      Vector3,
      Quaternion,
    } = stage.three;
    const r = 0.014 * stage.size;
    const dark = new MeshPhongMaterial({ color: 0x2f3640, shininess: 40 });
    const light = new MeshPhongMaterial({ color: 0xf2f2f0, shininess: 40 });
    this.items = scene.joints.map((joint) => {
      const group = new Group();
      const axis = new Vector3(...joint.axis);
      if (joint.kind === "revolute") {
        group.add(new Mesh(new CylinderGeometry(r, r, 3.4 * r, 28), dark));
        group.add(new Mesh(new CylinderGeometry(0.55 * r, 0.55 * r, 3.7 * r, 24), light));
      } else if (joint.kind === "prismatic")
        group.add(new Mesh(new BoxGeometry(0.7 * r, 3.4 * r, 0.7 * r), dark));
      else
        group.add(new Mesh(new SphereGeometry(joint.kind === "fixed" ? 0.5 * r : r, 20, 14), dark));
      group.position.set(...joint.point);
      if (axis.length() > 0)
        group.quaternion.copy(
          new Quaternion().setFromUnitVectors(new Vector3(0, 1, 0), axis.normalize()),
        );
      stage.nodes[joint.body].add(group);
      return { ...joint, group };
    });
    // pins on the ground stand on a foot
    for (const { foot } of scene.joints.filter((joint) => joint.foot.length)) {
      const group = new Group();
      const leg = new Mesh(new CylinderGeometry(0.5 * r, 1.6 * r, 3.4 * r, 28), dark);
      const sole = new Mesh(new BoxGeometry(6.4 * r, 0.5 * r, 6.4 * r), dark);
      [leg.position.y, sole.position.y] = [-1.7 * r, -3.6 * r];
      group.add(leg, sole);
      group.position.set(...foot.slice(0, 3));
      const down = new Vector3(...foot.slice(3)).negate();
      group.quaternion.setFromUnitVectors(new Vector3(0, 1, 0), down);
      stage.root.add(group);
      this.items.push({ group });
    }
  }

  show(on) {
    for (const { group } of this.items) group.visible = on;
  }
}
