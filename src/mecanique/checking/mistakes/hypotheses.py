"""A mistake with the equations it leads to, and the right equations that it changes."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property, lru_cache, partial
from itertools import combinations, islice, permutations
from operator import mul
from typing import Any, NamedTuple, TypeAlias, final

import numpy as np

from mecanique.arrays import Array
from mecanique.checking.budget import stop_clock
from mecanique.checking.judgement.quantities import roll
from mecanique.checking.judgement.truth import Sample, SeriesValues, Truth, accelerate
from mecanique.checking.verdict import Mistake
from mecanique.derivation.printing.equations import expression
from mecanique.derivation.scalars.polynomials import exponents
from mecanique.derivation.scalars.series import Kind, Series
from mecanique.derivation.symbolic.derivation import Derivation, mass_and_bias
from mecanique.derivation.symbolic.lagrange import Lagrange
from mecanique.errors import MecaniqueError
from mecanique.model.bodies.body import Body, Shape
from mecanique.model.expression import plain
from mecanique.model.force_base import AnyForce
from mecanique.model.forces import JointSpring, Spring
from mecanique.model.mechanism import Mechanism
from mecanique.model.mechanism.description import angles
from mecanique.model.parameters import Parameter

Reading: TypeAlias = "Callable[[Mapping[str, Array]], dict[str, Array]]"
"""What letters are taken for, by the letters."""


ALIKE = 1e-6
"""Two values in a state are equal if they differ by less than this part."""

SIMPLE = 60
"""Factors with a denominator up to this are written as fractions."""

MOST_TIMES = 6
"""Slips have factors with a numerator and a denominator up to this, or their squares."""


@final
@dataclass(frozen=True, eq=False)
class EquationValues:
    """The equations M a + rest = 0 in the states, with the energies there."""

    M: Array  # mass matrix, shape (n, nv, nv)
    rest: Array  # bias minus forces, shape (n, nv)
    T: Array  # shape (n,)
    V: Array  # there and in moved states, shape (2, n)

    def plus(self, other: EquationValues, factor: float = 1.0) -> EquationValues:
        """Return the terms with a multiple of others."""
        pairs = zip(self._parts, other._parts, strict=True)
        return EquationValues(*(mine + factor * further for mine, further in pairs))

    @property
    def _parts(self) -> tuple[Array, ...]:
        return self.M, self.rest, self.T, self.V


@final
@dataclass(frozen=True, eq=False)
class WrongDerivation:
    """A mistake in the whole derivation or in one term, with the equations it leads to."""

    kind: str
    text: str  # the mistake in words; "{}" stands for the term
    weight: float  # the smaller, the likelier
    terms: EquationValues
    row: int = -1  # index of the changed equation; −1 for all
    term: Series | None = None  # the changed term, if there is only one
    released: tuple[int, ...] = ()  # indices of the constraints whose forces are left out

    def mistake(self, more: float = 0.0, equation: int = 0) -> Mistake:
        """Return the mistake in words, with a weight that is larger by so much."""
        text = self.text.format("" if self.term is None else expression(self.term).text())
        return Mistake(self.kind, text, weight=self.weight + more, equation=equation)


@final
@dataclass(frozen=True, eq=False)
class Share:
    """What of the equations is in proportion to one property of a part, or to a force."""

    said: str  # the property in words
    terms: EquationValues  # what of the right equations it makes up
    length: str = ""  # a length to a power of which they are in proportion, too
    power: int = 2

    def say(self, factor: float) -> Mistake | None:
        """Return that the property is so many times too large, None if that is no simple number."""
        ratio = Fraction(factor).limit_denominator(MOST_TIMES**2)
        root = Fraction(abs(factor) ** 0.5).limit_denominator(MOST_TIMES)
        simple = max(ratio.numerator, ratio.denominator) <= MOST_TIMES or root * root == ratio
        if ratio <= 0 or ratio == 1 or abs(factor / ratio - 1) > ALIKE or not simple:
            return None
        what, weight = f"{self.said} is {_say_times(ratio)} what it should be", 1.6
        if Fraction(1, 2) <= ratio <= 2 or (self.length and root * root == ratio):
            weight = 1.38
        if self.length and self.power == 1:
            what = f"{self.said}, or {self.length}, is {_say_times(ratio)} what it should be"
        elif self.length and root * root == ratio:
            what += f", or {self.length} {_say_times(root)} what it should be"
        return Mistake("factor", what, weight=weight)


def _say_times(ratio: Fraction) -> str:
    known = {Fraction(2): "twice", Fraction(1, 2): "half of"}
    return known.get(ratio, f"{ratio} {'times' if ratio > 1 else 'of'}")


@final
class RightEquations:
    """The right equations in the states, and those of changed mechanisms."""

    # With loops or contacts they are those of the tree, without multipliers.

    def __init__(self, truth: Truth, derivation: Derivation) -> None:
        self.truth = truth
        self.derivation = derivation
        self.sample: Sample = truth.sample
        self.lagrange = Lagrange(truth.mechanism, derivation.algebra)
        self.V = self.lagrange.V
        rest = self.sample.bias - self.sample.forces
        whole = self.evaluate(derivation, self.lagrange)
        self.terms = replace(whole, M=self.sample.M, rest=rest)

    @cached_property
    def value(self) -> SeriesValues:
        """Gives the values of series in the states."""
        return self.truth.at({})

    def with_rest(self, rest: Array) -> EquationValues:
        """Return the right terms with another rest."""
        return replace(self.terms, rest=rest)

    def rebuild(self, mechanism: Mechanism) -> EquationValues | None:
        """Return the terms of a changed mechanism in the same states."""
        derived = _derive_tree(mechanism)
        if derived is None or derived[0].algebra.velocities != self.truth.velocities:
            return None
        return self.evaluate(*derived)

    def split(self, mechanism: Mechanism) -> tuple[EquationValues, EquationValues] | None:
        """Return the terms of a changed mechanism without gravity, and those that it adds."""
        whole = self.rebuild(mechanism)
        still = self.rebuild(replace(mechanism, gravity=(0.0, 0.0, 0.0)))
        return (still, whole.plus(still, -1)) if whole and still else None

    def reread(self, read: Reading) -> EquationValues:
        """Return the right equations with letters taken for others."""
        return self.evaluate(self.derivation, self.lagrange, read)

    def evaluate(
        self, derivation: Derivation, lagrange: Lagrange, read: Reading | None = None
    ) -> EquationValues:
        """Return the terms of a derivation in the states, or with letters taken for others."""
        with np.errstate(all="ignore"):
            here, moved = (
                SeriesValues(
                    derivation,
                    {**values, **(read(values) if read else {})},
                    self.sample.count,
                )
                for values in (self.sample.values, roll(self.truth, self.sample))
            )
            V = np.stack([here(lagrange.V), moved(lagrange.V)])
            return EquationValues(here.M, here.rest, here(lagrange.T), V)


@lru_cache(maxsize=256)
def _derive_tree(mechanism: Mechanism) -> tuple[Derivation, Lagrange] | None:
    """Return the derivation of a mechanism without its constraints, and its energies."""
    # the same changes are evaluated in several positions
    try:
        lagrange = Lagrange(replace(mechanism, loops=(), contacts=()))
        return lagrange.derivation(), lagrange
    except MecaniqueError:
        return None


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


MULTIPLES = (
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
        for factor, kind, words in MULTIPLES:
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
        inertial = group_by_velocities(h, velocities).items()
        acting = group_by_velocities(-Q, velocities).values()
        groups = [(group, _name(powers), (1.0, 2.0)) for powers, group in inertial]
        groups += [(group, "the force", (1.2, 1.5)) for group in acting]
        for group, name, (of_all, of_part) in groups:
            yield _Term(row, group, -1, name, of_all)
            for part in _split(group):
                yield _Term(row, part, -1, name, of_part)


def _change(
    right: RightEquations,
    term: _Term,
    factor: float | Array,
    kind: str,
    text: str,
    weight: float,
) -> WrongDerivation:
    """Return the equations with a term mistakenly multiplied by a factor."""
    M, rest, shown = right.terms.M, right.terms.rest, term.series
    change = (factor - 1) * right.value(term.series)
    if term.column >= 0:
        M = M.copy()
        M[:, term.row, term.column] += change
        ring = right.derivation.algebra.ring
        shown = term.series * ring[right.truth.accelerations[term.column]]
    else:
        rest = rest.copy()
        rest[:, term.row] += change
    terms = replace(right.terms, M=M, rest=rest)
    return WrongDerivation(kind, text, weight, terms, term.row, shown)


def list_parts(series: Series, velocities: Sequence[str]) -> list[Series]:
    """Return parts of a series: by powers of velocities, by parameters, and single terms."""
    single = series.split()
    if len(single) > _MOST_SINGLE:
        return []
    parts = list(group_by_velocities(series, velocities).values())
    for letter in (g for g in series.generators() if g.kind is Kind.PARAMETER):
        parts.append(series.ring.sum([part for part in single if letter in part.generators()]))
    return [part for part in dict.fromkeys([*parts, *_split(series), *single]) if part != series]


def _split(series: Series) -> list[Series]:
    """Return parts of a series: its terms, and those that share letters, or sine and cosine."""
    terms, single = list(series.terms()), series.split()
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
                groups[frozenset(places)] = ring.sum([single[place] for place in places])
    return list(groups.values())


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
    rest = right.terms.rest
    rows = []
    for k, entries in enumerate(derivation.M):
        terms = [entry.ddt() * rate for entry, rate in zip(entries, v, strict=True)]
        rows.append((k, ring.sum(terms)))
    changing = right.value.stack([series for _, series in rows])
    squares = _collect_quadratic(right, derivation.h, names)
    slopes = changing - squares
    text = "a rate is treated as constant: d/dt of the momentum lacks {}"
    for k, series in rows:
        if series:
            at = np.eye(len(rows))[k]
            less = right.with_rest(rest - changing * at)
            yield WrongDerivation("rate constant", text, 1.4, less, row=k, term=series)
            what = f"the term −∂T/∂{names[k][:-1]} is missing (centripetal)"
            yield WrongDerivation("missing", what, 1.3, right.with_rest(rest + slopes * at), row=k)
    what = "all terms with squares and products of velocities are missing"
    yield WrongDerivation("missing", what, 1.2, right.with_rest(rest - squares))
    what = "every rate is treated as constant in d/dt of the momenta"
    yield WrongDerivation("rate constant", what, 1.3, right.with_rest(rest - changing))
    what = "the terms −∂T/∂q are missing (centripetal)"
    yield WrongDerivation("missing", what, 1.3, right.with_rest(rest + slopes))


_MOST_VELOCITIES = 3
"""With more velocities no component of a body's velocity is left out in turn."""


def mistake_velocities(right: RightEquations) -> Iterator[WrongDerivation]:
    """Yield equations that lack a part of a body's velocity in T, or the products of rates."""
    algebra, kinematics = right.derivation.algebra, right.lagrange.kinematics
    bodies = [body for body in right.truth.mechanism.bodies if plain(body.mass) != 0]
    quasi = any(not name.endswith("'") for name in algebra.velocities)
    if quasi or len(algebra.velocities) > _MOST_VELOCITIES:
        return
    ring, M = algebra.ring, right.derivation.M
    lacking = list[tuple[float, str, Series]]()
    for body in bodies:
        velocity = kinematics.velocity(body.name, body.center)
        parts = [(axis, speed) for axis, speed in zip("xyz", velocity, strict=True) if speed]
        for axis, speed in parts if parts[1:] else ():
            what = f"the {axis} component of the velocity of {body.name!r} is missing in T"
            lacking.append((1.05, what, speed * speed * algebra.series(body.mass) / 2))
    for joint in right.truth.mechanism.tree:
        if kinematics.carrier(joint.child) != kinematics.carrier(joint.parent):
            continue
        spins = kinematics.spin(joint.child), kinematics.spin(joint.parent)
        moments = right.truth.mechanism.body(joint.child).inertia[:3]
        # about a common direction the moments of inertia stay what they are
        if any(spins[1]) and sum(any(both) for both in zip(*spins, strict=True)) == 1:
            what = f"the rotation of {joint.child!r} is taken relative to {joint.parent!r} in T"
            surplus = [
                algebra.series(I) * (w * w - (w - w0) * (w - w0))
                for I, w, w0 in zip(moments, *spins, strict=True)
            ]
            lacking.append((1.05, what, ring.sum(surplus) / 2))
    v = [ring[name] for name in algebra.velocities]
    for text, _, rates, dots in list_relative(right.truth):
        if dots == ("'",):
            w = [ring.sum([*map(mul, row.tolist(), v)]) for row in rates]
            terms = [
                M[i][j] * (v[i] * v[j] - w[i] * w[j]) for i in range(len(v)) for j in range(len(v))
            ]
            lacking.append((1.3, f"{text} in T", ring.sum(terms) / 2))
    pairs = combinations(range(len(v)), 2)
    products = ring.sum([M[i][j] * v[i] * v[j] for i, j in pairs])
    if products:
        what = "the coupling is missing: T lacks its products of different rates"
        lacking.append((1.2, what, products))
    for weight, what, T in lacking:
        less_M, h = mass_and_bias(algebra, [row.value for row in ring.euler(T)])
        dM = np.stack([right.value.stack(row) for row in less_M], axis=1)
        rest, V = right.value.stack(h), np.zeros_like(right.terms.V)
        less = EquationValues(dM, rest, right.value(T), V)
        yield WrongDerivation("missing", what, weight, right.terms.plus(less, -1))


def _collect_quadratic(right: RightEquations, h: Sequence[Series], names: Sequence[str]) -> Array:
    """Return the terms of second degree in the velocities, shape (n, nv)."""
    rows = []
    for series in h:
        groups = group_by_velocities(series, names)
        squares = [part for powers, part in groups.items() if sum(powers) == 2]
        rows.append(series.ring.sum(squares))
    return right.value.stack(rows)


def mistake_readings(right: RightEquations) -> Iterator[WrongDerivation]:
    """Yield equations with a parameter zero, or with two of the same unit exchanged throughout."""
    mechanism = right.truth.mechanism
    used = {g.name for row in right.derivation.rows for g in row.generators()}
    if "t" in used:
        what = "what changes with the time t is taken as it is at t = 0"
        start = {"t": np.zeros(right.sample.count)}
        yield WrongDerivation("time dependence", what, 1.4, right.reread(lambda _: start))
    parameters = [p for p in mechanism.parameters if p.symbol in used]
    for p in parameters:
        what = say_zero(p)
        terms = right.reread(partial(_stop, (p.symbol,)))
        yield WrongDerivation("missing", what, 1.65, terms)
    for p in parameters:
        for factor, what in _list_scales(p).items():
            terms = right.reread(partial(_scale_letter, p.symbol, factor))
            yield WrongDerivation("letter", what.format(p.symbol), 1.75, terms)
    for first, second in permutations(parameters, 2):
        if first.unit != second.unit:
            continue
        one_way, both = {first.symbol: second.symbol}, {second.symbol: first.symbol}
        what = f"{second.symbol} is written for {first.symbol} throughout"
        terms = right.reread(partial(_rename_letters, one_way))
        yield WrongDerivation("letter", what, 1.5, terms)
        if first.symbol < second.symbol:
            what = f"{first.symbol} and {second.symbol} are exchanged throughout"
            terms = right.reread(partial(_rename_letters, one_way | both))
            yield WrongDerivation("letter", what, 1.5, terms)


_FOR_RADIUS = {
    2.0: "the diameter stands for the radius {} throughout",
    0.5: "{} is taken for a diameter and halved throughout",
}
_PER_TURN = {
    2 * np.pi: "{} is taken per radian instead of per turn",
    1 / (2 * np.pi): "{} is taken per turn instead of per radian",
}
"""What radii, and what counts turns, are mistakenly multiplied by throughout."""


def _list_scales(parameter: Parameter) -> dict[float, str]:
    """Return the factors by which a parameter is mistaken, with the mistakes in words."""
    if "radius" in parameter.meaning:
        return _FOR_RADIUS
    return _PER_TURN if parameter.unit in ("m/rad", "rad/s") else {}


def _scale_letter(name: str, factor: float, values: Mapping[str, Array]) -> dict[str, Array]:
    return {name: factor * values[name]}


def say_zero(parameter: Parameter) -> str:
    """Return that a parameter is taken as zero, in words."""
    meaning = f" ({parameter.meaning})" if parameter.meaning else ""
    return f"{parameter.symbol} is taken as zero{meaning}"


def _rename_letters(names: Mapping[str, str], values: Mapping[str, Array]) -> dict[str, Array]:
    return {name: values[other] for name, other in names.items()}


def mistake_angles(right: RightEquations) -> Iterator[WrongDerivation]:
    """Yield equations with absolute coordinates for relative ones, and vice versa."""
    weightless = _derive_tree(replace(right.truth.mechanism, gravity=(0.0, 0.0, 0.0)))
    for text, read, rates, dots in list_relative(right.truth):
        if len(dots) > 1:
            terms = right.reread(read)
            # their accelerations are ours after the same change
            yield WrongDerivation("angle", text, 1.4, replace(terms, M=terms.M @ rates))
            if weightless is not None:
                weights = terms.plus(right.evaluate(*weightless, read), -1)
                weights = replace(weights, rest=weights.rest @ rates)
                wrong = right.evaluate(*weightless).plus(weights)
                yield WrongDerivation("angle", f"{text} in the potential of gravity", 1.45, wrong)


def list_relative(truth: Truth) -> Iterator[tuple[str, Reading, Array, tuple[str, ...]]]:
    """Yield absolute coordinates for relative ones, and vice versa, or their rates alone.

    Each has its words, the letters it reads, its rates by ours, and the dots of these letters.
    """
    names = [v.removesuffix("'") for v in truth.velocities if v.endswith("'")]
    if 2 < len(names) == len(truth.velocities):
        sums, differences = np.tri(len(names)), np.eye(len(names)) - np.eye(len(names), k=-1)
        for rates, said in (
            (differences, "absolute instead of relative to the one before"),
            (sums, "relative to the one before instead of absolute"),
        ):
            text = f"each of {', '.join(names)} is taken {said}"
            yield text, partial(_chain, names, rates), rates, ("", "'")
    for base, other in permutations(names, 2):
        for sign in (-1, 1):
            ways = ("relative to", "absolute") if sign > 0 else ("absolute", "relative to")
            places = [truth.velocities.index(f"{name}'") for name in (other, base)]
            turn = np.eye(len(truth.velocities))
            turn[places[0], places[1]] = sign
            for dots, said in ((("", "'"), ""), (("'",), "the rate of "), (("",), "")):
                text = f"{said}{other} is taken {ways[0]} instead of {ways[1]}"
                text = text.replace("relative to", f"relative to {base}")
                rates = turn if "'" in dots else np.eye(len(turn))
                yield text, partial(_add_letters, other, base, sign, dots), rates, dots


def _chain(names: Sequence[str], rates: Array, values: Mapping[str, Array]) -> dict[str, Array]:
    """Return combinations of coordinates and of their rates."""
    read = dict[str, Array]()
    for dots in ("", "'"):
        dotted = [f"{name}{dots}" for name in names]
        read |= zip(dotted, rates @ np.array([values[name] for name in dotted]), strict=True)
    return read


def _add_letters(
    name: str, base: str, sign: int, dots: Sequence[str], values: Mapping[str, Array]
) -> dict[str, Array]:
    """Return a coordinate and its rate, as dots say, with those of another added."""
    return {f"{name}{d}": values[f"{name}{d}"] + sign * values[f"{base}{d}"] for d in dots}


def linearize(right: RightEquations) -> Iterator[WrongDerivation]:
    """Yield the equations linearized about all coordinates zero, if that is an equilibrium."""
    forces, values = right.truth.rest_forces, right.sample.values
    names = (*right.truth.velocities, *right.truth.mechanism.coordinates)
    at_rest = right.truth.at(dict.fromkeys(names, 0.0))
    with np.errstate(all="ignore"):
        M, moved = at_rest.M, np.stack([values[name] for name in names], axis=-1)
        slopes = np.einsum("nij,nj->ni", at_rest.slopes(forces, names), moved)
        rest = at_rest.stack(forces) + slopes
        places, V = tuple(right.truth.mechanism.coordinates), right.terms.V.copy()
        T = at_rest(right.lagrange.T) + _expand(right.lagrange.T, names, at_rest, moved)
        for k, states in enumerate((values, roll(right.truth, right.sample))):
            q = np.stack([{**values, **states}[name] for name in places], axis=-1)
            V[k] = _expand(right.V, places, at_rest, q)
    turning = angles(right.truth.mechanism)
    small = "angles" if turning else "displacements"
    what = f"small {small} are assumed throughout: it is the linearized equation"
    weight = 0.5 if turning else 1.15
    yield WrongDerivation("linearized", what, weight, EquationValues(M, rest, T, V))


def _expand(series: Series, names: Sequence[str], at_rest: SeriesValues, moved: Array) -> Array:
    """Return the terms of first and second degree in letters (n, k) of an energy, shape (n,)."""
    slope = at_rest.slopes([series], names)[:, 0]
    curvature = at_rest.slopes([series.diff(name) for name in names], names)
    second = np.einsum("nij,ni,nj->n", curvature, moved, moved) / 2
    return np.asarray(np.einsum("ni,ni->n", slope, moved) + second)


_FELT = 1e-12
"""A change of M below this part of it is rounding: the moments of inertia do not matter."""
NO_INERTIA = (0.0,) * 6
_MOST_PIECES = 3
MOST_BODIES = 7
"""With more bodies in loops, deriving each change again would take seconds."""


def mistake_parts(right: RightEquations) -> Iterator[WrongDerivation]:
    """Yield equations with wrong inertia, weight or spring of a single part."""
    mechanism = right.truth.mechanism
    if mechanism.constrained and len(mechanism.bodies) > MOST_BODIES:
        return
    if (own := right.split(mechanism)) is not None:
        still, gravity = own
        T, V = "the kinetic energy", "the potential energy"
        for factor, kind, how_likely, what in (
            (-1.0, "potential sign", 0.9, "the sign of the potential of gravity is wrong"),
            (0.0, "missing", 1.0, "gravity is missing"),
            (0.5, "half", 1.1, f"{T} lacks its factor ½, or {V} has an extra ½"),
            (2.0, "half", 1.1, f"{T} has an extra factor ½, or {V} is counted twice"),
        ):
            yield WrongDerivation(kind, what, how_likely, still.plus(gravity, factor))
        alike: dict[tuple[str, float, str], list[tuple[str, EquationValues]]] = {}
        for piece in list_pieces(mechanism):
            for kind, weight, words, wrong in _piece(right, mechanism, piece, still):
                yield WrongDerivation(kind, words.format(piece.said), weight, wrong)
                alike.setdefault((kind, weight, words), []).append((piece.said, wrong))
        for (kind, weight, words), several in alike.items():
            if several[1:]:
                # terms of bodies add up, and so do the mistakes in them
                whole = right.terms
                for _, wrong in several:
                    whole = whole.plus(wrong).plus(right.terms, -1)
                *names, last = [name for name, _ in several]
                each = f"each of {', '.join(names)} and {last}"
                yield WrongDerivation(kind, words.format(each), weight + 0.05, whole)
    for force in mechanism.forces:
        others = tuple(present for present in mechanism.forces if present is not force)
        less = right.rebuild(replace(mechanism, forces=others))
        if less is not None:
            acting = right.terms.plus(less, -1)
            for factor, kind, words in MULTIPLES:
                what = words.format(f"the force {force.name!r}")
                if factor == 0.5:
                    what += " (an extra factor ½)"
                weight = 1.2 + 0.3 * (kind == "factor")
                yield WrongDerivation(kind, what, weight, less.plus(acting, factor))
        if not mechanism.constrained and len(right.truth.velocities) <= _MOST_VELOCITIES:
            yield from _hold_end(right, replace(mechanism, forces=others), force)
    yield from _forget_free_lengths(right, mechanism)


def _hold_end(
    right: RightEquations, without: Mechanism, force: AnyForce
) -> Iterator[WrongDerivation]:
    """Yield equations with a force between moving bodies as if a coordinate were zero."""
    derived = _derive_tree(without)
    if derived is None or derived[0].algebra.velocities != right.truth.velocities:
        return
    less = right.evaluate(*derived)
    felt = (np.abs(right.terms.rest - less.rest) > _FELT * np.abs(right.terms.rest)).any(axis=0)
    for k in np.flatnonzero(felt) if np.count_nonzero(felt) > 1 else ():
        velocity = right.truth.velocities[k]
        name = velocity.removesuffix("'")
        stop = partial(_stop, (name, velocity))
        acting = right.reread(stop).plus(right.evaluate(*derived, stop), -1)
        acting.rest[:, k] = 0.0
        what = f"the force {force.name!r} acts as if {name} were zero, not by its relative motion"
        yield WrongDerivation("relative", what, 1.15, less.plus(acting))


def _stop(names: Sequence[str], values: Mapping[str, Array]) -> dict[str, Array]:
    return {name: np.zeros_like(values[name]) for name in names}


def _forget_free_lengths(right: RightEquations, mechanism: Mechanism) -> Iterator[WrongDerivation]:
    """Yield equations with the free length of a spring, or of all, forgotten."""
    without = {force.name: _without_free_length(force) for force in mechanism.forces}
    felt = [force.name for force in mechanism.forces if without[force.name] != force]
    for names in [[name] for name in felt] + [felt] * (len(felt) > 1):
        forces = (without[f.name] if f.name in names else f for f in mechanism.forces)
        rebuilt = right.rebuild(replace(mechanism, forces=tuple(forces)))
        if rebuilt is not None:
            springs = "the springs" if names[1:] else f"the spring {names[0]!r}"
            what = f"the free length of {springs} is forgotten"
            yield WrongDerivation("free length", what, 0.8, rebuilt)


def _without_free_length(force: AnyForce) -> AnyForce:
    match force:
        case Spring():
            return replace(force, free_length=0.0)
        case JointSpring():
            return replace(force, reference=0.0)
    return force


class _Piece(NamedTuple):
    """A body, or one of the pieces that it is made of."""

    body: Body
    place: int  # index of its shape among those of the body
    said: str  # its name in words

    @property
    def shape(self) -> Shape:
        """Its mass, center and inertia."""
        return self.body.shapes[self.place]

    def put(self, mechanism: Mechanism, shape: Shape) -> Mechanism:
        """Return a mechanism with another shape in its place."""
        shapes = (*self.body.shapes[: self.place], shape, *self.body.shapes[self.place + 1 :])
        changed = Body(self.body.name, *shapes, as_given=self.body.as_given)
        bodies = (changed if b.name == changed.name else b for b in mechanism.bodies)
        return replace(mechanism, bodies=tuple(bodies))


def list_pieces(mechanism: Mechanism) -> list[_Piece]:
    """Return the bodies, those of a few pieces by their pieces."""
    pieces = []
    for body in mechanism.bodies:
        # what turns may be given a moment of inertia alone
        heavy = [k for k, s in enumerate(body.shapes) if any(map(plain, (s.mass, *s.inertia)))]
        if 1 < len(heavy) <= _MOST_PIECES:
            for k in heavy:
                shape = body.shapes[k]
                said = f"the {shape.form or 'piece'} {shape.mass} of {body.name!r}"
                pieces.append(_Piece(body, k, said))
        elif heavy[1:]:
            pieces.append(_Piece(body.replace(), 0, repr(body.name)))
        elif heavy:
            pieces.append(_Piece(body, heavy[0], repr(body.name)))
    return pieces


def _piece(
    right: RightEquations, mechanism: Mechanism, piece: _Piece, still: EquationValues
) -> Iterator[tuple[str, float, str, EquationValues]]:
    """Yield mistakes about a piece, "{}": inertia about center or joint, Steiner's term, weight."""
    shape = piece.shape
    point = replace(shape, inertia=NO_INERTIA)
    bare = right.split(piece.put(mechanism, point))
    gone = right.split(piece.put(mechanism, replace(point, mass=0.0)))
    if bare is None or gone is None:
        return
    terms = right.terms
    particle = bare[0].plus(bare[1])
    # the inertia forces of its mass at its center
    moving, weight = (
        with_mass.plus(without, -1) for with_mass, without in zip(bare, gone, strict=True)
    )
    unmoved = "the inertia of the motion of the center of {} is missing"
    mistakes = [
        ("missing", 1.3, "the mass of {} is missing", gone[0].plus(gone[1])),
        ("missing", 1.1, "the weight of {} is missing", terms.plus(weight, -1)),
        ("sign", 1.1, "the sign of the weight of {} is wrong", terms.plus(weight, -2)),
    ]
    # the moments of inertia of a body that only slides do not matter
    if _differ(terms.M, particle.M):
        own = "the inertia of {} about its own center"
        about = "the inertia of {} is taken about its center (Steiner's term is missing)"
        steiner = (
            "Steiner's term of {} is counted twice: inertia about the joint and the motion "
            "of the center"
        )
        # each change of a closed mechanism takes long to derive
        turning = None if mechanism.loops else _turn_about_joint(right, mechanism, piece)
        # what is dropped of a body whose center is in its joint may as well be a term
        likely = 0.8 if turning else 1.15
        kind = "parallel axis" if turning or mechanism.loops else "missing"
        about = about if kind != "missing" else unmoved
        turning = turning or moving
        mistakes += [
            ("inertia", 1.0, f"{own} is missing (as for a particle)", particle),
            # a named body says more than a term that "should be 4/5 times as large"
            ("inertia", 1.3, f"{own} is counted twice", terms.plus(terms.plus(particle, -1))),
            (kind, likely, about, terms.plus(turning, -1)),
            ("parallel axis", likely + 0.1, steiner, terms.plus(turning)),
        ]
        usual = _ROUND.get(shape.form)
        for form, factor in _ROUND.items():
            if usual and factor != usual:
                spun = particle.plus(terms.plus(particle, -1), factor / usual)
                mistakes.append(("inertia", 1.25, f"the inertia of {{}} is that of a {form}", spun))
        if shape.form == "slender rod" and turning is not moving:
            # m l²/4 is Steiner's term, and as much is left of m l²/2: three times its own
            for more, said in ((2.0, "disk, m l²/2"), (0.8, "ball, 2 m l²/5")):
                words = f"the inertia of {{}} about the joint is that of a {said}"
                wrong = terms.plus(terms.plus(particle, -1), more)
                mistakes.append(("inertia", 1.25, words, wrong))
        if (sphere := _even_out(shape)) is not None:
            # ∫x² dm is half of the sum of all three moments less that about x
            even = right.rebuild(piece.put(mechanism, sphere))
            what = "the moments of inertia of {} take the lengths along their axes, not across them"
            second = even and even.plus(terms, -1).plus(particle)
            mistakes += [("inertia", 1.2, what, second)] if second else []
        if any(plain(x) for x in shape.center):
            mistakes += _at_end(right, mechanism, piece, (particle, still))
    else:
        mistakes.append(("missing", 1.15, unmoved, terms.plus(moving, -1)))
        if shape.form == "particle" and not mechanism.constrained:
            mistakes += _as_body(right, mechanism, piece)
    yield from mistakes


_ROUND = {"thin ring": 1.0, "thin disk": 0.5, "solid ball": 0.4}
"""Moments of inertia about their axes that are mistaken for each other, of m r²."""


def list_shares(right: RightEquations) -> Iterator[Share]:
    """Yield what each mass, moment of inertia, weight and force makes up of the equations."""
    mechanism, terms = right.truth.mechanism, right.terms
    if mechanism.constrained and len(mechanism.bodies) > MOST_BODIES:
        return
    for piece in list_pieces(mechanism):
        shape, name = piece.shape, piece.said
        point = replace(shape, inertia=NO_INERTIA)
        bare = right.split(piece.put(mechanism, point))
        gone = right.split(piece.put(mechanism, replace(point, mass=0.0)))
        if bare is None or gone is None:
            continue
        # of properties that would explain the same, the narrower one comes first
        spinning = terms.plus(bare[0].plus(bare[1]), -1)
        if _differ(terms.M, terms.plus(spinning, -1).M):
            yield from _split_by_axes(right, piece, spinning)
            yield Share(f"the inertia of {name} about its own center", spinning, "its size")
        if gone[0].M.any():  # of a single body, all are in proportion to it
            massive = terms.plus(gone[0].plus(gone[1]), -1)
            yield Share(f"the mass of {name}", massive, "its distance")
        weight = bare[1].plus(gone[1], -1)
        yield Share(f"the weight of {name}", weight, "the distance of its center", power=1)
    for force in mechanism.forces:
        others = tuple(present for present in mechanism.forces if present is not force)
        without = right.rebuild(replace(mechanism, forces=others))
        if without is not None:
            yield Share(f"the force {force.name!r}", terms.plus(without, -1), "its lever arm")


def _split_by_axes(
    right: RightEquations, piece: _Piece, spinning: EquationValues
) -> Iterator[Share]:
    """Yield the moments of inertia about an axis of symmetry and across it, if both matter."""
    flat, terms = _flatten(piece.shape), right.terms
    less = right.rebuild(piece.put(right.truth.mechanism, flat)) if flat else None
    if less is None:
        return
    along = terms.plus(less, -1)
    across = spinning.plus(along, -1)
    if _differ(terms.M, less.M) and _differ(terms.M, terms.plus(across, -1).M):
        moment = f"the moment of inertia of {piece.said} about"
        yield Share(f"{moment} its axis of symmetry", along)
        yield Share(f"{moment} the axes across that of symmetry", across)


def _flatten(shape: Shape) -> Shape | None:
    """Return a shape without its moment of inertia about its axis, None if it has no such axis."""
    x, y, z, *products = shape.inertia
    if any(map(plain, products)):
        return None
    for k, (along, a, b) in enumerate(((x, y, z), (y, z, x), (z, x, y))):
        if plain(along) and plain(along) != plain(a) == plain(b):
            moments = [0.0 if n == k else a for n in range(3)]
            return replace(shape, inertia=(moments[0], moments[1], moments[2], 0.0, 0.0, 0.0))
    return None


def _even_out(shape: Shape) -> Shape | None:
    """Return a shape with half the sum of its moments about each axis, None if two are alike."""
    moments = shape.inertia[:3]
    if len({*map(plain, moments)}) < len(moments):
        return None
    half = sum(moments) / 2
    return replace(shape, inertia=(half, half, half, 0.0, 0.0, 0.0))


_BODIES = {
    1 / 3: (1.25, "of a rod about its end, m l²/3"),
    1 / 12: (1.25, "of a rod about its center, m l²/12"),
    1 / 2: (1.45, "of a disk, m l²/2"),
    2 / 5: (1.25, "of a ball, 2 m l²/5"),
    4 / 3: (1.25, "of a rod twice as long about its end, 4 m l²/3"),
}
"""Shares of m l² that are mistaken for the inertia of a particle about its joint."""


def _as_body(
    right: RightEquations, mechanism: Mechanism, piece: _Piece
) -> Iterator[tuple[str, float, str, EquationValues]]:
    """Yield a particle away from its joint with the inertia of a body, or as a rod."""
    turning = _turn_about_joint(right, mechanism, piece)
    if turning is None:
        return
    for share, (weight, said) in _BODIES.items():
        what = f"the inertia of {{}}, a particle, is that {said}"
        yield "inertia", weight, what, right.terms.plus(turning, share - 1)
    x, y, z = piece.shape.center
    inertia = tuple(piece.shape.mass * square / 12 for square in _square(piece.shape))
    rod = replace(piece.shape, center=(x / 2, y / 2, z / 2), inertia=inertia)
    if (terms := right.rebuild(piece.put(mechanism, rod))) is not None:
        what = "{}, a particle, is taken for a uniform rod from the joint to it"
        yield "inertia", 0.95, what, terms


def _square(shape: Shape) -> tuple[Any, ...]:
    """Return the moments and products of inertia about the joint of a unit mass at the center."""
    x, y, z = shape.center
    across = (y * y + z * z, x * x + z * z, x * x + y * y)
    return (*across, -x * y, -x * z, -y * z)


def _turn_about_joint(
    right: RightEquations, mechanism: Mechanism, piece: _Piece
) -> EquationValues | None:
    """Return the terms of Steiner's part of the inertia about the joint, None if it is zero."""
    squares = _square(piece.shape)
    if not any(plain(entry) for entry in squares):
        return None
    pairs = zip(piece.shape.inertia, squares, strict=True)
    more = tuple(own + piece.shape.mass * square for own, square in pairs)
    changed = right.rebuild(piece.put(mechanism, replace(piece.shape, inertia=more)))
    # a center on the axis of its joint has no such part either
    felt = changed is not None and _differ(right.terms.M, changed.M)
    return changed.plus(right.terms, -1) if changed and felt else None


def _at_end(
    right: RightEquations,
    mechanism: Mechanism,
    piece: _Piece,
    known: tuple[EquationValues, EquationValues],
) -> Iterator[tuple[str, float, str, EquationValues]]:
    """Yield a piece with its mass, or with its weight alone, at its end."""
    particle, still = known
    above, below, said = (
        (4, 3, "") if piece.shape.form == "solid cone" else (2, 1, " (twice the arm)")
    )
    x, y, z = (above * x / below for x in piece.shape.center)
    far = replace(piece.shape, center=(x, y, z))
    point = right.rebuild(piece.put(mechanism, replace(far, inertia=NO_INERTIA)))
    # along the axis about which it turns, its end is no other place than its center
    if point is not None and _differ(point.M, particle.M):
        what = "{} is taken for a point mass at its end instead of a body with inertia"
        yield "point mass", 0.9, what, point
    there = right.split(piece.put(mechanism, far))
    if there is not None and point is not None and _differ(point.M, particle.M):
        inertia_alone = point.plus(there[1], -1).plus(right.terms).plus(still, -1)
        yield (
            "point mass",
            1.2,
            "the inertia of {} is that of a point mass at its end",
            inertia_alone,
        )
    if there is not None:
        what = f"the weight of {{}} acts at its end instead of its center{said}"
        yield "weight", 1.0, what, still.plus(there[1])


def _differ(terms: Array, changed: Array) -> bool:
    """Whether mass matrices or forces in the states differ by more than rounding."""
    return bool(np.abs(terms - changed).max() > _FELT * np.abs(terms).max())


_MOST_CHOICES = 60
"""Largest number of choices of the eliminated velocities."""

_WORST_CONDITION = 1e8
"""A choice is dropped if its constraints have a larger condition number than this in a state."""


def mistake_constraints(right: RightEquations) -> Iterator[WrongDerivation]:
    """Yield equations without the forces of constraints, or with constraints used in T."""
    ties = right.derivation.ties
    for k, tie in enumerate(ties):
        what = f"the force of the constraint {tie.name} (its multiplier) is missing"
        yield WrongDerivation("missing", what, 1.2, right.terms, released=(k,))
    if len(ties) > 1:
        what = "the forces of all constraints (the multipliers) are missing"
        every = tuple(range(len(ties)))
        yield WrongDerivation("missing", what, 1.1, right.terms, released=every)
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
    p = np.einsum("nij,nj->ni", right.terms.M, v)
    for chosen in islice(combinations(range(len(names)), J.shape[1]), _MOST_CHOICES):
        kept = [k for k in range(len(names)) if k not in chosen]
        surplus = _find_surplus(J, changes, v, p, list(chosen), kept)
        if surplus is None:
            continue
        rest = right.terms.rest.copy()
        rest[:, kept] += surplus
        what = (
            "a constraint on velocities is substituted into T "
            f"({', '.join(names[k] for k in chosen)} eliminated before Lagrange's operator), which "
            "gives extra terms; use multipliers or virtual displacements instead"
        )
        yield WrongDerivation("constraint in T", what, 0.8, right.with_rest(rest))


def _find_slopes(right: RightEquations, names: Sequence[str]) -> tuple[Array, Array]:
    """Return J and ∂J/∂q_k, shape (n, m, nv) and (nv, n, m, nv)."""
    rows = [
        tie.second.linear(right.derivation.algebra.accelerations)[0]
        for tie in right.derivation.ties
    ]
    coordinates = [name[:-1] for name in names]
    changes = np.stack([right.value.slopes(row, coordinates) for row in rows], axis=1)
    return right.sample.slopes, np.moveaxis(changes, 3, 0)


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


_PAIRED = ("inertia", "parallel axis", "point mass", "weight", "potential sign", "free length")
TWO_SLIPS = "two slips"
_MOST_PAIRED = 16
"""Two mistakes at once are sought among no more than these."""


def _move_unlike(wrong: EquationValues, right: EquationValues) -> bool:
    return _differ(right.M, wrong.M) or _differ(right.rest, wrong.rest)


def _pair(right: RightEquations, single: Sequence[WrongDerivation]) -> Iterator[WrongDerivation]:
    """Yield equations with two of some mistakes."""
    # beside another, one that changes nothing here says nothing
    pairable = [m for m in single if m.kind in _PAIRED and _move_unlike(m.terms, right.terms)]
    if len(pairable) > _MOST_PAIRED or right.truth.mechanism.constrained:
        return
    for first, second in combinations(pairable, 2):
        terms = first.terms.plus(second.terms).plus(right.terms, -1)
        weight = first.weight + second.weight + 0.2
        yield WrongDerivation(TWO_SLIPS, f"{first.text}; {second.text}", weight, terms)


_SINGULAR = 1e-12


@final
class Hypotheses:
    """All hypotheses about a mechanism, with the accelerations that they lead to."""

    def __init__(self, truth: Truth) -> None:
        self._truth = truth
        self._sample = truth.sample

    @cached_property
    def right(self) -> RightEquations:
        """The right equations."""
        return RightEquations(self._truth, self._truth.closed_form)

    @cached_property
    def pairs(self) -> list[tuple[WrongDerivation, Array]]:
        """Every hypothesis that determines a motion other than the right one, with that motion."""
        with stop_clock():
            led = ((hypothesis, self._lead(hypothesis)) for hypothesis in self.every)
            return [(hypothesis, motion) for hypothesis, motion in led if motion is not None]

    @cached_property
    def every(self) -> list[WrongDerivation]:
        """Every hypothesis, also those that change nothing in the states."""
        if self._truth.derivation is None:
            return []
        right = self.right
        parts = list(mistake_parts(right))
        hypotheses = [
            *mistake_terms(right),
            *mistake_letters(right),
            *mistake_operator(right),
            *mistake_readings(right),
            *parts,
            *_pair(right, parts),
        ]
        if self._truth.mechanism.constrained:
            hypotheses += mistake_constraints(right)
        else:
            hypotheses += [*mistake_angles(right), *linearize(right), *mistake_velocities(right)]
        return hypotheses

    @cached_property
    def shares(self) -> list[Share]:
        """What each property of the parts makes up of the equations."""
        with stop_clock():
            return [] if self._truth.derivation is None else list(list_shares(self.right))

    @property
    def listed(self) -> tuple[WrongDerivation, ...]:
        """Every hypothesis whose equations determine the motion and differ from the right ones."""
        return tuple(hypothesis for hypothesis, _ in self.pairs)

    @cached_property
    def motions(self) -> Array:
        """The accelerations and multipliers of each hypothesis, shape (hypotheses, n, nv + m)."""
        motions = [motion for _, motion in self.pairs]
        return np.stack(motions) if motions else np.zeros((0, *self._sample.motion.shape))

    def _lead(self, hypothesis: WrongDerivation) -> Array | None:
        """Return a hypothesis's accelerations and multipliers, None if undetermined."""
        sample, M, rest = self._sample, hypothesis.terms.M, hypothesis.terms.rest
        if not (np.isfinite(M).all() and np.isfinite(rest).all()):
            return None
        scale = np.abs(sample.M).max((1, 2)) ** sample.M.shape[-1]
        alone = np.abs(np.linalg.det(M)) > _SINGULAR * scale
        if not (alone.all() or sample.slopes.shape[1]):
            return None
        J = sample.slopes
        if hypothesis.released:
            J = J.copy()
            J[:, list(hypothesis.released)] = 0.0
        right_side = -np.einsum("nmv,nv->nm", J, sample.a)
        a, multipliers = accelerate(M, -rest, J, right_side)
        if not (np.abs(a - sample.a) > 1e-7 * np.abs(sample.a)).any():
            return None
        return np.concatenate([a, multipliers], axis=1)
