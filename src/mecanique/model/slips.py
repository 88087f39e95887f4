"""Slips in descriptions: another unit, sign, order, point or digit, each with its words, once.

Whoever compares descriptions recognizes them, whoever compares equations tries them, and whoever
judges formulas or files calls them by the same names. What explains a difference, in equations, in
a formula or in a file, is a `Cause`.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import permutations, product
from typing import NamedTuple, Protocol

import numpy as np

from mecanique.arrays import Array
from mecanique.model.placement import rpy_rotation


class Cause(Protocol):
    """What explains that something is wrong: in equations, in a formula, in a file."""

    @property
    def kind(self) -> str:
        """The kind of slip, e.g. "sign"."""

    @property
    def where(self) -> str:
        """The link, joint or coordinate, or the part of a formula; empty for the whole."""

    @property
    def text(self) -> str:
        """What is wrong, in words."""


class Factor(NamedTuple):
    """A number that a slip multiplies the right one by, its kind and its words."""

    factor: float
    kind: str
    text: str


class Slip(NamedTuple):
    """A slip in a position, a tensor or an orientation: its kind, its words, the wrong value."""

    kind: str
    text: str
    value: Array


DIGITS = (
    Factor(10.0, "digit", "a decimal point (×10)"),
    Factor(0.1, "digit", "a decimal point (÷10)"),
    Factor(100.0, "digit", "a decimal point (×100)"),
    Factor(0.01, "digit", "a decimal point (÷100)"),
)

GRAMS = (
    Factor(1e3, "mass unit", "grams for kilograms"),
    Factor(1e-3, "mass unit", "kilograms for grams"),
)
MASS = (*GRAMS, Factor(1 / 0.45359237, "mass unit", "pounds for kilograms"))

MILLIMETERS = (
    Factor(1e3, "length unit", "millimeters for meters"),
    Factor(1e-3, "length unit", "meters for millimeters"),
)
LENGTH = (
    *MILLIMETERS,
    Factor(100.0, "length unit", "centimeters for meters"),
    Factor(1 / 0.0254, "length unit", "inches for meters"),
    Factor(0.0254, "length unit", "meters for inches"),
)

INERTIA = (
    *GRAMS,
    Factor(1e6, "length unit", "kg·mm² for kg·m²"),
    Factor(1e-6, "length unit", "kg·m² for kg·mm²"),
    Factor(1e9, "unit", "g·mm² for kg·m²"),
    Factor(1e-9, "unit", "kg·m² for g·mm²"),
)

ANGLE = (
    Factor(math.degrees(1), "degree", "degrees for radians"),
    Factor(math.radians(1), "degree", "radians for degrees"),
)

LEFT_OUT = "left out"
TWICE = "counted twice"

ABOUT_ORIGIN = (
    "about the link's origin instead of the center of mass (parallel-axis term counted twice)"
)
ABOUT_CENTER = "about the center of mass instead of the link's origin (parallel-axis term missing)"


def say_factor(factor: float) -> str:
    """Return a power of ten as what it does: "×1000", "÷10⁶"."""
    size = factor if factor > 1 else 1 / factor
    power = round(math.log10(size))
    shown = f"{size:.6g}" if power < 4 else f"10{'⁰¹²³⁴⁵⁶⁷⁸⁹'[power]}"
    return f"{'×' if factor > 1 else '÷'}{shown}"


def lever_of(mass: float, center: Array) -> Array:
    """Return what the parallel-axis theorem adds to an inertia, shape (3, 3) [kg·m²]."""
    steiner: Array = mass * (center @ center * np.eye(3) - np.outer(center, center))
    return steiner


def mistake_vector(kind: str, vector: Array) -> Iterator[Slip]:
    """Yield a position or an axis with signs changed or its coordinates exchanged, each once."""
    signs = sorted(product((1, -1), repeat=3), key=lambda s: s.count(-1))
    mistakes = [
        (f"mirrored ({_name_axes(vector, s)} with the other sign)", np.array(s) * vector)
        for s in signs
    ]
    mistakes += [
        (f"axes exchanged ({_say(order)})", vector[list(order)]) for order in permutations(range(3))
    ]
    yield from list_once(kind, mistakes, vector, 1e-9 * float(np.abs(vector).max(initial=0.0)))


def _name_axes(vector: Array, signs: tuple[int, ...]) -> str:
    return ", ".join(n for n, s, x in zip("xyz", signs, vector, strict=True) if s < 0 and x)


def mistake_point(mass: float, center: Array, inertia: Array) -> Iterator[Slip]:
    """Yield an inertia about the link's origin for one about the center of mass, and back."""
    lever = lever_of(mass, center)
    if lever.any():
        yield Slip("parallel axis", ABOUT_CENTER, inertia - lever)
        yield Slip("parallel axis", ABOUT_ORIGIN, inertia + lever)


def mistake_products(inertia: Array) -> Iterator[Slip]:
    """Yield an inertia with products of the other sign, of all, of one or two, or left out."""
    off = inertia - np.diag(np.diag(inertia))
    if not off.any():
        return
    yield Slip("product sign", "products of inertia with the other sign", inertia - 2 * off)
    places = [(i, k) for i, k in ((0, 1), (0, 2), (1, 2)) if off[i, k]]
    if len(places) > 1:
        for i, k in places:
            wrong = inertia.copy()
            wrong[i, k] = wrong[k, i] = -inertia[i, k]
            text = f"product of inertia i{'xyz'[i]}{'xyz'[k]} with the other sign"
            yield Slip("product sign", text, wrong)
    yield Slip("product sign", "products of inertia left out", inertia - off)


def mistake_axes(inertia: Array) -> Iterator[Slip]:
    """Yield an inertia with its axes mirrored or exchanged, each tensor once."""
    # a tensor does not feel that all three axes point the other way
    signs = np.array([[1, 1, 1], [-1, 1, 1], [1, -1, 1], [1, 1, -1]])
    mistakes = []
    for order in permutations(range(3)):
        for sign in signs:
            P = np.eye(3)[list(order)] * sign
            said = ", ".join(f"{'−' if sign[k] < 0 else ''}{'xyz'[k]}" for k in order)
            text = f"axes exchanged ({said})"
            if order == (0, 1, 2):
                text = f"mirrored ({_name_axes(np.ones(3), tuple(sign))} with the other sign)"
            mistakes.append((text, P @ inertia @ P.T))
    yield from list_once("wrong axes", mistakes, inertia, 1e-12 * float(np.abs(inertia).max()))


def mistake_turn(rpy: Array) -> Iterator[Slip]:
    """Yield orientations, shape (3, 3), that roll, pitch and yaw were mistaken for, each once."""
    right = turn_of(rpy)
    for factor, kind, text in ANGLE:
        yield Slip(kind, text, turn_of(factor * rpy))
    yield Slip("frame", LEFT_OUT, np.eye(3))
    about = [turn_of(angle * axis) for angle, axis in zip(rpy, np.eye(3), strict=True)]
    mistakes = [
        (
            f"turned about moving axes {_say((i, j, k))} instead of fixed ones",
            about[i] @ about[j] @ about[k],
        )
        for i, j, k in permutations(range(3))
    ]
    for order in permutations(range(3)):
        said = ", ".join("rpy"[k] for k in order)
        mistakes.append((f"rpy in the order {said}", turn_of(rpy[list(order)])))
    names = ("roll", "pitch", "yaw")
    for signs in sorted(product((1, -1), repeat=3), key=lambda s: s.count(-1)):
        said = ", ".join(name for name, s in zip(names, signs, strict=True) if s < 0)
        mistakes.append((f"{said} with the other sign", turn_of(np.array(signs) * rpy)))
    mistakes.append(("turned back", right.T))
    yield from list_once("joint turn", mistakes, right, 1e-9)


def turn_of(rpy: Array) -> Array:
    """Return the rotation of roll, pitch and yaw, shape (3, 3)."""
    roll, pitch, yaw = (float(angle) for angle in rpy)
    R: Array = np.array(rpy_rotation((roll, pitch, yaw)), dtype=float)
    return R


def list_once(
    kind: str, candidates: list[tuple[str, Array]], right: Array, tolerance: float
) -> Iterator[Slip]:
    """Yield values that differ from the right one, and from those before."""
    seen = [right]
    for text, value in candidates:
        if all(np.abs(value - known).max() > tolerance for known in seen):
            seen.append(value)
            yield Slip(kind, text, value)


def _say(order: tuple[int, ...]) -> str:
    return ", ".join("xyz"[k] for k in order)
