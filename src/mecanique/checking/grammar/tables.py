"""Matrices and vectors of formulas, multiplied and added entry by entry."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial, reduce
from typing import Any, TypeAlias, cast

import numpy as np
import numpy.typing as npt

from mecanique.checking.grammar.tree import Node, add, compound, divide, multiply, negate
from mecanique.errors import FormulaError

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
