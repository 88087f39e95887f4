"""An ensemble on Dask: double pendulums that start almost alike, and when they have forgotten it.

The cluster is two processes here; `Client("scheduler:8786")` shares the runs among machines.
"""

from __future__ import annotations

import numpy as np

import mecanique as mq

try:
    from distributed import Client
except ImportError:
    raise SystemExit(
        "this example needs Dask; install it with: pip install 'mecanique[cluster]'"
    ) from None


def main() -> None:
    pendulum = mq.textbook.load("double_pendulum")
    starts = np.full((50, 2), 2.6)
    starts[:, 0] += 1e-6 * np.random.default_rng(0).normal(size=50)
    times = np.arange(0.0, 20.1, 4.0)
    with Client(n_workers=2, threads_per_worker=1, dashboard_address=None) as client:
        runs = mq.simulate_many(
            pendulum,
            q=starts,
            duration=20.0,
            samples=times,
            executor=client.get_executor(),
            chunk=25,
        )
    for t, angles in zip(times, np.moveaxis(runs["q1"], -1, 0), strict=True):
        print(f"t = {t:4.1f} s: they differ by {np.ptp(angles):.1e} rad")


# Dask starts processes that read this file again: only the first of them may start the cluster
if __name__ == "__main__":
    main()
