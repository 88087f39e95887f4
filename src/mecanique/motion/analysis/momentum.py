"""Balances of linear and angular momentum along a motion.

Accelerations at many states come from the quickest equations that the reference agrees with. Where
the motion was integrated with equations derived in-house, these are there already: as functions of
arrays they give all states at once. The reference agreed with them at random states before they
were used; here it has to again, at states of this motion, and it answers alone where a singular
position of the loops is near.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, final

import numpy as np

from mecanique.generation.dop853 import NEAREST, PROBE
from mecanique.model.mechanism_units import velocity_scales
from mecanique.model.states import States
from mecanique.motion.compile.cache import compile_once
from mecanique.motion.compile.python import Batched, vectorize
from mecanique.motion.record.quadrature import integral
from mecanique.motion.record.spot_check import ASKED, agrees, spot_check, spread
from mecanique.motion.tolerances import ACCELERATIONS, NO_MOMENTUM, UNCHANGED
from mecanique.wording import Legible

if TYPE_CHECKING:
    from mecanique.model.mechanism import Mechanism
    from mecanique.motion.compile.program import RatesProgram
    from mecanique.motion.record.trajectory import Trajectory
    from mecanique.reference import Reference
    from mecanique.reference.engine.answers import Momentum


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
    def _program(self) -> RatesProgram | None:
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
        most = ACCELERATIONS * (1.0 + np.abs(right).max(initial=0.0))
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


@final
@dataclass(frozen=True, eq=False, repr=False)
class MomentumBalance(Legible):
    """A balance of momentum along a motion."""

    name: str
    residual: np.ndarray  # shape (n, 3), difference of the two sides
    size: float
    unit: str  # SI unit of the residual


def momentum_balances(motion: Trajectory) -> Iterator[MomentumBalance]:
    """Yield the balances of linear and angular momentum.

    The rate of change of momentum is the resultant of the external forces, support reactions
    included: ṗ = F (Fundamentals of Dynamics, eqs. 1.1, 1.2), L̇ₒ = Mₒ about the world's origin
    (eqs. 1.3, 1.10), L̇ = M about the center of mass (eq. 1.12). Both sides are compared
    integrated, p(t) − p(0) − ∫ F dt, which needs no numerical derivative. Impulses of impacts are
    left out.
    """
    mechanism, reference = motion.mechanism, motion.reference
    if not any(
        mechanism.evaluate(body.mass) for body in mechanism.bodies if body.name != mechanism.ground
    ):
        return

    accelerations = AccelerationLaw(mechanism, reference)

    def rates(t: np.ndarray, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        force, moment, center = reference.resultant(q, v, t, accelerations(t, q, v))
        about_center = moment - np.cross(center, force)
        sizes = [np.linalg.norm(x, axis=1, keepdims=True) for x in (force, moment, about_center)]
        return np.hstack([force, moment, about_center, *sizes])

    have = momenta_along(motion)
    sizes = np.linalg.norm(have.reshape(-1, 3, 3), axis=2).max(axis=0)
    duration = float(np.ptp(motion.t)) or 1.0
    negligible = UNCHANGED * np.repeat(_scales(sizes), 3) / duration
    given = integral(motion.curve, rates, motion.t, smooth=9, negligible=negligible)
    jumps = np.zeros_like(have)
    for event in motion.events:
        if event.impact:
            before, after = (
                np.hstack(reference.momentum(event.q, v, event.t)) for v in (event.v, event.after)
            )
            jumps += (motion.t >= event.t)[:, None] * (after - before)
    residual = have - have[0] - jumps - given[:, :9]
    scales = _scales(sizes + given[-1, 9:])
    for k, (name, unit) in enumerate(
        (
            ("linear momentum", "kg·m/s"),
            ("angular momentum about the origin", "kg·m²/s"),
            ("angular momentum about the center of mass", "kg·m²/s"),
        )
    ):
        yield MomentumBalance(name, residual[:, 3 * k : 3 * k + 3], float(scales[k]) or 1.0, unit)


def momenta_along(motion: Trajectory) -> np.ndarray:
    """Return linear momentum, angular about the origin and about the center, shape (n, 9)."""
    reference, q, v, t = motion.reference, motion.q, motion.v, motion.t

    def by_unit(momentum: Momentum) -> list[np.ndarray]:
        return [momentum.linear, np.hstack(momentum[1:])]

    parts = spot_check(
        lambda: by_unit(reference.quick_momenta(q, v, t)),
        lambda at: by_unit(reference.momentum(q[at], v[at], t[at])),
        len(t),
    )
    return np.hstack(parts)


def _scales(sizes: np.ndarray) -> np.ndarray:
    """What each momentum is compared with; one that is zero, with what its parts could have."""
    return np.where(sizes > NO_MOMENTUM * sizes.max(), sizes, sizes.max())
