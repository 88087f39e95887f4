// The scales of plots: which range a curve is drawn in, and what is written along it.

const SUPERSCRIPTS = {
  "-": "⁻",
  0: "⁰",
  1: "¹",
  2: "²",
  3: "³",
  4: "⁴",
  5: "⁵",
  6: "⁶",
  7: "⁷",
  8: "⁸",
  9: "⁹",
};

export function powerOfTen(exponent) {
  return `10${[...String(exponent)].map((digit) => SUPERSCRIPTS[digit]).join("")}`;
}

// Rows arrive in single precision and are rounded before: so much of a value is undetermined.
const ROUNDING = 1e-5;
// What is smaller than this part of the largest quantity of its unit counts as zero.
const NOTHING = 1e-9;

export function isNothing(x, scale = 0) {
  return Math.abs(x) <= NOTHING * scale;
}

// The range to draw values from low to high in; what varies by rounding alone is a flat line.
export function rangeOf(low, high, scale) {
  if (!(low <= high)) return [-1, 1];
  const size = Math.max(Math.abs(low), Math.abs(high));
  if (isNothing(size, scale)) return [-1, 1];
  if (high - low <= Math.max(ROUNDING * size, NOTHING * scale)) {
    const middle = (low + high) / 2;
    return [middle - 0.1 * Math.abs(middle), middle + 0.1 * Math.abs(middle)];
  }
  const pad = 0.06 * (high - low);
  return [low - pad, high + pad];
}

// Round numbers from low to high, at most so many, and the power of ten they are all written by.
export function ticks(low, high, count) {
  const rough = (high - low) / Math.max(count, 1);
  const unit = 10 ** Math.floor(Math.log10(rough));
  const step = unit * [1, 2, 5, 10].find((m) => m * unit >= rough * (1 - 1e-9));
  const big = Math.max(Math.abs(low), Math.abs(high));
  const power = big >= 1e5 || big < 1e-2 ? Math.floor(Math.log10(big) + 1e-9) : 0;
  const factor = 10 ** power;
  const digits = Math.min(12, Math.max(0, -Math.floor(Math.log10(step / factor) + 1e-9)));
  const marks = [];
  for (let i = Math.ceil(low / step - 1e-9); i * step <= high + 1e-9 * step; i++) {
    const text = ((i * step) / factor).toFixed(digits).replace("-", "−");
    marks.push({ x: i * step, text: i === 0 ? "0" : text });
  }
  return { marks, power: power ? `×${powerOfTen(power)}` : "" };
}

// Ticks along a width in pixels, so few that what is written at them does not overlap.
export function ticksAlong(low, high, width) {
  for (let count = Math.max(2, Math.floor(width / 60)); ; count--) {
    const found = ticks(low, high, count);
    const longest = Math.max(0, ...found.marks.map(({ text }) => text.length));
    if (count <= 1 || found.marks.length * (6.5 * longest + 26) <= width) return found;
  }
}
