"""Everything README and the pages of commands show runs as it stands there."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest
from click.testing import CliRunner

from mecanique.cli import GROUPS, app

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")
REFERENCE = (ROOT / "docs" / "commands.md").read_text(encoding="utf-8")
BLOCK = re.compile(r"^```(\w+)\n(.*?)^```$", re.DOTALL | re.MULTILINE)
INSTALLERS = ("pip ", "pytest", "sphinx-build ")

COMMANDS = [
    command.strip()
    for kind, text in BLOCK.findall(README + REFERENCE)
    if kind == "sh"
    for line in text.splitlines()
    for command in line.split("&&")
    if command.strip()
]


def test_only_python_and_shell_is_shown() -> None:
    assert {kind for kind, _ in BLOCK.findall(README)} == {"python", "sh"}
    assert all(command.startswith(("mecanique ", *INSTALLERS)) for command in COMMANDS)


def test_it_is_read_in_a_few_minutes() -> None:
    assert len(README.splitlines()) <= 120
    assert README.count("<img ") == 1


def test_the_two_commands_of_the_set_up_are_there() -> None:
    lines = README.splitlines()
    assert "pip install . && mecanique run rigid_bar_pendulum" in lines
    assert "pip install '.[test]' && pytest" in lines


def test_its_python_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    for number, (kind, text) in enumerate(BLOCK.findall(README)):
        if kind == "python":
            exec(compile(text, f"README.md, block {number}", "exec"), names)
    assert {path.name for path in tmp_path.iterdir()} == {"page.html"}


def test_every_command_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for command in COMMANDS:
        if not command.startswith(INSTALLERS):
            result = CliRunner().invoke(app, shlex.split(command)[1:])
            assert result.exit_code == 0, f"{command}: {result.output}{result.exception!r}"
            assert result.stdout.strip(), command
    assert "q'' + 3 g sin(q)/(2 l) = 0" in README


def test_the_reference_lists_every_command_in_its_group() -> None:
    _, *sections = re.split(r"^## (.+)$", REFERENCE, flags=re.MULTILINE)
    shown = {
        title: re.findall(r"^\| `mecanique (\w+)", text, re.MULTILINE)
        for title, text in zip(sections[::2], sections[1::2], strict=True)
    }
    assert {title: sorted(names) for title, names in shown.items()} == {
        title: sorted(str(command.name) for command in commands)
        for title, commands in GROUPS.items()
    }


def test_the_named_files_exist() -> None:
    for name in ("CHANGELOG.md", "CONTRIBUTING.md", "LICENSE"):
        assert f"`{name}`" in README
        assert (ROOT / name).is_file()
