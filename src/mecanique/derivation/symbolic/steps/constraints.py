"""Write the steps that state the constraints of loops and rolling, and solve for multipliers."""

from __future__ import annotations

from collections.abc import Sequence

from mecanique.derivation.scalars.cancel import tidy
from mecanique.derivation.scalars.series import Series
from mecanique.derivation.symbolic.derivation import Left, Matrix, Result, Stage
from mecanique.derivation.symbolic.symbols import Algebra
from mecanique.derivation.symbolic.ties.multipliers import solve_multipliers
from mecanique.derivation.symbolic.ties.tie import Tie

_LONGEST_RATE = 40
"""Constraints of loops on velocities or accelerations with more terms are too long to be read."""


def loop_stages(
    ties: Sequence[Tie], *, of_work: bool = False, of_forces: bool = False
) -> list[Stage]:
    """Return the steps that state the constraints of loops and of rolling.

    Args:
        ties: the equations of the loops, contacts and velocity constraints.
        of_work: whether the method is virtual work, in which no multipliers appear.
        of_forces: whether the multipliers are forces on the bodies, not generalized forces.
    """
    found = []
    loops = [tie for tie in ties if not tie.of_velocities and not tie.of_contact]
    if loops:
        sentence = (
            "Each loop joins a point or a frame of one body to one of another. Their separation Φ "
            "follows from the poses of both; it is zero as long as the loop is closed."
        )
        if of_forces:
            sentence += (
                " Where the loop is cut open, the bodies exert the unknown force λ on each other, "
                "like a reaction."
            )
        elif not of_work:
            sentence += (
                " In a virtual displacement that opens it by δΦ its force λ does the work λ δΦ; "
                "therefore λ ∂Φ/∂q is added to the generalized forces."
            )
        found.append(Stage("Loops", sentence, _list_demands(loops)))
        found += _differentiate_loops(loops)
    rolling = [tie for tie in ties if tie.of_velocities or tie.of_contact]
    if rolling:
        sentence = (
            "Where a body rolls, its point of contact has the same velocity as the point it "
            "touches; a blade does not move sideways. Φ is the distance from the plane; ψ, linear "
            "in the velocities, is in general not integrable."
        )
        if not of_work:
            sentence += (
                " The constraints must not be substituted into T. In a virtual displacement along "
                "which ψ is δψ the force λ does the work λ δψ; therefore λ ∂ψ/∂q' and λ ∂Φ/∂q are "
                "added to the generalized forces."
            )
        found.append(Stage("Constraints on velocities", sentence, _list_demands(rolling)))
    return found


def _differentiate_loops(loops: Sequence[Tie]) -> list[Stage]:
    """Return the step with the loops' constraints on velocities and accelerations, if short."""
    derived = [("'", tie, tie.demand.ddt()) for tie in loops]
    derived += [("''", tie, tie.second) for tie in loops]
    if max(len(series) for *_, series in derived) > _LONGEST_RATE:
        return []
    results = []
    for primes, tie, series in derived:
        left = Left(f"{tie.letter}_{tie.name}", primes=primes)
        results.append(Result(left, tidy(series)))
    sentence = (
        "As the loops remain closed, Φ' = 0 constrains the velocities and Φ'' = 0 the "
        "accelerations. The latter equations are linear in the accelerations, and the equations of "
        "motion are linear in accelerations and multipliers: one linear system gives them all."
    )
    return [Stage("Loops in motion", sentence, tuple(results))]


def multiplier_stages(
    algebra: Algebra, M: Matrix, rest: Sequence[Series], ties: Sequence[Tie]
) -> list[Stage]:
    """Return the step that solves for the multipliers of loops, if it is short.

    Args:
        algebra: the mechanism's symbols.
        M: rows of the mass matrix.
        rest: h − Q of each velocity.
        ties: the equations of the loops alone.
    """
    ring = algebra.ring
    if not ties or any(tie.of_velocities or tie.of_contact for tie in ties):
        return []
    a = [ring[name] for name in algebra.accelerations]
    sides = []
    for row, other in zip(M, rest, strict=True):
        sides.append(ring.sum([*(m * x for m, x in zip(row, a, strict=True)), other]))
    slopes = [list(map(tidy, tie.slopes(ring))) for tie in ties]
    solved = solve_multipliers(ties, slopes, sides)
    if not solved:
        return []
    results = []
    for one in solved:
        name = one.multiplier.generators()[0].name
        left = Left(name) if one.factor == 1 else tidy(one.factor * one.multiplier)
        results.append(Result(left, one.value))
    sentence = (
        "The equations of motion are linear in the multipliers. In this order, each gives one more "
        "of them in terms of the accelerations; the remaining equations do not contain them."
    )
    return [Stage("Multipliers", sentence, tuple(results))]


def _list_demands(ties: Sequence[Tie]) -> tuple[Result, ...]:
    return tuple(Result(Left(f"{tie.letter}_{tie.name}"), tie.demand) for tie in ties)
