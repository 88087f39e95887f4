"""A closed loop: assemble a four-bar linkage, set it in motion and read its bearing forces."""

from __future__ import annotations

import numpy as np

import mecanique as mq


def main() -> None:
    linkage = mq.textbook.load("four_bar_linkage")
    start = mq.textbook.entry("four_bar_linkage").start
    print(mq.degrees_of_freedom(linkage, start))
    q = mq.assemble(linkage, start)
    print(
        ", ".join(
            f"{name} = {value:.4f}" for name, value in zip(linkage.coordinates, q, strict=True)
        )
    )
    motion = mq.simulate(linkage, q=dict(zip(linkage.coordinates, q, strict=True)), duration=2.0)
    for joint in linkage.joints:
        force = np.linalg.norm(motion.reactions(joint.name).force, axis=1)
        print(f"{joint.name}: at most {force.max():.2f} N")
    print(motion.audit())


if __name__ == "__main__":
    main()
