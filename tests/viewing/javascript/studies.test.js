// What a page can do with its program besides moving: modes, sections, pulling, second motions.

import assert from "node:assert/strict";
import { test } from "node:test";

import { assets } from "./pages.js";

const load = (name) => import(new URL(`${name}.js`, assets));
const { Bench, readFragment, writeFragment } = await load("engine/bench");
const { Machine } = await load("engine/machine");
const { SmallMotions, eigen, isUnstable } = await load("engine/modes");
const { Section, describeSwing } = await load("engine/section");
const { Pull } = await load("engine/pull");
const { exaggerate } = await load("picture/exaggeration");
const { paceOf } = await load("studies/modes");
const { apart, describeParting } = await load("studies/beside");

test("modes are shown at a speed at which they are easily followed", () => {
  assert.deepEqual([1, 2, 5].map(paceOf), [1, 1, 1]);
  assert.deepEqual([0.874, 0.05, 0.0021, 30].map(paceOf), [0.2, 0.02, 0.001, 10]);
});

const near = (found, expected, tolerance = 1e-9) =>
  assert.ok(Math.abs(found - expected) < tolerance, `${found} ≉ ${expected}`);

// A block of mass m on a spring k and a damper c, along x; row: its pose, then x.
const BLOCK = {
  engine: {
    coordinates: ["x"],
    velocities: ["x'"],
    parameters: ["m", "k", "c"],
    values: [2, 18, 0.6],
    start: [0.4, 0],
    first: 0,
    duration: 6,
    rtol: 1e-10,
    quaternions: [],
    loops: 0,
    unknown: [],
    resized: [],
    python: "",
  },
  program: {
    rates: (t, y, p, out, tau) => {
      out[0] = y[1];
      out[1] = (-p[1] * y[0] - p[2] * y[1] + (tau ? tau[0] : 0)) / p[0];
      out[2] = -p[2] * y[1] * y[1];
      return out;
    },
    row: (t, y, p, out) => {
      out.fill(0);
      out[0] = y[0];
      out[3] = out[7] = out[11] = 1;
      out[12] = y[0];
      return out;
    },
  },
};
const LAYOUT = { bodies: 0, arrows: 7, lines: 7, traces: 7, series: 7, ledger: 8, end: 8 };
const bench = () =>
  new Bench(new Machine(BLOCK.engine, BLOCK.program), { bodies: [{}], series: [] }, LAYOUT);

test("eigenvalues and eigenvectors of a symmetric matrix", () => {
  const A = [
    [4, 1, -2],
    [1, 2, 0],
    [-2, 0, 3],
  ];
  const { values, vectors } = eigen(A);
  values.forEach((value, k) => {
    const x = vectors.map((row) => row[k]);
    A.forEach((row, i) =>
      near(
        row.reduce((sum, a, j) => sum + a * x[j], 0),
        value * x[i],
      ),
    );
  });
});

test("what grows is told from what sways, dies out or goes away steadily", () => {
  const none = [[0]];
  const grows = [
    [[[-1e-2]], none, none],
    [[[1]], [[-1e-3]], none], // driven by its own motion
    [[[1]], none, [[-1e-3]]],
    // flutter: ω⁴ − 2 ω² + 1 + 0.01 = 0
    [
      [
        [1, 0.1],
        [-0.1, 1],
      ],
      [
        [0, 0],
        [0, 0],
      ],
      [
        [0, 0],
        [0, 0],
      ],
    ],
  ];
  for (const [K, R, C] of grows) assert.equal(isUnstable(K, R, C), true);
  const stays = [
    [[[1]], none, none],
    [[[100]], [[1e-3]], none],
    [none, none, none], // free: it goes on steadily
    [none, [[2]], none],
    // a top that spins fast sleeps: ω² ± 3 ω + 1 = 0
    [
      [
        [-1, 0],
        [0, -1],
      ],
      [
        [0, 3],
        [-3, 0],
      ],
      [
        [0, 0],
        [0, 0],
      ],
    ],
  ];
  for (const [K, R, C] of stays) assert.equal(isUnstable(K, R, C), false);
});

test("a block on a spring rests at zero and has its natural frequency and damping", () => {
  const { machine, setting } = bench();
  const { y, modes } = new SmallMotions(machine, setting).find(machine.begin(setting));
  near(y[0], 0);
  assert.equal(modes.length, 1);
  near(Math.sqrt(modes[0].square), 3);
  near(modes[0].damping, 0.6 / (2 * 2 * 3));
  assert.deepEqual(modes[0].shape, [1]);
});

// A bead of mass 1 on a hoop of radius 1 that turns at w about the vertical: θ'' = sin θ (w² cos θ − g).
const BEAD = {
  engine: {
    ...BLOCK.engine,
    coordinates: ["theta"],
    velocities: ["theta'"],
    parameters: ["g", "w"],
    values: [9.81, 4],
    start: [0.7, 0],
  },
  program: {
    rates: (t, y, p, out, tau) => {
      out[0] = y[1];
      out[1] = Math.sin(y[0]) * (p[1] ** 2 * Math.cos(y[0]) - p[0]) + (tau ? tau[0] : 0);
      out[2] = 0;
      return out;
    },
  },
};

test("all positions of rest of a bead on a hoop are found, with their stability", () => {
  const machine = new Machine(BEAD.engine, BEAD.program);
  const setting = machine.initial();
  const small = new SmallMotions(machine, setting);
  const { rests } = [...small.search(machine.begin(setting), [Math.PI], [true])].at(-1);
  const found = rests.map(({ y, modes }) => [y[0], modes[0].square]).sort(([a], [b]) => a - b);
  const aside = Math.acos(9.81 / 16);
  const expected = [
    [-aside, 16 * Math.sin(aside) ** 2],
    [0, 9.81 - 16],
    [aside, 16 * Math.sin(aside) ** 2],
    [Math.PI, -9.81 - 16],
  ];
  assert.equal(found.length, 4);
  found.flat().forEach((x, k) => near(x, expected.flat()[k], 1e-5));
  near(rests[0].y[0], aside, 1e-8); // that downhill from the start comes first
});

test("positions that only look alike are all found, and the search tells how far it is", () => {
  // the same bead on a hoop that may be turned by hand to any psi
  const engine = {
    ...BEAD.engine,
    coordinates: ["psi", "theta"],
    velocities: ["psi'", "theta'"],
    start: [0.3, 0.7, 0, 0],
  };
  const rates = (t, y, p, out, tau) => {
    const theta = BEAD.program.rates(t, [y[1], y[3]], p, [0, 0, 0], tau && [tau[1]]);
    out.set([y[2], y[3], tau ? tau[0] : 0, theta[1], 0]);
    return out;
  };
  const machine = new Machine(engine, { rates });
  const small = new SmallMotions(machine, machine.initial());
  const from = machine.begin(machine.initial());
  const steps = [...small.search(from, [Math.PI, Math.PI], [true, true])];
  const { rests } = steps.at(-1);
  const aside = Math.acos(9.81 / 16);
  const found = rests.map(({ y }) => y[1]).sort((a, b) => a - b);
  [-aside, 0, aside, Math.PI].forEach((x, k) => near(found[k], x, 1e-5));
  assert.equal(found.length, 4);
  rests.forEach(({ y }) => near(y[0], 0.3, 1e-5));
  // after so many starts as four positions need: 2 · 4² + 3 · 4 + 2
  assert.ok(steps.length > 46);
  assert.equal(steps[0].part, 0);
  assert.equal(steps.at(-1).part, 1);
});

// A cart of mass M on a level track with a pendulum of mass 1 and length 1: x is free.
const CART = {
  engine: {
    ...BLOCK.engine,
    coordinates: ["x", "q"],
    velocities: ["x'", "q'"],
    parameters: ["M", "g"],
    values: [2, 9.81],
    start: [3, 1, 0, 0],
  },
  program: {
    rates: (t, y, p, out, tau) => {
      const [c, s] = [Math.cos(y[1]), Math.sin(y[1])];
      const [a, b] = [s * y[3] ** 2 + (tau ? tau[0] : 0), -p[1] * s + (tau ? tau[1] : 0)];
      const determinant = p[0] + s * s;
      out.set([y[2], y[3], (a - c * b) / determinant, ((p[0] + 1) * b - c * a) / determinant, 0]);
      return out;
    },
  },
};

test("what is free stays where it starts, and the pole rests below and above the cart", () => {
  const machine = new Machine(CART.engine, CART.program);
  const from = machine.begin(machine.initial());
  const small = new SmallMotions(machine, machine.initial());
  const { rests } = [...small.search(from, [20, Math.PI], [false, true])].at(-1);
  assert.equal(rests.length, 2);
  rests.forEach(({ y, modes }, k) => {
    near(y[0], 3, 1e-6);
    near(y[1], k * Math.PI, 1e-6);
    const squares = modes.map(({ square }) => square);
    near(Math.max(...squares.map(Math.abs)), (9.81 * 3) / 2, 1e-6);
    assert.ok(squares.includes(0));
  });
});

test("a mode moves by its own sine", () => {
  const { machine, setting } = bench();
  const small = new SmallMotions(machine, setting);
  const { y, modes } = small.find(machine.begin(setting));
  const path = small.path(y, modes[0], 0.2, 2);
  near(path.last, (2 * 2 * Math.PI) / 3, 1e-8);
  const [x, v] = path.at(0.3, new Float64Array(3));
  near(x, 0.2 * Math.sin(0.9), 1e-8);
  near(v, 0.6 * Math.cos(0.9), 1e-8);
});

test("a section holds the state whenever a number passes zero upwards", () => {
  const own = bench();
  own.set([["parameter", "c", 0]]);
  const section = new Section(own.table, 0, false);
  while (section.n < 3) section.extend();
  const period = (2 * Math.PI) / 3;
  section.times.forEach((t, k) => near(t, (k + 0.75) * period, 1e-7));
  near(section.value(1, 7), 0, 1e-7);
});

test("what is pulled comes to where the hand and its own spring balance", () => {
  const own = bench();
  const computed = own.adopt(own.setting);
  const pull = new Pull(computed, 0, [0, 0, 0], 0, [0, 0, 0]);
  pull.target = [1, 0, 0];
  for (let k = 0; k < 400; k++) pull.advance(0.02);
  // 40 m (1 − x) = k x
  near(pull.y[0], 80 / (80 + 18), 1e-3);
  near(pull.y[1], 0, 1e-3);
  assert.equal(own.machine.force, null);
});

test("a second motion starts beside the first, and a link keeps it", () => {
  const own = bench();
  const table = own.set([["beside", "x", 0.01]]);
  near(apart(table, 0, [7]), 0.01, 1e-12);
  assert.match(describeParting(table, [7]), /starts are 0.010 apart/);
  const text = writeFragment(own.changes());
  assert.equal(text, "b.x=0.01");
  assert.deepEqual(readFragment(`#${text}`, BLOCK.engine).changes, [["beside", "x", 0.01]]);
  assert.throws(
    () => own.set([["beside", "x", NaN]]),
    /finite number for the difference in x, got nan/,
  );
  assert.deepEqual(own.neighbor, { x: 0.01 });
  assert.equal(own.set([["beside", "x", 0]]).other, null);
});

test("a second motion may start otherwise in several numbers", () => {
  const own = bench();
  const velocity = own.machine.names[1];
  const table = own.set([
    ["beside", "x", 0.3],
    ["beside", velocity, -0.4],
  ]);
  const [first, second] = [table, table.other].map((each) => [...each.stateAt(each.first)]);
  near(second[0] - first[0], 0.3, 1e-12);
  near(second[1] - first[1], -0.4, 1e-12);
  assert.deepEqual(own.changes(), [
    ["beside", "x", 0.3],
    ["beside", velocity, -0.4],
  ]);
  own.set([["beside", "x", 0]]);
  assert.deepEqual(own.neighbor, { [velocity]: -0.4 });
});

test("displacements and turns from rest are multiplied", () => {
  const half = (angle) => [0, Math.sin(angle / 2), 0, Math.cos(angle / 2)];
  const rest = Float64Array.of(1, 2, 3, ...half(0.3), 5);
  const row = Float64Array.of(1.1, 2, 2.9, ...half(0.4), 6);
  const out = exaggerate(row, rest, 5, LAYOUT, new Float64Array(8));
  [1.5, 2, 2.5, ...half(0.8), 6].forEach((x, k) => near(out[k], x));
});

test("what a single coordinate does is said in words", () => {
  const own = bench();
  const free = own.set([["parameter", "c", 0]]);
  assert.equal(describeSwing(own.machine, free.path), "Period 2.09 s. ");
  const damped = own.set([["parameter", "c", 12]]);
  assert.equal(describeSwing(own.machine, damped.path), "");
  const gone = own.set([
    ["parameter", "c", 0],
    ["parameter", "k", 0],
    ["initial", "x'", 2],
  ]);
  assert.equal(describeSwing(own.machine, gone.path), "Swings through. ");
});
