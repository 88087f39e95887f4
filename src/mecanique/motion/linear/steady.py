"""Small deviations from steady motions of mechanisms that roll.

What rolls has fewer independent velocities w than independent positions q, so that its linear
equations are of first order, x' = A x with x = (δq, δw); those of δw are M δw' + C δw + K δq = 0
(Neimark & Fufaev, Dynamics of Nonholonomic Systems, 1972, ch. VI). A motion is steady if only
cyclic coordinates change, those that no acceleration and no rate depends on, e.g. the place of a
bicycle and the turns of its wheels.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, final

import numpy as np

from mecanique.errors import InputError
from mecanique.model.mechanism import Mechanism
from mecanique.model.states import Given
from mecanique.motion.linear.about import slopes
from mecanique.motion.record.loops import begin_on_loops
from mecanique.threads import one_thread_for_loops

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["SpeedRange", "SteadyLinearization", "linearize_steady", "sweep_speeds"]

_NONE = 1e-8
"""Entries of A below this part of the largest count as zero."""

_STEADY = 1e-6
"""Rates and accelerations of a steady motion may be this large [1/s, 1/s²]."""

_STABLE = 1e-7
"""Real parts of exponents up to this part of the largest exponent count as zero."""


@final
@dataclass(frozen=True, repr=False)
class SteadyLinearization:
    """The linear equations x' = A x of deviations x = (δq, δw) from a steady motion.

    Args:
        mechanism: what moves.
        q: shape (nq,), its position.
        v: shape (nv,), its velocities.
        positions: names of the independent coordinates q.
        velocities: names of the independent velocities w.
        A: shape (n, n), n of both together.
        M: shape (nw, nw), the mass matrix that the independent velocities see.
        idle: which deviations nothing depends on, of cyclic coordinates and of kept speeds.
        error: estimate of the error of A, relative to its largest entry.
    """

    mechanism: Mechanism
    q: np.ndarray
    v: np.ndarray
    positions: tuple[str, ...]
    velocities: tuple[str, ...]
    A: np.ndarray
    M: np.ndarray
    idle: tuple[int, ...]
    error: float

    @property
    def cyclic(self) -> tuple[str, ...]:
        """Names of the coordinates that nothing depends on."""
        return tuple(self.positions[k] for k in self.idle if k < len(self.positions))

    @property
    def C(self) -> np.ndarray:
        """Of M δw' + C δw + K δq = 0, shape (nw, nw)."""
        n = len(self.positions)
        found: np.ndarray = -self.M @ self.A[n:, n:]
        return found

    @property
    def K(self) -> np.ndarray:
        """Of the same, shape (nw, nq independent)."""
        n = len(self.positions)
        found: np.ndarray = -self.M @ self.A[n:, :n]
        return found

    def second_order(self, names: Sequence[str]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return M, C and K of some coordinates whose velocities are independent, each (k, k).

        Args:
            names: of the coordinates, e.g. ("roll", "steer") of a bicycle; no other may move with
                them.

        Raises:
            InputError: if one is not independent, or others move with them.
        """
        wanted = [f"{name}'" for name in names]
        if not set(names) <= set(self.positions) or not set(wanted) <= set(self.velocities):
            known = ", ".join(name for name in self.positions if name not in self.cyclic)
            raise InputError(f"expected names among {known}, got {', '.join(names)}")
        place = [self.positions.index(name) for name in names]
        rate = [self.velocities.index(name) for name in wanted]
        others = [k for k in range(len(self.velocities)) if k not in rate]
        free = [k for k, n in enumerate(self.positions) if n not in (*names, *self.cyclic)]
        M, C, K = self.M, self.C, self.K
        size = np.abs(M).max()
        left = [M[np.ix_(rate, others)], C[np.ix_(rate, others)], K[np.ix_(rate, free)]]
        if max(np.abs(part).max(initial=0.0) for part in left) > _NONE * size:
            raise InputError(f"other coordinates move with {', '.join(names)}")
        pick = np.ix_(rate, rate)
        return M[pick], C[pick], K[np.ix_(rate, place)]

    @cached_property
    def eigenvalues(self) -> np.ndarray:
        """All exponents λ of small deviations e^(λ t), by real part [1/s]."""
        values = np.concatenate([self.exponents, np.zeros(len(self.A) - len(self.exponents))])
        result: np.ndarray = values[np.lexsort((values.imag, values.real))]
        return result

    @cached_property
    def exponents(self) -> np.ndarray:
        """Those exponents that are not zero for each deviation that nothing depends on [1/s]."""
        kept = [k for k in range(len(self.A)) if k not in self.idle]
        values = np.linalg.eigvals(self.A[np.ix_(kept, kept)])
        result: np.ndarray = values[np.lexsort((values.imag, values.real))]
        return result

    @property
    def stable(self) -> bool:
        """Whether no small deviation grows exponentially."""
        size = np.abs(self.exponents).max(initial=0.0)
        return bool((self.exponents.real <= _STABLE * size).all())

    def __repr__(self) -> str:
        kind = "stable" if self.stable else "unstable"
        found = ", ".join(f"{_plain(x):.6g}" for x in self.exponents)
        return f"<{kind} steady motion of {self.mechanism.name!r}: λ = {found or 0}>"


@one_thread_for_loops
def linearize_steady(
    mechanism: Mechanism, at: Given = None, v: Given = None, *, by: Sequence[str] = ()
) -> SteadyLinearization:
    """Linearize the equations of a mechanism that rolls about a steady motion.

    Rates and accelerations of the reference are differentiated by central differences of eighth
    order; `error` says how well that worked.

    Args:
        mechanism: a mechanism with contacts or velocity constraints, its joints hinges and slides.
        at: positions, shape (nq,) or by name; wheels are put on the ground next to them.
        v: velocities, shape (nv,) or by name; those left out follow.
        by: names of coordinates that are to be independent, and their velocities; by default
            those of hinges.

    Raises:
        InputError: if the mechanism does not roll or turns by quaternions, or the motion is not
            steady; the message says what changes.
        ClosureError: if a wheel cannot be put on the ground.
        UnknownNameError: if a coordinate or velocity does not exist.
    """
    from mecanique.reference import Reference
    from mecanique.reference.loops.assembly import held_columns
    from mecanique.reference.loops.independent import Independent

    if not mechanism.rolls:
        raise InputError(f"mechanism {mechanism.name!r} does not roll; use linearize")
    if mechanism.quaternions:
        raise InputError(
            f"joint {mechanism.quaternions[0][0]!r} turns by a quaternion, whose deviations turn "
            "with it; describe it by three hinges to linearize about a steady motion"
        )
    reference, state, _ = begin_on_loops(Reference(mechanism), at, v, 0.0)
    q, velocity = state[: mechanism.nq], state[mechanism.nq :]
    closed = reference.closed
    assert closed is not None, "the mechanism rolls"
    # turns of hinges stay steady where a body rolls in a circle, slides do not
    turning = [n for j in mechanism.joints for n in j.coordinates if n not in j.linear_coordinates]
    prefer = held_columns(mechanism, by or [n for n in turning if n in mechanism.coordinates])
    place = Independent(closed, q, 0.0, rows=closed.closures.positional, prefer=prefer)
    free = Independent(closed, q, 0.0, prefer=prefer)
    n = len(place.chosen)
    w = velocity[free.chosen]

    def rates(step: np.ndarray) -> np.ndarray:
        found = []
        for x in step:
            there = place.position(x[:n])
            moving = free.velocity(there, w + x[n:])
            a = closed.solve(there, moving, 0.0).acceleration
            found.append(np.concatenate([moving[place.chosen], a[free.chosen]]))
        return np.array(found)

    A, error = slopes(rates, n + len(w))
    positions = tuple(mechanism.velocities[k].removesuffix("'") for k in place.chosen)
    velocities = tuple(mechanism.velocities[k] for k in free.chosen)
    idle = _idle(A)
    _refuse_changing(mechanism, rates(np.zeros((1, len(A))))[0], positions, velocities, idle)
    T = free.tangent
    M = T.T @ reference.mass_matrix(q) @ T
    return SteadyLinearization(mechanism, q, velocity, positions, velocities, A, M, idle, error)


@final
@dataclass(frozen=True, repr=False)
class SpeedRange:
    """The exponents of a steady motion over its speed; its text is a table.

    Args:
        mechanism: what moves.
        speeds: shape (n,), factors of the velocities given.
        eigenvalues: shape (n, k), the exponents, by real part [1/s].
        limits: speeds at which the motion becomes stable or ceases to be.
    """

    mechanism: Mechanism
    speeds: np.ndarray
    eigenvalues: np.ndarray
    limits: tuple[float, ...]

    def __str__(self) -> str:
        lines = [f"{self.mechanism.name}: exponents of small deviations [1/s] by speed"]
        for speed, values in zip(self.speeds, self.eigenvalues, strict=True):
            cells = "  ".join(f"{_plain(x):>22.6g}" for x in values)
            lines.append(f"{speed:>10.4g}  {cells}")
        limits = ", ".join(f"{limit:.9g}" for limit in self.limits) or "none in this range"
        return "\n".join([*lines, f"stability changes at: {limits}"])

    def plot(self) -> Figure:
        """Return real and imaginary parts over the speed, with the limits of stability."""
        from matplotlib.figure import Figure

        figure = Figure(layout="constrained")
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
        mechanism: a mechanism that rolls.
        at: positions, shape (nq,) or by name.
        v: velocities at speed 1, by name.
        speeds: factors of these velocities, in ascending order.
        by: names of coordinates that are to be independent.

    Raises:
        InputError: if there are not at least two speeds, or a motion is not steady.
    """
    from scipy.optimize import brentq

    given = np.array(list(speeds), dtype=float)
    if len(given) < 2 or not (np.diff(given) > 0).all():
        raise InputError(f"expected at least two speeds in ascending order, got {given.tolist()}")

    def exponents(speed: float) -> np.ndarray:
        moving = {name: speed * rate for name, rate in v.items()}
        return linearize_steady(mechanism, at, moving, by=by).exponents

    rows = [exponents(speed) for speed in given]
    heights = [_growth(row) for row in rows]
    limits = []
    for left, right, a, b in zip(given, given[1:], heights, heights[1:], strict=False):
        kinds = [int(np.sign(x)) if abs(x) > _STABLE else 0 for x in (a, b)]
        if kinds[0] == kinds[1]:
            continue
        # without damping nothing decays: what counts as zero divides growth from oscillation
        margin = _STABLE * sum(kinds)

        def height(speed: float, margin: float = margin) -> float:
            return _growth(exponents(speed)) - margin

        limits.append(float(brentq(height, left, right, xtol=1e-10, rtol=1e-10)))
    return SpeedRange(mechanism, given, np.array(rows), tuple(limits))


def _growth(exponents: np.ndarray) -> float:
    """The largest real part, relative to the largest exponent."""
    size = float(np.abs(exponents).max(initial=0.0)) or 1.0
    return float(exponents.real.max(initial=-size)) / size


def _idle(A: np.ndarray) -> tuple[int, ...]:
    """The deviations that nothing depends on but others that nothing depends on."""
    least = _NONE * float(np.abs(A).max(initial=0.0))
    found: list[int] = []
    while True:
        rest = [k for k in range(len(A)) if k not in found]
        more = [k for k in rest if np.abs(A[rest, k]).max(initial=0.0) <= least]
        if not more:
            return tuple(sorted(found))
        found += more


def _refuse_changing(
    mechanism: Mechanism,
    rates: np.ndarray,
    positions: tuple[str, ...],
    velocities: tuple[str, ...],
    idle: tuple[int, ...],
) -> None:
    named = [*(f"{name}'" for name in positions), *(f"{name}'" for name in velocities)]
    changing = [
        f"{name} = {rate:.3g}"
        for k, (name, rate) in enumerate(zip(named, rates, strict=True))
        if abs(rate) > _STEADY and (k >= len(positions) or k not in idle)
    ]
    if changing:
        raise InputError(
            f"the motion of {mechanism.name!r} is not steady: {', '.join(changing)}; give a state "
            "in which only cyclic coordinates change"
        )


def _plain(x: Any) -> Any:
    return x if x.imag else x.real
