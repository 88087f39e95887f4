// Judges formulas by their values in the question's states, as the package's own judge does. What
// needs algebra, units or other states is left to the teacher.

import { Letters, Unread, read } from "./reader.js";

const TOLERANCE = 1e-8;
const FAR = 1e-6;
const CLOSE = 1e-6;
// Next to a singular state rounding grows: at θ = 7e-7 a right equation of a dumbbell is off by 2e-5.
const NEAR_SINGULAR = 1e-2;
const ASKED = "#asked";
const IDLE = "it has a term that is too small to be seen";
const HOLDS = 1e-7;
const MOVING = ["coordinate", "velocity"];
const RANK = 1e-7;
const ROUNDING = 1e-13;
const RANKED = 6;
const MAGNITUDES = [1e-3, 0.03, 0.1, 0.3, 0.6, 0.9, 1.1, 1.5, 3.0, 10.0, 30.0, 1e3];
const FACTORS = [...MAGNITUDES.map((x) => -x).reverse(), ...MAGNITUDES];
const CALLS = {
  ...{ sin: Math.sin, cos: Math.cos, tan: Math.tan, sinh: Math.sinh, cosh: Math.cosh },
  ...{ tanh: Math.tanh, exp: Math.exp, sqrt: Math.sqrt },
};

/** Return {outcome, lines, forms, causes}; outcome "teacher" where it cannot be judged here. */
export function judge(question, text) {
  try {
    const statements = read(text, new Letters(question.letters, question.angles));
    const used = new Set();
    statements.forEach((sides) => sides.forEach((side) => collect(side, used)));
    const left = (question.left ?? []).find((name) => used.has(name));
    if (left) return leave(`this page does not judge potentials of loads such as ${left}`);
    const by = { motion: judgeMotion, several: judgeSeveral }[question.kind] ?? judgeValue;
    const verdict = by(question, statements, used, text);
    const bad = ["wrong", "incomplete"].includes(verdict.outcome);
    const otherwise = bad && readOtherwise(question, statements, text);
    return otherwise ? leave(`this page cannot read ${otherwise}`) : verdict;
  } catch (error) {
    if (!(error instanceof Unread)) throw error;
    return leave(`this page cannot read ${error.message}`);
  }
}

function leave(reason) {
  return { outcome: "teacher", lines: [], forms: [reason], causes: [] };
}

function collect(node, used) {
  if (node.op === "letter") used.add(node.name);
  (node.parts ?? []).forEach((part) => collect(part, used));
}

/** Return the value of a formula and the size of its terms, in one state. */
function evaluate(node, letters) {
  if (node.op === "number") return [node.value, Math.abs(node.value)];
  if (node.op === "letter") return [letters[node.name], Math.abs(letters[node.name])];
  const parts = node.parts.map((part) => evaluate(part, letters));
  const [[a, p], [b, r] = []] = parts;
  switch (node.op) {
    case "sum":
      return parts.reduce(([x, s], [y, t]) => [x + y, s + t]);
    case "product":
      return [a * b, p * r];
    case "quotient":
      return [a / b, (p / Math.abs(b)) * (r / Math.abs(b))];
    case "negative":
      return [-a, p];
    case "power": {
      const value = b === 2 ? a * a : a ** b;
      const worse = a === 0 ? 1 : p / Math.abs(a);
      return [value, Math.abs(value) * Math.max(1, Math.abs(b) * worse)];
    }
    default: {
      const value = CALLS[node.name](a);
      return [value, Math.abs(value) + (["sin", "cos"].includes(node.name) ? p : 0)];
    }
  }
}

function subtract(left, right) {
  return { op: "sum", parts: [left, { op: "negative", parts: [right] }] };
}

/** Return the letters of a state: of a table of columns the row k. */
function rowOf(table, k) {
  const row = { pi: Math.PI };
  for (const [name, column] of Object.entries(table)) row[name] = column[k];
  return row;
}

function rowsOf(table) {
  const count = Object.values(table)[0].length;
  return Array.from({ length: count }, (_, k) => rowOf(table, k));
}

function worstOf(pairs) {
  let worst = 0;
  for (const [value, size] of pairs)
    if (Number.isFinite(value) && Number.isFinite(size) && size > 0)
      worst = Math.max(worst, Math.abs(value) / size);
  return worst;
}

/** Yield a formula without one of the terms of its sums, for each of them. */
function* withoutTerms(node) {
  for (const [k, part] of (node.parts ?? []).entries()) {
    const put = (other) => ({
      ...node,
      parts: node.parts.map((old, at) => (at === k ? other : old)),
    });
    const inner = part.op === "negative" ? part.parts[0] : part;
    if (node.op === "sum" && !(inner.op === "number" && inner.value === 0))
      yield put({ op: "number", value: 0 });
    for (const other of withoutTerms(part)) yield put(other);
  }
}

/** Whether a term is too small to be seen in any state. */
function hasIdleTerm(root, states) {
  const whole = states.map((row) => evaluate(root, row));
  for (const other of withoutTerms(root)) {
    const left = states.map((row) => evaluate(other, row)[0]);
    if (worstOf(whole.map(([value, size], k) => [value - left[k], size])) <= TOLERANCE) return true;
  }
  return false;
}

/** Whether a number is written with as many digits as a rounded one has. */
function looksRounded(text) {
  return (text.match(/\d*[.,]\d+/g) ?? []).some(
    (number) => number.replace(/[.,]/g, "").replace(/^0+/, "").length > 1,
  );
}

function lacksParameters(question, used) {
  return question.parameters.some((name) => !used.has(name));
}

/** Why a wrong answer may still be right, for all that can be said here. */
function doubt(question, text) {
  if (question.name === "Lagrangian") return "a Lagrangian of another form";
  if (/\/\d+[^\W\d_]/.test(text)) return "a denominator without brackets, as in 3g/2l";
  if (looksRounded(text)) return "numbers that may be rounded";
  return "";
}

/** What the package reads in a way of its own. */
function readOtherwise(question, statements, text) {
  if (/_\{?t{1,2}(?![A-Za-z0-9])/.test(text)) return "a derivative by a subscript";
  if (/^\s{0,9}\(?(?:\d{1,2}|[a-z]|i{1,3})[.)]|\((?:\d{1,2}|[a-z])\)\s{0,9}$/m.test(text))
    return "lines with numbers";
  if (/^\s{0,9}\\?[A-Za-z]{1,9} ?\([^()=+*/^-]{0,40}\) {0,3}=/m.test(text))
    return "what a quantity depends on";
  const letters = statements.map((sides) => {
    const used = new Set();
    sides.forEach((side) => collect(side, used));
    return used;
  });
  const defines = statements.some(([left], k) => {
    const { name } = left.op === "power" ? left.parts[0] : left;
    if (!name || (question.accelerations ?? []).includes(name)) return false;
    const forms = [name, `${name}'`, `${name}''`];
    return letters.some((used, other) => other !== k && forms.some((form) => used.has(form)));
  });
  return defines ? "a definition" : "";
}

// --- equations of motion

function judgeMotion(question, statements, used, text) {
  const equations = [];
  for (const sides of statements) {
    if (sides.length === 1) equations.push(sides[0]);
    for (let k = 1; k < sides.length; k += 1) equations.push(subtract(sides[k - 1], sides[k]));
  }
  const states = rowsOf(question.states);
  const moves = [...used].some((name) => MOVING.includes(question.letters[name]));
  const judged = equations.map((root) => judgeEquation(root, { ...question, moves }, states));
  const unclear = judged.find((one) => one.unclear);
  if (unclear) return leave(unclear.unclear);
  const linearized = judged.some((one) => one.forms.includes("linearized"));
  if (linearized && judged.some((one) => one.outcome === "right"))
    return leave("this page cannot judge linearized equations beside exact ones");
  const off = judged.some((one) => one.off);
  const left = off ? judgeWrong(question, equations, used, text) : null;
  return left ?? sumUp(question, equations, judged, states);
}

function sumUp(question, equations, judged, states) {
  const sound = equations.filter((_, k) => judged[k].outcome !== "wrong");
  const nv = question.accelerations.length;
  const missing = sound.length ? countMissing(sound, question, states) : nv;
  const bad = judged.some((one) => one.outcome === "wrong");
  const causes = judged.flatMap((one) => one.causes.slice(0, 1));
  const forms = bad ? [] : judged.flatMap((one) => one.forms);
  if (!bad && missing) forms.unshift(`${missing} of ${nv} equations missing`);
  const good = forms.length ? "right except for form" : "right";
  return {
    outcome: bad ? "wrong" : missing ? "incomplete" : good,
    lines: judged.map((one) => one.outcome),
    forms: [...new Set(forms)],
    causes: [...new Set(causes)],
    independent: nv - missing,
    needed: nv,
  };
}

/** Return what is said of wrong equations as a whole, null if they are judged one by one. */
function judgeWrong(question, equations, used, text) {
  const numbers = rowsOf(question.numbers);
  const withNumbers = equations.every(
    (root) => worstOf(numbers.map((row) => evaluate(root, row))) <= TOLERANCE,
  );
  if (lacksParameters(question, used) && withNumbers)
    return leave(
      "this page compares formulas in letters, and this one holds for the numbers given",
    );
  const unsure = doubt(question, text);
  return unsure ? leave(`this page cannot judge ${unsure}`) : null;
}

function judgeEquation(root, question, states) {
  const pairs = states.map((row) => evaluate(root, row));
  const finite = pairs.filter(([value, size]) => Number.isFinite(value) && Number.isFinite(size));
  if (finite.length < Math.min(6, states.length))
    return { unclear: "it has a value in few states" };
  if (worstOf(pairs) > TOLERANCE) {
    // a difference at the edge of rounding is looked at more closely by the teacher's judge
    if (worstOf(pairs) < CLOSE) return { unclear: "it is off by very little" };
    return { ...explain(root, question, states), off: true };
  }
  const moved = states.map((row) => evaluate(root, move(row, question, 1)));
  const base = pairs.map(([value]) => value);
  if (worstOf(moved.map(([value, size], k) => [value - base[k], size])) <= TOLERANCE)
    return failed("it holds for any motion");
  if (!isAffine(root, question, states, base))
    return { unclear: "it is not linear in the accelerations" };
  const far = worstOf(evaluateFar(root, question));
  if (far > FAR && far < NEAR_SINGULAR) return { unclear: "it is off by little in special states" };
  if (far > FAR) return failed("it holds near the usual states only");
  const moving = states.map((row) => move(row, question, 1));
  const everywhere = [...states, ...moving, ...(question.far ? rowsOf(question.far) : [])];
  if (hasIdleTerm(root, everywhere)) return { unclear: IDLE };
  if (mayVanish(root, question))
    return { unclear: "it may be multiplied by a factor that vanishes" };
  return { holds: true, outcome: "right", forms: [], causes: [] };
}

/** Return the values far out, 0 where the error of a vanishing acceleration explains them. */
function evaluateFar(root, question) {
  if (!question.far) return [];
  return rowsOf(question.far).map((row, k) => {
    const [value, size] = evaluate(root, row);
    const by = slopes(root, row, question.accelerations).map(Math.abs);
    return [Math.abs(value) > ROUNDING * dot(by, question.usual[k]) ? value : 0, size];
  });
}

function failed(...causes) {
  return { holds: false, outcome: "wrong", forms: [], causes };
}

function move(row, question, factor) {
  const moved = { ...row };
  question.accelerations.forEach((name, k) => {
    moved[name] += factor * (1 + 0.37 * k) * (1 + Math.abs(row[name]));
  });
  return moved;
}

function isAffine(root, question, states, base) {
  const [back, once, twice] = [-1, 1, 2].map((factor) =>
    states.map((row) => evaluate(root, move(row, question, factor))),
  );
  const bends = twice.map(([value, size], k) => [value - 2 * once[k][0] + base[k], size]);
  const kinks = once.map(([value], k) => [value - 2 * base[k] + back[k][0], twice[k][1]]);
  return Math.max(worstOf(bends), worstOf(kinks)) <= TOLERANCE;
}

/** Return the derivatives by the accelerations of an equation that is linear in them. */
function slopes(root, row, accelerations) {
  const base = evaluate(root, row)[0];
  return accelerations.map((name) => {
    const step = 1 + Math.abs(row[name]);
    return (evaluate(root, { ...row, [name]: row[name] + step })[0] - base) / step;
  });
}

/** Whether the weights of the true equations turn round between neighboring points of a path. */
function mayVanish(root, question) {
  const { letters, M, steps } = question.paths;
  const rows = rowsOf(letters);
  const weights = rows.map((row, k) => solve(M[k], slopes(root, row, question.accelerations)));
  for (let k = 1; k < rows.length; k += 1) if (k % steps && turnsRound(weights, k)) return true;
  return rows.slice(0, steps).some((row) => dependsOnVelocities(root, row, question));
}

/** At a pole the weights grow before they turn round; at a zero they become small. */
function turnsRound(weights, k) {
  const [before, here] = [weights[k - 1], weights[k]];
  if (!before || !here || dot(before, here) >= 0) return false;
  const size = (at) => Math.hypot(...(weights[at] ?? []));
  return size(k - 1) + size(k) < size(k - 2) + size(k + 1) || k < 2;
}

function dependsOnVelocities(root, row, question) {
  const other = { ...row };
  question.velocities.forEach((name) => (other[name] *= -1.7));
  const [one, two] = [row, other].map((letters) =>
    slopes(root, letters, question.accelerations).map((x, k) => x / question.inertia[k]),
  );
  const size = Math.hypot(...one, ...two);
  return one.some((x, k) => Math.abs(x - two[k]) > 1e-6 * size);
}

function dot(a, b) {
  return a.reduce((sum, x, k) => sum + x * b[k], 0);
}

/** Return x of A x = b for a symmetric matrix, null if it is singular. */
function solve(A, b) {
  const rows = A.map((row, k) => [...row, b[k]]);
  for (let k = 0; k < rows.length; k += 1) {
    let pivot = k;
    for (let i = k + 1; i < rows.length; i += 1)
      if (Math.abs(rows[i][k]) > Math.abs(rows[pivot][k])) pivot = i;
    [rows[k], rows[pivot]] = [rows[pivot], rows[k]];
    if (!(Math.abs(rows[k][k]) > 0)) return null;
    for (let i = 0; i < rows.length; i += 1) {
      const factor = i === k ? 0 : rows[i][k] / rows[k][k];
      if (factor) rows[i] = rows[i].map((x, j) => x - factor * rows[k][j]);
    }
  }
  return rows.map((row, k) => row.at(-1) / row[k]);
}

/** Return how many accelerations the equations leave open, in the best of some states. */
function countMissing(sound, question, states) {
  const nv = question.accelerations.length;
  let missing = nv;
  for (const row of states.slice(0, RANKED)) {
    const table = sound.map((root) => {
      const by = slopes(root, row, question.accelerations).map((x, k) => x / question.inertia[k]);
      const size = Math.hypot(...by);
      return by.map((x) => (size > 0 ? x / size : 0));
    });
    missing = Math.min(missing, nv - rank(table));
  }
  return missing;
}

function rank(table) {
  const rows = table.map((row) => [...row]);
  let count = 0;
  for (const row of rows) {
    for (const other of rows.slice(0, count)) {
      const along = dot(row, other);
      row.forEach((_, k) => (row[k] -= along * other[k]));
    }
    const size = Math.hypot(...row);
    if (size > RANK) {
      const unit = row.map((x) => x / size);
      rows[count] = unit;
      count += 1;
    }
  }
  return count;
}

/** Return the slips after which a wrong equation holds. */
function explain(root, question, states) {
  const causes = [];
  for (const slip of question.slips) {
    const pairs = states.map((row, k) => {
      const moved = { ...row };
      question.accelerations.forEach((name, j) => (moved[name] = slip.motion[j][k]));
      return evaluate(root, moved);
    });
    if (worstOf(pairs) <= HOLDS) causes.push(slip);
  }
  // a motion without any force is no linearized one
  const likely = causes.findIndex((slip) => slip.kind === "linearized");
  // what a likelier slip leads to as well is decided by the teacher's judge
  if (question.moves && likely > 0) return { unclear: "it may lack a term, or be linearized" };
  if (question.moves && likely === 0)
    return { outcome: "right except for form", forms: ["linearized"], causes: [] };
  const others = causes.filter((slip) => slip.kind !== "linearized");
  return failed(...others.map((slip) => slip.text));
}

// --- energies, momenta and frequencies

function judgeValue(question, statements, used, text) {
  const states = rowsOf(question.states);
  const known = withNames(states, question.names, question.values);
  const { again } = question;
  const there = again ? withNames(rowsOf(again.states), question.names, again.values) : null;
  const lines = statements.map((sides) => judgeFormula(sides, question, states, known, there));
  const unclear = lines.find((line) => line.unclear);
  if (unclear) return leave(unclear.unclear);
  if (lines.some((line) => !line.holds)) {
    const unsure = doubt(question, text) || doubtNumbers(question, statements, used);
    if (unsure) return leave(`this page cannot judge ${unsure}`);
  }
  return sumUpValues(lines);
}

function judgeFormula(sides, question, states, known, there) {
  if (sides.length > 2) return { unclear: "this page cannot judge a chain of equations" };
  const root = subtract(sides[0], sides[1] ?? { op: "letter", name: ASKED });
  const worst = compare(root, known, there);
  if (worst > TOLERANCE && worst < CLOSE) return { unclear: "it is off by very little" };
  if (worst > TOLERANCE) return { holds: false, empty: "" };
  const values = known.map((row) => pick(row, question.names));
  const asks = determines(sides, question.names);
  const empty = asks ? findEmptiness(root, states, [values], Boolean(there), true) : "";
  const moved = known.map((row) => ({ ...row, ...scale(pick(row, question.names), 1.7) }));
  if (!empty && hasIdleTerm(root, [...known, ...moved])) return { unclear: IDLE };
  return { holds: true, empty };
}

function pick(row, names) {
  return Object.fromEntries(names.map((name) => [name, row[name]]));
}

/** Return values times a factor; those that are zero are moved as one would be. */
function scale(values, factor) {
  const scaled = Object.entries(values).map(([name, x]) => [name, x ? factor * x : factor - 1]);
  return Object.fromEntries(scaled);
}

function sumUpValues(lines) {
  const outcomes = lines.map((line) => (line.holds && !line.empty ? "right" : "wrong"));
  const outcome = outcomes.includes("wrong") ? "wrong" : "right";
  const causes = lines.map((line) => line.empty).filter(Boolean);
  const independent = outcomes.includes("right") ? 1 : 0;
  return { outcome, lines: outcomes, forms: [], causes, independent, needed: 1 };
}

function doubtNumbers(question, statements, used) {
  if (!lacksParameters(question, used)) return "";
  const { numbers } = question;
  const known = withNames(rowsOf(numbers.states), question.names, numbers.values);
  const again = numbers.again ?? null;
  const there = again ? withNames(rowsOf(again.states), question.names, again.values) : null;
  const holds = statements.every((sides) => {
    const root = subtract(sides[0], sides[1] ?? { op: "letter", name: ASKED });
    return compare(root, known, there) <= CLOSE;
  });
  return holds ? "what holds for the numbers given" : "";
}

/** Return how far a formula is off; of one with an open constant, its changes. */
function compare(root, known, there) {
  const pairs = known.map((row) => evaluate(root, row));
  if (!there) return worstOf(pairs);
  const changes = there.map((row) => evaluate(root, row));
  return worstOf(pairs.map(([v, s], k) => [v - changes[k][0], Math.max(s, changes[k][1])]));
}

/** Letters of the mechanism keep their own meaning. */
function withNames(rows, names, values) {
  return rows.map((row, k) => {
    const asked = Object.fromEntries(names.map((name) => [name, values[k]]));
    return { ...asked, ...row, [ASKED]: values[k] };
  });
}

/** Whether a line is an equation for a quantity, or a formula that contains its letter. */
function determines(sides, names) {
  const used = new Set();
  collect(sides[0], used);
  return sides.length > 1 || names.some((name) => used.has(name));
}

/**
 * Return why an equation that holds does not determine the quantity, "" if it does: it must change
 * its sign at each of the roots, and nowhere else, or the difference from its value there must.
 */
function findEmptiness(root, states, [known, ...more], openConstant = false, signed = false) {
  const used = new Set();
  collect(root, used);
  const names = Object.keys(known[0]);
  const first = names.find((name) => used.has(name)) ?? names[0];
  const others = more.filter((other) => other.some((at, k) => at[first] !== known[k][first]));
  const table = states.map((row, k) => {
    const [here, itsSize] = evaluate(root, { ...row, ...known[k] });
    return FACTORS.map((factor) => {
      const moved = scale(known[k], factor);
      const [value, size] = evaluate(root, { ...row, ...moved });
      const changed = value - (openConstant ? here : 0);
      if (!(Math.abs(changed) > TOLERANCE * Math.max(size, itsSize))) return 0;
      const sides = others.map((other) => Math.sign(moved[first] - other[k][first]));
      return sides.reduce((a, b) => a * b, Math.sign(factor - 1) * changed);
    });
  });
  if (table.every((row) => row.every((x) => !x)))
    return "it holds for any value of the quantity in question";
  const above = FACTORS.findIndex((factor) => factor > 1);
  const touches = table.filter((row) => row[above - 1] * row[above] < 0).length;
  if (touches > states.length / 2)
    return "it only touches zero: a square or a magnitude does not determine a quantity";
  const negative = known.some((at) => Object.values(at).some((x) => x < 0));
  const foreign = table.some((row) => turns(row, signed || negative));
  return foreign ? "it holds for other values, too" : "";
}

/** Whether values along the factors have both signs; at a pole at zero they grow before. */
function turns(row, fromBelow) {
  const start = MAGNITUDES.length;
  const [before, below, above] = row.slice(start - 2, start + 1);
  const sign = Math.abs(below) > Math.abs(before) && below * above < 0 ? -1 : 1;
  const whole = [
    ...(fromBelow ? row.slice(0, start).map((x) => sign * x) : []),
    ...row.slice(start),
  ];
  return whole.some((x) => x < 0) && whole.some((x) => x > 0);
}

function judgeSeveral(question, statements, used, text) {
  const states = rowsOf(question.states);
  const found = statements.map((sides) => coverOne(sides, question.measures, states));
  const unclear = found.find((line) => line.unclear);
  if (unclear) return leave(unclear.unclear);
  const right = found.filter((line) => line.covers.length && !line.empty);
  const lines = found.map((line) => (right.includes(line) ? "right" : "wrong"));
  const causes = found.map((line) => line.empty).filter(Boolean);
  const bad = lines.includes("wrong");
  const numbers = bad && lacksParameters(question, used) && coversWithNumbers(question, statements);
  const unsure =
    bad && (doubt(question, text) || (numbers ? "what holds for the numbers given" : ""));
  if (unsure) return leave(`this page cannot judge ${unsure}`);
  const named = new Set(right.flatMap((line) => line.covers));
  const independent = question.oscillating.filter((k) => named.has(k)).length;
  const needed = question.oscillating.length;
  const lacking = bad ? 0 : needed - independent;
  const forms = lacking ? [`${lacking} of ${needed} frequencies missing`] : [];
  const outcome = bad ? "wrong" : lacking ? "incomplete" : "right";
  return { outcome, lines, forms, causes, independent, needed };
}

function coversWithNumbers({ numbers }, statements) {
  const states = rowsOf(numbers.states);
  return statements.every((sides) => coverOne(sides, numbers.measures, states).covers?.length);
}

/** Return which of several values a line holds for. */
function coverOne(sides, measures, states) {
  if (sides.length > 2) return { unclear: "this page cannot judge a chain of equations" };
  // of a frequency that is zero there is no period
  const names = Object.keys(Object.assign({}, ...measures));
  const root = subtract(sides[0], sides[1] ?? { op: "letter", name: names[0] });
  const worst = measures.map((measure) =>
    worstOf(states.map((row, k) => evaluate(root, { ...rowOf(measure, k), ...row }))),
  );
  if (worst.some((one) => one > TOLERANCE && one < CLOSE))
    return { unclear: "it is off by very little" };
  const covers = worst.flatMap((one, k) => (one <= TOLERANCE ? [k] : []));
  if (!covers.length) return { covers };
  const shared = names.filter((name) => covers.every((k) => name in measures[k]));
  const roots = covers.map((k) => states.map((_, at) => pick(rowOf(measures[k], at), shared)));
  const empty = determines(sides, names) ? findEmptiness(root, states, roots) : "";
  const known = states.map((row, at) => ({ ...roots[0][at], ...row }));
  const moved = states.map((row, at) => ({ ...scale(roots[0][at], 1.7), ...row }));
  if (!empty && hasIdleTerm(root, [...known, ...moved])) return { unclear: IDLE };
  return { covers, empty };
}
