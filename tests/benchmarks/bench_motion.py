"""Motions by mecanique and its peers, side by side in one run, at equal final error. By hand.

    python tests/benchmarks/bench_motion.py [system or table …]

Systems: pendulum double cart_pole five twenty panda. Tables: growth ensemble energy. All of them by
default, in some minutes.

Of each system, every engine integrates 10 s (Panda: 1 s) from the same start, at a ladder of
tolerances or steps. The first level counts whose final error (the largest of all coordinates and
velocities, against Taylor series in long doubles, or dop853 at the least tolerance) is at most
1e-10 (Panda: 1e-9). These levels then run in turns. Times are medians of the processor's time,
which other work on the machine disturbs less, without building, which is listed beside them; ratios
are medians over the turns, to the package's default path: what method "auto" does when it is called
again without heyoka. Peers that are not installed are left out and named: pip install mujoco exudyn
pydy drake heyoka. Set OPENBLAS_NUM_THREADS=1 where other work disturbs."""

from __future__ import annotations

import gc
import os
import platform
import sys
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from importlib.metadata import PackageNotFoundError, version
from importlib.util import find_spec
from time import perf_counter, process_time

import numpy as np
from motion_peers import PEERS, SCIPY, TOLERANCES, Level
from motion_systems import Case, cases, chain, exact

import mecanique as mq
from mecanique.motion.simulation.choice import SMALL

TURNS = 9
LONGEST = 4.0
"""An engine is not asked for more accuracy than it reaches in this time [s]."""
AT_ONCE = 0.01
"""Short runs are repeated for so long, so that all are warm [s]."""

TAYLOR = "mecanique taylor"
TABLES = ("growth", "ensemble", "energy")
FAST = bool(find_spec("heyoka"))


def mecanique(case: Case) -> Iterator[Level]:
    """The package itself, by its methods."""
    methods = ["closed_form", "dop853"] if case.mechanism.nv <= SMALL else ["dop853"]
    if FAST and case.mechanism.nv <= 5:
        methods.append("taylor")
    for method in methods:
        for rtol in TOLERANCES:
            yield Level(f"mecanique {method}", f"{rtol:.0e}", *built(case, method, rtol))


def built(case: Case, method: str, rtol: float) -> tuple[float, Callable[[], np.ndarray]]:
    """The time to build from nothing [s], and the run."""
    if method == "taylor":
        import heyoka

        heyoka.llvm_state.clear_memcache()
        heyoka.llvm_state.set_diskcache_enabled(False)
    begin = process_time()
    mechanism = case.mechanism.replace()
    again = partial(
        mq.simulate,
        mechanism,
        q=case.q,
        rtol=rtol,
        method=method,
        reference=mq.Reference(mechanism),
    )
    again(duration=1e-3, samples=2)
    build = process_time() - begin

    def run() -> np.ndarray:
        motion = again(duration=case.span, samples=2)
        return np.concatenate([motion.q[-1], motion.v[-1]])

    return build, run


def accurate(case: Case, goal: np.ndarray) -> dict[str, tuple[float, Level]]:
    """Return each engine's first level that is accurate enough, else its most accurate one."""
    best: dict[str, tuple[float, Level]] = {}
    given_up: set[str] = set()
    for title, (module, engine) in {
        "mecanique": ("mecanique", mecanique),
        **SCIPY,
        **PEERS,
    }.items():
        if not find_spec(module):
            continue
        try:
            for level in engine(case):
                if level.engine in given_up or (
                    level.engine in best and best[level.engine][0] <= case.error
                ):
                    continue
                begin = process_time()
                error = float(np.abs(level.run() - goal).max())
                if process_time() - begin > LONGEST:
                    given_up.add(level.engine)
                if error < best.get(level.engine, (np.inf, level))[0]:
                    best[level.engine] = error, level
        except Exception as trouble:  # a peer's failure is told, and must not end the comparison
            print(f"{title:<26}failed: {type(trouble).__name__}: {str(trouble)[:150]}")
    return best


def in_turns(runs: Sequence[Callable[[], object]]) -> np.ndarray:
    """Times of one call each [s], shape (turns, runs)."""
    once = [seconds(run) for run in runs]
    rows = [
        # what takes a second is measured well enough by one run
        [
            took if took > 1 else seconds(run, 1 + int(AT_ONCE / took))
            for run, took in zip(runs, once, strict=True)
        ]
        for _ in range(TURNS)
    ]
    return np.array(rows)


def seconds(run: Callable[[], object], repeats: int = 1) -> float:
    """Processor time of one call, over some calls in a row."""
    begin = process_time()
    for _ in range(repeats):
        run()
    return (process_time() - begin) / repeats


def compare(case: Case) -> None:
    """Print the table of one system."""
    print(f"\n{case.name}, {case.span:g} s, error at most {case.error:g}")
    print(
        f"{'engine':<26}{'level':>12}{'time [ms]':>12}{'error':>10}{'build [ms]':>12}{'ratio':>10}"
    )
    best = accurate(case, exact(case))
    reached = [name for name, (error, _) in best.items() if error <= case.error]
    warming = optimize(best[TAYLOR][1].run) if TAYLOR in reached else (0.0, 0, 0.0)
    times = in_turns([best[name][1].run for name in reached])
    for k, name in enumerate(reached):
        error, level = best[name]
        to_first, middle = np.median(times[:, k] / times[:, 0]), np.median(times[:, k]) * 1e3
        print(
            f"{name:<26}{level.level:>12}{middle:>12.3f}{error:>10.1e}"
            f"{level.build * 1e3:>12.1f}{to_first:>10.3f}"
        )
    for name, (error, level) in best.items():
        if name not in reached:
            print(
                f"{name:<26}{level.level:>12}{'not reached':>12}{error:>10.1e}"
                f"{level.build * 1e3:>12.1f}"
            )

    def ratio(one: str, other: str) -> str:
        k, j = reached.index(one), reached.index(other)
        return f"{np.median(times[:, k] / times[:, j]):.3g}"

    if not reached or not reached[0].startswith("mecanique"):
        return
    default, fast = reached[0], TAYLOR
    bare = [
        name
        for name in reached
        if " + dop853" in name or (" + odeint" in name and "PyDy" not in name)
    ]
    others = [name for name in reached if not name.startswith("mecanique") and name not in bare]
    if bare:
        first = min(bare, key=lambda name: float(np.median(times[:, reached.index(name)])))
        print(f"default path over the best bare combination ({first}): {ratio(default, first)}")
    for name in others:
        line = f"default path over {name}: {ratio(default, name)}"
        if fast in reached:
            line += f"; {name} over taylor: {ratio(name, fast)}"
        print(line)
    if fast in reached:
        told = f"build and one run: taylor {(best[fast][1].build + warming[0]) * 1e3:.1f} ms"
        if "MuJoCo RK4" in reached:
            rival = best["MuJoCo RK4"][1].build + float(
                np.median(times[:, reached.index("MuJoCo RK4")])
            )
            told += f", MuJoCo {rival * 1e3:.1f} ms"
        print(
            f"{told}; taylor is optimized after {warming[1]} runs, which takes "
            f"{warming[2] * 1e3:.0f} ms"
        )


def optimize(run: Callable[[], object]) -> tuple[float, int, float]:
    """Run Taylor series until optimized: time of a run before [s], runs, time it takes [s]."""
    took = [seconds(run) for _ in range(3)]
    usual = float(np.median(took))
    while took[-1] < max(10 * usual, 0.015) and len(took) < 2000:
        took.append(seconds(run))
    return usual, len(took), took[-1]


def growth() -> None:
    """Print what 10 s of chains of n rods cost, and the exponents of n."""
    gc.collect()
    gc.freeze()  # what other engines left behind would be looked through again and again
    print(
        f"\ngrowth with the length of a chain, 10 s at rtol 1e-10\n{'n':>4}"
        f"{'default [ms]':>14}{'steps':>8}",
        end="",
    )
    print(f"{'µs a step':>11}{'fast [ms]':>12}{'steps':>8}{'µs a step':>11}{'build [ms]':>12}")
    rows: list[tuple[float, ...]] = []
    for n in (1, 2, 3, 4, 5, 6, 8, 12, 20, 40):
        mechanism = chain(n)
        case, reference = Case("chain", mechanism, np.full(n, 0.4 / n)), mq.Reference(mechanism)
        build, run = built(case, "taylor", 1e-10) if FAST and n <= 8 else (np.nan, None)

        def default(
            mechanism: mq.Mechanism = mechanism,
            q: np.ndarray = case.q,
            engine: mq.Reference = reference,
        ) -> mq.Motion:
            return mq.simulate(
                mechanism, q=q, rtol=1e-10, method="dop853", samples=2, reference=engine
            )

        if run is not None:
            optimize(run)
        times = np.median(in_turns([default] if run is None else [default, run]), axis=0)
        steps = default().statistics.steps
        quick = np.nan if run is None else times[1]
        fewer = np.nan
        if run is not None:
            fewer = mq.simulate(
                mechanism, q=case.q, rtol=1e-10, method="taylor", samples=2
            ).statistics.steps
        rows.append((n, times[0], steps, times[0] / steps, quick, fewer, quick / fewer, build))
        print(f"{n:>4}{times[0] * 1e3:>14.2f}{steps:>8}{times[0] / steps * 1e6:>11.1f}", end="")
        if run is not None:
            print(
                f"{quick * 1e3:>12.3f}{fewer:>8}{quick / fewer * 1e6:>11.2f}{build * 1e3:>12.1f}",
                end="",
            )
        print(flush=True)
    table = np.array(rows)
    parts = {"1…8": table[:, 0] <= 8, "5…40": table[:, 0] >= 5}
    for name, column, part in (
        ("default", 1, "1…8"),
        ("default", 1, "5…40"),
        ("default, a step", 3, "1…8"),
        ("default, a step", 3, "5…40"),
        ("fast", 4, "1…8"),
        ("fast, a step", 6, "1…8"),
        ("fast, build", 7, "1…8"),
    ):
        some = table[parts[part]]
        if np.isfinite(some[:, column]).all():
            print(
                f"exponent of n for n = {part}, {name}: {exponent(some[:, 0], some[:, column]):.2f}"
            )


def ensemble() -> None:
    """Print what many double pendulums cost, and the exponents of their number."""
    print("\ngrowth with the number of runs, double pendulums, 10 s at rtol 3e-8")
    methods = ["batch", "taylor"] if FAST else ["batch"]
    print(f"{'runs':>8}" + "".join(f"{method + ' [s]':>14}" for method in methods))
    mechanism, random, rows = chain(2), np.random.default_rng(0), []
    for count in (10, 100, 1000, 10_000, 40_000):
        q = random.uniform(-0.8, 0.8, (count, 2))
        for method in methods:
            mq.simulate_many(mechanism, q[:1], duration=0.01, rtol=3e-8, method=method)
        times = [
            np.median(
                [
                    seconds(partial(mq.simulate_many, mechanism, q, rtol=3e-8, method=m))
                    for _ in range(3)
                ]
            )
            for m in methods
        ]
        rows.append((count, *times))
        print(f"{count:>8}" + "".join(f"{took:>14.3f}" for took in times), flush=True)
    table = np.array(rows)
    for k, method in enumerate(methods, 1):
        print(
            f"exponent of the number of runs, {method}: {exponent(table[:, 0], table[:, k]):.2f}",
            end="",
        )
        print(f"; from 1000 on: {exponent(table[2:, 0], table[2:, k]):.2f}")


def exponent(x: np.ndarray, y: np.ndarray) -> float:
    """Slope of a straight line through logarithms."""
    return float(np.polyfit(np.log(x), np.log(y), 1)[0])


def energy() -> None:
    """Print how the energy of the pendulum drifts over 1,000 s, and what that costs."""
    print("\nthe pendulum over 1,000 s: relative drift of its energy at all samples and steps")
    print(f"{'method':<14}{'rtol':>8}{'drift':>10}{'steps':>8}{'evaluations':>13}{'time [s]':>10}")
    for method in ("dop853", "closed_form", "taylor") if FAST else ("dop853", "closed_form"):
        for rtol in (1e-8, 1e-10, 1e-12):
            motion = mq.simulate(chain(1), q=[2.0], duration=1000.0, rtol=rtol, method=method)
            total = np.concatenate([motion.energy().total, motion.energy(motion.curve.t).total])
            drift, s = np.abs(total / total[0] - 1).max(), motion.statistics
            print(
                f"{method:<14}{rtol:>8.0e}{drift:>10.1e}{s.steps:>8}{s.evaluations:>13}{s.seconds:>10.2f}",
                flush=True,
            )


def main(wanted: list[str]) -> None:
    """Print the tables."""
    unknown = set(wanted) - {case.name for case in cases()} - set(TABLES)
    if unknown:
        sys.exit(
            f"expected systems or tables "
            f"({', '.join([*(c.name for c in cases()), *TABLES])}), got {unknown}"
        )
    begin = perf_counter()
    print(
        f"{platform.processor() or platform.machine()}, {os.cpu_count()} processors, {versions()}"
    )
    engines = {**SCIPY, **PEERS, "heyoka": ("heyoka", None)}
    for title in [title for title, (module, _) in engines.items() if not find_spec(module)]:
        print(f"left out, not installed: {title}")
    for case in cases():
        if not wanted or case.name in wanted:
            compare(case)
    for table in (growth, ensemble, energy):
        if not wanted or table.__name__ in wanted:
            table()
    print(f"\n{perf_counter() - begin:.0f} s in all")


def versions() -> str:
    """Versions of Python and of what is compared."""
    found = [f"Python {platform.python_version()}"]
    for name in (
        "mecanique",
        "numpy",
        "scipy",
        "sympy",
        "pin",
        "heyoka",
        "pydy",
        "mujoco",
        "exudyn",
        "drake",
    ):
        try:
            found.append(f"{name} {version(name)}")
        except PackageNotFoundError:
            continue
    return ", ".join(found)


if __name__ == "__main__":
    main(sys.argv[1:])
