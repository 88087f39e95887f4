"""Judge sets of equilibria: each position by its balance, and all of them by a search of one's own.

The search starts Newton's method from a grid over the coordinates that matter, in a few states with
their own parameters. Of a coordinate that nothing feels, every value belongs to an equilibrium: an
answer leaves it open.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache, partial
from itertools import groupby, product
from typing import TypeAlias, final

import numpy as np
import numpy.typing as npt

from mecanique.arrays import Array
from mecanique.checking.budget import spend, stop_clock
from mecanique.checking.grammar.conditions import IF, STABLE, ParameterCondition
from mecanique.checking.grammar.reader import Statement, name_values
from mecanique.checking.grammar.tape import FormulaTape, Rows, find_rounding, find_sign_changes
from mecanique.checking.grammar.tree import Node, add, negate
from mecanique.checking.judgement.truth import SeriesValues, Truth, accelerate
from mecanique.errors import FormulaError
from mecanique.model.mechanism.description import angles
from mecanique.model.mechanism_units import characteristic_length

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

_STARTS = {0: 1, 1: 48, 2: 16, 3: 8}
"""Starting values of each coordinate, by their number; those of more coordinates are random."""

_RANDOM_STARTS, _MOST_FELT = 400, 6
"""Random starting positions, and how many coordinates may matter."""

_ROUNDS = 40
_STEP = 0.3
"""Largest step of Newton's method, in radians or characteristic lengths."""

_LEAST_USUAL = 1e-3
"""With constraints, forces are measured by at least this part of the largest usual one."""

_BESIDE = 0.1
"""So close to a position, in radians or characteristic lengths, an equilibrium may be meant."""

_SHIFT = 0.37
"""How far a coordinate is moved to see whether it matters, in radians or such lengths."""

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

NOWHERE = "nowhere"
"""The letter that stands for: there is no equilibrium."""

_WHOLE = (-2.0, -1.0, 0.0, 1.0, 2.0)


@final
class Equilibria:
    """The equilibria of a mechanism, and positions that are said to be some."""

    def __init__(self, truth: Truth) -> None:
        sample = truth.sample
        self._truth = truth
        self._forces, self._closures = truth.balance, truth.closures
        rest = sample.bias - sample.forces
        reactions = np.einsum("nmj,nm->nj", sample.slopes, sample.multipliers)
        usual = np.maximum(np.abs(rest).mean(0), np.abs(reactions).mean(0))
        # rows of massless coordinates hold rounding alone
        least = _LEAST_USUAL * usual.max(initial=0.0) if truth.multipliers else 0.0
        self._usual = np.maximum(usual, max(least, 1e-300))
        turning = angles(truth.mechanism)
        length = self._length = characteristic_length(truth.mechanism)
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
        self.loads = truth.multipliers
        load_sizes = np.abs(sample.multipliers).mean(0)
        self.size |= zip(self.loads, np.maximum(load_sizes, 1e-300), strict=True)
        acting = {g.name for force in self._forces for g in force.generators()}
        closing = {g.name for demand in self._closures for g in demand.generators()}
        self.felt = tuple(
            name
            for name in self.coordinates
            if name in closing or (name in acting and (not self.loads or self._drives(name)))
        )

    def _drives(self, name: str) -> bool:
        """Whether a motion from rest depends on a coordinate; axes of constraints alone may."""
        here = self._truth.sample.values
        values = {name: here[name] for name in self.coordinates}
        moved = {**values, name: values[name] + _SHIFT * self.size[name]}
        for _, at in self._truth.mechanism.quaternions:
            names = [self.coordinates[k] for k in at]
            length = np.linalg.norm([moved[name] for name in names], axis=0)
            moved |= {name: moved[name] / length for name in names}
        first, second = (self._start(places) for places in (values, moved))
        sample = self._truth.sample
        usual = np.einsum("ni,nij,nj->n", sample.a, sample.M, sample.a)
        return bool((np.abs(first - second) > _BALANCED * np.maximum(usual, first)).any())

    def _start(self, places: Mapping[str, Array]) -> Array:
        """Return aᵀ M a of the accelerations from rest in positions, shape (n,)."""
        values = {**self.at_zero, **places, **dict.fromkeys(self.loads, 0.0)}
        here = self._truth.at(values, self._truth.sample.count)
        J, M = -here.slopes(self._forces, self.loads).transpose(0, 2, 1), here.M
        a, _ = accelerate(M, -here.stack(self._forces), J, np.zeros(J.shape[:2]))
        return np.asarray(np.einsum("ni,nij,nj->n", a, M, a))

    def measure(self, values: dict[str, Array]) -> float:
        """Return the largest unbalanced force, relative to the usual size of forces."""
        here = self._truth.at(values, len(values[_STATE]))
        worst = float(np.abs(self._balance(here)).max(initial=0.0))
        return worst if worst > _BALANCED else 0.0

    def _balance(self, here: SeriesValues) -> Array:
        """Return forces and gaps of constraints, each over its usual size, shape (n, nv + c)."""
        forces, gaps = here.stack(self._forces) / self._usual, here.stack(self._closures)
        whole = np.concatenate([forces, gaps / self._length], axis=1)
        return np.asarray(np.nan_to_num(whole, nan=np.inf))

    def close(
        self, values: Mapping[str, Array], given: Collection[str]
    ) -> tuple[dict[str, Array], list[str]]:
        """Return the letters with the coordinates and forces that constraints determine.

        With them come the coordinates that neither are given nor follow.
        """
        values, left_open = dict(values), [name for name in self.felt if name not in given]
        if self._closures and left_open:
            values |= self._near(values, left_open)
            size = np.array([self.size[name] for name in left_open])
            slopes = np.zeros((0, 0))
            for _ in range(_ROUNDS):
                here = self._truth.at(values, len(values[_STATE]))
                slopes = here.slopes(self._closures, left_open) * size
                step = _step(slopes, here.stack(self._closures), _STEP) * size
                values |= {name: values[name] + step[:, k] for k, name in enumerate(left_open)}
            free = np.eye(len(size)) - np.linalg.pinv(slopes, rcond=_SAME) @ slopes
            moves = np.abs(free).max(axis=(0, 2)) > _SAME
            left_open = [name for name, is_free in zip(left_open, moves, strict=True) if is_free]
        if self.loads:
            values |= dict.fromkeys(self.loads, np.zeros(len(values[_STATE])))
            here = self._truth.at(values, len(values[_STATE]))
            slopes = here.slopes(self._forces, self.loads)
            loads = _step(slopes, here.stack(self._forces), np.inf)
            values |= zip(self.loads, loads.T, strict=True)
        return values, left_open

    def locate(self, position: Mapping[str, Array]) -> dict[str, Array]:
        """Return what constraints determine at a position, or at the equilibrium close by."""
        closed, _ = self.close({**self.at_zero, **position}, position)
        near = self.settle(closed)
        away = [
            np.abs(near[name] - closed[name]).max() / self.size[name] for name in near and self.felt
        ]
        chosen = near if near and max(away) < _BESIDE else closed
        return {name: chosen[name] for name in (*self.felt, *self.loads)}

    def settle(self, values: Mapping[str, Array]) -> dict[str, Array]:
        """Return the letters at the equilibrium beside a position; empty if there is none."""
        unknowns = (*self.felt, *self.loads)
        q = np.stack([values[name] for name in unknowns], axis=-1) if unknowns else np.zeros((1, 0))
        q, balance, _ = self._relax(values[_STATE].astype(int), q, _STEP)
        settled = bool(unknowns) and (np.abs(balance) <= _BALANCED).all()
        return {**values, **dict(zip(unknowns, q.T, strict=True))} if settled else {}

    def _near(self, values: Mapping[str, Array], names: Sequence[str]) -> dict[str, Array]:
        """Return where to begin to close constraints: at the known equilibrium next to values."""
        states = values[_STATE].astype(int)
        near = np.stack([self._truth.sample.values[name][states] for name in names], axis=-1)
        with stop_clock():
            known, nearest = self.all or {}, self.nearest
        given = [name for name in self.felt if name not in names]
        for row, state in enumerate(states):
            listed = [*known.get(state, ())]
            for letters in nearest:
                listed.append(np.array([letters[name][state] for name in self.felt]))
            if not listed:
                continue
            table = dict(zip(self.felt, np.transpose(listed), strict=True))
            away = np.zeros(len(listed))
            for name in given:
                step = (table[name] - values[name][row]) / self.size[name]
                away += 1 - np.cos(step) if name in self.turning else step**2
            best = int(np.argmin(away))
            near[row] = [table[name][best] for name in names]
        return dict(zip(names, near.T, strict=True))

    def find_stability(self, values: Mapping[str, Array]) -> Array:
        """Return in which states an equilibrium is stable by its stiffness: 1, -1 where it is not.

        It is 0 where the stiffness does not tell. Shape (n,).
        """
        count = len(values[_STATE])
        rows = [
            self._truth.velocities.index(v)
            for x in self.felt
            if (v := f"{x}'") in self._truth.velocities
        ]
        if self.loads or len(rows) < len(self.felt):
            return np.zeros(count)
        here, size = self._truth.at(values, count), [self.size[x] for x in self.felt]
        K = here.slopes([self._forces[row] for row in rows], self.felt) * np.outer(size, size)
        C = here.slopes(self._forces, self._truth.velocities)
        stiff = np.abs(K).max(axis=(1, 2), initial=1e-300)
        turned = [
            np.abs(A - A.transpose(0, 2, 1)).max(initial=0.0) for A in (K / stiff[:, None, None], C)
        ]
        least = np.linalg.eigvalsh(K).min(axis=1, initial=np.inf) / stiff
        stable = (least > _ISOLATED) & (turned[0] < _ZERO)
        # gyroscopic terms may hold what is not stiff
        falls = (least < -_ISOLATED) & (max(turned) < _ZERO)
        return np.asarray(1.0 * stable - 1.0 * falls)

    @cached_property
    def all(self) -> dict[int, Array] | None:
        """Return every equilibrium in a few states, shape (k, felt); None if they are not known."""
        count = len(self.felt)
        if count > _MOST_FELT or self._truth.derivation is None:
            return None
        reach = [np.pi if x in self.turning else _WIDE * self.size[x] for x in self.felt]
        if count in _STARTS:
            axis = np.linspace(-1.0, 1.0, _STARTS[count], endpoint=False) + 0.0123
            starts = np.array([*product(axis, repeat=count)])
        else:
            random = np.random.default_rng(self._truth.seed)
            starts = random.uniform(-1.0, 1.0, (_RANDOM_STARTS, count))
        starts = starts.reshape(len(starts), count) * np.array(reach)
        states = np.repeat(np.arange(min(_STATES, self._truth.sample.count)), len(starts))
        q = np.tile(starts, (len(states) // len(starts), 1))
        size = np.array([self.size[name] for name in self.felt])
        q, balance, stiffness = self._relax(states, self._load(q), _STEP)
        good = np.abs(balance).max(axis=1) <= _BALANCED
        good &= self._is_regular(states, q)
        for k, name in enumerate(self.felt):
            if name in self.turning:
                # half a turn is π, not −π
                q[:, k] = np.pi - np.mod(np.pi - q[:, k] + _SAME, 2 * np.pi) + _SAME
            else:
                good &= np.abs(q[:, k]) <= _WIDE * size[k]
                here = self._truth.sample.values[name]
                if self._truth.mechanism.contacts and (here > 0).all():
                    good &= q[:, k] > 0  # what rolls stays on its side of the surface
        positions = {}
        for state in range(min(_STATES, self._truth.sample.count)):
            chosen = np.flatnonzero(good & (states == state))
            isolated = np.linalg.svd(stiffness[chosen])[1].min(axis=1, initial=1.0) >= _ISOLATED
            # where constraints lose their rank, as in a stretched linkage, a position may be alone
            if not isolated.all() and not (self.loads and isolated.any()):
                return None
            chosen = chosen[isolated]
            kept: list[Array] = []
            for position in q[chosen, :count]:
                if not any(self.is_same(position, listed, self.felt) for listed in kept):
                    kept.append(position)
            positions[state] = np.array(kept).reshape(len(kept), count)
        return positions

    def cover(self, positions: Sequence[Position], true: Array, state: int) -> Array:
        """Return which of the true positions of a state, (k, felt), each one is, shape (n, k)."""
        table = np.zeros((len(positions), len(true)), dtype=bool)
        for row, position in enumerate(positions):
            at = np.flatnonzero(position.values[_STATE] == state)
            # q = q0 names all positions in which a loop may be closed there
            known = [name for name in self.felt if name in position.given or not self._closures]
            columns = [self.felt.index(name) for name in known]
            for k in at:
                named = np.array([position.values[name][k] for name in known])
                same = [self.is_same(x, named, known) for x in true[:, columns]]
                table[row] |= np.array(same, dtype=bool)
        return table

    @cached_property
    def nearest(self) -> tuple[dict[str, Array], ...]:
        """The equilibrium next to zero in every state; with constraints others, too."""
        return tuple(self._list_nearest())

    def _list_nearest(self) -> Iterator[dict[str, Array]]:
        count, starts = self._truth.sample.count, [np.zeros(len(self.felt))]
        if self.loads:
            size = np.array([self.size[name] for name in self.felt])
            known = (self.all or {}).get(0, np.zeros((0, len(self.felt))))
            starts += sorted(known, key=lambda position: float(np.linalg.norm(position / size)))
        for start in starts if len(self.felt) else ():
            longest = _STEP if self.loads else np.inf
            q = self._load(np.tile(start, (count, 1)))
            q, balance, _ = self._relax(np.arange(count), q, longest)
            if (np.abs(balance) <= _BALANCED).all():
                yield dict(zip((*self.felt, *self.loads), q.T, strict=True))

    def _load(self, q: Array) -> Array:
        """Return positions with forces of the constraints that are still zero."""
        return np.concatenate([q, np.zeros((len(q), len(self.loads)))], axis=1)

    def _relax(self, states: Rows, q: Array, longest: float) -> tuple[Array, Array, Array]:
        """Return positions after Newton's method, with forces and stiffness there."""
        unknowns = (*self.felt, *self.loads)
        size = np.array([self.size[name] for name in unknowns])
        for _ in range(_ROUNDS):
            balance, stiffness = self._linearize(states, q, size)
            q = q + _step(stiffness, balance, longest, len(self.felt)) * size
        return q, *self._linearize(states, q, size)

    def _linearize(self, states: Rows, q: Array, size: Array) -> tuple[Array, Array]:
        """Return forces and stiffness, scaled, shape (n, nv + c) and (n, nv + c, unknowns)."""
        here, unknowns = self._locate(states, q), (*self.felt, *self.loads)
        stiffness = here.slopes(self._forces, unknowns) * size / self._usual[:, None]
        closing = here.slopes(self._closures, unknowns) * size / self._length
        return self._balance(here), np.concatenate([stiffness, closing], axis=1)

    def _locate(self, states: Rows, q: Array) -> SeriesValues:
        """Return the values of series in some states at unknowns, shape (n, unknowns)."""
        values = {name: value[states] for name, value in self.at_zero.items()}
        values |= zip((*self.felt, *self.loads), q.T, strict=True)
        return self._truth.at(values, len(q))

    def _is_regular(self, states: Rows, q: Array) -> npt.NDArray[np.bool_]:
        """Whether each coordinate moves mass: at r = 0, say, an angle about it means nothing."""
        inertia = np.einsum("nii->ni", self._locate(states, q).M)
        usual = np.einsum("nii->ni", self._truth.sample.M).mean(axis=0)
        massless = usual <= _MASSLESS * usual.max()
        return np.asarray((massless | (inertia > _MASSLESS * usual)).all(axis=1))

    def is_same(self, first: Array, second: Array, names: Sequence[str]) -> bool:
        """Return whether two positions are the same, angles up to full turns."""
        for name, a, b in zip(names, first, second, strict=True):
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


def _step(slopes: Array, value: Array, longest: float, among: int | None = None) -> Array:
    """Return Newton's steps to zeros, shape (n, unknowns), bounded by the first unknowns."""
    step = -(np.linalg.pinv(np.nan_to_num(slopes)) @ value[..., None])[..., 0]
    length = np.linalg.norm(step[:, :among], axis=1, keepdims=True)
    step = step * np.minimum(1.0, longest / np.maximum(length, 1e-300))
    return np.asarray(np.nan_to_num(step), dtype=float)


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
    given: Collection[str] = ()  # the coordinates that are named
    limits: tuple[ParameterCondition, ...] = ()  # on parameters, under which it is said to be one
    outside: Position | None = None  # the same in states in which the limits do not hold
    rounding: str = ""  # the rounded number in it
    # which of the true positions of a state it is, shape (k, positions)
    says: Array = field(default_factory=lambda: np.ones((1, 1)))

    @property
    def conditions(self) -> tuple[ParameterCondition, ...]:
        """The conditions on parameters in its lines."""
        return tuple(condition for line in self.statements for condition in line.conditions)


def judge_positions(
    statements: Sequence[Statement], truth: Truth, text: str
) -> tuple[list[Position], list[str]]:
    """Return the positions that an answer names, and the names of equilibria that it lacks."""
    equilibria = equilibria_of(truth)
    if statements[0].sides[0].name == NOWHERE:
        return [_deny(statements[0], equilibria, text)], []
    positions = []
    for group in _combine(name_values(statements), equilibria):
        written = set().union(*(side.letters for statement in group for side in statement.sides))
        whole = [name for name in INTEGERS if name in written - equilibria.at_zero.keys()]
        for numbers in product(_WHOLE, repeat=len(whole)):
            counted = dict(zip(whole, numbers, strict=True))
            position = _move(equilibria, group, text, counted)
            position = _look_outside(position, equilibria, text, counted)
            positions.append(_round(position, equilibria, text) if position.worst else position)
    positions = _judge_limits(_judge_stability(positions, equilibria, text), equilibria)
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


_STABILITY = re.compile(
    rf"(?P<all>\b(?:both|all|alle|beide)(?: (?:are|sind))? )?(?P<word>{STABLE})"
    r"(?! (?:sinon|sonst|otherwise|else)\b)",
    re.IGNORECASE,
)
"""What is said of the stability of an equilibrium."""

_LIMITED = re.compile(rf" (?:(?:only|nur) )?{IF}")
_CLAUSE_ENDS = re.compile(r"[,;.)\n]|\b(?:and|or|und|oder|et|y|while|whereas)\b")


def _judge_stability(positions: list[Position], known: Equilibria, text: str) -> list[Position]:
    """Return the positions, those with the fault whose stability is stated wrongly."""
    judged = [*positions]
    for said in _STABILITY.finditer(text):
        starts = [line.start for position in positions for line in position.statements]
        about = min((start for start in starts if start >= said.end()), default=-1)
        # "unstable at q = π" is said of what follows, "q = π is unstable" of what goes before
        if about < 0 or _CLAUSE_ENDS.search(text, said.end(), about):
            about = max((start for start in starts if start < said.start()), default=-1)
        for k, position in enumerate(positions):
            if position.worst or not (
                said["all"] or about in [x.start for x in position.statements]
            ):
                continue
            condition = next((c for c in position.conditions if _follows(c, said, text)), None)
            if condition is None and _LIMITED.match(text, said.end()):
                continue  # a condition that is none on parameters
            states = known.find_stability(position.values)
            claim = 1 if said["word"].lower().startswith("stab") else -1
            fault = _find_unstable(states, claim, condition, position.values)
            judged[k] = replace(judged[k], fault=judged[k].fault or fault)
    return judged


def _follows(condition: ParameterCondition, said: re.Match[str], text: str) -> bool:
    """Whether a condition is one of what is said of the stability."""
    return said.end() <= condition.start and not text[said.end() : condition.start].strip(" ,;(")


def _find_unstable(
    states: Array, claim: int, condition: ParameterCondition | None, values: Mapping[str, Array]
) -> str:
    """Return what contradicts a claim of stability, 1, or instability, −1, "" if nothing does."""
    words = {1: "it is stable", -1: "it is not stable"}
    if condition is None:
        return words[-claim] if len(states) and (states == -claim).all() else ""
    holds = condition.holds(values, len(states))
    if (states[holds] == -claim).any():
        return f"{words[-claim]} where {condition.said}"
    if (states[~holds] == claim).any():
        return f"{words[claim]} not only where {condition.said}"
    return ""


def _look_outside(
    position: Position, known: Equilibria, text: str, counted: Mapping[str, float]
) -> Position:
    """Return a position with the same one in states in which its conditions do not hold."""
    limits = [c for c in position.conditions if not _is_of_stability(c, text)]
    if not limits:
        return position
    lines = position.statements
    holds = [c.holds(known.at_zero, len(known.at_zero[_STATE])) for c in limits]
    inside = np.logical_and.reduce(holds)
    if not inside.any():
        raise FormulaError(
            f"the condition {limits[0].said!r} holds in none of the random states",
            text,
            lines[0].start,
        )
    try:
        outside = _move(known, lines, text, counted, ~inside) if not inside.all() else None
    except FormulaError:
        outside = None  # it has no value there
    try:
        limited = _move(known, lines, text, counted, inside)
    except FormulaError:
        return replace(position, fault=f"there is none where {limits[0].said}")
    return replace(limited, limits=tuple(limits), outside=outside)


def _is_of_stability(condition: ParameterCondition, text: str) -> bool:
    return any(_follows(condition, said, text) for said in _STABILITY.finditer(text))


def _judge_limits(positions: list[Position], known: Equilibria) -> list[Position]:
    """Return the positions, those with the fault that are equilibria outside their limits, too."""
    judged = list[Position]()
    for position in positions:
        outside, fault = position.outside, position.fault
        if outside is None or outside.worst or fault:
            judged.append(position)
            continue
        for k, state in enumerate(outside.values[_STATE]):
            spend()
            there = np.array([[outside.values[name][k] for name in known.felt]])
            if not known.cover(positions, there, int(state)).any():
                fault = f"it is an equilibrium not only where {position.limits[0].said}"
                break
        judged.append(replace(position, fault=fault))
    return judged


def _deny(statement: Statement, known: Equilibria, text: str) -> Position:
    """Return what says that there is no equilibrium, with the fault if there is one."""
    with stop_clock():
        listed = known.all
    if listed is None:
        raise FormulaError("whether there is no equilibrium is not known", text)
    named = [known.name(true[0], state) for state, true in listed.items() if len(true)]
    return Position((statement,), 0.0, f"there is one: {named[0]}" if named else "", {})


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
    known: Equilibria,
    statements: Sequence[Statement],
    text: str,
    counted: Mapping[str, float],
    states: npt.NDArray[np.bool_] | slice = slice(None),
) -> Position:
    """Return the position that some lines give; coordinates that nothing feels are zero."""
    values = {name: value[states] for name, value in known.at_zero.items()}
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
            root = _root(statement)
            values = _solve(known, values, given, root, text, statement)
            given |= root.letters & set(known.coordinates)
    values, open_ones = known.close(values, given)
    worst = known.measure(values)
    if open_ones and not worst and not fault:
        fault = f"{', '.join(open_ones)} {'is' if len(open_ones) == 1 else 'are'} not given"
    return Position(tuple(statements), worst, fault, values, given)


def _round(position: Position, known: Equilibria, text: str) -> Position:
    """Return a position as the equilibrium beside it, if rounded numbers are the difference."""
    near, rounding = known.settle(position.values), ""
    for statement in position.statements if near else ():
        tape = FormulaTape(_root(statement))
        values = tape.evaluate(near, len(near[_STATE]))
        if values.relative.max() > _ZERO:
            rounding = find_rounding(tape, values, text)
            if not rounding:
                return position
    return replace(position, worst=0.0, values=near, rounding=rounding) if rounding else position


def _root(statement: Statement) -> Node:
    """Return left minus right."""
    left, *right = statement.sides[:1] + statement.sides[1:][-1:]
    return add(left, negate(right[0])) if right else left


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
    blocks = tape.blocks(place(states, numbers), len(numbers))
    return np.concatenate([tape.along(tape.slopes(values), name) for values in blocks])


def _list_factors(node: Node) -> list[Node]:
    """Return the factors of a condition: a root of several of them has no exact change of sign."""
    if node.kind in ("product", "negative"):
        return [factor for part in node.parts for factor in _list_factors(part)]
    return _list_factors(node.parts[0]) if node.kind == "power" else [node]
