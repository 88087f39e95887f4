"""Formulas from public sources and what `check` says of them; `page()` writes docs/papers.md.

Formulas are quoted as facts in the letters of their sources, which are defined in a mechanism's own
letters; no prose is quoted. Numbers of equations are left out, as editions differ.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import final

import mecanique as mq
from mecanique.model import (
    Body,
    Coordinates,
    Force,
    Input,
    JointDamper,
    JointForce,
    Mechanism,
    Parameter,
    Placement,
    Prismatic,
    Revolute,
    Shape,
    bar,
    box,
    coordinate,
    particle,
)

__all__ = ["PAPERS", "Paper", "page"]

DOWN = (0, -1, 0)
"""Axis about which an angle from the downward vertical is positive towards +x."""


@final
@dataclass(frozen=True)
class Paper:
    """A formula with its source.

    Args:
        source: author, work, year.
        what: it says.
        load: makes the mechanism.
        text: the formula.
        ask: what it is meant to be.
        let: definitions of the source's letters.
        outcome: what check says.
        cause: words in the first cause of a wrong one.
        remark: what else is to be known.
        seen: the public text it was compared with; empty if it is written from memory.
    """

    source: str
    what: str
    load: Callable[[], Mechanism]
    text: str
    ask: str = "equation of motion"
    let: tuple[str, ...] = ()
    outcome: str = "right"
    cause: str = ""
    remark: str = ""
    seen: str = ""

    @property
    def cited(self) -> str:
        """The source, and what public text of the formula it was compared with; else a mark."""
        if not self.seen:
            return f"{self.source} *"
        return self.source if self.seen == self.source else f"{self.source}; in {self.seen}"


def system(name: str) -> Callable[[], Mechanism]:
    """Return what loads a textbook system."""
    return partial(mq.textbook.load, name)


def two_particles() -> Mechanism:
    """Return two particles hanging one from the other by massless rods, absolute angles."""
    m1, m2 = Parameter("m1", 1.0, "kg"), Parameter("m2", 1.5, "kg")
    l1, l2 = Parameter("l1", 1.0, "m"), Parameter("l2", 0.8, "m")
    g = Parameter("g", 9.81, "m/s²")
    q1, q2 = coordinate("q1"), coordinate("q2")
    pin2 = Placement((0, 0, -l1))
    return Mechanism(
        name="two_particles",
        bodies=(
            Body("ground"),
            Body("upper", bar(l1), particle(m1, (0, 0, -l1))),
            Body("lower", bar(l2), particle(m2, (0, 0, -l2))),
        ),
        joints=(
            Revolute("pin1", "ground", "upper", axis=DOWN, coordinate="q1"),
            Revolute("pin2", "upper", "lower", axis=DOWN, origin=pin2, coordinate="turn"),
        ),
        coordinates=Coordinates(("q1", "q2"), {"turn": q2 - q1}),
        parameters=(m1, m2, l1, l2, g),
        gravity=(0, 0, -g),
    )


def undamped(name: str) -> Callable[[], Mechanism]:
    """Return what loads a textbook system without its dampers."""

    def load() -> Mechanism:
        mechanism = mq.textbook.load(name)
        kept = tuple(f for f in mechanism.forces if not isinstance(f, JointDamper))
        return replace(mechanism, forces=kept)

    return load


def inverted_pendulum(damped: bool = True) -> Mechanism:
    """Return a cart with a body that stands on a pin; theta is its angle from upright.

    Args:
        damped: whether the pin is damped, too.
    """
    M, m = Parameter("M", 1.0, "kg"), Parameter("m", 0.2, "kg")
    J, l = Parameter("J", 0.02, "kg·m²"), Parameter("l", 0.5, "m")
    c, gamma = Parameter("c", 0.1, "N·s/m"), Parameter("gamma", 0.01, "N·m·s")
    g, F = Parameter("g", 9.81, "m/s²"), Input("F", 0.0, "N")
    return Mechanism(
        name="inverted_pendulum",
        bodies=(
            Body("ground"),
            Body("cart", box(M, (0.4, 0.2, 0.2))),
            Body("pole", Shape(m, (0, 0, l), (J, J, 0, 0, 0, 0)), bar(l)),
        ),
        joints=(
            Prismatic("slide", "ground", "cart", axis=(1, 0, 0), coordinate="x"),
            Revolute("pin", "cart", "pole", axis=(0, 1, 0), coordinate="theta"),
        ),
        forces=(
            JointDamper("friction", "slide", c),
            *((JointDamper("bearing", "pin", gamma),) if damped else ()),
            Force("push", "cart", (0, 0, 0), force=(F, 0, 0)),
        ),
        parameters=(M, m, J, l, c, g, *((gamma,) if damped else ())),
        inputs=(F,),
        gravity=(0, 0, -g),
    )


def cart_and_pole(friction: bool = True) -> Mechanism:
    """Return Barto, Sutton & Anderson's cart with a homogeneous pole of length 2 l; R slows it.

    Args:
        friction: whether there is some, on the track and in the pin.
    """
    mc, m = Parameter("mc", 1.0, "kg"), Parameter("m", 0.1, "kg")
    l, g = Parameter("l", 0.5, "m"), Parameter("g", 9.8, "m/s²")
    b = Parameter("mup", 0.01, "N·m·s")
    F, R = Input("F", 0.0, "N"), Input("R", 0.0, "N")
    J = m * l**2 / 3
    return Mechanism(
        name="cart_and_pole",
        bodies=(
            Body("ground"),
            Body("cart", box(mc, (0.4, 0.2, 0.2))),
            Body("pole", Shape(m, (0, 0, l), (J, J, 0, 0, 0, 0)), bar(2 * l)),
        ),
        joints=(
            Prismatic("slide", "ground", "cart", axis=(1, 0, 0), coordinate="x"),
            Revolute("pin", "cart", "pole", axis=(0, 1, 0), coordinate="theta"),
        ),
        forces=(
            Force("push", "cart", (0, 0, 0), force=(F, 0, 0)),
            *(
                JointDamper("bearing", "pin", b),
                Force("friction", "cart", (0, 0, 0), force=(-R, 0, 0)),
            )[: 2 * friction],
        ),
        parameters=(mc, m, l, g, *((b,) if friction else ())),
        inputs=(F, *((R,) if friction else ())),
        gravity=(0, 0, -g),
    )


def two_links(level: bool) -> Mechanism:
    """Return two links with centers and inertias of their own, a torque between them.

    Args:
        level: whether q1 is measured from the horizontal; else from the downward vertical.
    """
    m1, m2 = Parameter("m1", 1.0, "kg"), Parameter("m2", 1.2, "kg")
    l1, lc1 = Parameter("l1", 1.0, "m"), Parameter("lc1", 0.5, "m")
    lc2, g = Parameter("lc2", 0.6, "m"), Parameter("g", 9.81, "m/s²")
    I1, I2 = Parameter("I1", 0.2, "kg·m²"), Parameter("I2", 0.3, "kg·m²")
    tau = Input("tau", 0.0, "N·m")
    along = (1, 0, 0) if level else (0, 0, -1)

    def out(length: object) -> tuple[object, ...]:
        return tuple(length * part if part else 0 for part in along)  # type: ignore[operator]

    return Mechanism(
        name="two_links",
        bodies=(
            Body("ground"),
            Body("upper", Shape(m1, out(lc1), (I1, I1, I1, 0, 0, 0))),  # type: ignore[arg-type]
            Body("lower", Shape(m2, out(lc2), (I2, I2, I2, 0, 0, 0))),  # type: ignore[arg-type]
        ),
        joints=(
            Revolute("pin1", "ground", "upper", axis=DOWN, coordinate="q1"),
            Revolute(
                "pin2",
                "upper",
                "lower",
                axis=DOWN,
                origin=Placement(out(l1)),  # type: ignore[arg-type]
                coordinate="q2",
            ),
        ),
        forces=(JointForce("motor", "pin2", tau),),
        parameters=(m1, m2, l1, lc1, lc2, I1, I2, g),
        inputs=(tau,),
        gravity=(0, 0, -g),
    )


_LANDAU = "Landau & Lifshitz, Mechanics, §5"
_GOLDSTEIN = "Goldstein, Classical Mechanics"
_BARTO = "Barto, Sutton & Anderson, IEEE Trans. SMC 13 (1983) 834"
_FLORIAN = "Florian, Correct equations for the dynamics of the cart-pole system, 2007"
_SPONG = "Spong, IEEE Control Systems 15 (1995) 49"
_TEDRAKE = "Tedrake, Underactuated Robotics, ch. 3"
_TOP = ("I1 = 3/5 m (h^2 + r^2/4)", "I3 = 3/10 m r^2", "lc = 3/4 h", "w3 = psi' + phi' cos(theta)")
_ACROBOT = (
    "d1 = m1 lc1^2 + m2 (l1^2 + lc2^2 + 2 l1 lc2 cos(q2)) + I1 + I2",
    "d2 = m2 (lc2^2 + l1 lc2 cos(q2)) + I2",
    "phi2 = m2 lc2 g cos(q1 + q2 - pi/2)",
    "phi1 = -m2 l1 lc2 q2'^2 sin(q2) - 2 m2 l1 lc2 q2' q1' sin(q2)"
    " + (m1 lc1 + m2 l1) g cos(q1 - pi/2) + phi2",
)
_BOTH = "d1 q1'' + d2 q2'' + phi1 = 0\n"
_D = "(2 m1 + m2 - m2 cos(2 q1 - 2 q2))"
_PRINTED = (
    "q1'' = (-g (2 m1 + m2) sin(q1) - m2 g sin(q1 - 2 q2)"
    f" - 2 sin(q1 - q2) m2 (q2'^2 l2 + q1'^2 l1 cos(q1 - q2)))/(l1 {_D})\n"
    "q2'' = 2 sin(q1 - q2) (q1'^2 l1 (m1 + m2) + g (m1 + m2) cos(q1)"
    f" + q2'^2 l2 m2 cos(q1 - q2))/(l2 {_D})"
)

PAPERS = (
    Paper(
        "Neumann, myphysicslab.com, Double Pendulum",
        "accelerations of two particles on massless rods, as most widely printed",
        two_particles,
        _PRINTED,
        remark="SymPy's `equals` does not decide it in half a minute",
        seen="Neumann, myphysicslab.com, Double Pendulum",
    ),
    Paper(
        f"{_LANDAU}, problem 1",
        "Lagrangian of the coplanar double pendulum",
        two_particles,
        "L = (m1 + m2)/2 l1^2 q1'^2 + m2/2 l2^2 q2'^2 + m2 l1 l2 q1' q2' cos(q1 - q2)"
        " + (m1 + m2) g l1 cos(q1) + m2 g l2 cos(q2)",
        "Lagrangian",
        seen="holooly.com, Lagrangian of the plane double pendulum",
    ),
    Paper(
        f"{_LANDAU}, problem 2",
        "Lagrangian of a pendulum whose support m1 moves on a level line",
        system("cart_pole"),
        "L = (m1 + m2)/2 x'^2 + m2/2 (l^2 q'^2 + 2 l x' q' cos(q)) + m2 g l cos(q)",
        "Lagrangian",
        ("m1 = M", "m2 = m"),
        seen="Tedrake, Underactuated Robotics, ch. 3, as T and U",
    ),
    Paper(
        f"{_LANDAU}, problem 3c",
        "pendulum whose support moves as a cos γt, downward, from its Lagrangian",
        system("kapitza_pendulum"),
        "m l^2 q'' = -m a l b^2 cos(b t) sin(q) - m g l sin(q)",
        let=("a = -A", "b = W"),
    ),
    Paper(
        "Huygens, Horologium oscillatorium, 1673",
        "period of small swings of a particle",
        system("simple_pendulum"),
        "T = 2 pi sqrt(l/g)",
        "frequency",
        seen="showmeclass.com, AP Physics C, Pendulums",
    ),
    Paper(
        "Huygens, Horologium oscillatorium, 1673",
        "period of small swings of a body with the moment of inertia I about its pin",
        system("compound_pendulum"),
        "T = 2 pi sqrt(I/(m g dcm))",
        "frequency",
        (
            "I = m1 l^2/3 + m2 (l^2 + r^2/2)",
            "m = m1 + m2",
            "dcm = (m1 l/2 + m2 l)/(m1 + m2)",
        ),
        seen="showmeclass.com, AP Physics C, Pendulums",
    ),
    Paper(
        "Beer & Johnston, Vector Mechanics for Engineers: Dynamics",
        "period of small swings of a uniform rod pinned at its end",
        system("rigid_bar_pendulum"),
        "T = 2 pi sqrt(2 l/(3 g))",
        "frequency",
        seen="showmeclass.com, AP Physics C, Pendulums",
    ),
    Paper(
        _BARTO,
        "cart and pole without friction",
        cart_and_pole,
        "theta'' = (g sin(theta) + cos(theta) (-F + R - m l theta'^2 sin(theta))/(mc + m)"
        " - mup theta'/(m l))/(l (4/3 - m cos(theta)^2/(mc + m)))\n"
        "x'' = (F - R + m l (theta'^2 sin(theta) - theta'' cos(theta)))/(mc + m)",
        remark="right for any force R that slows the cart; the paper takes R = μc sgn(x')",
        seen="exciting-environments documentation, Cartpole",
    ),
    Paper(
        _BARTO,
        "cart and pole with the value of g that the paper states, −9.8 m/s²",
        cart_and_pole,
        "theta'' = (-g sin(theta) + cos(theta) (-F + R - m l theta'^2 sin(theta))/(mc + m)"
        " - mup theta'/(m l))/(l (4/3 - m cos(theta)^2/(mc + m)))\n"
        "x'' = (F - R + m l (theta'^2 sin(theta) - theta'' cos(theta)))/(mc + m)",
        outcome="wrong",
        cause="sign",
        remark="with a negative g in these equations the pole would hang, as Florian notes, too",
        seen="Florian's abstract, which names the value",
    ),
    Paper(
        _FLORIAN,
        "cart and pole without friction",
        cart_and_pole,
        "theta'' = (g sin(theta) + cos(theta) ((-F + R - m l theta'^2 sin(theta))/(mc + m))"
        " - mup theta'/(m l))/(l (4/3 - m cos(theta)^2/(mc + m)))\n"
        "x'' = (F - R + m l (theta'^2 sin(theta) - theta'' cos(theta)))/(mc + m)",
        remark="Florian's correction concerns R, which goes by the force between cart and track",
    ),
    Paper(
        "Åström & Murray, Feedback Systems, 2008, ch. 2",
        "balance system: cart and pendulum with damping",
        inverted_pendulum,
        "(M + m) x'' - m l cos(u) u'' + c x' + m l sin(u) u'^2 = F\n"
        "-m l cos(u) x'' + (J + m l^2) u'' + gamma u' - m g l sin(u) = 0",
        let=("u = -theta",),
    ),
    Paper(
        _SPONG,
        "Acrobot, q1 from the horizontal",
        partial(two_links, True),
        "d11 q1'' + d12 q2'' - m2 l1 lc2 sin(q2) q2'^2 - 2 m2 l1 lc2 sin(q2) q2' q1'"
        " + (m1 lc1 + m2 l1) g cos(q1) + m2 lc2 g cos(q1 + q2) = 0\n"
        "d12 q1'' + d22 q2'' + m2 l1 lc2 sin(q2) q1'^2 + m2 lc2 g cos(q1 + q2) = tau",
        let=(
            "d11 = m1 lc1^2 + m2 (l1^2 + lc2^2 + 2 l1 lc2 cos(q2)) + I1 + I2",
            "d22 = m2 lc2^2 + I2",
            "d12 = m2 (lc2^2 + l1 lc2 cos(q2)) + I2",
        ),
    ),
    Paper(
        "Spong, Hutchinson & Vidyasagar, Robot Modeling and Control, 2006, ch. 7",
        "mass matrix of the planar elbow manipulator",
        partial(two_links, True),
        "[[m1 lc1^2 + m2 (l1^2 + lc2^2 + 2 l1 lc2 cos(q2)) + I1 + I2,"
        " m2 (lc2^2 + l1 lc2 cos(q2)) + I2],"
        " [m2 (lc2^2 + l1 lc2 cos(q2)) + I2, m2 lc2^2 + I2]]",
        "mass matrix",
        seen="Gym, classic_control/acrobot.py, entry by entry",
    ),
    Paper(
        "Sutton & Barto, Reinforcement Learning, 1998, sect. 11.3",
        "Acrobot, q1 from the downward vertical",
        partial(two_links, False),
        f"{_BOTH}q2'' = (tau + d2/d1 phi1 - m2 l1 lc2 q1'^2 sin(q2) - phi2)"
        "/(m2 lc2^2 + I2 - d2^2/d1)",
        let=_ACROBOT,
        seen="Gym, classic_control/acrobot.py, “book”",
    ),
    Paper(
        "Sutton, Advances in Neural Information Processing Systems 8 (1996) 1038",
        "Acrobot, q1 from the downward vertical",
        partial(two_links, False),
        f"{_BOTH}q2'' = (tau + d2/d1 phi1 - phi2)/(m2 lc2^2 + I2 - d2^2/d1)",
        let=_ACROBOT,
        outcome="wrong",
        cause="centripetal",
        remark="the book of 1998 has the term",
        seen="Gym, classic_control/acrobot.py, “nips”",
    ),
    Paper(
        "Cazzolato & Prime, J. Control Sci. Eng. 2011, 528341",
        "Furuta pendulum with a slender pendulum, without damping",
        system("furuta_pendulum"),
        "alpha'' (J0 + J2 sin(theta)^2) + theta'' m2 L1 l2 cos(theta)"
        " - m2 L1 l2 sin(theta) theta'^2 + alpha' theta' sin(2 theta) J2 = tau\n"
        "alpha'' m2 L1 l2 cos(theta) + theta'' J2 - 1/2 alpha'^2 sin(2 theta) J2"
        " + g m2 l2 sin(theta) = 0",
        let=("m2 = m", "L1 = r", "l2 = l", "J2 = m l^2", "J0 = M r^2/3 + m r^2"),
    ),
    Paper(
        "Atwood, A Treatise on the Rectilinear Motion, 1784, in today's letters",
        "Atwood's machine, with the pulley a solid disk",
        system("atwood_machine"),
        "a = g (m1 - m2)/(m1 + m2 + 1/2 mp)",
        let=("mp = M", "a = x''"),
        seen="Duffy, Boston University, Atwood's machine re-visited",
    ),
    Paper(
        "Tufillaro, Abbott & Griffiths, Am. J. Phys. 52 (1984) 895",
        "swinging Atwood's machine",
        system("swinging_atwood_machine"),
        "(1 + mu) r'' = r theta'^2 + g (cos(theta) - mu)\nr theta'' + 2 r' theta' = -g sin(theta)",
        let=("mu = M/m",),
        seen="analyticphysics.com (r) and shelvean.github.io (θ)",
    ),
    Paper(
        "Vitt & Gorelik, Zh. Tekh. Fiz. 3 (1933) 294",
        "elastic pendulum in polar coordinates",
        system("elastic_pendulum"),
        "r'' = r theta'^2 - k/m (r - l0) + g cos(theta)\ntheta'' = -g/r sin(theta) - 2 r' theta'/r",
        seen="shelvean.github.io, Elastic Pendulum",
    ),
    Paper(
        "Strogatz, Nonlinear Dynamics and Chaos, sect. 3.5",
        "bead on a rotating hoop, without damping",
        system("bead_on_hoop"),
        "m R theta'' = -m g sin(theta) + m R W^2 sin(theta) cos(theta)",
        seen="Kolukula, MATLAB Central 33425",
    ),
    Paper(
        "Strogatz, Nonlinear Dynamics and Chaos, sect. 3.5",
        "where the bead rides on the hoop",
        system("bead_on_hoop"),
        "theta = 0\ntheta = pi\ncos(theta) = g/(R W^2)",
        "equilibrium",
    ),
    Paper(
        "Landau & Lifshitz, Mechanics, §14, problem 1",
        "spherical pendulum",
        system("spherical_pendulum"),
        "theta'' - sin(theta) cos(theta) phi'^2 + g/l sin(theta) = 0\n"
        "d/dt(m l^2 sin(theta)^2 phi') = 0",
        seen="Wikipedia, Spherical pendulum, 2015",
    ),
    Paper(
        "Landau & Lifshitz, Mechanics, §14, problem 1",
        "angular momentum of the spherical pendulum about the vertical",
        system("spherical_pendulum"),
        "m l^2 phi' sin(theta)^2",
        "conserved quantity",
        seen="Wikipedia, Spherical pendulum, 2015",
    ),
    Paper(
        f"{_GOLDSTEIN}, ch. 5",
        "Lagrangian of the heavy symmetric top",
        system("heavy_top"),
        "L = I1/2 (theta'^2 + phi'^2 sin(theta)^2) + I3/2 (psi' + phi' cos(theta))^2"
        " - m g lc cos(theta)",
        "Lagrangian",
        _TOP,
        seen="Woodhouse, Introduction to Analytical Dynamics, ch. 5",
    ),
    Paper(
        f"{_GOLDSTEIN}, ch. 5",
        "momentum of the spin of the heavy top",
        system("heavy_top"),
        "I3 (psi' + phi' cos(theta))",
        "momentum of psi",
        _TOP,
        seen="Cambridge, Mathematical Tripos, Part II, 2009",
    ),
    Paper(
        f"{_GOLDSTEIN}, ch. 5",
        "momentum of the precession of the heavy top",
        system("heavy_top"),
        "(I1 sin(theta)^2 + I3 cos(theta)^2) phi' + I3 psi' cos(theta)",
        "momentum of phi",
        _TOP,
        seen="Cambridge, Mathematical Tripos, Part II, 2009",
    ),
    Paper(
        "Kuttler, Engineering Math, app. C",
        "heavy top in Euler's angles",
        system("heavy_top"),
        "d/dt(I1 sin(theta)^2 phi') + d/dt(I3 cos(theta)^2 phi' + I3 cos(theta) psi') = 0\n"
        "d/dt(I3 cos(theta) phi' + I3 psi') = 0\n"
        "I1 theta'' + phi'^2 cos(theta) sin(theta) (I3 - I1) + I3 sin(theta) phi' psi'"
        " - m g lc sin(theta) = 0",
        let=_TOP,
        seen="Kuttler, Engineering Math, app. C",
    ),
    Paper(
        "Euler, Mém. Acad. Berlin 14 (1758) 154",
        "rotation of a free rigid body",
        system("tennis_racket"),
        "I1 w1' = (I2 - I3) w2 w3\nI2 w2' = (I3 - I1) w3 w1\nI3 w3' = (I1 - I2) w1 w2",
        let=(
            "w1 = center_wx",
            "w2 = center_wy",
            "w3 = center_wz",
            "I1 = m (b^2 + c^2)/12",
            "I2 = m (a^2 + c^2)/12",
            "I3 = m (a^2 + b^2)/12",
        ),
    ),
    Paper(
        "Newton, Principia, 1687; Binet's polar form",
        "planet about a fixed sun",
        system("kepler_orbit"),
        "r'' - r phi'^2 = -mu/r^2\nr phi'' + 2 r' phi' = 0",
    ),
    Paper(
        "Kepler, Astronomia nova, 1609",
        "law of areas",
        system("kepler_orbit"),
        "r^2 phi'/2",
        "conserved quantity",
    ),
    Paper(
        f"{_GOLDSTEIN}, ch. 3",
        "energy of a planet",
        system("kepler_orbit"),
        "m/2 (r'^2 + r^2 phi'^2) - m mu/r",
        "conserved quantity",
    ),
    Paper(
        "Bloch, Nonholonomic Mechanics and Control, 2003, after Chaplygin",
        "sleigh on a blade: v' = a ω², (I + m a²) ω' = −m a v ω",
        system("chaplygin_sleigh"),
        "v' = a w^2\n(I + m a^2) w' = -m a v w",
        let=("v = x' cos(theta) + y' sin(theta)", "w = theta'"),
        seen="mathematica.stackexchange.com 162070, with I = 1",
    ),
    Paper(
        "SymPy documentation, A rolling disc, with Kane's method",
        "rates of the disc's angular velocity",
        system("rolling_coin"),
        "u1' = (4 g sin(lean) + 6 r u2 u3 - r u3^2 tan(lean))/(5 r)\n"
        "u2' = -2/3 u1 u3\n"
        "u3' = (-2 u2 + u3 tan(lean)) u1",
        let=("u1 = lean'", "u2 = spin' + yaw' sin(lean)", "u3 = yaw' cos(lean)"),
        seen="SymPy documentation, A rolling disc, with Kane's method",
    ),
    Paper(
        "French, Vibrations and Waves, ch. 5",
        "coupled pendulums: both normal frequencies",
        system("coupled_pendulums"),
        "omega = sqrt(g/l)\nomega = sqrt(g/l + 2 k a^2/(m l^2))",
        "frequency",
    ),
    Paper(
        "Landau & Lifshitz, Mechanics, §39, problem 3",
        "Foucault's pendulum, small swings, squares of the rotation neglected",
        system("foucault_pendulum"),
        "alpha'' - 2 W beta' + g/l alpha = 0\nbeta'' + 2 W alpha' + g/l beta = 0",
        outcome="wrong",
        remark="an approximation, as the source says: terms with W² and large angles are missing",
        seen="Kuttler, Engineering Math, sect. 24.7",
    ),
    Paper(
        "Den Hartog, Mechanical Vibrations, ch. 3",
        "two masses on two springs, a force on the second",
        system("two_blocks"),
        "m1 q1'' = -k1 q1 + k2 (q2 - q1)\nm2 q2'' = -k2 (q2 - q1) + F",
    ),
    Paper(
        _TEDRAKE,
        "Acrobot, q1 from the downward vertical, inertias about the pins",
        partial(two_links, False),
        "(J1 + J2 + m2 l1^2 + 2 m2 l1 lc2 cos(q2)) q1'' + (J2 + m2 l1 lc2 cos(q2)) q2''"
        " - 2 m2 l1 lc2 sin(q2) q1' q2' - m2 l1 lc2 sin(q2) q2'^2 + m1 g lc1 sin(q1)"
        " + m2 g (l1 sin(q1) + lc2 sin(q1 + q2)) = 0\n"
        "(J2 + m2 l1 lc2 cos(q2)) q1'' + J2 q2'' + m2 l1 lc2 sin(q2) q1'^2"
        " + m2 g lc2 sin(q1 + q2) = tau",
        let=("J1 = I1 + m1 lc1^2", "J2 = I2 + m2 lc2^2"),
        seen=_TEDRAKE,
    ),
    Paper(
        _TEDRAKE,
        "cart-pole without friction, solved for the accelerations",
        undamped("cart_pole"),
        "x'' = (fx + mp sin(q) (l q'^2 + g cos(q)))/(mc + mp sin(q)^2)\n"
        "q'' = (-fx cos(q) - mp l q'^2 cos(q) sin(q) - (mc + mp) g sin(q))"
        "/(l (mc + mp sin(q)^2))",
        let=("fx = F", "mp = m", "mc = M"),
        seen=_TEDRAKE,
    ),
    Paper(
        "Lund University, Control System Synthesis, exercise 2, 2020",
        "cart and pendulum with friction on the track, angle from the downward vertical",
        partial(inverted_pendulum, False),
        "(M + m) x'' + b x' + m l u'' cos(u) - m l u'^2 sin(u) = F\n"
        "(J + m l^2) u'' + m g l sin(u) = -m l x'' cos(u)",
        let=("u = pi - theta", "b = c"),
        seen="Lund University, Control System Synthesis, exercise 2, 2020",
    ),
    Paper(
        "Wolfram Language documentation, state-space models in natural form",
        "cart and pendulum, angle from upright",
        undamped("cart_pole"),
        "(M + m) x'' - m l sin(u) u'^2 + m l cos(u) u'' = F\nm x'' cos(u) + m l u'' = m g sin(u)",
        let=("u = pi - q",),
        seen="Wolfram Language documentation, state-space models in natural form",
    ),
    Paper(
        "DecisionMakingProblems.jl, documentation, Cart-Pole",
        "cart and homogeneous pole of length L",
        partial(cart_and_pole, False),
        "theta'' = (g sin(theta) - (F + theta'^2 L sin(theta/2))/(mc + m) cos(theta))"
        "/(L/2 (4/3 - m/(mc + m) cos(theta)^2))\n"
        "x'' = (F + theta'^2 L sin(theta/2))/(mc + m) - L/2 theta'' cos(theta) m/(mc + m)",
        let=("L = 2 l",),
        outcome="wrong",
        cause="units do not match",
        remark="a misprint: m L/2 sin θ is meant",
        seen="DecisionMakingProblems.jl, documentation, Cart-Pole",
    ),
    Paper(
        "github.com/HSJNYCU/Pendulums, after Spong",
        "Acrobot, q1 from the horizontal, printed with two slips",
        partial(two_links, True),
        "(m1 lc1^2 + m2 (l1^2 + lc2^2 + 2 l1 lc2 cos(q2)) + I1 + I2) q1''"
        " + m2 (lc2^2 + l1 lc2 cos(q2) + I2) q2'' - m2 l1 lc2 sin(q2) q2'^2"
        " - 2 m1 l1 lc2 sin(q2) q1' q2' + (m1 lc1 + m2 l1) g cos(q1)"
        " + m2 lc2 g cos(q1 + q2) = 0\n"
        "m2 (lc2^2 + l1 lc2 cos(q2) + I2) q1'' + (m2 lc2^2 + I2) q2''"
        " + m2 l1 lc2 sin(q2) q1'^2 + m2 lc2 g cos(q1 + q2) = tau",
        outcome="wrong",
        cause="units do not match",
        remark="I2 stands within the brackets of m2, and m1 for m2 in the Coriolis term",
        seen="github.com/HSJNYCU/Pendulums, after Spong",
    ),
    Paper(
        "analyticphysics.com, Swinging Atwood Machine, 2019",
        "angle from the vertical",
        system("swinging_atwood_machine"),
        "(M + m) r'' = m r theta'^2 + m g cos(theta) - M g\n"
        "m r^2 theta'' + 2 m r r' theta' = m g r sin(theta)",
        outcome="wrong",
        cause="the sign of the term",
        remark="gravity turns a hanging mass back: −m g r sin θ",
        seen="analyticphysics.com, Swinging Atwood Machine, 2019",
    ),
    Paper(
        "shelvean.github.io, Swinging Atwood Machine",
        "swing of the bob",
        system("swinging_atwood_machine"),
        "theta'' = -(2 r' theta' + g sin(theta))/r",
        outcome="incomplete",
        remark="one of two equations of motion; the other is a picture there",
        seen="shelvean.github.io, Swinging Atwood Machine",
    ),
    Paper(
        "academickids.com, Spherical pendulum",
        "equations of motion, with one exponent lost",
        system("spherical_pendulum"),
        "d/dt(m l^2 theta') - m l^2 sin(theta) cos(theta) phi'^2 + m g l sin(theta) = 0\n"
        "d/dt(m l^2 sin(theta) phi') = 0",
        outcome="wrong",
        cause="is halved",
        remark="m l² sin² θ φ' is conserved; as it is here, the Coriolis term is half",
        seen="academickids.com, Spherical pendulum",
    ),
    Paper(
        "physics.stackexchange.com 545374",
        "spherical pendulum, from a question",
        system("spherical_pendulum"),
        "m l^2 theta'' = m l^2 phi' sin(theta) cos(theta) - m g l sin(theta)",
        outcome="wrong",
        cause="units do not match",
        remark="φ' without its square",
        seen="physics.stackexchange.com 545374",
    ),
)
"""The formulas."""


def verdict(paper: Paper) -> mq.Check:
    """Return what `check` says of a formula."""
    return mq.check(paper.load(), paper.text, paper.ask, paper.let)


def page() -> str:
    """Return docs/papers.md."""
    rights = sum(paper.outcome == "right" for paper in PAPERS)
    lines = [
        "# Formulas from books and papers",
        "",
        "What `mecanique check` says of formulas as they are printed. They are quoted as facts, in "
        "text; the letters of a source",
        "are defined in those of the system. `tests/checking/papers.py` holds them, and a test "
        "keeps this page true.",
        f"Of {len(PAPERS)} formulas {rights} are right as they stand. Where a source was not at "
        "hand, a public text that prints the same",
        "formula is named (“in …”); those marked * are cited from memory.",
        "",
        "| source | formula | verdict | why |",
        "|---|---|---|---|",
    ]
    for paper in PAPERS:
        found = verdict(paper)
        why = [*found.forms, *(cause.text for cause in found.causes[:1])]
        why += [paper.remark] if paper.remark else []
        formula = "<br>".join(f"`{line}`" for line in paper.text.splitlines())
        cells = (paper.cited, f"{paper.what}: {formula}", found.outcome, "; ".join(why))
        lines.append("| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |")
    return "\n".join(lines) + "\n"
