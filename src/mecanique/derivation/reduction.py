"""Reduce a mechanism by Routh's method, and compare the result with the full equations."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from itertools import islice
from operator import attrgetter
from typing import Any, final

import numpy as np

from mecanique.derivation.document import Document
from mecanique.derivation.methods import derive
from mecanique.derivation.printing.equations import expression, join
from mecanique.derivation.printing.expressions import to_formula, to_power
from mecanique.derivation.printing.formulas import Product, add, multiply, number
from mecanique.derivation.printing.prose import to_latex
from mecanique.derivation.printing.writers import Equation, Expression
from mecanique.derivation.scalars.cancel import by_velocity, tidy
from mecanique.derivation.scalars.evaluation import Evaluation, relative_rest
from mecanique.derivation.scalars.series import Kind, Series
from mecanique.derivation.symbolic.derivation import Derivation, Left, Result, Stage, mass_and_bias
from mecanique.derivation.symbolic.kinematics import geometry_stages
from mecanique.derivation.symbolic.lagrange import Lagrange, energy_integral, energy_stages
from mecanique.derivation.symbolic.multipliers import Quotient, is_constant, name_of
from mecanique.derivation.symbolic.symbols import coordinate_of
from mecanique.errors import DerivationError
from mecanique.model.mechanism import Mechanism
from mecanique.model.mechanism_units import units
from mecanique.model.random_positions import draw_positions
from mecanique.wording import Legible, enumerate_words

_LETTERS = ("p", "P", "pi")
"""Letters for a momentum, before the name of its coordinate."""

_SINCE = (
    "Neither T nor V depends on these coordinates, and no other force acts along them: they are "
    "cyclic, and the momentum p = ∂T/∂q' of each is conserved."
)
_RATES = (
    "Each momentum is linear in its velocity and can be solved for it. The coefficient of the "
    "velocity is the inertia of that motion."
)
_FUNCTION = (
    "Routh's function is R = T - V - Σ p q', summed over the cyclic coordinates, with their "
    "velocities replaced. Half the square of a momentum, less its part from other velocities, "
    "divided by its inertia acts on the other coordinates like a potential energy. With V it is "
    "the effective potential V_eff, the part of -R without velocities."
)


@final
@dataclass(frozen=True)
class Ignored:
    """A cyclic coordinate that is ignored: p = inertia × q' + rest."""

    name: str
    momentum: Series  # its letter p
    inertia: Series  # coefficient of its velocity
    rest: Series  # part of the momentum due to the other motions
    folded: bool  # whether its part of R is expanded, as the rest contains velocities

    @property
    def left(self) -> Series:
        """The difference p − rest, which is inertia × q'."""
        return self.momentum - self.rest

    @property
    def rate(self) -> Series:
        """The velocity q' in terms of momenta and velocities that have not been ignored yet."""
        return tidy(self.left / self.inertia)

    @property
    def energy(self) -> Series:
        """The part (p − rest)²/(2 inertia) that is subtracted in R."""
        return tidy(self.left**2 / self.inertia / 2)

    def shown_energy(self, sign: int) -> Expression:
        """The part that is subtracted in R, with a sign, as a square over the inertia."""
        square = multiply(number(Fraction(sign, 2)), (add(expression(self.left).terms), 2))
        return Expression((multiply(square, to_power(to_formula(self.inertia), Fraction(-1))),))

    def shown_slope(self, coordinate: str) -> Product:
        """Return ∂/∂q of (p − rest)²/(2 inertia) if the rest contains no velocity."""
        left, A = self.left, self.inertia
        slope, change = left.diff(coordinate), A.diff(coordinate)
        factor = tidy(2 * A * slope - left * change)
        inverse = to_power(to_formula(A), Fraction(-2))
        return multiply(number(Fraction(1, 2)), to_formula(left), to_formula(factor), inverse)


@final
@dataclass(frozen=True)
class Routh:
    """The result of Routh's reduction."""

    derivation: Derivation  # the reduced equations with their steps
    ignored: tuple[Ignored, ...]  # the cyclic coordinates, in the order in which they are ignored
    parts: tuple[tuple[Series, ...], ...]  # the terms of each reduced equation, which sum to zero


def reduce_by_momenta(lagrange: Lagrange) -> Routh:
    """Derive the equations of the coordinates that are not cyclic, with conserved momenta."""
    algebra = lagrange.algebra
    ring, mechanism = algebra.ring, algebra.mechanism
    if lagrange.ties:
        raise DerivationError(
            f"mechanism {mechanism.name!r}: expected independent velocities for Routh's "
            "reduction, got constraints on them"
        )
    cyclic = _find_cyclic(lagrange)
    letters = _momenta(lagrange, cyclic)
    kinetic, ignored = lagrange.T, list[Ignored]()
    left = dict(zip(cyclic, letters, strict=True))
    while left:
        slopes = {name: kinetic.diff(f"{name}'") for name in left}
        inertias = {name: tidy(slopes[name].diff(f"{name}'")) for name in left}
        name = min(
            left,
            key=lambda candidate: (not is_constant(inertias[candidate]), len(inertias[candidate])),
        )
        v = ring[f"{name}'"]
        A, momentum = inertias[name], left.pop(name)
        rest = tidy(slopes[name] - A * v)
        folded = Kind.VELOCITY in rest.kinds
        coordinate = Ignored(name, momentum, A, rest, folded)
        # with q' = (p − B)/A, T − p q' is the part of T without q', minus (p − B)²/(2 A)
        kinetic = tidy(kinetic - A * v**2 / 2 - rest * v)
        if folded:
            kinetic = tidy(kinetic - coordinate.energy)
        ignored.append(coordinate)
    return _finish(lagrange, kinetic, ignored)


def _find_cyclic(lagrange: Lagrange) -> list[str]:
    """Find the cyclic coordinates, including that no drive, load or damper acts along them."""
    algebra = lagrange.algebra
    ring = algebra.ring
    drives = [force for work in lagrange.works if work.kind == "work" for force in work.forces]
    other = [*drives, lagrange.D]
    slopes = zip(
        algebra.velocities,
        lagrange.find_free(),
        ring.partials(lagrange.T),
        ring.along(lagrange.T),
        ring.along(lagrange.V),
        strict=True,
    )
    cyclic, held = [], []
    for v, free, momentum, along_T, along_V in slopes:
        name = coordinate_of(v)
        if name == v:
            continue
        acting = any(series.diff(by) for series in other for by in (v, name))
        if free and momentum and not (along_T or along_V or acting):
            cyclic.append(name)
        else:
            held.append(name)
    if not cyclic:
        raise DerivationError(
            f"mechanism {algebra.mechanism.name!r} has no cyclic coordinate: T or V depends on "
            f"each of {', '.join(held) or 'its velocities'}, or another force acts along it; "
            "no momentum ∂T/∂q' is conserved, and Routh's reduction does not apply"
        )
    return cyclic


def _momenta(lagrange: Lagrange, names: Sequence[str]) -> list[Series]:
    """Adjoin a letter for the momentum of each coordinate, a constant of the motion."""
    ring = lagrange.algebra.ring
    taken = {generator.name for generator in ring.generators}
    clashing = {
        candidate for candidate in _LETTERS for name in names if f"{candidate}_{name}" in taken
    }
    letter = next((candidate for candidate in _LETTERS if candidate not in clashing), "momentum")
    return [ring.parameter(f"{letter}_{name}") for name in names]


def _finish(lagrange: Lagrange, kinetic: Series, ignored: Sequence[Ignored]) -> Routh:
    """Assemble the reduced equations with their steps."""
    algebra = lagrange.algebra
    ring, V = algebra.ring, lagrange.V
    ahead = [coordinate for coordinate in ignored if not coordinate.folded]
    names = {coordinate.name for coordinate in ignored}
    moving = [k for k, v in enumerate(algebra.velocities) if coordinate_of(v) not in names]
    operated, falls = ring.euler(kinetic), ring.along(V)
    losses = ring.partials(lagrange.D)
    rows, parts, written = [], [], []
    for k in moving:
        q = coordinate_of(algebra.velocities[k])
        inertia = by_velocity(operated[k].value, algebra.velocities)
        pulls = [coordinate.energy.diff(q) for coordinate in ahead]
        slopes = [
            coordinate.shown_slope(q) for coordinate, pull in zip(ahead, pulls, strict=True) if pull
        ]
        drives = [work.forces[k] for work in lagrange.works if work.kind == "work"]
        drive = ring.sum(drives)
        every = (inertia, *pulls, falls[k], losses[k], -drive)
        shown = [expression(inertia), Expression(tuple(slopes))]
        shown += [expression(series) for series in (losses[k], falls[k])]
        left = join(part for part in shown if any(map(attrgetter("number"), part.terms)))
        parts.append(every)
        rows.append(ring.sum(every))
        written.append(Equation(left, expression(drive), ring.number(1)))
    M, h = mass_and_bias(algebra, rows)
    R = tidy(ring.sum([kinetic, *(-coordinate.energy for coordinate in ahead), -V]))
    shown_R = join(
        [
            expression(kinetic),
            *(coordinate.shown_energy(-1) for coordinate in ahead),
            expression(-V),
        ]
    )
    rates = [algebra.velocities[k] for k in moving]
    still = kinetic.coefficients(rates).get((0,) * len(rates), ring.number(0))
    effective = tidy(ring.sum([*(coordinate.energy for coordinate in ahead), V, -still]))
    shown_V = join([*(coordinate.shown_energy(1) for coordinate in ahead), expression(V - still)])
    momenta, velocities = list[Result](), list[Result]()
    for coordinate in ignored:
        name, v = coordinate.name, f"{coordinate.name}'"
        letter = name_of(coordinate.momentum).removesuffix(f"_{name}")
        momenta.append(Result(Left(letter, name, component=True), tidy(lagrange.T.diff(v))))
        fraction = Quotient(coordinate.left, coordinate.inertia).fraction
        velocities.append(Result(Left(v), coordinate.rate, fraction))
    derivation = Derivation(
        algebra=algebra,
        M=M,
        h=h,
        Q=tuple(ring.number(0) for _ in rows),
        stages=(
            *geometry_stages(lagrange.kinematics),
            *energy_stages(lagrange, by_squares=False),
            Stage("Cyclic coordinates", _SINCE, tuple(momenta)),
            Stage("Velocities of the cyclic coordinates", _RATES, tuple(velocities)),
            Stage(
                "Routh's function",
                _FUNCTION,
                (
                    Result(Left("R"), R, lambda: shown_R),
                    Result(Left("V_eff"), effective, lambda: shown_V),
                ),
            ),
            *energy_integral(lagrange, by_squares=False),
        ),
        assumptions=tuple(a for work in lagrange.works for a in work.assumptions),
        closing=_closing(lagrange, bool(rows)),
        unknowns=_meanings(lagrange, ignored),
        written=tuple(written),
    )
    return Routh(derivation, tuple(ignored), tuple(parts))


def _meanings(lagrange: Lagrange, ignored: Sequence[Ignored]) -> dict[str, str]:
    """Return the meaning of each momentum, with its unit."""
    unit = units(lagrange.algebra.mechanism)
    meanings = {}
    for coordinate in ignored:
        of_turning = unit[coordinate.name] == "rad"
        size = "kg·m²/s" if of_turning else "kg·m/s"
        meanings[name_of(coordinate.momentum)] = f"momentum of {coordinate.name}, constant [{size}]"
    return meanings


def _closing(lagrange: Lagrange, any_left: bool) -> str:
    if not any_left:
        return "Every coordinate is cyclic: all velocities follow from the momenta, by quadrature."
    kinds = {work.kind for work in lagrange.works}
    loss = " + ∂D/∂q'" if "dissipation" in kinds else ""
    drive = "Q" if "work" in kinds else "0"
    return (
        f"For each other coordinate d/dt ∂R/∂q' - ∂R/∂q{loss} = {drive}: Lagrange's equations with "
        "R in place of L, which contain the momenta and no cyclic coordinate."
    )


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
