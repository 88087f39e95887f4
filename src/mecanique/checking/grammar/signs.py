"""Unify the spelling of signs: Unicode's dots, powers and subscripts, minus signs, fonts."""

from __future__ import annotations

import re
import unicodedata

_SIGNS = {
    "−": "-",
    "–": "-",
    "·": "*",
    "×": "*",
    "⋅": "*",
    "∙": "*",
    "∗": "*",
    "÷": "/",
    "∕": "/",
    "⁄": "/",
    "′": "'",
    "’": "'",
    "″": "''",
    "”": "''",
    '"': "''",
    "‴": "'''",
    "√": " sqrt ",
    "ℓ": "l",
    "ⅆ": "d",
    "ϑ": "theta",
    "ϕ": "phi",
    "ε": "epsilon",
    "∂": "∂",
    "½": "(1/2)",
    "⅓": "(1/3)",
    "⅔": "(2/3)",
    "¼": "(1/4)",
    "¾": "(3/4)",
    "\u2061": " ",
    "\u2062": " ",
    "\u2063": " ",
    "\u00a0": " ",
    "\u2009": " ",
    "\u200b": " ",
    "\ufeff": " ",
    "≡": "=",
    "≔": "=",
}
_RAISED = dict(zip("⁰¹²³⁴⁵⁶⁷⁸⁹⁻", "0123456789-", strict=True))
_LOWERED = dict(zip("₀₁₂₃₄₅₆₇₈₉", "0123456789", strict=True))
_DOTS = {"\u0307": "'", "\u0308": "''", "\u20db": "'''"}

_NUMBERED = re.compile(r"^[^\S\n]*\(?(\d{1,2})\)[^\S\n]+(?=\S)", re.MULTILINE)
_BOX = re.compile(r"\\(?:boxed|fbox|ensuremath)\s*\{")
_FONT = re.compile(
    r"\\(?:mathrm|mathit|mathbf|mathsf|text|textrm|operatorname\*?|boldsymbol|bm)\s*"
    r"\{\s*(?P<word>(?:[A-Za-z0-9]|\\?_)+)\s*\}"
)


def normalize(text: str) -> tuple[str, list[int]]:
    """Return a text with unified signs, and the original position of each sign."""
    signs: list[str] = []
    places: list[int] = []

    def put(some: str, place: int) -> None:
        signs.extend(some)
        places.extend([place] * len(some))

    raised = False
    for place, original in enumerate(text):
        if original in _RAISED:
            put(("" if raised else "^") + _RAISED[original], place)
            raised = True
            continue
        raised = False
        if original in _LOWERED:
            # the dots of a letter, three at most, come after its subscript
            dots = len(signs)
            while dots and len(signs) - dots < 3 and signs[dots - 1] == "'":
                dots -= 1
            signs.insert(dots, _LOWERED[original])
            places.insert(dots, place)
        elif original in _SIGNS:
            put(_SIGNS[original], place)
        elif original in "\r\x0b\x0c\u2028\u2029\x85":
            put("\n", place)
        else:
            for sign in unicodedata.normalize("NFD", original):
                put(_DOTS.get(sign, sign), place)
    signs, places = _drop_spaces(signs, places)
    return _drop_fonts(_drop_numbers(_open_boxes("".join(signs))), places)


def _drop_spaces(signs: list[str], places: list[int]) -> tuple[list[str], list[int]]:
    """Keep one sign of each run of spaces, a line end if there is one.

    Patterns with several optional spaces would otherwise try every way to share a run among them.
    """
    kept: list[str] = []
    where: list[int] = []
    for sign, place in zip(signs, places, strict=True):
        if not (sign.isspace() and kept and kept[-1].isspace()):
            kept.append(sign)
            where.append(place)
        elif sign == "\n":
            kept[-1] = sign
    return kept, where


def _drop_numbers(plain: str) -> str:
    """Replace line numbers by spaces, if they count from 1 on."""
    found = list(_NUMBERED.finditer(plain))
    lines = sum(1 for line in plain.split("\n") if line.strip())
    if [int(one[1]) for one in found] != list(range(1, lines + 1)):
        return plain
    for one in found:
        plain = plain[: one.start()] + " " * len(one[0]) + plain[one.end() :]
    return plain


def _open_boxes(plain: str) -> str:
    """Replace the braces of LaTeX's boxes by spaces."""
    signs = list(plain)
    boxes = {found.end() - 1 for found in _BOX.finditer(plain)}
    for found in _BOX.finditer(plain):
        signs[found.start() : found.end()] = " " * len(found[0])
    opened: list[int] = []
    for at, sign in enumerate(plain):
        if sign == "{":
            opened.append(at)
        elif sign == "}" and opened and opened.pop() in boxes:
            signs[at] = " "
    return "".join(signs)


def _drop_fonts(plain: str, places: list[int]) -> tuple[str, list[int]]:
    """Remove LaTeX's font commands, keeping the words in them."""
    kept: list[int] = []
    end = 0
    for found in _FONT.finditer(plain):
        first, last = found.span("word")
        # the backslash of the command becomes a space, as letters may touch it
        kept += [*range(end, found.start()), -1]
        kept += [k for k in range(first, last) if plain[k] != "\\"]
        end = found.end()
    kept += range(end, len(plain))
    if end == 0:
        return plain, places
    signs = [plain[k] if k >= 0 else " " for k in kept]
    where = [places[max(k, 0)] for k in kept]
    return "".join(signs), where
