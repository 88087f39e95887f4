"""Duffing's oscillator by its potential, and two bodies that attract each other."""

from __future__ import annotations

import mecanique as mq

m, k, b, G = (
    mq.Parameter("m", 2.0, "kg"),
    mq.Parameter("k", 1.0, "N/m"),
    mq.Parameter("b", 3.0, "N/m³"),
    mq.Parameter("G", 0.5, "N·m²/kg²"),
)
x = mq.coordinate("x")


def mechanism(name: str, *forces: mq.AnyForce) -> mq.Mechanism:
    bodies = (mq.Body("ground"), *(mq.Body(n, mq.particle(m)) for n in ("block", "other")))
    slides = (("slide", "block", (1, 0, 0), "x"), ("lift", "other", (0, 0, 1), "z"))
    joints = tuple(
        mq.Prismatic(joint, "ground", body, axis=axis, coordinate=letter)
        for joint, body, axis, letter in slides
    )
    return mq.Mechanism(
        name, bodies, joints, forces=forces, parameters=(m, k, b, G), gravity=(0, 0, 0)
    )


def main() -> None:
    well = mq.Potential("well", "slide", b * x**4 / 4 - k * x**2 / 2)
    pull = mq.CentralForce(
        "pull", "block", (0, 0, 0), "other", (0, 0, 0), -G * m * m / mq.distance()
    )
    for system in (mechanism("duffing", well), mechanism("attraction", pull)):
        print(mq.derive(system).text(steps=True))
        print(mq.verify(system, samples=20))
    mq.picture(mechanism("attraction", pull), path="pull.svg", q={"x": 1.0, "z": 0.8})


if __name__ == "__main__":
    main()
