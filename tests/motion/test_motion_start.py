"""What a start by name leaves out is named, with its value, in what comes of it."""

from __future__ import annotations

from typing import Any

import pytest

import mecanique as mq

LEFT_OUT = [
    ({"q1": 1.0}, None, "; q2 = 0 was not given"),
    ({"q1": 1.0, "q2": 2.0}, {"q2'": 3.0}, "; q1' = 0 was not given"),
    ({"q2": 1.0}, {"q2": 3.0}, "; q1 = 0, q1' = 0 were not given"),
    ({"q1": 1.0, "q2": 2.0}, None, ""),
    ({}, {}, ""),
    (None, None, ""),
    ([1.0, 2.0], [0.0, 1.0], ""),
]
"""Positions, velocities, what a result says of them; the neutral state and rest need no word."""


@pytest.mark.parametrize(("q", "v", "said"), LEFT_OUT)
def test_a_motion_names_what_was_not_given(q: Any, v: Any, said: str) -> None:
    motion = mq.simulate(mq.textbook.load("double_pendulum"), q=q, v=v, duration=0.01)
    assert motion.method.endswith(said)
    assert ("not given" in motion.method) == bool(said)


def test_runs_and_linear_equations_name_it_too() -> None:
    pendulum = mq.textbook.load("double_pendulum")
    runs = mq.simulate_many(pendulum, q={"q1": [0.1, 0.2]}, duration=0.01, samples=2)
    assert runs.method.endswith("; q2 = 0 was not given")
    linear = mq.linearize(pendulum, at={"q1": 0.1}, v={"q1": 1.0})
    assert linear.chosen == "about the state given; q2 = 0, q2' = 0 were not given"
    assert linear.chosen in str(linear)


def test_what_loops_decide_is_not_left_out() -> None:
    crank = mq.simulate(mq.textbook.load("slider_crank"), q={"theta": 0.5}, duration=0.01)
    assert "not given" not in crank.method


def test_what_fewer_names_than_degrees_of_freedom_leave_open_is_named() -> None:
    m = mq.textbook.load("governor")
    motion = mq.simulate(m, q={"psi": 0.2}, v={"psi": 1.0}, duration=0.01)
    values = zip(m.coordinates, motion.q[0], strict=True)
    said = [f"{name} = {value:.6g}" for name, value in values if name != "psi"]
    assert motion.method.endswith(f"; {', '.join(said)} were not given")
