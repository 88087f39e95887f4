"""The register of the chapter: what each equation states, whether it holds as printed, computed when asked.

The chapter is "Fundamentals of Dynamics", ch. 1, of a text on structural dynamics; its numbers are
used throughout.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from mecanique.textbook.register.row import Row

__all__ = ["register"]


def register() -> tuple[Row, ...]:
    """Check every numbered equation (1.1-1.33) and every displayed result of Examples 1.1 and 1.2; return a row each.

    Raises:
        MecaniqueError: if a system cannot be treated.
    """
    from mecanique.textbook.register import energies, example_1, example_2, laws, pendulum

    numbered = sorted(
        (*laws.CHECKS, *pendulum.CHECKS, *energies.CHECKS), key=lambda check: check.order
    )
    return tuple(check.row() for check in (*numbered, *example_1.CHECKS, *example_2.CHECKS))
