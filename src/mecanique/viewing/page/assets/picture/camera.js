// Where one looks from: presets that frame the whole motion, and a camera that goes with a body.

import { aim, FIELD, room } from "../sketch/framing.js";

export class Camera {
  constructor(stage, box) {
    this.stage = stage;
    this.box = box;
    this.followed = -1;
    this.preset = null;
    this.share = 0.9;
    const camera = stage.viewer.camera;
    camera.fov = FIELD;
    camera.near = 0.02 * stage.size;
    camera.far = 60 * stage.size;
    stage.viewer.controls.addEventListener("start", () => this.chosen(null));
    const refit = () => this.preset && this.look(this.preset);
    stage.onresize = refit;
    // a bar that wraps, as once the scale of the arrows is told, leaves less of the picture
    const bars = new ResizeObserver(refit);
    for (const id of ["tools", "forces"]) bars.observe(document.getElementById(id));
  }

  chosen(preset) {
    this.preset = preset;
    this.onchoice?.(preset);
  }

  look(preset) {
    this.leaveRoom();
    const { target, eye } = this.aim(preset);
    this.place(target, eye);
    // a hand that misses a body must not tip a plane seen from the front
    const { scene, viewer } = this.stage;
    viewer.controls.enableRotate = !(scene.planar && preset === "front");
    this.chosen(preset);
  }

  leaveRoom() {
    const { w, h, share, shift } = room(this.stage.pane.parentElement);
    if (!w || !h) return;
    this.share = share;
    this.stage.viewer.camera.setViewOffset(w, h, 0, -shift, w, h);
  }

  // Where to look, and from where.
  aim(preset) {
    const { Vector3 } = this.stage.three;
    const { aspect } = this.stage.viewer.camera;
    const box = { low: this.box.min.toArray(), high: this.box.max.toArray() };
    const { target, eye } = aim(preset, box, { aspect, share: this.share });
    return { target: new Vector3(...target), eye: new Vector3(...eye) };
  }

  // meshcat's camera lives in axes with y up
  place(target, eye) {
    const { camera, controls } = this.stage.viewer;
    controls.target.set(target.x, target.z, -target.y);
    camera.position.set(eye.x, eye.z, -eye.y);
    controls.update();
    this.settle();
    this.stage.viewer.set_dirty();
  }

  // Takes where it is for where it was put.
  settle() {
    this.placed = this.stage.viewer.controls.target.clone();
  }

  center() {
    const { x, y, z } = this.stage.viewer.controls.target;
    return new this.stage.three.Vector3(x, -z, y);
  }

  eye() {
    const { x, y, z } = this.stage.viewer.camera.position;
    return new this.stage.three.Vector3(x, -z, y);
  }

  // Goes along with something that has moved.
  shift(step) {
    if (step.lengthSq() > 0) this.place(this.center().add(step), this.eye().add(step));
  }

  // Whether a hand has moved the picture aside since the camera was last placed.
  panned() {
    return (
      this.followed < 0 &&
      this.placed.distanceTo(this.stage.viewer.controls.target) > 1e-6 * this.stage.size
    );
  }

  follow(body) {
    this.followed = body;
    this.last = null;
  }

  move(row) {
    if (this.followed < 0) return;
    const [x, y, z] = row.subarray(7 * this.followed, 7 * this.followed + 3);
    const now = new this.stage.three.Vector3(x, z, -y);
    const { camera, controls } = this.stage.viewer;
    const step = this.last ? now.clone().sub(this.last) : now.clone().sub(controls.target);
    controls.target.add(step);
    camera.position.add(step);
    this.last = now;
  }
}
