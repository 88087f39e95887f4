"""The command line: parses words, calls the public API, prints."""

from __future__ import annotations

import gc
import os
import sys
from typing import TextIO, final

import click

import mecanique as mq
from mecanique.cli import derive, describe, formulas, motions, pictures, verify

__all__ = ["app", "main", "prepare_stream"]

_YOUNG = 200_000
"""So many new objects before garbage is collected; nearly all of a command live as long as it."""


GROUPS = {
    "Describe": (
        describe.list_,
        describe.urdf,
        describe.convert,
        describe.lint,
        describe.diff,
        describe.inertia,
    ),
    "Derive": (derive.derive, derive.code),
    "Verify": (verify.verify, verify.book),
    "Move": (motions.simulate, motions.linearize, motions.steady, motions.inertial),
    "Show": (pictures.run, pictures.export, pictures.view, pictures.picture, pictures.gallery),
    "Check": (formulas.check, formulas.grade),
    "Hand out": (formulas.exercise, formulas.benchmark, formulas.agents),
}
"""The commands by what a user wants to do, in the order of the work."""


@final
class _Program(click.Group):
    """A program whose help lists the commands by what a user wants to do."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the names of the commands, in the order in which they were added."""
        return list(self.commands)

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write a section for each group."""
        width = max(map(len, self.commands))
        for title, commands in GROUPS.items():
            rows = [(f"{c.name:{width}}", c.get_short_help_str(formatter.width)) for c in commands]
            with formatter.section(title):
                formatter.write_dl(rows)


@click.group(
    "mecanique",
    cls=_Program,
    context_settings={"help_option_names": ["-h", "--help"], "show_default": True},
    epilog="Exit codes: 0 success, 1 a disagreement or an error found, 2 bad input. "
    "Start with: mecanique run rigid_bar_pendulum",
)
@click.version_option(
    mq.__version__, message="mecanique %(version)s", help="Print the version and exit."
)
def app() -> None:
    """Derive equations of motion, check them against Pinocchio, and set them in motion.

    A SYSTEM is the name of a textbook system, a URDF, xacro, MJCF or SDF file, or the name of a
    robot from example-robot-data.
    """


for _commands in GROUPS.values():
    for _command in _commands:
        app.add_command(_command)


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
