"""Copies of a mechanism in which something is changed, and nothing else."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import mecanique as mq

ACROSS = (0.0, -1.0, 0.0)
ORIGIN = mq.Placement((0.1, 0.2, 0.3), (0.4, 0.5, 0.6))
ARM = mq.Mechanism(
    "arm",
    (mq.Body("ground"), *(mq.Body(name, mq.rod(1.0, 0.4)) for name in ("upper", "lower", "tip"))),
    (
        mq.Revolute(
            "shoulder",
            "ground",
            "upper",
            axis=ACROSS,
            origin=ORIGIN,
            limits=mq.Limits(-1, 1, 20.0, 3.0),
        ),
        mq.Prismatic("reach", "upper", "lower", axis=(0, 0, 1)),
        mq.Universal("wrist", "lower", "tip"),
    ),
    forces=(
        mq.JointDamper("one", "reach", 1.0),
        mq.JointSpring("spring", "shoulder", 2.0),
        mq.JointDamper("oil", "shoulder", 3.0),
        mq.JointDamper("more", "shoulder", 4.0),
    ),
)


def test_a_joint_stands_elsewhere_or_has_other_bounds() -> None:
    moved = ARM.with_joint("shoulder", origin=(7, 8, 9)).joint("shoulder")
    assert moved.origin == mq.Placement((7.0, 8.0, 9.0), ORIGIN.rpy)
    placed = mq.Placement((1, 2, 3))
    changed = ARM.with_joint(
        "shoulder", origin=placed, axis=(0, 0, 2), limits=(-2, 5), armature=0.1
    )
    hinge = changed.joint("shoulder")
    assert isinstance(hinge, mq.Revolute)
    assert (hinge.origin, hinge.axis, hinge.armature) == (placed, (0, 0, 1), 0.1)
    assert hinge.limits == mq.Limits(-2.0, 5.0, 20.0, 3.0)
    assert changed.joints[1:] == ARM.joints[1:]
    assert changed.forces == ARM.forces
    slide = ARM.with_joint("reach", limits=(0, 1)).joint("reach")
    assert isinstance(slide, mq.Prismatic)
    assert slide.limits == mq.Limits(0.0, 1.0)
    inertia = mq.Parameter("J", 0.2, "kg·m²")
    assert ARM.with_joint("shoulder", armature=inertia).parameters == (inertia,)


def test_a_joint_has_one_damper_where_its_first_one_stood() -> None:
    c = mq.Parameter("c", 5.0)
    one, spring, *_ = ARM.forces
    damped = ARM.with_joint("shoulder", damping=c)
    assert damped.forces == (one, spring, mq.JointDamper("oil", "shoulder", c))
    assert damped.parameters == (c,)
    assert ARM.with_joint("shoulder", damping=0).forces == (one, spring)
    bare = replace(ARM, forces=(mq.JointSpring("reach_damper", "shoulder", 2.0),))
    assert [force.name for force in bare.with_joint("reach", damping=2).forces] == [
        "reach_damper",
        "reach_damper_",
    ]


@pytest.mark.parametrize(
    ("name", "given", "message"),
    [
        ("wrist", {"damping": 1.0}, "one coordinate for damping, but 'wrist' is Universal"),
        ("wrist", {"axis": (0, 0, 1)}, "expected a joint with an axis, but 'wrist' is Universal"),
        ("reach", {"limits": (1, 2, 3)}, r"expected Limits or \(lower, upper\) for joint 'reach'"),
        ("reach", {"damping": -1.0}, "force 'one': expected a damping of at least 0, got -1"),
        ("elbow", {}, "unknown joint 'elbow'"),
    ],
)
def test_what_a_joint_cannot_have_is_refused(
    name: str, given: dict[str, Any], message: str
) -> None:
    with pytest.raises(mq.MecaniqueError, match=message):
        ARM.with_joint(name, **given)


def test_a_body_has_another_mass_center_or_inertia() -> None:
    m = mq.Parameter("m", 3.0, "kg")
    heavy = ARM.with_body("lower", mass=m)
    assert heavy.parameters == (m,)
    assert heavy.evaluate(heavy.body("lower").mass) == 3.0
    assert heavy.body("lower").inertia == ARM.body("lower").inertia
    assert heavy.body("upper") == ARM.body("upper")
    other = ARM.with_body("tip", center=np.array([1.0, 2, 3]), inertia=(1, 1, 1, 0, 0, 0)).body(
        "tip"
    )
    assert (other.mass, other.center, other.inertia) == (1.0, (1, 2, 3), (1, 1, 1, 0, 0, 0))
    with pytest.raises(mq.InputError, match="expected a mass above 0 for body 'tip', got 0"):
        ARM.with_body("tip", mass=0.0)


def test_gravity_is_a_direction_or_a_parameter_of_this_name() -> None:
    assert ARM.replace(gravity=(1, 2, 3)).gravity == (1, 2, 3)
    fall = mq.Parameter("fall", -9.81, "m/s²")
    assert ARM.replace(gravity=(0, 0, fall)).values == {"fall": -9.81}
    letter = mq.Parameter("gravity", 9.81, "m/s²")
    named = replace(ARM, gravity=(0, 0, -letter), parameters=(letter,))
    assert named.replace(gravity=1.62).values == {"gravity": 1.62}
    assert named.replace(gravity=1.62).gravity == named.gravity


def linkage() -> mq.Mechanism:
    """Hinges along ±y in turned frames, with a slide between them, and one that branches off."""
    frame = mq.Placement((0.3, 0, 0), (0.5, -0.2, 0.7))
    x, y, z = frame.rotation[1]
    across, back = (x, y, z), (-x, -y, -z)
    names = ("a", "b", "c", "d", "e")
    return mq.Mechanism(
        "linkage",
        (mq.Body("ground"), *(mq.Body(name, mq.rod(1.0, 0.4)) for name in names)),
        (
            mq.Revolute("A", "ground", "a", axis=(0, 1, 0)),
            mq.Revolute("B", "a", "b", axis=back, origin=frame),
            mq.Prismatic("S", "b", "c", axis=(1, 0, 0)),
            mq.Revolute("C", "c", "d", axis=across),
            mq.Revolute("E", "b", "e", axis=(1, 0, 0)),
        ),
    )


def test_absolute_angles_are_those_of_the_bodies() -> None:
    """The sum of parallel hinges' angles, each with its sense, from the ground on."""
    mechanism = linkage()
    turned = mechanism.with_absolute_angles({"B": "beta", "C": "gamma"})
    assert list(turned.coordinates) == ["A", "beta", "S", "gamma", "E"]
    q = {"A": 0.4, "B": 1.1, "S": 0.2, "C": -0.7, "E": 0.3}
    # B turns about −y: its angle counts against A's, and C's against B's
    absolute = {"A": 0.4, "beta": 1.1 - 0.4, "S": 0.2, "gamma": -0.7 - (1.1 - 0.4), "E": 0.3}
    mine, theirs = mq.Reference(turned).poses(absolute), mq.Reference(mechanism).poses(q)
    np.testing.assert_allclose(mine, theirs, rtol=0, atol=1e-12)
    again = turned.with_absolute_angles({"A": "alpha"})
    absolute["alpha"] = absolute.pop("A")
    np.testing.assert_allclose(mq.Reference(again).poses(absolute), theirs, rtol=0, atol=1e-12)


@pytest.mark.parametrize(
    ("letters", "message"),
    [
        ({"S": "s"}, r"expected a coordinate of a hinge \(A, B, C, E\), got 'S'"),
        ({"E": "eta"}, "'E' has no absolute angle: a hinge between its body and the ground is not"),
    ],
)
def test_angles_that_are_not_absolute_are_refused(letters: dict[str, str], message: str) -> None:
    with pytest.raises(mq.InputError, match=message):
        linkage().with_absolute_angles(letters)


def test_joints_that_follow_others_are_freed() -> None:
    x, time = mq.coordinate("S"), mq.time()
    tied = replace(
        linkage(), coordinates=mq.Coordinates((), {"C": 2 * x, "E": 0.3, "A": 0.1 * time})
    )
    free = tied.without_mimic()
    assert free.coordinates.driven == {"A": 0.1 * time}
    assert list(free.coordinates) == ["B", "S", "C", "E"]
    # in the order of the joints again, or in that which was chosen
    late = replace(linkage(), coordinates=mq.Coordinates((), {"B": 2 * mq.coordinate("C")}))
    assert list(late.without_mimic().coordinates) == ["A", "B", "S", "C", "E"]
    chosen = replace(linkage(), coordinates=mq.Coordinates(("E", "A"), {"B": 2 * x}))
    assert list(chosen.without_mimic().coordinates) == ["E", "A", "S", "C", "B"]
    machine = mq.textbook.load("planetary_gear")
    loose = machine.without_mimic()
    assert loose.elements == ()
    assert set(loose.coordinates) == {"sun", "arm", "planet", "ring"}
    screw = mq.textbook.load("screw_press")
    assert "theta_travel" in screw.without_mimic().coordinates.driven
