"""Find the states at which the equations are defined.

The coordinate map must be defined there, springs and dampers must have a length, and the
coordinates must not be next to a singular point of theirs: where two axes of a gimbal fall in line,
the mass matrix has no inverse, and rounding errors of the acceleration grow without bound. Where
the closed form takes something for granted, e.g. that a spring on a line is not turned inside out,
that must hold.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from mecanique.arrays import Array, median
from mecanique.derivation.numeric.recursion import Recursion
from mecanique.derivation.scalars.evaluation import evaluate
from mecanique.derivation.symbolic.derivation import Assumption
from mecanique.derivation.tree.links import links
from mecanique.derivation.tree.poses import Arithmetic, joint_values, poses, times_point
from mecanique.model.force_base import LineLoad
from mecanique.model.mechanism import Mechanism
from mecanique.model.states import States

Flags = npt.NDArray[np.bool_]
_NEAR = 1e-2
"""Lengths below this part of the typical length count as zero."""

_SINGULAR = 1e3
"""A mass matrix conditioned worse than the typical one by this factor is nearly singular."""


def is_possible(
    mechanism: Mechanism, states: States, assumptions: Sequence[Assumption] = ()
) -> Flags:
    """Return at which states the equations of motion are defined, shape (n,).

    Args:
        mechanism: the mechanism.
        states: candidates.
        assumptions: what the closed form takes for granted.
    """
    possible = np.ones(len(states.t), dtype=bool)
    with np.errstate(all="ignore"):
        values = _values(mechanism, states.q, states.t)
        for name, (lower, upper) in mechanism.limits.items():
            possible &= (values[name] > lower) & (values[name] < upper)
        for name in mechanism.coordinates.driven:
            possible &= np.isfinite(values[name])
        for force in mechanism.forces:
            if isinstance(force, LineLoad):
                possible &= _has_length(_span(mechanism, force, values, len(states.t)))
        for assumption in assumptions:
            possible &= evaluate(assumption.positive, values) > 0
    return possible & _is_regular(mechanism, states, possible)


def _is_regular(mechanism: Mechanism, states: States, possible: Flags) -> Flags:
    """Return where the mass matrix is not much worse conditioned than usual."""
    at = np.flatnonzero(possible)
    regular = np.ones(len(possible), dtype=bool)
    if not len(at) or not mechanism.nv:
        return regular
    chosen = replace(states.at(at), v=np.zeros((len(at), mechanism.nv)))
    mass = Recursion(mechanism).mass_matrix(chosen)
    condition = np.array([_condition(matrix) for matrix in mass])
    regular[at] = ~(condition > _SINGULAR * median(condition))
    return regular


def _condition(mass: Array) -> float:
    """Return the condition number, diagonal scaled to one; 1 if there is none."""
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


def _span(mechanism: Mechanism, force: LineLoad, values: dict[str, Any], n: int) -> Array:
    """From one end to the other in world axes, shape (n, 3) [m]."""
    tree = links(mechanism)
    carried = dict(
        zip((link.body for link in tree), poses(tree, values, Arithmetic()), strict=True)
    )
    ends = []
    for end in force.ends:
        here: Sequence[Any] = mechanism.evaluate_all(end.point)
        if end.body in carried:
            here = times_point(carried[end.body], here)
        ends.append(
            np.stack([np.broadcast_to(np.asarray(c, dtype=float), (n,)) for c in here], axis=-1)
        )
    return np.asarray(ends[1] - ends[0])


def _has_length(span: Array) -> Flags:
    length = np.linalg.norm(span, axis=1)
    known = length[np.isfinite(length)]
    long_enough: Flags = length > _NEAR * (median(known) if len(known) else 0.0)
    return long_enough
