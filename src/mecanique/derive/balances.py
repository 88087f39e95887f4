"""Newton's and Euler's equations of all bodies as one linear system in accelerations and reactions.

For each body, about its center of mass C and in world axes (Fundamentals of Dynamics, eqs. 1.2, 1.3, 1.8, 1.12):

    m a_C = m g + F + R − Σ R_child,    d/dt H_C = M_C + (couple and moment of R) − Σ (those of R_child),

with applied forces F, their moment M_C, the reaction R and its couple at the body's joint, and minus the reactions of
the joints that hang on the body (action and reaction). A joint transmits nothing along or about its free directions,
but what turns its rotor; where coordinates are driven, reactions along the joints do no work together.
"""

from __future__ import annotations

from typing import NamedTuple, final

import numpy as np

from mecanique.derive.free_bodies import FreeBodies, Snapshot, total_momentum
from mecanique.derive.recursion import solved
from mecanique.derive.states import States
from mecanique.errors import DerivationError
from mecanique.model.mechanism import Mechanism

__all__ = ["Balances", "Reaction", "kinetic_and_potential"]


class Reaction(NamedTuple):
    """What a parent does to its child through their joint.

    Args:
        force: shape (3,) or (n, 3), world axes [N].
        moment: shape (3,) or (n, 3), about the origin of the child's frame, world axes [N·m].
    """

    force: np.ndarray
    moment: np.ndarray


@final
class Balances:
    """The balances of momentum of every body of a mechanism, and what follows from them.

    Args:
        mechanism: any mechanism; of one with loops, its tree.
    """

    def __init__(self, mechanism: Mechanism) -> None:
        self._mechanism = mechanism
        self._bodies = FreeBodies(mechanism)

    def acceleration(self, states: States) -> np.ndarray:
        """Return the accelerations, shape (n, nv), solved for together with all reactions.

        Args:
            states: where, how fast and when.

        Raises:
            DerivationError: if a motion meets no inertia.
        """
        return self._solved(states)[:, : self._mechanism.nv]

    def reactions(self, states: States) -> dict[str, Reaction]:
        """Return the reaction in each joint, by joint name; springs, dampers, drives and loads are no part of it.

        Args:
            states: where, how fast and when.

        Raises:
            DerivationError: if a motion meets no inertia.
        """
        found = self._solved(states)[:, self._mechanism.nv :].reshape(len(states), -1, 2, 3)
        names = [joint.name for joint in self._mechanism.tree]
        by_name = {name: Reaction(found[:, k, 0], found[:, k, 1]) for k, name in enumerate(names)}
        return {joint.name: by_name[joint.name] for joint in self._mechanism.joints}

    def mass_matrix(self, states: States) -> np.ndarray:
        """Return M, shape (n, nv, nv): what is left before the accelerations once the reactions are eliminated.

        Args:
            states: where; velocities do not matter.
        """
        at = self._bodies.at(states)
        A, _, _ = self._system(at)
        nv = self._mechanism.nv
        # rows: bodies, then joints; columns: accelerations, then reactions
        reactions = np.linalg.solve(A[:, :-nv, nv:], A[:, :-nv, :nv]) if nv else A[:, :-nv, :nv]
        return np.asarray(A[:, -nv:, :nv] - A[:, -nv:, nv:] @ reactions)

    def bias(self, states: States) -> np.ndarray:
        """Return Coriolis, centrifugal and rheonomic inertia terms and gravity, shape (n, nv).

        Args:
            states: where and how fast.
        """
        at = self._bodies.at(states)
        A, inertia, _ = self._system(at)
        return -self._eliminated(A, inertia)

    def forces(self, states: States) -> np.ndarray:
        """Return the generalized forces of springs, dampers, drives and loads, shape (n, nv).

        Args:
            states: where, how fast and when.
        """
        A, _, applied = self._system(self._bodies.at(states))
        return self._eliminated(A, applied)

    def inverse_dynamics(self, states: States, a: np.ndarray) -> np.ndarray:
        """Return M a + bias, shape (n, nv).

        Args:
            states: where and how fast.
            a: shape (n, nv), accelerations.
        """
        A, inertia, _ = self._system(self._bodies.at(states))
        known = inertia - (A[:, :, : self._mechanism.nv] @ a[..., None])[..., 0]
        return -self._eliminated(A, known)

    def gravity(self, states: States) -> np.ndarray:
        """Return the part of the bias that gravity makes, shape (n, nv).

        Args:
            states: where.
        """
        at = self._bodies.at(states)
        A, inertia, _ = self._system(at)
        weights = np.zeros_like(inertia)
        for k, body in enumerate(at.bodies):
            weights[:, 6 * k : 6 * k + 3] = body.mass * self._bodies.gravity
        return -self._eliminated(A, weights)

    def energy(self, states: States) -> tuple[np.ndarray, np.ndarray]:
        """Return kinetic and potential energy, each shape (n,) [J].

        Args:
            states: where and how fast.
        """
        return kinetic_and_potential(self._bodies.at(states), self._bodies.gravity)

    def momentum(self, states: States) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return linear momentum, angular about the world's origin and about the center of mass, each shape (n, 3).

        Args:
            states: where and how fast.
        """
        return total_momentum(self._bodies.moving(states), len(states))

    def _eliminated(self, A: np.ndarray, known: np.ndarray) -> np.ndarray:
        """What is left of the right side in the joints' rows once the reactions are eliminated, shape (n, nv)."""
        nv = self._mechanism.nv
        if not nv:
            return np.zeros((len(A), 0))
        reactions = np.linalg.solve(A[:, :-nv, nv:], known[:, :-nv, None])
        left: np.ndarray = known[:, -nv:] - (A[:, -nv:, nv:] @ reactions)[..., 0]
        return left

    def _solved(self, states: States) -> np.ndarray:
        A, inertia, applied = self._system(self._bodies.at(states))
        if A.shape[1] <= _DENSE:
            return solved(self._mechanism, A, inertia + applied)
        from scipy.sparse import csc_matrix
        from scipy.sparse.linalg import splu

        try:
            rows = [splu(csc_matrix(one)).solve(known) for one, known in zip(A, inertia + applied, strict=True)]
        except RuntimeError:
            raise DerivationError(
                f"mechanism {self._mechanism.name!r}: a motion of massless bodies has no inertia; give them mass, or "
                "leave that coordinate out"
            ) from None
        return np.array(rows)

    def _system(self, at: Snapshot) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """A x = inertia + applied with x = [a, force and couple of each joint], rows: bodies, then joints."""
        n, nv, count = len(at.springs), self._mechanism.nv, len(at.bodies)
        size = nv + 6 * count
        A, inertia, applied = np.zeros((n, size, size)), np.zeros((n, size)), np.zeros((n, size))
        for k, body in enumerate(at.bodies):
            push, turn = slice(6 * k, 6 * k + 3), slice(6 * k + 3, 6 * k + 6)
            A[:, push, :nv] = body.mass * body.J
            A[:, turn, :nv] = body.inertia @ body.J_spin
            inertia[:, push] = body.mass * (self._bodies.gravity - body.gamma)
            inertia[:, turn] = -body.tumbling
            applied[:, push], applied[:, turn] = body.force, body.moment
            for other, sign in ((k, -1.0), (body.parent, 1.0)):
                if other < 0:
                    continue
                row, column = 6 * other, nv + 6 * k
                A[:, row : row + 6, column : column + 6] += sign * np.eye(6)
                A[:, row + 3 : row + 6, column : column + 3] += sign * _cross(body.seat - at.bodies[other].center)
        G = at.rates
        for u, k in enumerate(at.holders):
            column = nv + 6 * int(k)
            A[:, -nv or size :, column : column + 6] += G[:, u, :, None] * at.axes[:, None, :, u]
        rotors = G * at.armature[:, None]
        if nv:
            A[:, -nv:, :nv] += np.swapaxes(G, 1, 2) @ rotors
            inertia[:, -nv:] -= np.einsum("nuv,nu->nv", rotors, at.motions.gamma)
        return A, inertia, applied


def kinetic_and_potential(at: Snapshot, g: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return T = Σ ½ m v_C² + ½ H_C·ω (Fundamentals of Dynamics, eq. 1.31) and V of gravity and springs, shape (n,).

    Args:
        at: all free bodies.
        g: shape (3,), acceleration of free fall [m/s²].
    """
    T, V = 0.5 * np.sum(at.armature * at.motions.u**2, axis=-1), at.springs
    for body in at.bodies:
        T = T + 0.5 * body.mass * (body.velocity**2).sum(-1) + 0.5 * (body.angular_momentum * body.spin).sum(-1)
        V = V - body.mass * body.center @ g
    return T, V


_DENSE = 400
"""Systems with more equations than this are solved as sparse ones."""


def _cross(r: np.ndarray) -> np.ndarray:
    """The matrix of r ×, shape (n, 3, 3)."""
    out = np.zeros((len(r), 3, 3))
    out[:, 0, 1], out[:, 0, 2], out[:, 1, 2] = -r[:, 2], r[:, 1], -r[:, 0]
    return out - np.swapaxes(out, 1, 2)
