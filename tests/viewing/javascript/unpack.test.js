import assert from "node:assert/strict";
import { test } from "node:test";

import { assertNear, assets, packIntegers, scene } from "./pages.js";

const { gunzip, layoutOf, openParcel, readIntegers, Table, turn } = await import(
  new URL("data/unpack.js", assets)
);

test("integers come back, also large and negative ones", () => {
  const values = [0, -1, 1, 63, -64, 64, 12345, -12345, 2 ** 40, -(2 ** 40) - 1];
  const bytes = packIntegers(values);
  const out = new Float64Array(values.length);
  assert.equal(readIntegers(bytes, 0, values.length, out), bytes.length);
  assert.deepEqual([...out], values);
});

test("reading starts and ends where it is told to", () => {
  const bytes = packIntegers([7, 300, -5, 9]);
  const out = new Float64Array(2);
  assert.equal(readIntegers(bytes, 1, 2, out), bytes.length - 1);
  assert.deepEqual([...out], [300, -5]);
});

test("a parcel is its header and its parts", () => {
  const header = new TextEncoder().encode(JSON.stringify({ title: "θ", parts: [2, 0, 1] }));
  const bytes = new Uint8Array(4 + header.length + 3);
  new DataView(bytes.buffer).setUint32(0, header.length, true);
  bytes.set(header, 4);
  bytes.set([1, 2, 3], 4 + header.length);
  const parcel = openParcel(bytes);
  assert.equal(parcel.header.title, "θ");
  assert.deepEqual(
    parcel.parts.map((part) => [...part]),
    [[1, 2], [], [3]],
  );
});

test("what was compressed is what is read", async () => {
  const text = "θ̈ + 3 g / 2 l sin θ = 0";
  const squeezed = new Blob([text]).stream().pipeThrough(new CompressionStream("gzip"));
  const bytes = new Uint8Array(await new Response(squeezed).arrayBuffer());
  assert.equal(new TextDecoder().decode(await gunzip(bytes)), text);
});

test("a row holds bodies, arrows, lines, traces, series and the ledger, one after another", () => {
  const layout = layoutOf(scene({ bodies: 2, arrows: 3, lines: 1, traces: 1, series: 4 }));
  assert.deepEqual(layout, {
    bodies: 0,
    arrows: 14,
    lines: 32,
    traces: 38,
    series: 41,
    ledger: 45,
    end: 47,
  });
});

test("a quaternion turns a vector", () => {
  const half = Math.SQRT1_2;
  const turned = turn([0, 0, half, half], [1, 0, 2]);
  assertNear(turned, [0, 1, 2]);
});

// One body at (2, 0, 0) that turns about z from 0 to a right angle; a point fixed in it at (1, 0, 0).
function quarterTurn() {
  const integers = [0, 1, 10, 0]; // qz: 0, 1; qw: 10, then differences of order 1
  const packed = {
    n: 2,
    first: 1,
    dt: 0.5,
    start: [2, 0, 0, 0, 0, NaN, NaN, NaN, NaN, NaN],
    orders: [-1, -1, -1, -1, -1, 0, 1, -1, -1, -1],
    steps: [0, 0, 0, 0, 0, 1, 0.1, 0, 0, 0],
    anchors: [[7, 0, 1, 0, 0]],
  };
  return new Table(packed, packIntegers(integers));
}

test("columns are sums of differences times their step; others stay as they start", () => {
  const table = quarterTurn();
  assert.equal(table.last, 1.5);
  assert.equal(table.time(1), 1.5);
  assert.deepEqual([table.value(0, 5), table.value(1, 5)], [0, 1]);
  assert.deepEqual([table.value(0, 6), table.value(1, 6)], [1, 1]);
  assert.equal(table.value(1, 0), 2);
});

test("between key frames quaternions stay of unit length, and fixed points turn with the body", () => {
  const row = quarterTurn().row(1.25, 1, new Float64Array(10));
  assert.ok(Math.abs(Math.hypot(...row.subarray(3, 7)) - 1) < 1e-12);
  const angle = 2 * Math.atan2(0.5, 1);
  assertNear(row.subarray(7), [2 + Math.cos(angle), Math.sin(angle), 0]);
});

test("time beyond the ends is that of the ends", () => {
  const table = quarterTurn();
  assert.equal(table.index(-3), 0);
  assert.equal(table.index(99), 1);
  assertNear(table.row(99, 1, new Float64Array(10)).subarray(5, 7), [Math.SQRT1_2, Math.SQRT1_2]);
});

test("samples are evenly spread, and no more than there are instants", () => {
  const table = quarterTurn();
  assert.equal(table.sample(240, 1, 10).length, 2);
  const cosines = table.sample(2, 1, 10).map((row) => row[6]);
  assertNear(cosines, [1, Math.SQRT1_2]);
});
