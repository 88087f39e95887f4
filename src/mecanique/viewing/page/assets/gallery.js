// Tags choose which systems are shown: those that have every tag that is pressed.

const buttons = [...document.querySelectorAll("button[data-tag]")];
const cards = [...document.querySelectorAll("article")];
const count = document.getElementById("count");

function choose() {
  const wanted = buttons
    .filter((b) => b.getAttribute("aria-pressed") === "true")
    .map((b) => b.dataset.tag);
  for (const card of cards) {
    const tags = card.dataset.tags.split("|");
    card.hidden = !wanted.every((tag) => tags.includes(tag));
  }
  const shown = cards.filter((card) => !card.hidden).length;
  count.textContent =
    shown === cards.length ? `${shown} systems` : `${shown} of ${cards.length} systems`;
}

for (const button of buttons)
  button.onclick = () => {
    button.setAttribute(
      "aria-pressed",
      button.getAttribute("aria-pressed") === "true" ? "false" : "true",
    );
    choose();
  };
