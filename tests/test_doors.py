"""Calls with wrong objects are refused in words; those that fail otherwise keep their exception."""

from __future__ import annotations

import inspect
import pickle
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import mecanique as mq

MQ: Any = mq  # wrong arguments are the subject here
PENDULUM = mq.textbook.load("simple_pendulum")
MECHANISM: Any = PENDULUM
WRONG: dict[str, Any] = {"x": "'x', of type str", "3": "3, of type int", "None": "None"}
DOORS: dict[str, tuple[Callable[[Any], Any], str]] = {
    "derive": (mq.derive, "a Mechanism for 'mechanism'"),
    "simulate": (mq.simulate, "a Mechanism for 'mechanism'"),
    "verify": (mq.verify, "a Mechanism for 'mechanism'"),
    "assemble": (mq.assemble, "a Mechanism for 'mechanism'"),
    "linearize": (mq.linearize, "a Mechanism for 'mechanism'"),
    "degrees_of_freedom": (mq.degrees_of_freedom, "a Mechanism for 'mechanism'"),
    "write_urdf": (mq.write_urdf, "a Mechanism for 'mechanism'"),
    "generate": (mq.generate, "an Equations or a Modes for 'equations'"),
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


EQUATIONS: Any = mq.derive(PENDULUM)
MOTION: Any = mq.simulate(PENDULUM, q=[0.3], duration=0.1)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (
            lambda: EQUATIONS.solved(keep=3),
            "expected a text or several, each a text for 'keep', got 3, of type int",
        ),
        (
            lambda: EQUATIONS.text(steps=np.zeros((2, 3))),
            "expected True or False for 'steps', got array([[0., 0., 0.],",
        ),
        (
            lambda: MOTION.audit(accuracy="x"),
            "expected a number for 'accuracy', got 'x', of type str",
        ),
        (lambda: MOTION.pose("rod", 10**400), "expected times [s], got 1000"),
        (
            lambda: MQ.Reference(PENDULUM).quick_energies(1.5, MOTION.v, MOTION.t),
            "expected an array for 'q', got 1.5, of type float",
        ),
        (
            lambda: MECHANISM.matrix(3),
            "expected a Placement for 'placement', got 3, of type int",
        ),
        (
            lambda: MQ.verify(PENDULUM, tolerance=10**400),
            "expected a number or None for 'tolerance', got an integer of 401 digits",
        ),
        (
            lambda: MQ.equilibria(PENDULUM, seed=-1.5),
            "expected a whole number for 'seed', got -1.5, of type float",
        ),
        (
            lambda: MQ.inspect(PENDULUM, "x.html"),
            "expected several, each a Finding or None for 'findings', got 'x.html', of type str",
        ),
        (lambda: PENDULUM.explain_limit("q"), "unknown limited coordinate 'q'; known: "),
        (lambda: MQ.asin(3.0), "asin has no real value at 3"),
        (lambda: MQ.exp(1e300), "exp exceeds the largest number at 1e+300"),
        (
            lambda: MQ.simulate(PENDULUM, q=[0.3], duration=1.0, samples=10**9),
            "expected at most 1e+08 samples, got more",
        ),
        (
            lambda: MQ.linearize(PENDULUM).motion(periods=1e308),
            "expected fewer than 100,000,000 samples, got ",
        ),
    ],
)
def test_methods_and_what_they_return_refuse_in_words(
    call: Callable[[], Any], message: str
) -> None:
    with pytest.raises(mq.InputError) as caught:
        call()
    assert str(caught.value).startswith(message)


def test_methods_of_classes_stay_methods() -> None:
    assert mq.Loop.ball.__self__ is mq.Loop  # type: ignore[attr-defined]
    assert mq.Reference.of(PENDULUM).mechanism == PENDULUM
    assert inspect.signature(EQUATIONS.solved).parameters["keep"]
    assert pickle.loads(pickle.dumps(EQUATIONS.text))() == EQUATIONS.text()
