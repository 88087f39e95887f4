import assert from "node:assert/strict";
import { test } from "node:test";

import { assets, assertNear } from "./pages.js";

const load = (name) => import(new URL(`engine/${name}.js`, assets));
const { Integrator, findEvents } = await load("dop853");
const { Machine } = await load("machine");
const { Bench, readFragment, writeFragment, writePython } = await load("bench");
const { Grip } = await load("grip");
const { Loops } = await load("loops");
const { Computed, quaternionOf } = await load("computed");
const { general } = await load("../data/numbers");

function oscillator(t, y, out) {
  out[0] = y[1];
  out[1] = -y[0];
}

test("an oscillation ends where it should, in the order of the method", () => {
  const errors = [1e-5, 1e-8, 1e-11].map((rtol) => {
    const path = new Integrator(oscillator, { rtol, counted: 2 }).run(0, [1, 0], 20);
    const [x, v] = path.at(20, new Float64Array(2));
    assert.equal(path.last, 20);
    return Math.hypot(x - Math.cos(20), v + Math.sin(20));
  });
  errors.forEach((error, k) => assert.ok(error < 50 * [1e-5, 1e-8, 1e-11][k], errors.join()));
  assert.ok(errors[2] < 1e-4 * errors[0]);
});

test("the state between steps is as accurate as the steps", () => {
  const path = new Integrator(oscillator, { rtol: 1e-10, counted: 2 }).run(0, [1, 0], 10);
  for (let t = 0; t <= 10; t += 0.0371)
    assertNearly(path.at(t, new Float64Array(2)), [Math.cos(t), -Math.sin(t)], 1e-8);
});

function assertNearly(found, expected, tolerance) {
  expected.forEach((x, i) =>
    assert.ok(Math.abs(found[i] - x) < tolerance, `${found} ≉ ${expected}`),
  );
}

test("events are found where a function passes through zero, in the direction asked for", () => {
  const path = new Integrator(oscillator, { rtol: 1e-12, counted: 2 }).run(0, [1, 0], 10);
  const crossing = (t, y) => y[0];
  const up = findEvents(path, crossing, 1);
  const all = findEvents(path, crossing, 0);
  assertNearly(up, [1.5 * Math.PI], 1e-10);
  assertNearly(
    all,
    [0.5, 1.5, 2.5].map((k) => k * Math.PI),
    1e-10,
  );
  assert.equal(all.length, 3);
});

test("what passes zero for a moment within a step is found on its way out and back", () => {
  const path = new Integrator(oscillator, { rtol: 1e-12, counted: 2 }).run(0, [1, 0], 10);
  for (const depth of [1e-4, 1e-6]) {
    const half = Math.acos(1 - depth);
    const places = [1, 3].flatMap((k) => [k * Math.PI - half, k * Math.PI + half]);
    assertNearly(
      findEvents(path, (t, y) => y[0] + 1 - depth, 0),
      places,
      1e-8,
    );
  }
  assert.equal(findEvents(path, (t, y) => y[0] + 1 + 1e-6, 0).length, 0);
});

test("a place where rates are rounding alone is passed on the last good step", () => {
  // y = cos 20 t, of which nothing is known around t = 1
  const rates = (t, y, out) => {
    out[0] = y[1];
    out[1] = Math.abs(t - 1) < 0.004 ? NaN : -400 * y[0];
  };
  const given = { rtol: 1e-11, counted: 2, most: 2000 };
  const path = new Integrator(rates, { ...given, settle: () => false, hops: true }).run(
    0,
    [1, 0],
    2,
  );
  assert.equal(path.stopped, "");
  for (let t = 0; t <= 2; t += 0.0371)
    assertNearly(path.at(t, new Float64Array(2)), [Math.cos(20 * t), -20 * Math.sin(20 * t)], 1e-6);
  assert.match(new Integrator(rates, given).run(0, [1, 0], 2).stopped, /no step is short enough/);
});

test("rows that restrain velocities alone leave coordinates where they are", () => {
  // Φ = y0 − 1, and ψ = v0 − v1
  const program = {
    closure: (t, y, p, out) => out.set([y[0] - 1, 0, y[2], y[2] - y[3], 1, 0, 1, -1]),
    rates: (t, y, p, out) => out.set([y[2], y[3], 0, 0, 0]),
  };
  const loops = new Loops(program, { loops: 2, restrained: [1], nq: 2, nv: 2 }, []);
  const y = Float64Array.of(1.5, 7, 3, 5, 0);
  assert.ok(loops.close(0, y));
  assertNearly(y, [1, 7, 0, 0, 0], 1e-12);
});

test("a motion that runs away says where it stops", () => {
  const explode = (t, y, out) => (out[0] = y[0] * y[0]);
  const path = new Integrator(explode, { rtol: 1e-8, counted: 1, most: 5000 }).run(0, [1], 2);
  assert.match(path.stopped, /step/);
  assert.ok(Math.abs(path.last - 1) < 1e-6);
});

test("a rotation matrix becomes its quaternion, whichever component is the largest", () => {
  for (const q of [
    [0.1, 0.2, 0.3, 0.9],
    [0.9, 0.2, -0.3, 0.1],
    [0.1, -0.9, 0.3, 0.2],
    [0.2, 0.1, 0.9, -0.3],
  ]) {
    const size = Math.hypot(...q);
    const [x, y, z, w] = q.map((c) => c / size);
    const matrix = [
      1 - 2 * (y * y + z * z),
      2 * (x * y - z * w),
      2 * (x * z + y * w),
      2 * (x * y + z * w),
      1 - 2 * (x * x + z * z),
      2 * (y * z - x * w),
      2 * (x * z - y * w),
      2 * (y * z + x * w),
      1 - 2 * (x * x + y * y),
    ];
    const out = new Float64Array(4);
    quaternionOf(Float64Array.from(matrix), 0, out, 0);
    const sign = Math.sign(out[3] * w + out[0] * x);
    assertNear(
      [...out].map((c) => sign * c),
      [x, y, z, w],
    );
  }
});

// A mass on a spring: x" = −k x / m.
const engine = {
  coordinates: ["x"],
  velocities: ["x'"],
  parameters: ["m", "k"],
  values: [1, 4],
  start: [1, 0],
  first: 0,
  duration: 2,
  rtol: 1e-10,
  quaternions: [],
  loops: 0,
  unknown: [],
  resized: [],
  python: 'mq.textbook.load("spring")',
};
const program = {
  rates(t, y, p, out) {
    out[0] = y[1];
    out[1] = (-p[1] * y[0]) / p[0];
    out[2] = 0;
    return out;
  },
  row(t, y, p, out) {
    out.set([y[0], 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1]);
    const [T, V] = [(p[0] * y[1] ** 2) / 2, (p[1] * y[0] ** 2) / 2];
    out.set([T, V, T + V, y[2]], 12);
    return out;
  },
};
const names = ["kinetic", "potential", "total", "work"];
const scene = { bodies: [{}], series: names.map((name) => ({ name: `energy ${name}` })) };
const layout = { series: 7, end: 11 };
const bench = () => new Bench(new Machine(engine, program), scene, layout);

test("what is set moves, can be undone and reset, and the energy stays", () => {
  const set = bench();
  const table = set.set([["parameter", "k", 9]]);
  assert.ok(table instanceof Computed);
  assert.deepEqual([table.first, table.last, table.n], [0, 2, 241]);
  assertNearly([table.row(1.234, 1, new Float64Array(11))[0]], [Math.cos(3 * 1.234)], 1e-8);
  assertNearly([table.value(120, 0)], [Math.cos(3)], 1e-8);
  assert.ok(set.balance() < 1e-9);
  set.set([["initial", "x", 2]]);
  assert.equal(set.get("initial", "x"), 2);
  set.undo();
  assert.deepEqual([set.get("initial", "x"), set.get("parameter", "k")], [1, 9]);
  set.reset();
  assert.equal(set.get("parameter", "k"), 4);
});

test("what makes no sense is refused, and nothing changes", () => {
  const set = bench();
  set.set([["parameter", "k", 9]]);
  assert.throws(() => set.set([["parameter", "k", NaN]]), /finite number for parameter k, got nan/);
  assert.throws(() => set.set([["initial", "x", ""]]), /finite number for coordinate x, got ''/);
  assert.throws(() => set.set([["duration", "", 0]]), /positive duration \[s\], got 0/);
  assert.throws(() => set.set([["rtol", "", 1]]), /rtol in 1e-14…0\.1, got 1/);
  assert.throws(() => set.set([["parameter", "m", 0]]), /The motion x' moves no mass/);
  assert.deepEqual([set.get("parameter", "k"), set.get("parameter", "m")], [9, 1]);
});

test("two motions that together move no mass are named", () => {
  const two = { ...engine, coordinates: ["x", "s"], velocities: ["x'", "s'"], start: [0, 0, 0, 0] };
  // of a mass m at x + s alone
  const joined = {
    rates: (t, y, p, out) => out.fill(NaN),
    row(t, y, p, out) {
      program.row(t, [y[0] + y[1], y[2] + y[3], 0], p, out);
      return out;
    },
  };
  const set = new Bench(new Machine(two, joined), scene, layout);
  assert.throws(() => set.reset(), /A motion of x', s' together moves no mass/);
});

test("an address keeps what was changed and nothing else", () => {
  const set = bench();
  set.set([
    ["parameter", "k", 9.5],
    ["initial", "x'", -1],
    ["rtol", "", 1e-6],
  ]);
  const text = writeFragment(set.changes());
  assert.equal(text, "p.k=9.5&s.x%27=-1&rtol=0.000001");
  const { changes, extra } = readFragment(`#${text}&p.unknown=3&embed=`, engine);
  assert.deepEqual(changes, set.changes());
  assert.deepEqual(extra, { "p.unknown": "3", embed: "" });
});

test("what an address leaves empty or writes otherwise is no number", () => {
  for (const text of ["", " ", "0x10", "Infinity", "1e", "true"]) {
    const { changes } = readFragment(`#p.k=${encodeURIComponent(text)}`, engine);
    assert.throws(() => bench().set(changes), {
      message: `expected a finite number for parameter k, got '${text}'`,
    });
  }
});

test("numbers are written as by Python's format g", () => {
  const told = [-1, 0.00001, 0.0001, 123456, 1234567, 1e-14, -2.5e20, NaN, Infinity].map(general);
  const expected = ["-1", "1e-05", "0.0001", "123456", "1.23457e+06", "1e-14", "-2.5e+20"];
  assert.deepEqual(told, [...expected, "nan", "inf"]);
});

test("the Python repeats the motion", () => {
  const set = bench();
  set.set([["parameter", "k", 9]]);
  const text = writePython(set);
  assert.match(text, /mechanism = mq\.textbook\.load\("spring"\)\n/);
  assert.match(text, /replace\(\*\*\{"k": 9\}\)/);
  assert.match(text, /q=\{"x": 1\},\n +v=\{"x'": 0\}/);
});

// Two coordinates x and y of a point, and a loop that keeps it on the unit circle.
const circle = {
  engine: {
    ...engine,
    coordinates: ["x", "y"],
    velocities: ["x'", "y'"],
    start: [1, 0, 0, 0],
    loops: 1,
  },
  program: {
    rates: (t, y, p, out) => {
      out.set([y[2], y[3], 0, 0, 0]);
      return out;
    },
    row: (t, y, p, out) => {
      out.set([y[0], y[1], 0, 1, 0, 0, 0, 1, 0, 0, 0, 1]);
      return out;
    },
    closure: (t, y, p, out) => {
      const [a, b, c, d] = y;
      out.set([(a * a + b * b - 1) / 2, a * c + b * d, a, b]);
      return out;
    },
  },
};

test("loops are closed near by, what is held stays, and what cannot be closed is said", () => {
  const machine = new Machine(circle.engine, circle.program);
  const setting = { p: [], start: [0.6, 0.7, 0, 1], first: 0 };
  const [x, y, u, v] = machine.begin(setting, ["x"]);
  assertNear([x, y], [0.6, 0.8]);
  assertNear([x * u + y * v], [0]);
  assertNear([Math.hypot(...machine.begin(setting).subarray(0, 2))], [1]);
  assert.throws(() => machine.begin({ ...setting, start: [0, 0, 0, 0] }), /cannot be closed/);
});

test("redundant equations of loops do no harm", () => {
  const twice = (t, y, p, out) => {
    const [phi, rate, a, b] = circle.program.closure(t, y, p, new Float64Array(4));
    out.set([phi, phi, rate, rate, a, b, a, b]);
    return out;
  };
  const loops = new Loops({ ...circle.program, closure: twice }, { loops: 2, nq: 2, nv: 2 }, []);
  const y = Float64Array.from([0.9, 0.6, 0, 0, 0]);
  assert.ok(loops.close(0, y));
  assertNear([Math.hypot(y[0], y[1])], [1]);
});

test("a hand moves a body as far as the loops let it", () => {
  const machine = new Machine(circle.engine, circle.program);
  const computed = { machine, p: [], raw: new Float64Array(12) };
  const grip = new Grip(computed, 0, [1, 0, 0, 0, 0], 0, [0, 0, 0]);
  const state = grip.pull([3, 3, 0]);
  assertNearly(state, [Math.SQRT1_2, Math.SQRT1_2], 1e-6);
});

// A ball that falls on the ground at x = 0, and one that stops at x = 1 on its way down.
const ball = (bounds) => {
  const rates = (t, y, p, out, push) => {
    out.set([y[1], -1 + (push ? push[0] : 0), 0]);
    return out;
  };
  const measures = {
    bounds: (t, y, p, out) => out.set([y[0] - p[2], 0]),
    gradients: (t, y, p, out) => out.set([0, 1]),
  };
  const own = { ...engine, values: [1, 4, 0], parameters: ["m", "k", "x0"], start: [2, 0], bounds };
  return new Machine({ ...own, duration: 20 }, { ...program, rates, ...measures });
};
const GROUND = { words: "on the ground", direction: -1, must: "x must not be below the ground" };

test("a ball bounces back as high as its restitution says", () => {
  const machine = ball([{ ...GROUND, restitution: 0.5 }]);
  const setting = machine.initial();
  const path = machine.move(setting, machine.begin(setting), 5.9);
  assert.equal(path.stopped, "");
  // down 2 s from 2 at g = 1, up and down again for 2 s at half the speed
  assertNearly(path.at(3, new Float64Array(3)), [0.5, 0, -1.5], 1e-9);
  const impacts = [2, 4, 5];
  for (const t of impacts) assertNearly([path.at(t, new Float64Array(3))[0]], [0], 1e-9);
  assertNearly([path.at(5.25, new Float64Array(3))[0]], [0.25 * 0.25 - 0.25 ** 2 / 2], 1e-9);
});

test("impacts without end are the end, and so is a bound without restitution", () => {
  const resting = ball([{ ...GROUND, restitution: 0.5 }]);
  const setting = resting.initial();
  const path = resting.move(setting, resting.begin(setting), 20);
  assert.equal(path.stopped, "on the ground, where impacts follow one another without end");
  assertNearly([path.last], [6], 1e-6);
  const stopping = ball([{ ...GROUND, restitution: null }]);
  const short = stopping.move(setting, stopping.begin(setting), 20);
  assert.equal(short.stopped, "on the ground");
  assertNearly([short.last], [2], 1e-10);
  const below = { ...setting, start: [-1, 0] };
  assert.throws(() => stopping.begin(below), /must not be below the ground/);
});
