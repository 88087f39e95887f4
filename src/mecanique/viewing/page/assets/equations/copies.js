// What a click copies, derivations that unfold step by step, and the bar between picture and panel.

import { make } from "../panels/elements.js";
import { wholeOf } from "./breaking.js";

// Puts a text on the clipboard, by the old way where the new one is not allowed, as in a file.
export async function copyText(button, text) {
  const words = button.textContent;
  const field = make("textarea", { value: text, className: "copied" });
  button.after(field);
  field.select();
  let done = document.execCommand("copy");
  field.remove();
  if (!done) {
    try {
      await navigator.clipboard.writeText(text);
      done = true;
    } catch {
      done = false;
    }
  }
  button.textContent = done ? "Copied" : "Not copied";
  setTimeout(() => (button.textContent = words), 1500);
}

// Panels may be written anew, so one listener serves all buttons.
export function wireCopies(panel) {
  panel.addEventListener("click", ({ target }) => {
    if (target.dataset.copy !== undefined) copyText(target, target.dataset.copy);
    else if (target.dataset.copyMathml !== undefined) copyText(target, mathmlOf(target));
    else if (target.dataset.steps !== undefined) advance(target);
  });
}

function mathmlOf(button) {
  const found = button.closest(".equations").querySelectorAll("math");
  return [...found].map((math) => new XMLSerializer().serializeToString(wholeOf(math))).join("\n");
}

// The first click hides all but the first step; each further one shows the next.
function advance(button) {
  const steps = [...button.closest("details").querySelectorAll(".step")];
  let next = steps.findIndex((step) => step.hidden);
  if (next < 0) {
    for (const step of steps) step.hidden = true;
    next = 0;
  }
  steps[next].hidden = false;
  steps[next].scrollIntoView({ block: "nearest" });
  const left = steps.length - next - 1;
  button.textContent = left ? `Next step (${left} left)` : "Step by step";
}

const NARROWEST_PANEL = 20; // of the window's width [%]
const WIDEST_PANEL = 80;

// A bar that the mouse drags and the arrow keys move.
export function wireSplitter(splitter) {
  const main = splitter.parentElement;
  const set = (percent) => {
    const share = Math.min(WIDEST_PANEL, Math.max(NARROWEST_PANEL, percent));
    main.style.setProperty("--panel", `${share}%`);
    splitter.setAttribute("aria-valuenow", Math.round(share));
  };
  const at = (event) => {
    const box = main.getBoundingClientRect();
    return (100 * (box.right - event.clientX)) / box.width;
  };
  splitter.onpointerdown = (event) => splitter.setPointerCapture(event.pointerId);
  splitter.onpointermove = (event) => event.buttons && set(at(event));
  splitter.ondblclick = () => set(38);
  splitter.onkeydown = (event) => {
    const step = { ArrowLeft: 2, ArrowRight: -2 }[event.key];
    if (!step) return;
    event.preventDefault();
    set(Number(splitter.getAttribute("aria-valuenow")) + step);
  };
}
