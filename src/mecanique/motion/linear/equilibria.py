"""All equilibria of a mechanism that random or given starts lead to."""

from __future__ import annotations

from collections.abc import Iterable
from contextlib import suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING, final

import numpy as np

from mecanique.errors import EngineError, InputError
from mecanique.model.expression import finite
from mecanique.model.mechanism import Mechanism
from mecanique.model.random_positions import draw_positions
from mecanique.model.units import units
from mecanique.motion.linear.equilibrium import equilibrium_near
from mecanique.motion.linear.linearization import Linearization
from mecanique.motion.linear.linearize import linearize
from mecanique.motion.simulation.arguments import Values
from mecanique.threads import one_thread_for_loops

if TYPE_CHECKING:
    from mecanique.reference import Reference

__all__ = ["Equilibrium", "equilibria"]

_REACH = 1.0
"""Lengths of random starts lie within this of zero [m]."""

SAME = 1e-6
"""Positions closer than this are one equilibrium."""


@final
@dataclass(frozen=True, eq=False)
class Equilibrium:
    """A position in which a mechanism can rest.

    Args:
        q: shape (nq,), the position.
        linearization: small motions about it.
    """

    q: np.ndarray
    linearization: Linearization

    @property
    def stable(self) -> bool:
        """Whether no small deviation grows exponentially."""
        return self.linearization.stable

    def __str__(self) -> str:
        return str(self.linearization)


@one_thread_for_loops
def equilibria(
    mechanism: Mechanism,
    starts: int | Iterable[Values] = 50,
    *,
    t: float = 0.0,
    seed: int = 0,
    reference: Reference | None = None,
) -> tuple[Equilibrium, ...]:
    """Return the equilibria that Newton's method finds, in the order of their potential energy.

    Angles that differ by whole turns are one position; they are brought to −π…π where the forces
    are the same there. Of equilibria that a motion without any resistance joins, e.g. a cart
    anywhere on its track, one is returned.

    Args:
        mechanism: what may rest.
        starts: positions to start from, or how many random ones besides the neutral position.
        t: time at which forces are taken [s].
        seed: of the random starts: angles in −π…π, lengths in −1…1 m.
        reference: the mechanism's `Reference`, if you have one already.

    Raises:
        InputError: if a start is not what is expected.
        UnknownNameError: if a coordinate does not exist.
    """
    t = finite(t, "the time t")
    if reference is None:
        from mecanique.reference import Reference

        reference = Reference.of(mechanism)
    if isinstance(starts, int):
        if starts < 0:
            raise InputError(f"expected a number of starts of at least 0, got {starts}")
        drawn = draw_positions(mechanism, starts, np.random.default_rng(seed), _REACH)
        positions = [mechanism.neutral(), *drawn]
    else:
        positions = [mechanism.position(start) for start in starts]
    turning = [k for k, name in enumerate(mechanism.coordinates) if units(mechanism)[name] == "rad"]
    found: list[Equilibrium] = []
    for start in positions:
        q = equilibrium_near(reference, start, t)
        if q is None:
            continue
        q = _unwind(reference, q, turning, t)
        if not any(_same(q, other, turning) for other in found):
            # where the axes of a gimbal fall in line the mass matrix has no inverse, and next to a
            # singular position the loops leave no small motion
            with suppress(EngineError, InputError):
                found.append(Equilibrium(q, linearize(mechanism, q, t=t, reference=reference)))
    return tuple(sorted(found, key=lambda e: float(reference.energy(e.q, None, t).potential)))


def _unwind(reference: Reference, q: np.ndarray, turning: list[int], t: float) -> np.ndarray:
    """Bring angles to −π…π if the forces are the same there; with a torsion spring they are not."""
    if not turning:
        return q
    wound = q.copy()
    wound[turning] = (wound[turning] + np.pi - 1e-9) % (2 * np.pi) - np.pi + 1e-9
    still = np.zeros(reference.mechanism.nv)
    before, after = (reference.inverse_dynamics(x, still, still, t) for x in (q, wound))
    same = np.abs(before - after).max(initial=0.0) < 1e-8 * (1 + np.abs(before).max())
    return wound if same else q


def _same(q: np.ndarray, other: Equilibrium, turning: list[int]) -> bool:
    gap = q - other.q
    gap[turning] = (gap[turning] + np.pi) % (2 * np.pi) - np.pi
    K = other.linearization.K
    if len(gap) == len(K) > 0:
        _, resistance, directions = np.linalg.svd(K)
        free = directions[resistance <= 1e-9 * resistance.max(initial=0.0)]
        gap = gap - free.T @ (free @ gap)
    return bool(np.abs(gap).max(initial=0.0) < SAME)
