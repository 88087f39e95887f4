"""The catalogue as a folder of offline pages: one for each system, and an index with pictures."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import final

from mecanique.errors import InputError, MecaniqueError
from mecanique.figure.draw import figure_text
from mecanique.files import write_text
from mecanique.motion.motion import Motion, simulate
from mecanique.reference import degrees_of_freedom
from mecanique.textbook import entry, load, names
from mecanique.textbook.system import System
from mecanique.viewing.page.page import policy
from mecanique.viewing.page.panels import encode, fill, read_asset
from mecanique.viewing.show import export
from mecanique.wording import say_count


@final
@dataclass(frozen=True)
class Card:
    """A system in the index."""

    name: str
    title: str
    tags: tuple[str, ...]
    picture: str  # its figure, as SVG text; empty if there is none
    fault: str = ""  # why it has no page; empty if it has one
    freedom: int | None = None  # its degrees of freedom; None if they are unknown


def gallery(
    directory: str | os.PathLike[str],
    systems: Sequence[str] | None = None,
    *,
    duration: float | None = None,
    progress: Callable[[str, float], None] | None = None,
) -> tuple[Card, ...]:
    """Write a page for each system of the catalogue, and an index that reports what failed."""
    entries = _entries(systems)
    folder = _folder(directory)
    cards = []
    for k, (name, system) in enumerate(entries.items()):
        if progress is not None:
            progress(name, k / len(entries))
        fault = ""
        try:
            export(_motion(name, duration), folder / f"{name}.html")
        except MecaniqueError as error:
            fault = str(error)
        picture, freedom = picture_of(name, small=True), _count_freedom(name)
        cards.append(Card(name, system.title, system.tags, picture, fault, freedom))
    write_text(folder / "index.html", index(cards))
    return tuple(cards)


def pictures(
    directory: str | os.PathLike[str], systems: Sequence[str] | None = None
) -> tuple[Path, ...]:
    """Write the figure of each system of the catalogue as an SVG file."""
    entries = _entries(systems)
    folder = _folder(directory)
    paths = tuple(folder / f"{name}.svg" for name in entries)
    for name, path in zip(entries, paths, strict=True):
        write_text(path, picture_of(name))
    return paths


def _entries(systems: Sequence[str] | None) -> dict[str, System]:
    """The entries of these systems, or of all, by name."""
    everyone = sorted((*names(), *names(corners=True)))
    return {name: entry(name) for name in (everyone if systems is None else systems)}


def _folder(directory: str | os.PathLike[str]) -> Path:
    folder = Path(directory)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(
            f"expected a directory to write to, got {os.fspath(directory)!r}: {error.strerror}"
        ) from None
    return folder


def picture_of(name: str, *, small: bool = False) -> str:
    """Return the figure of a system of the catalogue as SVG text, or a small one for an index."""
    return figure_text(load(name), entry(name).start, small=small)


def _count_freedom(name: str) -> int | None:
    """Degrees of freedom of a system at the start of its motion."""
    mechanism, system = load(name), entry(name)
    if not mechanism.constrained:
        return mechanism.nv
    with suppress(MecaniqueError):
        return degrees_of_freedom(mechanism, system.start).N
    return None


def _motion(name: str, duration: float | None) -> Motion:
    system = entry(name)
    speed = {velocity.removesuffix("'"): value for velocity, value in system.start_velocity.items()}
    # fast motions stay short: the squeezer runs for some hundredths of a second
    seconds = system.duration if duration is None else min(duration, system.duration)
    return simulate(load(name), q=dict(system.start), v=speed, duration=seconds)


def index(cards: Sequence[Card]) -> str:
    """Return the index as one HTML document that needs no network."""
    tags = sorted({tag for card in cards for tag in card.tags})
    buttons = "".join(
        f'<button type="button" data-tag="{escape(tag)}" aria-pressed="false">'
        f"{escape(tag)}</button>"
        for tag in tags
    )
    counts = sorted({card.freedom for card in cards if card.freedom is not None})
    choices = "".join(f'<option value="{n}">{n}</option>' for n in counts)
    style, script = read_asset("gallery.css"), read_asset("gallery.js")
    parts = {
        "policy": escape(policy([script], [style], "'none'")),
        "style": style,
        "count": say_count(len(cards), "system"),
        "choices": choices,
        "buttons": buttons,
        "cards": "\n".join(map(_card, cards)),
        "script": script,
    }
    return fill(read_asset("gallery.html"), parts)


def _card(card: Card) -> str:
    image = f'<img src="{encode(card.picture)}" alt="">' if card.picture else ""
    words = f"<h2>{escape(card.name.replace('_', ' '))}</h2><p>{escape(card.title)}</p>"
    tags = "".join(f"<li>{escape(tag)}</li>" for tag in card.tags)
    freedom = "" if card.freedom is None else card.freedom
    attributes = f'data-tags="{escape("|".join(card.tags))}" data-freedom="{freedom}"'
    if card.fault:
        inner = f'<div class="card">{image}{words}<p class="fault">{escape(card.fault)}</p></div>'
    else:
        inner = f'<a class="card" href="{escape(card.name)}.html">{image}{words}</a>'
    return f"<article {attributes}>{inner}<ul>{tags}</ul></article>"
