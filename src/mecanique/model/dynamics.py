"""What equations of motion answer: M(q, t) a + bias(q, v, t) = forces(q, v, t).

Both sides of a comparison, the derived equations and the reference, are asked these questions with
these arguments; how they compute what they answer is their own.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Literal, TypeAlias

from mecanique.arrays import Array
from mecanique.model.mechanism import Mechanism
from mecanique.model.states import States
from mecanique.model.values import Given

Quantity: TypeAlias = Literal[
    "mass_matrix", "bias", "forces", "gravity", "acceleration", "inverse_dynamics"
]
"""What is asked for, by the name of the method."""


class Dynamics(ABC):
    """Equations of motion to compute with, in one state or many.

    Every method takes q of shape (nq,) or (n, nq), v and a of shape (nv,) or (n, nv), or values by
    name, and t of shape () or (n,) [s]; v and a are zero when left out. Of values by name those
    left out are zero, too; of a position as `Mechanism.neutral` has it, a quaternion unturned and
    a limited coordinate within its limits. Answers for n states have a first axis of n.

    Every method raises an InputError if a shape is wrong or a number is not finite, and an
    UnknownNameError if a name is unknown.
    """

    mechanism: Mechanism

    @abstractmethod
    def _compute(self, quantity: Quantity, states: States) -> Array:
        """Return what is asked for, without the batch axis if a single state was given."""

    def mass_matrix(self, q: Given, t: float | Array = 0.0) -> Array:
        """Return the mass matrix M, shape (nv, nv); of a mechanism with loops, that of its tree.

        `Reference.independent_mass_matrix` is that of the motion which the loops leave free.

        Args:
            q: shape (nq,).
            t: time [s].
        """
        return self._compute("mass_matrix", States.of(self.mechanism, q, t=t))

    def bias(self, q: Given, v: Given = None, t: float | Array = 0.0) -> Array:
        """Return the inertia forces that do not depend on accelerations, and gravity, shape (nv,).

        Of a mechanism with loops, those of its tree: the loops' own forces are left out.

        Args:
            q: shape (nq,).
            v: shape (nv,).
            t: time [s].
        """
        return self._compute("bias", States.of(self.mechanism, q, v, t))

    def forces(self, q: Given, v: Given = None, t: float | Array = 0.0) -> Array:
        """Return the generalized forces of springs, dampers, drives and loads, shape (nv,).

        Args:
            q: shape (nq,).
            v: shape (nv,).
            t: time [s].
        """
        return self._compute("forces", States.of(self.mechanism, q, v, t))

    def gravity(self, q: Given, t: float | Array = 0.0) -> Array:
        """Return the part of the bias that gravity makes, ∂V/∂q of gravity, shape (nv,).

        Args:
            q: shape (nq,).
            t: time [s].
        """
        return self._compute("gravity", States.of(self.mechanism, q, t=t))

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
            DerivationError: from `Equations`, if a motion moves no mass in this state.
            EngineError: from `Reference`, for the same reason or because a loop is open.
            ClosureError: from `Reference`, if a motion that the loops leave free moves no mass.
            InputError: if the loops lock the mechanism in a singular position.
            UnknownNameError: if a name in tau is no joint, coordinate or velocity.
        """
        return self._compute("acceleration", States.of(self.mechanism, q, v, t, tau=tau))

    def inverse_dynamics(self, q: Given, v: Given, a: Given, t: float | Array = 0.0) -> Array:
        """Return the forces that accelerations a need besides: M a + bias − forces, shape (nv,).

        Args:
            q: shape (nq,).
            v: shape (nv,).
            a: shape (nv,).
            t: time [s].
        """
        return self._compute("inverse_dynamics", States.of(self.mechanism, q, v, t, a))
