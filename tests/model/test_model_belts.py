"""Belts: the tension in each run, open and crossed, over two pulleys and more."""

from __future__ import annotations

from dataclasses import replace
from math import hypot, pi, sqrt
from pathlib import Path

import numpy as np
import pytest

import mecanique as mq
from mecanique.model.constraints.elements import force_names, preloads
from mecanique.viewing.scene.from_motion import scene_of

ACROSS, FLAT = (0.0, -1.0, 0.0), (pi / 2, 0.0, 0.0)
SMALL, BIG, APART = 0.1, 0.3, 1.0
DRIVE, PRELOAD = 2.0, 50.0


def drive(
    *,
    crossed: bool = False,
    preload: float | None = PRELOAD,
    apart: float = APART,
    torque: float = DRIVE,
) -> mq.Mechanism:
    """A driven small pulley that turns a big one."""
    wheels = {"motor": (1.0, SMALL, 0.0), "drum": (4.0, BIG, apart)}
    sense = -1 if crossed else 1
    return mq.Mechanism(
        "drive",
        (
            mq.Body("ground"),
            *(mq.Body(name, mq.disk(m, r).at(rpy=FLAT)) for name, (m, r, _) in wheels.items()),
        ),
        tuple(
            mq.Revolute(f"{name}_axle", "ground", name, axis=ACROSS, origin=mq.Placement((x, 0, 0)))
            for name, (_, _, x) in wheels.items()
        ),
        forces=(mq.JointForce("torque", "motor_axle", torque),),
        elements=(
            mq.Belt("belt", (mq.Pulley("motor", SMALL), mq.Pulley("drum", BIG, sense)), preload),
        ),
        gravity=(0, 0, 0),
    )


def triangle() -> mq.Mechanism:
    """A belt around three pulleys, the last one outside of it."""
    places = {"a": (0.0, 0.0), "b": (1.0, 0.0), "c": (0.5, 0.6)}
    return mq.Mechanism(
        "triangle",
        (
            mq.Body("ground"),
            *(mq.Body(name, mq.disk(1.0 + k, 0.1).at(rpy=FLAT)) for k, name in enumerate(places)),
        ),
        tuple(
            mq.Revolute(f"{name}_axle", "ground", name, axis=ACROSS, origin=mq.Placement((x, 0, z)))
            for name, (x, z) in places.items()
        ),
        forces=(mq.JointForce("torque", "a_axle", 0.5),),
        elements=(
            mq.Belt(
                "belt",
                (mq.Pulley("a", 0.1), mq.Pulley("b", 0.1), mq.Pulley("c", 0.1, -1)),
                20.0,
            ),
        ),
    )


@pytest.mark.parametrize("crossed", [False, True])
def test_a_belt_on_a_tilted_bench_turns_its_pulleys_in_the_axes_of_that(crossed: bool) -> None:
    """All wheels stand on a bench that is fixed in a tilt; the normal is in the bench's axes."""
    flat = drive(crossed=crossed)
    tilt = mq.Placement((0.1, 0.2, 0.3), (0.3, 0.2, 0.1))
    (belt,) = flat.elements
    assert isinstance(belt, mq.Belt)
    tilted = replace(
        flat,
        bodies=(*flat.bodies, mq.Body("bench")),
        joints=(
            mq.Fixed("mount", "ground", "bench", origin=tilt),
            *(replace(axle, parent="bench") for axle in flat.joints),
        ),
        coordinates=mq.Coordinates(()),
        elements=(replace(belt, axes="bench"),),
    )
    assert tilted.coordinates.driven == flat.coordinates.driven
    assert mq.verify(tilted, samples=5).agrees
    at = {"motor_axle": 0.3}
    tensions = mq.Reference(flat).guide_forces(at)
    for name, tension in mq.Reference(tilted).guide_forces(at).items():
        assert tension == pytest.approx(float(tensions[name]), rel=1e-12)


def test_no_law_follows_for_a_belt_whose_plane_turns() -> None:
    """Its normal is in the axes of a wheel, though that turns about the normal."""
    flat = drive()
    (belt,) = flat.elements
    assert isinstance(belt, mq.Belt)
    turned = replace(flat, coordinates=mq.Coordinates(()), elements=(replace(belt, axes="motor"),))
    assert flat.coordinates.driven.keys() == {"drum_axle"}
    assert not turned.coordinates.driven


@pytest.mark.parametrize("crossed", [False, True])
def test_a_drive_by_hand(crossed: bool) -> None:
    """J a = D - r (T1 - T2), the mean of both the preload; along the runs they pull the axles."""
    machine = drive(crossed=crossed)
    assert tuple(machine.coordinates) == ("motor_axle",)
    small, big = 1.0 * SMALL**2 / 2, 4.0 * BIG**2 / 2
    ratio = SMALL / BIG
    a = DRIVE / (small + big * ratio**2)
    reference, equations = mq.Reference(machine), mq.derive(machine, method="newton_euler")
    assert reference.acceleration([0.4])[0] == pytest.approx(a, rel=1e-13)
    pull = big * ratio * a / BIG
    slope = (BIG + (SMALL if crossed else -SMALL)) / APART
    for forces in (reference.guide_forces([0.4]), equations.guide_forces([0.4])):
        tensions = sorted(forces.values())
        assert tensions == pytest.approx([PRELOAD - pull / 2, PRELOAD + pull / 2], rel=1e-12)
    for reactions in (reference.reactions([0.4]), equations.reactions([0.4], None)):
        force = reactions["drum_axle"].force
        assert force[0] == pytest.approx(2 * PRELOAD * sqrt(1 - slope**2), rel=1e-12)
        # open, its runs lean to both sides of the center line; crossed, they do as well
        assert abs(force[2]) == pytest.approx(pull * slope, rel=1e-11)
        np.testing.assert_allclose(reactions["motor_axle"].force, -force, rtol=0, atol=1e-12)
        np.testing.assert_allclose(reactions["drum_axle"].moment, 0, rtol=0, atol=1e-12)
    sign = -1 if crossed else 1
    turned = machine.coordinates.driven["drum_axle"]
    assert float(turned.subs({"motor_axle": 1.0})) == pytest.approx(sign * ratio, rel=1e-12)


@pytest.mark.parametrize("machine", [drive(), drive(crossed=True), triangle()])
def test_verdicts_and_urdf(machine: mq.Mechanism) -> None:
    verdict = mq.verify(machine, samples=5)
    assert verdict.agrees, str(verdict)
    text = mq.write_urdf(machine)
    assert "<mecanique:belt" in text
    assert {finding.code for finding in mq.lint(text)} <= {"M107", "M201"} | {
        finding.code for finding in mq.lint(mq.write_urdf(mq.textbook.load("atwood_machine")))
    }
    again = mq.read_urdf(text)
    assert again.elements == machine.elements
    assert again.coordinates.driven.keys() == machine.coordinates.driven.keys()
    masses = [mq.Reference(each).mass_matrix([0.3]) for each in (machine, again)]
    assert float(masses[0][0, 0]) == pytest.approx(float(masses[1][0, 0]), rel=1e-14)


def test_a_third_pulley_turns_the_other_way() -> None:
    machine = triangle()
    laws = machine.coordinates.driven
    one = {"a_axle": 1.0}
    assert [float(laws[name].subs(one)) for name in ("b_axle", "c_axle")] == [1.0, -1.0]
    tensions = [float(each) for each in mq.Reference(machine).guide_forces([0.2]).values()]
    assert max(tensions) > 20.1
    assert np.mean(tensions) == pytest.approx(20.0, rel=1e-12)
    ours = mq.derive(machine, method="newton_euler").guide_forces([0.2])
    assert [float(each) for each in ours.values()] == pytest.approx(tensions, rel=1e-11)
    assert len({round(each, 6) for each in tensions}) == 3


def test_tensions_in_letters() -> None:
    machine = replace(drive(), coordinates=mq.Coordinates(("drum_axle",)))
    text = mq.derive(machine, method="newton_euler").text(steps=True)
    assert "tension of the belt from the motor to the drum [N]" in text
    lines = [line.strip() for line in text.splitlines()]
    assert any(line.startswith("T_belt_1 = 50 ") for line in lines), text


def test_without_a_preload_the_tensions_are_undetermined() -> None:
    reference = mq.Reference(drive(preload=None))
    assert np.isnan(list(reference.guide_forces([0.1]).values())).all()
    assert reference.acceleration([0.1])[0] == pytest.approx(
        mq.Reference(drive()).acceleration([0.1])[0], rel=1e-14
    )


def test_a_belt_without_enough_preload_is_slack() -> None:
    motion = mq.simulate(drive(preload=1.0), q={"motor_axle": 0.0}, duration=0.1)
    assert any(event.name.startswith("belt_") for event in motion.events), motion.events
    taut = mq.simulate(drive(), q={"motor_axle": 0.0}, duration=0.1)
    assert not taut.events


def test_runs_are_drawn(tmp_path: Path) -> None:
    motion = mq.simulate(drive(), q={"motor_axle": 0.0}, duration=0.1)
    lines = [line for line in scene_of(motion).lines if line.name.startswith("stretch")]
    lengths = [hypot(*(line.points[0, 1] - line.points[0, 0])) for line in lines]
    assert lengths == pytest.approx([sqrt(APART**2 - (BIG - SMALL) ** 2)] * 2, rel=1e-12)
    mq.picture(motion, 0.0, tmp_path / "drive.svg")
    assert "svg" in (tmp_path / "drive.svg").read_text(encoding="utf-8")


def test_pulleys_may_come_close() -> None:
    """A big one and a small one, nearer than two big ones could be."""
    tensions = mq.Reference(drive(apart=1.01 * (SMALL + BIG))).guide_forces([0.0])
    tight, slack = tensions.values()
    assert tight + slack == pytest.approx(2 * PRELOAD, rel=1e-12)
    assert abs(tight - slack) > 1


def test_wrong_belts_are_refused_with_place_and_remedy() -> None:
    with pytest.raises(mq.EngineError, match=r"belt 'belt': the pulleys on 'motor' and 'drum' ov"):
        mq.Reference(drive(apart=0.35))
    with pytest.raises(mq.InputError, match="belt 'b': expected two pulleys or more"):
        mq.Belt("b", (mq.Pulley("motor", 0.1),))
    with pytest.raises(mq.InputError, match="grips=True"):
        mq.Belt("b", (mq.Pulley("motor", 0.1), mq.Pulley("drum", 0.1, grips=False)))
    with pytest.raises(mq.InputError, match="belt 'b': expected a normal of unit length"):
        mq.Belt("b", (mq.Pulley("m", 0.1), mq.Pulley("d", 0.1)), normal=(0, 2, 0))


@pytest.mark.parametrize(
    ("before", "after", "message"),
    [
        ('preload="50"', 'preload="tight"', "number for preload"),
        ('sense="1"', 'sense="2"', "expected sense 1 or -1"),
        (
            '<mecanique:pulley link="motor"',
            '<mecanique:pulley link="nobody"',
            "'nobody' is no link",
        ),
        ('<mecanique:pulley link="motor"', '<mecanique:end link="motor"', "pulley> only"),
    ],
)
def test_a_belt_that_cannot_be_read_is_reported(before: str, after: str, message: str) -> None:
    text = mq.write_urdf(drive())
    assert before in text
    found = mq.lint(text.replace(before, after, 1))
    assert any(message in str(finding) for finding in found), [str(each) for each in found]


def test_the_preloads_of_several_belts_stand_each_beside_its_own_forces() -> None:
    """Of each belt the sum of its tensions is their number times the preload."""
    wheels = mq.Pulley("a", 0.1), mq.Pulley("b", 0.2)
    first, second, third = (mq.Belt(f"{n} N", wheels, preload=n) for n in (3, 5, 7))
    slack = mq.Belt("slack", wheels)
    stated = preloads((first, slack, second, third))
    assert [list(one.forces) for one in stated] == [[0, 1], [4, 5], [6, 7]]
    assert [one.total for one in stated] == [6, 10, 14]
    assert len(force_names((first, slack, second, third))) == 8
