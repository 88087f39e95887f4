// Searches the positions of rest of an engine, as a page does; prints them as JSON.
// Usage: node find_rests.js FILE, with {engine, spans, turns} in the file.

import { readFileSync } from "node:fs";
import { runInThisContext } from "node:vm";

import { assets } from "./pages.js";

const { Machine } = await import(new URL("engine/machine.js", assets));
const { SmallMotions } = await import(new URL("engine/modes.js", assets));

const { engine, spans, turns } = JSON.parse(readFileSync(process.argv[2], "utf8"));
runInThisContext(engine.script);
const machine = new Machine(engine, globalThis.mecaniqueProgram);
const setting = machine.initial();
const small = new SmallMotions(machine, setting);
const { rests } = [...small.search(machine.begin(setting), spans, turns)].at(-1);
const found = rests.map(({ y, modes, unstable }) => ({
  stable: !unstable,
  q: [...y.subarray(0, machine.nq)],
  squares: modes.map(({ square }) => square),
}));
process.stdout.write(JSON.stringify(found));
