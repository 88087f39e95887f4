"""Rates of the coordinates and generalized velocities, batched over states.

They differ only where a joint's position is a unit quaternion (`Spherical`, `Floating`): there the
velocities are components in the child's axes. Quaternions are (x, y, z, w).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np

from mecanique.model.mechanism import Mechanism
from mecanique.model.quaternions import conjugate, multiply, pure, turn

__all__ = ["Rates"]


@final
@dataclass(frozen=True)
class Rates:
    """The maps between v and q̇ of a mechanism.

    Args:
        plain: pairs of indices (in q, in v) of the coordinates whose rate is their velocity.
        balls: first index of each quaternion in q and of its angular velocity in v.
        free: first index of each free body's position in q and of its velocity in v; its quaternion
            follows.
    """

    plain: tuple[tuple[int, ...], tuple[int, ...]]
    balls: tuple[tuple[int, int], ...]
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
                at = names.index(joint.coordinates[0]), velocities.index(joint.velocities[0])
                inside.update(joint.coordinates)
                if joint.linear_coordinates:
                    free.append(at)
                    at = at[0] + 3, at[1] + 3
                balls.append(at)
        own = [name for name in names if name not in inside]
        plain = tuple(names.index(n) for n in own), tuple(velocities.index(f"{n}'") for n in own)
        return cls(plain, tuple(balls), tuple(free))

    @property
    def trivial(self) -> bool:
        """Whether v is q̇."""
        return not self.balls and self.plain[0] == self.plain[1]

    def normalize(self, q: np.ndarray) -> np.ndarray:
        """Return positions with every quaternion of unit length.

        Args:
            q: shape (…, nq).
        """
        if not self.balls:
            return q
        q = q.copy()
        for i, _ in self.balls:
            q[..., i : i + 4] /= np.linalg.norm(q[..., i : i + 4], axis=-1, keepdims=True)
        return q

    def drift(self, q: np.ndarray) -> float:
        """Return by how much the length of a quaternion differs from one, at most.

        Args:
            q: shape (…, nq).
        """
        return max(
            (
                float(np.abs(np.linalg.norm(q[..., i : i + 4], axis=-1) - 1).max())
                for i, _ in self.balls
            ),
            default=0.0,
        )

    def first(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Return q̇.

        For a quaternion Q and ω in body axes: Q̇ = ½ Q ω (Shuster, J. Astronaut. Sci. 41
        (1993) 439).

        Args:
            q: shape (…, nq).
            v: shape (…, nv).
        """
        if self.trivial:
            return v
        rate = np.zeros_like(q)
        rate[..., self.plain[0]] = v[..., self.plain[1]]
        for i, k in self.balls:
            rate[..., i : i + 4] = 0.5 * multiply(q[..., i : i + 4], pure(v[..., k : k + 3]))
        for i, k in self.free:
            rate[..., i : i + 3] = turn(q[..., i + 3 : i + 7], v[..., k : k + 3])
        return rate

    def second(self, q: np.ndarray, v: np.ndarray, a: np.ndarray) -> np.ndarray:
        """Return q̈.

        Args:
            q: shape (…, nq).
            v: shape (…, nv).
            a: shape (…, nv), rates of v.
        """
        if self.trivial:
            return a
        rate = np.zeros_like(q)
        rate[..., self.plain[0]] = a[..., self.plain[1]]
        for i, k in self.balls:
            spin = pure(v[..., k : k + 3])
            Q = q[..., i : i + 4]
            rate[..., i : i + 4] = 0.5 * multiply(Q, pure(a[..., k : k + 3])) + 0.25 * multiply(
                multiply(Q, spin), spin
            )
        for i, k in self.free:
            spin = np.cross(v[..., k + 3 : k + 6], v[..., k : k + 3])
            rate[..., i : i + 3] = turn(q[..., i + 3 : i + 7], a[..., k : k + 3] + spin)
        return rate

    def displace(self, q: np.ndarray, step: np.ndarray) -> np.ndarray:
        """Return positions after a small step along velocities: q + step where v is q̇.

        Args:
            q: shape (…, nq), with unit quaternions.
            step: shape (…, nv), v times a short time.
        """
        if self.trivial:
            shifted: np.ndarray = q + step
            return shifted
        moved = q + np.zeros((*step.shape[:-1], 1))
        moved[..., self.plain[0]] += step[..., self.plain[1]]
        for i, k in self.free:
            moved[..., i : i + 3] += turn(q[..., i + 3 : i + 7], step[..., k : k + 3])
        for i, k in self.balls:
            half = step[..., k : k + 3] / 2
            angle = np.linalg.norm(half, axis=-1, keepdims=True)
            change = np.concatenate([half * np.sinc(angle / np.pi), np.cos(angle)], axis=-1)
            moved[..., i : i + 4] = multiply(q[..., i : i + 4], change)
        return moved

    def velocities(self, q: np.ndarray, rate: np.ndarray) -> np.ndarray:
        """Return v from q̇.

        Args:
            q: shape (…, nq), with unit quaternions.
            rate: shape (…, nq).
        """
        if self.trivial:
            return rate
        v = np.zeros((*q.shape[:-1], len(self.plain[1]) + 3 * len(self.balls) + 3 * len(self.free)))
        v[..., self.plain[1]] = rate[..., self.plain[0]]
        for i, k in self.balls:
            v[..., k : k + 3] = (
                2 * multiply(conjugate(q[..., i : i + 4]), rate[..., i : i + 4])[..., :3]
            )
        for i, k in self.free:
            v[..., k : k + 3] = turn(conjugate(q[..., i + 3 : i + 7]), rate[..., i : i + 3])
        return v
