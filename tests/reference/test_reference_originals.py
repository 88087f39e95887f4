"""Robots as other engines read and evaluate them: alike, whatever their joints and folders."""

from __future__ import annotations

import json
import re
import subprocess
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from original_samples import ARM, JOINTED, MOVING, carried, pair

import mecanique as mq
from mecanique.reference.originals import drake, exudyn, mujoco, pinocchio
from mecanique.urdf import read_urdf
from mecanique.verification.engines import read_by
from mecanique.verification.verdict import OURS


@pytest.fixture
def drake_here(monkeypatch: pytest.MonkeyPatch) -> None:
    """Drake within this process: in its own, what mutate.py changes in the code is not seen."""

    def run(command: list[str], **given: Any) -> subprocess.CompletedProcess[str]:
        answer = json.dumps(drake._answer(json.loads(given["input"])))
        return subprocess.CompletedProcess(command, 0, answer, "")

    monkeypatch.setattr(subprocess, "run", run)


LIFTED = """<mujoco><worldbody><body gravcomp="0.7" euler="20 30 0">
<joint name="i" axis="0 1 0" actuatorgravcomp="true" damping="0.4"/>
<geom size=".1" pos="0.3 0.1 0.2"/><body pos="0.3 0 0.1" gravcomp="0.4">
<joint name="j" type="slide" axis="1 0 0.3"/><geom size=".2" pos="0.1 0 0.2"/></body></body>
</worldbody></mujoco>"""
MESH = '<visual><geometry><mesh filename="missing.obj"/></geometry></visual>'
LED = ARM.replace('<mimic joint="j"/>', "").replace('"continuous"', '"floating"')


@pytest.mark.usefixtures("drake_here")
@pytest.mark.parametrize(
    ("mechanism", "names"),
    [
        (read_urdf(ARM), ("exudyn",)),
        (read_urdf(LED), ("exudyn",)),
        (pair("continuous", "0.48 0.6 0.64"), ("exudyn",)),
        (read_urdf(ARM.replace("</inertial>", f"</inertial>{MESH}")), ("mujoco",)),
        (pair("floating"), ("pinocchio", "mujoco", "drake", "exudyn")),
        (pair("continuous", root="floating"), ("pinocchio", "mujoco", "drake", "exudyn")),
        (pair("planar", "0 0 1"), ("pinocchio", "mujoco", "drake")),
        (pair("planar"), ("mujoco", "drake")),
        (carried("planar", "0 0 1"), ("pinocchio", "mujoco", "drake")),
        (carried("planar", "0.48 0.6 0.64"), ("mujoco", "drake")),
        (mq.read(MOVING), ("mujoco", "drake")),
        (mq.read(LIFTED), ("mujoco",)),
        (mq.read(JOINTED), ("drake",)),
    ],
    ids=[
        "mimic",
        "floating end",
        "crooked hinge",
        "mesh",
        "floating",
        "free root",
        "planar",
        "slanted plane",
        "planar on a hinge",
        "slanted plane on a hinge",
        "MJCF",
        "MJCF with carried weight",
        "SDF",
    ],
)
def test_joints_with_any_number_of_velocities_are_read_alike(
    mechanism: mq.Mechanism, names: tuple[str, ...]
) -> None:
    for found in read_by(mechanism, names, 0):
        if not found.missing:
            assert found.worst is not None
            assert found.worst < 1e-12, found
            assert OURS in found.alike


@pytest.mark.usefixtures("drake_here")
def test_engines_with_and_without_springs_agree_on_the_rest() -> None:
    """Exudyn's trees have no springs, so that it is compared with Drake's bias alone."""
    pytest.importorskip("exudyn")
    pytest.importorskip("pydrake")
    readings = read_by(pair("continuous", root="floating"), ("exudyn", "drake"), 0)
    assert [reading.alike for reading in readings] == [
        (readings[1].engine, OURS),
        (readings[0].engine, OURS),
    ]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (b"<sdf/>", "it is built of URDF alone, not of <sdf>"),
        (b"<robot><joint name='j'/></robot>", "joint 'j' has no parent or no child"),
        (b"<robot", "line 1: "),
        (LED.replace("floating", "planar").encode(), "its trees have no joint of type 'planar'"),
        (ARM.replace('value="0.5"', 'value="x"').encode(), "expected 1 numbers for value, got 'x'"),
    ],
)
def test_exudyn_is_built_of_sound_urdf_alone(text: bytes, said: str) -> None:
    with pytest.raises(mq.EngineError, match=re.escape(said)):
        exudyn.read(text, (0.0, 0.0, -9.81), {}, {})


def test_pinocchio_gives_the_reason_of_its_parser() -> None:
    pytest.importorskip("pinocchio")
    with pytest.raises(mq.EngineError, match=r"^No link elements found in urdf file$"):
        pinocchio.read(b"<robot name='r'/>", (0.0, 0.0, -9.81), {}, {})


@pytest.mark.usefixtures("drake_here")
@pytest.mark.parametrize("engine", [mujoco, drake], ids=lambda engine: engine.__name__[30:])
@pytest.mark.parametrize("kind", ["hinge", "ball"])
def test_joints_that_nobody_asks_about_rest_unturned(kind: str, engine: ModuleType) -> None:
    pytest.importorskip("mujoco" if engine is mujoco else "pydrake")
    text = """<mujoco model="m"><worldbody><body euler="20 30 0"><joint name="i" axis="0 1 0.2"/>
    <geom size=".1" pos="0.3 0.1 0.2"/><body pos="0.3 0 0.1" euler="0 0 40">JOINT
    <geom type="box" size=".1 .2 .3" pos="0.1 0.4 0.2"/></body></body></worldbody></mujoco>"""
    held = mq.read(text.replace("JOINT", ""))
    moving = text.replace("JOINT", f'<joint name="j" type="{kind}" axis="1 0 0"/>')
    q, v = 0.7, -1.3
    original = engine.read(moving.encode(), (0.0, 0.0, -9.81), {"i": [q]}, {"i": [v]})
    assert [name.rpartition("::")[2] for name in original.others] == ["j"]
    reference = mq.Reference(held)
    np.testing.assert_allclose(original.mass[0], reference.mass_matrix([q]), rtol=1e-12, atol=0)
    np.testing.assert_allclose(original.bias[0], reference.bias([q], [v]), rtol=1e-11, atol=0)


@pytest.mark.usefixtures("drake_here")
@pytest.mark.parametrize(
    ("text", "others"),
    [
        (
            '<sdf version="1.9"><model name="m"><link name="a"/><link name="b"/>'
            '<joint name="i" type="revolute"><parent>world</parent><child>a</child>'
            "<axis><xyz>0 1 0</xyz></axis></joint></model></sdf>",
            ("m::b_root_joint",),
        ),
        (
            ARM.replace('<mimic joint="j"/>', "").replace('name="j"', 'name="l"'),
            ("r::l",),
        ),
    ],
    ids=["SDF", "URDF"],
)
def test_only_a_link_that_nothing_holds_has_a_root_joint_of_its_name(
    text: str, others: tuple[str, ...]
) -> None:
    pytest.importorskip("pydrake")
    original = drake.read(text.encode(), (0.0, 0.0, -9.81), {"i": [0.3]}, {"i": [0.2]})
    assert original.others == others


def test_a_robot_without_joints_of_one_coordinate_is_read_from_drake(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Its matrices have no entries, from which no number of states follows."""
    nothing: list[list[float]] = [[], []]
    numbers = {"mass": nothing, "bias": nothing, "passive": nothing}
    answer = json.dumps({"joints": [], **numbers, "complaints": [], "others": []})
    done = subprocess.CompletedProcess([], 0, answer, "")
    monkeypatch.setattr(subprocess, "run", lambda *_, **__: done)
    original = drake.read(b"<robot/>", (0.0, 0.0, -9.81), {}, {})
    assert (original.mass.shape, original.bias.shape) == ((2, 0, 0), (2, 0))


@pytest.mark.usefixtures("drake_here")
def test_drake_finds_models_in_folders_beside(tmp_path: Path) -> None:
    pytest.importorskip("pydrake")
    config = '<model><name>{0}</name><sdf version="1.9">{0}.sdf</sdf></model>'
    link = "<link name='b'><inertial><pose>0 0.1 0 0 0 0</pose><mass>2</mass></inertial></link>"
    models = {
        "inner": link,
        "outer": "<include><uri>model://inner/inner.sdf</uri><name>i</name>"
        "<pose>0 0 1 0 0 0</pose></include>"
        "<joint name='j' type='revolute'><parent>world</parent><child>i::b</child>"
        "<axis><xyz>1 0 0</xyz></axis></joint>",
    }
    for name, inside in models.items():
        folder = tmp_path / name
        folder.mkdir()
        (folder / "model.config").write_text(config.format(name), encoding="utf-8")
        text = f'<sdf version="1.9"><model name="{name}">{inside}</model></sdf>'
        (folder / f"{name}.sdf").write_text(text, encoding="utf-8")
    (found,) = read_by(mq.read(tmp_path / "outer" / "outer.sdf"), ("drake",), 0)
    assert found.alike == (OURS,)


@pytest.mark.usefixtures("drake_here")
def test_drake_knows_joints_by_models_in_models() -> None:
    pytest.importorskip("pydrake")
    link = (
        '<link name="{}"><pose>0.1 0 {} 0 0.3 0</pose><inertial><mass>{}</mass></inertial></link>'
    )
    axis = "<axis><xyz>0 1 0</xyz></axis>"
    joint = (
        '<joint name="j" type="revolute"><parent>{}</parent><child>{}</child>' + axis + "</joint>"
    )
    inner = f'<model name="n">{link.format("c", 2, 3)}{joint.format("a", "c")}{{}}</model>'
    outer = (
        f'<model name="{{}}">{link.format("b", 1, "{}")}{joint.format("world", "b")}{{}}</model>'
    )
    inner = inner.format(link.format("a", 1, 2))
    models = outer.format("m", 1, inner) + outer.format("o", 4, "")
    world = f'<sdf version="1.9"><world name="w">{models}</world></sdf>'
    (found,) = read_by(mq.read(world), ("drake",), 0)
    assert found.alike == ("mecanique",)
    assert not found.differs


@pytest.mark.usefixtures("drake_here")
def test_drake_has_joints_of_two_models_in_the_model_of_the_child() -> None:
    pytest.importorskip("pydrake")
    link = '<link name="{}"><pose>{} 0 0 0 0.3 0</pose><inertial><mass>{}</mass></inertial></link>'
    joint = (
        '<joint name="{}" type="revolute"><parent>{}</parent><child>{}</child>'
        "<axis><xyz>0 1 0</xyz></axis></joint>"
    )
    inner = '<model name="{0}"><pose>{1} 0 1 0 0 0</pose>' + link.format("c", 0.1, "{1}")
    inner += link.format("d", 0.5, 2) + joint.format("turn", "c", "d") + "</model>"
    outer = '<model name="{}">' + link.format("b", 0, "{}")
    outer += inner.format("n", 1) + inner.format("o", 3) + joint.format("first", "b", "n::c")
    outer += joint.format("second", "n::c", "o::c") + "</model>"
    world = f'<sdf version="1.9"><world name="w">{outer.format("m", 4)}{outer.format("k", 7)}'
    (found,) = read_by(mq.read(f"{world}</world></sdf>"), ("drake",), 0)
    assert found.alike == (OURS,)


@pytest.mark.usefixtures("drake_here")
def test_drake_takes_a_package_that_it_knows_from_where_the_file_is(tmp_path: Path) -> None:
    pytest.importorskip("pydrake")
    folder = tmp_path / "drake_models"
    folder.mkdir()
    (folder / "package.xml").write_text("<package><name>drake_models</name></package>", "utf-8")
    uri = "<mesh><uri>package://drake_models/a.obj</uri></mesh>"
    visual = f'<visual name="v"><geometry>{uri}</geometry></visual>'
    link = f'<link name="b"><inertial><mass>2</mass></inertial>{visual}</link>'
    file = folder / "arm.sdf"
    file.write_text(f'<sdf version="1.9"><model name="m">{link}</model></sdf>', "utf-8")
    (found,) = read_by(mq.read(file), ("drake",), 0)
    assert found.alike == (OURS,)
