"""Measure closed mechanisms: agreement, time per acceleration, drift and energy over 100 s.

Run it by hand: OPENBLAS_NUM_THREADS=1 python tests/benchmarks/bench_loops.py With more threads,
decompositions of matrices from about 60 rows on wait for each other, a hundredfold on busy cores.
"""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np

from mecanique import textbook
from mecanique.model.mechanism import Mechanism
from mecanique.motion import simulate
from mecanique.reference import Reference, assemble
from mecanique.verification import verify

CLOSED = [name for name in textbook.names() if textbook.load(name).loops]
CONSERVATIVE = (
    "bars_and_springs_loop",
    "slider_crank",
    "four_bar_linkage",
    "bricard_linkage",
    "governor",
    "chained_four_bars",
)
WINDOWS = (2, 5, 10, 20, 40, 70, 100)
"""2 n + 1 velocities; Pinocchio is given at most 210."""


def per_call(mechanism: Mechanism, q: np.ndarray) -> float:
    """Shortest mean time of the right-hand side over some rounds [s]."""
    rhs = Reference(mechanism).rhs()
    y = np.concatenate([q, np.zeros(mechanism.nv)])
    times = []
    for _ in range(5):
        count, begin = 0, time.perf_counter()
        while time.perf_counter() - begin < 0.1:
            rhs(0.0, y)
            count += 1
        times.append((time.perf_counter() - begin) / count)
    return min(times)


def agreement() -> None:
    """Print the worst relative difference of the accelerations, by way of derivation."""
    for name in CLOSED:
        verdict = verify(textbook.load(name), samples=30)
        rows = {row.sources[0]: row.worst for row in verdict.rows if row.quantity == "acceleration"}
        print(f"{name:24}", "  ".join(f"{way} {worst:.1e}" for way, worst in rows.items()))


def cost() -> None:
    """Print the time of an acceleration, closed and open, for more and more windows."""
    for name in CLOSED:
        mechanism = textbook.load(name)
        q = assemble(mechanism, textbook.entry(name).start)
        heavy = all(
            mechanism.evaluate(b.mass) for b in mechanism.bodies if b.name != mechanism.ground
        )
        text = (
            f"tree {per_call(replace(mechanism, loops=()), q) * 1e6:.0f} µs"
            if heavy
            else "tree is massless"
        )
        print(f"{name:24} closed {per_call(mechanism, q) * 1e6:.0f} µs, {text}")
    found = []
    for n in WINDOWS:
        mechanism = textbook.load("chained_four_bars", n=n)
        start = {f"theta{k}": 1.0 for k in range(n + 1)} | {
            f"phi{k}": -1.0 for k in range(1, n + 1)
        }
        q = assemble(mechanism, start)
        found.append(per_call(mechanism, q))
        alone = per_call(replace(mechanism, loops=()), q)
        print(
            f"{n:3} windows: {found[-1] * 1e3:.3f} ms per acceleration, {alone * 1e3:.3f} "
            f"ms for the tree"
        )
    for low, high in ((0, 2), (2, 6)):
        slope = np.polyfit(np.log(WINDOWS[low : high + 1]), np.log(found[low : high + 1]), 1)[0]
        print(f"exponent from {WINDOWS[low]} to {WINDOWS[high]} windows: {slope:.2f}")


def long_motions() -> None:
    """Print drift and energy error over 100 s, and over 0.1 s of the squeezer with its motor."""
    for name, duration in (*((name, 100.0) for name in CONSERVATIVE), ("squeezer", 0.1)):
        entry = textbook.entry(name)
        motion = simulate(
            entry.mechanism(),
            q=dict(entry.start),
            v=dict(entry.start_velocity),
            duration=duration,
            rtol=1e-10,
            fps=1000 / duration,
        )
        closed = motion.reference.closed
        assert closed is not None
        between = motion(np.linspace(0.0003, 0.999, 777) * duration)
        states = zip(between.q, between.v, np.atleast_1d(between.t), strict=True)
        worst = np.max([closed.drift(q, v, float(t)) for q, v, t in states], axis=0)
        energy = motion.energy()
        print(
            f"{name:24} drift {worst[0]:.1e} (positions) {worst[1]:.1e} (velocities), "
            f"energy {abs(energy.balance).max() / energy.scale:.1e}, "
            f"{motion.statistics.seconds:.1f} s, "
            f"{motion.statistics.steps} steps"
        )


if __name__ == "__main__":
    agreement()
    cost()
    long_motions()
