"""Orientations in other conventions than the model's own, which is the quaternion (x, y, z, w)."""

from __future__ import annotations

from functools import reduce
from typing import Any

import numpy as np

from mecanique.errors import InputError
from mecanique.model.quaternions import multiply

ORDERS = ("xyzw", "wxyz")
"""Orders in which quaternions are written."""

_AXES = dict(zip("xyz", np.eye(3), strict=True))

_SHORTEST = 1e-9
"""A quaternion shorter than this has no direction."""


def from_quaternion(given: np.ndarray, order: str | None) -> np.ndarray:
    """Return unit quaternions (x, y, z, w), shape (…, 4), of quaternions in a stated order.

    Args:
        given: shape (…, 4).
        order: "xyzw" or "wxyz".

    Raises:
        InputError: if there is no such order, or a quaternion has no length.
    """
    length = np.linalg.norm(given, axis=-1, keepdims=True)
    if not (length > _SHORTEST).all():
        raise InputError(f"expected a unit quaternion, got {given.tolist()}")
    found: np.ndarray = given / length
    return np.roll(found, -1, axis=-1) if _check_order(order) == "wxyz" else found


def to_quaternion(orientation: np.ndarray, order: str | None) -> np.ndarray:
    """Return quaternions in an order, of quaternions (x, y, z, w), shape (…, 4).

    Args:
        orientation: shape (…, 4).
        order: "xyzw" or "wxyz".

    Raises:
        InputError: if there is no such order.
    """
    return np.roll(orientation, 1 if _check_order(order) == "wxyz" else 0, axis=-1)


def from_euler(angles: np.ndarray, sequence: str | None) -> np.ndarray:
    """Return quaternions (x, y, z, w), shape (…, 4), of Euler angles in a stated sequence.

    Args:
        angles: shape (…, 3) [rad].
        sequence: such as "xyz" or "ZYX", see `mecanique.floating`.

    Raises:
        InputError: if there is no such sequence.
    """
    turns = []
    for axis, angle in zip(
        _check_sequence(sequence).lower(), np.moveaxis(angles, -1, 0), strict=True
    ):
        half = np.asarray(angle)[..., None] / 2
        turns.append(np.concatenate([_AXES[axis] * np.sin(half), np.cos(half)], axis=-1))
    # the first turn about fixed axes, or the last about axes that turn along, acts first
    return reduce(multiply, turns[::-1] if str(sequence).islower() else turns)


def to_euler(orientation: np.ndarray, sequence: str | None) -> np.ndarray:
    """Return Euler angles, shape (…, 3) [rad], of quaternions (x, y, z, w).

    At gimbal lock, where only the sum or difference of the first and third turn counts, the third
    angle is zero.

    Args:
        orientation: shape (…, 4).
        sequence: such as "xyz" or "ZYX", see `mecanique.floating`.

    Raises:
        InputError: if there is no such sequence.
    """
    import warnings

    from scipy.spatial.transform import Rotation

    turns: Any = Rotation.from_quat(orientation)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)
        return np.asarray(turns.as_euler(_check_sequence(sequence)))


def _check_order(order: str | None) -> str:
    if order not in ORDERS:
        raise InputError(f'expected the order "xyzw" or "wxyz" of a quaternion, got {order!r}')
    return str(order)


def _check_sequence(sequence: str | None) -> str:
    text = sequence if isinstance(sequence, str) else ""
    sound = (
        len(text) == 3 and set(text.lower()) <= set("xyz") and (text.islower() or text.isupper())
    )
    if not sound or text[0] == text[1] or text[1] == text[2]:
        raise InputError(
            'expected a sequence of Euler angles, such as "xyz" (turns about fixed axes) or "ZYX" '
            f"(about axes that turn along), got {sequence!r}"
        )
    return text
