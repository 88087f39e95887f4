// Number fields and sliders of a page that integrates by itself: what is set moves at once.

import { readFragment, writeFragment, writePython } from "../engine/bench.js";
import { describeBreaks, findBreaks } from "../studies/holding.js";
import { describeSwing } from "../engine/section.js";
import { measure, numberOf } from "../data/numbers.js";
import { copyText } from "../equations/copies.js";
import { make } from "./elements.js";
import { round } from "./sliders.js";

// In words, why a motion ends before its time.
function describeEnd({ stopped, last }) {
  return stopped ? `The motion ends at t = ${measure(last)} s, ${stopped}.` : "";
}

// What a motion does not tell by itself, below the picture.
export function describeLimits(...sentences) {
  const place = document.getElementById("ended");
  const text = sentences.filter(Boolean).join(" ");
  place.textContent = text;
  place.hidden = !text;
  return text;
}

export class Setup {
  constructor(bench, motion) {
    Object.assign(this, { bench, motion, listeners: [] });
    this.fields = [...document.querySelectorAll("#panel-parameters [data-kind]")];
    for (const field of this.fields) this.wire(field);
    const find = (id) => document.getElementById(id);
    this.status = find("setup-status");
    this.stay = find("setup-stay");
    this.undoing = find("setup-undo");
    this.undoing.onclick = () => this.attempt(() => bench.undo(), "Undone");
    find("setup-reset").onclick = () => this.attempt(() => bench.reset(), "As at first");
    find("setup-link").onclick = (event) => copyText(event.target, this.link());
    find("setup-python").onclick = (event) => copyText(event.target, writePython(bench));
    document.addEventListener("keydown", (event) => {
      const typed = event.target.tagName === "INPUT" && event.target.type === "number";
      if (!(event.ctrlKey || event.metaKey) || event.key !== "z" || typed || !bench.undoable)
        return;
      event.preventDefault();
      this.undoing.click();
    });
    addEventListener("hashchange", () => this.open(location.hash));
    this.show();
  }

  wire(field) {
    field.disabled = false;
    const { kind, name } = field.dataset;
    const dragged = field.type === "range";
    if (dragged) {
      field.onpointerdown = () => (this.sliding = false);
      field.onchange = () => (this.sliding = false);
    }
    field.oninput = () => {
      // all of one drag is one step to go back
      const keep = !(dragged && this.sliding);
      this.sliding = dragged;
      this.change([[kind, name, numberOf(field.value)]], keep, field);
    };
  }

  // Sets numbers and moves on from the start, or from the state now.
  change(changes, keep = true, field = null) {
    const now = this.stay.checked ? this.motion.present() : null;
    const from = now ? this.bench.machine.names.map((n, k) => ["initial", n, now[k]]) : [];
    const given = new Map([...from, ...changes].map((each) => [`${each[0]} ${each[1]}`, each]));
    return this.attempt(() => this.bench.set([...given.values()], { keep }), null, field);
  }

  // The motion shown, computed by the page: at first it is a recorded one.
  computed() {
    return this.bench.table ?? this.bench.adopt(this.bench.setting, { keep: false });
  }

  // A motion without end: it is shown from where it is when its end is reached.
  goOnForever() {
    const { clock } = this.motion;
    clock.onend = () => this.attempt(() => this.bench.prolong());
    const repeats = document.getElementById("loop");
    clock.looping = repeats.checked = false;
  }

  // Starts from a state, with one step to go back.
  startFrom(state, said) {
    const changes = this.bench.machine.names.map((name, k) => ["initial", name, state[k]]);
    return this.attempt(() => this.bench.set(changes), said);
  }

  attempt(compute, said, field = null) {
    let table;
    try {
      table = compute();
    } catch (error) {
      this.say(error.message, true);
      if (field) this.refuse(field, error.message);
      return false;
    }
    if (!table) return false;
    this.motion.adopt(table);
    this.limits = describeLimits(describeEnd(table.path), describeBreaks(findBreaks(table)));
    this.show(field);
    for (const each of this.listeners) each.show(table);
    this.say(said ?? this.describe());
    return true;
  }

  // Marks a field whose number is refused, with the reason below it; the others are as they are.
  refuse(field, reason) {
    this.show(field);
    field.setAttribute("aria-invalid", "true");
    const row = field.closest("tr");
    const place = { colSpan: row.cells.length, className: "wrong" };
    this.reason = make("tr", {}, make("td", place, reason));
    row.after(this.reason);
    this.reason.scrollIntoView({ block: "nearest" });
  }

  forget() {
    this.reason?.remove();
    this.reason = null;
    for (const field of this.fields) field.removeAttribute("aria-invalid");
  }

  // Takes over what an address says after its #.
  open(fragment) {
    const { changes, extra } = readFragment(fragment, this.bench.machine.engine);
    if (changes.length) {
      const setting = () => {
        const first = this.bench.machine.initial();
        this.bench.setting = first;
        return this.bench.set(changes, { keep: false });
      };
      this.attempt(setting, "As the address says");
    }
    return extra;
  }

  link() {
    const page = location.href.replace(/#.*/, "");
    const text = writeFragment(this.bench.changes());
    return text ? `${page}#${text}` : page;
  }

  show(typed = null) {
    this.forget();
    for (const field of this.fields) {
      const { kind, name, unit } = field.dataset;
      const value = this.bench.get(kind, name);
      if (field !== typed || field.type === "range") {
        if (field.type === "range") {
          if (value < Number(field.min)) field.min = value;
          if (value > Number(field.max)) field.max = value;
        }
        field.value = field.type === "range" ? value : round(value);
      }
      field.setAttribute("aria-valuetext", `${round(value)} ${unit ?? ""}`.trim());
    }
    this.undoing.disabled = !this.bench.undoable;
  }

  describe() {
    const { path } = this.bench.table;
    const swing = describeSwing(this.bench.machine, path);
    const length = (path.last - path.first).toPrecision(3);
    return `${swing}${length} s in ${path.steps} steps. ${this.limits}`.trim();
  }

  say(text, wrong = false) {
    this.status.textContent = text;
    this.status.classList.toggle("wrong", wrong);
    const { table } = this.bench;
    if (!table) return;
    const { path } = table;
    const gap = this.bench.balance();
    const facts = {
      "setup-balance": gap === null ? "–" : measure(gap, 3),
      "setup-error": `${measure(path.worst, 2)} of the tolerance`,
      "setup-steps": `${path.steps}, ${path.evaluations} evaluations, ${this.bench.spent.toFixed(1)} ms`,
    };
    for (const [id, value] of Object.entries(facts))
      document.getElementById(id).textContent = value;
  }
}
