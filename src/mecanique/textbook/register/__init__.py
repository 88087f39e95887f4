"""The register of the chapter: every equation, what it states and whether it holds as printed.

The chapter is "Fundamentals of Dynamics", ch. 1 of a text on structural dynamics. Rows are computed
on demand.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from mecanique.textbook.register.row import Row

__all__ = ["register"]


def register() -> tuple[Row, ...]:
    """Check the numbered equations (1.1-1.33) and all displayed results of Examples 1.1 and 1.2.

    Raises:
        MecaniqueError: if a system cannot be treated.
    """
    from mecanique.textbook.register import energies, example_1, example_2, laws, pendulum

    numbered = (*laws.rows(), *pendulum.rows(), *energies.rows())
    in_order = sorted(numbered, key=lambda row: row.place)
    return (*in_order, *example_1.rows(), *example_2.rows())
