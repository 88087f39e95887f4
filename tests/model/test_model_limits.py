"""Coordinates that locate a mechanism within an interval only."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

import mecanique as mq
from mecanique.verification.states import random_states

SENTENCE = (
    r"x must stay within \(-R, R\) = \(-1, 1\), got {}: "
    r"the chart x of 'particle_on_circle_x' ends there; "
    "use another coordinate, e.g. theta"
)


def on_circle(limits: dict[str, tuple[object, object]]) -> mq.Mechanism:
    from sympy import acos

    R = mq.Parameter("R", 2.0, "m")
    return mq.Mechanism(
        "ring",
        (mq.Body("ground"), mq.Body("bead", mq.particle(1.0, (R, 0, 0)))),
        (mq.Revolute("center", "ground", "bead", coordinate="theta"),),
        parameters=(R,),
        coordinates=mq.Coordinates(("x",), {"theta": acos(mq.coordinate("x") / R)}, limits=limits),
    )


@pytest.mark.parametrize("x", [1.0, -1.0, 1.25])
def test_a_position_beyond_its_chart_is_refused_in_words_everywhere(x: float) -> None:
    mechanism = mq.textbook.load("particle_on_circle_x")
    equations, reference = mq.derive(mechanism), mq.Reference(mechanism)
    pattern = SENTENCE.format(f"{x:g}")
    with pytest.raises(mq.InputError, match=pattern):
        mechanism.position([x])
    several: tuple[dict[str, float] | np.ndarray, ...] = (
        {"x": x},
        np.array([x]),
        np.array([[0.0], [x]]),
    )
    for q in several:
        with pytest.raises(mq.InputError, match=pattern):
            equations.mass_matrix(q)
        with pytest.raises(mq.InputError, match=pattern):
            reference.mass_matrix(q)
    with pytest.raises(mq.InputError, match=pattern):
        mq.simulate(mechanism, q=[x])


def test_limits_follow_the_parameters() -> None:
    mechanism = on_circle({"x": (-mq.Parameter("R", 2.0), mq.Parameter("R", 2.0))})
    assert mechanism.limits == {"x": (-2.0, 2.0)}
    assert mechanism.replace(R=3.0).limits == {"x": (-3.0, 3.0)}
    assert pickle.loads(pickle.dumps(mechanism)).limits == mechanism.limits
    assert mechanism.position([1.9]).tolist() == [1.9]


def test_where_zero_is_left_out_the_neutral_position_is_inside() -> None:
    assert on_circle({"x": (0.5, 1.5)}).neutral().tolist() == [1.0]
    assert on_circle({"x": (0.5, float("inf"))}).neutral().tolist() == [1.5]
    assert on_circle({"x": (float("-inf"), -0.5)}).neutral().tolist() == [-1.5]


def test_random_states_lie_inside() -> None:
    q = random_states(on_circle({"x": (0.5, 1.5)}), 200, 0).q
    assert ((q > 0.5) & (q < 1.5)).all()
    assert np.ptp(q) > 0.7
    q = random_states(on_circle({"x": (1.2, float("inf"))}), 50, 0).q
    assert (q > 1.2).all()


def test_verdicts_keep_inside() -> None:
    assert mq.verify(mq.textbook.load("particle_on_circle_x"), samples=30, seed=3).agrees


def test_limits_that_make_no_sense_are_faults() -> None:
    with pytest.raises(
        mq.MechanismError, match=r"coordinate 'x': its lower limit 1 is not below its upper -1"
    ):
        on_circle({"x": (1.0, -1.0)})
    with pytest.raises(
        mq.MechanismError, match="the limits of 'y', which is no generalized coordinate"
    ):
        on_circle({"y": (0.0, 1.0)})
    with pytest.raises(
        mq.MechanismError,
        match="the limits of coordinate 'x' depends on 'S', which is not declared",
    ):
        on_circle({"x": (0.0, mq.Parameter("S", 1.0))})
    with pytest.raises(
        mq.InputError, match=r"expected \(lower, upper\) for each coordinate in limits"
    ):
        mq.Coordinates(("x",), {}, limits={"x": 1.0})  # type: ignore[dict-item]  # what is refused
