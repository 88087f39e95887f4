"""Long chains of loops: elimination along the tree, and leaps across flat positions."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from reference_samples import parallelograms
from test_reference_metric import fall_of_parallelograms

import mecanique as mq
from mecanique.derivation.mechanics.letters import Letters
from mecanique.derivation.mechanics.loops import loops_of
from mecanique.generation.mechanics.articulated import articulate
from mecanique.generation.mechanics.constrained import FactorizedConstraints, inputs_at
from mecanique.generation.mechanics.dynamics import Tree
from mecanique.model import Body, Loop, Mechanism, Placement, Prismatic, Revolute, Spring, box, rod
from mecanique.motion.compile.derive import program_of
from mecanique.motion.compile.program import is_long_chain
from mecanique.motion.compile.stepper import has_compiler
from mecanique.program.evaluation import evaluate
from mecanique.program.traced import values_of
from mecanique.reference.loops import singular
from mecanique.verification.states import random_states

compiled = pytest.mark.skipif(not has_compiler(), reason="needs a C compiler")


def windows(count: int) -> Mechanism:
    """Four-bars in a row, no two alike, each closed between its own links, with a slide below."""
    bodies = [Body("ground"), Body("sled", box(3.0, (0.4, 0.3, 0.2)))]
    joints: list[Any] = [Prismatic("S", "ground", "sled", axis=(1, 0, 0))]
    loops = []
    carrier, place = "sled", (0.0, 0.0, 0.0)
    for k in range(count):
        lengths = 0.5 + 0.05 * k, 1.2 + 0.03 * k, 1.1, 1.3
        for name, length in zip("abc", lengths[:3], strict=True):
            bodies.append(Body(f"{name}{k}", rod(length, length, direction=(1, 0, 0))))
        near, far = Placement(place), Placement((place[0] + lengths[3], place[1], place[2]))
        tip = Placement((lengths[0], 0, 0))
        axis = (0, -1, 0)
        joints += [
            Revolute(f"A{k}", carrier, f"a{k}", axis=axis, origin=near),
            Revolute(f"B{k}", f"a{k}", f"b{k}", axis=axis, origin=tip),
            Revolute(f"C{k}", carrier, f"c{k}", axis=axis, origin=far),
        ]
        ends = f"b{k}", (lengths[1], 0, 0), f"c{k}", (lengths[2], 0, 0)
        loops.append(Loop.pin(f"loop{k}", *ends))
        carrier, place = f"b{k}", (0.3, 0.0, 0.0)
    spring = Spring("spring", "sled", (0, 0, 0), "ground", (2, 0, 0.5), 40.0, 1.0)
    return Mechanism("windows", tuple(bodies), tuple(joints), forces=(spring,), loops=tuple(loops))


@pytest.mark.parametrize(
    "mechanism",
    [parallelograms(2, serial=True), parallelograms(4, serial=False), windows(1), windows(3)],
    ids=["serial", "uprights", "window", "windows"],
)
def test_elimination_along_the_tree_gives_what_the_matrix_gives(mechanism: Mechanism) -> None:
    states = random_states(mechanism, 10, 3)
    letters = Letters(mechanism)
    tree = Tree(letters)
    loops = loops_of(letters, tree.recursion)
    drive = [Q - h for Q, h in zip(tree.forces(), tree.bias(), strict=True)]
    along = articulate(letters, tree.recursion, loops, states)
    assert along is not None
    by_matrix = FactorizedConstraints(letters, tree.mass_matrix(), loops, states)
    answers = []
    for factors in (along, by_matrix):
        solution = factors.solve(drive)
        answer = [
            *solution.acceleration,
            *solution.multipliers,
            *factors.close([1.0 + k for k in range(len(loops.names))]),
            # of several loops it is judged loop by loop along the tree
            *([factors.firmness()] if len(mechanism.loops) == 1 else []),
        ]
        values = values_of(answer)
        answers.append(evaluate(letters.tape, values, inputs_at(letters, states), len(states)))
    size = np.abs(answers[1]).max(axis=1, keepdims=True)
    np.testing.assert_allclose(answers[0] / size, answers[1] / size, rtol=0, atol=1e-9)


def test_operations_of_a_chain_grow_with_its_length() -> None:
    lengths = [program_of(m, states=random_states(m, 4, 0)).length for m in map(_row, (6, 12, 18))]
    assert lengths[2] - lengths[1] == pytest.approx(lengths[1] - lengths[0], rel=1e-3, abs=0)


def _row(count: int) -> Mechanism:
    return parallelograms(count, serial=True)


@compiled
def test_a_long_chain_leaps_across_flat_positions(monkeypatch: pytest.MonkeyPatch) -> None:
    """No state near them is asked of the engine, whose matrices are dense."""

    def refuse(*arguments: object) -> None:
        raise AssertionError("an acceleration is interpolated by the engine")

    monkeypatch.setattr(singular, "_interpolate", refuse)
    mechanism = parallelograms(20, serial=True)
    assert is_long_chain(mechanism)
    rates = {j.name: -1.0 if j.child.startswith("up") else 1.0 for j in mechanism.joints}
    motion = mq.simulate(
        mechanism, v=rates, duration=3.0, samples=101, rtol=1e-10, method="compiled"
    )
    fall = fall_of_parallelograms(20, motion.t)
    assert fall.min() < -5 * np.pi / 2
    np.testing.assert_allclose(motion["A0"], fall, rtol=0, atol=3e-9)


def test_a_long_chain_is_chosen_for_its_program() -> None:
    if not has_compiler():
        pytest.skip("needs a C compiler")
    mechanism = parallelograms(12, serial=True)
    rates = {j.name: -1.0 if j.child.startswith("up") else 1.0 for j in mechanism.joints}
    motion = mq.simulate(mechanism, v=rates, duration=4.0, samples=11)
    assert motion.method.startswith("compiled")
    np.testing.assert_allclose(
        motion["A0"], fall_of_parallelograms(12, motion.t), rtol=0, atol=1e-8
    )
