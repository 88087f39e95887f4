"""The forms of the in-house derivation that take part in a comparison."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, final

import numpy as np

from mecanique.derivation import derive
from mecanique.derivation.equations import Equations
from mecanique.derivation.numeric.independent import Reduced
from mecanique.derivation.numeric.lagrange import Definition
from mecanique.derivation.states import States as DerivedStates
from mecanique.derivation.symbolic.derivation import Derivation
from mecanique.derivation.symbolic.springs import Assumption
from mecanique.errors import DerivationError
from mecanique.model.mechanism import Mechanism
from mecanique.verification.closed_form import ClosedForm
from mecanique.verification.compare import Array, Dynamics
from mecanique.verification.states.random import States, characteristic_length

__all__ = [
    "InHouse",
    "affordable",
    "computed",
    "cut_free",
    "in_house",
    "independent",
    "is_light",
    "transmitted",
]

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
    forms = computed(mechanism, symbols)
    if mechanism.nv > _READABLE:
        return InHouse(
            forms, notes=(f"left out: the closed form, made for at most {_READABLE} velocities",)
        )
    if not symbols.symbolic:
        return InHouse(forms, notes=(f"left out: the closed form ({symbols.why_not})",))
    forms["closed form"] = ClosedForm(mechanism, symbols.derivation)
    return InHouse(forms, symbols.derivation.assumptions)


def computed(
    mechanism: Mechanism, symbols: Equations | None = None, *, quick: bool = False
) -> dict[str, Dynamics]:
    """Return the forms that only give numbers, by name.

    Args:
        mechanism: what to derive.
        symbols: its equations, if they are there already.
        quick: whether only the definition, as jets, and the fast recursion are asked for.
    """
    jets = Equations(mechanism, "definition", Definition(mechanism), _no_symbols)
    both: dict[str, Dynamics] = {
        "jets": jets,
        "recursion": derive(mechanism) if symbols is None else symbols,
    }
    if quick:
        return both
    return {
        **both,
        "Newton-Euler": derive(mechanism, "newton_euler"),
        "virtual work": derive(mechanism, "virtual_work"),
    }


def cut_free(ours: InHouse) -> Equations:
    """Return the form that shows the reactions.

    Args:
        ours: all forms.
    """
    form = ours.forms["Newton-Euler"]
    assert isinstance(form, Equations)
    return form


def transmitted(mechanism: Mechanism, states: States, wrenches: Mapping[str, Any]) -> Array:
    """Return the reactions of all joints as one vector, shape (n, 6 · joints); moments per characteristic length.

    Args:
        mechanism: whose joints.
        states: where.
        wrenches: `force` and `moment` of each joint, each shape (n, 3), by name.
    """
    length = characteristic_length(mechanism)
    parts: list[Array] = []
    for joint in mechanism.joints:
        wrench = wrenches.get(joint.name)
        if wrench is None:  # a source that knows another mechanism
            parts.append(np.full((len(states), 6), np.nan))
        else:
            parts += [np.asarray(wrench.force), np.asarray(wrench.moment) / length]
    return np.concatenate([np.zeros((len(states), 0)), *parts], axis=1)


def independent(
    mechanism: Mechanism, states: States
) -> tuple[Mapping[str, Array], tuple[str, ...]]:
    """Return the accelerations of a closed mechanism in as many coordinates as it has freedoms, and what is left out.

    Args:
        mechanism: a mechanism with loops.
        states: where; the loops closed.
    """
    try:
        reduced = Reduced(mechanism)
    except DerivationError as error:
        return {}, (f"left out: the equations in independent coordinates ({error})",)
    at = DerivedStates.of(mechanism, states.q, states.v, states.t)
    return {"acceleration": reduced.acceleration(at)}, ()


def affordable(name: str, states: States) -> States:
    """Return the states at which a form is evaluated: all, or the first ones if it is slow for a large mechanism.

    Args:
        name: of the form.
        states: all states.
    """
    most = max(3, _BUDGET // max(states.v.shape[1], 1) ** 2) if name == "jets" else len(states)
    return states.at(np.arange(min(most, len(states))))


def is_light(name: str, mechanism: Mechanism) -> bool:
    """Return whether a form is not asked for the mass matrix, because that would take it too long.

    Args:
        name: of the form.
        mechanism: what is compared.
    """
    return name == "jets" and mechanism.nv > _READABLE


def _no_symbols() -> Derivation:
    raise DerivationError("Lagrange's operator on jets gives numbers only")
