"""The reference: a mechanism's equations of motion as Pinocchio sees them."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import final

import numpy as np

from mecanique.arrays import Array
from mecanique.model.dynamics import Dynamics, Quantity
from mecanique.model.mechanism import Mechanism
from mecanique.model.states import States, expect_mechanism
from mecanique.model.values import Given
from mecanique.reference.engine.answers import Energy, Momentum, Resultant
from mecanique.reference.engine.many import energies, momenta, resultants
from mecanique.reference.engine.package import engine_package
from mecanique.reference.engine.rhs import Rhs
from mecanique.reference.kinematics import Kinematics
from mecanique.reference.loop_constraints import LoopConstraints
from mecanique.reference.loops.closed import Closed
from mecanique.reference.loops.loading import Loaded, load_once
from mecanique.reference.loops.singular import ClosedRhs, branch_acceleration, plain_rhs
from mecanique.reference.wrenches import Wrenches


@final
class Reference(Dynamics, Kinematics, LoopConstraints, Wrenches):
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
        """Return the energies in many states at once, unchecked, by sums over the bodies.

        Args:
            q: shape (n, nq).
            v: shape (n, nv).
            t: shape (n,) [s].
        """
        return Energy(*energies(self._tree, q, v, t).T)

    def momentum(self, q: Given, v: Given = None, t: float | Array = 0.0) -> Momentum:
        """Return the momenta of all bodies, world axes.

        Args:
            q: shape (nq,).
            v: shape (nv,).
            t: time [s].
        """
        parts = self._answer(States.of(self.mechanism, q, v, t=t), self._whole.momentum)
        return Momentum(*np.moveaxis(parts, -2, 0)[:3])

    def quick_momenta(self, q: Array, v: Array, t: Array) -> Momentum:
        """Return the momenta in many states at once, unchecked, by sums over the bodies.

        Args:
            q: shape (n, nq).
            v: shape (n, nv).
            t: shape (n,) [s].
        """
        return Momentum(*np.moveaxis(momenta(self._tree, q, v, t), 1, 0))

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
        changes = states.a if a is not None else self.quick_accelerations(states)
        with np.errstate(all="ignore"):
            parts = resultants(self._tree, states.q, states.v, states.t, changes)
        self._refuse_infinite(states, parts)
        return Resultant(*np.moveaxis(parts[0] if states.single else parts, -2, 0))

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
