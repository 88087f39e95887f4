"""Rules on joints that follow another: M4."""

from __future__ import annotations

from mecanique.urdf.rules.rule import Rule

RULES = (
    Rule(
        "M401",
        "mimic-unknown",
        "error",
        "It follows a joint that is not there.",
        "Correct the name.",
    ),
    Rule(
        "M402",
        "mimic-cycle",
        "error",
        "The joints would follow themselves.",
        "Let one of them move freely.",
    ),
    Rule(
        "M403",
        "mimic-kind",
        "error",
        "Only joints with one coordinate can follow or be followed.",
        "Remove the <mimic>.",
    ),
    Rule(
        "M404",
        "mimic-read-differently",
        "info",
        "MuJoCo up to 3.12 drops <mimic>, Pinocchio only obeys it when asked (mimic=True); "
        "mecanique and Drake obey.",
        "Know it when comparing.",
    ),
    Rule(
        "M405",
        "mimic-chain",
        "warning",
        "Pinocchio refuses joints that mimic a mimicking joint; mecanique composes them.",
        "Mimic the joint that moves freely.",
    ),
    Rule(
        "M406",
        "mimic-constant",
        "warning",
        "With multiplier 0 the joint stands still.",
        "Use type fixed.",
    ),
    Rule(
        "M407",
        "mimic-fixed",
        "warning",
        "A fixed joint cannot follow; the <mimic> is left out.",
        "Remove the <mimic>, or let the joint move.",
    ),
)
