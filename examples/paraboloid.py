"""A particle slides on a smooth paraboloid z = a (x² + y²): the map keeps it on the surface."""

from __future__ import annotations

import mecanique as mq

m, a, g = (
    mq.Parameter("m", 1.0, "kg"),
    mq.Parameter("a", 0.5, "1/m", "half the curvature at the bottom"),
    mq.Parameter("g", 9.81, "m/s²"),
)


def particle() -> mq.Mechanism:
    rho = mq.coordinate("rho")
    return mq.Mechanism(
        "paraboloid",
        (*map(mq.Body, ("ground", "turning", "outwards")), mq.Body("particle", mq.particle(m))),
        (
            mq.Revolute("turn", "ground", "turning", axis=(0, 0, 1), coordinate="phi"),
            mq.Prismatic("out", "turning", "outwards", axis=(1, 0, 0), coordinate="rho"),
            mq.Prismatic("up", "outwards", "particle", axis=(0, 0, 1), coordinate="z"),
        ),
        coordinates=mq.Coordinates(("phi", "rho"), {"z": a * rho**2}),
        parameters=(m, a, g),
        gravity=(0, 0, -g),
    )


def main() -> None:
    print(mq.derive(particle()).solved())
    print(mq.routh(particle()))
    mq.picture(particle(), path="paraboloid.svg", q={"phi": 0.5, "rho": 0.6})


if __name__ == "__main__":
    main()
