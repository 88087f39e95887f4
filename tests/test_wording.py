"""Counts and their nouns agree in number, wherever they stand."""

from __future__ import annotations

import re
from typing import Any

import pytest

import mecanique as mq
from mecanique.wording import say_count


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ((1, "state"), "1 state"),
        ((0, "state"), "0 states"),
        ((2, "body", "bodies"), "2 bodies"),
        ((1, "body", "bodies"), "1 body"),
    ],
)
def test_a_noun_agrees_with_its_count(given: tuple[int, str, str], said: str) -> None:
    assert say_count(*given) == said


def test_one_of_anything_is_singular() -> None:
    mechanism = mq.textbook.load("simple_pendulum")
    verdict = mq.verify(mechanism, samples=1)
    motion = mq.simulate(mechanism, duration=0.1, samples=[0.1])
    said = [repr(mechanism), str(verdict), verdict.summary, repr(motion), motion.summary()]
    said.append(str(mq.degrees_of_freedom(mechanism)))
    faulty: list[dict[str, Any]] = [{"q": []}, {"q": [1.0, 2.0]}, {"q": [0.1], "max_steps": 1}]
    for wrong in faulty:
        with pytest.raises(mq.MecaniqueError) as caught:
            mq.simulate(mechanism, **wrong)
        said.append(str(caught.value))
    text = "\n".join(said)
    assert "agrees at 1 random state" in text
    assert "more than 1 step " in text
    assert re.findall(r"(?<![\d.,])1 (?!s\b|is\b|J\b)\w*s\b.*", text) == []
