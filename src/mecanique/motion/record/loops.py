"""Keep a closed mechanism closed while its motion is integrated.

The equations keep the second derivative of the constraints at zero; rounding and the errors of the
steps let positions and velocities drift off all the same. They are brought back by projection,
which costs no accuracy, whereas feedback terms in the equations (Baumgarte, Comput. Methods Appl.
Mech. Eng. 1 (1972) 1) would (Hairer & Wanner, Solving Ordinary Differential Equations II, sect.
VII.2).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, ClassVar, NamedTuple, final

import numpy as np

from mecanique.model.values import Given
from mecanique.motion.tolerances import OFF_LOOPS, ON_LOOPS, REPORTED

if TYPE_CHECKING:
    from mecanique.reference import Reference
    from mecanique.reference.loops.closed import Closed


class Beginning(NamedTuple):
    """How a motion begins."""

    reference: Reference  # the mechanism's, for motions from here
    state: np.ndarray  # positions and velocities on the loops, shape (nq + nv,)
    remark: str


def begin_on_loops(reference: Reference, q: Given, v: Given, t: float) -> Beginning:
    """Return the state to start from, its loops closed; what is named stays if that is possible."""
    m = reference.mechanism
    given_q, given_v = m.position(q), m.velocity(v)
    if not m.constrained:
        return Beginning(reference, np.concatenate([given_q, given_v]), "")
    from mecanique.reference.loops.assembly import close_velocity, position_near, project
    from mecanique.reference.loops.singular import branch_acceleration, is_crossing

    position = position_near(_loops_of(reference), q, given_q, t, np.zeros(m.nv, dtype=bool))
    reference = reference.with_rank_at(position, t)
    closed = _loops_of(reference)
    named_q, named_v = _is_set(q, m.coordinates.names), _is_set(v, m.velocities)
    held = named_v if isinstance(v, Mapping) and v else None
    velocity = close_velocity(closed, position, given_v, t, held)
    position, velocity = project(closed, position, velocity, t)
    if is_crossing(closed, position, velocity, t):
        branch_acceleration(closed, position, velocity, t)  # refuses what it does not decide
    changes = [
        f"{what} changed by up to {size:.3g}"
        for what, size in (
            ("positions", float(np.abs(position - given_q)[named_q].max(initial=0.0))),
            ("velocities", float(np.abs(velocity - given_v)[named_v].max(initial=0.0))),
        )
        if size > REPORTED
    ]
    done = "loops closed" if m.loops else "constraints met"
    remark = f"; {done} at the start" + (f" ({', '.join(changes)})" if changes else "")
    return Beginning(reference, np.concatenate([position, velocity]), remark)


def _is_set(given: Given, names: tuple[str, ...]) -> np.ndarray:
    """Return which values were given; those left out by name follow from the constraints."""
    if not isinstance(given, Mapping):
        return np.full(len(names), given is not None)
    return np.array([name in given or name.removesuffix("'") in given for name in names], bool)


def _loops_of(reference: Reference) -> Closed:
    assert reference.closed is not None, "the mechanism has loops"
    return reference.closed


@final
class ClosedLoops:
    """The loops of a mechanism in motion."""

    share: ClassVar[float] = 0.1
    """Part of the tolerance that a step may use: each starts afresh, and no errors cancel."""

    def __init__(
        self,
        reference: Reference,
        rtol: float,
        close: Callable[[float, np.ndarray], np.ndarray | None] | None = None,
    ) -> None:
        self._closed = _loops_of(reference)
        self._quick = close
        self._most = max(OFF_LOOPS * rtol, ON_LOOPS)
        self._nq = reference.mechanism.nq

    def has_left(self, t: float, y: np.ndarray) -> bool:
        """Return whether a state, shape (nq + nv,), has drifted off the loops."""
        gap = np.abs(self.close(t, y) - y)
        speed = 1.0 + float(np.abs(y[self._nq :]).max(initial=0.0))
        return bool(
            max(gap[: self._nq].max(initial=0.0), gap[self._nq :].max(initial=0.0) / speed)
            > self._most
        )

    def close(self, t: float, y: np.ndarray) -> np.ndarray:
        """Return the state on the loops next to a state, shape (nq + nv,)."""
        closed = None if self._quick is None else self._quick(t, y)
        if closed is not None:
            return closed
        from mecanique.reference.loops.assembly import project

        return np.concatenate(project(self._closed, y[: self._nq], y[self._nq :], t, drifted=True))

    def close_all(
        self, t: np.ndarray, q: np.ndarray, v: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return the states on the loops next to some states, shape (n, nq) and (n, nv)."""
        states = zip(t.tolist(), np.hstack([q, v]), strict=True)
        closed = np.array([self.close(*state) for state in states])
        return closed[:, : self._nq], closed[:, self._nq :]
