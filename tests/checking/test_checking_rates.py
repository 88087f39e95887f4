"""A sample of the benchmark: rewritten right answers, injected mistakes, texts without sense."""

from __future__ import annotations

import random
import sys
from pathlib import Path

import pytest

import mecanique as mq

sys.path.insert(0, str(Path(__file__).parents[1] / "benchmarks"))

from check_answers import EXPECTED, Answer, problem, right_answers, wrong_answers

SYSTEMS = ("cart_pole", "double_pendulum", "elastic_pendulum", "rigid_bar_pendulum")

_SIGNS = [
    *("sin", "cos", "\\frac", "\\ddot", "m1", "q1'", "q2''", "Matrix", "Derivative", ".diff(t)"),
    *"()[]{}^\\+-*/=,;&\n02.√²θ$%_'\u0308\u2081 ",
]


def judge(answer: Answer) -> mq.Check:
    return mq.check(problem(answer.system).mechanism, answer.text, let=answer.let)


def test_no_right_answer_is_rejected() -> None:
    answers = list(right_answers(12, seed=5, systems=SYSTEMS))
    assert len({answer.how for answer in answers}) > 8
    for answer in answers:
        assert judge(answer).right, f"{answer}\n{judge(answer)}"


def test_no_wrong_answer_is_accepted_and_its_mistake_is_named() -> None:
    answers = list(wrong_answers(15, seed=6, systems=SYSTEMS))
    assert len({answer.mistake for answer in answers}) > 10
    unnamed = []
    for answer in answers:
        found = judge(answer)
        assert not found.right, answer
        kinds = {cause.kind for cause in found.causes[:3]}
        if not kinds & EXPECTED[answer.mistake]:
            unnamed.append(answer)
    assert len(unnamed) <= 0.05 * len(answers), unnamed


@pytest.mark.parametrize("seed", range(4))
def test_texts_without_sense_are_refused_in_words(seed: int) -> None:
    draw = random.Random(seed)
    mechanism = mq.textbook.load("double_pendulum")
    refused = 0
    for _ in range(150):
        text = "".join(draw.choice(_SIGNS) for _ in range(draw.randint(1, 40)))
        try:
            mq.check(mechanism, text)
        except mq.FormulaError:
            refused += 1
    assert refused > 100
