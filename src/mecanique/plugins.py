"""What other packages add by entry points: systems, targets of code, engines, lint rules."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from functools import cache
from typing import TYPE_CHECKING, Literal, TypeAlias, TypeVar

from mecanique.errors import InputError

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint


Group: TypeAlias = Literal["systems", "targets", "engines", "lint_rules"]
"""Groups of entry points, each called "mecanique." and its name."""

T = TypeVar("T")


@cache
def list_plugins(group: Group) -> Mapping[str, EntryPoint]:
    """Return the entry points that installed packages add to a group, by name."""
    from importlib.metadata import entry_points  # takes 30 ms, and few commands ask for it

    return {point.name: point for point in entry_points(group=f"mecanique.{group}")}


def load_plugin(group: Group, name: str, kind: type[T]) -> T:
    """Return what an entry point stands for."""
    point = list_plugins(group)[name]
    package = point.dist.name if point.dist else point.value
    said = f"{name!r} of mecanique.{group}, which the package {package!r} adds,"
    try:
        thing = point.load()
    except Exception as error:
        # whatever a package of somebody else raises while it is imported
        raise InputError(
            f"{said} cannot be loaded: {type(error).__name__}: {error}; mend or uninstall it"
        ) from error
    if not isinstance(thing, kind):
        raise InputError(f"{said} is a {type(thing).__name__}, expected a {kind.__name__}")
    return thing


def new_interpreter(statement: str) -> list[str]:
    """Return the command that runs a statement in another interpreter with the packages of this.

    By itself that would import what lies in the folder where it starts, which may be a stranger's.
    """
    return [sys.executable, "-c", f"import sys; sys.path[:] = sys.argv[1:]; {statement}", *sys.path]
