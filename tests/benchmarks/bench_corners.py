"""Time of a stick-slip oscillator of many corners, against its smooth pieces one by one.

Prints seconds, switches, and the ratio.
"""

from __future__ import annotations

import sys
from dataclasses import replace
from time import perf_counter

import mecanique as mq
from mecanique.motion.motion import Motion


def build() -> mq.Mechanism:
    """Return a mass on a belt, tied by a spring."""
    bodies = mq.Body("ground"), mq.Body("block", mq.box(1.0, (0.1, 0.1, 0.1)))
    slide = mq.Prismatic("slide", "ground", "block", axis=(1, 0, 0), coordinate="x")
    spring = mq.JointSpring("spring", "slide", 100.0)
    belt = mq.Friction("belt", "slide", 0.2, 9.81, mu_static=0.4, speed=0.1)
    return mq.Mechanism("belt", bodies, (slide,), forces=(spring,), switching=(belt,))


def main(events: int) -> None:
    """Print the times for a number of corners."""
    mechanism = build()
    mq.simulate(mechanism, v={"x": 0.1}, duration=2.0, fps=1.0)  # imports, not counted
    duration = 0.3924 + 0.8008 * events / 2
    begin = perf_counter()
    motion: Motion = mq.simulate(mechanism, v={"x": 0.1}, duration=duration, fps=1.0)
    whole = perf_counter() - begin
    spring = mechanism.forces
    sliding = replace(mechanism, switching=(), forces=(*spring, mq.JointForce("f", "slide", 1.962)))
    resting = replace(mechanism, switching=(), forces=())
    begin = perf_counter()
    for span in motion.modes:
        state = motion(span.begin)
        smooth = resting if span.states["belt"] == "sticks" else sliding
        length = span.end - span.begin
        mq.simulate(smooth, q=state.q, v=state.v, duration=length, fps=1.0, method="dop853")
    pieces = perf_counter() - begin
    print(f"{len(motion.events)} corners: {whole:.2f} s, pieces {pieces:.2f} s")
    print(f"ratio {whole / pieces:.2f}; {motion.statistics.evaluations} evaluations")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 1000)
