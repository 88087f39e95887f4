"""Expand equations between matrices, such as M q'' + h = Q: one equation for each row."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

from mecanique.checking.grammar.tree import Node, add, divide, multiply, negate
from mecanique.errors import FormulaError


def write_out(node: Node) -> list[Node]:
    """Return the entries of a column or a row of formulas; a single formula is the only entry.

    Args:
        node: sums and products of matrices and formulas.

    Raises:
        FormulaError: if it has several rows and columns, or sizes do not match.
    """
    found = _expand(node)
    if isinstance(found, Node):
        return [found]
    if min(found.rows, found.columns) > 1:
        raise FormulaError("expected an equation, got a matrix")
    return found.entries


@final
@dataclass(frozen=True)
class _Matrix:
    """A matrix of formulas.

    Args:
        rows: their number.
        columns: their number.
        entries: row by row.
    """

    rows: int
    columns: int
    entries: list[Node]


def _expand(node: Node) -> _Matrix | Node:
    if all(part.kind != "table" for part in node.walk()):
        return node
    match node.kind:
        case "table":
            return _Matrix(len(node.parts) // node.columns, node.columns, list(node.parts))
        case "negative":
            inner = _expand(node.parts[0])
            assert isinstance(inner, _Matrix)
            return _Matrix(inner.rows, inner.columns, [negate(entry) for entry in inner.entries])
        case "sum":
            total, *terms = map(_expand, node.parts)
            for term in terms:
                total = _add(total, term)
            return total
        case "product":
            product, *factors = map(_expand, node.parts)
            for factor in factors:
                product = _multiply(product, factor)
            return product
        case "quotient":
            above, below = map(_expand, node.parts)
            if isinstance(above, _Matrix) and isinstance(below, Node):
                divided = [divide(entry, below) for entry in above.entries]
                return _Matrix(above.rows, above.columns, divided)
    raise FormulaError("expected an equation, got a matrix")


def _add(a: _Matrix | Node, b: _Matrix | Node) -> _Matrix | Node:
    if isinstance(a, Node) and isinstance(b, Node):
        return add(a, b)
    if isinstance(a, Node) or isinstance(b, Node):
        matrix, other = (b, a) if isinstance(a, Node) else (a, b)
        if isinstance(other, Node) and other.is_zero:
            return matrix
        raise FormulaError("a matrix and a formula cannot be added")
    if (a.rows, a.columns) != (b.rows, b.columns):
        raise FormulaError(
            f"a matrix of {a.rows} × {a.columns} and one of {b.rows} × {b.columns} cannot be added"
        )
    pairs = zip(a.entries, b.entries, strict=True)
    return _Matrix(a.rows, a.columns, [add(one, other) for one, other in pairs])


def _multiply(a: _Matrix | Node, b: _Matrix | Node) -> _Matrix | Node:
    if isinstance(a, Node):
        if isinstance(b, Node):
            return multiply(a, b)
        return _Matrix(b.rows, b.columns, [multiply(a, entry) for entry in b.entries])
    if isinstance(b, Node):
        return _Matrix(a.rows, a.columns, [multiply(entry, b) for entry in a.entries])
    if a.columns != b.rows:
        raise FormulaError(
            f"a matrix of {a.rows} × {a.columns} cannot be multiplied by one of "
            f"{b.rows} × {b.columns}"
        )
    entries = []
    for i in range(a.rows):
        for j in range(b.columns):
            row = a.entries[i * a.columns : (i + 1) * a.columns]
            column = b.entries[j :: b.columns]
            pairs = zip(row, column, strict=True)
            entries.append(add(*(multiply(one, other) for one, other in pairs)))
    return _Matrix(a.rows, b.columns, entries)
