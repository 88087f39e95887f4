"""Count false alarms: verdicts of sound systems that disagree, over many seeds.

Run it by hand: python tests/benchmarks/bench_alarms.py [NAME …] [--seeds 2000] [--record FILE]
with names for these systems only: textbook systems, and one mechanism for each element that rolls,
slides or guides (`GUIDES`), which --guides alone counts; 3,334 seeds are 10,000 states of each.
With a record, a file to which every lot of seeds is added as it is counted, a run that was ended
goes on where it was. It prints every false alarm with its quantity, difference and what was
allowed, then a line by system, with the largest part of the bounds on entries that a difference
reaches. A seed all of whose differences are within half of the tolerance, and of the bounds on
entries, cannot be a false alarm; every other one, and every `STRIDE`-th, is judged as `verify` does
it. Where the bound on what is solved for decides, because it exceeds the tolerance, the line has
how many of the rows judged that is, and how tight the bound is: the largest part of it that a
difference reaches.

The states of each seed are drawn as those of `verify`, only in smaller lots, so that states next to
singular ones are recognized less well. Derivations and answers are shared, as a form answers at
many states as fast as at one. 2,000 seeds of 3 samples take about ten minutes of two idle cores,
most of it to close loops; what is constrained comes last.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import asdict, dataclass, field, replace
from multiprocessing import get_context
from pathlib import Path

import numpy as np
import numpy.typing as npt

from mecanique import textbook
from mecanique.model import Mechanism
from mecanique.model.states import States
from mecanique.reference import Reference
from mecanique.threads import one_thread_for_loops
from mecanique.verification import compare as derivations
from mecanique.verification import states as drawing
from mecanique.verification.compare import Answers, ask, judge
from mecanique.verification.rounding import entry_rounding
from mecanique.verification.rows import SMALL, least_size, moving_mass, scale
from mecanique.verification.verdict import SOLVED_ALIKE

Array = npt.NDArray[np.float64]

BATCH = 100
"""Seeds whose states are evaluated at once."""

STRIDE = 20
"""Of the seeds that cannot be false alarms, one in so many is judged all the same."""

LOT = 5
"""Candidates drawn at once; to close the loops of each is what takes most of the time."""


sys.path += [str(Path(__file__).parents[1]), str(Path(__file__).parents[1] / "model")]

import rolling_samples as rolls  # noqa: E402  # found by the line before
import test_model_belts as belts  # noqa: E402
import test_model_gears as gears  # noqa: E402
import test_model_turning_cords as cords  # noqa: E402


def light(mechanism: Mechanism) -> Mechanism:
    """Return a wheel with the mass and radius of the one that once disagreed."""
    values = {"m": 1.4, "r": 0.17}
    changed = [replace(p, value=values.get(p.symbol, p.value)) for p in mechanism.parameters]
    return replace(mechanism, parameters=tuple(changed))


GUIDES: dict[str, Callable[[], Mechanism]] = {
    "wheel": lambda: light(rolls.wheel()),
    "crowned wheel": lambda: light(rolls.wheel(crown=0.05)),
    "ball": rolls.turntable,
    "ellipsoid": rolls.stone,
    "bowl": rolls.bowl,
    "turning bowl": rolls.turning_bowl,
    "dome": lambda: rolls.bowl(-2.0),
    "blade": rolls.sleigh,
    "velocity constraint": lambda: rolls.sleigh(by_element=False),
    "cord": cords.collar,
    "belt": belts.drive,
    "gear": gears.planetary,
    "bevel gear": gears.bevel,
    "rack": gears.rack,
}


def load(name: str) -> Mechanism:
    """Return a sound system: one of the guides, or of the textbook."""
    return GUIDES[name]() if name in GUIDES else textbook.load(name)


@dataclass
class Count:
    """What became of some seeds of one system."""

    name: str
    seeds: list[int] = field(default_factory=list)
    alarms: list[str] = field(default_factory=list)
    entries: float = 0.0
    allowed: float = 0.0
    decided: int = 0
    tight: float = 0.0
    seconds: float = 0.0

    def add(self, other: Count) -> None:
        """Add what became of other seeds."""
        self.seeds += other.seeds
        self.alarms += other.alarms
        self.entries = max(self.entries, other.entries)
        self.allowed = max(self.allowed, other.allowed)
        self.decided += other.decided
        self.tight = max(self.tight, other.tight)
        self.seconds += other.seconds


def count_all(name: str, seeds: list[int], samples: int, record: Path | None) -> Count:
    """Count the false alarms of one system, and add each lot to the record."""
    total = Count(name)
    for found in count(name, seeds, samples):
        total.add(found)
        if record is not None:
            with record.open("a", encoding="utf-8") as file:
                file.write(json.dumps(asdict(found)) + "\n")
    return total


@one_thread_for_loops
def count(name: str, seeds: list[int], samples: int) -> Iterator[Count]:
    """Yield the false alarms of one system, lot by lot."""
    setattr(drawing, "_LOT", LOT)  # noqa: B010
    mechanism = load(name)
    ours, engine = derivations.derive_all(mechanism), Reference(mechanism)
    for first in range(0, len(seeds), BATCH):
        begin = time.process_time()
        some = seeds[first : first + BATCH]
        found = Count(name, some)
        drawn = [drawing.random_states(mechanism, samples, seed, ours.assumptions) for seed in some]
        q, v, t, a = (
            np.concatenate([getattr(states, part) for states in drawn]) for part in "qvta"
        )
        everywhere = States(mechanism, q, v, t, a)
        answers = ask(ours, engine, mechanism, everywhere, budget=False)
        entries = largest_of_entries(answers, mechanism, everywhere, samples)
        large = np.maximum(entries, largest_differences(answers, mechanism, samples) / SOLVED_ALIKE)
        found.entries = float(entries.max())
        for k, (seed, states) in enumerate(zip(some, drawn, strict=True)):
            if large[k] <= 0.5 and seed % STRIDE:
                continue
            here = cut(answers, slice(k * samples, (k + 1) * samples))
            verdict = judge(mechanism, here, states, seed)
            for row in verdict.rows:
                found.allowed = max(found.allowed, row.worst / row.allowed if row.worst else 0.0)
                if row.rounding > verdict.tolerance:
                    found.decided += 1
                    found.tight = max(found.tight, row.worst / row.rounding)
                if not row.agrees:
                    found.alarms.append(
                        f"  seed {seed}: {row.quantity}, {row.sources[0]}: {row.worst:.1e}, "
                        f"allowed {row.allowed:.1e}, q = {np.round(row.q, 6)}"
                    )
        found.seconds = time.process_time() - begin
        yield found


def cut(answers: Answers, some: slice) -> Answers:
    """Return the answers, of forms asked at all states, at some of these."""

    def part(values: dict[str, Array]) -> dict[str, Array]:
        return {quantity: array[some] for quantity, array in values.items()}

    forms = {name: part(form) for name, form in answers.forms.items()}
    return replace(answers, engine=part(answers.engine), forms=forms, opening=answers.opening[some])


def largest_of_entries(
    answers: Answers, mechanism: Mechanism, states: States, samples: int
) -> Array:
    """Return the largest part of its bound on rounding that an entry reaches, shape (seeds,)."""
    largest = np.zeros(len(states))
    for quantity, bound in entry_rounding(mechanism, states).items():
        for form in answers.forms.values():
            if quantity in form:
                off = np.abs(form[quantity] - answers.engine[quantity]).reshape(len(states), -1)
                with np.errstate(all="ignore"):
                    part = np.where(off > 0, off / bound.reshape(off.shape), 0.0)
                largest = np.maximum(largest, np.nan_to_num(part, nan=np.inf).max(axis=1))
    by_seed: Array = largest.reshape(-1, samples).max(axis=1)
    return by_seed


def largest_differences(answers: Answers, mechanism: Mechanism, samples: int) -> Array:
    """Return the largest relative difference of each seed, shape (seeds,), as `rows_of` has it."""
    mass, mass_matrix = moving_mass(mechanism), answers.engine["mass matrix"]
    found: list[Array] = []
    for form in answers.forms.values():
        for quantity, values in form.items():
            x, y = (
                scale(quantity, some, mass_matrix).reshape(-1, samples, some[0].size)
                for some in (values, answers.engine[quantity])
            )
            difference = _relative(x, y, least_size(quantity, mass))
            if quantity == "potential energy":
                # known up to a constant only
                middle = np.median(y, axis=1, keepdims=True)
                offset = np.median(x - y, axis=1, keepdims=True)
                shifted = _relative(x - offset - middle, y - middle, least_size(quantity, mass))
                difference = np.minimum(difference, shifted)
            found.append(difference.max(axis=1))
    largest: Array = np.max(found, axis=0)
    return largest


def _relative(x: Array, y: Array, least: float) -> Array:
    sizes = np.linalg.norm(y, axis=2)
    typical = np.sqrt(np.mean(sizes**2, axis=1, keepdims=True))
    size = np.maximum(
        np.maximum(np.linalg.norm(x, axis=2), sizes), SMALL * np.maximum(typical, least)
    )
    difference = np.linalg.norm(x - y, axis=2) / size
    return np.where(np.isfinite(difference), difference, np.inf)


def main(options: argparse.Namespace) -> int:
    """Return the number of false alarms."""
    begin, total = time.perf_counter(), 0
    names = options.names or (*GUIDES, *(() if options.guides else textbook.names()))
    counts = {name: Count(name) for name in names}
    if options.record is not None and options.record.exists():
        for line in options.record.read_text(encoding="utf-8").splitlines():
            earlier = Count(**json.loads(line))
            if earlier.name in counts:
                counts[earlier.name].add(earlier)
    print(
        "system, seeds, false alarms, largest part of the bounds on entries, largest part of what "
        "is allowed, rows where the bound decides, largest part of the bound there, seconds"
    )
    with ProcessPoolExecutor(
        options.processes, get_context("spawn"), initializer=os.nice, initargs=(10,)
    ) as pool:
        running = []
        for name in sorted(counts, key=lambda name: load(name).constrained):
            done = set(counts[name].seeds)
            left = [seed for seed in range(options.seeds) if seed not in done]
            running.append(pool.submit(count_all, name, left, options.samples, options.record))
        for future in as_completed(running):
            name = future.result().name
            counts[name].add(future.result())
            found = counts[name]
            print("\n".join([*found.alarms, ""]), end="")
            print(
                f"{found.name:24} {len(found.seeds):5} {len(found.alarms):4} {found.entries:9.1e} "
                f"{found.allowed:9.1e} {found.decided:6} {found.tight:9.1e} {found.seconds:7.0f}",
                flush=True,
            )
            total += len(found.alarms)
    verdicts = sum(len(found.seeds) for found in counts.values())
    print(f"{total} false alarms in {verdicts} verdicts, {time.perf_counter() - begin:.0f} s")
    return total


def read_options() -> argparse.Namespace:
    """Return what the command line asks for."""
    parser = argparse.ArgumentParser(description="Count false alarms of verify.")
    parser.add_argument("names", nargs="*", help="systems and guides; all by default")
    parser.add_argument("--guides", action="store_true", help="what rolls, slides and guides alone")
    parser.add_argument("--seeds", type=int, default=300, help="how many, from 0 on")
    parser.add_argument("--samples", type=int, default=3, help="states of each seed")
    parser.add_argument("--record", type=Path, help="what was counted, to go on with")
    parser.add_argument("--processes", type=int, default=os.cpu_count())
    return parser.parse_args()


if __name__ == "__main__":
    raise SystemExit(min(1, main(read_options())))
