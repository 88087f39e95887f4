"""Count false alarms: verdicts of sound textbook systems that disagree, over many seeds.

Run it by hand: python tests/benchmarks/bench_alarms.py [SEEDS] [SAMPLES] [FIRST] [PROCESSES]
It prints every false alarm with its quantity, difference and what was allowed, then a line by
system. Where the bound on rounding decides, because it exceeds the tolerance, the line has how many
rows that is, and how tight the bound is: the largest part of it that a difference reaches.

The states of each seed are those of `verify`, only that at least 8 candidates are drawn at once
instead of 32, so that states next to singular ones are recognized less well. Derivations and
answers are shared, as a form answers at many states as fast as at one. 2,000 seeds of 5 samples
take about half an hour of one idle core.
"""

from __future__ import annotations

import os
import sys
import time
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field
from functools import partial
from multiprocessing import get_context

import numpy as np

from mecanique import textbook
from mecanique.model.states import States
from mecanique.reference import Reference
from mecanique.threads import one_thread_for_loops
from mecanique.verification import forms
from mecanique.verification.answers import ask
from mecanique.verification.compare import judge
from mecanique.verification.states import random as drawing

BATCH = 100
"""Seeds whose states are evaluated at once."""

LOT = 8
"""Candidates drawn at once; to close the loops of each is what takes most of the time."""


@dataclass
class Count:
    """What became of one system."""

    name: str
    alarms: list[str] = field(default_factory=list)
    worst: float = 0.0
    allowed: float = 0.0
    decided: int = 0
    tight: float = 0.0
    seconds: float = 0.0


@one_thread_for_loops
def count(name: str, seeds: range, samples: int) -> Count:
    """Count the false alarms of one system."""
    found, begin = Count(name), time.process_time()
    setattr(drawing, "_LOT", LOT)  # noqa: B010
    mechanism = textbook.load(name)
    ours, engine = forms.derive_all(mechanism), Reference(mechanism)
    for first in range(seeds.start, seeds.stop, BATCH):
        some = range(first, min(first + BATCH, seeds.stop))
        drawn = [drawing.random_states(mechanism, samples, seed, ours.assumptions) for seed in some]
        q, v, t, a = (
            np.concatenate([getattr(states, part) for states in drawn]) for part in "qvta"
        )
        everywhere = States(mechanism, q, v, t, a)
        answers = ask(ours, engine, mechanism, everywhere, budget=False)
        for k, (seed, states) in enumerate(zip(some, drawn, strict=True)):
            here = answers.at(k * samples, (k + 1) * samples)
            verdict = judge(mechanism, here, states, seed)
            for row in verdict.rows:
                found.worst = max(found.worst, row.worst)
                found.allowed = max(found.allowed, row.worst / verdict.tolerance_of(row))
                if row.rounding > verdict.tolerance:
                    found.decided += 1
                    found.tight = max(found.tight, row.worst / row.rounding)
                if not verdict.accepts(row):
                    found.alarms.append(
                        f"  seed {seed}: {row.quantity}, {row.sources[0]}: {row.worst:.1e}, "
                        f"allowed {verdict.tolerance_of(row):.1e}, q = {np.round(row.q, 6)}"
                    )
    found.seconds = time.process_time() - begin
    return found


def main(seeds: int = 300, samples: int = 5, first: int = 0, processes: int = 0) -> int:
    """Return the number of false alarms."""
    begin, total = time.perf_counter(), 0
    one = partial(count, seeds=range(first, first + seeds), samples=samples)
    # what takes longest comes first
    names = sorted(textbook.names(), key=lambda name: -len(textbook.load(name).loops))
    print(
        "system, false alarms, largest difference, largest part of what is allowed, rows where "
        "the bound decides, largest part of the bound there, seconds"
    )
    with ProcessPoolExecutor(
        processes or os.cpu_count(), get_context("spawn"), initializer=os.nice, initargs=(10,)
    ) as pool:
        for found in pool.map(one, names):
            print("\n".join([*found.alarms, ""]), end="")
            print(
                f"{found.name:24} {len(found.alarms):4} {found.worst:9.1e} {found.allowed:9.1e} "
                f"{found.decided:6} {found.tight:9.1e} {found.seconds:7.0f}",
                flush=True,
            )
            total += len(found.alarms)
    print(f"{total} false alarms in {seeds} seeds, {time.perf_counter() - begin:.0f} s")
    return total


if __name__ == "__main__":
    raise SystemExit(min(1, main(*map(int, sys.argv[1:]))))
