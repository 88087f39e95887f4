"""What the reference refuses, and in which words."""

from __future__ import annotations

import numpy as np
import pytest
from sympy import sqrt

from mecanique.errors import EngineError, InputError, UnknownNameError
from mecanique.model import (
    Body,
    Coordinates,
    Input,
    Loop,
    Mechanism,
    Placement,
    Prismatic,
    Revolute,
    Shape,
    Spherical,
    Spring,
    ball,
    bar,
    coordinate,
    particle,
    rod,
)
from mecanique.model.joints import Joint
from mecanique.reference import Reference
from mecanique.textbook import load


def chain(*joints: Joint, shapes: dict[str, Shape] | None = None, **fields: object) -> Mechanism:
    shapes = shapes or {}
    bodies = (Body("ground"), *(Body(j.child, shapes.get(j.child, ball(1, 0.1))) for j in joints))
    return Mechanism("machine", bodies, joints, **fields)  # type: ignore[arg-type]  # any field


@pytest.fixture(scope="module")
def pendulum() -> Reference:
    return Reference(load("rigid_bar_pendulum"))


@pytest.mark.parametrize(
    ("q", "v", "t", "message"),
    [
        (
            [1.0, 2.0],
            None,
            0.0,
            r"expected shape \(1,\) or \(n, 1\) for the coordinate values \(q\), got \(2,\)",
        ),
        ([np.nan], None, 0.0, "expected finite coordinate values"),
        ([0.1], [np.inf], 0.0, "expected finite velocity values"),
        ([0.1], [1.0, 2.0], 0.0, r"expected shape \(1,\) or \(n, 1\) for the velocity values"),
        ([0.1], None, np.nan, "expected a finite number for time t"),
        ([0.1], None, "now", "expected a finite number for time t"),
        ("q", None, 0.0, "expected 1 number for the coordinate values"),
        (
            np.zeros((3, 2)),
            None,
            0.0,
            r"expected shape \(1,\) or \(n, 1\) for the coordinate values \(q\), got \(3, 2\)",
        ),
        (np.full((3, 1), np.inf), None, 0.0, "expected finite coordinate values"),
        (
            np.zeros((3, 1)),
            np.zeros((2, 1)),
            0.0,
            "expected one number of states in q, v, a and t, got q: 3, v: 2",
        ),
        (
            np.zeros((3, 1)),
            None,
            np.zeros(2),
            "expected one number of states in q, v, a and t, got q: 3, t: 2",
        ),
        (np.zeros((3, 1)), None, np.array([0, np.nan, 1]), "expected finite numbers for time t"),
        (np.zeros((1, 1, 1)), None, 0.0, r"expected shape \(1,\)"),
    ],
)
def test_bad_states(pendulum: Reference, q: object, v: object, t: object, message: str) -> None:
    with pytest.raises(InputError, match=message):
        pendulum.acceleration(q, v, t)  # type: ignore[arg-type]  # that is the point


def test_bad_names(pendulum: Reference) -> None:
    with pytest.raises(UnknownNameError, match="unknown coordinate 'theta'"):
        pendulum.mass_matrix({"theta": 1.0})
    with pytest.raises(UnknownNameError, match="unknown velocity 'w'"):
        pendulum.bias({"q": 1.0}, {"w": 1.0})
    with pytest.raises(UnknownNameError, match="unknown body 'rodd'; did you mean 'rod'"):
        pendulum.point("rodd", (0, 0, 0), [0.1])


@pytest.mark.parametrize("xyz", [(0, 0), (0, 0, np.nan), "abc", 3.0, (0, 0, coordinate("q"))])
def test_bad_points(pendulum: Reference, xyz: object) -> None:
    with pytest.raises(InputError, match=r"expected (three|a finite point|a number)"):
        pendulum.point("rod", xyz, [0.1])  # type: ignore[arg-type]  # that is the point


def test_accelerations_go_by_any_of_their_names(pendulum: Reference) -> None:
    one = pendulum.inverse_dynamics({"q": 0.3}, {"q": 0.5}, {"q": 2.0})
    assert one == pytest.approx([2 / 3 + 9.81 / 2 * np.sin(0.3)], rel=1e-12)
    for name in ("q'", "q''"):
        assert pendulum.inverse_dynamics({"q": 0.3}, {"q'": 0.5}, {name: 2.0}) == one


@pytest.mark.parametrize("quaternion", [(0, 0, 0, 0), (1e10, 0, 0, 0)])
def test_a_quaternion_without_length(quaternion: tuple[float, ...]) -> None:
    reference = Reference(chain(Spherical("s", "ground", "b")))
    with pytest.raises(InputError, match="expected a unit quaternion for joint 's'"):
        reference.mass_matrix(quaternion)
    with pytest.raises(InputError, match="expected a unit quaternion for joint 's'"):
        reference.mass_matrix(np.array([quaternion]))


def test_too_many_velocities_for_the_engines_memory() -> None:
    joints = [Prismatic(f"j{k}", "ground", f"b{k}") for k in range(251)]
    with pytest.raises(
        EngineError,
        match=r"has 251 joint velocities; Pinocchio is given at most 250.+mecanique\.derive",
    ):
        Reference(chain(*joints))


def test_too_many_joints_in_a_row_for_the_engines_parser() -> None:
    from mecanique.model import Fixed

    joints = [Fixed(f"j{k}", f"b{k - 1}" if k else "ground", f"b{k}") for k in range(1001)]
    with pytest.raises(
        EngineError, match=r"has 1001 joints in a row; Pinocchio is given at most 1000"
    ):
        Reference(chain(*joints))


@pytest.mark.parametrize(
    ("joint", "shape", "names"),
    [
        (
            Revolute("hinge", "ground", "tip", axis=(0, -1, 0)),
            bar(1.0),
            "q'.+joint 'hinge' .body 'tip'",
        ),
        (Prismatic("rail", "ground", "tip"), bar(1.0), "q'.+joint 'rail' .body 'tip'"),
        (
            Revolute("spin", "ground", "tip", axis=(1, 2, 3)),
            particle(2.0, (0.1, 0.2, 0.3)),
            "q'.+joint 'spin'",
        ),
        (
            Spherical("ball", "ground", "tip"),
            particle(2.0, (0.1, 0.2, -0.3)),
            "ball_w.+joint 'ball' .body 'tip'",
        ),
        (
            Spherical("ball", "ground", "tip"),
            rod(2.0, 1.0),
            "motion ball_wz, joint 'ball' .body 'tip'",
        ),
    ],
)
def test_a_motion_that_moves_no_mass(joint: Joint, shape: Shape, names: str) -> None:
    if isinstance(joint, (Revolute, Prismatic)):
        from dataclasses import replace

        joint = replace(joint, coordinate="q")
    reference = Reference(chain(joint, shapes={"tip": shape}))
    assert reference.massless is not None
    assert reference.mass_matrix(None) @ list(reference.massless.values()) == pytest.approx(
        0, abs=1e-15
    )
    for ask in (
        lambda: reference.acceleration(None),
        lambda: reference.reactions(None),
        reference.rhs,
    ):
        with pytest.raises(
            EngineError, match=rf"{names}.+moves no mass.+give the body mass or inertia"
        ):
            ask()


def test_a_massless_bar_that_carries_a_particle_is_refused_only_where_they_align() -> None:
    joints = (
        Revolute("a", "ground", "bar", axis=(0, -1, 0)),
        Revolute("b", "bar", "bob", axis=(0, -1, 0), origin=Placement((0, 0, -1))),
    )
    reference = Reference(
        chain(*joints, shapes={"bar": bar(1.0), "bob": particle(1.0, (0, 0, -1))})
    )
    # a free particle in the plane: the two bars only say where it is
    a = reference.acceleration([0.4, 0.8])
    moving = reference.point("bob", (0, 0, -1), [0.4, 0.8], None, a).acceleration
    assert moving == pytest.approx([0, 0, -9.81], abs=1e-12)
    aligned = r"a', b'.+moves no mass at q = \[0.4, 0.0\].+though it does elsewhere"
    with pytest.raises(EngineError, match=aligned):
        reference.acceleration([0.4, 0.0])
    assert not np.isfinite(reference.rhs()(0.0, np.array([0.4, 0.0, 0.0, 0.0]))[2:]).all()


@pytest.mark.engine
def test_masses_that_the_parser_loses() -> None:
    heavy = chain(
        Revolute("j", "ground", "electron", axis=(0, 1, 0)),
        shapes={"electron": particle(9.1e-31, (1, 0, 0))},
    )
    with pytest.raises(
        EngineError, match=r"Pinocchio read body 'electron'.+measure in smaller units"
    ):
        Reference(heavy)


def test_an_inertia_that_rounding_made_negative_is_no_reason_to_stop() -> None:
    flat = Shape(1.0, (0, 0, 0.1), (1.0, 1.0, -1e-12, 0, 0, 0))
    reference = Reference(chain(Revolute("j", "ground", "b", axis=(1, 0, 0)), shapes={"b": flat}))
    assert reference.mass_matrix([0.0]) == pytest.approx(np.array([[1.01]]), rel=1e-12)


def test_a_spring_without_direction() -> None:
    mechanism = chain(
        Prismatic("x", "ground", "b", axis=(1, 0, 0)),
        forces=(Spring("tie", "ground", (0, 0, 0), "b", (0, 0, 0), 4.0, 0.5),),
    )
    reference = Reference(mechanism)
    assert reference.forces([0.75]) == pytest.approx([-1], rel=1e-12)
    with pytest.raises(
        EngineError,
        match=r"'tie' has no direction: its ends, on 'ground' and 'b', coincide",
    ):
        reference.acceleration([0.0])


def test_a_map_that_is_not_defined_everywhere() -> None:
    x = coordinate("x")
    joints = (
        Prismatic("a", "ground", "b", axis=(1, 0, 0)),
        Prismatic("c", "b", "d", axis=(0, 0, 1)),
    )
    mechanism = chain(*joints, coordinates=Coordinates(("x",), {"a": x, "c": -sqrt(1 - x**2)}))
    reference = Reference(mechanism)
    assert reference.mass_matrix([0.6]) == pytest.approx(np.array([[1 + 1 / 0.64]]), rel=1e-12)
    for x_value in (1.0, 1.5):
        with pytest.raises(EngineError, match=rf"no finite answer at q = \[{x_value}\]"):
            reference.acceleration([x_value])


def test_a_map_that_follows_a_function_without_derivatives() -> None:
    S = Input("S", lambda t: t)
    mechanism = chain(
        Prismatic("a", "ground", "b"), inputs=(S,), coordinates=Coordinates((), {"a": S})
    )
    with pytest.raises(
        EngineError, match=r"depends on input 'S', a function whose derivatives are not known"
    ):
        Reference(mechanism)


def test_loops_are_not_ignored() -> None:
    mechanism = chain(
        Revolute("a", "ground", "b"),
        loops=(Loop.ball("close", "ground", (1, 0, 0), "b", (1, 0, 0)),),
    )
    reference = Reference(mechanism)
    assert reference.mass_matrix([0.0]).shape == (1, 1)
    assert reference.acceleration([0.0]) == pytest.approx([0.0], rel=1e-12)
    for ask in (reference.acceleration, reference.reactions, reference.undetermined):
        with pytest.raises(EngineError, match=r"the loops are open at q = \[0.3\] \(close: y by"):
            ask([0.3])


def test_a_mechanism_without_mass_has_no_center() -> None:
    reference = Reference(Mechanism("empty", (Body("ground"),), ()))
    with pytest.raises(EngineError, match="no moving mass"):
        reference.center_of_mass(None)
    assert reference.reactions(None) == {}
    assert reference.poses(None).shape == (1, 4, 4)
    assert reference.momentum(None).linear == pytest.approx([0, 0, 0], rel=1e-12)


@pytest.mark.engine
def test_the_engine_tells_its_version(pendulum: Reference) -> None:
    from importlib.metadata import version

    assert pendulum.version == version("pin")
