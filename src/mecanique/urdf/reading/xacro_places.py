"""Where the elements of an expanded xacro file come from: the lines of the files that wrote them.

Before xacro expands a text, each of its elements, except xacro's own, gets an attribute with a
number. Macros copy it with the element. Afterwards it is taken away again, and the elements that
are read get the file and line that the number stands for.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import Any, final

from mecanique.urdf.element import Element
from mecanique.urdf.findings import Report
from mecanique.urdf.xml.parse import parse

_MARK = "mecanique_place"


@final
@dataclass
class Places:
    """File and line of every element that xacro may copy.

    Args:
        known: file and line by number.
        taken: the number of each element that xacro left, in order; None for one of its own.
    """

    known: list[tuple[str, int]] = field(default_factory=list)
    taken: list[int | None] = field(default_factory=list)

    def mark(self, text: bytes, file: str) -> bytes:
        """Return a text with a number in each element; as it is, if it cannot be read.

        Args:
            text: of a xacro file.
            file: its name.
        """
        root = parse(text, Report(file))
        try:
            text.decode("utf-8")  # offsets count its bytes
        except UnicodeDecodeError:
            root = None
        if root is None:
            return text
        pieces, before = list[bytes](), 0
        for element in root.walk():
            if element.tag.startswith("xacro:"):
                continue
            at = element.offset + 1 + len(element.tag.encode())
            pieces += [text[before:at], f' {_MARK}="{len(self.known)}"'.encode()]
            self.known.append((file, element.line))
            before = at
        return b"".join([*pieces, text[before:]])

    def take(self, document: Any) -> None:
        """Take the numbers out of an expanded document.

        Args:
            document: xml.dom.minidom's.
        """
        self.taken.clear()
        for node in _elements(document.documentElement):
            number = node.getAttribute(_MARK)
            self.taken.append(int(number) if number else None)
            if number:
                node.removeAttribute(_MARK)

    def put(self, root: Element) -> Element:
        """Return the elements of an expanded text with files and lines of those who wrote them.

        Args:
            root: of the expanded text.
        """
        if sum(1 for _ in root.walk()) != len(self.taken):
            return root
        return self._put(root, iter(self.taken), ("", root.line))

    def _put(
        self, element: Element, numbers: Iterator[int | None], above: tuple[str, int]
    ) -> Element:
        number = next(numbers)
        file, line = above if number is None else self.known[number]
        children = tuple(self._put(child, numbers, (file, line)) for child in element.children)
        return replace(element, children=children, file=file, line=line)


def _elements(node: Any) -> Iterator[Any]:
    waiting = [node]
    while waiting:
        element = waiting.pop()
        yield element
        inner = [child for child in element.childNodes if child.nodeType == child.ELEMENT_NODE]
        waiting.extend(reversed(inner))
