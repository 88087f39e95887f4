"""Joints of the catalogue: in a plane, and those that lead a free body from the ground."""

from __future__ import annotations

import numpy as np

from mecanique.model import Body, Placement, Prismatic, Revolute, Spherical
from mecanique.model.expression import Vector
from mecanique.model.quaternions import conjugate, turn
from mecanique.textbook.facts import Number, Values

Led = tuple[Prismatic | Revolute | Spherical, ...]
"""Joints, each of which leads the parent of the next."""


def hinge(
    name: str,
    parent: str,
    child: str,
    coordinate: str,
    at: Vector = (0, 0, 0),
    axis: tuple[float, float, float] = (0, -1, 0),
) -> Revolute:
    """Return a hinge; about −y, an angle from the downward vertical grows towards +x.

    Args:
        name: its name.
        parent: name of the parent body.
        child: name of the child body.
        coordinate: name of its coordinate.
        at: shape (3,), where it stands in the parent [m].
        axis: shape (3,), in the parent's frame.
    """
    return Revolute(name, parent, child, axis=axis, origin=_at(at), coordinate=coordinate)


def slide(
    name: str,
    parent: str,
    child: str,
    coordinate: str,
    at: Vector,
    axis: tuple[float, float, float],
) -> Prismatic:
    """Return a slide; its arguments are those of `hinge`."""
    return Prismatic(name, parent, child, axis=axis, origin=_at(at), coordinate=coordinate)


def _at(point: Vector) -> Placement:
    x, y, z = point
    return Placement((x, y, z))


def slides(center: str) -> Led:
    """Return the slides x, y and z that lead a body from the ground."""
    return (
        Prismatic("slide_x", "ground", "along_x", axis=(1, 0, 0), coordinate="x"),
        Prismatic("slide_y", "along_x", "along_y", axis=(0, 1, 0), coordinate="y"),
        Prismatic("lift", "along_y", center, axis=(0, 0, 1), coordinate="z"),
    )


def hinges(
    center: str,
    leaning: str,
    body: str,
    names: tuple[str, str, str] = ("turn", "side", "nod"),
    angles: tuple[str, str, str] = ("yaw", "roll", "pitch"),
) -> Led:
    """Return the hinges by which a body turns: about the vertical, ahead and across."""
    first, side, nod = names
    yaw, roll, pitch = angles
    return (
        Revolute(first, center, "heading", axis=(0, 0, 1), coordinate=yaw),
        Revolute(side, "heading", leaning, axis=(1, 0, 0), coordinate=roll),
        Revolute(nod, leaning, body, axis=(0, 1, 0), coordinate=pitch),
    )


def carriers(joints: Led) -> tuple[Body, ...]:
    """Return the massless bodies between joints that lead from the ground to a body."""
    return tuple(Body(joint.child) for joint in joints[:-1])


def about(axis: int, angle: Number) -> Number:
    """Return the turn about x, y or z, of facts in these coordinates, shape (3, 3).

    Args:
        axis: 0, 1 or 2.
        angle: [rad], complex where a fact is differentiated by a complex step.
    """
    i, k = (axis + 1) % 3, (axis + 2) % 3
    turned = np.zeros((3, 3), dtype=complex)
    turned[axis, axis] = 1
    turned[[i, k], [i, k]] = np.cos(angle)
    turned[k, i], turned[i, k] = np.sin(angle), -np.sin(angle)
    return turned


def to_world(s: Values, u: Number) -> Number:
    """Return a vector of the axes of the body that qx, qy, qz and qw turn, in world axes."""
    return turn(np.array([s.qx, s.qy, s.qz, s.qw]), u)


def to_body(s: Values, u: Number) -> Number:
    """Return a vector of world axes in the axes of that body."""
    return turn(conjugate(np.array([s.qx, s.qy, s.qz, s.qw])), u)
