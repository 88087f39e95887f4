// Which systems are shown: those that have every tag that is pressed, as many degrees of freedom as
// chosen, and all the words that are searched for.

const buttons = [...document.querySelectorAll("button[data-tag]")];
const cards = [...document.querySelectorAll("article")];
const count = document.getElementById("count");

const search = document.getElementById("search");
const freedom = document.getElementById("freedom");

function choose() {
  const words = search.value.toLowerCase().split(/\s+/).filter(Boolean);
  const wanted = buttons
    .filter((b) => b.getAttribute("aria-pressed") === "true")
    .map((b) => b.dataset.tag);
  for (const card of cards) {
    const tags = card.dataset.tags.split("|");
    const text = `${card.textContent} ${tags.join(" ")}`.toLowerCase();
    card.hidden = !(
      wanted.every((tag) => tags.includes(tag)) &&
      words.every((word) => text.includes(word)) &&
      (freedom.value === "" || freedom.value === card.dataset.freedom)
    );
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

search.oninput = choose;
freedom.onchange = choose;
