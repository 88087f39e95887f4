"""Functions in machine code, called as the C that `generate` writes: inputs, then out.

Passing one runs it: machine code is not sandboxed.
"""

from __future__ import annotations

import ctypes
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, final

import numpy as np

from mecanique.arrays import Array
from mecanique.errors import InputError

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
    """A function in machine code: void f(double t, const double *q, …, double *out).

    Args:
        name: for messages.
        address: where it begins.
        takes: its inputs in order, among t, q, v, a, tau and p; t is a number, the others arrays.
        parameters: address of its own parameters, given for p; NULL by default.
    """

    name: str
    address: int
    takes: tuple[str, ...]
    parameters: int | None = None

    def __call__(self, inputs: Mapping[str, Array], size: int) -> Array:
        """Return so many numbers.

        Args:
            inputs: by name.
            size: how many numbers it has to give.

        Raises:
            InputError: if it gives more or fewer.
        """
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
    """Return where a function of ctypes or cffi begins; None of any other.

    Args:
        function: any.
    """
    if isinstance(function, _FUNCTION):
        return ctypes.cast(function, ctypes.c_void_p).value
    if type(function).__module__ == "_cffi_backend":
        from cffi import FFI

        return int(FFI().cast("intptr_t", function))
    return None
