// The slider that draws displacements from rest larger than they are.

const LARGEST_POWER = 3; // power of ten

export class Exaggerating {
  constructor(picture, layout, modes) {
    Object.assign(this, { picture, layout, modes });
    this.slider = document.getElementById("exaggerate");
    this.told = document.getElementById("exaggerated");
    this.slider.max = LARGEST_POWER;
    this.slider.oninput = () => this.set(10 ** Number(this.slider.value));
    this.set(1);
  }

  // Another motion may have another position of rest.
  show() {
    this.picture.rest = null;
    this.set(10 ** Number(this.slider.value));
  }

  set(factor) {
    const { picture } = this;
    if (factor > 1 && !picture.rest) picture.rest = this.find();
    picture.factor = factor;
    const times = Number(factor.toPrecision(2));
    this.told.textContent = factor > 1 ? `Displacements drawn × ${times}` : "";
    this.slider.setAttribute("aria-valuetext", `${times} times`);
    picture.redraw();
  }

  // The row of the position of rest, or of the start where there is none.
  find() {
    const { setup } = this.modes;
    const computed = setup.computed();
    const state = this.modes.rest()?.y ?? computed.stateAt(computed.first).slice();
    return computed.fill(computed.first, state, new Float64Array(this.layout.end));
  }
}
