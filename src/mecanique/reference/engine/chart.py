"""Map generalized coordinates to the engine's: p(q, t), u = G v + c and u' = G a + γ.

u are the engine's velocities, G = ∂u/∂v, and γ contains the second derivatives of the map, time
included (rheonomic maps: Goldstein, Classical Mechanics, 1950, sect. 1-4, eq. 1-49).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import cos, sin, sqrt
from typing import Any, final

import numpy as np
import numpy.typing as npt

from mecanique.arrays import Array
from mecanique.errors import EngineError
from mecanique.model.expression import evaluate, symbols_in
from mecanique.model.joints import Joint
from mecanique.model.mechanism import Mechanism
from mecanique.reference.engine.differentiation import MovingScalar, Operations, apply
from mecanique.reference.engine.load import EngineModel, JointIndices


def quaternion_rate(
    quaternion: Sequence[Any], spin: Sequence[Any], half: Any = 0.5
) -> tuple[Any, Any, Any, Any]:
    """Return the rate ½ quaternion ∘ (ω, 0), ω in the child's axes."""
    # The source is Diebel, Representing Attitude, 2006
    x, y, z, w = quaternion
    a, b, c = spin
    a, b, c = half * a, half * b, half * c
    return (
        w * a + y * c - z * b,
        w * b + z * a - x * c,
        w * c + x * b - y * a,
        -x * a - y * b - z * c,
    )


def turn(quaternion: Sequence[Any], vector: Sequence[Any]) -> tuple[Any, Any, Any]:
    """Rotate a vector by a quaternion of any length, from the child's axes to the joint's."""
    x, y, z, w = quaternion
    a, b, c = vector
    square = x * x + y * y + z * z + w * w
    # p = v + 2 w (r × v) + 2 r × (r × v), divided by the quaternion's square
    i, j, k = y * c - z * b, z * a - x * c, x * b - y * a
    return (
        a + 2 * (w * i + y * k - z * j) / square,
        b + 2 * (w * j + z * i - x * k) / square,
        c + 2 * (w * k + x * j - y * i) / square,
    )


@final
class Chart:
    """The map from a mechanism's coordinates to the engine's."""

    # Its arrays are overwritten by the next call

    def __init__(self, mechanism: Mechanism, engine: EngineModel) -> None:
        self._values = tuple(mechanism.values.values())
        self._positions: list[tuple[int, int]] = []
        self._circles: list[tuple[int, int]] = []
        self._quaternions: list[tuple[int, tuple[int, ...]]] = []
        self._twists: list[tuple[tuple[int, ...], tuple[int, ...]]] = []
        self._spins: list[tuple[tuple[int, ...], tuple[int, ...]]] = []
        self.index: dict[str, int] = {}
        """The index of each joint coordinate in the list that `place` returns."""
        self.rows: dict[str, int] = {}
        """The index of each joint velocity among the engine's velocities."""
        self.p: Array = np.zeros(engine.model.nq)
        self.G: Array = np.zeros((engine.model.nv, mechanism.nv))
        """∂u/∂v at the last call of `at`, shape (engine's nv, nv)."""
        self.c: Array = np.zeros(engine.model.nv)
        """Part of u that does not depend on v, at the last call of `at`, shape (engine's nv,)."""
        self.gamma: Array = np.zeros(engine.model.nv)
        """Part of u' that does not depend on a, at the last call of `at`, shape (engine's nv,)."""
        # where each coordinate stands in q, and each velocity in v
        self._at_q = {name: k for k, name in enumerate(mechanism.coordinates)}
        self._at_v = {name: k for k, name in enumerate(mechanism.velocities)}
        followers: dict[str, int] = {}
        for joint in mechanism.joints:
            seats = engine.seats[joint.name]
            if joint.quaternion:
                self._seat_quaternion(joint, seats[0])
            else:
                for name, seat in zip(joint.coordinates, seats, strict=False):
                    self._seat_single(name, seat, followers)
        rates = {name: self._at_v.get(f"{name}'") for name in self._at_q}
        self._rates = [(self._at_q[name], at) for name, at in rates.items() if at is not None]
        self._q_at_v = np.array([at for at, _ in self._rates], dtype=int)
        self._v_at_q = np.array([at for _, at in self._rates], dtype=int)
        self._map: Callable[..., tuple[float, ...]] | None = None
        self._jet: Callable[..., tuple[float, ...]] | None = None
        self._rows = np.array(list(followers.values()), dtype=int)
        if followers:
            self._follow(mechanism, tuple(followers))
        self.constant = self._jet is None
        """Whether G is constant, c and γ are zero."""
        square = engine.model.nv == mechanism.nv
        self.identical = self.constant and square and np.array_equal(self.G, np.eye(mechanism.nv))
        """Whether v are the engine's velocities in the engine's order."""
        self.single = self.constant and square and not self._quaternions
        """Whether the engine's positions and angles are linear functions of the coordinates."""
        self.velocities_are_rates = not self._spins and all(a == b for a, b in self._rates)
        """Whether v is q'."""

    def _seat_quaternion(self, joint: Joint, seat: JointIndices) -> None:
        """Register a joint with a quaternion, which in the engine is a floating one."""
        at_q = tuple(self._at_q[name] for name in joint.coordinates)
        at_v = tuple(self._at_v[name] for name in joint.velocities)
        self._quaternions.append((seat.at_q + 3, at_q[-4:]))
        self._spins.append((at_q[-4:], at_v[-3:]))
        if joint.linear_coordinates:
            self._positions += zip(range(seat.at_q, seat.at_q + 3), at_q, strict=False)
            self._twists.append((at_q, at_v))
        self.index.update(zip(joint.coordinates, at_q, strict=True))
        last = seat.at_v + 6
        self.G[range(last - len(at_v), last), at_v] = 1.0
        self.rows.update(zip(joint.velocities, range(last - len(at_v), last), strict=True))

    def _seat_single(self, name: str, seat: JointIndices, followers: dict[str, int]) -> None:
        """Register one coordinate; note a driven one with its velocity in the engine."""
        if name in self._at_q:
            at = self._at_q[name]
            self.G[seat.at_v, self._at_v[f"{name}'"]] = 1.0
        else:
            at = len(self._at_q) + len(followers)
            followers[name] = seat.at_v
        self.index[name] = at
        self.rows[f"{name}'"] = seat.at_v
        kind = self._circles if seat.kind == "continuous" else self._positions
        kind.append((seat.at_q, at))

    def reach(self, meets: Array) -> npt.NDArray[np.bool_]:
        """Return on which generalized velocities each of m quantities depends, shape (m, nv)."""
        spread = self.G != 0
        spread[self._rows] = True
        reached: npt.NDArray[np.bool_] = (meets != 0) @ spread
        return reached

    def place(self, q: Array, t: float) -> list[float]:
        """Set the engine's position p and return q followed by the driven joint coordinates."""
        values: list[float] = q.tolist()
        if self._map is not None:
            values += self._map(*values, t, *self._values)
        p = self.p
        for to, at in self._positions:
            p[to] = values[at]
        for to, at in self._circles:
            angle = values[at]
            p[to] = cos(angle)
            p[to + 1] = sin(angle)
        for to, ats in self._quaternions:
            x, y, z, w = (values[at] for at in ats)
            # the length drifts in integration, and the engine assumes unit length
            scale = 1 / sqrt(x * x + y * y + z * z + w * w)
            p[to : to + 4] = x * scale, y * scale, z * scale, w * scale
        return values

    def at(self, q: Array, v: Array, t: float) -> Array:
        """Set G, c and γ at a state and return the engine's velocities u, shape (engine's nv,)."""
        if self.identical:
            return v
        if self._jet is not None:
            numbers = self._jet(*q.tolist(), *v.tolist(), t, *self._values)
            rows, count = self._rows, len(self._rows)
            table = np.array(numbers)
            self.c[rows] = table[:count]
            self.gamma[rows] = table[count : 2 * count]
            self.G[rows] = table[2 * count :].reshape(count, -1)
            u: Array = self.G.dot(v)
            u += self.c
            return u
        # dot takes a third of the time of @ for small arrays
        product: Array = self.G.dot(v)
        return product

    def rates(self, q: Array, v: Array, out: Array) -> None:
        """Write q' into an array."""
        if not self._spins:
            out[self._q_at_v] = v[self._v_at_q]
            return
        for at, of in self._rates:
            out[at] = v[of]
        for (xa, ya, za, wa), (oxa, oya, oza) in self._spins:
            out[xa], out[ya], out[za], out[wa] = quaternion_rate(
                (q[xa], q[ya], q[za], q[wa]), (v[oxa], v[oya], v[oza])
            )
        for at_q, at_v in self._twists:
            out[list(at_q[:3])] = turn(
                [float(q[k]) for k in at_q[3:]], [float(v[k]) for k in at_v[:3]]
            )

    def _follow(self, mechanism: Mechanism, followers: Sequence[str]) -> None:
        """Differentiate the map and compile it."""
        driven = mechanism.coordinates.driven
        names = (*mechanism.coordinates, *mechanism.velocities, "t", *mechanism.values)
        operations = Operations(names)
        paths = _paths(mechanism, operations)
        for signal in mechanism.inputs:
            if any(signal.symbol in symbols_in(driven[name]) for name in followers):
                if callable(signal.signal):
                    raise EngineError(
                        f"the coordinate map of mechanism {mechanism.name!r} depends on "
                        f"input {signal.symbol!r}, a function whose derivatives are not known; "
                        "expected an expression in t and parameters"
                    )
                paths[signal.symbol] = evaluate(signal.signal, paths, function=apply)
        still = MovingScalar(operations, 0.0)
        maps = [still + evaluate(driven[name], paths, function=apply) for name in followers]
        q_names = (*mechanism.coordinates, "t", *mechanism.values)
        self._map = operations.compile([path.value for path in maps], q_names)
        c = [path.slopes.get("t", 0.0) for path in maps]
        gamma = [path.second for path in maps]
        G = [path.slopes.get(name, 0.0) for path in maps for name in mechanism.velocities]
        moving = operations.reaching((*mechanism.coordinates, "t"))
        # where G is constant, γ is the rate of c
        if not moving.isdisjoint(G) or any(entry != 0 for entry in c):
            self._jet = operations.compile([*c, *gamma, *G], names)
        else:
            numbers = operations.compile(G, tuple(mechanism.values))(*self._values)
            self.G[self._rows] = np.array(numbers).reshape(len(followers), -1)


def _paths(mechanism: Mechanism, operations: Operations) -> dict[str, Any]:
    """Return all coordinates, time and parameters, with their derivatives along the motion."""
    given = {name: operations.argument(name) for name in mechanism.values}
    time = operations.argument("t")
    paths = {**given, "t": MovingScalar(operations, time.value, {"t": 1.0}, 1.0)}
    for name in mechanism.velocities:
        if name.endswith("'"):
            value, rate = (operations.argument(x).value for x in (name[:-1], name))
            paths[name[:-1]] = MovingScalar(operations, value, {name: 1.0}, rate)
    for joint in mechanism.joints:
        if joint.quaternion:
            quaternion = [operations.argument(name) for name in joint.quaternion]
            spin, linear = joint.velocities[-3:], joint.velocities[:-3]
            # first with p' alone, from which p'' follows
            for _ in range(2):
                quaternion = _move_with(
                    operations, joint.quaternion, quaternion_rate, quaternion, spin
                )
            paths |= zip(joint.quaternion, quaternion, strict=True)
            if linear:
                sliding = _move_with(operations, joint.linear_coordinates, turn, quaternion, linear)
                paths |= zip(joint.linear_coordinates, sliding, strict=True)
    return paths


def _move_with(
    operations: Operations,
    names: Sequence[str],
    law: Callable[..., Sequence[MovingScalar]],
    quaternion: Sequence[MovingScalar],
    velocities: Sequence[str],
) -> list[MovingScalar]:
    """Return coordinates whose rates follow from a quaternion, linear in some velocities."""
    rates = law(quaternion, [operations.argument(name) for name in velocities])
    columns = [law(quaternion, unit) for unit in np.eye(3).tolist()]
    moved = []
    for name, rate, *slopes in zip(names, rates, *columns, strict=True):
        value = operations.argument(name).value
        by = dict(zip(velocities, (slope.value for slope in slopes), strict=True))
        moved.append(MovingScalar(operations, value, by, rate.value, rate.rate))
    return moved
