"""How many tests run at once, and which come first."""

from __future__ import annotations

import os

import pytest

pytest.register_assert_rewrite("viewing_browser", "viewing_watcher", "viewing_firefox")


def pytest_xdist_auto_num_workers() -> int | None:
    """Run half as many again as there are cores: tests of pages and programs wait much."""
    if "PYTEST_XDIST_AUTO_NUM_WORKERS" in os.environ:
        return None
    return 3 * len(os.sched_getaffinity(0)) // 2 if hasattr(os, "sched_getaffinity") else None


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Begin with the pages, so that one process has them and waits while others compute."""
    items.sort(key=lambda item: "viewing" not in item.path.parts)
