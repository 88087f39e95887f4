"""Statistics of an integration: steps, evaluations, time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final


@final
@dataclass(frozen=True)
class Statistics:
    """Steps, evaluations and time of an integration.

    Args:
        steps: number of steps.
        evaluations: number of evaluations of the equations.
        seconds: time it took, the reference's construction included [s].
        rtol: relative tolerance of a step.
        atol: absolute tolerance of a step.
    """

    steps: int
    evaluations: int
    seconds: float
    rtol: float
    atol: float
