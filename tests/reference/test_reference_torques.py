"""Torques given with a state: in accelerations and reactions, on both sides of the house."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from reference_samples import driven, flyer, states, tree

from mecanique.derivation import derive
from mecanique.derivation.equations import Equations
from mecanique.errors import InputError, UnknownNameError
from mecanique.model import (
    Body,
    Coordinates,
    JointForce,
    Mechanism,
    Placement,
    Revolute,
    coordinate,
    rod,
)
from mecanique.model.joint_base import Single
from mecanique.model.values import Given
from mecanique.reference import Reference, assemble
from mecanique.textbook import load
from mecanique.textbook.catalogue import entry


def test_the_torque_of_a_motor_turns_the_arm_and_its_holder() -> None:
    """Spong, Hutchinson & Vidyasagar, sect. 6.4: M q'' + … = (tau1, tau2)."""
    arm = load("two_link_arm")
    reference = Reference(arm)
    q, v = [0.3, -0.8], [0.5, 1.1]
    change = reference.acceleration(q, v, tau={"elbow": 3.0}) - reference.acceleration(q, v)
    assert reference.mass_matrix(q) @ change == pytest.approx([0, 3], abs=1e-12)
    for same in ({"q2": 3.0}, {"q2'": 3.0}, [0.0, 3.0], np.array([0.0, 3.0])):
        assert reference.acceleration(q, v, tau=same) - reference.acceleration(q, v) == (
            pytest.approx(change, rel=1e-12)
        )
    assert (reference.acceleration(q, v) == reference.acceleration(q, v, tau=[0.0, 0.0])).all()


def with_motors(name: str, torques: dict[str, float]) -> Mechanism:
    """A system with the torques as forces of its own."""
    plain = load(name)
    motors = (JointForce(f"drive of {joint}", joint, T) for joint, T in torques.items())
    return Mechanism(
        plain.name,
        bodies=plain.bodies,
        joints=plain.joints,
        forces=(*plain.forces, *motors),
        loops=plain.loops,
        parameters=plain.parameters,
        inputs=plain.inputs,
        coordinates=plain.coordinates,
        gravity=plain.gravity,
    )


@pytest.mark.parametrize(
    "name", ["two_link_arm", "double_pendulum", "slider_crank", "screw_press", "cart_pole"]
)
def test_torques_do_what_a_motor_in_the_joint_does(name: str) -> None:
    plain = load(name)
    singles = [joint.name for joint in plain.joints if isinstance(joint, Single)]
    torques = {joint: 0.5 + k for k, joint in enumerate(singles)}
    motors = with_motors(name, torques)
    reference, driven_too = Reference(plain), Reference(motors)
    start = assemble(plain, entry(name).start) if plain.loops else plain.position(entry(name).start)
    v = np.zeros(plain.nv)
    expected = driven_too.acceleration(start, v)
    assert reference.acceleration(start, v, tau=torques) == pytest.approx(expected, rel=1e-12)
    wanted, found = driven_too.reactions(start, v), reference.reactions(start, v, tau=torques)
    for joint, wrench in wanted.items():
        assert found[joint].force == pytest.approx(wrench.force, rel=1e-11, abs=1e-11, nan_ok=True)
        assert found[joint].moment == pytest.approx(
            wrench.moment, rel=1e-11, abs=1e-11, nan_ok=True
        )
    for method in ("lagrange", "newton_euler", "virtual_work"):
        equations = derive(plain, method=method)
        assert equations.acceleration(start, v, tau=torques) == pytest.approx(expected, rel=1e-9)
    if not plain.loops:
        own = derive(plain, method="newton_euler").reactions(start, v, tau=torques)
        for joint, wrench in wanted.items():
            assert own[joint].force == pytest.approx(wrench.force, rel=1e-9, abs=1e-9, nan_ok=True)
            assert own[joint].moment == pytest.approx(
                wrench.moment, rel=1e-9, abs=1e-9, nan_ok=True
            )


@pytest.mark.parametrize("build", [tree, flyer, driven])
def test_generalized_forces_enter_as_they_are(build: Callable[[], Mechanism]) -> None:
    """M (a − a₀) = tau, with quaternions, every joint, and a map that moves by itself."""
    mechanism = build()
    reference, equations = Reference(mechanism), derive(mechanism)
    random = np.random.default_rng(2)
    for q, v, t in states(mechanism, 4):
        tau = random.normal(size=mechanism.nv)
        change = reference.acceleration(q, v, t, tau) - reference.acceleration(q, v, t)
        assert reference.mass_matrix(q, t) @ change == pytest.approx(tau, rel=1e-8, abs=1e-8)
        own = equations.acceleration(q, v, t, tau) - equations.acceleration(q, v, t)
        assert own == pytest.approx(change, rel=1e-7, abs=1e-8)


def test_a_torque_in_a_joint_that_follows_works_through_the_map() -> None:
    """With r2 = 3 q, a torque T in the second joint is the generalized force 3 T."""
    geared = Mechanism(
        "geared",
        bodies=(Body("ground"), Body("a", rod(1, 1.0)), Body("b", rod(1, 1.0))),
        joints=(
            Revolute("one", "ground", "a", axis=(0, -1, 0), coordinate="r1"),
            Revolute(
                "two", "a", "b", axis=(0, -1, 0), origin=Placement((0, 0, -1)), coordinate="r2"
            ),
        ),
        coordinates=Coordinates(("q",), {"r1": coordinate("q"), "r2": 3 * coordinate("q")}),
    )
    reference, equations = Reference(geared), derive(geared, method="newton_euler")
    for side in (reference, equations):
        by_joint = side.acceleration([0.2], [0.4], tau={"two": 2.0})
        assert side.acceleration([0.2], [0.4], tau={"q": 6.0}) == pytest.approx(by_joint, rel=1e-13)
        assert side.acceleration([0.2], [0.4], tau={"r2": 2.0}) == pytest.approx(
            by_joint, rel=1e-13
        )
        with pytest.raises(InputError, match="what makes the forces on q'"):
            side.reactions([0.2], [0.4], tau={"q": 6.0})
    one, other = (
        reference.reactions([0.2], [0.4], tau={"two": 2.0}),
        equations.reactions([0.2], [0.4], tau={"two": 2.0}),
    )
    for joint in ("one", "two"):
        assert one[joint].force == pytest.approx(
            other[joint].force, rel=1e-11, abs=1e-12, nan_ok=True
        )
        assert one[joint].moment == pytest.approx(
            other[joint].moment, rel=1e-11, abs=1e-12, nan_ok=True
        )


def test_many_torques_at_once() -> None:
    arm = load("two_link_arm")
    sides: tuple[Reference | Equations, ...]
    sides = Reference(arm), derive(arm, method="newton_euler")
    torques: Any = {"elbow": np.array([0.0, 1.0, 2.0])}
    for side in sides:
        found = side.acceleration([0.3, 0.4], [0, 0], tau=torques)
        assert found.shape == (3, 2)
        assert found[2] - found[1] == pytest.approx(found[1] - found[0], rel=1e-12)
        forces = side.reactions([0.3, 0.4], [0, 0], tau=np.array([[0.0, 1.0], [0.0, 2.0]]))[
            "elbow"
        ].force
        assert forces.shape == (2, 3)


@pytest.mark.parametrize(
    ("tau", "error", "message"),
    [
        ({"elbo": 1.0}, UnknownNameError, "did you mean 'elbow'"),
        ({"elbow": 1.0, "q2": 1.0}, InputError, "given twice, as 'elbow' and 'q2'"),
        ({"elbow": float("nan")}, InputError, "finite"),
        ([1.0], InputError, r"expected shape \(2,\)"),
        (3.0, InputError, r"expected shape \(2,\)"),
    ],
)
def test_wrong_torques_are_refused(tau: Given, error: type[Exception], message: str) -> None:
    arm = load("two_link_arm")
    for side in (Reference(arm), derive(arm)):
        with pytest.raises(error, match=message):
            side.acceleration([0.3, 0.4], [0, 0], tau=tau)


def test_a_joint_with_several_velocities_is_refused_by_its_name() -> None:
    with pytest.raises(InputError, match=r"joint 's' has 3 velocities; .* s_wx, s_wy, s_wz"):
        Reference(flyer()).acceleration(None, tau={"s": 1.0})
    with pytest.raises(InputError, match="what makes the forces on s_wx"):
        Reference(flyer()).reactions(None, tau={"s_wx": 1.0})


def test_torques_do_not_outlive_the_call() -> None:
    reference = Reference(load("two_link_arm"))
    before = reference.acceleration([0.3, 0.4], [0, 0])
    reference.acceleration([0.3, 0.4], [0, 0], tau={"elbow": 2.0})
    with pytest.raises(InputError):
        reference.acceleration([0.3, 0.4], [0, 0], tau={"elbow": np.inf})
    assert (reference.acceleration([0.3, 0.4], [0, 0]) == before).all()
