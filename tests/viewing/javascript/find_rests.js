// Searches the positions of rest of an engine, as a page does; prints them as JSON.
// Usage: node find_rests.js FILE, with {engine, spans, turns} in the file.

import { readFileSync } from "node:fs";
import { runInThisContext } from "node:vm";

import { assets } from "./pages.js";

const { Machine } = await import(new URL("engine/machine.js", assets));
const { searchModes } = await import(new URL("engine/modes.js", assets));

const { engine, spans, turns } = JSON.parse(readFileSync(process.argv[2], "utf8"));
runInThisContext(engine.script);
const machine = new Machine(engine, globalThis.mecaniqueProgram);
const setting = machine.initial();
const from = machine.begin(setting);
const { rests } = [...searchModes(machine, setting, from, spans, turns)].at(-1);
const found = rests.map(({ y, modes, unstable, small }) => ({
  mode: small.states,
  ranges: spans.map((span, k) => small.range({ y }, k, span)),
  stable: !unstable,
  q: [...y.subarray(0, machine.nq)],
  squares: modes.map(({ square }) => square),
}));
process.stdout.write(JSON.stringify(found));
