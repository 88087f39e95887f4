"""Write the balances of bodies cut free, with named reactions and their closed forms."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, final

from mecanique.derivation.numeric.newton_euler import Balances
from mecanique.derivation.scalars.cancel import tidy
from mecanique.derivation.scalars.generators import Kind
from mecanique.derivation.scalars.series import Series
from mecanique.derivation.symbolic.derivation import Left, Result
from mecanique.derivation.symbolic.free_bodies.bodies import Cut, Cuts
from mecanique.derivation.symbolic.free_bodies.elements import Guiding
from mecanique.derivation.symbolic.free_bodies.elimination import (
    JointRate,
    demands,
    joint_rates,
)
from mecanique.derivation.symbolic.free_bodies.sentences import (
    describe_reaction,
)
from mecanique.derivation.symbolic.kinematics import Kinematics
from mecanique.derivation.symbolic.symbols import Algebra
from mecanique.derivation.symbolic.vectors import (
    Vector,
    Wrench,
    along,
    component,
    cross,
    lift,
    total,
    zero,
)
from mecanique.derivation.tree.poses import combination
from mecanique.model.guides.find import guides_of
from mecanique.model.guides.guide import explain_joint
from mecanique.model.mechanism import Mechanism

_LETTERS = {"force": "R", "moment": "M"}
"""Letters of the reactions."""

_TOTALS = {"force": "S", "moment": "C"}
"""Letters of the totals across a joint with a guide that no element describes."""


@final
class FreeBodies:
    """The balances of every body of a mechanism as series, and the reactions in closed form.

    Args:
        mechanism: any mechanism.
        algebra: its symbols.

    Raises:
        DerivationError: if the mechanism has no closed form of reasonable length.
    """

    def __init__(self, mechanism: Mechanism, algebra: Algebra) -> None:
        self.algebra = algebra
        self.cuts = Cuts(Kinematics(self.algebra))
        self.rates = joint_rates(self.cuts)
        every = Balances(mechanism).guides if mechanism.elements else guides_of(mechanism)
        self.guides = [guide for guide in every if guide.crossed]
        """The guides that no element describes."""
        self._held = {name for guide in every for name in guide.coordinates}
        self.guiding = Guiding(self.cuts)
        free = {cut.body: self._free(cut) for cut in self.cuts.bodies}
        self.demands = demands(self.cuts, _need, None if mechanism.elements else free)
        """The wrench that each joint must transmit to its child, by name of the child."""
        self.unknowns: dict[str, str] = dict(self.guiding.meanings)
        """The meaning of each reaction, by its name."""
        self.symbols: dict[str, Wrench] = {}
        """The wrench of each joint on its child in terms of named reactions, by child."""
        self._own: dict[str, Wrench] = {}
        self.zeros: list[str] = []
        self.closed: list[Result] = []
        self.guide_forces: list[Result] = []
        if mechanism.elements:
            self._find_guide_forces()
        for cut in self.cuts.bodies:
            self._name_reactions(cut)

    @property
    def reactions(self) -> dict[str, Series]:
        """The closed form of each reaction that is not identically zero, by name, e.g. R_pin_n."""
        return {
            result.left.quantity: result.right
            for result in (*self.guide_forces, *self.closed)
            if isinstance(result.left, Left)
        }

    def _name_reactions(self, cut: Cut) -> None:
        """Name the reactions of a body's joint, except components that vanish identically."""
        ring, free, demand = self.algebra.ring, self._free(cut), self.demands[cut.body]
        letters = _TOTALS if self.is_guided(cut) else _LETTERS
        nothing = [ring.number(0)] * 3
        own = {"force": nothing.copy(), "moment": nothing.copy()}
        sums = {"force": [zero(ring)], "moment": [zero(ring)]}
        for d in cut.axes.directions:
            loose = [
                rate for rate in free if rate.kind == d.kind and _is_parallel(d.row, rate.axis)
            ]
            if loose:  # along this direction the joint transmits only the force of its rotor
                sums[d.kind] += [rate.axis * -rate.rotor for rate in loose]
                continue
            name = "_".join(filter(None, (letters[d.kind], cut.joint.name, d.label)))
            value = component(d.row, demand.part(d.kind))
            if value.vanishes():
                self.zeros.append(name)
                continue
            R = d.sign * ring.unknown(name, Kind.REACTION)
            own[d.kind][d.place] = R
            sums[d.kind].append(lift(ring, d.row) * R)
            self.unknowns[name] = describe_reaction(cut, d, guided=self.is_guided(cut))
            self.closed.append(Result(Left(name), d.sign * value))
        self.symbols[cut.body] = Wrench(total(sums["force"]), total(sums["moment"]))
        self._own[cut.body] = Wrench(Vector(*own["force"]), Vector(*own["moment"]))

    def _find_guide_forces(self) -> None:
        """Solve for the forces of elements, and remove their actions from the joints' wrenches."""
        carried, guiding = self.guiding.balance_units(), self.guiding
        free = [rate for cut in self.cuts.bodies for rate in self._free(cut)]
        found = guiding.solve(free, self.demands, carried)
        sizes = guiding.symbols if found is None else found
        if found is not None:
            pairs = zip(guiding.names, found, strict=True)
            self.guide_forces = [Result(Left(name), size) for name, size in pairs]
        pressing = guiding.balance_pressing()
        for cut in self.cuts.bodies:
            whole = self.demands[cut.body]
            for size, under in zip(sizes, carried, strict=True):
                part = under[cut.body]
                whole = Wrench(
                    total([whole.force, part.force * size]),
                    total([whole.moment, part.moment * size]),
                )
            for size, under in pressing:
                part = under[cut.body]
                whole = Wrench(
                    total([whole.force, part.force * size]),
                    total([whole.moment, part.moment * size]),
                )
            self.demands[cut.body] = whole.tidy()

    def is_guided(self, cut: Cut) -> bool:
        """Return whether a guide that no element describes acts across a body's joint."""
        return bool(explain_joint(self.guides, cut.joint.name))

    def _free(self, cut: Cut) -> list[JointRate]:
        """Return the joint velocities along which a body's joint transmits nothing."""
        algebra = self.algebra
        here = [rate for rate in self.rates if rate.body == cut.body]
        if len(self.rates) == len(algebra.velocities):
            return here
        if algebra.mechanism.elements:
            own = cut.joint.followers
            return [] if own else [rate for rate in here if rate.name not in self._held]
        driven = algebra.mechanism.coordinates.driven
        guided = set(driven)
        for name in driven:
            guided |= {g.name for g in algebra.lift(algebra.values[name]).generators()}
        return [rate for rate in here if rate.name not in guided]

    def resultant(self, cut: Cut) -> Vector:
        """Return the resultant force on a body with named reactions, in its carrier's axes."""
        back = [wrench.force for _, wrench in self._collect_behind(cut)]
        held = self.guiding.on(cut).force
        return total([cut.weight, cut.loads().force, held, self.symbols[cut.body].force, *back])

    def forces_along(self, cut: Cut) -> Vector:
        """Return the resultant force along the axes in which the body's equations are written.

        The reaction in the body's own joint is not projected: that would expand n·n = 1.
        """
        rest = self.resultant(cut) - self.symbols[cut.body].force
        known = total([rest, self._rotors(cut, "force")])
        return along(cut.axes.rows, known) + self._own[cut.body].force

    def moments_along(self, cut: Cut) -> Vector:
        """Return the resultant moment about the axes in which the body's equations are written."""
        rest = self.moment(cut) - self.symbols[cut.body].moment
        known = total([rest, self._rotors(cut, "moment")])
        return along(cut.axes.turns, known) + self._own[cut.body].moment

    def _rotors(self, cut: Cut, kind: str) -> Vector:
        """Return the force or moment on the rotor of a body's joint, with opposite sign."""
        found = zero(self.algebra.ring)
        for rate in self._free(cut):
            if rate.kind == kind and rate.rotor:
                found = found - rate.axis * rate.rotor
        return found

    def turning(self, cut: Cut) -> Vector:
        """Return the rate of angular momentum about the fixed point, or else the center of mass."""
        return total([cut.turning, cross(_lead_back(cut), cut.push)])

    def moment(self, cut: Cut) -> Vector:
        """Return the resultant moment about the fixed point, or else the center of mass."""
        moments = [cut.weight_moment, cut.loads().moment, self.symbols[cut.body].moment]
        moments.append(self.guiding.on(cut).moment)
        moments.append(cross(_lead_back(cut), self.resultant(cut)))
        for place, wrench in self._collect_behind(cut):
            moments += [wrench.moment, cross(place, wrench.force)]
        return total(moments)

    def _collect_behind(self, cut: Cut) -> list[tuple[Vector, Wrench]]:
        """Return the position of each joint that a body carries, and its wrench on the body."""
        found = []
        for other in self.cuts.bodies:
            if other.joint.parent == cut.body:
                back = -self.cuts.carried_wrench(self.symbols[other.body], other.body, cut.body)
                found.append((self.cuts.between_seats(cut.body, other.body), back))
        return found

    def sum_guides(self) -> list[Result]:
        """Return the sums of reactions along guided joints, zero for each virtual displacement."""
        algebra, ring = self.algebra, self.algebra.ring
        sums: list[list[Series]] = [[] for _ in algebra.velocities]
        for rate in self.rates:
            reaction = self.symbols[rate.body].part(rate.kind)
            size = algebra.lift(combination(rate.axis, reaction))
            for terms, slope in zip(sums, rate.partials, strict=True):
                if slope:
                    terms.append(tidy(slope * size))
        return [Result(whole, ring.number(0)) for terms in sums if (whole := ring.sum(terms))]


def needs(cut: Cut) -> Wrench:
    """Return the wrench that a body needs for its motion: rates of momentum less weight."""
    return Wrench(cut.push - cut.weight, cut.turning - cut.weight_moment).tidy()


def _need(cut: Cut) -> Wrench:
    """Return the wrench that a body needs in addition to its loads."""
    return needs(cut) - cut.loads()


def _lead_back(cut: Cut) -> Vector:
    """Return the vector from the reference point of moments to the origin of the body's frame."""
    return zero(cut.mass.ring) if cut.fixed else -cut.center


def _is_parallel(row: Sequence[Any], axis: Vector) -> bool:
    """Whether a direction is an axis or its opposite."""
    return lift(axis.x.ring, row) in (axis, -axis)
