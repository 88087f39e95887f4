"""Write the velocities and accelerations of a tree's bodies on a tape, in world axes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

from mecanique.derivation.tree.poses import Matrix
from mecanique.generation.mechanics.recursion import Recursion
from mecanique.generation.mechanics.vectors import (
    Rows,
    Triple,
    add,
    apply,
    cross,
    dot,
    scale,
    transpose,
)

_STILL: Triple = [0.0, 0.0, 0.0]


@final
@dataclass(frozen=True)
class _Motion:
    """A moving link: origin p, ω, v, and α and a without generalized accelerations.

    Args:
        columns: linear and angular direction of each of its own joint velocities.
    """

    p: Triple
    w: Triple
    v: Triple
    alpha: Triple
    a: Triple
    columns: dict[int, tuple[Triple, Triple]]


_GROUND = _Motion(_STILL, _STILL, _STILL, _STILL, _STILL, {})


@final
class World:
    """Velocities of the bodies of a tree, and their rates without generalized accelerations.

    Args:
        recursion: the recursion over the bodies.
    """

    def __init__(self, recursion: Recursion) -> None:
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

    def pose(self, body: str) -> Matrix:
        """Return the pose of a body."""
        return self._recursion.pose(body)

    def moves(self, body: str) -> bool:
        """Return whether a body is not fixed to the ground."""
        return self._recursion.seats[body].place >= 0

    def spin(self, body: str) -> Triple:
        """Return the angular velocity of a body."""
        return self._of(self._recursion.seats[body].place).w

    def carrier_spin(self, body: str, axis: Sequence[float]) -> Triple:
        """Return an angular velocity that moves an axis of a body in the same way as the body's.

        For a hinge about the axis it is that of the parent link, as the hinge does not move it.

        Args:
            body: name of the body.
            axis: shape (3,), in the body's frame.
        """
        seat = self._recursion.seats[body]
        link = self._recursion.links[seat.place]
        along = apply([row[:3] for row in seat.pose], list(axis))
        if not link.linear and list(link.angular.values()) in ([along], [scale(-1.0, along)]):
            return self._of(link.parent).w
        return self.spin(body)

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
        place = [row[3] for row in self.pose(body)]
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
