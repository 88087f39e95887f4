"""The commands, one function each."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

import mecanique as mq
from mecanique.cli.checks import linted, surveyed
from mecanique.cli.derivations import derivation, derivations
from mecanique.cli.linear import figures, inertial_figures, response_table, small_motions
from mecanique.cli.printing import complain, heading, named_progress, say, show, verdict_table, working
from mecanique.cli.words import (
    Coordinates,
    Duration,
    Parameters,
    Samples,
    Seed,
    SystemName,
    Tolerance,
    Velocities,
    choose,
    guarded,
    numbers,
    simulated,
    source,
)

if TYPE_CHECKING:
    from mecanique.verify.survey import Survey

__all__ = ["app"]

app = typer.Typer(
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
    epilog="Exit codes: 0 fine or agrees, 1 disagrees, 2 bad input. Start with: mecanique run rigid_bar_pendulum",
)

AsJson = Annotated[bool, typer.Option("--json", help="Print JSON for scripts.")]
IsFloating = Annotated[bool, typer.Option("--floating", help="Leave the root link of a URDF or robot free.")]
Page = Annotated[Path | None, typer.Option("--output", "-o", help="The page to write; ./SYSTEM.html by default.")]


def _version(asked: bool) -> None:
    if asked:
        say(f"mecanique {mq.__version__}")
        raise typer.Exit


@app.callback()
def _mecanique(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Print the version and leave.")
    ] = False,
) -> None:
    """Equations of motion: derived independently, checked against Pinocchio, then set in motion.

    A SYSTEM is the name of a textbook system, a path to a URDF file, or the name of a robot of example-robot-data.
    """


@app.command("list", epilog="Example: mecanique list --tag pendulum")
@guarded
def list_(
    tag: Annotated[
        list[str] | None, typer.Option(metavar="TAG", help="Only systems with this tag; may be given again.")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """List the textbook systems: name, what each is, its degrees of freedom N, tags."""
    entries = {name: mq.textbook.entry(name) for name in mq.textbook.names()}
    known = sorted({word for entry in entries.values() for word in entry.tags})
    for word in tag or ():
        if word not in known:
            raise mq.UnknownNameError("tag", word, known)
    entries = {name: entry for name, entry in entries.items() if set(tag or ()) <= set(entry.tags)}
    rows = [
        {
            "name": name,
            "title": entry.title,
            "N": _freedom(name),
            "source": entry.source,
            "parameters": {p.symbol: {"value": p.value, "unit": p.unit} for p in entry.parameters},
            "tags": list(entry.tags),
        }
        for name, entry in entries.items()
    ]
    if as_json:
        say(json.dumps(rows, ensure_ascii=False, indent=2))
        return
    width, wide = (max((len(str(row[key])) for row in rows), default=0) for key in ("name", "title"))
    for row, entry in zip(rows, entries.values(), strict=True):
        say(f"{row['name']:{width}}  {row['title']:{wide}}  N = {row['N']}  {', '.join(entry.tags)}")


@app.command(epilog="Example: mecanique gallery pages")
@guarded
def gallery(
    directory: Annotated[Path, typer.Argument(metavar="DIR", help="Where the pages go; made if it is not there.")],
    systems: Annotated[
        list[str] | None, typer.Option("--only", metavar="SYSTEM", help="Only this system; may be given again.")
    ] = None,
    duration: Duration = None,
    only_pictures: Annotated[bool, typer.Option("--pictures", help="Only the pictures, as SVG files.")] = False,
) -> None:
    """Write an offline page for every textbook system, and an index with pictures."""
    from mecanique.view.gallery import gallery as write
    from mecanique.view.gallery import pictures

    if only_pictures:
        say(f"Wrote {len(pictures(directory, systems))} pictures to {directory}")
        return
    with named_progress("Writing pages") as advance:
        cards = write(directory, systems, duration=duration, progress=advance)
    failed = [card for card in cards if card.fault]
    for card in failed:
        complain(f"{card.name}: {card.fault}")
    say(f"Wrote {directory / 'index.html'}: {len(cards) - len(failed)} of {len(cards)} systems")
    if failed:
        raise typer.Exit(1)


@app.command(epilog="Example: mecanique run rigid_bar_pendulum -p l=2 -q q=1")
@guarded
def run(
    system: SystemName,
    parameters: Parameters = None,
    q: Coordinates = None,
    v: Velocities = None,
    duration: Duration = None,
    samples: Samples = 100,
    seed: Seed = 0,
    rtol: Tolerance = 1e-10,
    output: Page = None,
) -> None:
    """Do everything: derive, verify, simulate, and write an offline page."""
    chosen = choose(system, parameters)
    mechanism = chosen.mechanism
    with working("Deriving the equations of motion"):
        equations = mq.derive(mechanism)
        text = str(equations)
    heading(f"Equations of motion of {mechanism.name}")
    say(text)
    with working(f"Comparing with Pinocchio at {samples} states"):
        verdict = mq.verify(mechanism, samples=samples, seed=seed)
    say("")
    heading("Verdict")
    heading(verdict.summary, "green" if verdict.agrees else "bold red")
    show(verdict_table(verdict))
    for remark in verdict.remarks:
        say(remark)
    motion = simulated(chosen, q, v, duration, rtol)
    say("")
    heading("Motion")
    say(motion.summary())
    path = output or Path(f"{mechanism.name}.html")
    with working(f"Writing {path}"):
        mq.export(motion, path, equations=equations, verdict=verdict)
    say("")
    say(f"Wrote {path}: open it in a browser, no network needed.")
    if not verdict.agrees:
        raise typer.Exit(1)


@app.command(epilog="Example: mecanique derive two_blocks --method all --steps")
@guarded
def derive(
    system: SystemName,
    method: Annotated[
        str,
        typer.Option(
            metavar="METHOD",
            help="How to derive: newton_euler, virtual_work, lagrange, or all, with every step, in this order.",
        ),
    ] = "lagrange",
    form: Annotated[Literal["text", "latex", "mathml"], typer.Option("--format", help="How to print.")] = "text",
    steps: Annotated[bool, typer.Option("--steps", help="Show each step of the derivation.")] = False,
    parameters: Parameters = None,
) -> None:
    """Print the equations of motion."""
    chosen = choose(system, parameters)
    with working("Deriving the equations of motion"):
        text = (
            derivations(chosen.mechanism, form)
            if method == "all"
            else derivation(chosen.mechanism, method, form, steps)
        )
    say(text)


@app.command(epilog="Example: mecanique book --json")
@guarded
def book(as_json: AsJson = False) -> None:
    """Check every equation of the chapter; the exit code is 1 if a right form is not proven."""
    from mecanique.book import register
    from mecanique.cli import book as printed

    with working("Checking the equations of the chapter"):
        rows = register()
    say(printed.as_json(rows) if as_json else printed.as_text(rows))
    if not all(row.sound for row in rows):
        raise typer.Exit(1)


@app.command(epilog="Example: mecanique verify cart_pole --samples 1000 --json")
@guarded
def verify(
    system: Annotated[
        str | None,
        typer.Argument(
            metavar="[SYSTEM]", help="A textbook system, a URDF file or a robot's name.", show_default=False
        ),
    ] = None,
    samples: Annotated[
        int | None, typer.Option(metavar="NUMBER", help="Number of random states to compare at; 100, of --robots 50.")
    ] = None,
    seed: Seed = 0,
    parameters: Parameters = None,
    root: Annotated[
        Literal["fixed", "floating"], typer.Option("--root", help="How the root link of a URDF is held.")
    ] = "fixed",
    against: Annotated[
        str | None,
        typer.Option(
            metavar="OTHER",
            help="Instead of Pinocchio: another SYSTEM, FILE.py (functions M, C, g …) or FILE.csv (samples).",
        ),
    ] = None,
    tolerance: Annotated[
        float, typer.Option(metavar="NUMBER", help="Largest relative difference that agrees, for --against.")
    ] = 1e-9,
    every: Annotated[bool, typer.Option("--all", help="Verify every textbook system.")] = False,
    robots: Annotated[bool, typer.Option("--robots", help="Verify every robot of example-robot-data.")] = False,
    as_json: AsJson = False,
) -> None:
    """Compare the derived equations with Pinocchio; the exit code is 1 if they disagree."""
    if against is not None and system is None:
        raise typer.BadParameter("expected a SYSTEM with --against")
    if (system is not None) + every + robots != 1:
        raise typer.BadParameter("expected one of: a SYSTEM, --all, --robots")
    outcome: mq.Verdict | Survey
    if system is None:
        number = samples if samples is not None else 50 if robots else 100
        outcome = surveyed(number, seed, robots=robots)
    else:
        chosen = choose(system, parameters, root)
        number = 100 if samples is None else samples
        other = None if against is None else source(against, root)
        with working(f"Comparing with {'Pinocchio' if against is None else against} at {number} states"):
            outcome = mq.verify(chosen.mechanism, number, seed, against=other, tolerance=tolerance)
    say(outcome.to_json() if as_json else str(outcome))
    if not outcome.agrees:
        raise typer.Exit(1)


@app.command(epilog="Example: mecanique lint panda --json")
@guarded
def lint(
    file: Annotated[str, typer.Argument(metavar="FILE", help="A URDF file, or the name of a robot.")],
    as_json: AsJson = False,
    as_sarif: Annotated[bool, typer.Option("--sarif", help="Print SARIF, for editors and code hosts.")] = False,
    fix: Annotated[bool, typer.Option("--fix", help="Mend what has exactly one safe mend, in a copy.")] = False,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="Where the mended copy goes; it is printed without.")
    ] = None,
) -> None:
    """Say what is wrong in a URDF file; the exit code is 0 without errors, 1 with errors, 2 if it cannot be read."""
    form = "json" if as_json else "sarif" if as_sarif else "text"
    raise typer.Exit(linted(file, form, fix=fix, output=output))


@app.command(epilog="Example: mecanique urdf two_blocks -o two_blocks.urdf")
@guarded
def urdf(
    system: SystemName,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="The file to write, instead of printing.")
    ] = None,
    parameters: Parameters = None,
) -> None:
    """Write a system as URDF."""
    mechanism = choose(system, parameters).mechanism
    if output is None:
        typer.echo(mq.write_urdf(mechanism), nl=False)
    else:
        mq.write_urdf(mechanism, output)
        say(f"Wrote {output}")


@app.command(epilog="Example: mecanique simulate cart_pole -q q=0.5 -v q=1 --duration 5 --csv cart.csv")
@guarded
def simulate(
    system: SystemName,
    parameters: Parameters = None,
    q: Coordinates = None,
    v: Velocities = None,
    duration: Duration = None,
    rtol: Tolerance = 1e-10,
    csv: Annotated[Path | None, typer.Option(metavar="FILE", help="Write t, q, v, a as CSV.")] = None,
    npz: Annotated[Path | None, typer.Option(metavar="FILE", help="Save the motion, to be loaded by Python.")] = None,
    as_json: AsJson = False,
) -> None:
    """Integrate a motion, and print its end and how well energy is balanced."""
    motion = simulated(choose(system, parameters), q, v, duration, rtol)
    if csv is not None:
        motion.to_csv(csv)
    if npz is not None:
        motion.save(npz)
    say(json.dumps(_figures(motion), ensure_ascii=False, indent=2, allow_nan=False) if as_json else motion.summary())


@app.command(epilog="Example: mecanique linearize two_blocks --compare --page mode.html --mode 2")
@guarded
def linearize(
    system: SystemName,
    parameters: Parameters = None,
    at: Annotated[
        list[str] | None,
        typer.Option("--at", metavar="NAME=VALUE", help="Near which equilibrium, in rad or m: --at theta=3"),
    ] = None,
    mode: Annotated[
        int | None,
        typer.Option(
            metavar="NUMBER", help="Mode for --compare and --page, 1 the slowest; by default that oscillates."
        ),
    ] = None,
    amplitude: Annotated[
        float | None, typer.Option(metavar="NUMBER", help="Its largest component for --compare and --page [rad or m].")
    ] = None,
    compare: Annotated[bool, typer.Option("--compare", help="Compare the mode with the exact motion.")] = False,
    page: Annotated[Path | None, typer.Option(metavar="FILE", help="Write the mode as an offline page.")] = None,
    force: Annotated[
        list[str] | None,
        typer.Option(metavar="NAME=VALUE", help="Print the response to this harmonic force, by frequency, as CSV."),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Linearize about an equilibrium: M, C, K, natural frequencies, damping ratios, modes."""
    mechanism = choose(system, parameters).mechanism
    linearization = mq.linearize(mechanism, near=numbers(at, "--at") or None)
    if force:
        say(response_table(linearization.response(numbers(force, "--force"))))
        return
    with working("Writing the linear equations"):
        say(figures(linearization) if as_json else small_motions(linearization))
    which = None if mode is None else mode - 1
    if compare:
        say("\n" + str(linearization.compare(amplitude, mode=which)))
    if page is not None:
        with working(f"Writing {page}"):
            mq.export(linearization.motion(which, amplitude), page)
        say(f"\nWrote {page}")


@app.command(epilog="Example: mecanique inertial rigid_bar_pendulum --latitude 48")
@guarded
def inertial(
    system: SystemName,
    latitude: Annotated[float, typer.Option(metavar="DEGREES", help="Latitude of the place, positive in the north.")],
    facing: Annotated[
        Literal["south", "east", "north", "west"], typer.Option(help="Where the x axis points; z points up.")
    ] = "south",
    parameters: Parameters = None,
    q: Coordinates = None,
    v: Velocities = None,
    duration: Duration = None,
    as_json: AsJson = False,
) -> None:
    """Judge whether the ground may be taken as inertial: repeat the motion on the turning earth."""
    motion = simulated(choose(system, parameters), q, v, duration, 1e-10)
    with working("Repeating the motion on the turning earth"):
        check = mq.inertial_check(motion.mechanism, motion, math.radians(latitude), facing=facing)
    say(inertial_figures(check) if as_json else str(check))


@app.command(epilog="Example: mecanique export double_pendulum -o chaos.html --duration 20")
@guarded
def export(
    system: SystemName,
    output: Page = None,
    parameters: Parameters = None,
    q: Coordinates = None,
    v: Velocities = None,
    duration: Duration = None,
    rtol: Tolerance = 1e-10,
    floating: IsFloating = False,
) -> None:
    """Write the motion as one offline page, with its equations and verdict."""
    chosen = choose(system, parameters, "floating" if floating else "fixed")
    motion = simulated(chosen, q, v, duration, rtol)
    path = output or Path(f"{chosen.mechanism.name}.html")
    with working(f"Writing {path}"):
        mq.export(motion, path)
    say(f"Wrote {path}")


@app.command(epilog="Example: mecanique view double_pendulum")
@guarded
def view(
    system: SystemName,
    parameters: Parameters = None,
    q: Coordinates = None,
    v: Velocities = None,
    duration: Duration = None,
    rtol: Tolerance = 1e-10,
    floating: IsFloating = False,
) -> None:
    """Show the motion live in a browser on this machine, until Ctrl-C."""
    motion = simulated(choose(system, parameters, "floating" if floating else "fixed"), q, v, duration, rtol)
    mq.view(motion)


@app.command(epilog="Example: mecanique picture cart_pole -o cart_pole.svg --free-body cart")
@guarded
def picture(
    system: SystemName,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="The file: .svg, .png or .pdf; ./SYSTEM.svg by default.")
    ] = None,
    time: Annotated[
        float | None, typer.Option("--time", metavar="SECONDS", help="Draw this instant of the motion.")
    ] = None,
    free_body: Annotated[
        str | None, typer.Option("--free-body", metavar="BODY", help="Cut this body free, with all forces on it.")
    ] = None,
    parameters: Parameters = None,
    q: Coordinates = None,
    v: Velocities = None,
    rtol: Tolerance = 1e-10,
) -> None:
    """Draw a system as a textbook line figure, or one of its bodies cut free."""
    chosen = choose(system, parameters)
    path = output or Path(f"{chosen.mechanism.name}.svg")
    if time is None and free_body is None and not q and not v:
        from mecanique.view.drawing.posture import posture

        mq.picture(chosen.mechanism, path=path, q=posture(chosen.mechanism, chosen.start).tolist())
    else:
        motion = simulated(chosen, q, v, max(time or 0.0, 0.1), rtol)
        mq.picture(motion, time, path, free_body=free_body)
    say(f"Wrote {path}")


def _freedom(name: str) -> int:
    """Degrees of freedom of a textbook system; only loops need the engine to count them."""
    mechanism = mq.textbook.load(name)
    if not mechanism.loops:
        return mechanism.nv
    from mecanique.reference import degrees_of_freedom

    return int(degrees_of_freedom(mechanism, mq.textbook.entry(name).start).N)


def _figures(motion: mq.Motion) -> dict[str, object]:
    mechanism, audit = motion.mechanism, motion.audit()
    names = (*mechanism.coordinates.names, *mechanism.velocities)
    return {
        "mechanism": mechanism.name,
        "duration": float(motion.t[-1] - motion.t[0]),
        "samples": len(motion.t),
        "method": motion.method,
        "steps": motion.statistics.steps,
        "end": {name: float(motion[name][-1]) for name in names},
        "audit": {row.name: {"relative": row.relative, "limit": row.limit, "ok": row.ok} for row in audit.rows},
    }
