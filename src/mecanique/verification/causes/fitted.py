"""Fitted numbers: their standard deviations, how plain they are, and how to state them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import final

import numpy as np

from mecanique.arrays import Array

_ROUND, _ANY = 4, 6
"""Numbers of more digits than the first are any numbers, which are shown with the second."""


@final
@dataclass(frozen=True, order=True)
class Amount:
    """How plain a fitted change is: of changes that explain as well, the least is the likeliest.

    Args:
        digits: how many decimal digits state it; hands choose round numbers.
        ways: in how many ways such a slip can be made there, or how many numbers it rewrites.
        share: how large it is beside what stood there.
    """

    digits: int = 0
    ways: int = 1
    share: float = 0.0

    @classmethod
    def of(cls, new: float, old: float = 0.0, beside: float | None = None, ways: int = 1) -> Amount:
        """Return it of one number, read as it is, as a difference, or as a factor.

        Args:
            new: the number.
            old: what it was.
            beside: the size of what stood there, if it is more than the number.
            ways: in how many ways such a slip can be made there.
        """
        readings = [new, new - old, *([new / old] if old else [])]
        return cls(min(map(_count_digits, readings)), ways, _share(new - old, beside or old))

    @classmethod
    def of_all(cls, values: Array, beside: float) -> Amount:
        """Return it of a shift or a turn by several numbers.

        Args:
            values: the numbers.
            beside: the size of what stood there.
        """
        most = max(map(_count_digits, values.tolist()))
        return cls(most, len(values), _share(float(np.linalg.norm(values)), beside))


def _share(change: float, beside: float) -> float:
    """How large a change is; what stands where nothing was is all of it."""
    return float(abs(change) / abs(beside)) if beside else 1.0


def _count_digits(value: float) -> int:
    shown = f"{abs(value):.{_ANY}g}".partition("e")[0].replace(".", "").strip("0")
    return len(shown) if len(shown) <= _ROUND else _ANY


def deviations(slopes: Array, left: float, count: int) -> Array:
    """Return standard deviations of fitted numbers, shape (numbers,).

    Args:
        slopes: of the residuals by each number, shape (numbers, rows).
        left: norm of all residuals.
        count: how many residuals there are.
    """
    variance = left**2 / max(count - len(slopes), 1)
    spread = np.diag(np.linalg.pinv(slopes @ slopes.T)) * variance
    return np.asarray(np.sqrt(spread))


def turn_about(x: Array) -> Array:
    """Return the turn by the angle |x| about x, shape (3, 3)."""
    from scipy.spatial.transform import Rotation  # not wanted before a cause is looked for

    turn: Array = Rotation.from_rotvec(x).as_matrix()
    return turn


def give(value: float, sigma: float) -> str:
    """Return a fitted number, with its standard deviation where that can be seen."""
    if sigma <= 1e-6 * abs(value):
        return f"{value:.6g}"
    places = max(0, 1 - math.floor(math.log10(sigma)))
    return f"{value:.{places}f} ± {sigma:.{places}f}"


def give_all(values: Array) -> str:
    """Return fitted numbers in a row."""
    return ", ".join(f"{value:.6g}" for value in values)


def say_turn(x: Array) -> str:
    """Return a turn in words."""
    from scipy.spatial.transform import Rotation  # not wanted before a cause is looked for

    x = Rotation.from_rotvec(x).as_rotvec() + 0.0  # half a turn at most
    angle = float(np.linalg.norm(x))
    axis = x / angle if angle else np.array([0.0, 0.0, 1.0])
    return f"{np.degrees(angle):.6g}° about ({give_all(axis)})"
