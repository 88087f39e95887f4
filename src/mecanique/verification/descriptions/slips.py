"""Recognize a slip in a changed number of a description."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

import numpy as np

from mecanique.arrays import Array
from mecanique.model import slips
from mecanique.model.slips import DIGITS, LEFT_OUT, Factor, Slip

_CLOSE = 1e-4
"""Relative difference that digits left out in print make."""

_ALONE = (*slips.MILLIMETERS, *DIGITS[:2], Factor(-1.0, "sign", "the other sign"))
"""What may happen to a single number of several."""


def mass_slip(before: float, after: float) -> str:
    """Return what a changed mass looks like; empty if it looks like none known."""
    if before and not after:
        return LEFT_OUT
    return _factor(np.array([before]), np.array([after]), (*slips.MASS, *DIGITS))


def vector_slip(before: Array, after: Array) -> str:
    """Return what a changed position looks like, both of shape (3,) [m]."""
    text = _factor(before, after, (*slips.LENGTH, *DIGITS[:2]))
    text = text or _first(slips.mistake_vector("", before), after, before)
    if not text and before.any() and not after.any():
        return LEFT_OUT
    return text or _entry(before, after, "xyz", before)


def inertia_slip(mass: float, center: Array, before: Array, after: Array) -> str:
    """Return what a changed inertia looks like, both about the center of mass, shape (3, 3)."""
    text = _factor(before, after, (*slips.INERTIA, *DIGITS[:2]))
    if not text and before.any() and not after.any():
        return LEFT_OUT
    text = text or _first(slips.mistake_point(mass, center, before), after, after)
    text = text or _first(slips.mistake_products(before), after, before)
    text = text or _first(slips.mistake_axes(before), after, before)
    if text:
        return text
    values, others = (np.array(np.linalg.eigvalsh(x), dtype=float) for x in (before, after))
    if _near(values, others, values):
        return "the same principal moments about other axes"
    upper = np.triu_indices(3)
    names = [f"i{'xyz'[i]}{'xyz'[k]}" for i, k in zip(*upper, strict=True)]
    return _entry(before[upper], after[upper], names, before)


def turn_slip(before: Array, after: Array) -> str:
    """Return what changed roll, pitch and yaw look like, both of shape (3,) [rad]."""
    right, wrong = slips.turn_of(before), slips.turn_of(after)
    one = np.eye(3)
    if text := _first(slips.mistake_turn(before), wrong, one):
        return text
    for axis, name in zip(np.eye(3), "xyz", strict=True):
        for angle in (np.pi / 2, -np.pi / 2, np.pi):
            turn = slips.turn_of(angle * axis)
            if any(_near(wrong, found, one) for found in (right @ turn, turn @ right)):
                return f"{np.degrees(angle):+.0f}° about {name}"
    return ""


def axis_slip(before: Array, after: Array) -> str:
    """Return what a changed axis looks like."""
    return "reversed" if _near(after, -before, before) else vector_slip(before, after)


def bounds_slip(before: Array, after: Array) -> str:
    """Return what changed limits look like."""
    factors = (*slips.ANGLE, *slips.MILLIMETERS, Factor(-1.0, "sign", "the other sign"))
    if text := _factor(before, after, factors):
        return text
    return "the other sign, exchanged" if _near(after, -before[::-1], before) else ""


def _factor(before: Array, after: Array, factors: Iterable[Factor]) -> str:
    """Return the words of the factor between two arrays; empty if it is none of these."""
    known = (f.text for f in factors if before.any() and _near(after, f.factor * before, after))
    return next(known, "")


def _first(found: Iterator[Slip], after: Array, size: Array) -> str:
    return next((slip.text for slip in found if _near(after, slip.value, size)), "")


def _entry(before: Array, after: Array, names: Sequence[str], size: Array) -> str:
    """Return the slip of a single entry, the only one that changed."""
    changed = [k for k in range(len(before)) if not _near(after[k], before[k], size)]
    if len(changed) != 1:
        return ""
    (k,) = changed
    text = _factor(before[k : k + 1], after[k : k + 1], _ALONE)
    return f"{text} of {names[k]} alone" if text else ""


def _near(x: Array, y: Array, size: Array) -> bool:
    return bool(np.abs(x - y).max() <= _CLOSE * np.abs(size).max())
