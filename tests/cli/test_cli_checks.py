"""`mecanique lint`, robots by name, and whole collections."""

from __future__ import annotations

import json
import re
import shutil
from pathlib import Path
from zipfile import ZipFile

import pytest
from click.testing import CliRunner, Result

from mecanique.cli import app
from mecanique.verification import facts
from mecanique.verification import survey as survey_module
from mecanique.verification.facts import FactRow
from mecanique.verification.survey import Survey

TEXT = '<robot name="arm"><link name="a"/><link name="b"><inertial><mass value="1"/>'
TEXT += '<origin xyz="1 0 0"/>{}</inertial></link><joint name="j" type="revolute">'
TEXT += '<parent link="a"/><child link="b"/><axis xyz="0 0 {}"/>'
TEXT += '<limit effort="1" velocity="1"/></joint></robot>'
INERTIA = '<inertia ixx="{}" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>'


@pytest.fixture(autouse=True)
def _elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("good.urdf").write_text(TEXT.format(INERTIA.format(1), 1), encoding="utf-8")
    Path("long_axis.urdf").write_text(TEXT.format(INERTIA.format(1), 2), encoding="utf-8")
    Path("bad.urdf").write_text(TEXT.format(INERTIA.format(5), 1), encoding="utf-8")
    Path("no.urdf").write_text("no robot", encoding="utf-8")


def call(*words: str) -> Result:
    return CliRunner().invoke(app, words)


@pytest.mark.parametrize(
    ("file", "code", "said"),
    [
        ("good.urdf", 0, ""),
        ("bad.urdf", 1, "bad.urdf:1: error M203 link 'b'"),
        ("no.urdf", 2, "no.urdf:1: error M002"),
        ("missing.urdf", 2, "missing.urdf:1: error M001"),
        ("ur3", 1, "error M101 the robot has no name"),
    ],
)
def test_lint_ends_with_the_right_code(file: str, code: int, said: str) -> None:
    result = call("lint", file)
    assert result.exit_code == code, result.output
    assert said in result.stdout


def test_lint_takes_what_other_commands_take() -> None:
    folder = Path("ws", "odd")
    folder.mkdir(parents=True)
    (folder / "package.xml").write_text("<package><name>arms</name></package>", encoding="utf-8")
    shutil.copy("bad.urdf", folder / "bad.urdf")
    with ZipFile("arms.zip", "w") as archive:
        archive.write(folder / "bad.urdf", "arm/bad.urdf")
    words = ("arms.zip", "arms.zip/arm/bad.urdf", str(folder), "package://arms/bad.urdf")
    for word in words:
        result = call("lint", word, "--package-path", "ws")
        assert (result.exit_code, "error M203 link 'b'" in result.stdout) == (1, True), word
        assert call("inertia", word, "--package-path", "ws").exit_code == 0, word


def test_lint_prints_json_and_sarif() -> None:
    findings = json.loads(call("lint", "bad.urdf", "--json").stdout)["findings"]
    assert "M203" in {finding["code"] for finding in findings}
    log = json.loads(call("lint", "bad.urdf", "--sarif").stdout)
    assert "M203" in {result["ruleId"] for result in log["runs"][0]["results"]}


def test_lint_mends_a_copy() -> None:
    before = Path("long_axis.urdf").read_text(encoding="utf-8")
    assert "M3" in call("lint", "long_axis.urdf").stdout
    printed = call("lint", "long_axis.urdf", "--fix")
    assert printed.exit_code == 0
    assert printed.stdout == before.replace('"0 0 2"', '"0 0 1"')
    assert call("lint", "long_axis.urdf", "--fix", "-o", "mended.urdf").exit_code == 0
    assert Path("mended.urdf").read_text(encoding="utf-8") == printed.stdout
    assert Path("long_axis.urdf").read_text(encoding="utf-8") == before
    refused = call("lint", "good.urdf", "-o", "mended.urdf")
    assert (refused.exit_code, "expected --fix with --output" in refused.stderr) == (2, True)


def test_robots_are_known_by_name_and_may_float() -> None:
    fixed, floating = (
        json.loads(call("verify", "TwoDofs", "--root", root, "--samples", "3", "--json").stdout)
        for root in ("fixed", "floating")
    )
    assert fixed["agrees"]
    assert floating["agrees"]
    assert len(floating["rows"][0]["v"]) == len(fixed["rows"][0]["v"]) + 6


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("verify pandra", "did you mean 'panda'"),
        ("verify cart_pol", "did you mean 'cart_pole'"),
        ("verify anymal", "expected one of 'anymal_b_simple/anymal', 'anymal_c_simple/anymal'"),
        ("verify cart_pole --root floating", "expected a URDF file or a robot for --root floating"),
        ("derive cart_pole --keep masses", "expected a URDF file or a robot for --keep"),
        ("derive cart_pole --arg m=2", "expected a URDF file or a robot for --arg"),
    ],
)
def test_wrong_names_are_told_the_right_ones(words: str, said: str) -> None:
    result = call(*words.split())
    assert result.exit_code == 2
    assert said in result.stderr


def test_verify_states_the_facts_of_a_textbook_system() -> None:
    words = ("verify", "rigid_bar_pendulum", "-p", "l=2", "--samples", "3")
    text = call(*words)
    assert text.exit_code == 0
    assert re.search(r"fact holds \(\de-1\d\), kinetic energy: T = m l² q'² / 6\n", text.stdout)
    assert text.stdout.count("fact holds") == 5
    rows = json.loads(call(*words, "--json").stdout)["facts"]
    assert [row["kind"] for row in rows][-1] == "Period"
    assert all(row["holds"] and row["residual"] < 1e-10 for row in rows)


def test_a_fact_that_fails_ends_verify_with_one(monkeypatch: pytest.MonkeyPatch) -> None:
    rows = (FactRow("x", "Period", "T = 3", 1e-3), FactRow("x", "Steady", "q = 0", 1e-12))
    monkeypatch.setattr(facts, "check_facts", lambda *words, **options: rows)
    result = call("verify", "cart_pole", "--samples", "3")
    assert result.exit_code == 1
    assert "fact FAILS (1e-03), period: T = 3\n" in result.stdout
    assert "fact holds (1e-12), steady: q = 0\n" in result.stdout
    data = json.loads(call("verify", "cart_pole", "--samples", "3", "--json").stdout)
    assert data["agrees"]
    assert [row["fails"] for row in data["facts"]] == [True, False]


def test_a_fact_without_a_value_is_reported_and_does_not_fail() -> None:
    words = ("verify", "bead_on_hoop", "-p", "W=0.5", "--samples", "3")
    result = call(*words)
    assert result.exit_code == 0
    assert "fact has no value here (its state is not defined), steady: above it" in result.stdout
    row = json.loads(call(*words, "--json").stdout)["facts"][2]
    assert (row["holds"], row["fails"], row["residual"]) == (False, False, None)
    assert row["reason"] == "its state is not defined"


@pytest.mark.parametrize("words", [(), ("cart_pole", "--all"), ("--all", "--robots")])
def test_verify_wants_one_thing(words: tuple[str, ...]) -> None:
    result = call("verify", *words)
    assert result.exit_code == 2
    assert "--robots" in result.stderr


@pytest.mark.parametrize("agrees", [True, False])
def test_collections_are_surveyed(agrees: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[tuple[str, int]] = []

    def survey(kind: str) -> object:
        def one(samples: int, seed: int, **words: object) -> Survey:
            asked.append((kind, samples))
            worst = 1e-15 if agrees else 1.0
            entry = survey_module.Entry("x", "fixed", 1, worst, "bias", "", 0.0)
            return Survey((entry,), samples, seed, 1e-9, 0.0)

        return one

    monkeypatch.setattr(survey_module, "survey_systems", survey("systems"))
    monkeypatch.setattr(survey_module, "survey_robots", survey("robots"))
    for words in (("--all",), ("--robots",), ("--robots", "--samples", "7")):
        result = call("verify", *words)
        assert result.exit_code == (0 if agrees else 1), result.output
        assert "agree at" in result.stdout
    assert asked == [("systems", 100), ("robots", 50), ("robots", 7)]
    assert json.loads(call("verify", "--all", "--json").stdout)["agrees"] is agrees


def test_a_tolerance_acts_on_one_system_and_is_refused_with_all() -> None:
    runner = CliRunner()
    near = TEXT.format(INERTIA.format(1).replace('izz="1"', 'izz="1.00001"'), 1)
    Path("near.urdf").write_text(near, encoding="utf-8")
    words = ["verify", "good.urdf", "--against", "near.urdf", "--samples", "5"]
    assert runner.invoke(app, words).exit_code == 1
    assert runner.invoke(app, [*words, "--tolerance", "1e-3"]).exit_code == 0
    every = runner.invoke(app, ["verify", "--all", "--tolerance", "1e-3"])
    assert every.exit_code == 2
    assert "expected a SYSTEM with --tolerance" in every.output


def test_lint_balances_inertias_and_says_what_changed() -> None:
    result = call("lint", "bad.urdf", "--fix", "--balance", "-o", "balanced.urdf")
    assert "nearest possible inertia, line 1: link 'b': " in result.stderr
    assert "M203" not in call("lint", "balanced.urdf").stdout
    alone = call("lint", "bad.urdf", "--balance")
    assert (alone.exit_code, "expected --fix with --balance" in alone.stderr) == (2, True)


def test_a_flawed_file_is_verified_unless_strict() -> None:
    result = call("verify", "bad.urdf", "--samples", "3", "--floating", "--json")
    verdict = json.loads(result.stdout)
    assert (result.exit_code, verdict["agrees"]) == (0, True)
    assert [flaw["code"] for flaw in verdict["flaws"]] == ["M203"]
    strict = call("verify", "bad.urdf", "--strict")
    assert (strict.exit_code, "triangle inequality" in strict.stderr) == (2, True)


def test_check_takes_a_formula_that_begins_with_minus() -> None:
    found = call("check", "simple_pendulum", "-m g l sin q = m l^2 q''")
    assert found.exit_code == 0, found.output
    refused = call("check", "simple_pendulum", "--lettres")
    assert refused.exit_code == 2
    assert "No such option" in refused.output
    assert "expected a formula, or --letters" in call("check", "simple_pendulum").output


def test_check_lists_the_letters_of_a_question() -> None:
    found = call("check", "simple_pendulum", "--letters", "--ask", "frequency")
    assert found.exit_code == 0, found.output
    lines = found.output.splitlines()
    assert any(line.split()[0] == "omega" and "[1/s]" in line for line in lines)
    assert any(line.split()[0] == "l" and "[m]" in line for line in lines)
