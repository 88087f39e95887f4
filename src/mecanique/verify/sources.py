"""The forms of the in-house derivation that take part in a comparison."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np

from mecanique.derive import derive
from mecanique.derive.definition import Definition
from mecanique.derive.derivation import Derivation
from mecanique.derive.equations import Equations
from mecanique.derive.springs import Assumption
from mecanique.errors import DerivationError
from mecanique.model.mechanism import Mechanism
from mecanique.verify.closed_form import ClosedForm
from mecanique.verify.compare import Dynamics
from mecanique.verify.states import States

__all__ = ["InHouse", "affordable", "in_house"]

_BUDGET = 3_600
"""Number of states times nv² that the jets are asked for."""

_READABLE = 12
"""Closed forms of mechanisms with more velocities than this are not even tried: they fill books."""


@final
@dataclass(frozen=True)
class InHouse:
    """The in-house derivation of one mechanism.

    Args:
        forms: its forms, by name.
        assumptions: what the closed form takes for granted.
        notes: what was left out, and why.
    """

    forms: dict[str, Dynamics]
    assumptions: tuple[Assumption, ...] = ()
    notes: tuple[str, ...] = ()


def in_house(mechanism: Mechanism) -> InHouse:
    """Return every form of the in-house derivation that can treat a mechanism.

    Args:
        mechanism: what to derive.
    """
    symbols = derive(mechanism)
    forms: dict[str, Dynamics] = {
        "jets": Equations(mechanism, "definition", Definition(mechanism), _no_symbols),
        "recursion": symbols,
    }
    if mechanism.nv > _READABLE:
        return InHouse(forms, notes=(f"left out: the closed form, made for at most {_READABLE} velocities",))
    if not symbols.symbolic:
        return InHouse(forms, notes=(f"left out: the closed form ({symbols.why_not})",))
    forms["closed form"] = ClosedForm(mechanism, symbols.derivation)
    return InHouse(forms, symbols.derivation.assumptions)


def affordable(name: str, states: States) -> States:
    """Return the states at which a form is evaluated: all, or the first ones if it is slow for a large mechanism.

    Args:
        name: of the form.
        states: all states.
    """
    most = max(3, _BUDGET // max(states.v.shape[1], 1) ** 2) if name == "jets" else len(states)
    return states.at(np.arange(min(most, len(states))))


def _no_symbols() -> Derivation:
    raise DerivationError("Lagrange's operator on jets gives numbers only")
