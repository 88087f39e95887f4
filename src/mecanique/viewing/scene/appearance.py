"""How bodies and joints look: their shapes in their own frames, and a mark at each joint."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from mecanique.model.bodies.visuals import Box, Cylinder, Mesh, Sphere, Visual
from mecanique.model.joints import Planar, Single
from mecanique.model.mechanism import Mechanism
from mecanique.model.teeth import visuals_of
from mecanique.viewing.scene.scene import GREY, Floats, JointMark, SceneBody, Shape

__all__ = ["bodies_of", "marks_of", "quaternions_of"]


def bodies_of(mechanism: Mechanism) -> tuple[SceneBody, ...]:
    """Return a mechanism's bodies as they are drawn."""
    visuals = visuals_of(mechanism)
    return tuple(
        SceneBody(body.name, tuple(_shapes(mechanism, visuals[body.name])))
        for body in mechanism.bodies
    )


def marks_of(mechanism: Mechanism) -> tuple[JointMark, ...]:
    """Return a mark for each joint, at the origin of its child."""
    marks = []
    for joint in mechanism.joints:
        axis = joint.axis if isinstance(joint, (Single, Planar)) else (0.0, 0.0, 0.0)
        kind = type(joint).__name__.lower()
        marks.append(JointMark(joint.name, kind, joint.child, (0.0, 0.0, 0.0), axis))
    return tuple(marks)


def quaternions_of(rotations: Floats) -> Floats:
    """Return rotation matrices, shape (n, nb, 3, 3), as quaternions, shape (n, nb, 4)."""
    r = np.moveaxis(rotations, (-2, -1), (0, 1))
    x, y, z = (1 + 2 * r[k, k] - np.trace(r) for k in range(3))
    w = 1 + np.trace(r)
    # 4 q qᵀ, whose longest row is the quaternion without loss of digits
    squares = np.array(
        [
            [x, r[0, 1] + r[1, 0], r[0, 2] + r[2, 0], r[2, 1] - r[1, 2]],
            [r[0, 1] + r[1, 0], y, r[1, 2] + r[2, 1], r[0, 2] - r[2, 0]],
            [r[0, 2] + r[2, 0], r[1, 2] + r[2, 1], z, r[1, 0] - r[0, 1]],
            [r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1], w],
        ]
    )
    longest = np.argmax([x, y, z, w], axis=0)
    found = np.moveaxis(np.take_along_axis(squares, longest[None, None], axis=0)[0], 0, -1)
    return np.asarray(found / np.linalg.norm(found, axis=-1, keepdims=True))


def _shapes(mechanism: Mechanism, visuals: Sequence[Visual]) -> Iterator[Shape]:
    for visual in visuals:
        pose = mechanism.matrix(visual.placement)
        rgba = visual.rgba or GREY
        match visual.geometry:
            case Box(size):
                yield Shape("box", tuple(mechanism.evaluate_all(size)), pose, rgba)
            case Cylinder(radius, length):
                yield Shape(
                    "cylinder", (mechanism.evaluate(radius), mechanism.evaluate(length)), pose, rgba
                )
            case Sphere(radius):
                yield Shape("sphere", (mechanism.evaluate(radius),), pose, rgba)
            case Mesh(path=path, scale=scale) if path is not None:
                yield Shape("mesh", scale, pose, visual.rgba, path)
            case _:
                pass  # lint reports a mesh that was not found; there is nothing to draw
