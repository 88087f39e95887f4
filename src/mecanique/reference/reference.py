"""The reference: a mechanism's equations of motion as Pinocchio sees them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property, partial
from typing import final

import numpy as np
import numpy.typing as npt

from mecanique.errors import EngineError, InputError, MecaniqueError
from mecanique.model.joints import Single
from mecanique.model.mechanism import Mechanism
from mecanique.model.states import Given, States
from mecanique.reference.engine.answers import (
    AppliedForce,
    Array,
    Energy,
    Momentum,
    Places,
    PointMotion,
    Twist,
    Wrench,
    local_point,
)
from mecanique.reference.engine.rhs import Rhs
from mecanique.reference.engine.tree import Tree
from mecanique.reference.loops.closed import COMPONENTS, Closed
from mecanique.reference.loops.nullspace import solve

__all__ = ["Reference"]


@final
class Reference:
    """A mechanism inside Pinocchio, by its URDF: M(q, t) a + bias(q, v, t) = forces(q, v, t).

    bias holds the inertia forces that do not depend on a (Coriolis, centrifugal, those of a
    prescribed motion) and gravity; forces those of springs, dampers, drives and loads. With a
    coordinate map r = φ(q, t) the engine's equations are drawn back by G = ∂φ/∂q: Gᵀ M_r G a + Gᵀ
    (M_r γ + b_r) = Gᵀ Q_r (Lagrange; Kane & Levinson, Dynamics, 1985, sect. 4.1, 6.1).

    Every method takes one state or many: q of shape (nq,) or (n, nq), or values by coordinate name;
    answers for many have a first axis of n. Not safe to share between threads: each has to make its
    own.

    Args:
        mechanism: what to load.

    Raises:
        EngineError: if it is too large for Pinocchio, or is not read as it is written.
    """

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism = mechanism
        self._tree = Tree(mechanism)
        self._closed = Closed(self._tree) if mechanism.loops else None

    @cached_property
    def version(self) -> str:
        """Version of Pinocchio."""
        import pinocchio

        return str(pinocchio.__version__)

    @property
    def massless(self) -> dict[str, float] | None:
        """A motion that moves no mass, by velocity name; None if there is none.

        Where there is one, accelerations are not determined.
        """
        mode = self._tree.massless
        if mode is None:
            return None
        return dict(zip(self.mechanism.velocities, mode.tolist(), strict=True))

    def mass_matrix(self, q: Given, t: float | Array = 0.0) -> Array:
        """Return the mass matrix M, shape (nv, nv); of a mechanism with loops, that of its tree.

        `independent_mass_matrix` is that of the motion which the loops leave free.

        Args:
            q: shape (nq,).
            t: time [s].
        """
        return self._answer(States.of(self.mechanism, q, t=t), self._tree.mass)

    def response(self, q: Given, t: float, impulse: Given) -> Array:
        """Return the change of velocities by an impulse while loops stay closed, shape (nv,).

        Args:
            q: shape (nq,).
            t: time [s].
            impulse: shape (nv,).

        Raises:
            ClosureError: if a motion that the loops leave free carries no mass.
        """
        M, push = np.asarray(self.mass_matrix(q, t)), np.asarray(impulse, dtype=float)
        if self._closed is None:
            change: Array = np.linalg.solve(M, push)
            return change
        closures = self._closed.closures
        J = closures.at(np.asarray(q, dtype=float), np.zeros(len(push)), t).jacobian
        metric = self._closed.measure(J)
        return solve(metric, -push, J, np.zeros(len(J)), most=self._closed.most).acceleration

    def bias(self, q: Given, v: Given = None, t: float | Array = 0.0) -> Array:
        """Return the inertia forces that do not depend on accelerations, and gravity, shape (nv,).

        Of a mechanism with loops, those of its tree: the loops' own forces are left out.

        Args:
            q: shape (nq,).
            v: shape (nv,).
            t: time [s].
        """
        return self._answer(States.of(self.mechanism, q, v, t=t), self._tree.bias)

    def forces(self, q: Given, v: Given = None, t: float | Array = 0.0) -> Array:
        """Return the generalized forces of springs, dampers, drives and loads, shape (nv,).

        Args:
            q: shape (nq,).
            v: shape (nv,).
            t: time [s].
        """
        return self._answer(States.of(self.mechanism, q, v, t=t), self._tree.forces)

    def acceleration(
        self, q: Given, v: Given = None, t: float | Array = 0.0, tau: Given = None
    ) -> Array:
        """Return the accelerations a, shape (nv,).

        Args:
            q: shape (nq,).
            v: shape (nv,).
            t: time [s].
            tau: what drives besides the mechanism's own forces [N·m or N]: generalized forces,
                shape (nv,), or values by name of a joint with one coordinate (on the child, and
                the opposite on the parent), of a coordinate or of a velocity.

        Raises:
            EngineError: if a motion moves no mass in this state, or a loop is open.
            ClosureError: if a motion that the loops leave free moves no mass.
            UnknownNameError: if a name in tau is no joint, coordinate or velocity.
        """
        moving: Tree | Closed = self._tree if self._closed is None else self._closed
        return self._answer(States.of(self.mechanism, q, v, t, tau=tau), moving.acceleration)

    def inverse_dynamics(self, q: Given, v: Given, a: Given, t: float | Array = 0.0) -> Array:
        """Return the forces that accelerations a need besides: M a + bias − forces, shape (nv,).

        Args:
            q: shape (nq,).
            v: shape (nv,).
            a: shape (nv,).
            t: time [s].
        """
        return self._answer(
            States.of(self.mechanism, q, v, t, a), self._tree.inverse_dynamics, accelerations=True
        )

    def driving_forces(
        self,
        drives: Sequence[str],
        q: Given,
        v: Given = None,
        a: Given = None,
        t: float | Array = 0.0,
    ) -> dict[str, Array]:
        """Return what drives in chosen joints must do for given accelerations, by joint.

        With v and a left out, the forces and torques that hold the mechanism; loops are taken into
        account. If more joints drive than motions are free, the least forces, by sum of squares.

        Args:
            drives: names of joints with one coordinate.
            q: shape (nq,), the loops closed.
            v: shape (nv,), as the loops allow.
            a: shape (nv,), as the loops allow.
            t: time [s].

        Returns:
            Each shape () or (n,) [N·m or N], on the child, and the opposite on the parent.

        Raises:
            UnknownNameError: if there is no such joint.
            InputError: if a joint has not one coordinate.
            EngineError: if a loop is open.
            ClosureError: if the loops do not allow v or a, or the drives cannot make them.
        """
        joints = [self.mechanism.joint(name) for name in drives]
        for joint in joints:
            if not isinstance(joint, Single):
                raise InputError(
                    f"expected joints with one coordinate to drive, got {joint.name!r}, "
                    f"a {type(joint).__name__}"
                )
        from mecanique.reference.loops.driving import driving_forces

        rates = [joint.velocities[-1] for joint in joints]
        states = States.of(self.mechanism, q, v, t, a)
        one = partial(driving_forces, self._tree, self._closed, rates)
        found = self._answer(states, one, accelerations=True)
        return {name: found[..., k] for k, name in enumerate(drives)}

    @property
    def constraint_names(self) -> tuple[str, ...]:
        """Name of each row of the constraints, "loop: motion it closes"; empty for a tree."""
        return () if self._closed is None else self._closed.closures.names

    def constraint_residual(self, q: Given, t: float | Array = 0.0) -> Array:
        """Return how far the loops are open, Φ, shape (m,) [m or rad], by `constraint_names`.

        Args:
            q: shape (nq,).
            t: time [s].
        """
        return self._constraints(States.of(self.mechanism, q, t=t), "residual")

    def constraint_jacobian(self, q: Given, t: float | Array = 0.0) -> Array:
        """Return the constraints' Jacobian J, shape (m, nv): Φ' = J v, and what time adds.

        Args:
            q: shape (nq,).
            t: time [s].
        """
        return self._constraints(States.of(self.mechanism, q, t=t), "jacobian")

    def constraint_bias(self, q: Given, v: Given = None, t: float | Array = 0.0) -> Array:
        """Return the part of the constraints' second rate without a, γ: J a + γ = 0, shape (m,).

        Args:
            q: shape (nq,).
            v: shape (nv,).
            t: time [s].
        """
        return self._constraints(States.of(self.mechanism, q, v, t), "gamma")

    def independent_mass_matrix(self, q: Given, t: float = 0.0) -> tuple[tuple[str, ...], Array]:
        """Return names of independent velocities, and the mass matrix Tᵀ M T they see, (n, n).

        Args:
            q: shape (nq,), one position, the loops closed.
            t: time [s].

        Raises:
            EngineError: if a loop is open.
        """
        states = States.of(self.mechanism, q, t=t)
        M = self._answer(states, self._tree.mass).reshape(self.mechanism.nv, -1)
        if self._closed is None:
            return self.mechanism.velocities, M
        from mecanique.reference.loops.driving import free_motions

        chosen, T = free_motions(self._closed, states.q[0], float(states.t[0]))
        return tuple(self.mechanism.velocities[k] for k in chosen), T.T @ M @ T

    def _constraints(self, states: States, what: str) -> Array:
        closed = self._closed

        def one(q: Array, v: Array, t: float) -> Array:
            if closed is None:
                return np.zeros((0, self.mechanism.nv) if what == "jacobian" else 0)
            found: Array = getattr(closed.closures.at(q, v, t), what)
            return found

        return self._answer(states, one)

    def gravity(self, q: Given, t: float | Array = 0.0) -> Array:
        """Return the part of the bias that gravity makes, ∂V/∂q of gravity, shape (nv,).

        Args:
            q: shape (nq,).
            t: time [s].
        """
        return self._answer(States.of(self.mechanism, q, t=t), self._tree.gravity)

    def energy(self, q: Given, v: Given = None, t: float | Array = 0.0) -> Energy:
        """Return kinetic energy, potential energy of gravity and of springs [J].

        Args:
            q: shape (nq,).
            v: shape (nv,).
            t: time [s].
        """
        parts = self._answer(States.of(self.mechanism, q, v, t=t), self._tree.energy)
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
        parts = self._answer(States.of(self.mechanism, q, v, t=t), self._tree.momentum)
        return Momentum(*np.moveaxis(parts, -2, 0)[:3])

    @property
    def total_mass(self) -> float:
        """Mass of the bodies that can move, all those that the ground does not hold [kg]."""
        return self._tree.moving_mass

    def center_of_mass(
        self, q: Given, v: Given = None, a: Given = None, t: float | Array = 0.0
    ) -> PointMotion:
        """Return how the center of mass of the bodies that can move does so, world axes.

        Args:
            q: shape (nq,).
            v: shape (nv,).
            a: shape (nv,).
            t: time [s].

        Raises:
            EngineError: if they have no mass.
        """
        if not self._tree.moving_mass:
            raise EngineError(
                f"mechanism {self.mechanism.name!r} has no moving mass, so no center of it"
            )
        states = States.of(self.mechanism, q, v, t, a)
        parts = self._answer(states, self._tree.center, accelerations=True)
        return PointMotion(*np.moveaxis(parts, -2, 0))

    def reactions(
        self, q: Given, v: Given = None, t: float | Array = 0.0, tau: Given = None
    ) -> dict[str, Wrench]:
        """Return what each parent does to its child, by joint: at the child's origin, world axes.

        Springs, dampers, drives and loads count as external forces on the bodies, so a reaction is
        what the joint itself transmits: nothing along or about a free axis. Of a joint that follows
        the coordinate map, the force along its axis is what keeps it on the map. In a joint with an
        armature, −armature · r'' along or about its axis is what turns the rotor.

        After the joints come the loops by their names (after a joint of the same name, with "loop "
        before it): what body a does to body b, at the origin of the loop's frame on body b. What
        redundant constraints leave undetermined is the least that will do, and named in
        `undetermined`.

        Args:
            q: shape (nq,).
            v: shape (nv,).
            t: time [s].
            tau: what drives besides the mechanism's own forces, as in `acceleration`, in joints
                with one coordinate [N·m or N]; like them no part of a reaction.

        Raises:
            EngineError: if a motion moves no mass in this state, or a loop is open.
            ClosureError: if a motion that the loops leave free moves no mass.
            UnknownNameError: if a name in tau is no joint, coordinate or velocity.
            InputError: if tau acts elsewhere than in a joint with one coordinate.
        """
        names = self._carriers
        states = States.of(self.mechanism, q, v, t, tau=tau)
        if states.efforts is not None:
            states.efforts.refuse_without_seat()
        if not names:
            return {}
        if self._closed is not None:
            return self._transmit(states, self._closed)
        parts = self._answer(states, self._tree.reactions)
        return self._wrenches(states, parts)

    def applied(
        self, q: Given, v: Given = None, t: float | Array = 0.0
    ) -> tuple[AppliedForce, ...]:
        """Return what springs, dampers, drives and loads do to the bodies, force by force.

        A force between two bodies comes twice: on body a or the child, then on body b or the
        parent. A spring or damper whose ends meet does nothing.

        Args:
            q: shape (nq,).
            v: shape (nv,).
            t: time [s].
        """
        effects = self._tree.loads.effects
        parts = self._answer(States.of(self.mechanism, q, v, t=t), self._tree.applied)
        return tuple(
            AppliedForce(*effect, *np.moveaxis(parts[..., k, :, :], -2, 0))
            for k, effect in enumerate(effects)
        )

    def undetermined(self, q: Given, t: float = 0.0) -> dict[str, tuple[str, ...]]:
        """Return the components of reactions that redundancy leaves undetermined, by name.

        Joints and loops of which everything is determined are left out.

        Args:
            q: shape (nq,), one position.
            t: time [s].

        Raises:
            EngineError: if a loop is open.
        """
        states = States.of(self.mechanism, q, t=t)
        if self._closed is None:
            return {}
        self._closed.refuse_open(states.q[0], float(states.t[0]))
        flags = self._closed.undetermined(states.q[0], float(states.t[0]))
        return {
            name: _names_of(row)
            for name, row in zip(self._carriers, flags, strict=True)
            if row.any()
        }

    def poses(self, q: Given, t: float | Array = 0.0) -> Array:
        """Return the poses of all bodies in the world, in their order, shape (nb, 4, 4).

        Args:
            q: shape (nq,).
            t: time [s].
        """
        return self._answer(States.of(self.mechanism, q, t=t), self._tree.poses)

    def pose(self, body: str, q: Given, t: float | Array = 0.0) -> Array:
        """Return the pose of one body in the world, shape (4, 4).

        Args:
            body: name of the body.
            q: shape (nq,).
            t: time [s].

        Raises:
            UnknownNameError: if there is no such body.
        """
        place = self.mechanism.bodies.index(self.mechanism.body(body))
        pose: Array = self.poses(q, t)[..., place, :, :]
        return pose

    def velocity(self, body: str, q: Given, v: Given, t: float | Array = 0.0) -> Twist:
        """Return the velocity of a body's origin and its angular velocity, world axes.

        Args:
            body: name of the body.
            q: shape (nq,).
            v: shape (nv,).
            t: time [s].

        Raises:
            UnknownNameError: if there is no such body.
        """
        name = self.mechanism.body(body).name
        states = States.of(self.mechanism, q, v, t)
        return Twist(*np.moveaxis(self._answer(states, partial(self._tree.twist, name)), -2, 0))

    def followers(
        self, q: Given, v: Given = None, a: Given = None, t: float | Array = 0.0
    ) -> dict[str, Array]:
        """Return the joint coordinates that follow the coordinate map, mimic joints included.

        Args:
            q: shape (nq,).
            v: shape (nv,).
            a: shape (nv,).
            t: time [s].

        Returns:
            By name r, its rate by r', its second rate by r''; each shape () or (n,).
        """
        driven = self.mechanism.coordinates.driven
        states = States.of(self.mechanism, q, v, t, a)
        parts = self._answer(states, self._tree.followers, accelerations=True)
        return {
            f"{name}{marks}": parts[..., order, k]
            for order, marks in enumerate(("", "'", "''"))
            for k, name in enumerate(driven)
        }

    def point(
        self,
        body: str,
        xyz: Sequence[float] | Array = (0.0, 0.0, 0.0),
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
        name = self.mechanism.body(body).name
        local = local_point(xyz)
        parts = self._answer(
            States.of(self.mechanism, q, v, t, a),
            partial(self._tree.point, name, local),
            accelerations=True,
        )
        return PointMotion(*np.moveaxis(parts, -2, 0))

    def jacobian(self, body: str, q: Given, t: float | Array = 0.0) -> Array:
        """Return how each v moves a body: velocity of its origin, angular velocity, world axes.

        Args:
            body: name of the body.
            q: shape (nq,).
            t: time [s].

        Returns:
            Shape (6, nv): what v adds; of a prescribed motion, the part that time makes is left
            out.

        Raises:
            UnknownNameError: if there is no such body.
        """
        name = self.mechanism.body(body).name
        one = partial(self._tree.jacobian, name)
        return self._answer(States.of(self.mechanism, q, t=t), one)

    def rates(self, q: Given, v: Given) -> Array:
        """Return the rates q' of the coordinates, shape (nq,).

        Args:
            q: shape (nq,).
            v: shape (nv,).
        """

        def one(q: Array, v: Array, t: float) -> Array:
            out: Array = np.empty(self.mechanism.nq)
            self._tree.chart.rates(q, v, out)
            return out

        return self._answer(States.of(self.mechanism, q, v), one)

    def rhs(self, *, overwriting: bool = False) -> Rhs:
        """Return f(t, y) = y' for integration, y = [q, v] of shape (nq + nv,), fast and unchecked.

        Where the motion is not determined it gives numbers that are not finite, or raises what
        Python's own arithmetic raises (`ArithmeticError`, `ValueError`) where a map or a force is
        not defined.

        Loops must be closed; how far a state has left them is not looked at.

        Args:
            overwriting: whether an answer may be overwritten by the next, which is faster for many
                trees.

        Raises:
            EngineError: if a motion of a tree moves no mass.
        """
        if self._closed is None:
            return self._tree.rhs(overwriting=overwriting)
        from mecanique.reference.loops.singular import closed_rhs

        return closed_rhs(self._closed)

    def drift(self, q: Given, v: Given = None, t: float | Array = 0.0) -> Array:
        """Return how far positions and velocities are off the loops, shape (2,); zero for a tree.

        Args:
            q: shape (nq,).
            v: shape (nv,).
            t: time [s].

        Returns:
            The largest gap in characteristic lengths or radians, and the largest rate of a gap in
            the same per second.
        """
        states = States.of(self.mechanism, q, v, t)
        if self._closed is None:
            return np.zeros(2) if states.single else np.zeros((len(states), 2))
        return self._answer(states, self._closed.drift)

    @property
    def closed(self) -> Closed | None:
        """The loops and the motion they leave free; None for a tree."""
        return self._closed

    @cached_property
    def _carriers(self) -> list[str]:
        joints = [joint.name for joint in self.mechanism.joints]
        return joints + [
            f"loop {loop.name}" if loop.name in joints else loop.name
            for loop in self.mechanism.loops
        ]

    def _transmit(self, states: States, closed: Closed) -> dict[str, Wrench]:
        flags = np.zeros((len(self._carriers), 6), dtype=bool)

        def one(q: Array, v: Array, t: float) -> Array:
            found = closed.reactions(q, v, t)
            np.logical_or(flags, found.undetermined, out=flags)
            return found.wrenches

        parts = self._answer(states, one)
        return self._wrenches(states, parts, flags)

    def _wrenches(
        self, states: States, parts: Array, flags: npt.NDArray[np.bool_] | None = None
    ) -> dict[str, Wrench]:
        """Name what joints and loops transmit, shape (…, n, 2, 3), and say where it acts."""
        places = Places(partial(self._poses_by_name, states))
        found = {}
        for k, (name, (parent, child, point)) in enumerate(
            zip(self._carriers, self._seats, strict=True)
        ):
            found[name] = Wrench(
                parts[..., k, 0, :],
                parts[..., k, 1, :],
                () if flags is None else _names_of(flags[k]),
                parent=parent,
                child=child,
                point=point,
                body=child,
                places=places,
            )
        return found

    def _poses_by_name(self, states: States) -> dict[str, Array]:
        poses = np.moveaxis(self._answer(states, self._tree.poses), -3, 0)
        names = (body.name for body in self.mechanism.bodies)
        return dict(zip(names, poses, strict=True))

    @cached_property
    def _seats(self) -> list[tuple[str, str, tuple[float, float, float]]]:
        """Which body acts on which, and at which point of the latter: of each joint and loop."""
        m = self.mechanism
        seats = [(joint.parent, joint.child, (0.0, 0.0, 0.0)) for joint in m.joints]
        for loop in m.loops:
            x, y, z = (m.evaluate(c) for c in loop.frame_b.xyz)
            seats.append((loop.body_a, loop.body_b, (x, y, z)))
        return seats

    def _answer(
        self, states: States, one: Callable[..., Array], *, accelerations: bool = False
    ) -> Array:
        """Return what one(q, v, t), or one(q, v, t, a), answers in each state; all of it finite."""
        rows = []
        each = zip(states.q, states.v, states.a, states.t.tolist(), strict=True)
        try:
            for k, (q, v, a, t) in enumerate(each):
                reason = ""
                try:
                    if states.efforts is not None:
                        self._tree.drive(states.efforts, k, q, v, t)
                    row = np.asarray(one(q, v, t, a) if accelerations else one(q, v, t))
                except MecaniqueError:
                    raise
                except (ArithmeticError, ValueError) as error:
                    # a map or a force that is not defined here, e.g. the root of a negative number
                    row, reason = np.array(np.nan), f" ({error})"
                if not np.isfinite(row).all():
                    raise EngineError(
                        f"mechanism {self.mechanism.name!r} has no finite answer at "
                        f"q = {q.tolist()}, v = {v.tolist()}, t = {t:g}{reason}"
                    )
                rows.append(row)
        finally:
            if states.efforts is not None:
                self._tree.loads.drive(0.0)
        return rows[0] if states.single else np.array(rows)


def _names_of(flags: npt.NDArray[np.bool_]) -> tuple[str, ...]:
    return tuple(name for name, loose in zip(COMPONENTS, flags, strict=True) if loose)
