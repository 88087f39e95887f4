"""Reduce a mechanism with loops and one degree of freedom to one equation of motion."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, final

import numpy as np

from mecanique.derivation.document import Document
from mecanique.derivation.methods import derive
from mecanique.derivation.printing.prose import to_latex
from mecanique.derivation.printing.writers import Equation, Text
from mecanique.derivation.scalars.evaluation import Evaluation, relative_rest
from mecanique.derivation.symbolic.coefficients import ReducedEquation, reduce_to_one
from mecanique.derivation.symbolic.lagrange import Lagrange
from mecanique.derivation.tolerances import CLOSED_WELL, FIRM
from mecanique.errors import DerivationError
from mecanique.model.mechanism import Mechanism
from mecanique.model.random_positions import draw_positions
from mecanique.wording import Legible

_STEPS = 30
"""The most iterations of Newton to close a loop."""


@final
@dataclass(frozen=True, repr=False)
class SingleEquation(Legible):
    """The single equation J θ'' + C θ'² = Q of a mechanism with loops, and its coefficients.

    Args:
        mechanism: the mechanism that it describes.
        found: the reduction in closed form.

    Example:
        >>> one = mq.reduce_loops(mq.textbook.load("slider_crank"), "theta")
        >>> one.coordinate, list(one.coefficients)
        ('theta', ['K_beta', 'K_x', 'L_beta', 'L_x', 'J', 'C'])
        >>> print(one.coefficients["J"])
        m1 r^2/3 + m2 K_x^2
        >>> one.compare() < 1e-9
        True
    """

    mechanism: Mechanism
    found: ReducedEquation

    @property
    def coordinate(self) -> str:
        """The coordinate that is kept."""
        return self.found.coordinate

    @cached_property
    def document(self) -> Document:
        """The reduction written out."""
        return Document(self.found.derivation, f"the equation in {self.coordinate} alone")

    @property
    def equation(self) -> Equation:
        """The equation, written with J, C and the kinematic coefficients."""
        return self.document.equations[0]

    @property
    def acceleration(self) -> Equation:
        """The equation solved for the acceleration."""
        return self.document.equations[1]

    @cached_property
    def coefficients(self) -> dict[str, str]:
        """The definition of each coefficient as text, by letter, each after those it needs."""
        stages = self.found.derivation.stages[-3:]
        lines = [result.write(Text()) for stage in stages for result in stage.results]
        return dict(line.split(" = ", 1) for line in lines)

    def compare(self, samples: int = 20, seed: int = 0) -> float:
        """Return the largest disagreement with the full, constrained equations at random states.

        Args:
            samples: number of random positions to try; those whose loops can be closed are used.
            seed: of the random numbers.

        Returns:
            The largest residual of the equation, or of a dependent acceleration, relative to its
            largest term.

        Raises:
            DerivationError: if the loops could be closed at no random position.

        Example:
            >>> import mecanique as mq
            >>> one = mq.reduce_loops(mq.textbook.load("slider_crank"), "theta")
            >>> print(one.equation, one.compare() < 1e-9)
            J theta'' + C theta'^2 + m1 g r cos(theta)/2 = 0 True
        """
        full, worst, used = derive(self.mechanism), 0.0, 0
        random = np.random.default_rng(seed)
        for q in draw_positions(self.mechanism, samples, random, 1.0):
            values = self._close(q, random.normal())
            if values is None:
                continue
            names = self.mechanism.coordinates
            closed = np.array([values[name] for name in names])
            v = np.array([values[f"{name}'"] for name in names])
            a = full.acceleration(closed, v)
            values |= {f"{name}''": x for name, x in zip(names, a, strict=True)}
            evaluate = Evaluation(self.found.derivation.algebra.ring, values)
            worst = max(worst, relative_rest([evaluate(part) for part in self.found.parts]))
            worst = max(worst, self._check_followers(values))
            used += 1
        if not used:
            raise DerivationError(
                f"mechanism {self.mechanism.name!r}: no random position allowed its loops to close"
            )
        return worst

    def _check_followers(self, values: Mapping[str, float]) -> float:
        """Return the largest disagreement of a dependent acceleration with K θ'' + L θ'²."""
        kept, worst = self.coordinate, 0.0
        v, a = values[f"{kept}'"], values[f"{kept}''"]
        changes = {L.coordinate: L.name for L in self.found.changes}
        for K in self.found.ratios:
            L = values[changes[K.coordinate]]
            parts = [values[K.name] * a, L * v**2, -values[f"{K.coordinate}''"]]
            worst = max(worst, relative_rest(parts))
        return worst

    def _close(self, q: np.ndarray, rate: float) -> dict[str, Any] | None:
        """Close the loops near q; return all values there, None if singular or not closed."""
        ties, ring = self.found.ties, self.found.derivation.algebra.ring
        names = self.mechanism.coordinates
        others = [k for k, name in enumerate(names) if name != self.coordinate]
        values: dict[str, Any] = {}
        for _ in range(_STEPS):
            values = {**self.mechanism.values, **dict(zip(names, q.tolist(), strict=True))}
            evaluate = Evaluation(ring, values)
            gaps = np.array([evaluate(tie.demand) for tie in ties])
            slopes = np.array([[*map(evaluate, tie.slopes(ring))] for tie in ties])
            sizes = np.linalg.norm(slopes, axis=1)  # a gap in them is one of the coordinates
            if not sizes.all():
                return None
            J, gaps = slopes[:, others] / sizes[:, None], gaps / sizes
            if np.linalg.svd(J, compute_uv=False)[-1] < FIRM:
                return None
            if np.abs(gaps).max() < CLOSED_WELL:
                break
            q = np.array(q)
            q[others] -= np.linalg.solve(J, gaps)
        else:
            return None
        for _, letter, quotient in (*self.found.ratios, *self.found.changes):
            evaluate = Evaluation(ring, values)
            divisor = evaluate(quotient.below)
            if abs(divisor) < FIRM:
                return None
            values[letter] = evaluate(quotient.above) / divisor
        values[f"{self.coordinate}'"] = rate
        for K in self.found.ratios:
            values[f"{K.coordinate}'"] = values[K.name] * rate
        return values

    def text(self, steps: bool = True) -> str:
        """Return the equation as text, with the meanings and definitions of its letters.

        Args:
            steps: whether to show the steps that lead to it.
        """
        if steps:
            return f"{self.document.text(True, symbols=True)}\n\n{self._said}"
        defined = [f"{letter} = {value}" for letter, value in self.coefficients.items()]
        return "\n".join([*defined, str(self.equation), str(self.acceleration), "", self._said])

    def latex(self, steps: bool = True) -> str:
        """Return the equation as a fragment of a LaTeX document.

        Args:
            steps: whether to show the steps that lead to it.
        """
        if not steps:
            return self.equation.latex()
        return f"{self.document.latex(True, symbols=True)}\n\n{to_latex(self._said, ())}"

    def mathml(self, steps: bool = True) -> str:
        """Return the equation as a fragment of HTML with MathML.

        Args:
            steps: whether to show the steps that lead to it.
        """
        if not steps:
            return self.equation.mathml()
        return f"{self.document.mathml(True, symbols=True)}\n<p>{self._said}</p>"

    def __str__(self) -> str:
        return self.text(steps=False)

    def _repr_html_(self) -> str:
        return f"{self.document.html(steps=True)}\n<p>{self._said}</p>"

    @cached_property
    def _said(self) -> str:
        """A sentence that states how well it agrees with the full equations."""
        return (
            "At random closed states the accelerations of the full equations, with multipliers, "
            f"satisfy it to a relative difference of {self.compare():.0e}."
        )


def reduce_loops(mechanism: Mechanism, coordinate: str = "") -> SingleEquation:
    """Reduce a mechanism with loops and one degree of freedom to one equation, J θ'' + C θ'² = Q.

    Every other coordinate u follows θ by kinematic coefficients K = du/dθ and L = dK/dθ, each named
    and defined (R. Eksergian, J. Franklin Inst. 209, 1930, 21; B. Paul, Kinematics and Dynamics of
    Planar Machinery, 1979, ch. 12).

    Args:
        mechanism: a mechanism with loops and one degree of freedom.
        coordinate: θ, by default the first coordinate.

    Returns:
        The equation with its coefficients.

    Raises:
        UnknownNameError: if there is no such coordinate.
        DerivationError: if there is not exactly one degree of freedom, or the coefficients are too
            long.

    Example:
        >>> import mecanique as mq
        >>> one = mq.reduce_loops(mq.textbook.load("slider_crank"), "theta")
        >>> print(one.coefficients["J"])
        m1 r^2/3 + m2 K_x^2
    """
    return SingleEquation(mechanism, reduce_to_one(Lagrange(mechanism), coordinate))
