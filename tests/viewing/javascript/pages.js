// The modules under test, and small scenes whose every number is known.

import assert from "node:assert/strict";

export const assets = new URL("../../../src/mecanique/viewing/page/assets/", import.meta.url);

export function assertNear(found, expected) {
  assert.equal(found.length, expected.length);
  expected.forEach((x, i) => assert.ok(Math.abs(found[i] - x) < 1e-12, `${found} ≉ ${expected}`));
}

// Integers as the page's maker packs them: the sign in the lowest bit, seven bits a byte.
export function packIntegers(values) {
  const bytes = [];
  for (const value of values) {
    let rest = value < 0 ? -2 * value - 1 : 2 * value;
    while (rest >= 128) {
      bytes.push((rest % 128) + 128);
      rest = Math.floor(rest / 128);
    }
    bytes.push(rest);
  }
  return Uint8Array.from(bytes);
}

export function scene({ bodies = 1, arrows = 0, lines = 0, traces = 0, series = 0 } = {}) {
  const many = (count) => Array.from({ length: count }, (_, i) => ({ name: `n${i}` }));
  return {
    bodies: many(bodies),
    arrows: many(arrows),
    lines: many(lines),
    traces: many(traces),
    series: many(series),
    ledger: { coordinates: ["q"], rows: ["weight", "inertia"] },
  };
}
