"""The generators of series: named indeterminates, angles, and functions of series."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from fractions import Fraction
from typing import Any, Generic, TypeVar, final

E = TypeVar("E")
"""The elements of the ring, its series."""


class Kind(Enum):
    """What a generator of a ring stands for."""

    PARAMETER = "parameter"
    COORDINATE = "coordinate"
    VELOCITY = "velocity"
    ACCELERATION = "acceleration"
    INPUT = "input"
    TIME = "time"
    CONSTANT = "constant"
    ATOM = "atom"
    REACTION = "reaction"
    VARIATION = "virtual displacement"


@final
@dataclass(frozen=True)
class Generator:
    """A named indeterminate of a ring.

    Args:
        name: its name, e.g. "q", "q'" for a velocity, "q''" for an acceleration.
        kind: the kind of quantity that it denotes.
        index: its position in monomials.
    """

    name: str
    kind: Kind
    index: int


@final
@dataclass(frozen=True)
class Angle(Generic[E]):
    """An argument of sines and cosines: a rational multiple of a monomial, e.g. q, Ω t or x/R.

    Args:
        argument: the angle as a series [rad].
        unit: the rational multiple.
    """

    argument: E
    unit: Fraction


@final
@dataclass(frozen=True)
class Atom(Generic[E]):
    """A function of a series, adjoined to the ring as a generator with its own chain rule.

    Args:
        function: its name, e.g. "sqrt", "exp"; "1" if the generator is the argument itself,
            adjoined to allow division by it.
        argument: the argument of the function.
        slope: its derivative with respect to the argument.
        value: the function of numbers and arrays.
        named: whether it is printed under a name of its own.
    """

    function: str
    argument: E
    slope: E
    value: Callable[[Any], Any]
    named: bool
