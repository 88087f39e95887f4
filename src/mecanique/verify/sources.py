"""The forms of the in-house derivation that take part in a comparison."""

from __future__ import annotations

import numpy as np

from mecanique.derive.definition import Definition
from mecanique.derive.equations import Equations
from mecanique.derive.recursion import Recursion
from mecanique.model.mechanism import Mechanism
from mecanique.verify.compare import Dynamics
from mecanique.verify.states import States

__all__ = ["affordable", "in_house"]

_BUDGET = 2_500
"""Number of states times nv² that the jets are asked for."""


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


def affordable(name: str, states: States) -> States:
    """Return the states at which a form is evaluated: all, or the first ones if it is slow for a large mechanism.

    Args:
        name: of the form.
        states: all states.
    """
    most = max(3, _BUDGET // max(states.v.shape[1], 1) ** 2) if name == "jets" else len(states)
    return states.at(np.arange(min(most, len(states))))
