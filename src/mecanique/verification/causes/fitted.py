"""Fitted numbers: their standard deviations, and how to state them."""

from __future__ import annotations

import math

import numpy as np

from mecanique.arrays import Array

__all__ = ["deviations", "give", "give_all", "say_turn", "turn_about"]


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
    angle = float(np.linalg.norm(x))
    axis = x / angle if angle else np.array([0.0, 0.0, 1.0])
    return f"{np.degrees(angle):.6g}° about ({give_all(axis)})"
