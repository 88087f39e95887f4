"""Whether an equation of motion is right: forms that must be accepted, and some that must not."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest

import mecanique as mq

WRITTEN = (
    "rigid_bar_pendulum",
    "cart_pole",
    "furuta_pendulum",
    "elastic_pendulum",
    "kapitza_pendulum",
    "particle_on_circle_x",
    "two_blocks",
    "tennis_racket",
)

RIGHT = (
    "m l^2/3 q'' + m g l/2 sin q = 0",
    "q'' = -3/2 g/l sin(q)",
    "qdd + 3 g sin q/(2l) = 0",
    "ml²/3 q̈ + ½ mgl sin q = 0",
    r"\frac{m \ell^2}{3}\ddot{q} + \frac12 m g l \sin q = 0",
    r"\[ \frac{d}{dt}\left(\frac{m l^2}{3} \dot q\right) = -\tfrac{1}{2} m g l \sin (q) \]",
    "Eq(m*l**2*Derivative(q(t), (t, 2))/3 + m*g*l*sin(q(t))/2, 0)",
    "-2 l d^2q/dt^2 = 3 g sin(q)",
    "4 l q'' + 12 g sin(q/2) cos(q/2) = 0",
    "q_ddot/sin(q) = -1.5 g/l",
)


@pytest.mark.parametrize("text", RIGHT)
def test_an_equation_is_right_however_it_is_written(text: str) -> None:
    found = mq.check(mq.textbook.load("rigid_bar_pendulum"), text)
    assert found.right, str(found)
    assert found.worst < 1e-12


@pytest.mark.parametrize(
    ("name", "form"),
    # names of two words, as center_wx, have no one spelling in LaTeX
    [
        (name, form)
        for name in WRITTEN
        for form in ("text", "latex", "mathml")
        if (name, form) != ("tennis_racket", "latex")
    ],
)
def test_what_derive_prints_is_right(name: str, form: str) -> None:
    mechanism = mq.textbook.load(name)
    assert mq.check(mechanism, getattr(mq.derive(mechanism), form)()).right


def test_order_factors_and_combinations_do_not_matter() -> None:
    mechanism = mq.textbook.load("cart_pole")
    first = "(M + m) x'' + l m cos(q) q'' - l m sin(q) q'^2 + c x' - F"
    second = "cos(q) x'' + l q'' + g sin(q)"
    assert mq.check(mechanism, f"{second} = 0\n{first} = 0").right
    assert mq.check(mechanism, f"{first} + 3 m ({second}) = 0\n2 ({second}) = {first}").right


def test_solved_for_accelerations_is_right() -> None:
    """The double pendulum of two rods, by Cramer's rule."""
    let = {
        "A": "(m1/3 + m2) l1^2",
        "B": "m2 l1 l2 cos(q1 - q2)/2",
        "D": "m2 l2^2/3",
        "u": "-m2 l1 l2 sin(q1 - q2) q2'^2/2 - (m1/2 + m2) g l1 sin q1",
        "w": "m2 l1 l2 sin(q1 - q2) q1'^2/2 - m2 g l2 sin(q2)/2",
    }
    text = "q1'' = (D u - B w)/(A D - B^2)\nq2'' = (A w - B u)/(A D - B^2)"
    assert mq.check(mq.textbook.load("double_pendulum"), text, let=let).right


def test_a_letter_for_another_coordinate_brings_its_rates() -> None:
    mechanism = mq.textbook.load("two_link_arm")
    text = mq.derive(mechanism).text().replace("q2", "(phi - q1)").replace("(phi - q1)'", "phi'")
    text = text.replace("phi''", "(phi'' - q1'')").replace("phi'^", "(phi' - q1')^")
    text = text.replace("q1' phi'", "q1' (phi' - q1')").replace("b phi'", "b (phi' - q1')")
    assert mq.check(mechanism, text, let=["phi = q1 + q2"]).right


@pytest.mark.parametrize(
    ("text", "outcome", "form"),
    [
        ("q' (m l^2 q''/3 + m g l sin(q)/2) = 0", "right except for form", "velocities"),
        ("sin(q) (l q''/3 + g sin(q)/2) = 0", "right except for form", "where sin(q) = 0"),
        ("l q'' q/3 + g sin(q) q/2 = 0", "right except for form", "where q = 0"),
        ("(2 + cos(q)) (l q''/3 + g sin(q)/2) = 0", "right", ""),
        ("(l q''/3 + g sin(q)/2)/sin(q) = 0", "right", ""),
        ("q'' + 3*9.81 sin(q)/2 = 0", "right except for form", "these values"),
        (
            "(q'' + 3 g/(2 l) sin q)^3 l^2/g^2 + q'' + 3 g/(2 l) sin q",
            "right except for form",
            "linear",
        ),
        ("q'' + 3 g/(2 l) cos q = 0", "wrong", ""),
        ("q'' + 3.001 g/(2 l) sin q = 0", "wrong", ""),
    ],
)
def test_verdicts(text: str, outcome: str, form: str) -> None:
    found = mq.check(mq.textbook.load("rigid_bar_pendulum"), text)
    assert found.outcome == outcome
    assert form in found.form
    assert found.right is (outcome == "right")


def test_a_factor_that_vanishes_is_named_with_its_equation() -> None:
    text = "(M + m) x'' + m l cos q q'' - m l sin q q'^2 + c x' = F\n"
    text += "cos(q)^2 x'' + l cos(q) q'' + g sin(q) cos(q) = 0"
    found = mq.check(mq.textbook.load("cart_pole"), text)
    assert [line.outcome for line in found.lines] == ["right", "right except for form"]
    assert found.form.startswith("multiplied by a factor that vanishes where cos(q) = 0")


def test_an_acceleration_that_is_zero_is_right() -> None:
    """A rolling disk does not leave its slope; its z'' comes out as rounding alone."""
    text = "3/2 m x'' = m g sin(alpha)\nR turn'' = x''\nz'' = 0"
    assert mq.check(mq.textbook.load("rolling_disk"), text).right


def test_two_accelerations_that_are_equal_say_something() -> None:
    assert mq.check(mq.textbook.load("free_particle"), "x'' = y'' = 0, z'' = -g").right


def test_one_of_two_equations_is_incomplete() -> None:
    found = mq.check(mq.textbook.load("cart_pole"), "cos(q) x'' + l q'' + g sin(q) = 0")
    assert found.outcome == "incomplete"
    assert found.form == "1 of 2 equations missing"


def test_equal_masses_of_the_catalogue_are_not_taken_for_one_another() -> None:
    mechanism = mq.textbook.load("double_pendulum")
    right = mq.derive(mechanism).text()
    assert not mq.check(mechanism, right.replace("3 m2", "3 m1")).right


def test_a_wrong_answer_says_where_and_how_much() -> None:
    found = mq.check(mq.textbook.load("rigid_bar_pendulum"), "q'' + g/(2 l) sin q = 0")
    assert found.at is not None
    assert set(found.at) == {"g", "l", "q"}
    assert found.worst > 1e-2
    data = json.loads(found.to_json())
    assert data["outcome"] == "wrong"
    assert data["states"] == found.states >= 20
    assert "WRONG" in str(found)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "empty"),
        ("q'' + (3 g", "( is not closed"),
        ("q'' + 3) = 0", ") was not opened"),
        ("q'' + * 3 = 0", "'*' is not expected here"),
        ("q'' = sin q^2", "ambiguous; write sin(q)^2 or sin(q^2)"),
        ("q'' + J sin q", "unknown letter 'J'; the letters of this system are g, l, m"),
        ("q'' + L sin q", "did you mean 'l'?"),
        ("q'' + 3 g/(2 l) sin = 0", "expected an argument of sin"),
        ("q'' + |q|", "write abs"),
        ("q'' + x.diff(t)", "unknown letter"),
        ("__import__('os').system('true')", "'_' has no meaning here"),
        ("q° = 0", "write it behind a number, as in q = 30°"),
        ("open('/etc/passwd').read()", "has no meaning here"),
        ("exec(q)", "unknown letter 'exec'"),
        ("[[q, 1], [2]]", "rows of one length"),
        ("[[q'', 1], [2, 3]] = 0", "got a matrix"),
        ("q''/(q - q) = 0", "has a value at 0 of"),
        ("2^2^2^2^2^2^2 = q''", "powers of powers"),
        ("q^1000 = q''", "exponent of at most"),
        ("(" * 200 + "q" + ")" * 200, "nested more than"),
        ("q" * 30_000, "at most 20,000 characters"),
        (r"\frac{q''}", "expected two arguments in braces"),
        ("<math><mi>q</mi><mlabeledtr/></math>", "element 'mlabeledtr'"),
        ("<math><mi>q</math>", "MathML cannot be read"),
        ("(q' q'') ' = 0", "time derivative"),
    ],
)
def test_what_cannot_be_read_is_refused_with_its_place(text: str, message: str) -> None:
    with pytest.raises(mq.FormulaError) as caught:
        mq.check(mq.textbook.load("rigid_bar_pendulum"), text)
    assert message in str(caught.value)


def test_an_error_points_at_its_place() -> None:
    with pytest.raises(mq.FormulaError) as caught:
        mq.check(mq.textbook.load("rigid_bar_pendulum"), "q'' = 0\n3 q'' + k q = z")
    error = caught.value
    assert (error.line, error.column, error.unknown) == (2, 9, ("k", "z"))
    assert str(error).endswith("3 q'' + k q = z\n          ^")


@pytest.mark.parametrize(
    ("let", "message"),
    [
        (["J"], "expected LETTER = FORMULA"),
        (["m = 3"], "letter of the system already"),
        (["J = 2 = 3"], "expected one formula after J ="),
        (["J = I w"], "unknown letters"),
    ],
)
def test_definitions_are_checked(let: list[str], message: str) -> None:
    with pytest.raises(mq.FormulaError, match=message):
        mq.check(mq.textbook.load("rigid_bar_pendulum"), "J q'' = 0", let=let)


def test_definitions_are_a_list_and_questions_are_known() -> None:
    mechanism = mq.textbook.load("rigid_bar_pendulum")
    with pytest.raises(mq.InputError, match="list of definitions"):
        mq.check(mechanism, "q'' = 0", let="J = 3")
    with pytest.raises(mq.UnknownNameError, match="question"):
        mq.check(mechanism, "q'' = 0", ask="weather")


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("cart_pole", "m g l (1 s)"),
        ("simple_pendulum", "1/2 m l^2 q'^2W"),
        ("cart_pole", r"3   \boxed{ W and \boxed{"),
    ],
)
def test_a_unit_in_a_wrong_answer_is_no_part_of_the_state(name: str, text: str) -> None:
    judgement = mq.check(mq.textbook.load(name), text)
    assert judgement.outcome == "wrong"
    assert judgement.at is not None
    assert not any(letter.startswith("[") for letter in judgement.at)


def bar_in_numbers(**options: object) -> mq.Mechanism:
    """A bar of 3 kg and 2 m under 10 m/s², all of them numbers."""
    return mq.Mechanism(
        "bar",
        (mq.Body("ground"), mq.Body("bar", mq.rod(3.0, 2.0, (0, 0, -1)))),
        (mq.Revolute("pin", "ground", "bar", axis=(0, -1, 0), coordinate="q"),),
        gravity=(0.0, 0.0, -10.0),
        **options,  # type: ignore[arg-type]  # of a mechanism
    )


def test_numbers_may_stand_for_quantities_where_a_mechanism_has_no_letters() -> None:
    """4 and 30 are kg·m² and N·m here, and 2 in sin(2 t) is in rad/s."""
    assert mq.check(bar_in_numbers(), "4 q'' + 30 sin(q) = 0").right
    assert not mq.check(bar_in_numbers(), "4 q'' + 30 q = 0").right
    push = mq.JointForce("drive", "pin", 6 * mq.sin(2 * mq.time()))
    driven = bar_in_numbers(forces=(push,))
    assert mq.check(driven, "2 q'' + 15 sin(q) - 3 sin(2 t) = 0").right
    assert mq.check(driven, "2 q'' + 15 sin(q) = 6 sin(t) cos(t)").right


def test_a_number_in_a_law_of_time_has_a_unit_beside_letters_too() -> None:
    cart = mq.textbook.load("cart_pole")
    push = mq.JointForce("shaker", "slide", mq.sin(2 * mq.time()))
    shaken = replace(cart, forces=(*cart.forces, push))
    right = "(M + m) x'' + m l cos(q) q'' - m l sin(q) q'^2 + c x' = F + sin(2 t)"
    assert mq.check(shaken, f"{right}; cos(q) x'' + l q'' + g sin(q) = 0").right
    assert "units" in str(mq.check(cart, "(M + m) x'' + m l cos(q) q'' + c x' = F + 2 l q^2"))
