"""The page docs/reference.md lists what a Reference answers, no more and no less."""

from __future__ import annotations

import inspect
from pathlib import Path

from mecanique.reference import Reference

PAGE = Path(__file__).parents[2] / "docs" / "reference.md"
START = """# What a Reference answers

`ref = mq.Reference(mechanism)` takes positions, velocities, accelerations and torques in order or
by name, one state or many. Angles in radians, all else in SI units; signs and axes are those of the
[conventions](conventions.md). This page is made of the docstrings, and a test compares them.

"""

NO_ANSWERS = {"closed", "of"}


def signature(name: str) -> str:
    """Its name with its arguments, or alone if it is a property."""
    member = inspect.getattr_static(Reference, name)
    if not inspect.isfunction(member):
        return name
    shown = []
    for argument in list(inspect.signature(member).parameters.values())[1:]:
        bare = argument.default is inspect.Parameter.empty
        shown.append(argument.name if bare else f"{argument.name}={argument.default!r}")
    return f"{name}({', '.join(shown)})"


def page() -> str:
    """The page as it should be: a line for each answer, by name."""
    found = {name for part in Reference.__mro__[:-1] for name in vars(part)}
    names = sorted(name for name in found - NO_ANSWERS if not name.startswith("_"))
    lines = []
    for name in names:
        doc = inspect.getdoc(inspect.getattr_static(Reference, name)) or ""
        lines.append(f"- `ref.{signature(name)}`: {doc.splitlines()[0]}\n")
    return START + "".join(lines)


def test_the_page_lists_every_answer() -> None:
    assert PAGE.read_text(encoding="utf-8") == page()
