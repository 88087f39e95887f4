"""Conversions are proved: round trips, what is lost, and results that are wrong."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Literal

import pytest
from click.testing import CliRunner

import mecanique as mq
from mecanique import conversion as room
from mecanique.cli import app
from mecanique.formats.mjcf_write import write_mjcf

ARM = """<sdf version="1.9"><model name="m"><link name="a"><pose>0 0 1 0.1 0.2 0.3</pose></link>
<link name="b"><pose>0.5 0.1 1 0.4 0 0.2</pose></link>
<joint name="q" type="revolute"><pose>0 0.1 -0.2 0.3 0 0</pose><parent>world</parent>
<child>a</child><axis><xyz>0 1 0</xyz><dynamics><damping>0.3</damping></dynamics></axis></joint>
<joint name="r" type="prismatic"><parent>a</parent><child>b</child><axis><xyz>1 1 0</xyz>
</axis></joint></model></sdf>"""


@pytest.mark.parametrize("name", ["panda", "ur5_robot", "solo12", "double_pendulum"])
def test_urdf_to_mjcf_and_back_is_the_same_robot(name: str) -> None:
    robot = name in mq.robots()
    mechanism = mq.read(mq.robot(name)) if robot else mq.textbook.load(name)
    out = mq.convert(mechanism, "MJCF", states=20)
    assert out.proved, str(out)
    assert out.lost == ()
    assert any(reading.engine.startswith("MuJoCo") for reading in out.readings)
    back = mq.convert(mq.read(out.text), "URDF", states=20)
    assert max(out.worst, back.worst) <= 1e-12, str(back)
    assert mq.verify(mechanism, against=mq.read_urdf(back.text), samples=5).agrees


def test_sdf_becomes_urdf_and_mjcf() -> None:
    forms: tuple[Literal["URDF", "MJCF"], ...] = ("URDF", "MJCF")
    for form in forms:
        conversion = mq.convert(mq.read(ARM), form)
        assert conversion.proved, str(conversion)
        assert conversion.worst <= 1e-12


def test_springs_loops_and_mimics_are_written() -> None:
    mechanism = mq.read(ARM)
    point = (0.1, 0.2, 0.3)
    spring = mq.Spring("s", "world", point, "b", point, 30.0, 0.2)
    coil = mq.JointSpring("k", "q", 3.0, 0.4)
    ball = mq.Loop.ball("c", "world", point, "b", point)
    whole = replace(mechanism, forces=(*mechanism.forces, spring, coil), loops=(ball,))
    conversion = mq.convert(whole, "MJCF")
    assert conversion.proved, str(conversion)
    (loop,) = mq.read(conversion.text).loops
    assert (loop.kind, loop.bodies) == ("ball", ("world", "b"))
    driven = mq.Coordinates((), (("r", 0.5 + 2 * mq.coordinate("q")),))
    follows = mq.convert(replace(mechanism, coordinates=driven), "MJCF")
    assert follows.proved, str(follows)
    assert mq.read(follows.text).nv == 1


def test_what_is_lost_is_listed() -> None:
    conversion = mq.convert(mq.textbook.load("cart_pole"), "MJCF", states=5)
    assert conversion.lost == ("load push: MJCF states no such force",)
    assert "MJCF cannot express: load push" in str(conversion)
    # MuJoCo itself refuses the thin rod, and the verdict says so
    assert not conversion.proved
    assert "refuses the file itself" in str(conversion)


def test_a_wrong_result_is_not_proved(monkeypatch: pytest.MonkeyPatch) -> None:
    def write_wrongly(mechanism: mq.Mechanism) -> tuple[str, tuple[str, ...]]:
        text, lost = write_mjcf(mechanism)
        return text.replace('mass="1"', 'mass="1.000001"'), lost

    monkeypatch.setattr(room, "write_mjcf", write_wrongly)
    conversion = mq.convert(mq.read(ARM), "MJCF")
    assert not conversion.proved
    assert "The MJCF differs from the source" in str(conversion)


def test_an_engine_that_refuses_the_result_is_not_said_to_be_missing() -> None:
    pytest.importorskip("mujoco")
    told = str(mq.convert(mq.textbook.load("rigid_bar_pendulum"), "MJCF", states=3))
    assert "refuses the file itself" in told
    assert "No engine" not in told


def test_the_command_writes_and_judges(tmp_path: Path) -> None:
    source, result = tmp_path / "arm.sdf", tmp_path / "arm.xml"
    source.write_text(ARM, encoding="utf-8")
    run = CliRunner().invoke(app, ["convert", str(source), "-o", str(result)])
    assert run.exit_code == 0, run.output
    assert "The MJCF says the same as the source" in run.stdout
    assert mq.read(result).nv == 2
    refused = CliRunner().invoke(app, ["convert", str(source), "-o", str(tmp_path / "arm.usd")])
    assert refused.exit_code == 2
    assert "expected a file ending in .urdf, .xml or .mjcf, got 'arm.usd'" in refused.stderr
    with pytest.raises(mq.InputError, match="expected 'URDF' or 'MJCF' for the format"):
        mq.convert(mq.read(ARM), "SDF")  # type: ignore[arg-type]
    with pytest.raises(mq.InputError, match="expected a number of states from 1, got 0"):
        mq.convert(mq.read(ARM), "URDF", states=0)
