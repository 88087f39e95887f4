"""The bars and springs of Example 1.2 in sympy, for small vertical motion.

Positions follow from the bars being straight between their ends, velocities and accelerations from
differentiation, momenta and moments from cross products, reactions from the balances of the single
bars. x points right, y up, the origin is D; C moves down by q. On ABC the bar CF exerts C_x along x
and C_y against y, on DEF it exerts F_x against x and F_y along y; A and D are supports.
"""

from __future__ import annotations

from typing import Any, final

__all__ = ["Bars"]


@final
class Bars:
    """The assembly in sympy, for small vertical motion."""

    def __init__(self) -> None:
        from sympy import Function, Matrix, Symbol, symbols

        self.m, self.k, self.l = symbols("m k l", positive=True)
        t = Symbol("t")
        q = Function("q")(t)
        self.q, self.v, self.a = q, q.diff(t), q.diff(t, 2)
        length = self.l
        self.A, self.D = Matrix([0, length]), Matrix([0, 0])
        C, F = Matrix([4 * length, length - q]), Matrix([4 * length, -q])
        self.B, self.E = self.A + (C - self.A) * 3 / 4, self.D + (F - self.D) / 2
        self.Bs, self.C, self.F = self.A + (C - self.A) / 2, C, F
        self.t = t
        self.reactions = symbols("A_x A_y C_x C_y D_x D_y F_x F_y")
        self.delta = Symbol("delta_q")

    def rate(self, point: Any, order: int = 1) -> Any:
        """Velocity or acceleration of a point."""
        return point.diff(self.t, order)

    @property
    def center(self) -> Any:
        """Center of mass of both particles."""
        return (self.m * self.B + 2 * self.m * self.E) / (3 * self.m)

    @property
    def springs(self) -> tuple[tuple[Any, Any], tuple[Any, Any]]:
        """Point and force of each spring: it resists the displacement of its end."""
        from sympy import Matrix

        lifts = [
            -stiffness * (point - point.subs(self.q, 0))
            for stiffness, point in ((self.k, self.Bs), (2 * self.k, self.F))
        ]
        return (self.Bs, Matrix(lifts[0])), (self.F, Matrix(lifts[1]))

    @property
    def pushes(self) -> tuple[tuple[Any, Any], tuple[Any, Any]]:
        """Point and rate of momentum of each particle."""
        return (self.B, self.m * self.rate(self.B, 2)), (self.E, 2 * self.m * self.rate(self.E, 2))

    def moment(self, about: Any, pairs: Any, *, undeformed: bool = True) -> Any:
        """Sum of moments about a point, z component; levers of the undeflected assembly, as motion is small."""
        total = 0
        for point, force in pairs:
            arm = (point - about).subs(self.q, 0) if undeformed else point - about
            total += arm[0] * force[1] - arm[1] * force[0]
        return total

    @property
    def equation(self) -> Any:
        """The left side of the equation of motion as it is printed."""
        return self.m * self.a * 17 / 4 + 9 * self.k * self.q

    @property
    def solved(self) -> dict[Any, Any]:
        """All reactions and q'' from the balances of the three bars."""
        from sympy import Matrix, Symbol, solve

        Ax, Ay, Cx, Cy, Dx, Dy, Fx, Fy = self.reactions
        acceleration = Symbol("q2")
        abc = [(self.A, Matrix([Ax, Ay])), (self.C, Matrix([Cx, -Cy])), self.springs[0]]
        deform = [(self.D, Matrix([Dx, Dy])), (self.F, Matrix([-Fx, Fy])), self.springs[1]]
        cf = [(self.C, Matrix([-Cx, Cy])), (self.F, Matrix([Fx, -Fy]))]
        middle = (self.C + self.F) / 2
        equations: list[Any] = []
        for forces, push, point in (
            (abc, self.pushes[0], self.A),
            (deform, self.pushes[1], self.D),
            (cf, None, middle),
        ):
            given = [] if push is None else [(push[0], -push[1])]
            total = sum((force for _, force in [*forces, *given]), Matrix([0, 0]))
            equations += [*total, self.moment(point, [*forces, *given])]
        equations = [equation.subs(self.a, acceleration) for equation in equations]
        (found,) = solve(equations, [*self.reactions, acceleration], dict=True)
        return {**found, "q''": found[acceleration]}
