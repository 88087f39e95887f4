"""Find the systems of the catalogue.

Every module of `mecanique.textbook.systems` is one, and every module of
`mecanique.textbook.corners` one with friction, stops or contacts that open; other packages add
theirs by entry points of the group `mecanique.systems`, each a `System`.
"""

from __future__ import annotations

import inspect
from dataclasses import replace
from functools import cache
from importlib import import_module
from pkgutil import iter_modules

from mecanique.errors import UnknownNameError
from mecanique.lazy import keep_garbage
from mecanique.model.mechanism import Mechanism
from mecanique.plugins import list_plugins, load_plugin
from mecanique.textbook.system import System


@cache
def names(*, corners: bool = False) -> tuple[str, ...]:
    """Return the names of all smooth systems, in alphabetical order.

    Args:
        corners: whether to return those with friction, stops and contacts that open instead.
    """
    if corners:
        return tuple(sorted(_own("corners")))
    return tuple(sorted({*_own("systems"), *list_plugins("systems")}))


def is_known(name: str) -> bool:
    """Return whether there is a system of a name; what other packages add takes long to list."""
    return name in _own("systems") | _own("corners") or name in names()


@cache
def entry(name: str) -> System:
    """Return the catalogue's entry of a system.

    Raises:
        UnknownNameError: if there is no such system; it carries the near matches.
        InputError: if another package adds it, and it cannot be loaded.
    """
    with keep_garbage():  # it may be the first to import SymPy
        if name in _own("systems"):
            module = import_module(f"mecanique.textbook.systems.{name}")
        elif name in _own("corners"):
            module = import_module(f"mecanique.textbook.corners.{name}")
        elif is_known(name):
            return load_plugin("systems", name, System)
        else:
            raise UnknownNameError("system", name, (*names(), *names(corners=True)))
    system: System = module.SYSTEM
    return replace(system, statement=inspect.getdoc(module) or "")


def load(name: str, **parameters: float) -> Mechanism:
    """Build a system of the catalogue.

    Args:
        name: its name, one of `names()` or of `names(corners=True)`.
        parameters: value of each parameter to change, by symbol, in its SI unit.

    Raises:
        UnknownNameError: if the system or a parameter does not exist.
        InputError: if a value is not finite.
        MechanismError: if the mechanism is not sound with these values.
    """
    return entry(name).mechanism(**parameters)


@cache
def _own(folder: str) -> frozenset[str]:
    """Return the names of the modules of a folder of this package."""
    from mecanique.textbook import corners, systems

    path = {"systems": systems, "corners": corners}[folder].__path__
    return frozenset(module.name for module in iter_modules(path))
