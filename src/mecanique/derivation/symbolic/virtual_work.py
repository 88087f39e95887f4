"""d'Alembert's principle and virtual work: inertia forces, equilibrium of every body, and a ledger of all work.

Fundamentals of Dynamics, sect. 1.3.2: with the forces −m a on every particle each body is in
equilibrium (eqs. 1.21, 1.22), so that in a virtual displacement, time standing still, all forces
together do no work (eq. 1.27).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import final

from mecanique.derivation.scalars.cancel import by_velocity, tidy
from mecanique.derivation.scalars.series import Kind, Series
from mecanique.derivation.symbolic.derivation import Derivation, Left, Result, Stage, mass_and_bias
from mecanique.derivation.symbolic.distribution import distribution_of
from mecanique.derivation.symbolic.free_bodies import Cut
from mecanique.derivation.symbolic.newton_euler import NewtonEuler, listed
from mecanique.derivation.symbolic.springs import length_names
from mecanique.derivation.symbolic.steps import quaternion_stages
from mecanique.derivation.symbolic.symbols import Algebra
from mecanique.derivation.symbolic.vectors import Vector, along, cross, total
from mecanique.model.mechanism import Mechanism

__all__ = ["VirtualWork"]


@final
class VirtualWork:
    """Inertia forces and virtual work of a mechanism as series.

    Args:
        mechanism: any mechanism without loops.
        algebra: its symbols, if they are there already.

    Raises:
        DerivationError: if the mechanism has loops, or no closed form of reasonable length.
    """

    def __init__(self, mechanism: Mechanism, algebra: Algebra | None = None) -> None:
        self.algebra = algebra or Algebra(mechanism)
        self.balances = NewtonEuler(mechanism, self.algebra)
        self.cuts = self.balances.cuts
        ring = self.algebra.ring
        self._names = tuple(f"δ{name.removesuffix(chr(39))}" for name in self.algebra.velocities)
        self._deltas = [ring.unknown(name, Kind.VARIATION) for name in self._names]
        self._unknowns = dict(self.balances.unknowns)
        for name, velocity in zip(self._names, self.algebra.velocities, strict=True):
            of = (
                f"of {velocity[:-1]}"
                if velocity.endswith("'")
                else f"that belongs to the velocity {velocity}"
            )
            self._unknowns[name] = (
                f"virtual displacement {of}: small, arbitrary, with time standing still"
            )
        self._inertia: list[Series] = []
        self._weights: list[Series] = []
        self._loads: list[Series] = []

    def derivation(self) -> Derivation:
        """Return the equations of motion with their steps."""
        algebra, ring = self.algebra, self.algebra.ring
        stages = [stage for cut in self.cuts.bodies for stage in self._body(cut)]
        rotors = self._rotors()
        rows = [-c for c in self._coefficients([*self._inertia, *self._weights, *rotors])]
        loads = self._coefficients(self._loads)
        M, h = mass_and_bias(algebra, rows)
        whole = ring.sum([*self._inertia, *self._weights, *rotors, *self._loads])
        stages += self._reactions()
        factors = self._coefficients([whole])
        stages.append(
            Stage(
                "Sum of the virtual work",
                "The work of all forces in the virtual displacement, inertia forces included, is zero. As "
                f"{listed(self._names)} {'is' if len(self._names) == 1 else 'are'} arbitrary, what stands "
                "before each is zero by itself.",
                tuple(
                    Result(
                        Left("δW", name[1:], component=True),
                        by_velocity(c, algebra.velocities) * delta,
                    )
                    for name, c, delta in zip(self._names, factors, self._deltas, strict=True)
                ),
            )
        )
        return Derivation(
            algebra=algebra,
            M=M,
            h=h,
            Q=tuple(by_velocity(load, algebra.velocities) for load in loads),
            stages=(*quaternion_stages(algebra), *stages),
            assumptions=tuple(self.cuts.assumptions),
            lengths=length_names(ring, self.cuts.lengths.items()),
            closing="What stands before each virtual displacement, with the sign changed, is an equation of motion.",
            unknowns=self._unknowns,
            reactions=self.balances.reactions,
        )

    def _body(self, cut: Cut) -> list[Stage]:
        """Inertia forces of a body, its equilibrium with them, and the work of all forces on it."""
        stages = []
        if cut.mass:
            stages.append(self._inertia_forces(cut))
        stages.append(self._equilibrium(cut))
        ledger = self._ledger(cut)
        if ledger:
            stages.append(
                Stage(
                    f"Virtual work on {cut.body}",
                    "Each force F with the virtual displacement δr of its point, and each couple C with the virtual "
                    "rotation δφ of the body: δW is the sum of the products of their components. Components that "
                    f"are not listed are zero.{self._where(cut)}",
                    tuple(ledger),
                )
            )
        return stages

    def _inertia_forces(self, cut: Cut) -> Stage:
        algebra, body = self.algebra, cut.body
        push = [-c for c in along(algebra, cut.axes.rows, cut.push)]
        couple = self._couple(cut)
        spread = distribution_of(self.cuts, cut)
        sentence = f"Against the acceleration of every particle of {body} acts its inertia force, -a dm. {cut.axes.sentence} "
        results = []
        if spread is not None:
            sentence += (
                f"On the rod they are spread with f per length at the distance {spread.coordinate} from its end; each "
                f"component integrates to F, which acts at the distance s_{body} where its moment is that of f. "
            )
            name = spread.coordinate
            self._unknowns[name] = f"distance along {body} from its end [m]"
            for label, density, force, point in zip(
                cut.axes.labels, spread.density, spread.resultant, spread.point, strict=True
            ):
                if density:
                    results += [
                        Result(Left(f"f_{body}_{label}"), density),
                        Result(Left(f"F_{body}_{label}"), force),
                    ]
                if point is not None:
                    results.append(Result(Left(f"s_{body}_{label}"), point))
        sentence += (
            "Moved to the center of mass C, their resultant is F = -m a and a couple C, minus the rate of the angular "
            "momentum about it."
        )
        for label, component in zip(cut.axes.labels, push, strict=True):
            if component and spread is None:
                results.append(Result(Left(f"F_{body}_{label}"), component))
        for label, component in zip(
            cut.axes.turn_labels, along(algebra, cut.axes.turns, couple), strict=True
        ):
            if component:
                results.append(Result(Left("_".join(filter(None, ("C", body, label)))), component))
        if len(results) == 0:
            sentence += " Here they are all zero."
        return Stage(f"Inertia forces of {body}", sentence, tuple(results))

    def _equilibrium(self, cut: Cut) -> Stage:
        algebra, zero = self.algebra, self.algebra.ring.number(0)
        pushes = along(algebra, cut.axes.rows, cut.push)
        turnings = along(algebra, cut.axes.turns, self.balances.turning(cut))
        given = (*self.balances.forces_along(cut), *self.balances.moments_along(cut))
        sums = [a - b for a, b in zip(given, (*pushes, *turnings), strict=True)]
        if not any(sums):
            return Stage(
                f"Equilibrium of {cut.body}",
                f"{cut.body} has no mass, and nothing acts on it: all is zero.",
            )
        about = cut.joint.name if cut.fixed or not cut.mass else "the center of mass"
        return Stage(
            f"Equilibrium of {cut.body}",
            "With its inertia forces the body is in equilibrium, the reactions R and M of its joints included: the "
            f"sums of forces, then of moments about {about}, are zero.",
            tuple(Result(one, zero) for one in sums if one),
        )

    def _couple(self, cut: Cut) -> Vector:
        """Couple of the inertia forces about the center of mass."""
        lever = cross(cut.center, cut.push)
        return [tidy(b - a) for a, b in zip(cut.turning, lever, strict=True)]

    def _ledger(self, cut: Cut) -> list[Result]:
        algebra = self.algebra
        lines: list[Result] = []
        rotation = self._varied(cut.spin)
        at_center = self._varied(cut.center_velocity)
        body = cut.body
        if cut.mass:
            if any(cut.weight):
                self._weights.append(
                    self._force(lines, f"weight_{body}", cut, cut.weight, at_center)
                )
            moved, couple = self._seat_of_inertia(cut)
            moved = at_center if moved is None else moved
            work = self._force(lines, f"inertia_{body}", cut, [-c for c in cut.push], moved)
            work = work + self._turn(lines, f"inertia_{body}", cut, couple, rotation)
            self._inertia.append(work)
        for one in cut.applied:
            work = algebra.ring.number(0)
            if any(one.force):
                work = work + self._force(
                    lines, one.name, cut, one.force, self._varied(one.velocity)
                )
            if any(one.moment):
                work = work + self._turn(lines, one.name, cut, one.moment, rotation)
            self._loads.append(work)
        return lines

    def _where(self, cut: Cut) -> str:
        if not cut.mass:
            return ""
        if self._seat_of_inertia(cut)[0] is not None:
            weight = "The weight acts at the center of mass, t" if any(cut.weight) else "T"
            return f" {weight}he inertia forces where their resultant acts, at the distance s_{cut.body}."
        both = "Weight and inertia forces act" if any(cut.weight) else "The inertia forces act"
        return f" {both} at the center of mass."

    def _seat_of_inertia(self, cut: Cut) -> tuple[Vector | None, Vector]:
        """Virtual displacement of the point at which a rod's inertia forces act, and the couple that is left there."""
        spread, couple = distribution_of(self.cuts, cut), self._couple(cut)
        points = (
            {point for point in spread.point if point is not None} if spread is not None else set()
        )
        if spread is None or len(points) != 1:
            return None, couple
        (s,) = points
        arm = [(s - spread.length / 2) * d for d in spread.direction]
        left = [tidy(c + r) for c, r in zip(couple, cross(arm, cut.push), strict=True)]
        if any(left):
            return None, couple
        velocity = total(self.algebra, [cut.center_velocity, cross(cut.spin, arm)])
        return self._varied(velocity), left

    def _force(
        self, lines: list[Result], name: str, cut: Cut, force: Vector, displacement: Vector
    ) -> Series:
        rows, labels = cut.axes.rows, cut.axes.labels
        return self._entry(lines, ("F", "δr", "δW"), name, rows, labels, force, displacement)

    def _turn(
        self, lines: list[Result], name: str, cut: Cut, couple: Vector, rotation: Vector
    ) -> Series:
        if not any(couple):
            return self.algebra.ring.number(0)
        rows, labels = cut.axes.turns, cut.axes.turn_labels
        return self._entry(lines, ("C", "δφ", "δW_couple"), name, rows, labels, couple, rotation)

    def _entry(
        self,
        lines: list[Result],
        letters: tuple[str, str, str],
        name: str,
        rows: Sequence[Sequence[object]],
        labels: Sequence[str],
        force: Vector,
        displacement: Vector,
    ) -> Series:
        """Write one entry of the ledger and return its work."""
        algebra = self.algebra
        acts, moves = along(algebra, rows, force), along(algebra, rows, displacement)
        work = tidy(algebra.ring.sum([f * d for f, d in zip(acts, moves, strict=True)]))
        for label, act, move in zip(labels, acts, moves, strict=True):
            if act:
                lines.append(Result(Left("_".join(filter(None, (letters[0], name, label)))), act))
                lines.append(Result(Left("_".join(filter(None, (letters[1], name, label)))), move))
        lines.append(Result(Left(f"{letters[2]}_{name}"), work))
        return work

    def _varied(self, velocity: Vector) -> Vector:
        """The virtual displacement that belongs to a velocity: Σ ∂v/∂q' δq."""
        algebra = self.algebra
        return [
            tidy(
                algebra.ring.sum(
                    [
                        slope * delta
                        for slope, delta in zip(algebra.partials(c), self._deltas, strict=True)
                        if slope
                    ]
                )
            )
            for c in velocity
        ]

    def _coefficients(self, works: Sequence[Series]) -> list[Series]:
        """What stands before each virtual displacement in a sum of works."""
        found, _ = self.algebra.ring.sum(list(works)).linear(self._names)
        return [tidy(c) for c in found]

    def _rotors(self) -> list[Series]:
        """Work of the inertia of the joints' rotors."""
        found = []
        for rate in self.balances.rates:
            if rate.rotor:
                turned = [
                    slope * delta
                    for slope, delta in zip(rate.partials, self._deltas, strict=True)
                    if slope
                ]
                found.append(-rate.rotor * self.algebra.ring.sum(turned))
        return found

    def _reactions(self) -> list[Stage]:
        """The work of each joint's reaction and its opposite together."""
        algebra, kinematics = self.algebra, self.cuts.kinematics
        if not self.balances.unknowns:
            return []
        lines = []
        for cut in self.cuts.bodies:
            force, moment = self.balances.symbols[cut.body]
            shift = self._varied(kinematics.velocity(cut.body, (0, 0, 0)))
            rotation = self._varied(cut.spin)
            parent = cut.joint.parent
            if kinematics.place[parent] >= 0:
                turn = self._varied(kinematics.spin(parent))
                arm = self.cuts.between_seats(parent, cut.body)
                carrying = self._varied(kinematics.velocity(parent, (0, 0, 0)))
                moved = total(algebra, [carrying, cross(turn, arm)])
                shift = [
                    a - b
                    for a, b in zip(shift, self.cuts.carried(moved, parent, cut.body), strict=True)
                ]
                rotation = [
                    a - b
                    for a, b in zip(
                        rotation, self.cuts.carried(turn, parent, cut.body), strict=True
                    )
                ]
            products = [f * d for f, d in zip([*force, *moment], [*shift, *rotation], strict=True)]
            lines.append(Result(Left(f"δW_{cut.joint.name}"), tidy(algebra.ring.sum(products))))
        sentence = (
            "A reaction acts on the child, its opposite on the parent at the same point: together they do work only in "
            "the displacement of one against the other, and the joint allows that only where it transmits nothing."
        )
        if guided := self.balances.guided():
            sentence += (
                " What guides the coordinates that follow others does work joint by joint, but none in all, as the "
                "last lines say."
            )
            lines += guided
        rotors = any(rate.rotor for rate in self.balances.rates)
        if rotors:
            sentence += " Where a joint has a rotor, its inertia is what is left."
        return [Stage("Virtual work of the reactions", sentence, tuple(lines))]
