"""Equations of a mechanism with elements that switch: those of each mode, and when it holds.

The elements' forces enter Lagrange's equations by the rows J that a mode may hold, those of closed
contacts and of joints: M a + h = Q + Jᵀ R. In a mode each element gives one equation for each
of its forces: J a + γ = 0 where it sticks or is closed, R = −μ N where it slips, R = 0 where it is
open.
"""

from __future__ import annotations

import re
import textwrap
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache, partial
from html import escape
from itertools import combinations, product
from math import prod
from typing import Any, Literal, NamedTuple, final

import numpy as np

from mecanique.arrays import rank_of
from mecanique.derivation.mechanics.switching import (
    BACKWARD,
    CLOSED,
    FORWARD,
    OPEN,
    SLIPS,
    STICKS,
    close_contacts,
    place_of,
)
from mecanique.derivation.printing import prose
from mecanique.derivation.printing.expressions import (
    PLACES,
    from_sympy,
    list_factors,
    to_matrix,
    to_sympy,
)
from mecanique.derivation.printing.formulas import open_sum
from mecanique.derivation.printing.lines import INLINE, display, width
from mecanique.derivation.printing.writers import Latex, MathML, Text, Writer, to_lines, write
from mecanique.derivation.scalars.series import Kind, Series
from mecanique.derivation.symbolic.derivation import Derivation
from mecanique.derivation.symbolic.lagrange import Lagrange
from mecanique.derivation.tolerances import REDUNDANT
from mecanique.errors import DerivationError
from mecanique.model.constraints.friction import Contact, Friction, Stop, Switching
from mecanique.model.expression import plain, symbols_in
from mecanique.model.mechanism import Mechanism
from mecanique.model.mechanism.letters import letters_of_words
from mecanique.model.mechanism_units import add_unit
from mecanique.wording import Legible, say_count, to_title

MOST_MODES = 81
"""So many modes at most are written out."""

READABLE = 16
"""So many modes at most are written out where no one has asked for them."""

LONGEST_FRACTION = 1_000_000
"""Largest denominator of a fraction; those of binary numbers are longer."""

LONGEST_READ = 100
"""Terms of a numerator of a mode that is solved in letters; those of a woodpecker have hundreds to
thousands, and took up to a minute a mode to factor."""

LONGEST_FACTORED = 400
"""Operations of a formula up to which each factor is made as short as can be. A ball on a seesaw,
whose formulas have 500 to 900, took twice as long with it, and they were no shorter."""

MOST_TURNED = 2
"""Angles at most whose quarter turns are tried as the place of a mode; others stay at zero."""

MOST_SIMPLIFIED = 30
"""Operations of a formula up to which sums of angles are looked for."""

LARGEST_FACTORED = 1e50
"""Largest number of a formula that is factored or simplified: products of decimals of 16 digits
share nothing, and are sought through for minutes."""

LONGEST_SYSTEM = 10_000
"""Most products of terms in the determinant of a mode that is solved in letters, by a bound: two
rough corners of a block take 2,430, in a second; a crank whose slider touches by one 375,144."""

_UNDETERMINED = "its forces are not determined by rigid bodies"

_UNSOLVED = "solved for accelerations and forces it is too long to be read; they follow from"


@final
@dataclass(frozen=True)
class ModeCondition:
    """When an element is in a state: words, then a formula or a relation of two."""

    words: str
    left: Any = None  # a sympy expression; of `sized` its absolute value
    sign: str = ""
    right: Any = None
    sized: bool = False

    def with_decimals(self, say: Callable[[Any], Any]) -> ModeCondition:
        """Return the condition with its fractions said as decimals."""
        from sympy import sympify

        left, right = (
            None if side is None else say(sympify(side)) for side in (self.left, self.right)
        )
        return replace(self, left=left, right=right)

    def write(self, places: Mapping[str, tuple[float, float]], writer: Writer) -> str:
        """Write the formula; "" if there is none."""
        if self.left is None:
            return ""
        left = _write(self.left, places, writer)
        if self.sized:
            left = f"|{left}|" if isinstance(writer, Text) else writer.call("Abs", left, "")
        if not self.sign:
            return left
        return writer.relation(left, self.sign, _write(self.right, places, writer))


@final
@dataclass(frozen=True)
class ModeEquations:
    """The equations of one mode.

    Args:
        states: the state of each element, by name.
        accelerations: each solved for, a sympy expression by name, e.g. "x''"; empty if the mode
            does not determine them, or they are too long.
        forces: those of the elements, likewise: friction, and normal forces.
        held: where and when it holds.
        places: the sort key of each letter in a product.
        unsolved: expressions that are zero, where accelerations and forces are too long to be read.
        shown: accelerations and forces as they are written: at the coordinates that the closed
            elements fix, if there are any.
    """

    states: dict[str, str]
    accelerations: dict[str, Any]
    forces: dict[str, Any]
    held: tuple[ModeCondition, ...]
    places: Mapping[str, tuple[float, float]] = field(repr=False, compare=False)
    unsolved: tuple[Any, ...] = ()
    shown: Mapping[str, Any] = field(default_factory=dict, repr=False, compare=False)

    @property
    def title(self) -> str:
        """The state of each element in words, e.g. "belt slips +"."""
        return ", ".join(f"{name} {state}" for name, state in self.states.items())

    @property
    def conditions(self) -> tuple[str, ...]:
        """When it holds, as text."""
        return tuple(
            f"{words} {formula}".strip() for words, formula in self.write_conditions(Text())
        )

    def __str__(self) -> str:
        lines = [f"{self.title}:", *([f"  {self.remark}"] if self.remark else [])]
        lines += [f"  {line}" for line in self.write(Text())]
        lines += [f"  {condition}" for condition in self.conditions]
        return "\n".join(lines)

    @property
    def remark(self) -> str:
        """Why its accelerations are not given; "" if they are."""
        if self.accelerations:
            return ""
        return _UNSOLVED if self.unsolved else _UNDETERMINED

    def write(self, writer: Writer) -> list[str]:
        """Write its accelerations and forces in the format of a writer."""
        unsolved = [_write(law, self.places, writer) for law in self.unsolved]
        return [writer.relation(law, "=", "0") for law in unsolved] + [
            writer.equation(writer.letter(name, False, ""), _write(value, self.places, writer))
            for name, value in self.shown.items()
        ]

    def write_conditions(self, writer: Writer) -> list[tuple[str, str]]:
        """Write when it holds: words, and a formula in the format of a writer or ""."""
        return [(held.words, held.write(self.places, writer)) for held in self.held]


@final
@dataclass(frozen=True, repr=False)
class Modes(Legible):
    """The modes of a mechanism with elements that switch; its text lists them.

    Args:
        mechanism: whose they are.
        modes: each with its equations.
        symbols: their letters, but for coordinates, with what they mean.
        idle: rows of contacts along which nothing slips, e.g. "floor: y".
    """

    mechanism: Mechanism
    modes: tuple[ModeEquations, ...]
    symbols: tuple[tuple[str, str], ...] = ()
    idle: frozenset[str] = field(default=frozenset(), repr=False)

    def __getitem__(self, states: str | tuple[str, ...]) -> ModeEquations:
        asked = (states,) if isinstance(states, str) else states
        for mode in self.modes:
            if tuple(mode.states.values()) == asked:
                return mode
        known = "; ".join(", ".join(mode.states.values()) for mode in self.modes)
        raise DerivationError(f"expected the states of a mode, {known}; got {', '.join(asked)}")

    def __str__(self) -> str:
        return "\n".join(map(str, self.modes))

    def _repr_html_(self) -> str:
        shown, writer = [], MathML(letters_of_words(self.mechanism))
        for mode in self.modes:
            names = {*mode.places, *mode.forces}
            shown.append(f"<h4>{escape(mode.title)}</h4>")
            if mode.remark:
                shown.append(f"<p>{escape(mode.remark)}</p>")
            shown += map(to_lines, mode.write(writer), mode.write(Text()))
            for words, formula in mode.write_conditions(writer):
                math = f" <math>{formula}</math>" if formula else ""
                shown.append(f"<p>{prose.to_html(words, names)}{math}</p>")
        return "\n".join(shown)

    def text(self) -> str:
        """Return the modes below what the system is and what their letters mean."""
        about = (textwrap.fill(line, 100) + "\n" for line in self.mechanism.about.splitlines())
        wide = max((len(symbol) for symbol, _ in self.symbols), default=0)
        letters = (f"  {symbol:<{wide}}  {meaning}" for symbol, meaning in self.symbols)
        return "\n".join([*about, "Symbols", *letters, "", str(self)])

    def latex(self) -> str:
        """Return the modes as LaTeX."""
        name = prose.escape(to_title(self.mechanism.name))
        writer = Latex(letters_of_words(self.mechanism))
        every = {*self.mechanism.coordinates, *(symbol for symbol, _ in self.symbols)}
        parts = [f"\\section*{{{name}: equations of motion in each mode}}"]
        for paragraph in self.mechanism.about.splitlines():
            points = prose.find_points(paragraph)
            parts.append(prose.to_latex(paragraph, every, points) + "\n")
        parts.append("\\begin{description}\\setlength{\\itemsep}{0pt}\\setlength{\\parskip}{0pt}")
        for symbol, meaning in self.symbols:
            letter = writer.letter(symbol, False, "")
            parts.append(f"\\item[{{\\normalfont ${letter}$}}] {prose.to_latex(meaning, every)}")
        parts.append("\\end{description}")
        for mode in self.modes:
            names, formulas = {*mode.places, *mode.forces}, mode.write(writer)
            parts.append(f"\\subsection*{{{prose.escape(mode.title)}}}")
            parts += [f"{mode.remark}\n"] if mode.remark else []
            parts += [display(formulas)] if formulas else []
            said = (
                prose.to_latex(words, names) + _set_formula(formula)
                for words, formula in mode.write_conditions(writer)
            )
            parts.append("; ".join(said).replace("\\end{align*}; ", "\\end{align*}\n"))
        return "\n".join(parts)

    @property
    def _caption(self) -> str:
        return f"{self.mechanism.name}: {say_count(len(self.modes), 'mode')}"


def _set_formula(formula: str) -> str:
    """Set a formula of LaTeX after words: within their line, or in lines of its own."""
    if not formula:
        return ""
    return f" ${formula}$" if width(formula) < INLINE else "\n" + display([formula])


class _Row(NamedTuple):
    """A direction in which an element presses or rubs, in sympy expressions."""

    symbol: Any  # its force
    slopes: list[Any]  # J, shape (nv,)
    rate: Any  # J v, less what a rate of slip lacks, and with what moves by itself
    second: Any  # its rate, J a + γ
    gap: Any  # zero of one that rubs
    foot: Any = None  # of a contact, the place along its side


class _ElementForces(NamedTuple):
    """An element with the direction in which it presses and those in which it rubs."""

    element: Switching
    normal: _Row | None
    tangents: tuple[_Row, ...]

    @property
    def slip(self) -> dict[Any, Any]:
        """The letters of its slip in space, its size and its parts, and what they stand for."""
        from sympy import sqrt, symbols

        if len(self.tangents) < 2:
            return {}
        name = force_symbol("s", self.element.name)
        size, x, y = symbols((name, f"{name}_x", f"{name}_y"))
        return {size: sqrt(x**2 + y**2), x: self.tangents[0].rate, y: self.tangents[1].rate}


def force_symbol(letter: str, element: str) -> str:
    """Return the symbol of a force of an element, N, T or R with its name."""
    return f"{letter}_{re.sub(r'[^0-9a-zA-Z]', '_', element)}"


def name_forces(element: Any, tangents: int) -> tuple[str, ...]:
    """Return the symbols of an element's forces in the order of its rows, N first if it presses."""
    if not isinstance(element, Contact):
        return tuple(force_symbol(row.letter, element.name) for row in element.joint_rows)
    parts = ("_x", "_y") if tangents > 1 else ("",) * tangents
    friction = force_symbol("T", element.name)
    return (force_symbol("N", element.name), *(f"{friction}{part}" for part in parts))


def list_symbols(
    mechanism: Mechanism, forces: Sequence[_ElementForces] = ()
) -> Iterator[tuple[str, str]]:
    """Yield the letters of the equations of modes, but for coordinates, and what they mean."""
    for parameter in mechanism.parameters:
        yield parameter.symbol, add_unit(parameter.meaning or "a parameter", parameter.unit)
    for element, normal, tangents in forces:
        if normal is not None:
            yield str(normal.symbol), f"force by which {element.name} presses"
        along = (" along x of its plane", " along y of its plane") if len(tangents) > 1 else ("",)
        for row, direction in zip(tangents, along, strict=False):
            yield str(row.symbol), f"friction of {element.name}{direction}"


def derive_modes(
    mechanism: Mechanism,
    most: int = MOST_MODES,
    only: Collection[Mapping[str, str]] | Literal["single"] = (),
) -> Modes:
    """Derive the equations of every mode of a mechanism with elements that switch.

    Args:
        mechanism: a tree with `Friction`, `Stop` or `Contact` among its `switching` elements;
            contacts with planes.
        most: so many modes are written out at most; each may take seconds.
        only: the modes to write out, each by the state of every element, such as the `states` of a
            motion's `modes`; "single" for those in which at most one element is not in its first
            state, open if it has that one; by default all.

    Returns:
        The modes, each with its accelerations, the forces of the elements and its conditions.

    Raises:
        DerivationError: if an element is not treated, there are too many modes, or a state is not
            one of its element.

    Example:
        >>> from dataclasses import replace
        >>> mu, N = mq.Parameter("mu", 0.2), mq.Parameter("N", 5.0, "N")
        >>> block = mq.textbook.load("two_blocks")
        >>> dry = mq.Friction("dry", block.joints[0].name, mu, N)
        >>> parameters = (*block.parameters, mu, N)
        >>> dry_block = replace(block, parameters=parameters, switching=(dry,))
        >>> print(mq.derive_modes(dry_block)["slips +"].conditions[0])
        while q1' > 0
    """
    from sympy import Float, Matrix, Rational, Symbol, nan, sympify, zoo

    _refuse_unwritten(mechanism)
    derivation = Lagrange(close_contacts(mechanism)).derivation()
    cosines = _Cosines(mechanism)
    unknown = [*_list_forces(mechanism, derivation, cosines)]
    rows = [row for _, normal, tangents in unknown for row in (normal, *tangents) if row]
    symbols = [row.symbol for row in rows]
    accelerations = [Symbol(f"{name}'") for name in mechanism.velocities]
    rest = to_matrix([[h - Q] for h, Q in zip(derivation.h, derivation.Q, strict=True)])
    mass = to_matrix(derivation.M)
    balance = mass * Matrix(accelerations) + rest
    balance = balance.applyfunc(cosines.write)
    for row in rows:
        balance -= Matrix(row.slopes) * row.symbol
    turned = cosines.evaluate()
    by_forces = _solve(list(balance), accelerations, {}, turned) if turned else None
    slips = [pair for forces in unknown for pair in forces.slip.items()]
    letters = dict(slips) | cosines.meanings

    choices = {forces.element.name: _list_states(forces) for forces in unknown}
    if only == "single":
        first = {name: states[0] for name, states in choices.items()}
        changed = ((name, state) for name, states in choices.items() for state in states)
        only = [first | {name: state} for name, state in changed]
    # a dictionary keeps the order in which modes are named first
    chosen = dict.fromkeys(_require_states(choices, states) for states in only)
    count = len(chosen) or prod(map(len, choices.values()))
    if count > most:
        raise DerivationError(
            f"mechanism {mechanism.name!r} has {count} modes, more than {most}; expected "
            "fewer elements that switch, or some of its modes: only=[…], such as the states of a "
            'motion\'s modes, or only="single", those of one element alone'
        )
    modes: list[ModeEquations] = []
    places = _place_letters(mechanism)
    for states in chosen or product(*choices.values()):
        laws, seconds, known = list(balance), list[Any](), dict[Any, Any]()
        for forces, state in zip(unknown, states, strict=True):
            for row, force in _constrain(forces, state):
                if force is None:
                    seconds.append(row.second)
                else:
                    known[row.symbol] = sympify(force)
        known = {symbol: force.xreplace(known) for symbol, force in known.items()}
        # sympy rounds products of decimals, and what cancels would be left over
        decimals = {n: Rational(str(float(n))) for f in known.values() for n in f.atoms(Float)}
        known = {symbol: force.xreplace(decimals) for symbol, force in known.items()}
        left = [symbol for symbol in (*accelerations, *symbols) if symbol not in known]
        laws = [law.xreplace(known) for law in (*laws, *seconds)]
        if by_forces:
            # few equations for the forces are left, and accelerations are given by these
            pushes, moved = left[len(accelerations) :], laws[len(balance) :]
            laws = [cosines.reduce(law.xreplace(by_forces).xreplace(known)) for law in moved]
            solution = _solve(laws, pushes, known, turned) if pushes else known
            solution = cosines.add_accelerations(by_forces, solution, known)
        else:
            solution = _solve(laws, left, known, turned)
        unsolved = () if solution is not None else tuple(map(_clear, laws))
        if solution is None:  # conditions are told in the letters of its forces
            of_forces = {symbol: symbol for symbol in left if symbol in symbols}
            solution = (by_forces or {}) | known | of_forces
        chosen_states = list(zip(unknown, states, strict=True))
        place = _find_place(mechanism, chosen_states)
        written = {symbol: _put(value, place) for symbol, value in solution.items()}
        if written == solution or any(value.has(nan, zoo) for value in written.values()):
            place, written = {}, solution
        held = [
            ModeCondition("at", letter, "=", value)
            for letter, value in place.items()
            if str(letter) in mechanism.coordinates
        ]
        for forces, state in chosen_states:
            held += _list_conditions(forces, state, written, place)
        if len(unknown) == 1 and not unsolved and not cosines.meanings:
            held += _find_paradox(*chosen_states[0], mass, mechanism)
        if alike := _find_conflict(chosen_states, place):
            held = [ModeCondition(f"never, as {alike} slip alike")]
        held += _explain_letters(letters, [*written.values(), *(part.left for part in held)])
        say = partial(_write_decimals, everywhere=bool(decimals))
        inserted = letters | {symbol: solution[symbol] for symbol in symbols if symbol in solution}
        if not unsolved:
            solution = {s: _replace_letters(value, inserted) for s, value in solution.items()}
        solution = {symbol: say(value) for symbol, value in solution.items()}
        written = {symbol: say(value) for symbol, value in written.items()}
        pairs = zip(mechanism.velocities, accelerations, strict=True)
        named = {s: f"{name}'" for name, s in pairs if s in solution}
        acting = {s: str(s) for s in symbols if solution.get(s, 0) not in (0, s)}
        modes.append(
            ModeEquations(
                {forces.element.name: state for forces, state in chosen_states},
                {} if unsolved else {name: solution[s] for s, name in named.items()},
                {name: solution[s] for s, name in acting.items()},
                tuple(dict.fromkeys(condition.with_decimals(say) for condition in held)),
                places,
                unsolved,
                {name: written[s] for s, name in (named | acting).items()},
            )
        )
    tied = {tie.name for tie in derivation.ties}
    rubbed = product((element.name for element in mechanism.switching), "xy")
    idle = {f"{name}: {row}" for name, row in rubbed if f"{name}_{row}" not in tied}
    meanings = tuple(list_symbols(mechanism, unknown))
    return Modes(mechanism, tuple(modes), meanings, frozenset(idle))


def _require_states(
    choices: Mapping[str, Sequence[str]], named: Mapping[str, str]
) -> tuple[str, ...]:
    """Return the state of each element in a mode that is named."""
    for element, states in choices.items():
        if named.get(element) not in states:
            raise DerivationError(
                f"expected a state of {element!r}, {', '.join(states)}; got {named.get(element)!r}"
            )
    return tuple(named[element] for element in choices)


def _refuse_unwritten(mechanism: Mechanism) -> None:
    """Refuse a mechanism whose modes are not written out."""
    if mechanism.loops or mechanism.contacts or mechanism.velocity_constraints:
        raise DerivationError(
            f"mechanism {mechanism.name!r} has constraints that hold in every mode; the equations "
            "of its modes are written out for trees alone"
        )
    driven = mechanism.coordinates.driven.values()
    guided = any("t" in symbols_in(place) for place in driven)
    for element in mechanism.switching:
        if isinstance(element, Contact) and element.closed.curved:
            raise DerivationError(
                f"contact {element.name!r} is not with a plane; the equations of its modes are "
                "not written out yet"
            )
        if isinstance(element, Contact) and guided:
            raise DerivationError(
                f"contact {element.name!r}: the coordinate map depends on time, so its body "
                "may move by itself; the equations of such modes are not written out yet"
            )


@final
class _Cosines:
    """Letters for the direction cosines of what quaternions turn, in which formulas are short.

    Products of two components of a quaternion are sums of cosines: 4 x w = A_32 − A_23. Formulas
    are reduced by what the cosines of three perpendicular axes fulfil.
    """

    def __init__(self, mechanism: Mechanism) -> None:
        from sympy import Matrix, Symbol, eye, groebner

        self.meanings: dict[Any, Any] = {}  # the formula of each letter, in quaternions
        self._pairs: dict[tuple[Any, ...], dict[tuple[int, int], Any]] = {}
        self._relations: list[Any] = []
        for joint in mechanism.joints:
            if not joint.quaternion:
                continue
            x, y, z, w = quaternion = tuple(map(Symbol, joint.quaternion))
            name = force_symbol("A", joint.name)
            A = Matrix(3, 3, [Symbol(f"{name}_{i}{j}") for i in (1, 2, 3) for j in (1, 2, 3)])
            S = Matrix([(0, -z, y), (z, 0, -x), (-y, x, 0)])
            self.meanings |= dict(zip(A, (eye(3) + 2 * w * S + 2 * S * S).expand(), strict=True))
            squares = [1 + 2 * A[k, k] - A.trace() for k in range(3)] + [1 + A.trace()]
            pairs = {(k, k): square / 4 for k, square in enumerate(squares)}
            for i, j, k in ((0, 1, 2), (0, 2, 1), (1, 2, 0)):
                pairs[i, j] = (A[i, j] + A[j, i]) / 4
                pairs[k, 3] = (-1) ** k * (A[j, i] - A[i, j]) / 4
            self._pairs[quaternion] = pairs
            turned = [A.row(k - 3).cross(A.row(k - 2)) - A.row(k - 1) for k in range(3)]
            whole = [*(A * A.T - eye(3)), *(A.T * A - eye(3)), *(x for row in turned for x in row)]
            # those of the third row remain, of a floor the components of the vertical
            self._relations += groebner(whole, *A[:6], *reversed(A[6:]), order="grevlex").exprs

    def evaluate(self) -> dict[Any, float]:
        """Return the cosines of axes turned in no way of meaning."""
        generator, turned = np.random.default_rng(0), dict[Any, float]()
        for quaternion in self._pairs:
            values = generator.normal(size=4)
            unit = dict(zip(quaternion, (values / np.linalg.norm(values)).tolist(), strict=True))
            turned |= {
                letter: float(formula.xreplace(unit))
                for letter, formula in self.meanings.items()
                if formula.free_symbols & unit.keys()
            }
        return turned

    def write(self, formula: Any) -> Any:
        """Return a formula with cosines in the place of products of two components."""
        from sympy import Poly, prod

        for quaternion, pairs in self._pairs.items():
            if not formula.free_symbols.intersection(quaternion):
                continue
            parts = []
            for powers, factor in Poly(formula, *quaternion).terms():
                which = [k for k, power in enumerate(powers) for _ in range(power)]
                odd = quaternion[which[-1]] if len(which) % 2 else 1
                twos = zip(which[::2], which[1::2], strict=False)
                parts.append(prod((pairs[two] for two in twos), factor * odd))
            formula = sum(parts).expand()
        return formula

    def reduce(self, formula: Any) -> Any:
        """Return a formula without what the relations of cosines make zero."""
        from sympy import fraction, reduced, together

        if not formula.free_symbols & self.meanings.keys():
            return _shorten(formula)
        above, below = (
            reduced(side, self._relations, *self.meanings, order="grevlex")[1]
            for side in fraction(together(formula))
        )
        return _shorten(above / below)

    def add_accelerations(
        self, by_forces: Mapping[Any, Any], forces: dict[Any, Any] | None, known: Mapping[Any, Any]
    ) -> dict[Any, Any] | None:
        """Return accelerations and forces, the former by letters of forces that are long."""
        if not forces:
            return forces
        forces = {symbol: self.reduce(force) for symbol, force in forces.items()}
        short = {s: f for s, f in forces.items() if f.count_ops() <= MOST_SIMPLIFIED}
        moved = {s: self.reduce(value.xreplace(short)) for s, value in by_forces.items()}
        return moved | {
            s: min(f, known.get(s, f), key=_count_operations) for s, f in forces.items()
        }


def _list_forces(
    mechanism: Mechanism, derivation: Derivation, cosines: _Cosines
) -> Iterator[_ElementForces]:
    """Yield the elements with their rows, those of contacts as the constraints of closed ones."""
    from sympy import Symbol

    algebra, ring = derivation.algebra, derivation.algebra.ring
    ties = {tie.name: tie for tie in derivation.ties}

    def state(name: str, rate: Series, gap: Series, foot: Series | None = None) -> _Row:
        return _Row(
            symbol=Symbol(name),
            slopes=[cosines.write(to_sympy(slope)) for slope in ring.partials(rate)],
            rate=cosines.write(to_sympy(rate)),
            second=cosines.write(to_sympy(rate.ddt())),
            gap=to_sympy(gap),
            foot=None if foot is None else to_sympy(foot),
        )

    zero = ring.number(0)
    for element in mechanism.switching:
        if isinstance(element, Contact):
            normal, *along = (ties.get(f"{element.name}_{row}") for row in ("normal", "x", "y"))
            demands = [tie.demand for tie in along if tie is not None] if element.rubs else []
            names = name_forces(element, len(demands))
            gap = zero if normal is None else normal.demand
            presses = state(names[0], gap.ddt(), gap, None if normal is None else normal.foot)
            rubs = map(state, names[1:], demands, demands)
            yield _ElementForces(element, presses, tuple(rubs))
            continue
        rows: dict[str, _Row] = {}
        names = name_forces(element, 0)
        for name, stated in zip(names, element.joint_rows, strict=True):
            place = algebra.series(place_of(mechanism, stated))
            rate = place.ddt() - algebra.series(stated.speed)
            rows[stated.letter] = state(name, rate, place)
        yield _ElementForces(element, rows.pop("N", None), tuple(rows.values()))


def _list_states(forces: _ElementForces) -> list[str]:
    states = [] if forces.normal is None else [OPEN]
    if not forces.tangents:
        return [*states, CLOSED]
    return [*states, STICKS, *((SLIPS,) if forces.slip else (FORWARD, BACKWARD))]


def _constrain(forces: _ElementForces, state: str) -> Iterator[tuple[_Row, Any]]:
    """Yield each row of an element with its force in a state; None where it is held instead."""
    element, normal, tangents = forces
    if state == OPEN:
        yield from ((row, 0) for row in (normal, *tangents) if row is not None)
        return
    if normal is not None:
        stiffness = element.stiffness if isinstance(element, Stop) else None
        yield normal, None if stiffness is None else -stiffness * normal.gap
    size, *parts = forces.slip or (1, -1 if state == BACKWARD else 1)
    for row, part in zip(tangents, parts, strict=False):
        friction = element.coefficients[0] * _find_load(element)
        yield row, None if state == STICKS else -friction * part / size


def _find_place(
    mechanism: Mechanism, states: Sequence[tuple[_ElementForces, str]]
) -> dict[Any, Any]:
    """Return the coordinates that the closed elements fix, with their values, and their rates.

    Both corners of a block on a slope fix th = 0 and z = h/2. Angles are tried at quarter turns,
    the first of which leaves no open gap negative at the mechanism's own parameters.
    """
    from sympy import Matrix, Symbol, cos, linsolve, pi, sin
    from sympy.solvers.solveset import NonlinearError

    gaps: dict[bool, list[Any]] = {True: [], False: []}
    for forces, state in states:
        if forces.normal is not None and getattr(forces.element, "stiffness", None) is None:
            gaps[state != OPEN].append(forces.normal.gap)
    closed = Matrix(gaps[True])
    letters = [Symbol(name) for name in mechanism.coordinates.names if closed.has(Symbol(name))]
    if not letters or closed.has(Symbol("t")):
        return {}
    calls = Matrix([*closed.atoms(sin, cos)])
    turning = [letter for letter in letters if calls.has(letter)]
    lengths = [letter for letter in letters if letter not in turning]
    slopes = closed.jacobian(letters)
    for angles in product((0, pi, pi / 2, -pi / 2), repeat=min(len(turning), MOST_TURNED)):
        place = dict.fromkeys(turning, 0) | dict(zip(turning, angles, strict=False))
        try:
            (solved,) = linsolve([*closed.subs(place)], lengths) if lengths else ((),)
        except (NonlinearError, ValueError):  # of no solution, too
            continue
        place |= dict(zip(lengths, solved, strict=True))
        if any(gap.expand() != 0 for gap in closed.subs(place)):
            continue
        apart = (gap.subs(place).subs(mechanism.values) for gap in gaps[False])
        inside = any(gap.is_number and gap < 0 for gap in apart)
        if not inside and slopes.subs(place).rank() == len(letters):
            return place | {Symbol(f"{letter}'"): 0 for letter in letters}
    return {}


def _find_conflict(states: Sequence[tuple[_ElementForces, str]], place: Mapping[Any, Any]) -> str:
    """Return two elements whose slips are alike and whose states are not; "" if there are none."""
    signs = {STICKS: 0, FORWARD: 1, BACKWARD: -1}
    rubbing = [
        (forces.element.name, _put(forces.tangents[0].rate, place), signs[state])
        for forces, state in states
        if len(forces.tangents) == 1 and state in signs
    ]
    for (a, slip, sign), (b, other, its_sign) in combinations(rubbing, 2):
        ratio = _shorten(slip / other) if slip.free_symbols == other.free_symbols != set() else slip
        if ratio.is_number and sign * (1 if ratio > 0 else -1) != its_sign and ratio != 0:
            return f"{a} and {b}"
    return ""


def _put(value: Any, place: Mapping[Any, Any]) -> Any:
    """Return a formula at a place."""
    return _shorten(value.subs(place)) if place and value.free_symbols & place.keys() else value


def _find_load(element: Switching) -> Any:
    """Return the force that friction goes by: the symbol of what presses, 1 if none is named."""
    from sympy import Symbol

    by = element.pressed_by
    return 1 if by is None else Symbol(force_symbol("N", by))


def _solve(
    laws: list[Any], unknowns: list[Any], known: dict[Any, Any], turned: dict[Any, float]
) -> dict[Any, Any] | None:
    """Return the unknowns, and those known by others; none where they are not determined.

    That is judged where direction cosines have the values of turned axes. Of a system whose
    solution is too long to be read, return None.
    """
    from sympy import (
        Dummy,
        Float,
        Function,
        Matrix,
        Pow,
        Rational,
        cos,
        expand_trig,
        linear_eq_to_matrix,
        sin,
    )
    from sympy.polys.matrices import DomainMatrix

    count = len(unknowns)
    matrix, right = linear_eq_to_matrix([*laws, *known.values()], unknowns)
    if _is_singular(matrix[:count, :], turned):
        return {}
    whole = Matrix.hstack(matrix, right)
    if any(call.args[0].is_Add for call in whole.atoms(sin, cos)):
        whole = whole.applyfunc(expand_trig)
    # sines, cosines and roots as letters of their own, and decimals as fractions: sympy has quick
    # exact arithmetic for fractions of polynomials in letters alone
    roots = {power for power in whole.atoms(Pow) if power.is_number and not power.exp.is_integer}
    calls = {call: Dummy() for call in whole.atoms(Function) | roots}
    decimals = {number: Rational(str(number)) for number in whole.atoms(Float)}
    exact = DomainMatrix.from_Matrix(whole.xreplace(calls).xreplace(decimals)).to_field()
    # without fractions, whose common factors take nearly all of the time to find
    _, system = exact[:count, :].clear_denoms_rowwise(convert=True)
    rows = [list(map(_count_terms, row)) for row in system[:, :-1].to_list()]
    if min(prod(map(sum, lines)) for lines in (rows, zip(*rows, strict=True))) > LONGEST_SYSTEM:
        return None
    numerators, denominator = system[:, :-1].solve_den(system[:, -1:], method="charpoly")
    if max(map(_count_terms, numerators.to_list_flat())) > LONGEST_READ:
        return None
    below = exact.domain.convert_from(denominator, system.domain)
    solved = numerators.convert_to(exact.domain) / below
    others = exact[count:, :-1] * solved - exact[count:, -1:]
    back = {letter: call.xreplace(decimals) for call, letter in calls.items()}
    values = [*solved.to_Matrix(), *others.to_Matrix()]
    short = [_shorten(value.xreplace(back)) for value in values]
    return dict(zip([*unknowns, *known], short, strict=True))


def _clear(law: Any) -> Any:
    """Return a law without the letters of its denominator."""
    from sympy import fraction

    above, below = fraction(law)
    return above / below.as_coeff_Mul()[0]


def _count_terms(entry: Any) -> int:
    """Return the number of terms of a polynomial, which is a number where there are no letters."""
    return len(entry) if hasattr(entry, "terms") else int(bool(entry))


def _write_decimals(value: Any, *, everywhere: bool) -> Any:
    """Return a formula with its fractions as decimals, or those alone that no one would write."""
    from sympy import Float, Rational

    longest = 1 if everywhere else LONGEST_FRACTION
    return value.xreplace({n: Float(n) for n in value.atoms(Rational) if n.q > longest})


def _is_singular(matrix: Any, turned: dict[Any, float]) -> bool:
    """Return whether a matrix of formulas has no inverse, by its rank at a state of no meaning."""
    letters = sorted(matrix.free_symbols - turned.keys(), key=str)
    values = np.random.default_rng(0).uniform(0.5, 1.5, len(letters)).tolist()
    numbers = matrix.subs(dict(zip(letters, values, strict=True)) | turned).evalf()
    scaled = np.array(numbers.tolist(), dtype=float)
    for axis in (1, 0):  # rows and columns have units of their own
        scaled /= np.linalg.norm(scaled, axis=axis, keepdims=True) + np.finfo(float).tiny
    sizes = np.linalg.svd(scaled, compute_uv=False)
    return rank_of(sizes, REDUNDANT) < len(scaled)


@lru_cache(maxsize=1000)  # modes share most of their denominators, and many of their formulas
def _shorten(value: Any) -> Any:
    """Return a formula in factors, short by sin² + cos² = 1."""
    from sympy import Dummy, Function, Pow, cos, factor_terms, fraction, sin, together
    from sympy.simplify.fu import TR2i, TR10i

    # an exponential would be turned over, and overflow where what it stood for is none
    calls = {call: Dummy() for call in value.atoms(Function) - value.atoms(sin, cos)}
    value, back = value.xreplace(calls), {letter: call for call, letter in calls.items()}
    long = value.count_ops() > LONGEST_FACTORED
    sides = fraction(value)
    if any(power.exp.could_extract_minus_sign() for side in sides for power in side.atoms(Pow)):
        sides = fraction(together(value))  # which takes long, and changes nothing of N/D
    above, below = (_factor(side, short=not long) for side in sides)
    if long:
        return factor_terms(above / below).xreplace(back)
    short = _factor(above / below)
    large = any(n.is_Rational and max(abs(n.p), n.q) > LARGEST_FACTORED for n in short.atoms())
    if large or short.count_ops() > MOST_SIMPLIFIED or not short.has(sin, cos):
        return short.xreplace(back)
    simplified = _factor(TR2i(TR10i(short)))  # of all that `simplify` tries at length, these help
    shorter = 4 * simplified.count_ops() <= 3 * short.count_ops()
    return (simplified if shorter else short).xreplace(back)


@lru_cache(maxsize=1000)
def _factor(product: Any, *, short: bool = False) -> Any:
    """Return a product in factors, each as short as sin² + cos² = 1 makes it if asked."""
    from sympy import Add, Integer, Mul, Poly, factor, ring

    number, factors = Integer(1), []
    for power in Mul.make_args(product):
        base, exponent = power.as_base_exp()
        polynomial = Poly(base) if isinstance(base, Add) and exponent.is_integer else None
        if polynomial is None or not (polynomial.domain.is_ZZ or polynomial.domain.is_QQ):
            factors.append((factor(power), 1))
            continue
        denominator, whole = polynomial.clear_denoms(convert=True)
        if max(map(abs, whole.coeffs())) > LARGEST_FACTORED:
            # with a first coefficient of 1, as numbers of 300 digits overflow
            number *= polynomial.LC() ** exponent
            factors.append((polynomial.monic().as_expr(), exponent))
            continue
        letters, *_ = ring(whole.gens, whole.domain)
        content, parts = list_factors(letters.from_dict(whole.rep.to_dict()))
        number *= (content / denominator) ** exponent
        factors += [(part.as_expr(), times * exponent) for part, times in parts]
    rest = Integer(1)
    for base, exponent in factors:
        content, base = (_fold_angles(base) if short else base).as_coeff_Mul()
        number *= content**exponent
        rest *= base**exponent
    # sympy would multiply a fraction into a sum
    spread = number in (1, -1) or not isinstance(rest, Add)
    return number * rest if spread else Mul(number, rest, evaluate=False)


@lru_cache(maxsize=1000)
def _fold_angles(polynomial: Any) -> Any:
    """Return a sum without squares of sines, or of their cosines, where it is shorter."""
    from sympy import Pow, cos, expand, sin

    for angle in sorted({call.args[0] for call in polynomial.atoms(sin, cos)}, key=str):
        c, s = cos(angle), sin(angle)
        s = -s if s.could_extract_minus_sign() else s  # sympy's sin(−u) is −sin(u)
        ways = [polynomial]
        for letter, other in ((s, c), (c, s)):
            powers = {
                power: letter ** (power.exp % 2) * (1 - other**2) ** (power.exp // 2)
                for power in polynomial.atoms(Pow)
                if power.base == letter and power.exp > 1
            }
            ways += [_factor(expand(polynomial.xreplace(powers)))] if powers else []
        fewest = min(map(_count_operations, ways))
        polynomial = min(
            (way for way in ways if _count_operations(way) == fewest), key=_count_signs
        )
    return polynomial


@lru_cache(maxsize=1000)
def _count_operations(formula: Any) -> int:
    """Return the number of operations of a formula, whatever its sign."""
    return int(min(formula.count_ops(), (-formula).count_ops()))


def _count_signs(formula: Any) -> tuple[int, str]:
    """Return by what formulas of one length are ordered: that with fewer signs first."""
    return min(str(side).count("-") for side in (formula, -formula)), str(formula)


def _list_conditions(
    forces: _ElementForces, state: str, solution: dict[Any, Any], place: Mapping[Any, Any]
) -> Iterator[ModeCondition]:
    """Yield when an element is in a state."""
    from sympy import log, sqrt

    element, normal, tangents = forces
    ends = isinstance(element, Contact) and element.ends
    if state == OPEN:
        beyond = ", or beyond an end of its side" if ends else ""
        yield ModeCondition(f"while {element.name} is apart{beyond}")
        return
    if ends and normal is not None and normal.foot is not None:
        yield ModeCondition(
            "while", _drop_sign(_put(normal.foot, place)), "≤", element.length / 2, sized=True
        )
    if normal is not None and normal.symbol in solution:
        pressed = solution[normal.symbol]
        least = plain(-element.holds if isinstance(element, Stop) else 0)
        if pressed == 0:
            yield ModeCondition(f"{element.name} touches without force")
        elif (holds := _compare(pressed, "≥", least)) is None:
            yield ModeCondition("while", pressed, "≥", least)
        elif holds:
            yield ModeCondition(f"{element.name} presses always")
        else:
            yield ModeCondition(f"never, as {normal.symbol} would be", pressed)
    if not tangents:
        return
    acting = [row for row in tangents if solution.get(row.symbol, 0) != 0]
    tangent, *others = acting or tangents[:1]
    if state == SLIPS:
        yield ModeCondition("while", next(iter(forces.slip)), ">", 0)
    elif state != STICKS:
        sign = ">" if state == FORWARD else "<"
        rate = _put(tangent.rate, place) or tangent.rate
        yield ModeCondition("while", _shorten(rate), sign, 0)
    elif others:  # told by their letters, as a root of two squares would be long
        size = sqrt(sum(row.symbol**2 for row in acting))
        yield ModeCondition("sticks if", size, "≤", element.coefficients[1] * _find_load(element))
    elif tangent.symbol in solution:
        load, limit = _find_load(element), element.coefficients[1]
        load = solution.get(load, load)
        if isinstance(element, Friction):
            limit = element.mu_static
            load = load if element.pressed_by else element.load
        needed = solution[tangent.symbol]
        if needed == 0:
            yield ModeCondition("sticks always, as no friction is needed")
            return
        if load == 0 and needed.is_number:
            yield ModeCondition(f"never, as without a load {tangent.symbol} would be", needed)
            return
        if load == 0:
            yield ModeCondition("sticks if", needed, "=", 0)
            return
        if (grip := getattr(element, "grip", None)) is not None:  # of tensions N ∓ R/2 (Euler)
            ratio = log(_shorten((2 * load - needed) / (2 * load + needed)))
            limit = grip
        else:
            ratio = _drop_sign(_shorten(needed / load))
        if (holds := _compare(abs(ratio), "≤", limit)) is None:
            yield ModeCondition("sticks if", ratio, "≤", limit, sized=True)
        elif holds:
            yield ModeCondition("sticks always, as", abs(ratio), "≤", limit)
        else:
            yield ModeCondition("never, as", abs(ratio), ">", limit)


def _find_paradox(
    forces: _ElementForces, state: str, mass: Any, mechanism: Mechanism
) -> Iterator[ModeCondition]:
    """Yield where a contact that slips in a plane has no mode to follow, or two (Painlevé).

    Pressing with its friction it opens the gap at a rate that may be negative. Then nothing stops a
    gap that closes, and one that opens may as well stay closed.
    """
    from sympy import Dummy, Matrix, fraction

    element, normal, tangents = forces
    if state not in (FORWARD, BACKWARD) or normal is None or not isinstance(element, Contact):
        return
    mu, opening, ahead = Dummy("mu"), Dummy("opening"), 1 if state == FORWARD else -1
    steps, across = [Dummy(f"step_{k}") for k in range(mass.rows)], Matrix(normal.slopes)
    push = across - ahead * mu * Matrix(tangents[0].slopes)
    laws = [*(mass * Matrix(steps) - push), opening - across.dot(Matrix(steps))]
    solved = _solve(laws, [*steps, opening], {}, {})
    if not solved:
        return
    opens = solved[opening]
    if not opens.has(mu):
        return
    above, below = fraction(opens.xreplace({mu: plain(element.coefficients[0])}))
    # what is below is a part of the determinant of M, of one sign
    random = np.random.default_rng(0).uniform(0.5, 1.5, mechanism.nq)
    values = mechanism.values | dict(zip(mechanism.coordinates.names, random, strict=True))
    if below.subs(values) < 0:
        above = (-above).expand()
    yield ModeCondition(
        f"no mode follows, or two with {element.name} open (Painlevé), if", above, "<", 0
    )


def _replace_letters(formula: Any, letters: Mapping[Any, Any]) -> Any:
    """Return a formula with letters replaced by what they stand for, which may have others."""
    while formula.free_symbols & letters.keys():
        formula = formula.xreplace(letters)
    return formula


def _explain_letters(
    letters: Mapping[Any, Any], formulas: Sequence[Any]
) -> Iterator[ModeCondition]:
    """Yield what letters of formulas stand for; letters of a meaning follow in their order."""
    from sympy import sympify

    asked = set().union(*(sympify(f).free_symbols for f in formulas if f is not None))
    for letter, meaning in letters.items():
        if letter in asked:
            asked |= meaning.free_symbols
            yield ModeCondition("where", letter, "=", meaning)


def _compare(value: Any, sign: str, limit: Any) -> bool | None:
    """Return whether a relation of two numbers holds; None of formulas."""
    from sympy import sympify

    limit = sympify(limit)
    if not (value.is_number and limit.is_number):
        return None
    return bool(value >= limit) if sign == "≥" else bool(value <= limit)


def _drop_sign(value: Any) -> Any:
    """Return a formula whose absolute value is meant without a minus in front."""
    return -value if value.could_extract_minus_sign() else value


def _place_letters(mechanism: Mechanism) -> dict[str, tuple[float, float]]:
    """Return the sort key of each letter in a product: parameters, coordinates, velocities."""
    kinds = (
        (0, [parameter.symbol for parameter in mechanism.parameters]),
        (PLACES[Kind.COORDINATE], mechanism.coordinates.names),
        (PLACES[Kind.VELOCITY], mechanism.velocities),
    )
    return {name: (kind, k) for kind, names in kinds for k, name in enumerate(names)}


def _write(value: Any, places: Mapping[str, tuple[float, float]], writer: Writer) -> str:
    """Write a sympy expression in the format of a writer."""
    from sympy import Float, sympify

    value = sympify(value)
    return write(open_sum(from_sympy(value, places)), writer, decimals=bool(value.atoms(Float)))
