"""A particle slides on a smooth curve z = a x²: the map keeps it there."""

from __future__ import annotations

import mecanique as mq

m, a, g = (
    mq.Parameter("m", 1.0, "kg"),
    mq.Parameter("a", 0.5, "1/m", "half the curvature at the bottom"),
    mq.Parameter("g", 9.81, "m/s²"),
)


def particle() -> mq.Mechanism:
    return mq.Mechanism(
        "curve",
        (mq.Body("ground"), mq.Body("carriage"), mq.Body("particle", mq.particle(m))),
        (
            mq.Prismatic("along", "ground", "carriage", axis=(1, 0, 0), coordinate="x"),
            mq.Prismatic("up", "carriage", "particle", axis=(0, 0, 1), coordinate="z"),
        ),
        coordinates=mq.Coordinates(("x",), {"z": a * mq.coordinate("x") ** 2}),
        parameters=(m, a, g),
        gravity=(0, 0, -g),
    )


def main() -> None:
    print(mq.derive(particle()).solved().accelerations["x''"])
    motion = mq.simulate(particle(), q={"x": 1.0}, duration=5.0)
    print(motion.audit()["energy"])
    mq.picture(motion, path="curve.svg")


if __name__ == "__main__":
    main()
