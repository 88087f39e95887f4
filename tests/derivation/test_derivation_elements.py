"""Unit forces of cords, belts and teeth, in any place and tilt, against the geometry of contact."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from derivation_reading import value_of_text
from scipy.spatial.transform import Rotation

import mecanique as mq
from mecanique.derivation.mechanics.elements import Ground, UnitForce, unit_forces
from mecanique.derivation.numeric.newton_euler import Balances
from mecanique.derivation.printing.writers import Text
from mecanique.derivation.symbolic.balances import _list_meanings
from mecanique.derivation.symbolic.kinematics import relation_stages
from mecanique.derivation.symbolic.symbols import Algebra
from mecanique.model.constraints.elements import Element
from mecanique.model.states import States

r, R, ANGLE = 0.3, 0.1, 0.35
SEAT = mq.Placement((0.2, 0.1, 0.4), (0.5, -0.3, 0.8))
TILT = Rotation.from_euler("xyz", SEAT.rpy)
Y, Z = np.eye(3)[1:]


def pair(
    second: mq.Joint, *elements: Element, axis: tuple[float, float, float] = (0, 1, 0)
) -> mq.Mechanism:
    """Return a wheel a and a body b on a tilted seat."""
    joints = (
        mq.Fixed("mount", "ground", "seat", origin=SEAT),
        mq.Revolute("A", "seat", "a", axis=axis),
        second,
    )
    bodies = mq.Body("ground"), mq.Body("seat"), mq.Body("a", mq.ball(1.0, r)), mq.Body("b")
    return mq.Mechanism("pair", bodies, joints, elements=elements)


def acting(mechanism: mq.Mechanism) -> list[UnitForce]:
    """Return the unit forces in the axes of the seat, from its origin, all joints at zero."""
    at = {"ground": -TILT.inv().apply(SEAT.xyz), "seat": np.zeros(3)}
    turn = {"ground": TILT.inv().as_matrix()}
    for joint in mechanism.joints[1:]:
        at[joint.child] = np.array(joint.origin.xyz, dtype=float)
    ground = Ground(
        point=lambda body, xyz: list(at[body] + turn.get(body, np.eye(3)) @ np.array(xyz)),
        turn=lambda body: turn.get(body, np.eye(3)).tolist(),
        tilt=lambda placement: Rotation.from_euler("xyz", placement.rpy).as_matrix().tolist(),
        scalar=mechanism.evaluate,
        root=np.sqrt,
        wave=lambda angle: (np.cos(angle), np.sin(angle)),
        ratio=lambda a, b: a / b,
    )
    return unit_forces(mechanism, ground)


def on_b(units: list[UnitForce], point: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return what pushes b and what parts it from a, at a point; a is acted on in opposition."""
    found = {}
    for unit in units:
        np.testing.assert_allclose(unit.point, point, rtol=0, atol=1e-14)
        np.testing.assert_allclose(unit.moment, 0, rtol=0, atol=0)
        found[unit.body, unit.pressed] = np.array(unit.force)
    for pressed in (False, True):
        np.testing.assert_allclose(found["a", pressed], -found["b", pressed], rtol=0, atol=1e-15)
    return found["b", False], found["b", True]


@pytest.mark.parametrize("sides", [(1, 1), (1, -1), (-1, 1), (-1, -1)])
@pytest.mark.parametrize("slant", [0.6, 1.1, 2.0])
def test_bevel_wheels_push_where_their_pitch_circles_touch(
    slant: float, sides: tuple[int, int]
) -> None:
    """At p from the apex, across the plane of the axes, and apart across p."""
    c, s = np.cos(slant), np.sin(slant)
    x, y = sides[0] * r, sides[1] * R
    a, b = (y + c * x) / s, (x + c * y) / s
    line, p = np.array([s, 0, c]), np.array([x, 0, a])
    first = mq.Revolute("A", "seat", "a", axis=(0, 0, 1), origin=mq.Placement((0, 0, a)))
    second = mq.Revolute("B", "seat", "b", axis=(s, 0, c), origin=mq.Placement((b * s, 0, b * c)))
    gear = mq.Gear("mesh", "A", "B", r, other_radius=R, pressure_angle=ANGLE)
    bodies = mq.Body("ground"), mq.Body("seat"), mq.Body("a", mq.ball(1.0, r)), mq.Body("b")
    mount = mq.Fixed("mount", "ground", "seat", origin=SEAT)
    wheels = mq.Mechanism("bevel", bodies, (mount, first, second), elements=(gear,))
    push, part = on_b(acting(wheels), p)
    # what they do moves no wheel against the other: n × p turns as fast as ω line × p
    turned = float(np.cross(line, p) @ np.cross(Z, p)) / float(np.cross(Z, p) @ np.cross(Z, p))
    np.testing.assert_allclose(np.cross(line, p), turned * np.cross(Z, p), rtol=0, atol=1e-14)
    np.testing.assert_allclose(push[[0, 2]], 0, rtol=0, atol=1e-15)
    assert abs(push[1]) == pytest.approx(np.cos(ANGLE), rel=1e-13)
    assert np.cross(p, push) @ Z == pytest.approx(r * np.cos(ANGLE), rel=1e-13)
    away = b * line - (b * line @ p) / (p @ p) * p
    np.testing.assert_allclose(
        part, np.sin(ANGLE) * away / np.linalg.norm(away), rtol=0, atol=1e-14
    )


@pytest.mark.parametrize(
    ("internal", "offset", "bearing"), [(False, 0.0, 0.0), (False, 0.05, 1.1), (True, -0.2, 2.0)]
)
def test_wheels_push_along_the_tangent_and_part_along_the_line_of_centers(
    internal: bool, offset: float, bearing: float
) -> None:
    """Whatever stands between them along their axes; a wheel inside is parted inwards."""
    gear = mq.Gear("mesh", "A", "B", r, other_radius=R, internal=internal, pressure_angle=ANGLE)
    out = np.array([np.cos(bearing), 0, np.sin(bearing)])
    center = (r - R if internal else r + R) * out + offset * Y
    axle = mq.Revolute("B", "seat", "b", axis=(0, 1, 0), origin=mq.Placement(tuple(center)))
    push, part = on_b(acting(pair(axle, gear)), r * out)
    np.testing.assert_allclose(push, np.cos(ANGLE) * np.cross(Y, out), rtol=0, atol=1e-14)
    inward = -1 if internal else 1
    np.testing.assert_allclose(part, inward * np.sin(ANGLE) * out, rtol=0, atol=1e-14)


def test_a_rack_is_pushed_along_its_slide_and_parted_from_its_pinion() -> None:
    """The pinion touches it where the slide is nearest, wherever the rack stands along it."""
    slide = mq.Prismatic("B", "seat", "b", axis=(1, 0, 0), origin=mq.Placement((0.7, 0.2, -r)))
    push, part = on_b(
        acting(pair(slide, mq.Rack("mesh", "A", "B", r, pressure_angle=ANGLE))), -r * Z
    )
    np.testing.assert_allclose(push, np.cos(ANGLE) * np.cross(Y, -Z), rtol=0, atol=1e-14)
    np.testing.assert_allclose(part, -np.sin(ANGLE) * Z, rtol=0, atol=1e-14)


@pytest.mark.parametrize("sense", [1, -1])
def test_a_belt_pulls_along_the_tangents_of_its_pulleys(sense: int) -> None:
    """Open or crossed, as the senses are; its normal is in the axes of the seat."""
    over = mq.Pulley("a", r), mq.Pulley("b", R, sense)
    belt = mq.Belt("belt", over, preload=2.0, normal=(0, -1, 0), axes="seat")
    place = np.array([0.7, 0.0, 0.2])
    axle = mq.Revolute("B", "seat", "b", axis=(0, 1, 0), origin=mq.Placement(tuple(place)))
    units = acting(pair(axle, belt))
    assert [(unit.index, unit.body) for unit in units] == [(0, "a"), (0, "b"), (1, "b"), (1, "a")]
    wheels = {"a": (np.zeros(3), r, 1), "b": (place, R, sense)}
    for unit, other in zip(units, [units[k] for k in (1, 0, 3, 2)], strict=True):
        center, radius, side = wheels[unit.body]
        arm, force = np.array(unit.point) - center, np.array(unit.force)
        assert np.linalg.norm(force) == pytest.approx(1, rel=1e-14)
        assert np.linalg.norm(arm) == pytest.approx(radius, rel=1e-14)
        # towards the other end, and turning the pulleys in their senses, on to it or back
        run = np.subtract(other.point, unit.point)
        np.testing.assert_allclose(force, run / np.linalg.norm(run), rtol=0, atol=1e-14)
        onward = 1 if unit.index == (unit.body == "b") else -1
        np.testing.assert_allclose(
            np.cross(arm, force), -Y * side * onward * radius, rtol=0, atol=1e-14
        )


@pytest.mark.parametrize("kind", ["distance", "ball", "hinge", "weld", "plate", "pin"])
def test_a_loop_acts_along_its_rows_at_its_end_in_b(kind: str) -> None:
    """Forces and moments along the axes of the frame in a; of a distance, along the line."""
    at, end = mq.Placement((0.1, 0.2, 0.3), (0.4, 0.5, 0.6)), np.array([0.7, 0.1, -0.2])
    long = {"length": 1.0} if kind == "distance" else {}
    loop = mq.Loop("tie", kind, "a", at, "b", mq.Placement((0.1, 0.0, 0.2)), **long)  # type: ignore[arg-type]  # parametrized
    slide = mq.Prismatic("B", "seat", "b", axis=(1, 0, 0), origin=mq.Placement(tuple(end)))
    axes = dict(zip("xyz", Rotation.from_euler("xyz", at.rpy).as_matrix().T, strict=True))
    rows = {
        "distance": ["length"],
        "ball": ["x", "y", "z"],
        "pin": ["x", "y"],
        "plate": ["x", "y", "rz"],
        "hinge": ["x", "y", "z", "rx", "ry"],
        "weld": ["x", "y", "z", "rx", "ry", "rz"],
    }[kind]
    units = acting(pair(slide, loop))
    place = end + np.array([0.1, 0.0, 0.2])
    line = place - np.array(at.xyz)
    for k, (on, back) in enumerate(zip(units[::2], units[1::2], strict=True)):
        assert (on.index, on.body, back.index, back.body) == (k, "b", k, "a")
        along = line / np.linalg.norm(line) if rows[k] == "length" else axes[rows[k][-1]]
        force, moment = (0 * along, along) if rows[k].startswith("r") else (along, 0 * along)
        for unit, sign in ((on, 1), (back, -1)):
            np.testing.assert_allclose(unit.point, place, rtol=0, atol=1e-15)
            np.testing.assert_allclose(unit.force, sign * force, rtol=0, atol=1e-15)
            np.testing.assert_allclose(unit.moment, sign * moment, rtol=0, atol=1e-15)
    assert len(units) == 2 * len(rows)


J, K, ROTORS = 0.4, 0.15, (0.05, 0.02)
"""Inertia of two wheels and of the rotors in their bearings."""


def geared(element: mq.Gear | mq.Belt, place: mq.Placement, ratio: float, torque: float) -> Any:
    """Return the wheels a, driven, and b, at a place, which turns by a ratio."""
    axles = [
        mq.Revolute(name, "ground", body, axis=(0, 1, 0), origin=at, coordinate=q, armature=rotor)
        for name, body, at, q, rotor in (
            ("A", "a", mq.Placement(), "turn", ROTORS[0]),
            ("B", "b", place, "other", ROTORS[1]),
        )
    ]
    wheels = [
        mq.Body(name, mq.Shape(2.0, (0, 0, 0), (inertia, inertia, inertia, 0, 0, 0)))
        for name, inertia in (("a", J), ("b", K))
    ]
    return mq.Mechanism(
        "wheels",
        (mq.Body("ground"), *wheels),
        tuple(axles),
        forces=(mq.JointForce("motor", "A", torque),),
        elements=(element,),
        coordinates=mq.Coordinates(("turn",), {"other": ratio * mq.coordinate("turn")}),
        gravity=(0, 0, -9.81),
    )


@pytest.mark.parametrize("torque", [3.0, -3.0])
def test_teeth_part_their_wheels_whichever_way_they_push(torque: float) -> None:
    """The bearing of b holds it against tan(angle) times the force that turns it and its rotor."""
    gear = mq.Gear("mesh", "A", "B", r, other_radius=R, pressure_angle=ANGLE)
    wheels = geared(gear, mq.Placement((r + R, 0, 0)), -r / R, torque)
    # a turns from z to x, and so pushes b down
    turned = torque / (J + ROTORS[0] + (K + ROTORS[1]) * (r / R) ** 2)
    along = -(K + ROTORS[1]) * turned * r / R**2
    held = Balances(wheels).reactions(States.of(wheels, [0.3], [1.7]))
    for joint, away in (("A", 1), ("B", -1)):
        expected = [away * abs(along) * np.tan(ANGLE), 0, 2.0 * 9.81 + away * along]
        np.testing.assert_allclose(held[joint].force[0], expected, rtol=1e-12, atol=1e-12)
        np.testing.assert_allclose(held[joint].moment[0, ::2], 0, rtol=0, atol=1e-12)


def test_a_belt_pulls_by_its_preload_and_what_turns_the_wheel_that_it_drives() -> None:
    """Half of the difference more on one side, half less on the other."""
    belt = mq.Belt("belt", (mq.Pulley("a", r), mq.Pulley("b", R)), preload=50.0, normal=(0, -1, 0))
    drive = geared(belt, mq.Placement((0.7, 0, 0.2)), r / R, 3.0)
    half = (K + ROTORS[1]) * (r / R) / (2 * R)
    steps = mq.derive(drive, "newton_euler").text(steps=True)
    (first,), (second,) = (re.findall(rf"T_belt_{k} = (.*turn''.*)", steps) for k in (1, 2))
    for turned in (0.0, 2.0):
        values = {"turn''": turned}
        assert value_of_text(first, values) == pytest.approx(50.0 + half * turned, rel=1e-12)
        assert value_of_text(second, values) == pytest.approx(50.0 - half * turned, rel=1e-12)


def test_a_tension_is_told_from_the_first_to_the_last_body_that_it_pulls() -> None:
    """Over an eye it stays the same; a wheel that the cord turns parts it."""
    over = mq.Pulley("eye", 0.0, grips=False), mq.Pulley("wheel", 0.2)
    cord = mq.Cord("cord", ("left", (0, 0, 0)), over, ("right", (0, 0, 0)))
    places = {"left": (-1, 0, -1), "eye": (-1, 0, 0), "wheel": (0, 0, 0), "right": (0.2, 0, -2)}
    slides = [
        mq.Prismatic(
            f"rail_{body}",
            "ground",
            body,
            axis=(0, 0, 1),
            origin=mq.Placement(places[body]),
            coordinate=f"z_{body}",
        )
        for body in ("left", "right")
    ]
    fixed = mq.Fixed("hold", "ground", "eye", origin=mq.Placement(places["eye"]))
    axle = mq.Revolute("axle", "ground", "wheel", axis=(0, -1, 0), coordinate="turn")
    lift = {f"z_{body}": side * mq.coordinate("turn") for body, side in (("left", r), ("right", R))}
    machine = mq.Mechanism(
        "machine",
        (mq.Body("ground"), *(mq.Body(body, mq.ball(1.0, 0.1)) for body in places)),
        (*slides, fixed, axle),
        coordinates=mq.Coordinates(("turn",), lift),
        elements=(cord,),
    )
    told = dict(_list_meanings(machine, {}))
    assert told == {
        "T_cord_1": "tension of the cord from the left to the wheel [N]",
        "T_cord_2": "tension of the cord from the wheel to the right [N]",
    }


def test_relations_that_are_long_are_told_once_and_short_ones_with_their_rates() -> None:
    """The other wheel turns by -3 turn; two slides follow turn² + 3 turn in opposite ways."""
    gear = mq.Gear("mesh", "A", "B", r, other_radius=R)
    wheels = geared(gear, mq.Placement((r + R, 0, 0)), -3.0, 1.0)
    slides = [
        mq.Prismatic(f"rail_{name}", "ground", name, axis=(1, 0, 0), coordinate=f"x_{name}")
        for name in "cdef"
    ]
    turn = mq.coordinate("turn")
    long, short = turn**2 + 3 * turn, 2 * turn
    led = {"other": -3 * turn, "x_c": long, "x_d": -long, "x_e": short, "x_f": -short}
    machine = replace(
        wheels,
        bodies=(*wheels.bodies, *(mq.Body(name, mq.particle(1.0)) for name in "cdef")),
        joints=(*wheels.joints, *slides),
        coordinates=mq.Coordinates(("turn",), led),
    )
    (step,) = relation_stages(Algebra(machine))
    assert [line.write(Text()) for line in step.results] == [
        "other = -3 turn",
        "other' = -3 turn'",
        "x_c = 3 turn + turn^2",
        "x_c' = (3 + 2 turn) turn'",
        "x_d = -x_c",
        "x_e = 2 turn",
        "x_e' = 2 turn'",
        "x_f = -2 turn",
        "x_f' = -2 turn'",
    ]
