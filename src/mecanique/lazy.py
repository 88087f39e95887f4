"""Imports that wait until they are needed, and then take no longer than they must."""

from __future__ import annotations

import gc
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from importlib import import_module
from typing import Any


def find_homes(names: Mapping[str, str]) -> dict[str, str]:
    """Return the module of each name.

    Args:
        names: the names in each module, separated by blanks.
    """
    return {name: home for home, words in names.items() for name in words.split()}


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


@contextmanager
def keep_garbage() -> Iterator[None]:
    """Put off the collection of garbage while large packages are imported.

    What an import makes stays, and to look through it again and again takes a fifth of its time.
    """
    if not gc.isenabled():
        yield
        return
    gc.disable()
    try:
        yield
    finally:
        gc.enable()
