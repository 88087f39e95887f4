from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import eigh

import mecanique as mq
from mecanique.motion import equilibria, frequency_response, linearize

G = 9.81


def test_two_blocks_are_the_closed_form() -> None:
    mechanism = mq.textbook.load("two_blocks", F0=0.0)
    p = mechanism.values
    small = linearize(mechanism)
    np.testing.assert_allclose(small.q, 0.0, rtol=0, atol=1e-14)
    np.testing.assert_allclose(small.M, np.diag([p["m1"], p["m2"]]), rtol=1e-14, atol=0)
    np.testing.assert_allclose(
        small.K, [[p["k1"] + p["k2"], -p["k2"]], [-p["k2"], p["k2"]]], rtol=1e-12, atol=0
    )
    np.testing.assert_allclose(small.C, 0.0, rtol=0, atol=1e-12)
    squares = eigh(small.K, small.M, eigvals_only=True)
    np.testing.assert_allclose(small.frequencies, np.sqrt(squares), rtol=1e-12, atol=0)
    np.testing.assert_allclose(small.frequencies, np.sqrt([10, 40]), rtol=1e-12, atol=0)
    np.testing.assert_allclose(small.modes, [[0.5, 1.0], [1.0, -1.0]], rtol=0, atol=1e-12)
    assert (small.damping == 0).all()
    assert small.stable
    assert small.at_equilibrium
    assert small.error < 1e-11


def test_the_rod_pendulum_swings_at_the_root_of_three_g_over_two_l() -> None:
    for length in (0.03, 1.0, 40.0):
        small = linearize(mq.textbook.load("rigid_bar_pendulum", l=length))
        assert small.frequencies[0] == pytest.approx(np.sqrt(1.5 * G / length), rel=1e-12)
    # small swings have that period
    motion = mq.simulate(
        mq.textbook.load("rigid_bar_pendulum"),
        q=[1e-4],
        duration=5.0,
        events=[mq.Event("down", "q", 1)],
        rtol=1e-13,
    )
    assert np.diff(motion.times("down"))[0] == pytest.approx(2 * np.pi / np.sqrt(1.5 * G), rel=1e-8)


def test_the_inverted_pendulum_is_unstable() -> None:
    small = linearize(mq.textbook.load("rigid_bar_pendulum"), at={"q": np.pi})
    assert not small.stable
    assert small.frequencies.tolist() == [0.0]
    np.testing.assert_allclose(
        sorted(small.eigenvalues.real), np.sqrt(1.5 * G) * np.array([-1, 1]), rtol=1e-12, atol=0
    )
    assert "unstable" in str(small)


def test_damping_ratios_are_those_of_one_degree_of_freedom() -> None:
    for ratio in (0.05, 0.7):
        c = 2 * ratio * np.sqrt(50.0 * 2.0)
        mechanism = mq.Mechanism(
            "oscillator",
            (mq.Body("ground"), mq.Body("block", mq.particle(2.0))),
            (mq.Prismatic("slide", "ground", "block", axis=(1, 0, 0), coordinate="x"),),
            forces=(mq.JointSpring("s", "slide", 50.0), mq.JointDamper("d", "slide", c)),
        )
        small = linearize(mechanism)
        assert small.frequencies[0] == pytest.approx(5.0, rel=1e-12)
        assert small.damping[0] == pytest.approx(ratio, rel=1e-11)
        np.testing.assert_allclose(small.C, [[c]], rtol=1e-12, atol=0)


def test_an_overdamped_motion_does_not_oscillate() -> None:
    mechanism = mq.textbook.load("cart_pole", c=0.0)
    small = linearize(mechanism)
    # the cart is free, and with it the pole swings at ω² = (M + m) g / (M l)
    np.testing.assert_allclose(small.frequencies, [0.0, np.sqrt(3 / 2 * G)], rtol=0, atol=1e-11)
    damped = linearize(mq.textbook.load("cart_pole", c=2.0))
    assert damped.frequencies[0] == 0.0
    assert np.isnan(damped.damping[0])
    assert 0 < damped.damping[1] < 1
    assert damped.stable


def test_the_linear_and_the_nonlinear_motion_agree_for_small_amplitudes() -> None:
    mechanism = mq.textbook.load("double_pendulum")
    small = linearize(mechanism)
    start = 1e-4 * small.modes[:, 0].real
    motion = mq.simulate(mechanism, q=start, duration=3.0, rtol=1e-12, atol=1e-16)
    linear = start * np.cos(small.frequencies[0] * motion.t)[:, None]
    np.testing.assert_allclose(motion.q, linear, rtol=0, atol=1e-10)


def test_about_a_motion_the_linearization_follows_a_neighbor() -> None:
    mechanism = mq.textbook.load("cart_pole")
    motion = mq.simulate(mechanism, q={"q": 1.0}, v={"x": 0.5}, duration=1.0)
    at = motion(0.6)
    small = linearize(mechanism, at)
    assert not small.at_equilibrium
    dq, dv = np.array([1e-6, 2e-6]), np.array([-1e-6, 1e-6])
    ahead = motion.reference.acceleration(at.q + dq, at.v + dv, at.t)
    back = motion.reference.acceleration(at.q - dq, at.v - dv, at.t)
    expected = -np.linalg.solve(small.M, small.C @ dv + small.K @ dq)
    np.testing.assert_allclose((ahead - back) / 2, expected, rtol=1e-6, atol=0)


def test_a_free_body_is_linearized_along_its_velocities() -> None:
    mechanism = mq.Mechanism(
        "hanging",
        (mq.Body("ground"), mq.Body("rod", mq.rod(2.0, 1.5), mq.ball(0.3, 0.2))),
        (mq.Spherical("ball", "ground", "rod"),),
    )
    small = linearize(mechanism)
    inertia = 2.0 * 1.5**2 / 3 + 0.4 * 0.3 * 0.2**2
    np.testing.assert_allclose(
        small.K, np.diag([2.0 * G * 0.75, 2.0 * G * 0.75, 0.0]), rtol=0, atol=1e-11
    )
    np.testing.assert_allclose(
        small.frequencies, np.sqrt([0, 1.5 * G / inertia, 1.5 * G / inertia]), rtol=0, atol=1e-11
    )
    spun = linearize(mechanism, v=[0, 0, 3.0])
    # about a spin n the gyroscopic part of C is skew
    np.testing.assert_allclose(spun.C + spun.C.T, 0.0, rtol=0, atol=1e-12)
    assert np.abs(spun.C).max() > 1


def test_equilibria_of_the_pendulums_are_all_found() -> None:
    found = equilibria(mq.textbook.load("double_pendulum"))
    positions = sorted((round(abs(e.q[0]), 9), round(abs(e.q[1]), 9), e.stable) for e in found)
    pi = round(np.pi, 9)
    assert positions == [(0, 0, True), (0, pi, False), (pi, 0, False), (pi, pi, False)]
    assert found[0].stable
    assert "stable equilibrium" in str(found[0])


def test_a_cart_that_rests_anywhere_is_one_equilibrium() -> None:
    found = equilibria(mq.textbook.load("cart_pole"), starts=20)
    assert [e.stable for e in found] == [True, False]


def test_equilibria_start_where_they_are_told() -> None:
    mechanism = mq.textbook.load("rigid_bar_pendulum")
    (top,) = equilibria(mechanism, starts=[{"q": 3.0}])
    assert abs(top.q[0]) == pytest.approx(np.pi, rel=1e-12)
    with pytest.raises(mq.InputError, match="at least 0 for the number of starts, got -1"):
        equilibria(mechanism, starts=-1)
    with pytest.raises(mq.UnknownNameError, match="unknown coordinate 'p'"):
        equilibria(mechanism, starts=[{"p": 3.0}])


def test_where_nothing_can_rest_it_is_said() -> None:
    falling = mq.Mechanism(
        "stone",
        (mq.Body("ground"), mq.Body("stone", mq.particle(1.0))),
        (mq.Prismatic("fall", "ground", "stone", coordinate="z"),),
    )
    assert equilibria(falling, starts=3) == ()
    with pytest.raises(
        mq.InputError, match="no equilibrium of 'stone' was found from the neutral position"
    ):
        linearize(falling)


def test_the_frequency_response_is_the_dynamic_stiffness_inverted() -> None:
    mechanism = mq.textbook.load("two_blocks")
    small = linearize(mechanism, at=[0, 0])
    W = mechanism.values["W"]
    X = frequency_response(small, {"q2": mechanism.values["F0"]}, W)
    # the steady part of the motion under F0 cos W t
    np.testing.assert_allclose(X.imag, 0.0, rtol=0, atol=1e-12)
    motion = mq.simulate(mechanism, q=X.real, duration=5.0)
    np.testing.assert_allclose(motion.q, np.cos(W * motion.t)[:, None] * X.real, rtol=0, atol=1e-8)
    many = frequency_response(small, [0.0, 1.0], np.array([0.0, 1.0, 2.0]))
    np.testing.assert_allclose(many[0], np.linalg.solve(small.K, [0, 1]), rtol=1e-12, atol=0)
    with pytest.raises(mq.InputError, match=r"grows without bound at 3\.1622776"):
        frequency_response(small, {"q2": 1.0}, float(small.frequencies[0]))
    with pytest.raises(mq.InputError, match="expected finite frequencies"):
        frequency_response(small, {"q2": 1.0}, float("nan"))
    with pytest.raises(mq.UnknownNameError, match="unknown velocity 'q3'"):
        frequency_response(small, {"q3": 1.0}, 1.0)


def test_a_table_of_modes_has_no_nan_and_no_minus_zero() -> None:
    """One mode of the cart does not oscillate, so that it has no damping ratio."""
    table = mq.linearize(mq.textbook.load("cart_pole"), {"x": 0.0, "q": np.pi})._repr_html_()
    assert "nan" not in table
    assert "none" in table
    assert "-0.0000" not in table


def test_numbers_of_random_positions_are_bounded() -> None:
    linkage = mq.textbook.load("four_bar_linkage")
    with pytest.raises(mq.InputError, match="expected at most 1000000 for tries, got more"):
        mq.assembly_branches(linkage, {"phi": 1.0}, tries=10**400)
    with pytest.raises(mq.InputError, match="expected at most 1000000 for the number of starts"):
        mq.equilibria(linkage, 10**400)
