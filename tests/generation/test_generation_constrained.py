"""Accelerations, multipliers and corrections of closed mechanisms, held to what defines them."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import null_space

import mecanique as mq
from mecanique.derivation.mechanics.letters import Letters
from mecanique.derivation.mechanics.loops import loops_of
from mecanique.generation.mechanics.constrained import (
    FactorizedConstraints,
    independent,
    landing_of,
    sample,
)
from mecanique.generation.mechanics.dynamics import Tree
from mecanique.program.traced import trace
from mecanique.verification.states import random_states


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


MECHANISMS = {
    "a loop": mq.textbook.load("four_bar_linkage"),
    "several loops": mq.textbook.load("chained_four_bars"),
    "a wheel": mq.textbook.load("rolling_coin"),
    "a blade": mq.textbook.load("chaplygin_sleigh"),
    "eliminated velocities": mq.textbook.load("rattleback"),
    "a heavy rod": crank(mq.rod(0.7, 1.2, (1, 0, 0))),
    "a massless rod": crank(mq.bar(1.2, (1, 0, 0))),
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
