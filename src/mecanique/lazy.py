"""Imports that wait until they are needed, and then take no longer than they must."""

from __future__ import annotations

import ast
import gc
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from typing import Any


def find_homes(file: str) -> dict[str, str]:
    """Return the module of each name that the stub beside a package's `__init__.py` imports."""
    stub = ast.parse(Path(file).with_suffix(".pyi").read_text(encoding="utf-8"))
    imports = [node for node in stub.body if isinstance(node, ast.ImportFrom)]
    return {alias.name: str(node.module) for node in imports for alias in node.names}


def attach(
    package: str, file: str, prepare: Callable[[Any], Any] | None = None
) -> tuple[Callable[[str], Any], Callable[[], list[str]], list[str]]:
    """Return `__getattr__`, `__dir__` and `__all__` of a package, as the stub beside it says."""
    homes = find_homes(file)

    def get(name: str) -> Any:
        if homes.get(name) == package:  # a room of it
            room = f"{package}.{name}"
            return import_module(room)
        value = import_name(package, name, homes)
        if prepare is not None:
            value = prepare(value)
            setattr(sys.modules[package], name, value)
        return value

    names = sorted(name for name in homes if not name.startswith("_"))
    return get, lambda: sorted(homes), names


def import_name(package: str, name: str, homes: Mapping[str, str]) -> Any:
    """Return what a package's `__getattr__` is asked for, and keep it there."""
    if name not in homes:
        raise AttributeError(f"module {package!r} has no attribute {name!r}")
    value = getattr(import_module(homes[name], package), name)
    setattr(sys.modules[package], name, value)
    return value


@contextmanager
def keep_garbage() -> Iterator[None]:
    """Put off the collection of garbage while large packages are imported."""
    # what an import makes stays, and to look through it again and again takes a fifth of its time
    if not gc.isenabled():
        yield
        return
    gc.disable()
    try:
        yield
    finally:
        gc.enable()
