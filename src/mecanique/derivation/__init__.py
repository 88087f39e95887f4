"""Derive equations of motion in-house, from a mechanism's description alone."""

from __future__ import annotations

from mecanique.derivation.equations import Solved
from mecanique.derivation.methods import METHODS, derive
from mecanique.derivation.reduction import Reduction, SingleEquation, reduce_loops, routh

__all__ = [
    "METHODS",
    "Reduction",
    "SingleEquation",
    "Solved",
    "derive",
    "reduce_loops",
    "routh",
]
