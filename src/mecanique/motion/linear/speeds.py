"""Steady motions over their speed: exponents, limits of stability, M, C and K."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple, final

import numpy as np

from mecanique.derivation.steady import SteadyLetters, steady_letters
from mecanique.errors import InputError, MecaniqueError
from mecanique.model.mechanism import Mechanism
from mecanique.model.mechanism.letters import to_name
from mecanique.model.values import Given
from mecanique.motion.linear.steady import (
    SteadyLinearization,
    by_real_part,
    drop_noise,
    linearize_steady,
    write_exponent,
)
from mecanique.motion.output.plot import new_figure
from mecanique.motion.tolerances import AGREES, ALIKE, FITS, SAME_SPEED, STABLE
from mecanique.textbook import entry
from mecanique.textbook.catalogue import is_known
from mecanique.wording import Legible

if TYPE_CHECKING:
    from matplotlib.figure import Figure


_SAMPLED = (0.5, 1.0, 2.0)
"""Speeds at which the matrices are computed, for the polynomials through them."""

_CHECKED = 1.5
"""Speed at which they are computed again."""


_MOST_KNOWN = 8
"""No polynomial goes through more of them."""


@final
@dataclass(frozen=True, repr=False)
class SpeedRange(Legible):
    """The exponents of a steady motion over its speed; its text is a table.

    Args:
        mechanism: what moves.
        speeds: shape (n,), factors of the velocities given.
        eigenvalues: shape (n, k), the exponents, by real part [1/s].
        limits: speeds at which the motion becomes stable or ceases to be.

    Example:
        >>> coin = mq.textbook.load("rolling_coin")
        >>> rolling = mq.sweep_speeds(coin, {"z": coin.values["r"]}, {"spin": 1.0}, [5.0, 10.0])
        >>> bool(rolling.eigenvalues.real.max() < 1e-6)
        True
    """

    mechanism: Mechanism
    speeds: np.ndarray
    eigenvalues: np.ndarray
    limits: tuple[float, ...]

    def __str__(self) -> str:
        lines = [f"{self.mechanism.name}: exponents of small deviations [1/s] by speed"]
        for speed, values in zip(self.speeds, self.eigenvalues, strict=True):
            cells = "  ".join(f"{write_exponent(x):>22}" for x in drop_noise(values))
            lines.append(f"{speed:>10.4g}  {cells}")
        limits = ", ".join(f"{limit:.9g}" for limit in self.limits) or "none in this range"
        return "\n".join([*lines, f"stability changes at: {limits}"])

    def plot(self) -> Figure:
        """Return real and imaginary parts over the speed, with the limits of stability.

        Raises:
            InputError: if matplotlib is not installed.
        """
        figure: Figure = new_figure()
        axes = figure.subplots()
        axes.plot(self.speeds, self.eigenvalues.real, "C0.", markersize=3)
        axes.plot(self.speeds, np.abs(self.eigenvalues.imag), "C1.", markersize=3)
        for limit in self.limits:
            axes.axvline(limit, color="0.7", linewidth=1)
        axes.axhline(0, color="0", linewidth=0.5)
        axes.set_xlabel("speed")
        axes.set_ylabel("Re λ (blue), |Im λ| (orange) [1/s]")
        return figure


def sweep_speeds(
    mechanism: Mechanism,
    at: Given,
    v: Mapping[str, float],
    speeds: Iterable[float],
    *,
    by: Sequence[str] = (),
) -> SpeedRange:
    """Linearize about steady motions of several speeds; find where stability changes.

    Args:
        mechanism: what moves.
        at: positions, shape (nq,) or by name.
        v: velocities at speed 1, by name.
        speeds: factors of these velocities, in ascending order.
        by: names of coordinates that are to be independent.

    Returns:
        The exponents at each speed, and at which speeds stability changes.

    Raises:
        InputError: if there are not at least two speeds, or a motion is not steady.

    Example:
        >>> coin = mq.textbook.load("rolling_coin")
        >>> rolling = mq.sweep_speeds(coin, {"z": coin.values["r"]}, {"spin": 1.0}, [5.0, 10.0])
        >>> rolling.limits
        ()
    """
    given = np.array(list(speeds), dtype=float)
    if len(given) < 2 or not (np.diff(given) > 0).all():
        raise InputError(f"expected at least two speeds in ascending order, got {given.tolist()}")

    def linearize(speed: float) -> SteadyLinearization:
        moving = {name: speed * rate for name, rate in v.items()}
        return linearize_steady(mechanism, at, moving, by=by)

    linearizations = [linearize(speed) for speed in given]
    limits = []
    for k in range(len(given) - 1):
        ends = linearizations[k : k + 2]
        kinds = [np.sign(x) if abs(x) > STABLE else 0.0 for x in map(_growth, ends)]
        if kinds[0] != kinds[1]:
            # without damping nothing decays: what counts as zero divides growth from oscillation
            limits.append(_find_limit(linearize, given[k : k + 2], ends, STABLE * sum(kinds)))
    exponents = np.array([steady.exponents for steady in linearizations])
    return SpeedRange(mechanism, given, exponents, tuple(limits))


_Linearized = Callable[[float], SteadyLinearization]
"""A steady motion linearized, by its speed."""


def _find_limit(
    linearize: _Linearized, between: np.ndarray, ends: list[SteadyLinearization], margin: float
) -> float:
    """Find the speed between two at which the growth is `margin`.

    The polynomial in the speed through the matrices A known so far gives a guess. If A agrees with
    the polynomial there, the guess is right; otherwise it adds one more known matrix. An A that is
    quadratic in the speed, as in motion straight ahead, takes two guesses. Where other deviations
    become idle between the speeds, A itself is computed at every step of the search.
    """
    from scipy.optimize import brentq

    def solve(by_speed: _Linearized) -> float:
        def height(speed: float) -> float:
            return _growth(by_speed(speed)) - margin

        return float(brentq(height, between[0], between[1], xtol=SAME_SPEED, rtol=SAME_SPEED))

    speeds, known = list(between), ends
    while len(known) < _MOST_KNOWN and len({(*s.positions, s.idle) for s in known}) == 1:
        through = _interpolate(np.array(speeds), known)
        limit = solve(through)
        there = linearize(limit)
        if np.abs(there.A - through(limit).A).max() <= AGREES * np.abs(there.A).max():
            return limit
        speeds, known = [*speeds, limit], [*known, there]
    return solve(linearize)


def _interpolate(speeds: np.ndarray, known: Sequence[SteadyLinearization]) -> _Linearized:
    """Return the polynomial in the speed through matrices A (Lagrange)."""
    matrices = np.array([steady.A for steady in known])
    apart = speeds[:, None] - speeds + np.eye(len(speeds))

    def at(speed: float) -> SteadyLinearization:
        parts = np.where(np.eye(len(speeds)), 1.0, (speed - speeds) / apart)
        return replace(known[0], A=np.tensordot(parts.prod(axis=1), matrices, 1))

    return at


class _Matrices(NamedTuple):
    """M, C and K of M q'' + C q' + K q = 0, each shape (k, k)."""

    M: np.ndarray
    C: np.ndarray
    K: np.ndarray


@final
@dataclass(frozen=True, repr=False)
class SpeedMatrices(Legible):
    """M q'' + C(u) q' + K(u) q = 0 for deviations from a steady motion, by its speed u.

    Args:
        mechanism: what moves.
        names: of the coordinates.
        M: shape (k, k).
        C: C0 and C1 of C = C0 + u C1, shape (2, k, k).
        K: K0, K1 and K2 of K = K0 + u K1 + u² K2, shape (3, k, k).
        position: of the motion, by name where it was given.
        velocity: at speed 1, by name.

    Example:
        >>> coin = mq.textbook.load("rolling_coin")
        >>> ride = mq.expand_in_speed(coin, {"z": coin.values["r"]}, {"spin": 1.0}, ("yaw", "lean"))
        >>> M, C, K = ride.at(30.0)
        >>> C.round(3)
        array([[  0.   ,   4.875],
               [-14.625,   0.   ]])
    """

    mechanism: Mechanism
    names: tuple[str, ...]
    M: np.ndarray
    C: np.ndarray
    K: np.ndarray
    position: Mapping[str, float] = field(default_factory=dict)
    velocity: Mapping[str, float] = field(default_factory=dict)

    @cached_property
    def letters(self) -> SteadyLetters:
        """The same in letters: the matrices by their entries, found by the derivation.

        Raises:
            DerivationError: if the motion is not steady for all values of the parameters, or the
                entries cannot be written so.
        """
        return steady_letters(self.mechanism, self.position, self.velocity, self.names)

    def at(self, speed: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return M, C and K at a speed, each shape (k, k)."""
        return _Matrices(
            self.M,
            self.C[0] + speed * self.C[1],
            self.K[0] + speed * (self.K[1] + speed * self.K[2]),
        )

    def eigenvalues(self, speed: float) -> np.ndarray:
        """Return the exponents λ of small deviations e^(λ t) at a speed, by real part [1/s]."""
        M, C, K = self.at(speed)
        k = len(M)
        A = np.block([[np.zeros((k, k)), np.eye(k)], [-np.linalg.solve(M, np.hstack([K, C]))]])
        return by_real_part(np.linalg.eigvals(A))

    def __str__(self) -> str:
        head = (
            f"{self.mechanism.name}: M q'' + C q' + K q = 0 of {', '.join(self.names)} by speed u"
        )
        lines = [head]
        for title, matrix in (
            ("M", self.M),
            ("C = C0 + u C1: C0", self.C[0]),
            ("C1", self.C[1]),
            ("K = K0 + u K1 + u² K2: K0", self.K[0]),
            ("K1", self.K[1]),
            ("K2", self.K[2]),
        ):
            lines.append(title)
            lines += ["  " + "  ".join(map("{:>14.9g}".format, row)) for row in matrix]
        return "\n".join(lines)


def expand_in_speed(
    mechanism: Mechanism,
    at: Given,
    v: Mapping[str, float],
    names: Sequence[str],
    *,
    by: Sequence[str] = (),
) -> SpeedMatrices:
    """Return M, C and K of some coordinates as functions of the speed of a steady motion.

    They are computed at three speeds, and at a fourth to see whether M stays, C grows with the
    speed and K with its square, as where a motion straight ahead is only faster or slower.

    Args:
        mechanism: what moves.
        at: positions, shape (nq,) or by name.
        v: velocities at speed 1, by name.
        names: of the coordinates, e.g. ("roll", "steer") of a bicycle.
        by: names of coordinates that are to be independent; those of hinges by default.

    Returns:
        The matrices by power of the speed; at a speed: `at(speed)`.

    Raises:
        InputError: if a motion is not steady, others move with these coordinates, or the matrices
            depend on the speed in another way.

    Example:
        >>> bicycle = mq.textbook.load('whipple_bicycle')
        >>> ride = mq.expand_in_speed(bicycle, {'z': 0.3}, {'x': 1.0}, ('roll', 'steer'))
        >>> ride.C[1].round(5).tolist()
        [[0.0, 33.86641], [-0.85036, 1.6854]]
    """
    names = [to_name(mechanism, typed) for typed in names]

    def compute(speed: float) -> np.ndarray:
        moving = {name: speed * rate for name, rate in v.items()}
        linearization = linearize_steady(mechanism, at, moving, by=by)
        return np.array(linearization.second_order(names))

    powers = np.vander(_SAMPLED, 3, increasing=True)
    sampled = np.array([compute(speed) for speed in _SAMPLED])
    fitted = np.tensordot(np.linalg.inv(powers), sampled, 1)  # by power, then of M, C, K
    checked = np.tensordot(_CHECKED ** np.arange(3), fitted, 1)
    size = np.abs(sampled).max(axis=(0, 2, 3), keepdims=True)
    off = np.abs(compute(_CHECKED) - checked).max(axis=(1, 2)) / size[0, :, 0, 0]
    fitted[np.abs(fitted) <= ALIKE * size] = 0.0
    if off.max() > FITS or fitted[1:, 0].any() or fitted[2, 1].any():
        raise InputError(
            f"M, C and K of {mechanism.name!r} are no polynomials M, C0 + u C1, K0 + u K1 + u² K2 "
            "of the speed u; use sweep_speeds, which takes each speed by itself"
        )
    where = mechanism.position(at).tolist()
    return SpeedMatrices(
        mechanism,
        tuple(names),
        fitted[0, 0],
        fitted[:2, 1].copy(),
        fitted[:, 2].copy(),
        dict(zip(mechanism.coordinates, where, strict=True)),
        dict(v),
    )


def expand_start(mechanism: Mechanism) -> SpeedMatrices | None:
    """Return M, C and K about the steady motion that a catalogue's system starts near, if any.

    Its start at rest balances, and what nothing depends on goes on as it starts.
    """
    if not is_known(mechanism.name):
        return None
    system = entry(mechanism.name)
    with suppress(MecaniqueError):
        still = linearize_steady(mechanism, system.start, {})
        going = {name: v for name, v in system.start_velocity.items() if name in still.cyclic}
        names = [name for name in still.positions if name not in still.cyclic]
        unit = max(map(abs, going.values()), default=0.0)
        if unit and names:
            at_one = {name: v / unit for name, v in going.items()}
            return expand_in_speed(mechanism, system.start, at_one, names)
    return None


def _growth(motion: SteadyLinearization) -> float:
    """The largest real part of an exponent, relative to the largest exponent."""
    exponents = motion.exponents
    size = float(np.abs(exponents).max(initial=0.0)) or 1.0
    return float(exponents.real.max(initial=-size)) / size
