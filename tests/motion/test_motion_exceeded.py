"""Joint limits that a motion passes are told."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from click.testing import CliRunner

import mecanique as mq
from mecanique.cli import app
from mecanique.motion.analysis.extremes import find_exceeded

FALL = """<robot name="fall"><link name="base"/><link name="stone"><inertial><mass value="1"/>
<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="z" type="prismatic"><parent link="base"/><child link="stone"/><axis xyz="0 0 1"/>
<limit lower="{}" upper="0.1" effort="1" velocity="1"/></joint></robot>"""


def test_a_stone_passes_its_limit_at_the_time_of_free_fall() -> None:
    """It has fallen 0.2 m after √(2 · 0.2 / 9.81) s, and 4.905 m after one second."""
    motion = mq.simulate(mq.read_urdf(FALL.format(-0.2)), duration=1.0, samples=10001)
    (exceeded,) = find_exceeded(motion)
    assert exceeded.joint == "z"
    assert exceeded.since == pytest.approx((0.4 / 9.81) ** 0.5, abs=1e-9)
    assert exceeded.time == 1.0
    assert exceeded.value == pytest.approx(-4.905, rel=1e-12)
    assert "joint 'z' passes its limits -0.2 … 0.1 from t = 0.2019 s" in motion.summary()


def test_nothing_is_told_of_a_motion_within_its_limits() -> None:
    motion = mq.simulate(mq.read_urdf(FALL.format(-5)), duration=1.0)
    assert find_exceeded(motion) == ()
    assert "limits" not in motion.summary()


def test_the_command_tells_it_in_json(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "fall.urdf").write_text(FALL.format(-0.2), encoding="utf-8")
    run = CliRunner().invoke(app, ["simulate", "fall.urdf", "--duration", "1", "--json"])
    (passed,) = json.loads(run.stdout)["limits passed"]
    assert (passed["joint"], passed["lower"]) == ("z", -0.2)


def test_a_motion_stops_at_a_joints_limit_where_that_is_asked() -> None:
    motion = mq.simulate(mq.read_urdf(FALL.format(-0.2)), duration=5.0, limits="stop")
    assert motion["z"][-1] == pytest.approx(-0.2, abs=1e-9)
    assert motion.t[-1] == pytest.approx((2 * 0.2 / 9.81) ** 0.5, rel=1e-9)
    assert [event.name for event in motion.events] == ["lower limit of z"]


def test_a_joint_bounces_off_its_limit_with_the_restitution_given() -> None:
    """Half of the speed is a quarter of the height; the flight up and down takes e times 2 T."""
    fall = (2 * 0.2 / 9.81) ** 0.5
    motion = mq.simulate(mq.read_urdf(FALL.format(-0.2)), duration=1.9 * fall, limits=0.5)
    assert not find_exceeded(motion)
    assert float(motion(1.5 * fall).q[0]) == pytest.approx(-0.15, abs=1e-8)
    assert [event.t for event in motion.events] == pytest.approx([fall], rel=1e-8)


@pytest.mark.parametrize("limits", ["bounce", 1.5, -0.1, True])
def test_limits_that_mean_nothing_are_refused(limits: str | float) -> None:
    with pytest.raises(mq.InputError, match='expected "stop" or a coefficient of restitution'):
        mq.simulate(mq.read_urdf(FALL.format(-1)), duration=0.1, limits=limits)


def test_a_start_beyond_a_limit_is_refused_where_limits_count() -> None:
    stone = mq.read_urdf(FALL.format(-1))
    with pytest.raises(mq.InputError, match=r"beyond its upper limit 0\.1; start within"):
        mq.simulate(stone, q={"z": 1.0}, duration=0.1, limits="stop")


def test_the_command_line_takes_limits(tmp_path: Path) -> None:
    file = tmp_path / "fall.urdf"
    file.write_text(FALL.format(-0.2), encoding="utf-8")
    told = CliRunner().invoke(app, ["simulate", str(file), "--limits", "stop", "--json"])
    assert told.exit_code == 0
    assert json.loads(told.stdout)["limits passed"] == []
    wrong = CliRunner().invoke(app, ["simulate", str(file), "--limits", "bounce"])
    assert wrong.exit_code == 2
    assert "expected stop or a number in 0…1 after --limits, got 'bounce'" in wrong.output
