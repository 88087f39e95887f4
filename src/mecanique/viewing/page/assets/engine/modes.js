// Rest positions and what happens near them: the undamped modes of small motions, from the program
// alone. With loops, W = ∂a/∂τ = U D Uᵀ has the rank of what they leave free; with L = U √D the small
// motions q = L η follow η'' = −S η, where S = L⁺ (−∂a/∂q) L is symmetric. Where elements switch, each
// mode has positions of rest of its kind: those where it follows, with what it holds as loops.

import { dot } from "../data/vectors.js";
import { Corners } from "./corners.js";
import { keyOf, Law } from "./law.js";

const SMALL = 1e-5;
const RANK = 1e-9; // of the largest eigenvalue
const FREE = 1e-6; // stiffness of a motion that is free, of the largest
const SWEEPS = 60;
const DESCENTS = 300;
const FARTHEST_STEP = 0.2; // of a round, in the units of the coordinates
const STEPS = 40; // of Newton's, from a start that leads somewhere
const LEAST = 40; // starts that are tried at least
const ASTRAY = 10; // starts of which only one leads to a rest, before the search ends
const ASTRAY_IN_MODE = 3; // the same where each mode is searched
const SAME = 1e-5; // positions nearer than this are one
const REACHED = 1e-4; // distance at which a free motion has come to another position
const NEXT = 1e-4; // part of a coordinate's span, to where it may be changed if it may at all
const GLANCES = 8; // beyond, over its span
const HALVINGS = 30; // until an end of what friction holds is known
const BETWEEN = 0.3; // of the way from one position to another, where no symmetry makes a third
const INSTANT = 1 / 64; // part of the time of the fastest motion, after which its series is exact
const DOUBLINGS = 26; // of this time, to a million
const LEAST_SLOPE = 1e-8; // of the accelerations that contacts prevent
const STILL = 1e-4; // of that, for the accelerations themselves
const GROWING = 1e-4; // exponents of the largest: far above log t / t by then
const RESTING = 1e-9; // of the accelerations that a push of the size of the forces would cause

// Eigenvalues and eigenvectors (columns) of a symmetric matrix, by Jacobi's rotations.
export function eigen(matrix) {
  const n = matrix.length;
  const A = matrix.map((row) => [...row]);
  const V = A.map((_, i) => A.map((__, j) => Number(i === j)));
  for (let sweep = 0; sweep < SWEEPS; sweep++) {
    let off = 0;
    for (let p = 0; p < n; p++)
      for (let q = p + 1; q < n; q++) {
        const small = 1e-17 * (Math.abs(A[p][p]) + Math.abs(A[q][q]));
        if (!(Math.abs(A[p][q]) > small)) continue;
        off += 1;
        const theta = (A[q][q] - A[p][p]) / (2 * A[p][q]);
        const t = (theta < 0 ? -1 : 1) / (Math.abs(theta) + Math.hypot(theta, 1));
        const c = 1 / Math.hypot(t, 1);
        rotate(A, V, [p, q], [c, t * c]);
      }
    if (!off) break;
  }
  return { values: A.map((row, i) => row[i]), vectors: V };
}

function rotate(A, V, [p, q], [c, s]) {
  for (let k = 0; k < A.length; k++) {
    [A[k][p], A[k][q]] = [c * A[k][p] - s * A[k][q], s * A[k][p] + c * A[k][q]];
    [V[k][p], V[k][q]] = [c * V[k][p] - s * V[k][q], s * V[k][p] + c * V[k][q]];
  }
  for (let k = 0; k < A.length; k++)
    [A[p][k], A[q][k]] = [c * A[p][k] - s * A[q][k], s * A[p][k] + c * A[q][k]];
}

// The n-th of points spread evenly in a cube of some dimensions with edges from 0 to 1: multiples of
// the powers of 1/φ, φ^(d + 1) = φ + 1, of which no two depend on each other (Roberts, 2018).
function spread(n, dimensions) {
  let phi = 1;
  for (let round = 0; round < 40; round++) phi = (1 + phi) ** (1 / (dimensions + 1));
  return Array.from({ length: dimensions }, (_, k) => (n / phi ** (k + 1)) % 1);
}

const isAlike = (modes, others) => {
  if (modes.length !== others.length) return false;
  const most = Math.max(...modes.map(({ square }) => Math.abs(square)), 1e-300);
  return modes.every(({ square }, k) => Math.abs(square - others[k].square) < 1e-4 * most);
};

const multiply = (A, B) =>
  A.map((row) => B[0].map((_, j) => row.reduce((s, x, k) => s + x * B[k][j], 0)));

// Whether η' = w − C η, w' = −K η − R w grows exponentially, by the powers 2ⁿ of a state's change in
// a short time: what goes away steadily, as what is free to move does, grows like log t / t in this.
export function isUnstable(K, R, C) {
  const largest = (A) => Math.max(...A.flat().map(Math.abs), 1e-300);
  const rate = Math.max(Math.sqrt(largest(K)), largest(R), largest(C));
  const scaled = (row, factor) => row.map((x) => x * factor * INSTANT);
  const unit = (n) => Array.from({ length: n }, (_, i) => [...Array(n)].map((__, j) => +(i === j)));
  const A = [
    ...unit(K.length).map((row, i) => [...scaled(C[i], -1 / rate), ...scaled(row, 1)]),
    ...K.map((row, i) => [...scaled(row, -1 / rate ** 2), ...scaled(R[i], -1 / rate)]),
  ];
  let change = unit(A.length); // exp A by its series
  for (let n = 5; n > 0; n--)
    change = multiply(A, change).map((row, i) => row.map((x, j) => x / n + (i === j)));
  let logarithm = 0;
  let time = INSTANT;
  for (let n = 0; n < DOUBLINGS; n++) {
    const size = largest(change);
    change = change.map((row) => row.map((x) => x / size));
    change = multiply(change, change);
    logarithm = 2 * (logarithm + Math.log(size));
    time *= 2;
  }
  return (logarithm + Math.log(largest(change))) / time > GROWING;
}

const largestOf = (numbers) => Math.max(0, ...numbers.map(Math.abs));
const symmetric = (A) => A.map((row, i) => row.map((x, j) => (x + A[j][i]) / 2));
const column = (A, k) => A.map((row) => row[k]);

// Searches the positions of rest of every mode; of a mechanism where nothing switches there is one.
export function* searchModes(machine, setting, from, spans, turns) {
  const { switching } = machine.engine;
  const modes = switching
    ? [...new Law(switching, machine.program, machine.nq, machine.nv).listModes()]
    : [null];
  const rests = [];
  for (const [done, mode] of modes.entries()) {
    const before = [...rests];
    const small = new SmallMotions(machine, setting, mode);
    const search = small.isDetermined(from, spans) ? small.search(from, spans, turns) : [];
    yield { rests, part: done / modes.length };
    for (const known of search) {
      rests.splice(0, rests.length, ...before, ...known.rests);
      yield { rests, part: (done + known.part) / modes.length };
    }
  }
}

export class SmallMotions {
  // In one mode, if elements switch.
  constructor(machine, setting, mode = null) {
    Object.assign(this, { machine, setting, mode, t: setting.first });
    this.p = Float64Array.from(setting.p);
    this.corners = mode === null ? null : this.begin(machine.begin(setting));
    this.states = (mode ?? []).map(({ name }) => name);
    this.loops = this.corners ? this.corners.loopsIn(mode) : machine.loopsWith(this.p);
    // slopes below what rounding makes of loads that contacts bear
    this.least = LEAST_SLOPE * largestOf(this.corners?.read(this.t, this.corners.state).free ?? []);
    this.slopes = new Float64Array(machine.nq + machine.nv + 1);
    this.rank = 0; // of the loops, the largest so far
  }

  // The mode in which a motion from a state begins, with its impacts.
  begin(y) {
    return new Corners(this.machine, this.p.slice(), [this.t, this.t], y.slice());
  }

  // Whether rigid bodies determine the forces of the mode in one of some places.
  isDetermined(from, spans) {
    if (!this.corners) return true;
    const starts = this.starts(from, spans);
    return Array.from({ length: GLANCES }, () => starts.next().value).some((y) => {
      if (!y) return false;
      const { terms, a } = this.corners.solve(this.mode, this.t, y);
      return a.every(Number.isFinite) && this.corners.law.leavesSlip(terms, this.mode);
    });
  }

  accelerations(y, force = null) {
    const { program, nq, nv } = this.machine;
    if (this.corners) return this.corners.evaluate(this.mode, this.t, y, this.p, force).a;
    const axes = this.axesOfLoops(y);
    this.rank = Math.max(this.rank, axes.length);
    if (axes.length < this.rank) return this.accelerateWhereSingular(y, force, axes);
    program.rates(this.t, y, this.p, this.slopes, force);
    return [...this.slopes.subarray(nq, nq + nv)];
  }

  // Unit vectors across the velocities that loops leave free.
  axesOfLoops(y) {
    if (!this.loops) return [];
    this.loops.evaluate(this.t, y);
    return this.loops.basis(this.loops.count).map(({ axis }) => axis);
  }

  // Whether loops have the same rank next to a position of rest: else no small motions go on from it.
  isRegular({ y, at }) {
    const rank = this.axesOfLoops(y).length;
    if (at.L.length + rank !== this.machine.nv) return false; // all but singular, or no inertia
    return at.L.every((x) => this.axesOfLoops(this.moved(y, x, SMALL)).length === rank);
  }

  // Where loops lose rank the program divides by zero: there a = N (Nᵀ M N)⁻¹ Nᵀ f at rest, with the
  // velocities N that are free, by the tree's M and load f.
  accelerateWhereSingular(y, force, axes) {
    const { program, nv } = this.machine;
    const tree = new Float64Array(nv * (nv + 1));
    program.tree(this.t, y, this.p, tree, force);
    const rows = Array.from({ length: nv }, (_, k) => [...tree.subarray(k * nv, (k + 1) * nv)]);
    const load = tree.subarray(nv * nv);
    const across = rows.map((_, i) =>
      rows.map((__, k) => Number(i === k) - axes.reduce((sum, a) => sum + a[i] * a[k], 0)),
    );
    const projection = eigen(across); // onto N: of eigenvalues 1 and 0
    const N = projection.values.flatMap((x, k) => (x > 0.5 ? [column(projection.vectors, k)] : []));
    const inertia = (b) => rows.map((row) => dot(row, b));
    const { values, vectors } = eigen(N.map((a) => N.map((b) => dot(a, inertia(b)))));
    const out = new Array(nv).fill(0);
    values.forEach((value, k) => {
      const along = out.map((_, i) => N.reduce((sum, a, j) => sum + a[i] * vectors[j][k], 0));
      const share = dot(along, load) / value;
      along.forEach((x, i) => (out[i] += share * x));
    });
    return out;
  }

  // A state at rest, moved along velocities x for a unit of time, with loops closed again.
  moved(y, x, factor = 1) {
    const { nq, nv, program } = this.machine;
    const next = y.slice();
    const trial = y.slice();
    for (let k = 0; k < nv; k++) trial[nq + k] = factor * x[k];
    program.rates(this.t, trial, this.p, this.slopes, null);
    for (let k = 0; k < nq; k++) next[k] += this.slopes[k];
    next.fill(0, nq);
    this.machine.normalize(next);
    this.loops?.close(this.t, next);
    next.fill(0, nq);
    return next;
  }

  // Independent directions at a position: rows of L, and of its inverse.
  directions(y) {
    const { nv } = this.machine;
    const rest = this.accelerations(y);
    const W = Array.from({ length: nv }, (_, k) => {
      const push = new Float64Array(nv + 1);
      push[k] = 1;
      return this.accelerations(y, push).map((a, i) => a - rest[i]);
    });
    const { values, vectors } = eigen(symmetric(W));
    const most = Math.max(...values, this.yieldOfTree(y));
    const kept = values.map((_, k) => k).filter((k) => values[k] > RANK * most);
    const scaled = (power) =>
      kept.map((k) => column(vectors, k).map((x) => x * Math.sqrt(values[k]) ** power));
    return { L: scaled(1), inverse: scaled(-1), rest };
  }

  // What a push accelerates most where the mode held lets nothing move.
  yieldOfTree(y) {
    if (!this.corners) return 0;
    const { program, nq, nv } = this.machine;
    const rates = (push) => program.rates(this.t, y, this.p, this.slopes, push).slice(nq, nq + nv);
    const rest = rates(null);
    return Math.max(...rest.map((a, k) => rates(rest.map((_, i) => Number(i === k)))[k] - a));
  }

  // −∂a, or that of other rates, along the directions, where states follow from x and a small step
  // along it.
  slopesAlong({ L, inverse }, change, rates = (y) => this.accelerations(y)) {
    const columns = L.map((x) => {
      const [a, b] = [SMALL, -SMALL].map((h) => rates(change(x, h)));
      return a.map((each, i) => (b[i] - each) / (2 * SMALL));
    });
    const slopes = inverse.map((row) => columns.map((each) => dot(row, each)));
    return slopes.map((row) => row.map((x) => (Math.abs(x) > this.least ? x : 0)));
  }

  // −∂a/∂q along the directions, which is symmetric at rest alone.
  stiffness(y, at) {
    return this.slopesAlong(at, (x, h) => this.moved(y, x, h));
  }

  // −∂a/∂v along the directions.
  resistance(y, at) {
    return this.slopesAlong(at, (x, h) => {
      const next = y.slice();
      x.forEach((each, k) => (next[this.machine.nq + k] = h * each));
      return next;
    });
  }

  // Where the mechanism rests, found downhill from a position, or by Newton's steps, which also end
  // where it would fall; null if it finds no rest.
  settle(from, downhill = true) {
    const { nq } = this.machine;
    let y = from.slice();
    y.fill(0, nq);
    for (let round = 0; round < (downhill ? DESCENTS : STEPS); round++) {
      const at = this.directions(y);
      const push = at.inverse.map((row) => dot(row, at.rest));
      const size = Math.hypot(...push);
      if (!push.length || !Number.isFinite(size)) return this.holdsAll(at) ? { y, at } : null;
      const K = this.stiffness(y, at);
      const columns = push.map((_, i) => column(K, i));
      const squares = eigen(columns.map((a) => columns.map((b) => dot(a, b))));
      const most = Math.sqrt(Math.max(...squares.values, 1e-300));
      if (size <= RESTING * most + this.roundingOf(at)) return { y, at };
      const x = this.stepTo(push, { at, K, squares, most }, downhill);
      if (!(Math.hypot(...x) > 0)) return null; // what pushes meets no resistance
      y = this.moved(y, x);
    }
    return null;
  }

  // A step damped as far as it must be short: across what hardly resists first, of which the slopes
  // away from rest say little.
  stepTo(push, { at, K, squares, most }, downhill) {
    const columns = push.map((_, i) => column(K, i));
    const free = squares.values.map((square) => Math.sqrt(Math.abs(square)) < FREE * most);
    const { values, vectors } = downhill ? eigen(symmetric(K)) : squares;
    const pulled = downhill ? push : columns.map((c) => dot(c, push));
    let x;
    let damping = 0;
    do {
      const eta = push.map(() => 0);
      const go = (axis, step) => axis.forEach((each, i) => (eta[i] += step * each));
      values.forEach((value, k) => {
        const axis = column(vectors, k);
        if (downhill ? Math.abs(value) > FREE * most : !free[k])
          go(axis, dot(axis, pulled) / (Math.abs(value) + damping));
      });
      // where nothing pushes, any place will do
      squares.vectors.forEach((_, k) => {
        const axis = column(squares.vectors, k);
        if (free[k]) go(axis, -dot(axis, eta));
      });
      x = at.L[0].map((_, i) => dot(column(at.L, i), eta));
      damping = 4 * damping || FREE * Math.max(...values.map(Math.abs));
    } while (Math.hypot(...x) > FARTHEST_STEP);
    return x;
  }

  // The position of rest nearest downhill and its modes: ω² [1/s²], damping ratio, shape.
  find(from) {
    const found = this.settle(from);
    return found && this.describe(this.bring(found, from));
  }

  // Whether contacts and friction leave nothing free to move; without them there is no other rest.
  holdsAll({ L }) {
    return this.corners !== null && !L.length;
  }

  // What rounding leaves of the push at rest, where loads are borne by contacts.
  roundingOf({ inverse }) {
    return STILL * this.least * Math.max(0, ...inverse.flat().map(Math.abs));
  }

  // Of positions of rest among which a mechanism is free to move, the one nearest a state.
  bring(found, from) {
    let { y } = found;
    for (const { square, shape } of this.describe(found).modes) {
      if (square !== 0) continue;
      const along = this.moved(y, shape).map((x, k) => x - y[k]);
      const away = from.map((x, k) => (k < this.machine.nq ? x - y[k] : 0));
      y = this.moved(y, shape, dot(along, away) / dot(along, along));
    }
    return y === found.y ? found : (this.settle(y, false) ?? found);
  }

  // The position of rest that a start leads to, within the limits and with small motions; or null.
  restFrom(start, from, downhill) {
    const settled = this.settle(start, downhill);
    const found = settled && this.bring(settled, from);
    const allowed = found && !this.machine.beyond(this.p, [this.t, found.y]);
    return allowed && this.isRegular(found) && this.follows(found.y) ? found : null;
  }

  // Whether the mode is the one that follows at a position of rest.
  follows(y) {
    if (!this.corners) return true;
    try {
      return keyOf(this.begin(y).present) === keyOf(this.mode);
    } catch {
      return false; // bodies are one within the other, or no mode follows
    }
  }

  // Between what values one coordinate alone may be changed at a position of rest held by friction;
  // infinite if it may by all of its span.
  range({ y }, k, span) {
    const rests = (x) => {
      const next = y.slice();
      next[k] = x;
      const settled = this.settle(next, false);
      return settled !== null && Math.abs(settled.y[k] - x) < SAME && this.follows(settled.y);
    };
    return [-span, span].map((step) => {
      const ahead = [NEXT, ...Array.from({ length: GLANCES }, (_, n) => (n + 1) / GLANCES)];
      const past = ahead.findIndex((part) => !rests(y[k] + part * step));
      if (past === 0) return y[k];
      if (past < 0) return step * Infinity;
      let [inside, outside] = [past - 1, past].map((n) => y[k] + ahead[n] * step);
      for (let round = 0; round < HALVINGS; round++) {
        const middle = (inside + outside) / 2;
        if (rests(middle)) inside = middle;
        else outside = middle;
      }
      return inside;
    });
  }

  // Whether a mechanism that is free to move at one position of rest comes to another so.
  leads(found, other, gap) {
    if (this.corners || this.machine.engine.restrained?.length) {
      // what rolls or sticks comes to places along no straight way, but rests wherever it is put there
      const between = found.y.map((x, k) => x + BETWEEN * (other.y[k] - x));
      this.machine.normalize(between);
      if (this.corners && this.loops && !this.loops.close(this.t, between)) return false;
      const rest = this.settle(between, false);
      return rest !== null && gap(rest, { y: between }) < REACHED && this.follows(rest.y);
    }
    let far = Infinity;
    for (let now = found; gap(now, other) < far; now = this.bring(now, other.y)) {
      far = gap(now, other);
      if (far < REACHED) return true;
    }
    return false;
  }

  // Searches all positions of rest, from the start and from places spread around it: spans are how
  // far each coordinate is varied, turns whether it is an angle. After each start it yields those
  // found so far, that downhill from the start first, and the part of the search that is done.
  //
  // It ends where the expected number of positions, W (N − 1)/(N − W − 2) after N starts that led to
  // W different ones, is below W + 1/2 (Boender and Rinnooy Kan, Math. Program. 37 (1987) 59).
  *search(from, spans, turns) {
    const rests = [];
    // into −π … π, where −π counts as π
    const fold = (x, k) =>
      turns[k] ? x - 2 * Math.PI * Math.ceil((x - SAME) / (2 * Math.PI) - 0.5) : x;
    const gap = (a, b) => Math.max(...spans.map((_, k) => Math.abs(fold(a.y[k] - b.y[k], k))));
    const astray = this.corners ? ASTRAY_IN_MODE : ASTRAY;
    const starts = this.starts(from, spans);
    let led = 0;
    for (let n = 0; ; n++) {
      const W = rests.length;
      const needed = Math.max(LEAST, 2 * W * W + 3 * W + 2);
      yield { rests, part: Math.min(1, Math.max(led / needed, n / (astray * needed))) };
      if (led >= needed || n >= astray * needed) return;
      const start = starts.next().value;
      const found = start && this.restFrom(start, from, n === 0 && !this.corners);
      if (!found) continue;
      led += 1;
      turns.forEach((_, k) => (found.y[k] = fold(found.y[k], k)));
      if (rests.some((rest) => gap(rest, found) < SAME)) continue;
      const rest = this.describe(found);
      // of a family, among which the mechanism is free to move or held by friction, one is shown
      const isKin = (other) => this.isAlike(rest, other) && this.leads(found, other, gap);
      if (!rests.some(isKin)) rests.push(rest);
    }
  }

  // Places to search from, with loops closed, or null where they cannot be; also one where what
  // switches would have nothing to hold, as friction holds around there.
  *starts(from, spans) {
    for (let n = 0; ; n++) {
      const start = from.slice();
      if (n === 1 && this.corners)
        start.set(new SmallMotions(this.machine, this.setting).settle(from)?.y ?? from);
      if (n > 1) spread(n, spans.length).forEach((x, k) => (start[k] += spans[k] * (2 * x - 1)));
      this.machine.normalize(start);
      yield !this.loops || this.loops.close(this.t, start) ? start : null;
    }
  }

  // Whether positions of rest may be of one family by their modes.
  isAlike({ modes }, other) {
    return (
      this.corners !== null ||
      (modes.some(({ square }) => square === 0) && isAlike(other.modes, modes))
    );
  }

  describe({ y, at }) {
    const [K, R] = [this.stiffness(y, at), this.resistance(y, at)];
    const { values, vectors } = eigen(symmetric(K));
    const most = Math.max(...values.map(Math.abs), 1e-300);
    const order = values.map((_, k) => k).sort((a, b) => values[a] - values[b]);
    const modes = order.map((k) => {
      const axis = column(vectors, k);
      const shape = at.L[0].map((_, i) => dot(column(at.L, i), axis));
      const largest = shape.reduce((a, b) => (Math.abs(b) > Math.abs(a) ? b : a), 0) || 1;
      const square = Math.abs(values[k]) < 1e-7 * most ? 0 : values[k];
      const drag = dot(
        axis,
        R.map((row) => dot(row, axis)),
      );
      const damping = square > 0 ? drag / (2 * Math.sqrt(square)) : NaN;
      return { square, damping, shape: shape.map((x) => x / largest) };
    });
    return { y, modes, unstable: this.isUnstable(y, at, R), small: this };
  }

  isUnstable(y, at, R) {
    const { nq, nv } = this.machine;
    // what rolls on something driven moves beside its position of rest
    const beside = (x, h) => {
      const next = this.moved(y, x, h);
      this.loops?.closeRates(next);
      return next;
    };
    const C = this.slopesAlong(at, beside, (next) => [...next.subarray(nq, nq + nv)]);
    return isUnstable(this.slopesAlong(at, beside), R, C);
  }

  // A mode as a path of states: q = rest + amplitude · shape · sin ω t, for so many periods.
  path(y, { square, shape }, amplitude, periods) {
    const { nq, nv } = this.machine;
    const omega = Math.sqrt(square);
    const { t: first } = this;
    const last = first + (periods * 2 * Math.PI) / omega;
    const at = (t, out) => {
      const phase = omega * (t - first);
      out.set(this.moved(y, shape, amplitude * Math.sin(phase)));
      for (let k = 0; k < nv; k++) out[nq + k] = amplitude * omega * shape[k] * Math.cos(phase);
      this.loops?.closeRates(out);
      out[nq + nv] = 0;
      return out;
    };
    const facts = { evaluations: 0, refused: 0, worst: NaN, stopped: "" };
    const press = (t, state, p) => this.corners.evaluate(this.mode, t, state, p);
    const corners = this.corners && { press };
    return { first, last, steps: 1, size: nq + nv + 1, at, corners, ...facts };
  }
}
