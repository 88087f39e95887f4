"""Misreadings of the description: exchanged letters, wrong angles, small motions."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import permutations
from typing import Any

import numpy as np

from mecanique.arrays import Array
from mecanique.checking.mistakes.slips.hypothesis import Hypothesis, RightEquations
from mecanique.derivation.scalars.evaluation import Evaluation
from mecanique.derivation.scalars.ring import Ring


def mistake_readings(right: RightEquations) -> Iterator[Hypothesis]:
    """Yield equations with parameters of the same unit exchanged throughout."""
    mechanism = right.truth.mechanism
    used = {g.name for row in right.derivation.rows for g in row.generators()}
    parameters = [p for p in mechanism.parameters if p.symbol in used]
    for one, other in permutations(parameters, 2):
        if one.unit != other.unit:
            continue
        moved = {one.symbol: right.sample.values[other.symbol]}
        what = f"{other.symbol} is written for {one.symbol} throughout"
        yield _read(right, "letter", what, 1.5, moved)
        if one.symbol < other.symbol:
            moved |= {other.symbol: right.sample.values[one.symbol]}
            what = f"{one.symbol} and {other.symbol} are exchanged throughout"
            yield _read(right, "letter", what, 1.5, moved)


def _read(
    right: RightEquations,
    kind: str,
    what: str,
    weight: float,
    moved: Mapping[str, Any],
    turn: Array | None = None,
) -> Hypothesis:
    """Return the equations with other values of letters; `turn` converts our a to theirs."""
    derivation = right.derivation
    evaluated = Evaluation(derivation.algebra.ring, {**right.sample.values, **moved})
    M, rest = right.evaluate(derivation, evaluated)
    if turn is not None:
        M = M @ turn
    return Hypothesis(kind, what, weight, M, rest)


def mistake_angles(right: RightEquations) -> Iterator[Hypothesis]:
    """Yield equations with absolute coordinates for relative ones, and vice versa."""
    mechanism, values = right.truth.mechanism, right.sample.values
    moving = [name for name in mechanism.coordinates if f"{name}'" in values]
    for one, other in permutations(moving, 2):
        for sign in (-1, 1):
            moved = {
                name: values[name] + sign * values[name.replace(other, one, 1)]
                for name in (other, f"{other}'")
            }
            turn = np.eye(mechanism.nv)
            places = mechanism.velocities
            turn[places.index(f"{other}'"), places.index(f"{one}'")] = sign
            what = (
                f"{other} is taken relative to {one} instead of absolute"
                if sign > 0
                else f"{other} is taken absolute instead of relative to {one}"
            )
            yield _read(right, "angle", what, 1.4, moved, turn)


def linearize(right: RightEquations) -> Iterator[Hypothesis]:
    """Yield the equations linearized about all coordinates zero, if that is an equilibrium."""
    derivation = right.derivation
    ring = derivation.algebra.ring
    if not isinstance(ring, Ring):
        return
    mechanism = right.truth.mechanism
    names = (*derivation.algebra.velocities, *mechanism.coordinates)
    still = {**right.sample.values, **dict.fromkeys(names, np.zeros(right.sample.count))}
    at_rest = Evaluation(ring, still)
    forces = [h - Q for h, Q in zip(derivation.h, derivation.Q, strict=True)]
    n, nv = right.sample.count, mechanism.nv
    with np.errstate(all="ignore"):
        M, rest = np.empty((n, nv, nv)), np.empty((n, nv))
        for i, entries in enumerate(derivation.M):
            for j, entry in enumerate(entries):
                M[:, i, j] = at_rest(entry)
            rest[:, i] = at_rest(forces[i])
            for name in names:
                if any(g.name == name for g in forces[i].generators()):
                    slope = at_rest(forces[i].diff(name))
                    rest[:, i] += slope * right.sample.values[name]
    yield Hypothesis(
        "linearized",
        "small angles are assumed throughout: it is the linearized equation",
        0.5,
        M,
        rest,
    )
