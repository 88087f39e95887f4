"""Mistakes put in on purpose are named first; what cannot be told apart is said."""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import pytest
from verification_injections import (
    INJECTIONS,
    Array,
    Theirs,
    parts,
    seen,
    steiner,
    told_by,
    with_body,
    with_joint,
)

import mecanique as mq
from mecanique.derivation.numeric.recursion import Recursion
from mecanique.model.placement import rpy_rotation
from mecanique.model.states import States
from mecanique.verification import compare as sources
from mecanique.verification.causes.evidence import (
    Amount,
    Evidence,
    Hypothesis,
    deviations,
    say_turn,
    turn_about,
)
from mecanique.verification.causes.joints import (
    frame_changes,
    gravity_changes,
    joint_changes,
    placement_changes,
    state_changes,
)
from mecanique.verification.causes.links import (
    LinkEffect,
    fit_inertias,
    link_changes,
    principal_turn,
)
from mecanique.verification.causes.search import causes_of
from mecanique.verification.compare import ClosedForm
from mecanique.verification.rows import moving_mass
from mecanique.verification.states import random_states
from mecanique.verification.verdict import LikelyCause

IN_HOUSE = sources.derive_all
MODELS = {
    "two_link_arm": lambda: mq.textbook.load("two_link_arm"),
    "panda": lambda: mq.read_urdf(mq.robot("panda")),
    "z1": lambda: mq.read_urdf(mq.robot("z1")),
    "bolt": lambda: mq.read_urdf(mq.robot("bolt"), root="floating"),
}


PAIRS = [
    ("two_link_arm", kind)
    for kind in ("armature", "damping", "friction", "gravity sign", "joint order")
]
PAIRS += [
    (model, kind)
    for model in ("panda", "bolt")
    for kind in INJECTIONS
    if (model, kind) != ("bolt", "mimic")
]


@pytest.mark.parametrize(("model", "kind"), PAIRS)
def test_a_mistake_is_named_first_or_said_to_be_alike(model: str, kind: str) -> None:
    mechanism = MODELS[model]()
    for injection in INJECTIONS[kind](mechanism, np.random.default_rng(5)):
        found = seen(injection, 1)
        if found is None:
            continue
        causes = causes_of(injection.ours, *found)
        assert causes
        assert causes[0].removes
        assert causes[0].before > 10 * causes[0].after
        named = [(cause.kind, cause.where) for cause in (causes[0], *causes[0].alike)]
        assert (injection.kind, injection.where) in named
        return
    pytest.fail("the mistake could not be made")


def test_without_a_difference_there_is_no_cause() -> None:
    mechanism = MODELS["panda"]()
    states = random_states(mechanism, 10, 0)
    assert causes_of(mechanism, states, told_by(mechanism)(states)) == ()


@pytest.mark.parametrize(("size", "told"), [(0.9e-9, False), (1.1e-9, True)])
def test_a_difference_below_a_billionth_has_no_cause(size: float, told: bool) -> None:
    mechanism = mq.textbook.load("rigid_bar_pendulum")
    states = random_states(mechanism, 4, 0)
    # mass matrix, bias and gravity weigh one each
    theirs = {k: x * (1 + size / np.sqrt(3)) for k, x in told_by(mechanism)(states).items()}
    assert bool(causes_of(mechanism, states, theirs)) == told


def test_what_no_single_change_explains_is_not_explained() -> None:
    mechanism = MODELS["panda"]()
    states = random_states(mechanism, 10, 0)
    theirs = told_by(mechanism)(states)
    noise = np.random.default_rng(0).normal(size=theirs["bias"].shape)
    causes = causes_of(mechanism, states, {**theirs, "bias": theirs["bias"] + 100 * noise})
    assert not any(cause.removes for cause in causes)


def test_two_equal_links_on_one_axis_cannot_be_told_apart() -> None:
    hinge, weld = mq.Revolute("hinge", "ground", "a", axis=(0, 1, 0)), mq.Fixed("weld", "a", "b")
    bodies = (
        mq.Body("ground"),
        *(mq.Body(name, mq.ball(1.0, 0.1).at((0, 0, -1))) for name in "ab"),
    )
    pendulum = mq.Mechanism("pair", bodies, (hinge, weld), gravity=(0, 0, -9.81))
    heavier = replace(
        pendulum, bodies=(*bodies[:2], mq.Body("b", mq.ball(1000.0, 0.1).at((0, 0, -1))))
    )
    cause, *_ = mq.verify(pendulum, 10, against=heavier).causes
    assert cause.kind == "mass unit"
    assert {"link 'a'", "link 'b'"} <= {one.where for one in (cause, *cause.alike)}
    assert "cannot be told apart from" in str(cause)


def test_the_verdict_against_pinocchio_gives_its_causes(monkeypatch: pytest.MonkeyPatch) -> None:
    mechanism = mq.textbook.load("cart_pole")
    assert mq.verify(mechanism, 5).causes == ()
    monkeypatch.setattr(sources, "derive_all", lambda m: IN_HOUSE(m.replace(l=1.1)))
    verdict = mq.verify(mechanism, 5)
    assert not verdict.agrees
    # the mechanism itself is right, so that no change of it explains what the derivation does
    assert verdict.notes[-1] == "no single change among those tried removes the difference"


def test_causes_are_told_and_written() -> None:
    mechanism = mq.textbook.load("rigid_bar_pendulum")
    verdict = mq.verify(mechanism, 10, against=replace(mechanism, gravity=(0, 0, 9.81)))
    assert not verdict.agrees
    assert verdict.causes[0].kind == "gravity sign"
    assert "likely cause 1: gravity pulls the other way (the difference falls from " in str(verdict)
    data = json.loads(verdict.to_json())["causes"][0]
    assert (data["kind"], data["where"]) == ("gravity sign", "")
    assert data["after"] < 1e-12 < data["before"]


def test_residuals_count_every_quantity_alike() -> None:
    mechanism = mq.textbook.load("double_pendulum")
    states = random_states(mechanism, 6, 0)
    theirs = told_by(mechanism)(states)
    evidence = Evidence.of(mechanism, states, {**theirs, "bias": 2 * theirs["bias"]})
    assert evidence is not None
    assert evidence.before == pytest.approx(0.5, rel=1e-12)
    assert evidence.residual(evidence.tau) == 0
    assert Evidence.of(mechanism, states, {}) is None


def test_gravity_that_leans_is_told_by_its_components() -> None:
    mechanism = mq.read_urdf(mq.robot("panda"))
    cause, *more = mq.verify(
        mechanism, 10, against=replace(mechanism, gravity=(0.5, 0, -9.8))
    ).causes
    assert (cause.kind, cause.text) == ("gravity direction", "gravity is (0.5, 0, -9.8) m/s²")
    assert not more
    still, *_ = mq.verify(mechanism, 10, against=replace(mechanism, gravity=(0, 0, 0))).causes
    assert still.text == "gravity is left out"
    assert still.alike == ()


def test_a_prescribed_motion_gives_evidence_against_nothing_by_itself() -> None:
    """Where inertia moves by itself the mass matrix is asked together with the bias."""
    mechanism = mq.textbook.load("base_excited_mass")
    states = random_states(mechanism, 6, 0)
    theirs = told_by(mechanism)(states)
    evidence = Evidence.of(mechanism, states, theirs)
    assert evidence is not None
    assert evidence.before < 1e-12
    assert set(evidence.kind) == {"mass matrix", "bias", "forces"}
    del theirs["bias"]
    less = Evidence.of(mechanism, states, theirs)
    assert less is not None
    assert set(less.kind) == {"forces"}


def test_a_unit_mistaken_in_every_link_is_one_cause() -> None:
    arm = mq.textbook.load("double_pendulum")
    grams = arm.replace(m1=1000 * arm.values["m1"], m2=1000 * arm.values["m2"])
    cause, *_ = mq.verify(arm, 10, against=grams).causes
    assert (cause.kind, cause.where) == ("mass unit", "")
    assert cause.text == "mass and inertia of every link: grams for kilograms (×1000)"


def test_the_axis_of_a_joint_that_follows_the_coordinates_may_be_reversed() -> None:
    """The double pendulum's second hinge turns by q2 − q1, about −y."""
    ours = mq.textbook.load("double_pendulum")
    first, second = ours.joints
    assert isinstance(second, mq.Revolute)
    theirs = replace(ours, joints=(first, replace(second, axis=(0, 1, 0))))
    cause, *_ = mq.verify(ours, 10, against=theirs).causes
    named = {(one.kind, one.where) for one in (cause, *cause.alike)}
    assert ("axis sign", f"joint {second.name!r}") in named


def test_damping_left_out_in_every_joint_is_one_cause() -> None:
    arm = mq.textbook.load("two_link_arm")
    motors = tuple(force for force in arm.forces if isinstance(force, mq.JointForce))
    dampers = tuple(
        mq.JointDamper(f"damper {joint.name}", joint.name, 0.3 + k)
        for k, joint in enumerate(arm.joints)
    )
    damped = replace(arm, forces=(*motors, *dampers))
    free = replace(arm, forces=motors)
    cause, *_ = mq.verify(damped, 10, against=free).causes
    assert (cause.kind, cause.where) == ("damping", "")
    assert cause.text == "the damping of every joint is left out"


def test_every_change_that_is_tried_has_its_own_words() -> None:
    mechanism = mq.textbook.load("two_link_arm")
    states = random_states(mechanism, 6, 0)
    evidence = Evidence.of(mechanism, states, told_by(mechanism)(states))
    assert evidence is not None
    words = [(change.where, change.text) for change in link_changes(evidence)]
    assert len(words) == len(set(words))


@pytest.mark.parametrize(("factor", "words"), [(1000, "(×1000)"), (0.001, "(÷1000)")])
def test_a_joint_in_millimeters_is_named_with_its_factor(factor: float, words: str) -> None:
    arm = mq.textbook.load("two_link_arm")
    first, second = arm.joints
    place = second.origin
    x, y, z = (factor * arm.evaluate(c) for c in place.xyz)
    misread = replace(second, origin=replace(place, xyz=(x, y, z)))
    cause, *_ = mq.verify(arm, 10, against=replace(arm, joints=(first, misread))).causes
    assert cause.where == f"joint {second.name!r}"
    assert words in cause.text


def lengths_misread(m: mq.Mechanism, factor: float) -> mq.Mechanism:
    """All joints and centers of mass further out, the inertia about the centers as it was."""
    bodies = []
    for body in m.bodies:
        x, y, z = (factor * m.evaluate(c) for c in body.center)
        bodies.append(mq.Body(body.name, mq.Shape(body.mass, (x, y, z), body.inertia)))
    joints = []
    for joint in m.joints:
        x, y, z = (factor * m.evaluate(c) for c in joint.origin.xyz)
        joints.append(replace(joint, origin=replace(joint.origin, xyz=(x, y, z))))
    return replace(m, bodies=tuple(bodies), joints=tuple(joints))


def test_every_length_in_millimeters_is_one_cause() -> None:
    arm = mq.textbook.load("two_link_arm")
    cause, *_ = mq.verify(arm, 10, against=lengths_misread(arm, 1000.0)).causes
    assert (cause.kind, cause.where) == ("length unit", "")
    assert cause.text == "every length, of joints and centers: millimeters for meters (×1000)"


def test_a_link_counted_twice_and_a_product_of_the_other_sign_are_named() -> None:
    arm = mq.read_urdf(mq.robot("panda"))
    body = next(body for body in arm.bodies if body.name == "panda_link6")
    ixx, iyy, izz, ixy, ixz, iyz = body.inertia
    doubled = (2 * ixx, 2 * iyy, 2 * izz, 2 * ixy, 2 * ixz, 2 * iyz)
    twice = mq.Shape(2 * body.mass, body.center, doubled)
    other = mq.Shape(body.mass, body.center, (ixx, iyy, izz, ixy, -ixz, iyz))
    for shape, words in (
        (twice, "mass and inertia of link 'panda_link6': counted twice"),
        (other, "product of inertia ixz with the other sign"),
    ):
        bodies = tuple(mq.Body(b.name, shape) if b is body else b for b in arm.bodies)
        cause, *_ = mq.verify(arm, 10, against=replace(arm, bodies=bodies)).causes
        assert words in " ".join(one.text for one in (cause, *cause.alike))


def test_accelerations_are_compared_where_the_other_side_has_them() -> None:
    mechanism = mq.textbook.load("double_pendulum")
    verdict = mq.verify(mechanism, 5, against=mechanism)
    assert "acceleration" in {row.quantity for row in verdict.rows}


@pytest.mark.parametrize("name", ["slider_crank", "governor"])
def test_closed_forms_with_slides_and_loops_move_as_the_reference_does(name: str) -> None:
    mechanism = mq.textbook.load(name)
    derivation = mq.derive(mechanism).derivation
    states = random_states(mechanism, 5, 0, tuple(derivation.assumptions))
    ours = ClosedForm(mechanism, derivation).acceleration(states.q, states.v, states.t)
    expected = mq.Reference(mechanism).acceleration(states.q, states.v, states.t)
    np.testing.assert_allclose(ours, expected, rtol=1e-8, atol=1e-8 * np.abs(expected).max())


def evidence_of(mechanism: mq.Mechanism, theirs: Theirs, n: int = 8) -> Evidence:
    states = random_states(mechanism, n, 0)
    evidence = Evidence.of(mechanism, states, theirs(states))
    assert evidence is not None
    return evidence


@pytest.mark.parametrize(
    ("own", "more"), [(0.3, 0.2), (0.3, -0.3), (0.3, -0.5), (0.3, -0.2), (0.0, -1e-6)]
)
def test_less_than_no_damping_is_not_offered(own: float, more: float) -> None:
    pendulum = mq.textbook.load("rigid_bar_pendulum")
    damped = replace(pendulum, forces=(mq.JointDamper("damper", "pin", own),))

    def theirs(states: States) -> dict[str, np.ndarray]:
        values = told_by(damped)(states)
        return values | {"forces": values["forces"] - more * states.v}

    found = [c for c in joint_changes(evidence_of(damped, theirs)) if c.kind == "damping"]
    if own + more < 0:
        assert not found
        return
    (change,) = found
    assert change.free == 1
    assert ("is left out" in change.text) == (own + more == 0)
    if own + more:
        assert f": {own + more:.6g} N·m·s instead of {own:.6g}" in change.text


@pytest.mark.parametrize(
    ("own", "theirs", "digits"), [(0.37, 2.0, 1), (1.23, 1.53, 1), (0.7, 0.0, 0)]
)
def test_damping_is_as_plain_as_the_number_that_would_stand_there(
    own: float, theirs: float, digits: int
) -> None:
    """Or as what was added to it."""
    pendulum = mq.textbook.load("simple_pendulum")
    ours, other = (
        replace(pendulum, forces=(mq.JointDamper("damper", "pin", c),)) for c in (own, theirs)
    )
    evidence = evidence_of(ours, told_by(other))
    (change,) = (one for one in joint_changes(evidence) if one.kind == "damping")
    assert (change.amount.digits, change.amount.share) == (digits, 0.0)


def test_what_acts_in_a_screw_acts_about_its_axis() -> None:
    press = mq.textbook.load("screw_press")
    damped = replace(press, forces=(*press.forces, mq.JointDamper("oil", "thread", 0.4)))
    found = list(joint_changes(evidence_of(press, told_by(damped))))
    assert {one.where for one in found if one.kind == "damping"} == {"joint 'thread'"}


def test_what_a_change_explains_is_not_left() -> None:
    pendulum = mq.textbook.load("rigid_bar_pendulum")
    damped = replace(pendulum, forces=(mq.JointDamper("damper", "pin", 0.3),))
    evidence = evidence_of(pendulum, told_by(damped))
    (change,) = (one for one in joint_changes(evidence) if one.kind == "damping")
    left = evidence.after(change.answers - evidence.base, change.tree, None)
    assert evidence.before > 1e-3
    assert left.before < 1e-12


@pytest.mark.parametrize("more", [0.2, -0.05, -0.2])
def test_damping_mistaken_in_every_joint_is_offered_where_none_falls_below_zero(
    more: float,
) -> None:
    arm = mq.textbook.load("two_link_arm")
    dampers = [
        mq.JointDamper(f"damper {joint.name}", joint.name, c)
        for joint, c in zip(arm.joints, (0.3, 0.1), strict=True)
    ]
    damped = replace(arm, forces=tuple(dampers))

    def theirs(states: States) -> dict[str, np.ndarray]:
        values = told_by(damped)(states)
        return values | {"forces": values["forces"] - more * states.v}

    texts = [c.text for c in joint_changes(evidence_of(damped, theirs)) if c.kind == "damping"]
    words = f"damping in every joint: {more:+.6g} more in each (SI units)"
    assert (words in texts) == (more > -0.1)


def test_numbers_that_were_fitted_deviate_as_the_covariance_says() -> None:
    """s² (XᵀX)⁻¹ with s² = |r|²/(n − k), of columns at right angles s²/|x|²."""
    slopes = np.array([[3.0, 4.0, 0.0, 0.0], [0.0, 0.0, 2.0, 0.0]])
    left, count = 0.6, 11
    expected = left / 3 / np.array([5.0, 2.0])
    np.testing.assert_allclose(deviations(slopes, left, count), expected, rtol=1e-12, atol=0)


@pytest.mark.parametrize(
    ("own", "other", "text"),
    [
        ((0, 0, -9.81), (0, 0, 9.81), "gravity pulls the other way"),
        ((0, 0, -9.81), (0, 0, 0), "gravity is left out"),
        ((0, 0, -9.81), (9.81, 0, 0), "gravity pulls along +x"),
        ((0, 0, -9.81), (-9.81, 0, 0), "gravity pulls along −x"),
        ((0, 0, -9.81), (0, -9.81, 0), "gravity pulls along −y"),
        ((0, 0, -9.81), (0, 0, -19.62), "gravity is (0, 0, -19.62) m/s²"),
        ((3, 0, -9), (3, 0, -9), "gravity is (3, 0, -9) m/s²"),
        ((3, 0, -9), (-3, 0, 9), "gravity pulls the other way"),
        ((0, 0, -5e-6), (3e-6, 0, -4e-6), "gravity is (3e-06, 0, -4e-06) m/s²"),
        ((0, 0, -5e-9), (5e-9, 0, 0), "gravity pulls along +x"),
        ((0, 0, -9.81), (6e-9, 0, -12), "gravity is (0, 0, -12) m/s²"),
        ((0, 0, -9.81), (1.8e-8, 0, -12), "gravity is (1.8e-08, 0, -12) m/s²"),
        ((0, 0, -9.81), (9.81, 1.5e-8, 0), "gravity is (9.81, 1.5e-08, 0) m/s²"),
    ],
)
def test_each_change_of_gravity_has_one_name(
    own: tuple[float, float, float], other: tuple[float, float, float], text: str
) -> None:
    panda = MODELS["panda"]()
    ours, theirs = (replace(panda, gravity=g) for g in (own, other))
    evidence = evidence_of(ours, told_by(theirs))
    fitting = [c.text for c in gravity_changes(evidence) if evidence.residual(c.answers) < 1e-9]
    assert fitting == [text]


@pytest.mark.parametrize(
    ("factor", "words"),
    [(1000.0, "millimeters for meters (×1000)"), (1e-3, "meters for millimeters (÷1000)")],
)
@pytest.mark.parametrize("inertias", [True, False])
def test_lengths_of_a_spatial_arm_are_misread_with_or_without_inertias(
    factor: float, words: str, inertias: bool
) -> None:
    panda = MODELS["panda"]()
    theirs = lengths_misread(panda, factor)
    if inertias:
        bodies = []
        for body in theirs.bodies:
            ixx, iyy, izz, *products = (factor**2 * theirs.evaluate(i) for i in body.inertia)
            ixy, ixz, iyz = products
            shape = mq.Shape(body.mass, body.center, (ixx, iyy, izz, ixy, ixz, iyz))
            bodies.append(mq.Body(body.name, shape))
        theirs = replace(theirs, bodies=tuple(bodies))
    of = "of joints, centers and inertias" if inertias else "of joints and centers"
    evidence = evidence_of(panda, told_by(theirs))
    best = min(frame_changes(evidence), key=lambda change: evidence.residual(change.answers))
    assert best.text == f"every length, {of}: {words}"
    assert evidence.residual(best.answers) < 1e-9


@pytest.mark.parametrize(
    ("factor", "words"),
    [(np.pi / 180, "radians for degrees"), (180 / np.pi, "degrees for radians")],
)
@pytest.mark.parametrize("rates", [False, True])
@pytest.mark.parametrize("every", [False, True])
def test_angles_in_degrees_are_named(factor: float, words: str, rates: bool, every: bool) -> None:
    arm = mq.textbook.load("two_link_arm")
    scale = np.array([factor, factor if every else 1.0])

    def theirs(states: States) -> dict[str, np.ndarray]:
        misread = replace(states, q=states.q * scale, v=states.v * (scale if rates else 1.0))
        values = told_by(arm)(misread)
        # accelerations are misread with the rates
        return values | {"mass matrix": values["mass matrix"] * (scale if rates else 1.0)}

    evidence = evidence_of(arm, theirs)
    what = "every angle" if every else f"coordinate {arm.coordinates[0]!r}"
    fitting = [
        change.text
        for change in state_changes(evidence)
        if evidence.residual(change.answers) < 1e-9
    ]
    assert fitting == [f"{what}: {words}" + (", its rates as well" if rates else "")]


def test_the_moving_mass_is_that_of_all_bodies_but_the_ground() -> None:
    arm = mq.textbook.load("double_pendulum", m1=2.0, m2=3.0)
    heavy = tuple(
        mq.Body(b.name, mq.ball(50.0, 0.1)) if b.name == arm.ground else b for b in arm.bodies
    )
    assert moving_mass(arm) == moving_mass(replace(arm, bodies=heavy)) == 5.0
    assert moving_mass(arm.replace(m1=0.0, m2=0.0)) == 1.0


def joint_of(mechanism: mq.Mechanism, name: str) -> mq.Revolute:
    (joint,) = (joint for joint in mechanism.joints if joint.name == name)
    assert isinstance(joint, mq.Revolute)
    return joint


def with_origin(
    mechanism: mq.Mechanism, name: str, xyz: np.ndarray, rpy: np.ndarray
) -> mq.Mechanism:
    return with_joint(mechanism, name, origin=mq.Placement(tuple(xyz), tuple(rpy)))


def place(how: str, p: np.ndarray, r: np.ndarray) -> tuple[np.ndarray, np.ndarray, str, str]:
    """Position, angles, kind of the mistake and words that name it."""
    if how == "moved":
        return p + 0.01 * np.eye(3)[1], r, "joint origin", "moved by 0.01 m along y"
    if how == "mirrored":
        return (
            p * [-1, 1, 1],
            r,
            "joint origin",
            "joint4': mirrored (x with the other",
        )
    if how == "left out":
        return 0 * p, r, "joint origin", "position of joint 'panda_joint4': left out"
    if how == "longer":
        return 1.2 * p, r, "joint origin", "moved by 0.0165 m along x"
    if how == "yawed":
        return p, r + 0.2 * np.eye(3)[2], "joint turn", "yaw of joint 'panda_joint4'"
    if how == "degrees":
        return (
            p,
            r * 180 / np.pi,
            "degree",
            "joint4': degrees for radians",
        )
    if how == "turned":
        return p, r + 0.2 * np.eye(3)[0], "joint turn", "roll of joint 'panda_joint4'"
    return p, r[[1, 0, 2]], "joint turn", "rpy in the order p, r, y"


@pytest.mark.parametrize(
    "how", ["moved", "mirrored", "left out", "longer", "turned", "yawed", "degrees", "exchanged"]
)
def test_a_joint_that_stands_elsewhere_is_named_with_the_amount(how: str) -> None:
    mechanism = MODELS["panda"]()
    own = joint_of(mechanism, "panda_joint4").origin
    frame = [np.array(mechanism.evaluate_all(part)) for part in (own.xyz, own.rpy)]
    xyz, rpy, kind, text = place(how, *frame)
    states = random_states(mechanism, 6, 3)
    theirs = told_by(with_origin(mechanism, "panda_joint4", xyz, rpy))(states)
    first = causes_of(mechanism, states, theirs)[0]
    assert (first.kind, first.where) == (kind, "joint 'panda_joint4'")
    assert text in first.text
    assert first.removes


def test_a_tilted_axis_is_named_with_its_direction() -> None:
    mechanism = MODELS["panda"]()
    states = random_states(mechanism, 6, 3)
    tilted = with_joint(mechanism, "panda_joint4", axis=(0.0, 0.6, 0.8))
    first = causes_of(mechanism, states, told_by(tilted)(states))[0]
    assert (first.kind, first.where) == ("joint axis", "joint 'panda_joint4'")
    assert "along (0, 0.6, 0.8)" in first.text or "e-" in first.text


def test_any_turn_of_an_inertia_is_found() -> None:
    mechanism = MODELS["panda"]()
    (body,) = (body for body in mechanism.bodies if body.name == "panda_link5")
    mass, center, inertia = parts(mechanism, body)
    R = np.array(rpy_rotation((0.9, -0.4, 1.7)), dtype=float)
    theirs = with_body(mechanism, body.name, mass, center, R @ inertia @ R.T)
    states = random_states(mechanism, 6, 3)
    first = causes_of(mechanism, states, told_by(theirs)(states))[0]
    assert (first.kind, first.where) == ("inertia turn", "link 'panda_link5'")


def test_no_cause_has_less_than_no_mass() -> None:
    # the moment of inertia about the only axis is less: a lighter link, not a mass below zero
    mechanism = mq.read_urdf(mq.robot("z1"))
    states = random_states(mechanism, 6, 3)
    (body,) = (body for body in mechanism.bodies if body.name == "link01")
    mass, center, inertia = parts(mechanism, body)
    theirs = with_body(mechanism, "link01", mass, center, 0.8 * inertia)
    first = causes_of(mechanism, states, told_by(theirs)(states))[0]
    texts = [first.text, *(cause.text for cause in first.alike)]
    assert texts
    assert not any(re.search(r"[:(] ?-|times -", text) for text in texts)


def test_noisy_samples_give_link_and_mass_with_a_deviation() -> None:
    mechanism = MODELS["panda"]()
    (body,) = (body for body in mechanism.bodies if body.name == "panda_link5")
    mass, center, inertia = parts(mechanism, body)
    heavier = with_body(mechanism, body.name, 1.2 * mass, center, inertia)
    states = random_states(mechanism, 100, 3)
    recursion = Recursion(heavier)
    tau = recursion.inverse_dynamics(states, states.a) - recursion.forces(states)
    noise = np.random.default_rng(0).normal(size=tau.shape)
    tau += 0.05 * np.sqrt((tau**2).mean(axis=0)) * noise
    first = causes_of(mechanism, states, {"inverse dynamics": tau})[0]
    assert (first.kind, first.where) == ("link mass", "link 'panda_link5'")
    found = re.search(r"([\d.]+) ± ([\d.]+) kg", first.text)
    assert found
    assert abs(float(found[1]) - 1.2 * mass) <= 3 * float(found[2])
    assert 0 < float(found[2]) < 0.1 * mass


def test_a_pair_that_explains_all_stands_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    pendulum = mq.textbook.load("rigid_bar_pendulum")
    damped = replace(pendulum, forces=(mq.JointDamper("damper", "pin", 0.3),))
    pair, *singles = (LikelyCause("one", "", name, 1.0, 0.5) for name in "pabcde")
    search = sys.modules["mecanique.verification.causes.search"]
    monkeypatch.setattr(search, "_rank", lambda *_: tuple(singles))
    monkeypatch.setattr(search, "_find_pair", lambda *_: pair)
    states = random_states(pendulum, 4, 0)
    assert causes_of(pendulum, states, told_by(damped)(states)) == (pair,)


def test_a_small_mistake_beside_a_large_one_must_remove_what_that_leaves(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A pair counts if it leaves a ten-thousandth of what is left beside the large one alone."""
    pendulum = mq.textbook.load("rigid_bar_pendulum")
    damped = replace(pendulum, forces=(mq.JointDamper("damper", "pin", 0.3),))
    search = sys.modules["mecanique.verification.causes.search"]
    large = LikelyCause("one", "", "large", 1.0, 1e-9)
    monkeypatch.setattr(search, "_rank", lambda *_: (large,))
    limits = list[float]()
    monkeypatch.setattr(search, "_find_pair", lambda *given: limits.append(given[-1]))
    states = random_states(pendulum, 4, 0)
    assert causes_of(pendulum, states, told_by(damped)(states)) == (large,)
    assert limits == [pytest.approx(1e-13, rel=1e-9)]


@pytest.mark.parametrize(("links", "starts"), [(7, 6), (13, 2)])
def test_the_search_for_pairs_begins_in_few_places_of_a_long_chain(
    links: int, starts: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Six places, and two with more than twelve velocities, the most promising first."""
    chain = mq.textbook.load("n_link_pendulum", n=links)
    search = sys.modules["mecanique.verification.causes.search"]
    places = list[str]()
    monkeypatch.setattr(search, "_alternate", lambda _, first, __: places.append(first.where))
    evidence = evidence_of(chain, told_by(chain.replace(g=9.0)))
    names = [body.name for body in chain.bodies[1:]]
    away = evidence.tau - evidence.base
    changes = [
        Hypothesis("link mass", name, name, evidence.base + k / links * away)
        for k, name in enumerate(names)
    ]
    assert search._find_pair(evidence, changes, 1e-9) is None
    assert places == names[: -1 - starts : -1]


def test_a_damper_and_a_mass_are_named_together() -> None:
    """The damper changes no link, so that what it does is taken off before the next is fitted."""
    arm = MODELS["z1"]()
    (body,) = (body for body in arm.bodies if body.name == "link03")
    mass, center, inertia = parts(arm, body)
    damper = mq.JointDamper("injected damper", "joint5", 4.0)
    theirs = replace(
        with_body(arm, body.name, 1.2 * mass, center, inertia), forces=(*arm.forces, damper)
    )
    states = random_states(arm, 6, 3)
    causes = causes_of(arm, states, told_by(theirs)(states))
    named = {(part.kind, part.where) for part in causes[0].parts}
    assert named == {("damping", "joint 'joint5'"), ("link mass", "link 'link03'")}
    assert causes[0].removes


def test_dampers_of_two_joints_are_named_together() -> None:
    """Each is fitted while what the other explains is left free."""
    arm = MODELS["z1"]()
    added = {"joint1": 1.0, "joint2": 1.3}
    dampers = [mq.JointDamper(f"added to {name}", name, c) for name, c in added.items()]
    states = random_states(arm, 6, 3)
    (cause,) = causes_of(arm, states, told_by(replace(arm, forces=(*arm.forces, *dampers)))(states))
    assert [part.text for part in cause.parts] == [
        "damping of joint 'joint1': 2 N·m·s instead of 1",
        "damping of joint 'joint2': 3.3 N·m·s instead of 2",
    ]
    assert cause.removes


def test_more_noisy_samples_give_a_smaller_deviation() -> None:
    """By the root of their number."""
    pendulum = mq.textbook.load("rigid_bar_pendulum")
    recursion, found = Recursion(pendulum.replace(m=1.2 * pendulum.values["m"])), []
    for n in (100, 1600):
        states = random_states(pendulum, n, 3)
        tau = recursion.inverse_dynamics(states, states.a) - recursion.forces(states)
        tau += 0.05 * np.sqrt((tau**2).mean()) * np.random.default_rng(0).normal(size=tau.shape)
        first = causes_of(pendulum, states, {"inverse dynamics": tau})[0]
        said = re.search(r"± ([\d.]+)", first.text)
        assert said, first.text
        found.append(float(said[1]))
    assert found[0] / found[1] == pytest.approx(4, rel=0.25)


def test_the_last_link_of_a_long_chain_is_fitted_as_well() -> None:
    chain = mq.textbook.load("n_link_pendulum", n=10)
    body = chain.bodies[-1]
    mass, center, inertia = parts(chain, body)
    evidence = evidence_of(chain, told_by(with_body(chain, body.name, 1.3 * mass, center, inertia)))
    fitting = [one for one in fit_inertias(evidence) if evidence.residual(one.answers) < 1e-9]
    assert ("link mass", f"link {body.name!r}") in {(one.kind, one.where) for one in fitting}


@pytest.mark.slow
def test_two_mistakes_in_different_links_are_named_together() -> None:
    mechanism = mq.read_urdf(mq.robot("ur5_robot"))
    (elbow,) = (joint for joint in mechanism.joints if joint.name == "elbow_joint")
    x, y, z = mechanism.evaluate_all(elbow.origin.xyz)
    moved = mq.Placement((x, y, z + 0.01), elbow.origin.rpy)
    (body,) = (body for body in mechanism.bodies if body.name == "wrist_2_link")
    mass, center, inertia = parts(mechanism, body)
    theirs = with_body(
        with_joint(mechanism, elbow.name, origin=moved), body.name, 1.2 * mass, center, inertia
    )
    states = random_states(mechanism, 6, 3)
    first = causes_of(mechanism, states, told_by(theirs)(states))[0]
    named = {(part.kind, part.where) for part in first.parts}
    assert named == {("joint origin", "joint 'elbow_joint'"), ("link mass", "link 'wrist_2_link'")}
    assert "moved by 0.01 m along z" in first.text
    assert f"mass of link 'wrist_2_link': {1.2 * mass:.6g} kg" in first.text
    assert first.removes
    assert [part["kind"] for part in first.to_dict()["parts"]] == ["joint origin", "link mass"]


@pytest.mark.slow
def test_a_tilted_axis_is_named_beside_a_mistake_in_the_link_that_it_carries() -> None:
    mechanism = mq.read_urdf(mq.robot("ur5_robot"))
    mass, center, inertia = parts(mechanism, mechanism.body("forearm_link"))
    moved = with_body(mechanism, "forearm_link", mass, center + 0.01 * np.eye(3)[0], inertia)
    (elbow,) = (joint for joint in mechanism.joints if joint.name == "elbow_joint")
    assert isinstance(elbow, mq.Revolute)
    tilt = turn_about(np.array([0.1, 0.0, 0.2]))
    axis = tilt @ np.array(mechanism.evaluate_all(elbow.axis))
    theirs = with_joint(moved, elbow.name, axis=(axis[0], axis[1], axis[2]))
    states = random_states(mechanism, 6, 3)
    first = causes_of(mechanism, states, told_by(theirs)(states))[0]
    named = {(part.kind, part.where) for part in first.parts}
    assert named == {
        ("joint axis", "joint 'elbow_joint'"),
        ("center of mass", "link 'forearm_link'"),
    }
    assert "center of mass of link 'forearm_link' moved by 0.01 m along x" in first.text
    assert first.removes


def other_inertias() -> Iterator[tuple[str, str, Callable[[float, Array, Array], Any]]]:
    """Kinds of mistakes in a link, the words that name them with their number, and the change."""
    point, turn = np.array([0.05, -0.1, 0.15]), np.array(rpy_rotation((0.2, 0, 0)), dtype=float)
    whole = np.array([[0.02, -0.03, 0.01], [-0.03, 0.05, 0.02], [0.01, 0.02, -0.01]])
    yield "link mass", "mass of link 'arm': 2.6 kg instead", lambda m, c, i: (1.3 * m, c, i)
    yield (
        "link mass",
        "mass and inertia of link 'arm' times 0.7 (mass 1.4 kg)",
        lambda m, c, i: (0.7 * m, c, 0.7 * i),
    )
    for more, words in ((0.4, "0.4 kg more"), (-0.1, "0.1 kg less")):
        yield (
            "link mass",
            f"a point mass of {words} at the origin of link 'arm'",
            partial(with_point_mass, more),
        )
    for k, name in enumerate("xyz"):
        yield (
            "center of mass",
            f"moved by {point[k]:g} m along {name}",
            partial(with_shift, point[k] * np.eye(3)[k], np.zeros((3, 3))),
        )
    yield "center of mass", "moved by (0.05, -0.1, 0.15) m", lambda m, c, i: (m, c + point, i)
    yield "inertia", "inertia of link 'arm' times 1.5", lambda m, c, i: (m, c, 1.5 * i)
    for j, k in ((0, 0), (0, 2), (1, 2)):
        E = np.zeros((3, 3))
        E[j, k] = E[k, j] = 0.01
        name = f"i{'xyz'[j]}{'xyz'[k]}"
        yield "inertia", f"{name} of link 'arm'", partial(with_shift, np.zeros(3), E)
    yield "inertia turn", "turned by 11.4592° about (1, ", lambda m, c, i: (m, c, turn @ i @ turn.T)
    yield (
        "inertia",
        "ixx, ixy, ixz, iyy, iyz, izz = 0.22, -0.01, 0.04, 0.35, 0.05, 0.39 kg",
        lambda m, c, i: (m, c, i + whole),
    )


def with_shift(
    step: Array, more: Array, m: float, c: Array, i: Array
) -> tuple[float, Array, Array]:
    """Mass, center and inertia about it, the last two moved."""
    return m, c + step, i + more


def with_point_mass(more: float, m: float, c: Array, i: Array) -> tuple[float, Array, Array]:
    """Mass, center and inertia about it with a point mass more at the origin."""
    center = m * c / (m + more)
    return m + more, center, i + steiner(m, c - center) + steiner(more, -center)


def hull_with_arm() -> mq.Mechanism:
    """A free hull whose arm swings about a slanting axis, so that every mass moment is felt."""
    return mq.Mechanism(
        "free",
        (mq.Body("ground"), mq.Body("hull", mq.box(3.0, (0.3, 0.4, 0.5))), mq.Body("arm")),
        (
            mq.Floating("free", "ground", "hull"),
            mq.Revolute("hinge", "hull", "arm", axis=(0.6, 0, 0.8), origin=mq.Placement((1, 0, 0))),
        ),
        gravity=(0, 0, -9.81),
    )


INERTIA = np.array([[0.2, 0.02, 0.03], [0.02, 0.3, 0.03], [0.03, 0.03, 0.4]])


@pytest.mark.parametrize(("kind", "words", "change"), list(other_inertias()))
def test_each_kind_of_another_inertia_is_fitted_and_named_with_its_number(
    kind: str, words: str, change: Callable[[float, Array, Array], Any]
) -> None:
    own = 2.0, np.array([0.1, -0.2, 0.3]), INERTIA
    ours, theirs = (with_body(hull_with_arm(), "arm", *body) for body in (own, change(*own)))
    evidence = evidence_of(ours, told_by(theirs))
    for one in placement_changes(evidence):
        assert one.slopes is not None
        assert np.isfinite(one.slopes).all()
        (told,) = evidence.change([one.tree])
        np.testing.assert_allclose(one.answers, told, rtol=1e-10, atol=1e-10)
    moments = (J for one in fit_inertias(evidence) for J in one.tree.moments.values())
    assert all(np.allclose(J, J.T, rtol=0, atol=1e-12) for J in moments)
    fitting = [
        (one.kind, one.text)
        for one in fit_inertias(evidence)
        if one.where == "link 'arm'" and evidence.residual(one.answers) < 1e-9
    ]
    assert any(kind == one and words in text for one, text in fitting), fitting


@pytest.mark.parametrize("seed", range(8))
def test_a_turn_begins_where_the_principal_axes_of_the_best_inertia_lie(seed: int) -> None:
    """Where every mass moment is felt it is there already, up to half turns about these axes."""
    turn = turn_about(np.random.default_rng(seed).uniform(-2, 2, 3))
    other = turn @ INERTIA @ turn.T
    ours, theirs = (
        with_body(hull_with_arm(), "arm", 2.0, np.array([0.1, -0.2, 0.3]), inertia)
        for inertia in (INERTIA, other)
    )
    evidence = evidence_of(ours, told_by(theirs))
    (k,) = (k for k, link in enumerate(evidence.recursion.tree) if link.body == "arm")
    effect = LinkEffect.of(evidence, evidence.regressor[:, :, k])
    R = turn_about(principal_turn(effect, evidence.recursion.moments[k]))
    np.testing.assert_allclose(R @ INERTIA @ R.T, other, rtol=0, atol=1e-9)


@pytest.mark.parametrize(
    ("xyz", "roll", "text", "amount"),
    [
        ((0.1, 0.0, 0.2), 0.3, "moved by 0.0176 m along x", (0.1, 0.0824)),
        ((0.0824, 0.0, 0.2), 0.4321, "roll of joint 'hinge': 0.4321 rad", (0.4321, 0.3)),
        ((0.0824, 0.0, 0.2), np.radians(20), "roll of joint 'hinge'", (20.0, np.degrees(0.3))),
    ],
    ids=["x", "radians", "degrees"],
)
def test_how_plain_a_move_is_shows_in_the_number_that_would_stand_there(
    xyz: tuple[float, float, float], roll: float, text: str, amount: tuple[float, float]
) -> None:
    """In radians or degrees, whichever is plainer."""
    ours, theirs = (
        mq.Mechanism(
            "hung",
            (mq.Body("ground"), *(mq.Body(name, mq.box(2.0, (0.2, 0.3, 0.4))) for name in "ab")),
            (
                mq.Revolute("swing", "ground", "a", axis=(0.6, 0, 0.8)),
                mq.Revolute("hinge", "a", "b", axis=(0, 0.6, 0.8), origin=where),
            ),
            gravity=(0, 0, -9.81),
        )
        for where in (mq.Placement((0.0824, 0, 0.2), (0.3, 0, 0)), mq.Placement(xyz, (roll, 0, 0)))
    )
    evidence = evidence_of(ours, told_by(theirs))
    (found,) = (
        one
        for one in placement_changes(evidence)
        if text in one.text and evidence.residual(one.answers) < 1e-8
    )
    beside = np.linalg.norm((0.0824, 0.2)) if "moved" in text else np.pi
    expected = Amount.of(*amount, beside=float(beside), ways=3)
    assert (found.amount.digits, found.amount.ways) == (expected.digits, expected.ways)


def swinging_box(factor: float = 1.0, rotor: float = 0.0) -> mq.Mechanism:
    """A box on a hinge, with moments of inertia times a factor and a rotor [kg·m²] in the hinge."""
    box = mq.box(1.7, (0.3, 0.2, 0.5)).at((0.1, 0, -0.2))
    hinge = mq.Revolute("hinge", "ground", "box", axis=(0, 1, 0), armature=rotor)
    mechanism = mq.Mechanism("box", (mq.Body("ground"), mq.Body("box", box)), (hinge,))
    (body,) = (body for body in mechanism.bodies if body.name == "box")
    mass, center, inertia = parts(mechanism, body)
    return with_body(mechanism, "box", mass, center, factor * inertia)


@pytest.mark.parametrize(
    ("factor", "rotor", "kind"),
    [(1.3, 0.0, "inertia"), (1.0, 0.05, "armature"), (1.0, 0.0123457, "armature")],
)
def test_of_what_explains_as_well_the_plainest_number_comes_first(
    factor: float, rotor: float, kind: str
) -> None:
    """One hinge feels rotor + iyy alone: a round factor, a round rotor, else a rotor left out."""
    mechanism = swinging_box()
    states = random_states(mechanism, 6, 3)
    first = causes_of(mechanism, states, told_by(swinging_box(factor, rotor))(states))[0]
    assert first.kind == kind
    assert {"inertia", "armature"} - {kind} <= {cause.kind for cause in first.alike}


def test_plain_amounts_come_before_odd_and_large_ones() -> None:
    assert Amount.of(1.3 * 0.0213312, 0.0213312).digits == 2  # times 1.3
    assert Amount.of(0.0213312 + 0.005, 0.0213312).digits == 1
    assert Amount.of(0.2123456, 0.2).digits == 6
    round_one, odd = Amount.of(0.26, 0.2, ways=6), Amount.of(0.2123456, 0.2)
    assert round_one < odd
    assert odd < Amount.of(0.2123456, 0.2, ways=3)
    assert odd < Amount.of(0.3123456, 0.2)
    assert Amount.of(0.01, 0.0, beside=0.1).share == pytest.approx(0.1, rel=1e-12)
    assert Amount.of(0.01).share == 1.0
    assert Amount.of_all(np.array([0.01, 0.0, 0.0212345]), 0.1).digits == 6


def test_a_turn_is_given_by_half_a_turn_at_most() -> None:
    assert say_turn(np.array([0.0, 0.0, np.radians(350.0)])) == "10° about (0, 0, -1)"


@pytest.mark.parametrize("large", ["axis", "length"])
def test_a_mistake_beside_one_that_changes_everything_is_named_too(large: str) -> None:
    """The axis of the first joint is turned round, or 4 m are 4 km, and a far inertia is off."""
    arm = mq.textbook.load("two_link_arm")
    arm = mq.read_urdf(mq.write_urdf(arm))
    first, second = (joint for joint in arm.joints if isinstance(joint, mq.Revolute))
    (body,) = (body for body in arm.bodies if body.name == second.child)
    mass, center, inertia = parts(arm, body)
    x, y, z = arm.evaluate_all(second.origin.xyz)
    changes: dict[str, tuple[str, dict[str, Any], str]] = {
        "axis": (first.name, {"axis": tuple(-np.array(first.axis))}, "axis sign"),
        "length": (
            second.name,
            {"origin": mq.Placement((1e3 * x, 1e3 * y, 1e3 * z))},
            "length unit",
        ),
    }
    name, change, kind = changes[large]
    other = with_body(with_joint(arm, name, **change), body.name, mass, center, 1.3 * inertia)
    states = random_states(arm, 6, 3)
    (cause,) = causes_of(arm, states, told_by(other)(states))
    named = {(part.kind, part.where) for part in cause.parts}
    assert (kind, f"joint {name!r}") in named
    assert len(named) == 2
    assert cause.removes


def test_axes_that_are_all_reversed_are_named_together() -> None:
    """Positions, rates and forces change their signs at once; any two of them explain nothing."""
    arm = mq.textbook.load("two_link_arm")
    reversed_arm = arm
    for joint in arm.joints:
        assert isinstance(joint, mq.Revolute)
        x, y, z = joint.axis
        reversed_arm = reversed_arm.with_joint(joint.name, axis=(-x, -y, -z))
    verdict = mq.verify(arm, against=reversed_arm, samples=10)
    causes = {(cause.kind, cause.where): cause.after for cause in verdict.causes}
    assert causes["axis sign", ""] < 1e-13
