"""Admit generated equations only after they agree with the reference."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from mecanique.errors import DerivationError
from mecanique.model.mechanism import Mechanism
from mecanique.model.states import States
from mecanique.motion.compile.derive import program_of
from mecanique.motion.compile.program import SAMPLES, RatesProgram
from mecanique.motion.compile.python import overwriting, owning
from mecanique.motion.record.curve import RightHandSide
from mecanique.verification.rounding import rounding
from mecanique.verification.rows import rows_of
from mecanique.verification.states import random_states
from mecanique.verification.verdict import TOLERANCE

if TYPE_CHECKING:
    from mecanique.reference import Reference


_FEW = 4
"""Loops of mechanisms with more velocities are closed from random positions one by one for longer
than all their equations take to derive."""


class Admitted(NamedTuple):
    """A program that may be used."""

    program: RatesProgram
    # makes functions of it, each of which overwrites its last answer
    make: Callable[[], RightHandSide]


def require_agreement(
    mechanism: Mechanism,
    reference: Reference,
    accelerations: Callable[[States], np.ndarray],
    source: str,
    states: States | None = None,
) -> None:
    """Compare accelerations with the reference's at random states, as strictly as `verify` does."""
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


def admit(mechanism: Mechanism, reference: Reference) -> Admitted:
    """Derive a mechanism's equations as a program, and return it if the reference agrees."""
    many = SAMPLES if mechanism.constrained else 0
    far = mechanism.nv > _FEW
    states = random_states(mechanism, many, 0, lot=many, walk=far) if many else None
    program = program_of(mechanism, states=states)
    make = overwriting(program)
    rhs = owning(make())

    def accelerations(states: States) -> np.ndarray:
        rows = zip(states.q, states.v, states.t.tolist(), strict=True)
        try:
            return np.array([rhs(t, np.concatenate([q, v]))[mechanism.nq :] for q, v, t in rows])
        except (ArithmeticError, ValueError) as error:
            raise DerivationError(
                f"the closed form of {mechanism.name!r} is not defined everywhere: {error}"
            ) from error

    source = "closed form" if program.landing is None else "program"
    require_agreement(mechanism, reference, accelerations, source, states)
    return Admitted(program, make)
