"""Teeth that are drawn mesh, wherever the wheels have turned to."""

from __future__ import annotations

import numpy as np
import pytest

from mecanique import Body, Gear, Mechanism, Placement, Reference, Revolute, disk, textbook
from mecanique.model.bodies.visuals import Cylinder
from mecanique.model.teeth import RackTeeth, WheelTeeth, teeth_of, visuals_of


def offset(teeth: WheelTeeth, pose: np.ndarray, radius: float, toward: np.ndarray) -> float:
    """Return how far the nearest tooth is from a direction, along n × toward, in teeth."""
    n = np.array([0.0, -1.0, 0.0])
    axes = pose[:3, :3] @ teeth.axes
    at, tangent = pose[:3, :3].T @ toward, pose[:3, :3].T @ np.cross(n, toward)
    points = teeth.outline(radius).reshape(teeth.count, 4, 3).mean(axis=1)
    nearest = points[(points @ at).argmax()]
    pitch = 2 * np.pi * radius / teeth.count
    assert abs(axes[:, 2] @ n) == pytest.approx(1, rel=1e-12)
    return float(radius * np.arctan2(nearest @ tangent, nearest @ at) / pitch)


def apart(first: float, second: float) -> float:
    """Return the distance of two teeth, in teeth, from 0 to 1/2."""
    x = (first - second) % 1
    return min(x, 1 - x)


@pytest.mark.parametrize("place", [(0.0, 0.0), (0.7, -0.4), (3.0, 2.2)])
def test_a_tooth_of_one_wheel_is_between_two_of_the_other(place: tuple[float, float]) -> None:
    gear = textbook.load("planetary_gear")
    wheels = {each.body: each for each in teeth_of(gear) if isinstance(each, WheelTeeth)}
    assert [wheels[name].count for name in ("sun", "planet", "ring")] == [25, 15, 55]
    reference, names = Reference(gear), [body.name for body in gear.bodies]
    poses = dict(
        zip(names, reference.poses(dict(zip(("sun", "arm"), place, strict=True))), strict=True)
    )
    u = poses["planet"][:3, 3] / np.linalg.norm(poses["planet"][:3, 3])
    rs, rp = gear.values["rs"], gear.values["rp"]
    sun = offset(wheels["sun"], poses["sun"], rs, u)
    inner = -offset(wheels["planet"], poses["planet"], rp, -u)
    assert apart(sun, inner) == pytest.approx(0.5, abs=1e-9)
    outer = offset(wheels["planet"], poses["planet"], rp, u)
    ring = offset(wheels["ring"], poses["ring"], rs + 2 * rp, u)
    assert apart(ring, outer) == pytest.approx(0.5, abs=1e-9)


@pytest.mark.parametrize("x", [0.0, 0.033])
def test_a_tooth_of_the_pinion_is_between_two_of_the_rack(x: float) -> None:
    machine = textbook.load("rack_and_pinion")
    pinion, rack = teeth_of(machine)
    assert isinstance(pinion, WheelTeeth)
    assert isinstance(rack, RackTeeth)
    _, wheel, slide = Reference(machine).poses({"x": x})
    down = offset(pinion, wheel, 0.1, np.array([0.0, 0.0, -1.0]))
    pitch = 2 * np.pi * 0.1 / pinion.count
    teeth = rack.outline(pitch / np.pi).reshape(-1, 4, 3).mean(axis=1) + slide[:3, 3]
    along = np.cross([0.0, -1.0, 0.0], [0.0, 0.0, -1.0])
    assert apart(down, float(teeth[0] @ along) / pitch) == pytest.approx(0.5, abs=1e-9)
    # all of them on its box, tips one module above the pitch line
    outline = rack.outline(pitch / np.pi)
    assert np.abs(outline[:, 0]).max() <= 0.4
    assert outline[:, 2].max() == pytest.approx(pitch / np.pi, rel=1e-12)


def test_a_wheel_is_drawn_to_the_root_of_its_teeth() -> None:
    gear = textbook.load("planetary_gear")
    rim, _, *teeth = visuals_of(gear)["sun"]
    assert len(teeth) == 25
    assert isinstance(rim.geometry, Cylinder)
    # a module is 2 r/z
    assert gear.evaluate(rim.geometry.radius) == pytest.approx(0.1 - 1.25 * 0.2 / 25, rel=1e-12)
    assert visuals_of(gear)["arm"] == gear.body("arm").visuals
    assert len(visuals_of(gear)["ring"]) == 1 + 55


def test_without_gears_nothing_has_teeth_and_odd_radii_have_whole_numbers() -> None:
    assert teeth_of(textbook.load("double_pendulum")) == ()
    pair = Mechanism(
        "pair",
        (Body("ground"), Body("a", disk(1.0, 0.1)), Body("b", disk(1.0, 0.1234))),
        (
            Revolute("p", "ground", "a", axis=(0, 0, 1)),
            Revolute("q", "ground", "b", axis=(0, 0, 1), origin=Placement((0.2234, 0, 0))),
        ),
        elements=(Gear("mesh", "p", "q", 0.1, other_radius=0.1234),),
    )
    counts = [each.count for each in teeth_of(pair) if isinstance(each, WheelTeeth)]
    assert counts[1] / counts[0] == pytest.approx(1.234, rel=2e-3)


@pytest.mark.parametrize(("slant", "place"), [(90, 0.0), (90, 0.7), (60, -1.9), (120, 0.4)])
def test_bevel_wheels_mesh_on_their_pitch_cones(slant: float, place: float) -> None:
    """Their teeth point at each other across the ray from the apex, one between two."""
    big, small, angle = 0.2, 0.1, np.deg2rad(slant)
    c, s = np.cos(angle), np.sin(angle)
    a, b = (small + c * big) / s, (big + c * small) / s
    line = np.array([s, 0.0, c])
    machine = Mechanism(
        "bevel",
        (Body("ground"), Body("a", disk(3.0, big)), Body("b", disk(1.0, small))),
        (
            Revolute("A", "ground", "a", axis=(0, 0, 1), origin=Placement((0, 0, a))),
            Revolute("B", "ground", "b", axis=(0, 0, 1), origin=Placement(b * line, (0, angle, 0))),
        ),
        elements=(Gear("mesh", "A", "B", big, other_radius=small),),
    )
    wheels = {each.body: each for each in teeth_of(machine) if isinstance(each, WheelTeeth)}
    poses = dict(zip(("ground", "a", "b"), Reference(machine).poses([place]), strict=True))
    touch = np.array([big, 0, a])
    beside, pointing = [], []
    for name, radius in (("a", big), ("b", small)):
        wheel, pose = wheels[name], poses[name]
        outline = wheel.outline(radius) @ pose[:3, :3].T + pose[:3, 3]
        teeth = outline.reshape(wheel.count, 4, 3)
        nearest = teeth[np.linalg.norm(teeth.mean(axis=1) - touch, axis=1).argmin()]
        pitch = 2 * np.pi * radius / wheel.count
        tooth = nearest.mean(axis=0) - pose[:3, 3]
        toward = (touch - pose[:3, 3]) / radius
        beside.append(float(radius * np.arctan2(tooth[1], tooth @ toward) / pitch))
        root, tip = nearest[[0, 3]].mean(axis=0), nearest[[1, 2]].mean(axis=0)
        pointing.append((tip - root) / np.linalg.norm(tip - root))
        assert abs(pointing[-1] @ touch) / np.linalg.norm(touch) < 0.12  # half a tooth off at most
        assert len(visuals_of(machine)[name]) == wheel.count + 1
    assert apart(*beside) == pytest.approx(0.5, abs=1e-9)
    assert pointing[0] @ pointing[1] < -0.95
