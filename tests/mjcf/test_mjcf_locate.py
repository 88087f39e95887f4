"""What names a robot: folders, archives, packages and names of robot_descriptions."""

from __future__ import annotations

import re
import sys
import zipfile
from pathlib import Path
from types import ModuleType

import pytest
from click.testing import CliRunner

import mecanique as mq
from mecanique.cli import app
from mecanique.formats import locate as room
from mecanique.formats.locate import locate
from mecanique.urdf import robots as library_room

ROBOT = """<mujoco model="{}"><worldbody><body><joint/><geom size="0.1" pos="0.1 0 0"/></body>
</worldbody></mujoco>"""


def write(path: Path, name: str = "m") -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(ROBOT.format(name), encoding="utf-8")
    return path


def test_a_folder_of_the_menagerie_has_one_robot_beside_its_scenes(tmp_path: Path) -> None:
    folder = tmp_path / "acme_arm"
    robot = write(folder / "arm.xml")
    for other in ("scene.xml", "scene_left.xml", "mjx_arm.xml", "arm_hands.xml", "assets/link.xml"):
        write(folder / other)
    assert locate(folder) == robot
    assert mq.read(folder).nv == 1
    run = CliRunner().invoke(app, ["verify", str(folder), "--samples", "3"])
    assert run.exit_code == 0, run.output
    deeper = folder / "assets" / "link.xml"
    assert f"Reading {robot}; name {deeper}, deeper in the folder, to read them" in run.output
    write(folder / "model.sdf")
    assert locate(folder) == folder / "model.sdf"


def test_a_robot_is_called_after_its_folder_with_or_without_underscores(tmp_path: Path) -> None:
    robot = write(tmp_path / "acme_arm_v2" / "armv2.xml")
    write(tmp_path / "acme_arm_v2" / "armv2_pump.xml")
    assert locate(tmp_path / "acme_arm_v2") == robot


def test_a_folder_with_several_robots_or_none_is_refused(tmp_path: Path) -> None:
    with pytest.raises(mq.InputError, match="expected a description in URDF, xacro, MJCF or SDF"):
        locate(tmp_path)
    write(tmp_path / "left.xml")
    write(tmp_path / "right.xml")
    with pytest.raises(mq.InputError, match=r"expected one of its descriptions, left\.xml, right"):
        locate(tmp_path)
    assert locate(tmp_path / "none.xml") is None
    scene = write(tmp_path / "only" / "scene.xml")
    assert locate(tmp_path / "only") == scene
    for k in range(12):
        write(tmp_path / "many" / f"arm{k}" / f"arm{k}.xml")
    with pytest.raises(mq.InputError, match=r"arm7.arm7\.xml and 2 more; name one"):
        locate(tmp_path / "many")


@pytest.mark.parametrize("scheme", ["package", "model"])
def test_a_package_is_found_on_the_search_path(tmp_path: Path, scheme: str) -> None:
    robot = write(tmp_path / "acme" / "urdf" / "arm.xml")
    assert locate(f"{scheme}://acme/urdf/arm.xml", tmp_path) == robot
    assert locate(f"{scheme}://acme", tmp_path) == robot
    assert mq.read(f"{scheme}://acme", package_path=tmp_path).nv == 1
    with pytest.raises(mq.InputError, match="package 'nobody' is not found in"):
        locate(f"{scheme}://nobody/arm.xml", tmp_path)
    with pytest.raises(mq.InputError, match="expected a file of the package"):
        locate(f"{scheme}://acme/../arm.xml", tmp_path)


def test_an_archive_is_unpacked(tmp_path: Path) -> None:
    archive = tmp_path / "robots.zip"
    with zipfile.ZipFile(archive, "w") as file:
        file.writestr("acme/arm.xml", ROBOT.format("a"))
        file.writestr("acme/assets/more.xml", ROBOT.format("b"))
    assert mq.read(archive).name == "a"
    assert mq.read(f"{archive}/acme/assets/more.xml").name == "b"
    assert locate(f"{archive}/acme/none.xml") is None
    with pytest.raises(mq.InputError, match="expected a file of the archive"):
        locate(f"{archive}/acme/../../arm.xml")
    with zipfile.ZipFile(archive, "a") as file:
        file.writestr("acme/leg.xml", ROBOT.format("c"))
    names = ", ".join(str(Path("acme", name)) for name in ("arm.xml", "leg.xml"))
    with pytest.raises(
        mq.InputError, match=re.escape(f"{archive}: expected one of its descriptions, {names}")
    ):
        locate(archive)
    assert mq.read(archive.rename(tmp_path / "arm.zip")).name == "a"


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("arm.xml", ROBOT.format("a").replace("<joint/>", "<joint/><foo/>")),
        ("arm.urdf", '<robot name="a"><link name="b"/>\n<link name="b"/></robot>'),
    ],
)
def test_what_is_wrong_in_an_archive_is_told_where_it_stands_there(
    tmp_path: Path, name: str, text: str
) -> None:
    archive = tmp_path / "robots.zip"
    with zipfile.ZipFile(archive, "w") as file:
        file.writestr(f"acme/{name}", text)
    for word in (archive, archive / "acme" / name):
        run = CliRunner().invoke(app, ["lint", str(word)])
        assert f"{archive / 'acme' / name}:" in run.output
        with pytest.raises(mq.MecaniqueError) as refused:
            mq.read(word)
        assert f"{archive / 'acme' / name}:" in str(refused.value)


@pytest.mark.parametrize(
    "name",
    # on Windows a drive takes the place of all before it
    ["../arm.xml", "/arm.xml", "a/../../arm.xml", "C:/arm.xml", "a/D:/arm.xml", "a/D:arm.xml"],
)
def test_an_archive_whose_files_leave_it_is_refused(tmp_path: Path, name: str) -> None:
    archive = tmp_path / "robots.zip"
    with zipfile.ZipFile(archive, "w") as file:
        file.writestr(name, ROBOT.format("a"))
    with pytest.raises(mq.InputError, match=re.escape(f"{name!r} leaves the archive")):
        locate(archive)


def test_an_archive_too_large_or_no_archive_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    archive = tmp_path / "robots.zip"
    archive.write_bytes(b"PK nothing")
    with pytest.raises(mq.InputError, match="it cannot be unpacked"):
        locate(archive)
    with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED) as file:
        file.writestr("arm.xml", ROBOT.format("a" * 10_000))
    monkeypatch.setattr(room, "_MOST_BYTES", 5_000)
    with pytest.raises(mq.InputError, match="expected at most 20,000 files and 5,000 bytes"):
        locate(archive)


def test_a_name_of_robot_descriptions_is_found_where_that_is_installed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    library, robot = (
        ModuleType("robot_descriptions"),
        ModuleType("robot_descriptions.arm_description"),
    )
    library.__path__ = []
    robot.URDF_PATH = str(write(tmp_path / "arm.xml"))  # type: ignore[attr-defined]
    monkeypatch.setattr(library_room, "find_spec", lambda name: None)
    with pytest.raises(mq.InputError, match="not installed: pip install robot_descriptions"):
        locate("arm_description")
    monkeypatch.setitem(sys.modules, "robot_descriptions", library)
    monkeypatch.setitem(sys.modules, "robot_descriptions.arm_description", robot)
    monkeypatch.setattr(library_room, "find_spec", lambda name: name)
    assert locate("arm_description") == tmp_path / "arm.xml"
    assert mq.robot("arm_description") == tmp_path / "arm.xml"
    assert locate("leg_description") is None

    by_git = (
        "Cmd('git') failed due to: exit code(128)\n  cmdline: git fetch -v --progress\n"
        "  stderr: 'fatal: unable to access 'https://a.example/b.git/': no such host'"
    )
    causes = iter(["no network", by_git])

    def fail(name: str) -> None:
        raise OSError(next(causes))

    monkeypatch.setattr("importlib.import_module", fail)
    with pytest.raises(mq.InputError, match="does not give 'arm_description': no network"):
        locate("arm_description")
    with pytest.raises(mq.InputError) as refused:
        mq.robot("arm_description")
    assert str(refused.value) == (
        "robot_descriptions does not give 'arm_description': unable to access "
        "'https://a.example/b.git/': no such host"
    )
