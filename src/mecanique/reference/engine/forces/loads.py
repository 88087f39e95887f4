"""Compute springs, dampers, drives and loads as forces on the engine's bodies and in its joints.

The law of each is stated here independently of the derivation: a spring pulls its ends together
with k (l − l₀), a damper with c dl/dt, along the line between them; a spring in a joint exerts
−k (r − r₀), a damper −c r' (Meirovitch, Elements of Vibration Analysis, sect. 1-2).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from math import sqrt
from typing import NamedTuple, final

import numpy as np

from mecanique.arrays import Array
from mecanique.errors import EngineError
from mecanique.model.expression import (
    DISTANCE,
    Scalar,
    Vector,
    accept_arrays,
    compile_scalars,
)
from mecanique.model.force_base import AnyForce, BodyLoad, JointLoad, LineLoad
from mecanique.model.forces import (
    CentralForce,
    Damper,
    JointDamper,
    JointForce,
    JointSpring,
    Potential,
    Spring,
)
from mecanique.model.joint_base import Single
from mecanique.model.mechanism import Mechanism
from mecanique.model.parameters import Input
from mecanique.reference.engine.forces.sites import External, JointAxes, Site, SiteAction, Triple
from mecanique.reference.engine.load import EngineModel


@final
@dataclass(frozen=True)
class Law:
    """A force along x, a length or a coordinate: −k (x − x₀) − c x' + F − dV/dx."""

    stiffness: Scalar = 0.0  # k
    rest: Scalar = 0.0  # x₀
    damping: Scalar = 0.0  # c
    drive: Scalar | None = None  # F, which may depend on the state and time; None if there is none
    potential: Scalar | None = None  # V(x), which adds -dV/dx; None if there is none


def law_of(force: LineLoad | JointLoad) -> Law:
    """Return the law of a spring, a damper or a drive."""
    match force:
        case Spring():
            return Law(stiffness=force.stiffness, rest=force.free_length)
        case JointSpring():
            return Law(stiffness=force.stiffness, rest=force.reference)
        case Damper() | JointDamper():
            return Law(damping=force.damping)
        case CentralForce() | Potential():
            return Law(potential=force.potential)
        case JointForce():
            return Law(drive=force.force)
    raise EngineError(f"no law is known for force {force.name!r}, a {type(force).__name__}")


_ZERO: Triple = (0.0, 0.0, 0.0)


@final
class _Field:
    """A potential V(x), its slope dV/dx and, where V is even, (dV/dx)/x."""

    def __init__(self, mechanism: Mechanism, potential: Scalar, name: str) -> None:
        import sympy

        # a real symbol, so that |x| has the derivative sign(x)
        x, V = sympy.Symbol(name, real=True), sympy.sympify(potential)
        values = {sympy.Symbol(letter): value for letter, value in mechanism.values.items()}
        V = V.subs({**values, sympy.Symbol(name): x})
        self.even = sympy.expand(V - V.subs(x, -x)) == 0
        per_x = sympy.cancel(V.diff(x) / x) if self.even else V.diff(x) / x
        back = {x: sympy.Symbol(name)}
        slopes = [part.xreplace(back) for part in (V.diff(x), per_x)]
        self._slopes = compile_scalars(slopes, (name,))
        self._energy = accept_arrays(compile_scalars([V.xreplace(back)], (name,)))

    def slope(self, x: float) -> float:
        """Return dV/dx."""
        return self._slopes(x)[0]

    def tension(self, x: float) -> float:
        """Return (dV/dx)/x."""
        return self._slopes(x)[1]

    def energy(self, x: Array) -> Array:
        """Return V [J]."""
        return np.asarray(self._energy(x)[0], dtype=float)


@final
@dataclass(frozen=True, eq=False)
class _Line:
    """A force between two points."""

    name: str
    a: Site
    b: Site
    stiffness: float
    free_length: float
    damping: float
    field: _Field | None

    @property
    def directed(self) -> bool:
        """Whether it needs a direction, so that its ends must not coincide."""
        free = bool(self.free_length or self.damping)
        return free or (self.field is not None and not self.field.even)


class _Term(NamedTuple):
    """A force in a joint: the joint's velocity, its coordinate and F, each by index."""

    name: str
    row: int
    at: int
    stiffness: float
    rest: float
    damping: float
    field: _Field | None
    drive: int | None


@final
@dataclass(frozen=True, eq=False)
class _Hinge:
    """A joint with one coordinate in which a force may act, with the origins of its bodies."""

    joint: Single
    child: Site
    parent: Site

    def actions(self, size: float) -> tuple[SiteAction, SiteAction]:
        """Return the action of a joint's force on the child, and its opposite on the parent."""
        a, b, c = self.child.axes.to_world(self.joint.axis)
        along = (a * size, b * size, c * size)
        against = (-a * size, -b * size, -c * size)
        point = self.child.position()
        if self.joint.turns:
            return (
                SiteAction(self.child, _ZERO, point, along),
                SiteAction(self.parent, _ZERO, point, against),
            )
        return SiteAction(self.child, along, point, _ZERO), SiteAction(
            self.parent, against, point, _ZERO
        )


@final
@dataclass(frozen=True, eq=False)
class _Load:
    """A force and a torque on a body, in the axes of `turned`, if any."""

    # `force` and `torque` are the indices of their first components; None if there is none

    name: str
    site: Site
    turned: tuple[JointAxes, Array] | None
    force: int | None
    torque: int | None


@final
class Loads:
    """All forces of a mechanism except gravity and reactions."""

    # The engine's data must contain the positions and velocities of the state in question

    def __init__(self, mechanism: Mechanism, engine: EngineModel, index: dict[str, int]) -> None:
        self._values = tuple(mechanism.values.values())
        poses, twists = engine.data.oMi, engine.data.v
        self._axes = [
            JointAxes(
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
        self._terms: list[_Term] = []
        self._loads: list[_Load] = []
        self._names = [force.name for force in mechanism.forces]
        scalars: list[Scalar] = []

        for force in mechanism.forces:
            self._add(force, mechanism, engine, index, scalars)
        self._varies = bool(scalars)
        self._asks = any(callable(signal.signal) for signal in mechanism.inputs)
        self.waiting = False
        """Whether a function of time is being evaluated, as part of the evaluation of a state."""
        symbols = (*(signal.symbol for signal in mechanism.inputs), *mechanism.values)
        self._scalars: Callable[..., tuple[float, ...]] = compile_scalars(
            scalars, (*mechanism.coordinates, *mechanism.velocities, "t", *symbols)
        )
        self.sites = {body: self._seat(engine, body) for body in engine.holders}
        """The origin of each body."""
        self._hinges = {
            engine.seats[joint.name][-1].at_v: _Hinge(
                joint, self.sites[joint.child], self.sites[joint.parent]
            )
            for joint in mechanism.joints
            if isinstance(joint, Single)
        }
        self.external = External(engine.model.njoints)
        """The wrenches on the engine's bodies."""
        self.in_joints: Array = np.zeros(engine.model.nv)
        """Forces in the engine's joints."""
        self._driving: Array = np.zeros(engine.model.nv)
        self.act_on_bodies = bool(self._lines or self._loads)
        """Whether a force acts on a body."""
        self.act_in_joints = bool(self._terms)
        """Whether a force acts in a joint."""

    def _add(
        self,
        force: AnyForce,
        mechanism: Mechanism,
        engine: EngineModel,
        index: dict[str, int],
        scalars: list[Scalar],
    ) -> None:
        """Add a force to those of its kind, and its expressions to the scalars."""
        match force:
            case LineLoad():
                self._lines.append(self._line(mechanism, engine, force))
            case JointLoad():
                law = law_of(force)
                constants = _numbers(mechanism, (law.stiffness, law.rest, law.damping))
                row = engine.seats[force.joint][-1].at_v
                at = index[mechanism.joint(force.joint).coordinates[-1]]
                drive = _note(None if law.drive is None else (law.drive,), scalars)
                field = None
                if law.potential is not None:
                    name = mechanism.joint(force.joint).coordinates[-1]
                    field = _Field(mechanism, law.potential, name)
                self._terms.append(_Term(force.name, row, at, *constants, field, drive))
            case BodyLoad():
                wrench = force.wrench
                turned = None
                if wrench.axes != "world":
                    holder = engine.holders[wrench.axes]
                    turned = self._axes[holder.joint], holder.placement.rotation.copy()
                site = self._seat(engine, wrench.body, _numbers(mechanism, wrench.point))
                parts = _note(wrench.force, scalars), _note(wrench.torque, scalars)
                self._loads.append(_Load(force.name, site, turned, *parts))

    def update(
        self, values: list[float], q: Array, u: Array, v: Array, t: float
    ) -> list[SiteAction]:
        """Set `external` and `in_joints`, and return the actions on the bodies."""
        numbers = self._evaluate(q, v, t)
        if self.act_in_joints:
            forces = self.in_joints
            forces[:] = self._driving
            for row, size in self._sizes(values, u, numbers):
                forces[row] += size
        if not self.act_on_bodies:
            return []
        actions = [action for line in self._lines for action in _pull(line)]
        actions += [_push(load, numbers) for load in self._loads]
        self.external.set(actions)
        return actions

    def drive(self, torques: Array | float) -> None:
        """Apply additional forces in the engine's joints until the next call."""
        self._driving[:] = torques
        self.in_joints[:] = torques

    def by_force(
        self, values: list[float], q: Array, u: Array, v: Array, t: float
    ) -> list[tuple[Triple, Triple, Triple]]:
        """Return each force's point of action, force and moment there, as `effects` lists them."""
        numbers = self._evaluate(q, v, t)
        actions: dict[str, Sequence[SiteAction]] = {line.name: _pull(line) for line in self._lines}
        for load in self._loads:
            actions[load.name] = [_push(load, numbers)._replace(point=load.site.position())]
        for term, (row, size) in zip(self._terms, self._sizes(values, u, numbers), strict=True):
            actions[term.name] = self._hinges[row].actions(size)
        return [
            (action.point, action.force, action.torque)
            for name in self._names
            for action in actions[name]
        ]

    @property
    def effects(self) -> list[tuple[str, str, str | None]]:
        """Return the name of each force, its body, and the body with the opposite, if any."""
        pairs = {line.name: (line.a.body, line.b.body) for line in self._lines}
        hinges = {term.name: self._hinges[term.row] for term in self._terms}
        pairs |= {name: (hinge.child.body, hinge.parent.body) for name, hinge in hinges.items()}
        alone = {load.name: load.site.body for load in self._loads}
        reach: list[tuple[str, str, str | None]] = []
        for name in self._names:
            if name in alone:
                reach.append((name, alone[name], None))
            else:
                a, b = pairs[name]
                reach += [(name, a, b), (name, b, a)]
        return reach

    def across_joints(self) -> list[SiteAction]:
        """Return the forces in the joints as actions on the child and, opposite, on the parent."""
        return [
            action
            for row, hinge in self._hinges.items()
            if (size := float(self.in_joints[row]))
            for action in hinge.actions(size)
        ]

    def energy(self, values: Array, position: Callable[[Site], Array]) -> Array:
        """Return the potential energy of springs, ½ k (elongation)² each, and of fields [J]."""
        # in one state or in n: values (…, k), positions (…, 3)
        total = np.zeros(values.shape[:-1])
        for line in self._lines:
            if line.stiffness or line.field is not None:
                length = np.linalg.norm(position(line.b) - position(line.a), axis=-1)
                total += 0.5 * line.stiffness * (length - line.free_length) ** 2
                total += 0.0 if line.field is None else line.field.energy(length)
        for term in self._terms:
            if term.stiffness or term.field is not None:
                x = values[..., term.at]
                total += 0.5 * term.stiffness * (x - term.rest) ** 2
                total += 0.0 if term.field is None else term.field.energy(x)
        return total

    def check(self) -> None:
        """Refuse a state in which a force between two points has no direction."""
        for line in self._lines:
            if line.directed and line.a.position() == line.b.position():
                what = "spring or damper" if line.field is None else "central force"
                raise EngineError(
                    f"{what} {line.name!r} has no direction: its ends, on "
                    f"{line.a.body!r} and {line.b.body!r}, coincide; "
                    "move the mechanism a little, or its ends"
                )

    def _evaluate(self, q: Array, v: Array, t: float) -> tuple[float, ...]:
        """Evaluate the expressions of loads and drives."""
        if not self._varies:
            return ()
        self.waiting = self._asks
        try:
            signals = [signal(t) for signal in self._signals]
        finally:
            self.waiting = False
        return self._scalars(*q.tolist(), *v.tolist(), t, *signals, *self._values)

    def _sizes(
        self, values: list[float], u: Array, numbers: tuple[float, ...]
    ) -> Iterator[tuple[int, float]]:
        """Yield each force in a joint, with the index of the joint's velocity."""
        for _, row, at, stiffness, rest, damping, field, drive in self._terms:
            size = -stiffness * (values[at] - rest) - damping * u.item(row)
            size -= 0.0 if field is None else field.slope(values[at])
            yield row, size if drive is None else size + numbers[drive]

    def _seat(self, engine: EngineModel, body: str, point: Triple = _ZERO) -> Site:
        holder = engine.holders[body]
        x, y, z = holder.placement.act(np.array(point)).tolist()
        return Site(body, self._axes[holder.joint], (x, y, z))

    def _line(self, mechanism: Mechanism, engine: EngineModel, force: LineLoad) -> _Line:
        a, b = (self._seat(engine, end.body, _numbers(mechanism, end.point)) for end in force.ends)
        law = law_of(force)
        constants = _numbers(mechanism, (law.stiffness, law.rest, law.damping))
        V = law.potential
        field = None if V is None else _Field(mechanism, V, DISTANCE)
        return _Line(force.name, a, b, *constants, field)


def _pull(line: _Line) -> tuple[SiteAction, SiteAction]:
    """Return the actions of a force on its two points; zero where they coincide."""
    xa, xb = line.a.position(), line.b.position()
    dx, dy, dz = xb[0] - xa[0], xb[1] - xa[1], xb[2] - xa[2]
    tension = line.stiffness  # tension per length
    if line.field is not None or line.directed:
        square = dx * dx + dy * dy + dz * dz
        if line.directed and not square:
            return SiteAction(line.a, _ZERO, xa, _ZERO), SiteAction(line.b, _ZERO, xb, _ZERO)
        if line.free_length:
            tension *= 1 - line.free_length / sqrt(square)
        if line.field is not None:
            tension += line.field.tension(sqrt(square))
        if line.damping:
            va, vb = line.a.velocity(), line.b.velocity()
            parting = dx * (vb[0] - va[0]) + dy * (vb[1] - va[1]) + dz * (vb[2] - va[2])
            tension += line.damping * parting / square
    fx, fy, fz = tension * dx, tension * dy, tension * dz
    on_a = SiteAction(line.a, (fx, fy, fz), xa, _ZERO)
    on_b = SiteAction(line.b, (-fx, -fy, -fz), xb, _ZERO)
    return on_a, on_b


def _push(load: _Load, numbers: tuple[float, ...]) -> SiteAction:
    """Return the action of a load on its body."""
    force, torque = _components(load, load.force, numbers), _components(load, load.torque, numbers)
    point = _ZERO if load.force is None else load.site.position()
    return SiteAction(load.site, force, point, torque)


def _components(load: _Load, at: int | None, numbers: tuple[float, ...]) -> Triple:
    if at is None:
        return _ZERO
    vector = numbers[at], numbers[at + 1], numbers[at + 2]
    if load.turned is None:
        return vector
    axes, turn = load.turned
    x, y, z = (turn @ vector).tolist()
    return axes.to_world((x, y, z))


def _note(given: Sequence[Scalar] | None, scalars: list[Scalar]) -> int | None:
    """Add expressions to the scalars; return where the first one stands, None if there is none."""
    if given is None:
        return None
    scalars.extend(given)
    return len(scalars) - len(given)


def _numbers(mechanism: Mechanism, point: Vector) -> Triple:
    x, y, z = mechanism.evaluate_all(point)
    return x, y, z


def _signal(mechanism: Mechanism, signal: Input) -> Callable[[float], float]:
    """Return a signal as a function of t, compiled if it is an expression."""
    if callable(signal.signal):
        return signal.function(mechanism.values)
    function = compile_scalars([signal.signal], ("t", *mechanism.values))
    values = tuple(mechanism.values.values())
    return lambda t: function(t, *values)[0]
