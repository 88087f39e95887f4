"""Find the ends of equations, and of arguments written without brackets."""

from __future__ import annotations

from collections.abc import Iterator

from mecanique.checking.grammar.letters import Letters
from mecanique.checking.grammar.tokens import CLOSE, OPEN, OPERATORS, Token
from mecanique.errors import FormulaError


def join_lines(tokens: list[Token]) -> list[Token]:
    """Drop line ends within an equation; all others, and ; and , separate equations."""
    lines: list[list[Token]] = [[]]
    depth = 0
    for token in tokens:
        depth = max(0, depth + (token.kind in OPEN) - (token.kind in CLOSE))
        if depth == 0 and token.kind in ("NEWLINE", "SEMICOLON", "COMMA"):
            lines.append([])
        elif token.kind != "NEWLINE":
            lines[-1].append(token)
    joined: list[list[Token]] = []
    for line in filter(None, lines):
        indented = line[0].kind == "INDENT"
        line = [token for token in line if token.kind != "INDENT"]
        if not line:
            continue
        if joined and _continues(joined[-1], line, indented):
            joined[-1] += line
        else:
            joined.append(list(line))
    out: list[Token] = []
    for k, line in enumerate(joined):
        if k:
            out.append(Token("NEXT", "\n", line[0].start, line[0].start))
        out += line
    return out


def _continues(before: list[Token], line: list[Token], indented: bool) -> bool:
    """Return whether a line continues the equation before it."""
    first = line[0].kind
    if before[-1].kind in OPERATORS or first in ("EQUALS", "TIMES", "OVER", "POWER"):
        return True
    if first not in ("PLUS", "MINUS"):
        return False
    if not _is_equation(before):
        return True
    # no line continues "= 0"; any other right side is continued by a line without =
    ends = before[-2].kind == "EQUALS" and before[-1].value == "0"
    return not ends and (indented or not _is_equation(line))


def _is_equation(line: list[Token]) -> bool:
    return any(token.kind == "EQUALS" for token in line)


def close_arguments(tokens: list[Token], letters: Letters, text: str) -> Iterator[Token]:
    """Put brackets around arguments that have none: sin 2 q, cos q1, sqrt 3."""
    at = 0
    while at < len(tokens):
        token = tokens[at]
        yield token
        at += 1
        if token.kind != "FUNCTION":
            continue
        if at < len(tokens) and tokens[at].kind == "POWER":
            end = _find_end_of_exponent(tokens, at)
            yield from tokens[at:end]
            at = end
        if at < len(tokens) and tokens[at].kind in ("LPAR", "LBRACE", "FRACTION", "LSQB"):
            continue
        end = _find_end_of_argument(tokens, at, letters)
        if end == at:
            place = tokens[at].start if at < len(tokens) else len(text) - 1
            raise FormulaError(
                f"expected an argument of {token.value}, e.g. {token.value}(q)", text, place
            )
        if end < len(tokens) and tokens[end].kind == "POWER":
            name = token.value
            raise FormulaError(
                f"{name} of a letter with a power is ambiguous; write {name}(q)^2 or {name}(q^2)",
                text,
                tokens[end].start,
            )
        yield Token("LPAR", "(", tokens[at].start, tokens[at].start)
        yield from tokens[at:end]
        yield Token("RPAR", ")", tokens[end - 1].end, tokens[end - 1].end)
        at = end


def _find_end_of_exponent(tokens: list[Token], at: int) -> int:
    """Return the end of an exponent between a function and its argument."""
    at += 1
    if at < len(tokens) and tokens[at].kind == "MINUS":
        at += 1
    if at < len(tokens) and tokens[at].kind in OPEN:
        depth = 0
        while at < len(tokens):
            depth += (tokens[at].kind in OPEN) - (tokens[at].kind in CLOSE)
            at += 1
            if not depth:
                break
        return at
    return min(at + 1, len(tokens))


def _find_end_of_argument(tokens: list[Token], at: int, letters: Letters) -> int:
    """Return the end of an argument without brackets: numbers, then an angle or W t."""
    end = at
    while end < len(tokens) and tokens[end].kind == "NUMBER":
        end += 1
    while end < len(tokens) and tokens[end].kind == "NAME":
        name = tokens[end].value
        end += 1
        following = tokens[end] if end < len(tokens) else None
        to_time = following is not None and following.kind == "NAME" and following.value == "t"
        moving = letters.kinds.get(name) in ("coordinate", "time", "velocity")
        if moving or (name in letters.angles and not to_time) or not to_time:
            break
    return end
