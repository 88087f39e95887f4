// From the packed bytes back to numbers: variable-length integers, sums of differences, poses at
// any time.

export function bytesOf(id) {
  const text = atob(document.getElementById(id).textContent.trim());
  const bytes = new Uint8Array(text.length);
  for (let k = 0; k < bytes.length; k++) bytes[k] = text.charCodeAt(k);
  return bytes;
}

// What stands compressed in the page under a name.
export const unpack = (id) => gunzip(bytesOf(id));

export async function gunzip(bytes) {
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

// [length of the JSON header][header][binary parts one after another; lengths in header.parts]
export function openParcel(bytes) {
  const view = new DataView(bytes.buffer, bytes.byteOffset);
  const size = view.getUint32(0, true);
  const header = JSON.parse(new TextDecoder().decode(bytes.subarray(4, 4 + size)));
  let at = 4 + size;
  const parts = header.parts.map((length) => bytes.subarray(at, (at += length)));
  return { header, parts };
}

// Where each thing stands in a row of the table: bodies, arrows, lines, traces, series.
export function layoutOf(scene) {
  const bodies = 0;
  const arrows = bodies + 7 * scene.bodies.length;
  const lines = arrows + 6 * scene.arrows.length;
  const traces = lines + 6 * scene.lines.length;
  const series = traces + 3 * scene.traces.length;
  const ledger = series + scene.series.length;
  const end = ledger + scene.ledger.rows.length * scene.ledger.coordinates.length;
  return { bodies, arrows, lines, traces, series, ledger, end };
}

export function readIntegers(bytes, start, count, out) {
  let at = start;
  for (let i = 0; i < count; i++) {
    let value = 0;
    let factor = 1;
    let byte;
    do {
      byte = bytes[at++];
      value += (byte & 0x7f) * factor;
      factor *= 128;
    } while (byte & 0x80);
    out[i] = value % 2 ? -(value + 1) / 2 : value / 2;
  }
  return at;
}

export function turn(q, v) {
  const [x, y, z, w] = q;
  const a = y * v[2] - z * v[1];
  const b = z * v[0] - x * v[2];
  const c = x * v[1] - y * v[0];
  return [
    v[0] + 2 * (w * a + y * c - z * b),
    v[1] + 2 * (w * b + z * a - x * c),
    v[2] + 2 * (w * c + x * b - y * a),
  ];
}

// The scene as a table: one row an instant, one column a number that may change.
export class Table {
  constructor(packed, bytes) {
    this.n = packed.n;
    this.first = packed.first;
    this.dt = packed.dt;
    this.last = packed.first + packed.dt * (packed.n - 1);
    this.anchors = packed.anchors;
    this.start = packed.start;
    let at = 0;
    this.columns = packed.orders.map((order, j) => {
      if (order < 0) return null;
      const column = new Float64Array(this.n);
      at = readIntegers(bytes, at, this.n, column);
      for (let pass = 0; pass < order; pass++)
        for (let k = 1; k < this.n; k++) column[k] += column[k - 1];
      for (let k = 0; k < this.n; k++) column[k] *= packed.steps[j];
      return column;
    });
  }

  time(k) {
    return this.first + k * this.dt;
  }

  index(t) {
    if (this.n < 2) return 0;
    return Math.min(this.n - 1, Math.max(0, (t - this.first) / this.dt));
  }

  value(k, j) {
    return this.columns[j] ? this.columns[j][k] : this.start[j];
  }

  // So many rows at most, evenly spread over the motion, each as far as its first numbers.
  sample(most, bodies, width) {
    const count = Math.min(this.n, most);
    return Array.from({ length: count }, (_, i) => {
      const t = this.first + ((this.last - this.first) * i) / Math.max(count - 1, 1);
      return this.row(t, bodies, new Float64Array(width));
    });
  }

  // A whole row at time t, straight between key frames; quaternions are made unit again.
  row(t, bodies, out) {
    const x = this.index(t);
    const k = Math.min(Math.floor(x), Math.max(0, this.n - 2));
    const f = this.n < 2 ? 0 : x - k;
    for (let j = 0; j < out.length; j++) {
      const column = this.columns[j];
      out[j] = column ? (f ? column[k] * (1 - f) + column[k + 1] * f : column[k]) : this.start[j];
    }
    for (let b = 0; b < bodies; b++) {
      const o = 7 * b + 3;
      const size = Math.hypot(out[o], out[o + 1], out[o + 2], out[o + 3]);
      for (let i = 0; i < 4; i++) out[o + i] /= size;
    }
    for (const [first, b, ...local] of this.anchors) {
      const place = turn(out.subarray(7 * b + 3, 7 * b + 7), local);
      for (let i = 0; i < 3; i++) out[first + i] = out[7 * b + i] + place[i];
    }
    return out;
  }
}
