"""Example 1.2: bars and springs in small vertical motion, every displayed result."""

from __future__ import annotations

from collections.abc import Iterator

from mecanique.textbook.register.bars import Bars
from mecanique.textbook.register.row import Row, agreement, identity, misprint

_BY_POSITIONS = "positions of the straight bars, differentiated"
_BY_BALANCES = "the balances of all bars, solved"


def rows() -> Iterator[Row]:
    """Yield the rows of the example."""
    yield from _kinematics(Bars())
    yield from _balances(Bars())
    yield from _reactions(Bars())
    yield from _work(Bars())
    yield from _energies(Bars())
    yield from _catalogue()


def _kinematics(bars: Bars) -> Iterator[Row]:
    from sympy import Matrix

    l, q, v, a, t = bars.l, bars.q, bars.v, bars.a, bars.t
    yield identity(
        "Ex. 1.2 1",
        "r_B = 3 l x + (l - (3/4) q) y, r_E = 2 l x - (1/2) q y",
        _BY_POSITIONS,
        *(bars.B - Matrix([3 * l, l - q * 3 / 4])),
        *(bars.E - Matrix([2 * l, -q / 2])),
    )
    yield misprint(
        "Ex. 1.2 2",
        "printed: r_C = (7 l/3) x + (5 l/3 - 7 q/12) y",
        "(m r_B + 2 m r_E)/(3 m) with the positions just above",
        bars.r_C - Matrix([l * 7 / 3, l * 5 / 3 - q * 7 / 12]),
        bars.r_C - Matrix([l * 7 / 3, l / 3 - q * 7 / 12]),
        right="r_C = (7 l/3) x + (l/3 - 7 q/12) y",
        proof="B is at the height l, E at 0: (m l + 2 m 0)/(3 m) = l/3; velocity and acceleration "
        "are not affected",
    )
    yield identity(
        "Ex. 1.2 3",
        "v_C = -(7/12) q' y, a_C = -(7/12) q'' y",
        _BY_POSITIONS,
        *(bars.r_C.diff(t) - Matrix([0, -v * 7 / 12])),
        *(bars.r_C.diff(t, 2) - Matrix([0, -a * 7 / 12])),
    )


def _balances(bars: Bars) -> Iterator[Row]:
    """The balances of all bars together."""
    from sympy import Matrix, solve

    m, k, l, q, v, a, t = bars.m, bars.k, bars.l, bars.q, bars.v, bars.a, bars.t
    Ax, Ay, _, _, Dx, Dy, _, _ = bars.reactions
    solved = bars.solve()
    equation = m * a * 17 / 4 + 9 * k * q
    upper, lower = bars.springs

    left = 3 * m * bars.r_C.diff(t, 2)
    supports = Matrix([Ax + Dx, Ay + Dy]) + upper[1] + lower[1]
    yield identity(
        "Ex. 1.2 4",
        "3 m a_C = -(7/4) m q'' y = (A_x + D_x) x + (A_y + D_y + (5 k/2) q) y",
        "momentum of both particles against supports and springs",
        *(left - Matrix([0, -m * a * 7 / 4])),
        *(supports - Matrix([Ax + Dx, Ay + Dy + k * q * 5 / 2])),
        *(left - supports).subs(solved),
    )
    v_B = bars.B.diff(t) - Matrix([0, -v * 3 / 4])
    yield misprint(
        "Ex. 1.2 5",
        "printed: v_B = -(3/4) q' y and v_F = -(1/2) q' y for the mass 2 m at E",
        "velocities of B, E and F",
        [*v_B, *(bars.F.diff(t) - Matrix([0, -v / 2]))],
        [*v_B, *(bars.E.diff(t) - Matrix([0, -v / 2]))],
        right="v_E = r_E' = -(1/2) q' y",
        proof="the mass 2 m is at E, halfway along DEF; F itself falls with C, v_F = -q' y",
    )
    yield identity(
        "Ex. 1.2 6",
        "H_D = -(17/4) m l q' z",
        "cross products of positions and momenta",
        bars.moment(bars.D, bars.momenta) + m * l * v * 17 / 4,
    )
    H_rate, held = bars.moment(bars.D, bars.pushes), [(bars.A, Matrix([Ax, Ay]))]
    M_D = bars.moment(bars.D, [*held, *bars.springs])
    printed_M_D = -l * Ax + 9 * k * l * q
    yield identity(
        "Ex. 1.2 7",
        "dH_D/dt = -(17/4) m l q'' z = (-l A_x + 9 k l q) z = M_D",
        "moments of the rates of momentum, of supports and springs about D",
        H_rate + m * l * a * 17 / 4,
        M_D - printed_M_D,
        (H_rate - M_D).subs(solved),
    )
    for letter, states, difference in (
        ("a", "0 = A_x + D_x", Ax + Dx),
        (
            "b",
            "-(7/4) m q'' = A_y + D_y + (5 k/2) q",
            -m * a * 7 / 4 - Ay - Dy - k * q * 5 / 2,
        ),
        ("c", "-(17/4) m l q'' = -l A_x + 9 k l q", -m * l * a * 17 / 4 - printed_M_D),
    ):
        yield identity(f"Ex.1.2.{letter}", states, _BY_BALANCES, difference.subs(solved))
    (deduced,) = solve(H_rate - printed_M_D, Ax)
    yield identity(
        "Ex.1.2.d",
        "A_x = (17/4) m q'' + 9 k q = -D_x",
        "Ex.1.2.a and Ex.1.2.c solved for A_x and D_x",
        deduced - equation,
        solve(deduced + Dx, Dx)[0] + equation,
    )


def _reactions(bars: Bars) -> Iterator[Row]:
    """The balances of single bars, and what follows for their reactions."""
    from sympy import Matrix

    m, k, l, q, a = bars.m, bars.k, bars.l, bars.q, bars.a
    Ax, Ay, Cx, Cy, _, Dy, Fx, Fy = bars.reactions
    solved = bars.solve()
    equation = m * a * 17 / 4 + 9 * k * q
    upper, _ = bars.springs
    ends = [(bars.C, Matrix([-Cx, Cy])), (bars.F, Matrix([Fx, -Fy]))]
    total, spin = ends[0][1] + ends[1][1], bars.moment((bars.C + bars.F) / 2, ends)
    yield identity(
        "Ex. 1.2 8",
        "bar CF: 0 = C_x - F_x, 0 = C_y - F_y, 0 = (l/2) C_x + (l/2) F_x",
        "balances of the massless bar CF, moments about its middle",
        *(total[0] + (Cx - Fx), total[1] - (Cy - Fy), spin - l / 2 * (Cx + Fx)),
        *(solved[Cx], solved[Fx], solved[Cy] - solved[Fy]),
    )
    yield identity(
        "Ex.1.2.e",
        "C_x = F_x = 0, C_y = F_y",
        _BY_BALANCES,
        *(solved[Cx], solved[Fx], solved[Cy] - solved[Fy]),
    )
    on_upper = Matrix([Ax, Ay]) + Matrix([Cx, -Cy]) + upper[1]
    yield identity(
        "Ex. 1.2 9",
        "bar ABC: -(3/4) m q'' y = (A_x + C_x) x + (A_y - C_y + (k/2) q) y",
        "momentum of the bar ABC",
        *(on_upper - Matrix([Ax + Cx, Ay - Cy + k * q / 2])),
        *(bars.pushes[0][1] - Matrix([0, -m * a * 3 / 4])),
        solved[Ax],
    )
    yield identity("Ex.1.2.f", "A_x = -C_x = 0", _BY_BALANCES, solved[Ax], solved[Cx])
    yield identity(
        "Ex.1.2.g",
        "(17/4) m q'' + 9 k q = 0",
        f"q'' from {_BY_BALANCES}",
        equation.subs(solved),
    )
    yield identity(
        "Ex.1.2.h",
        "A_y = -(3 m/16) q'' - (k/4) q, D_y = -(m/2) q''",
        _BY_BALANCES,
        (-m * a * 3 / 16 - k * q / 4 - Ay).subs(solved),
        (-m * a / 2 - Dy).subs(solved),
    )


def _work(bars: Bars) -> Iterator[Row]:
    from sympy import Matrix, solve

    m, k, l, q, a, dq = bars.m, bars.k, bars.l, bars.q, bars.a, bars.dq
    Ax, Ay, Cx, Cy, Dx, Dy, Fx, Fy = bars.reactions
    solved = bars.solve()
    equation = m * a * 17 / 4 + 9 * k * q
    upper, lower = bars.springs
    inertia = [(point, -push) for point, push in bars.pushes]
    yield identity(
        "Ex. 1.2 10",
        "virtual displacements dq/2 at B', (3/4) dq at B, dq at F, dq/2 at E, all down",
        _BY_POSITIONS,
        2 * bars.Bs.diff(q)[1] + 1,
        4 * bars.B.diff(q)[1] + 3,
        bars.F.diff(q)[1] + 1,
        2 * bars.E.diff(q)[1] + 1,
    )
    dW = sum(force.dot(point.diff(q)) * dq for point, force in (*bars.springs, *inertia))
    bracket = k * q / 4 + 9 * m * a / 16 + 2 * k * q + m * a / 2
    yield identity(
        "Ex. 1.2 11",
        "dW = -(k q/4 + 9 m q''/16 + 2 k q + m q''/2) dq = 0",
        "forces of springs and inertia times virtual displacements",
        dW + bracket * dq,
        equation / 4 * dq - bracket * dq,
    )
    yield identity(
        "Ex.1.2.i",
        "(17/4) m q'' + 9 k q = 0, by virtual work",
        "four times the bracket before dq",
        4 * bracket - equation,
    )
    yield identity(
        "Ex. 1.2 11 a",
        "with inertia forces: C_x = F_x = 0, C_y = F_y, A_x = C_x = 0, D_x = F_x = 0",
        _BY_BALANCES,
        *(solved[name] for name in (Cx, Fx, Ax, Dx)),
        solved[Cy] - solved[Fy],
    )
    about_C = 4 * l * Ay + 2 * l * k / 2 * q + l * m * a * 3 / 4
    about_F = 4 * l * Dy + 2 * l * m * a
    yield identity(
        "Ex. 1.2 12",
        "moments about C: 4 l A_y + 2 l (k/2) q + l (3 m/4) q'' = 0; "
        "about F: 4 l D_y + 2 l m q'' = 0",
        "equilibrium of ABC and of DEF with the inertia forces",
        bars.moment(bars.C, [(bars.A, Matrix([0, Ay])), upper, inertia[0]]) + about_C,
        bars.moment(bars.F, [(bars.D, Matrix([0, Dy])), lower, inertia[1]]) + about_F,
        solve(about_C, Ay)[0] + m * a * 3 / 16 + k * q / 4,
        solve(about_F, Dy)[0] + m * a / 2,
    )


def _energies(bars: Bars) -> Iterator[Row]:
    m, k, q, v, a, t = bars.m, bars.k, bars.q, bars.v, bars.a, bars.t
    T, V = m * v**2 * 17 / 32, k * q**2 * 9 / 8
    lifts = [(point - point.subs(q, 0))[1] for point in (bars.Bs, bars.F)]
    v_B, v_E = bars.B.diff(t), bars.E.diff(t)
    yield identity(
        "Ex. 1.2 13",
        "T = (17/32) m q'², V = (9/8) k q²",
        "energies of particles and springs",
        m * v_B.dot(v_B) / 2 + m * v_E.dot(v_E) - T,
        k * lifts[0] ** 2 / 2 + k * lifts[1] ** 2 - V,
    )
    left = T.diff(v).diff(t) - T.diff(q) + V.diff(q)
    yield identity(
        "Ex.1.2.j",
        "(17/16) m q'' + (9/4) k q = 0, that is (17/4) m q'' + 9 k q = 0",
        "Lagrange's operator on these energies",
        left - m * a * 17 / 16 - k * q * 9 / 4,
        4 * left - (m * a * 17 / 4 + 9 * k * q),
    )


def _catalogue() -> Iterator[Row]:
    from mecanique.derivation.symbolic.lagrange import Lagrange
    from mecanique.motion import linearize
    from mecanique.textbook import load

    M, K = 2.0, 70.0
    exact = linearize(load("bars_and_springs", m=M, k=K))
    yield agreement(
        "Ex. 1.2 14",
        "the exact assembly in small motion: omega = sqrt(36 k/(17 m))",
        "the natural frequency of the exact assembly of the catalogue, linearized",
        (exact.frequencies, [(36 * K / (17 * M)) ** 0.5]),
    )
    small = Lagrange(load("bars_and_springs_small"))
    m, k, q, a = (small.algebra.ring[name] for name in ("m", "k", "q", "q''"))
    yield identity(
        "Ex. 1.2 15",
        "the catalogue's system for small motion: (17/4) m q'' + 9 k q = 0",
        "the equation derived by Lagrange",
        4 * small.derivation().rows[0] - (17 * m * a / 4 + 9 * k * q),
    )
