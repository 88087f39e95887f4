"""Cords, and pins that the coordinate map closes: their forces, and the reactions they leave."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from systems import derive_system

import mecanique as mq
from mecanique.errors import EngineError, InputError, MechanismError
from mecanique.model import Cord, Pulley
from mecanique.motion.analysis.forces import Actions
from mecanique.viewing.scene.from_motion import scene_of

HERE = (0.0, 0.0, 0.0)
HELD = (
    "atwood_machine",
    "bars_and_springs",
    "bars_and_springs_small",
    "double_atwood_machine",
    "swinging_atwood_machine",
)


def states(mechanism: mq.Mechanism) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    rng = np.random.default_rng(7)
    for _ in range(4):
        yield (
            mechanism.neutral() + rng.uniform(-0.3, 0.3, mechanism.nq),
            rng.normal(size=mechanism.nv),
        )


def test_the_axle_of_atwood_bears_both_tensions() -> None:
    """By hand: T1 = m1 (g - a), T2 = m2 (g + a), R = M g + T1 + T2."""
    machine = mq.textbook.load("atwood_machine")
    reference = mq.Reference(machine)
    assert reference.guided == {}
    m1, m2, M, g = (machine.values[name] for name in ("m1", "m2", "M", "g"))
    a = (m1 - m2) * g / (m1 + m2 + M / 2)
    tensions = m1 * (g - a), m2 * (g + a)
    for q, v in states(machine):
        forces = reference.guide_forces(q, v)
        assert list(forces) == ["cord_1", "cord_2"]
        assert tuple(forces.values()) == pytest.approx(tensions, rel=1e-13)
        wrenches = reference.reactions(q, v)
        np.testing.assert_allclose(
            wrenches["axle"].force, [0, 0, M * g + sum(tensions)], rtol=0, atol=1e-12
        )
        np.testing.assert_allclose(wrenches["axle"].moment, 0, rtol=0, atol=1e-13)
        for rail in ("rail1", "rail2"):
            np.testing.assert_allclose(wrenches[rail].force, 0, rtol=0, atol=1e-13)


def test_the_derivation_says_it_in_letters() -> None:
    equations = derive_system("atwood_machine", method="newton_euler")
    lines = [line.strip() for line in equations.text(steps=True).splitlines()]
    for line in (
        "0 = R_axle_z - T_cord_1 - T_cord_2 - M g",
        "M R x''/2 = R T_cord_1 - R T_cord_2",
        "T_cord_1 = m1 g - m1 x''",
        "T_cord_2 = m2 x'' + m2 g",
        "R_axle_z = (m2 - m1) x'' + (m1 + m2 + M) g",
    ):
        assert line in lines
    assert "undetermined" not in equations.text(steps=True)


@pytest.mark.parametrize("name", HELD)
def test_both_sides_agree_on_reactions_and_forces(name: str) -> None:
    mechanism = mq.textbook.load(name)
    reference = mq.Reference(mechanism)
    equations = mq.derive(mechanism, method="newton_euler")
    for q, v in states(mechanism):
        ours, theirs = equations.guide_forces(q, v), reference.guide_forces(q, v)
        assert ours.keys() == theirs.keys()
        for which, size in ours.items():
            np.testing.assert_allclose(size, theirs[which], rtol=1e-10, atol=1e-10)
        wrenches = reference.reactions(q, v)
        for joint, (force, moment) in equations.reactions(q, v).items():
            np.testing.assert_allclose(force, wrenches[joint].force, rtol=1e-10, atol=1e-9)
            np.testing.assert_allclose(moment, wrenches[joint].moment, rtol=1e-10, atol=1e-9)


@pytest.mark.parametrize("name", HELD)
def test_ideal_joints_transmit_nothing_along_their_axes(name: str) -> None:
    mechanism = mq.textbook.load(name)
    reference = mq.Reference(mechanism)
    for q, v in states(mechanism):
        poses = dict(zip((b.name for b in mechanism.bodies), reference.poses(q), strict=True))
        for joint in mechanism.joints:
            assert isinstance(joint, (mq.Revolute, mq.Prismatic))
            wrench = reference.reactions(q, v)[joint.name]
            axis = poses[joint.child][:3, :3] @ joint.axis
            along = wrench.moment if isinstance(joint, mq.Revolute) else wrench.force
            assert along @ axis == pytest.approx(0, abs=1e-9)


def test_the_parallelogram_has_the_reactions_of_the_loop() -> None:
    tree = mq.textbook.load("bars_and_springs")
    loop = mq.textbook.load("bars_and_springs_loop").replace(a=tree.values["a"])
    one, other = mq.Reference(tree), mq.Reference(loop)
    for q in (0.0, 0.4, -0.9):
        angle, speed = np.arcsin(q / 2), 0.7 / np.sqrt(4 - q * q)
        turned = np.array([angle, angle, -angle]), np.array([speed, speed, -speed])
        for name, wrench in other.reactions(*turned).items():
            if name != "F":
                mine = one.reactions([q], [0.7])[name]
                np.testing.assert_allclose(mine.force, wrench.force, rtol=1e-9, atol=1e-9)
                np.testing.assert_allclose(mine.moment, wrench.moment, rtol=0, atol=1e-12)


@pytest.mark.parametrize("name", ["bars_and_springs", "bars_and_springs_small"])
def test_small_motion_has_the_reactions_of_the_chapter(name: str) -> None:
    """Fundamentals of Dynamics, eq. Ex.1.2.h: A_y = -(3/16) m q'' - k q / 4, D_y = -m q'' / 2."""
    mechanism = mq.textbook.load(name)
    reference = mq.Reference(mechanism)
    m, k = mechanism.values["m"], mechanism.values["k"]
    q = 1e-6
    a = reference.acceleration([q])[0]
    wrenches = reference.reactions([q])
    assert wrenches["A"].force[2] == pytest.approx(-3 / 16 * m * a - k * q / 4, rel=1e-5)
    assert wrenches["D"].force[2] == pytest.approx(-m * a / 2, rel=1e-5)
    rod = 9 / 16 * m * a + k * q / 4
    assert wrenches["C"].force[2] == pytest.approx(rod, rel=1e-5)
    for joint in "ADC":
        np.testing.assert_allclose(wrenches[joint].force[:2], 0, rtol=0, atol=1e-9)
        np.testing.assert_allclose(wrenches[joint].moment, 0, rtol=0, atol=1e-14)


def test_a_moving_pulley_halves_the_pull() -> None:
    machine = mq.textbook.load("double_atwood_machine")
    forces = mq.Reference(machine).guide_forces([0.1, 0.2], [0.3, -0.4])
    assert forces["cord"] == pytest.approx(2 * forces["second"], rel=1e-12)


@pytest.mark.parametrize("name", HELD)
def test_bodies_are_in_balance_with_the_elements(name: str) -> None:
    mechanism = mq.textbook.load(name)
    reference = mq.Reference(mechanism)
    q, v = (np.array(part) for part in zip(*states(mechanism), strict=True))
    t = np.zeros(len(q))
    a = reference.acceleration(q, v, t)
    acting = Actions(mechanism, reference)
    every = [*acting.applied(t, q, v), *acting.reactions(t, q, v), *acting.inertia(t, q, v, a)]
    for body in mechanism.bodies[1:]:
        on_it = [action for action in every if action.body == body.name]
        np.testing.assert_allclose(sum(each.force for each in on_it), 0, rtol=0, atol=1e-12)
        moments = (each.moment + np.cross(each.origin, each.force) for each in on_it)
        np.testing.assert_allclose(sum(moments), 0, rtol=0, atol=1e-12)


@pytest.mark.parametrize("name", [*HELD, "planetary_gear", "rack_and_pinion"])
def test_what_an_element_does_to_one_body_it_undoes_to_the_other(name: str) -> None:
    mechanism = mq.textbook.load(name)
    q, v = next(states(mechanism))
    actions = mq.Reference(mechanism).guide_actions(q, v)
    for element in {action.name for action in actions}:
        parts = [action for action in actions if action.name == element]
        between = [(part.body, part.other) for part in parts]
        assert sorted(between) == sorted((other, body) for body, other in between)
        size = max(float(np.abs(part.force).max()) for part in parts)
        np.testing.assert_allclose(sum(part.force for part in parts), 0, rtol=0, atol=1e-14 * size)
        moments = (part.moment + np.cross(part.point, part.force) for part in parts)
        np.testing.assert_allclose(sum(moments), 0, rtol=0, atol=1e-14 * max(size, 1.0))
        assert size > 0


def test_urdf_keeps_the_cord_and_lint_says_who_reads_it(tmp_path: Path) -> None:
    machine = mq.textbook.load("atwood_machine")
    text = mq.write_urdf(machine)
    (cord,) = mq.read_urdf(text).elements
    assert isinstance(cord, Cord)
    assert cord.name == "cord"
    assert cord.over == (Pulley("pulley", 0.2, -1),)
    assert mq.write_urdf(mq.read_urdf(text)).count("<mecanique:cord") == 1
    again = mq.Reference(mq.read_urdf(text)).guide_forces([0.1])
    assert again["cord_1"] == pytest.approx(
        mq.Reference(machine).guide_forces([0.1])["cord_1"], rel=1e-12
    )
    assert "M610" in [finding.code for finding in mq.lint(text)]


@pytest.mark.parametrize(
    ("before", "after", "message"),
    [
        ('sense="-1"', 'sense="2"', "expected sense 1 or -1, got '2'"),
        ('grips="true"', 'grips="yes"', "expected grips true or false, got 'yes'"),
        ('<mecanique:end link="weight1"', '<mecanique:end link="w"', "'w' is no link"),
        ('normal="0 -1 0"', 'normal="0 -2 0"', "expected a normal of unit length"),
        ('<mecanique:end link="weight1" xyz="0 0 0"/>', "", "expected <mecanique:end>, any"),
    ],
)
def test_a_cord_that_cannot_be_read_is_reported(before: str, after: str, message: str) -> None:
    text = mq.write_urdf(mq.textbook.load("atwood_machine"))
    assert before in text
    findings = mq.lint(text.replace(before, after))
    assert any(message in finding.message for finding in findings)


def test_what_the_map_closes_is_a_loop_to_those_who_do_not_know_the_map() -> None:
    again = mq.read_urdf(mq.write_urdf(mq.textbook.load("bars_and_springs")))
    assert [loop.name for loop in again.loops] == ["F"]
    assert again.elements == ()


def test_wrong_elements_are_refused_with_place_and_remedy() -> None:
    machine = mq.textbook.load("atwood_machine")
    wheel = Pulley("pulley", 0.2, -1)
    with pytest.raises(MechanismError, match=r"element 'c': 'weight3' is no body"):
        replace(machine, elements=(Cord("c", ("weight1", HERE), (wheel,), ("weight3", HERE)),))
    with pytest.raises(InputError, match="expected sense 1 or -1, got 0"):
        Pulley("pulley", 0.2, 0)
    with pytest.raises(InputError, match=r"cord 'c': expected a normal of unit length"):
        Cord("c", ("weight1", HERE), (wheel,), ("weight2", HERE), (0, -2, 0))
    for wrong, message in (
        (Pulley("pulley", 0.1, -1), r"cord 'c' does not fit the coordinate map.*correct its"),
        (Pulley("pulley", 0.2, 1), r"cord 'c' does not fit the coordinate map"),
        (
            Pulley("pulley", 5.0, -1),
            r"cord 'c' has no straight run from 'weight1' to 'pulley'.*radii",
        ),
        (Pulley("pulley", 0.2, -1, center=(0, 1, 0)), r"cord 'c' leaves its plane"),
        (Pulley("pulley", 0.2, -1, center=(0, 0.3, 0)), r"cord 'c' leaves its plane"),
    ):
        held = replace(
            machine, elements=(Cord("c", ("weight1", HERE), (wrong,), ("weight2", HERE)),)
        )
        with pytest.raises(EngineError, match=message):
            mq.Reference(held)


def test_redundant_cords_leave_their_tensions_undetermined() -> None:
    machine = mq.textbook.load("double_atwood_machine")
    first, second = machine.elements
    twice = replace(machine, elements=(first, replace(first, name="twin"), second))
    reference = mq.Reference(twice)
    forces = reference.guide_forces([0.1, 0.1])
    assert np.isnan(forces["cord"])
    assert np.isnan(forces["twin"])
    assert np.isfinite(forces["second"])
    reactions = reference.reactions([0.1, 0.1])
    np.testing.assert_allclose(reactions["rail2"].force, 0, rtol=0, atol=1e-10)
    # they pull alike, however they share it
    assert {wrench.undetermined for wrench in reactions.values()} == {()}


def test_an_element_that_explains_a_part_leaves_the_rest_undetermined() -> None:
    machine = mq.textbook.load("double_atwood_machine")
    half = replace(machine, elements=machine.elements[:1])
    reference = mq.Reference(half)
    assert set(reference.guided) == {"rail2", "rail3"}
    whole = mq.Reference(machine).guide_forces([0.1, 0.1])["cord"]
    assert reference.guide_forces([0.1, 0.1])["cord"] == pytest.approx(whole, rel=1e-12)
    assert np.isnan(reference.reactions([0.1, 0.1])["rail2"].force).any()
    assert mq.derive(half, method="newton_euler").guide_forces([0.1, 0.1])["cord"] == pytest.approx(
        whole, rel=1e-12
    )


def test_the_page_draws_the_cord_and_its_tensions(tmp_path: Path) -> None:
    motion = mq.simulate(mq.textbook.load("atwood_machine"), q={"x": -0.5}, duration=0.3)
    scene = scene_of(motion)
    names = [arrow.name for arrow in scene.arrows]
    assert {"cord_1 on weight1", "cord_1 on pulley", "axle on pulley"} <= {*names}
    assert [line.name for line in scene.lines if line.name.startswith("stretch")] == [
        "stretch 1",
        "stretch 2",
    ]
    assert {"cord_1", "cord_2"} <= {series.name for series in scene.series}
    mq.picture(motion, 0.0, tmp_path / "pulley.svg", free_body="pulley", numbers=True)
    drawing = (tmp_path / "pulley.svg").read_text(encoding="utf-8")
    assert "undetermined" not in drawing
    assert " = 10.8 N" in drawing


def test_slack_is_told() -> None:
    """A weight that is pushed up faster than it falls does not hang on its cord."""
    machine = mq.textbook.load("atwood_machine")
    pushed = replace(machine, forces=(mq.Force("push", "weight2", (0, 0, 0), (0, 0, 60.0)),))
    audit = mq.simulate(pushed, q={"x": 0.0}, duration=0.1).audit()
    assert not audit["push of cord_2, slack"].ok
    assert not audit.ok
    taut = mq.simulate(machine, q={"x": 0.0}, duration=0.1).audit()
    assert taut["push of cord_2, slack"].ok


def test_cords_turn_with_the_earth_and_go_with_the_mimic_joints() -> None:
    machine = mq.textbook.load("atwood_machine")
    motion = mq.simulate(machine, q={"x": -0.3}, duration=0.2)
    check = mq.inertial_check(machine, motion, 0.8)
    assert {row.name for row in check.rows} >= {"force in axle"}
    free = machine.without_mimic()
    assert free.elements == ()
    assert mq.Reference(free).guided == {}
    (cord,) = machine.elements
    assert isinstance(cord, Cord)
    turned = replace(machine, elements=(replace(cord, axes="ground"),))
    text = mq.write_urdf(turned)
    assert 'axes="ground"' in text
    assert mq.read_urdf(text).elements[0] == replace(
        cord, axes="ground", over=(Pulley("pulley", 0.2, -1),)
    )
    forces = mq.derive(turned, method="newton_euler").guide_forces([0.1])
    assert forces["cord_1"] == pytest.approx(
        mq.Reference(turned).guide_forces([0.1])["cord_1"], rel=1e-12
    )


def winch(*, wound: bool = True) -> mq.Mechanism:
    """Return a weight that a cord lifts over a pulley onto a drum that a motor turns."""
    m, J, R, D, g = (
        mq.Parameter(name, value)
        for name, value in (("m", 2.0), ("J", 0.3), ("R", 0.1), ("D", 5.0), ("g", 9.81))
    )
    drum = mq.Shape(1.0, inertia=(J, J, J, 0, 0, 0))
    wheels = (Pulley("ground", R, -1, (0, 0, 1), grips=False), Pulley("drum", R, -1))
    return mq.Mechanism(
        "winch",
        (mq.Body("ground"), mq.Body("weight", mq.particle(m)), mq.Body("drum", drum)),
        (
            mq.Prismatic(
                "rise", "ground", "weight", origin=mq.Placement((-R, 0, 0)), axis=(0, 0, 1)
            ),
            mq.Revolute("axle", "ground", "drum", origin=mq.Placement((2, 0, 0.4)), axis=(0, 1, 0)),
        ),
        forces=(mq.JointForce("motor", "axle", D),),
        elements=(Cord("rope", ("weight", HERE), wheels),) if wound else (),
        parameters=(m, J, R, D, g),
        gravity=(0, 0, -g),
    )


def test_a_cord_that_is_wound_on_a_drum_turns_it_and_has_one_tension() -> None:
    """By hand: (m + J/R²) a = D/R - m g, T = m (g + a)."""
    mechanism = winch()
    (law,) = mechanism.coordinates.driven.items()
    assert law == ("axle", mq.coordinate("rise") / mq.Parameter("R", 0.1))
    a = (5.0 / 0.1 - 2.0 * 9.81) / (2.0 + 0.3 / 0.01)
    reference = mq.Reference(mechanism)
    assert reference.acceleration([0.0])[0] == pytest.approx(a, rel=1e-13)
    forces = reference.guide_forces([0.2], t=0.0)
    assert forces.keys() == {"rope"}
    assert float(forces["rope"]) == pytest.approx(2.0 * (9.81 + a), rel=1e-13)
    assert mq.verify(mechanism, samples=10).agrees
    steps = mq.derive(mechanism, "newton_euler").text(steps=True)
    assert "T_rope = m rise'' + m g" in steps


def test_a_cord_that_is_wound_on_a_drum_is_written_and_read() -> None:
    text = mq.write_urdf(winch())
    assert text.count("<mecanique:end") == 1
    again = mq.read_urdf(text)
    (rope,) = again.elements
    assert isinstance(rope, Cord)
    assert rope.end is None
    assert [wheel.body for wheel in rope.over] == ["ground", "drum"]
    assert mq.write_urdf(again).count("<mecanique:end") == 1
    slips = text.replace('grips="true"', 'grips="false"')
    assert any("that it is wound on and turns" in finding.message for finding in mq.lint(slips))


def test_a_cord_without_an_end_needs_a_drum() -> None:
    for over in ((), (Pulley("pulley", 0.2, grips=False),)):
        with pytest.raises(
            InputError, match=r"cord 'c': expected a last pulley that it is wound on"
        ):
            Cord("c", ("weight1", HERE), over)
