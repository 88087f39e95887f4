"""Turn a mode into a motion: the linear solution, large enough to see."""

from __future__ import annotations

from time import perf_counter

import numpy as np

from mecanique.errors import InputError
from mecanique.model.expression import finite
from mecanique.motion.linear.linearization import Linearization
from mecanique.motion.record.curve import Curve
from mecanique.motion.record.motion import Motion
from mecanique.motion.record.rates import Rates
from mecanique.motion.record.statistics import Statistics
from mecanique.motion.simulation.arguments import sample_times

NODES = 32
"""Points per period between which the linear motion is interpolated."""

TICK = 1e-4
"""Step, in periods, of the differences that give the rates of a mode with loops."""

ANGLE = 0.2
"""Amplitude that is easily seen [rad]."""


def mode_motion(
    linearization: Linearization,
    mode: int | None,
    amplitude: float | None,
    *,
    periods: float,
    fps: float,
) -> Motion:
    """Return a mode as a motion.

    Args:
        linearization: about which state.
        mode: which one, 0 for the slowest; None for the slowest that oscillates.
        amplitude: of the mode's largest component [rad or m], or None for one that is easily seen.
        periods: how many periods.
        fps: samples per second.

    Raises:
        InputError: if there is no such mode, or it does not oscillate.
    """
    begin = perf_counter()
    mode = slowest(linearization) if mode is None else mode
    root, _ = chosen_mode(linearization, mode)
    size = (
        usual_amplitude(linearization, mode)
        if amplitude is None
        else finite(amplitude, "the amplitude")
    )
    period = 2 * np.pi / abs(root.imag)
    duration = finite(periods, "the number of periods") * period
    if not duration > 0:
        raise InputError(f"expected a positive number of periods, got {periods!r}")
    nodes = np.linspace(0.0, duration, max(5, int(np.ceil(duration / period * NODES)) + 1))
    mechanism, rates = linearization.mechanism, Rates.of(linearization.mechanism)
    q, v, a = _closed_solution(linearization, mode, size, nodes)
    curve = Curve(t=nodes, q=q, v=v, a=a, breaks=np.array([0]), rates=rates)
    times = sample_times(0.0, duration, fps, None)
    q, v, _ = _closed_solution(linearization, mode, size, times)
    frequency = abs(root.imag) / (2 * np.pi)
    text = f"mode {mode + 1} of the linear equations, {frequency:.6g} Hz, amplitude {size:.4g}"
    statistics = Statistics(0, 0, perf_counter() - begin, 0.0, 0.0)
    return Motion(
        mechanism=mechanism, t=times, q=q, v=v, path=curve, method=text, statistics=statistics
    )


def slowest(linearization: Linearization) -> int:
    """Return the slowest mode that oscillates.

    Args:
        linearization: about which state.

    Raises:
        InputError: if there is none.
    """
    moving = np.flatnonzero((linearization.frequencies > 0) & (np.abs(linearization.damping) < 1))
    if not len(moving):
        raise InputError(f"no mode of {linearization.mechanism.name!r} oscillates there")
    return int(moving[0])


def chosen_mode(linearization: Linearization, mode: int) -> tuple[complex, np.ndarray]:
    """Return exponent λ and shape of a mode that oscillates.

    Args:
        linearization: about which state.
        mode: which one, 0 for the slowest.

    Raises:
        InputError: if there is no such mode, or it does not oscillate.
    """
    count = len(linearization.M)
    if isinstance(mode, bool) or not isinstance(mode, (int, np.integer)) or not 0 <= mode < count:
        raise InputError(f"expected a mode in 0…{count - 1}, 0 for the slowest, got {mode!r}")
    omega, zeta = float(linearization.frequencies[mode]), float(linearization.damping[mode])
    if not omega > 0 or not abs(zeta) < 1:
        raise InputError(f"mode {mode} of {linearization.mechanism.name!r} does not oscillate")
    return complex(-zeta * omega, omega * np.sqrt(1 - zeta**2)), linearization.modes[:, mode]


def linear_solution(
    linearization: Linearization, mode: int, amplitude: float, t: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return q, v and v̇ of the linear motion in one mode, δ = A Re(shape e^(λt)).

    Args:
        linearization: about which state.
        mode: which one.
        amplitude: A.
        t: shape (n,) [s].
    """
    root, shape = chosen_mode(linearization, mode)
    waves = amplitude * np.exp(root * t)[:, None] * shape
    rates = Rates.of(linearization.mechanism)
    at = np.repeat(linearization.q[None], len(t), axis=0)
    q = rates.normalize(rates.displace(at, waves.real))
    return q, (root * waves).real, (root**2 * waves).real


def _closed_solution(
    linearization: Linearization, mode: int, amplitude: float, t: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the linear motion with its loops closed; wide straight deviations open them."""
    from mecanique.reference import Reference
    from mecanique.reference.loops.assembly.closing import close_position

    loops, rates = Reference.of(linearization.mechanism).closed, Rates.of(linearization.mechanism)
    if loops is None:
        return linear_solution(linearization, mode, amplitude, t)
    h = TICK * 2 * np.pi / abs(chosen_mode(linearization, mode)[0].imag)

    def place(shift: float) -> np.ndarray:
        straight, _, _ = linear_solution(linearization, mode, amplitude, t + shift)
        return np.array([close_position(loops, q, linearization.t) for q in straight])

    before, q, after = place(-h), place(0.0), place(h)
    v = rates.velocities(q, (after - before) / (2 * h))
    a = rates.velocities(q, (after - 2 * q + before) / h**2)
    return q, v, a


def usual_amplitude(linearization: Linearization, mode: int) -> float:
    """Return an amplitude that is easily seen: 0.2 rad, or 0.2 characteristic lengths.

    Args:
        linearization: about which state.
        mode: which one.
    """
    _, shape = chosen_mode(linearization, mode)
    length = _length(linearization)
    reach = np.array([length if unit == "m" else 1.0 for unit in linearization.units])
    return ANGLE * float((reach / np.abs(shape).clip(1e-12)).min())


def _length(linearization: Linearization) -> float:
    from mecanique.model.units import characteristic_length

    return float(characteristic_length(linearization.mechanism))
