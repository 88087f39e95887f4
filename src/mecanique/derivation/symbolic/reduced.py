"""Reduce Lagrange's equations: by momenta of cyclic coordinates, or by kinematic coefficients."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import partial
from operator import attrgetter
from typing import NamedTuple, final

import numpy as np

from mecanique.derivation.printing.equations import expression, join
from mecanique.derivation.printing.expressions import to_formula, to_power
from mecanique.derivation.printing.formulas import Product, add, multiply, number
from mecanique.derivation.printing.writers import Equation, Expression
from mecanique.derivation.scalars.cancel import by_velocity, tidy
from mecanique.derivation.scalars.evaluation import Evaluation
from mecanique.derivation.scalars.polynomials import exponents
from mecanique.derivation.scalars.series import TIMED, Kind, Series
from mecanique.derivation.symbolic.derivation import (
    Derivation,
    Ending,
    Left,
    Result,
    Stage,
    Tie,
    along_displacement,
    lefts_of,
    mass_and_bias,
)
from mecanique.derivation.symbolic.kinematics import geometry_stages
from mecanique.derivation.symbolic.lagrange import (
    ENERGY_INTEGRAL,
    Lagrange,
    collect_squares,
    energy_integral,
    energy_stages,
    split_by_degree,
    write_momentum,
)
from mecanique.derivation.symbolic.multipliers import (
    Quotient,
    is_constant,
    loop_stages,
    name_of,
    say_where,
    solve_multipliers,
)
from mecanique.derivation.symbolic.symbols import Algebra, coordinate_of
from mecanique.derivation.tolerances import RANK
from mecanique.errors import DerivationError
from mecanique.model.mechanism.letters import find_name
from mecanique.model.mechanism_units import characteristic_length, units
from mecanique.model.random_positions import draw_positions
from mecanique.wording import enumerate_words

COEFFICIENTS = "Kinematic coefficients"
"""Title of the step that finds them."""

_LETTERS = ("p", "P", "pi")
"""Letters for a momentum, before the name of its coordinate."""

_CYCLIC, _FOLLOWING, _ROUTH = (
    "Cyclic coordinates",
    "Velocities of the cyclic coordinates",
    "Routh's function",
)
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
_LEFT_BY_MOMENTA = (
    "{} cyclic: {} from {}, and for {} left, with the effective potential V_eff{} (Routh)."
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

    @property
    def ending(self) -> Ending:
        """What is left of the equations, to end a derivation with; empty without new terms."""
        derivation, ignored = self.derivation, self.ignored
        letters = {name_of(coordinate.momentum) for coordinate in ignored}
        used = {g.name for parts in self.parts for part in parts for g in part.generators()}
        if not letters & used:  # equations that the momenta do not enter are said without them
            return Ending()
        gone = {coordinate.name for coordinate in ignored}
        every = derivation.algebra.mechanism.coordinates
        cyclic = [name for name in every if name in gone]
        others = enumerate_words([name for name in every if name not in gone])
        written = derivation.written or ()
        stages = {stage.title: stage.results for stage in derivation.stages}
        energy = stages.get(ENERGY_INTEGRAL, ())
        several, equations = len(cyclic) > 1, len(written) > 1
        sentence = _LEFT_BY_MOMENTA.format(
            f"{enumerate_words(cyclic)} {'are' if several else 'is'}",
            "their velocities follow" if several else "its velocity follows",
            f"the constant {'momenta' if several else 'momentum'} p",
            f"{others} {'these equations are' if equations else 'one equation is'}",
            " and the constant energy E in it" if energy else "",
        )
        rates = reversed(stages[_FOLLOWING])  # the last one is given by momenta alone
        momenta = dict(zip((x.name for x in ignored), stages[_CYCLIC], strict=True))
        listed = [momenta[name] for name in cyclic]
        lines: tuple[Result, ...] = (*listed, *rates, *stages[_ROUTH][1:], *energy)
        return Ending(sentence, (*lines, *written), derivation.unknowns)


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
    degrees = split_by_degree(kinetic)
    still = degrees.get(0, ring.number(0))
    effective = tidy(ring.sum([*(coordinate.energy for coordinate in ahead), V, -still]))
    shown_V = join([*(coordinate.shown_energy(1) for coordinate in ahead), expression(V - still)])
    energy = degrees.get(2, ring.number(0)) + ring.parameter("V_eff")
    energy += lagrange.load_potential or ring.number(0)
    integrals = [
        replace(stage, results=(Result(Left("E"), energy),))
        if stage.title == ENERGY_INTEGRAL
        else stage
        for stage in energy_integral(lagrange, by_squares=False)
    ]
    momenta, velocities = list[Result](), list[Result]()
    for coordinate in ignored:
        name, v = coordinate.name, f"{coordinate.name}'"
        letter = name_of(coordinate.momentum).removesuffix(f"_{name}")
        p = tidy(lagrange.T.diff(v))
        momentum = partial(write_momentum, p, v, collect_squares(lagrange.squares))
        momenta.append(Result(Left(letter, name, component=True), p, momentum))
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
            Stage(_CYCLIC, _SINCE, tuple(momenta)),
            Stage(_FOLLOWING, _RATES, tuple(velocities)),
            Stage(
                _ROUTH,
                _FUNCTION,
                (
                    Result(Left("R"), R, lambda: shown_R),
                    Result(Left("V_eff"), effective, lambda: shown_V),
                ),
            ),
            *integrals,
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
    return meanings | {"V_eff": "effective potential [J]"}


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


_FOLLOWING_LOOPS = (
    "The loops make every other coordinate a function of {0}: its velocity is K {0}'{1}, with the "
    "kinematic coefficient K named after it. Inserted into Φ' = 0, and divided by {0}', these are "
    "linear equations for the coefficients."
)
_SUM = (
    "The equation of each coordinate is multiplied by its coefficient, that of {0} by 1, and all "
    "are added: along such a displacement the forces λ of the loops do no work, and cancel."
)
_SUM_OF_WORK = (
    "Inserted into the sum of the virtual work, these displacements leave δ{0} alone, which is "
    "arbitrary: its coefficient is zero."
)
_REFERRED = (
    "With the velocities K {0}' and the accelerations K {0}'' + L {0}'² inserted, {J} collects "
    "what multiplies {0}'', the inertia referred to {0}; {1} what multiplies {0}'², which is ½ "
    "d{J}/d{0}; and Q_{0}, the generalized force, all else."
)
_LEFT = (
    "One equation is left for {0}{2}: {J} {0}'' + {1} {0}'² = Q_{0}. The loops give the other "
    "coordinates, Φ = 0."
)
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
    "With these the kinetic energy is ½ {J} {0}'², where {J} is the inertia referred to {0}: each"
    " mass times the square of its coefficient. {1} = ½ d{J}/d{0} accounts for the change of {J}."
)
_CLOSING = (
    "{J} {0}'' + {1} {0}'² equals the sum of all forces, each times the coefficient of the "
    "coordinate along which it acts: one equation without multipliers. It holds where no divisor "
    "above is zero; the loops give the other coordinates for each {0}."
)
_LEFT_BY_LOOPS = (
    "The loops give every other coordinate for each {0}, with the velocity K {0}' and the "
    "acceleration K {0}'' + L {0}'²; the equations reduce to one without multipliers{2}. {J} is "
    "the inertia referred to {0}, and {1} half its derivative d{J}/d{0}."
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
    rates: tuple[Series, ...]  # what these keep zero per unit velocity, linear in the coefficients
    # the sum of the equations of motion, each times its coefficient, without multipliers
    weighted: Series
    energy: Sequence[Stage]  # the step that states its energy, if that is constant

    def end(self, *, of_work: bool) -> Ending:
        """Return the equation with its coefficients and its energy, to end a derivation with."""
        follow, change, refer = self.derivation.stages[-3:]
        lines = [*follow.results, *change.results, *refer.results]
        *_, inertia, bias = lefts_of(lines)
        equation, _ = self.derivation.written or ()
        where = say_where(term.value for term in (*self.ratios, *self.changes))
        kept, unknowns = self.coordinate, self.derivation.unknowns
        letters = partial(str.format, J=inertia.symbol)
        sentence = letters(_LEFT_BY_LOOPS, kept, bias.symbol, where)
        displaced = f", and its virtual displacement K δ{kept}" if of_work else ""
        force = self.parts[0].ring.sum([-part for part in self.parts[2:]])
        pull = Result(Left("Q", kept, component=True), tidy(force))
        whole = Result(self.weighted, force.ring.number(0))
        integrals = tuple(line for stage in self.energy for line in stage.results)
        sections = (
            Ending(
                _FOLLOWING_LOOPS.format(kept, displaced),
                (*(Result(demand, force.ring.number(0)) for demand in self.rates), *follow.results),
                title=follow.title,
            ),
            Ending(
                (_SUM_OF_WORK if of_work else _SUM).format(kept),
                (whole,),
                title="Sum along the displacement",
            ),
            Ending(change.explanation, change.results, title=change.title),
            Ending(
                letters(_REFERRED, kept, bias.symbol), (*refer.results, pull), title=refer.title
            ),
            Ending(letters(_LEFT, kept, bias.symbol, where), (equation,)),
            Ending(" ".join(stage.explanation for stage in self.energy), integrals),
        )
        return Ending(sentence, (*lines, equation, *integrals), unknowns, sections=sections)


def reduce_to_one(lagrange: Lagrange, coordinate: str = "") -> ReducedEquation:
    """Derive the single equation of a mechanism with loops and one degree of freedom."""
    algebra = lagrange.algebra
    mechanism = algebra.mechanism
    kept = find_name(mechanism, coordinate or mechanism.coordinates[0], mechanism.coordinates)
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
        # the steps name points and bodies as well
        mechanism = self.algebra.mechanism
        parts = (*mechanism.bodies, *mechanism.joints, *mechanism.loops)
        taken = {part.name for part in parts}
        change = next(letter for letter in ("C", "N", "U", "C_") if letter not in taken)
        self.J, self.C = (self._adjoin(letter, ahead=True) for letter in ("J", change))

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
        accelerations = [ring[name] for name in algebra.accelerations]
        rows = []
        for row, h, Q in zip(full.M, full.h, full.Q, strict=True):
            rows.append(ring.sum([along_displacement(row, accelerations), h, -Q]))
        weighted = by_velocity(along_displacement(ratios, rows), algebra.velocities)
        rates = tuple(map(tidy, first))
        energy = energy_integral(self.lagrange, square=self.J * v**2 / 2)
        return ReducedEquation(
            derivation, kept, K, L, parts, self.ties, rates, weighted=weighted, energy=energy
        )

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
        named, push = [expression(inertia * a)], forces - rest
        if C:
            named.append(expression(change * v**2))
            push = push - change * v**2
        left = join([*named, *([expression(rest)] if rest else [])])
        equation = Equation(left, expression(forces), ring.number(1))
        solved = Quotient(push, inertia).equate(f"{kept}''")
        M, h = mass_and_bias(self.algebra, [J * a + C * v**2 + rest - forces])
        closed = [stage for stage in loop_stages(full.ties, of_work=True) if stage.title == "Loops"]
        before = [stage for stage in full.stages if stage.title in _ENERGIES]
        first, second = (tuple(map(Coefficient.result, ratios)) for ratios in (K, L))
        pairs = ((inertia, J), (change, C))
        inertias = tuple(
            Result(Left(name_of(a)), b, partial(self._by_coefficients, b)) for a, b in pairs
        )
        say = partial(str.format, J=name_of(inertia))
        return replace(
            full,
            M=M,
            h=h,
            Q=(ring.number(0),),
            stages=(
                *before,
                *closed,
                Stage(COEFFICIENTS, _FOLLOW.format(kept), first),
                Stage("Derivatives of the coefficients", _CHANGE.format(kept), second),
                Stage(
                    f"Inertia referred to {kept}", say(_INERTIA, kept, name_of(change)), inertias
                ),
            ),
            closing=say(_CLOSING, kept, name_of(change)),
            unknowns=dict(self._meanings(K, L)),
            quasi=(),
            written=(equation, solved),
        )

    def _by_coefficients(self, series: Series) -> Expression:
        """Collect a series by kinematic coefficients, or by 1 + K where that has fewer terms.

        For an angle against a body that turns with the coordinate kept, 1 + K is the ratio of the
        absolute angular velocity.
        """
        ring, one = self.ring, self.ring.number(1)
        letters = {name_of(letter): letter for letter in (*self.K.values(), *self.L.values())}
        turned = set[str]()
        for name in map(name_of, self.K.values()):
            slope = letters[name] - one
            by_power = series.coefficients([name]).items()
            shifted = tidy(ring.sum(part * slope**p for (p,), part in by_power))
            if len(shifted) < len(series):
                series = shifted
                turned.add(name)
        parts = []
        for powers, rest in series.coefficients([*letters]).items():
            product, ratios = rest, number(1)
            for (name, letter), p in zip(letters.items(), powers, strict=True):
                if name in turned:
                    ratios = multiply(ratios, (add([*expression(one + letter).terms]), p))
                else:
                    product = product * letter**p
            whole = expression(product)
            terms = tuple(multiply(term, ratios) for term in whole.terms)
            parts.append((sum(powers), replace(whole, terms=terms)))
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
