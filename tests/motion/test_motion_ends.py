"""A motion that comes to the end of its chart stops there and says so."""

from __future__ import annotations

import numpy as np
import pytest

import mecanique as mq


@pytest.mark.parametrize("method", ["auto", "lsoda"])
def test_a_particle_on_a_circle_stops_at_the_end_of_its_chart(method: str) -> None:
    mechanism = mq.textbook.load("particle_on_circle_x")
    with pytest.raises(
        mq.IntegrationError, match=r"x must stay within \(-R, R\) = \(-1, 1\), but comes to -0.998"
    ) as e:
        mq.simulate(mechanism, q=[0.8], v=[-0.6], duration=5.0, method=method, rtol=1e-9)
    assert "use another coordinate, e.g. theta" in str(e.value)
    # theta = acos(0.8) + t until cos(theta) = −0.998
    assert e.value.time == pytest.approx(np.arccos(-0.998) - np.arccos(0.8), rel=1e-7)
    motion = e.value.motion
    assert motion.t[-1] == e.value.time
    np.testing.assert_allclose(motion["x"], np.cos(np.arccos(0.8) + motion.t), rtol=0, atol=1e-7)
    np.testing.assert_allclose(
        e.value.state, [motion["x"][-1], motion["x'"][-1]], rtol=0, atol=1e-12
    )


def test_a_weight_that_comes_to_its_pulley_ends_the_motion() -> None:
    mechanism = mq.textbook.load("atwood_machine")
    with pytest.raises(
        mq.IntegrationError, match=r"x must stay within \(-h, h\) .+ the description of"
    ) as e:
        mq.simulate(mechanism, q={"x": -0.6}, duration=5.0)
    assert "another coordinate" not in str(e.value)  # x2 = −x ends there, too
    s = mechanism.values
    a = (s["m1"] - s["m2"]) * s["g"] / (s["m1"] + s["m2"] + s["M"] / 2)
    assert e.value.time == pytest.approx(np.sqrt(2 * (0.6 + 0.998) / a), rel=1e-9)


def test_a_motion_that_starts_near_the_limit_may_leave_it() -> None:
    mechanism = mq.textbook.load("particle_on_circle_x")
    angle = 0.01
    motion = mq.simulate(mechanism, q=[np.cos(angle)], v=[-np.sin(angle)], duration=1.0, rtol=1e-9)
    assert motion["x"][-1] == pytest.approx(np.cos(1 + angle), abs=1e-6)
    assert motion.events == ()


def test_other_events_are_still_found() -> None:
    mechanism = mq.textbook.load("particle_on_circle_x")
    middle = mq.Event("middle", "x", -1)
    motion = mq.simulate(mechanism, q=[0.8], v=[-0.6], duration=2.0, events=[middle])
    assert motion.times("middle") == pytest.approx([np.pi / 2 - np.arccos(0.8)], rel=1e-9)
    assert motion.watched == (middle,)


def test_of_many_motions_those_that_leave_the_chart_have_no_end() -> None:
    mechanism = mq.textbook.load("particle_on_circle_x")
    runs = mq.simulate_many(mechanism, q={"x": [0.8, 0.8]}, v={"x": [-0.6, -0.1]}, duration=4.0)
    assert "chosen because it watches the limits of x" in runs.method
    assert np.isnan(runs["x"][0, -1])
    # theta' = 1/6 brings it from acos(0.8) on by 4/6
    assert runs["x"][1, -1] == pytest.approx(np.cos(np.arccos(0.8) + 4 / 6), abs=1e-6)
    with pytest.raises(
        mq.InputError, match="method 'batch' does not watch the limits of x; expected 'single' or"
    ):
        mq.simulate_many(mechanism, q={"x": [0.8]}, method="batch")
