"""Single changes of a mechanism that a mistake would make, each with what it would answer."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np
import numpy.typing as npt

from mecanique.verify.evidence import Evidence

__all__ = ["Change", "fitted"]

Array = npt.NDArray[np.float64]


@final
@dataclass(frozen=True, eq=False)
class Change:
    """A change and what the changed mechanism would answer.

    Args:
        kind: of the mistake, e.g. "armature".
        where: link, joint or coordinate, or empty for the whole mechanism.
        text: what the other source seems to do, in a sentence.
        answers: what the changed mechanism predicts, shape (n, nv).
        free: how many numbers were chosen so that it fits.
    """

    kind: str
    where: str
    text: str
    answers: Array
    free: int = 0


def fitted(evidence: Evidence, columns: Array) -> tuple[Array, Array]:
    """Return the amounts of some effects that fit best, shape (k,), and what they answer, shape (n, nv).

    Args:
        evidence: what is to be fitted.
        columns: what a unit of each adds, shape (k, n, nv).
    """
    flat = (columns * evidence.weights).reshape(len(columns), -1)
    size = np.sqrt(np.sum(flat * flat, axis=1))
    used = size > 1e-12 * max(float(size.max(initial=0.0)), 1e-300)
    amounts = np.zeros(len(columns))
    if used.any():
        rest = ((evidence.tau - evidence.base) * evidence.weights).ravel()
        solution = np.linalg.lstsq((flat[used] / size[used, None]).T, rest, rcond=1e-10)[0]
        amounts[used] = solution / size[used]
    return amounts, evidence.base + np.einsum("k,knv->nv", amounts, columns)
