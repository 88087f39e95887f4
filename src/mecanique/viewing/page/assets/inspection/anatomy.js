// Where a robot's mass is: centers of mass, ellipsoids of inertia, axes of joints; and which links
// are suspicious.

const TINTS = { error: 0xd1242f, warning: 0xe08a00, info: 0x3b82c4, chosen: 0x00a2c7 };
const TINT = 0.65; // how much of a link's own color gives way
const FAINT = 0.32; // opacity of links that are looked through
const DOT = 0.008; // radius of a center of mass, of the picture's size
const LONG = 0.16; // length of an axis, of the picture's size

export class Anatomy {
  constructor({ stage, scene, marks }) {
    Object.assign(this, { stage, chosen: [], suspects: true, through: new Set() });
    this.own = new Set(marks.items.map(({ group }) => group));
    const { links, paths, notes } = scene.inspection;
    this.paints = stage.nodes.map((node) => this.paintsOf(node));
    this.levels = links.map((_, b) => levelOf(notes, b));
    this.centers = links.map((link, b) => this.center(link, b));
    this.ellipsoids = links.map((link, b) => this.ellipsoid(link, b));
    this.axes = paths.flatMap((path) => path.moves.map((move) => this.axis(path, move)));
    this.turn(this.centers, false);
    this.turn(this.ellipsoids, false);
    this.turn(this.axes, false);
    this.paint();
  }

  // The materials of a link, with what they are by themselves.
  paintsOf(node) {
    const found = [];
    const gather = (part) => {
      if (this.own.has(part)) return;
      for (const paint of part.material ? [part.material].flat() : []) {
        const { opacity, transparent, depthWrite } = paint;
        if (paint.color)
          found.push({ paint, color: paint.color.clone(), opacity, transparent, depthWrite });
      }
      part.children.forEach(gather);
    };
    gather(node);
    return found;
  }

  center({ mass, center }, b) {
    if (!(mass > 0)) return null;
    const { Mesh, SphereGeometry, MeshBasicMaterial } = this.stage.three;
    const paint = new MeshBasicMaterial({ color: 0x111111, depthTest: false, transparent: true });
    const dot = new Mesh(new SphereGeometry(DOT * this.stage.size, 20, 14), paint);
    dot.position.set(...center);
    dot.renderOrder = 5;
    this.stage.nodes[b].add(dot);
    return dot;
  }

  ellipsoid({ center, radii, axes }, b) {
    if (!radii.some((radius) => radius > 0)) return null;
    const { Mesh, SphereGeometry, MeshPhongMaterial, Matrix4 } = this.stage.three;
    const color = TINTS[this.levels[b]] ?? 0x2a78b8;
    const paint = new MeshPhongMaterial({ color, transparent: true, opacity: 0.55 });
    const ball = new Mesh(new SphereGeometry(1, 28, 20), paint);
    const [x, y, z] = axes;
    const turned = new Matrix4().set(...x, 0, ...y, 0, ...z, 0, 0, 0, 0, 1);
    ball.quaternion.setFromRotationMatrix(turned);
    ball.position.set(...center);
    const least = 1e-3 * Math.max(...radii); // a disk without thickness has no normals
    ball.scale.set(...radii.map((radius) => Math.max(radius, least)));
    this.stage.nodes[b].add(ball);
    return ball;
  }

  axis({ child }, { kind, axis }) {
    const { Mesh, CylinderGeometry, MeshBasicMaterial, Vector3 } = this.stage.three;
    const length = LONG * this.stage.size;
    const color = kind === "turn" ? 0x7a3db8 : 0x1d7d46;
    const paint = new MeshBasicMaterial({ color, depthTest: false, transparent: true });
    const rod = new Mesh(new CylinderGeometry(0.012 * length, 0.012 * length, length, 10), paint);
    rod.quaternion.setFromUnitVectors(new Vector3(0, 1, 0), new Vector3(...axis));
    rod.renderOrder = 4;
    this.stage.nodes[child].add(rod);
    return rod;
  }

  turn(parts, on) {
    for (const part of parts) if (part) part.visible = on;
    // what lies within the links shows only if one can look through them
    if (parts === this.axes) return;
    if (on) this.through.add(parts);
    else this.through.delete(parts);
  }

  // Links in their own color, those that are suspicious tinted, those that are chosen bright.
  paint() {
    this.paints.forEach((paints, b) => {
      const level = this.chosen.includes(b) ? "chosen" : this.suspects ? this.levels[b] : "";
      for (const { paint, color, opacity, transparent, depthWrite } of paints) {
        paint.color.copy(color);
        if (level) paint.color.lerp(new this.stage.three.Color(TINTS[level]), TINT);
        const faint = this.through.size > 0;
        paint.opacity = faint ? FAINT * opacity : opacity;
        paint.transparent = faint || transparent;
        paint.depthWrite = !faint && depthWrite;
      }
    });
    this.stage.viewer.set_dirty();
  }

  get switches() {
    const set = (parts) => (on) => {
      this.turn(parts, on);
      this.paint();
    };
    const suspects = (on) => {
      this.suspects = on;
      this.paint();
    };
    return [
      ["Centers of mass", false, set(this.centers)],
      ["Inertia ellipsoids", false, set(this.ellipsoids)],
      ["Joint axes", false, set(this.axes)],
      ["Suspicious links in color", true, suspects],
    ];
  }
}

// The worst that is said of a link.
function levelOf(notes, body) {
  const about = notes.filter(({ bodies, suspicious }) => suspicious && bodies.includes(body));
  const said = about.map(({ severity }) => severity);
  return ["error", "warning"].find((severity) => said.includes(severity)) ?? "";
}
