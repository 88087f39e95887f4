"""Find factors of equations of motion that vanish somewhere, where the equation says nothing."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property
from itertools import combinations
from typing import Any, final

import numpy as np
import numpy.typing as npt

from mecanique.arrays import Array
from mecanique.checking.grammar.tape import Tape
from mecanique.checking.judgement.motion import Residual
from mecanique.checking.judgement.truth import Truth
from mecanique.derivation.scalars.evaluation import Evaluation
from mecanique.model.random_positions import angles

_PATHS = 5
_STEPS = 61
_HALVINGS = 40
_ZERO = 1e-7
"""A factor vanishes if it is below this part of its value a step before."""

Numbers = npt.NDArray[Any]


@final
class Factors:
    """Finds factors along paths on which every coordinate moves, for a mechanism without loops.

    An equation is Σ w (M a + rest) with some weights w; if it is multiplied by a factor that
    passes zero, all weights vanish and change their signs there at once.
    """

    def __init__(self, truth: Truth) -> None:
        self._truth = truth

    def explain(self, one: Residual) -> str:
        """Return in words where an equation is multiplied by zero, "" if nowhere."""
        truth = self._truth
        if truth.derivation is None or truth.mechanism.constrained:
            return ""
        if one.root.letters & set(truth.sample.lengths):
            return ""
        paths = np.repeat(np.arange(len(self._starts)), _STEPS)
        along = np.tile(np.linspace(0.0, 1.0, _STEPS), len(self._starts))
        weights = self._weigh(one.tape, paths, along).reshape(len(self._starts), _STEPS, -1)
        with np.errstate(all="ignore"):
            product = np.einsum("psv,psv->ps", weights[:, :-1], weights[:, 1:])
        path, step = np.nonzero(product < 0)
        if not len(path):
            return ""
        low: Numbers = step / (_STEPS - 1)
        high: Numbers = (step + 1) / (_STEPS - 1)
        first = weights[path, step]
        for _ in range(_HALVINGS):
            middle = (low + high) / 2
            same = np.einsum("kv,kv->k", self._weigh(one.tape, path, middle), first) > 0
            low, high = np.where(same, middle, low), np.where(same, high, middle)
        left = np.linalg.norm(self._weigh(one.tape, path, low), axis=1)
        with np.errstate(all="ignore"):
            vanishes = left <= _ZERO * np.linalg.norm(first, axis=1)
        if not vanishes.any():
            return ""
        where = self._name(path[vanishes], low[vanishes])
        return f"multiplied by a factor that vanishes where {where}: it says nothing there"

    @cached_property
    def _starts(self) -> npt.NDArray[np.int64]:
        return np.arange(min(_PATHS, self._truth.sample.count))

    @cached_property
    def _steps(self) -> dict[str, Array]:
        """The displacement of each coordinate on each path: full turns, or to another state."""
        turning = angles(self._truth.mechanism)
        values, starts = self._truth.sample.values, self._starts
        steps = {}
        for k, name in enumerate(self._truth.mechanism.coordinates):
            if name in turning:
                steps[name] = 2 * np.pi * (1 + 0.17 * np.cos(3 * starts + k))
            else:
                steps[name] = np.roll(values[name], 1 + k)[starts] - values[name][starts]
        return steps

    def _locate(self, paths: Numbers, along: Array) -> dict[str, Array]:
        """Return the value of each letter at points of paths."""
        found = {
            name: np.broadcast_to(value, (self._truth.sample.count,))[paths]
            for name, value in self._truth.sample.values.items()
        }
        return found | {
            name: found[name] + along * step[paths] for name, step in self._steps.items()
        }

    def _weigh(self, tape: Tape, paths: Numbers, along: Array) -> Array:
        """Return the weight of each true equation, shape (k, nv)."""
        derivation = self._truth.derivation
        assert derivation is not None
        letters = self._locate(paths, along)
        n, nv = len(paths), len(derivation.M)
        by = np.empty((n, nv))
        for some in tape.blocks(n):
            values = tape.evaluate({k: x[some] for k, x in letters.items()}, len(paths[some]))
            slopes = tape.slopes(values)
            for column, name in enumerate(self._truth.accelerations):
                by[some, column] = tape.along(slopes, name)
        evaluated = Evaluation(derivation.algebra.ring, letters)
        M = np.empty((n, nv, nv))
        with np.errstate(all="ignore"):
            for i, row in enumerate(derivation.M):
                for j, entry in enumerate(row):
                    M[:, i, j] = evaluated(entry)
        whole = np.isfinite(M).all((1, 2)) & np.isfinite(by).all(1)
        M[~whole], by[~whole] = np.eye(nv), 0.0
        return np.asarray((np.linalg.pinv(M) @ by[..., None])[..., 0])

    def _name(self, paths: Numbers, along: Array) -> str:
        """Return a condition that holds at some points: on a sine or cosine, or values."""
        letters = self._locate(paths, along)
        for formula, value in self._conditions(letters):
            if (np.abs(value) <= 1e-6).all():
                return f"{formula} = 0"
        names = self._truth.mechanism.coordinates
        return ", ".join(f"{name} = {letters[name][0]:.4g}" for name in names)

    def _conditions(self, letters: dict[str, Array]) -> Iterator[tuple[str, Array]]:
        names = list(self._truth.mechanism.coordinates)
        turning = angles(self._truth.mechanism)
        for name in names:
            yield name, letters[name]
        arguments = {name: letters[name] for name in names if name in turning}
        for one, other in combinations(list(arguments), 2):
            arguments[f"{one} - {other}"] = letters[one] - letters[other]
            arguments[f"{one} + {other}"] = letters[one] + letters[other]
        for formula, value in arguments.items():
            yield f"sin({formula})", np.sin(value)
            yield f"cos({formula})", np.cos(value)
