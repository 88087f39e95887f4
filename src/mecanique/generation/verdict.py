"""Run what was written, and compare it with Pinocchio: the only module here that knows the engine.

Half of the states have the mechanism's own parameters; the others change every parameter that the
code takes by up to a tenth, in a few different ways.
"""

from __future__ import annotations

import subprocess
from collections.abc import Iterator
from dataclasses import dataclass
from functools import reduce
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, final

import numpy as np

from mecanique.errors import DerivationError, InputError, MecaniqueError
from mecanique.generation.program.program import Program
from mecanique.generation.targets.target import Cases, Target
from mecanique.model.mechanism import Mechanism
from mecanique.model.states import States
from mecanique.reference import Reference
from mecanique.verification.conditioning import rounding
from mecanique.verification.difference import scales
from mecanique.verification.rows import moving_mass
from mecanique.verification.states.random import random_states
from mecanique.verification.verdict import versions

__all__ = ["TOLERANCE", "CodeVerdict", "cases_of", "judge"]

TOLERANCE = 1e-13
"""Largest relative difference that counts as agreement, wherever rounding makes less."""

_VARIATIONS = 5
_CHANGE = 0.1

_ROUNDS = 10
"""How often states are drawn to find enough that are not singular."""

_RANK = 1e-9
"""Singular values of the constraints below this part of their size count as zero."""

_SMALL = 1e-3
"""Part of the typical size below which an answer is judged against the typical size."""

_LEAST = {"mass matrix": 0.0, "poses": 0.0, "kinetic energy": 1.0}
"""Power of the moving mass that is the typical size of what it does at 1 m/s or 1 m/s²."""


@final
@dataclass(frozen=True)
class CodeVerdict:
    """Whether code gives what Pinocchio gives.

    Args:
        samples: number of states at which it was compared.
        seed: of these.
        tolerance: largest relative difference that counts as agreement where rounding makes less.
        worst: worst relative difference of each quantity, by name.
        rounded: largest difference that rounding excuses at some state, by name; 0 where the
            tolerance was enough everywhere.
        versions: of what took part, by name.
        varied: number of states with other parameters than the mechanism's.
    """

    samples: int
    seed: int
    tolerance: float
    worst: dict[str, float]
    rounded: dict[str, float]
    versions: dict[str, str]
    varied: int = 0

    def lines(self) -> list[str]:
        """Return it in sentences, for the head of a file."""
        by = ", ".join(f"{name} {version}" for name, version in self.versions.items())
        varied = f", {self.varied} of them with other parameters" if self.varied else ""
        lines = [
            f"Run and compared with Pinocchio at {self.samples} random states (seed {self.seed})"
            f"{varied}:"
        ]
        for name, worst in self.worst.items():
            excused = self.rounded.get(name, 0.0)
            beyond = f"; rounding allows {excused:.1e}" if worst > self.tolerance else ""
            lines.append(f"  {name}: worst relative difference {worst:.1e}{beyond}")
        return [*lines, f"With {by}."]

    def __str__(self) -> str:
        return "\n".join(self.lines())


def cases_of(program: Program, samples: int, seed: int) -> Cases:
    """Return states with what Pinocchio gives there.

    Args:
        program: what will be compared.
        samples: number of states.
        seed: of these.

    Raises:
        MecaniqueError: if Pinocchio cannot treat the mechanism.
    """
    parts = [
        _cases(program, mechanism, number, seed + k)
        for k, (mechanism, number) in enumerate(_variations(program, samples, seed))
    ]
    return reduce(Cases.join, parts)


def judge(program: Program, target: Target, cases: Cases, seed: int) -> CodeVerdict:
    """Run the test of a program.

    Args:
        program: the program.
        target: its language.
        cases: the states.
        seed: of these.

    Raises:
        InputError: if what runs the language is not installed.
        DerivationError: if the code cannot be run, or gives something else than Pinocchio.
    """
    with TemporaryDirectory() as folder:
        directory = Path(folder)
        files = target.files(program, ["unjudged"]) | target.test_files(program, cases)
        for name, text in files.items():
            (directory / name).write_text(text, encoding="utf-8")
        done = None
        for command in target.commands(program, directory):
            done = subprocess.run(command, capture_output=True, text=True, check=False)
            if done.returncode and not done.stdout:
                raise DerivationError(
                    f"the {target.title} of {program.mechanism.name!r} does not run: "
                    f"{done.stderr.strip()[:2000]}"
                )
    assert done is not None, "every language has a command"
    worst = {name: float(number) for name, number, _ in map(str.split, done.stdout.splitlines())}
    if done.returncode:
        raise DerivationError(
            f"the {target.title} of {program.mechanism.name!r} and Pinocchio disagree: "
            f"{'; '.join(done.stderr.splitlines()[:3])}"
        )
    return CodeVerdict(
        len(cases),
        seed,
        TOLERANCE,
        worst,
        {name: float(np.max(rows, initial=0.0)) for name, rows in cases.allowed.items()},
        {**versions(), "run by": target.version()},
        _count_varied(program, cases),
    )


def _variations(program: Program, samples: int, seed: int) -> Iterator[tuple[Mechanism, int]]:
    """The mechanism, and sound ones with other parameters, with the number of states of each."""
    mechanism = program.mechanism
    symbols = [p.name for p in program.parameters if p.name in mechanism.values]
    number = samples // (2 * _VARIATIONS)
    varied = []
    random = np.random.default_rng(seed)
    for _ in range(_VARIATIONS if symbols and number and not mechanism.loops else 0):
        factors = random.uniform(1 - _CHANGE, 1 + _CHANGE, len(symbols))
        values = {
            symbol: mechanism.values[symbol] * float(factor)
            for symbol, factor in zip(symbols, factors, strict=True)
        }
        try:
            other = mechanism.replace(**values)
            Reference(other)
        except MecaniqueError:
            continue
        varied.append(other)
    yield mechanism, samples - number * len(varied)
    for other in varied:
        yield other, number


def _cases(program: Program, mechanism: Mechanism, samples: int, seed: int) -> Cases:
    reference = Reference(mechanism)
    states = _regular_states(reference, samples, seed)
    samples = len(states)
    random = np.random.default_rng(seed)
    q, v, t = states.q, states.v, states.t
    M = np.asarray(reference.mass_matrix(q, t))
    d = scales(M)
    basis = {
        "mass matrix": M,
        "bias": np.asarray(reference.bias(q, v, t)),
        "forces": np.asarray(reference.forces(q, v, t)),
    }
    tau = d * random.normal(size=d.shape) * np.linalg.norm(basis["bias"] / d, axis=1, keepdims=True)
    if mechanism.loops:
        tau = np.zeros_like(d)
    basis["acceleration"] = np.asarray(reference.acceleration(q, v, t, tau=tau))
    excused = rounding(mechanism, states, {**basis, "forces": basis["forces"] + tau})
    expected: dict[str, np.ndarray] = {}
    weights: dict[str, np.ndarray] = {}
    allowed: dict[str, np.ndarray] = {}
    mass = moving_mass(mechanism)
    for answer in program.answers:
        name = answer.quantity.name
        values, unit, quantity = _expect(name, reference, states, basis, d, mass)
        values = values.reshape(samples, -1)
        sizes = np.abs(values * unit)
        size = sizes if name == "energy" else np.linalg.norm(sizes, axis=1, keepdims=True)
        least = mass ** _LEAST.get(quantity, 0.5)
        typical = np.sqrt(np.mean(size**2, axis=0))
        if name == "energy":  # which is known up to a constant
            size = np.maximum(size, typical)
        size = np.maximum(size, _SMALL * np.maximum(typical, least))
        expected[name] = values
        weights[name] = np.broadcast_to(unit, values.shape) / size
        rounded = excused.get(quantity, np.zeros(samples)) / size.min(axis=1)
        allowed[name] = np.maximum(TOLERANCE, rounded)
    p = np.empty((samples, len(program.parameters)))
    for k, letter in enumerate(program.parameters):
        p[:, k] = states.values[letter.name]
    inputs = {"t": t[:, None], "q": q, "v": v, "a": states.a, "tau": tau, "p": p}
    return Cases(inputs, expected, weights, allowed)


def _regular_states(reference: Reference, samples: int, seed: int) -> States:
    """Random states, of a closed mechanism those at which its loops hold all that they can."""
    mechanism = reference.mechanism
    states = random_states(mechanism, samples, seed)
    if not mechanism.loops:
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


def _expect(
    name: str,
    reference: Reference,
    states: States,
    basis: dict[str, np.ndarray],
    d: np.ndarray,
    mass: float,
) -> tuple[np.ndarray, Any, str]:
    """What Pinocchio gives, the unit that makes its entries alike, and what rounding it has."""
    q, v, t = states.q, states.v, states.t
    match name:
        case "rhs":
            rates = np.asarray(reference.rates(q, v))
            both = np.hstack([rates, basis["acceleration"]])
            return both, np.hstack([np.full_like(rates, np.sqrt(mass)), d]), "acceleration"
        case "acceleration":
            return basis["acceleration"], d, "acceleration"
        case "mass_matrix":
            scale = 1 / (d[:, :, None] * d[:, None, :])
            return basis["mass matrix"], scale.reshape(len(d), -1), "mass matrix"
        case "bias" | "forces":
            return basis[name], 1 / d, name
        case "gravity":
            return np.asarray(reference.gravity(q, t)), 1 / d, "gravity"
        case "inverse_dynamics":
            needed = reference.inverse_dynamics(q, v, states.a, t)
            return np.asarray(needed), 1 / d, "inverse dynamics"
        case "energy":
            energy = reference.energy(q, v, t)
            V = np.asarray(energy.gravity) + np.asarray(energy.springs)
            return np.stack([np.asarray(energy.kinetic), V], axis=-1), 1.0, "kinetic energy"
        case "poses":
            bodies = [b.name for b in reference.mechanism.bodies]
            return _poses(reference, states, bodies), 1.0, "poses"
    raise InputError(f"{name!r} cannot be compared with Pinocchio")


def _poses(reference: Reference, states: States, bodies: list[str]) -> np.ndarray:
    ground = reference.mechanism.ground
    found = [
        np.asarray(reference.pose(body, states.q, states.t))[:, :3]
        for body in bodies
        if body != ground
    ]
    return np.stack(found, axis=1)


def _count_varied(program: Program, cases: Cases) -> int:
    own = np.array([program.mechanism.values.get(p.name, np.nan) for p in program.parameters])
    same = (cases.inputs["p"] == own) | np.isnan(own)
    return int(np.count_nonzero(~same.all(axis=1)))
