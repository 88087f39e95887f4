"""MJCF at the doors of URDF: by content, with letters, compared, and on the command line."""

from __future__ import annotations

from pathlib import Path

import pytest
from click.testing import CliRunner

import mecanique as mq
from mecanique.cli import app

PENDULUM = """<mujoco model="pendulum"><worldbody><body name="rod">
<joint name="q" axis="0 -1 0" damping="0.1"/>
<inertial pos="0 0 -0.5" mass="2" diaginertia="0.2 0.2 0.01"/></body></worldbody></mujoco>"""


def test_a_file_is_read_by_its_content(tmp_path: Path) -> None:
    file = tmp_path / "pendulum.xml"
    file.write_text(PENDULUM, encoding="utf-8")
    assert mq.read(file) == mq.read(PENDULUM)
    assert mq.read(PENDULUM, damping=False).forces == ()
    assert mq.read(PENDULUM, armature=0.3).joint("q").armature == 0.3  # type: ignore[union-attr]
    urdf = mq.write_urdf(mq.textbook.load("double_pendulum"))
    assert mq.read(urdf, root="floating") == mq.read_urdf(urdf, root="floating")
    nameless = tmp_path / "swing.xml"
    nameless.write_text(PENDULUM.replace(' model="pendulum"', ""), encoding="utf-8")
    assert mq.read(nameless).name == "swing"
    with pytest.raises(mq.InputError, match="root can be given for URDF and xacro alone"):
        mq.read(PENDULUM, root="floating")
    with pytest.raises(mq.UrdfError, match="cannot be read"):
        mq.read(tmp_path / "no.xml")
    with pytest.raises(mq.InputError, match="expected the path of a file or a text, got 3"):
        mq.read(3)  # type: ignore[arg-type]


def test_equations_are_in_letters() -> None:
    mechanism = mq.read(PENDULUM, parameters=("masses", "cz_rod"))
    assert [p.symbol for p in mechanism.parameters] == ["m_rod", "cz_rod"]
    equation = str(mq.derive(mechanism))
    assert "cz_rod" in equation
    assert "m_rod" in equation
    assert mq.verify(mechanism, samples=10).agrees


def test_the_same_robot_in_two_formats_agrees(tmp_path: Path) -> None:
    mechanism = mq.read(PENDULUM)
    file = tmp_path / "pendulum.urdf"
    mq.write_urdf(mechanism, file)
    assert mq.verify(mechanism, against=file, samples=10).agrees
    (tmp_path / "heavy.xml").write_text(PENDULUM.replace('mass="2"', 'mass="3"'), encoding="utf-8")
    assert "mass" in str(mq.diff(mechanism, tmp_path / "heavy.xml"))


def test_commands_take_it(tmp_path: Path) -> None:
    file = tmp_path / "pendulum.xml"
    file.write_text(PENDULUM, encoding="utf-8")
    result = CliRunner().invoke(app, ["derive", str(file), "--keep", "masses"])
    assert result.exit_code == 0, result.output
    assert "m_rod" in result.stdout
    assert CliRunner().invoke(app, ["verify", str(file), "--samples", "5"]).exit_code == 0
    refused = CliRunner().invoke(app, ["derive", str(file), "--root", "floating"])
    assert refused.exit_code == 2
    assert "root can be given for URDF and xacro alone" in refused.stderr
