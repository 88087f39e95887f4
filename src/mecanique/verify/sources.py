"""The forms of the in-house derivation that take part in a comparison."""

from __future__ import annotations

from mecanique.derive.definition import Definition
from mecanique.derive.equations import Equations
from mecanique.derive.recursion import Recursion
from mecanique.model.mechanism import Mechanism
from mecanique.verify.compare import Dynamics

__all__ = ["in_house"]


def in_house(mechanism: Mechanism) -> tuple[dict[str, Dynamics], tuple[str, ...]]:
    """Return every form of the in-house derivation that can treat a mechanism, by name, and what was left out.

    Args:
        mechanism: what to derive.
    """
    forms: dict[str, Dynamics] = {
        "jets": Equations(mechanism, "definition", Definition(mechanism)),
        "recursion": Equations(mechanism, "recursion", Recursion(mechanism)),
    }
    return forms, ()
