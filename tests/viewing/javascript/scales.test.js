import assert from "node:assert/strict";
import { test } from "node:test";

import { assets } from "./pages.js";

const { isNothing, powerOfTen, rangeOf, ticks, ticksAlong } = await import(
  new URL("data/scales.js", assets)
);
const { fold } = await import(new URL("panels/phase.js", assets));
const { measure } = await import(new URL("data/numbers.js", assets));

test("powers of ten are written with superscripts", () => {
  assert.equal(powerOfTen(-12), "10⁻¹²");
});

test("angles fold to one turn, π included and −π not", () => {
  const folded = [0, Math.PI, -Math.PI, 4, -4, 7 * Math.PI].map(fold);
  const expected = [0, Math.PI, Math.PI, 4 - 2 * Math.PI, 2 * Math.PI - 4, Math.PI];
  folded.forEach((angle, k) => assert.ok(Math.abs(angle - expected[k]) < 1e-14));
});

test("ticks are round numbers, each written once", () => {
  const { marks, power } = ticks(-0.9, 2.2, 4);
  assert.deepEqual(
    marks.map(({ text }) => text),
    ["0", "1", "2"],
  );
  assert.equal(power, "");
});

test("large and small numbers share a power of ten", () => {
  assert.equal(ticks(0, 2e6, 4).power, "×10⁶");
  assert.deepEqual(
    ticks(0, 2e6, 4).marks.map(({ text }) => text),
    ["0", "0.5", "1.0", "1.5", "2.0"],
  );
  assert.equal(ticks(-3e-4, 3e-4, 4).power, "×10⁻⁴");
});

test("ticks are within the range, and no more than asked for, within one", () => {
  for (const [low, high] of [
    [0, 1],
    [-7.3, 11.9],
    [99.9, 100.1],
    [1e-9, 3e-9],
  ])
    for (let count = 1; count < 12; count++) {
      const { marks } = ticks(low, high, count);
      const slack = 1e-8 * (high - low);
      assert.ok(marks.every(({ x }) => x >= low - slack && x <= high + slack));
      assert.ok(marks.length <= count + 1);
      assert.equal(new Set(marks.map(({ text }) => text)).size, marks.length);
    }
});

test("what is written along a narrow axis does not overlap", () => {
  const { marks } = ticksAlong(0, 1000, 150);
  const longest = Math.max(...marks.map(({ text }) => text.length));
  assert.ok(marks.length * (6.5 * longest + 26) <= 150);
});

test("a curve has room above and below", () => {
  const [low, high] = rangeOf(-1, 3, 3);
  assert.ok(low < -1 && high > 3);
});

test("what varies by rounding alone is a flat line in the middle", () => {
  const [low, high] = rangeOf(2, 2 + 1e-7, 2);
  assert.ok(high - low > 0.3);
  assert.ok(Math.abs((low + high) / 2 - 2) < 1e-6);
});

test("what is nothing beside the largest quantity of its unit is drawn about zero", () => {
  assert.deepEqual(rangeOf(-1e-12, 1e-12, 1), [-1, 1]);
  assert.deepEqual(rangeOf(NaN, NaN, 1), [-1, 1]);
  assert.ok(isNothing(1e-10, 1));
  assert.ok(!isNothing(1e-8, 1));
});

test("numbers are written with four digits, a true minus and powers of ten", () => {
  assert.equal(measure(0), "0");
  assert.equal(measure(-9.81), "−9.810");
  assert.equal(measure(12345.6), "1.235·10⁴");
  assert.equal(measure(250000), "2.50·10⁵");
  assert.equal(measure(-0.00025), "−2.50·10⁻⁴");
  assert.equal(measure(1 / 3, 3), "0.333");
});
