"""XML as elements that know their line."""

from __future__ import annotations

import re
from typing import NamedTuple, final

from mecanique.files import recognize
from mecanique.safe_xml import Reader, XmlRefusedError
from mecanique.urdf.findings import Report
from mecanique.urdf.markup import Element

_COMMENT = re.compile(rb"<!--(.*?)-->", re.DOTALL)
_FOREIGN = re.compile(rb"<(mujoco|sdf)")
_LATE = re.compile(
    rb"""\s+(<\?xml\s+version\s*=\s*["']1\.0["'](?:\s+encoding\s*=\s*["']utf-8["'])?\s*\?>)""",
    re.IGNORECASE,
)
"""An XML declaration of a text in UTF-8 that is not at its start."""

MOST_BYTES = 20_000_000
"""Largest text that is read; robot descriptions are smaller than one megabyte."""


def parse(data: bytes | str, report: Report) -> Element | None:
    """Return the root element of an XML text, or None if it cannot be read; the report says why."""
    try:
        raw = data.encode() if isinstance(data, str) else data
    except UnicodeEncodeError as error:
        line = str(data).count("\n", 0, error.start) + 1
        report.add("M002", line, "half of a surrogate pair is no character")
        return None
    if len(raw) > MOST_BYTES:
        report.add("M004", 1, f"expected at most {MOST_BYTES:,} bytes, got {len(raw):,}")
        return None
    if not raw.strip():
        report.add("M002", 1, "the text is empty")
        return None
    if (mistaken := recognize(raw)) is not None:
        name, remedy = mistaken
        report.add("M005", 1, f"the file is {name}", remedy)
        return None
    builder = _Builder("UTF-8" if isinstance(data, str) else None)
    try:
        builder.reader.read(_blank_hyphens(_blank_late_declaration(raw, report)))
    except XmlRefusedError as refused:
        match refused.reason:
            case "malformed":
                report.add("M002", refused.line, f"the text is not well-formed XML: {refused}")
            case "encoding":
                message = f"its encoding cannot be read ({refused})"
                report.add("M002", refused.line, message, "Save it as UTF-8.")
            case "entities":
                report.add("M003", refused.line, str(refused))
            case "limits":
                report.add("M004", refused.line, str(refused))
        return None
    return builder.roots[0]


def _blank_late_declaration(raw: bytes, report: Report) -> bytes:
    """Return a text without an XML declaration that stands behind blanks; places stay the same."""
    late = _LATE.match(raw)
    if late is None:
        return raw
    line = raw.count(b"\n", 0, late.start(1)) + 1
    report.aside.add("M007", line, "the text begins with blanks before its <?xml … ?>")
    return raw[: late.start(1)] + re.sub(rb"[^\n]", b" ", late.group(1)) + raw[late.end() :]


def _blank_hyphens(raw: bytes) -> bytes:
    """Return MJCF and SDF without hyphens in comments, where engines take any and XML no two."""
    if _FOREIGN.search(raw) is None:
        return raw
    return _COMMENT.sub(lambda comment: b"<!--" + comment[1].replace(b"-", b" ") + b"-->", raw)


class _Open(NamedTuple):
    """What an element is made of until its end tag comes, in the order of `Element`."""

    tag: str
    attributes: dict[str, str]
    children: list[Element]
    text: list[str]
    line: int
    offset: int


@final
class _Builder:
    """Collects elements as the reader meets them."""

    def __init__(self, encoding: str | None) -> None:
        self.reader = Reader(self, encoding=encoding)
        self.roots: list[Element] = []
        self._open: list[_Open] = []

    def start(self, tag: str, attributes: dict[str, str], /) -> None:
        self._open.append(_Open(tag, attributes, [], [], self.reader.line, self.reader.offset))

    def end(self, _: str, /) -> None:
        tag, attributes, children, text, line, offset = self._open.pop()
        siblings = self._open[-1].children if self._open else self.roots
        inside = "".join(text).strip()
        siblings.append(Element(tag, attributes, tuple(children), inside, line, offset))

    def data(self, text: str, /) -> None:
        if self._open:
            self._open[-1].text.append(text)
