"""Collect initial states and parameters of many runs; a single value holds for all runs."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from mecanique.errors import InputError, UnknownNameError
from mecanique.model.mechanism import Mechanism
from mecanique.model.mechanism.state_space import by_leaders
from mecanique.model.values import column_of, numbers_of


def sweep(
    mechanism: Mechanism, q: Any, v: Any, parameters: Any
) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Return the starts of all runs, shape (n, nq + nv), and given parameters, shape (n,) each."""
    names = mechanism.coordinates.names
    q = by_leaders(mechanism, q, names)
    positions = numbers_of(q, names, "coordinate", mechanism.neutral(), many=True)
    rates = mechanism.velocity(v, many=True)
    given = {} if parameters is None else parameters
    if not isinstance(given, Mapping):
        raise InputError(f"expected parameters by symbol, got {parameters!r}")
    for symbol in given:
        if symbol not in mechanism.values:
            raise UnknownNameError("parameter", symbol, mechanism.values)
    varied = {symbol: column_of(values, f"parameter {symbol}") for symbol, values in given.items()}
    lengths = {len(x) for x in (positions, rates) if x.ndim == 2}
    lengths |= {len(x) for x in varied.values() if x.ndim}
    if len(lengths) > 1:
        raise InputError(
            f"expected one number of runs in q, v and parameters, got {sorted(lengths)}"
        )
    n = lengths.pop() if lengths else 1
    if not n:
        raise InputError("expected at least one run, got none")
    parts = (np.broadcast_to(x, (n, x.shape[-1])) for x in (positions, rates))
    start = np.concatenate([*parts], axis=1)
    varied = {
        symbol: np.ascontiguousarray(np.broadcast_to(x, (n,))) for symbol, x in varied.items()
    }
    for values in varied.values():
        for index in {int(np.argmin(values)), int(np.argmax(values))}:
            mechanism.replace(**{name: float(x[index]) for name, x in varied.items()})
    mechanism.normalize(start[:, : mechanism.nq])
    return start, varied
