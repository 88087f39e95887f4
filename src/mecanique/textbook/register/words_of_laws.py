"""Sentences of sections 1.1 to 1.3.3: frames, degrees of freedom, momenta, points and units."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import combinations

import numpy as np

from mecanique.derivation.methods import derivations
from mecanique.derivation.printing.expressions import to_sympy
from mecanique.derivation.symbolic.lagrange import Lagrange
from mecanique.model.dimensions import read_unit
from mecanique.model.mechanism.homogeneity import dimensions_of
from mecanique.textbook import load
from mecanique.textbook.register.row import Row, agreement, decision, identity, misprint


def rows() -> Iterator[Row]:
    """Yield the rows of the sections."""
    yield _frames()
    yield from _freedom()
    yield from _methods()
    yield _angular_momenta()
    yield _two_integrals()
    yield _in_space()
    yield _plane()
    yield _generalized_forces()


def _frames() -> Row:
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


def _freedom() -> Iterator[Row]:
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


def _methods() -> Iterator[Row]:
    names = ("rigid_bar_pendulum", "two_blocks", "double_pendulum", "cart_pole")
    differences = []
    for name in names:
        first, *others = derivations(load(name)).values()
        for other in others:
            differences += [a - b for a, b in zip(first.rows, other.rows, strict=True)]
    yield identity(
        "sect. 1.3",
        "all formulations give the same equations of motion, up to a linear transformation",
        f"the rows of three methods for {', '.join(names)}",
        *differences,
    )


def _angular_momenta() -> Row:
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


def _two_integrals() -> Row:
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


def _in_space() -> Row:
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


def _plane() -> Row:
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


def _generalized_forces() -> Row:
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
