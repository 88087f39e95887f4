"""What can be written as code, by name: what it takes, gives and means."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

from mecanique.errors import InputError, UnknownNameError

__all__ = ["BY", "QUANTITIES", "Quantity", "choose", "derivative"]


@final
@dataclass(frozen=True)
class Quantity:
    """Something a program answers.

    Args:
        name: of its function.
        symbol: the letter of what it gives.
        takes: its arguments among t, y, q, v, a and tau; y is q and v in one.
        meaning: what it gives, in a few words.
        loops: whether only mechanisms with loops have it.
        by: of a derivative, what it is taken by: y, q, v, a, tau or p.
        base: of a derivative, the name of what is differentiated.
    """

    name: str
    symbol: str
    takes: tuple[str, ...]
    meaning: str
    loops: bool = False
    by: str = ""
    base: str = ""


QUANTITIES = {
    quantity.name: quantity
    for quantity in (
        Quantity("rhs", "dy", ("t", "y", "tau"), "rates of q, then of v"),
        Quantity("acceleration", "a", ("t", "q", "v", "tau"), "generalized accelerations"),
        Quantity("mass_matrix", "M", ("t", "q"), "mass matrix, row by row"),
        Quantity("bias", "h", ("t", "q", "v"), "Coriolis and centrifugal terms, and gravity"),
        Quantity("gravity", "g", ("t", "q"), "the part of the bias that gravity makes"),
        Quantity(
            "forces", "Q", ("t", "q", "v"), "generalized forces of springs, dampers, drives, loads"
        ),
        Quantity(
            "inverse_dynamics",
            "tau",
            ("t", "q", "v", "a"),
            "forces to add for accelerations a: M a + bias - forces",
        ),
        Quantity("energy", "E", ("t", "q", "v"), "kinetic energy, potential energy [J]"),
        Quantity("poses", "H", ("t", "q"), "rows of rotation and position of each body, 3 by 4"),
        Quantity(
            "jacobians",
            "J",
            ("t", "q"),
            "how each velocity moves each body: its origin, then its turn, world axes, 6 by nv",
        ),
        Quantity(
            "reactions",
            "R",
            ("t", "q", "v"),
            "force and moment on the child of each joint at its origin, then of loops; without tau",
        ),
        Quantity(
            "multipliers", "lambda", ("t", "q", "v", "tau"), "multipliers of the loops", loops=True
        ),
        Quantity(
            "closure", "Phi", ("t", "q", "v"), "what the loops miss: Phi, then its rate", loops=True
        ),
    )
}
"""Each quantity by its name."""


BY = {
    "q": "coordinates, along the motion that each velocity makes",
    "v": "velocities",
    "y": "coordinates, along the motion that each velocity makes, and velocities",
    "a": "accelerations",
    "tau": "torques",
    "p": "parameters",
}
"""What quantities can be differentiated by."""


def derivative(name: str) -> Quantity | None:
    """Return the derivative that a name like "acceleration_by_q" means, if it means one.

    Args:
        name: a quantity's, "_by_" and an argument's.
    """
    base, separator, by = name.rpartition("_by_")
    quantity = QUANTITIES.get(base)
    if not separator or quantity is None or by not in BY:
        return None
    state = {"y", *quantity.takes} if {"q", "v"} <= set(quantity.takes) else set(quantity.takes)
    state |= {"q", "v"} if "y" in quantity.takes else set()
    if by != "p" and by not in state:
        return None
    meaning = f"derivatives of {base} by {BY[by]}, row by row"
    return Quantity(name, f"d{quantity.symbol}", quantity.takes, meaning, quantity.loops, by, base)


def choose(what: str | Sequence[str], *, loops: bool) -> tuple[Quantity, ...]:
    """Return the quantities that are named.

    Args:
        what: their names, in a sequence or with commas between.
        loops: whether the mechanism has loops.

    Raises:
        InputError: if none is named, one is named twice, or one belongs to loops and there is none.
        UnknownNameError: if a name is no quantity.
    """
    names = [name.strip() for name in what.split(",")] if isinstance(what, str) else list(what)
    known = [name for name, quantity in QUANTITIES.items() if loops or not quantity.loops]
    found = []
    for name in names:
        quantity = QUANTITIES.get(name) or derivative(name)
        if quantity is None:
            raise UnknownNameError("quantity", name, known)
        if loops and quantity.by not in ("", "a", "tau"):
            raise InputError(
                f"expected no loops for {name!r}: positions next to a closed one are not closed"
            )
        found.append(quantity)
        if quantity.loops and not loops:
            raise InputError(f"expected a mechanism with loops for {name!r}; this one has none")
    if not names or len(set(names)) < len(names):
        raise InputError(f"expected names of quantities, each once, got {what!r}")
    return tuple(found)
