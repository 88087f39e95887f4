"""The period of a motion with one coordinate that begins at rest, by an integral of its energy."""

from __future__ import annotations

import numpy as np

from mecanique.arrays import Array
from mecanique.checking.grammar.tape import Rows, find_sign_changes
from mecanique.checking.judgement.truth import Truth
from mecanique.derivation.scalars.series import Series
from mecanique.derivation.symbolic.lagrange import Lagrange
from mecanique.errors import InputError
from mecanique.model.mechanism_units import characteristic_length
from mecanique.model.random_positions import angles

_AMPLITUDES = {True: (0.3, 2.5), False: (0.2, 1.5)}
"""Positions at rest, in radians where it turns, else in characteristic lengths."""

_REACH = {True: 2 * np.pi, False: 12.0}
_GRID = 400
_HALVINGS = 60
_FEWEST = 6
"""Least number of states in which the motion returns."""

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(200)


def release(truth: Truth, name: str) -> tuple[Array, Array]:
    """Return positions at rest of the only coordinate, and the period from each, shape (n,).

    The period is 2 ∫ dq √(M/(2 (V(q₀) − V(q)))) between the two positions at rest, where V is the
    potential without the part of T that does not depend on the velocity (Landau & Lifshitz,
    Mechanics, § 11); NaN where the motion does not return.
    """
    potential, inertia = _find_energy(truth, name)
    turns = name in angles(truth.mechanism)
    size = 1.0 if turns else characteristic_length(truth.mechanism)
    count = truth.sample.count
    start = size * np.random.default_rng(truth.seed).uniform(*_AMPLITUDES[turns], count)

    def evaluate(series: Series, states: Rows, q: Array) -> Array:
        return truth.at({**truth.sample.at(states), name: q}, len(states))(series)

    states = np.arange(count)
    height = evaluate(potential, states, start)
    downhill = -np.sign(evaluate(potential.diff(name), states, start))

    def rise(states: Rows, way: Array) -> Array:
        return evaluate(potential, states, start[states] + downhill[states] * way) - height[states]

    grid = np.linspace(0.0, _REACH[turns] * size, _GRID)[1:]
    rows, ways, _ = find_sign_changes(rise, count, grid, _HALVINGS)
    way = np.full(count, np.nan)
    rows, first = np.unique(rows, return_index=True)
    way[rows] = ways[first]
    if len(rows) < _FEWEST:
        raise InputError("released at rest it does not return, so it has no period")
    # over sin φ the inverse root, infinite at both ends, stays finite
    angle, period = np.pi / 2 * _NODES, np.zeros(count)
    for sine, cosine, weight in zip(np.sin(angle), np.cos(angle), _WEIGHTS, strict=True):
        q = start + downhill * way * (1 + sine) / 2
        fall = height - evaluate(potential, states, q)
        speed = np.sqrt(2 * fall / evaluate(inertia, states, q))
        period += np.pi / 2 * weight * way * cosine / speed
    return start, period


def _find_energy(truth: Truth, name: str) -> tuple[Series, Series]:
    """Return the potential and the inertia of the only coordinate."""
    lagrange = Lagrange(truth.mechanism, truth.closed_form.algebra)
    parts = lagrange.T.coefficients(truth.velocities)
    potential = lagrange.V - parts.get((0,), lagrange.V.ring.number(0))
    inertia = truth.closed_form.M[0][0]
    moving = {g.name for series in (potential, inertia) for g in series.generators()}
    alone = truth.velocities == (f"{name}'",) and not truth.mechanism.constrained
    if not alone or "t" in moving or not _is_kept(truth, potential, inertia, name):
        raise InputError(
            f"the period of {truth.mechanism.name!r} from rest is no integral: expected one "
            "coordinate, and neither damping nor forces that depend on the time"
        )
    return potential, inertia


def _is_kept(truth: Truth, potential: Series, inertia: Series, name: str) -> bool:
    """Whether the forces keep the energy: they are V' + M' v²/2, with the slopes by q."""
    sample = truth.sample
    pull, change = (truth.at({})(series.diff(name)) for series in (potential, inertia))
    if not pull.any():
        return False
    force = pull + change * sample.values[f"{name}'"] ** 2 / 2
    rest = (sample.bias - sample.forces)[:, 0]
    return bool((np.abs(rest - force) <= 1e-9 * (np.abs(rest) + np.abs(force))).all())
