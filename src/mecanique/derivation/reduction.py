"""Reduce a mechanism by Routh's method, and compare the result with the full equations."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import islice
from typing import Any, final

import numpy as np

from mecanique.derivation.document import Document
from mecanique.derivation.methods import derive
from mecanique.derivation.printing.prose import to_latex
from mecanique.derivation.printing.writers import Equation
from mecanique.derivation.scalars.evaluation import Evaluation, relative_rest
from mecanique.derivation.symbolic.lagrange import Lagrange
from mecanique.derivation.symbolic.multipliers import name_of
from mecanique.derivation.symbolic.routh import Routh, reduce_by_momenta
from mecanique.model.mechanism import Mechanism
from mecanique.model.random_positions import draw_positions
from mecanique.wording import Legible, enumerate_words

_AT = 0.3
"""The time at which the two sets of equations are compared [s]."""

_ROUNDS = 100
"""Lots of positions drawn at most, in search of those at which the closed form holds."""


@final
@dataclass(frozen=True, repr=False)
class Reduction(Legible):
    """Equations of motion in which conserved momenta replace the cyclic coordinates.

    Args:
        mechanism: the mechanism that they describe.
        found: the reduction in closed form.

    Example:
        >>> orbit = mq.routh(mq.textbook.load("kepler_orbit"))
        >>> orbit.cyclic, orbit.momenta
        (('phi',), ('p_phi',))
        >>> print(orbit.equations[0])
        m r'' - p_phi^2/(m r^3) + m mu/r^2 = 0
        >>> orbit.compare() < 1e-9
        True
    """

    mechanism: Mechanism
    found: Routh

    @property
    def cyclic(self) -> tuple[str, ...]:
        """The cyclic coordinates, in the mechanism's order."""
        names = {coordinate.name for coordinate in self.found.ignored}
        return tuple(name for name in self.mechanism.coordinates if name in names)

    @property
    def momenta(self) -> tuple[str, ...]:
        """The letter of the momentum of each cyclic coordinate, in the same order."""
        letters = {
            coordinate.name: name_of(coordinate.momentum) for coordinate in self.found.ignored
        }
        return tuple(letters[name] for name in self.cyclic)

    @cached_property
    def document(self) -> Document:
        """The reduction written out."""
        return Document(self.found.derivation, "Routh's reduction")

    @property
    def equations(self) -> tuple[Equation, ...]:
        """The equations of the remaining coordinates; none if every coordinate is cyclic."""
        return self.document.equations

    def compare(self, samples: int = 50, seed: int = 0) -> float:
        """Return the largest disagreement with the full equations, at random states.

        Accelerations and momenta of the full equations, computed numerically, are put into the
        reduced ones.

        Args:
            samples: number of states.
            seed: of the random numbers.

        Returns:
            The largest residual of an equation or a cyclic velocity, relative to its largest term.

        Example:
            >>> import mecanique as mq
            >>> mq.routh(mq.textbook.load("spherical_pendulum")).compare() < 1e-9
            True
        """
        values = self._compute_states(samples, np.random.default_rng(seed))
        evaluate = Evaluation(self.found.derivation.algebra.ring, values)
        worst = 0.0
        for parts in self.found.parts:
            worst = max(worst, relative_rest([evaluate(part) for part in parts]))
        for coordinate in self.found.ignored:
            worst = max(
                worst, relative_rest([evaluate(coordinate.rate), -values[f"{coordinate.name}'"]])
            )
        return worst

    def _compute_states(self, samples: int, random: np.random.Generator) -> dict[str, Any]:
        """Compute motions by the full equations at random states, with momenta, by name."""
        mechanism, full = self.mechanism, derive(self.mechanism)
        draws = (draw_positions(mechanism, samples, random, 1.0) for _ in range(_ROUNDS))
        sound = (position for draw in draws for position in draw if full.holds(position, _AT))
        q = np.array([*islice(sound, samples)])
        v = random.normal(size=(len(q), mechanism.nv))
        a = full.acceleration(q, v, _AT)
        values: dict[str, Any] = {**mechanism.values, "t": _AT}
        for signal in mechanism.inputs:
            values[signal.symbol] = signal.function(mechanism.values)(_AT)
        for names, columns in (
            (mechanism.coordinates, q),
            (mechanism.velocities, v),
            ([f"{name}'" for name in mechanism.velocities], a),
        ):
            values |= dict(zip(names, columns.T, strict=True))
        M = full.mass_matrix(q, _AT)
        for name, letter in zip(self.cyclic, self.momenta, strict=True):
            k = mechanism.velocities.index(f"{name}'")
            step = np.tile(np.eye(mechanism.nv)[k], (len(q), 1))
            # p = ∂T/∂q' = M q' + terms of given motions: the part of T that is odd in q'
            ahead, behind = (full.energy(q, s * step, _AT)[0] for s in (1, -1))
            values[letter] = np.einsum("ni,ni->n", M[:, k], v) + (ahead - behind) / 2
        return values

    def text(self, steps: bool = True) -> str:
        """Return the reduction as text, with the meaning of its letters.

        Args:
            steps: whether to show the steps that lead to it.
        """
        return f"{self.document.text(steps, symbols=True)}\n\n{self._said}"

    def latex(self, steps: bool = True) -> str:
        """Return the reduction as a fragment of a LaTeX document.

        Args:
            steps: whether to show the steps that lead to it.
        """
        return f"{self.document.latex(steps, symbols=True)}\n\n{to_latex(self._said, ())}"

    def mathml(self, steps: bool = True) -> str:
        """Return the reduction as a fragment of HTML with MathML.

        Args:
            steps: whether to show the steps that lead to it.
        """
        return f"{self.document.mathml(steps, symbols=True)}\n<p>{self._said}</p>"

    def __str__(self) -> str:
        return self.text(steps=False)

    @property
    def _caption(self) -> str:
        return f"{self.mechanism.name} without {enumerate_words(self.cyclic)}"

    def _repr_html_(self) -> str:
        return f"{self.document.html(steps=False)}\n<p>{self._said}</p>"

    @cached_property
    def _said(self) -> str:
        """A sentence that states how well they agree with the full equations."""
        return (
            "At 50 random states the accelerations and momenta of the full equations satisfy the "
            f"reduced ones to a relative difference of {self.compare():.0e}."
        )


def routh(mechanism: Mechanism) -> Reduction:
    """Reduce the equations of motion by the momenta of the cyclic coordinates.

    Routh's function R = L − Σ p q' takes the place of the Lagrangian for the other coordinates
    (E. J. Routh, Stability of a Given State of Motion, 1877, ch. IV; Goldstein, Classical
    Mechanics, sect. 8-3).

    Args:
        mechanism: a mechanism with a cyclic coordinate: neither T nor V depends on it, and no
            other force acts along it.

    Returns:
        The reduced equations, with the conserved momenta as letters.

    Raises:
        DerivationError: if no coordinate is cyclic, if there are constraints on the velocities, or
            if there is no closed form of reasonable length.

    Example:
        >>> import mecanique as mq
        >>> print(mq.routh(mq.textbook.load("kepler_orbit")).equations[0])
        m r'' - p_phi^2/(m r^3) + m mu/r^2 = 0
    """
    return Reduction(mechanism, reduce_by_momenta(Lagrange(mechanism)))
