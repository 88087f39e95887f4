"""Springs, dampers, drives and loads: on bodies, and as generalized forces along the tree."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property, partial
from typing import Any, Protocol, final

import numpy as np

from mecanique.derivation.laws import Stored, Travel, laws_of
from mecanique.derivation.mechanics.letters import Letters, LetterValues
from mecanique.derivation.mechanics.recursion import TreeRecursion
from mecanique.derivation.mechanics.vectors import (
    STILL,
    Triple,
    add,
    apply,
    dot,
    scale,
    times_point,
)
from mecanique.derivation.tree.poses import exact_direction
from mecanique.errors import DerivationError
from mecanique.model.expression import DISTANCE, POSITION, Scalar
from mecanique.model.force_base import AnyForce, BodyLoad, FieldLoad, JointLoad, LineLoad
from mecanique.model.joint_base import Single
from mecanique.model.mechanism import Mechanism
from mecanique.program.sweeps import pull_back
from mecanique.program.traced import trace, value_of

NOTHING = STILL


@final
@dataclass(frozen=True)
class AppliedWrench:
    """A force and a moment on a body, world axes."""

    name: str  # name of the force, the joint or loop, or of the body for weight and inertia
    kind: str  # "weight", "reaction", "inertia", or the kind of the force
    body: str
    origin: Triple
    force: Triple
    moment: Triple  # moment about that point
    point: Triple = NOTHING  # the point of a load, in the body's axes

    def opposite(self, body: str) -> AppliedWrench:
        """Return the opposite action, on the other body."""
        force, moment = scale(-1.0, self.force), scale(-1.0, self.moment)
        return replace(self, body=body, force=force, moment=moment)


@final
class Span:
    """The line between two points, in scalars of any kind."""

    name = DISTANCE

    def __init__(
        self,
        reach: Triple,
        root: Callable[[Any], Any],
        find_rate: Callable[[Span], Any] | None = None,
        ratio: Callable[[Any, Any], Any] | None = None,
    ) -> None:
        self.reach = reach
        self._root, self._find_rate, self._ratio = root, find_rate, ratio

    @property
    def values(self) -> dict[str, Any]:
        """The distance, by the name that potentials call it."""
        return {DISTANCE: self.x}

    @cached_property
    def square(self) -> Any:
        """The squared distance."""
        return dot(self.reach, self.reach)

    @cached_property
    def x(self) -> Any:
        """The distance."""
        return self._root(self.square)

    @property
    def length(self) -> Any | None:
        """The distance, if a law has needed it."""
        return vars(self).get("x")

    @cached_property
    def unit(self) -> Triple:
        """The direction; zero where the ends meet, if they may."""
        length = self.x
        if isinstance(length, np.ndarray):
            length = np.where(length > 0, length, np.inf)
        if isinstance(self.reach, np.ndarray):
            return self.reach / length
        return [self._ratio(c, length) if self._ratio else c / length for c in self.reach]

    @cached_property
    def rate(self) -> Any:
        """The rate of the distance."""
        assert self._find_rate is not None, "energies need no rates"
        return self._find_rate(self)

    def direct(self, slope: Any | None, size: Any | None) -> Triple:
        """Return (slope · x + size) e."""
        total = STILL
        if slope is not None:
            total = add(total, scale(slope, self.reach))
        if size is not None:
            total = add(total, scale(size, self.unit))
        return total


class Bodies(Protocol):
    """The bodies of a mechanism, as the laws of forces need them, in scalars of any kind."""

    @property
    def mechanism(self) -> Mechanism:
        """Whose bodies they are."""

    def number(self, scalar: Any, given: Mapping[str, Any] | None = None) -> Any:
        """Convert a scalar of the description; values of more letters may be given."""

    def components(
        self, given: Sequence[Scalar | Fraction], values: Mapping[str, Any] | None = None
    ) -> Triple:
        """Convert components of the description; values of more letters may be given."""

    def point(self, body: str, place: Sequence[Scalar]) -> Triple:
        """Return a point of a body in the world."""

    def in_world(self, components: Sequence[Scalar | Fraction], axes: str) -> Triple:
        """Return a vector, given in the axes of a body or the "world", in the world's."""

    def span(self, force: LineLoad) -> Span:
        """Return the line between the ends of a force."""

    def travel(self, joint: str) -> Travel:
        """Return the coordinate of a joint, which a force acts along."""


def as_place(xyz: Triple) -> Travel:
    """Return a place in the world, which potentials take instead of a coordinate."""
    return Travel(None, None, values=dict(zip(POSITION, xyz, strict=True)))


def argument_of(force: LineLoad | JointLoad | FieldLoad, bodies: Bodies) -> Span | Travel:
    """Return the line that a force acts along, its joint's coordinate, or where its point is."""
    match force:
        case LineLoad():
            return bodies.span(force)
        case FieldLoad():
            return as_place(bodies.point(force.body, force.point))
    return bodies.travel(force.joints[0])


def actions_of(force: AnyForce, bodies: Bodies) -> list[AppliedWrench]:
    """Return the actions of a force: on body a or the child, then on body b or the parent."""
    match force:
        case LineLoad():
            span, (a, b) = bodies.span(force), force.ends
            pull = add(*(law.pull(span) for law in laws_of(force, bodies.number)))
            first, second = (
                AppliedWrench(
                    force.name,
                    force.kind,
                    end.body,
                    bodies.point(end.body, end.point),
                    pull,
                    NOTHING,
                    bodies.components(end.point),
                )
                for end in (a, b)
            )
            return [first, second.opposite(b.body)]
        case JointLoad():
            return [action for joint in force.joints for action in _twist(force, joint, bodies)]
        case BodyLoad():
            wrench = force.wrench
            pull, turn = (
                NOTHING if part is None else bodies.in_world(part, wrench.axes)
                for part in (wrench.force, wrench.torque)
            )
            at, point = bodies.point(wrench.body, wrench.point), bodies.components(wrench.point)
            return [AppliedWrench(force.name, force.kind, wrench.body, at, pull, turn, point)]
        case FieldLoad():
            at, point = bodies.point(force.body, force.point), bodies.components(force.point)
            (law,) = (law for law in laws_of(force, bodies.number) if isinstance(law, Stored))
            push = scale(-1.0, bodies.components(law.gradient, as_place(at).values))
            return [AppliedWrench(force.name, force.kind, force.body, at, push, NOTHING, point)]
    kind = type(force).__name__
    raise DerivationError(f"no program is known for force {force.name!r}, a {kind}")


def _twist(force: JointLoad, name: str, bodies: Bodies) -> list[AppliedWrench]:
    joint = bodies.mechanism.joint(name)
    assert isinstance(joint, Single), "validated"
    axis = bodies.in_world(exact_direction(joint.axis), joint.child)
    along_axis = scale(_push(force, name, bodies), axis)
    pair = (NOTHING, along_axis) if joint.turns else (along_axis, NOTHING)
    origin = bodies.point(joint.child, (0.0, 0.0, 0.0))
    one = AppliedWrench(force.name, force.kind, joint.child, origin, *pair)
    return [one, one.opposite(joint.parent)]


def _push(force: JointLoad, joint: str, bodies: Bodies) -> Any:
    """Return the force or moment on a joint's child, along the joint."""
    travel, size = bodies.travel(joint), 0.0
    for law in laws_of(force, bodies.number):
        size = size - law.pull(travel)
    return size


@final
class Forces:
    """The forces of a mechanism on its tree."""

    def __init__(self, letters: LetterValues, recursion: TreeRecursion) -> None:
        self.mechanism = letters.mechanism
        self._letters = letters
        self._recursion = recursion

    @cached_property
    def _column(self) -> dict[str, int]:
        """The last joint velocity of each joint, by the joint's name."""
        columns: dict[str, int] = {}
        for joint in self.mechanism.tree:
            for name in joint.velocities:
                columns[name] = len(columns)
        moving = [joint for joint in self.mechanism.tree if joint.velocities]
        return {joint.name: columns[joint.velocities[-1]] for joint in moving}

    def project(self) -> list[Any]:
        """Return the generalized forces, shape (nv,)."""
        tau: list[Any] = self._recursion.chart.project(self.in_joints())
        return tau

    def in_joints(self) -> list[Any]:
        """Return the forces along the joint velocities, collected along the tree, shape (nu,)."""
        tree = self._recursion
        loads: dict[int, tuple[Triple, Triple]] = {}
        for action in self.at_points():
            wrench = tree.on_link(action.body, action.point, action.force, action.moment)
            if wrench.place >= 0:
                F, M = loads.get(wrench.place, (STILL, STILL))
                loads[wrench.place] = add(F, wrench.force), add(M, wrench.moment)
        tau: list[Any] = [0.0] * len(tree.chart.u)
        if loads:
            tau = tree.collect([loads.get(k, (STILL, STILL)) for k in range(len(tree.links))])
        for k, push in self.pushes_in_joints().items():
            tau[k] = tau[k] + push
        return tau

    def pushes_in_joints(self) -> dict[int, Any]:
        """Return the sum of what springs, dampers and drives do along each joint velocity."""
        pushes: dict[int, Any] = {}
        for force in self.mechanism.forces:
            if isinstance(force, JointLoad):
                for joint in force.joints:
                    k = self._column[joint]
                    pushes[k] = pushes.get(k, 0.0) + _push(force, joint, self)
        return pushes

    def at_points(self) -> list[AppliedWrench]:
        """Return the actions of all forces but those in joints, each at a point of its body."""
        forces = [force for force in self.mechanism.forces if not isinstance(force, JointLoad)]
        return [action for force in forces for action in actions_of(force, self)]

    def energy(self) -> Any:
        """Return the springs' energy."""
        total: Any = 0.0
        for force in self.mechanism.forces:
            if not force.conservative or isinstance(force, BodyLoad):
                continue
            along = argument_of(force, self)
            for law in laws_of(force, self.number):
                if law.kind == "potential":
                    total = total + law.scalar(along)
        return total

    def on_bodies(self) -> list[AppliedWrench]:
        """Return each force's actions: on body a or the child, then on body b or the parent."""
        return [action for force in self.mechanism.forces for action in actions_of(force, self)]

    def number(self, scalar: Any, given: Mapping[str, Any] | None = None) -> Any:
        """Convert a scalar of the description; values of more letters may be given."""
        r = self._recursion.chart.r
        return self._letters.number(scalar, {**r, **given} if given else r)

    def components(
        self, given: Sequence[Scalar | Fraction], values: Mapping[str, Any] | None = None
    ) -> Triple:
        """Convert components of the description; values of more letters may be given."""
        return self._letters.vector([self.number(c, values) for c in given])

    def point(self, body: str, place: Sequence[Scalar]) -> Triple:
        """Return a point of a body in the world."""
        return times_point(self._recursion.pose(body), self.components(place))

    def in_world(self, components: Sequence[Scalar | Fraction], axes: str) -> Triple:
        """Return a vector, given in the axes of a body or the "world", in the world's."""
        vector = self.components(components)
        return vector if axes == "world" else apply(self._recursion.pose(axes), vector)

    def travel(self, joint: str) -> Travel:
        """Return the coordinate of a joint, which a force acts along."""
        chart = self._recursion.chart
        name = self.mechanism.joint(joint).coordinates[-1]
        return Travel(chart.r[name], chart.u[self._column[joint]], name)

    def span(self, force: LineLoad) -> Span:
        """Return the line between the ends of a force."""
        a, b = (self.point(end.body, end.point) for end in force.ends)

        def find_rate(span: Span) -> Any:
            if isinstance(self._letters, Letters):
                return dot(span.unit, self._letters.along(span.reach))
            before, after = (
                self._recursion.velocity(end.body, self.components(end.point)) for end in force.ends
            )
            return dot(span.unit, add(after, scale(-1.0, before)))

        root = partial(self._letters.call, "sqrt")
        return Span(add(b, scale(-1.0, a)), root, find_rate)


def on_velocities(letters: Letters, moved: Sequence[Any], weights: Sequence[Any]) -> list[Any]:
    """Return Σ weight ∂x'/∂v for functions x(q, t), for each velocity."""
    tape = letters.tape
    gradient = pull_back(
        tape,
        [value_of(x) for x in moved],
        [value_of(w) for w in weights],
        [q.place for q in letters.q],
    )
    through = pull_back(
        tape,
        [value_of(rate) for rate in letters.rates],
        gradient,
        [v.place for v in letters.v],
    )
    return [trace(tape, value) for value in through]
