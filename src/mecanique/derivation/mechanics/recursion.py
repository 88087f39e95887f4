"""The equations of motion of a tree, by recursion in the bodies' own axes.

τ = Σ tr(∂H/∂q J Ḧᵀ) with the poses H and the mass moments J of each body, written in the body's
axes: a point r of the body has the acceleration a + U r with U = α̂ + ω̂ ω̂. With mass m, first
moments h and second moments E about the body's origin, the rate of momentum is m a + U h, and its
moment is h × a plus the axial vector of U E (J. Y. S. Luh, M. W. Walker & R. P. C. Paul, J. Dynamic
Systems, Measurement, and Control 102 (1980) 69, in the form of W. Khalil & E. Dombre, Modeling,
Identification and Control of Robots, 2002, sect. 9.5).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, final

from mecanique.derivation.mechanics.chart import JointMotion, chart_of
from mecanique.derivation.mechanics.elements import Ground, ground_of
from mecanique.derivation.mechanics.letters import Letters
from mecanique.derivation.mechanics.vectors import (
    Rows,
    Triple,
    add,
    apply,
    apply_transpose,
    cross,
    dot,
    products,
    scale,
    transpose,
)
from mecanique.derivation.tolerances import WHOLE
from mecanique.derivation.tree.links import Link, links, place_of
from mecanique.derivation.tree.poses import IDENTITY, Matrix, local, moments, origin, product
from mecanique.program.tape import Value
from mecanique.program.traced import Traced, value_of


@final
@dataclass(frozen=True)
class Seat:
    """A frame fixed in a link of the tree."""

    place: int  # index of the moving link, −1 for the ground
    pose: Matrix  # pose of the frame in that link


@final
@dataclass(frozen=True)
class Wrench:
    """A force and a moment on a moving link.

    Args:
        place: index of the link.
        force: in the link's axes.
        moment: about the link's origin, in its axes.
    """

    place: int
    force: Triple
    moment: Triple


@final
@dataclass(frozen=True)
class Inertia:
    """Mass m, first moments h and second moments E of a body about its origin."""

    m: Any
    h: Triple
    E: Rows

    def __add__(self, other: Inertia) -> Inertia:
        E = [add(*rows) for rows in zip(self.E, other.E, strict=True)]
        return Inertia(self.m + other.m, add(self.h, other.h), E)

    def __sub__(self, other: Inertia) -> Inertia:
        E = [add(x, scale(-1.0, y)) for x, y in zip(self.E, other.E, strict=True)]
        return Inertia(self.m - other.m, add(self.h, scale(-1.0, other.h)), E)

    @property
    def is_number(self) -> bool:
        """Whether it contains numbers only."""
        entries = [self.m, *self.h, *self.E[0], *self.E[1], *self.E[2]]
        return all(isinstance(entry, (int, float)) for entry in entries)

    def seen_from(self, pose: Matrix) -> Inertia:
        """Refer the inertia to the frame in which the body has a pose: its axes and its origin."""
        p = [row[3] for row in pose]
        turned = apply(pose, self.h)
        RE = [apply(self.E, row[:3]) for row in pose]  # E is symmetric
        E: Rows = [[0.0] * 3 for _ in range(3)]
        for i in range(3):
            for k in range(i + 1):
                turned_E = dot(RE[i], pose[k][:3])
                E[i][k] = E[k][i] = (
                    turned_E + turned[i] * p[k] + p[i] * turned[k] + self.m * p[i] * p[k]
                )
        return Inertia(self.m, add(turned, scale(self.m, p)), E)


_AXES = ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0])
_STILL: Triple = [0.0, 0.0, 0.0]


@final
@dataclass(frozen=True)
class Moving:
    """A moving link: its pose in its parent's axes, and its unit motions in its own."""

    parent: int
    pose: Matrix
    angular: dict[int, Triple]
    linear: dict[int, Triple]
    armature: Any

    @property
    def columns(self) -> list[int]:
        """The indices of its joint velocities."""
        return [*self.linear, *self.angular]

    def relative(self, rates: Sequence[Any]) -> tuple[Triple, Triple]:
        """Return Σ S u, angular and linear."""
        w, v = _STILL, _STILL
        for k, axis in self.angular.items():
            w = add(w, scale(rates[k], axis))
        for k, axis in self.linear.items():
            v = add(v, scale(rates[k], axis))
        return w, v

    def project(self, force: Triple, moment: Triple) -> dict[int, Any]:
        """Return the power of a force and a moment in each unit motion, by velocity index."""
        found = {k: dot(axis, force) for k, axis in self.linear.items()}
        return found | {k: dot(axis, moment) for k, axis in self.angular.items()}

    def carry(self, force: Triple, moment: Triple) -> tuple[Triple, Triple]:
        """Refer a force and its moment to the parent's axes and origin."""
        turned = apply(self.pose, force)
        return turned, add(apply(self.pose, moment), cross([row[3] for row in self.pose], turned))


@final
class TreeRecursion:
    """Mass matrix, bias, inverse dynamics and energies of a tree."""

    def __init__(self, letters: Letters) -> None:
        self.letters = letters
        mechanism, values = letters.mechanism, letters.values
        tree = links(mechanism)
        self.chart: JointMotion = chart_of(letters, tree)
        self.seats: dict[str, Seat] = {mechanism.ground: Seat(-1, IDENTITY)}
        self.links: list[Moving] = []
        seats: list[Seat] = []
        stands: list[Matrix] = []
        column = 0
        for link in tree:
            before = seats[link.parent] if link.parent >= 0 else Seat(-1, IDENTITY)
            stand = _clean(origin(link.origin, values, letters.arithmetic))
            pose = _clean(product(before.pose, stand))
            if link.kind == "fixed":
                seats.append(Seat(before.place, pose))
            else:
                stands.append(pose)
                pose = product(pose, local(link, self.chart.r, letters.arithmetic))
                angular, linear = _motions(link, column)
                column += len(link.velocities)
                armature = letters.arithmetic(link.armature, values)
                self.links.append(Moving(before.place, pose, angular, linear, armature))
                seats.append(Seat(len(self.links) - 1, IDENTITY))
        self.seats |= {body: seats[k] for body, k in place_of(tree, mechanism).items() if k >= 0}
        self.inertias = [Inertia(0.0, _STILL, [[0.0] * 3] * 3) for _ in self.links]
        for body in mechanism.bodies:
            seat = self.seats[body.name]
            if seat.place >= 0:
                J = moments(body, values, letters.arithmetic)
                first, second = [row[3] for row in J[:3]], [row[:3] for row in J[:3]]
                own = Inertia(J[3][3], first, second)
                moved = own.seen_from(seat.pose)
                self.inertias[seat.place] = self.inertias[seat.place] + moved
        self._regroup(stands)
        self.found: dict[str, list[Triple]] = {}
        """The vectors of each link in the last recursion, by letter: w, alpha, a, then F and N."""
        self.gravity: Triple = [letters.arithmetic(g, values) for g in mechanism.gravity]

    def _regroup(self, stands: Sequence[Matrix]) -> None:
        """Move inertia that a joint does not displace, e.g. mass on a hinge's axis, to the parent.

        A turn about its axis n does not change a body's m, h·n and n·E n, nor a slide its E; with
        these moved to the parent, most bodies have no mass of their own and take fewer operations
        (M. Gautier & W. Khalil, IEEE Trans. Robotics and Automation 6 (1990) 368).
        """
        for place in range(len(self.links) - 1, -1, -1):
            link, body = self.links[place], self.inertias[place]
            if link.parent < 0 or len(link.columns) != 1 or not body.is_number:
                continue
            stand = stands[place]
            if link.linear:
                moved = Inertia(0.0, _STILL, body.E)
                stand = [[*row[:3], 0.0] for row in stand]
            else:
                (n,) = link.angular.values()
                second = dot(n, apply(body.E, n))
                moved = Inertia(body.m, scale(dot(n, body.h), n), [scale(second * c, n) for c in n])
            carried = moved.seen_from(stand)
            if carried.is_number:
                self.inertias[place] = body - moved
                self.inertias[link.parent] = self.inertias[link.parent] + carried

    def inverse_dynamics(self, a: Sequence[Any], outside: Sequence[Wrench] = ()) -> list[Any]:
        """Return M a + bias, minus the generalized forces of external wrenches; a (nv,)."""
        rates = self.chart.spread(a)
        return self.chart.project(self._forces(self.chart.u, rates, self.gravity, outside))

    def bias(self) -> list[Any]:
        """Return Coriolis, centrifugal and rheonomic inertia terms and gravity."""
        tau = self._forces(self.chart.u, self.chart.gamma, self.gravity)
        return self.chart.project(tau)

    def gravity_forces(self) -> list[Any]:
        """Return gravity's part of the bias."""
        still = [0.0] * len(self.chart.u)
        return self.chart.project(self._forces(still, still, self.gravity))

    def mass_matrix(self) -> Rows:
        """Return M."""
        size = len(self.chart.u)
        M: Rows = [[0.0] * size for _ in range(size)]
        beyond = list(self.inertias)
        for place in range(len(self.links) - 1, -1, -1):
            link, inertia = self.links[place], beyond[place]
            if link.parent >= 0:
                beyond[link.parent] = beyond[link.parent] + inertia.seen_from(link.pose)
            for k in link.columns:
                force, moment = _momentum(inertia, link.angular.get(k), link.linear.get(k))
                for j, entry in link.project(force, moment).items():
                    if j <= k:
                        M[j][k] = M[k][j] = entry
                at = place
                while self.links[at].parent >= 0:
                    force, moment = self.links[at].carry(force, moment)
                    at = self.links[at].parent
                    for j, entry in self.links[at].project(force, moment).items():
                        M[j][k] = M[k][j] = entry
                M[k][k] = M[k][k] + link.armature
        return self.chart.project_matrix(M)

    def energy(self) -> tuple[Any, Any]:
        """Return the kinetic energy, and the potential energy of gravity."""
        T: Any = 0.0
        V: Any = 0.0
        spins: list[Triple] = []
        speeds: list[Triple] = []
        falls: list[tuple[Triple, Any]] = []
        for link, body in zip(self.links, self.inertias, strict=True):
            p = [row[3] for row in link.pose]
            spin, speed = (
                (spins[link.parent], speeds[link.parent]) if link.parent >= 0 else (_STILL, _STILL)
            )
            fall, level = falls[link.parent] if link.parent >= 0 else (self.gravity, 0.0)
            angular, linear = link.relative(self.chart.u)
            w = add(apply_transpose(link.pose, spin), angular)
            v = add(apply_transpose(link.pose, add(speed, cross(spin, p))), linear)
            here = apply_transpose(link.pose, fall), level + dot(fall, p)
            spins.append(w)
            speeds.append(v)
            falls.append(here)
            E = body.E
            second = sum(
                (w[i] * w[i] * (E[(i + 1) % 3][(i + 1) % 3] + E[(i + 2) % 3][(i + 2) % 3]))
                for i in range(3)
            )
            mixed = w[0] * w[1] * E[0][1] + w[1] * w[2] * E[1][2] + w[0] * w[2] * E[0][2]
            double = body.m * dot(v, v) + second + 2.0 * dot(v, cross(w, body.h)) - 2.0 * mixed
            double = double + sum(link.armature * self.chart.u[k] ** 2 for k in link.columns)
            T = T + 0.5 * double
            V = V - body.m * here[1] - dot(here[0], body.h)
        return T, V

    def _forces(
        self,
        u: Sequence[Any],
        ud: Sequence[Any],
        gravity: Triple,
        outside: Sequence[Wrench] = (),
    ) -> list[Any]:
        """Return the joint forces for given joint accelerations and gravity, shape (nu,)."""
        spins: list[Triple] = []
        fields: list[tuple[Rows, Triple, Triple]] = []  # U, α and a of each link
        for link in self.links:
            p = [row[3] for row in link.pose]
            if link.parent >= 0:
                spin = apply_transpose(link.pose, spins[link.parent])
                U, alpha, a = fields[link.parent]
                alpha = apply_transpose(link.pose, alpha)
                a = apply_transpose(link.pose, add(a, apply(U, p)))
            else:
                spin, alpha = _STILL, _STILL
                a = apply_transpose(link.pose, [-g for g in gravity])
            angular, linear = link.relative(u)
            turning, sliding = link.relative(ud)
            a = add(a, sliding, scale(2.0, cross(spin, linear)), cross(angular, linear))
            alpha = add(alpha, turning, cross(spin, angular))
            w = add(spin, angular)
            spins.append(w)
            fields.append((_field(w, alpha), alpha, a))
        loads: list[tuple[Triple, Triple]] = []
        for (U, _, a), body in zip(fields, self.inertias, strict=True):
            UE = products(U, body.E)  # E is symmetric
            turned = [
                UE[2][1] - UE[1][2],
                UE[0][2] - UE[2][0],
                UE[1][0] - UE[0][1],
            ]
            F = add(scale(body.m, a), apply(U, body.h))
            N = add(turned, cross(body.h, a))
            loads.append((F, N))
        for wrench in outside:
            F, T = loads[wrench.place]
            less = scale(-1.0, wrench.force), scale(-1.0, wrench.moment)
            loads[wrench.place] = add(F, less[0]), add(T, less[1])
        tau: list[Any] = [0.0] * len(u)
        self.found = {"w": spins, "alpha": [field[1] for field in fields]}
        self.found |= {"a": [field[2] for field in fields]}
        for place in range(len(self.links) - 1, -1, -1):
            link = self.links[place]
            force, moment = loads[place]
            for k, entry in link.project(force, moment).items():
                tau[k] = entry + link.armature * ud[k]
            if link.parent >= 0:
                carried, about = link.carry(force, moment)
                F, T = loads[link.parent]
                loads[link.parent] = add(F, carried), add(T, about)
        self.found |= {"F": [load[0] for load in loads], "N": [load[1] for load in loads]}
        return tau

    @cached_property
    def poses(self) -> list[Matrix]:
        """The pose of each moving link in the world."""
        poses: list[Matrix] = []
        for link in self.links:
            poses.append(product(poses[link.parent], link.pose) if link.parent >= 0 else link.pose)
        return poses

    def pose(self, body: str) -> Matrix:
        """Return the pose of a body in the world."""
        seat = self.seats[body]
        return product(self.poses[seat.place], seat.pose) if seat.place >= 0 else seat.pose

    @cached_property
    def ground(self) -> Ground:
        """The poses of all bodies."""
        return ground_of(self.pose, self.chart.r, self.letters.arithmetic)


def _motions(link: Link, first: int) -> tuple[dict[int, Triple], dict[int, Triple]]:
    """Return the unit motions of a link, angular and linear, by velocity index."""
    axis = [float(c) for c in link.axis]
    match link.kind:
        case "turn":
            return {first: axis}, {}
        case "slide":
            return {}, {first: axis}
        case "ball":
            return {first + k: list(e) for k, e in enumerate(_AXES)}, {}
    return (
        {first + 3 + k: list(e) for k, e in enumerate(_AXES)},
        {first + k: list(e) for k, e in enumerate(_AXES)},
    )


def _field(w: Triple, alpha: Triple) -> Rows:
    """Return U = α̂ + ω̂ ω̂."""
    xx, yy, zz = (c * c for c in w)
    xy, yz, xz = w[0] * w[1], w[1] * w[2], w[0] * w[2]
    return [
        [-(yy + zz), xy - alpha[2], xz + alpha[1]],
        [xy + alpha[2], -(xx + zz), yz - alpha[0]],
        [xz - alpha[1], yz + alpha[0], -(xx + yy)],
    ]


def _momentum(
    inertia: Inertia, angular: Triple | None, linear: Triple | None
) -> tuple[Triple, Triple]:
    """Return the momentum of a unit motion, and its moment."""
    if linear is not None:
        return scale(inertia.m, linear), cross(inertia.h, linear)
    assert angular is not None
    E, trace = inertia.E, inertia.E[0][0] + inertia.E[1][1] + inertia.E[2][2]
    moment = [trace * x - y for x, y in zip(angular, apply(E, angular), strict=True)]
    return cross(angular, inertia.h), moment


def _clean(pose: Matrix) -> Matrix:
    """Remove rounding from a pose whose rotation is by right angles."""
    return [[*map(_whole, row[:3]), row[3]] for row in pose]


def _whole(entry: Any) -> Any:
    if isinstance(entry, float):
        for number in (0.0, 1.0, -1.0):
            if abs(entry - number) < WHOLE:
                return number
    return entry


@final
@dataclass(frozen=True)
class _Motion:
    """A moving link: origin p, ω, v, and α and a without generalized accelerations."""

    p: Triple
    w: Triple
    v: Triple
    alpha: Triple
    a: Triple
    # linear and angular direction of each of its own joint velocities
    columns: dict[int, tuple[Triple, Triple]]


_GROUND = _Motion(_STILL, _STILL, _STILL, _STILL, _STILL, {})


@final
class World:
    """Velocities of the bodies of a tree, and their rates without generalized accelerations."""

    def __init__(self, recursion: TreeRecursion) -> None:
        self._recursion = recursion
        self._motions: list[_Motion] = []
        chart = recursion.chart
        for link, pose in zip(recursion.links, recursion.poses, strict=True):
            before, p = self._of(link.parent), [row[3] for row in pose]
            r = add(p, scale(-1.0, before.p))

            def turn(vector: Triple, pose: Matrix = pose) -> Triple:
                return apply([row[:3] for row in pose], vector)

            (w, l), (spun, slid) = (
                tuple(map(turn, link.relative(rates))) for rates in (chart.u, chart.gamma)
            )
            swing = cross(before.w, r)
            self._motions.append(
                _Motion(
                    p,
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
                            turn(link.linear.get(k, _STILL)),
                            turn(link.angular.get(k, _STILL)),
                        )
                        for k in link.columns
                    },
                )
            )

    @cached_property
    def pose_rates(self) -> dict[int, Value]:
        """Rates of the entries of all poses by their place on the tape: v, and ω × the axes.

        They take fewer operations than derivatives of the products that poses are made of. An axis
        that a link shares with its parent has the parent's rate, in which the link's own turn about
        it is left out.
        """
        rates: dict[int, Value] = {}
        for motion, pose in zip(self._motions, self._recursion.poses, strict=True):
            *axes, p = transpose(pose)
            moved = [(p, motion.v), *((e, cross(motion.w, e)) for e in axes)]
            for vector, rate in moved:
                for entry, slope in zip(vector, rate, strict=True):
                    if isinstance(entry, Traced):
                        rates.setdefault(entry.place, value_of(slope))
        return rates

    def velocity(self, body: str, place: Triple) -> Triple:
        """Return the velocity of a body's point at a place."""
        motion = self._of(self._recursion.seats[body].place)
        return add(motion.v, cross(motion.w, add(place, scale(-1.0, motion.p))))

    def change(self, body: str, place: Triple, rate: Triple) -> Triple:
        """Return the rate of that velocity, while the place moves with a given velocity."""
        motion = self._of(self._recursion.seats[body].place)
        arm = add(place, scale(-1.0, motion.p))
        aside = add(rate, scale(-1.0, motion.v))
        return add(motion.a, cross(motion.alpha, arm), cross(motion.w, aside))

    def columns(self, body: str, place: Triple) -> dict[int, Triple]:
        """Return the derivatives of that velocity by each joint velocity, by index."""
        found, at = dict[int, Triple](), self._recursion.seats[body].place
        while at >= 0:
            motion = self._motions[at]
            arm = add(place, scale(-1.0, motion.p))
            for k, (slide, axis) in motion.columns.items():
                found[k] = add(slide, cross(axis, arm))
            at = self._recursion.links[at].parent
        return found

    def turns(self, body: str) -> dict[int, Triple]:
        """Return the derivatives of a body's angular velocity by each joint velocity, by index."""
        found, at = dict[int, Triple](), self._recursion.seats[body].place
        while at >= 0:
            found |= {k: axis for k, (_, axis) in self._motions[at].columns.items()}
            at = self._recursion.links[at].parent
        return found

    def jacobian(self, body: str) -> Rows:
        """Return a body's Jacobian: velocity of its origin, then angular, shape (6, nv)."""
        place = [row[3] for row in self._recursion.pose(body)]
        G, nothing = self._recursion.chart.G, [0.0] * len(self._recursion.letters.v)
        rows: Rows = []
        for columns in (self.columns(body, place), self.turns(body)):
            for axis in range(3):
                entries = [column[axis] for column in columns.values()]
                moved = transpose([G[k] for k in columns])
                rows.append([dot(entries, each) for each in moved] or nothing)
        return rows

    def _of(self, place: int) -> _Motion:
        return self._motions[place] if place >= 0 else _GROUND
