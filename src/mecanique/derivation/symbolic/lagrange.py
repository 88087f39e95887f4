"""Derive Lagrange's equations in Poisson series: d/dt ∂T/∂q' − ∂T/∂q + ∂V/∂q + ∂D/∂q' = Q.

The velocities ω, or v and ω, of a joint with a quaternion are quasi-velocities, not rates of
coordinates; for them the operator has the additional terms of Euler and Kirchhoff, ω × ∂T/∂ω +
v × ∂T/∂v (H. Lamb, Hydrodynamics, 1932, art. 124, eqs. 2).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property, partial
from math import prod
from typing import TypeAlias, final

from mecanique.derivation.printing.equations import (
    add_weighted,
    energy,
    expression,
    gather_alike,
    half_square,
    half_squares,
    join,
    shorter,
)
from mecanique.derivation.printing.writers import Expression
from mecanique.derivation.scalars.cancel import by_velocity, tidy
from mecanique.derivation.scalars.series import TIMED, Euler, Kind, Series
from mecanique.derivation.symbolic.constraints import bonds_of, distances_of, ties_of
from mecanique.derivation.symbolic.derivation import (
    Derivation,
    Left,
    Result,
    Stage,
    mass_and_bias,
)
from mecanique.derivation.symbolic.forces import (
    Work,
    find_potentials,
    length_names,
    store_constant,
    works_of,
)
from mecanique.derivation.symbolic.inertias import inertia_stages, list_moments
from mecanique.derivation.symbolic.kinematics import (
    Kinematics,
    geometry_stages,
    quaternion_stages,
    relation_stages,
)
from mecanique.derivation.symbolic.multipliers import (
    loop_stages,
    multiplier_stages,
    redundancy_stages,
)
from mecanique.derivation.symbolic.named_inertias import name_inertias
from mecanique.derivation.symbolic.symbols import Algebra, coordinate_of
from mecanique.derivation.symbolic.vectors import Vector, along, cross
from mecanique.derivation.tree.poses import combination
from mecanique.errors import DerivationError
from mecanique.model.mechanism import Mechanism
from mecanique.model.mechanism.letters import call
from mecanique.wording import enumerate_words

ENERGY_INTEGRAL = "Energy integral"
"""Title of the step that states the constant energy."""

Squares: TypeAlias = "tuple[tuple[Series, Series], ...]"
"""Moments of inertia I about fixed axes' common point, and rates w, with T = Σ ½ I w²."""


def _write_squares(T: Series, squares: Squares) -> Expression:
    """Write a kinetic energy by the squares of angular velocities, where that is shorter."""
    plain = energy(T)
    if not squares:
        return plain
    written = plain
    for taken in (squares, [(factor, w) for factor, w in squares if len(w) > 1]):
        rest = tidy(T - T.ring.sum([factor * w * w / 2 for factor, w in taken]))
        around = (energy(rest),) if rest else ()
        written = shorter(join((*around, half_squares(taken))), written)
    return written


def collect_squares(squares: Mapping[str, Squares]) -> Squares:
    """Return the squares of all bodies, none if a body has none."""
    if not all(squares.values()):
        return ()
    return tuple(pair for pairs in squares.values() for pair in pairs)


def energy_stages(lagrange: Lagrange, *, by_squares: bool = True) -> list[Stage]:
    """Return the steps that find the kinetic and the potential energy."""
    squares = lagrange.squares if by_squares else {}
    T, V, gravity, works = lagrange.T, lagrange.V, lagrange.gravity, lagrange.works
    heavy = any(lagrange.algebra.mechanism.gravity)
    parts = [
        Result(Left(f"T_{name}"), part, partial(_write_squares, part, squares.get(name, ())))
        for name, part in lagrange.kinetic
        if part
    ]
    parts = parts if len(parts) > 1 else []
    whole = Result(Left("T"), T, partial(_write_squares, T, collect_squares(squares)))
    stages = [Stage("Kinetic energy", _say_kinetic(lagrange), (*parts, whole))]
    stored = _list_energies(gravity, works)
    sentences = []
    if gravity:
        sentences.append(
            "The work of the weights is the decrease of V, which is zero where all centers of mass "
            "are at the height of the origin."
        )
    elif heavy:
        sentences.append("The weights do no work in this motion.")
    potentials = [work for work in works if work.kind == "potential"]
    if any(work.elastic for work in potentials):
        sentences.append(
            "Each spring adds to V half its stiffness times the square of its elongation."
        )
    given = [work.name for work in potentials if work.stated and not work.elastic]
    if given:
        sentences.append(f"The potential V of {enumerate_words([*map(call, given)])} is given.")
    loads = [work.name for work in potentials if not work.stated]
    if loads:
        depend = "depends" if len(loads) == 1 else "depend"
        sentences.append(
            f"{enumerate_words(loads)} {depend} on the position alone, and the work along any path "
            "on its ends alone: the generalized forces are the derivatives of -V."
        )
    if _is_timed(V) and not _is_timed(T) and _find_orders(T) <= {2}:
        sentences.append(
            "V depends on time, so that the total energy is no integral: it changes at the rate "
            "∂V/∂t, and by the work of forces without potential."
        )
    if stored:
        several = stored if len(stored) > 1 else []
        whole = Result(Left("V"), V, partial(_write_potential, gravity, works, V))
        stages.append(Stage("Potential energy", " ".join(sentences), (*several, whole)))
    elif not V:
        sentence = "There are neither weights nor springs: V is zero."
        if heavy:
            sentence = "The weights do no work in this motion, and there are no springs: V is zero."
        stages.append(Stage("Potential energy", sentence, (Result(Left("V"), V),)))
    return stages


def _say_kinetic(lagrange: Lagrange) -> str:
    """Say of which terms the kinetic energy is the sum."""
    kinematics = lagrange.kinematics
    moments = [entry for body in kinematics.bodies for entry in list_moments(kinematics, body)]
    names = [str(entry.left.symbol) for entry in moments if isinstance(entry.left, Left)]
    parts = ["half its mass times the square of the velocity of its center of mass"]
    if names:
        half = "half its moments of inertia times the squares of its angular velocities"
        parts.append(f"{half} about their axes")
    if any(name[-1] != name[-2] for name in names):
        parts.append("its products of inertia, each times the angular velocities about both axes")
    said = f"The kinetic energy of a body is {', plus '.join(parts)}; the sum over all bodies is T."
    if len(lagrange.kinetic) > len(kinematics.bodies):
        said += " A rotor adds half its inertia times the square of the rate of its joint."
    return said


def _list_energies(gravity: Series, works: Sequence[Work]) -> list[Result]:
    """List the energy of the weights and of each spring."""
    springs = [work for work in works if work.kind == "potential" and work.scalar is not None]
    stored = [_store(work.name, work) for work in springs if work.scalar]
    weights = Result(Left("V_gravity"), gravity, partial(energy, gravity))
    return [weights, *stored] if gravity else stored


def _write_potential(gravity: Series, works: Sequence[Work], V: Series) -> Expression:
    """Write the potential energy spring by spring, where that is shorter."""
    parts = join(part.expression() for part in _list_energies(gravity, works))
    return shorter(gather_alike(parts), energy(V))


def _store(name: str, work: Work) -> Result:
    """Write the energy of a spring, as a square where its elongation is known."""
    assert work.scalar is not None
    shown = None if work.square is None else partial(half_square, *work.square)
    return Result(Left(f"V_{name}"), work.scalar, shown)


def write_momentum(p: Series, velocity: str, squares: Squares) -> Expression:
    """Write the momentum Σ I w ∂w/∂q' with its angular velocities as they are, if shorter."""
    plain = expression(p)
    parts = [(tidy(factor * slope), w) for factor, w in squares if (slope := w.diff(velocity))]
    sums = [(share, w) for share, w in parts if len(w) > 1]
    for taken in (parts, sums) if sums else ():
        rest = tidy(p - p.ring.sum([share * w for share, w in taken]))
        around = (expression(rest),) if rest else ()
        plain = shorter(join((*around, add_weighted(taken))), plain)
    return plain


def energy_integral(
    lagrange: Lagrange, *, by_squares: bool = True, square: Series | None = None
) -> list[Stage]:
    """Return the step that states the conserved energy, if L does not depend on time."""
    # the part of T that is quadratic in the velocities may be given in other letters
    T, V, gravity, works = lagrange.T, lagrange.V, lagrange.gravity, lagrange.works
    ties, squares = lagrange.ties, collect_squares(lagrange.squares) if by_squares else ()
    # If a prescribed motion adds terms of degree 0 or 1 in the velocities to T, the conserved
    # quantity is Jacobi's integral instead (Goldstein, Classical Mechanics, 3rd ed., eq. 2.53).
    loads, U = [work for work in works if work.kind == "work"], lagrange.load_potential
    if U is None:
        return []
    timed = any(map(_is_timed, [T, V, U, *(tie.demand for tie in ties)]))
    # a constraint in steady motion, like a turntable, does work
    driven = any(tie.of_velocities and _find_orders(tie.demand) != {1} for tie in ties)
    if lagrange.D or driven or timed:
        return []
    potentials = [work for work in works if work.kind == "potential"]
    sources = ["weights"] if gravity else []
    sources += ["springs"] if any(work.elastic for work in potentials) else []
    sources += [work.name for work in (*potentials, *loads) if not work.elastic]
    idle = f"Nothing depends on time{',' if ties else ' and'} no force "
    idle += f"but {enumerate_words(sources)} does work" if sources else "does work"
    idle += ", and the constraints do none" if ties else ""

    def write_potential() -> Expression:
        return join((_write_potential(gravity, works, V), expression(U)))

    degrees, zero = split_by_degree(T), T.ring.number(0)
    shown = expression(square) if square is not None else None
    if square is None:
        square = degrees.get(2, zero)
    if degrees.keys() <= {2}:
        whole = "E = T + V"
        if U:
            constant = "load" if len(loads) == 1 else "loads"
            whole += f", with the potential {expression(U).text()} of the constant {constant},"
        sentence = f"{idle}: the total energy {whole} is constant along any motion."
        energy = Result(
            Left("E"),
            square + V + U,
            lambda: join((shown or _write_squares(T, squares), write_potential())),
        )
        return [Stage(ENERGY_INTEGRAL, sentence, (energy,))]
    rest = degrees.get(0, zero)
    sentence = (
        "L = T - V does not depend on time, but a drive maintains the prescribed motion and does "
        "work, so the total energy changes. The conserved quantity is Jacobi's integral "
        "h = Σ q' ∂T/∂q' - L: V plus the part of T that is quadratic in the velocities, minus the "
        "part without velocities."
    )
    integral = Result(
        Left("h"),
        square + V + U - rest,
        lambda: join((expression(square), expression(-rest), write_potential())),
    )
    return [Stage("Jacobi's integral", sentence, (integral,))]


def _is_timed(series: Series) -> bool:
    """Return whether time or an input is in a series."""
    return not series.kinds.isdisjoint(TIMED)


def _find_orders(series: Series) -> set[int]:
    """Return the degrees of a series' terms in the velocities."""
    return {*map(sum, series.coefficients(series.ring.names(Kind.VELOCITY)))}


def split_by_degree(series: Series) -> dict[int, Series]:
    """Split a series into parts by their degree in the velocities."""
    ring = series.ring
    velocities = ring.names(Kind.VELOCITY)
    parts: dict[int, list[Series]] = {}
    for powers, coefficient in series.coefficients(velocities).items():
        rates = [ring[name] ** e for name, e in zip(velocities, powers, strict=True) if e]
        parts.setdefault(sum(powers), []).append(prod(rates, start=coefficient))
    return {degree: tidy(ring.sum(terms)) for degree, terms in parts.items()}


def work_stages(lagrange: Lagrange) -> list[Stage]:
    """Return the steps that treat dampers, drives and loads."""
    algebra, D = lagrange.algebra, lagrange.D
    stages = []
    if D:
        sentence = (
            "A linear damper resists with c times its rate. Half of c times the square of the rate "
            "is Rayleigh's dissipation function D; its derivative by a velocity is the force of "
            "the dampers against that velocity."
        )
        stages.append(Stage("Dissipation", sentence, (Result(Left("D"), D),)))
    loads = [work for work in lagrange.works if work.kind == "work"]
    if loads:
        sentence = (
            "In a virtual displacement each drive and each load does work; the coefficient of a "
            "coordinate's displacement is the generalized force Q of that coordinate."
        )
        results = []
        for k, name in enumerate(algebra.velocities):
            total = algebra.ring.sum([work.forces[k] for work in loads])
            results.append(Result(Left("Q", coordinate_of(name), component=True), total))
        stages.append(Stage("Virtual work of drives and loads", sentence, tuple(results)))
    return stages


def coordinate_stages(
    lagrange: Lagrange, operated: Sequence[Euler], turning: Sequence[Series]
) -> list[Stage]:
    """Return the steps that apply Lagrange's operator, one for each velocity."""
    ring, squares, stages = lagrange.algebra.ring, collect_squares(lagrange.squares), []
    columns = (
        lagrange.algebra.velocities,
        operated,
        turning,
        ring.along(lagrange.V),
        ring.partials(lagrange.D),
        lagrange.find_free(),
    )
    for v, E, terms, fall, loss, unforced in zip(*columns, strict=True):
        q = coordinate_of(v)
        quasi = q == v
        sentence = (
            "Lagrange's operator takes the momentum of a coordinate, its rate, and the derivatives "
            "of T and V by the coordinate at fixed velocities. Derivatives that are not listed are "
            "zero."
        )
        if quasi:
            sentence = (
                f"The operator for {v}, which is not the rate of a coordinate: as its axes turn "
                "with the body, it includes the terms of Euler and Kirchhoff."
            )
        conserved = unforced and not (quasi or E.slope or fall or loss)
        if conserved:
            sentence += (
                f" As neither T nor V depends on {q}, and no other force acts along it, the "
                f"momentum p_{q} = ∂T/∂{v} is conserved."
            )
        momentum = Left("p", q, component=True)
        lines = [
            (momentum, E.momentum, conserved),
            (Left("T", v), E.momentum, bool(E.momentum) and not conserved),
            (Left("T", v, total=True), E.rate, bool(E.rate)),
            (Left("T", v, turning=True), terms, bool(terms)),
            (Left("T", q), E.slope, bool(E.slope)),
            (Left("V", q), fall, bool(fall)),
            (Left("D", v), loss, bool(loss)),
        ]
        results = tuple(
            Result(left, right, partial(write_momentum, right, v, squares))
            if left is momentum
            else Result(left, right)
            for left, right, shown in lines
            if shown
        )
        if results:
            stages.append(Stage(f"Operator for {q}", sentence, results))
    return stages


@final
class Lagrange:
    """Energies, dissipation and virtual work as series, and Lagrange's operator on them."""

    def __init__(
        self, mechanism: Mechanism, algebra: Algebra | None = None, *, named: bool = False
    ) -> None:
        self.algebra = algebra = algebra or Algebra(mechanism)
        self.kinematics = Kinematics(algebra)
        self._bonds = bonds_of(self.kinematics)
        self.ties = ties_of(self.kinematics, self._bonds)
        for tie in self.ties:
            if tie.of_contact:
                _ = tie.second  # raises unless Φ'' has a closed form, too
        works = [work for force in mechanism.forces for work in works_of(self.kinematics, force)]
        self.works = find_potentials(algebra, works)
        self.kinetic = [*self._bodies(), *self._rotors()]
        T = tidy(algebra.ring.sum([series for _, series in self.kinetic]))
        slopes = [T.diff(v) for v in algebra.velocities] if named else []
        M = tuple(tuple(map(tidy, map(slope.diff, algebra.velocities))) for slope in slopes)
        self._inertias = name_inertias(algebra, M)
        self.T = self._inertias(T)
        self.gravity = tidy(algebra.ring.sum(self._weights()))
        self.V = tidy(self.gravity + self._sum("potential"))
        # what algebra found of loads: their work counts as that of loads wherever it is measured
        of_loads = [work.scalar for work in self.works if not work.stated and work.scalar]
        self.stored = tidy(self.V - algebra.ring.sum(of_loads))
        self.D = self._sum("dissipation")

    def derivation(self) -> Derivation:
        """Return the equations of motion with their steps."""
        algebra = self.algebra
        ring, names = algebra.ring, algebra.velocities
        operated = ring.euler(self.T)
        turning = self._find_turning([E.momentum for E in operated])
        falls = ring.along(self.gravity)
        inertia = [
            E.value + terms + fall for E, terms, fall in zip(operated, turning, falls, strict=True)
        ]
        M, h = mass_and_bias(algebra, inertia)
        loads = []
        for k in range(len(names)):
            loads.append(ring.sum([work.forces[k] for work in self.works]))
        return Derivation(
            algebra=algebra,
            M=M,
            h=h,
            Q=tuple(by_velocity(load, names) for load in loads),
            stages=(
                *quaternion_stages(algebra),
                *relation_stages(algebra),
                *inertia_stages(self.kinematics),
                *geometry_stages(self.kinematics),
                *energy_stages(self),
                *work_stages(self),
                *loop_stages(self.ties),
                *redundancy_stages(algebra.mechanism, self.ties),
                *coordinate_stages(self, operated, turning),
                *energy_integral(self),
                *multiplier_stages(
                    algebra, M, [a - b for a, b in zip(h, loads, strict=True)], self.ties
                ),
            ),
            assumptions=(
                *(a for work in self.works for a in work.assumptions),
                *(a for bond in self._bonds for a in bond.assumptions),
            ),
            lengths=length_names(
                ring,
                [(work.name, work.length) for work in self.works if work.length is not None],
                distances_of(self._bonds),
            ),
            closing=self._closing(),
            unknowns={f"lambda_{tie.name}": tie.meaning for tie in self.ties},
            ties=self.ties,
            energies=(self.T, self.stored),
        )

    def _bodies(self) -> Iterator[tuple[str, Series]]:
        """Yield name and kinetic energy ½ tr(Ḣ J Ḣᵀ) of each body."""
        terms = 0
        for body in self.kinematics.bodies:
            rate, J = self.kinematics.rate(body), self.kinematics.moments(body)
            columns = list(zip(*J, strict=True))
            halves = []
            for row in rate:
                HJ = [combination(row, column) for column in columns]
                halves.append(self.algebra.lift(combination(HJ, row)) / 2)
            energy = tidy(self.algebra.ring.sum(halves))
            terms += len(energy)
            if terms > self.algebra.ring.most_terms:
                raise DerivationError(
                    f"the kinetic energy has more than {self.algebra.ring.most_terms} terms, too "
                    "many to be read"
                )
            yield body, energy

    @cached_property
    def squares(self) -> dict[str, Squares]:
        """The kinetic energy of each body or rotor as squares, empty if it has no such form."""
        named = {}
        for name, T in self.kinetic:
            squares = self._list_squares(name) if name in self.kinematics.place else ()
            whole = self.algebra.ring.sum([factor * w * w / 2 for factor, w in squares])
            if T:
                moments = tuple((self._inertias(moment), w) for moment, w in squares)
                v = self.kinematics.velocity(name) if squares else ()
                mass = self.algebra.lift(self.kinematics.moments(name)[3][3]) if v else 0
                rest = T - whole - self.algebra.ring.sum([mass * w * w / 2 for w in v])
                named[name] = moments if rest.vanishes() else ()
        return named

    def _list_squares(self, body: str) -> Squares:
        """Return the principal moments about a body's fixed origin, or center, and its spin."""
        kinematics, lift = self.kinematics, self.algebra.lift
        J = kinematics.moments(body)
        aside = any(J[k][3] for k in range(3))
        if kinematics.carrier(body) >= 0 or (aside and any(kinematics.velocity(body))):
            return ()
        trace = self.algebra.ring.sum([lift(J[k][k]) for k in range(3)])
        moments = [tidy(trace - lift(J[k][k])) for k in range(3)]
        axes, *_ = kinematics.spin_axes(body)
        rates = along(axes, kinematics.spin(body))
        return tuple((m, w) for m, w in zip(moments, rates, strict=True) if m and w)

    def _rotors(self) -> Iterator[tuple[str, Series]]:
        """Yield the joint's name and the kinetic energy ½ I r'² of each rotor."""
        algebra = self.algebra
        for link in self.kinematics.tree:
            inertia = algebra.series(link.armature)
            if inertia:
                rate = algebra.lift(algebra.values[link.coordinates[0]]).ddt()
                yield link.joint, inertia * rate**2 / 2

    def _weights(self) -> list[Series]:
        """Return the potential energy −g·(m c) of each body."""
        algebra, terms = self.algebra, []
        g = [algebra.arithmetic(c, algebra.values) for c in algebra.mechanism.gravity]
        for body in self.kinematics.bodies:
            mass_moments = [row[3] for row in self.kinematics.moments(body)]
            pose = self.kinematics.pose(body)
            moment = [combination(row, mass_moments) for row in pose]
            terms.append(-algebra.lift(combination(g, moment)))
        return terms

    def _sum(self, kind: str) -> Series:
        scalars = [
            work.scalar for work in self.works if work.kind == kind and work.scalar is not None
        ]
        return tidy(self.algebra.ring.sum(scalars))

    @cached_property
    def load_potential(self) -> Series | None:
        """The potential of loads that are the same everywhere; None if other loads do work."""
        loads = (work for work in self.works if work.kind == "work")
        stored = [store_constant(self.algebra, load) for load in loads]
        known = [V for V in stored if V is not None]
        return tidy(self.algebra.ring.sum(known)) if len(known) == len(stored) else None

    def find_free(self) -> list[bool]:
        """Return for each velocity whether no drive, load or constraint acts along it."""
        drives = [work for work in self.works if work.kind == "work"]
        acting = [work.forces for work in drives]
        acting += [tuple(tie.slopes(self.algebra.ring)) for tie in self.ties]
        held = {k for forces in acting for k, force in enumerate(forces) if force}
        return [k not in held for k in range(len(self.algebra.velocities))]

    def _closing(self) -> str:
        """The sentence before the equations of motion."""
        kinds = {work.kind for work in self.works}
        loss = " + ∂D/∂q'" if "dissipation" in kinds else ""
        drive = "Q" if "work" in kinds else "0"
        slopes = sorted({"∂ψ/∂q'" if tie.of_velocities else "∂Φ/∂q" for tie in self.ties})
        if self.ties:
            held = " + ".join(f"Σ λ {slope}" for slope in slopes)
            drive = f"Q + {held}" if "work" in kinds else held
        quasi = any(not name.endswith("'") for name in self.algebra.velocities)
        added = (
            "; for a velocity that is not the rate of a coordinate the terms of Euler and "
            "Kirchhoff are added"
        )
        which = "Lagrange's equations with multipliers" if self.ties else "Lagrange's equations"
        return (
            f"{which} are d/dt ∂T/∂q' - ∂T/∂q + ∂V/∂q{loss} = {drive} for every coordinate q"
            f"{added if quasi else ''}.{self._say_ties()}"
        )

    def _say_ties(self) -> str:
        """The sentence about the equations of loops, contacts and velocity constraints."""
        if not self.ties:
            return ""
        if not self.algebra.mechanism.rolls:
            return " The loops add their constraint equations, Φ = 0."
        held = any(not tie.of_velocities for tie in self.ties)
        return f" The constraints add their own equations, {'Φ = 0 and ' if held else ''}ψ = 0."

    def _find_turning(self, momenta: Sequence[Series]) -> list[Series]:
        """Return ω × ∂T/∂v and ω × ∂T/∂ω + v × ∂T/∂v of each quaternion joint, else zero."""
        algebra = self.algebra
        turning = [algebra.ring.number(0)] * len(momenta)
        for joint in algebra.mechanism.joints:
            if joint.quaternion:
                at = [algebra.velocities.index(name) for name in joint.velocities]
                rates = [algebra.ring[name] for name in joint.velocities]
                w, H = Vector(*rates[-3:]), Vector(*(momenta[k] for k in at[-3:]))
                turned = [*cross(w, H)]
                if joint.linear_velocities:
                    v, p = Vector(*rates[:3]), Vector(*(momenta[k] for k in at[:3]))
                    turned = [*cross(w, p), *(cross(w, H) + cross(v, p))]
                for k, term in zip(at, turned, strict=True):
                    turning[k] = term
        return turning
