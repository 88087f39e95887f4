// What a stream has shown so far, in the form plots read.

// About a minute of a stream [frames].
const MOST = 3600;

export class History {
  constructor(width) {
    this.width = width;
    this.clear();
  }

  clear() {
    this.times = [];
    this.rows = [];
  }

  add(t, row) {
    if (this.times.length && t <= this.times[this.times.length - 1]) this.clear();
    this.times.push(t);
    this.rows.push(Float32Array.from(row));
    if (this.times.length > MOST) {
      this.times.splice(0, MOST / 4);
      this.rows.splice(0, MOST / 4);
    }
  }

  // The row of the instant next before a time.
  at(t) {
    return this.rows[Math.floor(this.index(t))];
  }

  get n() {
    return this.times.length;
  }

  get first() {
    return this.times[0] ?? 0;
  }

  get last() {
    return this.times[this.n - 1] ?? 0;
  }

  time(k) {
    return this.times[k];
  }

  value(k, j) {
    return this.rows[k][j];
  }

  index(t) {
    let [low, high] = [0, this.n - 1];
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (this.times[middle] <= t) low = middle;
      else high = middle;
    }
    const gap = this.times[high] - this.times[low];
    return gap > 0
      ? low + Math.min(1, Math.max(0, (t - this.times[low]) / gap))
      : Math.max(high, 0);
  }
}
