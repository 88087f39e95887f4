"""Whipple's bicycle.

A rear frame B with its rider, a fork H that turns in it, and two wheels R and F with sharp edges,
which roll on level ground without slip, under gravity g; nobody steers. The generalized coordinates
are the place x, y, z of the rear hub, the angle yaw of the frame's heading, the angle roll of its
lean to the right, its angle pitch, the angle steer of the fork to the right and the turns rear_spin
and front_spin of the wheels: seven positions and three velocities are independent.

Standing upright with the rear wheel touching at the origin, the bicycle has the wheelbase w and the
trail c; the steering axis leans back by the angle tilt. The wheels have the radii rR and rF, the
masses mR and mF, and moments of inertia IRxx, IFxx about a diameter and IRyy, IFyy about the hub.
The centers of mass lie xB ahead and zB above, and xH ahead and zH above; their masses are mB and
mH, and their tensors of inertia IBxx, IByy, IBzz, IBxz and IHxx, IHyy, IHzz, IHxz, the last of each
the entry xz of the tensor with x ahead and z up.
"""

from typing import TypeAlias

from numpy import array, block, cos, cross, diag, eye, pi, real, sin, tan, zeros
from numpy.linalg import eigvals, solve

from mecanique import model as mq
from mecanique.model.expression import Scalar
from mecanique.textbook import System, facts
from mecanique.textbook.joints import about, carriers, hinge, hinges, slides

BLUE = (0.0, 0.447, 0.698, 1.0)
SPEED = 4.6
"""Of the upright ride, between the speeds of weave and capsize [m/s]."""

EX, EY, EZ = eye(3)

PARAMETERS = (
    mq.Parameter("w", 1.02, "m", "wheelbase"),
    mq.Parameter("c", 0.08, "m", "trail"),
    mq.Parameter("tilt", pi / 10, "rad", "angle of the steering axis from the vertical"),
    mq.Parameter("rR", 0.3, "m", "radius of the rear wheel"),
    mq.Parameter("mR", 2.0, "kg", "mass of the rear wheel"),
    mq.Parameter("IRxx", 0.0603, "kg·m²", "moment of inertia of the rear wheel about a diameter"),
    mq.Parameter("IRyy", 0.12, "kg·m²", "moment of inertia of the rear wheel about its hub"),
    mq.Parameter(
        "xB", 0.3, "m", "distance of the frame's center of mass ahead of the rear contact"
    ),
    mq.Parameter("zB", 0.9, "m", "height of the frame's center of mass"),
    mq.Parameter("mB", 85.0, "kg", "mass of the frame with its rider"),
    mq.Parameter("IBxx", 9.2, "kg·m²", "entry xx of the frame's tensor of inertia"),
    mq.Parameter("IByy", 11.0, "kg·m²", "entry yy of the frame's tensor of inertia"),
    mq.Parameter("IBzz", 2.8, "kg·m²", "entry zz of the frame's tensor of inertia"),
    mq.Parameter("IBxz", -2.4, "kg·m²", "entry xz of the frame's tensor of inertia"),
    mq.Parameter("xH", 0.9, "m", "distance of the fork's center of mass ahead of the rear contact"),
    mq.Parameter("zH", 0.7, "m", "height of the fork's center of mass"),
    mq.Parameter("mH", 4.0, "kg", "mass of the fork"),
    mq.Parameter("IHxx", 0.05892, "kg·m²", "entry xx of the fork's tensor of inertia"),
    mq.Parameter("IHyy", 0.06, "kg·m²", "entry yy of the fork's tensor of inertia"),
    mq.Parameter("IHzz", 0.00708, "kg·m²", "entry zz of the fork's tensor of inertia"),
    mq.Parameter("IHxz", 0.00756, "kg·m²", "entry xz of the fork's tensor of inertia"),
    mq.Parameter("rF", 0.35, "m", "radius of the front wheel"),
    mq.Parameter("mF", 3.0, "kg", "mass of the front wheel"),
    mq.Parameter("IFxx", 0.1405, "kg·m²", "moment of inertia of the front wheel about a diameter"),
    mq.Parameter("IFyy", 0.28, "kg·m²", "moment of inertia of the front wheel about its hub"),
    mq.Parameter("g", 9.81, "m/s²", "acceleration of free fall"),
)
p = {parameter.symbol: parameter for parameter in PARAMETERS}


def piece(of: str, x: Scalar, z: Scalar) -> mq.Shape:
    """Return the mass of the frame or the fork, its center at x and z of the hub's axes."""
    xx, yy, zz, xz = (p[f"I{of}{entry}"] for entry in ("xx", "yy", "zz", "xz"))
    return mq.Shape(p[f"m{of}"], (x, 0, z), (xx, yy, zz, 0, xz, 0))


def wheel(of: str) -> tuple[mq.Shape, ...]:
    """Return a wheel with a spoke, by which its turning is seen."""
    r, across, about_hub = p[f"r{of}"], p[f"I{of}xx"], p[f"I{of}yy"]
    paint = (0.0, 0.447, 0.698, 0.35)
    rim = mq.Visual(mq.Cylinder(r, 0.03), mq.Placement(rpy=(pi / 2, 0, 0)), paint)
    spoke = mq.Visual(mq.Box((0.04, 0.04, 1.9 * r)), rgba=(0.9, 0.6, 0.0, 1.0))
    moments = (across, about_hub, across, 0, 0, 0)
    return mq.Shape(p[f"m{of}"], (0, 0, 0), moments, (rim,)), mq.massless(spoke)


def tube(start: tuple[Scalar, Scalar], end: tuple[Scalar, Scalar]) -> mq.Shape:
    """Return the drawing of a tube between two points of the plane of symmetry, x and z."""
    (x0, z0), (x1, z1) = start, end
    x, z = x1 - x0, z1 - z0
    middle = mq.Placement(((x0 + x1) / 2, 0, (z0 + z1) / 2), (0, mq.atan(x / z), 0))
    return mq.massless(mq.Visual(mq.Cylinder(0.02, mq.sqrt(x * x + z * z)), middle, BLUE))


# the bicycle, its rear hub led by three slides and turned by three hinges
tilt, rR, rF = p["tilt"], p["rR"], p["rF"]
steering = p["w"] + p["c"] - rR * mq.tan(tilt)  # where the axis meets the hub's height
ahead, above = p["w"] - steering, rF - rR
front = ahead * mq.cos(tilt) + above * mq.sin(tilt), above * mq.cos(tilt) - ahead * mq.sin(tilt)
frame = piece("B", p["xB"], p["zB"] - rR)
fork = piece("H", p["xH"] - steering, p["zH"] - rR).at(rpy=(0, tilt, 0))
floor = mq.Visual(mq.Box((2.4, 1.0, 0.02)), mq.Placement((0.5, 0, -0.01)), (0.85, 0.85, 0.85, 1.0))
torso = mq.Visual(
    mq.Box((0.3, 0.35, 0.7)), mq.Placement((p["xB"], 0, p["zB"])), (0.3, 0.6, 0.5, 1.0)
)
rider = mq.massless(torso)
hub, seat = (0, 0), (p["xB"] - 0.1, 0.6)
head = steering - 0.45 * mq.sin(tilt), 0.45 * mq.cos(tilt)
bar = mq.Visual(mq.Cylinder(0.02, 0.5), mq.Placement((0.05, 0, 0.75), (pi / 2, 0, 0)), BLUE)
chart = (*slides("hub"), *hinges("hub", "lean", "frame"))
mechanism = mq.Mechanism(
    name="whipple_bicycle",
    bodies=(
        mq.Body("ground", mq.massless(floor)),
        *carriers(chart),
        mq.Body("frame", frame, tube(hub, seat), tube(seat, head), tube(hub, head), rider),
        mq.Body("rear_wheel", *wheel("R")),
        mq.Body(
            "fork", fork, tube(front, (0, 0.4)), tube((0, 0.4), (0.05, 0.75)), mq.massless(bar)
        ),
        mq.Body("front_wheel", *wheel("F")),
    ),
    joints=(
        *chart,
        mq.Revolute("rear_hub", "frame", "rear_wheel", axis=(0, 1, 0), coordinate="rear_spin"),
        mq.Revolute(
            "headset",
            "frame",
            "fork",
            axis=(0, 0, -1),
            origin=mq.Placement((steering, 0, 0), (0, -tilt, 0)),
            coordinate="steer",
        ),
        hinge(
            "front_hub",
            "fork",
            "front_wheel",
            "front_spin",
            at=(front[0], 0, front[1]),
            axis=(0, 1, 0),
        ),
    ),
    coordinates=mq.Coordinates((), limits={"roll": (-pi / 2, pi / 2)}),
    contacts=(
        mq.Rolling("rear_contact", "rear_wheel", rR),
        mq.Rolling("front_contact", "front_wheel", rF),
    ),
    parameters=PARAMETERS,
    gravity=(0, 0, -p["g"]),
)


Part: TypeAlias = "tuple[facts.Number, facts.Number, facts.Number, facts.Number]"
"""Mass, velocity and height of the center of mass, and twice the energy of turning."""


def parts(s: facts.Values) -> list[Part]:
    """Return what moves, in the axes of the frame: rear wheel, frame, fork, front wheel."""
    lean, nod = about(0, s.roll), about(1, s.pitch)
    to_frame = nod.T @ lean.T @ about(2, s.yaw).T
    spin = s["pitch'"] * EY + nod.T @ (s["roll'"] * EX + lean.T @ (s["yaw'"] * EZ))
    hub = to_frame @ array([s["x'"], s["y'"], s["z'"]])
    back = about(1, -s.tilt)
    turn = back @ about(2, -s.steer) @ back.T  # the fork about its axis
    steering = s.w + s.c - s.rR * tan(s.tilt)
    fork_spin = spin - s["steer'"] * back @ EZ
    head = hub + cross(spin, steering * EX)
    up = to_frame @ EZ

    def part(
        mass: facts.Number,
        start: facts.Number,
        at: facts.Number,
        w: facts.Number,
        turn_rate: facts.Number,
        I: facts.Number,
    ) -> Part:
        arm = at - (steering * EX if start is head else 0)
        return mass, start + cross(w, arm), s.z + up @ at, turn_rate @ I @ turn_rate

    frame = array([s.xB, 0, s.zB - s.rR])
    fork = steering * EX + turn @ array([s.xH - steering, 0, s.zH - s.rR])
    front = steering * EX + turn @ array([s.w - steering, 0, s.rF - s.rR])
    rear_spin = spin + s["rear_spin'"] * EY
    front_spin = turn.T @ fork_spin + s["front_spin'"] * EY
    return [
        part(s.mR, hub, 0 * EX, spin, rear_spin, diag([s.IRxx, s.IRyy, s.IRxx])),
        part(s.mB, hub, frame, spin, spin, tensor(s, "B")),
        part(s.mH, head, fork, fork_spin, turn.T @ fork_spin, tensor(s, "H")),
        part(s.mF, head, front, fork_spin, front_spin, diag([s.IFxx, s.IFyy, s.IFxx])),
    ]


def tensor(s: facts.Values, of: str) -> facts.Number:
    """Return the tensor of inertia of the frame or the fork."""
    xx, yy, zz, xz = (s[f"I{of}{entry}"] for entry in ("xx", "yy", "zz", "xz"))
    return array([[xx, 0, xz], [0, yy, 0], [xz, 0, zz]])


def kinetic(s: facts.Values) -> facts.Number:
    """Return the kinetic energy [J]."""
    return real(sum(m * v @ v + turning for m, v, _, turning in parts(s)) / 2)


def energy(s: facts.Values) -> facts.Number:
    """Return the energy, complex where s is [J]."""
    return sum((m * v @ v + turning) / 2 + m * s.g * z for m, v, z, turning in parts(s))


def linear(s: facts.Values) -> tuple[facts.Number, facts.Number, facts.Number, facts.Number]:
    """Return M, C1, K0 and K2 of roll and steer (Meijaard et al. 2007, appendix A), z down."""
    zB, zH, IBxz, IHxz = -s.zB, -s.zH, -s.IBxz, -s.IHxz
    sine, cosine = sin(s.tilt), cos(s.tilt)
    masses = array([s.mR, s.mB, s.mH, s.mF])
    xs, zs = array([0, s.xB, s.xH, s.w]), array([-s.rR, zB, zH, -s.rF])
    mT = masses.sum()
    xT, zT = masses @ xs / mT, masses @ zs / mT
    Txx = s.IRxx + s.IBxx + s.IHxx + s.IFxx + masses @ zs**2
    Txz = IBxz + IHxz - masses @ (xs * zs)
    Tzz = s.IRxx + s.IBzz + s.IHzz + s.IFxx + masses @ xs**2
    mA = s.mH + s.mF
    xA, zA = (s.xH * s.mH + s.w * s.mF) / mA, (zH * s.mH - s.rF * s.mF) / mA
    Axx = s.IHxx + s.IFxx + s.mH * (zH - zA) ** 2 + s.mF * (s.rF + zA) ** 2
    Axz = IHxz - s.mH * (s.xH - xA) * (zH - zA) + s.mF * (s.w - xA) * (s.rF + zA)
    Azz = s.IHzz + s.IFxx + s.mH * (s.xH - xA) ** 2 + s.mF * (s.w - xA) ** 2
    uA = (xA - s.w - s.c) * cosine - zA * sine
    All = mA * uA**2 + Axx * sine**2 + 2 * Axz * sine * cosine + Azz * cosine**2
    Alx = -mA * uA * zA + Axx * sine + Axz * cosine
    Alz = mA * uA * xA + Axz * sine + Azz * cosine
    mu = s.c / s.w * cosine
    SR, SF = s.IRyy / s.rR, s.IFyy / s.rF
    ST, SA = SR + SF, mA * uA + mu * mT * xT
    cross_mass = Alx + mu * Txz
    M = array([[Txx, cross_mass], [cross_mass, All + 2 * mu * Alz + mu**2 * Tzz]])
    K0 = array([[mT * zT, -SA], [-SA, -SA * sine]])
    K2 = array([[0, (ST - mT * zT) / s.w * cosine], [0, (SA + SF * sine) / s.w * cosine]])
    C1 = array(
        [
            [0, mu * ST + SF * cosine + Txz / s.w * cosine - mu * mT * zT],
            [-(mu * ST + SF * cosine), Alz / s.w * cosine + mu * (SA + Tzz / s.w * cosine)],
        ]
    )
    return M, C1, K0, K2


def exponents(s: facts.Values) -> facts.Number:
    """Return the four exponents of the upright ride: weave, capsize and castor."""
    M, C1, K0, K2 = linear(s)
    stiffness, damping = solve(M, s.g * K0 + SPEED**2 * K2), solve(M, SPEED * C1)
    return eigvals(block([[zeros((2, 2)), eye(2)], [-stiffness, -damping]]))


def upright(s: facts.Values) -> dict[str, float]:
    """Return the upright ride straight ahead."""
    return {
        "z": s.rR,
        "x'": SPEED,
        "rear_spin'": SPEED / s.rR,
        "front_spin'": SPEED / s.rF,
    }


SYSTEM = System(
    title="Whipple's bicycle",
    source="F. J. W. Whipple, Q. J. Pure Appl. Math. 30 (1899) 312; benchmark of Meijaard, "
    "Papadopoulos, Ruina & Schwab, Proc. R. Soc. A 463 (2007) 1955, table 1",
    build=mechanism,
    start={"z": 0.3},
    start_velocity={"x": SPEED, "roll": 0.5},
    duration=5.0,
    tags=("spatial", "rolling", "nonholonomic", "contact", "vehicle"),
    facts=(
        facts.KineticEnergy("T = sum of m v^2/2 + w I w/2 of wheels, frame and fork", kinetic),
        facts.Conserved("the energy T + sum of m g z", energy),
        facts.Eigenvalues(
            "upright at v: M q'' + v C1 q' + (g K0 + v^2 K2) q = 0 for roll and steer, with the "
            "formulas of Meijaard et al., appendix A",
            exponents,
            at=upright,
        ),
        facts.Solution(
            "upright and straight ahead, x = v t, rear_spin = v t/rR, front_spin = v t/rF",
            upright,
            lambda s: {
                "x": SPEED * s.t,
                "rear_spin": SPEED * s.t / s.rR,
                "front_spin": SPEED * s.t / s.rF,
                "roll": 0.0,
            },
            until=lambda s: 2.0,
        ),
    ),
    forms={
        "yaw' = -(v steer + c steer') cos(tilt)/w": "Meijaard et al. 2007, sect. 4",
        "K0_11 = -mR rR - mB zB - mH zH - mF rF": "Meijaard et al. 2007, appendix A: m_T z_T",
        "C1_21 = -(c/w (IRyy/rR + IFyy/rF) + IFyy/rF) cos(tilt)": (
            "Meijaard et al. 2007, appendix A: -(μ S_T + S_F cos λ)"
        ),
    },
)
