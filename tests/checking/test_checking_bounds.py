"""What strangers send is judged within bounds: a clear word, no other error, little time."""

from __future__ import annotations

import itertools
import sys
import time
import tracemalloc
from collections.abc import Iterator

import pytest

import mecanique as mq
from mecanique.checking import budget
from mecanique.checking.check import Checker
from mecanique.checking.judgement.formula import judge_formula
from mecanique.checking.judgement.truth import Truth
from mecanique.checking.mistakes import search
from mecanique.checking.mistakes.hypotheses import Hypotheses
from mecanique.checking.mistakes.of_quantities import QuantityMistakes
from mecanique.checking.verdict import Mistake

PENDULUM = mq.textbook.load("simple_pendulum")
USUAL = budget.SECONDS
PROMISED = 5.0
"""Processor time within which any text is judged, with the words of what ended early [s]."""
DOUBLING = ["a0 = q + l", *(f"a{k} = a{k - 1}*a{k - 1} + a{k - 1}" for k in range(1, 17))]


@pytest.fixture
def patience(monkeypatch: pytest.MonkeyPatch) -> None:
    """Give a judgement four times as long where every line is counted, which slows it so much."""
    coverage = sys.modules.get("coverage")
    if coverage is not None and coverage.Coverage.current() is not None:
        monkeypatch.setattr(budget, "SECONDS", 4 * budget.SECONDS)


@pytest.mark.usefixtures("patience")
@pytest.mark.parametrize(
    ("text", "ask", "let", "message"),
    [
        ("d/dt " * 14 + "(sin(t) cos(t) exp(t)) = 0", "equation of motion", (), "100,000 parts"),
        ("a16 = 0", "equation of motion", DOUBLING, "100,000 parts"),
        ("q" + " " * 3000 + "(t", "equation of motion", (), r"a bracket \( is not closed"),
        ("q" + "\n" * 3000 + "(t", "equation of motion", (), r"a bracket \( is not closed"),
        ("d" * 19999, "equation of motion", (), "more than 200 signs"),
        ("q" * 19999, "equation of motion", (), "more than 200 signs"),
        (r"\frac" * 3000, "equation of motion", (), "nested more than 40 deep"),
        (r"q\frac{d\frac{d}{dt}) q''", "equation of motion", (), "unknown letter 'd'"),
        (r"\boxed{" * 2800, "equation of motion", (), "an empty text"),
        ("q" + r"\mathrm{" * 900 + "(t", "equation of motion", (), r"a bracket \( is not closed"),
        (
            "q " + "hello there " * 1500 + "(t",
            "equation of motion",
            (),
            r"a bracket \( is not closed",
        ),
        ("q" + "'" * 9000 + "₀" * 9000, "equation of motion", (), "has no meaning here"),
        ("1e" + "9" * 4400 + " q = 0", "equation of motion", (), "a number of at most 1e64"),
        ("-Eq(q, 0)", "equation of motion", (), "stands alone in its line"),
        ("Eq(q, 0) + 1 = 0", "equation of motion", (), "stands alone in its line"),
        ("[[q, q'], [g, l]] = 0", "conserved quantity", (), "expected a formula, got a matrix"),
        ("sin([q, q]) = 0", "kinetic energy", (), "expected a formula, got a matrix"),
        ("[[q, q], [q, q]]", "frequency", (), "expected a formula, got a matrix"),
        ("[[q, q], [q, q]]", "equilibrium", (), "expected a formula, got a matrix"),
        ("H" * 19990, "Hamiltonian", (), "more than 200 signs"),
        ("{" + "," * 19990, "equilibrium", (), "more than 4,000 signs"),
        (", " * 9900, "equilibrium", (), "more than 4,000 signs"),
        ("if " * 6600, "equilibrium", (), "more than 4,000 signs"),
        (
            "It is not q'' + g/l sin(q) = 0",
            "equation of motion",
            (),
            "the sentence denies this formula; write what holds",
        ),
        (
            "It is not true that q'' + g/l sin(q) = 0",
            "equation of motion",
            (),
            "the sentence denies this formula; write what holds",
        ),
        (
            "Es ist falsch, dass q'' + g/l sin(q) = 0",
            "equation of motion",
            (),
            "the sentence denies this formula; write what holds",
        ),
        ("ä̃" * 9900, "equation of motion", (), "more than 200 signs|no meaning here"),
        ("<math><mi>\ud800</mi></math>", "equation of motion", (), "a surrogate"),
    ],
)
def test_hostile_texts_are_refused_at_once(
    text: str, ask: str, let: list[str], message: str
) -> None:
    mq.check(PENDULUM, "q'' = 0")
    start = time.thread_time()
    with pytest.raises(mq.FormulaError, match=message):
        mq.check(PENDULUM, text, ask, let)
    assert time.thread_time() - start < budget.SECONDS


def test_positions_of_several_coordinates_are_read_in_linear_time() -> None:
    cart_pole = mq.textbook.load("cart_pole")
    start = time.thread_time()
    with pytest.raises(mq.FormulaError, match="expected at most 20,000 characters"):
        mq.check(cart_pole, "a," * 100_000, "equilibrium")
    assert time.thread_time() - start < budget.SECONDS


@pytest.mark.usefixtures("patience")
@pytest.mark.parametrize("terms", [600, 1900])
def test_a_sum_of_many_terms_is_judged(terms: int) -> None:
    mq.check(PENDULUM, "q'' = 0")
    start, most = time.thread_time(), PROMISED * budget.SECONDS / USUAL
    answer = mq.check(PENDULUM, "+".join(["q"] * terms) + "=0")
    assert time.thread_time() - start < most
    assert answer.outcome == "wrong"
    assert "the search for causes ended after" in str(answer.causes[-1])
    many = "+".join(["q''", *["g/l sin(q)"] * (terms // 6)])
    assert mq.check(PENDULUM, f"{many} - {terms // 6 - 1} g/l sin(q) = 0").outcome == "right"


@pytest.mark.usefixtures("patience")
def test_powers_of_powers_are_not_proven_digit_by_digit() -> None:
    power = "(((1.0000000001^64)^64)^64)^64"
    start = time.thread_time()
    answer = mq.check(PENDULUM, f"{power} (q'' + g/l sin q) = 0")
    assert (answer.outcome, answer.exact) == ("right", False)
    assert time.thread_time() - start < budget.SECONDS


def test_what_takes_too_long_is_refused_in_words(monkeypatch: pytest.MonkeyPatch) -> None:
    mq.check(PENDULUM, "q'' = 0")
    monkeypatch.setattr(budget, "SECONDS", 0.0)
    with pytest.raises(mq.FormulaError, match=r"not judged within 0 s; write them shorter\n  q"):
        mq.check(PENDULUM, "q'' + g/l sin q = 0")


@pytest.mark.parametrize(
    ("ask", "text"), [("equation of motion", "q'' - g/l q = 0"), ("frequency", "2 sqrt(g/l)")]
)
def test_the_search_for_causes_ends_in_time_and_says_so(
    monkeypatch: pytest.MonkeyPatch, ask: str, text: str
) -> None:
    """The verdict stands; only the causes are fewer."""

    def late(*_: object) -> Iterator[Mistake]:
        yield Mistake("sign", "the sign is wrong", "q", 1.0)
        raise budget.SpentError("late", "5 s")

    monkeypatch.setattr(search, "repairs", late)
    answer = mq.check(PENDULUM, text, ask)
    assert answer.outcome == "wrong"
    assert str(answer.causes[0]) == "the sign is wrong"
    assert str(answer.causes[-1]) == "the search for causes ended after 5 s"


@pytest.mark.usefixtures("patience")
def test_a_search_that_runs_out_of_parts_leaves_the_verdict(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A quick machine has spent 100,000 parts before its time is over."""
    monkeypatch.setattr(budget, "MOST_PARTS", 5000)
    answer = mq.check(PENDULUM, "+".join(["q"] * 300) + "=0")
    assert answer.outcome == "wrong"
    assert str(answer.causes[-1]) == "the search for causes ended after 5,000 parts"


@pytest.mark.parametrize(
    ("method", "ask", "text"),
    [
        ("explain", "kinetic energy", "T = m l^2 q'^2"),
        ("explain_constant", "conserved quantity", "m l q'"),
        ("explain_matrix", "mass matrix", "[[2 m l^2]]"),
    ],
)
def test_the_search_in_quantities_ends_in_time_and_says_so(
    monkeypatch: pytest.MonkeyPatch, method: str, ask: str, text: str
) -> None:
    def late(*_: object) -> Iterator[Mistake]:
        yield Mistake("sign", "the sign is wrong", "", 0.1)
        raise budget.SpentError("late", "5 s")

    monkeypatch.setattr(QuantityMistakes, method, late)
    answer = mq.check(PENDULUM, text, ask)
    assert answer.outcome == "wrong"
    said = [str(cause) for cause in answer.causes]
    assert "the sign is wrong" in said
    assert "the search for causes ended after 5 s" in said


@pytest.mark.parametrize(
    "text",
    [
        "m1 r^2 theta'^2/6 + m2 x'^2/2",
        "m1 r^2 theta'^2/6 + m2 r^2 theta'^2/2 (sin(theta) + r sin(theta) cos(theta)"
        "/sqrt(l^2 - r^2 sin(theta)^2))^2",
    ],
)
def test_what_is_not_compared_to_its_end_is_refused(
    monkeypatch: pytest.MonkeyPatch, text: str
) -> None:
    """Of loops the answer is compared again, in other proportions or assembled from zero."""
    calls = itertools.count()

    def spend(*arguments: object) -> object:
        if next(calls):
            raise budget.SpentError("late", "5 s")
        return judge_formula(*arguments)  # type: ignore[arg-type]

    monkeypatch.setattr("mecanique.checking.check.judge_formula", spend)
    monkeypatch.setattr(Checker, "_is_proven", lambda *_: False)
    monkeypatch.setattr(Checker, "_hold_numbers", lambda *_: None)
    with pytest.raises(mq.FormulaError, match="late"):
        mq.check(mq.textbook.load("slider_crank"), text, "kinetic energy")


def test_deriving_the_right_equations_does_not_count(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(budget, "SECONDS", 0.5)
    mechanism = mq.textbook.load("double_pendulum", l1=1.3)
    assert mq.check(mechanism, "q1'' = 0").outcome == "wrong"


def test_what_mistakes_lead_to_is_derived_once_for_all_lines(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Derivations do not depend on the text, so that no clock bounds them."""
    made: list[Hypotheses] = []
    build = Hypotheses.__init__

    def count(self: Hypotheses, truth: Truth) -> None:
        made.append(self)
        build(self, truth)

    monkeypatch.setattr(Hypotheses, "__init__", count)
    counts = []
    for lines in (2, 12):
        made.clear()
        answer = mq.check(PENDULUM, "\n".join(["9.81"] * lines), "frequency")
        assert answer.outcome == "wrong"
        counts.append(len(made))
    assert counts[1] <= counts[0]


@pytest.mark.usefixtures("patience")
def test_the_slope_of_a_long_condition_is_followed_in_bounded_memory() -> None:
    """One of 301 parts at 721 places of each state took twice as much at once."""
    tracemalloc.start()
    try:
        with pytest.raises(mq.FormulaError, match="the condition holds at no q"):
            mq.check(PENDULUM, "1e3 + " + "+".join(["q"] * 300), "equilibrium")
        assert tracemalloc.get_traced_memory()[1] < 70e6
    finally:
        tracemalloc.stop()
