// A motion that the page has computed, as a table like that of a recorded one: a row an instant.

const ROWS_PER_SECOND = 60;
const LEAST_ROWS = 240;
const MOST_ROWS = 7200;

// The quaternion of a rotation matrix, row by row, by its largest component.
export function quaternionOf(m, at, out, to) {
  const [a, b, c, d, e, f, g, h, k] = m.subarray(at, at + 9);
  const squares = [1 + a - e - k, 1 - a + e - k, 1 - a - e + k, 1 + a + e + k];
  const most = squares.indexOf(Math.max(...squares));
  const parts = [
    [squares[0], b + d, c + g, h - f],
    [b + d, squares[1], f + h, c - g],
    [c + g, f + h, squares[2], d - b],
    [h - f, c - g, d - b, squares[3]],
  ][most];
  const size = Math.hypot(...parts);
  for (let i = 0; i < 4; i++) out[to + i] = parts[i] / size;
}

export class Computed {
  // The rows go until the end of the path, or another time: what has ended before stays there.
  constructor(machine, setting, path, { layout, bodies, last = path.last }) {
    Object.assign(this, { machine, setting, path, layout, bodies });
    this.p = Float64Array.from(setting.p);
    this.first = path.first;
    this.last = last;
    const count = Math.round((this.last - this.first) * ROWS_PER_SECOND);
    this.n = path.steps ? Math.min(Math.max(count, LEAST_ROWS), MOST_ROWS - 1) + 1 : 1;
    this.dt = this.n > 1 ? (this.last - this.first) / (this.n - 1) : 0;
    this.state = new Float64Array(path.size);
    this.raw = new Float64Array(layout.end + 5 * bodies);
    this.rows = new Float64Array(this.n * layout.end);
    for (let k = 0; k < this.n; k++)
      this.row(this.time(k), bodies, this.rows.subarray(k * layout.end, (k + 1) * layout.end));
  }

  time(k) {
    return k === this.n - 1 ? this.last : this.first + k * this.dt;
  }

  index(t) {
    if (this.n < 2) return 0;
    return Math.min(this.n - 1, Math.max(0, (t - this.first) / this.dt));
  }

  value(k, j) {
    return this.rows[k * this.layout.end + j];
  }

  sample(most, bodies, width) {
    const count = Math.min(this.n, most);
    return Array.from({ length: count }, (_, i) => {
      const k = Math.round((i * (this.n - 1)) / Math.max(count - 1, 1));
      const at = k * this.layout.end;
      return this.rows.slice(at, at + width);
    });
  }

  stateAt(t) {
    return this.path.at(Math.min(t, this.path.last), this.state);
  }

  // The whole row at a time: not between key frames, but of the state itself.
  row(t, bodies, out) {
    return this.fill(t, this.stateAt(t), out);
  }

  // By the modes of a path, where there are any.
  fill(t, state, out, corners = this.path.corners) {
    const { raw, machine, bodies } = this;
    corners?.press(t, state, this.p);
    machine.program.row(t, state, this.p, raw, null);
    for (let b = 0; b < bodies; b++) {
      for (let i = 0; i < 3; i++) out[7 * b + i] = raw[12 * b + i];
      quaternionOf(raw, 12 * b + 3, out, 7 * b + 3);
    }
    out.set(raw.subarray(12 * bodies), 7 * bodies);
    for (const j of machine.engine.unknown) out[j] = NaN;
    return out;
  }
}
