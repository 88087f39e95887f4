"""The command that writes equations of motion as code."""

from __future__ import annotations

import json
from pathlib import Path

import click

import mecanique as mq
from mecanique.cli import options
from mecanique.cli.printing import say, working
from mecanique.cli.reading import Reading, reads_files
from mecanique.cli.words import choose, report_errors, start_of


@click.command(epilog="Example: mecanique code cart_pole --target c --what rhs,energy -o cart")
@options.system
@click.option(
    "--target",
    default="c",
    metavar="LANGUAGE",
    help="c, javascript, python, jax, casadi or fmu (FMI 3.0).",
)
@click.option(
    "--what",
    default="acceleration,energy",
    metavar="NAMES",
    help="Quantities with commas between: rhs, acceleration, mass_matrix, bias, gravity, "
    "forces, inverse_dynamics, energy, poses, jacobians, reactions; of loops also "
    "multipliers, closure; derivatives as rhs_by_y, rhs_by_tau, energy_by_p.",
)
@click.option(
    "--output",
    "-o",
    type=options.PATH,
    default=Path(),
    metavar="DIR",
    help="Directory to write in.",
)
@options.parameters
@click.option("--numbers", is_flag=True, help="Write parameters as numbers instead of arguments.")
@click.option("--name", metavar="NAME", help="What functions and files are called after.")
@click.option("--samples", default=100, metavar="NUMBER", help="Number of states to compare at.")
@options.seed
@options.coordinates
@options.velocities
@options.as_json
@report_errors
@reads_files
def code(
    system: str,
    target: str,
    what: str,
    output: Path,
    parameters: tuple[str, ...],
    numbers: bool,
    name: str | None,
    samples: int,
    seed: int,
    q: tuple[str, ...],
    v: tuple[str, ...],
    as_json: bool,
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
