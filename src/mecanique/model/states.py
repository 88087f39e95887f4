"""States of a mechanism, one or many: positions, velocities, accelerations and times, checked."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, final

import numpy as np

from mecanique.errors import InputError, UnknownNameError
from mecanique.model.expression import evaluate, symbols_in
from mecanique.model.joint_base import Single
from mecanique.model.mechanism import Mechanism
from mecanique.model.values import Given, column_of, numbers_of

_LISTED = 8
"""At most this many coordinates are listed in a message."""


@final
@dataclass(frozen=True, eq=False)
class Efforts:
    """Torques and forces that drive a mechanism besides its own forces, at n states."""

    mechanism: Mechanism  # what they drive
    # the velocities they work on: generalized ones, and those of joints that follow the coordinate
    # map
    names: tuple[str, ...]
    values: np.ndarray  # shape (n, names) [N·m or N]

    @cached_property
    def in_joints(self) -> dict[str, np.ndarray]:
        """Those that act in a joint, shape (n,), by the joint's velocity."""
        moved = {name for joint in self.mechanism.joints for name in joint.velocities}
        columns = zip(self.names, self.values.T, strict=True)
        return {name: column for name, column in columns if name in moved and column.any()}

    @cached_property
    def generalized(self) -> np.ndarray | None:
        """Those on generalized coordinates that are no joint's, shape (n, nv); None if all zero."""
        velocities = self.mechanism.velocities
        out = np.zeros((len(self.values), len(velocities)))
        for name, column in zip(self.names, self.values.T, strict=True):
            if name in velocities and name not in self.in_joints:
                out[:, velocities.index(name)] = column
        return out if out.any() else None

    def refuse_without_seat(self) -> None:
        """Raise unless each acts in a joint with one coordinate, as reactions need to know."""
        seated = seated_velocities(self.mechanism)
        given = zip(self.names, self.values.T, strict=True)
        loose = [name for name, column in given if name not in seated and column.any()]
        if loose:
            raise InputError(
                f"reactions depend on what makes the forces on {', '.join(loose)}; expected tau in "
                "joints with one coordinate, or describe the rest as forces of the mechanism"
            )


def seated_velocities(mechanism: Mechanism) -> set[str]:
    """Return the velocities of joints with one coordinate, in which a force has a place."""
    return {joint.velocities[-1] for joint in mechanism.joints if isinstance(joint, Single)}


def expect_mechanism(given: object) -> Mechanism:
    """Return a mechanism, or raise."""
    if isinstance(given, Mechanism):
        return given
    raise InputError(f"expected a Mechanism, got {type(given).__name__}")


@final
@dataclass(frozen=True, eq=False)
class States:
    """Positions, velocities, times and accelerations of n states."""

    mechanism: Mechanism
    q: np.ndarray  # shape (n, nq), positions; quaternions of unit length
    v: np.ndarray  # shape (n, nv), velocities
    t: np.ndarray  # shape (n,), times [s]
    a: np.ndarray  # shape (n, nv), accelerations
    single: bool = False  # whether one state was given without a batch axis
    # torques and forces that drive besides the mechanism's own; None if there are none
    efforts: Efforts | None = None
    asked: Given = None  # the positions as they were given, for messages

    @classmethod
    def of(
        cls,
        mechanism: Mechanism,
        q: Given,
        v: Given = None,
        t: float | np.ndarray = 0.0,
        a: Given = None,
        tau: Given = None,
    ) -> States:
        """Check and align what was given.

        Shapes: q (nq,) or (n, nq), v (nv,) or (n, nv), t () or (n,), a (nv,) or (n, nv), tau (nv,)
        or (n, nv).
        """
        parts = {
            "q": mechanism.position(q, many=True),
            "v": mechanism.velocity(v, many=True),
            "a": mechanism.acceleration(a, many=True),
        }
        names: tuple[str, ...] = ()
        if tau is not None:
            names, parts["tau"] = _efforts(mechanism, tau)
        times = column_of(t, "time t")
        single = not times.ndim and all(part.ndim == 1 for part in parts.values())
        lengths = {name: len(rows) for name, rows in parts.items() if rows.ndim == 2}
        lengths |= {"t": len(times)} if times.ndim else {}
        if len(set(lengths.values())) > 1:
            counts = ", ".join(f"{name}: {count}" for name, count in lengths.items())
            raise InputError(
                f"expected one number of states in {', '.join(parts)} and t, got {counts}"
            )
        n = next(iter(lengths.values()), 1)
        parts["t"] = times[..., None]
        rows = {
            name: part[None] if single else np.broadcast_to(part, (n, part.shape[-1]))
            for name, part in parts.items()
        }
        efforts = Efforts(mechanism, names, rows.pop("tau")) if names else None
        rows["t"] = rows["t"][:, 0]
        return cls(mechanism, **rows, single=single, efforts=efforts, asked=q)

    def __len__(self) -> int:
        return len(self.t)

    def at(self, indices: np.ndarray) -> States:
        """Return some of the states, as many."""
        efforts = self.efforts
        if efforts is not None:
            efforts = Efforts(self.mechanism, efforts.names, efforts.values[indices])
        return States(
            self.mechanism,
            self.q[indices],
            self.v[indices],
            self.t[indices],
            self.a[indices],
            efforts=efforts,
        )

    @cached_property
    def values(self) -> dict[str, Any]:
        """Every parameter, input, coordinate, velocity and t by name, each shape () or (n,)."""
        mechanism = self.mechanism
        constants: dict[str, Any] = {**mechanism.values, "t": self.t}
        signals: dict[str, Any] = {}
        for signal in mechanism.inputs:
            if callable(signal.signal):
                value = np.array([float(signal.signal(float(t))) for t in self.t])
            else:
                value = np.broadcast_to(evaluate(signal.signal, constants), (len(self),))
            if not np.isfinite(value).all():
                first = self.t[~np.isfinite(value)][0]
                raise InputError(f"input {signal.symbol!r} is not finite at t = {first:g} s")
            signals[signal.symbol] = value
        return {
            **constants,
            **signals,
            **dict(zip(mechanism.coordinates, self.q.T, strict=True)),
            **dict(zip(mechanism.velocities, self.v.T, strict=True)),
        }

    def unbatch(self, result: np.ndarray) -> np.ndarray:
        """Return a result as it was asked for: without the batch axis for a single state.

        Shapes: result (n, …).
        """
        return result[0] if self.single else result


def explain_defaults(mechanism: Mechanism, q: Given) -> str:
    """Return which coordinates were not given and where they are instead, to end a sentence."""
    if q is not None and not isinstance(q, Mapping):
        return ""
    return _say(_left_out(mechanism, q or {}, mechanism.neutral()))


def list_left_out(
    mechanism: Mechanism, q: object, v: object, start: np.ndarray, rank: int | None = None
) -> str:
    """Return what a start by name left out and its values there, to end a sentence.

    Nothing is said of a position, or of velocities, without any name: the neutral one, and rest;
    nor, where constraints decide others, of velocities, and of positions if as many are given as
    there are degrees of freedom.

    Shapes: start (nq + nv,).
    """
    position, velocity = np.split(start, [mechanism.nq])
    enough = mechanism.nv if rank is None else mechanism.nv - rank
    omitted: list[str] = []
    if isinstance(q, Mapping) and q and (rank is None or len(q) < enough):
        omitted += _left_out(mechanism, q, position)
    if isinstance(v, Mapping) and v and rank is None:
        stems = {name.removesuffix("'") for name in v}
        given = {f"{name}'" for name in stems | _leaders(mechanism, stems)} | {*v}
        values = zip(mechanism.velocities, velocity.tolist(), strict=True)
        omitted += [f"{name} = {value:.6g}" for name, value in values if name not in given]
    return _say(omitted)


def _left_out(mechanism: Mechanism, q: Mapping[str, Any], position: np.ndarray) -> list[str]:
    given = q.keys() | _leaders(mechanism, {*q})
    values = zip(mechanism.coordinates, position.tolist(), strict=True)
    return [f"{name} = {value:.6g}" for name, value in values if name not in given]


def _leaders(mechanism: Mechanism, names: set[str]) -> set[str]:
    """Return the coordinates that some joint coordinates follow."""
    driven = mechanism.coordinates.driven
    return {leader for name in names & driven.keys() for leader in symbols_in(driven[name])}


def _say(left_out: list[str]) -> str:
    if not left_out:
        return ""
    more = ", …" if len(left_out) > _LISTED else ""
    was = "was" if len(left_out) == 1 else "were"
    return f"; {', '.join(left_out[:_LISTED])}{more} {was} not given"


def _efforts(mechanism: Mechanism, tau: Given) -> tuple[tuple[str, ...], np.ndarray]:
    """Return the velocities that torques work on, and the torques, shape (names,) or (n, names)."""
    velocities = mechanism.velocities
    if not isinstance(tau, Mapping):
        zero = np.zeros(len(velocities))
        return velocities, numbers_of(tau, velocities, "torque", zero, many=True)
    moved = [name for joint in mechanism.joints for name in joint.velocities]
    names = (*velocities, *(name for name in moved if name not in velocities))
    meant: dict[str, set[str]] = {name: {name} for name in names}
    for name in names:
        meant.setdefault(name.removesuffix("'"), set()).add(name)
    for joint in mechanism.joints:
        if isinstance(joint, Single):
            meant.setdefault(joint.name, set()).add(joint.velocities[-1])
    taken: dict[str, str] = {}
    for name in tau:
        several = [joint for joint in mechanism.joints if joint.name == name and joint.nv != 1]
        if name not in meant and several:
            raise InputError(
                f"joint {name!r} has {several[0].nv} velocities; name what tau works on"
                + (f": {', '.join(several[0].velocities)}" if several[0].nv else "")
            )
        if name not in meant:
            raise UnknownNameError("joint or velocity for tau", name, meant)
        if len(meant[name]) > 1:
            listed = " or ".join(sorted(meant[name]))
            raise InputError(f"{name!r} may mean a joint or another's coordinate: name {listed}")
        (velocity,) = meant[name]
        if velocity in taken:
            raise InputError(
                f"tau on {velocity} is given twice, as {taken[velocity]!r} and {name!r}"
            )
        taken[velocity] = name
    known = {velocity: tau[name] for velocity, name in taken.items()}
    return names, numbers_of(known, names, "torque", np.zeros(len(names)), many=True)
