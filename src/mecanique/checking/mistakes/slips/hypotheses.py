"""Derive the wrong equations of motion that known mistakes give, and their accelerations.

Each hypothesis changes the true equations, and is recognized by the accelerations that follow:
an answer with that mistake holds for these, however it is multiplied, combined or solved.
"""

from __future__ import annotations

from functools import cached_property
from typing import final

import numpy as np

from mecanique.arrays import Array
from mecanique.checking.judgement.truth import Truth, accelerate
from mecanique.checking.mistakes.slips.constraints import mistake_constraints
from mecanique.checking.mistakes.slips.hypothesis import Hypothesis, RightEquations
from mecanique.checking.mistakes.slips.operators import mistake_operator
from mecanique.checking.mistakes.slips.parts import mistake_parts
from mecanique.checking.mistakes.slips.readings import linearize, mistake_angles, mistake_readings
from mecanique.checking.mistakes.slips.terms import mistake_letters, mistake_terms

_SINGULAR = 1e-12


@final
class Hypotheses:
    """All hypotheses about a mechanism, with the accelerations that they lead to.

    Args:
        truth: the right equations.
    """

    def __init__(self, truth: Truth) -> None:
        self._truth = truth
        self._sample = truth.sample

    @cached_property
    def _led(self) -> list[tuple[Hypothesis, Array]]:
        """Every hypothesis that determines a motion other than the right one, with that motion."""
        if self._truth.derivation is None:
            return []
        right = RightEquations(self._truth, self._truth.derivation)
        found = [
            *mistake_terms(right),
            *mistake_letters(right),
            *mistake_operator(right),
            *mistake_readings(right),
            *mistake_parts(right),
        ]
        if self._truth.mechanism.constrained:
            found += mistake_constraints(right)
        else:
            found += [*mistake_angles(right), *linearize(right)]
        led = ((one, self._lead(one)) for one in found)
        return [(one, motion) for one, motion in led if motion is not None]

    @property
    def listed(self) -> tuple[Hypothesis, ...]:
        """Every hypothesis whose equations determine the motion and differ from the right ones."""
        return tuple(one for one, _ in self._led)

    @cached_property
    def motions(self) -> Array:
        """The accelerations and multipliers of each hypothesis, shape (hypotheses, n, nv + m)."""
        found = [motion for _, motion in self._led]
        return np.stack(found) if found else np.zeros((0, *self._sample.motion.shape))

    def _lead(self, one: Hypothesis) -> Array | None:
        """Return a hypothesis's accelerations and multipliers, None if undetermined."""
        sample = self._sample
        if not (np.isfinite(one.M).all() and np.isfinite(one.rest).all()):
            return None
        scale = np.abs(sample.M).max((1, 2)) ** sample.M.shape[-1]
        alone = np.abs(np.linalg.det(one.M)) > _SINGULAR * scale
        if not (alone.all() or sample.slopes.shape[1]):
            return None
        J = sample.slopes
        if one.released:
            J = J.copy()
            J[:, list(one.released)] = 0.0
        own = -np.einsum("nmv,nv->nm", J, sample.a)
        a, multipliers = accelerate(one.M, -one.rest, J, own)
        if not (np.abs(a - sample.a) > 1e-7 * np.abs(sample.a)).any():
            return None
        return np.concatenate([a, multipliers], axis=1)
