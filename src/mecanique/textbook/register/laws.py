"""Sections 1.2 and 1.3.1: degrees of freedom, and the laws of Newton and Euler.

The laws of a body are checked on a rigid cloud of particles, thrown and turning.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from mecanique.derivation.scalars.series import Series
from mecanique.derivation.symbolic.newton_euler import NewtonEuler
from mecanique.model import Body, Floating, Force, Mechanism, Torque, cloud
from mecanique.reference import Reference
from mecanique.textbook import load
from mecanique.textbook.register.row import Row, agreement, identity

_G = (0.0, 0.0, -9.81)
_PUSH, _AT, _COUPLE = (3.0, -2.0, 5.0), (0.4, 0.1, -0.3), (0.7, 0.2, -1.1)
_CLOUD = (
    "sums over 30 particles of a rigid cloud, thrown and turning under weight, a force and a "
    "couple, against "
)


def rows() -> Iterator[Row]:
    """Yield the rows of the sections."""
    yield _degrees_of_freedom()
    yield from _particle()
    yield from _cloud()
    yield from _plate()


def _degrees_of_freedom() -> Row:
    from sympy import Matrix, symbols

    x, y, z, R = symbols("x y z R", positive=True)
    circle = Matrix([z, x**2 + y**2 - R**2]).jacobian([x, y, z]).rank()
    ends = symbols("x1 y1 z1 x2 y2 z2")
    length = sum((b - a) ** 2 for a, b in zip(ends[:3], ends[3:], strict=True))
    rod = Matrix([length]).jacobian(ends).rank()
    return agreement(
        "sect. 1.2",
        "N = 3 n_p - b: a particle on a circle has 1, two on a rigid rod have 5",
        "3 n_p less the rank of the constraints against the velocities of the systems: 1 on a "
        "circle, 5 for two particles on a rod",
        (float(3 - circle), float(load("particle_on_circle").nv)),
        (float(6 - rod), float(load("dumbbell").nv)),
    )


def _particle() -> Iterator[Row]:
    bodies = NewtonEuler(load("free_particle"))
    (*_, cut) = bodies.cuts.bodies
    a = [bodies.algebra.ring[name] for name in bodies.algebra.accelerations]
    components = list(zip(cut.push, cut.weight, a, bodies.derivation().rows, strict=True))
    yield identity(
        "1.1",
        "F = dp/dt = d(m v)/dt = m a for a particle",
        "d/dt(m v) of a free particle against m a, and against its weight",
        *(push - cut.mass * a for push, _, a, _ in components),
        *(push - weight - row for push, weight, _, row in components),
    )
    yield identity(
        "1.21",
        "d'Alembert for a particle: F - m a = 0",
        "weight and -m a of a free particle, whose sum is the equation of motion",
        *(weight - push + row for push, weight, _, row in components),
    )


def _cloud() -> Iterator[Row]:
    random = np.random.default_rng(1)
    masses, points = random.uniform(0.1, 1.0, 30), random.normal(size=(30, 3))
    mechanism = Mechanism(
        "cloud",
        (Body("ground"), Body("body", cloud(masses.tolist(), points.tolist()))),
        (Floating("flight", "ground", "body"),),
        forces=(Force("push", "body", _AT, _PUSH), Torque("couple", "body", _COUPLE)),
        gravity=_G,
    )
    engine = Reference(mechanism)
    q = mechanism.position(np.concatenate([random.normal(size=3), random.normal(size=4)]))
    velocities = random.normal(size=6)
    accelerations = engine.acceleration(q, velocities)
    center = mechanism.evaluate_all(mechanism.body("body").center)
    C = engine.point("body", center, q, velocities, accelerations)
    m, momentum = float(masses.sum()), engine.momentum(q, velocities)
    at = engine.point("body", _AT, q).position
    F = m * np.array(_G) + np.array(_PUSH)
    M_o = np.cross(C.position, m * np.array(_G)) + np.cross(at, _PUSH) + np.array(_COUPLE)
    M_C = M_o - np.cross(C.position, F)

    motions = [engine.point("body", point, q, velocities, accelerations) for point in points]
    r = np.array([motion.position for motion in motions])
    v = np.array([motion.velocity for motion in motions])
    a = np.array([motion.acceleration for motion in motions])
    rho, rho_rate = r - C.position, v - C.velocity
    p, p_rate = masses @ v, masses @ a
    H_o, H_o_rate = masses @ np.cross(r, v), masses @ np.cross(r, a)
    H_C, H_C_rate = masses @ np.cross(rho, v), masses @ np.cross(rho, a)

    newton = ((p_rate, F), (p_rate, m * C.acceleration))
    yield agreement(
        "1.2", "dp/dt = F = m a_C for a system of particles", _CLOUD + "F and m a_C", *newton
    )
    yield agreement(
        "1.3",
        "dH_o/dt = M_o or dH_C/dt = M_C",
        _CLOUD + "M_o and M_C",
        (H_o_rate, M_o),
        (H_C_rate, M_C),
    )
    yield agreement(
        "1.4",
        "linear momentum of a body: p = ∫ v dm",
        _CLOUD + "the engine's linear momentum",
        (p, momentum.linear),
    )
    yield agreement(
        "1.5",
        "center of mass: r_C = ∫ r dm / m",
        _CLOUD + "the body's center of mass",
        (masses @ r / m, C.position),
    )
    yield agreement(
        "1.6",
        "its velocity and acceleration: v_C = ∫ v dm / m, a_C = ∫ a dm / m",
        _CLOUD + "velocity and acceleration of the center of mass",
        (p / m, C.velocity),
        (p_rate / m, C.acceleration),
    )
    yield agreement("1.7", "p = ∫ v dm = m v_C", _CLOUD + "m v_C", (p, m * C.velocity))
    yield agreement("1.8", "dp/dt = m a_C = F for a body", _CLOUD + "F and m a_C", *newton)
    yield agreement(
        "1.9",
        "angular momentum about a fixed point: H_o = ∫ r × v dm",
        _CLOUD + "the engine's angular momentum about o",
        (H_o, momentum.angular),
    )
    yield agreement("1.10", "dH_o/dt = M_o", _CLOUD + "the resultant moment M_o", (H_o_rate, M_o))
    yield agreement(
        "1.11",
        "H_C = ∫ rho × v dm = ∫ rho × rho' dm",
        "both sums over 30 particles against each other and against the engine's H_C",
        (H_C, masses @ np.cross(rho, rho_rate)),
        (H_C, momentum.angular_about_center),
    )
    yield agreement("1.12", "dH_C/dt = M_C", _CLOUD + "the resultant moment M_C", (H_C_rate, M_C))


def _plate() -> Iterator[Row]:
    """Yield the laws in a plane, on a floor plate that turns about its corner."""
    bodies = NewtonEuler(load("rotating_plate"))
    (cut,) = bodies.cuts.bodies
    ring = bodies.algebra.ring
    m, a, b, k, theta, alpha = (ring[name] for name in ("m", "a", "b", "k", "theta", "theta''"))
    I_o, I_C = m * (a**2 + b**2) / 3, m * (a**2 + b**2) / 12
    lever = cut.center[0] * cut.push[1] - cut.center[1] * cut.push[0]
    M_o = cut.loads().moment.z
    yield identity(
        "1.13",
        "in a plane: M_o = I_o omega' or M_C = I_C omega'",
        "moments of the rates of momentum of a floor plate on a corner: I_o theta'', I_C theta''",
        cut.turning[2] - I_o * alpha,
        cut.turning[2] - lever - I_C * alpha,
        I_o * alpha - M_o - bodies.derivation().rows[0],
        M_o + k * theta,
    )
    # with the reactions that follow from the motion, forces and inertia forces are in equilibrium
    balances = zip(bodies.balances.resultant(cut), cut.push, strict=True)
    yield identity(
        "1.22",
        "for a body in a plane: F - m a_C = 0, M_o - I_o omega' = 0",
        "resultants of the inertia forces of a plate with its weight and reactions",
        *(_without_reactions(force - push, bodies) for force, push in balances),
        cut.turning[2] - I_o * alpha,
    )


def _without_reactions(series: Series, bodies: NewtonEuler) -> Series:
    """Replace each reaction by its closed form."""
    reactions = bodies.balances.reactions
    coefficients, rest = series.linear(list(reactions))
    parts = [c * R for c, R in zip(coefficients, reactions.values(), strict=True)]
    return bodies.algebra.ring.sum([rest, *parts])
