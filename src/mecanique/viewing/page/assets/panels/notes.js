// What has been found out since the page was made: the badge, the insides of panels, and what
// went wrong.

import { make } from "./elements.js";

export function wireNotes(live) {
  const banner = make("div", { id: "alarm", hidden: true });
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
    banner.replaceChildren(...texts.map((text) => make("p", { dir: "auto" }, text)));
  };
}
