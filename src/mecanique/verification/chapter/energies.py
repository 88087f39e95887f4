"""Section 1.3.3: Lagrange's equations, and the kinetic energy of rigid bodies."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from mecanique.derivation.numeric.lagrange import LagrangeOnJets
from mecanique.derivation.numeric.newton_euler import Balances
from mecanique.derivation.scalars.elementary import cos, sin
from mecanique.derivation.scalars.series import Series
from mecanique.derivation.symbolic.lagrange import Lagrange
from mecanique.derivation.symbolic.newton_euler import NewtonEuler
from mecanique.derivation.symbolic.symbols import Algebra
from mecanique.model.states import States
from mecanique.textbook import load
from mecanique.verification.chapter.row import ChapterRow, agreement, identity

_OPERATOR = (
    "the operator applied to T and V of {}, against Newton and Euler's equations of the same system"
)


def rows() -> Iterator[ChapterRow]:
    """Yield the rows of the section."""
    yield identity(
        "1.28",
        "d/dt dT/dq' - dT/dq + dV/dq = 0 without non-conservative forces",
        _OPERATOR.format("double_pendulum"),
        *_differences("double_pendulum"),
    )
    yield identity(
        "1.29",
        "d/dt dT/dq' - dT/dq + dV/dq = Q with non-conservative forces Q",
        _OPERATOR.format("cart_pole"),
        *_differences("cart_pole"),
    )
    yield identity(
        "1.30",
        "with L = T - V: d/dt dL/dq' - dL/dq = Q",
        _OPERATOR.format("cart_pole"),
        *_differences("cart_pole", of_lagrangian=True),
    )
    yield from _rod_pendulum()
    yield agreement(
        "1.31",
        "T = ½ m v_C² + ½ H_C·omega of a rigid body",
        "½ m v_C² + ½ H_C·omega against ∫ ½ v² dm by mass moments, three systems at 20 states",
        *map(_both_energies, ("free_rigid_body", "heavy_top", "gyroscope")),
    )
    mechanism = load("free_planar_body")
    thrown = Lagrange(mechanism)
    (plate,) = (body for body in mechanism.bodies if body.name != mechanism.ground)
    vx, vz, omega = (thrown.algebra.ring[f"{name}'"] for name in mechanism.coordinates)
    m, I_C = thrown.algebra.series(plate.mass), thrown.algebra.series(plate.inertia[1])
    yield identity(
        "1.32",
        "in a plane: T = ½ m v_C² + ½ I_C omega²",
        "T of a plate thrown in its own plane, with I_C of the table of bodies",
        thrown.T - (m * (vx**2 + vz**2) / 2 + I_C * omega**2 / 2),
    )
    floor, rod = Lagrange(load("rotating_plate")), Lagrange(load("rigid_bar_pendulum"))
    m, a, b, omega = (floor.algebra.ring[name] for name in ("m", "a", "b", "theta'"))
    M, l, v = (rod.algebra.ring[name] for name in ("m", "l", "q'"))
    yield identity(
        "1.33",
        "about a fixed point: T = ½ I_o omega²; of the rod m l² q'²/6",
        "T of a floor plate on its corner and of the rod pendulum, I_o = m l²/3",
        floor.T - m * (a**2 + b**2) / 3 * omega**2 / 2,
        rod.T - M * l**2 / 3 * v**2 / 2,
    )


def _differences(name: str, *, of_lagrangian: bool = False) -> list[Series]:
    """Return Lagrange's equations, written out from T and V, minus Newton and Euler's."""
    mechanism = load(name)
    algebra = Algebra(mechanism)
    lagrange = Lagrange(mechanism, algebra)
    T, V, ring = lagrange.T, lagrange.V, algebra.ring
    L = T - V
    balances = NewtonEuler(mechanism, algebra).derivation().rows
    differences = []
    for k, q in enumerate(mechanism.coordinates):
        rate = ring[f"{q}'"]
        left = T.diff(rate).ddt() - T.diff(q) + V.diff(q)
        if of_lagrangian:
            left = L.diff(rate).ddt() - L.diff(q)
        Q = ring.sum([work.forces[k] for work in lagrange.works if work.kind != "potential"])
        differences.append(left - Q - balances[k])
    return differences


def _rod_pendulum() -> Iterator[ChapterRow]:
    from sympy import integrate, symbols

    lagrange = Lagrange(load("rigid_bar_pendulum"))
    T, V, ring = lagrange.T, lagrange.V, lagrange.algebra.ring
    m, l, g, q, v, a = (ring[name] for name in ("m", "l", "g", "q", "q'", "q''"))
    s, mu, length, mass, rate = symbols("s mu l m v", positive=True)
    whole = integrate(mu * rate**2 * s**2 / 2, (s, 0, length)).subs(mu, mass / length)
    yield identity(
        "1.30 a",
        "rod pendulum: T = ∫ ½ mu q'² s² ds = m l² q'²/6",
        "the integral, and the derived kinetic energy",
        T - m * l**2 * v**2 / 6,
        whole - mass * length**2 * rate**2 / 6,
    )
    constant = m * g * (l / 2 - l / 2 * cos(q)) - V
    yield identity(
        "1.30 b",
        "V = V_o + m g (l/2 - (l/2) cos q)",
        "the derived potential energy, up to a constant",
        constant.diff("q"),
        constant - m * g * l / 2,
    )
    momentum = T.diff(v)
    yield identity(
        "1.30 c",
        "dT/dq' = m l² q'/3, its rate m l² q''/3, dT/dq = 0, dV/dq = (m g l/2) sin q",
        "the derived terms",
        momentum - m * l**2 / 3 * v,
        momentum.ddt() - m * l**2 / 3 * a,
        T.diff("q"),
        V.diff("q") - m * g * l / 2 * sin(q),
        momentum.ddt() - T.diff("q") + V.diff("q") - lagrange.derivation().rows[0],
    )


def _both_energies(name: str) -> tuple[np.ndarray, np.ndarray]:
    """Return the kinetic energy of a system in space by its momenta, and summed over its mass."""
    mechanism = load(name)
    random = np.random.default_rng(2)
    q, v = random.normal(size=(20, mechanism.nq)), random.normal(size=(20, mechanism.nv))
    states = States.of(mechanism, q, v)
    return Balances(mechanism).energy(states)[0], LagrangeOnJets(mechanism).energy(states)[0]
