"""Count false alarms: verdicts of sound textbook systems that disagree, over many seeds.

Run it by hand: python tests/benchmarks/bench_alarms.py [SEEDS] [SAMPLES] [FIRST]
It prints every false alarm with its quantity, difference and what was allowed, then a table by
system. Ten seeds of 5 samples take about 80 s on one busy core.
"""

from __future__ import annotations

import sys
import time
from functools import cache

import numpy as np

from mecanique import textbook
from mecanique.verification import compare as module
from mecanique.verification import forms


def main(seeds: int = 300, samples: int = 5, first: int = 0) -> int:
    """Return the number of false alarms."""
    # the same derivation for every seed; only the states change
    for name in ("derive_all",):
        setattr(forms, name, cache(getattr(forms, name)))
    begin, total = time.perf_counter(), 0
    print("system, alarms, largest difference, largest difference / allowed, seconds")
    for name in textbook.names():
        mechanism, start = textbook.load(name), time.perf_counter()
        alarms, worst, nearest = 0, 0.0, 0.0
        for seed in range(first, first + seeds):
            verdict = module.compare(mechanism, samples, seed)
            alarms += not verdict.agrees
            for row in verdict.rows:
                worst = max(worst, row.worst)
                nearest = max(nearest, row.worst / verdict.tolerance_of(row))
                if not verdict.accepts(row):
                    print(
                        f"  seed {seed}: {row.quantity}, {row.sources[0]}: {row.worst:.1e}, "
                        f"allowed {verdict.tolerance_of(row):.1e}, q = {np.round(row.q, 6)}"
                    )
        total += alarms
        seconds = time.perf_counter() - start
        print(f"{name:24} {alarms:4} {worst:9.1e} {nearest:9.1e} {seconds:7.1f}", flush=True)
    print(f"{total} false alarms in {seeds} seeds, {time.perf_counter() - begin:.0f} s")
    return total


if __name__ == "__main__":
    raise SystemExit(min(1, main(*map(int, sys.argv[1:]))))
