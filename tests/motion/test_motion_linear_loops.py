"""Small motions of mechanisms with loops, in the deviations that the loops leave free."""

from __future__ import annotations

import numpy as np
import pytest

import mecanique as mq
from mecanique.motion import equilibria, linearize
from mecanique.reference.loops.assembly import close_velocity


def test_the_closed_bars_and_springs_have_the_equation_of_example_1_2() -> None:
    mechanism = mq.textbook.load("bars_and_springs_loop")
    small = linearize(mechanism)
    p = mechanism.values
    # (17/4) m q'' + 9 k q = 0 for the displacement q, here over the angle: both sides by the same
    # length squared
    assert small.K[0, 0] / small.M[0, 0] == pytest.approx(9 * p["k"] / (17 / 4 * p["m"]), rel=1e-11)
    assert small.tangent.shape == (3, 1)
    assert small.at_equilibrium
    np.testing.assert_allclose(small.modes[:, 0], [1, 1, -1], rtol=1e-9, atol=0)
    # M and K are those of the tree along the direction that the loop leaves free
    tree = mq.Reference(mechanism).mass_matrix(small.q)
    np.testing.assert_allclose(small.M, small.tangent.T @ tree @ small.tangent, rtol=1e-12, atol=0)


def test_the_small_motion_is_the_exact_one_of_a_small_amplitude() -> None:
    mechanism = mq.textbook.load("bars_and_springs_loop")
    small = linearize(mechanism)
    start = mq.assemble(mechanism, {"alpha": 1e-4}, keep=["alpha"])
    motion = mq.simulate(mechanism, q=start, duration=1.0, rtol=1e-11)
    expected = 1e-4 * np.cos(small.frequencies[0] * motion.t)
    np.testing.assert_allclose(motion["alpha"], expected, rtol=0, atol=1e-10)


def four_bar() -> mq.Mechanism:
    """Two cranks and a coupler, all of length 1, on pivots 1 m apart: a swinging bar."""
    return mq.Mechanism(
        "swing",
        (
            mq.Body("ground"),
            mq.Body("left"),
            mq.Body("right"),
            mq.Body("seat", mq.rod(3.0, 1.0, (1, 0, 0))),
        ),
        (
            mq.Revolute("a", "ground", "left", axis=(0, -1, 0)),
            mq.Revolute("b", "ground", "right", origin=mq.Placement((1, 0, 0)), axis=(0, -1, 0)),
            mq.Revolute("c", "left", "seat", origin=mq.Placement((0, 0, -1)), axis=(0, -1, 0)),
        ),
        loops=(mq.Loop.pin("d", "right", (0, 0, -1), "seat", (1, 0, 0), (0, 1, 0)),),
    )


def test_a_swing_on_parallel_ropes_is_a_simple_pendulum() -> None:
    small = linearize(four_bar(), near={"a": 0.4, "b": 0.4, "c": -0.4})
    np.testing.assert_allclose(small.q, 0.0, rtol=0, atol=1e-12)
    assert small.frequencies[0] == pytest.approx(np.sqrt(9.81), rel=1e-8)
    assert small.stable
    with pytest.raises(
        mq.DerivationError, match="has loops, and M, C and K with loops have no closed form here"
    ):
        small.text()


def test_both_equilibria_of_the_swing_are_found() -> None:
    starts = [{"a": x, "b": x, "c": -x} for x in (0.3, 2.8)]
    found = equilibria(four_bar(), starts=starts)
    assert [round(abs(float(e.q[0])), 6) for e in found] == [0.0, round(np.pi, 6)]
    assert [e.stable for e in found] == [True, False]


def test_a_swing_in_motion_is_linearized_as_its_pendulum() -> None:
    small = linearize(four_bar(), at={"a": 0.4, "b": 0.4, "c": -0.4}, v={"a": 1.2})
    assert not small.at_equilibrium
    np.testing.assert_allclose(small.v, [1.2, 1.2, -1.2], rtol=0, atol=1e-12)
    assert small.K[0, 0] / small.M[0, 0] == pytest.approx(9.81 * np.cos(0.4), rel=1e-9)
    assert small.C[0, 0] == pytest.approx(0.0, abs=1e-9)


def test_a_linkage_in_motion_deviates_as_neighboring_motions_do() -> None:
    """M δa + C δv + K δq = 0, by differences of accelerations on the loops near the state."""
    mechanism = mq.textbook.load("four_bar_linkage")
    reference = mq.Reference(mechanism)
    assert reference.closed is not None
    start = mq.assemble(mechanism, {"phi": 1.1})
    small = linearize(mechanism, at=start, v={"phi": 2.0})
    independent = int(np.flatnonzero(small.tangent[:, 0] == 1.0)[0])
    name = mechanism.coordinates.names[independent]

    def acceleration(by: float, faster: float) -> float:
        q = mq.assemble(
            mechanism,
            dict(zip(mechanism.coordinates, start, strict=True)) | {name: start[independent] + by},
            keep=[name],
        )
        held = np.arange(mechanism.nv) == independent
        v = close_velocity(reference.closed, q, np.where(held, small.v + faster, 0.0), 0.0, held)  # type: ignore[arg-type]  # has loops
        return float(reference.acceleration(q, v)[independent])

    h = 1e-4
    stiff = -(acceleration(h, 0.0) - acceleration(-h, 0.0)) / (2 * h)
    damped = -(acceleration(0.0, h) - acceleration(0.0, -h)) / (2 * h)
    assert small.K[0, 0] / small.M[0, 0] == pytest.approx(stiff, rel=1e-6)
    assert small.C[0, 0] / small.M[0, 0] == pytest.approx(damped, rel=1e-6)


def test_a_mode_in_motion_keeps_its_loops_closed() -> None:
    mechanism = mq.textbook.load("bars_and_springs_loop")
    small = linearize(mechanism)
    motion = small.motion(amplitude=0.3, periods=1.0)
    closed = motion.reference.closed
    assert closed is not None
    closures = closed.closures
    gaps = [np.abs(closures.residual(q, 0.0)).max() for q in motion.q]
    assert max(gaps) < 1e-9
    # to the first order it is the mode's shape times a cosine
    np.testing.assert_allclose(
        motion["alpha"], 0.3 * np.cos(small.frequencies[0] * motion.t), rtol=0, atol=1e-9
    )
    np.testing.assert_allclose(motion(0.1).q, _near(motion, 0.1), rtol=0, atol=1e-7)


def _near(motion: mq.Motion, t: float) -> np.ndarray:
    return np.array([np.interp(t, motion.t, column) for column in motion.q.T])


def test_a_stiff_light_mechanism_rests_where_newton_leaves_it() -> None:
    # exponents of 480 1/s turn an error of 1e-13 rad into 2e-8 rad/s²
    small = linearize(mq.textbook.load("squeezer"))
    assert 1e-8 < np.abs(small.acceleration).max() < 1e-6
    assert small.at_equilibrium
    assert "unstable equilibrium" in str(small)
