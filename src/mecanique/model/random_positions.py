"""Random positions of a mechanism, drawn alike wherever some are needed."""

from __future__ import annotations

from typing import Any

import numpy as np

from mecanique.model.expression import plain, symbols_in
from mecanique.model.mechanism import Mechanism

_NEAR_LIMIT = 0.05
"""A coordinate limited on both sides is kept off its limits by this part of their distance."""


def draw_positions(
    mechanism: Mechanism, count: int, random: np.random.Generator, length: float
) -> np.ndarray:
    """Return positions, shape (n, nq): angles in (−π, π), unit quaternions, all within limits.

    Units: length [m].
    """
    angular = angles(mechanism)
    reach = np.array([np.pi if name in angular else length for name in mechanism.coordinates])
    low, high = -reach, reach.copy()
    for name, (lower, upper) in mechanism.limits.items():
        k = mechanism.coordinates.index(name)
        if np.isfinite([lower, upper]).all():
            low[k], high[k] = (
                lower + _NEAR_LIMIT * (upper - lower),
                upper - _NEAR_LIMIT * (upper - lower),
            )
        else:
            low[k], high[k] = max(lower, low[k]), min(upper, high[k])
            if not low[k] < high[k]:
                middle = mechanism.neutral()[k]
                low[k], high[k] = (
                    (lower, 2 * middle - lower)
                    if np.isfinite(lower)
                    else (2 * middle - upper, upper)
                )
    q = random.uniform(low, high, (count, mechanism.nq))
    for _, at in mechanism.quaternions:
        q[:, at] = random.normal(size=(count, 4))
    return mechanism.normalize(q)


def angles(mechanism: Mechanism) -> set[str]:
    """Return the coordinates that are angles and the velocities that are angular."""
    driven = {name: plain(scalar) for name, scalar in mechanism.coordinates.driven.items()}
    turning: set[str] = set()
    lengths: set[str] = set()
    rates: set[str] = set()
    for joint in mechanism.joints:
        turning.update(joint.angular_coordinates)
        lengths.update(() if joint.quaternion else joint.linear_coordinates)
        rates.update(joint.angular_velocities if joint.quaternion else ())
    for name, scalar in driven.items():
        # an angle turns a joint, or moves a slide as l cos(q); a length turns a joint as asin(x /
        # l)
        turning |= (
            _inside(scalar, {"sin", "cos", "tan"}) if name in lengths else symbols_in(scalar)
        ) - _inside(scalar, {"asin", "acos", "atan", "atan2"})
    turning = (turning - lengths) & set(mechanism.coordinates)
    return turning | rates | {f"{name}'" for name in turning}


def _inside(expression: Any, functions: set[str]) -> set[str]:
    """Symbols within some functions of an expression."""
    if isinstance(expression, float):
        return set()
    if type(expression).__name__ in functions:
        return set(symbols_in(expression))
    return set().union(*(_inside(part, functions) for part in expression.args))
