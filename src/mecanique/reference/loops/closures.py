"""Compute the constraints of loops by Pinocchio's kinematics: Φ(q, t), Φ' = J v + b, Φ'' = J a + γ.

All quantities are measured in the axes of frame a. With the position p and the rotation R of frame
b there, the rows are components of p, of the angular velocity of b relative to a, or |p| − length.
The velocity of b's origin relative to the coincident point of body a is the sum of the columns of
the spatial Jacobian of those joints that carry only one of the two bodies (Featherstone, Rigid Body
Dynamics Algorithms, 2008, sect. 8.2 to 8.4).
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple, final

import numpy as np
import numpy.typing as npt

from mecanique.arrays import Array
from mecanique.model.constraints.loops import CLOSED, Loop
from mecanique.model.mechanism import Mechanism
from mecanique.model.mechanism_units import characteristic_length, velocity_scales
from mecanique.model.placement import Placement
from mecanique.reference.engine.chart import Chart
from mecanique.reference.engine.load import EngineModel
from mecanique.reference.engine.package import engine_package
from mecanique.reference.loops.contacts import ContactRows, VelocityRows
from mecanique.reference.loops.nullspace import NaturalUnits
from mecanique.reference.tolerances import ROUNDING, TINY
from mecanique.reference.vectors import cross, hat


@final
class Parts:
    """The part of each constraint and each velocity."""

    # `meets`, shape (m, nv): whether a row may depend on a velocity; `owner`, shape (m,): each
    # row's loop, contact or velocity constraint.

    def __init__(self, mechanism: Mechanism, meets: npt.NDArray[np.bool_], owner: Array) -> None:
        rows, none = np.array(owner), len(meets)
        while True:
            # give rows that share a velocity their least number, until nothing changes
            columns = np.where(meets, rows[:, None], none).min(axis=0, initial=none)
            least = np.where(meets, columns, none).min(axis=1, initial=none)
            joined = np.minimum(rows, least)
            joined = np.array([joined[owner == label].min() for label in owner], dtype=int)
            if np.array_equal(joined, rows):
                break
            rows = joined
        numbers = np.unique(rows)
        self.rows: npt.NDArray[np.int_] = np.searchsorted(numbers, rows)
        """Number of the part of each row, shape (m,)."""
        self.columns: npt.NDArray[np.int_] = np.where(
            columns < none, np.searchsorted(numbers, columns), -1
        )
        """Number of the part of each velocity, −1 if it moves no loop, shape (nv,)."""
        self.count = len(numbers)
        self.length = characteristic_length(mechanism)
        """The characteristic length of the whole mechanism [m]."""
        self.lengths: Array = np.full(self.count, self.length)
        """The characteristic length of each part [m]."""
        for part in range(self.count if self.count > 1 else 0):
            names = _carriers(mechanism, set(owner[self.rows == part].tolist()))
            self.lengths[part] = characteristic_length(mechanism, names)

    def open(self, rows: npt.NDArray[np.bool_]) -> npt.NDArray[np.bool_]:
        """Return whether each velocity belongs to the part of one of some rows, shape (nv,)."""
        return np.isin(self.columns, self.rows[rows])


def _carriers(mechanism: Mechanism, owners: set[int]) -> set[str]:
    """Return the names of some loops and contacts, and of the joints that carry them."""
    above = {joint.child: joint for joint in mechanism.joints}
    ends = {
        **{k: (loop.name, loop.body_a, loop.body_b) for k, loop in enumerate(mechanism.loops)},
        **{
            k: (contact.name, contact.body, contact.on)
            for k, contact in enumerate(mechanism.contacts, len(mechanism.loops))
        },
    }
    carriers = set[str]()
    for name, *bodies in (ends[k] for k in owners & ends.keys()):
        carriers.add(name)
        for body in bodies:
            while body in above:
                carriers.add(above[body].name)
                body = above[body].parent
    return carriers


_AT = {"x": 0, "y": 1, "z": 2, "rx": 3, "ry": 4, "rz": 5}


class LoopClosure(NamedTuple):
    """The constraints in one state."""

    residual: Array  # Φ, shape (m,) [m or rad]
    jacobian: Array  # J, shape (m, nv)
    drift: Array  # b, the part of Φ' without v, shape (m,)
    gamma: Array  # γ, the part of Φ'' without a, shape (m,)


class _Ends(NamedTuple):
    """The frames on one side of all loops, each in the moving joint that carries its body."""

    joints: npt.NDArray[np.int_]  # shape (loops,), indices of these joints
    turns: Array  # shape (loops, 3, 3)
    points: Array  # shape (loops, 3)


class _Row(NamedTuple):
    """One constraint equation: the loop, its index, and the relative motion that it closes."""

    owner: int
    loop: Loop
    motion: str


class ScaledClosure(NamedTuple):
    """The constraints in one state, scaled to dimensionless numbers."""

    gaps: Array  # Φ, shape (m,)
    jacobian: Array  # J, shape (m, nv)
    rates: Array  # J v + b, shape (m,)
    rounding: Array  # what rounding may make of an entry of each row of J, shape (m,)


@final
class Closures:
    """All constraint equations of a mechanism: of loops, contacts and velocity constraints."""

    def __init__(self, mechanism: Mechanism, engine: EngineModel, chart: Chart) -> None:
        pin = engine_package()

        self._pin = pin
        self._engine = engine
        self._chart = chart
        self._loops = mechanism.loops
        self._a, self._b = (_find_ends(pin, mechanism, engine, side) for side in "ab")
        carried = velocities_that_carry(engine)
        self.contacts = ContactRows(mechanism, engine, carried)
        """The rows of rolling and blades, with their points of contact."""
        self._velocity_rows = VelocityRows(mechanism)
        self._between: Array = carried[self._b.joints] - carried[self._a.joints]
        self._masks = np.concatenate([self._between, carried[self._a.joints]]).T
        joints = np.stack([self._a.joints, self._b.joints], axis=1)
        self._used = np.unique(joints)
        self._slot = np.searchsorted(self._used, joints)
        rows = [
            _Row(k, loop, row) for k, loop in enumerate(self._loops) for row in CLOSED[loop.kind]
        ]
        self.names = (
            *(f"{row.loop.name}: {row.motion}" for row in rows),
            *self.contacts.names,
            *self._velocity_rows.names,
        )
        """Name of each row: its loop and the relative motion it closes, in the axes of frame a;

        its contact and the motion that prevents; or its velocity constraint.
        """
        self._owner = np.array([row.owner for row in rows], dtype=int)
        self._component = np.array([_AT.get(row.motion, 0) for row in rows], dtype=int)
        many = len(self._velocity_rows.names)
        self.owner: Array = np.concatenate(
            [
                self._owner,
                len(self._loops) + self.contacts.owner,
                len(self._loops) + len(mechanism.contacts) + np.arange(many),
            ]
        )
        """The index of the loop, contact or velocity constraint of each row, shape (m,)."""
        self.positional: Array = np.concatenate(
            [np.ones(len(rows), bool), self.contacts.positional, np.zeros(many, bool)]
        )
        """Whether each row is the rate of a Φ, and so restricts positions, shape (m,)."""
        self._rods = [i for i, row in enumerate(rows) if row.motion == "length"]
        self._lengths = [mechanism.evaluate(rows[i].loop.length) for i in self._rods]
        self._plates = [
            i for i, row in enumerate(rows) if row.motion == "rz" and row.loop.kind == "plate"
        ]
        self._hinges = [k for k, loop in enumerate(self._loops) if loop.kind == "hinge"]
        self._welds = [k for k, loop in enumerate(self._loops) if loop.kind == "weld"]
        meets = np.concatenate(
            [self._between[self._owner], self.contacts.meets, np.ones((many, engine.model.nv))]
        )
        self.parts = Parts(mechanism, chart.reach(meets), self.owner)
        """Constraints that share no motion."""
        self.length = self.parts.length
        """The characteristic length, with which others are compared [m]."""
        lengths = self.parts.lengths
        is_length = np.concatenate(
            [self._component < 3, np.ones(len(self.contacts.names), bool), np.zeros(many, bool)]
        )
        self._lengthy = np.flatnonzero(is_length)
        self._owner_of_length = self.owner[self._lengthy]
        self._blocks = 2 * self.owner
        self._blocks[: len(self._component)] += self._component >= 3
        self.rows: Array = np.where(is_length, 1 / lengths[self.parts.rows], 1.0)
        """Factors that make the rows dimensionless: 1/length for lengths, 1 for angles."""
        around = np.append(lengths, self.length)  # the last, at −1, for velocities outside loops
        self.columns: Array = velocity_scales(mechanism, around[self.parts.columns])
        """Units of the velocities, shape (nv,): the characteristic length, or one radian."""
        self._u: Array = np.zeros(engine.model.nv)
        self._places: Array = np.zeros((len(self._loops), 3))
        self._spans: Array = np.zeros((len(self._loops), 3))
        self._state: tuple[Array, Array, float] = (
            np.zeros(mechanism.nq),
            np.zeros(mechanism.nv),
            0,
        )

    def at(self, q: Array, v: Array, t: float) -> LoopClosure:
        """Return the constraints in a state."""
        self.move(q, v, t)
        return self.now()

    @property
    def units(self) -> NaturalUnits:
        """Natural units of rows and velocities; a loop's lengths and angles are a block each."""
        # The rounding is that of the last state
        return NaturalUnits(self.rows, self.columns, self._blocks, self._rounding_of_rows)

    def _rounding_of_rows(self) -> Array:
        """Return what rounding may make of entries of each row, natural units, (m,)."""
        # Velocities are those of points at the world's origin, carried to the place where a loop
        # closes: a difference of terms as long as the way there
        places = self._places
        if self.contacts.names:
            met = self.contacts.met
            places = np.concatenate([places, met]) if self._loops else met
        # once for each step of a search: ufuncs alone, which skip the checks of numpy's functions
        distances = np.sqrt(np.add.reduce(places * places, 1))
        way = np.zeros(len(self.owner))
        way[self._lengthy] = distances[self._owner_of_length] * self.rows[self._lengthy]
        size = 1.0 + way
        for i, k in zip(self._rods, self._owner[self._rods], strict=True):
            # the rod's direction is the less certain, the shorter it is
            size[i] *= 1 + 1 / max(self.rows[i] * float(np.linalg.norm(self._spans[k])), TINY)
        return ROUNDING * size

    def rounding(self) -> float:
        """Return the gap that rounding leaves in closed loops in the last state, natural units."""
        data = self._engine.data
        extent = max(float(np.abs(pose.translation).max()) for pose in data.oMi)
        return ROUNDING * (1 + extent / float(self.parts.lengths.min(initial=self.length)))

    def scale(self, q: Array, v: Array, t: float) -> ScaledClosure:
        """Return the constraints in a state, scaled by `rows` and `columns`."""
        closure = self.at(q, v, t)
        return ScaledClosure(
            self.rows * closure.residual,
            self.rows[:, None] * closure.jacobian * self.columns,
            self.rows * (closure.jacobian @ v + closure.drift),
            self._rounding_of_rows(),
        )

    def move(self, q: Array, v: Array, t: float) -> tuple[list[float], Array]:
        """Move the engine's bodies to a state; return q with the driven coordinates, and u."""
        chart = self._chart
        values = chart.place(q, t)
        self._u = chart.at(q, v, t)
        self._state = (q, v, t)
        self._pin.computeJointJacobiansTimeVariation(
            self._engine.model, self._engine.data, chart.p, self._u
        )
        return values, self._u

    def now(self, *, residual: bool = True) -> LoopClosure:
        """Return the constraints in the state of the last `move`."""
        parts = [self._of_loops(residual)] if self._loops else []
        if self.contacts.names:
            parts.append(self._project(*self.contacts.now(self._u)))
        if self._velocity_rows.names:
            parts.append(LoopClosure(*self._velocity_rows.now(*self._state)))
        if len(parts) == 1:
            return parts[0]
        return LoopClosure(*map(np.concatenate, zip(*parts, strict=True)))

    def _of_loops(self, residual: bool) -> LoopClosure:
        data, u = self._engine.data, self._u
        turn, here, place = self._frames()
        self._places, self._spans = place, here[0]
        # with a single velocity the engine returns matrices as vectors
        columns, changes = data.J.reshape(6, -1), data.dJ.reshape(6, -1)
        # twists at the world's origin, of b relative to a and of a, with their rates at constant u
        sums = np.concatenate([columns * u, changes * u]) @ self._masks
        (linear, spin, linear_gain, spin_gain), (linear_a, spin_a, *_) = sums.T.reshape(
            2, -1, 4, 3, 1
        ).swapaxes(1, 2)
        at, turning, turning_a = hat(np.array([place, spin[:, :, 0], spin_a[:, :, 0]]))
        parting = linear - at @ spin
        moved = linear_a - at @ spin_a + parting
        change = linear_gain - at @ spin_gain + turning @ moved - turning_a @ parting
        inverse = turn.transpose(0, 2, 1)
        inside = inverse @ np.concatenate(
            [parting, spin, change, spin_gain - turning_a @ spin], axis=2
        )
        six = inside.transpose(0, 2, 1).reshape(-1, 2, 6)
        phi = self._residual(here) if residual else np.zeros(len(self._owner))
        J = self._relative_twists(turn, place)
        return self._select(phi, here, J, six[:, 0], six[:, 1])

    def slopes(self, q: Array, t: float) -> tuple[Array, Array]:
        """Return `scale`'s J and rounding at a position, without what velocities change."""
        chart, still = self._chart, np.zeros(len(self.columns))
        if self.contacts.names or self._velocity_rows.names:
            closure = self.scale(q, still, t)
            return closure.jacobian, closure.rounding
        chart.place(q, t)
        self._pin.computeJointJacobians(self._engine.model, self._engine.data, chart.p)
        turn, here, place = self._frames()
        self._places, self._spans = place, here[0]
        rows = self._rows_of_loops(here, self._relative_twists(turn, place))
        if not chart.identical:
            chart.at(q, still, t)
            rows = rows @ chart.G
        return self.rows[:, None] * rows * self.columns, self._rounding_of_rows()

    def _relative_twists(self, turn: Array, place: Array) -> Array:
        """Return velocity at b's origin and angular velocity of b in a's axes, (loops, 6, nv)."""
        columns, inverse = self._engine.data.J.reshape(6, -1), turn.transpose(0, 2, 1)
        (at,) = hat(place[None])
        J = np.empty((len(place), 6, columns.shape[1]))
        J[:, :3] = inverse @ (columns[:3] - at @ columns[3:])
        J[:, 3:] = inverse @ columns[3:]
        J *= self._between[:, None, :]
        return J

    def _rows_of_loops(self, here: tuple[Array, Array], J: Array) -> Array:
        """Select rows of J from the six of each loop; some kinds combine them."""
        place, turn = here
        rows: Array = J[self._owner, self._component]
        for i in self._rods:
            k = self._owner[i]
            rows[i] = _unit(place[k]) @ J[k, :3]
        for i in self._plates:
            k = self._owner[i]
            rows[i] = _plate_row(turn[k]) @ J[k, 3:]
        return rows

    def residual(self, q: Array, t: float) -> Array:
        """Return Φ, shape (m,)."""
        self._chart.place(q, t)
        self._pin.forwardKinematics(self._engine.model, self._engine.data, self._chart.p)
        parts = [self._residual(self._frames()[1])] if self._loops else []
        parts += [self.contacts.residual(), np.zeros(len(self._velocity_rows.names))]
        return np.concatenate(parts)

    def wrenches(self, multipliers: Array) -> tuple[Array, Array, Array]:
        """Return force, moment and point of action of body a on b for each loop, world axes."""
        # The wrenches of contacts follow, on the body that rolls, at its hub, or that has the
        # blade. The engine's data must contain the state in question. The point of a loop is the
        # origin of frame b.
        first, end = len(self._owner), len(self._owner) + len(self.contacts.names)
        contacts = self.contacts.wrenches(multipliers[first:end])
        if not self._loops:
            return contacts
        turn, here, place = self._frames()
        force, moment = np.zeros((2, len(self._loops), 3))
        for i, (k, at) in enumerate(zip(self._owner, self._component, strict=True)):
            if i in self._rods:
                force[k] += multipliers[i] * _unit(here[0][k])
            elif i in self._plates:
                moment[k] += multipliers[i] * _plate_row(here[1][k])
            elif at < 3:
                force[k, at] += multipliers[i]
            else:
                moment[k, at - 3] += multipliers[i]
        force = (turn @ force[:, :, None])[:, :, 0]
        moment = (turn @ moment[:, :, None])[:, :, 0]
        loops = force, moment, place
        force, moment, place = (np.concatenate(pair) for pair in zip(loops, contacts, strict=True))
        return force, moment, place

    def _frames(self) -> tuple[Array, tuple[Array, Array], Array]:
        """Return each frame a's rotation, frame b's pose in it, and b's origin in the world."""
        poses = [self._engine.data.oMi[int(joint)] for joint in self._used]
        turns = np.array([pose.rotation for pose in poses])
        places = np.array([pose.translation for pose in poses])
        a, b = self._slot.T
        turn = turns[a] @ self._a.turns
        origin = places[a] + (turns[a] @ self._a.points[:, :, None])[:, :, 0]
        place = places[b] + (turns[b] @ self._b.points[:, :, None])[:, :, 0]
        inverse = turn.transpose(0, 2, 1)
        here = (inverse @ (place - origin)[:, :, None])[:, :, 0], inverse @ turns[b] @ self._b.turns
        return turn, here, place

    def _residual(self, here: tuple[Array, Array]) -> Array:
        place, turn = here
        six = np.concatenate([place, np.zeros_like(place)], axis=1)
        for k in self._hinges:
            six[k, 3:5] = _find_tilt(turn[k])
        for k in self._welds:
            six[k, 3:] = self._pin.log3(turn[k])
        phi: Array = six[self._owner, self._component]
        for i, length in zip(self._rods, self._lengths, strict=True):
            phi[i] = np.linalg.norm(place[self._owner[i]]) - length
        for i in self._plates:
            R = turn[self._owner[i]]
            phi[i] = math.atan2(R[1, 0], R[0, 0])
        return phi

    def _select(
        self, phi: Array, here: tuple[Array, Array], J: Array, rate: Array, second: Array
    ) -> LoopClosure:
        """Select rows from the six of each loop; distances and angles in a plane combine them."""
        place, turn = here
        rows = self._rows_of_loops(here, J)
        gamma: Array = second[self._owner, self._component]
        for i in self._rods:
            k = self._owner[i]
            along, distance = _unit(place[k]), float(np.linalg.norm(place[k]))
            parting = rate[k, :3]
            across = float(parting @ parting) - float(along @ parting) ** 2
            gamma[i] = along @ second[k, :3] + (across / distance if distance else 0.0)
        for i in self._plates:
            k = self._owner[i]
            spin, x = rate[k, 3:], turn[k][:, 0]
            row, level = _plate_row(turn[k]), float(x[0] ** 2 + x[1] ** 2)
            slope = cross(spin, x)
            # θ' = w·ω with w = (−x z, −y z, x² + y²) / (x² + y²) for b's axis (x, y, z);
            # θ'' = w·ω' + w'·ω
            (a, b, c), (da, db, dc) = x, slope
            change = np.array([-(da * c + a * dc), -(db * c + b * dc), 0.0]) / level
            change[:2] += np.array([a * c, b * c]) * 2 * (a * da + b * db) / level**2
            gamma[i] = row @ second[k, 3:] + change @ spin
        return self._project(phi, rows, np.zeros(len(rows)), gamma)

    def _project(self, phi: Array, rows: Array, drift: Array, gamma: Array) -> LoopClosure:
        """Convert rows in the engine's velocities to rows in the mechanism's."""
        chart = self._chart
        if chart.identical:
            return LoopClosure(phi, rows, drift, gamma)
        return LoopClosure(phi, rows @ chart.G, drift + rows @ chart.c, gamma + rows @ chart.gamma)


def _find_ends(pin: Any, mechanism: Mechanism, engine: EngineModel, side: str) -> _Ends:
    """Return the frames of the loops on side a or b."""
    joints, poses = [], []
    for loop in mechanism.loops:
        frame: Placement = getattr(loop, f"frame_{side}")
        holder = engine.holders[getattr(loop, f"body_{side}")]
        joints.append(holder.joint)
        poses.append(holder.placement * pin.SE3(mechanism.matrix(frame)))
    return _Ends(
        np.array(joints, dtype=int),
        np.array([pose.rotation for pose in poses]).reshape(-1, 3, 3),
        np.array([pose.translation for pose in poses]).reshape(-1, 3),
    )


def velocities_that_carry(engine: EngineModel) -> Array:
    """Return 1 where a velocity of the engine moves a joint of it, else 0, shape (joints, nv)."""
    model = engine.model
    carried: Array = np.zeros((model.njoints, model.nv))
    for index in range(1, model.njoints):
        joint = model.joints[index]
        carried[index] = carried[model.parents[index]]
        carried[index, joint.idx_v : joint.idx_v + joint.nv] = 1.0
    return carried


def _unit(vector: Array) -> Array:
    length = float(np.linalg.norm(vector))
    # a rod of length zero has no direction; any one lets an assembly begin
    return vector / length if length else np.array([1.0, 0.0, 0.0])


def _find_tilt(turn: Array) -> Array:
    """Return the rotation about x and y that takes z to the z axis of b, shape (2,)."""
    x, y, z = turn[:, 2]
    level = math.hypot(x, y)
    if not level:
        return np.array([0.0 if z > 0 else math.pi, 0.0])
    return np.array([-y, x]) * (math.atan2(level, z) / level)


def _plate_row(turn: Array) -> Array:
    """Return ∂θ'/∂ω for the angle θ of b's x axis within the plane."""
    x, y, z = turn[:, 0]
    level = x * x + y * y
    return np.array([-x * z / level, -y * z / level, 1.0])
