"""The reference: a mechanism's equations of motion as Pinocchio sees them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import cached_property, partial
from typing import Any, NamedTuple, final

import numpy as np
import numpy.typing as npt

from mecanique.arrays import Array, cross
from mecanique.errors import EngineError, InputError, MecaniqueError
from mecanique.model.dynamics import Dynamics, Quantity
from mecanique.model.expression import finite
from mecanique.model.joint_base import Single
from mecanique.model.mechanism import Mechanism
from mecanique.model.states import States, expect_mechanism, explain_defaults
from mecanique.model.values import Given, names_of, numbers_of
from mecanique.reference.engine.answers import (
    AppliedForce,
    BodyMotions,
    BodyPoses,
    Energy,
    Momentum,
    PointMotion,
    Resultant,
    Twist,
    Wrench,
    local_point,
    name_components,
)
from mecanique.reference.engine.forces.elements import Guided, GuideReactions
from mecanique.reference.engine.package import engine_package
from mecanique.reference.engine.rhs import Rhs
from mecanique.reference.engine.tree import EngineTree
from mecanique.reference.loops.closed import (
    Closed,
    Loaded,
    TransmittedWrenches,
    load_once,
)
from mecanique.reference.loops.closures import Ends, ends_of
from mecanique.reference.loops.freedom import generic_rank
from mecanique.reference.loops.independent import driving_forces, free_motions
from mecanique.reference.loops.nullspace import solve
from mecanique.reference.loops.singular import ClosedRhs, branch_acceleration, plain_rhs
from mecanique.reference.vectors import rotate

# How bodies move in one state or many, and sums over them: momenta and resultants.


class MovingFrame(NamedTuple):
    """How the frame of a joint moves, world axes, in one state or in n."""

    turn: Array  # shape (3, 3) or (n, 3, 3)
    place: Array  # shape (3,) or (n, 3), as the rest
    velocity: Array  # of its origin
    change: Array  # acceleration of its origin
    spin: Array  # angular velocity
    spin_up: Array  # angular acceleration

    def velocity_of(self, point: Array) -> Array:
        """Return the velocity of a point of the frame."""
        return self.velocity + cross(self.spin, self.turn @ point)

    def motion_of(self, point: Array) -> PointMotion:
        """Return position, velocity and acceleration of a point of the frame."""
        arm = self.turn @ point
        swing = cross(self.spin, arm)
        change = self.change + cross(self.spin_up, arm) + cross(self.spin, swing)
        return PointMotion(self.place + arm, self.velocity + swing, change)


def read_frames(rows: Array) -> list[MovingFrame]:
    """Return the frames of all joints by what `EngineTree.carry` answers, shape (…, nj, 24)."""
    turns, place, velocity, omega, change, alpha = np.split(rows, (9, 12, 15, 18, 21), axis=-1)
    turns = turns.reshape(*turns.shape[:-1], 3, 3)
    # from the spatial to the classical acceleration
    vectors = (velocity, change + np.cross(omega, velocity), omega, alpha)
    parts = np.stack([place, *np.moveaxis(turns @ np.stack(vectors, axis=-1), -1, 0)])
    return [MovingFrame(turns[..., k, :, :], *parts[..., k, :]) for k in range(rows.shape[-2])]


def motions(tree: EngineTree, frames: list[MovingFrame]) -> BodyMotions:
    """Return the motions of the mechanism's bodies."""
    holders = [tree.engine.holders[body.name] for body in tree.mechanism.bodies]
    shape = (*frames[0].place.shape[:-1], len(holders))
    poses, vectors = np.zeros((*shape, 4, 4)), np.empty((4, *shape, 3))
    poses[..., 3, 3] = 1.0
    for k, holder in enumerate(holders):
        frame = frames[holder.joint]
        place, velocity, change = frame.motion_of(holder.placement.translation)
        poses[..., k, :3, :3], poses[..., k, :3, 3] = frame.turn @ holder.placement.rotation, place
        vectors[..., k, :] = velocity, frame.spin, change, frame.spin_up
    return BodyMotions(poses, *vectors)


def momenta(tree: EngineTree, frames: list[MovingFrame]) -> Momentum:
    """Return p = Σ m v_c and L = Σ (c × m v_c + I ω), about the origin and the common center."""
    linear, angular, first = (np.zeros_like(frames[0].place) for _ in range(3))
    for inertia, frame in massive(tree, frames):
        center = frame.place + frame.turn @ inertia.lever
        push = inertia.mass * frame.velocity_of(inertia.lever)
        spin = rotate(frame.turn.swapaxes(-1, -2), frame.spin)
        linear += push
        angular += cross(center, push) + rotate(frame.turn, spin @ inertia.inertia)
        first += inertia.mass * center
    return Momentum(linear, angular, angular - cross(first / (tree.moving_mass or 1.0), linear))


def resultants(tree: EngineTree, frames: list[MovingFrame]) -> Resultant:
    """Return what changes the momenta, F = Σ m a_c and M = Σ (c × m a_c + I α + ω × I ω)."""
    force, moment, first = (np.zeros_like(frames[0].place) for _ in range(3))
    for inertia, frame in massive(tree, frames):
        center, _, change = frame.motion_of(inertia.lever)
        push = inertia.mass * change
        back = frame.turn.swapaxes(-1, -2)
        spin, spin_up = rotate(back, frame.spin), rotate(back, frame.spin_up)
        about_center = spin_up @ inertia.inertia + cross(spin, spin @ inertia.inertia)
        force += push
        moment += cross(center, push) + rotate(frame.turn, about_center)
        first += inertia.mass * center
    return Resultant(force, moment, first / (tree.moving_mass or 1.0))


def massive(tree: EngineTree, frames: list[MovingFrame]) -> Iterator[tuple[Any, MovingFrame]]:
    """The inertias that move, each with its frame."""
    for inertia, frame in zip(list(tree.engine.model.inertias)[1:], frames[1:], strict=True):
        if inertia.mass or inertia.inertia.any():
            yield inertia, frame


class _HeldStates(NamedTuple):
    """The elements' forces in some states, the remaining reactions, and the actions on bodies."""

    forces: Array
    wrenches: dict[str, Wrench]
    actions: Array


@final
class Reference(Dynamics):
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

    Example:
        >>> reference = mq.Reference(mq.textbook.load("double_pendulum"))
        >>> reference.mass_matrix({"q1": 0.0, "q2": 0.0}).round(3)
        array([[1.333, 0.5  ],
               [0.5  , 0.333]])
        >>> reference.acceleration({"q1": 0.1, "q2": 0.2}).round(3)
        array([-0.025, -2.886])
    """

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism = expect_mechanism(mechanism)
        self._tree = EngineTree(mechanism)
        self._closed = Closed(self._tree) if mechanism.constrained else None

    @classmethod
    def _over(cls, loaded: Loaded) -> Reference:
        """Make an instance for a mechanism that Pinocchio has loaded already."""
        reference = cls.__new__(cls)
        reference.mechanism = loaded.tree.mechanism
        reference._tree, reference._closed = loaded
        return reference

    def __reduce__(self) -> tuple[Callable[..., Reference], tuple[object, ...]]:
        """Pickle the mechanism, which another process loads into its own Pinocchio."""
        rank = None if self._closed is None else self._closed.most
        return _load, (self.mechanism, rank)

    _generic: int | None = None
    """The generic rank of the constraints, once they are known not to lock the mechanism."""

    def _look_for_locks(self, function: Callable[..., Array]) -> Callable[..., Array]:
        """Wrap a function of the state to refuse a mechanism locked in a singular position."""
        # One check suffices: a locked mechanism cannot reach any other position
        closed = self._closed
        if closed is None or closed.most is not None or self._generic is not None:
            return function

        def answer(q: Array, v: Array, t: float) -> Array:
            if self._generic is None:
                closed.refuse_open(q, t)
                self._generic = generic_rank(closed, q, t)
            return function(q, v, t)

        return answer

    def _answer(
        self, states: States, function: Callable[..., Array], *, accelerations: bool = False
    ) -> Array:
        """Evaluate function(q, v, t), or (q, v, t, a), in each state; values must be finite."""
        if self._tree.loads.waiting:
            raise InputError(
                f"a function of time in mechanism {self.mechanism.name!r} calls the Reference that "
                "is waiting for its value; let it use one of its own: Reference(mechanism)"
            )
        rows: list[Array] = []
        rows_in = zip(states.q, states.v, states.a, states.t.tolist(), strict=True)
        try:
            with np.errstate(all="ignore"):  # what is not finite is refused below
                for k, (q, v, a, t) in enumerate(rows_in):
                    if states.efforts is not None:
                        self._tree.drive(states.efforts, k, q, v, t)
                    rows.append(
                        np.asarray(function(q, v, t, a) if accelerations else function(q, v, t))
                    )
        except MecaniqueError:
            raise
        except (ArithmeticError, ValueError) as error:
            # a map or a force that is not defined here, e.g. the root of a negative number
            raise self._no_answer(states, len(rows), f" ({error})") from error
        finally:
            if states.efforts is not None:
                self._tree.loads.drive(0.0)
        answers = np.array(rows)
        known = np.isfinite(answers).reshape(len(answers), -1).all(axis=1)
        if not known.all():
            raise self._no_answer(states, int(np.argmin(known)))
        return rows[0] if states.single else answers

    def _no_answer(self, states: States, k: int, reason: str = "") -> EngineError:
        q, v, t = states.q[k].tolist(), states.v[k].tolist(), float(states.t[k])
        return EngineError(
            f"mechanism {self.mechanism.name!r} has no finite answer at q = {q}, v = {v}, "
            f"t = {t:g}{reason}{explain_defaults(self.mechanism, states.asked)}"
        )

    @classmethod
    def of(cls, mechanism: Mechanism, rank: int | None = None) -> Reference:
        """Return a reference that was loaded once for a mechanism, in this thread.

        All who ask for it share Pinocchio's work space, so that it must stay in this thread; its
        answers do not depend on what was asked before.

        Args:
            mechanism: what to load; it is not kept alive.
            rank: how many of the loops' constraints are independent, if that is known.

        Raises:
            EngineError: if it is too large for Pinocchio, or is not read as it is written.
        """
        tree, closed = load_once(expect_mechanism(mechanism))
        return cls._over(Loaded(tree, None if closed is None else closed.with_rank(rank)))

    def __repr__(self) -> str:
        return f"<Reference of {self.mechanism.name!r}>"

    @cached_property
    def version(self) -> str:
        """Version of Pinocchio."""
        return str(engine_package().__version__)

    @property
    def massless(self) -> dict[str, float] | None:
        """A motion that moves no mass, by velocity name; None if there is none.

        Where there is one, accelerations are not determined.
        """
        mode = self._tree.massless
        if mode is None:
            return None
        return dict(zip(self.mechanism.velocities, mode.tolist(), strict=True))

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

    def quick_energies(self, q: Array, v: Array, t: Array) -> Energy:
        """Return the energies in many states at once, unchecked.

        Args:
            q: shape (n, nq).
            v: shape (n, nv).
            t: shape (n,) [s].
        """
        states = States(self.mechanism, q, v, t, np.zeros_like(v))
        return Energy(*self._answer(states, self._tree.energy).T)

    def momentum(self, q: Given, v: Given = None, t: float | Array = 0.0) -> Momentum:
        """Return the momenta of all bodies, world axes.

        Args:
            q: shape (nq,).
            v: shape (nv,).
            t: time [s].
        """
        return momenta(self._tree, self._frames(States.of(self.mechanism, q, v, t)))

    def quick_momenta(self, q: Array, v: Array, t: Array) -> Momentum:
        """Return the momenta in many states at once, unchecked.

        Args:
            q: shape (n, nq).
            v: shape (n, nv).
            t: shape (n,) [s].
        """
        states = States(self.mechanism, q, v, t, np.zeros_like(v))
        return momenta(self._tree, self._frames(states))

    def resultant(
        self, q: Given, v: Given = None, t: float | Array = 0.0, a: Given = None
    ) -> Resultant:
        """Return the resultant of all that acts on the moving bodies from outside, world axes.

        These are their weights, the loads, and what the ground transmits: by joints, loops,
        contacts, springs and dampers. It is the rate of change of the momenta (Newton, Euler).

        Args:
            q: shape (nq,).
            v: shape (nv,).
            t: time [s].
            a: shape (nv,), the accelerations where they are known.

        Raises:
            EngineError: if a motion moves no mass in this state, or a loop is open.
        """
        states = States.of(self.mechanism, q, v, t, a)
        if a is None:
            states = replace(states, a=self.quick_accelerations(states))
        return resultants(self._tree, self._frames(states))

    def quick_accelerations(self, states: States) -> Array:
        """Return the accelerations at states of one motion, shape (n, nv), without many checks.

        Raises:
            EngineError: if a motion moves no mass in a state, or a loop is open.
        """
        rhs, nq = self.rhs(overwriting=True), self.mechanism.nq

        def function(q: Array, v: Array, t: float) -> Array:
            a = rhs(t, np.concatenate([q, v]))[nq:]
            return a.copy() if np.isfinite(a).all() else self._accelerate(q, v, t)

        return self._answer(states, function).reshape(len(states.q), self.mechanism.nv)

    def _compute(self, quantity: Quantity, states: States) -> Array:
        tree = self._tree
        ask: dict[Quantity, Callable[..., Array]] = {
            "mass_matrix": tree.mass,
            "bias": tree.bias,
            "forces": tree.forces,
            "gravity": tree.gravity,
            "acceleration": self._look_for_locks(self._accelerate),
            "inverse_dynamics": tree.inverse_dynamics,
        }
        return self._answer(states, ask[quantity], accelerations=quantity == "inverse_dynamics")

    def _accelerate(self, q: Array, v: Array, t: float) -> Array:
        if self._closed is None:
            return self._tree.acceleration(q, v, t)
        most = self._closed.most if self._generic is None else self._generic
        return branch_acceleration(self._closed.with_rank(most), q, v, t)

    def rhs(self, *, overwriting: bool = False) -> Rhs:
        """Return f(t, y) = y' for integration, y = [q, v] of shape (nq + nv,), fast and unchecked.

        Where the motion is not determined it gives numbers that are not finite, or raises what
        Python's own arithmetic raises (`ArithmeticError`, `ValueError`) where a map or a force is
        not defined.

        Loops must be closed; how far a state has left them is not looked at. In the first state f
        raises what `acceleration` does, as in a singular position at rest; later ones are taken for
        those of a motion from there. After `with_rank_at` no state is looked at.

        Args:
            overwriting: whether an answer may be overwritten by the next, which is faster for many
                trees.

        Raises:
            EngineError: if a motion of a tree moves no mass.
        """
        if self._closed is None:
            return self._tree.rhs(overwriting=overwriting)
        if not self.mechanism.loops:  # what rolls has no branches to cross
            return plain_rhs(self._closed)
        if self._closed.most is not None:
            return ClosedRhs(self._closed)
        return self._count_first(self._closed)

    def _count_first(self, closed: Closed) -> Rhs:
        """Return the right-hand side of loops that counts their constraints in its first state."""
        nq, counted = self.mechanism.nq, list[Rhs]()

        def rhs(t: float, y: Array) -> Array:
            if not counted:
                self._look_for_locks(self._accelerate)(y[:nq], y[nq:], t)
                counted.append(ClosedRhs(closed.with_rank(self._generic)))
            return counted[0](t, y)

        return rhs

    # how bodies and points move

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
        holder = self._tree.engine.holders[self.mechanism.body(body).name]
        frame = self._frames(States.of(self.mechanism, q, v, t))[holder.joint]
        return Twist(frame.velocity_of(holder.placement.translation), frame.spin)

    def motions(
        self, q: Given, v: Given = None, a: Given = None, t: float | Array = 0.0
    ) -> BodyMotions:
        """Return the motions of all bodies, world axes, in one pass over the bodies.

        Args:
            q: shape (nq,).
            v: shape (nv,).
            a: shape (nv,).
            t: time [s].
        """
        return motions(self._tree, self._frames(States.of(self.mechanism, q, v, t, a)))

    def _frames(self, states: States) -> list[MovingFrame]:
        """Return the frames of the joints, as the engine answers them."""
        return read_frames(self._answer(states, self._tree.carry, accelerations=True))

    def center_speeds(self, q: Given, v: Given = None, t: float | Array = 0.0) -> Array:
        """Return the speeds of all bodies' centers of mass, in their order, shape (nb,) [m/s].

        Args:
            q: shape (nq,).
            v: shape (nv,).
            t: time [s].
        """
        frames = self._frames(States.of(self.mechanism, q, v, t))
        holders = [self._tree.engine.holders[body.name] for body in self.mechanism.bodies]
        centers = [frames[h.joint].velocity_of(h.inertia.lever) for h in holders]
        speeds: Array = np.linalg.norm(np.stack(centers, axis=-2), axis=-1)
        return speeds

    def point(
        self,
        body: str,
        xyz: Sequence[float] | Array = (0.0, 0.0, 0.0),
        q: Given = None,
        v: Given = None,
        a: Given = None,
        t: float | Array = 0.0,
    ) -> PointMotion:
        """Return position, velocity and acceleration of a body's point, world axes.

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
        holder = self._tree.engine.holders[self.mechanism.body(body).name]
        frames = self._frames(States.of(self.mechanism, q, v, t, a))
        return frames[holder.joint].motion_of(holder.placement.act(local_point(xyz)))

    def jacobian(self, body: str, q: Given, t: float | Array = 0.0) -> Array:
        """Return a body's Jacobian: velocity of its origin and angular velocity, world axes.

        Args:
            body: name of the body.
            q: shape (nq,).
            t: time [s].

        Returns:
            Shape (6, nv), the derivatives by v; a prescribed motion adds a velocity of its own.

        Raises:
            UnknownNameError: if there is no such body.
        """
        name = self.mechanism.body(body).name
        function = partial(self._tree.jacobian, name)
        return self._answer(States.of(self.mechanism, q, t=t), function)

    def followers(
        self, q: Given, v: Given = None, a: Given = None, t: float | Array = 0.0
    ) -> dict[str, Array]:
        """Return the joint coordinates that the coordinate map drives, including mimic joints.

        Args:
            q: shape (nq,).
            v: shape (nv,).
            a: shape (nv,).
            t: time [s].

        Returns:
            Each coordinate by its name r, its rate by r', its second derivative by r''; each shape
            () or (n,).
        """
        driven = self.mechanism.coordinates.driven
        states = States.of(self.mechanism, q, v, t, a)
        parts = self._answer(states, self._tree.followers, accelerations=True)
        return {
            f"{name}{marks}": parts[..., order, k]
            for order, marks in enumerate(("", "'", "''"))
            for k, name in enumerate(driven)
        }

    def rates(self, q: Given, v: Given) -> Array:
        """Return the rates q' of the coordinates, shape (nq,).

        Args:
            q: shape (nq,).
            v: shape (nv,).
        """

        def function(q: Array, v: Array, t: float) -> Array:
            out: Array = np.empty(self.mechanism.nq)
            self._tree.chart.rates(q, v, out)
            return out

        return self._answer(States.of(self.mechanism, q, v), function)

    @property
    def total_mass(self) -> float:
        """The mass of the bodies that can move, those not welded to the ground [kg]."""
        return self._tree.moving_mass

    def center_of_mass(
        self, q: Given, v: Given = None, a: Given = None, t: float | Array = 0.0
    ) -> PointMotion:
        """Return position, velocity and acceleration of the moving bodies' center of mass.

        Components are in world axes.

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
                f"mechanism {self.mechanism.name!r} has no moving mass, so no center of mass"
            )
        frames = self._frames(States.of(self.mechanism, q, v, t, a))
        centers = [
            np.array(frame.motion_of(inertia.lever)) * (inertia.mass / self.total_mass)
            for inertia, frame in massive(self._tree, frames)
        ]
        return PointMotion(*np.sum(centers, axis=0))

    # constraints, and the motions they allow: Φ(q, t) = 0, J v + ∂Φ/∂t = 0, J a + γ = 0

    @property
    def closed(self) -> Closed | None:
        """The loops and the motions they allow; None for a tree."""
        return self._closed

    def with_rank_at(self, q: Given, t: float = 0.0) -> Reference:
        """Return a reference with the rank of the constraints fixed to its generic value near q.

        Slightly off the loops, where integration leads, redundant constraints seem independent;
        with a fixed rank the results there remain those of the mechanism.

        Args:
            q: shape (nq,), one position with closed loops.
            t: time [s].

        Raises:
            InputError: if the loops lock the mechanism there in a singular position.
        """
        if self._closed is None:
            return self
        rank = generic_rank(self._closed, self.mechanism.position(q), finite(t, "time t"))
        return self._over(Loaded(self._tree, self._closed.with_rank(rank)))

    @property
    def constraint_names(self) -> tuple[str, ...]:
        """The name of each row of the constraints, e.g. "loop: motion it closes"; empty for a tree.

        A contact's row is named "contact: motion it prevents", a velocity constraint's as itself.
        """
        return () if self._closed is None else self._closed.closures.names

    def multipliers(
        self, q: Given, v: Given = None, t: float | Array = 0.0, tau: Given = None
    ) -> dict[str, Array]:
        """Return Lagrange's multipliers λ by row of the constraints, each shape () or (n,).

        They satisfy M a + bias − forces = Jᵀ λ. Those of a contact are the components of its force
        on the body that rolls or has the blade [N], e.g. "wheel: normal"; those of a loop are the
        components of the force [N] or moment [N·m] of body a on body b, in the axes of frame a.

        Args:
            q: shape (nq,), with closed loops.
            v: shape (nv,), allowed by the constraints.
            t: time [s].
            tau: additional driving forces, as in `acceleration`.

        Raises:
            EngineError: if a loop is open.
            ClosureError: if a motion that the constraints allow moves no mass.
        """
        states = States.of(self.mechanism, q, v, t, tau=tau)
        if self._closed is None:
            return {}
        values = self._answer(states, self._look_for_locks(self._closed.multipliers))
        return dict(zip(self.constraint_names, np.moveaxis(values, -1, 0), strict=True))

    def constraint_residual(self, q: Given, t: float | Array = 0.0) -> Array:
        """Return the gaps Φ of the loops, by `constraint_names`, shape (m,) [m or rad].

        Args:
            q: shape (nq,).
            t: time [s].
        """
        return self._constraints(States.of(self.mechanism, q, t=t), "residual")

    def constraint_jacobian(self, q: Given, t: float | Array = 0.0) -> Array:
        """Return the constraint Jacobian J, shape (m, nv), with Φ' = J v + ∂Φ/∂t.

        Args:
            q: shape (nq,).
            t: time [s].
        """
        return self._constraints(States.of(self.mechanism, q, t=t), "jacobian")

    def constraint_bias(self, q: Given, v: Given = None, t: float | Array = 0.0) -> Array:
        """Return γ of the acceleration constraint J a + γ = 0, shape (m,).

        Args:
            q: shape (nq,).
            v: shape (nv,).
            t: time [s].
        """
        return self._constraints(States.of(self.mechanism, q, v, t), "gamma")

    def _constraints(self, states: States, what: str) -> Array:
        closed = self._closed

        def function(q: Array, v: Array, t: float) -> Array:
            if closed is None:
                return np.zeros((0, self.mechanism.nv) if what == "jacobian" else 0)
            values: Array = getattr(closed.closures.at(q, v, t), what)
            return values

        return self._answer(states, function)

    def drift(self, q: Given, v: Given = None, t: float | Array = 0.0) -> Array:
        """Return the violation of constraints by q and by v, shape (2,); zero for a tree.

        Args:
            q: shape (nq,).
            v: shape (nv,).
            t: time [s].

        Returns:
            The largest gap in characteristic lengths or radians, and the largest rate of a gap, in
            these units per second.
        """
        states = States.of(self.mechanism, q, v, t)
        if self._closed is None:
            return np.zeros(2) if states.single else np.zeros((len(states), 2))
        return self._answer(states, self._closed.drift)

    def independent_mass_matrix(self, q: Given, t: float = 0.0) -> tuple[tuple[str, ...], Array]:
        """Return names of independent velocities, and the mass matrix Tᵀ M T in them, (n, n).

        Args:
            q: shape (nq,), one position with closed loops.
            t: time [s].

        Raises:
            EngineError: if a loop is open.
        """
        states = States.of(self.mechanism, self.mechanism.position(q), t=finite(t, "time t"))
        M = self._answer(states, self._tree.mass).reshape(self.mechanism.nv, -1)
        if self._closed is None:
            return self.mechanism.velocities, M
        chosen, T = free_motions(self._closed, states.q[0], float(states.t[0]))
        return tuple(self.mechanism.velocities[k] for k in chosen), T.T @ M @ T

    def driving_forces(
        self,
        drives: str | Sequence[str],
        q: Given,
        v: Given = None,
        a: Given = None,
        t: float | Array = 0.0,
    ) -> dict[str, Array]:
        """Return the driving forces in chosen joints for given accelerations, by joint.

        Without v and a they hold the mechanism at rest; loops are taken into account. If there are
        more drives than degrees of freedom, the forces with the least sum of squares are returned.

        Args:
            drives: names of joints with one coordinate, or of their coordinates.
            q: shape (nq,), with closed loops.
            v: shape (nv,), allowed by the loops.
            a: shape (nv,), allowed by the loops.
            t: time [s].

        Returns:
            Each shape () or (n,) [N·m or N], on the child, with the opposite on the parent.

        Raises:
            UnknownNameError: if there is no such joint.
            InputError: if a joint does not have exactly one coordinate.
            EngineError: if a loop is open.
            ClosureError: if the loops do not allow v or a, or the drives cannot produce them.
        """
        drives = names_of(drives, "drives")
        owners = {j.coordinate: j.name for j in self.mechanism.joints if isinstance(j, Single)}
        joints = [self.mechanism.joint(owners.get(name, name)) for name in drives]
        for joint in joints:
            if not isinstance(joint, Single):
                raise InputError(
                    f"expected joints with one coordinate to drive, got {joint.name!r}, "
                    f"a {type(joint).__name__}"
                )
        rates = [joint.velocities[-1] for joint in joints]
        states = States.of(self.mechanism, q, v, t, a)
        function = partial(driving_forces, self._tree, self._closed, rates)
        forces = self._answer(states, function, accelerations=True)
        return {name: forces[..., k] for k, name in enumerate(drives)}

    def response(self, q: Given, t: float, impulse: Given) -> Array:
        """Return the change of velocities by an impulse with closed loops, shape (nv,).

        Args:
            q: shape (nq,).
            t: time [s].
            impulse: shape (nv,).

        Raises:
            ClosureError: if a motion that the loops allow moves no mass.
        """
        mechanism = self.mechanism
        push = numbers_of(impulse, mechanism.velocities, "impulse", np.zeros(mechanism.nv))
        return self._answer(States.of(mechanism, q, t=t), partial(self._respond, push))

    def _respond(self, push: Array, q: Array, v: Array, t: float) -> Array:
        closed = self._closed
        if closed is None:
            return np.asarray(np.linalg.solve(self._tree.mass(q, v, t), push), dtype=float)
        J = closed.closures.at(q, v, t).jacobian
        rest = np.zeros(len(J))
        return solve(closed.measure(J), -push, J, rest, most=closed.most).acceleration

    # forces between bodies

    def reactions(
        self, q: Given, v: Given = None, t: float | Array = 0.0, tau: Given = None
    ) -> dict[str, Wrench]:
        """Return the wrench of each parent on its child, by joint, at the child's origin.

        Components are in world axes.

        Springs, dampers, drives and loads count as external forces on the bodies. A reaction is the
        wrench of the joint itself, without a component along or about a free axis; at a joint with
        prescribed motion it includes the force that moves it. A joint with an armature also
        transmits −armature · r'' along or about its axis, which accelerates the rotor.

        Where the coordinate map couples several joints and no element says how, the components that
        depend on it are NaN; `undetermined` names them, and `reason` says why. `totals` are
        determined there, too.

        After the joints come the loops by name (as "loop …" if a joint has the same name), with the
        wrench of body a on body b, at the origin of the loop's frame on body b. Then come the
        contacts, with the wrench on the rolling body, at its hub (about the point of
        `contact_points` it has no moment), or at the point of a blade. Redundant constraints leave
        components undetermined; these have their least values and are named in `undetermined`.

        Args:
            q: shape (nq,).
            v: shape (nv,).
            t: time [s].
            tau: additional driving forces in joints with one coordinate [N·m or N], as in
                `acceleration`; like the mechanism's own forces not part of a reaction.

        Raises:
            EngineError: if a motion moves no mass in this state, or a loop is open.
            ClosureError: if a motion that the loops allow moves no mass.
            UnknownNameError: if a name in tau is not that of a joint, coordinate or velocity.
            InputError: if tau acts anywhere but in joints with one coordinate.
        """
        states = States.of(self.mechanism, q, v, t, tau=tau)
        wrenches = self._find_totals(states)
        if self.mechanism.elements:
            wrenches |= self._hold(states).wrenches
        if not self._guided.reasons:
            return wrenches
        poses = np.asarray(self._answer(states, self._tree.poses))
        count = len(self.mechanism.bodies)
        flags = self._guided.undetermined(poses.reshape(-1, count, 4, 4))
        return wrenches | {
            joint.name: _forget(wrenches[joint.name], loose, self._guided.reasons[joint.name])
            for joint, loose in zip(self.mechanism.joints, flags, strict=True)
            if loose.any()
        }

    def totals(
        self,
        q: Given,
        v: Given = None,
        t: float | Array = 0.0,
        tau: Given = None,
        *,
        elements: bool = True,
    ) -> dict[str, Wrench]:
        """Return the total wrench across each joint, of its reaction and its guides, by joint.

        It acts on the child and the bodies beyond, at the child's origin, world axes: the resultant
        of the joint's reaction and of the forces from outside that hold this part of the mechanism
        on the coordinate map. Without guides it is the joint's reaction. Loops follow as in
        `reactions`.

        Args:
            q: shape (nq,).
            v: shape (nv,).
            t: time [s].
            tau: additional driving forces, as in `reactions`.
            elements: whether to include the forces of the elements.

        Raises:
            EngineError: if a motion moves no mass in this state, or a loop is open.
            ClosureError: if a motion that the loops allow moves no mass.
            UnknownNameError: if a name in tau is not that of a joint, coordinate or velocity.
            InputError: if tau acts anywhere but in joints with one coordinate.
        """
        states = States.of(self.mechanism, q, v, t, tau=tau)
        totals = self._find_totals(states)
        known = elements or not self.mechanism.elements
        return totals if known else totals | self._hold(states).wrenches

    def guide_forces(
        self, q: Given, v: Given = None, t: float | Array = 0.0, tau: Given = None
    ) -> dict[str, Array]:
        """Return the forces of the guiding elements by name, e.g. tensions of cords [N].

        A force that redundant elements leave undetermined is NaN.

        Args:
            q: shape (nq,).
            v: shape (nv,).
            t: time [s].
            tau: additional driving forces, as in `reactions`.

        Returns:
            Each shape () or (n,) [N or N·m].

        Raises:
            EngineError: if a motion moves no mass in this state, or an element does not fit.
        """
        if not self.mechanism.elements:
            return {}
        held = self._hold(States.of(self.mechanism, q, v, t, tau=tau))
        names = self._tree.elements.names
        return {name: held.forces[..., k] for k, name in enumerate(names)}

    def guide_actions(
        self, q: Given, v: Given = None, t: float | Array = 0.0
    ) -> tuple[AppliedForce, ...]:
        """Return the actions of the guiding elements, force by force, each on both of its bodies.

        Args:
            q: shape (nq,).
            v: shape (nv,).
            t: time [s].
        """
        if not self.mechanism.elements:
            return ()
        states = States.of(self.mechanism, q, v, t)
        parts = self._hold(states).actions
        elements = self._tree.elements
        units = [unit for unit in elements.units() if not unit.pressed]
        effects = [(elements.names[unit.force], unit.body, unit.other) for unit in units]
        return _name_actions(effects, parts)

    def contact_points(self, q: Given, t: float | Array = 0.0) -> dict[str, Array]:
        """Return the points of contact of rolling bodies and blades, by contact, world axes [m].

        A contact exerts no moment about this point.

        Args:
            q: shape (nq,).
            t: time [s].

        Returns:
            Each shape (3,) or (n, 3), by the contacts' names in `reactions`.
        """
        if self._closed is None or not self.mechanism.contacts:
            return {}
        closures = self._closed.closures

        def function(q: Array, v: Array, t: float) -> Array:
            self._tree.poses(q, v, t)
            return closures.contacts.meet().places

        points = np.moveaxis(self._answer(States.of(self.mechanism, q, t=t), function), -2, 0)
        names = [end.name for end in self._ends[-len(points) :]]
        return dict(zip(names, points, strict=True))

    def _hold(self, states: States) -> _HeldStates:
        """Solve for the elements' forces in each state, and the joints' remaining reactions."""
        joints, tree = len(self.mechanism.joints), self._tree
        solutions: list[GuideReactions] = []

        def function(q: Array, v: Array, t: float) -> Array:
            if self._closed is None:
                totals = tree.reactions(q, v, t)
            else:
                totals = self._closed.reactions(q, v, t).wrenches[:joints]
            solutions.append(tree.hold(q, v, t, totals))
            return solutions[-1].reactions

        wrenches = self._answer(states, function)
        forces, _, loose, actions, unknown = map(np.array, zip(*solutions, strict=True))
        forces[:, unknown.any(axis=0)] = np.nan
        wrenches_by_name = self._wrenches(states, wrenches, np.asarray(loose.any(axis=0)))
        return _HeldStates(states.unbatch(forces), wrenches_by_name, states.unbatch(actions))

    @property
    def guided(self) -> dict[str, str]:
        """Why the reaction is undetermined, for each joint with a guide without an element."""
        return dict(self._guided.reasons)

    def _find_totals(self, states: States) -> dict[str, Wrench]:
        if states.efforts is not None:
            states.efforts.refuse_without_seat()
        if not self._ends:
            return {}
        if self._closed is not None:
            return self._transmit(states, self._closed)
        parts = self._answer(states, self._tree.reactions)
        return self._wrenches(states, parts)

    def undetermined(self, q: Given, t: float = 0.0) -> dict[str, tuple[str, ...]]:
        """Return the components of reactions that are undetermined, by name.

        The cause is redundant constraints, or guides without an element; joints and loops whose
        reactions are fully determined are left out.

        Args:
            q: shape (nq,), one position.
            t: time [s].

        Raises:
            EngineError: if a loop is open.
        """
        states = States.of(self.mechanism, q, t=t)
        flags = np.zeros((len(self._ends), 6), dtype=bool)
        if self._closed is not None:
            self._closed.refuse_open(states.q[0], float(states.t[0]))
            flags |= self._closed.undetermined(states.q[0], float(states.t[0]))
        if self._guided.reasons:
            poses = self._tree.poses(states.q[0], states.v[0], float(states.t[0]))
            flags[: len(self.mechanism.joints)] |= self._guided.undetermined(poses[None])
        return {
            end.name: name_components(row)
            for end, row in zip(self._ends, flags, strict=True)
            if row.any()
        }

    def applied(
        self, q: Given, v: Given = None, t: float | Array = 0.0
    ) -> tuple[AppliedForce, ...]:
        """Return the actions of springs, dampers, drives and loads on the bodies, force by force.

        A force between two bodies is listed twice: on body a or the child, then on body b or the
        parent. A spring or damper whose ends coincide exerts no force.

        Args:
            q: shape (nq,).
            v: shape (nv,).
            t: time [s].
        """
        effects = self._tree.loads.effects
        parts = self._answer(States.of(self.mechanism, q, v, t=t), self._tree.applied)
        return _name_actions(effects, parts)

    @cached_property
    def _guided(self) -> Guided:
        return Guided(self.mechanism, self._tree.elements.open)

    @cached_property
    def _ends(self) -> list[Ends]:
        """Joints, loops and contacts by the names of their reactions, with the bodies they join."""
        m = self.mechanism
        ends = [Ends(joint.name, joint.parent, joint.child, (0.0, 0.0, 0.0)) for joint in m.joints]
        joints = {end.name for end in ends}
        kinds = ["loop"] * len(m.loops) + ["contact"] * len(m.contacts)
        for kind, end in zip(kinds, ends_of(m), strict=True):
            name = f"{kind} {end.name}" if end.name in joints else end.name
            ends.append(end._replace(name=name))
        return ends

    def _transmit(self, states: States, closed: Closed) -> dict[str, Wrench]:
        solutions: list[TransmittedWrenches] = []

        def function(q: Array, v: Array, t: float) -> Array:
            solutions.append(closed.reactions(q, v, t))
            return solutions[-1].wrenches

        parts = self._answer(states, self._look_for_locks(function))
        flags = np.any([solution.undetermined for solution in solutions], axis=0)
        return self._wrenches(states, parts, flags)

    def _wrenches(
        self, states: States, parts: Array, flags: npt.NDArray[np.bool_] | None = None
    ) -> dict[str, Wrench]:
        """Name the wrenches of joints and loops, shape (…, n, 2, 3), with their points."""
        places = BodyPoses(partial(self._poses_by_name, states))
        return {
            end.name: Wrench(
                parts[..., k, 0, :],
                parts[..., k, 1, :],
                () if flags is None else name_components(flags[k]),
                parent=end.acting,
                child=end.acted,
                point=end.point,
                body=end.acted,
                places=places,
            )
            for k, end in enumerate(self._ends[: parts.shape[-3]])
        }

    def _poses_by_name(self, states: States) -> dict[str, Array]:
        poses = np.moveaxis(self._answer(states, self._tree.poses), -3, 0)
        names = (body.name for body in self.mechanism.bodies)
        return dict(zip(names, poses, strict=True))


def _load(mechanism: Mechanism, rank: int | None) -> Reference:
    """Load a mechanism anew; rank is that of its constraints, if it was known."""
    reference = Reference(mechanism)
    if reference._closed is None or rank is None:
        return reference
    return Reference._over(Loaded(reference._tree, reference._closed.with_rank(rank)))


def _name_actions(
    effects: Sequence[tuple[str, str, str | None]], parts: Array
) -> tuple[AppliedForce, ...]:
    """Name actions, shape (…, k, 3, 3), by force, body and the body with the opposite."""
    return tuple(
        AppliedForce(*effect, *np.moveaxis(parts[..., k, :, :], -2, 0))
        for k, effect in enumerate(effects)
    )


def _forget(wrench: Wrench, loose: npt.NDArray[np.bool_], reason: str) -> Wrench:
    """Set the components that guides leave undetermined to NaN; the others become zero."""
    force, moment = (np.where(part, np.nan, 0.0) for part in (loose[:3], loose[3:]))
    return replace(
        wrench,
        force=np.broadcast_to(force, wrench.force.shape).copy(),
        moment=np.broadcast_to(moment, wrench.moment.shape).copy(),
        undetermined=name_components(loose),
        reason=reason,
    )
