"""Sections 1.3.1 and 1.3.2: the rod pendulum by Newton and Euler and by d'Alembert's principle, line by line."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any, final

from mecanique.derivation.scalars.cancel import tidy
from mecanique.derivation.scalars.elementary import cos, sin
from mecanique.derivation.symbolic.distribution import Distribution, distribution_of
from mecanique.derivation.symbolic.vectors import along
from mecanique.derivation.symbolic.virtual_work import VirtualWork
from mecanique.textbook import load
from mecanique.textbook.register.row import Check, Finding, compared, corrected, identical

__all__ = ["CHECKS"]

_BY = "the derivation of the pendulum in the catalogue, term by term"


@final
class _Rod:
    """The rod pendulum in the letters of the chapter: components along n (from the pin) and t (across)."""

    def __init__(self) -> None:
        self.work = VirtualWork(load("rigid_bar_pendulum"))
        self.derivation = self.work.derivation()
        bodies = self.work.balances
        (cut,) = bodies.cuts.bodies
        ring = bodies.algebra.ring
        self.m, self.l, self.g, self.v, self.a = (
            ring[name] for name in ("m", "l", "g", "q'", "q''")
        )
        self.mu = self.m / self.l
        self.sin, self.cos = sin(ring["q"]), cos(ring["q"])
        self.Rn, self.Rt = ring["R_pin_n"], ring["R_pin_t"]
        self.closed = bodies.reactions
        self.delta = ring["δq"]
        algebra = bodies.algebra
        kinematics = bodies.cuts.kinematics
        rows = cut.axes.rows
        self.center = along(algebra, rows, cut.center)
        self.velocity = along(algebra, rows, cut.center_velocity)
        self.acceleration = along(
            algebra, rows, kinematics.change(cut.center_velocity, cut.carrier)
        )
        self.push = along(algebra, rows, cut.push)
        self.resultant = along(algebra, rows, bodies.resultant(cut))
        self.turning = along(algebra, cut.axes.turns, bodies.turning(cut))[2]
        self.moment = along(algebra, cut.axes.turns, bodies.moment(cut))[2]
        self.row = bodies.derivation().rows[0]
        spread = distribution_of(bodies.cuts, cut)
        assert spread is not None
        self.spread: Distribution = spread
        self.s = ring[spread.coordinate]
        self.equation = self.a + 3 * self.g * self.sin / (2 * self.l)


@cache
def _rod() -> _Rod:
    return _Rod()


def _exact(difference: Callable[[_Rod], Any], how: str = _BY) -> Callable[[], Finding]:
    return lambda: identical(difference(_rod()), how)


def _kinematics(p: _Rod) -> list[Any]:
    half = p.l / 2
    return [
        p.center[0] - half,
        p.center[1],
        p.velocity[0],
        p.velocity[1] - half * p.v,
        p.acceleration[0] + half * p.v**2,
        p.acceleration[1] - half * p.a,
    ]


def _linear(p: _Rod) -> list[Any]:
    given = [p.m * p.g * p.cos - p.Rn, p.Rt - p.m * p.g * p.sin]
    left = [-(p.m * p.l / 2) * p.v**2, p.m * p.l / 2 * p.a]
    return [
        *(x - y for x, y in zip(p.push, left, strict=False)),
        *(x - y for x, y in zip(p.resultant, given, strict=False)),
    ]


def _angular_momentum() -> Finding:
    from sympy import integrate, symbols

    s, mu, length, rate, m = symbols("s mu l q' m", positive=True)
    whole = integrate(s**2 * rate * mu, (s, 0, length))
    p = _rod()
    rate_of = p.turning - p.m * p.l**2 / 3 * p.a
    return identical(
        [
            whole - mu * length**3 / 3 * rate,
            whole.subs(mu, m / length) - m * length**2 / 3 * rate,
            rate_of,
        ],
        "the integral of s² q' mu over the rod, and the derivation's rate of it",
    )


def _linearized() -> Finding:
    from mecanique.motion import linearize

    mechanism = load("rigid_bar_pendulum", l=1.7)
    found = linearize(mechanism)
    exact = (3 * 9.81 / (2 * 1.7)) ** 0.5
    return compared(
        [(found.frequencies, [exact])],
        "the natural frequency of the linearized pendulum against sqrt(3 g/(2 l))",
    )


def _segments(p: _Rod) -> list[Any]:
    """The field −μ a along the rod is the distribution found from the poses."""
    field = [-p.s * p.v**2, p.s * p.a]
    return [-(p.mu * a) - f for a, f in zip(field, p.spread.density, strict=False)]


def _printed_126() -> Finding:
    p = _rod()
    printed = p.a - 3 * p.g * p.sin / (2 * p.l)
    from_125 = -(p.l / 2) * p.m * p.g * p.sin - 2 * p.l / 3 * p.mu * p.l * p.a * p.l / 2
    # eq. 1.25 times −3/(m l²) is the right form, and the derived equation times 3/(m l²) as well
    mended = [p.equation + 3 * from_125 / (p.m * p.l**2), p.equation - 3 * p.row / (p.m * p.l**2)]
    return corrected(
        tidy(printed - 3 * p.row / (p.m * p.l**2)),
        mended,
        "the printed left side against the derived equation of motion",
        "q'' + (3/2)(g/l) sin(q) = 0",
        "eq. 1.25 divided by -m l²/3 gives the plus sign, as eqs. 1.18 and 1.19 have it",
    )


def _virtual(p: _Rod) -> list[Any]:
    weight = -(p.m * p.g * p.sin) * (p.l / 2 * p.delta)
    inertia = -(p.m * p.l * p.a / 2) * (2 * p.l / 3 * p.delta)
    (stage,) = [stage for stage in p.derivation.stages if stage.title == "Sum of the virtual work"]
    total = stage.results[0].right
    return [
        weight + inertia - total,
        total + (p.m * p.g * p.l / 2 * p.sin + p.m * p.l**2 / 3 * p.a) * p.delta,
    ]


def _principle(p: _Rod) -> list[Any]:
    """No internal work in a rigid body; the reactions do none; what is left vanishes along the motion."""
    (reactions,) = [
        stage for stage in p.derivation.stages if stage.title == "Virtual work of the reactions"
    ]
    (total,) = [stage for stage in p.derivation.stages if stage.title == "Sum of the virtual work"]
    along_motion = total.results[0].right + p.row * p.delta
    return [along_motion, *(result.right for result in reactions.results)]


CHECKS = (
    Check(
        "1.14 a",
        "r_C = (l/2) n, v_C = (l/2) q' t, a_C = -(l/2) q'² n + (l/2) q'' t",
        _exact(_kinematics),
    ),
    Check("1.14", "m a_C = (m g cos q - R_n) n + (R_t - m g sin q) t", _exact(_linear)),
    Check("1.15", "H_o = ∫ s² q' mu ds = mu l³ q'/3 = m l² q'/3", _angular_momentum),
    Check("1.16", "dH_o/dt = (m l²/3) q''", _exact(lambda p: p.turning - p.m * p.l**2 / 3 * p.a)),
    Check(
        "1.17",
        "(m l²/3) q'' = -(l/2) m g sin q",
        _exact(lambda p: [p.moment + p.l / 2 * p.m * p.g * p.sin, (p.turning - p.moment) - p.row]),
    ),
    Check(
        "1.18",
        "q'' + (3 g/(2 l)) sin q = 0",
        _exact(lambda p: p.equation - 3 * p.row / (p.m * p.l**2)),
    ),
    Check(
        "1.19",
        "the same equation of motion",
        _exact(lambda p: p.equation - 3 * p.row / (p.m * p.l**2)),
    ),
    Check("1.20", "linearized: q'' + (3 g/(2 l)) q = 0", _linearized),
    Check(
        "1.23 a",
        "a = -s q'² n + s q'' t along the rod",
        _exact(_segments, "d'Alembert's distributed forces found from the poses"),
    ),
    Check(
        "1.23",
        "R_t - (1/2)(mu l q'') l - m g sin q = 0",
        _exact(
            lambda p: p.closed["R_pin_t"] - p.mu * p.l * p.a * p.l / 2 - p.m * p.g * p.sin,
            "the reaction eliminated from the balances",
        ),
    ),
    Check(
        "1.24",
        "R_n - (1/2)(mu l q'²) l - m g cos q = 0",
        _exact(
            lambda p: p.closed["R_pin_n"] - p.mu * p.l * p.v**2 * p.l / 2 - p.m * p.g * p.cos,
            "the reaction eliminated from the balances",
        ),
    ),
    Check(
        "1.25",
        "-(l/2) m g sin q - (2 l/3)(1/2)(mu l q'') l = 0",
        _exact(
            lambda p: (
                -(p.l / 2) * p.m * p.g * p.sin - 2 * p.l / 3 * p.mu * p.l * p.a * p.l / 2 + p.row
            )
        ),
    ),
    Check(
        "1.26", "printed: q'' - (3/2)(g/l) sin q = 0, said to be identical to 1.19", _printed_126
    ),
    Check(
        "1.27", "virtual work: dW_int = dW_ext, here both zero along the motion", _exact(_principle)
    ),
    Check(
        "1.27 a",
        "the resultant of the triangular distribution is m l q''/2, at 2 l/3 from o",
        _exact(
            lambda p: [
                p.spread.resultant[1] + p.m * p.l * p.a / 2,
                p.spread.point[1] - 2 * p.l / 3,
            ],
            "the distribution integrated over the rod, and its moment about o",
        ),
    ),
    Check(
        "1.27 b",
        "dW_ext = -(m g sin q)(l/2) dq - (m l q''/2)(2 l/3) dq = -(m g (l/2) sin q + m l² q''/3) dq",
        _exact(_virtual, "the ledger of virtual work"),
    ),
    Check(
        "1.27 c",
        "m l² q''/3 + m g (l/2) sin q = 0",
        _exact(lambda p: p.m * p.l**2 / 3 * p.a + p.m * p.g * p.l / 2 * p.sin - p.row),
    ),
)
