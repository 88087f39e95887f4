"""Exercises: variants by seed, each with a verified answer."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import mecanique as mq
from mecanique.cli import app
from mecanique.model import Mechanism
from mecanique.teaching import make_exercise
from mecanique.textbook import entry
from mecanique.textbook.facts import Frequencies, Values


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("system", ["cart_pole", "rigid_bar_pendulum", "two_blocks"])
def test_a_seed_makes_a_variant_whose_answer_is_right(system: str, seed: int) -> None:
    made = make_exercise(system, seed=seed)
    assert made.check.right
    assert mq.check(made.mechanism, made.answer).right
    assert made.answer in made.solution
    assert made.problem == make_exercise(system, seed=seed).problem
    assert made.mechanism.values != make_exercise(system, seed=seed + 10).mechanism.values


@pytest.mark.parametrize(
    "ask", ["kinetic energy", "potential energy", "Lagrangian", "mass matrix", "frequency"]
)
def test_other_questions_have_right_answers_too(ask: str) -> None:
    made = make_exercise("rigid_bar_pendulum", ask, seed=2)
    assert made.ask == ask
    assert mq.check(made.mechanism, made.answer, ask).right


@pytest.mark.parametrize(
    ("system", "ask", "answer", "task"),
    [
        ("two_blocks", "momentum", "p = m2 q2'", "Write the canonical momentum p of q2."),
        ("rotating_plate", "energy", "m (a^2 + b^2) theta'^2/6 + k theta^2/2", "energy E = T + V"),
        ("atwood_machine", "conserved quantity", "(2 m1 + 2 m2 + M) x'^2/4", "constant in every"),
        ("simple_pendulum", "period", "T = 2 pi/sqrt(g/l)", "period T of small oscillations"),
        ("rotating_plate", "period from rest", "integral(", "begins at rest at theta = theta0"),
        ("base_excited_mass", "undamped frequency", "sqrt(k/m)", "without the damping"),
        ("base_excited_mass", "damped frequency", "sqrt(k/m - (c/m)^2/4)", "of the damped small"),
        ("kepler_orbit", "Hamiltonian", "H = p1 (p1/", "canonical momenta p1, p2"),
        ("spherical_pendulum", "Hamilton's equations", "p1' = m l^2 sin(", "canonical momenta"),
        ("cart_pole", "state space", "q' = w2", "with w1, w2 for their rates"),
        ("two_blocks", "transfer function", "G = (-(-k2))/(", "G(s) of q1 from F"),
        ("two_link_arm", "equilibrium force", "tau1 = ", "Find tau1, tau2 such that"),
        ("acrobot", "equilibrium", "q1 = pi", "Find all positions at rest."),
        (
            "cart_pole",
            "equation of motion by newton_euler",
            "(M + m) x''",
            "cut free",
        ),
        ("kepler_orbit", "equation of motion by virtual_work", "- r phi'^2", "d'Alembert"),
        (
            "kepler_orbit",
            "acceleration",
            "phi'' = -2 phi' r'/r",
            "accelerations in the",
        ),
        ("rigid_bar_pendulum", "reaction", "R_pin_n = m l q'^2/2 + m g cos(q)", "R_pin_n, R_pin_t"),
        ("cart_pole", "driving force", "F = (M + m) x'' + m l cos(q) q''", "Find F by the motion"),
        ("kepler_orbit", "conserved momentum", "p = m r^2 phi'", "Which coordinate is cyclic?"),
        ("bead_on_hoop", "Jacobi's integral", "- m R^2 W^2 sin(theta)^2/2", "is not conserved"),
        ("base_excited_mass", "undamped period", "T = 2 pi/sqrt(k/m)", "without the damping"),
        ("base_excited_mass", "damped period", "T = 2 pi/sqrt(k/m - (c/m)^2/4)", "period T of the"),
    ],
)
def test_each_kind_of_question_has_a_verified_answer(
    system: str, ask: str, answer: str, task: str
) -> None:
    made = next(
        made
        for made in map(partial(make_exercise, system, ask), range(20))
        if "psi" not in made.answer
    )
    assert made.check.right
    assert answer in made.answer
    assert task in made.problem


@pytest.mark.parametrize(
    ("system", "ask", "why"),
    [
        ("cart_pole", "period", "no single coordinate swings about zero"),
        ("simple_pendulum", "damped frequency", "it is not damped"),
        ("n_link_pendulum", "Hamiltonian", "more than two coordinates"),
        ("bead_on_hoop", "equilibrium", "its equilibria depend on its numbers"),
        ("simple_pendulum", "transfer function", "it has no single input"),
        ("two_link_arm", "driving force", "it has no single input"),
        ("simple_pendulum", "conserved momentum", "has no cyclic coordinate"),
        ("simple_pendulum", "Jacobi's integral", "it has no Jacobi integral but its energy"),
        ("free_particle", "reaction", "no reaction is determined"),
        ("simple_pendulum", "damped period", "it is not damped"),
        ("base_excited_mass", "period in seconds", "expected an undamped mechanism that swings"),
    ],
)
def test_a_question_that_a_system_does_not_have_is_refused(system: str, ask: str, why: str) -> None:
    with pytest.raises(mq.InputError, match=f"no such exercise about '{system}'.*{why}"):
        make_exercise(system, ask)


def test_the_forces_of_a_contact_are_asked_for() -> None:
    exercise = make_exercise("rolling_disk", "reaction")
    assert exercise.answer.splitlines() == [
        "lambda_contact_normal = m g cos(alpha)",
        "lambda_contact_x = -m g sin(alpha)/3",
    ]


@pytest.mark.parametrize(
    ("system", "ask", "difficulty"),
    [
        ("simple_pendulum", "potential energy", 1),
        ("simple_pendulum", "equation of motion", 2),  # only steps
        ("n_link_pendulum", "potential energy", 3),  # a short answer about four coupled bodies
        ("cart_pole", "equation of motion", 3),  # two degrees of freedom, coupled, changing
        ("two_blocks", "equation of motion", 2),  # two, which only a spring couples
        ("furuta_pendulum", "state space", 4),
        ("rolling_coin", "equation of motion", 4),
        ("rolling_coin", "acceleration", 5),
    ],
)
def test_difficulty_goes_by_what_makes_an_exercise_hard(
    system: str, ask: str, difficulty: int
) -> None:
    made = make_exercise(system, ask)
    assert made.difficulty == difficulty
    assert f"Difficulty: {difficulty} of 5." in made.solution


@pytest.mark.parametrize(
    ("ask", "last", "left_out"),
    [
        ("kinetic energy", ". Kinetic energy\n", ". Potential energy\n"),
        ("mass matrix", "M_ij = ∂²T/∂q_i' ∂q_j'", ". Potential energy\n"),
        ("Lagrangian", ". Potential energy\n", "Operator for"),
        ("frequency", "With the numbers given: omega = ", "Operator for"),
        ("equation of motion", "Equations of motion", "Small motions"),
    ],
)
def test_the_steps_end_where_the_question_does(ask: str, last: str, left_out: str) -> None:
    made = make_exercise("simple_pendulum", ask, seed=1)
    assert last in made.solution
    assert left_out not in made.solution


@pytest.mark.parametrize(
    ("ask", "letter", "unit", "of_frequency"),
    [
        ("frequency in hertz", "f", "Hz", lambda omega: omega / (2 * math.pi)),
        ("period in seconds", "T", "s", lambda omega: 2 * math.pi / omega),
    ],
)
def test_answers_in_numbers_have_four_digits_and_a_unit(
    ask: str, letter: str, unit: str, of_frequency: Callable[[float], float]
) -> None:
    made = make_exercise("coupled_pendulums", ask, seed=3)
    frequencies = mq.linearize(made.mechanism).frequencies
    assert made.answer.splitlines() == [
        f"{letter}{k} = {of_frequency(omega):.4g} {unit}" for k, omega in enumerate(frequencies, 1)
    ]
    assert made.rounded
    assert f" in {unit}, for the numbers given, to four digits.**" in made.problem


def test_other_methods_lead_to_their_equations_by_their_own_steps() -> None:
    lagrange, balances, work = (
        make_exercise("simple_pendulum", f"equation of motion{by}", seed=2, turned=False)
        for by in ("", " by newton_euler", " by virtual_work")
    )
    assert lagrange.answer == balances.answer == work.answer
    assert "Kinetic energy" in lagrange.solution
    assert "Free body bob: forces" in balances.solution
    assert "Kinetic energy" not in balances.solution + work.solution


def test_the_number_of_a_frequency_is_that_of_the_numbers_given() -> None:
    made = make_exercise("simple_pendulum", "frequency", seed=3)
    values = made.mechanism.values
    assert f"omega = {(values['g'] / values['l']) ** 0.5:.4g} rad/s" in made.solution


@pytest.mark.parametrize("system", ["coupled_pendulums", "elastic_pendulum", "rack_and_pinion"])
def test_several_frequencies_are_asked_for_in_numbers(system: str) -> None:
    """By the closed forms of the catalogue, about the equilibrium that the question names."""
    made = make_exercise(system, "frequency", seed=4)
    (fact,) = (fact for fact in entry(system).facts if isinstance(fact, Frequencies))
    known = np.sort(np.ravel(fact.formula(Values(made.mechanism.values))))
    stated = [float(x) for x in re.findall(r"= (\S+) rad/s", made.answer)]
    np.testing.assert_allclose(stated, known, rtol=5.1e-4, atol=0)
    assert "for the numbers given, to four digits" in made.problem
    at = re.search(r"small motions about (.*), for the numbers", made.problem)
    assert at is not None
    named = dict(part.split(" = ") for part in at[1].split(", "))
    place = [float(named[name]) for name in made.mechanism.coordinates]
    assert np.abs(mq.Reference(made.mechanism).acceleration(place)).max() < 0.05
    wrong = made.answer.replace("= ", "= 1")
    assert not mq.check(made.mechanism, wrong, "frequency").right
    assert mq.check(made.mechanism, made.answer, "frequency").outcome == "right except for form"


def test_one_coordinate_is_spoken_of_as_one() -> None:
    assert "in the coordinate theta." in make_exercise("bead_on_hoop", "potential energy").problem
    assert (
        "in the coordinates x, q and their rates."
        in make_exercise("cart_pole", "kinetic energy").problem
    )


def test_some_variants_count_an_angle_the_other_way_round() -> None:
    texts = [make_exercise("rigid_bar_pendulum", seed=seed).problem for seed in range(8)]
    assert any("psi = −q" in text for text in texts)
    assert any("psi" not in text for text in texts)


def test_it_is_written_with_its_figure(tmp_path: Path) -> None:
    words = ["exercise", "cart_pole", "--seed", "7", "-o", str(tmp_path / "one")]
    result = CliRunner().invoke(app, words)
    assert result.exit_code == 0, result.output
    assert {path.name for path in (tmp_path / "one").iterdir()} == {
        "problem.md",
        "figure.svg",
        "solution.md",
    }
    assert "figure.svg" in (tmp_path / "one" / "problem.md").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("system", "ask", "message"),
    [
        ("cart_pole", "weather", "unknown question"),
        ("pendulm", "equation of motion", "unknown system"),
        ("cart_pole", "frequency", "expected an undamped mechanism that swings about a stable"),
        ("tennis_racket", "frequency", "expected an undamped mechanism that swings about a stable"),
        ("crane", "frequency", "have no constant coefficients"),
        ("tennis_racket", "potential energy", "its potential energy is constant"),
        ("four_bar_linkage", "frequency", "no such exercise about 'four_bar_linkage': mechanism"),
        ("bricard_linkage", "equation of motion", "no exercise about"),
        (
            "whipple_bicycle",
            "equation of motion",
            "no exercise about 'whipple_bicycle': the closed",
        ),
    ],
)
def test_what_has_no_answer_is_refused(system: str, ask: str, message: str) -> None:
    with pytest.raises(mq.InputError, match=message):
        make_exercise(system, ask)


def test_a_linkage_is_drawn_where_its_motion_starts(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    drawn: list[list[float]] = []

    def picture(shown: Mechanism, *, path: Path, q: list[float]) -> Path:
        drawn.append(q)
        return path

    monkeypatch.setattr("mecanique.teaching.exercise.picture", picture)
    make_exercise("slider_crank", seed=2).write(tmp_path)
    theta, beta, _ = drawn[0]
    assert abs(theta) > 0.3
    assert abs(beta) > 0.3
