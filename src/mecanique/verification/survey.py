"""Verify every textbook system, or every robot of example-robot-data, in one table."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass, replace
from functools import partial
from multiprocessing import get_context
from time import perf_counter
from typing import Literal, TypeAlias, final

from mecanique.errors import MecaniqueError
from mecanique.model.mechanism import Mechanism
from mecanique.model.values import whole
from mecanique.verification.verdict import SOLVED_ALIKE

Progress: TypeAlias = Callable[[float], None]
"""Receives the part of the work that is done, from 0 to 1."""

Root: TypeAlias = Literal["fixed", "floating"]


@final
@dataclass(frozen=True)
class Entry:
    """The outcome for one mechanism."""

    name: str  # of the robot or system
    root: str  # how the root link is held; empty for a textbook system
    velocities: int = 0  # number of generalized velocities, 0 if it was refused
    # the largest relative difference, of a disagreement if there is one; infinite if a number is
    # not finite or it was refused
    worst: float = math.inf
    quantity: str = ""  # where that difference is, or what went wrong
    refused: str = ""  # why it was refused, in one sentence; empty if it was compared
    seconds: float = 0.0  # how long it took [s]
    rounding: float = 0.0  # relative difference that rounding alone explains there
    allowed: float = SOLVED_ALIKE  # relative difference that counts as agreement there


@final
@dataclass(frozen=True)
class Survey:
    """The verdicts of many mechanisms."""

    entries: tuple[Entry, ...]  # one per mechanism and way of holding its root
    samples: int  # number of states of each
    seed: int  # of the random states
    tolerance: float  # largest relative difference that counts as agreement
    seconds: float  # how long it took [s]

    @property
    def agrees(self) -> bool:
        """Whether all that were compared agree."""
        return all(self.accepts(entry) for entry in self.entries if not entry.refused)

    def accepts(self, entry: Entry) -> bool:
        """Return whether an entry is within the tolerance, or within what rounding makes."""
        return entry.worst <= entry.allowed

    @property
    def summary(self) -> str:
        """The outcome in one sentence."""
        compared = [entry for entry in self.entries if not entry.refused]
        bad = [entry.name for entry in compared if not self.accepts(entry)]
        refused = len({entry.name for entry in self.entries if entry.refused})
        worst = max((entry.worst for entry in compared), default=0.0)
        said = (
            f"{len(compared) - len(bad)} of {len(compared)} agree at {self.samples} random states "
            f"(seed {self.seed})"
        )
        result = (
            f", worst relative difference {worst:.1e}"
            if not bad
            else f"; DISAGREE: {', '.join(bad)}"
        )
        return f"{said}{result}; {refused} refused; {self.seconds:.0f} s"

    def to_json(self) -> str:
        """Return everything as JSON text; a difference that is not finite is null."""
        rows = [
            {**asdict(e), "worst": e.worst if math.isfinite(e.worst) else None}
            for e in self.entries
        ]
        names = ("agrees", "summary", "samples", "seed", "tolerance", "seconds")
        table = {**{name: getattr(self, name) for name in names}, "entries": rows}
        return json.dumps(table, ensure_ascii=False, allow_nan=False, indent=2)

    def __str__(self) -> str:
        rows: list[tuple[str, ...]] = []
        grouped: dict[str, list[Entry]] = {}
        for entry in self.entries:
            grouped.setdefault(entry.name, []).append(entry)
        for name, entries in grouped.items():
            if all(entry.refused for entry in entries):
                rows.append((name, "-", "-", f"refused: {entries[0].refused}"))
                continue
            sizes = "/".join(
                str(entry.velocities) if not entry.refused else "-" for entry in entries
            )
            compared = [entry for entry in entries if not entry.refused]
            entry = max(compared, key=lambda entry: (not self.accepts(entry), entry.worst))
            worst, said = entry.worst, ""
            if not self.accepts(entry):
                said = f"DISAGREES: {entry.quantity}"
            elif worst > self.tolerance:
                said = f"rounding may make {entry.rounding:.1e} of {entry.quantity}"
            refusals = [entry for entry in entries if entry.refused]
            refused = [f"{entry.root} refused: {entry.refused}" for entry in refusals]
            rows.append((name, sizes, f"{worst:.1e}", "; ".join(filter(None, (said, *refused)))))
        both = any(entry.root for entry in self.entries)
        head = ("robot" if both else "system", "N fixed/floating" if both else "N", "worst", "")
        columns = list(zip(head, *rows, strict=True))
        widths = [max(map(len, column)) for column in columns[:3]]
        lines = [
            f"{name:{widths[0]}}  {size:>{widths[1]}}  {worst:>{widths[2]}}  {said}".rstrip()
            for name, size, worst, said in (head, *rows)
        ]
        return "\n".join([*lines, self.summary])


def survey_robots(
    samples: int = 50,
    seed: int = 0,
    *,
    processes: int = 1,
    progress: Progress | None = None,
    only: Sequence[str] = (),
) -> Survey:
    """Verify every robot of example-robot-data, held by its root link and floating."""
    from mecanique.urdf.robots import robot, robots

    names = tuple(only) or robots()
    for name in names:
        robot(name)
    tasks = [(name, root) for name in names for root in ("fixed", "floating")]
    return _survey(tasks, samples, seed, processes, progress)


def survey_systems(
    samples: int = 100, seed: int = 0, *, processes: int = 1, progress: Progress | None = None
) -> Survey:
    """Verify every textbook system."""
    from mecanique.textbook import names

    return _survey([(name, "") for name in names()], samples, seed, processes, progress)


def _survey(
    tasks: list[tuple[str, str]], samples: int, seed: int, processes: int, progress: Progress | None
) -> Survey:
    samples, seed = whole(samples, "samples", 1), whole(seed, "seed", 0)
    processes = whole(processes, "processes", 1)
    start, entries = perf_counter(), list[Entry]()
    for entry in _entries(partial(_entry, samples=samples, seed=seed), tasks, processes):
        entries.append(entry)
        if progress is not None:
            progress(len(entries) / len(tasks))
    return Survey(tuple(entries), samples, seed, SOLVED_ALIKE, perf_counter() - start)


def _entries(
    survey_task: Callable[[tuple[str, str]], Entry], tasks: list[tuple[str, str]], processes: int
) -> Iterator[Entry]:
    if processes == 1:
        yield from map(survey_task, tasks)
        return
    # a fresh interpreter each: a forked one would share threads that it does not have
    with ProcessPoolExecutor(processes, mp_context=get_context("spawn")) as pool:
        yield from pool.map(survey_task, tasks, chunksize=1)


def _entry(task: tuple[str, str], samples: int, seed: int) -> Entry:
    entry, start = Entry(*task), perf_counter()
    try:
        mechanism = _load(*task)
        from mecanique.verification.compare import compare

        verdict = compare(mechanism, samples, seed, quick=bool(entry.root))
        entry = replace(entry, velocities=mechanism.nv)
        if verdict.rows:
            bad = [row for row in verdict.rows if not row.agrees]
            row = max(bad or verdict.rows, key=lambda row: row.worst)
            entry = replace(entry, worst=row.worst, quantity=row.quantity)
            entry = replace(entry, rounding=row.rounding, allowed=row.allowed)
    except MecaniqueError as error:
        entry = replace(entry, refused=_short(str(error)))
    except Exception as error:
        # a fault of ours must not take the other rows along; it counts as a disagreement and is
        # reported
        entry = replace(entry, quantity=f"{type(error).__name__}: {error}")
    return replace(entry, seconds=perf_counter() - start)


def _load(name: str, root: str) -> Mechanism:
    if not root:
        from mecanique.textbook import load

        return load(name)
    from mecanique.urdf.read import read_urdf
    from mecanique.urdf.robots import robot

    return read_urdf(robot(name), root="floating" if root == "floating" else "fixed")


def _short(message: str) -> str:
    """Return the first fault of a message, without folders, and how many more there are."""
    first, *more = re.sub(r" at q = \[.*?\]", "", message).split("\n  ")
    if more:
        count = f" (and {len(more) - 1} more)" if len(more) > 1 else ""
        first = f"{more[0]}{count}"
    words = first.split(": ", 1)
    return (
        f"line {words[0].rpartition(':')[2]}: {words[1]}"
        if ".urdf:" in words[0] and len(words) == 2
        else first
    )
