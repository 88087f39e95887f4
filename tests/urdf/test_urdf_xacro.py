"""Xacro files, and the packages that they and meshes lie in."""

from __future__ import annotations

import os
import re
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path

import pytest
from click.testing import CliRunner

import mecanique as mq
from mecanique.cli import app
from mecanique.urdf import read_urdf
from mecanique.urdf.lint import lint
from mecanique.urdf.reading import xacro

pytest.importorskip("xacro")

MACRO = """<robot xmlns:xacro="http://www.ros.org/wiki/xacro">
<xacro:macro name="rod" params="name m l">
  <link name="${name}"><inertial><origin xyz="0 0 ${-l/2}"/><mass value="${m}"/>
  <inertia ixx="${m*l*l/12}" iyy="${m*l*l/12}" izz="0" ixy="0" ixz="0" iyz="0"/></inertial></link>
</xacro:macro></robot>"""
ARM = """<robot name="arm" xmlns:xacro="http://www.ros.org/wiki/xacro">
<xacro:include filename="$(find rods)/rod.xacro"/>
<xacro:arg name="length" default="0.5"/>
<link name="base"/>
<xacro:rod name="bar" m="3.0" l="${$(arg length)}"/>
<joint name="q" type="continuous"><parent link="base"/><child link="bar"/>
<axis xyz="0 1 0"/></joint>
</robot>"""


@pytest.fixture
def arm(tmp_path: Path) -> Path:
    rods = tmp_path / "elsewhere" / "rods"
    rods.mkdir(parents=True)
    (rods / "rod.xacro").write_text(MACRO, encoding="utf-8")
    (tmp_path / "here").mkdir()
    file = tmp_path / "here" / "arm.urdf.xacro"
    file.write_text(ARM, encoding="utf-8")
    return file


def test_a_xacro_file_is_read_with_its_arguments(arm: Path) -> None:
    """A bar's inertia about its end is m l²/3."""
    path = arm.parents[1] / "elsewhere"
    for length in (0.5, 2.0):
        arguments = {} if length == 0.5 else {"length": str(length)}
        mechanism = read_urdf(arm, package_path=path, arguments=arguments)
        assert mq.Reference(mechanism).mass_matrix({"q": 0.3})[0, 0] == pytest.approx(
            length**2, rel=1e-12
        )
    assert mq.verify(mechanism, samples=3).agrees


def test_a_browser_expands_it_without_a_process(arm: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = arm.parents[1] / "elsewhere"
    usual = read_urdf(arm, package_path=path, arguments={"length": "2"})

    def ask(*_: object) -> None:
        raise OSError("emscripten does not support processes.")

    monkeypatch.setattr(xacro, "_ask", ask)
    with pytest.raises(mq.UrdfError, match="xacro needs a process of its own: emscripten does not"):
        read_urdf(arm, package_path=path)
    monkeypatch.setattr("sys.platform", "emscripten")
    assert read_urdf(arm, package_path=path, arguments={"length": "2"}) == usual


def test_a_package_that_is_not_found_is_told_with_where(
    arm: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with pytest.raises(mq.UrdfError, match=r"package 'rods' is not found in .*here and above"):
        read_urdf(arm)
    (finding,) = lint(arm)
    assert finding.code == "M006"
    # the library says it twice, with the type of the error
    assert finding.message.startswith("xacro does not expand it: package 'rods' is not found in")
    assert finding.message.count("rods") == 1
    assert "Add its folder to --package-path" in finding.remedy
    prefix = arm.parents[1] / "prefix"
    prefix.mkdir()
    (arm.parents[1] / "elsewhere").rename(prefix / "share")
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(prefix))
    assert read_urdf(arm).name == "arm"


def test_findings_point_at_the_lines_that_someone_wrote(
    arm: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The bar's inertia is in the macro, its joint in the file; the expanded text is in neither."""
    rods = arm.parents[1] / "elsewhere"
    macro = rods / "rods" / "rod.xacro"
    macro.write_text(MACRO.replace('izz="0"', 'izz="9"'), encoding="utf-8")
    rubbing = ARM.replace('xyz="0 1 0"/>', 'xyz="0 1 0"/><dynamics friction="1"/>')
    arm.write_text(rubbing, encoding="utf-8")
    found = {finding.code: finding for finding in lint(arm, package_path=rods)}
    assert (found["M203"].line, Path(found["M203"].file)) == (4, macro)
    assert (found["M313"].line, Path(found["M313"].file)) == (6, arm)
    mechanism = read_urdf(arm, package_path=rods)
    assert mechanism.origin is not None
    assert [flaw.line for flaw in mechanism.origin.flaws] == [4]
    assert b"mecanique" not in mechanism.origin.text
    with pytest.raises(mq.UrdfError, match=r"rod\.xacro:4: .*triangle"):
        read_urdf(arm, package_path=rods, strict=True)
    # what is included from beside the file is shown beside it
    (arm.parent / "rod.xacro").write_text(macro.read_text(encoding="utf-8"), encoding="utf-8")
    arm.write_text(ARM.replace("$(find rods)/", ""), encoding="utf-8")
    monkeypatch.chdir(arm.parent)
    (one,) = [finding for finding in lint("arm.urdf.xacro") if finding.code == "M203"]
    assert (one.file, one.line) == ("rod.xacro", 4)


def test_a_text_in_another_encoding_keeps_its_lines_to_itself(arm: Path) -> None:
    text = '<?xml version="1.0" encoding="latin-1"?>\n<!-- Länge -->' + ARM
    arm.write_bytes(text.encode("latin-1"))
    rods = arm.parents[1] / "elsewhere"
    assert list(read_urdf(arm, package_path=rods).coordinates) == ["q"]


def test_a_folder_is_the_package_that_its_package_xml_names(arm: Path) -> None:
    home = arm.parent
    (home / "package.xml").write_text("<package><name> rods </name></package>", encoding="utf-8")
    (home / "rod.xacro").write_text(MACRO, encoding="utf-8")
    assert read_urdf(arm).name == "arm"


HEAD = '<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">'


def test_a_file_of_macros_alone_is_called_so(arm: Path) -> None:
    arm.write_text(f'{HEAD}<xacro:macro name="leg" params="a"/></robot>', encoding="utf-8")
    said = r"it defines macros alone \(leg\) and calls none. Name a file that calls them"
    with pytest.raises(mq.UrdfError, match=said):
        read_urdf(arm)


def test_all_arguments_without_a_value_are_named_at_once(arm: Path) -> None:
    text = f'{HEAD}\n<xacro:arg name="a" default="1"/><link name="$(arg b)$(arg a)"/>\n'
    text += '<xacro:arg name="c"/><link name="$(arg d)"/></robot>'
    arm.write_text(text, encoding="utf-8")
    with pytest.raises(mq.UrdfError) as caught:
        read_urdf(arm, arguments={"d": "1"})
    assert "2 arguments without a value: b, c. Give --arg b=VALUE --arg c=VALUE" in str(
        caught.value
    )
    (finding,) = [f for f in lint(arm) if f.code == "M006"]
    assert finding.line == 2
    assert "b, c, d" in finding.message


def test_an_error_of_xacro_has_the_line_of_what_it_evaluates(arm: Path) -> None:
    text = f'{HEAD}\n<xacro:macro name="leg" params="n">\n<link name="${{n}}"/>\n'
    text += '<link name="b${nothing}"/></xacro:macro>\n<xacro:leg n="x"/></robot>'
    arm.write_text(text, encoding="utf-8")
    (finding,) = lint(arm)
    assert (finding.code, finding.line, Path(finding.file)) == ("M006", 4, arm)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        ('<xacro:nothing n="y"/>', "unknown macro name: xacro:nothing. Correct the call"),
        ("<xacro:leg/>", "Undefined parameters [n]. Correct the call"),
        ('<xacro:leg n="y" z="3"/>', 'Invalid parameter "z". Correct the call'),
        ('<xacro:include filename="lost.xacro"/>', "No such file or directory"),
    ],
)
def test_a_call_that_xacro_refuses_has_its_own_line(arm: Path, call: str, message: str) -> None:
    text = f'{HEAD}\n<xacro:macro name="leg" params="n">\n<link name="${{n}}"/></xacro:macro>\n'
    arm.write_text(f'{text}<xacro:leg n="x"/>\n{call}\n</robot>', encoding="utf-8")
    with pytest.raises(mq.UrdfError, match=re.escape(message)) as refused:
        read_urdf(arm)
    assert (refused.value.line, Path(str(refused.value.file))) == (5, arm)


def test_what_xacro_cannot_expand_is_told(arm: Path) -> None:
    arm.write_text(ARM.replace("${$(arg length)}", "${nothing}"), encoding="utf-8")
    with pytest.raises(mq.UrdfError, match=r"xacro does not expand it: .*nothing"):
        read_urdf(arm, package_path=arm.parents[1] / "elsewhere")


def test_an_argument_that_the_file_has_not_is_refused(arm: Path) -> None:
    """The library takes any, so that a misspelt one changes nothing, in silence."""
    path = arm.parents[1] / "elsewhere"
    said = r"unknown argument 'lenght'; did you mean 'length'\?"
    for do in (read_urdf, lint):
        with pytest.raises(mq.UnknownNameError, match=said):
            do(arm, package_path=path, arguments={"lenght": "2"})
    with pytest.raises(mq.InputError, match=r"expected a \.xacro file with arguments, got a text"):
        read_urdf("<robot/>", arguments={"length": "2"})


def test_the_command_takes_arguments(arm: Path) -> None:
    path = str(arm.parents[1] / "elsewhere")
    words = [str(arm), "--package-path", path, "--arg", "length:=2"]
    run = CliRunner().invoke(app, ["verify", *words, "--samples", "3"])
    verdict = next(line for line in run.stdout.splitlines() if line.startswith("arm: "))
    assert (run.exit_code, verdict[:12]) == (0, "arm: agrees ")
    assert CliRunner().invoke(app, ["lint", *words]).exit_code == 0
    wrong = CliRunner().invoke(app, ["verify", str(arm), "--arg", "length"])
    assert (wrong.exit_code, "expected NAME=VALUE after --arg" in wrong.stderr) == (2, True)
    fix = CliRunner().invoke(app, ["lint", *words, "--fix"])
    assert (fix.exit_code, "repair a xacro file by hand" in fix.stderr) == (2, True)


@pytest.mark.parametrize(("tag", "said"), [("sdf", "this is SDF"), ("mujoco", "this is MJCF")])
def test_other_formats_are_called_by_their_names(tag: str, said: str) -> None:
    with pytest.raises(mq.UrdfError, match=said):
        read_urdf(f"<{tag}/>")


def test_a_urdf_that_holds_xacro_is_expanded_and_told(tmp_path: Path) -> None:
    text = """<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro">
    <xacro:property name="m" value="${1 + 1}"/><link name="base"/><link name="arm"><inertial>
    <mass value="${m}"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
    <joint name="j" type="continuous"><parent link="base"/><child link="arm"/></joint></robot>"""
    plain, named = tmp_path / "arm.urdf", tmp_path / "arm.xacro"
    for file in (plain, named):
        file.write_text(text, encoding="utf-8")
    assert mq.read_urdf(plain).body("arm").mass == 2.0
    assert mq.read_urdf(plain).about == "Its xacro macros were expanded."
    assert replace(mq.read_urdf(plain), about="") == mq.read_urdf(named)
    (finding,) = (f for f in mq.lint(plain) if f.code == "M008")
    assert finding.message == "it holds xacro macros, and was expanded"
    assert "M008" not in [f.code for f in mq.lint(named)]
    with pytest.raises(mq.UrdfError, match="xacro macros that are not expanded"):
        mq.read_urdf(text)


def test_a_package_beside_is_found_by_the_name_in_its_package_xml(tmp_path: Path) -> None:
    from mecanique.urdf.reading.packages import MeshSearch

    parts, robot = tmp_path / "parts-main" / "meshes", tmp_path / "robot" / "urdf"
    for folder in (parts, robot):
        folder.mkdir(parents=True)
    (parts / "a.stl").write_bytes(b"")
    xml = parts.parent / "package.xml"
    xml.write_text("<package><name>parts</name></package>", encoding="utf-8")
    uri = "package://parts/meshes/a.stl"
    assert MeshSearch(robot / "r.urdf").find(uri) == parts / "a.stl"
    assert MeshSearch(None, [tmp_path]).find(uri) == parts / "a.stl"
    assert MeshSearch(robot / "r.urdf").find("package://others/meshes/a.stl") is None


def test_macros_in_comments_do_not_make_a_file_one_of_xacro(tmp_path: Path) -> None:
    path = tmp_path / "robot.urdf"
    text = '<robot name="r"><!-- <xacro:arm/> --><link name="a"/><!-- <xacro:leg/> --></robot>'
    path.write_text(text, encoding="utf-8")
    assert "M008" not in [finding.code for finding in mq.lint(path)]


CALLING = '<xacro:macro name="m{}">{}</xacro:macro>'


@pytest.mark.parametrize(
    ("inside", "message"),
    [
        ('<xacro:include filename="robot.xacro"/>', "a macro or a file asks for itself"),
        (CALLING.format(0, "<xacro:m0/>") + "<xacro:m0/>", "a macro or a file asks for itself"),
        (
            "".join(CALLING.format(k, f"<xacro:m{k + 1}/>" * 2) for k in range(40))
            + CALLING.format(40, '<link name="x"/>')
            + "<xacro:m0/>",
            "macros are called more than 10,000 times",
        ),
    ],
)
def test_macros_without_end_are_refused(tmp_path: Path, inside: str, message: str) -> None:
    file = tmp_path / "robot.xacro"
    space = "http://www.ros.org/wiki/xacro"
    file.write_text(f'<robot name="r" xmlns:xacro="{space}">{inside}</robot>', encoding="utf-8")
    with pytest.raises(mq.UrdfError, match=message):
        mq.read(file)


@pytest.mark.parametrize(
    ("inside", "message"),
    [
        ('<link name="${9**9**9**9}"/>', "xacro does not expand it within 2 s and 4 GiB of memory"),
        ('<xacro:macro name="m" params="a:=%s\'"/>' % ("a" * 60), "within 2 s and 4 GiB"),
        ('<link name="${max(range(10**12))}"/>', "within 2 s and 4 GiB of memory"),
        ('<xacro:include filename="pipe"/>', "within 2 s and 4 GiB of memory"),
        ("<link name=\"${xacro.load_yaml('pipe')}\"/>", "within 2 s and 4 GiB of memory"),
        ('<link name="${[0]*10**13}"/>', "it takes more than 4 GiB of memory"),
        ("<link name=\"${'a'*10**8}\"/>", "expected at most 20,000,000 bytes"),
    ],
)
def test_expressions_without_end_are_ended(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, inside: str, message: str
) -> None:
    """They stop neither for a signal nor for another thread, and the next file is read."""
    monkeypatch.setattr(xacro, "_SECONDS", 2.0)
    if "pipe" in inside:
        if os.name == "nt":
            pytest.skip("Windows has no pipes with a path")
        os.mkfifo(tmp_path / "pipe")
    file, good = tmp_path / "robot.xacro", tmp_path / "good.xacro"
    file.write_text(f"{HEAD}{inside}</robot>", encoding="utf-8")
    good.write_text(f'{HEAD}<link name="a${{1 + 1}}"/></robot>', encoding="utf-8")
    with ThreadPoolExecutor(1) as threads, pytest.raises(mq.UrdfError, match=message):
        threads.submit(mq.read, file).result()
    assert mq.read(good).bodies[0].name == "a2"


def test_a_file_changes_nothing_for_the_next(tmp_path: Path) -> None:
    file, good = tmp_path / "robot.xacro", tmp_path / "good.xacro"
    file.write_text(f'{HEAD}<link name="${{str(math.update(pi=3))}}"/></robot>', encoding="utf-8")
    good.write_text(f'{HEAD}<link name="a${{math.pi > 3}}"/></robot>', encoding="utf-8")
    mq.read(file)
    assert mq.read(good).bodies[0].name == "aTrue"


def test_modules_in_the_folder_of_the_user_are_not_imported(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A stranger's folder may hold a json.py or a xacro.py."""
    for name in ("json", "xacro", "yaml", "random"):
        (tmp_path / f"{name}.py").write_text("raise SystemExit('imported')", encoding="utf-8")
    file = tmp_path / "robot.xacro"
    file.write_text(f'{HEAD}<link name="a${{1 + 1}}"/></robot>', encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    xacro._start.cache_clear()
    assert mq.read(file).bodies[0].name == "a2"
    if find_spec("pydrake") is None:
        return
    from mecanique.reference.originals import drake

    text = mq.write_urdf(mq.textbook.load("simple_pendulum")).encode()
    assert drake.read(text, (0, 0, -9.81), {}, {}).others == ("simple_pendulum::pin",)
