"""Test a mechanism in a few random states for motions without inertia."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NoReturn

import numpy as np

from mecanique.arrays import Array
from mecanique.errors import EngineError
from mecanique.model.mechanism import Mechanism
from mecanique.model.random_positions import draw_positions

_SINGULAR = 1e-13
"""A pivot of the mass matrix below this share of its own scale is rounding noise."""

_SHARE = 1e-6
"""Velocities up to this share of the largest do not take part in a motion."""

_REACH = 1.0
"""Largest absolute value of a length in a random state [m]."""


def random_states(mechanism: Mechanism, count: int = 4) -> Iterator[tuple[Array, Array, float]]:
    """Yield random positions, velocities and times, the same in every call."""
    random = np.random.default_rng(1788)
    positions = draw_positions(mechanism, count, random, _REACH)
    velocities = random.normal(size=(count, mechanism.nv))
    yield from zip(positions, velocities, random.uniform(size=count).tolist(), strict=True)


def massless_mode(mass: Array, reach: Array) -> Array | None:
    """Return a motion that moves no mass, shape (nv,), largest component 1; None if there is none.

    Args:
        mass: mass matrix, shape (nv, nv).
        reach: each diagonal entry without cancellation, shape (nv,).
    """
    # negative only for inertias that no real body has; these do have inertia
    diagonal = np.abs(np.diag(mass))
    for at in np.flatnonzero(~(diagonal > _SINGULAR * reach)):
        mode: Array = np.zeros(len(mass))
        mode[at] = 1.0
        return mode
    if not len(mass):
        return None
    scale = 1 / np.sqrt(diagonal)
    values, vectors = np.linalg.eigh(mass * np.outer(scale, scale))
    least = int(np.argmin(np.abs(values)))
    if abs(values[least]) > _SINGULAR:
        return None
    mode = vectors[:, least] * scale
    return np.asarray(mode / mode[np.argmax(np.abs(mode))])


def refuse_massless(mechanism: Mechanism, mode: Array, where: str = "") -> NoReturn:
    """Refuse a mechanism for a motion that moves no mass.

    Args:
        mechanism: the mechanism.
        mode: that motion, shape (nv,), largest component 1.
        where: the state, in words, if the motion is massless only there.

    Raises:
        EngineError: in any case.
    """
    parts = zip(mechanism.velocities, mode, strict=True)
    names = [name for name, part in parts if abs(part) > _SHARE]
    joints = [joint for joint in mechanism.joints if set(joint.velocities) & set(names)]
    moved = "".join(f", joint {joint.name!r} (body {joint.child!r})" for joint in joints)
    raise EngineError(
        f"mechanism {mechanism.name!r}: the motion {', '.join(names)}{moved} moves no mass{where}, "
        "so nothing determines it; give the body mass or inertia, or prescribe the joint by the "
        "coordinate map"
    )


def reach_of(model: Any, data: Any) -> Array:
    """Return the mass that each of the engine's velocities moves, or its polar moment of inertia.

    Args:
        model: pinocchio.Model.
        data: pinocchio.Data, after the mass matrix has been computed.
    """
    reach: Array = np.zeros(model.nv)
    for index in range(1, model.njoints):
        joint, carried = model.joints[index], data.Ycrb[index]
        polar = float(np.trace(carried.inertia)) + carried.mass * float(
            carried.lever @ carried.lever
        )
        span = slice(joint.idx_v, joint.idx_v + joint.nv)
        if joint.nv == 6:
            reach[span] = [carried.mass] * 3 + [polar] * 3
        else:
            reach[span] = carried.mass if joint.shortname().startswith("JointModelP") else polar
    reach += model.armature
    return reach


def backward_error(mass: Array, acceleration: Array, right: Array) -> float:
    """Return the residual of M a = right, relative to the size of its terms.

    Args:
        mass: mass matrix, shape (nv, nv).
        acceleration: shape (nv,).
        right: shape (nv,).
    """
    size = float((np.abs(mass) @ np.abs(acceleration) + np.abs(right)).max(initial=0.0))
    if not np.isfinite(size):
        return float("inf")
    return float(np.abs(mass @ acceleration - right).max(initial=0.0)) / size if size else 0.0
