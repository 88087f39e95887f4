// Numbers as they are written on the page.

import { powerOfTen } from "./scales.js";

export function measure(x, digits = 4) {
  if (Number.isNaN(x)) return "–";
  if (!x) return "0";
  const size = Math.abs(x);
  const text = size >= 1e5 || size < 1e-3 ? x.toExponential(digits - 2) : x.toPrecision(digits);
  return text
    .replaceAll("-", "−")
    .replace(/e\+?(.*)/, (_, exponent) => `·${powerOfTen(exponent.replace("−", "-"))}`);
}

// A number as Python's format "g" has it.
export function general(x) {
  if (Number.isNaN(x)) return "nan";
  if (!Number.isFinite(x)) return x < 0 ? "-inf" : "inf";
  if (!x) return "0";
  const [digits, power] = x.toExponential(5).split("e");
  const short = digits.includes(".") ? digits.replace(/\.?0+$/, "") : digits;
  if (power < -4 || power >= 6) return `${short}e${power[0]}${power.slice(1).padStart(2, "0")}`;
  return String(Number(x.toPrecision(6)));
}

// The number that a text states in decimals; the text itself if it states none.
export function numberOf(text) {
  return /^\s*[-+]?(\d+\.?\d*|\.\d+)(e[-+]?\d+)?\s*$/i.test(text) ? Number(text) : text;
}
