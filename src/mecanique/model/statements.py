"""What the parts of a mechanism state: scalars, field by field, and what their numbers keep to.

A field that states scalars says by its metadata in which unit, whether they may vary and whether
they have a sign. Whatever checks letters, units or numbers asks all parts alike.
"""

from __future__ import annotations

import math
import warnings
from abc import ABC
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields, replace
from typing import Any, ClassVar, Literal, TypeAlias, final

import numpy as np

from mecanique.model.expression import Scalar, evaluate, plain
from mecanique.model.placement import Placement, vector

Sign: TypeAlias = Literal["", "of at least", "above"]
"""How numbers stand to 0; empty if any will do."""


@final
@dataclass(frozen=True)
class Stated:
    """What one field of a part states.

    Args:
        name: of the field in words, e.g. "free length".
        scalars: one, or three components.
        units: their unit; of what acts in a joint, on a slide and about an axis.
        varies: whether they may depend on the state, time and inputs, not on parameters alone.
        sign: how they stand to 0.
        length: whether they are a length or a point [m].
        stores: whether it is a potential: of the distance, or the joint's coordinate.
    """

    name: str
    scalars: tuple[Scalar, ...]
    units: tuple[str, ...]
    varies: bool = False
    sign: Sign = ""
    length: bool = False
    stores: bool = False


def state(
    *units: str,
    vector: bool = False,
    named: bool = False,
    varies: bool = False,
    sign: Sign = "",
    length: bool = False,
    stores: bool = False,
) -> Mapping[str, Any]:
    """Return the metadata of a field that states a scalar, a vector, a frame or, if named, a name.

    `Stated` explains the rest.
    """
    stated = Stated("", (), units, varies, sign, length, stores)
    return {"vector": vector, "named": named, "stated": stated}


POINT = state("m", vector=True, length=True)
"""Metadata of a point of a body."""

LENGTH = state("m", sign="of at least", length=True)
"""Metadata of a length."""

FRAME = state("m")
"""Metadata of a frame: its place in meters, its angles in radians."""


@final
@dataclass(frozen=True)
class NumberRule:
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


@dataclass(frozen=True)
class MechanismPart(ABC):
    """A force, a loop, a contact or an element, by what it states."""

    name: str

    noun: ClassVar[str]
    """What it is called in messages."""

    def __post_init__(self) -> None:
        for item in fields(self):
            given = getattr(self, item.name)
            if not item.metadata or given is None or isinstance(given, Placement):
                continue
            if item.metadata["vector"]:
                place = vector(given, f"{item.name} of {self.name!r}")
                object.__setattr__(self, item.name, place)
            elif not (item.metadata["named"] and isinstance(given, str)):
                object.__setattr__(self, item.name, plain(given))

    def __getattr__(self, name: str) -> Any:
        if name != "quantities":
            raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")
        warnings.warn("quantities are called stated", DeprecationWarning, stacklevel=2)
        return self.stated

    @property
    def title(self) -> str:
        """What it is called, and its name."""
        return f"{self.noun} {self.name!r}"

    @property
    def stated(self) -> tuple[Stated, ...]:
        """Its points, frames, constants and expressions, field by field."""
        stated: list[Stated] = []
        for item in fields(self):
            given, name = getattr(self, item.name), item.name.replace("_", " ")
            if not item.metadata or given is None or isinstance(given, str):
                continue
            its: Stated = item.metadata["stated"]
            if isinstance(given, Placement):
                name = name.removesuffix(" a").removesuffix(" b")
                stated.append(replace(its, name=name, scalars=given.xyz))
                stated.append(Stated(f"{name}, its angles", given.rpy, ("rad",)))
            else:
                scalars = given if isinstance(given, tuple) else (given,)
                stated.append(replace(its, name=name, scalars=scalars))
        return tuple(stated)

    @property
    def scalars(self) -> tuple[Scalar, ...]:
        """All expressions in it."""
        return tuple(scalar for stated in self.stated for scalar in stated.scalars)

    def rules(self) -> Iterator[NumberRule]:
        """Yield what its numbers keep to; what is known before any motion must be finite."""
        for stated in self.stated:
            if stated.sign:
                words = f": expected a {stated.name} {stated.sign} 0, got {{}}"
                for scalar in stated.scalars:
                    strict = stated.sign == "above"
                    yield NumberRule(self.title, words, (scalar,), scalar, strict=strict)
            else:
                for scalar in stated.scalars:
                    yield NumberRule(
                        f"{self.title}: its {stated.name}", " is not finite", (scalar,)
                    )
