// Displacements from a position of rest, drawn larger than they are: structures move little.

const UNMOVED = 1e-12;

// q to the power of a factor: the turn about the same axis by a multiple of the angle.
function stretchTurn(q, factor) {
  const size = Math.hypot(q[0], q[1], q[2]);
  if (size < UNMOVED) return [0, 0, 0, 1];
  const angle = Math.atan2(size, q[3]) * factor;
  const part = Math.sin(angle) / size;
  return [q[0] * part, q[1] * part, q[2] * part, Math.cos(angle)];
}

function times([a, b, c, d], [x, y, z, w]) {
  return [
    d * x + a * w + b * z - c * y,
    d * y - a * z + b * w + c * x,
    d * z + a * y - b * x + c * w,
    d * w - a * x - b * y - c * z,
  ];
}

// Writes a row with displacements from another multiplied: of bodies, places of arrows, ends of lines.
export function exaggerate(row, rest, factor, layout, out) {
  out.set(row);
  const move = (from, to) => {
    for (let j = from; j < to; j++) out[j] = rest[j] + factor * (row[j] - rest[j]);
  };
  for (let o = layout.bodies; o < layout.arrows; o += 7) {
    move(o, o + 3);
    const [x, y, z, w] = rest.subarray(o + 3, o + 7);
    const now = [...row.subarray(o + 3, o + 7)];
    let turn = times(now, [-x, -y, -z, w]);
    if (turn[3] < 0) turn = turn.map((c) => -c);
    const turned = times(stretchTurn(turn, factor), [x, y, z, w]);
    for (let i = 0; i < 4; i++) out[o + 3 + i] = turned[i];
  }
  for (let o = layout.arrows; o < layout.lines; o += 6) move(o, o + 3);
  move(layout.lines, layout.series);
  return out;
}
