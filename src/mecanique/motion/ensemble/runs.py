"""The results of many runs: states by run and time, kept in memory or in a directory."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, final

import numpy as np

from mecanique.errors import InputError, UnknownNameError
from mecanique.files import write_whole
from mecanique.model.mechanism import Mechanism
from mecanique.motion.ensemble.chunks import Chunk, vary
from mecanique.motion.output.storage import provenance, read_arrays
from mecanique.wording import say_count

if TYPE_CHECKING:
    from mecanique.motion.motion import Motion


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
        m = self.mechanism
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
