"""Equations of motion: derived independently, checked against an engine, then set in motion."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from mecanique import viewing  # noqa: F401 lets motions show themselves; imports no numpy
from mecanique.lazy import find_homes, import_name

if TYPE_CHECKING:
    from mecanique import textbook
    from mecanique.checking.check import check
    from mecanique.checking.verdict import Check
    from mecanique.derivation import Reduction, SingleEquation, derive, reduce_loops, routh
    from mecanique.derivation.equations import Equations
    from mecanique.errors import (
        ClosureError,
        DerivationError,
        EngineError,
        FormulaError,
        InputError,
        IntegrationError,
        MecaniqueError,
        MechanismError,
        UnknownNameError,
        UrdfError,
    )
    from mecanique.generation import Code, generate, write_recursion
    from mecanique.model import (
        AnyForce,
        Belt,
        Blade,
        Body,
        Box,
        Coordinates,
        Cord,
        Cylinder,
        Damper,
        Fixed,
        Floating,
        FloatingState,
        Force,
        Gear,
        Helical,
        Input,
        Joint,
        JointDamper,
        JointForce,
        JointSpring,
        Limits,
        Loop,
        Mechanism,
        Mesh,
        Parameter,
        Placement,
        Planar,
        Prismatic,
        Pulley,
        Rack,
        Record,
        Revolute,
        Rolling,
        Shape,
        Sphere,
        Spherical,
        Spring,
        Torque,
        Universal,
        VelocityConstraint,
        Visual,
        acos,
        asin,
        atan,
        atan2,
        ball,
        bar,
        box,
        cloud,
        cone,
        coordinate,
        cos,
        cylinder,
        disk,
        exp,
        floating,
        floating_state,
        log,
        massless,
        particle,
        plate,
        ring,
        rod,
        shell,
        sign,
        sin,
        sqrt,
        tan,
        tanh,
        time,
        velocity,
    )
    from mecanique.motion import (
        Audit,
        Equilibrium,
        Event,
        InertialCheck,
        Linearization,
        Motion,
        Runs,
        SpeedMatrices,
        SpeedRange,
        SteadyLinearization,
        contact_events,
        equilibria,
        expand_in_speed,
        frequency_response,
        inertial_check,
        linearize,
        linearize_steady,
        simulate,
        simulate_many,
        sweep_speeds,
    )
    from mecanique.reference import (
        Freedom,
        Reference,
        Wrench,
        assemble,
        assembly_branches,
        degrees_of_freedom,
    )
    from mecanique.urdf import read_urdf, write_urdf
    from mecanique.urdf.lint import compare_inertias, lint
    from mecanique.urdf.robots import robot, robots
    from mecanique.verification import Verdict, verify
    from mecanique.verification.change import Difference
    from mecanique.verification.diff import diff

__all__ = [
    "AnyForce",
    "Audit",
    "Belt",
    "Blade",
    "Body",
    "Box",
    "Check",
    "ClosureError",
    "Code",
    "Coordinates",
    "Cord",
    "Cylinder",
    "Damper",
    "DerivationError",
    "Difference",
    "EngineError",
    "Equations",
    "Equilibrium",
    "Event",
    "Fixed",
    "Floating",
    "FloatingState",
    "Force",
    "FormulaError",
    "Freedom",
    "Gear",
    "Helical",
    "InertialCheck",
    "Input",
    "InputError",
    "IntegrationError",
    "Joint",
    "JointDamper",
    "JointForce",
    "JointSpring",
    "Limits",
    "Linearization",
    "Loop",
    "MecaniqueError",
    "Mechanism",
    "MechanismError",
    "Mesh",
    "Motion",
    "Parameter",
    "Placement",
    "Planar",
    "Prismatic",
    "Pulley",
    "Rack",
    "Record",
    "Reduction",
    "Reference",
    "Revolute",
    "Rolling",
    "Runs",
    "Shape",
    "SingleEquation",
    "SpeedMatrices",
    "SpeedRange",
    "Sphere",
    "Spherical",
    "Spring",
    "SteadyLinearization",
    "Torque",
    "Universal",
    "UnknownNameError",
    "UrdfError",
    "VelocityConstraint",
    "Verdict",
    "Visual",
    "Wrench",
    "acos",
    "asin",
    "assemble",
    "assembly_branches",
    "atan",
    "atan2",
    "ball",
    "bar",
    "box",
    "check",
    "cloud",
    "compare_inertias",
    "cone",
    "contact_events",
    "coordinate",
    "cos",
    "cylinder",
    "degrees_of_freedom",
    "derive",
    "diff",
    "disk",
    "equilibria",
    "exp",
    "expand_in_speed",
    "export",
    "floating",
    "floating_state",
    "frequency_response",
    "generate",
    "inertial_check",
    "inspect",
    "linearize",
    "linearize_steady",
    "lint",
    "log",
    "massless",
    "particle",
    "picture",
    "plate",
    "read_urdf",
    "reduce_loops",
    "ring",
    "robot",
    "robots",
    "rod",
    "routh",
    "shell",
    "sign",
    "simulate",
    "simulate_many",
    "sin",
    "sqrt",
    "sweep_speeds",
    "tan",
    "tanh",
    "textbook",
    "time",
    "velocity",
    "verify",
    "view",
    "write_recursion",
    "write_urdf",
]

_HOMES = find_homes(
    {
        "mecanique.checking.check": "check",
        "mecanique.checking.verdict": "Check",
        "mecanique.derivation": "Reduction SingleEquation derive reduce_loops routh",
        "mecanique.derivation.equations": "Equations",
        "mecanique.errors": """
            ClosureError DerivationError EngineError FormulaError InputError IntegrationError
            MecaniqueError MechanismError UnknownNameError UrdfError
        """,
        "mecanique.figure.draw": "picture",
        "mecanique.generation": "Code generate write_recursion",
        "mecanique.model": """
            AnyForce Belt Blade Body Box Coordinates Cord Cylinder Damper Fixed Floating
            FloatingState Force Gear Helical Input Joint JointDamper JointForce JointSpring
            Limits Loop Mechanism Mesh Parameter Placement Planar Prismatic Pulley Rack Record
            Revolute Rolling Shape Sphere Spherical Spring Torque Universal VelocityConstraint
            Visual acos asin atan atan2 ball bar box cloud cone coordinate cos cylinder disk exp
            floating floating_state log massless particle plate ring rod shell sign sin sqrt tan
            tanh time velocity
        """,
        "mecanique.motion": """
            Audit Equilibrium Event InertialCheck Linearization Motion Runs SpeedMatrices
            SpeedRange SteadyLinearization contact_events equilibria expand_in_speed
            frequency_response inertial_check linearize linearize_steady simulate simulate_many
            sweep_speeds
        """,
        "mecanique.reference": """
            Freedom Reference Wrench assemble assembly_branches degrees_of_freedom
        """,
        "mecanique.urdf": "read_urdf write_urdf",
        "mecanique.urdf.lint": "compare_inertias lint",
        "mecanique.urdf.robots": "robot robots",
        "mecanique.verification": "Verdict verify",
        "mecanique.verification.change": "Difference",
        "mecanique.verification.diff": "diff",
        "mecanique.viewing.live.view": "inspect view",
        "mecanique.viewing.show": "export",
    }
)
"""The homes of the public names, each imported on first use."""


def __getattr__(name: str) -> Any:
    if name == "__version__":
        return import_module("mecanique.version").__version__
    if name == "textbook":
        return import_module("mecanique.textbook")
    from mecanique.doors import explain

    value = globals()[name] = explain(import_name(__name__, name, _HOMES), __name__)
    return value


def __dir__() -> list[str]:
    return sorted([*__all__, "__version__"])
