// Keeps what moves in the picture, in a live view, whose end nobody knows, and in a motion that
// goes far: the view widens a little where that is enough, and else travels along; ground and
// graph paper come with it.

// Of the first box's size: how wide the view may become, and how far off its middle all is lost.
const WIDEST = 1.7;
const LOST = 1.5;
// How long it takes to travel at full speed, to come to the middle and to come to rest [s].
const RAMP = 0.35;
const CENTERING = 0.6;
const CALM = 3;

export class Companion {
  constructor(stage, camera, box, row) {
    Object.assign(this, { stage, camera });
    this.first = row.slice(0, 7 * stage.boxes.length);
    this.home = box.clone();
    this.size = box.getSize(new stage.three.Vector3()).length();
    this.middle = box.getCenter(new stage.three.Vector3());
    this.sun = stage.root.children.find((each) => each.isDirectionalLight);
    this.sunAt = [this.sun.position.clone(), this.sun.target.position.clone()];
    this.groundAt = stage.ground.position.clone();
    this.floorLines = [...stage.grid.children];
    this.buildWall();
    this.on = true;
    this.reset();
  }

  // Back to the start of the motion.
  reset() {
    const { Vector3 } = this.stage.three;
    this.frame = this.home.clone();
    this.travel = new Vector3();
    this.riding = false;
    this.afloat = false;
    this.fresh = true;
    this.track = [];
    this.camera.box = this.home.clone();
    if (this.on && this.camera.preset) this.camera.look(this.camera.preset);
    else if (this.on && this.camera.placed)
      this.camera.shift(this.middle.clone().sub(this.camera.center()));
  }

  // Offers itself among the bodies to follow; moving the picture aside by hand switches it off.
  wire(select) {
    const option = new Option("what moves", "all");
    select.options[0].after(option);
    select.value = "all";
    const others = select.onchange;
    select.onchange = (event) => {
      this.on = select.value === "all";
      if (!this.on) return others(event);
      this.camera.follow(-1);
      this.camera.settle();
      this.fresh = true;
    };
    this.off = () => {
      this.on = false;
      if (select.value === "all") select.value = "";
    };
  }

  // The box around the bodies that are not where they were at first, and the mean of their centers.
  survey(row) {
    const { Box3, Vector3, Quaternion, Matrix4 } = this.stage.three;
    const now = new Box3();
    const mean = new Vector3();
    let count = 0;
    const moved = (b) => {
      for (let j = 7 * b; j < 7 * b + 7; j++)
        if (Math.abs(row[j] - this.first[j]) > 1e-7) return true;
      return false;
    };
    this.stage.boxes.forEach((own, b) => {
      if (!own || !moved(b)) return;
      const [x, y, z, qx, qy, qz, qw] = row.subarray(7 * b, 7 * b + 7);
      const pose = new Matrix4().compose(
        new Vector3(x, y, z),
        new Quaternion(qx, qy, qz, qw),
        new Vector3(1, 1, 1),
      );
      const box = own.clone().applyMatrix4(pose);
      now.union(box);
      mean.add(box.getCenter(new Vector3()));
      count += 1;
    });
    return count ? { now, mean: mean.divideScalar(count) } : null;
  }

  // Called for every picture; says whether the picture is still on its way somewhere.
  step(row, seconds) {
    const dt = Math.min(seconds, 0.5);
    if (this.camera.panned()) this.off();
    const found = this.survey(row);
    if (found) this.keep(found, dt);
    const gliding = this.on && this.glide(dt);
    this.furnish(found);
    return gliding;
  }

  // What the picture frames now: the box, as far as it has travelled.
  shown() {
    return this.frame.clone().translate(this.travel);
  }

  keep({ now, mean }, dt) {
    const before = this.travel.clone();
    const middle = this.shown().getCenter(new this.stage.three.Vector3());
    const lost = mean.distanceTo(middle) > LOST * this.size;
    if (!this.riding) this.widen(now);
    if (this.riding) this.ride(mean, dt, lost || this.fresh);
    this.last = mean;
    this.camera.box = this.shown();
    if (this.on) this.aim(this.travel.clone().sub(before));
    this.fresh = false;
  }

  // Frames a little more, or begins to travel along if that would be too much.
  widen(now) {
    const roomy = this.shown().expandByScalar(0.03 * this.size);
    if (roomy.containsBox(now)) return;
    const wider = this.frame.clone().union(now.clone().translate(this.travel.clone().negate()));
    if (wider.getSize(new this.stage.three.Vector3()).length() <= WIDEST * this.size)
      this.frame = wider.expandByScalar(0.04 * this.size);
    else Object.assign(this, { riding: true, blend: 0, track: [] });
  }

  // Travels along with the mean of what moves, softly unless it must be at once.
  ride(mean, dt, atOnce) {
    this.blend = atOnce ? 1 : Math.min(1, this.blend + dt / RAMP);
    if (this.last) this.travel.addScaledVector(mean.clone().sub(this.last), this.blend);
    const middle = this.shown().getCenter(new this.stage.three.Vector3());
    const part = atOnce ? 1 : 1 - Math.exp(-dt / CENTERING);
    this.travel.addScaledVector(mean.clone().sub(middle), part);
    this.rest(mean);
  }

  // Takes the camera along; at the start of a motion it goes to where it looks from.
  aim(travelled) {
    const { camera, fresh } = this;
    if (!fresh) camera.shift(travelled);
    else if (camera.preset) camera.look(camera.preset);
    else camera.shift(camera.box.getCenter(new this.stage.three.Vector3()).sub(camera.center()));
  }

  // Stops travelling once the motion keeps to one place again.
  rest(mean) {
    const now = performance.now() / 1000;
    this.track.push([now, mean]);
    while (now - this.track[0][0] > CALM) this.track.shift();
    if (now - this.track[0][0] < 0.8 * CALM) return;
    const reach = new this.stage.three.Box3().setFromPoints(this.track.map(([, point]) => point));
    if (reach.getSize(new this.stage.three.Vector3()).length() < 0.3 * this.size)
      this.riding = false;
  }

  // Moves the camera towards where its preset has it look from, when the box it frames has grown.
  glide(dt) {
    const { camera } = this;
    if (!camera.preset) return false;
    const { target, eye } = camera.aim(camera.preset);
    const [toTarget, toEye] = [target.clone().sub(camera.center()), eye.clone().sub(camera.eye())];
    if (Math.max(toTarget.length(), toEye.length()) < 1e-4 * this.size) return false;
    const part = 1 - Math.exp(-dt / 0.35);
    camera.place(
      camera.center().addScaledVector(toTarget, part),
      camera.eye().addScaledVector(toEye, part),
    );
    return true;
  }

  // Below the ground there is none: graph paper stands behind what falls, and runs past.
  furnish(found) {
    const { stage, sun } = this;
    const away = this.camera.center().sub(this.middle);
    if (found && found.now.min.z < stage.floor - 0.02 * this.size) this.afloat = true;
    const step = 5 * stage.spacing;
    const snapped = (x) => Math.round(x / step) * step;
    stage.ground.position.set(this.groundAt.x + away.x, this.groundAt.y + away.y, this.groundAt.z);
    for (const part of stage.ground.children) part.visible = !this.afloat;
    const planar = stage.scene.planar;
    for (const part of this.floorLines) {
      part.visible = !this.afloat;
      part.position.set(
        snapped(away.x),
        planar ? 0 : snapped(away.y),
        planar && away.z > 0 ? snapped(away.z) : 0,
      );
    }
    sun.position.copy(this.sunAt[0]).add(away);
    sun.target.position.copy(this.sunAt[1]).add(away);
    this.wall.visible = this.afloat;
    if (!this.afloat) return;
    const toEye = this.camera.eye().sub(this.camera.center());
    const quarter = planar ? 0 : Math.round(Math.atan2(toEye.x, -toEye.y) / (Math.PI / 2));
    const turn = (quarter * Math.PI) / 2;
    this.wall.rotation.set(0, 0, turn);
    const center = this.camera.center();
    const along = center.x * Math.cos(turn) + center.y * Math.sin(turn);
    const across = -center.x * Math.sin(turn) + center.y * Math.cos(turn) + this.behind;
    const u = snapped(along);
    this.wall.position.set(
      u * Math.cos(turn) - across * Math.sin(turn),
      u * Math.sin(turn) + across * Math.cos(turn),
      snapped(center.z),
    );
  }

  buildWall() {
    const { Group, LineSegments, BufferGeometry, Float32BufferAttribute } = this.stage.three;
    const { spacing, gridPaints, scene } = this.stage;
    const half = 5 * Math.ceil((0.6 * this.size) / spacing);
    this.behind = scene.planar
      ? this.home.max.y - this.middle.y + 0.04 * this.size
      : 0.9 * this.size;
    this.wall = new Group();
    const lists = [[], []];
    for (let i = -half; i <= half; i++) {
      const [x, end] = [i * spacing, half * spacing];
      lists[i % 5 ? 0 : 1].push(x, 0, -end, x, 0, end, -end, 0, x, end, 0, x);
    }
    lists.forEach((list, i) => {
      const geometry = new BufferGeometry().setAttribute(
        "position",
        new Float32BufferAttribute(list, 3),
      );
      const lines = new LineSegments(geometry, gridPaints[i]);
      lines.renderOrder = -3;
      this.wall.add(lines);
    });
    this.stage.grid.add(this.wall);
  }
}
