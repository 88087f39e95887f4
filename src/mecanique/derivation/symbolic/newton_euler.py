"""Newton and Euler's equations: every body cut free, its reactions by name, eliminated from the tips to the ground.

Fundamentals of Dynamics, sect. 1.3.1: d/dt p = F (eq. 1.8) and d/dt H = M about the center of mass
(eq. 1.12) or a fixed point (eq. 1.10).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, final

from mecanique.derivation.scalars.cancel import by_velocity, tidy
from mecanique.derivation.scalars.series import Kind, Series
from mecanique.derivation.symbolic.derivation import Derivation, Left, Result, Stage, mass_and_bias
from mecanique.derivation.symbolic.elimination import JointRate, demands, joint_rates, project
from mecanique.derivation.symbolic.free_bodies import Cut, Cuts
from mecanique.derivation.symbolic.kinematics import Kinematics
from mecanique.derivation.symbolic.springs import length_names
from mecanique.derivation.symbolic.steps import quaternion_stages
from mecanique.derivation.symbolic.symbols import Algebra
from mecanique.derivation.symbolic.vectors import Vector, along, cross, total, zero
from mecanique.derivation.tree.poses import combination
from mecanique.errors import DerivationError
from mecanique.model.mechanism import Mechanism

__all__ = ["NewtonEuler", "listed"]


@final
class NewtonEuler:
    """The balances of every body of a mechanism as series, and the reactions in closed form.

    Args:
        mechanism: any mechanism without loops.
        algebra: its symbols, if they are there already.

    Raises:
        DerivationError: if the mechanism has loops, or no closed form of reasonable length.
    """

    def __init__(self, mechanism: Mechanism, algebra: Algebra | None = None) -> None:
        if mechanism.loops:
            raise DerivationError(
                f"mechanism {mechanism.name!r} has loops; the reactions in its tree alone would mean nothing, but "
                "Lagrange's equations with multipliers can be written out"
            )
        self.algebra = algebra or Algebra(mechanism)
        self.cuts = Cuts(Kinematics(self.algebra))
        self.rates = joint_rates(self.cuts)
        self._inertia = demands(self.cuts, _needs)
        self._loads = demands(self.cuts, Cut.loads)
        free = {cut.body: self._free(cut) for cut in self.cuts.bodies}
        self.demands = demands(self.cuts, _missing, free)
        """What each joint transmits to its child along a motion, by name of the child."""
        self.unknowns: dict[str, str] = {}
        """What each reaction is, by its name."""
        self.symbols: dict[str, tuple[Vector, Vector]] = {}
        """Force and moment of each joint on its child with the reactions by name, by name of the child."""
        self._own: dict[str, tuple[Vector, Vector]] = {}
        self._zeros: list[str] = []
        self._closed: list[Result] = []
        for cut in self.cuts.bodies:
            self._name(cut)

    def derivation(self) -> Derivation:
        """Return the equations of motion with their steps."""
        algebra = self.algebra
        M, h = mass_and_bias(algebra, project(self.cuts, self.rates, self._inertia, rotors=True))
        loads = project(self.cuts, self.rates, self._loads, rotors=False)
        return Derivation(
            algebra=algebra,
            M=M,
            h=h,
            Q=tuple(by_velocity(load, algebra.velocities) for load in loads),
            stages=(
                *quaternion_stages(algebra),
                *(stage for cut in self.cuts.bodies for stage in self._free_body(cut)),
                *self._elimination(),
            ),
            assumptions=tuple(self.cuts.assumptions),
            lengths=length_names(algebra.ring, self.cuts.lengths.items()),
            closing=self._closing(),
            unknowns=self.unknowns,
            reactions=self.reactions,
        )

    @property
    def reactions(self) -> dict[str, Series]:
        """Each reaction that is not identically zero in closed form, by its name, e.g. R_pin_n."""
        return {
            result.left.quantity: result.right
            for result in self._closed
            if isinstance(result.left, Left)
        }

    def _name(self, cut: Cut) -> None:
        """Give the reactions of a body's joint their names; a component that vanishes identically has none."""
        algebra, axes, joint = self.algebra, cut.axes, cut.joint.name
        demand = self.demands[cut.body]
        free = self._free(cut)
        force, moment = zero(algebra), zero(algebra)
        own: dict[str, Vector] = {"force": zero(algebra), "moment": zero(algebra)}
        for kind, rows, labels, signs in (
            ("force", axes.rows, axes.labels, axes.signs),
            ("moment", axes.turns, axes.turn_labels, (1, 1, 1)),
        ):
            closed = along(algebra, rows, demand.force if kind == "force" else demand.moment)
            for k, (row, label, sign, value) in enumerate(
                zip(rows, labels, signs, closed, strict=True)
            ):
                loose = [rate for rate in free if rate.kind == kind and _parallel(row, rate.axis)]
                if loose:
                    # a free joint transmits what its rotor takes, nothing else
                    rotor = [-rate.rotor * c for rate in loose for c in rate.axis]
                    force = total(algebra, [force, rotor]) if kind == "force" else force
                    moment = total(algebra, [moment, rotor]) if kind == "moment" else moment
                    continue
                name = "_".join(filter(None, ("R" if kind == "force" else "M", joint, label)))
                if value.vanishes():
                    self._zeros.append(name)
                    continue
                symbol = sign * algebra.ring.unknown(name, Kind.REACTION)
                own[kind][k] = symbol
                self.unknowns[name] = self._meaning(cut, kind, label, sign)
                self._closed.append(Result(Left(name), sign * value))
                vector = [symbol * algebra.lifted(c) for c in row]
                if kind == "force":
                    force = total(algebra, [force, vector])
                else:
                    moment = total(algebra, [moment, vector])
        self.symbols[cut.body] = (force, moment)
        self._own[cut.body] = (own["force"], own["moment"])

    def _free(self, cut: Cut) -> list[JointRate]:
        """The joint velocities in which the joint of a body transmits nothing."""
        algebra = self.algebra
        loose = len(self.rates) == len(algebra.velocities)
        driven = algebra.mechanism.coordinates.driven
        names = {
            generator.name
            for name in driven
            for generator in algebra.lifted(algebra.values[name]).generators()
        }
        found = []
        for rate in self.rates:
            if rate.body == cut.body and (
                loose or (rate.name not in driven and rate.name not in names)
            ):
                found.append(rate)
        return found

    def _meaning(self, cut: Cut, kind: str, label: str, sign: int) -> str:
        joint, parent = cut.joint.name, cut.joint.parent
        if kind == "moment":
            about = (
                f"about {label}{_whose(cut, label)}"
                if label
                else "in the sense in which moments count positive"
            )
            return f"moment that {parent} exerts on {cut.body} in {joint}, {about} [N·m]"
        where = f"towards {joint}" if sign < 0 else f"along {label}{_whose(cut, label)}"
        return f"force that {parent} exerts on {cut.body} in {joint}, {where} [N]"

    def _free_body(self, cut: Cut) -> list[Stage]:
        """The balances of one body, with the reactions by name."""
        algebra, body = self.algebra, cut.body
        left = along(algebra, cut.axes.rows, cut.push)
        right = self.forces_along(cut)
        kept = [Result(a, b) for a, b in zip(left, right, strict=True) if a or b]
        left, right = along(algebra, cut.axes.turns, self.turning(cut)), self.moments_along(cut)
        spun = [Result(a, b) for a, b in zip(left, right, strict=True) if a or b]
        hung = [other.joint.name for other in self.cuts.bodies if other.joint.parent == body]
        acting = [f"the reaction in {cut.joint.name}", *(["its weight"] if any(cut.weight) else [])]
        acting += list(dict.fromkeys(one.name for one in cut.applied))
        acting += [f"the opposite of the reaction in {name}" for name in hung]
        sentence = f"Cut free, {body} is acted on by {listed(acting)}. {cut.axes.sentence}"
        moving = self._accelerations(cut)
        if moving:
            sentence += (
                " Mass times the acceleration a of the center of mass equals the resultant force; below are the "
                "components of a, then those of both sides."
            )
        elif cut.mass:
            sentence += " Its center of mass stays where it is, so the forces on it are in balance."
        else:
            sentence += " It has no mass, so the forces on it are in balance."
        stages = [Stage(f"Free body {body}: forces", sentence, (*moving, *kept))]
        if spun:
            point = (
                f"{cut.joint.name}, a fixed point"
                if cut.fixed
                else "its center of mass"
                if cut.mass
                else f"{cut.joint.name}; without mass any point serves"
            )
            what = (
                "The rate of the angular momentum equals the resultant moment"
                if cut.mass
                else "Moments balance"
            )
            stages.append(
                Stage(f"Free body {body}: moments", f"{what}, both about {point}.", tuple(spun))
            )
        return stages

    def _accelerations(self, cut: Cut) -> list[Result]:
        if not cut.mass:
            return []
        a = along(
            self.algebra,
            cut.axes.rows,
            self.cuts.kinematics.change(cut.center_velocity, cut.carrier),
        )
        return [
            Result(Left(f"a_{cut.body}_{label}"), component)
            for label, component in zip(cut.axes.labels, a, strict=True)
            if component
        ]

    def resultant(self, cut: Cut) -> Vector:
        """Return the resultant force on a body, with reactions by name, in the axes of its carrier.

        Args:
            cut: the body.
        """
        loads, _ = cut.loads()
        back = [force for _, force, _ in self._behind(cut)]
        return total(self.algebra, [cut.weight, loads, self.symbols[cut.body][0], *back])

    def forces_along(self, cut: Cut) -> Vector:
        """Return the resultant force along the axes in which the body's equations are written.

        The reaction of its own joint needs no projection, which would write out n·n = 1 in its
        coordinates.

        Args:
            cut: the body.
        """
        force, own = self.symbols[cut.body][0], self._own[cut.body][0]
        rest = [a - b for a, b in zip(self.resultant(cut), force, strict=True)]
        known = self._rotors(cut, "force")
        found = along(self.algebra, cut.axes.rows, total(self.algebra, [rest, known]))
        return [a + b for a, b in zip(found, own, strict=True)]

    def moments_along(self, cut: Cut) -> Vector:
        """Return the resultant moment about the axes in which the body's equations are written.

        Args:
            cut: the body.
        """
        moment, own = self.symbols[cut.body][1], self._own[cut.body][1]
        rest = [a - b for a, b in zip(self.moment(cut), moment, strict=True)]
        known = self._rotors(cut, "moment")
        found = along(self.algebra, cut.axes.turns, total(self.algebra, [rest, known]))
        return [a + b for a, b in zip(found, own, strict=True)]

    def _rotors(self, cut: Cut, kind: str) -> Vector:
        """What the rotor of a body's free joint takes."""
        found = zero(self.algebra)
        for rate in self._free(cut):
            if rate.kind == kind and rate.rotor:
                found = [a - rate.rotor * c for a, c in zip(found, rate.axis, strict=True)]
        return found

    def turning(self, cut: Cut) -> Vector:
        """Return the moment of the rates of momentum about the body's fixed point, or else its center of mass.

        Args:
            cut: the body.
        """
        return total(self.algebra, [cut.turning, cross(_back(cut), cut.push)])

    def moment(self, cut: Cut) -> Vector:
        """Return the resultant moment about the body's fixed point, or else its center of mass, reactions by name.

        Args:
            cut: the body.
        """
        _, loads = cut.loads()
        parts = [
            cut.weight_moment,
            loads,
            self.symbols[cut.body][1],
            cross(_back(cut), self.resultant(cut)),
        ]
        for place, force, moment in self._behind(cut):
            parts += [moment, cross(place, force)]
        return total(self.algebra, parts)

    def _behind(self, cut: Cut) -> list[tuple[Vector, Vector, Vector]]:
        """Of each joint that hangs on a body: its place, minus its force and moment."""
        found = []
        for other in self.cuts.bodies:
            if other.joint.parent == cut.body:
                force, moment = (
                    [-c for c in self.cuts.carried(part, other.body, cut.body)]
                    for part in self.symbols[other.body]
                )
                found.append((self.cuts.between_seats(cut.body, other.body), force, moment))
        return found

    def _elimination(self) -> list[Stage]:
        sentence = (
            "From the tips to the ground each body's balances give the reaction in its own joint; the motion then "
            "gives its value at any time."
        )
        if self._zeros:
            sentence += f" Identically zero: {', '.join(self._zeros)}."
        stages = (
            [Stage("Reactions", sentence, tuple(self._closed))]
            if self._closed or self._zeros
            else []
        )
        driven = self.algebra.mechanism.coordinates.driven
        if driven and len(self.rates) != len(self.algebra.velocities):
            moved = [rate for rate in self.rates if any(rate.partials)]
            words = ", ".join(rate.name for rate in moved if rate.name in driven)
            if words:
                stages.append(
                    Stage(
                        "Guided coordinates",
                        f"The joint coordinates {words} follow the generalized coordinates. What guides them does "
                        "no work in any virtual displacement: the reactions along these joints, each times the "
                        "derivative of its coordinate, add up to zero.",
                        tuple(self.guided()),
                    )
                )
        return stages

    def guided(self) -> list[Result]:
        """Return what the reactions along guided joints add up to: zero for each virtual displacement."""
        ring = self.algebra.ring
        sums: list[list[Series]] = [[] for _ in self.algebra.velocities]
        for rate in self.rates:
            force, moment = self.symbols[rate.body]
            size = self.algebra.lifted(
                combination(rate.axis, force if rate.kind == "force" else moment)
            )
            for terms, slope in zip(sums, rate.partials, strict=True):
                if slope:
                    terms.append(tidy(slope * size))
        return [Result(whole, ring.number(0)) for terms in sums if (whole := ring.sum(terms))]

    def _closing(self) -> str:
        if len(self.rates) == len(self.algebra.velocities):
            return (
                "Put into the balances along and about the directions in which the joints are free, where they "
                "transmit nothing, the reactions leave one equation for each velocity, without unknown forces."
            )
        return (
            "Put into the balances where the joints are free and transmit nothing, and into the sum of what guides the "
            "other coordinates, the reactions leave one equation for each velocity, without unknown forces."
        )


def _needs(cut: Cut) -> tuple[Vector, Vector]:
    """What a body needs by itself: rates of momentum less weight."""
    force = [a - b for a, b in zip(cut.push, cut.weight, strict=True)]
    moment = [a - b for a, b in zip(cut.turning, cut.weight_moment, strict=True)]
    return [tidy(c) for c in force], [tidy(c) for c in moment]


def _missing(cut: Cut) -> tuple[Vector, Vector]:
    """What a body needs from its joint besides what is applied to it."""
    (force, moment), (push, turn) = _needs(cut), cut.loads()
    return [a - b for a, b in zip(force, push, strict=True)], [
        a - b for a, b in zip(moment, turn, strict=True)
    ]


def _back(cut: Cut) -> Vector:
    """From the point that moments are taken about to the origin of the body's frame."""
    return [c - c if cut.fixed else -c for c in cut.center]


def _whose(cut: Cut, label: str) -> str:
    """Whose axis a label means, where the sentence about the axes does not tell."""
    return f" of {cut.axes.whose}" if label in ("x", "y", "z") else ""


def _parallel(row: Sequence[Any], axis: Vector) -> bool:
    """Whether a direction is ± an axis, as series."""
    lifted = [axis[0].ring.number(1) * c for c in row]
    return lifted == axis or lifted == [-c for c in axis]


def listed(words: Sequence[str]) -> str:
    """Return words as an enumeration, the last after "and".

    Args:
        words: at least one.
    """
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} and {words[-1]}"
