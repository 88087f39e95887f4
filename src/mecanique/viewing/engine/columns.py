"""Every number of a scene that changes with time, on a tape."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, final

from mecanique.derivation.tree.poses import times_point
from mecanique.generation.mechanics.dynamics import Dynamics
from mecanique.generation.mechanics.free_body_forces import FreeBodyForces
from mecanique.model.bodies.visuals import Box, Cylinder, Sphere, Visual
from mecanique.model.constraint_base import PressingContact
from mecanique.model.expression import Scalar
from mecanique.model.placement import Placement
from mecanique.motion.analysis.energies import is_rheonomic
from mecanique.motion.record.events import break_names
from mecanique.program.sweeps import push_forward
from mecanique.program.traced import trace, value_of
from mecanique.viewing.scene.drawn import Spot, group_work, name_arrows, spans_of, tips_of
from mecanique.viewing.scene.scene import Scene


def margins_of(
    dynamics: Dynamics, actions: FreeBodyForces
) -> Iterator[tuple[str, tuple[Any, Any, Any]]]:
    """Yield what holds until a margin a − √(b² + c²) passes zero: its name, and a, b, c [N]."""
    mechanism, letters = dynamics.letters.mechanism, dynamics.letters
    margins: list[tuple[Any, Any, Any]] = []
    rolling = [contact for contact in mechanism.contacts if isinstance(contact, PressingContact)]
    if rolling:
        multipliers = dict(zip(dynamics.loops.names, dynamics.multipliers, strict=True))
        for contact in rolling:
            N, x, y = (multipliers[f"{contact.name}: {row}"] for row in contact.rows)
            margins.append((N, 0.0, 0.0))
            if contact.friction is not None:
                most = letters.arithmetic(contact.friction, letters.values) * N
                margins.append((most, x, y))
    for element in mechanism.elements:
        margins += [(actions.guide_sizes[name], 0.0, 0.0) for name in element.tensions]
    yield from zip(break_names(mechanism), margins, strict=True)


WORK = "work done"
"""Name on the tape of the work that has been done, which comes after the state."""


@final
class Columns:
    """The columns of a scene's table; those that are not known are None."""

    def __init__(self, dynamics: Dynamics) -> None:
        self._dynamics = dynamics
        self._letters = dynamics.letters
        self._mechanism = dynamics.letters.mechanism
        self._work = self._letters.tape.input(WORK)
        self._actions = FreeBodyForces(dynamics)
        self.shown = [a for a in self._actions.all() if a.body != self._mechanism.ground]
        """The forces on the moving bodies."""

    @property
    def rates(self) -> list[Any]:
        """Rates of the state and of the work of everything that has no potential."""
        # that work changes the energy along the motion: ∂E/∂q q' + ∂E/∂v a + ∂E/∂t
        letters, dynamics = self._letters, self._dynamics
        return [*letters.rates, *dynamics.acceleration, self._power()]

    def row(self, scene: Scene) -> list[Any]:
        """Return the columns, in the order of the table; a rotation matrix for each quaternion."""
        columns: list[Any] = []
        for body in scene.bodies:
            pose = self._dynamics.tree.recursion.pose(body.name)
            columns += [row[3] for row in pose]
            columns += [entry for row in pose for entry in row[:3]]
        arrows = {name: (action, unit) for name, action, unit in name_arrows(self.shown)}
        for arrow in scene.arrows:
            action, unit = arrows.get(arrow.name, (None, ""))
            if action is None:
                columns += [None] * 6
            else:
                columns += [*action.origin, *(action.force if unit == "N" else action.moment)]
        columns += self._points(scene)
        known = self.reactions() | self._actions.guide_sizes
        columns += [known.get(curve.name, self._series(curve.name)) for curve in scene.series]
        columns += self._ledger(scene)
        return columns

    def reactions(self) -> dict[str, Any]:
        """Return the components of the joints' reactions, by the name of their series."""
        children = {joint.name: joint.child for joint in self._mechanism.joints}
        components: dict[str, Any] = {}
        for action in self.shown:
            if action.kind == "reaction" and children.get(action.name) == action.body:
                for sign, vector in (("R", action.force), ("M", action.moment)):
                    for axis, component in zip("xyz", vector, strict=True):
                        components[f"{action.name} {sign}{axis}"] = component
        return components

    def closure(self) -> list[Any]:
        """Return residual, its rate and Jacobian of the loops as one list; empty for a tree."""
        if not self._mechanism.constrained:
            return []
        loops = self._dynamics.loops
        return [*loops.residual, *loops.rate, *(entry for row in loops.jacobian for entry in row)]

    def margins(self) -> dict[str, tuple[Any, Any, Any]]:
        """Return what contacts and cords have left, by what would happen without it."""
        return dict(margins_of(self._dynamics, self._actions))

    def shape(self, visual: Visual) -> list[Any]:
        """Return a shape's size, then its place row by row."""
        number = self._number
        place: Placement = visual.placement
        rows = zip(place.rotation, place.xyz, strict=True)
        pose = [number(entry) for row, offset in rows for entry in (*row, offset)]
        return [*map(number, sizes_of(visual)), *pose]

    def _power(self) -> Any:
        mechanism, letters, tape = self._mechanism, self._letters, self._letters.tape
        free = all(force.conservative for force in mechanism.forces)
        if free and not is_rheonomic(mechanism):
            return 0.0
        energy = sum(self._energy(), 0.0)
        along = {q.place: value_of(r) for q, r in zip(letters.q, letters.rates, strict=True)}
        a = self._dynamics.acceleration
        along |= {v.place: value_of(x) for v, x in zip(letters.v, a, strict=True)}
        along[letters.t.place] = 1.0
        return trace(tape, push_forward(tape, [value_of(energy)], along)[0])

    def _energy(self) -> tuple[Any, Any]:
        T, V = (trace(self._letters.tape, x) for x in self._dynamics.answer("energy"))
        return T, V

    def _points(self, scene: Scene) -> Iterator[Any]:
        spans = {span.name: span for span in spans_of(self._mechanism)}
        tensions = {name for element in self._mechanism.elements for name in element.tensions}
        touches = iter(action.origin for action in self._actions.guiding if action.name in tensions)
        for line in scene.lines:
            if line.name.startswith("stretch "):
                yield from (*next(touches), *next(touches))
            elif line.name in spans:
                for end in spans[line.name].ends:
                    yield from self._locate(end)
            else:
                yield from [None] * 6
        tips = {f"path of {tip.body}": tip for tip in tips_of(self._mechanism)}
        for path in scene.traces:
            yield from self._locate(tips[path.name])

    def _series(self, name: str) -> Any:
        letters, mechanism = self._letters, self._mechanism
        T, V = self._energy()
        known = dict(zip((f"{v}'" for v in mechanism.velocities), self._a, strict=True))
        known |= dict(zip(mechanism.velocities, letters.v, strict=True))
        known |= dict(zip(mechanism.coordinates, letters.q, strict=True))
        work = trace(letters.tape, self._work)
        energies = {"kinetic": T, "potential": V, "total": T + V, "work": work}
        return known.get(name, energies.get(name.removeprefix("energy ")))

    @property
    def _a(self) -> Sequence[Any]:
        return self._dynamics.acceleration

    def _ledger(self, scene: Scene) -> Iterator[Any]:
        groups = dict(group_work(self._mechanism, self.shown))
        for row in scene.document.ledger.rows:
            if row.name in groups:
                parts = [self._actions.work(action) for action in groups[row.name]]
                yield from (sum(column, 0.0) for column in zip(*parts, strict=True))
            else:
                yield from [None] * self._mechanism.nv

    def _locate(self, spot: Spot) -> list[Any]:
        pose = self._dynamics.tree.recursion.pose(spot.body)
        return times_point(pose, [self._number(c) for c in spot.point])

    def _number(self, scalar: Any) -> Any:
        return self._letters.arithmetic(scalar, self._dynamics.tree.recursion.chart.r)


def sizes_of(visual: Visual) -> tuple[Scalar, ...]:
    """Return what a shape is drawn with: edges, radius and length, or radius; none of a mesh."""
    match visual.geometry:
        case Box(size):
            return tuple(size)
        case Cylinder(radius, length):
            return radius, length
        case Sphere(radius):
            return (radius,)
    return ()
