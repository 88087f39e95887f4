"""What `derive` returns: texts, matrices, callables, and why there is no closed form."""

from __future__ import annotations

import re
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest
from derivation_samples import everything, sample
from sympy import Matrix, cos, sin, symbols
from systems import derive_system

from mecanique import textbook
from mecanique.derivation import METHODS, derive
from mecanique.errors import DerivationError, InputError, UnknownNameError
from mecanique.model import (
    Body,
    Coordinates,
    Input,
    Loop,
    Mechanism,
    Placement,
    Prismatic,
    Revolute,
    coordinate,
    rod,
)
from mecanique.verification import verify


def test_rigid_bar_pendulum() -> None:
    equations = derive_system("rigid_bar_pendulum")
    assert str(equations) == "q'' + 3 g sin(q)/(2 l) = 0"
    m, length, g, q = symbols("m l g q")
    assert Matrix([m * length**2 / 3]) == equations.M
    assert Matrix([m * g * length * sin(q) / 2]) == equations.h
    assert Matrix([0]) == equations.Q


def test_two_blocks() -> None:
    equations = derive_system("two_blocks")
    assert str(equations).splitlines() == [
        "m1 q1'' + (k1 + k2) q1 - k2 q2 = 0",
        "m2 q2'' + k2 (q2 - q1) = F",
    ]
    assert equations.matrix_form().splitlines() == [
        "M q'' + K q = f",
        "q = [q1, q2]",
        "M = [[m1, 0], [0, m2]]",
        "K = [[k1 + k2, -k2], [-k2, k2]]",
        "f = [0, F]",
    ]
    assert equations.linear is not None
    assert (
        "\\begin{bmatrix} k_{1} + k_{2} & -k_{2} \\\\ -k_{2} & k_{2} \\end{bmatrix}"
        in equations.linear.latex()
    )
    assert equations.holds({"q1": -0.5})
    assert not equations.holds({"q1": -1.5})


def test_damped_blocks_have_a_damping_matrix() -> None:
    text = derive(textbook.load("shear_building", n=2)).matrix_form()
    assert "M q'' + C q' + K q = f" in text
    assert "C = [[2 c, -c], [-c, c]]" in text


# the printed forms these systems had when the method was first tried out
SHORTEST = {
    "cart_pole": (
        "l q'' + cos(q) x'' + g sin(q) = 0",
        "l m cos(q) q'' + (M + m) x'' - l m sin(q) q'^2 + c x' - F = 0",
    ),
    "double_pendulum": (
        "l1 (m1 + m2) q1'' + l2 m2 cos(q1 - q2) q2'' + l2 m2 sin(q1 - q2) q2'^2"
        " + g (m1 + m2) sin(q1) = 0",
        "l1 cos(q1 - q2) q1'' + l2 q2'' - l1 sin(q1 - q2) q1'^2 + g sin(q2) = 0",
    ),
}


@pytest.mark.parametrize("name", SHORTEST)
def test_no_more_terms_than_by_hand(name: str) -> None:
    def letters(text: str) -> int:
        return len(re.findall(r"[A-Za-z]\w*", text))

    text = str(derive_system(name))
    assert len(text.splitlines()) == 2
    assert letters(text) <= sum(map(letters, SHORTEST[name]))


def test_mass_matrix_as_sympy() -> None:
    equations = derive_system("cart_pole")
    M, m, length, q = symbols("M m l q")
    assert (
        equations.M - Matrix([[M + m, m * length * cos(q)], [m * length * cos(q), m * length**2]])
    ).expand() == (Matrix.zeros(2, 2))


@pytest.mark.parametrize("steps", [False, True])
def test_mathml_is_well_formed(steps: bool) -> None:
    for name in ("two_blocks", "free_rigid_body", "coupled_pendulums"):
        ElementTree.fromstring(f"<div>{derive_system(name).mathml(steps=steps)}</div>")


def test_latex_in_notebooks() -> None:
    latex = derive_system("rigid_bar_pendulum")._repr_latex_()
    assert latex.startswith("$\\displaystyle \\begin{aligned}")
    assert "\\ddot{q} + \\frac{3 g}{2 l} \\sin q &= 0" in latex


def test_a_named_root_comes_with_its_definition() -> None:
    equations = derive_system("coupled_pendulums")
    radicand = "d^2 + 2 a^2 + 2 d a sin(q2) - 2 d a sin(q1) - 2 a^2 cos(q1 - q2)"
    assert f"length of the spring [m], rho = sqrt({radicand})" in equations.text(steps=True)
    assert r"\rho &= \sqrt{d^{2} + 2 a^{2}" in equations.latex(steps=True)


def test_steps_in_latex() -> None:
    latex = derive_system("cart_pole").latex(steps=True)
    assert "\\item[{\\normalfont $c$}] damping of the cart" in latex
    assert "\\frac{d}{dt} \\frac{\\partial T}{\\partial \\dot{x}}" in latex
    assert latex.count("\\begin{align*}") == latex.count("\\end{align*}") > 5
    assert "Q_{x} &= F(t)" in latex


def test_a_free_body_has_eulers_equations() -> None:
    text = str(derive_system("tennis_racket"))
    assert "center_wy center_wz" in text
    assert len(text.splitlines()) == 3


def test_assumptions_are_told() -> None:
    text = derive_system("two_blocks").text(steps=True)
    assert "Taken for granted: the length of spring1 is q1 + a, which must stay positive." in text


def test_a_closed_form_that_is_too_long_is_said_so() -> None:
    equations = derive(sample("everything"))
    assert not equations.symbolic
    assert "joint 'ball' turns by a quaternion on a body that turns" in str(equations)
    assert "describe the joint by three hinges" in equations.why_not
    assert "are computed, not written out" in equations.mathml()
    assert "are computed, not written out" in equations.latex()
    for read in (
        lambda: equations.M,
        lambda: equations.h,
        lambda: equations.Q,
        lambda: equations.steps,
    ):
        with pytest.raises(DerivationError, match="turns by a quaternion"):
            read()
    assert equations.mass_matrix(None).shape == (17, 17)


def test_long_chains_are_computed_not_written() -> None:
    axes = ((1, 0, 0), (0, 1, 0), (0, 0, 1))
    joints = tuple(
        Revolute(f"j{k}", f"b{k}", f"b{k + 1}", axis=axes[k % 3], origin=Placement((0.1, 0.2, 0.3)))
        for k in range(12)
    )
    bodies = (Body("b0"), *(Body(f"b{k + 1}", rod(1.0, 1.0, (1, 2, 3))) for k in range(12)))
    equations = derive(Mechanism("chain", bodies, joints, ground="b0"))
    assert not equations.symbolic
    assert "terms" in equations.why_not
    assert np.isfinite(equations.acceleration(np.ones(12), np.ones(12))).all()


def test_unknown_method() -> None:
    with pytest.raises(UnknownNameError, match="unknown method 'lagrang'; did you mean 'lagrange'"):
        derive_system("cart_pole", method="lagrang")
    assert "lagrange" in METHODS


def test_matrices_of_what_is_not_linear_are_refused() -> None:
    with pytest.raises(
        DerivationError, match="'cart_pole' are not linear with constant coefficients; linearize"
    ):
        derive_system("cart_pole").matrix_form()


def test_one_state_and_many() -> None:
    equations = derive_system("cart_pole")
    q, v = np.array([[0.1, 0.2], [0.3, 0.4], [0.5, 0.6]]), np.ones((3, 2))
    assert equations.mass_matrix(q).shape == (3, 2, 2)
    assert equations.mass_matrix(q[0]).shape == (2, 2)
    for quantity in (equations.bias, equations.forces, equations.acceleration):
        many = quantity(q, v, np.zeros(3))
        assert many.shape == (3, 2)
        np.testing.assert_array_equal(quantity(q[1], v[1]), many[1])
    T, V = equations.energy(q, v)
    assert T.shape == V.shape == (3,)
    np.testing.assert_array_equal(
        equations.bias({"q": 0.2, "x": 0.1}, {"q": 1.0, "x'": 1.0}), equations.bias(q[0], v[0])
    )
    np.testing.assert_array_equal(equations.bias(q, None), equations.bias(q, np.zeros((3, 2))))


def test_acceleration_solves_the_equations_of_motion() -> None:
    equations = derive(sample("driven"))
    q, v, t = sample("driven").neutral() + 0.3, np.linspace(-1, 1, equations.mechanism.nv), 0.7
    a = equations.acceleration(q, v, t)
    left = equations.mass_matrix(q, t) @ a + equations.bias(q, v, t)
    np.testing.assert_allclose(left, equations.forces(q, v, t), rtol=1e-11, atol=1e-11)


@pytest.mark.parametrize(
    ("q", "v", "t", "message"),
    [
        (
            [1.0],
            [1.0, 2.0],
            0.0,
            r"expected shape \(2,\) or \(n, 2\) for the coordinate values \(x, q\), got \(1,\)",
        ),
        (
            [1.0, 2.0],
            [1.0],
            0.0,
            r"expected shape \(2,\) or \(n, 2\) for the velocity values \(x', q'\), got \(1,\)",
        ),
        ([1.0, float("nan")], [1.0, 2.0], 0.0, "expected finite coordinate values"),
        (["a", "b"], [1.0, 2.0], 0.0, "expected 2 numbers for the coordinate values"),
        (
            np.zeros((3, 2)),
            np.zeros((2, 2)),
            0.0,
            "expected one number of states in q, v, a and t, got q: 3, v: 2",
        ),
        ([1.0, 2.0], [1.0, 2.0], [[0.0]], r"expected a number or shape \(n,\) for time t"),
        ({"y": 1.0}, None, 0.0, "unknown coordinate 'y'"),
        ({"q": 1.0}, {"z": 1.0}, 0.0, "unknown velocity 'z"),
    ],
)
def test_bad_states_are_refused(q: object, v: object, t: object, message: str) -> None:
    equations = derive_system("cart_pole")
    with pytest.raises(InputError, match=message):
        equations.bias(q, v, t)  # type: ignore[arg-type]  # what is not typed is refused, too


def test_a_quaternion_without_length_is_refused() -> None:
    equations = derive(sample("free"))
    with pytest.raises(InputError, match="expected a unit quaternion for joint 'flight'"):
        equations.mass_matrix(np.zeros(equations.mechanism.nq))


def test_a_coordinate_beyond_its_range_is_refused() -> None:
    equations = derive_system("particle_on_circle_x")
    with pytest.raises(InputError, match=r"x must stay within \(-R, R\) = \(-1, 1\), got 10"):
        equations.bias([10.0], [1.0])


def driven_by(signal: object) -> Mechanism:
    u = Input("u", signal, "m")
    return Mechanism(
        "driven",
        (Body("ground"), Body("cart"), Body("bob", rod(1.0, 1.0))),
        (
            Prismatic("slide", "ground", "cart", axis=(1, 0, 0), coordinate="x"),
            Revolute("pin", "cart", "bob", axis=(0, -1, 0), coordinate="q"),
        ),
        inputs=(u,),
        coordinates=Coordinates(("q",), {"x": u}),
    )


def test_a_map_cannot_follow_a_python_function() -> None:
    equations = derive(driven_by(lambda t: t))
    with pytest.raises(
        DerivationError, match="input 'u', a record or a Python function, which has no exact"
    ):
        equations.bias([0.1], [0.2])


def test_an_input_that_is_not_finite_is_refused() -> None:
    mechanism = textbook.load("cart_pole")
    broken = replace(mechanism, inputs=(Input("F", lambda t: float("nan")),))
    with pytest.raises(InputError, match="input 'F' is not finite at t = 2 s"):
        derive(broken).forces([0.0, 0.0], [0.0, 0.0], 2.0)


def test_a_map_follows_a_quaternion() -> None:
    mechanism = everything({"turn": 2 * coordinate("free_qx")})
    verdict = verify(mechanism, samples=3)
    assert verdict.agrees
    assert any("jets" in row.sources for row in verdict.rows if row.quantity == "bias")


def test_loops_determine_the_accelerations_and_stand_in_the_closed_form() -> None:
    mechanism = Mechanism(
        "ring",
        (Body("ground"), Body("a", rod(1.0, 1.0)), Body("b", rod(1.0, 1.0))),
        (
            Revolute("p", "ground", "a", axis=(0, -1, 0)),
            Revolute("r", "ground", "b", axis=(0, -1, 0), origin=Placement((1, 0, 0))),
        ),
        loops=(Loop.distance("tie", "a", (0, 0, -1), "b", (0, 0, -1), 1.0),),
    )
    equations = derive(mechanism)
    assert equations.mass_matrix([0.0, 0.0]).shape == (2, 2)
    # the tie keeps the rods parallel, so that they swing like one
    q = np.array([0.3, 0.3])
    np.testing.assert_allclose(
        equations.acceleration(q, [0.5, 0.5]), -1.5 * 9.81 * np.sin(q), rtol=1e-12, atol=0
    )
    assert set(equations.multipliers(q, [0.5, 0.5])) == {"tie: length"}
    assert equations.text().splitlines()[-1] == "1 - sin(p) - cos(p - r) + sin(r) = 0"


def test_repr() -> None:
    assert (
        repr(derive_system("cart_pole")) == "<Equations of 'cart_pole' by lagrange, v = (x', q')>"
    )
