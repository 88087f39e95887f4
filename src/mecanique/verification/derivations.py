"""The forms of the in-house derivation that take part in a comparison."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np

from mecanique.arrays import Array
from mecanique.derivation import derive
from mecanique.derivation.equations import Equations
from mecanique.derivation.numeric.constraints.independent import Reduced
from mecanique.derivation.numeric.lagrange import Definition
from mecanique.derivation.symbolic.derivation import Assumption, Derivation
from mecanique.errors import DerivationError
from mecanique.model.constraints.contacts import row_names
from mecanique.model.mechanism import Mechanism
from mecanique.model.states import States
from mecanique.model.units import characteristic_length
from mecanique.reference import Reference
from mecanique.verification.closed_form import ClosedForm
from mecanique.verification.rows import Dynamics

_BUDGET = 3_600
"""Number of states times nv² that the jets are asked for."""

_READABLE = 12
"""Mechanisms with more velocities than this are not derived in closed form: it would fill books."""


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


def derive_all(mechanism: Mechanism) -> InHouse:
    """Derive the equations of a mechanism in every form that can treat it."""
    symbols = derive(mechanism)
    forms: dict[str, Dynamics] = {
        "jets": _jets(mechanism),
        "recursion": symbols,
        "Newton-Euler": derive(mechanism, "newton_euler"),
        "virtual work": derive(mechanism, "virtual_work"),
    }
    if mechanism.nv > _READABLE:
        note = f"left out: the closed form, made for at most {_READABLE} velocities"
        return InHouse(forms, notes=(note,))
    if not symbols.symbolic:
        return InHouse(forms, notes=(f"left out: the closed form ({symbols.why_not})",))
    forms["closed form"] = ClosedForm(mechanism, symbols.derivation)
    if mechanism.loops:
        for name in ("Newton-Euler", "virtual work"):
            form = forms[name]
            if isinstance(form, Equations) and form.symbolic:
                forms[f"{name}, closed form"] = ClosedForm(mechanism, form.derivation)
    return InHouse(forms, symbols.derivation.assumptions)


def derive_quickly(mechanism: Mechanism) -> InHouse:
    """Derive the equations by the definition, on jets, and by the fast recursion alone."""
    return InHouse({"jets": _jets(mechanism), "recursion": derive(mechanism)})


def balances(ours: InHouse) -> Equations:
    """Return the form that gives the reactions: Newton and Euler's balances."""
    form = ours.forms["Newton-Euler"]
    assert isinstance(form, Equations)
    return form


def reactions(source: Equations | Reference, mechanism: Mechanism, states: States) -> Array:
    """Return the reactions of all joints as one vector, shape (n, 6 · joints).

    It is the total of each joint, with what guides across it; forces of elements follow. Moments
    are divided by the characteristic length; those of a joint that the source does not know are not
    numbers.
    """
    wrenches = source.totals(states.q, states.v, states.t)
    length = characteristic_length(mechanism)
    parts: list[Array] = [np.zeros((len(states), 0))]
    for joint in mechanism.joints:
        wrench = wrenches.get(joint.name)
        if wrench is None:
            parts.append(np.full((len(states), 6), np.nan))
        else:
            parts += [np.asarray(wrench.force), np.asarray(wrench.moment) / length]
    if mechanism.elements:
        forces = source.guide_forces(states.q, states.v, states.t)
        parts += [np.nan_to_num(np.asarray(force))[:, None] for force in forces.values()]
    return np.concatenate(parts, axis=1)


def shared_reactions(engine: Reference, states: States) -> Array:
    """Return which components redundant contacts leave undetermined, shape (n, 6 · joints).

    Args:
        engine: the mechanism inside the engine.
        states: n states.
    """
    closed, count = engine.closed, len(engine.mechanism.joints)
    assert closed is not None, "the mechanism has contacts"
    found = [
        closed.undetermined(q, t)[:count].reshape(-1)
        for q, t in zip(states.q, states.t.tolist(), strict=True)
    ]
    return np.array(found)


def contact_forces(source: Dynamics, engine: Reference, states: States) -> Array:
    """Return the forces of all contacts at n states, by row; those undetermined are zero.

    Args:
        source: the equations, or the engine itself.
        engine: knows which are determined.
        states: n states.
    """
    assert isinstance(source, (Equations, Reference))
    mechanism, closed = engine.mechanism, engine.closed
    assert closed is not None, "the mechanism has contacts"
    found = source.multipliers(states.q, states.v, states.t)
    of_contacts = np.array([name in row_names(mechanism.contacts) for name in found])
    columns = np.stack(list(found.values()), axis=-1)
    determined = [
        closed.solve(q, v, t).determined
        for q, v, t in zip(states.q, states.v, states.t.tolist(), strict=True)
    ]
    kept: Array = np.where(determined, columns, 0.0)[:, of_contacts]
    return kept


def independent_accelerations(
    mechanism: Mechanism, states: States
) -> tuple[dict[str, Array], tuple[str, ...]]:
    """Return the accelerations from equations in independent coordinates, and what was left out."""
    try:
        reduced = Reduced(mechanism)
    except DerivationError as error:
        return {}, (f"left out: the equations in independent coordinates ({error})",)
    return {"acceleration": reduced.acceleration(states)}, ()


def regularity(mechanism: Mechanism, states: States) -> Array:
    """Return how regular the choice of independent coordinates is in each state, shape (n,)."""
    return np.asarray(Reduced(mechanism).regularity(states))


def affordable(name: str, states: States) -> States:
    """Return the states at which a form is evaluated: only the first ones if it is slow."""
    most = max(3, _BUDGET // max(states.v.shape[1], 1) ** 2) if name == "jets" else len(states)
    return states.at(np.arange(min(most, len(states))))


def is_light(name: str, mechanism: Mechanism) -> bool:
    """Return whether a form's mass matrix would take too long and is left out."""
    return name == "jets" and mechanism.nv > _READABLE


def _jets(mechanism: Mechanism) -> Equations:
    title = "Lagrange's operator on jets"
    return Equations(mechanism, "definition", title, Definition(mechanism), _no_symbols)


def _no_symbols() -> Derivation:
    raise DerivationError("Lagrange's operator on jets gives numbers only")
