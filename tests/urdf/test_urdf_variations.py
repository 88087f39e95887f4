"""What is read can be varied: gravity, bodies, joints, mimics, damping, rotors, and letters."""

from __future__ import annotations

import sys
from typing import Any

import numpy as np
import pytest

import mecanique as mq
from mecanique.errors import InputError, MechanismError, UnknownNameError

ARM = """<robot name="arm">
  <link name="base"/>
  <link name="upper-arm"><inertial><origin xyz="0.1 0 -0.2" rpy="0.3 0 0.7"/><mass value="2"/>
    <inertia ixx="0.02" iyy="0.03" izz="0.04" ixy="0" ixz="0" iyz="0.001"/></inertial></link>
  <link name="fore"><inertial><origin xyz="0 0 -0.15"/><mass value="1.2"/>
    <inertia ixx="0.01" iyy="0.01" izz="0.002" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="hand"><inertial><origin xyz="0 0.02 -0.05"/><mass value="0.4"/>
    <inertia ixx="0.001" iyy="0.001" izz="0.001" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="shoulder" type="revolute"><origin xyz="0 0 1" rpy="0 0.5 0"/>
    <parent link="base"/><child link="upper-arm"/><axis xyz="0 1 0"/>
    <limit lower="-1" upper="2" effort="30" velocity="4"/><dynamics damping="0.3"/></joint>
  <joint name="elbow" type="continuous"><origin xyz="0 0.05 -0.4"/>
    <parent link="upper-arm"/><child link="fore"/><axis xyz="1 0 0"/>
    <dynamics damping="0.1"/></joint>
  <joint name="wrist" type="continuous"><origin xyz="0 0 -0.3"/>
    <parent link="fore"/><child link="hand"/><axis xyz="0 1 0"/>{more}</joint>
</robot>
"""
MIMIC = ARM.replace("{more}", '<mimic joint="elbow" multiplier="-0.5" offset="0.1"/>')
ARM = ARM.replace("{more}", "")
ALL = ("masses", "lengths", "inertias")


def dynamics(mechanism: mq.Mechanism, seed: int = 0) -> np.ndarray:
    rng, reference = np.random.default_rng(seed), mq.Reference(mechanism)
    q, v = rng.normal(size=(5, mechanism.nq)), rng.normal(size=(5, mechanism.nv))
    return np.concatenate(
        [
            np.reshape(reference.mass_matrix(q), (5, -1)),
            reference.bias(q, v),
            reference.forces(q, v),
        ],
        axis=1,
    )


def test_gravity_is_replaced_and_the_old_is_left() -> None:
    arm = mq.read_urdf(ARM)
    moon = arm.replace(gravity=(0, 0, -1.62))
    assert (moon.gravity, arm.gravity) == ((0.0, 0.0, -1.62), (0.0, 0.0, -9.81))
    assert moon == mq.read_urdf(ARM, gravity=(0, 0, -1.62))
    with pytest.raises(InputError, match=r"expected three components for gravity, got 9\.81"):
        arm.replace(gravity=9.81)


def test_a_parameter_called_gravity_is_meant_by_its_name() -> None:
    arm = mq.read_urdf(ARM).with_body("hand", mass=mq.Parameter("gravity", 0.7, "kg"))
    assert arm.replace(gravity=0.9).values == {"gravity": 0.9}


def test_a_body_is_changed_in_what_is_given_alone() -> None:
    arm = mq.read_urdf(ARM)
    before, after = arm.body("fore"), arm.with_body("fore", mass=3.0).body("fore")
    assert (after.mass, after.center, after.inertia) == (3.0, before.center, before.inertia)
    heavy = arm.with_body(
        "fore", mass=3.0, center=np.array([0, 0, -0.2]), inertia=np.array([2, 2, 1, 0, 0, 0])
    )
    whole = heavy.body("fore")
    assert (whole.mass, whole.center) == (3.0, (0.0, 0.0, -0.2))
    assert whole.inertia == (2.0, 2.0, 1.0, 0.0, 0.0, 0.0)
    text = ARM.replace('<mass value="1.2"/>', '<mass value="3"/>')
    np.testing.assert_array_equal(
        dynamics(arm.with_body("fore", mass=3)), dynamics(mq.read_urdf(text))
    )
    assert mq.verify(heavy, samples=5).agrees


@pytest.mark.parametrize(
    ("changes", "error", "message"),
    [
        ({"mass": 0}, InputError, "expected a mass above 0 for body 'fore', got 0"),
        ({"mass": -1.0}, MechanismError, r"body 'fore': its mass is negative \(-1 kg\)"),
        ({"mass": float("nan")}, MechanismError, "its mass or inertia is not finite"),
        ({"inertia": (1, 1, 3, 0, 0, 0)}, MechanismError, "break the triangle inequality"),
        ({"inertia": (1, 1, 1)}, InputError, "expected six entries ixx"),
        ({"center": (1, 1)}, InputError, "expected three components for center of mass"),
        ({"mass": mq.coordinate("m9")}, MechanismError, "depends on 'm9', which is not declared"),
    ],
)
def test_bodies_that_cannot_be_are_refused(
    changes: dict[str, Any], error: type[Exception], message: str
) -> None:
    with pytest.raises(error, match=message):
        mq.read_urdf(ARM).with_body("fore", **changes)


def test_unknown_names_are_refused_with_suggestions() -> None:
    arm = mq.read_urdf(ARM)
    with pytest.raises(UnknownNameError, match="unknown body 'for'; did you mean 'fore'"):
        arm.with_body("for", mass=1.0)
    with pytest.raises(UnknownNameError, match="unknown joint 'elbw'; did you mean 'elbow'"):
        arm.with_joint("elbw", damping=1.0)
    with pytest.raises(UnknownNameError, match="unknown parameter 'mass'; did you mean 'masses'"):
        mq.read_urdf(ARM, parameters="mass")
    with pytest.raises(UnknownNameError, match="unknown parameter 'm_for'; did you mean 'm_fore'"):
        mq.read_urdf(ARM, parameters=["m_for"])
    with pytest.raises(UnknownNameError, match="unknown joint 'elbw'"):
        mq.read_urdf(ARM, armature={"elbw": 1.0})


def test_a_joint_is_changed_in_what_is_given_alone() -> None:
    arm = mq.read_urdf(ARM)
    other = arm.with_joint(
        "shoulder", origin=(0, 0, 2), limits=(-2, 1), armature=0.5, axis=(0, 0, 3)
    )
    joint = other.joint("shoulder")
    assert isinstance(joint, mq.Revolute)
    assert (joint.origin.xyz, joint.origin.rpy) == ((0.0, 0.0, 2.0), (0.0, 0.5, 0.0))
    assert joint.limits == mq.Limits(-2, 1, 30, 4)
    assert (joint.armature, joint.axis) == (0.5, (0.0, 0.0, 1.0))
    placed = arm.with_joint("shoulder", origin=mq.Placement((0, 0, 2)), limits=mq.Limits())
    joint = placed.joint("shoulder")
    assert isinstance(joint, mq.Revolute)
    assert (joint.origin, joint.limits) == (mq.Placement((0, 0, 2)), mq.Limits())
    text = ARM.replace('damping="0.1"', 'damping="0.7"')
    assert arm.with_joint("elbow", damping=0.7) == mq.read_urdf(text)
    text = ARM.replace('<dynamics damping="0.1"/>', "")
    assert arm.with_joint("elbow", damping=0) == mq.read_urdf(text)
    assert mq.read_urdf(text).with_joint("elbow", damping=0.1).forces == arm.forces
    assert mq.verify(other, samples=5).agrees


@pytest.mark.parametrize(
    ("changes", "error", "message"),
    [
        ({"damping": -1.0}, MechanismError, "damping"),
        ({"armature": -1.0}, MechanismError, "its armature is negative"),
        ({"limits": (2, 1)}, MechanismError, "its lower limit 2 is not below its upper 1"),
        ({"limits": 3}, InputError, r"expected Limits or \(lower, upper\) for joint 'elbow'"),
        ({"origin": (1, 2)}, InputError, "expected three components for origin of joint 'elbow'"),
        ({"axis": (0, 0, 0)}, MechanismError, "expected an axis with a finite length"),
    ],
)
def test_joints_that_cannot_be_are_refused(
    changes: dict[str, Any], error: type[Exception], message: str
) -> None:
    with pytest.raises(error, match=message):
        mq.read_urdf(ARM).with_joint("elbow", **changes)


def test_a_joint_of_several_coordinates_has_no_one_damping() -> None:
    arm = mq.read_urdf(ARM, root="floating")
    with pytest.raises(
        InputError, match="expected a joint with one coordinate for damping, but 'root_joint' is Fl"
    ):
        arm.with_joint("root_joint", damping=1.0)
    with pytest.raises(InputError, match="expected a joint with an axis, but 'root_joint' is Fl"):
        arm.with_joint("root_joint", axis=(0, 0, 1))


def test_mimics_are_freed_in_the_order_of_the_joints() -> None:
    tied, free = mq.read_urdf(MIMIC), mq.read_urdf(ARM)
    assert tied.nq == 2
    assert tied.without_mimic() == free
    assert free.without_mimic() == free
    still = mq.read_urdf(MIMIC.replace('multiplier="-0.5"', 'multiplier="0"'))
    assert still.without_mimic() == free


def test_what_time_drives_and_a_screws_pitch_are_no_mimic() -> None:
    driven = mq.textbook.load("kapitza_pendulum")
    assert driven.without_mimic() == driven
    press = mq.textbook.load("screw_press").without_mimic()
    assert press.coordinates.driven.keys() == {"theta_travel"}


def test_damping_and_rotors_are_chosen_when_reading() -> None:
    assert mq.read_urdf(ARM, damping=False).forces == ()
    with pytest.raises(InputError, match="expected True or False for damping, got 0"):
        mq.read_urdf(ARM, damping=0)  # type: ignore[arg-type]  # on purpose
    M, heavier = (
        mq.Reference(mq.read_urdf(ARM, armature=armature)).mass_matrix([0.1, 0.2, 0.3])
        for armature in (None, 0.25)
    )
    np.testing.assert_allclose(heavier - M, 0.25 * np.eye(3), rtol=0, atol=1e-15)
    one = mq.read_urdf(ARM, armature={"elbow": 0.25})
    assert [joint.armature for joint in one.joints] == [0.0, 0.25, 0.0]  # type: ignore[union-attr]  # revolute
    with pytest.raises(MechanismError, match="joint 'shoulder': its armature is negative"):
        mq.read_urdf(ARM, armature=-1)


def test_letters_have_the_documented_names_units_and_values() -> None:
    arm = mq.read_urdf(ARM, parameters="masses")
    assert arm.values == {"m_upper_arm": 2.0, "m_fore": 1.2, "m_hand": 0.4}
    assert arm.parameters[0].meaning == "mass of 'upper-arm'"
    lengths = mq.read_urdf(ARM, parameters="lengths").values
    assert {"z_elbow": -0.4, "y_elbow": 0.05, "cz_fore": -0.15}.items() <= lengths.items()
    assert "x_elbow" not in lengths
    assert mq.read_urdf(ARM, parameters=["x_elbow"]).values == {"x_elbow": 0.0}
    inertias = mq.read_urdf(ARM, parameters=("inertias", "m_hand"))
    assert (inertias.values["Izz_fore"], inertias.values["m_hand"]) == (0.002, 0.4)
    assert {p.unit for p in inertias.parameters} == {"kg·m²", "kg"}


def test_letters_of_a_plain_urdf_need_no_xacro(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "xacro", None)  # as if it were not installed
    text = mq.write_urdf(mq.textbook.load("double_pendulum"))
    assert "m_rod1" in {p.symbol for p in mq.read_urdf(text, parameters="masses").parameters}


def test_a_letter_that_is_taken_gets_a_number() -> None:
    text = ARM.replace('"upper-arm"', '"upper_arm"').replace('"fore"', '"upper-arm"')
    values = mq.read_urdf(text, parameters="masses").values
    assert values == {"m_upper_arm": 2.0, "m_upper_arm_2": 1.2, "m_hand": 0.4}
    text = ARM.replace('"shoulder"', '"m_hand"')
    assert "m_hand_2" in mq.read_urdf(text, parameters="masses").values


@pytest.mark.parametrize("root", ["fixed", "floating"])
@pytest.mark.parametrize("source", [ARM, MIMIC, mq.robot("panda")], ids=["arm", "mimic", "panda"])
def test_with_letters_the_dynamics_are_those_with_numbers(source: Any, root: Any) -> None:
    numbers, letters = (mq.read_urdf(source, root=root, parameters=p) for p in ((), ALL))
    np.testing.assert_array_equal(dynamics(letters), dynamics(numbers))
    again = mq.read_urdf(mq.write_urdf(letters))
    assert again == mq.read_urdf(mq.write_urdf(numbers))
    rng = np.random.default_rng(1)
    q, v = letters.neutral(), rng.normal(size=letters.nv)
    derived, expected = mq.derive(letters), mq.derive(numbers)
    M, bias = expected.mass_matrix(q), expected.bias(q, v)
    np.testing.assert_allclose(derived.mass_matrix(q), M, rtol=1e-12, atol=1e-13 * np.abs(M).max())
    np.testing.assert_allclose(
        derived.bias(q, v), bias, rtol=1e-11, atol=1e-13 * np.abs(bias).max()
    )


def test_the_closed_form_shows_the_letters() -> None:
    arm = mq.read_urdf(ARM, parameters=["m_hand"], damping=False)
    equations = mq.derive(arm)
    assert "m_hand" in equations.text()
    assert mq.verify(arm, samples=5).agrees


def test_what_is_varied_by_a_letter_is_what_is_written_in_a_urdf() -> None:
    arm = mq.read_urdf(ARM, parameters=ALL).replace(m_fore=3.0, z_elbow=-0.5, Izz_hand=0.0015)
    text = ARM.replace('value="1.2"', 'value="3"').replace("0 0.05 -0.4", "0 0.05 -0.5")
    text = text.replace('iyy="0.001" izz="0.001"', 'iyy="0.001" izz="0.0015"')
    np.testing.assert_array_equal(dynamics(arm), dynamics(mq.read_urdf(text)))
    with pytest.raises(MechanismError, match="body 'fore': its mass is negative"):
        arm.replace(m_fore=-1.0)


def test_letters_are_swept() -> None:
    arm = mq.read_urdf(ARM, parameters="masses")
    masses = np.array([0.4, 0.8])
    runs = mq.simulate_many(arm, q={"elbow": 0.4}, parameters={"m_hand": masses}, duration=0.5)
    for k, mass in enumerate(masses):
        alone = mq.simulate(arm.with_body("hand", mass=mass), q={"elbow": 0.4}, duration=0.5)
        np.testing.assert_allclose(runs["elbow"][k, -1], alone["elbow"][-1], rtol=0, atol=1e-9)
