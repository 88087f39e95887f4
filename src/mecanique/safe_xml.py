"""Read XML safely: within limits, and without document types and entities.

Through those an XML text can grow without bound or read other files; nothing here needs them.
"""

from __future__ import annotations

from typing import Literal, Protocol, TypeAlias, final
from xml.etree import ElementTree
from xml.parsers import expat

MOST_DEPTH = 64
"""Deepest nesting that is read; a URDF needs six levels, a COLLADA scene some more."""

MOST_ELEMENTS = 500_000
"""Most elements that are read, so that a small file cannot fill the memory."""

Reason: TypeAlias = Literal["malformed", "encoding", "entities", "limits"]


@final
class XmlRefusedError(Exception):
    """A text is not XML, or not XML that is safe to read.

    Args:
        reason: what kind of fault it is.
        line: where it is, counted from 1.
        message: what is wrong.
    """

    def __init__(self, reason: Reason, line: int, message: str) -> None:
        super().__init__(message)
        self.reason: Reason = reason
        self.line = line


class Receiver(Protocol):
    """Receives the parts of a text in their order."""

    def start(self, tag: str, attributes: dict[str, str], /) -> object:
        """Receive a start tag."""

    def end(self, tag: str, /) -> object:
        """Receive an end tag."""

    def data(self, text: str, /) -> object:
        """Receive text."""


@final
class Reader:
    """Feeds one XML text to a target.

    Args:
        target: receives its parts.
        encoding: of the text, if known from elsewhere than the text itself.
        most_depth: deepest nesting that is read.
        separator: between the namespace of a tag and its name; None to take prefixes as written.
    """

    def __init__(
        self,
        target: Receiver,
        *,
        encoding: str | None = None,
        most_depth: int = MOST_DEPTH,
        separator: str | None = None,
    ) -> None:
        self._target = target
        self._most_depth = most_depth
        self._depth = self._count = 0
        self._parser = expat.ParserCreate(encoding, separator)
        self._parser.buffer_text = True
        self._parser.StartElementHandler = self._start
        self._parser.EndElementHandler = self._end
        self._parser.CharacterDataHandler = target.data
        self._parser.StartDoctypeDeclHandler = self._refuse_entities
        self._parser.EntityDeclHandler = self._refuse_entities

    @property
    def line(self) -> int:
        """The line that is being read, counted from 1."""
        return self._parser.CurrentLineNumber

    @property
    def offset(self) -> int:
        """The byte of the text in UTF-8 that is being read."""
        return self._parser.CurrentByteIndex

    def read(self, raw: bytes) -> None:
        """Read a whole text."""
        try:
            self._parser.Parse(raw, True)
        except expat.ExpatError as error:
            binary = b"\0" in raw[:1000] and not raw.startswith((b"\xff\xfe", b"\xfe\xff"))
            fault = "it is binary, not text" if binary else expat.ErrorString(error.code)
            raise XmlRefusedError("malformed", error.lineno, fault) from None
        except (LookupError, ValueError) as error:
            raise XmlRefusedError("encoding", 1, str(error)) from None

    def _start(self, tag: str, attributes: dict[str, str]) -> None:
        self._depth += 1
        self._count += 1 + len(attributes)
        if self._depth > self._most_depth:
            self._refuse("limits", f"elements are nested more than {self._most_depth} deep")
        if self._count > MOST_ELEMENTS:
            self._refuse("limits", f"there are more than {MOST_ELEMENTS:,} elements and attributes")
        self._target.start(tag, attributes)

    def _end(self, tag: str) -> None:
        self._depth -= 1
        self._target.end(tag)

    def _refuse_entities(self, *_: object) -> None:
        self._refuse("entities", "a document type or entity is declared")

    def _refuse(self, reason: Reason, message: str) -> None:
        raise XmlRefusedError(reason, self.line, message)


def tree_of(data: bytes | str, *, most_depth: int = MOST_DEPTH) -> ElementTree.Element:
    """Return the root of an XML text; the tags are without their namespaces."""
    target = _WithoutNamespaces()
    encoding = "UTF-8" if isinstance(data, str) else None
    reader = Reader(target, encoding=encoding, most_depth=most_depth, separator="}")
    try:
        raw = data.encode() if isinstance(data, str) else data
    except UnicodeEncodeError as error:
        line = str(data)[: error.start].count("\n") + 1
        raise XmlRefusedError("encoding", line, "half of a pair of signs (a surrogate)") from None
    reader.read(raw)
    return target.builder.close()


@final
class _WithoutNamespaces:
    """Builds a tree."""

    def __init__(self) -> None:
        self.builder: ElementTree.TreeBuilder = ElementTree.TreeBuilder()
        self.data = self.builder.data

    def start(self, tag: str, attributes: dict[str, str], /) -> None:
        self.builder.start(tag.rpartition("}")[2], attributes)

    def end(self, tag: str, /) -> None:
        self.builder.end(tag.rpartition("}")[2])
