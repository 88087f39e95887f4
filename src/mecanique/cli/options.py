"""The arguments and options that several commands have, each in one place.

They are decorators of a command: `@options.system`, `@options.seed`.
"""

from __future__ import annotations

from pathlib import Path

import click

PATH = click.Path(path_type=Path)

system = click.argument(
    "system",
    metavar="SYSTEM",
    help="A textbook system (see 'mecanique list'), the path of a URDF file, "
    "or the name of a robot, e.g. panda.",
)
parameters = click.option(
    "--parameter",
    "-p",
    "parameters",
    multiple=True,
    metavar="NAME=VALUE",
    help="Set a parameter, in its SI unit: -p l=2",
)
coordinates = click.option(
    "-q",
    multiple=True,
    metavar="NAME=VALUE",
    help="Set an initial coordinate, in rad or m: -q theta=1.5",
)
velocities = click.option(
    "-v",
    multiple=True,
    metavar="NAME=VALUE",
    help="Set an initial velocity, in rad/s or m/s: -v theta=0.5",
)
duration = click.option(
    "--duration",
    type=float,
    metavar="SECONDS",
    help="How long to simulate; the catalogue has a default for each system.",
)
tolerance = click.option(
    "--rtol", default=1e-10, metavar="NUMBER", help="Relative tolerance of the integration."
)
samples = click.option(
    "--samples",
    type=int,
    metavar="NUMBER",
    help="Number of random states at which to compare; 100, fewer above 60 velocities.",
)
seed = click.option("--seed", default=0, metavar="NUMBER", help="Seed of the random states.")
page = click.option(
    "--output", "-o", type=PATH, help="The page to write; ./SYSTEM.html by default."
)
as_json = click.option("--json", "as_json", is_flag=True, help="Print JSON for scripts.")
