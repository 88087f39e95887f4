"""Judge sets of equilibria: each position by its balance, and all of them by a search of one's own.

The search starts Newton's method from a grid over the coordinates that matter, in a few states with
their own parameters. Of a coordinate that nothing feels, every value belongs to an equilibrium: an
answer leaves it open.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache, partial
from itertools import groupby, product
from typing import TypeAlias, final

import numpy as np
import numpy.typing as npt

from mecanique.arrays import Array
from mecanique.checking.budget import stop_clock
from mecanique.checking.grammar.reader import Statement, name_values
from mecanique.checking.grammar.tape import FormulaTape, Rows, find_sign_changes
from mecanique.checking.grammar.tree import Node, add, negate
from mecanique.checking.judgement.truth import SeriesValues, Truth
from mecanique.errors import FormulaError
from mecanique.model.mechanism_units import characteristic_length
from mecanique.model.random_positions import angles

_BALANCED = 1e-9
"""Forces balance if they add up to less than this part of their usual size."""

_GRID = 721
"""Number of values of a coordinate between which sign changes of a condition are sought."""

_HALVINGS = 60
_ZERO = 1e-9
"""A condition holds where it falls below this part of its usual value."""

_WIDE = 6.0
"""Lengths are sought up to this many characteristic lengths."""

_STATES = 4
"""Number of states, each with its own parameters, in which all equilibria are sought."""

_STARTS = {1: 48, 2: 16, 3: 8}
"""Starting values of each coordinate, by their number; of more coordinates none are sought."""

_ROUNDS = 40
_STEP = 0.3
"""Largest step of Newton's method, in radians or characteristic lengths."""

_SAME = 1e-6
"""Positions nearer than this, in radians or characteristic lengths, are the same."""

_ISOLATED = 1e-7
"""An equilibrium whose scaled stiffness has a smaller singular value belongs to a family."""

_MASSLESS = 1e-9
"""Part of a coordinate's usual inertia below which its position has no meaning."""

_SHOWN = 3
"""As many missing equilibria are named."""

_STATE = "#state"

INTEGERS = ("n", "k", "j", "i", "z")
"""Letters of integers, as in q = n π, unless the mechanism has them."""

_WHOLE = (-2.0, -1.0, 0.0, 1.0, 2.0)


@final
class Equilibria:
    """The equilibria of a mechanism, and positions that are said to be some."""

    def __init__(self, truth: Truth) -> None:
        sample = truth.sample
        self._truth = truth
        self._forces = truth.rest_forces
        self._usual = np.maximum(np.abs(sample.bias - sample.forces).mean(0), 1e-300)
        turning = angles(truth.mechanism)
        length = characteristic_length(truth.mechanism)
        self.coordinates = tuple(truth.mechanism.coordinates)
        self.turning = {name for name in self.coordinates if name in turning}
        self.size = {name: 1.0 if name in turning else length for name in self.coordinates}
        inputs = [signal.symbol for signal in truth.mechanism.inputs]
        moving = (*truth.velocities, *truth.accelerations, *inputs)
        still = dict.fromkeys((*self.coordinates, *moving), np.zeros(sample.count))
        self.at_zero: dict[str, Array] = {
            **sample.values,
            **still,
            _STATE: np.arange(sample.count, dtype=float),
        }
        acting = {g.name for force in self._forces for g in force.generators()}
        self.felt = tuple(name for name in self.coordinates if name in acting)

    def measure(self, values: dict[str, Array]) -> float:
        """Return the largest unbalanced force, relative to the usual size of forces."""
        here = self._truth.at(values, len(values[_STATE]))
        worst = float(np.abs(self._balance(here)).max(initial=0.0))
        return worst if worst > _BALANCED else 0.0

    def _balance(self, here: SeriesValues) -> Array:
        """Return the unbalanced forces, each relative to its usual size, shape (n, nv)."""
        return np.asarray(np.nan_to_num(here.stack(self._forces) / self._usual, nan=np.inf))

    @cached_property
    def all(self) -> dict[int, Array] | None:
        """Return every equilibrium in a few states, shape (k, felt); None if they are not known."""
        count = len(self.felt)
        if count not in _STARTS or self._truth.derivation is None:
            return None
        axes = []
        for name in self.felt:
            reach = np.pi if name in self.turning else _WIDE * self.size[name]
            axes.append(np.linspace(-reach, reach, _STARTS[count], endpoint=False) + 0.0123 * reach)
        starts = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, count)
        states = np.repeat(np.arange(min(_STATES, self._truth.sample.count)), len(starts))
        q = np.tile(starts, (len(states) // len(starts), 1))
        size = np.array([self.size[name] for name in self.felt])
        q, balance, stiffness = self._relax(states, q, _STEP)
        good = np.abs(balance).max(axis=1) <= _BALANCED
        good &= self._is_regular(states, q)
        for k, name in enumerate(self.felt):
            if name in self.turning:
                # half a turn is π, not −π
                q[:, k] = np.pi - np.mod(np.pi - q[:, k] + _SAME, 2 * np.pi) + _SAME
            else:
                good &= np.abs(q[:, k]) <= _WIDE * size[k]
        positions = {}
        for state in range(min(_STATES, self._truth.sample.count)):
            chosen = np.flatnonzero(good & (states == state))
            if len(chosen) and np.linalg.svd(stiffness[chosen])[1][:, -1].min() < _ISOLATED:
                return None
            kept: list[Array] = []
            for position in q[chosen]:
                if not any(self.is_same(position, listed) for listed in kept):
                    kept.append(position)
            positions[state] = np.array(kept).reshape(-1, count)
        return positions

    def cover(self, positions: Sequence[Position], true: Array, state: int) -> Array:
        """Return which of the true positions of a state, (k, felt), each one is, shape (n, k)."""
        table = np.zeros((len(positions), len(true)), dtype=bool)
        for row, position in enumerate(positions):
            at = np.flatnonzero(position.values[_STATE] == state)
            for named in np.stack([position.values[name][at] for name in self.felt], axis=-1):
                table[row] |= np.array([self.is_same(x, named) for x in true], dtype=bool)
        return table

    def find_nearest(self) -> dict[str, Array]:
        """Return the equilibrium that lies nearest to zero in every state; empty if none does."""
        count = self._truth.sample.count
        start = np.zeros((count, len(self.felt)))
        q, balance, _ = self._relax(np.arange(count), start, np.inf)
        if not len(self.felt) or not (np.abs(balance) <= _BALANCED).all():
            return {}
        return dict(zip(self.felt, q.T, strict=True))

    def _relax(self, states: Rows, q: Array, longest: float) -> tuple[Array, Array, Array]:
        """Return positions after Newton's method, with forces and stiffness there."""
        size = np.array([self.size[name] for name in self.felt])
        for _ in range(_ROUNDS):
            balance, stiffness = self._linearize(states, q, size)
            step = -(np.linalg.pinv(np.nan_to_num(stiffness)) @ balance[..., None])[..., 0]
            length = np.linalg.norm(step, axis=1, keepdims=True)
            step = step * np.minimum(1.0, longest / np.maximum(length, 1e-300))
            q = q + np.nan_to_num(step) * size
        return q, *self._linearize(states, q, size)

    def _linearize(self, states: Rows, q: Array, size: Array) -> tuple[Array, Array]:
        """Return forces and stiffness, scaled, shape (n, nv) and (n, nv, felt)."""
        here = self._locate(states, q)
        stiffness = here.slopes(self._forces, self.felt) * size / self._usual[:, None]
        return self._balance(here), stiffness

    def _locate(self, states: Rows, q: Array) -> SeriesValues:
        """Return the values of series in some states at positions, shape (n, felt)."""
        values = {name: value[states] for name, value in self.at_zero.items()}
        return self._truth.at(values | dict(zip(self.felt, q.T, strict=True)), len(q))

    def _is_regular(self, states: Rows, q: Array) -> npt.NDArray[np.bool_]:
        """Whether each coordinate moves mass: at r = 0, say, an angle about it means nothing."""
        inertia = np.einsum("nii->ni", self._locate(states, q).M)
        usual = np.einsum("nii->ni", self._truth.sample.M).mean(axis=0)
        return np.asarray((inertia > _MASSLESS * usual).all(axis=1))

    def is_same(self, first: Array, second: Array) -> bool:
        """Return whether two positions are the same, angles up to full turns."""
        for name, a, b in zip(self.felt, first, second, strict=True):
            step = (a - b) / self.size[name]
            if name in self.turning:
                step = np.mod(step + np.pi, 2 * np.pi) - np.pi
            if not abs(step) < _SAME:
                return False
        return True

    def name(self, position: Array, state: int) -> str:
        """Return a position in words, with multiples of π or the parameters that it depends on."""
        said = [_say(x, turns=n in self.turning) for n, x in zip(self.felt, position, strict=True)]
        whole = ", ".join(f"{name} = {x}" for name, x in zip(self.felt, said, strict=True))
        if not any("." in x for x in said):
            return whole
        acting = {g.name for force in self._forces for g in force.generators()}
        parameters = [p.symbol for p in self._truth.mechanism.parameters if p.symbol in acting]
        values = (f"{name} = {self.at_zero[name][state]:.4g}" for name in parameters)
        return f"{whole} (for {', '.join(values)})"


@lru_cache(maxsize=32)
def equilibria_of(truth: Truth) -> Equilibria:
    """Return the equilibria of a mechanism, which are sought once."""
    return Equilibria(truth)


def _say(x: float, *, turns: bool) -> str:
    twelfths = 12 * x / np.pi
    if abs(x) < _SAME:
        return "0"
    if not turns or abs(twelfths - round(twelfths)) > _SAME or round(twelfths) % 2:
        return f"{x:.4g}"
    divisor = 12 // int(np.gcd(12, round(twelfths)))
    times = abs(round(twelfths)) * divisor // 12
    sign = "-" if x < 0 else ""
    over = f"/{divisor}" if divisor > 1 else ""
    return f"{sign}{times if times > 1 else ''}π{over}"


@final
@dataclass(frozen=True)
class Position:
    """A position that an answer names, in all states where it has a value."""

    statements: tuple[Statement, ...]  # the lines that give it
    worst: float  # its largest unbalanced force
    fault: str  # why it is no position, or empty
    values: dict[str, Array]  # the letters there, each shape (n,)
    # which of the true positions of a state it is, shape (k, positions)
    says: Array = field(default_factory=lambda: np.ones((1, 1)))


def judge_positions(
    statements: Sequence[Statement], truth: Truth, text: str
) -> tuple[list[Position], list[str]]:
    """Return the positions that an answer names, and the names of equilibria that it lacks."""
    equilibria = equilibria_of(truth)
    positions = []
    for group in _combine(name_values(statements), equilibria):
        written = set().union(*(side.letters for statement in group for side in statement.sides))
        whole = [name for name in INTEGERS if name in written - equilibria.at_zero.keys()]
        for numbers in product(_WHOLE, repeat=len(whole)):
            counted = dict(zip(whole, numbers, strict=True))
            positions.append(_move(equilibria, group, text, counted))
    with stop_clock():
        known = equilibria.all or {}
    missing: dict[str, None] = {}
    covers = {state: equilibria.cover(positions, true, state) for state, true in known.items()}
    if known:
        # parameters differ from state to state, and so do the numbers
        most = max(known, key=lambda state: len(known[state]))
        table = np.eye(len(known[most]))
        positions = [
            replace(position, says=table[covered])
            for position, covered in zip(positions, covers[most], strict=True)
        ]
    for state, true in known.items():
        lacking = ~np.any(covers[state], axis=0)
        missing |= {equilibria.name(true[k], state): None for k in np.flatnonzero(lacking)}
        if missing:
            break
    fixed = {*equilibria.coordinates} - {*equilibria.felt}
    for position in positions:
        fixed &= set().union(*(_unknowns(line, equilibria) for line in position.statements))
    missing |= {f"any other {name}": None for name in sorted(fixed)}
    wrong = any(position.worst or position.fault for position in positions)
    return positions, [] if wrong else list(missing)[:_SHOWN]


def _combine(statements: Sequence[Statement], known: Equilibria) -> Iterator[list[Statement]]:
    """Yield the lines of each position; q1 = 0 or π, q2 = 0 or π are four of them."""
    runs = [(name, list(run)) for name, run in groupby(statements, lambda line: line.sides[0].name)]
    names, coordinates = [name for name, _ in runs], {*known.coordinates}
    given = all(
        line.is_equation and not line.sides[-1].letters & coordinates for line in statements
    )
    if given and sorted(names) == sorted({*names} & coordinates):
        yield from map(list, product(*(run for _, run in runs)))
    else:
        yield from _group(statements, known)


def _group(statements: Sequence[Statement], known: Equilibria) -> Iterator[list[Statement]]:
    """Yield the lines of each position: a new one begins where a coordinate is given again."""
    group: list[Statement] = []
    given: set[str] = set()
    for statement in statements:
        names = _unknowns(statement, known) - given if group else _unknowns(statement, known)
        if group and not names:
            yield group
            group, given = [], set()
        group.append(statement)
        given |= _unknowns(statement, known)
    if group:
        yield group


def _unknowns(statement: Statement, known: Equilibria) -> set[str]:
    left = statement.sides[0]
    if left.kind == "letter" and left.name in known.coordinates:
        return {left.name}
    letters = set().union(*(side.letters for side in statement.sides))
    return letters & set(known.coordinates)


def _move(
    known: Equilibria, statements: Sequence[Statement], text: str, counted: Mapping[str, float]
) -> Position:
    """Return the position that some lines give; coordinates that nothing feels are zero."""
    values = dict(known.at_zero)
    given = set[str]()
    values |= {name: np.full(len(values[_STATE]), number) for name, number in counted.items()}
    fault = ""
    for statement in statements:
        left, right = statement.sides[0], statement.sides[-1]
        if left.kind == "letter" and left.name in known.coordinates and left.name not in given:
            others = sorted((right.letters & set(known.coordinates)) - given)
            if others:
                fault = f"it is a condition: {', '.join(others)} is not given"
            moved = FormulaTape(right).evaluate(values, len(values[_STATE])).whole
            values = {**values, left.name: moved}
            given.add(left.name)
            values = _keep(values, np.isfinite(moved), text, statement)
        else:
            root = left if len(statement.sides) == 1 else add(left, negate(right))
            values = _solve(known, values, given, root, text, statement)
            given |= root.letters & set(known.coordinates)
    open_ones = [name for name in known.felt if name not in given]
    worst = known.measure(values)
    if open_ones and not worst and not fault:
        fault = f"{', '.join(open_ones)} {'is' if len(open_ones) == 1 else 'are'} not given"
    return Position(tuple(statements), worst, fault, values)


def _keep(
    values: dict[str, Array], states: npt.NDArray[np.bool_], text: str, statement: Statement
) -> dict[str, Array]:
    if not states.any():
        raise FormulaError("the formula has a value at no state", text, statement.start)
    return {name: value[states] for name, value in values.items()}


def _solve(
    known: Equilibria,
    values: dict[str, Array],
    given: set[str],
    root: Node,
    text: str,
    statement: Statement,
) -> dict[str, Array]:
    """Return all positions at which a condition on one coordinate holds."""
    free = sorted((root.letters & set(known.coordinates)) - given)
    if len(free) != 1:
        raise FormulaError(
            "expected COORDINATE = FORMULA, e.g. q = 0, or a condition on one coordinate",
            text,
            statement.start,
        )
    (name,), count = free, len(values[_STATE])
    reach = np.pi if name in known.turning else _WIDE * known.size[name]
    # an odd offset keeps the grid away from simple positions such as 0
    grid = np.linspace(-reach, reach, _GRID) + 0.000271 * reach

    def place(states: Rows, numbers: Array) -> dict[str, Array]:
        return {**{letter: value[states] for letter, value in values.items()}, name: numbers}

    every, tape = np.repeat(np.arange(count), _GRID), FormulaTape(root)
    whole = tape.whole(place(every, np.tile(grid, count)), len(every))
    usual = np.abs(np.nan_to_num(whole, posinf=0.0, neginf=0.0)).reshape(count, _GRID).mean(1)
    states, numbers = list[Rows](), list[Array]()
    for factor in map(FormulaTape, _list_factors(root)):
        # where a root counts twice, as that of cos q = 1, the slope changes its sign instead
        for changing in (_evaluate, _slope):
            follow = partial(changing, factor, name, place)
            at, moved, _ = find_sign_changes(follow, count, grid, _HALVINGS)
            states.append(at)
            numbers.append(moved)
    at, moved = np.concatenate(states), np.concatenate(numbers)
    if len(at):
        zero = np.abs(tape.whole(place(at, moved), len(at))) < _ZERO * usual[at]
        at, moved = at[zero], moved[zero]
    if not len(at):
        raise FormulaError(f"the condition holds at no {name} of any state", text, statement.start)
    return place(at, moved)


_Place: TypeAlias = Callable[[Rows, Array], dict[str, Array]]
"""The letters of some states with a coordinate at some numbers."""


def _evaluate(tape: FormulaTape, _: str, place: _Place, states: Rows, numbers: Array) -> Array:
    return tape.whole(place(states, numbers), len(numbers))


def _slope(tape: FormulaTape, name: str, place: _Place, states: Rows, numbers: Array) -> Array:
    values = tape.evaluate(place(states, numbers), len(numbers))
    return np.asarray(tape.along(tape.slopes(values), name))


def _list_factors(node: Node) -> list[Node]:
    """Return the factors of a condition: a root of several of them has no exact change of sign."""
    if node.kind in ("product", "negative"):
        return [factor for part in node.parts for factor in _list_factors(part)]
    return _list_factors(node.parts[0]) if node.kind == "power" else [node]
