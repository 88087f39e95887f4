"""What a mechanism is: parameters, shapes, bodies, joints, forces, coordinates. Frozen data."""

from mecanique.model.bodies import Body
from mecanique.model.bodies.body import Shape
from mecanique.model.bodies.shapes import (
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
from mecanique.model.constraints.contacts import Blade, Rolling
from mecanique.model.constraints.cords import Belt, Cord, Pulley
from mecanique.model.constraints.friction import Capstan, Contact, Friction, Stop
from mecanique.model.constraints.gears import Gear, Rack
from mecanique.model.constraints.loops import Loop
from mecanique.model.constraints.velocity_constraints import VelocityConstraint
from mecanique.model.coordinates import Coordinates
from mecanique.model.expression import coordinate, distance, position, time, velocity
from mecanique.model.force_base import AnyForce
from mecanique.model.forces import (
    CentralForce,
    Damper,
    Force,
    JointDamper,
    JointForce,
    JointSpring,
    Potential,
    PotentialField,
    Spring,
    Torque,
)
from mecanique.model.free_bodies import FloatingState, floating, floating_state
from mecanique.model.functions import (
    acos,
    asin,
    atan,
    atan2,
    cos,
    exp,
    log,
    sign,
    sin,
    sqrt,
    tan,
    tanh,
)
from mecanique.model.joint_base import Limits
from mecanique.model.joints import (
    Fixed,
    Floating,
    Helical,
    Joint,
    Planar,
    Prismatic,
    Revolute,
    Spherical,
    Universal,
)
from mecanique.model.mechanism import Mechanism
from mecanique.model.parameters import Input, Parameter, Record
from mecanique.model.placement import Placement

__all__ = [
    "AnyForce",
    "Belt",
    "Blade",
    "Body",
    "Box",
    "Capstan",
    "CentralForce",
    "Contact",
    "Coordinates",
    "Cord",
    "Cylinder",
    "Damper",
    "Fixed",
    "Floating",
    "FloatingState",
    "Force",
    "Friction",
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
    "Potential",
    "PotentialField",
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
    "Stop",
    "Torque",
    "Universal",
    "VelocityConstraint",
    "Visual",
    "acos",
    "asin",
    "atan",
    "atan2",
    "ball",
    "bar",
    "box",
    "cloud",
    "cone",
    "coordinate",
    "cos",
    "cylinder",
    "disk",
    "distance",
    "exp",
    "floating",
    "floating_state",
    "log",
    "massless",
    "particle",
    "plate",
    "position",
    "ring",
    "rod",
    "shell",
    "sign",
    "sin",
    "sqrt",
    "tan",
    "tanh",
    "time",
    "velocity",
]
