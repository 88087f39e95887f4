"""Derive by d'Alembert's principle: inertia forces, equilibrium, a ledger of virtual work.

Fundamentals of Dynamics, sect. 1.3.2: with the inertia forces −a dm on its particles each body is
in equilibrium (eqs. 1.21, 1.22); hence all forces together do no work in a virtual displacement at
fixed time (eq. 1.27).
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import chain, count
from typing import Any, NamedTuple, final

import numpy as np

from mecanique.derivation.printing.equations import bracket, join
from mecanique.derivation.printing.writers import Expression
from mecanique.derivation.scalars.cancel import by_velocity, tidy
from mecanique.derivation.scalars.series import GIVEN, Kind, Series
from mecanique.derivation.symbolic.balances import FreeBodies
from mecanique.derivation.symbolic.cutting import Cut, Cuts
from mecanique.derivation.symbolic.derivation import (
    DISPLACEMENTS,
    DISTANCE,
    INDEPENDENT,
    Derivation,
    Left,
    Result,
    Stage,
    Tie,
    lefts_of,
    list_components,
    mass_and_bias,
)
from mecanique.derivation.symbolic.forces import length_names
from mecanique.derivation.symbolic.inertias import inertia_stages
from mecanique.derivation.symbolic.kinematics import quaternion_stages, relation_stages
from mecanique.derivation.symbolic.multipliers import (
    independent_displacements,
    list_alone,
    loop_stages,
    name_of,
    redundancy_stages,
)
from mecanique.derivation.symbolic.symbols import Algebra, coordinate_of
from mecanique.derivation.symbolic.vectors import (
    SymbolicWrench,
    Vector,
    along,
    cross,
    dot,
    lift,
    total,
    zero,
)
from mecanique.derivation.tolerances import ALIGNED
from mecanique.derivation.tree.poses import combination
from mecanique.errors import DerivationError
from mecanique.model import Cylinder, Mechanism, Shape
from mecanique.model.mechanism.letters import call
from mecanique.wording import enumerate_words

_NAMES = ("s", "xi", "sigma", "eta")


@final
@dataclass(frozen=True)
class Distribution:
    """Inertia forces per length along a homogeneous slender rod."""

    coordinate: str  # name of the distance from the rod's end
    length: Series  # length of the rod [m]
    direction: Vector  # direction along the rod from that end, in the axes of the body's carrier
    density: Vector  # force per length at that distance, along the axes of the body [N/m]
    resultant: tuple[Series, ...]  # its integral over the rod [N]
    # distance at which the resultant of each component has its moment; None if it has none, or the
    # distance is not the same in all states
    point: tuple[Series | None, ...]


def distribution_of(cuts: Cuts, cut: Cut) -> Distribution | None:
    """Return the distribution of a body's inertia forces if it is a homogeneous slender rod."""
    # With the acceleration a(s) of the rod's points the density is −(m/L) a(s), a polynomial in s;
    # its resultant and its moment about the end are integrated term by term
    algebra, kinematics = cuts.algebra, cuts.kinematics
    shapes = algebra.mechanism.body(cut.body).shapes
    if len(shapes) != 1 or (rod := _find_rod(cuts, shapes[0])) is None:
        return None
    length, direction, center = rod
    taken = {*algebra.values, *algebra.mechanism.coordinates}
    name = next((name for name in _NAMES if name not in taken), None)
    if name is None:
        return None
    s = algebra.ring.unknown(name, Kind.PARAMETER)
    point = [c + (s - length / 2) * d for c, d in zip(center, direction, strict=True)]
    rate = [combination(row, [*point, 1]) for row in kinematics.rate(cut.body)]
    a = kinematics.change(lift(algebra.ring, rate), cut.carrier)
    density = (along(cut.axes.rows, a) * -(cut.mass / length)).tidy()
    turn = kinematics.turn(kinematics.place[cut.body])
    away = lift(algebra.ring, [combination(row, direction) for row in turn]).tidy()
    resultants, points = [], []
    for axis, component in zip(cut.axes.rows, density, strict=True):
        force, moment = (_integrate(component, name, length, order) for order in (0, 1))
        resultants.append(force)
        # along the rod it has no moment about the end
        across = any(cross(lift(algebra.ring, axis), away).tidy())
        points.append(_divide(moment, force) if across else None)
    return Distribution(
        coordinate=name,
        length=length,
        direction=away,
        density=density,
        resultant=tuple(resultants),
        point=tuple(points),
    )


def _find_rod(cuts: Cuts, shape: Shape) -> tuple[Series, list[int], list[Series]] | None:
    """Return length, direction away from the joint and center of a slender rod, None for others."""
    algebra = cuts.algebra
    if len(shape.visuals) != 1 or not isinstance(cylinder := shape.visuals[0].geometry, Cylinder):
        return None
    rotation = shape.visuals[0].placement.rotation
    axis = np.array([algebra.mechanism.evaluate(row[2]) for row in rotation])
    if np.abs(axis).max() < 1 - ALIGNED:
        return None
    at = algebra.mechanism.evaluate_all(shape.center)
    sign = -1 if axis @ np.array(at) < 0 else 1
    direction = [sign * round(component) for component in axis.tolist()]
    length = algebra.series(cylinder.length)
    across = algebra.series(shape.mass) * length**2 / 12
    squares = [1 - d * d for d in direction]
    wanted = [across * square for square in squares] + [algebra.ring.number(0)] * 3
    given = [algebra.series(entry) for entry in shape.inertia]
    fits = all((a - b).vanishes() for a, b in zip(wanted, given, strict=True))
    if not length or not across or not fits:
        return None
    return length, direction, [algebra.series(component) for component in shape.center]


def _integrate(density: Series, name: str, length: Series, order: int) -> Series:
    """Return ∫ s^order f(s) ds from 0 to the length, for a polynomial f."""
    ring = density.ring
    terms: Sequence[Any] = [
        coefficient * length ** (power + order + 1) / (power + order + 1)
        for (power,), coefficient in density.coefficients([name]).items()
    ]
    return tidy(ring.sum(list(terms)))


def _divide(moment: Series, force: Series) -> Series | None:
    """Return moment/force if it is the same in any state, a product of parameters; else None."""
    if not force or not moment:
        return None
    # the ratio of the first terms, if it is the ratio of all
    (trig, monomial, c) = next(iter(force.terms()))
    for other_trig, other, d in moment.terms():
        if other_trig == trig:
            ratio = force.ring.monomial(other - monomial) * (d / c)
            if ratio.kinds <= GIVEN and (moment - ratio * force).vanishes():
                return ratio
    return None


class _Letters(NamedTuple):
    """The letters of a force or couple, of its virtual displacement and of its work."""

    act: str
    move: str
    work: str


_MOVES = ({"r": "δr", "u": "δu"}, {"phi": "δφ", "alpha": "δα", "chi": "δχ"})
"""Letters of the displacement of a point, and of the rotation of a body, by coordinates that would
be displaced alike: the first of them that the mechanism does without are taken."""

_LONGEST_WORK = 6
"""Most terms of a work that is written out; longer ones are told by the components' names."""


@final
class Displacements:
    """The virtual displacements δq of a mechanism, at fixed time."""

    def __init__(self, algebra: Algebra) -> None:
        self.ring, self._velocities = algebra.ring, algebra.velocities
        self.names = tuple(f"δ{coordinate_of(v)}" for v in algebra.velocities)
        self.deltas = [self.ring.unknown(name, Kind.VARIATION) for name in self.names]
        move, turn = (self._choose(letters) for letters in _MOVES)
        self.letters = _Letters("F", move, "δW"), _Letters("C", turn, "δW_couple")
        self.meanings: dict[str, str] = {}
        """The meaning of each, by its name."""
        free = "" if algebra.mechanism.constrained else "arbitrary, "
        for name, v in zip(self.names, algebra.velocities, strict=True):
            q = coordinate_of(v)
            of = f"that belongs to the velocity {v}" if q == v else f"of {q}"
            self.meanings[name] = f"virtual displacement {of}: small, {free}at fixed time"

    def _choose(self, letters: Mapping[str, str]) -> str:
        """Return the first letter that is no displacement of a coordinate, numbered if all are."""
        more = ((f"{q}_{k}", f"{letter}_{k}") for k in count(1) for q, letter in letters.items())
        choices = chain(letters.items(), more)
        return next(letter for q, letter in choices if f"δ{q}" not in self.names)

    def vary(self, velocity: Vector) -> Vector:
        """Return the virtual displacement that belongs to a velocity: Σ ∂v/∂q' δq."""
        partials = self.ring.partials
        return Vector(*(self.sum(partials(component)) for component in velocity)).tidy()

    def vary_twist(self, twist: SymbolicWrench) -> SymbolicWrench:
        """Return the virtual displacement and rotation that belong to a twist."""
        return SymbolicWrench(self.vary(twist.force), self.vary(twist.moment))

    def sum(self, slopes: Sequence[Series]) -> Series:
        """Return Σ ∂v/∂q' δq for the slopes ∂v/∂q' of a component."""
        pairs = zip(slopes, self.deltas, strict=True)
        return self.ring.sum([slope * delta for slope, delta in pairs if slope])

    def coefficients(self, works: Sequence[Series]) -> list[Series]:
        """Return the coefficient of each virtual displacement in a sum of works."""
        factors, _ = self.ring.sum(list(works)).linear(self.names)
        return [tidy(factor) for factor in factors]

    def write(self, work: Series) -> Expression:
        """Write a work, what each virtual displacement multiplies in brackets."""
        pairs = zip(self.coefficients([work]), self.deltas, strict=True)
        tidied = [(by_velocity(factor, self._velocities), delta) for factor, delta in pairs]
        return join(bracket(factor, delta) for factor, delta in tidied if factor)


@final
class Ledger:
    """The virtual work of all forces on the bodies of a mechanism, body by body."""

    def __init__(self, balances: FreeBodies, displacements: Displacements) -> None:
        self.cuts = balances.cuts
        self.displacements = displacements
        self._ring = balances.algebra.ring
        acting = {(cut.body, action.name) for cut in self.cuts.bodies for action in cut.applied}
        self._acting = Counter(name for _, name in acting)
        self.inertia: list[Series] = []
        """The work of the inertia forces of each body entered so far."""
        self.weights: list[Series] = []
        self.loads: list[Series] = []

    def enter(self, cut: Cut) -> list[Result]:
        """Enter a body: return the work of weight, inertia forces and loads, entry by entry."""
        lines: list[Result] = []
        body = cut.body
        at_center = self.displacements.vary_twist(cut.twist)
        rotation = at_center.moment
        if cut.inert:
            if any(cut.weight.force):
                weight = SymbolicWrench(cut.weight.force, zero(self._ring))
                self.weights.append(self._enter(lines, f"weight_{body}", cut, weight, at_center))
            velocity, couple = self.seat_of_inertia(cut)
            moved = SymbolicWrench(self.displacements.vary(velocity), rotation)
            inertia = SymbolicWrench(-cut.push.force, couple)
            work = self._enter(lines, f"inertia_{body}", cut, inertia, moved, known=True)
            self.inertia.append(work)
        for action in cut.applied:
            if action.ties:  # where bodies touch or are joined, both points move alike
                continue
            name = f"{action.name}_{body}" if self._acting[action.name] > 1 else action.name
            moved = SymbolicWrench(self.displacements.vary(action.velocity), rotation)
            self.loads.append(self._enter(lines, name, cut, action.wrench, moved))
        return lines

    def locate(self, cut: Cut) -> str:
        """Return a sentence that says where weight and inertia forces act."""
        if not cut.inert:
            return ""
        weight = "The weight acts at the center of mass, t" if any(cut.weight.force) else "T"
        if self.is_spread(cut):
            where = f"where their resultant acts, at the distance s_{cut.body}"
        elif self.is_pivoted(cut):
            where = f"at {call(cut.joint.name)}, which does not move"
        else:
            both = "Weight and i" if any(cut.weight.force) else "The i"
            return f" {both}nertia forces act at the center of mass."
        return f" {weight}he inertia forces {where}."

    def is_spread(self, cut: Cut) -> bool:
        """Return whether the inertia forces of a body are those of a rod, with one resultant."""
        spread = distribution_of(self.cuts, cut)
        points = {point for point in spread.point if point is not None} if spread else set()
        return len(points) == 1 and not any(self._seat_on_rod(cut)[1])

    def is_pivoted(self, cut: Cut) -> bool:
        """Return whether inertia forces are reduced to a fixed point beside the center of mass."""
        beside = cut.fixed and any(cut.center) and any(couple_of_inertia(cut))
        return beside and not self.is_spread(cut)

    def _seat_on_rod(self, cut: Cut) -> tuple[Vector, Vector]:
        """Return the velocity of the point where a rod's inertia forces act, and their couple."""
        spread = distribution_of(self.cuts, cut)
        assert spread is not None
        s = next(point for point in spread.point if point is not None)
        arm = spread.direction * (s - spread.length / 2)
        left = (couple_of_inertia(cut) + cross(arm, cut.push.force)).tidy()
        return total([cut.twist.force, cross(cut.twist.moment, arm)]), left

    def seat_of_inertia(self, cut: Cut) -> tuple[Vector, Vector]:
        """Return the velocity of the point where inertia forces act, and their couple."""
        if self.is_spread(cut):
            return self._seat_on_rod(cut)
        if self.is_pivoted(cut):
            return zero(self._ring), -cut.push.moment
        return cut.twist.force, couple_of_inertia(cut)

    def _enter(
        self,
        lines: list[Result],
        name: str,
        cut: Cut,
        wrench: SymbolicWrench,
        moved: SymbolicWrench,
        *,
        known: bool = False,
    ) -> Series:
        """Enter force and couple that work, unless listed already, with displacement and work."""
        axes, works = cut.axes, [self._ring.number(0)]
        of_force, of_couple = self.displacements.letters
        for letters, act, move, rows, labels in (
            (of_force, wrench.force, moved.force, axes.rows, axes.labels),
            (of_couple, wrench.moment, moved.moment, axes.turns, axes.turn_labels),
        ):
            if not any(act):
                continue
            act, move = along(rows, act), along(rows, move)
            works.append(tidy(dot(act, move)))
            if not works[-1]:
                continue
            products = []
            for label, size, shift in zip(labels, act, move, strict=True):
                if not (size and shift):
                    continue
                acts, moves = ("_".join(filter(None, (x, name, label))) for x in letters[:2])
                if not known:
                    lines.append(Result(Left(acts), size))
                lines.append(Result(Left(moves), shift))
                products.append((acts, moves))
            work, ring = works[-1], self._ring
            left, shown = Left(f"{letters.work}_{name}"), partial(self.displacements.write, work)
            if len(work) > _LONGEST_WORK and len(products) > 1:
                acting = [ring.unknown(acts, Kind.REACTION) for acts, _ in products]
                moving = [ring.unknown(moves, Kind.VARIATION) for _, moves in products]
                pairs = zip(acting, moving, strict=True)
                lines.append(Result(left, ring.sum([size * shift for size, shift in pairs])))
            else:
                lines.append(Result(left, work, shown))
        return self._ring.sum(works)


def couple_of_inertia(cut: Cut) -> Vector:
    """Return the couple of the inertia forces about the center of mass."""
    return (cross(cut.center, cut.push.force) - cut.push.moment).tidy()


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
    """Inertia forces and virtual work of a mechanism as series."""

    def __init__(self, mechanism: Mechanism, algebra: Algebra | None = None) -> None:
        self.algebra = algebra or Algebra(mechanism)
        self.balances = FreeBodies(mechanism, self.algebra)
        self.cuts = self.balances.cuts
        self._displacements = Displacements(self.algebra)
        self.ledger = Ledger(self.balances, self._displacements)
        self._unknowns = self.balances.unknowns | self._displacements.meanings

    def derivation(self) -> Derivation:
        """Return the equations of motion with their steps."""
        algebra, ring = self.algebra, self.algebra.ring
        ledger, displacements = self.ledger, self._displacements
        entries = {cut.body: ledger.enter(cut) for cut in self.balances.bodies}
        sentence = self._explain_work([*lefts_of(chain(*entries.values()))])
        stages = [
            stage
            for cut in self.balances.bodies
            for stage in self._body(cut, sentence, entries[cut.body])
        ]
        spread = [cut.body for cut in self.balances.bodies if cut.inert and ledger.is_spread(cut)]
        inertia = [*ledger.inertia, *ledger.weights, *self._rotors()]
        M, h = mass_and_bias(algebra, [-c for c in displacements.coefficients(inertia)])
        loads = displacements.coefficients(ledger.loads)
        whole = ring.sum([*inertia, *ledger.loads])
        ties = self.cuts.ties
        slopes = [list(map(tidy, tie.slopes(ring))) for tie in ties]
        S = self._independent(slopes) if ties else []
        known = not algebra.mechanism.velocity_constraints
        self._unknowns |= {f"lambda_{tie.name}": tie.meaning for tie in ties}
        return Derivation(
            algebra=algebra,
            M=M,
            h=h,
            Q=tuple(by_velocity(load, algebra.velocities) for load in loads),
            stages=(
                *quaternion_stages(algebra),
                *relation_stages(algebra),
                *inertia_stages(self.cuts.kinematics, spread),
                *self._relate(ties, S),
                *stages,
                *self._reactions(),
                self._sum(whole, free=not ties),
            ),
            assumptions=tuple(self.cuts.assumptions),
            lengths=length_names(ring, self.cuts.lengths.items(), self.cuts.distances),
            closing=_QUASI.format(_name_conditions(ties)) if S else _CLOSING,
            unknowns=self._unknowns,
            reactions=self.balances.reactions if known else {},
            ties=ties,
            quasi=tuple(map(tuple, S)),
        )

    def _independent(self, slopes: Sequence[list[Series]]) -> list[list[Series]]:
        """Return the displacements that the constraints allow; none if those of loops are long."""
        algebra = self.algebra
        try:
            return independent_displacements(algebra.ring, slopes, len(algebra.velocities))
        except DerivationError:
            if not algebra.mechanism.loops:
                raise
            return []

    def _relate(self, ties: Sequence[Tie], S: list[list[Series]]) -> Iterator[Stage]:
        """Yield the steps that express the allowed displacements by independent ones."""
        if not ties:
            return
        yield from loop_stages(ties, of_work=bool(S))
        yield from redundancy_stages(self.algebra.mechanism, ties, of_work=bool(S))
        if not S:
            return
        named: list[Series] = []
        for k, alone in enumerate(list_alone(S)):
            if alone:
                named.append(self._displacements.deltas[alone[0]])
                continue
            name = f"δπ{k + 1}"
            named.append(self.algebra.ring.unknown(name, Kind.VARIATION))
            self._unknowns[name] = INDEPENDENT
        results = []
        for i, name in enumerate(self._displacements.names):
            terms = [column[i] * delta for column, delta in zip(S, named, strict=True) if column[i]]
            right = self.algebra.ring.sum(terms)
            if right != self._displacements.deltas[i]:
                results.append(Result(Left(name), right))
        words = enumerate_words([name_of(delta) for delta in named])
        where = " or ".join(
            sorted({"ψ" if tie.of_velocities else "Φ'" for tie in ties}, reverse=True)
        )
        count = "one" if len(S) == 1 else len(S)
        sentence = (
            "A virtual displacement must satisfy the constraints at fixed time: with it in place "
            f"of the velocities, the terms of {where} that contain velocities sum to zero. That "
            f"leaves {count} independent, {words}; all others follow."
        )
        yield Stage(DISPLACEMENTS, sentence, tuple(results))

    def _sum(self, whole: Series, *, free: bool) -> Stage:
        """Return the step with the sum of all work, by virtual displacement."""
        title, displacements = "Sum of the virtual work", self._displacements
        if not displacements.names:
            return Stage(title, "Nothing can be displaced, so no force does any work.", ())
        single = len(displacements.names) == 1
        are, coefficients = ("is", "its coefficient") if single else ("are", "each coefficient")
        sentence = "As every body is in equilibrium, the work of all forces in "
        sentence += (
            "the virtual displacement, inertia forces included, is zero. As "
            f"{enumerate_words(displacements.names)} {are} arbitrary, {coefficients} is zero."
            if free
            else "a virtual displacement that the constraints allow, inertia forces included, is "
            "zero; the constraint forces between bodies do none. Listed is the part δW of each "
            "coordinate's displacement."
        )
        results = []
        factors = displacements.coefficients([whole])
        for factor, delta in zip(factors, displacements.deltas, strict=True):
            name = name_of(delta).removeprefix("δ")
            left = Left("δW", name, component=True)
            tidied = by_velocity(factor, self.algebra.velocities)
            if tidied or single:
                work = tidied * delta
                results.append(Result(left, work, partial(displacements.write, work)))
        return Stage(title, sentence, tuple(results))

    def _explain_work(self, entries: Sequence[Left]) -> str:
        """Say what the work of a force is, and where bodies turn that of a couple."""
        move, turn = (letters.move for letters in self._displacements.letters)
        turns = any(left.quantity.startswith(f"{turn}_") for left in entries)
        couples = [left.symbol for left in entries if left.symbol.startswith("C_")]
        couple = f", each couple [C] in the virtual rotation {turn} of the body" if turns else ""
        return self.algebra.say(
            f"Each force [F] does work in the virtual displacement {move} of its point{couple}: "
            "δW is the sum of the products of their components. Those that do no work are not "
            "listed.",
            C=couples,
        )

    def _body(self, cut: Cut, sentence: str, entries: Sequence[Result]) -> Iterator[Stage]:
        """Yield the steps of a body: inertia forces, equilibrium, work of all forces on it."""
        if cut.inert:
            yield self._inertia_forces(cut)
        yield from self._equilibrium(cut)
        if entries:
            said = f"{sentence}{self.ledger.locate(cut)}"
            yield Stage(f"Virtual work on {cut.body}", said, tuple(entries))

    def _inertia_forces(self, cut: Cut) -> Stage:
        """Return the step with d'Alembert's inertia forces and their resultant."""
        body, axes = cut.body, cut.axes
        spread = distribution_of(self.cuts, cut) if self.ledger.is_spread(cut) else None
        fixed = f"the fixed point {cut.joint.name}"
        point = fixed if self.ledger.is_pivoted(cut) else "the center of mass"
        entries = self.algebra.mechanism.body(body).inertia
        as_particle = bool(cut.mass) and not any(map(self.algebra.series, entries))
        said = f"Every particle of {call(body)} has an inertia force opposite to its acceleration"
        if as_particle:
            said = (
                f"Without moments of inertia, {call(body)} has the inertia force [F] of a "
                "particle, minus its mass times the acceleration of its center of mass"
            )
        parts = [f"{said}.", axes.sentence]
        results = []
        if spread is not None:
            self._unknowns[spread.coordinate] = DISTANCE
            parts.append(
                "On the rod they have the density [f] per length at the distance "
                f"{spread.coordinate} from its end; each component integrates to F_inertia_{body}, "
                f"which acts at the distance s_{body}, where it has their moment."
            )
            results += _list_spread_forces(spread, cut)
        else:
            F = -along(axes.rows, cut.push.force)
            results += list_components(f"F_inertia_{body}", axes.labels, F)
        couple = self.ledger.seat_of_inertia(cut)[1]
        C = along(axes.turns, couple)
        if spread is None and not as_particle:
            beside = ", and a couple [C], minus the rate of the angular momentum about that point"
            parts.append(
                f"Reduced to {point} they are one force [F], minus the mass times the acceleration "
                f"of the center of mass{beside if any(C) else ''}."
            )
        results += list_components(f"C_inertia_{body}", axes.turn_labels, C)
        if not results:
            parts.append("Here they are all zero.")
        letters = {"F": [f"F_inertia_{body}"], "C": [f"C_inertia_{body}"], "f": [f"f_{body}"]}
        sentence = self.algebra.say(" ".join(parts), **letters)
        return Stage(f"Inertia forces of {body}", sentence, tuple(results))

    def _equilibrium(self, cut: Cut) -> Iterator[Stage]:
        """Yield the step with the sums of all forces and moments, inertia forces included."""
        nothing = self.algebra.ring.number(0)
        push = cut.axes.along(cut.about_reference(cut.push))
        left = self.balances.acting_along(cut) - push
        sums = () if self.balances.repeats(cut) else left.moment
        lines = [Result(total, nothing) for total in (*left.force, *sums) if total]
        if not lines:  # without mass and forces it only leads others
            return
        about = call(cut.joint.name) if cut.fixed or not cut.mass else "the center of mass"
        moments = f", then of moments about {about}," if any(sums) else ""
        sentence = (
            f"{self.balances.explain_leaders(cut)}Under all forces on it, inertia forces included, "
            f"the body is in equilibrium: the sums of forces{moments} are zero."
        )
        yield Stage(f"Equilibrium of {cut.body}", sentence, tuple(lines))

    def _rotors(self) -> list[Series]:
        """Return the virtual work of the inertia of the joints' rotors."""
        rates = [rate for rate in self.balances.rates if rate.rotor]
        return [-rate.rotor * self._displacements.sum(rate.partials) for rate in rates]

    def work_of_reaction(self, cut: Cut) -> Series:
        """Return the virtual work of a joint's reaction together with its opposite."""
        # the displacement of the body's origin, and its rotation, in its parent
        cuts, parent = self.cuts, self.balances.holder(cut)
        twists = map(cuts.kinematics.twist, (cut.body, parent))
        own, carrying = map(self._displacements.vary_twist, twists)
        arm = cuts.between_seats(parent, cut.body)
        moved = total([carrying.force, cross(carrying.moment, arm)])
        shift, turn = (cuts.carry(part, parent, cut.body) for part in (moved, carrying.moment))
        return tidy(self.balances.symbols[cut.body].power(own - SymbolicWrench(shift, turn)))

    def _reactions(self) -> list[Stage]:
        """Return the step with the work of each joint's reaction together with its opposite."""
        if not self.balances.unknowns:
            return []
        lines = []
        for cut in filter(self.balances.transmits, self.balances.bodies):
            work = self.work_of_reaction(cut)
            lines += [Result(Left(f"δW_R_{cut.joint.name}"), work)] if work else []
        sentence = (
            "A reaction acts on the child, its opposite on the parent at the same point: together "
            "they do work only in the relative displacement of the two, and that the joint allows "
            "only in directions in which it transmits nothing. The reactions do no work."
        )
        if balanced := self.balances.sum_guides():
            sentence += (
                " The forces that guide dependent coordinates count as reactions; they do work in "
                "single joints, but none in total, as the last lines state."
                if self.algebra.mechanism.coordinates.driven
                else " That it transmits nothing there is stated by the last lines."
            )
            lines += balanced
        if self.balances.guiding.names:
            kinematics, vary = self.cuts.kinematics, self._displacements.vary_twist
            lines += self.balances.guiding.list_works(lambda cut: vary(kinematics.twist(cut.body)))
            sentence += (
                " The forces of cords, wheels and other elements work on each of the bodies they "
                "join, and do none in total: what one body receives the others give."
            )
        if any(rate.rotor for rate in self.balances.rates):
            sentence += " Where a joint has a rotor, the work of its inertia remains."
        return [Stage("Virtual work of the reactions", sentence, tuple(lines))]


def _list_spread_forces(spread: Distribution, cut: Cut) -> list[Result]:
    """List the density f and its resultant F by component, and the point where that acts."""
    results = []
    (point,) = {point for point in spread.point if point is not None}
    for label, f, F in zip(cut.axes.labels, spread.density, spread.resultant, strict=True):
        if f:
            results.append(Result(Left(f"f_{cut.body}_{label}"), f))
            results.append(Result(Left(f"F_inertia_{cut.body}_{label}"), F))
    return [*results, Result(Left(f"s_{cut.body}"), point)]


def _name_conditions(ties: Sequence[Tie]) -> str:
    """Name the equations of the constraints: Φ = 0, ψ = 0 or both."""
    held = {"ψ = 0" if tie.of_velocities else "Φ = 0" for tie in ties}
    return " and ".join(sorted(held))
