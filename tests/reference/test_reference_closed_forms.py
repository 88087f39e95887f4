"""The reference against formulas that can be written by hand."""

from __future__ import annotations

from collections.abc import Sequence
from math import cos, sin

import numpy as np
import pytest
from sympy import sin as symbolic_sin

from mecanique.model import (
    Body,
    Coordinates,
    Fixed,
    Floating,
    Force,
    Input,
    JointForce,
    JointSpring,
    Limits,
    Mechanism,
    Placement,
    Planar,
    Prismatic,
    Record,
    Revolute,
    Shape,
    Spherical,
    Spring,
    Torque,
    Universal,
    ball,
    bar,
    box,
    coordinate,
    cylinder,
    particle,
    rod,
    time,
)
from mecanique.model.joints import Joint
from mecanique.reference import Reference
from mecanique.reference.engine.tree import EngineTree
from mecanique.textbook import load

SAMPLES = [(0.4, 0.0), (2.0, -1.3), (-0.7, 3.1)]


def one_body(joint: Joint, *shapes: Shape, **fields: object) -> Reference:
    bodies = (Body("ground"), Body(joint.child, *shapes))
    return Reference(Mechanism("one", bodies=bodies, joints=(joint,), **fields))  # type: ignore[arg-type]  # any field


@pytest.mark.parametrize(("q", "v"), SAMPLES)
def test_rod_pendulum(q: float, v: float) -> None:
    """m l²/3 q'' + ½ m g l sin q = 0 and the reactions of the pin on the rod, along −n and t."""
    m, l, g = 2.0, 1.5, 9.81
    reference = Reference(load("rigid_bar_pendulum", m=m, l=l, g=g))
    a = -1.5 * g * sin(q) / l
    assert reference.mass_matrix([q]) == pytest.approx(np.array([[m * l**2 / 3]]), rel=1e-15)
    assert reference.bias([q], [v]) == pytest.approx([m * g * l * sin(q) / 2], rel=1e-14)
    assert reference.forces([q], [v]) == pytest.approx([0], abs=0)
    assert reference.acceleration([q], [v]) == pytest.approx([a], rel=1e-14)
    energy = reference.energy({"q": q}, {"q": v})
    assert energy.kinetic == pytest.approx(m * l**2 * v**2 / 6, rel=1e-14)
    assert energy.gravity == pytest.approx(-m * g * l * cos(q) / 2, rel=1e-14)
    assert energy.total == energy.kinetic + energy.potential
    pin = reference.reactions([q], [v])["pin"]
    n, t = np.array([sin(q), 0, -cos(q)]), np.array([cos(q), 0, sin(q)])
    assert -pin.force @ n == pytest.approx(m * g * cos(q) + m * l * v**2 / 2, rel=1e-13)
    assert pin.force @ t == pytest.approx(m * g * sin(q) + m * l * a / 2, rel=1e-13)
    assert pin.moment == pytest.approx([0, 0, 0], abs=1e-14)


@pytest.mark.parametrize(("q", "v"), [(0.4, 0.0), (0.1, -0.3), (-0.7, 0.2)])
@pytest.mark.parametrize("t", [0.0, 0.9])
def test_two_blocks_are_carried_not_pushed(q: float, v: float, t: float) -> None:
    """Springs and load are external forces: the guides bear the weights, nothing along the line."""
    reference = Reference(load("two_blocks", F0=2.0))
    a = reference.acceleration([q, v], [0.1, 0.2], t)
    F = 2 * cos(3 * t)
    assert reference.mass_matrix([q, v]) == pytest.approx(np.diag([2.0, 1.0]), rel=1e-12)
    assert reference.forces([q, v], None, t) == pytest.approx(
        [-60 * q + 20 * v, 20 * q - 20 * v + F], abs=1e-12
    )
    assert a == pytest.approx([(-60 * q + 20 * v) / 2, 20 * q - 20 * v + F], abs=1e-12)
    for name, mass in (("slide1", 2.0), ("slide2", 1.0)):
        wrench = reference.reactions([q, v], [0.1, 0.2], t)[name]
        assert wrench.force == pytest.approx([0, 0, mass * 9.81], abs=1e-12)
        assert wrench.moment == pytest.approx([0, 0, 0], abs=1e-12)
    assert reference.energy([q, v]).springs == pytest.approx(
        20 * q**2 + 10 * (v - q) ** 2, rel=1e-12
    )


@pytest.mark.parametrize(("q1", "q2", "v1", "v2"), [(0.3, 1.2, 0.5, -0.7), (2.0, 1.5, -1.0, 2.0)])
def test_double_pendulum_in_absolute_angles(q1: float, q2: float, v1: float, v2: float) -> None:
    """Closed form of two uniform rods (Levien & Tan, Am. J. Phys. 61 (1993) 1038)."""
    m1, m2, l1, l2, g = 1.2, 0.7, 0.9, 1.4, 9.81
    reference = Reference(load("double_pendulum", m1=m1, m2=m2, l1=l1, l2=l2, g=g))
    d = q2 - q1
    M = np.array(
        [
            [m1 * l1**2 / 3 + m2 * l1**2, m2 * l1 * l2 * cos(d) / 2],
            [m2 * l1 * l2 * cos(d) / 2, m2 * l2**2 / 3],
        ]
    )
    h = np.array(
        [
            -m2 * l1 * l2 * sin(d) * v2**2 / 2 + (m1 / 2 + m2) * g * l1 * sin(q1),
            m2 * l1 * l2 * sin(d) * v1**2 / 2 + m2 * g * l2 * sin(q2) / 2,
        ]
    )
    assert reference.mass_matrix([q1, q2]) == pytest.approx(M, rel=1e-13)
    assert reference.bias([q1, q2], [v1, v2]) == pytest.approx(h, rel=1e-13)
    a = np.linalg.solve(M, -h)
    assert reference.acceleration([q1, q2], [v1, v2]) == pytest.approx(a, rel=1e-12)
    # the same in relative angles, where there is no map
    absolute = load("double_pendulum", m1=m1, m2=m2, l1=l1, l2=l2, g=g)
    relative = Reference(
        Mechanism(
            "relative",
            absolute.bodies,
            absolute.joints,
            parameters=absolute.parameters,
            gravity=absolute.gravity,
        )
    )
    b = relative.acceleration([q1, d], [v1, v2 - v1])
    assert [b[0], b[0] + b[1]] == pytest.approx(a, rel=1e-12)
    for name, wrench in relative.reactions([q1, d], [v1, v2 - v1]).items():
        other = reference.reactions([q1, q2], [v1, v2])[name]
        assert other.force == pytest.approx(wrench.force, abs=1e-12)
        assert other.moment == pytest.approx(wrench.moment, abs=1e-12)


@pytest.mark.parametrize("limits", [None, Limits(-3, 3, 1, 1)])
@pytest.mark.parametrize("kind", [Revolute, Prismatic])
def test_an_armature_weighs_in_mass_energy_and_acceleration(
    kind: type[Revolute | Prismatic], limits: Limits | None
) -> None:
    """Pinocchio's kinetic energy forgets the rotor of a bounded joint; the reference must not."""
    joint = kind("j", "ground", "b", axis=(0, 0, 1), armature=0.5, limits=limits)
    reference = one_body(
        joint, cylinder(2.0, 0.3, 0.1), forces=(JointForce("f", "j", 3.0),), gravity=(0, 0, 0)
    )
    own = 2.0 * 0.3**2 / 2 if kind is Revolute else 2.0
    assert reference.mass_matrix([0.2]) == pytest.approx(np.array([[own + 0.5]]), rel=1e-12)
    assert reference.energy([0.2], [1.5]).kinetic == pytest.approx(
        (own + 0.5) * 1.5**2 / 2, rel=1e-12
    )
    assert reference.acceleration([0.2], [1.5]) == pytest.approx([3 / (own + 0.5)], rel=1e-12)
    wrench = reference.reactions([0.2], [1.5])["j"]
    along = wrench.moment if kind is Revolute else wrench.force
    assert along == pytest.approx([0, 0, -0.5 * 3 / (own + 0.5)], rel=1e-12)


def test_a_mass_on_a_shaken_base() -> None:
    """x'' + (k/m) (x − s(t)) + s'' = 0 for x measured from the base."""
    S = Input("S", 0.2 * symbolic_sin(3 * time()))
    mechanism = Mechanism(
        "shaken",
        bodies=(Body("ground"), Body("base"), Body("mass", box(2.0, (0.1, 0.1, 0.1)))),
        joints=(
            Prismatic("s", "ground", "base", axis=(1, 0, 0)),
            Prismatic("x", "base", "mass", axis=(1, 0, 0)),
        ),
        forces=(JointSpring("k", "x", 50.0),),
        coordinates=Coordinates(("x",), {"s": S}),
        inputs=(S,),
    )
    reference = Reference(mechanism)
    for t in (0.0, 0.4, 2.0):
        base = 0.2 * np.array([sin(3 * t), 3 * cos(3 * t), -9 * sin(3 * t)])
        assert reference.acceleration([0.3], [0.7], t) == pytest.approx(
            [-25 * 0.3 - base[2]], rel=1e-12
        )
        assert reference.bias([0.3], [0.7], t) == pytest.approx([2 * base[2]], rel=1e-12)
        assert reference.energy([0.3], [0.7], t).kinetic == pytest.approx(
            0.7**2 + 1.4 * base[1] + base[1] ** 2, rel=1e-12
        )
        moving = reference.point(
            "mass", (0, 0, 0), [0.3], [0.7], reference.acceleration([0.3], [0.7], t), t
        )
        assert moving.position[0] == pytest.approx(0.3 + base[0], rel=1e-12)
        assert moving.velocity[0] == pytest.approx(0.7 + base[1], rel=1e-12)
        assert moving.acceleration[0] == pytest.approx(-25 * 0.3, rel=1e-12)
        # what shakes the base pushes with the spring's force
        drive = reference.reactions([0.3], [0.7], t)["s"].force[0]
        assert drive == pytest.approx(2 * (moving.acceleration[0]), rel=1e-12)


def test_a_sampled_load_is_followed() -> None:
    F = Input("F", Record(np.array([0.0, 1.0, 3.0]), np.array([0.0, 2.0, -2.0])), "N")
    reference = one_body(
        Prismatic("x", "ground", "b", axis=(1, 0, 0)),
        box(2.0, (1, 1, 1)),
        forces=(Force("f", "b", (0, 0, 0), (F, 0, 0)),),
        inputs=(F,),
    )
    found = reference.acceleration(np.zeros((5, 1)), None, np.array([0.0, 0.5, 1.0, 2.0, 9.0]))
    assert found[:, 0] == pytest.approx([0, 0.5, 1, 0, -1], rel=1e-12)


def test_planar_joint_in_the_planes_own_axes() -> None:
    """M = m on x and y, I on θ about the center; normal −y turns from −z towards +x."""
    reference = one_body(
        Planar("p", "ground", "b", axis=(0, -1, 0)),
        box(3.0, (0.3, 0.2, 0.1)),
        gravity=(0, 0, -9.81),
    )
    assert reference.mass_matrix([1, 2, 0.3]) == pytest.approx(
        np.diag([3, 3, 3 * (0.3**2 + 0.1**2) / 12]), abs=1e-14
    )
    assert reference.bias([1, 2, 0.3], [4, 5, 6]) == pytest.approx([0, 3 * 9.81, 0], abs=1e-13)
    pose = reference.poses([1, 2, 0.3])[1]
    assert pose[:3, 3] == pytest.approx([1, 0, 2], rel=1e-12)
    assert pose[:3, :3] @ [0, 0, -1] == pytest.approx([sin(0.3), 0, -cos(0.3)], rel=1e-12)


def test_universal_joint_is_x_then_y() -> None:
    reference = one_body(
        Universal("u", "ground", "b"), particle(2.0, (0, 0, -1.5)), gravity=(0, 0, -9.81)
    )
    a, b = 0.7, -0.4
    position = 1.5 * np.array([-sin(b), sin(a) * cos(b), -cos(a) * cos(b)])
    assert reference.point("b", (0, 0, -1.5), [a, b]).position == pytest.approx(position, rel=1e-12)
    assert reference.mass_matrix([a, b]) == pytest.approx(
        2 * 1.5**2 * np.diag([cos(b) ** 2, 1]), abs=1e-14
    )
    gravity = 2 * 9.81 * 1.5 * np.array([sin(a) * cos(b), cos(a) * sin(b)])
    assert reference.gravity([a, b]) == pytest.approx(gravity, rel=1e-12)
    assert reference.energy([a, b]).gravity == pytest.approx(2 * 9.81 * position[2], rel=1e-12)
    # a particle's pin pulls along the rod alone
    wrench = reference.reactions([a, b], [0.3, 0.2])["u"]
    assert np.cross(wrench.force, position) == pytest.approx([0, 0, 0], abs=1e-13)
    assert wrench.moment == pytest.approx([0, 0, 0], abs=1e-13)


TURN = (0.1, -0.3, 0.2, 0.9)


def rotation(quaternion: Sequence[float] | np.ndarray) -> np.ndarray:
    x, y, z, w = np.array(quaternion) / np.linalg.norm(quaternion)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def test_a_ball_joint_turns_by_euler() -> None:
    """I ω' + ω × I ω = c × Rᵀ m g about the joint, child's axes (Euler 1758)."""
    heavy = Shape(2.0, (0.1, 0.2, -0.5), (0.3, 0.4, 0.2, 0.01, 0.02, -0.03))
    reference = one_body(
        Spherical("s", "ground", "b", origin=Placement((1, 2, 3))), heavy, gravity=(0, 0, -9.81)
    )
    w, c = np.array([0.5, -1.0, 2.0]), np.array([0.1, 0.2, -0.5])
    center = np.array([[0.3, 0.01, 0.02], [0.01, 0.4, -0.03], [0.02, -0.03, 0.2]])
    I = center + 2.0 * (c @ c * np.eye(3) - np.outer(c, c))
    weight = rotation(TURN).T @ [0, 0, -2 * 9.81]
    assert reference.mass_matrix(TURN) == pytest.approx(I, rel=1e-13)
    bias = np.cross(w, I @ w) - np.cross(c, weight)
    assert reference.bias(TURN, w) == pytest.approx(bias, rel=1e-13)
    turning = np.linalg.solve(I, -bias)
    assert reference.acceleration(TURN, w) == pytest.approx(turning, rel=1e-12)
    # the joint carries the weight and what bends the center's path, and no moment
    wrench = reference.reactions(TURN, w)["s"]
    pull = 2.0 * (np.cross(turning, c) + np.cross(w, np.cross(w, c)))
    assert wrench.force == pytest.approx(rotation(TURN) @ (pull - weight), rel=1e-12)
    assert wrench.moment == pytest.approx([0, 0, 0], abs=1e-12)
    # a quaternion that is not of unit length means the same
    assert reference.bias(3 * np.array(TURN), w) == pytest.approx(bias, rel=1e-13)
    y = reference.rhs()(0.0, np.array([*(2 * np.array(TURN)), *w]))
    assert y[4:] == pytest.approx(turning, rel=1e-10)


def test_two_particles_on_a_ball_joint_are_enough() -> None:
    """The floating joint's own mass matrix is singular; that of the ball joint is not."""
    shapes = particle(1.0, (1, 0, 0)), particle(2.0, (0, 1, 0))
    reference = one_body(Spherical("s", "ground", "b"), *shapes, gravity=(0, 0, 0))
    assert reference.mass_matrix(None) == pytest.approx(np.diag([2.0, 1.0, 3.0]), rel=1e-12)
    assert reference.acceleration(None, [1, 2, 3]) == pytest.approx(
        [-2 * 3 * (3 - 1) / 2, 3 * 1 * (3 - 2), -1 * 2 * (1 - 2) / 3], rel=1e-12
    )


def test_a_free_body_falls_and_spins() -> None:
    reference = one_body(Floating("f", "ground", "b"), ball(2.0, 0.5), gravity=(0, 0, -9.81))
    q = [1, 2, 3, *TURN]
    v = np.array([0.4, 0.5, 0.6, 1.0, -2.0, 3.0])
    R = rotation(TURN)
    assert reference.mass_matrix(q) == pytest.approx(np.diag([2.0] * 3 + [0.2] * 3), abs=1e-14)
    falling = R.T @ [0, 0, -9.81] - np.cross(v[3:], v[:3])
    assert reference.acceleration(q, v) == pytest.approx([*falling, 0, 0, 0], abs=1e-12)
    rates = reference.rates(q, v)
    assert rates[:3] == pytest.approx(R @ v[:3], rel=1e-12)
    later = reference.mechanism.position(q) + 1e-6 * rates
    spin = (rotation(later[3:]) - R) / 1e-6 @ R.T
    assert [spin[2, 1], spin[0, 2], spin[1, 0]] == pytest.approx(R @ v[3:], abs=1e-5)
    wrench = reference.reactions(q, v)["f"]
    assert [*wrench.force, *wrench.moment] == pytest.approx([0] * 6, abs=1e-12)


def test_a_massless_tip_may_be_prescribed() -> None:
    """A massless bar on a hinge would fall anyhow; where the map leads it, all is determined."""
    bodies = (Body("ground"), Body("rod", rod(3.0, 1.0)), Body("tip", bar(0.5)))
    joints = (
        Revolute("a", "ground", "rod", axis=(0, -1, 0)),
        Revolute("b", "rod", "tip", axis=(0, -1, 0), origin=Placement((0, 0, -1))),
    )
    mechanism = Mechanism(
        "led", bodies, joints, coordinates=Coordinates(("a",), {"b": 2 * coordinate("a") + time()})
    )
    found = Reference(mechanism).acceleration([0.5], [0.2], 0.3)
    assert found == pytest.approx([-1.5 * 9.81 * sin(0.5)], rel=1e-12)


def test_a_spring_without_length_pulls_towards_its_other_end() -> None:
    reference = one_body(
        Floating("f", "ground", "b"),
        ball(1.0, 0.1),
        forces=(Spring("s", "ground", (1, 0, 0), "b", (0, 0, 0), 4.0),),
        gravity=(0, 0, 0),
    )
    assert reference.forces({"f_x": 0.25, "f_y": 2.0}) == pytest.approx(
        [3, -8, 0, 0, 0, 0], rel=1e-12
    )
    assert reference.forces({"f_x": 1.0}) == pytest.approx([0] * 6, abs=0)


def test_axes_of_a_force_may_be_any_bodys() -> None:
    bodies = (Body("ground"), Body("a", ball(1, 0.1)), Body("b", ball(1, 0.1)), Body("tag"))
    joints = (
        Revolute("j", "ground", "a", axis=(0, 0, 1)),
        Prismatic("k", "ground", "b", axis=(1, 0, 0)),
        Fixed("w", "a", "tag", origin=Placement((0, 0, 0), (0, 0, 0.3))),
    )
    forces = (
        Force("f", "b", (0, 0, 0), (2.0, 0, 0), axes="tag"),
        Torque("t", "a", (0, 0, 5.0), axes="ground"),
    )
    reference = Reference(Mechanism("m", bodies, joints, forces))
    assert reference.forces([0.4, 0]) == pytest.approx([5, 2 * cos(0.7)], rel=1e-12)


def test_a_weld_to_the_ground_bears_the_weight_of_what_stands_on_it() -> None:
    bodies = (
        Body("ground"),
        Body("post", ball(2, 0.1).at((0, 0, 1))),
        Body("lamp", ball(3, 0.1).at((1, 0, 0))),
    )
    joints = (
        Fixed("root", "ground", "post", origin=Placement((5, 0, 0))),
        Fixed("arm", "post", "lamp", origin=Placement((0, 0, 2))),
    )
    reference = Reference(
        Mechanism("lamp", bodies, joints, (Force("wind", "lamp", (0, 0, 1), (7.0, 0, 0)),))
    )
    wrenches = reference.reactions(None)
    assert wrenches["arm"].force == pytest.approx([-7, 0, 3 * 9.81], rel=1e-12)
    assert wrenches["arm"].moment == pytest.approx([0, -7 * 1 - 3 * 9.81, 0], rel=1e-12)
    assert wrenches["root"].force == pytest.approx([-7, 0, 5 * 9.81], rel=1e-12)
    assert wrenches["root"].moment == pytest.approx([0, -7 * 3 - 3 * 9.81, 0], rel=1e-12)
    assert reference.energy(None).gravity == pytest.approx(9.81 * (2 * 1 + 3 * 2), rel=1e-12)
    assert reference.mass_matrix(None).shape == (0, 0)
    assert reference.acceleration(None).shape == (0,)
    # of all bodies at rest, though no joint carries them
    poses, *rates = reference.motions(None)
    assert poses[2, :3, 3] == pytest.approx([5, 0, 2], rel=1e-12)
    assert not np.any(rates)
    assert not np.any(reference.momentum(None))
    assert not np.any(reference.resultant(None))  # of what moves


def test_everything_may_be_prescribed() -> None:
    reference = one_body(
        Prismatic("x", "ground", "b", axis=(0, 0, 1)),
        ball(2.0, 0.1),
        coordinates=Coordinates((), {"x": symbolic_sin(2 * time())}),
    )
    t = 0.6
    assert reference.energy(None, None, t).kinetic == pytest.approx(
        (2 * cos(2 * t)) ** 2, rel=1e-12
    )
    lift = reference.reactions(None, None, t)["x"].force
    assert lift == pytest.approx([0, 0, 2 * (9.81 - 4 * sin(2 * t))], rel=1e-12)
    assert reference.rhs()(t, np.zeros(0)).shape == (0,)


@pytest.mark.parametrize("name", ["universe", "world", "root_joint", "é <&>"])
def test_names_that_the_engine_uses_itself_are_free(name: str) -> None:
    joint = Revolute(name, "ground", name, axis=(0, -1, 0))
    reference = one_body(joint, rod(1.0, 1.0))
    assert reference.acceleration([0.3]) == pytest.approx([-1.5 * 9.81 * sin(0.3)], rel=1e-12)
    assert reference.poses([0.3])[1, :3, :3] @ [0, 0, -1] == pytest.approx(
        [sin(0.3), 0, -cos(0.3)], rel=1e-12
    )
    assert list(reference.reactions([0.3])) == [name]


def test_the_mass_a_coordinate_reaches_goes_by_the_square_of_its_gearing() -> None:
    """Of a slide with x = −3 s, whose mass matrix is 9 m."""
    slide = Prismatic("slide", "ground", "block", axis=(1, 0, 0), coordinate="x")
    mechanism = Mechanism(
        "geared",
        (Body("ground"), Body("block", particle(2.0))),
        (slide,),
        coordinates=Coordinates(("s",), {"x": -3 * coordinate("s")}),
    )
    tree = EngineTree(mechanism)
    np.testing.assert_allclose(
        tree.mass(np.zeros(1), np.zeros(1), 0.0), [[18.0]], rtol=1e-14, atol=0
    )
    np.testing.assert_allclose(tree._reach(), [18.0], rtol=1e-14, atol=0)
