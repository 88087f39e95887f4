"""A yo-yo falls as its thread unwinds: the map keeps the disk from slipping on the thread."""

from __future__ import annotations

import mecanique as mq

m, r = mq.Parameter("m", 0.2, "kg"), mq.Parameter("r", 0.04, "m", "radius that the thread leaves")
g = mq.Parameter("g", 9.81, "m/s²")


def yo_yo() -> mq.Mechanism:
    disk = mq.disk(m, r).at(rpy=(1.5707963267948966, 0, 0))
    return mq.Mechanism(
        "yo_yo",
        (mq.Body("ground"), mq.Body("center"), mq.Body("disk", disk)),
        (
            mq.Prismatic("fall", "ground", "center", axis=(0, 0, -1), coordinate="y"),
            mq.Revolute("spin", "center", "disk", axis=(0, 1, 0), coordinate="phi"),
        ),
        coordinates=mq.Coordinates(("y",), {"phi": mq.coordinate("y") / r}),
        parameters=(m, r, g),
        gravity=(0, 0, -g),
    )


def main() -> None:
    print(mq.derive(yo_yo()).solved())  # the thread pulls with m (g - y'') = m g/3
    mq.picture(yo_yo(), path="yo_yo.svg", q={"y": 0.2})


if __name__ == "__main__":
    main()
