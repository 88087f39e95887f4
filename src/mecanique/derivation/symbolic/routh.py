"""Reduce Lagrange's equations by the momenta of cyclic coordinates, with Routh's function."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from operator import attrgetter
from typing import final

from mecanique.derivation.printing.equations import expression, join
from mecanique.derivation.printing.expressions import to_formula, to_power
from mecanique.derivation.printing.formulas import Product, add, multiply, number
from mecanique.derivation.printing.writers import Equation, Expression
from mecanique.derivation.scalars.cancel import by_velocity, tidy
from mecanique.derivation.scalars.series import Kind, Series
from mecanique.derivation.symbolic.derivation import (
    Derivation,
    Ending,
    Left,
    Result,
    Stage,
    mass_and_bias,
)
from mecanique.derivation.symbolic.kinematics import geometry_stages
from mecanique.derivation.symbolic.lagrange import (
    ENERGY_INTEGRAL,
    Lagrange,
    energy_integral,
    energy_stages,
    split_by_degree,
)
from mecanique.derivation.symbolic.multipliers import Quotient, is_constant, name_of
from mecanique.derivation.symbolic.symbols import coordinate_of
from mecanique.errors import DerivationError
from mecanique.model.mechanism_units import units
from mecanique.wording import enumerate_words

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
_ENDING = "{} cyclic: {} from {}, and for {} left, with the effective potential V_eff (Routh)."


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
        several, equations = len(cyclic) > 1, len(written) > 1
        sentence = _ENDING.format(
            f"{enumerate_words(cyclic)} {'are' if several else 'is'}",
            "their velocities follow" if several else "its velocity follows",
            "the constant momenta" if several else "the constant momentum",
            f"{others} {'these equations are' if equations else 'one equation is'}",
        )
        stages = {stage.title: stage.results for stage in derivation.stages}
        energy = stages.get(ENERGY_INTEGRAL, ())
        rates = reversed(stages[_FOLLOWING])  # the last one is given by momenta alone
        lines: tuple[Result, ...] = (*stages[_CYCLIC], *rates, *stages[_ROUTH][1:], *energy)
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
