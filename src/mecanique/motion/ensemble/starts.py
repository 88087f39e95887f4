"""Initial states and parameters of many runs: what is given once holds for all of them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from mecanique.errors import InputError, UnknownNameError
from mecanique.model.mechanism import Mechanism

__all__ = ["swept"]


def swept(
    mechanism: Mechanism, q: Any, v: Any, parameters: Any
) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Return the starts of all runs, shape (n, nq + nv), and the parameters that are given, shape (n,) each.

    Args:
        mechanism: what moves.
        q: positions: arrays or by name.
        v: velocities: arrays or by name.
        parameters: by symbol.

    Raises:
        InputError: if a shape is wrong, a number is not finite, or the numbers of runs differ.
        UnknownNameError: if a name does not exist.
        MechanismError: if the mechanism is not sound with some of the parameters.
    """
    columns: dict[str, np.ndarray] = {}
    names = mechanism.coordinates.names
    columns |= _columns(q, names, names, "coordinate", mechanism.neutral())
    aliases = tuple(name.removesuffix("'") for name in mechanism.velocities)
    columns |= _columns(v, mechanism.velocities, aliases, "velocity", np.zeros(mechanism.nv))
    given = {} if parameters is None else parameters
    if not isinstance(given, Mapping):
        raise InputError(f"expected parameters by symbol, got {parameters!r}")
    for symbol in given:
        if symbol not in mechanism.values:
            raise UnknownNameError("parameter", symbol, mechanism.values)
    varied = {symbol: _numbers(values, f"parameter {symbol}") for symbol, values in given.items()}
    lengths = {len(x) for x in (*columns.values(), *varied.values()) if x.ndim}
    if len(lengths) > 1:
        raise InputError(
            f"expected one number of runs in q, v and parameters, got {sorted(lengths)}"
        )
    n = lengths.pop() if lengths else 1
    if not n:
        raise InputError("expected at least one run, got none")
    start = np.stack([np.broadcast_to(x, (n,)) for x in columns.values()], axis=1)
    varied = {
        symbol: np.ascontiguousarray(np.broadcast_to(x, (n,))) for symbol, x in varied.items()
    }
    for values in varied.values():
        for index in {int(np.argmin(values)), int(np.argmax(values))}:
            mechanism.replace(**{other: float(x[index]) for other, x in varied.items()})
    for joint in mechanism.joints:
        if joint.quaternion:
            at = [names.index(name) for name in joint.quaternion]
            length = np.linalg.norm(start[:, at], axis=1, keepdims=True)
            if (length < 1e-9).any():
                raise InputError(
                    f"expected unit quaternions for joint {joint.name!r}, got one without length"
                )
            start[:, at] /= length
    return start, varied


def _columns(
    given: Any, names: tuple[str, ...], aliases: tuple[str, ...], kind: str, default: np.ndarray
) -> dict[str, np.ndarray]:
    """One column per name, each shape () or (n,)."""
    columns: dict[str, np.ndarray] = dict(zip(names, map(np.array, default.tolist()), strict=True))
    if given is None:
        return columns
    if isinstance(given, Mapping):
        for name, values in given.items():
            known = (
                name if name in names else names[aliases.index(name)] if name in aliases else None
            )
            if known is None:
                raise UnknownNameError(kind, name, names)
            columns[known] = _numbers(values, f"{kind} {name}")
        return columns
    array = _array(given, f"the {kind} values")
    if array.ndim not in (1, 2) or array.shape[-1] != len(names):
        listed = ", ".join(names[:8])
        raise InputError(
            f"expected shape ({len(names)},) or (n, {len(names)}) for the {kind} values ({listed}), got {array.shape}"
        )
    return dict(zip(names, np.moveaxis(array, -1, 0), strict=True))


def _numbers(values: Any, what: str) -> np.ndarray:
    array = _array(values, what)
    if array.ndim > 1:
        raise InputError(f"expected a number or shape (n,) for {what}, got shape {array.shape}")
    return array


def _array(values: Any, what: str) -> np.ndarray:
    try:
        array: np.ndarray = np.array(values, dtype=float)
    except (TypeError, ValueError):
        raise InputError(f"expected numbers for {what}, got {values!r}") from None
    if not np.isfinite(array).all():
        raise InputError(
            f"expected finite numbers for {what}, got {array[~np.isfinite(array)].ravel()[:3].tolist()}"
        )
    return array
