// Moves each engine of a list to its end at the tolerances asked for; both lists are JSON.
// Usage: node run_engines.js FILE, with [{engine, rtol, times}] in the file.

import { readFileSync } from "node:fs";
import { runInThisContext } from "node:vm";

import { assets } from "./pages.js";

const { Machine } = await import(new URL("engine/machine.js", assets));
const { findBreaks } = await import(new URL("studies/holding.js", assets));
const { writePython } = await import(new URL("engine/bench.js", assets));

const tasks = JSON.parse(readFileSync(process.argv[2], "utf8"));
const found = tasks.map(({ engine, rtol, times }) => {
  runInThisContext(engine.script);
  const machine = new Machine(engine, globalThis.mecaniqueProgram);
  const setting = { ...machine.initial(), rtol };
  const begun = performance.now();
  const path = machine.move(setting, machine.begin(setting), setting.first + setting.duration);
  const states = times.map((t) => [...path.at(t, new Float64Array(path.size))]);
  const { stopped, last } = path;
  const ms = performance.now() - begun;
  const [n, state, p] = [601, new Float64Array(path.size), Float64Array.from(setting.p)];
  const time = (k) => path.first + ((last - path.first) * k) / (n - 1);
  const stateAt = (t) => path.at(t, state);
  const breaks = findBreaks({ machine, p, n, first: path.first, time, stateAt });
  const python = writePython({ machine, setting, table: { path }, changes: () => [] });
  const strips = path.corners?.strips(last).map(({ name, spans }) => [name, spans.at(-1)[2]]);
  return { states, stopped, last, steps: path.steps, ms, python, breaks, strips };
});
process.stdout.write(JSON.stringify(found));
