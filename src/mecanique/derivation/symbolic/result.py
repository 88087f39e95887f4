"""Say what equations of motion come to: the last section of a derivation."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import suppress
from math import inf

from mecanique.derivation.printing.writers import Equation, Printed
from mecanique.derivation.scalars.cancel import without_common_divisor
from mecanique.derivation.scalars.evaluation import Substitution
from mecanique.derivation.scalars.series import Kind, Series
from mecanique.derivation.symbolic.derivation import (
    NO_ENDING,
    Derivation,
    Ending,
    Left,
    Result,
    Stage,
    lefts_of,
)
from mecanique.derivation.symbolic.lagrange import ENERGY_INTEGRAL, Lagrange
from mecanique.derivation.symbolic.multipliers import MULTIPLIERS, Quotient, say_where
from mecanique.derivation.symbolic.named_inertias import name_inertias
from mecanique.derivation.symbolic.reduced import reduce_by_momenta, reduce_to_one
from mecanique.derivation.symbolic.solution import EliminatedSolution, find_still, solve
from mecanique.derivation.symbolic.symbols import coordinate_of
from mecanique.errors import DerivationError
from mecanique.wording import enumerate_words

INTEGRALS = (ENERGY_INTEGRAL, "Jacobi's integral")
"""Titles of the steps that state constants; they are listed with the result."""

_LONGEST_OF_LOOPS = 20
"""Most terms of an acceleration of loops, and of a line of equations reduced further."""

_LONGEST_INSERTED = 6
"""Most terms of a force that is listed once more with the acceleration inserted."""

_LONGEST_ROW = 200
"""Most terms of an equation without multipliers; longer ones tell less than those with them."""

_OTHERS = "The other velocities follow from theirs."
_REMAIN = "Without the forces of the constraints these equations remain"
_ELIMINATED = (
    "To the equation of each free coordinate those of the "
    "others are added, each times the coefficient with which its velocity depends on that of the "
    "free one: in such a displacement the forces of the constraints do no work, and cancel."
)
_TURNED = "Components of friction along and across the heading are shorter than those in the plane."
_SHARED = "How contacts share their friction along one direction is undetermined; their sum is not."
_AS_ABOVE = "With the accelerations, the multipliers follow as listed above."
_ELSEWHERE = (
    "Kinematic coefficients, the velocities per unit of one of them, reduce the equations to one "
    "without multipliers: reduce_loops writes it."
)


def result_of(derivation: Derivation) -> Ending:
    """Return the last section of a derivation, without lines if nothing is new."""
    # It lists equations without multipliers, accelerations, forces of constraints, integrals and
    # the equations that loops or cyclic coordinates leave
    if derivation.written is not None:
        return NO_ENDING
    reduced, inertias = _reduce(derivation), name_inertias(derivation.algebra, derivation.M)
    derivation = inertias.rewrite(derivation)
    said, told, lines, last = list[str](), list[str](), list[Printed](), list[Printed]()
    conserved = [stage for stage in derivation.stages if stage.title in INTEGRALS]
    constants = [line for stage in conserved for line in stage.results]
    sections = [*reduced.sections[:-2]]
    with suppress(DerivationError):  # loops, and constraints without displacements everywhere
        loops = bool(derivation.algebra.mechanism.loops)
        # what multiplies out to more than twice as many terms seldom becomes as short as is shown
        solved = solve(derivation, longest=2 * _LONGEST_OF_LOOPS if loops else inf)
        single = len(solved.kept) == 1 and bool(solved.accelerations)
        lengths = [len(quotient.above) for quotient in solved.accelerations.values()]
        if loops and max(lengths, default=inf) > _LONGEST_OF_LOOPS:
            raise DerivationError("their one equation by kinematic coefficients is shorter")
        if max(map(len, solved.rows), default=0) > _LONGEST_ROW:
            raise DerivationError("those with the multipliers are shorter")
        if derivation.ties and solved.rows and all(map(without_common_divisor, solved.rows)):
            kept = enumerate_words([*map(coordinate_of, solved.kept)])
            said.append(f"The constraints leave {kept} free.")
            explicit = solved.accelerations and not say_where(solved.accelerations.values())
            if not sections:
                sections = [_eliminate(derivation, solved)]
            if not (single or explicit):
                where = _say_where(solved)
                said += [] if derivation.quasi else [_OTHERS, _ELIMINATED]
                said.append(f"{_REMAIN}{where}.")
                lines += [] if derivation.quasi else [*_follow(solved)]
                lines += solved.equations
        if solved.accelerations:
            where = say_where(solved.accelerations.values())
            are = "accelerations are" if len(solved.accelerations) > 1 else "acceleration is"
            said.append(f"The {are} explicit{where}.")
            told += [] if reduced.sections else said[-1:]
        if solved.forces:
            by = "" if solved.accelerations else " from the accelerations"
            turned = f" {_TURNED}" if solved.turned else ""
            shared = f" {_SHARED}" if solved.sums else ""
            said.append(f"The forces of the constraints follow{by}.{turned}{shared}")
            told.append(said[-1])
        inserted = _insert(derivation.reactions, solved)
        if inserted:
            said.append(f"Inserted, it gives {enumerate_words([*inserted])}.")
            told.append(said[-1])
        forces = [*solved.forces.items(), *inserted.items()]
        accelerations = [*_list_accelerations(solved)]
        rest = [solved.turned.get(name) or value.equate(name) for name, value in forces]
        rest += solved.sums
        lines += [*accelerations, *rest]
        if not reduced.sections:
            last += accelerations
        last += rest
        if solved.followers:  # in terms of the velocities that are kept
            insert = Substitution({**find_still(derivation), **solved.followers}, {})
            constants = [Result(line.left, insert(line.right)) for line in constants]
    if lines and not reduced.lines:  # those of the loops are short enough to stand here
        reduced = NO_ENDING
    integrals = [*constants, *_list_momenta(derivation.stages)]
    letters = [*dict.fromkeys(left.symbol for left in lefts_of(integrals))]
    if integrals:
        are = "is" if len(integrals) == 1 else "are"
        said.append(f"Along any motion {enumerate_words(letters)} {are} constant.")
    said += [reduced.sentence] if reduced.sentence else []
    # of E the last statement stays, with V_eff or with J
    momenta = {left for left in lefts_of(integrals) if left.component}
    new = [line for line in reduced.lines if momenta.isdisjoint(lefts_of([line]))]
    stated = {*lefts_of(new)}
    integrals = [line for line in integrals if stated.isdisjoint(lefts_of([line]))]
    named = [inertias.sentence] if inertias.sentence else []
    if reduced.sections:  # the equation of a loop comes first, and brings its energy
        *_, equation, energy = reduced.sections
        listed = any(stage.title == MULTIPLIERS for stage in derivation.stages)
        told += [_AS_ABOVE] if listed and not last else []
        told = [equation.sentence, *told, energy.sentence]
        last = [*equation.lines, *last, *energy.lines]
    else:
        if stated.isdisjoint(lefts_of(constants)):
            told += [stage.explanation for stage in conserved]
            last += constants
        told.append(reduced.sentence)
        last += reduced.lines
    ending = Ending(" ".join(filter(None, [*named, *told])), (*inertias.definitions, *last))
    sections.append(ending)
    whole = (*inertias.definitions, *lines, *integrals, *new)
    unknowns = {**inertias.unknowns, **reduced.unknowns}
    return Ending(" ".join([*named, *said]), whole, unknowns, sections=tuple(sections))


def _list_accelerations(solved: EliminatedSolution) -> Iterator[Equation]:
    """Yield the accelerations; of those that follow, only what is no longer than those kept."""
    kept = {f"{name}'" for name in solved.kept}
    sizes = {name: len(value.above) for name, value in solved.accelerations.items()}
    longest = max((sizes[name] for name in sizes.keys() & kept), default=inf)
    for name, value in solved.accelerations.items():
        if name in kept or 0 < sizes[name] <= longest:
            yield value.equate(name)


def _eliminate(derivation: Derivation, solved: EliminatedSolution) -> Ending:
    """Return the section from equations with constraints to those of the free coordinates."""
    kept, where = enumerate_words([*map(coordinate_of, solved.kept)]), _say_where(solved)
    said = f"The constraints leave {kept} free."
    if derivation.quasi:
        said += (
            " The velocities depend on each other as their displacements do. Inserted with their "
            f"rates into the equations of motion, these relations leave{where}:"
        )
        return Ending(said, solved.equations, title="Elimination of the dependent velocities")
    lines = (*_follow(solved), *solved.equations)
    said += f" {_OTHERS}"
    said += f" {_ELIMINATED} {_REMAIN}{where}."
    return Ending(said, lines, title="Elimination of the constraint forces")


def _say_where(solved: EliminatedSolution) -> str:
    """Say where the equations of the velocities that are kept hold."""
    return say_where(Quotient(row, row.ring.number(1)) for row in solved.rows)


def _follow(solved: EliminatedSolution) -> Iterator[Result]:
    """Yield the velocities that follow from those that are kept."""
    for name, rate in solved.followers.items():
        if rate:
            yield Result(rate.ring[name], rate)


def _reduce(derivation: Derivation) -> Ending:
    """Return the equations that loops or cyclic coordinates leave; of long ones, where they are."""
    mechanism = derivation.algebra.mechanism
    with suppress(DerivationError):
        lagrange = Lagrange(mechanism, named=True)
        of_work = any(name.startswith("δ") for name in derivation.unknowns)
        ending = (
            reduce_to_one(lagrange).end(of_work=of_work)
            if mechanism.loops
            else reduce_by_momenta(lagrange).ending
        )
        rights = [line.right for line in ending.lines if isinstance(line, Result)]
        if max(map(len, rights), default=0) <= _LONGEST_OF_LOOPS:
            return ending
        return Ending(_ELSEWHERE) if mechanism.loops else NO_ENDING
    return NO_ENDING


def _insert(reactions: Mapping[str, Series], solved: EliminatedSolution) -> dict[str, Quotient]:
    """Return the forces in joints and elements that one acceleration makes short when inserted."""
    if len(solved.accelerations) != 1:
        return {}
    moved = {
        name: solved.insert(force)
        for name, force in reactions.items()
        if Kind.ACCELERATION in force.kinds and Kind.REACTION not in force.kinds
    }
    return {name: force for name, force in moved.items() if len(force.above) <= _LONGEST_INSERTED}


def _list_momenta(stages: tuple[Stage, ...]) -> Iterator[Result]:
    """Yield the constant momenta."""
    for stage in stages:
        for line in stage.results:
            if isinstance(line.left, Left) and line.left.quantity == "p" and line.left.component:
                yield line
