"""Evaluate a mechanism's tree by Pinocchio, in one state at a time and without checks.

With a coordinate map r = φ(q, t) the engine's equations are projected by G = ∂φ/∂q:
Gᵀ M_r G a + Gᵀ (M_r γ + b_r) = Gᵀ Q_r (Kane & Levinson, Dynamics, 1985, sect. 4.1, 6.1).

A reaction is the wrench of a parent on its child. Pinocchio's inverse dynamics stores in `data.f`
the wrench of a joint on all bodies that it carries, gravity included. Bodies that are welded by
fixed joints are one body there. The reaction in a fixed joint follows from the balance of the
bodies it carries: their inertia forces, minus the loads on them, plus the wrenches of the joints
beyond (Newton–Euler). `computeSupportedForceByFrame` promises the same, but needs data other than
inverse dynamics leaves.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple, NoReturn, final

import numpy as np

from mecanique.arrays import Array
from mecanique.errors import EngineError
from mecanique.model import Fixed, Mechanism
from mecanique.model.random_positions import draw_positions
from mecanique.model.states import Efforts
from mecanique.reference.engine.chart import Chart
from mecanique.reference.engine.forces.elements import Elements, GuideReactions, Unit, hold
from mecanique.reference.engine.forces.loads import Loads
from mecanique.reference.engine.forces.sites import External, SiteAction
from mecanique.reference.engine.load import EngineModel, Holder, load
from mecanique.reference.engine.package import engine_package
from mecanique.reference.engine.rhs import Rhs, fast_rhs
from mecanique.reference.tolerances import AGREEMENT, ILL_CONDITIONED, SINGULAR_MASS, TAKES_PART
from mecanique.wording import OF_SHAPES


class _Weld(NamedTuple):
    """What a fixed joint carries."""

    bodies: frozenset[str]  # those that are welded to its child, the child among them
    behind: list[int]  # the indices of the moving joints beyond


@final
class Reactions:
    """Reads the reactions of every joint from the engine's data."""

    def __init__(self, mechanism: Mechanism, engine: EngineModel) -> None:
        self._engine = engine
        self._joints: list[tuple[Holder, int | _Weld]] = []
        for joint in mechanism.joints:
            through: int | _Weld = engine.seats[joint.name][-1].index
            if isinstance(joint, Fixed):
                bodies = _weld(mechanism, joint.child)
                beyond = [j for j in mechanism.joints if j.parent in bodies]
                moving = [j.name for j in beyond if not isinstance(j, Fixed)]
                through = _Weld(bodies, [engine.seats[name][0].index for name in moving])
            self._joints.append((engine.holders[joint.child], through))

    def read(self, actions: list[SiteAction]) -> Array:
        """Return force and moment of parent on child at the child's origin, world axes, (n, 2, 3).

        The engine's data must contain positions (`forwardKinematics`) and inverse dynamics of the
        state in question.
        """
        data = self._engine.data
        wrenches = np.empty((len(self._joints), 2, 3))
        for k, (holder, through) in enumerate(self._joints):
            turn = data.oMi[holder.joint].rotation
            if isinstance(through, _Weld):
                whole = self._through_weld(through, holder.joint, actions)
                wrench, turn = holder.placement.actInv(whole), turn @ holder.placement.rotation
            else:
                # the frame of the joint's last link is the child's
                wrench = data.f[through]
            wrenches[k] = turn @ wrench.linear, turn @ wrench.angular
        return wrenches

    def _through_weld(self, weld: _Weld, joint: int, actions: list[SiteAction]) -> Any:
        """Return the wrench of a fixed joint on all it carries, in the moving joint's frame."""
        pin = engine_package()

        engine, data = self._engine, self._engine.data
        velocity, acceleration = data.v[joint], data.a_gf[joint]
        total = pin.Force.Zero()
        for body in weld.bodies:
            inertia = engine.holders[body].inertia
            total += inertia * acceleration + velocity.cross(inertia * velocity)
        for index in weld.behind:
            total += data.liMi[index].act(data.f[index])
        pose = data.oMi[joint]
        for action in actions:
            if action.site.body in weld.bodies:
                force = np.array(action.force)
                moment = np.array(action.moment(*pose.translation.tolist()))
                total -= pin.Force(pose.rotation.T @ force, pose.rotation.T @ moment)
        return total


def _weld(mechanism: Mechanism, body: str) -> frozenset[str]:
    """Return a body and all bodies that are welded to it by fixed joints."""
    bodies = {body}
    for joint in mechanism.tree:
        if isinstance(joint, Fixed) and joint.parent in bodies:
            bodies.add(joint.child)
    return frozenset(bodies)


_REACH = 1.0
"""Largest absolute value of a length in a random state [m]."""


def random_states(mechanism: Mechanism, count: int = 4) -> Iterator[tuple[Array, Array, float]]:
    """Yield random positions, velocities and times, the same in every call."""
    random = np.random.default_rng(1788)
    positions = draw_positions(mechanism, count, random, _REACH)
    velocities = random.normal(size=(count, mechanism.nv))
    yield from zip(positions, velocities, random.uniform(size=count).tolist(), strict=True)


def massless_mode(mass: Array, reach: Array) -> Array | None:
    """Return a motion that moves no mass, shape (nv,), largest component 1, or None."""
    # negative only for inertias that no real body has; these do have inertia
    diagonal = np.abs(np.diag(mass))
    for at in np.flatnonzero(~(diagonal > SINGULAR_MASS * reach)):
        mode: Array = np.zeros(len(mass))
        mode[at] = 1.0
        return mode
    if not len(mass):
        return None
    scale = 1 / np.sqrt(diagonal)
    values, vectors = np.linalg.eigh(mass * np.outer(scale, scale))
    least = int(np.argmin(np.abs(values)))
    if abs(values[least]) > SINGULAR_MASS:
        return None
    mode = vectors[:, least] * scale
    return np.asarray(mode / mode[np.argmax(np.abs(mode))])


def refuse_massless(mechanism: Mechanism, mode: Array, q: Array | None = None) -> NoReturn:
    """Refuse a mechanism for a motion that moves no mass, at q alone or wherever it is."""
    parts = zip(mechanism.velocities, mode, strict=True)
    names = [name for name, part in parts if abs(part) > TAKES_PART]
    joints = [joint for joint in mechanism.joints if set(joint.velocities) & set(names)]
    moved = "".join(f", joint {joint.name!r} (body {joint.child!r})" for joint in joints)
    motion = f"mechanism {mechanism.name!r}: the motion {', '.join(names)}{moved} moves no mass"
    mass = f"give the body mass or inertia ({OF_SHAPES})"
    if q is None:
        raise EngineError(
            f"{motion}, so nothing determines it; {mass}, or prescribe the joint by the coordinate "
            "map"
        )
    # as at the pole of polar coordinates, or where hinges are in line
    raise EngineError(
        f"{motion} at q = {q.tolist()}, though it does elsewhere: the coordinates are singular "
        f"there; choose another position or other coordinates, or {mass}"
    )


def reach_of(model: Any, data: Any) -> Array:
    """Return the mass that each of the engine's velocities moves, or its polar moment."""
    reach: Array = np.zeros(model.nv)
    for index in range(1, model.njoints):
        joint, carried = model.joints[index], data.Ycrb[index]
        polar = float(np.trace(carried.inertia)) + carried.mass * float(
            carried.lever @ carried.lever
        )
        span = slice(joint.idx_v, joint.idx_v + joint.nv)
        if joint.nv == 6:
            reach[span] = [carried.mass] * 3 + [polar] * 3
        else:
            reach[span] = carried.mass if joint.shortname().startswith("JointModelP") else polar
    reach += model.armature
    return reach


def backward_error(mass: Array, acceleration: Array, right: Array) -> float:
    """Return the residual of M a = right, relative to the size of its terms."""
    size = float((np.abs(mass) @ np.abs(acceleration) + np.abs(right)).max(initial=0.0))
    if not np.isfinite(size):
        return float("inf")
    return float(np.abs(mass @ acceleration - right).max(initial=0.0)) / size if size else 0.0


@final
class EngineTree:
    """The tree of a mechanism inside Pinocchio; arguments must be finite and of correct shape."""

    def __init__(self, mechanism: Mechanism) -> None:
        pin = engine_package()

        mechanism.refuse_switching("a Reference answers for one mode alone")
        self.mechanism = mechanism
        self.engine = load(mechanism)
        self.chart = Chart(mechanism, self.engine)
        self.loads = Loads(mechanism, self.engine, self.chart.index)
        self.elements = Elements(mechanism, self.engine, self.chart, self.loads.sites)
        self._pin = pin
        self._reactions = Reactions(mechanism, self.engine)
        self._supported = External(self.engine.model.njoints)
        holders = self.engine.holders
        self._body_frames = [holders[body.name].frame for body in mechanism.bodies]
        # Pinocchio omits bodies welded to the ground; the ground itself has no energy
        welded = (
            holder
            for name, holder in holders.items()
            if not holder.joint and name != mechanism.ground
        )
        resting = sum((holder.inertia for holder in welded), pin.Inertia.Zero())
        self.resting = -resting.mass * float(self.engine.model.gravity.linear @ resting.lever)
        """The potential energy of bodies welded to the ground [J]."""
        self.moving_mass = float(
            sum(self.engine.model.inertias[k].mass for k in range(1, self.engine.model.njoints))
        )
        """The mass of the bodies that are not welded to the ground [kg]."""
        self.massless: Array | None = None
        """A motion that moves no mass in any sampled state, shape (nv,); None without one."""
        data, joints = self.engine.data, range(self.engine.model.njoints)
        # views of the engine's own memory
        self._views = (
            [data.oMi[joint].rotation for joint in joints],
            [data.oMi[joint].translation for joint in joints],
            [data.v[joint].vector for joint in joints],
            [data.a[joint].vector for joint in joints],
        )
        self.demand = np.zeros(self.engine.model.nv)
        """The forces along the joints that the last `transmit` left to elements, shape (nu,)."""
        self.recursive = self._probe()
        """Whether the articulated-body recursion may give the accelerations."""
        if mechanism.elements:
            self._probe_elements()

    def move(
        self, q: Array, v: Array, t: float, a: Array | None = None
    ) -> tuple[list[float], Array, Array]:
        """Move the bodies to a state; return q with the driven joint coordinates, u and u'."""
        engine, chart = self.engine, self.chart
        values = chart.place(q, t)
        u = chart.at(q, v, t)
        if a is None:
            self._pin.forwardKinematics(engine.model, engine.data, chart.p, u)
            return values, u, u
        rate = a if chart.identical else chart.G @ a + chart.gamma
        self._pin.forwardKinematics(engine.model, engine.data, chart.p, u, rate)
        return values, u, rate

    def drive(self, efforts: Efforts, k: int, q: Array, v: Array, t: float) -> None:
        """Apply torques in addition to the mechanism's own forces, until `loads.drive(0)`."""
        chart = self.chart
        torques = np.zeros(self.engine.model.nv)
        for name, column in efforts.in_joints.items():
            torques[chart.rows[name]] = column[k]
        if efforts.generalized is not None:
            chart.at(q, v, t)
            # the least torques in joints that do the same virtual work
            torques += np.linalg.lstsq(chart.G.T, efforts.generalized[k], rcond=None)[0]
        self.loads.drive(torques)

    def _at(self, q: Array, v: Array, t: float) -> tuple[Any, Any, Array, Array]:
        """Set the chart to a state; return the engine's model, data, positions and velocities."""
        self.chart.place(q, t)
        u = self.chart.at(q, v, t)
        return self.engine.model, self.engine.data, self.chart.p, u

    def mass(self, q: Array, v: Array, t: float) -> Array:
        """Return M, shape (nv, nv); v does not matter."""
        full, chart = self._pin.crba(*self._at(q, v, t)[:3]), self.chart
        return np.array(full) if chart.identical else np.asarray(chart.G.T @ full @ chart.G)

    def bias(self, q: Array, v: Array, t: float) -> Array:
        """Return the inertia forces that do not depend on a, and gravity, shape (nv,)."""
        return self._reduce(self._pin.rnea(*self._at(q, v, t), self.chart.gamma))

    def gravity(self, q: Array, v: Array, t: float) -> Array:
        """Return ∂V/∂q of gravity, shape (nv,); v does not matter."""
        return self._reduce(self._pin.computeGeneralizedGravity(*self._at(q, v, t)[:3]))

    def _act(self, q: Array, v: Array, t: float) -> Array:
        """Move the bodies to a state, update the forces on them, and return the velocities u."""
        values, u, _ = self.move(q, v, t)
        self.loads.check()
        self.loads.update(values, q, u, v, t)
        return u

    def forces(self, q: Array, v: Array, t: float) -> Array:
        """Return the generalized forces of springs, dampers, drives and loads, shape (nv,)."""
        engine, loads = self.engine, self.loads
        self._act(q, v, t)
        total: Array = loads.in_joints.copy()
        if loads.act_on_bodies:
            rest = np.zeros(engine.model.nv)
            # inverse dynamics at rest without gravity is minus the external forces' effect
            total -= self._pin.rnea(
                engine.weightless, engine.data, self.chart.p, rest, rest, loads.external.forces
            )
        return self._reduce(total)

    def inverse_dynamics(self, q: Array, v: Array, t: float, a: Array) -> Array:
        """Return M a + bias − forces, shape (nv,)."""
        force: Array = self.mass(q, v, t) @ a + self.bias(q, v, t) - self.forces(q, v, t)
        return force

    def acceleration(self, q: Array, v: Array, t: float) -> Array:
        """Return a, shape (nv,)."""
        if self.recursive:
            result = self._recurse(q, v, t)
            if np.isfinite(result).all():
                return result
        mass = self.mass(q, v, t)
        mode = massless_mode(mass, self._reach())
        if mode is not None:
            refuse_massless(self.mechanism, mode, q if self.massless is None else None)
        return np.asarray(np.linalg.solve(mass, self.forces(q, v, t) - self.bias(q, v, t)))

    def _recurse(self, q: Array, v: Array, t: float) -> Array:
        """Return a by the articulated-body recursion, shape (nv,)."""
        u, chart, loads = self._act(q, v, t), self.chart, self.loads
        full = self._pin.aba(
            self.engine.model, self.engine.data, chart.p, u, loads.in_joints, loads.external.forces
        )
        return np.array(full) if chart.identical else np.linalg.solve(chart.G, full)

    def energy(self, q: Array, v: Array, t: float) -> Array:
        """Return T, V of gravity and V of the springs, shape (3,)."""
        engine, chart = self.engine, self.chart
        values, u = chart.place(q, t), chart.at(q, v, t)
        # this also sets the bodies' poses, which the springs need
        height = self._pin.computePotentialEnergy(engine.model, engine.data, chart.p) + self.resting
        springs = self.loads.energy(values, t)
        # Pinocchio's own kinetic energy omits the armature of bounded hinges and slides
        kinetic = 0.5 * float(u @ self._pin.crba(engine.model, engine.data, chart.p) @ u)
        return np.array([kinetic, height, springs])

    def reactions(self, q: Array, v: Array, t: float) -> Array:
        """Return force and moment of parent on child, joint by joint, shape (n, 2, 3)."""
        loads = self.loads
        a = self.acceleration(q, v, t)
        values, u, rate = self.move(q, v, t, a)
        return self.transmit(loads.update(values, q, u, v, t) + loads.across_joints(), u, rate)

    def applied(self, q: Array, v: Array, t: float) -> Array:
        """Return points, forces and moments of the loads, by their `effects`, shape (k, 3, 3)."""
        values, u, _ = self.move(q, v, t)
        return np.array(self.loads.by_force(values, q, u, v, t)).reshape(-1, 3, 3)

    def transmit(
        self, actions: list[SiteAction], u: Array, rate: Array, *, weightless: bool = False
    ) -> Array:
        """Return the wrenches of the joints under given actions, shape (n, 2, 3)."""
        # The engine's data must contain the state in question
        engine = self.engine
        model = engine.weightless if weightless else engine.model
        self._supported.set(actions)
        self.demand = np.array(
            self._pin.rnea(model, engine.data, self.chart.p, u, rate, self._supported.forces)
        )
        return self._reactions.read(actions)

    def hold(self, q: Array, v: Array, t: float, totals: Array) -> GuideReactions:
        """Return the forces of elements and the remaining reactions of the joints."""
        # The last call of `transmit` must be the one that gave the totals
        # Shapes: q (nq,), v (nv,)
        demand = self.demand
        self.move(q, v, t)
        units = self.elements.units()
        carried, along = self._push(units, pressed=False)
        pressed, _ = self._push(units, pressed=True)
        columns = self.elements.columns(along)
        return hold(columns, demand, units, np.stack([carried, pressed]), totals)

    def _push(self, units: list[Unit], *, pressed: bool) -> tuple[Array, Array]:
        """Return the joints' wrenches under the elements' unit forces, and those along u."""
        rest, count = np.zeros(self.engine.model.nv), len(self.elements.names)
        carried = np.zeros((count, len(self.mechanism.joints), 2, 3))
        along = np.zeros((len(rest), count))
        for k in {unit.force for unit in units if unit.pressed == pressed}:
            pushing = [unit for unit in units if (unit.force, unit.pressed) == (k, pressed)]
            actions = [unit.action for unit in pushing]
            carried[k] = self.transmit(actions, rest, rest, weightless=True)
            along[:, k] = self.demand
        return carried, along

    def _probe_elements(self) -> None:
        """Find the guides that the elements describe, in a generic position."""
        random, v = np.random.default_rng(1784), np.zeros(self.mechanism.nv)
        away = random.uniform(0.2, 1.0, self.mechanism.nq)
        for near in (0.1, 0.03, 0.01, 0.003, 0.0):
            q = self.mechanism.normalize(self.mechanism.neutral() + near * away)
            try:
                self.move(q, v, 0.0)
                self.elements.explain(self._push(self.elements.units(), pressed=False)[1])
            except EngineError:
                if not near:
                    raise
            else:
                return

    def poses(self, q: Array, v: Array, t: float) -> Array:
        """Return the pose of every body, in their order, shape (nb, 4, 4); v does not matter."""
        engine, chart = self.engine, self.chart
        chart.place(q, t)
        self._pin.framesForwardKinematics(engine.model, engine.data, chart.p)
        return np.array([engine.data.oMf[frame].homogeneous for frame in self._body_frames])

    def carry(self, q: Array, v: Array, t: float, a: Array) -> Array:
        """Return turn, place, spatial velocity and acceleration of every joint, shape (nj, 24)."""
        self.move(q, v, t, a)
        parts = [np.array(views).reshape(len(views), -1) for views in self._views]
        return np.concatenate(parts, axis=1)

    def followers(self, q: Array, v: Array, t: float, a: Array) -> Array:
        """Return the driven joint coordinates, their rates and second rates, shape (3, k)."""
        values, u, rate = self.move(q, v, t, a)
        driven = self.mechanism.coordinates.driven
        rows = [self.chart.rows[f"{name}'"] for name in driven]
        return np.array([[values[self.chart.index[name]] for name in driven], u[rows], rate[rows]])

    def jacobian(self, body: str, q: Array, v: Array, t: float) -> Array:
        """Return a body's Jacobian in world axes, shape (6, nv); v does not matter."""
        model, data, p, _ = self._at(q, v, t)
        frame = self.engine.holders[body].frame
        world = self._pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
        # Pinocchio returns a single column as a vector
        columns = self._pin.computeFrameJacobian(model, data, p, frame, world).reshape(6, -1)
        return np.asarray(columns @ self.chart.G)

    def rhs(self, *, overwriting: bool = False) -> Rhs:
        """Return f(t, y) = y' for integration."""
        if self.massless is not None:
            refuse_massless(self.mechanism, self.massless)
        return fast_rhs(
            self.mechanism,
            self.engine,
            self.chart,
            self.loads,
            recursive=self.recursive,
            overwriting=overwriting,
        )

    def _reduce(self, forces: Array) -> Array:
        chart = self.chart
        return np.array(forces) if chart.identical else np.asarray(chart.G.T @ forces)

    def _reach(self) -> Array:
        return np.asarray((self.chart.G**2).T @ reach_of(self.engine.model, self.engine.data))

    def _probe(self) -> bool:
        """Look for motions that move no mass; return whether the recursion may be used."""
        G = self.chart.G
        recursive = self.chart.constant and G.shape[0] == G.shape[1] > 0
        recursive = bool(recursive and np.linalg.cond(G) < ILL_CONDITIONED)
        massless, sound = None, False
        for q, v, t in random_states(self.mechanism):
            try:
                mass = self.mass(q, v, t)
                if not np.isfinite(mass).all():
                    continue
                mode = massless_mode(mass, self._reach())
                if mode is not None:
                    massless = mode
                    continue
                sound = True
                if recursive:
                    right = self.forces(q, v, t) - self.bias(q, v, t)
                    error = backward_error(mass, self._recurse(q, v, t), right)
                    recursive = error < AGREEMENT
            except (ArithmeticError, ValueError, EngineError):
                # a map or a force is not defined in this random state
                continue
        if not sound:
            self.massless = massless
        return recursive and sound
