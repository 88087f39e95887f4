"""Sections 1.1 to 1.3: degrees of freedom, laws, the rod pendulum, energies, and the wording.

The laws of a body are checked on a rigid cloud of particles, thrown and turning. The pendulum's
components are along n (from the pin) and t (across).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from itertools import combinations
from typing import final

import numpy as np

from mecanique.derivation.methods import derivations
from mecanique.derivation.numeric.lagrange import LagrangeOnJets
from mecanique.derivation.numeric.newton_euler import Balances
from mecanique.derivation.printing.expressions import to_sympy
from mecanique.derivation.scalars.cancel import tidy
from mecanique.derivation.scalars.elementary import cos, sin
from mecanique.derivation.scalars.series import Kind, Series
from mecanique.derivation.symbolic.lagrange import Lagrange
from mecanique.derivation.symbolic.newton_euler import NewtonEuler
from mecanique.derivation.symbolic.symbols import Algebra
from mecanique.derivation.symbolic.vectors import along
from mecanique.derivation.symbolic.virtual_work import VirtualWork, distribution_of
from mecanique.model import Body, Floating, Force, Mechanism, Torque, cloud
from mecanique.model.mechanism.homogeneity import dimensions_of
from mecanique.model.states import States
from mecanique.model.units import read_unit
from mecanique.reference import Reference
from mecanique.textbook import entry, load
from mecanique.verification.chapter.row import (
    ChapterRow,
    agreement,
    decision,
    identity,
    misprint,
    misread,
    open_point,
)
from mecanique.verification.facts import Bench

_G = (0.0, 0.0, -9.81)
_PUSH, _AT, _COUPLE = (3.0, 2.0, 5.0), (0.4, 0.1, 0.3), (0.7, 0.2, 1.1)
_CLOUD = (
    "sums over 30 particles of a rigid cloud, thrown and turning under weight, a force and a "
    "couple, against "
)


def rows() -> Iterator[ChapterRow]:
    """Yield the rows of the numbered equations."""
    yield _degrees_of_freedom()
    yield from _particle()
    yield from _cloud()
    yield from _plate()
    rod = _Rod()
    yield from _balances(rod)
    yield from _distributed_forces(rod)
    yield from _work_on_rod(rod)
    yield from _energies()


def sentences() -> Iterator[ChapterRow]:
    """Yield the rows of the sentences that are computed."""
    yield _frames()
    yield from _freedom()
    yield from _methods()
    yield _angular_momenta()
    yield _two_integrals()
    yield _in_space()
    yield _plane()
    yield _generalized_forces()
    yield _unit_vectors()
    yield from _unknowns()
    yield _same_as_1_19()
    yield from _working()
    yield _absent()


def wording() -> Iterator[ChapterRow]:
    """Yield the rows of the sentences that are read, and of what is not checked."""
    yield from _wording()
    yield from _open_points()


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
    spins = np.cross(np.eye(3), five[:, None]).swapaxes(1, 2)
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


_BY = "the derivation of the pendulum in the catalogue, term by term"


@final
class _Rod:
    """The rod, cut free, and its equation of motion as the catalogue derives it."""

    def __init__(self) -> None:
        work = VirtualWork(load("rigid_bar_pendulum"))
        self.ledger = {stage.title: stage.results for stage in work.derivation().stages}
        self.bodies = work.balances
        (self.cut,) = self.bodies.cuts.bodies
        self.ring = self.bodies.algebra.ring
        self.letters = tuple(self.ring[name] for name in ("m", "l", "g", "q", "q'", "q''"))
        m, l, g, q, _, a = self.letters
        self.row = NewtonEuler(work.algebra.mechanism, work.algebra).derivation().rows[0]
        self.equation = a + 3 * g * sin(q) / (2 * l)
        self.difference = self.equation - 3 * self.row / (m * l**2)
        """Zero, if the derived equation is that of the book."""
        spread = distribution_of(self.bodies.cuts, self.cut)
        assert spread is not None
        self.spread = spread


def _balances(rod: _Rod) -> Iterator[ChapterRow]:
    """Newton and Euler's equations, and the motion near rest."""
    bodies, cut, row = rod.bodies, rod.cut, rod.row
    m, l, g, q, v, a = rod.letters
    axes, turns = cut.axes.rows, cut.axes.turns
    Rn, Rt = rod.ring["R_pin_n"], rod.ring["R_pin_t"]
    a_C = bodies.cuts.kinematics.change(cut.twist.force, cut.carrier)
    r_n, r_t, *_ = along(axes, cut.center)
    v_n, v_t, *_ = along(axes, cut.twist.force)
    a_n, a_t, *_ = along(axes, a_C)
    yield identity(
        "1.14 a",
        "r_C = (l/2) n, v_C = (l/2) q' t, a_C = -(l/2) q'² n + (l/2) q'' t",
        _BY,
        *(r_n - l / 2, r_t),
        *(v_n, v_t - l / 2 * v),
        *(a_n + l / 2 * v**2, a_t - l / 2 * a),
    )
    p_n, p_t, *_ = along(axes, cut.push.force)
    F_n, F_t, *_ = along(axes, bodies.acting(cut).force)
    yield identity(
        "1.14",
        "m a_C = (m g cos q - R_n) n + (R_t - m g sin q) t",
        _BY,
        *(p_n + m * l / 2 * v**2, p_t - m * l / 2 * a),
        *(F_n - (m * g * cos(q) - Rn), F_t - (Rt - m * g * sin(q))),
    )
    H_rate = along(turns, cut.about_reference(cut.push).moment)[2]
    M_o = along(turns, bodies.acting(cut).moment)[2]
    yield _angular_momentum(H_rate - m * l**2 / 3 * a)
    yield identity("1.16", "dH_o/dt = (m l²/3) q''", _BY, H_rate - m * l**2 / 3 * a)
    yield identity(
        "1.17",
        "(m l²/3) q'' = -(l/2) m g sin q",
        _BY,
        M_o + l / 2 * m * g * sin(q),
        H_rate - M_o - row,
    )
    yield identity("1.18", "q'' + (3 g/(2 l)) sin q = 0", _BY, rod.difference)
    yield identity("1.19", "the same equation of motion", _BY, rod.difference)
    yield _linearize()


def _distributed_forces(rod: _Rod) -> Iterator[ChapterRow]:
    """D'Alembert's forces along the rod, in balance with weight and reaction."""
    bodies, row = rod.bodies, rod.row
    m, l, g, q, v, a = rod.letters
    spread, mu = rod.spread, m / l
    s = rod.ring[spread.coordinate]
    yield identity(
        "1.23 a",
        "a = -s q'² n + s q'' t along the rod",
        "d'Alembert's distributed forces found from the poses",
        mu * s * v**2 - spread.density[0],
        -mu * s * a - spread.density[1],
    )
    yield identity(
        "1.23",
        "R_t - (1/2)(mu l q'') l - m g sin q = 0",
        "the reaction eliminated from the balances",
        bodies.reactions["R_pin_t"] - mu * l * a * l / 2 - m * g * sin(q),
    )
    yield identity(
        "1.24",
        "R_n - (1/2)(mu l q'²) l - m g cos q = 0",
        "the reaction eliminated from the balances",
        bodies.reactions["R_pin_n"] - mu * l * v**2 * l / 2 - m * g * cos(q),
    )
    moments = -(l / 2) * m * g * sin(q) - 2 * l / 3 * mu * l * a * l / 2
    yield identity("1.25", "-(l/2) m g sin q - (2 l/3)(1/2)(mu l q'') l = 0", _BY, moments + row)
    # eq. 1.25 times −3/(m l²) is the right form, and the derived equation times 3/(m l²) as well
    yield misprint(
        "1.26",
        "printed: q'' - (3/2)(g/l) sin q = 0, said to be identical to 1.19",
        "the printed left side against the derived equation of motion",
        [tidy(a - 3 * g * sin(q) / (2 * l) - 3 * row / (m * l**2))],
        [rod.equation + 3 * moments / (m * l**2), rod.difference],
        right="q'' + (3/2)(g/l) sin(q) = 0",
        proof="eq. 1.25 divided by -m l²/3 gives the plus sign, as eqs. 1.18 and 1.19 have it",
    )


def _work_on_rod(rod: _Rod) -> Iterator[ChapterRow]:
    """The virtual work of the same forces."""
    row, spread, ledger = rod.row, rod.spread, rod.ledger
    m, l, g, q, _, a = rod.letters
    dq = rod.ring["δq"]
    dW = ledger["Sum of the virtual work"][0].right
    yield identity(
        "1.27",
        "virtual work: dW_int = dW_ext, here both zero along the motion",
        _BY,
        dW + row * dq,
        *(result.right for result in ledger["Virtual work of the reactions"]),
    )
    yield identity(
        "1.27 a",
        "the resultant of the triangular distribution is m l q''/2, at 2 l/3 from o",
        "the distribution integrated over the rod, and its moment about o",
        spread.resultant[1] + m * l * a / 2,
        spread.point[1] - 2 * l / 3,
    )
    yield identity(
        "1.27 b",
        "dW_ext = -(m g sin q)(l/2) dq - (m l q''/2)(2 l/3) dq "
        "= -(m g (l/2) sin q + m l² q''/3) dq",
        "the ledger of virtual work",
        -(m * g * sin(q)) * (l / 2 * dq) - (m * l * a / 2) * (2 * l / 3 * dq) - dW,
        dW + (m * g * l / 2 * sin(q) + m * l**2 / 3 * a) * dq,
    )
    yield identity(
        "1.27 c",
        "m l² q''/3 + m g (l/2) sin q = 0",
        _BY,
        m * l**2 / 3 * a + m * g * l / 2 * sin(q) - row,
    )


def _angular_momentum(rate: object) -> ChapterRow:
    from sympy import integrate, symbols

    s, mu, l, v, m = symbols("s mu l q' m", positive=True)
    whole = integrate(s**2 * v * mu, (s, 0, l))
    return identity(
        "1.15",
        "H_o = ∫ s² q' mu ds = mu l³ q'/3 = m l² q'/3",
        "the integral of s² q' mu over the rod, and the derivation's rate of it",
        whole - mu * l**3 / 3 * v,
        whole.subs(mu, m / l) - m * l**2 / 3 * v,
        rate,
    )


def _linearize() -> ChapterRow:
    bench = Bench(entry("rigid_bar_pendulum"), {"l": 1.7}, "derive", 1, 0)
    return agreement(
        "1.20",
        "linearized: q'' + (3 g/(2 l)) q = 0",
        "the natural frequency of the linearized pendulum against sqrt(3 g/(2 l))",
        (bench.squares({}) ** 0.5, [(3 * 9.81 / (2 * 1.7)) ** 0.5]),
    )


_LEDGER = "the ledger of virtual work of the pendulum in the catalogue"


def _unit_vectors() -> ChapterRow:
    from sympy import Function, Matrix, Symbol, cos, sin

    q = Function("q")(Symbol("t"))
    n, t = Matrix([sin(q), -cos(q), 0]), Matrix([cos(q), sin(q), 0])
    k = n.cross(t)
    spin = q.diff() * k
    return identity(
        "before 1.14",
        "k = n × t completes a right-handed basis, the rod turns with omega = q' k, and a unit "
        "vector u that turns with it has the rate omega × u",
        "n and t of the hanging rod, differentiated",
        *(k - Matrix([0, 0, 1])),
        *(n.diff() - spin.cross(n)),
        *(t.diff() - spin.cross(t)),
        *(n.diff() - q.diff() * t),
    )


def _unknowns() -> Iterator[ChapterRow]:
    bodies = NewtonEuler(load("rigid_bar_pendulum"))
    (cut,) = bodies.cuts.bodies
    components = along(cut.axes.rows, bodies.balances.acting(cut).force)
    sides = (components[0], components[1])
    yield decision(
        "after 1.14",
        "the two equations 1.14 hold three unknowns, R_n, R_t and q",
        "letters of reactions in the forces on the rod, which turn with q",
        _names(sides, Kind.REACTION) == {"R_pin_n", "R_pin_t"},
        all(side.diff("q") for side in sides),
    )
    reactions = list(bodies.derivation().reactions.values())
    motions = _names(reactions, Kind.VELOCITY) | _names(reactions, Kind.ACCELERATION)
    yield decision(
        "after 1.20",
        "once q(t) is known the reactions follow from the balance of linear momentum",
        "the closed forms of R_n and R_t hold q, q' and q'' and no other unknown",
        len(reactions) == 2,
        not _names(reactions, Kind.REACTION),
        motions == {"q'", "q''"},
    )


def _same_as_1_19() -> ChapterRow:
    ring = NewtonEuler(load("rigid_bar_pendulum")).algebra.ring
    l, g, q, a = (ring[name] for name in ("l", "g", "q", "q''"))
    equation = a + 3 * g * sin(q) / (2 * l)
    return misprint(
        "after 1.26",
        "eq. 1.26 is said to be identical to eq. 1.19, and sect. 1.3.4 takes the motion from it",
        "the two left sides against each other",
        [a - 3 * g * sin(q) / (2 * l) - equation],
        [a + 3 * g * sin(q) / (2 * l) - equation],
        right="eq. 1.26 with a plus sign is; the motion follows from eq. 1.19",
        proof="with the printed sign q = 0 repels, with that of eq. 1.19 it is stable",
    )


def _working() -> Iterator[ChapterRow]:
    work = VirtualWork(load("rigid_bar_pendulum"))
    ring = work.balances.algebra.ring
    l, dq = ring["l"], ring["δq"]
    quantities: dict[str, Series] = {}
    for stage in work.derivation().stages:
        for result in stage.results:
            if not isinstance(result.left, Series):
                quantities[result.left.quantity] = result.right
    (rod,) = work.cuts.bodies
    of_inertia, _ = work.ledger.seat_of_inertia(rod)
    yield identity(
        "before 1.27 b",
        "the reactions do no work, nor do the parts of weight and inertia forces along the rod",
        _LEDGER,
        work.work_of_reaction(rod),
        *(along(rod.axes.rows, velocity)[0] for velocity in (rod.twist.force, of_inertia)),
    )
    yield identity(
        "after 1.27 b",
        "the points of action move by l dq/2 and 2 l dq/3 along the tangents",
        _LEDGER,
        quantities["δr_weight_rod_t"] - l * dq / 2,
        quantities["δr_inertia_rod_t"] - 2 * l * dq / 3,
    )


def _absent() -> ChapterRow:
    """Return the row on reactions, which only some methods show."""
    absent, present = [], []
    for name in ("rigid_bar_pendulum", "two_blocks", "double_pendulum"):
        by_method = derivations(load(name))
        absent += [
            not _names(by_method[k].rows, Kind.REACTION) for k in ("virtual_work", "lagrange")
        ]
        balances = next(s for s in by_method["newton_euler"].stages if s.title.endswith("forces"))
        sides = [result.right for result in balances.results]
        present.append(bool(_names(sides, Kind.REACTION)))
    return decision(
        "sect. 1.3.4",
        "constraint forces stand in the balances of Newton and Euler, and in no equation of "
        "virtual work or Lagrange",
        "letters in the derivations of three systems",
        *absent,
        *present,
    )


def _names(series: Iterable[Series], kind: Kind) -> set[str]:
    return {g.name for row in series for g in row.generators() if g.kind is kind}


_OPERATOR = (
    "the operator applied to T and V of {}, against Newton and Euler's equations of the same system"
)


def _energies() -> Iterator[ChapterRow]:
    """Lagrange's equations, and the kinetic energy of rigid bodies."""
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


def _wording() -> Iterator[ChapterRow]:
    yield misread(
        "sect. 1.1 a",
        "mass is called a measure of how a body resists motion",
        right="a measure of how it resists a change of its motion",
        proof="by the first law nothing resists a uniform motion; in F = m a mass resists a",
    )
    yield misread(
        "before 1.3",
        "the law of angular momentum lacks a word before 'all the external forces'",
        right="the resultant moment, at the same point, of all the external forces",
        proof="a moment is that of forces; eqs. 1.8 and 1.10 are worded so",
    )
    yield misread(
        "before 1.11",
        "the center is written 'center or mass'",
        right="center of mass",
        proof="it is the point of eq. 1.5",
    )
    yield misread(
        "after 1.27",
        "the right side of eq. 1.27 is explained without saying what of the external forces it is",
        right="the virtual work done by the external forces during the same virtual displacement",
        proof="the left side is explained as the virtual work done by the internal forces",
    )
    yield misread(
        "before 1.27",
        "the principle of virtual work is spelled as a 'principal', here and twice below",
        right="principle",
        proof="the definition above eq. 1.27 spells it so",
    )
    yield misread(
        "sect. 1.3.5",
        "of theory and applications it says that neither has 'by no means' been exhausted",
        right="neither has by any means been exhausted",
        proof="the two negations cancel, and the opposite is meant",
    )


def _open_points() -> Iterator[ChapterRow]:
    yield open_point(
        "sect. 1.1 c",
        "space, time, inertial frames, and equality of inertial and gravitational mass",
        "assumptions and experience, which no computation decides",
    )
    yield open_point(
        "sect. 1.1 d",
        "classical mechanics does for slow and large bodies, the earth for an inertial frame",
        "the chapter gives no measure; how far it errs depends on the problem",
    )
    yield open_point(
        "sect. 1.3.1 b",
        "the forces of two particles on each other act along the line through both",
        "an assumption, from which eqs. 1.10 and 1.12 follow",
    )
    yield open_point(
        "sect. 1.2 c",
        "independent coordinates, as many as degrees of freedom, can always be found",
        "true near any regular position; one set need not reach every position (a sphere has none)",
    )
    yield open_point(
        "sect. 1.3.1",
        "Newton's laws as quoted, and dates, pages and editions of the works cited",
        "history; D. T. Greenwood's Classical Dynamics is usually dated 1977, not 1997",
    )
    yield open_point(
        "of 1.2-1.13",
        "the laws of systems of particles hold for every body",
        "checked on one cloud of particles and one plate, which is no proof for all",
    )
    yield open_point(
        "of 1.27-1.30",
        "the principles of virtual work and of Lagrange hold for every holonomic system",
        "checked on the systems that the rows name, which is no proof for all",
    )
    yield open_point(
        "of 1.20",
        "how small an amplitude must be for the linear equation to do",
        "the chapter gives no measure; only the linear equation itself is checked",
    )
    yield open_point(
        "figures", "Figures 1.1 to 1.15", "only what the text says of them was at hand"
    )
    yield open_point(
        "sect. 1.3.4 b",
        "which method is easier, and what engineers prefer",
        "a judgment, also in sect. 1.3 and 1.3.5",
    )
    yield open_point(
        "spelling",
        "other slips of spelling and grammar, and marks of vectors and indices left out",
        "only those are listed that change what is meant or leave it open",
    )
