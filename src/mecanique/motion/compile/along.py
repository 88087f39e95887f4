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

from mecanique.arrays import Array, spread
from mecanique.generation.dop853 import (
    ASTRAY,
    CLOSED,
    HALVED,
    NEAREST,
    PROBE,
    ROUNDING,
    SWEEPS,
)
from mecanique.model.constraints.elements import force_names
from mecanique.model.mechanism import Mechanism
from mecanique.model.mechanism_units import velocity_scales
from mecanique.model.states import States
from mecanique.motion.compile.cache import compile_once
from mecanique.motion.compile.program import RatesProgram
from mecanique.motion.compile.python import Batched, vectorize
from mecanique.motion.record.curve import State
from mecanique.motion.record.rates import Rates
from mecanique.motion.tolerances import ACCELERATIONS, IDLE, SUMS

if TYPE_CHECKING:
    from mecanique.program.tape import Value
    from mecanique.reference import Reference
    from mecanique.reference.engine.answers import Wrench


MANY_SUMS, MANY = 2000, 400
"""In so many states a program of sums, or of accelerations and reactions, pays for its writing."""

ASKED = 24
"""At so many states the reference is asked as well."""

Ask: TypeAlias = Callable[[np.ndarray], np.ndarray]
"""Gives the reference's answers in the states with some indices, shape (n, k)."""

BLOCK = 16_384
"""States computed together: their arrays stay in the processor's cache."""


def compute(
    function: Batched, t: np.ndarray, parts: Sequence[np.ndarray], width: int
) -> np.ndarray:
    """Return what a function of arrays writes, shape (n, width), by the parts of n states."""
    out = np.empty((width, len(t)))
    for first in range(0, len(t), BLOCK):
        some = slice(first, first + BLOCK)
        function(t[some], np.concatenate([part[some].T for part in parts]), out[:, some])
    answers: np.ndarray = out.T
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
        with np.errstate(all="ignore"):
            values = compute(function, t, parts, width)
        asked = spread(len(t), ASKED)
        right = self.ask(t[asked], *(part[asked] for part in parts))
        most = SUMS * float(np.abs(right).max(initial=0.0))
        return values if _agrees(values[asked], right, most) else self.ask(t, *parts)

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

    def accelerations(self, t: Array, q: Array, v: Array) -> Array:
        """Return the accelerations, shape (n, nv), by t, shape (n,) [s], q and v."""

        def ask(at: np.ndarray) -> Array:
            states = States.of(self.mechanism, q[at], v[at], t[at])
            return self.reference.quick_accelerations(states)

        return self._answer("", ask, t, q, v)

    def multipliers(self, t: Array, q: Array, v: Array) -> dict[str, Array]:
        """Return the multipliers of the constraints by name, shape (n,); NaN if undetermined.

        States may be off the loops by the tolerance. Where guides alone hold a body against a row,
        nothing presses it there.
        """
        closed = self.reference.closed
        assert closed is not None, "the mechanism is constrained"

        def ask(at: np.ndarray) -> Array:
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

        forces = self._answer("multipliers", ask, t, q, v)
        return dict(zip(closed.closures.names, forces.T, strict=True))

    def guide_forces(self, t: Array, q: Array, v: Array) -> dict[str, Array]:
        """Return the forces of the guiding elements by name, shape (n,); NaN if undetermined."""
        if not self.mechanism.elements:
            return {}

        def ask(at: np.ndarray) -> Array:
            return np.column_stack([*self.reference.guide_forces(q[at], v[at], t[at]).values()])

        forces = self._answer("guides", ask, t, q, v)
        return dict(zip(force_names(self.mechanism.elements), forces.T, strict=True))

    def reactions(self, t: Array, q: Array, v: Array) -> dict[str, Wrench]:
        """Return the reactions of joints, loops and contacts, by name, as `Reference` does."""
        if self._program(len(t), "reactions") is None:
            return self.reference.reactions(q, v, t)
        from mecanique.reference.engine.answers import BodyPoses

        few = spread(len(t), ASKED)
        some = self.reference.reactions(q[few], v[few], t[few])

        def ask(at: np.ndarray) -> Array:
            same = np.array_equal(at, few)
            known = some if same else self.reference.reactions(q[at], v[at], t[at])
            parts = [part for wrench in known.values() for part in (wrench.force, wrench.moment)]
            return np.hstack(parts)

        forces = self._answer("reactions", ask, t, q, v).reshape(len(t), -1, 2, 3)
        places = BodyPoses(partial(self._poses, q, t))
        return {
            name: replace(wrench, force=forces[:, k, 0], moment=forces[:, k, 1], places=places)
            for k, (name, wrench) in enumerate(some.items())
        }

    def close(self, state: State) -> State:
        """Return a state, or states over time, with the loops closed to rounding."""
        from mecanique.reference.loops.assembly import project

        closed = self.reference.closed
        assert closed is not None, "the mechanism is constrained"

        def ask(at: np.ndarray, q: Array, v: Array) -> Array:
            states = zip(q[at], v[at], t[at].tolist(), strict=True)
            rows = [project(closed, *state, drifted=True) for state in states]
            return np.array([np.concatenate(row) for row in rows])

        t, q, v = np.atleast_1d(state.t), np.atleast_2d(state.q), np.atleast_2d(state.v)
        near_q, near_v, landed = self._land(t, q, v)
        asked = spread(len(t), ASKED)
        asked = asked[landed[asked]]
        if len(asked):
            most = CLOSED * max(1.0, float(np.abs(near_q).max()))
            again = ask(asked, near_q, near_v)[:, : self.mechanism.nq]
            landed &= _agrees(near_q[asked], again, most)
        if not landed.all():
            left = np.flatnonzero(~landed)
            near_q[left], near_v[left] = np.hsplit(ask(left, q, v), [self.mechanism.nq])
        return (
            State(state.t, near_q, near_v)
            if np.ndim(state.t)
            else State(state.t, near_q[0], near_v[0])
        )

    def _land(self, t: Array, q: Array, v: Array) -> tuple[Array, Array, np.ndarray]:
        """Return the states on the loops near some, by a program; whether it did it, shape (n,)."""
        q, v, closed = q.copy(), v.copy(), np.zeros(len(t), dtype=bool)
        program = self._program(len(t), "")
        if program is None or program.landing is None:
            return q, v, closed
        changes = program.landing.changes
        with np.errstate(all="ignore"):
            rates = self._compute(program, program.rates, t, q, v)
            some = np.flatnonzero(self._is_regular(program, rates, t, q, v))

            def change(at: np.ndarray, q: Array, v: Array) -> Array:
                return self._compute(program, changes, t[some[at]], q, v)

            normal = Rates.of(self.mechanism).normalize(q[some])
            there_q, there_v, landed = land(change, normal, v[some])
        there = some[landed]
        q[there], v[there], closed[there] = there_q[landed], there_v[landed], True
        return q, v, closed

    def _poses(self, q: Array, t: Array) -> dict[str, Array]:
        names = [body.name for body in self.mechanism.bodies]
        return dict(zip(names, np.moveaxis(self.reference.poses(q, t), 1, 0), strict=True))

    def _program(self, count: int, forces: str) -> RatesProgram | None:
        """Return the program of so many states, if it pays and there is one."""
        code = compile_once(self.mechanism)
        pays = count >= (2 * ASKED if code.knows(forces) else MANY)
        return code.along(forces) if pays and not _is_blind(self.mechanism) else None

    def _answer(self, forces: str, ask: Ask, *state: Array) -> Array:
        """Return the rates of v, or forces, by a program; by the reference where it is unsure."""
        everywhere, first = np.arange(len(state[0])), self.mechanism.nq
        program = self._program(len(everywhere), forces)
        if program is None:
            return ask(everywhere)
        with np.errstate(all="ignore"):
            answers = self._compute(program, program.rates, *state)
            sure = np.isfinite(answers).all(axis=1) & self._is_regular(program, answers, *state)
        asked = spread(len(everywhere), ASKED)
        result: Array = answers[:, first + self.mechanism.nv if forces else first :]
        if sure[asked].any():
            right = ask(asked)
            unknown = np.isnan(right).all(axis=0)
            result[:, unknown], right[:, unknown] = np.nan, 0.0
            most = ACCELERATIONS * (1.0 + np.abs(right).max(initial=0.0))
            kept = sure[asked]
            if not _agrees(np.where(unknown, 0.0, result[asked][kept]), right[kept], most):
                sure[:] = False
        if not sure.all():
            result[~sure] = ask(np.flatnonzero(~sure))
        return result

    def _compute(self, program: RatesProgram, values: tuple[Value, ...], *state: Array) -> Array:
        """Return values on a program's tape, shape (n, values)."""
        known, key = compile_once(self.mechanism).functions, (id(program.tape), values)
        if key not in known:
            known[key] = vectorize(replace(program, rates=values))
        return compute(known[key], state[0], state[1:], len(values))

    def _is_regular(
        self, program: RatesProgram, rates: Array, t: Array, q: Array, v: Array
    ) -> np.ndarray:
        """Whether no singular position of the loops is near, to first order along the motion."""
        if program.landing is None:
            return np.ones(len(t), dtype=bool)
        measure = (program.landing.firmness,)
        firmness = self._compute(program, measure, t, q, v)[:, 0]
        speed = np.abs(v / velocity_scales(self.mechanism)).max(axis=1)
        step = np.where(speed > 0, PROBE / speed, 0.0)[:, None]
        there = q + step * rates[:, : self.mechanism.nq]
        change = np.abs(self._compute(program, measure, t, there, v)[:, 0] - firmness)
        regular: np.ndarray = (firmness > 0) & (firmness * PROBE > NEAREST * change)
        return regular


def _agrees(quick: Array, right: Array, most: float) -> bool:
    """Return whether all numbers are within `most` of the right ones; one that is NaN is not."""
    return bool(np.abs(quick - right).max(initial=0.0) <= most)


def land(
    change: Callable[[np.ndarray, np.ndarray, np.ndarray], np.ndarray], q: np.ndarray, v: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the states on the loops near some, (n, nq) and (n, nv), and which landed there.

    `change` gives the first-order changes, shape (k, nq + nv), of states by their indices, q and v.
    """
    q, v = q.copy(), v.copy()
    last, landed, open_ = np.full(len(q), ASTRAY), np.zeros(len(q), dtype=bool), np.arange(len(q))
    for _ in range(SWEEPS):
        of_q, of_v = np.hsplit(change(open_, q[open_], v[open_]), [q.shape[1]])
        size = np.abs(of_q).max(axis=1)
        most = np.maximum(1.0, np.abs(q[open_]).max(axis=1))
        goes_on = (size > ROUNDING * most) & (size <= HALVED * last[open_])
        # where rounding is left, the velocities suit the positions as they are
        ended = open_[~goes_on]
        v[ended] += of_v[~goes_on]
        landed[ended] = (size <= CLOSED * most)[~goes_on]
        last[open_], open_ = size, open_[goes_on]
        if not len(open_):
            break
        q[open_] += of_q[goes_on]
    return q, v, landed
