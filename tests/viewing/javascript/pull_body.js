// Pulls the origin of a body to a place for some frames, as a page does; prints where it comes to.
// Usage: node pull_body.js FILE, with {engine, body, target, times} in the file.

import { readFileSync } from "node:fs";
import { runInThisContext } from "node:vm";

import { assets } from "./pages.js";

const { Bench } = await import(new URL("engine/bench.js", assets));
const { Machine } = await import(new URL("engine/machine.js", assets));
const { Pull } = await import(new URL("engine/pull.js", assets));

const { engine, body, target, times } = JSON.parse(readFileSync(process.argv[2], "utf8"));
runInThisContext(engine.script);
const machine = new Machine(engine, globalThis.mecaniqueProgram);
const row = globalThis.mecaniqueProgram.row(0, new Float64Array(100), new Float64Array(100), []);
const layout = { end: row.length, series: row.length };
const bench = new Bench(machine, { bodies: Array(body + 1), series: [] }, layout);
const computed = bench.adopt(bench.setting);
const pull = new Pull(computed, 0, computed.stateAt(0), body, [0, 0, 0]);
pull.target = target;
for (let k = 0; k < times; k++) pull.advance(0.02);
process.stdout.write(
  JSON.stringify([{ q: [...pull.y.subarray(0, machine.nq)], force: machine.force }]),
);
