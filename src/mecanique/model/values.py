"""Numbers given in order or by name, checked: the one way in for positions and velocities."""

from __future__ import annotations

from collections.abc import Mapping, Sequence, Set
from typing import Any, TypeAlias

import numpy as np

from mecanique.errors import InputError, UnknownNameError
from mecanique.model.expression import finite
from mecanique.wording import say_count

Given: TypeAlias = "np.ndarray | Sequence[float] | Mapping[str, float] | None"
"""Shape (names,) or (n, names), or values by name; what is left out takes its default, zero.

Of a position that is what `Mechanism.neutral` returns.
"""

_LISTED = 8
"""At most this many names are listed in a message."""


def numbers_of(
    given: Given,
    names: tuple[str, ...],
    kind: str,
    default: np.ndarray,
    aliases: Mapping[str, str] | None = None,
    *,
    many: bool = False,
) -> np.ndarray:
    """Return numbers in the order of their names, a new array of shape (names,).

    Shapes: default (names,), many (n, names).
    """
    if given is None:
        return np.array(default)
    if isinstance(given, Mapping):
        spellings = {**(aliases or {}), **{name: name for name in names}}
        columns = dict(zip(names, np.array(default), strict=True))
        for name, value in given.items():
            if name not in spellings:
                raise UnknownNameError(kind, name, names)
            what = f"{kind} {name}"
            columns[spellings[name]] = column_of(value, what) if many else finite(value, what)
        lengths = {len(column) for column in columns.values() if np.ndim(column)}
        if len(lengths) > 1:
            raise InputError(f"expected one number of {kind} values each, got {sorted(lengths)}")
        values = np.broadcast_arrays(*columns.values())
        return np.ascontiguousarray(np.array(values, dtype=float).T)
    try:
        numbers: np.ndarray = np.array(given, dtype=float)
    except (TypeError, ValueError, OverflowError):
        raise InputError(
            f"expected {say_count(len(names), 'number')} for the {kind} values, got {given!r}"
        ) from None
    if numbers.ndim not in ((1, 2) if many else (1,)) or numbers.shape[-1] != len(names):
        rows = f" or (n, {len(names)})" if many else ""
        raise InputError(
            f"expected shape ({len(names)},){rows} for the {kind} values "
            f"({', '.join(names[:_LISTED])}), got {numbers.shape}"
        )
    if not np.isfinite(numbers).all():
        raise InputError(f"expected finite {kind} values, got {_shorten(numbers)}")
    return numbers


def column_of(value: Any, what: str) -> np.ndarray:
    """Return one value, shape (), or those of many states, shape (n,), as an array."""
    try:
        single = isinstance(value, str) or np.ndim(value) == 0
        column: np.ndarray = np.zeros(1) if single else np.array(value, dtype=float)
    except (TypeError, ValueError, OverflowError):
        raise InputError(f"expected numbers for {what}, got {value!r}") from None
    if single:
        return np.array(finite(value, what))
    if not column.size:
        raise InputError(f"expected at least one number for {what}, got none")
    if column.ndim > 1:
        raise InputError(f"expected a number or shape (n,) for {what}, got shape {column.shape}")
    if not np.isfinite(column).all():
        raise InputError(f"expected finite numbers for {what}, got {_shorten(column)}")
    return column


def names_of(given: object, what: str) -> tuple[str, ...]:
    """Return names given as one or several, or raise."""
    names = (given,) if isinstance(given, str) else given
    if isinstance(names, (Sequence, Set, Mapping)) and all(isinstance(name, str) for name in names):
        return tuple(names)
    raise InputError(f"expected names for {what}, got {given!r}")


def _shorten(numbers: np.ndarray) -> str:
    """The numbers, or the first few that are not finite."""
    if numbers.size <= _LISTED:
        return str(numbers.tolist())
    return f"{numbers[~np.isfinite(numbers)][:3].tolist()} among them"


def whole(number: object, what: str, least: int = 1, most: int | None = None) -> int:
    """Return a whole number, or raise."""
    if isinstance(number, bool) or not isinstance(number, (int, np.integer)) or number < least:
        raise InputError(f"expected a whole number of at least {least} for {what}, got {number!r}")
    if most is not None and number > most:
        raise InputError(f"expected at most {most} for {what}, got more")
    return int(number)
