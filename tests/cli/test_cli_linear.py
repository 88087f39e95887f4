"""`mecanique linearize`: letters, numbers, JSON, the response as CSV, a mode as a page."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from mecanique.cli import app


def run(*words: str, code: int = 0) -> str:
    result = CliRunner().invoke(app, ["linearize", *words])
    assert result.exit_code == code, f"{result.output}{result.exception!r}"
    return result.output


def test_the_text_has_letters_matrices_and_modes() -> None:
    text = run("two_blocks")
    assert "m1 q1'' + (k1 + k2) q1 - k2 q2 = 0" in text
    assert "about the stable equilibrium" in text
    assert "   2    6.32455532    1.00658424          0  (+1.0000, -1.0000)" in text


def test_a_comparison_follows_when_asked_for() -> None:
    text = run("rigid_bar_pendulum", "--compare", "--amplitude", "1")
    assert "omega = sqrt(3 g/(2 l))" in text
    assert "period differs by 6.633%" in text
    assert "from the amplitude 0.398177 rad on" in text


def test_json_has_every_figure() -> None:
    told = json.loads(run("cart_pole", "--at", "q=3", "--json"))
    assert told["equilibrium"] == {"x": 0.0, "q": pytest.approx(np.pi, rel=1e-12)}
    assert told["stable"] is False
    assert told["equations"] == ["(M + m) x'' - m l q'' + c x' = F", "x'' - l q'' + g q = 0"]
    assert told["damping_ratios"][0] is None
    assert np.shape(told["modes"]["q"]) == (2, 2)
    assert told["frequencies_hz"] == pytest.approx(
        [w / (2 * np.pi) for w in told["frequencies_rad_per_s"]], rel=1e-12
    )


def test_what_has_no_letters_says_why() -> None:
    text = run("kapitza_pendulum", "--at", "q=0.0")
    assert "The linear equations are computed, not written out" in text
    assert json.loads(run("kapitza_pendulum", "--json"))["equations"] is None


def test_the_response_is_a_table_for_other_programs() -> None:
    lines = run("two_blocks", "--force", "q2=2").splitlines()
    assert lines[0] == "omega [rad/s],amplitude q1,phase q1,amplitude q2,phase q2"
    assert len(lines) == 401
    # at rest the force of 2 N stretches the springs of 40 N/m and 20 N/m
    assert [float(x) for x in lines[1].split(",")][1::2] == pytest.approx([0.05, 0.15], rel=1e-3)


def test_a_mode_becomes_a_page(tmp_path: Path) -> None:
    page = tmp_path / "mode.html"
    assert f"Wrote {page}" in run("two_blocks", "--mode", "2", "--page", str(page)).replace(
        "\n", " "
    )
    assert "mode 2 of the linear equations, 1.00658 Hz" in page.read_text(encoding="utf-8")


def test_refusals_are_sentences() -> None:
    assert "no equilibrium of 'kepler_orbit' was found" in run("kepler_orbit", code=2)
    assert "expected a mode in 0…1" in run("two_blocks", "--compare", "--mode", "3", code=2)
    assert "unknown coordinate 'p'" in run("rigid_bar_pendulum", "--at", "p=3", code=2)


def test_the_ground_is_judged_at_a_latitude() -> None:
    words = ["inertial", "rigid_bar_pendulum", "--latitude", "48", "--duration", "2"]
    result = CliRunner().invoke(app, words)
    assert result.exit_code == 0, result.output
    assert "The ground may be taken as inertial within 0.001" in result.output
    told = json.loads(CliRunner().invoke(app, [*words, "--json"]).stdout)
    assert told["latitude_deg"] == pytest.approx(48, rel=1e-12)
    assert {row["name"] for row in told["rows"]} >= {"q", "force in pin"}
    assert CliRunner().invoke(app, ["inertial", "two_blocks", "--latitude", "91"]).exit_code == 2


def test_an_equilibrium_is_printed_without_rounding() -> None:
    # Newton's method left q2 = -8e-17
    text = CliRunner().invoke(app, ["linearize", "two_link_arm"]).output
    assert "\n  q1 = -1.5708, q2 = 0\n" in text
