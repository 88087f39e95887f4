"""Rules on meshes, shapes and colors: M5."""

from __future__ import annotations

from mecanique.urdf.rules.rule import Rule

RULES = (
    Rule(
        "M501",
        "mesh-not-found",
        "warning",
        "It is not drawn.",
        "Add its package's folder to --package-path, ROS_PACKAGE_PATH or AMENT_PREFIX_PATH.",
    ),
    Rule(
        "M502",
        "mesh-outside",
        "error",
        "A path that climbs out of its package could read any file.",
        "Write package://PACKAGE/… without '..'.",
    ),
    Rule("M503", "no-shape", "warning", "It is not drawn.", "Use box, cylinder, sphere or mesh."),
    Rule("M504", "flat-shape", "warning", "It is not drawn.", "Give positive sizes."),
    Rule(
        "M505",
        "unknown-material",
        "warning",
        "It is drawn in its mesh's own color or none.",
        "Describe the material.",
    ),
    Rule("M506", "color-range", "warning", "Colors run from 0 to 1.", "Divide by 255."),
    Rule(
        "M507",
        "collision-unused",
        "info",
        "Contact is not modeled: bodies pass through one another; MuJoCo and Drake collide them.",
        "Know it when comparing.",
    ),
    Rule(
        "M508",
        "unreadable-mesh",
        "warning",
        "Neither its volume nor its inertia is known, and no page shows it.",
        "Write it as STL, OBJ or COLLADA again.",
    ),
)
