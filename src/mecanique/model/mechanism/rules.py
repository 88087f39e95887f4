"""What the numbers of a sound mechanism keep to, stated once for Python and for pages."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import final

import numpy as np

from mecanique.model.constraints.contacts import Rolling
from mecanique.model.expression import Scalar, evaluate, plain, symbols_in
from mecanique.model.joint_base import Single
from mecanique.model.mechanism.description import Description

MASS = "its mass is negative ({} kg)"
MOMENT = "its inertia has a negative principal moment ({} kg·m²)"
TRIANGLE = (
    "its principal moments break the triangle inequality ({} + {} < {} kg·m²): "
    "no mass is spread like that"
)


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


def rules_of(m: Description) -> Iterator[Rule]:
    """Yield what the parameters of a mechanism keep to, but for masses and inertias.

    Springs and dampers that would feed energy in are refused: write a Force for those.
    """
    for joint in m.joints:
        where = f"joint {joint.name!r}"
        yield from _finite(f"{where}: its origin", *joint.origin.xyz, *joint.origin.rpy)
        if isinstance(joint, Single):
            yield Rule(where, ": its armature is negative", gap=joint.armature, endless=True)
    yield from _finite("gravity", *m.gravity)
    for name, (lower, upper) in m.coordinates.intervals.items():
        where, words = f"coordinate {name!r}", ": its lower limit {} is not below its upper {}"
        width = plain(upper) - plain(lower)
        yield Rule(where, words, (lower, upper), width, strict=True, endless=True)
    for loop in m.loops:
        if loop.kind == "distance":
            words = ": expected a length above 0, got {}"
            yield Rule(f"loop {loop.name!r}", words, (loop.length,), loop.length, strict=True)
    for contact in m.contacts:
        if isinstance(contact, Rolling):
            yield from _rolling(contact)
    for force in m.forces:
        for stated in force.stated:
            words = f": expected a {stated.name} of at least 0, got {{}}"
            for scalar in stated.scalars if stated.positive else ():
                yield Rule(f"force {force.name!r}", words, (scalar,), scalar)
    yield from _list_finite(m)


def _rolling(contact: Rolling) -> Iterator[Rule]:
    where, radius, crown = f"contact {contact.name!r}", contact.radius, contact.crown
    yield Rule(where, ": expected a radius above 0, got {}", (radius,), radius, strict=True)
    words = ": expected a crown radius from 0, a sharp edge, to the radius {1}, a ball, got {0}"
    for gap in (crown, plain(radius) - plain(crown)):
        yield Rule(where, words, (crown, radius), gap, follows=True)
    if contact.friction is not None:
        words = ": expected a coefficient of friction of at least 0, got {}"
        yield Rule(where, words, (contact.friction,), contact.friction, endless=True)
    for factor in contact.stretch:
        words = ": expected a stretch above 0, got {}"
        yield Rule(where, words, (factor,), factor, strict=True)
    if contact.curved:
        words = ": expected a bowl's radius above the ball's {1}, or minus that of a dome, got {0}"
        bowl = plain(contact.bowl)
        # above 0 for a dome, below 0, and for a bowl wider than the ball
        outside = bowl * (bowl - plain(radius))
        yield Rule(where, words, (bowl, radius), outside, strict=True, endless=True)


def _list_finite(m: Description) -> Iterator[Rule]:
    """What is known before any motion must be finite: it would only come back as NaN."""
    for name, scalar in m.coordinates.driven.items():
        yield from _finite(f"the map of {name!r}", scalar)
    for loop in m.loops:
        for frame in (loop.frame_a, loop.frame_b):
            yield from _finite(f"loop {loop.name!r}: its frame", *frame.xyz, *frame.rpy)
    for contact in m.contacts:
        yield from _finite(f"contact {contact.name!r}: its geometry", *contact.scalars)
    for force in m.forces:
        for stated in force.stated:
            if not stated.positive:
                yield from _finite(f"force {force.name!r}: its {stated.name}", *stated.scalars)


def _finite(where: str, *scalars: Scalar) -> Iterator[Rule]:
    yield from (Rule(where, " is not finite", (scalar,)) for scalar in scalars)


def find_broken(rules: Iterable[Rule], values: Mapping[str, float]) -> list[str]:
    """Return the faults of rules, each once; what varies in a motion is not judged."""
    faults: list[str] = []
    fault = None
    for rule in rules:
        varies = any(not symbols_in(scalar) <= values.keys() for scalar in rule.scalars)
        if varies or (rule.follows and fault):
            continue
        fault = rule.fault(values)
        if fault and fault not in faults:
            faults.append(fault)
    return faults


def _number(scalar: Scalar, values: Mapping[str, float]) -> float:
    try:
        with np.errstate(all="ignore"):
            return float(evaluate(scalar, dict(values)))
    except (ArithmeticError, TypeError):
        return math.nan
