// Sliders that put a robot's joints where one wants them, and findings that point at links.

const DEGREES = 180 / Math.PI;

export class Posture {
  constructor(picture) {
    const { sliders } = picture.scene.inspection;
    this.picture = picture;
    this.values = sliders.map(({ value }) => value);
    for (const input of document.querySelectorAll("[data-joint]")) {
      const k = Number(input.dataset.joint);
      input.oninput = () => this.set(k, Number(input.value));
      this.write(input, k);
    }
    const back = document.getElementById("joints-back");
    if (back) back.onclick = () => sliders.forEach(({ value }, k) => this.set(k, value, true));
    this.pose();
  }

  set(k, value, back = false) {
    this.values[k] = value;
    const input = document.querySelector(`[data-joint="${k}"]`);
    if (back) input.value = value;
    this.write(input, k);
    this.pose();
  }

  write(input, k) {
    const turns = this.picture.scene.inspection.sliders[k].unit === "rad";
    const text = turns
      ? `${(this.values[k] * DEGREES).toFixed(1)}°`
      : `${this.values[k].toFixed(4)} m`;
    input.closest("tr").querySelector("output").textContent = text;
    input.setAttribute("aria-valuetext", text);
  }

  // Where every body stands: from its parent, to the joint, and by what the joint moves.
  pose() {
    const { picture } = this;
    const { Matrix4, Vector3, Quaternion } = picture.stage.three;
    const { links, paths } = picture.scene.inspection;
    const poses = links.map(() => new Matrix4());
    for (const { parent, child, place, moves } of paths) {
      const pose = poses[child].copy(poses[parent]).multiply(new Matrix4().set(...place.flat()));
      for (const { kind, axis, constant, factors } of moves) {
        const value = factors.reduce((sum, [s, c]) => sum + c * this.values[s], constant);
        const along = new Vector3(...axis);
        if (kind === "turn") pose.multiply(new Matrix4().makeRotationAxis(along, value));
        else pose.multiply(new Matrix4().makeTranslation(...along.multiplyScalar(value).toArray()));
      }
    }
    const [place, turn, scale] = [new Vector3(), new Quaternion(), new Vector3()];
    poses.forEach((pose, b) => {
      pose.decompose(place, turn, scale);
      picture.row.set([...place.toArray(), ...turn.toArray()], 7 * b);
    });
    picture.redraw();
  }
}

// A finding shows the links it is about, until it is chosen again.
export function wireFindings(anatomy) {
  const buttons = [...document.querySelectorAll("#findings [data-bodies]")];
  for (const button of buttons)
    button.onclick = () => {
      const on = button.getAttribute("aria-pressed") !== "true";
      for (const each of buttons) each.setAttribute("aria-pressed", on && each === button);
      anatomy.chosen = on ? button.dataset.bodies.split(" ").map(Number) : [];
      anatomy.paint();
    };
}
