// The modes of a motion, below its clock: for each element that switches a strip of its states.

import { measure } from "../data/numbers.js";
import { make } from "../panels/elements.js";

// A state that lasts a smaller part of the motion has no words in its strip, only in its hint.
const NARROW = 0.1;

const spell = (state) => state.replace("-", "−");

export class ModeStrips {
  constructor({ modes }, clock) {
    this.clock = clock;
    this.holder = document.getElementById("strips");
    this.build(modes);
  }

  // Shows the modes of a motion that the page has computed, if there are any.
  take({ path: { corners, last } }) {
    if (corners) this.build(corners.strips(last));
  }

  build(modes) {
    this.holder.hidden = !modes.length;
    this.holder.replaceChildren();
    this.strips = modes.map((mode) => {
      const track = make("div", { className: "track" });
      const needle = make("i");
      const now = make("output");
      now.setAttribute("aria-label", `${mode.name} now`);
      for (const span of mode.spans) track.append(this.segment(mode.name, span));
      for (const t of mode.impacts) track.append(this.impact(mode.name, t));
      track.append(needle);
      this.wire(track);
      const row = make("div", { className: "strip" }, make("span", {}, mode.name), track, now);
      this.holder.append(row);
      return { ...mode, needle, now };
    });
  }

  share(t) {
    const { first, last } = this.clock;
    return (t - first) / (last - first || 1);
  }

  segment(name, [begin, end, state]) {
    const long = this.share(end) - this.share(begin) > NARROW;
    const bar = make("b", {}, long ? spell(state) : "");
    bar.dataset.state = state;
    bar.title = `${name} ${spell(state)} from ${measure(begin)} s to ${measure(end)} s`;
    bar.style.left = `${100 * this.share(begin)}%`;
    bar.style.width = `${100 * (this.share(end) - this.share(begin))}%`;
    return bar;
  }

  impact(name, t) {
    const mark = make("u", { title: `impact at ${name}, t = ${measure(t)} s` });
    mark.style.left = `${100 * this.share(t)}%`;
    return mark;
  }

  // A strip is clicked or dragged like the clock above it.
  wire(track) {
    const seek = (event) => {
      if (!event.buttons) return;
      const { left, width } = track.getBoundingClientRect();
      const { clock } = this;
      clock.pause();
      clock.seek(clock.first + ((event.clientX - left) / width) * (clock.last - clock.first));
    };
    track.onpointerdown = (event) => {
      track.setPointerCapture(event.pointerId);
      seek(event);
    };
    track.onpointermove = seek;
  }

  // Called for every picture.
  show() {
    const { time } = this.clock;
    for (const { spans, needle, now } of this.strips) {
      needle.style.left = `${100 * this.share(time)}%`;
      const here = spans.find(([, end]) => time < end) ?? spans.at(-1);
      now.textContent = spell(here[2]);
    }
  }
}
