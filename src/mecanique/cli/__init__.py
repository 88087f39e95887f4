"""The command line: parses words, calls the public API, prints."""

from __future__ import annotations

import gc
import sys

from mecanique.cli.commands import app

__all__ = ["app", "main"]

_YOUNG = 10_000
"""So many new objects before garbage is collected; nearly all of a command live as long as it."""


def main() -> None:
    """Run the command line.

    The exit code is 0 for success, 1 for a disagreement, 2 for bad input, 130 for Ctrl-C.
    """
    for stream in (sys.stdout, sys.stderr):
        # a terminal that has no θ prints a question mark instead of a traceback
        if hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="replace")
    gc.set_threshold(_YOUNG)
    app(prog_name="mecanique")
