"""How many tests run at once, which come first, and which need Pinocchio itself."""

from __future__ import annotations

import contextlib
import gc
import io
import os
import runpy
import subprocess
import sys
from collections import Counter
from importlib.util import find_spec
from pathlib import Path

import pytest

pytest.register_assert_rewrite("viewing_browser", "viewing_watcher", "viewing_firefox")


def pytest_xdist_auto_num_workers() -> int | None:
    """Run half as many again as there are cores: tests of pages and programs wait much."""
    if "PYTEST_XDIST_AUTO_NUM_WORKERS" in os.environ:
        return None
    return 3 * len(os.sched_getaffinity(0)) // 2 if hasattr(os, "sched_getaffinity") else None


def pytest_configure() -> None:
    """Keep what is compiled, or each of some hundred processes compiles the whole package anew.

    Robots that somebody has fetched are none of the tests'.
    """
    sys.dont_write_bytecode = False
    os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
    os.environ["ROBOT_DESCRIPTIONS_CACHE"] = os.devnull


@pytest.fixture
def in_process(monkeypatch: pytest.MonkeyPatch) -> None:
    """Run the Python code that is generated in this process, which has imported numpy already."""
    from mecanique.generation.targets.target import run_command

    def run(command: list[str]) -> subprocess.CompletedProcess[str]:
        if command[0] != sys.executable or len(command) != 2:
            return run_command(command)
        said, complaint = io.StringIO(), io.StringIO()
        with (
            contextlib.redirect_stdout(said),
            contextlib.redirect_stderr(complaint),
            pytest.raises(SystemExit) as ended,
        ):
            runpy.run_path(command[1], run_name="__main__")
        returned = int(ended.value.code or 0)
        return subprocess.CompletedProcess(command, returned, said.getvalue(), complaint.getvalue())

    monkeypatch.setattr("mecanique.generation.verdict.run_command", run)


def pytest_collection_finish() -> None:
    """Look less often for garbage: what all tests share lives to the end and is much."""
    gc.freeze()
    gc.set_threshold(50_000, 20, 50)


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add an option that runs a part of every file's tests."""
    told = "run the first test of each file and every Nth after it"
    parser.addoption("--every", type=int, default=1, metavar="N", help=told)


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Begin with the pages, so that one process has them and waits while others compute."""
    chosen = take_every(config.getoption("every"), items)
    if len(chosen) < len(items):
        config.hook.pytest_deselected(items=list(set(items) - set(chosen)))
        items[:] = chosen
    items.sort(key=lambda item: "viewing" not in item.path.parts)
    if find_spec("pinocchio") is None:
        reason = "needs Pinocchio itself, which is not installed"
        for item in items:
            if item.get_closest_marker("engine"):
                item.add_marker(pytest.mark.skip(reason=reason))


def take_every(n: int, items: list[pytest.Item]) -> list[pytest.Item]:
    """Return the first test of each file and every nth after it, of those without a mark `slow`."""
    seen: Counter[Path] = Counter()
    chosen = []
    for item in items:
        if n == 1 or not item.get_closest_marker("slow"):
            if seen[item.path] % n == 0:
                chosen.append(item)
            seen[item.path] += 1
    return chosen
