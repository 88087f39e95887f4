"""The equations of motion of a tree, by recursion in the bodies' own axes.

τ = Σ tr(∂H/∂q J Ḧᵀ) with the poses H and the mass moments J of each body, written in the body's
axes: a point r of the body has the acceleration a + U r with U = α̂ + ω̂ ω̂. With mass m, first
moments h and second moments E about the body's origin, the rate of momentum is m a + U h, and its
moment is h × a plus the axial vector of U E (J. Y. S. Luh, M. W. Walker & R. P. C. Paul, J. Dynamic
Systems, Measurement, and Control 102 (1980) 69, in the form of W. Khalil & E. Dombre, Modeling,
Identification and Control of Robots, 2002, sect. 9.5).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple, TypeAlias, final

import numpy as np

from mecanique.derivation.mechanics.chart import CoordinateMap, JointMotion
from mecanique.derivation.mechanics.elements import Ground, ground_of
from mecanique.derivation.mechanics.letters import Letters, LetterValues
from mecanique.derivation.mechanics.vectors import (
    STILL,
    Column,
    Rows,
    Triple,
    acceleration_field,
    add,
    add_rows,
    apply,
    apply_transpose,
    as_array,
    axial,
    bundle,
    cross,
    dot,
    mirror,
    position,
    product,
    products,
    rotation,
    scale,
    symmetric_products,
    times_point,
    transpose,
    turned_pose,
    turning_energy,
    turning_momentum,
    zeros,
)
from mecanique.derivation.tolerances import WHOLE
from mecanique.derivation.tree.links import Link, links, place_of, unit_motions
from mecanique.derivation.tree.poses import (
    IDENTITY,
    Arithmetic,
    local,
    moments,
    origin,
    turn_by,
)
from mecanique.model.mechanism import Mechanism
from mecanique.program.tape import Value
from mecanique.program.traced import Traced, value_of


@final
@dataclass(frozen=True)
class Seat:
    """A frame fixed in a link of the tree."""

    place: int  # index of the moving link, −1 for the ground
    pose: Rows  # pose of the frame in that link


@final
@dataclass(frozen=True)
class LinkWrench:
    """A force and a moment on a moving link."""

    place: int  # index of the link
    force: Triple  # in the link's axes
    moment: Triple  # about the link's origin, in its axes


@final
@dataclass(frozen=True)
class MassMoments:
    """Mass m, first moments h and second moments E of a body about its origin."""

    m: Any
    h: Triple
    E: Rows

    def __add__(self, other: MassMoments) -> MassMoments:
        if self is MASSLESS:
            return other
        if other is MASSLESS:
            return self
        E = add_rows(self.E, other.E)
        return MassMoments(self.m + other.m, add(self.h, other.h), E)

    def __sub__(self, other: MassMoments) -> MassMoments:
        E = [add(x, scale(-1.0, y)) for x, y in zip(self.E, other.E, strict=True)]
        return MassMoments(self.m - other.m, add(self.h, scale(-1.0, other.h)), E)

    @property
    def is_number(self) -> bool:
        """Whether it contains numbers only."""
        entries = [self.m, *self.h, *self.E[0], *self.E[1], *self.E[2]]
        return all(isinstance(entry, (int, float)) for entry in entries)

    def seen_from(self, pose: Rows) -> MassMoments:
        """Refer the inertia to the frame in which the body has a pose: its axes and its origin."""
        if self is MASSLESS:
            return self
        p, R = position(pose), rotation(pose)
        turned = apply(R, self.h)
        h = add(turned, scale(self.m, p))
        # R E Rᵀ + (R h) pᵀ + p h'ᵀ with the new first moments h' = R h + m p
        E = symmetric_products((products(R, self.E), R), (turned, p), (p, h))
        return MassMoments(self.m, h, E)


MASSLESS = MassMoments(0.0, STILL, [STILL, STILL, STILL])
"""The inertia of a link without bodies."""


@final
@dataclass(frozen=True)
class Moving:
    """A moving link of a tree, with its unit motions in its own axes; fixed links belong to it."""

    link: Link  # its elementary motion
    parent: int  # index of its parent among the moving links, −1 for the ground
    stand: Rows  # pose of the frame in which it moves, in its parent's axes
    linear: dict[int, Triple]  # its unit slides, by index of the joint velocity
    angular: dict[int, Triple]  # the same of its turns
    armature: Any  # inertia of its rotor
    # how its pose on arrays depends on the joint's motion: the constant part, then the factor of x
    # in a slide, of sine and cosine in a turn
    path: Sequence[np.ndarray] = ()
    pose: Rows = ()  # in its parent's axes, at the states of a recursion

    @property
    def columns(self) -> list[int]:
        """The indices of its joint velocities."""
        return [*self.linear, *self.angular]

    def over(self, force: Triple, moment: Triple) -> Moving:
        """Return the link as it acts on these vectors, which may be bundles of several."""
        if getattr(force, "ndim", 0) < 3 and getattr(moment, "ndim", 0) < 3:
            return self
        wide = (slice(None), None)
        return replace(
            self,
            pose=self.pose[:, :, None],
            angular={k: axis[wide] for k, axis in self.angular.items()},
            linear={k: axis[wide] for k, axis in self.linear.items()},
        )

    def relative(self, rates: Sequence[Any]) -> tuple[Triple, Triple]:
        """Return Σ S u, angular and linear."""
        w, v = STILL, STILL
        for k, axis in self.angular.items():
            w = add(w, scale(rates[k], axis))
        for k, axis in self.linear.items():
            v = add(v, scale(rates[k], axis))
        return w, v

    def project(self, force: Triple, moment: Triple) -> dict[int, Any]:
        """Return the power of a force and a moment in each unit motion, by velocity index."""
        powers = {k: dot(axis, force) for k, axis in self.linear.items()}
        return powers | {k: dot(axis, moment) for k, axis in self.angular.items()}

    def carry(self, force: Triple, moment: Triple) -> tuple[Triple, Triple]:
        """Refer a force and its moment to the parent's axes and origin."""
        turned = apply(self.pose, force)
        return turned, add(apply(self.pose, moment), cross(position(self.pose), turned))


@final
@dataclass(frozen=True)
class Skeleton:
    """A tree's moving links, the same in every state; fixed links belong to their parents."""

    moving: list[Moving]  # each after its parent
    inertias: list[MassMoments]  # inertia of each one with all that is fixed to it
    seats: list[Seat]  # the frame of each elementary link of the tree, moving or not
    bodies: dict[str, Seat]  # the frame of each body
    gravity: Triple  # acceleration of gravity


class Numbers(NamedTuple):
    """The numbers of a tree in some arithmetic: lists of scalars, or arrays of many states."""

    origins: Sequence[Rows]  # pose of each elementary link's frame in its parent's
    moments: Mapping[int, Rows]  # mass moments ∫ (p, 1)(p, 1)ᵀ dm of each link that has a body
    armatures: Sequence[Any]  # inertia of each link's rotor
    gravity: Triple  # acceleration of gravity
    identity: Rows  # the pose of the ground
    axis: Callable[[Sequence[float]], Triple]  # converts a constant vector
    turns: Mapping[int, Rows]  # rotation of each link's axes in its frame, where that is varied


def skeleton_of(mechanism: Mechanism, tree: Sequence[Link], numbers: Numbers) -> Skeleton:
    """Return the moving links of a tree."""
    ground = Seat(-1, numbers.identity)
    seats: list[Seat] = []
    moving: list[Moving] = []
    column = 0
    for k, (link, pose) in enumerate(zip(tree, numbers.origins, strict=True)):
        before = seats[link.parent] if link.parent >= 0 else ground
        if before.pose is not numbers.identity:
            pose = _clean(product(before.pose, pose))
        if link.kind == "fixed":
            seats.append(Seat(before.place, pose))
            continue
        turn = numbers.turns.get(k)
        motions: tuple[dict[int, Triple], dict[int, Triple]] = {}, {}
        for both in unit_motions(link):
            for axes, axis in zip(motions, both, strict=True):
                if any(axis):
                    own = numbers.axis(axis)
                    axes[column] = own if turn is None else apply(turn, own)
            column += 1
        path = _path(link, pose, turn)
        armature = numbers.armatures[k]
        moving.append(Moving(link, before.place, pose, *motions, armature, path))
        seats.append(Seat(len(moving) - 1, numbers.identity))
    inertias = [MASSLESS for _ in moving]
    for k, J in numbers.moments.items():
        seat = seats[k]
        if seat.place < 0:
            continue
        body = MassMoments(J[3][3], position(J[:3]), rotation(J[:3]))
        # on a tape even the identity serves: E is symmetric up to rounding, then exactly, for which
        # fewer operations do
        if seat.pose is not numbers.identity or not isinstance(J, np.ndarray):
            body = body.seen_from(seat.pose)
        inertias[seat.place] = inertias[seat.place] + body
    bodies = {body: seats[k] for body, k in place_of(tuple(tree), mechanism).items() if k >= 0}
    return Skeleton(moving, inertias, seats, {mechanism.ground: ground, **bodies}, numbers.gravity)


def _path(link: Link, stand: Rows, turn: np.ndarray | None) -> list[np.ndarray]:
    """Return the constant part of a link's pose, and its derivatives by x or by sine and cosine."""
    if not isinstance(stand, np.ndarray) or link.kind not in ("turn", "slide"):
        return []
    # The law of a turn is linear in sine and cosine, so three values of it give its coefficients
    floats, name = Arithmetic(), "".join(link.coordinates)
    if link.kind == "slide":
        poses = as_array(local(link, {name: np.array([0.0, 1.0])}, floats), 2)
    else:
        sine, cosine = np.eye(3)[1:]
        poses = as_array(turn_by(link.axis, sine, cosine, floats), 3)
    poses = poses[..., None, :]  # the values last, after the states
    if turn is not None:
        poses = turned_pose(turn[..., None], poses)
    first, *others = np.moveaxis(product(stand[..., None], poses), -1, 0)
    return [first, *(pose - first for pose in others)]


def skeleton_on_tape(letters: Letters) -> Skeleton:
    """Return the moving links of a tree in scalars of a tape, with as few masses as possible."""
    mechanism, values, arithmetic = letters.mechanism, letters.values, letters.arithmetic
    tree = links(mechanism)
    place = place_of(tree, mechanism)
    numbers = Numbers(
        origins=[_clean(origin(link.origin, values, arithmetic)) for link in tree],
        moments={
            place[body.name]: moments(body, values, arithmetic)
            for body in mechanism.bodies
            if place[body.name] >= 0
        },
        armatures=[arithmetic(link.armature, values) for link in tree],
        gravity=[arithmetic(g, values) for g in mechanism.gravity],
        identity=IDENTITY,
        axis=lambda axis: [float(c) for c in axis],
        turns={},
    )
    skeleton = skeleton_of(mechanism, tree, numbers)
    _regroup(skeleton)
    return skeleton


def _regroup(tree: Skeleton) -> None:
    """Move inertia that a joint does not displace, e.g. mass on a hinge's axis, to the parent."""
    # A turn about its axis n does not change a body's m, h·n and n·E n, nor a slide its E; with
    # these moved to the parent, most bodies have no mass of their own and take fewer operations (M.
    # Gautier & W. Khalil, IEEE Trans. Robotics and Automation 6 (1990) 368).
    for place, link in reversed([*enumerate(tree.moving)]):
        body, stand, parent = tree.inertias[place], link.stand, link.parent
        if parent < 0 or len(link.columns) != 1 or not body.is_number:
            continue
        if link.linear:
            moved = MassMoments(0.0, STILL, body.E)
            stand = [[*row[:3], 0.0] for row in stand]
        else:
            (n,) = link.angular.values()
            second = dot(n, apply(body.E, n))
            moved = MassMoments(body.m, scale(dot(n, body.h), n), [scale(second * c, n) for c in n])
        carried = moved.seen_from(stand)
        if carried.is_number:
            tree.inertias[place] = body - moved
            tree.inertias[parent] = tree.inertias[parent] + carried


Field: TypeAlias = "tuple[Triple, Rows, Triple, Triple]"
"""ω, U, α and a of a link."""


@final
class TreeRecursion:
    """Mass matrix, inverse dynamics and energies of a tree, on a tape or on arrays."""

    def __init__(self, letters: LetterValues, skeleton: Skeleton, chart: JointMotion) -> None:
        self.letters = letters
        self.chart = chart
        self.skeleton = skeleton
        self.seats, self.inertias = skeleton.bodies, skeleton.inertias
        self.gravity = skeleton.gravity
        self.vectors: dict[str, Sequence[Triple]] = {}
        """The vectors of each link in the last recursion, omega, alpha and a, then F and N."""

    @cached_property
    def links(self) -> list[Moving]:
        """The moving links, each after its parent."""
        return [replace(link, pose=self._local(link)) for link in self.skeleton.moving]

    def _local(self, moving: Moving) -> Rows:
        """Return the pose of a link in its parent's axes."""
        chart, link = self.chart, moving.link
        if not moving.path:
            moved: Rows = local(link, chart.r, self.letters.arithmetic)
            if isinstance(moving.stand, np.ndarray):
                moved = as_array(moved, len(chart.u[0]))
            return product(moving.stand, moved)
        pose, *slopes = moving.path
        x = chart.r[link.coordinates[0]]
        factors = [x] if link.kind == "slide" else [np.sin(x), np.cos(x)]
        for factor, slope in zip(factors, slopes, strict=True):
            pose = pose + factor * slope
        return pose

    def inverse_dynamics(self, a: Sequence[Any], outside: Sequence[LinkWrench] = ()) -> Triple:
        """Return M a + bias, minus the generalized forces of external wrenches; a (nv,)."""
        return self.chart.project(self.joint_forces(self.chart.u, self.chart.spread(a), outside))

    def bias(self) -> Triple:
        """Return Coriolis, centrifugal and rheonomic inertia terms and gravity."""
        return self.chart.project(self.joint_forces(self.chart.u, self.chart.gamma))

    def gravity_forces(self) -> Triple:
        """Return gravity's part of the bias."""
        still = [0.0] * len(self.chart.u)
        return self.chart.project(self.joint_forces(still, still))

    def mass_matrix(self) -> Rows:
        """Return M."""
        return self.chart.project_matrix(self.joint_mass_matrix())

    def joint_mass_matrix(self) -> Rows:
        """Return M in the joint velocities, shape (nu, nu)."""
        M = zeros(self.chart.u)
        beyond = list(self.inertias)
        # momenta of the velocities beyond each link, and their moments about its origin
        momenta: list[list[Column]] = [[] for _ in self.links]
        for place in range(len(self.links) - 1, -1, -1):
            link, inertia = self.links[place], beyond[place]
            if link.parent >= 0:
                beyond[link.parent] = beyond[link.parent] + inertia.seen_from(link.pose)
            for k in link.columns:
                column = _momentum(inertia, link.angular.get(k), link.linear.get(k))
                momenta[place].append((k, *column))
            for k, force, moment in bundle(momenta[place]):
                several = link.over(force, moment)
                for j, entry in several.project(force, moment).items():
                    M[j][k] = entry
                if link.parent >= 0:
                    momenta[link.parent].append((k, *several.carry(force, moment)))
        mirror(M)
        for link in self.links:
            for k in link.columns:
                M[k][k] = M[k][k] + link.armature
        return M

    def energy(self) -> tuple[Any, Any]:
        """Return the kinetic energy, and the potential energy of gravity."""
        T: Any = 0.0
        V: Any = 0.0
        falls: list[tuple[Triple, Any]] = []
        for link, body, (w, v) in zip(self.links, self.inertias, self.velocities, strict=True):
            fall, level = falls[link.parent] if link.parent >= 0 else (self.gravity, 0.0)
            g = apply_transpose(link.pose, fall)
            level = level + dot(fall, position(link.pose))
            falls.append((g, level))
            for k in link.columns:
                T = T + 0.5 * (link.armature * self.chart.u[k] ** 2)
            if body is not MASSLESS:
                sliding = body.m * dot(v, v)
                T = T + 0.5 * (sliding + turning_energy(w, body.E, dot(v, cross(w, body.h))))
                V = V - body.m * level - dot(g, body.h)
        return T, V

    def momentum(self) -> tuple[Triple, Triple, Triple]:
        """Return the momenta, linear, angular about the origin and about the center of mass."""
        linear, angular, first = STILL, STILL, STILL
        mass: Any = 0.0
        for pose, body, (w, v) in zip(self.poses, self.inertias, self.velocities, strict=True):
            if body is MASSLESS:
                continue
            p = position(pose)
            push = add(scale(body.m, v), cross(w, body.h))
            spin = add(cross(body.h, v), turning_momentum(w, body.E))
            push = apply(pose, push)
            linear = add(linear, push)
            angular = add(angular, apply(pose, spin), cross(p, push))
            first = add(first, scale(body.m, p), apply(pose, body.h))
            mass = mass + body.m
        center = scale(1.0 / mass, first) if first is not STILL else STILL
        return linear, angular, add(angular, scale(-1.0, cross(center, linear)))

    @cached_property
    def velocities(self) -> list[tuple[Triple, Triple]]:
        """ω of each moving link and v of its origin, in its axes."""
        twists: list[tuple[Triple, Triple]] = []
        for link in self.links:
            spin, speed = twists[link.parent] if link.parent >= 0 else (STILL, STILL)
            angular, linear = link.relative(self.chart.u)
            carried = add(speed, cross(spin, position(link.pose)))
            w = add(apply_transpose(link.pose, spin), angular)
            v = add(apply_transpose(link.pose, carried), linear)
            twists.append((w, v))
        return twists

    def fields(self, u: Sequence[Any], ud: Sequence[Any]) -> list[Field]:
        """Return ω, U, α and a of each moving link; gravity accelerates the ground."""
        link_fields: list[Field] = []
        for link in self.links:
            p = position(link.pose)
            if link.parent >= 0:
                spin, U, alpha, a = link_fields[link.parent]
                spin = apply_transpose(link.pose, spin)
                alpha = apply_transpose(link.pose, alpha)
                a = apply_transpose(link.pose, add(a, apply(U, p)))
            else:
                spin, alpha = STILL, STILL
                a = apply_transpose(link.pose, scale(-1.0, self.gravity))
            angular, linear = link.relative(u)
            turning, sliding = link.relative(ud)
            a = add(a, sliding, scale(2.0, cross(spin, linear)), cross(angular, linear))
            alpha = add(alpha, turning, cross(spin, angular))
            w = add(spin, angular)
            link_fields.append((w, acceleration_field(w, alpha), alpha, a))
        return link_fields

    def joint_forces(
        self, u: Sequence[Any], ud: Sequence[Any], outside: Sequence[LinkWrench] = ()
    ) -> list[Any]:
        """Return the joint forces at joint velocities and accelerations, shape (nu,)."""
        fields = self.fields(u, ud)
        loads: list[tuple[Triple, Triple]] = []
        for (_, U, _, a), body in zip(fields, self.inertias, strict=True):
            if body is MASSLESS:
                loads.append((STILL, STILL))
                continue
            F = add(scale(body.m, a), apply(U, body.h))
            N = add(axial(U, body.E), cross(body.h, a))
            loads.append((F, N))
        for wrench in outside:
            F, N = loads[wrench.place]
            F = add(F, scale(-1.0, wrench.force))
            N = add(N, scale(-1.0, wrench.moment))
            loads[wrench.place] = F, N
        tau = self.collect(loads)
        for link in self.links:
            for k in link.columns:
                tau[k] = tau[k] + link.armature * ud[k]
        w, _, alpha, a = zip(*fields, strict=True) if fields else ((), (), (), ())
        F, N = zip(*loads, strict=True) if loads else ((), ())
        self.vectors = {"omega": w, "alpha": alpha, "a": a, "F": F, "N": N}
        return tau

    def collect(self, loads: list[tuple[Triple, Triple]]) -> list[Any]:
        """Return the joint forces of forces and moments on all links, summed from the tips."""
        # They are in the links' axes, about the links' origins; to each, those beyond are added
        tau: list[Any] = [0.0] * len(self.chart.u)
        for place in range(len(self.links) - 1, -1, -1):
            link = self.links[place]
            force, moment = loads[place]
            for k, entry in link.project(force, moment).items():
                tau[k] = entry
            if link.parent >= 0:
                carried, about = link.carry(force, moment)
                F, N = loads[link.parent]
                loads[link.parent] = add(F, carried), add(N, about)
        return tau

    @cached_property
    def poses(self) -> list[Rows]:
        """The pose of each moving link in the world."""
        poses: list[Rows] = []
        for link in self.links:
            poses.append(product(poses[link.parent], link.pose) if link.parent >= 0 else link.pose)
        return poses

    def pose(self, body: str) -> Rows:
        """Return the pose of a body in the world."""
        return self.pose_of(self.seats[body])

    def parent(self, place: int) -> int:
        """Return the index of a link's parent, −1 for the ground."""
        return self.skeleton.moving[place].parent

    def link_pose(self, place: int) -> Rows:
        """Return the pose of a link, or of the ground, in the world."""
        return self.poses[place] if place >= 0 else self.seats[self.letters.mechanism.ground].pose

    def pose_of(self, seat: Seat) -> Rows:
        """Return the pose of a frame in the world."""
        return product(self.poses[seat.place], seat.pose) if seat.place >= 0 else seat.pose

    def velocity(self, body: str, point: Triple) -> Triple:
        """Return the velocity of a point of a body, given in the body's axes, in the world."""
        seat = self.seats[body]
        if seat.place < 0:
            return STILL
        w, v = self.velocities[seat.place]
        moved = add(v, cross(w, times_point(seat.pose, point)))
        return apply(self.poses[seat.place], moved)

    def on_link(self, body: str, point: Triple, force: Triple, moment: Triple) -> LinkWrench:
        """Refer a force at a point of a body, in its axes, and a moment to the body's link."""
        # Force and moment are in the world's axes
        seat = self.seats[body]
        if seat.place < 0:
            return LinkWrench(-1, STILL, STILL)
        pose = self.poses[seat.place]
        turned = apply_transpose(pose, force)
        # by the arm in the link: differences of places in the world lose digits far from its origin
        arm = times_point(seat.pose, point)
        about = add(apply_transpose(pose, moment), cross(arm, turned))
        return LinkWrench(seat.place, turned, about)

    @cached_property
    def ground(self) -> Ground:
        """The poses of all bodies."""
        return ground_of(self.pose, self.chart.r, self.letters.arithmetic)


def recursion_on_tape(letters: Letters) -> TreeRecursion:
    """Return the recursion of a mechanism's tree on a tape."""
    mechanism = letters.mechanism
    chart = CoordinateMap(mechanism, links(mechanism)).at(letters)
    return TreeRecursion(letters, skeleton_on_tape(letters), chart)


def _momentum(
    inertia: MassMoments, angular: Triple | None, linear: Triple | None
) -> tuple[Triple, Triple]:
    """Return the momentum of a unit motion, and its moment."""
    if linear is not None:
        return scale(inertia.m, linear), cross(inertia.h, linear)
    assert angular is not None
    return cross(angular, inertia.h), turning_momentum(angular, inertia.E)


def _clean(pose: Rows) -> Rows:
    """Remove rounding from a pose whose rotation is by right angles, unless it is of arrays."""
    if isinstance(pose, np.ndarray):
        return pose
    return [[*map(_whole, row[:3]), row[3]] for row in pose]


def _whole(entry: Any) -> Any:
    if isinstance(entry, float):
        for number in (0.0, 1.0, -1.0):
            if abs(entry - number) < WHOLE:
                return number
    return entry


@final
@dataclass(frozen=True)
class LinkMotion:
    """A moving link: its origin p, ω, v, and α and a without generalized accelerations."""

    p: Triple
    step: Triple  # from its parent's origin to its own
    w: Triple
    v: Triple
    alpha: Triple
    a: Triple
    # linear and angular direction of each of its own joint velocities
    columns: dict[int, tuple[Triple, Triple]]


_GROUND = LinkMotion(STILL, STILL, STILL, STILL, STILL, STILL, {})


@final
class World:
    """Velocities of the bodies of a tree, and their rates without generalized accelerations."""

    def __init__(self, recursion: TreeRecursion) -> None:
        self._recursion = recursion
        self._motions: list[LinkMotion] = []
        chart = recursion.chart
        for link, pose in zip(recursion.links, recursion.poses, strict=True):
            before, p = self.motion(link.parent), position(pose)
            r = self._step(link)

            def turn(vector: Triple, pose: Rows = pose) -> Triple:
                return apply(pose, vector)

            (w, l), (spun, slid) = (
                tuple(map(turn, link.relative(rates))) for rates in (chart.u, chart.gamma)
            )
            swing = cross(before.w, r)
            self._motions.append(
                LinkMotion(
                    p,
                    r,
                    add(before.w, w),
                    add(before.v, swing, l),
                    add(before.alpha, spun, cross(before.w, w)),
                    add(
                        before.a,
                        cross(before.alpha, r),
                        cross(before.w, swing),
                        slid,
                        scale(2.0, cross(before.w, l)),
                        cross(w, l),
                    ),
                    {
                        k: (
                            turn(link.linear.get(k, STILL)),
                            turn(link.angular.get(k, STILL)),
                        )
                        for k in link.columns
                    },
                )
            )

    @cached_property
    def pose_rates(self) -> dict[int, Value]:
        """Rates of the entries of all poses by their place on the tape: v, and ω × the axes."""
        # They take fewer operations than derivatives of the products that poses are made of. An
        # axis that a link shares with its parent has the parent's rate, in which the link's own
        # turn about it is left out.
        rates: dict[int, Value] = {}
        for motion, pose in zip(self._motions, self._recursion.poses, strict=True):
            *axes, p = transpose(pose)
            moved = [(p, motion.v), *((e, cross(motion.w, e)) for e in axes)]
            for vector, rate in moved:
                for entry, slope in zip(vector, rate, strict=True):
                    if isinstance(entry, Traced):
                        rates.setdefault(entry.place, value_of(slope))
        return rates

    def motion(self, place: int) -> LinkMotion:
        """Return the motion of a link, or of the ground."""
        return self._motions[place] if place >= 0 else _GROUND

    def velocity(self, body: str, place: Triple) -> Triple:
        """Return the velocity of a body's point at a place."""
        motion = self.motion(self._recursion.seats[body].place)
        return add(motion.v, cross(motion.w, add(place, scale(-1.0, motion.p))))

    def change(self, body: str, place: Triple, rate: Triple) -> Triple:
        """Return the rate of that velocity, while the place moves with a given velocity."""
        motion = self.motion(self._recursion.seats[body].place)
        arm = add(place, scale(-1.0, motion.p))
        aside = add(rate, scale(-1.0, motion.v))
        return add(motion.a, cross(motion.alpha, arm), cross(motion.w, aside))

    def columns(self, body: str, place: Triple) -> dict[int, Triple]:
        """Return the derivatives of that velocity by each joint velocity, by index."""
        slopes = dict[int, Triple]()
        for motion in self._carriers(body):
            arm = add(place, scale(-1.0, motion.p))
            for k, (slide, axis) in motion.columns.items():
                slopes[k] = add(slide, cross(axis, arm))
        return slopes

    def turns(self, body: str) -> dict[int, Triple]:
        """Return the derivatives of a body's angular velocity by each joint velocity, by index."""
        columns = [motion.columns for motion in self._carriers(body)]
        return {k: axis for moved in columns for k, (_, axis) in moved.items()}

    def _carriers(self, body: str) -> Iterator[LinkMotion]:
        """Yield the motions of the links that move a body, from its own to the root."""
        at = self._recursion.seats[body].place
        while at >= 0:
            yield self._motions[at]
            at = self._recursion.links[at].parent

    def jacobian(self, body: str) -> Rows:
        """Return a body's Jacobian: velocity of its origin, then angular, shape (6, nv)."""
        place = position(self._recursion.pose(body))
        G, nothing = self._recursion.chart.G, [0.0] * self._recursion.letters.mechanism.nv
        rows: Rows = []
        for columns in (self.columns(body, place), self.turns(body)):
            for axis in range(3):
                entries = [column[axis] for column in columns.values()]
                moved = transpose([G[k] for k in columns])
                rows.append([dot(entries, generalized) for generalized in moved] or nothing)
        return rows

    def _step(self, link: Moving) -> Triple:
        """Return the vector from the parent's origin; a difference of positions loses digits."""
        p = position(link.pose)
        return apply(self._recursion.poses[link.parent], p) if link.parent >= 0 else p
