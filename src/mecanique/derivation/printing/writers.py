"""The three formats of formulas: text, LaTeX and MathML."""

from __future__ import annotations

import re
from abc import ABC, abstractmethod
from collections.abc import Sequence
from html import escape
from itertools import pairwise
from typing import final

from mecanique.derivation.printing.letters import GREEK, Letter, is_varied

_TIMES = "<mo>&#x2062;</mo>"
_CALL = re.compile(r"\\(arc)?(sin|cos|tan|exp|log|operatorname)")
_NUMBERED = re.compile(r"([^\W\d_]+?)(\d+)")
_WORD = re.compile(r"(?:\\d+ot\{)?\\text\{")
_WORDY = re.compile(r"(?:<m(?:over|sub|sup|subsup)[^>]*>)*<mi>\w{2,}</mi>")
_BRACKETS = ("(", "\\left(")
_THIN = '<mspace width="0.1667em"/>'


class Writer(ABC):
    """A format; all arguments except names and numbers are strings already written in it."""

    @abstractmethod
    def number(self, digits: str) -> str:
        """Write an unsigned decimal number."""

    @abstractmethod
    def letter(self, name: str, of_time: bool, exponent: str) -> str:
        """Write a named quantity; the exponent is "" for 1."""

    @abstractmethod
    def call(self, function: str, argument: str, exponent: str, *, bare: bool = False) -> str:
        """Write a function; a bare argument, such as one letter, needs no brackets."""

    @abstractmethod
    def brackets(self, inner: str, exponent: str) -> str:
        """Write a sum within a product."""

    @abstractmethod
    def alone(self, inner: str) -> str:
        """Write a sum that is all of a numerator or denominator."""

    @abstractmethod
    def term(
        self, numerator: Sequence[str], denominator: Sequence[str], tail: Sequence[str]
    ) -> str:
        """Write a product: a fraction, then functions and motions."""

    @abstractmethod
    def sum(self, terms: Sequence[tuple[bool, str]]) -> str:
        """Write a sum of (is negative, term)."""

    @abstractmethod
    def equation(self, left: str, right: str) -> str:
        """Write an equation."""

    @abstractmethod
    def partial(self, function: str, variable: str, rate: bool) -> str:
        """Write a partial derivative of two letters in this format, or its time derivative."""

    @abstractmethod
    def turning(self, gradient: str, component: str) -> str:
        """Write a component of ω × a gradient, as in the equations of Euler and Kirchhoff."""


@final
class Text(Writer):
    """Plain text: a b is a product, ^ a power, ' a time derivative, f(x)/(a b) a quotient."""

    def number(self, digits: str) -> str:
        """Write an unsigned decimal number."""
        return digits

    def letter(self, name: str, of_time: bool, exponent: str) -> str:
        """Write a named quantity."""
        return name + _raise(exponent)

    def call(self, function: str, argument: str, exponent: str, *, bare: bool = False) -> str:
        """Write a function of an argument."""
        return f"{function.lower()}({argument}){_raise(exponent)}"

    def brackets(self, inner: str, exponent: str) -> str:
        """Write a sum within a product."""
        return f"({inner}){_raise(exponent)}"

    def alone(self, inner: str) -> str:
        """Write a sum that is all of a numerator or denominator."""
        return self.brackets(inner, "")

    def term(
        self, numerator: Sequence[str], denominator: Sequence[str], tail: Sequence[str]
    ) -> str:
        """Write a product."""
        above = " ".join([*numerator, *tail]) or "1"
        if not denominator:
            return above
        return (
            f"{above}/{denominator[0]}"
            if len(denominator) == 1
            else f"{above}/({' '.join(denominator)})"
        )

    def sum(self, terms: Sequence[tuple[bool, str]]) -> str:
        """Write a sum."""
        return _sign(terms, "-", " + ", " - ")

    def equation(self, left: str, right: str) -> str:
        """Write an equation."""
        return f"{left} = {right}"

    def partial(self, function: str, variable: str, rate: bool) -> str:
        """Write a partial derivative, or its time derivative."""
        return f"{'d/dt ' if rate else ''}∂{function}/∂{variable}"

    def turning(self, gradient: str, component: str) -> str:
        """Write a component of ω × a gradient."""
        return f"(ω × {gradient})_{component}"


@final
class Latex(Writer):
    """LaTeX for math mode, which needs no package but amsmath."""

    def number(self, digits: str) -> str:
        """Write an unsigned decimal number."""
        mantissa, _, exponent = digits.partition("e")
        return f"{mantissa} \\times 10^{{{int(exponent)}}}" if exponent else digits

    def letter(self, name: str, of_time: bool, exponent: str) -> str:
        """Write a named quantity."""
        if is_varied(name):
            return f"\\delta {self.letter(name[1:], of_time, exponent)}"
        letter = Letter.of(name)
        written = self._word(letter.base)
        if letter.dots:
            written = f"\\{'d' * letter.dots}ot{{{written}}}"
        if letter.subscript:
            words = map(self._word, letter.subscript.split("_"))
            written += f"_{{{','.join(words)}}}"
        return written + (f"^{{{exponent}}}" if exponent else "") + ("(t)" if of_time else "")

    def call(self, function: str, argument: str, exponent: str, *, bare: bool = False) -> str:
        """Write a function of an argument."""
        power = f"^{{{exponent}}}" if exponent else ""
        if function == "sqrt":
            return f"\\sqrt{{{argument}}}"
        if function == "Abs":
            return f"\\left|{argument}\\right|{power}"
        name = {"asin": "arcsin", "acos": "arccos", "atan": "arctan"}.get(function, function)
        command = "\\operatorname{sgn}" if name == "sign" else f"\\{name}"
        if bare:
            return f"{command}{power} {argument}"
        if "\\frac" not in argument:
            return f"{command}{power}({argument})"
        return f"{command}{power}\\left({argument}\\right)"

    def brackets(self, inner: str, exponent: str) -> str:
        """Write a sum within a product."""
        tall = "\\frac" in inner
        held = f"\\left({inner}\\right)" if tall else f"({inner})"
        return held + (f"^{{{exponent}}}" if exponent else "")

    def alone(self, inner: str) -> str:
        """Write a sum that is all of a numerator or denominator."""
        return inner

    def term(
        self, numerator: Sequence[str], denominator: Sequence[str], tail: Sequence[str]
    ) -> str:
        """Write a product."""
        above, rest = (numerator, tail) if numerator or not denominator else (tail, [])
        if denominator:
            above = [f"\\frac{{{_space(above) or '1'}}}{{{_space(denominator)}}}"]
        return _space([*above, *rest]) or "1"

    def sum(self, terms: Sequence[tuple[bool, str]]) -> str:
        """Write a sum."""
        return _sign(terms, "-", " + ", " - ")

    def equation(self, left: str, right: str) -> str:
        """Write an equation."""
        return f"{left} = {right}"

    def partial(self, function: str, variable: str, rate: bool) -> str:
        """Write a partial derivative, or its time derivative."""
        slope = f"\\frac{{\\partial {function}}}{{\\partial {variable}}}"
        return f"\\frac{{d}}{{dt}} {slope}" if rate else slope

    def turning(self, gradient: str, component: str) -> str:
        """Write a component of ω × a gradient."""
        return f"\\left(\\omega \\times {gradient}\\right)_{{{component}}}"

    def _word(self, word: str) -> str:
        if word in GREEK:
            return "o" if word == "omicron" else f"\\{word}"
        if len(word) == 1 or word.isdigit():
            return word
        numbered = _NUMBERED.fullmatch(word)
        if numbered is not None and (len(numbered[1]) == 1 or numbered[1] in GREEK):
            return f"{self._word(numbered[1])}_{{{numbered[2]}}}"
        plain = word.replace("_", "\\_")
        return f"\\text{{{plain}}}"


@final
class MathML(Writer):
    """Presentation MathML in the core subset that browsers and screen readers support."""

    def number(self, digits: str) -> str:
        """Write an unsigned decimal number."""
        mantissa, _, exponent = digits.partition("e")
        if not exponent:
            return f"<mn>{digits}</mn>"
        power = f"<msup><mn>10</mn>{self._exponent(str(int(exponent)))}</msup>"
        return f"<mrow><mn>{mantissa}</mn><mo>×</mo>{power}</mrow>"

    def letter(self, name: str, of_time: bool, exponent: str) -> str:
        """Write a named quantity."""
        if is_varied(name):
            return f"<mrow><mi>δ</mi>{self.letter(name[1:], of_time, exponent)}</mrow>"
        letter = Letter.of(name)
        written = self._word(letter.base)
        if letter.dots:
            accent = {1: "˙", 2: "¨"}.get(letter.dots, "˙" * letter.dots)
            written = f'<mover accent="true">{written}<mo>{accent}</mo></mover>'
        below = self._word(letter.subscript) if letter.subscript else ""
        above = self._exponent(exponent) if exponent else ""
        if below and above:
            written = f"<msubsup>{written}{below}{above}</msubsup>"
        elif below or above:
            tag = "msub" if below else "msup"
            written = f"<{tag}>{written}{below or above}</{tag}>"
        if of_time:
            written = f"<mrow>{written}<mo>&#x2061;</mo>{_hug('<mi>t</mi>')}</mrow>"
        return written

    def call(self, function: str, argument: str, exponent: str, *, bare: bool = False) -> str:
        """Write a function of an argument."""
        if function == "sqrt":
            return f"<msqrt>{argument}</msqrt>"
        if function == "Abs":
            return self._power(f"<mrow><mo>|</mo>{argument}<mo>|</mo></mrow>", exponent)
        name = {"asin": "arcsin", "acos": "arccos", "atan": "arctan", "sign": "sgn"}.get(
            function, function
        )
        head = self._power(f"<mi>{name}</mi>", exponent)
        inner = f"{_THIN}{argument}" if bare else _hug(argument)
        return f"<mrow>{head}<mo>&#x2061;</mo>{inner}</mrow>"

    def brackets(self, inner: str, exponent: str) -> str:
        """Write a sum within a product."""
        return self._power(_hug(inner), exponent)

    def alone(self, inner: str) -> str:
        """Write a sum that is all of a numerator or denominator."""
        return inner

    def term(
        self, numerator: Sequence[str], denominator: Sequence[str], tail: Sequence[str]
    ) -> str:
        """Write a product."""
        above, rest = (numerator, tail) if numerator or not denominator else (tail, [])
        if denominator:
            over = self._row([], above) if above is tail else self._row(above, [])
            above = [f"<mfrac>{over}{self._row(denominator, [])}</mfrac>"]
        return self._row(above, rest)

    def sum(self, terms: Sequence[tuple[bool, str]]) -> str:
        """Write a sum."""
        inner = _sign(terms, "<mo>−</mo>", "<mo>+</mo>", "<mo>−</mo>")
        return f"<mrow>{inner or '<mn>0</mn>'}</mrow>"

    def equation(self, left: str, right: str) -> str:
        """Write an equation."""
        return f"<mrow>{left}<mo>=</mo>{right}</mrow>"

    def partial(self, function: str, variable: str, rate: bool) -> str:
        """Write a partial derivative, or its time derivative."""
        slope = f"<mfrac><mrow><mo>∂</mo>{function}</mrow><mrow><mo>∂</mo>{variable}</mrow></mfrac>"
        operator = "<mfrac><mi>d</mi><mrow><mi>d</mi><mi>t</mi></mrow></mfrac>"
        return f"<mrow>{operator}{slope}</mrow>" if rate else slope

    def turning(self, gradient: str, component: str) -> str:
        """Write a component of ω × a gradient."""
        product = f"<mrow><mo>(</mo><mi>ω</mi><mo>×</mo>{gradient}<mo>)</mo></mrow>"
        return f"<msub>{product}{component}</msub>"

    def _row(self, factors: Sequence[str], moving: Sequence[str]) -> str:
        """Write a product, with thin spaces before functions and motions, and beside words."""
        product = "".join(factors[:1])
        for before, factor in pairwise(factors):
            letters = not before.startswith("<mn>") and not factor.startswith("<mrow>")
            wordy = letters and any(map(_WORDY.match, (before, factor)))
            product += f"{_TIMES}{_THIN if wordy else ''}{factor}"
        for k, factor in enumerate(moving):
            product += f"{_TIMES}{_THIN}{factor}" if factors or k else factor
        if len(factors) + len(moving) <= 1:
            return product or "<mn>1</mn>"
        return f"<mrow>{product}</mrow>"

    def _power(self, base: str, exponent: str) -> str:
        return f"<msup>{base}{self._exponent(exponent)}</msup>" if exponent else base

    def _exponent(self, exponent: str) -> str:
        sign, digits = ("<mo>−</mo>", exponent[1:]) if exponent.startswith("-") else ("", exponent)
        above, slash, below = digits.partition("/")
        number = f"<mn>{above}</mn>" + (f"<mo>/</mo><mn>{below}</mn>" if slash else "")
        return f"<mrow>{sign}{number}</mrow>" if sign or slash else number

    def _word(self, word: str) -> str:
        parts = []
        for part in word.split("_"):
            shown = f"<mi>{GREEK.get(part, escape(part))}</mi>"
            parts.append(f"<mn>{part}</mn>" if part.isdigit() else shown)
        return parts[0] if len(parts) == 1 else f"<mrow>{'<mtext>,</mtext>'.join(parts)}</mrow>"


def _space(factors: Sequence[str]) -> str:
    """Join factors in LaTeX, with thin spaces after functions and beside words."""
    written = ""
    for before, factor in zip(["", *factors], factors, strict=False):
        called = _CALL.match(before) is not None and _CALL.match(factor) is None
        letters = before[:1].isalpha() or before[:1] == "\\"
        words = _WORD.match(before) is not None or _WORD.match(factor) is not None
        thin = called or (letters and words and not factor.startswith(_BRACKETS))
        written += (" \\, " if thin else " ") + factor
    return written.strip()


def _hug(inner: str) -> str:
    """Put brackets around a formula in MathML; they stretch only around fractions."""
    fence = "<mo>" if "<mfrac>" in inner else '<mo stretchy="false">'
    return f"<mrow>{fence}(</mo>{inner}{fence})</mo></mrow>"


def _raise(exponent: str) -> str:
    if not exponent:
        return ""
    return f"^{exponent}" if exponent.isdigit() else f"^({exponent})"


def _sign(terms: Sequence[tuple[bool, str]], first: str, plus: str, minus: str) -> str:
    if not terms:
        return "" if plus.startswith("<") else "0"
    (negative, text), *rest = terms
    return (first if negative else "") + text + "".join((minus if n else plus) + t for n, t in rest)
