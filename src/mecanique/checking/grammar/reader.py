"""The grammar of formulas, and functions that read texts with it."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from typing import Any, final

from lark import Lark
from lark import Token as LarkToken
from lark.exceptions import UnexpectedInput, UnexpectedToken
from lark.lexer import Lexer

from mecanique.checking.grammar import tree
from mecanique.checking.grammar.builder import build_tree
from mecanique.checking.grammar.letters import Letters, key_of
from mecanique.checking.grammar.mathml import is_mathml, text_of
from mecanique.checking.grammar.scanner import scan
from mecanique.checking.grammar.tokens import Token
from mecanique.checking.grammar.tree import Node
from mecanique.errors import FormulaError

_GRAMMAR = """
start: statement (_NEXT statement)*
statement: sum (_EQUALS sum)*

?sum: product
    | PLUS product            -> positive
    | MINUS product           -> negative
    | sum PLUS product        -> plus
    | sum MINUS product       -> minus

?product: factor
    | product TIMES signed    -> times
    | product OVER signed     -> over
    | product factor          -> juxtaposition

?signed: factor
    | MINUS signed            -> negative
    | PLUS signed             -> positive

?factor: atom
    | atom POWER exponent     -> power
    | RATE factor             -> time_derivative

?exponent: factor
    | MINUS exponent          -> negative
    | PLUS exponent           -> positive

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
_SURPLUS = {"RPAR": "a bracket ) was not opened", "RBRACE": "a brace } was not opened"}


@final
@dataclass(frozen=True)
class Statement:
    """A formula, or an equation between several.

    Args:
        sides: the formulas between the equals signs.
        text: the statement as it was written.
        start: its position in the whole text.
    """

    sides: tuple[Node, ...]
    text: str
    start: int

    @property
    def is_equation(self) -> bool:
        """Whether it has an equals sign."""
        return len(self.sides) > 1


def read(text: str, letters: Letters) -> tuple[Statement, ...]:
    """Read a text of formulas, without executing any of it.

    Args:
        text: plain text, LaTeX, SymPy's text or MathML; one formula a line.
        letters: the letters that it may contain.

    Raises:
        FormulaError: if it cannot be read; the message shows where and suggests a remedy.
    """
    if is_mathml(text):
        text = text_of(text)
    tokens = scan(text, letters)
    if not tokens:
        raise FormulaError("expected a formula, got an empty text")
    try:
        parsed: Any = _parser().parse(tokens)
    except UnexpectedInput as error:
        raise _explain(error, tokens, text) from None
    return tuple(_statements(build_tree(parsed, letters, text), text))


def define(text: str, letters: Letters) -> tuple[str, Node, Letters]:
    """Read a definition such as "J = m l^2/3" or "theta = q1 + q2", and add it to the letters.

    A letter of the system may be redefined, as in "q = pi - q": on the right it has its old
    meaning, from then on the new one.

    Args:
        text: the definition.
        letters: the letters it may use.

    Raises:
        FormulaError: if it is not a valid definition.
    """
    left, sign, right = text.partition("=")
    name = key_of(re.sub(r"[\\{}\s]|\(t\)", "", left))
    if not sign or not re.fullmatch(r"[^\W\d]\w*", name):
        raise FormulaError(f"expected LETTER = FORMULA, e.g. J = m l^2/3, got {text!r}")
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
    rates: dict[str, Node] = {}
    moving = letters.rate_nodes
    try:
        first = tree.rate(formula, moving)
        rates[f"{name}'"] = first
        rates[f"{name}''"] = tree.rate(first, moving)
    except FormulaError:
        pass
    return name, formula, letters.define(name, formula, rates)


def _statements(sides: list[list[Node]], text: str) -> Iterator[Statement]:
    for parts in sides:
        start, end = min(p.start for p in parts), max(p.end for p in parts)
        if len(parts) == 1 and _is_equation(parts[0]):
            parts = list(parts[0].parts)
        if any(_is_equation(node) for part in parts for node in part.walk()):
            raise FormulaError("Eq(…, …) is an equation, and stands alone in its line", text, start)
        yield Statement(tuple(parts), " ".join(text[start:end].split()), start)


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
        missing = [word for kind, word in _EXPECTED.items() if kind in _kinds(error)]
        what = missing[0] if missing else "the formula ends too early; expected a letter or number"
        opened = _last_open(tokens) if missing else None
        place = len(text.rstrip()) if opened is None else opened.start
        return FormulaError(what, text, place)
    token = error.token
    place = token.start_pos or 0
    kind = token.type.lstrip("_")
    if kind in _SURPLUS:
        return FormulaError(_SURPLUS[kind], text, place)
    if kind == "NEXT":
        return FormulaError("the line ends too early; expected a letter or number", text, place)
    if kind in ("COMMA", "SEMICOLON"):
        return FormulaError("a comma has no meaning within these brackets", text, place)
    if kind == "EQUALS":
        return FormulaError(
            "an equals sign within brackets or after an operator; write one equation a line",
            text,
            place,
        )
    return FormulaError(
        f"{str(token)!r} is not expected here; expected a letter, a number or a bracket",
        text,
        place,
    )


def _kinds(error: UnexpectedInput) -> set[str]:
    return set(getattr(error, "expected", ()) or getattr(error, "accepts", ()) or ())


def _last_open(tokens: list[Token]) -> Token | None:
    opened: list[Token] = []
    for token in tokens:
        if token.kind in ("LPAR", "LBRACE", "LSQB"):
            opened.append(token)
        elif token.kind in ("RPAR", "RBRACE", "RSQB") and opened:
            opened.pop()
    return opened[-1] if opened else None
