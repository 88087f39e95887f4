"""Lengths and units that a description has by itself, and positions drawn within its limits."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import mecanique as mq
from mecanique.model.mechanism.description import angles
from mecanique.model.mechanism_units import (
    add_unit,
    characteristic_length,
    coordinate_scales,
    per_second,
    velocity_scales,
)
from mecanique.model.random_positions import draw_positions
from mecanique.model.states import States, list_left_out

PLACE = mq.Placement
PENDULUM = mq.textbook.load("double_pendulum")


@pytest.mark.parametrize(
    ("unit", "rate"),
    [
        ("", ""),
        *(("1", "1/s"), ("m", "m/s"), ("rad", "rad/s")),
        *(("m/s", "m/s²"), ("rad/s", "rad/s²"), ("1/s", "1/s²")),
    ],
)
def test_units_of_rates(unit: str, rate: str) -> None:
    assert per_second(unit) == rate
    assert add_unit("x", rate) == (f"x [{rate}]" if rate else "x")


def machine(**parts: Any) -> mq.Mechanism:
    """Two hinges 0.8 m apart on a slide, and a body whose center is 0.3 m from its frame."""
    bodies = (
        mq.Body("ground"),
        mq.Body("sled", mq.box(1.0, (1, 1, 1))),
        mq.Body("upper", mq.particle(1.0, (0, 0, -0.3))),
        mq.Body("lower", mq.particle(1.0, (0, 0.03, 0.04))),
    )
    joints = (
        mq.Prismatic("slide", "ground", "sled", axis=(1, 0, 0)),
        mq.Revolute("first", "sled", "upper", origin=PLACE((0.48, 0, -0.64))),
        mq.Revolute("second", "upper", "lower", origin=PLACE((5e-7, 0, 0))),
    )
    return mq.Mechanism("machine", bodies, joints, **parts)


def test_the_characteristic_length_is_the_median_of_what_is_stated() -> None:
    # the hinge, and the centers of mass 0.3 and 0.05 m off; what is as short as 1e-6 m is none
    assert characteristic_length(machine()) == 0.3
    spring = mq.Spring("s", "ground", (0, 0, 2.0), "lower", (0, 0, 0), 10.0, 0.6)
    # 0.05, 0.3, 0.6, 0.8, 2
    assert characteristic_length(machine(forces=(spring,))) == 0.6
    # what joints and loops state, of closed mechanisms: 0.8, 1.5 and the length 0.2
    rod = mq.Loop.distance("rod", "ground", (1.5, 0, 0), "lower", (0, 0, 0), 0.2)
    closed = machine(loops=(rod,), forces=(spring,))
    assert characteristic_length(closed) == 0.8
    assert characteristic_length(closed, {"rod"}) == pytest.approx((1.5 + 0.2) / 2, rel=1e-15)
    assert characteristic_length(closed, {"first"}) == 0.8
    coin = mq.textbook.load("rolling_coin")
    assert characteristic_length(coin, {coin.contacts[0].name}) == coin.evaluate(
        coin.contacts[0].radius
    )
    point = mq.Mechanism(
        "m",
        (mq.Body("ground"), mq.Body("p", mq.particle(1.0))),
        (mq.Prismatic("x", "ground", "p"),),
    )
    assert characteristic_length(point) == 1.0


def test_velocities_and_coordinates_are_measured_in_lengths_and_radians() -> None:
    sled = machine()
    np.testing.assert_array_equal(velocity_scales(sled), [0.3, 1, 1])
    given = np.array([2.0, 3.0, 4.0])
    np.testing.assert_array_equal(velocity_scales(sled, given), [2, 1, 1])
    np.testing.assert_array_equal(coordinate_scales(sled, given, 0.5), given)
    body = mq.textbook.load("free_rigid_body")
    six = velocity_scales(body)
    np.testing.assert_array_equal(six[3:], 1.0)
    # coordinates of a quaternion are no integrals of velocities: the lesser of both units
    np.testing.assert_array_equal(coordinate_scales(body, six, 0.5), np.full(7, 0.5))
    np.testing.assert_array_equal(coordinate_scales(body, six, 2.0), np.full(7, 1.0))


@pytest.mark.parametrize(
    ("limits", "low", "high"),
    [
        # on both sides: a twentieth of the interval off them
        ((-10.0, 30.0), -8.0, 28.0),
        ((0.5, 1.5), 0.55, 1.45),
        # on one side: as far as without limits
        ((-0.5, np.inf), -0.5, 2.0),
        ((-np.inf, 0.25), -2.0, 0.25),
        # or, where that is beyond, as far again as the neutral position is
        ((3.0, np.inf), 3.0, 5.0),
        ((-np.inf, -4.0), -6.0, -4.0),
        ((2.0, np.inf), 2.0, 4.0),
    ],
)
def test_positions_fill_their_limits(limits: tuple[float, float], low: float, high: float) -> None:
    sled = machine(coordinates=mq.Coordinates((), (), {"slide": limits}))
    q = draw_positions(sled, 4000, np.random.default_rng(0), 2.0)
    assert q.shape == (4000, 3)
    slack = 3e-3 * (high - low)
    for column, (least, most) in zip(q.T, ((low, high), *[(-np.pi, np.pi)] * 2), strict=True):
        assert least <= column.min() < least + slack * (most - least) / (high - low)
        assert most >= column.max() > most - slack * (most - least) / (high - low)


def test_random_quaternions_turn_every_way() -> None:
    body = mq.textbook.load("free_rigid_body")
    q = draw_positions(body, 4000, np.random.default_rng(1), 2.0)[:, 3:]
    np.testing.assert_allclose(np.linalg.norm(q, axis=1), 1, rtol=1e-14, atol=0)
    np.testing.assert_allclose(q.T @ q / len(q), np.eye(4) / 4, rtol=0, atol=0.02)


@pytest.mark.parametrize(
    ("laws", "turning"),
    [
        ({"first": mq.coordinate("u")}, {"u", "u'"}),
        # a slide that a crank moves
        ({"slide": 0.3 * mq.cos(mq.coordinate("u"))}, {"u", "u'"}),
        ({"slide": 0.3 * mq.coordinate("u") + 1}, set()),
        # the length of which an angle is taken
        ({"first": mq.asin(mq.coordinate("u") / 2)}, set()),
        ({"first": 2 * mq.atan2(mq.coordinate("u"), 1.5)}, set()),
        # both, which remains a length
        ({"slide": mq.coordinate("u"), "first": mq.coordinate("u")}, {"u", "u'"}),
    ],
)
def test_angles_are_what_turns_a_joint_or_stands_in_a_sine(
    laws: dict[str, Any], turning: set[str]
) -> None:
    free = {"first", "second"} - laws.keys()
    expected = turning | free | {f"{name}'" for name in free}
    mechanism = machine(coordinates=mq.Coordinates(("u",), laws))
    assert angles(mechanism) == expected
    body = mq.textbook.load("free_rigid_body")
    assert angles(body) == {f"{name}" for name in body.velocities[3:]}


@pytest.mark.parametrize(
    ("q", "v", "rank", "said"),
    [
        (None, None, None, ""),
        ({}, {}, None, ""),
        ([0.0, 0.0], {"q1": 1.0}, None, "; q2' = 4 was not given"),
        ({"q1": 0.1}, None, None, "; q2 = 2 was not given"),
        ({"q1": 0.1}, {"q2'": 0.1}, None, "; q2 = 2, q1' = 3 were not given"),
        # the angle that follows stands for both that it follows
        ({"theta2": 0.1}, {"theta2": 0.1}, None, ""),
        # with constraints, as many positions as degrees of freedom are enough
        ({"q1": 0.1}, {"q1": 1.0}, 1, ""),
        ({"q1": 0.1}, {"q1": 1.0}, 0, "; q2 = 2 was not given"),
    ],
)
def test_what_a_start_leaves_out_is_listed(q: Any, v: Any, rank: int | None, said: str) -> None:
    assert list_left_out(PENDULUM, q, v, np.array([1.0, 2.0, 3.0, 4.0]), rank) == said


def test_of_many_only_eight_are_listed() -> None:
    chain = mq.Mechanism(
        "chain",
        (mq.Body("ground"), *(mq.Body(f"b{k}", mq.ball(1.0, 0.1)) for k in range(10))),
        tuple(
            mq.Revolute(f"j{k}", "ground" if k == 0 else f"b{k - 1}", f"b{k}") for k in range(10)
        ),
    )
    start = np.zeros(20)
    eight, nine = ({f"j{k}": 0.0 for k in range(10 - count)} for count in (8, 9))
    assert list_left_out(chain, eight, None, start).endswith("j9 = 0 were not given")
    assert list_left_out(chain, nine, None, start).endswith("j8 = 0, … were not given")


def test_torques_are_given_by_joint_coordinate_or_velocity() -> None:
    for tau in ({"pin1": 2.0}, {"q1": 2.0}, {"q1'": 2.0}):
        efforts = States.of(PENDULUM, None, tau=tau).efforts
        assert efforts is not None
        np.testing.assert_array_equal(efforts.in_joints["q1'"], [2.0])
        assert efforts.generalized is None
        efforts.refuse_without_seat()
    # q2 is no joint's own
    efforts = States.of(PENDULUM, None, tau=[0.0, 3.0]).efforts
    assert efforts is not None
    assert efforts.in_joints == {}
    np.testing.assert_array_equal(efforts.generalized, [[0.0, 3.0]])
    with pytest.raises(mq.InputError, match="reactions depend on what makes the forces on q2'"):
        efforts.refuse_without_seat()
    for wrong, message in (
        ({"pin": 1.0}, "unknown joint or velocity for tau 'pin'"),
        ({"pin1": 1.0, "q1": 2.0}, "tau on q1' is given twice, as 'pin1' and 'q1'"),
    ):
        with pytest.raises(mq.InputError, match=message):
            States.of(PENDULUM, None, tau=wrong)
    body = mq.textbook.load("free_rigid_body")
    with pytest.raises(
        mq.InputError, match=r"joint 'free' has 6 velocities; name what tau works on"
    ):
        States.of(body, None, tau={"free": 1.0})
    swapped = mq.Mechanism(
        "swapped",
        (mq.Body("ground"), mq.Body("a", mq.ball(1.0, 0.1)), mq.Body("b", mq.ball(1.0, 0.1))),
        (
            mq.Revolute("x", "ground", "a", coordinate="y"),
            mq.Revolute("z", "a", "b", coordinate="x"),
        ),
    )
    with pytest.raises(
        mq.InputError, match="'x' may mean a joint or another's coordinate: name x' or y'"
    ):
        States.of(swapped, None, tau={"x": 1.0})


def test_states_are_one_or_as_many_in_every_part() -> None:
    single = States.of(PENDULUM, [0.1, 0.2], [0.3, 0.4], 0.5)
    assert (len(single), single.single) == (1, True)
    np.testing.assert_array_equal(single.unbatch(np.array([[7.0]])), [7.0])
    two: Any = {"q1": [1.0, 2.0]}
    driven: Any = {"q1": [5.0, 6.0]}
    many = States.of(PENDULUM, two, [0.3, 0.4], 0.5, tau=driven)
    assert (len(many), many.single) == (2, False)
    np.testing.assert_array_equal(many.v, [[0.3, 0.4], [0.3, 0.4]])
    np.testing.assert_array_equal(many.t, [0.5, 0.5])
    last = many.at(np.array([1]))
    assert (last.q[0, 0], last.values["q1"].tolist()) == (2.0, [2.0])
    assert last.efforts is not None
    np.testing.assert_array_equal(last.efforts.in_joints["q1'"], [6.0])
    with pytest.raises(
        mq.InputError, match=r"one number of states in q, v, a and t, got q: 2, t: 3"
    ):
        States.of(PENDULUM, two, t=np.zeros(3))
    (force,) = mq.textbook.load("cart_pole").inputs
    pole = replace(
        mq.textbook.load("cart_pole"), inputs=(mq.Input(force.symbol, lambda t: 1 / (t - 1), "N"),)
    )
    np.testing.assert_array_equal(
        States.of(pole, None, t=np.array([0.0, 3.0])).values["F"], [-1, 0.5]
    )
    broken = replace(pole, inputs=(mq.Input(force.symbol, lambda t: np.inf * t, "N"),))
    with pytest.raises(mq.InputError, match=r"input 'F' is not finite at t = 2 s"):
        _ = States.of(broken, None, t=np.array([2.0, 3.0])).values
