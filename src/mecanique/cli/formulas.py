"""The command that checks submitted formulas."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

import mecanique as mq
from mecanique.cli.printing import say
from mecanique.cli.reading import Reading, reads_files
from mecanique.cli.words import AsJson, Parameters, Seed, SystemName, choose, report_errors

__all__ = ["app"]

app = typer.Typer()


@app.command(epilog="Example: mecanique check rigid_bar_pendulum \"q'' + 3 g/(2 l) sin q = 0\"")
@report_errors
@reads_files
def check(
    system: SystemName,
    formulas: Annotated[
        list[str],
        typer.Argument(
            metavar="FORMULA…",
            help="Equations in plain text, LaTeX, SymPy's text or MathML; the path of a file with "
            "one a line; or - to read them from standard input.",
        ),
    ],
    ask: Annotated[
        str,
        typer.Option(
            metavar="WORDS",
            help="What it is meant to be: equation of motion, kinetic energy, potential energy, "
            "Lagrangian, energy, mass matrix, momentum of q, conserved quantity, frequency, "
            "equilibrium or reaction.",
        ),
    ] = "equation of motion",
    let: Annotated[
        list[str] | None,
        typer.Option(metavar="LETTER=FORMULA", help='Define a letter: --let "J = m l^2/3"'),
    ] = None,
    parameters: Parameters = None,
    seed: Seed = 0,
    as_json: AsJson = False,
    *,
    reading: Reading,
) -> None:
    """Check whether an equation is right, and if not, why not.

    The exit code is 1 unless it is right.
    """
    mechanism = choose(system, parameters, reading).mechanism
    text = "\n".join(map(_read, formulas))
    found = mq.check(mechanism, text, ask, let or (), seed)
    say(found.to_json() if as_json else str(found))
    if not found.right:
        raise typer.Exit(1)


def _read(word: str) -> str:
    """Return a formula, or the text of the file that a word names."""
    if word == "-":
        return sys.stdin.read()
    if word.endswith((".txt", ".tex", ".mml", ".xml")) and "=" not in word:
        path = Path(word)
        if not path.is_file():
            raise mq.InputError(f"expected a formula or a file, but there is no file {word!r}")
        return path.read_text(encoding="utf-8", errors="replace")
    return word
