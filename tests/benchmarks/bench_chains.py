"""Rows of parallelograms that fall for 10 s through flat positions, against their closed form.

Run by hand: python tests/benchmarks/bench_chains.py [counts]. It prints the steps, the largest
error of the angle at rtol 1e-11, and the processor time for both choices of the tree: that of the
first motion, which derives and compiles the equations, and that of a second of the next one.
"""

from __future__ import annotations

import sys
from pathlib import Path
from time import process_time

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "reference"))

from reference_samples import parallelograms
from test_reference_metric import fall_of_parallelograms

import mecanique as mq

DURATION = 3.0
"""How long each falls [s]; it is flat three times."""


def main(counts: list[int]) -> None:
    print(f"{'links':>5}  {'tree':8}  {'steps':>5}  {'error':>8}  {'first s':>7}  {'s per s':>7}")
    for count in counts:
        for serial in (True, False):
            mechanism = parallelograms(count, serial=serial)
            rates = {
                joint.name: -1.0 if joint.child.startswith("up") else 1.0
                for joint in mechanism.joints
            }
            spent = []
            for _ in range(2):
                begin = process_time()
                motion = mq.simulate(mechanism, v=rates, duration=DURATION, samples=31, rtol=1e-11)
                spent.append(process_time() - begin)
            error = np.abs(motion["A0"] - fall_of_parallelograms(count, motion.t)).max()
            tree = "serial" if serial else "uprights"
            steps = motion.statistics.steps
            row = f"{count:5}  {tree:8}  {steps:5}  {error:8.1e}"
            print(f"{row}  {spent[0]:7.1f}  {spent[1] / DURATION:7.2f}", flush=True)


if __name__ == "__main__":
    main([int(count) for count in sys.argv[1:]] or [2, 10, 20, 40, 120])
