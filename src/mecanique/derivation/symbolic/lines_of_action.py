"""The lines along which springs, dampers and drives act: lengths and joint coordinates, as series.

A length is a polynomial if its square is the square of a polynomial, else a named root.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, final

from mecanique.derivation.scalars.cancel import tidy
from mecanique.derivation.scalars.evaluation import evaluate
from mecanique.derivation.scalars.generators import Kind
from mecanique.derivation.scalars.ring import Ring
from mecanique.derivation.scalars.series import Series
from mecanique.derivation.symbolic.kinematics import Kinematics
from mecanique.derivation.symbolic.symbols import Algebra
from mecanique.derivation.symbolic.vectors import Vector, dot, zero
from mecanique.model.force_base import LineLoad


@final
@dataclass(frozen=True)
class Assumption:
    """An assumption of a closed form.

    Args:
        subject: its subject, e.g. "the length of spring1".
        positive: the series that must be positive.
    """

    subject: str
    positive: Series

    def holds(self, values: Mapping[str, Any]) -> bool:
        """Return whether it holds.

        Args:
            values: value of each coordinate, parameter and t, by name.
        """
        return bool(evaluate(self.positive, values) > 0)


@final
class Span:
    """The line between the ends of a force, as series.

    If the squared distance is the square of a polynomial, the distance is that polynomial, taken
    as positive where all coordinates are zero; otherwise it is adjoined as a root.

    Args:
        kinematics: the kinematics of the mechanism.
        force: the spring, damper or other force between two points.
    """

    def __init__(self, kinematics: Kinematics, force: LineLoad) -> None:
        self._kinematics = kinematics
        self._subject = f"the length of {force.name}"
        a, b = (kinematics.point(end.body, end.point) for end in force.ends)
        self.reach = (b - a).tidy()
        """The vector from the first end to the other, world axes [m]."""
        self.length: Series | None = None
        """The distance, once it has been requested."""

    @cached_property
    def square(self) -> Series:
        """The square of the distance."""
        return dot(self.reach, self.reach)

    @cached_property
    def x(self) -> Series:
        """The distance."""
        self.length = self._kinematics.algebra.root(self.square)
        return self.length

    @cached_property
    def rate(self) -> Series:
        """The rate of the distance."""
        return tidy(self.x.ddt())

    def direct(self, slope: Series | None, size: Series | None) -> Vector:
        """Return (slope · x + size) e."""
        pull = zero(self._kinematics.algebra.ring) if slope is None else self.reach * slope
        if size is None:
            return pull
        unit = Vector(*(_ratio(component, self.x) for component in self.reach))
        return pull + unit * size

    @property
    def assumption(self) -> Assumption | None:
        """The assumption about the sign of the distance, if it was used and can change."""
        root = self.length
        if root is None:
            return None
        ring, generators = root.ring, root.generators()
        moves = any(g.kind in (Kind.COORDINATE, Kind.TIME, Kind.INPUT) for g in generators)
        rational = all(
            ring.atoms[g.index].argument.is_number for g in generators if g.index in ring.atoms
        )
        return Assumption(self._subject, root) if moves and rational else None


@final
class Travel:
    """A coordinate or a length that a force acts along, as a series."""

    length: None = None
    assumption: None = None

    def __init__(self, x: Series) -> None:
        self.x = x

    @classmethod
    def in_joint(cls, algebra: Algebra, joint: str) -> Travel:
        """Return the coordinate of a joint."""
        name = algebra.mechanism.joint(joint).coordinates[-1]
        return cls(algebra.lift(algebra.values[name]))

    @property
    def square(self) -> Series:
        """Its square."""
        return self.x * self.x

    @cached_property
    def rate(self) -> Series:
        """Its rate."""
        return tidy(self.x.ddt())

    def direct(self, slope: Series | None, size: Series | None) -> Series:
        """Return slope · x + size."""
        parts = [self.x * slope] if slope is not None else []
        return self.x.ring.sum(parts + ([size] if size is not None else []))


def _ratio(component: Series, length: Series) -> Series:
    """Return component/length, exact where it is 0 or ±1."""
    if not component or component == length:
        return component.ring.number(1 if component else 0)
    if component == -length:
        return component.ring.number(-1)
    return tidy(component / length)


def length_names(ring: Ring, lengths: Iterable[tuple[str, Series]]) -> dict[str, str]:
    """Return the meaning of each root in the lengths of springs and dampers, by its name.

    Args:
        ring: the ring.
        lengths: name and length of each spring and damper.
    """
    found: dict[str, list[str]] = {}
    whole: dict[str, bool] = {}
    for name, length in lengths:
        for g in length.generators():
            if g.index in ring.atoms and ring.atoms[g.index].named:
                found.setdefault(g.name, []).append(name)
                whole[g.name] = length == ring[g.name]
    return {
        name: f"{'length' if whole[name] else 'root in the length'} of {' and '.join(owners)}"
        + (" [m]" if whole[name] else "")
        for name, owners in found.items()
    }
