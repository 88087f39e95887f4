"""Close loops from far away, by Gauss–Newton steps with damping.

The step is that of Levenberg and Marquardt in scaled units (Marquardt, J. SIAM 11 (1963) 431); near
the solution the damping vanishes, and the pseudo-inverse of a possibly rank-deficient Jacobian is
used (Ben-Israel, J. Math. Anal. Appl. 15 (1966) 243). Parts that share no motion are closed at the
same time, but each with its own damping and its own end, as if it were alone.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from mecanique.arrays import Array
from mecanique.errors import ClosureError
from mecanique.model.constraints.loops import Loop
from mecanique.reference.loops.assembly.newton import displace
from mecanique.reference.loops.closed import Closed
from mecanique.reference.loops.nullspace import are_certain
from mecanique.reference.loops.tolerances import ASSEMBLED, EXACT, LEAST, RANK_ASSEMBLED, TINY

_NEAR = 1e-4
"""Gap, in characteristic lengths or radians, below which steps are not damped."""

_STEPS = 200
_PATIENCE = 12
"""Largest number of successive steps that each gain less than a thousandth."""

_LONGEST = 0.5
"""Longest step, in characteristic lengths or radians."""


def close_position(closed: Closed, q: Array, t: float, held: Array | None = None) -> Array:
    """Return positions near q at which every loop is closed, shape (nq,).

    Args:
        closed: the mechanism.
        q: shape (nq,), the guess.
        t: time [s].
        held: shape (nv,), whether the coordinate of each velocity is kept; none by default.

    Raises:
        ClosureError: if a loop cannot be closed; the message states its gap.
    """
    found, gaps = settle(closed, q, t, held)
    refuse_open(closed, gaps)
    return found


@dataclass
class _Search:
    """The state of the search for a position that closes one part.

    Args:
        rows: indices of the part's constraints.
        at: indices of its velocities.
        damping: damping of the next step, as a part of the largest singular value.
        stuck: number of successive steps that gained almost nothing.
        over: whether the search has been given up.
    """

    rows: npt.NDArray[np.intp]
    at: npt.NDArray[np.intp]
    damping: float = 1e-3
    stuck: int = 0
    over: bool = False

    def is_over(self, gaps: Array) -> bool:
        """Return whether the part is closed, or the search has been given up."""
        own = gaps[self.rows]
        return self.over or self._widest(gaps) <= EXACT or not np.isfinite(own).all()

    def step(self, J: Array, gaps: Array, rounding: Array) -> Array:
        """Return the next step, scaled."""
        damping = None if self._widest(gaps) < _NEAR else self.damping
        J = J[np.ix_(self.rows, self.at)]
        return _damped_step(J, gaps[self.rows], damping, rounding[self.rows])

    def accept(self, gaps: Array, trial: Array) -> bool:
        """Return whether to take a step, and set the damping of the next.

        Args:
            gaps: the gaps before it.
            trial: the gaps after it.
        """
        before, after = (float(np.linalg.norm(all_of[self.rows])) for all_of in (gaps, trial))
        self.stuck = self.stuck + 1 if after > 0.999 * before else 0
        if self.stuck > _PATIENCE:
            self.over = True
            return False
        if after < before:
            self.damping = max(self.damping / 5, 1e-12)
            return True
        self.over = self._widest(gaps) < _NEAR or self.damping > 1e6
        self.damping *= 4
        return False

    def _widest(self, gaps: Array) -> float:
        return float(np.abs(gaps[self.rows]).max(initial=0.0))


def settle(closed: Closed, q: Array, t: float, held: Array | None = None) -> tuple[Array, Array]:
    """Return the positions closest to closed that were found, and their gaps, shape (m,).

    Parts that share no motion are closed at the same time, but each with its own damping and end.
    """
    closures, parts = closed.closures, closed.closures.parts
    still, positional = np.zeros(closed.mechanism.nv), closures.positional
    free = np.ones(len(still)) if held is None else np.where(held, 0.0, 1.0)
    searches = []
    for k in range(parts.count):
        own = np.flatnonzero(parts.columns == k)
        if free[own].any():
            searches.append(_Search(np.flatnonzero((parts.rows == k) & positional), own))
    gaps = _gaps(closed, q, t)
    for _ in range(_STEPS):
        searches = [search for search in searches if not search.is_over(gaps)]
        if not searches:
            break
        here = closures.scale(q, still, t)
        J = here.jacobian * free
        step = np.zeros(len(still))
        for search in searches:
            step[search.at] = free[search.at] * search.step(J, gaps, here.rounding)
        moved = displace(closed, q, closures.columns * step)
        trial = _gaps(closed, moved, t)
        back = [search for search in searches if not search.accept(gaps, trial)]
        if len(back) == len(searches):
            continue
        if back:
            step[np.concatenate([search.at for search in back])] = 0.0
            moved = displace(closed, q, closures.columns * step)
            trial = _gaps(closed, moved, t)
        q, gaps = moved, trial
    return q, np.abs(gaps)


def is_open(gaps: Array) -> npt.NDArray[np.bool_]:
    """Return whether each gap is wider than an assembly may leave, or not finite."""
    return ~(gaps <= ASSEMBLED)


def _damped_step(
    J: Array, gaps: Array, damping: float | None, rounding: Array | float = 0.0
) -> Array:
    """Return the scaled step of Levenberg and Marquardt, of limited length.

    Without damping, near the end, it leaves out directions that the constraints do not restrain.
    """
    left, singular, right = np.linalg.svd(J, full_matrices=False)
    top = max(float(singular[0]), TINY) if singular.size else 1.0
    least, added = (
        (max(RANK_ASSEMBLED * top, LEAST), 0.0) if damping is None else (0.0, damping * top**2)
    )
    gain = np.zeros_like(singular)
    strong = are_certain(left, singular, least, rounding if damping is None else 0.0)
    gain[strong] = singular[strong] / (singular[strong] ** 2 + added)
    step: Array = -right.T @ (gain * (left.T @ gaps))
    longest = float(np.abs(step).max(initial=0.0))
    if longest > _LONGEST:
        step *= _LONGEST / longest
    return step


def refuse_open(closed: Closed, gaps: Array) -> None:
    """Refuse gaps that leave a loop open."""
    closures = closed.closures
    if not is_open(gaps).any():
        return
    worst = int(np.nanargmax(np.where(np.isfinite(gaps), gaps, np.inf)))
    name = closures.names[worst]
    unit = "rad" if name.split(": ")[-1] in ("rx", "ry", "rz") else "m"
    mechanism = closed.mechanism
    owner = (*mechanism.loops, *mechanism.contacts)[int(closures.owner[worst])]
    if not isinstance(owner, Loop):
        raise ClosureError(
            f"mechanism {mechanism.name!r}: {owner.name!r} cannot be put on the plane of "
            f"{owner.on!r} from there; the nearest position found leaves it off by "
            f"{gaps[worst] / closures.rows[worst]:.3g} m; do not fix the coordinate that lifts it"
        )
    raise ClosureError(
        f"mechanism {mechanism.name!r}: loop {owner.name!r} cannot be closed from there; "
        "the nearest position found leaves it open by "
        f"{gaps[worst] / closures.rows[worst]:.3g} {unit} ({name}); try another guess, or check "
        "its lengths"
    )


def _gaps(closed: Closed, q: Array, t: float) -> Array:
    return closed.closures.rows * closed.closures.residual(q, t)
