"""Sentences of Examples 1.1 and 1.2."""

from __future__ import annotations

from collections.abc import Iterator

from mecanique.derivation.matrix_form import linear
from mecanique.derivation.symbolic.lagrange import Lagrange
from mecanique.textbook import load
from mecanique.textbook.register.bars import Bars
from mecanique.textbook.register.row import Row, decision, identity, misprint


def rows() -> Iterator[Row]:
    """Yield the rows of the examples."""
    yield from _blocks()
    yield from _places(Bars())
    yield from _balances(Bars())


def _blocks() -> Iterator[Row]:
    lagrange = Lagrange(load("two_blocks"))
    ring = lagrange.algebra.ring
    lower, upper = (work.square for work in lagrange.works if work.square is not None)
    yield identity(
        "Ex. 1.1 words a",
        "q1 and q2 - q1 are the elongations of the two springs",
        "elongations found from the poses of the blocks",
        lower[1] - ring["q1"],
        upper[1] - (ring["q2"] - ring["q1"]),
    )
    letters = {g.name for row in lagrange.derivation().rows for g in row.generators()}
    yield decision(
        "Ex. 1.1 words b",
        "gravity, downwards, has no part in the horizontal motion",
        "letters of the equations of motion of blocks with weight",
        "g" not in letters,
        "m1" in letters,
    )


def _places(bars: Bars) -> Iterator[Row]:
    l, B, E, C = bars.l, bars.B, bars.E, bars.r_C
    line, to_C = B - E, C - E
    yield misprint(
        "Ex. 1.2 words a",
        "the center of mass is said to lie on the vertical line that connects B and E",
        "x of B, of E and of the center of mass",
        [line[0], to_C[0]],
        [line[0] - l, to_C[0] - l / 3, line[0] * to_C[1] - line[1] * to_C[0]],
        right="it lies on the straight line through B and E, which is not vertical",
        proof="B is at x = 3 l, E at 2 l; C is a third of the way from E to B, at 7 l/3",
    )
    yield identity(
        "Ex. 1.2 words b",
        "the bar CF stays vertical",
        "positions of C and F",
        (bars.C - bars.F)[0],
        (bars.C - bars.F)[1] - l,
    )
    exact = Lagrange(load("bars_and_springs")).derivation()
    small = Lagrange(load("bars_and_springs_small")).derivation()
    yield decision(
        "Ex. 1.2 words c",
        "beyond small motion the equation is not linear",
        "whether the assembly's equations are linear, exact and for small motion",
        linear(exact) is None,
        linear(small) is not None,
    )


def _balances(bars: Bars) -> Iterator[Row]:
    from sympy import Matrix

    m, k, l, q, v, a = bars.m, bars.k, bars.l, bars.q, bars.v, bars.a
    Ax, Ay, _, _, Dx, Dy, Fx, _ = bars.reactions
    solved, t = bars.solve(), bars.t
    A_y, D_y = -m * a * 3 / 16 - k * q / 4, -m * a / 2
    supports = [(bars.A, Matrix([Ax, Ay])), (bars.D, Matrix([Dx, Dy])), *bars.springs]
    about_D, about_A = (
        bars.moment(point, bars.pushes) - bars.moment(point, supports) for point in (bars.D, bars.A)
    )
    forces = sum((force for _, force in supports), Matrix([0, 0]))
    pushes = sum((push for _, push in bars.pushes), Matrix([0, 0]))
    unknown = (*(pushes - forces), about_D)
    letters = set().union(*(each.free_symbols for each in unknown)) - {m, k, l, t}
    yield decision(
        "Ex. 1.2 words d",
        "the balances of the whole are three equations in five unknowns",
        "letters in Ex.1.2.a to Ex.1.2.c: A_x, A_y, D_x, D_y, and q with its rates",
        letters == {Ax, Ay, Dx, Dy},
        all(each.has(q) for each in unknown[1:]),
    )
    yield identity(
        "Ex. 1.2 words e",
        "angular momentum about A says nothing new",
        "its balance less that about D is l times that of the forces along x",
        about_A - about_D - l * (pushes - forces)[0],
    )
    equation = m * a * 17 / 4 + 9 * k * q
    on_lower = Dx - Fx
    yield identity(
        "Ex. 1.2 words f",
        "the bar DEF leads to the same equation as ABC",
        "D_x = F_x = 0 put into D_x of Ex.1.2.d",
        on_lower.subs(solved),
        Dx.subs(solved),
        equation.subs(solved),
    )
    yield misprint(
        "after Ex.1.2.h",
        "once q' is determined the vertical reactions may be calculated from Ex.1.2.h",
        "slopes of A_y and D_y along q, q' and q''",
        [A_y.diff(q), A_y.diff(a), D_y.diff(a)],
        [A_y.diff(v), D_y.diff(v), (A_y - Ay).subs(solved), (D_y - Dy).subs(solved)],
        right="once q and q'' are determined, that is q(t)",
        proof="Ex.1.2.h holds q and q'' and does not hold q'",
    )
    multiple = 5 * m * k * equation
    yield identity(
        "Ex. 1.2 words g",
        "a multiple of the equation of motion may be added to the reactions (footnote)",
        "A_y and D_y of Ex.1.2.h with such a multiple against the balances, solved",
        (A_y + multiple - Ay).subs(solved),
        (D_y - multiple - Dy).subs(solved),
    )
