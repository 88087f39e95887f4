"""Cut every body free, in series: its rates of momentum, weight and applied forces."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property, partial
from typing import Any, final

import numpy as np

from mecanique.derivation.mechanics.forces import actions_of
from mecanique.derivation.scalars.cancel import tidy
from mecanique.derivation.scalars.series import Series
from mecanique.derivation.symbolic.constraints import bonds_of, distances_of, ties_of
from mecanique.derivation.symbolic.derivation import Assumption, Tie
from mecanique.derivation.symbolic.forces import assume_length
from mecanique.derivation.symbolic.kinematics import ORIGIN, Kinematics
from mecanique.derivation.symbolic.vectors import (
    SymbolicWrench,
    Vector,
    along,
    cross,
    lift,
    no_wrench,
    resultant,
    total,
    zero,
)
from mecanique.derivation.tolerances import ALIGNED
from mecanique.derivation.tree.poses import (
    Arithmetic,
    Matrix,
    combination,
    exact_direction,
    poses,
    times_point,
    transpose,
)
from mecanique.model import Joint, Mechanism, Revolute
from mecanique.model.guides import Guide
from mecanique.model.mechanism.letters import call
from mecanique.wording import enumerate_words

_UNITS = ((1, 0, 0), (0, 1, 0), (0, 0, 1))
_KINDS = ("force", "moment")
_LABELS = ("x", "y", "z")


@final
@dataclass(frozen=True)
class Direction:
    """A direction along which a joint may transmit a force, or about which a moment."""

    kind: str  # "force" or "moment"
    place: int  # index among the three directions of its kind
    row: Sequence[Any]  # shape (3,), in the axes of the body's carrier
    label: str  # its name, e.g. "x"; "" for the normal of a plane
    sign: int  # 1, or −1 if the reaction is positive in the opposite direction


@final
@dataclass(frozen=True)
class Axes:
    """The directions along which the equations of a body are written."""

    # shape (3, 3), directions of forces, in the axes of the body's carrier
    rows: Sequence[Sequence[Any]]
    turns: Sequence[Sequence[Any]]  # shape (3, 3), directions of moments
    sentence: str  # a sentence that introduces them to the reader
    labels: tuple[str, str, str] = _LABELS  # the reaction along "x" is R_joint_x
    turn_labels: tuple[str, str, str] = _LABELS  # "" for the normal of a plane
    # 1, or −1 if the reaction is positive in the opposite direction
    signs: tuple[int, int, int] = (1, 1, 1)
    # names of the bodies, or "the world", whose axes x, y and z forces and moments are along
    whose: Mapping[str, str] = field(default_factory=lambda: dict.fromkeys(_KINDS, "the world"))

    def along(self, wrench: SymbolicWrench) -> SymbolicWrench:
        """Return the components of a wrench, or of a twist, along these directions."""
        return SymbolicWrench(along(self.rows, wrench.force), along(self.turns, wrench.moment))

    @property
    def directions(self) -> Iterator[Direction]:
        """Yield the directions of forces, then those of moments."""
        for k, row in enumerate(self.rows):
            yield Direction("force", k, row, self.labels[k], self.signs[k])
        for k, row in enumerate(self.turns):
            yield Direction("moment", k, row, self.turn_labels[k], 1)

    def across_plane(self, direction: Direction) -> bool:
        """Return whether it is a force across a plane of motion, or a moment along that."""
        flat = "" in self.turn_labels
        return flat and bool(self.turn_labels[direction.place]) == (direction.kind == "moment")


def axes_of(kinematics: Kinematics, body: str, normal: np.ndarray | None) -> Axes:
    """Choose the axes for the equations of a body."""
    # The single body of a pendulum gets n from the pin to the center of mass and t perpendicular,
    # in the sense of its angle, as in Fundamentals of Dynamics, Figure 1.4; other bodies in plane
    # motion get the world's axes, or those of the slide that leads their center of mass
    mechanism = kinematics.algebra.mechanism
    if normal is None:
        return _axes_in_space(kinematics, body)
    if (swing := find_swing(mechanism, body)) is not None:
        joint, n, t = swing
        rotation = kinematics.turn(kinematics.place[body])
        rows = []
        for unit in (n, t, joint.axis):
            rows.append([combination(row, unit) for row in rotation])
        pin, called = joint.name, call(joint.name)
        sentence = (
            f"The unit vectors n, t and k turn with the body: n points from {called} to the center "
            f"of mass, t is perpendicular to it, in the sense of the angle, and k is along the "
            f"axis. R_{pin}_n is positive toward {called}, opposite to n, and R_{pin}_t along t. "
            "Moments are positive in the sense of the angle."
        )
        labels, turning = (("n", "t", "k"), ("n", "t", "")), dict.fromkeys(_KINDS, body)
        return Axes(rows, rows, sentence, *labels, (-1, 1, 1), turning)
    at = int(np.abs(normal).argmax())
    sign = 1 if normal[at] > 0 else -1
    about = [sign * entry for entry in _UNITS[at]]
    ring = kinematics.algebra.ring
    if not any(link.kind == "turn" for link in kinematics.tree):
        sentence = "x, y and z are the axes of the world."
        return Axes(_UNITS, _UNITS, sentence)
    pivot, rows, whose = _find_pivot(kinematics, body), [*map(list, _UNITS)], "the world"
    if pivot >= 0 and kinematics.tree[pivot].kind == "slide" and not kinematics.stands(pivot):
        rows, whose = kinematics.axes(pivot, body), kinematics.name_axes(pivot)
        at = next(
            k for k, row in enumerate(rows) if not any(cross(lift(ring, row), lift(ring, about)))
        )
    plane = " and ".join(label for k, label in enumerate(_LABELS) if k != at)
    x, y, z = ("" if k == at else label for k, label in enumerate(_LABELS))
    turns = [about if k == at else row for k, row in enumerate(rows)]
    axis = f"{'-' if sign < 0 else ''}{_LABELS[int(np.abs(normal).argmax())]}"
    sentence = (
        f"{plane} are the axes of {call(whose)}; forces are positive along them, moments about "
        f"{axis}."
    )
    axes = dict.fromkeys(_KINDS, whose)
    return Axes(rows, turns, sentence, turn_labels=(x, y, z), whose=axes)


def _axes_in_space(kinematics: Kinematics, body: str) -> Axes:
    """Choose axes for a body in space: its own, or those that do not take part in its spin."""
    # A last body may turn about hinges through its center of mass without moving that, and about an
    # axis of symmetry without changing its moments of inertia: axes before these turns are shorter
    place = kinematics.place[body]
    rows = turns = transpose(kinematics.turn(place))
    whose = whose_turns = kinematics.name_axes(place)
    constant = ""
    joints = kinematics.algebra.mechanism.joints
    if kinematics.algebra.mechanism.body(body).mass != 0 and all(j.parent != body for j in joints):
        center = _find_pivot(kinematics, body)
        if center != place:
            rows, whose = kinematics.axes(center, body), kinematics.name_axes(center)
        turns, whose_turns, symmetric = kinematics.spin_axes(body)
        if symmetric:
            axis = kinematics.tree[place].joint
            constant = (
                f", which do not spin with {call(body)}: it is symmetric about the axis of {axis}, "
                "so that its moments of inertia are constant in them too"
            )
    said = f"x, y and z are the axes of {call(whose)}"
    if whose != whose_turns:
        about = call(whose_turns)
        said = f"Forces are along x, y and z of {call(whose)}, moments about those of {about}"
    elif not constant:
        said += "; moments are taken about them"
    axes = {"force": whose, "moment": whose_turns}
    return Axes(rows, turns, f"{said}{constant}.", whose=axes)


def _find_pivot(kinematics: Kinematics, body: str) -> int:
    """Return the first link, −1 for the ground, in whose axes a body's center of mass is fixed."""
    place, algebra = kinematics.place[body], kinematics.algebra
    at = [*map(algebra.series, algebra.mechanism.body(body).center)]
    while place >= 0 and (link := kinematics.tree[place]).kind in ("turn", "ball"):
        axis = lift(algebra.ring, exact_direction(link.axis))
        across = at if link.kind == "ball" else cross(axis, lift(algebra.ring, at))
        if any(map(tidy, across)):
            break
        at = [*map(algebra.lift, times_point(kinematics.origin_of(link), at))]
        place = link.parent
    return place


def normal_of(kinematics: Kinematics) -> np.ndarray | None:
    """Return the world's axis normal to the plane of a mechanism's motion, shape (3,), or None."""
    # If nothing turns, any axis is a normal, and z is returned
    mechanism = kinematics.algebra.mechanism
    if any(link.kind in ("ball", "free") for link in kinematics.tree):
        return None
    values = {name: 0.0 for joint in mechanism.joints for name in joint.coordinates}
    turns, slides = list[np.ndarray](), list[np.ndarray]()
    frames = poses(kinematics.tree, mechanism.values | values, Arithmetic())
    for link, frame in zip(kinematics.tree, frames, strict=True):
        axis = np.array(frame, dtype=float)[:, :3] @ np.array(link.axis)
        if link.kind in ("turn", "slide"):
            (turns if link.kind == "turn" else slides).append(axis)
    if not turns:
        return np.array([0.0, 0.0, 1.0])
    normal = turns[0]
    parallel = all(np.linalg.norm(np.cross(normal, axis)) < ALIGNED for axis in turns)
    across = all(abs(normal @ axis) < ALIGNED for axis in slides)
    return normal if parallel and across and np.abs(normal).max() > 1 - ALIGNED else None


def find_swing(
    mechanism: Mechanism, body: str
) -> tuple[Revolute, tuple[float, ...], tuple[float, ...]] | None:
    """Return joint, n and t of a pendulum's only body, in its own axes; None for other bodies."""
    (joint, *others) = mechanism.joints
    if others or not isinstance(joint, Revolute) or joint.child != body:
        return None
    center = np.array(mechanism.evaluate_all(mechanism.body(body).center))
    axis = np.array(joint.axis)
    across = center - (center @ axis) * axis
    size = float(np.linalg.norm(across))
    if not size or np.abs(across).max() < size * (1 - ALIGNED) or np.abs(axis).max() < 1 - ALIGNED:
        return None
    n = np.round(across / size)
    t = np.cross(axis, n)
    return joint, tuple(n.tolist()), tuple(t.tolist())


@final
@dataclass(frozen=True)
class Applied:
    """A force or couple on a body, in the axes of the body's carrier."""

    name: str
    wrench: SymbolicWrench  # with a couple as its moment [N, N·m]
    arm: Vector  # vector from the origin of the body's frame to its point of action [m]
    velocity: Vector  # velocity of that point [m/s]
    ties: bool = False  # whether it is the unknown force of a contact or a loop


@final
@dataclass(frozen=True)
class Cut:
    """A body cut free; vectors are in the axes of its carrier."""

    body: str
    joint: Joint  # the joint that connects it to its parent
    carrier: int  # index of the link in whose axes the vectors are, −1 for the world
    axes: Axes  # the axes in which its equations are written
    mass: Series  # [kg]
    fixed: bool  # whether the origin of its frame is at rest
    # vector from the origin of its frame to its center of mass; zero without mass [m]
    center: Vector
    twist: SymbolicWrench  # velocities of its center of mass and of rotation [m/s, rad/s]
    # momentum ∫ x' dm and angular momentum ∫ y × x' dm about the origin of its frame
    momentum: SymbolicWrench  # [kg·m/s, kg·m²/s]
    # what accelerates it: ∫ x'' dm and ∫ y × x'' dm about the origin of its frame [N, N·m]
    push: SymbolicWrench
    weight: SymbolicWrench  # about the origin of its frame [N, N·m]
    applied: tuple[Applied, ...]  # springs, dampers, drives and loads

    @property
    def inert(self) -> bool:
        """Whether it has mass, or moments of inertia without mass, as rotating parts may."""
        return bool(self.mass) or any(self.push.moment)

    def loads(self) -> SymbolicWrench:
        """Return the resultant of the applied forces, about the origin of the body's frame."""
        acting = [action.wrench.about(action.arm) for action in self.applied]
        return resultant([no_wrench(self.mass.ring), *acting]).tidy()

    def about_reference(self, wrench: SymbolicWrench) -> SymbolicWrench:
        """Return a wrench about the fixed point, or else about the center of mass."""
        return wrench.about(zero(self.mass.ring) if self.fixed else -self.center)


@final
class Cuts:
    """The bodies of a mechanism, cut free."""

    def __init__(self, kinematics: Kinematics) -> None:
        self.kinematics = kinematics
        self.algebra = kinematics.algebra
        self.assumptions: list[Assumption] = []
        self.lengths: dict[str, Series] = {}
        self._applied: dict[str, list[Applied]] = {}
        to_vector = partial(lift, self.algebra.ring)
        for force in self.algebra.mechanism.forces:
            for action in actions_of(force, kinematics):
                wrench = SymbolicWrench(to_vector(action.force), to_vector(action.moment))
                self._apply(force.name, action.body, to_vector(action.origin), wrench)
            span = kinematics.spans.get(force.name)
            if span is not None and span.length is not None:
                self.lengths[force.name] = span.length
                # other forces contain only the square of the length, so its sign does not matter
                if force.conservative:
                    self.assumptions += assume_length(force.name, span.length)
        self.bonds = bonds_of(kinematics)
        self.distances = distances_of(self.bonds)
        for bond in self.bonds:
            self.assumptions += bond.assumptions
            for (body, place), wrench in zip(bond.ends, (bond.wrench, -bond.wrench), strict=True):
                self._apply(bond.name, body, place, wrench, ties=True)
        normal = normal_of(kinematics)
        self.planar = normal is not None and any(link.kind == "turn" for link in kinematics.tree)
        self.bodies = tuple(
            self._cut(joint, axes_of(kinematics, joint.child, normal))
            for joint in self.algebra.mechanism.tree
        )

    def refer(
        self, body: str, place: Vector, wrench: SymbolicWrench
    ) -> tuple[SymbolicWrench, Vector]:
        """Return a wrench at a place in the world in the axes of a body's carrier, with its arm."""
        kinematics = self.kinematics
        carrier = kinematics.carrier(body)
        given = (wrench.force, wrench.moment, place - kinematics.point(body, ORIGIN))
        F, M, arm = (kinematics.between(x, -1, carrier).tidy() for x in given)
        return SymbolicWrench(F, M), arm

    def _apply(
        self, name: str, body: str, place: Vector, wrench: SymbolicWrench, *, ties: bool = False
    ) -> None:
        """Apply a force at a place in the world, and a couple, to a body that can move."""
        if self.kinematics.place[body] < 0:
            return
        (here, arm), v, w = (
            self.refer(body, place, wrench),
            self.kinematics.velocity(body),
            self.kinematics.spin(body),
        )
        applied = Applied(name, here, arm, v + cross(w, arm), ties)
        self._applied.setdefault(body, []).append(applied)

    @cached_property
    def ties(self) -> tuple[Tie, ...]:
        """The equations of loops, then of contacts and velocity constraints."""
        return ties_of(self.kinematics, self.bonds)

    def between_seats(self, parent: str, child: str) -> Vector:
        """Return the vector from a parent's origin to a child's, in the parent's carrier's axes."""
        kinematics = self.kinematics
        start, end = kinematics.carrier(parent), kinematics.carrier(child)
        if start == end:
            ends = (kinematics.seat(parent), kinematics.seat(child))
        else:
            ends = (kinematics.point(parent, ORIGIN), kinematics.point(child, ORIGIN))
        reach = ends[1] - ends[0]
        return reach if start == end else kinematics.between(reach, -1, start)

    def carry(self, vector: Vector, start: str, end: str) -> Vector:
        """Transform a vector to the axes of another body's carrier."""
        kinematics = self.kinematics
        return kinematics.between(vector, kinematics.carrier(start), kinematics.carrier(end))

    def hand_down(self, wrench: SymbolicWrench, child: str, parent: str) -> SymbolicWrench:
        """Return a wrench on a child as one about its parent's origin, in the axes of that."""
        parts = (self.carry(part, child, parent) for part in (wrench.force, wrench.moment))
        return SymbolicWrench(*parts).about(self.between_seats(parent, child))

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
        spinning = self._spin_momentum(K, Kd, J)
        tumbling = kinematics.change(spinning, carrier)
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
            twist=SymbolicWrench(
                lift(ring, [combination(row, [*point, 1]) for row in Kd]).tidy(),
                kinematics.spin(body),
            ),
            momentum=SymbolicWrench(momentum, total([spinning, cross(first, velocity)])).tidy(),
            push=SymbolicWrench(
                kinematics.change(momentum, carrier),
                total([tumbling, cross(first, acceleration)]),
            ).tidy(),
            weight=SymbolicWrench(fall * mass, cross(first, fall)),
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


_MOST_ZEROS = 5
"""Reactions that vanish are listed by name if they are fewer than this."""


def say_zeros(zeros: Sequence[tuple[str, bool]]) -> str:
    """Say why reactions that are not listed vanish, by name and whether they are across a plane."""
    reasons = ["no joint transmits anything in the directions in which it is free"]
    if any(across for _, across in zeros):
        reasons.append("nothing acts out of the plane of the motion")
    rest = [name for name, across in zeros if not across]
    if rest:
        what = enumerate_words(rest) if len(rest) < _MOST_ZEROS else "the rest"
        reasons.append(f"no body needs {what}")
    return f"Components that are not listed are zero: {'; '.join(reasons)}."


_RATES = (
    " As the axes turn with the angular velocity Ω, the rate of a vector in them is that of its "
    "components plus the cross product of Ω and the vector."
)


def state_momentum_balance(cut: Cut, moving: bool, turning: bool) -> str:
    """Return the sentence that introduces the balance of forces of a body."""
    if moving:
        return (
            "Mass times the acceleration of the center of mass equals the resultant force."
            f"{_RATES if turning else ''} Listed are {'Ω, ' if turning else ''}the position [r] "
            "of that center, its velocity [v] and its acceleration [a], and then both sides in "
            "components."
        )
    if cut.mass:
        return "Its center of mass does not move, so the forces on it are in balance."
    return "It has no mass, so the forces on it are in balance."


def state_moment_balance(cut: Cut, spinning: bool, turning: bool) -> str:
    """Return the sentence that introduces the balance of moments of a body."""
    what = "The moments are in balance, all"
    if spinning:
        what = "The rate of the angular momentum [H] equals the resultant moment, both"
    moved = ""
    if cut.fixed:
        point = f"the joint {cut.joint.name}, a fixed point"
        if spinning and any(cut.center):
            moved = (
                " About it the moments of inertia are larger than about the center of mass, by "
                "the mass times the square of the distance of the two (Steiner)."
            )
    elif cut.mass:
        point = "its center of mass"
    else:
        point = f"the joint {cut.joint.name}; without mass any point serves"
    return f"{what} about {point}.{moved}{_RATES if turning else ''}"


def explain_guides(guides: Sequence[Guide]) -> str:
    """Explain which reactions the guides leave undetermined, and what S and C are."""
    reasons = "; ".join(guide.reason for guide in guides)
    return (
        f"{reasons[0].upper()}{reasons[1:]}. There the reactions by themselves are undetermined. S "
        "and C are the total force and moment across the joint, of reaction and guides together, "
        "on the child."
    )


def describe_reaction(cut: Cut, d: Direction, holder: str, *, guided: bool) -> str:
    """Describe a component of the reaction that a body or the ground exerts, with its unit."""
    at, body = call(cut.joint.name), call(cut.body)
    exerted = f"that {call(holder)} exerts on {body} in {at}"
    if guided:
        exerted = f"of reaction and guides together across {at} on {body}"
    if d.kind == "moment":
        about = "in the positive sense of moments"
        if d.label:
            about = f"about {d.label}{_say_whose(cut, d)}"
        return f"moment {exerted}, {about} [N·m]"
    where = f"along {d.label}{_say_whose(cut, d)}"
    if d.sign < 0:
        where = f"towards {at}"
    return f"force {exerted}, {where} [N]"


def _say_whose(cut: Cut, d: Direction) -> str:
    """Say whose axes x, y and z are, where the sentence about the axes does not."""
    return f" of {call(cut.axes.whose[d.kind])}" if d.label in _LABELS else ""
