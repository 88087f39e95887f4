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

export function drawPhase(plots, over, members, width) {
  const data = plots.section ?? plots.data;
  const places = plots.section ? [...Array(data.n).keys()] : placesIn(data, plots.span());
  const values = (each) => places.map((k) => each.value(data, k));
  const xs = values(over);
  const paths = members.map(values);
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
  const x = axis(xs, over.unit, [MARGIN.left, width - MARGIN.right]);
  const y = axis(paths.flat(), members[0].unit, [PHASE_HEIGHT - MARGIN.bottom, MARGIN.top]);
  const names = members.map((each) => each.text).join(", ");
  const where = plots.section ? `, a section of ${data.n} points` : "";
  const label = `${names} over ${over.text}${where}`;
  const attributes = { viewBox: `0 0 ${width} ${PHASE_HEIGHT}`, role: "img", "aria-label": label };
  const picture = svg("svg", attributes);
  drawAxes(picture, x, y, over.unit ? `${over.text} [${over.unit}]` : over.text);
  paths.forEach((path, i) => {
    const found = path
      .map((v, k) => [x.at(xs[k]), y.at(v)])
      .filter((point) => point.every(Number.isFinite));
    const { color, dash } = members[i];
    if (plots.section) {
      for (const [cx, cy] of found) svg("circle", { cx, cy, r: 1.6, fill: color }, picture);
      return;
    }
    const points = found.map((point) => point.map((v) => v.toFixed(1)).join(","));
    const curve = { class: "curve", points: points.join(" "), stroke: color };
    svg("polyline", { ...curve, "stroke-dasharray": dash }, picture);
  });
  const dots = members.map(({ color }) =>
    svg("circle", { class: "dot", r: 4, fill: color }, picture),
  );
  const move = (t) =>
    dots.forEach((dot, i) => {
      const place = [x.at(plots.at(over, t)), y.at(plots.at(members[i], t))];
      dot.style.display = place.every(Number.isFinite) && !plots.section ? "" : "none";
      dot.setAttribute("cx", place[0]);
      dot.setAttribute("cy", place[1]);
    });
  return { picture, move };
}
