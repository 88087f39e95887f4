"""Compute springs, dampers, drives and loads as forces on the engine's bodies and in its joints.

The law of each is stated here independently of the derivation: a spring pulls its ends together
with k (l − l₀), a damper with c dl/dt, along the line between them; a spring in a joint exerts
−k (r − r₀), a damper −c r' (Meirovitch, Elements of Vibration Analysis, sect. 1-2).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from math import dist, sqrt
from typing import NamedTuple, final

import numpy as np

from mecanique.arrays import Array
from mecanique.errors import EngineError
from mecanique.model.expression import (
    DISTANCE,
    POSITION,
    Scalar,
    Vector,
    compile_scalars,
)
from mecanique.model.force_base import AnyForce, BodyLoad, FieldLoad, JointLoad, LineLoad
from mecanique.model.forces import (
    CentralForce,
    Damper,
    JointDamper,
    JointForce,
    JointSpring,
    Potential,
    PotentialField,
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


def law_of(force: LineLoad | JointLoad | FieldLoad) -> Law:
    """Return the law of a spring, a damper or a drive."""
    match force:
        case Spring():
            return Law(stiffness=force.stiffness, rest=force.free_length)
        case JointSpring():
            return Law(stiffness=force.stiffness, rest=force.reference)
        case Damper() | JointDamper():
            return Law(damping=force.damping)
        case CentralForce() | Potential() | PotentialField():
            return Law(potential=force.potential)
        case JointForce():
            return Law(drive=force.force)
    raise EngineError(f"no law is known for force {force.name!r}, a {type(force).__name__}")


_ZERO: Triple = (0.0, 0.0, 0.0)


@final
class _Field:
    """A potential V(q, t), its slopes ∂V/∂q and, of a distance r alone, its tension (∂V/∂r)/r."""

    def __init__(self, mechanism: Mechanism, potential: Scalar, names: Sequence[str]) -> None:
        import sympy

        # real symbols, so that |x| has the derivative sign(x)
        real = {sympy.Symbol(name): sympy.Symbol(name, real=True) for name in names}
        V = sympy.sympify(potential).subs(real)
        x = real[sympy.Symbol(names[0])]
        self.even = sympy.expand(V - V.subs(x, -x)) == 0
        slopes = [*map(V.diff, real.values())]
        if names == (DISTANCE,):
            slopes.append(sympy.cancel(slopes[0] / x) if self.even else slopes[0] / x)
        back = {symbol: name for name, symbol in real.items()}
        letters = (*names, "t", *mechanism.values)
        self._values = tuple(mechanism.values.values())
        self._slopes = compile_scalars([part.xreplace(back) for part in slopes], letters)
        self._energy = compile_scalars([V.xreplace(back)], letters)

    def slopes(self, *at: float) -> tuple[float, ...]:
        """Return ∂V/∂q at q and t."""
        return self._slopes(*at, *self._values)

    def tension(self, x: float, t: float) -> float:
        """Return (∂V/∂x)/x of a distance x."""
        return self._slopes(x, t, *self._values)[-1]

    def energy(self, *at: float) -> float:
        """Return V at q and t [J]."""
        return self._energy(*at, *self._values)[0]


@final
class _Well(NamedTuple):
    """A potential of the coordinates of joints: the joints' velocities and these, by index."""

    name: str
    rows: tuple[int, ...]
    at: tuple[int, ...]
    field: _Field


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
    field: _Field | None = None  # a potential of where the site is, which pushes with −∇V


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
        self._wells: list[_Well] = []
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
        self.act_in_joints = bool(self._terms or self._wells)
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
                rows = tuple(engine.seats[joint][-1].at_v for joint in force.joints)
                names = [mechanism.joint(joint).coordinates[-1] for joint in force.joints]
                at = tuple(index[name] for name in names)
                if law.potential is None:
                    drive = _note(None if law.drive is None else (law.drive,), scalars)
                    self._terms.append(_Term(force.name, rows[0], at[0], *constants, drive))
                else:
                    field = _Field(mechanism, law.potential, names)
                    self._wells.append(_Well(force.name, rows, at, field))
            case BodyLoad():
                wrench = force.wrench
                turned = None
                if wrench.axes != "world":
                    holder = engine.holders[wrench.axes]
                    turned = self._axes[holder.joint], holder.placement.rotation.copy()
                site = self._seat(engine, wrench.body, _numbers(mechanism, wrench.point))
                parts = _note(wrench.force, scalars), _note(wrench.torque, scalars)
                self._loads.append(_Load(force.name, site, turned, *parts))
            case FieldLoad():
                site = self._seat(engine, force.body, _numbers(mechanism, force.point))
                V = law_of(force).potential
                assert V is not None, "a field has a potential"
                well = _Field(mechanism, V, POSITION)
                self._loads.append(_Load(force.name, site, None, None, None, well))

    def update(
        self, values: list[float], q: Array, u: Array, v: Array, t: float
    ) -> list[SiteAction]:
        """Set `external` and `in_joints`, and return the actions on the bodies."""
        numbers = self._evaluate(q, v, t)
        if self.act_in_joints:
            forces = self.in_joints
            forces[:] = self._driving
            for _, row, size in self._sizes(values, u, t, numbers):
                forces[row] += size
        if not self.act_on_bodies:
            return []
        actions = [action for line in self._lines for action in _pull(line, t)]
        actions += [_push(load, numbers, t) for load in self._loads]
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
        actions = {line.name: [*_pull(line, t)] for line in self._lines}
        for load in self._loads:
            actions[load.name] = [_push(load, numbers, t)._replace(point=load.site.position())]
        for name, row, size in self._sizes(values, u, t, numbers):
            actions.setdefault(name, []).extend(self._hinges[row].actions(size))
        return [
            (action.point, action.force, action.torque)
            for name in self._names
            for action in actions[name]
        ]

    @property
    def effects(self) -> list[tuple[str, str, str | None]]:
        """Return the name of each force, its body, and the body with the opposite, if any."""
        pairs: dict[str, list[tuple[str, str | None]]] = {
            line.name: [(line.a.body, line.b.body), (line.b.body, line.a.body)]
            for line in self._lines
        }
        pairs |= {load.name: [(load.site.body, None)] for load in self._loads}
        acting = [(term.name, (term.row,)) for term in self._terms]
        for name, rows in (*acting, *((well.name, well.rows) for well in self._wells)):
            for hinge in (self._hinges[row] for row in rows):
                child, parent = hinge.child.body, hinge.parent.body
                pairs.setdefault(name, []).extend([(child, parent), (parent, child)])
        return [(name, *pair) for name in self._names for pair in pairs[name]]

    def across_joints(self) -> list[SiteAction]:
        """Return the forces in the joints as actions on the child and, opposite, on the parent."""
        return [
            action
            for row, hinge in self._hinges.items()
            if (size := float(self.in_joints[row]))
            for action in hinge.actions(size)
        ]

    def energy(self, values: list[float], t: float) -> float:
        """Return the potential energy of springs, ½ k (elongation)² each, and of fields [J]."""
        total = 0.0
        for line in self._lines:
            if line.stiffness or line.field is not None:
                length = dist(line.b.position(), line.a.position())
                total += 0.5 * line.stiffness * (length - line.free_length) ** 2
                total += 0.0 if line.field is None else line.field.energy(length, t)
        for term in self._terms:
            total += 0.5 * term.stiffness * (values[term.at] - term.rest) ** 2
        for well in self._wells:
            total += well.field.energy(*(values[k] for k in well.at), t)
        for load in self._loads:
            if load.field is not None:
                total += load.field.energy(*load.site.position(), t)
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
        self, values: list[float], u: Array, t: float, numbers: tuple[float, ...]
    ) -> Iterator[tuple[str, int, float]]:
        """Yield each force in a joint: its name, the index of the joint's velocity, its size."""
        for name, row, at, stiffness, rest, damping, drive in self._terms:
            size = -stiffness * (values[at] - rest) - damping * u.item(row)
            yield name, row, size if drive is None else size + numbers[drive]
        for name, rows, places, field in self._wells:
            slopes = field.slopes(*(values[k] for k in places), t)
            for row, slope in zip(rows, slopes, strict=True):
                yield name, row, -slope

    def _seat(self, engine: EngineModel, body: str, point: Triple = _ZERO) -> Site:
        holder = engine.holders[body]
        x, y, z = holder.placement.act(np.array(point)).tolist()
        return Site(body, self._axes[holder.joint], (x, y, z))

    def _line(self, mechanism: Mechanism, engine: EngineModel, force: LineLoad) -> _Line:
        a, b = (self._seat(engine, end.body, _numbers(mechanism, end.point)) for end in force.ends)
        law = law_of(force)
        constants = _numbers(mechanism, (law.stiffness, law.rest, law.damping))
        V = law.potential
        field = None if V is None else _Field(mechanism, V, (DISTANCE,))
        return _Line(force.name, a, b, *constants, field)


def _pull(line: _Line, t: float) -> tuple[SiteAction, SiteAction]:
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
            tension += line.field.tension(sqrt(square), t)
        if line.damping:
            va, vb = line.a.velocity(), line.b.velocity()
            parting = dx * (vb[0] - va[0]) + dy * (vb[1] - va[1]) + dz * (vb[2] - va[2])
            tension += line.damping * parting / square
    fx, fy, fz = tension * dx, tension * dy, tension * dz
    on_a = SiteAction(line.a, (fx, fy, fz), xa, _ZERO)
    on_b = SiteAction(line.b, (-fx, -fy, -fz), xb, _ZERO)
    return on_a, on_b


def _push(load: _Load, numbers: tuple[float, ...], t: float) -> SiteAction:
    """Return the action of a load on its body."""
    if load.field is not None:
        place = load.site.position()
        x, y, z = load.field.slopes(*place, t)
        return SiteAction(load.site, (-x, -y, -z), place, _ZERO)
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
