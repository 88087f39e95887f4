"""What contacts and guiding elements say of themselves, whatever asks them.

As forces act in one of three ways, their base class, so do contacts and elements: what rolls
presses (`PressingContact`), a blade holds sideways (`EdgeContact`), a cord pulls along straight
runs (`Strung`). A class says which lengths it states, what they keep to, which of its forces have
one sign only and what these are called; its law stands in `mecanique.derivation.mechanics` and, on
the other side of the wall, in `mecanique.reference`.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields
from typing import ClassVar, NamedTuple, final

import numpy as np

from mecanique.model.expression import Scalar, Vector, evaluate, plain
from mecanique.model.placement import Placement


@final
@dataclass(frozen=True)
class Rule:
    """Numbers that must be finite, and a gap between them that must not close.

    Args:
        where: what they belong to.
        words: the fault if they are not so, with a {} for each number.
        numbers: what the words show.
        gap: what must be at least 0; None if it is enough that the numbers are finite.
        strict: whether the gap must be above 0.
        endless: whether the gap may be infinite.
        follows: whether it means something only if the rule before it is kept.
    """

    where: str
    words: str
    numbers: tuple[Scalar, ...] = ()
    gap: Scalar | None = None
    strict: bool = False
    endless: bool = False
    follows: bool = False

    @property
    def scalars(self) -> tuple[Scalar, ...]:
        """The numbers, and the gap if there is one."""
        return self.numbers if self.gap is None else (*self.numbers, self.gap)

    def fault(self, values: Mapping[str, float]) -> str | None:
        """Return what is wrong with the values of the parameters, or None."""
        numbers = [_number(scalar, values) for scalar in self.numbers]
        words = self.where + self.words.format(*(f"{number:g}" for number in numbers))
        if self.gap is None:
            return None if all(map(math.isfinite, numbers)) else words
        gap = _number(self.gap, values)
        enough = gap > 0 if self.strict else gap >= 0
        return None if enough and (self.endless or gap < math.inf) else words


def _number(scalar: Scalar, values: Mapping[str, float]) -> float:
    try:
        with np.errstate(all="ignore"):
            return float(evaluate(scalar, dict(values)))
    except (ArithmeticError, TypeError):
        return math.nan


class Quantity(NamedTuple):
    """Scalars that an element or a contact states: their name in words, and their SI unit."""

    words: str
    scalars: tuple[Scalar, ...]
    unit: str


def unit(symbol: str) -> Mapping[str, str]:
    """Return the metadata of a field that states scalars with a unit; frames have "m"."""
    return {"unit": symbol}


@dataclass(frozen=True)
class _Speaking(ABC):
    """What elements and contacts have in common."""

    name: str

    @property
    def quantities(self) -> tuple[Quantity, ...]:
        """What it states with a unit, field by field."""
        stated: list[Quantity] = []
        for item in fields(self):
            value, words = getattr(self, item.name), f"its {item.name.replace('_', ' ')}"
            if "unit" not in item.metadata or value is None:
                continue
            if isinstance(value, Placement):
                words = words.removesuffix(" a").removesuffix(" b")
                stated.append(Quantity(words, value.xyz, "m"))
                stated.append(Quantity(f"{words}, its angles", value.rpy, "rad"))
            else:
                scalars = value if isinstance(value, tuple) else (value,)
                stated.append(Quantity(words, tuple(scalars), item.metadata["unit"]))
        return tuple(stated)


@dataclass(frozen=True)
class ContactBase(_Speaking):
    """What every contact says of itself."""

    body: str

    forces_of: ClassVar[Mapping[str, str]]
    """Its force of each row and the way it acts, in words, with {} for the bodies and its name."""

    @property
    @abstractmethod
    def seat(self) -> Vector:
        """The point its force is referred to, in the frame of the body [m]."""

    @property
    def sizes(self) -> tuple[Scalar, ...]:
        """Lengths that are typical of it [m]."""
        return ()

    @property
    def breaks(self) -> tuple[str, ...]:
        """Names of the events at which it ceases to hold."""
        return ()

    def rules(self) -> Iterator[Rule]:
        """Yield what its numbers keep to."""
        yield from ()


class PressingContact(ContactBase):
    """A contact that presses along a normal and rubs along two directions, and so may let go."""

    radius: Scalar
    center: Vector
    axis: Vector | None
    crown: Scalar
    plane: Placement
    stretch: Vector
    bowl: Scalar
    friction: Scalar | None

    @property
    @abstractmethod
    def curved(self) -> bool:
        """Whether it rolls in a bowl or on a dome."""

    @property
    def seat(self) -> Vector:
        """Its center."""
        return self.center

    @property
    def sizes(self) -> tuple[Scalar, ...]:
        """Its radius."""
        return (self.radius,)

    @property
    def breaks(self) -> tuple[str, ...]:
        """Where it would pull, and where it would slip if that is asked."""
        slip = () if self.friction is None else (f"{self.name} would slip",)
        return (f"{self.name} would pull", *slip)

    def rules(self) -> Iterator[Rule]:
        """Yield what its numbers keep to."""
        where, radius, crown = f"contact {self.name!r}", self.radius, self.crown
        # a ball of radius 0 is a point
        bound = "at least" if self.axis is None else "above"
        words = f": expected a radius {bound} 0, got {{}}"
        yield Rule(where, words, (radius,), radius, strict=self.axis is not None)
        words = ": expected a crown radius from 0, a sharp edge, to the radius {1}, a ball, got {0}"
        for gap in (crown, plain(radius) - plain(crown)):
            yield Rule(where, words, (crown, radius), gap, follows=True)
        if self.friction is not None:
            words = ": expected a coefficient of friction of at least 0, got {}"
            yield Rule(where, words, (self.friction,), self.friction, endless=True)
        for factor in self.stretch:
            words = ": expected a stretch above 0, got {}"
            yield Rule(where, words, (factor,), factor, strict=True)
        if self.curved:
            words = (
                ": expected a bowl's radius above the ball's {1}, or minus that of a dome, got {0}"
            )
            bowl = plain(self.bowl)
            # above 0 for a dome, below 0, and for a bowl wider than the ball
            outside = bowl * (bowl - plain(radius))
            yield Rule(where, words, (bowl, radius), outside, strict=True, endless=True)


class EdgeContact(ContactBase):
    """A contact at a point of the body, which holds it in one direction."""

    point: Vector

    @property
    def seat(self) -> Vector:
        """Its point."""
        return self.point


@dataclass(frozen=True)
class GuidingElement(_Speaking):
    """What every element that guides says of itself."""

    @property
    def tensions(self) -> tuple[str, ...]:
        """Names of those of its forces that can only pull."""
        return ()


@final
@dataclass(frozen=True)
class JointRow:
    """A direction in which an element in joints presses or rubs.

    Args:
        letter: of its force, "N" if it presses and "R" if it rubs.
        weights: of the coordinate of each joint in the gap, or in the rate of slip.
        offset: the gap where the coordinates are zero; None for friction.
        speed: what the rate of slip lacks [m/s or rad/s].
    """

    letter: str
    weights: tuple[tuple[str, float], ...]
    offset: Scalar | None = None
    speed: Scalar = 0.0


@dataclass(frozen=True)
class SwitchingElement(_Speaking):
    """What every element that switches between states says of itself."""

    @property
    def joint_rows(self) -> tuple[JointRow, ...]:
        """Its directions if it sits in joints, the one that presses first."""
        return ()

    @property
    def coefficients(self) -> tuple[Scalar, Scalar]:
        """Kinetic and static friction, for each newton that presses or, of a stated load, in N."""
        return (0.0, 0.0)

    @property
    def pressed_by(self) -> str | None:
        """The element whose normal force its friction goes by; None if its load is stated."""
        return None

    @property
    def bodies(self) -> tuple[str, ...]:
        """Names of the bodies it refers to by itself; of an element in a joint, none."""
        return ()

    @property
    def varying(self) -> tuple[Scalar, ...]:
        """Scalars that may depend on the state and time."""
        return ()

    @property
    @abstractmethod
    def constants(self) -> tuple[Scalar, ...]:
        """Scalars in the parameters alone."""

    def rules(self) -> Iterator[Rule]:
        """Yield what its numbers keep to."""
        yield from ()


class Stop(NamedTuple):
    """A place that a cord runs to: an end of it, or a pulley.

    Args:
        body: its name.
        center: shape (3,), in the frame of the body [m].
        radius: of the cord's line around it, zero at an end [m].
        sense: 1 counterclockwise, −1 clockwise.
    """

    body: str
    center: Vector
    radius: Scalar = 0.0
    sense: int = 1


class Strung(GuidingElement):
    """An element of straight runs from stop to stop, which pull."""

    normal: tuple[float, float, float]
    axes: str

    @property
    @abstractmethod
    def stops(self) -> tuple[Stop, ...]:
        """Where it runs."""

    @property
    @abstractmethod
    def parts(self) -> tuple[int, ...]:
        """Which of its tensions each run has."""

    @property
    @abstractmethod
    def forces(self) -> tuple[str, ...]:
        """Names of its tensions."""

    @property
    def tensions(self) -> tuple[str, ...]:
        """All of its forces."""
        return self.forces

    @property
    def quantities(self) -> tuple[Quantity, ...]:
        """What its fields state, and its points and radii."""
        stated = list(super().quantities)
        for stop in self.stops:
            stated.append(Quantity("a point of it", tuple(stop.center), "m"))
            stated.append(Quantity("a radius of it", (stop.radius,), "m"))
        return tuple(stated)
