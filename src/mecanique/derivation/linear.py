"""Linear equations of motion, M q'' + C q' + K q = f: as they are, or about an equilibrium.

Of small motions M, C and K are the partial derivatives of M a + h − Q of the exact equations with
respect to accelerations, velocities and coordinates, taken at the equilibrium (L. Meirovitch,
Elements of Vibration Analysis, 1986, sect. 4.2).
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import count
from typing import final

from mecanique.derivation.printing.equations import equations, expression
from mecanique.derivation.printing.writers import (
    Equation,
    Latex,
    MathML,
    OverRoot,
    Printed,
    Root,
    Text,
    Writer,
    to_math,
)
from mecanique.derivation.scalars.cancel import tidy, without_common_divisor
from mecanique.derivation.scalars.evaluation import Substitution, evaluate
from mecanique.derivation.scalars.series import TIMED, Kind, Series
from mecanique.derivation.symbolic.derivation import Derivation, Matrix
from mecanique.derivation.tolerances import BALANCED, NEAT
from mecanique.errors import DerivationError

_LARGE = 4
"""Matrices with at least this many rows are printed on lines of their own."""


@final
@dataclass(frozen=True)
class Linear:
    """Matrices of linear equations of motion M q'' + C q' + K q = f."""

    names: tuple[str, ...]  # of the coordinates
    M: Matrix  # rows of the mass matrix
    C: Matrix  # rows of the damping matrix
    K: Matrix  # rows of the stiffness matrix
    f: tuple[Series, ...]  # the forces, functions of time alone

    def text(self) -> str:
        """Return the matrix equation as text, then each matrix by rows."""
        writer = Text()
        matrices = [f"{letter} = {_write(rows, writer)}" for letter, rows, _ in self._terms]
        force = ", ".join(expression(entry).text() for entry in self.f)
        forces = [f"f = [{force}]"] if any(self.f) else []
        return "\n".join(
            [self._state(writer), f"q = [{', '.join(self.names)}]", *matrices, *forces]
        )

    def latex(self) -> str:
        """Return one equation between matrices in LaTeX, without dollar signs."""
        return self._write_whole(Latex(self._letters))

    def lines(self) -> list[str]:
        """Return the equation in LaTeX; large matrices follow on lines of their own."""
        if len(self.names) < _LARGE:
            return [self.latex()]
        writer = Latex(self._letters)
        matrices = [f"{letter} = {_write(rows, writer)}" for letter, rows, _ in self._terms]
        forces = [f"f = {self._write_forces(writer)}"] if any(self.f) else []
        return [self._state(writer), *matrices, f"q = {self._write_column(writer, '')}", *forces]

    def mathml(self) -> str:
        """Return the equation as one MathML element."""
        return to_math(self._write_whole(MathML(self._letters)))

    @property
    def _letters(self) -> Mapping[str, str]:
        """The letters of names that are words."""
        return self.M[0][0].ring.letters

    @property
    def _terms(self) -> list[tuple[str, Matrix, str]]:
        """The letter and the rows of each matrix that is not zero, with the dots of its factor."""
        terms = [("M", self.M, "''"), ("C", self.C, "'"), ("K", self.K, "")]
        return [term for term in terms if any(map(any, term[1]))]

    def _state(self, writer: Writer) -> str:
        """Write the equation between letters that stand for matrices."""
        products = (
            f"{letter} {writer.letter(f'q{dots}', False, '')}" for letter, _, dots in self._terms
        )
        return f"{' + '.join(products)} = {'f' if any(self.f) else '0'}"

    def _write_whole(self, writer: Writer) -> str:
        """Write the equation between the matrices themselves."""
        products = [
            (False, _write(rows, writer) + self._write_column(writer, dots))
            for _, rows, dots in self._terms
        ]
        return writer.equation(writer.sum(products), self._write_forces(writer))

    def _write_forces(self, writer: Writer) -> str:
        """Write the column of the forces."""
        return _write([[entry] for entry in self.f], writer)

    def _write_column(self, writer: Writer, dots: str) -> str:
        """Write the column of the coordinates, or of their rates."""
        return writer.matrix([[writer.letter(name + dots, False, "")] for name in self.names])


def linear(derivation: Derivation) -> Linear | None:
    """Return the matrices of equations that are linear with constant coefficients, else None."""
    algebra = derivation.algebra
    ring, n = algebra.ring, len(algebra.velocities)
    moving = (Kind.COORDINATE, Kind.VELOCITY, Kind.ACCELERATION)
    names = tuple(algebra.mechanism.coordinates)
    if not n or len(names) != n or derivation.ties:
        return None

    def vary(rows: Iterable[Sequence[Series]], kinds: Collection[Kind]) -> bool:
        return any(not entry.kinds.isdisjoint(kinds) for row in rows for entry in row)

    fixed = {*moving, *TIMED}
    if vary(derivation.M, fixed):
        return None
    forces = [h - Q for h, Q in zip(derivation.h, derivation.Q, strict=True)]
    C = tuple(tuple(ring.partials(force)) for force in forces)
    K = tuple(tuple(ring.along(force)) for force in forces)
    if vary(C, fixed) or vary(K, fixed):
        return None
    state = [ring[name] for name in (*algebra.velocities, *names)]
    rest: list[Series] = []
    for c, k, force in zip(C, K, forces, strict=True):
        terms = [slope * x for slope, x in zip((*c, *k), state, strict=True)]
        rest.append(ring.sum([*terms, -force]))
    f = tuple(rest)
    return None if vary([f], moving) else Linear(names, derivation.M, C, K, f)


def _write(rows: Iterable[Sequence[Series]], writer: Writer) -> str:
    """Write a matrix of series."""

    def write(entry: Series) -> str:
        return expression(entry).write(writer)

    return writer.matrix([list(map(write, row)) for row in rows])


@final
@dataclass(frozen=True)
class Linearized:
    """Linear equations of small motions about an equilibrium, in letters."""

    matrices: Linear  # M, C, K and the forces f, functions of time alone
    # the same as one equation for each velocity; the coordinates in them are deviations from the
    # equilibrium
    equations: tuple[Equation, ...]
    place: Mapping[str, Series]  # the equilibrium, a series by coordinate name
    # value of each letter that stands for a coordinate at the equilibrium, e.g. theta_0
    letters: Mapping[str, float]
    # the square K/M of the natural frequency of a single degree of freedom; None with several
    # degrees of freedom, or if the equilibrium is not stable
    square: Series | None
    # the damping ratio of a single degree of freedom as numerator C and denominator 2 √(K M); None
    # if it is undamped
    ratio: tuple[Series, Series] | None
    zero: bool  # whether all coordinates are zero at the equilibrium

    def text(self) -> str:
        """Return the equations as text, with the matrices of several, the frequency of one."""
        lines = [self.about(), *(equation.text() for equation in self.equations)]
        if len(self.equations) > 1:
            lines += ["In matrices:", *self.matrices.text().splitlines()]
        return "\n".join([*lines, *(figure.text() for figure in self.figures)])

    def latex(self) -> str:
        """Return the equations in LaTeX, for math mode, with the frequency of a single one."""
        rows = [line.latex().replace(" = ", " &= ", 1) for line in (*self.equations, *self.figures)]
        return "\\begin{aligned}\n" + " \\\\\n".join(rows) + "\n\\end{aligned}"

    def mathml(self) -> str:
        """Return the equations in MathML, one element each, then the matrices or the frequency."""
        out = [equation.mathml() for equation in self.equations]
        if len(self.equations) > 1:
            out.append(self.matrices.mathml())
        return "\n".join([*out, *(to_math(figure.write(MathML())) for figure in self.figures)])

    def about(self) -> str:
        """Introduce the linear equations in a sentence: the equilibrium, and what letters mean."""
        listed = ", ".join(
            f"{name} = {expression(value).text()}" for name, value in self.place.items() if value
        )
        if self.zero:
            return "Small motions about the equilibrium with all coordinates zero:"
        numbers = "".join(f", {letter} = {value:.9g}" for letter, value in self.letters.items())
        where = f" {listed}{numbers}" if listed else ""
        return (
            f"Small motions about the equilibrium{where}; the coordinates below are "
            "deviations from it:"
        )

    def __str__(self) -> str:
        return self.text()

    def _repr_latex_(self) -> str:
        return f"$\\displaystyle {self.latex()}$"

    @property
    def figures(self) -> tuple[Printed, ...]:
        """The natural frequency and the damping ratio of a single degree of freedom."""
        frequency = [] if self.square is None else [Root("omega", expression(self.square))]
        if self.ratio is None:
            return (*frequency,)
        above, square = map(expression, self.ratio)
        return (*frequency, OverRoot("zeta", above, square, times="2"))


def linearize_equations(derivation: Derivation, q: Mapping[str, float]) -> Linearized:
    """Linearize symbolic equations of motion about an equilibrium."""
    # coordinates as 0, multiples of π/12, or letters with values
    ring = derivation.algebra.ring
    quaternions = {name for name in q if f"{name}'" not in derivation.algebra.velocities}
    place, letters = {}, {}
    for name, value in q.items():
        twelfths = round(value / (math.pi / 12))
        if abs(value) < NEAT:
            place[name] = ring.number(0)
        elif name in quaternions and abs(abs(value) - 1) < NEAT:
            place[name] = ring.number(round(value))
        elif name not in quaternions and abs(value - twelfths * math.pi / 12) < NEAT:
            place[name] = ring.constant("pi") * Fraction(twelfths, 12)
        else:
            letter = ring.choose_name(f"{name}_0{'0' * k}" for k in count())
            place[name] = ring.parameter(letter)
            letters[letter] = value
    return linearize_at(derivation, place, letters)


def linearize_at(
    derivation: Derivation, place: Mapping[str, Series], letters: Mapping[str, float]
) -> Linearized:
    """Linearize symbolic equations of motion about an equilibrium, given in letters."""
    algebra = derivation.algebra
    ring, mechanism = algebra.ring, algebra.mechanism
    numbers = {**mechanism.values, **letters}
    still = {name: ring.number(0) for name in (*algebra.velocities, *algebra.accelerations)}
    put = Substitution({**place, **still}, numbers)
    forces = [h - Q for h, Q in zip(derivation.h, derivation.Q, strict=True)]
    M = tuple(tuple(map(put, row)) for row in derivation.M)
    C = tuple(tuple(map(put, ring.partials(force))) for force in forces)
    K = tuple(tuple(map(put, ring.along(force))) for force in forces)
    for what, matrix in (("M", M), ("C", C), ("K", K)):
        for entry in (entry for row in matrix for entry in row):
            timed = [g.name for g in entry.generators() if g.kind in TIMED]
            if timed:
                raise DerivationError(
                    f"the linear equations of {mechanism.name!r} have no constant coefficients: "
                    f"{what} depends on {timed[0]!r}; use the matrices at one time"
                )
    stiffest = max((abs(evaluate(entry, numbers)) for row in K for entry in row), default=0.0)
    f = _find_drive([put(force) for force in forces], numbers, mechanism.name, stiffest)
    names = tuple(v[:-1] if v.endswith("'") else f"δ{v}" for v in algebra.velocities)
    moved = [
        ring[name] if name in mechanism.coordinates else ring.unknown(name, Kind.VARIATION)
        for name in names
    ]
    letters_of = [
        [ring[a] for a in algebra.accelerations],
        [ring[v] for v in algebra.velocities],
        moved,
    ]
    rows = []
    for k in range(len(names)):
        terms = [
            coefficient * letter
            for coefficients, row in zip((M, C, K), letters_of, strict=True)
            for coefficient, letter in zip(coefficients[k], row, strict=True)
        ]
        rows.append(without_common_divisor(ring.sum([*terms, -f[k]])))
    shown = {g.name for row in rows for g in row.generators()}
    used = {name: value for name, value in letters.items() if name in shown}
    square, ratio = _find_frequency(M, C, K, numbers) if len(names) == 1 else (None, None)

    def is_printed(value: Series) -> bool:  # only π and letters that are printed
        return all(g.kind is Kind.CONSTANT or g.name in used for g in value.generators())

    at = {name: place[name] for name in mechanism.coordinates if is_printed(place[name])}
    zero = not any(place[name] for name in mechanism.coordinates)
    matrices = Linear(names, M, C, K, f)
    return Linearized(
        matrices=matrices,
        equations=equations(rows),
        place=at,
        letters=used,
        square=square,
        ratio=ratio,
        zero=zero,
    )


def _find_drive(
    rests: Sequence[Series], numbers: Mapping[str, float], name: str, size: float
) -> tuple[Series, ...]:
    """Return each equation's terms that depend on time, as a force; the others must balance."""
    # Their sum is judged by the largest force of all, and by what a deviation of 1 makes (`size`):
    # where an arm hangs straight down, only what its file rounds is left of the forces
    drives, constants = list[Series](), list[Series]()
    for rest in rests:
        ring, timed, constant = rest.ring, list[Series](), list[Series]()
        for trig, monomial, c in rest.terms():
            term = Series(ring, {trig: {monomial: c.numerator}}, c.denominator, rest.reach)
            if not term.kinds.isdisjoint(TIMED):
                timed.append(-term)
            else:
                constant.append(term)
                size = max(size, abs(evaluate(term, numbers)))
        drives.append(ring.sum(timed))
        constants.append(ring.sum(constant))
    for constant_sum in constants:
        left = evaluate(constant_sum, numbers)
        if abs(left) > BALANCED * max(size, 1e-300):
            raise DerivationError(
                f"the forces of {name!r} do not balance there: they add up to {left:.3g}; expected "
                "an equilibrium (find one with mecanique.equilibria)"
            )
    return tuple(drives)


def _find_frequency(
    M: Matrix,
    C: Matrix,
    K: Matrix,
    numbers: Mapping[str, float],
) -> tuple[Series | None, tuple[Series, Series] | None]:
    """Return ω² = K/M and ζ = C/(2 √(K M)) where K is positive, else None."""
    m, c, k = M[0][0], C[0][0], K[0][0]
    if not evaluate(k, numbers) > 0:
        return None, None
    return tidy(k / m), (c, tidy(k * m)) if c else None
