"""Cut a formula into tokens, whether it is plain text, LaTeX or SymPy's text."""

from __future__ import annotations

import re
from typing import final

from mecanique.checking.grammar.latex import Latex
from mecanique.checking.grammar.letters import Letters
from mecanique.checking.grammar.lines import close_arguments, join_lines
from mecanique.checking.grammar.tokens import LETTER, SINGLE, Token, Tokens
from mecanique.errors import FormulaError

MOST_CHARACTERS = 20_000
"""Largest number of characters in a text."""

MOST_TOKENS = 4_000
"""Largest number of tokens in a text."""

_NUMBER = re.compile(r"(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?")
_WORD = re.compile(r"[^\W\d_](?:[^\W_]|_(?=[^\W_])|_\{[^{}]{1,20}\})*")
_INNER = rf"(?P<word>{LETTER})(?:\(\s*t\s*\))?"
_DERIVATIVE = re.compile(
    rf"(?:Derivative|diff)\(\s*{_INNER}\s*,\s*"
    r"(?P<by>\(\s*t\s*,\s*[123]\s*\)|t\s*,\s*[123]|t(?:\s*,\s*t)*)\s*\)"
)
_METHOD = re.compile(r"\.diff\(\s*(?P<by>t\s*,\s*[123]|t(?:\s*,\s*t)*)\s*\)")
_LEIBNIZ = re.compile(
    rf"d\s*(?:\^?\s*(?P<order>[23])\s*)?{_INNER}\s*/\s*"
    r"d\s*t(?:\s*(?:\^|\*\*)?\s*(?P<again>[23]))?(?!\w)"
)
_D_BY_DT = re.compile(r"d\s*/\s*d\s*t(?!\w)")
_DOT_OF = re.compile(rf"(?P<dots>d{{1,2}})ot\(\s*{_INNER}\s*\)")
_END_OF_SENTENCE = re.compile(r"[.…]+(?=\s*(?:$|\n|\$|\\(?:end|\]|\)|\\|q?quad|label|tag)))")
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


def scan(text: str, letters: Letters) -> list[Token]:
    """Cut a text into tokens.

    Args:
        text: plain text, LaTeX or SymPy's text.
        letters: the letters that it may contain.

    Raises:
        FormulaError: if it is too long, or contains an unknown sign or letter; the message names
            all unknown letters.
    """
    if len(text) > MOST_CHARACTERS:
        raise FormulaError(
            f"expected at most {MOST_CHARACTERS:,} characters in a formula, got {len(text):,}"
        )
    return Scanner(text, letters).scan()


@final
class Scanner:
    """Reads one text.

    Args:
        text: the formula.
        letters: the letters that it may contain.
    """

    def __init__(self, text: str, letters: Letters) -> None:
        self._text = text
        self._tokens = Tokens(text, letters)
        self._latex = Latex(self._tokens, self._next)

    def scan(self) -> list[Token]:
        """Cut the text into tokens, with brackets around every argument."""
        at = 0
        while at < len(self._tokens.plain):
            at = self._next(at)
            if len(self._tokens.found) > MOST_TOKENS:
                raise self._tokens.explain(f"the formula has more than {MOST_TOKENS:,} signs", at)
        if self._tokens.unknown:
            raise self._tokens.explain_unknown()
        lines = join_lines(self._tokens.found)
        return list(close_arguments(lines, self._tokens.letters, self._text))

    def _next(self, at: int) -> int:
        """Read the next piece at a position; return the position after it."""
        text = self._tokens.plain
        sign = text[at]
        if sign == "\n":
            return self._tokens.put("NEWLINE", "\n", at, at + 1)
        if sign.isspace() or sign in "$~":
            return at + 1
        if sign == "\\":
            return self._latex.read_command(at)
        if sign == "&":
            return self._tokens.put("COMMA", ",", at, at + 1) if self._tokens.tables else at + 1
        if found := _NUMBER.match(text, at):
            return self._tokens.put("NUMBER", found[0], at, found.end())
        if sign.isalpha():
            return self._word(at)
        if sign == "." and text[at + 1 : at + 2] in ("*", "/", "^"):
            # the dot of Matlab's elementwise products and powers
            return at + 1
        if text.startswith("**", at):
            return self._tokens.put("POWER", "^", at, at + 2)
        if text.startswith(":=", at) or text.startswith("==", at):
            return self._tokens.put("EQUALS", "=", at, at + 2)
        if sign == "'" and self._tokens.found and self._tokens.found[-1].kind == "RPAR":
            return self._tokens.put("PRIME", "'", at, at + 1)
        if found := _METHOD.match(text, at):
            return self._method(found)
        if sign in SINGLE:
            return self._tokens.put_sign(sign, at)
        if found := _END_OF_SENTENCE.match(text, at):
            return found.end()
        remedy = _REMEDIES.get(sign, "expected letters, numbers and + - * / ^ ( ) =")
        raise self._tokens.explain(f"{sign!r} has no meaning here; {remedy}", at)

    def _word(self, at: int) -> int:
        text = self._tokens.plain
        if found := _DERIVATIVE.match(text, at):
            return self._tokens.put_derivative(found["word"], _order(found["by"]), found)
        if found := _D_BY_DT.match(text, at):
            return self._tokens.put("RATE", "d/dt", at, found.end())
        if (found := _LEIBNIZ.match(text, at)) and self._tokens.is_moving(found["word"]):
            return self._tokens.put_derivative(found["word"], int(found["order"] or 1), found)
        if (found := _DOT_OF.match(text, at)) and self._tokens.is_moving(found["word"]):
            return self._tokens.put_derivative(found["word"], len(found["dots"]), found)
        found = _WORD.match(text, at)
        assert found is not None
        word, end = re.sub(r"[{}\\\s]", "", found[0]), found.end()
        if word == "and":
            return self._tokens.put("NEWLINE", word, at, end)
        return self._tokens.put_word(word, at, end)

    def _method(self, found: re.Match[str]) -> int:
        """Read the derivative in q(t).diff(t)."""
        before = self._tokens.found[-1] if self._tokens.found else None
        if before is None or before.kind != "NAME":
            raise self._tokens.explain(
                "expected a coordinate before .diff, e.g. q.diff(t)", found.start()
            )
        name = self._tokens.letters.by_key.get(before.value + "'" * _order(found["by"]))
        if before.value in self._tokens.unknown:
            return found.end()
        if name is None:
            raise self._tokens.explain(f"{before.value!r} has no derivative by t", found.start())
        self._tokens.found[-1] = Token(
            "NAME", name, before.start, self._tokens.place_after(found.end())
        )
        return found.end()


def _order(by: str) -> int:
    digits = re.findall(r"[123]", by)
    return int(digits[0]) if digits else by.count("t")
