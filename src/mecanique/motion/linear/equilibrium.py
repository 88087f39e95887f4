"""Where a mechanism can rest."""

from __future__ import annotations

from collections.abc import Iterable
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, final

import numpy as np

from mecanique.errors import EngineError, InputError, MecaniqueError
from mecanique.model.expression import finite
from mecanique.model.mechanism import Mechanism
from mecanique.model.units import units
from mecanique.motion.linear.linearization import Linearization
from mecanique.motion.linear.linearize import Held, linearize
from mecanique.motion.record.rates import Rates
from mecanique.motion.simulation.arguments import Values

__all__ = ["Equilibrium", "equilibria", "equilibrium_near"]

STEPS = 100
"""Most Newton steps from a start."""

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


def equilibria(
    mechanism: Mechanism,
    starts: int | Iterable[Values] = 50,
    *,
    t: float = 0.0,
    seed: int = 0,
    reference: Any = None,
) -> tuple[Equilibrium, ...]:
    """Return the equilibria that Newton's method finds from starts, those with the lowest potential energy first.

    Angles that differ by whole turns are one position; they are brought to −π…π where the forces
    are the same there. Of equilibria that a motion without any resistance joins, e.g. a cart
    anywhere on its track, one is returned.

    Args:
        mechanism: what may rest.
        starts: positions to start from, or how many random ones besides the neutral position.
        t: time at which forces are taken [s].
        seed: of the random starts: angles in −π…π, lengths in −1…1 m.
        reference: the mechanism's `Reference`, if it is there already.

    Raises:
        InputError: if a start is not what is expected.
        UnknownNameError: if a coordinate does not exist.
    """
    t = finite(t, "the time t")
    if reference is None:
        from mecanique.reference import Reference

        reference = Reference(mechanism)
    if isinstance(starts, int):
        if starts < 0:
            raise InputError(f"expected a number of starts of at least 0, got {starts}")
        positions = _random_starts(mechanism, starts, seed)
    else:
        positions = [mechanism.position(start) for start in starts]
    turning = [k for k, name in enumerate(mechanism.coordinates) if units(mechanism)[name] == "rad"]
    found: list[Equilibrium] = []
    for start in positions:
        q = equilibrium_near(mechanism, start, t, reference)
        if q is None:
            continue
        q = _unwound(mechanism, q, turning, t, reference)
        if not any(_same(q, other, turning) for other in found):
            with suppress(
                EngineError
            ):  # where the axes of a gimbal fall in line a mass matrix has no inverse
                found.append(Equilibrium(q, linearize(mechanism, q, t=t, reference=reference)))
    return tuple(sorted(found, key=lambda e: float(reference.energy(e.q, None, t).potential)))


def equilibrium_near(
    mechanism: Mechanism, start: np.ndarray, t: float, reference: Any
) -> np.ndarray | None:
    """Return the position without acceleration that Newton's method reaches, or None.

    Args:
        mechanism: what may rest.
        start: shape (nq,).
        t: time [s].
        reference: the mechanism's `Reference`.
    """
    rates = Rates.of(mechanism)
    nv = mechanism.nv
    if not nv:
        return start
    if mechanism.loops:
        return _near_on_loops(mechanism, start, t, reference)
    q = rates.normalized(np.array(start, dtype=float))
    h = 1e-6

    def residual(many: np.ndarray) -> np.ndarray:
        still = np.zeros((len(many), nv))
        value: np.ndarray = reference.inverse_dynamics(many, still, still, t)
        return value

    try:
        value = residual(q[None])[0]
        for _ in range(STEPS):
            ahead = np.vstack([np.eye(nv), -np.eye(nv)]) * h
            rise = residual(rates.moved(np.repeat(q[None], 2 * nv, axis=0), ahead))
            slope = ((rise[:nv] - rise[nv:]) / (2 * h)).T
            size = float(np.abs(value).max(initial=0.0))
            step = -np.linalg.lstsq(slope, value, rcond=1e-10)[0]
            step *= min(1.0, 1.0 / max(float(np.abs(step).max(initial=0.0)), 1e-300))
            for _ in range(20):  # a step that does not help is halved
                trial = rates.normalized(rates.moved(q, step))
                new = residual(trial[None])[0]
                if np.abs(new).max(initial=0.0) <= size:
                    break
                step = step / 2
            else:
                break
            moved = float(np.abs(step).max(initial=0.0))
            q, value = trial, new
            if moved < 1e-14:
                break
        scale = float(np.abs(reference.mass_matrix(q, t)).max(initial=0.0)) * _gravity(
            mechanism
        ) + float(np.abs(slope).max(initial=0.0))
    except MecaniqueError:  # e.g. a spring of no length on the way
        return None
    return q if float(np.abs(value).max(initial=0.0)) <= 1e-10 * scale + 1e-14 else None


def _near_on_loops(
    mechanism: Mechanism, start: np.ndarray, t: float, reference: Any
) -> np.ndarray | None:
    """The same for a mechanism with loops: Newton's method in the deviations that the loops leave free."""
    from mecanique.reference.loops.assembly import closed_position

    rates, h = Rates.of(mechanism), 1e-6
    still = np.zeros(mechanism.nv)
    try:
        q = closed_position(reference.closed, rates.normalized(np.array(start, dtype=float)), t)
        scale, size = 1.0, np.inf
        for _ in range(STEPS):
            held = Held(reference, q, t)
            none = np.zeros(held.tangent.shape[1])
            steps = np.vstack([none, np.eye(len(none)) * h, np.eye(len(none)) * -h])
            along = np.array([held.residual(held.near(step), none, none) for step in steps])
            slope = ((along[1 : len(none) + 1] - along[len(none) + 1 :]) / (2 * h)).T
            size = float(np.abs(along[0]).max(initial=0.0))
            weight = reference.inverse_dynamics(q, still, still, t)
            scale = float(np.abs(slope).max(initial=0.0)) + float(np.abs(weight).max(initial=0.0))
            step = -np.linalg.lstsq(slope, along[0], rcond=1e-10)[0]
            step *= min(1.0, 0.5 / max(float(np.abs(step).max(initial=0.0)), 1e-300))
            if float(np.abs(step).max(initial=0.0)) < 1e-12:
                break
            q = closed_position(reference.closed, rates.moved(q, held.tangent @ step), t)
    except MecaniqueError:  # e.g. loops that cannot be closed on the way
        return None
    return q if size <= 1e-9 * scale + 1e-14 else None


def _gravity(mechanism: Mechanism) -> float:
    return float(np.linalg.norm([mechanism.evaluate(g) for g in mechanism.gravity]))


def _random_starts(mechanism: Mechanism, count: int, seed: int) -> list[np.ndarray]:
    rng = np.random.default_rng(seed)
    unit = units(mechanism)
    reach = np.array([np.pi if unit[name] == "rad" else 1.0 for name in mechanism.coordinates])
    rates = Rates.of(mechanism)
    neutral = mechanism.neutral()
    return [
        neutral,
        *(rates.normalized(neutral * 0.1 + rng.uniform(-reach, reach)) for _ in range(count)),
    ]


def _unwound(
    mechanism: Mechanism, q: np.ndarray, turning: list[int], t: float, reference: Any
) -> np.ndarray:
    """Bring angles to −π…π if that leaves the position an equilibrium (it does not with a torsion spring)."""
    if not turning:
        return q
    wound = q.copy()
    wound[turning] = (wound[turning] + np.pi - 1e-9) % (2 * np.pi) - np.pi + 1e-9
    still = np.zeros(mechanism.nv)
    forces = [reference.inverse_dynamics(x, still, still, t) for x in (q, wound)]
    return (
        wound
        if np.abs(forces[0] - forces[1]).max(initial=0.0) < 1e-8 * (1 + np.abs(forces[0]).max())
        else q
    )


def _same(q: np.ndarray, other: Equilibrium, turning: list[int]) -> bool:
    gap = q - other.q
    gap[turning] = (gap[turning] + np.pi) % (2 * np.pi) - np.pi
    K = other.linearization.K
    if len(gap) == len(K) > 0:
        _, resistance, directions = np.linalg.svd(K)
        free = directions[resistance <= 1e-9 * resistance.max(initial=0.0)]
        gap = gap - free.T @ (free @ gap)
    return bool(np.abs(gap).max(initial=0.0) < SAME)
