"""The mechanism inside Pinocchio: the reference against which the in-house derivation is checked.

Only this package imports pinocchio, and only when a `Reference` is made.
"""

from mecanique.reference.engine.answers import (
    BodyMotions,
    Energy,
    Momentum,
    PointMotion,
    Twist,
    Wrench,
)
from mecanique.reference.loops.assembly import assemble, assembly_branches
from mecanique.reference.loops.freedom import Freedom, degrees_of_freedom
from mecanique.reference.reference import Reference

__all__ = [
    "BodyMotions",
    "Energy",
    "Freedom",
    "Momentum",
    "PointMotion",
    "Reference",
    "Twist",
    "Wrench",
    "assemble",
    "assembly_branches",
    "degrees_of_freedom",
]
