"""The result of a symbolic derivation: M a + h = Q as series, its steps and assumptions."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Protocol, TypeAlias, final

from mecanique.derivation.printing.equations import expression
from mecanique.derivation.printing.prose import to_html
from mecanique.derivation.printing.writers import Equation, Expression, Printed, Writer
from mecanique.derivation.scalars.cancel import by_velocity, tidy
from mecanique.derivation.scalars.evaluation import evaluate
from mecanique.derivation.scalars.series import Ring, Series
from mecanique.derivation.symbolic.symbols import Algebra
from mecanique.wording import say_count


@final
@dataclass(frozen=True)
class Tie:
    """One equation of a loop, a contact or a velocity constraint."""

    name: str  # name of the equation, e.g. "C_x"
    demand: Series  # its left side, Φ(q, t) or ψ = A v − b, which the constraint keeps zero
    multiplier: Series  # λ
    meaning: str  # the meaning of λ, with its unit
    # whether it is ψ, linear in the velocities and in general not integrable
    of_velocities: bool = False
    of_contact: bool = False
    foot: Series | None = None  # of a gap, the place along x of the plane

    @property
    def letter(self) -> str:
        """The letter of its left side, "Phi" or "psi"."""
        return "psi" if self.of_velocities else "Phi"

    def slopes(self, ring: Ring) -> list[Series]:
        """Return the derivatives of Φ', or of ψ, by each velocity: ∂Φ/∂q or ∂ψ/∂v."""
        return ring.partials(self.demand) if self.of_velocities else ring.along(self.demand)

    @cached_property
    def second(self) -> Series:
        """The constraint on the accelerations: Φ'' or ψ'."""
        rate = self.demand.ddt()
        return rate if self.of_velocities else rate.ddt()


Matrix: TypeAlias = "tuple[tuple[Series, ...], ...]"
"""Rows of series."""


REACTIONS = "Reactions"
LOOPS_IN_MOTION = "Loops in motion"
DISPLACEMENTS = "Independent displacements"
"""Titles of steps that documents look for."""

DISTANCE = "distance along a rod from its end [m]"
INDEPENDENT = "independent virtual displacement: small and arbitrary"
"""Meanings of letters that the steps of virtual work explain themselves."""


@final
@dataclass(frozen=True)
class Left:
    """The left-hand side of a result: a quantity, or a derivative of one."""

    quantity: str  # its letter, e.g. "T"
    by: str = ""  # the variable of a partial derivative, e.g. "q'"; "" if it is not a derivative
    total: bool = False  # whether to take the time derivative as well
    turning: bool = False  # whether it is a term of Euler and Kirchhoff, ω × ∂T/∂ω + v × ∂T/∂v
    component: bool = False  # whether it is the quantity's component named by `by`, e.g. Q_x
    primes: str = ""  # primes of a rate, e.g. "'" for Φ'

    @property
    def symbol(self) -> str:
        """The symbol that a reader must know to read it."""
        return f"{self.quantity}_{self.by}" if self.component else self.quantity

    def write(self, writer: Writer) -> str:
        """Write it in the format of a writer."""
        if self.component:
            return writer.letter(self.symbol, False, "")
        quantity = writer.letter(f"{self.quantity}{self.primes}", False, "")
        if not self.by:
            return quantity
        by = writer.letter(self.by, False, "")
        if self.turning:
            gradient = writer.partial(quantity, writer.letter("v", False, ""), False)
            return writer.turning(gradient, by)
        return writer.partial(quantity, by, self.total)


@final
@dataclass(frozen=True, repr=False)
class Result(Printed):
    """One line of a derivation, left = right."""

    left: Left | Series  # the quantity found; a series where an equation relates two sums
    right: Series
    # returns the value as printed, if not in the usual order
    shown: Callable[[], Expression] | None = field(default=None, compare=False)

    @property
    def spelled(self) -> Mapping[str, str]:
        """The letters of its names that are words."""
        return self.right.ring.letters

    def expression(self) -> Expression:
        """Return the right side as it is printed."""
        return self._expression

    @cached_property
    def _expression(self) -> Expression:
        return expression(self.right) if self.shown is None else self.shown()

    def write(self, writer: Writer) -> str:
        """Write the line in the format of a writer."""
        left = self.left if isinstance(self.left, Left) else expression(self.left)
        return writer.equation(left.write(writer), self.expression().write(writer))


def list_components(
    name: str, labels: Iterable[str], components: Iterable[Series]
) -> Iterator[Result]:
    """Yield the components of a vector that are not zero, each under its name, e.g. "r_bob_x"."""
    for label, part in zip(labels, components, strict=True):
        if part:
            yield Result(Left("_".join(filter(None, (name, label)))), part)


@final
@dataclass(frozen=True, repr=False)
class Stage:
    """One step of a derivation."""

    title: str
    explanation: str  # its purpose, in a sentence or two
    results: tuple[Result, ...] = ()  # the formulas it leads to

    def __repr__(self) -> str:
        return f"<Stage: {self.title}>"

    def _repr_html_(self) -> str:
        """Show the step in a notebook: title, explanation and formulas in MathML."""
        lines = [result._repr_html_() for result in self.results]
        head = f"<h4>{to_html(self.title)}</h4>\n<p>{to_html(self.explanation)}</p>"
        return "\n".join([head, *lines])


@final
class Stages(tuple[Stage, ...]):
    """The steps of a derivation; in a notebook, one below the other."""

    def _repr_html_(self) -> str:
        return "\n".join(stage._repr_html_() for stage in self)


@final
@dataclass(frozen=True)
class Assumption:
    """An assumption of a closed form."""

    subject: str  # its subject, e.g. "the length of spring1"
    positive: Series

    def holds(self, values: Mapping[str, Any]) -> bool:
        """Return whether it holds."""
        return bool(evaluate(self.positive, values) > 0)


@final
@dataclass(frozen=True, repr=False)
class Derivation:
    """Symbolic equations of motion M a + h = Q, with loops M a + h = Q + Σ λ ∂Φ/∂q and Φ = 0."""

    # For rolling and other velocity constraints ψ = A v − b = 0, ∂ψ/∂v takes the place of ∂Φ/∂q

    algebra: Algebra  # the mechanism's symbols
    M: Matrix  # rows of the mass matrix
    h: tuple[Series, ...]  # Coriolis, centrifugal and rheonomic inertia terms and gravity
    Q: tuple[Series, ...]  # generalized forces of springs, dampers, drives and loads
    stages: tuple[Stage, ...]  # the steps that lead to them
    assumptions: tuple[Assumption, ...] = ()  # the assumptions of the closed form
    # meaning of each root with a name, such as the length of a spring, by its name
    lengths: Mapping[str, str] = field(default_factory=dict)
    closing: str = ""  # a sentence that says how the equations of motion follow from the last step
    # meaning of each reaction or virtual displacement in the steps, by its name
    unknowns: Mapping[str, str] = field(default_factory=dict)
    # each reaction that is not identically zero, by its name; empty if the method shows none
    reactions: Mapping[str, Series] = field(default_factory=dict)
    # the equations of the loops, contacts and velocity constraints, with their multipliers
    ties: tuple[Tie, ...] = ()
    # independent displacements that the constraints allow, each with a part for every velocity; if
    # given, the equations of motion are projected on them
    quasi: Matrix = ()
    # the equations of motion as they are printed, if not in the usual form
    written: tuple[Equation, ...] | None = None
    # T, and V of gravity and springs without loads, where the method states them
    energies: tuple[Series, ...] = ()

    def __repr__(self) -> str:
        return f"<Derivation: {say_count(len(self.stages), 'step')}>"

    @property
    def rows(self) -> tuple[Series, ...]:
        """M a + h − Q − Σ λ ∂Φ/∂q, one series for each velocity or independent displacement."""
        ring = self.algebra.ring
        a = [ring[name] for name in self.algebra.accelerations]
        # the constraint forces do no work in independent displacements
        ties = () if self.quasi else self.ties
        slopes = [(tie.multiplier, tie.slopes(ring)) for tie in ties]
        rows = []
        for k, (row, h, Q) in enumerate(zip(self.M, self.h, self.Q, strict=True)):
            inertia = [m * x for m, x in zip(row, a, strict=True)]
            held = [-multiplier * slope[k] for multiplier, slope in slopes]
            rows.append(ring.sum([*inertia, h, -Q, *held]))
        if self.quasi:
            sums = [along_displacement(displacement, rows) for displacement in self.quasi]
            rows = [by_velocity(total, self.algebra.velocities) for total in sums]
        return tuple(rows)


@final
@dataclass(frozen=True)
class Ending:
    """What a derivation's equations of motion come to: a section after them."""

    sentence: str = ""
    lines: tuple[Printed, ...] = ()
    # meaning of each letter that the derivation itself does without, by its name
    unknowns: Mapping[str, str] = field(default_factory=dict)
    title: str = "Result"
    # the sections that lead to it from the equations of motion, and the last one after them
    sections: tuple[Ending, ...] = ()


NO_ENDING = Ending()
"""That of a derivation whose equations come to nothing new."""


def lefts_of(lines: Iterable[Printed]) -> Iterator[Left]:
    """Yield the quantities that lines state."""
    for line in lines:
        if isinstance(line, Result) and isinstance(line.left, Left):
            yield line.left


def along_displacement(displacement: Sequence[Series], rows: Sequence[Series]) -> Series:
    """Project equations on a displacement: the sum of their rows, each times its part of it."""
    pairs = zip(displacement, rows, strict=True)
    return rows[0].ring.sum([part * row for part, row in pairs if part])


def project(column: Sequence[Series], others: Sequence[Sequence[Series]]) -> list[Series]:
    """Return the product of a column with each of the others."""
    return [tidy(along_displacement(column, other)) for other in others]


class SymbolicMethod(Protocol):
    """A method that derives a mechanism's equations of motion as series."""

    def derivation(self) -> Derivation:
        """Return the equations of motion with their steps."""


def mass_and_bias(algebra: Algebra, rows: Iterable[Series]) -> tuple[Matrix, tuple[Series, ...]]:
    """Split rows M a + h into M and h."""
    M, h = [], []
    for row in rows:
        coefficients, rest = row.linear(algebra.accelerations)
        M.append(tuple(tidy(entry) for entry in coefficients))
        h.append(by_velocity(rest, algebra.velocities))
    return tuple(M), tuple(h)
