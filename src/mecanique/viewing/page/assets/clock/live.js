// The clock of a live view: frames from the server, and what the page asks of it.

import { History } from "./history.js";
import { keepPlace } from "../panels/place.js";
import { setSliders } from "../panels/sliders.js";

// The kind of message that is a command of meshcat's; any other is a frame.
const COMMAND = 2;

export class LiveClock {
  constructor(scene, width) {
    this.history = new History(width);
    this.seekable = false;
    this.speed = 1;
    this.playing = true;
    this.time = scene.first;
    this.scene = scene;
    this.row = null;
    this.number = 0;
    this.newest = null;
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
      if (typeof message.data === "string") this.hear(JSON.parse(message.data));
      else this.receive(message.data);
    };
    socket.onopen = () => this.onlink?.(true);
    socket.onclose = () => {
      this.onlink?.(false);
      setTimeout(() => this.connect(), 1000);
    };
  }

  // A frame is four integers (kind, number, 0, 0), the time and a row of the table.
  receive(buffer) {
    const [kind, number] = new Uint32Array(buffer, 0, 2);
    if (kind === COMMAND) {
      this.oncommand?.(new Uint8Array(buffer, 16));
      return;
    }
    if (this.leaving) return;
    const [time] = new Float64Array(buffer, 16, 1);
    this.newest = { time, row: new Float32Array(buffer, 24), number };
  }

  hear(state) {
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
  // Until then the time stays that of the picture.
  tick() {
    if (!this.newest) return false;
    const { time, row, number } = this.newest;
    Object.assign(this, { time, row, number, newest: null });
    this.history.add(time, row);
    this.send({ do: "ack", value: number });
    return true;
  }
}
