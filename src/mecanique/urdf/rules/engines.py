"""Rules on what engines make of a text: M7."""

from __future__ import annotations

from mecanique.urdf.limits import MOST_DEPTH, MOST_VELOCITIES
from mecanique.urdf.rules.rule import Rule

RULES = (
    Rule(
        "M701",
        "too-many-coordinates",
        "warning",
        "Pinocchio's memory grows with the cube of the number of coordinates (8 GB at 500).",
        f"Stay at or below {MOST_VELOCITIES} coordinates to verify against Pinocchio.",
    ),
    Rule(
        "M702",
        "too-deep",
        "warning",
        "Pinocchio crashes on chains of thousands of links.",
        f"Stay at or below {MOST_DEPTH:,}.",
    ),
    Rule(
        "M703",
        "not-used",
        "info",
        "It does not enter the equations of motion.",
        "There is nothing to mend.",
    ),
    Rule(
        "M704",
        "damping-read-differently",
        "info",
        "mecanique, Drake and MuJoCo apply it; Pinocchio reads it and does not.",
        "Know it when comparing.",
    ),
    Rule(
        "M705",
        "version",
        "warning",
        "Older parsers take only 1.0 and refuse the rest.",
        'Write version="1.0" or none.',
    ),
    Rule(
        "M706",
        "joint-read-differently",
        "info",
        "Drake leaves a floating joint's child free and refuses <joint type=planar>; MuJoCo "
        "makes planar three joints.",
        "Know it when comparing.",
    ),
)
