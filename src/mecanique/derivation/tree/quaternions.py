"""Multiply and apply quaternions (x, y, z, w) of any scalars, by Hamilton's rules."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any


def quaternion_product(p: Sequence[Any], r: Sequence[Any]) -> list[Any]:
    """Return the product p ⊗ r, four scalars (Goldstein, Classical Mechanics, 1980, sect. 4-5)."""
    x, y, z, w = p
    a, b, c, *scalar = r
    out = [
        w * a + y * c - z * b,
        w * b + z * a - x * c,
        w * c + x * b - y * a,
        -(x * a + y * b + z * c),
    ]
    return [each + scalar[0] * part for each, part in zip(out, p, strict=True)] if scalar else out


def quaternion_rotation(x: Any, y: Any, z: Any, w: Any) -> tuple[tuple[Any, Any, Any], ...]:
    """Return the rotation matrix of a unit quaternion, three rows of three scalars."""
    return (
        (1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)),
        (2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)),
        (2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)),
    )
