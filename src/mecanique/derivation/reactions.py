"""Which equations show reactions: those of bodies cut free, where balances determine them."""

from __future__ import annotations

from mecanique.derivation.numeric.dynamics import BatchDynamics
from mecanique.derivation.numeric.newton_euler import Balances
from mecanique.errors import DerivationError
from mecanique.model.mechanism import Mechanism

__all__ = ["require_balances", "require_reactions"]


def require_balances(numeric: BatchDynamics, method: str, what: str) -> Balances:
    """Return what computes equations if it balances bodies that are cut free.

    Args:
        numeric: what computes them.
        method: how they were derived.
        what: what is asked of them, for the error.

    Raises:
        DerivationError: if the method is another.
    """
    if isinstance(numeric, Balances):
        return numeric
    raise DerivationError(f'the method {method!r} shows no {what}; use method="newton_euler"')


def require_reactions(mechanism: Mechanism, numeric: BatchDynamics, method: str) -> Balances:
    """Return what computes equations if it determines the reactions in the joints.

    Args:
        mechanism: what the equations describe.
        numeric: what computes them.
        method: how they were derived.

    Raises:
        DerivationError: if the method shows none, or constraints leave them open.
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
