"""Rules on masses, centers of mass and inertias: M2."""

from __future__ import annotations

from mecanique.urdf.rules.rule import Rule

RULES = (
    Rule(
        "M201",
        "negative-mass",
        "error",
        "No body weighs less than nothing.",
        "Give a mass of at least 0 kg.",
    ),
    Rule(
        "M202",
        "negative-inertia",
        "error",
        "Kinetic energy may be negative; MuJoCo refuses, Drake warns and puts in a ball of water "
        "of the same mass.",
        "Compute the inertia again (--fix --balance writes the nearest one of a real body).",
    ),
    Rule(
        "M203",
        "triangle-inequality",
        "error",
        "No distribution of mass has these principal moments; Pinocchio takes them silently, "
        "MuJoCo refuses, Drake warns and puts in a ball of water of the same mass.",
        "Compute the inertia about the center of mass again, with enough digits (--fix --balance "
        "writes the nearest one of a real body).",
    ),
    Rule(
        "M204",
        "inertia-without-mass",
        "warning",
        "A body that resists turning has mass; MuJoCo refuses it, Drake warns and puts in a ball "
        "of water of 1 kg.",
        "Give the mass, with enough digits.",
    ),
    Rule(
        "M205",
        "point-mass",
        "info",
        "It does not resist turning; Pinocchio's forward dynamics fails where nothing else does.",
        "Give the inertia about the center of mass.",
    ),
    Rule(
        "M206",
        "massless-motion",
        "warning",
        "The mass matrix is singular: accelerations are undetermined, Pinocchio answers NaN, "
        "MuJoCo refuses.",
        "Give the moving links mass, or make the joint fixed.",
    ),
    Rule(
        "M207",
        "tiny-mass",
        "warning",
        "Pinocchio loses the lever of masses below 2.2e-16 kg, silently.",
        "Use other units, or drop the mass.",
    ),
    Rule(
        "M208",
        "inertia-units",
        "warning",
        "Inertias in g·mm², kg·mm² or about another point are the most common mistakes in "
        "URDF files.",
        "Give kg·m² about the center of mass.",
    ),
    Rule(
        "M209",
        "mass-units",
        "warning",
        "A mass in grams is a thousand times too heavy.",
        "Give the mass in kg.",
    ),
    Rule(
        "M210",
        "inertia-about-wrong-point",
        "warning",
        "URDF means the inertia about the center of mass, where <inertial><origin> puts it.",
        "Give the center in <inertial><origin> and the inertia about it.",
    ),
    Rule(
        "M211",
        "root-mass",
        "info",
        "With a fixed root it moves nothing, and ROS warns about it; with a floating root it "
        "counts.",
        "Leave it, or put an empty root link before it.",
    ),
    Rule(
        "M212",
        "sides-differ",
        "warning",
        "A slip in one of two sides, such as a sign that was not mirrored, escapes every engine.",
        "Compare both links: mirrored at the plane x–z, y, ixy and iyz change their signs.",
    ),
    Rule(
        "M213",
        "center-outside",
        "warning",
        "A center of mass outside of the body is likely in other units or another frame.",
        "Give the center in the link's frame, in meters (`mecanique inertia` computes it).",
    ),
    Rule(
        "M214",
        "density",
        "warning",
        "No material is denser than osmium, and no part lighter than air.",
        "Compare mass and shape, e.g. their units (`mecanique inertia`).",
    ),
)
