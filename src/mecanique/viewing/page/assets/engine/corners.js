// The corners of a motion: where elements switch, which mode follows there, and impacts.

import { Bounds } from "./bounds.js";
import { bisect, findDip, LOOKS } from "./dop853.js";
import { isHeld, isKept, keyOf, Law, OPEN, STICKS, Undecided, within } from "./law.js";
import { Loops } from "./loops.js";
import { dot } from "../data/vectors.js";

const MOST_AT_ONCE = 50; // switches that may follow each other at one instant
const MOST_IN_TURN = 10_000;

export class Corners {
  // Of a motion from a state, which is put after the impacts it begins with.
  constructor(machine, p, span, y) {
    const { nq, nv, program, engine } = machine;
    Object.assign(this, { machine, p, ...engine.switching });
    this.law = new Law(this, program, nq, nv);
    this.count = this.elements.length;
    this.rubbing = this.elements
      .filter(({ tangents }) => tangents.length)
      .map(({ name, tangents }) => [this.placeOf(`${name}: friction`), tangents]);
    // as p, but with the forces along rows in the place of those on bodies
    this.pushes = new Float64Array(p.length - this.forces + this.positional.length);
    this.pressed = new Float64Array(this.forces);
    this.struck = new Float64Array(nv + this.positional.length);
    this.state = y.slice();
    Object.assign(this, { times: [], sequence: [], impacts: [], atOnce: 0, held: new Map() });
    this.ended = new Set(); // modes that end at this instant, though each state of theirs may go on
    const words = this.begin(span[0], y);
    if (words) throw new Error(`There is no motion with these values, ${words}.`);
    this.bounds = machine.bounded ? new Bounds(machine, p, span, y) : null;
  }

  // The number of the state in which the loss of a name is summed up; -1 if there is none.
  placeOf(name) {
    const { nq, nv } = this.machine;
    const k = this.losses.indexOf(name);
    return k < 0 ? -1 : nq + nv + 1 + k;
  }

  // between corners -------------------------------------------------------------------------------

  // The mode at a time, after a switch at this time.
  modeAt(t) {
    let k = this.times.length - 1;
    while (k > 0 && this.times[k] > t) k -= 1;
    return this.sequence[k];
  }

  get present() {
    return this.sequence[this.sequence.length - 1];
  }

  // Solves a mode, with the direction of slip in space of the state; not a number without a solution.
  solve(mode, t, y, p = this.p, force = this.machine.force) {
    const { law } = this;
    const terms = this.read(t, y, p, force);
    const along = law.alongSlip(terms, mode, law.rounding(terms, this.speeds(y)));
    const solved = law.solveBegun(terms, along, law.accelerate(terms));
    const none = (numbers) => Array.from(numbers, () => NaN);
    return { mode, a: none(terms.free), forces: none(terms.gaps), ...solved, terms };
  }

  // Solves a mode, and hands its forces to the program as parameters.
  evaluate(mode, t, y, p = this.p, force = this.machine.force) {
    const { pushes, pressed } = this;
    const solved = this.solve(mode, t, y, p, force);
    const at = p.length - this.forces;
    pushes.set(p.subarray(0, at));
    pushes.set(solved.forces, at);
    this.machine.program.press(t, y, pushes, pressed, force);
    p.set(pressed, at);
    return solved;
  }

  press(t, y, p) {
    this.evaluate(this.modeAt(t), t, y, p);
  }

  rates(t, y, out, force) {
    const { terms, forces } = this.evaluate(this.present, t, y);
    this.machine.program.rates(t, y, this.p, out, force);
    for (const [place, tangents] of this.rubbing)
      if (place >= 0) out[place] = -tangents.reduce((w, r) => w + forces[r] * terms.rates[r], 0);
  }

  // What the elements have left in the present mode, two numbers each, more than their rounding.
  margins(t, y) {
    const solved = this.solve(this.present, t, y);
    return this.law.findMargins(solved.terms, solved, this.present, this.speeds(y));
  }

  // The loops that the rows make which are held, in position or in velocity alone.
  loopsOf(rows) {
    const key = rows.join();
    if (!rows.length) return null;
    if (!this.held.has(key)) {
      const { machine, positional } = this;
      const { nq, nv, program } = machine;
      const n = rows.length;
      const closure = (t, y, p, found) => {
        const { gaps, rates, slopes, steps } = this.read(t, y);
        rows.forEach((row, r) => {
          found[r] = positional[row] ? gaps[row] : 0;
          found[n + r] = rates[row];
          found.set(slopes[row], 2 * n + r * nv);
          found.set(steps[row], 2 * n + (n + r) * nv);
        });
      };
      const restrained = [...rows.keys()].filter((r) => !positional[rows[r]]);
      const held = { rates: program.rates, closure };
      this.held.set(key, new Loops(held, { loops: n, restrained, weighed: true, nq, nv }, this.p));
    }
    return this.held.get(key);
  }

  loopsIn(mode) {
    return this.loopsOf(this.law.rowsHeld(mode));
  }

  settle(t, y) {
    return this.loopsIn(this.present)?.settle(t, y) ?? false;
  }

  read(t, y, p = this.p, force = this.machine.force) {
    return this.law.measure(t, y, p, force);
  }

  speeds(y) {
    const { nq, nv } = this.machine;
    return y.slice(nq, nq + nv);
  }

  // where a margin passes zero --------------------------------------------------------------------

  // The first corner in the last piece of a path, or bound that ends it.
  find(path) {
    const corner = this.findCorner(path);
    const bound = this.bounds?.find(path);
    return bound && !(corner?.t <= bound.t) ? { t: bound.t, bound } : corner;
  }

  findCorner(path) {
    const [from, to] = path.times.slice(-2);
    const at = (t) => this.margins(t, path.follow(path.steps - 1, t, this.state));
    let low = from;
    const looks = [[from, this.before]];
    for (let look = 1; look <= LOOKS; look++) {
      const high = look === LOOKS ? to : from + ((to - from) * look) / LOOKS;
      const now = at(high);
      looks.push([high, now]);
      const passed = now.flatMap((margin, j) => {
        const value = (t) => at(t)[j];
        if (!(margin < 0)) {
          const [begin, ...others] = looks.slice(-3).map(([t, margins]) => [t, margins[j]]);
          const end = others.length === 2 ? findDip(value, begin, ...others) : null;
          return end === null ? [] : [{ j, t: bisect(value, begin[0], end) }];
        }
        const begun = this.before[j] > 0 ? low : this.leave(value, low, high);
        if (begun !== null) return [{ j, t: bisect(value, begun, high) }];
        return j & 1 ? [{ j, t: low }] : [];
      });
      if (passed.length) return passed.reduce((a, b) => (b.t < a.t ? b : a));
      [this.before, low] = [now, high];
    }
    return null;
  }

  // Just after a corner a margin may be zero to rounding: a time at which it has left zero, if it does
  // so at all; that of friction passes zero at once if it does not, as where two begin to slip together.
  leave(value, low, high) {
    let width = high - low;
    for (let k = 0; k < 50; k++) {
      width /= 2;
      if (value(low + width) > 0) return low + width;
    }
    return null;
  }

  // What a corner does to the state; in words, if the motion ends there.
  strike({ bound, j, t }, y) {
    if (bound) return this.bounds.strike(bound, y) || this.begin(t, y);
    const [k, which] = [j >> 1, j & 1];
    this.countAtOnce(t);
    const element = this.elements[k];
    if (this.atOnce > MOST_AT_ONCE) return `where ${element.name} switches without end`;
    const mode = this.present;
    const now = this.read(t, y);
    if (which === 1 && this.turn(t, y, now, k)) return "";
    const touching = this.elements.map((_, i) => this.isTouching(i, now, mode[i]));
    if (which === 0 && this.isBeside(k, now))
      return `where ${element.name} comes in from beyond an end of its side, below it`;
    if (which === 1) this.endSlip(t, y, k);
    else touching[k] = !isHeld(mode[k]) || (element.struck && this.isInside(k, now));
    const spent = this.listSpent(k, which, touching);
    const begun = this.listBegun(t, y).filter((i) => i !== k);
    const isForbidden = this.forbid(k, which, now, spent);
    return this.change(t, y, touching, { isForbidden, spent, begun });
  }

  // What began to slip just now and goes on: where several begin at once by symmetry, one and another
  // would stick in turn without end.
  listBegun(t, y) {
    const { law, present } = this;
    const { a, mode, terms } = this.solve(present, t, y);
    const [gained, sizes] = law.findGains(terms, law.accelerate(terms), a);
    const [still, { SLACK }] = [law.stillSpeed(terms, this.speeds(y)), this.tolerances];
    return [...mode.keys()].filter((k) => {
      const { tangents } = this.elements[k];
      const { heading, name } = mode[k];
      if (!heading || name === STICKS) return false;
      const [growth, size] = [gained, sizes].map((all) => tangents.map((row) => all[row]));
      const slip = tangents.map((row) => terms.rates[row]);
      return dot(heading, growth) >= -SLACK * Math.max(...size) && Math.hypot(...slip) <= still;
    });
  }

  // The slip, which is zero to rounding, is zero.
  endSlip(t, y, k) {
    const stops = this.present.map((state, i) =>
      i === k ? { name: STICKS, heading: null } : state,
    );
    if (this.present[k].name !== STICKS) this.project(t, y, stops);
  }

  countAtOnce(t) {
    this.atOnce = this.times[this.times.length - 1] === t ? this.atOnce + 1 : 0;
    if (!this.atOnce) this.ended.clear();
  }

  // Slip in space that has begun, or goes on in another direction, is followed from there; says
  // whether it does.
  turn(t, y, now, k) {
    const { law } = this;
    const begun = this.present.with(k, { ...this.present[k], begins: false });
    const along = law.alongSlip(now, begun, law.stillSpeed(now, this.speeds(y)));
    if (along[k] === begun[k]) return false;
    this.go(t, y, along);
    return true;
  }

  go(t, y, mode) {
    this.times.push(t);
    this.sequence.push(mode);
    this.before = this.margins(t, y);
  }

  // What sticks and has spent its static friction where a margin passes zero, of which others may take
  // some: what touches and is open, or what shares the forces of a mode.
  listSpent(k, which, touching) {
    const mode = this.present;
    const kept = [...mode.keys()].filter((i) => isKept(mode[i]));
    if (which === 1) {
      const takes = touching.some((near, i) => near && !isHeld(mode[i]));
      return mode[k].name === STICKS && (takes || kept.length) ? [k] : [];
    }
    return isHeld(mode[k]) && touching[k] ? kept : [];
  }

  // Whether a state of an element ends where its margin passes zero; if others take some of what is
  // spent, only the mode as a whole does.
  forbid(k, which, now, spent) {
    const mode = this.present;
    if (spent.length) {
      this.ended.add(keyOf(mode));
      return () => false;
    }
    if (which === 1)
      return (i, { name, heading }) =>
        i === k && mode[k].name === STICKS && name === STICKS && !heading;
    const ends = isHeld(mode[k]) && this.elements[k].struck && this.isInside(k, now);
    return (i, state) => ends && i === k && isHeld(state);
  }

  isTouching(k, now, state = { name: OPEN }) {
    const { struck, normal } = this.elements[k];
    if (!struck) return isHeld(state) && normal !== null;
    if (isHeld(state)) return true;
    const near = now.gaps[normal] <= this.tolerances.CLOSED_GAP * this.length;
    return near && this.isInside(k, now);
  }

  // Whether an element is between the ends of its side; always without ends.
  isInside(k, { inside }) {
    return inside[k] >= -this.tolerances.EVEN * this.length;
  }

  // Whether the bodies of an element are one within the other.
  isWithin(k, { gaps }) {
    const { struck, normal } = this.elements[k];
    return struck && gaps[normal] < -this.tolerances.CLOSED_GAP * this.length;
  }

  // Whether they are so as what touches passes an end, not as it meets the side.
  isBeside(k, now) {
    const { ends, normal } = this.elements[k];
    return ends && this.isWithin(k, now) && now.inside[k] < -now.gaps[normal];
  }

  findWithin(now) {
    return this.elements.filter((_, k) => this.isWithin(k, now) && this.isInside(k, now));
  }

  // Takes bodies that are one within the other apart until they touch; says whether that was possible.
  part(t, y) {
    const rows = this.findWithin(this.read(t, y)).map(({ normal }) => normal);
    return this.loopsOf(rows)?.close(t, y) ?? true;
  }

  begin(t, y) {
    const now = this.read(t, y);
    const [first] = this.findWithin(now);
    if (first) return `as ${first.name} begins with its bodies one within the other`;
    const touching = this.elements.map(({ normal }, k) =>
      this.law.isElastic(k) ? now.gaps[normal] < 0 : this.isTouching(k, now),
    );
    return this.change(t, y, touching);
  }

  project(t, y, mode) {
    const loops = this.loopsIn(mode);
    for (let round = 0; loops && round < 2; round++) loops.settle(t, y);
  }

  // Impacts, if contacts approach, then the mode that follows; in words, if there is none.
  change(t, y, touching, { isForbidden = () => false, spent = [], begun = [] } = {}) {
    const { law, ended } = this;
    let now = this.read(t, y);
    let still = law.stillSpeed(now, this.speeds(y));
    const approaching = [...this.elements.keys()].filter(
      (k) => touching[k] && this.elements[k].struck && now.rates[this.elements[k].normal] < -still,
    );
    const before = this.speeds(y);
    try {
      if (approaching.length) {
        this.impact(t, y, touching, approaching, still);
        ended.clear();
        this.impacts.push(...approaching.map((k) => [this.elements[k].name, t]));
        now = this.read(t, y);
        const after = this.speeds(y);
        const larger = before.map((x, i) => Math.max(Math.abs(x), Math.abs(after[i])));
        still = law.stillSpeed(now, larger);
      }
      const follow = () =>
        this.followBegun(now, { touching, still, isForbidden, ended, spent, begun });
      let next = follow();
      const over = approaching.length ? this.listEnded(next, { now, touching, still }) : [];
      if (over.length) {
        const after = y.slice();
        const loops = this.loopsOf([...law.rowsHeld(next.mode), ...over]);
        loops.evaluate(t, after);
        loops.closeRates(after);
        const bouncing = now;
        now = this.read(t, after);
        this.rest(y, bouncing, this.speeds(after), follow().mode, approaching);
        now = this.read(t, y);
        next = follow();
      }
      this.project(t, y, next.mode);
      this.go(t, y, this.keepBeginning(next.mode, now, still));
      return "";
    } catch (error) {
      if (error instanceof Undecided) return error.message;
      throw error;
    }
  }

  // A mode in which slip that begins still does, where another element switches meanwhile.
  keepBeginning(mode, { rates }, still) {
    return mode.map((state, k) => {
      const slip = this.elements[k].tangents.map((row) => rates[row]);
      const slow = Math.hypot(...slip) < 0.5 * this.tolerances.BEGUN * still;
      const slips = state.name === this.present?.[k].name;
      return slow && slips && this.present[k].begins ? { ...state, begins: true } : state;
    });
  }

  // The only mode that follows; what has begun to slip sticks only where nothing else does.
  followBegun(now, instant) {
    const { begun } = instant;
    if (begun.length) {
      const isForbidden = (k, state) =>
        instant.isForbidden(k, state) || (begun.includes(k) && state.name === STICKS);
      try {
        return this.onlyOf(this.law.follow(now, { ...instant, isForbidden }));
      } catch (error) {
        if (!(error instanceof Undecided)) throw error;
      }
    }
    return this.onlyOf(this.law.follow(now, instant));
  }

  // The only mode that may follow.
  onlyOf(following) {
    if (following.length === 1) return following[0];
    if (!following.length)
      throw new Undecided(
        "where no mode follows whose forces rigid bodies with Coulomb's friction determine",
      );
    const names = following.map(({ mode }) => mode.map(({ name }) => name).join(", ")).join("; ");
    throw new Undecided(`where ${following.length} modes may follow: ${names}`);
  }

  // impacts ---------------------------------------------------------------------------------------

  // Of all contacts that touch together, or one after the other.
  impact(t, y, touching, approaching, still) {
    const contacts = [...this.elements.keys()].filter(
      (k) => touching[k] && this.elements[k].struck,
    );
    const inTurn = contacts.some((k) => this.elements[k].in_turn);
    const taken = new Array(this.count).fill(0);
    for (let round = 0; round < MOST_IN_TURN; round++) {
      const { rates } = this.read(t, y);
      const rate = (k) => rates[this.elements[k].normal];
      const fastest = contacts.reduce((a, b) => (rate(b) < rate(a) ? b : a));
      if (rate(fastest) >= -still) break;
      this.strikeTogether(t, y, inTurn ? [fastest] : contacts, still, taken);
      if (!inTurn) break;
    }
    this.account(y, approaching, taken);
  }

  // Adds a change of velocities, and what elements take by it.
  push(y, now, change, impulses, taken) {
    const { nq } = this.machine;
    this.law
      .findTaken(now, this.speeds(y), change, impulses)
      .forEach((energy, k) => (taken[k] += energy));
    change.forEach((step, i) => (y[nq + i] += step));
  }

  // One contact by itself in a plane, by Routh's diagram.
  strikeAlone(t, y, k, taken) {
    const { nv, program } = this.machine;
    const now = this.read(t, y);
    program[`impact${k}`](t, y, this.p, this.struck);
    const change = [...this.struck.subarray(0, nv)];
    const { normal, by_impulse: byImpulse } = this.elements[k];
    const wanted = (this.tolerances.SAME_ANSWER - now.restitution[k]) * now.rates[normal];
    // friction jams what should part by Newton's law
    if (!byImpulse && now.rates[normal] + dot(now.slopes[normal], change) < wanted)
      throw new Undecided("where no velocities follow after the impact");
    this.push(y, now, change, this.struck.subarray(nv), taken);
  }

  // By Newton's law at once; by Poisson's a compression, whose impulses then return, e times each.
  strikeTogether(t, y, contacts, still, taken) {
    const [{ tangents, by_impulse: byImpulse }] = contacts.map((k) => this.elements[k]);
    if (contacts.length === 1 && tangents.length < 2)
      return this.strikeAlone(t, y, contacts[0], taken);
    if (contacts.some((k) => this.elements[k].by_impulse !== byImpulse))
      throw new Undecided("where contacts impact together by Newton's and by Poisson's law");
    let given;
    for (const phase of byImpulse ? ["compression", "expansion"] : ["impact"]) {
      const now = this.read(t, y);
      const solutions = this.law.collide(now, new Set(contacts), still, given);
      if (solutions.length !== 1)
        throw new Undecided(`where ${solutions.length || "no"} velocities follow after the impact`);
      const [{ a, forces }] = solutions;
      this.push(y, now, a, forces, taken);
      const rows = contacts.map((k) => this.elements[k].normal);
      given = new Map(rows.map((row, i) => [row, now.restitution[contacts[i]] * forces[row]]));
      const approaches = (row) => {
        const size = within(now.slopes[row], a) + Math.abs(now.rates[row]);
        const after = now.rates[row] + dot(now.slopes[row], a);
        return after < -this.tolerances.SLACK * size - still;
      };
      if (phase === "expansion" && rows.some(approaches))
        throw new Undecided("where bodies still approach each other after Poisson's expansion");
    }
    return undefined;
  }

  // The energy that an impact takes counts as work done, and as the loss of its elements.
  account(y, approaching, taken) {
    const { nq, nv } = this.machine;
    const whole = taken.reduce((a, b) => a + b, 0);
    const names = approaching.map((k) => this.elements[k].name);
    y[nq + nv] -= whole;
    const together = this.placeOf(`${names.join(", ")}: impact`);
    if (together >= 0) y[together] += whole;
    else taken.forEach((energy, k) => (y[this.impactOf(this.elements[k].name)] += energy));
  }

  // The number of the state for the impacts of an element, by itself or among others.
  impactOf(name) {
    const isOf = (loss) =>
      loss.endsWith(": impact") && loss.slice(0, -8).split(", ").includes(name);
    return this.placeOf(
      this.losses.find((loss) => loss === `${name}: impact`) ?? this.losses.find(isOf),
    );
  }

  // The rows of contacts whose bounces are over, those left staying below rounding.
  listEnded(next, { now, touching, still }) {
    const { slopes, rates, gamma, restitution } = now;
    return this.elements.flatMap(({ normal, struck }, k) => {
      if (!touching[k] || !struck) return [];
      const [speed, fall] = [rates[normal], -dot(slopes[normal], next.a) - gamma[normal]];
      if (!(restitution[k] < 1 && speed > still && fall > 0)) return [];
      return speed ** 2 / (2 * fall) <= this.tolerances.TAIL * this.length ? [normal] : [];
    });
  }

  // Takes away the rates of what the next mode holds as bounces end. All bounces left out press as
  // much as what rests meanwhile, less the impulse that ends them now: that takes its friction along.
  // Without friction velocities become `smooth`. The last bounce loses the energy of those left out.
  rest(y, now, smooth, mode, approaching) {
    const { law } = this;
    const kinetic = (v) =>
      dot(
        v,
        now.mass.map((row) => dot(row, v)),
      ) / 2;
    const v = this.speeds(y);
    const solved = law.solve(now, mode, law.strike(now, new Map()));
    const after = solved ? v.map((x, i) => x + solved.a[i]) : smooth;
    const share = (kinetic(v) - kinetic(after)) / approaching.length;
    this.account(
      y,
      approaching,
      this.elements.map((_, k) => share * approaching.includes(k)),
    );
    y.set(after, this.machine.nq);
  }

  // what happened ---------------------------------------------------------------------------------

  // The states of each element in time, as the strips below the clock show them.
  strips(last) {
    return this.elements.map(({ name }, k) => {
      const spans = [];
      this.times.forEach((begin, i) => {
        const end = this.times[i + 1] ?? last;
        const state = this.sequence[i][k].name;
        const before = spans[spans.length - 1];
        if (before?.[2] === state) before[1] = end;
        else if (end > begin || spans.length === 0) spans.push([begin, end, state]);
      });
      const impacts = this.impacts.filter(([element]) => element === name).map(([, t]) => t);
      return { name, spans, impacts };
    });
  }
}
