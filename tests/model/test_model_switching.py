"""What elements that switch say of themselves: rows, coefficients, states, and what they ask."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

import mecanique as mq
from mecanique.errors import InputError, MechanismError
from mecanique.model.constraint_base import JointRow, list_cord_runs
from mecanique.model.expression import evaluate
from mecanique.model.mechanism.homogeneity import hides_units
from mecanique.model.placement import pose_of

mu, at = mq.Parameter("mu", 0.3), mq.Parameter("a", 0.7, "m")
F, w = mq.Parameter("F", 1.0, "N"), mq.Parameter("w", 2.0, "rad/s")
BODIES = mq.Body("ground"), mq.Body("block", mq.particle(2.0)), mq.Body("free", mq.particle(1.0))
JOINTS = (
    mq.Prismatic("slide", "ground", "block", axis=(1, 0, 0), coordinate="x"),
    mq.Floating("loose", "ground", "free"),
)
NAMES = tuple(name for joint in JOINTS for name in joint.coordinates)


def block(**given: Any) -> mq.Mechanism:
    return mq.Mechanism("block", BODIES, JOINTS, parameters=(mu, at, F, w), **given)


def test_friction_is_its_coefficient_times_its_load() -> None:
    dry = mq.Friction("dry", "slide", mu, 5.0, mu_static=0.4, speed=0.2)
    assert [evaluate(x, {"mu": 0.3}) for x in dry.coefficients] == [1.5, 2.0]
    assert dry.joint_rows == (JointRow("R", (("slide", 1.0),), speed=0.2),)
    pressed = mq.Friction("dry", "slide", mu, "floor")
    assert [evaluate(x, {"mu": 0.3}) for x in pressed.coefficients] == [0.3, 0.3]
    units = {its.units for its in pressed.stated}
    assert ("1", "m") in units  # the lever of resistance to rolling
    assert ("1",) not in units
    assert ("1",) in {its.units for its in dry.stated}
    assert list_cord_runs(dry) == ()


@pytest.mark.parametrize("side", [1, -1])
def test_a_stop_leaves_what_is_on_its_side(side: int) -> None:
    """The gap is a − x at an upper stop, x − a at a lower one."""
    stop = mq.Stop("stop", "slide", at, side)
    (row,) = stop.joint_rows
    assert row.letter == "N"
    assert row.weights == (("slide", -side),)
    assert evaluate(row.offset, {"a": 0.7}) == side * 0.7
    assert list_cord_runs(stop) == ()


def test_stops_that_cannot_be_are_refused() -> None:
    with pytest.raises(InputError, match="stop 's': expected side 1 or -1, got 0"):
        mq.Stop("s", "slide", 0.0, 0)
    with pytest.raises(InputError, match="expected a stiffness or what it holds, got both"):
        mq.Stop("s", "slide", 0.0, stiffness=10.0, holds=1.0)
    assert mq.Stop("s", "slide", stiffness=10.0).holds == 0
    with pytest.raises(MechanismError, match="expected a pull that it holds of at least 0, got -2"):
        block(switching=(mq.Stop("s", "slide", holds=-2.0),))


def test_a_capstan_has_its_slack_and_half_the_difference_of_its_ends() -> None:
    """2 tanh(μ φ/2) = 2 (e^(μ φ) − 1)/(e^(μ φ) + 1): T₁ = e^(μ φ) T₂ where it slips."""
    cord = mq.Capstan("c", "in", "out", length=3.0, wrap=2.0, mu=0.3, mu_static=0.5, speed=0.1)
    slack, rub = cord.joint_rows
    assert slack == JointRow("N", (("in", -1.0), ("out", -1.0)), 3.0)
    assert rub == JointRow("R", (("in", 0.5), ("out", -0.5)), speed=0.1)
    assert list_cord_runs(cord) == ("in", "out")
    for coefficient, ratio in zip(cord.coefficients, (0.6, 1.0), strict=True):
        half = evaluate(coefficient, {}) / 2
        assert (1 + half) / (1 - half) == pytest.approx(2.718281828459045**ratio, rel=1e-14)


def test_a_contact_rubs_if_it_has_a_coefficient_and_ends_if_it_has_a_length() -> None:
    for given, rubs, ends in (
        ({}, False, False),
        ({"mu": 0.3}, True, False),
        ({"mu": 0.0, "mu_static": 0.4}, True, False),
        ({"mu": mu, "length": 2.0}, True, True),
        ({"length": at}, False, True),
    ):
        contact = mq.Contact("c", "free", **given)
        assert (contact.rubs, contact.ends) == (rubs, ends)
        assert contact.states == (("open", "sticks", "slips") if rubs else ("open", "closed"))
    assert mq.Contact("c", "free", mu=0.3).coefficients == (0.3, 0.3)
    assert mq.Contact("c", "free", mu=0.3, mu_static=0.4, law="poisson").coefficients == (0.3, 0.4)
    with pytest.raises(InputError, match="expected a law 'newton' or 'poisson', got 'hooke'"):
        mq.Contact("c", "free", law="hooke")  # type: ignore[arg-type]
    with pytest.raises(InputError, match="expected a length of a plane's side, not of a bowl"):
        mq.Contact("c", "free", bowl=2.0, length=1.0)


def test_what_presses_is_a_contact_or_a_stop() -> None:
    floor, dry = mq.Contact("floor", "free"), mq.Friction("dry", "slide", mu, "floor")
    assert block(switching=(floor, dry)).switching[1].pressed_by == "floor"
    assert block(switching=(replace(dry, load=5.0),)).switching[0].pressed_by is None
    for others in ((), (mq.Friction("floor", "slide", mu, 1.0),)):
        with pytest.raises(MechanismError, match="'floor', its load, is no contact or stop"):
            block(switching=(*others, dry))


def test_contacts_may_slip_if_their_friction_is_given() -> None:
    assert mq.Rolling("rim", "free", 0.1).breaks == ("rim would pull",)
    rough = mq.Rolling("rim", "free", 0.1, friction=0.3)
    assert rough.breaks == ("rim would pull", "rim would slip")


def test_a_hinge_of_a_loop_has_a_frame_on_each_body() -> None:
    loop = mq.Loop.hinge("pin", "block", (1, 2, 3), "free", (4, 5, 6), (0, 0, 1), (1, 0, 0))
    (a, b), along = (loop.frame_a, loop.frame_b), (0, 0, 1)
    assert (loop.body_a, a.xyz, loop.body_b, b.xyz) == ("block", (1, 2, 3), "free", (4, 5, 6))
    assert pose_of(a)[:3, :3] @ along == pytest.approx([0, 0, 1], abs=1e-15)
    assert pose_of(b)[:3, :3] @ along == pytest.approx([1, 0, 0], abs=1e-15)


def test_a_joint_with_one_coordinate_takes_the_last_of_the_names() -> None:
    assert JOINTS[0].renamed(("a", "b")).coordinate == "b"


def test_potentials_depend_on_their_joints_time_and_parameters_alone() -> None:
    x = mq.coordinate("x")

    def well(potential: Any) -> mq.Mechanism:
        return block(forces=(mq.Potential("V", "slide", potential),))

    assert well(F * x**2 / at + F * x * mq.sin(w * mq.time())).nv == 7
    assert well(mq.sign(at) * F * x**2 / at).nv == 7
    alone = "its potential is to depend on 'x', time and parameters alone, got \"x'\""
    with pytest.raises(MechanismError, match=alone):
        well(F * x * mq.velocity("x") / w / at)
    with pytest.raises(MechanismError, match="whose slope at zero is no force"):
        well(F * x * mq.sign(x))


def test_numbers_hide_units_where_time_needs_them() -> None:
    """In cos(2 t) the 2 is a frequency; in F cos(w t) nothing is hidden."""
    for law, hidden in (
        (F * mq.cos(w * mq.time()), False),
        (F * mq.cos(2 * mq.time()), True),
        (F * mq.cos(2 * mq.coordinate("x") / at), False),
    ):
        assert hides_units(block(forces=(mq.JointForce("drive", "slide", law),))) == hidden
    assert hides_units(mq.Mechanism("m", BODIES, JOINTS))
