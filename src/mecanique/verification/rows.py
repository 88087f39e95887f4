"""Evaluate two sources at the same states and compare them quantity by quantity.

Entries of one vector have different units as soon as angles and lengths are mixed, and a small
finger would vanish beside a heavy trunk. So they are made alike first, with d_i = √M_ii of the
engine's mass matrix:

- mass matrix: M_ij / (d_i d_j),
- bias, gravity, inverse dynamics and generalized forces: f_i / d_i,
- acceleration: a_i d_i,
- energies and momenta: as they are.

Of the mass matrix each entry is judged by itself, on its own scale d_i d_j, so that a light part is
seen wherever it moves with little else; of bias and gravity each entry is judged beside the whole
vector (`mecanique.verification.rounding` has what rounding may make of each). Otherwise the
relative difference of x and y at a state is ‖x − y‖ / max(‖x‖, ‖y‖, floor). The floor keeps a
value that happens to pass through zero from being judged against its own rounding errors: a
thousandth of the root mean square of ‖y‖ over all states, and not less than a thousandth of what 1
m/s² or 1 m/s makes of the moving mass.

What is solved for may differ by more than a fixed tolerance at states where rounding alone explains
it; `mecanique.verification.rounding` has the bound.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Protocol, TypeAlias, runtime_checkable

import numpy as np

from mecanique.arrays import Array, median
from mecanique.model.mechanism import Mechanism
from mecanique.model.states import States
from mecanique.verification.verdict import SOLVED_ALIKE, Row
from mecanique.wording import say_count

QUANTITIES = (
    "mass matrix",
    "bias",
    "gravity",
    "forces",
    "inverse dynamics",
    "acceleration",
    "kinetic energy",
    "potential energy",
    "momentum",
    "angular momentum",
    "reactions",
    "contact forces",
)
"""What is compared, in the order of the table."""

OF_ELEMENTS = "forces of elements"
"""What is compared besides the accelerations in each mode of what switches."""

IMPACT_MOMENTUM = "momentum about contacts"
"""What an impact leaves as it is."""

SMALL = 1e-3
"""Part of the typical size below which a value is judged against the typical size."""

_MOST = 1e-3
"""The largest relative difference that rounding excuses."""


def scales(mass: Array) -> Array:
    """Return d_i = √M_ii at each state, shape (n, nv); 1 where a velocity moves no mass."""
    diagonal = np.diagonal(mass, axis1=1, axis2=2)
    return np.sqrt(np.where(np.isfinite(diagonal) & (diagonal > 0), diagonal, 1.0))


def scale(quantity: str, values: Array, mass: Array) -> Array:
    """Return values (n, …) as vectors whose entries have one unit, shape (n, any)."""
    d = scales(mass)
    match quantity:
        case "mass matrix":
            values = values / (d[:, :, None] * d[:, None, :])
        case "bias" | "gravity" | "forces" | "inverse dynamics":
            values = values / d
        case "acceleration":
            values = values * d
    return values.reshape(len(values), -1)


def relative_difference(x: Array, y: Array, least: float) -> Array:
    """Return how x and y (n, k) differ at each state, shape (n,); infinite if not finite."""
    with np.errstate(all="ignore"):
        difference = np.linalg.norm(x - y, axis=1) / _sizes(x, y, least)
    finite = np.isfinite(x).all(axis=1) & np.isfinite(y).all(axis=1) & np.isfinite(difference)
    return np.where(finite, difference, np.inf)


def differ_by(quantity: str, x: Array, y: Array, mass: Array, least: float = 1.0) -> Array:
    """Return how two values of a quantity (n, …) differ at each state, relative, shape (n,)."""
    return relative_difference(scale(quantity, x, mass), scale(quantity, y, mass), least)


def relative_differences(x: Array, y: Array, least: float | None) -> Array:
    """Return how entries of x and y differ, shape (n, k); infinite if not finite."""
    with np.errstate(all="ignore"):
        difference = np.abs(x - y) / (1.0 if least is None else _sizes(x, y, least)[:, None])
    return np.where(np.isfinite(difference), difference, np.inf)


def relative_rounding(rounding: Array, x: Array, y: Array, least: float | None) -> Array:
    """Return the part of the relative difference that rounding (n,) explains, at most 1e-3."""
    with np.errstate(all="ignore"):
        sizes = np.ones(len(x)) if least is None else _sizes(x, y, least)
        part = rounding / sizes.reshape(-1, *[1] * (rounding.ndim - 1))
    return np.where(np.isnan(part), 0.0, np.minimum(part, _MOST))


def _sizes(x: Array, y: Array, least: float) -> Array:
    """Return the size against which a difference is judged at each state, shape (n,)."""
    with np.errstate(all="ignore"):
        sizes = np.linalg.norm(y, axis=1)
        known = sizes[np.isfinite(sizes)]
        largest = max(known, default=0.0)
        # scaled by the largest, so that a huge value does not overflow into a floor that excuses
        # everything
        typical = largest * float(np.sqrt(np.mean((known / largest) ** 2))) if largest > 0 else 0.0
        floor = SMALL * max(typical, least)
        size: Array = np.maximum(np.maximum(np.linalg.norm(x, axis=1), sizes), floor)
    return size


Values: TypeAlias = Mapping[str, Array]
"""What one source gives at all states: quantity -> shape (n, …)."""

_BY_MASS = (*QUANTITIES[6:], OF_ELEMENTS, IMPACT_MOMENTUM)
"""Quantities whose typical size is the moving mass at 1 m/s or 1 m/s²."""


class DynamicsSource(Protocol):
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
        """Kinetic energy, then potential energy in one or several parts; empty if not stated."""


@runtime_checkable
class BodySource(DynamicsSource, Protocol):
    """What a source answers that also knows its bodies."""

    def gravity(self, q: Any, t: Any = 0.0) -> Any:
        """Part of the bias that gravity makes."""

    def inverse_dynamics(self, q: Any, v: Any, a: Any, t: Any = 0.0) -> Any:
        """M a + bias − forces."""

    def momentum(self, q: Any, v: Any, t: Any = 0.0) -> Any:
        """Momentum, angular momentum about the origin, the same about the center of mass."""


def evaluate(
    source: DynamicsSource, states: States, *, light: bool = False, accelerations: bool = True
) -> dict[str, Array]:
    """Evaluate a source at all states."""
    q, v, t = states.q, states.v, states.t
    values = {"bias": source.bias(q, v, t), "forces": source.forces(q, v, t)}
    energies = source.energy(q, v, t)
    if len(energies):
        kinetic, *potential = energies
        values["kinetic energy"] = kinetic
        values["potential energy"] = sum(potential[1:], potential[0])
    if not light:
        values["mass matrix"] = source.mass_matrix(q, t)
    if accelerations and not light:
        values["acceleration"] = source.acceleration(q, v, t)
    if isinstance(source, BodySource):
        momentum, _, about_center = source.momentum(q, v, t)
        values |= {
            "gravity": source.gravity(q, t),
            "inverse dynamics": source.inverse_dynamics(q, v, states.a, t),
            "momentum": momentum,
            "angular momentum": about_center,
        }
    return {quantity: np.asarray(value, dtype=float) for quantity, value in values.items()}


def rows_of(
    names: tuple[str, str],
    ours: Values,
    theirs: Values,
    states: States,
    mechanism: Mechanism,
    *,
    rounding: Values | None = None,
    entries: Values | None = None,
    tolerance: float | None = SOLVED_ALIKE,
) -> tuple[Row, ...]:
    """Compare two sources quantity by quantity; rounding (n,)."""
    # a row reports the state, and the entry, where the difference is largest compared with what
    # is allowed there
    mass = moving_mass(mechanism)
    usual = SOLVED_ALIKE if tolerance is None else tolerance
    M, bounds = theirs["mass matrix"], entries or {}
    rows = []
    for quantity in (name for name in (*QUANTITIES, OF_ELEMENTS, IMPACT_MOMENTUM) if name in ours):
        x, y = (scale(quantity, values[quantity], M) for values in (ours, theirs))
        least, least_allowed, remark = least_size(quantity, mass), usual, ""
        by_entry = quantity in bounds
        if by_entry:
            least_allowed = tolerance or 0.0
            size = None if quantity == "mass matrix" else least
            difference = relative_differences(x, y, size)
            bound = scale(quantity, bounds[quantity][: len(states)], M)
            excused = relative_rounding(bound, x, y, size)
        else:
            difference = relative_difference(x, y, least)[:, None]
            excused = np.zeros_like(difference)
            if rounding is not None and quantity in rounding:
                bound = rounding[quantity][: len(states)]
                excused = relative_rounding(bound, x, y, least)[:, None]
        if quantity == "potential energy" and difference.max() > usual:
            # a potential is known up to a constant only; differences decide
            offset, middle = median(x - y), median(y)
            shifted = relative_difference(x - offset - middle, y - middle, least)
            if shifted.max() <= usual:
                difference = shifted[:, None]
                remark = f"up to a constant of {offset:.6g} J, which no equation of motion sees"
        remark = _explain_not_finite(names, ours[quantity], theirs[quantity]) or remark
        part = difference / np.maximum(excused, max(least_allowed, np.finfo(float).tiny))
        worst, entry = np.unravel_index(int(np.argmax(part)), part.shape)
        rows.append(
            Row(
                quantity=quantity,
                sources=names,
                worst=float(difference[worst, entry]),
                q=tuple(states.q[worst].tolist()),
                v=tuple(states.v[worst].tolist()),
                t=float(states.t[worst]),
                remark=remark,
                rounding=float(excused[worst, entry]),
                entry=_names_of(int(entry), quantity, mechanism) if by_entry else (),
                by_entry=by_entry,
                tolerance=least_allowed,
            )
        )
    return tuple(rows)


def _explain_not_finite(names: tuple[str, str], ours: Array, theirs: Array) -> str:
    """Say which source is not finite, the second if both are; empty if all values are finite."""
    remark = ""
    for name, values in zip(names, (ours, theirs), strict=True):
        if bad := int((~np.isfinite(values).reshape(len(values), -1).all(axis=1)).sum()):
            remark = f"{name} is not finite at {bad} of {say_count(len(values), 'state')}"
    return remark


def _names_of(entry: int, quantity: str, mechanism: Mechanism) -> tuple[str, ...]:
    """Return the names of an entry's velocities or axis, of the mass matrix by its flat place."""
    names = mechanism.velocities
    if quantity == "mass matrix":
        row, column = divmod(entry, len(names))
        return names[row], names[column]
    if quantity == "kinetic energy":
        return ()
    return (("xyz" if "momentum" in quantity else names)[entry],)


def moving_mass(mechanism: Mechanism) -> float:
    """Return the mass of all bodies except the ground, or 1 if they have none [kg]."""
    moving = (body for body in mechanism.bodies if body.name != mechanism.ground)
    return sum(max(mechanism.evaluate(body.mass), 0.0) for body in moving) or 1.0


def least_size(quantity: str, mass: float) -> float:
    """Return the smallest size to judge a difference of this quantity against."""
    if quantity == "mass matrix":
        return 1.0
    return mass if quantity in _BY_MASS else mass**0.5
