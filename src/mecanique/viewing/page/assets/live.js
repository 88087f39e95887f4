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
    return gap > 0
      ? low + Math.min(1, Math.max(0, (t - this.times[low]) / gap))
      : Math.max(high, 0);
  }
}

export class LiveClock {
  constructor(scene, width) {
    this.history = new History(width);
    this.seekable = false;
    this.speed = 1;
    this.playing = true;
    this.time = scene.first;
    this.scene = scene;
    this.row = null;
    this.connect();
  }

  get first() {
    return this.history.first;
  }

  get last() {
    return this.history.last;
  }

  // How much of time a plot shows at least: a stream has just begun, and goes on [s].
  get room() {
    return 2 * Math.min(this.speed, 1);
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
    if (this.leaving) return;
    this.time = new Float64Array(buffer, 16, 1)[0];
    this.row = new Float32Array(buffer, 24);
    this.number = number;
    this.fresh = true;
  }

  told(state) {
    if (state.notes) {
      this.onnotes?.(state.notes);
      return;
    }
    if (state.scene !== this.scene.id) {
      // what still comes before the page has gone belongs to the new scene
      this.leaving = true;
      keepPlace();
      location.reload();
      return;
    }
    this.playing = !state.paused;
    this.speed = state.speed;
    setSliders(state.values);
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

  // A stream shows the present alone: no other time can be chosen, neither by seeking nor by steps.
  seek() {}

  step() {
    this.pause();
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

// What has been found out since the page was made: the badge, the insides of panels, and what went wrong.
export function wireNotes(live) {
  const banner = Object.assign(document.createElement("div"), { id: "alarm", hidden: true });
  banner.setAttribute("role", "alert");
  document.querySelector("header").after(banner);
  const wrong = { alarm: "", warning: "" };
  live.onnotes = (notes) => {
    for (const key of ["equations", "verdict"]) {
      const panel = document.getElementById(`panel-${key}`);
      // the texts come from the page's maker, which lets MathML through and nothing else
      if (panel && notes[key] !== undefined)
        panel.innerHTML = panel.querySelector("h2").outerHTML + notes[key];
    }
    if (notes.badge !== undefined) {
      document.querySelector("header .badge")?.remove();
      document.querySelector("header").insertAdjacentHTML("beforeend", notes.badge);
    }
    for (const key of Object.keys(wrong)) wrong[key] = notes[key] ?? wrong[key];
    const texts = Object.values(wrong).filter(Boolean);
    banner.hidden = !texts.length;
    banner.replaceChildren(
      ...texts.map((text) =>
        Object.assign(document.createElement("p"), { textContent: text, dir: "auto" }),
      ),
    );
  };
}

// A page that must be loaded anew opens where it was: the same tab, the same view.
function keepPlace() {
  const tab = document.querySelector("[role=tab][aria-selected=true]")?.id;
  const view = document.querySelector("[data-camera][aria-pressed=true]")?.dataset.camera;
  sessionStorage.setItem("place", JSON.stringify({ tab, view }));
}

export function findPlace() {
  const { tab, view } = JSON.parse(sessionStorage.getItem("place") ?? "{}");
  sessionStorage.removeItem("place");
  if (tab) document.getElementById(tab)?.click();
  if (view) document.querySelector(`[data-camera=${CSS.escape(view)}]`)?.click();
}

function written(value) {
  return String(Number(Number(value).toPrecision(6)));
}

// Sets the sliders to what other pages, or this one before it was loaded anew, have chosen.
function setSliders(values) {
  for (const [kind, name, value] of values)
    for (const slider of document.querySelectorAll(`input[data-kind=${kind}]`))
      if (slider.dataset.name === name && slider !== document.activeElement) {
        slider.value = value;
        slider.closest("tr").querySelector("output").textContent = written(value);
      }
}

// Sliders for parameters and initial values; the motion starts again with what they are set to.
export function wireSliders(clock) {
  for (const slider of document.querySelectorAll("input[data-name]")) {
    slider.disabled = false;
    slider.oninput = () => {
      slider.closest("tr").querySelector("output").textContent = written(slider.value);
    };
    slider.onchange = () =>
      clock.send({
        do: slider.dataset.kind,
        name: slider.dataset.name,
        value: Number(slider.value),
      });
  }
}
