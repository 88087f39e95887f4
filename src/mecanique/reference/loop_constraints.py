"""Evaluate constraints and the motions they allow: Φ(q, t) = 0, J v + ∂Φ/∂t = 0, J a + γ = 0."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import TypeVar

import numpy as np

from mecanique.arrays import Array
from mecanique.errors import InputError
from mecanique.model.expression import finite
from mecanique.model.joint_base import Single
from mecanique.model.states import States
from mecanique.model.values import Given, names_of, numbers_of
from mecanique.reference.answering import Answering
from mecanique.reference.loops.closed import Closed
from mecanique.reference.loops.freedom import generic_rank
from mecanique.reference.loops.independent import driving_forces, free_motions
from mecanique.reference.loops.loading import Loaded
from mecanique.reference.loops.nullspace import solve

_Asked = TypeVar("_Asked", bound="LoopConstraints")


class LoopConstraints(Answering):
    """The methods of a `Reference` about loops; for a tree their results are empty."""

    @property
    def closed(self) -> Closed | None:
        """The loops and the motions they allow; None for a tree."""
        return self._closed

    def with_rank_at(self: _Asked, q: Given, t: float = 0.0) -> _Asked:
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
