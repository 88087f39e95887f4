"""The quantities besides equations of motion that can be checked, with their true values."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Literal, TypeAlias, final

import numpy as np

from mecanique.arrays import Array
from mecanique.checking.judgement.truth import Sample, Truth
from mecanique.derivation import derive
from mecanique.derivation.scalars.evaluation import Evaluation
from mecanique.derivation.scalars.series import Series
from mecanique.derivation.symbolic.derivation import Derivation, Left
from mecanique.derivation.symbolic.lagrange import Lagrange
from mecanique.errors import DerivationError, InputError, UnknownNameError
from mecanique.model.mechanism_units import units
from mecanique.model.units import Dimension, read_unit

Kind: TypeAlias = Literal[
    "value",
    "up to a constant",
    "matrix",
    "conserved",
    "several",
    "equilibrium",
    "letters",
    "free body",
]
"""The way to compare a formula."""


@final
@dataclass(frozen=True, eq=False)
class Quantity:
    """A quantity in question.

    Args:
        name: name of the question.
        kind: the way to compare a formula.
        letters: the letters that denote it in equations.
        values: its values in the states, shape (n,); of a matrix (n, nv, nv); of several (k, n).
        again: its values in other states with the same parameters, and the letters there.
        series: its value in the ring of the derivation, by letter; a matrix row by row.
        derivation: the derivation with that ring, if not that of the equations of motion.
        dimensions: dimensions of the letters, where known.
    """

    name: str
    kind: Kind
    letters: tuple[str, ...] = ()
    values: Array | None = None
    again: tuple[Array, Mapping[str, Array]] | None = None
    series: Mapping[str, Series] = field(default_factory=dict)
    derivation: Derivation | None = None
    dimensions: Mapping[str, Dimension] = field(default_factory=dict)


_ZERO = np.zeros(())

_LETTERS = {
    "kinetic energy": ("T", "Ek", "Ekin", "KE", "K"),
    "potential energy": ("V", "U", "Ep", "Epot", "PE"),
    "Lagrangian": ("L", "Lagrangian"),
    "energy": ("E", "H", "h"),
    "mass matrix": (),
    "momentum": ("p",),
    "conserved quantity": (*"EHhCcpALJKk", "C1", "C2", "c1", "c2", "Lz", "const"),
    "frequency": ("omega", "omega0", "omegan", "w", "f", "nu", "T", "T0"),
    "equilibrium": (),
    "reaction": (),
}

_NUMBERED = ("omega", "w", "f", "nu", "T")
"""Letters of frequencies and periods that may be numbered, as omega1."""

_OF = ("momentum", "equilibrium")
"""Questions that may name a coordinate or a body."""

QUESTIONS = ("equation of motion", *_LETTERS)
"""The possible questions."""


def ask_for(truth: Truth, question: str) -> Quantity:
    """Return the quantity that a question asks for."""
    name, _, what = question.partition(" of ")
    if name not in QUESTIONS or (what and name not in _OF):
        raise UnknownNameError("question", question, QUESTIONS)
    if truth.derivation is None:
        raise InputError(
            f"the equations of {truth.mechanism.name!r} have no closed form, with which a "
            f"{name} could be compared"
        )
    return _Asked(truth).find(name, what)


@final
class _Asked:
    """Computes true values.

    Args:
        truth: the mechanism's own equations.
    """

    def __init__(self, truth: Truth) -> None:
        self._truth = truth
        self._sample = truth.sample

    def find(self, name: str, what: str) -> Quantity:
        find: dict[str, Callable[[str, str], Quantity]] = {
            "kinetic energy": self._energy,
            "potential energy": self._energy,
            "Lagrangian": self._energy,
            "energy": self._energy,
            "mass matrix": self._mass,
            "momentum": self._momentum,
            "conserved quantity": self._constant,
            "frequency": self._frequency,
            "equilibrium": self._equilibrium,
            "reaction": self._reactions,
        }
        return find[name](name, what)

    @cached_property
    def _lagrange(self) -> Lagrange:
        derivation = self._truth.derivation
        return Lagrange(self._truth.mechanism, derivation.algebra if derivation else None)

    def _energy(self, name: str, _: str) -> Quantity:
        T, V = self._lagrange.T, self._lagrange.V
        series = {
            "kinetic energy": T,
            "potential energy": V,
            "Lagrangian": T - V,
            "energy": T + V,
        }[name]
        found = self._value(series, self._sample.values)
        joules = dict.fromkeys(_LETTERS[name], read_unit("N·m"))
        if name == "kinetic energy":
            own = Quantity(name, "value", _LETTERS[name], found, dimensions=joules)
            return self._in_letters(own, series)
        moved = roll(self._truth, self._sample)
        again = self._value(series, moved), moved
        whole = Quantity(name, "up to a constant", _LETTERS[name], found, again, dimensions=joules)
        return self._in_letters(whole, series)

    def _in_letters(self, quantity: Quantity, series: Series) -> Quantity:
        return replace(quantity, series=dict.fromkeys(quantity.letters, series))

    def _value(self, series: Series, values: Mapping[str, Array]) -> Array:
        evaluated = Evaluation(series.ring, values)
        return np.broadcast_to(np.asarray(evaluated(series), dtype=float), (self._sample.count,))

    def _mass(self, name: str, _: str) -> Quantity:
        derivation = self._truth.derivation
        assert derivation is not None
        entries = [entry for row in derivation.M for entry in row]
        series = {str(k): entry for k, entry in enumerate(entries)}
        return Quantity(name, "matrix", (), self._sample.M, series=series)

    def _momentum(self, name: str, what: str) -> Quantity:
        coordinates = [v.removesuffix("'") for v in self._truth.velocities]
        if not what and len(coordinates) > 1:
            raise InputError(
                f'expected the coordinate of the momentum, e.g. "momentum of {coordinates[0]}"'
            )
        chosen = what or coordinates[0]
        if chosen not in coordinates:
            raise UnknownNameError("coordinate", chosen, coordinates)
        velocity = self._truth.velocities[coordinates.index(chosen)]
        series = self._lagrange.T.diff(velocity)
        found = self._value(series, self._sample.values)
        letters = ("p", f"p{chosen}", f"p{coordinates.index(chosen) + 1}")
        own = units(self._truth.mechanism).get(velocity)
        unit = {} if own is None else dict.fromkeys(letters, _divide("N·m", own))
        return self._in_letters(Quantity(name, "value", letters, found, dimensions=unit), series)

    def _reactions(self, name: str, _: str) -> Quantity:
        derivation = balances(self._truth)
        found = [self._value(one, self._sample.values) for one in derivation.reactions.values()]
        values = np.stack(found) if found else np.zeros((0, self._sample.count))
        letters = tuple(derivation.reactions)
        return Quantity(name, "letters", letters, values, None, derivation.reactions, derivation)

    def _equilibrium(self, name: str, what: str) -> Quantity:
        """Return the mechanism's equilibrium, or the balance of forces on one free body."""
        if not what:
            return Quantity(name, "equilibrium")
        bodies = [body.name for body in self._truth.mechanism.bodies[1:]]
        if what not in bodies:
            raise UnknownNameError("body", what, bodies)
        derivation = balances(self._truth)
        series = dict(derivation.reactions)
        for stage in derivation.stages:
            for result in stage.results:
                if isinstance(result.left, Left) and stage.title.startswith(f"Free body {what}:"):
                    series[result.left.symbol] = result.right
        still = {**self._sample.values, **dict.fromkeys(self._truth.velocities, _ZERO)}
        still |= dict.fromkeys(self._truth.accelerations, _ZERO)
        values = np.stack([self._value(one, self._sample.values) for one in series.values()])
        at_rest = np.stack([self._value(one, still) for one in series.values()])
        again = (at_rest, still)
        return Quantity(
            f"{name} of {what}", "free body", tuple(series), values, again, series, derivation
        )

    def _constant(self, name: str, _: str) -> Quantity:
        momenta = [f"p{velocity.removesuffix(chr(39))}" for velocity in self._truth.velocities]
        return Quantity(name, "conserved", (*_LETTERS[name], *momenta))

    def _frequency(self, name: str, _: str) -> Quantity:
        M, C, K = linear_matrices(self._truth, self._sample)
        if np.abs(C).max(initial=0.0) > 1e-12:
            raise InputError("the mechanism is damped or gyroscopic; expected one that is neither")
        squares = np.linalg.eigvals(np.linalg.solve(M, K))
        if (squares.real < -1e-9 * np.abs(squares).max()).any():
            raise InputError("the position with all coordinates zero is not stable")
        found = np.sort(np.sqrt(np.maximum(squares.real, 0.0)), axis=1)
        numbered = [
            f"{letter}{k + 1}" for letter in _NUMBERED for k in range(len(self._truth.velocities))
        ]
        letters = (*_LETTERS[name], *numbered)
        rate, time = read_unit("1/s"), read_unit("s")
        unit = {letter: time if letter.startswith("T") else rate for letter in letters}
        return Quantity(name, "several", letters, found.T, dimensions=unit)


def _divide(unit: str, by: str) -> Dimension:
    pairs = zip(read_unit(unit), read_unit(by), strict=True)
    return tuple(above - below for above, below in pairs)


def roll(truth: Truth, sample: Sample) -> dict[str, Array]:
    """Return the letters with the coordinates and rates of other states, parameters unchanged."""
    moving = {*truth.mechanism.coordinates, *truth.velocities, *truth.accelerations}
    return {
        name: np.roll(value, 1) if name in moving else value
        for name, value in sample.values.items()
    }


def linear_matrices(truth: Truth, sample: Sample) -> tuple[Array, Array, Array]:
    """Return M, C and K of small motions about the position with all coordinates zero."""
    derivation = truth.derivation
    if derivation is None or truth.mechanism.constrained:
        raise InputError(
            f"frequencies of {truth.mechanism.name!r} cannot be compared: it is closed, or has no "
            "closed form"
        )
    signals = [signal.symbol for signal in truth.mechanism.inputs]
    names = (*truth.velocities, *truth.mechanism.coordinates, *signals)
    still = {**sample.values, **dict.fromkeys(names, np.zeros(sample.count))}
    evaluated = Evaluation(derivation.algebra.ring, still)
    n, nv = sample.count, len(truth.velocities)
    M, C, K = (np.zeros((n, nv, nv)) for _ in range(3))
    with np.errstate(all="ignore"):
        for i, (h, Q) in enumerate(zip(derivation.h, derivation.Q, strict=True)):
            force = h - Q
            rest = np.broadcast_to(evaluated(force), (n,))
            for j, velocity in enumerate(truth.velocities):
                M[:, i, j] = evaluated(derivation.M[i][j])
                C[:, i, j] = evaluated(force.diff(velocity))
            for j, slope in enumerate(_along(force, truth.velocities)):
                K[:, i, j] = evaluated(slope)
            if not (np.abs(rest) <= 1e-9 * (1.0 + np.abs(K[:, i]).sum(1))).all():
                raise InputError("the position with all coordinates zero is not an equilibrium")
    known = all(np.isfinite(matrix).all() for matrix in (M, C, K))
    if not known or (np.linalg.matrix_rank(M) < nv).any():
        raise InputError("the equations have no meaning with all coordinates zero")
    return M, C, K


def _along(force: Series, velocities: tuple[str, ...]) -> list[Series]:
    """Return the derivatives of a force by the coordinates of some velocities."""
    moving = {g.name for g in force.generators()}
    zero = force.ring.number(0)
    return [
        force.diff(name.removesuffix("'")) if name.removesuffix("'") in moving else zero
        for name in velocities
    ]


def balances(truth: Truth) -> Derivation:
    """Derive the balances of all free bodies, by Newton and Euler's method."""
    try:
        return derive(truth.mechanism, "newton_euler").derivation
    except DerivationError as error:
        raise InputError(f"the reactions have no closed form: {error}") from None
