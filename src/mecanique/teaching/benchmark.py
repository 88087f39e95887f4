"""A benchmark of tasks made by seed from systems and kinds of questions, judged without a key.

A task is an exercise without its answer. Its number says how it is made again, so that an answer is
judged by the mechanism itself, as `mecanique.check` judges any; no answers are kept anywhere.
"""

from __future__ import annotations

import json
import random
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import lru_cache
from itertools import count, islice
from pathlib import Path
from typing import final

from mecanique.errors import InputError, MecaniqueError
from mecanique.teaching.answers import KINDS
from mecanique.teaching.exercise import Exercise, make_exercise
from mecanique.teaching.marks import mark_answer
from mecanique.textbook.catalogue import names

_HOW = (
    "Answer with formulas alone, one equation or value per line, in plain text or LaTeX; q' and "
    "q'' are derivatives by the time. Use the letters above."
)


@final
@dataclass(frozen=True)
class Task:
    """A task: what is asked, without the answer."""

    name: str  # system/kind/seed, by which it is made again
    prompt: str  # the whole text, in Markdown


@final
@dataclass(frozen=True)
class Score:
    """How answers fare: points from 0 to 1 for each task."""

    points: Mapping[str, float]  # by name of the task

    @property
    def mean(self) -> float:
        """The mean of all points."""
        return sum(self.points.values()) / len(self.points)

    def __str__(self) -> str:
        kinds: dict[str, list[float]] = {}
        for name, points in self.points.items():
            kinds.setdefault(name.split("/")[1], []).append(points)
        lines = [f"{self.mean:.1%} of {len(self.points)} tasks"]
        wide = max(map(len, kinds), default=0)
        for kind, listed in sorted(kinds.items()):
            lines.append(f"  {kind:{wide}}{sum(listed) / len(listed):7.1%} of {len(listed)}")
        return "\n".join(lines)


def make_tasks(number: int = 1000, seed: int = 0) -> Iterator[Task]:
    """Yield tasks by seed: each kind of question about each system, then further variants."""
    draw = random.Random(f"benchmark {seed}")
    pairs = [(system, kind) for system in names() for kind in KINDS]
    yield from islice(_list_tasks(pairs, draw), number)


def _list_tasks(pairs: list[tuple[str, str]], draw: random.Random) -> Iterator[Task]:
    possible = list(pairs)
    for _ in count():
        draw.shuffle(possible)
        for system, kind in tuple(possible):
            name = f"{system}/{kind}/{draw.randrange(10**6)}"
            try:
                problem = _make(name).problem
            except MecaniqueError:
                possible.remove((system, kind))  # this question has no answer there
                continue
            text = problem.replace("![The system](figure.svg)\n\n", "")
            yield Task(name, f"{text}\n{_HOW}\n")


@lru_cache(maxsize=64)
def _make(name: str) -> Exercise:
    """Make the exercise of a task again."""
    system, _, rest = name.partition("/")
    kind, _, seed = rest.partition("/")
    if not seed.isdecimal():
        raise InputError(f"expected a task's name such as cart_pole/energy/7, got {name!r}")
    return make_exercise(system, kind, int(seed))


def score_answers(tasks: Iterable[str], answers: Mapping[str, str]) -> Score:
    """Score answers by the names of their tasks; a task without an answer gets nothing.

    Raises:
        InputError: if an answer belongs to none of the tasks, or a task's name says nothing.
    """
    points = {}
    for name in tasks:
        exercise, text = _make(name), answers.get(name, "")
        mark = mark_answer(exercise.mechanism, text, exercise.ask, exercise.form)
        points[name] = mark.points
    if not points:
        raise InputError("expected at least one task")
    if unknown := sorted(answers.keys() - points.keys()):
        raise InputError(f"an answer belongs to none of the tasks: {unknown[0]!r}")
    return Score(points)


def write_lines(tasks: Iterable[Task]) -> str:
    """Return tasks as lines of JSON with id and prompt."""
    entries = ({"id": task.name, "prompt": task.prompt} for task in tasks)
    return "".join(f"{json.dumps(entry, ensure_ascii=False)}\n" for entry in entries)


def read_lines(path: Path, field: str) -> dict[str, str]:
    """Return a field of each line of JSON, by id."""
    values: dict[str, str] = {}
    for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
        try:
            entry = json.loads(line)
            name, value = entry["id"], entry[field]
        except (ValueError, KeyError, TypeError):
            raise InputError(
                f'expected {{"id": …, "{field}": …}} in line {number} of {path.name}'
            ) from None
        if name in values:
            raise InputError(f"task {name!r} stands twice in {path.name}")
        values[str(name)] = str(value)
    return values
