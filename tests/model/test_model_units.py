"""Units: each expression is in the unit of its place, or refused with the place and both units."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from typing import Any

import pytest
import sympy

import mecanique as mq
from mecanique.errors import InputError, MechanismError
from mecanique.model.mechanism_units import units
from mecanique.model.units import (
    PURE,
    Dimensions,
    HomogeneityError,
    read_unit,
    say_unit,
)

M, L = mq.Parameter("m", 2.0, "kg"), mq.Parameter("l", 1.0, "m")
K, G = mq.Parameter("k", 3.0, "N/m"), mq.Parameter("g", 9.81, "m/s²")
W, F = mq.Parameter("w", 2.0, "rad/s"), mq.Input("F", 1.0, "N")
BOB = (0, 0, -L)


def _pendulum(shape: Any = None, **parts: Any) -> mq.Mechanism:
    """Return a pendulum on a slider, with some parts changed."""
    bodies = (mq.Body("ground"), mq.Body("block"), mq.Body("rod", shape or mq.rod(M, L)))
    joints = (
        mq.Prismatic("slide", "ground", "block", axis=(1, 0, 0), coordinate="x"),
        parts.pop("hinge", mq.Revolute("hinge", "block", "rod", axis=(0, -1, 0), coordinate="q")),
    )
    parts = {"gravity": (0, 0, -G), "parameters": (M, L, K, G, W), "inputs": (F,), **parts}
    return mq.Mechanism("pendulum", bodies, joints, **parts)


X, Q, T = mq.coordinate("x"), mq.coordinate("q"), mq.time()
REFUSED: list[tuple[dict[str, Any], str]] = [
    ({"shape": mq.rod(L, M)}, "body 'rod': its mass: l is in m, expected kg"),
    ({"shape": mq.rod(L, M)}, "body 'rod': its center of mass: -m/2 is in kg, expected m"),
    ({"shape": mq.rod(L, M)}, "body 'rod': its inertia: l*m**2/12 is in kg²·m, expected kg·m²"),
    (
        {"shape": replace(mq.rod(M, L), visuals=(mq.Visual(mq.Box((L, L, M))),))},
        "body 'rod': what is drawn of it: m is in kg, expected m",
    ),
    (
        {"forces": [mq.JointSpring("spiral", "hinge", K)]},
        "force 'spiral': its stiffness: k is in N/m, expected N·m/rad",
    ),
    (
        {"forces": [mq.JointSpring("s", "slide", K, M)]},
        "force 's': its reference: m is in kg, expected m",
    ),
    ({"forces": [mq.JointDamper("d", "hinge", K)]}, "its damping: k is in N/m, expected N·m·s/rad"),
    (
        {"forces": [mq.Spring("s", "ground", (0, 0, 0), "rod", BOB, K * L, L)]},
        "force 's': its stiffness: k*l is in N, expected N/m",
    ),
    (
        {"forces": [mq.Spring("s", "ground", (0, 0, 0), "rod", (0, 0, M), K, L)]},
        "force 's': its point b: m is in kg, expected m",
    ),
    ({"forces": [mq.JointForce("drive", "hinge", F)]}, "its force: F is in N, expected N·m"),
    (
        {"forces": [mq.Force("push", "rod", BOB, (F + K, 0, 0))]},
        "force 'push': its force: F + k adds F [N] and k [N/m]",
    ),
    (
        {"forces": [mq.Force("push", "rod", BOB, (F * mq.sin(L * T), 0, 0))]},
        "its force: l*t, of which sin is taken, is in m·s",
    ),
    (
        {"forces": [mq.Force("push", "rod", BOB, (0, 0, -10 * M))]},
        "-10*m is in kg, expected N (-10 counts as a pure number; a Parameter can have a unit)",
    ),
    ({"gravity": (0, 0, -W)}, "gravity: -w is in 1/s, expected m/s²"),
    (
        {"coordinates": mq.Coordinates((), {"x": L * T})},
        "the map of coordinate 'x': l*t is in m·s",
    ),
    (
        {"inputs": (mq.Input("F", K * T, "N"),)},
        "input 'F': k*t is in N·s/m, expected N",
    ),
    (
        {"hinge": mq.Revolute("hinge", "block", "rod", armature=M, coordinate="q")},
        "joint 'hinge': its armature: m is in kg, expected kg·m²",
    ),
    (
        {"hinge": mq.Revolute("hinge", "block", "rod", origin=mq.Placement((M, 0, 0)))},
        "joint 'hinge': its origin: m is in kg, expected m",
    ),
    (
        {"hinge": mq.Revolute("hinge", "block", "rod", origin=mq.Placement(rpy=(L, 0, 0)))},
        "joint 'hinge': its origin, its angles: l is in m, expected rad",
    ),
    (
        {"hinge": mq.Helical("hinge", "block", "rod", pitch=W)},
        "the map of coordinate 'hinge_travel': hinge*w is in 1/s, expected m",
    ),
    (
        {"loops": [mq.Loop.distance("link", "ground", (0, 0, 0), "rod", BOB, L**2)]},
        "loop 'link': its length: l**2 is in m², expected m",
    ),
    (
        {"coordinates": mq.Coordinates((), {}, {"x": (-1.0, M)})},
        "the limits of coordinate 'x': m is in kg, expected m",
    ),
    (
        {"velocity_constraints": [mq.VelocityConstraint("c", {"x": 1.0, "q": M}, W * mq.sin(Q))]},
        "velocity constraint 'c': ",
    ),
]
"""Parts of the pendulum, and what is said of them."""


@pytest.mark.parametrize(("parts", "said"), REFUSED, ids=[said[:40] for _, said in REFUSED])
def test_what_is_in_another_unit_is_refused(parts: dict[str, Any], said: str) -> None:
    with pytest.raises(MechanismError) as raised:
        _pendulum(**parts)
    assert said in str(raised.value)


ELEMENTS: list[tuple[dict[str, Any], str]] = [
    (
        {"contacts": [mq.Rolling("r", "rod", M)]},
        "contact 'r': its radius: m is in kg, expected m",
    ),
    (
        {"contacts": [mq.Blade("b", "rod", (W, 0, 0))]},
        "contact 'b': its point: w is in 1/s, expected m",
    ),
    (
        {"elements": [mq.Cord("c", ("ground", (0, 0, 0)), (mq.Pulley("rod", K),), ("rod", BOB))]},
        "element 'c': its radius: k is in N/m, expected m",
    ),
    (
        {"elements": [mq.Rack("rack", "hinge", "slide", L, pressure_angle=G)]},
        "element 'rack': its pressure angle: g is in m/s², expected rad",
    ),
]
"""The same of what guides."""


@pytest.mark.parametrize(("parts", "said"), ELEMENTS, ids=[said[:20] for _, said in ELEMENTS])
def test_what_guides_is_checked_as_well(parts: dict[str, Any], said: str) -> None:
    with pytest.raises(MechanismError) as raised:
        _pendulum(**parts)
    assert said in str(raised.value)


def test_what_is_in_its_unit_passes() -> None:
    _pendulum(
        coordinates=mq.Coordinates((), {"x": L * mq.sin(W * T) + 0.3 * T}),
        forces=[
            mq.JointSpring("spiral", "hinge", K * L**2, 0.5),
            mq.Force("push", "rod", BOB, (F * (1 + 0.1 * T), 0, -9.81 * M)),
            mq.Torque("twist", "rod", (0, -F * mq.sqrt(L**2 + (L * Q) ** 2) * mq.sign(Q), 0)),
            mq.JointForce("brake", "hinge", -2 * mq.velocity("q")),
        ],
    )
    row = mq.VelocityConstraint("drive", {"x": L * mq.sin(Q), "q": L**2}, L**2 * W)
    _pendulum(velocity_constraints=[row])


def test_a_letter_without_a_unit_is_in_that_of_its_place() -> None:
    bare = mq.Parameter("b", 2.0)
    assert bare.unit == ""
    _pendulum(mq.rod(bare, bare), parameters=(M, L, K, G, W, bare))


@pytest.mark.parametrize(
    ("unit", "said"),
    [
        ("furlong", "expected a unit of the SI without a prefix, got 'furlong'; state .* in m"),
        ("mm", "state the value in m"),
        ("deg", "state the value in rad"),
        ("kg·banana", r"expected an SI unit, e.g. .* got 'kg·banana' \('banana' is unknown\)"),
        ("kg·", "expected an SI unit"),
        ("kg)", "expected an SI unit"),
        ("(kg", "expected an SI unit"),
        ("m^", "expected an SI unit"),
        ("?", "expected an SI unit"),
        (" ", "expected an SI unit"),
        (3, "expected its unit as text, e.g. 'kg', got 3"),
    ],
)
def test_a_unit_that_is_none_is_refused(unit: Any, said: str) -> None:
    with pytest.raises(InputError, match=said):
        mq.Parameter("l", 1.0, unit)
    with pytest.raises(InputError, match=said):
        mq.Input("F", 1.0, unit)


@pytest.mark.parametrize(
    ("unit", "said"),
    [
        ("kg·m²", "kg·m²"),
        ("kg*m^2", "kg·m²"),
        ("kg m**2/s^2", "N·m"),
        ("J", "N·m"),
        ("N·m·s/rad", "N·m·s"),
        ("N/(m/s)", "N·s/m"),
        ("m³/s²", "m³/s²"),
        ("m/s/s", "m/s²"),
        ("s⁻¹", "1/s"),
        ("V·A", "W"),
        ("kg/(m·s³)", "kg/(m·s³)"),
        ("rad", "1"),
        ("K^5", "K^5"),
    ],
)
def test_units_are_read_and_said(unit: str, said: str) -> None:
    assert say_unit(read_unit(unit)) == said
    assert read_unit(said) == read_unit(unit)


@pytest.mark.parametrize(
    ("unit", "by"),
    [
        *(
            ("Hz", "1/s"),
            ("N", "kg·m/s²"),
            ("Pa", "N/m²"),
            ("J", "N·m"),
            ("W", "J/s"),
            ("C", "A·s"),
        ),
        *(("V", "W/A"), ("F", "C/V"), ("Ω", "V/A"), ("Wb", "V·s"), ("T", "Wb/m²")),
        *(("H", "Wb/A"), ("rad", "m/m"), ("sr", "m²/m²"), ("1", "K/K")),
    ],
)
def test_derived_units_are_those_of_the_si(unit: str, by: str) -> None:
    """BIPM, The International System of Units, 9th ed., 2019, table 4."""
    assert read_unit(unit) == read_unit(by)


def test_the_map_gives_a_coordinate_its_unit() -> None:
    length = units(mq.textbook.load("particle_on_circle_x"))
    assert length == {"x": "m", "x'": "m/s"}
    share = mq.coordinate("u")
    mechanism = _pendulum(coordinates=mq.Coordinates(("u",), {"x": L * share, "q": 3 * share}))
    assert units(mechanism)["u'"] == "rad/s"
    area = _pendulum(coordinates=mq.Coordinates(("u",), {"x": mq.sqrt(share) + L}))
    assert units(area)["u"] == "m²"


@pytest.mark.parametrize("name", mq.textbook.names())
def test_units_of_the_catalogue_are_known(name: str) -> None:
    mechanism = mq.textbook.load(name)
    assert all(parameter.unit for parameter in mechanism.parameters)
    assert all(signal.unit for signal in mechanism.inputs)
    assert all(units(mechanism).values())


def test_letters_of_a_urdf_have_units() -> None:
    text = mq.write_urdf(mq.textbook.load("double_pendulum"))
    mechanism = mq.read_urdf(text, parameters=["masses", "lengths", "inertias"])
    assert {parameter.unit for parameter in mechanism.parameters} == {"kg", "m", "kg·m²"}


def test_the_former_name_of_what_is_stated_warns() -> None:
    cord = mq.Cord("c", ("ground", (0, 0, 0)), (), ("rod", (0, 0, 0)))
    with pytest.warns(DeprecationWarning, match="quantities are called stated"):
        assert cord.quantities == cord.stated
    with pytest.raises(AttributeError, match="'Cord' object has no attribute 'quantity'"):
        assert cord.quantity


KG, METER, SECOND = (1, 0, 0, 0, 0), (0, 1, 0, 0, 0), (0, 0, 1, 0, 0)
LETTERS = Dimensions({"m": KG, "l": METER, "n": PURE}, {"x": METER, "t": SECOND})
m, l, n, x, t, u = sympy.symbols("m l n x t u")


@pytest.mark.parametrize(
    ("expression", "dimension"),
    [
        (2.5, PURE),
        (sympy.pi, PURE),
        (u, None),
        # whole numbers and fractions are pure beside what has a declared unit
        (2 * l, METER),
        (-x, METER),
        (2 * x, None),
        (2.5 * l, None),
        (x * t, (0, 1, 1, 0, 0)),
        (m * l**2 / t**2, (1, 2, -2, 0, 0)),
        (m * u, None),
        (sympy.sqrt(l), (0, Fraction(1, 2), 0, 0, 0)),
        (l ** sympy.Rational(4, 2) * l ** sympy.Rational(1, 3), (0, Fraction(7, 3), 0, 0, 0)),
        (l**0.5, (0, Fraction(1, 2), 0, 0, 0)),
        (sympy.sqrt(l**2), METER),
        (u**2, None),
        (n**3, PURE),
        (2**n, PURE),
        (n**n, PURE),
        (l + 3, METER),
        (l + x, METER),
        (x + t, None),
        (t + t * n, SECOND),
        (sympy.sin(l / x), PURE),
        (sympy.sin(t), PURE),
        (sympy.Abs(l), METER),
        (sympy.sign(l), PURE),
        (sympy.atan2(l, x), PURE),
        (sympy.atan2(x, t), PURE),
    ],
)
def test_dimensions_of_expressions(expression: Any, dimension: Any) -> None:
    assert LETTERS.of(expression) == dimension


@pytest.mark.parametrize(
    ("expression", "said"),
    [
        (l + m, "l + m adds l [m] and m [kg]"),
        (l + m + 3 * m, "adds 4*m [kg] and l [m] (4 counts as a pure number; a Parameter can"),
        (l + x - 2 * l * m, "(-2 counts as a pure number"),
        (m * (l + 2 * m * l) + 2 * l * t, "(2 counts as a pure number"),
        (m - 2 * l, "(-2 counts as a pure number; a Parameter can have a unit)"),
        (sympy.sin(l), "l, of which sin is taken, is in m, expected rad or a pure number"),
        (sympy.exp(l * t), "l*t, of which exp is taken, is in m·s"),
        (2**l, "the exponent l is in m"),
        (l**n, "l, whose exponent is no number, is in m"),
        (sympy.atan2(l, m), "atan2(l, m) compares l [m] with m [kg]"),
        (sympy.Abs(l + m), "adds"),
        (sympy.sign(l + m), "adds"),
    ],
)
def test_what_does_not_fit_in_an_expression_is_said(expression: Any, said: str) -> None:
    with pytest.raises(HomogeneityError) as raised:
        LETTERS.of(expression)
    assert said in str(raised.value)


@pytest.mark.parametrize(
    ("dimension", "said"),
    [
        ((-1, 0, 0, 0, 0), "1/kg"),
        ((0, 4, 0, 0, 0), "m⁴"),
        ((0, -1, -2, 0, 0), "1/(m·s²)"),
        ((2, 1, 0, 0, 0), "kg²·m"),
        ((0, Fraction(1, 2), -1, 0, 0), "m^1/2/s"),
        ((1, -1, -2, 0, 0), "Pa"),
        ((0, 0, 0, 1, 0), "A"),
    ],
)
def test_units_of_dimensions(dimension: Any, said: str) -> None:
    assert say_unit(dimension) == said
