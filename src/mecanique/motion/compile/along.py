"""Quantities in many states of a motion at once, by programs that the reference agrees with.

The engine answers one state at a time, each with Python's cost; a program answers as many as a
motion has samples in about the time that the motion took. The reference has to agree with it at
states of this motion, and it answers alone where a singular position of the loops is near.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import TYPE_CHECKING, final

import numpy as np

from mecanique.generation.dop853 import NEAREST, PROBE
from mecanique.model.mechanism import Mechanism
from mecanique.model.mechanism_units import velocity_scales
from mecanique.model.states import States
from mecanique.motion.compile.cache import compile_once
from mecanique.motion.compile.program import RatesProgram
from mecanique.motion.compile.python import Batched, vectorize
from mecanique.motion.record.spot_check import agrees, spot_check, spread
from mecanique.motion.tolerances import ACCELERATIONS

if TYPE_CHECKING:
    from mecanique.program.tape import Value
    from mecanique.reference import Reference
    from mecanique.reference.engine.answers import Wrench


MANY_SUMS, MANY = 2000, 400
"""In so many states a program of sums, or of accelerations and reactions, pays for its writing."""

BLOCK = 16_384
"""States computed together: their arrays stay in the processor's cache."""


def compute(
    function: Batched, t: np.ndarray, q: np.ndarray, v: np.ndarray, width: int
) -> np.ndarray:
    """Return what a function of arrays writes, shape (n, width)."""
    states, out = np.ascontiguousarray(np.hstack([q, v]).T), np.empty((width, len(t)))
    for first in range(0, len(t), BLOCK):
        part = slice(first, first + BLOCK)
        function(t[part], states[:, part], out[:, part])
    return np.asarray(out.T)


def _is_blind(mechanism: Mechanism) -> bool:
    """Return whether an input is a function, which need not take arrays."""
    return any(callable(signal.signal) for signal in mechanism.inputs)


@final
@dataclass(frozen=True)
class StateSums:
    """Sums over bodies or forces in many states: by a program, where these are many."""

    mechanism: Mechanism
    write: Callable[[Mechanism], RatesProgram]
    # gives the same by t, q and v, shape (n, k)
    ask: Callable[[np.ndarray, np.ndarray, np.ndarray], np.ndarray]

    def __call__(self, t: np.ndarray, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Return the sums, shape (n, k)."""
        if len(t) < MANY_SUMS or _is_blind(self.mechanism):
            return self.ask(t, q, v)

        function, width = self._function
        (sums,) = spot_check(
            lambda: [compute(function, t, q, v, width)],
            lambda at: [self.ask(t[at], q[at], v[at])],
            len(t),
        )
        return sums

    @cached_property
    def _function(self) -> tuple[Batched, int]:
        program = self.write(self.mechanism)
        return vectorize(program), len(program.rates)


@final
@dataclass(frozen=True)
class StateLaw:
    """Gives accelerations and reactions in states of a motion."""

    mechanism: Mechanism
    reference: Reference

    def accelerations(self, t: np.ndarray, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Return the accelerations, shape (n, nv), by t, shape (n,) [s], q and v."""

        def ask(at: np.ndarray) -> np.ndarray:
            states = States.of(self.mechanism, q[at], v[at], t[at])
            return self.reference.quick_accelerations(states)

        program = compile_once(self.mechanism).accelerations if self._pays(len(t)) else None
        return self._answer(program, self.mechanism.nq, ask, t, q, v)

    def reactions(self, t: np.ndarray, q: np.ndarray, v: np.ndarray) -> dict[str, Wrench]:
        """Return the reactions of joints, loops and contacts, by name, as `Reference` does."""
        program = compile_once(self.mechanism).reactions if self._pays(len(t)) else None
        if program is None:
            return self.reference.reactions(q, v, t)
        from mecanique.reference.engine.answers import BodyPoses

        few = spread(len(t))
        some = self.reference.reactions(q[few], v[few], t[few])

        def ask(at: np.ndarray) -> np.ndarray:
            same = np.array_equal(at, few)
            known = some if same else self.reference.reactions(q[at], v[at], t[at])
            parts = [part for wrench in known.values() for part in (wrench.force, wrench.moment)]
            return np.hstack(parts)

        first = self.mechanism.nq + self.mechanism.nv
        forces = self._answer(program, first, ask, t, q, v).reshape(len(t), -1, 2, 3)
        places = BodyPoses(partial(self._poses, q, t))
        return {
            name: replace(wrench, force=forces[:, k, 0], moment=forces[:, k, 1], places=places)
            for k, (name, wrench) in enumerate(some.items())
        }

    def _poses(self, q: np.ndarray, t: np.ndarray) -> dict[str, np.ndarray]:
        names = [body.name for body in self.mechanism.bodies]
        return dict(zip(names, np.moveaxis(self.reference.poses(q, t), 1, 0), strict=True))

    def _pays(self, count: int) -> bool:
        return count >= MANY and not _is_blind(self.mechanism)

    @cached_property
    def _functions(self) -> dict[tuple[Value, ...], Batched]:
        return {}

    def _compute(
        self,
        program: RatesProgram,
        rates: tuple[Value, ...],
        t: np.ndarray,
        q: np.ndarray,
        v: np.ndarray,
    ) -> np.ndarray:
        """Return values on a program's tape, shape (n, rates)."""
        if rates not in self._functions:
            self._functions[rates] = vectorize(replace(program, rates=rates))
        return compute(self._functions[rates], t, q, v, len(rates))

    def _answer(
        self,
        program: RatesProgram | None,
        first: int,
        ask: Callable[[np.ndarray], np.ndarray],
        t: np.ndarray,
        q: np.ndarray,
        v: np.ndarray,
    ) -> np.ndarray:
        """Return the answers of a program from the first on, the reference's where it is unsure."""
        if program is None:
            return ask(np.arange(len(t)))
        with np.errstate(all="ignore"):
            answers = self._compute(program, program.rates, t, q, v)
            sure = np.isfinite(answers).all(axis=1) & self._is_regular(program, answers, t, q, v)
        asked = spread(len(t))
        if sure[asked].any():
            right = ask(asked)
            most = ACCELERATIONS * (1.0 + np.abs(right).max(initial=0.0))
            kept = sure[asked]
            if not agrees(answers[asked][kept, first:], right[kept], most):
                sure[:] = False
        result: np.ndarray = answers[:, first:]
        if not sure.all():
            result[~sure] = ask(np.flatnonzero(~sure))
        return result

    def _is_regular(
        self,
        program: RatesProgram,
        rates: np.ndarray,
        t: np.ndarray,
        q: np.ndarray,
        v: np.ndarray,
    ) -> np.ndarray:
        """Whether no singular position of the loops is near, to first order along the motion."""
        if program.landing is None:
            return np.ones(len(t), dtype=bool)
        measure = (program.landing.firmness,)
        firmness = self._compute(program, measure, t, q, v)[:, 0]
        speed = np.abs(v / velocity_scales(self.mechanism)).max(axis=1)
        step = np.where(speed > 0, PROBE / speed, 0.0)[:, None]
        there = q + step * rates[:, : self.mechanism.nq]
        ahead = self._compute(program, measure, t, there, v)[:, 0]
        change = np.abs(ahead - firmness)
        regular: np.ndarray = (firmness > 0) & (firmness * PROBE > NEAREST * change)
        return regular
