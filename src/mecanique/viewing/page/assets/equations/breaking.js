// Equations wider than the panel are broken before +, − and =, and joined again where there is room.

const BREAKS = new Set(["+", "−", "="]);
const CONTINUATION_INDENT = 1.5; // of later lines [em]

// How many pieces stand in each line; a piece that is wider than a line has one to itself.
export function fillLines(widths, room, indent) {
  const lines = [];
  let left = -1;
  for (const width of widths) {
    if (width <= left) {
      lines[lines.length - 1]++;
      left -= width;
    } else {
      left = room - width - (lines.length ? indent : 0);
      lines.push(1);
    }
  }
  return lines;
}

const isBreak = (element) => element.localName === "mo" && BREAKS.has(element.textContent.trim());

const isSum = (element) =>
  element.localName === "mrow" &&
  (element.childElementCount === 1
    ? isSum(element.firstElementChild)
    : [...element.children].some(isBreak));

// The terms of an equation, each with the sign before it; what stands in parentheses stays whole.
function piecesOf(row) {
  const pieces = [[]];
  for (const child of row.children) {
    if (isBreak(child) && pieces.at(-1).length) pieces.push([]);
    if (!isSum(child)) {
      pieces.at(-1).push(child);
      continue;
    }
    const [first, ...later] = piecesOf(child);
    pieces.at(-1).push(...first);
    pieces.push(...later);
  }
  return pieces;
}

const isApplied = (element) =>
  [...element.children].some((each) => each.textContent.trim() === "\u2061");

function termsIn(part) {
  if (part.localName !== "mrow" || isApplied(part)) return [[part]];
  return isSum(part) ? piecesOf(part) : openUp(part.children);
}

// The terms in the outermost parentheses of a piece that is wider than a line.
function openUp(piece) {
  const pieces = [[]];
  for (const part of piece) {
    const [first, ...later] = termsIn(part);
    pieces.at(-1).push(...first);
    pieces.push(...later);
  }
  return pieces;
}

// A zero alone would be a poor last line.
function keepZero(pieces) {
  const text = pieces.at(-1).map((part) => part.textContent.trim());
  if (pieces.length > 1 && text.join("") === "=0") pieces.at(-2).push(...pieces.pop());
  return pieces;
}

const unbroken = new WeakMap(); // what each <math> held before it was broken

export function wholeOf(math) {
  const copy = math.cloneNode(!unbroken.has(math));
  for (const node of unbroken.get(math) ?? []) copy.append(node.cloneNode(true));
  return copy;
}

function rejoin(math) {
  if (unbroken.has(math)) math.replaceChildren(...unbroken.get(math));
  unbroken.delete(math);
}

function widthsOf(pieces, math) {
  const edges = ([first]) => first.getBoundingClientRect().left;
  const starts = [...pieces.map(edges), math.getBoundingClientRect().right];
  return pieces.map((_, i) => starts[i + 1] - starts[i]);
}

function measureTerms(math) {
  const style = getComputedStyle(math.parentElement);
  const padding = parseFloat(style.paddingLeft) + parseFloat(style.paddingRight);
  const indent = CONTINUATION_INDENT * parseFloat(getComputedStyle(math).fontSize);
  const room = math.parentElement.clientWidth - padding;
  const whole = keepZero(piecesOf(math));
  const wide = widthsOf(whole, math);
  const pieces = whole.flatMap((piece, i) => (wide[i] > room - indent ? openUp(piece) : [piece]));
  return { math, pieces, widths: widthsOf(pieces, math), room, indent };
}

const mathElement = (name, ...children) => {
  const made = document.createElementNS("http://www.w3.org/1998/Math/MathML", name);
  made.append(...children);
  return made;
};

function breakUp({ math, pieces, widths, room, indent }) {
  const lines = fillLines(widths, room, indent);
  if (lines.length < 2) return;
  unbroken.set(math, [...math.childNodes]);
  let next = 0;
  const rows = lines.map((count) => {
    const row = mathElement("mrow");
    for (const part of pieces.slice(next, (next += count)).flat()) {
      const copy = part.cloneNode(true);
      // an operator that begins a row would be set as a sign
      if (isBreak(part)) copy.setAttribute("form", "infix");
      row.append(copy);
    }
    return mathElement("mtr", mathElement("mtd", row));
  });
  const table = mathElement("mtable", ...rows);
  table.setAttribute("class", "broken");
  math.replaceChildren(table);
}

function fitAll(equations) {
  const maths = equations.flatMap((each) => [...each.querySelectorAll(":scope > math")]);
  maths.forEach(rejoin);
  maths.map(measureTerms).forEach(breakUp);
}

// Panels may be written anew and derivations unfold, so each equation is fitted when it is seen.
export function wireBreaking(panel) {
  if (!panel) return;
  const fitted = new WeakMap();
  const sizes = new ResizeObserver((entries) => {
    const changed = entries.filter(({ target, contentRect: { width } }) => {
      const known = fitted.get(target);
      fitted.set(target, width);
      return width && width !== known;
    });
    fitAll(changed.map(({ target }) => target));
  });
  const watch = () => panel.querySelectorAll(".equation").forEach((each) => sizes.observe(each));
  new MutationObserver(watch).observe(panel, { childList: true });
  watch();
}
