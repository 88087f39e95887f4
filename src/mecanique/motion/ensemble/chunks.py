"""A chunk of many runs: pickled to any process, integrated there, and sent back."""

from __future__ import annotations

import copy
import os
import pickle
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import pairwise
from typing import Any, TypeVar, final

import numpy as np

from mecanique.errors import MecaniqueError
from mecanique.model.mechanism import Mechanism
from mecanique.motion.compile.derive import program_of
from mecanique.motion.compile.heyoka import integrator, lanes
from mecanique.motion.compile.program import RatesProgram
from mecanique.motion.compile.python import Batched, vectorize
from mecanique.motion.compile.stepper import ENDED, Stepper, Tolerances
from mecanique.motion.ensemble.dop853 import Block, integrate
from mecanique.motion.record.loops import ClosedLoops, begin_on_loops
from mecanique.motion.record.rates import Rates
from mecanique.motion.simulation.problem import kinks, longest_step

FEWEST = 500
"""Fewest runs for which a thread pays."""


@final
@dataclass(frozen=True, eq=False)
class Part:
    """Runs that are integrated as one piece."""

    first: int  # index of its first run
    mechanism: bytes
    q: np.ndarray  # shape (n, nq), positions at the start
    v: np.ndarray  # shape (n, nv), velocities at the start
    # values of the parameters that differ from run to run, shape (n,) each, by symbol
    parameters: Mapping[str, np.ndarray]
    times: np.ndarray  # of the samples, the first is the start, shape (m,) [s]
    method: str  # "batch", "taylor", "compiled" or "single"
    rtol: float
    atol: float
    max_steps: int  # most steps of a run
    threads: int = 1  # how many threads it may use

    def __len__(self) -> int:
        return len(self.q)

    def take(self, some: slice | list[int]) -> Part:
        """Return some of its runs."""
        return replace(
            self,
            first=some.start if isinstance(some, slice) else some[0],
            q=self.q[some],
            v=self.v[some],
            parameters={symbol: values[some] for symbol, values in self.parameters.items()},
        )


@final
@dataclass(frozen=True, eq=False)
class Chunk:
    """The results of a part."""

    first: int  # index of its first run
    q: np.ndarray  # shape (n, m, nq), positions; not a number after a run has failed
    v: np.ndarray  # shape (n, m, nv), velocities
    steps: np.ndarray  # shape (n,), number of steps; negative for runs that failed


def run_part(part: Part) -> Chunk:
    """Integrate the runs of a part."""
    mechanism, nq = _mechanism(part.mechanism), part.q.shape[1]
    integrate_all: dict[str, Callable[[Part, Mechanism], tuple[np.ndarray, np.ndarray]]] = {
        "batch": _batch,
        "taylor": _taylor,
        "compiled": _integrate_in_c,
        "single": _single,
    }
    states, steps = integrate_all[part.method](part, mechanism)
    q = Rates.of(mechanism).normalize(states[:, :, :nq])
    return Chunk(part.first, q, states[:, :, nq:], steps)


@lru_cache(maxsize=4)
def _mechanism(pickled: bytes) -> Mechanism:
    mechanism: Mechanism = pickle.loads(pickled)
    return mechanism


@lru_cache(maxsize=4)
def _program(pickled: bytes, swept: tuple[str, ...]) -> RatesProgram:
    return program_of(_mechanism(pickled), swept)


def _start(part: Part) -> np.ndarray:
    return np.hstack([part.q, part.v])


def _batch(part: Part, mechanism: Mechanism) -> tuple[np.ndarray, np.ndarray]:
    program = _program(part.mechanism, tuple(part.parameters))
    values = [part.parameters[symbol] for symbol in program.open]
    rates, nq = Rates.of(mechanism), part.q.shape[1]

    def normalize(states: np.ndarray) -> np.ndarray:
        states[:nq] = rates.normalize(states[:nq].T).T
        return states

    begin, end = float(part.times[0]), float(part.times[-1])
    longest, stops = longest_step(mechanism, end - begin, None, ()), kinks(mechanism, begin, end)
    start = _start(part).T

    def work(low: int, high: int) -> tuple[np.ndarray, np.ndarray]:
        def make(some: np.ndarray) -> Batched:
            return vectorize(program, [value[low + some] for value in values])

        block = Block(
            make,
            np.ascontiguousarray(start[:, low:high]),
            normalize if rates.balls else None,
            part.rtol,
            part.atol,
            longest,
            part.max_steps,
        )
        return integrate(block, part.times.tolist(), stops)

    # numpy lets other threads run while it computes, but small arrays do not pay for them
    threads = max(1, min(part.threads, len(part) // FEWEST))
    pieces = _share_out(work, [len(part) * k // threads for k in range(threads + 1)])
    states = np.concatenate([piece for piece, _ in pieces], axis=2)
    return np.moveaxis(states, -1, 0).swapaxes(1, 2), np.concatenate([steps for _, steps in pieces])


_Piece = TypeVar("_Piece")


def _share_out(work: Callable[[int, int], _Piece], bounds: Sequence[int]) -> list[_Piece]:
    """Let a thread work from each bound to the next; a single one here."""
    pairs = list(pairwise(bounds))
    if len(pairs) == 1:
        return [work(*pairs[0])]
    with ThreadPoolExecutor(len(pairs)) as pool:
        return list(pool.map(lambda pair: work(*pair), pairs))


_integrators: dict[Any, Any] = {}


def _taylor(part: Part, mechanism: Mechanism) -> tuple[np.ndarray, np.ndarray]:
    width = lanes()
    program = _program(part.mechanism, tuple(part.parameters))
    key = part.mechanism, program.open, part.rtol, width
    if key not in _integrators:
        _integrators.clear()  # compiled code is large; one kind of runs at a time is enough
        _integrators[key] = integrator(program, part.rtol, width)
    original = _integrators[key]
    start = _start(part)
    states: np.ndarray = np.full((len(part), len(part.times), start.shape[1]), np.nan)
    steps = np.zeros(len(part), dtype=int)
    values = np.array([part.parameters[symbol] for symbol in program.open]).reshape(
        len(program.open), len(part)
    )

    def work(low: int, high: int) -> None:
        machine = copy.deepcopy(original)
        for first in range(low, high, width):
            # the last lanes may be idle: they repeat the last run
            runs = np.minimum(np.arange(first, first + width), len(part) - 1)
            inside = min(width, high - first)
            machine.set_time(float(part.times[0]))
            machine.state[:] = start[runs].T
            if len(values):
                machine.pars[:] = values[:, runs]
            states[runs[:inside], 0] = start[runs[:inside]]
            taken = np.zeros(width, dtype=int)
            whole = np.ones(width, dtype=bool)
            for place, t in enumerate(part.times[1:].tolist(), 1):
                machine.propagate_until(t, max_steps=part.max_steps)
                outcomes = machine.propagate_res
                taken += [result[3] for result in outcomes]
                whole &= [result[0].name == "time_limit" for result in outcomes]
                whole &= np.isfinite(machine.state).all(axis=0) & (taken <= part.max_steps)
                states[runs[:inside], place] = np.where(whole, machine.state, np.nan).T[:inside]
                if not whole.any():
                    break
            steps[runs[:inside]] = np.where(whole, taken, -taken - 1)[:inside]

    threads = max(1, min(part.threads, -(-len(part) // width)))
    bounds = [len(part) * k // threads // width * width for k in range(threads)] + [len(part)]
    _share_out(work, bounds)
    return states, steps


@lru_cache(maxsize=4)
def _stepper(pickled: bytes, swept: tuple[str, ...]) -> Stepper:
    return Stepper(_program(pickled, swept))


def _integrate_in_c(part: Part, mechanism: Mechanism) -> tuple[np.ndarray, np.ndarray]:
    """Integrate in C; what comes near a singular position, or else stops early, by `simulate`."""
    symbols = tuple(part.parameters)
    stepper, opened = _stepper(part.mechanism, symbols), _program(part.mechanism, symbols).open
    starts, closed = _close_starts(part, mechanism)
    values = np.array([part.parameters[symbol] for symbol in opened]).reshape(
        len(opened), len(part)
    )
    span = float(part.times[-1] - part.times[0])
    longest = longest_step(mechanism, span, None, ())
    share = ClosedLoops.share if mechanism.constrained else 1.0
    tolerances = Tolerances(share * part.rtol, share * part.atol, longest, part.max_steps)
    runs = np.flatnonzero(closed)

    def work(some: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        return stepper.march_all(starts[some], values.T[some], part.times, tolerances)

    pieces = [piece for piece in np.array_split(runs, part.threads) if len(piece)]
    with ThreadPoolExecutor(part.threads) as pool:
        results = list(pool.map(work, pieces))
    states = np.full((len(part), len(part.times), starts.shape[1]), np.nan)
    steps = np.full(len(part), -1)
    states[:, 0] = _start(part)
    left: list[int] = []
    for piece, (solution, taken, ended) in zip(pieces, results, strict=True):
        whole, endless = ended == ENDED.index("end"), ended == ENDED.index("many")
        states[piece], steps[piece] = solution, np.where(whole, taken, -taken - 1)
        left += piece[~whole & ~endless].tolist()
    if left:
        states[left], steps[left] = _single(part.take(left), mechanism)
    return states, steps


def _close_starts(part: Part, mechanism: Mechanism) -> tuple[np.ndarray, np.ndarray]:
    """Return the states to start from, with closed loops, and whether they can be closed."""
    starts, closed = _start(part), np.ones(len(part), dtype=bool)
    if not mechanism.constrained:
        return starts, closed
    from mecanique.reference import Reference

    t0 = float(part.times[0])
    for k, (q, v) in enumerate(zip(part.q, part.v, strict=True)):
        changed = vary(mechanism, part.parameters, k)
        try:
            starts[k] = begin_on_loops(Reference.of(changed), q, v, t0).state
        except MecaniqueError:
            closed[k] = False
    return starts, closed


def _single(part: Part, mechanism: Mechanism) -> tuple[np.ndarray, np.ndarray]:
    from mecanique.motion.motion import simulate

    states: np.ndarray = np.full(
        (len(part), len(part.times), part.q.shape[1] + part.v.shape[1]), np.nan
    )
    steps = np.zeros(len(part), dtype=int)
    begin, end = float(part.times[0]), float(part.times[-1])
    for k, (q, v) in enumerate(zip(part.q, part.v, strict=True)):
        states[k, 0] = np.concatenate([q, v])
        try:
            motion = simulate(
                vary(mechanism, part.parameters, k),
                q=q,
                v=v,
                t0=begin,
                duration=end - begin,
                samples=part.times,
                rtol=part.rtol,
                atol=part.atol,
                max_steps=part.max_steps,
            )
        except MecaniqueError as error:
            if isinstance(error.__cause__, KeyboardInterrupt):
                raise KeyboardInterrupt from error
            steps[k] = -1
            continue
        states[k], steps[k] = np.hstack([motion.q, motion.v]), motion.statistics.steps
    return states, steps


def vary(mechanism: Mechanism, parameters: Mapping[str, np.ndarray], run: int) -> Mechanism:
    """Return the mechanism of a run, with its values of the parameters."""
    numbers = {symbol: float(values[run]) for symbol, values in parameters.items()}
    return mechanism.replace(**numbers) if numbers else mechanism


def threads_here() -> int:
    """Return how many threads a part may use in this process."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
