"""How often the search for causes names a mistake that was put in on purpose. Run by hand.

    python tests/benchmarks/bench_causes.py [NUMBER [SEED]]

Each kind of mistake is put into textbook systems and robots in turn, 200 times in all; the states
and amounts are random with fixed seeds (NUMBER SEED to choose others). "first" counts mistakes
whose kind and place are ranked first, "alike" those that are named among what cannot be told apart
from the first."""

from __future__ import annotations

import sys
from collections import Counter
from pathlib import Path
from time import perf_counter

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1] / "verify"))

from verification_injections import INJECTIONS, Injection, seen

import mecanique as mq
from mecanique.verification.causes.search import causes_of
from mecanique.verification.verdict import LikelyCause

SYSTEMS = (
    "double_pendulum",
    "cart_pole",
    "two_link_arm",
    "furuta_pendulum",
    "crane",
    "acrobot",
    "coupled_pendulums",
)
ROBOTS = (
    ("panda", "fixed"),
    ("ur5_robot", "fixed"),
    ("bolt", "floating"),
    ("kinova", "fixed"),
    ("solo12", "floating"),
    ("z1", "fixed"),
    ("a1", "fixed"),
    ("so100", "floating"),
    ("iris", "floating"),
    ("simple_humanoid", "fixed"),
    ("talos_reduced", "fixed"),
    ("panda", "floating"),
)


def models() -> list[mq.Mechanism]:
    """The sound models."""
    robots = [
        mq.read_urdf(mq.robot(name), root="floating" if root == "floating" else "fixed")
        for name, root in ROBOTS
    ]
    systems = [*map(mq.textbook.load, SYSTEMS), *robots[: len(robots) - len(SYSTEMS)]]
    return [mechanism for pair in zip(robots, systems, strict=True) for mechanism in pair]


def is_named(cause: LikelyCause, injection: Injection) -> bool:
    """Whether a cause is the mistake that was made."""
    return cause.kind == injection.kind and cause.where in (injection.where, "")


def main(number: int = 200, seed: int = 1000) -> None:
    """Make the mistakes and print the table."""
    sound, kinds = models(), list(INJECTIONS)
    tried, first, alike, times = Counter[str](), Counter[str](), Counter[str](), list[float]()
    turn = dict.fromkeys(kinds, 0)
    count = 0
    while count < number:
        kind = kinds[count % len(kinds)]
        rng = np.random.default_rng(seed + count)
        found = None
        while found is None:
            model = sound[turn[kind] % len(sound)]
            turn[kind] += 1
            for injection in INJECTIONS[kind](model, rng):
                found = seen(injection, count)
                if found is not None:
                    break
        states, theirs = found
        start = perf_counter()
        causes = causes_of(injection.ours, states, theirs)
        times.append(perf_counter() - start)
        tried[kind] += 1
        count += 1
        if causes and is_named(causes[0], injection):
            first[kind] += 1
        elif causes and any(is_named(cause, injection) for cause in causes[0].alike):
            alike[kind] += 1
            print(
                f"alike: {kind}, {injection.where} of {model.name}: {causes[0].kind}: "
                f"{causes[0].text}"
            )
        else:
            said = str(causes[0]) if causes else "no cause"
            print(f"missed: {kind}, {injection.where} of {model.name}: {said}", flush=True)
    print(f"{'kind':18} tried first alike")
    for kind in kinds:
        print(f"{kind:18} {tried[kind]:5} {first[kind]:5} {alike[kind]:5}")
    total, named = sum(tried.values()), sum(first.values())
    print(f"{'all':18} {total:5} {named:5} {sum(alike.values()):5}")
    print(f"{named / total:.1%} first, {(named + sum(alike.values())) / total:.1%} first or alike")
    print(f"time of one search: median {np.median(times):.2f} s, most {max(times):.2f} s")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
