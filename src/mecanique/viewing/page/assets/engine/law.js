// The law of modes: the forces and accelerations of each mode, which follow in a state, and impacts
// (F. Pfeiffer, C. Glocker, Multibody Dynamics with Unilateral Contacts, 1996).
//
// The program gives the terms of a state, M a = load + Jᵀ λ with J a + γ = 0. A mode has the state of
// each element, its name and its heading: the direction of slip along the element's tangents, or of
// what sticks that against which all of its static friction is used. Slip in space that begins goes
// along the direction in which it grows until it has begun, as slow slip turns towards that at once.
// All modes are tried, so that none, one and several solutions are told apart. In C corners.c has the
// same law.

import { dot } from "../data/vectors.js";

export const OPEN = "open";
export const STICKS = "sticks";
const [CLOSES, FORWARD, BACKWARD, SLIPS] = ["closed", "slips +", "slips -", "slips"];
const NO_SPEED = 1e-300; // so that a bound on what is at rest is not zero, and may divide

// Why no motion goes on from a state.
export class Undecided extends Error {}

const stand = (name, heading = null, begins = false) => ({ name, heading, begins });
const point = (slip) =>
  stand(
    SLIPS,
    slip.map((x) => x / Math.hypot(...slip)),
  );
const IN_LINE = [
  stand(FORWARD, [1]),
  stand(BACKWARD, [-1]),
  stand(STICKS, [1]),
  stand(STICKS, [-1]),
];

export const isHeld = ({ name }) => name !== OPEN;
export const isKept = ({ name, heading }) => name === STICKS && heading !== null;
const slips = ({ name, heading }) => name !== STICKS && heading !== null;
const isSought = ({ name, heading }) => name === SLIPS && !heading;
export const keyOf = (mode) => JSON.stringify(mode);

export const within = (a, b) => a.reduce((sum, x, i) => sum + Math.abs(x * b[i]), 0);
const most = (a) => a.reduce((largest, x) => Math.max(largest, Math.abs(x)), 0);

// Every choice of one of each list.
function* choose(lists, chosen = []) {
  const at = chosen.length;
  if (at === lists.length) yield chosen;
  else for (const each of lists[at]) yield* choose(lists, [...chosen, each]);
}

// What gives M⁻¹ of a vector: M = L D Lᵀ.
function factorize(mass) {
  const n = mass.length;
  const L = mass.map((row) => [...row]);
  for (let j = 0; j < n; j++)
    for (let i = j; i < n; i++) {
      for (let k = 0; k < j; k++) L[i][j] -= L[i][k] * L[k][k] * L[j][k];
      if (i > j) L[i][j] /= L[j][j];
    }
  return (b) => {
    const x = [...b];
    for (let i = 0; i < n; i++) for (let k = 0; k < i; k++) x[i] -= L[i][k] * x[k];
    for (let i = n - 1; i >= 0; i--) {
      x[i] /= L[i][i];
      for (let k = i + 1; k < n; k++) x[i] -= L[k][i] * x[k];
    }
    return x;
  };
}

// Where the largest number of a square stands, from row and column k on.
function findPivot(rows, k, n) {
  let [row, column] = [k, k];
  for (let i = k; i < n; i++)
    for (let j = k; j < n; j++)
      if (Math.abs(rows[i][j]) > Math.abs(rows[row][column])) [row, column] = [i, j];
  return [row, column];
}

// Solves equations by elimination with the largest pivot of all; null if they are dependent, to a
// part of the first pivot.
function eliminate(matrix, right, dependent) {
  const n = right.length;
  const rows = matrix.map((row, i) => [...row, right[i]]);
  const order = [...rows.keys()];
  let first = 0;
  for (let k = 0; k < n; k++) {
    const [row, column] = findPivot(rows, k, n);
    const pivot = rows[row][column];
    if (k === 0) first = Math.abs(pivot);
    if (!(Math.abs(pivot) > dependent * first)) return null;
    [rows[k], rows[row]] = [rows[row], rows[k]];
    for (const each of rows) [each[k], each[column]] = [each[column], each[k]];
    [order[k], order[column]] = [order[column], order[k]];
    for (let i = k + 1; i < n; i++) {
      const part = rows[i][k] / pivot;
      for (let j = k; part !== 0 && j <= n; j++) rows[i][j] -= part * rows[k][j];
    }
  }
  const x = new Array(n);
  for (let i = n - 1; i >= 0; i--) {
    let sum = rows[i][n];
    for (let j = i + 1; j < n; j++) sum -= rows[i][j] * x[order[j]];
    x[order[i]] = sum / rows[i][i];
  }
  return x;
}

export class Law {
  constructor({ elements, positional, tolerances, length }, program, nq, nv) {
    Object.assign(this, { elements, positional, tolerances, length, program, nq, nv });
    const [m, count] = [positional.length, elements.length];
    this.size = nq + nv * (nv + 1 + m) + 3 * m + 6 * count;
    this.none = new Array(nv).fill(0);
  }

  // The terms of a state, with M⁻¹ of the rows and of the load.
  measure(t, y, p, force) {
    const { nq, nv, positional, elements } = this;
    const out = this.program.terms(t, y, p, new Float64Array(this.size), force);
    let at = nq;
    const take = (size) => Array.from(out.subarray(at, (at += size)));
    const takeRows = (number) => Array.from({ length: number }, () => take(nv));
    const [mass, load] = [takeRows(nv), take(nv)];
    const slopes = takeRows(positional.length);
    const [gamma, gaps, rates] = [0, 1, 2].map(() => take(positional.length));
    const byElement = Array.from({ length: 6 }, () => take(elements.length));
    const [inside, kinetic, sticking, restitution, stiffness, holds] = byElement;
    const invert = factorize(mass);
    return Object.assign(
      { mass, load, slopes, gamma, gaps, rates, steps: slopes.map(invert), free: invert(load) },
      { inside, kinetic, sticking, restitution, stiffness, holds },
    );
  }

  isElastic(k) {
    const { normal, struck } = this.elements[k];
    return normal !== null && !struck;
  }

  // What a mode is solved for: the accelerations of a state, or what velocities change by at an
  // impact, after which the rates of rows are zero where no others are named.
  accelerate({ load, free, gamma, sticking, holds }) {
    return { load, free, wanted: gamma.map((x) => -x), sticking, holds, given: new Map() };
  }

  strike({ rates, kinetic, holds }, targets, given = new Map()) {
    const wanted = rates.map((rate, row) => (targets.get(row) ?? 0) - rate);
    const none = holds.map(() => 0);
    const load = this.none;
    return { load, free: load, wanted, sticking: kinetic, holds: none, given, impact: true };
  }

  // The rows that a mode holds, which forces are known, and how much friction a force brings along.
  hold(terms, mode, { sticking, given, impact }) {
    const held = [];
    const known = terms.gaps.map(() => 0);
    this.elements.forEach(({ normal, tangents }, k) => {
      if (!isHeld(mode[k])) return;
      if (normal !== null && this.isElastic(k))
        known[normal] = impact ? 0 : -terms.stiffness[k] * terms.gaps[normal];
      else if (given.has(normal)) known[normal] = given.get(normal);
      else if (normal !== null) held.push(normal);
      if (mode[k].name === STICKS && !mode[k].heading) held.push(...tangents);
    });
    const shares = held.map(() => []);
    this.elements.forEach(({ tangents, pressing }, k) => {
      const limit = isKept(mode[k]) ? sticking[k] : terms.kinetic[k];
      const place = held.indexOf(pressing);
      mode[k].heading?.forEach((part, i) => {
        const friction = -limit * part;
        if (pressing === null) known[tangents[i]] = impact ? 0 : friction;
        else if (place >= 0) shares[place].push([tangents[i], friction]);
        else known[tangents[i]] = friction * known[pressing];
      });
    });
    return { held, known, shares };
  }

  // Accelerations and the forces of all rows in a mode; null if rigid bodies do not determine them.
  solve(terms, mode, drive) {
    const { slopes, steps } = terms;
    const { held, known, shares } = this.hold(terms, mode, drive);
    const a = [...drive.free];
    const add = (vector, factor) => vector.forEach((x, i) => (a[i] += factor * x));
    known.forEach((force, row) => force !== 0 && add(steps[row], force));
    const yielding = held.map((row, c) =>
      shares[c].reduce(
        (sum, [tangent, part]) => sum.map((x, i) => x + part * steps[tangent][i]),
        steps[row],
      ),
    );
    // rows in the metric of kinetic energy, so that pivots are comparable
    const size = held.map((row) => Math.sqrt(dot(slopes[row], steps[row])) || 1);
    const system = held.map((row, r) =>
      yielding.map((way, c) => dot(slopes[row], way) / size[r] / size[c]),
    );
    const right = held.map((row, r) => (drive.wanted[row] - dot(slopes[row], a)) / size[r]);
    const { REDUNDANT } = this.tolerances;
    if (held.length === 1) {
      const summed = within(slopes[held[0]], yielding[0]) / size[0] ** 2;
      if (!(Math.abs(system[0][0]) > REDUNDANT * summed)) return null;
    }
    const pushes = eliminate(system, right, REDUNDANT)?.map((x, c) => x / size[c]);
    if (!pushes) return null;
    const forces = [...known];
    pushes.forEach((push, c) => {
      add(yielding[c], push);
      forces[held[c]] += push;
      for (const [tangent, part] of shares[c]) forces[tangent] += part * push;
    });
    for (const row of held) {
      // a coordinate that sticks does not creep, not even by rounding
      const entries = slopes[row].flatMap((x, i) => (x === 0 ? [] : [i]));
      if (entries.length === 1) a[entries[0]] = drive.wanted[row] / slopes[row][entries[0]];
    }
    return { mode, a, forces };
  }

  // A mode with the directions of slip in space that a state has: as rounding, or past its end, slip
  // points anywhere, and the mode's direction is kept.
  alongSlip({ rates }, mode, rounding) {
    return mode.map((state, k) => {
      if (state.name !== SLIPS || state.begins) return state;
      const slip = this.elements[k].tangents.map((row) => rates[row]);
      const speed = Math.hypot(...slip);
      const ahead = dot(slip, state.heading) > this.tolerances.SAME_WAY * speed;
      return speed > rounding && ahead ? point(slip) : state;
    });
  }

  // The solution next to a mode in which slip that begins goes along its growth; null if there is
  // none.
  solveBegun(terms, mode, drive) {
    const begun = [...mode.keys()].filter((k) => mode[k].begins);
    if (!begun.length) return this.solve(terms, mode, drive);
    const { SMALL_TURN, SAME_WAY, SAME_DIRECTION, DIRECTION_STEPS } = this.tolerances;
    let angles = begun.map((k) => Math.atan2(mode[k].heading[1], mode[k].heading[0]));
    for (let step = 0; step < DIRECTION_STEPS; step++) {
      const [solved, missed] = this.head(terms, mode, drive, begun, angles);
      const columns = angles.map((_, j) => {
        const turned = angles.map((angle, i) => (i === j ? angle + SMALL_TURN : angle));
        return this.head(terms, mode, drive, begun, turned)[1];
      });
      const slopes = missed.map((rate, i) =>
        columns.map((column) => (column[i] - rate) / SMALL_TURN),
      );
      const turned = slopes.flat().every(Number.isFinite) ? eliminate(slopes, missed, 0) : null;
      if (!turned) return null;
      const largest = most(turned);
      if (largest <= SAME_DIRECTION) return solved;
      const part = Math.min(1, Math.acos(SAME_WAY) / largest);
      angles = angles.map((angle, i) => angle - part * turned[i]);
    }
    return null;
  }

  // The solution with the slip of elements along angles, and what of its growth goes across.
  head(terms, mode, drive, begin, angles) {
    const headings = angles.map((angle) => [Math.cos(angle), Math.sin(angle)]);
    const pointed = [...mode];
    begin.forEach((k, i) => (pointed[k] = stand(SLIPS, headings[i], true)));
    const solved = this.solve(terms, pointed, drive);
    if (!solved) return [null, angles.map(() => NaN)];
    const slip = (row) => dot(terms.slopes[row], solved.a) - drive.wanted[row];
    const across = begin.map((k, i) => {
      const [x, y] = this.elements[k].tangents.map(slip);
      return headings[i][0] * y - headings[i][1] * x;
    });
    return [solved, across];
  }

  // What each element has left in its state, two numbers: its gap or what presses; the reserve of
  // static friction or the speed of slip; 1 where there is none. Gaps and slips are those of the
  // state, or what the rows gain by at a corner.
  findLeft({ sticking, holds }, { mode, forces }, gaps, rates) {
    return mode.map((state, k) => {
      const { normal, tangents, pressing } = this.elements[k];
      if (normal !== null && (state.name === OPEN || this.isElastic(k)))
        return [state.name === OPEN ? gaps[normal] : -gaps[normal], 1];
      const press = normal === null ? 1 : forces[normal] + holds[k];
      if (slips(state))
        return [
          press,
          dot(
            state.heading,
            tangents.map((row) => rates[row]),
          ),
        ];
      if (state.name !== STICKS || state.heading) return [press, 1];
      const limit = sticking[k] * (pressing === null ? 1 : forces[pressing]);
      return [press, limit - Math.hypot(...tangents.map((row) => forces[row]))];
    });
  }

  // The same between corners, more than rounding.
  findMargins(terms, solved, mode, v) {
    const { tolerances, length } = this;
    const left = this.findLeft(
      this.accelerate(terms),
      { ...solved, mode },
      terms.gaps,
      terms.rates,
    );
    const load = most(terms.load);
    const pull = tolerances.DEAD * load + tolerances.LEAST_MARGIN;
    return left.flatMap(([first, second], k) => {
      const { normal, ends, tangents } = this.elements[k];
      const { name, begins } = mode[k];
      // what is closed opens beyond an end; what is open closes without a gap and inside
      if (ends && name === OPEN) first = Math.max(first, -terms.inside[k]);
      else if (ends) first = Math.min(first, (terms.inside[k] * load) / length);
      // slip in space ends, or has begun, or has turned
      if (begins) {
        const slow = this.stillSpeed(terms, v);
        second = Math.min(slow + second, tolerances.BEGUN * slow - second);
      } else if (name === SLIPS)
        second -= tolerances.TURNED * Math.hypot(...tangents.map((row) => terms.rates[row]));
      if (normal !== null && name === OPEN) first += tolerances.EVEN * length;
      else if (!this.isElastic(k)) first += pull;
      return [first, name === STICKS ? second + pull : second];
    });
  }

  // The speeds below which the rate of a row is rounding: by velocities, and by loads as well.
  rounding({ slopes, rates }, v) {
    const sizes = slopes.map((row, r) => within(row, v) + Math.abs(rates[r] - dot(row, v)));
    return this.tolerances.STILL * Math.max(0, ...sizes);
  }

  stillSpeed(terms, v) {
    const pull = Math.max(0, ...terms.slopes.map((row) => within(row, terms.free)));
    const usual = this.tolerances.STILL * Math.sqrt(this.length * pull);
    return Math.max(usual, this.rounding(terms, v)) + NO_SPEED;
  }

  rowsHeld(mode) {
    return this.elements.flatMap(({ normal, tangents, struck }, k) => [
      ...(struck && isHeld(mode[k]) ? [normal] : []),
      ...(mode[k].name === STICKS && !mode[k].heading ? tangents : []),
    ]);
  }

  // Whether what a mode holds keeps a row from changing.
  keeps({ slopes, steps }, mode, row) {
    const { REDUNDANT } = this.tolerances;
    const basis = [];
    const takeAway = (vector, step) => {
      for (const [axis, way] of basis) {
        const along = dot(way, vector);
        vector = vector.map((x, i) => x - along * axis[i]);
        step = step.map((x, i) => x - along * way[i]);
      }
      return [vector, step, dot(vector, step)];
    };
    for (const held of this.rowsHeld(mode)) {
      const [vector, step, size] = takeAway(slopes[held], steps[held]);
      if (!(size > REDUNDANT * dot(slopes[held], steps[held]))) continue;
      const scale = 1 / Math.sqrt(size);
      basis.push([vector.map((x) => x * scale), step.map((x) => x * scale)]);
    }
    return takeAway(slopes[row], steps[row])[2] <= REDUNDANT * dot(slopes[row], steps[row]);
  }

  // Whether what slips along a line in a mode may do so, and what is kept from it may not; at an
  // instant a row that is not at rest is kept nowhere, as at a dead center.
  leavesSlip(terms, mode, isAtRest = () => true) {
    return mode.every(({ name, heading }, k) => {
      if (!heading || name === SLIPS) return true;
      const [row] = this.elements[k].tangents;
      return (isAtRest(row, k) && this.keeps(terms, mode, row)) === (name === STICKS);
    });
  }

  // What the rate of each row gains by, and of what size the terms of that are.
  findGains({ slopes }, drive, a, still = 0) {
    const moved = a.map((x, i) => Math.abs(x) + Math.abs(drive.free[i]));
    return [
      slopes.map((row, r) => dot(row, a) - drive.wanted[r]),
      slopes.map((row, r) => within(row, moved) + Math.abs(drive.wanted[r]) + still),
    ];
  }

  // Whether what a mode or an impact presupposes is so: of elements that are near and open the gap
  // must not shrink, of those whose slip begins it must grow.
  isSound(terms, drive, solved, { near, beginning, still }, slack = this.tolerances.SLACK) {
    const { slopes } = terms;
    const { mode, a, forces } = solved;
    const [gained, sizes] = this.findGains(terms, drive, a, still);
    const longest = Math.max(0, ...slopes.map(most));
    const pull = slack * (most(forces) + (longest && most(drive.load) / longest));
    const left = this.findLeft(drive, solved, gained, gained);
    const isAtRest = (row, k) =>
      beginning.has(k) && Math.abs(gained[row]) <= Math.abs(slack) * sizes[row];
    if (!drive.impact && !this.leavesSlip(terms, mode, isAtRest)) return false;
    return mode.every((state, k) => {
      const [apart, rubs] = left[k];
      const { normal, tangents } = this.elements[k];
      if (this.isElastic(k)) return true;
      if (normal !== null && state.name === OPEN)
        return !near.has(k) || apart >= -slack * sizes[normal];
      const size = Math.max(...tangents.map((row) => sizes[row]));
      if (slips(state) && beginning.has(k) && rubs < -slack * size) return false;
      return (normal === null || apart >= -pull) && (state.name !== STICKS || rubs >= -pull);
    });
  }

  // The least of what presses and of the reserves of static friction.
  findLeast(terms, drive, solved) {
    const left = this.findLeft(drive, solved, terms.gaps, terms.rates);
    return solved.mode.reduce((least, state, k) => {
      if (!isHeld(state) || this.isElastic(k)) return least;
      return Math.min(least, left[k][0], state.name === STICKS ? left[k][1] : Infinity);
    }, Infinity);
  }

  // The solutions of all modes whose conditions are met; of one that begins to slip in space, for
  // each direction in which it may.
  solveAll(terms, choices, drive, instant) {
    const isOne = (mode) => mode.filter(isSought).length < 2;
    const solveEach = (modes) =>
      modes
        .flatMap((mode) => [...this.solveInSpace(terms, mode, drive)])
        .filter((solved) => this.isSound(terms, drive, solved, instant));
    const modes = [...choose(choices)];
    const sound = solveEach(modes.filter(isOne));
    const together = modes.filter((mode) => !isOne(mode));
    if (!together.length || sound.length) return sound;
    const several = solveEach(together);
    if (several.length) return several;
    throw new Undecided(
      "where no mode follows whose forces rigid bodies determine, and no directions were found in " +
        "which contacts begin to slip in space at once",
    );
  }

  *solveInSpace(terms, mode, drive) {
    const begin = [...mode.keys()].filter((k) => isSought(mode[k]));
    if (!begin.length) {
      const solved = this.solve(terms, mode, drive);
      if (solved) yield solved;
      return;
    }
    const { ANGLES } = this.tolerances;
    const around = Array.from({ length: ANGLES + 1 }, (_, k) => (2 * Math.PI * k) / ANGLES + 0.01);
    if (begin.length === 1) {
      yield* this.beginSlip(terms, mode, drive, begin[0], around);
      return;
    }
    const start = this.findStart(terms, mode, drive, begin);
    const solved = start && this.solveBegun(terms, start, drive);
    if (solved) yield solved;
  }

  // A mode with directions near those in which several contacts begin to slip: friction takes away
  // as much of the growth of slip as what presses allows, a fixed point of projections on disks.
  findStart(terms, mode, drive, begin) {
    const free = mode.map((state) => (isSought(state) ? stand(SLIPS, [0, 0]) : state));
    const rows = begin.flatMap((k) => this.elements[k].tangents);
    const limit = (k, forces) => {
      const { pressing } = this.elements[k];
      return terms.kinetic[k] * (pressing === null ? 1 : forces[pressing]);
    };
    const respond = (pushed) => {
      const solved = this.solve(terms, free, pushed);
      if (!solved) return null;
      const [gained] = this.findGains(terms, pushed, solved.a);
      return [...rows.map((row) => gained[row]), ...begin.map((k) => limit(k, solved.forces))];
    };
    const push = (row) => ({
      ...drive,
      load: drive.load.map((x, i) => x + terms.slopes[row][i]),
      free: drive.free.map((x, i) => x + terms.steps[row][i]),
    });
    const [base, ...pushed] = [drive, ...rows.map(push)].map(respond);
    if (!base || pushed.includes(null)) return null;
    const slopes = pushed.map((answer) => answer.map((x, i) => x - base[i]));
    // no longer than the inverse of the largest eigenvalue, up to which projections contract
    const step = 1 / Math.hypot(...slopes.flatMap((column) => column.slice(0, rows.length)));
    const rub = rows.map(() => 0);
    for (let round = 0; round < this.tolerances.PROJECTIONS; round++) {
      const now = base.map((x, i) =>
        slopes.reduce((sum, column, j) => sum + column[i] * rub[j], x),
      );
      rub.forEach((_, i) => (rub[i] -= step * now[i]));
      begin.forEach((_, i) => {
        const size = Math.hypot(rub[2 * i], rub[2 * i + 1]);
        const bound = Math.max(0, now[rows.length + i]);
        const part = size > bound ? bound / size : 1;
        rub[2 * i] *= part;
        rub[2 * i + 1] *= part;
      });
    }
    const headings = begin.map((_, i) => [-rub[2 * i], -rub[2 * i + 1]]);
    return mode.map((state, k) =>
      isSought(state) ? stand(SLIPS, headings[begin.indexOf(k)], true) : state,
    );
  }

  // The solutions in which an element slips in the direction in which slip grows, between two of the
  // angles.
  *beginSlip(terms, mode, drive, k, angles) {
    const head = (angle) => this.head(terms, mode, drive, [k], [angle]);
    const values = angles.map((angle) => head(angle)[1][0]);
    for (let i = 0; i < angles.length - 1; i++) {
      if (!(values[i] * values[i + 1] <= 0 && values[i] !== values[i + 1])) continue;
      let [low, high] = [angles[i], angles[i + 1]];
      for (let middle = (low + high) / 2; low < middle && middle < high; middle = (low + high) / 2)
        if (head(middle)[1][0] * values[i] > 0) low = middle;
        else high = middle;
      const [solved] = head(high);
      if (solved) yield solved;
    }
  }

  distinguish(solutions, free, still) {
    const isSame = (a, b) =>
      most(a.map((x, i) => x - b[i])) <=
      this.tolerances.SAME_ANSWER * (Math.max(most(a), most(b)) + most(free)) + still;
    const namesOf = ({ mode }) => `${mode.map(({ name }) => name)}`;
    const kept = [];
    for (const each of solutions) {
      const same = kept.findIndex(({ a }) => isSame(each.a, a));
      // of shares of the same forces the one that leaves most
      if (same < 0) kept.push(each);
      else if (each.least > kept[same].least && namesOf(each) === namesOf(kept[same]))
        kept[same] = each;
    }
    return kept;
  }

  // which mode follows ----------------------------------------------------------------------------

  candidates(k, { gaps, rates }, touches, still) {
    const { normal, tangents } = this.elements[k];
    if (this.isElastic(k)) {
      const inside = touches && Math.min(gaps[normal], rates[normal]) < 0;
      return [stand(inside ? CLOSES : OPEN)];
    }
    const apart = normal === null ? [] : [stand(OPEN)];
    if (apart.length && (!touches || rates[normal] > still)) return apart;
    const slip = tangents.map((row) => rates[row]);
    if (Math.hypot(...slip) > still)
      return [...apart, slip.length > 1 ? point(slip) : IN_LINE[slip[0] > 0 ? 0 : 1]];
    return [...apart, ...this.listClosed(tangents)];
  }

  // The states of what is closed and does not slip yet.
  listClosed(tangents) {
    if (!tangents.length) return [stand(CLOSES)];
    return [stand(STICKS), ...(tangents.length > 1 ? [stand(SLIPS)] : IN_LINE)];
  }

  // The modes that may follow in a state, unless an element's state is forbidden or a mode has ended;
  // what has spent its static friction sticks on only where others take some of it.
  follow(terms, { touching, still, isForbidden, ended, spent }) {
    const { elements } = this;
    const which = (test) => new Set([...elements.keys()].filter((k) => test(elements[k], k)));
    const slipOf = ({ tangents }) => Math.hypot(...tangents.map((row) => terms.rates[row]));
    const instant = {
      near: which(({ struck, normal }, k) => touching[k] && struck && terms.rates[normal] <= still),
      beginning: which((element) => slipOf(element) <= still),
      still: 0,
    };
    const choices = elements.map((_, k) =>
      this.candidates(k, terms, touching[k], still).filter((state) => !isForbidden(k, state)),
    );
    const drive = this.accelerate(terms);
    const sound = this.solveAll(terms, choices, drive, instant)
      .filter(({ mode }) => !ended.has(keyOf(mode)))
      .map((solved) => {
        const lasts = this.isSound(terms, drive, solved, instant, -this.tolerances.SLACK);
        const goesOn = lasts || spent.every((k) => solved.mode[k].name !== STICKS);
        return { ...solved, goesOn, least: this.findLeast(terms, drive, solved) };
      });
    const going = sound.some(({ goesOn }) => goesOn) ? sound.filter((each) => each.goesOn) : sound;
    const kept = going.filter((each) => !going.some((rival) => this.yields(each, rival, terms)));
    return this.distinguish(kept, terms.free, 0);
  }

  // Whether a mode ends where it need not: what can stick sticks, and latches keep closed.
  yields({ mode }, rival, { sticking, kinetic, holds }) {
    const differ = [...mode.keys()].filter((k) => mode[k].name !== rival.mode[k].name);
    const keeps = (k) =>
      (rival.mode[k].name === STICKS && slips(mode[k]) && sticking[k] > kinetic[k]) ||
      (rival.mode[k].name === CLOSES && holds[k] > 0);
    return differ.length > 0 && differ.every(keeps);
  }

  // Every mode that holds in one direction at least, of what slips in space none.
  *listModes() {
    const choices = this.elements.map(({ normal, tangents }) => [
      ...(normal === null ? [] : [stand(OPEN)]),
      ...this.listClosed(tangents).filter(({ name }) => name !== SLIPS),
    ]);
    yield* choose(choices);
  }

  // impacts ---------------------------------------------------------------------------------------

  // The changes of velocities by an impact of contacts together, by Newton's law; or those of the
  // expansion in Poisson's, in which impulses of normals are given.
  collide(terms, contacts, still, given) {
    const { rates, restitution } = terms;
    const targets = this.elements.flatMap(({ normal, by_impulse: byImpulse }, k) =>
      contacts.has(k) && !byImpulse ? [[normal, -restitution[k] * Math.min(rates[normal], 0)]] : [],
    );
    const choices = this.elements.map(({ tangents }, k) => {
      if (!contacts.has(k)) return [stand(OPEN)];
      const closed = this.listClosed(tangents).filter((state) => !isKept(state));
      return given ? closed : [stand(OPEN), ...closed];
    });
    const drive = this.strike(terms, new Map(targets), given);
    const instant = { near: contacts, beginning: contacts, still };
    return this.distinguish(this.solveAll(terms, choices, drive, instant), this.none, still);
  }

  // The energy that each element takes by impulses, as velocities change.
  findTaken({ slopes }, v, change, impulses) {
    const between = change.map((step, i) => v[i] + step / 2);
    return this.elements.map(({ normal, tangents }) =>
      [...(normal === null ? [] : [normal]), ...tangents].reduce(
        (sum, row) => sum - impulses[row] * dot(slopes[row], between),
        0,
      ),
    );
  }
}
