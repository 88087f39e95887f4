"""The page's scripts: their unit tests under node, and what joins them into one."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from collections import Counter
from pathlib import Path

import pytest

from mecanique.viewing.page.page import join_scripts, script_modules

ASSETS = Path(__file__).parents[2] / "src" / "mecanique" / "viewing" / "page" / "assets"
TESTS = Path(__file__).parent / "javascript"

IMPORT = re.compile(r"^import \{([^}]*)\} from \"(\.[\w./]+)\.js\";$", re.MULTILINE)
KIND = r"(?:async )?(?:function\*?|class|const|let)"
EXPORT = re.compile(rf"^export {KIND} (\w+)", re.MULTILINE)
DECLARED = re.compile(rf"^(?:export )?{KIND} (\w+)", re.MULTILINE)


def text(name: str) -> str:
    return (ASSETS / f"{name}.js").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def node() -> str:
    path = shutil.which("node")
    if path is None:
        reason = "no node found; install Debian's nodejs"
        if "node" in os.environ.get("MECANIQUE_REQUIRE_BROWSERS", "").split():
            pytest.fail(reason)
        pytest.skip(reason)
    return path


def test_the_unit_tests_of_the_scripts_pass(node: str) -> None:
    files = sorted(map(str, TESTS.glob("*.test.js")))
    done = subprocess.run(
        [node, "--test", *files], capture_output=True, encoding="utf-8", check=False
    )
    assert done.returncode == 0, done.stdout
    assert "# fail 0" in done.stdout


def test_every_script_of_the_page_is_in_it() -> None:
    found = {path.relative_to(ASSETS).with_suffix("").as_posix() for path in ASSETS.rglob("*.js")}
    assert found - {"boot", "gallery"} == set(script_modules())


@pytest.mark.parametrize("name", script_modules())
def test_a_script_imports_what_is_there_under_its_own_name(name: str) -> None:
    lines = [line for line in text(name).splitlines() if line.startswith("import")]
    found = IMPORT.findall(text(name))
    assert len(found) == len(lines)
    for names, source in found:
        wanted = {each.strip() for each in names.split(",")} - {""}
        there = (ASSETS / f"{name}.js").parent / f"{source}.js"
        assert wanted <= set(EXPORT.findall(there.read_text(encoding="utf-8"))), (name, source)


def test_no_two_scripts_declare_the_same_name() -> None:
    """They share one closure in the page."""
    counts = Counter(found for name in script_modules() for found in DECLARED.findall(text(name)))
    assert [name for name, count in counts.items() if count > 1] == []


def test_nothing_of_modules_is_left_in_the_page() -> None:
    joined = join_scripts()
    assert not re.search(r"^(import|export)\b", joined, re.MULTILINE)


@pytest.mark.parametrize("name", script_modules())
def test_no_text_of_a_script_goes_over_lines(name: str) -> None:
    """The page leaves out indentation, which would change such a text."""
    assert [line for line in text(name).splitlines() if line.count("`") % 2] == []
