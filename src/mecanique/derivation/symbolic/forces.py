"""Forces as series: energies of springs, Rayleigh's function of dampers, virtual work of everything else."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

from mecanique.derivation.scalars.cancel import tidy
from mecanique.derivation.scalars.series import Series
from mecanique.derivation.symbolic.kinematics import Kinematics
from mecanique.derivation.symbolic.springs import Assumption, Length, length_of
from mecanique.derivation.symbolic.symbols import Algebra
from mecanique.model.expression import Scalar
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

__all__ = ["Work", "work_of"]


@final
@dataclass(frozen=True)
class Work:
    """What one force contributes to the equations of motion.

    Args:
        name: the force's name.
        kind: "potential", "dissipation" or "work".
        scalar: its energy V, its Rayleigh function D, or None.
        forces: generalized forces by coordinate: −∂V/∂q, −∂D/∂q' or the coefficients of δq in δW.
        assumptions: what these take for granted.
        length: the distance between the ends of a spring or damper that enters.
    """

    name: str
    kind: str
    scalar: Series | None
    forces: tuple[Series, ...]
    assumptions: tuple[Assumption, ...] = ()
    length: Series | None = None


def work_of(kinematics: Kinematics, force: AnyForce) -> Work:
    """Return what a force contributes.

    Args:
        kinematics: of the mechanism.
        force: one of its forces.
    """
    algebra = kinematics.algebra
    match force:
        case Spring():
            length = length_of(kinematics, force)
            k, free = algebra.series(force.stiffness), algebra.series(force.free_length)
            # without a free length the energy ½ k ρ² needs no root
            energy = (length.square if not free else (length.series - free) ** 2) * k / 2
            return _from_energy(algebra, force.name, energy, length if free else None)
        case JointSpring():
            stretch = _coordinate(algebra, force.joint) - algebra.series(force.reference)
            return _from_energy(
                algebra, force.name, algebra.series(force.stiffness) * stretch**2 / 2, None
            )
        case Damper():
            # the length enters with its square, so its sign does not matter
            distance = length_of(kinematics, force).series
            return _from_rate(algebra, force.name, force.damping, distance, distance)
        case JointDamper():
            return _from_rate(
                algebra, force.name, force.damping, _coordinate(algebra, force.joint), None
            )
        case JointForce():
            turn, drive = _coordinate(algebra, force.joint), algebra.series(force.force)
            return Work(
                force.name, "work", None, tuple(drive * slope for slope in algebra.along(turn))
            )
        case Force():
            F = kinematics.vector(force.force, force.axes, force.body)
            return _from_power(algebra, force.name, F, kinematics.velocity(force.body, force.point))
        case Torque():
            C = kinematics.vector(force.torque, force.axes, force.body)
            return _from_power(algebra, force.name, C, kinematics.spin(force.body))


def _coordinate(algebra: Algebra, joint: str) -> Series:
    (name,) = algebra.mechanism.joint(joint).coordinates
    return algebra.lifted(algebra.values[name])


def _from_energy(algebra: Algebra, name: str, energy: Series, length: Length | None) -> Work:
    assumptions = (length.assumption,) if length and length.assumption else ()
    distance = length.series if length else None
    return Work(
        name,
        "potential",
        energy,
        tuple(-slope for slope in algebra.along(energy)),
        assumptions,
        distance,
    )


def _from_rate(
    algebra: Algebra, name: str, damping: Scalar, x: Series, distance: Series | None
) -> Work:
    """Rayleigh's ½ c x'², whose ∂/∂q' is c x' ∂x/∂q."""
    c, rate = algebra.series(damping), tidy(x.ddt())
    forces = tuple(-(c * rate * slope) for slope in algebra.along(x))
    return Work(name, "dissipation", c * rate**2 / 2, forces, length=distance)


def _from_power(algebra: Algebra, name: str, force: list[Series], velocity: list[Series]) -> Work:
    """The virtual displacement along δq is ∂(velocity)/∂q'."""
    columns = zip(*(algebra.partials(component) for component in velocity), strict=True)
    pairs = [list(zip(force, column, strict=True)) for column in columns]
    return Work(
        name, "work", None, tuple(algebra.ring.sum([f * d for f, d in pair]) for pair in pairs)
    )
