"""Modes in motion, compared with exact motion and driven harmonically, against closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import ellipk

import mecanique as mq
from mecanique.motion import linearize


def stretched(amplitude: float) -> float:
    """Period of a pendulum's swing, in periods of small swings."""
    return float(2 / np.pi * ellipk(np.sin(amplitude / 2) ** 2))


def test_the_pendulum_s_period_and_limit_are_those_of_the_elliptic_integral() -> None:
    small = linearize(mq.textbook.load("rigid_bar_pendulum"))
    side = small.compare(1.0)
    assert side.measure == "period"
    assert side.exact_period == pytest.approx(side.linear_period * stretched(1.0), rel=1e-9)
    assert side.difference == pytest.approx(stretched(1.0) - 1, rel=1e-7)
    for tolerance in (0.01, 0.1):
        expected = brentq(lambda a, tolerance=tolerance: stretched(a) - 1 - tolerance, 0.1, 2.0)
        assert small.compare(1.0, tolerance=tolerance).limit == pytest.approx(expected, rel=1e-6)
    assert "it differs by 0.01 from the amplitude 0.398177 rad on" in str(side)


def test_both_motions_are_there_side_by_side() -> None:
    small = linearize(mq.textbook.load("rigid_bar_pendulum"))
    side = small.compare()
    assert side.amplitude == side.limit
    assert side.difference == pytest.approx(0.01, rel=1e-6)
    np.testing.assert_allclose(
        side.linear[:, 0], side.limit * np.cos(small.frequencies[0] * side.t), rtol=0, atol=1e-12
    )
    assert side.exact.shape == side.linear.shape
    assert side.t[-1] == pytest.approx(2 * side.linear_period, rel=1e-12)
    assert np.abs(side.exact - side.linear).max() > 0.01 * side.limit


def test_a_pendulum_over_the_top_does_not_come_back() -> None:
    hanging = linearize(mq.textbook.load("rigid_bar_pendulum"))
    side = hanging.compare(np.pi - 1e-12)
    assert side.exact_period is None or side.exact_period > 5 * side.linear_period
    assert side.difference > 4


def test_linear_equations_never_differ() -> None:
    side = linearize(mq.textbook.load("rotating_plate")).compare()
    assert side.limit == np.inf
    assert side.difference < 1e-9
    assert "the same at any amplitude tried" in str(side)


def test_two_blocks_differ_where_the_spring_is_turned_inside_out() -> None:
    mechanism = mq.textbook.load("two_blocks", a=1.0)
    side = linearize(mechanism).compare()
    # in the first mode q1 = q2/2, and block 1 reaches the wall at q1 = −a
    assert side.limit == pytest.approx(2.0, rel=1e-3)
    assert side.difference < 1e-9


def test_several_degrees_of_freedom_are_compared_by_their_motion() -> None:
    small = linearize(mq.textbook.load("double_pendulum"))
    side = small.compare(mode=1, tolerance=0.02)
    assert side.measure == "motion"
    assert side.exact_period is None
    assert side.difference == pytest.approx(0.02, rel=1e-6)
    # the error grows with the square of the amplitude
    assert small.compare(side.limit / 10, mode=1).difference == pytest.approx(0.0002, rel=0.05)


def test_what_cannot_be_compared_is_refused() -> None:
    small = linearize(mq.textbook.load("rigid_bar_pendulum"))
    with pytest.raises(mq.InputError, match="expected a positive amplitude, got -1"):
        small.compare(-1.0)
    with pytest.raises(mq.InputError, match=r"expected a tolerance in 0…1, got 2"):
        small.compare(tolerance=2.0)
    with pytest.raises(mq.InputError, match=r"expected a mode in 0…0, 0 for the slowest, got 1"):
        small.compare(mode=1)
    with pytest.raises(mq.InputError, match="no mode of 'rigid_bar_pendulum' oscillates there"):
        linearize(mq.textbook.load("rigid_bar_pendulum"), at={"q": np.pi}).motion()
    with pytest.raises(mq.InputError, match="mode 0 of 'cart_pole' does not oscillate"):
        linearize(mq.textbook.load("cart_pole")).motion(0)
    with pytest.raises(mq.InputError, match="expected a linearization about an equilibrium"):
        linearize(mq.textbook.load("rigid_bar_pendulum"), at={"q": 0.5}).compare()
    with pytest.raises(mq.InputError, match="expected either at or near, got both"):
        linearize(mq.textbook.load("rigid_bar_pendulum"), {"q": 0.0}, near={"q": 0.0})


def test_a_mode_in_motion_is_its_shape_times_a_cosine() -> None:
    small = linearize(mq.textbook.load("two_blocks"))
    motion = small.motion(1, 0.25, periods=2.0)
    assert isinstance(motion, mq.Motion)
    assert "mode 2 of the linear equations, 1.00658 Hz, amplitude 0.25" in motion.method
    period = 2 * np.pi / np.sqrt(40)
    assert motion.t[-1] == pytest.approx(2 * period, rel=1e-12)
    np.testing.assert_allclose(
        motion["q1"], 0.25 * np.cos(np.sqrt(40) * motion.t), rtol=0, atol=1e-12
    )
    np.testing.assert_allclose(motion["q2"], -motion["q1"], rtol=0, atol=1e-12)
    t = np.linspace(0, motion.t[-1], 57)
    np.testing.assert_allclose(
        motion(t).q[:, 0], 0.25 * np.cos(np.sqrt(40) * t), rtol=0, atol=1e-12
    )
    assert motion.poses().shape == (len(motion.t), len(small.mechanism.bodies), 4, 4)


def test_a_mode_of_a_ball_joint_turns_it() -> None:
    mechanism = mq.Mechanism(
        "hanging",
        (mq.Body("ground"), mq.Body("rod", mq.rod(2.0, 1.5), mq.ball(0.3, 0.2))),
        (mq.Spherical("ball", "ground", "rod"),),
    )
    motion = linearize(mechanism).motion()
    np.testing.assert_allclose(np.linalg.norm(motion.q, axis=1), 1.0, rtol=0, atol=1e-12)
    assert 2 * np.arccos(motion.q[0, 3]) == pytest.approx(0.2, rel=0.5)


def test_a_damped_mode_decays() -> None:
    small = linearize(mq.textbook.load("cart_pole", c=2.0))
    motion = small.motion(1, 0.3, periods=2.0)
    decay = np.exp(-small.damping[1] * small.frequencies[1] * motion.t[-1])
    assert motion["q"][0] == pytest.approx(0.3, rel=1e-12)
    assert motion["q"][-1] == pytest.approx(0.3 * decay, rel=1e-9)


def test_the_response_of_an_oscillator_is_the_closed_form() -> None:
    m, c, k = 2.0, 3.0, 50.0
    mechanism = mq.Mechanism(
        "oscillator",
        (mq.Body("ground"), mq.Body("block", mq.particle(m))),
        (mq.Prismatic("slide", "ground", "block", axis=(1, 0, 0), coordinate="x"),),
        forces=(mq.JointSpring("s", "slide", k), mq.JointDamper("d", "slide", c)),
    )
    response = linearize(mechanism).response({"x": 7.0})
    w = response.frequencies
    assert w.shape == (400,)
    assert w[-1] == pytest.approx(10.0, rel=1e-3)
    np.testing.assert_allclose(
        response.amplitude[:, 0], 7 / np.hypot(k - m * w**2, c * w), rtol=1e-9, atol=0
    )
    np.testing.assert_allclose(
        response.phase[:, 0], np.arctan2(c * w, k - m * w**2), rtol=1e-9, atol=0
    )
    np.testing.assert_array_equal(response["x"], response.X[:, 0])
    assert response.units == ("m",)
    with pytest.raises(mq.UnknownNameError, match="unknown coordinate 'y'"):
        response["y"]
    figure = response.plot()
    assert [axis.get_ylabel() for axis in figure.axes] == ["amplitude", "phase lag [rad]"]
