"""Rates of the coordinates and generalized velocities, and quaternions of unit length, in batches.

They differ only where a joint's position is a unit quaternion (`Spherical`, `Floating`): there the
velocities are components in the child's axes. Quaternions are (x, y, z, w).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from types import EllipsisType
from typing import TypeAlias, final

import numpy as np

from mecanique.model.mechanism import Mechanism
from mecanique.model.quaternions import conjugate, multiply, pure, turn

_Columns: TypeAlias = tuple[EllipsisType, slice]
"""Some columns of an array of states."""


@final
@dataclass(frozen=True)
class Rates:
    """The maps between v and q̇ of a mechanism."""

    # pairs of indices (in q, in v) of the coordinates whose rate is their velocity
    plain: tuple[tuple[int, ...], tuple[int, ...]]
    # first index of each quaternion in q and of its angular velocity in v
    balls: tuple[tuple[int, int], ...]
    # first index of each free body's position in q and of its velocity in v; its quaternion
    # follows
    free: tuple[tuple[int, int], ...]

    @classmethod
    def of(cls, mechanism: Mechanism) -> Rates:
        """Return the maps of a mechanism."""
        names, velocities = mechanism.coordinates.names, mechanism.velocities
        balls: list[tuple[int, int]] = []
        free: list[tuple[int, int]] = []
        inside: set[str] = set()
        for joint in mechanism.joints:
            if joint.quaternion:
                inside.update(joint.coordinates)
                i = names.index(joint.coordinates[0])
                k = velocities.index(joint.velocities[0])
                if joint.linear_coordinates:
                    free.append((i, k))
                    i, k = i + 3, k + 3
                balls.append((i, k))
        plain_names = [name for name in names if name not in inside]
        in_q = tuple(names.index(name) for name in plain_names)
        in_v = tuple(velocities.index(f"{name}'") for name in plain_names)
        return cls((in_q, in_v), tuple(balls), tuple(free))

    @cached_property
    def _turning(self) -> tuple[tuple[_Columns, _Columns], ...]:
        """Columns of each quaternion in q and of its angular velocity in v."""
        return tuple((np.s_[..., i : i + 4], np.s_[..., k : k + 3]) for i, k in self.balls)

    @cached_property
    def _moving(self) -> tuple[tuple[_Columns, _Columns, _Columns, _Columns], ...]:
        """Columns of each free body: position and quaternion in q; velocity and spin in v."""
        return tuple(
            (
                np.s_[..., i : i + 3],
                np.s_[..., i + 3 : i + 7],
                np.s_[..., k : k + 3],
                np.s_[..., k + 3 : k + 6],
            )
            for i, k in self.free
        )

    @property
    def trivial(self) -> bool:
        """Whether v is q̇."""
        return not self.balls and self.plain[0] == self.plain[1]

    def normalize(self, q: np.ndarray) -> np.ndarray:
        """Return positions, shape (…, nq), with every quaternion of unit length."""
        if not self.balls:
            return q
        q = q.copy()
        for Q, _ in self._turning:
            q[Q] /= np.linalg.norm(q[Q], axis=-1, keepdims=True)
        return q

    def drift(self, q: np.ndarray) -> float:
        """Return by how much the length of a quaternion differs from one, at most."""
        lengths = (np.linalg.norm(q[Q], axis=-1) for Q, _ in self._turning)
        return max((float(np.abs(length - 1).max()) for length in lengths), default=0.0)

    def first(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Return q̇; of a quaternion Q̇ = ½ Q ω (Shuster, J. Astronaut. Sci. 41 (1993) 439)."""
        if self.trivial:
            return v
        rate = np.zeros_like(q)
        rate[..., self.plain[0]] = v[..., self.plain[1]]
        for Q, spin in self._turning:
            rate[Q] = 0.5 * multiply(q[Q], pure(v[spin]))
        for p, Q, velocity, _ in self._moving:
            rate[p] = turn(q[Q], v[velocity])
        return rate

    def second(self, q: np.ndarray, v: np.ndarray, a: np.ndarray) -> np.ndarray:
        """Return q̈, shape (…, nq), from a, the rates of v."""
        if self.trivial:
            return a
        rate = np.zeros_like(q)
        rate[..., self.plain[0]] = a[..., self.plain[1]]
        for Q, spin in self._turning:
            omega = pure(v[spin])
            turning = multiply(multiply(q[Q], omega), omega)
            rate[Q] = 0.5 * multiply(q[Q], pure(a[spin])) + 0.25 * turning
        for p, Q, velocity, spin in self._moving:
            carried = np.cross(v[spin], v[velocity])
            rate[p] = turn(q[Q], a[velocity] + carried)
        return rate

    def displace(self, q: np.ndarray, step: np.ndarray) -> np.ndarray:
        """Return positions after a small step (…, nv) along velocities: q + step where v is q̇."""
        if self.trivial:
            shifted: np.ndarray = q + step
            return shifted
        moved = q + np.zeros((*step.shape[:-1], 1))
        moved[..., self.plain[0]] += step[..., self.plain[1]]
        for p, Q, velocity, _ in self._moving:
            moved[p] += turn(q[Q], step[velocity])
        for Q, spin in self._turning:
            half = step[spin] / 2
            angle = np.linalg.norm(half, axis=-1, keepdims=True)
            along = half * np.sinc(angle / np.pi)  # numpy's sinc x is sin πx / πx
            change = np.concatenate([along, np.cos(angle)], axis=-1)
            moved[Q] = multiply(q[Q], change)
        return moved

    def between(self, start: np.ndarray, end: np.ndarray) -> np.ndarray:
        """Return the step along velocities (…, nv) that leads from a position to another."""
        if self.trivial:
            apart: np.ndarray = end - start
            return apart
        step = self.velocities(start, end - start)
        for Q, spin in self._turning:
            part = multiply(conjugate(start[Q]), end[Q])
            part = part * np.where(part[..., 3:] < 0, -1.0, 1.0)  # the shorter way
            size = np.linalg.norm(part[..., :3], axis=-1, keepdims=True)
            angle = 2 * np.arctan2(size, part[..., 3:])
            step[spin] = part[..., :3] * np.where(size > 0, angle / np.where(size > 0, size, 1), 2)
        return step

    def velocities(self, q: np.ndarray, rate: np.ndarray) -> np.ndarray:
        """Return v, shape (…, nv), from q̇; quaternions are of unit length."""
        if self.trivial:
            return rate
        size = len(self.plain[1]) + 3 * len(self.balls) + 3 * len(self.free)
        v = np.zeros((*q.shape[:-1], size))
        v[..., self.plain[1]] = rate[..., self.plain[0]]
        for Q, spin in self._turning:
            v[spin] = 2 * multiply(conjugate(q[Q]), rate[Q])[..., :3]
        for p, Q, velocity, _ in self._moving:
            v[velocity] = turn(conjugate(q[Q]), rate[p])
        return v
