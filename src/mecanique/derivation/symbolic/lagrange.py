"""Derive Lagrange's equations in Poisson series: d/dt ∂T/∂q' − ∂T/∂q + ∂V/∂q + ∂D/∂q' = Q.

The velocities ω, or v and ω, of a joint with a quaternion are quasi-velocities, not rates of
coordinates; for them the operator has the additional terms of Euler and Kirchhoff, ω × ∂T/∂ω +
v × ∂T/∂v (H. Lamb, Hydrodynamics, 1932, art. 124, eqs. 2).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import final

from mecanique.derivation.scalars.cancel import by_velocity, tidy
from mecanique.derivation.scalars.series import Series
from mecanique.derivation.symbolic.derivation import Derivation, mass_and_bias
from mecanique.derivation.symbolic.forces import works_of
from mecanique.derivation.symbolic.kinematics import Kinematics
from mecanique.derivation.symbolic.lines_of_action import length_names
from mecanique.derivation.symbolic.redundancy import redundancy_stages
from mecanique.derivation.symbolic.steps.constraints import loop_stages, multiplier_stages
from mecanique.derivation.symbolic.steps.energies import energy_integral, energy_stages
from mecanique.derivation.symbolic.steps.kinematics import geometry_stages, quaternion_stages
from mecanique.derivation.symbolic.steps.operator import coordinate_stages, work_stages
from mecanique.derivation.symbolic.symbols import Algebra
from mecanique.derivation.symbolic.ties.contacts import contact_ties, touches
from mecanique.derivation.symbolic.ties.loops import loop_ties
from mecanique.derivation.symbolic.vectors import Vector, cross
from mecanique.derivation.tree.poses import combination
from mecanique.errors import DerivationError
from mecanique.model.mechanism import Mechanism


@final
class Lagrange:
    """Energies, dissipation and virtual work as series, with Lagrange's operator applied to them.

    Args:
        mechanism: any mechanism.
        algebra: its symbols, if they exist already.

    Raises:
        DerivationError: if the mechanism has no closed form of reasonable length.
    """

    def __init__(self, mechanism: Mechanism, algebra: Algebra | None = None) -> None:
        self.algebra = algebra = algebra or Algebra(mechanism)
        self.kinematics = Kinematics(algebra)
        self._touches = touches(self.kinematics)
        rolling = contact_ties(self.kinematics, self._touches)
        self.ties = (*loop_ties(self.kinematics), *rolling)
        for tie in rolling:
            _ = tie.second  # raises unless Φ'' has a closed form, too
        self.works = [
            work for force in mechanism.forces for work in works_of(self.kinematics, force)
        ]
        self.kinetic = [*self._bodies(), *self._rotors()]
        self.T = tidy(algebra.ring.sum([series for _, series in self.kinetic]))
        self.gravity = tidy(algebra.ring.sum(self._weights()))
        self.V = tidy(self.gravity + self._sum("potential"))
        self.D = self._sum("dissipation")

    def derivation(self) -> Derivation:
        """Return the equations of motion with their steps."""
        algebra = self.algebra
        ring, names = algebra.ring, algebra.velocities
        operated = ring.euler(self.T)
        turning = self._find_turning([E.momentum for E in operated])
        falls = ring.along(self.gravity)
        inertia = [
            E.value + terms + fall for E, terms, fall in zip(operated, turning, falls, strict=True)
        ]
        M, h = mass_and_bias(algebra, inertia)
        loads = []
        for k in range(len(names)):
            loads.append(ring.sum([work.forces[k] for work in self.works]))
        return Derivation(
            algebra=algebra,
            M=M,
            h=h,
            Q=tuple(by_velocity(load, names) for load in loads),
            stages=(
                *quaternion_stages(algebra),
                *geometry_stages(self.kinematics),
                *energy_stages(
                    self.kinetic,
                    self.T,
                    self.gravity,
                    self.works,
                    self.V,
                    heavy=any(algebra.mechanism.gravity),
                ),
                *work_stages(algebra, self.works, self.D),
                *loop_stages(self.ties),
                *redundancy_stages(algebra.mechanism),
                *coordinate_stages(
                    names,
                    operated,
                    turning,
                    ring.along(self.V),
                    ring.partials(self.D),
                    self.find_free(),
                ),
                *energy_integral(self.T, self.gravity, self.V, self.D, self.works, self.ties),
                *multiplier_stages(
                    algebra, M, [a - b for a, b in zip(h, loads, strict=True)], self.ties
                ),
            ),
            assumptions=(
                *(a for work in self.works for a in work.assumptions),
                *(a for touch in self._touches for a in touch.assumptions),
            ),
            lengths=length_names(
                ring, [(work.name, work.length) for work in self.works if work.length is not None]
            ),
            closing=self._closing(),
            unknowns={f"lambda_{tie.name}": tie.meaning for tie in self.ties},
            ties=self.ties,
        )

    def _bodies(self) -> Iterator[tuple[str, Series]]:
        """Yield name and kinetic energy ½ tr(Ḣ J Ḣᵀ) of each body."""
        terms = 0
        for body in self.kinematics.bodies:
            rate, J = self.kinematics.rate(body), self.kinematics.moments(body)
            columns = list(zip(*J, strict=True))
            halves = []
            for row in rate:
                HJ = [combination(row, column) for column in columns]
                halves.append(self.algebra.lift(combination(HJ, row)) / 2)
            energy = tidy(self.algebra.ring.sum(halves))
            terms += len(energy)
            if terms > self.algebra.ring.most_terms:
                raise DerivationError(
                    f"the kinetic energy has more than {self.algebra.ring.most_terms} terms, too "
                    "many to be read"
                )
            yield body, energy

    def _rotors(self) -> Iterator[tuple[str, Series]]:
        """Yield the joint's name and the kinetic energy ½ I r'² of each rotor."""
        algebra = self.algebra
        for link in self.kinematics.tree:
            inertia = algebra.series(link.armature)
            if inertia:
                yield (
                    link.joint,
                    inertia * algebra.lift(algebra.values[link.coordinates[0]]).ddt() ** 2 / 2,
                )

    def _weights(self) -> list[Series]:
        """Return the potential energy −g·(m c) of each body."""
        algebra, terms = self.algebra, []
        g = [algebra.arithmetic(c, algebra.values) for c in algebra.mechanism.gravity]
        for body in self.kinematics.bodies:
            mass_moments = [row[3] for row in self.kinematics.moments(body)]
            pose = self.kinematics.pose(body)
            moment = [combination(row, mass_moments) for row in pose]
            terms.append(-algebra.lift(combination(g, moment)))
        return terms

    def _sum(self, kind: str) -> Series:
        scalars = [
            work.scalar for work in self.works if work.kind == kind and work.scalar is not None
        ]
        return tidy(self.algebra.ring.sum(scalars))

    def find_free(self) -> list[bool]:
        """Return for each velocity whether no drive, load or constraint acts along it."""
        drives = [work for work in self.works if work.kind == "work"]
        acting = [work.forces for work in drives]
        acting += [tuple(tie.slopes(self.algebra.ring)) for tie in self.ties]
        free = []
        for k in range(len(self.algebra.velocities)):
            free.append(not any(each[k] for each in acting))
        return free

    def _closing(self) -> str:
        """The sentence before the equations of motion."""
        found = {work.kind for work in self.works}
        loss = " + ∂D/∂q'" if "dissipation" in found else ""
        drive = "Q" if "work" in found else "0"
        slopes = sorted({"∂ψ/∂q'" if tie.of_velocities else "∂Φ/∂q" for tie in self.ties})
        if self.ties:
            held = " + ".join(f"Σ λ {slope}" for slope in slopes)
            drive = f"Q + {held}" if "work" in found else held
        quasi = any(not name.endswith("'") for name in self.algebra.velocities)
        which = "Lagrange's equations with multipliers" if self.ties else "Lagrange's equations"
        return (
            f"{which} are d/dt ∂T/∂q' - ∂T/∂q + ∂V/∂q{loss} = {drive} for every coordinate q"
            + (
                "; for a velocity that is not the rate of a coordinate the terms of Euler and "
                "Kirchhoff are added."
                if quasi
                else "."
            )
            + self._say_ties()
        )

    def _say_ties(self) -> str:
        """The sentence about the equations of loops, contacts and velocity constraints."""
        if not self.ties:
            return ""
        if not self.algebra.mechanism.rolls:
            return " The loops add their constraint equations, Φ = 0."
        held = any(not tie.of_velocities for tie in self.ties)
        return f" The constraints add their own equations, {'Φ = 0 and ' if held else ''}ψ = 0."

    def _find_turning(self, momenta: Sequence[Series]) -> list[Series]:
        """Return ω × ∂T/∂v and ω × ∂T/∂ω + v × ∂T/∂v of each quaternion joint, else zero."""
        algebra = self.algebra
        found = [algebra.ring.number(0)] * len(momenta)
        for joint in algebra.mechanism.joints:
            if joint.quaternion:
                at = [algebra.velocities.index(name) for name in joint.velocities]
                rates = [algebra.ring[name] for name in joint.velocities]
                w, H = Vector(*rates[-3:]), Vector(*(momenta[k] for k in at[-3:]))
                turned = [*cross(w, H)]
                if joint.linear_velocities:
                    v, p = Vector(*rates[:3]), Vector(*(momenta[k] for k in at[:3]))
                    turned = [*cross(w, p), *(cross(w, H) + cross(v, p))]
                for k, term in zip(at, turned, strict=True):
                    found[k] = term
        return found
