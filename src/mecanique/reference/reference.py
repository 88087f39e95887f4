"""The reference: a mechanism's equations of motion as Pinocchio sees them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property
from typing import final

import numpy as np

from mecanique.errors import EngineError, InputError
from mecanique.model.mechanism import Mechanism
from mecanique.model.placement import vector
from mecanique.reference.answers import Array, Energy, Momentum, PointMotion, Wrench
from mecanique.reference.chart import Chart
from mecanique.reference.engine import load
from mecanique.reference.loads import Loads
from mecanique.reference.probe import backward_error, massless_mode, random_states, reach_of
from mecanique.reference.reactions import Reactions
from mecanique.reference.rhs import Rhs, fast_rhs
from mecanique.reference.sites import External
from mecanique.reference.states import Given, States, checked

__all__ = ["Reference"]


@final
class Reference:
    """A mechanism inside Pinocchio, by way of its URDF: M(q, t) a + bias(q, v, t) = forces(q, v, t).

    bias holds the inertia forces that do not depend on a (Coriolis, centrifugal, those of a prescribed motion) and
    gravity; forces those of springs, dampers, drives and loads. With a coordinate map r = φ(q, t) the engine's
    equations are drawn back by G = ∂φ/∂q: Gᵀ M_r G a + Gᵀ (M_r γ + b_r) = Gᵀ Q_r (Lagrange; Kane & Levinson, Dynamics,
    1985, sect. 4.1, 6.1).

    Every method takes one state or many: q of shape (nq,) or (n, nq), or values by coordinate name; answers for many
    have a first axis of n. Not safe to share between threads: each has to make its own.

    Args:
        mechanism: what to load.

    Raises:
        EngineError: if it is too large for Pinocchio, has a motion that moves no mass, or is not read as it is written.
    """

    def __init__(self, mechanism: Mechanism) -> None:
        import pinocchio as pin

        self.mechanism = mechanism
        self._pin = pin
        self._engine = load(mechanism)
        self._chart = Chart(mechanism, self._engine)
        self._loads = Loads(mechanism, self._engine, self._chart.index)
        self._reactions = Reactions(mechanism, self._engine)
        holders = self._engine.holders
        self._body_frames = [holders[body.name].frame for body in mechanism.bodies]
        resting = sum((holder.inertia for holder in holders.values() if not holder.joint), pin.Inertia.Zero())
        self._moving_mass = sum(self._engine.model.inertias[k].mass for k in range(1, self._engine.model.njoints))
        self._supported = External(self._engine.model.njoints)
        self._resting = -resting.mass * float(self._engine.model.gravity.linear @ resting.lever)
        self._recursive = self._probe()

    @cached_property
    def version(self) -> str:
        """Version of Pinocchio."""
        return str(self._pin.__version__)

    def mass_matrix(self, q: Given, t: float | Array = 0.0) -> Array:
        """Return the mass matrix M, shape (nv, nv).

        Args:
            q: shape (nq,).
            t: time [s].
        """
        return self._answer(checked(self.mechanism, q, t=t), lambda q, v, a, t: self._mass(q, v, t))

    def bias(self, q: Given, v: Given = None, t: float | Array = 0.0) -> Array:
        """Return the inertia forces that do not depend on accelerations, and gravity, shape (nv,).

        Args:
            q: shape (nq,).
            v: shape (nv,).
            t: time [s].
        """
        return self._answer(checked(self.mechanism, q, v, t=t), lambda q, v, a, t: self._bias(q, v, t))

    def forces(self, q: Given, v: Given = None, t: float | Array = 0.0) -> Array:
        """Return the generalized forces of springs, dampers, drives and loads, shape (nv,).

        Args:
            q: shape (nq,).
            v: shape (nv,).
            t: time [s].
        """
        return self._answer(checked(self.mechanism, q, v, t=t), lambda q, v, a, t: self._forces(q, v, t))

    def acceleration(self, q: Given, v: Given = None, t: float | Array = 0.0) -> Array:
        """Return the accelerations a, shape (nv,).

        Args:
            q: shape (nq,).
            v: shape (nv,).
            t: time [s].

        Raises:
            EngineError: if a motion moves no mass in this state, or the mechanism has loops.
        """
        self._need_tree("accelerations")
        return self._answer(checked(self.mechanism, q, v, t=t), lambda q, v, a, t: self._acceleration(q, v, t))

    def inverse_dynamics(self, q: Given, v: Given, a: Given, t: float | Array = 0.0) -> Array:
        """Return the generalized forces that must be added for accelerations a: M a + bias − forces, shape (nv,).

        Args:
            q: shape (nq,).
            v: shape (nv,).
            a: shape (nv,).
            t: time [s].
        """
        return self._answer(
            checked(self.mechanism, q, v, a, t),
            lambda q, v, a, t: self._mass(q, v, t) @ a + self._bias(q, v, t) - self._forces(q, v, t),
        )

    def gravity(self, q: Given, t: float | Array = 0.0) -> Array:
        """Return the part of the bias that gravity makes, ∂V/∂q of gravity, shape (nv,).

        Args:
            q: shape (nq,).
            t: time [s].
        """

        def one(q: Array, v: Array, a: Array, t: float) -> Array:
            self._chart.place(q, t)
            self._chart.at(q, v, t)
            engine = self._engine
            return self._reduced(self._pin.computeGeneralizedGravity(engine.model, engine.data, self._chart.p))

        return self._answer(checked(self.mechanism, q, t=t), one)

    def energy(self, q: Given, v: Given = None, t: float | Array = 0.0) -> Energy:
        """Return kinetic energy, potential energy of gravity and of springs [J].

        Args:
            q: shape (nq,).
            v: shape (nv,).
            t: time [s].
        """
        parts = self._answer(checked(self.mechanism, q, v, t=t), lambda q, v, a, t: self._energy(q, v, t))
        if parts.ndim == 1:
            kinetic, gravity, springs = parts.tolist()
            return Energy(kinetic, gravity, springs)
        return Energy(*parts.T)

    def momentum(self, q: Given, v: Given = None, t: float | Array = 0.0) -> Momentum:
        """Return the momenta of all bodies, world axes.

        Args:
            q: shape (nq,).
            v: shape (nv,).
            t: time [s].
        """
        parts = self._answer(checked(self.mechanism, q, v, t=t), lambda q, v, a, t: self._momentum(q, v, t))
        return Momentum(*np.moveaxis(parts, -2, 0))

    def center_of_mass(self, q: Given, t: float | Array = 0.0) -> Array:
        """Return the common center of mass of the bodies that the ground does not hold, world axes, shape (3,) [m].

        Args:
            q: shape (nq,).
            t: time [s].

        Raises:
            EngineError: if they have no mass.
        """
        if not self._moving_mass:
            raise EngineError(f"mechanism {self.mechanism.name!r} has no moving mass, so no center of it")
        return self._answer(checked(self.mechanism, q, t=t), lambda q, v, a, t: self._momentum(q, v, t)[3])[..., :3]

    def reactions(self, q: Given, v: Given = None, t: float | Array = 0.0) -> dict[str, Wrench]:
        """Return what each parent does to its child, by joint name: at the child's origin, world axes.

        Springs, dampers, drives and loads count as external forces on the bodies, so a reaction is what the joint
        itself transmits: nothing along or about a free axis. Of a joint that follows the coordinate map, the force
        along its axis is what keeps it on the map. In a joint with an armature, −armature · r'' along or about its
        axis is what turns the rotor.

        Args:
            q: shape (nq,).
            v: shape (nv,).
            t: time [s].

        Raises:
            EngineError: if a motion moves no mass in this state, or the mechanism has loops.
        """
        self._need_tree("reactions")
        names = [joint.name for joint in self.mechanism.joints]
        if not names:
            return {}
        parts = self._answer(checked(self.mechanism, q, v, t=t), lambda q, v, a, t: self._all_reactions(q, v, t))
        return {name: Wrench(parts[..., k, 0, :], parts[..., k, 1, :]) for k, name in enumerate(names)}

    def poses(self, q: Given, t: float | Array = 0.0) -> Array:
        """Return the pose of every body in the world, in the order of the mechanism's bodies, shape (nb, 4, 4).

        Args:
            q: shape (nq,).
            t: time [s].
        """
        return self._answer(checked(self.mechanism, q, t=t), lambda q, v, a, t: self._poses(q, t))

    def point(
        self,
        body: str,
        xyz: Sequence[float] = (0.0, 0.0, 0.0),
        q: Given = None,
        v: Given = None,
        a: Given = None,
        t: float | Array = 0.0,
    ) -> PointMotion:
        """Return how a point of a body moves, world axes.

        Args:
            body: name of the body.
            xyz: shape (3,), the point in the body's frame [m].
            q: shape (nq,).
            v: shape (nv,).
            a: shape (nv,).
            t: time [s].

        Raises:
            UnknownNameError: if there is no such body.
        """
        holder = self._engine.holders[self.mechanism.body(body).name]
        try:
            local: Array = np.array([float(c) for c in vector(xyz, "a point")])
        except TypeError:
            raise InputError(f"expected three numbers for a point, got {xyz!r}") from None
        if not np.isfinite(local).all():
            raise InputError(f"expected a finite point, got {xyz!r}")
        at = holder.placement.act(local)

        def one(q: Array, v: Array, a: Array, t: float) -> Array:
            self._move(q, v, t, a)
            data = self._engine.data
            pose, twist, rate = data.oMi[holder.joint], data.v[holder.joint], data.a[holder.joint]
            velocity = twist.linear + np.cross(twist.angular, at)
            change = rate.linear + np.cross(rate.angular, at) + np.cross(twist.angular, velocity)
            return np.array([pose.act(at), pose.rotation @ velocity, pose.rotation @ change])

        return PointMotion(*np.moveaxis(self._answer(checked(self.mechanism, q, v, a, t), one), -2, 0))

    def rates(self, q: Given, v: Given) -> Array:
        """Return the rates q' of the coordinates, shape (nq,).

        Args:
            q: shape (nq,).
            v: shape (nv,).
        """

        def one(q: Array, v: Array, a: Array, t: float) -> Array:
            out: Array = np.empty(self.mechanism.nq)
            self._chart.rates(q, v, out)
            return out

        return self._answer(checked(self.mechanism, q, v), one)

    def rhs(self) -> Rhs:
        """Return f(t, y) = y' for integration, y = [q, v] of shape (nq + nv,); it checks nothing and is fast.

        Where the motion is not determined it gives numbers that are not finite.

        Raises:
            EngineError: if the mechanism has loops.
        """
        self._need_tree("accelerations")
        return fast_rhs(self.mechanism, self._engine, self._chart, self._loads, recursive=self._recursive)

    def _answer(self, states: States, one: Callable[[Array, Array, Array, float], Array]) -> Array:
        rows = [one(q, v, a, t) for q, v, a, t in zip(states.q, states.v, states.a, states.t.tolist(), strict=True)]
        result: Array = np.array(rows) if states.many else np.asarray(rows[0])
        if not np.isfinite(result).all():
            at = 0 if not states.many else int(np.argmin([np.isfinite(row).all() for row in rows]))
            raise EngineError(
                f"mechanism {self.mechanism.name!r} has no finite answer at q = {states.q[at].tolist()}, "
                f"v = {states.v[at].tolist()}, t = {states.t[at]:g}"
            )
        return result

    def _need_tree(self, what: str) -> None:
        if self.mechanism.loops:
            raise EngineError(
                f"mechanism {self.mechanism.name!r} has loops, and its {what} depend on them; the reference answers "
                "for the tree alone"
            )

    def _move(self, q: Array, v: Array, t: float, a: Array | None = None) -> tuple[list[float], Array, Array]:
        """Put the engine's bodies in a state; return all coordinates, u and u'."""
        engine, chart = self._engine, self._chart
        values = chart.place(q, t)
        u = chart.at(q, v, t)
        if a is None:
            self._pin.forwardKinematics(engine.model, engine.data, chart.p, u)
            return values, u, u
        rate = a if chart.identical else chart.G @ a + chart.gamma
        self._pin.forwardKinematics(engine.model, engine.data, chart.p, u, rate)
        return values, u, rate

    def _reduced(self, forces: Array) -> Array:
        chart = self._chart
        return np.array(forces) if chart.identical else np.asarray(chart.G.T @ forces)

    def _mass(self, q: Array, v: Array, t: float) -> Array:
        engine, chart = self._engine, self._chart
        chart.place(q, t)
        chart.at(q, v, t)
        full: Array = self._pin.crba(engine.model, engine.data, chart.p)
        return np.array(full) if chart.identical else np.asarray(chart.G.T @ full @ chart.G)

    def _bias(self, q: Array, v: Array, t: float) -> Array:
        engine, chart = self._engine, self._chart
        chart.place(q, t)
        u = chart.at(q, v, t)
        return self._reduced(self._pin.rnea(engine.model, engine.data, chart.p, u, chart.gamma))

    def _forces(self, q: Array, v: Array, t: float) -> Array:
        engine, chart, loads = self._engine, self._chart, self._loads
        values, u, _ = self._move(q, v, t)
        loads.check()
        loads.update(values, q, u, v, t)
        total: Array = loads.in_joints.copy()
        if loads.act_on_bodies:
            rest = np.zeros(engine.model.nv)
            # inverse dynamics at rest and without gravity is minus what the external forces do
            total -= self._pin.rnea(engine.weightless, engine.data, chart.p, rest, rest, loads.external.forces)
        return self._reduced(total)

    def _acceleration(self, q: Array, v: Array, t: float) -> Array:
        if self._recursive:
            engine, chart, loads = self._engine, self._chart, self._loads
            values, u, _ = self._move(q, v, t)
            loads.check()
            loads.update(values, q, u, v, t)
            full = self._pin.aba(engine.model, engine.data, chart.p, u, loads.in_joints, loads.external.forces)
            if np.isfinite(full).all():
                return full.copy() if chart.identical else np.linalg.solve(chart.G, full)
        mass = self._mass(q, v, t)
        self._refuse_massless(mass, f" at q = {q.tolist()}")
        right = self._forces(q, v, t) - self._bias(q, v, t)
        return np.asarray(np.linalg.solve(mass, right))

    def _energy(self, q: Array, v: Array, t: float) -> Array:
        engine, chart = self._engine, self._chart
        values, u, _ = self._move(q, v, t)
        springs = self._loads.energy(values)
        height = self._pin.computePotentialEnergy(engine.model, engine.data, chart.p) + self._resting
        # Pinocchio's own kinetic energy leaves the armature of bounded hinges and slides out
        kinetic = 0.5 * float(u @ self._pin.crba(engine.model, engine.data, chart.p) @ u)
        return np.array([kinetic, height, springs])

    def _momentum(self, q: Array, v: Array, t: float) -> Array:
        self._move(q, v, t)
        engine = self._engine
        total, moment, mass = self._pin.Force.Zero(), np.zeros(3), 0.0
        for index in range(1, engine.model.njoints):
            pose, inertia = engine.data.oMi[index], engine.model.inertias[index]
            total += pose.act(inertia * engine.data.v[index])
            moment += inertia.mass * pose.act(inertia.lever)
            mass += inertia.mass
        center = moment / mass if mass else moment
        return np.array([total.linear, total.angular, total.angular - np.cross(center, total.linear), center])

    def _all_reactions(self, q: Array, v: Array, t: float) -> Array:
        engine, chart, loads = self._engine, self._chart, self._loads
        a = self._acceleration(q, v, t)
        values, u, rate = self._move(q, v, t, a)
        actions = loads.update(values, q, u, v, t) + loads.across_joints()
        self._supported.set(actions)
        self._pin.rnea(engine.model, engine.data, chart.p, u, rate, self._supported.forces)
        found = self._reactions.read(actions)
        return np.array([found[joint.name] for joint in self.mechanism.joints])

    def _poses(self, q: Array, t: float) -> Array:
        engine, chart = self._engine, self._chart
        chart.place(q, t)
        self._pin.framesForwardKinematics(engine.model, engine.data, chart.p)
        return np.array([engine.data.oMf[frame].homogeneous for frame in self._body_frames])

    def _probe(self) -> bool:
        """Look for motions that move no mass; return whether the recursive algorithm may be used."""
        engine, chart, loads = self._engine, self._chart, self._loads
        square = chart.constant and chart.G.shape[0] == chart.G.shape[1] and self.mechanism.nv > 0
        recursive = bool(square and np.linalg.cond(chart.G) < 1e6)
        found, sound = None, False
        for q, v, t in random_states(self.mechanism):
            try:
                mass = self._mass(q, v, t)
                if not np.isfinite(mass).all():
                    continue
                mode = massless_mode(mass, (chart.G**2).T @ reach_of(engine.model, engine.data))
                if mode is not None:
                    found = mode
                    continue
                sound = True
                if recursive:
                    right = self._forces(q, v, t) - self._bias(q, v, t)
                    values, u, _ = self._move(q, v, t)
                    loads.update(values, q, u, v, t)
                    full = self._pin.aba(engine.model, engine.data, chart.p, u, loads.in_joints, loads.external.forces)
                    recursive = backward_error(mass, np.linalg.solve(chart.G, full), right) < 1e-10
            except (ArithmeticError, ValueError):
                # a map or a force that is not defined in this random state
                continue
        if found is not None and not sound and not self.mechanism.loops:
            self._refuse(found, "")
        return recursive and sound

    def _refuse_massless(self, mass: Array, where: str) -> None:
        engine, chart = self._engine, self._chart
        mode = massless_mode(mass, (chart.G**2).T @ reach_of(engine.model, engine.data))
        if mode is not None:
            self._refuse(mode, where)

    def _refuse(self, mode: Array, where: str) -> None:
        names = [name for name, part in zip(self.mechanism.velocities, mode, strict=True) if abs(part) > 1e-6]
        joints = [joint for joint in self.mechanism.joints if set(joint.velocities) & set(names)]
        moved = "".join(f", joint {joint.name!r} (body {joint.child!r})" for joint in joints)
        raise EngineError(
            f"mechanism {self.mechanism.name!r}: the motion {', '.join(names)}{moved} moves no mass{where}, so nothing "
            "determines it; give the body mass or inertia, or prescribe the joint by the coordinate map"
        )
