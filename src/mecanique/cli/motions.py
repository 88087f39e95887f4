"""Commands on motions: simulate, linearize, steady motions, check the ground."""

from __future__ import annotations

import math
from dataclasses import asdict
from pathlib import Path
from typing import Literal

import click

import mecanique as mq
from mecanique.cli import options
from mecanique.cli.printing import say, to_json, working
from mecanique.cli.words import Chosen, numbers, simulate_motion, takes_system

_MOST_SPEEDS = 1000


@click.command(
    epilog="Example: mecanique simulate cart_pole -q q=0.5 -v q=1 --duration 5 --csv cart.csv"
)
@options.system
@options.start
@options.duration
@options.tolerance
@click.option(
    "--limits",
    metavar="stop|NUMBER",
    help="Stop where a joint reaches its limit, or bounce with this coefficient of restitution.",
)
@options.file("--csv", "Write t, q, v, a as CSV.")
@options.file("--npz", "Save the motion for Motion.load in Python.")
@options.as_json
@takes_system
def simulate(
    chosen: Chosen,
    duration: float | None,
    rtol: float,
    limits: str | None,
    csv: Path | None,
    npz: Path | None,
    as_json: bool,
) -> None:
    """Simulate a motion; print its final state and energy balance.

    Exit code 2 if nothing can move: there are no coordinates, or the mechanism is locked.
    """
    motion = simulate_motion(chosen, duration, rtol, limits)
    if csv is not None:
        motion.to_csv(csv)
    if npz is not None:
        motion.save(npz)
    say(to_json(_figures(motion)) if as_json else motion.summary())


@click.command(epilog="Example: mecanique linearize two_blocks --compare --page mode.html --mode 2")
@options.system
@options.several("--at", said="Search near this position, in rad or m: --at theta=3")
@click.option(
    "--mode",
    type=int,
    metavar="NUMBER",
    help="Mode for --compare and --page, 1 being the slowest; by default the first to oscillate.",
)
@options.real("--amplitude", "Largest component of the mode for --compare and --page [rad or m].")
@click.option("--compare", is_flag=True, help="Compare the mode with the exact motion.")
@options.file("--page", "Write the mode as an offline page.")
@options.several("--force", said="Print the frequency response to this harmonic force as CSV.")
@options.as_json
@takes_system
def linearize(
    chosen: Chosen,
    at: tuple[str, ...],
    mode: int | None,
    amplitude: float | None,
    compare: bool,
    page: Path | None,
    force: tuple[str, ...],
    as_json: bool,
) -> None:
    """Linearize about an equilibrium: M, C, K, frequencies, modes.

    Without --at, the search starts from the neutral position, then from random ones; the output
    names what it found. Exit code 2 if there is none, 0 with a sentence if nothing can move.
    """
    from mecanique.cli.linear import figures, response_table, small_motions

    linearization = mq.linearize(chosen.mechanism, near=numbers(at, "--at") or None)
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


@click.command(
    epilog="Example: mecanique steady whipple_bicycle --at z=0.3 -v x=1 --speeds 0:10:11"
)
@options.system
@options.several("--at", said="Position, in rad or m: --at z=0.3")
@options.velocities
@click.option(
    "--speeds",
    metavar="FROM:TO:COUNT",
    help="Tabulate over COUNT multiples of the velocities.",
)
@options.several("--by", said="Take this coordinate as independent; repeatable.", metavar="NAME")
@options.several(
    "--expand",
    said="Print M, C, K of this coordinate as functions of the speed; repeatable.",
    metavar="NAME",
)
@click.option("--letters", is_flag=True, help="Print those of --expand in letters.")
@options.file("--plot", "Plot the table as SVG, PDF or PNG.")
@options.as_json
@takes_system
def steady(
    chosen: Chosen,
    at: tuple[str, ...],
    speeds: str | None,
    by: tuple[str, ...],
    expand: tuple[str, ...],
    letters: bool,
    plot: Path | None,
    as_json: bool,
) -> None:
    """Linearize about a steady motion: exponents, stability.

    Exit code 2 if the motion is not steady.
    """
    from mecanique.cli.linear import exponents, matrix_figures, speed_figures

    mechanism = chosen.mechanism
    place, moving = numbers(at, "--at"), numbers(chosen.v, "-v")
    if expand:
        matrices = mq.expand_in_speed(mechanism, place, moving, expand, by=by)
        said = str(matrices.letters if letters else matrices)
        say(matrix_figures(matrices) if as_json else said)
        if speeds is None:
            return
    if speeds is None:
        if plot is not None:
            raise click.BadParameter("expected --speeds with --plot")
        say(exponents(mq.linearize_steady(mechanism, place, moving, by=by), as_json=as_json))
        return
    with working("Linearizing about each speed"):
        table = mq.sweep_speeds(mechanism, place, moving, _range(speeds), by=by)
    say(speed_figures(table) if as_json else str(table))
    if plot is not None:
        table.plot().savefig(plot)
        say(f"\nWrote {plot}")


def _range(text: str) -> list[float]:
    """The numbers of FROM:TO:COUNT."""
    try:
        first, last, count = text.split(":")
        start, stop, steps = float(first), float(last), int(count)
    except ValueError:
        raise click.BadParameter(f"expected --speeds FROM:TO:COUNT, got {text!r}") from None
    if not 2 <= steps <= _MOST_SPEEDS or not start < stop:
        raise click.BadParameter(
            f"expected --speeds with FROM below TO and 2 to {_MOST_SPEEDS} of them, got {text!r}"
        )
    return [start + (stop - start) * k / (steps - 1) for k in range(steps)]


@click.command(epilog="Example: mecanique inertial rigid_bar_pendulum --latitude 48")
@options.system
@options.real("--latitude", "Latitude, positive in the north.", metavar="DEGREES", required=True)
@click.option(
    "--facing",
    type=click.Choice(["south", "east", "north", "west"]),
    default="south",
    help="Direction of the x axis; z points up.",
)
@options.start
@options.duration
@options.as_json
@takes_system
def inertial(
    chosen: Chosen,
    latitude: float,
    facing: Literal["south", "east", "north", "west"],
    duration: float | None,
    as_json: bool,
) -> None:
    """Check whether the ground may be taken as inertial.

    The motion is repeated on the rotating earth and compared.
    """
    from mecanique.cli.linear import inertial_figures

    motion = simulate_motion(chosen, duration, 1e-10)
    with working("Repeating the motion on the rotating earth"):
        check = mq.inertial_check(chosen.mechanism, motion, math.radians(latitude), facing=facing)
    say(inertial_figures(check) if as_json else str(check))


def _figures(motion: mq.Motion) -> dict[str, object]:
    from mecanique.motion.analysis.extremes import find_exceeded

    mechanism, audit = motion.mechanism, motion.audit()
    names = (*mechanism.coordinates.names, *mechanism.velocities)
    return {
        "mechanism": mechanism.name,
        "duration": float(motion.t[-1] - motion.t[0]),
        "samples": len(motion.t),
        "method": motion.method,
        "steps": motion.statistics.steps,
        "end": {name: float(motion[name][-1]) for name in names},
        "limits passed": [asdict(exceeded) for exceeded in find_exceeded(motion)],
        "audit": {
            row.name: {"relative": row.relative, "limit": row.limit, "ok": row.ok}
            for row in audit.rows
        },
    }
