"""Measure closed mechanisms: agreement, time per acceleration, drift and energy over 100 s.

Run it by hand: OPENBLAS_NUM_THREADS=1 python tests/benchmarks/bench_loops.py [beside] With more
threads, decompositions of matrices from about 60 rows on wait for each other, a hundredfold on busy
cores. "beside" prints only the times of motions beside a KKT system written by hand (`BareKkt`),
all to the same error at the end: in processor time, with that of the C compiler, medians of three;
"first" with a mechanism that nothing was derived for yet, "again" with the same one.
"""

from __future__ import annotations

import resource
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from statistics import median

import numpy as np
from loops_peers import BareKkt

from mecanique import simulate_many, textbook
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
"""2 n + 1 velocities; Pinocchio is given at most 250."""


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


TARGET = 1e-9
"""Error at the end, in q relative to its size or one, at which times are compared."""

LADDER = 10.0 ** -np.arange(7.0, 13.01, 0.5)

BESIDE = (
    ("four_bar_linkage", 10.0, 10.0),
    ("slider_crank", 10.0, 10.0),
    ("bars_and_springs_loop", 10.0, 10.0),
    ("squeezer", 0.03, 1000.0),
)
"""System, duration [s] and rate of Baumgarte's terms [1/s]."""


def processor_time() -> float:
    """Time of this process and of those that it started and ended [s]."""
    used = (resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return sum(part.ru_utime + part.ru_stime for part in used)


def at_target(end: Callable[[float], np.ndarray], exact: np.ndarray) -> tuple[float, float, float]:
    """Return tolerance, error and median time of the loosest tolerance that meets the target."""
    for rtol in LADDER.tolist():
        begin = processor_time()
        found = end(rtol)
        times = [processor_time() - begin]
        error = float((np.abs(found - exact) / (1 + np.abs(exact))).max())
        if error <= TARGET:
            for _ in range(2):
                begin = processor_time()
                end(rtol)
                times.append(processor_time() - begin)
            return rtol, error, median(times)
    return float("nan"), error, float("nan")


def beside() -> None:
    """Print the times of motions beside a KKT system by hand."""
    for name, duration, damping in BESIDE:
        compare_with_hand(name, duration, damping)


def compare_with_hand(name: str, duration: float, damping: float) -> None:
    """Print the times of one system's motions."""
    entry = textbook.entry(name)
    kept = entry.mechanism()
    q = assemble(kept, dict(entry.start))
    start = np.concatenate([q, np.zeros(len(q))])
    bare = BareKkt(entry.mechanism(), damping)

    def move(mechanism: Mechanism, rtol: float, method: str = "auto") -> np.ndarray:
        motion = simulate(mechanism, q=q, duration=duration, rtol=rtol, samples=2, method=method)
        return np.asarray(motion.q[-1])

    exact = move(kept, 1e-14, "compiled")
    rtol, error, unit = at_target(
        lambda rtol: bare.integrate(start, duration, rtol)[: len(q)], exact
    )
    print(
        f"{name}: {duration:g} s to an error of {TARGET:g}; by hand {unit * 1e3:.0f} ms "
        f"(rtol {rtol:.0e}, error {error:.0e})"
    )
    for title, run in (
        ("simulate, first", lambda rtol: move(entry.mechanism(), rtol)),
        ("simulate, again", lambda rtol: move(kept, rtol)),
        ("compiled, again", lambda rtol: move(kept, rtol, "compiled")),
    ):
        rtol, error, spent = at_target(run, exact)
        print(
            f"    {title:16} {spent * 1e3:7.1f} ms, {spent / unit:6.3f} times as long "
            f"(rtol {rtol:.0e}, error {error:.0e})"
        )


def many() -> None:
    """Print how long 1,000 linkages take."""
    mechanism = textbook.load("four_bar_linkage")
    q = assemble(mechanism, dict(textbook.entry("four_bar_linkage").start))
    starts = q + np.random.default_rng(0).uniform(-0.2, 0.2, (1000, len(q)))
    begin, clock = processor_time(), time.perf_counter()
    runs = simulate_many(mechanism, starts, duration=10.0, rtol=1e-9)
    spent, passed = processor_time() - begin, time.perf_counter() - clock
    print(
        f"1,000 four-bar linkages over 10 s: {passed:.1f} s, of processors {spent:.1f} s, "
        f"{len(runs.failed)} failed"
    )


if __name__ == "__main__":
    beside()
    many()
    if "beside" not in sys.argv:
        agreement()
        cost()
        long_motions()
