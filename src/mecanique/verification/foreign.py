"""Equations of motion in other programs: functions, compiled or not, FMUs, samples from a file.

Functions in machine code are called as the C that `generate` writes: inputs, then out. Machine code
is not sandboxed: passing a library or an FMU runs it, in a process of its own, which it may end.
"""

from __future__ import annotations

import csv
import ctypes
import inspect
import os
import pickle
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields
from importlib.util import find_spec
from pathlib import Path
from typing import Any, final

import numpy as np

from mecanique.arrays import Array
from mecanique.errors import InputError, UnknownNameError
from mecanique.model.mechanism import Mechanism
from mecanique.model.states import States

_PROGRAM = "import sys; from mecanique.verification.foreign import work; work(sys.argv[1])"


def ask_in_child(name: str, function: Callable[..., Any], *arguments: Any) -> Any:
    """Return what a function returns in another process, or raise what it raises there."""
    with tempfile.TemporaryDirectory(prefix="mecanique_foreign_") as folder:
        Path(folder, "task").write_bytes(pickle.dumps((function, arguments)))
        ended = subprocess.run(
            [sys.executable, "-c", _PROGRAM, folder],
            env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
            check=False,
        )
        answer = Path(folder, "answer")
        if not answer.exists():
            code = ended.returncode
            how = f"signal {-code}" if code < 0 else f"exit code {code}"
            raise InputError(f"{name} ended its process, with {how}, instead of answering")
        returned = pickle.loads(answer.read_bytes())
    if isinstance(returned, Exception):
        raise returned
    return returned


def work(folder: str) -> None:
    """Do the task in a folder, and write the answer beside it once it is whole."""
    function, arguments = pickle.loads(Path(folder, "task").read_bytes())
    try:
        returned = function(*arguments)
    except Exception as error:
        returned = error
    part = Path(folder, "part")
    part.write_bytes(pickle.dumps(returned))
    part.rename(Path(folder, "answer"))


LIBRARIES = (".so", ".dylib", ".dll")
"""Endings of shared libraries."""

_DECLARATION = re.compile(r"\bvoid\s+(\w+)\s*\(([^)]*)\)\s*;")
_SIZE = re.compile(r"\b\w*?n([qv])\s*=\s*(\d+)")
_COMMENT = re.compile(r"/\*.*?\*/|//[^\n]*", re.DOTALL)
_INPUTS = ("t", "q", "v", "a", "tau", "p")


def load_library(
    path: str | os.PathLike[str], header: str | os.PathLike[str] | None, mechanism: Mechanism
) -> dict[str, CFunction]:
    """Return the functions of a library that a header declares, by what they give."""
    # known by the end of its name, `…_acceleration`; the arguments as in the C that `generate`
    # writes
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
    wanted = {name: what for name in declared if (what := quantity_of(name))}
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


def quantity_of(name: str) -> str:
    """Return what a function gives by its own name, or the end of it; empty if it is none."""
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


_ENERGIES = ("kinetic energy", "potential energy")


def ask_fmu(path: str | os.PathLike[str], mechanism: Mechanism, states: States) -> dict[str, Array]:
    """Return what a model gives at states, by quantity: accelerations, energies if any."""
    # its states are known by their names, or der(θ) for the velocity of θ; parameters and inputs
    # are as it starts
    if find_spec("fmpy") is None:
        raise InputError("expected fmpy, which is not installed: pip install 'mecanique[fmpy]'")
    given = (path, mechanism, states)
    values: dict[str, Array] = ask_in_child(os.fspath(path), _run_file, *given)
    return values


def _run_file(
    path: str | os.PathLike[str], mechanism: Mechanism, states: States
) -> dict[str, Array]:
    import fmpy

    try:
        described = fmpy.read_model_description(os.fspath(path))
    except Exception as error:
        # FMPy raises whatever the file's fault leads to
        raise InputError(f"expected an FMU, but {path} cannot be read: {error}") from None
    if described.modelExchange is None or not described.fmiVersion.startswith(("2", "3")):
        raise InputError(
            f"expected an FMU for model exchange by FMI 2 or 3, got FMI {described.fmiVersion}"
            f"{'' if described.modelExchange else ' without model exchange'} in {path}"
        )
    folder = fmpy.extract(os.fspath(path))
    try:
        return _run(_Model(described, folder), described, mechanism, states)
    except (fmpy.fmi1.FMICallException, OSError) as error:
        raise InputError(f"the FMU {path} fails: {error}") from None
    finally:
        shutil.rmtree(folder, ignore_errors=True)


class _Model:
    """An instance of FMI 2 or 3."""

    def __init__(self, described: Any, folder: str) -> None:
        from fmpy.fmi2 import FMU2Model
        from fmpy.fmi3 import FMU3Model

        self._second = described.fmiVersion.startswith("2")
        kind = FMU2Model if self._second else FMU3Model
        self.fmu = kind(
            guid=described.guid,
            unzipDirectory=folder,
            modelIdentifier=described.modelExchange.modelIdentifier,
            instanceName="verify",
        )
        if self._second:
            self.fmu.instantiate()
            self.fmu.setupExperiment()
        else:
            self.fmu.instantiate(logMessage=lambda *said: None)
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()
        if self._second:
            self.fmu.newDiscreteStates()
        else:
            self.fmu.updateDiscreteStates()
        self.fmu.enterContinuousTimeMode()

    def put(self, t: float, state: Sequence[float]) -> None:
        """Set the state."""
        self.fmu.setTime(t)
        numbers = (ctypes.c_double * len(state))(*state)
        self.fmu.setContinuousStates(numbers, len(state))

    def rates(self, size: int) -> Array:
        """Return the rates of its states."""
        numbers = (ctypes.c_double * size)()
        read = self.fmu.getDerivatives if self._second else self.fmu.getContinuousStateDerivatives
        read(numbers, size)
        return np.array(numbers)

    def read(self, references: Sequence[int]) -> list[float]:
        """Return variables."""
        get = self.fmu.getReal if self._second else self.fmu.getFloat64
        return list(get(references))


def _run(model: _Model, described: Any, mechanism: Mechanism, states: States) -> dict[str, Array]:
    names = [
        described_variable.variable.derivative.name for described_variable in described.derivatives
    ]
    order = _order(names, mechanism)
    variables = {variable.name: variable for variable in described.modelVariables}
    energies = [variables.get(name.replace(" ", "_")) for name in _ENERGIES]
    references = [
        described_variable.valueReference
        for described_variable in energies
        if described_variable is not None
    ]
    accelerations, energies_read = [], []
    for t, q, v in zip(states.t.tolist(), states.q, states.v, strict=True):
        model.put(t, np.concatenate([q, v])[order].tolist())
        rates = np.empty(len(order))
        rates[order] = model.rates(len(order))
        accelerations.append(rates[mechanism.nq :])
        if len(references) == len(_ENERGIES):
            energies_read.append(model.read(references))
    model.fmu.terminate()
    model.fmu.freeInstance()
    values: dict[str, Array] = {"acceleration": np.array(accelerations)}
    if energies_read:
        values |= zip(_ENERGIES, np.array(energies_read).T, strict=True)
    return values


def _order(names: Sequence[str], mechanism: Mechanism) -> list[int]:
    """Where each state of a model stands among the coordinates and velocities."""
    ours = [*mechanism.coordinates, *mechanism.velocities]
    places = {name: k for k, name in enumerate(ours)}
    for name in mechanism.velocities:
        if name.endswith("'"):
            places.setdefault(f"der({name[:-1]})", places[name])
    unknown = [name for name in names if name not in places]
    missing = [name for k, name in enumerate(ours) if k not in map(places.get, names)]
    if unknown or missing or len(names) != len(ours):
        raise InputError(
            f"expected the states {', '.join(ours)} in the FMU, got {', '.join(names) or 'none'}; "
            f"it lacks {', '.join(missing) or 'none'}, and "
            f"{', '.join(unknown) or 'none'} are unknown"
        )
    return [places[name] for name in names]


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
        shapes = {"mass_matrix": (n, n), "energy": (2,)}
        values: dict[str, Array] = {}
        for name, takes in TAKES.items():
            if function := getattr(self, name):
                usual = "".join(kind for kind in takes if kind in "qva")
                shape = shapes.get(name, (n,))
                values[name.replace("_", " ")] = call(function, name, usual, shape)
        if self.coriolis and not self.bias:
            C = call(self.coriolis, "coriolis", "qv", (n, n), (n,))
            Cv = np.einsum("nij,nj->ni", C, states.v) if C.ndim == 3 else C
            values["bias"] = Cv + values["gravity"]
        if "energy" in values:
            values |= zip(_ENERGIES, values.pop("energy").T, strict=True)
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
            answers.append(self._answer(code, name, row, shapes))
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

    def _answer(
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
