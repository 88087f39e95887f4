"""A mechanism: what it knows about its coordinates, and its frozen copies."""

from __future__ import annotations

import math
import pickle
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import mecanique as mq
from mecanique import textbook
from mecanique.errors import InputError, MechanismError, UnknownNameError
from mecanique.model import (
    Belt,
    Body,
    Coordinates,
    Cord,
    Fixed,
    Floating,
    Input,
    Loop,
    Mechanism,
    Parameter,
    Placement,
    Planar,
    Prismatic,
    Pulley,
    Revolute,
    Rolling,
    Spherical,
    Universal,
    ball,
    coordinate,
    rod,
)
from mecanique.model.force_base import loads_in

ALL = Mechanism(
    "all",
    (Body("ground"), *(Body(name, ball(1.0, 0.1)) for name in "abcdefg")),
    (
        Universal("u", "c", "d", names=("u1", "u2")),
        Revolute("r", "ground", "a", coordinate="q"),
        Floating("f", "a", "b"),
        Spherical("s", "b", "c"),
        Planar("p", "d", "e", axis=(0, -1, 0)),
        Prismatic("z", "e", "f"),
        Fixed("w", "f", "g"),
    ),
)


def test_coordinates_come_in_the_order_of_the_joints() -> None:
    assert ALL.coordinates.names == (
        *("u1", "u2", "q"),
        *("f_x", "f_y", "f_z", "f_qx", "f_qy", "f_qz", "f_qw"),
        *("s_qx", "s_qy", "s_qz", "s_qw"),
        *("p_x", "p_y", "p_theta", "z"),
    )
    assert ALL.velocities == (
        *("u1'", "u2'", "q'"),
        *("f_vx", "f_vy", "f_vz", "f_wx", "f_wy", "f_wz"),
        *("s_wx", "s_wy", "s_wz"),
        *("p_x'", "p_y'", "p_theta'", "z'"),
    )
    assert (ALL.nq, ALL.nv) == (18, 16)
    assert list(ALL.coordinates[:2]) == ["u1", "u2"]


def test_velocities_come_in_the_order_of_the_coordinates() -> None:
    order = (*("z", "q"), *ALL.joint("s").coordinates, "u2", *ALL.joint("f").coordinates)
    sorted_otherwise = replace(ALL, coordinates=Coordinates((*order, "u1")))
    assert sorted_otherwise.velocities == (
        *("z'", "q'", *ALL.joint("s").velocities, "u2'", *ALL.joint("f").velocities),
        *("u1'", "p_x'", "p_y'", "p_theta'"),
    )


def test_the_tree_places_each_joint_after_the_one_that_carries_it() -> None:
    placed = {"ground"}
    for joint in ALL.tree:
        assert joint.parent in placed
        placed.add(joint.child)
    assert placed == {body.name for body in ALL.bodies}


def test_driven_coordinates_leave_q_and_map_names_join_it() -> None:
    mechanism = textbook.load("double_pendulum")
    assert mechanism.coordinates.names == ("q1", "q2")
    assert set(mechanism.coordinates.driven) == {"theta2"}
    assert mechanism.velocities == ("q1'", "q2'")


def test_positions_by_array_by_name_or_neutral() -> None:
    neutral = ALL.position(None)
    np.testing.assert_array_equal(neutral, ALL.neutral())
    assert dict(zip(ALL.coordinates, neutral, strict=True))["s_qw"] == 1
    assert neutral.sum() == 2
    given = ALL.position({"q": 0.5, "f_qx": 1.0, "f_qw": 1.0})
    assert given[2] == 0.5
    assert given[6] == given[9] == pytest.approx(math.sqrt(0.5), rel=1e-12)
    array = np.arange(18.0) + 1
    taken = ALL.position(array)
    np.testing.assert_allclose(
        taken[6:10], np.array([7, 8, 9, 10]) / math.sqrt(294), rtol=1e-15, atol=0
    )
    np.testing.assert_array_equal(array, np.arange(18.0) + 1)


def test_velocities_by_array_or_by_name_of_coordinate_or_velocity() -> None:
    np.testing.assert_array_equal(ALL.velocity(None), np.zeros(16))
    given = ALL.velocity({"q": 2.0, "u1'": 1.0, "f_wz": -3.0})
    assert (given[0], given[2], given[8]) == (1.0, 2.0, -3.0)
    np.testing.assert_array_equal(ALL.velocity(np.arange(16)), np.arange(16.0))


@pytest.mark.parametrize(
    ("given", "error", "message"),
    [
        ({"q1": 1.0}, UnknownNameError, "unknown coordinate 'q1'"),
        ({"q": math.nan}, InputError, "expected a finite number for coordinate q, got nan"),
        ({"q": "x"}, InputError, "expected a finite number for coordinate q, got 'x'"),
        (
            [0.0, 1.0],
            InputError,
            r"expected shape \(18,\) for the coordinate values \(u1, .*, got \(2,\)",
        ),
        (np.full(18, np.inf), InputError, "expected finite coordinate values"),
        (np.zeros(18), InputError, "expected a unit quaternion for joint 'f'"),
        (["x"] * 18, InputError, "expected 18 numbers for the coordinate values"),
    ],
)
def test_bad_positions_are_refused(given: Any, error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        ALL.position(given)


def test_bad_velocities_are_refused() -> None:
    with pytest.raises(UnknownNameError, match="unknown velocity 'f_x'"):
        ALL.velocity({"f_x": 1.0})
    with pytest.raises(InputError, match=r"expected shape \(16,\) for the velocity values"):
        ALL.velocity(np.zeros(18))


def test_a_replaced_copy_has_the_new_values_and_leaves_the_old() -> None:
    first = textbook.load("rigid_bar_pendulum")
    other = first.replace("long", l=3.0)
    assert (other.name, other.values["l"], first.values["l"]) == ("long", 3.0, 1.0)
    assert other.evaluate(other.body("rod").inertia[0]) == pytest.approx(9 / 12, rel=1e-12)
    assert first.replace() == first
    with pytest.raises(UnknownNameError, match="unknown parameter 'L'; known: m, l, g"):
        first.replace(L=1.0)
    with pytest.raises(InputError, match="expected a finite number for parameter l, got nan"):
        first.replace(l=math.nan)
    with pytest.raises(MechanismError, match="its mass is negative"):
        first.replace(m=-1.0)


def test_bodies_and_joints_by_name() -> None:
    assert ALL.body("a").name == "a"
    assert ALL.joint("w") == Fixed("w", "f", "g")
    with pytest.raises(UnknownNameError, match="unknown body 'h'"):
        ALL.body("h")
    with pytest.raises(UnknownNameError, match="unknown joint 'hinge'"):
        ALL.joint("hinge")


@pytest.mark.parametrize(
    "name", [name for name in textbook.names() if not textbook.load(name).inputs]
)
def test_pickling_keeps_a_mechanism(name: str) -> None:
    mechanism = textbook.load(name)
    assert mechanism.velocities
    assert mechanism.tree
    again = pickle.loads(pickle.dumps(mechanism))
    assert again == mechanism
    assert hash(again) == hash(mechanism)
    assert again.velocities == mechanism.velocities


def test_a_mechanism_with_inputs_is_pickled_too() -> None:
    mechanism = textbook.load("two_blocks")
    again = pickle.loads(pickle.dumps(mechanism))
    assert again == mechanism
    assert again.inputs[0].function(again.values)(0.0) == mechanism.values["F0"]
    assert Input("F", 2.0) == Input("F", 2)


def test_it_is_frozen_and_shows_itself() -> None:
    with pytest.raises(AttributeError):
        ALL.name = "other"  # type: ignore[misc]  # that is the point
    assert repr(textbook.load("double_pendulum")) == (
        "<Mechanism 'double_pendulum': 3 bodies, 2 joints, 0 forces, q = (q1, q2)>"
    )
    assert repr(Body("b", ball(1.0, 2.0))).startswith("Body('b', Shape(mass=1.0")


def test_axes_are_stored_with_unit_length() -> None:
    assert Revolute("r", "a", "b", axis=(0, -3, 0)).axis == (0, -1, 0)
    assert Prismatic("p", "a", "b", axis=(3, 0, 4)).axis == (0.6, 0, 0.8)
    with pytest.raises(InputError, match="expected three numbers for the axis of joint 'r'"):
        Revolute("r", "a", "b", axis=(Parameter("m", 1.0), 0, 0))  # type: ignore[arg-type]  # that is the point


@pytest.mark.parametrize(
    "axis", [(0, 0, 1), (0, -1, 0), (1, 0, 0), (0, 0, -1), (1, 2, 3), (-1, 1, -5), (0, 1e-9, -1)]
)
def test_the_axes_of_a_plane_come_from_the_smallest_turn(axis: tuple[float, float, float]) -> None:
    joint = Planar("p", "a", "b", axis=axis)
    x, y = (np.array(direction) for direction in joint.directions)
    normal = np.array(axis) / np.linalg.norm(axis)
    np.testing.assert_allclose(np.cross(x, y), normal, rtol=0, atol=1e-14)
    np.testing.assert_allclose([x @ x, y @ y, x @ y], [1, 1, 0], rtol=0, atol=1e-13)
    if normal[2] > -0.999:
        turn = Rotation.align_vectors([normal], [[0, 0, 1]])[0]
        np.testing.assert_allclose(turn.apply([1, 0, 0]), x, rtol=0, atol=1e-13)
    if axis == (0, -1, 0):
        np.testing.assert_allclose([x, y], [[1, 0, 0], [0, 0, 1]], rtol=0, atol=1e-15)


def test_placements_turn_as_urdf_says() -> None:
    rpy = (0.4, -1.1, 2.5)
    np.testing.assert_allclose(
        Placement(rpy=rpy).rotation, Rotation.from_euler("xyz", rpy).as_matrix(), rtol=0, atol=1e-14
    )
    quarter = Placement(rpy=(math.pi / 2, 0, 0)).rotation
    assert quarter == ((1, 0, 0), (0, 0, -1), (0, 1, 0))
    with pytest.raises(InputError, match="expected three components for position xyz"):
        Placement((1, 2))  # type: ignore[arg-type]  # that is the point


def test_joints_name_their_coordinates_or_refuse() -> None:
    assert Revolute("r", "a", "b").coordinates == ("r",)
    assert Planar("p", "a", "b", names=("x", "y", "t")).velocities == ("x'", "y'", "t'")
    with pytest.raises(
        InputError, match=r"joint 'p': expected 3 names \(x, y, theta\), got \('x',\)"
    ):
        Planar("p", "a", "b", names=("x",))


def test_the_map_of_coordinates_may_be_a_mapping_or_pairs() -> None:
    q = coordinate("q")
    assert Coordinates(("q",), {"r": 2 * q}) == Coordinates(("q",), (("r", 2 * q),))
    assert rod(1.0, 1.0) == rod(1, 1)


@pytest.mark.parametrize(
    ("given", "meant"),
    [
        ((1e-13, -1.0, 1e-12), (0.0, -1.0, 0.0)),
        ((0.9999999999999983, -2e-14, 2e-14), (1.0, 0.0, 0.0)),
        ((0.0, 1e-11, 1.0), (0.0, 1e-11, 1.0)),
        ((0.6, 1e-14, 0.8), (0.6, 1e-14, 0.8)),
    ],
)
def test_what_cad_programs_leave_beside_a_coordinate_axis_is_dropped(
    given: tuple[float, float, float], meant: tuple[float, float, float]
) -> None:
    for kind in (Revolute, Prismatic):
        assert kind("j", "ground", "a", axis=given).axis == meant


def test_what_is_not_said_is_what_the_conventions_say() -> None:
    """Down is -z, g is 9.81 m/s², a plane is that of x and z, and a wheel's axle lies along y."""
    wheel = Mechanism(
        "drop", (Body("ground"), Body("ball", ball(1.0, 0.1))), (Floating("f", "ground", "ball"),)
    )
    assert wheel.gravity == (0.0, 0.0, -9.81)
    across = (0.0, -1.0, 0.0)
    assert Cord("c", ("ball", (0, 0, 0)), (Pulley("ball", 0.1),)).normal == across
    assert Belt("b", (Pulley("ground", 0.1), Pulley("ball", 0.1))).normal == across
    for loop in (Loop.pin, Loop.plate):
        turned = loop("l", "ground", (0, 0, 0), "ball", (0, 0, 0)).frame_a
        np.testing.assert_allclose(wheel.matrix(turned)[:3, 2], across, rtol=0, atol=1e-15)
    roll = Rolling("r", "ball", 0.1)
    assert (roll.axis, wheel.matrix(roll.plane)[:3, 2].tolist()) == ((0.0, 1.0, 0.0), [0, 0, 1])


def test_forces_in_a_joint_are_those_of_that_joint_alone_and_of_a_kind() -> None:
    forces = (
        mq.JointSpring("coil", "pin", 7.0),
        mq.JointDamper("oil", "pin", 0.5),
        mq.JointSpring("other", "axle", 3.0),
        mq.Potential("both", ("axle", "pin"), mq.coordinate("q") * mq.coordinate("p")),
        mq.Force("weight", "body", (0, 0, 0), (0, 0, -1)),
    )
    assert [force.name for force in loads_in(forces, "pin")] == ["coil", "oil"]
    assert [force.name for force in loads_in(forces, "axle")] == ["other"]
    assert [force.name for force in loads_in(forces, "pin", "damper")] == ["oil"]
    assert loads_in(forces, "none") == ()
