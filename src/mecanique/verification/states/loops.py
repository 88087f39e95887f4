"""Random states of a closed mechanism: random positions brought to where the loops are closed.

Those next to a singular position are left out, where rounding errors of the acceleration grow
without bound: the smallest singular value of the constraints that act there is much below the
typical one.
"""

from __future__ import annotations

from contextlib import suppress
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from mecanique.arrays import Array
from mecanique.errors import ClosureError
from mecanique.model.mechanism import Mechanism

_RANK = 1e-9
_REGULAR = 0.03
"""Part of the typical smallest singular value below which a position is next to a singular one."""

_TREMBLING = 1e-5
"""The same, absolute: positions that close the loops without being held in them."""


_DETERMINED = 1e-2
"""Least margin of a contact, of a wheel the sine of the angle at which it lies.

Forms of its law divide by the margin's square, so that rounding grows to 1e4 times its usual size,
and stays a hundredth of what is tolerated.
"""

_STRIDE = 0.5
"""Length of a step along the loops, in radians or characteristic lengths."""

_STRIDES = 4
"""How many steps lead from one state to the next."""


class ClosedStates(NamedTuple):
    """States with closed loops.

    Args:
        q: positions, shape (k, nq).
        v: velocities, shape (k, nv).
        at: which of the states given they are near, shape (k,).
        rank: how many of the constraints are independent there.
    """

    q: Array
    v: Array
    at: npt.NDArray[np.intp]
    rank: int


def closed_states(mechanism: Mechanism, q: Array, v: Array, t: Array) -> ClosedStates:
    """Return the states with closed loops near given ones, and which of them they are near.

    Args:
        mechanism: a mechanism with loops.
        q: positions, shape (n, nq).
        v: velocities, shape (n, nv).
        t: times, shape (n,) [s].
    """
    from mecanique.reference import Reference
    from mecanique.reference.loops.assembly.assembly import project
    from mecanique.reference.loops.assembly.closing import close_position

    closed = Reference.of(mechanism).closed
    if closed is None:
        return ClosedStates(q, v, np.arange(len(t)), 0)
    found: list[tuple[Array, Array]] = []
    which: list[int] = []
    least: list[float] = []
    ranks: list[int] = []
    for k in range(len(t)):
        try:
            with np.errstate(all="ignore"):
                start = close_position(closed, q[k], float(t[k]))
                position, velocity = project(closed, start, v[k], float(t[k]))
        except (ClosureError, ArithmeticError, ValueError):
            continue
        J = closed.closures.scale(position, velocity, float(t[k])).jacobian
        if closed.closures.contacts.margins.min(initial=1.0) < _DETERMINED:
            continue
        sizes = np.linalg.svd(J, compute_uv=False)
        acting = sizes[sizes > _RANK * sizes.max(initial=0.0)]
        least.append(float(acting.min(initial=1.0)))
        ranks.append(len(acting))
        found.append((position, velocity))
        which.append(k)
    if not found:
        return ClosedStates(q[:0], v[:0], np.arange(0), 0)
    # fewer equations act at singular positions, and where parts fall together and move otherwise
    whole = np.array(ranks) == max(ranks)
    usual = np.median(np.array(least)[whole])
    keep = np.flatnonzero(whole & (np.array(least) > max(_REGULAR * usual, _TREMBLING)))
    return ClosedStates(
        np.array([found[k][0] for k in keep]).reshape(len(keep), q.shape[1]),
        np.array([found[k][1] for k in keep]).reshape(len(keep), v.shape[1]),
        np.array(which, dtype=np.intp)[keep],
        max(ranks),
    )


def refuse_locked(mechanism: Mechanism) -> None:
    """Raise if a mechanism with loops is locked in a singular position.

    It may tremble there, so that no random position is held by the loops.

    Raises:
        InputError: if it is.
    """
    from mecanique.reference import Reference
    from mecanique.reference.loops.freedom.freedom import refuse_locked as refuse

    closed = Reference.of(mechanism).closed
    if closed is not None:
        with suppress(ClosureError):
            refuse(closed, 0.0)


def wander(
    mechanism: Mechanism,
    t: Array,
    random: np.random.Generator,
    start: Array | None = None,
    strides: int = _STRIDES,
) -> Array:
    """Return positions met on a random walk along the loops, shape (n, nq).

    It finds states of long chains of loops, which close from no random position.

    Args:
        mechanism: a mechanism with loops.
        t: time of each, shape (n,) [s].
        random: makes the steps.
        start: a position with closed loops, shape (nq,); one near zero by default.
        strides: how many steps lead from one position to the next.

    Raises:
        ClosureError: if no position is found at which all loops are closed.
    """
    from mecanique.reference import Reference
    from mecanique.reference.loops.assembly.assembly import position_near
    from mecanique.reference.loops.assembly.closing import close_position
    from mecanique.reference.loops.assembly.newton import displace

    closed, q = Reference.of(mechanism).closed, mechanism.neutral()
    if closed is None:
        return np.tile(q, (len(t), 1))
    still = np.zeros(mechanism.nv)
    met = []
    free = still.astype(bool)
    q = position_near(closed, None, q, float(t[0]), free) if start is None else start
    for time in t.tolist():
        heading = random.normal(size=len(still))
        for _ in range(strides):
            J = closed.closures.scale(q, still, time).jacobian[closed.closures.positional]
            along = heading - np.linalg.pinv(J, rcond=_RANK) @ (J @ heading)
            step = along * (_STRIDE / max(float(np.abs(along).max(initial=0.0)), _STRIDE))
            with suppress(ClosureError):
                q = close_position(
                    closed, displace(closed, q, closed.closures.columns * step), time
                )
        met.append(q)
    return np.array(met)
