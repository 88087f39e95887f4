// Equations wider than the panel are broken before +, − and =, and joined again where there is room.

const BREAKS = new Set(["+", "−", "="]);
const CONTINUATION_INDENT = 1.5; // of later lines [em]
const MOST_SPARED = 60; // at the ends of lines [px]
const BOXES = ".equation, .note"; // what holds equations, alone or in a sentence

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

const leftOf = ([first]) => first.getBoundingClientRect().left;
const widthOf = (piece) => piece.at(-1).getBoundingClientRect().right - leftOf(piece);

// Widths of pieces that follow one another, each with the space after it.
const widthsOf = (pieces) =>
  pieces.map((piece, k) => {
    const next = pieces[k + 1];
    return next ? leftOf(next) - leftOf(piece) : widthOf(piece);
  });

// A piece in parts that are no wider than there is room, as far as parentheses can be opened.
function narrow(piece, room) {
  const pieces = widthOf(piece) > room ? openUp(piece) : [piece];
  return pieces.length < 2 ? [piece] : pieces.flatMap((each) => narrow(each, room));
}

function measureTerms(math, spared = 0) {
  const box = math.closest(BOXES);
  const style = getComputedStyle(box);
  const padding = parseFloat(style.paddingLeft) + parseFloat(style.paddingRight);
  const indent = CONTINUATION_INDENT * parseFloat(getComputedStyle(math).fontSize);
  const room = box.clientWidth - padding - spared;
  const pieces = keepZero(piecesOf(math)).flatMap((piece) => narrow(piece, room - indent));
  return { math, pieces, room, indent };
}

const mathElement = (name, ...children) => {
  const made = document.createElementNS("http://www.w3.org/1998/Math/MathML", name);
  made.append(...children);
  return made;
};

function breakUp({ math, pieces, room, indent }) {
  const lines = linesOf(pieces, room, indent);
  if (!lines) return;
  unbroken.set(math, [...math.childNodes]);
  // fractions are as large as in an equation in one line
  lines.setAttribute("displaystyle", String(math.getAttribute("display") === "block"));
  math.replaceChildren(lines);
}

// A table of a line each, of pieces that are wider than one; null if they are not.
function linesOf(pieces, room, indent) {
  const widths = widthsOf(pieces);
  const lines = fillLines(widths, room, indent);
  if (lines.length < 2 && widths[0] <= room) return null;
  let next = 0;
  const rows = lines.map((count, k) => {
    const line = pieces.slice(next, (next += count));
    const least = room - (k ? indent : 0);
    const row = mathElement("mrow", ...line.flatMap((piece) => fit(piece, least, indent)));
    return mathElement("mtr", mathElement("mtd", row));
  });
  const table = mathElement("mtable", ...rows);
  table.setAttribute("class", "broken");
  return table;
}

// Copies of parts of an equation; of a fraction wider than there is room, with broken lines in it.
function fit(parts, room, indent) {
  const spare = room - widthOf(parts);
  return parts.map((part) => {
    const copy = part.cloneNode(true);
    // an operator that begins a row would be set as a sign
    if (isBreak(part)) copy.setAttribute("form", "infix");
    const within = widthOf([part]) + spare;
    if (spare >= 0 || within <= 0 || !part.childElementCount) return copy;
    if (part.localName === "mfrac")
      [...part.children].forEach((side, k) => {
        const pieces = openUp([side]).flatMap((piece) => narrow(piece, within - indent));
        const table = linesOf(pieces, within, indent);
        if (table) copy.children[k].replaceWith(table);
      });
    else if (part.localName === "mrow")
      copy.replaceChildren(...fit([...part.children], within, indent));
    return copy;
  });
}

function fitAll(equations) {
  const maths = equations.flatMap((each) => [...each.querySelectorAll("math")]);
  maths.forEach(rejoin);
  maths.map((math) => measureTerms(math)).forEach(breakUp);
  for (const box of equations) giveWay(box);
}

// Where lines came out a little wider than their pieces, by spaces around signs, breaks them once more.
function giveWay(box) {
  const over = () => box.scrollWidth - box.clientWidth;
  for (let spared = over(); over() > 0 && spared < MOST_SPARED; spared += over())
    for (const math of box.querySelectorAll("math")) {
      rejoin(math);
      breakUp(measureTerms(math, spared));
    }
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
  const watch = () => panel.querySelectorAll(BOXES).forEach((each) => sizes.observe(each));
  new MutationObserver(watch).observe(panel, { childList: true });
  watch();
}
