// A page that must be loaded anew opens where it was: the same tab, the same view.

export function keepPlace() {
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
