"""Everything README shows runs as it stands there."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest
from click.testing import CliRunner

from mecanique.cli import app

README = (Path(__file__).parents[1] / "README.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"^```(\w+)\n(.*?)^```$", README, re.DOTALL | re.MULTILINE)
INSTALLERS = ("pip ", "pytest", "sphinx-build ")

COMMANDS = [
    command.strip()
    for kind, text in BLOCKS
    if kind == "sh"
    for line in text.splitlines()
    for command in line.split("&&")
    if command.strip()
]


def test_only_python_and_shell_is_shown() -> None:
    assert {kind for kind, _ in BLOCKS} == {"python", "sh"}
    assert all(command.startswith(("mecanique ", *INSTALLERS)) for command in COMMANDS)


def test_the_two_commands_of_the_set_up_are_there() -> None:
    lines = README.splitlines()
    assert "pip install . && mecanique run rigid_bar_pendulum" in lines
    assert "pip install '.[test]' && pytest" in lines


def test_the_python_tour_runs_from_top_to_bottom(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    for number, (kind, text) in enumerate(BLOCKS):
        if kind == "python":
            exec(compile(text, f"README.md, block {number}", "exec"), names)
    assert {path.name for path in tmp_path.iterdir()} == {
        "controller",
        "motion.npz",
        "page.html",
        "cart_pole.urdf",
    }


def test_every_command_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for command in COMMANDS:
        if not command.startswith(INSTALLERS):
            result = CliRunner().invoke(app, shlex.split(command)[1:])
            assert result.exit_code == 0, f"{command}: {result.output}{result.exception!r}"
            assert result.stdout.strip(), command
    assert "q'' + 3 g sin(q)/(2 l) = 0" in README


def test_the_table_lists_every_command() -> None:
    shown = set(re.findall(r"^\| `mecanique (\w+)", README, re.MULTILINE))
    assert shown == set(app.commands)


def test_the_named_files_exist() -> None:
    root = Path(__file__).parents[1]
    for name in ("CHANGELOG.md", "CONTRIBUTING.md", "LICENSE"):
        assert f"`{name}`" in README
        assert (root / name).is_file()
