"""Energies, momenta, mass matrices, frequencies, equilibria, reactions, conserved quantities."""

from __future__ import annotations

import pytest

import mecanique as mq

_COLUMN = (
    "1/2 k (q1^2 + (q2-q1)^2 + (q3-q2)^2 + (q4-q3)^2) + P l (cos q1 + cos q2 + cos q3 + cos q4)"
)
ROD = "rigid_bar_pendulum"

JUDGED = (
    (ROD, "T = m l^2/6 q'^2", "kinetic energy", "right", ""),
    (ROD, "1/2 m l^2/12 q'^2", "kinetic energy", "wrong", "4 times as large"),
    (ROD, "m l^2/3 q'^2", "kinetic energy", "wrong", "twice what it should be"),
    (ROD, "V = m g l/2 (1 - cos q)", "potential energy", "right", ""),
    (ROD, "V = m g l/2 cos q", "potential energy", "wrong", "the sign of the term"),
    (ROD, "L = m l^2/6 q'^2 + m g l/2 cos q", "Lagrangian", "right", ""),
    (ROD, "E = m l^2/6 q'^2 - m g l/2 cos q", "energy", "right", ""),
    ("cart_pole", "[[M + m, m l cos q], [m l cos q, m l^2]]", "mass matrix", "right", ""),
    ("cart_pole", "[M + m, m l cos q; m l cos q, m l^2]", "mass matrix", "right", ""),
    (
        "cart_pole",
        r"\begin{pmatrix} M + m & m l \cos q \\ m l \cos q & m l^2 \end{pmatrix}",
        "mass matrix",
        "right",
        "",
    ),
    ("cart_pole", "[[M+m, m l sin q], [m l cos q, m l^2]]", "mass matrix", "wrong", "be cos"),
    ("cart_pole", "Matrix([[M, 0], [0, m*l**2]])", "mass matrix", "wrong", "should be M + m"),
    (
        "cart_pole",
        "[[m l^2, m l cos q], [m l cos q, M + m]]",
        "mass matrix",
        "right except for form",
        "",
    ),
    ("cart_pole", "p_x = (M + m) x' + m l q' cos q", "momentum of x", "right", ""),
    ("cart_pole", "(M + m) x' + m l q' sin q", "momentum of x", "wrong", "should be cos"),
    (ROD, "m l^2/6 q'^2 - m g l/2 cos q = E", "conserved quantity", "right", ""),
    (ROD, "m l^2/3 q'^2 - m g l/2 cos q = E", "conserved quantity", "wrong", ""),
    ("spherical_pendulum", "m l^2 sin(theta)^2 phi'", "conserved quantity", "right", ""),
    (ROD, "m g l", "conserved quantity", "wrong", "it does not depend on the motion"),
    (ROD, "omega = sqrt(3 g/(2 l))", "frequency", "right", ""),
    (ROD, "omega^2 = 3 g/(2 l)", "frequency", "right", ""),
    (ROD, "f = sqrt(3 g/(2 l))/(2 pi)", "frequency", "right", ""),
    (ROD, "T = 2 pi sqrt(2 l/(3 g))", "frequency", "right", ""),
    (ROD, "omega = sqrt(2 g/(3 l))", "frequency", "wrong", ""),
    ("two_blocks", "omega = sqrt(k1/m1)", "frequency", "wrong", ""),
    ("cart_pole", "omega = 0", "frequency", "error", "is damped"),
    ("spherical_pendulum", "omega = sqrt(g/l)", "frequency", "error", "no meaning"),
    ("bead_on_hoop", "theta = acos(g/(R W^2))", "equilibrium", "incomplete", "π is missing"),
    ("bead_on_hoop", "theta = asin(g/(R W^2))", "equilibrium", "wrong", ""),
    (ROD, "R_pin_n = m g cos q + m l/2 q'^2", "reaction", "right", ""),
    (ROD, "R_pin_n = m g cos q - m l/2 q'^2", "reaction", "wrong", "the sign of the term"),
    (ROD, "m g cos q", "reaction", "error", "expected an equation for one of R_pin_n"),
    (ROD, "sin(q) = 0", "equilibrium", "right", ""),
    (ROD, "q + 1 = 0", "equilibrium", "wrong", ""),
    (ROD, "g + 1 = 0", "equilibrium", "error", "expected COORDINATE = FORMULA"),
    (ROD, "q^2 + 1 = 0", "equilibrium", "error", "the condition holds at no q"),
    ("bead_on_hoop", "cos(theta) = g/(R W^2)", "equilibrium", "incomplete", "= 0 is missing"),
    ("bead_on_hoop", "tan(theta) = 0", "equilibrium", "incomplete", "theta = 1.02 (for "),
    ("bead_on_hoop", "cos(theta) = 2 g/(R W^2)", "equilibrium", "wrong", ""),
    (ROD, "R_pin_n = m g cos q", "reaction", "wrong", "the term m l q'^2/2 is missing"),
    (
        "cart_pole",
        "T = (M + m)/2 x'^2 + m/2 l^2 q'^2",
        "kinetic energy",
        "wrong",
        "the term m l cos(q) x' q' is missing",
    ),
    (
        "cart_pole",
        "L = (M + m)/2 x'^2 + m l x' q' cos q + m/2 l^2 q'^2",
        "Lagrangian",
        "wrong",
        "the potential energy is missing",
    ),
    ("governor", "k/2 (s - a)^2", "potential energy", "wrong", "gravity is missing"),
    ("cart_pole", "p_1 = (M + m) x' + m l q' cos q", "momentum of x", "right", ""),
    ("kepler_orbit", "A = r^2 phi'/2", "conserved quantity", "right", ""),
    ("heavy_top", "p_psi = psi' + phi' cos(theta)", "conserved quantity", "right", ""),
    ("simple_pendulum", "T = 2π√(l/g)", "frequency", "right", ""),
    (
        "simple_pendulum",
        "sqrt(l/g)",
        "frequency",
        "wrong",
        "is in s, the quantity in question in 1/s",
    ),
    ("cart_pole", "V = -m g l cos q - F x", "potential energy", "right", ""),
    ("cart_pole", "V = -m g l cos q", "potential energy", "right", ""),
    ("cart_pole", "V = F x - m g l cos q", "potential energy", "wrong", "sign of the term 'F x'"),
    (
        "cart_pole",
        "1/2 (M+m) x'^2 + m l x' q' cos q + m l^2 q'^2/2 + m g l cos q + F x",
        "Lagrangian",
        "right",
        "",
    ),
    ("cart_pole", "p_x^2/M - m g l cos q - F x", "Hamiltonian", "wrong", ""),
    ("bar_chain", f"V = {_COLUMN} - C q4", "potential energy", "right", ""),
    ("bar_chain", f"V = {_COLUMN}", "potential energy", "right", ""),
    ("bar_chain", f"V = {_COLUMN} - 2 C q4", "potential energy", "wrong", "'- 2 C q4' is twice"),
    (
        "tennis_racket",
        "m (a^2 center_wx^2 + b^2 center_wy^2 + c^2 center_wz^2)/24",
        "kinetic energy",
        "wrong",
        "the lengths along their axes, not across them",
    ),
    (
        "cart_pole",
        "G(s) = 1/((M + m) s^2 + c s)",
        "transfer function of x from F",
        "wrong",
        "it is that with q held at rest",
    ),
    (ROD, "2 pi sqrt(2 l/(3 g))", "frequency", "wrong", "a period is taken for a frequency"),
    (ROD, "T = sqrt(3 g/(2 l))", "period", "wrong", "a period is taken for a frequency"),
    ("simple_pendulum", "m l q'^2/2", "kinetic energy", "wrong", "the quantity in question in N·m"),
    ("simple_pendulum", "p = m l q'", "momentum of q", "wrong", "'p' is in N·m·s"),
    (
        "coupled_pendulums",
        r"\omega_1^2 = g/l \\ \omega_2^2 = g/l + \frac{2 k a^2}{m l^2}",
        "frequency",
        "right",
        "",
    ),
    ("cart_pole", "M + m", "mass matrix", "error", "expected a matrix"),
    ("cart_pole", "[[M + m]]", "mass matrix", "error", "expected a matrix"),
    ("cart_pole", "x'", "momentum", "error", "expected the coordinate"),
    ("cart_pole", "x'", "momentum of z", "error", "unknown coordinate"),
    ("bricard_linkage", "0", "kinetic energy", "error", "no closed form"),
)


@pytest.mark.parametrize(("name", "text", "ask", "outcome", "words"), JUDGED)
def test_a_quantity_is_judged(name: str, text: str, ask: str, outcome: str, words: str) -> None:
    mechanism = mq.textbook.load(name)
    if outcome == "error":
        with pytest.raises(mq.InputError, match=words):
            mq.check(mechanism, text, ask)
        return
    found = mq.check(mechanism, text, ask)
    assert found.outcome == outcome, str(found)
    told = [*(cause.text for cause in found.causes[:2]), found.form]
    assert words in " ".join(told), str(found)
    assert found.asked == ask


def test_one_of_two_frequencies_is_incomplete() -> None:
    mechanism = mq.textbook.load("two_blocks")
    both = [
        f"omega^2 = ((k1 + k2)/m1 + k2/m2 {sign} sqrt(((k1 + k2)/m1 - k2/m2)^2 + 4 k2^2/(m1 m2)))/2"
        for sign in "+-"
    ]
    assert mq.check(mechanism, "\n".join(both), "frequency").right
    found = mq.check(mechanism, both[0], "frequency")
    assert found.outcome == "incomplete"
    assert found.form == "1 of 2 frequencies missing"


@pytest.mark.parametrize(
    "name", ["four_bar_linkage", "chaplygin_sleigh", "rolling_coin", "coupled_pendulums"]
)
@pytest.mark.parametrize("form", ["text", "latex", "mathml"])
def test_equations_with_multipliers_and_lengths_are_right(name: str, form: str) -> None:
    mechanism = mq.textbook.load(name)
    found = mq.check(mechanism, getattr(mq.derive(mechanism), form)())
    assert found.right, str(found)


def test_of_a_closed_mechanism_what_is_missing_is_counted() -> None:
    mechanism = mq.textbook.load("four_bar_linkage")
    lines = mq.derive(mechanism).text().splitlines()
    assert mq.check(mechanism, "\n".join(lines[:3])).right
    found = mq.check(mechanism, "\n".join(lines[:2]))
    assert found.outcome == "incomplete"
    wrong = lines[0].replace(" g ", " 2 g ", 1)
    assert wrong != lines[0]
    assert mq.check(mechanism, "\n".join([wrong, *lines[1:3]])).outcome == "wrong"


@pytest.mark.parametrize(
    ("system", "answer", "outcome"),
    [
        ("rack_and_pinion", "N_teeth = abs(F_teeth) sin(alpha)", "right"),
        ("rack_and_pinion", "N_teeth = abs(D/r - m x''/2) tan(alpha)", "right"),
        ("rack_and_pinion", "R_axle_z = m g - abs(F_teeth) sin(alpha)", "right"),
        ("rack_and_pinion", "R_slide_z = M g", "wrong"),
        ("rack_and_pinion", "N_teeth = N_teeth", "wrong"),
        ("planetary_gear", "N_inner = abs(F_inner) sin(alpha)", "right"),
        ("planetary_gear", "R_sun_axle_x = 0", "wrong"),
        ("rolling_disk", "lambda_contact_normal = m g cos(alpha)", "right"),
    ],
)
def test_reactions_where_wheels_part_are_judged(system: str, answer: str, outcome: str) -> None:
    """The separating force |F| sin(alpha) of meshing teeth belongs to their reactions."""
    assert mq.check(mq.textbook.load(system), answer, "reaction").outcome == outcome


TUFILLARO = (
    "r^2 theta' (r' cos(theta/2) - r theta'/2 sin(theta/2)) + g r^2 sin(theta/2) cos(theta/2)^2"
)


@pytest.mark.parametrize(
    ("system", "values", "ask", "answer", "outcome"),
    [
        # Tufillaro, Abbott & Griffiths, Am. J. Phys. 52 (1984) 895: M = 3 m
        ("swinging_atwood_machine", {"M": 3, "m": 1}, "conserved quantity", TUFILLARO, "right"),
        ("base_excited_mass", {"c": 0}, "frequency", "sqrt(k/m)", "right"),
        ("simple_pendulum", {"l": 2}, "frequency", "sqrt(g/2)", "right"),
        ("simple_pendulum", {"l": 2}, "frequency", "sqrt(g/3)", "wrong"),
        ("simple_pendulum", {"l": 2}, "equation of motion", "2 q'' + g sin q = 0", "right"),
        ("simple_pendulum", {"l": 2}, "equation of motion", "l q'' + g sin q = 0", "right"),
        ("simple_pendulum", {"l": 2}, "equation of motion", "m q'' + g sin q = 0", "wrong"),
        ("cart_pole", {"m": 2}, "mass matrix", "[[M + 2, 2 l cos q], [2 l cos q, 2 l^2]]", "right"),
    ],
)
def test_given_values_may_be_written_as_numbers(
    system: str, values: dict[str, float], ask: str, answer: str, outcome: str
) -> None:
    """What the question gives is no deviation of form; letters that are written still vary."""
    mechanism = mq.textbook.load(system, **values)
    assert mq.check(mechanism, answer, ask, given=values).outcome == outcome


@pytest.mark.parametrize(
    ("ask", "answer"),
    [("frequency", "3.863 rad/s"), ("equation of motion", "q'' + 17.415 sin q = 0")],
)
def test_digits_that_are_exchanged_are_a_cause(ask: str, answer: str) -> None:
    judged = mq.check(mq.textbook.load(ROD), answer, ask, given=("g", "l", "m"))
    assert "two digits of" in judged.causes[0].text


@pytest.mark.parametrize("number", ["1 9.81", "(1 9.81)", "9.81²", "1.5 9.81"])
def test_a_product_of_numbers_has_no_digits_to_exchange(number: str) -> None:
    judged = mq.check(mq.textbook.load("simple_pendulum"), f"m g l ({number} - q)")
    assert judged.outcome == "wrong"
    assert not any("two digits of" in cause.text for cause in judged.causes)


def test_values_that_are_not_given_are_a_matter_of_form() -> None:
    pendulum = mq.textbook.load("simple_pendulum", l=2)
    assert mq.check(pendulum, "sqrt(g/2)", "frequency").outcome == "right except for form"
    damped = mq.textbook.load("base_excited_mass", c=0)
    with pytest.raises(mq.InputError, match="the mechanism is damped"):
        mq.check(damped, "sqrt(k/m)", "frequency")


def test_a_period_is_asked_for() -> None:
    pendulum = mq.textbook.load("simple_pendulum")
    assert mq.check(pendulum, "2 pi sqrt(l/g)", "period").right
    assert mq.check(pendulum, "T = 2 pi sqrt(l/g)", "period").right
    first = mq.check(pendulum, "2 pi sqrt(g/l)", "period").causes[0]
    assert "inverted" in first.text
    bar = mq.textbook.load("rigid_bar_pendulum")
    wrong = mq.check(bar, "2 pi sqrt(l/g)", "period")
    assert wrong.causes[0].text.startswith("'rod' is taken for a point mass")
