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
