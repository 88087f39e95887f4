// The buttons over the picture: cameras, what is shown, which forces, one body alone.

import { KINDS, colorOf } from "../picture/arrows.js";
import { make, swatch } from "./elements.js";

function checkbox(text, checked, onchange, parent) {
  const box = make("input", { type: "checkbox", checked });
  if (onchange) box.onchange = () => onchange(box.checked);
  const label = make("label", {}, box, text);
  parent.append(label);
  return label;
}

export function wireCameras(camera, scene) {
  const buttons = [...document.querySelectorAll("[data-camera]")];
  for (const button of buttons) button.onclick = () => camera.look(button.dataset.camera);
  camera.onchoice = (preset) => {
    for (const button of buttons)
      button.setAttribute("aria-pressed", button.dataset.camera === preset);
  };
  const select = document.getElementById("follow");
  scene.bodies.forEach((body, b) => select.append(new Option(body.name, b)));
  select.onchange = () => camera.follow(select.value === "" ? -1 : Number(select.value));
  return Object.fromEntries(buttons.map((button, i) => [String(i + 1), () => button.click()]));
}

// Menus close by Escape, and when what is outside of them is pressed.
export function wireMenus() {
  const menus = [...document.querySelectorAll("details.menu")];
  const leave = ({ target }) => {
    for (const menu of menus) if (!menu.contains(target)) menu.open = false;
  };
  addEventListener("pointerdown", leave, { capture: true }); // a body that is dragged stops it
  for (const menu of menus)
    menu.addEventListener("keydown", (event) => {
      if (event.key !== "Escape" || !menu.open) return;
      menu.open = false;
      menu.querySelector("summary").focus();
    });
}

// With more bodies than this their names are not shown at first.
const FEW_BODIES = 8;

// What can be switched on and off besides forces: words, whether it is on at first, what to do.
export function wireShow(picture, bars, more) {
  const { scene, stage, labels, marks, traces } = picture;
  const named = scene.bodies.length > 1 && scene.bodies.length <= FEW_BODIES;
  const switches = [
    ["Grid", true, (on) => (stage.grid.visible = on)],
    ["Ground", !scene.planar || scene.ground !== null, (on) => (stage.ground.visible = on)],
    ["Axes", true, (on) => (labels.compass.hidden = !on)],
    ["Body names", named, (on) => (labels.shown.bodies = on)],
    ["Joints", true, (on) => marks.show(on)],
    ["Joint names", false, (on) => (labels.shown.joints = on)],
    ["Traces", true, (on) => (traces.shown = on)],
    ["Values at the arrows", false, (on) => (labels.shown.values = on)],
    ...(bars.known ? [["Energy bars", false, (on) => bars.turn(on)]] : []),
    ...more,
  ];
  const menu = document.getElementById("show-menu");
  for (const [text, on, set] of switches) {
    const change = (value) => {
      set(value);
      picture.redraw();
    };
    checkbox(text, on, change, menu);
    change(on);
  }
}

// The bar of forces takes its room before anything is drawn; it works once they are.
export function listForces(scene) {
  const chips = document.getElementById("kinds");
  const present = Object.keys(KINDS).filter((kind) =>
    scene.arrows.some((arrow) => arrow.kind === kind),
  );
  for (const kind of present) {
    const chip = checkbox(KINDS[kind].label, false, null, chips);
    chip.dataset.force = kind;
    chip.insertBefore(swatch(colorOf(kind)), chip.lastChild);
  }
  document.getElementById("forces").hidden = !present.length;
}

export function wireForces(picture) {
  const { arrows } = picture;
  for (const chip of document.querySelectorAll("[data-force]")) {
    const { force } = chip.dataset;
    const box = chip.querySelector("input");
    box.checked = arrows.kinds.has(force);
    box.onchange = () => {
      if (box.checked) arrows.kinds.add(force);
      else arrows.kinds.delete(force);
      picture.redraw();
    };
  }
  const slider = document.getElementById("arrow-scale");
  slider.oninput = () => {
    arrows.gauge.factor = 10 ** Number(slider.value);
    slider.setAttribute("aria-valuetext", `${arrows.gauge.factor.toPrecision(2)} times`);
    picture.redraw();
  };
  slider.oninput();
  const mode = document.getElementById("arrow-mode");
  mode.onchange = () => {
    arrows.gauge.common = mode.value === "common";
    picture.redraw();
  };
  const scale = document.getElementById("arrow-told");
  arrows.onscale = (text) => {
    if (text !== scale.textContent) scale.textContent = text;
  };
}

// Ticks or unticks a kind of forces.
function tick(kind, on) {
  const box = document.querySelector(`[data-force=${kind}] input`);
  if (box && box.checked !== on) box.click();
}

// Shows one body cut free, in the picture and in the table of forces.
export function wireFreeBody(picture, forces) {
  const { scene } = picture;
  let reactions = false;
  const choose = (body) => {
    // a body cut free is held by its reactions; whoever wants can untick them
    if (body !== null && forces.body === null) {
      reactions = picture.arrows.kinds.has("reaction");
      tick("reaction", true);
    }
    if (body === null && !reactions) tick("reaction", false);
    picture.isolate(body);
    forces.choose(body);
  };
  const select = document.getElementById("free-body");
  const loaded = new Set(scene.arrows.map((arrow) => arrow.body));
  scene.bodies.forEach((body, b) => loaded.has(b) && select.append(new Option(body.name, b)));
  select.onchange = () => choose(select.value === "" ? null : Number(select.value));
  choose(null);
}

export function wireTooltip(stage, arrows) {
  const tip = document.getElementById("tooltip");
  const pane = stage.pane.parentElement;
  const hide = () => (tip.hidden = true);
  pane.addEventListener("pointermove", (event) => {
    if (event.buttons) return hide();
    const box = pane.getBoundingClientRect();
    const [x, y] = [event.clientX - box.left, event.clientY - box.top];
    const item = arrows.under((x / box.width) * 2 - 1, 1 - (y / box.height) * 2);
    if (!item) return hide();
    tip.textContent = arrows.describe(item);
    tip.hidden = false;
    const left = Math.min(x + 14, box.width - tip.offsetWidth - 8);
    const top = y - tip.offsetHeight - 10;
    tip.style.transform = `translate(${Math.max(4, left)}px, ${Math.max(4, top)}px)`;
  });
  pane.addEventListener("pointerleave", hide);
  pane.addEventListener("pointerdown", hide, { capture: true });
}

// A still of the picture goes on paper: a WebGL canvas prints blank once its frame is over.
export function wirePrint(stage, plots, clock) {
  const still = document.getElementById("still");
  const take = () => {
    stage.viewer.render();
    const source = stage.viewer.renderer.domElement;
    still.width = source.width;
    still.height = source.height;
    still.getContext("2d").drawImage(source, 0, 0);
    const scale = document.getElementById("arrow-told").textContent;
    document.getElementById("instant").textContent = [`At t = ${clock.time.toFixed(3)} s`, scale]
      .filter(Boolean)
      .join("; ");
    plots.draw();
  };
  addEventListener("beforeprint", take);
  matchMedia("print").addEventListener("change", (event) => event.matches && take());
}
