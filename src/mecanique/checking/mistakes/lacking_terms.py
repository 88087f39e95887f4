"""Find terms of the true quantity that a formula lacks, or has with a wrong factor."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from mecanique.checking.budget import spend
from mecanique.checking.judgement.motion import Residual
from mecanique.checking.mistakes.repairs.repair import ALIKE, Repair
from mecanique.checking.mistakes.slips.terms import list_parts
from mecanique.derivation.printing.equations import expression
from mecanique.derivation.scalars.evaluation import Evaluation
from mecanique.derivation.scalars.series import Series

_WORDS = (
    (1.0, "missing", "{} is missing"),
    (2.0, "sign", "the sign of {} is wrong"),
    (-1.0, "factor", "{} is counted twice"),
    (0.5, "factor", "{} is halved"),
)
"""The truth minus the answer as a multiple of a part of the truth, with kind and words."""


def find_lacking(one: Residual, series: Mapping[str, Series]) -> Iterator[Repair]:
    """Yield parts of the true quantity whose absence or factor explains a formula.

    Args:
        one: the formula minus its true value.
        series: the true values of the letters of quantities.
    """
    named = [name for name in series if name in one.root.letters]
    if len(named) != 1:
        return
    slope = one.tape.along(one.slopes, named[0])
    with np.errstate(all="ignore"):
        lacks = one.values.whole / slope
    usable = one.finite & np.isfinite(lacks)
    if not usable.any():
        return
    truth = series[named[0]]
    evaluated = Evaluation(truth.ring, one.sample.values)
    for part in list_parts(truth, one.truth.velocities):
        spend()
        own = np.broadcast_to(evaluated(part), lacks.shape)
        for factor, kind, words in _WORDS:
            scale = np.abs(factor * own) + np.abs(lacks)
            if (np.abs(lacks - factor * own) <= ALIKE * scale)[usable].all():
                text = words.format(f"the term {expression(part).text()}")
                yield Repair(kind, text, "", 1.1 if factor == 1.0 else 1.6)
