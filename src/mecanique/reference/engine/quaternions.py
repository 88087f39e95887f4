"""Differentiate and apply quaternions (x, y, z, w) of numbers or symbols."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any


def quaternion_rate(
    quaternion: Sequence[Any], spin: Sequence[Any], half: Any = 0.5
) -> tuple[Any, Any, Any, Any]:
    """Return the rate ½ quaternion ∘ (ω, 0), ω in the child's axes.

    The source is Diebel, Representing Attitude, 2006.

    Args:
        quaternion: four scalars.
        spin: the angular velocity ω, three scalars.
        half: ½, as a float or exact.
    """
    x, y, z, w = quaternion
    a, b, c = spin
    a, b, c = half * a, half * b, half * c
    return (
        w * a + y * c - z * b,
        w * b + z * a - x * c,
        w * c + x * b - y * a,
        -x * a - y * b - z * c,
    )


def turn(quaternion: Sequence[Any], vector: Sequence[Any]) -> tuple[Any, Any, Any]:
    """Rotate a vector by a quaternion of any length, from the child's axes to the joint's."""
    x, y, z, w = quaternion
    a, b, c = vector
    square = x * x + y * y + z * z + w * w
    # p = v + 2 w (r × v) + 2 r × (r × v), divided by the quaternion's square
    i, j, k = y * c - z * b, z * a - x * c, x * b - y * a
    return (
        a + 2 * (w * i + y * k - z * j) / square,
        b + 2 * (w * j + z * i - x * k) / square,
        c + 2 * (w * k + x * j - y * i) / square,
    )
