"""States of a mechanism, many at once: checked arrays and the value of every symbol."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, TypeAlias, final

import numpy as np

from mecanique.errors import InputError
from mecanique.model.expression import evaluate
from mecanique.model.mechanism import Mechanism

__all__ = ["Given", "States"]

Given: TypeAlias = "Sequence[float] | np.ndarray | Mapping[str, float] | None"
"""Positions or velocities: an array, shape (n,) or (states, n), values by name, or None for rest."""


@final
@dataclass(frozen=True)
class States:
    """Positions, velocities and times of n states.

    Args:
        mechanism: what is in these states.
        q: shape (n, nq), positions; quaternions of unit length.
        v: shape (n, nv), velocities.
        t: shape (n,), times [s].
        single: whether one state was given without a batch axis.
    """

    mechanism: Mechanism
    q: np.ndarray
    v: np.ndarray
    t: np.ndarray
    single: bool

    @classmethod
    def of(
        cls, mechanism: Mechanism, q: Given, v: Given = None, t: float | np.ndarray = 0.0
    ) -> States:
        """Check and align what was given.

        Args:
            mechanism: what is in these states.
            q: shape (nq,) or (n, nq), or values by name.
            v: shape (nv,) or (n, nv), or values by name; zero when left out.
            t: shape () or (n,) [s].

        Raises:
            InputError: if a shape is wrong, a number is not finite or the numbers of states differ.
            UnknownNameError: if a name is no coordinate or velocity.
        """
        rows_q, single_q = _rows(q, mechanism, "q")
        rows_v, single_v = _rows(v, mechanism, "v")
        times = _array(t, "t")
        if times.ndim > 1:
            raise InputError(f"expected shape () or (n,) for the times t, got {times.shape}")
        lengths = {
            len(rows) for rows, single in ((rows_q, single_q), (rows_v, single_v)) if not single
        }
        lengths |= {len(times)} if times.ndim else set()
        if len(lengths) > 1:
            raise InputError(f"expected one number of states in q, v and t, got {sorted(lengths)}")
        n = lengths.pop() if lengths else 1
        return cls(
            mechanism,
            np.broadcast_to(rows_q, (n, mechanism.nq)),
            np.broadcast_to(rows_v, (n, mechanism.nv)),
            np.broadcast_to(times, (n,)),
            single_q and single_v and not times.ndim,
        )

    def __len__(self) -> int:
        return len(self.t)

    @cached_property
    def values(self) -> dict[str, Any]:
        """Value of every parameter, input, coordinate, velocity and t, by name; shape () or (n,)."""
        mechanism = self.mechanism
        constants: dict[str, Any] = {**mechanism.values, "t": self.t}
        signals: dict[str, Any] = {}
        for signal in mechanism.inputs:
            if callable(signal.signal):
                value = np.array([float(signal.signal(float(t))) for t in self.t])
            else:
                value = np.broadcast_to(evaluate(signal.signal, constants), (len(self),))
            if not np.isfinite(value).all():
                raise InputError(
                    f"input {signal.symbol!r} is not finite at t = {self.t[~np.isfinite(value)][0]:g} s"
                )
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


def _rows(given: Given, mechanism: Mechanism, what: str) -> tuple[np.ndarray, bool]:
    size = mechanism.nq if what == "q" else mechanism.nv
    if given is None or isinstance(given, Mapping):
        one = mechanism.position(given) if what == "q" else mechanism.velocity(given)
        return one[None], True
    rows = _array(given, what)
    if rows.ndim not in (1, 2) or rows.shape[-1] != size:
        names = mechanism.coordinates.names if what == "q" else mechanism.velocities
        listed = ", ".join(names[:8])
        raise InputError(
            f"expected shape ({size},) or (n, {size}) for {what} = ({listed}), got {rows.shape}"
        )
    single = rows.ndim == 1
    rows = np.atleast_2d(rows)
    if what == "q":
        mechanism.refuse_outside(rows)
    return (_normalized(rows, mechanism) if what == "q" else rows), single


def _array(given: object, what: str) -> np.ndarray:
    try:
        numbers: np.ndarray = np.array(given, dtype=float)
    except (TypeError, ValueError):
        raise InputError(f"expected numbers for {what}, got {given!r}") from None
    if not np.isfinite(numbers).all():
        raise InputError(f"expected finite numbers for {what}, got {numbers.tolist()}")
    return numbers


def _normalized(q: np.ndarray, mechanism: Mechanism) -> np.ndarray:
    for joint in mechanism.joints:
        if joint.quaternion:
            at = [mechanism.coordinates.index(name) for name in joint.quaternion]
            length = np.linalg.norm(q[:, at], axis=1, keepdims=True)
            if (length < 1e-9).any():
                raise InputError(
                    f"expected a unit quaternion for joint {joint.name!r}, got one without length"
                )
            q[:, at] /= length
    return q
