"""Springs, dampers, drives and loads: on bodies, and as generalized forces along the tree."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, final

import numpy as np

from mecanique.derivation.laws import LineOfAction, Travel, laws_of
from mecanique.derivation.mechanics.letters import Letters, LetterValues
from mecanique.derivation.mechanics.recursion import TreeRecursion
from mecanique.derivation.mechanics.vectors import (
    STILL,
    Triple,
    add,
    apply,
    dot,
    position,
    scale,
    times_point,
)
from mecanique.errors import DerivationError
from mecanique.model.expression import DISTANCE, Scalar
from mecanique.model.force_base import AnyForce, BodyLoad, End, JointLoad, LineLoad
from mecanique.model.joint_base import Single
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
        reach: Sequence[Any],
        root: Callable[[Any], Any],
        parting: Callable[[], Sequence[Any]] | None = None,
    ) -> None:
        self.reach = reach
        self._root, self._parting = root, parting

    @property
    def values(self) -> dict[str, Any]:
        """The distance, by the name that potentials call it."""
        return {DISTANCE: self.x}

    @property
    def square(self) -> Any:
        """The squared distance."""
        return dot(self.reach, self.reach)

    @cached_property
    def x(self) -> Any:
        """The distance."""
        return self._root(self.square)

    @cached_property
    def unit(self) -> Triple:
        """The direction; zero where the ends meet, if they may."""
        length = self.x
        if isinstance(length, np.ndarray):
            length = np.where(length > 0, length, np.inf)
        if isinstance(self.reach, np.ndarray):
            return self.reach / length
        return [c / length for c in self.reach]

    @cached_property
    def rate(self) -> Any:
        """The rate of the distance."""
        assert self._parting is not None, "energies need no rates"
        return dot(self.unit, self._parting())

    def direct(self, slope: Any | None, size: Any | None) -> Triple:
        """Return (slope · x + size) e."""
        total = STILL
        if slope is not None:
            total = add(total, scale(slope, self.reach))
        if size is not None:
            total = add(total, scale(size, self.unit))
        return total


@final
class Forces:
    """The forces of a mechanism."""

    def __init__(self, letters: LetterValues, recursion: TreeRecursion) -> None:
        self._letters = letters
        self._recursion = recursion

    @cached_property
    def _column(self) -> dict[str, int]:
        """The last joint velocity of each joint, by the joint's name."""
        letters = self._letters
        columns: dict[str, int] = {}
        for joint in letters.mechanism.tree:
            for name in joint.velocities:
                columns[name] = len(columns)
        moving = [joint for joint in letters.mechanism.tree if joint.velocities]
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
        for force in self._letters.mechanism.forces:
            if isinstance(force, JointLoad):
                for joint in force.joints:
                    k = self._column[joint]
                    pushes[k] = pushes.get(k, 0.0) + self._push_joint(force, joint)
        return pushes

    def at_points(self) -> list[AppliedWrench]:
        """Return the actions of all forces but those in joints, each at a point of its body."""
        forces = self._letters.mechanism.forces
        return [a for force in forces if not isinstance(force, JointLoad) for a in self.of(force)]

    def energy(self) -> Any:
        """Return the springs' energy."""
        total: Any = 0.0
        for force in self._letters.mechanism.forces:
            if not force.conservative or isinstance(force, BodyLoad):
                continue
            path: LineOfAction = (
                self._span(force)
                if isinstance(force, LineLoad)
                else self._travel(force, force.joints[0])
            )
            for law in laws_of(force, self._number):
                if law.kind == "potential":
                    total = total + law.scalar(path)
        return total

    def on_bodies(self) -> list[AppliedWrench]:
        """Return each force's actions: on body a or the child, then on body b or the parent."""
        return [action for force in self._letters.mechanism.forces for action in self.of(force)]

    def of(self, force: AnyForce) -> list[AppliedWrench]:
        """Return the actions of one force."""
        match force:
            case LineLoad():
                return self._pull(force)
            case JointLoad():
                return [action for joint in force.joints for action in self._twist(force, joint)]
            case BodyLoad():
                return [self._push(force)]
        kind = type(force).__name__
        raise DerivationError(f"no program is known for force {force.name!r}, a {kind}")

    def _pull(self, force: LineLoad) -> list[AppliedWrench]:
        span, (a, b) = self._span(force), force.ends
        pull = add(*(law.pull(span) for law in laws_of(force, self._number)))
        start, end = self._vector(a.point), self._vector(b.point)
        one = AppliedWrench(force.name, force.kind, a.body, self._locate(a), pull, NOTHING, start)
        other = one.opposite(b.body)
        return [one, replace(other, origin=self._locate(b), point=end)]

    def _twist(self, force: JointLoad, name: str) -> list[AppliedWrench]:
        joint = self._letters.mechanism.joint(name)
        if not isinstance(joint, Single):
            raise DerivationError(f"force {force.name!r} acts in a joint of several coordinates")
        pose = self._recursion.pose(joint.child)
        axis = self._letters.vector(joint.axis)
        along_axis = scale(self._push_joint(force, name), apply(pose, axis))
        pair = (NOTHING, along_axis) if joint.turns else (along_axis, NOTHING)
        one = AppliedWrench(force.name, force.kind, joint.child, position(pose), *pair)
        return [one, one.opposite(joint.parent)]

    def _push_joint(self, force: JointLoad, joint: str) -> Any:
        """Return the force or moment on a joint's child, along the joint."""
        size: Any = 0.0
        travel = self._travel(force, joint)
        for law in laws_of(force, self._number):
            size = size - law.pull(travel)
        return size

    def _travel(self, force: JointLoad, joint: str) -> Travel:
        chart, mechanism = self._recursion.chart, self._letters.mechanism
        name = mechanism.joint(joint).coordinates[-1]
        return Travel(chart.r[name], chart.u[self._column[joint]], name)

    def _push(self, force: BodyLoad) -> AppliedWrench:
        wrench, pull, turn = force.wrench, NOTHING, NOTHING
        if wrench.force is not None:
            pull = self._in_world(force, wrench.force)
        if wrench.torque is not None:
            turn = self._in_world(force, wrench.torque)
        place = self._vector(wrench.point)
        at = times_point(self._recursion.pose(wrench.body), place)
        return AppliedWrench(force.name, force.kind, wrench.body, at, pull, turn, place)

    def _in_world(self, force: BodyLoad, components: Sequence[Scalar]) -> Triple:
        """Return a load's components along the axes of the world."""
        vector = self._vector(components)
        if force.wrench.axes == "world":
            return vector
        return apply(self._recursion.pose(force.wrench.axes), vector)

    def _vector(self, components: Sequence[Scalar]) -> Triple:
        return self._letters.vector([self._number(c) for c in components])

    def _number(self, scalar: Any, given: Mapping[str, Any] | None = None) -> Any:
        r = self._recursion.chart.r
        return self._letters.number(scalar, {**r, **given} if given else r)

    def _span(self, force: LineLoad) -> Span:
        a, b = (self._locate(end) for end in force.ends)
        reach = add(b, scale(-1.0, a))

        def parting() -> Triple:
            if isinstance(self._letters, Letters):
                return self._letters.along(reach)
            before, after = (
                self._recursion.velocity(end.body, self._vector(end.point)) for end in force.ends
            )
            return add(after, scale(-1.0, before))

        return Span(reach, self._root, parting)

    def _root(self, square: Any) -> Any:
        return self._letters.call("sqrt", square)

    def _locate(self, end: End) -> Triple:
        """Return a point of a body in the world."""
        return times_point(self._recursion.pose(end.body), self._vector(end.point))


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
