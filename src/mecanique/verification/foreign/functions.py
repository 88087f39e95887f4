"""Other sources to compare a mechanism with: a user's functions, or samples from a file."""

from __future__ import annotations

import csv
import inspect
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, final

import numpy as np

from mecanique.arrays import Array
from mecanique.errors import InputError, UnknownNameError
from mecanique.model.mechanism import Mechanism
from mecanique.model.states import States
from mecanique.verification.foreign.compiled import TAKES, CFunction, address_of, load_library


@final
@dataclass(frozen=True)
class Functions:
    """Equations of motion as functions of one state: M(q) a + C(q, v) v + g(q) = forces.

    Functions whose arguments are called t, q, v, a, tau and p, as those of `generate` are, get
    these by name: time, state, accelerations, no torques, and the parameters; so do CasADi's.
    Functions of ctypes and cffi are called as the C that `generate` writes.
    """

    mass_matrix: Callable[..., Any] | None = None  # (q) -> M, shape (nv, nv)
    bias: Callable[..., Any] | None = None  # (q, v) -> C v + g, shape (nv,)
    # (q, v) -> C, shape (nv, nv), or C v, shape (nv,); with `gravity`, instead of `bias`
    coriolis: Callable[..., Any] | None = None
    gravity: Callable[..., Any] | None = None  # (q) -> g, shape (nv,)
    forces: Callable[..., Any] | None = None  # (q, v) -> generalized forces, shape (nv,)
    # (q, v, a) -> M a + C v + g − forces, shape (nv,)
    inverse_dynamics: Callable[..., Any] | None = None
    acceleration: Callable[..., Any] | None = None  # (q, v) -> a, shape (nv,)
    energy: Callable[..., Any] | None = None  # (q, v) -> kinetic and potential energy, shape (2,)
    # of what rolls, names of the coordinates whose velocities the equations have left; M, bias and
    # forces then have as many rows, in this order, and still take all q and v
    by: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        known = [field.name for field in fields(self) if field.name != "by"]
        if not any(getattr(self, name) for name in known):
            names = ", ".join(known)
            raise InputError(f"expected at least one of the functions {names}")
        if self.coriolis and not self.bias and not self.gravity:
            raise InputError("expected gravity besides coriolis: what is compared is C v + g")

    @classmethod
    def of(cls, given: Mapping[str, Callable[..., Any]]) -> Functions:
        """Return functions by name; M, C and g are short for mass_matrix, coriolis and gravity."""
        short = {"M": "mass_matrix", "C": "coriolis", "g": "gravity"}
        known = [field.name for field in fields(cls) if field.name != "by"]
        named = {short.get(name, name): function for name, function in given.items()}
        for name in named:
            if name not in known:
                raise UnknownNameError("function", name, (*known, *short))
        functions: dict[str, Any] = named
        return cls(**functions)

    def values(self, mechanism: Mechanism, states: States) -> dict[str, Array]:
        """Return what the functions give at all states, by quantity."""
        n = len(self.by) or mechanism.nv
        call = _Caller(mechanism, states)
        values: dict[str, Array] = {}
        if self.mass_matrix:
            values["mass matrix"] = call(self.mass_matrix, "mass_matrix", "q", (n, n))
        if self.gravity:
            values["gravity"] = call(self.gravity, "gravity", "q", (n,))
        if self.bias:
            values["bias"] = call(self.bias, "bias", "qv", (n,))
        elif self.coriolis:
            C = call(self.coriolis, "coriolis", "qv", (n, n), (n,))
            Cv = np.einsum("nij,nj->ni", C, states.v) if C.ndim == 3 else C
            values["bias"] = Cv + values["gravity"]
        if self.forces:
            values["forces"] = call(self.forces, "forces", "qv", (n,))
        if self.inverse_dynamics:
            values["inverse dynamics"] = call(
                self.inverse_dynamics, "inverse_dynamics", "qva", (n,)
            )
        if self.acceleration:
            values["acceleration"] = call(self.acceleration, "acceleration", "qv", (n,))
        if self.energy:
            T, V = call(self.energy, "energy", "qv", (2,)).T
            values |= {"kinetic energy": T, "potential energy": V}
        return values


def ask_library(
    path: str | os.PathLike[str],
    header: str | os.PathLike[str] | None,
    mechanism: Mechanism,
    states: States,
) -> dict[str, Array]:
    """Return what the functions of a library give at states, by quantity."""
    return Functions.of(load_library(path, header, mechanism)).values(mechanism, states)


def read_samples(path: str | os.PathLike[str], mechanism: Mechanism) -> tuple[States, Array]:
    """Return the states and forces of a CSV file.

    Its first line names the columns, in any order: the coordinates (q), the velocities (q'), the
    accelerations (q''; of the velocity arm_wx, arm_wx'), the forces (tau_q, tau_arm_wx), and t.
    What follows a name in brackets, e.g. [rad/s], is not read, and other columns are passed over. A
    force or t without a column is zero: a file written by `Motion.to_csv` describes a free motion.
    """
    try:
        with Path(path).open(encoding="utf-8-sig", newline="") as stream:
            head, *rows = [row for row in csv.reader(stream) if row]
    except (OSError, UnicodeDecodeError, csv.Error, ValueError) as error:
        raise InputError(
            f"expected a CSV file with a line of names, but {path} cannot be read: {error}"
        ) from None
    names = [title.partition("[")[0].strip() for title in head]
    accelerations = [f"{name}'" for name in mechanism.velocities]
    for name in (*mechanism.coordinates, *mechanism.velocities, *accelerations):
        if name not in names:
            raise InputError(f"{path}: expected a column {name!r}, got {', '.join(names)}")
    if not rows:
        raise InputError(f"{path}: expected at least one line of numbers")
    columns: dict[str, list[float]] = {name: [] for name in names}
    for number, row in enumerate(rows, 2):
        if len(row) != len(names):
            raise InputError(f"{path}:{number}: expected {len(names)} numbers, got {len(row)}")
        for name, word in zip(names, row, strict=True):
            columns[name].append(_number(word))
    zero = [0.0] * len(rows)
    forces = [f"tau_{name.removesuffix(chr(39))}" for name in mechanism.velocities]
    wanted = (tuple(mechanism.coordinates), mechanism.velocities, accelerations, forces)

    def table(part: Sequence[str]) -> Array:
        rows_by_column = np.array([columns.get(name, zero) for name in part])
        by_row: Array = rows_by_column.reshape(-1, len(rows)).T
        return by_row

    q, v, a, tau = map(table, wanted)
    t = np.array(columns.get("t", zero))
    for what, values in zip(
        ("coordinates", "velocities", "accelerations", "forces", "t"),
        (q, v, a, tau, t),
        strict=True,
    ):
        bad = np.flatnonzero(~np.isfinite(values.reshape(len(rows), -1)).all(axis=1))
        if len(bad):
            raise InputError(f"{path}:{bad[0] + 2}: expected finite numbers for the {what}")
    return States.of(mechanism, q, v, t, a), tau


def _number(word: str) -> float:
    try:
        return float(word)
    except ValueError:
        return float("nan")


@final
class _Caller:
    """Calls functions at states."""

    def __init__(self, mechanism: Mechanism, states: States) -> None:
        n = len(states)
        values = [*mechanism.values.values(), *_constants(mechanism)]
        self._rows: dict[str, Array] = {
            "t": states.t,
            "q": states.q,
            "v": states.v,
            "a": states.a,
            "tau": np.zeros((n, mechanism.nv)),
            "p": np.tile(np.array(values, dtype=float), (n, 1)),
        }

    def __call__(
        self, function: Callable[..., Any], name: str, usual: str, *shapes: tuple[int, ...]
    ) -> Array:
        """Return what a function gives at all states."""
        code = function
        if not isinstance(function, CFunction) and (address := address_of(function)) is not None:
            code = CFunction(name, address, TAKES[name])
        if isinstance(code, CFunction):
            takes: tuple[str, ...] = code.takes
        else:
            takes = _find_names(function, self._rows) or tuple(usual)
            self._refuse_sizes(function, name, takes)
        answers = []
        for k in range(len(self._rows["t"])):
            row = {kind: self._rows[kind][k].copy() for kind in takes}
            answers.append(self._one(code, name, row, shapes))
        return np.array(answers)

    def _refuse_sizes(self, function: Any, name: str, takes: tuple[str, ...]) -> None:
        """Refuse a function of CasADi with arguments of other sizes."""
        if not callable(getattr(function, "name_in", None)):
            return
        for k, kind in enumerate(takes):
            size = 1 if kind == "t" else self._rows[kind].shape[1]
            if function.numel_in(k) != size:
                raise InputError(
                    f"expected {size} numbers for {kind} of {name}, the function takes "
                    f"{function.numel_in(k)}"
                )

    def _one(
        self,
        function: Callable[..., Any],
        name: str,
        row: Mapping[str, Array],
        shapes: tuple[tuple[int, ...], ...],
    ) -> Array:
        """One answer."""
        listed = ", ".join(str(x.tolist()) for kind, x in row.items() if kind in "qva")
        if isinstance(function, CFunction):
            return function(row, int(np.prod(shapes[0]))).reshape(shapes[0])
        try:
            value = np.asarray(function(*row.values()), dtype=float)
        except (Exception, SystemExit) as error:
            # any error of a user's own function is reported together with the state; its exit
            # would end this program as if all agreed
            raise InputError(f"{name}({listed}) raised {type(error).__name__}: {error}") from error
        if value.shape not in shapes and value.size == int(np.prod(shapes[0])):
            value = value.reshape(shapes[0])
        if value.shape not in shapes:
            expected = " or ".join(map(str, shapes))
            raise InputError(
                f"expected shape {expected} from {name}, got {value.shape} at {listed}"
            )
        return value


def _constants(mechanism: Mechanism) -> list[float]:
    """Values of the inputs, where they are constants."""
    signals = [given.signal for given in mechanism.inputs]
    return [signal for signal in signals if isinstance(signal, float)]


def _find_names(function: Any, rows: Mapping[str, Array]) -> tuple[str, ...]:
    """The arguments of a function by name, if these say what they are."""
    names_of = getattr(function, "name_in", None)
    if callable(names_of):
        names = list(names_of())
    else:
        try:
            parameters = inspect.signature(function).parameters.values()
        except (TypeError, ValueError):
            return ()
        names = [
            parameter.name
            for parameter in parameters
            # a state is given also where it may be left out, as by `Reference.bias`
            if parameter.default is parameter.empty or parameter.name in ("q", "v", "a")
        ]
    return tuple(names) if "q" in names and all(name in rows for name in names) else ()
