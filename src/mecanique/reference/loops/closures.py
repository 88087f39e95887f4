"""Compute the constraints of loops by Pinocchio's kinematics: Φ(q, t), Φ' = J v + b, Φ'' = J a + γ.

Each row of a loop or a contact holds two bodies together in a direction n: Φ' = n·v, where v is the
velocity of body b relative to body a at the place P where they meet, or Φ' = n·ω with their
relative angular velocity. With twists (l, ω) at the world's origin v = l + ω × P, and along the
motion v' = l' + ω' × P + ω × P' and Φ'' = n·v' + n'·v. A loop meets at the origin of frame b, in
directions of the axes of frame a, of the rod, or about those that turn b's x axis within the plane.
The relative twist is the sum of the columns of the spatial Jacobian of those joints that carry only
one of the two bodies (Featherstone, Rigid Body Dynamics Algorithms, 2008, sect. 8.2 to 8.4).
"""

from __future__ import annotations

import math
from typing import NamedTuple, final

import numpy as np
import numpy.typing as npt

from mecanique.arrays import Array, cross
from mecanique.model.constraints.loops import CLOSED
from mecanique.model.mechanism import Mechanism
from mecanique.model.mechanism_units import characteristic_length, turns, velocity_scales
from mecanique.reference.engine.chart import Chart
from mecanique.reference.engine.load import EngineModel
from mecanique.reference.engine.package import engine_package
from mecanique.reference.loops.contacts import (
    ContactRows,
    LoopClosure,
    Meeting,
    VelocityRows,
)
from mecanique.reference.loops.nullspace import NaturalUnits
from mecanique.reference.tolerances import ROUNDING, TINY
from mecanique.reference.vectors import hat


class Ends(NamedTuple):
    """The bodies that a loop or a contact holds together."""

    name: str
    acting: str  # body a of a loop, or the body with the plane
    acted: str  # body b of a loop, or the body that rolls or has the blade
    point: tuple[float, float, float]  # where the wrench on it is reported, in its frame [m]


def ends_of(mechanism: Mechanism) -> list[Ends]:
    """Return the ends of all loops, then of all contacts."""
    ends = []
    for loop in mechanism.loops:
        x, y, z = mechanism.evaluate_all(loop.frame_b.xyz)
        ends.append(Ends(loop.name, loop.body_a, loop.body_b, (x, y, z)))
    for contact in mechanism.contacts:
        x, y, z = mechanism.evaluate_all(contact.seat)
        ends.append(Ends(contact.name, contact.on, contact.body, (x, y, z)))
    return ends


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


def _carriers(mechanism: Mechanism, owners: set[int]) -> set[str]:
    """Return the names of some loops and contacts, and of the joints that carry them."""
    above = {joint.child: joint for joint in mechanism.joints}
    carriers = set[str]()
    for ends in (end for k, end in enumerate(ends_of(mechanism)) if k in owners):
        carriers.add(ends.name)
        for body in (ends.acting, ends.acted):
            while body in above:
                carriers.add(above[body].name)
                body = above[body].parent
    return carriers


_AT = {"x": 0, "y": 1, "z": 2, "rx": 3, "ry": 4, "rz": 5}


class ScaledClosure(NamedTuple):
    """The constraints in one state, scaled to dimensionless numbers."""

    gaps: Array  # Φ, shape (m,)
    jacobian: Array  # J, shape (m, nv)
    rates: Array  # J v + b, shape (m,)
    rounding: Array  # what rounding may make of an entry of each row of J, shape (m,)


@final
class LoopRows:
    """The rows of a mechanism's loops."""

    def __init__(self, mechanism: Mechanism, engine: EngineModel, carried: Array) -> None:
        pin = engine_package()

        self._engine, self._log = engine, pin.log3
        loops = mechanism.loops
        rows = [(k, loop, row) for k, loop in enumerate(loops) for row in CLOSED[loop.kind]]
        self.names = tuple(f"{loop.name}: {row}" for _, loop, row in rows)
        """Name of each row, "loop: relative motion it closes", in the axes of frame a."""
        self.owner = np.array([k for k, _, _ in rows], dtype=int)
        """The index of the loop of each row, shape (m,)."""
        self._component = np.array([_AT.get(row, 0) for *_, row in rows], dtype=int)
        self.angular = self._component >= 3
        """Whether each row closes an angle, shape (m,)."""
        self.rods = [(i, k) for i, (k, _, row) in enumerate(rows) if row == "length"]
        """The rows that keep a distance, each with the index of its loop."""
        self._lengths = [mechanism.evaluate(rows[i][1].length) for i, _ in self.rods]
        self._plates = [
            (i, k) for i, (k, loop, row) in enumerate(rows) if (loop.kind, row) == ("plate", "rz")
        ]
        self._hinges = [k for k, loop in enumerate(loops) if loop.kind == "hinge"]
        self._welds = [k for k, loop in enumerate(loops) if loop.kind == "weld"]
        # frames a, then frames b, each in the moving joint that carries its body
        ends = [(loop.body_a, loop.frame_a) for loop in loops]
        ends += [(loop.body_b, loop.frame_b) for loop in loops]
        holders = [engine.holders[body] for body, _ in ends]
        poses = [
            holder.placement * pin.SE3(mechanism.matrix(frame))
            for holder, (_, frame) in zip(holders, ends, strict=True)
        ]
        self._turns = np.array([pose.rotation for pose in poses]).reshape(2, -1, 3, 3)
        self._points = np.array([pose.translation for pose in poses]).reshape(2, -1, 3, 1)
        joints = np.array([holder.joint for holder in holders], dtype=int).reshape(2, -1)
        self._used = np.unique(joints)
        self._slot = np.searchsorted(self._used, joints)
        self._carried = carried[joints]
        self.between: Array = self._carried[1] - self._carried[0]
        """Which velocities move frame b, minus those that move frame a, shape (k, nu)."""
        self.meets: Array = self.between[self.owner]
        """Not zero where a row may depend on a velocity, shape (m, nu)."""
        self.spans: Array = np.zeros((len(loops), 3))
        """From the origin of frame a to that of frame b at the last meeting, shape (k, 3)."""

    def meet(self, moving: Array | None = None, *, gaps: bool = True) -> Meeting:
        """Return where loops close by J u, column by column, without which the bodies rest."""
        poses = [self._engine.data.oMi[int(joint)] for joint in self._used]
        turns = np.array([pose.rotation for pose in poses]).reshape(-1, 3, 3)[self._slot]
        places = np.array([pose.translation for pose in poses]).reshape(-1, 3)[self._slot]
        places = places + (turns @ self._points)[..., 0]
        turn_a, turn_b = turns @ self._turns
        place, self.spans = places[1], places[1] - places[0]
        directions = turn_a[self.owner, :, self._component % 3]
        rates, turning = np.zeros_like(place), np.zeros_like(directions)
        spins = velocities = np.zeros((2, *place.shape))
        if moving is not None:
            twists = self._carried @ moving.T
            spins = twists[..., 3:]
            about = hat(spins)
            # of the bodies' points where loops close
            velocities = twists[..., :3] + (about @ place[:, :, None])[..., 0]
            rates = velocities[1]
            turning = (about[0, self.owner] @ directions[:, :, None])[:, :, 0]
        for i, k in self.rods:
            length = float(np.linalg.norm(self.spans[k]))
            # a rod of length zero has no direction; any one lets an assembly begin
            n = directions[i] = self.spans[k] / length if length else turn_a[k, :, 0]
            parting = velocities[1, k] - velocities[0, k]
            across = parting - (n @ parting) * n
            turning[i] = cross(spins[0, k], n) + across / (length or np.inf)
        for i, k in self._plates:
            inside = turn_a[k].T @ np.array([turn_b[k, :, 0], spins[1, k] - spins[0, k]]).T
            w, change = _turn_in_plane(inside[:, 0], cross(inside[:, 1], inside[:, 0]))
            directions[i] = turn_a[k] @ w
            turning[i] = cross(spins[0, k], directions[i]) + turn_a[k] @ change
        phi = self._gaps(turn_a, turn_b) if gaps else np.zeros(len(self.names))
        return Meeting(place, rates, directions, turning, place, phi)

    def _gaps(self, turn_a: Array, turn_b: Array) -> Array:
        """Return Φ of all rows, shape (m,)."""
        back = turn_a.transpose(0, 2, 1)
        place, turn = (back @ self.spans[:, :, None])[:, :, 0], back @ turn_b
        six = np.concatenate([place, np.zeros_like(place)], axis=1)
        for k in self._hinges:
            six[k, 3:5] = _find_tilt(turn[k])
        for k in self._welds:
            six[k, 3:] = self._log(turn[k])
        phi: Array = six[self.owner, self._component]
        for (i, k), length in zip(self.rods, self._lengths, strict=True):
            phi[i] = np.linalg.norm(place[k]) - length
        for i, k in self._plates:
            phi[i] = math.atan2(turn[k, 1, 0], turn[k, 0, 0])
        return phi


@final
class Closures:
    """All constraint equations of a mechanism: of loops, contacts and velocity constraints."""

    def __init__(self, mechanism: Mechanism, engine: EngineModel, chart: Chart) -> None:
        self._pin = engine_package()
        self._engine = engine
        self._chart = chart
        carried = velocities_that_carry(engine)
        self._loops = LoopRows(mechanism, engine, carried)
        self.contacts = ContactRows(mechanism, engine, carried)
        """The rows of rolling and blades."""
        self._velocity_rows = VelocityRows(mechanism)
        self.ends = ends_of(mechanism)
        """The bodies that each loop and contact holds together."""
        self._between: Array = np.concatenate([self._loops.between, self.contacts.between])
        self.names = (*self._loops.names, *self.contacts.names, *self._velocity_rows.names)
        """Name of each row: its loop and the relative motion it closes, in the axes of frame a;

        its contact and the motion that prevents; or its velocity constraint.
        """
        many = len(self._velocity_rows.names)
        self._owner = np.concatenate(
            [self._loops.owner, len(mechanism.loops) + self.contacts.owner]
        )
        self.owner: Array = np.concatenate([self._owner, len(self.ends) + np.arange(many)])
        """The index of the loop, contact or velocity constraint of each row, shape (m,)."""
        self.positional: Array = np.concatenate(
            [np.ones(len(self._loops.names), bool), self.contacts.positional, np.zeros(many, bool)]
        )
        """Whether each row is the rate of a Φ, and so restricts positions, shape (m,)."""
        self._angular = np.zeros(len(self._owner), dtype=int)
        self._angular[: len(self._loops.names)] = self._loops.angular
        # sums rows to the force and the moment of each loop and contact
        places = 2 * self._owner + self._angular
        self._sums = np.equal.outer(np.arange(2 * len(self.ends)), places).astype(float)
        meets = np.concatenate(
            [self._loops.meets, self.contacts.meets, np.ones((many, engine.model.nv))]
        )
        self.parts = Parts(mechanism, chart.reach(meets), self.owner)
        """Constraints that share no motion."""
        self.length = self.parts.length
        """The characteristic length, with which others are compared [m]."""
        lengths = self.parts.lengths
        self._lengthy = np.flatnonzero(self._angular == 0)
        self._blocks = 2 * self.owner
        self._blocks[: len(self._owner)] += self._angular
        self.rows: Array = np.ones(len(self.owner))
        """Factors that make the rows dimensionless: 1/length for lengths, 1 for angles."""
        self.rows[self._lengthy] = 1 / lengths[self.parts.rows[self._lengthy]]
        around = np.append(lengths, self.length)  # the last, at −1, for velocities outside loops
        self.columns: Array = velocity_scales(mechanism, around[self.parts.columns])
        """Units of the velocities, shape (nv,): the characteristic length, or one radian."""
        self.turning = turns(mechanism)
        self._u: Array = np.zeros(engine.model.nv)
        self._places: Array = np.zeros((len(self.ends), 3))
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
        # closes: a difference of terms as long as the way there.
        # Once for each step of a search: ufuncs alone, which skip the checks of numpy's functions
        distances = np.sqrt(np.add.reduce(self._places * self._places, 1))
        size = np.ones(len(self.owner))
        size[self._lengthy] += distances[self._owner[self._lengthy]] * self.rows[self._lengthy]
        for i, k in self._loops.rods:
            # the rod's direction is the less certain, the shorter it is
            size[i] *= 1 + 1 / max(self.rows[i] * float(np.linalg.norm(self._loops.spans[k])), TINY)
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
        u, chart = self._u, self._chart
        # with a single velocity the engine returns matrices as vectors
        columns, changes = (x.reshape(6, -1) for x in (self._engine.data.J, self._engine.data.dJ))
        met = self._meet(columns * u, gaps=residual)
        at, along = hat(np.array([met.places, met.rates]))
        J = self._relative_twists(columns, at)
        twists, gains = J @ u, ((changes * u) @ self._between.T).T.reshape(-1, 2, 3)
        gains[:, 0] -= (at @ gains[:, 1, :, None] + along @ twists[:, 1, :, None])[:, :, 0]
        held = self._owner, self._angular
        rows = (met.directions[:, None] @ J[held])[:, 0]
        gamma = np.add.reduce(met.directions * gains[held] + met.turning * twists[held], 1)
        drift = np.zeros(len(rows))
        if not chart.identical:
            rows, drift, gamma = rows @ chart.G, rows @ chart.c, gamma + rows @ chart.gamma
        closure = LoopClosure(met.gaps, rows, drift, gamma)
        if not self._velocity_rows.names:
            return closure
        return LoopClosure(
            *map(np.concatenate, zip(closure, self._velocity_rows.now(*self._state), strict=True))
        )

    def slopes(self, q: Array, t: float) -> tuple[Array, Array]:
        """Return `scale`'s J and rounding at a position, without what velocities change."""
        chart, still = self._chart, np.zeros(len(self.columns))
        if self._velocity_rows.names:
            closure = self.scale(q, still, t)
            return closure.jacobian, closure.rounding
        chart.place(q, t)
        self._pin.computeJointJacobians(self._engine.model, self._engine.data, chart.p)
        columns = self._engine.data.J.reshape(6, -1)
        met = self._meet()
        J = self._relative_twists(columns, hat(met.places))
        rows = (met.directions[:, None] @ J[self._owner, self._angular])[:, 0]
        if not chart.identical:
            chart.at(q, still, t)
            rows = rows @ chart.G
        return self.rows[:, None] * rows * self.columns, self._rounding_of_rows()

    def residual(self, q: Array, t: float) -> Array:
        """Return Φ, shape (m,)."""
        self._chart.place(q, t)
        self._pin.forwardKinematics(self._engine.model, self._engine.data, self._chart.p)
        return np.concatenate(
            [self._meet(gaps=True).gaps, np.zeros(len(self._velocity_rows.names))]
        )

    def wrenches(self, multipliers: Array) -> tuple[Array, Array, Array]:
        """Return force, moment and point of action on b for each loop and contact, world axes."""
        # The engine's data must contain the state in question. The point is the origin of frame b,
        # or that of the body that rolls at its hub
        met = self._meet()
        pushes = multipliers[: len(self._owner), None] * met.directions
        six = (self._sums @ pushes).reshape(-1, 2, 3)
        return six[:, 0], six[:, 1] + cross(met.places - met.seats, six[:, 0]), met.seats

    def _meet(self, moving: Array | None = None, *, gaps: bool = False) -> Meeting:
        """Return where all loops and contacts meet in the engine's present state, by J u."""
        if not self.contacts.names:
            met = self._loops.meet(moving, gaps=gaps)
        else:
            met = self.contacts.meet(moving)
            if self._loops.names:
                loops = self._loops.meet(moving, gaps=gaps)
                met = Meeting(*map(np.concatenate, zip(loops, met, strict=True)))
        self._places = met.places
        return met

    def _relative_twists(self, columns: Array, at: Array) -> Array:
        """Return relative velocity where bodies meet and angular velocity, by u, (k, 2, 3, nu)."""
        J = np.empty((len(at), 2, 3, columns.shape[1]))
        J[:, 0] = columns[:3] - at @ columns[3:]
        J[:, 1] = columns[3:]
        J *= self._between[:, None, None]
        return J


def velocities_that_carry(engine: EngineModel) -> Array:
    """Return 1 where a velocity of the engine moves a joint of it, else 0, shape (joints, nv)."""
    model = engine.model
    carried: Array = np.zeros((model.njoints, model.nv))
    for index in range(1, model.njoints):
        joint = model.joints[index]
        carried[index] = carried[model.parents[index]]
        carried[index, joint.idx_v : joint.idx_v + joint.nv] = 1.0
    return carried


def _find_tilt(turn: Array) -> Array:
    """Return the rotation about x and y that takes z to the z axis of b, shape (2,)."""
    x, y, z = turn[:, 2]
    level = math.hypot(x, y)
    if not level:
        return np.array([0.0 if z > 0 else math.pi, 0.0])
    return np.array([-y, x]) * (math.atan2(level, z) / level)


def _turn_in_plane(x: Array, slope: Array) -> tuple[Array, Array]:
    """Return w of θ' = w·ω for the angle θ of an axis x within the plane, and w' by x'."""
    # w = (−x z, −y z, x² + y²) / (x² + y²)
    (a, b, c), (da, db, dc) = x, slope
    level = a * a + b * b
    change = np.array([-(da * c + a * dc), -(db * c + b * dc), 0.0]) / level
    change[:2] += np.array([a * c, b * c]) * 2 * (a * da + b * db) / level**2
    return np.array([-a * c / level, -b * c / level, 1.0]), change
