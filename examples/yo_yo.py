"""A yo-yo falls as its thread unwinds: by the coordinate map, and by a cord with its tension."""

from __future__ import annotations

import mecanique as mq

m, r = mq.Parameter("m", 0.2, "kg"), mq.Parameter("r", 0.04, "m", "radius that the thread leaves")
l, g = mq.Parameter("l", 0.1, "m", "length of the thread at y = 0"), mq.Parameter("g", 9.81, "m/s²")
UNWOUND = mq.Coordinates(("y",), {"phi": mq.coordinate("y") / r})
THREAD = mq.Cord("thread", ("ground", (0, 0, 0)), (mq.Pulley("disk", r),))  # wound on the disk


def yo_yo(*, cord: bool) -> mq.Mechanism:
    disk = mq.disk(m, r).at(rpy=(1.5707963267948966, 0, 0))
    below = mq.Placement((r, 0, -l))
    return mq.Mechanism(
        "yo_yo",
        (mq.Body("ground"), mq.Body("center"), mq.Body("disk", disk)),
        (
            mq.Prismatic("fall", "ground", "center", origin=below, axis=(0, 0, -1), coordinate="y"),
            mq.Revolute("spin", "center", "disk", axis=(0, 1, 0), coordinate="phi"),
        ),
        coordinates=mq.Coordinates(("y",)) if cord else UNWOUND,
        elements=(THREAD,) if cord else (),
        parameters=(m, r, l, g),
        gravity=(0, 0, -g),
    )


def main() -> None:
    print(mq.derive(yo_yo(cord=False)).solved())
    print(mq.Reference(yo_yo(cord=True)).guide_forces([0.0]))  # m (g - y'') = m g/3
    mq.picture(yo_yo(cord=True), path="yo_yo.svg", q={"y": 0.2})


if __name__ == "__main__":
    main()
