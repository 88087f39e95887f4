"""Gears and racks: the force along the line of action, and what it leaves to the bearings."""

from __future__ import annotations

from dataclasses import replace
from math import cos, pi, radians, sin

import numpy as np
import pytest

import mecanique as mq
from mecanique.errors import EngineError, InputError, MechanismError
from mecanique.model import Gear, Rack
from mecanique.model.mechanism import Mechanism
from mecanique.model.mechanism.element_laws import bevel_of
from mecanique.viewing.scene.from_motion import scene_of

ACROSS, FLAT = (0.0, -1.0, 0.0), (pi / 2, 0.0, 0.0)
ANGLE = radians(20)
BIG, SMALL, DRIVE = 0.2, 0.1, 2.0


def wheel(name: str, mass: float, radius: float) -> mq.Body:
    return mq.Body(name, mq.disk(mass, radius).at(rpy=FLAT))


def pair(*, far: float = BIG + SMALL, drive: float = DRIVE, **changes: object) -> Mechanism:
    """Two wheels in mesh, the big one driven."""
    about = {"other_radius": SMALL, **changes}
    return mq.Mechanism(
        "pair",
        (mq.Body("ground"), wheel("a", 3.0, BIG), wheel("b", 1.0, SMALL)),
        (
            mq.Revolute("A", "ground", "a", axis=ACROSS),
            mq.Revolute("B", "ground", "b", axis=ACROSS, origin=mq.Placement((far, 0, 0))),
        ),
        forces=(mq.JointForce("drive", "A", drive),),
        coordinates=mq.Coordinates((), {"B": -2 * mq.coordinate("A")}),
        elements=(Gear("mesh", "A", "B", BIG, **about),),  # type: ignore[arg-type]
    )


def rack() -> Mechanism:
    """A driven pinion on a rack below it."""
    return mq.Mechanism(
        "rack",
        (mq.Body("ground"), wheel("p", 3.0, BIG), mq.Body("r", mq.box(2.0, (1.0, 0.05, 0.05)))),
        (
            mq.Revolute("P", "ground", "p", axis=ACROSS),
            mq.Prismatic("S", "ground", "r", axis=(1, 0, 0), origin=mq.Placement((0, 0, -BIG))),
        ),
        forces=(mq.JointForce("drive", "P", DRIVE),),
        coordinates=mq.Coordinates((), {"S": BIG * mq.coordinate("P")}),
        elements=(Rack("mesh", "P", "S", BIG),),
    )


def planetary() -> Mechanism:
    """A driven sun, a planet on an arm, and a ring that is held."""
    c = mq.coordinate("C")
    ring = BIG + 2 * SMALL
    return mq.Mechanism(
        "planetary",
        (
            *(mq.Body("ground"), wheel("sun", 3.0, BIG), wheel("planet", 1.0, SMALL)),
            *(mq.Body("arm", mq.rod(1.0, BIG + SMALL)), mq.Body("ring")),
        ),
        (
            mq.Revolute("S", "ground", "sun", axis=ACROSS),
            mq.Revolute("C", "ground", "arm", axis=ACROSS),
            mq.Revolute(
                "P", "arm", "planet", axis=ACROSS, origin=mq.Placement((0, 0, -BIG - SMALL))
            ),
            mq.Revolute("R", "ground", "ring", axis=ACROSS),
        ),
        forces=(mq.JointForce("drive", "S", DRIVE),),
        coordinates=mq.Coordinates(("C",), {"S": 3 * c, "P": -4 * c, "R": 0.0}),
        elements=(
            Gear("inner", "S", "P", BIG, other_radius=SMALL),
            Gear("outer", "R", "P", ring, other_radius=SMALL, internal=True),
        ),
    )


@pytest.mark.parametrize("drive", [DRIVE, -DRIVE])
def test_a_pair_of_wheels_by_hand(drive: float) -> None:
    """I_b a_b = F cos(20°) r_b about b; the bearings bear F, its radial part outwards, weights."""
    machine = pair(drive=drive)
    reference, equations = mq.Reference(machine), mq.derive(machine, method="newton_euler")
    big, small = 3.0 * BIG**2 / 2, 1.0 * SMALL**2 / 2
    a = reference.acceleration([0.3])[0]
    assert a == pytest.approx(drive / (big + 4 * small), rel=1e-12)
    push = small * 2 * a / (SMALL * cos(ANGLE))
    for forces in (reference.guide_forces([0.3]), equations.guide_forces([0.3])):
        assert forces["mesh"] == pytest.approx(push, rel=1e-12)
    along, apart = push * cos(ANGLE), abs(push) * sin(ANGLE)
    for reactions in (reference.reactions([0.3]), equations.reactions([0.3], None)):
        np.testing.assert_allclose(
            reactions["B"].force, [-apart, 0, 9.81 - along], rtol=0, atol=1e-13
        )
        np.testing.assert_allclose(
            reactions["A"].force, [apart, 0, 29.43 + along], rtol=0, atol=1e-13
        )
        for joint in "AB":
            np.testing.assert_allclose(reactions[joint].moment, 0, rtol=0, atol=1e-14)


def test_a_pair_of_wheels_in_letters() -> None:
    text = mq.derive(pair(pressure_angle=0.0), method="newton_euler").text(steps=True)
    lines = [line.strip() for line in text.splitlines()]
    assert "0.06 A'' = 2 - 0.2 F_mesh" in lines
    assert "F_mesh = 0.1 A''" in lines
    assert "R_B_z = 9.81 - 0.1 A''" in lines
    parted = mq.derive(pair(), method="newton_euler").text(steps=True)
    assert "N_mesh  separating force, |F_mesh| sin(pressure angle) [N]" in parted
    assert "R_A_x = N_mesh" in [line.strip() for line in parted.splitlines()]


def test_a_rack_by_hand() -> None:
    machine = rack()
    reference = mq.Reference(machine)
    a = reference.acceleration([0.3])[0]
    assert a == pytest.approx(DRIVE / (3.0 * BIG**2 / 2 + 2.0 * BIG**2), rel=1e-12)
    push = 2.0 * BIG * a / cos(ANGLE)
    assert reference.guide_forces([0.3])["mesh"] == pytest.approx(push, rel=1e-12)
    reactions = reference.reactions([0.3])
    apart = push * sin(ANGLE)
    np.testing.assert_allclose(reactions["S"].force, [0, 0, 19.62 + apart], rtol=0, atol=1e-13)
    np.testing.assert_allclose(
        reactions["P"].force, [push * cos(ANGLE), 0, 29.43 - apart], rtol=1e-14, atol=0
    )


def test_a_planetary_gear_by_hand() -> None:
    """The sun's balance gives the inner force, the held ring's moment the outer one."""
    machine = planetary()
    reference = mq.Reference(machine)
    assert reference.guided == {}
    a = reference.acceleration([0.3], [0.5])[0]
    forces = reference.guide_forces([0.3], [0.5])
    inner = (DRIVE - 3.0 * BIG**2 / 2 * 3 * a) / (BIG * cos(ANGLE))
    assert forces["inner"] == pytest.approx(inner, rel=1e-11)
    held = reference.reactions([0.3], [0.5])["R"].moment[1]
    assert abs(held) == pytest.approx(abs(forces["outer"]) * cos(ANGLE) * 0.4, rel=1e-11)
    for joint in "SCP":
        assert reference.reactions([0.3], [0.5])[joint].moment[1] == pytest.approx(0, abs=1e-12)


@pytest.mark.parametrize("machine", [pair(), rack(), planetary()], ids=lambda m: m.name)
def test_verdicts_and_urdf(machine: Mechanism) -> None:
    assert mq.verify(machine, samples=5).agrees
    again = mq.read_urdf(mq.write_urdf(machine))
    assert [type(each) for each in again.elements] == [type(each) for each in machine.elements]
    reference, equations = mq.Reference(machine), mq.derive(machine, method="newton_euler")
    q, v = np.array([0.7]), np.array([-0.4])
    for name, (force, moment) in equations.reactions(q, v).items():
        wrench = reference.reactions(q, v)[name]
        np.testing.assert_allclose(force, wrench.force, rtol=0, atol=1e-12)
        np.testing.assert_allclose(moment, wrench.moment, rtol=0, atol=1e-13)


def test_wrong_wheels_are_refused_with_place_and_remedy() -> None:
    with pytest.raises(EngineError, match=r"gear 'mesh' does not fit its axes: they are 0.31 m"):
        mq.Reference(pair(far=0.31))
    with pytest.raises(EngineError, match=r"gear 'mesh' does not fit the coordinate map"):
        mq.Reference(pair(far=BIG - SMALL, internal=True))
    beside = mq.Prismatic("S", "ground", "r", axis=(1, 0, 0), origin=mq.Placement((0, 0, -0.22)))
    with pytest.raises(EngineError, match=r"rack 'mesh' does not fit its axes: they are 0.22 m"):
        mq.Reference(replace(rack(), joints=(rack().joints[0], beside)))
    with pytest.raises(MechanismError, match=r"'mesh': expected the name of a hinge, got 'C'"):
        mq.Mechanism(
            "one",
            (mq.Body("ground"), wheel("a", 1.0, BIG)),
            (mq.Revolute("A", "ground", "a", axis=ACROSS),),
            elements=(Gear("mesh", "A", "C", BIG, other_radius=SMALL),),
        )
    with pytest.raises(InputError, match=r"gear 'mesh': expected a pressure angle from 0"):
        pair(pressure_angle=2.0)


@pytest.mark.parametrize(
    ("before", "after", "message"),
    [
        ('wheel="A"', 'wheel="Z"', "'Z' is no joint"),
        ('internal="false"', 'internal="no"', "expected internal true or false, got 'no'"),
        ('pressure_angle="0.', 'pressure_angle="9.', "expected a pressure angle from 0"),
    ],
)
def test_a_gear_that_cannot_be_read_is_reported(before: str, after: str, message: str) -> None:
    text = mq.write_urdf(pair())
    assert before in text
    findings = mq.lint(text.replace(before, after))
    assert any(message in finding.message for finding in findings)


def test_a_page_shows_what_a_gear_does_as_one_force() -> None:
    motion = mq.simulate(pair(), duration=0.1)
    arrows = {arrow.name: arrow.vector[0] for arrow in scene_of(motion).arrows}
    push = motion.guide_forces()["mesh"][0]
    expected = [push * sin(ANGLE), 0, push * cos(ANGLE)]
    np.testing.assert_allclose(arrows["mesh on b"], expected, rtol=0, atol=1e-14)
    np.testing.assert_allclose(arrows["mesh on a"], [-c for c in expected], rtol=0, atol=1e-14)


def bevel(**changes: object) -> Mechanism:
    """Two bevel wheels at right angles, the apex at the origin of the ground."""
    about = {"other_radius": SMALL, **changes}
    along = mq.Placement((0, 0, SMALL))
    aside = mq.Placement((BIG, 0, 0))
    return mq.Mechanism(
        "bevel",
        (
            mq.Body("ground"),
            mq.Body("a", mq.disk(3.0, BIG)),
            mq.Body("b", mq.disk(1.0, SMALL).at(rpy=(0, pi / 2, 0))),
        ),
        (
            mq.Revolute("A", "ground", "a", axis=(0, 0, 1), origin=along),
            mq.Revolute("B", "ground", "b", axis=(1, 0, 0), origin=aside),
        ),
        forces=(mq.JointForce("drive", "A", DRIVE),),
        elements=(Gear("mesh", "A", "B", BIG, **about),),  # type: ignore[arg-type]
        gravity=(0, 0, 0),
    )


def test_bevel_wheels_by_hand() -> None:
    """They touch at (0.2, 0, 0.1); the force parts them at right angles to the ray to there."""
    machine = bevel()
    reference, equations = mq.Reference(machine), mq.derive(machine, method="newton_euler")
    big, small = 3.0 * BIG**2 / 2, 1.0 * SMALL**2 / 2
    turned = float(machine.coordinates.driven["B"].subs({"A": 1.0}))
    # at the touch w_a z x (0.2, 0, 0.1) = w_b x x (0, 0, 0.1) gives 0.2 w_a = -0.1 w_b
    assert turned == -2.0
    a = reference.acceleration([0.3])[0]
    assert a == pytest.approx(DRIVE / (big + 4 * small), rel=1e-12)
    tangential = small * 2 * a / SMALL
    force = tangential / cos(ANGLE)
    ray = np.array([BIG, 0, SMALL]) / np.hypot(BIG, SMALL)
    apart = np.array([ray[2], 0, -ray[0]])  # from the wheel about z to the one about x
    expected = tangential * np.array([0, 1, 0]) + force * sin(ANGLE) * apart
    for forces in (reference.guide_forces([0.3]), equations.guide_forces([0.3])):
        assert forces["mesh"] == pytest.approx(force, rel=1e-12)
    for reactions in (reference.reactions([0.3]), equations.reactions([0.3], None)):
        np.testing.assert_allclose(reactions["B"].force, -expected, rtol=0, atol=1e-13)
        np.testing.assert_allclose(reactions["A"].force, expected, rtol=0, atol=1e-13)


@pytest.mark.parametrize("slant", [pi / 3, pi / 2, 2 * pi / 3, 2.7])
def test_bevel_wheels_at_any_angle_agree_and_read_back(slant: float) -> None:
    """Their centers lie s a = R + c r and s b = r + c R from the apex."""
    c, s = cos(slant), sin(slant)
    a, b = (SMALL + c * BIG) / s, (BIG + c * SMALL) / s
    machine = mq.Mechanism(
        "slant",
        (mq.Body("ground"), wheel("a", 3.0, BIG), wheel("b", 1.0, SMALL)),
        (
            mq.Revolute("A", "ground", "a", axis=(0, 0, 1), origin=mq.Placement((0, 0, a))),
            mq.Revolute("B", "ground", "b", axis=(s, 0, c), origin=mq.Placement((b * s, 0, b * c))),
        ),
        elements=(Gear("mesh", "A", "B", BIG, other_radius=SMALL),),
        forces=(mq.JointForce("drive", "A", DRIVE),),
    )
    assert mq.verify(machine, samples=5).agrees
    ours, theirs = (
        each.reactions([0.3], [0.2])["B"]
        for each in (mq.Reference(machine), mq.derive(machine, method="newton_euler"))
    )
    np.testing.assert_allclose(ours.force, theirs.force, rtol=0, atol=1e-12)
    np.testing.assert_allclose(ours.moment, theirs.moment, rtol=0, atol=1e-14)
    again = mq.read_urdf(mq.write_urdf(machine))
    assert again.coordinates.driven.keys() == {"B"}
    assert again.elements == machine.elements


@pytest.mark.parametrize("sides", [(1, 1), (1, -1), (-1, 1), (-1, -1)])
@pytest.mark.parametrize(("r", "R"), [(0.1, 0.2), (0.2, 0.02), (0.02, 0.2)])
@pytest.mark.parametrize("slant", [0.3, 1.1, 2.0, 2.8])
def test_bevel_wheels_move_alike_where_their_pitch_circles_touch(
    slant: float, r: float, R: float, sides: tuple[int, int]
) -> None:
    """Wherever they touch, ω₁ n₁ × p = ω₂ n₂ × p with p from the apex to the pitch point."""
    c, s = cos(slant), sin(slant)
    x, y = sides[0] * r, sides[1] * R
    a, b = (y + c * x) / s, (x + c * y) / s
    n, line, p = np.array([0, 0, 1]), np.array([s, 0, c]), np.array([x, 0, a])
    machine = mq.Mechanism(
        "slant",
        (mq.Body("ground"), wheel("a", 3.0, r), wheel("b", 1.0, R)),
        (
            mq.Revolute("A", "ground", "a", axis=(0, 0, 1), origin=mq.Placement((0, 0, a))),
            mq.Revolute("B", "ground", "b", axis=(s, 0, c), origin=mq.Placement(tuple(b * line))),
        ),
        elements=(Gear("mesh", "A", "B", r, other_radius=R),),
    )
    ratio = float(machine.coordinates.driven["B"].subs({"A": 1.0}))
    np.testing.assert_allclose(ratio * np.cross(line, p), np.cross(n, p), rtol=0, atol=1e-14)


def test_a_differential_follows_from_its_wheels() -> None:
    """Two side wheels and a planet on a cage: the cage turns with their mean."""
    r = 0.1
    hollow = mq.Shape(0.5, (0, 0, 0), (0.01, 0.01, 0.01, 0, 0, 0))
    machine = mq.Mechanism(
        "differential",
        (
            mq.Body("ground"),
            *(mq.Body(name, hollow) for name in ("cage", "left", "right", "planet")),
        ),
        (
            mq.Revolute("cage", "ground", "cage", axis=(0, 1, 0)),
            mq.Revolute("left", "ground", "left", axis=(0, 1, 0), origin=mq.Placement((0, r, 0))),
            mq.Revolute(
                "right", "ground", "right", axis=(0, 1, 0), origin=mq.Placement((0, -r, 0))
            ),
            mq.Revolute("planet", "cage", "planet", axis=(1, 0, 0), origin=mq.Placement((r, 0, 0))),
        ),
        elements=(
            Gear("near", "left", "planet", r, other_radius=r),
            Gear("far", "right", "planet", r, other_radius=r),
        ),
        gravity=(0, 0, 0),
    )
    assert tuple(machine.coordinates) == ("cage", "left")
    law = machine.coordinates.driven["right"]
    assert float(law.subs({"cage": 1.0, "left": 0.0})) == 2.0
    assert float(law.subs({"cage": 0.0, "left": 1.0})) == -1.0
    assert mq.verify(machine, samples=5).agrees


def test_bevel_wheels_that_share_no_apex_are_refused() -> None:
    with pytest.raises(
        EngineError, match=r"its pitch cones do not share an apex. The wheels are 0"
    ):
        mq.Reference(bevel(other_radius=0.15))
    machine = bevel()
    moved = machine.with_joint("B", origin=(BIG, 0.05, 0))
    with pytest.raises(
        EngineError, match=r"intersecting axes, but they pass each other at a distance of 0.05 m"
    ):
        mq.Reference(moved)


@pytest.mark.parametrize("angle", [0.6, 1.2, 2.2])
@pytest.mark.parametrize("sides", [(1, 1), (1, -1), (-1, 1), (-1, -1)])
def test_bevel_wheels_are_told_by_where_their_pitch_circles_touch(
    angle: float, sides: tuple[int, int]
) -> None:
    """From the apex, the centers are at (σ₂ r₂ + c σ₁ r₁) n₁/s and (σ₁ r₁ + c σ₂ r₂) n₂/s."""
    c, s, (r, R) = cos(angle), sin(angle), (0.1, 0.25)
    n, line = np.array([0.0, 0.0, 1.0]), np.array([s, 0.0, c])
    first = (sides[1] * R + c * sides[0] * r) / s
    second = (sides[0] * r + c * sides[1] * R) / s
    apex, gear = np.array([0.3, -0.2, 0.5]), Gear("mesh", "A", "B", r, other_radius=R)
    places = [tuple((apex + far * axis).tolist()) for far, axis in ((first, n), (second, line))]
    mechanism = mq.Mechanism(
        "bevel",
        (mq.Body("ground"), wheel("a", 3.0, r), wheel("b", 1.0, R)),
        tuple(
            mq.Revolute(name, "ground", name.lower(), axis=tuple(axis), origin=mq.Placement(place))
            for name, axis, place in zip("AB", (n, line), places, strict=True)
        ),
        elements=(gear,),
    )
    bevel = bevel_of(mechanism, gear)
    assert bevel is not None
    assert bevel.sides == sides
    assert bevel.ahead == np.sign(sides[1] * second)
    assert (bevel.cosine, bevel.sine) == pytest.approx((c, s), rel=1e-14)
    # the ratio leads the point that touches alike with both
    turned = mechanism.coordinates.driven["B"]
    goes = sides[0] * r * np.cross(n, (line - c * n) / s)
    along = sides[1] * R * np.cross(line, (n - c * line) / s)
    ratio = float(turned.diff(mq.coordinate("A")))
    np.testing.assert_allclose(goes, ratio * along, rtol=0, atol=1e-15)
