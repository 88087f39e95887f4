"""A browser is enough: what the documentation's page unpacks needs nothing that is not there."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest
from packaging.markers import Marker
from packaging.requirements import Requirement
from uncovered import without_coverage

ROOT = Path(__file__).parents[2]
BROWSER = {"sys_platform": "emscripten", "platform_machine": "wasm32", "os_name": "posix"}
COMPILED = {"numpy", "scipy", "sympy"}
"""What Pyodide's own distribution brings."""
PURE = {"click", "example-robot-data", "lark", "rich", "threadpoolctl", "u-msgpack-python"}


def required() -> list[Requirement]:
    """Return what the package depends on."""
    text = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    listed = text.partition("\ndependencies = [")[2].partition("\n]")[0]
    return [Requirement(line) for line in re.findall(r'^  "(.+?)",', listed, re.MULTILINE)]


def holds(marker: Marker | None, environment: dict[str, str]) -> bool:
    return marker is None or marker.evaluate(environment)


def test_a_browser_is_asked_for_nothing_that_has_no_build_for_it() -> None:
    new = {**BROWSER, "python_version": "3.13"}
    assert {each.name for each in required() if holds(each.marker, new)} == COMPILED | PURE


@pytest.mark.parametrize(
    ("platform", "engine"), [("linux", True), ("darwin", True), ("win32", False)]
)
def test_other_systems_are_asked_for_what_they_have(platform: str, engine: bool) -> None:
    environment = {"sys_platform": platform, "python_version": "3.13"}
    names = {each.name for each in required() if holds(each.marker, environment)}
    assert {"meshcat", "tornado"} <= names
    assert ("pin" in names) == engine


@pytest.fixture
def archive(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """What the documentation's page unpacks."""
    monkeypatch.syspath_prepend(ROOT / "docs")
    from pack import pack

    path = tmp_path / "mecanique.zip"
    pack(path)
    return path


def test_all_runs_without_what_a_browser_lacks(archive: Path, tmp_path: Path) -> None:
    assert archive.stat().st_size < 4e6
    folder = tmp_path / "unpacked"
    with zipfile.ZipFile(archive) as packed:
        packed.extractall(folder)
    script = Path(__file__).with_name("only_a_browser.py")
    done = subprocess.run(
        [sys.executable, "-I", str(script), str(folder)],
        env=without_coverage(),
        capture_output=True,
        encoding="utf-8",
        check=False,
        timeout=300,
    )
    assert done.stdout == "all runs in a browser\n", done.stderr


def test_what_needs_no_numbers_runs_in_pyodide(archive: Path) -> None:
    """Every module compiles there without a warning, and a fifth needs none of its builds."""
    node = shutil.which("node")
    if node is None or not (ROOT / "node_modules" / "pyodide").is_dir():
        pytest.skip("no Pyodide found; run npm install")
    here = Path(__file__)
    done = subprocess.run(
        [node, here.with_name("in_pyodide.mjs"), archive, here.with_name("in_pyodide.py")],
        capture_output=True,
        encoding="utf-8",
        check=False,
        timeout=300,
    )
    told = re.fullmatch(r"(\d+) compiled, (\d+) imported\n", done.stdout)
    assert told, done.stderr[-2000:]
    compiled, imported = map(int, told.groups())
    assert compiled > 400
    assert imported > 50
