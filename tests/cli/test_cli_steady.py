"""`mecanique steady`: exponents about a steady motion, over speeds, as table, JSON and plot."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from mecanique import textbook
from mecanique.cli import app


def run(*words: str, code: int = 0) -> str:
    result = CliRunner().invoke(app, ["steady", *words])
    assert result.exit_code == code, f"{result.output}{result.exception!r}"
    return result.output


COIN = textbook.load("rolling_coin").values
UPRIGHT = ("rolling_coin", "--at", f"z={COIN['r']}", "-v")


def test_one_motion_has_its_exponents_and_matrices() -> None:
    """Of a thin disk upright λ² = 4 g/(5 r) − 12 n²/5 (Routh, Advanced Rigid Dynamics, 1905)."""
    n = 2 * np.sqrt(COIN["g"] / (3 * COIN["r"]))
    told = json.loads(run(*UPRIGHT, f"spin={n}", "--json"))
    assert told["stable"]
    expected = np.sqrt(12 * n * n / 5 - 4 * COIN["g"] / (5 * COIN["r"]))
    assert max(imag for _, imag in told["exponents"]) == pytest.approx(expected, rel=1e-8)
    assert np.shape(told["K"]) == (len(told["velocities"]), len(told["positions"]))


def test_speeds_make_a_table_and_a_plot(tmp_path: Path) -> None:
    file = tmp_path / "speeds.svg"
    text = run(*UPRIGHT, "spin=1", "--speeds", "15:20:2", "--plot", str(file))
    assert text.startswith(
        "rolling_coin: exponents of small deviations [1/s] by speed\n        15 "
    )
    assert "stability changes at: none in this range" in text
    assert "<svg" in file.read_text(encoding="utf-8")


def test_one_motion_is_told_in_words() -> None:
    text = run(*UPRIGHT, "spin=1")
    assert text.startswith("rolling_coin: unstable steady motion")
    assert "cyclic                  x, y" in text


def test_no_matrix_shows_the_rounding_of_another_entry() -> None:
    """The bicycle's M had -6.5e-15 beside 80.8, its C 8e-11 beside 169."""
    text = run("whipple_bicycle", "-v", "x=5")
    for block in text.split("\n\n")[2:]:
        entries = [abs(float(x)) for x in block.split()[1:]]
        assert all(x == 0 or x > 1e-12 * max(entries) for x in entries), block


def test_matrices_are_written_as_functions_of_the_speed() -> None:
    """C1 of the benchmark bicycle (Meijaard et al., Proc. R. Soc. A 463 (2007) 1955)."""
    words = "whipple_bicycle", "--at", "z=0.3", "-v", "x=1", "--expand", "roll", "--expand", "steer"
    told = json.loads(run(*words, "--json"))
    C1 = [[0.0, 33.86641391492494], [-0.85035641456978, 1.6854039739756]]
    np.testing.assert_allclose(told["C"][1], C1, rtol=0, atol=1e-10)
    assert told["coordinates"] == ["roll", "steer"]


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("whipple_bicycle", "--speeds", "1:2"), "expected --speeds FROM:TO:COUNT, got '1:2'"),
        (("whipple_bicycle", "--speeds", "2:1:5"), "FROM below TO and 2 to 1000"),
        (("whipple_bicycle", "--plot", "x.svg"), "expected --speeds with --plot"),
        (("double_pendulum", "--at", "q1=1"), "is not steady: q1'' = "),
        (("rolling_coin", "--expand", "x"), "expected names among"),
    ],
)
def test_wrong_words_are_refused(words: tuple[str, ...], message: str) -> None:
    said = " ".join(run(*words, code=2).split())
    assert message in said


@pytest.mark.parametrize("name", ["acrobot", "ball_on_a_turntable"])
def test_exponents_of_undamped_motions_have_no_real_part(name: str) -> None:
    # rounding left 1e-16 of them, and 1e-15 of a zero
    text = CliRunner().invoke(app, ["steady", name]).output
    listed = text.split("exponents [1/s]\n")[1].split("\n\n")[0].split()
    assert len(listed) == 4
    assert all(exponent == "0" or exponent.startswith(("0-", "0+")) for exponent in listed)
    assert not re.search(r"e-\d", " ".join(listed))


def test_matrices_are_printed_in_letters() -> None:
    """M_11 is the bicycle's moment of inertia about the line of its contacts."""
    words = ("whipple_bicycle", "-v", "x=1", "--expand", "roll", "--expand", "steer", "--letters")
    M = "M_11 = mR rR^2 + IRxx + mB zB^2 + IBxx + mH zH^2 + IHxx + mF rF^2 + IFxx"
    assert M in run(*words)


def test_all_methods_end_in_small_motions_once() -> None:
    text = CliRunner().invoke(app, ["derive", "simple_pendulum", "--method", "all"]).stdout
    assert text.count(". Small motions\n") == 1
    assert text.index(". Small motions\n") > text.rindex(". Result\n")
    assert text.count("natural angular frequency") == 1
