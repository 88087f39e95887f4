"""A long fuzz run of the URDF reader and linter, by hand.

python tests/benchmarks/fuzz_urdf.py --cases 20000 --seed 1

Each case damages the text of the dialect sample or of a robot of example-robot-data in one to eight
places. It counts as a failure if anything but a sound mechanism or a refusal comes of it, or if it
takes longer than ten seconds."""

from __future__ import annotations

import argparse
import random
import sys
import time
import traceback
from collections import Counter
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "urdf"))


def main() -> int:
    """Run the cases and print the figures; the exit code says whether one failed."""
    from urdf_mutations import SAMPLE, mutated, outcome

    from mecanique.urdf.robots import robot, robots

    words = argparse.ArgumentParser(description=main.__doc__)
    words.add_argument("--cases", type=int, default=20_000)
    words.add_argument("--seed", type=int, default=1)
    words.add_argument(
        "--robots", type=float, default=0.05, help="share of cases that damage a robot's file"
    )
    given = words.parse_args()
    texts = [
        text
        for text in (robot(name).read_text(encoding="utf-8") for name in robots())
        if len(text) < 60_000
    ]
    counts: Counter[str] = Counter()
    slowest = 0.0
    begin = time.perf_counter()
    for case in range(given.cases):
        rng = random.Random(given.seed * 10_000_000 + case)
        source = rng.choice(texts) if rng.random() < given.robots else SAMPLE
        text = mutated(source, rng, rng.choice((1, 1, 1, 2, 2, 3, 5, 8)))
        start = time.perf_counter()
        try:
            result = outcome(text)
        except Exception:
            result = "failed"
            print(
                f"case {case} of seed {given.seed}:\n{traceback.format_exc(limit=-3)}",
                file=sys.stderr,
            )
        seconds = time.perf_counter() - start
        if seconds > 10:
            result = "failed"
            print(f"case {case} of seed {given.seed} took {seconds:.1f} s", file=sys.stderr)
        slowest = max(slowest, seconds)
        counts[result] += 1
    told = ", ".join(f"{counts[result]:,} {result}" for result in ("read", "refused", "failed"))
    print(
        f"{given.cases:,} cases: {told}; slowest {slowest * 1e3:.0f} ms, "
        f"{time.perf_counter() - begin:.0f} s in all"
    )
    return 1 if counts["failed"] else 0


if __name__ == "__main__":
    raise SystemExit(main())
