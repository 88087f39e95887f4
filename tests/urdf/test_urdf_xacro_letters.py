"""Arguments and properties of a xacro file as parameters."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import sympy
from click.testing import CliRunner

import mecanique as mq
from mecanique.cli import app

pytest.importorskip("xacro")

ARM = """<robot name="arm" xmlns:xacro="http://www.ros.org/wiki/xacro">
<xacro:property name="L1" value="0.5"/>
<xacro:property name="m1" value="3.0"/>
<xacro:property name="tilt" value="0.2"/>
<xacro:property name="many" value="1"/>
<xacro:property name="word" value="a"/>
<xacro:property name="twice" value="1"/>
<xacro:property name="twice" value="${many + 1}"/>
<xacro:arg name="flag" default="1"/>
<xacro:if value="$(arg flag)"/>
<xacro:macro name="sided" params="n"><xacro:property name="side" value="${n}"/></xacro:macro>
<xacro:sided n="1"/>
<xacro:sided n="2"/>
<link name="base"/>
<link name="upper"><inertial><origin xyz="0 0 ${-L1/2}"/><mass value="${m1}"/>
<inertia ixx="${m1*L1*L1/12}" iyy="${m1*L1*L1/12}" izz="0" ixy="0" ixz="0" iyz="0"/></inertial>
</link>
<link name="lower"><inertial><origin xyz="0 0 -0.2"/><mass value="2"/>
<inertia ixx="0.03" iyy="0.03" izz="${0.01 + 0*sqrt(L1)}" ixy="0" ixz="0" iyz="0"/></inertial>
</link>
<joint name="q1" type="continuous"><origin xyz="0 0 0" rpy="0 ${tilt} 0"/>
<parent link="base"/><child link="upper"/><axis xyz="0 -1 0"/></joint>
<joint name="q2" type="continuous"><origin xyz="0 0 ${-L1}"/><parent link="upper"/>
<child link="lower"/><axis xyz="0 -1 0"/></joint>
<xacro:if value="${many > 1}"><link name="more"/><joint name="q3" type="fixed">
<parent link="base"/><child link="more"/></joint></xacro:if>
</robot>"""


@pytest.fixture
def arm(tmp_path: Path) -> Path:
    file = tmp_path / "arm.urdf.xacro"
    file.write_text(ARM, encoding="utf-8")
    return file


def test_numbers_are_the_polynomials_that_the_file_writes(arm: Path) -> None:
    kept = mq.read_urdf(arm, parameters=("L1", "m1"))
    assert {p.symbol: p.value for p in kept.parameters} == {"L1": 0.5, "m1": 3.0}
    upper = kept.body("upper")
    assert str(upper.inertia[0]) == "L1**2*m1/12"
    assert str(upper.center[2]) == "-L1/2"
    assert str(kept.joint("q2").origin.xyz[2]) == "-L1"
    assert not mq.read_urdf(arm).parameters
    # another value in the letters is the file with that value in it
    changed = arm.with_name("changed.urdf.xacro")
    text = ARM.replace('"L1" value="0.5"', '"L1" value="0.8"')
    changed.write_text(text.replace('"m1" value="3.0"', '"m1" value="1.5"'), encoding="utf-8")
    q, v = [0.3, -0.7], [1.0, 2.0]
    ours = mq.Reference(kept.replace(L1=0.8, m1=1.5))
    theirs = mq.Reference(mq.read_urdf(changed))
    assert np.allclose(ours.mass_matrix(q), theirs.mass_matrix(q), rtol=1e-12, atol=0)
    assert np.allclose(ours.bias(q, v), theirs.bias(q, v), rtol=1e-12, atol=0)
    assert mq.verify(kept, samples=2).agrees


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("tilt", "joint 'q1' depends on the value of tilt otherwise than by its place"),
        ("many", "which links there are depends on the value of many"),
        ("word", "'word' of the xacro file cannot be a letter: it is no number but 'a'"),
        ("twice", "cannot be a letter: it is defined more than once"),
        ("side", "cannot be a letter: it has several values: 1, 2"),
        ("flag", r"cannot be read with flag = 1\.0, so flag cannot be a letter: .* boolean"),
        ("L2", "unknown parameter 'L2'; did you mean 'L1'?"),
        ("xyz", "unknown parameter 'xyz'; known: L1, flag, m1, many, tilt, masses, lengths, "),
    ],
)
def test_what_cannot_be_a_letter_is_refused(arm: Path, name: str, said: str) -> None:
    with pytest.raises((mq.InputError, mq.UnknownNameError), match=said):
        mq.read_urdf(arm, parameters=(name,))


def test_what_is_no_polynomial_is_refused(arm: Path) -> None:
    arm.write_text(ARM.replace("${-L1/2}", "${-1/L1}"), encoding="utf-8")
    with pytest.raises(mq.InputError, match="z of link 'upper' is no polynomial of degree 6 in L1"):
        mq.read_urdf(arm, parameters="L1")


COMPUTED = """<robot name="arm" xmlns:xacro="http://www.ros.org/wiki/xacro">
<xacro:arg name="mass" default="2.0"/>
<xacro:include filename="sizes.xacro"/>
<xacro:property name="mass" value="$(arg mass)"/>
<xacro:property name="m1" value="${2*mass}"/>
<xacro:property name="half" value="${L1/2}"/>
<link name="base"/>
<link name="upper"><inertial><origin xyz="0 0 ${-half}"/><mass value="${m1}"/>
<inertia ixx="${m1*L1*L1/12}" iyy="${m1*L1*L1/12}" izz="0" ixy="0" ixz="0" iyz="0"/></inertial>
</link>
<joint name="q1" type="continuous">
<parent link="base"/><child link="upper"/><axis xyz="0 -1 0"/></joint>
</robot>"""

SIZES = """<robot xmlns:xacro="http://www.ros.org/wiki/xacro">
<xacro:property name="L1" value="0.5"/></robot>"""


@pytest.mark.parametrize(
    ("kept", "values", "mass", "inertia"),
    [
        # an argument, and the property that is that argument, are one letter
        (("mass",), {"mass": 2.0}, "2*mass", "mass/24"),
        # what is computed from an argument
        (("m1",), {"m1": 4.0}, "m1", "m1/48"),
        # what is written in an included file
        (("L1",), {"L1": 0.5}, "4.00000000000000", "L1**2/3"),
        # both the computed one and what it is computed from
        (("half", "L1"), {"half": 0.25, "L1": 0.5}, "4.00000000000000", "L1**2/3"),
    ],
)
def test_arguments_and_what_is_computed_from_them_are_letters(
    tmp_path: Path, kept: tuple[str, ...], values: dict[str, float], mass: str, inertia: str
) -> None:
    (tmp_path / "sizes.xacro").write_text(SIZES, encoding="utf-8")
    file = tmp_path / "arm.urdf.xacro"
    file.write_text(COMPUTED, encoding="utf-8")
    mechanism = mq.read_urdf(file, parameters=kept)
    assert {p.symbol: p.value for p in mechanism.parameters} == values
    upper = mechanism.body("upper")
    assert str(sympy.sympify(upper.mass)) == mass
    assert str(upper.inertia[0]) == inertia
    # in numbers it is what the file says
    ours, theirs = mq.Reference(mechanism), mq.Reference(mq.read_urdf(file))
    np.testing.assert_allclose(
        ours.bias([0.3], [1.0]), theirs.bias([0.3], [1.0]), rtol=1e-12, atol=0
    )


def test_an_argument_keeps_the_value_that_is_given(tmp_path: Path) -> None:
    (tmp_path / "sizes.xacro").write_text(SIZES, encoding="utf-8")
    file = tmp_path / "arm.urdf.xacro"
    file.write_text(COMPUTED, encoding="utf-8")
    mechanism = mq.read_urdf(file, parameters="mass", arguments={"mass": "3"})
    assert [(p.symbol, p.value) for p in mechanism.parameters] == [("mass", 3.0)]
    # an argument and a property that differ are not one letter
    file.write_text(COMPUTED.replace('"$(arg mass)"', '"${1 + $(arg mass)}"'), encoding="utf-8")
    with pytest.raises(mq.InputError, match=r"'mass' .* it has several values: 2, 3"):
        mq.read_urdf(file, parameters="mass")


def test_the_command_keeps_letters(arm: Path) -> None:
    run = CliRunner().invoke(app, ["derive", str(arm), "--keep", "L1,m1"])
    assert run.exit_code == 0, run.output
    assert "L1 (" in run.stdout
    robot = CliRunner().invoke(app, ["derive", "double_pendulum_simple", "--keep", "masses"])
    assert "m_link" in robot.stdout or "m_" in robot.stdout


def test_packages_that_robot_descriptions_has_fetched_are_found(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    text = """<robot name="r"><link name="a"><visual><geometry>
<mesh filename="package://arm_description/a.stl"/></geometry></visual></link></robot>"""
    monkeypatch.setenv("ROBOT_DESCRIPTIONS_CACHE", str(tmp_path / "none"))
    (lost,) = (finding for finding in mq.lint(text) if finding.code == "M501")
    assert lost.message == "its mesh file is not found in the empty search path"
    home = tmp_path / "cache" / "repository" / "robots" / "arm_description"
    home.mkdir(parents=True)
    (home / "a.stl").write_text("solid", encoding="utf-8")
    monkeypatch.setenv("ROBOT_DESCRIPTIONS_CACHE", str(tmp_path / "cache"))
    assert not [finding for finding in mq.lint(text) if finding.code == "M501"]
