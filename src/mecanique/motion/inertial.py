"""Whether the ground may be taken for an inertial frame: the same motion on the turning earth.

The site is carried around by the earth, which turns once in a sidereal day: a rheonomic joint between inertial space
and the ground, with no small-angle formula and no Coriolis force written by hand. The acceleration of free fall that
the mechanism states is what a plumb line shows at the world's origin, the centrifugal part there included; it turns
with the ground. With that the earth's center may be left out: what its distance adds is the same at all points of the
site and is part of what the plumb line shows. The earth's way around the sun and tides are left out.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, final

import numpy as np

from mecanique.errors import InputError
from mecanique.model.bodies import Body
from mecanique.model.coordinates import Coordinates
from mecanique.model.expression import time
from mecanique.model.forces import AnyForce, Force, Torque
from mecanique.model.joints import Revolute
from mecanique.model.mechanism import Mechanism
from mecanique.model.parameters import Parameter
from mecanique.motion.integrate import simulate
from mecanique.motion.motion import Motion

__all__ = ["EARTH_RATE", "Change", "InertialCheck", "inertial_check", "on_the_turning_earth"]

EARTH_RATE = 7.292115e-5
"""Angular velocity of the earth [rad/s] (IERS Conventions 2010, table 1.2)."""

_SPACE, _JOINT, _RATE = "inertial_space", "earth", "Omega_earth"


@final
@dataclass(frozen=True)
class Change:
    """How far the earth's rotation changes a quantity.

    Args:
        largest: over the motion, in the quantity's unit.
        relative: the same by the largest value of the quantity; infinite where it is zero without the rotation.
        time: when it is largest [s].
    """

    largest: float
    relative: float
    time: float


@final
@dataclass(frozen=True)
class InertialCheck:
    """How far motion, reactions and periods change on the turning earth; its text is a table.

    Args:
        mechanism: its name.
        latitude: north positive [rad].
        duration: of the motion [s].
        coordinates: change of each coordinate.
        reactions: change of the force in each joint, in the axes of the ground.
        periods: mean time between the maxima of each coordinate that has two, without and with the rotation [s].
        motion: the motion on the turning earth.
    """

    mechanism: str
    latitude: float
    duration: float
    coordinates: Mapping[str, Change]
    reactions: Mapping[str, Change]
    periods: Mapping[str, tuple[float, float]]
    motion: Motion

    @property
    def worst(self) -> float:
        """The largest relative change of a coordinate that moves without the rotation."""
        finite = [change.relative for change in self.coordinates.values() if math.isfinite(change.relative)]
        return max(finite, default=0.0)

    def __str__(self) -> str:
        degrees = math.degrees(self.latitude)
        lines = [
            f"{self.mechanism} on the earth, turning at {EARTH_RATE:g} rad/s, latitude {degrees:.4g} degrees, "
            f"{self.duration:.4g} s; x points east, y north, z up"
        ]
        width = max(map(len, [*self.coordinates, *self.reactions, *self.periods]), default=0)
        for what, changes in (("coordinate", self.coordinates), ("reaction in", self.reactions)):
            for name, change in changes.items():
                share = (
                    f"{change.relative:.1e} of its largest value" if math.isfinite(change.relative) else "zero without"
                )
                lines.append(
                    f"  {what:<11} {name:<{width}}  changes by {change.largest:.2e} ({share}) at {change.time:.4g} s"
                )
        for name, (without, including) in self.periods.items():
            shift = including / without - 1
            lines.append(f"  {'period of':<11} {name:<{width}}  {without:.9g} s, relative change {shift:.1e}")
        return "\n".join(lines)


def on_the_turning_earth(mechanism: Mechanism, latitude: float) -> Mechanism:
    """Return a mechanism whose ground is carried by the earth; x points east, y north, z up.

    Args:
        mechanism: any mechanism; its gravity is what a plumb line shows.
        latitude: north positive [rad].

    Raises:
        InputError: if the latitude is not within −π/2…π/2.
    """
    if not (isinstance(latitude, (int, float)) and -math.pi / 2 <= latitude <= math.pi / 2):
        raise InputError(f"expected a latitude within -pi/2…pi/2 rad, north positive, got {latitude!r}")
    ground = mechanism.ground
    rate = Parameter(_RATE, EARTH_RATE, "rad/s", "angular velocity of the earth")
    weights: list[AnyForce] = []
    for body in mechanism.bodies:
        if body.name != ground and body.mass != 0:
            x, y, z = (_product(body.mass, component) for component in mechanism.gravity)
            weights.append(Force(f"weight_of_{body.name}", body.name, body.center, (x, y, z), axes=ground))
    carried = [
        replace(force, axes=ground) if isinstance(force, (Force, Torque)) and force.axes == "world" else force
        for force in mechanism.forces
    ]
    axis = (0.0, math.cos(latitude), math.sin(latitude))
    return replace(
        mechanism,
        name=f"{mechanism.name}_on_earth",
        bodies=(Body(_SPACE), *mechanism.bodies),
        joints=(Revolute(_JOINT, _SPACE, ground, axis=axis), *mechanism.joints),
        forces=(*carried, *weights),
        parameters=(*mechanism.parameters, rate),
        coordinates=Coordinates(mechanism.coordinates.names, {**mechanism.coordinates.driven, _JOINT: rate * time()}),
        gravity=(0.0, 0.0, 0.0),
        ground=_SPACE,
    )


def inertial_check(mechanism: Mechanism, motion: Motion, latitude: float) -> InertialCheck:
    """Judge a motion for which the ground was taken for an inertial frame: how far the earth's rotation changes it.

    Args:
        mechanism: what moved.
        motion: how it moved, by `simulate`.
        latitude: of the site, north positive [rad]; x points east, y north, z up.

    Raises:
        InputError: if the latitude is not within −π/2…π/2, or the motion is another mechanism's.
        IntegrationError: if the motion on the turning earth cannot be integrated.
    """
    if motion.mechanism != mechanism:
        raise InputError(f"expected a motion of {mechanism.name!r}, got one of {motion.mechanism.name!r}")
    carried = on_the_turning_earth(mechanism, latitude)
    t = motion.t
    turning = simulate(
        carried,
        q=motion.q[0],
        v=motion.v[0],
        duration=float(t[-1] - t[0]),
        rtol=motion.statistics.rtol,
        t0=float(t[0]),
    )
    there = turning(np.clip(t, turning.t[0], turning.t[-1]))
    coordinates = {
        name: _change(there.q[:, k : k + 1] - motion.q[:, k : k + 1], motion.q[:, k : k + 1], t)
        for k, name in enumerate(mechanism.coordinates)
    }
    engine = turning.reference
    place = [body.name for body in carried.bodies].index(mechanism.ground)
    axes = engine.poses(there.q, there.t)[:, place, :3, :3]
    theirs = engine.reactions(there.q, there.v, there.t)
    ours = motion.reference.reactions(motion.q, motion.v, t)
    reactions = {}
    for joint in mechanism.joints:
        force = np.einsum("nji,nj->ni", axes, theirs[joint.name].force)
        reactions[joint.name] = _change(force - ours[joint.name].force, ours[joint.name].force, t)
    periods = {}
    for name in mechanism.coordinates:
        found = [_period(one, name) for one in (motion, turning)]
        if found[0] is not None and found[1] is not None:
            periods[name] = (found[0], found[1])
    return InertialCheck(mechanism.name, latitude, float(t[-1] - t[0]), coordinates, reactions, periods, turning)


def _change(difference: np.ndarray, values: np.ndarray, t: np.ndarray) -> Change:
    size = np.linalg.norm(difference, axis=1)
    at = int(size.argmax())
    largest, whole = float(size[at]), float(np.linalg.norm(values, axis=1).max())
    tiny = 1e-12 * max(largest, 1e-300)
    relative = largest / whole if whole > tiny else math.inf if largest else 0.0
    return Change(largest, relative, float(t[at]))


def _period(motion: Motion, name: str) -> float | None:
    """Mean time between the maxima of a coordinate: where its rate falls through zero."""
    if f"{name}'" not in motion.mechanism.velocities:
        return None
    from scipy.optimize import brentq

    column = motion.mechanism.velocities.index(f"{name}'")
    t = np.linspace(motion.t[0], motion.t[-1], 20 * len(motion.t))
    rate = motion(t).v[:, column]
    scale = float(np.abs(rate).max())
    falls = np.flatnonzero((rate[:-1] > 0) & (rate[1:] <= 0) & (scale > 1e-9))

    def at(moment: float) -> float:
        return float(motion(moment).v[column])

    tops = [brentq(at, t[k], t[k + 1], xtol=1e-14) for k in falls]
    return float((tops[-1] - tops[0]) / (len(tops) - 1)) if len(tops) > 1 else None


def _product(mass: Any, component: Any) -> Any:
    return 0.0 if isinstance(component, float) and component == 0.0 else mass * component
