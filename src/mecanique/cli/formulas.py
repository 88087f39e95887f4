"""Commands on formulas: check them, grade sheets of them, make exercises, serve agents."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

import mecanique as mq
from mecanique.cli.printing import progress, say, working, write_text
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
            "equilibrium, equilibrium of BODY (cut free) or reaction.",
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


@app.command(epilog="Example: mecanique grade sheet.toml answers --csv marks.csv")
@report_errors
def grade(
    sheet: Annotated[
        Path, typer.Argument(metavar="SHEET", help="A TOML or JSON file of questions.")
    ],
    answers: Annotated[
        Path,
        typer.Argument(
            metavar="ANSWERS",
            help="A folder with a folder (1a.txt, 1b.tex …) or a .toml for each student.",
        ),
    ],
    csv: Annotated[
        Path | None, typer.Option("--csv", metavar="FILE", help="Write the marks to this file.")
    ] = None,
) -> None:
    """Grade answers to a sheet, with partial credit and reasons."""
    from mecanique.teaching import grade as grade_sheet

    with progress("Grading") as advance:
        found = grade_sheet(sheet, answers, progress=advance)
    if csv is None:
        say(str(found))
    else:
        write_text(csv, found.to_csv())
        say(f"Wrote {csv}")


@app.command(epilog='Example: mecanique exercise cart_pole --seed 7 --ask "equation of motion"')
@report_errors
def exercise(
    system: Annotated[str, typer.Argument(metavar="SYSTEM", help="A textbook system.")],
    ask: Annotated[
        str,
        typer.Option(
            metavar="WORDS",
            help="equation of motion, kinetic energy, potential energy, Lagrangian, mass matrix "
            "or frequency.",
        ),
    ] = "equation of motion",
    seed: Seed = 0,
    output: Annotated[
        Path | None,
        typer.Option(
            "--output",
            "-o",
            metavar="DIR",
            help="Write problem.md, figure.svg and solution.md there; printed by default.",
        ),
    ] = None,
) -> None:
    """Make an exercise: a problem with figure and numbers, and its verified solution."""
    from mecanique.teaching import make_exercise

    with working("Making the exercise"):
        made = make_exercise(system, ask, seed)
        paths = made.write(output) if output is not None else ()
    say("\n".join(f"Wrote {path}" for path in paths) or f"{made.problem}\n{made.solution}")


@app.command(epilog="Example: mecanique agents, as the command of a server in a client's settings")
@report_errors
def agents() -> None:
    """Serve agents by the Model Context Protocol over standard input and output."""
    from mecanique.serving.agents import serve

    serve()


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
