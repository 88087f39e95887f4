"""What can be written as code, by name: what it takes, gives and means."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

from mecanique.errors import InputError, UnknownNameError

__all__ = ["QUANTITIES", "Quantity", "choose"]


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
    """

    name: str
    symbol: str
    takes: tuple[str, ...]
    meaning: str
    loops: bool = False


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
            "multipliers", "lambda", ("t", "q", "v", "tau"), "multipliers of the loops", loops=True
        ),
        Quantity(
            "closure", "Phi", ("t", "q", "v"), "what the loops miss: Phi, then its rate", loops=True
        ),
    )
}
"""Each quantity by its name."""


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
    for name in names:
        if name not in QUANTITIES:
            raise UnknownNameError("quantity", name, known)
        if name not in known:
            raise InputError(f"expected a mechanism with loops for {name!r}; this one has none")
    if not names or len(set(names)) < len(names):
        raise InputError(f"expected names of quantities, each once, got {what!r}")
    return tuple(QUANTITIES[name] for name in names)
