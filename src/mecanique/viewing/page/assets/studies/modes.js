// Rest and modes: the table of natural frequencies, each mode shown as a motion.

import { Computed } from "../engine/computed.js";
import { searchModes, SmallMotions } from "../engine/modes.js";
import { showSpeed } from "../clock/player.js";
import { measure } from "../data/numbers.js";
import { make } from "../panels/elements.js";

const PERIODS = 4;
const SWAY = 0.25; // amplitude of the largest coordinate: rad, or this part of the picture's size
const NOWHERE = 1e-6; // what searches leave of a position at zero
const WIDE = 1e-4; // of what friction holds, above what searches leave
const SLICE = 25; // of a search, after which the picture moves on [ms]
const COLUMNS = ["Mode", "ω [rad/s]", "f [Hz]", "T [s]", "Damping ratio", ""];

// A period that is this long on the screen is easy to follow [s].
const READABLE = [1, 5];
const BEST = 2;

// How fast a mode is shown: as it is, or 1, 2 or 5 times a power of ten of that.
export function paceOf(period) {
  if (period >= READABLE[0] && period <= READABLE[1]) return 1;
  const rough = period / BEST;
  const power = Math.floor(Math.log10(rough) + 1e-9);
  const digit = [5, 2, 1].find((each) => each * 10 ** power <= rough * (1 + 1e-9));
  return Number(`${digit}e${power}`);
}

const describePace = (pace) => {
  if (pace === 1) return "at its own speed";
  return pace < 1 ? `${Math.round(1 / pace)} times slower` : `${pace} times faster`;
};

const near = (x) => (Math.abs(x) < NOWHERE ? "0" : measure(x, 4));

export class Modes {
  constructor(setup, scene, picture) {
    Object.assign(this, { setup, scene, picture, before: null });
    setup.listeners.push(this);
    this.told = document.getElementById("modes-told");
    this.table = document.getElementById("modes");
    this.offers = document.getElementById("rests");
    this.button = document.getElementById("modes-find");
    this.words = this.button.textContent;
    this.button.onclick = () => (this.search ? this.end() : this.begin());
  }

  // The position of rest next downhill from the start, and what is known there; null without.
  rest() {
    const { machine, setting } = this.setup.bench;
    return new SmallMotions(machine, setting).find(machine.begin(setting));
  }

  // Searches every position of rest, in slices between pictures; the button then ends the search.
  begin() {
    const { machine, setting } = this.setup.bench;
    const { coordinates } = machine.engine;
    const turns = coordinates.map((name) => this.unitOf(name) === "rad");
    const moves = coordinates.map((name) => this.unitOf(name) !== "");
    this.spans = turns.map((turn, k) => (turn ? Math.PI : moves[k] * this.picture.stage.size));
    this.search = searchModes(machine, setting, machine.begin(setting), this.spans, turns);
    this.offers.replaceChildren();
    this.offers.hidden = this.table.hidden = true;
    this.told.textContent = "";
    this.go(this.search);
  }

  go(search) {
    const { machine } = this.setup.bench;
    if (this.search !== search) return;
    const end = performance.now() + SLICE;
    let step = search.next();
    let known = step.value;
    while (!step.done && performance.now() < end) {
      step = search.next();
      known = step.value ?? known;
    }
    if (known) this.list(known.rests);
    if (step.done) {
      this.end();
      if (!this.offers.childElementCount)
        this.told.textContent = machine.engine.switching
          ? "No contact or friction holds it at rest anywhere that was tried."
          : "No position of rest was found near this start.";
      return;
    }
    const found = `${step.value.rests.length} found, ${Math.floor(100 * step.value.part)} % searched`;
    this.button.textContent = `End the search: ${found}`;
    setTimeout(() => this.go(search));
  }

  // Offers what has been found, each a button that shows its modes; the first at once.
  list(rests) {
    const before = this.offers.childElementCount;
    this.offers.append(...rests.slice(before).map((rest) => this.offer(rest)));
    this.offers.hidden = rests.length < 2;
    if (before || !rests.length) return;
    this.tell(rests[0]);
  }

  end() {
    this.search = null;
    this.button.textContent = this.words;
  }

  unitOf(name) {
    return this.scene.series.find((series) => series.name === name)?.unit ?? "";
  }

  // Where a position of rest is, and whether small motions there stay small.
  place(rest) {
    const { coordinates, switching } = this.setup.bench.machine.engine;
    const values = coordinates.map(
      (name, k) => `${name} = ${near(rest.y[k])}${this.span(rest, k)}`,
    );
    const states = rest.small.states.map((state, k) => `${switching.elements[k].name} ${state}`);
    return `${[...values, ...states].join(", ")}: ${rest.unstable ? "unstable" : "stable"}`;
  }

  // In words, between what values of a coordinate friction holds.
  span(rest, k) {
    if (!rest.small.corners || !this.spans[k]) return "";
    const [low, high] = rest.small.range(rest, k, this.spans[k]);
    if (!(high - low > WIDE)) return "";
    if (high - low === Infinity && low === -high) return " (or elsewhere)";
    const from = low > -Infinity ? ` from ${near(low)}` : "";
    return ` (${`${from}${high < Infinity ? ` to ${near(high)}` : " on"}`.trim()})`;
  }

  offer(rest) {
    const button = make("button", { type: "button" });
    button.textContent = this.place(rest);
    button.onclick = () => this.tell(rest);
    return button;
  }

  tell(found) {
    this.told.textContent = `At rest where ${this.place(found)}. ${this.count(found.modes)}`;
    const rows = found.modes.map((mode, k) => this.row(found, mode, k));
    this.table.hidden = !rows.length;
    const head = make("tr", {}, ...COLUMNS.map((text) => make("th", { scope: "col" }, text)));
    this.table.replaceChildren(head, ...rows);
  }

  count(modes) {
    if (!modes.length) return "Nothing is free to move there.";
    const swaying = modes.filter(({ square }) => square > 0).length;
    const falling = modes.filter(({ square }) => square < 0).length;
    const free = modes.length - swaying - falling;
    const parts = [`${swaying} natural ${swaying === 1 ? "mode" : "modes"}`];
    if (free) parts.push(`${free} free to move`);
    if (falling) parts.push(`${falling} unstable`);
    return `${parts.join(", ")}; undamped, without gyroscopic terms.`;
  }

  row(found, mode, k) {
    const omega = Math.sqrt(mode.square);
    const known = mode.square > 0;
    const texts = known
      ? [omega, omega / (2 * Math.PI), (2 * Math.PI) / omega, mode.damping].map((x) =>
          measure(x, 4),
        )
      : [mode.square < 0 ? "unstable" : "0", "–", "–", "–"];
    const cells = texts.map((text) => make("td", { className: "number" }, text));
    const line = make("tr", {}, make("th", { scope: "row" }, String(k + 1)), ...cells);
    const last = line.insertCell();
    if (!known) return line;
    const button = make("button", { type: "button" });
    button.textContent = "Show";
    button.setAttribute("aria-label", `Show mode ${k + 1}`);
    button.onclick = () => this.play(found, mode, k);
    last.append(button);
    return line;
  }

  // How far the largest coordinate of a mode goes: an angle, or a length next to the picture's.
  amplitude({ shape }) {
    const { velocities } = this.setup.bench.machine.engine;
    const largest = shape.findIndex((x) => Math.abs(x) === Math.max(...shape.map(Math.abs)));
    const series = this.scene.series.find(({ name }) => name === velocities[largest]);
    const turns = series?.unit.startsWith("rad");
    return turns ? SWAY : 0.3 * SWAY * this.picture.stage.size;
  }

  play({ y, small }, mode, k) {
    const { bench, motion } = this.setup;
    const path = small.path(y, mode, this.amplitude(mode), PERIODS);
    const { setting, machine } = bench;
    const { layout, bodies } = bench;
    const period = (2 * Math.PI) / Math.sqrt(mode.square);
    const pace = paceOf(period);
    this.before ??= motion.clock.speed;
    this.setSpeed(pace);
    motion.adopt(new Computed(machine, setting, path, { layout, bodies }));
    motion.clock.play();
    const how = `drawn large and ${describePace(pace)}`;
    this.told.textContent = `Mode ${k + 1}, ${how}: its period is ${measure(period, 3)} s. Reset or any change goes back.`;
  }

  setSpeed(speed) {
    this.setup.motion.clock.setSpeed(speed);
    showSpeed(speed);
  }

  // Another motion has the speed of before, and other positions of rest.
  show() {
    if (this.search) this.end();
    if (this.before === null) return;
    this.setSpeed(this.before);
    this.before = null;
    this.setup.motion.transport.refit();
  }
}
