"""Write equations of any size as a recursion from body to body, with every result named.

Mechanisms with loops or rolling have the additional rows A v = b and, depending on the method,
constraint forces: multipliers in Lagrange's equations, forces on the bodies in Newton and Euler's,
none in the virtual work of the displacements that A allows.
"""

from __future__ import annotations

import re
import textwrap
from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property, partial
from html import escape
from itertools import chain
from typing import Any, final

from mecanique.derivation.coordinates import CoordinateWords
from mecanique.derivation.equations import Equations
from mecanique.derivation.mechanics.contacts import velocity_rows
from mecanique.derivation.mechanics.letters import Letters
from mecanique.derivation.mechanics.loops import Loops
from mecanique.derivation.mechanics.recursion import LinkWrench, TreeRecursion
from mecanique.derivation.mechanics.vectors import add as add_vectors
from mecanique.derivation.mechanics.vectors import apply_transpose, cross, scale
from mecanique.derivation.printing.formulas import (
    MOVING,
    SUMS,
    Base,
    Call,
    Letter,
    Product,
    Sum,
    add,
    list_letters,
    multiply,
    names_in,
    number,
)
from mecanique.derivation.printing.lines import display, width
from mecanique.derivation.printing.prose import to_html, to_latex
from mecanique.derivation.printing.writers import Latex, MathML, Text, Writer, write
from mecanique.generation.mechanics.dynamics import TapeDynamics, Tree
from mecanique.model.expression import symbols_in
from mecanique.model.mechanism import Mechanism
from mecanique.model.mechanism.letters import call, letters_of_words
from mecanique.program.listing import Notation, list_program
from mecanique.program.tape import Tape, Value
from mecanique.program.traced import Traced, trace, values_of
from mecanique.wording import Legible

_HALF = Fraction(1, 2)


@final
@dataclass(frozen=True)
class ResultLine:
    """A named result: name = sum."""

    name: str
    right: Sum


@final
@dataclass(frozen=True)
class WeightedSum:
    """A sum of products, factor × name, plus a rest."""

    terms: dict[str, int]  # index of the factor in the outputs, by name
    rest: int | None = None  # index of the rest in the outputs; None for none
    negative: bool = False  # whether the products are subtracted


@final
@dataclass(frozen=True)
class Results:
    """The results of a program, and the letters for them."""

    tape: Tape
    outputs: Sequence[Value]
    inputs: Mapping[str, str]  # letter of each input
    names: Mapping[int, str]  # letter of each operation that has one, in order
    known: Mapping[str, Product]  # parameters, in their order within products
    fresh: str  # letter before the numbers of results without a name of their own

    def tidy(self, rows: Sequence[WeightedSum]) -> tuple[list[ResultLine], list[Sum]]:
        """Return named results and rows, without results that only repeat others or are unused."""
        once = frozenset[str]()
        for _ in range(2):
            kept, ends = self._substitute(rows, once)
            rights = [line.right for line in kept]
            uses = Counter(name for part in (*ends, *rights) for name in list_letters(part))
            once = frozenset(
                part.name for part in kept if uses[part.name] == 1 and len(part.right.terms) == 1
            )
        return kept, ends

    def _substitute(
        self, rows: Sequence[WeightedSum], once: Collection[str]
    ) -> tuple[list[ResultLine], list[Sum]]:
        """Return named results and rows, with results that are used once where they are used."""
        fresh_name = re.compile(rf"{self.fresh}\d+")
        letters, lines = dict(self.known), list[ResultLine]()
        for place, name in self.names.items():
            right = _draw_together(self._operate(place, letters))
            short = len(right.terms) < 2 and (name in once or _is_plain(right))
            if short and fresh_name.fullmatch(name):
                letters[name] = right.terms[0] if right.terms else number(0)
            else:
                lines.append(ResultLine(name, right))
        ends = [_draw_together(self._add_up(row, letters)) for row in rows]
        needed = frozenset[str]().union(*(names_in(end) for end in ends))
        kept = list[ResultLine]()
        for line in reversed(lines):
            if line.name in needed:
                needed |= names_in(line.right)
                kept.append(line)
        return kept[::-1], ends

    def _add_up(self, row: WeightedSum, known: Mapping[str, Product]) -> Iterator[Product]:
        """Yield the terms of a row."""
        if row.rest is not None:
            yield from self._terms(self.outputs[row.rest], known)
        for name, place in row.terms.items():
            factor = self._product(self.outputs[place], known)
            yield multiply(number(-1 if row.negative else 1), _letter(name, known), factor)

    def _terms(self, value: Value, known: Mapping[str, Product]) -> list[Product]:
        """Return the terms of a value."""
        if isinstance(value, int) and value not in self.names:
            return self._operate(value, known)
        return [self._product(value, known)]

    def _product(self, value: Value, known: Mapping[str, Product]) -> Product:
        """Return a value as a product, with a sum as one factor."""
        if isinstance(value, float):
            return number(Fraction(repr(value)))
        if value in self.names:
            return _letter(self.names[value], known)
        if self.tape.operations[value][0] in "+-":
            return multiply(_draw_together(self._operate(value, known)))
        (term,) = self._operate(value, known)
        return term

    def _operate(self, place: int, known: Mapping[str, Product]) -> list[Product]:
        """Return the terms of an operation."""
        kind, operands, name = self.tape.operations[place]
        if kind == "input":
            return [_letter(self.inputs[name], known)]
        if kind in "+-":
            left, right = operands
            last = self._product(right, known)
            return [*self._terms(left, known), last if kind == "+" else multiply(number(-1), last)]
        if kind in "*/":
            first, second = (self._product(operand, known) for operand in operands)
            return [multiply(first, second if kind == "*" else _invert(second))]
        inner = _draw_together(self._terms(operands[0], known))
        return [multiply((inner, _HALF) if kind == "sqrt" else Call(kind, inner))]


def _letter(name: str, known: Mapping[str, Product]) -> Product:
    place = (MOVING if name.endswith("'") else SUMS + 1, 0)
    return known[name] if name in known else multiply(Letter(name, place))


def _is_plain(whole: Sum) -> bool:
    """Whether a sum is a number, or a number times one letter."""
    factors = [factor for term in whole.terms for factor in term.factors]
    alone = len(factors) <= len(whole.terms) <= 1
    return alone and all(isinstance(base, Letter) and power == 1 for base, power in factors)


def _invert(factor: Product) -> Product:
    powers = tuple((base, -power) for base, power in factor.factors)
    return Product(1 / Fraction(factor.number), powers)


def _draw_together(terms: Iterable[Product]) -> Sum:
    """Return a sum, with terms that differ only in their numbers collected."""
    whole = _collect(terms)
    # sums beside the same factors are multiplied out if fewer terms are left
    beside: dict[tuple[tuple[Base, int | Fraction], ...], dict[Product, list[Product]]] = {}
    for term in whole.terms:
        for pair in term.factors:
            if isinstance(pair[0], Sum) and pair[1] == 1:
                rest = tuple(other for other in term.factors if other != pair)
                parts = [multiply(Product(term.number, rest), part) for part in pair[0].terms]
                beside.setdefault(rest, {})[term] = parts
    for spread in beside.values():
        short = _collect(chain(*spread.values()))
        if len(short.terms) < len(spread) and spread.keys() <= {*whole.terms}:
            whole = _collect([*(x for x in whole.terms if x not in spread), *short.terms])
    return whole


def _collect(terms: Iterable[Product]) -> Sum:
    """Return a sum, with terms that differ only in their numbers collected."""
    sizes: dict[tuple[tuple[Base, int | Fraction], ...], int | Fraction] = {}
    for term in add(terms).terms:
        sizes[term.factors] = sizes.get(term.factors, 0) + term.number
    return add(Product(size, factors) for factors, size in sizes.items())


_MEANINGS = {
    "omega": "angular velocity of {} [rad/s]",
    "alpha": "angular acceleration of {} [rad/s²]",
    "a": "acceleration of the origin of {} minus that of free fall [m/s²]",
    "F": "force that accelerates {} and all bodies beyond [N]",
    "N": "moment that accelerates {} and all bodies beyond, about its origin [N·m]",
}


def spell(name: str) -> str:
    """Spell the name of a part as a subscript."""
    return "".join(sign if sign.isalnum() else "_" for sign in name)


def name_results(recursion: TreeRecursion) -> dict[int, str]:
    """Return the names of the components of the links' vectors, by place on the tape."""
    names: dict[int, str] = {}
    for letter, vectors in recursion.vectors.items():
        for body, vector in zip(_bodies(recursion), vectors, strict=True):
            for axis, component in zip("xyz", vector, strict=True):
                if not isinstance(component, Traced):
                    continue
                kind, _, _ = component.tape.operations[component.place]
                if kind != "input":
                    names.setdefault(component.place, f"{letter}_{spell(body)}_{axis}")
    return names


def name_functions(tape: Tape, taken: dict[int, str]) -> dict[int, str]:
    """Return the names of sines and cosines of coordinates, sin_q1 and cos_q1."""
    names: dict[int, str] = {}
    for place, (kind, values, _) in enumerate(tape.operations):
        if kind in ("sin", "cos") and place not in taken:
            (inner,) = values
            operation = tape.operations[inner] if isinstance(inner, int) else ("", (), "")
            if operation[0] == "input":
                names[place] = f"{kind}_{operation[2]}"
    return names


def explain_letters(
    mechanism: Mechanism, used: Collection[str]
) -> Iterator[tuple[tuple[str, ...], str]]:
    """Yield the meanings of a mechanism's coordinates, velocities and parameters."""
    for name, sentence in CoordinateWords(mechanism).sentences():
        yield (name,), sentence
    for parameter in mechanism.parameters:
        if parameter.symbol in used:
            unit = "" if parameter.unit == "1" else f" [{parameter.unit}]"
            yield (parameter.symbol,), f"{parameter.meaning or 'parameter'}{unit}"
    for signal in mechanism.inputs:
        if signal.symbol in used:
            yield (signal.symbol,), signal.meaning or "input"


def explain_results(
    recursion: TreeRecursion, defined: set[str]
) -> Iterator[tuple[tuple[str, ...], str]]:
    """Yield the meanings of the named vectors with a component in the list."""
    for body in _bodies(recursion):
        for letter, sentence in _MEANINGS.items():
            every = [f"{letter}_{spell(body)}_{axis}" for axis in "xyz"]
            parts = tuple(name for name in every if name in defined)
            if parts:
                yield parts, sentence.format(call(body))


def explain_force(mechanism: Mechanism, row: str) -> str:
    """Explain the multiplier of a row, e.g. a force of a contact, with its direction."""
    name, _, motion = row.partition(": ")
    for contact in mechanism.contacts:
        if contact.name == name:
            return contact.forces_of[motion].format(f"of {contact.on} on {contact.body} in {name}")
    if motion:
        return f"multiplier of loop {name}, {motion}"
    return f"multiplier of velocity constraint {name}"


def _bodies(recursion: TreeRecursion) -> list[str]:
    """Return the body after which each moving link is named."""
    first: dict[int, str] = {}
    for body, seat in recursion.seats.items():
        first.setdefault(seat.place, body)
    return [first.get(place, f"link{place + 1}") for place in range(len(recursion.links))]


_WIDTH = 100
_LABEL = 120.0  # [pt], the widest symbols with their meaning beside them, not below
_FRAGMENT = "% part of a document with \\usepackage{amsmath}"
_MATH = '<math xmlns="http://www.w3.org/1998/Math/MathML" display="{}">{}</math>'


@final
@dataclass(frozen=True)
class WrittenPart:
    """Formulas under a heading."""

    heading: str
    said: str  # a sentence about them; may be empty
    lines: tuple[ResultLine, ...]  # each name = right, or 0 = right
    first: int = 0  # number of the first line; 0 if they are not numbered

    def write(self, writer: Writer) -> tuple[str, ...]:
        """Write its lines in the format of a writer."""
        return tuple(_write_node(line, writer) for line in self.lines)


@final
@dataclass(frozen=True, repr=False)
class Written(Legible):
    """Equations of motion as a list of named results."""

    title: str
    about: tuple[str, ...]  # the mechanism's description, and how to read the list, by paragraphs
    meanings: tuple[tuple[tuple[str, ...], str], ...]
    recursion: tuple[WrittenPart, ...]  # the results in order
    results: tuple[WrittenPart, ...]  # the equations of motion, then the constraints
    printed: Mapping[str, str]  # letters for names that are words

    @cached_property
    def lines(self) -> tuple[str, ...]:
        """The results in order, as text, name = formula."""
        return tuple(line for part in self.recursion for line in part.write(Text()))

    @cached_property
    def equations(self) -> tuple[str, ...]:
        """The equations of motion and the constraints, as text, formula = 0."""
        return tuple(line for part in self.results for line in part.write(Text()))

    def text(self) -> str:
        """Return the list as text."""
        out = [self.title, ""]
        for paragraph in self.about:
            out += [*textwrap.wrap(paragraph, _WIDTH), ""]
        out.append("Symbols")
        listed = [(", ".join(names), sentence) for names, sentence in self.meanings]
        wide = max(len(names) for names, _ in listed)
        out += [f"  {names:<{wide}}  {sentence}" for names, sentence in listed]
        digits = len(str(len(self.lines)))
        for part in self._parts:
            out += ["", part.heading, *textwrap.wrap(part.said, _WIDTH)]
            for count, line in enumerate(part.write(Text()), part.first):
                label = f"{f'({count})':>{digits + 2}}  " if part.first else ""
                out.append(f"  {label}{line}")
        return "\n".join(out)

    def latex(self) -> str:
        """Return the list in LaTeX, as a fragment of a document."""
        names = frozenset(name for names, _ in self.meanings for name in names)
        writer = Latex(self.printed)
        words = partial(to_latex, names=names, letters=self.printed)
        out = [_FRAGMENT, f"\\section*{{{to_latex(self.title, ())}}}"]
        out += [f"{words(paragraph)}\n" for paragraph in self.about]
        out.append("\\begin{description}\\setlength{\\itemsep}{0pt}\\setlength{\\parskip}{0pt}")
        for symbols, sentence in self.meanings:
            letters = ((name, writer.letter(name, False, "")) for name in symbols)
            said = ", ".join(name if name == "…" else f"${letter}$" for name, letter in letters)
            below = " \\hfill \\\\" if width(said) > _LABEL else ""
            out.append(f"\\item[{{\\normalfont {said}}}]{below} {words(sentence)}")
        out.append("\\end{description}")
        for part in self._parts:
            out += [f"\\subsection*{{{part.heading}}}", words(part.said)]
            rows = part.write(writer)
            if part.first:
                rows = tuple(f"{row} \\tag{{{n}}}" for n, row in enumerate(rows, part.first))
            out += [display(rows)] if rows else []
        return "\n".join(out)

    def mathml(self) -> str:
        """Return the list in MathML, as a fragment of an HTML page."""
        names = frozenset(chain(*(names for names, _ in self.meanings)))
        words = partial(to_html, names=names, letters=self.printed)
        out = [f"<h3>{escape(self.title)}</h3>"]
        out += [*(f"<p>{words(paragraph)}</p>" for paragraph in self.about), "<dl>"]
        out += [f"<dt>{said}</dt><dd>{words(meaning)}</dd>" for said, meaning in self.symbols()]
        out.append("</dl>")
        for heading, said, formulas in self.sections():
            out += [f"<h4>{escape(heading)}</h4>", *([f"<p>{words(said)}</p>"] if said else [])]
            out += formulas
        return "\n".join(out)

    def symbols(self) -> tuple[tuple[str, str], ...]:
        """Return each symbol in MathML, with its meaning in words."""
        explained, writer = [], MathML(self.printed)
        for names, sentence in self.meanings:
            symbol = "<mo>,</mo>".join(writer.letter(name, False, "") for name in names)
            explained.append((_MATH.format("inline", symbol), sentence))
        return tuple(explained)

    def sections(self) -> Iterator[tuple[str, str, tuple[str, ...]]]:
        """Yield heading, explanation and formulas in MathML of each part."""
        for part in self._parts:
            rows = part.write(MathML(self.printed))
            yield part.heading, part.said, tuple(_MATH.format("block", row) for row in rows)

    def __str__(self) -> str:
        return self.text()

    @property
    def _caption(self) -> str:
        return self.title

    @property
    def _parts(self) -> tuple[WrittenPart, ...]:
        return (*self.recursion, *self.results)


def _write_node(line: ResultLine, writer: Writer) -> str:
    right = write(line.right.terms, writer, decimals=True)
    if line.name == "0":
        return writer.equation(right, writer.number("0"))
    return writer.equation(writer.letter(line.name, False, ""), right)


_CALLS = ("sin", "cos", "tan", "sqrt", "exp", "log", "asin", "acos", "atan", "tanh", "sign")
_NOTATION = Notation(
    {name: f"{name}({{}})" for name in _CALLS} | {"Abs": "abs({})"}, "{} = {}", lambda x: f"{x!r}"
)
_ABOUT = (
    "The equations are written as a recursion from body to body, not in closed form: outward the "
    "motion of each body, inward the forces that cause it. All components are in the axes of the "
    "body. Inertia that a joint does not displace, such as mass on the axis of a hinge, is "
    "counted with the parent."
)
_RECURSION = "The results, each from those above it."
_DIVISIONS = ("Constants", "Positions", "Velocities and accelerations", "Forces and moments")
"""Headings of the results: of parameters alone, and from where positions, rates, forces begin."""
_HELD = {
    "lagrange": (
        "Lagrange's equations with multipliers: one for each velocity, M a + h - Q minus the sum "
        "of the multipliers times the coefficients of that velocity in the conditions below."
    ),
    "newton_euler": (
        "Newton and Euler's equations along each velocity; the forces of the contacts are included "
        "in the forces on the bodies."
    ),
    "virtual_work": (
        "The virtual work of all forces, including inertia forces, vanishes in every displacement "
        "that satisfies the conditions on the displacements; the forces of contacts do none."
    ),
}
"""How a method treats the constraints, in a list of named results."""


def write_recursion(equations: Equations) -> Written:
    """Write equations of motion of any size as a recursion, which can be parsed again.

    It is Newton and Euler's recursion (J. Y. S. Luh, M. W. Walker & R. P. C. Paul, 1980), with
    parameters as letters.

    Args:
        equations: the equations of motion.

    Returns:
        The named results, as text, LaTeX or MathML.

    Raises:
        DerivationError: if the coordinate map has no derivatives, or a function in the equations
            cannot be printed.

    Example:
        >>> written = mq.write_recursion(mq.derive(mq.textbook.load("simple_pendulum")))
        >>> written.text().splitlines()[-1]
        '  -N_bob_y = 0'
    """
    mechanism = equations.mechanism
    letters = Letters(mechanism, tuple(mechanism.values))
    tree = Tree(letters)
    dynamics = TapeDynamics(letters, tree, tree, "recursion")
    holds = _Holds(dynamics, equations.method) if mechanism.constrained else None
    tau = tree.recursion.inverse_dynamics(letters.a, holds.wrenches if holds else ())
    outputs = [x - Q for x, Q in zip(tau, dynamics.forces, strict=True)]
    rows = [WeightedSum({}, place) for place in range(len(outputs))]
    parts = {"Equations of motion": rows}
    if holds is not None:
        parts = holds.gather(outputs)
    names = name_results(tree.recursion)
    names |= name_functions(letters.tape, names)
    inputs = {name: name for name in (*mechanism.coordinates, *mechanism.velocities)}
    inputs |= {f"a {name}": f"{name}'" for name in mechanism.velocities}
    inputs |= {name: name for name in ("t", *mechanism.values, *letters.signals)}
    inputs |= {name: name for name in (holds.multipliers if holds else ())}
    fresh = "e" if any(re.fullmatch(r"x\d+", name) for name in inputs) else "x"
    values = values_of(outputs)
    listing = list_program(letters.tape, values, inputs, _NOTATION, names, fresh)
    known = {
        name: Product(1, ((Letter(name, (0, place)), 1),))
        for place, name in enumerate(mechanism.values)
    }
    results = Results(letters.tape, values, inputs, listing.names, known, fresh)
    lines, ends = results.tidy([row for rows_of_part in parts.values() for row in rows_of_part])
    rights = [line.right for line in lines]
    used = frozenset[str]().union(*map(names_in, (*ends, *rights)))
    defined = {line.name for line in lines}
    meanings = [*explain_letters(mechanism, used)]
    meanings += explain_results(tree.recursion, defined)
    if holds is not None:
        meanings += holds.explain()
    if any(re.fullmatch(rf"{fresh}\d+", name) for name in defined):
        meanings.append(((f"{fresh}1", f"{fresh}2", "…"), "results that are used repeatedly"))
    left, written = iter(ends), list[WrittenPart]()
    for heading, rows_of_part in parts.items():
        said = _HELD[equations.method] if holds is not None and not written else ""
        zeros = [ResultLine("0", next(left)) for _ in rows_of_part]
        # a condition that holds by itself, as that across a planar mechanism's plane, is left out
        stated = [line for line in zeros if line.right.terms or not written]
        written.append(WrittenPart(heading, said, tuple(stated)))
    title = f"{mechanism.name.replace('_', ' ').capitalize()}: {equations.title}"
    about = (*mechanism.about.splitlines(), _ABOUT)
    moving = dict.fromkeys((*mechanism.coordinates, "t", *letters.signals), 1)
    moving |= {name: 2 for v in mechanism.velocities for name in (v, f"{v}'")}
    recursion = tuple(_divide(lines, moving))
    printed = letters_of_words(mechanism)
    return Written(title, about, tuple(meanings), recursion, tuple(written), printed)


def _divide(lines: Sequence[ResultLine], moving: dict[str, int]) -> Iterator[WrittenPart]:
    """Divide a list where coordinates, then rates, then forces begin, each from its letters."""
    parts, reached = [list[ResultLine]() for _ in _DIVISIONS], 0
    for line in lines:
        own = 3 if line.name.startswith(("F_", "N_")) else 0
        reached = max(reached, own, *(moving.get(name, 0) for name in names_in(line.right)))
        parts[reached].append(line)
    count, said = 1, _RECURSION
    for heading, part in zip(_DIVISIONS, parts, strict=True):
        if part:
            yield WrittenPart(heading, said, tuple(part), count)
            count, said = count + len(part), ""


@final
class _Holds:
    """The constraints of a mechanism with loops or rolling, by the method of derivation."""

    def __init__(self, dynamics: TapeDynamics, method: str) -> None:
        self._letters = dynamics.letters
        self._loops: Loops = dynamics.loops
        self._method = method
        recursion = dynamics.tree.recursion
        self._velocity_rows = (
            velocity_rows(self._letters, recursion) if method == "newton_euler" else []
        )
        self.multipliers: list[str] = []
        """The names of the multipliers, one for each row; none with virtual work."""
        if method != "virtual_work":
            self.multipliers = [
                f"lambda_{spell(row.replace(': ', '_'))}" for row in self._loops.names
            ]
        self.wrenches = [*self._act(recursion)]
        """The forces of contacts on links, for Newton and Euler's equations."""

    def gather(self, outputs: list[Any]) -> dict[str, list[WeightedSum]]:
        """Return the rows under each heading, and append their factors to the outputs."""
        mechanism, loops = self._letters.mechanism, self._loops
        count = len(outputs)
        A: list[list[int]] = []
        for slopes in loops.jacobian:
            A.append([len(outputs) + k for k in range(count)])
            outputs += slopes
        if self._method == "virtual_work":
            moved = [f"δ{name.rstrip(chr(39))}" for name in mechanism.velocities]
            motion = [WeightedSum(dict(zip(moved, range(count), strict=True)))]
            allowed = [WeightedSum(dict(zip(moved, row, strict=True))) for row in A]
        else:
            acting = {demand.name for demand in self._velocity_rows if demand.place is not None}
            every = zip(self.multipliers, loops.names, A, strict=True)
            pairs = [(multiplier, row) for multiplier, name, row in every if name not in acting]
            motion = []
            for k in range(count):
                motion.append(
                    WeightedSum({multiplier: row[k] for multiplier, row in pairs}, k, negative=True)
                )
            allowed = []
        conditions = [*self._conditions(outputs, A)]
        parts = {"Equations of motion": motion, "Conditions on the displacements": allowed}
        parts["Conditions"] = conditions
        return {heading: rows for heading, rows in parts.items() if rows}

    def explain(self) -> Iterator[tuple[tuple[str, ...], str]]:
        """Yield the meanings of multipliers and displacements."""
        mechanism = self._letters.mechanism
        for name, row in zip(self.multipliers, self._loops.names, strict=False):
            yield (name,), explain_force(mechanism, row)
        if self._method == "virtual_work":
            for name in mechanism.velocities:
                yield (f"δ{name.rstrip(chr(39))}",), f"virtual displacement along {name}"

    def _conditions(self, outputs: list[Any], A: list[list[int]]) -> Iterator[WeightedSum]:
        """Yield Φ = 0 of rows that restrict positions, then ψ = 0 of the others."""
        mechanism, loops = self._letters.mechanism, self._loops
        steady = not any("t" in symbols_in(law) for law in mechanism.coordinates.driven.values())
        for k, (gap, rate) in enumerate(zip(loops.residual, loops.rate, strict=True)):
            if not (isinstance(gap, float) and gap == 0.0):
                outputs.append(gap)
                yield WeightedSum({}, len(outputs) - 1)
            elif steady and k < len(loops.names) - len(mechanism.velocity_constraints):
                yield WeightedSum(dict(zip(mechanism.velocities, A[k], strict=True)))
            else:
                outputs.append(rate)
                yield WeightedSum({}, len(outputs) - 1)

    def _act(self, recursion: TreeRecursion) -> Iterator[LinkWrench]:
        mechanism, tape = self._letters.mechanism, self._letters.tape
        contacts = {contact.name: contact for contact in mechanism.contacts}
        names = dict(zip(self._loops.names, self.multipliers, strict=False))
        for demand in self._velocity_rows:
            if demand.place is None or demand.direction is None:
                continue
            size = trace(tape, tape.input(names[demand.name]))
            contact = contacts[demand.name.partition(": ")[0]]
            for body, sign in ((contact.body, 1.0), (contact.on, -1.0)):
                place = recursion.seats[body].place
                if place < 0:
                    continue
                pose = recursion.poses[place]
                arm = add_vectors(demand.place, scale(-1.0, [row[3] for row in pose]))
                turn = [row[:3] for row in pose]
                force = apply_transpose(turn, scale(sign, demand.direction))
                reach = apply_transpose(turn, arm)
                yield LinkWrench(place, scale(size, force), scale(size, cross(reach, force)))
