"""The command line: parses words, calls the public API, prints."""

from __future__ import annotations

import gc
import os
import sys
from typing import TextIO

from mecanique.cli.commands import app

__all__ = ["app", "main", "prepare_stream"]

_YOUNG = 200_000
"""So many new objects before garbage is collected; nearly all of a command live as long as it."""


def main() -> None:
    """Run the command line."""
    for stream in (sys.stdout, sys.stderr):
        prepare_stream(stream, sys.platform)
    gc.set_threshold(_YOUNG)
    # NumPy reads it when it is imported; threads of BLAS spin while they wait for large matrices
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    app(prog_name="mecanique")


def prepare_stream(stream: TextIO, platform: str) -> None:
    """Let a stream take every letter; a terminal that has no θ shows a question mark."""
    if not hasattr(stream, "reconfigure"):
        return
    unnamed = "PYTHONIOENCODING" not in os.environ
    # code pages of Windows have no Greek
    redirected = platform == "win32" and not stream.isatty()
    stream.reconfigure(encoding="utf-8" if redirected and unnamed else None, errors="replace")
