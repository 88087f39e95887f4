"""Loops and springs that stand beside a URDF, in a TOML file."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import mecanique as mq
from mecanique.cli import app

LEG = Path(__file__).parents[2] / "examples" / "cassie_leg.urdf"
ROD = LEG.with_suffix(".toml")


def test_the_rod_and_the_spring_of_a_leg() -> None:
    leg = mq.read_urdf(LEG, loops=ROD)
    assert [loop.name for loop in leg.loops] == ["achilles_rod"]
    assert mq.degrees_of_freedom(leg, mq.assemble(leg)).N == 3
    q = mq.assemble(leg, {"hip_pitch": 0.2, "knee": -0.3})
    reference = mq.Reference(leg)
    poses = reference.poses(q)
    ends = []
    for loop_end, frame in (
        (leg.loops[0].body_a, leg.loops[0].frame_a),
        (leg.loops[0].body_b, leg.loops[0].frame_b),
    ):
        pose = poses[leg.bodies.index(leg.body(loop_end))]
        ends.append(pose[:3, :3] @ np.array(frame.xyz, float) + pose[:3, 3])
    assert np.linalg.norm(ends[1] - ends[0]) == pytest.approx(0.5, abs=1e-9)
    # the spring is all of the potential energy besides weight: ½ k q²
    springs = reference.energy(q).springs
    assert springs == pytest.approx(
        750.0 * q[leg.coordinates.index("knee_to_shin")] ** 2, rel=1e-12
    )
    assert mq.verify(leg, samples=2).agrees


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "got an empty file"),
        ("[[lop]]", "got 'lop'"),
        ("[loop]", r"expected tables \[\[loop\]\]"),
        ("[[loop]", "cannot be read"),
        ('[[loop]]\nname = "r"\nkind = "rod"', "a kind among ball, .*got 'rod'"),
        ('[[loop]]\nkind = "ball"', 'expected name = "…"'),
        ('[[loop]]\nname = "r"\nkind = "ball"', 'expected a = { link = "…"'),
        ('[[loop]]\nname = "r"\nkind = "ball"\nlenght = 1', "unknown field 'lenght'"),
        (
            '[[loop]]\nname = "r"\nkind = "ball"\na = { link = "hip", xyz = [1, 2] }',
            "three numbers for xyz",
        ),
        (
            '[[loop]]\nname = "r"\nkind = "distance"\na = { link = "hip" }\nb = { link = "shin" }',
            "expected a length of a distance",
        ),
        ('[[spring]]\njoint = "knee"', "expected a stiffness or a damping"),
        ('[[spring]]\njoint = "knee"\nstiffness = "k"', "expected a number for stiffness"),
    ],
)
def test_what_is_refused(tmp_path: Path, text: str, said: str) -> None:
    file = tmp_path / "leg.toml"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(mq.InputError, match=said):
        mq.read_urdf(LEG, loops=file)


def test_links_and_joints_must_exist(tmp_path: Path) -> None:
    file = tmp_path / "leg.toml"
    file.write_text(ROD.read_text(encoding="utf-8").replace("tarsus", "foot"), encoding="utf-8")
    with pytest.raises(mq.MechanismError, match="'foot'"):
        mq.read_urdf(LEG, loops=file)
    with pytest.raises(mq.InputError, match=r"but there is no file .*none\.toml"):
        mq.read_urdf(LEG, loops=tmp_path / "none.toml")


def test_the_commands_take_the_file() -> None:
    words = ["--loops", str(ROD), "--samples", "2"]
    run = CliRunner().invoke(app, ["verify", str(LEG), *words])
    assert run.exit_code == 0, run.output
    assert "independent coordinates" in run.stdout
    refused = CliRunner().invoke(app, ["verify", "cart_pole", *words])
    assert (refused.exit_code, "for --loops" in refused.stderr) == (2, True)
