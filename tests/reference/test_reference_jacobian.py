"""The Jacobian of a body against the velocities of its points."""

from __future__ import annotations

import numpy as np
import pytest

import mecanique as mq


@pytest.mark.parametrize(
    "name",
    [
        "double_pendulum",
        "free_rigid_body",
        "gyroscope",
        "kapitza_pendulum",
        "simple_pendulum",
        "two_blocks",
    ],
)
def test_points_move_as_the_jacobian_says(name: str) -> None:
    mechanism = mq.textbook.load(name)
    reference = mq.Reference(mechanism)
    rng = np.random.default_rng(3)
    q = mechanism.position(mechanism.neutral() + 0.3 * rng.normal(size=mechanism.nq))
    v, t = rng.normal(size=mechanism.nv), 0.7
    for body in mechanism.bodies:
        poses = reference.poses(q, t)[mechanism.bodies.index(body)]
        jacobian = reference.jacobian(body.name, q, t)
        assert jacobian.shape == (6, mechanism.nv)
        for xyz in np.eye(3):
            moved = reference.point(body.name, xyz, q, v, t=t).velocity
            carried = reference.point(body.name, xyz, q, t=t).velocity
            linear, angular = (jacobian @ v).reshape(2, 3)
            np.testing.assert_allclose(
                linear + np.cross(angular, poses[:3, :3] @ xyz),
                moved - carried,
                rtol=0,
                atol=1e-14 * (1 + np.abs(v).max()),
            )


def test_a_body_that_is_not_there_is_told() -> None:
    with pytest.raises(mq.UnknownNameError, match="unknown body 'rodd'; did you mean 'rod'"):
        mq.Reference(mq.textbook.load("rigid_bar_pendulum")).jacobian("rodd", [0.0])
