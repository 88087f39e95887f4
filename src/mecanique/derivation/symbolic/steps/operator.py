"""Write the steps that apply Lagrange's operator, with the work of drives and loads."""

from __future__ import annotations

from collections.abc import Sequence

from mecanique.derivation.scalars.ring import Euler
from mecanique.derivation.scalars.series import Series
from mecanique.derivation.symbolic.derivation import Left, Result, Stage
from mecanique.derivation.symbolic.forces import Work
from mecanique.derivation.symbolic.symbols import Algebra


def work_stages(algebra: Algebra, works: Sequence[Work], D: Series) -> list[Stage]:
    """Return the steps that treat dampers, drives and loads."""
    found = []
    if D:
        sentence = (
            "A linear damper resists with c times its rate. Half of c times the square of the rate "
            "is Rayleigh's dissipation function D; its derivative by a velocity is the force of "
            "the dampers against that velocity."
        )
        found.append(Stage("Dissipation", sentence, (Result(Left("D"), D),)))
    loads = [work for work in works if work.kind == "work"]
    if loads:
        sentence = (
            "In a virtual displacement each drive and each load does work; the coefficient of a "
            "coordinate's displacement is the generalized force Q of that coordinate."
        )
        results = []
        for k, name in enumerate(algebra.velocities):
            total = algebra.ring.sum([work.forces[k] for work in loads])
            results.append(Result(Left("Q", coordinate_of(name), component=True), total))
        found.append(Stage("Virtual work of drives and loads", sentence, tuple(results)))
    return found


def coordinate_stages(
    velocities: Sequence[str],
    operated: Sequence[Euler],
    turning: Sequence[Series],
    falls: Sequence[Series],
    losses: Sequence[Series],
    free: Sequence[bool] = (),
) -> list[Stage]:
    """Return the steps that apply Lagrange's operator, one for each velocity.

    Args:
        velocities: their names.
        operated: the operator on T.
        turning: the terms of Euler and Kirchhoff.
        falls: the derivative of V along each velocity.
        losses: the derivative of D by each velocity.
        free: whether no drive, load or constraint acts along each velocity.
    """
    found = []
    alone = free or [False] * len(velocities)
    each = zip(velocities, operated, turning, falls, losses, alone, strict=True)
    for v, E, terms, fall, loss, unforced in each:
        q = coordinate_of(v)
        quasi = q == v
        sentence = (
            f"Lagrange's operator for {q}: its momentum, the rate of the momentum, and the "
            "derivatives of T and V by the coordinate at fixed velocities."
        )
        if quasi:
            sentence = (
                f"The operator for {v}, which is not the rate of a coordinate: as its axes turn "
                "with the body, it includes the terms of Euler and Kirchhoff."
            )
        conserved = unforced and not (quasi or E.slope or fall or loss)
        if conserved:
            sentence += (
                f" As neither T nor V depends on {q}, and no other force acts along it, its "
                f"momentum p, ∂T/∂{v}, is conserved."
            )
        lines = [
            (Left("p", q, component=True), E.momentum, conserved),
            (Left("T", v), E.momentum, not conserved),
            (Left("T", v, total=True), E.rate, True),
            (Left("T", v, turning=True), terms, bool(terms)),
            (Left("T", q), E.slope, bool(E.slope) or not quasi),
            (Left("V", q), fall, bool(fall) or not quasi),
            (Left("D", v), loss, bool(loss)),
        ]
        results = tuple(Result(left, right) for left, right, shown in lines if shown)
        found.append(Stage(f"Operator for {q}", sentence, results))
    return found


def coordinate_of(velocity: str) -> str:
    """Return the coordinate whose rate a velocity is, or a quasi-velocity's own name.

    Args:
        velocity: its name, e.g. "q'".
    """
    return velocity.removesuffix("'")
