"""What differs from one system to another is named: encodings, folders, modules of one system."""

from __future__ import annotations

import ast
import io
import os
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

import mecanique as mq
from mecanique.cli import prepare_stream
from mecanique.generation.compiled import build_library
from mecanique.motion.compile.stepper import can_compile

ROOT = Path(__file__).parents[1]
FOLDERS = ("src", "tests", "examples", "docs")
FILES = sorted(
    path
    for folder in FOLDERS
    for path in (ROOT / folder).rglob("*.py")
    # benchmarks are measured by hand, on Linux, and a copy may be written while this is read
    if not {"benchmarks", "_generated"} & set(path.parts)
)
TEMPORARY = "/" + "tmp/"
OF_ONE_SYSTEM = {"crypt", "fcntl", "grp", "posix", "pty", "pwd", "resource", "termios", "winreg"}
CALLS = {"os.fork", "os.getuid", "os.rename", "os.setsid"}
SUSPECT = re.compile(
    "|".join(
        [r"\bopen\(", r"_text\(", r"\btext=", TEMPORARY, *map(re.escape, (*CALLS, *OF_ONE_SYSTEM))]
    )
)
"""What a file must hold to be looked at more closely."""


def find_faults(text: str) -> Iterator[str]:
    """Yield what behaves in another way on another system, with its line."""
    if not SUSPECT.search(text):
        return
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Call) and _without_encoding(node):
            yield f"{node.lineno}: a text file without its encoding"
        names = [each.name for each in node.names] if isinstance(node, ast.Import) else []
        if isinstance(node, ast.ImportFrom):
            names = [node.module or ""]
        if OF_ONE_SYSTEM & set(names):
            yield f"{node.lineno}: a module that not every system has"  # type: ignore[attr-defined]
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
            called = f"{node.value.id}.{node.attr}"
            if called in CALLS:
                yield f"{node.lineno}: {called}"
        if isinstance(node, ast.Constant) and str(node.value).startswith(TEMPORARY):
            yield f"{node.lineno}: a folder that not every system has"


def _without_encoding(call: ast.Call) -> bool:
    name = call.func.attr if isinstance(call.func, ast.Attribute) else getattr(call.func, "id", "")
    if any(keyword.arg in ("encoding", None) for keyword in call.keywords):
        return False
    if name in ("run", "Popen", "check_output"):  # what a process says
        return any(keyword.arg == "text" for keyword in call.keywords)
    if name == "read_text":
        return not call.args
    if name == "write_text":
        return len(call.args) < 2
    if name != "open":
        return False
    positions = call.args[1:] if isinstance(call.func, ast.Name) else call.args
    mode = positions[0] if positions else None
    modes = [keyword.value for keyword in call.keywords if keyword.arg == "mode"]
    mode = modes[0] if modes else mode
    if mode is None:
        return not call.keywords  # a method of another kind takes arguments of its own
    return isinstance(mode, ast.Constant) and isinstance(mode.value, str) and "b" not in mode.value


@pytest.mark.parametrize("folder", FOLDERS)
def test_nothing_supposes_one_operating_system(folder: str) -> None:
    files = [path for path in FILES if path.is_relative_to(ROOT / folder)]
    assert files
    found = [
        f"{path.relative_to(ROOT).as_posix()}:{fault}"
        for path in files
        for fault in find_faults(path.read_text(encoding="utf-8"))
    ]
    assert not found, "\n".join(found)


@pytest.mark.parametrize(
    ("text", "faults"),
    [
        ("path.read_text()", 1),
        ("path.read_text('utf-8')", 0),
        ("path.write_text(text)", 1),
        ("path.write_text(text, encoding='utf-8')", 0),
        ("open(path)", 1),
        ("open(path, 'rb')", 0),
        ("open(path, 'w', encoding='utf-8')", 0),
        ("path.open()", 1),
        ("path.open('w')", 1),
        ("path.open('xb')", 0),
        ("subprocess.run(command, text=True)", 1),
        ("subprocess.run(command, encoding='utf-8')", 0),
        ("import fcntl", 1),
        ("from resource import getrusage", 1),
        ("Path(TEMPORARY)".replace("TEMPORARY", repr(TEMPORARY)), 1),
        ("os.rename(a, b)", 1),
        ("os.replace(a, b)", 0),
    ],
)
def test_faults_are_found(text: str, faults: int) -> None:
    assert len(list(find_faults(text))) == faults


@pytest.mark.parametrize(
    ("platform", "named", "written"),
    [
        ("win32", "", "θ λ".encode()),
        ("win32", "cp1252", b"? ?"),
        ("linux", "", b"? ?"),
    ],
)
def test_what_is_redirected_on_windows_has_every_letter(
    platform: str, named: str, written: bytes, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("PYTHONIOENCODING", raising=False)
    if named:
        monkeypatch.setenv("PYTHONIOENCODING", named)
    file = io.BytesIO()
    stream = io.TextIOWrapper(file, encoding="cp1252", newline="")
    prepare_stream(stream, platform)
    stream.write("θ λ")
    stream.flush()
    assert file.getvalue() == written


@pytest.mark.skipif(os.name != "posix", reason="the compiler is a script of the shell")
def test_a_compiler_for_another_system_is_found_out(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    foreign = tmp_path / "foreign-cc"
    script = '#!/bin/sh\nwhile [ "$1" != -o ]; do shift; done\nprintf MZ > "$2"\n'
    foreign.write_text(script, encoding="utf-8")
    foreign.chmod(0o755)
    monkeypatch.setenv("CC", str(foreign))
    with pytest.raises(mq.InputError, match="foreign-cc made one that does not load"):
        build_library({"one.c": "int one(void) { return 1; }\n"})
    can_compile.cache_clear()
    assert not can_compile()
    can_compile.cache_clear()
