"""Loops replaced by coordinates in closed form give the equations of the loop itself."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest

from mecanique import textbook
from mecanique.derivation import derive
from mecanique.derivation.equations import Equations
from mecanique.derivation.reduction import reduce_loops
from mecanique.errors import InputError
from mecanique.model import Coordinates, Mechanism, coordinate
from mecanique.reference import Reference, assemble
from mecanique.verification import verify

ANGLES = (-2.9, -2.0, -0.4, 0.0, 0.7, 1.5, 3.0)


def slider_crank() -> Mechanism:
    """The catalogue's slider-crank without its loop: rod and slider follow the crank, x > 0."""
    from sympy import asin, cos, sin, sqrt

    loop = textbook.load("slider_crank")
    r, length = loop.parameters[:2]
    theta = coordinate("theta")
    follow = {
        "beta": -theta - asin(r * sin(theta) / length),
        "x": r * cos(theta) + sqrt(length**2 - r**2 * sin(theta) ** 2),
    }
    return replace(
        loop, name="slider_crank_tree", loops=(), coordinates=Coordinates(("theta",), follow)
    )


def crank_state(theta: float, rate: float) -> tuple[Mapping[str, float], Mapping[str, float]]:
    """All positions and velocities of the closed slider-crank."""
    r, length = 0.5, 1.2
    run = np.sqrt(length**2 - (r * np.sin(theta)) ** 2)
    swing = -r * np.cos(theta) * rate / run
    q = {
        "theta": theta,
        "beta": -theta - np.arcsin(r * np.sin(theta) / length),
        "x": r * np.cos(theta) + run,
    }
    v = {
        "theta'": rate,
        "beta'": swing - rate,
        "x'": -r * np.sin(theta) * rate * (1 + r * np.cos(theta) / run),
    }
    return q, v


@pytest.fixture(scope="module")
def crank() -> Equations:
    return derive(slider_crank())


@pytest.mark.parametrize("theta", ANGLES)
@pytest.mark.parametrize("rate", [0.0, 1.3, -4.0])
def test_the_symbolic_slider_crank_turns_as_its_loop_does(
    crank: Equations, theta: float, rate: float
) -> None:
    assert crank.symbolic
    q, v = crank_state(theta, rate)
    own = crank.acceleration(np.array([theta]), np.array([rate]))[0]
    tree = Reference(slider_crank()).acceleration({"theta": theta}, {"theta'": rate})[0]
    loop = Reference(textbook.load("slider_crank")).acceleration(q, v)[0]
    assert own == pytest.approx(tree, rel=1e-10, abs=1e-10)
    assert own == pytest.approx(loop, rel=1e-10, abs=1e-10)


def test_its_mass_matrix_is_that_of_the_book(crank: Equations) -> None:
    theta = np.array(ANGLES)
    run = np.sqrt(1.2**2 - (0.5 * np.sin(theta)) ** 2)
    way = -0.5 * np.sin(theta) * (1 + 0.5 * np.cos(theta) / run)
    np.testing.assert_allclose(
        crank.mass_matrix(theta[:, None])[:, 0, 0], 2.0 * 0.5**2 / 3 + way**2, rtol=1e-12, atol=0
    )


def test_its_parameters_stay_letters(crank: Equations) -> None:
    assert {"r", "l", "m1", "m2", "theta"} <= {str(letter) for letter in crank.M.free_symbols}


def test_the_slider_crank_without_its_loop_is_verified() -> None:
    verdict = verify(slider_crank(), samples=30)
    assert verdict.agrees, str(verdict)


def test_the_symbolic_parallelogram_moves_as_its_loop_does() -> None:
    tree = textbook.load("bars_and_springs")
    loop = replace(textbook.load("bars_and_springs_loop"), parameters=tree.parameters)
    equations, closed, reference = derive(tree), Reference(loop), Reference(tree)
    assert equations.symbolic
    for angle in (-1.2, -0.5, 0.0, 0.4, 1.1):
        for rate in (0.0, 1.7, -3.0):
            q, v = 2.0 * np.sin(angle), 2.0 * np.cos(angle) * rate
            a = closed.acceleration(
                {"alpha": angle, "delta": angle, "gamma": -angle},
                {"alpha'": rate, "delta'": rate, "gamma'": -rate},
            )[0]
            expected = 2.0 * (np.cos(angle) * a - np.sin(angle) * rate**2)
            own = equations.acceleration(np.array([q]), np.array([v]))[0]
            assert own == pytest.approx(expected, rel=1e-10, abs=1e-10)
            assert own == pytest.approx(
                reference.acceleration({"q": q}, {"q'": v})[0], rel=1e-10, abs=1e-10
            )


def test_a_four_bar_in_absolute_angles_has_the_loops_of_its_book() -> None:
    """R. L. Norton, Design of Machinery, ch. 4 and 6: ω4/ω2 = a sin(θ2 − θ3)/(c sin(θ4 − θ3))."""
    relative = textbook.load("four_bar_linkage")
    linkage = relative.with_absolute_angles({"theta": "chi"})
    assert list(linkage.coordinates) == ["phi", "chi", "psi"]
    lines = [line.strip() for line in derive(linkage).text(steps=True).splitlines()]
    assert "Phi_C_x = d - a cos(phi) + c cos(psi) - b cos(chi)" in lines
    assert "Phi_C_z = c sin(psi) - a sin(phi) - b sin(chi)" in lines
    one = reduce_loops(linkage)
    assert str(one.coefficients["K_psi"]) == "a sin(phi - chi)/(c sin(psi - chi))"
    q = assemble(relative, {"phi": 0.7})
    phi, theta, psi = q
    held = Reference(relative).acceleration(q, [1.0, 0.0, 0.0])
    same = Reference(linkage).acceleration([phi, phi + theta, psi], [1.0, 1.0, 0.0])
    np.testing.assert_allclose(same, [held[0], held[0] + held[1], held[2]], rtol=1e-10, atol=1e-15)


def test_absolute_angles_are_those_of_parallel_hinges() -> None:
    arm = textbook.load("two_link_arm").with_absolute_angles({"q2": "q"})
    assert list(arm.coordinates) == ["q1", "q"]
    assert dict(arm.coordinates.driven) == {"q2": coordinate("q") - coordinate("q1")}
    assert verify(arm, samples=5).agrees
    top = textbook.load("heavy_top")
    with pytest.raises(InputError, match="not parallel to it"):
        top.with_absolute_angles({"theta": "c"})
    with pytest.raises(InputError, match=r"expected a coordinate of a hinge \(q1, q2\), got"):
        textbook.load("acrobot").with_absolute_angles({"q": "c"})
