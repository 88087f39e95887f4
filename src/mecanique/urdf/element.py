"""Elements of an XML text."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import final


@final
@dataclass(frozen=True)
class Element:
    """One element of an XML text.

    Args:
        tag: its name as written, prefix included.
        attributes: its attributes, by name as written.
        children: the elements inside, in order.
        text: the characters inside, without the space around them.
        line: where its start tag begins, counted from 1.
        offset: where its start tag begins, in bytes of the text in UTF-8.
        file: the file whose line it is, if that is not the text it was read from.
    """

    tag: str
    attributes: dict[str, str]
    children: tuple[Element, ...]
    text: str
    line: int
    offset: int
    file: str = ""

    def child(self, tag: str) -> Element | None:
        """Return the first child with a tag, or None."""
        return next((child for child in self.children if child.tag == tag), None)

    def all(self, tag: str) -> tuple[Element, ...]:
        """Return the children with a tag, in order."""
        return tuple(child for child in self.children if child.tag == tag)

    def walk(self) -> Iterator[Element]:
        """Yield the element and all elements inside, in order of the text."""
        waiting = [self]
        while waiting:
            element = waiting.pop()
            yield element
            waiting.extend(reversed(element.children))
