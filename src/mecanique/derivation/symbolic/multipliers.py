"""Solve constrained equations of motion in closed form: for multipliers, or without them.

The balance of each velocity k is Σ λ ∂Φ/∂q_k = (M a + h − Q)_k. A balance with a single unknown
multiplier gives that multiplier. From two balances with the same one it is eliminated by cross
multiplication, which avoids division by an expression that may vanish.

Independent virtual displacements δq = S δπ with A δq = 0 do without multipliers. Row by row, the
displacements allowed so far are combined so that they satisfy the next row (G. A. Maggi, Principii
della teoria matematica del movimento, 1896; Neimark & Fufaev, Dynamics of Nonholonomic Systems,
1972, ch. III). No divisor may vanish: a row needs a constant entry, or two whose squares add up to
a constant, such as −sin θ and cos θ. Rows without such entries are solved by Cramer's rule, with
all displacements multiplied by the determinant instead of divided.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import chain, combinations
from typing import TypeAlias, final

from mecanique.derivation.numeric.constraints.redundancy import find_redundancy
from mecanique.derivation.printing.equations import expression, shorter
from mecanique.derivation.printing.expressions import to_formula, to_power
from mecanique.derivation.printing.formulas import draw_number, multiply
from mecanique.derivation.printing.trigforms import common_monomial, common_scale
from mecanique.derivation.printing.writers import Equation, Expression
from mecanique.derivation.scalars.cancel import divide_by_wave, tidy
from mecanique.derivation.scalars.polynomials import exponents, power
from mecanique.derivation.scalars.series import GIVEN, TIMED, Kind, Ring, Series, canonical
from mecanique.derivation.symbolic.derivation import (
    LOOPS_IN_MOTION,
    Left,
    Matrix,
    Result,
    Stage,
    Tie,
    project,
)
from mecanique.derivation.symbolic.symbols import Algebra, coordinate_of
from mecanique.errors import DerivationError
from mecanique.model.mechanism import Mechanism
from mecanique.wording import enumerate_words

Column: TypeAlias = "list[Series]"
"""A part for each velocity."""

MULTIPLIERS = "Multipliers"
"""Title of the step that gives them by the accelerations."""

_LONGEST = 60
"""Balances and displacements with more terms are too long to be read."""

LONGEST_ABOVE = 40
"""Numerators with more terms are too long to be read."""

_WIDEST = 12
"""Denominators with more terms are too wide for a page, as no line breaks below a fraction bar."""


@final
@dataclass(frozen=True)
class Quotient:
    """A solved quantity, numerator/denominator."""

    above: Series
    below: Series  # the denominator, 1 if there is none; the result holds where it is not zero

    @property
    def bearable(self) -> bool:
        """Whether it is short enough to be read."""
        return len(self.above) <= LONGEST_ABOVE and len(self.below) <= _WIDEST

    @property
    def divided(self) -> bool:
        """Whether it is divided by what may vanish."""
        ring = self.above.ring
        powers = {item for _, monomial, _ in self.above.terms() for item in exponents(monomial)}
        below = {i for i, e in powers if e < 0}
        letters = [ring.generators[i].kind in GIVEN for i in below - ring.atoms.keys()]
        atoms = [ring.atoms[i] for i in below & ring.atoms.keys()]
        sums = [self.below, *(atom.argument for atom in atoms)]
        plain = all(atom.function in ("1", "sqrt") for atom in atoms)  # which vanish as sums do
        return not (plain and all(letters) and all(map(vanishes_nowhere, sums)))

    def expression(self) -> Expression:
        """Return it as printed, with a factored denominator."""
        if self.below == 1:
            return expression(self.above)
        under = to_power(to_formula(self.below), Fraction(-1))
        sums = draw_number(expression(self.above).terms)
        return shorter(self.fraction(), Expression((multiply(sums, under),)))

    def fraction(self) -> Expression:
        """Return it as one fraction, with factors put outside its sums."""
        above, waves, ring = self.above, [], self.above.ring
        for atom in ring.atoms.values():  # what was divided by may be a factor of the numerator
            wave = max(atom.argument.parts)
            while wave and len(atom.argument) == 1 and (rest := divide_by_wave(above, wave)):
                above = rest
                waves.append(to_formula(canonical(ring, {wave: {0: 1}}, 1, above.reach)))
        under = to_power(to_formula(self.below), Fraction(-1))
        return Expression((multiply(to_formula(above), *waves, under),))

    def equate(self, name: str) -> Equation:
        """Return the equation that states it, under its name."""
        left = expression(self.above.ring[name])
        return Equation(left, self.expression(), self.below)


def say_where(values: Iterable[Quotient]) -> str:
    """Say where solved quantities hold, "" if everywhere."""
    return " wherever no denominator is zero" if any(value.divided for value in values) else ""


@final
@dataclass(frozen=True)
class _Balance:
    """One balance: Σ factor × λ = rest."""

    factors: tuple[Series, ...]
    rest: Series
    given: _Balance | None = None  # before others were eliminated, if any was

    def unknown(self, known: Sequence[int]) -> list[int]:
        """Return the indices of its multipliers that are not known yet."""
        return [k for k, factor in enumerate(self.factors) if factor and k not in known]

    def move(self, unknowns: Sequence[Series], kept: Sequence[int]) -> Series:
        """Return its rest, less what the multipliers that are not kept have in it."""
        pairs = enumerate(zip(self.factors, unknowns, strict=True))
        others = [-factor * letter for k, (factor, letter) in pairs if factor and k not in kept]
        return tidy(self.rest.ring.sum([self.rest, *others]))

    def cost(self) -> int:
        """Return its length; constant factors cost less."""
        loose = sum(1 for factor in self.factors if factor and not is_constant(factor))
        return 10 * loose + len(self.rest) + sum(map(len, self.factors))


def solve_multipliers(
    unknowns: Sequence[Series], slopes: Sequence[Sequence[Series]], sides: Sequence[Series]
) -> dict[str, Quotient]:
    """Solve for multipliers, by name, one after another; return none if balances become long."""
    # the numerator of each may contain multipliers solved for before
    columns = zip(*slopes, strict=True)
    balances = [_Balance(tuple(c), side) for c, side in zip(columns, sides, strict=True)]
    order: list[int] = []
    solved: dict[str, Quotient] = {}
    held: dict[int, _Balance] = {}
    while len(order) + len(held) < len(unknowns):
        known = [*order, *held]
        usable = [equation for equation in balances if equation.unknown(known)]
        if not usable:
            return {}
        chosen = min(usable, key=lambda equation: (len(equation.unknown(known)), equation.cost()))
        balances.remove(chosen)
        if chosen.cost() > _LONGEST:
            return {}
        unknown = chosen.unknown(known)
        k = min(unknown, key=lambda k: (not is_constant(chosen.factors[k]), len(chosen.factors[k])))
        held[k] = chosen
        if len(unknown) > 1:
            balances = [_eliminate(equation, chosen, k) for equation in balances]
            continue
        block: dict[int, _Balance] = {}
        for k, balance in reversed(held.items()):
            if not balance.unknown([k, *order, *block]):
                block[k] = balance
        held = {k: balance for k, balance in held.items() if k not in block}
        solved |= _solve_block(unknowns, block, order)
        order += block
    return solved


def _solve_block(
    unknowns: Sequence[Series], block: Mapping[int, _Balance], order: Sequence[int]
) -> dict[str, Quotient]:
    """Solve for multipliers that depend on each other: the first alone, and then the others."""
    back = dict(_solve(unknowns, balance, k) for k, balance in block.items())
    given = [balance.given or balance for balance in block.values()]
    apart = any(balance.unknown([*order, *block]) for balance in given)
    _, *others = (is_constant(balance.factors[k]) for k, balance in block.items())
    if apart or all(others):
        return back
    # a factor of a balance alone may vanish where the determinant of all does not
    rows = select([balance.factors for balance in given], [*block])
    sides = [balance.move(unknowns, [*block]) for balance in given]
    ring = unknowns[0].ring
    below, whole = determinant(ring, rows), dict[str, Quotient]()
    for k, above in zip(block, cramer(ring, rows, sides), strict=True):
        fraction = make_positive(divide_common(divide_waves([below, above])))
        whole[name_of(unknowns[k])] = Quotient(*reversed(fraction))
    return whole if all(quotient.bearable for quotient in whole.values()) else back


def is_constant(entry: Series) -> bool:
    """Return whether a series is one product of parameters, which is never zero."""
    return entry.is_unit and entry.kinds <= GIVEN


def vanishes_nowhere(entry: Series) -> bool:
    """Return whether a series vanishes nowhere, as what is constant in it outweighs its waves."""
    constants, amplitudes = dict[int, Fraction](), dict[int, Fraction]()
    for trig, monomial, c in entry.terms():
        if any(entry.ring.generators[i].kind not in GIVEN for i, _ in exponents(monomial)):
            return False
        # of each product of parameters, which are positive, a wave takes off at most its amplitude
        constants.setdefault(monomial, Fraction(0))
        if trig:
            amplitudes[monomial] = amplitudes.get(monomial, Fraction(0)) + abs(c)
        else:
            constants[monomial] = c
    sign = 1 if sum(constants.values()) > 0 else -1
    left = [sign * c - amplitudes.get(monomial, 0) for monomial, c in constants.items()]
    return any(left) and min(left) >= 0


def divide_common(column: Sequence[Series], *kinds: Kind) -> list[Series]:
    """Divide series by the number and the letters, parameters by default, that all contain."""
    # the coefficients of the products of sines and cosines
    whole = [
        Series(entry.ring, {0: part}, entry.denominator, entry.reach)
        for entry in column
        for part in entry.parts.values()
    ]
    if not whole:
        return list(column)
    shared = whole[0].ring.monomial(common_monomial(whole, {*kinds} or {Kind.PARAMETER}))
    divisor = shared * common_scale(whole)
    return [entry / divisor for entry in column]


def divide_waves(column: Sequence[Series]) -> list[Series]:
    """Divide series by the sines and cosines of single angles that all of them contain."""
    divided = list(column)
    for index in sorted({index for entry in column for index in entry.turns()}):
        for wave in (2 * power(index), 2 * power(index) + 1):
            while any(divided):
                less = [divide_by_wave(entry, wave) for entry in divided]
                whole = [entry for entry in less if entry is not None]
                if len(whole) < len(less):
                    break
                divided = whole
    return divided


def _solve(unknowns: Sequence[Series], balance: _Balance, k: int) -> tuple[str, Quotient]:
    """Solve a balance for one of its multipliers; return it with its name."""
    above = balance.move(unknowns, [k])
    below = balance.factors[k]
    if is_constant(below):
        above, below = above / below, below.ring.number(1)
    else:
        below, above = make_positive(divide_common([below, above]))
    return name_of(unknowns[k]), Quotient(above, below)


def name_of(letter: Series) -> str:
    """Return the name of a generator."""
    (generator,) = letter.generators()
    return generator.name


def _eliminate(balance: _Balance, other: _Balance, k: int) -> _Balance:
    """Eliminate multiplier k from a balance by another that contains it."""
    mine, its = balance.factors[k], other.factors[k]
    if not mine:
        return balance
    if is_constant(its):
        mine, its = mine / its, its.ring.number(1)
    pairs = zip((*balance.factors, balance.rest), (*other.factors, other.rest), strict=True)
    *factors, rest = divide_common([tidy(its * a - mine * b) for a, b in pairs])
    return _Balance(tuple(factors), rest, balance.given or balance)


def redundancy_stages(
    mechanism: Mechanism, ties: Sequence[Tie], *, of_work: bool = False
) -> list[Stage]:
    """Return the step that names redundant constraints, or no step if there are none."""
    # those across the plane of a motion have no equation
    if not mechanism.constrained:
        return []
    try:
        rows, shared = find_redundancy(mechanism)
    except DerivationError:  # no position satisfies the constraints
        return []
    names = [tie.name for tie in ties]
    rows = tuple(row for row in rows if row.replace(": ", "_") in names)
    shared = tuple(row for row in shared if row.replace(": ", "_") in names)
    if not rows:
        return []
    verb, restrain = ("follows", "it restrains") if len(rows) == 1 else ("follow", "they restrain")
    sentence = (
        f"In every position that the constraints allow, {enumerate_words(rows)} {verb} from the "
        f"others and from how the joints lead the bodies: {restrain} nothing more."
    )
    if not of_work and len(shared) == 1:
        sentence += f" The force of {shared[0]} is undetermined."
    elif not of_work:
        sentence += (
            f" The forces of {enumerate_words(shared)} are undetermined individually; only their "
            "combined effect follows from the motion."
        )
    return [Stage("Redundant constraints", sentence, ())]


_LONGEST_RATE = 40
"""Constraints of loops on velocities or accelerations with more terms are too long to be read."""


def loop_stages(
    ties: Sequence[Tie], *, of_work: bool = False, of_forces: bool = False
) -> list[Stage]:
    """Return the steps that state the constraints of loops and of rolling."""
    stages = []
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
        stages.append(Stage("Loops", sentence, _list_demands(loops)))
        stages += _differentiate_loops(loops)
    rolling = [tie for tie in ties if tie.of_velocities or tie.of_contact]
    if rolling:
        blades = {tie.name.endswith("_side") for tie in rolling if tie.of_contact}
        sentence = " ".join(_CONTACTS[blade] for blade in sorted(blades))
        loads, moving = list[str](), sum(tie.of_velocities for tie in rolling)
        if moving:
            about, warning = _INTEGRABLE[_integrate(ties)]
            sentence += about if of_work else about + warning
            loads.append("λ ∂ψ/∂q'")
        if moving < len(rolling):
            sentence += " Φ is the distance from the plane."
            loads.append("λ ∂Φ/∂q")
        if not of_work:
            letter = "ψ" if moving else "Φ"
            sentence += (
                f" In a virtual displacement along which {letter} is δ{letter} the force λ does "
                f"the work λ δ{letter}; therefore {enumerate_words(loads)} "
                f"{'are' if len(loads) > 1 else 'is'} added to the generalized forces."
            )
        said = sentence.lstrip()
        stages.append(Stage("Constraints on velocities", said, _list_demands(rolling)))
    return stages


_CONTACTS = {
    False: (
        "Where a body rolls, its point of contact has the same velocity as the point it touches."
    ),
    True: "A blade does not move sideways.",
}
"""What is said of contacts, by whether they are blades."""

_INTEGRABLE = {
    True: (
        " ψ is linear in the velocities; here the constraints can be integrated, so that they "
        "restrict positions alone.",
        "",
    ),
    False: (
        " ψ, linear in the velocities, cannot be integrated.",
        " ψ = 0 must not be substituted into T.",
    ),
    None: (
        " ψ, linear in the velocities, need not be integrable.",
        " Where it is not, ψ = 0 must not be substituted into T.",
    ),
}
"""What is said of ψ, and of T, by whether it can be integrated; None if that is undecided."""


def _integrate(ties: Sequence[Tie]) -> bool | None:
    """Return whether constraints integrate to ones on positions alone; None if undecided."""
    # They do if they allow the bracket of any two displacements that they allow (G. Frobenius, J.
    # reine angew. Math. 82 (1877) 230)
    ring = ties[0].demand.ring
    velocities = ring.names(Kind.VELOCITY)
    rows = [list(map(tidy, tie.slopes(ring))) for tie in ties]
    try:
        basis = independent_displacements(ring, rows, len(velocities))
    except DerivationError:
        return None
    quasi = any(coordinate_of(v) == v for v in velocities)
    if quasi or sum(map(len, chain(*basis))) > _LONGEST:
        return None
    closed = set[str]()
    gaps = [tie.demand for tie in ties if not tie.of_velocities]
    for gap in gaps:  # which gives a coordinate by others, or may restrict any of its own
        names = {g.name for g in gap.generators() if g.kind is Kind.COORDINATE}
        others = {g.name for other in gaps if other is not gap for g in other.generators()}
        solved = [name for name in sorted(names - others) if is_constant(gap.diff(name))]
        closed |= {*solved[:1]} or names
    for a, b in combinations(basis, 2):
        slopes = zip(map(ring.along, a), map(ring.along, b), strict=True)
        bracket = [project(x, [b])[0] - project(y, [a])[0] for x, y in slopes]
        for rest in project(bracket, rows):
            if not rest.vanishes():  # it might yet where Φ = 0
                return False if closed.isdisjoint(g.name for g in rest.generators()) else None
    moving = [tie.demand.linear(velocities)[1] for tie in ties if tie.of_velocities]
    timed = any(entry.kinds & TIMED for row in rows for entry in row)
    return None if timed or any(moving) else True


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
    return [Stage(LOOPS_IN_MOTION, sentence, tuple(results))]


def multiplier_stages(
    algebra: Algebra, M: Matrix, rest: Sequence[Series], ties: Sequence[Tie]
) -> list[Stage]:
    """Return the step that solves for the multipliers of loops, if it is short."""
    ring = algebra.ring
    if not ties or any(tie.of_velocities or tie.of_contact for tie in ties):
        return []
    a = [ring[name] for name in algebra.accelerations]
    sides = []
    for row, constant in zip(M, rest, strict=True):
        sides.append(ring.sum([*(m * x for m, x in zip(row, a, strict=True)), constant]))
    slopes = [list(map(tidy, tie.slopes(ring))) for tie in ties]
    solved = solve_multipliers([tie.multiplier for tie in ties], slopes, sides)
    if not solved:
        return []
    results = []
    for name, value in solved.items():
        left = Left(name) if value.below == 1 else tidy(value.below * ring[name])
        results.append(Result(left, value.above))
    sentence = (
        "The equations of motion are linear in the multipliers. In this order, each gives one more "
        "of them in terms of the accelerations; the remaining equations do not contain them."
    )
    if say_where(solved.values()):
        sentence += " Where the factor before a multiplier is zero, its line does not give it."
    return [Stage(MULTIPLIERS, sentence, tuple(results))]


def _list_demands(ties: Sequence[Tie]) -> tuple[Result, ...]:
    return tuple(Result(Left(f"{tie.letter}_{tie.name}"), tie.demand) for tie in ties)


_MOST_ROWS = 4
"""The most rows whose displacements, by Cramer's rule, can still be read."""


@final
@dataclass(frozen=True)
class Allowed:
    """What rows A of constraints allow."""

    basis: list[Column]  # independent displacements S with A S = 0
    # a row, and a displacement u along which that row is 1, in the order in which rows were met:
    # rows met before it are 0 along u
    pulls: list[tuple[int, Column]]

    def reach(self, ring: Ring, rows: Sequence[Column], values: Sequence[Series]) -> Column:
        """Return a displacement p with A p = values."""
        p = [ring.number(0)] * len(rows[0])
        for row, u in self.pulls:
            (met,) = project(rows[row], [p])
            p = _subtract(p, met - values[row], u)
        return p

    def weigh(self, ring: Ring, rows: Sequence[Column], forces: Column) -> list[Series]:
        """Return the multipliers λ with Aᵀ λ = forces, which do no work along S."""
        multipliers = [ring.number(0)] * len(rows)
        for k, (row, u) in reversed([*enumerate(self.pulls)]):
            later = [other for other, _ in self.pulls[k + 1 :]]
            work, *parts = project(u, [forces, *(rows[other] for other in later)])
            taken = [multipliers[i] * part for i, part in zip(later, parts, strict=True)]
            multipliers[row] = tidy(work - ring.sum(taken))
        return multipliers


def sweep(
    ring: Ring,
    rows: Sequence[Column],
    count: int,
    ranks: Sequence[int] = (),
    *,
    divide: bool = False,
) -> tuple[Allowed, list[int]]:
    """Meet rows one after another as long as no divisor may vanish; also return the rows left.

    Those left are met as well if one may divide by what vanishes in some positions.
    """
    # Of the displacements that could meet a row, the one with the least rank gives way
    basis = identity(ring, count)
    ranks = list(ranks or range(count))
    pulls: list[tuple[int, Column]] = []
    waiting = list(range(len(rows)))
    while waiting:
        for row in waiting:
            entries = project(rows[row], basis)
            met = [k for k, entry in enumerate(entries) if entry]
            step = _satisfy(ring, basis, entries, sorted(met, key=lambda k: ranks[k]))
            if step is not None or not met:
                waiting.remove(row)
                break
        else:
            if not divide:
                break
            row = waiting.pop(0)
            entries = project(rows[row], basis)
            met = [k for k, entry in enumerate(entries) if entry]
            pivot = min(met, key=lambda k: (len(entries[k]), ranks[k]))
            step = _give_way(basis, entries, met, pivot)
        if step is not None:
            basis, u, gone = step
            del ranks[gone]
            pulls.append((row, u))
    return Allowed(basis, pulls), waiting


def independent_displacements(ring: Ring, rows: Sequence[Column], count: int) -> list[Column]:
    """Return a basis S of the displacements with A δq = 0, each with a part for every velocity."""
    # the later ones follow from the first
    allowed, left = sweep(ring, rows, count, range(count, 0, -1))
    return _solve_by_cramer(ring, allowed.basis, [rows[k] for k in left]) if left else allowed.basis


def _solve_by_cramer(
    ring: Ring, basis: list[Column], rows: Sequence[Sequence[Series]]
) -> list[Column]:
    """Return displacements that satisfy rows without constant entries, by Cramer's rule."""
    whole = [project(row, basis) for row in rows]
    size = len(rows)
    if size > _MOST_ROWS or sum(len(entry) for row in whole for entry in row) > _LONGEST:
        raise DerivationError(
            "the independent displacements that the constraints allow are too long to be read; "
            "such equations are computed, not written out"
        )
    # rows without a minor of their size follow from others, as those of two wheels on one axle
    choices = list[tuple[int, tuple[int, ...], tuple[int, ...], list[list[Series]], Series]]()
    while not choices:
        for entries in map(list, combinations(whole, size)):
            for places in combinations(range(len(basis)), size):
                if minor := determinant(ring, select(entries, places)):
                    choices.append((len(minor), places[::-1], places, entries, minor))
        size -= 1
    *_, held, entries, minor = min(choices, key=lambda choice: choice[:2])
    displacements = []
    for free in range(len(basis)):
        if free in held:
            continue
        column = [minor * x for x in basis[free]]
        shares = cramer(ring, select(entries, held), [row[free] for row in entries])
        for k, share in zip(held, shares, strict=True):
            column = [a - share * b for a, b in zip(column, basis[k], strict=True)]
        shared = divide_waves([tidy(entry) for entry in column])
        displacements.append(make_positive(divide_common(shared, Kind.PARAMETER, Kind.COORDINATE)))
    return displacements


def list_alone(basis: Sequence[Column]) -> list[list[int]]:
    """Return for each displacement the velocities that it alone changes, at the rate 1."""
    users = [sum(map(bool, parts)) for parts in zip(*basis, strict=True)]
    alone = []
    for column in basis:
        alone.append([i for i, x in enumerate(column) if x == 1 and users[i] == 1])
    return alone


Product: TypeAlias = Callable[[Series, Series], Series]
"""How series are multiplied; a proof counts the terms."""


def determinant(
    ring: Ring, rows: Sequence[Sequence[Series]], times: Product = operator.mul
) -> Series:
    """Expand a determinant by its first row, skipping what is zero."""
    if not rows:
        return ring.number(1)
    first, *others = rows
    terms = []
    for k, entry in enumerate(first):
        if entry:
            rest = [i for i in range(len(first)) if i != k]
            minor = determinant(ring, select(others, rest), times)
            terms.append(times(entry, minor) * (-1) ** k)
    return tidy(ring.sum(terms))


def cramer(
    ring: Ring,
    rows: Sequence[Sequence[Series]],
    sides: Sequence[Series],
    times: Product = operator.mul,
) -> list[Series]:
    """Return each unknown of a linear system times its determinant, by Cramer's rule."""
    numerators = []
    for k in range(len(rows)):
        pairs = zip(rows, sides, strict=True)
        replaced = [[*row[:k], side, *row[k + 1 :]] for row, side in pairs]
        numerators.append(determinant(ring, replaced, times))
    return numerators


def select(rows: Sequence[Sequence[Series]], places: Sequence[int]) -> list[list[Series]]:
    """Select entries of every row, in the given order."""
    return [list(map(row.__getitem__, places)) for row in rows]


def make_positive(column: Column) -> Column:
    """Return series with the common sign that makes most terms of the first one positive."""
    first = next(entry for entry in column if entry)
    signs = [1 if c > 0 else -1 for _, _, c in first.terms()]
    return [-entry for entry in column] if sum(signs) < 0 else column


def _satisfy(
    ring: Ring, basis: list[Column], entries: list[Series], met: list[int]
) -> tuple[list[Column], Column, int] | None:
    """Return displacements that satisfy a row with these entries; None if a divisor may vanish."""
    # Also return the displacement along which the row is 1, and which of the basis gives way
    single = next((k for k in met if is_constant(entries[k])), None)
    if single is not None:
        return _give_way(basis, entries, met, single)
    for i, k in combinations(sorted(met), 2):
        size = tidy(entries[i] ** 2 + entries[k] ** 2)
        if not is_constant(size):
            continue
        # the row prevents the displacement (c, s) and allows (−s, c)
        c, s = entries[i], entries[k]
        pairs = list(zip(basis[i], basis[k], strict=True))
        held = [tidy(c * a + s * b) for a, b in pairs]
        rest = [
            _subtract(column, entries[j] / size, held) if j in met else column
            for j, column in enumerate(basis)
        ]
        rest[i] = [tidy(s * a - c * b) for a, b in pairs]
        return rest[:k] + rest[k + 1 :], [entry / size for entry in held], k
    return None


def _give_way(
    basis: list[Column], entries: list[Series], met: list[int], place: int
) -> tuple[list[Column], Column, int]:
    """Return displacements that satisfy a row by one of them, which is divided by its entry."""
    pivot = entries[place]
    rest = [
        _subtract(column, tidy(entries[k] / pivot), basis[place]) if k in met else column
        for k, column in enumerate(basis)
        if k != place
    ]
    return rest, [tidy(entry / pivot) for entry in basis[place]], place


def identity(ring: Ring, size: int) -> list[Column]:
    """Return the rows of a unit matrix."""
    rows = [[ring.number(0)] * size for _ in range(size)]
    for k, row in enumerate(rows):
        row[k] = ring.number(1)
    return rows


def _subtract(column: Column, factor: Series, other: Column) -> Column:
    if not factor:
        return column
    return [tidy(a - factor * b) for a, b in zip(column, other, strict=True)]
