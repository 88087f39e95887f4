"""An ensemble: double pendulums that start almost alike, and when they have forgotten it.

With `executor=` a process pool, or Dask's `Client(...).get_executor()`, processes or machines share the runs.
"""

from __future__ import annotations

import numpy as np

import mecanique as mq


def main() -> None:
    pendulum = mq.textbook.load("double_pendulum")
    starts = np.full((50, 2), 2.6)
    starts[:, 0] += 1e-6 * np.random.default_rng(0).normal(size=50)
    times = np.arange(0.0, 20.1, 4.0)
    runs = mq.simulate_many(pendulum, q=starts, duration=20.0, samples=times)
    for t, angles in zip(times, np.moveaxis(runs["q1"], -1, 0), strict=True):
        print(f"t = {t:4.1f} s: they differ by {np.ptp(angles):.1e} rad")


if __name__ == "__main__":
    main()
