"""Find the systems of the catalogue.

Every module of `mecanique.textbook.systems` is one; other packages add theirs by entry points of
the group `mecanique.systems`, each a `System`.
"""

from __future__ import annotations

from functools import cache
from importlib import import_module
from pkgutil import iter_modules

from mecanique.errors import UnknownNameError
from mecanique.model.mechanism import Mechanism
from mecanique.plugins import list_plugins, load_plugin
from mecanique.textbook.system import System


@cache
def names() -> tuple[str, ...]:
    """Return the names of all systems, in alphabetical order."""
    return tuple(sorted({*_own(), *list_plugins("systems")}))


def is_known(name: str) -> bool:
    """Return whether there is a system of a name; what other packages add takes long to list."""
    return name in _own() or name in names()


@cache
def entry(name: str) -> System:
    """Return the catalogue's entry of a system.

    Raises:
        UnknownNameError: if there is no such system; it carries the near matches.
        InputError: if another package adds it, and it cannot be loaded.
    """
    if name not in _own():
        if not is_known(name):
            raise UnknownNameError("system", name, names())
        return load_plugin("systems", name, System)
    system: System = import_module(f"mecanique.textbook.systems.{name}").SYSTEM
    return system


def load(name: str, **parameters: float) -> Mechanism:
    """Build a system of the catalogue.

    Args:
        name: its name, one of `names()`.
        parameters: value of each parameter to change, by symbol, in its SI unit.

    Raises:
        UnknownNameError: if the system or a parameter does not exist.
        InputError: if a value is not finite.
        MechanismError: if the mechanism is not sound with these values.
    """
    return entry(name).mechanism(**parameters)


@cache
def _own() -> frozenset[str]:
    from mecanique.textbook import systems

    return frozenset(module.name for module in iter_modules(systems.__path__))
