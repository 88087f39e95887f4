"""A mode of elements that switch at rest: what it holds, and the motion that it leaves free."""

from __future__ import annotations

from typing import TYPE_CHECKING, final

import numpy as np

from mecanique.arrays import Array, rank_of
from mecanique.derivation.mechanics.switching import CLOSED, OPEN, STICKS, ElementState, Mode, Terms
from mecanique.derivation.tolerances import CLOSED_GAP, NO_GAP, REDUNDANT
from mecanique.errors import ClosureError, MecaniqueError
from mecanique.motion.switching.corners import Corners, least_step
from mecanique.motion.switching.law import ModeSolution, UndecidedError
from mecanique.motion.tolerances import FLAT_HELD

if TYPE_CHECKING:
    from mecanique.reference.engine.answers import Energy

CLOSINGS = 30
"""Newton's steps from a start to where what is closed touches."""


@final
class HeldMode:
    """What a `Reference` answers, of one mode and without checks.

    What rubs sticks where its surfaces are at rest, and slips against what moves by itself.
    """

    def __init__(
        self,
        corners: Corners,  # the laws of the elements
        closed: frozenset[str],  # names of the elements that are closed
        *,
        sticks: bool = True,  # whether friction holds; if not, what would stick has none
    ) -> None:
        from mecanique.reference import Reference

        self.mechanism = corners.mechanism
        self.rates = corners.rows.rates
        self._corners, self._closed, self._sticks = corners, closed, sticks
        self._base = Reference.of(corners.rows.base)
        self._known: dict[bytes, tuple[Terms, Mode]] = {}

    def at(self, q: Array, v: Array, t: float) -> tuple[Terms, Mode]:
        """Return the terms in a state, and the mode that holds at rest there."""
        # the same state is asked for as often as it is described
        state = np.array([*q, *v, t]).tobytes()
        if state not in self._known:
            self._known = {state: self._evaluate(q, v, t)}
        return self._known[state]

    def _evaluate(self, q: Array, v: Array, t: float) -> tuple[Terms, Mode]:
        terms, none = self._corners.measure(q, v, t), np.zeros(len(v))
        resting = terms._replace(rates=terms.drift)
        still, mode = self._corners.still_speed(resting, none), list[ElementState]()
        for element in self._corners.elements:
            touches = not element.struck or element.name in self._closed
            states = self._corners.laws.candidates(resting, element, touches, still)
            # the first is open, if it may be and does not have to be
            state = states[len(states) > 1 and element.normal is not None]
            if state.name == STICKS and not self._sticks:
                state = ElementState(OPEN if element.normal is None else CLOSED)
            mode.append(state)
        return terms, tuple(mode)

    def hold(self, q: Array, t: float, *, gaps: bool = False) -> tuple[Terms, list[int]]:
        """Return the terms at rest, and the rows that are held, or those of gaps alone."""
        terms, mode = self.at(q, np.zeros(self.mechanism.nv), t)
        rows = self._corners.list_rows(mode)
        return terms, [k for k in rows if self._corners.rows.positional[k] or not gaps]

    def close(self, q: Array, t: float, fixed: int | None = None) -> Array:
        """Return the position next to q where what is closed touches; one velocity may be fixed."""
        q = self.rates.normalize(np.array(q, dtype=float))
        moving, widest = [k for k in range(self.mechanism.nv) if k != fixed], np.inf
        for _ in range(CLOSINGS):
            terms, rows = self.hold(q, t, gaps=True)
            gaps, last = terms.gaps[rows], widest
            widest = float(np.abs(gaps).max(initial=0.0)) / self._corners.length
            # by the rounding of one number gaps stay as wide as they are
            if widest <= NO_GAP or last <= widest <= CLOSED_GAP:
                return q
            step = np.zeros(self.mechanism.nv)
            mass, slopes = terms.mass[np.ix_(moving, moving)], terms.jacobian[:, moving]
            step[moving] = least_step(terms._replace(mass=mass, jacobian=slopes), rows, gaps)
            q = self.rates.displace(q, step)
        if not widest <= CLOSED_GAP:
            raise ClosureError(f"what is closed does not touch: gaps of {gaps}")
        return q

    def follows(self, q: Array, t: float) -> dict[str, str] | None:
        """Return the state of each element where this mode is the one that follows at rest."""
        y = np.concatenate([q, np.zeros(self.mechanism.nv)])
        try:
            self._corners.begin(t, y)
        except MecaniqueError:  # bodies are one within the other, or no mode follows
            return None
        present, (_, mode) = self._corners.mode(t), self.at(q, y[len(q) :], t)
        states = {e.name: s.name for e, s in zip(self._corners.elements, present, strict=True)}
        return states if list(states.values()) == [state.name for state in mode] else None

    def drop_rounding(self, slopes: Array, tangent: Array, q: Array, t: float) -> Array:
        """Return slopes of forces along what is free without the rounding of loads held."""
        terms, _ = self.at(q, np.zeros(self.mechanism.nv), t)
        rounding = FLAT_HELD * np.abs(terms.load).sum() * np.abs(tangent).max(axis=0, initial=0.0)
        return np.where(np.abs(slopes) <= rounding[:, None], 0.0, slopes)

    def keeps(self, q: Array, t: float) -> bool:
        """Return whether rest at a position is in this mode; where friction is let go, any is."""
        return not self._sticks or self.follows(q, t) is not None

    def acceleration(self, q: Array, v: Array, t: float = 0.0) -> Array:
        """Return the accelerations in this mode, shape (nv,)."""
        return self._solve(*self.at(q, v, t)).a

    def inverse_dynamics(self, q: Array, v: Array, a: Array, t: float = 0.0) -> Array:
        """Return M a + bias − forces, shape (nv,), without the forces along the rows held."""
        terms, mode = self.at(q, v, t)
        forces = self._solve(terms, mode).forces.copy()
        forces[self._corners.list_rows(mode)] = 0.0
        balance: Array = terms.mass @ a - terms.load - terms.jacobian.T @ forces
        return balance

    def _solve(self, terms: Terms, mode: Mode) -> ModeSolution:
        solution = self._corners.laws.solve(terms, mode)
        if solution is None:
            raise UndecidedError(f"the mode {self._corners.describe(mode)} has no accelerations", 0)
        return solution

    def mass_matrix(self, q: Array, t: float = 0.0) -> Array:
        """Return M, shape (nv, nv)."""
        return self.at(q, np.zeros(self.mechanism.nv), t)[0].mass

    def energy(self, q: Array, v: Array | None, t: float) -> Energy:
        """Return the energies, without those of elastic stops."""
        return self._base.energy(q, v, t)


@final
class ModeMotion:
    """The motion that a mode leaves free near a position, described as `Independent` does."""

    def __init__(self, held: HeldMode, q: Array, t: float) -> None:
        from scipy.linalg import qr

        self._held, self._q, self._t = held, q, t
        terms, rows = held.hold(q, t)
        # in the metric of kinetic energy, so that singular values are comparable
        root = np.linalg.inv(np.linalg.cholesky(terms.mass)).T
        J = terms.jacobian[rows] @ root
        sizes = np.linalg.norm(J, axis=1, keepdims=True)
        _, values, axes = np.linalg.svd(J / np.where(sizes == 0, 1.0, sizes))
        free = root @ axes[rank_of(values, REDUNDANT) :].T
        _, _, order = qr((np.sqrt(np.diag(terms.mass))[:, None] * free).T, pivoting=True)
        self.chosen: Array = np.sort(order[: free.shape[1]])
        self._others: Array = np.sort(order[free.shape[1] :])
        self.tangent: Array = free @ np.linalg.inv(free[self.chosen])

    def position(self, step: Array) -> Array:
        """Return the closed position after a step of the independent coordinates, shape (nq,)."""
        return self._held.close(self._held.rates.displace(self._q, self.tangent @ step), self._t)

    def tangents(self, q: Array) -> Array:
        """Return T at a closed position, shape (nv, n)."""
        return self._complete(q, np.eye(len(self.chosen)), None)

    def velocity(self, q: Array, w: Array) -> Array:
        """Return v, shape (nv,), from the independent velocities at a closed position."""
        return self._complete(q, w[:, None], None)[:, 0] if w.any() else np.zeros(len(self.tangent))

    def acceleration(self, q: Array, v: Array, rate: Array) -> Array:
        """Return v', shape (nv,), from the independent velocities' rates in a closed state."""
        return self._complete(q, rate[:, None], v)[:, 0]

    def _complete(self, q: Array, given: Array, v: Array | None) -> Array:
        """Return the columns x with the given components and J x = 0, or J x + γ = 0 in motion."""
        _, rows = self._held.hold(q, self._t)
        terms, _ = self._held.at(q, np.zeros(len(self.tangent)) if v is None else v, self._t)
        J, rest = terms.jacobian[rows], 0.0 if v is None else terms.gamma[rows, None]
        others = self._others
        x = np.zeros((len(self.tangent), given.shape[1]))
        x[self.chosen] = given
        x[others] = -np.linalg.lstsq(J[:, others], J @ x + rest, rcond=REDUNDANT)[0]
        return x
