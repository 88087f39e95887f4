"""States of a mechanism, one or many: positions, velocities, accelerations and times, checked."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, final

import numpy as np

from mecanique.errors import InputError
from mecanique.model.expression import evaluate, finite
from mecanique.model.mechanism import Mechanism
from mecanique.model.values import Given

__all__ = ["Given", "States"]


@final
@dataclass(frozen=True, eq=False)
class States:
    """Positions, velocities, times and accelerations of n states.

    Args:
        mechanism: what is in these states.
        q: shape (n, nq), positions; quaternions of unit length.
        v: shape (n, nv), velocities.
        t: shape (n,), times [s].
        a: shape (n, nv), accelerations.
        single: whether one state was given without a batch axis.
    """

    mechanism: Mechanism
    q: np.ndarray
    v: np.ndarray
    t: np.ndarray
    a: np.ndarray
    single: bool = False

    @classmethod
    def of(
        cls,
        mechanism: Mechanism,
        q: Given,
        v: Given = None,
        t: float | np.ndarray = 0.0,
        a: Given = None,
    ) -> States:
        """Check and align what was given.

        Args:
            mechanism: what is in these states.
            q: shape (nq,) or (n, nq), or values by name.
            v: shape (nv,) or (n, nv), or values by name; zero when left out.
            t: shape () or (n,) [s].
            a: shape (nv,) or (n, nv), or values by name of the coordinate, the velocity or its
                rate; zero when left out.

        Raises:
            InputError: if a shape is wrong, a number is not finite or the numbers of states differ.
            UnknownNameError: if a name is no coordinate or velocity.
        """
        parts = {
            "q": mechanism.position(q, many=True),
            "v": mechanism.velocity(v, many=True),
            "a": mechanism.acceleration(a, many=True),
        }
        times = _times(t)
        if not times.ndim and all(rows.ndim == 1 for rows in parts.values()):
            q, v, a = (rows[None] for rows in parts.values())
            return cls(mechanism, q, v, times[None], a, single=True)
        lengths = {name: len(rows) for name, rows in parts.items() if rows.ndim == 2}
        lengths |= {"t": len(times)} if times.ndim else {}
        if len(set(lengths.values())) > 1:
            counts = ", ".join(f"{name}: {count}" for name, count in lengths.items())
            raise InputError(f"expected one number of states in q, v, a and t, got {counts}")
        n = next(iter(lengths.values()))
        rows = {name: np.broadcast_to(part, (n, part.shape[-1])) for name, part in parts.items()}
        times = np.broadcast_to(times, (n,))
        return cls(mechanism, rows["q"], rows["v"], times, rows["a"])

    def __len__(self) -> int:
        return len(self.t)

    def at(self, indices: np.ndarray) -> States:
        """Return some of the states, as many."""
        return States(
            self.mechanism, self.q[indices], self.v[indices], self.t[indices], self.a[indices]
        )

    @cached_property
    def values(self) -> dict[str, Any]:
        """Every parameter, input, coordinate, velocity and t by name, each shape () or (n,)."""
        mechanism = self.mechanism
        constants: dict[str, Any] = {**mechanism.values, "t": self.t}
        signals: dict[str, Any] = {}
        for signal in mechanism.inputs:
            if callable(signal.signal):
                value = np.array([float(signal.signal(float(t))) for t in self.t])
            else:
                value = np.broadcast_to(evaluate(signal.signal, constants), (len(self),))
            if not np.isfinite(value).all():
                first = self.t[~np.isfinite(value)][0]
                raise InputError(f"input {signal.symbol!r} is not finite at t = {first:g} s")
            signals[signal.symbol] = value
        return {
            **constants,
            **signals,
            **dict(zip(mechanism.coordinates, self.q.T, strict=True)),
            **dict(zip(mechanism.velocities, self.v.T, strict=True)),
        }

    def shaped(self, result: np.ndarray) -> np.ndarray:
        """Return a result as it was asked for: without the batch axis for a single state.

        Args:
            result: shape (n, …).
        """
        return result[0] if self.single else result


def _times(t: float | np.ndarray) -> np.ndarray:
    if isinstance(t, str) or np.ndim(t) == 0:
        return np.array(finite(t, "time t"))
    try:
        times: np.ndarray = np.array(t, dtype=float)
    except (TypeError, ValueError):
        raise InputError(f"expected numbers for the times t, got {t!r}") from None
    if times.ndim > 1:
        raise InputError(f"expected shape () or (n,) for the times t, got {times.shape}")
    if not np.isfinite(times).all():
        raise InputError(f"expected finite times t, got {times[~np.isfinite(times)][:3].tolist()}")
    return times
