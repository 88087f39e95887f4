"""A sheet of questions: systems, what is asked, points."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, final

from mecanique.errors import InputError
from mecanique.teaching.answers import read_table

_FIELDS = {"id", "system", "ask", "points", "form", "let", "parameters"}


@final
@dataclass(frozen=True)
class Question:
    """One question.

    Args:
        name: of the question, e.g. "1a".
        system: name of a textbook system.
        ask: what is asked for, as in `mecanique.check`.
        points: for a right answer.
        form: part of the points for an answer that is right except for form, from 0 to 1.
        let: definitions of letters that the question gives.
        parameters: values that differ from the catalogue's.
    """

    name: str
    system: str
    ask: str = "equation of motion"
    points: float = 1.0
    form: float = 1.0
    let: tuple[str, ...] = ()
    parameters: Mapping[str, float] = field(default_factory=dict)


@final
@dataclass(frozen=True)
class Sheet:
    """A sheet of questions.

    Args:
        title: its title.
        questions: in order.
        step: to which points are rounded, e.g. 0.25 for quarter points; 0 for none.
    """

    title: str
    questions: tuple[Question, ...]
    step: float = 0.0

    @property
    def points(self) -> float:
        """All points."""
        return sum(question.points for question in self.questions)


def read_sheet(path: Path) -> Sheet:
    """Read a sheet from a TOML or JSON file.

    Args:
        path: of the file, with a title and a table [[question]] for each question.

    Raises:
        InputError: if a field is missing, unknown or of the wrong kind.
    """
    table = read_table(path)
    listed = table.get("question")
    if not isinstance(listed, list) or not listed:
        raise InputError(f"expected at least one [[question]] in {path.name}")
    questions = tuple(_question(entry, path.name) for entry in listed)
    names = [question.name for question in questions]
    for name in names:
        if names.count(name) > 1:
            raise InputError(f"question {name!r} stands twice in {path.name}")
    step = table.get("step", 0.0)
    if not isinstance(step, (int, float)) or isinstance(step, bool) or not 0 <= step <= 1:
        raise InputError(f"expected step from 0 to 1 in {path.name}, got {step!r}")
    return Sheet(str(table.get("title", path.stem)), questions, float(step))


def _question(entry: Any, where: str) -> Question:
    if not isinstance(entry, dict):
        raise InputError(f"expected tables [[question]] in {where}, got {entry!r}")
    unknown = sorted(entry.keys() - _FIELDS)
    if unknown:
        known = ", ".join(sorted(_FIELDS))
        raise InputError(f"unknown field {unknown[0]!r} of a question in {where}; known: {known}")
    for needed in ("id", "system"):
        if not isinstance(entry.get(needed), str):
            raise InputError(f'expected {needed} = "…" in every question of {where}')
    points, form = entry.get("points", 1.0), entry.get("form", 1.0)
    for name, value, most in (("points", points, 1e6), ("form", form, 1.0)):
        if not isinstance(value, (int, float)) or isinstance(value, bool) or not 0 <= value <= most:
            raise InputError(
                f"expected {name} from 0 to {most:g} in question {entry['id']!r}, got {value!r}"
            )
    let, parameters = entry.get("let", []), entry.get("parameters", {})
    if not isinstance(let, list) or not all(isinstance(definition, str) for definition in let):
        raise InputError(f'expected let = ["J = …"] in question {entry["id"]!r}, got {let!r}')
    if not isinstance(parameters, dict):
        raise InputError(f"expected parameters = {{l = 2.0}} in question {entry['id']!r}")
    return Question(
        name=entry["id"],
        system=entry["system"],
        ask=str(entry.get("ask", "equation of motion")),
        points=float(points),
        form=float(form),
        let=tuple(let),
        parameters=parameters,
    )
