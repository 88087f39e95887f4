"""Small deviations from a steady motion in letters, against the exact equations linearized by hand.

Of the rolling coin (Neimark & Fufaev, Dynamics of Nonholonomic Systems, ch. II) at spin' = u:
yaw'' + 2 u lean' = 0 and 5 r lean'' - 6 r u yaw' - 4 g lean = 0, times m r²/4 and m r/4.
"""

from __future__ import annotations

import re
from dataclasses import replace
from math import sqrt

import pytest

import mecanique as mq
from mecanique.derivation.printing.equations import expression
from mecanique.derivation.steady import steady_letters
from mecanique.derivation.symbolic.derivation import Matrix


def entries(rows: Matrix) -> list[list[str]]:
    return [[expression(entry).text() for entry in row] for row in rows]


@pytest.mark.parametrize(
    ("rate", "across", "back"),
    [
        (1.0, "m r^2/2", "-3 m r^2/2"),
        (-2.0, "-m r^2", "3 m r^2"),
        (1 / 3, "m r^2/6", "-m r^2/2"),  # a fraction, not its decimals
        (1.5e-9, "7.5e-10 m r^2", "-2.25e-09 m r^2"),  # and not nothing
    ],
)
def test_the_coin_has_the_matrices_of_its_exact_equations(
    rate: float, across: str, back: str
) -> None:
    coin = mq.textbook.load("rolling_coin")
    letters = steady_letters(coin, {}, {"spin": rate}, ("yaw", "lean"))
    nothing = [["0", "0"], ["0", "0"]]
    assert entries(letters.M) == [["m r^2/4", "0"], ["0", "5 m r^2/4"]]
    assert [*map(entries, letters.C)] == [nothing, [["0", across], [back, "0"]]]
    assert [*map(entries, letters.K)] == [[["0", "0"], ["0", "-m g r"]], nothing, nothing]


def test_coefficients_of_the_determinant_are_set_and_explained() -> None:
    coin = mq.textbook.load("rolling_coin")
    printed = steady_letters(coin, {}, {"spin": 1.0}, ("yaw", "lean")).latex()
    assert "$a_{4} \\lambda^{4} + a_{2} \\lambda^{2} = 0$" in printed
    assert "$a_{2}$, $a_{4}$}] coefficient of the determinant" in printed


def test_the_coin_is_written_out_with_its_motion_and_the_meaning_of_its_letters() -> None:
    coin = mq.textbook.load("rolling_coin")
    falling = steady_letters(coin, {}, {"spin": 1.0}, ("yaw", "lean")).text()
    lines = [re.sub(r"(?<=\S) {2,}", "  ", line) for line in falling.splitlines()]
    m, r = coin.values["m"], coin.values["r"]
    assert lines[-11:] == [
        "     M_11 yaw'' + u C1_12 lean' = 0",
        "     M_22 lean'' + u C1_21 yaw' + K0_22 g lean = 0",
        "",
        "8. Result",
        "   In matrices, with the numbers of the description: M q'' + u C1 q' + g K0 q = 0 for q = "
        "(yaw,",
        "   lean). Of deviations proportional to exp(lambda t), the determinant is a4 lambda^4 + "
        "a2 lambda^2",
        "   = 0. Below u_c, where a2 = 0, a deviation grows without oscillation (of a bicycle, "
        "capsize).",
        f"     M = [[{m * r**2 / 4:.5g}, 0], [0, {5 * m * r**2 / 4:.5g}]]",
        f"     C1 = [[0, {m * r**2 / 2:.5g}], [-{3 * m * r**2 / 2:.5g}, 0]]",
        f"     K0 = [[0, 0], [0, -{m * r:.5g}]]",
        f"     u_c = sqrt(M_11 K0_22 g/(C1_12 C1_21)) = {sqrt(coin.values['g'] / r / 3):.5g}",
    ]
    for line in (
        "  u  speed of the steady motion [rad/s]",
        "  g  acceleration of free fall [m/s²]",
        "    entries of the mass matrix",
        "  K0_22  entries of the matrices of the deviations",
        *("     z = r", "     x' = u r", "     spin' = u", "     lambda_rim_normal = m g"),
        *("     x' = r spin'", "     y' = r (u yaw - lean')"),
        *("     M_22 = 5 m r^2/4", "     C1_21 = -3 m r^2/2", "     K0_22 = -m r"),
    ):
        assert line in lines
    floating = replace(coin, gravity=(0.0, 0.0, 0.0))
    text = steady_letters(floating, {}, {"spin": 1.0}, ("yaw", "lean")).text()
    assert "     M_22 lean'' + u C1_21 yaw' = 0" in text.splitlines()
    assert "M q'' + u C1 q' = 0 for q = (yaw, lean)." in text
    assert "free fall" not in text
    assert "deviations" not in text.replace("small deviations", "")


def test_a_bicycle_ends_with_its_weave_and_capsize_speed() -> None:
    """Meijaard et al., Proc. R. Soc. A 463 (2007) 1955, sect. 7: 4.29238253634111 and 6.0242620153.

    The capsize speed is that at which the determinant of K vanishes (ibid., sect. 6).
    """
    bicycle = mq.textbook.load("whipple_bicycle")
    ride = steady_letters(bicycle, {}, {"x": 1.0}, ("roll", "steer"))
    text = ride.text()
    assert text.splitlines()[-2:] == [
        "     v_w = 4.2924",
        "     v_c = sqrt((K0_12^2 - K0_11 K0_22) g/(K0_11 K2_22 - K0_12 K2_12)) = 6.0243",
    ]
    said = " ".join(text.split())
    assert "Below v_w, where a3 a2 a1 - a4 a1^2 - a3^2 a0 = 0, an oscillation grows" in said
    assert "Above v_c, where a0 = 0, a deviation grows without oscillation" in said
    # with the heading to the left and the steer to the right (ibid., sect. 4 and 6)
    assert "yaw' = -(v steer + c steer') cos(tilt)/w" in said
    assert "lambda_front_contact_normal = (mB xB + mH xH + mF w) g/w" in said
    assert "v_{w} &= 4.2924" in ride.latex()
    assert "<msqrt>" in ride.mathml()
    # with the trail of a castor, both frames of the benchmark fall over at any speed
    fallen = steady_letters(bicycle.replace(c=-0.2), {}, {"x": 1.0}, ("roll", "steer"))
    assert "v_c" not in fallen.text()


def test_matrices_with_signs_are_not_broken_in_latex() -> None:
    """A row was broken before the minus of an entry, within the matrix."""
    bicycle = mq.textbook.load("whipple_bicycle")
    text = steady_letters(bicycle, {}, {"x": 1.0}, ("roll", "steer")).latex()
    for matrix in re.findall(r"\\begin\{bmatrix\}.*?\\end\{bmatrix\}", text, re.DOTALL):
        assert "&=" not in matrix
        assert "\\qquad" not in matrix
    assert text.count("\\begin{bmatrix}") == 4
    assert "$M \\ddot{q} + v C_{1} \\dot{q}" in text.replace("\n", " ")
