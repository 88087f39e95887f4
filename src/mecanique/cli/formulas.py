"""Commands on formulas: check them, grade sheets of them, make exercises, serve agents."""

from __future__ import annotations

import sys
from pathlib import Path

import click
from click.exceptions import Exit

import mecanique as mq
from mecanique.cli import options
from mecanique.cli.printing import progress, say, working
from mecanique.cli.words import Chosen, report_errors, takes_system
from mecanique.files import write_text


@click.command(
    epilog="Example: mecanique check rigid_bar_pendulum \"q'' + 3 g/(2 l) sin q = 0\"",
    # a formula may begin with minus
    context_settings={"ignore_unknown_options": True},
)
@options.system
@click.argument(
    "formulas",
    nargs=-1,
    metavar="FORMULA…",
    help="Equations in plain text, LaTeX, SymPy's text or MathML; a file with one equation "
    "per line; or - for standard input.",
)
@click.option(
    "--ask",
    default="equation of motion",
    metavar="WORDS",
    help="What the formula is meant to be: equation of motion, kinetic energy, potential energy, "
    "Lagrangian, energy, mass matrix, momentum of q, conserved quantity, frequency, "
    "undamped frequency, damped frequency (frequency at q = pi, frequency at steady motion), "
    "period, period from rest (at q0), equilibrium, equilibrium of BODY (cut free), "
    "equilibrium force, steady motion, reaction, state space, Hamiltonian, "
    "Hamilton's equations or transfer function of x from F.",
)
@options.several("--let", said='Define a letter: --let "J = m l^2/3"', metavar="LETTER=FORMULA")
@click.option("--letters", is_flag=True, help="List the letters that the question knows.")
@options.seed
@options.as_json
@takes_system
def check(
    chosen: Chosen,
    formulas: tuple[str, ...],
    ask: str,
    let: tuple[str, ...],
    letters: bool,
    seed: int,
    as_json: bool,
) -> None:
    """Check whether an equation is right, and if not, why not.

    The exit code is 1 unless it is right.
    """
    for word in formulas:
        if word.startswith("--"):
            raise click.NoSuchOption(word)
    mechanism = chosen.mechanism
    if letters:
        from mecanique.checking.check import list_letters

        for name, meaning in list_letters(mechanism, ask, let, seed, chosen.given).items():
            say(f"{name:12} {meaning}")
        return
    if not formulas:
        raise click.UsageError("expected a formula, or --letters")
    text = "\n".join(map(_read, formulas))
    verdict = mq.check(mechanism, text, ask, let, seed, chosen.given)
    say(verdict.to_json() if as_json else str(verdict))
    if not verdict.right:
        raise Exit(1)


@click.command(epilog="Example: mecanique grade sheet.toml answers --csv marks.csv")
@click.argument(
    "sheet", type=options.PATH, metavar="SHEET", help="A TOML or JSON file of questions."
)
@click.argument(
    "answers",
    type=options.PATH,
    metavar="ANSWERS",
    help="A folder with one folder (1a.txt, 1b.tex …) or one .toml per student.",
)
@options.file("--csv", "Write the marks to this file.")
@options.file("--html", "Write a page of the results.")
@report_errors
def grade(sheet: Path, answers: Path, csv: Path | None, html: Path | None) -> None:
    """Grade answers to a sheet, with partial credit and reasons."""
    from mecanique.teaching import grade as grade_sheet
    from mecanique.teaching import write_class_page

    with progress("Grading") as advance:
        grades = grade_sheet(sheet, answers, progress=advance)
    if csv is None and html is None:
        say(str(grades))
    if csv is not None:
        write_text(csv, grades.to_csv())
        say(f"Wrote {csv}")
    if html is not None:
        write_text(html, write_class_page(grades))
        say(f"Wrote {html}")


@click.command(epilog='Example: mecanique exercise cart_pole --seed 7 --ask "equation of motion"')
@click.argument("system", metavar="SYSTEM", help="A textbook system.")
@click.option(
    "--ask",
    default="equation of motion",
    metavar="WORDS",
    help="What it asks for: equation of motion, kinetic energy, potential energy, Lagrangian, "
    "energy, conserved quantity, mass matrix, momentum, Hamiltonian, Hamilton's equations, state "
    "space, equilibrium, equilibrium force, frequency, period, period from rest, undamped "
    "frequency, damped frequency or transfer function.",
)
@options.seed
@click.option(
    "--for",
    "course",
    type=click.Choice(["page", "scorm", "stack", "prairielearn", "nbgrader"]),
    help="Write it to --output for a learning platform: a page that judges by itself, the same "
    "as SCORM 1.2, Moodle's XML for STACK, a folder for PrairieLearn, or a notebook for nbgrader.",
)
@click.option(
    "--variants",
    type=click.IntRange(1, 100),
    default=1,
    metavar="NUMBER",
    help="Variants with numbers of their own, for STACK and PrairieLearn.",
)
@options.output(
    "Write problem.md, figure.svg and solution.md into this folder, or the course's file or "
    "folder here; printed by default.",
    metavar="PATH",
)
@report_errors
def exercise(
    system: str, ask: str, seed: int, course: str | None, variants: int, output: Path | None
) -> None:
    """Make an exercise with figure, numbers and verified solution."""
    from mecanique.teaching import export_exercise, make_exercise

    if course is not None and output is None:
        raise click.UsageError(f"--for {course} needs --output")
    with working("Making the exercise"):
        if course is not None and output is not None:
            seeds = range(seed, seed + variants)
            paths: tuple[Path, ...] = (export_exercise(system, course, output, ask, seeds),)
        else:
            made = make_exercise(system, ask, seed)
            paths = made.write(output) if output is not None else ()
    say("\n".join(f"Wrote {path}" for path in paths) or f"{made.problem}\n{made.solution}")


@click.command(epilog="Example: mecanique benchmark tasks.jsonl --number 1000 --seed 7")
@click.argument("tasks", type=options.PATH, metavar="TASKS")
@click.argument("answers", type=options.PATH, metavar="[ANSWERS]", required=False)
@click.option(
    "--number",
    type=click.IntRange(1, 100_000),
    default=1000,
    metavar="NUMBER",
    help="Number of tasks to write.",
)
@options.seed
@report_errors
def benchmark(tasks: Path, answers: Path | None, number: int, seed: int) -> None:
    """Write tasks for a model, or score its answers to them.

    TASKS is written as one JSON object per line, with id and prompt. ANSWERS, with id and answer,
    is judged as by 'check', and scored by kind of question.
    """
    from mecanique.teaching import benchmark

    if answers is None:
        with working("Making the tasks"):
            write_text(tasks, benchmark.write_lines(benchmark.make_tasks(number, seed)))
        say(f"Wrote {tasks}")
        return
    with working("Judging the answers"):
        asked = benchmark.read_lines(tasks, "prompt")
        score = benchmark.score_answers(asked, benchmark.read_lines(answers, "answer"))
    say(str(score))


@click.command(
    epilog="Example: mecanique agents, entered in the client's settings as a server's command"
)
@report_errors
def agents() -> None:
    """Serve agents over the Model Context Protocol (stdio)."""
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
