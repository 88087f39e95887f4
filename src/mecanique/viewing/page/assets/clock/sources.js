// Where the present row comes from: a motion recorded whole, or a stream shown as it arrives.

// A stream's plots are drawn anew at most so often [ms].
const PLOT_PERIOD = 120;

export class Recording {
  constructor(table, clock, picture, plots) {
    Object.assign(this, { clock, picture, plots });
    this.take(table);
  }

  // Shows another motion from now on.
  take(table) {
    this.table = table;
    this.shown = null;
    const { picture } = this;
    picture.traces.clear();
    picture.ghost.show(Boolean(table.other));
    if (!picture.scene.traces.length) return;
    const row = new Float64Array(picture.row.length);
    for (let k = 0; k < table.n; k++)
      picture.traces.add(table.row(table.time(k), this.bodies, row));
  }

  get bodies() {
    return this.picture.scene.bodies.length;
  }

  // How many points of a trace have been passed.
  get reached() {
    return Math.floor(this.table.index(this.clock.time) + 1e-6) + 1;
  }

  // Take the row of the clock's time; say whether it is another than before.
  advance(now) {
    this.clock.tick(now);
    if (this.clock.time === this.shown) return false;
    const { table, picture } = this;
    table.row(this.clock.time, this.bodies, picture.row);
    table.other?.row(this.clock.time, this.bodies, picture.ghost.row);
    this.shown = this.clock.time;
    return true;
  }

  plot() {
    this.plots.follow();
  }
}

export class Stream {
  constructor(clock, picture, plots) {
    Object.assign(this, { clock, picture, plots });
    this.shown = null;
    this.drawn = 0;
    this.behind = false;
  }

  get reached() {
    return Infinity;
  }

  // Take the newest frame, if one came since the last picture, or one of the past; time that goes
  // back is a new start.
  advance() {
    if (!this.clock.tick()) return false;
    const { picture, clock } = this;
    picture.row.set(clock.row);
    this.shown = clock.time;
    if (clock.past) return true;
    if (clock.time < this.newest) picture.restart();
    this.newest = clock.time;
    picture.arrows.learn(picture.row);
    for (const points of clock.passed) picture.traces.pass(points);
    picture.traces.add(picture.row);
    this.behind = true;
    return true;
  }

  plot(now) {
    if (!this.behind || now - this.drawn <= PLOT_PERIOD) return;
    this.drawn = now;
    this.behind = false;
    this.plots.refresh();
  }
}
