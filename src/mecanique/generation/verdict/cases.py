"""Choose the states in which code is compared, and compute Pinocchio's values there.

Half of the states have the mechanism's own parameters; in the others every parameter that the code
takes is changed by up to a tenth, in a few different ways.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import reduce

import numpy as np

from mecanique.errors import MecaniqueError
from mecanique.generation.program import Program
from mecanique.generation.targets.target import Cases
from mecanique.generation.verdict.answers import ROUNDED, answer_of, unit_of
from mecanique.generation.verdict.differences import TOLERANCE as DIFFERENCES
from mecanique.generation.verdict.differences import differences
from mecanique.model.mechanism import Mechanism
from mecanique.model.states import States, seated_velocities
from mecanique.reference import Reference
from mecanique.verification.difference import scales
from mecanique.verification.rounding import UNIT, rounding
from mecanique.verification.rows import moving_mass
from mecanique.verification.states import random_states

TOLERANCE = 1e-13
"""Largest relative difference that counts as agreement, unless rounding allows more."""

_VARIATIONS = 5
_CHANGE = 0.1

_ROUNDS = 10
"""How often states are drawn until enough of them are not singular."""

_RANK = 1e-9
"""Singular values of the constraints below this part of their size count as zero."""

_SMALL = 1e-3
"""Answers below this part of the typical size are compared with the typical size."""

_LEAST = {
    **dict.fromkeys(("mass_matrix", "poses", "jacobians", "closure"), 0.0),
    **dict.fromkeys(("energy", "reactions"), 1.0),
}
"""The typical size of a quantity at 1 m/s or 1 m/s², as a power of the moving mass."""


def cases_of(program: Program, samples: int, seed: int) -> Cases:
    """Return states with Pinocchio's values there.

    Args:
        program: the program to be compared.
        samples: number of states.
        seed: of the random states.

    Raises:
        MecaniqueError: if Pinocchio cannot treat the mechanism.
    """
    parts = [
        _compute_cases(program, mechanism, number, seed + k)
        for k, (mechanism, number) in enumerate(_vary(program, samples, seed))
    ]
    return reduce(Cases.join, parts)


def count_varied(program: Program, cases: Cases) -> int:
    """Return the number of states with parameters other than the mechanism's.

    Args:
        program: the compared program.
        cases: the states.
    """
    own = np.array([program.mechanism.values.get(p.name, np.nan) for p in program.parameters])
    same = (cases.inputs["p"] == own) | np.isnan(own)
    return int(np.count_nonzero(~same.all(axis=1)))


def _vary(program: Program, samples: int, seed: int) -> Iterator[tuple[Mechanism, int]]:
    """Yield the mechanism, then variants of its parameters, each with its number of states."""
    mechanism = program.mechanism
    symbols = [p.name for p in program.parameters if p.name in mechanism.values]
    number = samples // (2 * _VARIATIONS)
    varied = []
    random = np.random.default_rng(seed)
    for _ in range(_VARIATIONS if symbols and number and not mechanism.constrained else 0):
        factors = random.uniform(1 - _CHANGE, 1 + _CHANGE, len(symbols))
        values = {
            symbol: mechanism.values[symbol] * float(factor)
            for symbol, factor in zip(symbols, factors, strict=True)
        }
        try:
            other = mechanism.replace(**values)
            Reference.of(other)
        except MecaniqueError:
            continue
        varied.append(other)
    yield mechanism, samples - number * len(varied)
    for other in varied:
        yield other, number


def _compute_cases(program: Program, mechanism: Mechanism, samples: int, seed: int) -> Cases:
    reference = Reference.of(mechanism)
    states = _draw_regular(reference, samples, seed)
    samples = len(states)
    random = np.random.default_rng(seed)
    q, v, t = states.q, states.v, states.t
    M = np.asarray(reference.mass_matrix(q, t))
    d = scales(M)
    bias = np.asarray(reference.bias(q, v, t))
    tau = d * random.normal(size=d.shape) * np.linalg.norm(bias / d, axis=1, keepdims=True)
    if any("reactions" in (a.quantity.name, a.quantity.base) for a in program.answers):
        tau = tau * _has_seat(mechanism)
    basis = {
        "mass matrix": M,
        "bias": bias,
        "forces": np.asarray(reference.forces(q, v, t)) + tau,
        "acceleration": np.asarray(reference.acceleration(q, v, t, tau=tau)),
    }
    excused = rounding(mechanism, states, basis)
    if mechanism.constrained:
        # accelerations that loops keep small are differences of larger terms
        alone = np.linalg.pinv(M / (d[:, :, None] * d[:, None, :]), hermitian=True)
        parts = (alone @ ((basis["forces"] - bias) / d)[..., None])[..., 0]
        excused["acceleration"] = excused["acceleration"] + UNIT * np.linalg.norm(parts, axis=1)
    expected: dict[str, np.ndarray] = {}
    weights: dict[str, np.ndarray] = {}
    allowed: dict[str, np.ndarray] = {}
    mass = moving_mass(mechanism)
    for answer in program.answers:
        quantity = answer.quantity
        name, base = quantity.name, quantity.base or quantity.name
        if quantity.by:
            values, compared = differences(quantity, program, reference, states, tau)
            rows = unit_of(base, values[..., 0], d, mass)
            unit = (rows[:, :, None] * compared).reshape(samples, -1)
        else:
            values = answer_of(name, reference, states, tau)
            unit = unit_of(name, values, d, mass)
        values = values.reshape(samples, -1)
        size = _find_sizes(name, np.abs(values * unit), mass)
        expected[name] = values
        weights[name] = unit / size
        rounded = excused.get(ROUNDED.get(base, base), np.zeros(samples)) / size.min(axis=1)
        allowed[name] = np.maximum(DIFFERENCES if quantity.by else TOLERANCE, rounded)
    p = np.empty((samples, len(program.parameters)))
    for k, letter in enumerate(program.parameters):
        p[:, k] = states.values[letter.name]
    inputs = {"t": t[:, None], "q": q, "v": v, "a": states.a, "tau": tau, "p": p}
    return Cases(inputs, expected, weights, allowed)


def _has_seat(mechanism: Mechanism) -> np.ndarray:
    """Return whether Pinocchio's side knows where tau on each velocity acts, shape (nv,)."""
    seated = seated_velocities(mechanism)
    return np.array([name in seated for name in mechanism.velocities])


def _draw_regular(reference: Reference, samples: int, seed: int) -> States:
    """Return random states; for a closed mechanism only those where its constraints keep rank."""
    mechanism = reference.mechanism
    states = random_states(mechanism, samples, seed)
    if not mechanism.constrained:
        return states
    found = []
    for k in range(_ROUNDS):
        J = np.asarray(reference.constraint_jacobian(states.q, states.t))
        ranks = np.linalg.matrix_rank(J, tol=_RANK * np.linalg.norm(J, axis=(1, 2)))
        found.append((ranks, states))
        most = max(int(ranks.max()) for ranks, _ in found)
        if sum(int((ranks == most).sum()) for ranks, _ in found) >= samples:
            break
        states = random_states(mechanism, samples, seed + k + 1)
    kept = [states.at(np.flatnonzero(ranks == most)) for ranks, states in found]
    return States(
        mechanism,
        np.concatenate([part.q for part in kept])[:samples],
        np.concatenate([part.v for part in kept])[:samples],
        np.concatenate([part.t for part in kept])[:samples],
        np.concatenate([part.a for part in kept])[:samples],
    )


def _find_sizes(name: str, sizes: np.ndarray, mass: float) -> np.ndarray:
    """Return the sizes with which differences are compared, shape (n, 1), for energies (n, 2)."""
    least = mass ** _LEAST.get(name, 0.5)
    if name != "energy":
        size = np.linalg.norm(sizes, axis=1, keepdims=True)
        # a closure is zero up to the rounding of lengths
        floor = 1.0 if name == "closure" else _SMALL * max(np.sqrt(np.mean(size**2)), least)
        return np.asarray(np.maximum(size, floor))
    # each energy by itself; the potential energy has an arbitrary constant
    typical = np.sqrt(np.mean(sizes**2, axis=0))
    return np.asarray(np.maximum(np.maximum(sizes, typical), _SMALL * least))
