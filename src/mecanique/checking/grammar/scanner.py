"""Cut a formula into tokens, whether it is plain text, LaTeX or SymPy's text."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterator
from dataclasses import dataclass
from difflib import get_close_matches
from typing import final

from mecanique.checking.grammar.letters import SPELLINGS, Letters
from mecanique.checking.grammar.tree import FUNCTIONS
from mecanique.errors import FormulaError

__all__ = ["MOST_CHARACTERS", "Scanner", "Token", "scan"]

MOST_CHARACTERS = 20_000
"""Longest text that is read."""

MOST_TOKENS = 4_000
"""Most tokens of a text."""

MOST_BRACKETS = 40
"""Deepest nesting of brackets."""

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
    "√": "sqrt ",
    "ℓ": "l",
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

_NUMBER = re.compile(r"(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?")
_WORD = re.compile(r"[^\W\d_](?:[^\W_]|_(?=[^\W_])|_\{[^{}]{1,20}\})*")
_PRIMES = re.compile(r"\s?'+|\^\{?(?:\s*\\prime)+\s*\}?")
_COMMAND = re.compile(r"\\(?:[A-Za-z]+|.)", re.DOTALL)
_OF_TIME = re.compile(r"\s*\(\s*t\s*\)")
_LETTER = r"\\?[^\W\d_]+(?:_?\{?[^\W_]*\}?)?"
_INNER = rf"(?P<word>{_LETTER})(?:\(\s*t\s*\))?"
_DERIVATIVE = re.compile(
    rf"(?:Derivative|diff)\(\s*{_INNER}\s*,\s*"
    r"(?P<by>\(\s*t\s*,\s*[123]\s*\)|t\s*,\s*[123]|t(?:\s*,\s*t)*)\s*\)"
)
_METHOD = re.compile(r"\.diff\(\s*(?P<by>t\s*,\s*[123]|t(?:\s*,\s*t)*)\s*\)")
_LEIBNIZ = re.compile(
    rf"d\s*(?:\^?\s*(?P<order>[23])\s*)?{_INNER}\s*/\s*"
    r"d\s*t(?:\s*(?:\^|\*\*)?\s*(?P<again>[23]))?(?!\w)"
)
_D = r"(?:\\mathrm\s*\{\s*d\s*\}|\\text\s*\{\s*d\s*\}|d)"
_FRACTION = re.compile(
    rf"\\[dt]?frac\s*\{{\s*{_D}\s*(?:\^\s*\{{?\s*(?P<order>[23])\s*\}}?)?\s*(?P<word>{_LETTER})?\s*"
    rf"\}}\s*\{{\s*{_D}\s*\\?,?\s*t\s*(?:\^\s*\{{?\s*[23]\s*\}}?)?\s*\}}"
)
_D_BY_DT = re.compile(r"d\s*/\s*d\s*t(?!\w)")
_DOT = re.compile(
    r"\\(?P<dots>d{1,3})ot\s*(?:\{\s*(?P<inner>[^{}]*(?:\{[^{}]*\}[^{}]*)?)\}|(?P<word>\\?[A-Za-z]))"
    r"(?P<subscript>\s*_\s*(?:\{[^{}]{1,20}\}|\w))?"
)
_FONT = re.compile(
    r"\\(?:mathrm|mathit|mathbf|mathsf|text|textrm|operatorname\*?|boldsymbol|bm)\s*"
    r"\{\s*(?P<word>(?:[A-Za-z0-9]|\\?_)+)\s*\}"
)
_SUBSCRIPT = re.compile(r"\s*_\s*(?:\{(?P<long>[^{}]{1,40})\}|(?P<short>\\?[A-Za-z]+|\d))")
_ENVIRONMENT = re.compile(r"\\(?P<which>begin|end)\s*\{\s*(?P<name>[a-z]+)\*?\s*\}(?:\{[lcr|]*\})?")
_TABLES = {"matrix", "pmatrix", "bmatrix", "vmatrix", "smallmatrix", "Bmatrix"}
_IGNORED = re.compile(
    r"\\(?:left|right|[bB]igg?[lrm]?|displaystyle|textstyle|nonumber|notag|limits|quad|qquad|,|;|:|!"
    r"| |>|\(|\)|\[|\]|hspace\{[^{}]*\}|label\{[^{}]*\}|tag\*?\{[^{}]*\})(?![A-Za-z])\s*\.?"
)
_SPACING = re.compile(r"\\(?:,|;|:|!| |>|\(|\)|\[|\])")
_OPEN, _CLOSE = {"LPAR", "LSQB", "LBRACE"}, {"RPAR", "RSQB", "RBRACE"}
_SINGLE = {
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
_OPERATORS = {"PLUS", "MINUS", "TIMES", "OVER", "POWER", "EQUALS"}
_REMEDIES = {
    "|": "write abs(…) for a magnitude",
    "<": "write an equation with =",
    ">": "write an equation with =",
    "!": "factorials have no place in a formula of mechanics",
    ":": "write an equation with =",
    "%": "write a number",
    "∂": "write partial derivatives out",
    "∫": "write integrals out",
}


@final
@dataclass(frozen=True)
class Token:
    """A piece of a formula.

    Args:
        kind: e.g. "NAME", "NUMBER", "PLUS".
        value: the letter's name, the number or the sign.
        start: where it begins in the text.
        end: where it ends.
    """

    kind: str
    value: str
    start: int
    end: int


def scan(text: str, letters: Letters) -> list[Token]:
    """Return the tokens of a text.

    Args:
        text: plain text, LaTeX or SymPy's text.
        letters: what its letters may stand for.

    Raises:
        FormulaError: if it is too long, or holds a sign or letter that is not known; all unknown
            letters are named at once.
    """
    if len(text) > MOST_CHARACTERS:
        raise FormulaError(
            f"expected at most {MOST_CHARACTERS:,} characters in a formula, got {len(text):,}"
        )
    return Scanner(text, letters).tokens()


@final
class Scanner:
    """Reads one text.

    Args:
        text: the formula.
        letters: what its letters may stand for.
    """

    def __init__(self, text: str, letters: Letters) -> None:
        self._text = text
        self._letters = letters
        self._plain, self._places = _normalize(text)
        self._found: list[Token] = []
        self._unknown: dict[str, int] = {}
        self._tables = 0
        self._depth = 0

    def tokens(self) -> list[Token]:
        """Return the tokens."""
        at = 0
        while at < len(self._plain):
            at = self._next(at)
            if len(self._found) > MOST_TOKENS:
                raise self._error(f"the formula has more than {MOST_TOKENS:,} signs", at)
        if self._unknown:
            raise self._explain_unknown()
        return list(_close_arguments(_join_lines(self._found), self._letters, self._text))

    def _next(self, at: int) -> int:
        """Read what stands at a place; return where to go on."""
        text = self._plain
        sign = text[at]
        if sign == "\n":
            return self._put("NEWLINE", "\n", at, at + 1)
        if sign.isspace() or sign in "$~":
            return at + 1
        if sign == "\\":
            return self._command(at)
        if sign == "&":
            return self._put("COMMA", ",", at, at + 1) if self._tables else at + 1
        if found := _NUMBER.match(text, at):
            return self._put("NUMBER", found[0], at, found.end())
        if sign.isalpha():
            return self._word(at)
        if text.startswith("**", at):
            return self._put("POWER", "^", at, at + 2)
        if text.startswith(":=", at) or text.startswith("==", at):
            return self._put("EQUALS", "=", at, at + 2)
        if sign == "'" and self._found and self._found[-1].kind == "RPAR":
            return self._put("PRIME", "'", at, at + 1)
        if found := _METHOD.match(text, at):
            return self._method(found)
        if sign in _SINGLE:
            return self._single(sign, at)
        if sign in ".…" and not text[at:].strip(" .…\n"):
            return at + 1
        remedy = _REMEDIES.get(sign, "expected letters, numbers and + - * / ^ ( ) =")
        raise self._error(f"{sign!r} has no meaning here; {remedy}", at)

    def _single(self, sign: str, at: int) -> int:
        kind = _SINGLE[sign]
        self._depth += (kind in _OPEN) - (kind in _CLOSE)
        if self._depth > MOST_BRACKETS:
            raise self._error(f"brackets are nested more than {MOST_BRACKETS} deep", at)
        return self._put(kind, sign, at, at + 1)

    def _put(self, kind: str, value: str, start: int, end: int) -> int:
        places = self._places
        self._found.append(Token(kind, value, places[start], places[end - 1] + 1))
        return end

    def _word(self, at: int) -> int:
        text = self._plain
        if found := _DERIVATIVE.match(text, at):
            return self._derivative(found["word"], _order(found["by"]), found)
        if found := _D_BY_DT.match(text, at):
            return self._put("RATE", "d/dt", at, found.end())
        if (found := _LEIBNIZ.match(text, at)) and self._is_moving(found["word"]):
            return self._derivative(found["word"], int(found["order"] or 1), found)
        found = _WORD.match(text, at)
        assert found is not None
        word, end = re.sub(r"[{}\\\s]", "", found[0]), found.end()
        return self._name(word, at, end)

    def _name(self, word: str, at: int, end: int) -> int:
        """Read a word, with the primes after it, as a letter, a function or several of them."""
        text = self._plain
        primes = _PRIMES.match(text, end)
        dots = _count(primes) if primes else 0
        if primes and dots:
            end = primes.end()
        name = self._letters.find(word + "'" * dots)
        if name is not None:
            self._put("NAME", name, at, end)
            kind = self._letters.kinds[name]
            of_time = _OF_TIME.match(text, end)
            if of_time and kind in ("coordinate", "velocity", "acceleration", "input"):
                end = of_time.end()
                if (after := _PRIMES.match(text, end)) and _count(after):
                    self._found.pop()
                    return self._name(word + "'" * _count(after), at, after.end())
            return end
        if not dots and word in ("Eq", "Matrix", "Rational", "Derivative"):
            return self._put("SYMPY", word, at, end)
        function = SPELLINGS.get(word, word)
        if not dots and function in FUNCTIONS:
            return self._put("FUNCTION", function, at, end)
        pieces = self._split(word, dots)
        if pieces is None:
            self._unknown.setdefault(word + "'" * dots, at)
            self._put("NAME", word, at, end)
            return end
        for k, (piece, start, stop) in enumerate(pieces):
            last = k == len(pieces) - 1
            place = (at + start, end if last else at + stop)
            if piece.isdigit():
                self._put("NUMBER", piece, *place)
            elif piece in FUNCTIONS:
                self._put("FUNCTION", piece, *place)
            else:
                self._put("NAME", piece, *place)
        return end

    def _split(self, word: str, dots: int) -> list[tuple[str, int, int]] | None:
        """Cut letters written without a space, as in mgl; None if some part is not known."""
        spots = [k for k, sign in enumerate(word) if sign != "_"]
        bare = word.replace("_", "")
        best: list[list[tuple[str, int, int]] | None] = [None] * len(bare) + [[]]
        for first in range(len(bare) - 1, -1, -1):
            for last in range(min(len(bare), first + self._letters.longest), first, -1):
                rest = best[last]
                if rest is None:
                    continue
                piece = bare[first:last]
                own = "'" * dots if last == len(bare) else ""
                name = self._meaning(piece, own, bare[last : last + 1])
                if name is not None:
                    place = (name, spots[first], spots[last - 1] + 1)
                    best[first] = [place, *rest]
                    break
        return best[0]

    def _meaning(self, piece: str, dots: str, following: str) -> str | None:
        name = self._letters.by_key.get(piece + dots) or self._letters.find(piece + dots)
        if name is not None:
            return name
        function = SPELLINGS.get(piece, piece)
        if function in FUNCTIONS and not dots and len(piece) > 2 and following:
            return function
        return None

    def _is_moving(self, word: str) -> bool:
        name = self._letters.find(_bare(word))
        return name is not None and name in self._letters.rates

    def _derivative(self, word: str, order: int, found: re.Match[str]) -> int:
        return self._name(_bare(word) + "'" * order, found.start(), found.end())

    def _method(self, found: re.Match[str]) -> int:
        """Read q(t).diff(t)."""
        before = self._found[-1] if self._found else None
        if before is None or before.kind != "NAME":
            raise self._error("expected a coordinate before .diff, e.g. q.diff(t)", found.start())
        name = self._letters.by_key.get(before.value + "'" * _order(found["by"]))
        if before.value in self._unknown:
            return found.end()
        if name is None:
            raise self._error(f"{before.value!r} has no derivative by t", found.start())
        self._found[-1] = Token("NAME", name, before.start, self._places[found.end() - 1] + 1)
        return found.end()

    def _command(self, at: int) -> int:
        """Read a command of LaTeX."""
        text = self._plain
        if text.startswith("\\\\", at):
            skip = re.compile(r"\\\\\s*(?:\[[^\]\n]{0,10}\])?").match(text, at)
            assert skip is not None
            kind = "SEMICOLON" if self._tables else "NEWLINE"
            return self._put(kind, ";", at, skip.end())
        if found := _FRACTION.match(text, at):
            return self._fraction_of_time(found)
        if found := _DOT.match(text, at):
            return self._read_dots(found)
        if found := _ENVIRONMENT.match(text, at):
            return self._environment(found)
        if found := _IGNORED.match(text, at):
            # "\left." opens nothing; elsewhere a dot after a space ends a sentence
            return found.end()
        if found := _SPACING.match(text, at):
            return found.end()
        found = _COMMAND.match(text, at)
        if found is None:
            raise self._error("a backslash at the end has no meaning", at)
        return self._plain_command(found)

    def _plain_command(self, found: re.Match[str]) -> int:
        name, at, end = found[0][1:], found.start(), found.end()
        if name in ("cdot", "times", "ast"):
            return self._put("TIMES", "*", at, end)
        if name in ("div", "over"):
            return self._put("OVER", "/", at, end)
        if name in ("frac", "dfrac", "tfrac"):
            self._put("FRACTION", "frac", at, end)
            return self._brace(self._brace(end))
        if name in ("lvert", "rvert", "vert", "mid"):
            raise self._error("write abs(…) for a magnitude", at)
        function = SPELLINGS.get(name, name)
        if function == "sqrt" and self._plain.startswith("[", end):
            raise self._error("write other roots than the square root as powers", at)
        if function in FUNCTIONS:
            self._put("FUNCTION", function, at, end)
            return end
        if name in ("{", "}"):
            return self._single("(" if name == "{" else ")", at) + 1
        if not name.isalpha():
            raise self._error(f"the command \\{name} has no meaning in a formula", at)
        subscript, end = self._subscript(end)
        return self._name(name + subscript, at, end)

    def _subscript(self, at: int) -> tuple[str, int]:
        """Return the subscript at a place, and where to go on."""
        found = _SUBSCRIPT.match(self._plain, at)
        if not found:
            return "", at
        return re.sub(r"[\\\s,{}]", "", found["long"] or found["short"]), found.end()

    def _brace(self, at: int) -> int:
        """Put braces around an argument of a fraction that has none, as the 1 and 2 of frac12."""
        text = self._plain
        while at < len(text) and text[at].isspace():
            at += 1
        if at >= len(text) or text[at] == "{":
            if at >= len(text):
                raise self._error("expected two arguments in braces after \\frac", at - 1)
            return self._read_braces(at)
        if text[at].isdigit():
            self._put("LBRACE", "{", at, at + 1)
            self._put("NUMBER", text[at], at, at + 1)
            self._put("RBRACE", "}", at, at + 1)
            return at + 1
        if text[at].isalpha() or text[at] == "\\":
            self._put("LBRACE", "{", at, at + 1)
            end = self._command(at) if text[at] == "\\" else self._name(text[at], at, at + 1)
            self._put("RBRACE", "}", end - 1, end)
            return end
        raise self._error("expected an argument in braces after \\frac", at)

    def _read_braces(self, at: int) -> int:
        """Read an argument in braces to its end."""
        depth = self._depth
        at = self._next(at)
        while at < len(self._plain) and self._depth > depth:
            at = self._next(at)
        if self._depth > depth:
            raise self._error("a brace is not closed", len(self._plain) - 1)
        return at

    def _fraction_of_time(self, found: re.Match[str]) -> int:
        order = int(found["order"] or 1)
        if found["word"]:
            if not self._is_moving(found["word"]):
                self._put("FRACTION", "frac", found.start(), found.start() + 5)
                at = self._plain.index("{", found.start())
                return self._read_braces(self._plain.index("{", self._read_braces(at)))
            return self._derivative(found["word"], order, found)
        for _ in range(order):
            self._put("RATE", "d/dt", found.start(), found.end())
        return found.end()

    def _read_dots(self, found: re.Match[str]) -> int:
        inner = (found["inner"] or found["word"] or "").strip()
        word = _bare(inner) + re.sub(r"[\\\s_{},]", "", found["subscript"] or "")
        if not word.isalnum():
            raise self._error(
                "expected a single letter below the dots, e.g. \\ddot{\\theta}_1; write d/dt "
                "before brackets",
                found.start(),
            )
        return self._name(word + "'" * len(found["dots"]), found.start(), found.end())

    def _environment(self, found: re.Match[str]) -> int:
        if found["name"] in _TABLES:
            opens = found["which"] == "begin"
            self._tables += 1 if opens else -1
            self._depth += 1 if opens else -1
            kind = "LSQB" if opens else "RSQB"
            return self._put(kind, "[" if opens else "]", found.start(), found.end())
        return found.end()

    def _explain_unknown(self) -> FormulaError:
        names = list(self._unknown)
        known = [name for name in self._letters.kinds if "'" not in name]
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
        return self._error(message, self._unknown[names[0]], names)

    def _error(self, message: str, at: int, unknown: list[str] | None = None) -> FormulaError:
        place = self._places[min(at, len(self._places) - 1)] if self._places else 0
        return FormulaError(message, self._text, place, unknown or ())


def _normalize(text: str) -> tuple[str, list[int]]:
    """Return a text with one spelling of each sign, and the place each sign comes from."""
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
            # dots of a letter stand after its subscript
            dots = len(signs)
            while dots and signs[dots - 1] == "'":
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
    return _drop_fonts("".join(signs), places)


def _drop_fonts(plain: str, places: list[int]) -> tuple[str, list[int]]:
    """Return a text without commands for upright and other letters: their words alone."""
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


def _bare(word: str) -> str:
    return re.sub(r"[\\{}\s]|\(t\)", "", word)


def _order(by: str) -> int:
    digits = re.findall(r"[123]", by)
    return int(digits[0]) if digits else by.count("t")


def _count(primes: re.Match[str]) -> int:
    return primes[0].count("'") + primes[0].count("\\prime")


def _join_lines(tokens: list[Token]) -> list[Token]:
    """Drop ends of lines within an equation; let every other one, and ; and , separate."""
    lines: list[list[Token]] = [[]]
    depth = 0
    for token in tokens:
        depth = max(0, depth + (token.kind in _OPEN) - (token.kind in _CLOSE))
        if depth == 0 and token.kind in ("NEWLINE", "SEMICOLON", "COMMA"):
            lines.append([])
        elif token.kind != "NEWLINE":
            lines[-1].append(token)
    joined: list[list[Token]] = []
    for line in filter(None, lines):
        equation = any(token.kind == "EQUALS" for token in line)
        before = joined[-1][-1].kind if joined else ""
        first = line[0].kind
        goes_on = before in _OPERATORS or first in ("EQUALS", "TIMES", "OVER", "POWER")
        whole = bool(joined) and any(token.kind == "EQUALS" for token in joined[-1])
        goes_on = goes_on or (first in ("PLUS", "MINUS") and not (equation and whole))
        if joined and goes_on:
            joined[-1] += line
        else:
            joined.append(list(line))
    out: list[Token] = []
    for k, line in enumerate(joined):
        if k:
            out.append(Token("NEXT", "\n", line[0].start, line[0].start))
        out += line
    return out


def _close_arguments(tokens: list[Token], letters: Letters, text: str) -> Iterator[Token]:
    """Put brackets around arguments that have none: sin 2 q, cos q1, sqrt 3."""
    at = 0
    while at < len(tokens):
        token = tokens[at]
        yield token
        at += 1
        if token.kind != "FUNCTION":
            continue
        if at < len(tokens) and tokens[at].kind == "POWER":
            end = _end_of_exponent(tokens, at)
            yield from tokens[at:end]
            at = end
        if at < len(tokens) and tokens[at].kind in ("LPAR", "LBRACE", "FRACTION", "LSQB"):
            continue
        end = _end_of_argument(tokens, at, letters)
        if end == at:
            place = tokens[at].start if at < len(tokens) else len(text) - 1
            raise FormulaError(
                f"expected an argument of {token.value}, e.g. {token.value}(q)", text, place
            )
        if end < len(tokens) and tokens[end].kind == "POWER":
            name = token.value
            raise FormulaError(
                f"{name} of a letter with a power may be read in two ways; write {name}(q)^2 or "
                f"{name}(q^2)",
                text,
                tokens[end].start,
            )
        yield Token("LPAR", "(", tokens[at].start, tokens[at].start)
        yield from tokens[at:end]
        yield Token("RPAR", ")", tokens[end - 1].end, tokens[end - 1].end)
        at = end


def _end_of_exponent(tokens: list[Token], at: int) -> int:
    """Return where an exponent ends that stands between a function and its argument."""
    at += 1
    if at < len(tokens) and tokens[at].kind == "MINUS":
        at += 1
    if at < len(tokens) and tokens[at].kind in _OPEN:
        depth = 0
        while at < len(tokens):
            depth += (tokens[at].kind in _OPEN) - (tokens[at].kind in _CLOSE)
            at += 1
            if not depth:
                break
        return at
    return min(at + 1, len(tokens))


def _end_of_argument(tokens: list[Token], at: int, letters: Letters) -> int:
    """Return where an argument without brackets ends: numbers, then an angle or W t."""
    end = at
    while end < len(tokens) and tokens[end].kind == "NUMBER":
        end += 1
    while end < len(tokens) and tokens[end].kind == "NAME":
        name = tokens[end].value
        end += 1
        following = tokens[end] if end < len(tokens) else None
        to_time = following is not None and following.kind == "NAME" and following.value == "t"
        moving = letters.kinds.get(name) in ("coordinate", "time", "velocity")
        if moving or (name in letters.angles and not to_time) or not to_time:
            break
    return end
