"""Example 1.1: two blocks and two springs, by all methods."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import final

from mecanique.derivation.matrix_form import linear
from mecanique.derivation.scalars.series import Series
from mecanique.derivation.symbolic.lagrange import Lagrange
from mecanique.derivation.symbolic.newton_euler import NewtonEuler
from mecanique.derivation.symbolic.symbols import Algebra
from mecanique.derivation.symbolic.virtual_work import VirtualWork
from mecanique.textbook import load
from mecanique.textbook.register.row import Row, identity


def rows() -> Iterator[Row]:
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


def _newton_euler(blocks: _Blocks) -> Iterator[Row]:
    m1, m2, k1, k2, F, a1, a2 = blocks.letters("m1 m2 k1 k2 F q1'' q2''")
    bodies = NewtonEuler(blocks.mechanism, blocks.algebra)
    first, second = bodies.cuts.bodies
    yield identity(
        "Ex. 1.1 a",
        "-k1 q1 + k2 (q2 - q1) = m1 q1'', -k2 (q2 - q1) + F = m2 q2''",
        "both blocks cut free, along x",
        bodies.balances.resultant(first)[0] - blocks.force1,
        bodies.balances.resultant(second)[0] - blocks.force2,
        first.push[0] - m1 * a1,
        second.push[0] - m2 * a2,
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


def _virtual_work(blocks: _Blocks) -> Iterator[Row]:
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


def _lagrange(blocks: _Blocks) -> Iterator[Row]:
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
    found: Sequence[Sequence[Series]], stated: Sequence[Sequence[Series | int]]
) -> list[Series]:
    """Return the differences of two matrices, entry by entry."""
    differences = []
    for ours, theirs in zip(found, stated, strict=True):
        differences += [x - y for x, y in zip(ours, theirs, strict=True)]
    return differences
