"""The relative difference of two equations of motion.

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

import numpy as np

from mecanique.arrays import Array

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

SMALL = 1e-3
"""Part of the typical size below which a value is judged against the typical size."""

_MOST = 1e-3
"""The largest relative difference that rounding excuses."""


def scales(mass: Array) -> Array:
    """Return d_i = √M_ii at each state, shape (n, nv); 1 where a velocity moves no mass."""
    diagonal = np.diagonal(mass, axis1=1, axis2=2)
    return np.sqrt(np.where(np.isfinite(diagonal) & (diagonal > 0), diagonal, 1.0))


def scale(quantity: str, values: Array, mass: Array) -> Array:
    """Return values as vectors whose entries have one unit, shape (n, any).

    Shapes: values (n, …), mass (n, nv, nv).
    """
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
    """Return the relative difference at each state, shape (n,); infinite if a value is not finite.

    Shapes: x (n, k), y (n, k).
    """
    with np.errstate(all="ignore"):
        difference = np.linalg.norm(x - y, axis=1) / _sizes(x, y, least)
    finite = np.isfinite(x).all(axis=1) & np.isfinite(y).all(axis=1) & np.isfinite(difference)
    return np.where(finite, difference, np.inf)


def relative_differences(x: Array, y: Array, least: float | None) -> Array:
    """Return the relative difference of each entry, shape (n, k); infinite if not finite.

    Shapes: x (n, k), y (n, k).
    """
    with np.errstate(all="ignore"):
        difference = np.abs(x - y) / (1.0 if least is None else _sizes(x, y, least)[:, None])
    return np.where(np.isfinite(difference), difference, np.inf)


def relative_rounding(rounding: Array, x: Array, y: Array, least: float | None) -> Array:
    """Return the part of the relative difference that rounding explains, shape as given.

    It is at most a thousandth, however close to a singular one a state is.

    Shapes: rounding (n,), x (n, k), y (n, k).
    """
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
        floor = max(SMALL * typical, SMALL * least, np.finfo(float).tiny)
        size: Array = np.maximum(np.maximum(np.linalg.norm(x, axis=1), sizes), floor)
    return size
