"""Small deviations from steady motions: of what rolls, of tops, of loops.

What rolls has fewer independent velocities w than independent positions q, so that its linear
equations are of first order, x' = A x with x = (δq, δw); those of δw are M δw' + C δw + K δq = 0
(Neimark & Fufaev, Dynamics of Nonholonomic Systems, 1972, ch. VI). A motion is steady if only
cyclic coordinates change, those that no acceleration and no rate depends on, e.g. the place of a
bicycle and the turns of its wheels, or the spin of a top (Routh, Advanced Rigid Dynamics, 1905, ch.
III).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple, final

import numpy as np

from mecanique.errors import InputError
from mecanique.model.mechanism import Mechanism
from mecanique.model.values import Given
from mecanique.motion.linear.differences import slopes
from mecanique.motion.linear.hinges import put_hinges
from mecanique.motion.record.loops import begin_on_loops
from mecanique.threads import one_thread_for_loops

if TYPE_CHECKING:
    from mecanique.reference import Reference


_NONE = 1e-8
"""Entries of A below this part of the largest count as zero."""

_STEADY = 1e-6
"""Rates and accelerations of a steady motion may be this large [1/s, 1/s²]."""

STABLE = 1e-7
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

    Example:
        >>> coin = mq.textbook.load("rolling_coin")
        >>> rolling = {"z": coin.values["r"]}
        >>> slow, fast = (mq.linearize_steady(coin, rolling, {"spin": w}) for w in (1.0, 30.0))
        >>> slow.stable, fast.stable
        (False, True)
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
        damping: np.ndarray = -self.M @ self.A[n:, n:]
        return damping

    @property
    def K(self) -> np.ndarray:
        """Of the same, shape (nw, nq independent)."""
        n = len(self.positions)
        stiffness: np.ndarray = -self.M @ self.A[n:, :n]
        return stiffness

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
        """The exponents without a zero for each deviation that nothing depends on [1/s]."""
        kept = [k for k in range(len(self.A)) if k not in self.idle]
        values = np.linalg.eigvals(self.A[np.ix_(kept, kept)])
        result: np.ndarray = values[np.lexsort((values.imag, values.real))]
        return result

    @property
    def stable(self) -> bool:
        """Whether no small deviation grows exponentially."""
        size = np.abs(self.exponents).max(initial=0.0)
        return bool((self.exponents.real <= STABLE * size).all())

    def __repr__(self) -> str:
        kind = "stable" if self.stable else "unstable"
        listed = ", ".join(f"{x:.6g}" for x in plain(self.exponents))
        return f"<{kind} steady motion of {self.mechanism.name!r}: λ = {listed or 0}>"


class _Free(NamedTuple):
    """What may deviate from a steady motion, and how fast it then changes."""

    positions: np.ndarray  # which velocities' coordinates are independent, indices
    velocities: np.ndarray  # which velocities are independent, indices
    # (q', w') by deviations (δq, δw), shape (n, count) both
    rates: Callable[[np.ndarray], np.ndarray]
    tangent: np.ndarray  # v by w at the motion itself, shape (nv, nw)


@one_thread_for_loops
def linearize_steady(
    mechanism: Mechanism, at: Given = None, v: Given = None, *, by: Sequence[str] = ()
) -> SteadyLinearization:
    """Linearize the equations of a mechanism about a steady motion.

    Rates and accelerations of the reference are differentiated by central differences of eighth
    order; `error` says how well that worked. A joint that turns by a quaternion is described by
    hinges first, `<joint>_precession`, `_nutation` and `_spin`: about an axis that stays, about the
    normal to both and about an axis of the body.

    Args:
        mechanism: a mechanism that rolls, a tree or one with loops.
        at: positions, shape (nq,) or by name; wheels are put on the ground next to them.
        v: velocities, shape (nv,) or by name; those left out follow.
        by: names of coordinates that are to be independent, and their velocities; by default
            those of hinges.

    Returns:
        The linear equations, with their exponents.

    Raises:
        InputError: if the motion is not steady; the message says what changes.
        ClosureError: if a wheel cannot be put on the ground.
        UnknownNameError: if a coordinate or velocity does not exist.

    Example:
        >>> disk = mq.textbook.load('rolling_coin')
        >>> mq.linearize_steady(disk, {'z': disk.values['r']}, {'spin': 30.0}).stable
        True
    """
    from mecanique.reference.loops.assembly import held_columns

    reference, q, velocity = _begin(mechanism, at, v)
    if mechanism.quaternions:
        hinged = put_hinges(mechanism, q, velocity, reference.acceleration(q, velocity))
        mechanism = hinged.mechanism
        reference, q, velocity = _begin(mechanism, hinged.position, hinged.velocity)
    # turns of hinges stay steady where a body rolls in a circle, slides do not
    turning = [n for j in mechanism.joints for n in j.coordinates if n not in j.linear_coordinates]
    prefer = held_columns(mechanism, by or [n for n in turning if n in mechanism.coordinates])
    free = (_release_tree if reference.closed is None else _release_loops)(
        reference, q, velocity, prefer
    )
    A, error = slopes(free.rates, len(free.positions) + len(free.velocities))
    positions = tuple(mechanism.velocities[k].removesuffix("'") for k in free.positions)
    velocities = tuple(mechanism.velocities[k] for k in free.velocities)
    idle = _idle(A)
    rates = free.rates(np.zeros((1, len(A))))[0]
    _refuse_changing(mechanism, rates, positions, velocities, idle)
    M = free.tangent.T @ reference.mass_matrix(q) @ free.tangent
    return SteadyLinearization(
        mechanism=mechanism,
        q=q,
        v=velocity,
        positions=positions,
        velocities=velocities,
        A=A,
        M=M,
        idle=idle,
        error=error,
    )


def _begin(mechanism: Mechanism, at: Given, v: Given) -> tuple[Reference, np.ndarray, np.ndarray]:
    """The state, on the constraints."""
    from mecanique.reference import Reference

    reference = Reference.of(mechanism)
    if not mechanism.constrained:
        return reference, mechanism.position(at), mechanism.velocity(v)
    reference, state, _ = begin_on_loops(reference, at, v, 0.0)
    return reference, state[: mechanism.nq], state[mechanism.nq :]


def _release_tree(reference: Reference, q: np.ndarray, v: np.ndarray, prefer: np.ndarray) -> _Free:
    """All coordinates and velocities of a tree may deviate."""
    n = len(q)

    def rates(step: np.ndarray) -> np.ndarray:
        moving = v + step[:, n:]
        return np.hstack([moving, reference.acceleration(q + step[:, :n], moving)])

    return _Free(np.arange(n), np.arange(n), rates, np.eye(n))


def _release_loops(reference: Reference, q: np.ndarray, v: np.ndarray, prefer: np.ndarray) -> _Free:
    """The deviations that the constraints leave free, preferred ones first."""
    from mecanique.reference.loops.independent import Independent

    closed = reference.closed
    assert closed is not None, "it has constraints"
    place = Independent(closed, q, 0.0, rows=closed.closures.positional, prefer=prefer)
    free = Independent(closed, q, 0.0, prefer=prefer)
    n, w = len(place.chosen), v[free.chosen]
    home = place.position(np.zeros(n))

    def rates(step: np.ndarray) -> np.ndarray:
        rows = []
        for x in step:
            there = place.position(x[:n]) if x[:n].any() else home
            moving = free.velocity(there, w + x[n:])
            a = closed.solve(there, moving, 0.0).acceleration
            rows.append(np.concatenate([moving[place.chosen], a[free.chosen]]))
        return np.array(rows)

    return _Free(place.chosen, free.chosen, rates, free.tangent)


def _idle(A: np.ndarray) -> tuple[int, ...]:
    """The deviations on which only deviations of the same kind depend."""
    least = _NONE * float(np.abs(A).max(initial=0.0))
    idle: list[int] = []
    while True:
        rest = [k for k in range(len(A)) if k not in idle]
        more = [k for k in rest if np.abs(A[rest, k]).max(initial=0.0) <= least]
        if not more:
            return tuple(sorted(idle))
        idle += more


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


def plain(exponents: np.ndarray) -> list[complex | float]:
    """Return the numbers without rounding noise, those that are real as such."""
    noise = _NONE * np.abs(exponents).max(initial=0.0)
    re, im = (np.where(np.abs(x) > noise, x, 0.0) for x in (exponents.real, exponents.imag))
    return [complex(x, y) if y else float(x) for x, y in zip(re, im, strict=True)]
