"""The command that writes equations of motion as code."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated

import typer

import mecanique as mq
from mecanique.cli.printing import say, working
from mecanique.cli.reading import Reading, reads_files
from mecanique.cli.words import (
    AsJson,
    Coordinates,
    Parameters,
    Seed,
    SystemName,
    Velocities,
    choose,
    report_errors,
    start_of,
)

__all__ = ["app"]

app = typer.Typer()


@app.command(epilog="Example: mecanique code cart_pole --target c --what rhs,energy -o cart")
@report_errors
@reads_files
def code(
    system: SystemName,
    target: Annotated[
        str,
        typer.Option(
            metavar="LANGUAGE", help="c, javascript, python, jax, casadi or fmu (FMI 3.0)."
        ),
    ] = "c",
    what: Annotated[
        str,
        typer.Option(
            metavar="NAMES",
            help="Quantities with commas between: rhs, acceleration, mass_matrix, bias, gravity, "
            "forces, inverse_dynamics, energy, poses, jacobians, reactions; of loops also "
            "multipliers, closure; derivatives as rhs_by_y, rhs_by_tau, energy_by_p.",
        ),
    ] = "acceleration,energy",
    output: Annotated[
        Path, typer.Option("--output", "-o", metavar="DIR", help="Directory to write in.")
    ] = Path(),
    parameters: Parameters = None,
    numbers: Annotated[
        bool,
        typer.Option("--numbers", help="Write parameters as numbers instead of arguments."),
    ] = False,
    name: Annotated[
        str | None,
        typer.Option(metavar="NAME", help="What functions and files are called after."),
    ] = None,
    samples: Annotated[
        int, typer.Option(metavar="NUMBER", help="Number of states to compare at.")
    ] = 100,
    seed: Seed = 0,
    q: Coordinates = None,
    v: Velocities = None,
    as_json: AsJson = False,
    *,
    reading: Reading,
) -> None:
    """Write the equations of motion as code, checked by running it.

    The test that compares it comes along. Only an FMU has a start, by -q and -v.
    """
    chosen = choose(system, parameters, reading)
    start, start_velocity = start_of(chosen, q, v)
    with working(f"Writing and running {target}"):
        made = mq.generate(
            mq.derive(chosen.mechanism),
            target,
            what,
            parameters=() if numbers else None,
            name=name,
            q=start,
            v=start_velocity,
            samples=samples,
            seed=seed,
        )
    paths = made.write(output)
    if as_json:
        say(
            json.dumps(
                {
                    "files": [str(path) for path in paths],
                    "operations": {
                        answer.quantity.name: made.count(answer.quantity.name).total
                        for answer in made.program.answers
                    },
                    "worst": None if made.verdict is None else made.verdict.worst,
                },
                indent=2,
            )
        )
        return
    for path in paths:
        say(f"Wrote {path}")
    say("Not run here, see the head of the file." if made.verdict is None else str(made.verdict))
