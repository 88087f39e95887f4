"""Section 1.3.3: Lagrange's equations, and the kinetic energy of rigid bodies."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from mecanique.derivation.numeric.lagrange import Definition
from mecanique.derivation.numeric.newton_euler import Balances
from mecanique.derivation.scalars.elementary import cos, sin
from mecanique.derivation.states import States
from mecanique.derivation.symbolic.lagrange import Lagrange
from mecanique.derivation.symbolic.newton_euler import NewtonEuler
from mecanique.derivation.symbolic.symbols import Algebra
from mecanique.textbook import load
from mecanique.textbook.register.row import Check, Finding, compared, identical

__all__ = ["CHECKS"]


def _operator(name: str, of_lagrangian: bool) -> Finding:
    """Lagrange's operator written out here, on T and V, against the balances of Newton and Euler."""
    mechanism = load(name)
    algebra = Algebra(mechanism)
    lagrange = Lagrange(mechanism, algebra)
    rows = NewtonEuler(mechanism, algebra).derivation().rows
    T, V, ring = lagrange.T, lagrange.V, algebra.ring
    differences = []
    for k, q in enumerate(mechanism.coordinates):
        rate = ring[f"{q}'"]
        if of_lagrangian:
            L = T - V
            left = L.diff(rate).ddt() - L.diff(q)
        else:
            left = T.diff(rate).ddt() - T.diff(q) + V.diff(q)
        forces = ring.sum([work.forces[k] for work in lagrange.works if work.kind != "potential"])
        differences.append(left - forces - rows[k])
    how = f"the operator applied to T and V of {name}, against Newton and Euler's equations of the same system"
    return identical(differences, how)


def _pendulum(difference: Callable[[Any, Lagrange], Any], how: str) -> Callable[[], Finding]:
    def check() -> Finding:
        mechanism = load("rigid_bar_pendulum")
        lagrange = Lagrange(mechanism, Algebra(mechanism))
        return identical(difference(lagrange.algebra.ring, lagrange), how)

    return check


def _kinetic(r: Any, lagrange: Lagrange) -> list[Any]:
    from sympy import integrate, symbols

    s, mu, length, m, v = symbols("s mu l m v", positive=True)
    whole = integrate(mu * v**2 * s**2 / 2, (s, 0, length)).subs(mu, m / length)
    return [lagrange.T - r["m"] * r["l"] ** 2 * r["q'"] ** 2 / 6, whole - m * length**2 * v**2 / 6]


def _potential(r: Any, lagrange: Lagrange) -> Any:
    """The printed V less the derived one is a constant."""
    q = r["q"]
    printed = r["m"] * r["g"] * (r["l"] / 2 - r["l"] / 2 * cos(q))
    return [(printed - lagrange.V).diff("q"), (printed - lagrange.V) - r["m"] * r["g"] * r["l"] / 2]


def _terms(r: Any, lagrange: Lagrange) -> list[Any]:
    m, length, g, q, v, a = (r[name] for name in ("m", "l", "g", "q", "q'", "q''"))
    T, V = lagrange.T, lagrange.V
    momentum = T.diff(v)
    return [
        momentum - m * length**2 / 3 * v,
        momentum.ddt() - m * length**2 / 3 * a,
        T.diff("q"),
        V.diff("q") - m * g * length / 2 * sin(q),
        momentum.ddt() - T.diff("q") + V.diff("q") - lagrange.derivation().rows[0],
    ]


def _rigid() -> Finding:
    """T of a rigid body in space, against the sum over all mass by mass moments."""
    pairs = []
    for name in ("free_rigid_body", "heavy_top", "gyroscope"):
        mechanism = load(name)
        random = np.random.default_rng(2)
        q, v = random.normal(size=(20, mechanism.nq)), random.normal(size=(20, mechanism.nv))
        states = States.of(mechanism, q, v)
        pairs.append(
            (Balances(mechanism).energy(states)[0], Definition(mechanism).energy(states)[0])
        )
    return compared(
        pairs,
        "½ m v_C² + ½ H_C·omega against ∫ ½ v² dm by mass moments, three systems at 20 states",
    )


def _planar() -> Finding:
    mechanism = load("free_planar_body")
    lagrange = Lagrange(mechanism, Algebra(mechanism))
    ring = lagrange.algebra.ring
    x, z, theta = (f"{name}'" for name in mechanism.coordinates)
    body = next(body for body in mechanism.bodies if body.name != mechanism.ground)
    m, inertia = lagrange.algebra.series(body.mass), lagrange.algebra.series(body.inertia[1])
    given = m * (ring[x] ** 2 + ring[z] ** 2) / 2 + inertia * ring[theta] ** 2 / 2
    return identical(
        lagrange.T - given, "T of a plate thrown in its own plane, with I_C of the table of bodies"
    )


def _fixed() -> Finding:
    mechanism = load("rotating_plate")
    lagrange = Lagrange(mechanism, Algebra(mechanism))
    m, a, b, rate = (lagrange.algebra.ring[name] for name in ("m", "a", "b", "theta'"))
    plate = lagrange.T - m * (a**2 + b**2) / 3 * rate**2 / 2
    mechanism = load("rigid_bar_pendulum")
    rod = Lagrange(mechanism, Algebra(mechanism))
    m, length, rate = (rod.algebra.ring[name] for name in ("m", "l", "q'"))
    return identical(
        [plate, rod.T - m * length**2 / 3 * rate**2 / 2],
        "T of a floor plate on its corner and of the rod pendulum, I_o = m l²/3",
    )


CHECKS = (
    Check(
        "1.28",
        "d/dt dT/dq' - dT/dq + dV/dq = 0 without non-conservative forces",
        lambda: _operator("double_pendulum", False),
    ),
    Check(
        "1.29",
        "d/dt dT/dq' - dT/dq + dV/dq = Q with non-conservative forces Q",
        lambda: _operator("cart_pole", False),
    ),
    Check("1.30", "with L = T - V: d/dt dL/dq' - dL/dq = Q", lambda: _operator("cart_pole", True)),
    Check(
        "1.30 a",
        "rod pendulum: T = ∫ ½ mu q'² s² ds = m l² q'²/6",
        _pendulum(_kinetic, "the integral, and the derived kinetic energy"),
    ),
    Check(
        "1.30 b",
        "V = V_o + m g (l/2 - (l/2) cos q)",
        _pendulum(_potential, "the derived potential energy, up to a constant"),
    ),
    Check(
        "1.30 c",
        "dT/dq' = m l² q'/3, its rate m l² q''/3, dT/dq = 0, dV/dq = (m g l/2) sin q",
        _pendulum(_terms, "the derived terms"),
    ),
    Check("1.31", "T = ½ m v_C² + ½ H_C·omega of a rigid body", _rigid),
    Check("1.32", "in a plane: T = ½ m v_C² + ½ I_C omega²", _planar),
    Check("1.33", "about a fixed point: T = ½ I_o omega²; of the rod m l² q'²/6", _fixed),
)
