// The clock of a recorded motion, and the bar below the picture that drives it.

export class Player {
  constructor(table) {
    this.speed = 1;
    this.playing = false;
    this.looping = true;
    this.take(table);
  }

  // Plays another motion from its start.
  take(table) {
    this.table = table;
    this.time = table.first;
    this.first = table.first;
    this.last = table.last;
    this.seekable = table.n > 1;
    this.stamp = null;
  }

  play() {
    if (!this.seekable) return;
    if (this.time >= this.last) this.time = this.first;
    this.playing = true;
    this.stamp = null;
  }

  pause() {
    this.playing = false;
  }

  seek(t) {
    this.time = Math.min(this.last, Math.max(this.first, t));
  }

  setSpeed(speed) {
    this.speed = speed;
  }

  step(frames) {
    this.pause();
    this.seek(this.time + frames * (this.table.dt || 0));
  }

  reset() {
    this.seek(this.first);
  }

  // Called once a frame with the browser's clock in milliseconds.
  tick(now) {
    if (this.playing && this.stamp !== null) {
      const next = this.time + ((now - this.stamp) / 1000) * this.speed;
      if (next <= this.last) this.time = next;
      else if (this.looping)
        this.time = this.first + ((next - this.first) % (this.last - this.first));
      else {
        this.time = this.last;
        this.pause();
      }
    }
    this.stamp = now;
  }
}

export class Transport {
  constructor(clock) {
    this.clock = clock;
    this.digits = 2;
    this.find("play").onclick = () => this.toggle();
    this.find("reset").onclick = () => clock.reset();
    this.find("speed").onchange = (event) => clock.setSpeed(Number(event.target.value));
    this.find("loop").onchange = (event) => (clock.looping = event.target.checked);
    const slider = this.find("slider");
    slider.oninput = () => {
      clock.pause();
      clock.seek(Number(slider.value));
    };
    this.refit();
  }

  find(id) {
    return document.getElementById(id);
  }

  refit() {
    const slider = this.find("slider");
    slider.min = this.clock.first;
    slider.max = this.clock.last;
    slider.step = "any";
    slider.disabled = !this.clock.seekable;
    if (!this.clock.history) this.digits = this.clock.last - this.clock.first < 2 ? 3 : 2;
  }

  toggle() {
    if (this.clock.playing) this.clock.pause();
    else this.clock.play();
  }

  show() {
    const { time, playing, last, seekable } = this.clock;
    const text = time.toFixed(this.digits);
    if (this.clock.history) this.refit(); // a stream has no end yet
    if (this.shown === text && this.playing === playing) return;
    Object.assign(this, { shown: text, playing });
    const slider = this.find("slider");
    slider.value = time;
    slider.setAttribute("aria-valuetext", `${text} seconds`);
    this.find("time").textContent =
      seekable && !this.clock.history ? `${text} / ${last.toFixed(this.digits)} s` : `${text} s`;
    const button = this.find("play");
    button.classList.toggle("playing", playing);
    button.setAttribute("aria-label", playing ? "Pause" : "Play");
  }
}

// Whether a key is meant for the control that has the focus.
function isTyped(key, { tagName, type }) {
  if (/^(SELECT|TEXTAREA)$/.test(tagName)) return true;
  if (tagName === "INPUT" && !/^(checkbox|range)$/.test(type)) return true;
  if (key === " ") return /^(BUTTON|SUMMARY|A)$/.test(tagName) || type === "checkbox";
  return type === "range";
}

// Space, arrows, Home, End, 1 to 5.
export function listenToKeys(transport, actions) {
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || event.defaultPrevented) return;
    if (isTyped(event.key, event.target)) return;
    const { clock } = transport;
    const jump = event.shiftKey ? 10 : 1;
    const keys = {
      " ": () => transport.toggle(),
      ArrowLeft: () => clock.step(-jump),
      ArrowRight: () => clock.step(jump),
      Home: () => clock.seek(clock.first),
      End: () => clock.seek(clock.last),
      ...actions,
    };
    if (!Object.hasOwn(keys, event.key)) return;
    event.preventDefault();
    keys[event.key]();
  });
}
