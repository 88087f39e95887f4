"""Reduce a mechanism with loops and one degree of freedom to one equation of motion."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any, NamedTuple, final

import numpy as np

from mecanique.derivation.document import Document
from mecanique.derivation.methods import derive
from mecanique.derivation.printing.equations import expression, join
from mecanique.derivation.printing.prose import to_latex
from mecanique.derivation.printing.writers import Equation, Expression, Text
from mecanique.derivation.scalars.cancel import tidy
from mecanique.derivation.scalars.evaluation import Evaluation, relative_rest
from mecanique.derivation.scalars.polynomials import exponents
from mecanique.derivation.scalars.series import TIMED, Series
from mecanique.derivation.symbolic.derivation import (
    Derivation,
    Left,
    Result,
    Stage,
    Tie,
    along_displacement,
    mass_and_bias,
)
from mecanique.derivation.symbolic.lagrange import Lagrange
from mecanique.derivation.symbolic.multipliers import (
    Quotient,
    loop_stages,
    name_of,
    solve_multipliers,
)
from mecanique.derivation.symbolic.symbols import Algebra
from mecanique.derivation.tolerances import CLOSED_WELL, FIRM, RANK
from mecanique.errors import DerivationError, UnknownNameError
from mecanique.model.mechanism import Mechanism
from mecanique.model.mechanism_units import characteristic_length, units
from mecanique.model.random_positions import draw_positions
from mecanique.wording import Legible

_FOLLOW = (
    "The loops make every other coordinate a function of {0}: its velocity is K {0}', with the "
    "kinematic coefficient K named after it. The loop equations, differentiated by {0}, are linear "
    "in these. In this order, each follows from the loops and the coefficients above it."
)
_CHANGE = (
    "The derivatives of the coefficients, L = dK/d{0}, follow from the loop equations "
    "differentiated once more: the acceleration of the coordinate is K {0}'' + L {0}'²."
)
_INERTIA = (
    "With these the kinetic energy is ½ J {0}'², where J is the inertia referred to {0}: each mass "
    "times the square of its coefficient. C = ½ dJ/d{0} accounts for the change of J."
)
_CLOSING = (
    "J {0}'' + C {0}'² equals the sum of all forces, each times the coefficient of the coordinate "
    "along which it acts: one equation without multipliers. It holds where no divisor above is "
    "zero; the loops give the other coordinates for each {0}."
)


class Coefficient(NamedTuple):
    """A kinematic coefficient, or the derivative of one, in terms of those before it."""

    coordinate: str  # the coordinate that it belongs to
    name: str  # its letter
    value: Quotient

    def result(self) -> Result:
        """Return the line that states it."""
        return Result(Left(self.name), self.value.above, self.value.fraction)


@final
@dataclass(frozen=True)
class ReducedEquation:
    """The single equation of a mechanism with one degree of freedom."""

    derivation: Derivation  # the equation with its steps
    coordinate: str  # the coordinate that is kept
    ratios: tuple[Coefficient, ...]  # K of each other coordinate, in the order of their definitions
    changes: tuple[Coefficient, ...]  # L of each, likewise
    # the terms of the equation, which sum to zero, in terms of all coordinates, the velocity and
    # acceleration of the kept one, and the coefficients
    parts: tuple[Series, ...]
    ties: tuple[Tie, ...]  # the independent equations of the loops


def reduce_to_one(lagrange: Lagrange, coordinate: str = "") -> ReducedEquation:
    """Derive the single equation of a mechanism with loops and one degree of freedom."""
    algebra = lagrange.algebra
    mechanism = algebra.mechanism
    kept = coordinate or mechanism.coordinates[0]
    if kept not in mechanism.coordinates:
        raise UnknownNameError("coordinate", kept, tuple(mechanism.coordinates))
    still = all(not (tie.of_velocities or tie.of_contact) for tie in lagrange.ties)
    if still and any(not tie.demand.kinds.isdisjoint(TIMED) for tie in lagrange.ties):
        raise DerivationError(f"mechanism {mechanism.name!r}: its loops depend on time")
    ties = independent_ties(algebra, lagrange.ties) if still and lagrange.ties else ()
    if not ties or not still or len(ties) != len(algebra.velocities) - 1:
        raise DerivationError(
            f"mechanism {mechanism.name!r}: expected loops that leave one of its "
            f"{len(algebra.velocities)} velocities free, got {len(ties)} equations of loops"
        )
    return _Reducing(lagrange, kept, ties).single()


def independent_ties(algebra: Algebra, ties: Sequence[Tie]) -> tuple[Tie, ...]:
    """Return the ties that no others follow from in any position, open ones included."""
    # In a tilted plane a gap has three components, of which two are independent
    mechanism, ring = algebra.mechanism, algebra.ring
    names, random = mechanism.coordinates.names, np.random.default_rng(0)
    slopes = []
    for q in draw_positions(mechanism, _POSITIONS, random, characteristic_length(mechanism)):
        values = {**mechanism.values, **dict(zip(names, q.tolist(), strict=True))}
        evaluate = Evaluation(ring, values)
        entries = (entry for tie in ties for entry in tie.slopes(ring))
        slopes.append(np.array([*map(evaluate, entries)], dtype=float).reshape(len(ties), -1))
    rows = np.concatenate(slopes, axis=1)
    rest, chosen = rows, list[int]()
    for _ in ties:
        sizes = np.linalg.norm(rest, axis=1)
        longest = int(np.argmax(sizes))
        if sizes[longest] <= RANK * np.linalg.norm(rows[longest]):
            break
        chosen.append(longest)
        along = rest[longest] / sizes[longest]
        rest = rest - np.outer(rest @ along, along)
    return tuple(ties[k] for k in sorted(chosen))


class _Reducing:
    """The loops of a mechanism, differentiated by the coordinate that is kept."""

    def __init__(self, lagrange: Lagrange, kept: str, ties: tuple[Tie, ...]) -> None:
        self.lagrange, self.kept, self.ties = lagrange, kept, ties
        self.algebra = lagrange.algebra
        self.ring = self.algebra.ring
        self.others = [name for name in self.algebra.mechanism.coordinates if name != kept]
        self.K = {name: self._adjoin(f"K_{name}") for name in self.others}
        self.L = {name: self._adjoin(f"L_{name}") for name in self.others}
        self.J, self.C = (self._adjoin(letter, ahead=True) for letter in "JC")

    def _adjoin(self, name: str, *, ahead: bool = False) -> Series:
        """Adjoin a letter under an unused name, ordered after lengths or ahead of them."""
        free = self.ring.choose_name((name, f"{name}_", f"{name}__"))
        self.ring.places[free] = 0 if ahead else _AFTER_LENGTHS
        return self.ring.parameter(free)

    def along(self, series: Series) -> Series:
        """Return d/dθ of a function of the coordinates and the coefficients."""
        terms = [series.diff(self.kept)]
        for name in self.others:
            terms.append(series.diff(name) * self.K[name])
            terms.append(series.diff(self.K[name]) * self.L[name])
        return self.ring.sum(terms)

    def solve(
        self, demands: Sequence[Series], letters: dict[str, Series]
    ) -> tuple[Coefficient, ...]:
        """Solve constraint equations that are linear in the coefficients for these."""
        owners = {name_of(letter): name for name, letter in letters.items()}
        rows, rests = zip(*(demand.linear([*owners]) for demand in demands), strict=True)
        entries = [list(map(tidy, column)) for column in zip(*rows, strict=True)]
        solved = solve_multipliers([*letters.values()], entries, [-rest for rest in rests])
        if not solved:
            raise DerivationError(
                f"mechanism {self.algebra.mechanism.name!r}: the kinematic coefficients with "
                f"respect to {self.kept} have no short closed form"
            )
        return tuple(Coefficient(owners[name], name, value) for name, value in solved.items())

    def single(self) -> ReducedEquation:
        """Return the equation."""
        ring, algebra, kept = self.ring, self.algebra, self.kept
        first = [self.along(_angle_of(tie.demand)) for tie in self.ties]
        second = [self.along(demand) for demand in first]
        K, L = self.solve(first, self.K), self.solve(second, self.L)
        one = ring.number(1)
        ratios = [self.K.get(name, one) for name in algebra.mechanism.coordinates]
        changes = [self.L.get(name, ring.number(0)) for name in algebra.mechanism.coordinates]
        full = self.lagrange.derivation()
        meets = [along_displacement(ratios, row) for row in full.M]
        grows = [along_displacement(changes, row) for row in full.M]
        J = tidy(along_displacement(ratios, meets))
        v, a = ring[f"{kept}'"], ring[f"{kept}''"]
        bias = [self._put(h) for h in full.h]
        forces = self._put(along_displacement(ratios, full.Q))
        carried = tidy(along_displacement(ratios, bias))
        powers = carried.coefficients([f"{kept}'"])
        square = powers.pop((2,), ring.number(0))
        C = tidy(along_displacement(ratios, grows) + square)
        rest = ring.sum([part * v**p for (p,), part in powers.items()])
        parts = (J * a, C * v**2, rest, -forces)
        derivation = self._derivation(full, K, L, J, C, rest, forces)
        return ReducedEquation(derivation, kept, K, L, parts, self.ties)

    def _put(self, series: Series) -> Series:
        """Replace the velocities of the other coordinates by K θ'."""
        ring, v = self.ring, self.ring[f"{self.kept}'"]
        names = self.algebra.mechanism.coordinates
        ratios = [self.K.get(name, ring.number(1)) for name in names]
        terms = []
        for powers, coefficient in series.coefficients(self.algebra.velocities).items():
            term = coefficient
            for ratio, p in zip(ratios, powers, strict=True):
                term = term * (ratio * v) ** p
            terms.append(term)
        return ring.sum(terms)

    def _derivation(
        self,
        full: Derivation,
        K: Sequence[Coefficient],
        L: Sequence[Coefficient],
        J: Series,
        C: Series,
        rest: Series,
        forces: Series,
    ) -> Derivation:
        kept, ring = self.kept, self.ring
        inertia, change = self.J, self.C
        a, v = ring[f"{kept}''"], ring[f"{kept}'"]
        named = [expression(inertia * a)]
        if C:
            named.append(expression(change * v**2))
        left = join([*named, *([expression(rest)] if rest else [])])
        equation = Equation(left, expression(forces), ring.number(1))
        push = forces - rest - change * v**2 if C else forces - rest
        solved = Quotient(push, inertia).equate(f"{kept}''")
        M, h = mass_and_bias(self.algebra, [J * a + C * v**2 + rest - forces])
        closed = [stage for stage in loop_stages(full.ties, of_work=True) if stage.title == "Loops"]
        before = [stage for stage in full.stages if stage.title in _ENERGIES]

        def state(coefficients: Sequence[Coefficient]) -> tuple[Result, ...]:
            return tuple(coefficient.result() for coefficient in coefficients)

        pairs = ((inertia, J), (change, C))
        inertias = tuple(
            Result(Left(name_of(a)), b, partial(self._by_coefficients, b)) for a, b in pairs
        )
        return replace(
            full,
            M=M,
            h=h,
            Q=(ring.number(0),),
            stages=(
                *before,
                *closed,
                Stage("Kinematic coefficients", _FOLLOW.format(kept), state(K)),
                Stage("Derivatives of the coefficients", _CHANGE.format(kept), state(L)),
                Stage(f"Inertia referred to {kept}", _INERTIA.format(kept), inertias),
            ),
            closing=_CLOSING.format(kept),
            unknowns=dict(self._meanings(K, L)),
            quasi=(),
            written=(equation, solved),
        )

    def _by_coefficients(self, series: Series) -> Expression:
        """Collect a series by kinematic coefficients."""
        letters = [*self.K.values(), *self.L.values()]
        parts = []
        for powers, rest in series.coefficients([*map(name_of, letters)]).items():
            product = rest
            for letter, p in zip(letters, powers, strict=True):
                product = product * letter**p
            parts.append((sum(powers), expression(product)))
        ordered = sorted(parts, key=lambda part: part[0])
        return join(part for _, part in ordered) if ordered else expression(series)

    def _meanings(
        self, K: Sequence[Coefficient], L: Sequence[Coefficient]
    ) -> Iterator[tuple[str, str]]:
        """Yield each letter with its meaning and unit."""
        unit = units(self.algebra.mechanism)
        by = unit[self.kept]
        for term in K:
            size = f"{unit[term.coordinate]}/{by}"
            yield term.name, f"kinematic coefficient d{term.coordinate}/d{self.kept} [{size}]"
        for term in L:
            size = f"{unit[term.coordinate]}/{by}²"
            yield term.name, f"its derivative, d²{term.coordinate}/d{self.kept}² [{size}]"
        inertia, change = ("kg·m²", "kg·m²/rad") if by == "rad" else ("kg", "kg/m")
        yield name_of(self.J), f"inertia referred to {self.kept} [{inertia}]"
        yield (
            name_of(self.C),
            f"half its derivative, ½ dJ/d{self.kept} [{change}]",
        )


_POSITIONS = 3
"""Random positions at which equations of loops must depend on each other to be redundant."""

_AFTER_LENGTHS = 4
"""Position of the coefficients in a product: m l² K."""

_ENERGIES = ("Positions and velocities", "Kinetic energy", "Potential energy")


def _angle_of(demand: Series) -> Series:
    """Return the angle whose sine, times a number, is to vanish; any other demand as it is."""
    # Where the loop is closed the cosine is 1 or −1, so that the rates of both vanish together
    if len(demand) != 1:
        return demand
    ((trig, monomial, _),) = demand.terms()
    if not trig & 1 or monomial:
        return demand
    ring = demand.ring
    return ring.sum([k * ring.angles[j].argument for j, k in exponents(trig >> 1)])


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
