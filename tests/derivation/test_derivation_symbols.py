"""Every symbol that stands in print is defined above it, for all systems by all methods."""

from __future__ import annotations

import math
import re
from fractions import Fraction

import pytest
from systems import derive_system

from mecanique import (
    Body,
    Mechanism,
    Parameter,
    Prismatic,
    Revolute,
    derive,
    particle,
    rod,
    textbook,
)
from mecanique.derivation import METHODS
from mecanique.derivation.document import Document
from mecanique.derivation.glossary import clashes, explain_coordinates, meanings
from mecanique.derivation.printing.equations import expression
from mecanique.derivation.printing.expressions import to_sympy
from mecanique.derivation.scalars.evaluation import evaluate
from mecanique.derivation.scalars.polynomials import exact
from mecanique.derivation.scalars.series import Series
from mecanique.derivation.symbolic.derivation import Left
from mecanique.derivation.symbolic.symbols import Algebra
from mecanique.model.mechanism.homogeneity import dimensions_of
from mecanique.model.units import say_unit

FUNCTIONS = {"sin", "cos", "tan", "sqrt", "exp", "log", "asin", "acos", "atan", "tanh", "abs"}
FUNCTIONS |= {"sign", "pi", "d", "dt"}
MATRICES = {"M", "C", "K", "f", "q"}
NAME = re.compile(r"[^\W\d]\w*'*")
NUMBER = re.compile(r"\d[\d.]*e[-+]?\d+")
COMPONENT = re.compile(r"\)_\w+")


def defined_in(text: str) -> set[str]:
    """The symbols that the list above a derivation defines."""
    listed = text.split("\nSymbols\n", 1)[1].split("\n\n")[0]
    names: set[str] = set()
    for line in listed.splitlines():
        if re.match(r"  \S", line):
            names |= set(line.strip().partition("  ")[0].split(", "))
    return names


def undefined_in(document: Document) -> set[str]:
    """The symbols in the formulas of a derivation that its list does not define."""
    text = document.text(steps=True)
    known = defined_in(text)
    if document.linear is not None:
        known |= MATRICES
    used: set[str] = set()
    for line in text.split("\n\n1. ", 1)[1].splitlines():
        if line.startswith("     "):
            used |= set(NAME.findall(NUMBER.sub(" ", COMPONENT.sub(") ", line)).replace("∂", " ")))
    for meaning in meanings(document.derivation):
        used |= meaning.definition.letters if meaning.definition is not None else frozenset()
    return {name for name in used if not {name, name.rstrip("'")} & (known | FUNCTIONS)}


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=pytest.mark.slow) if name == "two_wheeled_cart" else name
        for name in textbook.names()
    ],
)
def test_every_symbol_of_every_system_is_defined(name: str) -> None:
    for method in METHODS:
        equations = derive_system(name, method)
        if equations.symbolic:
            assert undefined_in(equations.document) == set(), method


def test_what_is_not_defined_is_found() -> None:
    document = derive_system("cart_pole").document
    text = document.text(steps=True)
    assert "l" in defined_in(text)
    assert "l" not in defined_in(text.replace("  l    ", "  "))


@pytest.mark.parametrize("name", textbook.names())
def test_description_and_source_stand_above_the_equations(name: str) -> None:
    mechanism = textbook.load(name)
    description, source = mechanism.about.splitlines()
    assert len(description) > 60
    assert source == f"Source: {textbook.entry(name).source}."


def test_the_coordinate_map_is_stated() -> None:
    text = derive_system("double_pendulum").text(symbols=True)
    assert "theta2  angle of the hinge pin2, about -y of rod1 [rad], theta2 = q2 - q1" in text
    assert "l = l0 - w t" in derive_system("crane").text(symbols=True)
    assert "z = A cos(W t)" in derive_system("kapitza_pendulum").text(symbols=True)


def test_the_law_of_an_input_is_stated_in_all_formats() -> None:
    equations = derive_system("two_blocks")
    assert "force on block 2 [N], F = F0 cos(W t)" in equations.text(symbols=True)
    assert r"$F = F_{0} \cos(W t)$" in equations.latex(symbols=True)
    assert "angular frequency of the force [rad/s]" in equations.mathml(symbols=True)
    assert "angular frequency of the force [rad/s]" in equations._repr_html_()
    assert "angular frequency of the force [rad/s]" in dict(equations.document.symbols()).values()


def test_a_letter_for_two_things_is_warned_of() -> None:
    m, T = Parameter("m", 1.0, "kg", "mass"), Parameter("T", 2.0, "m", "length of the rod")
    bodies = (Body("ground"), Body("bar", rod(m, T)))
    pin = Revolute("pin", "ground", "bar", axis=(0, -1, 0), coordinate="q")
    equations = derive(Mechanism("bar", bodies, (pin,), parameters=(m, T)))
    (warning,) = clashes(equations.derivation, steps=True, matrices=False)
    assert warning.startswith("Beware: T stands for the length of the rod; alone on the left")
    assert " ".join(warning.split()) in " ".join(equations.text(steps=True).split())
    assert not list(clashes(equations.derivation, steps=False, matrices=False))


@pytest.mark.parametrize("name", ["two_blocks", "gyroscope", "coupled_pendulums"])
def test_each_symbol_of_virtual_work_stands_for_one_thing(name: str) -> None:
    """A spring pulls two bodies, and the joints of the gyroscope are named like its angles."""
    derivation = derive_system(name, "virtual_work").derivation
    found: dict[str, Series] = {}
    for stage in derivation.stages:
        for result in stage.results:
            if isinstance(result.left, Left):
                known = found.setdefault(result.left.symbol, result.right)
                assert known == result.right, result.left.symbol
    meant = [symbol for meaning in meanings(derivation) for symbol in meaning.names]
    assert len(set(meant)) == len(meant)


def test_what_a_force_is_and_on_what_is_said() -> None:
    listed = {
        name: meaning.sentence
        for meaning in meanings(derive_system("two_blocks", "virtual_work").derivation)
        for name in meaning.names
    }
    assert listed["F_spring2_block1_x"] == "force of spring2 on block1 [N]"
    assert listed["F_inertia_block1_x"] == "resultant of the inertia forces of block1 [N]"
    assert listed["F_weight_block1_z"] == "weight of block1 [N]"
    assert listed["δW_R_slide1"] == "virtual work of the reaction in slide1 [J]"


def test_what_belongs_to_a_coordinate_or_a_tie_has_its_unit() -> None:
    assert _listed("chaplygin_sleigh")["psi_edge_side"].endswith(" edge_side [m/s]")
    assert _listed("governor")["Phi_link1_l"].endswith(" link1_l [m²]")
    dumbbell = _listed("dumbbell")
    assert dumbbell["p_x"] == "momenta, each of the coordinate it is named after [kg·m/s]"
    assert dumbbell["p_phi"] == "momentum of phi [N·m·s]"
    press = _listed("screw_press")
    assert press["Q_theta"].endswith(" [N·m]")
    assert press["theta_travel"] == "dependent coordinate of joint thread [m]"
    assert _listed("free_rigid_body")["ω"].startswith("angular velocity [rad/s] and velocity [m/s]")


@pytest.mark.parametrize("name", ["governor", "four_bar_linkage", "rolling_coin", "rolling_disk"])
def test_the_unit_of_what_a_tie_demands_is_that_of_its_formula(name: str) -> None:
    derivation = derive_system(name).derivation
    listed = _listed(name)
    dimensions = dimensions_of(derivation.algebra.mechanism)
    for tie in derivation.ties:
        its = dimensions.of(to_sympy(tie.demand))
        assert its is not None
        assert listed[f"{tie.letter}_{tie.name}"].endswith(f" [{say_unit(its)}]")


def test_a_joint_named_like_its_kind_is_named_once() -> None:
    m = Parameter("m", 1.0, "kg")
    bodies = (Body("ground"), Body("block", rod(m, 1.0)), Body("bob", rod(m, 1.0)))
    slide = Prismatic("slide", "ground", "block", axis=(1, 0, 0), coordinate="x")
    hinge = Revolute("hinge", "block", "bob", axis=(0, 1, 0), coordinate="q")
    text = derive(Mechanism("block", bodies, (slide, hinge), parameters=(m,))).text(symbols=True)
    assert "displacement in the slide, along x of ground [m]" in text
    assert "angle of the hinge, about y of block [rad]" in text


@pytest.mark.parametrize(
    ("gravity", "said"),
    [
        ((0, 0, 0), "There are neither weights nor springs: V is zero."),
        ((0, 0, -9.81), "The weights do no work in this motion, and there are no springs: V is"),
    ],
)
def test_a_potential_energy_of_zero_is_said(gravity: tuple[float, float, float], said: str) -> None:
    m, l = Parameter("m", 1.0, "kg"), Parameter("l", 2.0, "m")
    bodies = (Body("ground"), Body("bar", rod(m, l, (1, 0, 0))))
    pin = Revolute("pin", "ground", "bar", axis=(0, 0, 1), coordinate="q")
    text = derive(Mechanism("bar", bodies, (pin,), parameters=(m, l), gravity=gravity)).text(
        steps=True
    )
    assert said in " ".join(text.split())
    assert "     V = 0\n" in text


def _listed(name: str) -> dict[str, str]:
    """What each symbol of a system is."""
    every = meanings(derive_system(name).derivation)
    return {symbol: meaning.sentence for meaning in every for symbol in meaning.names}


def algebra(*parameters: Parameter) -> Algebra:
    point = Body("point", particle(1.0))
    slide = Prismatic("slide", "ground", "point", axis=(1, 0, 0), coordinate="x")
    return Algebra(Mechanism("p", (Body("ground"), point), (slide,), parameters=parameters))


@pytest.mark.parametrize("number", [math.sqrt(0.5), -math.sqrt(0.75), math.sqrt(7 / 999)])
def test_a_float_that_is_the_root_of_a_fraction_is_that_root(number: float) -> None:
    root = algebra().number(number)
    assert root**2 == Fraction(number**2).limit_denominator(1000)
    assert float(evaluate(root, {})) == pytest.approx(number, rel=1e-15)
    assert not root.is_number


@pytest.mark.parametrize(
    "number", [0.1, 1 / 3, math.sqrt(0.5) * (1 + 1e-14), math.sqrt(5 / 1003), 0.70710678, 1.5]
)
def test_other_floats_are_the_fractions_that_they_are(number: float) -> None:
    series = algebra().number(number)
    assert series.is_number
    assert series == exact(number)


def test_products_name_masses_then_gravity_lengths_and_rates() -> None:
    """Whatever the order in which they are declared, with the square of a length as a length."""
    units = {"W": "rad/s", "A": "m²", "l": "m", "g": "m/s²", "m": "kg", "k": "N/m", "v": "m/s"}
    ring = algebra(*(Parameter(name, 2.0, unit) for name, unit in units.items())).ring
    whole = ring.number(1)
    for name in units:
        whole = whole * ring[name]
    assert expression(whole).text() == "m k g A l W v"


def test_a_coordinate_that_places_a_center_is_said_to_do_so() -> None:
    """Massless carriers on slides lead the coin; a base that is driven carries its block."""

    def say(name: str, coordinate: str) -> str:
        explained = explain_coordinates(textbook.load(name))
        return next(meaning.sentence for meaning in explained if coordinate in meaning.names)

    assert say("rolling_coin", "x") == "position of the center of coin along x of ground [m]"
    assert say("rolling_coin", "z") == "position of the center of coin along z of ground [m]"
    assert say("two_wheeled_cart", "x") == "position of the origin of load along x of ground [m]"
    for relative in (("base_excited_mass", "u"), ("double_atwood_machine", "y"), ("crane", "x")):
        assert say(*relative).startswith("displacement in the slide")
