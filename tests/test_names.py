"""Functions are named by verbs: what they do, not what is then done."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

SOURCE = Path(__file__).parents[1] / "src" / "mecanique"

PARTICIPLE = re.compile(
    r"(?<!e)ed$|^(told|found|built|made|held|sent|met|kept|lost|bound|understood)$"
    r"|(?<!d)(written|driven|drawn|shown|seen|taken|given|chosen|hidden|broken|thrown|torn)$"
)
"""The last word of a name that fails; "need" and "speed" pass, so do "read", "set" and "split"."""

VERBS = {
    "add",
    "can",
    "choose",
    "collect",
    "count",
    "find",
    "has",
    "is",
    "keep",
    "note",
    "refuse",
    "solve",
}
"""A participle may follow one of these: `is_pinned`, `find_needed`."""

RIGHT = {
    "JointModelRevoluteUnaligned": "Pinocchio's name, in its stand-in",
    "applied": "public, `Reference.applied`: a list of forces",
    "colored": "public, `Shape.colored`: a changed copy, as `sorted` returns one",
    "renamed": "public, `Joint.renamed`: a changed copy",
    "solved": "public, `Equations.solved`: a changed copy",
    "undetermined": "public, `Reference.undetermined`: a list of components",
}
"""Participles that stay, and why."""


def functions() -> Iterator[tuple[str, str]]:
    """Yield every function that is no property, and where it stands."""
    for path in sorted(SOURCE.rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
                marks = " ".join(map(ast.unparse, node.decorator_list))
                if "property" not in marks and ".setter" not in marks:
                    yield node.name, f"{path.relative_to(SOURCE)}:{node.lineno}"


def is_participle(name: str) -> bool:
    """Return whether a name says what is done, not what to do."""
    words = name.strip("_").split("_")
    return bool(PARTICIPLE.search(words[-1])) and words[0] not in VERBS


def test_the_rule_knows_participles() -> None:
    for name in ("moved", "_told", "_was_written", "_kinds_shown", "turned_axes_drawn"):
        assert is_participle(name), name
    for name in ("move", "_read", "is_pinned", "_largest_speed", "find_needed", "add_spread"):
        assert not is_participle(name), name


def test_functions_are_named_by_verbs() -> None:
    wrong = [f"{name} ({where})" for name, where in functions() if is_participle(name)]
    assert [each for each in wrong if each.split()[0] not in RIGHT] == []
    assert {each.split()[0] for each in wrong} == RIGHT.keys()
