"""Rules on the file, its XML and what may be read of it: M0."""

from __future__ import annotations

from mecanique.urdf.rules.rule import Rule

RULES = (
    Rule(
        "M001",
        "unreadable-file",
        "error",
        "Nothing can be read from it.",
        "Give the path of a URDF file, or its text.",
    ),
    Rule(
        "M002",
        "malformed-xml",
        "error",
        "No XML reader can go on from there.",
        "Mend the XML at this line.",
    ),
    Rule(
        "M003",
        "document-type",
        "error",
        "Entities make a text grow without bound or read other files.",
        "Remove the <!DOCTYPE …>; a URDF needs none.",
    ),
    Rule(
        "M004",
        "too-large",
        "error",
        "It would fill the memory.",
        "Split the robot, or remove what is no URDF.",
    ),
    Rule(
        "M005",
        "not-a-robot",
        "error",
        "It is no URDF.",
        "Put everything into one <robot name=…> element.",
    ),
    Rule(
        "M006",
        "unexpanded-xacro",
        "error",
        "Macros and ${…} are no numbers; engines drop or zero what they cannot read.",
        "Read the .xacro file itself (extra xacro), or expand it: xacro FILE.xacro > FILE.urdf.",
    ),
    Rule(
        "M007",
        "late-declaration",
        "error",
        "XML allows nothing before its declaration, and strict readers refuse the file.",
        "Remove what stands before <?xml … ?>.",
    ),
)
