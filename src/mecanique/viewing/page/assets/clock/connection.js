// What the page of a live view does when the server reports, and when it is gone.

import { keepPlace } from "../panels/place.js";
import { wireNotes } from "../panels/notes.js";
import { wireSliders } from "../panels/sliders.js";

export function wireLive(live, picture, transport) {
  const notice = document.getElementById("notice");
  live.onleave = () => keepPlace(picture.camera);
  live.onlink = (on) => {
    notice.textContent = on ? "" : "The connection is lost; waiting for the program to come back.";
    notice.hidden = on;
  };
  live.onstate = (state) => {
    transport.refit();
    // the slower time passes, the more digits of it are shown
    transport.digits = Math.max(2, 2 - Math.floor(Math.log10(state.speed)));
    if (state.restart) {
      live.history.clear();
      picture.restart();
    }
    showSpeed(state.speed);
    picture.redraw();
  };
  live.oncommand = (command) => picture.stage.viewer.handle_command_bytearray(command);
  document.getElementById("loop-label").hidden = true;
  wireNotes(live);
  wireSliders(live);
}

function showSpeed(value) {
  const speed = document.getElementById("speed");
  if (![...speed.options].some((option) => Number(option.value) === value))
    speed.append(new Option(`${value}×`, value));
  speed.value = String(value);
}
