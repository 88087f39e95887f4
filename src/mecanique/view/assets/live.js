// The live view's side of the page: frames from the server, commands to it, and what has been seen so far.

const MOST = 3600;

// The last minute or so of a stream, in the form plots read.
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
    return gap > 0 ? low + Math.min(1, Math.max(0, (t - this.times[low]) / gap)) : Math.max(high, 0);
  }
}

export class LiveClock {
  constructor(scene, width) {
    this.history = new History(width);
    this.length = scene.length;
    this.seekable = false;
    this.speed = 1;
    this.playing = true;
    this.time = scene.first;
    this.scene = scene;
    this.row = null;
    this.connect();
  }

  get first() {
    return this.seekable ? this.scene.first : this.history.first;
  }

  get last() {
    return this.seekable ? this.scene.first + this.length : this.history.last;
  }

  connect() {
    const socket = (this.socket = new WebSocket(`ws://${location.host}${location.pathname}ws`));
    socket.binaryType = "arraybuffer";
    socket.onmessage = (message) => {
      if (typeof message.data === "string") this.told(JSON.parse(message.data));
      else this.framed(message.data);
    };
    socket.onopen = () => this.onlink?.(true);
    socket.onclose = () => {
      this.onlink?.(false);
      setTimeout(() => this.connect(), 1000);
    };
  }

  // A frame is four integers (kind, number, 0, 0), the time, and a row of the table; a command is meshcat's.
  framed(buffer) {
    const [kind, number] = new Uint32Array(buffer, 0, 2);
    if (kind === 2) {
      this.oncommand?.(new Uint8Array(buffer, 16));
      return;
    }
    this.time = new Float64Array(buffer, 16, 1)[0];
    this.row = new Float32Array(buffer, 24);
    this.number = number;
    this.fresh = true;
  }

  told(state) {
    if (state.scene !== this.scene.id) {
      location.reload();
      return;
    }
    this.playing = !state.paused;
    this.speed = state.speed;
    this.seekable = state.seekable;
    this.onstate?.(state);
  }

  send(message) {
    if (this.socket.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify(message));
  }

  play() {
    this.send({ do: "resume" });
  }

  pause() {
    this.send({ do: "pause" });
  }

  reset() {
    this.history.clear();
    this.send({ do: "reset" });
  }

  setSpeed(speed) {
    this.send({ do: "speed", value: speed });
  }

  seek(t) {
    if (this.seekable) this.send({ do: "seek", value: t });
  }

  step(frames) {
    this.pause();
    this.seek(this.time + frames / 60);
  }

  // Takes the newest frame, if one came since the last picture, and lets the server send another.
  tick() {
    if (!this.fresh) return false;
    this.fresh = false;
    this.history.add(this.time, this.row);
    this.send({ do: "ack", value: this.number });
    return true;
  }
}

// Sliders for parameters and initial values; the motion starts again with what they are set to.
export function wireSliders(clock) {
  for (const slider of document.querySelectorAll("input[data-name]")) {
    slider.disabled = false;
    slider.oninput = () => {
      slider.closest("tr").querySelector("output").textContent = Number(slider.value).toPrecision(4);
    };
    slider.onchange = () => clock.send({ do: slider.dataset.kind, name: slider.dataset.name, value: Number(slider.value) });
  }
}
