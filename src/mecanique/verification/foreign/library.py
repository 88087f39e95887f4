"""Functions of a shared library, by its header. Loading the library runs its code."""

from __future__ import annotations

import ctypes
import os
import re
from pathlib import Path

from mecanique.errors import InputError
from mecanique.model.mechanism import Mechanism
from mecanique.verification.foreign.compiled import TAKES, CFunction

LIBRARIES = (".so", ".dylib", ".dll")
"""Endings of shared libraries."""

_DECLARATION = re.compile(r"\bvoid\s+(\w+)\s*\(([^)]*)\)\s*;")
_SIZE = re.compile(r"\b\w*?n([qv])\s*=\s*(\d+)")
_COMMENT = re.compile(r"/\*.*?\*/|//[^\n]*", re.DOTALL)
_INPUTS = ("t", "q", "v", "a", "tau", "p")


def load_library(
    path: str | os.PathLike[str], header: str | os.PathLike[str] | None, mechanism: Mechanism
) -> dict[str, CFunction]:
    """Return the functions of a library that a header declares, by what they give.

    A function is known by the end of its name, `…_acceleration`, and its arguments by theirs: t, q,
    v, a, tau, p and out, as in the C that `generate` writes.

    Args:
        path: of the library.
        header: of the header that declares its functions.
        mechanism: whose sizes it must have.

    Raises:
        InputError: if a file cannot be read, the header declares no such function or other sizes,
            or the library has not what the header declares.
    """
    if header is None:
        raise InputError(
            f"expected the header of {os.fspath(path)}, which says what its functions take: "
            "--header FILE.h, or header=… in Python"
        )
    try:
        text = _COMMENT.sub(" ", Path(header).read_text(encoding="utf-8", errors="replace"))
    except OSError as error:
        raise InputError(f"expected a C header, but {header} cannot be read: {error}") from None
    for kind, size in _SIZE.findall(text):
        own = mechanism.nq if kind == "q" else mechanism.nv
        if int(size) != own:
            names = mechanism.coordinates if kind == "q" else mechanism.velocities
            raise InputError(
                f"expected n{kind} = {own} ({', '.join(names)}) in {header}, it states {size}"
            )
    declared: dict[str, str] = dict(_DECLARATION.findall(text))
    wanted = {name: what for name in declared if (what := _quantity(name))}
    if not wanted:
        raise InputError(
            f"expected functions in {header} whose names end in "
            f"{', '.join(f'_{name}' for name in TAKES)}; it declares "
            f"{', '.join(declared) or 'none'}"
        )
    try:
        library = ctypes.CDLL(os.fspath(Path(path).resolve()))
    except OSError as error:
        raise InputError(f"expected a shared library, but {path} does not load: {error}") from None
    found = {}
    for name, what in wanted.items():
        takes = _takes(name, declared[name])
        function = getattr(library, name, None)
        if function is None:
            raise InputError(f"{header} declares {name}, which {path} does not have")
        address = ctypes.cast(function, ctypes.c_void_p).value or 0
        parameters = _address(library, f"{name[: -len(what) - 1]}_parameters")
        found[what] = CFunction(name, address, takes, parameters)
    return found


def _quantity(name: str) -> str:
    return next((what for what in TAKES if name == what or name.endswith(f"_{what}")), "")


def _takes(name: str, arguments: str) -> tuple[str, ...]:
    """The inputs of a declared function.

    Raises:
        InputError: if its arguments are not those of such a function.
    """
    words = [re.findall(r"\w+", part) for part in arguments.split(",")]
    names = [found[-1] if found else "" for found in words]
    *inputs, last = names
    pointers = ["*" in part or "[" in part for part in arguments.split(",")]
    unknown = [given for given in inputs if given not in _INPUTS]
    if unknown or last != "out":
        raise InputError(
            f"expected arguments of {name} among {', '.join(_INPUTS)}, then out; got "
            f"{', '.join(names)}"
        )
    for given, pointer in zip(names, pointers, strict=True):
        if pointer == (given == "t"):
            kind = "a number" if given == "t" else "a pointer"
            raise InputError(f"expected {given} of {name} to be {kind}")
    if "double" not in arguments or "float" in arguments:
        raise InputError(f"expected arguments of {name} in double precision")
    return tuple(inputs)


def _address(library: ctypes.CDLL, symbol: str) -> int | None:
    try:
        return ctypes.addressof(ctypes.c_double.in_dll(library, symbol))
    except ValueError:
        return None
