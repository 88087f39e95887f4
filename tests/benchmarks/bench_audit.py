"""Processor time of a motion's audit, and of every other question, against its simulation.

    python tests/benchmarks/bench_audit.py [SYSTEM …] [--robots panda,ur3] [--questions]

Each motion is simulated and audited twice, each time with a mechanism made anew: the first time
of a system, and again. Without names it takes the whole catalogue and some robots that fall from
rest. The share that the law itself costs is not hidden: both times are printed. Goal: a ratio of
at most 3.

With --questions all questions are asked of some long motions instead, each of a motion of its own:
medians of three ratios. Goal: at most 1, but for what the docstrings say takes longer.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from statistics import median

import mecanique as mq

GOAL = 3.0

ROBOTS = ("panda", "ur5_robot", "solo12", "go1", "hyq_no_sensors", "talos_full_v2", "tiago_pro")

LONG = {
    "kepler_orbit": (2000.0, 5000.0),
    "kapitza_pendulum": (20.0, 120.0, 1000.0),
    "double_pendulum": (300.0,),
    "four_bar_linkage": (300.0,),
    "rolling_coin": (200.0,),
    "atwood_machine": (1.9,),
}
"""How long the motions last of which all is asked [s]."""

TURNS = 3

FOLDER = Path(tempfile.mkdtemp())

Question = Callable[[mq.Motion], object]

QUESTIONS: dict[str, Question] = {
    "energy": lambda motion: motion.energy(),
    "losses": lambda motion: motion.losses(),
    "audit": lambda motion: motion.audit(),
    "summary": lambda motion: motion.summary(),
    "a": lambda motion: motion.a,
    "poses": lambda motion: motion.poses(),
    "velocity": lambda motion: motion.velocity(motion.mechanism.bodies[-1].name),
    "point": lambda motion: motion.point(motion.mechanism.bodies[-1].name),
    "reactions": lambda motion: motion.reactions(motion.mechanism.joints[-1].name),
    "guide forces": lambda motion: motion.guide_forces(),
    "states": lambda motion: motion(motion.t),
    "to_frame": lambda motion: motion.to_frame(),
    "to_csv": lambda motion: motion.to_csv(FOLDER / "motion.csv"),
    "to_parquet": lambda motion: motion.to_parquet(FOLDER / "motion.parquet"),
    "save": lambda motion: motion.save(FOLDER / "motion.npz"),
    "plot": lambda motion: motion.plot(),
    "plot energies": lambda motion: motion.plot("energies"),
    "plot reactions": lambda motion: motion.plot("reactions"),
    "picture": lambda motion: mq.picture(motion, float(motion.t[-1]), FOLDER / "motion.svg"),
    "export": lambda motion: mq.export(motion, FOLDER / "motion.html"),
}


def main() -> None:
    """Print a line for each motion, and how many meet the goal."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("systems", nargs="*")
    parser.add_argument("--robots", default="")
    parser.add_argument("--questions", action="store_true")
    arguments = parser.parse_args()
    if arguments.questions:
        _ask_all(arguments.systems or list(LONG))
        return
    robots = [name for name in arguments.robots.split(",") if name]
    if not arguments.systems and not robots:
        robots = list(ROBOTS)
    systems = arguments.systems or ([] if arguments.robots else list(mq.textbook.names()))
    # what the process imports once belongs to neither
    mq.simulate(mq.textbook.load("rigid_bar_pendulum"), q=[1.0], duration=0.1).audit()
    print(f"{'motion':34} {'simulate':>9} {'audit':>9} ratio  {'again':>9} {'audit':>9} ratio")
    rows = [_line(name, robot=False) for name in systems]
    rows += [_line(name, robot=True) for name in robots]
    for turn, which in enumerate(("first", "again")):
        met = sum(row[turn] <= GOAL for row in rows)
        worst = max(row[turn] for row in rows)
        print(f"{which}: {met} of {len(rows)} at most {GOAL:g}, worst {worst:.1f}")


def _ask_all(systems: list[str]) -> None:
    """Print what each question costs of each motion, in times that the motion took."""
    pendulum = mq.simulate(mq.textbook.load("rigid_bar_pendulum"), q=[1.0], duration=0.1)
    for ask in QUESTIONS.values():
        ask(pendulum)
    for name in systems:
        for duration in LONG.get(name, (mq.textbook.entry(name).duration,)):
            times = [_ask(ask, name, duration) for ask in QUESTIONS.values()]
            simulated = median(motion for motion, _ in times)
            print(f"{name}, {duration:g} s, simulated in {simulated * 1e3:.0f} ms")
            for question, (_, ratio) in zip(QUESTIONS, times, strict=True):
                print(f"    {question:16} {ratio:8.2f}{'  above 1' * (ratio > 1)}", flush=True)


def _ask(ask: Question, name: str, duration: float) -> tuple[float, float]:
    """The time of a motion [s], and that of a question in terms of it."""
    system, times, ratios = mq.textbook.entry(name), list[float](), list[float]()
    for _ in range(TURNS):
        mechanism, start = mq.textbook.load(name), time.process_time()
        motion = mq.simulate(mechanism, q=system.start, v=system.start_velocity, duration=duration)
        between = time.process_time()
        ask(motion)
        times.append(between - start)
        ratios.append((time.process_time() - between) / times[-1])
    return median(times), median(ratios)


def _line(name: str, *, robot: bool) -> tuple[float, float]:
    """Print the times of one motion; return both ratios."""
    ratios, cells = [], []
    for _ in range(2):
        mechanism = mq.read_urdf(mq.robot(name)) if robot else mq.textbook.load(name)
        system = None if robot else mq.textbook.entry(name)
        start = time.process_time()
        if system is None:
            motion = mq.simulate(mechanism, duration=2.0)
        else:
            motion = mq.simulate(
                mechanism, q=system.start, v=system.start_velocity, duration=system.duration
            )
        simulated = time.process_time() - start
        start = time.process_time()
        motion.audit()
        audited = time.process_time() - start
        ratios.append(audited / simulated)
        cells.append(f"{simulated * 1e3:7.1f}ms {audited * 1e3:7.1f}ms {ratios[-1]:5.1f}")
    print(f"{name:34} {cells[0]}  {cells[1]}", flush=True)
    return ratios[0], ratios[1]


if __name__ == "__main__":
    main()
