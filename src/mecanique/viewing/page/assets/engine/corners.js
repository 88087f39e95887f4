// The corners of a motion: where elements switch, which mode follows there, and impacts.
//
// The program has a function for each mode and each impact: accelerations, the elements' forces, what
// each element has left, and what the mode presupposes. Here these numbers are compared with zero.

import { Bounds } from "./bounds.js";
import { bisect, findDip, LOOKS } from "./dop853.js";
import { Loops } from "./loops.js";

const [OPEN, STICKS, FORWARD, BACKWARD] = ["open", "sticks", "slips +", "slips -"];
const MOST_AT_ONCE = 50; // switches that may follow each other at one instant
const MOST_IN_TURN = 10_000;
const NO_SPEED = 1e-300;

const isHeld = (state) => state !== OPEN;
const alongRow = (a, b) => a.reduce((sum, x, i) => sum + x * b[i], 0);
const withinRow = (a, b) => a.reduce((sum, x, i) => sum + Math.abs(x * b[i]), 0);

export class Corners {
  // Of a motion from a state, which is put after the impacts it begins with.
  constructor(machine, p, span, y) {
    Object.assign(this, { machine, p, ...machine.engine.switching });
    const { nv } = machine;
    this.count = this.elements.length;
    this.known = new Float64Array(this.positional.length * (2 + 2 * nv) + nv + 1 + 4 * this.count);
    this.rubbing = this.elements.filter(({ tangent }) => tangent !== null);
    this.heats = this.rubbing.map(({ name }) => this.placeOf(`${name}: friction`));
    // where a mode's numbers stand: accelerations, forces, heat, margins, then what it presupposes
    this.heatAt = nv + this.forces;
    this.marginAt = this.heatAt + this.rubbing.length;
    this.numbers = new Float64Array(this.marginAt + 6 * this.count + 2);
    this.struck = new Float64Array(nv + 5 * this.count + 1);
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

  // The number of the mode at a time, after a switch at this time.
  modeAt(t) {
    let k = this.times.length - 1;
    while (k > 0 && this.times[k] > t) k -= 1;
    return this.sequence[k];
  }

  get present() {
    return this.sequence[this.sequence.length - 1];
  }

  // Evaluates a mode and hands its forces to the program as parameters.
  evaluate(mode, t, y, p = this.p, force = this.machine.force) {
    const { numbers, machine, forces, heatAt } = this;
    machine.program[`mode${mode}`](t, y, p, numbers, force);
    p.set(numbers.subarray(machine.nv, heatAt), p.length - forces);
    return numbers;
  }

  press(t, y, p) {
    this.evaluate(this.modeAt(t), t, y, p);
  }

  rates(t, y, out, force) {
    const numbers = this.evaluate(this.present, t, y);
    this.machine.program.rates(t, y, this.p, out, force);
    this.heats.forEach((place, k) => {
      if (place >= 0) out[place] = numbers[this.heatAt + k];
    });
  }

  // What the elements have left in the present mode, two numbers each, more than their rounding.
  margins(t, y) {
    const { tolerances, length, count, marginAt } = this;
    const numbers = this.evaluate(this.present, t, y);
    const pull = tolerances.DEAD * numbers[numbers.length - 1] + tolerances.LEAST_MARGIN;
    const margins = [...numbers.subarray(marginAt, marginAt + 2 * count)];
    this.modes[this.present].forEach((state, k) => {
      if (state === OPEN) margins[2 * k] += tolerances.EVEN * length;
      else if (!this.isElastic(k)) margins[2 * k] += pull;
      if (state === STICKS) margins[2 * k + 1] += pull;
    });
    return margins;
  }

  isElastic(k) {
    const { normal, struck } = this.elements[k];
    return normal !== null && !struck;
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

  rowsHeld(states) {
    return this.elements.flatMap(({ normal, tangent, struck }, k) => [
      ...(struck && isHeld(states[k]) ? [normal] : []),
      ...(states[k] === STICKS ? [tangent] : []),
    ]);
  }

  settle(t, y) {
    return this.loopsOf(this.rowsHeld(this.modes[this.present]))?.settle(t, y) ?? false;
  }

  // Gaps, rates, slopes and steps M⁻¹Jᵀ of all rows, the accelerations by the load, the kinetic energy,
  // and numbers of the elements.
  read(t, y) {
    const { known, positional, count, machine } = this;
    const { nv } = machine;
    const m = positional.length;
    machine.program.rows(t, y, this.p, known, machine.force);
    const free = (2 + 2 * nv) * m;
    const vectors = (first) =>
      positional.map((_, r) => known.slice(first + r * nv, first + (r + 1) * nv));
    return {
      gaps: known.subarray(0, m),
      rates: known.subarray(m, 2 * m),
      slopes: vectors(2 * m),
      steps: vectors((2 + nv) * m),
      free: known.slice(free, free + nv),
      kinetic: known[free + nv],
      of: Array.from({ length: count }, (_, k) => {
        const [restitution, holds, spare, inside] = known.slice(free + nv + 1 + 4 * k);
        return { restitution, holds, spare, inside };
      }),
    };
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
        return begun === null ? [] : [{ j, t: bisect(value, begun, high) }];
      });
      if (passed.length) return passed.reduce((a, b) => (b.t < a.t ? b : a));
      [this.before, low] = [now, high];
    }
    return null;
  }

  // Just after a corner a margin may be zero to rounding: a time at which it has left zero, if it
  // does so at all.
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
    const states = this.modes[this.present];
    const state = states[k];
    const now = this.read(t, y);
    const touching = this.elements.map((_, i) => this.isTouching(i, now, states[i]));
    if (which === 0 && this.isBeside(k, now))
      return `where ${element.name} comes in from beyond an end of its side, below it`;
    // the slip, which is zero to rounding, is zero
    if (which === 1 && state !== STICKS)
      this.project(t, y, this.rowsHeld(states.map((s, i) => (i === k ? STICKS : s))));
    if (which === 0) touching[k] = state === OPEN || (element.struck && this.isInside(k, now));
    const spent = this.listSpent(k, which, touching);
    return this.change(t, y, touching, this.forbid(k, which, now, spent), spent);
  }

  countAtOnce(t) {
    this.atOnce = this.times[this.times.length - 1] === t ? this.atOnce + 1 : 0;
    if (!this.atOnce) this.ended.clear();
  }

  // What sticks and has spent its static friction where a margin passes zero, of which others may take
  // some: what touches and is open, or what shares the forces of a mode.
  listSpent(k, which, touching) {
    const states = this.modes[this.present];
    const sticking = [...states.keys()].filter((i) => states[i] === STICKS);
    if (which === 1) {
      const takes = touching.some((near, i) => near && !isHeld(states[i]));
      return takes || this.kept[this.present].length ? sticking.filter((i) => i === k) : [];
    }
    return isHeld(states[k]) && touching[k] ? this.kept[this.present] : [];
  }

  // The states of an element that end where its margin passes zero; if others take some of what is
  // spent, only the mode as a whole does.
  forbid(k, which, now, spent) {
    const state = this.modes[this.present][k];
    if (spent.length) {
      this.ended.add(this.present);
      return new Set();
    }
    if (which === 1) return new Set(state === STICKS ? [`${k} ${STICKS}`] : []);
    if (state === OPEN || !this.elements[k].struck || !this.isInside(k, now)) return new Set();
    return new Set(this.modes.filter((mode) => isHeld(mode[k])).map((mode) => `${k} ${mode[k]}`));
  }

  isTouching(k, now, state = OPEN) {
    const { struck, normal } = this.elements[k];
    if (!struck) return isHeld(state) && normal !== null;
    if (isHeld(state)) return true;
    const near = now.gaps[normal] <= this.tolerances.CLOSED_GAP * this.length;
    return near && this.isInside(k, now);
  }

  // Whether an element is between the ends of its side; always without ends.
  isInside(k, { of }) {
    return of[k].inside >= -this.tolerances.EVEN * this.length;
  }

  // Whether the bodies of an element are one within the other.
  isWithin(k, { gaps }) {
    const { struck, normal } = this.elements[k];
    return struck && gaps[normal] < -this.tolerances.CLOSED_GAP * this.length;
  }

  // Whether they are so as what touches passes an end, not as it meets the side.
  isBeside(k, now) {
    const { ends, normal } = this.elements[k];
    return ends && this.isWithin(k, now) && now.of[k].inside < -now.gaps[normal];
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
    const [within] = this.findWithin(now);
    if (within) return `as ${within.name} begins with its bodies one within the other`;
    const touching = this.elements.map(({ normal }, k) =>
      this.isElastic(k) ? now.gaps[normal] < 0 : this.isTouching(k, now),
    );
    return this.change(t, y, touching, new Set());
  }

  project(t, y, rows) {
    const loops = this.loopsOf(rows);
    for (let round = 0; loops && round < 2; round++) loops.settle(t, y);
  }

  // Impacts, if contacts approach, then the mode that follows; in words, if there is none.
  change(t, y, touching, forbidden, spent = []) {
    const { nq, nv } = this.machine;
    let now = this.read(t, y);
    let still = this.stillSpeed(now, y);
    const approaching = [...this.elements.keys()].filter(
      (k) => touching[k] && this.elements[k].struck && now.rates[this.elements[k].normal] < -still,
    );
    if (approaching.length) {
      const before = y.slice();
      const words = this.impact(t, y, touching, approaching, still);
      if (words) return words;
      this.ended.clear();
      this.impacts.push(...approaching.map((k) => [this.elements[k].name, t]));
      now = this.read(t, y);
      for (let i = nq; i < nq + nv; i++) before[i] = Math.max(Math.abs(before[i]), Math.abs(y[i]));
      still = this.stillSpeed(now, before);
    }
    const follow = () => this.follow(t, y, { ...now, touching, still }, forbidden, spent);
    let next = follow();
    if (approaching.length && this.rest(t, y, next, { ...now, touching, still })) {
      // the energy of the bounces left out is lost by the last one
      const { kinetic } = now;
      now = this.read(t, y);
      const share = (kinetic - now.kinetic) / approaching.length;
      this.account(
        y,
        approaching,
        this.elements.map((_, k) => share * approaching.includes(k)),
      );
      next = follow();
    }
    if (typeof next === "string") return next;
    this.times.push(t);
    this.sequence.push(next);
    this.project(t, y, this.rowsHeld(this.modes[next]));
    this.before = this.margins(t, y);
    return "";
  }

  // The speed below which a row's rate is rounding.
  stillSpeed({ rates, slopes, free }, y) {
    const { nq, nv } = this.machine;
    const v = y.slice(nq, nq + nv);
    const speeds = slopes.map(
      (row, r) => withinRow(row, v) + Math.abs(rates[r] - alongRow(row, v)),
    );
    const pull = Math.max(0, ...slopes.map((row) => withinRow(row, free)));
    const usual = Math.sqrt(this.length * pull);
    return this.tolerances.STILL * Math.max(usual, ...speeds) + NO_SPEED;
  }

  // Whether what a mode or an impact presupposes is so, by its numbers: of elements that are near and
  // open the gap must not shrink, of those whose slip begins it must grow.
  isSound(states, numbers, { near, beginning, still }, slack = this.tolerances.SLACK) {
    const sizes = 2 * this.count;
    const pull = slack * numbers.slice(2 * sizes).reduce((a, b) => a + b, 0);
    return states.every((state, k) => {
      const [apart, rubs] = numbers.subarray(2 * k);
      const [high, wide] = numbers.subarray(sizes + 2 * k);
      const { normal } = this.elements[k];
      if (this.isElastic(k)) return true;
      if (normal !== null && state === OPEN)
        return !near.has(k) || apart >= -slack * (high + still);
      const slips = state === FORWARD || state === BACKWARD;
      if (slips && beginning.has(k) && !(rubs >= -slack * (wide + still))) return false;
      return (normal === null || apart >= -pull) && (state !== STICKS || rubs >= -pull);
    });
  }

  // The least of what presses and of the reserves of static friction.
  findLeast(states, numbers) {
    return states.reduce((least, state, k) => {
      if (!isHeld(state) || this.isElastic(k)) return least;
      const [press, reserve] = numbers.subarray(2 * k);
      return Math.min(least, press, state === STICKS ? reserve : Infinity);
    }, Infinity);
  }

  candidates(k, { gaps, rates, touching, still }) {
    const { normal, tangent } = this.elements[k];
    if (this.isElastic(k)) {
      const inside = touching[k] && (gaps[normal] < 0 || rates[normal] < 0);
      return [inside ? "closed" : OPEN];
    }
    if (normal !== null && (!touching[k] || rates[normal] > still)) return [OPEN];
    const apart = normal === null ? [] : [OPEN];
    if (tangent === null) return [...apart, "closed"];
    const slip = rates[tangent];
    if (Math.abs(slip) > still) return [...apart, slip > 0 ? FORWARD : BACKWARD];
    return [...apart, STICKS, FORWARD, BACKWARD];
  }

  // The number of the only mode that may follow, or why there is none. What has spent its static
  // friction sticks on only where others take some of it.
  follow(t, y, now, forbidden, spent) {
    const { rates, touching, still } = now;
    const choices = this.elements.map((_, k) =>
      this.candidates(k, now).filter((state) => !forbidden.has(`${k} ${state}`)),
    );
    const which = (test) =>
      new Set([...this.elements.keys()].filter((k) => test(this.elements[k], k)));
    const instant = {
      near: which(({ struck, normal }, k) => touching[k] && struck && rates[normal] <= still),
      beginning: which(({ tangent }) => tangent === null || Math.abs(rates[tangent]) <= still),
      still: 0,
    };
    const sound = [];
    this.modes.forEach((states, mode) => {
      if (this.ended.has(mode) || !states.every((state, k) => choices[k].includes(state))) return;
      const numbers = this.evaluate(mode, t, y);
      const presupposed = numbers.subarray(this.marginAt + 2 * this.count);
      if (!this.isSound(states, presupposed, instant)) return;
      const lasts = this.isSound(states, presupposed, instant, -this.tolerances.SLACK);
      const least = this.findLeast(states, presupposed);
      const goesOn = lasts || spent.every((k) => states[k] !== STICKS);
      sound.push({ mode, states, goesOn, least, a: numbers.slice(0, this.machine.nv) });
    });
    const going = sound.some(({ goesOn }) => goesOn) ? sound.filter((each) => each.goesOn) : sound;
    const kept = going.filter((each) => !going.some((rival) => this.yields(each, rival, now)));
    const distinct = this.distinguish(kept, now.free, 0);
    if (distinct.length === 1) return distinct[0].mode;
    if (!distinct.length)
      return "where no mode follows whose forces rigid bodies with Coulomb's friction determine";
    const names = distinct.map(({ states }) => states.join(", ")).join("; ");
    return `where ${distinct.length} modes may follow: ${names}`;
  }

  // Whether a mode ends where it need not: what can stick sticks, and latches keep closed.
  yields({ states }, rival, { of }) {
    const differ = [...states.keys()].filter((k) => states[k] !== rival.states[k]);
    const keeps = (k) =>
      (rival.states[k] === STICKS && states[k].startsWith("slips") && of[k].spare > 0) ||
      (rival.states[k] === "closed" && of[k].holds > 0);
    return differ.length > 0 && differ.every(keeps);
  }

  distinguish(solutions, free, still) {
    const most = (a) => a.reduce((largest, x) => Math.max(largest, Math.abs(x)), 0);
    const isSame = (a, b) =>
      most(a.map((x, i) => x - b[i])) <=
      this.tolerances.SAME_ANSWER * (Math.max(most(a), most(b)) + most(free)) + still;
    const kept = [];
    for (const each of solutions) {
      const same = kept.findIndex(({ a }) => isSame(each.a, a));
      // of shares of the same forces the one that leaves most
      if (same < 0) kept.push(each);
      else if (each.least > kept[same].least && `${each.states}` === `${kept[same].states}`)
        kept[same] = each;
    }
    return kept;
  }

  // impacts ---------------------------------------------------------------------------------------

  // Of all contacts that touch together, or one after the other; in words, if none is determined.
  impact(t, y, touching, approaching, still) {
    const contacts = [...this.elements.keys()].filter(
      (k) => touching[k] && this.elements[k].struck,
    );
    const inTurn = contacts.some((k) => this.elements[k].in_turn);
    const taken = new Float64Array(this.count);
    for (let round = 0; round < MOST_IN_TURN; round++) {
      const { rates } = this.read(t, y);
      const rate = (k) => rates[this.elements[k].normal];
      const fastest = contacts.reduce((a, b) => (rate(b) < rate(a) ? b : a));
      if (rate(fastest) >= -still) break;
      const words = this.strikeTogether(t, y, inTurn ? [fastest] : contacts, still, taken);
      if (words) return words;
      if (!inTurn) break;
    }
    this.account(y, approaching, taken);
    return "";
  }

  // One contact by itself, by Routh's diagram.
  strikeAlone(t, y, k, taken) {
    const { nq, nv, program } = this.machine;
    program[`impact${k}`](t, y, this.p, this.struck);
    const change = this.struck.subarray(0, nv);
    const { rates, slopes, of } = this.read(t, y);
    const { normal, by_impulse: byImpulse } = this.elements[k];
    const wanted = (this.tolerances.SAME_ANSWER - of[k].restitution) * rates[normal];
    // friction jams what should part by Newton's law
    if (!byImpulse && rates[normal] + alongRow(slopes[normal], change) < wanted)
      return "where no velocities follow after the impact";
    change.forEach((step, i) => (y[nq + i] += step));
    taken.forEach((_, i) => (taken[i] += this.struck[nv + i]));
    return "";
  }

  // By Newton's law at once; by Poisson's a compression, whose impulses then return, e times each.
  strikeTogether(t, y, contacts, still, taken) {
    const { nq, nv } = this.machine;
    if (contacts.length === 1) return this.strikeAlone(t, y, contacts[0], taken);
    const byImpulse = this.elements[contacts[0]].by_impulse;
    if (contacts.some((k) => this.elements[k].by_impulse !== byImpulse))
      return "where contacts impact together by Newton's and by Poisson's law";
    for (const kind of byImpulse ? ["strike", "expansion"] : ["strike"]) {
      const solutions = this.solveImpact(t, y, new Set(contacts), still, kind);
      if (solutions.length !== 1)
        return `where ${solutions.length || "no"} velocities follow after the impact`;
      const [{ a, lost, pressed }] = solutions;
      for (let i = 0; i < nv; i++) y[nq + i] += a[i];
      lost.forEach((energy, k) => (taken[k] += energy));
      const { rates, slopes, of } = this.read(t, y);
      if (kind === "strike") {
        const places = [...this.elements.keys()].filter((k) => this.elements[k].struck);
        const impulses = places.map((k) => of[k].restitution * pressed[k]);
        this.p.set(impulses, this.p.length - this.forces);
      } else if (
        contacts.some((k) => {
          const { normal } = this.elements[k];
          const size = withinRow(slopes[normal], a) + Math.abs(rates[normal]);
          return rates[normal] < -this.tolerances.SLACK * size - still;
        })
      )
        return "where bodies still approach each other after Poisson's expansion";
    }
    return "";
  }

  solveImpact(t, y, contacts, still, kind) {
    const { nv, program } = this.machine;
    const sound = [];
    const all = kind === "strike" ? this.strikes : this.expansions;
    all.forEach((states, k) => {
      if (!states.every((state, i) => state === OPEN || contacts.has(i))) return;
      if (kind === "expansion" && [...contacts].some((i) => states[i] === OPEN)) return;
      const numbers = program[`${kind}${k}`](t, y, this.p, this.struck);
      const presupposed = numbers.subarray(nv + this.count);
      if (this.isSound(states, presupposed, { near: contacts, beginning: contacts, still }))
        sound.push({
          a: numbers.slice(0, nv),
          lost: numbers.slice(nv, nv + this.count),
          pressed: states.map((state, i) => (state === OPEN ? 0 : presupposed[2 * i])),
        });
    });
    return this.distinguish(sound, [], still);
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

  // Takes away the rates of contacts whose bounces are over, those left staying below rounding, while
  // what the next mode holds stays together; says whether there are any.
  rest(t, y, next, { rates, of, touching, still }) {
    if (typeof next === "string") return false;
    const numbers = this.evaluate(next, t, y);
    const ended = this.elements.flatMap(({ normal, struck }, k) => {
      if (!touching[k] || !struck) return [];
      const speed = rates[normal];
      const fall = -numbers[this.marginAt + 2 * this.count + 2 * k];
      if (!(of[k].restitution < 1 && speed > still && fall > 0)) return [];
      return speed ** 2 / (2 * fall) <= this.tolerances.TAIL * this.length ? [normal] : [];
    });
    if (!ended.length) return false;
    const loops = this.loopsOf([...this.rowsHeld(this.modes[next]), ...ended]);
    loops.evaluate(t, y);
    loops.closeRates(y);
    return true;
  }

  // what happened ---------------------------------------------------------------------------------

  // The states of each element in time, as the strips below the clock show them.
  strips(last) {
    return this.elements.map(({ name }, k) => {
      const spans = [];
      this.times.forEach((begin, i) => {
        const end = this.times[i + 1] ?? last;
        const state = this.modes[this.sequence[i]][k];
        const before = spans[spans.length - 1];
        if (before?.[2] === state) before[1] = end;
        else if (end > begin || spans.length === 0) spans.push([begin, end, state]);
      });
      const impacts = this.impacts.filter(([element]) => element === name).map(([, t]) => t);
      return { name, spans, impacts };
    });
  }
}
