"""Search for mistakes in equations of motion, the likeliest first."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from itertools import chain, combinations, pairwise, permutations
from types import MappingProxyType
from typing import TypeAlias, final

import numpy as np
import numpy.typing as npt

from mecanique.arrays import Array
from mecanique.checking.budget import SpentError, spend
from mecanique.checking.grammar import tree
from mecanique.checking.grammar.letters import KnownLetters
from mecanique.checking.grammar.reader import Statement
from mecanique.checking.grammar.tape import FormulaTape, needed_values
from mecanique.checking.grammar.tree import Node, rate
from mecanique.checking.judgement.formula import Judged
from mecanique.checking.judgement.motion import Residual, combine_angles, residuals
from mecanique.checking.judgement.quantities import AskedQuantity, measure
from mecanique.checking.judgement.truth import Truth
from mecanique.checking.mistakes.hypotheses import (
    ALIKE,
    MOST_TIMES,
    MULTIPLES,
    SIMPLE,
    TWO_SLIPS,
    Hypotheses,
    WrongDerivation,
    list_parts,
)
from mecanique.checking.mistakes.of_quantities import QuantityMistakes, is_repeated, mutate
from mecanique.checking.mistakes.units import LetterUnits, UnitMisfitError
from mecanique.checking.verdict import Mistake
from mecanique.derivation.printing.equations import expression
from mecanique.derivation.scalars.evaluation import Evaluation
from mecanique.derivation.scalars.series import Kind, Series
from mecanique.derivation.symbolic.multipliers import divide_common
from mecanique.errors import FormulaError
from mecanique.model.mechanism import Mechanism
from mecanique.model.units import Dimension, read_unit


@final
class Context:
    """The likely intentions behind parts of formulas about a mechanism; values (n,)."""

    def __init__(
        self,
        mechanism: Mechanism,
        letters: KnownLetters,
        units: LetterUnits,
        values: Mapping[str, Array],
    ) -> None:
        self.dimension_of = units.find
        self._dimensions = units.of
        self.values = values
        self.units = {p.symbol: p.unit for p in mechanism.parameters}
        self.coordinates = tuple(mechanism.coordinates)
        self.velocities = mechanism.velocities
        self.accelerations = tuple(f"{name}'" for name in mechanism.velocities)
        self.angles = [name for name in self.coordinates if name in letters.angles]

    @cached_property
    def arguments(self) -> dict[str, Array]:
        """The possible arguments of sine and cosine, by their formula."""
        fixed = [name for name, unit in self.units.items() if unit == "rad"]
        arguments = combine_angles([*self.angles, *fixed], self.values)
        turning = [name for name, unit in self.units.items() if unit in ("rad/s", "1/s")]
        arguments |= {f"{name} t": self.values[name] * self.values["t"] for name in turning}
        for name in tuple(arguments):
            arguments[f"2 {name}" if " " not in name else f"2 ({name})"] = 2 * arguments[name]
        return arguments

    @cached_property
    def factors(self) -> dict[str, tuple[str, Array]]:
        """Kind and value of each factor that a term may lack, by its formula."""
        factors: dict[str, tuple[str, Array]] = {}
        for symbol in self.units:
            value = self.values[symbol]
            factors[symbol] = ("factor missing", value)
            factors[f"{symbol}^2"] = ("factor missing", value * value)
        for first, second in permutations(self.units, 2):
            if self.units[first] == self.units[second]:
                ratio = self.values[first] / self.values[second]
                factors[f"{first}/{second}"] = ("letter", ratio)
                factors[f"({first}/{second})^2"] = ("factor missing", ratio * ratio)
                if self.units[first] == "kg":
                    share = self.values[first] / (self.values[first] + self.values[second])
                    both = " + ".join(name for name in self.units if name in (first, second))
                    factors[f"{first}/({both})"] = ("letter", share)
        for name in (*self.coordinates, *self.velocities):
            factors[name] = ("factor missing", self.values[name])
        for formula, value in self.arguments.items():
            for name, wave in (("cos", np.cos(value)), ("sin", np.sin(value))):
                kind = "small angle" if name == "cos" else "factor missing"
                factors[f"{name}({formula})"] = (kind, wave)
                factors[f"{name}({formula})^2"] = ("factor missing", wave * wave)
            tangent = np.tan(value)
            factors[f"tan({formula})"] = ("sin for cos", tangent)
            factors[f"tan({formula})^2"] = ("sin for cos", tangent * tangent)
        return factors

    @cached_property
    def ratios(self) -> Array:
        """The factors, then their inverses, shape (2 k, n)."""
        stacked = np.stack([value for _, value in self.factors.values()])
        return np.concatenate([stacked, 1 / stacked])

    def alternatives(self, name: str) -> Iterator[tuple[str, Array]]:
        """Yield alternatives to a letter, with their values."""
        values = self.values
        dimension = self._dimensions.get(name)
        fixed = [*self.units, *self.coordinates]
        if name in fixed and dimension is not None:
            group = [letter for letter in fixed if self._dimensions.get(letter) == dimension]
            yield from ((letter, values[letter]) for letter in group if letter != name)
            if name in self.units:
                yield from self._sums([letter for letter in group if letter in self.units])
        for family in (self.coordinates, self.velocities, self.accelerations):
            if name in family:
                yield from ((letter, values[letter]) for letter in family if letter != name)
                yield from self._combinations(name, family)

    def _sums(self, group: list[str]) -> Iterator[tuple[str, Array]]:
        for k, first in enumerate(group):
            for second in group[k + 1 :]:
                yield f"{first} + {second}", self.values[first] + self.values[second]
        if len(group) > 2:
            yield " + ".join(group), sum((self.values[first] for first in group), np.zeros(()))

    def _combinations(self, name: str, family: tuple[str, ...]) -> Iterator[tuple[str, Array]]:
        values = self.values
        for letter in family:
            if letter != name:
                yield f"{name} + {letter}", values[name] + values[letter]
                yield f"{name} - {letter}", values[name] - values[letter]
                yield f"{letter} - {name}", values[letter] - values[name]
        for letter in family if family is not self.coordinates else ():
            for angle in self.angles if letter != name else ():
                # a spin is the rate about the own axis and the share of another one
                share = np.cos(values[angle]) * values[letter]
                yield f"{name} + {letter} cos({angle})", values[name] + share


@dataclass(frozen=True, eq=False)
class FormulaPart:
    """A part of a formula, with its present and its needed values."""

    residual: Residual  # the formula
    place: int  # index of the part on its tape
    have: Array  # its present values
    want: Array  # its needed values
    usable: npt.NDArray[np.bool_]  # the states in which both are known
    context: Context  # the likely intentions
    text: str

    @property
    def tape(self) -> FormulaTape:
        """The formula as a list of parts."""
        return self.residual.tape

    @property
    def node(self) -> Node:
        """The part itself."""
        return self.tape.nodes[self.place]

    @cached_property
    def quoted(self) -> str:
        """The part as it was written."""
        return self.node.quote(self.text)

    @property
    def is_term(self) -> bool:
        """Whether it is a term of a sum, stands below a root, or is the whole."""
        parent = self.tape.parents[self.place]
        return parent < 0 or self.tape.nodes[parent].kind == "sum" or self.is_below_root

    @property
    def is_below_root(self) -> bool:
        """Whether it is all that stands below a root."""
        return self.tape.nodes[self.tape.parents[self.place]].name == "sqrt"

    @property
    def is_inertial(self) -> bool:
        """Whether it multiplies an acceleration, or is one."""
        place = self.place
        while place >= 0:
            node = self.tape.nodes[place]
            if node.kind != "sum" and node.letters & {*self.context.accelerations}:
                return True
            place = self.tape.parents[place]
        return False

    @property
    def is_squared(self) -> bool:
        """Whether its sign does not matter, as it is raised to an even power."""
        parent = self.tape.nodes[self.tape.parents[self.place]]
        return parent.kind == "power" and parent.parts[1].value % 2 == 0

    def is_alike(self, value: Array) -> bool:
        """Whether a value is the needed one, in all states."""
        want = self.want
        if self.is_squared:
            value, want = np.abs(value), np.abs(want)
        scale = np.abs(value) + np.abs(want)
        return bool((np.abs(value - want) <= ALIKE * scale).all())

    @property
    def here(self) -> str:
        """The part as it was written; within a definition or a rate, its letter's name."""
        return self.quoted or self.node.name

    @property
    def where(self) -> str:
        """The term that contains the part, in words."""
        place = self.place
        while place >= 0 and (
            self.tape.parents[place] >= 0
            and self.tape.nodes[self.tape.parents[place]].kind != "sum"
        ):
            place = self.tape.parents[place]
        node = self.tape.nodes[place]
        if place == self.place or node.end <= node.start:
            return ""
        return f"in '{node.quote(self.text)}' "

    def quote_of(self, node: Node) -> str:
        """Return another part as it was written."""
        return node.quote(self.text)

    def values_of(self, place: int) -> Array:
        """Return the present values of another part, where both of this one are known."""
        return self.residual.values.parts[place][self.usable]


_Candidate: TypeAlias = tuple[Array, str, str, float]
"""A value that a part may be meant to have; the mistake's kind, its words and its weight."""


def _exchange_digits(written: str) -> Iterator[float]:
    """Yield a number as it is with two neighbouring digits exchanged; none of a product."""
    if not written.replace(".", "", 1).isdecimal():
        return
    for i, j in pairwise([k for k, sign in enumerate(written) if sign != "."]):
        signs = [*written]
        signs[i], signs[j] = signs[j], signs[i]
        yield float("".join(signs))


def repair_number(part: FormulaPart) -> Iterator[Mistake]:
    """Yield repairs of a number."""
    ratio = part.want
    spread = float(np.ptp(ratio))
    parent = part.tape.nodes[part.tape.parents[part.place]]
    if parent.kind == "power" or spread > ALIKE * float(np.abs(ratio).max()):
        return
    decimals = len(part.quoted.replace(",", ".").partition(".")[2])
    exchanged = _exchange_digits(part.quoted.replace(",", "."))
    if decimals and any(abs(x - ratio.mean()) <= 0.51 * 10.0**-decimals for x in exchanged):
        yield Mistake("digits", f"two digits of '{part.quoted}' are exchanged", part.quoted, 1.1)
    factor = Fraction(float(ratio.mean())).limit_denominator(SIMPLE)
    close = (
        0 < abs(factor.numerator) <= SIMPLE and abs(float(factor) / float(ratio.mean()) - 1) < ALIKE
    )
    if close and not part.is_term:
        yield Mistake("factor", f"the number '{part.quoted}' should be {factor}", part.quoted, 1.6)


def _vary_letter(part: FormulaPart) -> Iterator[_Candidate]:
    """Yield what a letter may stand for: another one, its sine, a power."""
    name = part.node.name
    context = part.context
    have = part.have
    said = f"{part.here} {part.where}should be"
    for spelled, value in context.alternatives(name):
        # a sum in place of a letter is a missing term; a difference is less likely than a factor
        weight = max(2.05 * ("+" in spelled), 1.45 * ("-" in spelled), 1.3)
        kind = "letter" if name in context.units else "angle"
        yield value[part.usable], kind, f"{said} {spelled}", weight
    parent = part.tape.nodes[part.tape.parents[part.place]]
    if name == "pi" and not any(node.kind == "number" for node in parent.parts):
        yield 2 * have, "measure", f"{said} 2 pi", 0.7
    for function, shape in (("sin", np.sin), ("tan", np.tan)) if name in context.angles else ():
        text = f"{said} {function}({name}): the angle is assumed to be small"
        yield shape(have), "small angle", text, 1.0
    if name in context.units or name in context.velocities or name in context.coordinates:
        yield have**2, "power", f"{said} {name}^2", 1.7
        yield have**3, "power", f"{said} {name}^3", 1.7
        if not part.is_term:
            yield np.ones_like(have), "power", f"{said} 1", 1.7


_WAVES = {"sin": np.sin, "cos": np.cos, "tan": np.tan}


def _vary_wave(part: FormulaPart) -> Iterator[_Candidate]:
    """Yield what a sine, cosine or tangent may stand for: another one, another angle, none."""
    name, argument = part.node.name, part.node.parts[0]
    inner = part.values_of(part.tape.parts[part.place][0])
    turned = "cos" if name == "sin" else "sin"
    written, swapped = _WAVES[name], _WAVES[turned]
    said = f"'{part.quoted}' {part.where}should be"
    yield swapped(inner), "sin for cos", f"{said} {turned}", 1.0
    if not part.is_squared:
        yield -swapped(inner), "sin for cos", f"{said} −{turned}", 1.3
    if "2" in (numbers := [part.quote_of(p) for p in argument.parts]) and name != "tan":
        half = " ".join(text for text in numbers if text != "2")
        text = f"{said} {name}({half})^2: a square is not a double angle"
        yield written(inner / 2) ** 2, "power", text, 1.0
    degrees = (np.radians(inner), np.degrees(inner))
    for angle in degrees:
        text = f"'{part.quoted}' {part.where}is taken in degrees: angles are in radians"
        yield written(angle), "degree", text, 0.8
    for formula, value in part.context.arguments.items():
        angle = value[part.usable]
        if not any((np.abs(angle - known) <= ALIKE).all() for known in (inner, *degrees)):
            text = f"{said} {name}({formula})"
            # a mere number is no other angle
            if any(n.isidentifier() and n not in ("pi", "t") for n in argument.letters):
                text += ": relative and absolute angles are mixed up"
            yield written(angle), "angle", text, 1.2
            yield swapped(angle), "angle", f"{said} {turned}({formula})", 2.2
    if argument.letters:
        text = f"the factor '{part.quoted}' does not belong {part.where or 'there'}"
        yield np.ones_like(inner), "factor surplus", text, 2.0


def _vary_power(part: FormulaPart) -> Iterator[_Candidate]:
    """Yield what a power may stand for: another exponent, a product of rates."""
    letter, exponent_node = part.node.parts
    place = part.tape.parts[part.place][0]
    base = part.values_of(place)
    said = f"'{part.quoted}' {part.where}should be"
    shown = letter.quote(part.text)
    for exponent in (x for x in (1, 2, 3, 4, 0, -1) if x != exponent_node.value):
        value = np.abs(base) ** exponent if exponent in (2, 4) else base**exponent
        right = {0: "1", 1: shown}.get(exponent, f"{shown}^{exponent}")
        yield np.asarray(value, dtype=float), "power", f"{said} {right}", 1.5
    if exponent_node.value != 2:
        return
    if letter.kind == "call" and letter.name in ("sin", "cos"):
        inner = part.values_of(part.tape.parts[place][0])
        argument = letter.parts[0].quote(part.text)
        text = f"{said} {letter.name}(2 {argument}): a square is not a double angle"
        yield _WAVES[letter.name](2 * inner), "power", text, 1.2
    if letter.kind == "sum":
        squares = [_find_sign(part, k) * part.values_of(k) ** 2 for k in part.tape.parts[place]]
        yield np.sum(np.abs(squares), axis=0), "power", f"{said} the sum of the squares", 1.2
        yield np.sum(squares, axis=0), "power", f"{said} the difference of the squares", 1.3
    for second in part.context.velocities if letter.name in part.context.velocities else ():
        if second != letter.name:
            product = part.context.values[second][part.usable] * base
            yield product, "angle", f"{said} {letter.name} {second}", 1.4


def _find_sign(part: FormulaPart, place: int) -> int:
    """Return the sign before a term."""
    return -1 if part.tape.nodes[place].kind == "negative" else 1


def _vary_roots(part: FormulaPart) -> Iterator[_Candidate]:
    """Yield what a sum of squares or of roots may stand for: the square or the root of a sum."""
    places = part.tape.parts[part.place]
    bare = [node.parts[0] if node.kind == "negative" else node for node in part.node.parts]
    signs = [_find_sign(part, place) for place in places]
    terms = [part.values_of(place) for place in places]
    if all(node.kind == "power" and node.parts[1].value == 2 for node in bare):
        powers = [part.tape.parts[k][0] if s < 0 else k for k, s in zip(places, signs, strict=True)]
        bases = [part.values_of(part.tape.parts[k][0]) for k in powers]
        roots = [sign * base for sign, base in zip(signs, bases, strict=True)]
        text = f"'{part.quoted}' should be the square of the sum or difference, not that of squares"
        yield np.square(np.sum(roots, axis=0)), "power", text, 0.7
    if any(node.name == "sqrt" for node in bare):
        squares = [sign * term**2 for sign, term in zip(signs, terms, strict=True)]
        text = f"'{part.quoted}' should be a single root: a root is not taken term by term"
        yield np.sqrt(np.sum(squares, axis=0)), "power", text, 1.2


def _vary_product(part: FormulaPart) -> Iterator[_Candidate]:
    """Yield what a product may stand for: with the squares of two letters for their product."""
    units, values = part.context.units, part.context.values
    letters = [node.name for node in part.node.parts if node.name in units]
    for first, second in combinations(letters, 2):
        if units[first] == units[second]:
            a, b = values[first][part.usable], values[second][part.usable]
            for sign in "+-":
                squares = a**2 + b**2 if sign == "+" else a**2 - b**2
                text = (
                    f"'{first} {second}' in '{part.quoted}' should be {first}^2 {sign} {second}^2"
                )
                yield part.have * squares / (a * b), "power", text, 1.2


def _vary_sum(part: FormulaPart) -> Iterator[_Candidate]:
    """Yield what a sum may stand for: its sine, one with a letter more, a square or a root."""
    yield from _vary_roots(part)
    context = part.context
    letters = part.node.letters
    if letters and letters <= set(context.angles):
        text = f"'{part.quoted}' should be its sine: the angle is assumed to be small"
        yield np.sin(part.have), "small angle", text, 1.0
    for name in letters & {*context.angles} if len(letters) == 1 else ():
        angle = context.values[name][part.usable]
        for wave, value, series in (
            ("sin", np.sin(angle), angle - angle**3 / 6),
            ("cos", np.cos(angle), 1 - angle**2 / 2),
        ):
            if _alike(part.have, series):
                text = f"'{part.quoted}' should be {wave} {name}, not the beginning of its series"
                yield value, "small angle", text, 1.0
    units = {context.units[name] for name in letters if name in context.units}
    alike = [name for name in sorted(letters) if name in context.units]
    if len(alike) == len(part.node.parts) == 2 and len(units) == 1:
        first, second = alike
        known = {"kg": "the reduced mass ", "N/m": "that of springs in series, "}
        reduced = f"{known.get(context.units[first], '')}{first} {second}/({first} + {second})"
        product = context.values[first] * context.values[second]
        yield product[part.usable] / part.have, "mass", f"'{part.quoted}' should be {reduced}", 1.4
    if len(units) == 1 and part.tape.parents[part.place] >= 0:
        for name, unit in context.units.items():
            if unit in units:
                more = part.have + context.values[name][part.usable]
                kind, said = "letter", f"{name} is missing from the sum '{part.quoted}'"
                if any(
                    term.kind == "negative" and term.parts[0].name == name
                    for term in part.node.parts
                ):
                    kind, said = "extra", f"the term '- {name}' does not belong in '{part.quoted}'"
                yield more, kind, said, 1.4


_ABOUT = "the inertia may be taken about the wrong point (center or pin) or of the wrong body"
_INERTIAS = {
    **dict.fromkeys((Fraction(4), Fraction(1, 4), Fraction(3), Fraction(1, 3)), _ABOUT),
    Fraction(12): _ABOUT,
    Fraction(3, 4): "a particle has no inertia about its own center, as a rod has",
    Fraction(4, 3): "the inertia of a rod about its own center is missing (as for a particle)",
    Fraction(4, 5): "the inertia of a rod about its own center is counted twice",
}
"""What it may mean that a term with an inertia should be so many times as large."""


def repair_term(part: FormulaPart) -> Iterator[Mistake]:
    """Yield repairs of a term: a number, a letter, a function; or its absence."""
    ratio = part.want / part.have
    if not np.isfinite(ratio).all():
        return
    size = part.residual.values.sizes[part.tape.parents[part.place]][part.usable]
    if (np.abs(part.want) <= 1e-9 * size).all() and not part.is_below_root:
        text = f"the term '{part.quoted}' does not belong there"
        # a number that is added to another says less than the inertia that it stands for
        yield Mistake("extra", text, part.quoted, 0.95 if part.node.letters else 1.35)
        return
    mean = float(ratio.mean())
    if float(np.ptp(ratio)) <= ALIKE * abs(mean):
        yield from _scale(part, mean)
        return
    rows = part.context.ratios[:, part.usable]
    alike = (np.abs(rows - ratio) <= ALIKE * (np.abs(rows) + np.abs(ratio))).all(axis=1)
    alike |= (np.abs(rows + ratio) <= ALIKE * (np.abs(rows) + np.abs(ratio))).all(axis=1)
    names = list(part.context.factors)
    for place in np.flatnonzero(alike):
        name = names[place % len(names)]
        kind = part.context.factors[name][0]
        if kind == part.node.kind == "letter":
            continue  # it is said of the letter itself
        if kind == "sin for cos":
            formula = name[3:].removesuffix("^2")
            pair = ("sin", "cos") if place < len(names) else ("cos", "sin")
            text = f"in the term '{part.quoted}' {pair[1]}{formula} should be {pair[0]}{formula}"
            yield Mistake(kind, text, part.quoted, 1.7)
        elif kind == "letter" and _is_exchanged(
            part, letters := _read_ratio(name, upright=bool(place < len(names)))
        ):
            text = f"in the term '{part.quoted}' {letters[1]} should be {letters[0]}"
            # a sum in place of a letter is a missing term
            yield Mistake(kind, text, part.quoted, 2.05 if "+" in letters[0] else 1.7)
        elif kind == "letter":
            text = f"the term '{part.quoted}' lacks the factor {'/'.join(letters)}"
            yield Mistake("factor missing", text, part.quoted, 1.75)
        elif place >= len(names):
            text = f"the factor {name} does not belong in the term '{part.quoted}'"
            if not _contains(part.node, name):
                text = f"the term '{part.quoted}' lacks the divisor {name}"
            yield Mistake("factor surplus", text, part.quoted, 2.0)
        elif kind == "small angle":
            text = (
                f"the term '{part.quoted}' lacks the factor {name}: the angle is assumed to be "
                "small"
            )
            yield Mistake(kind, text, part.quoted, 1.8)
        else:
            text = f"the term '{part.quoted}' lacks the factor {name}"
            yield Mistake(kind, text, part.quoted, 2.0)
    if not alike.any():
        yield from _scale_by_factor(part, ratio / rows, names)


def _scale_by_factor(part: FormulaPart, shares: Array, names: Sequence[str]) -> Iterator[Mistake]:
    """Yield that a term lacks a factor or divisor times a number."""
    means = shares.mean(axis=1)
    alike = (np.ptp(shares, axis=1) <= ALIKE * np.abs(means)) & (np.abs(means) <= MOST_TIMES)
    for place in np.flatnonzero(alike):
        number = Fraction(float(means[place])).limit_denominator(MOST_TIMES)
        if number and abs(means[place] / float(number) - 1) < ALIKE:
            said = "factor" if place < len(names) else "divisor"
            number = number if place < len(names) else 1 / number
            text = f"the term '{part.quoted}' lacks the {said} {number} {names[place % len(names)]}"
            yield Mistake("factor missing", text, part.quoted, _UNLIKELY + 0.05)


def _read_ratio(ratio: str, *, upright: bool) -> list[str]:
    pair = ratio.split("/", 1)
    return pair if upright else pair[::-1]


def _is_exchanged(part: FormulaPart, pair: Sequence[str]) -> bool:
    """Whether a term is right with the first of two letters in place of the second."""
    if any("+" in name for name in pair):
        return True
    values = {**part.residual.sample.letters, pair[1]: part.context.values[pair[0]]}
    whole = FormulaTape(part.node).evaluate(values, part.residual.sample.count).whole
    return part.is_alike(whole[part.usable])


def _contains(node: Node, factor: str) -> bool:
    """Whether a letter or a function such as cos(q)^2 occurs in a part."""
    word = re.split(r"[(^]", factor)[0]
    return any(word == inner.name for inner in node.walk())


def _scale(part: FormulaPart, ratio: float) -> Iterator[Mistake]:
    factor = Fraction(ratio).limit_denominator(SIMPLE)
    close = 0 < abs(factor.numerator) <= SIMPLE and abs(ratio / float(factor) - 1) < ALIKE
    if factor == 1 and close:
        return
    if factor == -1 and close:
        text = f"the sign of the term '{part.quoted}' is wrong"
        yield Mistake("sign", text, part.quoted, 1.0)
    elif close and factor in _INERTIAS and _is_inertial(part):
        text = f"the term '{part.quoted}' should be {factor} times as large: {_INERTIAS[factor]}"
        yield Mistake("inertia", text, part.quoted, 1.5)
    elif abs(ratio * (numbers := _multiply_numbers(part.node)) ** 2 - 1) < ALIKE:
        said = Fraction(numbers).limit_denominator(SIMPLE)
        text = f"the ratio in '{part.quoted}' is upside down"
        if abs(said / numbers - 1) < ALIKE:
            text += f": it should be {1 / said}, not {said}"
        # of one and a number, the factor may as well be another one
        yield Mistake("inverted", text, part.quoted, 1.35 if _is_ratio(numbers**2) else 1.6)
    elif close and factor > 0:
        # a product of two slips is no simple factor
        weight = 1.4 if max(factor.numerator, factor.denominator) <= MOST_TIMES else 2.3
        text = {
            Fraction(2): f"the term '{part.quoted}' is half of what it should be",
            Fraction(1, 2): f"the term '{part.quoted}' is twice what it should be",
        }.get(factor, f"the term '{part.quoted}' should be {factor} times as large")
        yield Mistake("factor", text, part.quoted, weight)
    elif close:
        text = f"the term '{part.quoted}' should be multiplied by {factor}"
        yield Mistake("factor", text, part.quoted, 2.4)
    elif shown := _say_ratio(ratio):
        text = f"the term '{part.quoted}' should be {shown} times as large"
        yield Mistake("factor", text, part.quoted, 2.6)


def _is_ratio(value: float) -> bool:
    """Whether a number is a simple ratio of two that are not one."""
    said = Fraction(value).limit_denominator(SIMPLE)
    return min(said.numerator, said.denominator) > 1


def _multiply_numbers(node: Node) -> float:
    """Return the number by which a product or quotient multiplies its letters."""
    match node.kind:
        case "number":
            return abs(float(node.value)) or 1.0
        case "product" | "negative":
            return math.prod(map(_multiply_numbers, node.parts))
        case "quotient":
            return _multiply_numbers(node.parts[0]) / _multiply_numbers(node.parts[1])
        case "call" if node.name == "sqrt":
            return math.sqrt(_multiply_numbers(node.parts[0]))
    return 1.0


_TURNS = {
    "pi": math.pi,
    "1/pi": 1 / math.pi,
    "2 pi": 2 * math.pi,
    "1/(2 pi)": 0.5 / math.pi,
    "4 pi^2": 4 * math.pi**2,
    "1/(4 pi^2)": 0.25 / math.pi**2,
}


def _say_ratio(ratio: float) -> str:
    """Return a ratio that is no simple fraction: a root, or turns in radians; "" if it is none."""
    for said, turns in _TURNS.items():
        if abs(ratio / turns - 1) < ALIKE:
            return said
    square = Fraction(ratio * ratio).limit_denominator(SIMPLE)
    simple = 0 < square.numerator <= SIMPLE and abs(ratio * ratio / float(square) - 1) < ALIKE
    return f"√({square})" if simple and square != 1 and ratio > 0 else ""


_MOMENT = read_unit("kg·m²")


def _is_inertial(part: FormulaPart) -> bool:
    """Whether a term holds an acceleration, or is a moment of inertia."""
    felt = part.residual.root.letters
    rates = part.context.accelerations if felt & {*part.context.accelerations} else ()
    if part.node.letters & {*(rates or part.context.velocities)}:
        return True
    try:
        return part.context.dimension_of(part.node, part.text) == _MOMENT
    except UnitMisfitError:
        return False


_FEWEST = 3
"""Least number of states in which a part must have a value."""


def repairs(
    residual: Residual, context: Context, text: str, exact: Sequence[str] = ()
) -> Iterator[Mistake]:
    """Yield the changes of single parts that make a formula right.

    Those of what is exact, of "M" or "rest", are less likely.
    """
    tape, values = residual.tape, residual.values
    needed = needed_values(tape, values, np.zeros(residual.sample.count))
    finite = np.isfinite(values.whole)
    explained: set[int] = set()
    for k in range(len(tape.nodes) - 1, -1, -1):
        spend()
        parent = tape.parents[k]
        # the factors of what is explained would need the same change
        again = tape.nodes[k].name != "pi" and (
            parent in explained and tape.nodes[parent].kind in ("product", "quotient", "negative")
        )
        if again:
            explained.add(k)
        node = tape.nodes[k]
        if node.end <= node.start and node.kind != "letter":
            # within a definition or a rate only letters can be quoted
            continue
        want, have = needed[k], values.parts[k]
        usable = finite & np.isfinite(want)
        if usable.sum() < min(_FEWEST, len(finite)) or not usable.any():
            continue
        whole_part = FormulaPart(
            residual=residual,
            place=k,
            have=have[usable],
            want=want[usable],
            usable=usable,
            context=context,
            text=text,
        )
        whole = list(_take(_invert(whole_part), whole_part) if again else _find(whole_part))
        if any(repair.kind in ("sign", "extra", "factor", "inertia") for repair in whole):
            explained.add(k)
        kept = exact and ("M" if whole_part.is_inertial else "rest") in exact
        yield from (replace(m, weight=m.weight + _DENIED) for m in whole) if kept else whole


def _find(part: FormulaPart) -> Iterator[Mistake]:
    """Yield repairs of a part."""
    if part.is_term and part.tape.parents[part.place] >= 0:
        yield from repair_term(part)
    node = part.node
    if node.kind == "number":
        yield from repair_number(part)
    vary = {
        "letter": _vary_letter,
        "power": _vary_power,
        "product": _vary_product,
        "sum": _vary_sum,
    }.get(node.kind)
    if node.kind == "call" and node.name in _WAVES:
        vary = _vary_wave
    yield from _take(chain(vary(part) if vary else (), _invert(part)), part)


def _take(candidates: Iterable[_Candidate], part: FormulaPart) -> Iterator[Mistake]:
    """Yield those of the candidates that a part needs to be."""
    for value, kind, text, weight in candidates:
        if part.is_alike(value):
            yield Mistake(kind, text, part.quoted, weight)


def _invert(part: FormulaPart) -> Iterator[_Candidate]:
    """Yield a quotient upside down, or a factor on the other side of the fraction bar."""
    parent = part.tape.nodes[part.tape.parents[part.place]].kind
    if part.node.kind == "quotient":
        # of one and a number, the factor may as well be another one
        weight = 1.3 if part.node.letters or _is_ratio(part.have[0]) else 1.55
        yield 1 / part.have, "inverted", f"'{part.quoted}' is inverted", weight
    elif parent in ("product", "quotient") and not (part.have == 1).all():
        text = f"'{part.quoted}' {part.where}belongs on the other side of the fraction bar"
        yield 1 / part.have, "inverted", text, 1.55 if part.node.value == 2 else 1.35
        if part.node.kind == "number":
            text = f"'{part.quoted}' {part.where}should be its root"
            yield np.sqrt(np.abs(part.have)), "power", text, 1.45


def mend_twice(residual: Residual, context: Context, text: str) -> Iterator[Mistake]:
    """Yield a change of a part with the change of another that it leaves to be made."""
    sides = {side.quote(text) for side in residual.statement.sides}
    for first, changed in mutate(residual.root, text, context.units):
        spend()
        if first.part in sides:
            continue
        once = replace(residual, root=changed)
        if (residual.finite & ~once.finite).any():
            continue  # without a value it holds nowhere
        if once.holds:
            yield first
            continue
        for second in repairs(once, context, text):
            if second.part in sides or not second.part:
                continue
            # what contains a changed part is not written as such; a part may occur twice
            again = first.part == second.part and first.kind != "factor"
            apart = first.part not in second.part and second.part not in first.part
            nothing = first.kind == second.kind == "extra"
            if (apart and not nothing) or (again and text.count(first.part) > 1):
                weight = first.weight + second.weight
                yield Mistake(TWO_SLIPS, f"{first}; {second}", first.part, weight)


def find_lacking(residual: Residual, series: Mapping[str, Series]) -> Iterator[Mistake]:
    """Yield parts of the true quantity whose absence or factor explains a formula."""
    named = [name for name in series if name in residual.root.letters]
    if len(named) != 1:
        return
    slope = residual.tape.along(residual.slopes, named[0])
    lacks = residual.values.whole / slope
    usable = residual.finite & np.isfinite(lacks)
    if not usable.any():
        return
    truth = series[named[0]]
    evaluated = Evaluation(truth.ring, residual.sample.values)

    def value(part: Series) -> Array:
        return np.broadcast_to(evaluated(part), slope.shape)[usable]

    lacks = lacks[usable]
    for part in [*list_parts(truth, residual.truth.velocities), truth]:
        spend()
        alone = value(part)
        for factor, kind, words in MULTIPLES:
            more = (1.0 - factor) * alone
            if (
                more.any()
                and (np.abs(lacks - more) <= ALIKE * (np.abs(more) + np.abs(lacks))).all()
            ):
                text = words.format(_say_terms(part))
                yield Mistake(kind, text, "", 1.1 if kind == "missing" else 1.6)
    yield from _compare_terms(truth, value, lacks)


def _release(residual: Residual, series: Mapping[str, Series]) -> Residual:
    """Return a formula in states whose velocities no constraint binds to each other."""
    # bound to each other, they leave it open which terms of a quantity a formula lacks
    random, sample = np.random.default_rng(0), residual.sample
    free = {
        name: sample.values[name] * random.uniform(0.5, 1.5, sample.count)
        for name in residual.truth.velocities
    }
    values = {**sample.values, **free}
    values |= {name: Evaluation(part.ring, values)(part) for name, part in series.items()}
    return replace(residual, sample=replace(sample, values=values))


def _say_terms(series: Series) -> str:
    said = outside = expression(series).text()
    while (less := _INNERMOST.sub("", outside)) != outside:
        outside = less
    return f"the {'sum' if ' + ' in outside or ' - ' in outside else 'term'} {said}"


_INNERMOST = re.compile(r"\([^()]*\)")


def _compare_terms(
    truth: Series, value: Callable[[Series], Array], lacks: Array
) -> Iterator[Mistake]:
    """Yield which terms of the truth a formula has with other factors, if that is all."""
    terms = [term for term in truth.split() if value(term).any()]
    if not 1 < len(terms) <= len(lacks) // 2:
        return
    table = np.stack([value(term) for term in terms], axis=1)
    # terms of one size, so that the rank tells which depend on each other, not which are small
    size = np.abs(table).max(axis=0)
    table = table / size
    shares, _, rank, _ = np.linalg.lstsq(table, lacks, rcond=_SAME_TERMS)
    off = np.abs(table @ shares - lacks)
    scale = np.abs(table) @ np.abs(shares) + np.abs(lacks)
    if rank < len(terms) or not (off <= ALIKE * scale).all():
        return
    factors = [Fraction(float(x)).limit_denominator(SIMPLE) for x in 1 - shares / size]
    if any(abs(float(f) - (1 - x)) > ALIKE for f, x in zip(factors, shares / size, strict=True)):
        return
    wrong = [(f, term) for f, term in zip(factors, terms, strict=True) if f != 1]
    ring = truth.ring
    for factor, kind, words in MULTIPLES:
        if {f for f, _ in wrong} == {Fraction(factor)}:
            yield Mistake(kind, words.format(_say_terms(ring.sum(t for _, t in wrong))), "", 1.9)
            return
    lacking = ring.sum((1 - f) * term for f, term in wrong)
    likely = all(0 <= f < 1 for f, _ in wrong)
    yield Mistake("missing", f"{_say_terms(lacking)} is missing", "", 1.9 if likely else _UNLIKELY)


_SAME_TERMS = 1e-9
"""Terms whose values in the states depend on each other to this part cannot be told apart."""

_UNLIKELY = 2.5
"""Two slips are sought if nothing explains a formula that weighs less."""


_CONSTANT = "#constant"

_HOLDS = 1e-7
"""An equation holds for wrong accelerations if it is off by less than this part of its terms."""

_SEVERAL = -0.6
"""Added to the weight of a hypothesis that explains several equations at once."""

_DENIED = 1.0
"""Added to the weight of a hypothesis that contradicts an equation that is right."""

_MOST = 12
"""Largest number of causes that are kept for an equation."""


@final
class Search:
    """Searches for mistakes in equations about one mechanism."""

    def __init__(self, truth: Truth, letters: KnownLetters, with_numbers: bool = False) -> None:
        self._truth = truth
        self._letters = letters
        # whether any number may stand for a quantity with a unit
        self._with_numbers = with_numbers

    @cached_property
    def _hypotheses(self) -> Hypotheses:
        return Hypotheses(self._truth)

    @cached_property
    def context(self) -> Context:
        """The likely intentions."""
        values = self._truth.sample.letters
        return Context(self._truth.mechanism, self._letters, self.units, values)

    @cached_property
    def units(self) -> LetterUnits:
        """The units of the letters."""
        return self._units_with({})

    def _units_with(self, asked: Mapping[str, Dimension]) -> LetterUnits:
        return LetterUnits(self._truth.mechanism, asked, with_numbers=self._with_numbers)

    def explain(
        self,
        judged: Sequence[Judged],
        quantity: AskedQuantity,
        text: str,
        defined: Mapping[str, Node],
    ) -> list[tuple[Mistake, ...]]:
        """Return the likely causes of each line that is wrong, or is right except for rounding."""
        motion = quantity.kind == "motion"
        quantity = quantity.meant_by([formula.statement for formula in judged])
        explained = (
            self._explain_motion([f.residual for f in judged if f.residual], text, defined)
            if motion
            else self._explain_formulas(judged, quantity, text)
        )
        for k, formula in enumerate(judged):
            if formula.fault:
                place = k + 1 if len(judged) > 1 else 0
                explained[k] = (Mistake("emptiness", formula.fault, equation=place),)
            elif motion and formula.rounding:
                explained[k] = (Mistake("rounding", formula.rounding),)
        return explained

    def _explain_motion(
        self, residuals: Sequence[Residual], text: str, defined: Mapping[str, Node]
    ) -> list[tuple[Mistake, ...]]:
        """Return the likely causes for each wrong equation of motion; none for a right one."""
        holds = self._hold(residuals)
        right = np.array([residual.holds for residual in residuals])
        # a hypothesis that contradicts a right equation explains only part of the answer
        denied = _DENIED * ~np.asarray(holds[:, right].all(axis=1))
        common: list[Mistake] = []
        of_all = np.zeros(len(holds), dtype=bool)
        if np.count_nonzero(~right) > 1:
            of_all = np.asarray(holds.all(axis=1))
            common = self._list_likeliest(of_all, np.full(len(holds), _SEVERAL), 0)
        if not right.all():
            common += _list_in_time(self._fit_shares(residuals))
        moving = {*self._truth.mechanism.coordinates, *self._truth.velocities}
        moves = any(residual.root.letters & moving for residual in residuals)
        explained: list[tuple[Mistake, ...]] = []
        for k, residual in enumerate(residuals):
            number = k + 1 if len(residuals) > 1 else 0
            causes: tuple[Mistake, ...] = ()
            if not residual.root.letters and not residual.holds:
                said = "no letter of the system occurs in it"
                causes = (Mistake("emptiness", said, equation=number),)
            elif not residual.holds:
                exact = self._find_exact(residual)
                unlikely = np.maximum(denied, _DENIED * self._contradict(exact)[: len(denied)])
                of_one = self._list_likeliest(holds[:, k] & ~of_all, unlikely, number)
                mistakes = [*common, *of_one]
                if residual.sample is self._truth.sample:
                    repaired = _list_in_time(repairs(residual, self.context, text, exact))
                    if all(m.weight >= _UNLIKELY for m in (*repaired, *mistakes)):
                        repaired += _list_in_time(mend_twice(residual, self.context, text))
                        repaired += _list_in_time(self._find_other_terms(residual, text))
                    mistakes += _in_equation(repaired, number)
                causes = _rank(_misfits(self.units, residual, number, text, defined), mistakes)
            # a motion without any force is no linearized one
            explained.append(tuple(c for c in causes if moves or c.kind != "linearized"))
        return explained

    def _explain_formulas(
        self, judged: Sequence[Judged], quantity: AskedQuantity, text: str
    ) -> list[tuple[Mistake, ...]]:
        """Return the likely causes for each wrong formula of a quantity; none for a right one."""
        matrix = self._explain_matrix(judged, quantity)
        explained: list[tuple[Mistake, ...]] = []
        statements = [formula.statement for formula in judged]
        for k, formula in enumerate(judged):
            number = k + 1 if len(judged) > 1 else 0
            causes: tuple[Mistake, ...] = ()
            if formula.agrees or formula.fault:
                explained.append(())
                continue
            if formula.residual is not None:
                listed = [
                    self._mend(residual, series, quantity, text)
                    for residual, series in _list_open(formula, judged, quantity)
                ]
                if quantity.kind == "several" and is_repeated(formula.residual.root, quantity):
                    # a polynomial is right for all of its roots
                    shared = set(listed[0]).intersection(*listed)
                    listed = [tuple(cause for cause in listed[0] if cause in shared)]
                causes = _rank([], chain.from_iterable(listed)) if listed[1:] else listed[0]
            elif quantity.kind == "conserved" and formula.root is not None:
                causes = self._explain_constant(formula, text)
            elif quantity.kind == "equilibrium":
                mended = self._of_quantities.explain_position(statements, k, text)
                causes = _rank([], _list_in_time(mended))
            explained.append(tuple(dict.fromkeys((*matrix, *_in_equation(causes, number)))))
        return explained

    def _mend(
        self, residual: Residual, series: Mapping[str, Series], quantity: AskedQuantity, text: str
    ) -> tuple[Mistake, ...]:
        """Return the single changes that would make a formula right."""
        mistakes = self._mend_once(residual, series, text)
        mistakes += _list_in_time(self._of_quantities.explain(residual, quantity))
        if not mistakes:
            mistakes += _list_in_time(self._of_quantities.mend(residual, quantity, text))
        if all(mistake.weight >= _UNLIKELY for mistake in mistakes):
            mistakes += _list_in_time(mend_twice(residual, self.context, text))
        return _rank(_misfits(self._units_with(quantity.dimensions), residual, 0, text), mistakes)

    def _mend_once(
        self,
        residual: Residual,
        series: Mapping[str, Series],
        text: str,
    ) -> list[Mistake]:
        """Return the single changes of parts that are written, and the parts that are not."""
        changes = _list_in_time(repairs(residual, self.context, text))
        written = [mistake for mistake in changes if mistake.part or mistake.kind == "time"]
        # of one term, as it is written and as it should be, the same mistake is told once
        said: dict[str, float] = {}
        for mistake in written:
            said[mistake.kind] = min(mistake.weight, said.get(mistake.kind, np.inf))
        lacking = [
            mistake
            for mistake in _list_in_time(find_lacking(residual, series))
            if mistake.weight < said.get(mistake.kind, np.inf)
        ]
        if not (written or lacking) and self._truth.mechanism.constrained:
            lacking = _list_in_time(find_lacking(_release(residual, series), series))
        return written + lacking

    @cached_property
    def _of_quantities(self) -> QuantityMistakes:
        return QuantityMistakes(self._truth, self._hypotheses, self.units)

    def _explain_matrix(
        self, judged: Sequence[Judged], quantity: AskedQuantity
    ) -> tuple[Mistake, ...]:
        """Return mistakes that lead to a whole mass matrix."""
        true = quantity.values
        differences = [formula.residual.values.whole for formula in judged if formula.residual]
        if quantity.kind != "matrix" or true is None or len(differences) != true[0].size:
            return ()
        if all(formula.holds for formula in judged):
            return ()
        given = true + np.stack(differences, axis=-1).reshape(true.shape)
        return _rank([], _list_in_time(self._of_quantities.explain_matrix(given)))

    def _explain_constant(self, formula: Judged, text: str) -> tuple[Mistake, ...]:
        """Return the likely causes why a formula is not conserved."""
        truth, root = self._truth, formula.root
        assert root is not None, "it is judged by its rate"
        mistakes = _list_in_time(self._of_quantities.explain_constant(root, text))
        constants, compared = list(self._of_quantities.list_constants()), list[Residual]()
        lacking = list[Mistake]()
        divided = [divide_common([series], Kind.PARAMETER)[0] for series in constants]
        for series in dict.fromkeys([*constants, *divided]):
            known = {**truth.sample.values, _CONSTANT: truth.at({})(series)}
            less = tree.add(tree.letter(_CONSTANT), tree.negate(root))
            residual = Residual(formula.statement, less, truth, replace(truth.sample, values=known))
            once = self._mend_once(residual, {_CONSTANT: series}, text)
            mistakes += [mistake for mistake in once if mistake.weight < _UNLIKELY]
            lacking += [mistake for mistake in once if mistake.weight == _UNLIKELY]
            compared.append(residual)
        if not mistakes:
            twice = (mend_twice(residual, self.context, text) for residual in compared)
            mistakes += _list_in_time(chain.from_iterable(twice))
        if not mistakes and lacking:
            # with many factors every constant is another one: the one that lacks least
            mistakes.append(min(lacking, key=lambda mistake: len(mistake.text)))
        try:
            slope = rate(root, self._letters.rate_nodes)
            line = Statement((slope, tree.number(0)), text, root.start)
            holds = self._hold(residuals([line], truth, truth.sample, text))
            mistakes += self._list_likeliest(holds[:, 0], np.full(len(holds), 1.5), 0)
        except FormulaError:
            pass
        # what has no positions in it is the same where these are small
        positions = root.letters & set(truth.mechanism.coordinates)
        return _rank([], [m for m in mistakes if positions or m.kind != "linearized"])

    def has_unit_fault(
        self, residual: Residual, text: str, asked: Mapping[str, Dimension] = MappingProxyType({})
    ) -> bool:
        """Return whether the units in an equation do not match."""
        units = self._units_with(asked) if asked else self.units
        return bool(_misfits(units, residual, 0, text))

    def list_slips(self) -> list[tuple[WrongDerivation, Array]]:
        """Return the slips with the motions that they lead to, the likeliest first."""
        return sorted(self._hypotheses.pairs, key=lambda pair: pair[0].weight)

    def _hold(self, residuals: Sequence[Residual]) -> npt.NDArray[np.bool_]:
        """Return whether each equation holds for the accelerations of each hypothesis."""
        known = all(residual.sample is self._truth.sample for residual in residuals)
        right = all(residual.holds for residual in residuals)
        if not known or right or not self._hypotheses.listed:
            return np.zeros((0, len(residuals)), dtype=bool)
        step = self._hypotheses.motions - self._truth.sample.motion
        columns, names = [], self._truth.multipliers
        for residual in residuals:
            slopes = residual.by_unknown
            moved = np.einsum("nv,hnv->hn", slopes, step)
            size = residual.values.size + np.einsum("nv,hnv->hn", np.abs(slopes), np.abs(step))
            # where all is zero, as in x'' = 0 of what falls, there is nothing to compare
            left = np.abs(residual.values.whole + moved) / np.where(size > 0, size, 1.0)
            left[:, ~residual.finite] = 0.0
            # a multiplier that is written is not left out
            written = {k for k, name in enumerate(names) if name in residual.root.letters}
            possible = [written.isdisjoint(h.released) for h in self._hypotheses.listed]
            columns.append((left <= _HOLDS).all(axis=1) & possible)
        return np.stack(columns, axis=-1)

    def _fit_shares(self, residuals: Sequence[Residual]) -> Iterator[Mistake]:
        """Yield the properties of parts that a whole set of equations takes too large."""
        sample, right = self._truth.sample, self._hypotheses.right.terms
        if any(residual.sample is not sample for residual in residuals):
            return
        J = sample.slopes
        n, m, nv = J.shape
        held = any(r.root.letters & {*self._truth.multipliers} for r in residuals)
        unknowns = nv + m * held
        kept = np.pad(J, ((0, 0), (0, 0), (0, unknowns - nv)))
        rows = np.stack([r.by_unknown[:, :unknowns] for r in residuals], axis=1)
        whole = np.stack([r.values.whole for r in residuals], axis=1)
        step = _solve(np.hstack([rows, kept]), np.hstack([-whole, np.zeros((n, m))]))
        if step is None:
            return
        # what is left of each balance of forces; without multipliers, along the allowed motions
        a, off = sample.a + step[:, :nv], np.einsum("nij,nj->ni", right.M, step[:, :nv])
        size = np.einsum("nij,nj->ni", np.abs(right.M), np.abs(a)) + np.abs(right.rest)
        size += np.einsum("nmi,nm->ni", np.abs(J), np.abs(sample.multipliers))
        along = np.eye(nv) - np.linalg.pinv(J) @ J
        if held:
            off -= np.einsum("nmi,nm->ni", J, step[:, nv:])
            along = np.broadcast_to(np.eye(nv), along.shape)
        for share in self._hypotheses.shares:
            spend()
            acting = np.einsum("nij,nj->ni", share.terms.M, a) + share.terms.rest
            given, part = (np.einsum("nij,nj->ni", along, force) for force in (off, acting))
            more = -(given * part).sum(axis=1) / (part * part).sum(axis=1)
            left = np.abs(given + more[:, None] * part)
            # where nothing is left, terms of this size have cancelled up to rounding
            allowed = ALIKE * (np.abs(given) + np.abs(part)) + _SAME_TERMS * size
            agree = (left <= allowed).all() and bool(np.ptp(more) <= ALIKE * np.abs(more).max())
            mistake = share.say(1 + float(more.mean())) if agree else None
            if mistake is not None:
                yield mistake

    def _find_other_terms(self, residual: Residual, text: str) -> Iterator[Mistake]:
        """Yield terms of an equation that stand in place of others of a row as it is derived."""
        right, slopes = self._hypotheses.right, residual.by_acceleration
        tape, whole = residual.tape, residual.values
        if not residual.root.letters & {*self.context.units}:
            return  # numbers stand for all parameters
        needed = needed_values(tape, whole, np.zeros(residual.sample.count))
        for k, row in enumerate(right.derivation.h):
            column = int(np.abs(right.terms.M[:, k]).sum(axis=0).argmax())
            scale = slopes[:, column] / right.terms.M[:, k, column]
            if not np.allclose(slopes, scale[:, None] * right.terms.M[:, k], rtol=ALIKE, atol=0.0):
                continue
            # of a row M a + h − Q, on whichever side of the equation its terms are written
            parts = [s for side in (row, right.derivation.Q[k]) for s in (side, *side.split())]
            values = [(part, scale * right.value(part)) for part in dict.fromkeys(parts) if part]
            for place, node in enumerate(tape.nodes):
                written = node.quote(text)
                is_term = tape.nodes[tape.parents[place]].kind == "sum" and written
                # a term of a product of matrices is not written as such
                if is_term and all(written.count(a) == written.count(b) for a, b in ("[]", "()")):
                    for series, value in values:
                        if _alike(np.abs(needed[place]), np.abs(value)):
                            # the sign that moves a side to the left is not written
                            moved = node.kind == "negative" and written[0] not in "-−"
                            same = _alike(needed[place], value) != moved
                            term = expression(series if same else -series).text()
                            said = f"'{written}' stands in place of the term {term}"
                            yield Mistake("term", said, written, _UNLIKELY)

    def _find_exact(self, residual: Residual) -> tuple[str, ...]:
        """Return which of "M" and "rest" of a row stand in an equation as they are derived."""
        # a slip in both that leads to the same motion is not what is wrong there
        sample, right = self._truth.sample, self._hypotheses.right.terms
        if residual.sample is not sample or self._truth.derivation is None:
            return ()
        if len(self._truth.multipliers) and not residual.root.letters & {*self._truth.multipliers}:
            return ()  # those who eliminate multipliers write no row as it is derived
        slopes = residual.by_acceleration
        rest = residual.values.whole - np.einsum("nv,nv->n", slopes, sample.a)
        exact = []
        for name, given, true in (("M", slopes, right.M), ("rest", rest, right.rest)):
            rows = np.moveaxis(true, 1, 0)
            if any(row.any() and _alike(np.abs(given), np.abs(row)) for row in rows):
                exact.append(name)
        return tuple(exact)

    def _contradict(self, exact: Sequence[str]) -> npt.NDArray[np.bool_]:
        """Return whether each hypothesis changes what stands in an equation as it should."""
        right = self._hypotheses.right.terms
        changed = np.zeros(len(self._hypotheses.listed), dtype=bool)
        for k, hypothesis in enumerate(self._hypotheses.listed):
            for name in exact:
                changed[k] |= not _alike(getattr(hypothesis.terms, name), getattr(right, name))
        return changed

    def _list_likeliest(
        self, chosen: npt.NDArray[np.bool_], more: Array, number: int
    ) -> list[Mistake]:
        """Return the likeliest of the hypotheses that are chosen."""
        mistakes = [
            self._hypotheses.listed[h].mistake(float(more[h]), number)
            for h in np.flatnonzero(chosen)
        ]
        return sorted(mistakes, key=lambda mistake: mistake.weight)[:_MOST]


def _solve(rows: Array, right: Array) -> Array | None:
    """Return the solution (n, unknowns) of equations that agree and determine it, else None."""
    size = np.linalg.norm(rows, axis=2)
    size[size == 0] = 1.0
    rows, right = rows / size[..., None], right / size
    if not (
        np.isfinite(rows).all() and np.isfinite(right).all() and rows.shape[1] >= rows.shape[2]
    ):
        return None
    if np.linalg.svd(rows, compute_uv=False)[:, -1].min() < _SAME_TERMS:
        return None
    solution = np.einsum("nij,nj->ni", np.linalg.pinv(rows), right)
    terms = rows * solution[:, None]
    agree = np.abs(terms.sum(axis=2) - right) <= ALIKE * (np.abs(terms).sum(axis=2) + np.abs(right))
    return solution if agree.all() else None


def _alike(given: Array, true: Array) -> bool:
    return np.allclose(given, true, rtol=ALIKE, atol=0.0)


def _list_open(
    formula: Judged, judged: Sequence[Judged], quantity: AskedQuantity
) -> Iterator[tuple[Residual, Mapping[str, Series]]]:
    """Yield a wrong formula with what it may be meant to be: the residual, and the series.

    It may be each of several values that no other line gives, or a quantity without its constant.
    """
    residual = formula.residual
    assert residual is not None, "it is explained by one"
    sample, values = residual.sample, quantity.values

    def mean(more: Mapping[str, Array]) -> Residual:
        return replace(residual, sample=replace(sample, values={**sample.values, **more}))

    if quantity.kind == "several" and values is not None:
        given = sum((line.says.sum(axis=0) for line in judged if line.holds), np.zeros(1))
        still_open = values[~(np.broadcast_to(given, len(values)) > 0)]
        for omega in still_open if len(still_open) else values:
            yield mean(measure(omega, quantity.letters)), formula.series
        return
    yield residual, formula.series
    series = next(iter(formula.series.values()), None)
    if quantity.kind == "up to a constant" and values is not None and series is not None:
        fixed = {Kind.PARAMETER, Kind.CONSTANT}
        constant = series.ring.sum([term for term in series.split() if term.kinds <= fixed])
        if constant:
            less = values - Evaluation(series.ring, sample.values)(constant)
            letters = quantity.letters
            yield mean(dict.fromkeys(letters, less)), dict.fromkeys(letters, series - constant)


def _misfits(
    units: LetterUnits,
    residual: Residual,
    number: int,
    text: str,
    defined: Mapping[str, Node] = MappingProxyType({}),
) -> list[Mistake]:
    try:
        units.find(residual.root, text)
    except UnitMisfitError as fault:
        part = fault.part.quote(text)
        if odd := units.list_odd(defined):
            what = f"the units do not match: the terms that define {', '.join(odd)} differ in units"
            return [Mistake("units", what, equation=number)]
        definitions = [
            units.describe(name, node) for name, node in defined.items() if name in fault.text
        ]
        return [Mistake("units", "; ".join([fault.text, *definitions]), part, equation=number)]
    return []


def _list_in_time(mistakes: Iterable[Mistake]) -> list[Mistake]:
    """Return mistakes, those listed until time or parts were spent, and that they were."""
    listed: list[Mistake] = []
    try:
        listed.extend(mistakes)
    except SpentError as spent:
        ended = f"the search for causes ended after {spent.most}"
        listed.append(Mistake("time", ended, "", math.inf))
    return listed


def _in_equation(mistakes: Iterable[Mistake], number: int) -> list[Mistake]:
    return [replace(mistake, equation=number) for mistake in mistakes]


def _rank(misfits: Sequence[Mistake], mistakes: Iterable[Mistake]) -> tuple[Mistake, ...]:
    """Return mistakes by weight, each once; those about units come first."""
    order = sorted(mistakes, key=lambda mistake: mistake.weight)
    # a missing root, or a period for a frequency, says why the units do not match
    measures = [mistake for mistake in order if mistake.kind == "measure"]
    if order and order[0].kind != TWO_SLIPS:
        # two slips at once explain nothing that a likelier one explains
        order = [mistake for mistake in order if mistake.kind != TWO_SLIPS]
    return tuple(dict.fromkeys([*measures, *misfits, *order]))[:_MOST]
