"""Write coordinates as jets along a motion, q + v ε + ½ a ε², with variations δq as dual parts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any

import numpy as np

from mecanique.derivation.mechanics.elements import Ground, ground_of
from mecanique.derivation.scalars.functions import function
from mecanique.derivation.scalars.jets import Jet
from mecanique.derivation.tree.links import Link
from mecanique.derivation.tree.poses import (
    IDENTITY,
    Arithmetic,
    Matrix,
    joint_values,
    quaternion_product,
    quaternion_rotation,
)
from mecanique.errors import DerivationError
from mecanique.model import Joint, Mechanism
from mecanique.model.expression import evaluate, symbols_in
from mecanique.model.states import States

JETS = Arithmetic(function)
"""The arithmetic that computes poses with jets as scalars."""


def joint_paths(
    states: States, tree: tuple[Link, ...], a: np.ndarray | None = None
) -> dict[str, Jet]:
    """Return the jet of every joint coordinate, except those of quaternion joints; a (n, nv)."""
    # The coefficients have shape (3, 1 + nv, n): orders of ε, then the value and its partial
    # derivative along each δq
    values = joint_values(states.mechanism, _paths(states, a), JETS)
    names = [name for link in tree if link.kind in ("turn", "slide") for name in link.coordinates]
    return {name: _lift(values[name], states) for name in names}


def driven_paths(states: States) -> dict[str, np.ndarray]:
    """Return coefficients of the driven coordinates' jets at constant v, each (3, 1 + nv, n)."""
    values = joint_values(states.mechanism, _paths(states, None), JETS)
    return {name: _lift(values[name], states).c for name in states.mechanism.coordinates.driven}


def coordinate_paths(states: States, a: np.ndarray | None = None) -> dict[str, Any]:
    """Return the value of every parameter, and the jets of t and of every coordinate."""
    # Shapes: a (n, nv)
    mechanism = states.mechanism
    values: dict[str, Any] = dict(mechanism.values)
    for joint in mechanism.joints:
        if joint.quaternion:
            values |= _turning_paths(states, joint, a)
    place = {name: k for k, name in enumerate(mechanism.velocities)}
    for q, name in zip(states.q.T, mechanism.coordinates, strict=True):
        if name not in values:
            k = place[f"{name}'"]
            values[name] = _jet(states, q, states.v[:, k], 0.0 if a is None else a[:, k], k)
    values["t"] = _jet(states, states.t, 1.0, 0.0, None)
    return values


def _turning_paths(states: States, joint: Joint, a: np.ndarray | None) -> dict[str, Jet]:
    """Return the jets of a quaternion p, p' = ½ p ω, and of the place x beside it, x' = R v."""
    mechanism = states.mechanism
    at = [mechanism.velocities.index(name) for name in joint.velocities]
    v = states.v[:, at].T
    vd = np.zeros_like(v) if a is None else a[:, at].T
    q = {name: states.q[:, mechanism.coordinates.index(name)] for name in joint.coordinates}

    def turn(p: Any, spin: Any) -> np.ndarray:
        return np.array(quaternion_product(p, spin)) / 2

    p = [np.array([q[name] for name in joint.quaternion])]
    p.append(turn(p[0], v[-3:]))
    p.append((turn(p[1], v[-3:]) + turn(p[0], vd[-3:])) / 2)
    c = np.zeros((joint.nq, 3, 1 + mechanism.nv, len(states)))
    for order, part in enumerate(p):
        c[-4:, order, 0] = part
        for k, axis in zip(at[-3:], np.eye(3), strict=True):
            c[-4:, order, 1 + k] = turn(part, axis)
    if joint.linear_coordinates:
        rows = quaternion_rotation(*map(Jet, c[-4:]))
        entries = [entry.c[:, 0] for row in rows for entry in row]
        R = np.reshape(entries, (3, 3, 3, len(states)))  # the third axis is that of orders
        c[:3, 0, 0] = [q[name] for name in joint.linear_coordinates]
        c[:3, 1, 0] = np.einsum("ijn,jn->in", R[:, :, 0], v[:3])
        c[:3, 2, 0] = np.einsum("ijn,jn->in", R[:, :, 1], v[:3]) / 2
        c[:3, 2, 0] += np.einsum("ijn,jn->in", R[:, :, 0], vd[:3]) / 2
        c[:3, :, [1 + k for k in at[:3]]] = R.transpose(0, 2, 1, 3)
    return dict(zip(joint.coordinates, map(Jet, c), strict=True))


def stack_jets(rows: Sequence[Sequence[Any]], shape: tuple[int, ...]) -> Jet:
    """Return a pose of jets and numbers as a jet of homogeneous matrices."""
    c = np.zeros((*shape, 4, 4))
    c[0, 0, :, 3, 3] = 1.0
    return _fill(c, rows)


def constant_jet(value: Any, shape: tuple[int, ...]) -> Jet:
    """Return a number as a jet with coefficients of a shape."""
    c = np.zeros(shape)
    c[0, 0] = value
    return Jet(c)


def frame_jet(poses: list[Jet], place: int, X: np.ndarray | None = None) -> Jet:
    """Return the pose of a frame X in a link, or in the ground at place −1."""
    if place < 0:
        return constant_jet(np.eye(4) if X is None else X, poses[0].c.shape)
    return poses[place] if X is None else poses[place] @ X


def stack_column(entries: Sequence[Any], shape: tuple[int, ...]) -> Jet:
    """Return a vector of jets and numbers as a jet of columns, trailing shape (n, 3, 1)."""
    return _fill(np.zeros((*shape, 3, 1)), [[entry] for entry in entries])


def _fill(c: np.ndarray, rows: Sequence[Sequence[Any]]) -> Jet:
    """Fill the coefficients of a matrix with jets and numbers."""
    for i, row in enumerate(rows):
        for k, entry in enumerate(row):
            if isinstance(entry, Jet):
                c[..., i, k] = entry.c
            else:
                c[0, 0, :, i, k] = entry
    return Jet(c)


def ground_on_jets(mechanism: Mechanism, place: Mapping[str, int], poses: list[Jet]) -> Ground:
    """Return the poses of bodies as scalar jets, given the place of each body's pose."""

    @cache
    def pose(body: str) -> Matrix:
        if place[body] < 0:
            return IDENTITY
        moved = poses[place[body]]
        rows = []
        for i in range(3):
            rows.append([moved[:, i, k] for k in range(4)])
        return rows

    return ground_of(pose, mechanism.values, JETS)


def delay(x: Jet) -> Jet:
    """Return the same motion with the variation η = ε instead of η = 1."""
    c = np.zeros_like(x.c)
    c[:, 0] = x.c[:, 0]
    c[1:, 1:] = x.c[:-1, 1:]
    return Jet(c)


def _paths(states: States, a: np.ndarray | None) -> dict[str, Any]:
    """Return the value or jet of every symbol that the coordinate map may contain."""
    mechanism, values = states.mechanism, coordinate_paths(states, a)
    used = {
        symbol: name for name, s in mechanism.coordinates.driven.items() for symbol in symbols_in(s)
    }
    for signal in mechanism.inputs:
        if signal.symbol in used:
            if callable(signal.signal):
                raise DerivationError(
                    f"the map of coordinate {used[signal.symbol]!r} depends on input "
                    f"{signal.symbol!r}, a record or a Python function, which has no exact "
                    "derivatives; give it as an expression in t"
                )
            values[signal.symbol] = evaluate(signal.signal, values, function=function)
    return values


def _jet(states: States, x: Any, rate: Any, second: Any, direction: int | None) -> Jet:
    c = np.zeros((3, 1 + states.mechanism.nv, len(states)))
    c[0, 0], c[1, 0], c[2, 0] = x, rate, np.asarray(second) / 2
    if direction is not None:
        c[0, 1 + direction] = 1.0
    return Jet(c)


def _lift(value: Any, states: States) -> Jet:
    return value if isinstance(value, Jet) else _jet(states, value, 0.0, 0.0, None)
