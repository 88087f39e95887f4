"""Put the commands together into one program."""

from __future__ import annotations

from typing import final

import click

import mecanique as mq
from mecanique.cli import bodies, code, equations, formulas, motions, pictures


@final
class _Program(click.Group):
    """A program whose help lists the commands in the order of a user's work."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the names of the commands, in the order in which they were added."""
        return list(self.commands)


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

    A SYSTEM is the name of a textbook system, the path of a URDF file, or the name of a robot from
    example-robot-data.
    """


for command in (
    equations.list_,
    equations.derive,
    equations.book,
    equations.verify,
    equations.lint,
    equations.diff,
    equations.urdf,
    bodies.inertia,
    formulas.check,
    formulas.grade,
    formulas.exercise,
    formulas.agents,
    code.code,
    motions.simulate,
    motions.linearize,
    motions.steady,
    motions.inertial,
    pictures.run,
    pictures.export,
    pictures.view,
    pictures.picture,
    pictures.gallery,
):
    app.add_command(command)
