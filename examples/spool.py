"""A spool on rough ground, pulled by a thread that leaves its core below: it follows the pull."""

from __future__ import annotations

import mecanique as mq

m, R, c = (mq.Parameter(*p) for p in (("m", 1.0, "kg"), ("R", 0.3, "m"), ("c", 0.2, "m")))
F, J, g = mq.Parameter("F", 2.0, "N"), mq.Parameter("J", 0.1, "kg·m²"), mq.Parameter("g", 9.81)


def spool() -> mq.Mechanism:
    across = mq.Placement(rpy=(1.5707963267948966, 0, 0))
    rim, core = (mq.Visual(mq.Cylinder(radius, 0.1), across) for radius in (R, c))
    wheel = mq.Shape(m, inertia=(J / 2, J, J / 2, 0, 0, 0), visuals=(rim, core))
    return mq.Mechanism(
        "spool",
        (*map(mq.Body, ("ground", "along", "center")), mq.Body("spool", wheel)),
        (
            mq.Prismatic("slide", "ground", "along", axis=(1, 0, 0), coordinate="x"),
            mq.Prismatic("lift", "along", "center", axis=(0, 0, 1), coordinate="z"),
            mq.Revolute("roll", "center", "spool", axis=(0, 1, 0), coordinate="turn"),
        ),
        forces=(
            mq.Force("pull", "center", (0, 0, 0), (F, 0, 0)),
            mq.JointForce("lever", "roll", -F * c),
        ),
        parameters=(m, R, c, F, J, g),
        gravity=(0, 0, -g),
        contacts=(mq.Rolling("ground_contact", "spool", R),),
    )


def main() -> None:
    print(mq.derive(spool()).solved())
    mq.picture(spool(), path="spool.svg", q={"x": 0.5, "z": 0.3})


if __name__ == "__main__":
    main()
