// Plots as SVG: their elements, their axes, and all of them in one file.

import { ticks, ticksAlong } from "../data/scales.js";

const SVG = "http://www.w3.org/2000/svg";
export const MARGIN = { left: 52, right: 10, top: 8, bottom: 24 };

export function svg(tag, attributes, parent) {
  const element = document.createElementNS(SVG, tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  parent?.append(element);
  return element;
}

function write(text, attributes, picture) {
  svg("text", attributes, picture).textContent = text;
}

// Lines and numbers along both axes; ranges and scales are { from, to, at } of x and of y.
export function drawAxes(picture, x, y, title) {
  const { width, height } = picture.viewBox.baseVal;
  const [right, bottom] = [width - MARGIN.right, height - MARGIN.bottom];
  const { marks, power } = ticks(y.from, y.to, Math.round(height / 42));
  for (const mark of marks) {
    const place = y.at(mark.x);
    svg("line", { class: "rule", x1: MARGIN.left, x2: right, y1: place, y2: place }, picture);
    write(mark.text, { x: MARGIN.left - 6, y: place + 3.5, "text-anchor": "end" }, picture);
  }
  if (power) write(power, { class: "unit", x: MARGIN.left + 4, y: MARGIN.top + 9 }, picture);
  const along = ticksAlong(x.from, x.to, right - MARGIN.left);
  const room = 7 * (title.length + along.power.length) + 12;
  for (const mark of along.marks) {
    const place = x.at(mark.x);
    svg("line", { class: "rule", x1: place, x2: place, y1: MARGIN.top, y2: bottom }, picture);
    if (place < right - room)
      write(mark.text, { x: place, y: bottom + 15, "text-anchor": "middle" }, picture);
  }
  const words = `${along.power} ${title}`.trim();
  write(words, { class: "unit", x: right, y: bottom + 15, "text-anchor": "end" }, picture);
}

const STYLE =
  "text{font:11px sans-serif;fill:#444}.rule{stroke:#ddd}.curve{fill:none;stroke-width:1.5}" +
  ".cursor{stroke:#000}.dot{stroke:#fff}.ring{stroke-width:1.5}";

// All plots as the text of one file, each below its legend.
export function stack(charts) {
  const whole = svg("svg", { xmlns: SVG });
  svg("style", {}, whole).textContent = STYLE;
  let [top, wide] = [0, 0];
  for (const { picture, members } of charts) {
    const { width, height } = picture.viewBox.baseVal;
    let left = MARGIN.left;
    for (const { text, unit, color } of members) {
      const words = unit ? `${text} [${unit}]` : text;
      svg("rect", { x: left, y: top + 8, width: 12, height: 3, fill: color }, whole);
      write(words, { x: left + 16, y: top + 14 }, whole);
      left += 7 * words.length + 34;
    }
    const group = svg("g", { transform: `translate(0 ${top + 18})` }, whole);
    for (const part of picture.children) group.append(part.cloneNode(true));
    top += height + 24;
    wide = Math.max(wide, width);
  }
  whole.setAttribute("viewBox", `0 0 ${wide} ${top}`);
  return new XMLSerializer().serializeToString(whole);
}
