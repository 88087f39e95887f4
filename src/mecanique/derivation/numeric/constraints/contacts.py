"""Compute the rows A v = b, A a + γ = 0 of rolling, blades and velocity constraints from our poses.

The body's point at the place of contact P has in the body the position s(ε) = R(ε)ᵀ (P(ε) − p(ε))
and the velocity H'(ε) s(ε); s changes as the contact moves, but adds nothing to the velocity of the
material point. With jets along the path q + ε v, that velocity is [ε⁰] of H' s, its rate [ε¹], and
the virtual displacement δH s.
"""

from __future__ import annotations

from typing import Any, final

import numpy as np

from mecanique.derivation.mechanics.contacts import touch
from mecanique.derivation.numeric.constraints.loops import (
    Constraints,
    RowUnits,
    drop_rounding,
    shift_sizes,
    turn_sizes,
)
from mecanique.derivation.numeric.paths import (
    coordinate_paths,
    frame_jet,
    ground_on_jets,
    stack_column,
)
from mecanique.derivation.scalars.functions import function
from mecanique.derivation.scalars.jets import Jet
from mecanique.derivation.tree.links import links, place_of
from mecanique.model.constraints.contacts import Contact, row_names
from mecanique.model.expression import evaluate
from mecanique.model.mechanism import Mechanism
from mecanique.model.mechanism_units import characteristic_length
from mecanique.model.states import States


@final
class VelocityLaws:
    """The rows of a mechanism's contacts and velocity constraints."""

    def __init__(self, mechanism: Mechanism) -> None:
        self._mechanism = mechanism
        self._place = place_of(links(mechanism), mechanism)
        constraints = mechanism.velocity_constraints
        self.names = (*row_names(mechanism.contacts), *(each.name for each in constraints))
        """Name of each row: the contact's and the motion it prevents, or the constraint's."""
        length = characteristic_length(mechanism)
        contacts = [k for k, contact in enumerate(mechanism.contacts) for _ in contact.rows]
        units = [length] * len(contacts) + [1.0] * len(constraints)
        blocks = contacts + [len(mechanism.contacts) + k for k in range(len(constraints))]
        self.row_units = RowUnits(np.array(units), np.array(blocks, dtype=int))
        """Natural units of the rows, and their blocks: one for each contact or constraint."""

    def at(self, states: States, poses: list[Jet]) -> Constraints:
        """Return the rows at n states; poses (n, 4, 4)."""
        blocks = []
        for contact in self._mechanism.contacts:
            place, directions, gap = self.touch(contact, poses)
            A, B = (frame_jet(poses, self._place[body]) for body in (contact.body, contact.on))
            rows = [_no_slip(A, B, place, direction) for direction in directions]
            jacobian, gamma = (np.stack(parts, axis=1) for parts in zip(*rows, strict=True))
            residual = np.zeros(gamma.shape)
            residual[:, 0] = gap
            blocks.append(Constraints(residual, jacobian, gamma))
        blocks.append(self._state_laws(states))
        parts = zip(*((b.residual, b.jacobian, b.gamma) for b in blocks), strict=True)
        return Constraints(*(np.concatenate(part, axis=1) for part in parts))

    def touch(self, contact: Contact, poses: list[Jet]) -> tuple[Jet, list[Jet], np.ndarray]:
        """Return the place and the directions of a contact, trailing shape (n, 3, 1), and its Φ."""
        ground = ground_on_jets(self._mechanism, self._place, poses)
        place, directions, gap = touch(self._mechanism, contact, ground)
        shape = poses[0].c.shape[:3]
        columns = [stack_column(vector, shape) for vector in (place, *directions)]
        return columns[0], columns[1:], gap.value if isinstance(gap, Jet) else np.zeros(shape[2])

    def _state_laws(self, states: States) -> Constraints:
        """Return the rows Σ A_i v_i − b of the velocity constraints."""
        constraints, velocities = self._mechanism.velocity_constraints, self._mechanism.velocities
        n, size = len(states), len(constraints)
        jacobian, gamma = np.zeros((n, size, len(velocities))), np.zeros((n, size))
        if not constraints:
            return Constraints(np.zeros((n, 0)), jacobian, gamma)
        values = coordinate_paths(states)

        def path(scalar: Any) -> np.ndarray:
            value = evaluate(scalar, values, function=function)
            return value.c[:2, 0] if isinstance(value, Jet) else np.array([[value], [0.0]])

        for row, constraint in enumerate(constraints):
            for k, entry in enumerate(constraint.along(velocities)):
                now, rate = path(entry)
                jacobian[:, row, k] = now
                gamma[:, row] += rate * states.v[:, k]
            gamma[:, row] -= path(constraint.rate)[1]
        return Constraints(np.zeros((n, size)), jacobian, gamma)


def _no_slip(A: Jet, B: Jet, place: Jet, direction: Jet) -> tuple[np.ndarray, np.ndarray]:
    """Return the row A and γ of n·(v_A − v_B) = 0, for the points of two bodies in contact."""
    velocity, rate, shifts = (
        a - b for a, b in zip(_carry(A, place), _carry(B, place), strict=True)
    )
    n, turning = direction.c[0, 0, :, :, 0], direction.c[1, 0, :, :, 0]
    jacobian = np.einsum("ni,kni->nk", n, shifts)
    far = np.linalg.norm(place.value[:, :, 0], axis=-1)[:, None]
    terms = sum(shift_sizes(H) + far * turn_sizes(H) for H in (A, B))
    jacobian = drop_rounding(jacobian, np.asarray(terms))
    gamma = np.einsum("ni,ni->n", n, rate) + np.einsum("ni,ni->n", turning, velocity)
    return jacobian, gamma


def _carry(H: Jet, place: Jet) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return H' s, its rate without accelerations, and δH s, of the body's point at a place."""
    s = H[:, :3, :3].T @ (place - H[:, :3, 3:])
    one = np.ones((*s.c.shape[2:-2], 1, 1))
    at = np.concatenate([s.c[0, 0], one], axis=-2)
    moving = np.concatenate([s.c[1, 0], 0 * one], axis=-2)
    velocity = H.c[1, 0] @ at
    rate = 2 * H.c[2, 0] @ at + H.c[1, 0] @ moving
    shifts = H.c[0, 1:] @ at
    return velocity[..., :3, 0], rate[..., :3, 0], shifts[..., :3, 0]
