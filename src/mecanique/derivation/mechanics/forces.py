"""Springs, dampers, drives and loads: on bodies, and as generalized forces by virtual work.

A force F at a point x(q, t) has the generalized forces F·∂x/∂q: one reverse sweep from all points,
weighted with the forces on them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, final

import numpy as np

from mecanique.derivation.laws import Travel, laws_of
from mecanique.derivation.mechanics.chart import along
from mecanique.derivation.mechanics.letters import Letters
from mecanique.derivation.mechanics.recursion import TreeRecursion
from mecanique.derivation.mechanics.vectors import Rows, Triple, add, apply, dot, scale
from mecanique.derivation.tree.poses import times_point
from mecanique.errors import DerivationError
from mecanique.model.force_base import BodyLoad, End, JointLoad, LineLoad
from mecanique.model.joint_base import Single
from mecanique.program.sweeps import pull_back
from mecanique.program.traced import trace, value_of

NOTHING: Triple = [0.0, 0.0, 0.0]


@final
@dataclass(frozen=True)
class Action:
    """A force and a moment on a body, world axes."""

    name: str  # name of the force, the joint or loop, or of the body for weight and inertia
    kind: str  # "weight", "reaction", "inertia", or the kind of the force
    body: str
    origin: Triple
    force: Triple
    moment: Triple  # moment about that point

    def opposite(self, body: str) -> Action:
        """Return the opposite action, on the other body."""
        force, moment = scale(-1.0, self.force), scale(-1.0, self.moment)
        return replace(self, body=body, force=force, moment=moment)


@final
class Span:
    """The line between two points, in scalars of any kind."""

    def __init__(
        self,
        reach: Sequence[Any],
        root: Callable[[Any], Any],
        parting: Callable[[], Sequence[Any]] | None = None,
    ) -> None:
        self.reach = reach
        self._root, self._parting = root, parting

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
        return [c / length for c in self.reach]

    @cached_property
    def rate(self) -> Any:
        """The rate of the distance."""
        assert self._parting is not None, "energies need no rates"
        return dot(self.unit, self._parting())

    def direct(self, slope: Any | None, size: Any | None) -> Triple:
        """Return (slope · x + size) e."""
        total: Triple = [0.0, 0.0, 0.0]
        if slope is not None:
            total = add(total, scale(slope, self.reach))
        if size is not None:
            total = add(total, scale(size, self.unit))
        return total


@final
class Forces:
    """The forces of a mechanism."""

    def __init__(self, letters: Letters, recursion: TreeRecursion) -> None:
        self._letters = letters
        self._recursion = recursion
        columns: dict[str, int] = {}
        for joint in letters.mechanism.tree:
            for name in joint.velocities:
                columns[name] = len(columns)
        self._column = {
            joint.name: columns[joint.velocities[-1]]
            for joint in letters.mechanism.tree
            if joint.velocities
        }
        self._coordinate = {
            joint.name: joint.coordinates[-1]
            for joint in letters.mechanism.tree
            if joint.coordinates
        }

    def project(self) -> list[Any]:
        """Return the generalized forces, shape (nv,)."""
        letters, chart = self._letters, self._recursion.chart
        tau: list[Any] = [0.0] * len(chart.u)
        moved: list[Any] = []
        weights: list[Any] = []
        for force in letters.mechanism.forces:
            match force:
                case LineLoad():
                    span = self._span(force)
                    for law in laws_of(force, self._number):
                        moved += span.reach
                        weights += [-c for c in law.pull(span)]
                case JointLoad():
                    k = self._column[force.joint]
                    travel = Travel(chart.r[self._coordinate[force.joint]], chart.u[k])
                    for law in laws_of(force, self._number):
                        tau[k] = tau[k] - law.pull(travel)
                case BodyLoad():
                    self._load(force, moved, weights)
                case _:
                    kind = type(force).__name__
                    raise DerivationError(f"no program is known for force {force.name!r}, a {kind}")
        found = on_velocities(letters, moved, weights)
        return [x + y for x, y in zip(chart.project(tau), found, strict=True)]

    def energy(self) -> Any:
        """Return the springs' energy."""
        total: Any = 0.0
        chart = self._recursion.chart
        for force in self._letters.mechanism.forces:
            if not force.conservative or isinstance(force, BodyLoad):
                continue
            path: Any
            if isinstance(force, LineLoad):
                path = self._span(force)
            else:
                path = Travel(chart.r[self._coordinate[force.joint]], 0.0)
            for law in laws_of(force, self._number):
                if law.kind == "potential":
                    total = total + law.scalar(path)
        return total

    def on_bodies(self) -> list[Action]:
        """Return the actions of each force: on body a or the child, then on body b or the parent.

        Raises:
            DerivationError: if a force is of an unknown kind.
        """
        actions: list[Action] = []
        for force in self._letters.mechanism.forces:
            match force:
                case LineLoad():
                    actions += self._pull(force)
                case JointLoad():
                    actions += self._twist(force)
                case BodyLoad():
                    actions.append(self._push(force))
                case _:
                    kind = type(force).__name__
                    raise DerivationError(f"no program is known for force {force.name!r}, a {kind}")
        return actions

    def _pull(self, force: LineLoad) -> list[Action]:
        span, (a, b) = self._span(force), force.ends
        pull = add(*(law.pull(span) for law in laws_of(force, self._number)))
        one = Action(force.name, force.kind, a.body, self._locate(a), pull, NOTHING)
        return [one, replace(one.opposite(b.body), origin=self._locate(b))]

    def _twist(self, force: JointLoad) -> list[Action]:
        chart, joint = self._recursion.chart, self._letters.mechanism.joint(force.joint)
        k = self._column[force.joint]
        travel = Travel(chart.r[self._coordinate[force.joint]], chart.u[k])
        size: Any = 0.0
        for law in laws_of(force, self._number):
            size = size - law.pull(travel)
        if not isinstance(joint, Single):
            raise DerivationError(f"force {force.name!r} acts in a joint of several coordinates")
        pose = self._recursion.pose(joint.child)
        along_axis = scale(size, apply(pose, list(joint.axis)))
        pair = (NOTHING, along_axis) if joint.turns else (along_axis, NOTHING)
        at = [row[3] for row in pose]
        one = Action(force.name, force.kind, joint.child, at, *pair)
        return [one, one.opposite(joint.parent)]

    def _push(self, force: BodyLoad) -> Action:
        wrench, turn = force.wrench, self._axes(force)
        parts = [
            NOTHING if part is None else apply(turn, list(map(self._number, part)))
            for part in (wrench.force, wrench.torque)
        ]
        pose, place = self._recursion.pose(wrench.body), list(map(self._number, wrench.point))
        return Action(force.name, force.kind, wrench.body, times_point(pose, place), *parts)

    def _axes(self, force: BodyLoad) -> Rows:
        """Return the axes in which a load's components are given."""
        if force.wrench.axes == "world":
            return [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
        return [row[:3] for row in self._recursion.pose(force.wrench.axes)]

    def _number(self, scalar: Any) -> Any:
        return self._letters.arithmetic(scalar, self._recursion.chart.r)

    def _span(self, force: LineLoad) -> Span:
        a, b = (self._locate(end) for end in force.ends)
        reach = [y - x for x, y in zip(a, b, strict=True)]
        return Span(reach, self._root, lambda: along(self._letters, reach))

    def _root(self, square: Any) -> Any:
        return self._letters.call("sqrt", square)

    def _locate(self, end: End) -> Triple:
        """Return a point of a body in the world."""
        return times_point(self._recursion.pose(end.body), [self._number(c) for c in end.point])

    def _load(self, force: BodyLoad, moved: list[Any], weights: list[Any]) -> None:
        wrench, pose = force.wrench, self._recursion.pose(force.wrench.body)
        turn = self._axes(force)
        if wrench.force is not None:
            moved += times_point(pose, [self._number(c) for c in wrench.point])
            weights += apply(turn, [self._number(c) for c in wrench.force])
        if wrench.torque is not None:
            # δW = C·δθ = ½ Σ δe·(C × e) over the body's axes e
            x, y, z = apply(turn, [self._number(c) for c in wrench.torque])
            for k in range(3):
                e = [row[k] for row in pose]
                moved += e
                crossed = [y * e[2] - z * e[1], z * e[0] - x * e[2], x * e[1] - y * e[0]]
                weights += scale(0.5, crossed)


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
