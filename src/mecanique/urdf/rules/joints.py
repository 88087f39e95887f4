"""Rules on joints, their axes, limits and damping: M3."""

from __future__ import annotations

from mecanique.urdf.rules.rule import Rule

RULES = (
    Rule(
        "M301",
        "unknown-joint-type",
        "error",
        "How it moves is not known.",
        "Use a type of URDF or of <drake:joint>.",
    ),
    Rule(
        "M302",
        "zero-axis",
        "error",
        "It points nowhere; Pinocchio answers NaN.",
        "Give the direction.",
    ),
    Rule(
        "M303",
        "axis-not-unit",
        "warning",
        "Every engine makes it a unit vector.",
        "Write a unit vector (--fix does).",
    ),
    Rule(
        "M304",
        "axis-missing",
        "warning",
        "URDF means x; many people mean z.",
        "Write the axis (--fix writes x).",
    ),
    Rule(
        "M305",
        "planar-axis",
        "warning",
        "Pinocchio and Drake ignore the axis of a planar joint and take z; mecanique takes "
        "the axis given.",
        "Turn the joint's origin so that the normal is z.",
    ),
    Rule(
        "M306", "inverted-limits", "error", "No position lies between them.", "Give lower ≤ upper."
    ),
    Rule(
        "M307",
        "limit-missing",
        "warning",
        "URDF demands effort and velocity of revolute and prismatic joints; Pinocchio and "
        "ROS refuse the file.",
        'Add <limit lower=… upper=… effort=… velocity=…/>, or type="continuous".',
    ),
    Rule(
        "M308",
        "locked-by-limits",
        "warning",
        "Bounds left out mean 0 in URDF.",
        "Write lower and upper.",
    ),
    Rule(
        "M309",
        "degrees",
        "warning",
        "URDF means radians everywhere.",
        "Multiply by π/180.",
    ),
    Rule(
        "M310", "millimeters", "warning", "URDF means meters everywhere.", "Divide lengths by 1000."
    ),
    Rule(
        "M311",
        "negative-damping",
        "error",
        "It would feed energy in.",
        "Give a damping of at least 0.",
    ),
    Rule(
        "M312",
        "damping-of-many",
        "error",
        "The damping of a joint with several coordinates is not modeled; equations without "
        "it would be wrong.",
        "Remove it, or put drake: dampers between points.",
    ),
    Rule(
        "M313",
        "friction",
        "warning",
        "Dry friction is left out of the equations here and in Pinocchio and Drake; MuJoCo "
        "applies it.",
        "Set it to 0, or know that it is missing.",
    ),
    Rule(
        "M314",
        "joint-dialect",
        "warning",
        "URDF readers differ on which joints stand in <joint> and which in <drake:joint>.",
        "Use <joint> for URDF's types and <drake:joint> for ball, planar and universal.",
    ),
)
