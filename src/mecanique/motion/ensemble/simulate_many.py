"""Simulate many motions of one mechanism, from other states or with other parameters."""

from __future__ import annotations

import hashlib
import json
import pickle
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, Executor, Future, wait
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cached_property
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias, final

import numpy as np

from mecanique.errors import (
    DerivationError,
    InputError,
    IntegrationError,
    MecaniqueError,
    UnknownNameError,
)
from mecanique.files import write_whole
from mecanique.generation.targets.c import compiler
from mecanique.model.mechanism import Mechanism
from mecanique.model.mechanism.letters import to_name
from mecanique.model.mechanism.state_space import by_leaders
from mecanique.model.states import States, list_left_out
from mecanique.model.values import column_of, numbers_of, whole
from mecanique.motion.compile.costs import NUMPY, estimate_series_of
from mecanique.motion.compile.derive import program_of, require_agreement
from mecanique.motion.compile.heyoka import is_installed
from mecanique.motion.compile.program import SAMPLES, RatesProgram
from mecanique.motion.compile.python import vectorize
from mecanique.motion.compile.stepper import can_compile, refuse_signals
from mecanique.motion.ensemble.chunks import Chunk, Part, run_part, threads_here, vary
from mecanique.motion.output.storage import provenance, read_arrays
from mecanique.motion.simulation.problem import refuse_still, sample_times, span_and_tolerances
from mecanique.verification.states import random_states
from mecanique.wording import say_count

if TYPE_CHECKING:
    from mecanique.motion.motion import Motion

# The results of many runs: states by run and time, kept in memory or in a directory.

FORMAT = "mecanique runs 1"


@final
class Store:
    """Chunks as they come, each kept once: in memory, or each in a file of a directory."""

    def __init__(
        self,
        directory: Path | None,
        about: Mapping[str, Any],
        shapes: tuple[tuple[int, ...], ...],
        size: int,
    ) -> None:
        self.directory = directory
        self._shapes, self._size = shapes, size
        self._chunks: dict[int, Chunk] = {}
        if directory is None:
            return
        description = directory / "runs.json"
        try:
            directory.mkdir(parents=True, exist_ok=True)
            if description.exists():
                stored = json.loads(description.read_text(encoding="utf-8"))
                if stored != about:
                    differing = ", ".join(
                        sorted(k for k in {*stored, *about} if stored.get(k) != about.get(k))
                    )
                    raise InputError(
                        f"directory {str(directory)!r} holds other runs (other {differing}); "
                        "choose another directory, "
                        "or ask for the same runs to continue them"
                    )
            else:
                with write_whole(description) as file:
                    file.write(json.dumps(about, indent=1, ensure_ascii=False).encode())
        except (OSError, ValueError) as error:
            raise InputError(f"the runs in {str(directory)!r} cannot be kept: {error}") from error

    def keep(self, chunk: Chunk) -> None:
        """Keep a chunk; one that is there already is left as it is."""
        if chunk.first in self:
            return
        if self.directory is None:
            self._chunks[chunk.first] = chunk
            return
        import io

        data = io.BytesIO()
        np.savez(data, q=chunk.q, v=chunk.v, steps=chunk.steps)
        try:
            with write_whole(self._path(chunk.first)) as file:
                file.write(data.getvalue())
        except OSError as error:
            raise InputError(
                f"the runs in {str(self.directory)!r} cannot be kept: {error}"
            ) from error

    def __contains__(self, first: int) -> bool:
        return first in self._chunks if self.directory is None else self._path(first).exists()

    def __getitem__(self, first: int) -> Chunk:
        if self.directory is None:
            return self._chunks[first]
        path = self._path(first)
        try:
            arrays = read_arrays(path)
            parts = [arrays[name] for name in ("q", "v", "steps")]
            for part, (runs, *shape) in zip(parts, self._shapes, strict=True):
                expected = (min(self._size, runs - first), *shape)
                if part.shape != expected or part.dtype.kind not in "fi":
                    raise ValueError(
                        f"expected numbers of shape {expected}, got {part.dtype} of {part.shape}"
                    )
            return Chunk(first, *parts)
        except Exception as error:
            raise InputError(
                f"{str(path)!r} cannot be read ({error}); delete it and run again"
            ) from error

    def _path(self, first: int) -> Path:
        assert self.directory is not None
        return self.directory / f"runs_{first:09d}.npz"


@final
@dataclass(frozen=True, eq=False)
class Runs:
    """Many motions of one mechanism; `simulate_many` makes them.

    `runs["q"]` and `runs["q'"]` are a coordinate and its velocity, shape (n, m): by run and time.
    What could not be integrated is not a number; `runs.failed` lists these runs.

    Args:
        mechanism: what moved.
        t: shape (m,), times of the samples [s].
        start: positions and velocities at the start, shape (n, nq + nv).
        parameters: values of the parameters that differ from run to run, shape (n,) each, by
            symbol.
        method: how they were integrated and why.
        rtol: relative tolerance of a step.
        chunk: number of runs in a chunk.
        store: what was integrated.

    Example:
        >>> pendulum = mq.textbook.load("rigid_bar_pendulum")
        >>> runs = mq.simulate_many(pendulum, q={"q": [0.1, 1.0, 2.0]}, duration=1.0)
        >>> runs["q"][:, -1].round(3)
        array([-0.077, -0.902, -1.948])
        >>> float(runs.motion(2)["q"][-1].round(3))
        -1.948
    """

    mechanism: Mechanism
    t: np.ndarray
    start: np.ndarray
    parameters: Mapping[str, np.ndarray]
    method: str
    rtol: float
    chunk: int = field(repr=False)
    store: Store = field(repr=False)

    def __len__(self) -> int:
        return len(self.start)

    @property
    def done(self) -> int:
        """How many runs were integrated; fewer than all after an interruption."""
        return sum(
            min(self.chunk, len(self) - first) for first in self._firsts if first in self.store
        )

    def chunks(self) -> Iterator[tuple[np.ndarray, np.ndarray, np.ndarray]]:
        """Yield (indices of runs, q, v) chunk by chunk, so that memory need not hold them all."""
        for first in self._firsts:
            if first in self.store:
                chunk = self.store[first]
                yield np.arange(first, first + len(chunk.q)), chunk.q, chunk.v

    @cached_property
    def q(self) -> np.ndarray:
        """Positions, shape (n, m, nq)."""
        return self._gather("q", self.mechanism.nq)

    @cached_property
    def v(self) -> np.ndarray:
        """Velocities, shape (n, m, nv)."""
        return self._gather("v", self.mechanism.nv)

    @cached_property
    def steps(self) -> np.ndarray:
        """Number of steps of each run, shape (n,): 0 if not integrated, negative if it failed."""
        steps = np.zeros(len(self), dtype=int)
        for first in self._firsts:
            if first in self.store:
                taken = self.store[first].steps
                steps[first : first + len(taken)] = taken
        return steps

    @property
    def failed(self) -> np.ndarray:
        """Indices of the runs that could not be integrated to their end."""
        return np.flatnonzero(self.steps < 0)

    def __getitem__(self, name: str) -> np.ndarray:
        m, name = self.mechanism, to_name(self.mechanism, name)
        for names, values in ((m.coordinates.names, "q"), (m.velocities, "v")):
            if name in names:
                column: np.ndarray = getattr(self, values)[:, :, names.index(name)]
                return column
        if name in self.parameters:
            return self.parameters[name]
        raise UnknownNameError(
            "coordinate, velocity or parameter", name, (*m.coordinates, *m.velocities)
        )

    def motion(self, index: int, **options: Any) -> Motion:
        """Return one run as a `Motion`, integrated again by `simulate`.

        Args:
            index: of the run.
            options: of `simulate`.

        Raises:
            InputError: if there is no such run.
        """
        from mecanique.motion.motion import simulate

        if not -len(self) <= index < len(self):
            raise InputError(
                f"expected the index of one of {say_count(len(self), 'run')}, got {index!r}"
            )
        nq = self.mechanism.nq
        span = {
            "t0": float(self.t[0]),
            "duration": float(self.t[-1] - self.t[0]),
            "rtol": self.rtol,
        }
        return simulate(
            vary(self.mechanism, self.parameters, index),
            q=self.start[index, :nq],
            v=self.start[index, nq:],
            **{**span, **options},
        )

    def __repr__(self) -> str:
        return (
            f"<Runs of {self.mechanism.name!r}: {self.done} of {say_count(len(self), 'run')}, "
            f"{say_count(len(self.t), 'sample')}, "
            f"t = {self.t[0]:g}…{self.t[-1]:g} s>"
        )

    @property
    def _firsts(self) -> range:
        return range(0, len(self), self.chunk)

    def _gather(self, name: str, width: int) -> np.ndarray:
        values: np.ndarray = np.full((len(self), len(self.t), width), np.nan)
        for first in self._firsts:
            if first in self.store:
                part = getattr(self.store[first], name)
                values[first : first + len(part)] = part
        return values


def identity(
    mechanism: Mechanism,
    start: np.ndarray,
    parameters: Mapping[str, np.ndarray],
    t: np.ndarray,
    settings: list[Any],
) -> dict[str, Any]:
    """Return what identifies runs, so that only the same ones are continued in a directory."""
    arrays = [start, t, *(parameters[symbol] for symbol in sorted(parameters))]
    return {
        "format": FORMAT,
        **provenance(mechanism),
        "swept": sorted(parameters),
        "runs": len(start),
        "settings": settings,
        "numbers": hashlib.sha256(
            b"".join(np.ascontiguousarray(a).tobytes() for a in arrays)
        ).hexdigest(),
    }


Given: TypeAlias = (
    "Sequence[float] | np.ndarray | Mapping[str, float | Sequence[float] | np.ndarray] | None"
)

CHUNK = 5000
"""Runs in a chunk for each thread: enough that Python's overhead and waiting are small."""

WAITING = 64
"""Most chunks handed to an executor at a time, so that memory stays bounded."""

_TITLES = {
    "batch": "batch (explicit Runge-Kutta of order 8(5,3), many runs at once in numpy)",
    "taylor": "taylor (Taylor series, heyoka)",
    "compiled": "compiled (explicit Runge-Kutta of order 8(5,3) in C)",
    "single": "single (each run by simulate)",
}


def simulate_many(
    mechanism: Mechanism,
    q: Given = None,
    v: Given = None,
    parameters: Mapping[str, float | Sequence[float] | np.ndarray] | None = None,
    *,
    duration: float = 10.0,
    rtol: float = 1e-8,
    atol: float | None = None,
    method: str = "auto",
    samples: int | Sequence[float] | np.ndarray = 2,
    t0: float = 0.0,
    max_steps: int = 1_000_000,
    executor: Executor | None = None,
    directory: str | PathLike[str] | None = None,
    chunk: int | None = None,
    progress: bool | Callable[[float], object] = False,
) -> Runs:
    """Integrate many motions of one mechanism, each from its own start and with its own parameters.

    What is given once holds for all runs. The equations derived in-house drive the runs, after they
    have been compared with the reference.

    Args:
        mechanism: what moves.
        q: positions at the start: shape (nq,) or (n, nq), or by coordinate name a number or shape
            (n,).
        v: velocities at the start: shape (nv,) or (n, nv), or by name (q or q') a number or shape
            (n,).
        parameters: by symbol, a number or shape (n,).
        duration: how long [s].
        rtol: relative tolerance of each step, in 1e-14…1e-1.
        atol: absolute tolerance of each step; as rtol by default.
        method: "auto", or one of "batch" (numpy), "taylor" (heyoka, extra `fast`), "compiled" (C,
            with a C compiler; the only fast one that keeps loops closed), "single" (each run by
            `simulate`). "auto" takes "single" where no other can be had, e.g. where there are
            limits or elements that switch.
        samples: number of samples, the start and the end among them, or their times [s], shape
            (m,).
        t0: time at the start [s].
        max_steps: most steps of a run.
        executor: any `concurrent.futures` executor, e.g.
            `dask.distributed.Client().get_executor()`; without one the runs are integrated in this
            process.
        directory: where to keep what is done, chunk by chunk; the same call continues runs that
            were interrupted.
        chunk: number of runs in a chunk.
        progress: True for a bar, or a function that is called with the fraction done, in 0…1.

    Returns:
        The runs, at the times asked for.

    Raises:
        InputError: if an argument is not what is expected, or the directory holds other runs.
        UnknownNameError: if a coordinate, velocity, parameter or method does not exist.
        MechanismError: if the mechanism is not sound with some of the parameters.
        DerivationError: if the equations do not allow the method asked for.
        IntegrationError: if it was interrupted or the executor broke; its `.motion` holds the runs
            that are done.

    Example:
        >>> pendulum = mq.textbook.load("simple_pendulum")
        >>> lengths = {"l": [0.5, 1.0, 2.0]}
        >>> runs = mq.simulate_many(pendulum, q={"q": 0.1}, parameters=lengths, duration=1.0)
        >>> runs["q"][:, -1].round(3)
        array([-0.028, -0.1  , -0.06 ])
    """
    refuse_still(mechanism)
    t0, end, rtol, atol = span_and_tolerances(t0, duration, rtol, atol)
    times = np.union1d([t0], sample_times(t0, end, 60.0, samples))
    if times[-1] < end:
        times = np.append(times, end)
    start, varied = _sweep(mechanism, q, v, parameters)
    if method not in ("auto", *_TITLES):
        raise UnknownNameError("method", method, ("auto", *_TITLES))
    max_steps = whole(max_steps, "max_steps")
    chunk = None if chunk is None else whole(chunk, "chunk")
    chosen, reason = _choose(mechanism, start, varied, method, end - t0)
    size = min(chunk or _chunk(len(start), chosen, executor), len(start))
    about = (
        identity(mechanism, start, varied, times, [chosen, rtol, atol, max_steps, size])
        if directory
        else {}
    )
    n, m = len(start), len(times)
    shapes = (n, m, mechanism.nq), (n, m, mechanism.nv), (n,)
    store = Store(None if directory is None else Path(directory), about, shapes, size)
    if not mechanism.constrained:
        reason += list_left_out(mechanism, q, v, start[0])
    runs = Runs(
        mechanism=mechanism,
        t=times,
        start=start,
        parameters=varied,
        method=f"{_TITLES[chosen]}{reason}",
        rtol=rtol,
        chunk=size,
        store=store,
    )
    every = Part(
        first=0,
        mechanism=_pickle(mechanism),
        q=start[:, : mechanism.nq],
        v=start[:, mechanism.nq :],
        parameters=varied,
        times=times,
        method=chosen,
        rtol=rtol,
        atol=atol,
        max_steps=max_steps,
        threads=threads_here() if executor is None else 1,
    )
    parts = (every.take(slice(k, k + size)) for k in range(0, len(start), size) if k not in store)
    done = _here(parts, store) if executor is None else _elsewhere(parts, store, executor)
    _finish(runs, done, progress, directory)
    return runs


def _sweep(
    mechanism: Mechanism, q: Any, v: Any, parameters: Any
) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Return the starts of all runs, shape (n, nq + nv), and given parameters, shape (n,) each."""
    names = mechanism.coordinates.names
    q = by_leaders(mechanism, q, names)
    positions = numbers_of(q, names, "coordinate", mechanism.neutral(), many=True)
    rates = mechanism.velocity(v, many=True)
    given = {} if parameters is None else parameters
    if not isinstance(given, Mapping):
        raise InputError(f"expected parameters by symbol, got {parameters!r}")
    for symbol in given:
        if symbol not in mechanism.values:
            raise UnknownNameError("parameter", symbol, mechanism.values)
    varied = {symbol: column_of(values, f"parameter {symbol}") for symbol, values in given.items()}
    lengths = {len(x) for x in (positions, rates) if x.ndim == 2}
    lengths |= {len(x) for x in varied.values() if x.ndim}
    if len(lengths) > 1:
        raise InputError(
            f"expected one number of runs in q, v and parameters, got {sorted(lengths)}"
        )
    n = lengths.pop() if lengths else 1
    if not n:
        raise InputError("expected at least one run, got none")
    parts = (np.broadcast_to(x, (n, x.shape[-1])) for x in (positions, rates))
    start = np.concatenate([*parts], axis=1)
    varied = {
        symbol: np.ascontiguousarray(np.broadcast_to(x, (n,))) for symbol, x in varied.items()
    }
    for values in varied.values():
        for index in {int(np.argmin(values)), int(np.argmax(values))}:
            mechanism.replace(**{name: float(x[index]) for name, x in varied.items()})
    mechanism.normalize(start[:, : mechanism.nq])
    return start, varied


def _finish(
    runs: Runs,
    done: Iterable[None],
    progress: bool | Callable[[float], object],
    directory: str | PathLike[str] | None,
) -> None:
    """Integrate the chunks one after another, and say how far they are."""
    with _reporting(progress) as report:
        report(runs.done / len(runs))
        try:
            for _ in done:
                report(runs.done / len(runs))
        except MecaniqueError:
            raise
        except (KeyboardInterrupt, BrokenExecutor) as error:
            raise _explain_interruption(runs, error, directory) from error


def _explain_interruption(
    runs: Runs, error: BaseException, directory: str | PathLike[str] | None
) -> IntegrationError:
    """Return the error that says how many runs are done, and how to continue them."""
    pressed = isinstance(error, KeyboardInterrupt)
    what = "interrupted" if pressed else f"the executor broke ({error})"
    again = "the same call continues them"
    return IntegrationError(
        f"{what}: {runs.done} of {say_count(len(runs), 'run')} done, in the error's .motion; "
        f"{again if directory else f'with a directory {again}'}",
        motion=runs,
    )


def _chunk(count: int, method: str, executor: Executor | None) -> int:
    """How many runs make a chunk."""
    if method == "single":
        return 10
    # an executor should have some chunks to share out, but small ones are slow: numpy's overhead is
    # per call
    return CHUNK * threads_here() if executor is None else int(np.clip(-(-count // 8), 250, CHUNK))


def _here(parts: Iterator[Part], store: Store) -> Iterator[None]:
    for part in parts:
        store.keep(run_part(part))
        yield


def _elsewhere(parts: Iterator[Part], store: Store, executor: Executor) -> Iterator[None]:
    """Hand parts to the executor, a few at a time, and keep what comes back."""
    waiting: set[Future[Any]] = set()
    try:
        for part in parts:
            waiting.add(executor.submit(run_part, part))
            if len(waiting) >= WAITING:
                waiting = yield from _keep_done(waiting, store)
        while waiting:
            waiting = yield from _keep_done(waiting, store)
    except BaseException as error:
        for future in waiting:
            future.cancel()
            if future.done() and not future.cancelled() and future.exception() is None:
                store.keep(future.result())
        if isinstance(error, (MecaniqueError, BrokenExecutor)) or not isinstance(error, Exception):
            raise
        # whatever else an executor raises, the runs that are done are kept
        raise BrokenExecutor(f"{type(error).__name__}: {error}") from error


def _keep_done(waiting: set[Future[Any]], store: Store) -> Any:
    done, left = wait(waiting, return_when=FIRST_COMPLETED)
    broken: BaseException | None = None
    for future in done:
        error = future.exception()
        if error is None:
            store.keep(future.result())
            yield
        else:
            broken = error
    if broken is not None:
        raise broken
    return left


def _choose(
    mechanism: Mechanism,
    start: np.ndarray,
    varied: Mapping[str, np.ndarray],
    method: str,
    span: float,
) -> tuple[str, str]:
    """Return the method and the reason for it; its equations are compared with the reference."""
    if method == "single":
        return method, ""
    watched = [f"the limits of {', '.join(mechanism.limits)}"] if mechanism.limits else []
    if mechanism.switching:
        switching = ", ".join(element.name for element in mechanism.switching)
        watched.append(f"where {switching} switches")
    if watched:
        if method != "auto":
            raise InputError(
                f"method {method!r} does not watch {watched[0]}; expected 'single' or 'auto'"
            )
        return "single", f"; chosen because it watches {' and '.join(watched)}"
    if mechanism.constrained and method in ("batch", "taylor"):
        raise DerivationError(
            f"mechanism {mechanism.name!r} has constraints, which method {method!r} does not "
            "keep; expected 'compiled', 'single' or 'auto'"
        )
    if mechanism.constrained and method == "auto" and not can_compile():
        return "single", "; chosen because no C compiler works here"
    if method == "compiled":
        compiler()
    try:
        program = program_of(mechanism, varied)
        if program.signals and (mechanism.constrained or method == "compiled"):
            refuse_signals(program)
        _compare(mechanism, program, varied)
    except DerivationError as error:
        if method != "auto":
            raise
        return "single", f"; chosen because {error}"
    if method != "auto":
        return method, ""
    if mechanism.constrained:
        return "compiled", "; chosen because it keeps constraints"
    if not is_installed():
        return "batch", "; chosen because heyoka is not installed"
    work = len(start) * span * len(program.tape.find_needed(program.rates)) * NUMPY
    if program.signals or work < 2 * estimate_series_of(program):
        return (
            "batch",
            "; chosen because compiling would take longer" if not program.signals else "",
        )
    return "taylor", "; chosen for the number of runs"


def _compare(mechanism: Mechanism, program: RatesProgram, varied: Mapping[str, np.ndarray]) -> None:
    """Compare the equations with the reference at the extreme values of each parameter.

    Those with which loops can never be closed have no motion, and nothing to compare.
    """
    from mecanique.reference import Reference

    extremes = {0}
    for values in varied.values():
        extremes |= {int(np.argmin(values)), int(np.argmax(values))}
    compared, useless = False, None
    for index in sorted(extremes):
        changed = vary(mechanism, varied, index)

        def accelerations(states: States, numbers: dict[str, float] = changed.values) -> np.ndarray:
            Y = np.hstack([states.q, states.v]).T
            out = np.empty((mechanism.nq + mechanism.nv, len(states)))
            rhs = vectorize(program, [np.array(numbers[symbol]) for symbol in program.open])
            with np.errstate(all="ignore"):
                for k, t in enumerate(states.t.tolist()):
                    rhs(t, Y[:, k : k + 1], out[:, k : k + 1])
            rates: np.ndarray = out[mechanism.nq :].T
            return rates

        try:
            states = random_states(changed, SAMPLES, 0)
        except InputError as error:
            useless = error
            continue
        require_agreement(changed, Reference.of(changed), accelerations, "closed form", states)
        compared = True
    if useless is not None and not compared:
        raise useless


def _pickle(mechanism: Mechanism) -> bytes:
    try:
        return pickle.dumps(mechanism)
    except Exception as error:
        raise InputError(
            f"mechanism {mechanism.name!r} cannot be sent to other processes ({error}); "
            "let its inputs be records, expressions, or functions of a module"
        ) from error


@contextmanager
def _reporting(progress: bool | Callable[[float], object]) -> Iterator[Callable[[float], object]]:
    if progress is True and sys.stderr.isatty():
        from rich.console import Console
        from rich.progress import Progress

        with Progress(console=Console(stderr=True)) as bar:
            task = bar.add_task("runs", total=1.0)
            yield lambda fraction: bar.update(task, completed=fraction)
    else:
        yield progress if callable(progress) else lambda _: None
