"""The evidence of another source about a mechanism, as forces at many states.

A mass matrix is asked through M a at random accelerations a, at rest and without gravity; a bias at
constant velocities; gravity at rest. So everything is one kind of experiment: state and
acceleration in, forces out.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from copy import copy
from dataclasses import dataclass, field
from functools import cached_property
from operator import attrgetter
from types import MappingProxyType
from typing import Any, NamedTuple, TypeAlias, TypeVar, final

import numpy as np
import numpy.typing as npt

from mecanique.arrays import Array
from mecanique.derivation.numeric.recursion import Recursion
from mecanique.model.expression import symbols_in
from mecanique.model.mechanism import Mechanism
from mecanique.model.slips import Cause
from mecanique.model.states import States


class TreeChange(NamedTuple):
    """What a change replaces in the tree of a mechanism, by place."""

    origins: Mapping[int, Array] = MappingProxyType({})  # frames of joints
    moments: Mapping[int, Array] = MappingProxyType({})  # mass moments of links
    # how the axes of joints are turned in their frames
    turns: Mapping[int, Array] = MappingProxyType({})


@final
@dataclass(frozen=True, eq=False)
class Inputs:
    """What goes into experiments."""

    q: Array  # shape (n, nq)
    v: Array  # shape (n, nv)
    a: Array  # shape (n, nv)
    t: Array  # shape (n,) [s]
    heavy: npt.NDArray[np.bool_]  # whether gravity acts, shape (n,)
    inertia: npt.NDArray[np.bool_]  # whether inertia forces and gravity count, shape (n,)
    loads: npt.NDArray[np.bool_]  # whether springs, dampers, drives and loads count, shape (n,)

    def __len__(self) -> int:
        return len(self.t)

    def at(self, rows: npt.NDArray[np.intp]) -> Inputs:
        """Return some of the experiments, or the same ones several times."""
        return Inputs(*(getattr(self, name)[rows] for name in self.__dataclass_fields__))

    @classmethod
    def join(cls, parts: Sequence[Inputs]) -> Inputs:
        """Return the experiments of several parts."""
        names = cls.__dataclass_fields__
        return cls(*(np.concatenate(list(map(attrgetter(name), parts))) for name in names))


@final
class Evidence:
    """Experiments with what another source answered; tau (n, nv), kind (n,)."""

    def __init__(
        self, mechanism: Mechanism, inputs: Inputs, tau: Array, kind: npt.NDArray[np.str_]
    ) -> None:
        self.mechanism = mechanism
        self.inputs = inputs
        self.tau = tau
        self.kind = kind
        self.chosen: Array | None = None
        self.recursion = Recursion(mechanism)
        self.base: Array = self.answers(self.recursion, inputs)

    @classmethod
    def of(
        cls, mechanism: Mechanism, states: States, theirs: Mapping[str, Array], seed: int = 0
    ) -> Evidence | None:
        """Return what values by quantity say; None if nothing can be asked."""
        q, v, t = states.q, states.v, states.t
        n, zero = len(states), np.zeros_like(states.v)
        # of order one in every direction, so that no part of M is hidden
        a = np.abs(v).mean(axis=0) * np.random.default_rng(seed).normal(size=v.shape) if n else zero
        moving = {"t", *(signal.symbol for signal in mechanism.inputs)}
        moved = any(
            moving & set(symbols_in(scalar)) for scalar in mechanism.coordinates.driven.values()
        )
        given = {name: values for name, values in theirs.items() if np.isfinite(values).all()}
        parts: list[tuple[str, Inputs, Array]] = []

        def experiment(
            kind: str,
            v: Array,
            a: Array,
            tau: Array,
            *,
            heavy: bool = True,
            inertia: bool = True,
            loads: bool = False,
        ) -> None:
            flags = (np.full(n, flag) for flag in (heavy, inertia, loads))
            parts.append((kind, Inputs(q, v, a, t, *flags), tau))

        if "mass matrix" in given:
            Ma = np.einsum("nij,nj->ni", given["mass matrix"], a)
            if not moved:
                experiment("mass matrix", zero, a, Ma, heavy=False)
            elif "bias" in given:
                experiment("mass matrix", v, a, Ma + given["bias"])
        if "bias" in given:
            experiment("bias", v, zero, given["bias"])
        if "gravity" in given and not moved:
            experiment("gravity", zero, zero, given["gravity"])
        if "forces" in given:
            experiment("forces", v, zero, -given["forces"], inertia=False, loads=True)
        if "inverse dynamics" in given and not {"mass matrix", "bias"} & given.keys():
            tau = given["inverse dynamics"]
            experiment("inverse dynamics", v, states.a, tau, loads=True)
        if not parts or not n:
            return None
        kinds, inputs, answers = zip(*parts, strict=True)
        return cls(mechanism, Inputs.join(inputs), np.concatenate(answers), np.repeat(kinds, n))

    def after(self, effect: Array, tree: TreeChange, slopes: Array | None) -> Evidence:
        """Return what is left to explain after an effect (n, nv), with slopes (k, n, nv)."""
        evidence = copy(self)
        for name in ("regressor", "before"):
            evidence.__dict__.pop(name, None)
        evidence.__dict__["weights"] = self.weights
        evidence.chosen = None
        if any(tree):
            evidence.recursion = self.recursion.vary(tree.origins, tree.moments, turns=tree.turns)
            evidence.base = evidence.answers(evidence.recursion, self.inputs)
        else:
            evidence.tau = self.tau - effect
        if slopes is not None and len(slopes):
            directions, sizes, _ = np.linalg.svd(evidence.weigh(slopes).T, full_matrices=False)
            evidence.chosen = directions[:, sizes > 1e-9 * sizes[0]]
        return evidence

    def weigh(self, differences: Array) -> Array:
        """Return differences (…, n, nv) as weighted rows (…, N), without what is chosen already."""
        rows: Array = (differences * self.weights).reshape(*differences.shape[:-2], -1)
        return rows if self.chosen is None else rows - (rows @ self.chosen) @ self.chosen.T

    def answers(
        self,
        recursion: Recursion,
        inputs: Inputs,
        gravity: Array | None = None,
        mechanism: Mechanism | None = None,
    ) -> Array:
        """Return the forces that a recursion predicts, shape (n, nv); gravity (3,)."""
        mechanism = self.mechanism if mechanism is None else mechanism
        states = States(mechanism, inputs.q, inputs.v, inputs.t, inputs.a)
        pull = (self.gravity if gravity is None else gravity) * inputs.heavy[:, None]
        tau = (
            recursion.vary(gravity=pull).inverse_dynamics(states, inputs.a)
            * inputs.inertia[:, None]
        )
        if inputs.loads.any() and mechanism.forces:
            tau = tau - recursion.forces(states) * inputs.loads[:, None]
        return tau

    def change(
        self, trees: Sequence[TreeChange], rows: npt.NDArray[np.intp] | None = None
    ) -> Array:
        """Return what each changed tree answers in some experiments, shape (trees, n, nv)."""
        rows = np.arange(len(self.inputs)) if rows is None else rows
        lot = max(1, _MOST // len(rows))
        if len(trees) > lot:
            lots = range(0, len(trees), lot)
            return np.concatenate([self.change(trees[k : k + lot], rows) for k in lots])
        varied: list[dict[int, Array]] = []
        originals = (self.recursion.origins, self.recursion.moments, self.recursion.turns)
        for original, changes in zip(originals, zip(*trees, strict=True), strict=True):
            varied.append({})
            for k in set().union(*changes):
                parts = [change.get(k, original[k]) for change in changes]
                varied[-1][k] = np.repeat(parts, len(rows), axis=0)
        origins, moments, turns = varied
        recursion = self.recursion.vary(origins, moments, turns=turns)
        answers = self.answers(recursion, self.inputs.at(np.tile(rows, len(trees))))
        return answers.reshape(len(trees), len(rows), -1)

    @property
    def is_measured(self) -> bool:
        """Whether it consists of samples of inverse dynamics, which may be noisy."""
        return bool((self.kind == "inverse dynamics").all())

    @cached_property
    def gravity(self) -> Array:
        """Acceleration of free fall, shape (3,) [m/s²]."""
        return np.array(self.mechanism.evaluate_all(self.mechanism.gravity))

    @cached_property
    def regressor(self) -> Array:
        """What the mass moments of each link add, shape (n, nv, links, 4, 4)."""
        inputs = self.inputs
        states = States(self.mechanism, inputs.q, inputs.v, inputs.t, inputs.a)
        pulled = self.recursion.vary(gravity=self.gravity * inputs.heavy[:, None])
        Y: Array = pulled.regressor(states, inputs.a)
        return Y * inputs.inertia[:, None, None, None, None]

    @cached_property
    def weights(self) -> Array:
        """What makes all entries alike in unit and size, shape (n, nv)."""
        inputs = self.inputs
        if self.is_measured:
            # noise is mostly a part of what each joint bears
            rms = np.sqrt(np.mean(self.tau**2, axis=0))
            by_joint = 1 / np.where(
                rms > 1e-9 * rms.max(initial=0.0), rms, rms.max(initial=0.0) or 1.0
            )
            whole: Array = np.broadcast_to(by_joint / np.sqrt(self.tau.size), self.tau.shape)
            return whole
        rest = np.zeros_like(inputs.v[:8])
        states = States(self.mechanism, inputs.q[:8], rest, inputs.t[:8], rest)
        diagonal = np.diagonal(self.recursion.mass_matrix(states), axis1=1, axis2=2).mean(axis=0)
        d = np.sqrt(np.where(diagonal > 0, diagonal, 1.0))
        weights = np.empty_like(self.tau)
        for kind in np.unique(self.kind):
            rows = self.kind == kind
            sizes = [float(np.linalg.norm(tau[rows] / d)) for tau in (self.tau, self.base)]
            weights[rows] = 1 / (d * (max(sizes) or 1.0))
        return weights

    @cached_property
    def few(self) -> npt.NDArray[np.intp]:
        """Two experiments of each kind, enough to choose the changes worth evaluating in full."""
        return np.concatenate(
            [np.flatnonzero(self.kind == kind)[:2] for kind in dict.fromkeys(self.kind)]
        )

    def misfit(self, predicted: Array) -> float:
        """Return the weighted difference of answers (n, nv), of what is chosen already as well."""
        return float(self._size_of_all(predicted, slice(None)))

    def _size_of_all(self, predicted: Array, rows: npt.NDArray[np.intp] | slice) -> Array:
        off = (predicted - self.tau[rows]) * self.weights[rows]
        size: Array = np.sqrt(np.sum(off * off, axis=(-2, -1)))
        return size

    def residual(self, predicted: Array, rows: npt.NDArray[np.intp] | None = None) -> Any:
        """Return how far predictions (…, n, nv) are from the other source, relative, shape (…)."""
        with np.errstate(all="ignore"):
            if rows is None:
                size = np.linalg.norm(self.weigh(predicted - self.tau), axis=-1)
            else:
                size = self._size_of_all(predicted, rows)
        return np.where(np.isfinite(size), size, np.inf)

    @cached_property
    def before(self) -> float:
        """How far the unchanged mechanism is from what the other source answered, relative."""
        return float(self.residual(self.base))


Residuals: TypeAlias = "Callable[[list[tuple[int, Array]]], Array]"
"""Residuals, shape (trials, N), of trials: a problem's number and its unknowns."""

_STEP = 1e-6
_ROUNDS = 20
_DONE = 1e-14
_SLOW = 1e-3
"""Problems that gain less than this part in a round are at their end."""

_GRACE = 4
"""Rounds after which only the best problems go on, if there are more than are wanted."""


def descend(
    residuals: Residuals, starts: Sequence[Array], most: int | None = None
) -> tuple[list[Array], Array]:
    """Return the unknowns of each problem at its least residual, and the residuals' norms."""
    unknowns = [np.array(start, dtype=float) for start in starts]
    now = residuals(list(enumerate(unknowns)))
    cost = np.linalg.norm(now, axis=1)
    damping = np.full(len(unknowns), 1e-3)
    active = [k for k in range(len(unknowns)) if np.isfinite(cost[k])]
    for round_ in range(_ROUNDS):
        if round_ == _GRACE:
            active = sorted(active, key=lambda k: float(cost[k]))[:most]
        if not active:
            break
        slopes = _slopes(residuals, unknowns, now, active)
        trials = []
        for k, slope in zip(active, slopes, strict=True):
            normal = slope.T @ slope
            lhs = normal + damping[k] * np.diag(np.diag(normal))
            step = np.linalg.lstsq(lhs, -slope.T @ now[k], rcond=None)[0]
            trials.append((k, unknowns[k] + step))
        trial_residuals = residuals(trials)
        sizes = np.linalg.norm(trial_residuals, axis=1)
        going = []
        for (k, trial), rest, size in zip(trials, trial_residuals, sizes, strict=True):
            if size < cost[k]:
                ended = cost[k] - size <= _SLOW * cost[k]
                unknowns[k], now[k], cost[k] = trial, rest, size
                damping[k] *= 0.03
            else:
                ended = damping[k] > 1e3
                damping[k] *= 30
            if not ended and cost[k] > _DONE:
                going.append(k)
        active = going
    return unknowns, cost


def _slopes(
    residuals: Residuals, unknowns: list[Array], now: Array, active: list[int]
) -> list[Array]:
    """Derivatives of the residuals of each active problem, shape (N, unknowns)."""
    trials = []
    for k in active:
        for at in range(len(unknowns[k])):
            moved = unknowns[k].copy()
            moved[at] += _STEP
            trials.append((k, moved))
    rises = iter(residuals(trials))
    slopes = []
    for k in active:
        columns = [(next(rises) - now[k]) / _STEP for _ in unknowns[k]]
        slopes.append(np.stack(columns, axis=1))
    return slopes


_ROUND, _ANY = 4, 6
"""Numbers of more digits than the first are any numbers, which are shown with the second."""


@final
@dataclass(frozen=True, order=True)
class Amount:
    """How plain a fitted change is: of changes that explain as well, the least is the likeliest."""

    digits: int = 0  # how many decimal digits state it; hands choose round numbers
    ways: int = 1  # in how many ways such a slip can be made there, or how many numbers it rewrites
    share: float = 0.0  # how large it is beside what stood there

    @classmethod
    def of(cls, new: float, old: float = 0.0, beside: float | None = None, ways: int = 1) -> Amount:
        """Return it of one number, read as it is, as a difference, or as a factor."""
        readings = [new, new - old, *([new / old] if old else [])]
        return cls(min(map(_count_digits, readings)), ways, _share(new - old, beside or old))

    @classmethod
    def of_all(cls, values: Array, beside: float) -> Amount:
        """Return it of a shift or a turn by several numbers."""
        most = max(map(_count_digits, values.tolist()))
        return cls(most, len(values), _share(float(np.linalg.norm(values)), beside))


def _share(change: float, beside: float) -> float:
    """How large a change is; what stands where nothing was is all of it."""
    return float(abs(change) / abs(beside)) if beside else 1.0


def _count_digits(value: float) -> int:
    shown = f"{abs(value):.{_ANY}g}".partition("e")[0].replace(".", "").strip("0")
    return len(shown) if len(shown) <= _ROUND else _ANY


def deviations(slopes: Array, left: float, count: int) -> Array:
    """Return standard deviations of fitted numbers, shape (numbers,); slopes (numbers, rows)."""
    variance = left**2 / max(count - len(slopes), 1)
    spread = np.diag(np.linalg.pinv(slopes @ slopes.T)) * variance
    return np.asarray(np.sqrt(spread))


def turn_about(x: Array) -> Array:
    """Return the turn by the angle |x| about x, shape (3, 3)."""
    from scipy.spatial.transform import Rotation  # not wanted before a cause is looked for

    turn: Array = Rotation.from_rotvec(x).as_matrix()
    return turn


def give(value: float, sigma: float) -> str:
    """Return a fitted number, with its standard deviation where that can be seen."""
    if sigma <= 1e-6 * abs(value):
        return f"{value:.6g}"
    places = max(0, 1 - math.floor(math.log10(sigma)))
    return f"{value:.{places}f} ± {sigma:.{places}f}"


def give_all(values: Array) -> str:
    """Return fitted numbers in a row."""
    return ", ".join(f"{value:.6g}" for value in values + 0.0)  # not −0


def say_turn(x: Array) -> str:
    """Return a turn in words."""
    from scipy.spatial.transform import Rotation  # not wanted before a cause is looked for

    x = Rotation.from_rotvec(x).as_rotvec() + 0.0  # half a turn at most
    angle = float(np.linalg.norm(x))
    axis = x / angle if angle else np.array([0.0, 0.0, 1.0])
    return f"{np.degrees(angle):.6g}° about ({give_all(axis)})"


_MOST = 4000
"""Experiments evaluated at once."""

_CLOSER = 8
"""Guesses that get a closer look."""

SMALL = 1e-6
"""Step of the numbers by which slopes are taken."""

_Guess = TypeVar("_Guess", bound=Cause)
"""What a change is called before it is known what it answers."""


@final
@dataclass(frozen=True, eq=False)
class Hypothesis:
    """A change and what the changed mechanism would answer."""

    kind: str  # of the mistake, e.g. "armature"
    where: str  # link, joint or coordinate, or empty for the whole mechanism
    text: str  # what the other source seems to do, in a sentence
    answers: Array  # what the changed mechanism predicts, shape (n, nv)
    free: int = 0  # how many numbers were chosen so that it fits
    amount: Amount = field(default_factory=Amount)  # how plain these are
    # of the changed mechanism; a change without one only adds to the answers
    tree: TreeChange = field(default_factory=TreeChange)
    slopes: Array | None = None  # of the answers by each number chosen, shape (free, n, nv)


def promising(
    evidence: Evidence,
    guesses: Iterable[_Guess],
    answer: Callable[[list[_Guess], npt.NDArray[np.intp]], Array],
) -> Iterator[Hypothesis]:
    """Yield the guesses that explain a few experiments best; answer gives (guesses, n, nv)."""
    kept = list(guesses)
    if len(kept) > _CLOSER:
        coarse = evidence.residual(answer(kept, evidence.few), evidence.few)
        kept = [kept[k] for k in np.argsort(coarse, kind="stable")[:_CLOSER]]
    if not kept:
        return
    whole = answer(kept, np.arange(len(evidence.inputs)))
    for guess, predicted in zip(kept, whole, strict=True):
        tree = getattr(guess, "tree", TreeChange())
        yield Hypothesis(guess.kind, guess.where, guess.text, predicted, tree=tree)


@final
@dataclass(frozen=True, eq=False)
class Family:
    """Ways to change a link or a joint that differ in a few numbers."""

    kind: str
    where: str
    change: Callable[[Array], TreeChange]  # what these numbers change
    say: Callable[[Array, Array], str]  # what they mean, in words, with their standard deviations
    amount: Callable[[Array], Amount]  # how plain they are
    starts: tuple[Array, ...]  # where to begin, each shape (numbers,)
    way: str = ""  # which change it is, in a word that is alike for all joints

    @property
    def units(self) -> list[Array]:
        """A small step of each number."""
        return list(SMALL * np.eye(len(self.starts[0])))


def fit_families(
    evidence: Evidence,
    families: Sequence[Family],
    residuals: Callable[[list[TreeChange]], Array],
    answers: Callable[[list[TreeChange]], Array],
    most: int | None = None,
) -> Iterator[Hypothesis]:
    """Yield the changes with the numbers that fit best, if they explain anything.

    Residuals have shape (trees, N), answers (trees, n, nv).
    """
    problems = [(family, start) for family in families for start in family.starts]
    unknowns, costs = descend(
        lambda trials: residuals([problems[k][0].change(x) for k, x in trials]),
        [start for _, start in problems],
        most,
    )
    for family in families:
        tried = [k for k, (start_of, _) in enumerate(problems) if start_of is family]
        best = min(tried, key=lambda k: float(costs[k]))
        if not costs[best] < evidence.before:
            continue
        x = unknowns[best]
        trees = [family.change(x), *(family.change(x + step) for step in family.units)]
        predicted, *near = answers(trees)
        slopes = (np.array(near) - predicted) / SMALL
        sigma = np.zeros(len(x))
        if evidence.is_measured:
            left = float(evidence.residual(predicted))
            sigma = deviations(evidence.weigh(slopes), left, evidence.tau.size)
        text, amount = family.say(x, sigma), family.amount(x)
        yield Hypothesis(
            family.kind, family.where, text, predicted, len(x), amount, trees[0], slopes
        )


def fit(evidence: Evidence, columns: Array) -> tuple[Array, Array]:
    """Fit amounts (k,) of effects (k, n, nv); return them and their answers (n, nv)."""
    flat = evidence.weigh(columns)
    size = np.sqrt(np.sum(flat * flat, axis=1))
    used = size > 1e-12 * size.max(initial=0.0)
    amounts = np.zeros(len(columns))
    if used.any():
        rest = evidence.weigh(evidence.tau - evidence.base)
        solution = np.linalg.lstsq((flat[used] / size[used, None]).T, rest, rcond=1e-10)[0]
        amounts[used] = solution / size[used]
    return amounts, evidence.base + np.einsum("k,knv->nv", amounts, columns)
