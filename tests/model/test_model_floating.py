"""States of free bodies in the conventions of others, beside SciPy's, URDF's and Pinocchio's."""

from __future__ import annotations

from itertools import product
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import mecanique as mq
from mecanique.reference import Reference

BODY = mq.textbook.load("free_rigid_body")
RANDOM = np.random.default_rng(13)
SEQUENCES = [
    "".join(axes)
    for letters in ("xyz", "XYZ")
    for axes in product(letters, repeat=3)
    if axes[0] != axes[1] != axes[2]
]


def placed() -> mq.Mechanism:
    """A free body whose joint stands away from the world's origin, turned."""
    origin = mq.Placement((1.0, -2.0, 0.5), (0.3, -0.4, 1.1))
    bodies = mq.Body("ground"), mq.Body("box", mq.box(2.0, (0.1, 0.2, 0.3)))
    joint = mq.Floating("flight", "ground", "box", origin=origin)
    return mq.Mechanism("placed", bodies, (joint,))


def test_the_sequences_are_all_there_are() -> None:
    assert len(SEQUENCES) == 24
    assert "zxz" in SEQUENCES


@pytest.mark.parametrize("sequence", SEQUENCES)
def test_euler_angles_are_those_of_scipy(sequence: str) -> None:
    angles = RANDOM.uniform(-1.5, 1.5, 3)
    q, _ = mq.floating(BODY, euler=angles, sequence=sequence)
    turned = Rotation.from_euler(sequence, angles)
    pose = Reference.of(BODY).pose("cylinder", q)
    assert pose[:3, :3] == pytest.approx(turned.as_matrix(), abs=1e-14)
    state = mq.floating_state(BODY, q)
    back = Rotation.from_euler(sequence, state.euler(sequence))
    assert (back.inv() * turned).magnitude() < 1e-14


def test_xyz_are_roll_pitch_yaw_of_urdf() -> None:
    angles = (0.3, -0.7, 1.9)
    q, _ = mq.floating(BODY, euler=angles, sequence="xyz")
    numbers = np.array(mq.Placement(rpy=angles).rotation, dtype=float)
    assert Reference.of(BODY).pose("cylinder", q)[:3, :3] == pytest.approx(numbers, rel=1e-12)


def test_gimbal_lock_is_read_without_a_third_turn() -> None:
    q, _ = mq.floating(BODY, euler=(0.4, np.pi / 2, 0.3), sequence="ZYX")
    roll = mq.floating_state(BODY, q).euler("ZYX")
    again, _ = mq.floating(BODY, euler=roll, sequence="ZYX")
    assert roll[2] == 0
    assert list(again.values()) == pytest.approx(list(q.values()), abs=1e-7)


@pytest.mark.parametrize("order", ["xyzw", "wxyz"])
def test_quaternions_in_either_order_of_any_length(order: str) -> None:
    turned = Rotation.from_quat([0.1, -0.2, 0.3, 0.9])
    given = turned.as_quat(scalar_first=order == "wxyz")
    q, _ = mq.floating(BODY, quaternion=-3 * given, order=order)
    assert [abs(q[f"q{k}"]) for k in "xyzw"] == pytest.approx(np.abs(turned.as_quat()), rel=1e-12)
    assert mq.floating_state(BODY, q).quaternion(order) == pytest.approx(given, rel=1e-12)


@pytest.mark.parametrize("axes", ["world", "body"])
def test_velocities_in_the_axes_they_are_given_in(axes: str) -> None:
    mechanism, turned = placed(), Rotation.from_euler("zxz", (0.5, 1.0, -0.3))
    linear, angular = np.array([1.0, 2.0, 3.0]), np.array([-0.5, 0.7, 0.2])
    q, v = mq.floating(
        mechanism,
        position=(4.0, 5.0, 6.0),
        quaternion=turned.as_quat(),
        order="xyzw",
        linear=linear,
        angular=angular,
        axes=axes,
    )
    pose, twist = (
        Reference.of(mechanism).pose("box", q),
        Reference.of(mechanism).velocity("box", q, v),
    )
    assert pose[:3, 3] == pytest.approx([4, 5, 6], rel=1e-12)
    assert pose[:3, :3] == pytest.approx(turned.as_matrix(), rel=1e-12)
    turn = np.eye(3) if axes == "world" else turned.as_matrix()
    assert twist.linear == pytest.approx(turn @ linear, rel=1e-12)
    assert twist.angular == pytest.approx(turn @ angular, rel=1e-12)
    state = mq.floating_state(mechanism, q, v)
    assert state.position == pytest.approx([4, 5, 6], rel=1e-12)
    assert np.array(state.velocity(axes)) == pytest.approx(np.array([linear, angular]), rel=1e-12)
    assert np.array(state.velocity("world")) == pytest.approx(
        np.array([state.linear, state.angular]), rel=1e-12
    )


def test_many_states_at_once_are_those_one_by_one() -> None:
    mechanism, angles = placed(), RANDOM.uniform(-1, 1, (5, 3))
    rates = RANDOM.normal(size=(5, 3))
    call: dict[str, Any] = {"position": (1, 2, 3), "sequence": "ZXZ", "axes": "world"}
    q, v = mq.floating(mechanism, euler=angles, linear=rates, **call)
    poses = Reference.of(mechanism).pose("box", q)
    state = mq.floating_state(mechanism, q, v)
    for k in range(5):
        one, w = mq.floating(mechanism, euler=angles[k], linear=rates[k], **call)
        assert Reference.of(mechanism).pose("box", one) == pytest.approx(poses[k], rel=1e-12)
        assert mq.floating_state(mechanism, one, w).linear == pytest.approx(rates[k], rel=1e-12)
    assert state.euler("ZXZ").shape == (5, 3)
    assert state.linear == pytest.approx(rates, rel=1e-12)


def test_what_is_given_to_a_robot_is_what_its_motion_reads() -> None:
    """A body thrown without gravity keeps its velocity in world axes, not in its own."""
    mechanism = BODY.replace(gravity=(0, 0, 0))
    q, v = mq.floating(
        mechanism,
        position=(0, 0, 1),
        euler=(0.2, 0.1, 0.0),
        sequence="ZYX",
        linear=(1, 2, 3),
        angular=(0.3, 0.2, 2.0),
        axes="world",
    )
    motion = mq.simulate(mechanism, q=q, v=v, duration=1.0)
    assert motion.floating_state(0.0).euler("ZYX") == pytest.approx([0.2, 0.1, 0.0], rel=1e-12)
    assert motion.floating_state(0.0).angular == pytest.approx([0.3, 0.2, 2.0], rel=1e-12)
    center = motion.reference.center_of_mass(motion.q, motion.v).velocity
    assert center == pytest.approx(np.tile(center[0], (len(motion), 1)), rel=1e-8)
    end = motion.floating_state(1.0)
    assert end.position == pytest.approx(motion.pose("cylinder", 1.0)[:3, 3], rel=1e-12)
    assert motion.floating_state().position.shape == (len(motion), 3)


def test_a_root_read_from_urdf_is_found_by_itself() -> None:
    mechanism = mq.read_urdf(mq.write_urdf(mq.textbook.load("double_pendulum")), root="floating")
    q, v = mq.floating(mechanism, position=(0, 0, 2), angular=(0, 0, 1), axes="body")
    assert set(q) == {f"root_joint_{k}" for k in ("x", "y", "z", "qx", "qy", "qz", "qw")}
    assert v["root_joint_wz"] == 1.0
    assert mechanism.position(q)[2] == 2.0


def test_a_ball_can_only_turn() -> None:
    bodies = mq.Body("ground"), mq.Body("top", mq.rod(1.0, 1.0))
    mechanism = mq.Mechanism("ball", bodies, (mq.Spherical("socket", "ground", "top"),))
    q, v = mq.floating(mechanism, "socket", euler=(0.1, 0.2, 0.3), sequence="XYZ")
    assert len(q) == 4
    assert set(v.values()) == {0.0}
    state = mq.floating_state(mechanism, q, joint="socket")
    assert state.euler("XYZ") == pytest.approx([0.1, 0.2, 0.3], rel=1e-12)
    assert state.position == pytest.approx([0, 0, 0], rel=1e-12)
    with pytest.raises(mq.InputError, match="'socket' can only turn; expected no position"):
        mq.floating(mechanism, "socket", position=(0, 0, 1))
    with pytest.raises(mq.InputError, match="'ball' has no floating joint"):
        mq.floating(mechanism)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"quaternion": (0, 0, 0, 1)}, 'expected the order "xyzw" or "wxyz" .*, got None'),
        ({"quaternion": (0, 0, 0, 0), "order": "xyzw"}, "expected a unit quaternion"),
        (
            {"quaternion": (0, 0, 1), "order": "xyzw"},
            r"expected shape \(4,\) or \(n, 4\)",
        ),
        ({"euler": (0, 0, 1)}, "expected a sequence of Euler angles, .*, got None"),
        ({"euler": (0, 0, 1), "sequence": "xxz"}, "expected a sequence of Euler angles"),
        ({"euler": (0, 0, 1), "sequence": "xYz"}, "expected a sequence of Euler angles"),
        ({"euler": (0, 0, 1), "quaternion": (0, 0, 0, 1)}, "got both"),
        ({"linear": (0, 0, 1)}, 'expected the axes "world" or "body" of the velocities, got None'),
        ({"angular": (0, 0, 1), "axes": "local"}, "got 'local'"),
        ({"position": (0, 0, float("nan"))}, "expected finite position values, got"),
        ({"position": "here"}, "expected 3 numbers for the position values, got 'here'"),
        ({"joint": "fre"}, "fre"),
    ],
)
def test_no_convention_is_taken_for_granted(given: dict[str, Any], message: str) -> None:
    with pytest.raises(mq.MecaniqueError, match=message):
        mq.floating(BODY, **given)


def test_a_joint_that_is_not_free_in_the_world_is_refused() -> None:
    pendulum = mq.textbook.load("double_pendulum")
    with pytest.raises(mq.InputError, match="expected a floating or spherical joint"):
        mq.floating(pendulum, pendulum.joints[0].name)
    bodies = mq.Body("ground"), mq.Body("a", mq.ball(1.0, 0.1)), mq.Body("b", mq.ball(1.0, 0.1))
    joints = mq.Floating("one", "ground", "a"), mq.Floating("two", "a", "b")
    mechanism = mq.Mechanism("two", bodies, joints)
    with pytest.raises(mq.InputError, match="has 2 floating joints, one, two; name one"):
        mq.floating(mechanism)
    with pytest.raises(mq.InputError, match="'two' hangs on 'a', not on the ground"):
        mq.floating(mechanism, "two")
