"""Linear equations in letters: the textbook's own, and those of the numeric matrices."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

import mecanique as mq
from mecanique.derivation.scalars.evaluation import evaluate
from mecanique.derivation.scalars.series import Series
from mecanique.motion import equilibria, linearize

RESTING = (
    "acrobot",
    "bar_chain",
    "bars_and_springs",
    "bead_on_hoop",
    "cart_pole",
    "compound_pendulum",
    "coupled_pendulums",
    "double_pendulum",
    "elastic_pendulum",
    "foucault_pendulum",
    "furuta_pendulum",
    "gyroscope",
    "n_link_pendulum",
    "rotating_plate",
    "shear_building",
    "simple_pendulum",
    "tennis_racket",
)


def lines(name: str, **parameters: float) -> list[str]:
    return [
        equation.text() for equation in linearize(mq.textbook.load(name, **parameters)).equations
    ]


def test_the_rod_pendulum_is_equation_1_20() -> None:
    small = linearize(mq.textbook.load("rigid_bar_pendulum"))
    assert [equation.text() for equation in small.equations] == ["q'' + 3 g q/(2 l) = 0"]
    assert small.text().splitlines() == [
        "Small motions about the equilibrium with all coordinates zero:",
        "q'' + 3 g q/(2 l) = 0",
        "omega = sqrt(3 g/(2 l))",
    ]
    assert small.latex().splitlines()[1:3] == [
        "\\ddot{q} + \\frac{3 g q}{2 l} &= 0 \\\\",
        "\\omega &= \\sqrt{\\frac{3 g}{2 l}}",
    ]
    assert small.mathml().count("<math") == 2
    assert "<msqrt>" in small.mathml()


def test_the_inverted_pendulum_has_no_frequency() -> None:
    small = linearize(mq.textbook.load("rigid_bar_pendulum"), at={"q": np.pi})
    assert "about the equilibrium q = pi; the coordinates below are deviations" in small.text()
    assert [equation.text() for equation in small.equations] == ["q'' - 3 g q/(2 l) = 0"]
    assert small.symbolic.square is None
    assert "omega" not in small.text()


def test_the_two_blocks_are_equations_of_the_chapter() -> None:
    small = linearize(mq.textbook.load("two_blocks"))
    np.testing.assert_allclose(
        small.q, 0.0, rtol=0, atol=1e-14
    )  # the harmonic force is no part of an equilibrium
    text = small.text()
    assert "m1 q1'' + (k1 + k2) q1 - k2 q2 = 0" in text
    assert "m2 q2'' + k2 (q2 - q1) = F" in text
    assert "K = [[k1 + k2, -k2], [-k2, k2]]" in text


def test_the_bars_and_springs_have_the_equation_of_example_1_2() -> None:
    # (17/4) m q'' + 9 k q = 0
    assert (
        lines("bars_and_springs") == lines("bars_and_springs_small") == ["q'' + 36 k q/(17 m) = 0"]
    )


def test_damping_and_a_force_are_shown() -> None:
    small = linearize(mq.textbook.load("base_excited_mass"), at={"u": 0.0})
    assert [equation.text() for equation in small.equations] == [
        "u'' + c u'/m + k u/m = X W^2 sin(W t)"
    ]
    assert small.text().splitlines()[-2:] == ["omega = sqrt(k/m)", "zeta = c/(2 sqrt(m k))"]
    assert small.symbolic.square is not None
    square = evaluate(small.symbolic.square, small.mechanism.values)
    assert np.sqrt(square) == pytest.approx(small.frequencies[0], rel=1e-12)


def test_coordinates_that_are_no_multiple_of_pi_stay_letters() -> None:
    small = linearize(mq.textbook.load("elastic_pendulum"))
    assert "r = r_0, r_0 = 1.33333333" in small.text()
    assert [equation.text() for equation in small.equations] == [
        "m r'' + k r = 0",
        "r_0 theta'' + g theta = 0",
    ]


def test_a_letter_that_is_taken_gets_another_zero() -> None:
    names = (("m", 1.0), ("k", 30.0), ("r_0", 1.0))
    m, k, free = (mq.Parameter(symbol, value) for symbol, value in names)
    bodies = (mq.Body("ground"), mq.Body("guide"), mq.Body("bob", mq.particle(m)))
    pin = mq.Revolute("pin", "ground", "guide", axis=(0, -1, 0), coordinate="theta")
    slide = mq.Prismatic("slide", "guide", "bob", axis=(0, 0, -1), coordinate="r")
    spring = mq.JointSpring("spring", "slide", k, free)
    swinging = mq.Mechanism(
        "swinging", bodies, (pin, slide), forces=(spring,), parameters=(m, k, free)
    )
    small = linearize(swinging, at={"r": 1.0 + 9.81 / 30, "theta": 0.0})
    assert "r = r_00, r_00 = 1.327" in small.text()


def test_an_equilibrium_of_no_consequence_is_not_called_zero() -> None:
    bodies = (mq.Body("ground"), mq.Body("bob", mq.particle(2.0)))
    slide = mq.Prismatic("slide", "ground", "bob", axis=(0, 0, -1), coordinate="z")
    spring = mq.JointSpring("spring", "slide", 100.0, 0.3)
    small = linearize(mq.Mechanism("hanging", bodies, (slide,), forces=(spring,)))
    first, *_ = small.text().splitlines()
    assert first == (
        "Small motions about the equilibrium; the coordinates below are deviations from it:"
    )


def test_a_rotating_hoop_lifts_the_bead_where_its_letter_says() -> None:
    mechanism = mq.textbook.load("bead_on_hoop")
    lifted = [e for e in equilibria(mechanism) if 0.1 < abs(e.q[0]) < 3]
    p = mechanism.values
    if p["W"] ** 2 * p["R"] <= p["g"]:
        mechanism = mechanism.replace(W=float(np.sqrt(2 * p["g"] / p["R"])))
        lifted = [e for e in equilibria(mechanism) if 0.1 < abs(e.q[0]) < 3]
    # cos theta = g/(R W²), and the small motion's frequency is W sin theta
    p = mechanism.values
    angle = np.arccos(p["g"] / (p["R"] * p["W"] ** 2))
    assert len(lifted) == 2
    for rest in lifted:
        assert abs(rest.q[0]) == pytest.approx(angle, rel=1e-9)
        assert rest.linearization.frequencies[0] == pytest.approx(p["W"] * np.sin(angle), rel=1e-9)
        symbolic = rest.linearization.symbolic
        values = {**p, **symbolic.letters}
        assert symbolic.square is not None
        assert np.sqrt(evaluate(symbolic.square, values)) == pytest.approx(
            p["W"] * np.sin(angle), rel=1e-9
        )


@pytest.mark.parametrize("name", RESTING)
def test_letters_and_numbers_are_the_same_matrices_at_every_equilibrium(name: str) -> None:
    mechanism = mq.textbook.load(name)
    for rest in equilibria(mechanism, starts=12):
        small = rest.linearization
        symbolic = small.symbolic
        values = {**mechanism.values, **symbolic.letters}
        for rows, numbers in (
            (symbolic.matrices.M, small.M),
            (symbolic.matrices.C, small.C),
            (symbolic.matrices.K, small.K),
        ):
            scale = np.abs(numbers).max() + np.abs(small.K).max() + 1e-12
            np.testing.assert_allclose(_numbers(rows, values), numbers, rtol=0, atol=1e-12 * scale)


def _numbers(rows: Sequence[Sequence[Series]], values: dict[str, float]) -> np.ndarray:
    every = {**values, "F": 0.0, "tau": 0.0, "ag": 0.0, "t": 0.0}
    return np.array([[float(evaluate(entry, every)) for entry in row] for row in rows])


def test_what_is_no_equilibrium_is_refused() -> None:
    pendulum = mq.textbook.load("rigid_bar_pendulum")
    with pytest.raises(
        mq.DerivationError,
        match=r"do not balance there: they add up to .*; expected an equilibrium",
    ):
        _ = linearize(pendulum, at={"q": 0.5}).equations
    with pytest.raises(mq.DerivationError, match="not about a state in motion"):
        linearize(pendulum, v={"q": 0.5}).text()
    with pytest.raises(mq.DerivationError, match="no constant coefficients: K depends on 't'"):
        linearize(mq.textbook.load("kapitza_pendulum"), at={"q": 0.0}).text()


def test_an_arm_whose_vertical_axes_are_so_but_for_a_digit_is_linearized_in_letters() -> None:
    """UR5's file has 1.570796325 for π/2; it hangs straight down, and three joints turn freely."""
    near = {"shoulder_lift_joint": 1.5, "wrist_1_joint": -1.5}
    small = mq.linearize(mq.read_urdf(mq.robot("ur5_robot")), near=near)
    assert (small.frequencies[:3] == 0).all()
    assert small.frequencies[3] > 0.1
    assert np.isnan(small.damping[:3]).all()
    stiffness = _numbers(small.symbolic.matrices.K, dict(small.mechanism.values))
    np.testing.assert_allclose(stiffness, small.K, rtol=1e-6, atol=1e-6)
