"""Cut every body free, in series: its rates of momentum, weight and applied forces."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import final

from mecanique.derivation.laws import laws_of
from mecanique.derivation.scalars.series import Series
from mecanique.derivation.symbolic.free_bodies.axes import Axes, axes_of, normal_of
from mecanique.derivation.symbolic.kinematics import ORIGIN, Kinematics
from mecanique.derivation.symbolic.lines_of_action import Assumption, Span, Travel
from mecanique.derivation.symbolic.ties.contacts import Touch, contact_ties, touches
from mecanique.derivation.symbolic.ties.loops import Closing, closings
from mecanique.derivation.symbolic.ties.tie import Tie
from mecanique.derivation.symbolic.vectors import Vector, Wrench, cross, lift, total, zero
from mecanique.derivation.tree.poses import Matrix, combination, transpose
from mecanique.model.expression import Scalar
from mecanique.model.force_base import AnyForce, BodyLoad, JointLoad, LineLoad, WrenchOnBody
from mecanique.model.joints import Joint


@final
@dataclass(frozen=True)
class Applied:
    """A force or couple on a body, in the axes of the body's carrier.

    Args:
        name: name of the force.
        force: [N].
        moment: a couple [N·m].
        arm: vector from the origin of the body's frame to its point of action [m].
        velocity: velocity of that point [m/s].
        ties: whether it is the unknown force of a contact or a loop.
    """

    name: str
    force: Vector
    moment: Vector
    arm: Vector
    velocity: Vector
    ties: bool = False


@final
@dataclass(frozen=True)
class Cut:
    """A body cut free; vectors are in the axes of its carrier.

    Args:
        body: its name.
        joint: the joint that connects it to its parent.
        carrier: index of the link in whose axes the vectors are, −1 for the world.
        axes: the axes in which its equations are written.
        mass: [kg].
        fixed: whether the origin of its frame is at rest.
        center: vector from the origin of its frame to its center of mass; zero without
            mass [m].
        center_velocity: [m/s].
        spin: angular velocity [rad/s].
        push: rate of the linear momentum [N].
        turning: moment of m a about the origin of its frame, ∫ y × x'' dm [N·m].
        weight: [N].
        weight_moment: about the origin of its frame [N·m].
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

    @property
    def inert(self) -> bool:
        """Whether it has mass, or moments of inertia without mass, as rotating parts may."""
        return bool(self.mass) or any(self.turning)

    def loads(self) -> Wrench:
        """Return the resultant of the applied forces, about the origin of the body's frame."""
        nothing = zero(self.mass.ring)
        forces = [one.force for one in self.applied]
        moments = [one.moment + cross(one.arm, one.force) for one in self.applied]
        return Wrench(total([nothing, *forces]), total([nothing, *moments])).tidy()


@final
class Cuts:
    """The bodies of a mechanism, cut free."""

    def __init__(self, kinematics: Kinematics) -> None:
        self.kinematics = kinematics
        self.algebra = kinematics.algebra
        self.assumptions: list[Assumption] = []
        self.lengths: dict[str, Series] = {}
        self._applied: dict[str, list[Applied]] = {}
        for force in self.algebra.mechanism.forces:
            for body, one in self._apply(force):
                self._applied.setdefault(body, []).append(one)
        self.touches = touches(kinematics)
        for touch in self.touches:
            self.assumptions += touch.assumptions
            for body, one in self._apply_contact(touch):
                self._applied.setdefault(body, []).append(one)
        self.closings = closings(kinematics)
        for closing in self.closings:
            for body, one in self._apply_loop(closing):
                self._applied.setdefault(body, []).append(one)
        normal = normal_of(kinematics)
        self.planar = normal is not None and any(link.kind == "turn" for link in kinematics.tree)
        self.bodies = tuple(
            self._cut(joint, axes_of(kinematics, joint.child, normal))
            for joint in self.algebra.mechanism.tree
        )

    def _apply_contact(self, touch: Touch) -> Iterator[tuple[str, Applied]]:
        """Yield the unknown force of a contact on one body, and its opposite on the other."""
        contact, wrench = touch.contact, Wrench(touch.force, zero(self.algebra.ring))
        for body, sign in ((contact.body, 1), (contact.on, -1)):
            if self.kinematics.place[body] >= 0:
                yield body, self._tie(contact.name, body, touch.place, wrench, sign)

    def _apply_loop(self, closing: Closing) -> Iterator[tuple[str, Applied]]:
        """Yield the unknown force of a loop on one body, and its opposite on the other."""
        loop, wrench = closing.loop, closing.wrench
        ends = (loop.body_b, closing.on_b, 1), (loop.body_a, closing.on_a, -1)
        for body, place, sign in ends:
            if self.kinematics.place[body] >= 0:
                yield body, self._tie(f"the loop {loop.name}", body, place, wrench, sign)

    def _tie(self, name: str, body: str, place: Vector, wrench: Wrench, sign: int) -> Applied:
        """Apply an unknown force at a place in the world, and a couple, to a body."""
        kinematics = self.kinematics
        carrier = kinematics.carrier(body)
        reach = place - kinematics.point(body, ORIGIN)
        given = (wrench.force * sign, wrench.moment * sign, reach)
        F, M, arm = (kinematics.between(x, -1, carrier).tidy() for x in given)
        v, w = kinematics.velocity(body), kinematics.spin(body)
        return Applied(name, F, M, arm, v + cross(w, arm), ties=True)

    @cached_property
    def ties(self) -> tuple[Tie, ...]:
        """The equations of loops, then of contacts and velocity constraints."""
        loops = [tie for closing in self.closings for tie in closing.ties]
        return (*loops, *contact_ties(self.kinematics, self.touches))

    def between_seats(self, parent: str, child: str) -> Vector:
        """Return the vector from a parent's origin to a child's, in the parent's carrier's axes.

        Args:
            parent: name of the parent.
            child: name of the child.
        """
        kinematics = self.kinematics
        start, end = kinematics.carrier(parent), kinematics.carrier(child)
        if start == end:
            ends = (kinematics.seat(parent), kinematics.seat(child))
        else:
            ends = (kinematics.point(parent, ORIGIN), kinematics.point(child, ORIGIN))
        reach = ends[1] - ends[0]
        return reach if start == end else kinematics.between(reach, -1, start)

    def carry(self, vector: Vector, start: str, end: str) -> Vector:
        """Transform a vector to the axes of another body's carrier.

        Args:
            vector: the vector.
            start: name of the body in whose carrier's axes it is given.
            end: name of the other body.
        """
        kinematics = self.kinematics
        return kinematics.between(vector, kinematics.carrier(start), kinematics.carrier(end))

    def carried_wrench(self, wrench: Wrench, start: str, end: str) -> Wrench:
        """Transform a force and a moment to the axes of another body's carrier.

        Args:
            wrench: force and moment.
            start: name of the body in whose carrier's axes they are given.
            end: name of the other body.
        """
        return Wrench(self.carry(wrench.force, start, end), self.carry(wrench.moment, start, end))

    def _cut(self, joint: Joint, axes: Axes) -> Cut:
        kinematics, algebra, body = self.kinematics, self.algebra, joint.child
        ring, carrier = algebra.ring, kinematics.carrier(body)
        K, Kd = kinematics.turn(kinematics.place[body]), kinematics.rate(body)
        J = kinematics.moments(body)
        S = [row[3] for row in J]  # mass times the center of mass, and the mass
        first = lift(ring, [combination(row, S[:3]) for row in K])
        momentum = lift(ring, [combination(row, S) for row in Kd])
        velocity = kinematics.velocity(body)
        acceleration = kinematics.change(velocity, carrier)
        tumbling = kinematics.change(self._spin_momentum(K, Kd, J), carrier)
        described = algebra.mechanism.body(body)
        mass = algebra.lift(J[3][3])
        point = [algebra.series(c) for c in described.center] if mass else [*zero(ring)]
        fall = kinematics.vector(algebra.mechanism.gravity, "world", body)
        return Cut(
            body=body,
            joint=joint,
            carrier=carrier,
            axes=axes,
            mass=mass,
            fixed=not any(velocity),
            center=lift(ring, [combination(row, point) for row in K]).tidy(),
            center_velocity=lift(ring, [combination(row, [*point, 1]) for row in Kd]).tidy(),
            spin=kinematics.spin(body),
            push=kinematics.change(momentum, carrier).tidy(),
            turning=total([tumbling, cross(first, acceleration)]).tidy(),
            weight=fall * mass,
            weight_moment=cross(first, fall),
            applied=tuple(self._applied.get(body, ())),
        )

    def _spin_momentum(self, K: Matrix, Kd: Matrix, J: Matrix) -> Vector:
        """Return ∫ y × y' dm, the skew part of ∫ y y'ᵀ dm = K J K'ᵀ."""
        columns = transpose(J)[:3]
        outer = []
        for row in K:
            KJ = [combination(row, column[:3]) for column in columns]
            outer.append([self.algebra.lift(combination(KJ, rate[:3])) for rate in Kd])
        return Vector(*(outer[i][k] - outer[k][i] for i, k in ((1, 2), (2, 0), (0, 1))))

    def _apply(self, force: AnyForce) -> Iterator[tuple[str, Applied]]:
        """Yield the action of a force on each body that can move."""
        match force:
            case LineLoad():
                yield from self._apply_line(force)
            case JointLoad():
                yield from self._apply_joint(force)
            case BodyLoad():
                wrench = force.wrench
                if self.kinematics.place[wrench.body] >= 0:
                    parts = (
                        self._components(wrench, given) for given in (wrench.force, wrench.torque)
                    )
                    yield wrench.body, self._apply_at(force.name, wrench.body, wrench.point, *parts)

    def _components(self, wrench: WrenchOnBody, given: Sequence[Scalar] | None) -> Vector:
        if given is None:
            return zero(self.algebra.ring)
        return self.kinematics.vector(given, wrench.axes, wrench.body)

    def _apply_at(
        self, name: str, body: str, point: Sequence[Scalar], force: Vector, moment: Vector
    ) -> Applied:
        kinematics, algebra = self.kinematics, self.algebra
        here = [algebra.arithmetic(component, algebra.values) for component in point]
        turn = kinematics.turn(kinematics.place[body])
        arm = lift(algebra.ring, [combination(row, here) for row in turn]).tidy()
        return Applied(name, force, moment, arm, kinematics.velocity(body, point))

    def _apply_line(self, force: LineLoad) -> Iterator[tuple[str, Applied]]:
        """Yield a force on both its ends, along the line between them."""
        kinematics, algebra = self.kinematics, self.algebra
        span = Span(kinematics, force)
        laws = laws_of(force, algebra.series)
        pull = total([law.pull(span) for law in laws])
        if span.length is not None:
            self.lengths[force.name] = span.length
        # other forces contain only the square of the length, so its sign does not matter
        if span.assumption is not None and force.conservative:
            self.assumptions.append(span.assumption)
        for end, sign in zip(force.ends, (1, -1), strict=True):
            body = end.body
            if kinematics.place[body] >= 0:
                F = kinematics.between(pull * sign, -1, kinematics.carrier(body)).tidy()
                yield body, self._apply_at(force.name, body, end.point, F, zero(algebra.ring))

    def _apply_joint(self, force: JointLoad) -> Iterator[tuple[str, Applied]]:
        """Yield a joint's force on child and parent, along or about its axis."""
        kinematics, algebra = self.kinematics, self.algebra
        joint = algebra.mechanism.joint(force.joint)
        place = kinematics.place[joint.child]
        link = kinematics.tree[place]
        travel = Travel.in_joint(algebra, force.joint)
        pulls = [law.pull(travel) for law in laws_of(force, algebra.series)]
        size = -algebra.ring.sum(pulls)
        axis = [algebra.arithmetic(component, {}) for component in link.axis]
        e = lift(algebra.ring, [combination(row, axis) for row in kinematics.turn(place)])
        F, nothing = (e * size).tidy(), zero(algebra.ring)
        wrench = Wrench(F, nothing) if link.kind == "slide" else Wrench(nothing, F)
        child, parent = joint.child, joint.parent
        yield child, self._apply_at(force.name, child, ORIGIN, wrench.force, wrench.moment)
        if kinematics.place[parent] >= 0:
            back = -self.carried_wrench(wrench, child, parent)
            arm = self.between_seats(parent, child)
            # velocity of the parent's point at the joint's present position
            v, w = kinematics.velocity(parent), kinematics.spin(parent)
            yield parent, Applied(force.name, back.force, back.moment, arm, v + cross(w, arm))
