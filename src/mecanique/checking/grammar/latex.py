"""Read commands of LaTeX: fractions, dots, environments, spaces and names."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import final

from mecanique.checking.grammar.letters import SPELLINGS
from mecanique.checking.grammar.tokens import LETTER, Tokens
from mecanique.checking.grammar.tree import FUNCTIONS

_COMMAND = re.compile(r"\\(?:[A-Za-z]+|.)", re.DOTALL)
_D = r"(?:\\mathrm\s*\{\s*d\s*\}|\\text\s*\{\s*d\s*\}|d)"
_FRACTION = re.compile(
    rf"\\[dt]?frac\s*\{{\s*{_D}\s*(?:\^\s*\{{?\s*(?P<order>[23])\s*\}}?)?\s*(?P<word>{LETTER})?\s*"
    rf"(?:\(\s*t\s*\)\s*)?\}}\s*\{{\s*{_D}\s*\\?,?\s*t\s*(?:\^\s*\{{?\s*[23]\s*\}}?)?\s*\}}"
)
_DOT = re.compile(
    r"\\(?P<dots>d{1,3})ot\s*"
    r"(?:\{\s*(?P<inner>[^{}]{0,80}(?:\{[^{}]{0,80}\}[^{}]{0,80})?)\}|(?P<word>\\[A-Za-z]+|[A-Za-z]))"
    r"(?P<subscript>\s*_\s*(?:\{[^{}]{1,20}\}|\w))?"
)
_SUBSCRIPT = re.compile(
    r"\s*_\s*(?:\{(?P<long>(?:[^{}]|\{[^{}]{0,20}\}){1,40})\}|(?P<short>\\?[A-Za-z]+|\d))"
)
_ENVIRONMENT = re.compile(r"\\(?P<which>begin|end)\s*\{\s*(?P<name>[a-z]+)\*?\s*\}(?:\{[lcr|]*\})?")
_TABLES = {"matrix", "pmatrix", "bmatrix", "vmatrix", "smallmatrix", "Bmatrix"}
_IGNORED = re.compile(
    r"\\(?:left|right|[bB]igg?[lrm]?|displaystyle|textstyle|nonumber|notag|limits|quad|qquad"
    r"|,|;|:|!| |>|\(|\)|\[|\]|(?:hspace|label|tag\*?)\{[^{}]{0,80}\})(?![A-Za-z])\s*\.?"
)
_CASES = re.compile(r"\\left\s*\\\{(?=\s*\\begin)")
_SPACING = re.compile(r"\\(?:,|;|:|!| |>|\(|\)|\[|\])")


@final
class Latex:
    """Reads commands of LaTeX into tokens.

    Args:
        tokens: the tokens found so far.
        read: reads the next piece at a position, and returns the position after it.
    """

    def __init__(self, tokens: Tokens, read: Callable[[int], int]) -> None:
        self._tokens = tokens
        self._read = read
        self._arrays: list[bool] = []

    def read_command(self, at: int) -> int:
        """Read the command at a position; return the position after it."""
        text = self._tokens.plain
        if text.startswith("\\\\", at):
            skip = re.compile(r"\\\\\s*(?:\[[^\]\n]{0,10}\])?").match(text, at)
            assert skip is not None
            kind = "SEMICOLON" if self._tokens.tables else "NEWLINE"
            return self._tokens.put(kind, ";", at, skip.end())
        if found := _FRACTION.match(text, at):
            return self._fraction_of_time(found)
        if found := _DOT.match(text, at):
            return self._read_dots(found)
        if found := _ENVIRONMENT.match(text, at):
            return self._environment(found)
        if found := _CASES.match(text, at):
            return found.end()
        if found := _IGNORED.match(text, at):
            # the dot of "\left." is no sign; elsewhere a dot after a space ends a sentence
            before = self._tokens.found[-1:]
            if before and before[0].kind == "NEWLINE" and "quad" in found[0]:
                self._tokens.put("INDENT", " ", at, found.end())
            return found.end()
        if found := _SPACING.match(text, at):
            return found.end()
        found = _COMMAND.match(text, at)
        if found is None:
            raise self._tokens.explain("a backslash at the end has no meaning", at)
        return self._plain_command(found)

    def _plain_command(self, found: re.Match[str]) -> int:
        name, at, end = found[0][1:], found.start(), found.end()
        if name in ("cdot", "times", "ast"):
            return self._tokens.put("TIMES", "*", at, end)
        if name == "over":
            raise self._tokens.explain("write \\frac{…}{…} for \\over", at)
        if name == "div":
            return self._tokens.put("OVER", "/", at, end)
        if name in ("frac", "dfrac", "tfrac"):
            self._tokens.put("FRACTION", "frac", at, end)
            return self._brace(self._brace(end))
        if name in ("lvert", "rvert", "vert", "mid"):
            raise self._tokens.explain("write abs(…) for a magnitude", at)
        function = SPELLINGS.get(name, name)
        if function == "sqrt" and self._tokens.plain.startswith("[", end):
            raise self._tokens.explain("write other roots than the square root as powers", at)
        if function in FUNCTIONS:
            self._tokens.put("FUNCTION", function, at, end)
            return end
        if name in ("{", "}"):
            return self._tokens.put_sign("(" if name == "{" else ")", at) + 1
        if not name.isalpha():
            raise self._tokens.explain(f"the command \\{name} has no meaning in a formula", at)
        subscript, end = self._subscript(end)
        return self._tokens.put_word(name + subscript, at, end)

    def _subscript(self, at: int) -> tuple[str, int]:
        """Return the subscript at a position, and the position after it."""
        found = _SUBSCRIPT.match(self._tokens.plain, at)
        if not found:
            return "", at
        return re.sub(r"[\\\s,{}]", "", found["long"] or found["short"]), found.end()

    def _brace(self, at: int) -> int:
        """Put braces around an argument of a fraction without braces, as in frac12."""
        text = self._tokens.plain
        while at < len(text) and text[at].isspace():
            at += 1
        if at >= len(text) or text[at] == "{":
            if at >= len(text):
                raise self._tokens.explain("expected two arguments in braces after \\frac", at - 1)
            return self._read_braces(at)
        if text[at].isdigit():
            self._tokens.put("LBRACE", "{", at, at + 1)
            self._tokens.put("NUMBER", text[at], at, at + 1)
            self._tokens.put("RBRACE", "}", at, at + 1)
            return at + 1
        if text[at].isalpha() or text[at] == "\\":
            self._tokens.put("LBRACE", "{", at, at + 1)
            end = (
                self.read_command(at)
                if text[at] == "\\"
                else self._tokens.put_word(text[at], at, at + 1)
            )
            self._tokens.put("RBRACE", "}", end - 1, end)
            return end
        raise self._tokens.explain("expected an argument in braces after \\frac", at)

    def _read_braces(self, at: int) -> int:
        """Read an argument in braces to its end."""
        depth = self._tokens.depth
        at = self._read(at)
        while at < len(self._tokens.plain) and self._tokens.depth > depth:
            at = self._read(at)
        if self._tokens.depth > depth:
            raise self._tokens.explain("a brace is not closed", len(self._tokens.plain) - 1)
        return at

    def _fraction_of_time(self, found: re.Match[str]) -> int:
        order = int(found["order"] or 1)
        if found["word"]:
            if not self._tokens.is_moving(found["word"]):
                command = _COMMAND.match(self._tokens.plain, found.start())
                assert command is not None
                return self._plain_command(command)
            return self._tokens.put_derivative(found["word"], order, found)
        for _ in range(order):
            self._tokens.put("RATE", "d/dt", found.start(), found.end())
        return found.end()

    def _read_dots(self, found: re.Match[str]) -> int:
        inner = (found["inner"] or found["word"] or "").strip()
        word = re.sub(r"[\\\s_{},]|\(t\)", "", inner + (found["subscript"] or ""))
        if not word.isalnum():
            raise self._tokens.explain(
                "expected a single letter below the dots, e.g. \\ddot{\\theta}_1; write d/dt "
                "before brackets",
                found.start(),
            )
        return self._tokens.put_word(word + "'" * len(found["dots"]), found.start(), found.end())

    def _environment(self, found: re.Match[str]) -> int:
        tokens, opens = self._tokens, found["which"] == "begin"
        table = found["name"] in _TABLES
        if found["name"] == "array":
            # a matrix within brackets, lines elsewhere
            before = tokens.found[-1:]
            if opens:
                self._arrays.append(bool(before) and before[0].kind in ("LSQB", "LPAR"))
            table = self._arrays[-1] if self._arrays else False
            if not opens and self._arrays:
                self._arrays.pop()
        if table:
            tokens.tables += 1 if opens else -1
            kind = "LSQB" if opens else "RSQB"
            return tokens.put(kind, "[" if opens else "]", found.start(), found.end())
        return found.end()
