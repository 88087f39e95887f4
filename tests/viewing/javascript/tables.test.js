import assert from "node:assert/strict";
import { test } from "node:test";

import { assets } from "./pages.js";

const { balance, totalWork } = await import(new URL("panels/balance.js", assets));

// A uniform rod (2 kg, 1 m) pinned at its upper end, let go when level: α = 3 g / 2 l at first.
const G = 9.81;
const center = [0.5, 0, 0];
const down = (x) => [0, 0, -x];
const loads = [
  { unit: "N", at: center, vector: down(2 * G) },
  { unit: "N", at: [0, 0, 0], vector: [0, 0, G / 2] },
];
const inertia = [
  { unit: "N", at: center, vector: [0, 0, 1.5 * G] },
  { unit: "N·m", at: center, vector: [0, -0.25 * G, 0] },
];

test("forces on a body cut free sum to m a, their moments to I α", () => {
  assert.deepEqual(balance(loads, inertia), [
    ["Σ F", "(0, 0, −14.71) N"],
    ["m a", "(0, 0, −14.71) N"],
    ["Σ M about the center of mass", "(0, 2.453, 0) N·m"],
    ["I α + ω × I ω", "(0, 2.453, 0) N·m"],
  ]);
});

test("a body without mass has only the sum of its forces", () => {
  const pull = [3, 0, 0];
  const pair = [
    { unit: "N", at: [0, 0, 0], vector: pull },
    { unit: "N", at: [1, 0, 0], vector: pull.map((x) => -x) },
  ];
  assert.deepEqual(balance(pair, []), [["Σ F", "(0, 0, 0) N"]]);
});

test("a moment is added as it is, wherever it acts", () => {
  const couple = { unit: "N·m", at: [9, 9, 9], vector: [0, 4, 0] };
  const lines = Object.fromEntries(balance([couple], inertia.slice(0, 1)));
  assert.equal(lines["Σ M about the center of mass"], "(0, 4.000, 0) N·m");
});

test("what rounding leaves of a sum is zero", () => {
  const off = 1e-4;
  const pull = { unit: "N", at: [off, 0, 0], vector: [0, 0, 1000] };
  const hold = { unit: "N", at: [0, 0, 0], vector: [0, 0, -1000.01] };
  assert.equal(balance([pull, hold], [])[0][1], "(0, 0, 0) N");
});

test("virtual work is summed coordinate by coordinate", () => {
  assert.deepEqual(totalWork([1, -2, 3, 4], 2), ["4.000", "2.000"]);
  assert.deepEqual(totalWork([1, 5, -1 + 1e-6, 5], 2), ["0", "10.00"]);
});
