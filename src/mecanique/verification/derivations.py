"""The forms of the in-house derivation that take part in a comparison."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, final

import numpy as np

from mecanique.arrays import Array
from mecanique.derivation import derive
from mecanique.derivation.equations import Equations
from mecanique.derivation.numeric.constraints.independent import Reduced
from mecanique.derivation.numeric.constraints.loops import RowUnits
from mecanique.derivation.numeric.constraints.multipliers import solve_held
from mecanique.derivation.numeric.lagrange import LagrangeOnJets
from mecanique.derivation.scalars.evaluation import Evaluation
from mecanique.derivation.scalars.series import Series
from mecanique.derivation.symbolic.derivation import Assumption, Derivation
from mecanique.errors import DerivationError
from mecanique.model.constraints.contacts import row_names
from mecanique.model.mechanism import Mechanism
from mecanique.model.mechanism_units import characteristic_length
from mecanique.model.random_positions import angles
from mecanique.model.states import States
from mecanique.model.values import Given
from mecanique.reference import Reference
from mecanique.verification.rows import DynamicsSource


@final
class ClosedForm:
    """The series of a symbolic derivation, evaluated at n states at once."""

    def __init__(self, mechanism: Mechanism, derivation: Derivation) -> None:
        self._mechanism = mechanism
        self._derivation = derivation

    def mass_matrix(self, q: Given, t: Any = 0.0) -> Array:
        """Return M, shape (n, nv, nv); q (n, nq), t () or (n,)."""
        size = self._mechanism.nv
        entries = self._evaluate([m for row in self._derivation.M for m in row], q, None, t)
        return entries.reshape(len(entries), size, size)

    def bias(self, q: Given, v: Given, t: Any = 0.0) -> Array:
        """Return h, shape (n, nv); q (n, nq), v (n, nv), t () or (n,)."""
        return self._evaluate(self._derivation.h, q, v, t)

    def forces(self, q: Given, v: Given, t: Any = 0.0) -> Array:
        """Return Q, shape (n, nv); q (n, nq), v (n, nv), t () or (n,)."""
        return self._evaluate(self._derivation.Q, q, v, t)

    def acceleration(self, q: Given, v: Given, t: Any = 0.0) -> Array:
        """Return the solution a of M a + h = Q + Σ λ ∂Φ/∂q and Φ'' = 0, shape (n, nv).

        It is not a number where there is none.

        Shapes: q (n, nq), v (n, nv), t () or (n,).
        """
        mass, rest = self.mass_matrix(q, t), self.forces(q, v, t) - self.bias(q, v, t)
        if self._derivation.ties:
            return self._hold(mass, rest, q, v, t)
        try:
            return np.asarray(np.linalg.solve(mass, rest[..., None])[..., 0])
        except np.linalg.LinAlgError:
            return np.full(rest.shape, np.nan)

    def _hold(self, mass: Array, rest: Array, q: Given, v: Given, t: Any) -> Array:
        """Return the accelerations that the loops leave, by the least multipliers."""
        algebra, ties = self._derivation.algebra, self._derivation.ties
        # Φ'' = J a + γ
        second = [tie.second.linear(algebra.accelerations) for tie in ties]
        J = self._evaluate([entry for row, _ in second for entry in row], q, v, t)
        gamma = self._evaluate([gamma for _, gamma in second], q, v, t)
        J = J.reshape(*gamma.shape, mass.shape[-1])
        angular, length = angles(self._mechanism), characteristic_length(self._mechanism)
        units = np.array(
            [1.0 if name in angular else length for name in self._mechanism.velocities]
        )
        if self._derivation.quasi:
            return self._reduce(mass, rest, J, gamma, units, q, t)
        rows = RowUnits(np.ones(len(ties)), np.arange(len(ties)))
        held = np.full(rest.shape, np.nan)
        known = np.isfinite(J).all(axis=(1, 2)) & np.isfinite(gamma).all(axis=1)
        for k in np.flatnonzero(known):
            motion = solve_held(mass[k], rest[k], J[k], gamma[k], units, rows)
            held[k] = motion.acceleration
        return held

    def _reduce(
        self,
        mass: Array,
        rest: Array,
        J: Array,
        gamma: Array,
        units: Array,
        q: Given,
        t: Any,
    ) -> Array:
        """Return the accelerations by the equations along independent displacements."""
        quasi = self._derivation.quasi
        S = self._evaluate([entry for column in quasi for entry in column], q, None, t)
        S = S.reshape(len(S), len(quasi), mass.shape[-1])
        rows = np.concatenate([S @ mass, J], axis=1)
        sides = np.concatenate([(S @ rest[..., None])[..., 0], -gamma], axis=1)
        reduced = []
        for matrix, side in zip(rows, sides, strict=True):
            columns = matrix * units
            sizes = np.abs(columns).max(axis=1, keepdims=True)
            sizes[sizes == 0] = 1.0
            rows_alike, sides_alike = columns / sizes, side / sizes[:, 0]
            y = np.linalg.lstsq(rows_alike, sides_alike, rcond=None)[0]
            # once more, for what is left: terms of very different sizes lose digits
            y += np.linalg.lstsq(rows_alike, sides_alike - rows_alike @ y, rcond=None)[0]
            reduced.append(units * y)
        return np.array(reduced)

    def energy(self, q: Given, v: Given, t: Any = 0.0) -> tuple[Array, ...]:
        """Return the kinetic and the potential energy, each shape (n,) [J]; none if not stated.

        Shapes: q (n, nq), v (n, nv), t () or (n,).
        """
        return tuple(self._evaluate(self._derivation.energies, q, v, t).T)

    def _evaluate(self, series: Sequence[Series], q: Given, v: Given, t: Any) -> Array:
        states = States.of(self._mechanism, q, v, t)
        with np.errstate(all="ignore"):
            value = Evaluation(self._derivation.algebra.ring, states.values)
            columns = [np.broadcast_to(value(entry), (len(states),)) for entry in series]
        return np.stack(columns, axis=-1).astype(float) if columns else np.zeros((len(states), 0))


_BUDGET = 3_600
"""Number of states times nv² that the jets are asked for."""

_READABLE = 12
"""Mechanisms with more velocities than this are not derived in closed form: it would fill books."""


@final
@dataclass(frozen=True)
class InHouse:
    """The in-house derivation of one mechanism."""

    forms: dict[str, DynamicsSource]
    assumptions: tuple[Assumption, ...] = ()  # what the closed form takes for granted
    notes: tuple[str, ...] = ()  # what was left out, and why


def derive_all(mechanism: Mechanism) -> InHouse:
    """Derive the equations of a mechanism in every form that can treat it."""
    symbols = derive(mechanism)
    forms: dict[str, DynamicsSource] = {
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
    """Return which components redundant contacts leave undetermined, shape (n, 6 · joints)."""
    closed, count = engine.closed, len(engine.mechanism.joints)
    assert closed is not None, "the mechanism has contacts"
    parts = [
        closed.undetermined(q, t)[:count].reshape(-1)
        for q, t in zip(states.q, states.t.tolist(), strict=True)
    ]
    return np.array(parts)


def contact_forces(source: DynamicsSource, engine: Reference, states: States) -> Array:
    """Return the forces of all contacts at n states, by row; those undetermined are zero."""
    assert isinstance(source, (Equations, Reference))
    mechanism, closed = engine.mechanism, engine.closed
    assert closed is not None, "the mechanism has contacts"
    multipliers = source.multipliers(states.q, states.v, states.t)
    of_contacts = np.array([name in row_names(mechanism.contacts) for name in multipliers])
    columns = np.stack(list(multipliers.values()), axis=-1)
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
    return Equations(mechanism, "definition", title, LagrangeOnJets(mechanism), _no_symbols)


def _no_symbols() -> Derivation:
    raise DerivationError("Lagrange's operator on jets gives numbers only")
