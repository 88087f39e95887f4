"""Commands on a file with friction and a stop."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import mecanique as mq
from mecanique.cli import app


@pytest.fixture
def block(tmp_path: Path) -> str:
    """The path of a block on a slide with friction and a stop, as URDF."""
    mechanism = mq.Mechanism(
        "block",
        (mq.Body("ground"), mq.Body("block", mq.box(1.0, (0.1, 0.1, 0.1)))),
        (mq.Prismatic("slide", "ground", "block", axis=(1, 0, 0), coordinate="slide"),),
        switching=(
            mq.Friction("dry", "slide", 0.2, 9.81),
            mq.Stop("wall", "slide", at=1.0, restitution=0.5),
        ),
    )
    path = tmp_path / "block.urdf"
    mq.write_urdf(mechanism, path)
    return str(path)


def test_derive_prints_every_mode_with_its_condition(block: str) -> None:
    done = CliRunner().invoke(app, ["derive", block])
    assert done.exit_code == 0
    assert "dry slips -, wall open:\n  slide'' = 1.962\n" in done.output
    assert "never, as N_wall would be -1.962" in done.output
    for options in (["--steps"], ["--routh"], ["--in", "slide"], ["--method", "all"]):
        refused = CliRunner().invoke(app, ["derive", block, *options])
        assert refused.exit_code == 2
        assert "its modes are written as text or LaTeX by Lagrange" in refused.output


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (
            ["check", "slide'' = 0"],
            "a formula is checked where the equations are those of one mode",
        ),
        (["linearize"], "small motions are those of one mode, as long as it holds"),
        (["inertial", "--latitude", "48"], "what follows on the turning earth is not looked for"),
    ],
)
def test_what_takes_one_mode_alone_says_why(words: list[str], said: str, block: str) -> None:
    command, *options = words
    done = CliRunner().invoke(app, [command, block, *options])
    assert done.exit_code == 2
    assert said in done.output
    assert "elements that switch, 'dry', 'wall': " in done.output


def test_convert_writes_what_switches_and_lists_what_mjcf_lacks(block: str, tmp_path: Path) -> None:
    written = tmp_path / "again.urdf"
    done = CliRunner().invoke(app, ["convert", block, "-o", str(written)])
    assert done.exit_code == 0, done.output
    assert len(mq.read_urdf(written).switching) == 2
    done = CliRunner().invoke(app, ["convert", block, "-o", str(tmp_path / "block.xml")])
    assert done.exit_code == 0, done.output
    assert "dry" in done.output
    assert "wall" in done.output


def test_run_derives_verifies_simulates_and_writes_a_page(block: str, tmp_path: Path) -> None:
    page = tmp_path / "page.html"
    done = CliRunner().invoke(app, ["run", block, "-v", "slide=3", "-o", str(page)])
    assert done.exit_code == 0, done.output
    assert "dry sticks, wall open:" in done.output
    assert "block: agrees at 100 random states" in done.output
    assert "wall: impact: t = 0.38" in done.output
    assert page.stat().st_size > 100_000


def test_diff_tells_another_coefficient(block: str, tmp_path: Path) -> None:
    other = tmp_path / "other.urdf"
    text = Path(block).read_text(encoding="utf-8")
    other.write_text(text.replace('mu="0.2"', 'mu="0.1"'), encoding="utf-8")
    done = CliRunner().invoke(app, ["diff", block, str(other)])
    assert done.exit_code == 1
    assert "friction 'dry': mu 0.2 → 0.1" in done.output


def test_code_has_every_mode_and_impact(block: str, tmp_path: Path) -> None:
    done = CliRunner().invoke(app, ["code", block, "--target", "python", "-o", f"{tmp_path}/made"])
    assert done.exit_code == 0, done.output
    assert "mode_dry_slips_plus_wall_open: worst relative difference" in done.output
    assert "impact_wall: worst relative difference" in done.output


@pytest.mark.skipif(shutil.which("cc") is None, reason="needs a C compiler")
def test_an_fmu_of_what_switches_is_written(block: str, tmp_path: Path) -> None:
    pytest.importorskip("fmpy")
    done = CliRunner().invoke(app, ["code", block, "--target", "fmu", "-o", f"{tmp_path}/made"])
    assert done.exit_code == 0, done.output
    assert "impact_wall: worst relative difference" in done.output
    assert list((tmp_path / "made").glob("*.fmu"))


@pytest.mark.parametrize(
    ("name", "said"),
    [("woodpecker", "has 64 modes, more than 16"), ("tippe_top", "T_floor_x = -N_floor s_floor_x")],
)
def test_run_moves_what_has_modes_in_letters_or_not(name: str, said: str, tmp_path: Path) -> None:
    words = ["run", name, "--samples", "5", "--duration", "0.02", "-o", f"{tmp_path}/page.html"]
    done = CliRunner().invoke(app, words)
    assert done.exit_code == 0, done.output
    assert said in " ".join(done.output.split())
    assert f"{name}: agrees at 5 random states" in done.output


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("cc") is None, reason="needs a C compiler")
def test_an_fmu_of_many_modes_is_written_and_solves_them_all(tmp_path: Path) -> None:
    """Of the 256 modes of a slider in its guide 13 have one contact, and two touch at once."""
    fmpy = pytest.importorskip("fmpy")
    system = mq.textbook.entry("clearance_slider_crank")
    v = {rate.removesuffix("'"): value for rate, value in system.start_velocity.items()}
    given = [
        f"-{option}{name}={x!r}"
        for option, start in (("q", system.start), ("v", v))
        for name, x in start.items()
    ]
    words = ["code", "clearance_slider_crank", "--target", "fmu", "--samples", "3", *given]
    done = CliRunner().invoke(app, [*words, "-o", str(tmp_path)])
    assert done.exit_code == 0, done.output
    found = fmpy.simulate_fmu(
        str(tmp_path / "clearance_slider_crank.fmu"), stop_time=0.05, output_interval=0.001
    )
    mechanism = system.mechanism()
    motion = mq.simulate(mechanism, q=system.start, v=v, duration=0.05, rtol=1e-12)
    exact = motion(np.minimum(found["time"], 0.05)).q
    states = np.array([found[name] for name in mechanism.coordinates]).T
    np.testing.assert_allclose(states, exact, rtol=0, atol=1e-8)
