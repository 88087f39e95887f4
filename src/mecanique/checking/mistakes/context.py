"""List what an author may have meant by the parts of a formula."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cached_property
from itertools import permutations
from typing import final

import numpy as np

from mecanique.arrays import Array
from mecanique.checking.grammar.letters import Letters
from mecanique.checking.mistakes.units import Units
from mecanique.model.mechanism import Mechanism


@final
class Context:
    """The likely intentions behind parts of formulas about a mechanism.

    Args:
        mechanism: any mechanism.
        letters: the letters of formulas.
        units: the units of the letters.
        values: the values of all letters, shape (n,) or ().
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
        """The possible arguments of sine and cosine, by their formula."""
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
        """Kind and value of each factor that a term may lack, by its formula."""
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
        """Yield alternatives to a letter, with their values."""
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
