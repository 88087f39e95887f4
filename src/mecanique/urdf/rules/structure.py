"""Rules on elements, names and the tree of links: M1."""

from __future__ import annotations

from mecanique.urdf.rules.rule import Rule

RULES = (
    Rule(
        "M101", "no-robot-name", "error", "URDF parsers refuse the file.", "Add name=… to <robot>."
    ),
    Rule("M102", "no-links", "error", "There is nothing to move.", "Describe at least one <link>."),
    Rule(
        "M103",
        "missing",
        "error",
        "Engines drop the element or take a silent default.",
        "Write it out.",
    ),
    Rule(
        "M104",
        "bad-number",
        "error",
        "Pinocchio drops the whole inertial at an unreadable number, others take zero.",
        "Write plain numbers with a decimal point, separated by spaces.",
    ),
    Rule(
        "M105", "bad-name", "error", "Nothing can refer to it safely.", "Give it a printable name."
    ),
    Rule(
        "M106",
        "duplicate-name",
        "error",
        "It is unclear which one is meant.",
        "Rename one of them.",
    ),
    Rule(
        "M107",
        "unknown-link",
        "error",
        "The joint hangs in the air.",
        "Correct the name or add the link.",
    ),
    Rule(
        "M108",
        "self-joint",
        "error",
        "A link cannot move against itself.",
        "Give the joint another child.",
    ),
    Rule(
        "M109",
        "two-parents",
        "error",
        "URDF describes trees; a second parent would close a loop.",
        "Keep one of the joints.",
    ),
    Rule(
        "M110",
        "cycle",
        "error",
        "No link of the cycle hangs on the root; Pinocchio drops them.",
        "Open the cycle.",
    ),
    Rule(
        "M111",
        "disconnected",
        "error",
        "A URDF has one root; the rest would vanish or be refused.",
        "Join all parts by joints to one root.",
    ),
    Rule(
        "M112", "duplicate-element", "error", "Engines read the first or the last one.", "Keep one."
    ),
    Rule(
        "M113",
        "misspelt",
        "warning",
        "What is misspelt is silently ignored by every engine.",
        "Correct the spelling.",
    ),
    Rule(
        "M114",
        "reserved-name",
        "warning",
        "The name has a meaning of its own in an engine: the link or joint may be mistaken "
        "or ignored.",
        "Choose another name.",
    ),
    Rule(
        "M115",
        "not-sound",
        "error",
        "The equations of motion would be meaningless.",
        "See the message.",
    ),
    Rule(
        "M116",
        "blank-in-number",
        "warning",
        "urdfdom, the parser of Pinocchio and ROS, reads no number with a blank behind it, and no "
        "vector with tabs or line breaks; others do.",
        "Separate numbers by single blanks, with none around them (--fix does).",
    ),
)
