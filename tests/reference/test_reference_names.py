"""Bodies, wrenches, mass and coordinates by name."""

from __future__ import annotations

import pickle
from typing import Any

import numpy as np
import pytest
from reference_samples import driven, flyer, states, tree
from scipy.spatial.transform import Rotation
from sympy import sin

from mecanique.errors import InputError, UnknownNameError
from mecanique.model import (
    Body,
    Coordinates,
    Mechanism,
    Placement,
    Prismatic,
    Revolute,
    coordinate,
    particle,
    rod,
)
from mecanique.model.placement import pose_of
from mecanique.motion import simulate, simulate_many
from mecanique.reference import Reference, assemble
from mecanique.reference.engine.answers import BodyPoses, Wrench
from mecanique.textbook import load
from mecanique.textbook.catalogue import entry


@pytest.mark.parametrize("mechanism", [tree(), flyer(), driven()], ids=lambda m: m.name)
def test_pose_and_velocity_of_one_body(mechanism: Mechanism) -> None:
    reference = Reference(mechanism)
    for q, v, t in states(mechanism, 3):
        for k, body in enumerate(mechanism.bodies):
            assert (reference.pose(body.name, q, t) == reference.poses(q, t)[k]).all()
            found = reference.velocity(body.name, q, v, t)
            point = reference.point(body.name, (0, 0, 0), q, v, None, t)
            assert found.linear == pytest.approx(point.velocity, abs=1e-12)
            arm = reference.point(body.name, (0.3, 0, 0), q, v, None, t)
            assert found.linear + np.cross(
                found.angular, arm.position - point.position
            ) == pytest.approx(arm.velocity, abs=1e-12)


@pytest.mark.parametrize("mechanism", [tree(), flyer(), driven()], ids=lambda m: m.name)
def test_the_center_of_mass_carries_the_momentum(mechanism: Mechanism) -> None:
    reference = Reference(mechanism)
    random = np.random.default_rng(5)
    for q, v, t in states(mechanism, 3):
        a = random.normal(size=mechanism.nv)
        center = reference.center_of_mass(q, v, a, t)
        momentum = reference.momentum(q, v, t).linear
        assert reference.total_mass * center.velocity == pytest.approx(momentum, rel=1e-10)
        h = 1e-5
        rate = reference.rates(q, v)
        later = [
            reference.center_of_mass(q + s * h * rate, v + s * h * a, None, t + s * h).velocity
            for s in (1, -1)
        ]
        assert (later[0] - later[1]) / (2 * h) == pytest.approx(
            center.acceleration, rel=1e-5, abs=1e-5
        )


@pytest.mark.parametrize(
    ("rpy", "expected"),
    [
        ((0, 0, 0), ("force y", "moment x", "moment z")),
        ((0, 0, np.pi / 2), ("force x", "moment y", "moment z")),
        ((0, 0, 0.4), ("force x", "force y", "moment x", "moment y", "moment z")),
        ((0.4, 0, 0), ("force y", "force z", "moment x", "moment y", "moment z")),
    ],
)
def test_what_undetermined_components_are_part_of_is_undetermined(
    rpy: tuple[float, float, float], expected: tuple[str, ...]
) -> None:
    poses = {"rod": pose_of(Placement(rpy=rpy))}
    loose = ("force y", "moment x", "moment z")
    parts = np.array([[1.0, np.nan, 2.0], [np.nan, 3.0, np.nan]])
    found = Wrench(parts[0], parts[1], loose, places=BodyPoses(lambda: poses)).in_axes("rod")
    assert found.undetermined == expected
    for kind, turned, part in zip(
        ("force", "moment"), (found.force, found.moment), parts, strict=True
    ):
        known = np.nan_to_num(part) @ poses["rod"][:3, :3]
        lost = [f"{kind} {axis}" in expected for axis in "xyz"]
        np.testing.assert_allclose(turned, np.where(lost, np.nan, known), rtol=1e-14, atol=1e-15)


def test_a_wrench_goes_from_the_axes_of_one_body_to_those_of_another() -> None:
    """In each of many states; what is lost in one is not in the next."""
    turns = Rotation.random(6, rng=4).as_matrix().reshape(2, 3, 3, 3)
    poses = {name: np.tile(np.eye(4), (3, 1, 1)) for name in "ab"}
    for name, turn in zip("ab", turns, strict=True):
        poses[name][:, :3, :3] = turn
    poses["c"] = np.array([pose_of(Placement(rpy=(0, 0, k * np.pi / 2))) for k in range(3)])
    force, moment = np.random.default_rng(5).normal(size=(2, 3, 3))
    places = BodyPoses(lambda: poses)
    found = Wrench(force, moment, axes="a", places=places).in_axes("b")
    for k in range(3):
        back = poses["b"][k, :3, :3].T @ poses["a"][k, :3, :3]
        np.testing.assert_allclose(found.force[k], back @ force[k], rtol=0, atol=1e-14)
        np.testing.assert_allclose(found.moment[k], back @ moment[k], rtol=0, atol=1e-14)
    force[:, 1] = np.nan
    lost = np.isnan(Wrench(force, moment, places=places).in_axes("c").force)
    assert lost.tolist() == [[k == 1, k != 1, False] for k in range(3)]


def test_a_wrench_in_the_axes_of_the_rod() -> None:
    """Along the rod m g cos q + m l q'²/2, across it m g sin q + m l q''/2."""
    m, l, g, q, v = 2.0, 1.5, 9.81, 0.7, 1.2
    reference = Reference(load("rigid_bar_pendulum", m=m, l=l, g=g))
    a = reference.acceleration([q], [v])[0]
    pin = reference.reactions([q], [v])["pin"]
    own = pin.in_axes("child")
    along = m * g * np.cos(q) + m * l * v**2 / 2
    across = m * g * np.sin(q) + m * l * a / 2
    assert own.force == pytest.approx([across, 0, along], rel=1e-12)
    assert own.axes == pin.child
    assert own.in_axes("world").force == pytest.approx(pin.force, rel=1e-12)
    assert (pin.in_axes("parent").force == pin.force).all()
    middle = own.about((0, 0, -l / 2), "child")
    assert middle.moment == pytest.approx([0, across * l / 2, 0], rel=1e-12)
    assert middle.force == pytest.approx(own.force, rel=1e-15)
    back = pickle.loads(pickle.dumps(pin)).in_axes("child")
    assert back.force == pytest.approx(own.force, rel=1e-15)
    with pytest.raises(UnknownNameError, match="unknown body or axes 'roof'"):
        pin.in_axes("roof")
    with pytest.raises(InputError, match="three"):
        pin.about((1, 2))


def test_wrenches_of_many_states_and_of_loops_turn_and_move_back() -> None:
    linkage = load("slider_crank")
    motion = simulate(linkage, q={"theta": 0.7, "beta": -0.97, "x": 1.54}, duration=0.3)
    for name in ("A", "B", "guide"):
        wrench = motion.reactions(name)
        there = wrench.about((0.1, 0.2, -0.3), "rod").in_axes("rod")
        assert there.force.shape == wrench.force.shape == (len(motion), 3)
        back = there.in_axes("world").about((0, 0, 0), "child")
        assert back.moment == pytest.approx(wrench.moment, abs=1e-10)
        assert back.force == pytest.approx(wrench.force, abs=1e-10)


def test_what_redundancy_leaves_open_stays_marked_in_other_axes() -> None:
    linkage = load("four_bar_linkage")
    q = assemble(linkage, entry("four_bar_linkage").start)
    for wrench in Reference(linkage).reactions(q).values():
        same = wrench.in_axes("child").in_axes("world")
        assert set(wrench.undetermined) <= set(same.undetermined)


def geared() -> Mechanism:
    return Mechanism(
        "geared",
        bodies=(
            Body("ground"),
            Body("a", rod(1, 1.0)),
            Body("b", rod(1, 1.0)),
            Body("c", particle(1)),
        ),
        joints=(
            Revolute("one", "ground", "a", axis=(0, -1, 0), coordinate="r"),
            Revolute(
                "two", "a", "b", axis=(0, -1, 0), origin=Placement((0, 0, -1)), coordinate="z1"
            ),
            Prismatic("three", "ground", "c", axis=(1, 0, 0), coordinate="z2"),
        ),
        coordinates=Coordinates(
            ("r",), {"z1": 3 * coordinate("r") + 0.5, "z2": sin(coordinate("r"))}
        ),
    )


def test_joints_that_follow_are_read_by_name() -> None:
    motion = simulate(geared(), q={"z1": 1.1}, v={"r": 0.4}, duration=0.5)
    assert motion["r"][0] == pytest.approx(0.2, rel=1e-14)
    assert motion["z1"] == pytest.approx(3 * motion["r"] + 0.5, rel=1e-13)
    assert motion["z1'"] == pytest.approx(3 * motion["r'"], rel=1e-13)
    assert motion["z1''"] == pytest.approx(3 * motion["r''"], rel=1e-13)
    r, w, a = motion["r"], motion["r'"], motion["r''"]
    assert motion["z2''"] == pytest.approx(np.cos(r) * a - np.sin(r) * w**2, rel=1e-11, abs=1e-12)
    with pytest.raises(UnknownNameError):
        motion["z3"]


def test_positions_by_joints_that_follow_are_solved_or_refused() -> None:
    mechanism = geared()
    assert mechanism.position({"z1": 3.5}) == pytest.approx([1.0], rel=1e-15)
    two: Any = {"z1": np.array([0.5, 3.5])}
    assert Reference(mechanism).poses(two).shape == (2, 4, 4, 4)
    with pytest.raises(InputError, match=r"z2 = sin\(r\), and does not determine"):
        mechanism.position({"z2": 0.1})
    with pytest.raises(InputError, match="follows r, which is given, too"):
        mechanism.position({"z1": 0.1, "r": 1.0})


def test_rates_by_joints_that_follow_are_solved_or_refused() -> None:
    mechanism = geared()
    for name in ("z1", "z1'"):
        assert mechanism.velocity({name: 6.0}) == pytest.approx([2.0], rel=1e-15)
    for name in ("z1", "z1'", "z1''"):
        assert mechanism.acceleration({name: 6.0}) == pytest.approx([2.0], rel=1e-15)
    assert simulate(geared(), v={"z1'": 0.6}, duration=0.01).v[0] == pytest.approx([0.2], rel=1e-12)
    runs = simulate_many(geared(), q={"z1": [0.5, 3.5]}, v={"z1": 0.6}, duration=0.01)
    assert runs.q[:, 0, 0] == pytest.approx([0.0, 1.0], rel=1e-12)
    with pytest.raises(InputError, match=r"z2' follows .* z2 = sin\(r\), .*; give r'"):
        mechanism.velocity({"z2'": 0.1})
    with pytest.raises(InputError, match="z1' follows r, which is given, too"):
        mechanism.velocity({"z1'": 0.1, "r": 1.0})
    with pytest.raises(UnknownNameError, match="unknown velocity \"z1''\""):
        mechanism.velocity({"z1''": 0.1})


def test_a_motion_gives_pose_and_velocity_by_name() -> None:
    motion = simulate(load("double_pendulum"), q=[0.5, 0.2], duration=0.5)
    name = motion.mechanism.bodies[-1].name
    assert (motion.pose(name) == motion.poses()[:, -1]).all()
    assert motion.pose(name, 0.2).shape == (4, 4)
    assert motion.velocity(name).linear == pytest.approx(motion.point(name).velocity, abs=1e-12)
    assert motion.velocity(name, 0.2).angular.shape == (3,)
