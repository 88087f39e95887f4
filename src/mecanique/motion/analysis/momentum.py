"""Balances of linear and angular momentum along a motion."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, final

import numpy as np

from mecanique.motion.compile.along import MANY, StateLaw
from mecanique.motion.record.quadrature import POINTS, integral
from mecanique.motion.tolerances import NO_MOMENTUM, UNCHANGED
from mecanique.motion.trajectory import stretches_of
from mecanique.wording import Legible

if TYPE_CHECKING:
    from mecanique.motion.trajectory import Trajectory


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
    negligible = UNCHANGED * np.repeat(_scales(sizes), 3) / duration
    given = integral(motion.curve, rates, motion.t, smooth=9, negligible=negligible)
    jumps = np.zeros_like(have)
    for event in motion.events:
        if event.impact:
            before, after = (
                np.hstack(reference.momentum(event.q, v, event.t)) for v in (event.v, event.after)
            )
            jumps += (motion.t >= event.t)[:, None] * (after - before)
    residual = have - have[0] - (jumps - jumps[0]) - given[:, :9]
    scales = _scales(sizes + given[-1, 9:])
    scales[scales == 0] = 1.0
    return residual, np.tile(scales, (len(residual), 1))


def _scales(sizes: np.ndarray) -> np.ndarray:
    """What each momentum is compared with; one that is zero, with what its parts could have."""
    return np.where(sizes > NO_MOMENTUM * sizes.max(), sizes, sizes.max())
