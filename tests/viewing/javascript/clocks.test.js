import assert from "node:assert/strict";
import { test } from "node:test";

import { assets } from "./pages.js";

const { History } = await import(new URL("clock/history.js", assets));
const { LiveClock } = await import(new URL("clock/live.js", assets));
const { Player } = await import(new URL("clock/player.js", assets));
const { Gauge } = await import(new URL("picture/gauge.js", assets));

test("a history finds the instant before a time, and the part of the way to the next", () => {
  const history = new History(1);
  for (const t of [0, 1, 3]) history.add(t, [10 * t]);
  assert.deepEqual([history.first, history.last, history.n], [0, 3, 3]);
  assert.deepEqual(
    [-1, 0.5, 2, 9].map((t) => history.index(t)),
    [0, 0.5, 1.5, 2],
  );
  assert.equal(history.value(2, 0), 30);
});

test("a history begins anew when time goes back, and is bounded", () => {
  const history = new History(1);
  for (let k = 0; k < 10_000; k++) history.add(k / 60, [k]);
  assert.ok(history.n <= 3600);
  assert.equal(history.value(history.n - 1, 0), 9999);
  history.add(0, [0]);
  assert.equal(history.n, 1);
});

test("a live clock looks back at the recent past, and returns to the present", () => {
  const sent = [];
  globalThis.WebSocket = class {
    static OPEN = 1;
    readyState = 1;
    send = (text) => sent.push(JSON.parse(text));
  };
  globalThis.location = { host: "here", pathname: "/" };
  const clock = new LiveClock({ first: 0, id: "a" }, 2);
  clock.connect();
  const frame = (time, row, passed) => {
    const bytes = new ArrayBuffer(16 + 4 * (row.length + passed.length));
    new Uint32Array(bytes, 0, 2).set([7, passed.length]);
    new Float64Array(bytes, 8, 1).set([time]);
    new Float32Array(bytes, 16).set([...row, ...passed]);
    clock.receive(bytes);
  };
  frame(1, [10, 11], []);
  assert.ok(clock.tick() && !clock.seekable);
  // of a frame that comes before the one before it is drawn, the places passed are kept
  frame(1.5, [15, 16], [1, 2, 3]);
  frame(2, [20, 21], [4, 5, 6]);
  assert.ok(clock.tick() && clock.seekable);
  assert.deepEqual(
    clock.passed.map((each) => [...each]),
    [
      [1, 2, 3],
      [4, 5, 6],
    ],
  );
  clock.seek(1.2);
  assert.ok(clock.tick() && clock.past);
  assert.deepEqual([clock.time, ...clock.row], [1.2, 10, 11]);
  clock.play();
  frame(3, [30, 31], []);
  assert.ok(clock.tick() && !clock.past);
  assert.deepEqual([clock.time, ...clock.row], [3, 30, 31]);
  assert.deepEqual(sent.at(-1), { do: "ack", value: 7 });
});

const table = { first: 0, last: 2, n: 121, dt: 1 / 60 };

test("a player repeats its motion at the speed that is set", () => {
  const player = new Player(table);
  player.setSpeed(2);
  player.play();
  for (const now of [0, 250, 500]) player.tick(now);
  assert.equal(player.time, 1);
  player.tick(1250);
  assert.equal(player.time, 0.5);
});

test("a player that does not repeat stops at the end, and starts over", () => {
  const player = new Player(table);
  player.looping = false;
  player.play();
  for (const now of [0, 5000]) player.tick(now);
  assert.deepEqual([player.time, player.playing], [2, false]);
  player.play();
  assert.equal(player.time, 0);
});

test("steps and seeking stay within the motion", () => {
  const player = new Player(table);
  player.step(-1);
  assert.equal(player.time, 0);
  player.step(1);
  assert.equal(player.time, 1 / 60);
  player.seek(9);
  assert.equal(player.time, 2);
});

test("the largest force that is shown is as long as any; a rare peak is cut", () => {
  const items = [
    { kind: "weight", unit: "N", column: 0 },
    { kind: "load", unit: "N", column: 6 },
  ];
  const gauge = new Gauge(items);
  const sizes = [10, ...Array.from({ length: 99 }, () => 1)];
  gauge.survey({ n: 100, value: (k, j) => ({ 5: 2, 11: sizes[k] })[j] ?? 0 });
  gauge.fit(() => true);
  assert.equal(gauge.share(items[0], 2), 1);
  assert.equal(gauge.share(items[1], 10), 5);
  assert.equal(gauge.length(items[1], 10, 1), 0.28);
  gauge.common = false;
  gauge.fit(() => true);
  assert.equal(gauge.share(items[1], 1.25), 1);
  const kinds = { weight: { label: "Weight" }, load: { label: "Loads" } };
  assert.equal(gauge.describe(1, kinds), "Weight: 1 m ≙ 7.14 N · Loads: 1 m ≙ 4.46 N");
});

test("a motion that is over in a moment is shown in ten seconds", () => {
  assert.equal(new Player({ first: 0, last: 0.03, n: 241, dt: 0.03 / 240 }).speed, 0.003);
  assert.equal(new Player({ first: 0, last: 5, n: 301, dt: 1 / 60 }).speed, 1);
});

test("a motion without end is carried on when its end is reached, unless it is repeated", () => {
  const player = new Player({ first: 0, last: 1, n: 61, dt: 1 / 60 });
  player.onend = () => {
    player.take({ first: 0, last: 2, n: 121, dt: 1 / 60 });
    return true;
  };
  player.seek(0.9);
  player.play();
  player.tick(0);
  player.tick(300);
  assert.ok(Math.abs(player.time - 0.2) < 1e-12, "repeated");
  player.looping = false;
  player.seek(0.9);
  player.tick(400);
  player.tick(600);
  assert.ok(Math.abs(player.time - 1.2) < 1e-12, "carried on");
  assert.equal(player.last, 2);
  assert.equal(player.playing, true);
});
