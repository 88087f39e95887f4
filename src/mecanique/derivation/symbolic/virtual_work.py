"""Derive by d'Alembert's principle: inertia forces, equilibrium, a ledger of virtual work.

Fundamentals of Dynamics, sect. 1.3.2: with the inertia forces −a dm on its particles each body is
in equilibrium (eqs. 1.21, 1.22); hence all forces together do no work in a virtual displacement at
fixed time (eq. 1.27).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial
from typing import final

from mecanique.derivation.printing.equations import distribute
from mecanique.derivation.scalars.cancel import by_velocity, tidy
from mecanique.derivation.scalars.generators import Kind
from mecanique.derivation.scalars.series import Series
from mecanique.derivation.symbolic.derivation import Derivation, Left, Result, Stage, mass_and_bias
from mecanique.derivation.symbolic.free_bodies.balances import FreeBodies
from mecanique.derivation.symbolic.free_bodies.bodies import Cut
from mecanique.derivation.symbolic.free_bodies.distribution import Distribution, distribution_of
from mecanique.derivation.symbolic.free_bodies.sentences import enumerate_words
from mecanique.derivation.symbolic.ledger import (
    Displacements,
    Ledger,
    couple_of_inertia,
    join_words,
)
from mecanique.derivation.symbolic.lines_of_action import length_names
from mecanique.derivation.symbolic.redundancy import redundancy_stages
from mecanique.derivation.symbolic.steps.constraints import loop_stages
from mecanique.derivation.symbolic.steps.kinematics import quaternion_stages
from mecanique.derivation.symbolic.symbols import Algebra
from mecanique.derivation.symbolic.ties.quasi import independent_displacements
from mecanique.derivation.symbolic.ties.tie import Tie
from mecanique.derivation.symbolic.vectors import Vector, along, cross, total
from mecanique.errors import DerivationError
from mecanique.model.mechanism import Mechanism

_QUASI = (
    "The coefficient of each independent displacement, with the sign changed, is the left side of "
    "an equation of motion without multipliers. The constraints add their own equations, {}."
)

_CLOSING = (
    "The coefficient of each virtual displacement, with the sign changed, is the left side of an "
    "equation of motion."
)


@final
class VirtualWork:
    """Inertia forces and virtual work of a mechanism as series.

    Args:
        mechanism: any mechanism.
        algebra: its symbols, if they exist already.

    Raises:
        DerivationError: if the mechanism has no closed form of reasonable length.
    """

    def __init__(self, mechanism: Mechanism, algebra: Algebra | None = None) -> None:
        self.algebra = algebra or Algebra(mechanism)
        self.balances = FreeBodies(mechanism, self.algebra)
        self.cuts = self.balances.cuts
        self._displacements = Displacements(self.algebra)
        self._ledger = Ledger(self.balances, self._displacements)
        self._unknowns = self.balances.unknowns | self._displacements.meanings

    def derivation(self) -> Derivation:
        """Return the equations of motion with their steps."""
        algebra, ring = self.algebra, self.algebra.ring
        stages = [stage for cut in self.cuts.bodies for stage in self._body(cut)]
        ledger, displacements = self._ledger, self._displacements
        inertia = [*ledger.inertia, *ledger.weights, *self._rotors()]
        M, h = mass_and_bias(algebra, [-c for c in displacements.coefficients(inertia)])
        loads = displacements.coefficients(ledger.loads)
        whole = ring.sum([*inertia, *ledger.loads])
        ties = self.cuts.ties
        slopes = [list(map(tidy, tie.slopes(ring))) for tie in ties]
        S = self._independent(slopes) if ties else []
        known = not algebra.mechanism.velocity_constraints
        met = [tie for one in self.cuts.touches for tie in one.ties]
        met += [tie for one in self.cuts.closings for tie in one.ties]
        self._unknowns |= {f"lambda_{tie.name}": tie.meaning for tie in met}
        return Derivation(
            algebra=algebra,
            M=M,
            h=h,
            Q=tuple(by_velocity(load, algebra.velocities) for load in loads),
            stages=(
                *quaternion_stages(algebra),
                *stages,
                *self._reactions(),
                self._sum(whole, free=not ties),
                *self._relate(ties, S),
            ),
            assumptions=tuple(self.cuts.assumptions),
            lengths=length_names(ring, self.cuts.lengths.items()),
            closing=_QUASI.format(_name_conditions(ties)) if S else _CLOSING,
            unknowns=self._unknowns,
            reactions=self.balances.reactions if known else {},
            ties=ties,
            quasi=tuple(map(tuple, S)),
        )

    def _independent(self, slopes: Sequence[Sequence[Series]]) -> list[list[Series]]:
        """Return the displacements that the constraints allow; none if those of loops are long."""
        algebra = self.algebra
        loops = bool(algebra.mechanism.loops)
        count = len(algebra.velocities)
        try:
            return independent_displacements(algebra.ring, slopes, count, cramer=loops)
        except DerivationError:
            if not loops:
                raise
            return []

    def _relate(self, ties: Sequence[Tie], S: list[list[Series]]) -> Iterator[Stage]:
        """Yield the steps that express the allowed displacements by independent ones."""
        if not ties:
            return
        yield from loop_stages(ties, of_work=bool(S))
        yield from redundancy_stages(self.algebra.mechanism, of_work=bool(S))
        if not S:
            return
        one = self.algebra.ring.number(1)
        named: list[Series] = []
        users = [sum(map(bool, row)) for row in zip(*S, strict=True)]
        for k, column in enumerate(S):
            alone = [i for i, entry in enumerate(column) if entry == one]
            own = [i for i in alone if users[i] == 1]
            if own:
                named.append(self._displacements.deltas[own[0]])
                continue
            name = f"δπ{k + 1}"
            named.append(self.algebra.ring.unknown(name, Kind.VARIATION))
            self._unknowns[name] = "independent virtual displacement: small and arbitrary"
        results = []
        for i, name in enumerate(self._displacements.names):
            terms = [column[i] * delta for column, delta in zip(S, named, strict=True) if column[i]]
            right = self.algebra.ring.sum(terms)
            if right != self._displacements.deltas[i]:
                results.append(Result(Left(name), right))
        words = enumerate_words([delta.generators()[0].name for delta in named])
        where = " or ".join(
            sorted({"ψ" if tie.of_velocities else "Φ'" for tie in ties}, reverse=True)
        )
        count = "one" if len(S) == 1 else len(S)
        sentence = (
            "A virtual displacement must satisfy the constraints at fixed time: with it in place "
            f"of the velocities, the terms of {where} that contain velocities sum to zero. That "
            f"leaves {count} of them independent, {words}; all others follow."
        )
        yield Stage("Independent displacements", sentence, tuple(results))

    def _sum(self, whole: Series, *, free: bool) -> Stage:
        """Return the step with the sum of all work, by virtual displacement."""
        title, displacements = "Sum of the virtual work", self._displacements
        if not displacements.names:
            return Stage(title, "Nothing can be displaced, so no force does any work.", ())
        are = "is" if len(displacements.names) == 1 else "are"
        sentence = (
            "The work of all forces in the virtual displacement, inertia forces included, is zero. "
            f"As {enumerate_words(displacements.names)} {are} arbitrary, the coefficient of each "
            "is zero by itself."
            if free
            else "The work of all forces in a virtual displacement that the constraints allow, "
            "inertia forces included, is zero; the constraint forces between bodies do none."
        )
        results = []
        factors = displacements.coefficients([whole])
        for factor, delta in zip(factors, displacements.deltas, strict=True):
            name = delta.generators()[0].name.removeprefix("δ")
            left = Left("δW", name, component=True)
            tidied = by_velocity(factor, self.algebra.velocities)
            results.append(Result(left, tidied * delta, partial(distribute, tidied, delta)))
        return Stage(title, sentence, tuple(results))

    def _body(self, cut: Cut) -> Iterator[Stage]:
        """Yield the steps of a body: inertia forces, equilibrium, work of all forces on it."""
        if cut.inert:
            yield self._inertia_forces(cut)
        yield self._equilibrium(cut)
        entries = self._ledger.enter(cut)
        if entries:
            sentence = (
                "Each force F does work in the virtual displacement δr of its point, each couple C "
                "in the virtual rotation δφ of the body: δW is the sum of the products of their "
                f"components. Components that are not listed are zero.{self._ledger.locate(cut)}"
            )
            yield Stage(f"Virtual work on {cut.body}", sentence, tuple(entries))

    def _inertia_forces(self, cut: Cut) -> Stage:
        """Return the step with d'Alembert's inertia forces and their resultant."""
        body, axes = cut.body, cut.axes
        spread = distribution_of(self.cuts, cut)
        parts = [
            f"Every particle of {body} has the inertia force -a dm, opposite to its acceleration.",
            axes.sentence,
        ]
        results = []
        if spread is not None:
            self._unknowns[spread.coordinate] = "distance along a rod from its end [m]"
            parts.append(
                f"On the rod they have the density f per length at the distance "
                f"{spread.coordinate} from its end; each component integrates to "
                f"F_inertia_{body}, which acts at the distance s_{body}, where it has the same "
                "moment as f."
            )
            results += _list_spread_forces(spread, cut)
        else:
            F = -along(axes.rows, cut.push)
            named = zip(axes.labels, F, strict=True)
            results += [
                Result(Left(f"F_inertia_{body}_{label}"), part) for label, part in named if part
            ]
        C = along(axes.turns, couple_of_inertia(cut))
        for label, part in zip(axes.turn_labels, C, strict=True):
            if part:
                results.append(Result(Left(join_words("C_inertia", body, label)), part))
        parts.append(
            "Reduced to the center of mass they are one force, minus the mass times the "
            "acceleration of that center, and a couple, minus the rate of the angular momentum "
            "about it."
        )
        if not results:
            parts.append("Here they are all zero.")
        return Stage(f"Inertia forces of {body}", " ".join(parts), tuple(results))

    def _equilibrium(self, cut: Cut) -> Stage:
        """Return the step with the sums of all forces and moments, inertia forces included."""
        title, zero = f"Equilibrium of {cut.body}", self.algebra.ring.number(0)
        F = self.balances.forces_along(cut) - along(cut.axes.rows, cut.push)
        C = self.balances.moments_along(cut) - along(cut.axes.turns, self.balances.turning(cut))
        lines = [Result(one, zero) for one in (*F, *C) if one]
        if not lines:
            return Stage(title, f"{cut.body} has no mass, and no force acts on it.")
        about = cut.joint.name if cut.fixed or not cut.mass else "the center of mass"
        sentence = (
            "Under all forces, including inertia forces and the reactions R and M of its joints, "
            f"the body is in equilibrium: the sums of forces, then of moments about {about}, are "
            "zero."
        )
        return Stage(title, sentence, tuple(lines))

    def _rotors(self) -> list[Series]:
        """Return the virtual work of the inertia of the joints' rotors."""
        rates = [rate for rate in self.balances.rates if rate.rotor]
        return [-rate.rotor * self._displacements.sum(rate.partials) for rate in rates]

    def _reactions(self) -> list[Stage]:
        """Return the step with the work of each joint's reaction together with its opposite."""
        if not self.balances.unknowns:
            return []
        lines = []
        for cut in self.cuts.bodies:
            reaction = self.balances.symbols[cut.body]
            shift, rotation = self._against_parent(cut)
            forces, moves = [*reaction.force, *reaction.moment], [*shift, *rotation]
            products = [f * d for f, d in zip(forces, moves, strict=True)]
            work = tidy(self.algebra.ring.sum(products))
            lines.append(Result(Left(f"δW_R_{cut.joint.name}"), work))
        sentence = (
            "A reaction acts on the child, its opposite on the parent at the same point: together "
            "they do work only in the relative displacement of the two, and that the joint allows "
            "only in directions in which it transmits nothing."
        )
        if guided := self.balances.sum_guides():
            sentence += (
                " The forces that guide dependent coordinates count as reactions; they do work in "
                "single joints, but none in total, as the last lines state."
            )
            lines += guided
        if any(rate.rotor for rate in self.balances.rates):
            sentence += " Where a joint has a rotor, the work of its inertia remains."
        return [Stage("Virtual work of the reactions", sentence, tuple(lines))]

    def _against_parent(self, cut: Cut) -> tuple[Vector, Vector]:
        """Return the virtual displacement of a body's origin relative to its parent.

        Also return the body's virtual rotation relative to its parent.
        """
        cuts, kinematics, parent = self.cuts, self.cuts.kinematics, cut.joint.parent
        vary = self._displacements.vary
        shift, rotation = vary(kinematics.velocity(cut.body)), vary(cut.spin)
        if kinematics.place[parent] < 0:
            return shift, rotation
        turn = vary(kinematics.spin(parent))
        arm = cuts.between_seats(parent, cut.body)
        carrying = vary(kinematics.velocity(parent))
        moved = total([carrying, cross(turn, arm)])
        shift = shift - cuts.carry(moved, parent, cut.body)
        return shift, rotation - cuts.carry(turn, parent, cut.body)


def _list_spread_forces(spread: Distribution, cut: Cut) -> list[Result]:
    """List the density f, its resultant F and the point where that acts, by component."""
    results = []
    for k, label in enumerate(cut.axes.labels):
        if spread.density[k]:
            results.append(Result(Left(f"f_{cut.body}_{label}"), spread.density[k]))
            results.append(Result(Left(f"F_inertia_{cut.body}_{label}"), spread.resultant[k]))
        point = spread.point[k]
        if point is not None:
            results.append(Result(Left(f"s_{cut.body}_{label}"), point))
    return results


def _name_conditions(ties: Sequence[Tie]) -> str:
    """Name the equations of the constraints: Φ = 0, ψ = 0 or both."""
    held = {"ψ = 0" if tie.of_velocities else "Φ = 0" for tie in ties}
    return " and ".join(sorted(held))
