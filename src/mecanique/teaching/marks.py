"""Grade answers to a sheet, with partial credit and reasons."""

from __future__ import annotations

import csv
import io
import re
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, final

from mecanique.checking.check import Checker
from mecanique.checking.verdict import Check
from mecanique.errors import FormulaError, InputError
from mecanique.model.mechanism import Mechanism
from mecanique.teaching.answers import Submission, collect, read_table, write_visibly
from mecanique.textbook.catalogue import load
from mecanique.wording import say_count

_FIELDS = {"id", "system", "ask", "points", "form", "let", "parameters"}


@final
@dataclass(frozen=True)
class Question:
    """One question."""

    name: str  # of the question, e.g. "1a"
    system: str  # name of a textbook system
    ask: str = "equation of motion"  # what is asked for, as in `mecanique.check`
    points: float = 1.0  # for a right answer
    form: float = 1.0  # part of the points for an answer that is right except for form, from 0 to 1
    let: tuple[str, ...] = ()  # definitions of letters that the question gives
    # values that differ from the catalogue's
    parameters: Mapping[str, float] = field(default_factory=dict)


@final
@dataclass(frozen=True)
class Sheet:
    """A sheet of questions."""

    title: str  # its title
    questions: tuple[Question, ...]  # in order
    step: float = 0.0  # to which points are rounded, e.g. 0.25 for quarter points; 0 for none

    @property
    def points(self) -> float:
        """All points."""
        return sum(question.points for question in self.questions)


def read_sheet(path: Path) -> Sheet:
    """Read a sheet from a TOML or JSON file with a title and a table for each question."""
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


RULE = (
    "A right answer gets all points, one that is right except for form the part that its question "
    "states, any other the share of its independent right equations among those asked or given."
)
"""The rule of partial credit."""

_ADVICE = re.compile(r'e\.g\. --let "([^"]*)"')


@final
@dataclass(frozen=True)
class Mark:
    """The mark of one answer."""

    student: str  # whose answer
    question: str  # name of the question
    points: float  # given
    possible: float  # points of the question
    # "right", "right except for form", "incomplete", "wrong", "unreadable" or "missing"
    outcome: str
    reason: str  # why points are missing, in a sentence or two; empty if none are


@final
@dataclass(frozen=True)
class Grades:
    """All marks of a sheet."""

    sheet: Sheet  # the sheet
    marks: tuple[Mark, ...]  # by student, then question

    @property
    def totals(self) -> dict[str, float]:
        """Sum of the points of each student."""
        points_of: dict[str, float] = {}
        for mark in self.marks:
            points_of[mark.student] = points_of.get(mark.student, 0.0) + mark.points
        return points_of

    @property
    def by_question(self) -> dict[str, float]:
        """Mean of the points for each question."""
        means = {}
        for question in self.sheet.questions:
            points = [mark.points for mark in self.marks if mark.question == question.name]
            means[question.name] = sum(points) / len(points) if points else 0.0
        return means

    @property
    def frequent(self) -> tuple[tuple[str, str, int], ...]:
        """The mistakes of more than one student: question, mistake and number, by number."""
        counts: Counter[tuple[str, str]] = Counter()
        for mark in self.marks:
            if mark.outcome not in ("missing", "unreadable"):
                said = {line.partition(": ")[2] or line for line in mark.reason.splitlines()}
                counts.update((mark.question, reason) for reason in sorted(said))
        return tuple((*key, count) for key, count in counts.most_common() if count > 1)

    def to_csv(self) -> str:
        """Return a table with a line for each answer."""
        out = io.StringIO()
        table = csv.writer(out, lineterminator="\n")
        table.writerow(["student", "question", "points", "of", "outcome", "reason"])
        for mark in self.marks:
            row = [mark.student, mark.question, f"{mark.points:g}", f"{mark.possible:g}"]
            table.writerow([_disarm(cell) for cell in (*row, mark.outcome, mark.reason)])
        return out.getvalue()

    def __str__(self) -> str:
        totals = self.totals
        width = max((len(name) for name in totals), default=0)
        lines = [f"{self.sheet.title}: {say_count(len(totals), 'student')}"]
        for student, points in totals.items():
            lines.append(f"{student:{width}}  {points:g} of {self.sheet.points:g}")
            for mark in self.marks:
                if mark.student == student:
                    lines.append(f"  {mark.question}: {mark.points:g}  {mark.outcome}")
                    lines += [f"      {line}" for line in mark.reason.splitlines()]
        lines.append("On the average")
        for question in self.sheet.questions:
            mean = self.by_question[question.name]
            lines.append(f"  {question.name}: {mean:.3g} of {question.points:g}")
        if self.frequent:
            lines.append("Frequent mistakes")
        for name, reason, count in self.frequent:
            lines.append(f"  {name}: {reason} ({count} students)")
        lines.append(RULE)
        return "\n".join(lines)


def grade(
    sheet: Path | str, answers: Path | str, progress: Callable[[float], None] | None = None
) -> Grades:
    """Grade the answers in a folder."""
    # a folder per student with files like anna/1a.txt, or a table per student like anna.toml with
    # 1a = "…"; whatever cannot be read gets a mark with the reason
    questions = read_sheet(Path(sheet))
    students = collect(Path(answers), [question.name for question in questions.questions])
    if not students:
        raise InputError(
            f"expected a folder or a .toml for each student in {str(answers)!r}, found none"
        )
    checkers: dict[str, Checker] = {}
    for question in questions.questions:
        checkers[question.name] = Checker(_mechanism(question))
    marks = []
    for number, submission in enumerate(students, 1):
        for question in questions.questions:
            marks.append(_grade(question, checkers[question.name], submission, questions.step))
        if progress is not None:
            progress(number / len(students))
    return Grades(questions, tuple(marks))


def _grade(question: Question, checker: Checker, submission: Submission, step: float) -> Mark:
    """Return the mark of one answer; what cannot be read gets none and says why."""

    def mark(part: float, outcome: str, reason: str) -> Mark:
        points = part * question.points
        if step and part < 1:
            points = min(question.points, round(points / step) * step)
        points = round(points, 4)
        return Mark(
            student=submission.student,
            question=question.name,
            points=points,
            possible=question.points,
            outcome=outcome,
            reason=write_visibly(reason),
        )

    fault = submission.fault or submission.faults.get(question.name)
    text = submission.texts.get(question.name, "")
    if fault:
        return mark(0.0, "unreadable", fault)
    if not text.strip():
        return mark(0.0, "missing", "no answer")
    try:
        verdict = checker.check(text, question.ask, question.let)
    except FormulaError as error:
        # a student has no command line, but may define a letter in a line
        return mark(0.0, "unreadable", _ADVICE.sub(r"e.g. in a line \1", str(error)))
    return mark(_credit(verdict, checker.mechanism, question), verdict.outcome, _explain(verdict))


def _credit(verdict: Check, mechanism: Mechanism, question: Question) -> float:
    """The part of the points: by equation, less for those that are right except for form."""
    if verdict.outcome == "right":
        return 1.0
    if verdict.outcome == "right except for form":
        return question.form
    if question.ask != "equation of motion":
        worth = [line.outcome != "wrong" for line in verdict.lines]
        return sum(worth) / len(worth) if len(worth) > 1 else 0.0
    worth_of = {"right": 1.0, "right except for form": question.form}
    credit = sum(worth_of.get(line.outcome, 0.0) for line in verdict.lines)
    # equations that follow from each other count once
    credit = min(credit, verdict.independent)
    return min(1.0, credit / max(mechanism.nv, len(verdict.lines)))


def _explain(verdict: Check) -> str:
    """What is missing or wrong, one line for each equation: its likeliest cause."""
    lines = list(verdict.forms)
    for number, line in enumerate(verdict.lines, 1):
        if line.outcome != "wrong":
            continue
        place = f"equation {number}: " if len(verdict.lines) > 1 else ""
        cause = line.causes[0].text if line.causes else "wrong; no single mistake explains it"
        lines.append(f"{place}{cause}")
    return "\n".join(lines)


def _mechanism(question: Question) -> Mechanism:
    return load(question.system, **question.parameters)


def _disarm(cell: str) -> str:
    """Return a cell that no spreadsheet takes for a formula of its own."""
    # full-width signs open a formula, too, and blanks before a sign do not hide it
    armed = cell.lstrip()[:1] in tuple("=+-@＝＋－＠") or cell[:1] == "\t"
    return f"'{cell}" if armed else cell
