"""What guides may act on stays unknown, and torques that are given with a state act in joints."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
from systems import derive_system

import mecanique as mq
from mecanique.derivation import derive


def test_a_universal_joint_that_a_map_guides_transmits_no_moment_about_its_axes() -> None:
    """The first stands still in the parent, however the second turns the child."""
    cross = mq.Mechanism(
        "cross",
        (mq.Body("ground"), *(mq.Body(name, mq.ball(1.0, 0.1)) for name in ("arm", "slider"))),
        (
            mq.Universal("joint", "ground", "arm", names=("a", "b")),
            mq.Prismatic("rail", "ground", "slider", coordinate="x"),
        ),
        coordinates=mq.Coordinates(("a", "b"), {"x": mq.coordinate("a")}),
    )
    equations = derive(cross, "newton_euler")
    force, moment = equations.reactions({"a": 0.4, "b": 0.3}, None)["joint"]
    assert np.isnan(force).all()
    np.testing.assert_array_equal(np.isnan(moment), [False, True, True])
    # with what guides it the joint bears the weight of the arm
    total = equations.totals({"a": 0.4, "b": 0.3}, None)["joint"]
    np.testing.assert_allclose(total.force, [0, 0, 9.81], rtol=0, atol=1e-13)


@pytest.mark.parametrize("method", ["lagrange", "newton_euler", "virtual_work"])
@pytest.mark.parametrize("name", ["double_pendulum", "cart_pole"])
def test_torques_given_with_a_state_act_as_drives_do(name: str, method: str) -> None:
    """M a changes by them, whatever else acts; reactions bear what drives in the joints do."""
    mechanism = mq.textbook.load(name)
    joints = [joint for joint in mechanism.joints if joint.coordinates]
    pushes = {joint.name: 0.3 + k for k, joint in enumerate(joints)}
    tau = dict(zip((joint.coordinates[0] for joint in joints), pushes.values(), strict=True))
    drives = tuple(mq.JointForce(f"by {k}", k, push) for k, push in pushes.items())
    driven = replace(mechanism, forces=(*mechanism.forces, *drives))
    q, v = np.full(mechanism.nq, 0.4), np.full(mechanism.nv, 0.7)
    given, own = derive_system(name, method), derive(driven, method)
    np.testing.assert_allclose(
        given.acceleration(q, v, tau=tau), own.acceleration(q, v), rtol=1e-11, atol=1e-12
    )
    if method != "newton_euler":
        return
    expected = own.reactions(q, v)
    for joint, (force, moment) in given.reactions(q, v, tau=tau).items():
        np.testing.assert_allclose(force, expected[joint].force, rtol=0, atol=1e-11)
        np.testing.assert_allclose(moment, expected[joint].moment, rtol=0, atol=1e-11)


def test_what_guides_coordinates_does_no_work() -> None:
    """Of x = 2 s and z = s²: 2 S_x + 2 s S_z = 0, by the derivatives of both."""
    s = mq.coordinate("s")
    slides = (
        mq.Prismatic("slide", "ground", "a", axis=(1, 0, 0), coordinate="x"),
        mq.Prismatic("rise", "ground", "b", axis=(0, 0, 1), coordinate="z"),
    )
    bodies = mq.Body("ground"), *(mq.Body(name, mq.particle(1.3)) for name in "ab")
    guided = mq.Coordinates(("s",), {"x": 2 * s, "z": s**2})
    text = mq.derive(mq.Mechanism("pair", bodies, slides, coordinates=guided), "newton_euler").text(
        steps=True
    )
    (step,) = re.findall(r"Guided coordinates\n(.*?)\n\n", text, re.DOTALL)
    assert step.strip().startswith("The joint coordinates x, z follow the generalized coordinates.")
    assert step.splitlines()[-1].strip() == "2 S_slide_x + 2 s S_rise_z = 0"
    free = mq.derive(mq.Mechanism("pair", bodies, slides), "newton_euler").text(steps=True)
    assert "Guided coordinates" not in free
