// Elements of the page, with what they are and what they hold.

export function make(tag, properties = {}, ...inside) {
  const element = Object.assign(document.createElement(tag), properties);
  element.append(...inside);
  return element;
}

// A small area in the color of a curve or of a force.
export function swatch(color) {
  const area = make("i");
  area.style.backgroundColor = color;
  return area;
}
