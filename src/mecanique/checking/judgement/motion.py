"""Judge equations of motion: do they hold for the true accelerations, and determine these?"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from itertools import pairwise, permutations
from typing import final

import numpy as np
import numpy.typing as npt

from mecanique.arrays import Array, rank_of
from mecanique.checking.grammar.reader import Statement
from mecanique.checking.grammar.tape import (
    OPAQUE,
    FormulaTape,
    FormulaValues,
    Rows,
    find_sign_changes,
)
from mecanique.checking.grammar.tree import Node, add, negate, number
from mecanique.checking.judgement.truth import Sample, Truth
from mecanique.errors import FormulaError
from mecanique.model.mechanism.description import angles

EQUATION_HOLDS = 1e-8
"""A difference below this part of the formula's terms is rounding."""

_ROUNDING = 1e-13
"""Error of a vanishing acceleration, relative to the usual size of accelerations."""

_RANK = 1e-7
_RANKED = 6
"""Number of states in which the rank of the equations is determined."""

_LINES = 3
"""Number of lines through the true accelerations that a nonlinear equation is followed along."""

_REACHES = np.logspace(-4, 4, 49)
"""How far along them, in usual accelerations."""

_HALVINGS = 60
_ROOT = 1e-6
"""A sign changes at a root if the equation falls below this part of its value beside it."""

_FEWEST = 6
"""Least number of states in which a formula must be finite."""


@final
@dataclass(frozen=True, eq=False)
class Residual:
    """An equation, as left minus right, with the true accelerations of many states."""

    statement: Statement  # the line in which it was written
    root: Node  # left minus right
    truth: Truth  # the equations that it is compared with
    sample: Sample

    @cached_property
    def tape(self) -> FormulaTape:
        """Left minus right as a list of parts."""
        return FormulaTape(self.root)

    @cached_property
    def values(self) -> FormulaValues:
        """The values of all parts."""
        return self.evaluate({})

    def evaluate(self, moved: Mapping[str, Array]) -> FormulaValues:
        """Return the values of all parts where some letters have others, shape (n,) each."""
        return self.tape.evaluate({**self.sample.letters, **moved}, self.sample.count)

    @cached_property
    def finite(self) -> npt.NDArray[np.bool_]:
        """Whether it has a value, in each state."""
        return np.isfinite(self.values.whole) & np.isfinite(self.values.size)

    @cached_property
    def relative(self) -> Array:
        """Its size relative to that of its terms, shape (n,); zero where it has no value."""
        differences = self.values.relative
        counts = self.finite & (self.values.size > 0)
        if (differences[counts] > EQUATION_HOLDS).any():
            counts &= np.abs(self.values.whole) > self._rounding
        return np.where(counts, differences, 0.0)

    @cached_property
    def _rounding(self) -> Array:
        """The effect of rounding; the error of a vanishing acceleration scales with usual ones."""
        slopes = np.nan_to_num(np.abs(self.by_acceleration), posinf=0.0)
        return np.asarray(_ROUNDING * np.einsum("ni,ni->n", slopes, self.sample.usual))

    def find_idle(self, far: FormulaValues | None = None) -> Node | None:
        """Return a term too small to be seen in any state, also far out; None if there is none."""
        weights = np.zeros(len(self.tape.nodes))
        for values in (self.values, self._moved, *(() if far is None else (far,))):
            slopes = self.tape.slopes(values)
            # by the sizes of its own terms, so that an identity counts
            shares = np.abs(np.stack(slopes)) * np.stack(values.sizes) / values.size
            shares[~np.isfinite(shares)] = 0.0
            weights = np.maximum(weights, shares.max(axis=1))
        hidden = [False] * len(weights)
        for k in reversed(range(len(weights))):
            parent, node = self.tape.parents[k], self.tape.nodes[k]
            hidden[k] = node.name in OPAQUE or (parent >= 0 and hidden[parent])
            if hidden[k] or weights[k] > EQUATION_HOLDS:
                continue
            is_term = parent >= 0 and self.tape.nodes[parent].kind == "sum"
            if is_term and not any(part.is_zero for part in node.walk()):
                return node
        return None

    @property
    def worst(self) -> float:
        """The largest relative difference."""
        return float(self.relative.max())

    @property
    def holds(self) -> bool:
        """Whether it holds in every state."""
        return self.worst <= EQUATION_HOLDS

    @cached_property
    def slopes(self) -> list[Array]:
        """Its derivatives by each of its parts."""
        return self.tape.slopes(self.values)

    @cached_property
    def by_acceleration(self) -> Array:
        """Its derivatives by the accelerations, shape (n, nv)."""
        columns = [self.tape.along(self.slopes, name) for name in self.truth.accelerations]
        return np.stack(columns, axis=-1)

    @cached_property
    def by_unknown(self) -> Array:
        """Its derivatives by the accelerations and multipliers, shape (n, nv + m)."""
        columns = [self.tape.along(self.slopes, name) for name in self.truth.multipliers]
        return np.concatenate([self.by_acceleration, *(c[:, None] for c in columns)], axis=1)

    @cached_property
    def _moved(self) -> FormulaValues:
        """Its values with other accelerations; with constraints, in other states altogether."""
        # each is changed by a different amount, or x'' = y'' would hold as well
        truth = self.truth
        names = truth.moving if truth.multipliers else truth.accelerations
        moved = {
            name: self.sample.values[name]
            + (1.0 + 0.37 * k) * (1 + np.abs(self.sample.values[name]))
            for k, name in enumerate(names)
        }
        return self.evaluate(moved)

    @cached_property
    def says_nothing(self) -> bool:
        """Whether it holds for any motion, as 0 = 0 does."""
        if not self.holds:
            return False
        changed = np.abs(self._moved.whole - self.values.whole) / self._moved.size
        return bool(np.nanmax(np.where(np.isfinite(changed), changed, 0.0)) <= EQUATION_HOLDS)

    @cached_property
    def is_affine(self) -> bool:
        """Whether it is linear in the accelerations, on both sides of the true ones."""
        before = self.sample.letters
        steps = []
        for factor in (-1.0, 1.0, 2.0):
            moved = {
                name: before[name] + factor * (1.0 + np.abs(before[name]))
                for name in self.truth.accelerations
            }
            steps.append(self.evaluate(moved))
        back, first, second = steps
        bend = np.abs(second.whole - 2 * first.whole + self.values.whole)
        kink = np.abs(first.whole - 2 * self.values.whole + back.whole)
        curvature = np.fmax(bend, kink) / second.size
        return bool(np.nanmax(np.where(np.isfinite(curvature), curvature, 0.0)) <= EQUATION_HOLDS)

    @cached_property
    def emptiness(self) -> str:
        """Why an equation that holds does not determine the motion, "" if it does."""
        # one that is not linear in the accelerations is followed along lines through the true
        # ones: it must change its sign there, and nowhere else
        if self.says_nothing:
            return "it holds for any motion"
        if self.is_affine:
            return ""
        names = self.truth.accelerations
        usual = np.sqrt(np.mean(self.sample.a**2, axis=0))
        scale = np.where(usual > 0, usual, 1.0)
        directions = np.random.default_rng(0).normal(size=(_LINES, len(names))) * scale
        states = np.repeat(np.arange(self.sample.count), _LINES)
        way = np.tile(directions, (self.sample.count, 1))

        def follow(lines: Rows, steps: Array) -> Array:
            """Return its values at steps along lines from the true accelerations."""
            moved = self.sample.a[states[lines]] + steps[:, None] * way[lines]
            some = {name: x[states[lines]] for name, x in self.sample.letters.items()}
            some |= dict(zip(names, moved.T, strict=True))
            return self.tape.whole(some, len(lines))

        every, step = np.arange(len(states)), np.full(len(states), _REACHES[0])
        if (follow(every, -step) * follow(every, step) > 0).mean() > 0.5:
            return "it only touches zero: a square or a magnitude does not determine accelerations"
        for reaches in (-_REACHES, _REACHES):
            lines, steps, left = find_sign_changes(follow, len(states), reaches, _HALVINGS)
            roots = np.flatnonzero(left < _ROOT)
            if len(roots):
                line, reach = lines[roots[0]], steps[roots[0]]
                a = self.sample.a[states[line]]
                wrong = a + reach * way[line]
                said = ", ".join(f"{name} = {x:.4g}" for name, x in zip(names, wrong, strict=True))
                true = ", ".join(f"{x:.4g}" for x in a)
                return f"it holds for other motions, too, as for {said} instead of {true}"
        return ""

    @cached_property
    def has_factor_of_velocities(self) -> bool:
        """Whether it has a factor that depends on velocities, and may vanish."""
        before = self.sample.letters
        values = self.evaluate({name: -1.7 * before[name] for name in self.truth.velocities})
        slopes = self.tape.slopes(values)
        columns = [self.tape.along(slopes, name) for name in self.truth.accelerations]
        after = np.stack(columns, axis=-1)
        scale = np.abs(after) + np.abs(self.by_acceleration)
        changes = np.abs(after - self.by_acceleration) / scale
        known = np.isfinite(changes) & (scale > 0)
        return bool((changes[known] > 1e-6).any())


def residuals(
    statements: Sequence[Statement], truth: Truth, sample: Sample, text: str
) -> list[Residual]:
    """Evaluate every equation of some lines at the true accelerations."""
    equations = []
    for statement in statements:
        first, *others = statement.sides
        pairs = pairwise(statement.sides) if others else [(first, number(0))]
        for left, right in pairs:
            root = add(left, negate(right).at(right.start, right.end))
            residual = Residual(statement, root, truth, sample)
            if residual.finite.sum() < min(_FEWEST, sample.count):
                raise FormulaError(
                    f"the formula has a value at {int(residual.finite.sum())} of {sample.count} "
                    "states; look for a division by zero or the root of a negative number",
                    text,
                    root.start,
                )
            equations.append(residual)
    return equations


def count_missing(equations: Sequence[Residual]) -> int:
    """Return the number of accelerations that equations and constraints leave undetermined."""
    sample, truth = equations[0].sample, equations[0].truth
    names = (*truth.accelerations, *truth.multipliers)
    rows = _slopes(equations, names)
    ties = np.zeros((sample.count, sample.slopes.shape[1], rows.shape[2]))
    ties[:, :, : sample.slopes.shape[2]] = sample.slopes
    # in the unit of each acceleration's own inertia
    scale = np.ones(rows.shape[2])
    inertia = np.sqrt(np.abs(np.diagonal(sample.M, axis1=1, axis2=2))).mean(0)
    scale[: len(inertia)] = np.where(inertia > 0, inertia, 1.0)
    whole = np.concatenate([rows, ties], axis=1) / scale
    whole = whole[np.isfinite(whole).all((1, 2))]
    if not len(whole):
        return len(inertia)
    size = np.linalg.norm(whole, axis=2, keepdims=True)
    whole = whole / np.where(size > 0, size, 1.0)
    return min(_count_open(matrix, len(inertia)) for matrix in whole[:_RANKED])


def count_rank(equations: Sequence[Residual]) -> int:
    """Return the number of equations that do not follow from each other."""
    rows = np.nan_to_num(_slopes(equations, equations[0].truth.moving)[:_RANKED])
    rows = rows / np.maximum(np.linalg.norm(rows, axis=2, keepdims=True), 1e-300)
    return int(np.linalg.matrix_rank(rows, tol=_RANK).max())


def _slopes(equations: Sequence[Residual], names: Sequence[str]) -> Array:
    """Return the derivative of each equation by each name in each state, shape (n, m, k)."""
    slopes = np.empty((equations[0].sample.count, len(equations), len(names)))
    for row, residual in enumerate(equations):
        for column, name in enumerate(names):
            slopes[:, row, column] = residual.tape.along(residual.slopes, name)
    return slopes


def _count_open(matrix: Array, accelerations: int) -> int:
    """Return the number of independent accelerations that the rows of a matrix leave free."""
    _, sizes, axes = np.linalg.svd(matrix)
    free = axes[rank_of(sizes, _RANK) :, :accelerations]
    return int((np.linalg.svd(free, compute_uv=False) > _RANK).sum()) if len(free) else 0


def combine_angles(names: Sequence[str], values: Mapping[str, Array]) -> dict[str, Array]:
    """Return angles, their differences and sums, by their formulas."""
    combined = {name: values[name] for name in names}
    for first, second in permutations(names, 2):
        combined[f"{first} - {second}"] = values[first] - values[second]
        if first < second:
            combined[f"{first} + {second}"] = values[first] + values[second]
    return combined


_PATHS = 5
_STEPS = 61
_FACTOR_HALVINGS = 40
_ZERO = 1e-7
"""A factor vanishes if it is below this part of its value a step before."""


@final
class CommonFactors:
    """Finds factors along paths on which every coordinate moves, for a mechanism without loops."""

    # An equation is Σ w (M a + rest); where a factor passes zero, all weights w change their
    # signs at once.

    def __init__(self, truth: Truth) -> None:
        self._truth = truth

    def list_forms(self, residual: Residual) -> tuple[str, ...]:
        """Return how an equation that holds deviates from the usual form."""
        if not residual.is_affine:
            return ("not linear in the accelerations",)
        if residual.has_factor_of_velocities:
            return ("not divided by a common factor that depends on velocities",)
        factor = self._explain(residual)
        return (factor,) if factor else ()

    def _explain(self, residual: Residual) -> str:
        """Return in words where an equation is multiplied by zero, "" if nowhere."""
        truth = self._truth
        if truth.derivation is None or truth.mechanism.constrained:
            return ""
        if residual.root.letters & set(truth.sample.lengths):
            return ""
        weigh = partial(self._weigh, residual.tape)
        grid = np.linspace(0.0, 1.0, _STEPS)
        count = len(self._starts)
        paths, along, left = find_sign_changes(weigh, count, grid, _FACTOR_HALVINGS)
        vanishes = left <= _ZERO
        if not vanishes.any():
            return ""
        where = self._name(paths[vanishes], along[vanishes])
        return f"multiplied by a factor that vanishes where {where}: it says nothing there"

    def sample_paths(self) -> tuple[dict[str, Array], Array, int]:
        """Return letters and mass matrices at the points of all paths, and the points of each."""
        paths = np.repeat(np.arange(len(self._starts)), _STEPS)
        letters = self._locate(paths, np.tile(np.linspace(0.0, 1.0, _STEPS), len(self._starts)))
        return letters, self._truth.at(letters, len(paths)).M, _STEPS

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

    def _locate(self, paths: Rows, along: Array) -> dict[str, Array]:
        """Return the value of each letter at points of paths."""
        positions = self._truth.sample.at(paths)
        return positions | {
            name: positions[name] + along * step[paths] for name, step in self._steps.items()
        }

    def _weigh(self, tape: FormulaTape, paths: Rows, along: Array) -> Array:
        """Return the weight of each true equation, shape (k, nv)."""
        letters = self._locate(paths, along)
        n, nv = len(paths), len(self._truth.velocities)
        by = np.empty((n, nv))
        done = 0
        for values in tape.blocks(letters, n):
            slopes = tape.slopes(values)
            some = slice(done, done + len(values.whole))
            for column, name in enumerate(self._truth.accelerations):
                by[some, column] = tape.along(slopes, name)
            done = some.stop
        M = self._truth.at(letters, n).M
        whole = np.isfinite(M).all((1, 2)) & np.isfinite(by).all(1)
        M[~whole], by[~whole] = np.eye(nv), 0.0
        return np.asarray((np.linalg.pinv(M) @ by[..., None])[..., 0])

    def _name(self, paths: Rows, along: Array) -> str:
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
        angular = [name for name in names if name in turning]
        for formula, value in combine_angles(angular, letters).items():
            yield f"sin({formula})", np.sin(value)
            yield f"cos({formula})", np.cos(value)
