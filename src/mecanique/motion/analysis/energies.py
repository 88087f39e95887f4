"""Energies along a motion, and the work that changes them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, final

import numpy as np

from mecanique.arrays import Array, median
from mecanique.model import AnyForce, Mechanism
from mecanique.model.expression import symbols_in
from mecanique.motion.compile.along import StateLaw, StateSums, compute
from mecanique.motion.compile.python import vectorize
from mecanique.motion.record.curve import Curve, State
from mecanique.motion.record.quadrature import integral
from mecanique.motion.tolerances import UNCHANGED
from mecanique.motion.trajectory import states_at, stretches_of
from mecanique.wording import Legible

if TYPE_CHECKING:
    from mecanique.motion.trajectory import Trajectory


TIME_STEP = 0.02
"""Step of the differences for the rates of signals, in steps of the integrator."""


@final
@dataclass(frozen=True, eq=False, repr=False)
class Energies(Legible):
    """The energies along a motion [J].

    Args:
        t: shape (n,), times [s].
        kinetic: shape (n,), T.
        gravity: shape (n,), V of gravity, zero if every body's center is at the world's origin.
        springs: shape (n,), V of the springs.
        loads: shape (n,), V of the loads that algebra shows to have a potential.
        work: shape (n,), work since the start of everything that has no potential: dampers, drives,
            other loads, inputs, prescribed motion, constraints that move by themselves, impacts.
    """

    t: np.ndarray
    kinetic: np.ndarray
    gravity: np.ndarray
    springs: np.ndarray
    loads: np.ndarray
    work: np.ndarray

    @cached_property
    def potential(self) -> np.ndarray:
        """V of gravity, springs and loads together, shape (n,)."""
        total: np.ndarray = self.gravity + self.springs + self.loads
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
        """What errors are compared with: kinetic energy, range of the potential, and work.

        At rest these are rounding, and it is the potential.
        """
        size = float(self.kinetic.max() + np.ptp(self.potential) + np.abs(self.work).max())
        stored = float(np.abs(self.potential).max())
        return size if size > UNCHANGED * stored else stored or 1.0


def energies(motion: Trajectory, times: np.ndarray) -> Energies:
    """Return the energies of a motion and the work done on it.

    With h = v·∂T/∂v − T + V: dh/dt = Q·v − ∂L/∂t, Q being the generalized forces without potential,
    so that E = h + T₁ + 2 T₀ changes by ∫ (Q·v − ∂L/∂t) dt + Δ(T₁ + 2 T₀), T₁ and T₀ being the
    parts of T of first and zeroth degree in v, which prescribed motion brings (Goldstein, Classical
    Mechanics, 1950, sect. 2-6; Whittaker, Analytical Dynamics, 1904, art. 41). The integral is
    taken along the motion by quadrature of order 12 on its steps, halved where it needs that.
    Constraints that move by themselves are part of Q: theirs is M a + bias less all other forces.
    """
    reference, state = motion.reference, states_at(motion, times)

    def ask(t: np.ndarray, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        return np.transpose(reference.energy(q, v, t))

    from mecanique.motion.compile.derive import energies_of

    parts = StateSums(motion.mechanism, energies_of, ask)(times, state.q, state.v)
    work = _work(motion, state)
    work = work - sum(_losses_at_impacts(motion, times).values())
    kinetic, gravity, springs = parts.T
    loads = _stored_in_loads(motion.mechanism, state.q)
    return Energies(times, kinetic, gravity, springs, loads, work)


def _stored_in_loads(mechanism: Mechanism, q: np.ndarray) -> np.ndarray:
    """Return V of the loads that have a potential, shape (n,) [J]."""
    total = np.zeros(len(q))
    if all(force.conservative for force in mechanism.forces):
        return total
    from mecanique.derivation.scalars.evaluation import Evaluation
    from mecanique.derivation.symbolic.forces import stored_in_loads

    letters = {**mechanism.values, **dict(zip(mechanism.coordinates, q.T, strict=True))}
    for series in stored_in_loads(mechanism).values():
        total = total + Evaluation(series.ring, letters)(series)
    return total


def losses(motion: Trajectory, times: np.ndarray) -> dict[str, np.ndarray]:
    """Return what friction and impacts have taken since the start, each of shape (n,) [J]."""
    lost: dict[str, np.ndarray] = {}
    if motion.corners is not None and motion.corners.rubbing:
        heat = integral(motion.curve, motion.corners.powers, times)
        for name, column in zip(motion.corners.rubbing, heat.T, strict=False):
            lost[f"{name}: friction"] = column
    return lost | _losses_at_impacts(motion, times)


def _losses_at_impacts(motion: Trajectory, times: np.ndarray) -> dict[str, np.ndarray]:
    lost: dict[str, np.ndarray] = {}
    for event in motion.events:
        if event.impact:
            before = motion.reference.energy(event.q, event.v, event.t).total
            after = motion.reference.energy(event.q, event.after, event.t).total
            step = np.where(times >= event.t, before - after, 0.0)
            lost[event.name] = lost.get(event.name, 0.0) + step
    return lost


def is_rheonomic(mechanism: Mechanism) -> bool:
    """Return whether the coordinate map, a potential or a constraint moves by itself."""
    moving = {"t", *(signal.symbol for signal in mechanism.inputs)}
    conservative = [force for force in mechanism.forces if force.conservative]
    constraints = (*mechanism.loops, *mechanism.contacts, *mechanism.velocity_constraints)
    timed = [x for part in (*conservative, *constraints) for x in part.scalars]
    timed += mechanism.coordinates.driven.values()
    driving = any(constraint.rate != 0 for constraint in mechanism.velocity_constraints)
    return driving or any(symbols_in(scalar) & moving for scalar in timed)


def balance_energy(motion: Trajectory, *, whole: bool = False) -> tuple[Energies, ...]:
    """Return the energies of a motion at its samples, or of stretches of a long one.

    Work that has no potential is an integral along the motion, over six states of each step.
    """
    driven = (
        motion.corners is not None or _list_free_forces(motion) or is_rheonomic(motion.mechanism)
    )
    parts = stretches_of(motion) if driven and not whole else [motion]
    return tuple(energies(part, part.t) for part in parts)


def _list_free_forces(motion: Trajectory) -> tuple[AnyForce, ...]:
    """Return the forces of a motion without potential, but for those of elements that switch."""
    described = {force.name for force in motion.described.forces}
    free = [force for force in motion.mechanism.forces if not force.conservative]
    free = [force for force in free if force.name in described]
    if not free:
        return ()
    from mecanique.derivation.symbolic.forces import stored_in_loads

    stored = stored_in_loads(motion.mechanism)
    return tuple(force for force in free if force.name not in stored)


def _work(motion: Trajectory, state: State) -> np.ndarray:
    mechanism, reference = motion.mechanism, motion.reference
    times, free = state.arrays[0], _list_free_forces(motion)
    work: np.ndarray = np.zeros(len(times))
    if motion.corners is not None:
        work = work + integral(motion.curve, motion.corners.powers, times)[:, -1]
    if free:
        from mecanique.reference import Reference

        others = (
            reference
            if len(free) == len(mechanism.forces)
            else Reference(replace(mechanism, forces=free))
        )

        def ask(t: np.ndarray, q: np.ndarray, v: np.ndarray) -> np.ndarray:
            return np.asarray(np.sum(others.forces(q, v, t) * v, axis=1, keepdims=True))

        from mecanique.motion.compile.derive import power_of

        power = StateSums(others.mechanism, power_of, ask)
        work = work + integral(motion.curve, power, times)[:, 0]
    if not is_rheonomic(mechanism):
        return work

    curve, rheonomic = motion.curve, _Rheonomic(mechanism, motion.curve)
    begin = State(*(part[:1] for part in (curve.t, curve.q, curve.v)))
    work = work + integral(curve, rheonomic.power, times)[:, 0]
    if mechanism.constrained and motion.corners is None:
        law = StateLaw(mechanism, reference)

        def hold(t: np.ndarray, q: np.ndarray, v: np.ndarray) -> np.ndarray:
            held = reference.inverse_dynamics(q, v, law.accelerations(t, q, v), t)
            return np.asarray(np.sum(held * v, axis=1, keepdims=True))

        work = work + integral(curve, hold, times)[:, 0]
    carried = rheonomic.carry(*state.arrays) - rheonomic.carry(*begin.arrays)
    return np.asarray(work + carried)


@final
class _Rheonomic:
    """What prescribed motion brings, by a program."""

    def __init__(self, mechanism: Mechanism, curve: Curve) -> None:
        from mecanique.motion.compile.derive import rheonomic_of

        program, inputs = rheonomic_of(mechanism), {s.symbol: s for s in mechanism.inputs}
        self._function, self._width = vectorize(program), len(program.rates)
        self._signals = [inputs[symbol].function(mechanism.values) for symbol in program.more]
        lengths = np.diff(curve.t)[curve.intervals]
        self._step = TIME_STEP * median(lengths) if len(lengths) else 1.0

    def _at(self, t: Array) -> Array:
        """Return the signals at n times, shape (n, signals)."""
        values = np.empty((len(t), len(self._signals)))
        for column, signal in zip(values.T, self._signals, strict=True):
            column[:] = list(map(signal, t.tolist()))
        return values

    def _compute(self, t: Array, q: Array, v: Array) -> Array:
        return compute(self._function, t, (q, v, self._at(t)), self._width)

    def power(self, t: Array, q: Array, v: Array) -> Array:
        """Return −∂L/∂t, shape (n, 1)."""
        values, h = self._compute(t, q, v), self._step
        near, far = (self._at(t + k * h) - self._at(t - k * h) for k in (1, 2))
        total: Array = values[:, 0] + np.sum(values[:, 2:] * (8 * near - far) / (12 * h), axis=1)
        return total[:, None]

    def carry(self, t: Array, q: Array, v: Array) -> Array:
        """Return T₁ + 2 T₀, shape (n,)."""
        return self._compute(t, q, v)[:, 1]
