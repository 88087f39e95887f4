"""Rules on the tags of Drake and of mecanique: M6."""

from __future__ import annotations

from mecanique.urdf.rules.rule import Rule

RULES = (
    Rule(
        "M601",
        "unknown-drake-tag",
        "warning",
        "Neither mecanique nor Drake may know it.",
        "Correct the spelling.",
    ),
    Rule(
        "M602",
        "drake-value",
        "error",
        "The force is not what was meant.",
        "Give every value Drake asks for.",
    ),
    Rule("M603", "drake-unknown-name", "error", "The force acts on nothing.", "Correct the name."),
    Rule(
        "M604",
        "not-modeled",
        "error",
        "Equations without it would be those of another mechanism.",
        "Remove it to derive the open tree.",
    ),
    Rule(
        "M605",
        "bushing",
        "error",
        "A bushing is modeled where it equals a spring and damper in one joint: "
        "its two frames coincide at the joint and the joint's axis is one of theirs.",
        "Place both frames at the joint, one on its parent, one on its child.",
    ),
    Rule(
        "M606",
        "drake-only",
        "info",
        "Pinocchio and MuJoCo ignore all drake: tags.",
        "Know it when comparing.",
    ),
    Rule(
        "M607",
        "drake-namespace",
        "warning",
        "Strict XML readers refuse a prefix that is not declared.",
        'Add xmlns:drake="http://drake.mit.edu" to <robot> (--fix does).',
    ),
    Rule(
        "M608",
        "rotor",
        "info",
        "The rotor adds inertia × ratio² at the joint in mecanique and Drake; Pinocchio and "
        "MuJoCo ignore it.",
        "Know it when comparing.",
    ),
    Rule(
        "M609",
        "drake-differs",
        "info",
        "The same tag gives another force in Drake.",
        "Know it when comparing.",
    ),
    Rule(
        "M610",
        "mecanique-only",
        "info",
        "Other programs ignore it: they see loops open and bodies slip, and do not know what "
        "guides mimic joints.",
        "Know it when comparing.",
    ),
)
