"""Example 1.1: two blocks and two springs, by all methods."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any, final

from mecanique.derivation.matrix_form import linear
from mecanique.derivation.symbolic.lagrange import Lagrange
from mecanique.derivation.symbolic.newton_euler import NewtonEuler
from mecanique.derivation.symbolic.symbols import Algebra
from mecanique.derivation.symbolic.virtual_work import VirtualWork
from mecanique.textbook import load
from mecanique.textbook.register.row import Check, Finding, identical

__all__ = ["CHECKS"]


@final
class _Blocks:
    """The two blocks in the letters of the chapter; along x, away from the wall."""

    def __init__(self) -> None:
        mechanism = load("two_blocks")
        algebra = Algebra(mechanism)
        ring = algebra.ring
        self.m1, self.m2, self.k1, self.k2, self.F = (
            ring[name] for name in ("m1", "m2", "k1", "k2", "F")
        )
        self.q1, self.q2, self.v1, self.v2, self.a1, self.a2 = (
            ring[name] for name in ("q1", "q2", "q1'", "q2'", "q1''", "q2''")
        )
        self.bodies = NewtonEuler(mechanism, algebra)
        work = VirtualWork(mechanism, algebra)
        self.work = work.derivation()
        self.d1, self.d2 = ring["δq1"], ring["δq2"]
        self.lagrange = Lagrange(mechanism, algebra)
        self.rows = self.lagrange.derivation().rows
        self.balanced = self.bodies.derivation().rows
        first, second = self.bodies.cuts.bodies
        self.pushes = [cut.push[0] for cut in (first, second)]
        self.forces = [self.bodies.resultant(cut)[0] for cut in (first, second)]
        self.left1 = -self.k1 * self.q1 + self.k2 * (self.q2 - self.q1)
        self.left2 = -self.k2 * (self.q2 - self.q1) + self.F
        self.row1 = self.m1 * self.a1 + (self.k1 + self.k2) * self.q1 - self.k2 * self.q2
        self.row2 = self.m2 * self.a2 - self.k2 * self.q1 + self.k2 * self.q2 - self.F


@cache
def _blocks() -> _Blocks:
    return _Blocks()


def _exact(difference: Callable[[_Blocks], Any], how: str) -> Callable[[], Finding]:
    return lambda: identical(difference(_blocks()), how)


def _matrices(b: _Blocks) -> list[Any]:
    """M q'' + K q = f from the coefficients of the derived equations."""
    found = linear(b.bodies.derivation())
    assert found is not None
    M = ((b.m1, 0), (0, b.m2))
    K = ((b.k1 + b.k2, -b.k2), (-b.k2, b.k2))
    pairs = [(found.M, M), (found.K, K)]
    entries = [
        x - y
        for ours, theirs in pairs
        for a, c in zip(ours, theirs, strict=True)
        for x, y in zip(a, c, strict=True)
    ]
    return [*entries, found.f[0], found.f[1] - b.F]


def _summed(b: _Blocks) -> Any:
    (stage,) = [stage for stage in b.work.stages if stage.title == "Sum of the virtual work"]
    whole = stage.results[0].right + stage.results[1].right
    return whole - (b.left1 - b.m1 * b.a1) * b.d1 - (b.left2 - b.m2 * b.a2) * b.d2


def _potential(b: _Blocks) -> Any:
    return b.lagrange.V - b.k1 * b.q1**2 / 2 - b.k2 * (b.q2 - b.q1) ** 2 / 2


def _nonconservative(b: _Blocks) -> list[Any]:
    loads = [work for work in b.lagrange.works if work.kind == "work"]
    (load_,) = loads
    return [load_.forces[0], load_.forces[1] - b.F]


def _operator(b: _Blocks) -> list[Any]:
    T, V = b.lagrange.T, b.lagrange.V
    found = []
    for q, v, expected in (("q1", b.v1, b.row1), ("q2", b.v2, b.row2 + b.F)):
        found.append(T.diff(v).ddt() - T.diff(q) + V.diff(q) - expected)
    return found


CHECKS = (
    Check(
        "Ex. 1.1 a",
        "-k1 q1 + k2 (q2 - q1) = m1 q1'', -k2 (q2 - q1) + F = m2 q2''",
        _exact(
            lambda b: [
                b.forces[0] - b.left1,
                b.forces[1] - b.left2,
                b.pushes[0] - b.m1 * b.a1,
                b.pushes[1] - b.m2 * b.a2,
            ],
            "both blocks cut free, along x",
        ),
    ),
    Check(
        "Ex. 1.1 b",
        "m1 q1'' + (k1 + k2) q1 - k2 q2 = 0, m2 q2'' - k2 q1 + k2 q2 = F",
        _exact(
            lambda b: [b.balanced[0] - b.row1, b.balanced[1] - b.row2],
            "the equations derived by Newton and Euler",
        ),
    ),
    Check(
        "Ex. 1.1 c",
        "M q'' + K q = f, M = [[m1, 0], [0, m2]], K = [[k1 + k2, -k2], [-k2, k2]], f = [0, F]",
        _exact(_matrices, "the matrices of the derived equations"),
    ),
    Check(
        "Ex. 1.1 d",
        "[-k1 q1 + k2 (q2 - q1) - m1 q1''] dq1 + [-k2 (q2 - q1) + F - m2 q2''] dq2 = 0",
        _exact(_summed, "the sum of the ledger of virtual work"),
    ),
    Check(
        "Ex. 1.1 e",
        "each bracket is zero by itself; rearranged, the same equations",
        _exact(
            lambda b: [b.work.rows[0] - b.row1, b.work.rows[1] - b.row2],
            "the equations derived by virtual work",
        ),
    ),
    Check(
        "Ex. 1.1 f",
        "V = ½ k1 q1² + ½ k2 (q2 - q1)²",
        _exact(_potential, "the derived potential energy"),
    ),
    Check(
        "Ex. 1.1 g",
        "T = ½ m1 q1'² + ½ m2 q2'²",
        _exact(
            lambda b: b.lagrange.T - b.m1 * b.v1**2 / 2 - b.m2 * b.v2**2 / 2,
            "the derived kinetic energy",
        ),
    ),
    Check(
        "Ex. 1.1 h",
        "dW_nc = 0 dq1 + F dq2: Q1 = 0, Q2 = F",
        _exact(_nonconservative, "the virtual work of the load"),
    ),
    Check(
        "Ex. 1.1 i",
        "m1 q1'' - 0 + (k1 q1 - k2 (q2 - q1)) = 0, m2 q2'' - 0 + k2 (q2 - q1) = F",
        _exact(_operator, "Lagrange's operator on the derived T and V"),
    ),
    Check(
        "Ex. 1.1 j",
        "the same equations by Lagrange",
        _exact(
            lambda b: [b.rows[0] - b.row1, b.rows[1] - b.row2], "the equations derived by Lagrange"
        ),
    ),
)
