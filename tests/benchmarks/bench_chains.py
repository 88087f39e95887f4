"""Rows of parallelograms that fall for 10 s through flat positions, against their closed form.

Run by hand: python tests/benchmarks/bench_chains.py [counts]. It prints the steps, the largest
error of the angle at rtol 1e-10 and the processor time, for both choices of the tree.
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


def main(counts: list[int]) -> None:
    print(f"{'links':>5}  {'tree':8}  {'steps':>5}  {'error':>8}  {'CPU s':>6}")
    for count in counts:
        for serial in (True, False):
            mechanism = parallelograms(count, serial=serial)
            rates = {
                joint.name: -1.0 if joint.child.startswith("up") else 1.0
                for joint in mechanism.joints
            }
            begin = process_time()
            motion = mq.simulate(mechanism, v=rates, duration=10.0, samples=101)
            spent = process_time() - begin
            error = np.abs(motion["A0"] - fall_of_parallelograms(count, motion.t)).max()
            tree = "serial" if serial else "uprights"
            steps = motion.statistics.steps
            print(f"{count:5}  {tree:8}  {steps:5}  {error:8.1e}  {spent:6.1f}", flush=True)


if __name__ == "__main__":
    main([int(count) for count in sys.argv[1:]] or [2, 10, 20, 40])
