"""Write all forces on all bodies on a tape: weights, loads, reactions and inertia forces.

A joint's reaction follows from the balance of its child and all bodies beyond: the sum of
m (x'' − g) and of the rates of angular momentum, minus the forces of springs, dampers, drives,
loads and loops (d'Alembert's principle, Fundamentals of Dynamics, eqs. 1.21, 1.22).

With the total wrench T_k across joint k, S_kj balances the unit force j of a guiding element on all
bodies beyond it. The joint transmits nothing along its own directions n: n·T_k + Σ f_j n·S_kj = 0
for each direction that the coordinate map drives. These are more equations than forces f, but
consistent; they are solved by least squares.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import cached_property
from typing import Any, final

from mecanique.derivation.mechanics.elements import UnitForce, act_loop, unit_forces
from mecanique.derivation.mechanics.forces import NOTHING, AppliedWrench, on_velocities
from mecanique.derivation.mechanics.vectors import (
    Rows,
    Triple,
    add,
    apply,
    cross,
    dot,
    products,
    scale,
    transpose,
)
from mecanique.derivation.tree.links import links
from mecanique.derivation.tree.poses import Matrix, times_point
from mecanique.errors import DerivationError
from mecanique.generation.mechanics.dynamics import TapeDynamics
from mecanique.model.bodies import Body
from mecanique.model.constraints.contacts import Contact
from mecanique.model.constraints.elements import force_names, preloads
from mecanique.model.constraints.loops import CLOSED, Loop
from mecanique.model.mechanism.description import bodies_with_inertia, bodies_with_mass
from mecanique.program.solving import factorize
from mecanique.program.traced import value_of


@final
class FreeBodyForces:
    """The forces on a mechanism's bodies at the accelerations of its motion."""

    def __init__(self, dynamics: TapeDynamics) -> None:
        self._dynamics = dynamics
        self._letters = dynamics.letters
        self._recursion = dynamics.tree.recursion
        self._mechanism = dynamics.letters.mechanism
        self._values = self._recursion.chart.r
        self._heavy = bodies_with_mass(self._mechanism)
        self._inert = bodies_with_inertia(self._mechanism)

    def all(self) -> list[AppliedWrench]:
        """Return all forces, except those of velocity constraints, which are not specified."""
        reactions = [] if self._mechanism.velocity_constraints else self.reactions()
        return [*self.weights(), *self.loads, *reactions, *self.inertia]

    def weights(self) -> Iterator[AppliedWrench]:
        """Yield the weight of each body."""
        gravity = self._recursion.gravity
        for body in self._heavy:
            weight = scale(self._number(body.mass), gravity)
            yield AppliedWrench(body.name, "weight", body.name, self._center(body), weight, NOTHING)

    @cached_property
    def loads(self) -> list[AppliedWrench]:
        """The actions of springs, dampers, drives and loads on each body."""
        return self._dynamics.tree.loads.on_bodies()

    @cached_property
    def drives(self) -> list[AppliedWrench]:
        """The actions of tau in the joints, on the child and on the parent.

        Where it works on coordinates that are no joint's, it is the least forces in joints that do
        the same work.
        """
        m, chart, tape = self._mechanism, self._recursion.chart, self._letters.tape
        motions = [link for link in links(m) if link.kind != "fixed"]
        tau = dict(zip(m.velocities, self._letters.tau, strict=True))
        efforts = [tau.pop(name, 0.0) for link in motions for name in link.velocities]
        if tau:
            columns = transpose(chart.G)
            generalized = [tau.get(name, 0.0) for name in m.velocities]
            shares = factorize(tape, products(columns, columns)).solve(generalized)
            efforts = [x + dot(row, shares) for x, row in zip(efforts, chart.G, strict=True)]
        drives: list[AppliedWrench] = []
        recursion = self._recursion
        for link, motion, pose in zip(motions, recursion.links, recursion.poses, strict=True):
            joint = m.joint(link.joint)
            moment, force = (apply(pose, part) for part in motion.relative(efforts))
            at = self._point(joint.child, NOTHING)
            drive = AppliedWrench(joint.name, "drive", joint.child, at, force, moment)
            drives += [drive, drive.opposite(joint.parent)]
        return drives

    @cached_property
    def inertia(self) -> list[AppliedWrench]:
        """D'Alembert's inertia forces: −m a at the center of mass, and minus dH/dt about it.

        dH/dt is ∫ x × x'' dm, by the second moments, as in `mecanique.motion.analysis.forces`.
        """
        actions = []
        for body in self._inert:
            center, turn = self._center(body), self._pose(body.name)
            a = self.accelerate(center)
            entries = [entry for row in turn for entry in row[:3]]
            change = self.accelerate(entries)
            E, second = [row[:3] for row in turn], _second_moments(body, self._number)
            rows = [change[3 * i : 3 * i + 3] for i in range(3)]
            moments = [apply(E, apply(second, row)) for row in rows]  # R'' S Rᵀ
            rate = [moments[k][i] - moments[i][k] for i, k in ((1, 2), (2, 0), (0, 1))]
            force = scale(-1.0 * self._number(body.mass), a)
            actions.append(
                AppliedWrench(body.name, "inertia", body.name, center, force, scale(-1.0, rate))
            )
        return actions

    def reactions(self) -> Iterator[AppliedWrench]:
        """Yield the actions of joints, loops, contacts and elements on the bodies."""
        transmitted = self._transmit([*self._acting, *self.guiding])
        for joint in self._mechanism.joints:
            yield transmitted[joint.name]
            yield transmitted[joint.name].opposite(joint.parent)
        yield from self._closing
        yield from self.guiding

    @cached_property
    def guide_sizes(self) -> dict[str, Any]:
        """The magnitudes of the guiding elements' forces, by name."""
        elements = self._mechanism.elements
        if not elements:
            return {}
        names, totals = force_names(elements), self._drive_along(self._acting)
        rows = []
        for k in range(len(names)):
            unit_actions = [self._act(unit) for unit, _ in self._unit_pairs if unit.index == k]
            rows.append(self._drive_along(unit_actions))
        for preload in preloads(elements):
            totals = [*totals, -1.0 * self._number(preload.total)]
            rows = [[*row, float(k in preload.forces)] for k, row in enumerate(rows)]
        missing = [-dot(row, totals) for row in rows]
        sizes = factorize(self._letters.tape, products(rows, rows)).solve(missing)
        return dict(zip(names, sizes, strict=True))

    @cached_property
    def guiding(self) -> list[AppliedWrench]:
        """The actions of the guiding elements on the bodies."""
        actions, sizes = list[AppliedWrench](), self.guide_sizes
        for unit, pressing in self._unit_pairs if sizes else ():
            action = self._act(unit)
            size = sizes[action.name]
            force, moment = scale(size, action.force), scale(size, action.moment)
            if pressing is not None:
                strength = self._letters.call("Abs", size)
                force = add(force, scale(strength, pressing.force))
            actions.append(replace(action, force=force, moment=moment))
        return actions

    @cached_property
    def _unit_pairs(self) -> list[tuple[UnitForce, UnitForce | None]]:
        """Each unit force with the separating force at the same point, if any."""
        units = unit_forces(self._mechanism, self._recursion.ground)
        following = zip(units, [*units[1:], None], strict=True)
        return [
            (unit, after if after is not None and after.pressed else None)
            for unit, after in following
            if not unit.pressed
        ]

    def _act(self, unit: UnitForce) -> AppliedWrench:
        name = force_names(self._mechanism.elements)[unit.index]
        return AppliedWrench(name, "reaction", unit.body, unit.point, unit.force, unit.moment)

    def _drive_along(self, acting: Sequence[AppliedWrench]) -> list[Any]:
        """Return the joints' wrenches along the directions in which the map drives them."""
        recursion, components = self._recursion, list[Any]()
        crossing = self._transmit(acting)
        for joint in self._mechanism.tree:
            if not joint.velocities:
                continue
            place = recursion.seats[joint.child].place
            link, turn = recursion.links[place], [row[:3] for row in recursion.poses[place]]
            vectors = (crossing[joint.name].force, crossing[joint.name].moment)
            for k in link.columns:
                if all(isinstance(entry, float) and not entry for entry in recursion.chart.G[k]):
                    continue
                pairs = zip((link.linear.get(k), link.angular.get(k)), vectors, strict=True)
                components.append(sum((dot(apply(turn, n), x) for n, x in pairs if n), 0.0))
        return components

    @cached_property
    def _closing(self) -> list[AppliedWrench]:
        m = self._mechanism
        loops = [action for loop in m.loops for action in self._close(loop)]
        return loops + [action for contact in m.contacts for action in self._press(contact)]

    @property
    def _acting(self) -> list[AppliedWrench]:
        """All actions except those of joints and elements."""
        return [*self.weights(), *self.loads, *self.drives, *self.inertia, *self._closing]

    def _transmit(self, acting: Sequence[AppliedWrench]) -> dict[str, AppliedWrench]:
        """Return the actions of joints on their children under forces, including inertia forces."""
        needed: dict[str, list[AppliedWrench]] = {body.name: [] for body in self._mechanism.bodies}
        for action in acting:
            needed[action.body].append(action)
        reactions: dict[str, AppliedWrench] = {}
        for joint in reversed(self._mechanism.tree):
            at = self._point(joint.child, NOTHING)
            force, moment = NOTHING, NOTHING
            for action in needed[joint.child]:
                arm = [x - y for x, y in zip(action.origin, at, strict=True)]
                force = add(force, scale(-1.0, action.force))
                moment = add(moment, scale(-1.0, add(action.moment, cross(arm, action.force))))
            reaction = AppliedWrench(joint.name, "reaction", joint.child, at, force, moment)
            reactions[joint.name] = reaction
            needed[joint.parent].append(reaction.opposite(joint.parent))
        return reactions

    def _press(self, contact: Contact) -> tuple[AppliedWrench, AppliedWrench]:
        """Return the actions of a contact on its two bodies, at the point of contact."""
        loops = self._dynamics.loops
        first = len(loops.names) - len(loops.velocity_rows)
        place, force = NOTHING, NOTHING
        for k, row in enumerate(loops.velocity_rows, first):
            if row.name.rpartition(": ")[0] == contact.name and row.place is not None:
                push = scale(self._dynamics.multipliers[k], row.direction or NOTHING)
                place, force = row.place, add(force, push)
        held = AppliedWrench(contact.name, "reaction", contact.body, place, force, NOTHING)
        return held, held.opposite(contact.on)

    def joint_reactions(self, *, shared: bool = False) -> list[AppliedWrench]:
        """Return the action of each joint on its child, of each loop on its body b, of contacts.

        Where elements and contacts share the reactions with the joints, the caller has to see to
        it that these are determined.
        """
        m = self._mechanism
        if m.velocity_constraints or (not shared and (m.elements or m.contacts)):
            raise DerivationError(
                f"the reactions of mechanism {m.name!r} have no program: its elements, contacts or "
                "velocity constraints share them with the joints; use `Reference.reactions`"
            )
        count = len(m.joints) + len(m.loops) + len(m.contacts)
        return list(self.reactions())[: 2 * count : 2]

    def work(self, action: AppliedWrench) -> list[Any]:
        """Return the virtual work of a force, F·δx + M·δφ, for each velocity."""
        pose = self._pose(action.body)
        arm = [x - row[3] for x, row in zip(action.origin, pose, strict=True)]
        moment = add(action.moment, cross(arm, action.force))
        moved, weights = [row[3] for row in pose], list(action.force)
        # M·δφ = ½ Σ δe·(M × e) over the body's axes e
        for e in transpose(pose)[:3]:
            moved += e
            weights += scale(0.5, cross(moment, e))
        return on_velocities(self._letters, moved, weights)

    def accelerate(self, scalars: Sequence[Any]) -> list[Any]:
        """Return second derivatives along the motion."""
        letters, first = self._letters, self._letters.along(scalars)
        pairs = zip(letters.v, self._dynamics.acceleration, strict=True)
        return letters.along(first, {v.place: value_of(a) for v, a in pairs})

    def _close(self, loop: Loop) -> tuple[AppliedWrench, AppliedWrench]:
        """Return the actions of a loop on its two bodies, by its multipliers."""
        units = [
            unit for unit in act_loop(loop, self._recursion.ground) if unit.body == loop.body_b
        ]
        loops = self._mechanism.loops
        first = sum(len(CLOSED[closed.kind]) for closed in loops[: loops.index(loop)])
        multipliers = self._dynamics.multipliers[first : first + len(units)]
        force, moment = NOTHING, NOTHING
        for unit, multiplier in zip(units, multipliers, strict=True):
            force = add(force, scale(multiplier, unit.force))
            moment = add(moment, scale(multiplier, unit.moment))
        held = AppliedWrench(loop.name, "reaction", loop.body_b, units[0].point, force, moment)
        return held, held.opposite(loop.body_a)

    def _pose(self, body: str) -> Matrix:
        pose: Matrix = self._recursion.pose(body)
        return pose

    def _center(self, body: Body) -> Triple:
        return self._point(body.name, [self._number(c) for c in body.center])

    def _point(self, body: str, point: Sequence[Any]) -> Triple:
        return times_point(self._pose(body), point)

    def _number(self, scalar: Any) -> Any:
        return self._letters.arithmetic(scalar, self._values)


def _second_moments(body: Body, number: Callable[[Any], Any]) -> Rows:
    """Return ∫ ρ ρᵀ dm about the center of mass, ½ tr(I) 1 − I."""
    ixx, iyy, izz, ixy, ixz, iyz = map(number, body.inertia)
    half = (ixx + iyy + izz) * 0.5
    return [[half - ixx, -ixy, -ixz], [-ixy, half - iyy, -iyz], [-ixz, -iyz, half - izz]]
