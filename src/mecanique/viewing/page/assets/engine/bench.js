// What has been set on the page: parameters, start, length and tolerance of the motion, with a way
// back; and the motion that follows.

import { numberOf } from "../data/numbers.js";
import { Computed } from "./computed.js";
import { eigen } from "./modes.js";
import { findFaults, requireFinite, requireSpan } from "./rules.js";

const UNDONE = 200; // settings kept to go back to
const IDLE = 1e-14; // of the largest inertia, where there is none
const MOST_LONGER = 6; // how many times longer a motion is made; then its next part is shown

function copy(setting) {
  return { ...setting, p: [...setting.p], start: [...setting.start] };
}

export class Bench {
  constructor(machine, scene, layout) {
    Object.assign(this, { machine, scene, layout, bodies: scene.bodies.length });
    this.setting = machine.initial();
    this.past = [];
    this.table = null;
    this.neighbor = null; // by how much each number of a second motion's start differs, by name
  }

  // The number that is set, by its kind: parameter, initial, duration or rtol.
  get(kind, name) {
    const { engine, names } = this.machine;
    if (kind === "parameter") return this.setting.p[engine.parameters.indexOf(name)];
    if (kind === "initial") return this.setting.start[names.indexOf(name)];
    return this.setting[kind];
  }

  // Sets numbers, [kind, name, value] each, and computes the motion; if there is none, everything
  // stays as it was and the error says why.
  set(changes, { keep = true } = {}) {
    const next = copy(this.setting);
    const before = this.neighbor;
    const held = changes.filter(([kind]) => kind === "initial").map(([, name]) => name);
    try {
      for (const change of changes) this.put(next, change);
      requireSpan(next);
      const faults = findFaults(this.machine, next);
      if (faults.length) throw new Error(faults.join("; "));
      return this.adopt(next, { keep, held });
    } catch (error) {
      this.neighbor = before;
      throw error;
    }
  }

  put(setting, [kind, name, value]) {
    const { engine, names } = this.machine;
    requireFinite([kind, name, value], engine.coordinates);
    if (kind === "parameter") setting.p[engine.parameters.indexOf(name)] = value;
    else if (kind === "initial") setting.start[names.indexOf(name)] = value;
    else if (kind === "beside") this.differ(name, value);
    else setting[kind] = value;
  }

  // Lets a second motion start otherwise; there is none without a difference.
  differ(name, by) {
    const differences = { ...this.neighbor, [name]: by };
    const kept = Object.entries(differences).filter(([, difference]) => difference);
    this.neighbor = kept.length ? Object.fromEntries(kept) : null;
  }

  // Takes a setting as it is and computes its motion.
  adopt(next, { keep = true, held = [] } = {}) {
    const y = this.machine.begin(next, held);
    next.start = [...y.subarray(0, this.machine.names.length)];
    const begun = performance.now();
    const path = this.moveFrom(next, y);
    const table = new Computed(this.machine, next, path, this);
    this.spent = performance.now() - begun;
    table.other = this.neighbor ? this.moveOther(next, table) : null;
    if (keep) {
      this.past.push(copy(this.setting));
      if (this.past.length > UNDONE) this.past.shift();
    }
    this.setting = next;
    this.table = table;
    return table;
  }

  // The path of a motion; where a motion moves no mass, that is why there is none.
  moveFrom(setting, y) {
    try {
      const path = this.machine.move(setting, y, setting.first + setting.duration);
      const stuck = !path.steps || path.stopped.endsWith(" steps");
      if (!stuck || (path.steps && !this.findIdle(setting, y).length)) return path;
    } catch (error) {
      if (!this.findIdle(setting, y).length) throw error;
    }
    throw new Error(this.explainRest(setting, y));
  }

  // For each body whether its place or attitude follows some coordinate.
  findMoving() {
    const { machine, setting, layout, bodies } = this;
    const p = Float64Array.from(setting.p);
    const poses = (state) => {
      const raw = new Float64Array(layout.end + 5 * bodies);
      machine.program.row(setting.first, state, p, raw, null);
      return raw.subarray(0, 12 * bodies);
    };
    const start = machine.assemble(setting, []);
    const still = poses(start);
    const moving = new Array(bodies).fill(false);
    for (let k = 0; k < machine.nq; k++) {
      const state = start.slice();
      state[k] += 0.1;
      poses(state).forEach((x, i) => {
        if (Math.abs(x - still[i]) > 1e-9) moving[Math.floor(i / 12)] = true;
      });
    }
    return moving;
  }

  // Why there is no motion: a velocity v has T = 0, by M_kl = T(1_k + 1_l) − T(1_k) − T(1_l) + T(0).
  explainRest(setting, y) {
    const idle = this.findIdle(setting, y);
    if (!idle.length)
      return "There is no motion with these values: the accelerations at the start are not finite.";
    const names = idle.map((k) => this.machine.names[this.machine.nq + k]);
    return names.length === 1
      ? `The motion ${names[0]} moves no mass, so nothing determines it; give it mass or inertia.`
      : `A motion of ${names.join(", ")} together moves no mass, so nothing determines it; give it mass or inertia.`;
  }

  // The velocities of a motion that moves no mass; empty if every motion moves some.
  findIdle(setting, y) {
    const { machine, scene, layout } = this;
    const { nq, nv } = machine;
    const at = scene.series?.findIndex(({ name }) => name === "energy kinetic") ?? -1;
    if (at < 0) return [];
    const path = {
      first: setting.first,
      last: setting.first,
      steps: 0,
      size: y.length,
      at: () => y,
    };
    const row = new Float64Array(layout.end);
    const still = new Computed(machine, setting, path, this);
    const energy = (...moving) => {
      const state = y.slice().fill(0, nq);
      for (const k of moving) state[nq + k] += 1;
      return still.fill(setting.first, state, row)[layout.series + at];
    };
    const [none, alone] = [energy(), Array.from({ length: nv }, (_, k) => energy(k))];
    const M = alone.map((a, k) => alone.map((b, l) => energy(k, l) - a - b + none));
    const masses = M.map((line, k) => line[k]);
    const most = Math.max(...masses);
    const idle = masses.findIndex((mass) => !(mass > IDLE * most));
    if (idle >= 0) return [idle];
    const { values, vectors } = eigen(
      M.map((line, k) => line.map((x, l) => x / Math.sqrt(masses[k] * masses[l]))),
    );
    const least = values.indexOf(Math.min(...values));
    if (values[least] > IDLE) return [];
    const parts = vectors.map((line, k) => Math.abs(line[least]) / Math.sqrt(masses[k]));
    return [...parts.keys()].filter((k) => parts[k] > 0.1 * Math.max(...parts));
  }

  // The motion made twice as long, or its next part if that would be too long; null if it stops.
  prolong() {
    const { setting, table, machine } = this;
    const { duration } = setting;
    if (!table || table.path.stopped) return null;
    if (2 * duration <= MOST_LONGER * machine.engine.duration)
      return this.adopt({ ...setting, duration: 2 * duration }, { keep: false });
    const start = [...table.stateAt(table.last)].slice(0, machine.names.length);
    return this.adopt({ ...setting, first: table.last, start }, { keep: false });
  }

  // The motion from another start.
  moveOther(setting, table) {
    const { machine } = this;
    const start = [...setting.start];
    for (const [name, by] of Object.entries(this.neighbor))
      start[machine.names.indexOf(name)] += by;
    const y = machine.begin({ ...setting, start }, Object.keys(this.neighbor));
    const path = machine.move(setting, y, table.last);
    const { layout, bodies } = this;
    return new Computed(machine, setting, path, { layout, bodies, last: table.last });
  }

  get undoable() {
    return this.past.length > 0;
  }

  undo() {
    const before = this.past.pop();
    return before ? this.adopt(before, { keep: false }) : null;
  }

  reset() {
    return this.adopt(this.machine.initial());
  }

  // What differs from the page as it was made: [kind, name, value] each.
  changes() {
    const { engine, names } = this.machine;
    const { setting } = this;
    const found = [];
    const first = this.machine.initial();
    engine.parameters.forEach((name, k) => {
      if (setting.p[k] !== first.p[k]) found.push(["parameter", name, setting.p[k]]);
    });
    names.forEach((name, k) => {
      if (setting.start[k] !== first.start[k]) found.push(["initial", name, setting.start[k]]);
    });
    for (const kind of ["duration", "rtol"])
      if (setting[kind] !== first[kind]) found.push([kind, "", setting[kind]]);
    for (const [name, by] of Object.entries(this.neighbor ?? {})) found.push(["beside", name, by]);
    return found;
  }

  // The largest departure of the energy from its balance with the work done, in terms of the energy
  // that is exchanged.
  balance() {
    const { scene, table, layout } = this;
    const at = (name) => layout.series + scene.series.findIndex((s) => s.name === `energy ${name}`);
    const [T, V, E, W] = ["kinetic", "potential", "total", "work"].map(at);
    if (!table || E < layout.series) return null;
    let [worst, most, low, high] = [0, 0, Infinity, -Infinity];
    for (let k = 0; k < table.n; k++) {
      const gap = table.value(k, E) - table.value(0, E) - (table.value(k, W) - table.value(0, W));
      worst = Math.max(worst, Math.abs(gap));
      most = Math.max(most, table.value(k, T), Math.abs(table.value(k, W)));
      [low, high] = [Math.min(low, table.value(k, V)), Math.max(high, table.value(k, V))];
    }
    return worst / (most + high - low || 1);
  }
}

const PREFIXES = { parameter: "p.", initial: "s.", beside: "b." };

// The part of an address behind # that makes a page show the same motion, and back.
export function writeFragment(changes, extra = {}) {
  const pairs = changes.map(([kind, name, value]) => [
    kind in PREFIXES ? `${PREFIXES[kind]}${name}` : kind,
    String(value),
  ]);
  return new URLSearchParams([...pairs, ...Object.entries(extra)]).toString();
}

export function readFragment(text, { parameters, coordinates, velocities }) {
  const states = [...coordinates, ...velocities];
  const changes = [];
  const extra = {};
  for (const [key, value] of new URLSearchParams(text.replace(/^#/, ""))) {
    const name = key.slice(2);
    if (key.startsWith(PREFIXES.parameter) && parameters.includes(name))
      changes.push(["parameter", name, numberOf(value)]);
    else if (key.startsWith(PREFIXES.initial) && states.includes(name))
      changes.push(["initial", name, numberOf(value)]);
    else if (key.startsWith(PREFIXES.beside) && states.includes(name))
      changes.push(["beside", name, numberOf(value)]);
    else if (key === "duration" || key === "rtol") changes.push([key, "", numberOf(value)]);
    else extra[key] = value;
  }
  return { changes, extra };
}

// How long; a motion that ends at a limit is asked for until there, where Python would raise.
function writeDuration({ table, setting }) {
  const { stopped, last } = table?.path ?? {};
  if (!stopped) return `    duration=${setting.duration},`;
  const until = Math.floor((last - setting.first) * 1e9) / 1e9;
  return `    duration=${until},  # it ends ${stopped}`;
}

// The Python that repeats a motion.
export function writePython(bench) {
  const { machine, setting } = bench;
  const { engine } = machine;
  const changed = bench.changes().filter(([kind]) => kind === "parameter");
  const values = changed.map(([, name, value]) => `${JSON.stringify(name)}: ${value}`).join(", ");
  const mapping = (names, from) =>
    `{${names.map((name, k) => `${JSON.stringify(name)}: ${setting.start[from + k]}`).join(", ")}}`;
  const options = engine.options ?? [];
  return [
    "import mecanique as mq",
    ...(options.some((option) => option.includes("sympy.")) ? ["import sympy"] : []),
    "",
    `mechanism = ${engine.python}`,
    ...(values ? [`mechanism = mechanism.replace(**{${values}})`] : []),
    "motion = mq.simulate(",
    "    mechanism,",
    `    q=${mapping(engine.coordinates, 0)},`,
    `    v=${mapping(engine.velocities, engine.coordinates.length)},`,
    writeDuration(bench),
    `    t0=${setting.first},`,
    `    rtol=${setting.rtol},`,
    ...options.map((option) => `    ${option},`),
    ")",
    "",
  ].join("\n");
}
