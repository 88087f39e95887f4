"""Write forces as series: a spring's energy, a damper's Rayleigh function, the work of others."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import final

from mecanique.derivation.laws import Elastic, Law, Travel, laws_of
from mecanique.derivation.mechanics.forces import Span, argument_of
from mecanique.derivation.scalars.cancel import integrate, tidy
from mecanique.derivation.scalars.series import GIVEN, TIMED, Kind, Ring, Series
from mecanique.derivation.symbolic.derivation import Assumption
from mecanique.derivation.symbolic.kinematics import Kinematics, moves
from mecanique.derivation.symbolic.symbols import Algebra
from mecanique.derivation.symbolic.vectors import Vector
from mecanique.errors import DerivationError
from mecanique.model.force_base import AnyForce, BodyLoad, WrenchOnBody
from mecanique.model.mechanism import Mechanism
from mecanique.model.mechanism.letters import call

MOST_VELOCITIES = 12
"""Where more can move, the potentials of loads are not sought: their series would be too long."""


def assume_length(force: str, length: Series) -> tuple[Assumption, ...]:
    """Return the assumption about the sign of a distance that is no root, if it can change."""
    # If the squared distance is the square of a polynomial, the distance is that polynomial, taken
    # as positive where all coordinates are zero; otherwise it is adjoined as a root
    atoms = length.ring.atoms
    rational = all(
        atoms[g.index].argument.is_number for g in length.generators() if g.index in atoms
    )
    return (
        (Assumption(f"the length of {call(force)}", length),) if moves(length) and rational else ()
    )


def length_names(
    ring: Ring, lengths: Iterable[tuple[str, Series]], distances: Iterable[tuple[Series, str]] = ()
) -> dict[str, str]:
    """Return the meaning of each root with a name, such as the length of a spring."""
    lengths_of: dict[str, list[str]] = {}
    whole: dict[str, bool] = {}
    for name, length in lengths:
        for g in length.generators():
            if g.index in ring.atoms and ring.atoms[g.index].named:
                lengths_of.setdefault(g.name, []).append(name)
                whole[g.name] = whole.get(g.name, True) and length == ring[g.name]
    roots = (i for i, atom in ring.atoms.items() if atom.named and atom.function == "sqrt")
    meant = dict(distances)
    names = [ring.generators[i].name for i in roots]
    said = {name: meant.get(ring[name], "root") for name in names}
    for name, owners in lengths_of.items():
        what, unit = ("length", " [m]") if whole[name] else ("root in the length", "")
        said[name] = f"{what} of {' and '.join(map(call, owners))}{unit}"
    return said


@final
@dataclass(frozen=True)
class Work:
    """The contribution of one force to the equations of motion."""

    name: str
    kind: str  # "potential", "dissipation" or "work"
    scalar: Series | None  # its energy V, its Rayleigh function D, or None
    # generalized forces by coordinate: −∂V/∂q, −∂D/∂q' or the coefficients of δq in δW
    forces: tuple[Series, ...]
    assumptions: tuple[Assumption, ...] = ()  # the assumptions of these expressions
    # the distance between the ends of a spring or damper, if it occurs
    length: Series | None = None
    # stiffness k and elongation x of a spring with the energy ½ k x²
    square: tuple[Series, Series] | None = None
    elastic: bool = False  # whether its law is that of a spring
    stated: bool = True  # whether its energy is that of its law, not found from a load


def works_of(kinematics: Kinematics, force: AnyForce) -> Iterator[Work]:
    """Yield the contributions of a force, law by law."""
    algebra = kinematics.algebra
    if isinstance(force, BodyLoad):
        yield _find_work(kinematics, force.name, force.wrench)
        return
    for law in laws_of(force, algebra.series):
        along = argument_of(force, kinematics)
        scalar = law.scalar(along)
        forces = _find_forces(algebra, law, along, scalar)
        length = along.length if isinstance(along, Span) else None
        # in the other laws only the square of the length occurs, so its sign does not matter
        signed = None if law.kind != "potential" else length
        yield Work(
            name=force.name,
            kind=law.kind,
            scalar=scalar,
            forces=forces,
            assumptions=() if signed is None else assume_length(force.name, signed),
            length=length,
            square=_find_square(law, along),
            elastic=isinstance(law, Elastic),
        )


def store_constant(algebra: Algebra, load: Work) -> Series | None:
    """Return −Σ Q q, the potential of a load that is the same everywhere; None of any other."""
    used = _list_kinds(algebra, load)
    if used is None or not used <= GIVEN | TIMED:
        return None
    coordinates = map(algebra.ring.__getitem__, algebra.mechanism.coordinates)
    return -algebra.ring.sum([Q * q for Q, q in zip(load.forces, coordinates, strict=True)])


def _list_kinds(algebra: Algebra, load: Work) -> set[Kind] | None:
    """Return what a load along the coordinates depends on, None of what is no such load."""
    rates = [f"{name}'" for name in algebra.mechanism.coordinates]
    if load.kind != "work" or rates != [*algebra.velocities]:
        return None
    return set[Kind]().union(*(force.kinds for force in load.forces))


def find_potential(algebra: Algebra, load: Work) -> Work:
    """Return a load as a potential if algebra shows that it has one, else as it is."""
    # Q = −∂V/∂q is integrated coordinate by coordinate; V is right if its derivatives are −Q
    ring, names, used = algebra.ring, algebra.mechanism.coordinates, _list_kinds(algebra, load)
    if used is None or not used <= {*GIVEN, Kind.COORDINATE} or Kind.COORDINATE not in used:
        return load
    V = ring.number(0)
    for name, force in zip(names, load.forces, strict=True):
        share = integrate(tidy(force + V.diff(name)), name)
        if share is None:
            return load
        V = tidy(V - share)
    falls = zip(ring.along(V), load.forces, strict=True)
    # a load that nothing moves against does no work, and needs no potential
    if not V or not all((fall + force).vanishes() for fall, force in falls):
        return load
    return replace(load, kind="potential", scalar=V, stated=False)


def find_potentials(algebra: Algebra, works: Iterable[Work]) -> list[Work]:
    """Return loads as potentials where algebra shows that they have one, each or all the rest."""
    judged = [find_potential(algebra, work) for work in works]
    rest = [k for k, work in enumerate(judged) if work.kind == "work"]
    if len(rest) > 1:
        columns = zip(*(judged[k].forces for k in rest), strict=True)
        sums = tuple(tidy(algebra.ring.sum(list(column))) for column in columns)
        whole = find_potential(algebra, replace(judged[rest[0]], forces=sums))
        if whole.kind == "potential":  # which stands with the first of them
            nothing = algebra.ring.number(0)
            idle = replace(whole, scalar=nothing, forces=(nothing,) * len(sums))
            for k in rest:
                part = whole if k == rest[0] else idle
                judged[k] = replace(part, name=judged[k].name, assumptions=judged[k].assumptions)
    return judged


@lru_cache(maxsize=32)
def stored_in_loads(mechanism: Mechanism) -> Mapping[str, Series]:
    """Return the potential of each load that algebra shows to have one, by the load's name."""
    loads = [force for force in mechanism.forces if not force.conservative]
    if not loads or mechanism.nv > MOST_VELOCITIES:
        return {}
    stored = {}
    try:
        kinematics = Kinematics(Algebra(mechanism))
        every = [work for force in loads for work in works_of(kinematics, force)]
        judged = find_potentials(kinematics.algebra, every)
        for name in (force.name for force in loads):
            works = [work for work in judged if work.name == name]
            if all(work.kind == "potential" for work in works):
                ring = kinematics.algebra.ring
                stored[name] = ring.sum([work.scalar for work in works if work.scalar])
    except DerivationError:
        return {}
    return stored


def _find_square(law: Law, along: Span | Travel) -> tuple[Series, Series] | None:
    """Return stiffness and elongation of a spring with a free length or in a joint, else None."""
    if not isinstance(law, Elastic) or not (law.rest or isinstance(along, Travel)):
        return None
    return law.stiffness, along.x - law.rest


def _find_forces(
    algebra: Algebra, law: Law, along: Span | Travel, scalar: Series | None
) -> tuple[Series, ...]:
    """Return the generalized forces: −∂V/∂q of a potential, −f ∂x/∂q of a pull f."""
    if law.kind == "potential" and scalar is not None:
        return tuple(-slope for slope in algebra.ring.along(scalar))
    pull = law.pull(Travel(along.x, along.rate, along.name))
    return tuple(-(pull * slope) for slope in algebra.ring.along(along.x))


def _find_work(kinematics: Kinematics, name: str, wrench: WrenchOnBody) -> Work:
    """Return the work F·δr + C·δφ; the virtual displacement along δq is ∂(velocity)/∂q'."""
    algebra, body = kinematics.algebra, wrench.body
    works: list[list[Series]] = [[] for _ in algebra.velocities]

    def add(force: Vector, motion: Vector) -> None:
        for component, rate in zip(force, motion, strict=True):
            for work, slope in zip(works, algebra.ring.partials(rate), strict=True):
                work.append(component * slope)

    if wrench.force is not None:
        F = kinematics.vector(wrench.force, wrench.axes, body)
        add(F, kinematics.velocity(body, wrench.point))
    if wrench.torque is not None:
        C = kinematics.vector(wrench.torque, wrench.axes, body)
        add(C, kinematics.spin(body))
    return Work(name, "work", None, tuple(map(algebra.ring.sum, works)))
