"""Derive equations of motion in-house, from a mechanism's description alone."""

from __future__ import annotations

from mecanique.derivation.equations import Solved
from mecanique.derivation.methods import METHODS, derive
from mecanique.derivation.reduction import Reduction, routh
from mecanique.derivation.single_equation import SingleEquation, reduce_loops

__all__ = [
    "METHODS",
    "Reduction",
    "SingleEquation",
    "Solved",
    "derive",
    "reduce_loops",
    "routh",
]
