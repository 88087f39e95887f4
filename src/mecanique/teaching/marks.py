"""Grade answers to a sheet, with partial credit and reasons.

Answers of a class are read so that what one student hands in never stops the others.
"""

from __future__ import annotations

import codecs
import csv
import io
import json
import os
import re
import stat
import sys
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, final
from unicodedata import category

from mecanique.checking.check import Checker, checker_of
from mecanique.checking.verdict import Check
from mecanique.errors import FormulaError, InputError
from mecanique.model.mechanism import Mechanism
from mecanique.textbook.catalogue import load
from mecanique.wording import say_count

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

_TEXTS = (".txt", ".tex", ".mml", ".md")
_TABLES = (".toml", ".json")
_LONGEST_TEXT, _LONGEST_TABLE = 80_000, 1_000_000
"""Bytes; the checker takes 20,000 characters."""


@final
@dataclass(frozen=True)
class Submission:
    """What a student handed in."""

    student: str  # the name, of the folder or of the table
    texts: dict[str, str] = field(default_factory=dict)  # the answers, by question
    # why an answer cannot be read, by question
    faults: dict[str, str] = field(default_factory=dict)
    fault: str = ""  # why none can, or ""


def read_table(path: Path) -> dict[str, Any]:
    """Return what a TOML or JSON file holds."""
    text = _read(path, _LONGEST_TABLE)
    try:
        if path.suffix.lower() == ".json":
            table = json.loads(text, object_pairs_hook=_unite)
        else:
            table = tomllib.loads(text)
    except RecursionError:
        raise InputError(f"{_name(path)} cannot be read: it is nested too deeply") from None
    except ValueError as error:
        raise InputError(f"{_name(path)} cannot be read: {error}") from None
    if not isinstance(table, dict):
        raise InputError(f"expected a table in {_name(path)}, got a {type(table).__name__}")
    return table


def collect(folder: Path, questions: Sequence[str]) -> list[Submission]:
    """Return what each student handed in, by name, from a folder of folders or tables."""
    if not folder.is_dir():
        raise InputError(f"expected a folder of answers, got {str(folder)!r}")
    places: dict[str, list[Path]] = {}
    for path in sorted(folder.iterdir(), key=lambda path: os.fsencode(path.name)):
        if path.name.startswith((".", "__MACOSX")):
            continue  # what file managers and archives leave behind
        if path.suffix.lower() in _TABLES and not _is_folder(path):
            places.setdefault(_display(path.stem), []).append(path)
        elif _is_folder(path) or path.is_symlink():
            places.setdefault(_display(path.name), []).append(path)
    return [_submission(student, folders, questions) for student, folders in places.items()]


def _submission(student: str, places: list[Path], questions: Sequence[str]) -> Submission:
    try:
        path = _only(places)
        if _is_folder(path):
            return _read_folder(student, path, questions)
        table = read_table(path)
    except (InputError, OSError) as error:
        return Submission(student, fault=str(error))
    texts, faults = {}, {}
    for question in questions:
        value = table.get(question, "")
        if isinstance(value, (str, int, float)):
            texts[question] = str(value)
        else:
            faults[question] = f"expected a text in {_name(path)}, got a {type(value).__name__}"
    return Submission(student, texts, faults)


def _read_folder(student: str, folder: Path, questions: Sequence[str]) -> Submission:
    places: dict[str, list[Path]] = {}
    texts, faults = {}, {}
    by_name = {question.casefold(): question for question in questions}
    for path in sorted(folder.iterdir()):
        question = path.stem if path.stem in questions else by_name.get(path.stem.casefold(), "")
        if question and path.suffix.lower() in _TEXTS:
            places.setdefault(question, []).append(path)
        elif question:
            faults[question] = f"expected a text ({', '.join(_TEXTS)}), got {_name(path)}"
    for question, paths in places.items():
        try:
            texts[question] = _read(_only(paths), _LONGEST_TEXT)
            faults.pop(question, None)
        except (InputError, OSError) as error:
            faults[question] = str(error)
    return Submission(student, texts, faults)


def _only(places: list[Path]) -> Path:
    """Return the one place of several; whichever of two is meant is not guessed."""
    if len(places) > 1:
        raise InputError(f"expected one of {', '.join(map(_name, places))}, got them all")
    if places[0].is_symlink():
        raise InputError(f"{_name(places[0])} is a link; links are not followed")
    return places[0]


def _read(path: Path, most: int) -> str:
    # a pipe or a device would make an ordinary open wait, or never end
    waiting = getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0)
    try:
        descriptor = os.open(path, os.O_RDONLY | waiting)
        with os.fdopen(descriptor, "rb") as file:
            if not stat.S_ISREG(os.fstat(descriptor).st_mode):
                raise InputError(f"{_name(path)} is no regular file")
            data = file.read(most + 1)
    except IsADirectoryError:
        raise InputError(f"{_name(path)} is a folder, not a file") from None
    except OSError as error:
        raise InputError(f"{_name(path)} cannot be read: {error.strerror}") from None
    if len(data) > most:
        raise InputError(f"{_name(path)} is longer than {most:,} bytes")
    return _decode(data, path)


def _decode(data: bytes, path: Path) -> str:
    """Return a file's text: UTF-8, UTF-16, or an answer from an old editor."""
    code = "utf-8-sig"
    if data.startswith((codecs.BOM_UTF32_LE, codecs.BOM_UTF32_BE)):
        code = "utf-32"  # whose mark begins as that of UTF-16
    elif data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        code = "utf-16"
    elif b"\0" in data:
        halves = {"utf-16-le": data[1::2], "utf-16-be": data[::2]}
        code = next((c for c, half in halves.items() if 2 * half.count(0) > len(half)), "")
        if not code:
            raise InputError(f"{_name(path)} is no text; save it as UTF-8")
    try:
        return data.decode(code)
    except UnicodeDecodeError:
        if code != "utf-8-sig" or path.suffix.lower() in _TABLES:
            raise InputError(f"{_name(path)} cannot be read: it is not UTF-8") from None
    return data.decode("cp1252", "replace")


def _unite(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """Return a table of JSON, in which no name may stand twice."""
    table = dict(pairs)
    if len(table) < len(pairs):
        names = [name for name, _ in pairs]
        twice = next(name for name in names if names.count(name) > 1)
        raise ValueError(f"{twice!r} stands twice")
    return table


def _is_folder(path: Path) -> bool:
    return path.is_dir() and not path.is_symlink()


def _name(path: Path) -> str:
    return _display(path.name)


def _display(name: str) -> str:
    """Return a file's name as text, with escapes for bytes that are not UTF-8."""
    return write_visibly(os.fsencode(name).decode("utf-8", "backslashreplace"))


def write_visibly(text: str) -> str:
    """Return a text with control characters and halves of surrogates written as escapes."""
    return "".join(
        c if c in "\n\t" or category(c) not in ("Cc", "Cs") else f"\\x{ord(c):02x}" for c in text
    )


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


def make_sheet(table: Mapping[str, Any], where: str) -> Sheet:
    """Return the sheet that a table describes; errors say where it stands."""
    listed = table.get("question")
    if not isinstance(listed, list) or not listed:
        raise InputError(f"expected at least one [[question]] in {where}")
    questions = tuple(_question(entry, where) for entry in listed)
    names = [question.name for question in questions]
    for name in names:
        if names.count(name) > 1:
            raise InputError(f"question {name!r} stands twice in {where}")
    return Sheet(str(table.get("title", "")), questions, _number_of(table, "step", 0.0, 1.0, where))


def _number_of(
    table: Mapping[str, Any], name: str, default: float, most: float, where: str
) -> float:
    """Return a number of a table, from 0 to the largest that it may be."""
    value = table.get(name, default)
    if not isinstance(value, (int, float)) or isinstance(value, bool) or not 0 <= value <= most:
        raise InputError(f"expected {name} from 0 to {most:g} in {where}, got {value!r}")
    return float(value)


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
    here = f"question {entry['id']!r}"
    points = _number_of(entry, "points", 1.0, 1e6, here)
    form = _number_of(entry, "form", 1.0, 1.0, here)
    let, parameters = entry.get("let", []), entry.get("parameters", {})
    if not isinstance(let, list) or not all(isinstance(definition, str) for definition in let):
        raise InputError(f'expected let = ["J = …"] in {here}, got {let!r}')
    if not isinstance(parameters, dict):
        raise InputError(f"expected parameters = {{l = 2.0}} in {here}")
    return Question(
        name=entry["id"],
        system=entry["system"],
        ask=str(entry.get("ask", "equation of motion")),
        points=points,
        form=form,
        let=tuple(let),
        parameters=parameters,
    )


RULE = (
    "A right answer gets all points, one that is right except for form the part that its question "
    "states, any other the share of its independent right equations among those asked or given."
)
"""The rule of partial credit."""

_NUMBER = re.compile(r"^equation \d+: ")
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
                said = {_NUMBER.sub("", line) for line in mark.reason.splitlines()}
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
    path = Path(sheet)
    questions = make_sheet({"title": path.stem, **read_table(path)}, path.name)
    students = collect(Path(answers), [question.name for question in questions.questions])
    if not students:
        raise InputError(
            f"expected a folder or a .toml for each student in {str(answers)!r}, found none"
        )
    return grade_submissions(questions, students, progress)


def grade_submissions(
    sheet: Sheet, students: Sequence[Submission], progress: Callable[[float], None] | None = None
) -> Grades:
    """Grade what students handed in."""
    checkers = {
        question.name: Checker(
            load(question.system, **question.parameters), given=question.parameters
        )
        for question in sheet.questions
    }
    marks = []
    for number, submission in enumerate(students, 1):
        for question in sheet.questions:
            marks.append(_grade(question, checkers[question.name], submission, sheet.step))
        if progress is not None:
            progress(number / len(students))
    return Grades(sheet, tuple(marks))


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
    if fault:
        return mark(0.0, "unreadable", fault)
    text = submission.texts.get(question.name, "")
    part, outcome, reason = _judge(checker, text, question.ask, question.let, question.form)
    return mark(part, outcome, reason)


def mark_answer(
    mechanism: Mechanism, text: str, ask: str = "equation of motion", form: float = 0.5
) -> Mark:
    """Return the mark of one answer, of one point, for learning platforms."""
    part, outcome, reason = _judge(checker_of(mechanism), text, ask, (), form)
    return Mark("", ask, round(part, 4), 1.0, outcome, write_visibly(reason))


def _judge(
    checker: Checker, text: str, ask: str, let: Sequence[str], form: float
) -> tuple[float, str, str]:
    """Return the part of the points, the outcome and the reason of an answer."""
    if not text.strip():
        return 0.0, "missing", "no answer"
    try:
        verdict = checker.check(text, ask, let)
    except FormulaError as error:
        # a student has no command line, but may define a letter in a line
        return 0.0, "unreadable", _ADVICE.sub(r"e.g. in a line \1", str(error))
    return _credit(verdict, form), verdict.outcome, _explain(verdict)


def _credit(verdict: Check, form: float) -> float:
    """The part of the points: by equation, less for those that are right except for form."""
    if verdict.outcome == "right":
        return 1.0
    if verdict.outcome == "right except for form":
        return form
    worth_of = {"right": 1.0, "right except for form": form}
    credit = sum(worth_of.get(line.outcome, 0.0) for line in verdict.lines)
    # equations that follow from each other count once
    credit = min(credit, verdict.independent)
    return min(1.0, credit / max(verdict.needed, len(verdict.lines)))


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


def _disarm(cell: str) -> str:
    """Return a cell that no spreadsheet takes for a formula of its own."""
    # full-width signs open a formula, too, and blanks before a sign do not hide it
    armed = cell.lstrip()[:1] in tuple("=+-@＝＋－＠") or cell[:1] == "\t"
    return f"'{cell}" if armed else cell
