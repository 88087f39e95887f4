"""The steps of Lagrange's method in words and formulas, in the order of a textbook."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from math import prod

from mecanique.derivation.printing.equations import expression, half_square, join, shorter
from mecanique.derivation.printing.printed import Expression
from mecanique.derivation.scalars.cancel import tidy
from mecanique.derivation.scalars.monomials import exponents
from mecanique.derivation.scalars.ring import Euler
from mecanique.derivation.scalars.series import Kind, Series
from mecanique.derivation.symbolic.derivation import Left, Matrix, Result, Stage
from mecanique.derivation.symbolic.forces import Work
from mecanique.derivation.symbolic.kinematics import Kinematics
from mecanique.derivation.symbolic.symbols import Algebra
from mecanique.derivation.symbolic.ties.multipliers import solve_multipliers
from mecanique.derivation.symbolic.ties.tie import Tie

__all__ = [
    "coordinate_of",
    "coordinate_stages",
    "energy_integral",
    "energy_stages",
    "geometry_stages",
    "loop_stages",
    "multiplier_stages",
    "quaternion_stages",
    "work_stages",
]

_MOST_LISTED = 600
"""Most terms of positions and velocities that are listed."""

_LONGEST_RATE = 40
"""Terms of a loop's demand on velocities or accelerations above which it would help no reader."""


def quaternion_stages(algebra: Algebra) -> list[Stage]:
    """Return the step that says how quaternions and positions follow from the velocities."""
    names = algebra.mechanism.coordinates
    free = [name for name in names if f"{name}'" not in algebra.velocities]
    if not free:
        return []
    sentence = (
        "The velocities of a body that turns freely are components in its own axes. Its unit "
        "quaternion p follows the angular velocity w by p' = p w / 2, a product of quaternions, "
        "and its position follows the turned velocity."
    )
    ring = algebra.ring
    results = tuple(Result(Left(f"{name}'"), ring.rates[ring.index(name)]) for name in free)
    return [Stage("Rates of the coordinates", sentence, results)]


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
        works: what each force contributes.
        V: potential energy of gravity and springs.
        heavy: whether gravity acts at all.
    """
    parts = [Result(Left(f"T_{name}"), series) for name, series in kinetic if series]
    parts = parts if len(parts) > 1 else []
    found = [
        Stage(
            "Kinetic energy",
            "A body has half its mass times the square of the velocity of its center of mass, and "
            "half its moments of inertia times the squares of its angular velocity; summed over "
            "all bodies, this is T.",
            (*parts, Result(Left("T"), T)),
        )
    ]
    stored = _list_energies(gravity, works)
    sentences = []
    if gravity:
        sentences.append(
            "The weights do the work that V loses: it is zero where all centers of mass are at the "
            "height of the origin."
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
    """The energy of the weights and of each spring."""
    springs = [work for work in works if work.kind == "potential" and work.scalar is not None]
    stored = [_store(work.name, work) for work in springs]
    return [Result(Left("V_gravity"), gravity), *stored] if gravity else stored


def _write_potential(gravity: Series, works: Sequence[Work], V: Series) -> Expression:
    """The potential energy spring by spring, where that is shorter."""
    parts = join(part.expression() for part in _list_energies(gravity, works))
    return shorter(parts, expression(V))


def _store(name: str, work: Work) -> Result:
    """The energy of a spring, as a square where its elongation is known."""
    assert work.scalar is not None
    shown = None if work.square is None else partial(half_square, *work.square)
    return Result(Left(f"V_{name}"), work.scalar, shown)


def geometry_stages(kinematics: Kinematics) -> list[Stage]:
    """Return the step from the coordinates to the velocities of all bodies."""
    mechanism, results = kinematics.algebra.mechanism, list[Result]()
    for body in kinematics.bodies:
        given = mechanism.body(body)
        found = {}
        if given.mass != 0:
            found["r"] = kinematics.point(body, given.center)
            found["v"] = kinematics.velocity(body, given.center)
        if any(entry != 0 for entry in given.inertia):
            found["omega"] = kinematics.spin(body)
        for letter, vector in found.items():
            for axis, part in zip("xyz", vector, strict=True):
                if part:
                    results.append(Result(Left(f"{letter}_{body}_{axis}"), tidy(part)))
    if not results or sum(len(result.right) for result in results) > _MOST_LISTED:
        return []
    sentence = (
        "The poses of the bodies as functions of the coordinates give the position r of each "
        "center of mass, its rate the velocity v, and the turning axes the angular velocity omega. "
        "Components along x, y and z of the world that are not listed are zero."
    )
    if any(joint.quaternion for joint in mechanism.joints):
        sentence += (
            " Velocities of a body that turns freely, and of what hangs on it, are in its own axes."
        )
    return [Stage("Positions and velocities", sentence, tuple(results))]


def energy_integral(
    T: Series,
    gravity: Series,
    V: Series,
    D: Series,
    works: Sequence[Work],
    ties: Sequence[Tie],
) -> list[Stage]:
    """Return the step that says what the motion conserves, if L does not depend on time.

    Where a prescribed motion puts terms without velocities or linear in them into T, that is not
    the energy but Jacobi's integral (Goldstein, Classical Mechanics, 3rd ed., eq. 2.53).
    """
    given = {Kind.TIME, Kind.INPUT}
    every = [T, V, *(tie.demand for tie in ties)]
    kinds = {g.kind for series in every for g in series.generators()}
    # a constraint that moves steadily, like a turntable, does work
    driven = any(tie.of_velocities and _orders(tie.demand) != {1} for tie in ties)
    if D or driven or kinds & given or any(work.kind == "work" for work in works):
        return []
    idle = "Nothing depends on time, no force but weights and springs does work" + (
        ", and the constraints do none" if ties else ""
    )
    potential = partial(_write_potential, gravity, works, V)
    if _orders(T) <= {2}:
        sentence = f"{idle}: along any motion the total energy keeps its value."
        energy = Result(Left("E"), T + V, lambda: join((expression(T), potential())))
        return [Stage("Energy integral", sentence, (energy,))]
    degrees, zero = _degrees(T), T.ring.number(0)
    square, rest = degrees.get(2, zero), degrees.get(0, zero)
    sentence = (
        "L = T - V does not depend on time, but a drive keeps up the prescribed motion and does "
        "work, so that the total energy changes. What keeps its value is Jacobi's integral "
        "h = Σ q' ∂T/∂q' - L: V and the part of T that is quadratic in the velocities, less the "
        "part without velocities."
    )
    integral = Result(
        Left("h"),
        square + V - rest,
        lambda: join((expression(square), expression(-rest), potential())),
    )
    return [Stage("Jacobi's integral", sentence, (integral,))]


def _orders(series: Series) -> set[int]:
    """The degrees in the velocities that the terms of a series have."""
    moving = {g.index for g in series.ring.generators if g.kind is Kind.VELOCITY}
    found = set()
    for monomial in set().union(*series.parts.values()):
        found.add(sum(e for i, e in exponents(monomial) if i in moving))
    return found


def _degrees(series: Series) -> dict[int, Series]:
    """The parts of a series by their degree in the velocities."""
    ring = series.ring
    velocities = [g.name for g in ring.generators if g.kind is Kind.VELOCITY]
    found: dict[int, list[Series]] = {}
    for powers, coefficient in series.coefficients(velocities).items():
        rates = [ring[name] ** e for name, e in zip(velocities, powers, strict=True) if e]
        found.setdefault(sum(powers), []).append(prod(rates, start=coefficient))
    return {degree: tidy(ring.sum(terms)) for degree, terms in found.items()}


def work_stages(algebra: Algebra, works: Sequence[Work], D: Series) -> list[Stage]:
    """Return the steps that treat dampers, drives and loads."""
    found = []
    if D:
        sentence = (
            "A linear damper resists with c times its rate; half of c times the square of the rate "
            "is Rayleigh's dissipation function D, whose slope along a velocity is the force of "
            "the dampers against it."
        )
        found.append(Stage("Dissipation", sentence, (Result(Left("D"), D),)))
    loads = [work for work in works if work.kind == "work"]
    if loads:
        sentence = (
            "In a virtual displacement each drive and each load does work; the factor before the "
            "displacement of a coordinate is the generalized force Q that belongs to it."
        )
        results = []
        for k, name in enumerate(algebra.velocities):
            total = algebra.ring.sum([work.forces[k] for work in loads])
            results.append(Result(Left("Q", coordinate_of(name), component=True), total))
        found.append(Stage("Virtual work of drives and loads", sentence, tuple(results)))
    return found


def loop_stages(
    ties: Sequence[Tie], *, of_work: bool = False, of_forces: bool = False
) -> list[Stage]:
    """Return the steps that say what the loops demand, and what rolls.

    Args:
        ties: the equations of the loops, contacts and velocity constraints.
        of_work: whether the multipliers do not appear.
        of_forces: whether they are forces on the bodies, not generalized forces.
    """
    found = []
    loops = [tie for tie in ties if not tie.of_velocities and not tie.of_contact]
    if loops:
        sentence = (
            "Each loop joins a point or a frame of one body to one of another; what parts them, Φ, "
            "follows from the poses of both and is zero as long as the loop is closed."
        )
        if of_forces:
            sentence += (
                " Cut open there, the bodies exert the unknown force λ on each other, like a "
                "reaction."
            )
        elif not of_work:
            sentence += (
                " In a virtual displacement that opens it by δΦ its force λ does the work λ δΦ, "
                "so that λ ∂Φ/∂q joins the generalized forces."
            )
        found.append(Stage("Loops", sentence, _demands(loops)))
        found += _moving_loops(loops)
    rolling = [tie for tie in ties if tie.of_velocities or tie.of_contact]
    if rolling:
        sentence = (
            "Where a body rolls, the point that touches has the velocity of the point it touches; "
            "a blade does not move sideways. Φ is the distance from the plane; ψ, linear in the "
            "velocities, is in general not integrable."
        )
        if not of_work:
            sentence += (
                " The constraints must not be put into T. In a virtual displacement along which ψ "
                "is δψ the force λ does the work λ δψ, so that λ ∂ψ/∂q' joins the generalized "
                "forces, and λ ∂Φ/∂q."
            )
        found.append(Stage("Constraints on velocities", sentence, _demands(rolling)))
    return found


def _moving_loops(loops: Sequence[Tie]) -> list[Stage]:
    """The demands of the loops on velocities and accelerations, if they are short."""
    derived = [("'", tie, tie.demand.ddt()) for tie in loops]
    derived += [("''", tie, tie.second) for tie in loops]
    if max(len(series) for *_, series in derived) > _LONGEST_RATE:
        return []
    results = []
    for primes, tie, series in derived:
        left = Left(f"{tie.letter}_{tie.name}", primes=primes)
        results.append(Result(left, tidy(series)))
    sentence = (
        "Loops that are closed at all times stay closed: Φ' = 0 ties the velocities, Φ'' = 0 the "
        "accelerations. The latter are linear in the accelerations, as the equations of motion "
        "are in accelerations and multipliers, and so all of them follow from one linear system."
    )
    return [Stage("Loops in motion", sentence, tuple(results))]


def multiplier_stages(
    algebra: Algebra, M: Matrix, rest: Sequence[Series], ties: Sequence[Tie]
) -> list[Stage]:
    """Return the step that solves for the multipliers of loops, where it is short.

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
        "The equations of motion hold the multipliers linearly. Taken in this order, each gives "
        "one more of them by the accelerations; what is left is free of them."
    )
    return [Stage("Multipliers", sentence, tuple(results))]


def _demands(ties: Sequence[Tie]) -> tuple[Result, ...]:
    return tuple(Result(Left(f"{tie.letter}_{tie.name}"), tie.demand) for tie in ties)


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
        falls: the slope of V along each velocity.
        losses: the slope of D with each velocity.
        free: whether no drive, load or constraint acts along each velocity.
    """
    found = []
    alone = free or [False] * len(velocities)
    each = zip(velocities, operated, turning, falls, losses, alone, strict=True)
    for v, E, terms, fall, loss, unforced in each:
        q = coordinate_of(v)
        quasi = q == v
        sentence = (
            f"Lagrange's operator for {q}: the momentum that belongs to it, how that changes in "
            "time, and how T and V change with the coordinate while the velocities stay."
        )
        if quasi:
            sentence = (
                f"The operator for {v}, which is no rate of a coordinate: because its axes turn "
                "with the body, the terms of Euler and Kirchhoff enter."
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
    """Return the coordinate a velocity is the rate of, or the name of a quasi-velocity itself.

    Args:
        velocity: its name, e.g. "q'".
    """
    return velocity.removesuffix("'")
