"""Functions in machine code, called as the C that `generate` writes: inputs, then out.

Passing one runs it: machine code is not sandboxed.
"""

from __future__ import annotations

import ctypes
import os
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, final

import numpy as np

from mecanique.arrays import Array
from mecanique.errors import InputError
from mecanique.model.mechanism import Mechanism

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
        expected = mechanism.nq if kind == "q" else mechanism.nv
        if int(size) != expected:
            names = mechanism.coordinates if kind == "q" else mechanism.velocities
            raise InputError(
                f"expected n{kind} = {expected} ({', '.join(names)}) in {header}, it states {size}"
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
    functions = {}
    for name, what in wanted.items():
        takes = _takes(name, declared[name])
        function = getattr(library, name, None)
        if function is None:
            raise InputError(f"{header} declares {name}, which {path} does not have")
        address = ctypes.cast(function, ctypes.c_void_p).value or 0
        parameters = _address(library, f"{name[: -len(what) - 1]}_parameters")
        functions[what] = CFunction(name, address, takes, parameters)
    return functions


def _quantity(name: str) -> str:
    return next((what for what in TAKES if name == what or name.endswith(f"_{what}")), "")


def _takes(name: str, arguments: str) -> tuple[str, ...]:
    """The inputs of a declared function."""
    words = [re.findall(r"\w+", part) for part in arguments.split(",")]
    names = [words_of[-1] if words_of else "" for words_of in words]
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


TAKES: dict[str, tuple[str, ...]] = {
    "acceleration": ("t", "q", "v", "tau", "p"),
    "mass_matrix": ("t", "q", "p"),
    "bias": ("t", "q", "v", "p"),
    "gravity": ("t", "q", "p"),
    "forces": ("t", "q", "v", "p"),
    "inverse_dynamics": ("t", "q", "v", "a", "p"),
    "energy": ("t", "q", "v", "p"),
}
"""What functions take, by the name of what they give."""

_GUARD = 64
"""Numbers behind a function's answer that it must leave as they are."""

_FUNCTION: Any = ctypes.CFUNCTYPE(None).__mro__[1]
"""The type of all functions of ctypes."""

_MARK = np.float64(-1.2345678987654321e-300)


@final
@dataclass(frozen=True)
class CFunction:
    """A function in machine code: void f(double t, const double *q, …, double *out)."""

    name: str
    address: int  # where it begins
    # its inputs in order, among t, q, v, a, tau and p; t is a number, the others arrays
    takes: tuple[str, ...]
    parameters: int | None = None  # address of its own parameters, given for p; NULL by default

    def __call__(self, inputs: Mapping[str, Array], size: int) -> Array:
        """Return so many numbers."""
        kinds = [ctypes.c_double if kind == "t" else ctypes.c_void_p for kind in self.takes]
        out = np.full(size + _GUARD, _MARK)
        kept, given = [], list[Any]()
        for kind in self.takes:
            if kind == "t":
                given.append(float(inputs["t"]))
            elif kind == "p":
                given.append(self.parameters)
            else:
                kept.append(np.ascontiguousarray(inputs[kind], dtype=float))
                given.append(kept[-1].ctypes.data)
        prototype = ctypes.CFUNCTYPE(None, *kinds, ctypes.c_void_p)
        prototype(self.address)(*given, out.ctypes.data)
        written = int(np.flatnonzero(out != _MARK).max(initial=-1)) + 1
        if written != size:
            raise InputError(f"expected {size} numbers from {self.name}, it wrote {written}")
        return out[:size]


def address_of(function: Any) -> int | None:
    """Return where a function of ctypes or cffi begins; None of any other."""
    if isinstance(function, _FUNCTION):
        return ctypes.cast(function, ctypes.c_void_p).value
    if type(function).__module__ == "_cffi_backend":
        from cffi import FFI

        return int(FFI().cast("intptr_t", function))
    return None
