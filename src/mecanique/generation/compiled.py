"""Compile C, and call it as functions of numpy arrays."""

from __future__ import annotations

import ctypes
import os
import subprocess
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, final

import numpy as np

from mecanique.arrays import Array
from mecanique.errors import InputError, UnknownNameError
from mecanique.generation.program import Answer, Program
from mecanique.generation.targets.c import compiler, limit_optimization
from mecanique.generation.targets.target import run_command

OPTIONS = ("-O1", "-march=native")
"""More optimization of programs without branches takes long and gains nothing."""

SECONDS = 300.0
"""Time limit of the compiler [s]."""


@final
class Compiled:
    """Functions compiled from C, for one state or many: `compiled.acceleration(t, q, v)`.

    Each quantity is an attribute. Arguments are those of the C function, by position or name; q of
    shape (nq,) or (n, nq) and so on; tau and p, an array or values by symbol, may be left out.

    Args:
        program: the compiled program.
        library: the shared library.
    """

    def __init__(self, program: Program, library: ctypes.CDLL) -> None:
        self._program = program
        self._library = library
        self._answers = {answer.quantity.name: answer for answer in program.answers}

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_") or name not in self._answers:
            raise AttributeError(f"no function {name!r} was compiled; there is: {self._names()}")
        function = _Function(self._program, self._answers[name], self._library)
        setattr(self, name, function)
        return function

    def __repr__(self) -> str:
        return f"<Compiled {self._program.name}: {self._names()}>"

    def _names(self) -> str:
        return ", ".join(self._answers)


@final
class _Function:
    """One compiled function."""

    def __init__(self, program: Program, answer: Answer, library: ctypes.CDLL) -> None:
        self._answer = answer
        self._letters = program.letters
        self._parameters = np.array([letter.value for letter in program.parameters])
        self._places = {letter.name: k for k, letter in enumerate(program.parameters)}
        self._takes = (*answer.quantity.takes, "p")
        self._many = getattr(library, f"{program.name}_{answer.quantity.name}_many")
        self._many.restype = None
        self._many.argtypes = [ctypes.c_long, *[ctypes.c_void_p] * (2 * len(self._takes) + 1)]

    def __call__(self, *args: Any, **named: Any) -> Array:
        takes, name = self._takes, self._answer.quantity.name
        if len(args) > len(takes):
            raise InputError(f"expected at most {len(takes)} arguments of {name}, got {len(args)}")
        given = dict(zip(takes, args, strict=False))
        for key, value in named.items():
            if key not in takes:
                raise UnknownNameError(f"argument of {name}", key, takes)
            if key in given:
                raise InputError(f"argument {key!r} of {name} is given twice")
            given[key] = value
        rows: dict[str, Array | None] = {}
        leading: tuple[int, ...] = ()
        for kind in takes:
            size = self._size(kind)
            value = given.get(kind)
            if value is None and kind not in ("tau", "p", "t"):
                raise InputError(f"expected {kind} in a call of {name}")
            if kind == "p":
                value = self._values(value)
            if value is None:
                rows[kind] = None if kind == "tau" else np.zeros(1)
                continue
            array = np.asarray(value, dtype=float)
            array = array[..., None] if kind == "t" else array
            if array.shape[-1:] != (size,) or array.ndim > 2:
                raise InputError(
                    f"expected shape ({size},) or (n, {size}) for {kind} in a call of {name}, "
                    f"got {array.shape}"
                )
            rows[kind] = np.ascontiguousarray(array)
            if array.ndim == 2:
                if leading and leading[0] != len(array):
                    raise InputError(
                        f"expected one number of states in a call of {name}, got {leading[0]} and "
                        f"{len(array)}"
                    )
                leading = (len(array),)
        count = leading[0] if leading else 1
        out = np.empty((count, max(len(self._answer.values), 1)))
        addresses: list[Any] = []
        steps: list[Any] = []
        for kind in takes:
            row = rows[kind]
            addresses.append(None if row is None else row.ctypes.data)
            steps.append(row.shape[-1] if row is not None and row.ndim == 2 else 0)
        self._many(count, *addresses, *steps, out.ctypes.data)
        return out[:, : len(self._answer.values)].reshape(*leading, *self._answer.shape)

    def _size(self, kind: str) -> int:
        if kind == "y":
            return len(self._letters["q"]) + len(self._letters["v"])
        return len(self._letters[kind])

    def _values(self, given: Any) -> Any:
        if not isinstance(given, Mapping):
            return self._parameters if given is None else given
        values = self._parameters.copy()
        for symbol, value in given.items():
            if symbol not in self._places:
                raise UnknownNameError("parameter", symbol, self._places)
            values[self._places[symbol]] = value
        return values


def compile_program(
    program: Program, files: Mapping[str, str], options: Sequence[str] = OPTIONS
) -> Compiled:
    """Compile the C of a program and load it."""
    sources = {name: files[name] for name in (f"{program.name}.h", f"{program.name}.c")}
    return Compiled(program, build_library({**sources, "many.c": _write_loops(program)}, options))


def build_library(files: Mapping[str, str], options: Sequence[str] = OPTIONS) -> ctypes.CDLL:
    """Compile C and load it."""
    # Windows cannot remove a library that is loaded
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:
        directory = Path(folder)
        for name, text in files.items():
            (directory / name).write_text(text, encoding="utf-8")
        library = directory / ("library.dll" if os.name == "nt" else "library.so")
        sources = [directory / name for name in files if name.endswith(".c")]
        shared = ["-std=c99", "-shared", "-fPIC", "-o", str(library)]
        options = [*options, *limit_optimization(sources)]
        command = [compiler(), *options, *shared, *map(str, sources), "-lm"]
        try:
            done = run_command(command, SECONDS)
        except subprocess.TimeoutExpired:
            raise InputError(
                f"the C compiler did not end within {SECONDS:.0f} s; expected a shorter program, "
                'or options=("-O0",)'
            ) from None
        if done.returncode:
            raise InputError(f"the C compiler refused: {done.stderr.strip()[:2000]}")
        try:
            return ctypes.CDLL(str(library))
        except OSError as error:
            raise InputError(
                "expected a C compiler whose libraries Python can load, of its own system and "
                f"width; {command[0]} made one that does not load: {error}"
            ) from None


def _write_loops(program: Program) -> str:
    """Write a loop over many states for each function; the step of a shared argument is 0."""
    lines = [f'#include "{program.name}.h"', "#include <stddef.h>", "#include <stdint.h>", ""]
    for answer in program.answers:
        takes = (*answer.quantity.takes, "p")
        name = f"{program.name}_{answer.quantity.name}"
        given = [f"const double *{kind}" for kind in takes]
        steps = [f"void *{kind}_step" for kind in takes]
        size = max(len(answer.values), 1)
        calls = []
        for kind in takes:
            at = f"{kind} + k * (ptrdiff_t)(intptr_t){kind}_step"
            calls.append(f"*({at})" if kind == "t" else f"{kind} == NULL ? NULL : {at}")
        lines += [
            f"void {name}_many(long n, {', '.join(given)}, {', '.join(steps)}, double *out)",
            "{",
            "    for (long k = 0; k < n; k++) {",
            f"        {name}({', '.join(calls)}, out + k * {size});",
            "    }",
            "}",
            "",
        ]
    return "\n".join(lines)
