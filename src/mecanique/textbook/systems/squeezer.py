"""Andrews' squeezer.

Seven bodies in a plane, three of them on fixed pins: the crank K1 turns about the origin by beta,
driven by the constant torque mom; K2 is hinged to it and turns by theta relative to it, and its tip
P is pinned to three other bodies: K3, which turns by gamma about B and is held by a spring of
stiffness c0 and free length l0, K4, which turns by phi against K5, itself on A with the angle
delta, and K6, which turns by omega against K7, itself on A with the angle epsilon. Gravity is
neglected. The generalized coordinates are the seven angles; three loops at P leave one of them
free. Masses, inertias and lengths are the published ones. The plane is x-z, and the published y is
z here.
"""

from numpy import cos, hypot, sin, sqrt

from mecanique import model as mq
from mecanique.textbook import System, facts
from mecanique.textbook.joints import hinge

MASSES = (0.04325, 0.00365, 0.02373, 0.00706, 0.07050, 0.00706, 0.05498)
INERTIAS = (2.194e-6, 4.410e-7, 5.255e-6, 5.667e-7, 1.169e-5, 5.667e-7, 1.912e-5)
XA, YA, XB, YB, XC, YC = -0.06934, -0.00227, -0.03635, 0.03273, 0.014, 0.072
D, DA, E, EA, ZF, FA, RR, RA = 28e-3, 115e-4, 2e-2, 1421e-5, 2e-2, 1421e-5, 7e-3, 92e-5
SS, SA, SB, SC, SD, ZT, TA, TB = 35e-3, 1874e-5, 1043e-5, 18e-3, 2e-2, 4e-2, 2308e-5, 916e-5
U, UA, UB = 4e-2, 1228e-5, 449e-5
"""The published numbers (kg, kg·m², m); y of the plane is z here."""


mom = mq.Parameter("mom", 0.033, "N·m", "torque of the drive on K1")
c0 = mq.Parameter("c0", 4530.0, "N/m", "stiffness of the spring")
l0 = mq.Parameter("l0", 0.07785, "m", "free length of the spring")


def _piece(mass: float, inertia: float, center: tuple[float, float]) -> mq.Shape:
    """Return a flat piece in the x-z plane; only its inertia about y is published and matters."""
    return mq.Shape(
        mass, (center[0], 0.0, center[1]), (inertia / 2, inertia, inertia / 2, 0.0, 0.0, 0.0)
    )


centers = ((RA, 0), (-DA, 0), (SB, -SA), (0, EA - E), (TA, TB), (ZF - FA, 0), (-UB, -UA))
arms = (
    ((RR, 0),),
    ((-D, 0),),
    ((0, -SS), (SD, -SC)),
    ((0, -E),),
    ((ZT, 0),),
    ((ZF, 0),),
    ((0, -U),),
)
bodies = []
for k in range(7):
    piece = _piece(MASSES[k], INERTIAS[k], centers[k])
    rods = [mq.bar(hypot(x, z), (x, 0, z), radius=0.002) for x, z in arms[k]]
    bodies.append(mq.Body(f"K{k + 1}", piece, *rods))

mechanism = mq.Mechanism(
    name="squeezer",
    bodies=(mq.Body("ground"), *bodies),
    joints=(
        hinge("O", "ground", "K1", "beta"),
        hinge("K1_K2", "K1", "K2", "theta", at=(RR, 0, 0)),
        hinge("B", "ground", "K3", "gamma", at=(XB, 0, YB)),
        hinge("A5", "ground", "K5", "delta", at=(XA, 0, YA)),
        hinge("K5_K4", "K5", "K4", "phi", at=(ZT, 0, 0)),
        hinge("A7", "ground", "K7", "epsilon", at=(XA, 0, YA)),
        hinge("K7_K6", "K7", "K6", "omega", at=(0, 0, -U)),
    ),
    forces=(
        mq.Spring(
            "spring", "ground", (XC, 0, YC), "K3", (SD, 0, -SC), stiffness=c0, free_length=l0
        ),
        mq.JointForce("drive", "O", mom),
    ),
    loops=(
        mq.Loop.pin("P3", "K3", (0, 0, -SS), "K2", (-D, 0, 0)),
        mq.Loop.pin("P4", "K4", (0, 0, -E), "K2", (-D, 0, 0)),
        mq.Loop.pin("P6", "K6", (ZF, 0, 0), "K2", (-D, 0, 0)),
    ),
    parameters=(mom, c0, l0),
    gravity=(0, 0, 0),
)


def kinetic(s: facts.Values) -> facts.Number:
    """Return T of the seven bodies, from the published positions of their centers."""

    def velocity(
        arm: tuple[float, float], *angles: str
    ) -> tuple[facts.Number, facts.Number, facts.Number]:
        # of the end of an arm that turns by the sum of these angles, and its rate of turning
        (x, y), a, w = arm, sum(s[name] for name in angles), sum(s[f"{name}'"] for name in angles)
        return -w * (x * sin(a) + y * cos(a)), w * (x * cos(a) - y * sin(a)), w

    still = (0.0, 0.0)
    # each body with the pin that carries it, and its center as seen from there
    chains = (
        (velocity(still, "beta"), velocity((RA, 0.0), "beta")),
        (velocity((RR, 0.0), "beta"), velocity((-DA, 0.0), "beta", "theta")),
        (velocity(still, "gamma"), velocity((SB, -SA), "gamma")),
        (velocity((ZT, 0.0), "delta"), velocity((0.0, EA - E), "phi", "delta")),
        (velocity(still, "delta"), velocity((TA, TB), "delta")),
        (velocity((0.0, -U), "epsilon"), velocity((ZF - FA, 0.0), "omega", "epsilon")),
        (velocity(still, "epsilon"), velocity((-UB, -UA), "epsilon")),
    )
    return sum(
        (mass * ((px + vx) ** 2 + (py + vy) ** 2) + inertia * w**2) / 2
        for mass, inertia, ((px, py, _), (vx, vy, w)) in zip(MASSES, INERTIAS, chains, strict=True)
    )


def energy(s: facts.Values) -> facts.Number:
    """Return T + V of the spring - mom beta."""
    x = XB + SC * sin(s.gamma) + SD * cos(s.gamma) - XC
    y = YB + SD * sin(s.gamma) - SC * cos(s.gamma) - YC
    return kinetic(s) + s.c0 * (sqrt(x**2 + y**2) - s.l0) ** 2 / 2 - s.mom * s.beta


SYSTEM = System(
    title="Seven-body squeezer of Andrews",
    source="Hairer & Wanner, Solving ODEs II, sect. VII.7; test set for IVP solvers (Bari), "
    "problem andrews",
    build=mechanism,
    start={
        "beta": -0.0617138900142764496,
        "theta": 0.0,
        "gamma": 0.455279819163070380,
        "phi": 0.222668390165885885,
        "delta": 0.487364979543842550,
        "omega": -0.222668390165885885,
        "epsilon": 1.23054744454982120,
    },
    duration=0.03,
    tags=("linkage", "planar", "loop", "spring", "driven", "benchmark"),
    facts=(
        facts.KineticEnergy("T of seven bodies at the published positions", kinetic),
        facts.Conserved("T + c0 (length - l0)² / 2 - mom beta", energy),
    ),
    forms={
        "0.03635 + 0.007 cos(beta) - 0.035 sin(gamma) - 0.028 cos(beta + theta) = 0": (
            "problem andrews, the first loop: rr cos β - d cos(β + θ) - ss sin γ - xb = 0"
        ),
        (
            "0.06934 + 0.007 cos(beta) - 0.04 cos(delta) - 0.028 cos(beta + theta) - "
            "0.02 sin(delta + phi) = 0"
        ): "the same, the second loop: rr cos β - d cos(β + θ) - e sin(φ + δ) - zt cos δ - xa = 0",
    },
)
