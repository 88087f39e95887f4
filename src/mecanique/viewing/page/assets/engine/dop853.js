// Integrates y' = f(t, y) to a tolerance by the method of order 8(5, 3) of Dormand & Prince, and
// keeps each step's dense output, so that the state is known at any time.

import { CONTROL, DENSE, ERRORS, NODES, STAGES } from "./tableau.js";

const STEP = 12; // the stage whose state is the end of the step
const { DAMPING, EXPONENT, SAFETY, SHRINKAGE, GROWTH, SHORTEST } = CONTROL;
const { BEFORE, NEARLY, FIRST, UNKNOWN, BRIEF, SHALLOW, GRAZES } = CONTROL;
export const LOOKS = CONTROL.LOOKS; // within a step
// Of the longest of the last steps: what has stalled, what is a good step still, and how far one of
// these is followed beyond its end at most.
const LATELY = 60;
const STALLED = 1e-5;
const GOOD = 0.1;
const LONGEST_HOP = 2;
const GOLDEN = (3 - Math.sqrt(5)) / 2;

// Weights with the stages they belong to, as arrays of numbers: a step sums many of them.
const pack = (pairs) => ({
  of: Int32Array.from(pairs, ([stage]) => stage),
  by: Float64Array.from(pairs, ([, weight]) => weight),
});
const [SUMS, ERROR_SUMS, DENSE_SUMS] = [STAGES, ERRORS, DENSE].map((rows) => rows.map(pack));

function weigh({ of: places, by }, stages, i) {
  let sum = 0;
  for (let k = 0; k < places.length; k++) sum += by[k] * stages[places[k]][i];
  return sum;
}

// The states of a motion at any time between its first and its last.
export class Path {
  constructor(size, t) {
    Object.assign(this, { size, times: [t], pieces: [], spans: [] });
    Object.assign(this, { evaluations: 0, refused: 0, worst: 0, stopped: "" });
  }

  get first() {
    return this.times[0];
  }

  get last() {
    return this.times[this.times.length - 1];
  }

  get steps() {
    return this.pieces.length;
  }

  // A piece up to a time; its polynomial runs from 0 to 1 over its span.
  add(t, piece, span = [this.last, t]) {
    this.times.push(t);
    this.pieces.push(piece);
    this.spans.push(span);
  }

  // Ends within the last piece.
  end(t) {
    this.times[this.steps] = t;
  }

  // Forgets all pieces from a number on.
  cut(k) {
    this.times.length = k + 1;
    this.pieces.length = this.spans.length = k;
  }

  length(k) {
    return this.times[k + 1] - this.times[k];
  }

  // The number of the step in which a time lies.
  find(t) {
    let [low, high] = [0, this.steps];
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (this.times[middle] <= t) low = middle;
      else high = middle;
    }
    return low;
  }

  at(t, out) {
    return this.follow(this.find(t), t, out);
  }

  // The state by one piece, which may be followed beyond its ends.
  follow(k, t, out) {
    const [piece, [from, to]] = [this.pieces[k], this.spans[k]];
    const n = this.size;
    const x = (t - from) / (to - from);
    for (let i = 0; i < n; i++) {
      let sum = 0;
      for (let j = 7; j > 0; j--) sum = (sum + piece[j * n + i]) * (j % 2 ? x : 1 - x);
      out[i] = sum + piece[i];
    }
    return out;
  }
}

export class Integrator {
  // rates(t, y, out) are those of the state; settle(t, y) puts a state right after a step and says
  // whether it moved it; only the first `counted` numbers of the state are held to the tolerance;
  // bounds end the motion or send it back; loops may lose rank, which it then hops over.
  constructor(rates, { rtol, atol = rtol, counted, settle = null, bounds = null, ...limits }) {
    const { hops = false, most = 200_000 } = limits;
    Object.assign(this, { rates, rtol, atol, counted, settle, bounds, hops, most });
  }

  // The path from a state to a time; a halt says why it ends before.
  run(t, start, end) {
    const n = start.length;
    const path = new Path(n, t);
    Object.assign(this, { n, t, path, y: Float64Array.from(start), before: BEFORE, grows: true });
    this.crossing = null;
    this.trial = new Float64Array(n);
    this.stages = Array.from({ length: NODES.length }, () => new Float64Array(n));
    this.evaluate(0, t, this.y);
    this.h = this.guess(end - t);
    while (this.t < end && !path.stopped) this.step(end);
    return path;
  }

  evaluate(stage, t, y) {
    this.rates(t, y, this.stages[stage]);
    this.path.evaluations += 1;
  }

  // y + h Σ weight k, in place.
  combine(sum, h, out) {
    const { n, y, stages } = this;
    for (let i = 0; i < n; i++) {
      out[i] = y[i] + h * weigh(sum, stages, i);
    }
  }

  step(end) {
    const { path, trial, stages, t } = this;
    const left = end - t;
    const last = this.h * NEARLY >= left;
    const h = last ? left : Math.min(this.h, left / (left < 2 * this.h ? 2 : 1));
    for (let stage = 1; stage <= STEP; stage++) {
      this.combine(SUMS[stage], h, trial);
      this.evaluate(stage, t + NODES[stage] * h, trial);
    }
    const error = this.measure(h);
    if (!(error <= 1)) return this.refuse(h, error);
    path.worst = Math.max(path.worst, error);
    const piece = this.interpolate(h);
    this.t = last ? end : t + h;
    this.y.set(trial);
    path.add(this.t, piece);
    if (this.meet(end)) return undefined;
    if (this.settle?.(this.t, this.y)) this.evaluate(0, this.t, this.y);
    else stages[0].set(stages[STEP]);
    this.h = Math.max(this.lengthen(h, error), last ? this.h : 0);
    if (path.steps >= this.most) path.stopped = `after ${path.steps} steps`;
    return undefined;
  }

  // The length of the step after one of length h.
  lengthen(h, error) {
    const growth = error ? (SAFETY * this.before ** DAMPING) / error ** EXPONENT : GROWTH;
    const next = h * Math.max(SHRINKAGE, Math.min(this.grows ? GROWTH : 1, growth));
    Object.assign(this, { before: Math.max(error, BEFORE), grows: true });
    return next;
  }

  // Whether the last step came to a bound: there the motion ends, or starts anew.
  meet(end) {
    const { path, bounds } = this;
    const met = bounds?.find(path);
    if (!met) return false;
    path.end(met.t);
    this.t = met.t;
    path.follow(path.steps - 1, met.t, this.y);
    this.settle?.(this.t, this.y);
    path.stopped = bounds.strike(met, this.y);
    this.evaluate(0, this.t, this.y);
    Object.assign(this, { before: BEFORE, grows: true, h: this.guess(end - this.t) });
    return true;
  }

  refuse(h, error) {
    this.path.refused += 1;
    this.h =
      h * (Number.isFinite(error) ? Math.max(SHRINKAGE, SAFETY / error ** EXPONENT) : SHRINKAGE);
    this.grows = false;
    if (this.hops && this.hop()) return;
    if (this.h < SHORTEST * Math.max(1, Math.abs(this.t)))
      this.path.stopped = "where no step is short enough";
  }

  // Where loops lose rank the rates are all rounding though the motion is smooth, so that steps
  // shrink without end. The last good piece is followed across, to as far behind that place as it
  // is before it, or farther if the motion stalls there again; says whether that was done.
  hop() {
    const { path, t } = this;
    const longest = Math.max(...path.spans.slice(-LATELY).map(([a, b]) => b - a));
    if (!(this.h < STALLED * longest)) return false;
    const { crossing: before } = this;
    const again = before && t - before.aim < before.reach;
    const good = (_, k) => path.length(k) > GOOD * longest;
    const last = again ? before.last : path.spans.findLastIndex(good);
    const edge = path.times[last + 1];
    const reach = again ? 2 * before.reach : 2 * (t - edge) + GOOD * path.length(last);
    if (reach > LONGEST_HOP * longest) return false;
    const aim = edge + reach;
    this.crossing = { last, reach, aim };
    path.follow(last, aim, this.y);
    const [piece, span] = [path.pieces[last], path.spans[last]];
    path.cut(last + 1);
    path.add(aim, piece, span);
    this.t = aim;
    this.settle(aim, this.y);
    this.evaluate(0, aim, this.y);
    this.h = path.length(last);
    return true;
  }

  // The error of a step in tolerances.
  measure(h) {
    const { counted, stages, y, trial } = this;
    const squares = [0, 0];
    for (let i = 0; i < counted; i++) {
      const scale = this.atol + this.rtol * Math.max(Math.abs(y[i]), Math.abs(trial[i]));
      for (let k = 0; k < 2; k++) squares[k] += (weigh(ERROR_SUMS[k], stages, i) / scale) ** 2;
    }
    const [fifth, third] = squares;
    if (fifth === 0 && third === 0) return 0;
    return (h * fifth) / Math.sqrt((fifth + 0.01 * third) * counted);
  }

  // The state at the start of a step and seven coefficients, one after the other.
  interpolate(h) {
    const { n, y, trial, stages, t } = this;
    const between = new Float64Array(n);
    for (let stage = STEP + 1; stage < NODES.length; stage++) {
      this.combine(SUMS[stage], h, between);
      this.evaluate(stage, t + NODES[stage] * h, between);
    }
    const piece = new Float64Array(8 * n);
    for (let i = 0; i < n; i++) {
      const change = trial[i] - y[i];
      piece[i] = y[i];
      piece[n + i] = change;
      piece[2 * n + i] = h * stages[0][i] - change;
      piece[3 * n + i] = 2 * change - h * (stages[0][i] + stages[STEP][i]);
      for (let k = 0; k < DENSE_SUMS.length; k++)
        piece[(4 + k) * n + i] = h * weigh(DENSE_SUMS[k], stages, i);
    }
    return piece;
  }

  // A first step from the sizes of the state and its rate (Hairer et al., II.4).
  guess(length) {
    let [size, rate] = [0, 0];
    for (let i = 0; i < this.counted; i++) {
      const scale = this.atol + this.rtol * Math.abs(this.y[i]);
      size += (this.y[i] / scale) ** 2;
      rate += (this.stages[0][i] / scale) ** 2;
    }
    const h = size > UNKNOWN && rate > UNKNOWN ? FIRST * Math.sqrt(size / rate) : BRIEF;
    return Math.min(Math.max(h, BRIEF), length);
  }
}

// The times at which a function of time and state passes through zero from below, or from above if
// the direction is −1, or both ways if it is 0.
export function findEvents(path, g, direction = 1) {
  const y = new Float64Array(path.size);
  const value = (t) => g(t, path.at(t, y));
  const found = [];
  const note = (from, to, sign) => {
    if (sign * direction >= 0) found.push(bisect(value, from, to));
  };
  let [before, low] = [path.first, value(path.first)];
  let last = -Infinity;
  for (let k = 0; k < path.steps; k++) {
    const [from, to] = [path.times[k], path.times[k + 1]];
    const looks = [[before, low]];
    for (let part = 1; part <= LOOKS; part++) {
      const t = part === LOOKS ? to : from + ((to - from) * part) / LOOKS;
      const high = value(t);
      looks.push([t, high]);
      if (low < 0 && high >= 0) note(before, t, 1);
      if (low > 0 && high <= 0) note(before, t, -1);
      const sign = Math.sign(low);
      const three = looks.slice(-3).map(([when, height]) => [when, sign * height]);
      const turn = part > 1 ? findDip((when) => sign * value(when), ...three) : null;
      // what turns between the middle two of four looks is seen twice
      if (turn !== null && turn - last > (to - from) / 1000) {
        note(three[0][0], turn, -sign);
        note(turn, t, sign);
        last = turn;
      }
      [before, low] = [t, high];
    }
  }
  return found;
}

// When a quantity that is positive at three times is least between them, if it is below zero there by
// more than rounding.
export function findDip(value, [t0, g0], [t1, g1], [t2, g2]) {
  const least = Math.min(g0, g1, g2);
  if (!(least > 0)) return null;
  // the turn of a parabola through the three
  const [first, second] = [(g1 - g0) / (t1 - t0), (g2 - g1) / (t2 - t1)];
  const bend = (second - first) / (t2 - t0);
  if (!(bend > 0)) return null;
  const turn = (t0 + t1) / 2 - first / (2 * bend);
  const lowest = g0 + (first + bend * (turn - t1)) * (turn - t0);
  if (!(t0 < turn && turn < t2) || lowest > SHALLOW * least) return null;
  let [low, high] = [t0, t2];
  for (let k = 0; k < 40; k++) {
    const [early, late] = [low + GOLDEN * (high - low), high - GOLDEN * (high - low)];
    if (value(early) < value(late)) high = late;
    else low = early;
  }
  const t = (low + high) / 2;
  return value(t) < -GRAZES * Math.max(g0, g1, g2) ? t : null;
}

export function bisect(value, a, b) {
  const sign = Math.sign(value(a));
  for (let k = 0; k < 60 && b - a > 1e-14 * Math.max(1, Math.abs(b)); k++) {
    const middle = (a + b) / 2;
    if (Math.sign(value(middle)) === sign) a = middle;
    else b = middle;
  }
  return b;
}
