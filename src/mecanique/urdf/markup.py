"""XML text for people: indented, numbers exact, hostile names harmless."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import TypeAlias, final

from mecanique.errors import UrdfError


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
        model: name of the model that it comes from, if that is attached to another one.
    """

    tag: str
    attributes: dict[str, str]
    children: tuple[Element, ...]
    text: str
    line: int
    offset: int
    file: str = ""
    model: str = ""

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


@final
@dataclass(frozen=True)
class Comment:
    """A remark."""

    lines: Sequence[str]

    def __init__(self, *lines: str) -> None:
        object.__setattr__(self, "lines", lines)


@final
@dataclass(frozen=True)
class Tag:
    """An element."""

    tag: str
    children: Sequence[Node]
    content: str  # text inside, instead of children
    attributes: dict[str, str]  # name -> text

    def __init__(self, tag: str, /, *children: Node, content: str = "", **attributes: str) -> None:
        object.__setattr__(self, "tag", tag)
        object.__setattr__(self, "attributes", attributes)
        object.__setattr__(self, "children", children)
        object.__setattr__(self, "content", content)


Node: TypeAlias = Tag | Comment


def write_xml(root: Tag) -> str:
    """Return the XML document, ending with a newline."""
    return "\n".join(['<?xml version="1.0"?>', *_lines(root, "")]) + "\n"


def number(value: float, what: str) -> str:
    """Return a finite number so that reading it gives the same number again."""
    value = float(value)
    if not math.isfinite(value):
        raise UrdfError(f"expected a finite number for {what}, got {value}; a URDF cannot hold it")
    # a zero has no sign in mechanics
    exact = repr(value if value else 0.0).removesuffix(".0")
    short = f"{value:.6g}"
    return short if float(short) == value and len(short) < len(exact) else exact


def numbers(values: Iterable[float], what: str) -> str:
    """Return several finite numbers separated by spaces."""
    return " ".join(number(value, what) for value in values)


def quote(value: str) -> str:
    """Return an attribute's value in quotes, as `xml.sax.saxutils.quoteattr` does.

    That module takes longer to import than a description takes to write, as it reads from networks.
    """
    value = value.replace("&", "&amp;").replace(">", "&gt;").replace("<", "&lt;")
    for letter in "\n\r\t":
        value = value.replace(letter, f"&#{ord(letter)};")
    if '"' not in value:
        return f'"{value}"'
    return f"'{value}'" if "'" not in value else '"' + value.replace('"', "&quot;") + '"'


def _lines(node: Node, indent: str) -> Iterable[str]:
    if isinstance(node, Comment):
        first, *rest = [_harmless(line) for line in node.lines] or [""]
        yield f"{indent}<!-- {first}" + ("" if rest else " -->")
        for line in rest:
            yield f"{indent}     {line}"
        if rest:
            yield f"{indent}-->"
        return
    attributes = "".join(f" {name}={quote(value)}" for name, value in node.attributes.items())
    head = f"{indent}<{node.tag}{attributes}"
    if node.content:
        yield f"{head}>{node.content}</{node.tag}>"
    elif not node.children:
        yield f"{head}/>"
    else:
        yield f"{head}>"
        for child in node.children:
            yield from _lines(child, indent + "  ")
        yield f"{indent}</{node.tag}>"


def _harmless(line: str) -> str:
    """A comment must not contain two hyphens in a row or control characters."""
    line = "".join(letter if letter.isprintable() else " " for letter in line)
    while "--" in line:
        line = line.replace("--", "- -")
    return f"{line} " if line.endswith("-") else line
