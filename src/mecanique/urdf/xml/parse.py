"""XML, read safely: elements that know their line, and nothing that a hostile file could use."""

from __future__ import annotations

from typing import final
from xml.parsers import expat

from mecanique.urdf.element import Element
from mecanique.urdf.findings import Report

__all__ = ["MOST_BYTES", "MOST_DEPTH", "MOST_ELEMENTS", "parse"]

MOST_BYTES = 20_000_000
"""Largest text that is read; robot descriptions stay below one megabyte."""

MOST_DEPTH = 64
"""Deepest nesting that is read; a URDF needs six levels."""

MOST_ELEMENTS = 500_000
"""Most elements that are read, so that a small file cannot fill the memory."""


def parse(data: bytes | str, report: Report) -> Element | None:
    """Return the root element of an XML text, or None if it cannot be read; the report says why.

    Entities and document types are refused: a URDF needs none, and they are how an XML text grows
    without bound or reads other files.

    Args:
        data: the text; bytes carry their own encoding, UTF-8 by default.
        report: where faults are noted.
    """
    try:
        raw = data.encode() if isinstance(data, str) else data
    except UnicodeEncodeError as error:
        report.add(
            "M002",
            str(data).count("\n", 0, error.start) + 1,
            "",
            "half of a surrogate pair is no character",
        )
        return None
    if len(raw) > MOST_BYTES:
        report.add("M004", 1, "", f"expected at most {MOST_BYTES:,} bytes, got {len(raw):,}")
        return None
    if not raw.strip():
        report.add("M002", 1, "", "the text is empty")
        return None
    builder = _Builder("UTF-8" if isinstance(data, str) else None)
    try:
        builder.parser.Parse(raw, True)
    except _Refused as refused:
        report.add(refused.code, builder.parser.CurrentLineNumber, "", refused.message)
        return None
    except expat.ExpatError as error:
        binary = b"\0" in raw[:1000] and not raw.startswith((b"\xff\xfe", b"\xfe\xff"))
        reason = "it is binary, no text" if binary else expat.ErrorString(error.code)
        report.add("M002", error.lineno, "", f"the text is not well-formed XML: {reason}")
        return None
    except (LookupError, ValueError) as error:
        report.add("M002", 1, "", f"its encoding cannot be read ({error})", "Save it as UTF-8.")
        return None
    return builder.roots[0]


@final
class _Refused(Exception):  # noqa: N818  # it never leaves this module
    def __init__(self, code: str, message: str) -> None:
        self.code, self.message = code, message


@final
class _Builder:
    """Collects elements as expat meets them."""

    def __init__(self, encoding: str | None) -> None:
        self.parser = expat.ParserCreate(encoding)
        self.parser.buffer_text = True
        self.parser.StartElementHandler = self._start
        self.parser.EndElementHandler = self._end
        self.parser.CharacterDataHandler = self._characters
        self.parser.StartDoctypeDeclHandler = self._doctype
        self.parser.EntityDeclHandler = self._doctype
        self.roots: list[Element] = []
        self._count = 0
        self._open: list[tuple[str, dict[str, str], list[Element], list[str], int, int]] = []

    def _start(self, tag: str, attributes: dict[str, str]) -> None:
        self._count += 1 + len(attributes)
        if len(self._open) >= MOST_DEPTH:
            raise _Refused("M004", f"elements are nested more than {MOST_DEPTH} deep")
        if self._count > MOST_ELEMENTS:
            raise _Refused("M004", f"there are more than {MOST_ELEMENTS:,} elements and attributes")
        place = self.parser.CurrentLineNumber, self.parser.CurrentByteIndex
        self._open.append((tag, attributes, [], [], *place))

    def _end(self, _: str) -> None:
        tag, attributes, children, text, line, offset = self._open.pop()
        element = Element(tag, attributes, tuple(children), "".join(text).strip(), line, offset)
        (self._open[-1][2] if self._open else self.roots).append(element)

    def _characters(self, text: str) -> None:
        if self._open:
            self._open[-1][3].append(text)

    def _doctype(self, *_: object) -> None:
        raise _Refused("M003", "a document type or entity is declared")
