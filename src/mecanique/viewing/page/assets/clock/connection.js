// What the page of a live view does when the server reports, and when it is gone.

import { keepPlace } from "../panels/place.js";
import { wireNotes } from "../panels/notes.js";
import { Link } from "./link.js";
import { digitsAt, showSpeed } from "./player.js";
import { setSliders, wireSliders } from "../panels/sliders.js";

// How long a page that computes by itself says that it is alone now [ms].
const SAID = 8000;

function wireLink(link, picture) {
  link.onleave = () => keepPlace(picture.camera);
  wireNotes(link);
}

// The page of a motion that the server computes.
export function wireLive(live, picture, transport) {
  const notice = document.getElementById("notice");
  wireLink(live, picture);
  live.onlink = (on) => {
    notice.textContent = on ? "" : "The connection is lost; waiting for the program to come back.";
    notice.hidden = on;
  };
  live.onstate = (state) => {
    live.playing = !state.paused;
    live.speed = state.speed;
    setSliders(state.values);
    transport.refit();
    transport.digits = digitsAt(state.speed);
    if (state.restart) {
      live.history.clear();
      picture.restart();
    }
    showSpeed(state.speed);
    picture.redraw();
  };
  document.getElementById("loop-label").hidden = true;
  wireSliders(live);
  live.connect(); // not before: what nobody listens to yet is lost
}

// The page of a motion that it computes by itself: only what is found out about it comes later.
export function wireComputing(id, picture, clock) {
  const link = new Link(id);
  const notice = document.getElementById("notice");
  wireLink(link, picture);
  let linked = false;
  link.onlink = (on) => {
    if (on) notice.hidden = true;
    else if (linked) {
      notice.textContent = "The program has ended; this page goes on by itself.";
      notice.hidden = false;
      setTimeout(() => (notice.hidden = true), SAID);
    }
    linked = on;
  };
  link.onstate = ({ speed }) => {
    clock.setSpeed(speed);
    showSpeed(speed);
  };
  link.connect();
}
