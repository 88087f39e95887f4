"""CONTRIBUTING tells the truth: its files exist, and its recipes list every file of src."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
SOURCE = ROOT / "src" / "mecanique"
TEXT = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")

FILE = re.compile(r"`([\w./-]+\.(?:py|md))`")
RECIPES = dict(re.findall(r"^### Add an? ([^\n]+)\n(.*?)(?=^##)", TEXT, re.DOTALL | re.MULTILINE))

EXAMPLES = {
    "joint": r"\b(Helical|SCREW)\b",
    "force": r"\b(JointDamper|JointSpring|JointForce|Damper|Torque)\b",
    "element that guides": r"\b(Cord|Belt)\b",
    "law of contact": r"\b(Rolling|Blade)\b",
    "element that switches": r"\b(Capstan|CAPSTAN)\b",
    "lint rule": r"\bM205\b",
    "plot": r"\"phase\"",
    "curve in the page": r"\"Accelerations\"",
    "method of derivation": r"\"virtual_work\"|\bVirtualWork\b|class NumericV|help=.*virtual_work",
}
"""For each recipe, what only the files that it lists name: one of its kind stands for all."""

ELSEWHERE = {
    # SDF has screws of its own, and engines read those of URDF as two joints; a new joint need not
    "joint": {"formats/sdf.py", "verification/engines.py"},
    # a joint's own damping is read where URDF's joints are, and varied with them; springs may stand
    # beside a URDF or in MJCF; a forgotten free length is one of the mistakes a check looks for
    "force": {
        "checking/mistakes/hypotheses.py",
        "model/mechanism/mechanism.py",
        "urdf/toml_loops.py",
        "urdf/read.py",
        "formats/mjcf.py",
        "formats/scope.py",
        "formats/sources.py",
        "formats/sdf.py",
        "conversion.py",
        "formats/read.py",
        "motion/switching/corners.py",
        "derivation/switching.py",
    },
    # a contact that opens and closes is one that rolls, while it is closed
    "law of contact": {"model/constraints/friction.py", "motion/switching/rows.py"},
}

MOST = {
    "joint": 9,
    "force": 8,
    "element that guides": 9,
    "law of contact": 9,
    "element that switches": 6,
}
"""How many files of src a new type may touch, its textbook system included."""


def files(recipe: str) -> set[str]:
    """Return the files of src in the first column of a recipe's table."""
    cells = [line.split("|")[1] for line in RECIPES[recipe].splitlines() if line.startswith("|")]
    named = {name for cell in cells for name in FILE.findall(cell)}
    return {name for name in named if not name.startswith("tests/")}


def test_there_is_a_recipe_for_each_example() -> None:
    assert RECIPES.keys() == EXAMPLES.keys()


@pytest.mark.parametrize("name", sorted(set(FILE.findall(TEXT))))
def test_every_file_it_names_exists(name: str) -> None:
    assert any((folder / name).is_file() for folder in (ROOT, SOURCE))


@pytest.mark.parametrize("recipe", EXAMPLES)
def test_no_other_file_has_a_part_in_a_recipe(recipe: str) -> None:
    example = re.compile(EXAMPLES[recipe])
    found = {
        path.relative_to(SOURCE).as_posix()
        for path in SOURCE.rglob("*.py")
        if example.search(path.read_text(encoding="utf-8"))
    }
    # systems and the chapter's examples use what is there
    if recipe != "joint":
        found = {name for name in found if not name.startswith(("textbook/", "verification/chap"))}
    assert found
    assert found - ELSEWHERE.get(recipe, set()) <= files(recipe)


@pytest.mark.parametrize("recipe", MOST)
def test_a_new_type_touches_few_files(recipe: str) -> None:
    assert len(files(recipe)) <= MOST[recipe]
