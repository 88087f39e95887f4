"""The bars and springs of Example 1.2 in sympy, for small vertical motion.

Positions follow from straight bars between their ends, velocities and accelerations from
differentiation, momenta and moments from cross products, reactions from the balances of the single
bars. x points right, y up, the origin is D; C moves down by q. On ABC the bar CF exerts C_x along x
and C_y against y, on DEF it exerts F_x against x and F_y along y; A and D are supports.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, TypeAlias, final

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

    def _rise(self, point: Any) -> Any:
        return point - point.subs(self.q, 0)

    def moment(self, about: Any, acting: Sequence[Acting]) -> Any:
        """Return the sum of moments about z; levers are undeflected, as the motion is small."""
        total = 0
        for point, force in acting:
            arm = (point - about).subs(self.q, 0)
            total += arm[0] * force[1] - arm[1] * force[0]
        return total

    def solve(self) -> dict[Any, Any]:
        """Return all reactions and q'' from the balances of the three bars."""
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
        (found,) = solve(equations, [*self.reactions, self.a], dict=True)
        return dict(found)
