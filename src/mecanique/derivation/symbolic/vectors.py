"""Vectors of three series, and forces with their moments."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, final

from mecanique.derivation.scalars.cancel import tidy
from mecanique.derivation.scalars.series import Ring, Series
from mecanique.derivation.tree.poses import combination


@final
@dataclass(frozen=True)
class Vector:
    """Three components."""

    x: Series
    y: Series
    z: Series

    def __iter__(self) -> Iterator[Series]:
        return iter((self.x, self.y, self.z))

    def __getitem__(self, place: int) -> Series:
        return (self.x, self.y, self.z)[place]

    def __add__(self, other: Vector) -> Vector:
        return Vector(self.x + other.x, self.y + other.y, self.z + other.z)

    def __sub__(self, other: Vector) -> Vector:
        return Vector(self.x - other.x, self.y - other.y, self.z - other.z)

    def __neg__(self) -> Vector:
        return Vector(-self.x, -self.y, -self.z)

    def __mul__(self, factor: Series | int) -> Vector:
        return Vector(factor * self.x, factor * self.y, factor * self.z)

    def tidy(self) -> Vector:
        """Cancel common factors in every component."""
        return Vector(tidy(self.x), tidy(self.y), tidy(self.z))


@final
@dataclass(frozen=True)
class SymbolicWrench:
    """A force and a moment, or a twist: the velocity of a point and the angular velocity."""

    force: Vector
    moment: Vector  # about a point that the user chooses

    def part(self, kind: str) -> Vector:
        """Return the "force" or the "moment"."""
        return self.force if kind == "force" else self.moment

    def __add__(self, other: SymbolicWrench) -> SymbolicWrench:
        return SymbolicWrench(self.force + other.force, self.moment + other.moment)

    def __sub__(self, other: SymbolicWrench) -> SymbolicWrench:
        return SymbolicWrench(self.force - other.force, self.moment - other.moment)

    def __neg__(self) -> SymbolicWrench:
        return SymbolicWrench(-self.force, -self.moment)

    def __mul__(self, factor: Series | int) -> SymbolicWrench:
        return SymbolicWrench(self.force * factor, self.moment * factor)

    def power(self, twist: SymbolicWrench) -> Series:
        """Return the power in a twist, or the virtual work in what belongs to it."""
        pairs = zip((*self.force, *self.moment), (*twist.force, *twist.moment), strict=True)
        return self.force.x.ring.sum([a * b for a, b in pairs])

    def about(self, arm: Vector) -> SymbolicWrench:
        """Return it with the moment about the start of an arm at whose end it acts."""
        return SymbolicWrench(self.force, total([self.moment, cross(arm, self.force)]))

    def tidy(self) -> SymbolicWrench:
        """Cancel common factors in every component."""
        return SymbolicWrench(self.force.tidy(), self.moment.tidy())


def zero(ring: Ring) -> Vector:
    """Return the vector 0."""
    return Vector(*[ring.number(0)] * 3)


def no_wrench(ring: Ring) -> SymbolicWrench:
    """Return the wrench 0."""
    return SymbolicWrench(zero(ring), zero(ring))


def lift(ring: Ring, components: Sequence[Any]) -> Vector:
    """Make a vector from three components, some of which may be plain numbers."""
    return Vector(*(c if isinstance(c, Series) else ring.number(c) for c in components))


def total(vectors: Iterable[Vector]) -> Vector:
    """Return the sum of at least one vector, in one pass."""
    return Vector(*(terms[0].ring.sum(terms) for terms in zip(*vectors, strict=True)))


def resultant(wrenches: Sequence[SymbolicWrench]) -> SymbolicWrench:
    """Return the sum of at least one wrench, all with moments about the same point."""
    return SymbolicWrench(total(w.force for w in wrenches), total(w.moment for w in wrenches))


def dot(a: Vector, b: Vector) -> Series:
    """Return a · b."""
    return a.x.ring.sum([p * q for p, q in zip(a, b, strict=True)])


def cross(a: Vector, b: Vector) -> Vector:
    """Return a × b."""
    return Vector(
        a.y * b.z - a.z * b.y,
        a.z * b.x - a.x * b.z,
        a.x * b.y - a.y * b.x,
    )


def component(row: Sequence[Any], vector: Vector) -> Series:
    """Return the component of a vector along a direction, shape (3,)."""
    projected = combination(row, vector)
    return tidy(projected) if isinstance(projected, Series) else vector.x.ring.number(projected)


def along(rows: Sequence[Sequence[Any]], vector: Vector) -> Vector:
    """Return the components of a vector along three directions, shape (3, 3)."""
    return Vector(*(component(row, vector) for row in rows))
