"""Single changes that a mistake makes to a mechanism, each with the answers it gives."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Protocol, TypeVar, final

import numpy as np
import numpy.typing as npt

from mecanique.arrays import Array
from mecanique.verification.causes.evidence import Evidence
from mecanique.verification.causes.fitted import Amount

_MOST = 4000
"""Experiments evaluated at once."""

_CLOSER = 8
"""Guesses that get a closer look."""


class Guess(Protocol):
    """What a change is called before it is known what it answers."""

    @property
    def kind(self) -> str:
        """Of the mistake."""

    @property
    def where(self) -> str:
        """Link, joint or coordinate, or empty for the whole mechanism."""

    @property
    def text(self) -> str:
        """What the other source seems to do."""


_G = TypeVar("_G", bound=Guess)


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
        amount: how plain these are.
        origins: frames of the changed mechanism's joints, by place in the tree.
        moments: its links' mass moments, by place.
        turns: how the axes of its joints are turned in their frames, by place; a change with none
            of these only adds to the answers.
        slopes: of the answers by each number chosen, shape (free, n, nv).
    """

    kind: str
    where: str
    text: str
    answers: Array
    free: int = 0
    amount: Amount = field(default_factory=Amount)
    origins: Mapping[int, Array] = field(default_factory=dict)
    moments: Mapping[int, Array] = field(default_factory=dict)
    turns: Mapping[int, Array] = field(default_factory=dict)
    slopes: Array | None = None

    @property
    def in_tree(self) -> bool:
        """Whether it changes the tree itself, so that others can be looked for beside it."""
        return bool(self.origins or self.moments or self.turns)


def promising(
    evidence: Evidence,
    guesses: Iterable[_G],
    answer: Callable[[list[_G], npt.NDArray[np.intp]], Array],
) -> Iterator[Change]:
    """Yield the guesses that explain a few experiments best, with what they answer in all of them.

    Args:
        evidence: what is to be explained.
        guesses: what may be the matter.
        answer: gives what some guesses answer in the experiments of some indices, shape (guesses,
            n, nv).
    """

    def answers(some: list[_G], rows: npt.NDArray[np.intp]) -> Array:
        lot = max(1, _MOST // len(rows))
        return np.concatenate([answer(some[k : k + lot], rows) for k in range(0, len(some), lot)])

    kept = list(guesses)
    if len(kept) > _CLOSER:
        coarse = evidence.residual(answers(kept, evidence.few), evidence.few)
        kept = [kept[k] for k in np.argsort(coarse, kind="stable")[:_CLOSER]]
    if kept:
        for guess, found in zip(kept, answers(kept, np.arange(len(evidence.inputs))), strict=True):
            origins, moments, turns = (
                getattr(guess, name, {}) for name in ("origins", "moments", "turns")
            )
            yield Change(
                guess.kind,
                guess.where,
                guess.text,
                found,
                origins=origins,
                moments=moments,
                turns=turns,
            )


def fit(evidence: Evidence, columns: Array) -> tuple[Array, Array]:
    """Fit the amounts of some effects; return them, shape (k,), and their answers, shape (n, nv).

    Args:
        evidence: what to fit.
        columns: what a unit of each adds, shape (k, n, nv).
    """
    flat = evidence.weigh(columns)
    size = np.sqrt(np.sum(flat * flat, axis=1))
    used = size > 1e-12 * max(float(size.max(initial=0.0)), 1e-300)
    amounts = np.zeros(len(columns))
    if used.any():
        rest = evidence.weigh(evidence.tau - evidence.base)
        solution = np.linalg.lstsq((flat[used] / size[used, None]).T, rest, rcond=1e-10)[0]
        amounts[used] = solution / size[used]
    return amounts, evidence.base + np.einsum("k,knv->nv", amounts, columns)
