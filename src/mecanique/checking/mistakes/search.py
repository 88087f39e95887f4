"""Search for mistakes in equations of motion, the likeliest first."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from itertools import combinations, permutations
from types import MappingProxyType
from typing import TypeAlias, final

import numpy as np
import numpy.typing as npt

from mecanique.arrays import Array
from mecanique.checking.budget import SECONDS, OutOfTimeError, spend
from mecanique.checking.grammar import tree
from mecanique.checking.grammar.letters import KnownLetters
from mecanique.checking.grammar.reader import Statement
from mecanique.checking.grammar.tape import FormulaTape, needed_values
from mecanique.checking.grammar.tree import Node, rate
from mecanique.checking.judgement.formula import Judged
from mecanique.checking.judgement.motion import Residual, combine_angles, residuals
from mecanique.checking.judgement.quantities import AskedQuantity
from mecanique.checking.judgement.truth import Truth
from mecanique.checking.mistakes.hypotheses import (
    MULTIPLES,
    Hypotheses,
    WrongDerivation,
    list_parts,
)
from mecanique.checking.mistakes.of_quantities import QuantityMistakes
from mecanique.checking.mistakes.units import LetterUnits, UnitMisfitError
from mecanique.checking.verdict import Mistake
from mecanique.derivation.printing.equations import expression
from mecanique.derivation.scalars.evaluation import Evaluation
from mecanique.derivation.scalars.series import Series
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
        arguments = combine_angles(self.angles, self.values)
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
                factors[f"{first}/{second}"] = ("letter", self.values[first] / self.values[second])
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
            if self.units.get(name) == "kg":
                yield from self._sums(group)
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


ALIKE = 1e-6
"""Two values in a state are equal if they differ by less than this part."""

SIMPLE = 60
"""Factors with a denominator up to this are written as fractions."""


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

    def values_of(self, place: int) -> Array:
        """Return the present values of another part, where both of this one are known."""
        return self.residual.values.parts[place][self.usable]


_Candidate: TypeAlias = tuple[Array, str, str, float]
"""A value that a part may be meant to have; the mistake's kind, its words and its weight."""


def repair_number(part: FormulaPart) -> Iterator[Mistake]:
    """Yield repairs of a number."""
    ratio = part.want
    spread = float(np.ptp(ratio))
    parent = part.tape.nodes[part.tape.parents[part.place]]
    if parent.kind == "power" or spread > ALIKE * float(np.abs(ratio).max()):
        return
    factor = Fraction(float(ratio.mean())).limit_denominator(SIMPLE)
    if factor and abs(float(factor) / float(ratio.mean()) - 1) < ALIKE and not part.is_term:
        yield Mistake("factor", f"the number '{part.quoted}' should be {factor}", part.quoted, 1.6)


def _vary_letter(part: FormulaPart) -> Iterator[_Candidate]:
    """Yield what a letter may stand for: another one, its sine, a power."""
    name = part.node.name
    context = part.context
    have = part.have
    said = f"{part.here} {part.where}should be"
    for spelled, value in context.alternatives(name):
        # a sum in place of a letter is a missing term
        weight = 2.05 if "+" in spelled else 1.3
        kind = "letter" if name in context.units else "angle"
        yield value[part.usable], kind, f"{said} {spelled}", weight
    for function, shape in (("sin", np.sin), ("tan", np.tan)) if name in context.angles else ():
        text = f"{said} {function}({name}): the angle is assumed to be small"
        yield shape(have), "small angle", text, 1.0
    if name in context.units or name in context.velocities or name in context.coordinates:
        yield have**2, "power", f"{said} {name}^2", 1.7
        yield have**3, "power", f"{said} {name}^3", 1.7
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
    degrees = (np.radians(inner), np.degrees(inner))
    for angle in degrees:
        text = f"'{part.quoted}' {part.where}is taken in degrees: angles are in radians"
        yield written(angle), "degree", text, 0.8
    for formula, value in part.context.arguments.items():
        angle = value[part.usable]
        if not any((np.abs(angle - known) <= ALIKE).all() for known in (inner, *degrees)):
            text = f"{said} {name}({formula}): relative and absolute angles are mixed up"
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
    for exponent in (1, 2, 3, 4, 0, -1):
        value = np.abs(base) ** exponent if exponent in (2, 4) else base**exponent
        right = {0: "1", 1: shown}.get(exponent, f"{shown}^{exponent}")
        yield np.asarray(value, dtype=float), "power", f"{said} {right}", 1.5
    if exponent_node.value != 2:
        return
    if letter.kind == "sum":
        squares = [part.values_of(k) ** 2 for k in part.tape.parts[place]]
        yield np.sum(squares, axis=0), "power", f"{said} the sum of the squares", 1.2
    for second in part.context.velocities if letter.name in part.context.velocities else ():
        if second != letter.name:
            product = part.context.values[second][part.usable] * base
            yield product, "angle", f"{said} {letter.name} {second}", 1.4


def _vary_sum(part: FormulaPart) -> Iterator[_Candidate]:
    """Yield what a sum may stand for: its sine, one with a letter more."""
    context = part.context
    letters = part.node.letters
    if letters and letters <= set(context.angles):
        text = f"'{part.quoted}' should be its sine: the angle is assumed to be small"
        yield np.sin(part.have), "small angle", text, 1.0
    units = {context.units[name] for name in letters if name in context.units}
    masses = [name for name in sorted(letters) if context.units.get(name) == "kg"]
    if len(masses) == len(letters) == len(part.node.parts) == 2:
        first, second = masses
        reduced = f"the reduced mass {first} {second}/({first} + {second})"
        product = context.values[first] * context.values[second]
        yield product[part.usable] / part.have, "mass", f"'{part.quoted}' should be {reduced}", 1.4
    if len(units) == 1 and part.tape.parents[part.place] >= 0:
        for name, unit in context.units.items():
            if unit in units:
                more = part.have + context.values[name][part.usable]
                yield more, "letter", f"{name} is missing from the sum '{part.quoted}'", 1.4


_ABOUT = "the inertia may be taken about the wrong point (center or pin) or of the wrong body"
_INERTIAS = {
    **dict.fromkeys((Fraction(4), Fraction(1, 4), Fraction(3), Fraction(1, 3)), _ABOUT),
    Fraction(12): _ABOUT,
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
        yield Mistake("extra", text, part.quoted, 2.2)
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
        elif kind == "letter":
            pair = name.split("/") if place < len(names) else name.split("/")[::-1]
            text = f"in the term '{part.quoted}' {pair[1]} should be {pair[0]}"
            # a sum in place of a letter is a missing term
            yield Mistake(kind, text, part.quoted, 2.05 if "+" in pair[0] else 1.7)
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


def _contains(node: Node, factor: str) -> bool:
    """Whether a letter or a function such as cos(q)^2 occurs in a part."""
    word = re.split(r"[(^]", factor)[0]
    return any(word == inner.name for inner in node.walk())


def _scale(part: FormulaPart, ratio: float) -> Iterator[Mistake]:
    factor = Fraction(ratio).limit_denominator(SIMPLE)
    close = factor != 0 and abs(ratio / float(factor) - 1) < ALIKE
    if factor == -1 and close:
        text = f"the sign of the term '{part.quoted}' is wrong"
        yield Mistake("sign", text, part.quoted, 1.0)
    elif close and factor in _INERTIAS and _is_inertial(part):
        text = f"the term '{part.quoted}' should be {factor} times as large: {_INERTIAS[factor]}"
        yield Mistake("inertia", text, part.quoted, 1.5)
    elif close and factor > 0:
        text = {
            Fraction(2): f"the term '{part.quoted}' is half of what it should be",
            Fraction(1, 2): f"the term '{part.quoted}' is twice what it should be",
        }.get(factor, f"the term '{part.quoted}' should be {factor} times as large")
        yield Mistake("factor", text, part.quoted, 1.4)
    elif close:
        text = f"the term '{part.quoted}' should be multiplied by {factor}"
        yield Mistake("factor", text, part.quoted, 2.4)
    else:
        square = Fraction(ratio * ratio).limit_denominator(SIMPLE)
        shown = f"{ratio:.6g}"
        if square and abs(ratio * ratio / float(square) - 1) < ALIKE and ratio > 0:
            shown = f"√({square})"
        if shown in ("0", "1", "√(1)"):
            return
        text = f"the term '{part.quoted}' should be {shown} times as large"
        yield Mistake("factor", text, part.quoted, 2.6)


_MOMENT = read_unit("kg·m²")


def _is_inertial(part: FormulaPart) -> bool:
    """Whether a term holds an acceleration, or is a moment of inertia."""
    if part.node.letters & set(part.context.accelerations):
        return True
    try:
        return part.context.dimension_of(part.node, part.text) == _MOMENT
    except UnitMisfitError:
        return False


_FEWEST = 6
"""Least number of states in which a part must have a value."""


def repairs(residual: Residual, context: Context, text: str) -> Iterator[Mistake]:
    """Yield the changes of single parts that make a formula right."""
    tape, values = residual.tape, residual.values
    needed = needed_values(tape, values, np.zeros(residual.sample.count))
    finite = np.isfinite(values.whole)
    explained: set[int] = set()
    for k in range(len(tape.nodes) - 1, -1, -1):
        spend()
        parent = tape.parents[k]
        if parent in explained and tape.nodes[parent].kind in ("product", "quotient", "negative"):
            # its factors would need the same change
            explained.add(k)
            continue
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
        whole = list(_find(whole_part))
        if any(repair.kind in ("sign", "extra", "factor", "inertia") for repair in whole):
            explained.add(k)
        yield from whole


def _find(part: FormulaPart) -> Iterator[Mistake]:
    """Yield repairs of a part."""
    if part.is_term and part.tape.parents[part.place] >= 0:
        yield from repair_term(part)
    node = part.node
    if node.kind == "number":
        yield from repair_number(part)
    vary = {"letter": _vary_letter, "power": _vary_power, "sum": _vary_sum}.get(node.kind)
    if node.kind == "call" and node.name in _WAVES:
        vary = _vary_wave
    for value, kind, text, weight in vary(part) if vary else ():
        if part.is_alike(value):
            yield Mistake(kind, text, part.quoted, weight)


_MOST_PAIRED = 60
"""Two terms at once are sought among no more than these."""


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
    parts = [*list_parts(truth, residual.truth.velocities), truth]
    values = [np.broadcast_to(evaluated(part), lacks.shape) for part in parts]

    def is_lacking(more: Array) -> bool:
        spend()
        scale = np.abs(more) + np.abs(lacks)
        return bool((np.abs(lacks - more) <= ALIKE * scale)[usable].all())

    few = list(zip(parts, values, strict=True))[: _MOST_PAIRED + 1]
    for (part, alone), (second, more) in combinations(few, 2) if len(few) <= _MOST_PAIRED else ():
        if part + second != truth and is_lacking(alone + more):
            said = f"{expression(part).text()} and {expression(second).text()}"
            yield Mistake("missing", f"the terms {said} are missing", "", 1.9)
    for part, part_values in zip(parts[:-1], values, strict=False):
        if truth - part not in parts and is_lacking(values[-1] - part_values):
            text = f"only {expression(part).text()} is there: {expression(truth - part).text()}"
            yield Mistake("missing", f"{text} is missing", "", 1.8)
    for part, part_values in zip(parts, values, strict=True):
        for factor, kind, words in MULTIPLES:
            if is_lacking((1.0 - factor) * part_values):
                text = words.format(f"the term {expression(part).text()}")
                yield Mistake(kind, text, "", 1.1 if kind == "missing" else 1.6)


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
        if np.count_nonzero(~right) > 1:
            every = np.asarray(holds.all(axis=1))
            common = self._list_likeliest(every, np.full(len(holds), _SEVERAL), 0)
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
                mistakes = [*common, *self._list_likeliest(holds[:, k], denied, number)]
                if residual.sample is self._truth.sample:
                    repaired = _list_in_time(repairs(residual, self.context, text))
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
                causes = self._mend(formula.residual, formula.series, quantity, text)
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
        changes = _list_in_time(repairs(residual, self.context, text))
        mistakes = [mistake for mistake in changes if mistake.part or mistake is _ENDED]
        mistakes += _list_in_time(find_lacking(residual, series))
        mistakes += _list_in_time(self._of_quantities.explain(residual, quantity))
        if not mistakes:
            mistakes += _list_in_time(self._of_quantities.mutate(residual, quantity, text))
        return _rank(_misfits(self._units_with(quantity.dimensions), residual, 0, text), mistakes)

    @cached_property
    def _of_quantities(self) -> QuantityMistakes:
        return QuantityMistakes(self._truth, self._hypotheses)

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
        for series in self._of_quantities.list_constants():
            known = {**truth.sample.values, _CONSTANT: truth.at({})(series)}
            less = tree.add(tree.letter(_CONSTANT), tree.negate(root))
            residual = Residual(formula.statement, less, truth, replace(truth.sample, values=known))
            mistakes += _list_in_time(find_lacking(residual, {_CONSTANT: series}))
        try:
            slope = rate(root, self._letters.rate_nodes)
            line = Statement((slope, tree.number(0)), text, root.start)
            holds = self._hold(residuals([line], truth, truth.sample, text))
            mistakes += self._list_likeliest(holds[:, 0], np.full(len(holds), 0.4), 0)
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
        pairs = zip(self._hypotheses.listed, self._hypotheses.motions, strict=True)
        return sorted(pairs, key=lambda pair: pair[0].weight)

    def _hold(self, residuals: Sequence[Residual]) -> npt.NDArray[np.bool_]:
        """Return whether each equation holds for the accelerations of each hypothesis."""
        known = all(residual.sample is self._truth.sample for residual in residuals)
        right = all(residual.holds for residual in residuals)
        if not known or right or not self._hypotheses.listed:
            return np.zeros((0, len(residuals)), dtype=bool)
        step = self._hypotheses.motions - self._truth.sample.motion
        columns = []
        for residual in residuals:
            slopes = residual.by_unknown
            moved = np.einsum("nv,hnv->hn", slopes, step)
            size = residual.values.size + np.einsum("nv,hnv->hn", np.abs(slopes), np.abs(step))
            left = np.abs(residual.values.whole + moved) / size
            left[:, ~residual.finite] = 0.0
            columns.append((left <= _HOLDS).all(axis=1))
        return np.stack(columns, axis=-1)

    def _list_likeliest(
        self, chosen: npt.NDArray[np.bool_], more: Array, number: int
    ) -> list[Mistake]:
        """Return the likeliest of the hypotheses that are chosen."""
        mistakes = [
            self._hypotheses.listed[h].mistake(float(more[h]), number)
            for h in np.flatnonzero(chosen)
        ]
        return sorted(mistakes, key=lambda mistake: mistake.weight)[:_MOST]


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


_ENDED = Mistake("time", f"the search for causes ended after {SECONDS:g} s", "", math.inf)


def _list_in_time(mistakes: Iterable[Mistake]) -> list[Mistake]:
    """Return mistakes, those listed until the time was over, and that it was."""
    listed: list[Mistake] = []
    try:
        listed.extend(mistakes)
    except OutOfTimeError:
        listed.append(_ENDED)
    return listed


def _in_equation(mistakes: Iterable[Mistake], number: int) -> list[Mistake]:
    return [replace(mistake, equation=number) for mistake in mistakes]


def _rank(misfits: Sequence[Mistake], mistakes: Iterable[Mistake]) -> tuple[Mistake, ...]:
    """Return mistakes by weight, each once; those about units come first."""
    order = sorted(mistakes, key=lambda mistake: mistake.weight)
    # a missing root, or a period for a frequency, says why the units do not match
    measures = [mistake for mistake in order if mistake.kind == "measure"]
    return tuple(dict.fromkeys([*measures, *misfits, *order]))[:_MOST]
