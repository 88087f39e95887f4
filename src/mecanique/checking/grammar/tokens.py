"""Collect the tokens of a text: letters by name, numbers and signs."""

from __future__ import annotations

import re
from dataclasses import dataclass
from difflib import get_close_matches
from typing import final

from mecanique.checking.budget import spend
from mecanique.checking.grammar.letters import SPELLINGS, Letters
from mecanique.checking.grammar.signs import normalize
from mecanique.checking.grammar.tree import FUNCTIONS
from mecanique.errors import FormulaError

LETTER = r"\\?[^\W\d_]+(?:_?\{?[^\W_]*\}?)?"
"""A letter with its subscript, in text or LaTeX, as a regular expression."""

MOST_BRACKETS = 40
"""Deepest nesting of brackets."""

MOST_IN_WORD = 200
"""Longest word, also of letters written without spaces."""

_LONG = re.compile(rf"(?<!\d)[^\W\d]\w{{{MOST_IN_WORD}}}")
_PRIMES = re.compile(r"\s?'+|\^\{?(?:\s*\\prime)+\s*\}?")
_OF_TIME = re.compile(
    r"\s*(?P<brace>\{)?\s*(?:\\left)?\s*\(\s*t\s*(?:\\right)?\s*\)(?(brace)\s*\})"
)

OPEN, CLOSE = {"LPAR", "LSQB", "LBRACE"}, {"RPAR", "RSQB", "RBRACE"}
"""Kinds of brackets."""

SINGLE = {
    "+": "PLUS",
    "-": "MINUS",
    "*": "TIMES",
    "/": "OVER",
    "^": "POWER",
    "=": "EQUALS",
    "(": "LPAR",
    ")": "RPAR",
    "[": "LSQB",
    "]": "RSQB",
    "{": "LBRACE",
    "}": "RBRACE",
    ",": "COMMA",
    ";": "SEMICOLON",
}
"""The kind of each sign that is a token by itself."""

OPERATORS = {"PLUS", "MINUS", "TIMES", "OVER", "POWER", "EQUALS"}
"""Kinds of tokens that a line cannot end with."""


@final
@dataclass(frozen=True)
class Token:
    """A piece of a formula.

    Args:
        kind: e.g. "NAME", "NUMBER", "PLUS".
        value: the letter's name, the number or the sign.
        start: its first position in the text.
        end: the position after it.
    """

    kind: str
    value: str
    start: int
    end: int


@final
class Tokens:
    """The tokens found in one text so far.

    Args:
        text: the formula.
        letters: the letters that it may contain.
    """

    def __init__(self, text: str, letters: Letters) -> None:
        self.letters = letters
        self.found: list[Token] = []
        self.unknown: dict[str, int] = {}
        self.tables = 0
        self.depth = 0
        self._text = text
        self.plain, self._places = normalize(text)
        if long := _LONG.search(self.plain):
            raise self.explain(
                f"a word of more than {MOST_IN_WORD} signs; write spaces between the letters",
                long.start(),
            )

    def put_sign(self, sign: str, at: int) -> int:
        """Add a sign that is a token by itself; return the position after it."""
        return self.put(SINGLE[sign], sign, at, at + 1)

    def put(self, kind: str, value: str, start: int, end: int) -> int:
        """Add a token; return the position after it."""
        self.depth += (kind in OPEN) - (kind in CLOSE)
        if self.depth > MOST_BRACKETS:
            raise self.explain(f"brackets are nested more than {MOST_BRACKETS} deep", start)
        self.found.append(Token(kind, value, self._places[start], self.place_after(end)))
        return end

    def put_word(self, word: str, at: int, end: int) -> int:
        """Read a word, with the primes after it, as a letter, a function or several of them."""
        text = self.plain
        primes = _PRIMES.match(text, end)
        dots = _count_primes(primes) if primes else 0
        if primes and dots:
            end = primes.end()
        name = self.letters.find(word + "'" * dots)
        if name is not None:
            self.put("NAME", name, at, end)
            kind = self.letters.kinds[name]
            of_time = _OF_TIME.match(text, end)
            if of_time and kind in ("coordinate", "velocity", "acceleration", "input"):
                end = of_time.end()
                if (after := _PRIMES.match(text, end)) and _count_primes(after):
                    self.found.pop()
                    return self.put_word(word + "'" * _count_primes(after), at, after.end())
            return end
        if not dots and word in ("Eq", "Matrix", "Rational", "Derivative"):
            return self.put("SYMPY", word, at, end)
        function = SPELLINGS.get(word, word)
        if not dots and function in FUNCTIONS:
            return self.put("FUNCTION", function, at, end)
        pieces = self._split(word, dots)
        if pieces is None and not dots and (rate := self._find_rate(word)):
            return self.put("NAME", rate, at, end)
        if pieces is None:
            self.unknown.setdefault(word + "'" * dots, at)
            self.put("NAME", word, at, end)
            return end
        for k, (piece, start, stop) in enumerate(pieces):
            last = k == len(pieces) - 1
            place = (at + start, end if last else at + stop)
            if piece.isdigit():
                self.put("NUMBER", piece, *place)
            elif piece in FUNCTIONS:
                self.put("FUNCTION", piece, *place)
            else:
                self.put("NAME", piece, *place)
        return end

    def _find_rate(self, word: str) -> str | None:
        """Return the rate that a word such as dq or ddq denotes, if any."""
        for prefix, primes in (("dd", "''"), ("d", "'")):
            stem = self.letters.find(word.removeprefix(prefix)) if word.startswith(prefix) else None
            if stem is not None and stem in self.letters.rates:
                return self.letters.find(stem + primes)
        return None

    def _split(self, word: str, dots: int) -> list[tuple[str, int, int]] | None:
        """Split letters written without spaces, as in mgl; return None if a part is unknown."""
        spots = [k for k, sign in enumerate(word) if sign != "_"]
        whole = word.replace("_", "")
        best: list[list[tuple[str, int, int]] | None] = [None] * len(whole) + [[]]
        for first in range(len(whole) - 1, -1, -1):
            spend()
            for last in range(min(len(whole), first + self.letters.longest), first, -1):
                rest = best[last]
                if rest is None:
                    continue
                piece = whole[first:last]
                own = "'" * dots if last == len(whole) else ""
                name = self._meaning(piece, own, whole[last : last + 1])
                if name is not None:
                    place = (name, spots[first], spots[last - 1] + 1)
                    best[first] = [place, *rest]
                    break
        return best[0]

    def _meaning(self, piece: str, dots: str, following: str) -> str | None:
        name = self.letters.by_key.get(piece + dots) or self.letters.find(piece + dots)
        if name is not None:
            return name
        function = SPELLINGS.get(piece, piece)
        if function in FUNCTIONS and not dots and len(piece) > 2 and following:
            return function
        return None

    def is_moving(self, word: str) -> bool:
        """Return whether a word is a letter with a rate."""
        name = self.letters.find(clean(word))
        return name is not None and name in self.letters.rates

    def put_derivative(self, word: str, order: int, found: re.Match[str]) -> int:
        """Add a letter's time derivative; return the position after it."""
        return self.put_word(clean(word) + "'" * order, found.start(), found.end())

    def explain_unknown(self) -> FormulaError:
        """Return an error that names the unknown letters."""
        names = list(self.unknown)
        known = [name for name in self.letters.kinds if "'" not in name]
        hints = []
        for name in names[:6]:
            near = get_close_matches(name.rstrip("'"), known, n=1, cutoff=0.6) or [
                other for other in known if other.lower() == name.rstrip("'").lower()
            ]
            hints.append(f"{name!r}" + (f" (did you mean {near[0]!r}?)" if near else ""))
        listed = ", ".join(sorted(known))
        several = len(names) > 1
        message = (
            f"unknown letter{'s' if several else ''} {', '.join(hints)}; the letters of this "
            f"system are {listed}. Say what {'others mean' if several else 'it means'}, e.g. "
            f'--let "{names[0].rstrip(chr(39))} = …"'
        )
        return self.explain(message, self.unknown[names[0]], names)

    def place_after(self, at: int) -> int:
        """Return the position in the text after the sign before a position."""
        return self._places[at - 1] + 1

    def explain(self, message: str, at: int, unknown: list[str] | None = None) -> FormulaError:
        """Return an error at a position."""
        place = self._places[min(at, len(self._places) - 1)] if self._places else 0
        return FormulaError(message, self._text, place, unknown or ())


def clean(word: str) -> str:
    """Return a letter's name without LaTeX's markup and without (t)."""
    return re.sub(r"[\\{}\s]|\(t\)", "", word)


def _count_primes(primes: re.Match[str]) -> int:
    """Return the number of derivatives that primes denote."""
    return primes[0].count("'") + primes[0].count("\\prime")
