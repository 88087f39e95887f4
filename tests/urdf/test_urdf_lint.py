"""Every rule of the linter: a text that triggers it, its line and words; a clean text, none."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path

import pytest

import mecanique as mq
from mecanique.model.mechanism.origin import Finding
from mecanique.urdf.lint import as_json, as_sarif, as_text, lint, mend
from mecanique.urdf.read import read_urdf
from mecanique.urdf.robots import robot, robots
from mecanique.urdf.rules import RULES

CLEAN = """<?xml version="1.0"?>
<robot name="clean" xmlns:drake="http://drake.mit.edu">
  <material name="red"><color rgba="1 0 0 1"/></material>
  <link name="base"/>
  <link name="arm">
    <inertial>
      <origin xyz="0 0 0.5" rpy="0 0 0"/>
      <mass value="1"/>
      <inertia ixx="0.084" iyy="0.084" izz="0.002" ixy="0" ixz="0" iyz="0"/>
    </inertial>
    <visual>
      <origin xyz="0 0 0.5"/>
      <geometry><box size="0.1 0.1 1"/></geometry>
      <material name="red"/>
    </visual>
  </link>
  <link name="hand">
    <inertial>
      <origin xyz="0 0 0.1"/>
      <mass value="0.5"/>
      <inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/>
    </inertial>
  </link>
  <joint name="shoulder" type="revolute">
    <origin xyz="0 0 0.2" rpy="0 0 0"/>
    <parent link="base"/>
    <child link="arm"/>
    <axis xyz="0 1 0"/>
    <limit lower="-1" upper="1" effort="10" velocity="5"/>
  </joint>
  <joint name="wrist" type="continuous">
    <origin xyz="0 0 1"/>
    <parent link="arm"/>
    <child link="hand"/>
    <axis xyz="0 0 1"/>
  </joint>
</robot>
"""

_END = "</robot>"
_WRIST_AXIS = '<axis xyz="0 0 1"/>'
_MASS = '<mass value="1"/>'
_INERTIA = 'ixx="0.084" iyy="0.084" izz="0.002"'
_BOX = '<geometry><box size="0.1 0.1 1"/></geometry>'
_MESH = '<geometry><mesh filename="{}"/></geometry>'
_SPRING = """<drake:linear_spring_damper>
  <drake:linear_spring_damper_body_A name="base"/><drake:linear_spring_damper_p_AP value="0 0 0"/>
  <drake:linear_spring_damper_body_B name="hand"/><drake:linear_spring_damper_p_BQ value="0 0 1"/>
  <drake:linear_spring_damper_free_length value="1"/>
  <drake:linear_spring_damper_stiffness value="8"/><drake:linear_spring_damper_damping value="0"/>
</drake:linear_spring_damper>
"""
_BUSHING = """<drake:linear_bushing_rpy>
  <drake:bushing_frameA name="base"/><drake:bushing_frameC name="arm"/>
  <drake:bushing_torque_stiffness value="1 1 1"/><drake:bushing_torque_damping value="0 0 0"/>
  <drake:bushing_force_stiffness value="0 0 0"/><drake:bushing_force_damping value="0 0 0"/>
</drake:linear_bushing_rpy>
"""
_ROLLING = '<mecanique:rolling name="r" link="arm" on="base" radius="0.1"/>'
_ROTOR = """<transmission name="t"><type>SimpleTransmission</type><joint name="shoulder"/>\
<actuator name="m">
  <drake:rotor_inertia value="0.1"/></actuator></transmission>
"""
_LOOSE = '<link name="{0}"/><link name="{1}"/>\n'
_JOINT = '<joint name="{0}" type="fixed"><parent link="{1}"/><child link="{2}"/></joint>\n'


def swap(old: str, new: str) -> str:
    assert old in CLEAN
    return CLEAN.replace(old, new, 1)


def add(text: str) -> str:
    return swap(_END, text + _END)


def wrist(more: str, kind: str = "continuous", axis: str = _WRIST_AXIS) -> str:
    return swap('type="continuous"', f'type="{kind}"').replace(_WRIST_AXIS, axis + more)


def chain(count: int) -> str:
    links = "".join(f'<link name="l{k}"/>' for k in range(count + 1))
    joints = "".join(
        _JOINT.format(f"j{k}", f"l{k - 1}" if k else "base", f"l{k}") for k in range(count + 1)
    )
    return add(links + joints)


def many(count: int) -> str:
    inertial = '<mass value="1"/>'
    '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>'
    links = "".join(
        f'<link name="l{k}"><inertial>{inertial}</inertial></link>' for k in range(count)
    )
    joints = "".join(_JOINT.format(f"j{k}", "base", f"l{k}") for k in range(count))
    return add(links + joints.replace('type="fixed">', f'type="continuous">{_WRIST_AXIS}'))


_MIMIC_AXIS = f'{_WRIST_AXIS}<mimic joint="shoulder" multiplier="2"/>'
_THIRD = (
    '<link name="third"><inertial><mass value="1"/>'
    '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>'
    "</inertial></link>\n"
    '<joint name="third" type="continuous"><parent link="hand"/>'
    '<child link="third"/><axis xyz="0 0 1"/>'
    '\n<mimic joint="wrist"/></joint>'
)
_BALL = '<drake:joint name="wrist" type="ball">'

_SIDES = "".join(
    f'<link name="{side}_hip"><inertial><mass value="{mass}"/>'
    '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>\n'
    f'<joint name="{side}_hip" type="fixed"><origin xyz="0 {y} 0"/><parent link="base"/>'
    f'<child link="{side}_hip"/></joint>\n'
    for side, mass, y in (("l", 1, 0.1), ("r", 2, -0.1))
)

CASES: dict[str, tuple[str, int, str]] = {
    "M001": ("missing.urdf", 1, "cannot be read: No such file"),
    "M002": (swap("<parent link", "<parent link link"), 26,
             "not well-formed XML: not well-formed (invalid token)"),
    "M003": (swap("<robot", '<!DOCTYPE a [<!ENTITY b "c">]>\n<robot'), 2,
             "document type or entity"),
    "M004": (swap("<robot", "<a>" * 70 + "<robot"), 2, "nested more than 64 deep"),
    "M005": ("<sdf/>", 1, "expected <robot> as the outermost element, got <sdf>"),
    "M006": (swap('<mass value="1"', '<mass value="${m}"'), 8, "got '${m}'"),
    "M007": (swap("<?xml", "\n<?xml"), 2, "begins with blanks before its <?xml … ?>"),
    "M101": (swap(' name="clean"', ""), 2, "the robot has no name"),
    "M102": ('<robot name="empty">\n</robot>', 1, "the robot has no link"),
    "M103": (swap('<mass value="1"', "<mass"), 8, "<mass> has no value=…"),
    "M104": (swap('value="1"', 'value="1,5"'), 8,
             "expected a finite number for value of <mass>, got '1,5'"),
    "M105": (swap('link name="base"', 'link name=" "'), 4,
             "expected a printable name of <link>, got ' '"),
    "M106": (swap('<link name="hand">', '<link name="arm">'), 17, "it is there already at line 5"),
    "M107": (swap('parent link="arm"', 'parent link="Arm"'), 31, "its parent 'Arm' is no link"),
    "M108": (swap('parent link="arm"', 'parent link="hand"'), 31, "it joins link 'hand' to itself"),
    "M109": (add(_JOINT.format("x", "base", "hand")), 37,
             "is the child of joint 'wrist' at line 31 already"),
    "M110": (
        add(_LOOSE.format("a", "b") + _JOINT.format("x", "a", "b") + _JOINT.format("y", "b", "a")),
        37,
        "it hangs on itself: a ← b ← a",
    ),
    "M111": (add('<link name="lost"/>'), 37, "it is no joint's child, and neither is link 'base'"),
    "M112": (swap(_MASS, _MASS + "\n" + _MASS), 9, "<inertial> has 2 <mass>"),
    "M113": (swap('<origin xyz="0 0 0.2"', '<orgin xyz="0 0 0.2"'), 25,
             "ignored; did you mean 'origin'?"),
    "M114": (swap('joint name="wrist"', 'joint name="universe"'), 31,
             "Pinocchio has a joint of this name"),
    "M116": (swap('value="1"', 'value="1\n"'), 8,
             r"value of <mass> is '1\n': Pinocchio and ROS silently drop the whole <inertial>"),
    "M201": (swap('value="1"', 'value="-1"'), 8, "its mass is -1 kg"),
    "M202": (swap(_INERTIA, 'ixx="-0.1" iyy="1" izz="1"'), 9, "negative principal moment"),
    "M203": (swap(_INERTIA, 'ixx="0.1" iyy="0.2" izz="0.4"'), 9,
             "triangle inequality (0.1 + 0.2 < 0.4"),
    "M204": (swap('value="1"', 'value="0"'), 5, "it has inertia but no mass"),
    "M205": (swap(_INERTIA, 'ixx="0" iyy="0" izz="0"'), 5, "a mass without inertia"),
    "M206": (add('<link name="tip"/><joint name="x" type="continuous"><axis xyz="0 0 1"/>'
                 '<parent link="hand"/>'
                 '<child link="tip"/></joint>'), 37, "it moves nothing that has mass"),
    "M207": (swap('value="1"', 'value="1e-17"').replace(_INERTIA, 'ixx="0" iyy="0" izz="0"'), 5,
             "its mass is 1e-17"),
    "M208": (swap(_INERTIA, 'ixx="84" iyy="84" izz="2"'), 5,
             "9.22 m away from the center, but it is 1 m large"),
    "M209": (
        swap(
            "  </link>\n  <link name=\"hand\"",
            f'<collision>{_BOX}</collision></link>\n  <link name="hand"',
        ).replace(
            'value="1"', 'value="1000"'
        ).replace(_INERTIA, 'ixx="84" iyy="84" izz="2"'),
        5,
        "its density is 1e+05 kg/m³",
    ),
    "M210": (swap('ixx="0.084" iyy="0.084"', 'ixx="0.334" iyy="0.334"'), 5,
             "about the link's origin instead of"),
    "M211": (swap('<link name="base"/>', f'<link name="base"><inertial>{_MASS}'
                  f'<inertia {_INERTIA} ixy="0" ixz="0" '
                  'iyz="0"/></inertial></link>'), 4, "the root link has a mass of 1 kg"),
    "M212": (add(_SIDES), 39, "it is not link 'l_hip' mirrored: 2 kg, not 1 kg"),
    "M213": (swap('<origin xyz="0 0 0.5"/>', '<origin xyz="0 0 500"/>'), 5,
             "its center of mass lies 4.99e+05 mm outside of its shape"),
    "M214": (swap('<mass value="1"', '<mass value="0.001"').replace(
        _INERTIA, 'ixx="0.000084" iyy="0.000084" izz="0.000002"'), 5, "its density would be 0.1"),
    "M301": (wrist("", "hinge"), 31, "expected a type among revolute"),
    "M302": (wrist("", axis='<axis xyz="0 0 0"/>'), 35, "its axis '0 0 0' has no length"),
    "M303": (wrist("", axis='<axis xyz="0 0 2"/>'), 35, "its axis '0 0 2' has the length 2"),
    "M304": (wrist("", axis=""), 31, "it has no <axis>, which means 1 0 0"),
    "M305": (wrist("", "planar", '<axis xyz="0 1 0"/>'), 31, "the normal of its plane is 0 1 0"),
    "M306": (swap('lower="-1"', 'lower="2"'), 29, "its lower limit 2 is above its upper limit 1"),
    "M307": (swap(' effort="10"', ""), 29, "<limit> has no effort; it is read as unbounded"),
    "M308": (swap('lower="-1" upper="1" ', ""), 29, "lets it move from 0 to 0"),
    "M309": (swap('lower="-1" upper="1"', 'lower="-90" upper="90"'), 24,
             "its limits reach 90 radians"),
    "M310": (swap('xyz="0 0 0.2"', 'xyz="0 0 200"'), 24, "its origin is 200 m away"),
    "M311": (wrist('<dynamics damping="-1"/>'), 35, "its damping is -1"),
    "M312": (wrist('<dynamics damping="1"/>', "floating"), 35,
             "the damping of a floating joint is not modeled"),
    "M313": (wrist('<dynamics friction="1"/>'), 31, "dry friction is left out"),
    "M314": (
        CLEAN.replace('<joint name="wrist"', '<drake:joint name="wrist"').replace(
            f"{_WRIST_AXIS}\n  </joint>", f"{_WRIST_AXIS}\n  </drake:joint>"
        ),
        31,
        "the type 'continuous' belongs into <joint>",
    ),
    "M401": (wrist('<mimic joint="elbow"/>'), 35, "it mimics 'elbow', which is no joint"),
    "M402": (wrist('<mimic joint="wrist"/>'), 35, "cycle: wrist → wrist"),
    "M403": (wrist('<mimic joint="shoulder"/>', "floating"), 35,
             "a floating joint cannot mimic another"),
    "M404": (wrist('<mimic joint="shoulder"/>'), 31, "it mimics another joint"),
    "M405": (swap(_WRIST_AXIS, _MIMIC_AXIS).replace(_END, _THIRD + _END), 39,
             "'wrist', which mimics 'should"),
    "M406": (wrist('<mimic joint="shoulder" multiplier="0"/>'), 35, "multiplier 0"),
    "M407": (wrist('<mimic joint="shoulder"/>', "fixed"), 35, "it is fixed and mimics 'shoulder'"),
    "M501": (swap(_BOX, _MESH.format("package://a/b.stl")), 13, "its mesh file is not found"),
    "M502": (swap(_BOX, _MESH.format("package://a/../../b.stl")), 13,
             "'package://a/../../b.stl' lies outside"),
    "M503": (swap(_BOX, "<geometry/>"), 13, "the shape of a <visual> is missing"),
    "M504": (swap("0.1 0.1 1", "0.1 0 1"), 13, "expected positive sizes of a <box>"),
    "M505": (swap('<material name="red"/>', '<material name="blue"/>'), 14,
             "the material 'blue' is not described"),
    "M506": (swap("1 0 0 1", "255 0 0 1"), 3, "expected colors from 0 to 1"),
    "M507": (swap("<visual>", f"<collision>{_BOX}</collision><visual>"), 5,
             "collisions are not modeled"),
    "M601": (add("<drake:spring/>"), 37, "<drake:spring> in <robot> is not known"),
    "M602": (add(_SPRING.replace('stiffness value="8"', 'stiffness value="-8"')), 41,
             "stiffness of at least 0"),
    "M603": (add(_SPRING.replace('"hand"', '"foot"')), 37, "'foot' is no link"),
    "M604": (add("<drake:tendon_constraint/>"), 37, "<drake:tendon_constraint> is not modeled"),
    "M605": (add(_BUSHING), 37, "do not coincide on the axis of joint 'shoulder'"),
    "M606": (add(_SPRING), 37, "only Drake and mecanique read it"),
    "M607": (add(_SPRING).replace(' xmlns:drake="http://drake.mit.edu"', ""), 37,
             "prefix drake: is used but not"),
    "M608": (add(_ROTOR), 38, "a rotor adds inertia"),
    "M609": (add(_SPRING.replace('free_length value="1"', 'free_length value="0"')), 37,
             "Drake refuses a spring"),
    "M610": (add(_ROLLING), 37, "only mecanique reads it"),
    "M701": (many(250), 2, "the robot has 252 velocities"),
    "M702": (chain(1100), 2, "the longest chain has 1101 joints"),
    "M703": (add("<gazebo/>"), 37, "<gazebo> in <robot> is not used"),
    "M704": (wrist('<dynamics damping="1"/>'), 31, "damping is applied"),
    "M705": (swap('name="clean"', 'name="clean" version="1.2"'), 2, "the version is '1.2'"),
    "M706": (wrist("", "floating"), 31, "its type is read differently"),
}  # fmt: skip


def test_a_clean_file_has_no_findings() -> None:
    assert lint(CLEAN) == ()


def test_every_rule_has_a_case() -> None:
    # found in files alone: M008 in test_urdf_xacro.py, M508 in test_urdf_solids.py
    assert {*CASES, "M008", "M115", "M508"} == set(RULES)


@pytest.mark.parametrize("code", CASES)
def test_rule(code: str) -> None:
    text, line, words = CASES[code]
    found = [finding for finding in lint(text) if finding.code == code]
    assert found, [str(finding) for finding in lint(text)]
    assert (found[0].line, found[0].severity) == (line, RULES[code].severity)
    assert words in found[0].message
    assert found[0].why
    assert found[0].remedy


@pytest.mark.parametrize("code", CASES)
def test_errors_are_what_the_reader_refuses(code: str) -> None:
    text, line, words = CASES[code]
    errors = [finding for finding in lint(text) if finding.severity == "error"]
    if errors:
        with pytest.raises(mq.UrdfError) as caught:
            read_urdf(text, strict=True)
        assert all(finding.message in str(caught.value) for finding in errors)
    if any(finding.stops for finding in errors):
        with pytest.raises(mq.UrdfError) as caught:
            read_urdf(text)
        assert all(finding.message in str(caught.value) for finding in errors)
    else:
        origin = read_urdf(text).origin
        assert origin is not None
        assert list(origin.flaws) == errors
    if RULES[code].severity == "error":
        with pytest.raises(mq.UrdfError, match=f"(?s){line}: .*{re.escape(words)}"):
            read_urdf(text, strict=True)


def test_what_only_the_model_refuses_is_told_too(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object, **__: object) -> None:
        raise mq.MechanismError("clean", ["body 'arm' is odd"])

    monkeypatch.setattr("mecanique.urdf.read.Mechanism", refuse)
    assert [(f.code, f.line, f.message) for f in lint(CLEAN)] == [("M115", 2, "body 'arm' is odd")]


def test_misplaced_and_misspelt_words() -> None:
    def messages(text: str) -> list[str]:
        return [f.message for f in lint(text) if f.code == "M113"]

    assert messages(swap('<link name="base"/>', '<link name="base"><mass value="1"/></link>')) == [
        "<mass> has no meaning in <link>; it is ignored"
    ]
    assert messages(swap('lower="-1"', 'lowwer="-1"')) == [
        "lowwer=… of <limit> is ignored; did you mean 'lower'?"
    ]
    assert messages(swap('<origin xyz="0 0 1"/>', '<origin XYZ="0 0 1"/>')) == [
        "XYZ=… of <origin> is ignored; did you mean 'xyz'?"
    ]


def test_point_mass_on_its_axis_does_not_resist() -> None:
    text = swap('ixx="0.01" iyy="0.01" izz="0.01"', 'ixx="0" iyy="0" izz="0"')
    assert [f.message for f in lint(text) if f.code == "M206"] == [
        "link 'hand' does not resist this motion"
    ]
    assert not [
        f for f in lint(text.replace('xyz="0 0 0.1"', 'xyz="0.1 0 0.1"')) if f.code == "M206"
    ]


ROD = """<robot name="a"><link name="base"/><link name="rod"><inertial><mass value="1"/>
<inertia ixx="0.1" iyy="0.1" izz="0" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="j" type="continuous"><parent link="base"/><child link="rod"/><axis xyz="0 0 1"/>
</joint></robot>"""
TIP = """<link name="tip"><inertial><mass value="{}"/></inertial></link>
<joint name="weld" type="fixed"><parent link="rod"/><child link="tip"/><origin xyz="{} 0 1"/>
</joint></robot>"""


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda text: text, "link 'rod' does not resist this motion"),
        (lambda text: text.replace('izz="0"', 'izz="1e-9"'), None),
        (lambda text: text.replace('"0 0 1"', '"0 0.6 0.8"'), None),
        (
            lambda text: text.replace("</robot>", TIP.format(2, 0)),
            "links 'rod' and 'tip' do not resist this motion",
        ),
        (lambda text: text.replace("</robot>", TIP.format(2, 0.1)), None),
        (lambda text: text.replace("continuous", "prismatic"), None),
        (lambda text: text.replace("continuous", "floating"), "link 'rod' does not resist"),
        (lambda text: text.replace("continuous", "planar"), "link 'rod' does not resist"),
    ],
)
def test_a_rod_about_its_own_axis_does_not_resist(
    change: Callable[[str], str], said: str | None
) -> None:
    found = [f.message for f in lint(change(ROD)) if f.code == "M206"]
    assert len(found) == (said is not None)
    assert not said or said in found[0]


def test_a_mass_that_no_motion_meets_is_named() -> None:
    with pytest.raises(mq.EngineError, match="its bodies have mass, but none resists"):
        mq.verify(mq.read_urdf(ROD))


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("<!DOCTYPE html>\n<html><head></head></html>", "the file is a web page"),
        ('<?xml version="1.0"?>\n<!DOCTYPE HTML PUBLIC "-//W3C"><html>', "the file is a web page"),
        ("<!-- saved --><html><br></html>", "the file is a web page"),
        ("version https://git-lfs.github.com/spec/v1\noid", "the file is a pointer of Git LFS"),
        ("PK\x03\x04abc", "the file is a zip archive"),
        ("\x1f\x8b\x08abc", "the file is compressed by gzip"),
    ],
)
def test_files_that_are_something_else_are_called_so(tmp_path: Path, text: str, said: str) -> None:
    path = tmp_path / "robot.urdf"
    path.write_bytes(text.encode("latin-1"))
    (finding,) = lint(path)
    assert finding.code == "M005"
    assert finding.why == "It describes no robot."  # nor MJCF or SDF, for which it is asked for
    assert finding.message.startswith(said)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("<mujocoinclude/>", "this is a part of MJCF; name the file that includes it"),
        ("<gazebo/>", "this is SDF before 1.3, which is not read"),
        ("<launch/>", "got <launch>. Name a file whose outermost element is <robot>, or in other"),
        ('<!DOCTYPE m [<!ENTITY a "b">]><mujoco/>', "no description needs one"),
    ],
)
def test_what_describes_no_robot_is_told_in_words_of_all_formats(text: str, said: str) -> None:
    with pytest.raises(mq.UrdfError, match=re.escape(said)):
        mq.read(text)


def test_mass_at_the_origin_with_inertia_about_elsewhere() -> None:
    text = swap('ixx="0.084" iyy="0.084"', 'ixx="0.334" iyy="0.334"').replace(
        'xyz="0 0 0.5" rpy="0 0 0"', 'xyz="0 0 0"'
    )
    assert [f.message for f in lint(text)] == [
        "its mass is at its origin, but its inertia is that of its shape, whose center is elsewhere"
    ]


def test_lint_refuses_what_is_neither_path_nor_text() -> None:
    with pytest.raises(mq.InputError, match="path of a URDF file or its text, got None"):
        lint(None)  # type: ignore[arg-type]  # it is the refusal that is tested


def test_files_are_named(tmp_path: Path) -> None:
    file = tmp_path / "arm.urdf"
    file.write_text(CASES["M303"][0], encoding="utf-8")
    (finding,) = lint(file)
    assert (
        str(finding) == f"{file}:35: warning M303 joint 'wrist': its axis '0 0 2' has the length 2"
    )


MENDED = {
    "M101": (' name="clean"', ""),
    "M103": (
        ' ixy="0" ixz="0" iyz="0"/>\n    </inertial>\n    <visual>',
        "/>\n    </inertial>\n    <visual>",
    ),
    "M303": (_WRIST_AXIS, '<axis xyz = "0 0 3" />'),
    "M304": (_WRIST_AXIS, ""),
    "M116": ('xyz="0 0 0.2"', 'xyz="0\t0 0.2 "'),
    "M607": (' xmlns:drake="http://drake.mit.edu"', ""),
}


@pytest.mark.parametrize("code", MENDED)
def test_mend(code: str) -> None:
    text = add(_SPRING)
    before = {f.code for f in lint(text)}
    old, new = MENDED[code]
    broken = text.replace(old, new, 1)
    assert broken != text
    assert {f.code for f in lint(broken)} - before == {code}
    mended = mend(broken)
    assert {f.code for f in lint(mended)} == before
    assert mend(mended) == mended


def test_mend_keeps_the_meaning_and_all_else() -> None:
    text = CASES["M303"][0].replace("<link", "<!-- ä > ' \" -->\n<link", 1)
    mended = mend(text)
    assert mended == text.replace('"0 0 2"', '"0 0 1"')
    assert read_urdf(mended) == read_urdf(text)
    assert mend(CASES["M304"][0]).count('<axis xyz="1 0 0"/>') == 1
    assert read_urdf(mend(CASES["M304"][0])) == read_urdf(CASES["M304"][0])
    assert mend(CLEAN) == CLEAN


def test_mend_leaves_what_it_cannot_read() -> None:
    for text in ("<robot", "<sdf/>", "", "no xml", CASES["M003"][0]):
        assert mend(text) == text


def test_mend_names_a_robot() -> None:
    mended = mend('<robot ><link name="a"/></robot>', name='it\'s "a" <robot>')
    assert read_urdf(mended).name == 'it\'s "a" <robot>'


def _findings() -> tuple[Finding, ...]:
    return lint(CASES["M601"][0].replace('value="1"', 'value="-1"'))


def test_text_output() -> None:
    lines = as_text(_findings()).splitlines()
    assert lines[0] == "<text>:8: error M201 link 'arm': its mass is -1 kg"
    assert lines[1] == "    No body weighs less than nothing. Give a mass of at least 0 kg."
    assert lines[-1] == "1 error, 1 warning"
    assert as_text(()) == "nothing found"


def test_json_output() -> None:
    rows = json.loads(as_json(_findings()))["findings"]
    assert [(row["code"], row["name"], row["line"]) for row in rows] == [
        ("M201", "negative-mass", 8),
        ("M601", "unknown-drake-tag", 37),
    ]
    assert set(rows[0]) == {
        "code",
        "name",
        "severity",
        "file",
        "line",
        "where",
        "message",
        "why",
        "remedy",
        "stops",
    }


def test_sarif_output(tmp_path: Path) -> None:
    log = json.loads(as_sarif(_findings()))
    assert log["version"] == "2.1.0"
    (run,) = log["runs"]
    rules = run["tool"]["driver"]["rules"]
    assert [rule["id"] for rule in rules] == ["M201", "M601"]
    for result in run["results"]:
        assert rules[result["ruleIndex"]]["id"] == result["ruleId"]
        assert result["level"] in ("error", "warning", "note")
        assert result["locations"][0]["physicalLocation"]["region"]["startLine"] >= 1
    assert run["results"][0]["locations"][0]["logicalLocations"][0]["name"] == "link 'arm'"
    file = tmp_path / "ein arm.urdf"
    file.write_text(CASES["M303"][0], encoding="utf-8")
    (result,) = json.loads(as_sarif(lint(file)))["runs"][0]["results"]
    uri = result["locations"][0]["physicalLocation"]["artifactLocation"]["uri"]
    assert uri == f"file://{tmp_path}/ein%20arm.urdf"


def test_every_robot_is_linted() -> None:
    refused = [
        name
        for name in robots()
        if any(finding.severity == "error" for finding in lint(robot(name)))
    ]
    assert len(robots()) == 69
    assert len(refused) == 17


REDUCED = "<mechanicalReduction>50</mechanicalReduction>"


@pytest.mark.parametrize(
    ("inside", "line", "armature"),
    [
        (
            "<mechanicalReduction>50</mechanicalReduction>\n<rotorInertia>2e-4</rotorInertia>",
            39,
            0.5,
        ),
        ("<motor_inertia value='0.3'/>", 38, 0.3),
        (
            "<drake:rotor_inertia value='2e-4'/><mechanicalReduction>50</mechanicalReduction>",
            38,
            0.5,
        ),
    ],
)
def test_rotors_of_other_tags_are_pointed_to(inside: str, line: int, armature: float) -> None:
    drive = f'<joint name="wrist"/>\n<actuator name="m">{inside}</actuator>'
    text = add(f'<transmission name="t" type="SimpleTransmission">{drive}</transmission>')
    findings = [f for f in lint(text) if f.code == "M601"]
    (finding,) = [f for f in findings if "is not read" in f.message]
    assert finding.line == line
    assert finding.where == "transmission 't'"
    assert f"joint 'wrist' has an armature of {armature:g}" in finding.message
    assert f"armature={{'wrist': {armature:g}}}" in finding.remedy


def test_drakes_rotor_with_its_gear_needs_no_pointer() -> None:
    inside = "<drake:rotor_inertia value='2e-4'/><drake:gear_ratio value='5'/>"
    drive = f'<joint name="wrist"/><actuator name="m">{inside}</actuator>'
    text = add(f'<transmission name="t" type="SimpleTransmission">{drive}</transmission>')
    assert not [f for f in lint(text) if "armature" in f.message]
