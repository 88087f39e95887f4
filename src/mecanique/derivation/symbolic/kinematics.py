"""Write poses, velocities and virtual displacements of a mechanism as series.

Velocities are written in the axes of the body's carrier: the world, or the body of the quaternion
joint that leads to it from the ground; in the axes of that body no quaternion appears.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from fractions import Fraction
from functools import cached_property, partial
from typing import Any, final

from mecanique.derivation.laws import Travel
from mecanique.derivation.mechanics.elements import Ground
from mecanique.derivation.mechanics.forces import Span
from mecanique.derivation.printing.expressions import size, to_formula
from mecanique.derivation.printing.formulas import MOVING, Letter, multiply, number
from mecanique.derivation.printing.writers import Expression
from mecanique.derivation.scalars.cancel import tidy
from mecanique.derivation.scalars.series import FOLLOWER, TIMED, Kind, Series
from mecanique.derivation.symbolic.derivation import Left, Result, Stage, list_components
from mecanique.derivation.symbolic.symbols import Algebra
from mecanique.derivation.symbolic.vectors import SymbolicWrench, Vector, along, lift, zero
from mecanique.derivation.tree.links import Link, links, place_of
from mecanique.derivation.tree.poses import (
    IDENTITY,
    Matrix,
    combination,
    local,
    moments,
    origin,
    plus,
    product,
    times_point,
    transpose,
)
from mecanique.errors import DerivationError
from mecanique.model.expression import Scalar
from mecanique.model.force_base import LineLoad
from mecanique.model.mechanism import Mechanism
from mecanique.model.mechanism.letters import call
from mecanique.wording import enumerate_words

ORIGIN = (0, 0, 0)
"""The origin of a body's frame."""


@final
class Kinematics:
    """The poses and velocities of all bodies as series."""

    def __init__(self, algebra: Algebra) -> None:
        self.algebra = algebra
        self.tree = links(algebra.mechanism)
        self.place = place_of(self.tree, algebra.mechanism)
        self._carriers: list[int] = []
        self._relative: list[Matrix] = []
        self._frames: dict[int, Matrix] = {-1: IDENTITY}
        self._carried: dict[int, list[Any]] = {}
        """Where joints with quaternions are on what carries them, in the world."""
        self.spans: dict[str, Span] = {}
        """The lines between the ends of the forces asked for, by the force's name."""
        values, arithmetic = algebra.values, algebra.arithmetic
        for place, link in enumerate(self.tree):
            parent = self._relative[link.parent] if link.parent >= 0 else IDENTITY
            carrier = self._of(link.parent)
            seat = product(parent, self.origin_of(link))
            pose = product(seat, local(link, values, arithmetic))
            if link.kind in ("ball", "free"):
                if carrier >= 0 or any(moves(entry) for row in parent for entry in row[:3]):
                    raise DerivationError(
                        f"joint {link.joint!r} turns by a quaternion on a body that turns; such "
                        "equations are computed, not written out: describe the joint by three "
                        "hinges to read them"
                    )
                self._frames[place] = pose
                self._carried[place] = [row[3] for row in seat]
                carrier, pose = place, IDENTITY
            self._carriers.append(carrier)
            self._relative.append(pose)

    @cached_property
    def ground(self) -> Ground:
        """The poses of bodies for laws that are written on scalars of any kind."""
        algebra = self.algebra
        return Ground(
            point=lambda body, point: [*self.point(body, point).tidy()],
            turn=lambda body: [row[:3] for row in self.pose(body)],
            tilt=lambda placement: [
                row[:3] for row in origin(placement, algebra.values, algebra.arithmetic)
            ],
            scalar=algebra.series,
            root=algebra.root,
            wave=lambda angle: algebra.arithmetic.sine_cosine(algebra.series(angle))[::-1],
            ratio=lambda a, b: _divide(algebra.lift(a), algebra.lift(b)),
            opposite=0.0,
        )

    def carrier(self, body: str) -> int:
        """Return the index of the link in whose axes a body is described, −1 for the world."""
        return self._of(self.place[body])

    def pose(self, body: str) -> Matrix:
        """Return the pose of a body in the world, three rows of four scalars."""
        place = self.place[body]
        if place < 0:
            return IDENTITY
        return product(self._frames[self._of(place)], self._relative[place])

    def point(self, body: str, place: Sequence[Scalar]) -> Vector:
        """Return a point of a body, given in its frame, in the world [m]."""
        return lift(self.algebra.ring, times_point(self.pose(body), self.components(place)))

    def rate(self, body: str) -> Matrix:
        """Return the rate of a body's pose in its carrier's axes, three rows of four scalars."""
        # With the carrier's angular velocity ω and velocity v in its own axes, and the body's pose
        # (K, p) in the carrier, it is (ω̂ K + K', v + ω̂ p + p')
        place = self.place[body]
        if place < 0:
            return [[0] * 4 for _ in range(3)]
        K, carrier = self._relative[place], self._of(place)
        change = [list(map(_ddt, row)) for row in K]
        if carrier < 0:
            return change
        carried = product(self._twist(carrier), K)
        return [list(map(plus, *rows)) for rows in zip(carried, change, strict=True)]

    def velocity(self, body: str, point: Sequence[Scalar] = ORIGIN) -> Vector:
        """Return the velocity of a point, given in the body's frame, in carrier axes [m/s]."""
        return lift(self.algebra.ring, times_point(self.rate(body), self.components(point)))

    def spin(self, body: str) -> Vector:
        """Return the angular velocity of a body in its carrier's axes [rad/s]."""
        place = self.place[body]
        if place < 0:
            return zero(self.algebra.ring)
        return self.turning(transpose(self.turn(place)), self._of(place))

    def turning(self, axes: Sequence[Sequence[Any]], carrier: int) -> Vector:
        """Return the angular velocity of axes, a row each, given like it in those of a carrier."""
        # from ω̂ = K' Kᵀ with the axes as the columns of K
        ring, turn = self.algebra.ring, transpose(axes)
        rate = transpose([[*self.change(lift(ring, axis), carrier)] for axis in axes])
        pairs = ((2, 1), (0, 2), (1, 0))
        return lift(ring, [combination(rate[i], turn[k]) for i, k in pairs])

    def twist(self, body: str) -> SymbolicWrench:
        """Return the velocity of a body's origin and its spin, in its carrier's axes."""
        return SymbolicWrench(self.velocity(body), self.spin(body))

    def vector(self, components: Sequence[Scalar | Fraction], axes: str, body: str) -> Vector:
        """Return a vector, given in the axes of a body or the "world", in a body's carrier's."""
        given = self.components(components)
        at = -1 if axes == "world" else self.place[axes]
        if at >= 0:
            given = [combination(row[:3], given) for row in self._relative[at]]
        return self.between(given, self._of(at), self.carrier(body))

    def between(self, components: Iterable[Any], start: int, end: int) -> Vector:
        """Return a vector in the axes of another carrier; −1 is the world."""
        given = list(components)
        if start != end:
            out, back = self._frames[start], [*zip(*self._frames[end], strict=True)][:3]
            given = [combination(row[:3], given) for row in out]
            given = [combination(column, given) for column in back]
        return lift(self.algebra.ring, given)

    @property
    def mechanism(self) -> Mechanism:
        """Whose kinematics they are."""
        return self.algebra.mechanism

    def number(self, scalar: Scalar, given: Mapping[str, Series] | None = None) -> Series:
        """Return a scalar of the description as a series; values of more letters may be given."""
        return self.algebra.series(scalar, given)

    def in_world(self, components: Sequence[Scalar | Fraction], axes: str) -> Vector:
        """Return a vector, given in the axes of a body or the "world", in the world's."""
        return self.vector(components, axes, self.mechanism.ground)

    def span(self, force: LineLoad) -> Span:
        """Return the line between the ends of a force, world axes."""
        if force.name not in self.spans:
            a, b = (self.point(end.body, end.point) for end in force.ends)
            self.spans[force.name] = Span(
                [*(b - a).tidy()],
                self.algebra.root,
                lambda span: tidy(span.x.ddt()),
                self.ground.ratio,
            )
        return self.spans[force.name]

    def travel(self, joint: str) -> Travel:
        """Return the coordinate of a joint, which a force acts along."""
        name = self.mechanism.joint(joint).coordinates[-1]
        x = self.algebra.lift(self.algebra.values[name])
        return Travel(x, tidy(x.ddt()), name)

    def components(
        self, given: Sequence[Scalar], values: Mapping[str, Any] | None = None
    ) -> list[Any]:
        """Return components of the description as series or plain numbers, as `number` does."""
        known = {**self.algebra.values, **values} if values else self.algebra.values
        return [self.algebra.arithmetic(c, known) for c in given]

    def change(self, vector: Vector, carrier: int) -> Vector:
        """Return the inertial rate of a vector, x' + ω × x, in the axes of its carrier."""
        rate = Vector(*(component.ddt() for component in vector))
        if carrier < 0:
            return rate
        turned = [combination(row[:3], vector) for row in self._twist(carrier)]
        return rate + lift(self.algebra.ring, turned)

    def seat(self, body: str) -> Vector:
        """Return the vector from the carrier's origin to a body's, in the carrier's axes."""
        return lift(self.algebra.ring, [row[3] for row in self._pose(self.place[body])])

    def turn(self, place: int) -> Matrix:
        """Return the axes of a link in those of its carrier, three rows of three scalars."""
        return [row[:3] for row in self._pose(place)]

    def turn_before(self, place: int) -> Matrix:
        """Return the axes of a link before its own joint turns it, in those of its carrier."""
        link = self.tree[place]
        return [row[:3] for row in product(self._pose(link.parent), self.origin_of(link))]

    def spin_axes(self, body: str) -> tuple[Matrix, str, bool]:
        """Return axes, a row each, in which a body's moments of inertia are those it is given."""
        # Its own or, about a hinge along an axis of symmetry, those that do not spin with it; also
        # return whose they are, and whether they are the latter
        place = self.place[body]
        link = self.tree[place]
        if link.kind != "turn" or not self._is_symmetric(body, link.axis):
            return transpose(self.turn(place)), self.name_axes(place), False
        axes = transpose(self.turn_before(place))
        if axes == transpose(self.turn(link.parent)):
            return axes, self.name_axes(link.parent), True
        return axes, f"the frame of joint {link.joint}", True

    def _is_symmetric(self, body: str, axis: Sequence[float]) -> bool:
        """Return whether a body's mass lies alike about an axis through its origin."""
        if sorted(map(abs, axis)) != [0, 0, 1]:
            return False
        J, k = self.moments(body), [*map(abs, axis)].index(1)
        i, j = (k + 1) % 3, (k + 2) % 3
        unlike = (J[i][i] - J[j][j], J[i][j], J[i][k], J[j][k], J[i][3], J[j][3])
        return all(self.algebra.lift(entry).vanishes() for entry in unlike)

    def name_axes(self, place: int) -> str:
        """Name the body whose axes a link's are, or the world."""
        if self.stands(place):
            return "the world"
        link = self.tree[place]
        return link.body or f"the link within {link.joint}"

    def origin_of(self, link: Link) -> Matrix:
        """Return the pose of a link's frame in its parent, before its own joint moves it."""
        return origin(link.origin, self.algebra.values, self.algebra.arithmetic)

    def axes(self, place: int, body: str) -> Matrix:
        """Return the axes of a link, a row each, in those of a body's carrier."""
        start, end = self._of(place), self.carrier(body)
        return [[*self.between(axis, start, end)] for axis in transpose(self.turn(place))]

    def stands(self, place: int) -> bool:
        """Return whether the axes of a link are those of the world."""
        return self._of(place) < 0 and self.turn(place) == [[*row[:3]] for row in IDENTITY]

    def moments(self, body: str) -> Matrix:
        """Return the mass moments of a body about its origin, four rows of four scalars."""
        algebra = self.algebra
        return moments(algebra.mechanism.body(body), algebra.values, algebra.arithmetic)

    @cached_property
    def bodies(self) -> tuple[str, ...]:
        """Names of the bodies that can move and have shapes."""
        described = self.algebra.mechanism.bodies
        return tuple(b.name for b in described if b.shapes and self.place[b.name] >= 0)

    def _pose(self, place: int) -> Matrix:
        """Return the pose of a link in its carrier."""
        return self._relative[place] if place >= 0 else IDENTITY

    def _of(self, place: int) -> int:
        return self._carriers[place] if place >= 0 else -1

    def _twist(self, carrier: int) -> Matrix:
        """Return the twist (ω̂, v) of a carrier in its own axes."""
        *linear, x, y, z = (self.algebra.values[name] for name in self.tree[carrier].velocities)
        carried = self._carried[carrier]
        if any(map(moves, carried)):  # what carries the joint moves without turning
            *axes, _ = zip(*self._frames[carrier], strict=True)
            rates = [*map(_ddt, carried)]
            pushed = [combination(axis, rates) for axis in axes]
            linear = [*map(plus, linear, pushed)] if linear else pushed
        u, v, w = linear or (0, 0, 0)
        return [[0, -z, y, u], [z, 0, -x, v], [-y, x, 0, w]]


def _divide(a: Series, b: Series) -> Series:
    """Return a quotient, exact where it is 0 or ±1."""
    a, b = tidy(a), tidy(b)
    if not a or a in (b, -b):
        size = 1 if a else 0
        return a.ring.number(size if a == b else -size)
    return tidy(a / b)


def moves(entry: Any) -> bool:
    """Return whether a scalar of a position changes."""
    return isinstance(entry, Series) and not entry.kinds.isdisjoint({Kind.COORDINATE, *TIMED})


def _ddt(entry: Any) -> Any:
    return entry.ddt() if isinstance(entry, Series) else 0


MOST_LISTED = 600
"""Positions and velocities are listed if they have at most this many terms in total."""


RELATIONS = "Kinematic relations"
"""Title of the step that states the coordinates which elements lead."""


def follow(algebra: Algebra) -> Iterator[tuple[str, Series]]:
    """Yield the joint coordinates that follow from others, each with its value."""
    ring = algebra.ring
    named = {
        ring.generators[index].name: atom.argument
        for index, atom in ring.atoms.items()
        if atom.function == FOLLOWER
    }
    for name in algebra.mechanism.coordinates.driven:
        yield name, named.get(name) or algebra.lift(algebra.values[name])


def relation_stages(algebra: Algebra) -> list[Stage]:
    """Return the step that states how cords, wheels and other elements lead coordinates."""
    mechanism = algebra.mechanism
    relations = [*follow(algebra)] if mechanism.elements else []
    if not relations:
        return []
    names = enumerate_words([call(element.name) for element in mechanism.elements])
    free = enumerate_words([*mechanism.coordinates])
    sentence = (
        f"Through {names}, the other coordinates depend on {free}. Differentiated, these relations "
        "give the velocities, and at fixed time the virtual displacements alike."
    )
    results, leaders = list[Result](), dict[Series, str]()
    for name, value in relations:
        value = tidy(value)
        same = next((x for x in (value, -value) if x in leaders), None)
        if same is not None and size(to_formula(value)) > 2:  # whose rate has been given
            leader = multiply(
                number(1 if same == value else -1), Letter(leaders[same], (MOVING, 0))
            )
            results.append(Result(Left(name), value, partial(Expression, (leader,))))
            continue
        leaders[value] = name
        results += [Result(Left(name), value), Result(Left(f"{name}'"), tidy(value.ddt()))]
    return [Stage(RELATIONS, sentence, tuple(results))]


def quaternion_stages(algebra: Algebra) -> list[Stage]:
    """Return the step that gives the rates of quaternions and positions by the velocities."""
    names = algebra.mechanism.coordinates
    free = [name for name in names if f"{name}'" not in algebra.velocities]
    if not free:
        return []
    sentence = (
        "The velocities of a body that rotates freely are components in its own axes. Its unit "
        "quaternion p has the rate p' = p w / 2, a product of quaternions with the angular "
        "velocity w, and the rate of its position is its velocity in the axes of the world."
    )
    for joint in algebra.mechanism.joints:
        if (
            joint.quaternion
            and joint.linear_velocities
            and joint.parent != algebra.mechanism.ground
        ):
            sentence += (
                f" Both are relative to {call(joint.parent)}, which carries {call(joint.child)}."
            )
    ring = algebra.ring
    results = tuple(Result(Left(f"{name}'"), ring.rates[ring.index(name)]) for name in free)
    return [Stage("Rates of the coordinates", sentence, results)]


def geometry_stages(kinematics: Kinematics) -> list[Stage]:
    """Return the step from the coordinates to the velocities of all bodies."""
    mechanism, results = kinematics.algebra.mechanism, list[Result]()
    massless = {body.name for body in mechanism.bodies if body.mass == 0}
    turns, turned = False, dict[str, list[str]]()
    for body in kinematics.bodies:
        given = mechanism.body(body)
        vectors = {}
        if given.mass != 0:
            vectors["r"] = kinematics.point(body, given.center)
            vectors["v"] = kinematics.velocity(body, given.center)
        if any(entry != 0 for entry in given.inertia):
            spin = kinematics.spin(body).tidy()
            axes, whose, fixed = kinematics.spin_axes(body)
            vectors["omega"] = along(axes, spin)
            turns |= any(spin)
            if vectors["omega"] != spin:
                bare = whose in massless
                others = "axes that do not" if bare else f"those of {call(whose)}, which do not"
                other = f"{others} spin with {call(body)}"
                turned.setdefault(other if fixed else "the body's own", []).append(body)
        for letter, vector in vectors.items():
            results += list_components(f"{letter}_{body}", "xyz", vector.tidy())
    if not results or sum(len(result.right) for result in results) > MOST_LISTED:
        return []
    sentence = (
        "The poses of the bodies as functions of the coordinates give the position [r] of each "
        "center of mass; its rate is the velocity [v]"
        + (", and the rates of the axes give the angular velocity omega" if turns else "")
        + ". Components along x, y and z of the world that are not listed are zero."
    )
    if any(joint.quaternion for joint in mechanism.joints):
        sentence += (
            " Velocities of a body that rotates freely, and of bodies it carries, are in its axes."
        )
    if turned:
        places = [
            f"for {enumerate_words([*map(call, names)])} along {axes}"
            for axes, names in turned.items()
        ]
        sentence += (
            " The components of omega are along axes in which the moments of inertia are those "
            f"listed: {'; '.join(places)}."
        )
    return [
        Stage(
            "Positions and velocities",
            kinematics.algebra.say(
                sentence,
                r=[f"r_{body}" for body in kinematics.bodies],
                v=[f"v_{body}" for body in kinematics.bodies],
            ),
            tuple(results),
        )
    ]
