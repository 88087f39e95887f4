"""Every fault of a mechanism is found, named, and told together with all the others."""

from __future__ import annotations

import math
from typing import Any

import pytest
import sympy

from mecanique.errors import InputError, MechanismError
from mecanique.model import (
    Body,
    Coordinates,
    Damper,
    Fixed,
    Force,
    Input,
    JointDamper,
    JointForce,
    JointSpring,
    Limits,
    Loop,
    Mechanism,
    Parameter,
    Placement,
    Planar,
    Prismatic,
    Revolute,
    Shape,
    Spherical,
    Spring,
    Torque,
    box,
    coordinate,
    particle,
    time,
    velocity,
)
from mecanique.model.mechanism.validation import inertia_fault

GROUND, BLOCK = Body("ground"), Body("block", box(1.0, (1, 1, 1)))
SLIDE = Prismatic("slide", "ground", "block", axis=(1, 0, 0), coordinate="x")
NOT, ZERO = math.nan, Parameter("zero", 0.0)
A, B = (0.0, 0.0, 0.0), (1.0, 0.0, 0.0)


def untyped(value: object) -> Any:
    """A value whose type the checker is not to judge: refusing it is what is tested."""
    return value


def faults_of(**fields: Any) -> tuple[str, ...]:
    """The faults of a block on a slide with some fields replaced."""
    sound: dict[str, Any] = {"name": "m", "bodies": (GROUND, BLOCK), "joints": (SLIDE,)}
    with pytest.raises(MechanismError) as caught:
        Mechanism(**{**sound, **fields})
    assert str(caught.value).startswith(f"mechanism {caught.value.name!r} has ")
    assert all(fault in str(caught.value) for fault in caught.value.faults)
    return caught.value.faults


def with_force(force: Any) -> dict[str, Any]:
    return {"forces": (force,), "parameters": (ZERO,)}


def with_body(*shapes: Shape) -> dict[str, Any]:
    return {"bodies": (GROUND, Body("block", *shapes)), "parameters": (ZERO,)}


def with_slide(**fields: Any) -> dict[str, Any]:
    return {"joints": (Prismatic("slide", "ground", "block", **fields),)}


CASES: dict[str, tuple[dict[str, Any], str]] = {
    "no name": ({"name": " "}, "the mechanism has no name"),
    "nameless body": ({"bodies": (GROUND, BLOCK, Body(""))}, "a body has no name"),
    "unprintable": (
        {"bodies": (GROUND, BLOCK, Body("a\x00"))},
        r"body 'a\x00' has unprintable characters in its name",
    ),
    "two bodies": ({"bodies": (GROUND, BLOCK, BLOCK)}, "body 'block' is there 2 times"),
    "two parameters": (
        {"parameters": (ZERO,), "inputs": (Input("zero"),)},
        "parameter or input 'zero' is there 2 times",
    ),
    "shared coordinate": (
        {
            "bodies": (GROUND, BLOCK, Body("other")),
            "joints": (SLIDE, Revolute("r", "block", "other", coordinate="x")),
        },
        "coordinate 'x' belongs to 2 joints",
    ),
    "clash": (
        {"parameters": (Parameter("x", 1.0),)},
        "'x' is both a coordinate and a parameter, an input or time",
    ),
    "map of nothing": (
        {"coordinates": Coordinates((), {"y": 1.0})},
        "the coordinate map sets 'y', which is no joint coordinate",
    ),
    "mapped quaternion": (
        {
            "joints": (Spherical("s", "ground", "block"),),
            "coordinates": Coordinates((), {"s_qx": 0.0}),
        },
        "the coordinate map sets 's_qx', but a quaternion's joint cannot be driven",
    ),
    "scattered quaternion": (
        {
            "bodies": (GROUND, BLOCK, Body("other", BLOCK.shapes[0])),
            "joints": (Spherical("s", "ground", "block"), Revolute("r", "block", "other")),
            "coordinates": Coordinates(("s_qx", "s_qy", "r", "s_qz", "s_qw")),
        },
        "the coordinates of joint 's' must follow one another: s_qx, s_qy, s_qz, s_qw",
    ),
    "quaternion that begins late": (
        {
            "joints": (Spherical("s", "ground", "block"),),
            "coordinates": Coordinates(("s_qy", "s_qz", "s_qw")),
        },
        "the coordinates of joint 's' must follow one another: s_qx, s_qy, s_qz, s_qw",
    ),
    "idle coordinate": (
        {"coordinates": Coordinates(("u",))},
        "coordinate 'u' moves nothing: no joint has it, "
        "and the coordinate map does not depend on it",
    ),
    "free and driven": (
        {"coordinates": Coordinates(("x",), {"x": 2 * coordinate("x")})},
        "'x' is both a generalized coordinate and set by the coordinate map",
    ),
    "map of what is unknown": (
        {"coordinates": Coordinates((), {"x": coordinate("u")})},
        "the map of coordinate 'x' depends on 'u', which is not declared (known: t)",
    ),
    "map is not finite": (
        {"coordinates": Coordinates((), {"x": NOT})},
        "the map of 'x' is not finite",
    ),
    "velocity in the map": (
        {"coordinates": Coordinates(("u",), {"x": coordinate("u") + velocity("u")})},
        "the map of coordinate 'x' depends on \"u'\", which is not declared (known: t, u)",
    ),
    "undeclared in a body": (
        with_body(box(Parameter("M", 1.0), (1, 1, 1))),
        "body 'block' depends on 'M', which is not declared (known: zero)",
    ),
    "time in a body": (
        with_body(particle(time())),
        "body 'block': its mass cannot depend on time",
    ),
    "undeclared in a joint": (
        with_slide(origin=Placement((Parameter("a", 1.0), 0, 0))),
        "joint 'slide' depends on 'a', which is not declared (known: none)",
    ),
    "undeclared in an armature": (
        with_slide(armature=Parameter("J", 1.0)),
        "joint 'slide' depends on 'J', which is not declared (known: none)",
    ),
    "undeclared in gravity": (
        {"gravity": (0, 0, -Parameter("g", 1.0))},
        "gravity depends on 'g', which is not declared (known: none)",
    ),
    "input of a coordinate": (
        {"inputs": (Input("F", 2 * coordinate("x")),)},
        "input 'F' depends on 'x', which is no parameter",
    ),
    "undeclared in a force": (
        with_force(Force("f", "block", A, (Parameter("F", 1.0), 0, 0))),
        "force 'f' depends on 'F', which is not declared (known: t, x, x', zero)",
    ),
    "coordinate in a stiffness": (
        with_force(JointSpring("s", "slide", coordinate("x"))),
        "force 's' depends on 'x', which is not declared (known: zero)",
    ),
    "strange function": (
        with_force(JointForce("f", "slide", sympy.gamma(time()))),
        "force 'f' holds the function gamma; "
        "expected sin, cos, tan, asin, acos, atan, atan2, sqrt, exp, log, Abs, "
        "sign, tanh",
    ),
    "undeclared in a loop": (
        {"loops": (Loop.distance("l", "ground", A, "block", A, Parameter("d", 1.0)),)},
        "loop 'l' depends on 'd', which is not declared (known: none)",
    ),
    "no ground": ({"ground": "earth"}, "the ground 'earth' is no body (bodies: block, ground)"),
    "no parent": (
        {"joints": (Fixed("w", "wall", "block"),)},
        "joint 'w': its parent 'wall' is no body",
    ),
    "no child": (
        {"joints": (SLIDE, Fixed("w", "block", "wall"))},
        "joint 'w': its child 'wall' is no body",
    ),
    "itself": (
        {"joints": (SLIDE, Fixed("w", "block", "block"))},
        "joint 'w' joins body 'block' to itself",
    ),
    "moving ground": (
        {"joints": (SLIDE, Fixed("w", "block", "ground"))},
        "the ground 'ground' is the child of a joint",
    ),
    "two parents": (
        {"joints": (SLIDE, Fixed("w", "ground", "block"))},
        "body 'block' is the child of 2 joints; close loops by a loop constraint, not by a joint",
    ),
    "disconnected": ({"joints": ()}, "body 'block' is not connected to the ground 'ground'"),
    "no axis": (
        with_slide(axis=(0, 0, 0)),
        "joint 'slide': expected an axis with a finite length, got (0.0, 0.0, 0.0)",
    ),
    "nan axis": (
        with_slide(axis=(0, 0, NOT)),
        "joint 'slide': expected an axis with a finite length, got (0.0, 0.0, nan)",
    ),
    "flat plane": (
        {"joints": (Planar("p", "ground", "block", axis=(0, 0, 0)),)},
        "joint 'p': expected an axis with a finite length, got (0.0, 0.0, 0.0)",
    ),
    "limits crossed": (
        with_slide(limits=Limits(1.0, -1.0)),
        "joint 'slide': its lower limit 1 is not below its upper -1",
    ),
    "negative effort": (
        with_slide(limits=Limits(effort=-1.0)),
        "joint 'slide': its limits of effort and velocity must not be negative",
    ),
    "armature": (with_slide(armature=-1.0), "joint 'slide': its armature is negative"),
    "origin": (
        with_slide(origin=Placement((NOT, 0, 0))),
        "joint 'slide': its origin is not finite",
    ),
    "spring to nothing": (
        with_force(Spring("s", "ground", A, "wall", A, 1.0)),
        "force 's': 'wall' is no body",
    ),
    "damper to nothing": (
        with_force(Damper("d", "wall", A, "block", A, 1.0)),
        "force 'd': 'wall' is no body",
    ),
    "force on nothing": (with_force(Force("f", "wall", A, A)), "force 'f': 'wall' is no body"),
    "axes of nothing": (
        with_force(Torque("f", "block", A, axes="wall")),
        "force 'f': 'wall' is no body",
    ),
    "drive of nothing": (
        with_force(JointForce("f", "hinge", 1.0)),
        "force 'f': 'hinge' is no joint with one coordinate",
    ),
    "drive of a ball": (
        {"joints": (Spherical("s", "ground", "block"),), "forces": (JointDamper("d", "s", 1.0),)},
        "force 'd': 's' is no joint with one coordinate",
    ),
    "loop to nothing": (
        {"loops": (Loop.ball("l", "ground", A, "wall", A),)},
        "loop 'l': 'wall' is no body",
    ),
    "loop to itself": (
        {"loops": (Loop.ball("l", "block", A, "block", B),)},
        "loop 'l' joins body 'block' to itself",
    ),
    "loop of no length": (
        {"loops": (Loop.distance("l", "ground", A, "block", A, 0.0),)},
        "loop 'l': expected a length above 0, got 0",
    ),
    "loop frame": (
        {"loops": (Loop.ball("l", "ground", (NOT, 0, 0), "block", A),)},
        "loop 'l': its frame is not finite",
    ),
    "negative mass": (
        with_body(Shape(-2.0)),
        "body 'block': its mass is negative (-2 kg)",
    ),
    "infinite mass": (
        with_body(Shape(math.inf)),
        "body 'block': its mass or inertia is not finite",
    ),
    "nan center": (
        with_body(particle(1.0, (NOT, 0, 0))),
        "body 'block': its center of mass is not finite",
    ),
    "negative inertia": (
        with_body(Shape(1.0, inertia=(1.0, 1.0, -1.0, 0.0, 0.0, 0.0))),
        "body 'block': its inertia has a negative principal moment (-1 kg·m²)",
    ),
    "triangle": (
        with_body(Shape(1.0, inertia=(1.0, 1.0, 3.0, 0.0, 0.0, 0.0))),
        "body 'block': its principal moments break the triangle inequality "
        "(1 + 1 < 3 kg·m²): no mass is spread "
        "like that",
    ),
    "division by zero": (
        with_body(particle(1 / ZERO)),
        "body 'block': its mass cannot be computed (0.0 cannot be raised to a negative power)",
    ),
    "nan gravity": ({"gravity": (0, 0, NOT)}, "gravity is not finite"),
    "stiffness": (
        with_force(JointSpring("s", "slide", -1.0)),
        "force 's': expected a stiffness of at least 0, got -1",
    ),
    "free length": (
        with_force(Spring("s", "ground", A, "block", A, 1.0, -2.0)),
        "force 's': expected a free length of at least 0, got -2",
    ),
    "damping": (
        with_force(JointDamper("d", "slide", NOT)),
        "force 'd': expected a damping of at least 0, got nan",
    ),
    "reference": (
        with_force(JointSpring("s", "slide", 1.0, NOT)),
        "force 's': its reference is not finite",
    ),
    "point": (
        with_force(Spring("s", "ground", (NOT, 0, 0), "block", A, 1.0)),
        "force 's': its point a is not finite",
    ),
    "load": (with_force(Force("f", "block", A, (0, NOT, 0))), "force 'f': its force is not finite"),
    "torque": (
        with_force(Torque("f", "block", (0, math.inf, 0))),
        "force 'f': its torque is not finite",
    ),
    "drive": (with_force(JointForce("f", "slide", 1 / ZERO)), "force 'f': its force is not finite"),
    "imaginary": (
        with_force(JointForce("f", "slide", sympy.sqrt(ZERO - 1))),
        "force 'f': its force is not finite",
    ),
}


@pytest.mark.parametrize("case", CASES)
def test_a_fault_is_named(case: str) -> None:
    fields, fault = CASES[case]
    assert fault in faults_of(**fields)


def test_all_faults_are_told_at_once() -> None:
    found = faults_of(
        name="broken",
        bodies=(GROUND, BLOCK, Body("loose")),
        joints=(SLIDE, Fixed("w", "wall", "block")),
        forces=(JointForce("f", "hinge", Parameter("F", 1.0)),),
        gravity=(0, 0, -Parameter("g", 9.81)),
    )
    expected = (
        "'loose' is not connected",
        "'wall' is no body",
        "'hinge' is no joint",
        "depends on 'F'",
        "depends on 'g'",
    )
    for part in expected:
        assert sum(part in fault for fault in found) == 1, part
    assert sum("2 joints" in fault for fault in found) == 1
    assert len(found) == 6


def test_values_are_judged_together_too() -> None:
    found = faults_of(
        bodies=(GROUND, Body("block", Shape(-1.0))),
        gravity=(NOT, 0, 0),
        forces=(JointSpring("s", "slide", -1.0), JointDamper("d", "slide", -2.0)),
    )
    assert len(found) == 4


def test_one_fault_is_one_fault() -> None:
    with pytest.raises(
        MechanismError, match=r"^mechanism 'm' has 1 fault:\n  gravity is not finite$"
    ):
        Mechanism("m", (GROUND, BLOCK), (SLIDE,), gravity=(NOT, 0, 0))


def test_sound_descriptions_pass() -> None:
    mechanism = Mechanism(
        "sound",
        (GROUND, BLOCK),
        (
            Prismatic(
                "slide", "ground", "block", coordinate="x", limits=Limits(-1.0, 1.0), armature=0.5
            ),
        ),
        forces=(
            JointForce("drive", "slide", coordinate("x") * velocity("x") * time() + ZERO),
            Force("push", "block", A, (Input("F") * 2, 0, 0), axes="block"),
            Spring("s", "ground", B, "block", A, 3.0, 0.5),
        ),
        parameters=(ZERO,),
        inputs=(Input("F", ZERO + time()),),
    )
    assert mechanism.nq == 1


@pytest.mark.parametrize(
    ("mass", "inertia", "expected"),
    [
        (1.0, (1.0, 1.0, 2.0, 0.0, 0.0, 0.0), None),
        (0.0, (0.0,) * 6, None),
        (2.0, (2.0, 2.0, 2.0, 0.5, -0.5, 0.5), None),
        (1.0, (1.0, 1.0, 2.1, 0.0, 0.0, 0.0), "triangle"),
        (1.0, (1.0, 1.0, 1.0, 1.5, 0.0, 0.0), "negative principal moment"),
        (-1.0, (1.0, 1.0, 1.0, 0.0, 0.0, 0.0), "negative"),
        (1.0, (math.nan, 1.0, 1.0, 0.0, 0.0, 0.0), "not finite"),
    ],
)
def test_what_is_wrong_with_an_inertia(
    mass: float, inertia: tuple[float, ...], expected: str | None
) -> None:
    found = inertia_fault(mass, inertia)
    assert (found is None) if expected is None else (found is not None and expected in found)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (
            lambda: Spring("s", "a", untyped((0, 0)), "b", A, 1.0),
            "expected three components for point_a of 's'",
        ),
        (lambda: Force("f", "a", A, untyped((1, 2))), "expected three components for force of 'f'"),
        (
            lambda: JointForce("f", "j", "1"),
            "expected a number, a parameter or an expression, got '1'",
        ),
        (
            lambda: Loop.hinge("l", "a", A, "b", A, (0, 0, 0)),
            "expected a finite vector with a length for the axis of a loop",
        ),
        (
            lambda: Loop("l", untyped("glue"), "a", Placement(), "b", Placement()),
            "loop 'l': expected a kind among ball",
        ),
    ],
)
def test_what_cannot_be_written_down_is_refused_at_once(make: Any, message: str) -> None:
    with pytest.raises(InputError, match=message):
        make()
