"""A crane's trolley carries two loads on ropes; a force F drives it."""

from __future__ import annotations

import mecanique as mq

M, l, g = mq.Parameter("M", 5.0, "kg"), mq.Parameter("l", 2.0, "m"), mq.Parameter("g", 9.81, "m/s²")
m1, m2 = mq.Parameter("m1", 1.0, "kg"), mq.Parameter("m2", 2.0, "kg")
F = mq.Input("F", 0.0, "N")


def crane() -> mq.Mechanism:
    loads = [
        mq.Body(f"load{k}", mq.bar(l), mq.particle(m, at=(0, 0, -l)))
        for k, m in enumerate((m1, m2), 1)
    ]
    ends = (mq.Placement((-0.4, 0, 0)), mq.Placement((0.4, 0, 0)))
    pins = [
        mq.Revolute(f"q{k}", "trolley", f"load{k}", axis=(0, -1, 0), origin=end)
        for k, end in enumerate(ends, 1)
    ]
    return mq.Mechanism(
        "two_loads",
        (mq.Body("ground"), mq.Body("trolley", mq.box(M, (1.0, 0.3, 0.2))), *loads),
        (mq.Prismatic("rail", "ground", "trolley", axis=(1, 0, 0), coordinate="x"), *pins),
        forces=(mq.JointForce("drive", "rail", F),),
        parameters=(M, l, g, m1, m2),
        inputs=(F,),
        gravity=(0, 0, -g),
    )


def main() -> None:
    print(mq.derive(crane()))
    mq.picture(crane(), path="two_loads.svg", q={"q1": 0.3, "q2": 0.5})


if __name__ == "__main__":
    main()
