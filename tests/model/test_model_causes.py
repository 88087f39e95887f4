"""What explains a difference has one interface: for verify and diff, for check, and for lint."""

from collections.abc import Callable, Sequence

import pytest

import mecanique as mq
from mecanique.model.slips import Cause

PENDULUM = mq.textbook.load("double_pendulum")
HEAVIER = PENDULUM.replace(m2=3.0 * PENDULUM.values["m2"])

CAUSES: dict[str, Callable[[], Sequence[Cause]]] = {
    "verify": lambda: mq.verify(PENDULUM, 5, against=HEAVIER).causes,
    "diff": lambda: mq.diff(PENDULUM, HEAVIER).changes,
    "check": lambda: mq.check(mq.textbook.load("simple_pendulum"), "q'' = 2 g/l sin(g/l q)").causes,
    "lint": lambda: mq.lint(mq.write_urdf(mq.textbook.load("simple_pendulum"))),
}
"""What each act finds wrong; that they are `Cause`s is checked by the types."""

EXPECTED = {
    "verify": ("link mass", "link 'rod2'", "mass and inertia of link 'rod2' times 3 (mass 3 kg)"),
    "diff": ("mass", "link 'rod2'", "mass 1 → 3 kg (+200 %)"),
    "check": (
        "units",
        "sin(g/l q)",
        "the units do not match: the argument of 'sin(g/l q)' is in 1/s², expected an angle or a "
        "pure number",
    ),
    "lint": ("point-mass", "link 'bob'", "a mass without inertia"),
}


@pytest.mark.parametrize("act", CAUSES)
def test_a_cause_has_a_kind_a_place_and_words(act: str) -> None:
    cause = CAUSES[act]()[0]
    assert (cause.kind, cause.where, cause.text) == EXPECTED[act]
