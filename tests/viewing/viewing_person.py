"""A person at a page: a mouse and a keyboard, the same in every browser."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any, Protocol

from viewing_browser import Visit
from viewing_firefox import Firefox

KEYS = {"Enter": "\ue007", "Escape": "\ue00c", "End": "\ue010", "ArrowRight": "\ue014"}
"""What WebDriver calls keys that write nothing."""

Place = Sequence[float]
"""Where the pointer is, from the left and the top of the page's window [px]."""


class Hands(Protocol):
    """What a browser lets a person do."""

    def js(self, expression: str) -> Any: ...
    def pointer(self, *steps: tuple[str, Place]) -> None: ...
    def key(self, name: str) -> None: ...


class InChromium:
    def __init__(self, seen: Visit) -> None:
        self.seen = seen

    def js(self, expression: str) -> Any:
        return self.seen.js(f"() => ({expression})")

    def pointer(self, *steps: tuple[str, Place]) -> None:
        mouse = self.seen.page.mouse
        for kind, (x, y) in steps:
            if kind == "move":
                mouse.move(x, y)
            else:
                getattr(mouse, kind)()

    def key(self, name: str) -> None:
        self.seen.page.keyboard.press(name)


class InFirefox:
    def __init__(self, fox: Firefox) -> None:
        self.fox = fox

    def js(self, expression: str) -> Any:
        return self.fox.js(expression)

    def pointer(self, *steps: tuple[str, Place]) -> None:
        self.fox.point(*steps)

    def key(self, name: str) -> None:
        self.fox.press(KEYS.get(name, name))


AIMS = 5
"""How often a person aims at what moves away before they give up."""
AIM = """(async () => {
    const control = %s;
    control.scrollIntoView({ block: "nearest" });
    await new Promise(requestAnimationFrame);
    const { left, top, width, height } = control.getBoundingClientRect();
    const place = [left + width * %r, top + height / 2];
    const hit = document.elementFromPoint(...place);
    const part = control.closest("label") ?? control;
    return [...place, part.contains(hit) ? "" : (hit?.outerHTML.slice(0, 200) ?? "nothing")];
})()"""


class Person:
    """Someone who reads a page and uses what is on it; whatever is used is taken note of."""

    def __init__(self, hands: Hands) -> None:
        self.hands = hands
        self.js = hands.js
        self.js(
            """(() => {
                window.used = new Set();
                const note = ({ target }) =>
                    used.add(target.closest("button, select, input, summary"));
                for (const kind of ["click", "input", "change"]) addEventListener(kind, note, true);
            })()"""
        )

    def place(self, control: str, share: float = 0.5) -> list[float]:
        """Where a control is, so far along its width; nothing may lie over it."""
        for _ in range(AIMS):
            *place, over = self.js(AIM % (control, share))
            if not over:
                return [float(x) for x in place]
        raise AssertionError(f"{over} lies over {control} at {place}")

    def click(self, control: str, share: float = 0.5) -> None:
        place = self.place(control, share)
        self.hands.pointer(("move", place), ("down", place), ("up", place))

    def drag(self, first: Place, *places: Place) -> None:
        moves = [("move", place) for place in places]
        self.hands.pointer(("move", first), ("down", first), *moves, ("up", places[-1]))

    def write(self, field: str, text: str) -> None:
        """Replace what stands in a field."""
        self.click(field, 0.3)
        self.js(f"({field}).select()")
        for letter in text:
            self.hands.key(letter)

    def choose(self, select: str, value: str) -> None:
        """Choose from a list, whose own window no driver can see."""
        self.js(
            f"((list) => {{ list.focus(); list.value = {json.dumps(value)};"
            " list.dispatchEvent(new Event('input', { bubbles: true }));"
            f" list.dispatchEvent(new Event('change', {{ bubbles: true }})); }})({select})"
        )

    def wait(self, condition: str) -> None:
        """Look at the page until something is so."""
        came = self.js(
            f"""(async () => {{
                const end = Date.now() + 20000;
                while (!({condition}) && Date.now() < end)
                    await new Promise((done) => setTimeout(done, 30));
                return Boolean({condition});
            }})()"""
        )
        assert came, condition
