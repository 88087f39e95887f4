"""Run the written code, and compare it with Pinocchio.

Half of the states have the mechanism's own parameters; in the others every parameter that the code
takes is changed by up to a tenth, in a few different ways. Derivatives are finite differences of
the sixth order.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import reduce
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, final

import numpy as np

from mecanique.errors import DerivationError, EngineError, InputError, MecaniqueError
from mecanique.files import as_bytes
from mecanique.generation.program import QUANTITIES, Output, Program
from mecanique.generation.targets.target import Cases, Target, run_command
from mecanique.model.mechanism import Mechanism
from mecanique.model.mechanism_units import characteristic_length
from mecanique.model.states import States, seated_velocities
from mecanique.model.values import Given
from mecanique.reference import Reference, assemble
from mecanique.verification.modes import measure_elements, solve_mode
from mecanique.verification.rounding import UNIT, measure_noise, rounding
from mecanique.verification.rows import moving_mass, scales
from mecanique.verification.states import random_states
from mecanique.verification.stencil import WEIGHTS
from mecanique.verification.verdict import NOT_INSTALLED, versions

ROUNDED = {
    "rhs": "acceleration",
    "mass_matrix": "mass matrix",
    "inverse_dynamics": "inverse dynamics",
    "multipliers": "acceleration",
}
"""The name under which the rounding of a quantity is known, if it is not its own."""


def answer_of(name: str, reference: Reference, states: States, tau: np.ndarray) -> np.ndarray:
    """Compute a quantity by Pinocchio, shape (n, …); tau (n, nv)."""
    q, v, t = states.q, states.v, states.t
    given = {"q": q, "v": v, "t": t, "a": states.a, "tau": tau}
    mechanism = reference.mechanism
    moved = [body.name for body in mechanism.bodies if body.name != mechanism.ground]
    match name:
        case "rhs":
            rates = np.asarray(reference.rates(q, v))
            return np.hstack([rates, answer_of("acceleration", reference, states, tau)])
        case "energy":
            energy = reference.energy(q, v, t)
            V = np.asarray(energy.gravity) + np.asarray(energy.springs)
            return np.stack([np.asarray(energy.kinetic), V], axis=-1)
        case "poses":
            poses = [np.asarray(reference.pose(body, q, t))[:, :3] for body in moved]
            return np.stack(poses, axis=1)
        case "jacobians":
            return np.stack([np.asarray(reference.jacobian(body, q, t)) for body in moved], axis=1)
        case "reactions":
            return _compute_reactions(reference, states, tau)
        case "closure":
            residual = np.asarray(reference.constraint_residual(q, t))
            return np.hstack([residual, _compute_gap_rates(reference, states)])
        case "multipliers":
            return _compute_multipliers(reference, states, tau)
    if name not in QUANTITIES:
        raise InputError(f"{name!r} cannot be compared with Pinocchio")
    taken = {kind: given[kind] for kind in QUANTITIES[name].takes}
    return np.asarray(getattr(reference, name)(**taken))


def _compute_reactions(reference: Reference, states: States, tau: np.ndarray) -> np.ndarray:
    """Return the wrenches of joints on their children, then of loops, (n, joints and loops, 6)."""
    wrenches = reference.reactions(states.q, states.v, states.t, tau)
    loose = [name for name, wrench in wrenches.items() if wrench.undetermined]
    if loose:
        raise DerivationError(
            f"the reactions of mechanism {reference.mechanism.name!r} are undetermined in "
            f"{', '.join(loose)}"
        )
    rows = [np.concatenate([w.force, w.moment], axis=-1) for w in wrenches.values()]
    return np.stack(rows, axis=1)


def _compute_gap_rates(reference: Reference, states: States) -> np.ndarray:
    """Return Φ', or ψ for rows that restrict velocities only, shape (n, m)."""
    assert reference.closed is not None, "the mechanism has loops"
    gap_rates = []
    for q, v, t in zip(states.q, states.v, states.t.tolist(), strict=True):
        here = reference.closed.closures.at(q, v, t)
        gap_rates.append(here.jacobian @ v + here.drift)
    return np.array(gap_rates)


def unit_of(name: str, answer: np.ndarray, d: np.ndarray, mass: float) -> Any:
    """Return the factors that make the entries of an answer comparable, for its shape (n, size).

    Shapes: answer (n, …), d (n, nv), mass [kg].
    """
    match name:
        case "rhs":
            rates = answer.shape[1] - d.shape[1]
            return np.hstack([np.full((len(d), rates), np.sqrt(mass)), d])
        case "acceleration":
            return d
        case "mass_matrix":
            return (1 / (d[:, :, None] * d[:, None, :])).reshape(len(d), -1)
        case "bias" | "forces" | "gravity" | "inverse_dynamics":
            return 1 / d
    return np.ones((len(d), int(np.prod(answer.shape[1:]))))


def _compute_multipliers(reference: Reference, states: States, tau: np.ndarray) -> np.ndarray:
    """Return λ from M a + bias − forces − τ = Jᵀ λ."""
    J = np.asarray(reference.constraint_jacobian(states.q, states.t))
    a = answer_of("acceleration", reference, states, tau)
    M = answer_of("mass_matrix", reference, states, tau)
    rest = answer_of("bias", reference, states, tau) - tau
    rest = rest - answer_of("forces", reference, states, tau)
    multipliers = []
    for k in range(len(states)):
        solved = np.linalg.lstsq(J[k].T, M[k] @ a[k] + rest[k], rcond=None)
        if solved[2] < len(J[k]):
            raise DerivationError(
                f"constraints of mechanism {reference.mechanism.name!r} are redundant, which "
                "leaves their multipliers undetermined"
            )
        multipliers.append(solved[0])
    return np.array(multipliers)


DIFFERENCES = 1e-6
"""Largest relative difference that counts as agreement, given the error of this method."""

_STEP = 1e-3
"""Step along a coordinate or a velocity, and relative step of a torque or a parameter."""


def differences(
    quantity: Output, program: Program, reference: Reference, states: States, tau: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return derivatives, shape (n, …, directions), and which directions are compared, 1 or 0.

    Derivatives by signals are not compared, as they are not inputs of Pinocchio, nor those of
    reactions by tau that acts in no joint with one coordinate, which the reference refuses.

    Shapes: tau (n, nv).
    """
    columns: list[np.ndarray] = []
    compared: list[float] = []
    for move, scale in _list_moves(quantity, program, reference, states, tau):
        size = _STEP * scale
        total = 0.0 * answer_of(quantity.base, *move(0.0))
        for k, weight in enumerate(WEIGHTS if scale else (), 1):
            ahead, behind = (answer_of(quantity.base, *move(sign * k * size)) for sign in (1, -1))
            total = total + weight * (ahead - behind) / size
        columns.append(total)
        compared.append(float(scale > 0))
    return np.stack(columns, axis=-1), np.array(compared)


_Move = Callable[[float], tuple[Reference, States, np.ndarray]]


def _list_moves(
    quantity: Output, program: Program, reference: Reference, states: States, tau: np.ndarray
) -> list[tuple[_Move, float]]:
    """Return the displacement along each direction, with its scale; zero if it is not compared."""
    mechanism, unit = reference.mechanism, np.eye(reference.mechanism.nv)

    def along(kind: str, k: int) -> _Move:
        if kind == "tau":
            return lambda step: (reference, states, tau + step * unit[k])
        ahead: Any = unit[k]
        if kind == "q":
            ahead = np.asarray(reference.rates(states.q, np.broadcast_to(ahead, states.v.shape)))

        def move(step: float) -> tuple[Reference, States, np.ndarray]:
            moved = getattr(states, kind) + step * ahead
            if kind == "q":
                mechanism.normalize(moved)
            return reference, replace(states, **{kind: moved}), tau

        return move

    def along_parameter(symbol: str) -> _Move:
        def move(step: float) -> tuple[Reference, States, np.ndarray]:
            if not step:
                return reference, states, tau
            varied = mechanism.replace(**{symbol: mechanism.values[symbol] + step})
            return Reference(varied), replace(states, mechanism=varied), tau

        return move

    if quantity.by == "p":
        values = [mechanism.values.get(p.name) for p in program.parameters]
        sizes = [0.0 if value is None else abs(value) or 1.0 for value in values]
        moves = [along_parameter(p.name) for p in program.parameters]
        return list(zip(moves, sizes, strict=True))
    known = np.ones(mechanism.nv)
    if quantity.by == "tau" and quantity.base == "reactions":
        known = 1.0 * _has_seat(mechanism)
    kinds = {"y": ("q", "v")}.get(quantity.by, (quantity.by,))
    return [(along(kind, k), scale) for kind in kinds for k, scale in enumerate(known.tolist())]


def start_of(mechanism: Mechanism, q: Given, v: Given) -> tuple[float, ...]:
    """Return initial coordinates with closed loops, and velocities."""
    return (*assemble(mechanism, q).tolist(), *mechanism.velocity(v).tolist())


CODE_ALIKE = 1e-13
"""Largest relative difference that counts as agreement, unless rounding allows more."""

_VARIATIONS = 5
_CHANGE = 0.1

_SMALL = 1e-3
"""Answers below this part of the typical size are compared with the typical size."""

_LEAST = {
    **dict.fromkeys(("mass_matrix", "poses", "jacobians", "closure"), 0.0),
    **dict.fromkeys(("energy", "reactions"), 1.0),
}
"""The typical size of a quantity at 1 m/s or 1 m/s², as a power of the moving mass."""


def cases_of(program: Program, samples: int, seed: int) -> Cases:
    """Return states with Pinocchio's values there."""
    parts = [
        _compute_cases(program, mechanism, number, seed + k)
        for k, (mechanism, number) in enumerate(_vary(program, samples, seed))
    ]
    return reduce(Cases.join, parts)


def count_varied(program: Program, cases: Cases) -> int:
    """Return the number of states with parameters other than the mechanism's."""
    defaults = np.array([program.mechanism.values.get(p.name, np.nan) for p in program.parameters])
    same = (cases.inputs["p"] == defaults) | np.isnan(defaults)
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
            variant = mechanism.replace(**values)
            Reference.of(variant)
        except MecaniqueError:
            continue
        varied.append(variant)
    yield mechanism, samples - number * len(varied)
    for variant in varied:
        yield variant, number


def _compute_cases(program: Program, mechanism: Mechanism, samples: int, seed: int) -> Cases:
    reference = Reference.of(mechanism)
    states = random_states(mechanism, samples, seed)
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
        # loops far from the origin are closed to the rounding of where they are: both answers vary
        gap = np.abs(reference.constraint_residual(q, t)).max(initial=0.0)
        opening = np.full(samples, gap / characteristic_length(mechanism))

        def ask(near: States) -> dict[str, np.ndarray]:
            return {"acceleration": reference.acceleration(near.q, v, t, tau=tau)}

        noise = measure_noise(ask, M, states, opening)
        excused["acceleration"] = np.maximum(excused["acceleration"], 2 * noise["acceleration"])
    expected: dict[str, np.ndarray] = {}
    weights: dict[str, np.ndarray] = {}
    allowed: dict[str, np.ndarray] = {}
    mass = moving_mass(mechanism)
    for answer in program.answers:
        quantity = answer.quantity
        name, base = quantity.name, quantity.base or quantity.name
        if program.switching:
            whole = replace(mechanism, switching=program.switching)
            if quantity.mode:
                mode = dict(quantity.mode)
                values, lost = solve_mode(whole, mode, states, struck=quantity.struck)
                forces = np.full((samples, values.shape[1] - d.shape[1]), mass**-0.5)
                unit = np.hstack([d, forces])
                excused[name] = lost / mass**0.5
            else:
                values = measure_elements(whole, states)
                unit = np.ones(values.shape)
        elif quantity.by:
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
        allowed[name] = np.maximum(DIFFERENCES if quantity.by else CODE_ALIKE, rounded)
    p = np.empty((samples, len(program.parameters)))
    for k, letter in enumerate(program.parameters):
        p[:, k] = states.values[letter.name]
    inputs = {"t": t[:, None], "q": q, "v": v, "a": states.a, "tau": tau, "p": p}
    return Cases(inputs, expected, weights, allowed)


def _has_seat(mechanism: Mechanism) -> np.ndarray:
    """Return whether Pinocchio's side knows where tau on each velocity acts, shape (nv,)."""
    seated = seated_velocities(mechanism)
    return np.array([name in seated for name in mechanism.velocities])


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


@final
@dataclass(frozen=True)
class CodeVerdict:
    """The result of comparing code with Pinocchio."""

    samples: int  # number of states in which it was compared
    seed: int  # of the random states
    # largest relative difference that counts as agreement, unless rounding allows more
    tolerance: float
    worst: dict[str, float]  # worst relative difference of each quantity, by name
    # largest difference that rounding excuses in some state, by name; 0 if the tolerance was enough
    # everywhere
    rounded: dict[str, float]
    versions: dict[str, str]  # versions of the tools involved, by name
    varied: int = 0  # number of states with parameters other than the mechanism's

    def lines(self) -> list[str]:
        """Return the verdict in sentences, for the head of a file."""
        by = ", ".join(f"{name} {version}" for name, version in self.versions.items())
        missing = self.versions.get("pin") == NOT_INSTALLED
        engine = "a stand-in for Pinocchio" if missing else "Pinocchio"
        varied = f", {self.varied} of them with other parameters" if self.varied else ""
        lines = [
            f"Run and compared with {engine} at {self.samples} random states "
            f"(seed {self.seed}){varied}:"
        ]
        for name, worst in self.worst.items():
            excused = self.rounded.get(name, 0.0)
            beyond = (
                f"; rounding allows {excused:.1e}" if excused and worst > self.tolerance else ""
            )
            lines.append(f"  {name}: worst relative difference {worst:.1e}{beyond}")
        return [*lines, f"With {by}."]

    def __str__(self) -> str:
        return "\n".join(self.lines())


def judge(program: Program, target: Target, cases: Cases, seed: int) -> CodeVerdict:
    """Run the test of a program."""
    with TemporaryDirectory() as folder:
        directory = Path(folder)
        files = {**target.files(program, ["unjudged"]), **target.test_files(program, cases)}
        for name, content in files.items():
            (directory / name).write_bytes(as_bytes(content))
        done = None
        for command in target.commands(program, directory):
            try:
                done = run_command(command)
            except OSError as error:  # in a browser there are no processes
                raise EngineError(
                    "code is compared in a process of its own before it is handed out, and none "
                    f"can be started here ({error}); generate it where Python runs by itself"
                ) from error
            if done.returncode and not done.stdout:
                raise DerivationError(
                    f"the {target.title} of {program.mechanism.name!r} does not run: "
                    f"{done.stderr.strip()[:2000]}"
                )
    assert done is not None, "every language has a command"
    worst = {name: float(number) for name, number, _ in map(str.split, done.stdout.splitlines())}
    if done.returncode:
        raise DerivationError(
            f"the {target.title} of {program.mechanism.name!r} and the reference disagree: "
            f"{'; '.join(done.stderr.splitlines()[:3])}"
        )
    return CodeVerdict(
        samples=len(cases),
        seed=seed,
        tolerance=CODE_ALIKE,
        worst=worst,
        rounded={name: float(np.max(rows, initial=0.0)) for name, rows in cases.allowed.items()},
        versions={**versions(), "run by": target.version()},
        varied=count_varied(program, cases),
    )
