"""Where wheels, or a pinion and its rack, touch on their pitch circles."""

from __future__ import annotations

from math import atan2
from typing import NamedTuple, final

import numpy as np

from mecanique.arrays import Array
from mecanique.model.constraints.gears import Gear, Rack
from mecanique.model.joints import Prismatic, Revolute
from mecanique.model.mechanism import Mechanism
from mecanique.model.mechanism.element_laws import bevel_of


@final
class PitchPoint(NamedTuple):
    """Where two parts in mesh touch, in the world.

    Args:
        axis: of the wheel.
        toward: from its center to where the pitch circles touch, a unit vector.
        other_axis: of the other wheel.
        other_toward: the same from its center.
        rises: angles by which the teeth of both point out of their wheels' planes, towards the
            axes; zero unless they are bevel wheels [rad].
        ray: from the apex of bevel wheels to there [m].
    """

    axis: Array
    toward: Array
    other_axis: Array
    other_toward: Array
    rises: tuple[float, float] = (0.0, 0.0)
    ray: float = 0.0


def find_pitch_point(mechanism: Mechanism, mesh: Gear | Rack, A: Array, B: Array) -> PitchPoint:
    """Return where a wheel touches another, or a rack.

    Args:
        mechanism: whose elements.
        mesh: one of them, between wheels on hinges or with a rack on a slide.
        A: shape (4, 4), pose of the wheel.
        B: shape (4, 4), pose of the other part.
    """
    wheel, other = (mechanism.joint(name) for name in mesh.joints)
    assert isinstance(wheel, Revolute)
    assert isinstance(other, Revolute | Prismatic)
    n, line = A[:3, :3] @ np.array(wheel.axis), B[:3, :3] @ np.array(other.axis)
    bevel = bevel_of(mechanism, mesh) if isinstance(mesh, Gear) else None
    if bevel is not None and isinstance(mesh, Gear):
        c, s = bevel.cosine, bevel.sine
        r, R = mechanism.evaluate_all((mesh.radius, mesh.other_radius))
        x, y = bevel.sides[0] * r, bevel.sides[1] * R
        # from the apex the centers are at a n and b n'
        a, b = (y + c * x) / s, (x + c * y) / s
        return PitchPoint(
            axis=n,
            toward=bevel.sides[0] * (line - c * n) / s,
            other_axis=line,
            other_toward=bevel.sides[1] * (n - c * line) / s,
            rises=(_rise(a, r), _rise(b, R)),
            ray=float(np.hypot(a, r)),
        )
    point = mesh.point if isinstance(mesh, Rack) else (0.0, 0.0, 0.0)
    d = B[:3, :3] @ mechanism.evaluate_all(point) + B[:3, 3] - A[:3, 3]
    if isinstance(other, Prismatic):
        d = d - (d @ line) * line
    d = d - (d @ n) * n
    u = d / np.linalg.norm(d)
    internal = isinstance(mesh, Gear) and mesh.internal
    return PitchPoint(n, u, n, u if internal else -u)


def _rise(ahead: float, radius: float) -> float:
    """The angle of a cone's outward normal from the wheel's plane, its apex behind by a height."""
    return -atan2(radius, ahead) if ahead > 0 else atan2(radius, -ahead)
