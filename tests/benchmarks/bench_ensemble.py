"""Ten thousand double pendulums for 10 s: `simulate_many` beside MuJoCo's threaded rollout. Run by hand.

    python tests/benchmarks/bench_ensemble.py [number of runs]

Starts are uniform in |q| ≤ 0.8 rad and |v| ≤ 0.5 rad/s. The worst error over all runs is against Taylor series at
1e-13. MuJoCo's rollout is slow, so it integrates 200 of the runs, and its time is scaled to all.
"""

from __future__ import annotations

import os
import platform
import sys
from collections.abc import Iterator
from importlib.util import find_spec
from time import perf_counter
from typing import Any

import numpy as np

import mecanique as mq

SPAN = 10.0
FEW = 200
SWEEPS: tuple[tuple[str, float], ...] = (("batch", 3e-8), ("batch", 1e-8), ("taylor", 1e-7), ("taylor", 1e-8))


def double() -> mq.Mechanism:
    """Two uniform rods m = 1, l = 1 by relative angles."""
    m, length, g = mq.Parameter("m", 1.0, "kg"), mq.Parameter("l", 1.0, "m"), mq.Parameter("g", 9.81, "m/s²")
    return mq.Mechanism(
        name="double",
        bodies=(mq.Body("ground"), mq.Body("rod1", mq.rod(m, length)), mq.Body("rod2", mq.rod(m, length))),
        joints=(
            mq.Revolute("pin1", "ground", "rod1", axis=(0, -1, 0), coordinate="q1"),
            mq.Revolute("pin2", "rod1", "rod2", axis=(0, -1, 0), origin=mq.Placement((0, 0, -length)), coordinate="q2"),
        ),
        parameters=(m, length, g),
        gravity=(0, 0, -g),
    )


def final(runs: mq.Runs) -> np.ndarray:
    """States at the end, shape (n, 4)."""
    return np.hstack([runs.q[:, -1], runs.v[:, -1]])


def rollout(q: np.ndarray, v: np.ndarray) -> Iterator[tuple[str, float, np.ndarray]]:
    """MuJoCo's rollout with RK4 on all processors: level, time [s], states at the end."""
    import mujoco
    from mujoco import rollout as threaded

    inertia = f'<inertial pos="0 0 -.5" mass="1" diaginertia="{1 / 12:.17g} {1 / 12:.17g} 1e-9"/>'
    hinge = '<joint type="hinge" axis="0 -1 0"/>'
    for step in (5e-3, 2.5e-3, 1.25e-3):
        text = (
            f'<mujoco><option timestep="{step}" integrator="RK4" gravity="0 0 -9.81"><flag contact="disable"/></option>'
            f'<worldbody><body>{hinge}{inertia}<body pos="0 0 -1">{hinge}{inertia}</body></body></worldbody></mujoco>'
        )
        model: Any = mujoco.MjModel.from_xml_string(text)
        threads = os.cpu_count() or 1
        data = [mujoco.MjData(model) for _ in range(threads)]
        start = np.hstack([np.zeros((len(q), 1)), q, v])
        with threaded.Rollout(nthread=threads) as pool:
            begin = perf_counter()
            states, _ = pool.rollout(model, data, start, nstep=round(SPAN / step))
            yield f"{step:g} s", perf_counter() - begin, states[:, -1, 1:5]


def main(count: int) -> None:
    """Print the table."""
    mechanism, random = double(), np.random.default_rng(0)
    q, v = random.uniform(-0.8, 0.8, (count, 2)), random.uniform(-0.5, 0.5, (count, 2))
    fast = bool(find_spec("heyoka"))
    goal = final(mq.simulate_many(mechanism, q, v, duration=SPAN, rtol=1e-13, method="taylor" if fast else "batch"))
    print(f"{platform.machine()}, {os.cpu_count()} processors, Python {platform.python_version()}; {count} runs")
    print(f"{'engine':<22}{'level':>10}{'time [s]':>12}{'worst error':>14}")
    for method, rtol in SWEEPS:
        if method == "taylor" and not fast:
            print("left out, not installed: heyoka")
            break
        times = []
        for _ in range(3):
            begin = perf_counter()
            end = final(mq.simulate_many(mechanism, q, v, duration=SPAN, rtol=rtol, method=method))
            times.append(perf_counter() - begin)
        print(f"{'mecanique ' + method:<22}{rtol:>10.0e}{np.median(times):>12.2f}{np.abs(end - goal).max():>14.1e}")
    if not find_spec("mujoco"):
        print("left out, not installed: mujoco")
        return
    few = min(FEW, count)
    for level, seconds, end in rollout(q[:few], v[:few]):
        error = np.abs(end - goal[:few]).max()
        print(f"{'MuJoCo rollout RK4':<22}{level:>10}{seconds * count / few:>12.2f}{error:>14.1e}", flush=True)


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 10_000)
