"""Check that equations determine reactions: only balances of bodies cut free do."""

from __future__ import annotations

from mecanique.derivation.numeric.dynamics import BatchDynamics
from mecanique.derivation.numeric.newton_euler import Balances
from mecanique.errors import DerivationError
from mecanique.model.mechanism import Mechanism


def require_balances(numeric: BatchDynamics, method: str, what: str) -> Balances:
    """Return a numeric derivation if it is by the balances of bodies cut free.

    Args:
        numeric: the numeric derivation.
        method: name of its method.
        what: the requested quantity, for the error.

    Raises:
        DerivationError: if it is by another method.
    """
    if isinstance(numeric, Balances):
        return numeric
    raise DerivationError(f'the method {method!r} shows no {what}; use method="newton_euler"')


def require_reactions(mechanism: Mechanism, numeric: BatchDynamics, method: str) -> Balances:
    """Return a numeric derivation if it determines the reactions in the joints.

    Args:
        mechanism: the mechanism.
        numeric: its numeric derivation.
        method: name of the method.

    Raises:
        DerivationError: if the method shows no reactions, or constraints leave them undetermined.
    """
    balances = require_balances(numeric, method, "reactions, which do no virtual work")
    if mechanism.loops:
        raise DerivationError(
            f"mechanism {mechanism.name!r} has loops, whose forces the balances of its "
            "tree leave out; use Reference"
        )
    if mechanism.velocity_constraints:
        raise DerivationError(
            f"mechanism {mechanism.name!r}: velocity constraint "
            f"{mechanism.velocity_constraints[0].name!r} does not say by which force it "
            "acts, and where, so that the reactions are undetermined; a Rolling or a Blade does"
        )
    return balances
