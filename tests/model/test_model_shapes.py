"""Every shape's mass, center and inertia against quadrature over its points."""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import suppress
from itertools import product
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from mecanique.errors import InputError
from mecanique.model import (
    Body,
    Box,
    Cylinder,
    Fixed,
    Floating,
    Helical,
    Limits,
    Mesh,
    Parameter,
    Placement,
    Planar,
    Prismatic,
    Revolute,
    Shape,
    Sphere,
    Spherical,
    Universal,
    Visual,
    ball,
    bar,
    box,
    cloud,
    cone,
    cylinder,
    disk,
    massless,
    particle,
    plate,
    ring,
    rod,
    shell,
)
from mecanique.model.bodies.tensor import moments_of
from mecanique.model.expression import evaluate

Array = npt.NDArray[np.float64]
Points = tuple[Array, Array]

NODES, WEIGHTS = np.polynomial.legendre.leggauss(6)
CIRCLE = 2 * np.pi * np.arange(12) / 12
SIDES = st.floats(0.05, 3.0)
ANGLES = st.floats(-3.1, 3.1)


def untyped(value: object) -> Any:
    """A value whose type the checker is not to judge: refusing it is what is tested."""
    return value


def along(low: float, high: float) -> list[tuple[float, float]]:
    """Gauss points and weights of an interval; exact for the polynomials that occur."""
    half = (high - low) / 2
    return [(low + half * (1 + x), half * w) for x, w in zip(NODES, WEIGHTS, strict=True)]


def collect(points: list[tuple[float, float, float, float]]) -> Points:
    array = np.array(points)
    return array[:, :3], array[:, 3] / array[:, 3].sum()


def of_rod(
    length: float, direction: tuple[float, float, float], start: tuple[float, float, float]
) -> Points:
    unit = np.array(direction) / np.linalg.norm(direction)
    places = along(0, length)
    return np.array([start + s * unit for s, _ in places]), np.array(
        [w for _, w in places]
    ) / length


def of_box(a: float, b: float, c: float) -> Points:
    grid = product(along(-a / 2, a / 2), along(-b / 2, b / 2), along(-c / 2, c / 2))
    return collect([(x, y, z, u * v * w) for (x, u), (y, v), (z, w) in grid])


def of_plate(a: float, b: float) -> Points:
    grid = product(along(-a / 2, a / 2), along(-b / 2, b / 2))
    return collect([(x, y, 0.0, u * v) for (x, u), (y, v) in grid])


def of_disk(radius: float) -> Points:
    grid = product(along(0, radius), CIRCLE)
    return collect([(r * math.cos(f), r * math.sin(f), 0.0, w * r) for (r, w), f in grid])


def of_ring(radius: float) -> Points:
    return collect([(radius * math.cos(f), radius * math.sin(f), 0.0, 1.0) for f in CIRCLE])


def of_cylinder(radius: float, length: float) -> Points:
    grid = product(along(0, radius), CIRCLE, along(-length / 2, length / 2))
    return collect([(r * math.cos(f), r * math.sin(f), z, w * u * r) for (r, w), f, (z, u) in grid])


def of_ball(radius: float) -> Points:
    grid = product(along(0, radius), along(-1, 1), CIRCLE)
    return collect(
        [
            (
                r * math.sqrt(1 - c * c) * math.cos(f),
                r * math.sqrt(1 - c * c) * math.sin(f),
                r * c,
                w * u * r * r,
            )
            for (r, w), (c, u), f in grid
        ]
    )


def of_shell(radius: float) -> Points:
    grid = product(along(-1, 1), CIRCLE)
    return collect(
        [
            (
                radius * math.sqrt(1 - c * c) * math.cos(f),
                radius * math.sqrt(1 - c * c) * math.sin(f),
                radius * c,
                w,
            )
            for (c, w), f in grid
        ]
    )


def of_cone(radius: float, height: float) -> Points:
    grid = product(along(0, height), along(0, 1), CIRCLE)
    points = []
    for (z, w), (part, u), f in grid:
        r = part * radius * z / height
        points.append((r * math.cos(f), r * math.sin(f), z, w * u * part * (z / height) ** 2))
    return collect(points)


def moments(mass: float, points: Points) -> tuple[Array, Array]:
    """Center of mass and inertia tensor about it, ∫ (p² 1 − p pᵀ) dm."""
    places, parts = points
    center = parts @ places
    arms = places - center
    tensor = np.einsum("n,nij->ij", mass * parts, np.einsum("nk,nk,ij->nij", arms, arms, np.eye(3)))
    return center, tensor - np.einsum("n,ni,nj->ij", mass * parts, arms, arms)


def tensor_of(inertia: tuple[Any, ...]) -> Array:
    ixx, iyy, izz, ixy, ixz, iyz = (float(entry) for entry in inertia)
    return np.array([[ixx, ixy, ixz], [ixy, iyy, iyz], [ixz, iyz, izz]])


SHAPES: dict[str, tuple[Callable[..., Shape], Callable[..., Points]]] = {
    "rod": (
        lambda m, a, b, c: rod(m, a, (b, -c, 1.0), (c, a, -b)),
        lambda a, b, c: of_rod(a, (b, -c, 1.0), (c, a, -b)),
    ),
    "box": (lambda m, a, b, c: box(m, (a, b, c)), of_box),
    "plate": (lambda m, a, b, c: plate(m, (a, b)), lambda a, b, c: of_plate(a, b)),
    "disk": (lambda m, a, b, c: disk(m, a), lambda a, b, c: of_disk(a)),
    "ring": (lambda m, a, b, c: ring(m, a), lambda a, b, c: of_ring(a)),
    "cylinder": (lambda m, a, b, c: cylinder(m, a, b), lambda a, b, c: of_cylinder(a, b)),
    "ball": (lambda m, a, b, c: ball(m, a), lambda a, b, c: of_ball(a)),
    "shell": (lambda m, a, b, c: shell(m, a), lambda a, b, c: of_shell(a)),
    "cone": (lambda m, a, b, c: cone(m, a, b), lambda a, b, c: of_cone(a, b)),
}


@pytest.mark.parametrize("name", SHAPES)
@settings(deadline=None, max_examples=25)
@given(mass=SIDES, a=SIDES, b=SIDES, c=SIDES)
def test_center_and_inertia_are_those_of_the_points(
    name: str, mass: float, a: float, b: float, c: float
) -> None:
    make, points_of = SHAPES[name]
    shape = make(mass, a, b, c)
    center, tensor = moments(mass, points_of(a, b, c))
    size = max(1.0, float(abs(tensor).max()))
    np.testing.assert_allclose([float(x) for x in shape.center], center, rtol=0, atol=1e-12)
    np.testing.assert_allclose(tensor_of(shape.inertia), tensor, rtol=0, atol=1e-12 * size)
    assert shape.mass == mass
    assert shape.visuals


@pytest.mark.parametrize("name", SHAPES)
@settings(deadline=None, max_examples=25)
@given(xyz=st.tuples(SIDES, SIDES, SIDES), rpy=st.tuples(ANGLES, ANGLES, ANGLES))
def test_a_moved_shape_has_moved_points(
    name: str, xyz: tuple[float, float, float], rpy: tuple[float, float, float]
) -> None:
    make, points_of = SHAPES[name]
    places, parts = points_of(0.7, 1.1, 0.4)
    moved = Rotation.from_euler("xyz", rpy).apply(places) + xyz
    center, tensor = moments(1.3, (moved, parts))
    shape = make(1.3, 0.7, 1.1, 0.4).at(xyz, rpy)
    np.testing.assert_allclose([float(x) for x in shape.center], center, rtol=0, atol=1e-12)
    np.testing.assert_allclose(tensor_of(shape.inertia), tensor, rtol=0, atol=1e-12)
    whole = np.column_stack([moved, np.ones(len(moved))])
    integral = 1.3 * (whole.T * parts) @ whole  # ∫ (p, 1)(p, 1)ᵀ dm
    np.testing.assert_allclose(moments_of(1.3, center, tensor), integral, rtol=0, atol=1e-11)


def test_pieces_of_a_body_add_up_about_the_common_center() -> None:
    turn = (0.3, -0.8, 1.2)
    body = Body(
        "whole",
        ball(2, 0.3).at((1, 0, 0)),
        box(1, (0.2, 0.4, 0.6)).at((0, -1, 0.5), turn),
        bar(4.0),
    )
    ball_places, ball_parts = of_ball(0.3)
    box_places, box_parts = of_box(0.2, 0.4, 0.6)
    turned = Rotation.from_euler("xyz", turn).apply(box_places)
    places = np.vstack([ball_places + np.array([1, 0, 0]), turned + np.array([0, -1, 0.5])])
    center, tensor = moments(3.0, (places, np.concatenate([2 * ball_parts, box_parts]) / 3))
    assert body.mass == 3
    np.testing.assert_allclose([float(x) for x in body.center], center, rtol=0, atol=1e-14)
    np.testing.assert_allclose(tensor_of(body.inertia), tensor, rtol=0, atol=1e-13)
    assert len(body.visuals) == 3


def test_a_cloud_is_its_particles() -> None:
    random = np.random.default_rng(4)
    masses, places = random.uniform(0.1, 2, 5), random.normal(size=(5, 3))
    shape = cloud(masses.tolist(), places.tolist())
    center, tensor = moments(masses.sum(), (places, masses / masses.sum()))
    assert shape.mass == pytest.approx(masses.sum(), rel=1e-12)
    np.testing.assert_allclose(shape.center, center, rtol=0, atol=1e-15)
    np.testing.assert_allclose(tensor_of(shape.inertia), tensor, rtol=0, atol=1e-13)


def test_symbolic_inertias_stay_exact() -> None:
    from sympy import Rational, Symbol

    m, l = Parameter("m", 1.0, "kg"), Parameter("l", 2.0, "m")
    shape = rod(m, l)
    assert shape.inertia[:3] == (Symbol("m") * Symbol("l") ** 2 * Rational(1, 12),) * 2 + (0,)
    assert shape.center[2] == -Symbol("l") / 2
    assert evaluate(shape.inertia[0], {"m": 3.0, "l": 2.0}) == 1.0


def test_what_has_no_mass_has_no_inertia() -> None:
    for shape in (massless(), bar(2.0), bar(1.0, (1, 1, 0))):
        assert shape.mass == 0
        assert shape.inertia == (0,) * 6
    empty = Body("empty")
    assert (empty.mass, empty.center, empty.visuals) == (0, (0, 0, 0), ())
    assert particle(2.0, (1, 2, 3)).center == (1, 2, 3)


def test_drawings_have_the_stated_sizes_and_places() -> None:
    (drawn,) = rod(1.0, 2.0, (1, 0, 0), (0, 0, 1)).visuals
    assert drawn.geometry == Cylinder(0.02, 2.0)
    assert drawn.placement.xyz == (1.0, 0.0, 1.0)
    axis = np.array(drawn.placement.rotation, dtype=float) @ [0, 0, 1]
    np.testing.assert_allclose(axis, [1, 0, 0], rtol=0, atol=1e-15)
    (drawn,) = box(1.0, (1, 2, 3)).at((0, 0, 5)).colored((1, 0, 0, 1)).visuals
    assert drawn.geometry == Box((1.0, 2.0, 3.0))
    assert drawn.placement.xyz == (0, 0, 5)
    assert drawn.rgba == (1, 0, 0, 1)
    assert particle(1.0).visuals[0].geometry == Sphere(0.05)
    # a cone by its base, an eighth of it high, and its axis
    base, stick = cone(1.0, 0.8, 3.2).visuals
    assert (base.geometry, base.placement.xyz) == (Cylinder(0.8, 0.4), (0, 0, 3.0))
    assert (stick.geometry, stick.placement.xyz) == (Cylinder(0.1, 3.2), (0, 0, 1.6))


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (
            lambda: rod(1, 1, (0, 0, 0)),
            "with a length for the direction of a rod, got \\(0, 0, 0\\)",
        ),
        (lambda: rod(1, 1, ("x", 0, 0)), "expected three numbers for the direction of a rod"),
        (lambda: rod("1", 1), "expected a number, a parameter or an expression, got '1'"),
        (lambda: box(1, (1, 2)), "expected three components for size of a box"),
        (lambda: cloud([1.0], []), "expected one mass for each point, got 1 masses and 0 points"),
        (lambda: cloud([], []), "expected one mass for each point"),
        (lambda: Shape(1.0, inertia=untyped((1.0, 1.0))), "expected six entries"),
        (lambda: Body("b", untyped(3)), "expected shapes for body 'b', got 3"),
        (lambda: rod(1, 1, radius=-1), "expected a radius from 0 to 1e\\+100 m, got -1"),
        (lambda: rod(1, 1e200), "expected a length from 0 to 1e\\+100 m, got 1e\\+200"),
        (lambda: cone(1, 1, -2), "expected a height from 0 to 1e\\+100 m, got -2"),
        (lambda: box(1, (1, math.nan, 1)), "expected a box's edge from 0 to 1e\\+100 m, got nan"),
        (lambda: plate(1, untyped((1, 2, 3))), r"expected two edges of a plate, got \(1, 2, 3\)"),
        (lambda: particle(1.0, untyped(2.0)), "expected three components for position xyz, got 2"),
        (lambda: cloud(untyped(1.0), [(0, 0, 0)]), "expected masses, got 1.0"),
        (lambda: Shape(1.0, visuals=untyped(3)), "expected visuals, got 3"),
        (lambda: Body(untyped(3)), "expected a text for the name of a body, got 3"),
        (lambda: Visual(untyped(3)), "expected a Box, Cylinder, Sphere or Mesh, got 3"),
        (lambda: Visual(Sphere(1), rgba=untyped((1, 2))), "expected red, green, blue and opacity"),
        (lambda: Visual(Sphere(1), untyped(3)), "expected a Placement of a visual, got 3"),
        (lambda: Mesh("a", scale=untyped((1, "x", 1))), "expected a number, a parameter or an"),
        (lambda: Revolute("j", "a", untyped(1)), "expected a text for the child of a joint, got 1"),
        (lambda: Fixed("j", "a", "b", origin=untyped(1)), "expected a Placement for its origin"),
        (lambda: Revolute("j", "a", "b", limits=untyped(1)), "joint 'j': expected Limits, got 1"),
        (lambda: Revolute("j", "a", "b", coordinate=untyped(1)), "expected a text for its coord"),
        (lambda: Spherical("j", "a", "b", names=untyped(1)), "joint 'j': expected 4 names"),
        (lambda: Limits(math.nan), "expected a number for lower of limits, got nan"),
    ],
)
def test_bad_shapes_are_refused(make: Callable[[], object], message: str) -> None:
    with pytest.raises(InputError, match=message):
        make()


NUMBERS = st.one_of(
    st.floats(),
    st.integers(),
    st.just(10**400),
    st.none(),
    st.booleans(),
    st.text(max_size=3),
    st.binary(max_size=3),
    st.lists(st.floats(), max_size=7),
    st.complex_numbers(),
)
SOUND: dict[str, Any] = {
    "size": (1, 2),
    "length": 1.0,
    "radius": 1.0,
    "height": 1.0,
    "mass": 1.0,
    "masses": [1.0],
    "points": [(0, 0, 0)],
    "uri": "a.stl",
    "geometry": Sphere(1.0),
    "name": "j",
    "parent": "a",
    "child": "b",
    "pitch": 1.0,
}
CONSTRUCTORS: tuple[Callable[..., object], ...] = (
    *(ball, bar, box, cloud, cone, cylinder, disk, particle, plate, ring, rod, shell, massless),
    *(Body, Box, Cylinder, Mesh, Placement, Shape, Sphere, Visual, Limits),
    *(Fixed, Floating, Helical, Planar, Prismatic, Revolute, Spherical, Universal),
)


MASSIVE: dict[str, Callable[[Any], Shape]] = {
    "rod": lambda mass: rod(mass, 1.0),
    "box": lambda mass: box(mass, (1, 1, 1)),
    "plate": lambda mass: plate(mass, (1, 1)),
    "disk": lambda mass: disk(mass, 1.0),
    "ring": lambda mass: ring(mass, 1.0),
    "cylinder": lambda mass: cylinder(mass, 1.0, 1.0),
    "ball": lambda mass: ball(mass, 1.0),
    "shell": lambda mass: shell(mass, 1.0),
    "cone": lambda mass: cone(mass, 1.0, 1.0),
    "particle": lambda mass: particle(mass),
    "cloud": lambda mass: cloud([1.0, mass], [(0, 0, 0), (1, 0, 0)]),
}


@pytest.mark.parametrize("form", MASSIVE)
@pytest.mark.parametrize("mass", [-1, -1e-300, math.nan, math.inf])
def test_no_homogeneous_body_has_a_mass_below_zero_or_without_bound(form: str, mass: float) -> None:
    with pytest.raises(InputError, match=r"expected a mass from 0 to 1e\+100 kg, got "):
        MASSIVE[form](mass)
    assert MASSIVE[form](0.0).inertia == (0.0,) * 6 or form == "cloud"


@given(st.sampled_from(CONSTRUCTORS), st.data())
def test_constructors_refuse_in_words(make: Callable[..., object], data: st.DataObject) -> None:
    from inspect import signature

    parameters = signature(make).parameters
    plain = [name for name, p in parameters.items() if p.kind != p.VAR_POSITIONAL]
    given = {name: SOUND[name] for name in plain if name in SOUND}
    if make in (box, Box):
        given["size"] = (1, 2, 3)
    if plain:
        given[data.draw(st.sampled_from(plain))] = data.draw(NUMBERS)
    with suppress(InputError):
        make(**given)
