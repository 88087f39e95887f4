"""Find the equilibria of a mechanism that Newton's method reaches from many starts."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING, final

import numpy as np

from mecanique.errors import EngineError, InputError, MecaniqueError
from mecanique.model.expression import finite
from mecanique.model.mechanism import Mechanism
from mecanique.model.mechanism_units import units
from mecanique.model.random_positions import draw_positions
from mecanique.model.values import whole
from mecanique.motion.linear.differences import linearize_about
from mecanique.motion.linear.equilibrium import equilibrium_near
from mecanique.motion.linear.linearization import Linearization
from mecanique.motion.simulation.problem import Values
from mecanique.motion.tolerances import IN_LINE, SAME_FORCES, SAME_PLACE, TURN, UNRESISTED
from mecanique.threads import one_thread_for_loops
from mecanique.wording import Legible

if TYPE_CHECKING:
    from mecanique.reference import Reference


_REACH = 1.0
"""Lengths of random starts lie within this of zero [m]."""

MOST_STARTS = 1_000_000
"""Random starts that may be asked for: hours of work."""


@final
@dataclass(frozen=True, eq=False, repr=False)
class Equilibrium(Legible):
    """A position in which a mechanism can rest.

    Args:
        q: shape (nq,), the position.
        linearization: small motions about it.

    Example:
        >>> down, up = mq.equilibria(mq.textbook.load("rigid_bar_pendulum"))
        >>> down.stable, up.stable
        (True, False)
        >>> down.linearization.frequencies.round(3)
        array([3.836])
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

    Returns:
        One for each position found.

    Raises:
        InputError: if a start is not what is expected, or the loops lock the mechanism in a
            singular position.
        UnknownNameError: if a coordinate does not exist.
        ClosureError: if the loops cannot be closed at all.

    Example:
        >>> [each.stable for each in mq.equilibria(mq.textbook.load('rigid_bar_pendulum'))]
        [True, False]
    """
    t = finite(t, "the time t")
    if reference is None:
        from mecanique.reference import Reference

        reference = Reference.of(mechanism)
    if reference.closed is not None:
        from mecanique.reference.loops.freedom import refuse_locked

        refuse_locked(reference.closed, t)
    if isinstance(starts, int):
        count = whole(starts, "the number of starts", 0, MOST_STARTS)
        positions = random_starts(mechanism, count, seed)
    else:
        positions = [mechanism.position(start) for start in starts]
    search = Found(reference, positions, t)
    for start in positions:
        search.add(start)
    return search.sorted


@final
class Found:
    """The equilibria that starts, shape (nq,) each, have led to so far."""

    def __init__(self, reference: Reference, starts: Sequence[np.ndarray], t: float) -> None:
        self.equilibria: list[Equilibrium] = []
        self.refused: list[MecaniqueError] = []
        """Why positions of rest cannot be linearized about."""
        self._reference, self._t = reference, t
        mechanism = reference.mechanism
        unit = units(mechanism)
        self._turning = [k for k, name in enumerate(mechanism.coordinates) if unit[name] == "rad"]
        self._scales, self._least = _usual_inertia(reference, starts, t)

    @property
    def sorted(self) -> tuple[Equilibrium, ...]:
        """The equilibria in the order of their potential energy."""
        energy = self._reference.energy
        return tuple(
            sorted(self.equilibria, key=lambda e: float(energy(e.q, None, self._t).potential))
        )

    def add(self, start: np.ndarray) -> None:
        """Add the equilibrium that a start leads to, if it leads to one that is not there yet."""
        q = equilibrium_near(self._reference, start, self._t)
        if q is None:
            return
        q = _unwind(self._reference, q, self._turning, self._t)
        if any(_same(q, equilibrium, self._turning) for equilibrium in self.equilibria):
            return
        # where the axes of a gimbal fall in line the mass matrix has no inverse, and next to a
        # singular position the loops leave no small motion
        try:
            self._refuse_singular(q)
            linearization = linearize_about(self._reference, q, t=self._t)
        except (EngineError, InputError) as error:
            self.refused.append(error)
        else:
            self.equilibria.append(Equilibrium(q, linearization))

    def _refuse_singular(self, q: np.ndarray) -> None:
        mechanism = self._reference.mechanism
        if mechanism.constrained or not mechanism.nv:
            return
        mass = self._reference.mass_matrix(q, self._t)
        values, motions = np.linalg.eigh(mass / np.outer(self._scales, self._scales))
        if values[0] <= IN_LINE * self._least:
            still = np.abs(motions[:, 0])
            names = [
                name
                for name, part in zip(mechanism.velocities, still, strict=True)
                if part > 0.1 * still.max()
            ]
            place = ", ".join(
                f"{name} = {round(x, 6) + 0.0:.6g}"
                for name, x in zip(mechanism.coordinates, q, strict=True)
            )
            raise InputError(f"a motion of {', '.join(names)} moves no mass at {place}")


def _usual_inertia(
    reference: Reference, positions: Sequence[np.ndarray], t: float
) -> tuple[np.ndarray, float]:
    """Return √M_ii at its largest, shape (nv,), and the largest least eigenvalue of M so scaled."""
    nv = reference.mechanism.nv
    masses: list[np.ndarray] = [np.zeros((nv, nv))]
    for position in positions:
        with suppress(MecaniqueError):
            masses.append(reference.mass_matrix(position, t))
    largest = np.max([np.diagonal(mass) for mass in masses], axis=0)
    scales = np.sqrt(np.where(largest > 0, largest, 1.0))
    scaled = np.array(masses) / np.outer(scales, scales)
    return scales, float(np.linalg.eigvalsh(scaled)[:, 0].max()) if nv else 0.0


def random_starts(mechanism: Mechanism, count: int, seed: int) -> list[np.ndarray]:
    """Return the neutral position and random ones: angles in −π…π, lengths in −1…1 m."""
    drawn = draw_positions(mechanism, count, np.random.default_rng(seed), _REACH)
    return [mechanism.neutral(), *drawn]


def _unwind(reference: Reference, q: np.ndarray, turning: list[int], t: float) -> np.ndarray:
    """Bring angles to −π…π if the forces are the same there; with a torsion spring they are not."""
    if not turning:
        return q
    wound = q.copy()
    wound[turning] = (wound[turning] + np.pi - TURN) % (2 * np.pi) - np.pi + TURN
    still = np.zeros(reference.mechanism.nv)
    before, after = (reference.inverse_dynamics(x, still, still, t) for x in (q, wound))
    same = np.abs(before - after).max(initial=0.0) < SAME_FORCES * (1 + np.abs(before).max())
    return wound if same else q


def _same(q: np.ndarray, equilibrium: Equilibrium, turning: list[int]) -> bool:
    gap = q - equilibrium.q
    gap[turning] = (gap[turning] + np.pi) % (2 * np.pi) - np.pi
    K, tangent = equilibrium.linearization.K, equilibrium.linearization.tangent
    if len(gap) == len(tangent) and len(K):
        # along these directions nothing resists: it is one equilibrium, anywhere
        _, resistance, directions = np.linalg.svd(K)
        idle = tangent @ directions[resistance <= UNRESISTED * resistance.max(initial=0.0)].T
        free = np.linalg.qr(idle)[0]
        gap = gap - free @ (free.T @ gap)
    return bool(np.abs(gap).max(initial=0.0) < SAME_PLACE)
