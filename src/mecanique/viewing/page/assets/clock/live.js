// The clock of a live view: frames from the server, and what the page asks of it.

import { History } from "./history.js";
import { Link } from "./link.js";

export class LiveClock extends Link {
  constructor(scene, width) {
    super(scene.id);
    this.history = new History(width);
    this.width = width;
    this.chosen = null; // a time of the recent past that is looked at
    this.speed = 1;
    this.playing = true;
    this.time = scene.first;
    this.row = null;
    this.number = 0;
    this.newest = null;
  }

  get first() {
    return this.history.first;
  }

  get last() {
    return this.history.last;
  }

  get seekable() {
    return this.history.n > 1;
  }

  // How much of time a plot shows at least: a stream has just begun, and goes on [s].
  get room() {
    return 2 * Math.min(this.speed, 1);
  }

  // A frame is its number, how many numbers come last, the time, a row of the table, and the places
  // that the traces passed since the frame before.
  receive(buffer) {
    const [number] = new Uint32Array(buffer, 0, 1);
    const [time] = new Float64Array(buffer, 8, 1);
    const passed = [...(this.newest?.passed ?? []), new Float32Array(buffer, 16 + 4 * this.width)];
    this.newest = { time, row: new Float32Array(buffer, 16, this.width), number, passed };
  }

  play() {
    this.chosen = null;
    this.send({ do: "resume" });
  }

  pause() {
    this.send({ do: "pause" });
  }

  reset() {
    this.chosen = null;
    this.history.clear();
    this.send({ do: "reset" });
  }

  setSpeed(speed) {
    this.send({ do: "speed", value: speed });
  }

  // Looks back at the recent past; playing returns to the present.
  seek(t) {
    if (this.seekable) this.chosen = Math.min(this.last, Math.max(this.first, t));
  }

  step(frames) {
    this.pause();
    const { history } = this;
    const k = Math.round(history.index(this.time)) + frames;
    if (this.seekable) this.chosen = history.time(Math.min(history.n - 1, Math.max(0, k)));
  }

  // Takes the newest frame, if one came since the last picture, and lets the server send another.
  // Until then the time stays that of the picture.
  tick() {
    const fresh = this.newest;
    this.past = this.chosen !== null;
    this.passed = fresh?.passed ?? [];
    if (fresh) {
      this.newest = null;
      this.history.add(fresh.time, fresh.row);
      this.send({ do: "ack", value: fresh.number });
    }
    if (!this.past) {
      if (fresh) Object.assign(this, { time: fresh.time, row: fresh.row, number: fresh.number });
      return Boolean(fresh);
    }
    const moved = this.time !== this.chosen;
    this.time = this.chosen;
    this.row = this.history.at(this.time);
    return moved;
  }
}
