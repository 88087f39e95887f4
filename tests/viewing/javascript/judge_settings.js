// Says what is wrong with parameters of engines: [{engine, settings}] in a file of JSON, lists of
// sentences on standard output. Usage: node judge_settings.js FILE

import { readFileSync } from "node:fs";
import { runInThisContext } from "node:vm";

import { assets } from "./pages.js";

const { Machine } = await import(new URL("engine/machine.js", assets));
const { findFaults } = await import(new URL("engine/rules.js", assets));

const told = JSON.parse(readFileSync(process.argv[2], "utf8")).map(({ engine, settings }) => {
  runInThisContext(engine.script);
  const machine = new Machine(engine, globalThis.mecaniqueProgram);
  return settings.map((p) => findFaults(machine, { ...machine.initial(), p }));
});
process.stdout.write(JSON.stringify(told));
