"""Derive Newton and Euler's equations: cut bodies free, name their reactions, eliminate these.

Fundamentals of Dynamics, sect. 1.3.1: d/dt p = F (eq. 1.8) and d/dt H = M about the center of mass
(eq. 1.12) or a fixed point (eq. 1.10).
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import final

from mecanique.derivation.scalars.cancel import by_velocity
from mecanique.derivation.symbolic.balances import (
    FreeBodies,
    demands,
    needs,
    project,
)
from mecanique.derivation.symbolic.cutting import (
    Cut,
    explain_guides,
    say_zeros,
    state_moment_balance,
    state_momentum_balance,
)
from mecanique.derivation.symbolic.derivation import (
    REACTIONS,
    Derivation,
    Result,
    Stage,
    list_components,
    mass_and_bias,
)
from mecanique.derivation.symbolic.forces import length_names
from mecanique.derivation.symbolic.inertias import inertia_stages
from mecanique.derivation.symbolic.kinematics import quaternion_stages, relation_stages
from mecanique.derivation.symbolic.multipliers import (
    loop_stages,
    multiplier_stages,
    name_of,
    redundancy_stages,
)
from mecanique.derivation.symbolic.symbols import Algebra
from mecanique.derivation.symbolic.vectors import Vector, along, cross
from mecanique.errors import DerivationError
from mecanique.model.constraints.contacts import SPEAKING
from mecanique.model.mechanism import Mechanism
from mecanique.model.mechanism.letters import call
from mecanique.wording import enumerate_words


@final
class NewtonEuler:
    """The equations of a mechanism from the balances of its bodies, as series."""

    def __init__(self, mechanism: Mechanism, algebra: Algebra | None = None) -> None:
        self.algebra = algebra or Algebra(mechanism)
        self.balances = FreeBodies(mechanism, self.algebra)
        self.cuts = self.balances.cuts
        self._inertia = demands(self.cuts, needs)
        self._loads = demands(self.cuts, Cut.loads)

    def derivation(self) -> Derivation:
        """Return the equations of motion with their steps."""
        algebra, unstated = self.algebra, self.algebra.mechanism.velocity_constraints
        if unstated:
            raise DerivationError(
                f"mechanism {algebra.mechanism.name!r}: velocity constraint {unstated[0].name!r} "
                f"does not say by which force it acts, and where; use {SPEAKING}, or "
                "derive by Lagrange's equations or virtual work"
            )
        rates = self.balances.rates
        inertia = project(self.cuts, rates, self._inertia, rotors=True)
        M, h = mass_and_bias(algebra, inertia)
        ties = self.cuts.ties
        names = [name_of(tie.multiplier) for tie in ties]
        loads = [
            load.linear(names)[1] for load in project(self.cuts, rates, self._loads, rotors=False)
        ]
        multipliers = {f"lambda_{tie.name}": tie.meaning for tie in ties}
        Q = tuple(by_velocity(load, algebra.velocities) for load in loads)
        rest = [a - b for a, b in zip(h, Q, strict=True)]
        loops = [tie for tie in ties if not tie.of_contact]
        return Derivation(
            algebra=algebra,
            M=M,
            h=h,
            Q=Q,
            stages=(
                *quaternion_stages(algebra),
                *relation_stages(algebra),
                *inertia_stages(self.cuts.kinematics),
                *loop_stages(loops, of_forces=True),
                *(stage for cut in self.balances.bodies for stage in self._balance(cut)),
                *self._eliminate(),
                *redundancy_stages(algebra.mechanism, ties),
                *multiplier_stages(algebra, M, rest, ties),
            ),
            assumptions=tuple(self.cuts.assumptions),
            lengths=length_names(algebra.ring, self.cuts.lengths.items(), self.cuts.distances),
            closing=self._close(),
            unknowns=self.balances.unknowns | multipliers,
            reactions=self.balances.reactions,
            ties=ties,
        )

    def _balance(self, cut: Cut) -> Iterator[Stage]:
        """Yield the steps with the balances of one body, in terms of named reactions."""
        moving = self._list_accelerations(cut)
        vectors = (cut.twist.force, self._locate(cut)) if moving else ()
        turning = self._list_turning(cut, "force", *vectors)
        push = cut.axes.along(cut.about_reference(cut.push))
        acting = self.balances.acting_along(cut)
        pairs = zip(push.force, acting.force, strict=True)
        forces = [Result(a, b) for a, b in pairs if a or b]
        pairs = zip(push.moment, acting.moment, strict=True)
        moments = [Result(a, b) for a, b in pairs if a or b]
        every = [child for child in self.balances.bodies if self.balances.transmits(child)]
        hung = [child for child in every if self.balances.holder(child) == cut.body]
        held = [self._name_total(cut)] if self.balances.transmits(cut) else []
        acting_on = [
            *held,
            *(["its weight"] if any(cut.weight.force) else []),
            *dict.fromkeys(call(action.name) for action in cut.applied),
            *self.balances.guiding.acting_on(cut),
            *(f"the opposite of {self._name_total(child)}" for child in hung),
        ]
        if not (cut.inert or forces or acting_on):  # it only leads others
            return
        what = enumerate_words(acting_on) if acting_on else "nothing"
        sentence = (
            f"{self.balances.explain_leaders(cut)}Cut free, {call(cut.body)} is acted on by "
            f"{what}. {cut.axes.sentence} "
            f"{state_momentum_balance(cut, bool(moving), bool(turning))}"
        )
        letters = {letter: [f"{letter}_{cut.body}"] for letter in "rvaH"}
        sentence = self.algebra.say(sentence, **letters)
        yield Stage(f"Free body {cut.body}: forces", sentence, (*turning, *moving, *forces))
        if moments and not self.balances.repeats(cut):
            H = cut.about_reference(cut.momentum).tidy().moment
            stored = along(cut.axes.turns, H)
            momenta = list_components(f"H_{cut.body}", cut.axes.turn_labels, stored)
            changing = self._list_turning(cut, "moment", H)
            sentence = state_moment_balance(cut, any(H), bool(changing))
            sentence = self.algebra.say(sentence, **letters)
            new = [line for line in changing if line not in turning]
            yield Stage(f"Free body {cut.body}: moments", sentence, (*new, *momenta, *moments))

    def _list_turning(self, cut: Cut, kind: str, *vectors: Vector) -> list[Result]:
        """Return the angular velocity Ω of a body's axes if Ω × a vector in them is not zero."""
        axes, whose = cut.axes, cut.axes.whose[kind]
        if whose == "the world":
            return []
        # of the axes of forces and of moments in a plane, the latter include its normal
        rows = axes.turns if kind == "moment" or "" in axes.turn_labels else axes.rows
        turning = self.cuts.kinematics.turning(rows, cut.carrier).tidy()
        if not any(any(cross(turning, vector).tidy()) for vector in vectors):
            return []
        name = f"Omega_{whose.rpartition(' ')[2]}"
        return [*list_components(name, axes.turn_labels, along(rows, turning))]

    def _name_total(self, cut: Cut) -> str:
        """Name what acts across the joint of a body: a reaction, or a total with guides."""
        total = "total of reaction and guides" if self.balances.is_guided(cut) else "reaction"
        return f"the {total} in {call(cut.joint.name)}"

    def _locate(self, cut: Cut) -> Vector:
        """Return the position of a body's center of mass, in the axes of its carrier."""
        kinematics, body = self.cuts.kinematics, self.algebra.mechanism.body(cut.body)
        return kinematics.between(kinematics.point(cut.body, body.center), -1, cut.carrier).tidy()

    def _list_accelerations(self, cut: Cut) -> list[Result]:
        """Return position, velocity and acceleration of a body's center of mass."""
        if not cut.mass:
            return []
        r, v, results = self._locate(cut), cut.twist.force, list[Result]()
        a = self.cuts.kinematics.change(v, cut.carrier)
        for letter, vector in zip("rva", (r, v, a), strict=True):
            parts = along(cut.axes.rows, vector)
            results += list_components(f"{letter}_{cut.body}", cut.axes.labels, parts)
        return results

    def _eliminate(self) -> Iterator[Stage]:
        """Yield the steps with the reactions and the forces of guides in closed form."""
        sentences = []
        if self.balances.closed:
            sentences = [
                "From the tips to the ground, the balances of each body give the reaction in its "
                "joint; the motion then gives its value at any time.",
                say_zeros(self.balances.zeros),
            ]
        idle = [
            other.joint.name
            for cut in self.balances.bodies
            if not self.balances.transmits(cut)
            for other in reversed(self.balances.list_chain(cut))
        ]
        if idle and sentences:
            transmit = "transmits" if len(idle) == 1 else "transmit"
            sentences.append(f"{enumerate_words(idle)} {transmit} nothing.")
        if self.balances.guiding.names:
            yield Stage(
                "Forces of the elements",
                "Along and about the directions in which their joints are free, bodies receive no "
                "reaction: there their balances give the forces of "
                f"{enumerate_words([call(part.name) for part in self.algebra.mechanism.elements])}."
                + ("" if self.balances.guide_forces else " Their closed forms would be long."),
                tuple(self.balances.guide_forces),
            )
        if sentences:
            yield Stage(REACTIONS, " ".join(sentences), tuple(self.balances.closed))
        if self.balances.guides:
            yield Stage("Undetermined reactions", explain_guides(self.balances.guides))
        if self.balances.guiding.names:
            return
        driven = self.algebra.mechanism.coordinates.driven
        guided = [rate for rate in self.balances.rates if rate.name in driven]
        words = [rate.name for rate in guided if any(rate.partials)]
        if words:
            yield Stage(
                "Guided coordinates",
                f"The joint coordinates {', '.join(words)} follow the generalized coordinates. "
                "The forces that guide them do no work in any virtual displacement: the reactions "
                "along these joints, each times the derivative of its coordinate, sum to zero."
                + " The inertia of rotors counts with them."
                * any(rate.rotor for rate in guided),
                tuple(self.balances.sum_guides()),
            )

    def _close(self) -> str:
        at = (
            "With the reactions inserted, the balances along and about the free directions of the "
            "joints{} leave one equation for each velocity{}"
        )
        if not self.balances.unknowns:
            at = at.replace("With the reactions inserted, t", "T").replace("leave", "are")
        unknown = "The forces λ of the {} remain as unknowns; the {} add as many equations{}"
        if self.algebra.mechanism.loops:
            return f"{at.format('', '.')} {unknown.format('loops', 'loops', ', Φ = 0.')}"
        if self.algebra.mechanism.contacts:
            held = "conditions of rolling, Φ = 0 and ψ = 0,"
            return f"{at.format('', '.')} {unknown.format('contacts', held, '.')}"
        guided = len(self.balances.rates) != len(self.algebra.velocities)
        sums = ", and the sums for the guided coordinates," if guided else ""
        return at.format(sums, ", without unknown forces.")
