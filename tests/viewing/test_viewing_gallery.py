"""The gallery: a page a system, an index that works offline, pictures that are up to date."""

from __future__ import annotations

import re
from collections.abc import Callable
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest
from viewing_browser import Visit

import mecanique as mq
from mecanique.errors import UnknownNameError
from mecanique.viewing.gallery import Card, _count_freedom, gallery, index, picture_of, pictures

KEPT = Path(__file__).parents[2] / "examples" / "pictures"
NUMBER = re.compile(r"-?\d+\.?\d*")


EVERYONE = (*mq.textbook.names(), *mq.textbook.names(corners=True))


@pytest.mark.parametrize("name", EVERYONE)
def test_the_pictures_kept_are_those_drawn(name: str) -> None:
    """Letter by letter, but for what rounding does to places."""
    path = KEPT / f"{name}.svg"
    assert path.is_file(), "run: mecanique gallery examples/pictures --pictures"
    kept, drawn = path.read_text(encoding="utf-8"), picture_of(name)
    assert NUMBER.sub("0", kept) == NUMBER.sub("0", drawn)
    numbers = [np.array([float(x) for x in NUMBER.findall(text)]) for text in (kept, drawn)]
    assert np.abs(numbers[0] - numbers[1]).max() < 1.5


def test_there_are_no_other_pictures() -> None:
    assert {path.stem for path in KEPT.iterdir()} == set(EVERYONE)


def test_a_gallery_of_two(visit: Callable[..., Visit], tmp_path: Path) -> None:
    told: list[tuple[str, float]] = []
    chosen = ["rigid_bar_pendulum", "two_blocks"]
    cards = gallery(
        tmp_path / "pages",
        chosen,
        duration=0.2,
        progress=lambda name, done: told.append((name, done)),
    )
    assert [card.name for card in cards] == chosen
    assert not any(card.fault for card in cards)
    assert told == [("rigid_bar_pendulum", 0.0), ("two_blocks", 0.5)]
    names = ["index.html", "rigid_bar_pendulum.html", "two_blocks.html"]
    assert sorted(path.name for path in (tmp_path / "pages").iterdir()) == names
    seen = visit((tmp_path / "pages" / "index.html").as_uri(), wait=False, offline=True)
    assert seen.page.locator("article img").count() == 2
    assert seen.js(
        "() => [...document.images].every(image => image.complete && image.naturalWidth > 50)"
    )
    # pictures are inside the page, as data
    assert all(address.startswith("data:image/svg+xml") for address in seen.requests[1:])
    assert seen.messages == seen.errors == []
    seen.page.click("button[data-tag=pendulum]")
    assert seen.page.locator("article:visible h2").all_inner_texts() == ["Rigid bar pendulum"]
    assert seen.page.locator("#count").inner_text() == "1 of 2 systems"
    seen.page.click("button[data-tag=pendulum]")
    seen.page.select_option("#freedom", "2")
    assert seen.page.locator("article:visible h2").all_inner_texts() == ["Two blocks"]
    seen.page.select_option("#freedom", "")
    seen.page.fill("#search", "bar RIGID")
    assert seen.page.locator("article:visible h2").all_inner_texts() == ["Rigid bar pendulum"]
    seen.page.click("article:visible a")
    seen.page.wait_for_selector("body.ready")
    assert "Rigid bar pendulum" in seen.page.title()


def test_what_fails_is_told_in_the_index(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object) -> None:
        raise mq.InputError("no <motion> today")

    monkeypatch.setattr(import_module("mecanique.viewing.gallery"), "export", refuse)
    (card,) = gallery(tmp_path, ["two_blocks"], duration=0.1)
    assert card.fault == "no <motion> today"
    text = (tmp_path / "index.html").read_text(encoding="utf-8")
    assert "no &lt;motion&gt; today" in text
    assert 'href="two_blocks.html"' not in text


def test_hostile_words_are_only_words(visit: Callable[..., Visit], tmp_path: Path) -> None:
    every = "</script><script>alert(1)</script><img src=x onerror=alert(1)>\"' & שלום"
    picture = "<svg xmlns='http://www.w3.org/2000/svg'/>"
    path = tmp_path / "i.html"
    path.write_text(
        index([Card("x", every, (every, "constructor"), picture, every)]), encoding="utf-8"
    )
    seen = visit(path.as_uri(), wait=False, offline=True)
    assert seen.page.locator("article p").first.inner_text() == every
    assert seen.page.locator("script").count() == 1
    seen.page.locator("button").first.click()
    assert seen.errors == []


def test_what_cannot_be_written_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("", encoding="utf-8")
    with pytest.raises(mq.InputError, match="expected a directory to write to"):
        pictures(tmp_path / "file", [])
    with pytest.raises(UnknownNameError, match="pendulum"):
        gallery(tmp_path / "new", ["pendulun"])
    assert not (tmp_path / "new").exists()


def test_freedom_is_counted_where_loops_are_closed() -> None:
    # its default start names three of five angles, and leaves a loop open
    assert [_count_freedom(name) for name in ("chained_four_bars", "rolling_coin")] == [1, 3]
