"""A pendulum on a pivot that is moved to and fro, x = A sin(W t)."""

from __future__ import annotations

import mecanique as mq

m, l, g = mq.Parameter("m", 1.0, "kg"), mq.Parameter("l", 0.8, "m"), mq.Parameter("g", 9.81, "m/s²")
A, W = mq.Parameter("A", 0.1, "m", "amplitude"), mq.Parameter("W", 3.0, "rad/s", "frequency")


def pendulum() -> mq.Mechanism:
    bob = mq.particle(m, at=(0, 0, -l))
    return mq.Mechanism(
        "moving_pivot",
        (mq.Body("ground"), mq.Body("pivot"), mq.Body("pendulum", mq.bar(l), bob)),
        (
            mq.Prismatic("slide", "ground", "pivot", axis=(1, 0, 0), coordinate="x"),
            mq.Revolute("pin", "pivot", "pendulum", axis=(0, -1, 0), coordinate="q"),
        ),
        coordinates=mq.Coordinates(("q",), {"x": A * mq.sin(W * mq.time())}),
        parameters=(m, l, g, A, W),
        gravity=(0, 0, -g),
    )


def main() -> None:
    print(mq.derive(pendulum()).solved())
    mq.picture(pendulum(), path="moving_pivot.svg", q={"q": 0.5})


if __name__ == "__main__":
    main()
