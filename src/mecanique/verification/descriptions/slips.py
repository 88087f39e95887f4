"""Recognize a slip in a changed number: a unit, a sign, an axis, a point, a digit."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import permutations

import numpy as np

from mecanique.arrays import Array
from mecanique.model.placement import Placement

_CLOSE = 1e-4
"""Relative difference that digits left out in print make."""

_ORDERS = "ypr", "pry", "ryp", "pyr", "yrp"
"""Roll, pitch and yaw taken in another order."""

_MOST_LIKE = 2
"""As many slips are named where several look the same."""

_SIGNS = ((-1, 1, 1), (1, -1, 1), (1, 1, -1), (-1, -1, 1), (-1, 1, -1), (1, -1, -1), (-1, -1, -1))


def mass_slip(before: float, after: float) -> str:
    """Return what a changed mass looks like; empty if it looks like none known."""
    factors = {
        1e3: "grams for kilograms",
        1e-3: "kilograms for grams",
        10.0: "a decimal point (×10)",
        0.1: "a decimal point (÷10)",
        1 / 0.45359237: "pounds for kilograms",
        100.0: "a decimal point (×100)",
        0.01: "a decimal point (÷100)",
        0.0: "no mass",
    }
    if before == 0:
        return ""
    return next((text for f, text in factors.items() if _near(after, f * before, before)), "")


def vector_slip(before: Array, after: Array) -> str:
    """Return what a changed position looks like.

    Args:
        before: shape (3,) [m].
        after: shape (3,) [m].
    """
    for factor, text in (
        (1e3, "millimeters for meters"),
        (1e-3, "meters for millimeters"),
        (100.0, "centimeters for meters"),
        (10.0, "a decimal point (×10)"),
        (0.1, "a decimal point (÷10)"),
        (0.0254, "inches"),
        (1 / 0.0254, "inches for meters"),
    ):
        if before.any() and _near(after, factor * before, after):
            return text
    for signs in _SIGNS:
        if before.any() and _near(after, np.array(signs) * before, before):
            turned = [axis for axis, sign, x in zip("xyz", signs, before, strict=True)
                      if sign < 0 and x]  # fmt: skip
            return f"mirrored ({', '.join(turned)} with the other sign)"
    for order in permutations(range(3)):
        if order != (0, 1, 2) and _near(after, before[list(order)], before):
            return f"axes exchanged ({', '.join('xyz'[k] for k in order)})"
    if before.any() and not after.any():
        return "left out"
    changed = [
        (axis, x, y)
        for axis, x, y in zip("xyz", before, after, strict=True)
        if not _near(y, x, before)
    ]
    if len(changed) == 1 and changed[0][1]:
        axis, x, y = changed[0]
        for factor, text in ((1e3, "millimeters"), (10, "×10"), (0.1, "÷10"), (-1, "sign")):
            if _near(y, factor * x, x):
                return f"{text} of {axis} alone"
    return ""


def inertia_slip(mass: float, center: Array, before: Array, after: Array) -> str:
    """Return what a changed inertia looks like.

    Args:
        mass: of the link [kg].
        center: of mass in the link, shape (3,) [m].
        before: tensor about the center of mass, shape (3, 3) [kg·m²].
        after: the other.
    """
    return next(_inertia_slips(mass, center, before, after), "")


def _inertia_slips(mass: float, center: Array, before: Array, after: Array) -> Iterator[str]:
    for factor, text in (
        (1e6, "kg·mm² for kg·m²"),
        (1e-6, "kg·m² for kg·mm²"),
        (1e9, "g·mm² for kg·m²"),
        (1e-9, "kg·m² for g·mm²"),
        (1e3, "a factor of 1000"),
        (1e-3, "a factor of 1/1000"),
        (10.0, "a decimal point (×10)"),
        (0.1, "a decimal point (÷10)"),
        (0.0, "left out"),
    ):
        if _near(after, factor * before, after if factor else before):
            yield text
    lever = mass * (center @ center * np.eye(3) - np.outer(center, center))
    if lever.any() and _near(after, before + lever, after):
        yield "about the link's origin instead of the center of mass"
    if lever.any() and _near(after + lever, before, before):
        yield "about the center of mass of what was about the link's origin"
    flipped = 2 * np.diag(np.diag(before)) - before
    if _near(after, flipped, before):
        yield "products of inertia with the other sign"
    for signs in _SIGNS[:3]:
        mirror = np.diag(signs)
        if _near(after, mirror @ before @ mirror, before):
            yield f"mirrored ({'xyz'[signs.index(-1)]} with the other sign)"
    for order in permutations(range(3)):
        if order != (0, 1, 2) and _near(after, before[np.ix_(order, order)], before):
            yield f"axes exchanged ({', '.join('xyz'[k] for k in order)})"
    values = np.array(np.linalg.eigvalsh(before), dtype=float)
    if _near(values, np.array(np.linalg.eigvalsh(after), dtype=float), values):
        yield "the same principal moments about other axes"
    diagonal = np.diag(np.diag(before))
    if _near(after, diagonal, before):
        yield "products of inertia left out"
    yield from _entry_slips(before, after)


def _entry_slips(before: Array, after: Array) -> Iterator[str]:
    """Name the slip of a single entry of an inertia."""
    entries = [(i, k) for i in range(3) for k in range(i, 3)]
    changed = [(i, k) for i, k in entries if not _near(after[i, k], before[i, k], before)]
    if len(changed) != 1:
        return
    ((i, k),) = changed
    for factor, text in ((1e3, "×1000"), (1e-3, "÷1000"), (10, "×10"), (0.1, "÷10"), (-1, "sign")):
        if before[i, k] and _near(after[i, k], factor * before[i, k], after[i, k]):
            yield f"{text} of i{'xyz'[i]}{'xyz'[k]} alone"


def turn_slip(before: Array, after: Array) -> str:
    """Return what a changed orientation looks like.

    Args:
        before: roll, pitch, yaw [rad].
        after: the same of the other.
    """
    a = before
    found = _rotation(after)
    candidates = {
        "degrees for radians": np.degrees(a),
        "radians for degrees": np.radians(a),
        "left out": 0 * a,
        **{f"rpy in the order {', '.join(order)}": a[_places_in(order)] for order in _ORDERS},
        "roll with the other sign": a * [-1, 1, 1],
        "pitch with the other sign": a * [1, -1, 1],
        "yaw with the other sign": a * [1, 1, -1],
        "turns with the other sign": -a,
    }
    own = _rotation(before)
    like = [text for text, angles in candidates.items()
            if _near(found, _rotation(angles), np.eye(3))]  # fmt: skip
    swapped = Placement(rpy=(float(a[0]), 0, 0)), Placement(rpy=(0, float(a[1]), 0))
    x, y = (np.array(p.rotation, dtype=float) for p in swapped)
    z = np.array(Placement(rpy=(0, 0, float(a[2]))).rotation, dtype=float)
    if _near(found, x @ y @ z, np.eye(3)):
        like.append("turned about moving axes x, y, z instead of fixed ones")
    if not like and _near(found, own.T, np.eye(3)):
        like.append("the other way")
    if like:
        return ", or ".join(like[:_MOST_LIKE])
    for name, step in (("x", (1, 0, 0)), ("y", (0, 1, 0)), ("z", (0, 0, 1))):
        for angle in (np.pi / 2, -np.pi / 2, np.pi):
            turn = _rotation(np.array(step) * angle)
            if any(_near(found, r, np.eye(3)) for r in (own @ turn, turn @ own)):
                return f"{np.degrees(angle):+.0f}° about {name}"
    return ""


def axis_slip(before: Array, after: Array) -> str:
    """Return what a changed axis looks like."""
    if _near(after, -before, before):
        return "reversed"
    return vector_slip(before, after)


def place_slip(before: Array, after: Array) -> str:
    """Return what a changed limit or constant looks like, number by number."""
    for factor, text in (
        (np.degrees(1), "degrees for radians"),
        (np.radians(1), "radians for degrees"),
        (1e3, "a factor of 1000"),
        (-1.0, "the other sign"),
    ):
        if before.any() and _near(after, factor * before, after):
            return text
    if before.any() and _near(after, -before[::-1], before):
        return "the other sign, exchanged"
    return ""


def _places_in(order: str) -> list[int]:
    return list(map("rpy".index, order))


def _rotation(rpy: Array) -> Array:
    x, y, z = (float(angle) for angle in rpy)
    found: Array = np.array(Placement(rpy=(x, y, z)).rotation, dtype=float)
    return found


def _near(x: Array | float, y: Array | float, size: Array | float) -> bool:
    return bool(np.abs(np.asarray(x) - y).max() <= _CLOSE * np.abs(size).max())
