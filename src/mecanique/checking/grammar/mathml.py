"""Convert presentation MathML into text that the grammar reads."""

from __future__ import annotations

import re
from html.entities import html5
from xml.etree.ElementTree import Element

from mecanique.errors import FormulaError
from mecanique.safe_xml import XmlRefusedError, tree_of

_MOST_CHARACTERS = 200_000
_DOTS = {"˙": 1, "¨": 2, "⃛": 3, ".": 1, "..": 2, "\u0307": 1, "\u0308": 2}
_ENTITY = re.compile(r"&(\w{2,40});")
_OF_RATE = re.compile(r"[dⅆ](?P<order>[23])?(?P<word>[^\W\d]\w*)?")
_BY_TIME = re.compile(r"[dⅆ][23]?t[23]?")
_OF_XML = ("amp", "lt", "gt", "quot", "apos")
_START = re.compile(r"\s*<(?:\w+:)?(?:math|mrow|mtable|div|p)\b")


def is_mathml(text: str) -> bool:
    """Return whether a text is MathML, or a part of a page that contains MathML."""
    return bool(_START.match(text)) and "<" in text


def text_of(markup: str) -> str:
    """Convert formulas in MathML to plain text, one a line."""
    if len(markup) > _MOST_CHARACTERS:
        raise FormulaError(f"expected at most {_MOST_CHARACTERS:,} characters of MathML")
    try:
        root = tree_of(f"<formulas>{_ENTITY.sub(_name_entity, markup)}</formulas>")
    except XmlRefusedError as error:
        raise FormulaError(f"the MathML cannot be read, line {error.line}: {error}") from None
    formulas = [element for element in root.iter() if element.tag == "math"] or [root]
    return "\n".join(_write(element) for element in formulas)


def _name_entity(entity: re.Match[str]) -> str:
    """Replace an entity of HTML by its sign; leave those of XML."""
    return entity[0] if entity[1] in _OF_XML else html5.get(f"{entity[1]};", entity[0])


def _write(element: Element) -> str:
    parts = list(element)
    match element.tag:
        case "mi" | "mn" | "mo" | "mtext":
            return f" {(element.text or '').strip()} "
        case "math" | "mrow" | "mstyle" | "formulas" | "mpadded" | "div" | "p" | "semantics":
            inner = [_write(part) for part in parts if not part.tag.startswith("annotation")]
            return "".join(inner)
        case "mspace" | "mphantom":
            return " "
        case "mfrac" if len(parts) == 2 and (rate := _read_rate(*parts)):
            return rate
        case "mfrac" if len(parts) == 2:
            return f" (({_write(parts[0])})/({_write(parts[1])})) "
        case "msqrt":
            return f" sqrt({''.join(map(_write, parts))}) "
        case "msup" if len(parts) == 2:
            return f"{_write(parts[0]).rstrip()}^({_write(parts[1])}) "
        case "msub" if len(parts) == 2:
            return _write_letter(element)
        case "msubsup" if len(parts) == 3:
            return f"{_write_letter(element)}^({_write(parts[2])}) "
        case "mover" if len(parts) == 2:
            return _write_letter(element)
        case "mtable":
            rows = "; ".join(map(_write, parts))
            return f"[{rows}]"
        case "mtr":
            return ", ".join(_write(part) for part in parts)
        case "mtd":
            return "".join(map(_write, parts))
    raise FormulaError(f"the element {element.tag!r} of MathML is not known in a formula")


def _read_rate(above: Element, below: Element) -> str:
    """Return d/dt, d²/dt² or the derivative of a letter as text, "" if it is none of these."""
    upper, lower = ("".join("".join(part.itertext()).split()) for part in (above, below))
    derivative = _OF_RATE.fullmatch(upper)
    if not derivative or not _BY_TIME.fullmatch(lower):
        return ""
    order = int(derivative["order"] or 1)
    word = derivative["word"]
    return f" {word}{chr(39) * order} " if word else " d/dt" * order + " "


def _write_letter(element: Element) -> str:
    """Return a letter with dots and subscript as one word."""
    word, subscript, dots = _take_apart(element)
    return f" {word}{'_' + subscript if subscript else ''}{chr(39) * dots}"


def _take_apart(element: Element) -> tuple[str, str, int]:
    parts = list(element)
    if element.tag in ("msub", "msubsup"):
        word, _, dots = _take_apart(parts[0])
        below = re.sub(r"\W", "", "".join(parts[1].itertext()))
        return word, below, dots
    if element.tag == "mover":
        word, subscript, dots = _take_apart(parts[0])
        sign = "".join(parts[1].itertext()).strip()
        if sign not in _DOTS:
            raise FormulaError(f"the accent {sign!r} of MathML is not known in a formula")
        return word, subscript, dots + _DOTS[sign]
    return "".join(element.itertext()).strip(), "", 0
