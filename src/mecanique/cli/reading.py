"""How a command reads a robot's file: the options that every such command has, in one place."""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any, Literal, TypeAlias, TypeVar, final

import typer

import mecanique as mq

__all__ = ["Reading", "reads_files"]

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
        """Return the mechanism of a file.

        Args:
            path: of the file.
        """
        return mq.read_urdf(
            path,
            root=self.root,
            strict=self.strict,
            package_path=self.package_path or None,
            arguments=self.arguments,
            loops=self.loops,
            parameters=self.keep,
        )


_OPTIONS = {
    "root": (
        Annotated[
            Root, typer.Option("--root", help="Whether the root link of a URDF is fixed or free.")
        ],
        "fixed",
    ),
    "floating": (
        Annotated[bool, typer.Option("--floating", help="The same as --root floating.")],
        False,
    ),
    "strict": (
        Annotated[
            bool,
            typer.Option(
                "--strict",
                help="Refuse a file with any error, also one that its equations do without.",
            ),
        ],
        False,
    ),
    "package_path": (
        Annotated[
            list[Path] | None,
            typer.Option(
                metavar="DIR",
                help="Search this directory for packages, before ROS_PACKAGE_PATH; repeatable.",
            ),
        ],
        None,
    ),
    "arg": (
        Annotated[
            list[str] | None,
            typer.Option(metavar="NAME=VALUE", help="Set an argument of a xacro file; repeatable."),
        ],
        None,
    ),
    "loops": (
        Annotated[
            Path | None,
            typer.Option(
                metavar="FILE.toml", help="Loops, springs and dampers beside a URDF, as TOML."
            ),
        ],
        None,
    ),
    "keep": (
        Annotated[
            list[str] | None,
            typer.Option(
                metavar="NAMES",
                help="Letters to keep of a file, with commas: masses, lengths, inertias, letters, "
                "properties of a xacro file.",
            ),
        ],
        None,
    ),
}
"""Annotation and default of each option, by the name of its parameter."""


def reads_files(command: Callable[..., R]) -> Callable[..., R]:
    """Give a command the options of reading; it takes them together as `reading`.

    Args:
        command: has a parameter `reading`.
    """

    @functools.wraps(command)
    def reads(*args: Any, **kwargs: Any) -> R:
        given = {name: kwargs.pop(name, default) for name, (_, default) in _OPTIONS.items()}
        root: Root = "floating" if given["floating"] else given["root"]
        arguments = dict(map(_split, given["arg"] or ()))
        reading = Reading(
            root,
            given["strict"],
            tuple(given["package_path"] or ()),
            arguments,
            given["loops"],
            tuple(word for words in given["keep"] or () for word in words.split(",") if word),
        )
        return command(*args, reading=reading, **kwargs)

    own = inspect.signature(command, eval_str=True)
    kept = [parameter for name, parameter in own.parameters.items() if name != "reading"]
    added = [
        inspect.Parameter(
            name, inspect.Parameter.KEYWORD_ONLY, default=default, annotation=annotation
        )
        for name, (annotation, default) in _OPTIONS.items()
    ]
    kept = [parameter.replace(kind=inspect.Parameter.KEYWORD_ONLY) for parameter in kept]
    reads.__signature__ = own.replace(parameters=[*kept, *added])  # type: ignore[attr-defined]
    return reads


def _split(word: str) -> tuple[str, str]:
    """Return name and value of "name=value", or of "name:=value" as xacro itself writes it."""
    name, sign, value = word.partition("=")
    name = name.removesuffix(":")
    if not (name and sign):
        raise mq.InputError(f"expected NAME=VALUE after --arg, got {word!r}")
    return name, value
