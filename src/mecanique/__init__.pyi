"""The public names and where they live; `mecanique.lazy` reads this, and so do type checkers."""

from mecanique import textbook as textbook
from mecanique.checking.check import check as check
from mecanique.checking.verdict import Check as Check
from mecanique.conversion import (
    Conversion as Conversion,
    convert as convert,
)
from mecanique.derivation import (
    Reduction as Reduction,
    SingleEquation as SingleEquation,
    Solved as Solved,
    derive as derive,
    reduce_loops as reduce_loops,
    routh as routh,
)
from mecanique.derivation.equations import Equations as Equations
from mecanique.derivation.switching import derive_modes as derive_modes
from mecanique.errors import (
    ClosureError as ClosureError,
    DerivationError as DerivationError,
    EngineError as EngineError,
    FormulaError as FormulaError,
    InputError as InputError,
    IntegrationError as IntegrationError,
    MecaniqueError as MecaniqueError,
    MechanismError as MechanismError,
    UnknownNameError as UnknownNameError,
    UrdfError as UrdfError,
)
from mecanique.figure.draw import (
    Drawing as Drawing,
    picture as picture,
)
from mecanique.formats.read import read as read
from mecanique.generation import (
    Code as Code,
    generate as generate,
    write_recursion as write_recursion,
)
from mecanique.model import (
    AnyForce as AnyForce,
    Belt as Belt,
    Blade as Blade,
    Body as Body,
    Box as Box,
    Capstan as Capstan,
    CentralForce as CentralForce,
    Contact as Contact,
    Coordinates as Coordinates,
    Cord as Cord,
    Cylinder as Cylinder,
    Damper as Damper,
    Fixed as Fixed,
    Floating as Floating,
    FloatingState as FloatingState,
    Force as Force,
    Friction as Friction,
    Gear as Gear,
    Helical as Helical,
    Input as Input,
    Joint as Joint,
    JointDamper as JointDamper,
    JointForce as JointForce,
    JointSpring as JointSpring,
    Limits as Limits,
    Loop as Loop,
    Mechanism as Mechanism,
    Mesh as Mesh,
    Parameter as Parameter,
    Placement as Placement,
    Planar as Planar,
    Prismatic as Prismatic,
    Potential as Potential,
    PotentialField as PotentialField,
    Pulley as Pulley,
    Rack as Rack,
    Record as Record,
    Revolute as Revolute,
    Rolling as Rolling,
    Shape as Shape,
    Sphere as Sphere,
    Spherical as Spherical,
    Spring as Spring,
    Stop as Stop,
    Torque as Torque,
    Universal as Universal,
    VelocityConstraint as VelocityConstraint,
    Visual as Visual,
    acos as acos,
    asin as asin,
    atan as atan,
    atan2 as atan2,
    ball as ball,
    bar as bar,
    box as box,
    cloud as cloud,
    cone as cone,
    coordinate as coordinate,
    distance as distance,
    position as position,
    cos as cos,
    cylinder as cylinder,
    disk as disk,
    exp as exp,
    floating as floating,
    floating_state as floating_state,
    log as log,
    massless as massless,
    particle as particle,
    plate as plate,
    ring as ring,
    rod as rod,
    shell as shell,
    sign as sign,
    sin as sin,
    sqrt as sqrt,
    tan as tan,
    tanh as tanh,
    time as time,
    velocity as velocity,
)
from mecanique.motion import (
    Audit as Audit,
    Equilibrium as Equilibrium,
    Event as Event,
    InertialCheck as InertialCheck,
    Linearization as Linearization,
    Motion as Motion,
    Runs as Runs,
    SpeedMatrices as SpeedMatrices,
    SpeedRange as SpeedRange,
    SteadyLinearization as SteadyLinearization,
    contact_events as contact_events,
    equilibria as equilibria,
    expand_in_speed as expand_in_speed,
    frequency_response as frequency_response,
    inertial_check as inertial_check,
    linearize as linearize,
    linearize_steady as linearize_steady,
    simulate as simulate,
    simulate_many as simulate_many,
    sweep_speeds as sweep_speeds,
)
from mecanique.reference import (
    Freedom as Freedom,
    Reference as Reference,
    Wrench as Wrench,
    assemble as assemble,
    assembly_branches as assembly_branches,
    degrees_of_freedom as degrees_of_freedom,
)
from mecanique.urdf import (
    read_urdf as read_urdf,
    write_urdf as write_urdf,
)
from mecanique.urdf.lint import (
    compare_inertias as compare_inertias,
    lint as lint,
)
from mecanique.urdf.robots import (
    robot as robot,
    robots as robots,
)
from mecanique.verification import (
    Verdict as Verdict,
    verify as verify,
)
from mecanique.verification.verdict import Difference as Difference
from mecanique.verification.diff import diff as diff
from mecanique.version import __version__ as __version__
from mecanique.viewing.live.view import (
    inspect as inspect,
    view as view,
)
from mecanique.viewing.show import export as export

__all__: list[str]
