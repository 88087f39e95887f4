"""Put the commands together into one program."""

from __future__ import annotations

from typing import Annotated

import typer

import mecanique as mq
from mecanique.cli import bodies, code, equations, formulas, motions, pictures
from mecanique.cli.printing import say

__all__ = ["app"]

app = typer.Typer(
    no_args_is_help=True,
    rich_markup_mode=None,  # panels take longer to import than everything else the help needs
    add_completion=False,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
    epilog="Exit codes: 0 success, 1 a disagreement or an error found, 2 bad input. "
    "Start with: mecanique run rigid_bar_pendulum",
)


def _version(asked: bool) -> None:
    if asked:
        say(f"mecanique {mq.__version__}")
        raise typer.Exit


@app.callback()
def _mecanique(
    version: Annotated[
        bool,
        typer.Option(
            "--version", callback=_version, is_eager=True, help="Print the version and exit."
        ),
    ] = False,
) -> None:
    """Derive equations of motion, check them against Pinocchio, and set them in motion.

    A SYSTEM is the name of a textbook system, the path of a URDF file, or the name of a robot from
    example-robot-data.
    """


for room in (equations, bodies, formulas, code, motions, pictures):
    app.add_typer(room.app)
