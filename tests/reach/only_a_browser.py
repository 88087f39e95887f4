"""Run what a browser runs: without Pinocchio, servers, threads and processes.

Usage: python only_a_browser.py ARCHIVE, the archive that the documentation's page unpacks.
"""

from __future__ import annotations

import _thread
import subprocess
import sys
import threading
import time
from collections.abc import Sequence
from importlib.machinery import ModuleSpec, PathFinder
from types import ModuleType
from typing import Any

ABSENT = {
    "pinocchio", "meshcat", "tornado", "zmq", "example_robot_data", "heyoka", "cffi", "jax",
    "click", "rich", "multiprocessing", "_posixsubprocess",
}  # fmt: skip


class Browser:
    """Finds modules as Pyodide does: what has no build for it is not there."""

    @staticmethod
    def find_spec(
        name: str, path: Sequence[str] | None = None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """Return where a module is; of what is absent only what the archive brings."""
        if name.partition(".")[0] in ABSENT:
            path = [entry for entry in sys.path if entry == sys.argv[1]]
        return PathFinder.find_spec(name, path, target)


def refuse(*_: Any, **__: Any) -> Any:
    """Start no thread and no process."""
    raise OSError("a browser starts no thread and no process")


def block() -> None:
    """Take away what a browser does not have, and read the package from the archive."""
    paths = [finder for finder in sys.meta_path if finder is PathFinder]
    for finder in paths:
        sys.meta_path[sys.meta_path.index(finder)] = Browser
    _thread.start_new_thread = refuse
    for name in ("_start_new_thread", "_start_joinable_thread"):
        if hasattr(threading, name):
            setattr(threading, name, refuse)
    del time.thread_time
    subprocess.Popen = refuse  # type: ignore[misc, assignment]
    sys.path.insert(0, sys.argv[1])


def main() -> None:
    """Derive, verify, move, linearize, draw, check, generate and show."""
    block()
    import mecanique as mq

    assert mq.__file__.startswith(sys.argv[1])
    double = mq.textbook.load("double_pendulum")
    verdict = mq.verify(double, samples=5)
    assert verdict.agrees
    assert verdict.worst < 1e-12
    motion = mq.simulate(double, q={"q1": 1.0}, duration=2.0)
    assert motion.audit().ok
    linkage = mq.textbook.load("four_bar_linkage")
    start = mq.textbook.entry("four_bar_linkage").start
    assert mq.simulate(linkage, q=start, duration=0.5).audit().ok
    assert len(mq.linearize(double).frequencies) == 2
    assert mq.picture(double).svg.startswith("<svg")
    pendulum = mq.textbook.load("rigid_bar_pendulum")
    assert mq.check(pendulum, "q'' + 3 g sin(q)/(2 l) = 0").outcome == "right"
    for text in (mq.convert(pendulum, form).text for form in ("URDF", "MJCF", "SDF")):
        for form in ("URDF", "MJCF", "SDF"):
            conversion = mq.convert(mq.read(text), form)
            assert not conversion.proved  # without an engine of the format
            assert not conversion.differs
            assert "; not proved: no engine of " in str(conversion)
            assert conversion.worst < 1e-12
    refused = ""
    try:
        mq.generate(mq.derive(pendulum), target="python")
    except mq.EngineError as error:
        refused = str(error)
    assert "none can be started here (a browser starts no thread" in refused
    assert "<iframe" in (motion._repr_html_() or "")
    lengths = mq.simulate_many(pendulum, {"q": [0.1, 1.0]}, duration=0.5)
    assert lengths["q"].shape[0] == 2
    print("all runs in a browser")


if __name__ == "__main__":
    main()
