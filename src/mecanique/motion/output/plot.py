"""Plots of a motion, by matplotlib."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from mecanique.errors import InputError, UnknownNameError
from mecanique.model.mechanism_units import add_unit, units
from mecanique.motion.analysis.energies import energies
from mecanique.motion.tolerances import FLAT_CURVE
from mecanique.motion.trajectory import Trajectory


def plot(motion: Trajectory, what: str = "coordinates", joint: str | None = None) -> Any:
    """Plot a motion; return the matplotlib Figure, which no window shows yet."""
    kinds: dict[str, Callable[[Trajectory, Any, str | None], None]] = {
        "coordinates": _coordinates,
        "phase": _phase,
        "energies": _energies,
        "reactions": _reactions,
    }
    if what not in kinds:
        raise UnknownNameError("plot", what, kinds)
    figure = new_figure(figsize=(8, 5))
    kinds[what](motion, figure, joint)
    return figure


def new_figure(**options: Any) -> Any:
    """Return an empty matplotlib Figure, which a notebook shows."""
    try:
        from mecanique.motion.output.shown import ShownFigure
    except ImportError:
        raise InputError(
            "plots need matplotlib; install it with: pip install 'mecanique[plot]'"
        ) from None
    return ShownFigure(layout="constrained", **options)


def _coordinates(motion: Trajectory, figure: Any, joint: str | None) -> None:
    m, unit = motion.mechanism, units(motion.mechanism)
    groups = (m.coordinates.names, m.velocities)
    for axes, names in zip(figure.subplots(2, 1, sharex=True), groups, strict=True):
        for name in names:
            axes.plot(motion.t, motion[name], label=add_unit(name, unit[name]), linewidth=1)
        shared = {unit[name] for name in names}
        text = ", ".join(names) if len(names) <= 4 else f"{names[0]} … {names[-1]}"
        axes.set_ylabel(add_unit(text, shared.pop()) if len(shared) == 1 else text)
    _finish_over_time(figure, m.name)


def _phase(motion: Trajectory, figure: Any, joint: str | None) -> None:
    m, unit = motion.mechanism, units(motion.mechanism)
    pairs = [(name, f"{name}'") for name in m.coordinates if f"{name}'" in m.velocities]
    if not pairs:
        raise InputError(
            f"mechanism {m.name!r} has no coordinate whose rate is a velocity; "
            "expected one for a phase plot"
        )
    columns = int(np.ceil(np.sqrt(len(pairs))))
    grid = figure.subplots(int(np.ceil(len(pairs) / columns)), columns, squeeze=False).ravel()
    for axes, (name, rate) in zip(grid, pairs, strict=False):
        axes.plot(motion[name], motion[rate], linewidth=1)
        axes.plot(motion[name][:1], motion[rate][:1], "o", markersize=4)
        axes.set_xlabel(add_unit(name, unit[name]))
        axes.set_ylabel(add_unit(rate, unit[rate]))
        axes.grid(alpha=0.3)
    for axes in grid[len(pairs) :]:
        axes.set_axis_off()
    figure.suptitle(f"{m.name}, phase portrait")


def _energies(motion: Trajectory, figure: Any, joint: str | None) -> None:
    energy = energies(motion, motion.t)
    axes = figure.subplots()
    for name, values in (
        ("kinetic", energy.kinetic),
        ("gravity", energy.gravity),
        ("springs", energy.springs),
        ("loads", energy.loads),
        ("total", energy.total),
        ("work done on it", energy.work),
    ):
        if name in ("kinetic", "total") or np.abs(values).max() > 0:
            axes.plot(motion.t, values, label=name, linewidth=2 if name == "total" else 1)
    axes.set_ylabel("energy [J]")
    _finish_over_time(figure, motion.mechanism.name)


def _reactions(motion: Trajectory, figure: Any, joint: str | None) -> None:
    m = motion.mechanism
    if joint is None:
        if not m.joints:
            raise InputError(
                f"mechanism {m.name!r} has no joint; expected one for a plot of reactions"
            )
        joint = m.joints[0].name
    wrench = motion.reactions(joint)
    for axes, (what, unit, values) in zip(
        figure.subplots(2, 1, sharex=True),
        (("force", "N", wrench.force), ("moment", "N·m", wrench.moment)),
        strict=True,
    ):
        for k, direction in enumerate("xyz"):
            axes.plot(motion.t, values[:, k], label=direction, linewidth=1)
        if np.abs(values).max() < FLAT_CURVE * (1 + np.abs(wrench.force).max()):
            axes.set_ylim(-1, 1)  # nothing but rounding: not worth a closer look
        axes.set_ylabel(f"{what} [{unit}]")
    title = f"{m.name}: {m.joint(joint).parent} on {m.joint(joint).child} at {joint!r}, world axes"
    if wrench.reason:
        title += f"\nundetermined: {', '.join(wrench.undetermined)}"
    _finish_over_time(figure, title)


def _finish_over_time(figure: Any, title: str) -> None:
    for axes in figure.axes:
        axes.legend(loc="upper right", fontsize="small")
        axes.grid(alpha=0.3)
    figure.axes[-1].set_xlabel("t [s]")
    figure.suptitle(title)
