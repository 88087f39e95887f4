"""Steady motions: coordinates on which no motion depends turn uniformly, the others rest."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import final

import numpy as np

from mecanique.arrays import Array
from mecanique.checking.judgement.equilibria import equilibria_of
from mecanique.checking.judgement.truth import Truth
from mecanique.errors import InputError

_ROUNDING = 1e-12
"""Forces below this part of those in random motions are rounding."""

INDEPENDENT = 1e-9
"""A constraint with a smaller part of the largest slope repeats others."""


@final
class SteadyMotions:
    """The steady motions at the positions of the random states.

    Raises:
        InputError: if nothing may turn while the rest stays where it is.
    """

    def __init__(self, truth: Truth) -> None:
        self._truth = truth
        names = [name.removesuffix("'") for name in truth.velocities]
        equilibria = equilibria_of(truth)
        felt = [k for k, name in enumerate(names) if name in equilibria.felt]
        # where something rolls, slides follow hinges, and what is felt follows what is not
        order = sorted(
            range(len(names)), key=lambda k: (names[k] in equilibria.turning, k not in felt)
        )
        self._J = truth.sample.slopes
        self._following, free, self._allowed = _solve(self._J, order)
        _, turning, turns = _solve(self._allowed[:, felt], range(len(free)))
        self._turns = self._allowed @ turns
        self.rates = tuple(truth.velocities[free[k]] for k in turning)
        if (
            not self.rates
            or truth.driven
            or (len(free) < len(names) and truth.mechanism.quaternions)
        ):
            raise InputError(
                f"{truth.mechanism.name!r} has no coordinate that may turn uniformly while the "
                "others rest"
            )

    def at(self, rates: Mapping[str, Array | float]) -> dict[str, Array]:
        """Return the letters that change in the motion at given rates, others as in the states."""
        truth, sample = self._truth, self._truth.sample
        given = [
            np.broadcast_to(rates.get(name, sample.values[name]), sample.count)
            for name in self.rates
        ]
        velocity = np.einsum("nij,jn->in", self._turns, np.array(given))
        inputs = [signal.symbol for signal in truth.mechanism.inputs]
        values = dict.fromkeys(inputs, np.zeros(sample.count))
        values |= zip(truth.velocities, velocity, strict=True)
        acceleration = np.zeros_like(velocity)
        if following := self._following:
            _, centripetal = truth.constraints(truth.at(values), sample.count)
            solved = np.linalg.pinv(self._J[:, :, following]) @ centripetal[..., None]
            acceleration[following] = -solved[..., 0].T
        return values | dict(zip(truth.accelerations, acceleration, strict=True))

    def choose(self) -> dict[str, Array]:
        """Return the letters of one steady motion in each state; NaN where there is none."""
        truth = self._truth
        if truth.multipliers:
            raise InputError(
                f"small motions about steady ones of {truth.mechanism.name!r}, which has "
                "constraints, are not judged; mq.linearize_steady computes them"
            )
        for name in self.rates:
            try:
                return self.at({name: self.find_rates(name)[1]})
            except InputError:
                if name == self.rates[-1]:
                    raise
        raise AssertionError("there are rates")

    def balance(self, values: Mapping[str, Array]) -> Array:
        """Return the forces that are left along displacements that constraints allow, (k, n)."""
        here = self._truth.at(values)
        acceleration = np.stack([values[name] for name in self._truth.accelerations], axis=-1)
        force = np.einsum("nij,nj->ni", here.M, acceleration) + here.rest
        return np.asarray(np.einsum("nik,ni->kn", self._allowed, force))

    def find_rates(self, name: str) -> Array:
        """Return both values of a rate in each state, shape (2, n); NaN where there are none."""
        rows = np.array([self.balance(self.at({name: turning})) for turning in (-1.0, 0.0, 1.0)])
        sample = self._truth.sample
        usual = np.abs(sample.bias - sample.forces).max(initial=0.0)
        acting = np.flatnonzero(np.abs(rows).max(axis=(0, 2)) > _ROUNDING * usual)
        if len(acting) > 1:
            raise InputError(
                "the steady motions follow from several conditions; ask for equilibrium"
            )
        if not len(acting):
            raise InputError(f"with any {name} the motion is steady; there is nothing to ask for")
        below, rest, above = rows[:, acting[0]]
        square, linear = (above + below) / 2 - rest, (above - below) / 2
        # of what is linear in the rate, rounding leaves a square, with a second, huge root
        square[np.abs(square) <= _ROUNDING * np.abs(rows[:, acting[0]]).max(axis=0)] = 0.0
        with np.errstate(all="ignore"):
            root = np.sqrt(linear**2 - 4 * square * rest)
            # the sum does not cancel, and what is linear keeps one root
            larger = -(linear + np.copysign(root, linear)) / 2
            roots = np.stack([larger / square, rest / larger])
        roots[~np.isfinite(roots)] = np.nan
        if np.isnan(roots).all():
            raise InputError(
                f"{name} keeps {self._truth.mechanism.name!r} steady in none of the random states"
            )
        return np.sort(roots, axis=0)


def _solve(rows: Array, order: Sequence[int]) -> tuple[list[int], list[int], Array]:
    """Solve rows · x = 0, shape (n, m, k), for as many of x as possible, the first in an order.

    Returns them, the others, and what x is for unit values of these, shape (n, k, others).
    """
    following = list[int]()
    least = INDEPENDENT * np.abs(rows[0]).max(initial=0.0)
    for k in order:
        columns = rows[0][:, [*following, k]]
        if np.linalg.matrix_rank(columns, least) > len(following):
            following.append(k)
    n, _, count = rows.shape
    others = [k for k in range(count) if k not in following]
    whole = np.zeros((n, count, len(others)))
    whole[:, others] = np.eye(len(others))
    whole[:, following] = -np.linalg.pinv(rows[:, :, following]) @ rows[:, :, others]
    return following, others, whole
