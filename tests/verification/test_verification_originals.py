"""What engines make of the file itself."""

from __future__ import annotations

import json
import subprocess
from dataclasses import replace

import pytest

import mecanique as mq
from mecanique.reference.originals import drake
from mecanique.urdf import read_urdf
from mecanique.verification.engines import read_by
from mecanique.verification.verdict import EngineReading

ARM = """<robot name="r">
<link name="base"/>
<link name="l"><inertial><origin xyz="0 0 -0.5"/><mass value="1"/>
<inertia ixx="0.02" iyy="0.02" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>
<link name="k"><inertial><origin xyz="0 0.1 -0.2"/><mass value="0.5"/>
<inertia ixx="0.02" iyy="0.02" izz="0.01" ixy="0.001" ixz="0" iyz="0"/></inertial></link>
<joint name="j" type="revolute"><parent link="base"/><child link="l"/><axis xyz="0 1 0"/>
<limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
<joint name="i" type="continuous"><parent link="l"/><child link="k"/><origin xyz="0 0 -1"/>
<axis xyz="0 0.6 0.8"/><mimic joint="j"/></joint>
</robot>"""


def reading(text: str, engine: str = "pinocchio") -> EngineReading:
    (found,) = read_by(read_urdf(text), (engine,), 0)
    return found


@pytest.mark.parametrize(
    "engine", [pytest.param("pinocchio", marks=pytest.mark.engine), "mujoco", "drake"]
)
def test_engines_read_a_sound_file_alike(engine: str) -> None:
    if engine != "pinocchio":
        pytest.importorskip({"drake": "pydrake"}.get(engine, engine))
    found = reading(ARM, engine)
    assert found.worst is not None
    assert found.worst < 1e-12
    assert not found.sentences()


@pytest.mark.engine
@pytest.mark.parametrize(
    ("old", "new", "read", "trap", "said"),
    [
        (
            'value="0.5"',
            'value="0.5 "',
            "0 kg·m²",
            "line 5: link 'k': value of <mass> is '0.5 '",
            "mass [0.5 ] is not a float",
        ),
        (
            'ixy="0.001" ixz="0" iyz="0"',
            'ixy="0.001" ixz="0" iyz="0\n"',
            "0.02 kg·m²",
            "line 6: link 'k': iyz of <inertia>",
            "element iyz is not",
        ),
        (
            'xyz="0 0.1 -0.2"',
            'xyz="0\t0.1 -0.2"',
            "0 kg·m²",
            "line 5: link 'k': xyz of <origin>",
            "[0\t0.1]",
        ),
    ],
)
def test_a_dropped_inertial_does_not_agree(
    old: str, new: str, read: str, trap: str, said: str
) -> None:
    """M of the outer joint is m |a × c|² + aᵀ I a = 0.02 + 0.0136."""
    assert old in ARM
    verdict = mq.verify(read_urdf(ARM.replace(old, new, 1)), samples=3)
    (found,) = verdict.readings
    assert found.differs
    assert not verdict.agrees
    assert "DISAGREES" in verdict.summary
    assert "Pinocchio 4" in verdict.summary
    text = str(verdict)
    assert f"link 'k' at joint 'i': {read} instead of 0.0336" in text
    assert trap in text
    assert said in text
    assert verdict.to_dict()["readings"][0]["differs"] is True


@pytest.mark.engine
def test_other_engines_read_the_file_besides_pinocchio() -> None:
    """MuJoCo reads a number with a blank behind it, Pinocchio does not."""
    pytest.importorskip("mujoco")
    text = ARM.replace('value="0.5"', 'value="0.5 "', 1)
    verdict = mq.verify(read_urdf(text), samples=3, engines=("mujoco",))
    pinocchio, mujoco = verdict.readings
    assert pinocchio.differs
    assert not mujoco.differs
    assert not verdict.agrees


@pytest.mark.engine
def test_a_refusal_is_told_and_equations_still_agree() -> None:
    text = ARM.replace('effort="1"', 'effort="-1"')
    verdict = mq.verify(read_urdf(text), samples=3)
    assert verdict.agrees
    assert "Pinocchio" in verdict.summary
    assert "refuses the file itself" in verdict.summary
    assert "min_effort are greater than max_effort" in str(verdict)


def test_drake_and_mujoco_on_an_inertia_of_no_real_body() -> None:
    pytest.importorskip("mujoco")
    text = ARM.replace(
        'ixx="0.02" iyy="0.02" izz="0.01" ixy="0"', 'ixx="9" iyy="1" izz="1" ixy="0"'
    )
    found = reading(text, "mujoco")
    assert "inertia must satisfy A + B >= C" in found.refused
    assert any("line 4: link 'l': its principal moments" in remark for remark in found.remarks)
    pytest.importorskip("pydrake")
    found = reading(text, "drake")
    assert found.differs
    assert any("Drake said" in remark for remark in found.remarks)


def test_an_engine_that_is_not_installed_or_known(monkeypatch: pytest.MonkeyPatch) -> None:
    from mecanique.verification import engines

    drake = replace(engines.ENGINES["drake"], package="no-such-package")
    monkeypatch.setitem(engines.ENGINES, "drake", drake)
    found = reading(ARM, "drake")
    said = "Drake did not read the file: it is not installed"
    assert found.sentences() == (f"{said} (pip install no-such-package)",)
    assert not found.refused
    verdict = mq.verify(read_urdf(ARM), samples=3, engines=("drake",))
    assert verdict.agrees
    assert verdict.summary.endswith(f"; {said}")
    with pytest.raises(mq.UnknownNameError, match="bullet"):
        reading(ARM, "bullet")


def test_a_mechanism_from_no_file_has_no_readings() -> None:
    assert mq.verify(mq.textbook.load("cart_pole"), samples=3).readings == ()


def test_a_robot_without_joints_of_one_coordinate_is_read_from_drake(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Its matrices have no entries, from which no number of states follows."""
    nothing: list[list[float]] = [[], []]
    numbers = {"mass": nothing, "bias": nothing, "passive": nothing}
    answer = json.dumps({"joints": [], **numbers, "complaints": []})
    done = subprocess.CompletedProcess([], 0, answer, "")
    monkeypatch.setattr(subprocess, "run", lambda *_, **__: done)
    original = drake.read(b"<robot/>", (0.0, 0.0, -9.81), {}, {})
    assert (original.mass.shape, original.bias.shape) == ((2, 0, 0), (2, 0))
