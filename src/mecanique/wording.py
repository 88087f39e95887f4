"""Words that depend on numbers, and tables of them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol, final

_SHORT = 6
"""Numbers that are printed; of more the range is told."""


OF_SHAPES = "`mecanique inertia FILE --density 1000 -o NEW` takes them from shapes"
"""Where mass and inertia may be had from."""


class _Printer(Protocol):
    def text(self, written: str) -> None: ...

    def break_(self) -> None: ...


class Legible:
    """A result that a notebook prints as `str` does, and that `repr` names by its first line."""

    def __str__(self) -> str:
        described = getattr(self, "__dataclass_fields__", {})
        lines = []
        for name, value in vars(self).items():
            empty = value is None or (isinstance(value, (str, tuple)) and not value)
            hidden = name.startswith("_") or (name in described and not described[name].repr)
            if not (empty or hidden):
                lines.append(f"{name}: {write_value(value)}")
        return "\n".join(lines)

    def __repr__(self) -> str:
        return f"<{type(self).__name__}: {self._caption}>"

    @property
    def _caption(self) -> str:
        """What it is in one line: the first one, or all where they are its fields."""
        lines = str(self).splitlines()
        listed = type(self).__str__ is Legible.__str__
        return "; ".join(lines) if listed else lines[0]

    def _repr_pretty_(self, printer: _Printer, cycle: bool) -> None:
        """Print it line by line, within a tuple or a mapping as well."""
        first, *others = str(self).splitlines()
        printer.text(first)
        for line in others:
            printer.break_()
            printer.text(line)


def name_fields(answer: Any) -> str:
    """Return a named tuple in a line; its `__repr__`, as it can have no other base."""
    fields = (f"{name}: {write_value(value)}" for name, value in answer._asdict().items())
    return f"<{type(answer).__name__}: {'; '.join(fields)}>"


@final
class LegibleText(Legible, str):
    """Text that a notebook prints line by line; a string in everything else."""

    __str__ = str.__str__
    __repr__ = str.__repr__


def write_value(value: Any) -> str:
    """Return a value as one reads it: few numbers one by one, many by their shape and range."""
    import numpy as np

    if not isinstance(value, np.ndarray):
        return str(value)
    if value.size <= _SHORT:
        return np.array2string(value + 0.0, precision=6, separator=", ")  # no minus zero
    return f"shape {value.shape}, {value.min():.6g} … {value.max():.6g}"


def to_title(name: str) -> str:
    """Return a name as a title: "heavy_top" as "Heavy top"."""
    words = name.replace("_", " ")
    return words[:1].upper() + words[1:]


def say_count(count: int, noun: str, plural: str = "") -> str:
    """Return a count with its noun: "1 state", "2 states", "3 bodies"."""
    return f"{count} {noun if count == 1 else plural or f'{noun}s'}"


def enumerate_words(words: Sequence[str]) -> str:
    """Join words into an enumeration, the last after "and"."""
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} and {words[-1]}"


def write_table(caption: str, rows: Sequence[Sequence[str]]) -> str:
    """Return a table in HTML, for notebooks."""
    from html import escape

    lines = []
    for tag, cells in zip(["th", *["td"] * (len(rows) - 1)], rows, strict=True):
        inner = "".join(f"<{tag}>{escape(cell)}</{tag}>" for cell in cells)
        lines.append(f"<tr>{inner}</tr>")
    return f"<table><caption>{escape(caption)}</caption>{''.join(lines)}</table>"
