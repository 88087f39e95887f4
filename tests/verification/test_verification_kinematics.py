"""Kinematics of robots without mass, compared with the engine."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

import mecanique as mq
from mecanique.cli import app
from mecanique.verification.compare import compare, compare_kinematics, has_mass

ARM = """<robot name="arm"><link name="base"/><link name="upper"/><link name="lower"/>
<joint name="q" type="revolute"><origin xyz="0 0.1 1" rpy="0.1 0.2 0.3"/><parent link="base"/>
<child link="upper"/><axis xyz="0 0.6 0.8"/>
<limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
<joint name="r" type="prismatic"><origin xyz="0 0 -2"/><parent link="upper"/><child link="lower"/>
<axis xyz="1 0 0"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>"""


def without_mass(mechanism: mq.Mechanism) -> mq.Mechanism:
    bodies = tuple(mq.Body(body.name) for body in mechanism.bodies)
    return replace(mechanism, bodies=bodies, forces=())


@pytest.mark.parametrize("root", ["fixed", "floating"])
def test_a_robot_without_mass_has_kinematics(root: Any) -> None:
    verdict = mq.verify(mq.read(ARM, root=root), samples=10)
    assert verdict.agrees
    assert verdict.worst < 1e-14
    assert [row.quantity for row in verdict.rows] == ["poses", "Jacobians"]
    assert "kinematics alone: nothing that moves has mass" in str(verdict)
    assert "mecanique inertia FILE --density 1000 -o NEW" in str(verdict)


@pytest.mark.parametrize(
    ("arm", "ground", "message"),
    [
        (mq.particle(2.0), None, "its bodies have mass, but none resists a change of hinge'"),
        (None, mq.ball(3.0, 0.1), "nothing that moves has mass, so it has geometry but no"),
    ],
)
def test_a_mass_that_resists_nothing_is_told_from_none(
    arm: mq.Shape | None, ground: mq.Shape | None, message: str
) -> None:
    bodies = (mq.Body("ground", *filter(None, [ground])), mq.Body("arm", *filter(None, [arm])))
    hinge = mq.Revolute("hinge", "ground", "arm", axis=(0, 1, 0))
    with pytest.raises(mq.EngineError, match=message):
        compare(mq.Mechanism("hinge", bodies, (hinge,)), 2, 0)


@pytest.mark.parametrize("name", ["four_bar_linkage", "bricard_linkage", "screw_press"])
def test_loops_without_mass_are_compared(name: str) -> None:
    mechanism = without_mass(mq.textbook.load(name))
    assert not has_mass(mechanism)
    verdict = mq.verify(mechanism, samples=5)
    assert verdict.agrees
    assert verdict.worst < 1e-12
    looped = {row.quantity for row in verdict.rows} >= {"gaps of loops", "Jacobians of loops"}
    assert looped == bool(mechanism.loops)


@pytest.mark.parametrize("quantity", ["poses", "Jacobians"])
def test_a_wrong_engine_disagrees(quantity: str, monkeypatch: pytest.MonkeyPatch) -> None:
    name = {"poses": "poses", "Jacobians": "jacobian"}[quantity]
    right = getattr(mq.Reference, name)

    def wrong(self: Any, *given: Any) -> Any:
        return np.asarray(right(self, *given)) * 1.001

    monkeypatch.setattr(mq.Reference, name, wrong)
    verdict = compare_kinematics(mq.read(ARM), 5, 0)
    assert [row.quantity for row in verdict.rows if not row.agrees] == [quantity]
    assert next(row for row in verdict.rows if not row.agrees).entry[0] in ("upper", "lower")


def test_commands_say_the_way_out(tmp_path: Any) -> None:
    file = tmp_path / "arm.urdf"
    file.write_text(ARM, encoding="utf-8")
    run = CliRunner().invoke(app, ["verify", str(file), "--samples", "5"])
    assert run.exit_code == 0
    assert "kinematics alone" in run.stdout
    for command in ("derive", "simulate"):
        run = CliRunner().invoke(app, [command, str(file)])
        assert run.exit_code == 2
        assert "mecanique inertia FILE --density" in run.stderr, command
