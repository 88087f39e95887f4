"""Springs, dampers, drives and loads, as forces on the engine's bodies and in its joints.

A spring pulls its ends together with k (l − l₀), a damper with c dl/dt, along the line between
them; a spring in a joint turns or pushes with −k (r − r₀), a damper with −c r' (Meirovitch,
Elements of Vibration Analysis, sect. 1-2).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from math import sqrt
from typing import final

import numpy as np

from mecanique.errors import EngineError
from mecanique.model.expression import Scalar, Vector, compiled
from mecanique.model.forces import (
    Damper,
    Force,
    JointDamper,
    JointForce,
    JointSpring,
    Spring,
    Torque,
)
from mecanique.model.joints import Single
from mecanique.model.mechanism import Mechanism
from mecanique.model.parameters import Input
from mecanique.reference.engine.answers import Array
from mecanique.reference.engine.load import Engine
from mecanique.reference.engine.sites import Action, Axes, External, Site, Triple

__all__ = ["Loads"]

_ZERO: Triple = (0.0, 0.0, 0.0)


@final
@dataclass(frozen=True, eq=False)
class _Line:
    """A spring or a damper between two points."""

    name: str
    a: Site
    b: Site
    stiffness: float
    free_length: float
    damping: float


@final
@dataclass(frozen=True, eq=False)
class _Load:
    """A Force or a Torque; its components are the expressions from `at` on, in the axes of `turned`, if any."""

    site: Site
    turned: tuple[Axes, Array] | None
    at: int
    pure: bool


@final
class Loads:
    """All forces of a mechanism besides gravity and reactions.

    The engine's work space must hold the positions and velocities of the state that is asked about.

    Args:
        mechanism: whose forces they are.
        engine: the mechanism inside Pinocchio.
        index: where each joint coordinate stands in the values that are passed to the methods.
    """

    def __init__(self, mechanism: Mechanism, engine: Engine, index: dict[str, int]) -> None:
        self._values = tuple(mechanism.values.values())
        poses, twists = engine.data.oMi, engine.data.v
        self._axes = [
            Axes(
                joint,
                poses[joint].rotation,
                poses[joint].translation,
                twists[joint].linear,
                twists[joint].angular,
            )
            for joint in range(engine.model.njoints)
        ]
        self._signals = [_signal(mechanism, signal) for signal in mechanism.inputs]
        self._lines: list[_Line] = []
        self._springs: list[tuple[int, int, float, float]] = []
        self._dampers: list[tuple[int, float]] = []
        self._drives: list[tuple[int, int]] = []
        self._loads: list[_Load] = []
        scalars: list[Scalar] = []
        for force in mechanism.forces:
            match force:
                case Spring() | Damper():
                    self._lines.append(self._line(mechanism, engine, force))
                case JointSpring() | JointDamper() | JointForce():
                    row = engine.seats[force.joint][0].at_v
                    if isinstance(force, JointSpring):
                        at = index[mechanism.joint(force.joint).coordinates[0]]
                        constants = (
                            mechanism.evaluate(force.stiffness),
                            mechanism.evaluate(force.reference),
                        )
                        self._springs.append((row, at, *constants))
                    elif isinstance(force, JointDamper):
                        self._dampers.append((row, mechanism.evaluate(force.damping)))
                    else:
                        self._drives.append((row, len(scalars)))
                        scalars.append(force.force)
                case Force() | Torque():
                    self._loads.append(self._load(mechanism, engine, force, len(scalars)))
                    scalars += force.force if isinstance(force, Force) else force.torque
        symbols = (*(signal.symbol for signal in mechanism.inputs), *mechanism.values)
        self._scalars: Callable[..., tuple[float, ...]] = compiled(
            scalars, (*mechanism.coordinates, *mechanism.velocities, "t", *symbols)
        )
        self._joints = [
            (engine.seats[joint.name][0].at_v, self._seat(engine, joint.child), joint, joint.parent)
            for joint in mechanism.joints
            if isinstance(joint, Single)
        ]
        self.sites = {body: self._seat(engine, body) for body in engine.holders}
        """The origin of each body."""
        self.external = External(engine.model.njoints)
        """What acts on the engine's bodies."""
        self.in_joints: Array = np.zeros(engine.model.nv)
        """Forces in the engine's joints."""
        self.act_on_bodies = bool(self._lines or self._loads)
        """Whether a force acts on a body."""
        self.act_in_joints = bool(self._springs or self._dampers or self._drives)
        """Whether a force acts in a joint."""

    def update(self, values: list[float], q: Array, u: Array, v: Array, t: float) -> list[Action]:
        """Set `external` and `in_joints` and return what acts on the bodies.

        Args:
            values: q, then the driven joint coordinates.
            q: shape (nq,).
            u: the engine's velocities.
            v: shape (nv,).
            t: time [s].
        """
        numbers: tuple[float, ...] = ()
        if self._drives or self._loads:
            signals = [signal(t) for signal in self._signals]
            numbers = self._scalars(*q.tolist(), *v.tolist(), t, *signals, *self._values)
        if self.act_in_joints:
            forces = self.in_joints
            forces[:] = 0.0
            for row, at, stiffness, reference in self._springs:
                forces[row] -= stiffness * (values[at] - reference)
            for row, damping in self._dampers:
                forces[row] -= damping * u.item(row)
            for row, at in self._drives:
                forces[row] += numbers[at]
        if not self.act_on_bodies:
            return []
        actions = [*self._from_lines(), *self._from_loads(numbers)]
        self.external.set(actions)
        return actions

    def across_joints(self) -> list[Action]:
        """Return the forces in the joints as what they do to the bodies: on the child, and opposite on the parent."""
        actions = []
        for row, child, joint, parent in self._joints:
            force = float(self.in_joints[row])
            if force:
                a, b, c = child.axes.to_world(joint.axis)
                along, against = (
                    (a * force, b * force, c * force),
                    (-a * force, -b * force, -c * force),
                )
                point, other = child.position(), self.sites[parent]
                if joint.turns:
                    actions += [
                        Action(child, _ZERO, point, along),
                        Action(other, _ZERO, point, against),
                    ]
                else:
                    actions += [
                        Action(child, along, point, _ZERO),
                        Action(other, against, point, _ZERO),
                    ]
        return actions

    def energy(self, values: list[float]) -> float:
        """Return the potential energy of all springs, ½ k (elongation)² each [J].

        Args:
            values: q, then the driven joint coordinates.
        """
        total = 0.0
        for line in self._lines:
            if line.stiffness:
                xa, xb = line.a.position(), line.b.position()
                length = sqrt(sum((b - a) ** 2 for a, b in zip(xa, xb, strict=True)))
                total += 0.5 * line.stiffness * (length - line.free_length) ** 2
        for _, at, stiffness, reference in self._springs:
            total += 0.5 * stiffness * (values[at] - reference) ** 2
        return total

    def check(self) -> None:
        """Refuse a state in which a force between two points has no direction.

        Raises:
            EngineError: naming the spring or damper.
        """
        for line in self._lines:
            if (line.free_length or line.damping) and line.a.position() == line.b.position():
                raise EngineError(
                    f"spring or damper {line.name!r} has no direction: its ends, on {line.a.body!r} and "
                    f"{line.b.body!r}, are at one place; move the mechanism a little, or its ends"
                )

    def _from_lines(self) -> Iterator[Action]:
        for line in self._lines:
            xa, xb = line.a.position(), line.b.position()
            dx, dy, dz = xb[0] - xa[0], xb[1] - xa[1], xb[2] - xa[2]
            tension = line.stiffness  # per length
            if line.free_length or line.damping:
                square = dx * dx + dy * dy + dz * dz
                if not square:
                    continue
                if line.free_length:
                    tension *= 1 - line.free_length / sqrt(square)
                if line.damping:
                    va, vb = line.a.velocity(), line.b.velocity()
                    parting = dx * (vb[0] - va[0]) + dy * (vb[1] - va[1]) + dz * (vb[2] - va[2])
                    tension += line.damping * parting / square
            fx, fy, fz = tension * dx, tension * dy, tension * dz
            yield Action(line.a, (fx, fy, fz), xa, _ZERO)
            yield Action(line.b, (-fx, -fy, -fz), xb, _ZERO)

    def _from_loads(self, numbers: tuple[float, ...]) -> Iterator[Action]:
        for load in self._loads:
            at = load.at
            vector = numbers[at], numbers[at + 1], numbers[at + 2]
            if load.turned is not None:
                axes, turn = load.turned
                x, y, z = (turn @ vector).tolist()
                vector = axes.to_world((x, y, z))
            if load.pure:
                yield Action(load.site, _ZERO, _ZERO, vector)
            else:
                yield Action(load.site, vector, load.site.position(), _ZERO)

    def _seat(self, engine: Engine, body: str, point: Triple = _ZERO) -> Site:
        holder = engine.holders[body]
        x, y, z = holder.placement.act(np.array(point)).tolist()
        return Site(body, self._axes[holder.joint], (x, y, z))

    def _line(self, mechanism: Mechanism, engine: Engine, force: Spring | Damper) -> _Line:
        a, b = (
            self._seat(engine, body, _numbers(mechanism, point))
            for body, point in ((force.body_a, force.point_a), (force.body_b, force.point_b))
        )
        if isinstance(force, Damper):
            return _Line(force.name, a, b, 0.0, 0.0, mechanism.evaluate(force.damping))
        constants = mechanism.evaluate(force.stiffness), mechanism.evaluate(force.free_length)
        return _Line(force.name, a, b, *constants, 0.0)

    def _load(self, mechanism: Mechanism, engine: Engine, force: Force | Torque, at: int) -> _Load:
        point = _numbers(mechanism, force.point) if isinstance(force, Force) else _ZERO
        turned = None
        if force.axes != "world":
            holder = engine.holders[force.axes]
            turned = self._axes[holder.joint], holder.placement.rotation.copy()
        return _Load(self._seat(engine, force.body, point), turned, at, isinstance(force, Torque))


def _numbers(mechanism: Mechanism, point: Vector) -> Triple:
    x, y, z = (mechanism.evaluate(c) for c in point)
    return x, y, z


def _signal(mechanism: Mechanism, signal: Input) -> Callable[[float], float]:
    """The signal as a function of t, compiled if it is an expression."""
    if callable(signal.signal):
        return signal.function(mechanism.values)
    function = compiled([signal.signal], ("t", *mechanism.values))
    values = tuple(mechanism.values.values())
    return lambda t: function(t, *values)[0]
