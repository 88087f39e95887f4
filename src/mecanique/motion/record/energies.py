"""Energies along a motion, and the work that changes them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, final

import numpy as np

from mecanique.arrays import median
from mecanique.model.expression import symbols_in
from mecanique.model.mechanism import Mechanism
from mecanique.motion.record.curve import Curve
from mecanique.motion.record.events import Occurrence
from mecanique.motion.record.quadrature import integral
from mecanique.motion.record.upheld import uphold

if TYPE_CHECKING:
    from mecanique.reference import Reference


TIME_STEP = 0.02
"""Step of the differences for ∂L/∂t of prescribed motions, in steps of the integrator."""


@final
@dataclass(frozen=True, eq=False)
class Energies:
    """The energies along a motion [J].

    Args:
        t: shape (n,), times [s].
        kinetic: shape (n,), T.
        gravity: shape (n,), V of gravity, zero if every body's center is at the world's origin.
        springs: shape (n,), V of the springs.
        work: shape (n,), work since the start of everything that has no potential: dampers, drives,
            loads, inputs, prescribed motion and impacts.
    """

    t: np.ndarray
    kinetic: np.ndarray
    gravity: np.ndarray
    springs: np.ndarray
    work: np.ndarray

    @cached_property
    def potential(self) -> np.ndarray:
        """V = V of gravity + V of springs, shape (n,)."""
        total: np.ndarray = self.gravity + self.springs
        return total

    @cached_property
    def total(self) -> np.ndarray:
        """E = T + V, shape (n,)."""
        total: np.ndarray = self.kinetic + self.potential
        return total

    @cached_property
    def balance(self) -> np.ndarray:
        """E(t) − E(0) − work(t), zero for an exact motion, shape (n,)."""
        residual: np.ndarray = self.total - self.total[0] - self.work
        return residual

    @cached_property
    def scale(self) -> float:
        """What errors are compared with: kinetic energy, range of the potential, and work."""
        size = float(self.kinetic.max() + np.ptp(self.potential) + np.abs(self.work).max())
        return size if size > 0 else 1.0


def energies(
    mechanism: Mechanism,
    reference: Reference,
    curve: Curve,
    occurrences: tuple[Occurrence, ...],
    times: np.ndarray,
) -> Energies:
    """Return the energies of a motion and the work done on it.

    With h = v·∂T/∂v − T + V: dh/dt = Q·v − ∂L/∂t, Q being the generalized forces without potential,
    so that E = h + T₁ + 2 T₀ changes by ∫ (Q·v − ∂L/∂t) dt + Δ(T₁ + 2 T₀), T₁ and T₀ being the
    parts of T of first and zeroth degree in v, which prescribed motion brings (Goldstein, Classical
    Mechanics, 1950, sect. 2-6; Whittaker, Analytical Dynamics, 1904, art. 41). The integral is
    taken along the motion by quadrature of order 12 on its steps, halved where it needs that.

    Args:
        mechanism: what moves.
        reference: its `Reference`.
        curve: the motion.
        occurrences: the events on it; impacts take energy.
        times: shape (n,) [s].
    """
    state = curve(times)
    (parts,) = uphold(
        lambda: [np.transpose(reference.quick_energies(state.q, state.v, times))],
        lambda at: [np.transpose(reference.energy(state.q[at], state.v[at], times[at]))],
        len(times),
    )
    work = _work(mechanism, reference, curve, times)
    for occurrence in occurrences:
        if occurrence.impact:
            before, after = (
                reference.energy(occurrence.q, v, occurrence.t).total
                for v in (occurrence.v, occurrence.after)
            )
            work = work + np.where(times >= occurrence.t, after - before, 0.0)
    kinetic, gravity, springs = parts.T
    return Energies(times, kinetic, gravity, springs, work)


def is_rheonomic(mechanism: Mechanism) -> bool:
    """Return whether the coordinate map depends on time."""
    moving = {"t", *(signal.symbol for signal in mechanism.inputs)}
    return any(
        symbols_in(expression) & moving for expression in mechanism.coordinates.driven.values()
    )


def _work(
    mechanism: Mechanism, reference: Reference, curve: Curve, times: np.ndarray
) -> np.ndarray:
    free = tuple(force for force in mechanism.forces if not force.conservative)
    rheonomic = is_rheonomic(mechanism)
    work: np.ndarray = np.zeros(len(times))
    if free:
        from mecanique.reference import Reference

        others = (
            reference
            if len(free) == len(mechanism.forces)
            else Reference(replace(mechanism, forces=free))
        )

        def power(t: np.ndarray, q: np.ndarray, v: np.ndarray) -> np.ndarray:
            total: np.ndarray = np.sum(others.forces(q, v, t) * v, axis=1, keepdims=True)
            return total

        work = work + integral(curve, power, times)[:, 0]
    if not rheonomic:
        return work

    lengths = curve.t[curve.intervals + 1] - curve.t[curve.intervals]
    h = TIME_STEP * median(lengths) if len(lengths) else 1.0

    def minus_slope(t: np.ndarray, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """−∂L/∂t."""
        total = np.zeros(len(t))
        for k, weight in ((1, 8.0), (2, -1.0)):
            for side in (1, -1):
                energy = reference.quick_energies(q, v, t + side * k * h)
                total += side * weight * (energy.kinetic - energy.potential)
        return -total[:, None] / (12 * h)

    def carry(t: np.ndarray, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """T₁ + 2 T₀."""
        forward, backward, rest = (
            reference.quick_energies(q, u, t).kinetic for u in (v, -v, np.zeros_like(v))
        )
        result: np.ndarray = (forward - backward) / 2 + 2 * rest
        return result

    state = curve(times)
    begin = curve(curve.t[:1])
    work = work + integral(curve, minus_slope, times)[:, 0] + carry(times, state.q, state.v)
    result: np.ndarray = work - carry(np.atleast_1d(begin.t), begin.q, begin.v)
    return result
