"""Commands that compare: equations with the reference, and a chapter with both."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click
from click.exceptions import Exit

import mecanique as mq
from mecanique.cli import options
from mecanique.cli.options import FileOptions, reads_files
from mecanique.cli.printing import named_progress, progress, say, to_json, working
from mecanique.cli.words import choose, numbers, report_errors, source

if TYPE_CHECKING:
    from mecanique.verification.chapter.row import ChapterRow
    from mecanique.verification.facts import FactRow
    from mecanique.verification.survey import Survey


SAMPLES, SAMPLES_OF_ROBOTS = 100, 50
"""Numbers of random states at which to compare a system, and each robot."""

_PROCESSES = 2


@click.command(epilog="Example: mecanique verify cart_pole --samples 1000 --json")
@click.argument(
    "system",
    required=False,
    metavar="[SYSTEM]",
    help="A textbook system, a URDF, xacro, MJCF or SDF file, or a robot's name.",
)
@click.option(
    "--samples",
    type=int,
    metavar="NUMBER",
    help="Number of random states to compare; 100 by default, 50 with --robots, fewer for "
    "one SYSTEM with more than 60 velocities.",
)
@options.seed
@options.parameters
@click.option(
    "--against",
    metavar="OTHER",
    help="Compare with this instead of Pinocchio: another SYSTEM, FILE.csv (samples), or "
    "a program, which is run: FILE.py (functions M, C, g …), FILE.fmu or FILE.so.",
)
@options.file("--header", "The C header of --against FILE.so.", "FILE.h")
@options.real("--tolerance", "Largest accepted relative difference; 1e-9 by default.")
@click.option(
    "--engines",
    default="",
    metavar="NAMES",
    help="Further engines that read the file themselves, comma-separated: mujoco, drake, exudyn.",
)
@click.option("--states", is_flag=True, help="Print the states with the largest disagreements.")
@click.option("--all", "every", is_flag=True, help="Verify every textbook system.")
@click.option("--robots", is_flag=True, help="Verify every robot of example-robot-data.")
@options.as_json
@report_errors
@reads_files
def verify(
    system: str | None,
    samples: int | None,
    seed: int,
    parameters: tuple[str, ...],
    against: str | None,
    header: Path | None,
    tolerance: float | None,
    engines: str,
    states: bool,
    every: bool,
    robots: bool,
    as_json: bool,
    *,
    reading: FileOptions,
) -> None:
    """Compare the equations with Pinocchio, and check known facts.

    The exit code is 1 if they disagree or a fact does not hold.
    """
    from mecanique.reference.engine.package import engine_name

    if against is not None and system is None:
        raise click.BadParameter("expected a SYSTEM with --against")
    if header is not None and against is None:
        raise click.BadParameter("expected --against with --header")
    if (system is not None) + every + robots != 1:
        raise click.BadParameter("expected one of: a SYSTEM, --all, --robots")
    if system is None and tolerance is not None:
        raise click.BadParameter("expected a SYSTEM with --tolerance")
    if system is None:
        usual = SAMPLES_OF_ROBOTS if robots else SAMPLES
        surveyed = survey(usual if samples is None else samples, seed, robots=robots)
        say(surveyed.to_json() if as_json else str(surveyed))
        raise Exit(0 if surveyed.agrees else 1)
    chosen = choose(system, parameters, reading)
    compared_with = None if against is None else source(against, reading)
    with named_progress(f"Comparing with {against or engine_name()}") as advance:
        verdict = mq.verify(
            chosen.mechanism,
            samples,
            seed,
            against=compared_with,
            header=header,
            tolerance=tolerance,
            engines=[word for word in engines.split(",") if word],
            progress=advance,
        )
        facts = () if against is not None else textbook_facts(system, parameters, seed)
    if as_json:
        listed = {"facts": [fact.to_dict() for fact in facts]} if facts else {}
        say(to_json({**verdict.to_dict(), **listed}))
    else:
        worst = verdict.worst_states if states else ()
        say("\n".join([str(verdict), *worst, *map(str, facts)]))
        chosen.tell_omissions()
    if not verdict.agrees or any(fact.fails for fact in facts):
        raise Exit(1)


@click.command(epilog="Example: mecanique book --json")
@options.as_json
@report_errors
def book(as_json: bool) -> None:
    """Check the equations and statements of the first chapter.

    Points that are not checked are listed. The exit code is 1 if an equation or a statement is
    wrong and its correction is not proven.
    """
    from mecanique.verification.chapter import register

    with working("Checking the equations of the chapter"):
        rows = register()
    say(to_json([row.to_dict() for row in rows]) if as_json else register_as_text(rows))
    if not all(row.sound for row in rows):
        raise Exit(1)


def textbook_facts(system: str, parameters: Sequence[str], seed: int) -> tuple[FactRow, ...]:
    """Check the facts of a textbook system; there are none of any other."""
    if not mq.textbook.catalogue.is_known(system):
        return ()
    from mecanique.verification.facts import check_facts

    return check_facts(system, numbers(parameters, "-p"), seed=seed, simulate=mq.simulate)


def survey(samples: int, seed: int, *, robots: bool) -> Survey:
    """Verify every textbook system, or every robot, and show progress."""
    from mecanique.verification.survey import survey_robots, survey_systems

    verify, what = (survey_robots, "robot") if robots else (survey_systems, "textbook system")
    with progress(f"Verifying every {what}") as advance:
        processes = min(_PROCESSES, os.cpu_count() or 1)
        return verify(samples, seed, processes=processes, progress=advance)


def register_as_text(rows: tuple[ChapterRow, ...]) -> str:
    """Return the register as text, a summary first."""
    checked = [row for row in rows if row.holds is not None]
    parts = [_count(kind, checked) for kind in ("equation", "sentence")]
    left = len(rows) - len(checked)
    head = f"Fundamentals of Dynamics, chapter 1: {'; '.join(parts)}; {left} points not checked"
    return "\n".join([head, "", *map(str, rows)])


def _count(kind: str, checked: Sequence[ChapterRow]) -> str:
    """How many equations or sentences there are, and which are in error."""
    rows = [row for row in checked if row.about == kind]
    wrong = [row.number for row in rows if not row.holds]
    errors = "none in error as printed"
    if wrong:
        sound = "NOT ALL PROVEN"
        if all(row.sound for row in rows):
            sound = "each with its right form" + (" proven" if kind == "equation" else "")
        errors = f"{len(wrong)} in error as printed ({', '.join(wrong)}), {sound}"
    return f"{len(rows)} {kind}s, {len(rows) - len(wrong)} hold, {errors}"
