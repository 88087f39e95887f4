// Bodies that the mouse or a finger places, to start from rest where they are let go, or pulls by a
// spring while the mechanism moves on.

import { Grip } from "../engine/grip.js";
import { Pull } from "../engine/pull.js";

// How far beside a body a mouse and a finger still take it, and where is looked for it [px].
const [REACH, FINGER] = [12, 20];
const RING = 4;
const WAYS = 8;

export class Hand {
  constructor(picture, clock, setup) {
    Object.assign(this, { picture, clock, setup });
    this.way = document.getElementById("drag");
    this.string = this.buildString();
    const { pane, viewer } = picture.stage;
    this.controls = viewer.controls;
    // before the camera's own listener, which would turn the picture
    const early = { capture: true };
    pane.addEventListener("pointerdown", (event) => this.take(event), early);
    pane.addEventListener("pointermove", (event) => this.move(event), early);
    for (const end of ["pointerup", "pointercancel"])
      pane.addEventListener(end, (event) => this.drop(event), early);
    pane.addEventListener("pointermove", (event) => {
      if (!event.buttons) pane.classList.toggle("over-body", this.hit(event) !== null);
    });
  }

  // From the eye through a place beside the pointer [px].
  ray(event, [right, down] = [0, 0]) {
    const { Raycaster, Vector2 } = this.picture.stage.three;
    const { pane, viewer } = this.picture.stage;
    const box = pane.getBoundingClientRect();
    const x = ((event.clientX + right - box.left) / box.width) * 2 - 1;
    const y = 1 - ((event.clientY + down - box.top) / box.height) * 2;
    const caster = new Raycaster();
    caster.setFromCamera(new Vector2(x, y), viewer.camera);
    return caster;
  }

  // The body that can move under a pointer, or the nearest in its reach, and where it is touched.
  hit(event) {
    const direct = this.touch(event);
    if (direct) return this.moves(direct.body) ? direct : null;
    const reach = event.pointerType === "touch" ? FINGER : REACH;
    for (let distance = RING; distance <= reach; distance += RING)
      for (let k = 0; k < WAYS; k++) {
        const way = (2 * Math.PI * k) / WAYS;
        const near = this.touch(event, [distance * Math.cos(way), distance * Math.sin(way)]);
        if (near && this.moves(near.body)) return near;
      }
    return null;
  }

  // The body that a ray meets, and where.
  touch(event, aside) {
    const { nodes } = this.picture.stage;
    const found = this.ray(event, aside).intersectObjects(
      nodes.filter((node) => node.visible),
      true,
    )[0];
    if (!found) return null;
    let part = found.object;
    while (part && !nodes.includes(part)) part = part.parent;
    const body = nodes.indexOf(part);
    return body >= 0 ? { body, at: found.point } : null;
  }

  // Whether a body is not the ground, nor fixed to it, even where its motion is to rest.
  moves(body) {
    this.moving ??= this.setup.bench.findMoving();
    return this.moving[body];
  }

  take(event) {
    if (event.button !== 0 || !event.isPrimary) return;
    const hit = this.hit(event);
    if (!hit) return;
    event.stopImmediatePropagation();
    event.preventDefault();
    const { stage } = this.picture;
    this.clock.pause();
    this.controls.enabled = false;
    stage.pane.setPointerCapture(event.pointerId);
    const computed = this.setup.computed();
    const state = computed.stateAt(this.clock.time);
    const point = stage.nodes[hit.body].worldToLocal(hit.at.clone()).toArray();
    if (this.way.value === "pull") {
      this.pull = new Pull(computed, this.clock.time, state, hit.body, point);
      this.picture.traces.clear();
    } else this.grip = new Grip(computed, computed.first, state, hit.body, point);
    const { Plane, Vector3 } = stage.three;
    const normal = this.picture.scene.planar
      ? new Vector3(0, 0, 1) // the viewer's axes have y up
      : stage.viewer.camera.getWorldDirection(new Vector3());
    this.plane = new Plane().setFromNormalAndCoplanarPoint(normal, hit.at);
    // a body taken beside it stays as far from the pointer
    const under = this.ray(event).ray.intersectPlane(this.plane, new Vector3()) ?? hit.at;
    this.aside = hit.at.clone().sub(under);
  }

  move(event) {
    if (!this.grip && !this.pull) return;
    event.stopImmediatePropagation();
    const { Vector3 } = this.picture.stage.three;
    const target = this.ray(event).ray.intersectPlane(this.plane, new Vector3());
    if (!target) return;
    target.add(this.aside);
    const place = [target.x, -target.z, target.y];
    if (this.pull) {
      this.pull.target = place;
      return;
    }
    const state = this.grip.pull(place);
    const { computed, t, corners } = this.grip;
    computed.fill(t, state, this.picture.row, corners);
    this.picture.redraw();
  }

  // What is pulled moves on while time passes.
  tick(seconds) {
    const { pull, picture } = this;
    if (!pull) return;
    const state = pull.advance(seconds * this.clock.speed);
    pull.computed.fill(pull.t, state, picture.row, pull.corners);
    picture.traces.add(picture.row);
    this.stretch(pull.place, pull.target);
    picture.redraw();
  }

  drop(event) {
    const held = this.grip ?? this.pull;
    if (!held) return;
    event.stopImmediatePropagation();
    this.controls.enabled = true;
    const said = this.pull
      ? "Started from where it was let go, as fast as it was"
      : "Started from rest where it was let go";
    Object.assign(this, { grip: null, pull: null });
    this.string.visible = false;
    this.setup.startFrom(held.y, said);
    this.clock.play();
  }

  // The spring between a body and the hand, as a line.
  buildString() {
    const { BufferGeometry, Float32BufferAttribute, Line, LineBasicMaterial } =
      this.picture.stage.three;
    const places = new Float32BufferAttribute(new Float32Array(6), 3);
    const geometry = new BufferGeometry().setAttribute("position", places);
    const paint = new LineBasicMaterial({ color: 0xd55e00, depthTest: false });
    const line = new Line(geometry, paint);
    Object.assign(line, { visible: false, frustumCulled: false, renderOrder: 12 });
    this.picture.stage.root.add(line);
    return line;
  }

  stretch(from, to) {
    const { position } = this.string.geometry.attributes;
    position.array.set([...from, ...to]);
    position.needsUpdate = true;
    this.string.visible = true;
  }
}
