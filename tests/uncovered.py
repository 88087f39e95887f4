"""Processes whose lines are not counted as covered."""

from __future__ import annotations

import os


def without_coverage() -> dict[str, str]:
    """Return the environment for a process that does not measure its coverage.

    An interrupt that comes while coverage holds its lock leaves the lock held, and the process
    waits for it without end; a copy of the package counts as lines that nothing covers.
    """
    return {name: value for name, value in os.environ.items() if "COVERAGE" not in name}
