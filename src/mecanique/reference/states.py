"""States as callers give them: one or many, arrays or mappings; checked once, here."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias, final

import numpy as np

from mecanique.errors import InputError
from mecanique.model.expression import finite
from mecanique.model.mechanism import Mechanism
from mecanique.reference.engine.answers import Array

__all__ = ["Given", "States", "checked"]

Given: TypeAlias = "Array | Sequence[float] | Mapping[str, float] | None"
"""Shape (n_names,) or (n, n_names), or values by name; those left out, or all for None, are zero."""


@final
@dataclass(frozen=True, eq=False)
class States:
    """One or many states.

    Args:
        q: shape (n, nq).
        v: shape (n, nv).
        a: shape (n, nv).
        t: shape (n,) [s].
        many: whether many were asked about, so that answers have a first axis of n.
    """

    q: Array
    v: Array
    a: Array
    t: Array
    many: bool


def checked(
    mechanism: Mechanism, q: Given, v: Given = None, a: Given = None, t: float | Array = 0.0
) -> States:
    """Return states with every shape and number checked.

    Args:
        mechanism: whose states they are.
        q: positions, shape (nq,) or (n, nq), or by name.
        v: velocities, shape (nv,) or (n, nv), or by name.
        a: accelerations, shape (nv,) or (n, nv), or by name: of the coordinate, the velocity, or
            q''.
        t: time [s], or shape (n,).

    Raises:
        InputError: if a shape is wrong or a number is not finite.
        UnknownNameError: if a name does not exist.
    """
    if isinstance(a, Mapping):
        a = {
            name.removesuffix("'") if name.endswith("''") else name: value
            for name, value in a.items()
        }
    rows = {what: _rows(given) for what, given in (("q", q), ("v", v), ("a", a))}
    times = np.asarray(t)
    lengths = {len(array) for array in rows.values() if array is not None}
    if times.ndim == 1:
        lengths.add(len(times))
    if not lengths:
        time = finite(t, "time t")
        one = mechanism.position(q), mechanism.velocity(v), mechanism.velocity(a)
        return States(one[0][None], one[1][None], one[2][None], np.array([time]), many=False)
    if len(lengths) > 1 or times.ndim > 1:
        counts = {name: len(array) for name, array in rows.items() if array is not None}
        shapes = ", ".join(
            f"{name}: {count}" for name, count in {**counts, "t": times.size}.items()
        )
        raise InputError(f"expected the same number of states everywhere, got {shapes}")
    (count,) = lengths
    try:
        each = np.broadcast_to(times.astype(float), (count,))
    except (TypeError, ValueError):
        raise InputError(f"expected times as numbers, got {t!r}") from None
    if not np.isfinite(each).all():
        raise InputError("expected finite times")
    positions = _many(
        rows["q"],
        mechanism.position(q) if rows["q"] is None else None,
        count,
        mechanism.nq,
        "coordinate",
    )
    mechanism.refuse_outside(positions)
    for joint in mechanism.joints:
        if joint.quaternion:
            at = [mechanism.coordinates.index(name) for name in joint.quaternion]
            length = np.linalg.norm(positions[:, at], axis=1)
            if not ((length > 1e-9) & (length < 1e9)).all():
                raise InputError(f"expected unit quaternions for joint {joint.name!r}")
            positions[:, at] /= length[:, None]
    velocities, accelerations = (
        _many(
            rows[name],
            mechanism.velocity(given) if rows[name] is None else None,
            count,
            mechanism.nv,
            what,
        )
        for name, given, what in (("v", v, "velocity"), ("a", a, "acceleration"))
    )
    return States(positions, velocities, accelerations, each, many=True)


def _rows(given: Given) -> Array | None:
    """The given states as an array if they are many, else None."""
    if given is None or isinstance(given, Mapping):
        return None
    try:
        array: Array = np.array(given, dtype=float)
    except (TypeError, ValueError):
        return None
    return array if array.ndim == 2 else None


def _many(rows: Array | None, one: Array | None, count: int, width: int, what: str) -> Array:
    if rows is None:
        return np.repeat(np.asarray(one)[None], count, axis=0)
    if rows.shape[1] != width:
        raise InputError(f"expected shape (n, {width}) for the {what} values, got {rows.shape}")
    if not np.isfinite(rows).all():
        raise InputError(f"expected finite {what} values")
    return rows
