"""Calls with wrong objects are refused in words; those that fail otherwise keep their exception."""

from __future__ import annotations

import pickle
from collections.abc import Callable
from typing import Any

import pytest

import mecanique as mq

MQ: Any = mq  # wrong arguments are the subject here
PENDULUM = mq.textbook.load("simple_pendulum")
WRONG: dict[str, Any] = {"x": "'x', of type str", "3": "3, of type int", "None": "None"}
DOORS: dict[str, tuple[Callable[[Any], Any], str]] = {
    "derive": (mq.derive, "a Mechanism for 'mechanism'"),
    "simulate": (mq.simulate, "a Mechanism for 'mechanism'"),
    "verify": (mq.verify, "a Mechanism for 'mechanism'"),
    "assemble": (mq.assemble, "a Mechanism for 'mechanism'"),
    "linearize": (mq.linearize, "a Mechanism for 'mechanism'"),
    "degrees_of_freedom": (mq.degrees_of_freedom, "a Mechanism for 'mechanism'"),
    "write_urdf": (mq.write_urdf, "a Mechanism for 'mechanism'"),
    "generate": (mq.generate, "an Equations for 'equations'"),
    "Reference": (mq.Reference, "a Mechanism for 'mechanism'"),
}


@pytest.mark.parametrize("wrong", WRONG)
@pytest.mark.parametrize("name", DOORS)
def test_what_is_no_mechanism_is_refused_in_words(name: str, wrong: str) -> None:
    door, expected = DOORS[name]
    value = {"x": "x", "3": 3, "None": None}[wrong]
    with pytest.raises(mq.InputError) as caught:
        door(value)
    # what checks its mechanism before anything else names the type alone
    assert str(caught.value) in (
        f"expected {expected}, got {WRONG[wrong]}",
        f"expected a Mechanism, got {type(value).__name__}",
    )


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (
            lambda: MQ.Mechanism("a", 3, ()),
            "several, each a Body for 'bodies', got 3, of type int",
        ),
        (
            lambda: MQ.Mechanism("a", ["b"], ()),
            "several, each a Body for 'bodies', got ['b'], of",
        ),
        (lambda: MQ.simulate(PENDULUM, events=3), "several, each an Event for 'events', got 3"),
        (
            lambda: MQ.simulate(PENDULUM, reference=4),
            "a Reference or None for 'reference', got 4",
        ),
        (
            lambda: MQ.assemble(PENDULUM, keep=2),
            "names for keep, got 2",
        ),
        (lambda: MQ.write_urdf(PENDULUM, 2.5), "a text or a path or None for 'path', got 2.5"),
        (lambda: MQ.check(PENDULUM, 3), "a text for 'text', got 3, of type int"),
        (
            lambda: MQ.derive(mq.Mechanism),
            "a Mechanism for 'mechanism', got the class Mechanism",
        ),
        (
            lambda: MQ.simulate(PENDULUM, q=[10**400]),
            "1 number for the coordinate values, got [1",
        ),
    ],
)
def test_arguments_of_a_wrong_kind_are_refused_in_words(
    call: Callable[[], Any], message: str
) -> None:
    with pytest.raises(mq.InputError) as caught:
        call()
    assert str(caught.value).startswith(f"expected {message}")


def test_what_a_users_function_raises_stays_as_it_is() -> None:
    def fails(*state: object) -> float:
        raise ZeroDivisionError("mine")

    with pytest.raises(ZeroDivisionError, match="mine"):
        mq.simulate(PENDULUM, q=[0.3], duration=1.0, events=[mq.Event("never", fails)])
    with pytest.raises(TypeError, match="unexpected keyword argument 'lenght'"):
        MQ.simulate(PENDULUM, lenght=1.0)


def test_public_functions_can_be_pickled() -> None:
    assert pickle.loads(pickle.dumps(mq.derive)) is mq.derive
    assert mq.derive.__name__ == "derive"
