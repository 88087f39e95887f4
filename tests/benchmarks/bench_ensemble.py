"""Ten thousand double pendulums for 10 s: `simulate_many` beside MuJoCo's rollout. By hand.

    python tests/benchmarks/bench_ensemble.py [number of runs]

Starts are uniform in |q| ≤ 0.8 rad and |v| ≤ 0.5 rad/s. The worst error over all runs is against
Taylor series at 1e-13. MuJoCo's rollout is slow, so it integrates 100 of the runs, and its time is
scaled to all. All run in turns. Times are medians, by the clock and of all processors together;
ratios, of both, are to the fastest accurate rollout.
"""

from __future__ import annotations

import os
import platform
import sys
from collections.abc import Iterator
from importlib.util import find_spec
from time import perf_counter, process_time
from typing import Any

import numpy as np

import mecanique as mq

SPAN = 10.0
FEW = 100
TURNS = 3
ERROR = 1e-6
SWEEPS: tuple[tuple[str, float], ...] = (
    ("batch", 6e-8),
    ("batch", 3e-8),
    ("taylor", 1e-7),
    ("taylor", 1e-8),
)


def double() -> mq.Mechanism:
    """Two uniform rods m = 1, l = 1 by relative angles."""
    m, length, g = (
        mq.Parameter("m", 1.0, "kg"),
        mq.Parameter("l", 1.0, "m"),
        mq.Parameter("g", 9.81, "m/s²"),
    )
    return mq.Mechanism(
        name="double",
        bodies=(
            mq.Body("ground"),
            mq.Body("rod1", mq.rod(m, length)),
            mq.Body("rod2", mq.rod(m, length)),
        ),
        joints=(
            mq.Revolute("pin1", "ground", "rod1", axis=(0, -1, 0), coordinate="q1"),
            mq.Revolute(
                "pin2",
                "rod1",
                "rod2",
                axis=(0, -1, 0),
                origin=mq.Placement((0, 0, -length)),
                coordinate="q2",
            ),
        ),
        parameters=(m, length, g),
        gravity=(0, 0, -g),
    )


def final(runs: mq.Runs) -> np.ndarray:
    """States at the end, shape (n, 4)."""
    return np.hstack([runs.q[:, -1], runs.v[:, -1]])


def rollout(q: np.ndarray, v: np.ndarray) -> Iterator[tuple[str, tuple[float, float], np.ndarray]]:
    """MuJoCo's rollout with RK4 on all processors: level, times [s], states at the end."""
    import mujoco
    from mujoco import rollout as threaded

    inertia = f'<inertial pos="0 0 -.5" mass="1" diaginertia="{1 / 12:.17g} {1 / 12:.17g} 1e-9"/>'
    hinge = '<joint type="hinge" axis="0 -1 0"/>'
    for step in (4e-3, 2.5e-3, 2e-3):
        text = (
            f'<mujoco><option timestep="{step}" integrator="RK4" gravity="0 0 -9.81"><flag '
            f'contact="disable"/></option>'
            f'<worldbody><body>{hinge}{inertia}<body pos="0 0 -1">{hinge}{inertia}'
            f"</body></body></worldbody></mujoco>"
        )
        model: Any = mujoco.MjModel.from_xml_string(text)
        threads = os.cpu_count() or 1
        data = [mujoco.MjData(model) for _ in range(threads)]
        start = np.hstack([np.zeros((len(q), 1)), q, v])
        with threaded.Rollout(nthread=threads) as pool:
            begin = perf_counter(), process_time()
            states, _ = pool.rollout(model, data, start, nstep=round(SPAN / step))
            yield f"{step:g} s", since(begin), states[:, -1, 1:5]


def since(begin: tuple[float, float]) -> tuple[float, float]:
    """Time since then, by the clock and of all processors together [s]."""
    return perf_counter() - begin[0], process_time() - begin[1]


def main(count: int) -> None:
    """Print the table."""
    mechanism, random = double(), np.random.default_rng(0)
    q, v = random.uniform(-0.8, 0.8, (count, 2)), random.uniform(-0.5, 0.5, (count, 2))
    fast, few = bool(find_spec("heyoka")), min(FEW, count)
    goal = final(
        mq.simulate_many(
            mechanism, q, v, duration=SPAN, rtol=1e-13, method="taylor" if fast else "batch"
        )
    )
    print(
        f"{platform.machine()}, {os.cpu_count()} processors, Python "
        f"{platform.python_version()}; {count} runs"
    )
    for title, module in (("heyoka", "heyoka"), ("MuJoCo", "mujoco")):
        if not find_spec(module):
            print(f"left out, not installed: {title}")
    times: dict[tuple[str, str], list[tuple[float, ...]]] = {}
    errors: dict[tuple[str, str], float] = {}
    for _ in range(TURNS):
        for method, rtol in SWEEPS:
            if method == "taylor" and not fast:
                continue
            begin = perf_counter(), process_time()
            end = final(mq.simulate_many(mechanism, q, v, duration=SPAN, rtol=rtol, method=method))
            key = f"mecanique {method}", f"{rtol:.0e}"
            times.setdefault(key, []).append(since(begin))
            errors[key] = float(np.abs(end - goal).max())
        if find_spec("mujoco"):
            for level, seconds, end in rollout(q[:few], v[:few]):
                key = "MuJoCo rollout RK4", level
                times.setdefault(key, []).append(tuple(s * count / few for s in seconds))
                errors[key] = float(np.abs(end - goal[:few]).max())
    accurate = [
        np.array(times[key])
        for key in times
        if key[0].startswith("MuJoCo") and errors[key] <= ERROR
    ]
    rival = min(
        accurate, key=lambda rows: float(np.median(rows[:, 0])), default=np.full((TURNS, 2), np.nan)
    )
    print(
        f"{'engine':<22}{'level':>10}{'time [s]':>12}{'processors [s]':>16}"
        f"{'worst error':>14}{'MuJoCo over it':>18}"
    )
    for key, rows in times.items():
        clock, processors = np.median(rows, axis=0)
        ratios = "{:.1f}, {:.1f}".format(*np.median(rival / np.array(rows), axis=0))
        told = ratios if errors[key] <= ERROR else "not accurate"
        print(
            f"{key[0]:<22}{key[1]:>10}{clock:>12.2f}{processors:>16.2f}{errors[key]:>14.1e}{told:>18}"
        )


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 10_000)
