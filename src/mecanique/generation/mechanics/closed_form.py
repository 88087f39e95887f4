"""Write the equations of motion on a tape in closed form, from the series that are printed."""

from __future__ import annotations

from functools import cached_property
from typing import Any, final

from mecanique.derivation.equations import Equations
from mecanique.derivation.scalars.series import Series
from mecanique.derivation.symbolic.lagrange import Lagrange
from mecanique.errors import DerivationError
from mecanique.generation.mechanics.letters import Letters
from mecanique.generation.mechanics.vectors import Rows
from mecanique.generation.program.lowering import Lowering
from mecanique.generation.program.traced import trace, value_of

MOST_VELOCITIES = 8
"""With more velocities, closed forms are too long to be faster than a recursion."""


@final
class ClosedForm:
    """Mass matrix, bias, forces and energies from the series of a derivation.

    Args:
        letters: the mechanism's inputs.
        equations: its equations of motion.

    Raises:
        DerivationError: if there is no closed form that holds in every state.
    """

    def __init__(self, letters: Letters, equations: Equations) -> None:
        mechanism = letters.mechanism
        if mechanism.constrained:
            raise DerivationError(
                f"mechanism {mechanism.name!r} has loops; its closed form is that of the open tree"
            )
        if mechanism.nv > MOST_VELOCITIES:
            raise DerivationError(
                f"expected at most {MOST_VELOCITIES} velocities for a closed form, "
                f"got {mechanism.nv}"
            )
        self._derivation = derivation = equations.derivation
        if derivation.assumptions:
            subjects = ", ".join(assumption.subject for assumption in derivation.assumptions)
            raise DerivationError(
                f"the closed form of {mechanism.name!r} holds for one sign of {subjects} only"
            )
        self._letters = letters
        values = {name: value_of(scalar) for name, scalar in letters.values.items()}
        self._lower = Lowering(derivation.algebra.ring, letters.tape, values)

    def mass_matrix(self) -> Rows:
        """Return M."""
        return [list(map(self._write, row)) for row in self._derivation.M]

    def bias(self) -> list[Any]:
        """Return Coriolis, centrifugal and rheonomic inertia terms and gravity."""
        return [self._write(entry) for entry in self._derivation.h]

    def forces(self) -> list[Any]:
        """Return the generalized forces of springs, dampers, drives and loads."""
        return [self._write(entry) for entry in self._derivation.Q]

    def energy(self) -> tuple[Any, Any]:
        """Return the kinetic and the potential energy."""
        return self._write(self._lagrange.T), self._write(self._lagrange.V)

    def rates(self) -> list[Any]:
        """Return the rates of the coordinates."""
        ring = self._derivation.algebra.ring
        return [
            self._write(ring.rates[ring.index(name)])
            for name in self._letters.mechanism.coordinates
        ]

    @cached_property
    def _lagrange(self) -> Lagrange:
        return Lagrange(self._letters.mechanism, self._derivation.algebra)

    def _write(self, series: Series) -> Any:
        return trace(self._letters.tape, self._lower(series))
