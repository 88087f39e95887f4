"""State the law of each spring, damper and drive, independently of the derivation.

A spring pulls its ends together with k (l − l₀), a damper with c dl/dt, along the line between
them; a spring in a joint exerts −k (r − r₀), a damper −c r' (Meirovitch, Elements of Vibration
Analysis, sect. 1-2).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

from mecanique.errors import EngineError
from mecanique.model.expression import Scalar
from mecanique.model.force_base import JointLoad, LineLoad
from mecanique.model.forces import (
    CentralForce,
    Damper,
    JointDamper,
    JointForce,
    JointSpring,
    Potential,
    Spring,
)


@final
@dataclass(frozen=True)
class Law:
    """A force along x, a length or a coordinate: −k (x − x₀) − c x' + F − dV/dx."""

    stiffness: Scalar = 0.0  # k
    rest: Scalar = 0.0  # x₀
    damping: Scalar = 0.0  # c
    drive: Scalar | None = None  # F, which may depend on the state and time; None if there is none
    potential: Scalar | None = None  # V(x), which adds -dV/dx; None if there is none


def law_of(force: LineLoad | JointLoad) -> Law:
    """Return the law of a spring, a damper or a drive."""
    match force:
        case Spring():
            return Law(stiffness=force.stiffness, rest=force.free_length)
        case JointSpring():
            return Law(stiffness=force.stiffness, rest=force.reference)
        case Damper() | JointDamper():
            return Law(damping=force.damping)
        case CentralForce() | Potential():
            return Law(potential=force.potential)
        case JointForce():
            return Law(drive=force.force)
    raise EngineError(f"no law is known for force {force.name!r}, a {type(force).__name__}")
