"""Sections 1.2 and 1.3.1: degrees of freedom, and the laws of Newton and Euler, checked on a cloud of particles."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any, final

import numpy as np
import numpy.typing as npt

from mecanique.derivation.symbolic.newton_euler import NewtonEuler
from mecanique.model import Body, Floating, Force, Mechanism, Torque, cloud
from mecanique.reference import Reference
from mecanique.textbook import load
from mecanique.textbook.register.row import Check, Finding, compared, identical

__all__ = ["CHECKS"]

Array = npt.NDArray[np.float64]

_G = (0.0, 0.0, -9.81)
_PUSH, _AT, _COUPLE = (3.0, -2.0, 5.0), (0.4, 0.1, -0.3), (0.7, 0.2, -1.1)
_CLOUD = "sums over 30 particles of a rigid cloud, thrown and turning under weight, a force and a couple, against "


@final
@dataclass(frozen=True, eq=False)
class _Cloud:
    """A rigid cloud of particles in one state of motion, and what the engine says of the rigid body.

    Args:
        masses: shape (n,) [kg].
        r: shape (n, 3), positions [m].
        v: shape (n, 3), velocities [m/s].
        a: shape (n, 3), accelerations [m/s²].
        center: motion of the center of mass.
        momentum: of the body.
        force: resultant of the external forces [N].
        moment: their moment about the world's origin [N·m].
    """

    masses: Array
    r: Array
    v: Array
    a: Array
    center: Any
    momentum: Any
    force: Array
    moment: Array

    @property
    def mass(self) -> float:
        """Mass of the body [kg]."""
        return float(self.masses.sum())


@cache
def _thrown() -> _Cloud:
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
    v = random.normal(size=6)
    a = engine.acceleration(q, v)
    motions = [engine.point("body", point, q, v, a) for point in points]
    center = [mechanism.evaluate(component) for component in mechanism.body("body").center]
    middle = engine.point("body", center, q, v, a)
    weight, push = masses.sum() * np.array(_G), np.array(_PUSH)
    at = engine.point("body", _AT, q, v, a).position
    moment = np.cross(middle.position, weight) + np.cross(at, push) + np.array(_COUPLE)
    r, rate, second = (
        np.array([getattr(m, name) for m in motions])
        for name in ("position", "velocity", "acceleration")
    )
    return _Cloud(masses, r, rate, second, middle, engine.momentum(q, v), weight + push, moment)


def _sum(values: Array) -> Array:
    """Σ m x over the particles."""
    return np.asarray(_thrown().masses @ values)


def _newton() -> Finding:
    bodies = NewtonEuler(load("free_particle"))
    (*_, cut) = bodies.cuts.bodies
    ring = bodies.algebra.ring
    mass = cut.mass
    accelerations = [ring[name] for name in bodies.algebra.accelerations]
    push = [p - mass * a for p, a in zip(cut.push, accelerations, strict=True)]
    rows = list(bodies.derivation().rows)
    balance = [p - w - row for p, w, row in zip(cut.push, cut.weight, rows, strict=True)]
    return identical(
        [*push, *balance], "d/dt(m v) of a free particle against m a, and against its weight"
    )


def _first(about: str) -> Finding:
    c = _thrown()
    middle = c.center
    if about == "p":
        return compared(
            [(_sum(c.a), c.force), (_sum(c.a), c.mass * middle.acceleration)],
            _CLOUD + "F and m a_C",
        )
    o = (_sum(np.cross(c.r, c.a)), c.moment)
    rho = c.r - middle.position
    g = (_sum(np.cross(rho, c.a)), c.moment - np.cross(middle.position, c.force))
    if about == "o":
        return compared([o], _CLOUD + "the resultant moment M_o")
    if about == "C":
        return compared([g], _CLOUD + "the resultant moment M_C")
    return compared([o, g], _CLOUD + "M_o and M_C")


def _momentum() -> Finding:
    return compared(
        [(_sum(_thrown().v), _thrown().momentum.linear)], _CLOUD + "the engine's linear momentum"
    )


def _center() -> Finding:
    c = _thrown()
    return compared([(_sum(c.r) / c.mass, c.center.position)], _CLOUD + "the body's center of mass")


def _center_rates() -> Finding:
    c = _thrown()
    pairs = [(_sum(c.v) / c.mass, c.center.velocity), (_sum(c.a) / c.mass, c.center.acceleration)]
    return compared(pairs, _CLOUD + "velocity and acceleration of the center of mass")


def _by_center() -> Finding:
    c = _thrown()
    return compared([(_sum(c.v), c.mass * c.center.velocity)], _CLOUD + "m v_C")


def _moment_of_momentum() -> Finding:
    c = _thrown()
    return compared(
        [(_sum(np.cross(c.r, c.v)), c.momentum.angular)],
        _CLOUD + "the engine's angular momentum about o",
    )


def _about_center() -> Finding:
    c = _thrown()
    rho, rate = c.r - c.center.position, c.v - c.center.velocity
    whole = _sum(np.cross(rho, c.v))
    pairs = [(whole, _sum(np.cross(rho, rate))), (whole, c.momentum.angular_about_center)]
    return compared(
        pairs, "both sums over 30 particles against each other and against the engine's H_C"
    )


def _planar() -> Finding:
    """The floor plate: the moments of the rates of momentum are I θ'', about the corner and about the center."""
    bodies = NewtonEuler(load("rotating_plate"))
    (cut,) = bodies.cuts.bodies
    ring = bodies.algebra.ring
    m, a, b, k, theta, alpha = (ring[name] for name in ("m", "a", "b", "k", "theta", "theta''"))
    corner, center = m * (a**2 + b**2) / 3, m * (a**2 + b**2) / 12
    lever = cut.center[0] * cut.push[1] - cut.center[1] * cut.push[0]
    _, applied = cut.loads()
    moved = (corner * alpha - applied[2]) - bodies.derivation().rows[0]
    parts = [
        cut.turning[2] - corner * alpha,
        cut.turning[2] - lever - center * alpha,
        moved,
        applied[2] + k * theta,
    ]
    return identical(
        parts,
        "moments of the rates of momentum of a floor plate on a corner: I_o theta'', I_C theta''",
    )


def _dalembert() -> Finding:
    bodies = NewtonEuler(load("rotating_plate"))
    (cut,) = bodies.cuts.bodies
    inertia = [-p for p in cut.push]
    resultant = bodies.resultant(cut)
    # with the reactions as they follow from the motion, forces and inertia forces are in
    # equilibrium
    ring = bodies.algebra.ring
    total = [r + i for r, i in zip(resultant, inertia, strict=True)]
    closed = [_substituted(series, bodies) for series in total]
    m, a, b, alpha = (ring[name] for name in ("m", "a", "b", "theta''"))
    turned = cut.turning[2] - m * (a**2 + b**2) / 3 * alpha
    return identical(
        [*closed, turned],
        "resultants of the inertia forces of a plate with its weight and reactions",
    )


def _substituted(series: Any, bodies: NewtonEuler) -> Any:
    """A series with each reaction replaced by its closed form."""
    names = list(bodies.reactions)
    coefficients, rest = series.linear(names)
    ring = bodies.algebra.ring
    return ring.sum(
        [rest, *(c * bodies.reactions[name] for c, name in zip(coefficients, names, strict=True))]
    )


def _particle() -> Finding:
    bodies = NewtonEuler(load("free_particle"))
    (*_, cut) = bodies.cuts.bodies
    rows = bodies.derivation().rows
    return identical(
        [w - p + row for w, p, row in zip(cut.weight, cut.push, rows, strict=True)],
        "weight and -m a of a free particle, whose sum is the equation of motion",
    )


def _freedom() -> Finding:
    """N = 3 n_p − b, with b the rank of the constraints' derivatives."""
    from sympy import Matrix, symbols

    x, y, z, R = symbols("x y z R", positive=True)
    circle = Matrix([z, x**2 + y**2 - R**2]).jacobian([x, y, z]).rank()
    coordinates = symbols("x1 y1 z1 x2 y2 z2")
    rod = Matrix([sum((b - a) ** 2 for a, b in zip(coordinates[:3], coordinates[3:], strict=True))])
    joined = rod.jacobian(coordinates).rank()
    counts = [(3 - circle, load("particle_on_circle").nv), (6 - joined, load("dumbbell").nv)]
    return compared(
        [(float(a), float(b)) for a, b in counts],
        "3 n_p less the rank of the constraints against the "
        "velocities of the systems: 1 on a circle, 5 for two particles on a rod",
    )


CHECKS = (
    Check(
        "sect. 1.2",
        "N = 3 n_p - b: a particle on a circle has 1, two on a rigid rod have 5",
        _freedom,
    ),
    Check("1.1", "F = dp/dt = d(m v)/dt = m a for a particle", _newton),
    Check("1.2", "dp/dt = F = m a_C for a system of particles", lambda: _first("p")),
    Check("1.3", "dH_o/dt = M_o or dH_C/dt = M_C", lambda: _first("both")),
    Check("1.4", "linear momentum of a body: p = ∫ v dm", _momentum),
    Check("1.5", "center of mass: r_C = ∫ r dm / m", _center),
    Check(
        "1.6", "its velocity and acceleration: v_C = ∫ v dm / m, a_C = ∫ a dm / m", _center_rates
    ),
    Check("1.7", "p = ∫ v dm = m v_C", _by_center),
    Check("1.8", "dp/dt = m a_C = F for a body", lambda: _first("p")),
    Check("1.9", "angular momentum about a fixed point: H_o = ∫ r × v dm", _moment_of_momentum),
    Check("1.10", "dH_o/dt = M_o", lambda: _first("o")),
    Check("1.11", "H_C = ∫ rho × v dm = ∫ rho × rho' dm", _about_center),
    Check("1.12", "dH_C/dt = M_C", lambda: _first("C")),
    Check("1.13", "in a plane: M_o = I_o omega' or M_C = I_C omega'", _planar),
    Check("1.21", "d'Alembert for a particle: F - m a = 0", _particle),
    Check("1.22", "for a body in a plane: F - m a_C = 0, M_o - I_o omega' = 0", _dalembert),
)
