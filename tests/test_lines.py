"""Lines are read at once: nothing nested inside its own kind, no long tuple, no long call."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

SOURCE = Path(__file__).parents[1] / "src" / "mecanique"

COMPREHENSION = (ast.ListComp, ast.SetComp, ast.DictComp, ast.GeneratorExp)

LONGEST_TUPLE = 5
"""A longer one is a record, whose fields have names."""

MOST_POSITIONAL = 8
"""A call with more arguments names them."""

RIGHT = {
    "model/bodies/body.py: tuple `(rows[0][0], rows[1][1], rows[2][2], row…`": (
        "the six entries of an inertia, in the order of URDF"
    ),
}
"""What stays, and why."""


def faults(tree: ast.AST) -> Iterator[str]:
    """Yield what a reader would have to unravel."""
    for node in ast.walk(tree):
        match node:
            case ast.ListComp() | ast.SetComp() | ast.DictComp() | ast.GeneratorExp():
                if holds(node, *COMPREHENSION):
                    yield f"comprehension in a comprehension `{start(node)}`"
            case ast.IfExp():
                if holds(node, ast.IfExp):
                    yield f"condition in a condition `{start(node)}`"
            case ast.Return(value=ast.Tuple(elts=elements) as value):
                if len(elements) > LONGEST_TUPLE:
                    yield f"tuple `{start(value)}`"
            case ast.Subscript(value=ast.Name(id="tuple"), slice=ast.Tuple(elts=elements)):
                if len(elements) > LONGEST_TUPLE:
                    yield f"tuple `{start(node)}`"
            case ast.Call(args=arguments):
                if len(arguments) > MOST_POSITIONAL:
                    yield f"call with {len(arguments)} positional arguments `{start(node)}`"


def holds(node: ast.AST, *kinds: type[ast.AST]) -> bool:
    """Return whether a node of these kinds stands below this one."""
    return any(isinstance(each, kinds) for each in ast.walk(node) if each is not node)


def start(node: ast.AST) -> str:
    """Return the first words of a piece of code."""
    return f"{ast.unparse(node)[:40]}…"


@pytest.mark.parametrize(
    "code",
    [
        "[[x for x in row] for row in rows]",
        "[x for x in (y for y in ys)]",
        "{k: v for k, v in items if all(w for w in v)}",
        "a if b else c if d else e",
        "a if (b if c else d) else e",
        "def f(): return 1, 2, 3, 4, 5, 6",
        "x: tuple[int, int, int, int, int, int]",
        "f(1, 2, 3, 4, 5, 6, 7, 8, 9)",
    ],
)
def test_the_rule_finds(code: str) -> None:
    assert len(list(faults(ast.parse(code)))) == 1


@pytest.mark.parametrize(
    "code",
    [
        "[x for row in rows for x in row]",
        "[f(row) for row in rows] + [x for x in xs]",
        "(a if b else c), (d if e else f)",
        "def f(): return 1, 2, 3, 4, 5",
        "x: tuple[int, ...] = (1, 2, 3, 4, 5, 6)",
        "f(1, 2, 3, 4, 5, 6, 7, 8, a=9)",
    ],
)
def test_the_rule_passes(code: str) -> None:
    assert not list(faults(ast.parse(code)))


def test_lines_are_read_at_once() -> None:
    found: list[str] = []
    for path in sorted(SOURCE.rglob("*.py")):
        tree = ast.parse(path.read_text(encoding="utf-8"))
        where = path.relative_to(SOURCE).as_posix()
        found += [f"{where}: {fault}" for fault in faults(tree)]
    assert [fault for fault in found if fault not in RIGHT] == []
    assert set(found) == RIGHT.keys()
