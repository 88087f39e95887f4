"""Single changes of a submitted formula that would make it right.

What each part would have to be is known at every state; a part is explained where that is always
the same known quantity: the part with the other sign, cos for sin, another letter.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from itertools import permutations
from typing import final

import numpy as np
import numpy.typing as npt

from mecanique.arrays import Array
from mecanique.checking.grammar.letters import Letters
from mecanique.checking.grammar.tape import Tape, Values
from mecanique.checking.grammar.tree import Node
from mecanique.checking.mistakes.needed import needed_values
from mecanique.checking.mistakes.units import Units
from mecanique.model.mechanism import Mechanism

__all__ = ["Context", "Repair", "repairs"]

_ALIKE = 1e-6
"""Two values at one state that differ by less than this part are one."""

_FEWEST = 6
_SIMPLE = 60
"""Factors with numerators and denominators up to this are named."""

_INERTIAS = {Fraction(4), Fraction(1, 4), Fraction(3), Fraction(1, 3), Fraction(12)}


@final
@dataclass(frozen=True)
class Repair:
    """A change of one part that makes a formula right.

    Args:
        kind: of the mistake.
        text: what is wrong, in words.
        part: the part as it was written.
        weight: the smaller, the likelier.
    """

    kind: str
    text: str
    part: str
    weight: float


@final
class Context:
    """What parts of formulas on a mechanism may have been meant to be.

    Args:
        mechanism: any mechanism.
        letters: the letters of formulas.
        units: of the letters.
        values: of all letters, shape (n,) or ().
        count: number of states.
    """

    def __init__(
        self,
        mechanism: Mechanism,
        letters: Letters,
        units: Units,
        values: Mapping[str, Array],
        count: int,
    ) -> None:
        self._dimensions = units.of
        self.values = {
            name: np.broadcast_to(np.asarray(value, dtype=float), (count,))
            for name, value in values.items()
        }
        self.units = {p.symbol: p.unit for p in mechanism.parameters}
        self.coordinates = tuple(mechanism.coordinates)
        self.velocities = mechanism.velocities
        self.accelerations = tuple(f"{name}'" for name in mechanism.velocities)
        self.angles = [name for name in self.coordinates if name in letters.angles]

    @cached_property
    def arguments(self) -> dict[str, Array]:
        """Angles that sine and cosine may be taken of, by their formula."""
        values = self.values
        found = {name: values[name] for name in self.angles}
        for one, other in permutations(self.angles, 2):
            found[f"{one} - {other}"] = values[one] - values[other]
            if one < other:
                found[f"{one} + {other}"] = values[one] + values[other]
        for name in tuple(found):
            found[f"2 {name}" if " " not in name else f"2 ({name})"] = 2 * found[name]
        return found

    @cached_property
    def factors(self) -> dict[str, tuple[str, Array]]:
        """Kind and value of what a term may lack as a factor, by its formula."""
        found: dict[str, tuple[str, Array]] = {}
        for symbol in self.units:
            value = self.values[symbol]
            found[symbol] = ("factor missing", value)
            found[f"{symbol}^2"] = ("factor missing", value * value)
        for one, other in permutations(self.units, 2):
            if self.units[one] == self.units[other]:
                found[f"{one}/{other}"] = ("letter", self.values[one] / self.values[other])
        for name in (*self.coordinates, *self.velocities):
            found[name] = ("factor missing", self.values[name])
        for formula, value in self.arguments.items():
            found[f"cos({formula})"] = ("small angle", np.cos(value))
            found[f"sin({formula})"] = ("factor missing", np.sin(value))
            tangent = np.tan(value)
            found[f"tan({formula})"] = ("sin for cos", tangent)
            found[f"tan({formula})^2"] = ("sin for cos", tangent * tangent)
        return found

    @cached_property
    def ratios(self) -> Array:
        """The factors, then their inverses, shape (2 k, n)."""
        with np.errstate(all="ignore"):
            stacked = np.stack([value for _, value in self.factors.values()])
            return np.concatenate([stacked, 1 / stacked])

    def alternatives(self, name: str) -> Iterator[tuple[str, Array]]:
        """Yield what may have been meant by a letter, with its values."""
        values = self.values
        own = self._dimensions.get(name)
        fixed = [*self.units, *self.coordinates]
        if name in fixed and own is not None:
            group = [other for other in fixed if self._dimensions.get(other) == own]
            yield from ((other, values[other]) for other in group if other != name)
            if self.units.get(name) == "kg":
                yield from self._sums(group)
        for family in (self.coordinates, self.velocities, self.accelerations):
            if name in family:
                yield from ((other, values[other]) for other in family if other != name)
                yield from self._combinations(name, family)

    def _sums(self, group: list[str]) -> Iterator[tuple[str, Array]]:
        for k, one in enumerate(group):
            for other in group[k + 1 :]:
                yield f"{one} + {other}", self.values[one] + self.values[other]
        if len(group) > 2:
            yield " + ".join(group), sum((self.values[one] for one in group), np.zeros(()))

    def _combinations(self, name: str, family: tuple[str, ...]) -> Iterator[tuple[str, Array]]:
        values = self.values
        for other in family:
            if other != name:
                yield f"{name} + {other}", values[name] + values[other]
                yield f"{name} - {other}", values[name] - values[other]
                yield f"{other} - {name}", values[other] - values[name]


def repairs(
    tape: Tape, values: Values, target: Array, context: Context, text: str
) -> Iterator[Repair]:
    """Yield the changes of single parts that make a formula right.

    Args:
        tape: the formula.
        values: of its parts at the states.
        target: what the whole should be.
        context: what may have been meant.
        text: what the formula was read from.
    """
    needed = needed_values(tape, values, target)
    finite = np.isfinite(values.whole)
    explained: set[int] = set()
    for k in range(len(tape.nodes) - 1, -1, -1):
        parent = tape.parents[k]
        if parent in explained and tape.nodes[parent].kind in ("product", "quotient", "negative"):
            # its factors would need the same change
            explained.add(k)
            continue
        want, have = needed[k], values.parts[k]
        usable = finite & np.isfinite(want)
        if usable.sum() < min(_FEWEST, len(finite)) or not usable.any():
            continue
        one = _Part(tape, k, have[usable], want[usable], usable, context, text, values)
        whole = list(one.find())
        if any(repair.kind in ("sign", "extra", "factor", "inertia") for repair in whole):
            explained.add(k)
        yield from whole


@final
@dataclass(frozen=True, eq=False)
class _Part:
    """A part of a formula, what it is and what it would have to be.

    Args:
        tape: the formula.
        place: of the part in it.
        have: its values.
        want: the values it would need.
        usable: at which states.
        context: what may have been meant.
        text: what the formula was read from.
        values: of all parts.
    """

    tape: Tape
    place: int
    have: Array
    want: Array
    usable: npt.NDArray[np.bool_]
    context: Context
    text: str
    values: Values

    @property
    def node(self) -> Node:
        return self.tape.nodes[self.place]

    @cached_property
    def quoted(self) -> str:
        return " ".join(self.text[self.node.start : self.node.end].split())

    @property
    def is_term(self) -> bool:
        """Whether it is a term of a sum, or the whole."""
        parent = self.tape.parents[self.place]
        return parent < 0 or self.tape.nodes[parent].kind == "sum"

    def is_alike(self, value: Array) -> bool:
        """Whether a value is what is needed, at all states."""
        scale = np.abs(value) + np.abs(self.want)
        return bool((np.abs(value - self.want) <= _ALIKE * scale).all())

    def find(self) -> Iterator[Repair]:
        """Yield what would mend the part."""
        if self.is_term and self.tape.parents[self.place] >= 0:
            yield from self._as_term()
        node = self.node
        if node.kind == "letter":
            yield from self._as_letter()
        elif node.kind == "call" and node.name in ("sin", "cos"):
            yield from self._as_circular()
        elif node.kind == "power":
            yield from self._as_power()
        elif node.kind == "sum":
            yield from self._as_sum()
        elif node.kind == "number":
            yield from self._as_number()

    def _as_number(self) -> Iterator[Repair]:
        ratio = self.want
        spread = float(np.ptp(ratio))
        parent = self.tape.nodes[self.tape.parents[self.place]]
        if parent.kind == "power" or spread > _ALIKE * float(np.abs(ratio).max()):
            return
        found = Fraction(float(ratio.mean())).limit_denominator(_SIMPLE)
        if found and abs(float(found) / float(ratio.mean()) - 1) < _ALIKE and not self.is_term:
            yield Repair(
                "factor", f"the number '{self.quoted}' should be {found}", self.quoted, 1.6
            )

    def _as_term(self) -> Iterator[Repair]:
        with np.errstate(all="ignore"):
            ratio = self.want / self.have
        if not np.isfinite(ratio).all():
            return
        size = self.values.sizes[self.tape.parents[self.place]][self.usable]
        if (np.abs(self.want) <= 1e-9 * size).all():
            text = f"the term '{self.quoted}' does not belong there"
            yield Repair("extra", text, self.quoted, 2.2)
            return
        mean = float(ratio.mean())
        if float(np.ptp(ratio)) <= _ALIKE * abs(mean):
            yield from self._by_number(mean)
            return
        rows = self.context.ratios[:, self.usable]
        alike = (np.abs(rows - ratio) <= _ALIKE * (np.abs(rows) + np.abs(ratio))).all(axis=1)
        alike |= (np.abs(rows + ratio) <= _ALIKE * (np.abs(rows) + np.abs(ratio))).all(axis=1)
        names = list(self.context.factors)
        for place in np.flatnonzero(alike):
            name = names[place % len(names)]
            kind = self.context.factors[name][0]
            if kind == "sin for cos":
                formula = name[3:].removesuffix("^2")
                pair = ("sin", "cos") if place < len(names) else ("cos", "sin")
                text = (
                    f"in the term '{self.quoted}' {pair[1]}{formula} stands for {pair[0]}{formula}"
                )
                yield Repair(kind, text, self.quoted, 1.7)
            elif kind == "letter":
                pair = name.split("/") if place < len(names) else name.split("/")[::-1]
                text = f"in the term '{self.quoted}' {pair[1]} stands for {pair[0]}"
                yield Repair(kind, text, self.quoted, 1.7)
            elif place >= len(names):
                text = f"the factor {name} does not belong into the term '{self.quoted}'"
                yield Repair("factor surplus", text, self.quoted, 2.0)
            elif kind == "small angle":
                text = (
                    f"the term '{self.quoted}' lacks the factor {name}: as if the angle were small"
                )
                yield Repair(kind, text, self.quoted, 1.8)
            else:
                text = f"the term '{self.quoted}' lacks the factor {name}"
                yield Repair(kind, text, self.quoted, 2.0)

    def _by_number(self, ratio: float) -> Iterator[Repair]:
        found = Fraction(ratio).limit_denominator(_SIMPLE)
        close = found != 0 and abs(ratio / float(found) - 1) < _ALIKE
        if found == -1 and close:
            text = f"the sign of the term '{self.quoted}' is wrong"
            yield Repair("sign", text, self.quoted, 1.0)
        elif close and found in _INERTIAS and self._is_inertial:
            text = (
                f"the term '{self.quoted}' should be {found} times as large: the inertia may be "
                "taken about the wrong point (center or pin) or of the wrong body"
            )
            yield Repair("inertia", text, self.quoted, 1.5)
        elif close and found > 0:
            text = {
                Fraction(2): f"the term '{self.quoted}' is half of what it should be",
                Fraction(1, 2): f"the term '{self.quoted}' is twice what it should be",
            }.get(found, f"the term '{self.quoted}' should be {found} times as large")
            yield Repair("factor", text, self.quoted, 1.4)
        elif close:
            text = f"the term '{self.quoted}' should be multiplied by {found}"
            yield Repair("factor", text, self.quoted, 2.4)
        else:
            text = f"the term '{self.quoted}' should be {ratio:.6g} times as large"
            yield Repair("factor", text, self.quoted, 2.6)

    @property
    def _is_inertial(self) -> bool:
        return bool(self.node.letters & set(self.context.accelerations))

    def _as_letter(self) -> Iterator[Repair]:
        name = self.node.name
        context = self.context
        for other, value in context.alternatives(name):
            if self.is_alike(value[self.usable]):
                angular = name in context.units
                kind = "letter" if angular else "angle"
                text = f"{self._here} stands {self._where}where {other} should"
                # a sum for a letter is a term that is missing
                yield Repair(kind, text, self.quoted, 2.05 if "+" in other else 1.3)
        if name in context.angles:
            for function, shape in (("sin", np.sin), ("tan", np.tan)):
                if self.is_alike(shape(self.have)):
                    text = (
                        f"{self._here} stands {self._where}for {function}({name}): the angle is "
                        "taken as small"
                    )
                    yield Repair("small angle", text, self.quoted, 1.0)
        if name in context.units or name in context.velocities or name in context.coordinates:
            for shown, value in (
                (f"{name}^2", self.have**2),
                (f"{name}^3", self.have**3),
                ("1", np.ones_like(self.have)),
            ):
                if self.is_alike(value):
                    text = f"{self._here} stands {self._where}where {shown} should"
                    yield Repair("power", text, self.quoted, 1.7)

    @property
    def _here(self) -> str:
        return self.quoted or self.node.name

    @property
    def _where(self) -> str:
        """The term that the part stands in, in words."""
        place = self.place
        while place >= 0 and (
            self.tape.parents[place] >= 0
            and self.tape.nodes[self.tape.parents[place]].kind != "sum"
        ):
            place = self.tape.parents[place]
        node = self.tape.nodes[place]
        if place == self.place or node.end <= node.start:
            return ""
        return f"in '{' '.join(self.text[node.start : node.end].split())}' "

    def _as_circular(self) -> Iterator[Repair]:
        name, argument = self.node.name, self.node.parts[0]
        inner = self.values.parts[self.tape.parts[self.place][0]][self.usable]
        own, other = (np.sin, np.cos) if name == "sin" else (np.cos, np.sin)
        turned = "cos" if name == "sin" else "sin"
        for sign, words in ((1, ""), (-1, "−")):
            if self.is_alike(sign * other(inner)):
                text = f"'{self.quoted}' {self._where}should be {words}{turned}"
                yield Repair("sin for cos", text, self.quoted, 1.0 + 0.3 * (sign < 0))
        for formula, value in self.context.arguments.items():
            angle = value[self.usable]
            alike = bool((np.abs(angle - inner) <= _ALIKE).all())
            if not alike and self.is_alike(own(angle)):
                text = (
                    f"'{self.quoted}' {self._where}should be {name}({formula}): relative and "
                    "absolute angles are mixed up"
                )
                yield Repair("angle", text, self.quoted, 1.2)
            elif not alike and self.is_alike(other(angle)):
                text = f"'{self.quoted}' {self._where}should be {turned}({formula})"
                yield Repair("angle", text, self.quoted, 2.2)
        if self.is_alike(np.ones_like(inner)) and argument.letters:
            text = f"the factor '{self.quoted}' does not belong {self._where or 'there'}"
            yield Repair("factor surplus", text, self.quoted, 2.0)

    def _as_power(self) -> Iterator[Repair]:
        base = self.values.parts[self.tape.parts[self.place][0]][self.usable]
        for exponent in (1, 2, 3, 4, 0, -1):
            with np.errstate(all="ignore"):
                value = np.abs(base) ** exponent if exponent in (2, 4) else base**exponent
            if self.is_alike(np.asarray(value, dtype=float)):
                letter = self.node.parts[0]
                shown = " ".join(self.text[letter.start : letter.end].split())
                right = {0: "1", 1: shown}.get(exponent, f"{shown}^{exponent}")
                text = f"'{self.quoted}' {self._where}should be {right}"
                yield Repair("power", text, self.quoted, 1.5)
        exponent_node = self.node.parts[1]
        velocity = self.node.parts[0].name
        if velocity in self.context.velocities and exponent_node.value == 2:
            for other in self.context.velocities:
                product = self.context.values[other][self.usable] * base
                if other != velocity and self.is_alike(product):
                    text = f"'{self.quoted}' {self._where}should be {velocity} {other}"
                    yield Repair("angle", text, self.quoted, 1.4)

    def _as_sum(self) -> Iterator[Repair]:
        angular = self.node.letters and self.node.letters <= set(self.context.angles)
        if angular and self.is_alike(np.sin(self.have)):
            text = f"'{self.quoted}' stands for its sine: the angle is taken as small"
            yield Repair("small angle", text, self.quoted, 1.0)
        short = self.want - self.have
        group = [name for name in self.node.letters if name in self.context.units]
        units = {self.context.units[name] for name in group}
        if len(units) == 1 and group and self.tape.parents[self.place] >= 0:
            for name, unit in self.context.units.items():
                value = self.context.values[name][self.usable]
                alike = (np.abs(short - value) <= _ALIKE * np.abs(value)).all()
                if unit in units and alike:
                    text = f"{name} is missing in the sum '{self.quoted}'"
                    yield Repair("letter", text, self.quoted, 1.4)
