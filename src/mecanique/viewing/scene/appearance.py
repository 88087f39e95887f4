"""How bodies and joints look: their shapes in their own frames, and a mark at each joint."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from mecanique.model.bodies.visuals import Box, Cylinder, Mesh, Sphere, Visual
from mecanique.model.joint_base import Single
from mecanique.model.joints import Planar
from mecanique.model.mechanism import Mechanism
from mecanique.model.meshing.teeth import visuals_of
from mecanique.viewing.scene.scene import GREY, JointMark, SceneBody, Shape


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
