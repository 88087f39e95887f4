"""Elimination along the tree in space: what defines its solutions, and how firm its loops are."""

from __future__ import annotations

import numpy as np
import pytest

import mecanique as mq
from mecanique.derivation.mechanics.letters import Letters
from mecanique.derivation.mechanics.loops import Loops, loops_of
from mecanique.generation.mechanics.articulated import Articulated, articulate
from mecanique.generation.mechanics.constrained import sample
from mecanique.generation.mechanics.dynamics import Tree
from mecanique.verification.states import random_states

ACROSS = (0, -1, 0)


def hull() -> mq.Mechanism:
    """A floating hull with a crank, a rod and a rocker in space, and a bob tied to the ground."""
    return mq.Mechanism(
        "hull",
        (
            mq.Body("ground"),
            mq.Body("hull", mq.box(3.0, (0.4, 0.3, 0.2)).at((0.1, -0.2, 0.05), (0.3, 0.2, 0.1))),
            mq.Body("crank", mq.rod(1.0, 0.3, (1, 0, 0))),
            mq.Body("rod", mq.box(0.7, (0.9, 0.1, 0.05)).at((0.4, 0.02, 0.01))),
            mq.Body("rocker", mq.rod(1.5, 0.8, (0, 0, 1))),
            mq.Body("bob", mq.box(0.5, (0.1, 0.2, 0.3)).at((0.3, 0.1, -0.2))),
        ),
        (
            mq.Floating("free", "ground", "hull"),
            mq.Revolute("A", "hull", "crank", axis=(0, 0.6, 0.8), armature=0.2),
            mq.Universal("B", "crank", "rod", origin=mq.Placement((0.3, 0, 0), (0.4, -0.2, 0))),
            mq.Revolute(
                "C", "hull", "rocker", axis=(1, 0, 0), origin=mq.Placement((0.7, 0.2, -0.5))
            ),
            mq.Revolute(
                "D", "rocker", "bob", axis=(0.6, 0, 0.8), origin=mq.Placement((0, 0.1, 0.4))
            ),
        ),
        loops=(
            mq.Loop.ball("tip", "rod", (0.9, 0, 0), "rocker", (0, 0, 0.8)),
            mq.Loop.distance("rope", "ground", (0.2, 0.3, 1.5), "bob", (0.3, 0.1, 0), 1.2),
        ),
    )


def presses() -> mq.Mechanism:
    """On a slide a four-bar closed by a hinge, on its rod another closed by a pin, and a truss."""
    lean = mq.Placement((0.1, 0.2, 0.3), (0.4, -0.3, 0.2))
    bodies = [mq.Body("ground"), mq.Body("sled", mq.box(2.0, (0.4, 0.3, 0.2)))]
    joints: list[mq.Joint] = [
        mq.Prismatic("S", "ground", "sled", axis=(0, 0.6, 0.8), origin=lean, armature=0.3)
    ]
    carrier, loops = "sled", list[mq.Loop]()
    for name, (a, b, c, d) in (("k", (0.5, 1.2, 1.1, 1.3)), ("m", (0.6, 1.1, 1.2, 1.35))):
        links = [f"{part}{name}" for part in "abc"]
        for k, (link, length) in enumerate(zip(links, (a, b, c), strict=True)):
            bodies.append(mq.Body(link, mq.rod(0.5 + 0.4 * k, length, direction=(1, 0, 0))))
        joints += [
            mq.Revolute(f"A{name}", carrier, links[0], axis=ACROSS),
            mq.Revolute(f"B{name}", *links[:2], axis=ACROSS, origin=mq.Placement((a, 0, 0))),
            mq.Revolute(f"C{name}", carrier, links[2], axis=ACROSS, origin=mq.Placement((d, 0, 0))),
        ]
        ends = links[1], (b, 0, 0), links[2], (c, 0, 0)
        loops.append(mq.Loop.pin("pin", *ends) if loops else mq.Loop.hinge("hinge", *ends, ACROSS))
        carrier = links[1]
    # no joint of a triangle is left to move once its loop is closed
    for name, foot in (("left", 0.0), ("right", 0.9)):
        bodies.append(mq.Body(name, mq.rod(0.8, 0.7, direction=(1, 0, 0))))
        stand = mq.Placement((foot, 0.2, 0))
        joints.append(mq.Revolute(name, "sled", name, axis=ACROSS, origin=stand))
    loops.append(mq.Loop.pin("top", "left", (0.7, 0, 0), "right", (0.6, 0, 0)))
    return mq.Mechanism("presses", tuple(bodies), tuple(joints), loops=tuple(loops))


def crank() -> mq.Mechanism:
    """A crank and a rod that push a slider, in whose axes they are pinned to it."""
    return mq.Mechanism(
        "crank",
        (
            mq.Body("ground"),
            mq.Body("crank", mq.rod(1.0, 0.5, (1, 0, 0))),
            mq.Body("rod", mq.rod(0.7, 1.2, (1, 0, 0))),
            mq.Body("slider", mq.box(2.0, (0.1, 0.1, 0.1))),
        ),
        (
            mq.Prismatic("S", "ground", "slider", axis=(1, 0, 0)),
            mq.Revolute("A", "ground", "crank", axis=ACROSS),
            mq.Revolute("B", "crank", "rod", axis=ACROSS, origin=mq.Placement((0.5, 0, 0))),
        ),
        loops=(mq.Loop.pin("C", "slider", (0, 0, 0), "rod", (1.2, 0, 0)),),
    )


def firmness(factors: Articulated, M: np.ndarray, J: np.ndarray, loops: Loops) -> float:
    """(Σ w²)^(−1/4), with w = Σ 1/σ² of a loop's rows in motions of the joints passed so far.

    The others rest, and the loops before it are closed.
    """
    joints, closed, total = list[int](), list[int](), 0.0
    steps = [(hasattr(step, "inertia"), step) for step in factors._steps]
    while steps:
        while steps and steps[0][0]:
            joints.append(steps.pop(0)[1].index)  # type: ignore[union-attr]
        rows = list[int]()
        while steps and not steps[0][0]:
            row = steps[0][1].row  # type: ignore[union-attr]
            if rows and loops.blocks[row] // 2 != loops.blocks[rows[0]] // 2:
                break
            rows.append(row)
            steps.pop(0)
        if not rows:
            break
        # directions of unit kinetic energy in which the loops before stay closed
        L = np.linalg.inv(np.linalg.cholesky(M[np.ix_(joints, joints)])).T
        before, here = J[np.ix_(closed, joints)] @ L, J[np.ix_(rows, joints)] @ L
        if closed:
            here = here - here @ np.linalg.pinv(before) @ before
        blocks = np.array([loops.blocks[row] for row in rows])
        for block in set(blocks.tolist()):
            here[blocks == block] /= np.linalg.norm(here[blocks == block])
        total += float(np.sum(np.linalg.svd(here, compute_uv=False) ** -2.0)) ** 2
        closed += rows
    return float(total**-0.25)


@pytest.mark.parametrize("mechanism", [hull(), presses(), crank()], ids=lambda m: m.name)
def test_elimination_along_the_tree_keeps_loops_by_their_forces_alone(
    mechanism: mq.Mechanism,
) -> None:
    """M a = f + Jᵀ λ and J a = −γ; M x = Jᵀ μ and J x = −gaps."""
    states = random_states(mechanism, 4, 3)
    letters = Letters(mechanism)
    tree = Tree(letters)
    loops = loops_of(letters, tree.recursion)
    factors = articulate(letters, tree.recursion, loops, states)
    assert factors is not None
    force = [1.0 + 0.5 * k for k in range(mechanism.nv)]
    gaps = [0.3 - 0.2 * k for k in range(len(loops.names))]
    solution = factors.solve(list(force))
    tables = [
        *(tree.mass_matrix(), loops.jacobian, [loops.gamma]),
        *([solution.acceleration], [solution.multipliers], [factors.close(list(gaps))]),
        [[factors.firmness()]],
        [factors.pivots],
    ]
    kept = [step.row for step in factors._steps if not hasattr(step, "inertia")]
    for M, J, *rows in zip(*sample(letters, tables, states), strict=True):
        gamma, a, multipliers, closing, (firm,), pivots = (row[0] for row in rows)
        assert pivots.min() > 0
        size = np.abs(M @ a).max() + np.abs(J.T @ multipliers).max()
        np.testing.assert_allclose(M @ a - J.T @ multipliers, force, rtol=0, atol=1e-11 * size)
        np.testing.assert_allclose(J @ a, -gamma, rtol=0, atol=1e-10 * (1 + np.abs(a).max()))
        np.testing.assert_allclose((J @ closing)[kept], -np.array(gaps)[kept], rtol=0, atol=1e-10)
        pushed = np.linalg.lstsq(J.T, M @ closing, rcond=1e-10)[0]
        np.testing.assert_allclose(
            J.T @ pushed, M @ closing, rtol=0, atol=1e-10 * np.abs(M @ closing).max()
        )
        assert firm == pytest.approx(firmness(factors, M, J, loops), rel=1e-8)


def test_what_moves_no_mass_by_itself_is_not_eliminated_along_the_tree() -> None:
    """A rod turns on a body without mass that a loop welds to the rocker."""
    bare = mq.Body("end")
    linkage = mq.Mechanism(
        "linkage",
        (
            mq.Body("ground"),
            *(mq.Body(name, mq.rod(1.0, 1.0, (1, 0, 0))) for name in ("crank", "rod", "rocker")),
            bare,
        ),
        (
            mq.Revolute("A", "ground", "crank", axis=ACROSS),
            mq.Revolute("B", "crank", "rod", axis=ACROSS, origin=mq.Placement((1, 0, 0))),
            mq.Revolute("C", "ground", "rocker", axis=ACROSS, origin=mq.Placement((1.5, 0, 0))),
            mq.Revolute("D", "rod", "end", axis=ACROSS, origin=mq.Placement((1, 0, 0))),
        ),
        loops=(mq.Loop("weld", "weld", "end", mq.Placement(), "rocker", mq.Placement((1, 0, 0))),),
    )
    letters = Letters(linkage)
    tree = Tree(letters)
    loops = loops_of(letters, tree.recursion)
    assert articulate(letters, tree.recursion, loops, random_states(linkage, 4, 3)) is None
