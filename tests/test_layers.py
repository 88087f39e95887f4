"""The rooms import one way, and the two walls stand: read from the imports themselves."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

SOURCE = Path(__file__).parents[1] / "src" / "mecanique"

BELOW: dict[str, set[str]] = {
    "errors": set(),
    "model": {"errors"},
    "textbook": {"errors", "model"},
    "urdf": {"errors", "model"},
    "derive": {"errors", "model"},
    "reference": {"errors", "model", "urdf"},
    "verify": {"errors", "model", "textbook", "urdf", "derive", "reference"},
    "motion": {"errors", "model", "textbook", "urdf", "derive", "reference", "verify"},
    "book": {"errors", "model", "textbook", "urdf", "derive", "reference", "verify", "motion"},
    "view": {"errors", "model", "textbook", "urdf", "derive", "reference", "verify", "motion"},
    "cli": {"errors", "model", "textbook", "urdf", "derive", "reference", "verify", "motion", "book", "view"},
    "__main__": {"cli"},
}
"""What each room may import besides itself."""

MODULES = sorted(SOURCE.rglob("*.py"))
INSIDE = [path for path in MODULES if path != SOURCE / "__init__.py"]


def imports(text: str) -> Iterator[str]:
    """Every module a text imports, wherever in it, as a dotted name; relative imports as a lone dot."""
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            if node.level:
                yield "."
            elif node.module == "mecanique":
                yield from (f"mecanique.{alias.name}" for alias in node.names)
            elif node.module:
                yield node.module
        elif isinstance(node, ast.Call) and node.args and isinstance(node.args[0], (ast.Constant, ast.JoinedStr)):
            called = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
            if called in {"import_module", "__import__"}:
                first = node.args[0].values[0] if isinstance(node.args[0], ast.JoinedStr) else node.args[0]
                own = isinstance(first, ast.FormattedValue) and ast.unparse(first.value) == "__name__"
                if not own:  # a room may reach into itself
                    yield str(first.value) if isinstance(first, ast.Constant) else "."


def room_of(path: Path) -> str:
    return path.relative_to(SOURCE).with_suffix("").parts[0]


def rooms_in(text: str) -> set[str]:
    """The rooms a text imports from."""
    return {parts[1] for name in imports(text) if (parts := name.split("."))[0] == "mecanique" and len(parts) > 1}


def outside(text: str) -> set[str]:
    """The other packages a text imports."""
    return {name.split(".")[0] for name in imports(text)}


@pytest.mark.parametrize("path", INSIDE, ids=lambda path: str(path.relative_to(SOURCE)))
def test_a_room_imports_only_what_lies_below_it(path: Path) -> None:
    room = room_of(path)
    assert room in BELOW, f"{room} is no room of the house"
    assert rooms_in(path.read_text()) <= BELOW[room] | {room}


@pytest.mark.parametrize("path", INSIDE, ids=lambda path: str(path.relative_to(SOURCE)))
def test_inside_the_package_imports_are_absolute_and_name_a_room(path: Path) -> None:
    names = set(imports(path.read_text()))
    assert "." not in names
    assert "mecanique" not in names - {"mecanique"} or room_of(path) == "cli"


def test_the_derivation_never_sees_the_engine_and_the_engine_never_sees_the_derivation() -> None:
    derivation = [path.read_text() for path in INSIDE if room_of(path) == "derive"]
    engine = [path.read_text() for path in INSIDE if room_of(path) == "reference"]
    assert derivation
    assert engine
    for text in derivation:
        assert not rooms_in(text) & {"reference", "urdf", "verify", "motion", "view", "cli"}
        assert not outside(text) & {"pinocchio", "pin", "example_robot_data", "hppfcl", "coal", "eigenpy"}
    for text in engine:
        assert "derive" not in rooms_in(text)


def test_only_the_reference_imports_pinocchio() -> None:
    users = {room_of(path) for path in MODULES if outside(path.read_text()) & {"pinocchio", "pin"}}
    assert users == {"reference"}


def test_only_the_reference_mentions_pinocchio_as_a_module() -> None:
    """No way around by an attribute of the reference room either."""
    for path in MODULES:
        if room_of(path) != "reference":
            for node in ast.walk(ast.parse(path.read_text())):
                assert not (isinstance(node, ast.Attribute) and node.attr == "pinocchio"), path


@pytest.mark.parametrize(
    ("text", "rooms"),
    [
        ("import mecanique.reference.engine", {"reference"}),
        ("from mecanique.urdf.write import write_urdf", {"urdf"}),
        ("from mecanique import motion, view", {"motion", "view"}),
        ("def f():\n    from mecanique.derive import derive", {"derive"}),
        ("import importlib\nimportlib.import_module('mecanique.view.page')", {"view"}),
        ("import_module(f'mecanique.motion.{name}')", {"motion"}),
        ("import numpy, math", set()),
    ],
)
def test_the_reader_of_imports_finds_them_all(text: str, rooms: set[str]) -> None:
    assert rooms_in(text) == rooms


def test_the_reader_of_imports_finds_other_packages_and_relative_imports() -> None:
    assert outside("import pinocchio as pin\nfrom numpy.linalg import norm") == {"pinocchio", "numpy"}
    assert "." in set(imports("from .scene import Scene"))
    assert "." in set(imports("import_module(f'{room}.page')"))
    assert not set(imports("import_module(f'{__name__}.page')"))
