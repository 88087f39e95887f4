"""Where a mechanism can be: the limits of its coordinates, unit quaternions, numbers by name."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from mecanique.errors import InputError, UnknownNameError
from mecanique.model.expression import coordinate, symbols_in
from mecanique.model.mechanism.description import Description
from mecanique.model.mechanism.letters import to_name
from mecanique.model.values import Given, numbers_of

_SHORTEST, _LONGEST = 1e-9, 1e9
"""Lengths between which four numbers count as a quaternion to be normalized."""


@dataclass(frozen=True)
class StateSpace(Description):
    """The positions, velocities and accelerations that a mechanism can be given."""

    @cached_property
    def limits(self) -> dict[str, tuple[float, float]]:
        """The open interval of each coordinate that is limited, by name."""
        return {
            name: (self.evaluate(lower), self.evaluate(upper))
            for name, (lower, upper) in self.coordinates.intervals.items()
        }

    def refuse_outside(self, q: np.ndarray) -> None:
        """Raise if a coordinate is not within its limits.

        Args:
            q: shape (nq,) or (n, nq).

        Raises:
            InputError: naming the coordinate, its limits and what it was.
        """
        for name, (lower, upper) in self.limits.items():
            values = np.atleast_2d(q)[:, self.coordinates.index(name)]
            outside = values[~((values > lower) & (values < upper))]
            if len(outside):
                raise InputError(self.explain_limit(name, f", got {outside[0]:.9g}"))

    def explain_limit(self, name: str, what: str = "") -> str:
        """Return in a sentence where a coordinate must stay, and what to use instead.

        Args:
            name: of a limited coordinate.
            what: what happened to it, after a comma.

        Raises:
            UnknownNameError: if there is no such coordinate, or it is not limited.
        """
        if name not in self.limits:
            raise UnknownNameError("limited coordinate", name, self.limits)
        stated = ", ".join(map(str, self.coordinates.intervals[name]))
        numbers = ", ".join(f"{bound:g}" for bound in self.limits[name])
        interval = f"({stated})" if stated == numbers else f"({stated}) = ({numbers})"
        return f"{name} must stay within {interval}{what}: {self.explain_chart(name)}"

    def explain_chart(self, name: str) -> str:
        """Return why a limited coordinate ends at its limits, and what to use instead.

        Args:
            name: of the coordinate.
        """
        slopes = {
            driven: map_.diff(coordinate(name))
            for driven, map_ in self.coordinates.driven.items()
            if name in symbols_in(map_)
        }
        others = [driven for driven, slope in slopes.items() if name in symbols_in(slope)]
        if slopes and not others:
            # what goes with it linearly is no other chart: it is the mechanism that ends there
            return f"beyond, the description of {self.name!r} does not hold"
        instead = f", e.g. {' or '.join(others)}" if others else ""
        return f"the chart {name} of {self.name!r} ends there; use another coordinate{instead}"

    def neutral(self) -> np.ndarray:
        """Return the position with every coordinate zero and every quaternion one, shape (nq,).

        A coordinate whose limits leave out zero is in the middle of them, or 1 away from the finite
        one.
        """
        ones = {joint.quaternion[-1] for joint in self.joints if joint.quaternion}
        middle = {name: _middle(*bounds) for name, bounds in self.limits.items()}
        return np.array(
            [1.0 if name in ones else middle.get(name, 0.0) for name in self.coordinates]
        )

    @cached_property
    def quaternions(self) -> tuple[tuple[str, list[int]], ...]:
        """Name of each joint with a unit quaternion, and where the quaternion stands in q."""
        at = self.coordinates.index
        return tuple((j.name, [*map(at, j.quaternion)]) for j in self.joints if j.quaternion)

    def normalize(self, q: np.ndarray) -> np.ndarray:
        """Give every quaternion of some positions unit length, in place, and return them.

        Args:
            q: shape (nq,) or (n, nq).

        Raises:
            InputError: if a quaternion has no length.
        """
        for name, at in self.quaternions:
            length = np.linalg.norm(q[..., at], axis=-1, keepdims=True)
            sound = (length > _SHORTEST) & (length < _LONGEST)
            if not sound.all():
                wrong = q[..., at][~sound[..., 0]][0]
                raise InputError(
                    f"expected a unit quaternion for joint {name!r}, got {wrong.tolist()}"
                )
            q[..., at] /= length
        return q

    def position(self, q: Given, *, many: bool = False) -> np.ndarray:
        """Return positions as an array, shape (nq,).

        Args:
            q: shape (nq,), or values by coordinate name (those left out are zero, a quaternion's w
                one), or None. A joint coordinate that follows one of them in proportion, with an
                offset or none, may stand for it.
            many: whether several positions may be given, shape (n, nq), or by name shape (n,); the
                answer then has that shape.

        Raises:
            InputError: if the shape is wrong, a number is not finite or beyond its coordinate's
                limits, or a quaternion has no length.
            UnknownNameError: if a name is no coordinate.
        """
        by_name = q is None or isinstance(q, Mapping)
        default = self.neutral() if by_name else np.zeros(self.nq)
        q = by_leaders(self, q, self.coordinates.names)
        names = self.coordinates.names
        normalized = self.normalize(numbers_of(q, names, "coordinate", default, many=many))
        self.refuse_outside(normalized)
        return normalized

    def velocity(self, v: Given, *, many: bool = False) -> np.ndarray:
        """Return velocities as an array, shape (nv,).

        Args:
            v: shape (nv,), or values by velocity name, q or q' (those left out are zero), or None.
                That of a joint coordinate that follows another in proportion may stand for it.
            many: whether several velocities may be given, shape (n, nv), or by name shape (n,); the
                answer then has that shape.

        Raises:
            InputError: if the shape is wrong or a number is not finite.
            UnknownNameError: if a name is no velocity.
        """
        v, zero = by_leaders(self, v, self.velocities, primes=1), np.zeros(self.nv)
        return numbers_of(v, self.velocities, "velocity", zero, self._rates, many=many)

    def acceleration(self, a: Given, *, many: bool = False) -> np.ndarray:
        """Return accelerations as an array, shape (nv,).

        Args:
            a: shape (nv,), or values by name of the coordinate, of the velocity or of its rate
                (those left out are zero), or None.
            many: whether several accelerations may be given, shape (n, nv), or by name shape (n,);
                the answer then has that shape.

        Raises:
            InputError: if the shape is wrong or a number is not finite.
            UnknownNameError: if a name is no acceleration.
        """
        a, zero = by_leaders(self, a, self.velocities, primes=2), np.zeros(self.nv)
        return numbers_of(a, self.velocities, "acceleration", zero, self._changes, many=many)

    @cached_property
    def _rates(self) -> dict[str, str]:
        """The velocity that each coordinate's name stands for."""
        return {name.removesuffix("'"): name for name in self.velocities}

    @cached_property
    def _changes(self) -> dict[str, str]:
        """The velocity whose change is meant by the name of a coordinate or of an acceleration."""
        return {**self._rates, **{f"{name}'": name for name in self.velocities}}


def by_leaders(space: StateSpace, given: Given, names: tuple[str, ...], primes: int = 0) -> Given:
    """Replace what is given of joint coordinates that follow the map by what they follow."""
    driven = space.coordinates.driven
    if not isinstance(given, Mapping):
        return given
    typed = list(given)
    given = {to_name(space, name): value for name, value in given.items()}
    if len(given) < len(typed):
        raise InputError(f"expected each coordinate once, got {', '.join(typed)}")
    stems = {name: _stem(name, primes) for name in given}
    led: dict[str, Any] = {
        name: value for name, value in given.items() if stems[name] not in driven
    }
    taken = {stems[name] for name in led}
    for name in given.keys() - led.keys():
        law = driven[stems[name]]
        leaders = symbols_in(law) - space.values.keys()
        leader = min(leaders, default="")
        slope = law.diff(coordinate(leader)) if leader in space.coordinates else 0
        if len(leaders) != 1 or not slope or symbols_in(slope) - space.values.keys():
            raise InputError(
                f"{name} follows the coordinate map, {stems[name]} = {law}, and does not "
                f"determine the coordinates in it by itself; give {', '.join(names)}"
            )
        if leader in taken:
            raise InputError(f"{name} follows {leader}, which is given, too: {stems[name]} = {law}")
        rest = 0.0 if primes else space.evaluate(law.subs({coordinate(leader): 0}))
        led[leader] = (np.asarray(given[name], dtype=float) - rest) / space.evaluate(slope)
        taken.add(leader)
    return led


def _stem(name: str, primes: int) -> str:
    """Return the name of the coordinate whose rate a name means."""
    for _ in range(primes):
        name = name.removesuffix("'")
    return name


def _middle(lower: float, upper: float) -> float:
    if lower < 0 < upper:
        return 0.0
    if np.isfinite(lower) and np.isfinite(upper):
        return (lower + upper) / 2
    return lower + 1 if np.isfinite(lower) else upper - 1
