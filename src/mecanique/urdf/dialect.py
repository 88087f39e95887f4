"""The elements of Drake that URDF itself does not define: one table for writer and reader.

Tags of the `drake:` namespace are those of Drake's multibody parser (Drake documentation, "Parsing
Models for Multibody", section URDF); other programs ignore them. Those of mecanique's namespace are
in `mecanique.urdf.reading.native_tags`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, final

from mecanique.urdf.markup import Element, Tag

DRAKE_NAMESPACE = "http://drake.mit.edu"
"""Namespace declared for the prefix `drake:`; Drake itself matches the prefix by its letters."""

WORLD = "world"
"""The link that Drake and others take as the inertial frame."""

NAMESPACE = "urn:mecanique"
"""Namespace declared for the prefix `mecanique:`, where it is used."""

SCREW = "mecanique:screw"
"""Below a slide that mimics the hinge behind it: together they are one screw joint, the hinge."""

UNBOUNDED = 1e9
"""Written where the format demands a limit and there is none; larger limits are read as none."""

DRAKE_JOINT = "drake:joint"
"""Like `joint`, for types that URDF lacks, e.g. `type="ball"`; other programs ignore it."""

UNUSED = frozenset({"safety_controller", "calibration", "transmission"})
"""Tags of URDF that no equation of motion uses, but for the rotor in a transmission."""

FOREIGN = frozenset({"gazebo", "ros2_control", "sensor", "mujoco", "loop_joint"})
"""Tags of other programs."""

ACTUATOR_INERTIA = "drake:rotor_inertia"
"""Below robot/transmission/actuator: inertia of the rotor before the gear [kg·m² or kg]."""

ACTUATOR_GEAR = "drake:gear_ratio"
"""Below robot/transmission/actuator: at the joint the rotor has ratio² times its inertia."""


@final
@dataclass(frozen=True)
class Child:
    """One child element of an extension."""

    tag: str
    count: int  # how many numbers its value holds; 0 if it has a name instead
    meaning: str

    @property
    def attribute(self) -> Literal["name", "value"]:
        """What it has."""
        return "value" if self.count else "name"


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


_ENDS = {
    "body_a": "body_A",
    "point_a": "p_AP",
    "body_b": "body_B",
    "point_b": "p_BQ",
    "frame_a": "frameA",
    "frame_c": "frameC",
}
"""How the tags of some roles end; others end with the role."""

_TWO_POINTS = {
    "body_a": (0, "link A"),
    "point_a": (3, "point P of link A, in its frame [m]"),
    "body_b": (0, "link B"),
    "point_b": (3, "point Q of link B, in its frame [m]"),
}


def _extend(
    tag: str, meaning: str, children: Mapping[str, tuple[int, str]], prefix: str = ""
) -> Extension:
    """Return an element whose children have tags with its own in front, or with a prefix."""
    named = {
        role: Child(f"{prefix or tag}_{_ENDS.get(role, role)}", *stated)
        for role, stated in children.items()
    }
    return Extension(tag, meaning, named)


SPRING_DAMPER = _extend(
    "drake:linear_spring_damper",
    "pulls P and Q together with k (length − free length) + c d(length)/dt",
    {
        **_TWO_POINTS,
        "free_length": (1, "length without force, above zero [m]"),
        "stiffness": (1, "k, not negative [N/m]"),
        "damping": (1, "c, not negative [N·s/m]"),
    },
)

BUSHING = _extend(
    "drake:linear_bushing_rpy",
    "torques against roll, pitch and yaw and forces against the displacements "
    "of frame C in frame A",
    {
        "frame_a": (0, "frame A"),
        "frame_c": (0, "frame C"),
        "torque_stiffness": (3, "about x, y, z [N·m/rad]"),
        "torque_damping": (3, "about x, y, z [N·m·s/rad]"),
        "force_stiffness": (3, "along x, y, z [N/m]"),
        "force_damping": (3, "along x, y, z [N·s/m]"),
    },
    prefix="drake:bushing",
)

BALL_CONSTRAINT = _extend("drake:ball_constraint", "keeps P and Q together", _TWO_POINTS)

DISTANCE_CONSTRAINT = _extend(
    "drake:distance_constraint",
    "keeps the distance from P to Q, by a stiff spring and a damper",
    {
        **_TWO_POINTS,
        "distance": (1, "kept distance, above zero [m]"),
        "stiffness": (1, "above zero [N/m]"),
        "damping": (1, "not negative [N·s/m]"),
    },
)

IN_DRAKE = ("ball", "distance")
"""Kinds of loops for which Drake has a tag."""

EXTENSIONS: Mapping[str, Extension] = {
    extension.tag: extension
    for extension in (SPRING_DAMPER, BUSHING, BALL_CONSTRAINT, DISTANCE_CONSTRAINT)
}
"""Every extension by its tag."""


def uses_drake(element: Element) -> bool:
    """Return whether the tag of an element or an attribute has the prefix drake:."""
    return any(name.startswith("drake:") for name in (element.tag, *element.attributes))
