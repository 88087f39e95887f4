// What the numbers set on a page keep to: the rules, and the words, of `Mechanism` and `simulate`.

import { general } from "../data/numbers.js";
import { eigen } from "./modes.js";

const fill = (words, numbers) => {
  let next = 0;
  return words.replace(/\{(\d*)\}/g, (_, k) => general(numbers[k === "" ? next++ : Number(k)]));
};

// Which of the words on an inertia a body's mass and inertia deserve; null if it is that of a body.
function faultOfInertia([moment, triangle], [mass, xx, yy, zz, xy, xz, yz]) {
  const { values } = eigen([
    [xx, xy, xz],
    [xy, yy, yz],
    [xz, yz, zz],
  ]);
  const principal = values.sort((a, b) => a - b);
  const slack = 1e-9 * Math.max(...principal.map(Math.abs)) + 1e-14 * mass;
  if (principal[0] < -slack) return fill(moment, principal);
  return principal[0] + principal[1] < principal[2] - slack ? fill(triangle, principal) : null;
}

function judge({ kind, words, strict }, numbers) {
  if (kind === "finite") return numbers.every(Number.isFinite) ? null : words[0];
  if (kind === "inertia") return faultOfInertia(words, numbers);
  const gap = numbers[numbers.length - 1];
  return (strict ? gap > 0 : gap >= 0) ? null : fill(words[0], numbers);
}

// What is wrong with the parameters, a sentence each.
export function findFaults({ engine, program, nq, nv }, setting) {
  const { conditions = [] } = engine;
  const size = conditions.reduce((sum, { count }) => sum + count, 0);
  if (!size) return [];
  const state = new Float64Array(nq + nv + 1);
  const p = Float64Array.from(setting.p);
  const out = program.rules(setting.first, state, p, new Float64Array(size), null);
  const faults = [];
  let [at, fault] = [0, null];
  for (const condition of conditions) {
    // what is divided by zero has no value, as in Python
    const numbers = [...out.subarray(at, (at += condition.count))].map((x) =>
      Number.isFinite(x) ? x : NaN,
    );
    if (condition.follows && fault) continue;
    fault = judge(condition, numbers);
    if (fault) faults.push(condition.where + fault);
  }
  return [...new Set(faults)];
}

// How Python's messages call what is set; a second motion starts by a difference.
function nameOf(kind, name, coordinates) {
  const state = coordinates.includes(name) ? "coordinate" : "velocity";
  const called = {
    duration: "the duration",
    rtol: "the relative tolerance rtol",
    beside: `the difference in ${name}`,
    parameter: `parameter ${name}`,
  };
  return called[kind] ?? `${state} ${name}`;
}

export function requireFinite([kind, name, value], coordinates) {
  if (Number.isFinite(value)) return;
  const got = typeof value === "string" ? `'${value}'` : general(value);
  throw new Error(`expected a finite number for ${nameOf(kind, name, coordinates)}, got ${got}`);
}

export function requireSpan({ duration, rtol }) {
  if (!(duration > 0))
    throw new Error(`expected a positive duration [s], got ${general(duration)}`);
  if (!(rtol >= 1e-14 && rtol <= 0.1))
    throw new Error(`expected a relative tolerance rtol in 1e-14…0.1, got ${general(rtol)}`);
}
