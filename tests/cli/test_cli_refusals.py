"""Bad input gives one clear message on standard error and exit code 2; help helps."""

from __future__ import annotations

import re
import signal
import subprocess
import sys
from collections.abc import Iterator
from importlib.metadata import entry_points
from pathlib import Path

import pytest
from click.testing import CliRunner
from uncovered import without_coverage

import mecanique as mq
from mecanique.cli import app, words

COMMANDS = sorted(app.commands)


@pytest.fixture(autouse=True)
def _elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("bad.urdf").write_text("<robot>", encoding="utf-8")
    Path("notes.txt").write_text("no robot at all", encoding="utf-8")


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (
            "derive rigid_bar_pendulm",
            "unknown system 'rigid_bar_pendulm'; did you mean 'rigid_bar_pendulum'",
        ),
        ("derive rigid_bar_pendulum --method newton", "unknown method 'newton'; "),
        ("verify cart_pole -p L=1", "unknown parameter 'L'; "),
        (
            "verify cart_pole -p l",
            "expected NAME=VALUE with a finite number after -p, e.g. l=2.0, got 'l'",
        ),
        ("verify cart_pole -p l=long", "got 'l=long'"),
        ("verify cart_pole -p l=nan", "got 'l=nan'"),
        ("verify cart_pole -p =3", "got '=3'"),
        ("verify cart_pole -p m=-1", "body 'pole': its mass is negative (-1 kg)"),
        (
            "verify cart_pole --samples 0",
            "expected a whole number of at least 1 for samples, got 0",
        ),
        ("verify cart_pole --seed -1", "expected a whole number of at least 0 for seed, got -1"),
        ("derive nowhere.sdf", "SDF file, but there is no file 'nowhere.sdf'"),
        (
            "verify nowhere.urdf",
            "expected a URDF, MJCF or SDF file, but there is no file 'nowhere.urdf'",
        ),
        (
            "verify ./folder/robot",
            "expected a URDF, MJCF or SDF file, but there is no file './folder/robot'",
        ),
        ("verify bad.urdf", "bad.urdf:1:"),
        ("verify notes.txt", "notes.txt:1:"),
        ("urdf cart_pole -o missing/cart.urdf", "missing/cart.urdf"),
        ("simulate cart_pole -q phi=1", "unknown coordinate 'phi'"),
        ("simulate cart_pole -v phi=1", "unknown velocity 'phi'"),
        ("simulate cart_pole -q q=inf", "expected NAME=VALUE with a finite number after -q"),
        ("simulate cart_pole --duration 0", "duration"),
        ("simulate cart_pole --duration nan", "duration"),
        ("simulate cart_pole --rtol 0", "rtol"),
        ("simulate cart_pole --duration 0.1 --csv missing/cart.csv", "missing/cart.csv"),
        ("export cart_pole --duration 0.1 -o missing/cart.html", "missing"),
    ],
)
def test_bad_input_is_refused_with_one_message(words: str, message: str) -> None:
    result = CliRunner().invoke(app, words.split())
    assert result.exit_code == 2, result.output + repr(result.exception)
    assert message in result.stderr.replace("\n", " ")
    assert result.stderr.startswith("error: ")
    assert "Traceback" not in result.output
    assert result.stdout == ""


@pytest.mark.parametrize(
    "words", ["verify", "fly cart_pole", "verify cart_pole --fast", "derive cart_pole --format pdf"]
)
def test_wrong_usage_is_refused_too(words: str) -> None:
    result = CliRunner().invoke(app, words.split())
    assert result.exit_code == 2
    assert "Usage:" in result.stderr


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_explains_itself_with_an_example(command: str) -> None:
    result = CliRunner().invoke(app, [command, "--help"])
    assert result.exit_code == 0
    assert f"Example: mecanique {command}" in " ".join(result.stdout.split())


def test_the_commands_are_those_of_the_design() -> None:
    assert {"derive", "export", "list", "run", "simulate", "urdf", "verify", "view"} <= set(
        COMMANDS
    )


def test_help_and_version() -> None:
    text = CliRunner().invoke(app, ["--help"]).stdout
    assert all(command in text for command in COMMANDS)
    assert "mecanique run rigid_bar_pendulum" in " ".join(text.split())
    groups = text.partition("\nDescribe:\n")[2]
    assert re.findall(r"^  (\w+)  ", groups, re.MULTILINE) == list(app.commands)
    titles = ["Derive", "Verify", "Move", "Show", "Check", "Hand out"]
    assert re.findall(r"^([A-Z][a-z ]+):$", groups, re.MULTILINE) == titles
    sentences = [line for line in groups.splitlines() if line.startswith("  ")]
    assert len(sentences) == len(COMMANDS) + 2, "each command takes one line of 80 characters"
    result = CliRunner().invoke(app, ["--version"])
    assert (result.exit_code, result.stdout) == (0, f"mecanique {mq.__version__}\n")


def test_the_entry_point_runs_as_a_program() -> None:
    done = subprocess.run(
        [sys.executable, "-m", "mecanique", "verify", "nothing"],
        capture_output=True,
        encoding="utf-8",
        check=False,
    )
    assert done.returncode == 2
    assert done.stderr.startswith("error: unknown system 'nothing'")
    assert done.stdout == ""
    (script,) = entry_points(group="console_scripts", name="mecanique")
    assert script.value == "mecanique.cli:main"


def test_a_file_is_written_into_a_directory_that_exists(tmp_path: Path) -> None:
    before = {path.name for path in tmp_path.iterdir()}
    words = ["inertia", mq.robot("double_pendulum"), "-o", tmp_path / "none" / "new.urdf"]
    done = CliRunner().invoke(app, [str(word) for word in words])
    assert done.exit_code == 2
    assert "expected a path in a directory that exists" in done.stderr
    words[-1] = tmp_path / "new.urdf"
    assert CliRunner().invoke(app, [str(word) for word in words]).exit_code == 0
    assert {path.name for path in tmp_path.iterdir()} == {*before, "new.urdf"}


def test_ctrl_c_before_there_is_a_motion_needs_no_message(monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(words, "choose", interrupt)
    result = CliRunner().invoke(app, ["derive", "two_blocks"])
    assert (result.exit_code, result.output) == (130, "")


@pytest.fixture
def interruptible() -> Iterator[None]:
    """Let Ctrl-C work here and in subprocesses, even where tests run in the background."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


ANNOUNCE = """
import sys
import mecanique as mq
from mecanique.cli import main

simulate = mq.simulate

def announce(*args, **options):
    print("simulating", flush=True)
    return simulate(*args, **options)

mq.simulate = announce
main()
"""


def test_ctrl_c_ends_with_130(interruptible: None) -> None:
    words = [sys.executable, "-c", ANNOUNCE, "simulate", "double_pendulum", "--duration", "3000"]
    with subprocess.Popen(
        words,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        encoding="utf-8",
        env=without_coverage(),
    ) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "simulating\n"
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=60)
    assert process.returncode == 130, errors
    assert "Traceback" not in errors
