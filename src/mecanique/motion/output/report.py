"""A motion in a few lines of text."""

from __future__ import annotations

from math import ceil, inf, log10
from typing import TYPE_CHECKING

from mecanique.errors import MecaniqueError
from mecanique.model.mechanism_units import add_unit, units
from mecanique.motion.analysis.energies import balance_energy, losses
from mecanique.motion.analysis.extremes import find_bounds, find_exceeded
from mecanique.motion.analysis.trust import estimate_errors
from mecanique.motion.trajectory import look_along
from mecanique.wording import LegibleText, say_count

if TYPE_CHECKING:
    from mecanique.motion.trajectory import Trajectory


LONG = 1200
"""With so many steps a motion states how far its errors may have added up."""

MAX_LISTED = 12
"""Most coordinates that are listed."""


def summary(motion: Trajectory) -> str:
    """Return a summary: mechanism, duration, method and energy balance."""
    mechanism, statistics = motion.mechanism, motion.statistics
    seen = look_along(motion)
    parts = balance_energy(seen)
    size = max(energy.scale for energy in parts)
    off = max(float(abs(energy.balance).max()) for energy in parts) / size
    first, last = parts[0].total[0], parts[-1].total[-1]
    change, where = f"{parts[-1].work[-1]:.6g} J of work since", ""
    if len(parts) > 1:
        change, where = f"{last:.6g} J at the end", f" in {len(parts)} stretches"
    lines = [
        f"motion of {mechanism.name}: t = {motion.t[0]:g}…{motion.t[-1]:g} s, "
        f"{say_count(len(motion.t), 'sample')}",
        f"method: {motion.method}",
        f"        rtol {statistics.rtol:g}, atol {statistics.atol:g}; "
        f"{say_count(statistics.steps, 'step')}, "
        f"{say_count(statistics.evaluations, 'evaluation')}, {statistics.seconds:.3g} s",
        f"energy: {first:.6g} J at the start, {change}; balance within {off:.1e} (relative){where}",
    ]
    for name, lost in losses(motion, motion.t[-1:]).items():
        lines.append(f"        of that, {name}: {lost[0]:.6g} J lost")
    unit = units(mechanism)
    names = (*mechanism.coordinates.names, *mechanism.velocities)
    bounds = find_bounds(seen)
    errors, unknown = _errors(motion)
    for name, low, high, error in zip(
        names[:MAX_LISTED], -bounds[len(names) :], bounds, errors, strict=False
    ):
        lines.append(
            f"{add_unit(name, unit[name]):>14}: {low:.6g} … {high:.6g}, "
            f"at the end {say_uncertain(float(motion[name][-1]), error)}"
        )
    if len(names) > MAX_LISTED:
        lines.append(f"{'…':>14}  {len(names) - MAX_LISTED} more")
    if unknown:
        lines.append(f"errors of these values are not known: {unknown}")
    passed = find_exceeded(seen)
    lines += [str(exceeded) for exceeded in passed[:MAX_LISTED]]
    if len(passed) > MAX_LISTED:
        lines.append(f"… and {len(passed) - MAX_LISTED} joints more pass theirs")
    for event in motion.events[:MAX_LISTED]:
        lines.append(f"event {event}")
    return LegibleText("\n".join(lines))


def _errors(motion: Trajectory) -> tuple[list[float], str]:
    """Return how far each of (q, v) of a long motion may be off, or zeros and why it is unknown."""
    none = [0.0] * (motion.mechanism.nq + motion.mechanism.nv)
    if motion.statistics.steps < LONG:
        return none, ""
    if motion.corners is not None:
        return none, "motions with corners are integrated once"
    if motion.watched is None:
        return none, "the motion was read from a file, without the events it was watched for"
    try:
        return [float(error) for error in estimate_errors(motion)], ""
    except MecaniqueError as error:  # what was integrated once need not be so again
        return none, str(error)


def say_uncertain(value: float, error: float) -> str:
    """Write a number with its error, to the digits that this leaves; to 9 if it is not known."""
    if not 0 < error < inf:
        return f"{value:.9g}"
    digits = ceil(log10(max(abs(value) / error, 1e-3))) + 1
    return f"{value:.{min(max(digits, 1), 15)}g} ± {error:.1g}"
