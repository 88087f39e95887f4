import assert from "node:assert/strict";
import { test } from "node:test";

import { assertNear, assets } from "./pages.js";

const load = (name) => import(new URL(`${name}.js`, assets));
const { aim, frame, matrixOf, turned } = await load("sketch/framing");
const { boxAround, solidOf } = await load("sketch/solids");
const { hull, lens } = await load("sketch/sketch");

const LAYOUT = { lines: 7, series: 7 };
const UPRIGHT = [1, 0, 0, 0, 1, 0, 0, 0, 1];
const BAR = { kind: "box", size: [2, 0.2, 0.4], turn: UPRIGHT, place: [1, 0, 0], color: "#000" };
const rowAt = (x) => Float64Array.from([x, 0, 0, 0, 0, 0, 1]);
const HALF = Math.SQRT1_2;

test("the points around others are those at the corners", () => {
  const inner = [
    [0.5, 0.5],
    [0, 0.5],
    [0.2, 0.9],
  ];
  const corners = [
    [0, 0],
    [1, 0],
    [1, 1],
    [0, 1],
  ];
  assert.deepEqual(hull([...inner, ...corners]), corners);
});

test("a turned box is as large as its corners reach", () => {
  const box = turned({ low: [0, 0, 0], high: [2, 1, 0] }, matrixOf(0, 0, HALF, HALF), [5, 0, 0]);
  assertNear(box.low, [4, 0, 0]);
  assertNear(box.high, [5, 2, 0]);
});

test("a body's box holds all of its solids", () => {
  const ball = { kind: "sphere", size: [0.5], turn: UPRIGHT, place: [0, 0, 1] };
  const side = [-2, 2].map((z) => [0.1, z]);
  const pin = { kind: "cylinder", size: [0.1, 4], profile: side, turn: UPRIGHT, place: [0, 0, 0] };
  const box = boxAround([BAR, ball, pin].map(solidOf));
  assertNear(box.low, [-0.5, -0.5, -2]);
  assertNear(box.high, [2, 0.5, 2]);
  assert.equal(boxAround([]), null);
});

test("a motion is framed whole, unless it goes far", () => {
  const boxes = [boxAround([solidOf(BAR)])];
  const still = frame(boxes, [rowAt(0), rowAt(1)], LAYOUT);
  assert.equal(still.far, false);
  assertNear(still.box.high, [3, 0.15, 0.2]);
  const far = frame(boxes, [rowAt(0), rowAt(100)], LAYOUT);
  assert.equal(far.far, true);
  assertNear(far.box.high, [2, 0.1, 0.2]);
});

test("the feet on which pins and springs stand are in the picture", () => {
  const boxes = [boxAround([solidOf(BAR)])];
  const rows = [rowAt(0), rowAt(1)];
  const { high: bare } = frame(boxes, rows, LAYOUT).box;
  const joints = [{ foot: [0, 0, bare[2], 0, 0, 1] }, { foot: [] }];
  const { high } = frame(boxes, rows, LAYOUT, { joints }).box;
  assertNear(high.slice(0, 2), bare.slice(0, 2));
  assert.ok(high[2] > bare[2] + 0.1);
});

test("what rests is framed as far as it is near what moves", () => {
  const floor = { ...BAR, size: [40, 40, 0], place: [0, 0, -1] };
  const boxes = [floor, BAR].map((solid) => boxAround([solidOf(solid)]));
  const rows = [0, 1].map((x) => Float64Array.from([0, 0, 0, 0, 0, 0, 1, x, 0, 0, 0, 0, 0, 1]));
  const { low, high } = frame(boxes, rows, { lines: 14, series: 14 }).box;
  const near = 0.3 * Math.hypot(3, 0.2, 0.4); // of the box in which the bar moves
  assertNear([low[0], low[2]], [-near, -1]);
  assertNear(high, [3 + near, 0.1 + near, 0.2]);
});

test("a motion that goes far leaves the floor it starts on out of the picture", () => {
  const floor = { ...BAR, size: [9, 9, 0], place: [0, 0, -0.2] };
  const boxes = [floor, BAR].map((solid) => boxAround([solidOf(solid)]));
  const rows = [0, 100].map((x) => Float64Array.from([0, 0, 0, 0, 0, 0, 1, x, 0, 0, 0, 0, 0, 1]));
  const { box, far } = frame(boxes, rows, { lines: 14, series: 14 });
  assert.equal(far, true);
  assertNear(box.high, [2, 0.1, 0.2]);
});

test("the picture of a motion that goes far is hardly wider than what moves", () => {
  const boxes = [boxAround([solidOf(BAR)])];
  const { box } = frame(boxes, [0, 0.2, 1, 100].map(rowAt), LAYOUT);
  assertNear(box.high, [2.2, 0.1, 0.2]);
});

for (const preset of ["front", "side", "top", "free"])
  test(`all of a box is in the picture from the ${preset}, and some of it near the edge`, () => {
    const box = { low: [-3, -1, 0], high: [1, 2, 5] };
    const room = { w: 700, h: 500, shift: 10 };
    const see = lens(aim(preset, box, { aspect: room.w / room.h, share: 0.8 }), room);
    const corners = [0, 1, 2, 3, 4, 5, 6, 7].map((k) =>
      [0, 1, 2].map((i) => ((k >> i) & 1 ? box.high[i] : box.low[i])),
    );
    const margins = corners.map((corner) => {
      const [x, y] = see(corner);
      return Math.min(x, room.w - x, y - 60, 460 - y);
    });
    assert.ok(Math.min(...margins) > 0, margins);
    assert.ok(Math.min(...margins) < 70, margins);
  });
