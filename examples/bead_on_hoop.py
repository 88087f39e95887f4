"""A bead slides on a smooth hoop that turns steadily about its vertical diameter."""

from __future__ import annotations

import mecanique as mq

m, R = mq.Parameter("m", 0.1, "kg"), mq.Parameter("R", 0.5, "m", "radius of the hoop")
W, g = mq.Parameter("W", 6.0, "rad/s", "rate of the hoop"), mq.Parameter("g", 9.81, "m/s²")
QUARTER = 1.5707963267948966


def bead_on_hoop() -> mq.Mechanism:
    ring = mq.ring(0.2, R, thickness=0.01).at(rpy=(QUARTER, 0, 0))
    bead = mq.Body("bead", mq.particle(m, (0, 0, -R)))
    return mq.Mechanism(
        "hoop",
        (mq.Body("ground"), mq.Body("hoop", ring), bead),
        (
            mq.Revolute("axle", "ground", "hoop", axis=(0, 0, 1), coordinate="turn"),
            mq.Revolute("slide", "hoop", "bead", axis=(0, -1, 0), coordinate="theta"),
        ),
        coordinates=mq.Coordinates(("theta",), {"turn": W * mq.time()}),
        parameters=(m, R, W, g),
        gravity=(0, 0, -g),
    )


def main() -> None:
    print(mq.derive(bead_on_hoop()).text(steps=True))  # Jacobi's integral, as the hoop is driven
    for rest in mq.equilibria(bead_on_hoop()):
        print(rest)
    mq.picture(bead_on_hoop(), path="bead_on_hoop.svg", q={"theta": 0.7})


if __name__ == "__main__":
    main()
