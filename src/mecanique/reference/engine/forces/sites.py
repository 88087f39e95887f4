"""Points and axes fixed in the engine's bodies, read with few calls, and actions on them."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, NamedTuple, TypeAlias, final

from mecanique.arrays import Array
from mecanique.reference.engine.package import engine_package

Triple: TypeAlias = "tuple[float, float, float]"
"""Components along x, y, z."""


@final
@dataclass(frozen=True, eq=False)
class JointAxes:
    """The axes of one of the engine's joints, as views of the engine's data."""

    joint: int  # index of the joint, 0 for the world
    rotation: Array  # shape (3, 3), from these axes to the world's
    origin: Array  # shape (3,), in the world [m]
    linear: Array  # shape (3,), velocity of the origin, these axes [m/s]
    angular: Array  # shape (3,), angular velocity, these axes [rad/s]

    def to_world(self, vector: Triple) -> Triple:
        """Transform a vector from these axes to the world's."""
        a, b, c = vector
        (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = self.rotation.tolist()
        return xx * a + xy * b + xz * c, yx * a + yy * b + yz * c, zx * a + zy * b + zz * c


@final
@dataclass(frozen=True, eq=False)
class Site:
    """A point fixed in a body."""

    body: str  # name of the body
    axes: JointAxes  # axes of the joint that carries the body
    point: Triple  # shape (3,), in those axes [m]

    def position(self) -> Triple:
        """Return its position in the world [m]."""
        x, y, z = self.axes.origin.tolist()
        if not any(self.point):
            return x, y, z
        a, b, c = self.axes.to_world(self.point)
        return x + a, y + b, z + c

    def velocity(self) -> Triple:
        """Return its velocity, world axes [m/s]."""
        x, y, z = self.point
        p, q, r = self.axes.angular.tolist()
        a, b, c = self.axes.linear.tolist()
        return self.axes.to_world((a + q * z - r * y, b + r * x - p * z, c + p * y - q * x))


class SiteAction(NamedTuple):
    """A force at a point and a torque, on a body."""

    site: Site  # a point of the body
    force: Triple  # shape (3,), world axes [N]
    point: Triple  # point of action in the world, shape (3,) [m]
    torque: Triple  # shape (3,), world axes [N·m]

    @classmethod
    def of(cls, site: Site, force: Array, point: Array, torque: Array) -> SiteAction:
        """Return an action given by arrays, shape (3,) each."""
        x, y, z = (tuple(part.tolist()) for part in (force, point, torque))
        return cls(site, x, y, z)

    def moment(self, x: float, y: float, z: float) -> Triple:
        """Return the moment about the point (x, y, z) of the world, world axes [N·m]."""
        (fx, fy, fz), (px, py, pz), (a, b, c) = self.force, self.point, self.torque
        px -= x
        py -= y
        pz -= z
        return a + py * fz - pz * fy, b + pz * fx - px * fz, c + px * fy - py * fx


@final
class External:
    """The total action on each of the engine's bodies, in the engine's form."""

    def __init__(self, joints: int) -> None:
        pin = engine_package()

        self.forces: Any = pin.StdVec_Force()
        """pinocchio.StdVec_Force: one for each joint, in its axes, at its origin."""
        for _ in range(joints):
            self.forces.append(pin.Force.Zero())
        # views of the engine's own memory
        self._wrenches = [self.forces[joint].vector for joint in range(joints)]
        self._used: set[int] = set()

    def set(self, actions: Iterable[SiteAction]) -> None:
        """Sum the actions on each body."""
        sums: dict[int, list[Any]] = {}
        for action in actions:
            axes = action.site.axes
            if not axes.joint:
                continue
            fx, fy, fz = action.force
            mx, my, mz = action.moment(*axes.origin.tolist())
            if axes.joint in sums:
                total = sums[axes.joint]
                total[1] += fx
                total[2] += fy
                total[3] += fz
                total[4] += mx
                total[5] += my
                total[6] += mz
            else:
                sums[axes.joint] = [axes, fx, fy, fz, mx, my, mz]
        for joint in self._used - sums.keys():
            self._wrenches[joint][:] = 0.0
        for joint, (axes, fx, fy, fz, mx, my, mz) in sums.items():
            (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = axes.rotation.tolist()
            self._wrenches[joint][:] = (
                xx * fx + yx * fy + zx * fz,
                xy * fx + yy * fy + zy * fz,
                xz * fx + yz * fy + zz * fz,
                xx * mx + yx * my + zx * mz,
                xy * mx + yy * my + zy * mz,
                xz * mx + yz * my + zz * mz,
            )
        self._used = set(sums)
