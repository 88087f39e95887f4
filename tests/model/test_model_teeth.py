"""Teeth that are drawn mesh, wherever the wheels have turned to."""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import numpy as np
import pytest

from mecanique import (
    Body,
    Gear,
    Mechanism,
    Placement,
    Prismatic,
    Rack,
    Reference,
    Revolute,
    ball,
    box,
    disk,
    textbook,
)
from mecanique.model.bodies.visuals import Box, Cylinder, Visual
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


def bevel_wheels(slant: float, big: float = 0.2, small: float = 0.1, sign: int = 1) -> Mechanism:
    """Two bevel wheels at an angle [°], the apex of their pitch cones at the origin.

    The axis of the second points away from the apex, or towards it.
    """
    angle = np.deg2rad(slant)
    c, s = np.cos(angle), np.sin(angle)
    a, b = (small + c * big) / s, (big + c * small) / s
    line = np.array([s, 0.0, c])
    return Mechanism(
        "bevel",
        (Body("ground"), Body("a", disk(3.0, big)), Body("b", disk(1.0, small))),
        (
            Revolute("A", "ground", "a", axis=(0, 0, 1), origin=Placement((0, 0, a))),
            Revolute(
                *("B", "ground", "b"),
                axis=(0, 0, sign),
                origin=Placement(b * line, (0, angle, 0)),
            ),
        ),
        elements=(Gear("mesh", "A", "B", big, other_radius=small),),
    )


def reach(mechanism: Mechanism, visual: Visual, origin: np.ndarray, axes: np.ndarray) -> np.ndarray:
    """Return how far a box reaches along some axes, least and greatest, shape (axes, 2)."""
    assert isinstance(visual.geometry, Box)
    half = np.array(mechanism.evaluate_all(visual.geometry.size)) / 2
    corners = half * list(product((-1, 1), repeat=3))
    pose = mechanism.matrix(visual.placement)
    along = (corners @ pose[:3, :3].T + pose[:3, 3] - origin) @ axes.T
    return np.stack([along.min(axis=0), along.max(axis=0)], axis=1)


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
    # its teeth point to the pinion, and its axes are right-handed
    axes = slide[:3, :3] @ rack.axes
    np.testing.assert_allclose(axes[:, 1], [0, 0, 1], rtol=0, atol=1e-15)
    assert np.linalg.det(axes) == pytest.approx(1, rel=1e-12)
    # all of them on its box, tips one module above the pitch line
    outline = rack.outline(pitch / np.pi)
    assert np.abs(outline[:, 0]).max() <= 0.4
    assert outline[:, 2].max() == pytest.approx(pitch / np.pi, rel=1e-12)


def test_a_wheel_is_drawn_to_the_root_of_its_teeth() -> None:
    gear = textbook.load("planetary_gear")
    visuals = visuals_of(gear)
    rim, _, *teeth = visuals["sun"]
    assert len(teeth) == 25
    assert isinstance(rim.geometry, Cylinder)
    # a module is 2 r/z
    assert gear.evaluate(rim.geometry.radius) == pytest.approx(0.1 - 1.25 * 0.2 / 25, rel=1e-12)
    assert visuals["arm"] == gear.body("arm").visuals
    assert len(visuals["ring"]) == 1 + 55


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


@pytest.mark.parametrize("slant", [60, 120, 150])
@pytest.mark.parametrize("scale", [0.01, 100.0])
def test_bevel_teeth_point_the_same_way_at_any_size(slant: float, scale: float) -> None:
    for big, small in ((0.2, 0.1), (0.1, 0.2), (0.2, 0.15)):
        drawn, scaled = (
            [each.rise for each in teeth_of(pair) if isinstance(each, WheelTeeth)]
            for pair in (
                bevel_wheels(slant, big, small),
                bevel_wheels(slant, scale * big, scale * small),
            )
        )
        np.testing.assert_allclose(scaled, drawn, rtol=1e-12, atol=0)


@pytest.mark.parametrize(
    ("slant", "place"), [(90, 0.0), (90, 0.7), (60, -1.9), (120, 0.4), (140, 1.3)]
)
@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize(("big", "small"), [(0.2, 0.1), (0.1, 0.2)])
def test_bevel_wheels_mesh_on_their_pitch_cones(
    slant: float, place: float, sign: int, big: float, small: float
) -> None:
    """Their teeth point at each other across the ray from the apex, one between two."""
    machine = bevel_wheels(slant, big, small, sign)
    wheels = {each.body: each for each in teeth_of(machine) if isinstance(each, WheelTeeth)}
    poses = dict(zip(("ground", "a", "b"), Reference(machine).poses([place]), strict=True))
    touch = np.array([big, 0, machine.home_poses["a"][2, 3]])
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


MACHINES = {
    "planetary gear": textbook.load("planetary_gear"),
    "rack and pinion": textbook.load("rack_and_pinion"),
    # beyond 120° the pitch cone of the larger wheel is hollow
    **{f"bevel wheels at {slant}°": bevel_wheels(slant) for slant in (60, 90, 140)},
}
HEIGHTS, WIDTHS = np.array([-1.25, 1, 1, -1.25]), np.array([-0.36, -0.14, 0.14, 0.36])


@pytest.mark.parametrize("name", MACHINES)
def test_drawn_teeth_fill_their_contour(name: str) -> None:
    """From 1.25 modules below the pitch circle to one above, half a pitch wide on average.

    The teeth of spur wheels lie on both sides of their plane, those of bevel wheels stand on the
    pitch cone and reach from the pitch circle towards the apex.
    """
    machine = MACHINES[name]
    visuals = visuals_of(machine)
    for wheel in teeth_of(machine):
        if isinstance(wheel, RackTeeth):
            continue
        radius, width = machine.evaluate_all((wheel.radius, wheel.width))
        module, n = 2 * radius / wheel.count, wheel.axes[:, 2]
        pose = machine.home_poses[wheel.body]
        contour = wheel.outline(radius).reshape(wheel.count, 4, 3)
        drawn = visuals[wheel.body][-wheel.count :]
        for k, (tooth, visual) in enumerate(zip(contour, drawn, strict=True)):
            turned = wheel.phase + 2 * np.pi * k / wheel.count
            out = wheel.axes @ [np.cos(turned), np.sin(turned), 0]
            along, ray = np.cross(n, out), radius * out + pose[:3, :3].T @ pose[:3, 3]
            up = np.cross(along, ray) / np.linalg.norm(ray) if wheel.rise else out
            up = -up if wheel.internal else up
            inward = -ray / np.linalg.norm(ray) if wheel.rise else n
            # a box in a frame of its pitch point
            quarter = np.pi * module / 4
            across = [0, width] if wheel.rise else [-width / 2, width / 2]
            spans = [[-1.25 * module, module], [-quarter, quarter], across]
            spanned = reach(machine, visual, radius * out, np.array([up, along, inward]))
            np.testing.assert_allclose(spanned, spans, rtol=0, atol=1e-12)
            # the corners of the contour, turned from the middle of the tooth
            angles = WIDTHS * 2 * np.pi / wheel.count
            turns = np.outer(np.cos(angles), out) + np.outer(np.sin(angles), along)
            high = np.outer(HEIGHTS * module, up)
            level, above = high @ out, np.outer(high @ n, n)
            np.testing.assert_allclose(
                tooth, (radius + level)[:, None] * turns + above, rtol=0, atol=1e-12
            )


def test_a_rack_has_the_teeth_that_fit_on_its_longest_box() -> None:
    """Each from 1.25 modules below the pitch line to one above, the longest box may be turned."""
    machine = textbook.load("rack_and_pinion")
    plain = machine.body("rack")
    (shown,) = plain.visuals
    stand = replace(shown, geometry=Box((0.05, 0.9, 0.7)), placement=Placement((0.1, 0, -0.3)))
    turned = replace(
        shown,
        geometry=Box((0.04, 0.9, 0.05)),
        placement=Placement((0.13, 0, -0.037), (np.pi / 2, np.pi / 2, 0)),
    )
    for drawn, ends in (((shown, stand), (-0.4, 0.4)), ((shown, turned, stand), (-0.32, 0.58))):
        body = replace(plain.shapes[0], visuals=drawn)
        bodies = (*machine.bodies[:2], Body("rack", body))
        _, rack = teeth_of(replace(machine, bodies=bodies))
        assert isinstance(rack, RackTeeth)
        module = machine.evaluate(rack.module)
        pitch = np.pi * module
        contour = rack.outline(module).reshape(-1, 4, 3)
        middles = contour.mean(axis=1)[:, 0]
        way = np.sign(middles[1] - middles[0])
        np.testing.assert_allclose(np.diff(middles), way * pitch, rtol=0, atol=1e-14)
        # no other one has room
        first, last = sorted((middles[0], middles[-1]))
        assert ends[0] <= first - 0.36 * pitch < ends[0] + pitch
        assert ends[1] >= last + 0.36 * pitch > ends[1] - pitch
        boxes = [*rack.visuals(module)]
        axes = np.array(
            [np.sign(middles[1] - middles[0]) * np.eye(3)[0], np.eye(3)[2], np.eye(3)[1]]
        )
        for tooth, visual, middle in zip(contour, boxes, middles, strict=True):
            origin = np.array([middle, 0, 0])
            np.testing.assert_allclose(
                (tooth - origin) @ axes[:2].T,
                np.stack([WIDTHS * pitch, HEIGHTS * module], axis=1),
                rtol=0,
                atol=1e-12,
            )
            spans = [[-pitch / 4, pitch / 4], [-1.25 * module, module], [-0.025, 0.025]]
            spanned = reach(machine, visual, origin, axes)
            np.testing.assert_allclose(spanned, spans, rtol=0, atol=1e-12)


def test_a_rack_without_a_box_has_the_teeth_that_fit_on_eight_pitches() -> None:
    machine = textbook.load("rack_and_pinion")
    bodies = (*machine.bodies[:2], Body("rack", ball(1.0, 0.1)))
    _, rack = teeth_of(replace(machine, bodies=bodies))
    assert isinstance(rack, RackTeeth)
    assert len(rack.outline(machine.evaluate(rack.module))) == 7 * 4


@pytest.mark.parametrize(
    ("radii", "counts"),
    [
        ((0.1, 0.2), (15, 30)),
        ((0.1, 0.15), (16, 24)),
        ((0.2, 0.07), (60, 21)),
        ((0.1, 0.1025), (40, 41)),
        ((0.1, 0.1), (15, 15)),
    ],
)
def test_the_smallest_wheel_has_as_few_teeth_as_make_both_numbers_whole(
    radii: tuple[float, float], counts: tuple[int, int]
) -> None:
    first, second = radii
    pair = Mechanism(
        "pair",
        (Body("ground"), Body("a", disk(1.0, first, 0.03)), Body("b", disk(1.0, second, 0.05))),
        (
            Revolute("p", "ground", "a", axis=(0, 0, 1)),
            Revolute("q", "ground", "b", axis=(0, 0, 1), origin=Placement((first + second, 0, 0))),
        ),
        elements=(Gear("mesh", "p", "q", first, other_radius=second),),
    )
    wheels = [each for each in teeth_of(pair) if isinstance(each, WheelTeeth)]
    assert tuple(wheel.count for wheel in wheels) == counts
    # the other wheel shows how wide they are, the first where the other has no such shape
    assert [wheel.width for wheel in wheels] == [0.05, 0.05]
    bare = replace(pair, bodies=(*pair.bodies[:2], Body("b", ball(1.0, second / 2))))
    assert teeth_of(bare)[0].width == 0.03


def test_a_bent_train_and_its_rack_mesh_at_every_pitch_point() -> None:
    """Whichever way the wheels' frames and axes are turned, a tooth is between two of the other."""
    radii = {"a": 0.1, "b": 0.15, "c": 0.05}
    a = np.zeros(3)
    b = a + 0.25 * np.array([np.cos(0.4), np.sin(0.4), 0])
    c = b + 0.2 * np.array([np.cos(2.0), np.sin(2.0), 0])
    along, down = np.array([np.cos(1.2), np.sin(1.2), 0]), np.array([np.sin(1.2), -np.cos(1.2), 0])
    start = c + 0.05 * down + 0.1 * along
    frames = [
        Placement(tuple(place), turned)
        for place, turned in zip(
            (a, b, c), ((0.7, 0.2, 0.3), (-0.4, 0, -1.1), (0, -0.6, 2.5)), strict=True
        )
    ]
    turn = np.array(Placement(rpy=(0.5, -0.3, 1.2)).rotation, dtype=float)
    # the rack's frame on the other side of the wheel
    point = (turn.T @ (0.3 * down - 0.2 * along)).tolist()
    bed = Placement(tuple(start - turn @ point), (0.5, -0.3, 1.2))
    x, y, z = (along @ turn).tolist()
    machine = Mechanism(
        "train",
        (
            Body("ground"),
            *(Body(name, disk(1.0, radius)) for name, radius in radii.items()),
            Body("rack", box(1.0, (0.7, 0.02, 0.05))),
        ),
        (
            *(
                Revolute(
                    name.upper(),
                    "ground",
                    name,
                    axis=tuple(sense * x for x in frame.rotation[2]),
                    origin=frame,
                )
                for name, frame, sense in zip(radii, frames, (1, -1, 1), strict=True)
            ),
            Prismatic("S", "ground", "rack", axis=(x, y, z), origin=bed),
        ),
        elements=(
            Gear("ab", "A", "B", 0.1, other_radius=0.15),
            Gear("cb", "C", "B", 0.05, other_radius=0.15),
            Rack("cs", "C", "S", 0.05, point=point),
        ),
    )
    parts = {each.body: each for each in teeth_of(machine)}
    wheels = {name: part for name, part in parts.items() if isinstance(part, WheelTeeth)}
    assert [wheels[name].count for name in "abc"] == [30, 45, 15]

    def offset_at(name: str, toward: np.ndarray) -> float:
        """How far a tooth is from a pitch point, along z × toward, in teeth."""
        pose, wheel = machine.home_poses[name], wheels[name]
        tooth = wheel.outline(radii[name])[:4].mean(axis=0) @ pose[:3, :3].T
        turned = np.arctan2(np.cross(toward, tooth)[2], tooth @ toward)
        return float(turned * wheel.count / (2 * np.pi))

    for first, second, between in (("a", "b", b - a), ("c", "b", b - c)):
        u = between / np.linalg.norm(between)
        assert apart(offset_at(first, u), -offset_at(second, -u)) == pytest.approx(0.5, abs=1e-9)
    rack, pose, pitch = parts["rack"], machine.home_poses["rack"], 2 * np.pi * 0.05 / 15
    assert isinstance(rack, RackTeeth)
    tooth = rack.outline(pitch / np.pi)[:4].mean(axis=0) @ pose[:3, :3].T + pose[:3, 3]
    lead = float((tooth - c) @ np.cross([0, 0, 1], down)) / pitch
    assert apart(offset_at("c", down), lead) == pytest.approx(0.5, abs=1e-9)
