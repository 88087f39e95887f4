"""What is no mechanism, no number or no name is refused at the door, in words."""

from __future__ import annotations

import pickle
from collections.abc import Callable
from importlib.machinery import ModuleSpec
from typing import Any

import numpy as np
import pytest

import mecanique as mq
from mecanique.errors import DerivationError, EngineError, InputError, UnknownNameError
from mecanique.reference.engine import package

HUGE = 10**400
LINKAGE = mq.textbook.load("four_bar_linkage")
CLOSED = mq.assemble(LINKAGE)

MECHANISMS: dict[str, Callable[[Any], object]] = {
    "Reference": mq.Reference,
    "Reference.of": mq.Reference.of,
    "assemble": mq.assemble,
    "assembly_branches": mq.assembly_branches,
    "degrees_of_freedom": mq.degrees_of_freedom,
}


@pytest.mark.parametrize("door", MECHANISMS)
@pytest.mark.parametrize("given", [None, "pendulum", 3.5, {}, [], np.zeros(2), type])
def test_what_is_no_mechanism_is_refused(door: str, given: Any) -> None:
    with pytest.raises(InputError, match=f"expected a Mechanism, got {type(given).__name__}"):
        MECHANISMS[door](given)


STATES = {
    "acceleration": lambda r, q, v, t: r.acceleration(q, v, t),
    "reactions": lambda r, q, v, t: r.reactions(q, v, t),
    "multipliers": lambda r, q, v, t: r.multipliers(q, v, t),
    "energy": lambda r, q, v, t: r.energy(q, v, t),
    "point": lambda r, q, v, t: r.point("crank", (0, 0, 0), q, v, t=t),
    "resultant": lambda r, q, v, t: r.resultant(q, v, t),
    "response": lambda r, q, v, t: r.response(q, t, v),
    "drift": lambda r, q, v, t: r.drift(q, v, t),
}


@pytest.mark.parametrize("name", STATES)
@pytest.mark.parametrize(
    ("state", "message"),
    [
        (([HUGE, 0, 0], [0, 0, 0], 0.0), "expected 3 numbers for the coordinate values"),
        (({"phi": HUGE}, [0, 0, 0], 0.0), "expected a finite number for coordinate phi"),
        ((CLOSED, [0, HUGE, 0], 0.0), "expected 3 numbers for the (velocity|impulse) values"),
        ((CLOSED, [0, 0, 0], HUGE), "expected a finite number for time t"),
        (
            (CLOSED, [0, 0, 0], []),
            "expected at least one number for time t, got none",
        ),
        ((CLOSED, [0, 0, 0], [[1, 2], [3]]), "expected numbers for time t"),
        ((CLOSED, np.array(["a"]), 0.0), "expected 3 numbers for the (velocity|impulse) values"),
    ],
)
def test_what_is_no_number_is_refused(name: str, state: tuple[Any, Any, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        STATES[name](mq.Reference(LINKAGE), *state)


def test_values_have_names() -> None:
    reference = mq.Reference(LINKAGE)
    with pytest.raises(InputError, match="expected values by name, got 1 for a name"):
        reference.energy(CLOSED, {1: 2.0})  # type: ignore[dict-item]  # on purpose
    for given in (None, 3, LINKAGE, [1]):
        with pytest.raises(InputError, match="expected names for drives, got"):
            reference.driving_forces(given, CLOSED)  # type: ignore[arg-type]  # on purpose
        with pytest.raises(InputError, match="expected names for keep, got"):
            mq.assemble(LINKAGE, keep=given)  # type: ignore[arg-type]  # on purpose
    nameless: list[Any] = [[], {}, np.array("a")]
    for body in nameless:
        with pytest.raises(UnknownNameError, match="unknown body"):
            reference.pose(body, CLOSED)
    for seed in (None, "a", -1, 0.5):
        with pytest.raises(InputError, match="expected a whole number of at least 0 for seed"):
            mq.degrees_of_freedom(LINKAGE, seed=seed)  # type: ignore[arg-type]  # on purpose
        with pytest.raises(InputError, match="expected a whole number of at least 0 for seed"):
            mq.assembly_branches(LINKAGE, seed=seed)  # type: ignore[arg-type]  # on purpose


@pytest.mark.parametrize("name", ["double_pendulum", "kapitza_pendulum", "four_bar_linkage"])
def test_what_overflows_is_no_answer(name: str) -> None:
    """Neither NaN nor a warning: an error that says where."""
    mechanism = mq.textbook.load(name)
    reference, fast = mq.Reference(mechanism), [1e308] * mechanism.nv
    q = mq.assemble(mechanism)
    asked = [reference.energy, reference.bias]
    asked += [] if mechanism.loops else [reference.acceleration, reference.resultant]
    for ask in asked:
        with pytest.raises(EngineError, match=r"has no finite answer at q = .* v = "):
            ask(q, fast)
    for method in ("lagrange", "newton_euler", "virtual_work"):
        equations = mq.derive(mechanism, method)
        with pytest.raises(DerivationError, match=r"has no finite acceleration at q = .* v = "):
            equations.acceleration(q, fast)


@pytest.mark.parametrize("name", ["double_pendulum", "kapitza_pendulum", "four_bar_linkage"])
def test_both_sides_can_be_sent_to_another_process(name: str) -> None:
    mechanism = mq.textbook.load(name)
    q, v = mq.assemble(mechanism), np.zeros(mechanism.nv)
    reference = mq.Reference(mechanism)
    sent: mq.Reference = pickle.loads(pickle.dumps(reference))
    np.testing.assert_array_equal(sent.acceleration(q, v), reference.acceleration(q, v))
    ranked: mq.Reference = pickle.loads(pickle.dumps(reference.with_rank_at(q)))
    assert ranked.closed is None or ranked.closed.most == 2
    assert sent.closed is None or sent.closed.most is None
    for method in ("lagrange", "newton_euler", "virtual_work"):
        equations = mq.derive(mechanism, method)
        text = str(equations)
        arrived = pickle.loads(pickle.dumps(equations))
        assert str(arrived) == text
        np.testing.assert_array_equal(arrived.acceleration(q, v), equations.acceleration(q, v))


def test_the_engine_is_what_is_installed(monkeypatch: pytest.MonkeyPatch) -> None:
    for spec, installed in ((None, False), (ModuleSpec("pinocchio", None), True)):
        monkeypatch.setattr(package, "find_spec", lambda name, spec=spec: spec)
        assert package.has_pinocchio.__wrapped__() is installed
