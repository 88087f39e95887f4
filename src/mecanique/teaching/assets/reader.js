// Reads formulas in plain text and LaTeX into trees, as the package's own reader does. What it is
// not sure to read alike is refused, and left to the teacher.

const SIGNS = new Map([
  ...["−", "–", "‑", "－"].map((sign) => [sign, "-"]),
  ...["·", "×", "⋅", "∙", "∗"].map((sign) => [sign, "*"]),
  ...["′", "’", "ʹ", "´"].map((sign) => [sign, "'"]),
  ...["″", "”", '"'].map((sign) => [sign, "''"]),
  ...["\u00a0", "\u2009", "\t", "~", "$"].map((sign) => [sign, " "]),
  ["＋", "+"],
  ["＝", "="],
  ["÷", "/"],
  ["⁄", "/"],
  ["√", " sqrt "],
  ["ℓ", "l"],
  ["ϑ", "theta"],
  ["ϕ", "phi"],
  ["½", "(1/2)"],
  ["⅓", "(1/3)"],
  ["¼", "(1/4)"],
  ["\r", "\n"],
]);
const DOTS = new Map([
  ["\u0307", "'"],
  ["\u0308", "''"],
]);
const RAISED = "⁰¹²³⁴⁵⁶⁷⁸⁹";
const LOWERED = "₀₁₂₃₄₅₆₇₈₉";
const GREEK = {
  ...{ α: "alpha", β: "beta", γ: "gamma", δ: "delta", ζ: "zeta", θ: "theta", κ: "kappa" },
  ...{ λ: "lambda", μ: "mu", ν: "nu", π: "pi", ρ: "rho", σ: "sigma", τ: "tau", φ: "phi" },
  ...{ χ: "chi", ψ: "psi", ω: "omega", Ω: "Omega" },
};
const SPELLINGS = {
  ...{ sen: "sin", tg: "tan", Sin: "sin", Cos: "cos", Tan: "tan", Sqrt: "sqrt", Exp: "exp" },
};
const VARIANTS = { vartheta: "theta", varphi: "phi", ell: "l" };
// Others have values near zero whose rounding the package judges in ways of its own.
const FUNCTIONS = new Set(["sin", "cos", "tan", "cot", "sinh", "cosh", "tanh", "exp", "sqrt"]);
const IGNORED =
  /\\(?:left|right|[bB]igg?[lr]?|displaystyle|quad|qquad|nonumber|,|;|:|!| |\(|\)|\[|\])(?![A-Za-z])/g;
const MOST_CHARACTERS = 20000;
const MOST_TOKENS = 4000;
const MOST_DEPTH = 40;

/** What this reader leaves to the teacher. */
export class Unread extends Error {}

/** The letters of a question: names, kinds, and how they are compared. */
export class Letters {
  constructor(kinds, angles) {
    this.kinds = kinds;
    this.angles = new Set(angles);
    this.byKey = new Map(Object.keys(kinds).map((name) => [keyOf(name), name]));
    this.longest = Math.max(...[...this.byKey.keys(), ...FUNCTIONS].map((name) => name.length)) + 6;
  }

  find(word) {
    return this.byKey.get(keyOf(word));
  }
}

function keyOf(name) {
  const dots = /'*$/.exec(name)[0];
  const stem = name.slice(0, name.length - dots.length);
  const plain = stem.replace(/[_{}\s]/g, "");
  const base = /^[^\d_]*/.exec(plain)[0];
  return (VARIANTS[base] ?? base) + plain.slice(base.length) + dots;
}

function normalize(text) {
  let out = "";
  for (const original of text) {
    if (RAISED.includes(original)) out += `^${RAISED.indexOf(original)}`;
    else if (LOWERED.includes(original)) out = lower(out, String(LOWERED.indexOf(original)));
    else if (SIGNS.has(original)) out += SIGNS.get(original);
    else for (const sign of original.normalize("NFD")) out += DOTS.get(sign) ?? sign;
  }
  if (/\^\d\^/.test(out)) throw new Unread("a power of several raised digits");
  return out.replace(/[Α-ω]/g, (letter) => (GREEK[letter] ? ` ${GREEK[letter]}` : letter));
}

/** The dots of a letter come after its subscript. */
function lower(out, digit) {
  const dots = /'{0,3}$/.exec(out)[0];
  return out.slice(0, out.length - dots.length) + digit + dots;
}

/** SymPy's Eq(…, 0) and Derivative(q(t), (t, 2)). */
function rewrite(text) {
  return text
    .replace(/Derivative\((\w+)\(t\), \(t, ([12])\)\)/g, (_, name, n) => name + "'".repeat(n))
    .replace(/Derivative\((\w+)\(t\), t\)/g, "$1'")
    .replace(/^\s*Eq\((.*), ([^,()]*)\)\s*$/gm, "$1 = $2");
}

function strip(text) {
  return rewrite(text)
    .replace(/\\(?:begin|end)\s*\{(?:aligned|align|equation|gather|split|cases)\*?\}/g, "\n")
    .replace(/\\\\/g, "\n")
    .replace(/\\(?:d|t)frac/g, "\\frac")
    .replace(IGNORED, " ")
    .replace(/\\(?:cdot|times|ast)(?![A-Za-z])/g, "*")
    .replace(/&/g, " ");
}

/** Cuts a text into tokens {kind, value}. */
class Scanner {
  constructor(text, letters) {
    this.text = strip(normalize(text));
    this.letters = letters;
    this.at = 0;
    this.tokens = [];
  }

  scan() {
    while (this.at < this.text.length) {
      this.next();
      if (this.tokens.length > MOST_TOKENS) throw new Unread("a formula of this length");
    }
    return this.tokens;
  }

  match(pattern) {
    pattern.lastIndex = this.at;
    const match = pattern.exec(this.text);
    if (match) this.at = pattern.lastIndex;
    return match;
  }

  put(kind, value) {
    this.tokens.push({ kind, value });
  }

  next() {
    let match;
    if ((match = this.match(/[^\S\n]+/y))) return;
    if ((match = this.match(/(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?/y))) this.number(match[0]);
    else if (
      (match = this.match(/\\d{1,2}ot\s*(?:\{[^{}]*\}|\\[A-Za-z]+|[A-Za-z])(?:_\{?\w+\}?)?/y))
    )
      this.dotted(match[0]);
    else if ((match = this.match(/\\frac/y))) this.fraction();
    else if ((match = this.match(/\\?[A-Za-z](?:[A-Za-z0-9]|_(?=[A-Za-z0-9])|_\{\w{1,20}\})*/y)))
      this.word(match[0]);
    else if ((match = this.match(/\*\*|==|[-+*/^=(){}[\],;\n]/y))) this.sign(match[0]);
    else if (!(match = this.match(/\.(?=\s*(?:\n|$))/y)))
      throw new Unread(`the sign ${this.text[this.at]}`);
  }

  number(written) {
    if (/^,\d/.test(this.text.slice(this.at))) throw new Unread("a decimal comma");
    this.put("NUMBER", written);
  }

  sign(sign) {
    const same = { "**": "^", "==": "=", "{": "(", "}": ")", "[": "(", "]": ")" };
    this.put(same[sign] ?? sign, sign);
  }

  dotted(command) {
    const dots = command.startsWith("\\dd") ? "''" : "'";
    const inner = command.replace(/^\\d{1,2}ot/, "").replace(/[\\{}\s_]/g, "");
    this.letter(inner + dots);
  }

  /** An argument without braces is a digit or a letter. */
  fraction() {
    this.put("FRACTION", "");
    for (let k = 0; k < 2; k += 1) {
      this.match(/\s*/y);
      if (this.text[this.at] === "{") this.braces();
      else {
        const match = this.match(/\d|\\[A-Za-z]+|[A-Za-z]/y);
        if (!match) throw new Unread("a fraction without arguments");
        this.put("(", "{");
        if (/\d/.test(match[0])) this.put("NUMBER", match[0]);
        else this.word(match[0]);
        this.put(")", "}");
      }
    }
  }

  braces() {
    let depth = 0;
    do {
      const first = this.tokens.length;
      this.next();
      for (const token of this.tokens.slice(first))
        depth += (token.kind === "(") - (token.kind === ")");
    } while (depth > 0 && this.at < this.text.length);
    if (depth > 0) throw new Unread("a brace that is not closed");
  }

  word(written) {
    const word = written.replace(/[\\{}]/g, "");
    const primes = this.match(/\s?'+|\^\{?(?:\s*\\prime)+\s*\}?/y);
    const dots = "'".repeat(primes ? (primes[0].match(/'|\\prime/g) ?? []).length : 0);
    const name = this.letters.find(word + dots);
    if (name) this.named(name);
    else if (!dots && FUNCTIONS.has(SPELLINGS[word] ?? word))
      this.put("FUNCTION", SPELLINGS[word] ?? word);
    else this.split(word, dots);
  }

  letter(word) {
    const name = this.letters.find(word);
    if (!name) throw new Unread(`the letter ${word}`);
    this.named(name);
  }

  named(name) {
    this.put("NAME", name);
    const kind = this.letters.kinds[name];
    if (["coordinate", "velocity", "acceleration", "input"].includes(kind))
      this.match(/\s*(?:\(\s*t\s*\)|\[\s*t\s*\])/y);
    if (/^\s*'/.test(this.text.slice(this.at))) throw new Unread("primes behind (t)");
  }

  /** Letters written without spaces, as in mgl; the longest that leave a readable rest. */
  split(word, dots) {
    const whole = word.replace(/_/g, "");
    const best = Array(whole.length + 1).fill(null);
    best[whole.length] = [];
    for (let first = whole.length - 1; first >= 0; first -= 1) {
      const farthest = Math.min(whole.length, first + this.letters.longest);
      for (let last = farthest; last > first && !best[first]; last -= 1) {
        const token = best[last] && this.meaning(whole, first, last, dots);
        if (token) best[first] = [token, ...best[last]];
      }
    }
    if (!best[0]) throw new Unread(`the letter ${word}${dots}`);
    this.tokens.push(...best[0]);
  }

  meaning(whole, first, last, dots) {
    const piece = whole.slice(first, last);
    const ends = last === whole.length;
    const name = this.letters.find(piece + (ends ? dots : ""));
    if (name) return { kind: "NAME", value: name };
    const called = SPELLINGS[piece] ?? piece;
    const isCall = FUNCTIONS.has(called) && piece.length > 2 && !ends;
    return isCall ? { kind: "FUNCTION", value: called } : null;
  }
}

/** Reads tokens by the package's grammar. */
class Parser {
  constructor(tokens, letters) {
    this.tokens = tokens;
    this.letters = letters;
    this.at = 0;
    this.depth = 0;
  }

  get kind() {
    return this.tokens[this.at]?.kind;
  }

  take(kind) {
    if (this.kind !== kind) throw new Unread(`${this.tokens[this.at]?.value ?? "the end"}`);
    return this.tokens[this.at++].value;
  }

  sum() {
    this.depth += 1;
    if (this.depth > MOST_DEPTH) throw new Unread("brackets nested so deep");
    let sign = "+";
    if (this.kind === "+" || this.kind === "-") sign = this.take(this.kind);
    const terms = [signed(this.product(), sign)];
    while (this.kind === "+" || this.kind === "-") {
      const next = this.take(this.kind);
      terms.push(signed(this.product(), next));
    }
    this.depth -= 1;
    return terms.length === 1 ? terms[0] : { op: "sum", parts: terms };
  }

  product() {
    let node = this.factor();
    for (;;) {
      if (this.kind === "*") {
        this.take("*");
        node = { op: "product", parts: [node, this.signed()] };
      } else if (this.kind === "/") {
        this.take("/");
        node = { op: "quotient", parts: [node, this.signed()] };
      } else if (["NUMBER", "NAME", "(", "FRACTION", "FUNCTION"].includes(this.kind))
        node = { op: "product", parts: [node, this.factor()] };
      else return node;
    }
  }

  signed() {
    if (this.kind !== "-" && this.kind !== "+") return this.factor();
    return signed(this.signedAfter(), "-");
  }

  signedAfter() {
    if (this.take(this.kind) === "+") throw new Unread("two signs");
    return this.signed();
  }

  factor() {
    const node = this.atom();
    return this.kind === "^" ? this.power(node) : node;
  }

  power(base) {
    this.take("^");
    return { op: "power", parts: [base, this.exponent()] };
  }

  exponent() {
    if (this.kind === "-") {
      this.take("-");
      return signed(this.exponent(), "-");
    }
    return this.factor();
  }

  atom() {
    switch (this.kind) {
      case "NUMBER":
        return { op: "number", value: Number(this.take("NUMBER")) };
      case "NAME":
        return { op: "letter", name: this.take("NAME") };
      case "(":
        return this.brackets();
      case "FRACTION":
        this.take("FRACTION");
        return { op: "quotient", parts: [this.brackets(), this.brackets()] };
      case "FUNCTION":
        return this.call();
      default:
        throw new Unread(`${this.tokens[this.at]?.value ?? "an end that comes too early"}`);
    }
  }

  brackets() {
    this.take("(");
    const inner = this.sum();
    this.take(")");
    return inner;
  }

  call() {
    const name = this.take("FUNCTION");
    let exponent = null;
    if (this.kind === "^") {
      this.take("^");
      exponent = this.kind === "NUMBER" || this.kind === "(" ? this.atom() : null;
      if (exponent?.op !== "number") throw new Unread("the power of a function");
    }
    const argument = this.argument();
    const call = write(name, argument);
    return exponent ? { op: "power", parts: [call, exponent] } : call;
  }

  /** An argument without brackets: numbers, then one letter, and t behind a rate. */
  argument() {
    if (this.kind === "(") return this.brackets();
    if (this.kind === "FRACTION") return this.atom();
    const parts = [];
    while (this.kind === "NUMBER") parts.push(this.atom());
    while (this.kind === "NAME") {
      const part = this.atom();
      parts.push(part);
      const moving = ["coordinate", "time", "velocity"].includes(this.letters.kinds[part.name]);
      if (moving || this.tokens[this.at]?.value !== "t") break;
    }
    if (!parts.length || this.kind === "^") throw new Unread("a function without brackets");
    return parts.reduce((all, part) => ({ op: "product", parts: [all, part] }));
  }
}

function signed(node, sign) {
  return sign === "-" ? { op: "negative", parts: [node] } : node;
}

function write(name, argument) {
  if (name !== "cot") return { op: "call", name, parts: [argument] };
  const [above, below] = ["cos", "sin"].map((other) => ({
    op: "call",
    name: other,
    parts: [argument],
  }));
  return { op: "quotient", parts: [above, below] };
}

/** Return the statements of a text, each a list of the sides of an equation. */
export function read(text, letters) {
  if (text.length > MOST_CHARACTERS) throw new Unread("a formula of this length");
  const tokens = new Scanner(text, letters).scan();
  const lines = [[]];
  let depth = 0;
  for (const token of tokens) {
    depth += (token.kind === "(") - (token.kind === ")");
    if (depth === 0 && ["\n", ";", ","].includes(token.kind)) lines.push([]);
    else if (token.kind !== "\n") lines[lines.length - 1].push(token);
  }
  const written = lines.filter((line) => line.length);
  if (!written.length) throw new Unread("an empty text");
  return written.map((line, k) => statement(line, written[k - 1], letters));
}

/** Whether a line that begins with a sign may continue the one before it. */
function goesOn(before, line) {
  const kinds = before.map((token) => token.kind);
  if (!kinds.includes("=")) return true;
  if (kinds.at(-2) === "=" && before.at(-1).value === "0") return false;
  return !line.some((token) => token.kind === "=");
}

function statement(line, before, letters) {
  const operators = ["+", "-", "*", "/", "^", "="];
  if (operators.includes(line[0].kind) && !"+-".includes(line[0].kind))
    throw new Unread("a line that goes on");
  if (operators.includes(line.at(-1).kind)) throw new Unread("a line that goes on");
  if (before && "+-".includes(line[0].kind) && goesOn(before, line))
    throw new Unread("a line that goes on");
  const parser = new Parser(line, letters);
  const sides = [parser.sum()];
  while (parser.kind === "=") {
    parser.take("=");
    sides.push(parser.sum());
  }
  if (parser.at < line.length) throw new Unread(`${line[parser.at].value}`);
  return sides;
}
