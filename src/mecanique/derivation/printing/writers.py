"""The three formats of formulas: text, LaTeX and MathML."""

from __future__ import annotations

import re
from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from html import escape
from itertools import pairwise
from math import isqrt
from types import MappingProxyType
from typing import ClassVar, final
from xml.etree.ElementTree import Element, fromstring, tostring

from mecanique.derivation.printing.formulas import (
    FUNCTIONS,
    Base,
    Call,
    Letter,
    Product,
    Sum,
    names_in,
)
from mecanique.derivation.scalars.series import Series
from mecanique.model.mechanism.letters import GREEK, SplitName, is_varied, to_letter

_TIMES = "<mo>&#x2062;</mo>"
_CALL = re.compile(r"\\(arc)?(sin|cos|tan|exp|log|operatorname)")
_CALLED = {"asin": "arcsin", "acos": "arccos", "atan": "arctan", "sign": "sgn"}
_NUMBERED = re.compile(r"([^\W\d_]+?)(\d+)")
_WORD = re.compile(r"(?:\\d+ot\{)?\\text\{")
_WORDY = re.compile(r"(?:<m(?:over|sub|sup|subsup)[^>]*>)*<mi>\w{2,}</mi>")
_CALLING = re.compile(r"<mrow>(?:<msup>)?<mi>\w{2,}</mi>")
_BRACKETS = ("(", "\\left(")
_LARGE = 10**6
"""Numbers up to this are searched for squares that stand before a root."""
_THIN = '<mspace width="0.1667em"/>'

NO_LETTERS: Mapping[str, str] = MappingProxyType({})


class Writer(ABC):
    """A format; all arguments except names and numbers are strings already written in it."""

    row: ClassVar[str] = "{}"  # around a sum
    held: ClassVar[str] = "{}"  # around a sum that is all of a numerator or denominator
    signs: ClassVar[tuple[str, str, str]] = ("-", " + ", " - ")  # a first minus, and between terms
    statement: ClassVar[str] = "{} {} {}"
    relations: ClassVar[Mapping[str, str]] = {}  # signs that are written otherwise
    slope: ClassVar[str]  # ∂ of one letter by another
    rate: ClassVar[str]  # d/dt of that
    turned: ClassVar[str]  # a component of ω × a gradient

    def __init__(self, letters: Mapping[str, str] = NO_LETTERS) -> None:
        self.letters = letters  # of names that are words; text has the names themselves

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
    def term(
        self, numerator: Sequence[str], denominator: Sequence[str], tail: Sequence[str]
    ) -> str:
        """Write a product: a fraction, then functions and motions."""

    def alone(self, inner: str) -> str:
        """Write a sum that is all of a numerator or denominator."""
        return self.held.format(inner)

    def sum(self, terms: Sequence[tuple[bool, str]]) -> str:
        """Write a sum of (is negative, term)."""
        if not terms:
            return self.row.format(self.number("0"))
        (negative, text), *rest = terms
        begin, plus, minus = self.signs
        later = "".join((minus if negative else plus) + term for negative, term in rest)
        return self.row.format((begin if negative else "") + text + later)

    def equation(self, left: str, right: str) -> str:
        """Write an equation."""
        return self.relation(left, "=", right)

    def relation(self, left: str, sign: str, right: str) -> str:
        """Write an equation, or an inequality with <, >, ≤ or ≥."""
        return self.statement.format(left, self.relations.get(sign, sign), right)

    @abstractmethod
    def matrix(self, rows: Sequence[Sequence[str]]) -> str:
        """Write a matrix, or a column."""

    def partial(self, function: str, variable: str, rate: bool) -> str:
        """Write a partial derivative of two letters in this format, or its time derivative."""
        slope = self.slope.format(function, variable)
        return self.rate.format(slope) if rate else slope

    def turning(self, gradient: str, component: str) -> str:
        """Write a component of ω × a gradient, as in the equations of Euler and Kirchhoff."""
        return self.turned.format(gradient, component)


@final
class Text(Writer):
    """Plain text: a b is a product, ^ a power, ' a time derivative, f(x)/(a b) a quotient."""

    held, slope, rate, turned = "({})", "∂{}/∂{}", "d/dt {}", "(ω × {})_{}"

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

    def matrix(self, rows: Sequence[Sequence[str]]) -> str:
        """Write a matrix, or a column."""
        written = (f"[{', '.join(row)}]" for row in rows)
        return f"[{', '.join(written)}]"


@final
class Latex(Writer):
    """LaTeX for math mode, which needs no package but amsmath."""

    relations: ClassVar[Mapping[str, str]] = {"≤": "\\leq", "≥": "\\geq", "≈": "\\approx"}
    slope, rate = "\\frac{{\\partial {}}}{{\\partial {}}}", "\\frac{{d}}{{dt}} {}"
    turned = "\\left(\\omega \\times {}\\right)_{{{}}}"

    def number(self, digits: str) -> str:
        """Write an unsigned decimal number."""
        mantissa, _, exponent = digits.partition("e")
        return f"{mantissa} \\times 10^{{{int(exponent)}}}" if exponent else digits

    def letter(self, name: str, of_time: bool, exponent: str) -> str:
        """Write a named quantity."""
        if is_varied(name):
            return f"\\delta {self.letter(name[1:], of_time, exponent)}"
        letter = SplitName.of(to_letter(name, self.letters))
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
        name = _CALLED.get(function, function)
        command = "\\operatorname{sgn}" if function == "sign" else f"\\{name}"
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

    def term(
        self, numerator: Sequence[str], denominator: Sequence[str], tail: Sequence[str]
    ) -> str:
        """Write a product."""
        above, rest = (numerator, tail) if numerator or not denominator else (tail, [])
        if denominator:
            above = [f"\\frac{{{_space(above) or '1'}}}{{{_space(denominator)}}}"]
        return _space([*above, *rest]) or "1"

    def matrix(self, rows: Sequence[Sequence[str]]) -> str:
        """Write a matrix, or a column."""
        lines = " \\\\ ".join(map(" & ".join, rows))
        return f"\\begin{{bmatrix}} {lines} \\end{{bmatrix}}"

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

    row, statement = "<mrow>{}</mrow>", "<mrow>{}<mo>{}</mo>{}</mrow>"
    signs = ("<mo>−</mo>", "<mo>+</mo>", "<mo>−</mo>")
    relations: ClassVar[Mapping[str, str]] = {"<": "&lt;", ">": "&gt;"}
    slope = "<mfrac><mrow><mo>∂</mo>{}</mrow><mrow><mo>∂</mo>{}</mrow></mfrac>"
    rate = "<mrow><mfrac><mi>d</mi><mrow><mi>d</mi><mi>t</mi></mrow></mfrac>{}</mrow>"
    turned = "<msub><mrow><mo>(</mo><mi>ω</mi><mo>×</mo>{}<mo>)</mo></mrow>{}</msub>"

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
        letter = SplitName.of(to_letter(name, self.letters))
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
        head = self._power(f"<mi>{_CALLED.get(function, function)}</mi>", exponent)
        inner = f"{_THIN}{argument}" if bare else _hug(argument)
        return f"<mrow>{head}<mo>&#x2061;</mo>{inner}</mrow>"

    def brackets(self, inner: str, exponent: str) -> str:
        """Write a sum within a product."""
        return self._power(_hug(inner), exponent)

    def term(
        self, numerator: Sequence[str], denominator: Sequence[str], tail: Sequence[str]
    ) -> str:
        """Write a product."""
        above, rest = (numerator, tail) if numerator or not denominator else (tail, [])
        if denominator:
            over = self._row([], above) if above is tail else self._row(above, [])
            above = [f"<mfrac>{over}{self._row(denominator, [])}</mfrac>"]
        return self._row(above, rest)

    def matrix(self, rows: Sequence[Sequence[str]]) -> str:
        """Write a matrix, or a column."""
        table = ""
        for row in rows:
            cells = "".join(f"<mtd>{cell}</mtd>" for cell in row)
            table += f"<mtr>{cells}</mtr>"
        return f"<mrow><mo>[</mo><mtable>{table}</mtable><mo>]</mo></mrow>"

    def _row(self, factors: Sequence[str], moving: Sequence[str]) -> str:
        """Write a product, with thin spaces before functions and motions, and beside words."""
        product = "".join(factors[:1])
        for before, factor in pairwise(factors):
            letters = not before.startswith("<mn>") and not factor.startswith("<mrow>")
            wordy = letters and any(map(_WORDY.match, (before, factor)))
            called = _CALLING.match(before) or _CALLING.match(factor)
            product += f"{_TIMES}{_THIN if wordy or called else ''}{factor}"
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


_LARGE = 10**7  # numbers with more digits are written as decimals
_DECIMAL = 100  # a terminating number with a larger numerator, e.g. 981/100, becomes a decimal
_DIGITS = 13


def write(terms: Iterable[Product], writer: Writer, *, decimals: bool = False) -> str:
    """Write a sum in a format, its terms in the given order."""
    walk = _Walk(writer, decimals)
    return writer.sum([walk.term(term) for term in terms])


_HALF = Fraction(1, 2)


@final
class _Walk:
    """A walk over a formula that extracts signs and puts negative powers into denominators."""

    def __init__(self, writer: Writer, decimals: bool) -> None:
        self._writer = writer
        self._decimals = decimals
        self._written: dict[Sum, str] = {}

    def term(self, product: Product) -> tuple[bool, str]:
        """Return whether a product is negative, and the product written without its sign."""
        numerator, tail, denominator = list[str](), list[str](), list[str]()
        above = [factor for factor in product.factors if factor[1] > 0]
        below = [(base, -power) for base, power in product.factors if power < 0]
        over, under = self._number(product.number)
        numerator += over
        plain = [factor for factor in above if factor[0].place[0] < FUNCTIONS]
        alone = len(plain) == 1 and not over and bool(below or under)
        numerator += [self._factor(base, power, alone=alone) for base, power in plain]
        moving = above[len(plain) :]
        tail += [self._factor(base, power, alone=False) for base, power in moving]
        denominator += under
        alone = len(below) == 1 and not under
        denominator += [self._factor(base, power, alone=alone) for base, power in below]
        return product.number < 0, self._writer.term(numerator, denominator, tail)

    def _number(self, signed: int | Fraction) -> tuple[list[str], list[str]]:
        """Write a number without its sign, as numerator and denominator."""
        if signed in (1, -1):
            return [], []
        size = abs(Fraction(signed))
        above, below = size.numerator, size.denominator
        if max(above, below) >= _LARGE or (below > 1 and self._wants_decimal(size)):
            decimal = f"{float(size):.{_DIGITS}g}".replace("e+", "e")
            return [self._writer.number(decimal)], []
        return (
            [self._writer.number(str(above))] if above != 1 else [],
            [self._writer.number(str(below))] if below != 1 else [],
        )

    def _wants_decimal(self, size: Fraction) -> bool:
        ends = 10**12 % size.denominator == 0
        measured = self._decimals and (ends or size.denominator >= _DECIMAL**2)
        return measured or (ends and size.numerator >= _DECIMAL)

    def sum(self, whole: Sum) -> str:
        """Write a sum, positive terms first; cached, as long equations repeat the same sums."""
        if whole not in self._written:
            self._written[whole] = self._writer.sum([self.term(term) for term in whole.terms])
        return self._written[whole]

    def _factor(self, base: Base, power: int | Fraction, *, alone: bool) -> str:
        """Write a power; a sum that is all of a numerator or denominator needs no brackets."""
        writer = self._writer
        if power != 1 and power == _HALF:
            inner = self.sum(base) if isinstance(base, Sum) else self._factor(base, 1, alone=False)
            return writer.call("sqrt", inner, "")
        exponent = "" if power == 1 else str(power)
        if isinstance(base, Letter):
            return writer.letter(base.name, base.of_time, exponent)
        if isinstance(base, Call):
            inner = self.sum(base.argument)
            return writer.call(base.function, inner, exponent, bare=_is_bare(base.argument))
        if alone and not exponent:
            return writer.alone(self.sum(base))
        return writer.brackets(self.sum(base), exponent)


def _is_bare(argument: Sum) -> bool:
    """Whether a function's argument needs no brackets: a letter or a multiple of one."""
    if len(argument.terms) != 1:
        return False
    (term,) = argument.terms
    letter = len(term.factors) == 1 and isinstance(term.factors[0][0], Letter)
    return letter and term.factors[0][1] == 1 and term.number > 0 and term.number.denominator == 1


def to_math(row: str, display: str = "block", alt: str = "") -> str:
    """Return a row of MathML as an element of a page, with its text if any."""
    told = f' alttext="{escape(alt, quote=True)}"' if alt else ""
    xmlns = "http://www.w3.org/1998/Math/MathML"
    return f'<math xmlns="{xmlns}" display="{display}"{told}>{row}</math>'


_BREAKS = ("+", "−", "=")
_LINES = (
    '<div role="math" aria-label="{}" style="margin: 0.7em 0; padding-left: 2em;'
    ' text-indent: -1.5em; line-height: 2.2; overflow: auto hidden">{}</div>'
)
# an inline formula would be set small, and an indentation would pass on to its parts
_PIECE = '<math displaystyle="true" style="text-indent: 0; margin: 0.2em 0">{}</math>'


def to_lines(row: str, alt: str = "") -> str:
    """Return presentation MathML as HTML that wraps before +, − and =, without a script."""
    # No browser breaks a formula by itself. The terms of the outermost sum are formulas of their
    # own here, between which lines break as between words.
    terms = _split(fromstring(f"<mrow>{row}</mrow>"))
    pieces = ["".join(map(_serialize, term)) for term in terms]
    if len(pieces) > 1 and pieces[-1].endswith("=</mo><mrow><mn>0</mn></mrow>"):
        zero = pieces.pop()  # a zero alone would be a poor last line
        pieces[-1] += zero
    written = "&#x200b;".join(map(_PIECE.format, pieces))
    return _LINES.format(escape(alt, quote=True), written)


def _serialize(part: Element) -> str:
    return tostring(part, encoding="unicode")


def _split(row: Element) -> list[list[Element]]:
    """Return the terms of an equation, each with the sign before it; brackets stay whole."""
    pieces: list[list[Element]] = [[]]
    for part in row:
        if _is_break(part):
            # the form that a browser guesses from the place does not hold once lines break
            part.set("form", "infix" if pieces[-1] else "prefix")
            if pieces[-1]:
                pieces.append([])
        if part.tag == "mrow" and any(map(_is_break, part)):
            first, *later = _split(part)
            pieces[-1] += first
            pieces += later
        else:
            pieces[-1].append(part)
    return pieces


def _is_break(part: Element) -> bool:
    return part.tag == "mo" and part.text in _BREAKS


class Printed(ABC):
    """An object that can be written as text, LaTeX and MathML, and displayed in a notebook."""

    @property
    def spelled(self) -> Mapping[str, str]:
        """The letters of its names that are words."""
        return NO_LETTERS

    @abstractmethod
    def write(self, writer: Writer) -> str:
        """Write it in the format of a writer."""

    def text(self) -> str:
        """Return it as one line of text, e.g. q'' + 3 g sin(q)/(2 l) = 0."""
        return self.write(Text())

    def latex(self) -> str:
        """Return it in LaTeX, without dollar signs."""
        return self.write(Latex(self.spelled))

    def mathml(self) -> str:
        """Return it as one MathML element."""
        return to_math(self.write(MathML(self.spelled)), alt=self.text())

    def __str__(self) -> str:
        return self.text()

    def __repr__(self) -> str:
        return f"<{type(self).__name__}: {self}>"

    def _repr_latex_(self) -> str:
        return f"$\\displaystyle {self.latex()}$"

    def _repr_html_(self) -> str:
        """Show it in a notebook, even where no script renders LaTeX."""
        return to_lines(self.write(MathML(self.spelled)), self.text())


@final
@dataclass(frozen=True, repr=False)
class Expression(Printed):
    """A sum of terms in textbook order."""

    terms: tuple[Product, ...]
    decimals: bool = False  # whether fractions of numbers are written as decimals

    @property
    def letters(self) -> frozenset[str]:
        """The names of its letters."""
        return frozenset().union(*(names_in(term) for term in self.terms))

    def write(self, writer: Writer) -> str:
        """Write it in the format of a writer."""
        return write(self.terms, writer, decimals=self.decimals)


@final
@dataclass(frozen=True, repr=False)
class Equation(Printed):
    """An equation of motion left = right, with inputs and other functions of time on the right."""

    left: Expression  # the terms with accelerations, velocities and coordinates
    right: Expression  # the terms that depend on time alone
    # the monomial of parameters by which the derived equation was divided: derived = (left − right)
    # × divisor
    divisor: Series

    @property
    def spelled(self) -> Mapping[str, str]:
        """The letters of its names that are words."""
        return self.divisor.ring.letters

    def write(self, writer: Writer) -> str:
        """Write it in the format of a writer."""
        return writer.equation(self.left.write(writer), self.right.write(writer))


@final
@dataclass(frozen=True, repr=False)
class Root(Printed):
    """A letter, the square root that it is if that is short, and its value where it is stated."""

    name: str
    square: Printed | None
    value: str = ""

    def write(self, writer: Writer) -> str:
        """Write it in the format of a writer."""
        written = writer.letter(self.name, False, "")
        if self.square is not None:
            above, below, square = _take_squares(self.square)
            root = writer.call("sqrt", square.write(writer), "")
            outside = ([writer.number(str(n))] if n > 1 else [] for n in (above, below))
            written = writer.equation(written, writer.term(next(outside), next(outside), [root]))
        return writer.equation(written, writer.number(self.value)) if self.value else written


def _find_root(number: int) -> int:
    """Return the largest number whose square divides a number, 1 for what is large."""
    roots = range(1, isqrt(number) + 1) if 0 < number < _LARGE else ()
    return max((n for n in roots if number % n**2 == 0), default=1)


def _take_squares(square: Printed) -> tuple[int, int, Printed]:
    """Return the numbers before and below the root of a single product, and what stays under it."""
    if not isinstance(square, Expression) or len(square.terms) != 1:
        return 1, 1, square
    (term,) = square.terms
    number = Fraction(term.number)
    above, below = map(_find_root, (number.numerator, number.denominator))
    rest = replace(term, number=number * below**2 / above**2)
    return above, below, Expression((rest,), square.decimals)


@final
@dataclass(frozen=True, repr=False)
class OverRoot(Printed):
    """A letter that is a product over a square root, times a number."""

    name: str
    above: Expression
    square: Printed
    times: str = ""

    def write(self, writer: Writer) -> str:
        """Write it in the format of a writer."""
        root = writer.call("sqrt", self.square.write(writer), "")
        below = [writer.number(self.times), root] if self.times else [root]
        written = self.above.write(writer)
        above = writer.alone(written) if len(self.above.terms) > 1 else written
        fraction = writer.term([above], below, [])
        return writer.equation(writer.letter(self.name, False, ""), fraction)


@final
@dataclass(frozen=True, repr=False)
class Relation(Printed):
    """An inequality, or two sides that are nearly equal."""

    left: Printed
    sign: str
    right: Printed

    def write(self, writer: Writer) -> str:
        """Write it in the format of a writer."""
        return writer.relation(self.left.write(writer), self.sign, self.right.write(writer))
