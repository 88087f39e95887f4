"""A ladder slides down a smooth wall onto a smooth floor, which press on it with their forces."""

from __future__ import annotations

from math import pi, sin

import mecanique as mq

m, l, g = (
    mq.Parameter("m", 10.0, "kg", "mass of the ladder"),
    mq.Parameter("l", 4.0, "m", "length of the ladder"),
    mq.Parameter("g", 9.81, "m/s²"),
)
LEAN = 0.3


def ladder() -> mq.Mechanism:
    upright = mq.Placement((0, 0, 0), (0, pi / 2, 0))
    return mq.Mechanism(
        "ladder",
        (mq.Body("ground"), mq.Body("ladder", mq.rod(m, l, direction=(0, 0, 1)))),
        (mq.Planar("plane", "ground", "ladder", axis=(0, -1, 0), names=("x", "z", "theta")),),
        parameters=(m, l, g),
        gravity=(0, 0, -g),
        switching=(
            mq.Contact("floor", "ladder", center=(0, 0, 0)),
            mq.Contact("wall", "ladder", center=(0, 0, l), plane=upright),
        ),
    )


def main() -> None:
    print(mq.derive_modes(ladder()).text())
    start = {"x": 4.0 * sin(LEAN), "z": 0.0, "theta": LEAN}
    print(*mq.simulate(ladder(), q=start, duration=1.4).modes, sep="\n")
    mq.picture(ladder(), path="ladder.svg", q=start)


if __name__ == "__main__":
    main()
