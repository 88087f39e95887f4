"""Equations reduced by momenta or by kinematic coefficients, compared with the full ones."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import islice
from typing import Any, final

import numpy as np

from mecanique.derivation.document import Document
from mecanique.derivation.methods import derive
from mecanique.derivation.printing.prose import to_latex
from mecanique.derivation.printing.writers import Equation, Text
from mecanique.derivation.scalars.evaluation import Evaluation, relative_rest
from mecanique.derivation.scalars.series import Series
from mecanique.derivation.symbolic.lagrange import Lagrange
from mecanique.derivation.symbolic.multipliers import name_of
from mecanique.derivation.symbolic.reduced import (
    ReducedEquation,
    Routh,
    reduce_by_momenta,
    reduce_to_one,
)
from mecanique.derivation.tolerances import CLOSED_WELL, FIRM
from mecanique.errors import DerivationError
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
        sums = [[*map(evaluate, parts)] for parts in self.found.parts]
        sums += [[evaluate(x.rate), -values[f"{x.name}'"]] for x in self.found.ignored]
        return max(map(relative_rest, sums), default=0.0)

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
        v, a = (values[f"{self.coordinate}{dots}"] for dots in ("'", "''"))
        changes = {L.coordinate: values[L.name] for L in self.found.changes}
        sums = []
        for K in self.found.ratios:
            due = -values[f"{K.coordinate}''"]
            sums.append([values[K.name] * a, changes[K.coordinate] * v**2, due])
        return max(map(relative_rest, sums), default=0.0)

    @cached_property
    def _slopes(self) -> list[list[Series]]:
        """The derivatives of the loops' gaps by the coordinates."""
        ring = self.found.derivation.algebra.ring
        return [tie.slopes(ring) for tie in self.found.ties]

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
            slopes = np.array([[*map(evaluate, row)] for row in self._slopes])
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
