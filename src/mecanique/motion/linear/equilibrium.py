"""Find the position near a start in which a mechanism can rest, by Newton's method."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, final

import numpy as np

from mecanique.arrays import Array
from mecanique.errors import MecaniqueError
from mecanique.model.expression import symbols_in
from mecanique.model.mechanism import Mechanism
from mecanique.model.parameters import Input
from mecanique.motion.record.rates import Rates
from mecanique.motion.tolerances import (
    AT_REST,
    AT_REST_ON_LOOPS,
    FLAT_SLOPE,
    NEWTON_STEP,
    NEWTON_STEP_ON_LOOPS,
    NO_FORCE,
    SLOPE_STEP,
    TINY,
)

if TYPE_CHECKING:
    from mecanique.reference import Reference
    from mecanique.reference.loops.closed import Closed
    from mecanique.reference.loops.independent import Independent


STEPS = 100
"""Most Newton steps from a start."""

HALVINGS = 20
"""How often a step that does not help is halved."""

PATIENCE, GAIN = 6, 0.9
"""A start is given up after so many steps on loops that do not bring the forces down to this part
of their least: between two turning points of a force Newton's method goes to and fro for good."""


def equilibrium_near(reference: Reference, start: np.ndarray, t: float) -> np.ndarray | None:
    """Return the position (nq,) without acceleration that Newton's method reaches, or None."""
    if not reference.mechanism.nv:
        return start
    try:
        if reference.closed is not None:
            return _on_loops(reference, reference.closed, start, t)
        return _of_tree(reference, start, t)
    except (MecaniqueError, np.linalg.LinAlgError):
        return None  # e.g. a spring of no length, or loops that cannot be closed on the way


@final
class TreeMotion:
    """The motion of a tree near a position, described as `Independent` does: all of it is free."""

    def __init__(self, mechanism: Mechanism, q: Array) -> None:
        self._rates, self._q = Rates.of(mechanism), q
        self.chosen = np.arange(mechanism.nv)
        self.tangent: Array = np.eye(mechanism.nv)

    def position(self, step: Array) -> Array:
        """Return the position after a step along the velocities, shape (nq,)."""
        return self._rates.displace(self._q, step)

    def tangents(self, q: Array) -> Array:
        """Return unity, shape (nv, nv)."""
        return self.tangent

    def velocity(self, q: Array, w: Array) -> Array:
        """Return w itself, shape (nv,)."""
        return w

    def acceleration(self, q: Array, v: Array, rate: Array) -> Array:
        """Return the rate itself, shape (nv,)."""
        return rate


def free_near(
    reference: Reference,
    q: Array,
    t: float,
    *,
    positional: bool = False,
    prefer: Array | None = None,
) -> Independent | TreeMotion:
    """Return the motion that constraints leave free near a position, or those of positions do."""
    closed = reference.closed
    if closed is None:
        return TreeMotion(reference.mechanism, q)
    from mecanique.reference.loops.independent import Independent

    rows = closed.closures.positional if positional else None
    return Independent(closed, q, t, rows=rows, prefer=prefer)


def effort(
    reference: Reference,
    free: Independent | TreeMotion,
    q: np.ndarray,
    w: np.ndarray,
    rate: np.ndarray,
    t: float,
) -> np.ndarray:
    """Return Tᵀ (M a + bias − forces), shape (n,), for free velocities w and their rate."""
    v = free.velocity(q, w)
    a = free.acceleration(q, v, rate)
    along: np.ndarray = free.tangents(q).T @ reference.inverse_dynamics(q, v, a, t)
    return along


def _of_tree(reference: Reference, start: np.ndarray, t: float) -> np.ndarray | None:
    mechanism, nv = reference.mechanism, reference.mechanism.nv
    rates = Rates.of(mechanism)
    q = rates.normalize(np.array(start, dtype=float))

    def residual(many: np.ndarray) -> np.ndarray:
        still = np.zeros((len(many), nv))
        value: np.ndarray = reference.inverse_dynamics(many, still, still, t)
        return value

    value = residual(q[None])[0]
    for _ in range(STEPS):
        ahead = np.vstack([np.eye(nv), -np.eye(nv)]) * SLOPE_STEP
        rise = residual(rates.displace(np.repeat(q[None], 2 * nv, axis=0), ahead))
        slope = ((rise[:nv] - rise[nv:]) / (2 * SLOPE_STEP)).T
        size = _size(value)
        step = _step(slope, value, longest=1.0)
        for _ in range(HALVINGS):
            trial = rates.normalize(rates.displace(q, step))
            new = residual(trial[None])[0]
            if _size(new) <= size:
                break
            step = step / 2
        else:
            break
        q, value = trial, new
        if _size(step) < NEWTON_STEP:
            break
    gravity = np.linalg.norm(mechanism.evaluate_all(mechanism.gravity))
    scale = _size(reference.mass_matrix(q, t)) * float(gravity) + _size(slope)
    return q if _size(value) <= AT_REST * scale + NO_FORCE else None


def _on_loops(
    reference: Reference, closed: Closed, start: np.ndarray, t: float
) -> np.ndarray | None:
    """Do the same in the deviations that the loops leave free."""
    from mecanique.reference.loops.assembly import close_position
    from mecanique.reference.loops.independent import Independent

    rates = Rates.of(reference.mechanism)
    still = np.zeros(reference.mechanism.nv)
    q = close_position(closed, rates.normalize(np.array(start, dtype=float)), t)
    balanced, best, idle = False, np.inf, 0
    for _ in range(STEPS):
        free = Independent(closed, q, t)
        count = len(free.chosen)
        if not count:
            return q
        none = np.zeros(count)
        steps = np.vstack([none, np.eye(count) * SLOPE_STEP, np.eye(count) * -SLOPE_STEP])
        along = [effort(reference, free, free.position(step), none, none, t) for step in steps]
        value, ahead, behind = (
            along[0],
            np.array(along[1 : count + 1]),
            np.array(along[count + 1 :]),
        )
        slope = ((ahead - behind) / (2 * SLOPE_STEP)).T
        # row by row and by the masses that move, so that a small part counts beside a large one
        tangent = free.tangent
        weight = np.abs(reference.inverse_dynamics(q, still, still, t))
        least = (
            AT_REST_ON_LOOPS * (np.abs(slope).max(axis=1) + np.abs(tangent).T @ weight) + NO_FORCE
        )
        balanced = bool((np.abs(value) <= least).all())
        mass = np.diag(tangent.T @ reference.mass_matrix(q, t) @ tangent)
        unit = np.sqrt(np.where(mass > 0, mass, 1.0))
        left = _size(value / unit)
        best, idle = (left, 0) if left <= GAIN * best else (best, idle + 1)
        if idle > PATIENCE:
            break
        step = _step(slope / np.outer(unit, unit), value / unit, longest=np.inf) / unit
        step *= min(1.0, 0.5 / max(_size(step), TINY))
        if _size(step) < NEWTON_STEP_ON_LOOPS:
            break
        q = close_position(closed, rates.displace(q, tangent @ step), t)
    return q if balanced else None


def _step(slope: np.ndarray, value: np.ndarray, longest: float) -> np.ndarray:
    """Return Newton's step, shortened to the longest that is allowed."""
    step: np.ndarray = -np.linalg.lstsq(slope, value, rcond=FLAT_SLOPE)[0]
    return step * min(1.0, longest / max(_size(step), TINY))


def _size(values: np.ndarray) -> float:
    return float(np.abs(values).max(initial=0.0))


def _changes(signal: Input) -> bool:
    return callable(signal.signal) or "t" in symbols_in(signal.signal)


def drop_disturbances(mechanism: Mechanism) -> Mechanism:
    """Return a mechanism whose inputs that change with time are zero."""
    if not any(_changes(signal) for signal in mechanism.inputs):
        return mechanism
    inputs = tuple(
        replace(signal, signal=0.0) if _changes(signal) else signal for signal in mechanism.inputs
    )
    return replace(mechanism, inputs=inputs)
