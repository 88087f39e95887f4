"""Evaluate every source at the same states and compare them with the engine."""

from __future__ import annotations

import platform
from collections.abc import Mapping
from importlib.metadata import PackageNotFoundError, version
from typing import Any, Protocol, TypeAlias, runtime_checkable

import numpy as np
import numpy.typing as npt

from mecanique.model.mechanism import Mechanism
from mecanique.verification.difference import QUANTITIES, relative_difference, scaled
from mecanique.verification.states.random import States, random_states
from mecanique.verification.verdict import Row, Verdict

__all__ = ["TOLERANCE", "Dynamics", "Values", "Whole", "rows_of", "values_of", "versions"]

Array = npt.NDArray[np.float64]
Values: TypeAlias = Mapping[str, Array]
"""What one source gives at all states: quantity -> shape (n, …)."""

TOLERANCE = 1e-9
"""Largest relative difference that counts as agreement."""

_BY_WEIGHT = ("kinetic energy", "potential energy", "momentum", "angular momentum", "reactions")
"""What grows with the mass, when 1 m/s, or 1 m/s², is all that moves it."""


class Dynamics(Protocol):
    """What a source of equations of motion answers at n states at once."""

    def mass_matrix(self, q: Any, t: Any = 0.0) -> Any:
        """M."""

    def bias(self, q: Any, v: Any, t: Any = 0.0) -> Any:
        """Inertia forces that do not depend on accelerations, and gravity."""

    def forces(self, q: Any, v: Any, t: Any = 0.0) -> Any:
        """Generalized forces."""

    def acceleration(self, q: Any, v: Any, t: Any = 0.0) -> Any:
        """Generalized accelerations."""

    def energy(self, q: Any, v: Any, t: Any = 0.0) -> Any:
        """Kinetic energy, then potential energy in one or several parts."""


@runtime_checkable
class Whole(Dynamics, Protocol):
    """What a source answers that knows its bodies as well."""

    def gravity(self, q: Any, t: Any = 0.0) -> Any:
        """Part of the bias that gravity makes."""

    def inverse_dynamics(self, q: Any, v: Any, a: Any, t: Any = 0.0) -> Any:
        """M a + bias − forces."""

    def momentum(self, q: Any, v: Any, t: Any = 0.0) -> Any:
        """Momentum, angular momentum about the origin, the same about the center of mass."""


def compared(mechanism: Mechanism, samples: int, seed: int, *, quick: bool = False) -> Verdict:
    """Compare every form of the in-house derivation with the engine.

    Args:
        mechanism: what to verify.
        samples: number of random states.
        seed: of the random states.
        quick: whether only the jets and the recursion take part, and no reactions.
    """
    from mecanique.reference import Reference
    from mecanique.verification.forms import (
        InHouse,
        affordable,
        computed,
        cut_free,
        in_house,
        independent,
        is_light,
        transmitted,
    )

    ours = InHouse(computed(mechanism, quick=True)) if quick else in_house(mechanism)
    states, notes = random_states(mechanism, samples, seed, ours.assumptions), ours.notes
    engine = Reference(mechanism)
    theirs = values_of(engine, states)
    rows: list[Row] = []
    for name, form in ours.forms.items():
        some = affordable(name, states)
        light = is_light(name, mechanism)
        if len(some) < len(states):
            most = f"{name}: at the first {len(some)} states only{', without the mass matrix' if light else ''}"
            notes = (*notes, f"{most}, their cost grows with the cube of the size")
        at_some = {quantity: values[: len(some)] for quantity, values in theirs.items()}
        rows += rows_of(
            (name, "Pinocchio"), values_of(form, some, light=light), at_some, some, mechanism
        )
    if not mechanism.loops and not quick:
        found = [
            source.reactions(states.q, states.v, states.t) for source in (cut_free(ours), engine)
        ]
        mine, its = ({"reactions": transmitted(mechanism, states, one)} for one in found)
        rows += rows_of(("Newton-Euler", "Pinocchio"), mine, {**theirs, **its}, states, mechanism)
    if mechanism.loops:
        more, remarks = independent(mechanism, states)
        rows += rows_of(("independent coordinates", "Pinocchio"), more, theirs, states, mechanism)
        notes = (*notes, *remarks)
    return Verdict(
        mechanism.name,
        tuple(sorted(rows, key=lambda row: QUANTITIES.index(row.quantity))),
        len(states),
        seed,
        TOLERANCE,
        mechanism.coordinates.names,
        mechanism.velocities,
        versions(),
        notes,
    )


def values_of(source: Dynamics, states: States, *, light: bool = False) -> dict[str, Array]:
    """Evaluate a source at all states.

    Args:
        source: what gives the values.
        states: where.
        light: whether to leave out the mass matrix, and the accelerations that follow from it.
    """
    q, v, t = states.q, states.v, states.t
    kinetic, *potential = source.energy(q, v, t)
    given = {
        "bias": source.bias(q, v, t),
        "forces": source.forces(q, v, t),
        "kinetic energy": kinetic,
        "potential energy": sum(potential[1:], potential[0]),
    }
    if not light:
        given["mass matrix"] = source.mass_matrix(q, t)
    if not light:
        given["acceleration"] = source.acceleration(q, v, t)
    if isinstance(source, Whole):
        momentum, _, about_center = source.momentum(q, v, t)
        given |= {
            "gravity": source.gravity(q, t),
            "inverse dynamics": source.inverse_dynamics(q, v, states.a, t),
            "momentum": momentum,
            "angular momentum": about_center,
        }
    return {quantity: np.asarray(value, dtype=float) for quantity, value in given.items()}


def rows_of(
    names: tuple[str, str], ours: Values, theirs: Values, states: States, mechanism: Mechanism
) -> tuple[Row, ...]:
    """Compare two sources quantity by quantity.

    Args:
        names: of the two sources.
        ours: values of the first.
        theirs: values of the second; its mass matrix sets the scale.
        states: where they were evaluated.
        mechanism: whose values they are.
    """
    moving = (body for body in mechanism.bodies if body.name != mechanism.ground)
    weight = sum(max(mechanism.evaluate(body.mass), 0.0) for body in moving) or 1.0
    rows = []
    for quantity in (name for name in QUANTITIES if name in ours):
        x, y = (
            scaled(quantity, values[quantity], theirs["mass matrix"]) for values in (ours, theirs)
        )
        least = (
            1.0 if quantity == "mass matrix" else weight if quantity in _BY_WEIGHT else weight**0.5
        )
        difference, remark = relative_difference(x, y, least), ""
        if quantity == "potential energy" and difference.max() > TOLERANCE:
            # a potential is known up to a constant only; differences decide
            offset, middle = float(np.median(x - y)), float(np.median(y))
            shifted = relative_difference(x - offset - middle, y - middle, least)
            if shifted.max() <= TOLERANCE:
                difference, remark = (
                    shifted,
                    f"up to a constant of {offset:.6g} J, which no equation of motion sees",
                )
        at = int(np.argmax(difference))
        for name, values in zip(names, (ours, theirs), strict=True):
            bad = int(
                np.count_nonzero(
                    ~np.isfinite(values[quantity].reshape(len(states), -1)).all(axis=1)
                )
            )
            if bad:
                remark = f"{name} is not finite at {bad} of {len(states)} states"
        state = (tuple(states.q[at].tolist()), tuple(states.v[at].tolist()), float(states.t[at]))
        rows.append(Row(quantity, names, float(difference[at]), *state, remark))
    return tuple(rows)


def versions() -> dict[str, str]:
    """Return the versions of what takes part, by name."""
    found = {"python": platform.python_version()}
    for package in ("mecanique", "pin", "numpy"):
        try:
            found[package] = version(package)
        except PackageNotFoundError:
            found[package] = "unknown"
    return dict(sorted(found.items()))
