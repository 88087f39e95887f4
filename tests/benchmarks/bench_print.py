"""Processor time to derive and print planar chains, each on a fresh mechanism.

Run by hand: python tests/benchmarks/bench_print.py [times]. The first run of all is not counted.
"""

from __future__ import annotations

import sys
from dataclasses import replace
from time import process_time

import mecanique as mq


def build_chain(links: int) -> mq.Mechanism:
    """Equal particles on massless rods in a vertical plane, by the angles from rod to rod."""
    pendulum = mq.textbook.load("n_link_pendulum", n=links)
    angles = tuple(name for joint in pendulum.joints for name in joint.coordinates)
    return replace(pendulum, coordinates=mq.Coordinates(angles, {}))


def measure(links: int, *, relative: bool) -> tuple[float, int]:
    """Seconds to derive and print, and how many characters that gave."""
    mechanism = build_chain(links) if relative else mq.textbook.load("n_link_pendulum", n=links)
    begin = process_time()
    equations = mq.derive(mechanism)
    text = str(equations if equations.symbolic else mq.write_recursion(equations))
    return process_time() - begin, len(text)


def main(times: int) -> None:
    measure(3, relative=True)
    for links, relative in ((10, True), (12, False), (64, False)):
        runs = [measure(links, relative=relative) for _ in range(times)]
        spent, length = min(runs)
        angles = "from rod to rod" if relative else "from the vertical"
        print(f"{links:3} links, angles {angles}: {spent:5.2f} s, {length:,} characters")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 5)
