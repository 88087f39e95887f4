"""Accelerations at many states of a motion, by the quickest equations that the reference upholds.

Where the motion was integrated with equations derived in-house, these are there already: as
functions of arrays they give all states at once. The reference agreed with them at random states
before they were used; here it has to again, at states of this motion, and it answers alone where a
singular position of the loops is near.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, final

import numpy as np

from mecanique.generation.dop853 import NEAREST, PROBE
from mecanique.model.mechanism_units import velocity_scales
from mecanique.model.states import States
from mecanique.motion.compile.cache import compile_once
from mecanique.motion.compile.python import Batched, vectorize
from mecanique.motion.record.spot_check import ASKED, agrees, spread

if TYPE_CHECKING:
    from mecanique.model.mechanism import Mechanism
    from mecanique.motion.compile.program import Program
    from mecanique.reference import Reference


_AGREEMENT = 1e-9
"""Relative difference from the reference that is only rounding."""


@final
@dataclass(frozen=True)
class AccelerationLaw:
    """Gives accelerations at states of a motion."""

    mechanism: Mechanism
    reference: Reference

    def __call__(self, t: np.ndarray, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Return the accelerations, shape (n, nv), by t, shape (n,) [s], q and v."""
        accelerations, sure = self._by_program(t, q, v)
        if not sure.all():
            rest = States.of(self.mechanism, q[~sure], v[~sure], t[~sure])
            accelerations[~sure] = self.reference.quick_accelerations(rest)
        return accelerations

    @cached_property
    def _program(self) -> Program | None:
        return compile_once(self.mechanism).known

    def _by_program(
        self, t: np.ndarray, q: np.ndarray, v: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """What the program gives, shape (n, nv), and at which states that may be used, (n,)."""
        mechanism = self.mechanism
        accelerations: np.ndarray = np.empty((len(t), mechanism.nv))
        sure: np.ndarray = np.zeros(len(t), dtype=bool)
        if self._program is None or len(t) <= ASKED:
            return accelerations, sure
        with np.errstate(all="ignore"):
            rates = _compute(self._rates, t, q, v, mechanism.nq + mechanism.nv)
            accelerations[:] = rates[:, mechanism.nq :]
            sure[:] = np.isfinite(accelerations).all(axis=1) & self._is_regular(t, q, v, rates)
        asked = spread(len(t))
        asked = asked[sure[asked]]
        states = States.of(mechanism, q[asked], v[asked], t[asked])
        right = self.reference.quick_accelerations(states)
        most = _AGREEMENT * (1.0 + np.abs(right).max(initial=0.0))
        if not agrees(accelerations[asked], right, most):
            sure[:] = False
        return accelerations, sure

    @cached_property
    def _rates(self) -> Batched:
        assert self._program is not None, "there is a program"
        return vectorize(self._program)

    @cached_property
    def _firmness(self) -> Batched:
        assert self._program is not None, "there is a program"
        assert self._program.landing is not None, "its mechanism has loops"
        return vectorize(replace(self._program, rates=(self._program.landing.firmness,)))

    def _is_regular(
        self, t: np.ndarray, q: np.ndarray, v: np.ndarray, rates: np.ndarray
    ) -> np.ndarray:
        """Whether no singular position of the loops is near, to first order along the motion."""
        mechanism = self.mechanism
        if not mechanism.constrained:
            return np.ones(len(t), dtype=bool)
        firmness = _compute(self._firmness, t, q, v, 1)[:, 0]
        speed = np.abs(v / velocity_scales(mechanism)).max(axis=1)
        step = np.where(speed > 0, PROBE / speed, 0.0)[:, None]
        ahead = _compute(self._firmness, t, q + step * rates[:, : mechanism.nq], v, 1)[:, 0]
        change = np.abs(ahead - firmness)
        regular: np.ndarray = (firmness > 0) & (firmness * PROBE > NEAREST * change)
        return regular


def _compute(
    function: Batched, t: np.ndarray, q: np.ndarray, v: np.ndarray, width: int
) -> np.ndarray:
    """What a function of arrays writes, shape (n, width)."""
    out = np.empty((width, len(t)))
    function(t, np.ascontiguousarray(np.hstack([q, v]).T), out)
    return np.asarray(out.T)
