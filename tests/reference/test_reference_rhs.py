from __future__ import annotations

import numpy as np
import pytest

import mecanique as mq

ROD = mq.rod(1.0, 1.0)


def pair(coordinates: mq.Coordinates, armature: float) -> mq.Mechanism:
    """Two rods, the second hanging from the first."""
    joints = (
        mq.Revolute("a", "ground", "first", axis=(0, -1, 0), coordinate="r1", armature=armature),
        mq.Revolute(
            "b",
            "first",
            "second",
            axis=(0, -1, 0),
            origin=mq.Placement((0, 0, -1)),
            coordinate="r2",
        ),
    )
    bodies = (mq.Body("ground"), mq.Body("first", ROD), mq.Body("second", ROD))
    return mq.Mechanism("pair", bodies, joints, gravity=(0, 0, -9.81), coordinates=coordinates)


q1, q2 = mq.coordinate("q1"), mq.coordinate("q2")
MAPS = {
    "own angles": mq.Coordinates(("r1", "r2")),
    "absolute angles": mq.Coordinates(("q1", "q2"), {"r1": q1, "r2": q2 - q1}),
    "with an offset of many turns": mq.Coordinates(
        ("q1", "q2"), {"r1": q1 + 7.5, "r2": 2 * q2 - q1 - 40.25}
    ),
    "in another order": mq.Coordinates(("q1", "q2"), {"r1": q2, "r2": q1}),
}


@pytest.mark.parametrize("name", sorted(MAPS))
@pytest.mark.parametrize("armature", [0.0, 0.3])
def test_hinges_move_alike_in_all_coordinates(name: str, armature: float) -> None:
    reference = mq.Reference(pair(MAPS[name], armature))
    f, random = reference.rhs(), np.random.default_rng(0)
    for _ in range(5):
        q, v = random.uniform(-30, 30, 2), random.uniform(-3, 3, 2)
        y = f(0.0, np.concatenate([q, v]))
        assert y[:2].tolist() == v.tolist()
        np.testing.assert_allclose(y[2:], reference.acceleration(q, v), rtol=1e-9, atol=1e-9)
