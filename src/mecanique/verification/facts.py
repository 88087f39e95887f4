"""Check the closed-form facts of a textbook system, kind by kind.

Facts about any state are compared at random states, conserved quantities by their rate along the
flow (complex step), motions by integration at the tightest tolerance, frequencies and limits of
stability by differences of eighth order.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, final

import numpy as np

from mecanique.arrays import Array
from mecanique.errors import ClosureError, EngineError, InputError, IntegrationError
from mecanique.model import CentralForce, Mechanism
from mecanique.textbook.catalogue import entry
from mecanique.textbook.facts import (
    Acceleration,
    Conserved,
    Eigenvalues,
    Fact,
    Frequencies,
    GuideForce,
    KineticEnergy,
    Lasting,
    MassMatrix,
    ModeAcceleration,
    Occurs,
    Period,
    Reaction,
    Solution,
    StabilityLimit,
    State,
    Steady,
    Values,
)
from mecanique.textbook.system import System
from mecanique.verification.states import random_states
from mecanique.verification.stencil import differences

if TYPE_CHECKING:
    from mecanique.derivation.equations import Equations
    from mecanique.derivation.symbolic.derivation import Assumption
    from mecanique.reference import Reference


_STEP = 1e-2
"""Step of the differences, relative to coordinates larger than one."""


@final
@dataclass(frozen=True)
class Bench:
    """A system with certain parameters and its equations of motion."""

    system: System  # of the catalogue, or of your own
    values: Mapping[str, float]  # parameters and options that are changed, by symbol
    source: str  # whose equations of motion are used, "reference" or "derive"
    samples: int  # number of random states
    seed: int  # of the random states
    simulate: Callable[..., Any] | None = None  # makes motions

    @cached_property
    def mechanism(self) -> Mechanism:
        """The system with these parameters."""
        return self.system.mechanism(**self.values)

    @cached_property
    def smooth(self) -> Mechanism:
        """The same without what switches."""
        return replace(self.mechanism, switching=()) if self.mechanism.switching else self.mechanism

    @cached_property
    def reference(self) -> Reference:
        """The engine's side of it, loaded once."""
        from mecanique.reference import Reference

        return Reference.of(self.smooth)

    @cached_property
    def dynamics(self) -> Reference | Equations:
        """The equations of motion that the facts are held against."""
        if self.source == "reference":
            return self.reference
        from mecanique.derivation import derive

        return derive(self.smooth)

    @cached_property
    def motion(self) -> Any:
        """The default motion."""
        assert self.simulate is not None, "facts of motions are left out without it"
        return self.simulate(
            self.mechanism,
            q=dict(self.system.start),
            v=dict(self.system.start_velocity),
            duration=self.system.duration,
            rtol=1e-13,
        )

    @cached_property
    def constants(self) -> dict[str, Any]:
        """Numbers of its parameters and options, by symbol."""
        options = {
            name: int(self.values.get(name, number)) for name, number in self.system.options.items()
        }
        return {**self.mechanism.values, **options}

    def numbers(self, q: Any, v: Any, t: Any = 0.0) -> Values:
        """Return constants and state by name, as formulas ask for them."""
        names = (*self.mechanism.coordinates, *self.mechanism.velocities, "t")
        return Values({**self.constants, **dict(zip(names, (*q, *v, t), strict=True))})

    def state(self, given: State) -> tuple[Array, Array]:
        """Return positions and velocities of a state that a fact names."""
        named = given(Values(self.constants)) if callable(given) else given
        positions = {
            name: x for name, x in named.items() if name in set(self.mechanism.coordinates)
        }
        velocities = {name: x for name, x in named.items() if name not in positions}
        if not np.isfinite(list(named.values())).all():
            raise ArithmeticError("its state is not defined")
        return self.close(self.mechanism.position(positions), self.mechanism.velocity(velocities))

    def close(self, q: Array, v: Array) -> tuple[Array, Array]:
        """Return the state next to this one at which the loops are closed."""
        closed = self.reference.closed if self.mechanism.constrained else None
        if closed is None:
            return q, v
        from mecanique.reference.loops.assembly import close_position, project

        return project(closed, close_position(closed, q, 0.0), v, 0.0)

    @cached_property
    def states(self) -> tuple[tuple[Array, Array, float], ...]:
        """The better half of twice as many random states: singular ones lose digits."""
        states = random_states(self.smooth, 2 * self.samples, self.seed, self._assumptions)
        worth = [
            np.linalg.cond(self.dynamics.mass_matrix(q, float(t)))
            for q, t in zip(states.q, states.t, strict=True)
        ]
        better = np.argsort(worth)[: self.samples]
        return tuple((states.q[k], states.v[k], float(states.t[k])) for k in better)

    @property
    def _assumptions(self) -> tuple[Assumption, ...]:
        """What the closed form takes for granted of distances, and so do the facts."""
        if not any(isinstance(force, CentralForce) for force in self.mechanism.forces):
            return ()
        from mecanique.derivation import derive

        return derive(self.smooth).derivation.assumptions

    def aside(self, q: Array, v: Array) -> Array:
        """Return the accelerations also where loops are open, next to where they are closed."""
        closed = self.reference.closed
        if closed is None or self.source != "reference":
            return np.asarray(self.dynamics.acceleration(q, v, 0.0))
        return np.asarray(closed.solve(q, v, 0.0).acceleration)

    def slope(self, t: float, y: Array) -> Array:
        """Return the rates of [q, v]."""
        q, v = y[: self.mechanism.nq], y[self.mechanism.nq :]
        return np.concatenate((self.reference.rates(q, v), self.dynamics.acceleration(q, v, t)))

    def flow(self, q: Array, v: Array, times: Any) -> Array:
        """Return the states [q, v] at the times, shape (n, nq + nv)."""
        from scipy.integrate import solve_ivp

        slope = self.reference.rhs() if self.source == "reference" else self.slope
        solution = solve_ivp(
            slope,
            (0.0, float(times[-1])),
            np.concatenate((q, v)),
            method="DOP853",
            t_eval=np.asarray(times, dtype=float),
            rtol=3e-14,
            atol=1e-14,
        )
        if not solution.success:
            raise IntegrationError(f"no motion up to t = {times[-1]:g} s: {solution.message}")
        return np.asarray(solution.y.T)

    def stiffness(self, at: State) -> tuple[Array, Array]:
        """Return M and K of small motion about an equilibrium."""
        q, _ = self.state(at)
        rest = np.zeros(self.mechanism.nv)

        def static_forces(x: Array) -> Array:
            return self.dynamics.bias(x, rest, 0.0) - self.dynamics.forces(x, rest, 0.0)

        K = jacobian(static_forces, q)
        return np.asarray(self.dynamics.mass_matrix(q, 0.0)), K

    def squares(self, at: State) -> Array:
        """Return ω² of small motion about an equilibrium, in order, shape (nv,) [rad²/s²]."""
        eigenvalues: Array = np.sort(np.linalg.eigvals(np.linalg.solve(*self.stiffness(at))).real)
        return eigenvalues


def jacobian(function: Callable[[Array], Any], at: Array) -> Array:
    """Return the derivative of a function, shape (m, n)."""
    return differences(
        lambda steps: np.array([function(at + step) for step in steps]),
        len(at),
        _STEP * np.maximum(1.0, np.abs(at)),
    )


FACT_HOLDS = 1e-10
"""Largest residual of a fact that holds."""

SOURCES = ("reference", "derive")
"""Whose equations of motion the facts can be checked against."""

_ASIDE = 0.01
"""Distance from a limit of stability, relative to it, at which both of its sides are examined."""

_IMAGINARY_STEP = 1e-30
"""A complex step has no difference of nearby values in it, so it can be as small as this."""


@final
@dataclass(frozen=True)
class FactRow:
    """One fact and how well it holds."""

    system: str  # name of the textbook system; its title if it is not in the catalogue
    kind: str  # of the fact, e.g. "Period"
    statement: str  # the fact in one line
    # relative difference between the fact and the equations of motion; not a number if the fact
    # has no value for the given parameters
    residual: float
    reason: str = ""  # why it has none

    @property
    def holds(self) -> bool:
        """Whether the residual is at most 1e-10."""
        return self.residual <= FACT_HOLDS

    @property
    def fails(self) -> bool:
        """Whether the fact is false; one that has no value for the given parameters is not."""
        return not self.holds and not math.isnan(self.residual)

    def to_dict(self) -> dict[str, Any]:
        """Return everything as plain data, ready for JSON; None if the residual is not finite."""
        return {
            "kind": self.kind,
            "statement": self.statement,
            "holds": self.holds,
            "fails": self.fails,
            "residual": self.residual if math.isfinite(self.residual) else None,
            "reason": self.reason,
        }

    def __str__(self) -> str:
        kind = re.sub("(?<=[a-z])(?=[A-Z])", " ", self.kind).lower()
        if math.isnan(self.residual):
            return f"fact has no value here ({self.reason}), {kind}: {self.statement}"
        holds = "holds" if self.holds else "FAILS"
        return f"fact {holds} ({self.residual:.0e}), {kind}: {self.statement}"


def check_facts(
    name: str | System,
    values: Mapping[str, float] | None = None,
    *,
    source: str = "reference",
    samples: int = 20,
    seed: int = 0,
    simulate: Callable[..., Any] | None = None,
) -> tuple[FactRow, ...]:
    """Check every fact of a textbook system; those of its motion only with `mq.simulate`."""
    if source not in SOURCES:
        raise InputError(f"expected a source among {', '.join(SOURCES)}, got {source!r}")

    system = name if isinstance(name, System) else entry(name)

    benches: dict[frozenset[tuple[str, float]], Bench] = {}

    def build(given: Mapping[str, float]) -> Bench:
        """Facts that suppose the same parameters are asked of one bench."""
        named = frozenset(given.items())
        if named not in benches:
            changed = {**(values or {}), **given}
            benches[named] = Bench(system, changed, source, samples, seed, simulate)
        return benches[named]

    system.mechanism(**(values or {}))  # refuses unknown parameters even where no fact needs them
    called = system.title if isinstance(name, System) else name
    known = [f for f in system.facts if simulate or not isinstance(f, (Occurs, Lasting))]
    return tuple(_row(called, fact, build(fact.given)) for fact in known)


def _row(system: str, fact: Fact, bench: Bench) -> FactRow:
    residual, reason = math.nan, "its formula is not defined"
    try:
        with np.errstate(all="ignore"):
            residual = _RESIDUALS[type(fact)](bench, fact)
    except InputError:
        raise
    except (ArithmeticError, ValueError, ClosureError, EngineError, IntegrationError) as error:
        reason = str(error)
    undefined = math.isnan(residual)
    return FactRow(
        system, type(fact).__name__, fact.statement, residual, reason if undefined else ""
    )


def _in_mode(bench: Bench, fact: ModeAcceleration) -> float:
    from mecanique.verification.modes import solve_mode

    states = random_states(bench.smooth, bench.samples, bench.seed)
    names = [element.name for element in bench.mechanism.switching]
    mode = dict(zip(names, fact.states, strict=True))
    computed = solve_mode(bench.mechanism, mode, states)[0][:, : bench.mechanism.nv]
    expected = [
        fact.formula(bench.numbers(q, v, t))
        for q, v, t in zip(states.q, states.v, states.t.tolist(), strict=True)
    ]
    return _relative(computed, expected)


def _at_event(bench: Bench, fact: Occurs) -> float:
    """Return the largest relative difference of what is stated of an event."""
    motion = bench.motion
    if fact.event == "end":
        t, q, v, after = motion.t[-1], motion.q[-1], motion.v[-1], motion.v[-1]
    else:
        events = [event for event in motion.events if event.name == fact.event]
        if len(events) <= fact.which:
            raise ArithmeticError(f"{fact.event!r} happens {len(events)} times")
        event = events[fact.which]
        t, q, v, after = event.t, event.q, event.v, event.after
    numbers = bench.numbers(q, v, float(t))
    speeds = bench.mechanism.velocities
    known = {**numbers.numbers, **{f"after {k}": x for k, x in zip(speeds, after, strict=True)}}
    stated = fact.formula(numbers)
    # what is zero but for rounding has the scale of the others
    largest = max(map(abs, stated.values()))
    return float(
        max(abs(known[name] - x) / (abs(x) or largest or 1.0) for name, x in stated.items())
    )


def _last(bench: Bench, fact: Lasting) -> float:
    motion = bench.motion
    states = zip(motion.q, motion.v, motion.t.tolist(), strict=True)
    values = [np.atleast_1d(fact.formula(bench.numbers(*state))) for state in states]
    return float(np.max(np.abs(np.array(values) - values[0])) / np.max(np.abs(values[0])))


def _relative(value: Any, expected: Any) -> float:
    """Return the largest difference of each component, relative to its size; shape (n, …) both."""
    value, expected = np.asarray(value, dtype=float), np.asarray(expected, dtype=float)
    scale = np.max(np.abs(expected), axis=0)
    # a component that is zero except for rounding has no scale of its own
    scale = np.where(scale > 1e-9 * np.max(scale), scale, np.max(scale) or 1.0)
    return float(np.max(np.abs(value - expected) / scale))


def _at_states(
    bench: Bench, formula: Callable[[Values], Any], engine: Callable[[Array, Array, float], Any]
) -> float:
    expected = [
        np.asarray(formula(bench.numbers(q, v, t)), dtype=float) for q, v, t in bench.states
    ]
    return _relative([engine(q, v, t) for q, v, t in bench.states], expected)


def _mass_matrix(bench: Bench, fact: MassMatrix) -> float:
    differences = []
    for q, v, t in bench.states:
        expected = np.asarray(fact.formula(bench.numbers(q, v, t)), dtype=float)
        size = np.sqrt(np.diag(expected))
        computed = bench.dynamics.mass_matrix(q, t)
        differences.append(np.abs(computed - expected) / np.multiply.outer(size, size))
    return float(np.max(differences))


def _drift(bench: Bench, fact: Conserved) -> float:
    """Return the rates along the flow, relative to the sum of what q, v and t contribute."""
    nq, rates, sizes, depends = bench.mechanism.nq, [], [], False
    for q, v, t in bench.states:
        at = np.concatenate((q, v, [t])).astype(complex)
        parts = []
        for k, slope in enumerate(np.append(bench.slope(t, np.concatenate((q, v))), 1.0)):
            moved = at.copy()
            moved[k] += _IMAGINARY_STEP * 1j
            value = np.atleast_1d(fact.formula(bench.numbers(moved[:nq], moved[nq:-1], moved[-1])))
            # all are relative to one another, so the step is not divided out
            parts.append(np.imag(value) * slope)
            depends |= bool(np.any(np.imag(value)))
        rates.append(np.abs(np.sum(parts, axis=0)))
        sizes.append(np.sum(np.abs(parts), axis=0))
    if not depends:
        return math.inf  # a number is no quantity
    size = np.max(sizes, axis=0)
    return float(np.max(np.max(rates, axis=0) / np.where(size > 0, size, 1.0)))


def _solution(bench: Bench, fact: Solution) -> float:
    q, v = bench.state(fact.start)
    times = np.linspace(0.0, float(fact.until(Values(bench.constants))), 8)
    names = (*bench.mechanism.coordinates, *bench.mechanism.velocities)
    stated = [fact.formula(Values({**bench.constants, "t": float(t)})) for t in times]
    columns = [names.index(name) for name in stated[0]]
    return _relative(
        bench.flow(q, v, times)[:, columns], [list(state.values()) for state in stated]
    )


def _period(bench: Bench, fact: Period) -> float:
    q, v = bench.state(fact.start)
    onwards = np.concatenate(bench.state(fact.advance))
    T = float(fact.seconds(Values(bench.constants)))
    way = bench.flow(q, v, np.array([0, 1 / 4, 1 / 3, 1 / 2, 2 / 3, 3 / 4, 1]) * T)
    size = np.max(np.abs(way), axis=0)
    off = np.abs(way[1:] - way[0] - onwards) / np.where(size > 0, size, 1.0)
    # a multiple of the period is not the period
    return math.inf if np.min(np.max(off[:-1], axis=1)) < 1e-3 else float(np.max(off[-1]))


def _frequencies(bench: Bench, fact: Frequencies) -> float:
    M, squares = bench.stiffness(fact.at)[0], bench.squares(fact.at)
    stated = np.asarray(fact.formula(bench.numbers(*bench.state(fact.at))), dtype=float)
    expected = np.sort(stated**2)
    difference = float(np.max(np.abs(squares - expected)) / np.max(expected))
    # the rounding of a long chain's M grows with the square of its size
    rounding = float(np.finfo(float).eps * len(M) ** 2 * np.linalg.cond(M))
    return difference if rounding < FACT_HOLDS else max(0.0, difference - rounding)


def _eigenvalues(bench: Bench, fact: Eigenvalues) -> float:
    # deviations of [q, v] from an equilibrium or a steady motion
    q, v = bench.state(fact.at)
    if len(q) != len(v):
        raise InputError(
            f"expected a system without quaternions for eigenvalues, got {bench.mechanism.name!r}"
        )
    n = len(q)
    lower = jacobian(lambda y: bench.aside(y[:n], y[n:]), np.concatenate((q, v)))
    computed = np.linalg.eigvals(np.block([[np.zeros((n, n)), np.eye(n)], [lower]]))
    stated = np.asarray(fact.formula(bench.numbers(*bench.state(fact.at))), dtype=complex)
    nearest = np.min(np.abs(np.subtract.outer(stated, computed)), axis=1)
    return float(np.max(nearest) / np.max(np.abs(stated)))


def _steady(bench: Bench, fact: Steady) -> float:
    """Return the acceleration relative to that at a state nearby."""
    q, v = bench.state(fact.at)
    quaternions = [k for _, at in bench.mechanism.quaternions for k in at]
    aside = q + 0.1
    aside[quaternions] = q[quaternions]
    aside, faster = bench.close(aside, v + 0.1 * (np.max(np.abs(v)) or 1.0))
    typical = np.max(np.abs(bench.dynamics.acceleration(aside, faster, 0.0)))
    return float(np.max(np.abs(bench.dynamics.acceleration(q, v, 0.0))) / (typical or 1.0))


def _limit(bench: Bench, fact: StabilityLimit) -> float:
    value = float(fact.formula(Values(bench.constants)))
    below, at, above = (
        _margin(replace(bench, values={**bench.values, fact.parameter: value * factor}), fact)
        for factor in (1 - _ASIDE, 1, 1 + _ASIDE)
    )
    stable, unstable = (below, above) if fact.stable == "below" else (above, below)
    if not stable > 0 > unstable:
        return math.inf
    return abs(at) / (abs(above - below) / (2 * _ASIDE))


def _margin(bench: Bench, fact: StabilityLimit) -> float:
    """Return a number that is positive where the equilibrium is stable, and zero at the limit."""
    if fact.period is None:
        return float(bench.squares(fact.at)[0])
    q, v = bench.state(fact.at)
    n, T = len(q), float(fact.period(Values(bench.constants)))
    turn = jacobian(lambda y: bench.flow(y[:n], y[n:], [0.0, T])[-1], np.concatenate((q, v)))
    # Floquet: det(turn − 1) passes through zero where a multiplier passes through one
    return float(np.linalg.det(turn - np.eye(2 * n)))


def _reaction(bench: Bench, fact: Reaction) -> float:
    """Compare the force in a joint; in all, where something not described guides across it."""
    reference = bench.reference
    ask = reference.totals if fact.joint in reference.guided else reference.reactions
    return _at_states(bench, fact.formula, lambda q, v, t: ask(q, v, t)[fact.joint].force)


def _guide_force(bench: Bench, fact: GuideForce) -> float:
    ask = bench.reference.guide_forces
    return _at_states(bench, fact.formula, lambda q, v, t: ask(q, v, t)[fact.force])


_RESIDUALS: dict[type, Callable[[Bench, Any], float]] = {
    Acceleration: lambda bench, fact: _at_states(bench, fact.formula, bench.dynamics.acceleration),
    MassMatrix: _mass_matrix,
    KineticEnergy: lambda bench, fact: _at_states(
        bench, fact.formula, lambda q, v, t: bench.dynamics.energy(q, v, t)[0]
    ),
    Reaction: _reaction,
    GuideForce: _guide_force,
    Conserved: _drift,
    Solution: _solution,
    Period: _period,
    Frequencies: _frequencies,
    Eigenvalues: _eigenvalues,
    Steady: _steady,
    StabilityLimit: _limit,
    ModeAcceleration: _in_mode,
    Occurs: _at_event,
    Lasting: _last,
}
"""What tells how far each kind of fact is from the equations of motion."""
