// Tabs that the keyboard reaches, and files to save.

import { make } from "./elements.js";

// What is wider than its frame is scrolled by the keyboard too, once it has the focus.
export function reach() {
  for (const frame of document.querySelectorAll(".equation, .scroll, pre")) {
    if (!frame.checkVisibility()) continue;
    if (frame.scrollWidth > frame.clientWidth) frame.tabIndex = 0;
    else frame.removeAttribute("tabindex");
  }
}

export function wireTabs(list) {
  const tabs = [...list.querySelectorAll("[role=tab]:not([hidden])")];
  const panel = (tab) => document.getElementById(tab.getAttribute("aria-controls"));
  const choose = (chosen) => {
    for (const tab of tabs) {
      const on = tab === chosen;
      tab.setAttribute("aria-selected", on);
      tab.tabIndex = on ? 0 : -1;
      panel(tab).classList.toggle("off", !on);
    }
    panel(chosen).dispatchEvent(new Event("opened"));
  };
  const open = (tab) => {
    choose(tab);
    tab.scrollIntoView({ block: "nearest", inline: "nearest" });
    reach();
  };
  addEventListener("resize", reach);
  document.getElementById("panel").addEventListener("toggle", reach, true);
  tabs.forEach((tab, i) => {
    tab.onclick = () => open(tab);
    tab.onkeydown = (event) => {
      const steps = { ArrowLeft: -1, ArrowRight: 1, Home: -i, End: tabs.length - 1 - i };
      if (!Object.hasOwn(steps, event.key)) return;
      event.preventDefault();
      const next = tabs[(i + steps[event.key] + tabs.length) % tabs.length];
      open(next);
      next.focus();
    };
  });
  if (tabs.length) choose(tabs[0]);
}

export function save(name, text, type) {
  const href = URL.createObjectURL(new Blob([text], { type }));
  const link = make("a", { href, download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 2000);
}

// The button beside the URDF, where there is one.
export function wireSave(fileName) {
  const button = document.getElementById("save-urdf");
  const text = document.getElementById("urdf-text")?.textContent;
  if (button) button.onclick = () => save(`${fileName}.urdf`, text, "application/xml");
}
