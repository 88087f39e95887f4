"""A textbook system prepared for checking its facts: states, motions, small motions."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, final

import numpy as np

from mecanique.arrays import Array
from mecanique.errors import IntegrationError
from mecanique.model.mechanism import Mechanism
from mecanique.textbook.facts import State, Values
from mecanique.textbook.system import System
from mecanique.verification.states.random import random_states
from mecanique.verification.stencil import differences

if TYPE_CHECKING:
    from mecanique.derivation.equations import Equations
    from mecanique.reference import Reference


_STEP = 1e-2
"""Step of the differences, relative to coordinates larger than one."""


@final
@dataclass(frozen=True)
class Bench:
    """A system with certain parameters and its equations of motion.

    Args:
        system: of the catalogue, or of your own.
        values: parameters and options that are changed, by symbol.
        source: whose equations of motion are used, "reference" or "derive".
        samples: number of random states.
        seed: of the random states.
    """

    system: System
    values: Mapping[str, float]
    source: str
    samples: int
    seed: int

    @cached_property
    def mechanism(self) -> Mechanism:
        """The system with these parameters."""
        return self.system.mechanism(**self.values)

    @cached_property
    def reference(self) -> Reference:
        """The engine's side of it, loaded once."""
        from mecanique.reference import Reference

        return Reference.of(self.mechanism)

    @cached_property
    def dynamics(self) -> Reference | Equations:
        """The equations of motion that the facts are held against."""
        if self.source == "reference":
            return self.reference
        from mecanique.derivation import derive

        return derive(self.mechanism)

    @cached_property
    def constants(self) -> dict[str, Any]:
        """Numbers of its parameters and options, by symbol."""
        options = {
            name: int(self.values.get(name, number)) for name, number in self.system.options.items()
        }
        return {**self.mechanism.values, **options}

    def numbers(self, q: Any, v: Any, t: Any = 0.0) -> Values:
        """Return constants and state by name, as formulas ask for them."""
        names = (*self.mechanism.coordinates, *self.mechanism.velocities, "t")
        return Values({**self.constants, **dict(zip(names, (*q, *v, t), strict=True))})

    def state(self, given: State) -> tuple[Array, Array]:
        """Return positions and velocities of a state that a fact names."""
        named = given(Values(self.constants)) if callable(given) else given
        positions = {
            name: x for name, x in named.items() if name in set(self.mechanism.coordinates)
        }
        velocities = {name: x for name, x in named.items() if name not in positions}
        if not np.isfinite(list(named.values())).all():
            raise ArithmeticError("its state is not defined")
        return self.close(self.mechanism.position(positions), self.mechanism.velocity(velocities))

    def close(self, q: Array, v: Array) -> tuple[Array, Array]:
        """Return the state next to this one at which the loops are closed."""
        closed = self.reference.closed if self.mechanism.constrained else None
        if closed is None:
            return q, v
        from mecanique.reference.loops.assembly.assembly import project
        from mecanique.reference.loops.assembly.closing import close_position

        return project(closed, close_position(closed, q, 0.0), v, 0.0)

    @cached_property
    def states(self) -> tuple[tuple[Array, Array, float], ...]:
        """The better half of twice as many random states: singular ones lose digits."""
        states = random_states(self.mechanism, 2 * self.samples, self.seed)
        worth = [
            np.linalg.cond(self.dynamics.mass_matrix(q, float(t)))
            for q, t in zip(states.q, states.t, strict=True)
        ]
        better = np.argsort(worth)[: self.samples]
        return tuple((states.q[k], states.v[k], float(states.t[k])) for k in better)

    def aside(self, q: Array, v: Array) -> Array:
        """Return the accelerations also where loops are open, next to where they are closed."""
        closed = self.reference.closed
        if closed is None or self.source != "reference":
            return np.asarray(self.dynamics.acceleration(q, v, 0.0))
        return np.asarray(closed.solve(q, v, 0.0).acceleration)

    def slope(self, t: float, y: Array) -> Array:
        """Return the rates of [q, v]."""
        q, v = y[: self.mechanism.nq], y[self.mechanism.nq :]
        return np.concatenate((self.reference.rates(q, v), self.dynamics.acceleration(q, v, t)))

    def flow(self, q: Array, v: Array, times: Any) -> Array:
        """Return the states [q, v] at the times, shape (n, nq + nv)."""
        from scipy.integrate import solve_ivp

        slope = self.reference.rhs() if self.source == "reference" else self.slope
        found = solve_ivp(
            slope,
            (0.0, float(times[-1])),
            np.concatenate((q, v)),
            method="DOP853",
            t_eval=np.asarray(times, dtype=float),
            rtol=3e-14,
            atol=1e-14,
        )
        if not found.success:
            raise IntegrationError(f"no motion up to t = {times[-1]:g} s: {found.message}")
        return np.asarray(found.y.T)

    def stiffness(self, at: State) -> tuple[Array, Array]:
        """Return M and K of small motion about an equilibrium."""
        q, _ = self.state(at)
        rest = np.zeros(self.mechanism.nv)

        def static_forces(x: Array) -> Array:
            return self.dynamics.bias(x, rest, 0.0) - self.dynamics.forces(x, rest, 0.0)

        K = jacobian(static_forces, q)
        return np.asarray(self.dynamics.mass_matrix(q, 0.0)), K

    def squares(self, at: State) -> Array:
        """Return ω² of small motion about an equilibrium, in order, shape (nv,) [rad²/s²]."""
        found: Array = np.sort(np.linalg.eigvals(np.linalg.solve(*self.stiffness(at))).real)
        return found


def jacobian(function: Callable[[Array], Any], at: Array) -> Array:
    """Return the derivative of a function, shape (m, n)."""
    return differences(
        lambda steps: np.array([function(at + step) for step in steps]),
        len(at),
        _STEP * np.maximum(1.0, np.abs(at)),
    )
