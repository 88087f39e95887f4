"""A mistake with the equations it leads to, and the right equations that it changes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from itertools import combinations, islice, permutations
from typing import Any, NamedTuple, final

import numpy as np

from mecanique.arrays import Array
from mecanique.checking.judgement.truth import Sample, Truth, accelerate, stack, stack_mass
from mecanique.checking.verdict import Mistake
from mecanique.derivation import derive
from mecanique.derivation.printing.equations import expression
from mecanique.derivation.scalars.evaluation import Evaluation
from mecanique.derivation.scalars.polynomials import exponents
from mecanique.derivation.scalars.series import Kind, Ring, Series
from mecanique.derivation.symbolic.derivation import Derivation
from mecanique.errors import MecaniqueError
from mecanique.model.bodies import Body
from mecanique.model.expression import plain
from mecanique.model.force_base import AnyForce
from mecanique.model.forces import JointSpring, Spring
from mecanique.model.mechanism import Mechanism


@final
@dataclass(frozen=True, eq=False)
class WrongDerivation:
    """A mistake in the whole derivation or in one term, with the equations it leads to."""

    kind: str
    text: str  # the mistake in words; "{}" stands for the term
    weight: float  # the smaller, the likelier
    M: Array  # mass matrix, shape (n, nv, nv)
    rest: Array  # bias minus forces, shape (n, nv)
    row: int = -1  # index of the changed equation; −1 for all
    term: Series | None = None  # the changed term, if there is only one
    released: tuple[int, ...] = ()  # indices of the constraints whose forces are left out

    def mistake(self, more: float = 0.0, equation: int = 0) -> Mistake:
        """Return the mistake in words, with a weight that is larger by so much."""
        text = self.text.format("" if self.term is None else expression(self.term).text())
        return Mistake(self.kind, text, weight=self.weight + more, equation=equation)


@final
class RightEquations:
    """The right equations M a + rest = 0 in the states, and those of changed mechanisms."""

    # With loops or contacts they are those of the tree, without multipliers.

    def __init__(self, truth: Truth, derivation: Derivation) -> None:
        self.truth = truth
        self.derivation = derivation
        self.sample: Sample = truth.sample
        self.rest = self.sample.bias - self.sample.forces

    @cached_property
    def _evaluated(self) -> Evaluation:
        return Evaluation(self.derivation.algebra.ring, self.sample.values)

    def value(self, series: Series) -> Array:
        """Return the values of a series, shape (n,)."""
        return np.broadcast_to(self._evaluated(series), (self.sample.count,))

    def stack(self, rows: Sequence[Sequence[Series]]) -> Array:
        """Return the values of a matrix of series, shape (n, rows, columns)."""
        return np.stack([self._stack_row(row) for row in rows], axis=1)

    def _stack_row(self, row: Sequence[Series]) -> Array:
        return np.stack([self.value(entry) for entry in row], axis=-1)

    def rebuild(self, mechanism: Mechanism) -> tuple[Array, Array] | None:
        """Return M and bias − forces of a changed mechanism in the same states."""
        try:
            derivation = derive(replace(mechanism, loops=(), contacts=())).derivation
        except MecaniqueError:
            return None
        if derivation.algebra.velocities != self.truth.velocities:
            return None
        return self.evaluate(derivation, Evaluation(derivation.algebra.ring, self.sample.values))

    def evaluate(self, derivation: Derivation, evaluated: Evaluation) -> tuple[Array, Array]:
        """Return M and bias − forces of a derivation for some values of its letters."""
        n = self.sample.count
        with np.errstate(all="ignore"):
            M = stack_mass(derivation, evaluated, n)
            bias, forces = (stack(rows, evaluated, n) for rows in (derivation.h, derivation.Q))
            return M, bias - forces


def group_by_velocities(series: Series, velocities: Sequence[str]) -> dict[tuple[int, ...], Series]:
    """Return the parts of a series by powers of the velocities."""
    ring = series.ring
    groups = {}
    for powers, part in series.coefficients(velocities).items():
        whole = part
        for name, power in zip(velocities, powers, strict=True):
            whole = whole * ring[name] ** power if power else whole
        groups[powers] = whole
    return groups


_MOST_SINGLE = 60
"""Longer quantities are not searched term by term."""

_MOST_TERMS = 12
"""Longer entries of the equations are changed only as a whole, not term by term."""


SLIPS = (
    (0.0, "missing", "{} is missing"),
    (-1.0, "sign", "the sign of {} is wrong"),
    (2.0, "factor", "{} is counted twice"),
    (0.5, "factor", "{} is halved"),
)
"""What a part is mistakenly multiplied by, with the kind of mistake and its words."""


class _Term(NamedTuple):
    """A term of a row of the equations, or a group of terms."""

    row: int  # index of the equation
    series: Series  # the term, without its acceleration
    column: int  # column of M; −1 for a term without an acceleration
    name: str  # its name in words
    weight: float  # how likely it is forgotten; smaller is likelier


def mistake_terms(right: RightEquations) -> Iterator[WrongDerivation]:
    """Yield equations with a term left out, of the wrong sign, doubled or halved."""
    for term in _list_terms(right):
        for factor, kind, words in SLIPS:
            name = term.name if kind == "missing" else "the term"
            weight = term.weight + 0.5 * (kind == "factor")
            yield _change(right, term, factor, kind, words.format(f"{name} {{}}"), weight)


def mistake_letters(right: RightEquations) -> Iterator[WrongDerivation]:
    """Yield equations with one letter for another of the same unit in a single term."""
    parameters = right.truth.mechanism.parameters
    values = right.sample.values
    for term in _list_terms(right):
        whole = term.series
        if len(whole) > 1:
            continue
        ((_, monomial, _),) = whole.terms()
        powers = {whole.ring.generators[i].name: e for i, e in exponents(monomial)}
        for right_letter, wrong_letter in permutations(parameters, 2):
            if right_letter.unit == wrong_letter.unit and right_letter.symbol in powers:
                ratio = (values[wrong_letter.symbol] / values[right_letter.symbol]) ** powers[
                    right_letter.symbol
                ]
                text = f"in the term {{}} {wrong_letter.symbol} should be {right_letter.symbol}"
                yield _change(right, term, ratio, "letter", text, 2.1)


def _list_terms(right: RightEquations) -> Iterator[_Term]:
    """Yield the terms that may be wrong: entries of M, groups of h and Q, and their parts."""
    derivation = right.derivation
    velocities = derivation.algebra.velocities
    for row, entries in enumerate(derivation.M):
        for column, entry in enumerate(entries):
            if not entry:
                continue
            diagonal = row == column
            name = "the inertia term" if diagonal else "the coupling term"
            yield _Term(row, entry, column, name, 1.6 if diagonal else 1.0)
            for part in _split(entry):
                yield _Term(row, part, column, "the inertia term", 2.0)
    for row, (h, Q) in enumerate(zip(derivation.h, derivation.Q, strict=True)):
        groups = group_by_velocities(h, velocities)
        for powers, group in groups.items():
            name = _name(powers)
            yield _Term(row, group, -1, name, 1.0)
            for part in _split(group):
                yield _Term(row, part, -1, name, 2.0)
        for group in group_by_velocities(Q, velocities).values():
            yield _Term(row, -group, -1, "the force", 1.2)
            for part in _split(group):
                yield _Term(row, -part, -1, "the force", 1.5)


def _change(
    right: RightEquations,
    term: _Term,
    factor: float | Array,
    kind: str,
    text: str,
    weight: float,
) -> WrongDerivation:
    """Return the equations with a term mistakenly multiplied by a factor."""
    M, rest, shown = right.sample.M, right.rest, term.series
    change = (factor - 1) * right.value(term.series)
    if term.column >= 0:
        M = M.copy()
        M[:, term.row, term.column] += change
        ring = right.derivation.algebra.ring
        shown = term.series * ring[right.truth.accelerations[term.column]]
    else:
        rest = rest.copy()
        rest[:, term.row] += change
    return WrongDerivation(kind, text, weight, M, rest, term.row, shown)


def list_parts(series: Series, velocities: Sequence[str]) -> list[Series]:
    """Return parts of a series: by powers of velocities, by parameters, and single terms."""
    single = [_term(series, *term) for term in series.terms()]
    if len(single) > _MOST_SINGLE:
        return []
    parts = list(group_by_velocities(series, velocities).values())
    for letter in (g for g in series.generators() if g.kind is Kind.PARAMETER):
        parts.append(series.ring.sum([part for part in single if letter in part.generators()]))
    return [part for part in dict.fromkeys([*parts, *_split(series), *single]) if part != series]


def _split(series: Series) -> list[Series]:
    """Return parts of a series: its terms, and those that share letters, or sine and cosine."""
    terms = list(series.terms())
    if not 1 < len(terms) <= _MOST_TERMS:
        return []
    ring = series.ring
    groups: dict[frozenset[int], Series] = {}
    for first, last in ((1, 2), (0, 1), (0, 2)):
        # terms that share the monomial, the sine or cosine, or both
        together: dict[Any, list[int]] = {}
        for place, term in enumerate(terms):
            together.setdefault(term[first:last], []).append(place)
        for places in together.values():
            if len(places) < len(terms):
                parts = [_term(series, *terms[place]) for place in places]
                groups[frozenset(places)] = ring.sum(parts)
    return list(groups.values())


def _term(series: Series, trig: int, monomial: int, c: Fraction) -> Series:
    return Series(series.ring, {trig: {monomial: c.numerator}}, c.denominator, series.reach)


def _name(powers: Sequence[int]) -> str:
    """Return a textbook's name for terms with these powers of the velocities."""
    if sum(powers) == 2:
        return "the centripetal term" if 2 in powers else "the Coriolis term"
    # dampers are forces; these terms come from prescribed motions
    return "the Coriolis term" if sum(powers) == 1 else "the term"


def mistake_operator(right: RightEquations) -> Iterator[WrongDerivation]:
    """Yield equations without parts of Lagrange's operator: d/dt of the inertia, or ∂T/∂q."""
    derivation = right.derivation
    ring = derivation.algebra.ring
    names = derivation.algebra.velocities
    if any(not name.endswith("'") for name in names):
        return
    v = [ring[name] for name in names]
    M, rest = right.sample.M, right.rest
    rows = []
    for k, entries in enumerate(derivation.M):
        terms = [entry.ddt() * rate for entry, rate in zip(entries, v, strict=True)]
        rows.append((k, ring.sum(terms)))
    changing = np.stack([right.value(series) for _, series in rows], axis=-1)
    squares = _collect_quadratic(right, derivation.h, names)
    slopes = changing - squares
    text = "a rate is treated as constant: d/dt of the momentum lacks {}"
    for k, series in rows:
        if series:
            less = rest.copy()
            less[:, k] -= changing[:, k]
            yield WrongDerivation(
                kind="rate constant", text=text, weight=1.4, M=M, rest=less, row=k, term=series
            )
            less = rest.copy()
            less[:, k] += slopes[:, k]
            what = f"the term −∂T/∂{names[k][:-1]} is missing (centripetal)"
            yield WrongDerivation(kind="missing", text=what, weight=1.3, M=M, rest=less, row=k)
    what = "all terms with squares and products of velocities are missing"
    yield WrongDerivation("missing", what, 1.2, M, rest - squares)
    what = "every rate is treated as constant in d/dt of the momenta"
    yield WrongDerivation("rate constant", what, 1.3, M, rest - changing)
    what = "the terms −∂T/∂q are missing (centripetal)"
    yield WrongDerivation("missing", what, 1.3, M, rest + slopes)


def _collect_quadratic(right: RightEquations, h: Sequence[Series], names: Sequence[str]) -> Array:
    """Return the terms of second degree in the velocities, shape (n, nv)."""
    columns = []
    for series in h:
        groups = group_by_velocities(series, names)
        squares = [part for powers, part in groups.items() if sum(powers) == 2]
        columns.append(right.value(series.ring.sum(squares)))
    return np.stack(columns, axis=-1)


def mistake_readings(right: RightEquations) -> Iterator[WrongDerivation]:
    """Yield equations with parameters of the same unit exchanged throughout."""
    mechanism = right.truth.mechanism
    used = {g.name for row in right.derivation.rows for g in row.generators()}
    parameters = [p for p in mechanism.parameters if p.symbol in used]
    for first, second in permutations(parameters, 2):
        if first.unit != second.unit:
            continue
        moved = {first.symbol: right.sample.values[second.symbol]}
        what = f"{second.symbol} is written for {first.symbol} throughout"
        yield _read(right, "letter", what, 1.5, moved)
        if first.symbol < second.symbol:
            moved |= {second.symbol: right.sample.values[first.symbol]}
            what = f"{first.symbol} and {second.symbol} are exchanged throughout"
            yield _read(right, "letter", what, 1.5, moved)


def _read(
    right: RightEquations,
    kind: str,
    what: str,
    weight: float,
    moved: Mapping[str, Any],
    turn: Array | None = None,
) -> WrongDerivation:
    """Return the equations with other values of letters; `turn` converts our a to theirs."""
    derivation = right.derivation
    evaluated = Evaluation(derivation.algebra.ring, {**right.sample.values, **moved})
    M, rest = right.evaluate(derivation, evaluated)
    if turn is not None:
        M = M @ turn
    return WrongDerivation(kind, what, weight, M, rest)


def mistake_angles(right: RightEquations) -> Iterator[WrongDerivation]:
    """Yield equations with absolute coordinates for relative ones, and vice versa."""
    mechanism, values = right.truth.mechanism, right.sample.values
    moving = [name for name in mechanism.coordinates if f"{name}'" in values]
    for base, moved_letter in permutations(moving, 2):
        for sign in (-1, 1):
            moved = {
                name: values[name] + sign * values[name.replace(moved_letter, base, 1)]
                for name in (moved_letter, f"{moved_letter}'")
            }
            turn = np.eye(mechanism.nv)
            places = mechanism.velocities
            turn[places.index(f"{moved_letter}'"), places.index(f"{base}'")] = sign
            what = (
                f"{moved_letter} is taken relative to {base} instead of absolute"
                if sign > 0
                else f"{moved_letter} is taken absolute instead of relative to {base}"
            )
            yield _read(right, "angle", what, 1.4, moved, turn)


def linearize(right: RightEquations) -> Iterator[WrongDerivation]:
    """Yield the equations linearized about all coordinates zero, if that is an equilibrium."""
    derivation = right.derivation
    ring = derivation.algebra.ring
    if not isinstance(ring, Ring):
        return
    mechanism = right.truth.mechanism
    names = (*derivation.algebra.velocities, *mechanism.coordinates)
    still = {**right.sample.values, **dict.fromkeys(names, np.zeros(right.sample.count))}
    at_rest = Evaluation(ring, still)
    forces, n = right.truth.rest_forces, right.sample.count
    with np.errstate(all="ignore"):
        M, rest = stack_mass(derivation, at_rest, n), stack(forces, at_rest, n)
        for i, force in enumerate(forces):
            for name in names:
                if any(g.name == name for g in force.generators()):
                    rest[:, i] += at_rest(force.diff(name)) * right.sample.values[name]
    yield WrongDerivation(
        "linearized",
        "small angles are assumed throughout: it is the linearized equation",
        0.5,
        M,
        rest,
    )


_FELT = 1e-12
"""A change of M below this part of it is rounding: the moments of inertia do not matter."""
_MOST_BODIES = 7
"""With more bodies in loops, deriving each change again would take seconds."""


def mistake_parts(right: RightEquations) -> Iterator[WrongDerivation]:
    """Yield equations with wrong inertia, weight or spring of a single part."""
    mechanism = right.truth.mechanism
    if mechanism.constrained and len(mechanism.bodies) > _MOST_BODIES:
        return
    yield from _gravity(right, mechanism)
    for body in mechanism.bodies:
        if plain(body.mass) == 0:
            continue
        yield from _body(right, mechanism, body)
    for force in mechanism.forces:
        others = tuple(present for present in mechanism.forces if present is not force)
        less = right.rebuild(replace(mechanism, forces=others))
        if less is not None:
            own_M, own_rest = right.sample.M - less[0], right.rest - less[1]
            for factor, kind, words in SLIPS:
                what = words.format(f"the force {force.name!r}")
                if factor == 0.5:
                    what += " (an extra factor ½)"
                M, rest = less[0] + factor * own_M, less[1] + factor * own_rest
                yield WrongDerivation(kind, what, 1.2 + 0.3 * (kind == "factor"), M, rest)
        yield from _forget_free_length(right, mechanism, force)


def _forget_free_length(
    right: RightEquations, mechanism: Mechanism, force: AnyForce
) -> Iterator[WrongDerivation]:
    changed: AnyForce
    if isinstance(force, Spring) and force.free_length:
        changed = replace(force, free_length=0.0)
    elif isinstance(force, JointSpring) and force.reference:
        changed = replace(force, reference=0.0)
    else:
        return
    forces = tuple(changed if present is force else present for present in mechanism.forces)
    rebuilt = right.rebuild(replace(mechanism, forces=forces))
    if rebuilt is not None:
        what = f"the free length of the spring {force.name!r} is forgotten"
        yield WrongDerivation("free length", what, 0.8, *rebuilt)


def _gravity(right: RightEquations, mechanism: Mechanism) -> Iterator[WrongDerivation]:
    less = right.rebuild(replace(mechanism, gravity=(0.0, 0.0, 0.0)))
    if less is None:
        return
    M, rest = less
    weight = right.rest - rest
    what = "the sign of the potential of gravity is wrong"
    yield WrongDerivation("potential sign", what, 0.9, M, rest - weight)
    yield WrongDerivation("missing", "gravity is missing", 1.0, M, rest)
    what = "the kinetic energy lacks its factor ½, or the potential energy has an extra ½"
    yield WrongDerivation("half", what, 1.1, M, rest + weight / 2)
    what = "the kinetic energy has an extra factor ½, or the potential energy is counted twice"
    yield WrongDerivation("half", what, 1.1, M, rest + 2 * weight)


def _body(right: RightEquations, mechanism: Mechanism, body: Body) -> Iterator[WrongDerivation]:
    """Yield mistakes about a body: inertia about center or joint, Steiner's term, weight."""
    bare = body.replace(inertia=(0.0,) * 6)
    particle = right.rebuild(_with_body(mechanism, bare))
    if particle is None:
        return
    turning = right.sample.M - particle[0], right.rest - particle[1]
    name = body.name
    # the moments of inertia of a body that only slides do not matter
    turns = _differ(right.sample.M, particle[0])
    if turns:
        what = f"the inertia of {name!r} about its own center is missing (as for a particle)"
        yield WrongDerivation("inertia", what, 1.0, *particle)
        what = f"the inertia of {name!r} about its own center is counted twice"
        twice = right.sample.M + turning[0], right.rest + turning[1]
        # a named body says more than a term that "should be 4/5 times as large"
        yield WrongDerivation("inertia", what, 1.3, *twice)
    still = right.rebuild(replace(_with_body(mechanism, bare), gravity=(0.0, 0.0, 0.0)))
    gone = body.replace(mass=0.0, inertia=(0.0,) * 6)
    absent = right.rebuild(replace(_with_body(mechanism, gone), gravity=(0.0, 0.0, 0.0)))
    if still is None or absent is None:
        return
    moving = still[0] - absent[0], still[1] - absent[1]
    if turns:
        what = f"the inertia of {name!r} is taken about its center (Steiner's term is missing)"
        rest = right.rest - moving[1]
        yield WrongDerivation("parallel axis", what, 0.8, right.sample.M - moving[0], rest)
        what = (
            f"Steiner's term of {name!r} is counted twice: inertia about the joint and the "
            "motion of the center"
        )
        rest = right.rest + moving[1]
        yield WrongDerivation("parallel axis", what, 0.9, right.sample.M + moving[0], rest)
    if turns and any(plain(x) for x in body.center):
        far = tuple(2 * x for x in body.center)
        point = right.rebuild(_with_body(mechanism, bare.replace(center=far)))
        # along the axis about which it turns, its end is no other place than its center
        if point is not None and _differ(point[0], particle[0]):
            what = f"{name!r} is taken for a point mass at its end instead of a body with inertia"
            yield WrongDerivation("point mass", what, 0.9, *point)
        moved = right.rebuild(_with_body(mechanism, body.replace(center=far)))
        far_still = right.rebuild(
            replace(_with_body(mechanism, body.replace(center=far)), gravity=(0.0, 0.0, 0.0))
        )
        near_still = right.rebuild(replace(mechanism, gravity=(0.0, 0.0, 0.0)))
        if moved is not None and far_still is not None and near_still is not None:
            weight = (moved[1] - far_still[1]) - (right.rest - near_still[1])
            what = f"the weight of {name!r} acts at its end instead of its center (twice the arm)"
            yield WrongDerivation("weight", what, 1.0, right.sample.M, right.rest + weight)
    light = right.rebuild(_with_body(mechanism, gone))
    if light is not None:
        what = f"the mass of {name!r} is missing"
        yield WrongDerivation("missing", what, 1.3, *light)
        weight = (particle[1] - still[1]) - (light[1] - absent[1])
        what = f"the weight of {name!r} is missing"
        yield WrongDerivation("missing", what, 1.1, right.sample.M, right.rest - weight)
        what = f"the sign of the weight of {name!r} is wrong"
        yield WrongDerivation("sign", what, 1.1, right.sample.M, right.rest - 2 * weight)


def _differ(M: Array, changed: Array) -> bool:
    """Whether two mass matrices differ by more than rounding."""
    return bool(np.abs(M - changed).max() > _FELT * np.abs(M).max())


def _with_body(mechanism: Mechanism, body: Body) -> Mechanism:
    bodies = tuple(body if present.name == body.name else present for present in mechanism.bodies)
    return replace(mechanism, bodies=bodies)


_MOST_CHOICES = 60
"""Largest number of choices of the eliminated velocities."""

_WORST_CONDITION = 1e8
"""A choice is dropped if its constraints have a larger condition number than this in a state."""


def mistake_constraints(right: RightEquations) -> Iterator[WrongDerivation]:
    """Yield equations without the forces of constraints, or with constraints used in T."""
    ties = right.derivation.ties
    for k, tie in enumerate(ties):
        what = f"the force of the constraint {tie.name} (its multiplier) is missing"
        yield WrongDerivation("missing", what, 1.2, right.sample.M, right.rest, released=(k,))
    if len(ties) > 1:
        what = "the forces of all constraints (the multipliers) are missing"
        every = tuple(range(len(ties)))
        yield WrongDerivation("missing", what, 1.1, right.sample.M, right.rest, released=every)
    if right.truth.mechanism.contacts or right.truth.mechanism.velocity_constraints:
        yield from _put_into_energy(right)


def _put_into_energy(right: RightEquations) -> Iterator[WrongDerivation]:
    """Yield the equations from Lagrange's operator on a T from which velocities are eliminated.

    With v_d = B v_i for the eliminated velocities d, they have the extra terms
    Σ p_d (dB_di/dt − ∂(B v)_d/∂q_i), where p = ∂T/∂v. These vanish for integrable constraints
    (Hamel, Theoretische Mechanik, 1949; Neimark & Fufaev, Dynamics of Nonholonomic Systems,
    ch. 3).
    """
    names = right.derivation.algebra.velocities
    if any(not name.endswith("'") for name in names):
        return
    J, changes = _find_slopes(right, names)
    v = np.stack([right.sample.values[name] for name in names], axis=-1)
    p = np.einsum("nij,nj->ni", right.sample.M, v)
    for chosen in islice(combinations(range(len(names)), J.shape[1]), _MOST_CHOICES):
        kept = [k for k in range(len(names)) if k not in chosen]
        surplus = _find_surplus(J, changes, v, p, list(chosen), kept)
        if surplus is None:
            continue
        rest = right.rest.copy()
        rest[:, kept] += surplus
        what = (
            "a constraint on velocities is substituted into T "
            f"({', '.join(names[k] for k in chosen)} eliminated before Lagrange's operator), which "
            "gives extra terms; use multipliers or virtual displacements instead"
        )
        yield WrongDerivation("constraint in T", what, 0.8, right.sample.M, rest)


def _find_slopes(right: RightEquations, names: Sequence[str]) -> tuple[Array, Array]:
    """Return J and ∂J/∂q_k, shape (n, m, nv) and (nv, n, m, nv)."""
    rows = [
        tie.second.linear(right.derivation.algebra.accelerations)[0]
        for tie in right.derivation.ties
    ]
    moving = {g.name for row in rows for entry in row for g in entry.generators()}
    J = right.sample.slopes
    changes = np.zeros((len(names), *J.shape))
    for k, name in enumerate(names):
        if name[:-1] in moving:
            changes[k] = right.stack([_differentiate(row, name[:-1]) for row in rows])
    return J, changes


def _differentiate(row: Sequence[Series], name: str) -> list[Series]:
    return [entry.diff(name) for entry in row]


def _find_surplus(
    J: Array, changes: Array, v: Array, p: Array, chosen: list[int], kept: list[int]
) -> Array | None:
    """Return the extra terms, shape (n, kept); None if the choice is not possible."""
    J_dependent = J[:, :, chosen]
    with np.errstate(all="ignore"):
        condition = np.linalg.cond(J_dependent)
    if not (condition < _WORST_CONDITION).all():
        return None
    B = -np.linalg.solve(J_dependent, J[:, :, kept])
    # D_k B, along the motion of each kept coordinate that the constraint allows
    along = np.stack(
        [
            -np.linalg.solve(J_dependent, change[:, :, kept] + change[:, :, chosen] @ B)
            for change in changes
        ]
    )
    ways = along[kept] + np.einsum("ndk,dnei->knei", B, along[chosen])
    rates = np.einsum("nk,kndi->ndi", v[:, kept], ways)
    slopes = np.einsum("nk,indk->ndi", v[:, kept], ways)
    return np.asarray(np.einsum("nd,ndi->ni", p[:, chosen], rates - slopes))


_SINGULAR = 1e-12


@final
class Hypotheses:
    """All hypotheses about a mechanism, with the accelerations that they lead to."""

    def __init__(self, truth: Truth) -> None:
        self._truth = truth
        self._sample = truth.sample

    @cached_property
    def _led(self) -> list[tuple[WrongDerivation, Array]]:
        """Every hypothesis that determines a motion other than the right one, with that motion."""
        if self._truth.derivation is None:
            return []
        right = RightEquations(self._truth, self._truth.derivation)
        hypotheses = [
            *mistake_terms(right),
            *mistake_letters(right),
            *mistake_operator(right),
            *mistake_readings(right),
            *mistake_parts(right),
        ]
        if self._truth.mechanism.constrained:
            hypotheses += mistake_constraints(right)
        else:
            hypotheses += [*mistake_angles(right), *linearize(right)]
        led = ((hypothesis, self._lead(hypothesis)) for hypothesis in hypotheses)
        return [(hypothesis, motion) for hypothesis, motion in led if motion is not None]

    @property
    def listed(self) -> tuple[WrongDerivation, ...]:
        """Every hypothesis whose equations determine the motion and differ from the right ones."""
        return tuple(hypothesis for hypothesis, _ in self._led)

    @cached_property
    def motions(self) -> Array:
        """The accelerations and multipliers of each hypothesis, shape (hypotheses, n, nv + m)."""
        motions = [motion for _, motion in self._led]
        return np.stack(motions) if motions else np.zeros((0, *self._sample.motion.shape))

    def _lead(self, hypothesis: WrongDerivation) -> Array | None:
        """Return a hypothesis's accelerations and multipliers, None if undetermined."""
        sample = self._sample
        if not (np.isfinite(hypothesis.M).all() and np.isfinite(hypothesis.rest).all()):
            return None
        scale = np.abs(sample.M).max((1, 2)) ** sample.M.shape[-1]
        alone = np.abs(np.linalg.det(hypothesis.M)) > _SINGULAR * scale
        if not (alone.all() or sample.slopes.shape[1]):
            return None
        J = sample.slopes
        if hypothesis.released:
            J = J.copy()
            J[:, list(hypothesis.released)] = 0.0
        right_side = -np.einsum("nmv,nv->nm", J, sample.a)
        a, multipliers = accelerate(hypothesis.M, -hypothesis.rest, J, right_side)
        if not (np.abs(a - sample.a) > 1e-7 * np.abs(sample.a)).any():
            return None
        return np.concatenate([a, multipliers], axis=1)
