"""Refuse to integrate where an inertia that no real body has makes the kinetic energy negative."""

from __future__ import annotations

import numpy as np

from mecanique.arrays import Array
from mecanique.errors import IntegrationError
from mecanique.reference import Reference

_ROUNDING = 1e-13
"""Eigenvalues of the scaled mass matrix above minus this are zero to rounding."""


def refuse_indefinite(reference: Reference, t: Array, q: Array) -> None:
    """Raise if the mass matrix has a negative eigenvalue at any of the states.

    Only bodies that are taken as given can have such an inertia; without them nothing is computed.

    Args:
        reference: the mechanism inside the engine.
        t: shape (n,), times [s].
        q: shape (n, nq), positions.

    Raises:
        IntegrationError: with the first such state and the bodies that may be the reason.
    """
    bodies = [body.name for body in reference.mechanism.bodies if body.as_given]
    if not bodies:
        return
    mass = reference.mass_matrix(q, t)
    size = np.sqrt(np.abs(np.diagonal(mass, axis1=1, axis2=2)))
    size = np.where(size > 0, size, 1.0)
    least = np.linalg.eigvalsh(mass / (size[:, :, None] * size[:, None, :]))[:, 0]
    wrong = np.flatnonzero(least < -_ROUNDING)
    if len(wrong):
        first = wrong[0]
        raise IntegrationError(
            f"the mass matrix is not positive definite at t = {t[first]:.6g} s: there are motions "
            "with negative kinetic energy, so that no integration means anything; no real body "
            f"has the inertia of {', '.join(map(repr, bodies[:6]))}"
            f"{', …' if len(bodies) > 6 else ''}; mend it (mecanique lint --fix --balance)",
            time=float(t[first]),
            state=q[first],
        )
