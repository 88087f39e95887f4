"""Compare linear and exact motion, and find the amplitude at which they differ."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, final

import numpy as np

from mecanique.errors import InputError, IntegrationError
from mecanique.model.expression import finite
from mecanique.motion.linear.differences import drop_disturbances
from mecanique.motion.linear.linearization import Linearization
from mecanique.motion.linear.modes import chosen_mode, linear_solution, slowest, usual_amplitude
from mecanique.motion.record.events import Event
from mecanique.motion.record.motion import Motion
from mecanique.motion.simulation.simulate import simulate

if TYPE_CHECKING:
    from mecanique.reference import Reference


RTOL = 1e-11
"""Relative tolerance of the exact motions."""

SAME = 1e-8
"""Differences below this are the integrator's."""

LONGEST = 20.0
"""A motion that has not returned after this many linear periods is no longer an oscillation."""

ROUNDS = 40
"""Largest number of amplitudes to try."""


@final
@dataclass(frozen=True, eq=False)
class Comparison:
    """A mode by the linear and by the exact equations, started alike.

    For one degree of freedom without damping the difference is that of the periods, relative to the
    linear one; in general it is the largest distance between the two motions within a linear
    period, relative to the amplitude.

    Args:
        linearization: about which state.
        mode: which mode.
        amplitude: of its largest component [rad or m].
        tolerance: the relative difference that `limit` is for.
        limit: the amplitude at which linear and exact motion differ by that; infinite if they never
            do.
        motion: the exact motion, over two linear periods.
        linear: shape (n, nq), the linear motion at the same times.
    """

    linearization: Linearization
    mode: int
    amplitude: float
    tolerance: float
    limit: float
    motion: Motion
    linear: np.ndarray

    @property
    def t(self) -> np.ndarray:
        """Times of both motions, shape (n,) [s]."""
        return self.motion.t

    @property
    def exact(self) -> np.ndarray:
        """The motion by the exact equations, shape (n, nq)."""
        return self.motion.q

    @property
    def linear_period(self) -> float:
        """Period of the linear motion [s]."""
        return _period(self.linearization, self.mode)

    @cached_property
    def exact_period(self) -> float | None:
        """Period of the exact motion; None if it has none, or does not return [s]."""
        if not _periodic(self.linearization):
            return None
        period = _exact_period(self.linearization, self.mode, self.amplitude, self.motion.reference)
        return period if np.isfinite(period) else None

    @cached_property
    def difference(self) -> float:
        """The relative difference; infinite if the exact motion does not return."""
        return _difference(self.linearization, self.mode, self.motion.reference)(self.amplitude)

    @property
    def measure(self) -> str:
        """What the difference is of: "period" or "motion"."""
        return "period" if _periodic(self.linearization) else "motion"

    def __str__(self) -> str:
        largest = int(np.abs(self.linearization.modes[:, self.mode]).argmax())
        name, unit = self.linearization.deviations[largest], self.linearization.units[largest]
        start = f"{name} = {self.amplitude:.6g} {unit}".rstrip()
        lines = [
            f"{self.linearization.mechanism.name}, mode {self.mode + 1}, "
            f"started {start} from the equilibrium"
        ]
        lines.append(f"  linear period {self.linear_period:.9g} s")
        if self.measure == "period":
            period = self.exact_period
            lines.append(
                "  exact period  "
                + ("none: it does not return" if period is None else f"{period:.9g} s")
            )
        lines.append(f"  {self.measure} differs by {self.difference:.3%}")
        if np.isfinite(self.limit):
            wide = f"{self.limit:.6g} {unit}".rstrip()
            lines.append(f"  it differs by {self.tolerance:.3g} from the amplitude {wide} on")
        else:
            lines.append("  linear and exact motion are the same at any amplitude tried")
        return "\n".join(lines)


def compare(
    linearization: Linearization,
    amplitude: float | None = None,
    *,
    mode: int | None = None,
    tolerance: float = 0.01,
) -> Comparison:
    """Return a mode by the linear and by the exact equations side by side.

    Args:
        linearization: about an equilibrium.
        amplitude: of the mode's largest component [rad or m]; by default the one at which they
            differ by `tolerance`.
        mode: which one, 0 for the slowest; by default the slowest that oscillates.
        tolerance: the relative difference for which the amplitude is sought.

    Raises:
        InputError: if there is no such mode, it does not oscillate, the state is no equilibrium, or
            the equations are not smooth there.
    """
    tolerance = finite(tolerance, "the tolerance")
    if not 0 < tolerance < 1:
        raise InputError(f"expected a tolerance in 0…1, got {tolerance:g}")
    if not linearization.at_equilibrium:
        raise InputError(
            "expected a linearization about an equilibrium; look for one with equilibria(mechanism)"
        )
    if linearization.mechanism.constrained:
        raise InputError(
            "expected a mechanism without loops to compare its linear and exact motion"
        )
    from mecanique.reference import Reference

    mode = slowest(linearization) if mode is None else mode
    linearization = replace(linearization, mechanism=drop_disturbances(linearization.mechanism))
    reference = Reference.of(linearization.mechanism)
    usual = usual_amplitude(linearization, mode)
    limit = _limit(_difference(linearization, mode, reference), usual, tolerance)
    if amplitude is None:
        amplitude = limit if np.isfinite(limit) else usual
    amplitude = finite(amplitude, "the amplitude")
    if not amplitude > 0:
        raise InputError(f"expected a positive amplitude, got {amplitude:g}")
    span = 2 * _period(linearization, mode)
    motion = _exact(linearization, mode, amplitude, reference, span, samples=241)
    linear, _, _ = linear_solution(linearization, mode, amplitude, motion.t - linearization.t)
    return Comparison(
        linearization=linearization,
        mode=mode,
        amplitude=amplitude,
        tolerance=tolerance,
        limit=limit,
        motion=motion,
        linear=linear,
    )


def _period(linearization: Linearization, mode: int) -> float:
    root, _ = chosen_mode(linearization, mode)
    return 2 * np.pi / abs(root.imag)


def _periodic(linearization: Linearization) -> bool:
    """Whether every motion is periodic, so that its period can be measured."""
    return len(linearization.M) == 1 and linearization.undamped


def _exact(
    linearization: Linearization,
    mode: int,
    amplitude: float,
    reference: Reference,
    span: float,
    **options: Any,
) -> Motion:
    q, v, _ = linear_solution(linearization, mode, amplitude, np.zeros(1))
    return simulate(
        linearization.mechanism,
        q=q[0],
        v=v[0],
        duration=span,
        t0=linearization.t,
        rtol=RTOL,
        method="dop853",
        reference=reference,
        **options,
    )


def _exact_period(
    linearization: Linearization, mode: int, amplitude: float, reference: Reference
) -> float:
    """Until the velocity is zero again on the side it started from."""
    span = LONGEST * _period(linearization, mode)
    back = Event("back", linearization.mechanism.velocities[0], -1, stop=True)
    motion = _exact(
        linearization,
        mode,
        amplitude,
        reference,
        span,
        events=[back],
        samples=2,
        max_step=span / LONGEST / 8,
    )
    times = motion.times("back")
    return float(times[0]) - linearization.t if len(times) else np.inf


def _difference(
    linearization: Linearization, mode: int, reference: Reference
) -> Callable[[float], float]:
    """The relative difference by amplitude."""
    period = _period(linearization, mode)

    def of_periods(amplitude: float) -> float:
        try:
            return abs(_exact_period(linearization, mode, amplitude, reference) / period - 1)
        except IntegrationError:
            return np.inf

    def of_motions(amplitude: float) -> float:
        try:
            motion = _exact(linearization, mode, amplitude, reference, period, samples=121)
        except IntegrationError:
            return np.inf
        linear, _, _ = linear_solution(linearization, mode, amplitude, motion.t - linearization.t)
        return float(np.abs(motion.q - linear).max()) / amplitude

    return of_periods if _periodic(linearization) else of_motions


def _limit(difference: Callable[[float], float], start: float, tolerance: float) -> float:
    """Return the amplitude of a given difference, by a bounded secant method in logarithms."""
    low, high, amplitude, power = 0.0, np.inf, start / 4, 2.0
    before: tuple[float, float] | None = None
    for _ in range(ROUNDS):
        found = difference(amplitude)
        if np.isfinite(found) and abs(found / tolerance - 1) < 1e-8:
            return amplitude
        if found > tolerance:
            high = min(high, amplitude)
        else:
            low = max(low, amplitude)
        if amplitude > 1e3 * start and found < SAME:
            return np.inf
        if (
            before is not None
            and np.isfinite(found)
            and found > SAME
            and before[1] > SAME
            and amplitude != before[0]
        ):
            slope = np.log(found / before[1]) / np.log(amplitude / before[0])
            power = slope if 0.2 < slope < 8 else power
        if np.isfinite(found):
            before = (amplitude, found)
            amplitude = amplitude * float(
                np.clip((tolerance / max(found, SAME)) ** (1 / power), 0.125, 8)
            )
        else:
            amplitude = (low + high) / 2
        if not low < amplitude < high:
            amplitude = (low + high) / 2 if np.isfinite(high) else 2 * low
        if high < 1e-6 * start:
            raise InputError(
                "the linear and the exact motion differ however small they are: the forces have a "
                "kink there"
            )
        if np.isfinite(high) and high - low < 1e-9 * high:
            break
    # where the difference jumps, e.g. as a spring is turned inside out, steps may just miss it
    return low * (1 - 1e-4) if np.isfinite(high) else np.inf
