"""A ladder slides down a smooth wall onto a smooth floor: the map holds both of its ends."""

from __future__ import annotations

import mecanique as mq

m, l, g = (
    mq.Parameter("m", 10.0, "kg", "mass of the ladder"),
    mq.Parameter("l", 4.0, "m", "length of the ladder"),
    mq.Parameter("g", 9.81, "m/s²"),
)


def ladder() -> mq.Mechanism:
    theta = mq.coordinate("theta")
    rod = mq.rod(m, l, direction=(0, 0, 1))
    return mq.Mechanism(
        "ladder",
        (mq.Body("ground"), mq.Body("foot"), mq.Body("ladder", rod)),
        (
            mq.Prismatic("floor", "ground", "foot", axis=(1, 0, 0), coordinate="x"),
            mq.Revolute("lean", "foot", "ladder", axis=(0, -1, 0), coordinate="theta"),
        ),
        coordinates=mq.Coordinates(("theta",), {"x": l * mq.sin(theta)}),
        parameters=(m, l, g),
        gravity=(0, 0, -g),
    )


def main() -> None:
    equations = mq.derive(ladder())
    print(equations.solved().accelerations["theta''"])
    mq.picture(ladder(), path="ladder.svg", q={"theta": 0.5})


if __name__ == "__main__":
    main()
