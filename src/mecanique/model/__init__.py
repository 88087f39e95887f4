"""What a mechanism is: parameters, shapes, bodies, joints, forces, coordinates. Frozen data."""

from mecanique.model.bodies import Body
from mecanique.model.bodies.shapes import (
    Shape,
    ball,
    bar,
    box,
    cloud,
    cone,
    cylinder,
    disk,
    massless,
    particle,
    plate,
    ring,
    rod,
    shell,
)
from mecanique.model.bodies.visuals import Box, Cylinder, Mesh, Sphere, Visual
from mecanique.model.contacts import Blade, Rolling
from mecanique.model.coordinates import Coordinates
from mecanique.model.elements import Cord, Gear, Pulley, Rack
from mecanique.model.expression import coordinate, time, velocity
from mecanique.model.forces import (
    AnyForce,
    Damper,
    Force,
    JointDamper,
    JointForce,
    JointSpring,
    Spring,
    Torque,
)
from mecanique.model.free_body import FloatingState, floating, floating_state
from mecanique.model.joints import (
    Fixed,
    Floating,
    Helical,
    Joint,
    Limits,
    Planar,
    Prismatic,
    Revolute,
    Spherical,
    Universal,
)
from mecanique.model.loops import Loop
from mecanique.model.mechanism import Mechanism
from mecanique.model.parameters import Input, Parameter, Record
from mecanique.model.placement import Placement
from mecanique.model.velocity_constraints import VelocityConstraint

__all__ = [
    "AnyForce",
    "Blade",
    "Body",
    "Box",
    "Coordinates",
    "Cord",
    "Cylinder",
    "Damper",
    "Fixed",
    "Floating",
    "FloatingState",
    "Force",
    "Gear",
    "Helical",
    "Input",
    "Joint",
    "JointDamper",
    "JointForce",
    "JointSpring",
    "Limits",
    "Loop",
    "Mechanism",
    "Mesh",
    "Parameter",
    "Placement",
    "Planar",
    "Prismatic",
    "Pulley",
    "Rack",
    "Record",
    "Revolute",
    "Rolling",
    "Shape",
    "Sphere",
    "Spherical",
    "Spring",
    "Torque",
    "Universal",
    "VelocityConstraint",
    "Visual",
    "ball",
    "bar",
    "box",
    "cloud",
    "cone",
    "coordinate",
    "cylinder",
    "disk",
    "floating",
    "floating_state",
    "massless",
    "particle",
    "plate",
    "ring",
    "rod",
    "shell",
    "time",
    "velocity",
]
