"""From the world to paper: the view of a mechanism and its scale in points per meter."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mecanique.figure.paper.marks import Point
from mecanique.model.mechanism import Mechanism

Floats = NDArray[np.float64]


def _looking(azimuth: float, elevation: float) -> Floats:
    """Rows: right, up and towards the eye, in world axes."""
    ca, sa, ce, se = math.cos(azimuth), math.sin(azimuth), math.cos(elevation), math.sin(elevation)
    return np.array([[-sa, ca, 0.0], [-ca * se, -sa * se, ce], [ca * ce, sa * ce, se]])


FRONT = np.array([[1.0, 0, 0], [0, 0, 1.0], [0, -1.0, 0]])
TOP = np.array([[1.0, 0, 0], [0, 1.0, 0], [0, 0, 1.0]])
ISOMETRIC = _looking(math.radians(-33.0), math.radians(18.0))
ACROSS = _looking(math.radians(57.0), math.radians(18.0))
"""A quarter turn about the vertical from the usual view."""


@final
@dataclass(frozen=True, eq=False)
class Camera:
    """A parallel projection onto paper."""

    axes: Floats  # shape (3, 3), rows right, up and towards the eye, in world axes
    scale: float

    def at(self, position: ArrayLike) -> Point:
        """Project positions onto paper, shape (..., 2)."""
        seen = np.asarray(position, dtype=float) @ self.axes[:2].T * self.scale
        paper: Point = seen * np.array([1.0, -1.0])
        return paper

    def depth(self, position: ArrayLike) -> float:
        """Return how far a position lies towards the eye [m]."""
        return float(np.asarray(position, dtype=float) @ self.axes[2])

    @property
    def toward(self) -> Floats:
        """Unit vector from the paper to the eye."""
        eye: Floats = self.axes[2]
        return eye

    @property
    def flat(self) -> bool:
        """Whether it looks along an axis of the world."""
        return bool(np.abs(self.axes[2]).max() > 1 - 1e-9)


def side_of(mechanism: Mechanism, poses: Floats) -> Floats:
    """Return the axes of the best view of a mechanism: front or top if it is planar."""
    at = {body.name: k for k, body in enumerate(mechanism.bodies)}
    axes = []
    for joint in mechanism.joints:
        if joint.quaternion:
            return ISOMETRIC
        turn = poses[at[joint.child], :3, :3]
        axes += [(motion.kind == "slide", turn @ motion.axis) for motion in joint.chain if joint.nv]
    for view in (FRONT, TOP):
        normal = view[2]
        if all(abs(abs(axis @ normal) - (0.0 if slides else 1.0)) < 1e-6 for slides, axis in axes):
            return _upright(mechanism, view)
    return ISOMETRIC


def _upright(mechanism: Mechanism, view: Floats) -> Floats:
    """Return a flat view turned until gravity points down on paper, as beside an incline."""
    up = -np.array(mechanism.evaluate_all(mechanism.gravity))
    size = float(np.linalg.norm(up))
    if not size or abs(up @ view[2]) > 1e-9 * size or abs(up @ view[0]) < 1e-9 * size:
        return view
    up = up / size
    return np.array([np.cross(up, view[2]), up, view[2]])
