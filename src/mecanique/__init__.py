"""Every equation of motion, derived independently, checked against an engine, then set in motion."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from mecanique import textbook
from mecanique.derivation import derive
from mecanique.errors import (
    ClosureError,
    DerivationError,
    EngineError,
    InputError,
    IntegrationError,
    MecaniqueError,
    MechanismError,
    UnknownNameError,
    UrdfError,
)
from mecanique.model import (
    AnyForce,
    Body,
    Box,
    Coordinates,
    Cylinder,
    Damper,
    Fixed,
    Floating,
    Force,
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
    Record,
    Revolute,
    Shape,
    Sphere,
    Spherical,
    Spring,
    Torque,
    Universal,
    VelocityConstraint,
    Visual,
    ball,
    bar,
    box,
    cloud,
    cone,
    coordinate,
    cylinder,
    disk,
    massless,
    particle,
    plate,
    ring,
    rod,
    shell,
    time,
    velocity,
)
from mecanique.verification import Verdict, verify
from mecanique.viewing import export, picture, view

if TYPE_CHECKING:
    from mecanique.derivation.equations import Equations
    from mecanique.motion import (
        Audit,
        Equilibrium,
        Event,
        InertialCheck,
        Linearization,
        Motion,
        Runs,
        equilibria,
        frequency_response,
        inertial_check,
        linearize,
        simulate,
        simulate_many,
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
    from mecanique.urdf.lint import lint
    from mecanique.urdf.robots import robot, robots

__all__ = [
    "AnyForce",
    "Audit",
    "Body",
    "Box",
    "ClosureError",
    "Coordinates",
    "Cylinder",
    "Damper",
    "DerivationError",
    "EngineError",
    "Equations",
    "Equilibrium",
    "Event",
    "Fixed",
    "Floating",
    "Force",
    "Freedom",
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
    "Record",
    "Reference",
    "Revolute",
    "Runs",
    "Shape",
    "Sphere",
    "Spherical",
    "Spring",
    "Torque",
    "Universal",
    "UnknownNameError",
    "UrdfError",
    "VelocityConstraint",
    "Verdict",
    "Visual",
    "Wrench",
    "assemble",
    "assembly_branches",
    "ball",
    "bar",
    "box",
    "cloud",
    "cone",
    "coordinate",
    "cylinder",
    "degrees_of_freedom",
    "derive",
    "disk",
    "equilibria",
    "export",
    "frequency_response",
    "inertial_check",
    "linearize",
    "lint",
    "massless",
    "particle",
    "picture",
    "plate",
    "read_urdf",
    "ring",
    "robot",
    "robots",
    "rod",
    "shell",
    "simulate",
    "simulate_many",
    "textbook",
    "time",
    "velocity",
    "verify",
    "view",
    "write_urdf",
]

_HOMES = {
    "Audit": "mecanique.motion",
    "Equations": "mecanique.derivation.equations",
    "Equilibrium": "mecanique.motion",
    "Event": "mecanique.motion",
    "Freedom": "mecanique.reference",
    "Linearization": "mecanique.motion",
    "Motion": "mecanique.motion",
    "Reference": "mecanique.reference",
    "Runs": "mecanique.motion",
    "Wrench": "mecanique.reference",
    "assemble": "mecanique.reference",
    "assembly_branches": "mecanique.reference",
    "degrees_of_freedom": "mecanique.reference",
    "equilibria": "mecanique.motion",
    "frequency_response": "mecanique.motion",
    "inertial_check": "mecanique.motion",
    "InertialCheck": "mecanique.motion",
    "linearize": "mecanique.motion",
    "lint": "mecanique.urdf.lint",
    "read_urdf": "mecanique.urdf",
    "robot": "mecanique.urdf.robots",
    "robots": "mecanique.urdf.robots",
    "simulate": "mecanique.motion",
    "simulate_many": "mecanique.motion",
    "write_urdf": "mecanique.urdf",
}
"""Where the names are that are imported only when somebody asks for them."""


def __getattr__(name: str) -> Any:
    if name == "__version__":
        from importlib.metadata import version

        return version("mecanique")
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    value = getattr(import_module(_HOMES[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__, "__version__"})
