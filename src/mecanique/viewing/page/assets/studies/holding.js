// Where what rolls would pull or slip, and a cord would push: from there on no real mechanism moves as
// the equations say.

import { bisect } from "../engine/dop853.js";
import { measure } from "../data/numbers.js";

// What ceases to hold along a computed motion, and when: { name, t } of the first time of each.
export function findBreaks(computed) {
  const { machine, p, n, first } = computed;
  const { holding } = machine.engine;
  if (!holding.length) return [];
  const out = new Float64Array(holding.length);
  const left = (t) => {
    machine.program.margins(t, computed.stateAt(t), p, out);
    return out.slice();
  };
  let before = left(first);
  const found = holding.map((name, k) => (before[k] < 0 ? { name, t: first } : null));
  for (let i = 1; i < n; i++) {
    const now = left(computed.time(i));
    holding.forEach((name, k) => {
      if (found[k] || !(before[k] > 0 && now[k] <= 0)) return;
      const t = bisect((time) => left(time)[k], computed.time(i - 1), computed.time(i));
      found[k] = { name, t };
    });
    before = now;
  }
  return found.filter(Boolean);
}

// In words, from when on a motion is none of a real mechanism, and why.
export function describeBreaks(breaks) {
  if (!breaks.length) return "";
  const { name, t } = breaks.reduce((a, b) => (b.t < a.t ? b : a));
  return `From t = ${measure(t)} s on no real mechanism moves like this: ${name}.`;
}
