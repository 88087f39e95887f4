"""How a command reads a robot's file: the options that every such command has, in one place."""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal, TypeAlias, TypeVar, final

import click

import mecanique as mq
from mecanique.cli import options

R = TypeVar("R")

Root: TypeAlias = Literal["fixed", "floating"]


@final
@dataclass(frozen=True)
class Reading:
    """How a file is read.

    Args:
        root: how its root link is held.
        strict: whether every error refuses it.
        package_path: folders to search for packages.
        arguments: of a xacro file, by name.
        loops: a TOML file with loops and springs beside it.
        keep: what stays a letter.
    """

    root: Root = "fixed"
    strict: bool = False
    package_path: tuple[Path, ...] = ()
    arguments: Mapping[str, str] = field(default_factory=dict)
    loops: Path | None = None
    keep: tuple[str, ...] = ()

    def read(self, path: Path) -> mq.Mechanism:
        """Return the mechanism of a file."""
        return mq.read_urdf(
            path,
            root=self.root,
            strict=self.strict,
            package_path=self.package_path or None,
            arguments=self.arguments,
            loops=self.loops,
            parameters=self.keep,
        )


def reads_files(command: Callable[..., R]) -> Callable[..., R]:
    """Give a command the options of reading; it takes them together as `reading`."""

    @click.option(
        "--root",
        type=click.Choice(["fixed", "floating"]),
        default="fixed",
        help="Whether the root link of a URDF is fixed or free.",
    )
    @click.option("--floating", is_flag=True, help="The same as --root floating.")
    @click.option(
        "--strict",
        is_flag=True,
        help="Refuse a file with any error, also one that its equations do without.",
    )
    @click.option(
        "--package-path",
        multiple=True,
        type=options.PATH,
        metavar="DIR",
        help="Search this directory for packages, before ROS_PACKAGE_PATH; repeatable.",
    )
    @click.option(
        "--arg",
        multiple=True,
        metavar="NAME=VALUE",
        help="Set an argument of a xacro file; repeatable.",
    )
    @click.option(
        "--loops",
        type=options.PATH,
        metavar="FILE.toml",
        help="Loops, springs and dampers beside a URDF, as TOML.",
    )
    @click.option(
        "--keep",
        multiple=True,
        metavar="NAMES",
        help="Letters to keep of a file, with commas: masses, lengths, inertias, letters, "
        "properties of a xacro file.",
    )
    @functools.wraps(command)
    def reads(
        *args: Any,
        root: Root,
        floating: bool,
        strict: bool,
        package_path: tuple[Path, ...],
        arg: tuple[str, ...],
        loops: Path | None,
        keep: tuple[str, ...],
        **kwargs: Any,
    ) -> R:
        reading = Reading(
            "floating" if floating else root,
            strict,
            package_path,
            dict(map(_split, arg)),
            loops,
            tuple(word for words in keep for word in words.split(",") if word),
        )
        return command(*args, reading=reading, **kwargs)

    return reads


def _split(word: str) -> tuple[str, str]:
    """Return name and value of "name=value", or of "name:=value" as xacro itself writes it."""
    name, sign, value = word.partition("=")
    name = name.removesuffix(":")
    if not (name and sign):
        raise mq.InputError(f"expected NAME=VALUE after --arg, got {word!r}")
    return name, value
