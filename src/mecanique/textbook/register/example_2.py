"""Example 1.2: bars and springs in small vertical motion, every displayed result; the assembly is in `bars`."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

from mecanique.textbook.register.bars import Bars
from mecanique.textbook.register.row import Check, Finding, compared, corrected, identical

__all__ = ["CHECKS"]


@cache
def _bars() -> Bars:
    return Bars()


_HOW = "positions of the straight bars, differentiated"


def _exact(difference: Callable[[Bars], Any], how: str = _HOW) -> Callable[[], Finding]:
    return lambda: identical(difference(_bars()), how)


def _vector(x: Any, y: Any) -> Any:
    from sympy import Matrix

    return Matrix([x, y])


def _positions(b: Bars) -> list[Any]:
    return [
        *(b.B - _vector(3 * b.l, b.l - b.q * 3 / 4)),
        *(b.E - _vector(2 * b.l, -b.q / 2)),
    ]


def _center() -> Finding:
    b = _bars()
    printed = b.center - _vector(b.l * 7 / 3, b.l * 5 / 3 - b.q * 7 / 12)
    mended = b.center - _vector(b.l * 7 / 3, b.l / 3 - b.q * 7 / 12)
    return corrected(
        list(printed),
        list(mended),
        "(m r_B + 2 m r_E)/(3 m) with the positions just above",
        "r_C = (7 l/3) x + (l/3 - 7 q/12) y",
        "B is at the height l, E at 0: (m l + 2 m 0)/(3 m) = l/3; velocity and acceleration are not affected",
    )


def _velocity_of_e() -> Finding:
    b = _bars()
    printed = [*(b.rate(b.B) - _vector(0, -b.v * 3 / 4)), *(b.rate(b.F) - _vector(0, -b.v / 2))]
    mended = [*(b.rate(b.B) - _vector(0, -b.v * 3 / 4)), *(b.rate(b.E) - _vector(0, -b.v / 2))]
    return corrected(
        printed,
        mended,
        "velocities of B, E and F",
        "v_E = r_E' = -(1/2) q' y",
        "the mass 2 m is at E, halfway along DEF; F itself falls with C, v_F = -q' y",
    )


def _balance(b: Bars) -> list[Any]:
    """3 m a_C against the sum of supports and springs, and each side as printed."""
    Ax, Ay, _, _, Dx, Dy, _, _ = b.reactions
    lifts = sum((force for _, force in b.springs), _vector(0, 0))
    left = 3 * b.m * b.rate(b.center, 2)
    total = _vector(Ax + Dx, Ay + Dy) + lifts
    solved = [(left - total).subs(b.a, b.solved["q''"]).subs(b.solved)]
    return [
        *(left - _vector(0, -b.m * b.a * 7 / 4)),
        *(total - _vector(Ax + Dx, Ay + Dy + b.k * b.q * 5 / 2)),
        *solved[0],
    ]


def _spin(b: Bars) -> Any:
    pairs = [(b.B, b.m * b.rate(b.B)), (b.E, 2 * b.m * b.rate(b.E))]
    return b.moment(b.D, pairs) + b.m * b.l * b.v * 17 / 4


def _moment(b: Bars) -> list[Any]:
    Ax, Ay, _, _, Dx, Dy, _, _ = b.reactions
    outer = b.moment(b.D, [(b.A, _vector(Ax, Ay)), (b.D, _vector(Dx, Dy)), *b.springs])
    left = b.moment(b.D, b.pushes)
    balance = (left - outer).subs(b.a, b.solved["q''"]).subs(b.solved)
    return [left + b.m * b.l * b.a * 17 / 4, outer - (-b.l * Ax + 9 * b.k * b.l * b.q), balance]


def _deduced(b: Bars) -> list[Any]:
    from sympy import solve

    Ax, *_ = b.reactions
    (found,) = solve(b.moment(b.D, b.pushes) - (-b.l * Ax + 9 * b.k * b.l * b.q), Ax)
    Dx = b.reactions[4]
    (other,) = solve(found + Dx, Dx)
    return [found - b.equation, other + b.equation]


def _link(b: Bars) -> list[Any]:
    _, _, Cx, Cy, _, _, Fx, Fy = b.reactions
    forces = [(b.C, _vector(-Cx, Cy)), (b.F, _vector(Fx, -Fy))]
    total = forces[0][1] + forces[1][1]
    spin = b.moment((b.C + b.F) / 2, forces)
    solved = b.solved
    return [
        total[0] + (Cx - Fx),
        total[1] - (Cy - Fy),
        spin - b.l / 2 * (Cx + Fx),
        solved[Cx],
        solved[Fx],
        solved[Cy] - solved[Fy],
    ]


def _upper(b: Bars) -> list[Any]:
    Ax, Ay, Cx, Cy, *_ = b.reactions
    total = _vector(Ax, Ay) + _vector(Cx, -Cy) + b.springs[0][1]
    given = _vector(Ax + Cx, Ay - Cy + b.k * b.q / 2)
    return [*(total - given), *(b.pushes[0][1] - _vector(0, -b.m * b.a * 3 / 4)), b.solved[Ax]]


def _motion(b: Bars) -> Any:
    return b.equation.subs(b.a, b.solved["q''"])


def _vertical(b: Bars) -> list[Any]:
    solved = b.solved
    Ay, Dy = b.reactions[1], b.reactions[5]
    given = -b.m * b.a * 3 / 16 - b.k * b.q / 4, -b.m * b.a / 2
    return [
        (g.subs(b.a, solved["q''"]) - solved[name]) for g, name in zip(given, (Ay, Dy), strict=True)
    ]


def _displacements(b: Bars) -> list[Any]:
    return [
        point.diff(b.q)[1] + share
        for point, share in ((b.Bs, _half()), (b.B, 3 * _half() / 2), (b.F, 1), (b.E, _half()))
    ]


def _half() -> Any:
    from sympy import Rational

    return Rational(1, 2)


def _work(b: Bars) -> Any:
    """Force times displacement, springs and inertia forces."""
    total = 0
    for point, force in (*b.springs, *((p, -push) for p, push in b.pushes)):
        total += sum(f * d for f, d in zip(force, point.diff(b.q), strict=True)) * b.delta
    printed = -(b.k * b.q / 4 + 9 * b.m * b.a / 16 + 2 * b.k * b.q + b.m * b.a / 2) * b.delta
    return [total - printed, printed + b.equation / 4 * b.delta]


def _equilibrium(b: Bars) -> list[Any]:
    """Moments about C and about F, with inertia forces, and what follows for A_y and D_y."""
    from sympy import solve

    _Ax, Ay, _, _, _Dx, Dy, _, _ = b.reactions
    about_c = b.moment(b.C, [(b.A, _vector(0, Ay)), b.springs[0], (b.B, -b.pushes[0][1])])
    about_f = b.moment(b.F, [(b.D, _vector(0, Dy)), b.springs[1], (b.E, -b.pushes[1][1])])
    first = 4 * b.l * Ay + 2 * b.l * b.k / 2 * b.q + b.l * b.m * b.a * 3 / 4
    second = 4 * b.l * Dy + 2 * b.l * b.m * b.a
    return [
        about_c + first,
        about_f + second,
        solve(first, Ay)[0] + b.m * b.a * 3 / 16 + b.k * b.q / 4,
        solve(second, Dy)[0] + b.m * b.a / 2,
    ]


def _horizontal(b: Bars) -> list[Any]:
    """All that is horizontal vanishes, whatever its sign."""
    Ax, _, Cx, Cy, Dx, _, Fx, Fy = b.reactions
    return [*(b.solved[name] for name in (Cx, Fx, Ax, Dx)), b.solved[Cy] - b.solved[Fy]]


def _energies(b: Bars) -> list[Any]:
    T = b.m * b.rate(b.B).dot(b.rate(b.B)) / 2 + b.m * b.rate(b.E).dot(b.rate(b.E))
    drops = [(point - point.subs(b.q, 0))[1] for point in (b.Bs, b.F)]
    V = b.k * drops[0] ** 2 / 2 + b.k * drops[1] ** 2
    return [T - b.m * b.v**2 * 17 / 32, V - b.k * b.q**2 * 9 / 8]


def _lagrange(b: Bars) -> list[Any]:
    T, V = b.m * b.v**2 * 17 / 32, b.k * b.q**2 * 9 / 8
    left = T.diff(b.v).diff(b.t) - T.diff(b.q) + V.diff(b.q)
    return [left - b.m * b.a * 17 / 16 - b.k * b.q * 9 / 4, 4 * left - b.equation]


def _catalogue() -> Finding:
    """The catalogue's small-motion system has this equation; the exact one has it when linearized."""
    from mecanique.derivation import derive
    from mecanique.motion import linearize
    from mecanique.textbook import load

    small = load("bars_and_springs_small")
    row = derive(small).derivation.rows[0]
    ring = row.ring
    exact = linearize(load("bars_and_springs", m=2.0, k=70.0))
    wanted = (36 * 70.0 / (17 * 2.0)) ** 0.5
    found = compared(
        [(exact.frequencies, [wanted])],
        "the exact assembly linearized, and the small-motion system derived",
    )
    same = row.vanishes() is False and (4 * row - _printed_row(ring)).vanishes()
    return Finding(found.how, found.kind, found.holds and same, found.residual)


def _printed_row(ring: Any) -> Any:
    index = {generator.name: generator.index for generator in ring.generators}
    from mecanique.derivation.scalars.monomials import power
    from mecanique.derivation.scalars.series import Series

    def letter(name: str) -> Series:
        return Series(ring, {0: {power(index[name]): 1}}, 1, 1)

    return 17 * letter("m") * letter("q''") / 4 + 9 * letter("k") * letter("q")


CHECKS = (
    Check(
        "Ex. 1.2 1", "r_B = 3 l x + (l - (3/4) q) y, r_E = 2 l x - (1/2) q y", _exact(_positions)
    ),
    Check("Ex. 1.2 2", "printed: r_C = (7 l/3) x + (5 l/3 - 7 q/12) y", _center),
    Check(
        "Ex. 1.2 3",
        "v_C = -(7/12) q' y, a_C = -(7/12) q'' y",
        _exact(
            lambda b: [
                *(b.rate(b.center) - _vector(0, -b.v * 7 / 12)),
                *(b.rate(b.center, 2) - _vector(0, -b.a * 7 / 12)),
            ]
        ),
    ),
    Check(
        "Ex. 1.2 4",
        "3 m a_C = -(7/4) m q'' y = (A_x + D_x) x + (A_y + D_y + (5 k/2) q) y",
        _exact(_balance, "momentum of both particles against supports and springs"),
    ),
    Check(
        "Ex. 1.2 5",
        "printed: v_B = -(3/4) q' y and v_F = -(1/2) q' y for the mass 2 m at E",
        _velocity_of_e,
    ),
    Check(
        "Ex. 1.2 6",
        "H_D = -(17/4) m l q' z",
        _exact(_spin, "cross products of positions and momenta"),
    ),
    Check(
        "Ex. 1.2 7",
        "dH_D/dt = -(17/4) m l q'' z = (-l A_x + 9 k l q) z = M_D",
        _exact(_moment, "moments of the rates of momentum, of supports and springs about D"),
    ),
    Check(
        "Ex.1.2.a",
        "0 = A_x + D_x",
        _exact(
            lambda b: b.solved[b.reactions[0]] + b.solved[b.reactions[4]],
            "the balances of all bars, solved",
        ),
    ),
    Check(
        "Ex.1.2.b",
        "-(7/4) m q'' = A_y + D_y + (5 k/2) q",
        _exact(
            lambda b: (
                -b.m * b.solved["q''"] * 7 / 4
                - b.solved[b.reactions[1]]
                - b.solved[b.reactions[5]]
                - b.k * b.q * 5 / 2
            ),
            "the balances of all bars, solved",
        ),
    ),
    Check(
        "Ex.1.2.c",
        "-(17/4) m l q'' = -l A_x + 9 k l q",
        _exact(
            lambda b: (
                -b.m * b.l * b.solved["q''"] * 17 / 4
                + b.l * b.solved[b.reactions[0]]
                - 9 * b.k * b.l * b.q
            ),
            "the balances of all bars, solved",
        ),
    ),
    Check(
        "Ex.1.2.d",
        "A_x = (17/4) m q'' + 9 k q = -D_x",
        _exact(_deduced, "Ex.1.2.a and Ex.1.2.c solved for A_x and D_x"),
    ),
    Check(
        "Ex. 1.2 8",
        "bar CF: 0 = C_x - F_x, 0 = C_y - F_y, 0 = (l/2) C_x + (l/2) F_x",
        _exact(_link, "balances of the massless bar CF, moments about its middle"),
    ),
    Check(
        "Ex.1.2.e",
        "C_x = F_x = 0, C_y = F_y",
        _exact(
            lambda b: [
                b.solved[b.reactions[2]],
                b.solved[b.reactions[6]],
                b.solved[b.reactions[3]] - b.solved[b.reactions[7]],
            ],
            "the balances of all bars, solved",
        ),
    ),
    Check(
        "Ex. 1.2 9",
        "bar ABC: -(3/4) m q'' y = (A_x + C_x) x + (A_y - C_y + (k/2) q) y",
        _exact(_upper, "momentum of the bar ABC"),
    ),
    Check(
        "Ex.1.2.f",
        "A_x = -C_x = 0",
        _exact(
            lambda b: [b.solved[b.reactions[0]], b.solved[b.reactions[2]]],
            "the balances of all bars, solved",
        ),
    ),
    Check(
        "Ex.1.2.g",
        "(17/4) m q'' + 9 k q = 0",
        _exact(_motion, "q'' from the balances of all bars, solved"),
    ),
    Check(
        "Ex.1.2.h",
        "A_y = -(3 m/16) q'' - (k/4) q, D_y = -(m/2) q''",
        _exact(_vertical, "the balances of all bars, solved"),
    ),
    Check(
        "Ex. 1.2 10",
        "virtual displacements dq/2 at B', (3/4) dq at B, dq at F, dq/2 at E, all down",
        _exact(_displacements),
    ),
    Check(
        "Ex. 1.2 11",
        "dW = -(k q/4 + 9 m q''/16 + 2 k q + m q''/2) dq = 0",
        _exact(_work, "forces of springs and inertia times virtual displacements"),
    ),
    Check(
        "Ex.1.2.i",
        "(17/4) m q'' + 9 k q = 0, by virtual work",
        _exact(
            lambda b: (
                4 * (b.k * b.q / 4 + 9 * b.m * b.a / 16 + 2 * b.k * b.q + b.m * b.a / 2)
                - b.equation
            ),
            "four times the bracket before dq",
        ),
    ),
    Check(
        "Ex. 1.2 11 a",
        "with inertia forces: C_x = F_x = 0, C_y = F_y, A_x = C_x = 0, D_x = F_x = 0",
        _exact(_horizontal, "the balances of all bars, solved"),
    ),
    Check(
        "Ex. 1.2 12",
        "moments about C: 4 l A_y + 2 l (k/2) q + l (3 m/4) q'' = 0; about F: 4 l D_y + 2 l m q'' = 0",
        _exact(_equilibrium, "equilibrium of ABC and of DEF with the inertia forces"),
    ),
    Check(
        "Ex. 1.2 13",
        "T = (17/32) m q'², V = (9/8) k q²",
        _exact(_energies, "energies of particles and springs"),
    ),
    Check(
        "Ex.1.2.j",
        "(17/16) m q'' + (9/4) k q = 0, that is (17/4) m q'' + 9 k q = 0",
        _exact(_lagrange, "Lagrange's operator on these energies"),
    ),
    Check(
        "Ex. 1.2 14",
        "the exact assembly in small motion, and the catalogue's system for small motion",
        _catalogue,
    ),
)
