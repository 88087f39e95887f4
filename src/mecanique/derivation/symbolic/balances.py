"""Eliminate the reactions from the tips to the ground, by the wrench that each joint must transmit.

A body needs F = d/dt p − m g − F_applied + Σ F_child from its joint, and likewise moments about the
origin of its frame: equations are solved only by moving terms, which keeps closed forms short.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import combinations
from typing import final

import numpy as np

from mecanique.arrays import rank_of
from mecanique.derivation.mechanics.elements import UnitForce, unit_forces
from mecanique.derivation.numeric.newton_euler import Balances
from mecanique.derivation.printing.equations import expression, join
from mecanique.derivation.scalars.cancel import tidy
from mecanique.derivation.scalars.evaluation import Evaluation
from mecanique.derivation.scalars.series import Kind, Ring, Series
from mecanique.derivation.symbolic.cutting import (
    Cut,
    Cuts,
    describe_reaction,
)
from mecanique.derivation.symbolic.derivation import Left, Result
from mecanique.derivation.symbolic.kinematics import Kinematics
from mecanique.derivation.symbolic.multipliers import cramer, determinant
from mecanique.derivation.symbolic.symbols import Algebra
from mecanique.derivation.symbolic.vectors import (
    SymbolicWrench,
    Vector,
    component,
    cross,
    dot,
    lift,
    no_wrench,
    resultant,
    total,
    zero,
)
from mecanique.derivation.tolerances import RANK
from mecanique.derivation.tree.links import Link
from mecanique.derivation.tree.poses import combination
from mecanique.model import Gear, Mechanism, Rack
from mecanique.model.constraint_base import Strung
from mecanique.model.constraints.elements import preloads
from mecanique.model.expression import Scalar
from mecanique.model.guides import explain_joint, guides_of
from mecanique.model.mechanism.letters import call
from mecanique.wording import enumerate_words


@final
@dataclass(frozen=True)
class JointRate:
    """A joint velocity with its direction and its derivatives by the generalized velocities."""

    body: str  # the child that it moves
    kind: str  # "force" or "moment", the part of a reaction that does work with it
    axis: Vector  # its direction in the axes of the child's carrier
    name: str  # name of the joint coordinate or quasi-velocity
    partials: tuple[Series, ...]  # its derivative by each generalized velocity
    rotor: Series  # moment or force that accelerates the joint's rotor

    @property
    def wrench(self) -> SymbolicWrench:
        """The force or the moment that does unit power with it."""
        nothing = zero(self.rotor.ring)
        forces = self.kind == "force"
        return SymbolicWrench(self.axis, nothing) if forces else SymbolicWrench(nothing, self.axis)

    def component(self, wrench: SymbolicWrench) -> Series:
        """Return the component of a wrench along or about its direction."""
        return dot(self.axis, wrench.part(self.kind))


def demands(
    cuts: Cuts,
    part: Callable[[Cut], SymbolicWrench],
    relieve: Callable[[Cut, SymbolicWrench], SymbolicWrench] = lambda _, whole: whole,
) -> dict[str, SymbolicWrench]:
    """Return the wrench that every joint must transmit, by name of its child."""
    # Force and moment are in the axes of the child's carrier, the moment about the child's origin
    needed: dict[str, SymbolicWrench] = {}
    behind: dict[str, list[str]] = {}
    for cut in cuts.bodies:
        behind.setdefault(cut.joint.parent, []).append(cut.body)
    for cut in reversed(cuts.bodies):
        carried = [cuts.hand_down(needed[c], c, cut.body) for c in behind.get(cut.body, ())]
        needed[cut.body] = relieve(cut, resultant([part(cut), *carried])).tidy()
    return needed


def joint_rates(cuts: Cuts) -> tuple[JointRate, ...]:
    """Return the joint velocities in the order of the tree."""
    child = {joint.name: joint.child for joint in cuts.algebra.mechanism.joints}
    rates: list[JointRate] = []
    for place, link in enumerate(cuts.kinematics.tree):
        if link.kind in ("turn", "slide"):
            rates.append(_find_axial(cuts, place, child[link.joint]))
        elif link.kind in ("ball", "free"):
            rates += _list_quasi(cuts.algebra, link, child[link.joint])
    return tuple(rates)


def _find_axial(cuts: Cuts, place: int, body: str) -> JointRate:
    """Return the joint velocity of a hinge or a slide."""
    algebra, link = cuts.algebra, cuts.kinematics.tree[place]
    r = algebra.lift(algebra.values[link.coordinates[0]])
    axis = algebra.arithmetic.direction(link.axis)
    turn = cuts.kinematics.turn(place)
    inertia = algebra.series(link.armature)
    return JointRate(
        body=body,
        kind="moment" if link.kind == "turn" else "force",
        axis=lift(algebra.ring, [combination(row, axis) for row in turn]).tidy(),
        name=link.coordinates[0],
        partials=tuple(tidy(slope) for slope in algebra.ring.along(r)),
        rotor=tidy(inertia * r.ddt().ddt()) if inertia else algebra.ring.number(0),
    )


def _list_quasi(algebra: Algebra, link: Link, body: str) -> Iterator[JointRate]:
    """Yield the quasi-velocities of a quaternion joint, along and about the child's own axes."""
    number = algebra.ring.number
    kinds = ("force",) * (len(link.velocities) - 3) + ("moment",) * 3
    for k, (name, kind) in enumerate(zip(link.velocities, kinds, strict=True)):
        axis = Vector(*(number(int(i == k % 3)) for i in range(3)))
        partials = tuple(number(int(v == name)) for v in algebra.velocities)
        yield JointRate(
            body=body, kind=kind, axis=axis, name=name, partials=partials, rotor=number(0)
        )


def project(
    cuts: Cuts, rates: Iterable[JointRate], wrenches: Mapping[str, SymbolicWrench], *, rotors: bool
) -> list[Series]:
    """Project reactions on the generalized velocities: Σ ∂u/∂v × (reaction · axis + rotor)."""
    ring = cuts.algebra.ring
    sums: list[list[Series]] = [[] for _ in cuts.algebra.velocities]
    for rate in rates:
        size = rate.component(wrenches[rate.body])
        if rotors:
            size = size + rate.rotor
        for terms, slope in zip(sums, rate.partials, strict=True):
            if slope:
                terms.append(tidy(slope * size))
    return [tidy(ring.sum(terms)) for terms in sums]


_MOST = 3
"""Systems with more unknown forces than this are solved in numbers only."""


@final
class Guiding:
    """The unknown forces of a mechanism's elements, and their actions on its bodies."""

    def __init__(self, cuts: Cuts) -> None:
        self._cuts = cuts
        self._algebra = cuts.algebra
        mechanism, ring = self._algebra.mechanism, self._algebra.ring
        ground = replace(cuts.kinematics.ground, wave=self._wave)
        units = unit_forces(mechanism, ground) if mechanism.elements else []
        axes = {(unit.index, unit.body): _name_axis(ring, unit) for unit in units}
        self.meanings = dict(_list_meanings(mechanism, axes))
        """The meaning of each unknown, by its name."""
        self.names = [*self.meanings]
        self.symbols = [ring.unknown(name, Kind.REACTION) for name in self.names]
        self._parting: dict[int, Series] = {}
        """The separating force |F| sin α of meshing wheels, by index of F."""
        for index in sorted({unit.index for unit in units if unit.pressed and any(unit.force)}):
            _, _, stem = self.names[index].partition("_")
            self._parting[index] = ring.unknown(f"N_{stem}", Kind.REACTION)
            of = f"|{self.names[index]}| sin(pressure angle)"
            self.meanings[f"N_{stem}"] = f"separating force, {of} [N]"
        self._actions: dict[tuple[int, bool], dict[str, list[SymbolicWrench]]] = {}
        """The wrenches on each body of each force and, with True, of its separating force."""
        for unit in units:
            if not unit.pressed or unit.index in self._parting:
                on = self._actions.setdefault((unit.index, unit.pressed), {})
                if cuts.kinematics.place[unit.body] >= 0:
                    on.setdefault(unit.body, []).append(self._refer(unit))

    def on(self, cut: Cut) -> SymbolicWrench:
        """Return the elements' wrench on a body, about the origin of its frame."""
        return self._sum(cut, {force: self._size(force) for force in self._actions})

    def acting_on(self, cut: Cut) -> list[str]:
        """Return the names of the forces that act on a body."""
        return [str(self._size(force)) for force, on in self._actions.items() if cut.body in on]

    def balance(self) -> list[tuple[Series, dict[str, SymbolicWrench]]]:
        """Return each force, separating ones last, with the joints' wrenches that balance its unit.

        The wrenches are by name of the child.
        """
        one, balances = self._algebra.ring.number(-1), []
        for force in sorted(self._actions, key=lambda force: force[::-1]):
            resist = partial(self._sum, sizes={force: one})
            balances.append((self._size(force), demands(self._cuts, resist)))
        return balances

    def list_works(self, twist: Callable[[Cut], SymbolicWrench]) -> Iterator[Result]:
        """Yield the work of each force in a displacement of the bodies, as a sum over these."""
        for force, on in self._actions.items():
            size = self._size(force)
            bodies = [cut for cut in self._cuts.bodies if cut.body in on]
            works = [tidy(self._sum(cut, {force: size}).power(twist(cut))) for cut in bodies]
            if any(works):
                shown = partial(join, [expression(work) for work in works if work])
                yield Result(Left(f"δW_{size}"), tidy(self._algebra.ring.sum(works)), shown)

    def _sum(self, cut: Cut, sizes: Mapping[tuple[int, bool], Series]) -> SymbolicWrench:
        """Return the wrench on a body under forces of some sizes."""
        acting = [
            wrench * size
            for force, size in sizes.items()
            for wrench in self._actions[force].get(cut.body, ())
        ]
        return resultant([no_wrench(self._algebra.ring), *acting]).tidy()

    def _size(self, force: tuple[int, bool]) -> Series:
        index, presses = force
        return self._parting[index] if presses else self.symbols[index]

    def solve(
        self,
        rates: Sequence[JointRate],
        totals: Mapping[str, SymbolicWrench],
        carried: Sequence[Mapping[str, SymbolicWrench]],
    ) -> list[Series] | None:
        """Solve for the forces in closed form; return None if there is no short one."""
        count = len(self.names)
        rows = []
        for rate in rates:
            row = [tidy(rate.component(unit[rate.body])) for unit in carried]
            known = tidy(rate.component(totals[rate.body]) + rate.rotor)
            if any(row):
                rows.append(([-c for c in row], known))
        algebra, ring = self._algebra, self._algebra.ring
        for preload in preloads(algebra.mechanism.elements):
            together = [ring.number(int(k in preload.forces)) for k in range(count)]
            rows.append((together, algebra.series(preload.total)))
        if not 0 < count <= _MOST or len(rows) < count:
            return None
        # take the shortest equations that determine the forces
        rows.sort(key=lambda equation: sum(map(len, (*equation[0], equation[1]))))
        for chosen in combinations(rows, count):
            divisor = determinant(ring, [row for row, _ in chosen])
            if not divisor.vanishes():
                break
        else:
            return None
        above = cramer(ring, [row for row, _ in chosen], [known for _, known in chosen])
        return [tidy(numerator / divisor) for numerator in above]

    def _refer(self, unit: UnitForce) -> SymbolicWrench:
        """Refer a unit force to the origin of its body's frame, in the axes of its carrier."""
        ring = self._algebra.ring
        point, force, moment = (lift(ring, part) for part in (unit.point, unit.force, unit.moment))
        wrench, arm = self._cuts.refer(unit.body, point, SymbolicWrench(force, moment))
        return wrench.about(arm).tidy()

    def _wave(self, angle: Scalar) -> tuple[Series, Series]:
        """Return cosine and sine of a pressure angle, with 1 for the sine that N contains."""
        algebra = self._algebra
        value = algebra.mechanism.evaluate(angle)
        if not value:
            return algebra.ring.number(1), algebra.ring.number(0)
        from sympy import cos, sympify

        return algebra.series(cos(sympify(angle))), algebra.ring.number(1)


def _name_axis(ring: Ring, unit: UnitForce) -> str:
    """Return the world's axis that a unit force is along in every position, "" if none."""
    for axis, size in zip("xyz", lift(ring, unit.force).tidy(), strict=True):
        if size in (1, -1):
            return axis if size == 1 else f"-{axis}"
    return ""


def _list_meanings(
    mechanism: Mechanism, axes: Mapping[tuple[int, str], str]
) -> Iterator[tuple[str, str]]:
    """Yield the name of each unknown force with its meaning and unit.

    The world's axis that it is along, if any, is given by its index and the body it acts on.
    """
    following = 0
    for element in mechanism.elements:
        first, following = following, following + len(element.forces)
        if isinstance(element, Strung):
            stops = element.stops
            for name, part in zip(element.forces, dict.fromkeys(element.parts), strict=True):
                places = [k for k, run in enumerate(element.parts) if run == part]
                start, end = stops[places[0]].body, stops[places[-1] + 1].body
                yield (
                    f"T_{name}",
                    f"tension of {call(element.name)} from {call(start)} to {call(end)} [N]",
                )
            continue
        if isinstance(element, (Gear, Rack)):
            a, b = (call(mechanism.joint(joint).child) for joint in element.joints)
            where = f"force of {a} on {b} in {call(element.name)} along the line of action"
            yield from ((f"F_{name}", f"{where} [N]") for name in element.forces)
            continue
        forces = dict(enumerate(element.forces, first))
        worlds = [axes.get((k, element.body_b), "") for k, x in forces.items() if ": r" not in x]
        named = all(world in [*"xyz"] for world in worlds)  # by the axes of the world
        for k, name in forces.items():
            row = name.rpartition(": ")[2]
            turns = row.startswith("r")
            world = axes.get((k, element.body_b))
            axis = f"along {world} of the world" if world else f"along {row[-1]} of its frame"
            axis = "along its length" if row == "length" else axis
            row = world if world and named and row in [*"xyz"] else row
            yield (
                f"{'M' if turns else 'R'}_{element.name}_{row}",
                f"{'moment' if turns else 'force'} that {call(element.body_a)} exerts on "
                f"{call(element.body_b)} in {call(element.name)}, {axis} "
                f"[{'N·m' if turns else 'N'}]",
            )


_LETTERS = {"force": "R", "moment": "M"}
"""Letters of the reactions."""

_TOTALS = {"force": "S", "moment": "C"}
"""Letters of the totals across a joint with a guide that no element describes."""


@final
class FreeBodies:
    """The balances of every body of a mechanism as series, and the reactions in closed form."""

    def __init__(self, mechanism: Mechanism, algebra: Algebra) -> None:
        self.algebra = algebra
        self.cuts = Cuts(Kinematics(self.algebra))
        self.rates = joint_rates(self.cuts)
        every = Balances(mechanism).guides if mechanism.elements else guides_of(mechanism)
        self.guides = [guide for guide in every if guide.crossed]
        """The guides that no element describes."""
        self._held = {name for guide in every for name in guide.coordinates}
        self.guiding = Guiding(self.cuts)
        self.leaders = dict(self._find_leaders())
        """The body without mass and load that leads a body and no other, by the body it leads."""
        leading = {leader.body for leader in self.leaders.values()}
        self.bodies = tuple(cut for cut in self.cuts.bodies if cut.body not in leading)
        """The bodies that are cut free; joints on both sides of a leader are cut as one."""
        self._idle: dict[str, dict[tuple[str, int], bool]] = {}
        """The directions in which no joint that leads to a body transmits anything."""
        relieve = (lambda _, whole: whole) if mechanism.elements else self._relieve
        self.demands = demands(self.cuts, lambda cut: needs(cut) - cut.loads(), relieve)
        """The wrench that each joint must transmit to its child, by name of the child."""
        self.unknowns: dict[str, str] = dict(self.guiding.meanings)
        """The meaning of each reaction, by its name."""
        self.symbols: dict[str, SymbolicWrench] = {}
        """The wrench of each joint on its child in terms of named reactions, by child."""
        self._own: dict[str, SymbolicWrench] = {}
        self.zeros: list[tuple[str, bool]] = []
        """The reactions that vanish though their joint is not free, and whether by plane motion."""
        self.closed: list[Result] = []
        self.guide_forces: list[Result] = []
        if mechanism.elements:
            self._find_guide_forces()
        for cut in self.bodies:
            self._name_reactions(cut)
        for cut in reversed(self.cuts.bodies):
            if (leader := self.leaders.get(cut.body)) is not None:
                wrench = self.cuts.hand_down(self.symbols[cut.body], cut.body, leader.body)
                self.symbols[leader.body] = wrench.tidy()

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
        named = {"force": nothing.copy(), "moment": nothing.copy()}
        sums = {"force": [zero(ring)], "moment": [zero(ring)]}
        zeros = list[tuple[str, bool]]()
        if cut.body not in self._idle:
            self._idle[cut.body] = self._find_idle(cut, demand)
        idle = self._idle[cut.body]
        for d in cut.axes.directions:
            loose = [
                rate
                for rate in free
                if rate.kind == d.kind and lift(ring, d.row) in (rate.axis, -rate.axis)
            ]
            name = "_".join(filter(None, (letters[d.kind], cut.joint.name, d.label)))
            if loose or (d.kind, d.place) in idle:  # the joint transmits only a rotor's force
                sums[d.kind] += [rate.axis * -rate.rotor for rate in loose if rate.rotor]
                if not (loose or idle[d.kind, d.place]):
                    zeros.append((name, cut.axes.across_plane(d)))
                continue
            value = component(d.row, demand.part(d.kind))
            R = d.sign * ring.unknown(name, Kind.REACTION)
            named[d.kind][d.place] = R
            sums[d.kind].append(lift(ring, d.row) * R)
            self.unknowns[name] = describe_reaction(
                cut, d, self.holder(cut), guided=self.is_guided(cut)
            )
            self.closed.append(Result(Left(name), d.sign * value))
        self.symbols[cut.body] = SymbolicWrench(total(sums["force"]), total(sums["moment"]))
        self._own[cut.body] = SymbolicWrench(Vector(*named["force"]), Vector(*named["moment"]))
        if self.transmits(cut):
            self.zeros += zeros

    def _find_guide_forces(self) -> None:
        """Solve for the forces of elements, and remove their actions from the joints' wrenches."""
        names, balanced = self.guiding.names, self.guiding.balance()
        sizes = [size for size, _ in balanced]
        carried = [under for _, under in balanced]
        free = [rate for cut in self.cuts.bodies for rate in self._free(cut)]
        solved = self.guiding.solve(free, self.demands, carried[: len(names)])
        if solved is not None:
            pairs = zip(names, solved, strict=True)
            self.guide_forces = [Result(Left(name), size) for name, size in pairs]
            sizes[: len(names)] = solved
        for cut in self.cuts.bodies:
            parts = [under[cut.body] * size for size, under in zip(sizes, carried, strict=True)]
            self.demands[cut.body] = resultant([self.demands[cut.body], *parts]).tidy()

    def transmits(self, cut: Cut) -> bool:
        """Return whether a body's joint transmits any reaction."""
        return any(map(any, (self._own[cut.body].force, self._own[cut.body].moment)))

    def list_chain(self, cut: Cut) -> list[Cut]:
        """Return a body and the bodies without mass that lead it, toward the ground."""
        chain = [cut]
        while (leader := self.leaders.get(chain[-1].body)) is not None:
            chain.append(leader)
        return chain

    def holder(self, cut: Cut) -> str:
        """Return the body, or the ground, that holds a body by the joints that lead to it."""
        return self.list_chain(cut)[-1].joint.parent

    def explain_leaders(self, cut: Cut) -> str:
        """Return a sentence that says by which joints and bodies a body is held as by one joint."""
        chain = self.list_chain(cut)[::-1]
        if len(chain) == 1 or not self.transmits(cut):
            return ""
        (*leaders, _), joints = ([x.body for x in chain], [x.joint.name for x in chain])
        them = ("body", "has", "it") if len(leaders) == 1 else ("bodies", "have", "them")
        what, have, these = them
        return (
            f"The {what} {enumerate_words(leaders)} {have} no mass, and nothing else acts on "
            f"{these}: the joints {enumerate_words(joints)} together join {call(cut.body)} to "
            f"{call(self.holder(cut))}. "
        )

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
            followers = cut.joint.followers
            return [] if followers else [rate for rate in here if rate.name not in self._held]
        driven = algebra.mechanism.coordinates.driven
        guided = set(driven)
        for name in driven:
            guided |= {g.name for g in algebra.lift(algebra.values[name]).generators()}
        return [rate for rate in here if rate.name not in guided]

    def _find_leaders(self) -> Iterator[tuple[str, Cut]]:
        """Yield each body that another leads, with nothing of its own, and that leader."""
        cuts = {cut.body: cut for cut in self.cuts.bodies}
        held = Counter(cut.joint.parent for cut in self.cuts.bodies)
        driven = {rate.body for rate in self.rates if rate.rotor}
        for cut in self.cuts.bodies:
            leader = cuts.get(cut.joint.parent)
            if leader is None or held[leader.body] > 1 or leader.inert or leader.applied:
                continue
            if driven.isdisjoint((cut.body, leader.body)) and not (
                self.guiding.acting_on(leader) or self.is_guided(cut) or self.is_guided(leader)
            ):
                yield cut.body, leader

    def _relieve(self, cut: Cut, whole: SymbolicWrench) -> SymbolicWrench:
        """Return what a joint must transmit, without what the equations of motion make zero."""
        idle = self._idle[cut.body] = self._find_idle(cut, whole) if cut in self.bodies else {}
        for rate in self._free(cut):
            whole = whole - rate.wrench * (rate.component(whole) + rate.rotor)
        if idle:
            parts = {"force": [zero(self.algebra.ring)], "moment": [zero(self.algebra.ring)]}
            for d in cut.axes.directions:
                if (d.kind, d.place) not in idle:
                    row = lift(self.algebra.ring, d.row)
                    parts[d.kind].append(row * component(d.row, whole.part(d.kind)))
            whole = SymbolicWrench(*map(total, parts.values()))
        return whole

    def _find_idle(self, cut: Cut, whole: SymbolicWrench) -> dict[tuple[str, int], bool]:
        """Return the directions in which a body's joints transmit nothing, True where all free."""
        # In each twist the transmitted wrench has no power: the free motions of the joints, then
        # what the body needs nothing in: directions, and turns about its center of mass. What these
        # span is idle, in all states if it is in a generic one.
        ring, nothing, chain = self.algebra.ring, zero(self.algebra.ring), self.list_chain(cut)
        twists, units = list[SymbolicWrench](), dict[tuple[str, int], SymbolicWrench]()
        for rate in (rate for other in chain for rate in self._free(other) if not rate.rotor):
            axis = self.cuts.carry(rate.axis, rate.body, cut.body)
            if rate.kind == "moment":
                arm = self.cuts.between_seats(rate.body, cut.body)
                arm = self.cuts.carry(arm, rate.body, cut.body)
                twists.append(SymbolicWrench(cross(axis, arm), axis))
            else:
                twists.append(SymbolicWrench(axis, nothing))
        free, needless = len(twists), whole.about(-cut.center).moment
        for d in cut.axes.directions:
            row = lift(ring, d.row)
            unit = SymbolicWrench(*((row, nothing) if d.kind == "force" else (nothing, row)))
            units[d.kind, d.place] = unit
            if component(d.row, whole.part(d.kind)).vanishes():
                twists.append(unit)
            elif d.kind == "moment" and component(d.row, needless).vanishes():
                twists.append(SymbolicWrench(cross(cut.center, row), row))
        value = Evaluation(ring, self.algebra.generic)
        with np.errstate(invalid="ignore"):  # what is not defined there is no condition
            rows = [
                (*map(value, x.force), *map(value, x.moment)) for x in (*twists, *units.values())
            ]
        matrix = np.array(rows)
        matrix /= np.linalg.norm(matrix, axis=1, keepdims=True)
        matrix[~np.isfinite(matrix).all(axis=1)] = 0.0
        by_freedom, by_all = (
            _lie_within(matrix[len(twists) :], matrix[:count]) for count in (free, len(twists))
        )
        return {
            key: bool(alone)
            for key, alone, idle in zip(units, by_freedom, by_all, strict=True)
            if idle
        }

    def acting(self, cut: Cut) -> SymbolicWrench:
        """Return all that acts on a body, about the fixed point, or else the center of mass."""
        # With named reactions, in the axes of the body's carrier
        joints = [
            -self.cuts.hand_down(self.symbols[child.body], child.body, cut.body)
            for child in self.cuts.bodies
            if child.joint.parent == cut.body
        ]
        direct = (cut.weight, cut.loads(), self.guiding.on(cut), self.symbols[cut.body])
        return cut.about_reference(resultant([*direct, *joints]))

    def repeats(self, cut: Cut) -> bool:
        """Return whether a body's moments only repeat its forces, as those of a particle do."""
        if not cut.fixed:
            return False
        rest = self.acting(cut) - cut.about_reference(cut.push)
        return not any(rest.about(-cut.center).tidy().moment)

    def acting_along(self, cut: Cut) -> SymbolicWrench:
        """Return all that acts on a body along the axes in which its equations are written."""
        # The reaction in the body's own joint is not projected: that would expand n·n = 1
        rest = self.acting(cut) - self.symbols[cut.body]
        for rate in self._free(cut):
            if rate.rotor:
                rest = rest - rate.wrench * rate.rotor
        return cut.axes.along(rest) + self._own[cut.body]

    def sum_guides(self) -> list[Result]:
        """Return the sums of reactions and rotors along joints, zero for each displacement."""
        sums = project(self.cuts, self.rates, self.symbols, rotors=True)
        return [Result(whole, self.algebra.ring.number(0)) for whole in sums if whole]


def _lie_within(rows: np.ndarray, span: np.ndarray) -> np.ndarray:
    """Return which unit rows, shape (k, 6), are sums of others, shape (n, 6)."""
    _, sizes, basis = np.linalg.svd(span, full_matrices=False)
    basis = basis[: rank_of(sizes, RANK)]
    rest = np.linalg.norm(rows - rows @ basis.T @ basis, axis=1)
    return np.asarray(rows.any(axis=1) & (rest < RANK))


def needs(cut: Cut) -> SymbolicWrench:
    """Return the wrench that a body needs for its motion: rates of momentum less weight."""
    return (cut.push - cut.weight).tidy()
