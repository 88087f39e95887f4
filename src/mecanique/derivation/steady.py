"""Write the linear equations of small deviations from a steady motion in letters.

The equations M a + h − Q = Jᵀ λ and J v = 0 of a mechanism on a tape are evaluated as series in its
parameters, at the motion itself, with their derivatives by each coordinate and velocity. With
displacements S that the constraints allow, J S = 0, deviations δq have δv = S w + P δq, and what is
left of the equations along S is M̂ w' + Ĉ w + K̂ δq = 0 (Neimark & Fufaev, Dynamics of Nonholonomic
Systems, 1972, ch. VI).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import partial, reduce
from operator import mul
from typing import Any, final

import numpy as np

from mecanique.derivation.document import Document
from mecanique.derivation.mechanics.forces import Forces
from mecanique.derivation.mechanics.letters import Letters
from mecanique.derivation.mechanics.loops import loops_of
from mecanique.derivation.mechanics.recursion import recursion_on_tape
from mecanique.derivation.printing.equations import equations, expression, join, shorter
from mecanique.derivation.printing.expressions import to_formula
from mecanique.derivation.printing.writers import Expression, Printed, Root, Writer
from mecanique.derivation.scalars.cancel import tidy
from mecanique.derivation.scalars.evaluation import Substitution, evaluate
from mecanique.derivation.scalars.functions import function
from mecanique.derivation.scalars.series import Ring, Series
from mecanique.derivation.symbolic.derivation import (
    NO_ENDING,
    Derivation,
    Ending,
    Left,
    Matrix,
    Result,
    Stage,
    along_displacement,
)
from mecanique.derivation.symbolic.multipliers import (
    Column,
    Quotient,
    determinant,
    list_alone,
    make_positive,
    sweep,
)
from mecanique.derivation.symbolic.symbols import Algebra
from mecanique.derivation.tolerances import NEAT, SAME_EXPONENT
from mecanique.errors import DerivationError
from mecanique.model.mechanism import Mechanism
from mecanique.model.mechanism_units import units
from mecanique.program.evaluation import replay
from mecanique.program.sweeps import push_forward
from mecanique.program.tape import Value
from mecanique.program.traced import values_of

_FINEST = 10**6
"""Numbers of the description with denominators up to this are taken as fractions."""

_MOTION = (
    "The coordinates and velocities of the motion that are not zero, at the speed {}. No force is "
    "left along the displacements that the constraints allow, so that it goes on."
)
_FORCES = (
    "Forces of the motion",
    "What the constraints exert in the motion itself, where it is not zero.",
)
_FOLLOWING = (
    "Constraints to first order",
    "In a small deviation the other positions and velocities follow by the constraints. Each "
    "letter is a deviation from the steady motion.",
)
_MASS = (
    "Mass matrix",
    "To first order, the equations along the displacements that the constraints allow have the "
    "matrices that follow. Entries are numbered by row and column, in the order of the "
    "coordinates; those that are not listed are zero.",
)
_RATES = (
    "Matrices of the velocities",
    "The first index is the power of the speed with which an entry stands.",
)
_PLACES = (
    "Matrices of the deviations",
    "The first index is the power of the speed with which an entry stands. Where all without the "
    "speed are due to weights, these are divided by the acceleration of free fall.",
)
_CLOSING = (
    "Each entry stands with its power of the speed {}, and a coordinate is the deviation from its "
    "value in the steady motion."
)
_MATRICES = "In matrices, with the numbers of the description: {} = 0 for q = ({})."
_POWERS = ("", "{} ", "{}² ")


@final
@dataclass(frozen=True, repr=False)
class _Numbers(Printed):
    """A matrix in numbers."""

    name: str
    rows: Matrix
    values: Mapping[str, float]

    def write(self, writer: Writer) -> str:
        """Write it in the format of a writer."""

        def cell(entry: Series) -> str:
            value = float(evaluate(entry, self.values))
            return writer.sum([(value < 0, writer.number(f"{abs(value):.5g}"))])

        cells = [list(map(cell, row)) for row in self.rows]
        return writer.equation(writer.letter(self.name, False, ""), writer.matrix(cells))


@final
@dataclass(frozen=True, repr=False)
class SteadyLetters:
    """M q'' + C q' + K q = 0 of small deviations q from a steady motion at the speed u, in letters.

    Args:
        derivation: the matrices as steps, and the equations that they make.
        names: of the coordinates.
        M: rows of the mass matrix.
        C: the matrices of C = C0 + u C1.
        K: the matrices of K = K0 + u K1 + u² K2.
        ending: the matrices in numbers, and the speeds at which stability changes.
    """

    derivation: Derivation
    names: tuple[str, ...]
    M: Matrix
    C: tuple[Matrix, ...]
    K: tuple[Matrix, ...]
    ending: Ending

    def text(self) -> str:
        """Return the motion, the matrices and the equations as text, with the symbols."""
        return self.document.text(True, True)

    def latex(self) -> str:
        """Return the same in LaTeX, as a fragment of a document."""
        return self.document.latex(True, True)

    def mathml(self) -> str:
        """Return the same in MathML, as a fragment of an HTML page."""
        return self.document.mathml(True, True)

    def __str__(self) -> str:
        return self.text()

    def __repr__(self) -> str:
        name = self.derivation.algebra.mechanism.name
        return f"<Linear equations in letters of {name!r}, {', '.join(self.names)}>"

    def _repr_html_(self) -> str:
        return self.document.html(True)

    @property
    def document(self) -> Document:
        """The same, ready to be printed."""
        title = "small deviations from a steady motion"
        return Document(self.derivation, title, ending=self.ending)


def steady_letters(
    mechanism: Mechanism, at: Mapping[str, float], v: Mapping[str, float], names: Sequence[str]
) -> SteadyLetters:
    """Return M, C and K of some coordinates about a steady motion, in letters; v at speed 1."""
    motion = _Motion(mechanism, at, v, names)
    M, damping, stiffness = motion.matrices()
    C, K = motion.split(damping, 1), motion.split(stiffness, 2)
    ring, u, g = motion.algebra.ring, motion.u, motion.weight(K[0])
    sums = [ring.number(0)] * len(names)

    def entries(letter: str, rows: Matrix, factor: Series, dots: str) -> Iterator[Result]:
        """Yield the entries of a matrix, and add its terms to the equations."""
        for i, row in enumerate(rows):
            for k, entry in enumerate(row):
                if entry:
                    label = f"{letter}_{i + 1}{k + 1}"
                    sums[i] = sums[i] + factor * ring.parameter(label) * ring[f"{names[k]}{dots}"]
                    letters[label] = evaluate(entry, mechanism.values)
                    if k < i and rows[k][i] == entry:
                        same[label] = ring[f"{letter}_{k + 1}{i + 1}"]
                    value = same.get(label, entry)
                    yield Result(Left(label), value, partial(_divide_apart, value))

    falls = ring.number(1) if g is None else g
    bare = _entrywise(lambda entry: tidy(entry / falls), K[0])
    same, letters = dict[str, Series](), dict[str, float]()
    steps = {
        _MASS: [*entries("M", M, ring.number(1), "''")],
        _RATES: [x for k, rows in enumerate(C) for x in entries(f"C{k}", rows, u**k, "'")],
        _PLACES: [
            *entries("K0", bare, falls, ""),
            *(x for k in (1, 2) for x in entries(f"K{k}", K[k], u**k, "")),
        ],
    }
    forces = motion.forces()
    stages = [Stage("Steady motion", _MOTION.format(motion.speed), motion.lines())]
    if forces:
        stages.append(Stage(*_FORCES, tuple(Result(Left(name), x) for name, x in forces.items())))
    if following := motion.follow():
        stages.append(Stage(*_FOLLOWING, following))
    stages += [Stage(*head, tuple(lines)) for head, lines in steps.items() if lines]
    meanings = {motion.speed: f"speed of the steady motion{motion.unit}"}
    meanings |= dict.fromkeys(forces, "force of a constraint in the steady motion")
    labels = {
        line.left.quantity: f"entries of the {title[0].lower()}{title[1:]}"
        for (title, _), lines in steps.items()
        for line in lines
        if isinstance(line.left, Left)
    }
    derivation = Derivation(
        motion.algebra,
        M=(),
        h=(),
        Q=(),
        stages=tuple(stages),
        closing=_CLOSING.format(motion.speed),
        unknowns=meanings | labels,
        written=equations(sums),
    )
    falling = "" if g is None else f"{expression(g).text()} "
    numbers = _put_numbers(mechanism, names, M, C, (bare, *K[1:]), (motion.speed, falling))
    exponent = ring.choose_name(("lambda", "s", "exponent"))
    rate = ring.parameter(exponent)
    factors = [rate**2, rate, ring.number(1)]
    state = [(ring[f"{name}''"], ring[f"{name}'"], ring[name]) for name in names]

    def collect(total: Series) -> list[Series]:
        """Return the factors of the deviations in an equation, with the exponent for a rate."""
        slopes = [map(total.diff, its) for its in state]
        return [along_displacement(factors, [*its]) for its in slopes]

    rows = [*map(collect, map(Substitution(same, {}), sums))]
    values = {**mechanism.values, **letters}
    borders = find_borders(rows, exponent, motion.speed, values, motion.unit)
    ending = Ending(
        f"{numbers.sentence} {borders.sentence}".strip(),
        (*numbers.lines, *borders.lines),
        {**numbers.unknowns, **borders.unknowns},
    )
    return SteadyLetters(derivation, tuple(names), M, C, K, ending)


def _put_numbers(
    mechanism: Mechanism,
    names: Sequence[str],
    M: Matrix,
    C: Sequence[Matrix],
    K: Sequence[Matrix],
    factors: tuple[str, str],
) -> Ending:
    """Return the matrices that are not zero in numbers, and what they make."""
    speed, falling = factors
    lines, terms = [_Numbers("M", M, mechanism.values)], ["M q''"]
    for letter, matrices, rate in (("C", C, "q'"), ("K", K, "q")):
        parts = list[str]()
        for k, rows in enumerate(matrices):
            if any(map(any, rows)):
                lines.append(_Numbers(f"{letter}{k}", rows, mechanism.values))
                power = _POWERS[k].format(speed)
                parts.append(f"{falling if letter == 'K' and not k else power}{letter}{k}")
        total = " + ".join(parts)
        if parts:
            terms.append(f"({total}) {rate}" if len(parts) > 1 else f"{total} {rate}")
    letters = [line.name for line in lines if line.name not in mechanism.values]
    explained = dict.fromkeys(letters, "matrices of the entries that bear their letters")
    return Ending(_MATRICES.format(" + ".join(terms), ", ".join(names)), tuple(lines), explained)


class _Motion:
    """A steady motion of a mechanism on a tape, whose values there are series."""

    def __init__(
        self,
        mechanism: Mechanism,
        at: Mapping[str, float],
        speeds: Mapping[str, float],
        names: Sequence[str],
    ) -> None:
        self._name, self._gravity, self._names = mechanism.name, mechanism.gravity, names
        self.algebra = Algebra(mechanism)
        ring = self._ring = self.algebra.ring
        self._zero = ring.number(0)
        self._v, self._q = list(mechanism.velocities), list(mechanism.coordinates)
        if self._v != [f"{name}'" for name in self._q]:
            raise DerivationError(
                f"mechanism {self._name!r} turns by a quaternion; describe it by hinges"
            )
        letters = Letters(mechanism, [parameter.symbol for parameter in mechanism.parameters])
        recursion = recursion_on_tape(letters)
        loops = loops_of(letters, recursion)
        self._tape = letters.tape
        self._mass = [values_of(row) for row in recursion.mass_matrix()]
        loads = zip(recursion.bias(), Forces(letters, recursion).project(), strict=True)
        self._rest = values_of([h - Q for h, Q in loads])
        self._jacobian = [values_of(row) for row in loops.jacobian]
        self._slips, self._rows = values_of(loops.rate), loops.names
        rates = {f" [{units(mechanism)[name]}/s]" for name in speeds}
        self.unit = rates.pop() if len(rates) == 1 else ""
        """The unit of the speed, as it stands behind its meaning."""
        usual = ("v", "V") if self.unit == " [m/s]" else ("u", "U")
        self.speed = ring.choose_name((*usual, "speed", "v_0"))
        """The letter of the speed."""
        self.u = ring.parameter(self.speed)
        # what is asked for gives way last
        kept = {*names, *speeds}
        ranks = [len(self._q) * (name in kept) - k for k, name in enumerate(self._q)]
        self._base = dict.fromkeys([*self._q, *self._v, "t"], self._zero)
        self._base |= {name: self._lift(x) for name, x in at.items()}
        self._place = self._close(values_of(loops.residual), ranks)
        self._J = [self._values(row) for row in self._jacobian]
        self._allowed, _ = sweep(ring, self._J, len(self._v), ranks)
        for column, k in zip(self._allowed.basis, self._independent, strict=True):
            speed = self.u * self._lift(speeds.get(self._q[k], 0.0))
            for name, part in zip(self._v, column, strict=True):
                self._base[name] = tidy(self._base[name] + speed * part)

    def lines(self) -> tuple[Result, ...]:
        """Return the positions and velocities that are not zero."""
        state = [(name, self._base[name]) for name in (*self._q, *self._v)]
        return tuple(Result(self._ring[name], x) for name, x in state if x)

    def forces(self) -> dict[str, Series]:
        """Return the forces of the constraints that are not zero, by name."""
        names = (f"lambda_{row.replace(': ', '_')}" for row in self._rows)
        return {name: x for name, x in zip(names, self._weigh(), strict=True) if x}

    def follow(self) -> tuple[Result, ...]:
        """Return the deviations that follow from the independent ones by the constraints."""
        q = [self._ring[name] for name in self._q]
        v = [self._ring[name] for name in self._v]
        free, w = _alone(self._place), self._independent
        places = _mix([q[k] for k in free], self._place)
        rates = _mix(
            [*(v[k] for k in w), *(q[k] for k in free)], [*self._allowed.basis, *self._turn()]
        )
        pairs = zip([*q, *v], [*places, *rates], strict=True)
        followed = ((name, tidy(x)) for name, x in pairs if x and x != name)
        return tuple(Result(name, x, partial(_divide_apart, x)) for name, x in followed)

    def matrices(self) -> tuple[Matrix, Matrix, Matrix]:
        """Return M, C and K."""
        S, w, free = self._allowed.basis, self._independent, _alone(self._place)
        wanted = [self._q.index(name) for name in self._names]
        if not {*wanted} <= {*w} & {*free}:
            raise DerivationError(
                f"mechanism {self._name!r}: expected coordinates that stay independent, as do "
                f"{', '.join(self._q[k] for k in w)}, got {', '.join(self._names)}"
            )
        M = [self._values(row) for row in self._mass]
        turned = self._turn()
        by_q, by_v = self._balance(), self._slopes(self._rest, self._v)

        def along(forces: Column) -> Column:
            """Return what forces do along S."""
            return [along_displacement(forces, s) for s in S]

        def project(forces: Column, rate: Column) -> Column:
            """Return what forces, and the accelerations that δq brings at a rate, do along S."""
            a = _mix([rate[k] for k in free], turned)
            total = [x + along_displacement(a, row) for x, row in zip(forces, M, strict=True)]
            return [tidy(x) for x in along(total)]

        mass = [along(_mix(column, M)) for column in S]
        damping = [project(_mix(column, by_v), column) for column in S]
        stiffness = []
        for rate, column in zip(turned, self._place, strict=True):
            pairs = zip(_mix(rate, by_v), _mix(column, by_q), strict=True)
            stiffness.append(project([a + b for a, b in pairs], rate))
        picked = [w.index(k) for k in wanted]
        places = [free.index(k) for k in wanted]
        return (
            self._pick(mass, picked, picked),
            self._pick(damping, picked, picked),
            self._pick(stiffness, picked, places),
        )

    def split(self, matrix: Matrix, most: int) -> tuple[Matrix, ...]:
        """Return the matrices of a polynomial in the speed."""
        powers = _entrywise(lambda entry: entry.coefficients([self.speed]), matrix)
        if any(not 0 <= e <= most for row in powers for x in row for (e,) in x):
            raise DerivationError(
                f"the equations of {self._name!r} about this motion are no polynomials "
                f"C0 + {self.speed} C1 and K0 + {self.speed} K1 + {self.speed}^2 K2 of its speed"
            )

        def part(k: int) -> Matrix:
            return _entrywise(lambda entry: entry.get((k,), self._zero), powers)

        return tuple(part(k) for k in range(most + 1))

    def weight(self, K: Matrix) -> Series | None:
        """Return the acceleration of free fall if all entries are proportional to it."""
        falls = [self.algebra.series(component) for component in self._gravity]
        names = [generator.name for fall in falls for generator in fall.generators()]
        entries = [entry for row in K for entry in row if entry]
        alike = len(names) == 1 and all({*x.coefficients(names)} == {(1,)} for x in entries)
        return self._ring[names[0]] if alike and entries else None

    @property
    def _independent(self) -> list[int]:
        """The velocities that are independent."""
        return _alone(self._allowed.basis)

    def _turn(self) -> list[Column]:
        """Return δv by each independent δq while no independent velocity deviates."""
        slips = self._slopes(self._slips, self._q)

        def turn(column: Column) -> Column:
            back = [-x for x in _mix(column, slips)]
            return self._allowed.reach(self._ring, self._J, back)

        return list(map(turn, self._place))

    def _weigh(self) -> list[Series]:
        """Return the λ of the motion, which balances it."""
        return self._allowed.weigh(self._ring, self._J, self._values(self._rest)) if self._J else []

    def _close(self, gaps: Sequence[Value], ranks: Sequence[int]) -> list[Column]:
        """Close loops and put wheels on the ground; return the displacements that keep them so."""
        slopes = self._slopes(gaps, self._q)
        rows = [list(row) for row in zip(*slopes, strict=True) if any(row)]
        values = [-gap for gap, *row in zip(self._values(gaps), *slopes, strict=True) if any(row)]
        allowed, _ = sweep(self._ring, rows, len(self._q), ranks)
        step = allowed.reach(self._ring, rows, values) if rows else []
        self._base |= {
            name: tidy(self._base[name] + x) for name, x in zip(self._q, step, strict=False)
        }
        if any(self._values(gaps)):
            raise DerivationError(
                f"mechanism {self._name!r}: its loops or contacts are not closed in this position "
                "for all values of the parameters"
            )
        return allowed.basis

    def _balance(self) -> list[Column]:
        """Return h − Q − Jᵀ λ by each coordinate, at the λ of the motion, which balances it."""
        rest = self._values(self._rest)
        left = [tidy(along_displacement(rest, column)) for column in self._allowed.basis]
        if any(left):
            changing = next(expression(x).text() for x in left if x)
            raise DerivationError(
                f"the motion of {self._name!r} is not steady for all values of the parameters: "
                f"{changing} is left of its forces"
            )
        weights = self._weigh()
        held = [self._slopes(row, self._q) for row in self._jacobian]
        balances = []
        for k, column in enumerate(self._slopes(self._rest, self._q)):
            pulls = _mix([-x for x in weights], [slopes[k] for slopes in held])
            balances.append([x + y for x, y in zip(column, pulls or column, strict=True)])
        return balances

    def _pick(self, columns: list[Column], rows: list[int], picked: list[int]) -> Matrix:
        """Return some rows of some columns; what else stands in these rows must be zero."""
        others = [column for k, column in enumerate(columns) if k not in picked]
        if any(column[row] for column in others for row in rows):
            raise DerivationError(
                f"mechanism {self._name!r}: other coordinates move with {', '.join(self._names)}"
            )
        kept = [*zip(*(columns[k] for k in picked), strict=True)]
        return _entrywise(tidy, [kept[row] for row in rows])

    def _slopes(self, outputs: Sequence[Value], by: Sequence[str]) -> list[Column]:
        """Return the derivatives of values of the tape by each of some inputs."""
        inputs = [self._tape.input(name) for name in by]
        return [self._values(push_forward(self._tape, outputs, {x: 1.0})) for x in inputs]

    def _values(self, outputs: Sequence[Value]) -> Column:
        """Return values of the tape at the motion."""

        def read(name: str) -> Series:
            known = self._base.get(name)
            return self.algebra.lift(self.algebra.values[name]) if known is None else known

        return replay(self._tape, outputs, read, function, self._lift)

    def _lift(self, scalar: Any) -> Series:
        """Return a number of the description as the fraction that it stands for; tidy a series."""
        if isinstance(scalar, Series):
            return tidy(scalar)
        near = Fraction(scalar).limit_denominator(_FINEST)
        close = abs(float(near) - scalar) <= NEAT * abs(scalar)
        return self._ring.number(near if close else Fraction(scalar))


def _divide_apart(entry: Series) -> Expression:
    """Return an entry as the few of its terms that a letter divides stand apart from the others."""
    ring, rare = entry.ring, list[str]()
    for name in (generator.name for generator in entry.generators()):
        powers = entry.coefficients([name])
        count = sum(len(part) for (e,), part in powers.items() if e < 0)
        if 0 < 2 * count < len(entry):
            rare.append(name)
    divided = dict[tuple[int, ...], Series]()
    for exponents, part in entry.coefficients(rare).items():
        below = tuple(min(e, 0) for e in exponents)
        letters = (ring[name] ** e for name, e in zip(rare, exponents, strict=True))
        divided[below] = divided.get(below, ring.number(0)) + reduce(mul, letters, part)
    ordered = [divided[by] for by in sorted(divided, key=sum, reverse=True)]
    apart = join(shorter(expression(x), Expression((to_formula(x),), False)) for x in ordered)
    return shorter(expression(entry), apart)


def _entrywise(
    change: Callable[[Any], Any], rows: Sequence[Sequence[Any]]
) -> tuple[tuple[Any, ...], ...]:
    """Return a matrix of what becomes of each entry."""
    return tuple(tuple(map(change, row)) for row in rows)


def _mix(factors: Sequence[Series], columns: Sequence[Column]) -> Column:
    """Return the sum of columns, each times its factor."""
    return [along_displacement(factors, parts) for parts in zip(*columns, strict=True)]


def _alone(basis: Sequence[Column]) -> list[int]:
    """Return the entry of each displacement that is 1 there and 0 in all others."""
    return [alone[0] for alone in list_alone(basis)]


# Find at which speeds a steady motion becomes stable, or ceases to be.
#
# Deviations e^(λ t) have a characteristic polynomial in λ, with coefficients a. On a border of
# stability an exponent is zero, where the lowest coefficient vanishes, or two are imaginary, where
# Hurwitz's determinant vanishes (A. Hurwitz, Math. Ann. 46 (1895) 273).

_POLYNOMIAL = "Of deviations proportional to exp({0} t), the determinant is {1} = 0."
_BORDERS = {
    "c": "{0} {1}, where {2} = 0, a deviation grows without oscillation (of a bicycle, capsize).",
    "w": "{0} {1}, where {2} = 0, an oscillation grows (of a bicycle, weave).",
}
_MEANINGS = {
    "c": "speed at which a constant deviation stays",
    "w": "speed at which an oscillation neither grows nor decays",
}
_APART = 1e-3
"""Relative distance from a border at which stability is judged."""


def find_borders(
    rows: Sequence[Sequence[Series]],
    exponent: str,
    speed: str,
    values: Mapping[str, float],
    unit: str,
) -> Ending:
    """Return the speeds at which stability changes, in letters where they are short."""
    ring = rows[0][0].ring
    powers = determinant(ring, rows).coefficients([exponent])
    a = {n: coefficient for (n,), coefficient in powers.items() if coefficient}
    conditions = {"c": (f"a{min(a)}", a[min(a)]), **_find_oscillation(a)}
    borders = []
    for letter, (condition, series) in conditions.items():
        for border in _find_roots(series, speed, values):
            below = _growth(a, speed, values, border * (1 - _APART))
            above = _growth(a, speed, values, border * (1 + _APART))
            if (below > SAME_EXPONENT) != (above > SAME_EXPONENT):
                borders.append((border, letter, condition, "Above" if above > below else "Below"))
    if not borders:
        return NO_ENDING
    terms = " + ".join(f"a{n} {exponent}^{n}" for n in sorted(a, reverse=True) if n)
    terms = terms.replace(f"{exponent}^1", exponent)
    said = [_POLYNOMIAL.format(exponent, f"{terms} + a0" if 0 in a else terms)]
    lines = []
    unknowns = dict.fromkeys((f"a{n}" for n in sorted(a)), "coefficient of the determinant")
    for border, letter, condition, side in sorted(borders):
        name = f"{speed}_{letter}"
        square = _solve(a[min(a)], speed) if letter == "c" else None
        said.append(_BORDERS[letter].format(side, name, condition))
        lines.append(Root(name, square and square.expression(), f"{border:.5g}"))
        unknowns[name] = f"{_MEANINGS[letter]}{unit}"
    return Ending(" ".join(said), tuple(lines), unknowns)


def _find_oscillation(a: Mapping[int, Series]) -> dict[str, tuple[str, Series]]:
    """Return Hurwitz's determinant, as text in the coefficients and as a series."""
    lowest, order = min(a), max(a) - min(a)
    if order < 2 or not any((n - lowest) % 2 for n in a):
        return {}
    letters = Ring()
    named = {n: letters.parameter(f"a{n}") for n in a}

    def hurwitz(of: Mapping[int, Series], ring: Ring) -> Series:
        size, zero = range(order - 1), ring.number(0)

        def line_up(shift: int) -> list[Series]:
            return [of.get(max(a) - 1 - 2 * k + shift, zero) for k in size]

        return determinant(ring, [*map(line_up, size)])

    ring = a[lowest].ring
    return {"w": (expression(hurwitz(named, letters)).text(), hurwitz(a, ring))}


def _find_roots(series: Series, speed: str, values: Mapping[str, float]) -> Iterator[float]:
    """Yield the positive speeds at which a polynomial in the speed vanishes."""
    powers = {n: evaluate(part, values) for (n,), part in series.coefficients([speed]).items()}
    falling = [powers.get(n, 0.0) for n in range(max(powers), min(powers) - 1, -1)]
    for root in np.roots(falling):
        if abs(root.imag) <= SAME_EXPONENT * abs(root) and root.real > 0:
            yield float(root.real)


def _growth(a: Mapping[int, Series], speed: str, values: Mapping[str, float], at: float) -> float:
    """Return the largest real part of an exponent, relative to the largest exponent."""
    numbers = {**values, speed: at}
    falling = [evaluate(a[n], numbers) if n in a else 0.0 for n in range(max(a), min(a) - 1, -1)]
    exponents = np.roots(falling)
    return float(exponents.real.max() / np.abs(exponents).max())


def _solve(series: Series, speed: str) -> Quotient | None:
    """Return the square of the speed at which A u² + B, or that times a power of u, vanishes."""
    powers = {n: part for (n,), part in series.coefficients([speed]).items()}
    low, high = min(powers), max(powers)
    if high - low != 2 or len(powers) > 2:
        return None
    below, above = make_positive([powers[high], -powers[low]])
    return Quotient(above, below)
