"""The arguments and options that several commands have, and how a robot's file is read.

They are decorators of a command: `@options.system`, `@options.seed`, `@options.reads_files`.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any, Literal, TypeAlias, TypeVar, final

import click

import mecanique as mq

R = TypeVar("R")

PATH = click.Path(path_type=Path)


Decorator: TypeAlias = Callable[[Callable[..., Any]], Callable[..., Any]]
"""What gives a command an option."""


def several(*names: str, said: str, metavar: str = "NAME=VALUE") -> Decorator:
    """Return an option that is repeatable, of numbers by name by default."""
    return click.option(*names, multiple=True, metavar=metavar, help=said)


def real(name: str, said: str, metavar: str = "NUMBER", **more: Any) -> Decorator:
    """Return an option of a number."""
    return click.option(name, type=float, metavar=metavar, help=said, **more)


def file(name: str, said: str, metavar: str = "FILE") -> Decorator:
    """Return an option of a file."""
    return click.option(name, type=PATH, metavar=metavar, help=said)


def output(said: str, **more: Any) -> Decorator:
    """Return the option of where to write."""
    return click.option("--output", "-o", type=PATH, help=said, **more)


_system = click.argument(
    "system",
    metavar="SYSTEM",
    help="A textbook system (see 'mecanique list'), a URDF, xacro, MJCF or SDF file, "
    "or the name of a robot, e.g. panda.",
)

parameters = several("--parameter", "-p", "parameters", said="Set a parameter, in SI units: -p l=2")


def system(command: Callable[..., R]) -> Callable[..., R]:
    """Give a command the system it works on, and the option that sets its parameters."""
    return _system(parameters(command))


velocities = several("-v", said="Set an initial velocity, in rad/s or m/s: -v theta=0.5")


def start(command: Callable[..., R]) -> Callable[..., R]:
    """Give a command the options of a motion's start."""
    coordinates = several("-q", said="Set an initial coordinate, in rad or m: -q theta=1.5")
    return coordinates(velocities(command))


duration = real(
    "--duration", "How long to simulate; each system has its default.", metavar="SECONDS"
)

tolerance = click.option(
    "--rtol", default=1e-10, metavar="NUMBER", help="Relative tolerance of the integration."
)

samples = click.option(
    "--samples",
    type=int,
    metavar="NUMBER",
    help="Number of random states to compare; 100 by default, fewer above 60 velocities.",
)

seed = click.option("--seed", default=0, metavar="NUMBER", help="Seed of the random states.")

page = output("The page to write; ./SYSTEM.html by default.")

as_json = click.option("--json", "as_json", is_flag=True, help="Print JSON for scripts.")

Root: TypeAlias = Literal["fixed", "floating"]


@final
@dataclass(frozen=True)
class FileOptions:
    """How a file is read."""

    root: Root = "fixed"
    strict: bool = False
    package_path: tuple[Path, ...] = ()
    arguments: Mapping[str, str] = field(default_factory=dict)
    loops: Path | None = None
    keep: tuple[str, ...] = ()

    def read(self, path: Path) -> mq.Mechanism:
        """Return the mechanism of a file."""
        # other formats than URDF refuse what is asked of it
        given = {name: value for name, value in vars(self).items() if value and name != "keep"}
        if self.root == "fixed":
            del given["root"]
        return mq.read(path, parameters=self.keep, **given)


def reads_files(command: Callable[..., R]) -> Callable[..., R]:
    """Give a command the options of reading; it takes them together as `reading`."""

    @click.option(
        "--root",
        type=click.Choice(["fixed", "floating"]),
        default="fixed",
        help="Whether the root link of a URDF is fixed or floating.",
    )
    @click.option("--floating", is_flag=True, help="The same as --root floating.")
    @click.option(
        "--strict",
        is_flag=True,
        help="Refuse a file with any error, even one that does not affect the equations.",
    )
    @click.option(
        "--package-path",
        multiple=True,
        type=PATH,
        metavar="DIR",
        help="Search this directory for packages, before ROS_PACKAGE_PATH; repeatable.",
    )
    @several(
        "--arg",
        "arguments",
        said="Set an argument of a xacro file; repeatable.",
        metavar="NAME=VALUE",
    )
    @file("--loops", "A TOML file with loops, springs and dampers to add to a URDF.", "FILE.toml")
    @several(
        "--keep",
        said="Quantities to keep symbolic, comma-separated: masses, lengths, inertias, letters, "
        "or properties of a xacro file.",
        metavar="NAMES",
    )
    @functools.wraps(command)
    def reads(*args: Any, floating: bool, **kwargs: Any) -> R:
        given = {item.name: kwargs.pop(item.name) for item in fields(FileOptions)}
        given["arguments"] = dict(map(_split, given["arguments"]))
        given["keep"] = tuple(word for text in given["keep"] for word in text.split(",") if word)
        given["root"] = "floating" if floating else given["root"]
        return command(*args, reading=FileOptions(**given), **kwargs)

    return reads


def _split(word: str) -> tuple[str, str]:
    """Return name and value of "name=value", or of "name:=value" as xacro itself writes it."""
    name, sign, value = word.partition("=")
    name = name.removesuffix(":")
    if not (name and sign):
        raise mq.InputError(f"expected NAME=VALUE after --arg, got {word!r}")
    return name, value
