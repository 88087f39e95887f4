"""Set up the equations for the forces of guiding elements (cords, gears …).

An ideal joint transmits nothing along or about its own free axes. The forces that the motion needs
there, τ = inverse dynamics minus loads, come from the elements and from guides without an element:
D f + N μ = τ, with a column of D for each element's unit force, and columns of N along the guides
that no element describes. The rank of (D, N) tells which forces are determined.

A straight run of cord from a wheel at P to one at Q, which it touches at s r (e × n) from their
centers, has the direction e = (l d + h d × n) / d² with d = Q − P, h = s_Q r_Q − s_P r_P,
l² = d² − h².
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple, final

import numpy as np
import numpy.typing as npt

from mecanique.arrays import Array
from mecanique.errors import EngineError
from mecanique.model import Belt, Cord, Gear, Joint, Loop, Mechanism, Rack
from mecanique.model.constraints.elements import force_names, preloads
from mecanique.model.constraints.loops import CLOSED
from mecanique.model.guides import (
    Guide,
    cord_fault,
    explain_joint,
    guides_of,
    idle_coordinates,
    mesh_fault,
    work_fault,
)
from mecanique.model.joint_base import Single
from mecanique.model.mechanism_units import characteristic_length
from mecanique.reference.engine.chart import Chart
from mecanique.reference.engine.forces.sites import Site, SiteAction, Triple
from mecanique.reference.engine.load import EngineModel
from mecanique.reference.tolerances import DEPENDENT, EXPLAINED, LOOSE, PARALLEL, WHOLE
from mecanique.reference.vectors import rank_of

_ZERO: Triple = (0.0, 0.0, 0.0)


class Unit(NamedTuple):
    """The action of an element's unit force on one body."""

    force: int  # index of the unknown force
    body: str  # name of the body
    other: str  # name of the body on which the opposite acts
    action: SiteAction  # force and torque, world axes
    # whether it grows with the force's magnitude, as the separating force of gears
    pressed: bool = False


@final
class GuideColumns(NamedTuple):
    """The unknown forces with their components along the joint velocities."""

    matrix: Array  # shape (nu + k, forces + own + guides), scaled; the last k rows state preloads
    scale: Array  # shape (nu,), factors of the rows
    stated: Array  # shape (k,), right sides of the last rows


@final
class Elements:
    """The elements of a mechanism inside Pinocchio."""

    def __init__(
        self, mechanism: Mechanism, engine: EngineModel, chart: Chart, sites: dict[str, Site]
    ) -> None:
        self._mechanism = mechanism
        self._engine, self._chart = engine, chart
        self._axes = {name: site.axes for name, site in sites.items()}
        self.names = force_names(mechanism.elements)
        self.open: tuple[Guide, ...] = guides_of(mechanism)
        """The guides that no element describes."""
        length = characteristic_length(mechanism)
        angular = {name for joint in mechanism.joints for name in joint.angular_velocities}
        self._scale = np.zeros(engine.model.nv)
        for name, row in chart.rows.items():
            self._scale[row] = 1 / length if name in angular else 1.0

    def units(self) -> list[Unit]:
        """Return the actions of unit forces on the bodies, at the engine's present position."""
        units: list[Unit] = []
        first = 0
        for element in self._mechanism.elements:
            match element:
                case Cord() | Belt():
                    pushes = self._of_cord(element)
                case Gear() | Rack():
                    pushes = self._of_teeth(element)
                case _:
                    pushes = self._of_loop(element)
            units += [unit._replace(force=first + unit.force) for unit in pushes]
            first += len(element.forces)
        return units

    def columns(self, forces: Array) -> GuideColumns:
        """Return the unknown forces along the joints: of elements, joints and open guides."""
        G, scale = self._chart.G, self._scale
        self._refuse(work_fault(self._mechanism, G.T @ forces))
        known = self._known(forces)
        bases = [scale[:, None] * self._tie_forces(guide) for guide in self.open if guide.crossed]
        matrix = np.concatenate([known, *bases], axis=1)
        given = preloads(self._mechanism.elements)
        together = np.zeros((len(given), matrix.shape[1]))
        for row, preload in zip(together, given, strict=True):
            row[preload.forces] = 1.0
        stated = np.array(self._mechanism.evaluate_all(preload.total for preload in given))
        return GuideColumns(np.concatenate([matrix, together]), scale, stated)

    def explain(self, forces: Array) -> None:
        """Remove guides that elements describe, at the engine's present position, from `open`."""
        self._refuse(work_fault(self._mechanism, self._chart.G.T @ forces))
        known = self._known(forces)
        onto = known @ np.linalg.pinv(known, rcond=DEPENDENT)
        left = []
        for guide in self.open:
            basis = self._scale[:, None] * self._tie_forces(guide)
            if not guide.crossed or np.abs(basis - onto @ basis).max() > EXPLAINED:
                left.append(guide)
        self.open = tuple(left)

    def _known(self, forces: Array) -> Array:
        """Columns along the joints, scaled: unit forces of elements, then forces within joints."""
        G = self._chart.G
        columns_known = [np.zeros((len(G), 0))]
        for joint in self._mechanism.joints:
            columns_known.append(
                self._null(G, [self._chart.rows[name] for name in joint.velocities])
            )
        known: Array = self._scale[:, None] * np.concatenate([forces, *columns_known], axis=1)
        return known

    def _tie_forces(self, guide: Guide) -> Array:
        """A basis of the forces by which a guide may hold its joints, shape (nu, k)."""
        return self._null(self._chart.G, [self._chart.rows[f"{n}'"] for n in guide.coordinates])

    def _null(self, G: Array, rows: list[int]) -> Array:
        """A basis of forces along some joint velocities that do no virtual work, (nu, k)."""
        out = np.zeros((len(G), 0))
        if not rows:
            return out
        left, sizes, _ = np.linalg.svd(G[rows])
        rank = rank_of(sizes, DEPENDENT)
        out = np.zeros((len(G), len(rows) - rank))
        out[rows] = left[:, rank:]
        return out

    def _refuse(self, fault: str) -> None:
        if fault:
            raise EngineError(fault)

    def _of_cord(self, cord: Cord | Belt) -> Iterator[Unit]:
        stops, n = cord.stops, np.array(cord.normal)
        if cord.axes != "world":
            n = self._turn(cord.axes) @ n
        places = [self._place(stop.body, stop.center) for stop in stops]
        reach = [self._mechanism.evaluate(stop.radius) * stop.sense for stop in stops]
        self._refuse(cord_fault(self._mechanism, cord, np.array(places), n))
        for k, part in enumerate(cord.parts):
            d, h = places[k + 1] - places[k], reach[k + 1] - reach[k]
            square = float(d @ d)
            e = (np.sqrt(square - h * h) * d + h * np.cross(d, n)) / square
            side = np.cross(e, n)
            for at, beside, sign in ((k, k + 1, 1.0), (k + 1, k, -1.0)):
                touch = places[at] + reach[at] * side
                action = self._action(stops[at].body, touch, sign * e, np.zeros(3))
                yield Unit(part, stops[at].body, stops[beside].body, action)

    def _of_teeth(self, mesh: Gear | Rack) -> Iterator[Unit]:
        a, b = (self._mechanism.joint(name) for name in mesh.joints)
        assert isinstance(a, Single)
        assert isinstance(b, Single)
        n, line = self._turn(a.child) @ a.axis, self._turn(b.child) @ b.axis
        start = self._place(a.child, _ZERO)
        end = self._place(b.child, _ZERO if isinstance(mesh, Gear) else mesh.point)
        self._refuse(mesh_fault(self._mechanism, mesh, (n, line), (start, end)))
        if isinstance(mesh, Gear) and float(np.linalg.norm(np.cross(n, line))) > PARALLEL:
            yield from self._of_bevel(mesh, a.child, b.child, (n, line), (start, end))
            return
        radius, angle = (self._mechanism.evaluate(x) for x in (mesh.radius, mesh.pressure_angle))
        d = end - start
        if isinstance(mesh, Rack):
            d = d - (d @ line) * line
        d = d - (d @ n) * n
        u = d / np.linalg.norm(d)
        apart = -1.0 if isinstance(mesh, Gear) and mesh.internal else 1.0
        touch = start + radius * u
        pushes = (
            (np.cos(angle) * np.cross(n, u), False),
            (apart * np.sin(angle) * u, True),
        )
        for body, partner, sign in ((b.child, a.child, 1.0), (a.child, b.child, -1.0)):
            for push, pressed in pushes:
                action = self._action(body, touch, sign * push, np.zeros(3))
                yield Unit(0, body, partner, action, pressed)

    def _of_bevel(
        self,
        gear: Gear,
        a: str,
        b: str,
        axes: tuple[Array, Array],
        centers: tuple[Array, Array],
    ) -> Iterator[Unit]:
        """Yield the actions of bevel wheels; pitch circles touch in the plane of the axes."""
        (n, line), (start, end) = axes, centers
        r, R, angle = (
            self._mechanism.evaluate(x)
            for x in (gear.radius, gear.other_radius, gear.pressure_angle)
        )
        across = np.cross(n, line)
        across = across / np.linalg.norm(across)
        # from the apex to the centers, along the axes
        way, _ = np.linalg.lstsq(np.array([-n, line]).T, end - start, rcond=None)[0]
        apex = start - way * n
        u, U = np.cross(across, n), np.cross(across, line)
        rims = [(start + i * r * u, end + k * R * U) for i in (1, -1) for k in (1, -1)]
        touch, _ = min(rims, key=lambda pair: float(np.linalg.norm(pair[0] - pair[1])))
        ray = (touch - apex) / np.linalg.norm(touch - apex)
        aside = end - apex
        away = aside - (aside @ ray) * ray
        away = away / np.linalg.norm(away)
        tangent = np.cross(n, touch - start) / r
        pushes = ((np.cos(angle) * tangent, False), (np.sin(angle) * away, True))
        for body, opposite, sign in ((b, a, 1.0), (a, b, -1.0)):
            for push, pressed in pushes:
                action = self._action(body, touch, sign * push, np.zeros(3))
                yield Unit(0, body, opposite, action, pressed)

    def _of_loop(self, loop: Loop) -> Iterator[Unit]:
        a = self._place(loop.body_a, loop.frame_a.xyz)
        b = self._place(loop.body_b, loop.frame_b.xyz)
        ends = ((loop.body_b, loop.body_a, 1.0), (loop.body_a, loop.body_b, -1.0))
        axes = self._turn(loop.body_a) @ self._mechanism.matrix(loop.frame_a)[:3, :3]
        for k, row in enumerate(CLOSED[loop.kind]):
            if row == "length":
                along, turns = (b - a) / np.linalg.norm(b - a), False
            else:
                along, turns = axes[:, "xyz".index(row[-1])], row.startswith("r")
            for body, partner, sign in ends:
                force, moment = (np.zeros(3), along) if turns else (along, np.zeros(3))
                yield Unit(k, body, partner, self._action(body, b, sign * force, sign * moment))

    def _action(self, body: str, at: Array, force: Array, moment: Array) -> SiteAction:
        return SiteAction.of(Site(body, self._axes[body], _ZERO), force, at, moment)

    def _place(self, body: str, point: Any) -> Array:
        here = np.array(self._mechanism.evaluate_all(point))
        placed: Array = self._engine.data.oMi[self._holder(body).joint].act(
            self._holder(body).placement.act(here)
        )
        return placed

    def _turn(self, body: str) -> Array:
        holder = self._holder(body)
        turned: Array = self._engine.data.oMi[holder.joint].rotation @ holder.placement.rotation
        return turned

    def _holder(self, body: str) -> Any:
        return self._engine.holders[body]


class GuideReactions(NamedTuple):
    """The forces of the elements in one state, and the reactions that remain."""

    forces: Array  # shape (k,), the elements' forces [N or N·m]
    reactions: Array  # shape (joints, 2, 3), reactions of the joints
    # shape (joints, 6), whether redundant elements leave a component undetermined
    loose: npt.NDArray[np.bool_]
    # shape (units, 3, 3), point, force and moment of each action on a body; with what presses
    actions: Array
    # shape (k,), whether redundant elements leave a force undetermined
    unknown: npt.NDArray[np.bool_]


def hold(
    columns: GuideColumns, demand: Array, units: list[Unit], carried: Array, totals: Array
) -> GuideReactions:
    """Solve for the elements' forces; if several sets are possible, take the least."""
    # `carried`, shape (2, k, joints, 2, 3): the joints' wrenches under unit forces, and under those
    # that grow with their magnitudes.
    # Shapes: demand (nu,), carried (2, k, joints, 2, 3), totals (joints, 2, 3)
    carried, pressed = carried
    count = len(carried)
    _, sizes, right = np.linalg.svd(columns.matrix)
    rank = rank_of(sizes, DEPENDENT)
    solution = np.linalg.pinv(columns.matrix, rcond=DEPENDENT) @ np.concatenate(
        [-columns.scale * demand, columns.stated]
    )
    forces = solution[:count]
    idle = right[rank:, :count]
    reactions = totals + np.einsum("k,kjab->jab", forces, carried)
    reactions += np.einsum("k,kjab->jab", np.abs(forces), pressed)
    spread = np.einsum("ik,kjab->ijab", idle, carried).reshape(len(idle), len(totals), 6)
    loose = (np.abs(spread) > LOOSE).any(axis=0)
    unknown = (np.abs(idle) > LOOSE).any(axis=0)
    actions: list[Array] = []
    for unit in units:
        push = np.array([(0.0, 0.0, 0.0), unit.action.force, unit.action.torque])
        if unit.pressed:  # acts at the same point as the force before it
            actions[-1] += abs(forces[unit.force]) * push
        else:
            actions.append(forces[unit.force] * push)
            actions[-1][0] = unit.action.point
    return GuideReactions(forces, reactions, loose, np.array(actions), unknown)


@final
class Guided:
    """The joints of a mechanism whose reactions depend on guides without an element."""

    def __init__(self, mechanism: Mechanism, guides: Sequence[Guide]) -> None:
        self._mechanism = mechanism
        self._guides = guides
        self._place = {body.name: k for k, body in enumerate(mechanism.bodies)}
        reasons = {
            joint.name: explain_joint(self._guides, joint.name) for joint in mechanism.joints
        }
        self.reasons = {name: reason for name, reason in reasons.items() if reason}
        """The reason why a reaction is undetermined, by name of the joint."""

    def undetermined(self, poses: Array) -> npt.NDArray[np.bool_]:
        """Return which components of each joint's reaction are undetermined, shape (joints, 6)."""
        joints = self._mechanism.joints
        flags = np.zeros((len(joints), 6), dtype=bool)
        for k, joint in enumerate(joints):
            if joint.name in self.reasons:
                idle = self._idle(joint, poses)
                # a component along e is determined if e lies within the idle directions, |P e| = 1
                onto = np.linalg.pinv(idle) if idle.size else np.zeros((len(poses), 0, 6))
                flags[k] = (np.linalg.norm(idle @ onto, axis=1) < WHOLE).any(axis=0)
        return flags

    def _idle(self, joint: Joint, poses: Array) -> Array:
        """Return the directions in which a joint transmits nothing, world axes, shape (n, 6, k)."""
        names = idle_coordinates(self._guides, joint)
        turns = poses[:, self._place[joint.child], :3, :3]
        origin = self._mechanism.matrix(joint.origin)[:3, :3]
        before = poses[:, self._place[joint.parent], :3, :3] @ origin
        directions, chain = [np.zeros((len(poses), 6, 0))], joint.chain
        for motion in chain:
            if not names.issuperset(motion.coordinates):
                continue
            # the axes of a chain's earlier motions do not turn with the child
            frame = turns if motion is chain[-1] else before
            axes = np.eye(3) if motion.kind in ("ball", "free") else np.array([motion.axis]).T
            along, nothing = frame @ axes, np.zeros((len(poses), 3, axes.shape[1]))
            if motion.kind in ("slide", "free"):
                directions.append(np.concatenate([along, nothing], axis=1))
            if motion.kind in ("turn", "ball", "free"):
                directions.append(np.concatenate([nothing, along], axis=1))
        return np.concatenate(directions, axis=2)
