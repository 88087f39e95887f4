"""Write forces as series: a spring's energy, a damper's Rayleigh function, the work of others."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import final

from mecanique.derivation.laws import Elastic, Law, laws_of
from mecanique.derivation.scalars.series import Series
from mecanique.derivation.symbolic.kinematics import Kinematics
from mecanique.derivation.symbolic.lines_of_action import Assumption, Span, Travel
from mecanique.derivation.symbolic.symbols import Algebra
from mecanique.derivation.symbolic.vectors import Vector
from mecanique.model.force_base import AnyForce, BodyLoad, LineLoad, WrenchOnBody


@final
@dataclass(frozen=True)
class Work:
    """The contribution of one force to the equations of motion.

    Args:
        name: the force's name.
        kind: "potential", "dissipation" or "work".
        scalar: its energy V, its Rayleigh function D, or None.
        forces: generalized forces by coordinate: −∂V/∂q, −∂D/∂q' or the coefficients of δq in δW.
        assumptions: the assumptions of these expressions.
        length: the distance between the ends of a spring or damper, if it occurs.
        square: stiffness k and elongation x of a spring with the energy ½ k x².
    """

    name: str
    kind: str
    scalar: Series | None
    forces: tuple[Series, ...]
    assumptions: tuple[Assumption, ...] = ()
    length: Series | None = None
    square: tuple[Series, Series] | None = None


def works_of(kinematics: Kinematics, force: AnyForce) -> Iterator[Work]:
    """Yield the contributions of a force, law by law."""
    algebra = kinematics.algebra
    if isinstance(force, BodyLoad):
        yield _find_work(kinematics, force.name, force.wrench)
        return
    for law in laws_of(force, algebra.series):
        along = (
            Span(kinematics, force)
            if isinstance(force, LineLoad)
            else Travel.in_joint(algebra, force.joint)
        )
        scalar = law.scalar(along)
        forces = _find_forces(algebra, law, along, scalar)
        # in the other laws only the square of the length occurs, so its sign does not matter
        taken = along.assumption if law.kind == "potential" else None
        assumptions = () if taken is None else (taken,)
        square = _find_square(law, along)
        yield Work(
            name=force.name,
            kind=law.kind,
            scalar=scalar,
            forces=forces,
            assumptions=assumptions,
            length=along.length,
            square=square,
        )


def _find_square(law: Law, along: Span | Travel) -> tuple[Series, Series] | None:
    """Return stiffness and elongation of a spring with a free length or in a joint, else None."""
    if not isinstance(law, Elastic) or not (law.rest or isinstance(along, Travel)):
        return None
    return law.stiffness, along.x - law.rest


def _find_forces(
    algebra: Algebra, law: Law, along: Span | Travel, scalar: Series | None
) -> tuple[Series, ...]:
    """Return the generalized forces: −∂V/∂q of a potential, −f ∂x/∂q of a pull f."""
    if law.kind == "potential" and scalar is not None:
        return tuple(-slope for slope in algebra.ring.along(scalar))
    pull = law.pull(Travel(along.x))
    return tuple(-(pull * slope) for slope in algebra.ring.along(along.x))


def _find_work(kinematics: Kinematics, name: str, wrench: WrenchOnBody) -> Work:
    """Return the work F·δr + C·δφ; the virtual displacement along δq is ∂(velocity)/∂q'."""
    algebra, body = kinematics.algebra, wrench.body
    works: list[list[Series]] = [[] for _ in algebra.velocities]

    def add(force: Vector, motion: Vector) -> None:
        for component, rate in zip(force, motion, strict=True):
            for work, slope in zip(works, algebra.ring.partials(rate), strict=True):
                work.append(component * slope)

    if wrench.force is not None:
        F = kinematics.vector(wrench.force, wrench.axes, body)
        add(F, kinematics.velocity(body, wrench.point))
    if wrench.torque is not None:
        C = kinematics.vector(wrench.torque, wrench.axes, body)
        add(C, kinematics.spin(body))
    return Work(name, "work", None, tuple(map(algebra.ring.sum, works)))
