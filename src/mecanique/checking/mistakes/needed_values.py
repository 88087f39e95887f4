"""Compute the value that each part of a formula needs for the whole to be right."""

from __future__ import annotations

import numpy as np

from mecanique.arrays import Array
from mecanique.checking.grammar.tape import Tape, Values


def needed_values(tape: Tape, values: Values, target: Array) -> list[Array]:
    """Return for each part the value that makes the whole equal a target, all else unchanged.

    The values follow from the whole to the parts, by inverting one operation after another; they
    are NaN where there is none, and within the arguments of functions.

    Args:
        tape: the formula.
        values: values of its parts, shape (n,).
        target: required values of the whole, shape (n,).
    """
    unknown = np.full_like(values.whole, np.nan)
    found: list[Array] = [unknown] * len(tape.nodes)
    found[-1] = np.broadcast_to(target, values.whole.shape)
    with np.errstate(all="ignore"):
        for k in range(len(tape.nodes) - 1, -1, -1):
            places = tape.parts[k]
            below = [values.parts[j] for j in places]
            parts = _undo(tape.nodes[k].kind, tape.nodes[k].name, values.parts[k], found[k], below)
            for place, part in zip(places, parts, strict=True):
                found[place] = unknown if part is None else part
    return found


def _undo(
    kind: str, name: str, value: Array, target: Array, below: list[Array]
) -> list[Array | None]:
    match kind:
        case "sum":
            return [target - (value - part) for part in below]
        case "negative":
            return [-target]
        case "product":
            rest: list[Array | None] = []
            for k in range(len(below)):
                others = np.ones_like(value)
                for j, factor in enumerate(below):
                    others = others * factor if j != k else others
                rest.append(target / others)
            return rest
        case "quotient":
            return [target * below[1], below[0] / target]
        case "power":
            return [_root(target, below), None]
        case "call" if name == "sqrt":
            return [target * target]
    return [None] * len(below)


def _root(target: Array, below: list[Array]) -> Array:
    """Return the base of a power; for an even exponent with the sign of the present base."""
    base, exponent = below
    size = np.abs(target) ** (1 / exponent)
    even = np.mod(exponent, 2) == 0
    odd = np.mod(exponent, 2) == 1
    signed = np.where(even, np.sign(base) * size, np.where(odd, np.sign(target) * size, size))
    return np.where((target < 0) & ~odd, np.nan, signed)
