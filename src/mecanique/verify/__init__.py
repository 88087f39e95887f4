"""The in-house derivation against the engine: a Verdict, quantity by quantity, at many seeded states."""

from __future__ import annotations

from mecanique.model.mechanism import Mechanism
from mecanique.verify.verdict import Row, Verdict

__all__ = ["Row", "Verdict", "verify"]


def verify(mechanism: Mechanism, samples: int = 100, seed: int = 0) -> Verdict:
    """Compare the equations of motion derived in-house with the engine's at random states.

    Compared are the mass matrix, the bias, the generalized forces, the acceleration, the kinetic and the potential
    energy: each form of the in-house derivation against Pinocchio, which gets the mechanism as URDF text only.

    Args:
        mechanism: what to verify.
        samples: number of random states, at least 1.
        seed: of the random states; the same seed gives the same states and the same verdict.

    Raises:
        InputError: if `samples` or `seed` is not a whole number in its range.
        MecaniqueError: if a source cannot treat the mechanism at all.
    """
    from mecanique.verify.compare import compared

    return compared(mechanism, samples, seed)
