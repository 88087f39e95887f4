"""Where faults begin: each bound is held on both of its sides."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import mecanique as mq
from mecanique.errors import InputError
from mecanique.model.guides import cord_fault, mesh_fault, work_fault
from mecanique.model.mechanism.validation import find_broken, inertia_fault
from mecanique.model.parameters import Parameter
from mecanique.model.statements import NumberRule
from mecanique.model.values import column_of, names_of, numbers_of, whole

a, b = Parameter("a", 1.0), Parameter("b", 2.0)


@pytest.mark.parametrize(
    ("rule", "values", "fault"),
    [
        ({"gap": a}, {"a": 0.0}, None),
        ({"gap": a}, {"a": -1e-300}, "it: 2"),
        ({"gap": a, "strict": True}, {"a": 0.0}, "it: 2"),
        ({"gap": a, "strict": True}, {"a": 1e-300}, None),
        ({"gap": a}, {"a": math.inf}, "it: 2"),
        ({"gap": a, "endless": True}, {"a": math.inf}, None),
        ({"gap": a, "endless": True}, {"a": math.nan}, "it: 2"),
        ({}, {"a": math.inf, "b": 2.0}, None),
        ({}, {"b": math.inf}, "it: inf"),
        ({"gap": 1 / a}, {"a": 0.0}, "it: 2"),
    ],
)
def test_a_rule_is_broken_beyond_its_bound(
    rule: dict[str, Any], values: dict[str, float], fault: str | None
) -> None:
    values = {"b": 2.0, **values}
    assert NumberRule("it", ": {}", (b,), **rule).fault(values) == fault


def test_a_rule_that_follows_is_silent_where_the_one_before_it_is_broken() -> None:
    first, second = NumberRule("a", " < 0", gap=a), NumberRule("b", " < 0", gap=b, follows=True)
    assert find_broken([first, second, first], {"a": -1.0, "b": -1.0}) == ["a < 0"]
    assert find_broken([first, second], {"a": 1.0, "b": -1.0}) == ["b < 0"]
    # nothing is said of what varies in a motion
    assert find_broken([first, second], {"b": -1.0}) == ["b < 0"]


@pytest.mark.parametrize(
    ("mass", "moments", "fault"),
    [
        (0.0, (0, 0, 0, 0, 0, 0), None),
        (-1e-300, (0, 0, 0, 0, 0, 0), "its mass is negative (-1e-300 kg)"),
        (math.inf, (1, 1, 1, 0, 0, 0), "its mass or inertia is not finite"),
        (1.0, (1, 1, math.nan, 0, 0, 0), "its mass or inertia is not finite"),
        # a plate, whose moments are just possible, and beyond
        (1.0, (1, 2, 3, 0, 0, 0), None),
        (1.0, (1, 2, 3 + 2e-9, 0, 0, 0), None),
        (1.0, (1, 2, 3 + 4e-9, 0, 0, 0), "break the triangle inequality (1 + 2 < 3 kg·m²)"),
        # a rod, whose least moment is zero up to rounding, and beyond
        (1.0, (1, 1, -5e-10, 0, 0, 0), None),
        (1.0, (1, 1, -2e-9, 0, 0, 0), "a negative principal moment (-2e-09 kg·m²)"),
        # a point as wide as 1e-7 m
        (1.0, (0, 0, 0.9e-14, 0, 0, 0), None),
        (1.0, (0, 0, 1.1e-14, 0, 0, 0), "break the triangle inequality"),
        (0.5, (0, 0, 0.9e-14, 0, 0, 0), "break the triangle inequality"),
        # principal moments 1 ± 2, 2 in axes turned by 45°
        (1.0, (1, 1, 2, 2, 0, 0), "a negative principal moment (-1 kg·m²)"),
        (1.0, (2, 1, 1, 0, 0, 2), "a negative principal moment (-1 kg·m²)"),
        (1.0, (1, 2, 1, 0, 2, 0), "a negative principal moment (-1 kg·m²)"),
    ],
)
def test_masses_and_inertias_are_possible_up_to_rounding(
    mass: float, moments: tuple[float, ...], fault: str | None
) -> None:
    said = inertia_fault(mass, moments)
    assert said is None if fault is None else fault in str(said)
    assert inertia_fault(abs(mass), moments, real=False) == (
        said if "finite" in str(said) else None
    )


PAIR = mq.Mechanism(
    "pair",
    (mq.Body("ground"), mq.Body("p", mq.disk(1.0, 0.3)), mq.Body("q", mq.disk(1.0, 0.1))),
    (
        mq.Revolute("P", "ground", "p"),
        mq.Revolute("Q", "ground", "q", origin=mq.Placement((0.4, 0, 0))),
    ),
    coordinates=mq.Coordinates(()),
)
UP, OUT, APART = np.array([0.0, 0, 1]), np.array([1.0, 0, 0]), "m apart, its radii need"
START = np.array([0.2, -0.1, 0.5])


@pytest.mark.parametrize("off", [-1.5, -0.5, 0.5, 1.5])
@pytest.mark.parametrize("internal", [False, True])
def test_wheels_in_mesh_touch_within_a_billionth(off: float, internal: bool) -> None:
    """Seen along their axes; the bound is 1e-9 times 1 m and the radius."""
    gear = mq.Gear("mesh", "P", "Q", 0.3, other_radius=0.1, internal=internal)
    distance = (0.2 if internal else 0.4) + off * 1e-9 * 1.3
    end = START + distance * np.array([0.6, 0.8, 0]) + 0.7 * UP
    for line in (UP, -UP):
        said = mesh_fault(PAIR, gear, (UP, line), (START, end))
        assert (APART in said) == (abs(off) > 1)
    assert bool(said) == (abs(off) > 1)


@pytest.mark.parametrize("off", [-1.5, -0.5, 0.5, 1.5])
def test_a_rack_touches_its_pinion_within_a_billionth(off: float) -> None:
    rack = mq.Rack("teeth", "P", "Q", 0.3)
    end = START + (0.3 + off * 1e-9 * 1.3) * np.array([0, -1, 0]) + 0.9 * OUT - 0.2 * UP
    assert bool(mesh_fault(PAIR, rack, (UP, OUT), (START, end))) == (abs(off) > 1)
    tilted = np.array([1, 0, off * 1e-9])
    said = mesh_fault(PAIR, rack, (UP, tilted), (START, START + 0.3 * np.array([0, -1, 0])))
    assert ("expected a slide normal to the hinge" in said) == (abs(off) > 1)


@pytest.mark.parametrize("slant", [0.4, math.pi / 2, 2.3])
@pytest.mark.parametrize("sides", [(1, 1), (1, -1), (-1, 1), (-1, -1)])
@pytest.mark.parametrize("off", [-1.5, -0.5, 0.5, 1.5])
def test_bevel_wheels_touch_within_a_billionth(
    slant: float, sides: tuple[int, int], off: float
) -> None:
    """The axes meet, and the pitch circles touch in their plane, wherever they do."""
    gear = mq.Gear("mesh", "P", "Q", 0.3, other_radius=0.1)
    c, s = math.cos(slant), math.sin(slant)
    line, across = np.array([s, 0, c]), np.array([0, 1.0, 0])
    x, y = 0.3 * sides[0], 0.1 * sides[1]
    near, far = (y + c * x) / s, (x + c * y) / s
    start, end = START + near * UP, START + far * line
    bound = 1e-9 * 1.3
    said = mesh_fault(PAIR, gear, (UP, line), (start, end + off * bound * line))
    assert ("its pitch cones do not share an apex" in said) == (abs(off) > 1)
    if said:
        assert f"The wheels are {abs(near):.6g} and {abs(far):.6g} m from where" in said
    said = mesh_fault(PAIR, gear, (UP, line), (start, end + off * bound * across))
    assert ("they pass each other" in said) == (abs(off) > 1)


def belt(**given: Any) -> mq.Belt:
    wheels = (mq.Pulley("p", 0.3), mq.Pulley("q", 0.1))
    return mq.Belt("belt", given.get("over", wheels), normal=(0, 0, 1))


def runs(cord: mq.Cord | mq.Belt, *places: tuple[float, float, float]) -> str:
    return cord_fault(PAIR, cord, np.array(places), UP)


@pytest.mark.parametrize(
    ("far", "overlap"), [(0.4 - 1e-9, True), (0.4 + 1e-9, False), (2.0, False)]
)
def test_pulleys_of_a_belt_have_room(far: float, overlap: bool) -> None:
    places = (0, 0, 0), (far, 0, 0), (0, 0, 0)
    for over in (
        (mq.Pulley("p", 0.3), mq.Pulley("q", 0.1)),
        (mq.Pulley("p", 0.3), mq.Pulley("q", 0.1, -1)),
    ):
        said = runs(belt(over=over), *places)
        crossed = over[1].sense == -1
        # a crossed belt has no straight run at all where they overlap
        word = "has no straight run" if crossed else "overlap"
        assert (word in said) == overlap
        assert bool(said) == overlap


def test_a_run_is_straight_where_its_circles_leave_room_and_lies_in_its_plane() -> None:
    cord = mq.Cord("cord", ("ground", (0, 0, 0)), (mq.Pulley("p", 0.3, -1),), ("q", (0, 0, 0)))
    assert runs(cord, (0, 0, 0), (0.4, 0, 0), (1, 0, 0)) == ""
    said = runs(cord, (0, 0, 0), (0.3, 0, 0), (1, 0, 0))
    assert "cord 'cord' has no straight run from 'ground' to 'p', 0.3 m apart" in said
    assert "from 'p' to 'q', 0.2 m apart" in runs(cord, (0, 0, 0), (0.4, 0, 0), (0.6, 0, 0))
    bound = 1e-9 * 2
    assert runs(cord, (0, 0, 0), (1, 0, 0.9 * bound), (2, 0, 0)) == ""
    said = runs(cord, (0, 0, 0), (1, 0, -1.1 * bound), (2, 0, 0))
    assert "leaves its plane from 'ground' to 'p', 1 m apart" in said
    # the worst of many positions
    many = np.array([[(0, 0, 0), (1, 0, 0), (2, 0, 0)], [(0, 0, 0), (0.2, 0, 0), (2, 0, 0)]])
    assert "0.2 m apart" in cord_fault(PAIR, cord, many, UP)


def test_elements_do_no_work_beyond_rounding() -> None:
    gear = mq.Gear("mesh", "P", "Q", 0.3, other_radius=0.1)
    rope = mq.Cord("rope", ("ground", (0, 0, 0)), (mq.Pulley("p", 0.3),), ("q", (0, 0, 0)))
    machine = mq.Mechanism("pair", PAIR.bodies, PAIR.joints, elements=(gear, rope))
    work = np.zeros((2, machine.nv, 3))
    assert work_fault(machine, work) == work_fault(machine, work[:0]) == ""
    work[1, 0, 0] = -1e-8
    assert work_fault(machine, work) == ""
    work[1, 0, 0] = -1.1e-8
    said = work_fault(machine, work)
    assert (
        "gear 'mesh' does not fit the coordinate map, in which mesh does the work -1.1e-08" in said
    )
    assert said.endswith("or the map")
    work[0, 0, 2] = 0.5
    assert "cord 'rope' does not fit the coordinate map, in which rope_2 does the work 0.5" in (
        work_fault(machine, work)
    )
    assert "Coordinates(…, {'P': …})" in work_fault(machine, work)


def test_numbers_by_name_in_order_or_many() -> None:
    zero, names = np.zeros(2), ("x", "y")
    np.testing.assert_array_equal(numbers_of(None, names, "it", zero + 3), [3, 3])
    given: Any = {"y": [1.0, 2.0]}
    many = numbers_of(given, names, "it", zero, many=True)
    np.testing.assert_array_equal(many, [[0, 1], [0, 2]])
    for given, wrong in (
        ([[1.0, 2.0]], r"expected shape \(2,\) for the it values \(x, y\), got \(1, 2\)"),
        ({"x": [1.0]}, "expected a finite number for it x"),
        ([math.nan, 0.0], r"expected finite it values, got \[nan, 0.0\]"),
    ):
        with pytest.raises(InputError, match=wrong):
            numbers_of(given, names, "it", zero)
    for given, wrong in (
        ([[[1.0, 2.0]]], r"expected shape \(2,\) or \(n, 2\) for the it values"),
        ({"x": [1.0], "y": [1.0, 2.0]}, r"expected one number of it values each, got \[1, 2\]"),
        (
            [[0.0, math.inf]] + [[0.0, 0.0]] * 4,
            r"expected finite it values, got \[inf\] among them",
        ),
    ):
        with pytest.raises(InputError, match=wrong):
            numbers_of(given, names, "it", zero, many=True)


def test_columns_whole_numbers_and_names() -> None:
    assert column_of(2, "it").shape == ()
    np.testing.assert_array_equal(column_of([1, 2], "it"), [1.0, 2.0])
    for given, wrong in (
        ([], "expected at least one number for it, got none"),
        ([[1.0]], r"expected a number or shape \(n,\) for it, got shape \(1, 1\)"),
        ([1.0, math.nan], r"expected finite numbers for it, got \[1.0, nan\]"),
        (["a"], "expected numbers for it, got"),
        ("1", "expected a finite number for it, got '1'"),
    ):
        with pytest.raises(InputError, match=wrong):
            column_of(given, "it")
    assert (whole(1, "it"), whole(np.int64(5), "it", 5, 5)) == (1, 5)
    for number, least, most in ((0, 1, None), (6, 1, 5), (True, 0, None), (1.0, 0, None)):
        with pytest.raises(InputError, match=r"expected (a whole number of at least|at most)"):
            whole(number, "it", least, most)
    assert names_of("ab", "it") == ("ab",)
    assert names_of(["a", "b"], "it") == ("a", "b")
    with pytest.raises(InputError, match="expected names for it, got 3"):
        names_of(3, "it")
    with pytest.raises(InputError, match=r"expected names for it, got \['a', 3\]"):
        names_of(["a", 3], "it")


def test_limits_bound_a_position_on_either_side() -> None:
    assert mq.Limits(lower=0.0).bounded
    assert mq.Limits(upper=0.0).bounded
    assert not mq.Limits(effort=1.0, velocity=1.0).bounded


STRIKING: list[Any] = [
    mq.Stop("s", "j", restitution=a),
    mq.Contact("c", "b", restitution=a),
    mq.Capstan("c", "j", "k", length=b, wrap=b, restitution=a),
]


@pytest.mark.parametrize("part", STRIKING, ids=lambda part: type(part).__name__)
@pytest.mark.parametrize(("e", "sound"), [(-1e-9, 0), (0, 1), (0.5, 1), (1, 1), (1 + 1e-9, 0)])
def test_a_restitution_is_from_zero_to_one(part: Any, e: float, sound: int) -> None:
    broken = find_broken(part.rules(), {"a": e, "b": 2.0})
    assert bool(broken) != bool(sound)
    assert all("expected a restitution in 0…1" in fault for fault in broken)


BOUNDS: list[tuple[Any, float, bool, str]] = [
    # what states a number a, its bound, whether it may be that, and the words where it is beyond
    (mq.Spring("s", "b", (0, 0, 0), "c", (0, 0, 0), a), 0.0, True, "a stiffness of at least 0"),
    (mq.Spring("s", "b", (0, 0, 0), "c", (0, 0, 0), 1, a), 0.0, True, "free length of at least 0"),
    (mq.Damper("s", "b", (0, 0, 0), "c", (0, 0, 0), a), 0.0, True, "a damping of at least 0"),
    (mq.JointSpring("s", "j", a), 0.0, True, "a stiffness of at least 0"),
    (mq.JointDamper("s", "j", a), 0.0, True, "a damping of at least 0"),
    (mq.Loop.distance("l", "b", (0, 0, 0), "c", (0, 0, 0), a), 0.0, False, "a length above 0"),
    (mq.Friction("f", "j", a, 1.0, mu_static=9.0), 0.0, True, "friction of at least 0"),
    (mq.Friction("f", "j", 2.0, 1.0, mu_static=a), 2.0, True, "at least the kinetic 2"),
    (mq.Friction("f", "j", 0.1, load=a), 0.0, True, "a load of at least 0"),
    (mq.Stop("s", "j", stiffness=a), 0.0, False, "a stiffness above 0"),
    (mq.Stop("s", "j", holds=a), 0.0, True, "a pull that it holds of at least 0"),
    (mq.Capstan("c", "j", "k", length=a, wrap=1.0), 0.0, False, "a length above 0"),
    (mq.Capstan("c", "j", "k", length=1.0, wrap=a), 0.0, False, "a wrap above 0"),
    (mq.Contact("c", "b", radius=a), 0.0, True, "a radius of at least 0"),
    (mq.Contact("c", "b", radius=a, axis=(0, 1, 0)), 0.0, False, "a radius above 0"),
    (mq.Contact("c", "b", mu=a, mu_static=9.0), 0.0, True, "friction of at least 0"),
    (mq.Rolling("r", "b", a), 0.0, False, "a radius above 0"),
    (mq.Rolling("r", "b", a, axis=None), 0.0, True, "a radius of at least 0"),
    (mq.Rolling("r", "b", 2.0, crown=a), 0.0, True, "a crown radius from 0"),
    (mq.Rolling("r", "b", a, crown=2.0), 2.0, True, "to the radius 1.9"),
    (mq.Rolling("r", "b", 2.0, friction=a), 0.0, True, "friction of at least 0"),
    (
        mq.Rolling("r", "b", 2.0, axis=None, bowl=a),
        2.0,
        False,
        "a bowl's radius above the ball's 2",
    ),
    (mq.Rolling("r", "b", 2.0, axis=None, stretch=(1, a, 1)), 0.0, False, "a stretch above 0"),
]


@pytest.mark.parametrize(("part", "bound", "included", "words"), BOUNDS)
def test_what_parts_state_keeps_to_its_bound(
    part: Any, bound: float, included: bool, words: str
) -> None:
    def fault(value: float) -> str:
        return "; ".join(find_broken(part.rules(), {"a": value}))

    assert fault(bound + 0.1) == ""
    assert (fault(bound) == "") == included
    for value in (bound - 0.1, *(() if included else (bound,))):
        assert words.replace("1.9", f"{value:g}") in fault(value)


def test_a_dome_is_a_bowl_of_negative_radius() -> None:
    for bowl, sound in ((-3.0, True), (-0.1, True), (0.1, False), (1.9, False), (2.1, True)):
        ball = mq.Rolling("r", "b", 2.0, axis=None, bowl=a)
        assert (find_broken(ball.rules(), {"a": bowl}) == []) == sound


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda x: mq.Gear("g", "P", "Q", 1.0, other_radius=1.0, pressure_angle=x), "from 0 to"),
        (lambda x: mq.Rack("g", "P", "Q", 1.0, pressure_angle=x), "to less than π/2"),
    ],
)
def test_a_pressure_angle_is_below_a_right_angle(make: Any, message: str) -> None:
    for angle in (0.0, 1.5, math.pi / 2 - 1e-12):
        make(angle)
    for angle in (-1e-12, math.pi / 2, 2.0):
        with pytest.raises(InputError, match=message):
            make(angle)


def test_what_presses_and_what_rubs() -> None:
    """Rows of joints: the gap and its force, the slip and its coefficients."""
    (stop,) = mq.Stop("s", "j", at=0.3, side=-1).joint_rows
    assert (stop.letter, stop.weights, stop.offset) == ("N", (("j", 1),), -0.3)
    (stop,) = mq.Stop("s", "j", at=0.3).joint_rows
    assert (stop.weights, stop.offset) == ((("j", -1),), 0.3)
    (slip,) = mq.Friction("f", "j", 0.1, 5.0, speed=2.0).joint_rows
    assert (slip.letter, slip.weights, slip.offset, slip.speed) == ("R", (("j", 1.0),), None, 2.0)
    assert mq.Friction("f", "j", 0.1, 5.0, mu_static=0.3).coefficients == (0.5, 1.5)
    assert mq.Friction("f", "j", 0.1, "floor").coefficients == (0.1, 0.1)
    drum = mq.Capstan("c", "j", "k", length=3.0, wrap=1.2, mu=0.4, mu_static=0.5, speed=0.7)
    slack, slip = drum.joint_rows
    assert (slack.weights, slack.offset) == ((("j", -1.0), ("k", -1.0)), 3.0)
    assert (slip.weights, slip.speed) == ((("j", 0.5), ("k", -0.5)), 0.7)
    # Euler: T₁ = e^(μ φ) T₂, of a mean of one newton
    for coefficient, mu in zip(drum.coefficients, (0.4, 0.5), strict=True):
        larger, smaller = 1 + float(coefficient) / 2, 1 - float(coefficient) / 2
        assert larger / smaller == pytest.approx(math.exp(mu * 1.2), rel=1e-12)
