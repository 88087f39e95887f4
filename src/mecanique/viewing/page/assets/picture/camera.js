// Where one looks from: presets that frame the whole motion, and a camera that goes with a body.

const DIRECTIONS = {
  front: [0, -1, 0.16],
  side: [1, 0, 0.12],
  top: [0, -0.0001, 1],
  free: [0.75, -1.25, 0.62],
};

export class Camera {
  constructor(stage, box) {
    this.stage = stage;
    this.box = box;
    this.followed = -1;
    this.preset = null;
    this.share = 0.9;
    const camera = stage.viewer.camera;
    camera.fov = 26;
    camera.near = 0.02 * stage.size;
    camera.far = 60 * stage.size;
    stage.viewer.controls.addEventListener("start", () => this.chosen(null));
    stage.onresize = () => this.preset && this.look(this.preset);
  }

  chosen(preset) {
    this.preset = preset;
    this.onchoice?.(preset);
  }

  look(preset) {
    this.leaveRoom();
    const { target, eye } = this.aim(preset);
    this.place(target, eye);
    this.chosen(preset);
  }

  // The mechanism stands between the bars of buttons, which take up to half of a low picture.
  leaveRoom() {
    const { clientWidth: w, clientHeight: h } = this.stage.pane.parentElement;
    if (!w || !h) return;
    const [above, below] = ["tools", "forces"].map(
      (id) => 14 + document.getElementById(id).offsetHeight,
    );
    const most = Math.min(1, (0.5 * h) / (above + below));
    this.share = 1 - (most * (above + below)) / h;
    this.stage.viewer.camera.setViewOffset(w, h, 0, (most * (below - above)) / 2, w, h);
  }

  // Where to look, and from where: every corner of the box is in the picture, with a margin.
  aim(preset) {
    const { Vector3 } = this.stage.three;
    const camera = this.stage.viewer.camera;
    const toEye = new Vector3(...DIRECTIONS[preset]).normalize();
    const right = new Vector3(-toEye.y, toEye.x, 0).normalize();
    if (preset === "top") right.set(1, 0, 0);
    const up = toEye.clone().cross(right);
    const tan = Math.tan((camera.fov * Math.PI) / 360);
    const tanV = 0.94 * tan * this.share;
    const tanH = 0.84 * tan * Math.max(camera.aspect, 0.2);
    const center = this.box.getCenter(new Vector3());
    let distance = 0;
    for (const x of [this.box.min.x, this.box.max.x])
      for (const y of [this.box.min.y, this.box.max.y])
        for (const z of [this.box.min.z, this.box.max.z]) {
          const d = new Vector3(x, y, z).sub(center);
          const reach = Math.max(Math.abs(d.dot(right)) / tanH, Math.abs(d.dot(up)) / tanV);
          distance = Math.max(distance, reach + d.dot(toEye));
        }
    return { target: center, eye: center.clone().addScaledVector(toEye, distance) };
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
