"""Accelerations, multipliers and corrections of closed mechanisms, held to what defines them."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from scipy.linalg import null_space

import mecanique as mq
from mecanique.derivation.mechanics.letters import Letters
from mecanique.derivation.mechanics.loops import loops_of
from mecanique.derivation.mechanics.vectors import Rows
from mecanique.generation.mechanics.constrained import (
    FactorizedConstraints,
    _is_singular,
    _reduce,
    independent,
    landing_of,
    sample,
)
from mecanique.generation.mechanics.dynamics import Tree
from mecanique.program.traced import trace
from mecanique.verification.states import random_states


def linkage(size: float) -> mq.Mechanism:
    """A four-bar linkage of heavy links, but for its massless rod; size [m]."""
    a, b, c, d = (size * length for length in (0.5, 1.2, 1.1, 1.3))
    shapes = {"a": mq.rod(2.0, a, (1, 0, 0)), "b": mq.bar(b, (1, 0, 0)), "c": mq.rod(3.0, c)}
    across = (0, -1, 0)
    return mq.Mechanism(
        "linkage",
        (mq.Body("ground"), *(mq.Body(name, shape) for name, shape in shapes.items())),
        (
            mq.Revolute("A", "ground", "a", axis=across),
            mq.Revolute("B", "a", "b", axis=across, origin=mq.Placement((a, 0, 0))),
            mq.Revolute("C", "ground", "c", axis=across, origin=mq.Placement((d, 0, 0))),
        ),
        loops=(mq.Loop.pin("D", "b", (b, 0, 0), "c", (0, 0, c)),),
    )


def crank(rod: mq.Shape) -> mq.Mechanism:
    """A crank, a rod and a slider, closed by a pin; nothing weighs where the rod is massless."""
    across = (0, -1, 0)
    return mq.Mechanism(
        "crank",
        (
            mq.Body("ground"),
            mq.Body("crank", mq.rod(1.0, 0.5, (1, 0, 0))),
            mq.Body("rod", rod),
            mq.Body("slider", mq.box(2.0, (0.1, 0.1, 0.1))),
        ),
        (
            mq.Revolute("A", "ground", "crank", axis=across),
            mq.Revolute("B", "crank", "rod", axis=across, origin=mq.Placement((0.5, 0, 0))),
            mq.Prismatic("S", "ground", "slider", axis=(1, 0, 0)),
        ),
        loops=(mq.Loop.pin("C", "rod", (1.2, 0, 0), "slider", (0, 0, 0)),),
    )


def sleigh() -> mq.Mechanism:
    """A blade on two slides, of which a flywheel drives the first one."""
    turn = mq.coordinate("T")
    return mq.Mechanism(
        "sleigh",
        (
            *(mq.Body("ground"), mq.Body("carriage", mq.particle(1.5))),
            *(mq.Body("cross", mq.particle(0.5)), mq.Body("wheel", mq.disk(2.0, 0.3))),
            mq.Body("blade", mq.box(3.0, (0.5, 0.1, 0.2)).at((0.2, 0.1, 0))),
        ),
        (
            mq.Prismatic("X", "ground", "carriage", axis=(1, 0, 0)),
            mq.Prismatic("Y", "carriage", "cross", axis=(0, 1, 0)),
            mq.Revolute("T", "cross", "blade", axis=(0, 0, 1)),
            mq.Revolute("F", "ground", "wheel", axis=(0, 0, 1)),
        ),
        velocity_constraints=(
            mq.VelocityConstraint("drives", {"X": 2.0, "F": -0.3}, rate=mq.sin(mq.time())),
            mq.VelocityConstraint("cuts", {"X": mq.sin(turn), "Y": -mq.cos(turn)}),
        ),
    )


MECHANISMS = {
    "a drive and a blade": sleigh(),
    "a loop": mq.textbook.load("four_bar_linkage"),
    "several loops": mq.textbook.load("chained_four_bars"),
    "a wheel": mq.textbook.load("rolling_coin"),
    "a blade": mq.textbook.load("chaplygin_sleigh"),
    "eliminated velocities": mq.textbook.load("rattleback"),
    "a heavy rod": crank(mq.rod(0.7, 1.2, (1, 0, 0))),
    "a massless rod": crank(mq.bar(1.2, (1, 0, 0))),
    "a massless rod of a tiny linkage": linkage(1e-6),
}


@pytest.mark.parametrize("name", MECHANISMS)
def test_constraints_are_kept_by_their_forces_alone(name: str) -> None:
    """M a = f + Jᵀ λ and J a = −γ; what closes gaps has J x = −gaps and works on no free motion."""
    mechanism = MECHANISMS[name]
    states = random_states(mechanism, 4, 5)
    letters = Letters(mechanism)
    tree = Tree(letters)
    M, loops = tree.mass_matrix(), loops_of(letters, tree.recursion)
    factors = FactorizedConstraints(letters, M, loops)
    force = [1.0 + 0.5 * k for k in range(mechanism.nv)]
    gaps = [0.3 - 0.2 * k for k in range(len(loops.names))]
    solution, landing = factors.solve(list(force)), landing_of(letters, loops, factors)
    changes = [trace(letters.tape, value) for value in landing.changes]
    tables = [
        *(M, loops.jacobian, [loops.gamma], [loops.residual], [loops.rate]),
        *([solution.acceleration], [solution.multipliers], [factors.close(list(gaps))], [changes]),
        [[trace(letters.tape, landing.firmness)]],
    ]
    for M_, J, *rows in zip(*sample(letters, tables, states), strict=True):
        gamma, residual, rate, a, multipliers, closing, change, (firm,) = (row[0] for row in rows)
        size = np.abs(M_ @ a).max() + np.abs(J.T @ multipliers).max()
        np.testing.assert_allclose(M_ @ a - J.T @ multipliers, force, rtol=0, atol=1e-11 * size)
        free = np.abs(np.linalg.pinv(M_, hermitian=True) @ force).max() + np.abs(a).max()
        np.testing.assert_allclose(J @ a, -gamma, rtol=0, atol=1e-10 * free)
        turned = change[-mechanism.nv :]
        moved = mechanism.nq == mechanism.nv  # else of quaternions, which change with them
        pairs = [
            (closing, gaps),
            (turned, rate),
            *([(change[: mechanism.nv], residual)] if moved else []),
        ]
        for x, gap in pairs:
            np.testing.assert_allclose(J @ x, -np.asarray(gap), rtol=0, atol=1e-10)
            work = null_space(J).T @ M_ @ x
            np.testing.assert_allclose(work, 0, rtol=0, atol=1e-10 * max(np.abs(M_ @ x).max(), 1))
        if np.linalg.cond(M_) < 1e8:
            assert firm == pytest.approx(firmness(M_, J, loops.blocks), rel=1e-8)


def firmness(M: np.ndarray, J: np.ndarray, blocks: tuple[int, ...]) -> float:
    """(Σ 1/σ²)^(−1/2) of the rows of J in directions of unit kinetic energy."""
    rows = J @ np.linalg.inv(np.linalg.cholesky(M)).T
    for block in set(blocks):
        own = [k for k, other in enumerate(blocks) if other == block]
        rows[own] /= np.linalg.norm(rows[own])
    return float(np.sum(np.linalg.svd(rows, compute_uv=False) ** -2.0) ** -0.5)


@pytest.mark.parametrize(
    ("jacobians", "kept"),
    [
        ([[[1.0, 0.0], [0.0, 1.0]]], [0, 1]),
        # of whatever size, if it is any
        ([[[1e-8, 0.0], [0.0, 1e6]]], [0, 1]),
        ([[[0.0, 0.0], [0.0, 1.0]]], [1]),
        # what follows from rows before it, up to rounding
        ([[[1.0, 2.0], [-3.0, -6.0], [0.0, 1.0]]], [0, 2]),
        ([[[1.0, 0.0], [1.0, 1e-9]]], [0]),
        ([[[1.0, 0.0], [1.0, 1e-7]]], [0, 1]),
        ([[[1.0, 0.0], [0.0, 1.0], [1.0, 1.0]]], [0, 1]),
        # in every state
        ([[[1.0, 0.0], [1.0, 0.0]], [[1.0, 0.0], [1.0, 1.0]]], [0, 1]),
        ([[[1.0, 0.0], [2.0, 0.0]], [[0.0, 1.0], [0.0, 3.0]]], [0]),
        (np.zeros((2, 0, 3)).tolist(), []),
    ],
)
def test_rows_that_follow_from_others_are_left_out(
    jacobians: list[list[list[float]]], kept: list[int]
) -> None:
    shape = (len(jacobians), len(jacobians[0]), -1) if jacobians[0] else (2, 0, 3)
    assert independent(np.array(jacobians).reshape(shape)) == kept


def test_velocities_with_a_constant_factor_of_their_own_are_expressed_by_the_others() -> None:
    """Their rows form a diagonal of numbers; J a = −γ in these rows for any others."""
    s = Fraction(1, 3)  # of what varies, as it is no float
    J: Rows = [
        [2.0, 0.0, s, 0.0],
        [0.0, -4.0, 2 * s, 0.0],
        [1.0, 0.0, 0.0, 5.0],  # its first velocity is taken
        [0.0, 0.0, 7 * s, 3.0],
    ]
    gamma = [0.5, -1.5, 2.5, 3.5]
    reduced = _reduce(J, gamma)
    assert reduced.pivots == {0: 0, 1: 1, 3: 3}
    assert reduced.others == [2]
    S, c = (np.array(part, dtype=float) for part in (reduced.spread, reduced.rest))
    for b in (0.0, 1.7):
        a = S[:, 0] * b + c
        assert a[2] == b
        for k in reduced.pivots:
            assert np.array(J[k], dtype=float) @ a == pytest.approx(-gamma[k], rel=1e-14)


@pytest.mark.parametrize(
    ("M", "singular"),
    [
        ([[3.0]], False),
        ([[0.0]], True),
        ([[2.0, 1.0], [1.0, 2.0]], False),
        ([[1.0, 1.0], [1.0, 1.0]], True),
        ([[1.0, 0.0], [0.0, 0.0]], True),
        # whatever the units are
        ([[1e-12, 0.0], [0.0, 1e12]], False),
        ([[1e-12, 1.0], [1.0, 1e12]], True),
        ([[1.0, 1 - 0.9e-8], [1 - 0.9e-8, 1.0]], True),
        ([[1.0, 1 - 1.1e-8], [1 - 1.1e-8, 1.0]], False),
    ],
)
def test_a_mass_matrix_is_singular_where_some_motion_has_no_mass(
    M: list[list[float]], singular: bool
) -> None:
    sound = np.eye(len(M))
    assert _is_singular(np.array([sound, M])) == singular
