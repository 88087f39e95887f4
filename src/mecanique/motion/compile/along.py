"""Quantities in many states of a motion at once, by programs that the reference agrees with.

The engine answers one state at a time, each with Python's cost; a program answers as many as a
motion has samples in about the time that the motion took. The reference has to agree with it at
states of this motion, and it answers alone where a singular position of the loops is near.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import TYPE_CHECKING, TypeAlias, final

import numpy as np

from mecanique.arrays import Array
from mecanique.generation.dop853 import NEAREST, PROBE
from mecanique.model.constraints.elements import force_names
from mecanique.model.mechanism import Mechanism
from mecanique.model.mechanism_units import velocity_scales
from mecanique.model.states import States
from mecanique.motion.compile.cache import compile_once
from mecanique.motion.compile.program import RatesProgram
from mecanique.motion.compile.python import Batched, vectorize
from mecanique.motion.record.spot_check import ASKED, agrees, spot_check, spread
from mecanique.motion.tolerances import ACCELERATIONS, IDLE

if TYPE_CHECKING:
    from mecanique.program.tape import Value
    from mecanique.reference import Reference
    from mecanique.reference.engine.answers import Wrench


MANY_SUMS, MANY = 2000, 400
"""In so many states a program of sums, or of accelerations and reactions, pays for its writing."""

Ask: TypeAlias = Callable[[np.ndarray], np.ndarray]
"""Gives the reference's answers in the states with some indices, shape (n, k)."""

BLOCK = 16_384
"""States computed together: their arrays stay in the processor's cache."""


def compute(
    function: Batched, t: np.ndarray, parts: Sequence[np.ndarray], width: int
) -> np.ndarray:
    """Return what a function of arrays writes, shape (n, width), by the parts of n states."""
    answers = np.empty((len(t), width))
    for first in range(0, len(t), BLOCK):
        some = slice(first, first + BLOCK)
        out = np.empty((width, len(t[some])))
        function(t[some], np.concatenate([part[some].T for part in parts]), out)
        answers[some] = out.T
    return answers


def _is_blind(mechanism: Mechanism) -> bool:
    """Return whether an input is a function, which need not take arrays."""
    return any(callable(signal.signal) for signal in mechanism.inputs)


@final
@dataclass(frozen=True)
class StateSums:
    """Sums over bodies or forces in many states: by a program, where these are many."""

    mechanism: Mechanism
    write: Callable[[Mechanism], RatesProgram]
    # gives the same by t, q, v and, if the program takes them, accelerations, shape (n, k)
    ask: Callable[..., np.ndarray]

    def __call__(self, t: np.ndarray, *parts: np.ndarray) -> np.ndarray:
        """Return the sums, shape (n, k)."""
        if len(t) < MANY_SUMS or _is_blind(self.mechanism):
            return self.ask(t, *parts)

        function, width = self._function
        return spot_check(
            lambda: compute(function, t, parts, width),
            lambda at: self.ask(t[at], *(part[at] for part in parts)),
            len(t),
        )

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

        return self._answer(self._program(len(t)), self.mechanism.nq, ask, t, q, v)

    def multipliers(self, t: np.ndarray, q: np.ndarray, v: np.ndarray) -> dict[str, Array]:
        """Return the multipliers of the constraints by name, shape (n,); NaN if undetermined.

        States may be off the loops by the tolerance. Where guides alone hold a body against a row,
        nothing presses it there.
        """
        closed = self.reference.closed
        assert closed is not None, "the mechanism is constrained"

        def ask(at: np.ndarray) -> np.ndarray:
            forces = np.empty((len(at), len(closed.closures.names)))
            for known, k in zip(forces, at.tolist(), strict=True):
                state = q[k], v[k], float(t[k])
                solved = closed.solve(*state)
                known[:] = solved.multipliers
                if not solved.determined.all():
                    jacobian = closed.closures.at(*state).jacobian
                    units = closed.measure(jacobian).units
                    idle = np.abs(units.rows[:, None] * jacobian * units.columns).max(axis=1) < IDLE
                    known[~(solved.determined | idle)] = np.nan
            return forces

        program = self._program(len(t), "multipliers")
        forces = self._answer(program, self.mechanism.nq + self.mechanism.nv, ask, t, q, v)
        return dict(zip(closed.closures.names, forces.T, strict=True))

    def guide_forces(self, t: np.ndarray, q: np.ndarray, v: np.ndarray) -> dict[str, Array]:
        """Return the forces of the guiding elements by name, shape (n,); NaN if undetermined."""
        if not self.mechanism.elements:
            return {}

        def ask(at: np.ndarray) -> np.ndarray:
            return np.column_stack([*self.reference.guide_forces(q[at], v[at], t[at]).values()])

        program = self._program(len(t), "guides")
        forces = self._answer(program, self.mechanism.nq + self.mechanism.nv, ask, t, q, v)
        return dict(zip(force_names(self.mechanism.elements), forces.T, strict=True))

    def reactions(self, t: np.ndarray, q: np.ndarray, v: np.ndarray) -> dict[str, Wrench]:
        """Return the reactions of joints, loops and contacts, by name, as `Reference` does."""
        program = self._program(len(t), "reactions")
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

    def _program(self, count: int, forces: str = "") -> RatesProgram | None:
        """Return the program of so many states, if it pays and there is one."""
        code = compile_once(self.mechanism)
        pays = count >= (2 * ASKED if code.knows(forces) else MANY)
        return code.along(forces) if pays and not _is_blind(self.mechanism) else None

    def _compute(
        self,
        program: RatesProgram,
        rates: tuple[Value, ...],
        t: np.ndarray,
        q: np.ndarray,
        v: np.ndarray,
    ) -> np.ndarray:
        """Return values on a program's tape, shape (n, rates)."""
        known, key = compile_once(self.mechanism).functions, (id(program.tape), rates)
        if key not in known:
            known[key] = vectorize(replace(program, rates=rates))
        return compute(known[key], t, (q, v), len(rates))

    def _answer(
        self,
        program: RatesProgram | None,
        first: int,
        ask: Ask,
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
        result: np.ndarray = answers[:, first:]
        if sure[asked].any():
            right = ask(asked)
            unknown = np.isnan(right).all(axis=0)
            result[:, unknown], right[:, unknown] = np.nan, 0.0
            most = ACCELERATIONS * (1.0 + np.abs(right).max(initial=0.0))
            kept = sure[asked]
            if not agrees(np.where(unknown, 0.0, result[asked][kept]), right[kept], most):
                sure[:] = False
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
