"""The elements of Drake that URDF itself does not define: one table for writer and reader.

Tags of the `drake:` namespace are those of Drake's multibody parser (Drake documentation, "Parsing
Models for Multibody", section URDF); other programs ignore them. Those of mecanique's namespace are
in `mecanique.urdf.reading.native_tags`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, final

from mecanique.urdf.markup import Tag

DRAKE_NAMESPACE = "http://drake.mit.edu"
"""Namespace declared for the prefix `drake:`; Drake itself matches the prefix by its letters."""

WORLD = "world"
"""The link that Drake and others take as the inertial frame."""

OWN_NAMESPACE = "urn:mecanique"
"""Namespace declared for the prefix `mecanique:`, where it is used."""

SCREW = "mecanique:screw"
"""Below a slide that mimics the hinge behind it: together they are one screw joint, the hinge."""

UNBOUNDED = 1e9
"""Written where the format demands a limit and there is none; larger limits are read as none."""

DRAKE_JOINT = "drake:joint"
"""Like `joint`, for types that URDF lacks, e.g. `type="ball"`; other programs ignore it."""

ACTUATOR_INERTIA = "drake:rotor_inertia"
"""Below robot/transmission/actuator: inertia of the rotor before the gear [kg·m² or kg]."""

ACTUATOR_GEAR = "drake:gear_ratio"
"""Below robot/transmission/actuator: at the joint the rotor has ratio² times its inertia."""


@final
@dataclass(frozen=True)
class Child:
    """One child element of an extension."""

    tag: str
    attribute: Literal["name", "value"]
    count: int  # how many numbers the value holds; 0 for a name
    meaning: str


@final
@dataclass(frozen=True)
class Extension:
    """An element below `robot` that URDF does not define."""

    tag: str
    meaning: str
    children: Mapping[str, Child]  # its children by role, in the order written; all are required

    def write(self, contents: Mapping[str, str]) -> Tag:
        """Return the element with the names and values of its children by role."""
        children = (
            Tag(child.tag, **{child.attribute: contents[role]})
            for role, child in self.children.items()
        )
        return Tag(self.tag, *children)


def _link(tag: str, meaning: str) -> Child:
    return Child(tag, "name", 0, meaning)


def _numbers(tag: str, count: int, meaning: str) -> Child:
    return Child(tag, "value", count, meaning)


def _two_points(prefix: str) -> dict[str, Child]:
    return {
        "body_a": _link(f"{prefix}_body_A", "link A"),
        "point_a": _numbers(f"{prefix}_p_AP", 3, "point P of link A, in its frame [m]"),
        "body_b": _link(f"{prefix}_body_B", "link B"),
        "point_b": _numbers(f"{prefix}_p_BQ", 3, "point Q of link B, in its frame [m]"),
    }


SPRING_DAMPER = Extension(
    "drake:linear_spring_damper",
    "pulls P and Q together with k (length − free length) + c d(length)/dt",
    {
        **_two_points("drake:linear_spring_damper"),
        "free_length": _numbers(
            "drake:linear_spring_damper_free_length", 1, "length without force, above zero [m]"
        ),
        "stiffness": _numbers("drake:linear_spring_damper_stiffness", 1, "k, not negative [N/m]"),
        "damping": _numbers("drake:linear_spring_damper_damping", 1, "c, not negative [N·s/m]"),
    },
)

BUSHING = Extension(
    "drake:linear_bushing_rpy",
    "torques against roll, pitch and yaw and forces against the displacements "
    "of frame C in frame A",
    {
        "frame_a": _link("drake:bushing_frameA", "frame A"),
        "frame_c": _link("drake:bushing_frameC", "frame C"),
        "torque_stiffness": _numbers(
            "drake:bushing_torque_stiffness", 3, "about x, y, z [N·m/rad]"
        ),
        "torque_damping": _numbers("drake:bushing_torque_damping", 3, "about x, y, z [N·m·s/rad]"),
        "force_stiffness": _numbers("drake:bushing_force_stiffness", 3, "along x, y, z [N/m]"),
        "force_damping": _numbers("drake:bushing_force_damping", 3, "along x, y, z [N·s/m]"),
    },
)

BALL_CONSTRAINT = Extension(
    "drake:ball_constraint",
    "keeps P and Q together",
    _two_points("drake:ball_constraint"),
)

DISTANCE_CONSTRAINT = Extension(
    "drake:distance_constraint",
    "keeps the distance from P to Q, by a stiff spring and a damper",
    {
        **_two_points("drake:distance_constraint"),
        "distance": _numbers(
            "drake:distance_constraint_distance", 1, "kept distance, above zero [m]"
        ),
        "stiffness": _numbers("drake:distance_constraint_stiffness", 1, "above zero [N/m]"),
        "damping": _numbers("drake:distance_constraint_damping", 1, "not negative [N·s/m]"),
    },
)

IN_DRAKE = ("ball", "distance")
"""Kinds of loops for which Drake has a tag."""

EXTENSIONS: Mapping[str, Extension] = {
    extension.tag: extension
    for extension in (SPRING_DAMPER, BUSHING, BALL_CONSTRAINT, DISTANCE_CONSTRAINT)
}
"""Every extension by its tag."""
