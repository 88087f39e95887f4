"""At which states the equations mean anything.

The coordinate map must be defined there, and the coordinates must not be next to a singular point of theirs: where two
axes of a gimbal fall in line, the mass matrix has no inverse, and rounding errors of the acceleration grow without
bound. A spring's length is a square root. On a line it is the root of a perfect square, a + x, and the derivation in
closed form takes the branch that holds while the spring is not turned inside out.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from mecanique.derive.links import links
from mecanique.derive.poses import Arithmetic, joint_values, poses, times_point
from mecanique.derive.recursion import Recursion
from mecanique.derive.states import States
from mecanique.model.forces import Damper, Spring
from mecanique.model.mechanism import Mechanism

__all__ = ["Sampled", "is_possible"]

Array = npt.NDArray[np.float64]
Flags = npt.NDArray[np.bool_]
_NEAR = 1e-2
"""Lengths below this part of the typical length count as zero."""

_SINGULAR = 1e3
"""A mass matrix worse conditioned than the typical one by this factor is next to a singular point."""


class Sampled(Protocol):
    """Coordinates and times of several states."""

    @property
    def q(self) -> Array:
        """Coordinates, shape (n, nq)."""

    @property
    def t(self) -> Array:
        """Times, shape (n,) [s]."""


def is_possible(mechanism: Mechanism, states: Sampled, lengths: Flags) -> Flags:
    """Return at which states the equations of motion are defined, shape (n,).

    Args:
        mechanism: the mechanism.
        states: candidates.
        lengths: which coordinates are lengths, shape (nq,).
    """
    with np.errstate(all="ignore"):
        values = _values(mechanism, states.q, states.t)
        possible = np.ones(len(states.t), dtype=bool)
        for name in mechanism.coordinates.driven:
            possible &= np.isfinite(values[name])
        for force in mechanism.forces:
            if isinstance(force, (Spring, Damper)):
                here = _span(mechanism, force, values, len(states.t))
                # the same angles, with every length as drawn in the description
                drawn = _values(mechanism, np.where(lengths, 0.0, states.q), states.t)
                there = _span(mechanism, force, drawn, len(states.t))
                possible &= _keeps_its_sense(here, there, isinstance(force, Damper) or _is_always_slack(force))
    return possible & _is_regular(mechanism, states, possible)


def _is_regular(mechanism: Mechanism, states: Sampled, possible: Flags) -> Flags:
    """Where the mass matrix, its diagonal scaled to one, is not much worse conditioned than usual."""
    at = np.flatnonzero(possible)
    regular = np.ones(len(possible), dtype=bool)
    if not len(at) or not mechanism.nv:
        return regular
    chosen = States.of(mechanism, states.q[at], np.zeros((len(at), mechanism.nv)), states.t[at])
    mass = Recursion(mechanism).mass_matrix(chosen)
    condition = np.array([_condition(matrix) for matrix in mass])
    regular[at] = ~(condition > _SINGULAR * np.median(condition))
    return regular


def _condition(mass: Array) -> float:
    """Condition number with the diagonal scaled to one; 1 where there is none, so that the state is kept."""
    with np.errstate(all="ignore"):
        d = np.sqrt(np.diagonal(mass))
        scaled = mass / np.outer(d, d)
    return float(np.linalg.cond(scaled)) if np.isfinite(scaled).all() else 1.0


def _values(mechanism: Mechanism, q: Array, t: Array) -> dict[str, Any]:
    values: dict[str, Any] = {**mechanism.values, "t": t}
    for signal in mechanism.inputs:
        function = signal.function(mechanism.values)
        values[signal.symbol] = np.array([function(float(instant)) for instant in t])
    values.update({name: q[:, k] for k, name in enumerate(mechanism.coordinates)})
    return joint_values(mechanism, values, Arithmetic())


def _span(mechanism: Mechanism, force: Spring | Damper, values: dict[str, Any], n: int) -> Array:
    """From one end to the other in world axes, shape (n, 3) [m]."""
    tree = links(mechanism)
    carried = dict(zip((link.body for link in tree), poses(tree, values, Arithmetic()), strict=True))
    ends = []
    for body, point in ((force.body_a, force.point_a), (force.body_b, force.point_b)):
        here: Sequence[Any] = [mechanism.evaluate(component) for component in point]
        if body in carried:
            here = times_point(carried[body], here)
        ends.append(np.stack([np.broadcast_to(np.asarray(c, dtype=float), (n,)) for c in here], axis=-1))
    return np.asarray(ends[1] - ends[0])


def _keeps_its_sense(here: Array, there: Array, either_way: bool) -> Flags:
    length, before = np.linalg.norm(here, axis=1), np.linalg.norm(there, axis=1)
    typical = float(np.nanmedian(np.maximum(length, before))) if np.isfinite(length).any() else 0.0
    apart = length > _NEAR * typical
    cosine = np.sum(here * there, axis=1) / np.where(length * before > 0, length * before, 1.0)
    keeps: Flags = apart & (cosine > (-2.0 if either_way else -1 + 1e-12))
    return keeps


def _is_always_slack(spring: Spring | Damper) -> bool:
    """A spring of free length zero pulls with k times its span, without any root."""
    return isinstance(spring, Spring) and isinstance(spring.free_length, float) and spring.free_length == 0
