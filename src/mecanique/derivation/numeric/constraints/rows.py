"""Compute the rows of loops, contacts and velocity constraints from our poses: Φ or ψ, J and γ.

Along the path q + ε v the Φ of a loop is a jet: its partial derivatives at ε = 0 are J, and twice
its coefficient of ε² is γ, the value of Φ'' without accelerations. All is measured in the axes of
frame a, where frame b has the position p and the rotation matrix R; a hinge keeps R z = z, a weld
keeps the skew part of R at zero.

At the place of contact P a body's point has in the body the position s(ε) = R(ε)ᵀ (P(ε) − p(ε))
and the velocity H'(ε) s(ε); s changes as the contact moves, but adds nothing to the velocity of the
material point. That velocity is [ε⁰] of H' s, its rate [ε¹], and the virtual displacement δH s.
"""

from __future__ import annotations

from itertools import chain
from typing import Any, NamedTuple, final

import numpy as np

from mecanique.derivation.mechanics.contacts import touch
from mecanique.derivation.mechanics.loops import closure, label_rows
from mecanique.derivation.numeric.lagrange import LagrangeOnJets
from mecanique.derivation.numeric.paths import (
    constant_jet,
    coordinate_paths,
    frame_jet,
    ground_on_jets,
    stack_column,
)
from mecanique.derivation.scalars.functions import function
from mecanique.derivation.scalars.jets import Jet
from mecanique.derivation.tolerances import ROUNDING
from mecanique.derivation.tree.links import links, place_of
from mecanique.derivation.tree.poses import placement_matrix
from mecanique.model.constraints.contacts import Contact
from mecanique.model.constraints.loops import CLOSED, Loop
from mecanique.model.expression import evaluate
from mecanique.model.mechanism import Mechanism
from mecanique.model.mechanism_units import characteristic_length
from mecanique.model.states import States


class RowUnits(NamedTuple):
    """Natural units of the rows of constraints."""

    units: np.ndarray  # shape (m,), the characteristic length or one radian
    # shape (m,), number of each row's block, which are scaled together: a loop's lengths, its
    # angles, a contact or a velocity constraint
    blocks: np.ndarray


class Push(NamedTuple):
    """A unit force of a contact."""

    place: np.ndarray  # shape (n, 3), its point of action, in the world [m]
    direction: np.ndarray  # shape (n, 3), world axes
    ends: tuple[str, str]  # the body on which it acts, and the one on which its opposite acts


class Constraints(NamedTuple):
    """The constraints at n states: Φ = 0 with Φ'' = J a + γ, or ψ = 0 with ψ' = J a + γ."""

    residual: np.ndarray  # Φ, 0 of rows that restrict velocities only, shape (n, m)
    jacobian: np.ndarray  # J, shape (n, m, nv)
    gamma: np.ndarray  # γ, shape (n, m)
    rates: np.ndarray  # Φ' or ψ, with what moves by itself, shape (n, m)
    pushes: list[Push | None]  # the unit force of each row that belongs to a contact


@final
class Held:
    """All rows that constrain a mechanism's tree: of loops, contacts and velocity constraints."""

    def __init__(self, mechanism: Mechanism) -> None:
        self._mechanism = mechanism
        self._definition = LagrangeOnJets(mechanism)
        self._place = place_of(links(mechanism), mechanism)
        length, labels = characteristic_length(mechanism), label_rows(mechanism)
        self.names = tuple(label.name for label in labels)
        """Name of each row: the loop's or the contact's and the motion it prevents."""
        self.row_units = RowUnits(
            np.array([length if label.long else 1.0 for label in labels]),
            np.array([label.block for label in labels], dtype=int),
        )
        """Natural units of the rows, and their blocks."""

    def at(self, states: States) -> Constraints:
        """Return Φ, J and γ."""
        poses = self._definition.motion(states, np.zeros_like(states.v))[1]
        parts = [self._close(poses)] if self._mechanism.loops else []
        parts += [self._roll(contact, poses) for contact in self._mechanism.contacts]
        if self._mechanism.velocity_constraints or not parts:
            parts.append(self._state_laws(states))
        *arrays, pushes = zip(*parts, strict=True)
        residual, jacobian, gamma, rates = (np.concatenate(rows, axis=1) for rows in arrays)
        return Constraints(residual, jacobian, gamma, rates, [*chain.from_iterable(pushes)])

    def gaps(self, poses: list[Jet]) -> list[Jet]:
        """Return Φ of the loops, one jet per row; poses (n, 4, 4)."""
        ground, shape = ground_on_jets(self._mechanism, self._place, poses), poses[0].c.shape[:3]
        rows = [row for loop in self._mechanism.loops for row in closure(loop, ground, _angle)]
        return [row if isinstance(row, Jet) else constant_jet(row, shape) for row in rows]

    def _close(self, poses: list[Jet]) -> Constraints:
        """Return the rows of the loops."""
        c = np.stack([row.c for row in self.gaps(poses)], axis=-1)
        terms = [size for loop in self._mechanism.loops for size in self._sizes(loop, poses)]
        jacobian = _drop_rounding(np.moveaxis(c[0, 1:], 0, -1), np.stack(terms, axis=1))
        return Constraints(c[0, 0], jacobian, 2 * c[2, 0], c[1, 0], [None] * jacobian.shape[1])

    def _sizes(self, loop: Loop, poses: list[Jet]) -> list[np.ndarray]:
        """Return the size of what is summed in the entries of each row of J, each (n, nv)."""
        values = self._mechanism.values
        ends = (loop.body_a, loop.frame_a), (loop.body_b, loop.frame_b)
        A, B = (
            frame_jet(poses, self._place[body], placement_matrix(frame, values))
            for body, frame in ends
        )
        turn = _turn_sizes(A)
        # p = Rᵀ (p_B − p_A) turns with frame a, and p_B − p_A is as certain as its two terms
        far = sum(np.linalg.norm(X.value[:, :3, 3], axis=1) for X in (A, B))
        shift = _shift_sizes(A) + _shift_sizes(B) + turn * np.reshape(far, (-1, 1))
        turn = turn + _turn_sizes(B)
        return [turn if row.startswith("r") else shift for row in CLOSED[loop.kind]]

    def _roll(self, contact: Contact, poses: list[Jet]) -> Constraints:
        """Return the rows of a contact, n·(v_A − v_B) = 0 in each of its directions."""
        ground, shape = ground_on_jets(self._mechanism, self._place, poses), poses[0].c.shape[:3]
        met, ends = touch(self._mechanism, contact, ground), (contact.body, contact.on)
        # columns, trailing shape (n, 3, 1)
        place, *directions = (stack_column(x, shape) for x in (met.place, *met.directions))
        A, B = (frame_jet(poses, self._place[body]) for body in ends)
        velocity, rate, shifts = (
            a - b for a, b in zip(_carry(A, place), _carry(B, place), strict=True)
        )
        far = np.linalg.norm(place.value[:, :, 0], axis=-1)[:, None]
        terms = sum(_shift_sizes(H) + far * _turn_sizes(H) for H in (A, B))
        jacobian, gamma, rates = [], [], []
        for direction in directions:
            n, turning = direction.c[0, 0, :, :, 0], direction.c[1, 0, :, :, 0]
            slopes = np.einsum("ni,kni->nk", n, shifts)
            jacobian.append(_drop_rounding(slopes, np.asarray(terms)))
            gamma.append(np.einsum("ni,ni->n", n, rate) + np.einsum("ni,ni->n", turning, velocity))
            rates.append(np.einsum("ni,ni->n", n, velocity))
        residual = np.zeros((shape[2], len(directions)))
        residual[:, 0] = met.gap.value if isinstance(met.gap, Jet) else 0.0
        at = place.value[:, :, 0]
        pushes = [Push(at, direction.value[:, :, 0], ends) for direction in directions]
        slopes, bent, now = (np.stack(parts, axis=1) for parts in (jacobian, gamma, rates))
        return Constraints(residual, slopes, bent, now, [*pushes])

    def _state_laws(self, states: States) -> Constraints:
        """Return the rows Σ A_i v_i − b of the velocity constraints."""
        laws, velocities = self._mechanism.velocity_constraints, self._mechanism.velocities
        n, size = len(states), len(laws)
        jacobian = np.zeros((n, size, len(velocities)))
        gamma, rates = np.zeros((2, n, size))
        values = coordinate_paths(states) if laws else {}

        def path(scalar: Any) -> np.ndarray:
            value = evaluate(scalar, values, function=function)
            return value.c[:2, 0] if isinstance(value, Jet) else np.array([[value], [0.0]])

        for row, law in enumerate(laws):
            for k, entry in enumerate(law.along(velocities)):
                now, rate = path(entry)
                jacobian[:, row, k] = now
                gamma[:, row] += rate * states.v[:, k]
                rates[:, row] += now * states.v[:, k]
            now, rate = path(law.rate)
            gamma[:, row] -= rate
            rates[:, row] -= now
        return Constraints(np.zeros((n, size)), jacobian, gamma, rates, [None] * size)


def _angle(y: Any, x: Any) -> Any:
    return y.atan2(x) if isinstance(y, Jet) else np.arctan2(y, x)


def _carry(H: Jet, place: Jet) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return H' s, its rate without accelerations, and δH s, of the body's point at a place."""
    s = H[:, :3, :3].T @ (place - H[:, :3, 3:])
    unit = np.ones((*s.c.shape[2:-2], 1, 1))
    at = np.concatenate([s.c[0, 0], unit], axis=-2)
    moving = np.concatenate([s.c[1, 0], 0 * unit], axis=-2)
    velocity = H.c[1, 0] @ at
    rate = 2 * H.c[2, 0] @ at + H.c[1, 0] @ moving
    shifts = H.c[0, 1:] @ at
    return velocity[..., :3, 0], rate[..., :3, 0], shifts[..., :3, 0]


def _drop_rounding(jacobian: np.ndarray, terms: np.ndarray) -> np.ndarray:
    """Return J with zeros where its entries are no more than the rounding of their terms."""
    # Rows that joints satisfy by themselves, such as those across a planar linkage's plane, would
    # otherwise count as constraints once they are scaled to one
    return np.where(np.abs(jacobian) > ROUNDING * terms, jacobian, 0.0)


def _shift_sizes(pose: Jet) -> np.ndarray:
    """Return by how much variations displace a pose's origin, shape (n, nv)."""
    return np.asarray(np.linalg.norm(pose.c[0, 1:, :, :3, 3], axis=-1).T)


def _turn_sizes(pose: Jet) -> np.ndarray:
    """Return by how much variations turn a pose, shape (n, nv)."""
    return np.asarray(np.linalg.norm(pose.c[0, 1:, :, :3, :3], axis=(-2, -1)).T)
