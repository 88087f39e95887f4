"""Check the arguments of `simulate`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TypeAlias

import numpy as np

from mecanique.errors import InputError
from mecanique.model.expression import finite
from mecanique.model.mechanism import Mechanism
from mecanique.model.parameters import Record
from mecanique.motion.record.events import Event

Values: TypeAlias = Sequence[float] | np.ndarray | Mapping[str, float]
"""Numbers in order, or by name."""


def refuse_still(mechanism: Mechanism) -> None:
    """Raise if a mechanism has no coordinate."""
    if not mechanism.nv:
        raise InputError(
            f"mechanism {mechanism.name!r} has no coordinate, so nothing in it can be set in motion"
        )


def span_and_tolerances(
    t0: float, duration: float, rtol: float, atol: float | None
) -> tuple[float, float, float, float]:
    """Return start, end and tolerances, checked."""
    t0, duration = finite(t0, "the start time t0"), finite(duration, "the duration")
    if not duration > 0:
        raise InputError(f"expected a positive duration [s], got {duration:g}")
    if not t0 + duration * 1e-6 > t0:
        raise InputError(
            "expected a duration that is not lost beside the start time, "
            f"got {duration:g} at {t0:g} s"
        )
    rtol = finite(rtol, "the relative tolerance rtol")
    if not 1e-14 <= rtol <= 0.1:
        raise InputError(f"expected a relative tolerance rtol in 1e-14…0.1, got {rtol:g}")
    atol = rtol if atol is None else finite(atol, "the absolute tolerance atol")
    if not atol > 0:
        raise InputError(f"expected a positive absolute tolerance atol, got {atol:g}")
    return t0, t0 + duration, rtol, atol


MOST_SAMPLES = 1e8
"""Of a motion; ten coordinates of as many take 8 GB each of positions and velocities."""


def sample_times(
    t0: float, end: float, fps: float, samples: int | Sequence[float] | np.ndarray | None
) -> np.ndarray:
    """Return the times of the samples, shape (n,) [s]."""
    if samples is None:
        fps = finite(fps, "the samples per second fps")
        if not fps > 0:
            raise InputError(f"expected a positive number of samples per second fps, got {fps:g}")
        count = (end - t0) * fps
        if count > MOST_SAMPLES:
            raise InputError(
                f"expected fewer than {MOST_SAMPLES:,.0f} samples, got {count:.3g}; choose a "
                "smaller fps"
            )
        whole = int(np.ceil(count - 1e-6))
        times: np.ndarray = t0 + np.arange(whole + 1) / fps
        times[-1] = end
        return times
    if isinstance(samples, (int, np.integer)) and not isinstance(samples, bool):
        if samples < 2:
            raise InputError(f"expected at least 2 samples, got {samples}")
        if samples > MOST_SAMPLES:
            raise InputError(f"expected at most {MOST_SAMPLES:g} samples, got more")
        return np.array([t0, end]) if samples == 2 else np.linspace(t0, end, int(samples))
    try:
        times = np.array(samples, dtype=float)
    except (TypeError, ValueError, OverflowError):
        raise InputError(f"expected a number of samples or their times, got {samples!r}") from None
    if (
        times.ndim != 1
        or not len(times)
        or not np.isfinite(times).all()
        or (np.diff(times) <= 0).any()
    ):
        raise InputError("expected increasing finite sample times, shape (n,)")
    if times[0] < t0 or times[-1] > end:
        raise InputError(
            f"expected sample times in {t0:g}…{end:g} s, got {times[0]:g}…{times[-1]:g} s"
        )
    return times


def longest_step(
    mechanism: Mechanism, span: float, given: float | None, events: Sequence[Event]
) -> float:
    """Return the longest step that the integrator may take [s]."""
    if given is not None:
        given = finite(given, "the longest step max_step")
        if not given > 0:
            raise InputError(f"expected a positive longest step max_step [s], got {given:g}")
        return given
    for event in events:
        if not isinstance(event, Event):
            raise InputError(f"expected events of type Event, got {event!r}")
    blind = any(callable(i.signal) and not isinstance(i.signal, Record) for i in mechanism.inputs)
    return span / 50 if blind or events else float("inf")


def kinks(mechanism: Mechanism, t0: float, end: float) -> list[float]:
    """Return the times at which a sampled input has a kink [s]; no step may reach across."""
    records = [i.signal.times for i in mechanism.inputs if isinstance(i.signal, Record)]
    if not records:
        return []
    times = np.unique(np.concatenate(records))
    least = 1e-9 * (end - t0)
    inside: list[float] = times[(times > t0 + least) & (times < end - least)].tolist()
    return inside
