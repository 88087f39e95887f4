"""Clutch that slips until it locks.

A shaft with inertia J_1 drives another with J_2, each a disk of radius R, through plates that
transmit at most the torque T. The generalized coordinates are the angle p of the first shaft and
the slip s of the second against it. From the slip w they are locked after w/(T (1/J_1 + 1/J_2)).
"""

from mecanique import model as mq
from mecanique.textbook import System, facts

J_1 = mq.Parameter("J_1", 0.5, "kg·m²", "inertia of the driving shaft")
J_2 = mq.Parameter("J_2", 0.2, "kg·m²", "inertia of the driven shaft")
T = mq.Parameter("T", 3.0, "N·m", "torque at which the plates slip")
R = mq.Parameter("R", 0.3, "m", "radius of the disks")

mechanism = mq.Mechanism(
    name="clutch",
    bodies=(
        mq.Body("ground"),
        mq.Body("drive", mq.disk(2 * J_1 / R**2, R)),
        mq.Body("load", mq.disk(2 * J_2 / R**2, R)),
    ),
    joints=(
        mq.Revolute("shaft", "ground", "drive", coordinate="p"),
        mq.Revolute("clutch", "drive", "load", coordinate="s"),
    ),
    parameters=(J_1, J_2, T, R),
    gravity=(0, 0, 0),
    switching=(mq.Friction("plates", "clutch", 1.0, T),),
)


SYSTEM = System(
    title="Clutch that slips until it locks",
    source="Shigley, Mechanical Engineering Design, sect. 16-1",
    build=mechanism,
    start_velocity={"p": 40.0, "s": -40.0},
    duration=3.0,
    tags=("friction", "corners"),
    facts=(
        facts.ModeAcceleration(
            "p'' = -T/J_1, s'' = T (1/J_1 + 1/J_2) where the load lags",
            ("slips -",),
            lambda s: [-s.T / s.J_1, s.T * (1 / s.J_1 + 1 / s.J_2)],
        ),
        facts.Occurs(
            "it locks after w/(T (1/J_1 + 1/J_2)), at J_1 w/(J_1 + J_2)",
            "plates: sticks",
            lambda s: {
                "t": 40 / (s.T * (1 / s.J_1 + 1 / s.J_2)),
                "p'": 40 * s.J_1 / (s.J_1 + s.J_2),
            },
        ),
    ),
)
