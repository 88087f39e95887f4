"""Every body cut free, in series: its rates of momentum, its weight, what is applied to it, and where."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, final

from mecanique.derivation.laws import laws_of
from mecanique.derivation.scalars.cancel import tidy
from mecanique.derivation.scalars.series import Series
from mecanique.derivation.symbolic.axes import Axes, axes_of, normal_of
from mecanique.derivation.symbolic.kinematics import Kinematics
from mecanique.derivation.symbolic.springs import Assumption, Span, Travel
from mecanique.derivation.symbolic.vectors import Vector, cross, total, zero
from mecanique.derivation.tree.poses import combination
from mecanique.model.expression import Scalar
from mecanique.model.forces import AnyForce, BodyLoad, JointLoad, LineLoad, WrenchOnBody
from mecanique.model.joints import Joint

__all__ = ["Applied", "Cut", "Cuts"]


@final
@dataclass(frozen=True)
class Applied:
    """A force or couple on a body, in the axes of the body's carrier.

    Args:
        name: of the force.
        force: shape (3,) [N].
        moment: shape (3,), a couple [N·m].
        arm: shape (3,), its point against the origin of the body's frame [m].
        velocity: shape (3,), of that point [m/s].
    """

    name: str
    force: Vector
    moment: Vector
    arm: Vector
    velocity: Vector


@final
@dataclass(frozen=True)
class Cut:
    """A body cut free; vectors are in the axes of its carrier.

    Args:
        body: its name.
        joint: the joint that holds it.
        carrier: place of the link in whose axes the vectors are, −1 for the world.
        axes: in which its equations are written.
        mass: [kg].
        fixed: whether the origin of its frame rests.
        center: shape (3,), its center of mass against the origin of its frame; zero for one without
            mass [m].
        center_velocity: shape (3,) [m/s].
        spin: shape (3,), angular velocity [rad/s].
        push: shape (3,), rate of the linear momentum [N].
        turning: shape (3,), moment of the rates of momentum about the origin of its frame, ∫ y ×
            x'' dm [N·m].
        weight: shape (3,) [N].
        weight_moment: shape (3,), about the origin of its frame [N·m].
        applied: springs, dampers, drives and loads.
    """

    body: str
    joint: Joint
    carrier: int
    axes: Axes
    mass: Series
    fixed: bool
    center: Vector
    center_velocity: Vector
    spin: Vector
    push: Vector
    turning: Vector
    weight: Vector
    weight_moment: Vector
    applied: tuple[Applied, ...]

    def loads(self) -> tuple[Vector, Vector]:
        """Resultant of what is applied, and its moment about the origin of the body's frame."""
        force = [component - component for component in self.push]
        moment = list(force)
        for one in self.applied:
            force = [a + b for a, b in zip(force, one.force, strict=True)]
            lever = cross(one.arm, one.force)
            moment = [a + b + c for a, b, c in zip(moment, one.moment, lever, strict=True)]
        return [tidy(c) for c in force], [tidy(c) for c in moment]


@final
class Cuts:
    """The bodies of a mechanism, cut free.

    Args:
        kinematics: of the mechanism.
    """

    def __init__(self, kinematics: Kinematics) -> None:
        self.kinematics = kinematics
        self.algebra = kinematics.algebra
        self.assumptions: list[Assumption] = []
        self.lengths: dict[str, Series] = {}
        self._applied: dict[str, list[Applied]] = {}
        for force in self.algebra.mechanism.forces:
            for body, one in self._of(force):
                self._applied.setdefault(body, []).append(one)
        normal = normal_of(kinematics)
        self.planar = normal is not None and any(link.kind == "turn" for link in kinematics.tree)
        self.bodies = tuple(
            self._cut(joint, axes_of(kinematics, joint.child, normal)) for joint in self._joints()
        )

    def between_seats(self, parent: str, child: str) -> Vector:
        """Return the origin of a child's frame against its parent's, in the axes of the parent's carrier.

        Args:
            parent: name of the body that carries.
            child: name of the body carried.
        """
        kinematics = self.kinematics
        start, end = kinematics.carrier(parent), kinematics.carrier(child)
        if start == end:
            ends = (kinematics.seat(parent), kinematics.seat(child))
        else:
            ends = (kinematics.point(parent, (0, 0, 0)), kinematics.point(child, (0, 0, 0)))
        reach = [b - a for a, b in zip(*ends, strict=True)]
        return reach if start == end else kinematics.between(reach, -1, start)

    def carried(self, vector: Sequence[Series], start: str, end: str) -> Vector:
        """Return a vector in the axes of another body's carrier.

        Args:
            vector: shape (3,).
            start: name of the body in whose carrier's axes it is.
            end: name of the other body.
        """
        kinematics = self.kinematics
        return kinematics.between(vector, kinematics.carrier(start), kinematics.carrier(end))

    def _joints(self) -> tuple[Joint, ...]:
        return self.algebra.mechanism.tree

    def _cut(self, joint: Joint, axes: Axes) -> Cut:
        kinematics, algebra, body = self.kinematics, self.algebra, joint.child
        carrier = kinematics.carrier(body)
        turn = kinematics.turn(kinematics.place[body])
        rate = kinematics.rate(body)
        J = kinematics.moments(body)
        first = [algebra.lifted(combination(row, [J[k][3] for k in range(3)])) for row in turn]
        momentum = [algebra.lifted(combination(row, [J[k][3] for k in range(4)])) for row in rate]
        push = [tidy(c) for c in kinematics.change(momentum, carrier)]
        # ∫ y y'ᵀ dm = K J K'ᵀ, whose skew part is ∫ y × y' dm
        inner = [[combination(row, [J[i][k] for i in range(3)]) for k in range(3)] for row in turn]
        outer = [[combination(row, other[:3]) for other in rate] for row in inner]
        own = [
            algebra.lifted(outer[i][k]) - algebra.lifted(outer[k][i])
            for i, k in ((1, 2), (2, 0), (0, 1))
        ]
        origin_velocity = kinematics.velocity(body, (0, 0, 0))
        origin_acceleration = kinematics.change(origin_velocity, carrier)
        turning = total(
            algebra, [kinematics.change(own, carrier), cross(first, origin_acceleration)]
        )
        described = algebra.mechanism.body(body)
        mass = algebra.lifted(J[3][3])
        point = tuple(algebra.series(c) for c in described.center) if mass else tuple(zero(algebra))
        fall = kinematics.vector(algebra.mechanism.gravity, "world", body)
        return Cut(
            body=body,
            joint=joint,
            carrier=carrier,
            axes=axes,
            mass=mass,
            fixed=not any(origin_velocity),
            center=[tidy(algebra.lifted(combination(row, point))) for row in turn],
            center_velocity=[tidy(algebra.lifted(c)) for c in self._moved(rate, point)],
            spin=kinematics.spin(body),
            push=push,
            turning=[tidy(c) for c in turning],
            weight=[mass * g for g in fall],
            weight_moment=cross(first, fall),
            applied=tuple(self._applied.get(body, ())),
        )

    def _moved(self, rate: Any, point: Sequence[Any]) -> list[Any]:
        return [combination(row, [*point, 1]) for row in rate]

    def _of(self, force: AnyForce) -> Iterator[tuple[str, Applied]]:
        """What a force does to each body that can move."""
        match force:
            case LineLoad():
                yield from self._along_line(force)
            case JointLoad():
                yield from self._in_joint(force)
            case BodyLoad():
                wrench = force.wrench
                if self.kinematics.place[wrench.body] >= 0:
                    parts = (
                        self._components(wrench, given) for given in (wrench.force, wrench.torque)
                    )
                    yield wrench.body, self._at(force.name, wrench.body, wrench.point, *parts)

    def _components(self, wrench: WrenchOnBody, given: Sequence[Scalar] | None) -> Vector:
        if given is None:
            return zero(self.algebra)
        return self.kinematics.vector(given, wrench.axes, wrench.body)

    def _at(
        self, name: str, body: str, point: Sequence[Scalar], force: Vector, moment: Vector
    ) -> Applied:
        kinematics, algebra = self.kinematics, self.algebra
        here = [algebra.arithmetic(component, algebra.values) for component in point]
        turn = kinematics.turn(kinematics.place[body])
        arm = [tidy(algebra.lifted(combination(row, here))) for row in turn]
        return Applied(name, force, moment, arm, kinematics.velocity(body, point))

    def _along_line(self, force: LineLoad) -> Iterator[tuple[str, Applied]]:
        """A force on both its ends, along the line between them."""
        kinematics, algebra = self.kinematics, self.algebra
        span = Span(kinematics, force)
        laws = laws_of(force, algebra.series)
        pull = total(algebra, [law.pull(span) for law in laws])
        if span.length is not None:
            self.lengths[force.name] = span.length
        # elsewhere the length enters with its square, so its sign does not matter
        if span.assumption is not None and force.conservative:
            self.assumptions.append(span.assumption)
        for end, sign in zip(force.ends, (1, -1), strict=True):
            body = end.body
            if kinematics.place[body] >= 0:
                turned = kinematics.between([sign * p for p in pull], -1, kinematics.carrier(body))
                yield (
                    body,
                    self._at(force.name, body, end.point, [tidy(c) for c in turned], zero(algebra)),
                )

    def _in_joint(self, force: JointLoad) -> Iterator[tuple[str, Applied]]:
        """A force in a joint on child and parent, along or about its axis."""
        kinematics, algebra = self.kinematics, self.algebra
        joint = algebra.mechanism.joint(force.joint)
        place = kinematics.place[joint.child]
        link = kinematics.tree[place]
        travel = Travel.in_joint(algebra, force.joint)
        pulls = [law.pull(travel) for law in laws_of(force, algebra.series)]
        size = -algebra.ring.sum(pulls)
        axis = [algebra.arithmetic(component, {}) for component in link.axis]
        direction = [algebra.lifted(combination(row, axis)) for row in kinematics.turn(place)]
        vector, nothing = [tidy(size * c) for c in direction], zero(algebra)
        parts = (vector, nothing) if link.kind == "slide" else (nothing, vector)
        yield joint.child, self._at(force.name, joint.child, (0.0, 0.0, 0.0), *parts)
        if kinematics.place[joint.parent] >= 0:
            back = [[-c for c in self.carried(part, joint.child, joint.parent)] for part in parts]
            arm = self.between_seats(joint.parent, joint.child)
            # the point of the parent that is where the joint is now
            velocity = total(
                algebra,
                [
                    kinematics.velocity(joint.parent, (0, 0, 0)),
                    cross(kinematics.spin(joint.parent), arm),
                ],
            )
            yield joint.parent, Applied(force.name, back[0], back[1], arm, velocity)
