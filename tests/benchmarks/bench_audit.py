"""Processor time of a motion's audit against that of its simulation.

    python tests/benchmarks/bench_audit.py [SYSTEM …] [--robots panda,ur3]

Each motion is simulated and audited twice, each time with a mechanism made anew: the first time
of a system, and again. Without names it takes the whole catalogue and some robots that fall from
rest. The share that the law itself costs is not hidden: both times are printed. Goal: a ratio of
at most 3.
"""

from __future__ import annotations

import argparse
import time

import mecanique as mq

GOAL = 3.0

ROBOTS = ("panda", "ur5_robot", "solo12", "go1", "hyq_no_sensors", "talos_full_v2", "tiago_pro")


def main() -> None:
    """Print a line for each motion, and how many meet the goal."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("systems", nargs="*")
    parser.add_argument("--robots", default="")
    arguments = parser.parse_args()
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
