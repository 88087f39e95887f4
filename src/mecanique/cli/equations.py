"""Commands on equations: list, derive, compare, read and write them."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, Literal

import click
from click.exceptions import Exit

import mecanique as mq
from mecanique.cli import options
from mecanique.cli.checks import Check, lint_file, survey, textbook_facts
from mecanique.cli.formats.derivations import (
    as_document,
    derivation,
    derivations,
    in_one_coordinate,
    reduction,
)
from mecanique.cli.printing import named_progress, say, working
from mecanique.cli.reading import Reading, reads_files
from mecanique.cli.words import choose, report_errors, source

SAMPLES, SAMPLES_OF_ROBOTS = 100, 50
"""Numbers of random states at which to compare a system, and each robot."""


@click.command("list", epilog="Example: mecanique list --tag pendulum")
@click.option("--tag", multiple=True, metavar="TAG", help="Only systems with this tag; repeatable.")
@options.as_json
@report_errors
def list_(tag: tuple[str, ...], as_json: bool) -> None:
    """List the textbook systems with their degrees of freedom N."""
    entries = {name: mq.textbook.entry(name) for name in mq.textbook.names()}
    known = sorted(set().union(*(entry.tags for entry in entries.values())))
    for word in tag:
        if word not in known:
            raise mq.UnknownNameError("tag", word, known)
    rows = [_row(name) for name, entry in entries.items() if set(tag) <= set(entry.tags)]
    if as_json:
        say(json.dumps(rows, ensure_ascii=False, indent=2))
        return
    name_width = max((len(row["name"]) for row in rows), default=0)
    title_width = max((len(row["title"]) for row in rows), default=0)
    for row in rows:
        columns = f"{row['name']:{name_width}}  {row['title']:{title_width}}"
        say(f"{columns}  N = {row['N']}  {', '.join(row['tags'])}")


@click.command(epilog="Example: mecanique derive two_blocks --method all --steps")
@options.system
@click.option(
    "--method",
    default="lagrange",
    metavar="METHOD",
    help="newton_euler, virtual_work, lagrange, or all (in turn, with every step).",
)
@click.option(
    "--format",
    "form",
    type=click.Choice(["text", "latex", "mathml"]),
    default="text",
    help="Output format.",
)
@click.option("--steps", is_flag=True, help="Show every step of the derivation.")
@click.option("--units", is_flag=True, help="Show the unit that each line's terms have, in text.")
@click.option("--document", is_flag=True, help="Print a complete LaTeX file, with every step.")
@click.option(
    "--routh",
    is_flag=True,
    help="Reduce the equations by the momenta of the cyclic coordinates (Routh), and "
    "compare them with the full ones.",
)
@click.option(
    "--in",
    "alone",
    metavar="COORDINATE",
    help="Reduce a mechanism whose loops leave one motion free to one equation in this "
    "coordinate, by kinematic coefficients.",
)
@options.parameters
@report_errors
@reads_files
def derive(
    system: str,
    method: str,
    form: Literal["text", "latex", "mathml"],
    steps: bool,
    units: bool,
    document: bool,
    routh: bool,
    alone: str | None,
    parameters: tuple[str, ...],
    *,
    reading: Reading,
) -> None:
    """Print what a system is, what its letters mean, and its equations of motion."""
    if units and (form != "text" or steps or document or method == "all"):
        raise click.BadParameter("expected --units without --steps, --format and --method all")
    reduced = routh or alone is not None
    if reduced and (units or method != "lagrange" or (routh and alone is not None)):
        raise click.BadParameter("expected one of --routh, --in, --units, --method")
    chosen = choose(system, parameters, reading)
    form, steps = ("latex" if document else form), steps or document
    with working("Deriving the equations of motion"):
        if routh:
            text = reduction(chosen.mechanism, form, steps)
        elif alone is not None:
            text = in_one_coordinate(chosen.mechanism, alone, form, steps)
        elif method == "all":
            text = derivations(chosen.mechanism, form)
        else:
            text = derivation(chosen.mechanism, method, form, steps, units=units)
    say(as_document([text]) if document else text)


@click.command(epilog="Example: mecanique book --json")
@options.as_json
@report_errors
def book(as_json: bool) -> None:
    """Check the catalogue's first chapter: its equations, and what its sentences state.

    What is not checked is said. The exit code is 1 if an equation or a sentence is in error and
    its right form is not proven.
    """
    from mecanique.cli.formats import book as printed
    from mecanique.verification.chapter import register

    with working("Checking the equations of the chapter"):
        rows = register()
    say(printed.as_json(rows) if as_json else printed.as_text(rows))
    if not all(row.sound for row in rows):
        raise Exit(1)


@click.command(epilog="Example: mecanique verify cart_pole --samples 1000 --json")
@click.argument(
    "system",
    required=False,
    metavar="[SYSTEM]",
    help="A textbook system, a URDF file or a robot's name.",
)
@click.option(
    "--samples",
    type=int,
    metavar="NUMBER",
    help="Number of random states at which to compare; 100, or 50 for --robots, and fewer "
    "of one SYSTEM with more than 60 velocities.",
)
@options.seed
@options.parameters
@click.option(
    "--against",
    metavar="OTHER",
    help="Compare with this instead of Pinocchio: another SYSTEM, FILE.csv (samples), or "
    "a program, which is run: FILE.py (functions M, C, g …), FILE.fmu, or FILE.so.",
)
@click.option(
    "--header", type=options.PATH, metavar="FILE.h", help="The C header of --against FILE.so."
)
@click.option(
    "--tolerance",
    type=float,
    metavar="NUMBER",
    help="Largest relative difference that is accepted; 1e-9 by default.",
)
@click.option(
    "--engines",
    default="",
    metavar="NAMES",
    help="Engines that read the file itself besides Pinocchio, with commas: mujoco, drake.",
)
@click.option("--states", is_flag=True, help="Print the states where what disagrees is worst.")
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
    reading: Reading,
) -> None:
    """Compare the derived equations with Pinocchio; check facts.

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
    other = None if against is None else source(against, reading)
    with named_progress(f"Comparing with {against or engine_name()}") as advance:
        verdict = mq.verify(
            chosen.mechanism,
            samples,
            seed,
            against=other,
            header=header,
            tolerance=tolerance,
            engines=[word for word in engines.split(",") if word],
            progress=advance,
        )
        facts = () if against is not None else textbook_facts(system, parameters, seed)
    check = Check(verdict, facts, states)
    say(check.to_json() if as_json else str(check))
    if not check.right:
        raise Exit(1)


@click.command(epilog="Example: mecanique lint panda --json")
@click.argument("file", metavar="FILE", help="A URDF file, or the name of a robot.")
@options.as_json
@click.option("--sarif", "as_sarif", is_flag=True, help="Print SARIF, for editors and code hosts.")
@click.option("--fix", is_flag=True, help="Write a copy with every safe repair made.")
@click.option(
    "--balance",
    is_flag=True,
    help="With --fix: give each inertia that no real body has the nearest one that a body "
    "can have, and say what changed.",
)
@click.option(
    "--output",
    "-o",
    type=options.PATH,
    help="Where to write the repaired copy; printed by default.",
)
@click.option(
    "--meshes",
    is_flag=True,
    help="Read mesh files, too, for centers of mass outside of them and impossible densities.",
)
@report_errors
@reads_files
def lint(
    file: str,
    as_json: bool,
    as_sarif: bool,
    fix: bool,
    balance: bool,
    output: Path | None,
    meshes: bool,
    *,
    reading: Reading,
) -> None:
    """Report what is wrong in a URDF file.

    The exit code is 1 if there are errors, 2 if the file cannot be read.
    """
    form = "text"
    if as_json or as_sarif:
        form = "json" if as_json else "sarif"
    code = lint_file(file, form, reading, fix=fix, output=output, balance=balance, meshes=meshes)
    raise Exit(code)


@click.command(epilog="Example: mecanique diff old.urdf new.urdf")
@click.argument("first", metavar="A", help="A URDF file, robot or system.")
@click.argument("second", metavar="B", help="The other.")
@options.as_json
@report_errors
@reads_files
def diff(first: str, second: str, as_json: bool, *, reading: Reading) -> None:
    """List what differs between two descriptions, by its weight in the dynamics.

    The exit code is 1 if anything differs.
    """
    found = mq.diff(*(choose(word, (), reading).mechanism for word in (first, second)))
    say(found.to_json() if as_json else str(found))
    if not found.same:
        raise Exit(1)


@click.command(epilog="Example: mecanique urdf two_blocks -o two_blocks.urdf")
@options.system
@click.option("--output", "-o", type=options.PATH, help="Write to this file instead of printing.")
@options.parameters
@report_errors
@reads_files
def urdf(
    system: str, output: Path | None, parameters: tuple[str, ...], *, reading: Reading
) -> None:
    """Write a system as URDF."""
    mechanism = choose(system, parameters, reading).mechanism
    if output is None:
        click.echo(mq.write_urdf(mechanism), nl=False)
    else:
        mq.write_urdf(mechanism, output)
        say(f"Wrote {output}")


def _row(name: str) -> dict[str, Any]:
    """Return what `mecanique list` prints about a textbook system."""
    entry = mq.textbook.entry(name)
    parameters = {p.symbol: {"value": p.value, "unit": p.unit} for p in entry.parameters}
    return {
        "name": name,
        "title": entry.title,
        "N": _freedom(name),
        "source": entry.source,
        "parameters": parameters,
        "tags": list(entry.tags),
    }


def _freedom(name: str) -> int:
    """Return the degrees of freedom of a textbook system; only constraints need the engine."""
    mechanism = mq.textbook.load(name)
    if not mechanism.constrained:
        return mechanism.nv
    from mecanique.reference import degrees_of_freedom

    return int(degrees_of_freedom(mechanism, mq.textbook.entry(name).start).N)
