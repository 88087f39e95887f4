"""The grammar of formulas, and functions that read texts with it."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cache, partial, reduce
from itertools import takewhile
from typing import Any, TypeAlias, cast, final

import numpy as np
import numpy.typing as npt
from lark import Lark
from lark import Token as LarkToken
from lark.exceptions import UnexpectedInput, UnexpectedToken, VisitError
from lark.lexer import Lexer
from lark.visitors import Transformer_NonRecursive, v_args

from mecanique.checking.grammar import tree
from mecanique.checking.grammar.conditions import CONDITION, ParameterCondition, split_relation
from mecanique.checking.grammar.letters import Kind, KnownLetters, key_of
from mecanique.checking.grammar.mathml import is_mathml, text_of
from mecanique.checking.grammar.scanner import CLOSE, OPEN, Scanner, Token
from mecanique.checking.grammar.tape import FormulaTape
from mecanique.checking.grammar.tree import FUNCTIONS, Node, add, compound, divide, multiply, negate
from mecanique.errors import FormulaError
from mecanique.model.mechanism import Mechanism

_MOST_POWERS = 4
_MOST_EXPONENT = 64
_MOST_DIGITS = 40
_MOST_FACTORS = 64


def build_tree(parsed: Any, letters: KnownLetters, text: str) -> list[list[Node]]:
    """Build the sides of each statement from the parser's tree."""
    try:
        return _Builder(letters, text).transform(parsed)  # type: ignore[no-any-return]
    except VisitError as error:
        if isinstance(error.orig_exc, FormulaError):
            raise error.orig_exc from None
        raise


def _build_in_place(method: Any, _: str, parts: list[Any], __: Any) -> Any:
    """Return what a method builds, a part of a formula at the place of its tokens."""
    built = method(parts)
    return _place(built, parts) if isinstance(built, Node) else built


@final
@v_args(wrapper=_build_in_place)
class _Builder(Transformer_NonRecursive[Any, Any]):
    """Builds the tree of a formula from its tokens."""

    def __init__(self, letters: KnownLetters, text: str) -> None:
        super().__init__()
        self._letters = letters
        self._text = text

    def rows(self, parts: list[Any]) -> list[Any]:
        return parts

    start = statement = cells = rows

    def number(self, parts: list[LarkToken]) -> Node:
        (token,) = parts
        mantissa, _, exponent = token.lower().partition("e")
        place = token.start_pos or 0
        if len(mantissa) > _MOST_DIGITS:
            what = f"expected a number of at most {_MOST_DIGITS} digits"
            raise FormulaError(what, self._text, place)
        # a long exponent is not read as a number at all: that takes the square of its length
        if len(exponent) > _MOST_DIGITS or abs(int(exponent or 0)) > _MOST_EXPONENT:
            what = (
                f"expected a number of at most 1e{_MOST_EXPONENT}, and at least 1e-{_MOST_EXPONENT}"
            )
            raise FormulaError(what, self._text, place)
        return tree.number(Fraction(token))

    def negative_number(self, parts: list[LarkToken]) -> Node:
        return tree.negate(self.number(parts[1:]))

    def name(self, parts: list[LarkToken]) -> Node:
        return self._letters.node(str(parts[0]))

    def negative(self, parts: list[Any]) -> Node:
        return tree.negate(parts[1])

    def plus(self, parts: list[Any]) -> Node:
        return tree.add(parts[0], parts[2])

    def minus(self, parts: list[Any]) -> Node:
        term = tree.negate(parts[2])
        term = term if term.is_zero else term.at(parts[1].start_pos, parts[2].end)
        return tree.add(parts[0], term)

    def times(self, parts: list[Any]) -> Node:
        return self._product(parts[0], parts[2])

    def juxtaposition(self, parts: list[Any]) -> Node:
        return self._product(*parts)

    def _product(self, first: Node, second: Node) -> Node:
        if first.kind == "product" and len(first.parts) >= _MOST_FACTORS:
            raise FormulaError(
                f"expected at most {_MOST_FACTORS} factors in a product", self._text, second.start
            )
        return tree.multiply(first, second)

    def over(self, parts: list[Any]) -> Node:
        return tree.divide(parts[0], parts[2])

    def fraction(self, parts: list[Any]) -> Node:
        return tree.divide(parts[2], parts[5])

    def power(self, parts: list[Any]) -> Node:
        return self._power(parts[0], parts[2])

    def _power(self, base: Node, exponent: Node) -> Node:
        chain, top = 0, exponent
        while top.kind == "power":
            top, chain = top.parts[1], chain + 1
        if chain >= _MOST_POWERS:
            raise FormulaError("expected fewer powers of powers", self._text, exponent.start)
        if exponent.kind == "number" and abs(exponent.value) > _MOST_EXPONENT:
            raise FormulaError(
                f"expected an exponent of at most {_MOST_EXPONENT}", self._text, exponent.start
            )
        return tree.raise_to(base, exponent)

    def time_derivative(self, parts: list[Any]) -> Node:
        return self._rate(parts[1])

    def prime(self, parts: list[Any]) -> Node:
        return self._rate(parts[0])

    def _rate(self, node: Node) -> Node:
        try:
            return tree.rate(node, self._letters.rate_nodes).put_at(node.start)
        except FormulaError as error:
            raise FormulaError(str(error), self._text, node.start) from None

    def brackets(self, parts: list[Any]) -> Node:
        return parts[1]  # type: ignore[no-any-return]

    def square(self, parts: list[Any]) -> Node:
        rows: list[list[Node]] = parts[1]
        if len(rows) == 1 and len(rows[0]) == 1:
            return rows[0][0]
        return self._table(rows)

    def _table(self, rows: list[list[Node]]) -> Node:
        if len(rows) == 1 and any(cell.kind == "table" for cell in rows[0]):
            # the brackets of a row with one entry were read as those of a sum
            rows = [list(cell.parts) if cell.kind == "table" else [cell] for cell in rows[0]]
        width = len(rows[0])
        if any(len(row) != width for row in rows):
            place = rows[0][0].start
            raise FormulaError("expected rows of one length in a matrix", self._text, place)
        entries = [cell for row in rows for cell in row]
        if any(cell.kind == "table" for cell in entries):
            raise FormulaError("a matrix within a matrix", self._text, entries[0].start)
        return tree.compound("table", *entries, columns=width)

    def argument(self, parts: list[Any]) -> Node:
        return tree.compound("table", *parts[1])

    def argument_fraction(self, parts: list[Any]) -> Node:
        return tree.compound("table", _place(self.fraction(parts), parts))

    def function(self, parts: list[Any]) -> Node:
        token, arguments = parts
        return self._call(token, arguments.parts)

    def raised_function(self, parts: list[Any]) -> Node:
        token, _, exponent, arguments = parts
        inverse = exponent.kind == "negative" and exponent.parts[0].value == 1
        if inverse and token in ("sin", "cos", "tan"):
            inverted = token.update(value=f"a{token}")
            return self._call(inverted, arguments.parts)
        base = _place(self._call(token, arguments.parts), parts)
        return self._power(base, exponent)

    def _call(self, token: LarkToken, arguments: Sequence[Node]) -> Node:
        wanted = FUNCTIONS[token].arguments
        if len(arguments) != wanted:
            raise FormulaError(
                f"expected {wanted} argument{'s' if wanted > 1 else ''} of {token}, got "
                f"{len(arguments)}",
                self._text,
                token.start_pos or 0,
            )
        if token == "integral" and arguments[1].kind != "letter":
            what = "expected integral(f, x, a, b), over a letter x from a to b"
            raise FormulaError(what, self._text, token.start_pos or 0)
        if token == "pow":
            return self._power(*arguments)
        if token == "det":
            return determinant(*arguments)
        if token == "cot":
            cosine, sine = (tree.call(name, *arguments) for name in ("cos", "sin"))
            return tree.divide(cosine, sine)
        if token in ("sec", "csc"):
            below = tree.call("cos" if token == "sec" else "sin", *arguments)
            return tree.divide(tree.number(1), below)
        return tree.call(str(token), *arguments)

    def sympy(self, parts: list[Any]) -> Node:
        token, _, rows, _ = parts
        arguments: list[Node] = [cell for row in rows for cell in row]
        if token == "Matrix" and len(arguments) == 1 and arguments[0].kind == "table":
            return arguments[0]
        if token == "Matrix" and len(rows) == 1:
            return self._table([[cell] for cell in arguments])
        if token == "Rational" and len(arguments) == 2:
            return tree.divide(*arguments)
        if token == "Eq" and len(arguments) == 2:
            return tree.compound("call", *arguments, name="Eq")
        if token == "Derivative" and arguments[1:] and arguments[1].name == "t":
            return self._rate(arguments[0])
        raise FormulaError(f"expected {token} as SymPy prints it", self._text, token.start_pos or 0)


def _place(node: Node, parts: list[Any]) -> Node:
    first, last = parts[0], parts[-1]
    start = first.start if isinstance(first, Node) else (first.start_pos or 0)
    end = last.end_pos if isinstance(last, LarkToken) else last.end
    return node.at(start, max(start, end or start))


_GRAMMAR = """
start: statement (_NEXT statement)*
statement: sum (_EQUALS sum)*

?sum: product
    | PLUS product            -> brackets
    | MINUS product           -> negative
    | sum PLUS product        -> plus
    | sum MINUS product       -> minus

?product: factor
    | product TIMES signed    -> times
    | product OVER signed     -> over
    | product factor          -> juxtaposition

?signed: factor
    | MINUS signed            -> negative
    | PLUS signed             -> brackets

?factor: atom
    | atom POWER exponent     -> power
    | RATE factor             -> time_derivative

?exponent: factor
    | MINUS exponent          -> negative
    | PLUS exponent           -> brackets

?atom: NUMBER                 -> number
    | NAME                    -> name
    | LPAR sum RPAR           -> brackets
    | LBRACE sum RBRACE       -> brackets
    | LSQB rows RSQB          -> square
    | atom PRIME              -> prime
    | FRACTION LBRACE sum RBRACE LBRACE sum RBRACE -> fraction
    | FUNCTION argument       -> function
    | FUNCTION POWER raised argument -> raised_function
    | SYMPY LPAR rows RPAR    -> sympy

?raised: NUMBER               -> number
    | NAME                    -> name
    | MINUS NUMBER            -> negative_number
    | LBRACE sum RBRACE       -> brackets
    | LPAR sum RPAR           -> brackets

argument: LPAR cells RPAR
    | LBRACE cells RBRACE
    | LSQB cells RSQB
    | FRACTION LBRACE sum RBRACE LBRACE sum RBRACE -> argument_fraction

rows: cells (_SEMICOLON cells)*
cells: sum (_COMMA sum)*

%declare NUMBER NAME PLUS MINUS TIMES OVER POWER LPAR RPAR LBRACE RBRACE LSQB RSQB PRIME
%declare FRACTION FUNCTION SYMPY RATE _NEXT _EQUALS _SEMICOLON _COMMA
"""

_SILENT = {"NEXT", "EQUALS", "SEMICOLON", "COMMA"}

_EXPECTED = {
    "RPAR": "a bracket ( is not closed",
    "RBRACE": "a brace { is not closed",
    "RSQB": "a bracket [ is not closed",
}
_UNEXPECTED = {
    "RPAR": "a bracket ) was not opened",
    "RBRACE": "a brace } was not opened",
    "NEXT": "the line ends too early; expected a letter or number",
    "COMMA": "a comma has no meaning within these brackets",
    "SEMICOLON": "a comma has no meaning within these brackets",
    "EQUALS": ("an equals sign within brackets or after an operator; write one equation a line"),
}


@final
@dataclass(frozen=True)
class Statement:
    """A formula, or an equation between several."""

    sides: tuple[Node, ...]  # the formulas between the equals signs
    text: str  # the statement as it was written
    start: int  # its position in the whole text
    conditions: tuple[ParameterCondition, ...] = ()  # on parameters, under which it is said to hold

    @property
    def is_equation(self) -> bool:
        """Whether it has an equals sign."""
        return len(self.sides) > 1


@final
@dataclass(frozen=True)
class ReadText:
    """What a text says."""

    statements: tuple[Statement, ...]
    letters: KnownLetters  # with those that the text itself defines
    notes: tuple[str, ...] = ()  # what was set aside, defined, or read in one of several ways


_MOST_DEFINITIONS = 12


def part_chains(statements: Sequence[Statement], text: str) -> list[Statement]:
    """Return equations of two sides: a = 1 = 2 is a = 1 and a = 2; a = b = 1 is a = 1 and b = 1."""
    parted: list[Statement] = []
    for statement in statements:
        first, *others = statement.sides
        if len(others) < 2:
            parted.append(statement)
            continue
        alike = list(takewhile(lambda side: side.kind == "letter", others[:-1]))
        values = others[len(alike) :]
        pairs = [(name, values[0]) for name in (first, *alike)]
        for left, right in [*pairs, *((first, value) for value in values[1:])]:
            said = f"{left.quote(text)} = {right.quote(text)}"
            parted.append(replace(statement, sides=(left, right), text=said))
    return parted


def name_values(statements: Sequence[Statement]) -> list[Statement]:
    """Return statements in which q = 0, π is q = 0 and q = π, and q1 = q2 = 0 is q1 = 0, q2 = 0."""
    named: list[Statement] = []
    for statement in statements:
        *alike, value = statement.sides
        if len(alike) > 1 and all(side.kind == "letter" for side in alike):
            named += [replace(statement, sides=(side, value)) for side in alike]
            continue
        first = named[-1].sides[0] if named and named[-1].is_equation else None
        if first is not None and first.kind == "letter" and not statement.is_equation:
            statement = replace(statement, sides=(first, *statement.sides))
        named.append(statement)
    return named


def read(text: str, letters: KnownLetters) -> tuple[Statement, ...]:
    """Read a text of formulas, without executing any of it.

    Raises:
        FormulaError: if it cannot be read; the message shows where and suggests a remedy.
    """
    return read_answer(text, letters).statements


def read_answer(text: str, letters: KnownLetters, *, conditional: bool = False) -> ReadText:
    """Read a text of formulas, in which lines may define further letters.

    With conditions, each is known to the lines for which it is stated.
    """
    if is_mathml(text):
        text = text_of(text)
    conditions = [*CONDITION.finditer(text)] if conditional else []
    for match in conditions:
        text = text[: match.start()] + " " * len(match[0]) + text[match.end() :]
    defined: dict[str, str] = {}
    places = set[int]()
    while True:
        scanner = Scanner(text, letters)
        lines = scanner.scan()
        lines = [_turn_round(line, defined) for line in lines]
        further = {*defined, *scanner.unknown}
        lines = [part for line in lines for part in _part_definition(line, further)]
        # another definition of the same letter is not left out in silence
        lines = [_derive_constant(line, scanner.unknown) for line in lines]
        kept = [
            line
            for line in lines
            if _start(line) not in places and _quote(line, text) not in defined.values()
        ]
        if not scanner.unknown:
            break
        # no line defines w' alone, and with w its rate w' is undefined, too
        undefined = {word.rstrip("'") for word in scanner.unknown}
        kept = [_turn_round(line, undefined) for line in kept]
        entries = [_turn_round(entry, undefined) for line in kept for entry in _split_vector(line)]
        definitions = [line for line in (*kept, *entries) if _defined_by(line)[0] in undefined]
        ready = [line for line in definitions if not _names(line[1:]) & undefined]
        if not ready or len(defined) >= _MOST_DEFINITIONS or kept == ready[:1]:
            raise scanner.explain_unknown()
        name, order = _defined_by(ready[0])
        start = [token.kind for token in ready[0]].index("EQUALS") + 1
        (sides,) = _parse(ready[0][start:], scanner.letters, text)
        formula = sides[0].put_at(0)
        if order == 2:
            formula = tree.call("sqrt", formula)
        letters = _define(name, formula, letters)
        said = " ".join(token.value for token in ready[0])
        defined[name] = _quote(ready[0], text) if ready[0] in kept else said
        places.add(_start(ready[0]))
    if not kept:
        raise FormulaError(
            "expected a formula besides definitions"
            if defined
            else "expected a formula, got an empty text"
        )
    tokens: list[Token] = []
    for k, line in enumerate(kept):
        tokens += [Token("NEXT", "\n", line[0].start, line[0].start)] if k else []
        tokens += line
    statements = list(_statements(_parse(tokens, scanner.letters, text), text))
    # without letters that are defined, what is the same on both sides says nothing
    restated = [s for s in statements if _is_restated(s, text) or _repeats(s, letters, text)]
    restated = restated if letters.defined else []
    if len(restated) < len(statements):
        statements = [statement for statement in statements if statement not in restated]
        judged = {statement.text for statement in statements}
        defined |= {said.text: said.text for said in restated if said.text not in judged}
    notes = [*scanner.notes, *(f"taken as a definition: '{said}'" for said in defined.values())]
    for match in conditions:
        condition = _read_condition(match, letters)
        if condition is None:
            notes.append(f"set aside: '{match[0].strip(' ,;')}'")
        else:
            statements = _restrict(statements, condition, text)
    return ReadText(tuple(statements), scanner.letters, tuple(notes))


def _read_condition(match: re.Match[str], letters: KnownLetters) -> ParameterCondition | None:
    """Return a condition on parameters; None if it is none that can be read."""
    said = match["said"] or match["alone"]
    falling = list[Node]()
    for side in split_relation(said) or ():
        try:
            statements = read(side, letters)
        except FormulaError:
            return None
        falling += statements[0].sides
        known = {letters.kinds.get(name) for name in statements[0].sides[0].letters}
        if len(statements) > 1 or len(statements[0].sides) > 1 or known - {"parameter", "constant"}:
            return None
    start = match.end() - len(match[0].lstrip(" ,;"))
    return ParameterCondition(said.strip(), start, tuple(falling)) if falling else None


_BEGINS = re.compile(r"(?:^|[\n.;:]|\b(?:and|und|et|y),?)[ $,]*$")
"""What stands before a condition with which a sentence or a part of one begins."""


def _restrict(
    statements: Sequence[Statement], condition: ParameterCondition, text: str
) -> list[Statement]:
    """Return lines, with a condition those that it is stated for.

    That is the one before it, or, where it begins a sentence, all that follow in its line; where
    it has a line of its own, all in those below.
    """
    start = condition.start
    begins = _BEGINS.search(text[max(0, start - 9) : start]) is not None
    end = text.find("\n", start)
    follow = [line for line in statements if line.start > start]
    in_line = [line for line in follow if end < 0 or line.start < end]
    before = [line for line in statements if line.start < start][-1:]
    of = (in_line or follow) if begins or not before else before
    return [
        replace(line, conditions=(*line.conditions, condition)) if line in of else line
        for line in statements
    ]


_MOST_ELIMINATED = 6
"""Most unknown forces that are eliminated."""


def eliminate(text: str, letters: KnownLetters, error: FormulaError) -> ReadText:
    """Return what a text says without the unknown letters that its equations determine.

    Those who cut bodies free write forces between them, as in m1 g - T = m1 x''. Each letter
    must stand linearly in two equations at least, so that none of these is left out unread.
    """
    names = [*error.unknown]
    if len(names) > _MOST_ELIMINATED or len({name.rstrip("'") for name in names}) < len(names):
        raise error
    # an unknown acceleration, as phi'', is eliminated like a force
    kinds: dict[str, Kind] = {**letters.kinds, **dict.fromkeys(names, "input")}
    try:
        reading = read_answer(text, replace(letters, kinds=kinds))
    except FormulaError:
        raise error from None
    statements = [*reading.statements]
    for name in names:
        holding = [statement for statement in statements if name in _letters_of(statement)]
        solved: list[tuple[int, Statement, Node]] = []
        for statement in holding if all(len(s.sides) == 2 for s in holding) else ():
            left, right = statement.sides
            whole = tree.add(left, tree.negate(right))
            slope = tree.rate(whole, {name: tree.number(1)})
            if not slope.letters & {*names} and not slope.is_zero:
                rest = tree.substitute(whole, name, tree.number(0))
                solved.append((slope.size, statement, tree.negate(tree.divide(rest, slope))))
        if not solved or len(holding) == 1:
            raise error
        _, used, formula = min(solved, key=lambda pair: pair[0])
        statements = [_insert(s, name, formula) for s in statements if s is not used]
    notes = (*reading.notes, f"eliminated: {', '.join(names)}")
    return ReadText(tuple(statements), reading.letters, notes)


def _letters_of(statement: Statement) -> set[str]:
    return set().union(*(side.letters for side in statement.sides))


def _insert(statement: Statement, name: str, formula: Node) -> Statement:
    """Return a statement with a formula in place of a letter."""
    sides = (tree.substitute(side, name, formula) for side in statement.sides)
    return replace(statement, sides=tuple(sides))


def _is_restated(statement: Statement, text: str) -> bool:
    """Whether a line follows from definitions, as x1' = x3 with x1 = q and x3 = q'."""
    if len(statement.sides) != 2:
        return False
    first, second = statement.sides
    # an entry of a vector that is defined elsewhere is not written here at all
    left, right = first.quote(text), second.quote(text)
    return (left != right or not left) and _key_of(first) == _key_of(second)


def _repeats(statement: Statement, letters: KnownLetters, text: str) -> bool:
    """Whether a line repeats a definition beside the answer, as w0^2 = k/m."""
    first, last = statement.sides[0], statement.sides[-1]
    word = re.sub(r" ?(?:\^ ?\{?2\}?|²)$", "", first.quote(text).strip())
    if letters.find(word) not in letters.defined or not statement.is_equation:
        return False
    difference = tree.add(first, tree.negate(last))
    # any values will do: what is defined so is the same for all of them
    random = np.random.default_rng(0)
    values = {name: random.uniform(0.5, 2.0, 4) for name in sorted(difference.letters)}
    with np.errstate(all="ignore"):
        relative = FormulaTape(difference).evaluate(values, 4).relative
    return bool((relative < _REPEATED).all())


_REPEATED = 1e-12
"""Sides of a definition that differ by less than this part are the same, up to rounding."""


def _key_of(node: Node) -> tuple[object, ...]:
    """Return what a formula is, in whatever order its terms and factors are."""
    parts = [_key_of(part) for part in node.parts]
    if node.kind in ("sum", "product"):
        parts.sort(key=repr)
    return node.kind, node.name, node.value, *parts


def _start(line: Sequence[Token]) -> int:
    return min(token.start for token in line)


def _quote(line: Sequence[Token], text: str) -> str:
    return " ".join(text[_start(line) : max(token.end for token in line)].split())


def _parse(tokens: list[Token], letters: KnownLetters, text: str) -> list[list[Node]]:
    """Return the sides of each statement."""
    try:
        parsed: Any = _parser().parse(tokens)
    except UnexpectedInput as error:
        raise _explain(error, tokens, text) from None
    return build_tree(parsed, letters, text)


def _names(tokens: Sequence[Token]) -> set[str]:
    return {token.value.rstrip("'") for token in tokens if token.kind == "NAME"}


def _split_vector(line: list[Token]) -> list[list[Token]]:
    """Return the equations a = c and b = d of [a, b] = [c, d], none of any other line."""
    equals = [k for k, token in enumerate(line) if token.kind == "EQUALS"]
    if len(equals) != 1:
        return []
    left, right = _list_entries(line[: equals[0]]), _list_entries(line[equals[0] + 1 :])
    if len(left) != len(right):
        return []
    return [[*a, line[equals[0]], *b] for a, b in zip(left, right, strict=True)]


def _list_entries(side: list[Token]) -> list[list[Token]]:
    """Return the entries of a vector in square brackets, none if it is anything else."""
    entries: list[list[Token]] = [[]]
    depth = 0
    for token in side[:-1]:
        depth += (token.kind in OPEN) - (token.kind in CLOSE)
        if depth == 0:
            return []
        if depth == 1 and token.kind in ("COMMA", "SEMICOLON"):
            entries.append([])
        else:
            entries[-1].append(token)
    entries[0] = entries[0][1:]
    return entries if side and side[0].kind == "LSQB" and side[-1].kind == "RSQB" else []


def _turn_round(line: list[Token], undefined: Collection[str]) -> list[Token]:
    """Return q' = w, of a state-space form, as the definition of its right side."""
    kinds = [token.kind for token in line]
    if kinds == ["NAME", "EQUALS", "NAME"] and line[2].value in undefined:
        return line if _names(line[:1]) & set(undefined) else line[::-1]
    return line


def _part_definition(line: list[Token], further: Collection[str]) -> list[list[Token]]:
    """Return a = x'' = …, where a is no letter of the system, as a = x'' and x'' = …."""
    chained = [token.kind for token in line[:4]] == ["NAME", "EQUALS"] * 2
    if chained and line[0].value in further and line[2].value not in further:
        return [line[:3], line[2:]]
    return [line]


def _derive_constant(line: list[Token], unknown: dict[str, int]) -> list[Token]:
    """Return r^2 phi' = const as d/dt(r^2 phi') = 0; the word is then no unknown letter."""
    word = line[-1].value
    if word not in ("const", "constant") or [t.kind for t in line].count("EQUALS") != 1:
        return line
    if line[-2].kind != "EQUALS" or unknown.pop(word, None) is None:
        return line
    first, last = line[0].start, line[-2].start
    return [
        Token("RATE", "d/dt", first, first),
        Token("LPAR", "(", first, first),
        *line[:-2],
        Token("RPAR", ")", last, last),
        line[-2],
        replace(line[-1], kind="NUMBER", value="0"),
    ]


def _defined_by(line: Sequence[Token]) -> tuple[str, int]:
    """Return the letter that a line such as J = … or omega^2 = … defines, and its power."""
    kinds = [token.kind for token in line[:4]]
    if kinds.count("EQUALS") != 1 or [token.kind for token in line].count("EQUALS") != 1:
        return "", 0
    if kinds[:2] == ["NAME", "EQUALS"]:
        return line[0].value, 1
    if kinds == ["NAME", "POWER", "NUMBER", "EQUALS"] and line[2].value == "2":
        return line[0].value, 2
    return "", 0


def define(text: str, letters: KnownLetters) -> tuple[str, Node, KnownLetters]:
    """Read a definition such as "J = m l^2/3" or "theta = q1 + q2", and add it to the letters."""
    # in "q = pi - q" the letter has its old meaning on the right, from then on the new one
    left, sign, right = text.partition("=")
    name = key_of(re.sub(r"[\\{}\s]|\(t\)", "", left))
    if not sign or not re.fullmatch(r"[^\W\d]\w*", name):
        raise FormulaError(f"expected LETTER = FORMULA, e.g. J = m l^2/3, got {text!r}")
    if name not in letters.printed:  # which may as well be called something else
        name = letters.by_key.get(name, name)
    if letters.kinds.get(name) in ("time", "constant"):
        raise FormulaError(f"{name!r} is defined already; define another letter")
    statements = read(right, letters)
    if len(statements) != 1 or statements[0].is_equation:
        raise FormulaError(f"expected one formula after {name} =, got {right.strip()!r}")
    # its positions are in the definition, not in the text that uses it
    formula = statements[0].sides[0].put_at(0)
    if name in letters.kinds and not formula.letters:
        raise FormulaError(
            f"{name!r} is a letter of the system already; its value is a parameter's (-p {name}=…)"
        )
    return name, formula, _define(name, formula, letters)


def define_joint_positions(letters: KnownLetters, mechanism: Mechanism) -> KnownLetters:
    """Return the letters with those of joints whose positions are formulas, as l = l0 − w t."""
    for name, formula in mechanism.coordinates.driven.items():
        if letters.find(name) is None:
            try:
                letters = define(f"{name} = {formula}", letters)[2]
            except FormulaError:
                continue  # a formula that is not written in letters alone
    return letters


def _define(name: str, formula: Node, letters: KnownLetters) -> KnownLetters:
    """Return the letters with one more, and with its rates where they are known."""
    rates: dict[str, Node] = {}
    moving = letters.rate_nodes
    try:
        first = tree.rate(formula, moving)
        rates[f"{name}'"] = first
        rates[f"{name}''"] = tree.rate(first, moving)
    except FormulaError:
        pass
    return letters.define(name, formula, rates)


def _statements(sides: list[list[Node]], text: str) -> Iterator[Statement]:
    for parts in sides:
        start, end = min(p.start for p in parts), max(p.end for p in parts)
        if len(parts) == 1 and _is_equation(parts[0]):
            parts = list(parts[0].parts)
        if any(_is_equation(node) for part in parts for node in part.walk()):
            raise FormulaError("Eq(…, …) is an equation, and stands alone in its line", text, start)
        try:
            equations = write_out(parts)
        except FormulaError as error:
            raise FormulaError(str(error), text, start) from None
        for equation in equations:
            yield Statement(equation, " ".join(text[start:end].split()), start)


def _is_equation(node: Node) -> bool:
    return node.kind == "call" and node.name == "Eq"


@final
class _Tokens(Lexer):
    """Passes tokens that exist already to the parser."""

    def __init__(self, _: Any) -> None:
        pass

    def lex(self, state: Any, parser_state: Any = None) -> Iterator[LarkToken]:
        tokens: list[Token] = state.text if hasattr(state, "text") else state
        for token in tokens:
            kind = f"_{token.kind}" if token.kind in _SILENT else token.kind
            yield LarkToken(kind, token.value, start_pos=token.start, end_pos=token.end)


@cache
def _parser() -> Lark:
    return Lark(_GRAMMAR, parser="lalr", lexer=_Tokens, maybe_placeholders=False)


def _explain(error: UnexpectedInput, tokens: list[Token], text: str) -> FormulaError:
    if not isinstance(error, UnexpectedToken) or error.token.type == "$END":
        kinds = getattr(error, "expected", ()) or getattr(error, "accepts", ()) or ()
        missing = [word for kind, word in _EXPECTED.items() if kind in kinds]
        what = missing[0] if missing else "the formula ends too early; expected a letter or number"
        opened = _last_open(tokens) if missing else None
        place = len(text.rstrip()) if opened is None else opened.start
        return FormulaError(what, text, place)
    token = error.token
    other = f"{str(token)!r} is not expected here; expected a letter, a number or a bracket"
    what = _UNEXPECTED.get(token.type.lstrip("_"), other)
    return FormulaError(what, text, token.start_pos or 0)


def _last_open(tokens: list[Token]) -> Token | None:
    opened: list[Token] = []
    for token in tokens:
        if token.kind in ("LPAR", "LBRACE", "LSQB"):
            opened.append(token)
        elif token.kind in ("RPAR", "RBRACE", "RSQB") and opened:
            opened.pop()
    return opened[-1] if opened else None


# Matrices and vectors of formulas, multiplied and added entry by entry.

Table: TypeAlias = npt.NDArray[np.object_]
"""A matrix of formulas."""


def write_out(sides: Sequence[Node]) -> list[tuple[Node, ...]]:
    """Return the sides of each equation that an equation between vectors stands for."""
    expanded = [_expand(side) for side in sides]
    tables = [side for side in expanded if not isinstance(side, Node)]
    if not tables:
        return [tuple(sides)]
    if any(min(table.shape) > 1 for table in tables):
        matrices = [
            side if isinstance(side, Node) else compound("table", *side.flat, columns=side.shape[1])
            for side in expanded
        ]
        return [tuple(matrices)]
    count = next((table.size for table in tables if table.size > 1), 1)
    columns = []
    for side in expanded:
        entries = [side] if isinstance(side, Node) else list(side.flat)
        if len(entries) not in (1, count):
            what = f"expected {count} entries on both sides, got {len(entries)}"
            raise FormulaError(what)
        columns.append(entries * count if len(entries) == 1 else entries)
    return list(zip(*columns, strict=True))


_LARGEST = 5
"""Largest number of rows of a determinant, which is written out."""


def determinant(matrix: Node) -> Node:
    """Return the determinant of a matrix, by its first row."""
    table = _expand(matrix)
    if isinstance(table, Node) or len(set(table.shape)) > 1 or len(table) > _LARGEST:
        raise FormulaError(f"expected a square matrix of at most {_LARGEST} rows below det")
    return _minor(table)


def _minor(table: Table) -> Node:
    if len(table) == 1:
        return cast(Node, table[0, 0])
    terms = []
    for column, entry in enumerate(table[0]):
        if not entry.is_zero:
            term = multiply(entry, _minor(np.delete(table[1:], column, axis=1)))
            terms.append(negate(term) if column % 2 else term)
    return add(*terms)


def _expand(node: Node) -> Table | Node:
    if all(part.kind != "table" for part in node.walk()):
        return node
    if node.kind == "table":
        table = np.empty(len(node.parts), dtype=object)
        table[:] = node.parts
        return table.reshape(-1, node.columns)
    parts = [_expand(part) for part in node.parts]
    match node.kind:
        case "negative":
            return _each(negate, parts[0])
        case "sum":
            return reduce(_add, parts)
        case "product":
            return reduce(_multiply, parts)
        case "quotient" if isinstance(parts[1], Node):
            below = parts[1]
            return _each(lambda entry: divide(entry, below), parts[0])
    raise FormulaError("expected a formula, got a matrix")


def _each(change: Callable[[Node], Node], table: Any) -> Table:
    return np.asarray(np.frompyfunc(change, 1, 1)(table))


def _add(a: Table | Node, b: Table | Node) -> Table | Node:
    if isinstance(a, Node) and isinstance(b, Node):
        return add(a, b)
    if isinstance(a, Node) or isinstance(b, Node):
        matrix, entry = (b, a) if isinstance(a, Node) else (a, b)
        if isinstance(entry, Node) and entry.is_zero:
            return matrix
        raise FormulaError("a matrix and a formula cannot be added")
    if 1 in b.shape and a.shape == b.shape[::-1]:
        b = np.asarray(b.T)
    if a.shape != b.shape:
        raise FormulaError(f"a matrix of {_size(a)} and one of {_size(b)} cannot be added")
    return np.asarray(np.frompyfunc(add, 2, 1)(a, b))


def _size(table: Table) -> str:
    return f"{table.shape[0]} × {table.shape[1]}"


def _multiply(a: Table | Node, b: Table | Node) -> Table | Node:
    if isinstance(a, Node) and isinstance(b, Node):
        return multiply(a, b)
    if isinstance(a, Node):
        return _each(partial(multiply, a), b)
    if isinstance(b, Node):
        factor = b
        return _each(lambda entry: multiply(entry, factor), a)
    if a.shape[1] != b.shape[0] and b.shape == (1, a.shape[1]):
        b = np.asarray(b.T)  # a vector beside a matrix is a column, however it is written
    if a.shape[1] != b.shape[0]:
        raise FormulaError(f"a matrix of {_size(a)} cannot be multiplied by one of {_size(b)}")
    product = np.empty((len(a), b.shape[1]), dtype=object)
    for i, j in np.ndindex(product.shape):
        product[i, j] = add(*map(multiply, a[i], b[:, j]))
    return product
