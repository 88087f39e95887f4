"""Hinges in place of quaternions, next to a steady motion.

Deviations by a quaternion's velocities turn with the body, so that a steady motion is none in them.
A body that turns steadily about an axis e of its own while that axis goes round a fixed axis p has
the angular velocity Ω p + σ e; described by hinges about p, about the normal to both and about e,
its angles change at the constant rates Ω, 0 and σ (E. J. Routh, Advanced Rigid Dynamics, 1905, ch.
III). In the body's axes that is ω' = −σ e × ω, by which e and σ are found.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import final

import numpy as np

from mecanique.arrays import Array
from mecanique.errors import InputError, MechanismError
from mecanique.model.bodies import Body
from mecanique.model.bodies.tensor import tensor_of
from mecanique.model.constraint_base import PressingContact
from mecanique.model.joints import Floating, Joint, Prismatic, Revolute, Spherical
from mecanique.model.mechanism import Mechanism
from mecanique.model.placement import Placement, rpy_of
from mecanique.model.quaternions import to_matrices

_KINDS = ("precession", "nutation", "spin")
"""What a hinge's angle is called, by its place."""

_CONSTANT = 1e-9
"""Rates below this part of the square of the angular velocity count as zero."""

_LEAST = 1e-12
"""Angular velocities below this count as rest [rad/s]."""

_ALIKE = 1e-9
"""Moments of inertia that differ by this part are equal."""

_FLAT = 1e-3
"""Hinges about axes that enclose a smaller angle than this do not describe an attitude [rad]."""


@final
@dataclass(frozen=True)
class Hinged:
    """A mechanism without quaternions, in a state."""

    mechanism: Mechanism  # its joints that turned by quaternions are slides and hinges
    position: dict[str, float]  # of each coordinate, by name
    velocity: dict[str, float]  # of each velocity, by name


@final
@dataclass(frozen=True)
class _Turning:
    """How a body turns, next to a state."""

    outer: Array  # unit vector of the axis that stays where it is, in the joint's frame
    outer_rate: float  # about it [rad/s]
    inner: Array  # unit vector of the body's own axis, in the body's frame
    inner_rate: float  # about it [rad/s]


def put_hinges(mechanism: Mechanism, q: Array, v: Array, a: Array) -> Hinged:
    """Return a mechanism with hinges in place of its quaternions, in the same state."""
    bodies, joints = list(mechanism.bodies), list[Joint]()
    place = dict(zip(mechanism.coordinates, q.tolist(), strict=True))
    rate = dict(zip(mechanism.velocities, v.tolist(), strict=True))
    second = dict(zip(mechanism.velocities, a.tolist(), strict=True))
    for joint in mechanism.joints:
        if not isinstance(joint, Spherical | Floating):
            joints.append(joint)
            continue
        position, turns = joint.names[:-4], joint.velocities[-3:]
        attitude = to_matrices(np.array([place.pop(name) for name in joint.names[-4:]]))
        w = np.array([rate.pop(name) for name in turns])
        turning = _split(mechanism, joint, attitude, w, np.array([second[name] for name in turns]))
        chain = list(_chain(joint, attitude, turning))
        if position:
            moved = attitude @ [rate.pop(k) for k in joint.velocities[:3]]
            rate |= {f"{name}'": float(x) for name, x in zip(position, moved, strict=True)}
        speeds = (turning.outer_rate, 0.0, turning.inner_rate)
        for hinge, speed in zip(chain[-3:], speeds, strict=True):
            place[hinge.coordinate], rate[f"{hinge.coordinate}'"] = 0.0, speed
        joints += chain
        bodies += [Body(hinge.child) for hinge in chain[:-1]]
    quaternions = {name for j in mechanism.joints if j.quaternion for name in j.coordinates}
    coordinates = replace(
        mechanism.coordinates,
        names=tuple(name for name in mechanism.coordinates if name not in quaternions),
    )
    try:
        hinged = replace(
            mechanism, bodies=tuple(bodies), joints=tuple(joints), coordinates=coordinates
        )
    except MechanismError as error:
        name = mechanism.quaternions[0][0]
        raise InputError(
            f"joint {name!r} turns by a quaternion that cannot be replaced by hinges here: "
            f"{'; '.join(error.faults)}; describe it by three hinges"
        ) from error
    return Hinged(hinged, place, rate)


def _chain(
    joint: Spherical | Floating, attitude: Array, turning: _Turning
) -> Iterator[Prismatic | Revolute]:
    """The slides and hinges in a joint's place."""
    inner = attitude @ turning.inner
    normal = np.cross(turning.outer, inner)
    length = float(np.linalg.norm(normal))
    if length < _FLAT:
        raise InputError(
            f"the body of joint {joint.name!r} spins about the very axis about which it precesses, "
            "so that the hinges are singular; describe it by hinges about other axes"
        )
    before, origin = joint.parent, joint.origin
    directions = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    for direction, name in zip(directions, joint.names[:-4], strict=False):
        child = f"{name}_led"
        yield Prismatic(
            f"{joint.name}_along_{name}",
            before,
            child,
            origin=origin,
            axis=direction,
            coordinate=name,
        )
        before, origin = child, Placement()
    axes = (turning.outer, normal / length, turning.inner)
    for kind, axis in zip(_KINDS, axes, strict=True):
        name, child = f"{joint.name}_{kind}", f"{joint.name}_{kind}_led"
        if kind == _KINDS[-1]:
            child, origin = joint.child, Placement(rpy=rpy_of(attitude))
        yield Revolute(name, before, child, origin=origin, axis=tuple(axis.tolist()))
        before, origin = child, Placement()


def _split(
    mechanism: Mechanism, joint: Spherical | Floating, attitude: Array, w: Array, rate: Array
) -> _Turning:
    """Take the angular velocity apart: about a fixed axis, and about one of the body's own."""
    speed = float(np.linalg.norm(w))
    axes, round_ = _symmetry(mechanism, joint.child)
    if speed < _LEAST or np.linalg.norm(rate) <= _CONSTANT * speed**2:
        spin_axis = w / speed if speed >= _LEAST else np.array([0.0, 0.0, 1.0])
        aside = np.cross(spin_axis, np.eye(3)[np.abs(spin_axis).argmin()])
        aside /= np.linalg.norm(aside)
        if round_ or any(np.linalg.norm(np.cross(spin_axis, axis)) < _CONSTANT for axis in axes):
            return _Turning(attitude @ aside, 0.0, spin_axis, speed)
        return _Turning(attitude @ spin_axis, speed, aside, 0.0)
    if round_:
        # every axis will do: that of what is left of a turn about the vertical
        fall = attitude.T @ mechanism.evaluate_all(mechanism.gravity)
        axes = [w - _factor(rate, np.cross(fall, w)) * fall]
        axes = [axis / max(float(np.linalg.norm(axis)), _LEAST) for axis in axes]
    for spin_axis in axes:
        spin = _factor(rate, -np.cross(spin_axis, w))
        outer = attitude @ (w - spin * spin_axis)
        going = float(np.linalg.norm(outer))
        left = np.abs(rate + spin * np.cross(spin_axis, w)).max()
        if left <= _CONSTANT * speed**2 and going > _LEAST:
            return _Turning(outer / going, going, spin_axis, spin)
    change = ", ".join(
        f"{name}' = {x:.3g}" for name, x in zip(joint.velocities[-3:], rate, strict=True)
    )
    raise InputError(
        f"the motion of {mechanism.name!r} is not steady: {change}; expected a "
        f"spin of body {joint.child!r} about an axis of symmetry that precesses at a constant rate"
    )


def _factor(a: Array, b: Array) -> float:
    """The multiple of b nearest to a, by least squares."""
    return float(a @ b) / max(float(b @ b), _LEAST**2)


def _symmetry(mechanism: Mechanism, name: str) -> tuple[list[Array], bool]:
    """The axes about which a body may be turned without any change, and whether all are."""
    body = mechanism.body(name)
    rolling = [
        contact
        for contact in mechanism.contacts
        if isinstance(contact, PressingContact) and contact.body == name
    ]
    axes = [np.array(wheel.axis) for wheel in rolling if wheel.axis]
    moments, principal = np.linalg.eigh(tensor_of(mechanism.evaluate_all(body.inertia)))
    low, high = np.diff(moments) <= _ALIKE * moments[-1]
    center = np.array(mechanism.evaluate_all(body.center))
    if low and high:
        plain = not axes and not any(contact.stretched for contact in rolling)
        return axes, plain and not center.any()
    axes += [principal[:, k] for k, alike in ((2, low), (0, high)) if alike]
    aside = (np.linalg.norm(np.cross(axis, center)) for axis in axes)
    size = max(float(np.linalg.norm(center)), _LEAST)
    return [axis for axis, off in zip(axes, aside, strict=True) if off <= _ALIKE * size], False
