"""Examples 1.1 and 1.2 of the chapter, equation by equation, and the sentences about them.

The bars and springs of Example 1.2 stand in sympy, for small vertical motion: positions follow from
straight bars between their ends, velocities and accelerations from differentiation, momenta and
moments from cross products, reactions from the balances of the single bars. x points right, y up,
the origin is D; C moves down by q. On ABC the bar CF exerts C_x along x and C_y against y, on DEF
it exerts F_x against x and F_y along y; A and D are supports.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cached_property
from typing import Any, TypeAlias, final

from mecanique.derivation.linear import linear
from mecanique.derivation.scalars.series import Series
from mecanique.derivation.symbolic.lagrange import Lagrange
from mecanique.derivation.symbolic.newton_euler import NewtonEuler
from mecanique.derivation.symbolic.symbols import Algebra
from mecanique.derivation.symbolic.virtual_work import VirtualWork
from mecanique.textbook import entry, load
from mecanique.verification.chapter.row import ChapterRow, agreement, decision, identity, misprint
from mecanique.verification.facts import Bench

Acting: TypeAlias = tuple[Any, Any]
"""A point, and the force or momentum there."""


@final
class Bars:
    """The assembly."""

    def __init__(self) -> None:
        from sympy import Function, Matrix, Symbol, symbols

        m, k, l = symbols("m k l", positive=True)
        t = Symbol("t")
        q = Function("q")(t)
        self.m, self.k, self.l = m, k, l
        self.t, self.q = t, q
        self.v = q.diff(t)
        self.a = q.diff(t, 2)
        self.dq = Symbol("delta_q")
        self.A = Matrix([0, l])
        self.C = Matrix([4 * l, l - q])
        self.D = Matrix([0, 0])
        self.F = Matrix([4 * l, -q])
        upper, lower = self.C - self.A, self.F - self.D
        self.B = self.A + upper * 3 / 4
        self.E = self.D + lower / 2
        self.Bs = self.A + upper / 2
        """The end of the upper spring, B'; the lower one ends at F."""
        self.r_C = (m * self.B + 2 * m * self.E) / (3 * m)
        self.reactions = symbols("A_x A_y C_x C_y D_x D_y F_x F_y")
        self.springs: tuple[Acting, ...] = (
            (self.Bs, -k * self._rise(self.Bs)),
            (self.F, -2 * k * self._rise(self.F)),
        )
        self.momenta: tuple[Acting, ...] = (
            (self.B, m * self.B.diff(t)),
            (self.E, 2 * m * self.E.diff(t)),
        )
        self.pushes: tuple[Acting, ...] = tuple((point, p.diff(t)) for point, p in self.momenta)
        self.equation = m * self.a * 17 / 4 + 9 * k * q

    def letters(self, names: str) -> Iterator[Any]:
        """Yield letters by name."""
        return (getattr(self, name) for name in names.split())

    def _rise(self, point: Any) -> Any:
        return point - point.subs(self.q, 0)

    def moment(self, about: Any, acting: Sequence[Acting]) -> Any:
        """Return the sum of moments about z; levers are undeflected, as the motion is small."""
        total = 0
        for point, force in acting:
            arm = (point - about).subs(self.q, 0)
            total += arm[0] * force[1] - arm[1] * force[0]
        return total

    @cached_property
    def solved(self) -> dict[Any, Any]:
        """All reactions and q'' from the balances of the three bars."""
        from sympy import Matrix, solve

        Ax, Ay, Cx, Cy, Dx, Dy, Fx, Fy = self.reactions
        at_A, at_D = Matrix([Ax, Ay]), Matrix([Dx, Dy])
        at_C, at_F = Matrix([Cx, -Cy]), Matrix([-Fx, Fy])  # of CF on the other two bars
        upper, lower = self.springs
        inertia_ABC, inertia_DEF = ((point, -push) for point, push in self.pushes)
        ABC = [(self.A, at_A), (self.C, at_C), upper, inertia_ABC]
        DEF = [(self.D, at_D), (self.F, at_F), lower, inertia_DEF]
        CF = [(self.C, -at_C), (self.F, -at_F)]
        middle = (self.C + self.F) / 2
        equations: list[Any] = []
        for about, acting in ((self.A, ABC), (self.D, DEF), (middle, CF)):
            total = sum((force for _, force in acting), Matrix([0, 0]))
            equations += [*total, self.moment(about, acting)]
        (solution,) = solve(equations, [*self.reactions, self.a], dict=True)
        return dict(solution)


def list_blocks() -> Iterator[ChapterRow]:
    """Yield the rows of the example, in the letters of the chapter; x points away from the wall."""
    blocks = _Blocks()
    yield from _newton_euler(blocks)
    yield from _virtual_work(blocks)
    yield from _lagrange(blocks)


@final
class _Blocks:
    """The blocks: the chapter's forces on both, and its equations of motion, as zeros."""

    def __init__(self) -> None:
        self.mechanism = load("two_blocks")
        self.algebra = Algebra(self.mechanism)
        m1, m2, k1, k2, F, q1, q2, a1, a2 = self.letters("m1 m2 k1 k2 F q1 q2 q1'' q2''")
        self.force1, self.force2 = -k1 * q1 + k2 * (q2 - q1), -k2 * (q2 - q1) + F
        self.row1 = m1 * a1 + (k1 + k2) * q1 - k2 * q2
        self.row2 = m2 * a2 - k2 * q1 + k2 * q2 - F

    def letters(self, names: str) -> Iterator[Series]:
        """Yield letters by name."""
        return (self.algebra.ring[name] for name in names.split())


def _newton_euler(blocks: _Blocks) -> Iterator[ChapterRow]:
    m1, m2, k1, k2, F, a1, a2 = blocks.letters("m1 m2 k1 k2 F q1'' q2''")
    bodies = NewtonEuler(blocks.mechanism, blocks.algebra)
    first, second = bodies.cuts.bodies
    yield identity(
        "Ex. 1.1 a",
        "-k1 q1 + k2 (q2 - q1) = m1 q1'', -k2 (q2 - q1) + F = m2 q2''",
        "both blocks cut free, along x",
        bodies.balances.acting(first).force[0] - blocks.force1,
        bodies.balances.acting(second).force[0] - blocks.force2,
        first.push.force[0] - m1 * a1,
        second.push.force[0] - m2 * a2,
    )
    derived = bodies.derivation()
    yield identity(
        "Ex. 1.1 b",
        "m1 q1'' + (k1 + k2) q1 - k2 q2 = 0, m2 q2'' - k2 q1 + k2 q2 = F",
        "the equations derived by Newton and Euler",
        derived.rows[0] - blocks.row1,
        derived.rows[1] - blocks.row2,
    )
    matrices = linear(derived)
    assert matrices is not None
    yield identity(
        "Ex. 1.1 c",
        "M q'' + K q = f, M = [[m1, 0], [0, m2]], K = [[k1 + k2, -k2], [-k2, k2]], f = [0, F]",
        "the matrices of the derived equations",
        *_entries(matrices.M, ((m1, 0), (0, m2))),
        *_entries(matrices.K, ((k1 + k2, -k2), (-k2, k2))),
        *_entries([matrices.f], ((0, F),)),
    )


def _virtual_work(blocks: _Blocks) -> Iterator[ChapterRow]:
    work = VirtualWork(blocks.mechanism, blocks.algebra).derivation()
    m1, m2, a1, a2, d1, d2 = blocks.letters("m1 m2 q1'' q2'' δq1 δq2")
    (total,) = (stage for stage in work.stages if stage.title == "Sum of the virtual work")
    yield identity(
        "Ex. 1.1 d",
        "[-k1 q1 + k2 (q2 - q1) - m1 q1''] dq1 + [-k2 (q2 - q1) + F - m2 q2''] dq2 = 0",
        "the sum of the ledger of virtual work",
        total.results[0].right
        + total.results[1].right
        - (blocks.force1 - m1 * a1) * d1
        - (blocks.force2 - m2 * a2) * d2,
    )
    yield identity(
        "Ex. 1.1 e",
        "each bracket is zero by itself; rearranged, the same equations",
        "the equations derived by virtual work",
        work.rows[0] - blocks.row1,
        work.rows[1] - blocks.row2,
    )


def _lagrange(blocks: _Blocks) -> Iterator[ChapterRow]:
    m1, m2, k1, k2, F = blocks.letters("m1 m2 k1 k2 F")
    q1, q2, v1, v2 = blocks.letters("q1 q2 q1' q2'")
    lagrange = Lagrange(blocks.mechanism, blocks.algebra)
    T, V = lagrange.T, lagrange.V
    yield identity(
        "Ex. 1.1 f",
        "V = ½ k1 q1² + ½ k2 (q2 - q1)²",
        "the derived potential energy",
        V - k1 * q1**2 / 2 - k2 * (q2 - q1) ** 2 / 2,
    )
    yield identity(
        "Ex. 1.1 g",
        "T = ½ m1 q1'² + ½ m2 q2'²",
        "the derived kinetic energy",
        T - m1 * v1**2 / 2 - m2 * v2**2 / 2,
    )
    (load_,) = (work for work in lagrange.works if work.kind == "work")
    yield identity(
        "Ex. 1.1 h",
        "dW_nc = 0 dq1 + F dq2: Q1 = 0, Q2 = F",
        "the virtual work of the load",
        load_.forces[0],
        load_.forces[1] - F,
    )
    yield identity(
        "Ex. 1.1 i",
        "m1 q1'' - 0 + (k1 q1 - k2 (q2 - q1)) = 0, m2 q2'' - 0 + k2 (q2 - q1) = F",
        "Lagrange's operator on the derived T and V",
        T.diff(v1).ddt() - T.diff("q1") + V.diff("q1") - blocks.row1,
        T.diff(v2).ddt() - T.diff("q2") + V.diff("q2") - (blocks.row2 + F),
    )
    by_lagrange = lagrange.derivation().rows
    yield identity(
        "Ex. 1.1 j",
        "the same equations by Lagrange",
        "the equations derived by Lagrange",
        by_lagrange[0] - blocks.row1,
        by_lagrange[1] - blocks.row2,
    )


def _entries(
    derived: Sequence[Sequence[Series]], stated: Sequence[Sequence[Series | int]]
) -> list[Series]:
    """Return the differences of two matrices, entry by entry."""
    differences = []
    for ours, theirs in zip(derived, stated, strict=True):
        differences += [x - y for x, y in zip(ours, theirs, strict=True)]
    return differences


_BY_POSITIONS = "positions of the straight bars, differentiated"
_BY_BALANCES = "the balances of all bars, solved"


def list_bars() -> Iterator[ChapterRow]:
    """Yield the rows of the example."""
    bars = Bars()
    yield from _kinematics(bars)
    yield from _balance_bars(bars)
    yield from _find_reactions(bars)
    yield from _work(bars)
    yield from _energies_of_bars(bars)
    yield from _catalogue()


def _kinematics(bars: Bars) -> Iterator[ChapterRow]:
    from sympy import Matrix

    l, q, v, a, t = bars.letters("l q v a t")
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


def _balance_bars(bars: Bars) -> Iterator[ChapterRow]:
    """The balances of all bars together."""
    from sympy import Matrix, solve

    m, k, l, q, v, a, t = bars.letters("m k l q v a t")
    Ax, Ay, _, _, Dx, Dy, _, _ = bars.reactions
    solved, equation = bars.solved, bars.equation
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
    H_rate = bars.moment(bars.D, bars.pushes)
    held = [(bars.A, Matrix([Ax, Ay]))]
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


def _find_reactions(bars: Bars) -> Iterator[ChapterRow]:
    """The balances of single bars, and what follows for their reactions."""
    from sympy import Matrix

    m, k, l, q, a = bars.letters("m k l q a")
    Ax, Ay, Cx, Cy, _, Dy, Fx, Fy = bars.reactions
    solved, equation = bars.solved, bars.equation
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


def _work(bars: Bars) -> Iterator[ChapterRow]:
    from sympy import Matrix, solve

    m, k, l, q, a, dq = bars.letters("m k l q a dq")
    Ax, Ay, Cx, Cy, Dx, Dy, Fx, Fy = bars.reactions
    solved, equation = bars.solved, bars.equation
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


def _energies_of_bars(bars: Bars) -> Iterator[ChapterRow]:
    m, k, q, v, a, t = bars.letters("m k q v a t")
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


def _catalogue() -> Iterator[ChapterRow]:
    M, K = 2.0, 70.0
    exact = Bench(entry("bars_and_springs"), {"m": M, "k": K}, "derive", 1, 0)
    yield agreement(
        "Ex. 1.2 14",
        "the exact assembly in small motion: omega = sqrt(36 k/(17 m))",
        "the natural frequency of the exact assembly of the catalogue, linearized",
        (exact.squares({}) ** 0.5, [(36 * K / (17 * M)) ** 0.5]),
    )
    small = Lagrange(load("bars_and_springs_small"))
    m, k, q, a = (small.algebra.ring[name] for name in ("m", "k", "q", "q''"))
    yield identity(
        "Ex. 1.2 15",
        "the catalogue's system for small motion: (17/4) m q'' + 9 k q = 0",
        "the equation derived by Lagrange",
        4 * small.derivation().rows[0] - (17 * m * a / 4 + 9 * k * q),
    )


def sentences() -> Iterator[ChapterRow]:
    """Yield the rows of the examples."""
    yield from _blocks()
    yield from _places(Bars())
    yield from _balances_of_bars(Bars())


def _blocks() -> Iterator[ChapterRow]:
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


def _places(bars: Bars) -> Iterator[ChapterRow]:
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


def _balances_of_bars(bars: Bars) -> Iterator[ChapterRow]:
    from sympy import Matrix, Symbol

    m, k, l, q, v, a, t = bars.letters("m k l q v a t")
    Ax, Ay, _, _, Dx, Dy, Fx, _ = bars.reactions
    solved = bars.solved
    A_y, D_y = -m * a * 3 / 16 - k * q / 4, -m * a / 2
    supports = [(bars.A, Matrix([Ax, Ay])), (bars.D, Matrix([Dx, Dy])), *bars.springs]
    about_D, about_A = (
        bars.moment(point, bars.pushes) - bars.moment(point, supports) for point in (bars.D, bars.A)
    )
    forces = sum((force for _, force in supports), Matrix([0, 0]))
    pushes = sum((push for _, push in bars.pushes), Matrix([0, 0]))
    unknown = (*(pushes - forces), about_D)
    letters = set().union(*(unknown_force.free_symbols for unknown_force in unknown)) - {m, k, l, t}
    yield decision(
        "Ex. 1.2 words d",
        "the balances of the whole are three equations in five unknowns",
        "letters in Ex.1.2.a to Ex.1.2.c: A_x, A_y, D_x, D_y, and q with its rates",
        letters == {Ax, Ay, Dx, Dy},
        all(unknown_force.has(q) for unknown_force in unknown[1:]),
    )
    yield identity(
        "Ex. 1.2 words e",
        "angular momentum about A says nothing new",
        "its balance less that about D is l times that of the forces along x",
        about_A - about_D - l * (pushes - forces)[0],
    )
    equation, on_lower = bars.equation, Dx - Fx
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
    multiple = Symbol("c") * equation
    yield identity(
        "Ex. 1.2 words g",
        "a multiple of the equation of motion may be added to the reactions (footnote)",
        "A_y and D_y of Ex.1.2.h with such a multiple against the balances, solved",
        (A_y + multiple - Ay).subs(solved),
        (D_y - multiple - Dy).subs(solved),
    )
