"""Describe a mechanism, a block on a sprung slide, derive its equations and have them checked."""

from __future__ import annotations

import mecanique as mq


def block(m: float = 2.0, k: float = 50.0, c: float = 0.8) -> mq.Mechanism:
    mass, stiffness, damping = (
        mq.Parameter("m", m, "kg"),
        mq.Parameter("k", k, "N/m"),
        mq.Parameter("c", c, "N·s/m"),
    )
    return mq.Mechanism(
        name="block",
        bodies=(mq.Body("ground"), mq.Body("block", mq.box(mass, (0.3, 0.3, 0.3)))),
        joints=(mq.Prismatic("slide", "ground", "block", axis=(1, 0, 0), coordinate="x"),),
        forces=(
            mq.JointSpring("spring", "slide", stiffness),
            mq.JointDamper("damper", "slide", damping),
        ),
        parameters=(mass, stiffness, damping),
    )


def main() -> None:
    mechanism = block()
    print(mq.derive(mechanism))
    print(mq.verify(mechanism))
    motion = mq.simulate(mechanism, q={"x": 0.2}, duration=5.0)
    print(motion.summary())


if __name__ == "__main__":
    main()
