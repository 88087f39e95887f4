"""Evaluate the true equations of motion in random states with random parameters.

Parameters vary from state to state, to distinguish two masses that happen to be equal in the
catalogue. If the equations have no closed form, the parameters keep their own values.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from copy import copy
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, final

import numpy as np
import numpy.typing as npt

from mecanique.arrays import Array
from mecanique.checking.grammar.tape import Rows
from mecanique.derivation import derive
from mecanique.derivation.equations import Equations
from mecanique.derivation.scalars.evaluation import Evaluation
from mecanique.derivation.scalars.series import Series
from mecanique.derivation.symbolic.derivation import Derivation
from mecanique.errors import DerivationError, InputError
from mecanique.model.expression import evaluate
from mecanique.model.mechanism import Mechanism
from mecanique.model.states import States
from mecanique.verification.states import closed_states, random_states

STATES = 24
"""Number of states in which a formula is compared."""

_RESIZED = 0.05
"""Largest relative change of sizes on which constraints depend, with which most loops close."""

_CANDIDATES = 64
"""Number of states that are drawn; nearly singular ones and those without values are left out."""

_SPREAD = 0.5
"""Parameters vary by a factor of up to e to the power of ± this."""

_STRETCHES = (
    *((0.0, 0.0), (0.0, 1.0), (1.0, 0.0), (0.0, 1e3), (1e-3, 1e-3)),
    *((1.0, 1e3), (1e2, 1.0), (1e3, 0.0)),
)
"""What positions and velocities are multiplied by to see what the random states hide."""

_STILL = 1e-12
"""Part of an acceleration's usual size that is rounding."""

_SINGULAR = 1e4
"""States with a larger condition number of the mass matrix are left out."""


@final
class SeriesValues:
    """Gives the values of series where the letters of a derivation have some, in n states."""

    def __init__(self, derivation: Derivation, values: Mapping[str, Any], count: int) -> None:
        self._derivation = derivation
        # a power of an array that is zero has no value, where that of a number raises an error
        arrays = {name: np.broadcast_to(value, (count,)) for name, value in values.items()}
        self._evaluated = Evaluation(derivation.algebra.ring, arrays)
        self._count = count

    def __call__(self, series: Series) -> Array:
        """Return the values of a series, shape (n,)."""
        value = np.asarray(self._evaluated(series), dtype=float)
        return np.broadcast_to(value, (self._count,))

    def stack(self, rows: Sequence[Series]) -> Array:
        """Return the values of several series, shape (n, rows)."""
        values = [self(series) for series in rows]
        return np.stack(values, axis=-1) if values else np.zeros((self._count, 0))

    def slopes(self, rows: Sequence[Series], names: Sequence[str]) -> Array:
        """Return the derivatives of several series by letters, shape (n, rows, names)."""
        whole = np.empty((self._count, len(rows), len(names)))
        for i, series in enumerate(rows):
            for j, name in enumerate(names):
                whole[:, i, j] = self(series.diff(name))
        return whole

    @property
    def M(self) -> Array:
        """The mass matrix, shape (n, nv, nv)."""
        return np.stack([self.stack(row) for row in self._derivation.M], axis=1)

    @property
    def rest(self) -> Array:
        """The terms h − Q of M a + h − Q = 0, shape (n, nv)."""
        return self.stack(self._derivation.h) - self.stack(self._derivation.Q)


@final
@dataclass(frozen=True, eq=False)
class Sample:
    """States with the values of all letters that formulas may contain."""

    # value of each letter, shape (n,); without the lengths of springs
    values: Mapping[str, Array]
    M: Array  # mass matrix, shape (n, nv, nv)
    bias: Array  # M a + bias = forces, shape (n, nv)
    forces: Array  # generalized forces, shape (n, nv)
    slopes: Array  # constraint Jacobian, shape (n, m, nv); m = 0 without constraints
    a: Array  # the true accelerations, shape (n, nv)
    multipliers: Array  # the true multipliers of the constraints, shape (n, m)
    count: int  # number of states n
    varied: bool  # whether parameters differ from state to state
    # lengths of springs that have a letter, which follow from the rest
    lengths: Mapping[str, Array] = field(default_factory=dict)

    @property
    def letters(self) -> dict[str, Array]:
        """The value of each letter that a formula may contain."""
        return {**self.values, **self.lengths}

    def at(self, states: Rows) -> dict[str, Array]:
        """Return the value of each letter in some of the states."""
        return {name: value[states] for name, value in self.values.items()}

    def take(self, states: npt.NDArray[np.bool_]) -> Sample:
        """Return some of the states."""
        arrays = {
            name: getattr(self, name)[states]
            for name in ("M", "bias", "forces", "slopes", "a", "multipliers")
        }
        lengths = {name: value[states] for name, value in self.lengths.items()}
        values = {name: value[states] for name, value in self.values.items()}
        count = int(states.sum())
        return replace(self, values=values, count=count, lengths=lengths, **arrays)

    @property
    def usual(self) -> Array:
        """The usual size of each acceleration, shape (n, nv); 0 where it moves no mass."""
        vigor = np.sqrt(np.abs(np.einsum("ni,nij,nj->n", self.a, self.M, self.a)))
        usual = vigor[:, None] / np.sqrt(np.diagonal(self.M, axis1=1, axis2=2))
        return np.where(np.isfinite(usual), usual, 0.0)

    @property
    def motion(self) -> Array:
        """The accelerations and multipliers, shape (n, nv + m)."""
        return np.concatenate([self.a, self.multipliers], axis=1)


@final
class Truth:
    """A mechanism's own equations, with which formulas are compared."""

    def __init__(self, mechanism: Mechanism, seed: int = 0, fixed: Collection[str] = ()) -> None:
        self.mechanism = mechanism
        self.seed = seed
        self._fixed = frozenset(fixed)  # parameters that have their own values in all states
        self._partly: dict[frozenset[str], Sample] = {}
        self.velocities = mechanism.velocities
        self.accelerations = tuple(f"{name}'" for name in mechanism.velocities)

    @property
    def moving(self) -> tuple[str, ...]:
        """The letters that change in a motion: coordinates to multipliers."""
        coordinates = tuple(self.mechanism.coordinates)
        return (*coordinates, *self.velocities, *self.accelerations, *self.multipliers)

    @cached_property
    def changing(self) -> tuple[str, ...]:
        """The velocities that change; constraints may hold the others."""
        still = np.abs(self.sample.a) <= _STILL * self.sample.usual
        return tuple(np.array(self.velocities)[~still.all(axis=0)])

    @cached_property
    def equations(self) -> Equations:
        """The equations by Lagrange's method."""
        return derive(self.mechanism)

    @cached_property
    def derivation(self) -> Derivation | None:
        """The closed form, if there is one."""
        try:
            return self.equations.derivation
        except DerivationError:
            return None

    @property
    def closed_form(self) -> Derivation:
        """The closed form, of a mechanism that is known to have one."""
        assert self.derivation is not None, "asked of what has one"
        return self.derivation

    @cached_property
    def rest_forces(self) -> list[Series]:
        """The terms h − Q of M a + h − Q = 0."""
        return [h - Q for h, Q in zip(self.closed_form.h, self.closed_form.Q, strict=True)]

    @cached_property
    def balance(self) -> list[Series]:
        """The terms h − Q − Jᵀ λ, which vanish at rest."""
        ring, ties = self.closed_form.algebra.ring, self.closed_form.ties
        slopes = [tie.slopes(ring) for tie in ties]
        balance = list[Series]()
        for k, force in enumerate(self.rest_forces):
            loads = (-tie.multiplier * J[k] for tie, J in zip(ties, slopes, strict=True))
            balance.append(ring.sum([force, *loads]))
        return balance

    @cached_property
    def driven(self) -> bool:
        """Whether constraints move the mechanism by themselves."""
        still = self.at(dict.fromkeys(self.velocities, 0.0))
        return any(
            still(tie.demand if tie.of_velocities else tie.demand.ddt()).any()
            for tie in self.closed_form.ties
        )

    @cached_property
    def closures(self) -> list[Series]:
        """The left sides of Φ(q, t) = 0."""
        return [tie.demand for tie in self.closed_form.ties if not tie.of_velocities]

    @cached_property
    def sample(self) -> Sample:
        """States, with random parameters if the equations have a closed form."""
        return self.with_numbers(self._variable)

    def at(self, values: Mapping[str, Any], count: int = 0) -> SeriesValues:
        """Return the values of series where letters have these, others those of the sample."""
        known = {**self.sample.values, **values}
        return SeriesValues(self.closed_form, known, count or self.sample.count)

    def hold(self, varied: frozenset[str]) -> Truth:
        """Return the same with states in which only some parameters vary."""
        return self._with_sample(self.with_numbers(varied))

    def assemble(self, given: Collection[str]) -> Truth | None:
        """Return the same in the states in which loops are assembled as from zero.

        Where the other coordinates follow from those that are given, they may do so in two ways:
        the determinant of the constraints by them changes its sign only where both ways meet.
        """
        mechanism, names = self.mechanism, self.mechanism.coordinates.names
        following = [name for name in names if name not in given]
        if self.derivation is None or len(self.closures) != len(following) or not following:
            return None
        zero = np.zeros((1, mechanism.nq)), np.zeros((1, mechanism.nv)), np.zeros(1)
        from_zero = closed_states(mechanism, *zero).q
        if not len(from_zero):
            return None
        here, there = (
            np.linalg.det(self.at(values).slopes(self.closures, following))
            for values in ({}, dict(zip(names, from_zero[0], strict=True)))
        )
        alike = here * there > 0
        return self._with_sample(self.sample.take(alike)) if alike.any() else None

    def rest(self, position: Mapping[str, Array]) -> Truth | None:
        """Return the same at rest in a position, without inputs; None if it has no values."""
        sample = self.sample
        inputs = [signal.symbol for signal in self.mechanism.inputs]
        names = (*self.velocities, *inputs, *self.mechanism.coordinates, "t")
        zero = dict.fromkeys(names, 0.0)
        values: dict[str, Any] = {**sample.values, **zero, **position}
        still = self._evaluate(values, sample.count, varied=sample.varied, most=sample.count)
        if still is None or still.count < sample.count:
            return None
        return self._with_sample(still)

    def _with_sample(self, sample: Sample) -> Truth:
        same = copy(self)
        same.__dict__["sample"] = sample
        return same

    def change(self, mechanism: Mechanism) -> Truth:
        """Return the truth about a mechanism with other masses, in the same states."""
        return Truth(mechanism, self.seed, self._fixed)._with_sample(self.sample)

    def prepare(self) -> None:
        """Derive the equations and evaluate them in the states, if that is still to be done."""
        assert self.sample.count

    @cached_property
    def _variable(self) -> frozenset[str]:
        """The parameters that may vary; with loops only those that do not affect their closure."""
        if self.derivation is None:
            return frozenset()
        held = {g.name for tie in self.derivation.ties for g in tie.demand.generators()}
        held |= self._fixed
        return frozenset(p.symbol for p in self.mechanism.parameters if p.symbol not in held)

    @cached_property
    def resized(self) -> Truth | None:
        """The same with constraints of slightly other proportions; None where these are fixed."""
        sizes = {p.symbol for p in self.mechanism.parameters} - self._variable - self._fixed
        if self.derivation is None or len(sizes) < 2:
            return None  # with one size, units alone tell it from its powers
        random = np.random.default_rng(self.seed + 2)
        parameters = (
            p.with_value(p.value * (1 + _RESIZED * random.uniform(-1, 1)))
            if p.symbol in sizes
            else p
            for p in self.mechanism.parameters
        )
        other = Truth(replace(self.mechanism, parameters=tuple(parameters)), self.seed, self._fixed)
        # the letters are the same, and so are the equations
        other.__dict__["derivation"] = self.derivation
        try:
            return other if other.sample.count else None
        except InputError:
            return None  # the loops close in special proportions only

    def with_numbers(self, varied: frozenset[str]) -> Sample:
        """Return states in which only some parameters vary; the others have their own values."""
        varied &= self._variable
        if varied not in self._partly:
            drawn = self._compute() if self.derivation is None else self._draw(varied)
            self._partly[varied] = drawn
        return self._partly[varied]

    @cached_property
    def _states(self) -> States:
        """States of the mechanism, drawn once: those of loops take long."""
        assumed = self.closed_form.assumptions
        return random_states(self.mechanism, _CANDIDATES, self.seed, assumed)

    def _draw(self, varied: frozenset[str]) -> Sample:
        """Draw states, and evaluate the closed form in them."""
        mechanism, states = self.mechanism, self._states
        random = np.random.default_rng(self.seed + 1)
        values = self._letters(states, random, varied)
        sample = self._evaluate(values, len(states), varied=bool(varied), most=STATES)
        if sample is None:
            raise InputError(
                f"the equations of {mechanism.name!r} have a value at none of {len(states)} random "
                "states"
            )
        return sample

    def stretch(self, sample: Sample) -> Sample | None:
        """Return states near zero, at it and far out; None with loops or without a closed form."""
        # what vanishes near the random states, or is tiny there, shows in these
        if self.derivation is None or self.derivation.ties:
            return None
        # a quaternion keeps its unit length
        fixed = {k for _, at in self.mechanism.quaternions for k in at}
        moving = {name for k, name in enumerate(self.mechanism.coordinates) if k not in fixed}
        values: dict[str, Any] = {}
        for name, value in sample.values.items():
            scales = np.ones(len(_STRETCHES))
            if name in moving or name in self.velocities:
                scales = np.array([pair[name in self.velocities] for pair in _STRETCHES])
            values[name] = np.outer(scales, value).ravel()
        count = len(_STRETCHES) * sample.count
        return self._evaluate(values, count, varied=sample.varied, most=count)

    def _evaluate(
        self, values: dict[str, Any], n: int, *, varied: bool, most: int
    ) -> Sample | None:
        """Evaluate the closed form in n states; keep those with values, at most so many."""
        derivation = self.closed_form
        evaluated = SeriesValues(derivation, values, n)
        with np.errstate(all="ignore"):
            M, bias, forces = evaluated.M, *map(evaluated.stack, (derivation.h, derivation.Q))
            known = np.concatenate([M.reshape(n, -1), bias - forces], axis=1)
            possible = np.asarray(np.isfinite(known).all(axis=1))
            for assumption in derivation.assumptions:
                possible &= evaluated(assumption.positive) > 0
            if not derivation.ties:
                possible[possible] &= _are_regular(M[possible])
        at = np.flatnonzero(possible)[:most]
        if not len(at):
            return None
        values = {name: np.broadcast_to(value, (n,))[at] for name, value in values.items()}
        slopes, rates = self.constraints(evaluated, n)
        slopes, rates, M, bias, forces = slopes[at], rates[at], M[at], bias[at], forces[at]
        a, multipliers = accelerate(M, forces - bias, slopes, rates)
        values |= dict(zip(self.accelerations, a.T, strict=True))
        values |= dict(zip(self.multipliers, multipliers.T, strict=True))
        lengths = {}
        for name in derivation.lengths:
            lengths[name] = evaluated(derivation.algebra.ring[name])[at]
        return Sample(
            values=values,
            M=M,
            bias=bias,
            forces=forces,
            slopes=slopes,
            a=a,
            multipliers=multipliers,
            count=len(at),
            varied=varied,
            lengths=lengths,
        )

    @cached_property
    def multipliers(self) -> tuple[str, ...]:
        """The names of Lagrange's multipliers."""
        if self.derivation is None:
            return ()
        return tuple(f"lambda_{tie.name}" for tie in self.derivation.ties)

    @property
    def further_letters(self) -> tuple[str, ...]:
        """The letters besides the mechanism's own: multipliers, and lengths of springs."""
        lengths = () if self.derivation is None else tuple(self.derivation.lengths)
        return (*self.multipliers, *lengths)

    def constraints(self, evaluated: SeriesValues, n: int) -> tuple[Array, Array]:
        """Return J and b of J a + b = 0, shape (n, m, nv) and (n, m)."""
        derivation, nv = self.closed_form, self.mechanism.nv
        slopes, rates = np.zeros((n, len(derivation.ties), nv)), np.zeros((n, len(derivation.ties)))
        for k, tie in enumerate(derivation.ties):
            coefficients, rest = tie.second.linear(self.accelerations)
            slopes[:, k] = evaluated.stack(coefficients)
            rates[:, k] = evaluated(rest)
        return slopes, rates

    def _letters(
        self, states: States, random: np.random.Generator, varied: frozenset[str]
    ) -> dict[str, Any]:
        """Return the value of each letter; signals that are numbers or records are random."""
        mechanism, n = self.mechanism, len(states)
        values: dict[str, Any] = {"t": states.t, "pi": np.float64(math.pi)}
        for parameter in mechanism.parameters:
            factor = np.exp(random.uniform(-_SPREAD, _SPREAD, n))
            values[parameter.symbol] = (
                factor * (parameter.value or 1.0)
                if parameter.symbol in varied
                else np.full(n, parameter.value)
            )
        for signal in mechanism.inputs:
            if callable(signal.signal) or isinstance(signal.signal, float):
                values[signal.symbol] = random.uniform(-2.0, 2.0, n) * self._force_scale
            else:
                values[signal.symbol] = np.broadcast_to(evaluate(signal.signal, values), (n,))
        values |= dict(zip(mechanism.coordinates, states.q.T, strict=True))
        values |= dict(zip(mechanism.velocities, states.v.T, strict=True))
        return values

    @cached_property
    def _force_scale(self) -> float:
        """The mechanism's weight, the scale of random forces."""
        masses = [p.value for p in self.mechanism.parameters if p.unit == "kg" and p.value]
        return float(np.median(masses)) * 9.81 if masses else 1.0

    def _compute(self) -> Sample:
        """Draw states, and compute the equations numerically, without a closed form."""
        mechanism, equations = self.mechanism, self.equations
        states = random_states(mechanism, STATES, self.seed)
        n = len(states)
        values = dict(states.values) | {"pi": np.float64(math.pi)}
        arguments = (states.q, states.v, states.t)
        a = equations.acceleration(*arguments)
        values |= dict(zip(self.accelerations, a.T, strict=True))
        slopes = np.zeros((n, 0, mechanism.nv))
        values = {name: np.broadcast_to(value, (n,)) for name, value in values.items()}
        M = equations.mass_matrix(states.q, states.t)
        bias, forces = equations.bias(*arguments), equations.forces(*arguments)
        return Sample(
            values=values,
            M=M,
            bias=bias,
            forces=forces,
            slopes=slopes,
            a=a,
            multipliers=np.zeros((n, 0)),
            count=n,
            varied=False,
        )


def accelerate(M: Array, force: Array, J: Array, rates: Array) -> tuple[Array, Array]:
    """Solve M a = force + Jᵀ λ, J a + own = 0 for a and λ; redundant rows share their load."""
    n, m, nv = J.shape
    if not m:
        return np.asarray(np.linalg.solve(M, force[..., None])[..., 0]), np.zeros((n, 0))
    whole = np.zeros((n, nv + m, nv + m))
    whole[:, :nv, :nv] = M
    whole[:, :nv, nv:] = -J.transpose(0, 2, 1)
    whole[:, nv:, :nv] = J
    right = np.concatenate([force, -rates], axis=1)
    solution = (np.linalg.pinv(whole) @ right[..., None])[..., 0]
    return np.asarray(solution[:, :nv]), np.asarray(solution[:, nv:])


def _are_regular(M: Array) -> npt.NDArray[np.bool_]:
    diagonal = np.sqrt(np.abs(np.diagonal(M, axis1=1, axis2=2)))
    with np.errstate(all="ignore"):
        scaled = M / (diagonal[:, :, None] * diagonal[:, None, :])
    finite = np.isfinite(scaled).all((1, 2))
    condition = np.full(len(M), np.inf)
    condition[finite] = np.linalg.cond(scaled[finite])
    return np.asarray(condition < _SINGULAR)
