// The 3-D pane: meshcat's viewer with our own lights, ground and grid, and the bodies' shapes and
// places.

import { hangMeshes } from "./meshes.js";

// Cylinders of three.js point along y, those of a mechanism along z.
const UPRIGHT = (three) => new three.Matrix4().makeRotationX(Math.PI / 2);

export function themeIsDark() {
  return matchMedia("(prefers-color-scheme: dark)").matches;
}

export class Stage {
  constructor(pane, [meshes, ...commands], scene) {
    this.three = MeshCat.THREE;
    this.pane = pane;
    this.scene = scene;
    const viewer = (this.viewer = new MeshCat.Viewer(pane, false));
    viewer.gui.domElement.remove();
    viewer.renderer.debug.checkShaderErrors = false; // asking for them makes the first picture wait
    viewer.hide_background();
    viewer.set_3d_pane_size = () => this.resize();
    for (const name of ["Grid", "Axes", "Lights"])
      viewer.scene_tree.find([name]).object.visible = false;
    this.root = new this.three.Group();
    this.root.name = "mecanique";
    viewer.scene.add(this.root);
    const { MeshBasicMaterial, BackSide } = this.three;
    this.rimPaint = new MeshBasicMaterial({ side: BackSide, depthTest: false, transparent: true });
    for (const command of commands) viewer.handle_command_bytearray(command);
    this.nodes = scene.bodies.map((_, k) => viewer.scene_tree.find(["meshcat", `n${k}`]).object);
    hangMeshes(this.three, scene.meshes, meshes, this.nodes);
    for (const node of this.nodes) node.traverse((part) => this.smooth(part));
    this.boxes = this.nodes.map((node) => this.localBox(node));
    new ResizeObserver(() => this.resize()).observe(pane.parentElement);
  }

  smooth(part) {
    if (!part.material) return;
    for (const material of [part.material].flat()) material.side = material.transparent ? 0 : 2;
  }

  // The box around a body in its own axes, null for one that is not drawn.
  localBox(node) {
    const box = new this.three.Box3();
    node.updateMatrixWorld(true);
    const back = node.matrixWorld.clone().invert();
    node.traverse((part) => {
      if (!part.geometry) return;
      part.geometry.computeBoundingBox();
      const own = part.geometry.boundingBox.clone();
      box.union(own.applyMatrix4(back.clone().multiply(part.matrixWorld)));
    });
    return box.isEmpty() ? null : box;
  }

  // The boxes of the bodies in plain numbers.
  get extents() {
    return this.boxes.map((box) => box && { low: box.min.toArray(), high: box.max.toArray() });
  }

  // Draws shapes that follow the parameters in another size and at another place: size and twelve
  // entries of the place of each, one after the other.
  reshape(resized, numbers) {
    let at = 0;
    for (const { body, shape, size } of resized) {
      const now = numbers.subarray(at, at + size.length);
      const place = numbers.subarray(at + size.length, (at += size.length + 12));
      const node = this.viewer.scene_tree.find(["meshcat", `n${body}`, `s${shape}`]).object;
      const [a, b = a, c = a] = [...now].map((x, i) => x / size[i]);
      // cylinders stand along y in their own axes: radius, length, radius
      const scale = size.length === 2 ? [a, b, a] : [a, b, c];
      const pose = new this.three.Matrix4().set(...place, 0, 0, 0, 1);
      if (size.length === 2) pose.multiply(UPRIGHT(this.three));
      pose.decompose(node.position, node.quaternion, node.scale);
      node.scale.set(...scale);
      node.updateMatrix();
    }
    this.boxes = this.nodes.map((node) => this.localBox(node));
    this.viewer.set_dirty();
  }

  boxFrom({ low, high }) {
    const { Box3, Vector3 } = this.three;
    return new Box3(new Vector3(...low), new Vector3(...high));
  }

  furnish(box, planar, ground) {
    const { Vector3 } = this.three;
    const size = (this.size = box.getSize(new Vector3()).length());
    const center = box.getCenter(new Vector3());
    this.floor = ground ?? box.min.z - 0.06 * size;
    this.light(box, center, size);
    this.layGround(center, size);
    this.layGrid(box, center, size, planar);
    this.paint();
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.paint());
  }

  light(box, center, size) {
    const { HemisphereLight, DirectionalLight } = this.three;
    const sky = new HemisphereLight(0xffffff, 0xb8b2a8, 0.62);
    sky.position.set(0, 0, 1);
    const sun = new DirectionalLight(0xffffff, 0.55);
    sun.position.set(center.x - 0.7 * size, center.y - 1.1 * size, center.z + 1.5 * size);
    sun.target.position.copy(center);
    sun.castShadow = true;
    sun.shadow.mapSize.set(1024, 1024);
    sun.shadow.radius = 5;
    sun.shadow.normalBias = 0.006 * size;
    const reach = Object.assign(sun.shadow.camera, {
      left: -size,
      right: size,
      top: size,
      bottom: -size,
    });
    Object.assign(reach, { near: 0.05 * size, far: 6 * size });
    this.root.add(sky, sun, sun.target);
  }

  layGround(center, size) {
    const { Group, Mesh, CircleGeometry, MeshBasicMaterial, ShadowMaterial } = this.three;
    const disk = new CircleGeometry(2.4 * size, 96);
    this.groundPaint = new MeshBasicMaterial({
      transparent: true,
      opacity: 0.5,
      depthWrite: false,
    });
    const shade = new Mesh(disk, new ShadowMaterial({ opacity: 0.2, depthWrite: false }));
    shade.receiveShadow = true;
    shade.renderOrder = -1;
    const plane = new Mesh(disk, this.groundPaint);
    plane.renderOrder = -2;
    this.ground = new Group();
    this.ground.add(plane, shade);
    this.ground.position.set(center.x, center.y, this.floor);
    this.root.add(this.ground);
  }

  // Graph paper behind a planar mechanism, under a spatial one; 1, 2 or 5 times a power of ten.
  layGrid(box, center, size, planar) {
    const { Group, LineSegments, BufferGeometry, Float32BufferAttribute, LineBasicMaterial } =
      this.three;
    const rough = size / 10;
    const power = 10 ** Math.floor(Math.log10(rough));
    const spacing = (this.spacing = power * [1, 2, 5, 10].find((m) => m * power >= rough * 0.999));
    const half = Math.ceil((planar ? 1.1 : 1.4) * (size / spacing));
    const u = Math.round(center.x / spacing);
    const v = Math.round((planar ? center.z : center.y) / spacing);
    const depth = planar ? box.max.y + 0.04 * size : this.floor;
    const low = planar ? Math.ceil(this.floor / spacing - 1e-6) : v - half;
    const fine = [];
    const thick = [];
    const put = (list, a, b) =>
      list.push(...(planar ? [a[0], depth, a[1], b[0], depth, b[1]] : [...a, depth, ...b, depth]));
    for (let i = u - half; i <= u + half; i++) {
      const x = i * spacing;
      const bottom = planar ? this.floor : low * spacing;
      put(i % 5 ? fine : thick, [x, bottom], [x, (v + half) * spacing]);
    }
    for (let i = low; i <= v + half; i++) {
      put(
        i % 5 ? fine : thick,
        [(u - half) * spacing, i * spacing],
        [(u + half) * spacing, i * spacing],
      );
    }
    this.gridPaints = [fine, thick].map(
      () => new LineBasicMaterial({ transparent: true, depthWrite: false }),
    );
    this.grid = new Group();
    [fine, thick].forEach((list, i) => {
      const geometry = new BufferGeometry().setAttribute(
        "position",
        new Float32BufferAttribute(list, 3),
      );
      const lines = new LineSegments(geometry, this.gridPaints[i]);
      lines.renderOrder = -3;
      this.grid.add(lines);
    });
    this.root.add(this.grid);
  }

  paint() {
    const dark = themeIsDark();
    this.rimPaint.color.set(dark ? 0x14181d : 0xffffff);
    this.groundPaint.color.set(dark ? 0x2a2f36 : 0xd9d6cf);
    this.gridPaints.forEach((paint, i) => {
      paint.color.set(dark ? 0x8d99a8 : 0x5a6675);
      paint.opacity = [0.13, 0.28][i];
    });
    this.viewer.set_dirty();
  }

  pose(row) {
    this.row = row;
    this.nodes.forEach((node, b) => {
      const o = 7 * b;
      node.position.set(row[o], row[o + 1], row[o + 2]);
      node.quaternion.set(row[o + 3], row[o + 4], row[o + 5], row[o + 6]);
    });
    this.viewer.set_dirty();
  }

  resize() {
    const { clientWidth: w, clientHeight: h } = this.pane.parentElement;
    if (!w || !h) return;
    const { camera, renderer } = this.viewer;
    camera.aspect = w / h;
    camera.updateProjectionMatrix();
    renderer.setSize(w, h);
    this.viewer.set_dirty();
    this.onresize?.();
  }

  render() {
    if (this.viewer.needs_render) this.viewer.render();
  }

  // Directions of the world's axes as the camera sees them: right, up, towards the eye.
  directions() {
    const { Matrix4, Vector3 } = this.three;
    const turn = new Matrix4().extractRotation(this.viewer.camera.matrixWorldInverse);
    return [
      [1, 0, 0],
      [0, 0, -1],
      [0, 1, 0],
    ].map((axis) => new Vector3(...axis).applyMatrix4(turn).toArray());
  }

  // Where a point of the world falls in the pane, in pixels; null behind the camera.
  project(point) {
    const p = new this.three.Vector3(...point)
      .applyMatrix4(this.viewer.scene.matrixWorld)
      .project(this.viewer.camera);
    const { clientWidth: w, clientHeight: h } = this.pane.parentElement;
    return p.z > 1 ? null : [((p.x + 1) / 2) * w, ((1 - p.y) / 2) * h];
  }
}
