"""Write the steps that find the energies and the conserved quantities."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from math import prod

from mecanique.derivation.printing.equations import expression, half_square, join, shorter
from mecanique.derivation.printing.printed import Expression
from mecanique.derivation.scalars.cancel import tidy
from mecanique.derivation.scalars.generators import Kind
from mecanique.derivation.scalars.monomials import exponents
from mecanique.derivation.scalars.series import Series
from mecanique.derivation.symbolic.derivation import Left, Result, Stage
from mecanique.derivation.symbolic.forces import Work
from mecanique.derivation.symbolic.ties.tie import Tie


def energy_stages(
    kinetic: Sequence[tuple[str, Series]],
    T: Series,
    gravity: Series,
    works: Sequence[Work],
    V: Series,
    heavy: bool,
) -> list[Stage]:
    """Return the steps that find the kinetic and the potential energy.

    Args:
        kinetic: name and kinetic energy of each body and rotor.
        T: their sum.
        gravity: potential energy of gravity.
        works: the contributions of each force.
        V: potential energy of gravity and springs.
        heavy: whether gravity acts at all.
    """
    parts = [Result(Left(f"T_{name}"), series) for name, series in kinetic if series]
    parts = parts if len(parts) > 1 else []
    found = [
        Stage(
            "Kinetic energy",
            "The kinetic energy of a body is half its mass times the square of the velocity of its "
            "center of mass, plus half its moments of inertia times the squares of its angular "
            "velocity; the sum over all bodies is T.",
            (*parts, Result(Left("T"), T)),
        )
    ]
    stored = _list_energies(gravity, works)
    sentences = []
    if gravity:
        sentences.append(
            "The work of the weights is the decrease of V, which is zero where all centers of mass "
            "are at the height of the origin."
        )
    elif heavy:
        sentences.append("The weights do no work in this motion.")
    if len(stored) > bool(gravity):
        sentences.append(
            "Each spring stores half its stiffness times the square of its elongation."
        )
    if stored:
        several = stored if len(stored) > 1 else []
        whole = Result(Left("V"), V, partial(_write_potential, gravity, works, V))
        found.append(Stage("Potential energy", " ".join(sentences), (*several, whole)))
    elif not V:
        sentence = "There are neither weights nor springs: V is zero."
        if heavy:
            sentence = "The weights do no work in this motion, and there are no springs: V is zero."
        found.append(Stage("Potential energy", sentence, (Result(Left("V"), V),)))
    return found


def _list_energies(gravity: Series, works: Sequence[Work]) -> list[Result]:
    """List the energy of the weights and of each spring."""
    springs = [work for work in works if work.kind == "potential" and work.scalar is not None]
    stored = [_store(work.name, work) for work in springs]
    return [Result(Left("V_gravity"), gravity), *stored] if gravity else stored


def _write_potential(gravity: Series, works: Sequence[Work], V: Series) -> Expression:
    """Write the potential energy spring by spring, where that is shorter."""
    parts = join(part.expression() for part in _list_energies(gravity, works))
    return shorter(parts, expression(V))


def _store(name: str, work: Work) -> Result:
    """Write the energy of a spring, as a square where its elongation is known."""
    assert work.scalar is not None
    shown = None if work.square is None else partial(half_square, *work.square)
    return Result(Left(f"V_{name}"), work.scalar, shown)


def energy_integral(
    T: Series,
    gravity: Series,
    V: Series,
    D: Series,
    works: Sequence[Work],
    ties: Sequence[Tie],
) -> list[Stage]:
    """Return the step that states the conserved energy, if L does not depend on time.

    If a prescribed motion adds terms of degree 0 or 1 in the velocities to T, the conserved
    quantity is Jacobi's integral instead (Goldstein, Classical Mechanics, 3rd ed., eq. 2.53).
    """
    given = {Kind.TIME, Kind.INPUT}
    every = [T, V, *(tie.demand for tie in ties)]
    kinds = {g.kind for series in every for g in series.generators()}
    # a constraint in steady motion, like a turntable, does work
    driven = any(tie.of_velocities and _find_orders(tie.demand) != {1} for tie in ties)
    if D or driven or kinds & given or any(work.kind == "work" for work in works):
        return []
    idle = "Nothing depends on time, no force but weights and springs does work" + (
        ", and the constraints do none" if ties else ""
    )
    potential = partial(_write_potential, gravity, works, V)
    if _find_orders(T) <= {2}:
        sentence = f"{idle}: the total energy is constant along any motion."
        energy = Result(Left("E"), T + V, lambda: join((expression(T), potential())))
        return [Stage("Energy integral", sentence, (energy,))]
    degrees, zero = _split_by_degree(T), T.ring.number(0)
    square, rest = degrees.get(2, zero), degrees.get(0, zero)
    sentence = (
        "L = T - V does not depend on time, but a drive maintains the prescribed motion and does "
        "work, so the total energy changes. The conserved quantity is Jacobi's integral "
        "h = Σ q' ∂T/∂q' - L: V plus the part of T that is quadratic in the velocities, minus the "
        "part without velocities."
    )
    integral = Result(
        Left("h"),
        square + V - rest,
        lambda: join((expression(square), expression(-rest), potential())),
    )
    return [Stage("Jacobi's integral", sentence, (integral,))]


def _find_orders(series: Series) -> set[int]:
    """Return the degrees of a series' terms in the velocities."""
    moving = {g.index for g in series.ring.generators if g.kind is Kind.VELOCITY}
    found = set()
    for monomial in set().union(*series.parts.values()):
        found.add(sum(e for i, e in exponents(monomial) if i in moving))
    return found


def _split_by_degree(series: Series) -> dict[int, Series]:
    """Split a series into parts by their degree in the velocities."""
    ring = series.ring
    velocities = [g.name for g in ring.generators if g.kind is Kind.VELOCITY]
    found: dict[int, list[Series]] = {}
    for powers, coefficient in series.coefficients(velocities).items():
        rates = [ring[name] ** e for name, e in zip(velocities, powers, strict=True) if e]
        found.setdefault(sum(powers), []).append(prod(rates, start=coefficient))
    return {degree: tidy(ring.sum(terms)) for degree, terms in found.items()}
