"""Robots as code: the recursion traced with their numbers folded, or with letters kept."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import mecanique as mq
from mecanique.generation.build import build_program

pytestmark = pytest.mark.usefixtures("in_process")

OPERATIONS = {
    "panda": {"inverse_dynamics": 650, "acceleration": 1340, "mass_matrix": 474},
    "ur5_robot": {"inverse_dynamics": 340, "acceleration": 667, "mass_matrix": 262},
    "talos_reduced": {"inverse_dynamics": 3187, "acceleration": 7413, "mass_matrix": 2744},
}
"""Operations of robots without friction, Panda with its fingers locked: no more than these."""


def robot(name: str) -> mq.Mechanism:
    found = mq.read_urdf(mq.robot(name), damping=False)
    joints = [
        mq.Fixed(joint.name, joint.parent, joint.child, origin=joint.origin)
        if "finger" in joint.name
        else joint
        for joint in found.joints
    ]
    return replace(found, joints=tuple(joints), coordinates=mq.Coordinates(()))


@pytest.mark.parametrize("name", OPERATIONS)
def test_programs_of_robots_stay_short(name: str) -> None:
    most = OPERATIONS[name]
    program = build_program(mq.derive(robot(name)), tuple(most))
    for quantity, operations in most.items():
        assert program.count(quantity).total <= operations


@pytest.mark.parametrize(
    ("name", "root"), [("panda", "fixed"), ("solo", "floating"), ("talos_reduced", "fixed")]
)
def test_the_code_of_robots_gives_what_pinocchio_gives(name: str, root: str) -> None:
    mechanism = mq.read_urdf(mq.robot(name), root="floating" if root == "floating" else "fixed")
    what = ("rhs", "inverse_dynamics", "mass_matrix", "energy", "poses")
    verdict = mq.generate(mq.derive(mechanism), "python", what, samples=20).verdict
    assert verdict is not None
    assert verdict.samples == 20
    for quantity, worst in verdict.worst.items():
        assert worst <= (max(1e-13, verdict.rounded[quantity]) if quantity == "rhs" else 1e-13)


def test_masses_stay_letters_where_asked() -> None:
    mechanism = mq.read_urdf(mq.robot("ur5_robot"), parameters="masses")
    code = mq.generate(mq.derive(mechanism), "c", "inverse_dynamics")
    assert len(code.parameters) == len(mechanism.parameters) >= 6
    assert code.verdict is not None
    assert code.verdict.varied == 50
    folded = mq.generate(mq.derive(mechanism), "c", "inverse_dynamics", parameters=())
    assert folded.parameters == ()
    assert folded.count().total < code.count().total
    q, v, a = np.random.default_rng(0).normal(size=(3, 6))
    same = [made.compile().inverse_dynamics(0.0, q, v, a) for made in (code, folded)]
    np.testing.assert_allclose(same[0], same[1], rtol=1e-12, atol=1e-12)
