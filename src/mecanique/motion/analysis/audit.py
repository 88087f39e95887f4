"""Audit a motion: check its balances, and estimate how far it can be trusted."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, final

import numpy as np

from mecanique.errors import InputError, UnknownNameError
from mecanique.motion.simulation.watching.validity import Pressing, pressings

if TYPE_CHECKING:
    from mecanique.motion.analysis.trust import Trust
    from mecanique.motion.record.trajectory import Trajectory


_SLACK = 1e-9
"""A cord that would have to push by this part of its largest tension is slack."""

LIGHT = 299_792_458.0
"""Speed of light in vacuum [m/s] (SI definition)."""

GROWTH = 1e4
"""A balance holds if its relative residual is at most this many times the tolerance of a step."""

ROUNDING = 1e-13
"""Relative residuals below GROWTH times this are never held against a motion."""


@final
@dataclass(frozen=True)
class AuditRow:
    """One balance.

    Args:
        name: what is balanced, or stays zero.
        residual: largest deviation along the motion, in the unit.
        relative: the same, compared with the size of the quantities that balance.
        limit: what `relative` may be.
        unit: SI unit of the residual.
        time: when it is largest [s].
    """

    name: str
    residual: float
    relative: float
    limit: float
    unit: str
    time: float

    @property
    def ok(self) -> bool:
        """Whether the balance holds."""
        return bool(self.relative <= self.limit)


@final
@dataclass(frozen=True)
class FrictionNeed:
    """The coefficient of friction that a contact needs along a motion.

    Args:
        contact: its name.
        coefficient: largest ratio of friction to normal force; NaN where that is undetermined.
        time: when it is largest [s].
    """

    contact: str
    coefficient: float
    time: float

    def __str__(self) -> str:
        if np.isnan(self.coefficient):
            return f"friction at {self.contact}: undetermined, other contacts share it"
        return (
            f"friction at {self.contact}: needs a coefficient of {self.coefficient:.4g}, "
            f"at t = {self.time:.4g} s"
        )


@final
@dataclass(frozen=True)
class Audit:
    """The result of auditing a motion; its text is a table.

    Args:
        rows: the balances.
        speed: largest speed of a body's center of mass [m/s].
        trust: until when the motion can be trusted, if it was asked for.
        friction: what each body that rolls needs not to slip.

    Example:
        >>> pendulum = mq.textbook.load("rigid_bar_pendulum")
        >>> audit = mq.simulate(pendulum, q={"q": 2.0}, duration=1.0).audit()
        >>> audit.ok
        True
        >>> audit.rows[0].name, audit.rows[0].relative < 1e-8
        ('energy', True)
    """

    rows: tuple[AuditRow, ...]
    speed: float
    trust: Trust | None = None
    friction: tuple[FrictionNeed, ...] = ()

    @property
    def ok(self) -> bool:
        """Whether every balance holds and no speed comes near that of light."""
        return all(row.ok for row in self.rows) and self.speed_of_light_fraction < 0.01

    @property
    def speed_of_light_fraction(self) -> float:
        """The largest speed as a fraction of the speed of light."""
        return self.speed / LIGHT

    def __getitem__(self, name: str) -> AuditRow:
        for row in self.rows:
            if row.name == name:
                return row
        raise UnknownNameError("balance", name, (row.name for row in self.rows))

    def __str__(self) -> str:
        width = max(len(row.name) for row in self.rows)
        lines = [f"{'balance':<{width}}  {'residual':>18}  {'relative':>9}  {'limit':>7}  at t [s]"]
        for row in self.rows:
            verdict = "" if row.ok else "  BROKEN"
            residual = f"{row.residual:.2e} {row.unit}".rstrip()
            lines.append(
                f"{row.name:<{width}}  {residual:>18}  {row.relative:9.1e}  {row.limit:7.0e}  "
                f"{row.time:.4g}{verdict}"
            )
        lines.append(
            f"largest speed {self.speed:.4g} m/s, {self.speed_of_light_fraction:.1e} of the speed "
            "of light"
        )
        lines += map(str, self.friction)
        if self.trust is not None:
            lines.append(str(self.trust))
        return "\n".join(lines)


def audit(motion: Trajectory, *, refine: bool = False, accuracy: float = 1e-6) -> Audit:
    """Check the balances of energy and momentum of a motion, and that its loops stay closed.

    Args:
        motion: the motion.
        refine: also integrate again with a smaller tolerance.
        accuracy: the error that is then accepted, relative to the largest coordinate.

    Raises:
        InputError: if the accuracy is not positive.
    """
    if not accuracy > 0:
        raise InputError(f"expected a positive accuracy, got {accuracy!r}")
    from mecanique.motion.analysis.momentum import momentum_balances
    from mecanique.motion.analysis.trust import trust

    limit = GROWTH * (motion.statistics.rtol + ROUNDING)
    energy = motion.energy()
    rows = [_row("energy", energy.balance[:, None], energy.scale, limit, "J", motion.t)]
    # what holds a velocity constraint is not known
    known = not motion.mechanism.velocity_constraints
    for one in momentum_balances(motion) if known else ():
        rows.append(_row(one.name, one.residual, one.size, limit, one.unit, motion.t))
    if motion.mechanism.constrained:
        most = motion.statistics.rtol + ROUNDING
        drift = motion.reference.drift(motion.q, motion.v, motion.t)
        speed = 1.0 + float(np.abs(motion.v).max(initial=0.0))
        rows.append(_row("loops, in lengths or radians", drift[:, :1], 1.0, most, "", motion.t))
        rows.append(_row("rates of the loops", drift[:, 1:], speed, most, "1/s", motion.t))
    rows += _pulls(motion)
    pressed = pressings(motion.reference, motion.q, motion.v, motion.t)
    rows += _lifts(motion, pressed)
    return Audit(
        tuple(rows),
        _largest_speed(motion),
        trust(motion, accuracy) if refine else None,
        tuple(_need(motion, each) for each in pressed),
    )


def _lifts(motion: Trajectory, pressed: tuple[Pressing, ...]) -> Iterator[AuditRow]:
    """The largest pull a contact would need where a body would leave the ground."""
    for each in pressed:
        pull = np.maximum(-np.nan_to_num(each.normal), 0.0)[:, None]
        size = float(np.nan_to_num(np.abs(each.normal)).max(initial=0.0)) or 1.0
        yield _row(f"pull of {each.contact.name}, off", pull, size, _SLACK, "N", motion.t)


def _need(motion: Trajectory, pressed: Pressing) -> FrictionNeed:
    """The largest ratio of friction to normal force where the contact presses."""
    with np.errstate(all="ignore"):
        ratio = np.where(pressed.normal > 0, pressed.friction / pressed.normal, np.nan)
    name = pressed.contact.name
    if np.isnan(ratio).all():
        return FrictionNeed(name, float("nan"), float("nan"))
    worst = int(np.nanargmax(ratio))
    return FrictionNeed(name, float(ratio[worst]), float(motion.t[worst]))


def _pulls(motion: Trajectory) -> Iterator[AuditRow]:
    """The largest push a cord would need where it would go slack."""
    names = [name for element in motion.mechanism.elements for name in element.tensions]
    forces = motion.guide_forces() if names else {}
    for name in names:
        push = np.maximum(-forces[name], 0.0)[:, None]
        size = float(np.abs(forces[name]).max(initial=0.0)) or 1.0
        yield _row(f"push of {name}, slack", push, size, _SLACK, "N", motion.t)


def _row(
    name: str, residual: np.ndarray, scale: float, limit: float, unit: str, t: np.ndarray
) -> AuditRow:
    size = np.linalg.norm(residual, axis=1)
    worst = int(size.argmax())
    return AuditRow(
        name, float(size[worst]), float(size[worst]) / scale, limit, unit, float(t[worst])
    )


def _largest_speed(motion: Trajectory) -> float:
    """The largest speed of a body's center of mass."""
    speeds = motion.reference.center_speeds(motion.q, motion.v, motion.t)
    return float(speeds.max(initial=0.0))
