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

// In a slide or on a learning platform the page shows picture and controls alone, and tells the page
// around it how high it would like to be.
export function wireEmbedding(part = 0.62) {
  const show = () => {
    const on = new URLSearchParams(location.hash.replace(/^#/, "")).has("embed");
    document.body.classList.toggle("embed", on);
    if (!on || parent === window) return;
    const height = Math.round(document.documentElement.clientWidth * part);
    parent.postMessage({ source: "mecanique", height }, "*");
  };
  show();
  addEventListener("hashchange", show);
  addEventListener("resize", show);
}
