// The clock of a recorded motion, and the bar below the picture that drives it.

// A motion of at most this length is shown in ten seconds [s].
const SHORT = 0.5;

// The speed in the list of speeds, where it may be new.
export function showSpeed(value) {
  const speed = document.getElementById("speed");
  if (![...speed.options].some((option) => Number(option.value) === value))
    speed.append(new Option(`${value}×`, value));
  speed.value = String(value);
}

// How many digits of the time are shown: the slower it passes, the more.
export function digitsAt(speed) {
  return Math.max(2, 2 - Math.floor(Math.log10(speed)));
}

export class Player {
  constructor(table) {
    this.playing = false;
    this.looping = true;
    this.take(table);
    const length = this.last - this.first;
    // what is over in a moment is shown slowly
    this.speed = length > SHORT || !length ? 1 : Number((length / 10).toPrecision(1));
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
    if (this.time >= this.last && !this.goesOn()) this.time = this.first;
    this.playing = true;
    this.stamp = null;
  }

  pause() {
    this.playing = false;
  }

  // Whether the motion has been carried on beyond its end, where that is possible.
  goesOn() {
    const { time } = this;
    if (this.looping || !this.onend?.()) return false;
    this.time = time;
    return true;
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
      if (next <= this.last || this.goesOn()) this.time = next;
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
    showSpeed(clock.speed);
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
    const { first, last, speed, history } = this.clock;
    if (!history) this.digits = Math.max(last - first < 2 ? 3 : 2, digitsAt(speed));
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
