import assert from "node:assert/strict";
import { test } from "node:test";

import { assets } from "./pages.js";

const { fillLines } = await import(new URL("equations/breaking.js", assets));

test("terms stand in one line where there is room", () => {
  assert.deepEqual(fillLines([3, 4, 3], 10, 1), [3]);
});

test("later lines have less room by their indent", () => {
  assert.deepEqual(fillLines([6, 4, 5, 4, 1], 10, 1), [2, 2, 1]);
});

test("a term wider than a line has one to itself", () => {
  assert.deepEqual(fillLines([2, 20, 2], 10, 1), [1, 1, 1]);
});
