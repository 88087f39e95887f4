"""Programs compiled to C together with the steps that integrate them."""

from __future__ import annotations

import ctypes
from dataclasses import dataclass
from functools import cache
from typing import Any, final

import numpy as np
import numpy.typing as npt

from mecanique.arrays import Array
from mecanique.errors import DerivationError, InputError
from mecanique.generation.dop853 import BEFORE, NEAREST
from mecanique.motion.compile.program import RatesProgram

ENDED = ("end", "room", "near", "small", "many", "stiff", "off", "past")
"""Why a motion stops, by the number that says so: it came to its end; there is no more room for
steps; it came near a singular position; its steps are too small, or too many, or the equations are
stiff; no state was finite and on the loops; it has passed a singular position."""

_ROOM = 4096
"""Steps that are noted at a time."""

_OPTIONS = ("-O2", "-march=native", "-fno-math-errno", "-fno-trapping-math")


@final
@dataclass(frozen=True)
class Tolerances:
    """How accurately to integrate."""

    rtol: float
    atol: float
    max_step: float  # longest step [s]
    max_steps: int


class _Motion(ctypes.Structure):
    """As in stepper.c."""

    _fields_ = [
        *((name, ctypes.c_double) for name in ("t", "end", "h", "before", "rtol", "atol")),
        *((name, ctypes.c_double) for name in ("max_step", "near", "leap")),
        *((name, ctypes.c_long) for name in ("most", "steps", "evaluations")),
        *((name, ctypes.c_long) for name in ("at_limit", "below")),
    ]


class _Notes(ctypes.Structure):
    """As in stepper.c."""

    _fields_ = [
        *((name, ctypes.c_long) for name in ("room", "noted")),
        *((name, ctypes.c_void_p) for name in ("t", "y", "dy")),
    ]


class _Samples(ctypes.Structure):
    """As in stepper.c."""

    _fields_ = [
        *((name, ctypes.c_long) for name in ("number", "done")),
        *((name, ctypes.c_void_p) for name in ("times", "states")),
    ]


class _Runs(ctypes.Structure):
    """As in stepper.c."""

    _fields_ = [
        *((name, ctypes.c_long) for name in ("count", "width")),
        *((name, ctypes.c_void_p) for name in ("starts", "parameters")),
        ("samples", _Samples),
        *((name, ctypes.c_void_p) for name in ("steps", "ended")),
    ]


@cache
def has_compiler() -> bool:
    """Return whether there is a C compiler."""
    from mecanique.generation.targets.c import compiler

    try:
        compiler()
    except InputError:
        return False
    return True


@cache
def can_compile() -> bool:
    """Return whether there is a C compiler, and Python can load what it makes; this builds once."""
    from mecanique.generation.compiled import build_library

    try:
        build_library({"empty.c": "int mecanique_empty(void) { return 0; }\n"})
    except InputError:
        return False
    return True


@final
class March:
    """One motion from a state (size,) at t0 [s] under way, with samples at times (n,) [s]."""

    def __init__(
        self,
        library: ctypes.CDLL,
        size: int,
        start: Array,
        t0: float,
        times: Array,
        tolerances: Tolerances,
    ) -> None:
        self._advance = library.mecanique_advance
        self._motion = _begin(t0, tolerances)
        self._times = np.ascontiguousarray(times, dtype=float)
        self.y: Array = np.array(start, dtype=float)
        """The state now."""
        self.samples: Array = np.full((len(times), size), np.nan)
        """The states at the times that were passed, shape (n, size)."""
        passed = int(np.searchsorted(self._times, t0, side="right"))
        self.samples[:passed] = start
        self._samples = _Samples(len(times), passed, _at(self._times), _at(self.samples))

    @property
    def t(self) -> float:
        """The time now [s]."""
        return float(self._motion.t)

    @property
    def evaluations(self) -> int:
        """How often the equations were evaluated."""
        return int(self._motion.evaluations)

    @property
    def passed(self) -> int:
        """How many of the times of samples were passed."""
        return int(self._samples.done)

    def advance(self, end: float) -> tuple[str, Array, Array, Array]:
        """Integrate until `end` [s]; return why it stopped, and the steps: t, y and y'."""
        self._motion.end = end
        size = len(self.y)
        t, y, dy = np.empty(_ROOM), np.empty((_ROOM, size)), np.empty((_ROOM, size))
        notes = _Notes(_ROOM, 0, _at(t), _at(y), _at(dy))
        moving = ctypes.byref(self._motion), None, _at(self.y)
        reason = self._advance(*moving, ctypes.byref(notes), ctypes.byref(self._samples))
        taken = notes.noted
        return ENDED[reason], t[:taken], y[:taken], dy[:taken]

    def leap(self, distance: float) -> None:
        """Leap across singular positions from a distance on; from 0, stop before them."""
        self._motion.leap = distance

    def put(self, t: float, y: Array, passed: int) -> None:
        """Set the time [s], the state and how many times of samples lie before."""
        self._motion.t, self._motion.h, self.y[:] = t, 0.0, y
        self._samples.done = passed


@final
class Stepper:
    """A program with the steps that integrate it, compiled; closed loops stay closed."""

    def __init__(self, program: RatesProgram) -> None:
        refuse_signals(program)
        self._size = len(program.rates)
        from mecanique.generation.compiled import build_library

        self._library = build_library({"steps.c": _source(program)}, _OPTIONS)
        self._library.mecanique_advance.restype = ctypes.c_int
        self._library.mecanique_distance.restype = ctypes.c_double
        self._library.mecanique_advance_many.restype = None

    def distance(self, t: float, y: Array) -> float:
        """Return the distance along the motion to a singular position, to first order."""
        speed, state = ctypes.c_double(), np.ascontiguousarray(y)
        none = ctypes.c_void_p(None)
        distance = self._library.mecanique_distance
        return float(distance(ctypes.c_double(t), _at(state), none, ctypes.byref(speed)))

    def march(self, start: Array, t0: float, times: Array, tolerances: Tolerances) -> March:
        """Return a motion to integrate from a state (nq + nv,), sampled at times (n,) [s]."""
        return March(self._library, self._size, start, t0, times, tolerances)

    def march_all(
        self, starts: Array, parameters: Array, times: Array, tolerances: Tolerances
    ) -> tuple[Array, npt.NDArray[Any], npt.NDArray[Any]]:
        """Integrate n motions; return states at all times (m,) [s], steps, and why each ended."""
        count = len(starts)
        starts, parameters, later = (
            np.ascontiguousarray(x, dtype=float) for x in (starts, parameters, times[1:])
        )
        states = np.full((count, len(later), self._size), np.nan)
        steps, ended = np.zeros(count, dtype=np.int_), np.zeros(count, dtype=np.int32)
        motion = _begin(float(times[0]), tolerances)
        motion.end = float(times[-1])
        runs = _Runs(
            count,
            parameters.shape[1],
            _at(starts),
            _at(parameters),
            _Samples(len(later), 0, _at(later), _at(states)),
            _at(steps),
            _at(ended),
        )
        self._library.mecanique_advance_many(ctypes.byref(motion), ctypes.byref(runs))
        whole = np.concatenate([starts[:, None], states], axis=1)
        return whole, steps, ended


def refuse_signals(program: RatesProgram) -> None:
    """Raise if C does not know an input of a program."""
    if program.signals:
        raise DerivationError(
            f"compiled C needs the equations as formulas, but the input "
            f"{', '.join(program.signals)} is a function or a record"
        )


def _begin(t0: float, tolerances: Tolerances) -> _Motion:
    return _Motion(
        t=t0,
        end=t0,
        before=BEFORE,
        rtol=tolerances.rtol,
        atol=tolerances.atol,
        max_step=tolerances.max_step,
        near=NEAREST,
        most=tolerances.max_steps,
    )


def _at(array: npt.NDArray[Any]) -> ctypes.c_void_p:
    return ctypes.c_void_p(array.ctypes.data)


def _source(program: RatesProgram) -> str:
    """The whole text: sizes, coefficients, the program, the steps."""
    from mecanique.generation.targets.c import SteppedProgram, write_steps

    symbols = {state: f"y{k}" for k, state in enumerate(program.states)}
    symbols |= {symbol: f"p{k}" for k, symbol in enumerate(program.open)} | {"t": "t"}
    mechanism, tape = program.mechanism, program.tape
    return write_steps(SteppedProgram(mechanism, tape, symbols, program.rates, program.landing))
