"""The in-house derivation against the engine: a Verdict, quantity by quantity, at many seeded states."""

from __future__ import annotations

from typing import TYPE_CHECKING

from mecanique.model.mechanism import Mechanism
from mecanique.verification.causes.cause import Cause
from mecanique.verification.verdict import Row, Verdict

if TYPE_CHECKING:
    from mecanique.verification.against import Other

__all__ = ["Cause", "Row", "Verdict", "verify"]


def verify(
    mechanism: Mechanism,
    samples: int = 100,
    seed: int = 0,
    *,
    against: Other | None = None,
    tolerance: float = 1e-9,
) -> Verdict:
    """Compare the equations of motion derived in-house with the engine's, or with another source, at random states.

    Compared are the mass matrix, the bias, gravity, the generalized forces, inverse dynamics, the
    acceleration, the energies and the momenta: each form of the in-house derivation (Lagrange's
    equations by jets, by a recursion and in closed form, Newton and Euler's balances, virtual work)
    against Pinocchio, which gets the mechanism as URDF text only; and the reactions in all joints.
    Where they disagree, the verdict ranks likely causes.

    Args:
        mechanism: what to verify.
        samples: number of random states, at least 1.
        seed: of the random states; the same seed gives the same states and the same verdict.
        against: another source instead of Pinocchio: a mechanism; the path of a URDF file;
            functions by name, e.g. `{"M": …, "C": …, "g": …}` (see
            `mecanique.verification.given.Functions`); or the path of a CSV file with states and
            forces, whose states are then used (see `mecanique.verification.given.read_samples`).
        tolerance: largest relative difference that counts as agreement with another source.

    Raises:
        InputError: if `samples` or `seed` is not a whole number in its range, or the other source
            is none.
        MecaniqueError: if a source cannot treat the mechanism at all.
    """
    if against is not None:
        from mecanique.verification.against import compared_with

        return compared_with(mechanism, against, samples, seed, tolerance)
    from mecanique.verification.compare import compared

    verdict = compared(mechanism, samples, seed)
    if verdict.agrees:
        return verdict
    from mecanique.verification.against import explained

    return explained(verdict, mechanism)
