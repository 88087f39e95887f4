"""Cache the code compiled for a mechanism as long as the mechanism lives."""

from __future__ import annotations

import weakref
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, final

from mecanique.errors import DerivationError
from mecanique.model.mechanism import Mechanism
from mecanique.motion.compile.closed import ClosedProgram
from mecanique.motion.compile.heyoka import integrator
from mecanique.motion.compile.program import RatesProgram, is_long_chain
from mecanique.motion.compile.python import Batched, overwriting, vectorize
from mecanique.motion.compile.stepper import Stepper
from mecanique.motion.record.curve import RightHandSide
from mecanique.motion.record.rates import Rates

if TYPE_CHECKING:
    from mecanique.program.tape import Value
    from mecanique.reference import Reference


OPTIMIZED = 50_000
"""After so many steps of Taylor series, optimizing their code pays for any mechanism."""


@final
class CompiledMotion:
    """Compiled equations of one mechanism, which they do not keep alive, built on first use."""

    def __init__(self, mechanism: Mechanism) -> None:
        self._mechanism = weakref.ref(mechanism)
        self._size = mechanism.nv
        self._closed = mechanism.constrained
        self.chain = is_long_chain(mechanism)
        """Whether its operations grow with its size, not with the cube of it."""
        self.rates = Rates.of(mechanism)
        """The maps between v and q̇."""
        self._program: RatesProgram | DerivationError | None = None
        self._along: dict[str, RatesProgram | None] = {}
        self.functions: dict[tuple[int, tuple[Value, ...]], Batched] = {}
        """Functions of arrays, by the tape that they are on and the values that they give."""
        self._stepper: Stepper | None = None
        self._make: Callable[[], RightHandSide] | None = None
        self._pools: dict[tuple[float, bool], list[Any]] = {}
        self._taken: dict[float, int] = {}
        self._optimized: set[float] = set()

    def program(self, reference: Reference) -> RatesProgram:
        """Return the equations as a program, after it was compared with the reference."""
        if self._program is None:
            mechanism = self._mechanism()
            assert mechanism is not None, "who asks holds the mechanism"
            try:
                from mecanique.motion.compile.derive import admit

                self._program, self._make = admit(mechanism, reference)
            except DerivationError as error:
                self._program = error
            except Exception as error:
                if not any(callable(signal.signal) for signal in mechanism.inputs):
                    raise
                self._program = DerivationError(
                    f"the equations of {mechanism.name!r} cannot be compared with the reference: "
                    f"an input fails at a random time ({error})"
                )
                self._program.__cause__ = error
        if isinstance(self._program, DerivationError):
            raise self._program
        return self._program

    def knows(self, forces: str) -> bool:
        """Return whether a program along motions was written."""
        return forces in self._along

    def along(self, forces: str = "") -> RatesProgram | None:
        """Return the rates of a state and forces, for many states at once; None if there are none.

        Args:
            forces: as `motion_of` knows them.
        """
        if forces not in self._along:
            from mecanique.motion.compile.derive import motion_of

            mechanism = self._mechanism()
            assert mechanism is not None, "who asks holds the mechanism"
            try:
                self._along[forces] = motion_of(mechanism, forces)
            except DerivationError:
                self._along[forces] = None
        return self._along[forces]

    def rhs(self, reference: Reference) -> RightHandSide:
        """Return a new function f(t, y) = y', which overwrites its last answer."""
        program = self.program(reference)
        if self._make is None:
            self._make = overwriting(program)
        if program.landing is not None:
            return ClosedProgram(program, program.landing, reference, self._make())
        return self._make()

    def stepper(self, reference: Reference) -> Stepper:
        """Return the equations as C, with the steps that integrate them."""
        if self._stepper is None:
            self._stepper = Stepper(self.program(reference))
        return self._stepper

    @property
    def possible(self) -> bool:
        """Whether there is a closed form, as far as known."""
        return not isinstance(self._program, DerivationError)

    def borrow(self, reference: Reference, tolerance: float, *, optimized: bool) -> Any:
        """Return a Taylor integrator for one user, who gives it back."""
        pool = self._pools.get((tolerance, optimized))
        if pool:
            return pool.pop()
        return integrator(self.program(reference), tolerance, optimized=optimized)

    def build_integrator(self, reference: Reference, tolerance: float, *, optimized: bool) -> None:
        """Build a Taylor integrator, if none is there."""
        machine = self.borrow(reference, tolerance, optimized=optimized)
        self.give_back(tolerance, machine, optimized=optimized)

    def pays_to_optimize(self, tolerance: float, steps: int = 0) -> bool:
        """Return whether motions of a tolerance have taken enough steps for optimized code."""
        if self._taken.get(tolerance, 0) + steps >= OPTIMIZED:
            self._optimized.add(tolerance)
        return self.is_optimized(tolerance)

    def is_optimized(self, tolerance: float) -> bool:
        """Whether Taylor integrators of a tolerance are optimized where that may change."""
        return tolerance in self._optimized

    def give_back(self, tolerance: float, machine: Any, steps: int = 0, *, optimized: bool) -> None:
        """Take a Taylor integrator back, for the next motion."""
        self._taken[tolerance] = self._taken.get(tolerance, 0) + steps
        self._pools.setdefault((tolerance, optimized), []).append(machine)

    def vectorize(self, reference: Reference) -> Batched:
        """Return the equations as a function of arrays."""
        return vectorize(self.program(reference))


_known: dict[int, tuple[weakref.ref[Mechanism], CompiledMotion]] = {}


def compile_once(mechanism: Mechanism) -> CompiledMotion:
    """Return the compiled code of a mechanism: one object as long as the mechanism lives."""
    key = id(mechanism)
    entry = _known.get(key)
    if entry is None or entry[0]() is not mechanism:
        # bound here: at the interpreter's end the module may be gone before the mechanism
        def forget(
            _: object, known: dict[int, tuple[weakref.ref[Mechanism], CompiledMotion]] = _known
        ) -> None:
            known.pop(key, None)

        entry = _known[key] = weakref.ref(mechanism, forget), CompiledMotion(mechanism)
    return entry[1]
