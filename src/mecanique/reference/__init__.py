"""The mechanism inside Pinocchio: the reference that the in-house derivation is checked against.

This room is the only place that imports pinocchio, and it does so when a `Reference` is made.
"""

from mecanique.reference.answers import Energy, Momentum, PointMotion, Wrench
from mecanique.reference.reference import Reference

__all__ = ["Energy", "Momentum", "PointMotion", "Reference", "Wrench"]
