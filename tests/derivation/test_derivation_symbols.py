"""Every symbol that stands in print is defined above it, for all systems by all methods."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from fractions import Fraction

import pytest
import sympy
from systems import derive_system

from mecanique import (
    Body,
    Floating,
    Mechanism,
    Parameter,
    Planar,
    Prismatic,
    Revolute,
    Spherical,
    Universal,
    ball,
    derive,
    particle,
    rod,
    textbook,
)
from mecanique.derivation import METHODS
from mecanique.derivation.coordinates import CoordinateWords
from mecanique.derivation.document import Document
from mecanique.derivation.glossary import clashes, meanings
from mecanique.derivation.printing.equations import expression
from mecanique.derivation.scalars.evaluation import evaluate
from mecanique.derivation.scalars.polynomials import exact
from mecanique.derivation.scalars.series import Series
from mecanique.derivation.symbolic.derivation import Ending, Left, Result
from mecanique.derivation.symbolic.symbols import Algebra
from mecanique.model.mechanism.letters import call

FUNCTIONS = {"sin", "cos", "tan", "sqrt", "exp", "log", "asin", "acos", "atan", "tanh", "abs"}
FUNCTIONS |= {"sign", "pi", "d", "dt"}
MATRICES = {"M", "C", "K", "f", "q"}
NAME = re.compile(r"[^\W\d]\w*'*")
WORD = re.compile(r"[^\W_]+")
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


SPELLED = {"Omega": "Ω", "Phi": "Φ", "psi": "ψ"}
"""How sentences spell the letters of steps, where formulas name them in words."""


def undefined_in(document: Document) -> set[str]:
    """The symbols in formulas that neither the list nor the sentences up to them explain."""
    text = document.text(steps=True)
    known = defined_in(text) | FUNCTIONS
    if document.linear is not None:
        known |= MATRICES
    told, missing = set[str](), set[str]()
    for line in text.split("\n\n1. ", 1)[1].splitlines():
        if not line.startswith("     "):
            told |= set(WORD.findall(line))
            continue
        formula = NUMBER.sub(" ", COMPONENT.sub(") ", line)).replace("∂", " ")
        for name in NAME.findall(formula):
            letter = name.rstrip("'").partition("_")[0]
            if known.isdisjoint({name, name.rstrip("'")}) and told.isdisjoint(
                {name, letter, SPELLED.get(letter, letter)}
            ):
                missing.add(name)
    for meaning in meanings(document.derivation):
        used = meaning.definition.letters if meaning.definition is not None else frozenset()
        missing |= {name for name in used if known.isdisjoint({name, name.rstrip("'")})}
    return missing


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


GENERIC = re.compile(
    r"\b(?:acceleration|center is at|couple|density|distance|force|inertia|mass|momentum|position|"
    r"velocity) ([^\W\d_])\b(?!['_(])"
)
"""A letter that a step introduces for a quantity of any body."""


@pytest.mark.parametrize("name", textbook.names())
def test_no_letter_of_a_derivation_means_two_things(name: str) -> None:
    meant: dict[str, set[str]] = {}
    for method in METHODS:
        equations = derive_system(name, method)
        if not equations.legible:
            continue
        document, algebra = equations.document, equations.derivation.algebra
        assert "Beware" not in document.introduction
        for meaning in document.meanings(steps=True):
            for letter in meaning.names if meaning.sentence else ():
                meant.setdefault(letter, set()).add(meaning.sentence)
        said = " ".join(section.explanation for section in document.sections())
        declared = {*algebra.values, *algebra.mechanism.coordinates}
        assert not declared.intersection(GENERIC.findall(said)), method
    assert {letter: what for letter, what in meant.items() if len(what) > 1} == {}


def test_what_is_not_defined_is_found() -> None:
    document = derive_system("cart_pole").document
    text = document.text(steps=True)
    assert "l" in defined_in(text)
    assert undefined_in(document) == set()
    unlisted = replace(document, explained=frozenset({"l"}))
    assert undefined_in(unlisted) == {"l"}


@pytest.mark.parametrize("method", METHODS)
def test_the_list_leaves_out_what_the_steps_explain(method: str) -> None:
    text = derive_system("slider_crank", method).text(steps=True)
    assert defined_in(text).isdisjoint({"T", "V", "m_crank", "H_crank", "K_x", "J", "δW_x", "s"})
    assert "x and z components in the axes of the world" in text
    if method != "lagrange":
        assert (
            "  R_O_x, R_O_z\n    force that the ground exerts on the crank in O, along x and z of"
            in text
        )


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("name", ["heavy_top", "rolling_coin", "atwood_machine", "slider_crank"])
def test_no_line_stands_twice_and_none_says_zero(name: str, method: str) -> None:
    text = derive_system(name, method).text(steps=True)
    steps, _, after = text.partition(". Equations of motion\n")
    lines = [line for line in f"{steps}{after}".splitlines() if line.startswith("     ")]
    assert len(lines) == len({*lines})
    assert not [line for line in lines if re.match(r"     (?:d/dt )?(?:∂|δ).* = 0$", line)]


@pytest.mark.parametrize("name", textbook.names())
def test_description_and_source_stand_above_the_equations(name: str) -> None:
    mechanism = textbook.load(name)
    description, source = mechanism.about.splitlines()
    assert len(description) > 60
    assert source == f"Source: {textbook.entry(name).source}."


def test_the_coordinate_map_is_stated() -> None:
    swinging = derive_system("particle_on_circle_x").text(symbols=True)
    assert "positive towards +y [rad], theta = acos(x/R)" in swinging
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


def test_what_stands_at_the_end_without_steps_has_its_unit() -> None:
    derivation = derive_system("dumbbell").derivation
    lines = tuple(Result(Left("p", name, component=True), derivation.h[0]) for name in ("x", "phi"))
    listed = meanings(derivation, [Ending("", lines)], steps=False)
    said = {name: meaning.sentence for meaning in listed for name in meaning.names}
    assert said["p_x"] == "momentum of x [kg·m/s]"
    assert said["p_phi"] == "momentum of phi [N·m·s]"
    assert "  E           total energy, T + V [J]" in derive_system("slider_crank").text(
        symbols=True
    )
    assert _listed("screw_press")["theta_travel"] == "dependent coordinate of joint thread [m]"
    assert _listed("free_rigid_body")["ω"].startswith("angular velocity [rad/s] and velocity [m/s]")


def test_what_a_slide_and_a_hinge_move_is_named() -> None:
    m = Parameter("m", 1.0, "kg")
    bodies = (Body("ground"), Body("block", rod(m, 1.0)), Body("bob", rod(m, 1.0)))
    slide = Prismatic("slide", "ground", "block", axis=(1, 0, 0), coordinate="x")
    hinge = Revolute("hinge", "block", "bob", axis=(0, 1, 0), coordinate="q")
    text = derive(Mechanism("block", bodies, (slide, hinge), parameters=(m,))).text(symbols=True)
    assert "displacement of the block along x [m]" in text
    assert "angle of the bob from the downward vertical, positive towards -x [rad]" in text


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


@pytest.mark.parametrize("constant", [sympy.pi, sympy.E, sympy.GoldenRatio, sympy.EulerGamma])
def test_constants_have_their_values(constant: sympy.NumberSymbol) -> None:
    """In print π and e keep their names; the others, which SymPy alone knows, are numbers."""
    series = algebra().number(constant)
    assert float(evaluate(series, {})) == pytest.approx(float(constant), rel=1e-15)
    assert series.is_number == (constant not in (sympy.pi, sympy.E))


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
        words = CoordinateWords(textbook.load(name))
        return {**words.of_joints, **dict(words.sentences())}[coordinate]

    assert say("rolling_coin", "x") == "position of the center of the coin along x [m]"
    assert say("rolling_coin", "z") == "position of the center of the coin along z [m]"
    assert say("two_wheeled_cart", "x") == "position of the origin of the load along x [m]"
    assert say("base_excited_mass", "x_base") == "displacement of the base along x [m]"
    assert (
        say("base_excited_mass", "u")
        == "displacement of the block relative to the base along x [m]"
    )
    tilted = "position of the center of the disk along x, turned by alpha about y [m]"
    assert say("rolling_disk", "x") == tilted
    assert say("kepler_orbit", "r") == "distance of the planet from the axis of phi [m]"
    assert say("elastic_pendulum", "r") == "distance of the bob from the hinge pin [m]"
    # a coordinate that is no joint's is that of the point which it moves as much
    assert say("bars_and_springs", "q") == "displacement of C along -z [m]"
    assert say("shear_building", "u3") == "displacement of floor3 along x [m]"


@pytest.mark.parametrize(
    ("system", "name", "said"),
    [
        ("cart_pole", "q", "angle of the pole from the downward vertical, positive towards +x"),
        ("four_bar_linkage", "phi", "angle of the crank from the x axis, positive upwards"),
        ("bars_and_springs", "alpha", "angle of ABC from the x axis, positive towards -z"),
        ("kepler_orbit", "phi", "angle of the planet from the x axis, positive towards +y"),
        # a sum of those of parallel hinges is that of the last body itself
        ("double_pendulum", "q2", "angle of rod2 from the downward vertical, positive towards +x"),
        ("bar_chain", "q4", "angle of bar4 from the z axis, positive towards +x"),
        ("double_pendulum", "theta2", "angle of rod2 relative to rod1, about -y, zero in line"),
        ("slider_crank", "beta", "angle of the rod relative to the crank, about -y, zero in line"),
        (
            "whipple_bicycle",
            "rear_spin",
            "rotation of the rear wheel relative to the frame, about y",
        ),
        ("rolling_disk", "turn", "rotation of the disk about y"),
        # what turns about the vertical leaves a tilt from it as it is
        (
            "heavy_top",
            "theta",
            "angle of the top from the upward vertical, about x of the precessing",
        ),
        ("heavy_top", "phi", "rotation of the top about z"),
        ("heavy_top", "psi", "rotation of the top about its axis z"),
        ("rolling_coin", "lean", "rotation of the coin about x of the heading"),
        ("gyroscope", "psi", "rotation of the rotor relative to the inner, about z"),
    ],
)
def test_an_angle_is_told_by_its_body_and_where_it_is_zero(
    system: str, name: str, said: str
) -> None:
    words = CoordinateWords(textbook.load(system))
    assert {**words.of_joints, **dict(words.sentences())}[name] == f"{said} [rad]"


def test_coordinates_and_velocities_of_joints_in_space_are_told_with_their_units() -> None:
    bodies = tuple(Body(name, ball(1.0, 0.1)) for name in ("stone", "bob", "plate", "shaft"))
    joints = (
        Floating("free", "ground", "stone"),
        Spherical("socket", "ground", "bob"),
        Planar("floor", "ground", "plate", axis=(0, 0, 1), names=("x", "y", "theta")),
        Universal("cardan", "plate", "shaft", names=("p", "q")),
    )
    said = dict(CoordinateWords(Mechanism("all", (Body("ground"), *bodies), joints)).sentences())
    for axis in "xyz":
        assert said[f"free_{axis}"] == f"{axis} coordinate of the stone [m]"
        of = "velocity of the stone, in its own axes"
        assert said[f"free_v{axis}"] == f"{axis} component of the {of} [m/s]"
        assert said[f"free_w{axis}"] == f"{axis} component of the angular {of} [rad/s]"
        of = "angular velocity of the bob, in its own axes"
        assert said[f"socket_w{axis}"] == f"{axis} component of the {of} [rad/s]"
        part = "component of the unit quaternion of the bob"
        assert said[f"socket_q{axis}"] == f"{axis} {part}"
    assert said["socket_qw"] == "scalar part of the unit quaternion of the bob"
    assert [said[name] for name in ("x", "y", "theta")] == [
        "displacement of the plate along x [m]",
        "displacement of the plate along y [m]",
        "rotation of the plate about z [rad]",
    ]
    assert [said[name] for name in "pq"] == [
        f"rotation of the shaft about {axis} of the Cardan joint cardan [rad]"
        for axis in ("x", "the turned y")
    ]


def test_a_name_that_is_a_word_has_its_article_in_a_sentence() -> None:
    names = ["crank", "rear_wheel", "A", "rod1", "psi", "spring_B", "the world"]
    said = ["the crank", "the rear wheel", "A", "rod1", "psi", "spring_B", "the world"]
    assert [*map(call, names)] == said
    text = " ".join(derive_system("slider_crank", "newton_euler").text(steps=True).split())
    assert "Cut free, the slider is acted on by the reaction in the guide, its weight" in text


def test_an_angle_of_a_joint_that_nothing_contains_is_not_listed() -> None:
    """What other angles add up to alone says nothing; laws with lengths or time do."""
    for name, said in {
        "double_pendulum": 0,
        "bar_chain": 0,
        "crane": 1,
        "atwood_machine": 2,
    }.items():
        mechanism = textbook.load(name)
        symbols = derive_system(name).text(steps=True, symbols=True).partition("Symbols\n")[2]
        symbols = symbols.partition("\n1. ")[0]
        listed = [driven for driven in mechanism.coordinates.driven if f"  {driven} " in symbols]
        assert len(listed) == said, name


def test_pages_explain_the_reactions_of_the_steps() -> None:
    said = [meaning for _, meaning in derive_system("cart_pole", "newton_euler").document.symbols()]
    assert (
        "force that the cart exerts on the pole in the pin, along x and z of the world [N]" in said
    )
    assert "kinetic energy [J]" not in said
