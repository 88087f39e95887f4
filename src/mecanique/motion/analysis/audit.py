"""Audit a motion: check its balances, and estimate how far it can be trusted."""

from __future__ import annotations

from dataclasses import dataclass
from html import escape
from typing import TYPE_CHECKING, final

import numpy as np

from mecanique.arrays import spread
from mecanique.errors import InputError, UnknownNameError
from mecanique.motion.analysis.energies import balance_energy
from mecanique.motion.analysis.extremes import find_maxima
from mecanique.motion.compile.along import MANY, StateLaw, StateSums
from mecanique.motion.record.curve import State
from mecanique.motion.record.events import break_names
from mecanique.motion.record.quadrature import POINTS, integral
from mecanique.motion.switching.holding import Holding
from mecanique.motion.tolerances import BALANCED, NO_MOMENTUM, SLACK_CORD, UNCHANGED
from mecanique.motion.trajectory import Trajectory, look_along, stretches_of
from mecanique.wording import Legible, say_count, write_table

if TYPE_CHECKING:
    from mecanique.motion.analysis.trust import Trust

# Balances of linear and angular momentum along a motion.


@final
@dataclass(frozen=True, eq=False, repr=False)
class MomentumBalance(Legible):
    """A balance of momentum along a motion."""

    name: str
    t: np.ndarray  # shape (n,), times [s]
    residual: np.ndarray  # shape (n, 3), difference of the two sides
    size: np.ndarray  # shape (n,), what it is compared with
    unit: str  # SI unit of the residual


_BALANCED = (
    ("linear momentum", "kg·m/s"),
    ("angular momentum about the origin", "kg·m²/s"),
    ("angular momentum about the center of mass", "kg·m²/s"),
)

LENGTH = -(-MANY // POINTS)
"""Steps in a stretch: with the states of each there are just enough for a program to pay."""


def momentum_balances(motion: Trajectory, *, whole: bool = False) -> list[MomentumBalance]:
    """Return the balances of linear and angular momentum.

    The rate of change of momentum is the resultant of the external forces, support reactions
    included: ṗ = F (Fundamentals of Dynamics, eqs. 1.1, 1.2), L̇ₒ = Mₒ about the world's origin
    (eqs. 1.3, 1.10), L̇ = M about the center of mass (eq. 1.12). Both sides are compared
    integrated, p(t) − p(0) − ∫ F dt, which needs no numerical derivative. Impulses of impacts are
    left out. The integral takes six states of each step, so that of a long motion stretches are
    balanced, each from its own start, unless the whole is wanted.
    """
    mechanism = motion.mechanism
    if not any(
        mechanism.evaluate(body.mass) for body in mechanism.bodies if body.name != mechanism.ground
    ):
        return []
    stretches = [motion] if whole else stretches_of(motion, LENGTH)
    parts = zip(*map(_balance, stretches), strict=True)
    residual, scales = map(np.concatenate, parts)
    t = np.concatenate([stretch.t for stretch in stretches])
    return [
        MomentumBalance(name, t, residual[:, 3 * k : 3 * k + 3], scales[:, k], unit)
        for k, (name, unit) in enumerate(_BALANCED)
    ]


def _balance(motion: Trajectory) -> tuple[np.ndarray, np.ndarray]:
    """Return the residuals (n, 9) of a stretch, and the size of each balance (n, 3)."""
    reference, law = motion.reference, StateLaw(motion.mechanism, motion.reference)

    def rates(t: np.ndarray, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        force, moment, center = reference.resultant(q, v, t, law.accelerations(t, q, v))
        about_center = moment - np.cross(center, force)
        sizes = [np.linalg.norm(x, axis=1, keepdims=True) for x in (force, moment, about_center)]
        return np.hstack([force, moment, about_center, *sizes])

    have = np.hstack(reference.momentum(motion.q, motion.v, motion.t))
    sizes = np.linalg.norm(have.reshape(-1, 3, 3), axis=2).max(axis=0)
    duration = float(np.ptp(motion.t)) or 1.0
    pull = np.linalg.norm(motion.mechanism.evaluate_all(motion.mechanism.gravity))
    weight = float(reference.total_mass * pull * duration)
    negligible = UNCHANGED * np.repeat(_scales(sizes, weight), 3) / duration
    given = integral(motion.curve, rates, motion.t, smooth=9, negligible=negligible)
    jumps = np.zeros_like(have)
    for event in motion.events:
        if event.impact:
            before, after = (
                np.hstack(reference.momentum(event.q, v, event.t)) for v in (event.v, event.after)
            )
            jumps += (motion.t >= event.t)[:, None] * (after - before)
    residual = have - have[0] - (jumps - jumps[0]) - given[:, :9]
    scales = _scales(sizes + given[-1, 9:], weight)
    scales[scales == 0] = 1.0
    return residual, np.tile(scales, (len(residual), 1))


def _scales(sizes: np.ndarray, impulse: float) -> np.ndarray:
    """What each momentum is compared with; one that is zero, with what its parts could have.

    Where all are rounding of what bears the weight, that is its impulse.
    """
    largest = max(sizes.max(), impulse if sizes.max() <= NO_MOMENTUM * impulse else 0.0)
    return np.where(sizes > NO_MOMENTUM * largest, sizes, largest)


LIGHT = 299_792_458.0
"""Speed of light in vacuum [m/s] (SI definition)."""

MOST_ASKED = 100
"""Whether loops are closed is asked of the reference at so many steps, and at so many samples."""

GROWTH = 1e4
"""A balance holds if its relative residual is at most this many times the tolerance of a step."""


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
@dataclass(frozen=True, repr=False)
class FrictionNeed(Legible):
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
@dataclass(frozen=True, repr=False)
class Audit(Legible):
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

    @property
    def _caption(self) -> str:
        judged = say_count(len(self.rows), "balance")
        return f"{judged}, {'all' if self.ok else 'not all'} within their limits"

    def __str__(self) -> str:
        width = max(len(row.name) for row in self.rows)
        lines = []
        for name, residual, relative, limit, time, verdict in self._table:
            line = f"{name:<{width}}  {residual:>18}  {relative:>9}  {limit:>7}  {time}  {verdict}"
            lines.append(line.rstrip())
        return "\n".join([*lines, *self._remarks])

    def _repr_html_(self) -> str:
        remarks = "".join(f"<p>{escape(remark)}</p>" for remark in self._remarks)
        return write_table(self._caption, self._table) + remarks

    @property
    def _table(self) -> list[list[str]]:
        """The balances, with a head."""
        rows = [["balance", "residual", "relative", "limit", "at t [s]", ""]]
        for row in self.rows:
            residual = f"{row.residual:.2e} {row.unit}".rstrip()
            numbers = f"{row.relative:.1e}", f"{row.limit:.0e}", f"{row.time:.4g}"
            rows.append([row.name, residual, *numbers, "" if row.ok else "BROKEN"])
        return rows

    @property
    def _remarks(self) -> list[str]:
        """What the audit says below its balances."""
        share = f"{self.speed_of_light_fraction:.1e} of the speed of light"
        remarks = [f"largest speed {self.speed:.4g} m/s, {share}", *map(str, self.friction)]
        return remarks if self.trust is None else [*remarks, str(self.trust)]


def audit(motion: Trajectory, *, refine: bool = False, accuracy: float = 1e-6) -> Audit:
    """Check the balances of energy and momentum of a motion, and that its loops stay closed."""
    if not accuracy > 0:
        raise InputError(f"expected a positive accuracy, got {accuracy!r}")
    from mecanique.motion.analysis.trust import trust
    from mecanique.motion.compile.derive import speeds_of

    def ask_speeds(t: np.ndarray, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        return motion.reference.center_speeds(q, v, t)

    limit = GROWTH * (motion.statistics.rtol + BALANCED)
    seen = look_along(motion)
    parts = balance_energy(seen, whole=refine)
    off = np.concatenate([energy.balance for energy in parts])
    times = np.concatenate([energy.t for energy in parts])
    size = max(energy.scale for energy in parts)
    # of a large potential that hardly changes, what rounding takes is not held against the motion
    stored = max(float(np.abs(energy.potential).max()) for energy in parts)
    rows = [_row("energy", off[:, None], size, limit + BALANCED * stored / size, "J", times)]
    # what holds a velocity constraint is not known
    known = not motion.mechanism.velocity_constraints
    for balance in momentum_balances(seen, whole=refine) if known else ():
        unit, times = balance.unit, balance.t
        rows.append(_row(balance.name, balance.residual, balance.size, limit, unit, times))
    if motion.mechanism.constrained:
        most = motion.statistics.rtol + BALANCED
        of_steps, of_samples = (
            State(m.t[some], m.q[some], m.v[some])
            for m in (seen, motion)
            for some in [spread(len(m.t), MOST_ASKED)]
        )
        # a motion puts states on the loops when it is asked for them; samples are somebody's data
        of_steps = StateLaw(motion.mechanism, motion.reference).close(of_steps)
        t, q, v = map(np.concatenate, zip(of_steps.arrays, of_samples.arrays, strict=True))
        drift = motion.reference.drift(q, v, t)
        speed = 1.0 + float(np.abs(seen.v).max(initial=0.0))
        rows.append(_row("loops, in lengths or radians", drift[:, :1], 1.0, most, "", t))
        rows.append(_row("rates of the loops", drift[:, 1:], speed, most, "1/s", t))
    unmet, needs = _list_unmet(seen)
    speeds = find_maxima(seen.curve, StateSums(motion.mechanism, speeds_of, ask_speeds))
    return Audit(
        (*rows, *unmet),
        float(speeds.values.max(initial=0.0)),
        trust(seen, accuracy) if refine else None,
        needs,
    )


def _list_unmet(motion: Trajectory) -> tuple[list[AuditRow], tuple[FrictionNeed, ...]]:
    """Return the largest push of cords and pull of contacts, and the friction that these need.

    A force that is not known is not held against the motion.
    """
    if not break_names(motion.mechanism):
        return [], ()
    from mecanique.derivation.mechanics.switching import list_holding

    holding = Holding(motion.mechanism, motion.reference)
    first = motion.curve
    names = [*holding.forces(first.t[:1], first.q[:1], first.v[:1])]
    elements = list(list_holding(motion.mechanism, names))

    def measure(t: np.ndarray, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        forces, columns = [*holding.forces(t, q, v).values()], list[np.ndarray]()
        for element in elements:
            force = forces[element.rows[0]]
            friction = np.linalg.norm([forces[k] for k in element.tangents] or force * 0.0, axis=0)
            with np.errstate(all="ignore"):
                ratio = np.where(force > 0, friction / force, np.nan)
            columns += [-force, np.abs(force), ratio]
        return np.column_stack(columns)

    rows, needs = list[AuditRow](), list[FrictionNeed]()
    largest, times = (part.reshape(-1, 3) for part in find_maxima(motion.curve, measure))
    for element, (wrong, size, ratio), when in zip(elements, largest, times, strict=True):
        force = max(float(np.nan_to_num(wrong)), 0.0)
        relative = force / (float(np.nan_to_num(size)) or 1.0)
        words = f"push of {names[element.rows[0]]}, slack"
        if element.tangents:
            words = f"pull of {element.name}, off"
            needs.append(FrictionNeed(element.name, float(ratio), float(when[2])))
        time = float(np.nan_to_num(when[0]))
        rows.append(AuditRow(words, force, relative, SLACK_CORD, "N", time))
    return rows, tuple(needs)


def _row(
    name: str,
    residual: np.ndarray,
    scale: float | np.ndarray,
    limit: float,
    unit: str,
    t: np.ndarray,
) -> AuditRow:
    size = np.linalg.norm(residual, axis=1)
    relative = size / scale
    worst = int(relative.argmax())
    return AuditRow(name, float(size[worst]), float(relative[worst]), limit, unit, float(t[worst]))
