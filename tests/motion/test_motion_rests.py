"""Where contacts, stops and friction let a mechanism rest, against statics by hand."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import pytest

import mecanique as mq
from mecanique.motion.linear import held

G = 9.81

Rest = tuple[dict[str, str], bool, dict[str, tuple[float, float]], tuple[str, ...]]

RESTS: dict[str, tuple[dict[str, float], list[Rest]]] = {
    "bouncing_ball": ({}, [({"floor": "closed"}, True, {}, ())]),
    # within mu m g/k of where the spring is slack
    "dry_oscillator": ({}, [({"dry": "sticks"}, True, {"x": (-0.00981, 0.00981)}, ())]),
    # tan 0.4 = 0.42
    "block_on_incline": ({"mu_0": 0.43}, [({"dry": "sticks"}, True, {}, ("x",))]),
    "block_on_incline ": ({"mu_0": 0.42}, []),
    # kinetic friction of the belt stretches the spring by mu m g/k
    "stick_slip": ({}, [({"belt": "slips -"}, True, {}, ())]),
    "pendulum_with_stop": (
        {},
        [({"stop": "open"}, True, {}, ()), ({"stop": "open"}, False, {}, ())],
    ),
    "clutch": ({}, [({"plates": "sticks"}, True, {}, ("p", "s"))]),
}


@pytest.mark.parametrize("name", RESTS)
def test_rests_have_their_states_and_how_far_friction_holds(name: str) -> None:
    parameters, expected = RESTS[name]
    rests = mq.equilibria(mq.textbook.load(name.strip(), **parameters), 10)
    assert [(r.states, r.stable, r.family) for r in rests] == [
        (states, stable, family) for states, stable, _, family in expected
    ]
    for rest, (_, _, ranges, _) in zip(rests, expected, strict=True):
        assert rest.ranges.keys() == ranges.keys()
        for name_of, ends in ranges.items():
            assert rest.ranges[name_of] == pytest.approx(ends, rel=0, abs=1e-9)


def test_a_belt_stretches_the_spring_on_which_a_block_rests() -> None:
    (rest,) = mq.equilibria(mq.textbook.load("stick_slip"), 10)
    assert rest.q == pytest.approx([0.01962], rel=0, abs=1e-12)
    assert rest.linearization.frequencies == pytest.approx([10.0], rel=1e-10)
    assert "x = 0.01962; belt slips -" in str(rest)


def test_a_block_stands_or_balances_on_a_corner() -> None:
    """Its center is above the corner at tan th = b/h."""
    block = mq.textbook.load("rocking_block")
    stands, *balances = mq.equilibria(block, 20)
    assert stands.states == {"left": "sticks", "right": "sticks"}
    assert stands.family == ("x",)
    assert not len(stands.linearization.M)
    assert sorted(rest.q[2] for rest in balances) == pytest.approx(
        [-math.atan(0.25), math.atan(0.25)], rel=0, abs=1e-9
    )
    # it falls like a pendulum about the corner: p² = 3 g/(4 R)
    p = math.sqrt(0.75 * G / math.hypot(0.1, 0.4))
    for rest in balances:
        assert rest.linearization.eigenvalues.real.max() == pytest.approx(p, rel=1e-8)


def test_a_ladder_leans_as_friction_allows() -> None:
    """Rough floor and smooth wall: tan of its angle to the wall is at most 2 mu."""
    mu, length = 0.3, 4.0
    wall = mq.Placement((0, 0, 0), (0, math.pi / 2, 0))
    ladder = mq.Mechanism(
        "ladder",
        (mq.Body("ground"), mq.Body("ladder", mq.rod(1.0, length).at((0, 0, length)))),
        (mq.Planar("plane", "ground", "ladder", axis=(0, -1, 0), names=("x", "z", "th")),),
        switching=(
            mq.Contact("floor", "ladder", mu=mu),
            mq.Contact("wall", "ladder", (0, 0, length), plane=wall),
        ),
    )
    starts = [{"x": 1.0, "th": 0.25}, {"x": 3.0, "th": 0.8}]
    leaning = [
        rest
        for rest in mq.equilibria(ladder, starts)
        if rest.states == {"floor": "sticks", "wall": "closed"}
    ]
    assert len(leaning) == 1
    _, high = leaning[0].ranges["th"]
    assert high == pytest.approx(math.atan(2 * mu), rel=0, abs=1e-8)


def test_too_many_contacts_are_refused() -> None:
    ball = mq.textbook.load("bouncing_ball")
    floors = tuple(replace(ball.switching[0], name=f"floor{k}") for k in range(7))
    with pytest.raises(mq.InputError, match="7 elements may be closed, more than 6"):
        mq.equilibria(replace(ball, switching=floors))


def test_what_touches_is_closed_in_few_steps(monkeypatch: pytest.MonkeyPatch) -> None:
    """A gap of one rounding cannot be made smaller, and was tried thirty times."""
    steps, closed, right = [0], list[int](), vars(held)["least_step"]

    def step(*given: Any) -> Any:
        steps[-1] += 1
        return right(*given)

    close = held.HeldMode.close

    def begin(*given: Any, **named: Any) -> Any:
        steps[-1] = 0
        place = close(*given, **named)
        closed.append(steps[-1])
        return place

    monkeypatch.setattr(held, "least_step", step)
    monkeypatch.setattr(held.HeldMode, "close", begin)
    assert len(mq.equilibria(mq.textbook.load("ladder"), 20)) == 3
    assert max(closed) < 15
    assert len(closed) > 100
