// One quantity over another: phase portraits, reactions over angles.

import { rangeOf } from "../data/scales.js";
import { MARGIN, drawAxes, svg } from "./drawing.js";

const PHASE_HEIGHT = 270;
// A curve goes through so many points at most.
const MOST_DRAWN = 3000;

// The rows between two times, not too many.
function placesIn(data, [a, b]) {
  const from = Math.max(0, Math.floor(data.index(a)));
  const to = Math.min(data.n - 1, Math.ceil(data.index(b)));
  const every = Math.max(1, Math.ceil((to - from) / MOST_DRAWN));
  const places = [];
  for (let k = from; k <= to; k += every) places.push(k);
  return places;
}

// The angle in (−π, π] that points where an angle does.
export function fold(angle) {
  const turn = 2 * Math.PI;
  return angle - turn * Math.ceil(angle / turn - 0.5);
}

// Points of the picture, in pieces: a gap where nothing is known, and where a folded angle jumps.
function cut(points, widest) {
  const pieces = [[]];
  let before = null;
  for (const point of points) {
    const known = point.every(Number.isFinite);
    const jumps = before && Math.abs(point[0] - before[0]) > widest;
    if (!known || jumps) pieces.push([]);
    if (known) pieces.at(-1).push(point);
    before = known ? point : null;
  }
  return pieces.filter((piece) => piece.length);
}

// The motions to draw: the states of a section, else the motion and the one beside it.
const motionsOf = ({ section, data }) =>
  [section ?? data, section ? null : data.other].filter(Boolean);

export function drawPhase(plots, over, members, width) {
  const folded = plots.folds(over);
  const across = (value) => (folded ? fold(value) : value);
  const curves = motionsOf(plots).flatMap((data, second) => {
    const places = plots.section ? [...Array(data.n).keys()] : placesIn(data, plots.span());
    const xs = places.map((k) => across(over.value(data, k)));
    return members.map((member) => {
      const ys = places.map((k) => member.value(data, k));
      return { data, member, xs, ys, second: second > 0 };
    });
  });
  const axis = (all, unit, [begin, end]) => {
    const known = all.filter(Number.isFinite);
    const [low, high] = known.reduce(
      ([least, most], v) => [Math.min(least, v), Math.max(most, v)],
      [Infinity, -Infinity],
    );
    const [first, last] = rangeOf(low, high, plots.peaks.get(unit) ?? 0);
    const at = (v) => begin + ((v - first) / (last - first)) * (end - begin);
    return { from: first, to: last, at };
  };
  const sides = folded ? [-Math.PI, Math.PI] : curves.flatMap(({ xs }) => xs);
  const heights = curves.flatMap(({ ys }) => ys);
  const x = axis(sides, over.unit, [MARGIN.left, width - MARGIN.right]);
  const y = axis(heights, members[0].unit, [PHASE_HEIGHT - MARGIN.bottom, MARGIN.top]);
  const names = members.map((each) => each.text).join(", ");
  const beside = curves.some(({ second }) => second) ? ", with the second motion" : "";
  const where = plots.section ? `, a section of ${plots.section.n} points` : beside;
  const label = `${names} over ${over.text}${where}`;
  const attributes = { viewBox: `0 0 ${width} ${PHASE_HEIGHT}`, role: "img", "aria-label": label };
  const picture = svg("svg", attributes);
  drawAxes(picture, x, y, over.unit ? `${over.text} [${over.unit}]` : over.text);
  const drawPiece = plots.section ? drawPoints : drawCurve;
  const half = folded ? x.at(Math.PI) - x.at(0) : Infinity;
  for (const { member, xs, ys, second } of curves) {
    const pieces = cut(
      xs.map((value, k) => [x.at(value), y.at(ys[k])]),
      half,
    );
    for (const piece of pieces) drawPiece(picture, piece, member, second);
  }
  const dots = plots.section ? [] : curves;
  const marks = dots.map(({ member, second }) => {
    const paint = second ? { stroke: member.color, fill: "none" } : { fill: member.color };
    return svg("circle", { class: second ? "ring" : "dot", r: 4, ...paint }, picture);
  });
  const move = (t) =>
    dots.forEach(({ data, member }, i) => {
      const place = [x.at(across(plots.at(over, t, data))), y.at(plots.at(member, t, data))];
      const known = place.every(Number.isFinite);
      marks[i].style.display = known ? "" : "none";
      if (!known) return;
      marks[i].setAttribute("cx", place[0]);
      marks[i].setAttribute("cy", place[1]);
    });
  return { picture, move };
}

// A piece of a curve; that of a second motion is pale.
function drawCurve(picture, piece, { color, dash }, second) {
  const points = piece.map((point) => point.map((v) => v.toFixed(1)).join(",")).join(" ");
  const stroke = { stroke: color, "stroke-dasharray": dash, "stroke-opacity": second ? 0.45 : 1 };
  svg("polyline", { class: "curve", points, ...stroke }, picture);
}

function drawPoints(picture, piece, { color }) {
  for (const [cx, cy] of piece) svg("circle", { cx, cy, r: 1.6, fill: color }, picture);
}
