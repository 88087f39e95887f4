"""What a book's last line says: accelerations and forces of constraints in closed form."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import final

from mecanique.derivation.document import Document
from mecanique.derivation.printing.writers import Equation
from mecanique.derivation.symbolic.derivation import Derivation
from mecanique.derivation.symbolic.solution import EliminatedSolution
from mecanique.derivation.symbolic.symbols import coordinate_of

_CLOSING = "Solved for the accelerations and the forces of the constraints."


@final
@dataclass(frozen=True, repr=False)
class Solved:
    """Equations of motion solved for accelerations and forces of constraints.

    Constraints are eliminated by the displacements that they allow (G. A. Maggi, Principii della
    teoria matematica del movimento, 1896; Neimark & Fufaev, Dynamics of Nonholonomic Systems, 1972,
    ch. III), accelerations that depend on each other, three at most, by Cramer's rule.

    Args:
        derivation: what is solved.
        found: the solution in closed form.

    Example:
        >>> disk = mq.derive(mq.textbook.load("rolling_disk")).solved()
        >>> print(disk.accelerations["x''"])
        x'' = 2 g sin(alpha)/3
        >>> print(disk.forces["lambda_contact_x"])
        lambda_contact_x = -m g sin(alpha)/3
    """

    derivation: Derivation
    found: EliminatedSolution

    @property
    def independent(self) -> tuple[str, ...]:
        """The coordinates, or velocities that are no coordinate's rate, that remain independent.

        None if there are none, as with the knife edge of a sleigh: the speed along it is no rate.
        """
        return tuple(map(coordinate_of, self.found.kept))

    @property
    def equations(self) -> tuple[Equation, ...]:
        """The equations of motion in these alone, without multipliers; empty if none are."""
        return self.found.equations

    @cached_property
    def accelerations(self) -> dict[str, Equation]:
        """Each acceleration, e.g. x'' = 2 g/3, by name; empty if they would be long."""
        return {name: value.equate(name) for name, value in self.found.accelerations.items()}

    @cached_property
    def forces(self) -> dict[str, Equation]:
        """Each multiplier by name; in terms of the accelerations if those are not solved for.

        Those that redundant constraints leave undetermined are not listed.
        """
        return {name: value.equate(name) for name, value in self.found.forces.items()}

    def text(self, symbols: bool = False) -> str:
        """Return what is solved as text, one line each.

        Args:
            symbols: whether to say above it what it is of and what each letter means.
        """
        return self._document.text(False, symbols)

    def latex(self, symbols: bool = False) -> str:
        """Return what is solved in LaTeX for mathematics mode; with symbols, a fragment.

        Args:
            symbols: whether to say above it what it is of and what each letter means.
        """
        return self._document.latex(False, symbols)

    def mathml(self, symbols: bool = False) -> str:
        """Return what is solved in MathML, an element each; with symbols, part of an HTML page.

        Args:
            symbols: whether to say above it what it is of and what each letter means.
        """
        return self._document.mathml(False, symbols)

    def __str__(self) -> str:
        return self.text()

    def __repr__(self) -> str:
        name = self.derivation.algebra.mechanism.name
        independent = ", ".join(self.independent) or "no velocity"
        return f"<Solved equations of {name!r}, {independent} independent>"

    def _repr_html_(self) -> str:
        return self._document.html()

    @cached_property
    def _document(self) -> Document:
        motion = self.accelerations.values() or self.equations
        lines = (*motion, *self.forces.values(), *self.found.turned)
        solved = replace(self.derivation, written=lines, stages=(), closing=_CLOSING)
        return Document(solved, "the equations of motion, solved")
