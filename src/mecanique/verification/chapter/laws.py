"""Sections 1.2 and 1.3.1: degrees of freedom, and the laws of Newton and Euler.

The laws of a body are checked on a rigid cloud of particles, thrown and turning.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import combinations

import numpy as np

from mecanique.derivation.methods import derivations
from mecanique.derivation.printing.expressions import to_sympy
from mecanique.derivation.scalars.series import Series
from mecanique.derivation.symbolic.lagrange import Lagrange
from mecanique.derivation.symbolic.newton_euler import NewtonEuler
from mecanique.model import Body, Floating, Force, Mechanism, Torque, cloud
from mecanique.model.mechanism.homogeneity import dimensions_of
from mecanique.model.units import read_unit
from mecanique.reference import Reference
from mecanique.textbook import load
from mecanique.verification.chapter.row import ChapterRow, agreement, decision, identity, misprint

_G = (0.0, 0.0, -9.81)
_PUSH, _AT, _COUPLE = (3.0, 2.0, 5.0), (0.4, 0.1, 0.3), (0.7, 0.2, 1.1)
_CLOUD = (
    "sums over 30 particles of a rigid cloud, thrown and turning under weight, a force and a "
    "couple, against "
)


def rows() -> Iterator[ChapterRow]:
    """Yield the rows of the sections."""
    yield _degrees_of_freedom()
    yield from _particle()
    yield from _cloud()
    yield from _plate()


def _degrees_of_freedom() -> ChapterRow:
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


def _particle() -> Iterator[ChapterRow]:
    bodies = NewtonEuler(load("free_particle"))
    (*_, cut) = bodies.cuts.bodies
    a = [bodies.algebra.ring[name] for name in bodies.algebra.accelerations]
    components = list(
        zip(cut.push.force, cut.weight.force, a, bodies.derivation().rows, strict=True)
    )
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


def _cloud() -> Iterator[ChapterRow]:
    random = np.random.default_rng(1)
    masses = random.uniform(0.1, 1.0, 30)
    points = random.normal(size=(30, 3))
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
    m = float(masses.sum())
    momentum = engine.momentum(q, velocities)
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


def _plate() -> Iterator[ChapterRow]:
    """Yield the laws in a plane, on a floor plate that turns about its corner."""
    bodies = NewtonEuler(load("rotating_plate"))
    (cut,) = bodies.cuts.bodies
    ring = bodies.algebra.ring
    m, a, b, k, theta, alpha = (ring[name] for name in ("m", "a", "b", "k", "theta", "theta''"))
    I_o, I_C = m * (a**2 + b**2) / 3, m * (a**2 + b**2) / 12
    push, turning = cut.push.force, cut.push.moment
    lever = cut.center[0] * push[1] - cut.center[1] * push[0]
    M_o = cut.loads().moment.z
    yield identity(
        "1.13",
        "in a plane: M_o = I_o omega' or M_C = I_C omega'",
        "moments of the rates of momentum of a floor plate on a corner: I_o theta'', I_C theta''",
        turning[2] - I_o * alpha,
        turning[2] - lever - I_C * alpha,
        I_o * alpha - M_o - bodies.derivation().rows[0],
        M_o + k * theta,
    )
    # with the reactions that follow from the motion, forces and inertia forces are in equilibrium
    balances = zip(bodies.balances.acting(cut).force, push, strict=True)
    yield identity(
        "1.22",
        "for a body in a plane: F - m a_C = 0, M_o - I_o omega' = 0",
        "resultants of the inertia forces of a plate with its weight and reactions",
        *(_without_reactions(force - rate, bodies) for force, rate in balances),
        turning[2] - I_o * alpha,
    )


def _without_reactions(series: Series, bodies: NewtonEuler) -> Series:
    """Replace each reaction by its closed form."""
    reactions = bodies.balances.reactions
    coefficients, rest = series.linear(list(reactions))
    parts = [c * R for c, R in zip(coefficients, reactions.values(), strict=True)]
    return bodies.algebra.ring.sum([rest, *parts])


def sentences() -> Iterator[ChapterRow]:
    """Yield the rows of the sections."""
    yield _frames()
    yield from _freedom()
    yield from _methods()
    yield _angular_momenta()
    yield _two_integrals()
    yield _in_space()
    yield _plane()
    yield _generalized_forces()


def _frames() -> ChapterRow:
    from sympy import Function, Matrix, Symbol, cos, sin, symbols

    t, W = symbols("t W")
    r = Matrix([Function(name)(t) for name in "xyz"])
    moved = r - Matrix(symbols("a b c")) - t * Matrix(symbols("d e f"))
    turn = Matrix([[cos(W * t), sin(W * t), 0], [-sin(W * t), cos(W * t), 0], [0, 0, 1]])
    seen, spin = turn * r, Matrix([0, 0, Symbol("W")])
    apparent = 2 * spin.cross(seen.diff(t)) + spin.cross(spin.cross(seen))
    return identity(
        "sect. 1.1 b",
        "a frame in uniform translation serves as an inertial one; one that turns does not",
        "accelerations of a particle in both: the same, and less 2 Omega × v + Omega × (Omega × r)",
        *(moved - r).diff(t, 2),
        *(seen.diff(t, 2) + apparent - turn * r.diff(t, 2)),
    )


def _freedom() -> Iterator[ChapterRow]:
    """Yield what is said of degrees of freedom."""
    five = np.random.default_rng(3).normal(size=(5, 3))
    kept = list(combinations(range(5), 2))
    J = np.zeros((len(kept), 5, 3))
    for row, (i, j) in zip(J, kept, strict=True):
        row[i], row[j] = five[i] - five[j], five[j] - five[i]
    rank = int(np.linalg.matrix_rank(J.reshape(len(kept), 15)))
    body = load("free_rigid_body").nv
    counted = misprint(
        "sect. 1.2 a",
        "b constraint equations leave n_p particles N = 3 n_p - b degrees of freedom",
        "five particles at fixed distances, 10 equations, against the velocities of a rigid body",
        [15 - len(kept) - body],
        [15 - rank - body],
        right="b counts independent constraints only",
        proof="of the 10 distances between five points of a body 9 are independent: 15 - 9 = 6",
    )
    yield replace(counted, kind="computed")
    spins = np.array([[(0, z, -y), (-z, 0, x), (y, -x, 0)] for x, y, z in five])
    moves = np.concatenate([np.broadcast_to(np.eye(3), (5, 3, 3)), spins], axis=2)
    flat = moves[:, :, [0, 1, 5]]
    yield agreement(
        "sect. 1.2 b",
        "a free rigid body has six degrees of freedom, in plane motion at most three",
        "the rank of the velocities of five points of a body by those of one point and its turning",
        (float(np.linalg.matrix_rank(moves.reshape(15, 6))), 6.0),
        (float(np.linalg.matrix_rank(flat.reshape(15, 3))), 3.0),
        (float(body), 6.0),
        (float(load("free_planar_body").nv), 3.0),
    )


def _methods() -> Iterator[ChapterRow]:
    names = ("rigid_bar_pendulum", "two_blocks", "double_pendulum", "cart_pole")
    differences = []
    for name in names:
        first, *others = derivations(load(name)).values()
        for method in others:
            differences += [a - b for a, b in zip(first.rows, method.rows, strict=True)]
    yield identity(
        "sect. 1.3",
        "all formulations give the same equations of motion, up to a linear transformation",
        f"the rows of three methods for {', '.join(names)}",
        *differences,
    )


def _angular_momenta() -> ChapterRow:
    from sympy import Function, Symbol, symbols

    m, l = symbols("m l", positive=True)
    t = Symbol("t")
    q = Function("q")(t)
    H = m * l**2 / 3 * q.diff(t)
    rate = m * l**2 / 3 * q.diff(t, 2)
    return misprint(
        "after 1.3",
        "the dotted letters of eq. 1.3 are called the angular momenta about o and C",
        "the angular momentum of the rod of eq. 1.15 and its rate of eq. 1.16",
        [rate - H],
        [H.diff(t) - rate],
        right="the dotted letters are the rates of the angular momenta H_o and H_C",
        proof="eqs. 1.10 and 1.12 equate a rate with a moment; the momentum itself has no dot",
    )


def _two_integrals() -> ChapterRow:
    from sympy import Matrix, symbols

    masses = symbols("m1:4", positive=True)
    points = [Matrix(symbols(f"x{k} y{k} z{k}")) for k in range(3)]
    rates = [Matrix(symbols(f"u{k} v{k} w{k}")) for k in range(3)]
    total = sum(masses)

    def mean(vectors: list[Matrix]) -> Matrix:
        whole = Matrix([0, 0, 0])
        for m, vector in zip(masses, vectors, strict=True):
            whole += m * vector
        return whole / total

    def gap(P: Matrix, moving: Matrix) -> Matrix:
        """By how much the two integrals of eq. 1.11 differ at a moving point."""
        whole = Matrix([0, 0, 0])
        for m, r, v in zip(masses, points, rates, strict=True):
            whole += m * ((r - P).cross(v) - (r - P).cross(v - moving))
        return whole

    P, moving = Matrix(symbols("a b c")), Matrix(symbols("d e f"))
    return identity(
        "after 1.11",
        "the two integrals of eq. 1.11 agree at C, and in general not at another moving point P",
        "three particles: the difference is m rho_C × v_P, which vanishes at C",
        *gap(mean(points), mean(rates)),
        *(gap(P, moving) - total * (mean(points) - P).cross(moving)),
    )


def _in_space() -> ChapterRow:
    box = load("tennis_racket")
    rows = Lagrange(box).derivation().rows
    degrees = {sum(powers) for row in rows for powers in row.coefficients(box.velocities)}
    held = {g.name for row in rows for g in row.generators()}
    return decision(
        "after 1.12 b",
        "in space angular momentum gives nonlinear equations of first order in angular velocities",
        "letters of the balances of a free box: products of two, their rates, and no coordinate",
        2 in degrees,
        held >= {f"{rate}'" for rate in box.velocities},
        not held & set(box.coordinates),
    )


def _plane() -> ChapterRow:
    from sympy import Function, Symbol, cos, sin, symbols

    m, I_C, c = symbols("m I_C c", positive=True)
    t = Symbol("t")
    x, y, theta = (Function(name)(t) for name in ("x", "y", "theta"))
    H_o = m * (x * y.diff(t) - y * x.diff(t)) + I_C * theta.diff(t)
    I_o = I_C + m * (x**2 + y**2)
    thrown = H_o.diff(t) - I_o * theta.diff(t, 2)
    pinned = thrown.subs({x: c * cos(theta), y: c * sin(theta)}).doit()
    at_C = (H_o - m * (x * y.diff(t) - y * x.diff(t))).diff(t) - I_C * theta.diff(t, 2)
    return misprint(
        "after 1.12",
        "in any plane motion M_o = I_o omega' about a stationary point o; so eqs. 1.13, 1.22",
        "the rate of H_o of a body thrown in a plane against I_o omega'",
        [thrown],
        [pinned, at_C],
        right="o must be a point of the body that does not move, or C is taken",
        proof="about another stationary point dH_o/dt = r_C × m a_C + I_C omega'; it is I_o omega' "
        "where the body turns about o",
    )


def _generalized_forces() -> ChapterRow:
    facts = []
    for name, coordinate, unit in (("rigid_bar_pendulum", "q", "N·m"), ("two_blocks", "q1", "N")):
        lagrange = Lagrange(load(name))
        slope = to_sympy(lagrange.V.diff(coordinate))
        facts.append(dimensions_of(load(name)).of(slope) == read_unit(unit))
    return decision(
        "after 1.29",
        "a generalized force need be no force: that of a rotation is a moment (footnote)",
        "units of dV/dq for the angle of the rod and for the displacement of a block",
        *facts,
    )
