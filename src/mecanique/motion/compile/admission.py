"""Whether generated equations may be used: they have to agree with the reference first."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from mecanique.errors import DerivationError
from mecanique.model.mechanism import Mechanism
from mecanique.model.states import States
from mecanique.verification.rounding.conditioning import rounding
from mecanique.verification.rows import TOLERANCE, rows_of
from mecanique.verification.states.random import random_states

if TYPE_CHECKING:
    from mecanique.reference import Reference

__all__ = ["SAMPLES", "require_agreement"]

SAMPLES = 10
"""Number of random states at which accelerations are compared."""


def require_agreement(
    mechanism: Mechanism,
    reference: Reference,
    accelerations: Callable[[States], np.ndarray],
    source: str,
    states: States | None = None,
) -> None:
    """Compare accelerations with the reference's at random states, as strictly as `verify` does.

    Args:
        mechanism: what moves.
        reference: its `Reference`.
        accelerations: gives them at states, shape (n, nv).
        source: where they come from, for the message.
        states: where to compare; random ones by default.

    Raises:
        DerivationError: if they do not agree.
    """
    if states is None:
        states = random_states(mechanism, SAMPLES, 0)
    theirs = {
        "mass matrix": np.asarray(reference.mass_matrix(states.q, states.t)),
        "bias": np.asarray(reference.bias(states.q, states.v, states.t)),
        "forces": np.asarray(reference.forces(states.q, states.v, states.t)),
        "acceleration": np.asarray(reference.acceleration(states.q, states.v, states.t)),
    }
    most = rounding(mechanism, states, theirs)
    ours = {"acceleration": accelerations(states)}
    (row,) = rows_of((source, "reference"), ours, theirs, states, mechanism, rounding=most)
    if not row.worst <= max(TOLERANCE, row.rounding):
        raise DerivationError(
            f"the {source} of {mechanism.name!r} and the reference disagree: accelerations "
            f"differ by {row.worst:.1e} at q = {list(row.q)}; "
            "verify(mechanism) shows what else does"
        )
