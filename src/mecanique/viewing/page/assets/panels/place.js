// A page that must be loaded anew opens where it was: the same tab, the same view.

export function keepPlace(camera) {
  const tab = document.querySelector("[role=tab][aria-selected=true]")?.id;
  const view = document.querySelector("[data-camera][aria-pressed=true]")?.dataset.camera;
  const follow = document.getElementById("follow").value;
  const [center, eye] = [camera.center().toArray(), camera.eye().toArray()];
  const scroll = document.querySelector("[role=tabpanel]:not(.off)")?.parentElement.scrollTop;
  sessionStorage.setItem("place", JSON.stringify({ tab, view, follow, center, eye, scroll }));
}

export function findPlace(camera) {
  const place = JSON.parse(sessionStorage.getItem("place") ?? "{}");
  const { tab, view, follow, center, eye, scroll } = place;
  sessionStorage.removeItem("place");
  if (tab) document.getElementById(tab)?.click();
  const followed = document.getElementById("follow");
  if (follow !== undefined && follow !== followed.value) {
    followed.value = follow;
    followed.dispatchEvent(new Event("change"));
  }
  if (view) document.querySelector(`[data-camera=${CSS.escape(view)}]`)?.click();
  else if (eye) {
    const { Vector3 } = camera.stage.three;
    camera.chosen(null);
    camera.place(new Vector3(...center), new Vector3(...eye));
  }
  const panel = document.querySelector("[role=tabpanel]:not(.off)")?.parentElement;
  if (scroll && panel) panel.scrollTop = scroll;
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
