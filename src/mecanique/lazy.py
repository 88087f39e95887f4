"""Names of a package that are imported when they are first used."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from importlib import import_module
from typing import Any

__all__ = ["import_name"]


def import_name(package: str, name: str, homes: Mapping[str, str]) -> Any:
    """Return what a package's `__getattr__` is asked for, and keep it there.

    Args:
        package: full name of the package.
        name: what is asked for.
        homes: module of each name, below the package where it begins with a dot.

    Raises:
        AttributeError: if the package has no such name.
    """
    if name not in homes:
        raise AttributeError(f"module {package!r} has no attribute {name!r}")
    value = getattr(import_module(homes[name], package), name)
    setattr(sys.modules[package], name, value)
    return value
