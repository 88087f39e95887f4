"""Export exercises to learning platforms: judging pages, SCORM, STACK, PrairieLearn, nbgrader."""

from __future__ import annotations

import base64
import hashlib
import html
import json
import re
import uuid
from collections.abc import Callable, Sequence
from importlib.resources import files
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any
from xml.sax.saxutils import escape
from zipfile import ZIP_DEFLATED, ZipFile

from mecanique.errors import InputError, UnknownNameError
from mecanique.files import write_whole
from mecanique.teaching.exercise import Exercise, make_exercise
from mecanique.teaching.question import describe_question
from mecanique.teaching.stack import write_stack


def export_exercise(
    system: str,
    course: str,
    path: Path | str,
    ask: str = "equation of motion",
    seeds: Sequence[int] = (0,),
) -> Path:
    """Write an exercise in the form a learning platform imports; return the file or folder.

    Args:
        system: name of a textbook system.
        course: "page" (HTML that judges by itself), "scorm" (the same as SCORM 1.2), "stack"
            (Moodle's XML), "prairielearn" (a folder with question and element) or "nbgrader".
        path: of the file; of the folder for PrairieLearn.
        ask: what is asked for, as in `make_exercise`.
        seeds: of the variants; a page and a notebook hold one.

    Raises:
        UnknownNameError: if there is no such course, system or question.
        InputError: if the course's software cannot judge the question, with the reason.
    """
    if course not in _COURSES:
        raise UnknownNameError("kind of course", course, tuple(_COURSES))
    made = [make_exercise(system, ask, seed, turned=False) for seed in seeds]
    place = Path(path)
    # a question in numbers names its equilibrium
    if len(made) > 1 and (course in ("page", "scorm", "nbgrader") or made[0].rounded):
        raise InputError(f"expected one seed for {course}, got {len(made)}; write a file for each")
    _COURSES[course](made, place)
    return place


def _write(place: Path, data: str | bytes) -> None:
    place.parent.mkdir(parents=True, exist_ok=True)
    with write_whole(place) as file:
        file.write(data.encode() if isinstance(data, str) else data)


def draw_figure(exercise: Exercise) -> str:
    """Return the figure of an exercise, as SVG."""
    with TemporaryDirectory() as folder:
        exercise.write(folder)
        return Path(folder, "figure.svg").read_text(encoding="utf-8")


def problem_html(exercise: Exercise, figure: str) -> str:
    """Return the text of an exercise as HTML, with its figure."""
    parts = []
    for part in exercise.problem.strip().split("\n\n"):
        if part.startswith("!["):
            parts.append(figure)
        elif part.startswith("# "):
            parts.append(f"<h1>{html.escape(part[2:])}</h1>")
        elif part.startswith("**"):
            parts.append(f"<p><strong>{html.escape(part.strip('*'))}</strong></p>")
        else:
            parts.append(f"<p>{html.escape(part)}</p>")
    return "\n".join(parts)


def write_page(exercise: Exercise) -> str:
    """Return an HTML page that judges answers to an exercise without a server."""
    if exercise.rounded:
        system = exercise.mechanism.name
        raise InputError(
            f"no page judges the {exercise.ask} of {system!r} by itself: it is asked for in numbers"
        )
    question = describe_question(exercise.mechanism, exercise.ask)
    question |= {"id": exercise.mechanism.name, "form": exercise.form}
    modules = [_asset(name) for name in ("reader.js", "judge.js", "page.js")]
    script = "\n".join(re.sub(r"^(import .*;|export )", "", text, flags=re.M) for text in modules)
    style, figure = _asset("page.css"), draw_figure(exercise)
    rates = [v for v in exercise.mechanism.velocities if v.endswith("'")]
    parts = {
        "policy": f"default-src 'none'; script-src '{_hash(script)}'; style-src 'unsafe-inline'",
        "title": html.escape(exercise.title),
        "style": style,
        "problem": problem_html(exercise, figure[figure.index("<svg") :]),
        "hint": " and ".join(f"{rates[0]}{dots}" for dots in ("", "'")) if rates else "x' and x''",
        # no text of a question ends the element that holds it
        "question": json.dumps(question, separators=(",", ":")).replace("<", "\\u003c"),
        "script": script,
    }
    template = _asset("page.html")
    template = template.replace("\n      {script}\n    ", "{script}")
    return re.sub(r"\{(\w+)\}", lambda match: parts[match[1]], template)


def _asset(name: str) -> str:
    return (files("mecanique.teaching") / "assets" / name).read_text(encoding="utf-8")


def _hash(text: str) -> str:
    return f"sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}"


def _export_page(made: Sequence[Exercise], place: Path) -> None:
    _write(place, write_page(made[0]))


_MANIFEST = """<?xml version="1.0" encoding="UTF-8"?>
<manifest identifier="{identifier}" version="1.2"
    xmlns="http://www.imsproject.org/xsd/imscp_rootv1p1p2"
    xmlns:adlcp="http://www.adlnet.org/xsd/adlcp_rootv1p2">
  <metadata><schema>ADL SCORM</schema><schemaversion>1.2</schemaversion></metadata>
  <organizations default="course">
    <organization identifier="course">
      <title>{title}</title>
      <item identifier="item" identifierref="page">
        <title>{title}</title>
        <adlcp:masteryscore>100</adlcp:masteryscore>
      </item>
    </organization>
  </organizations>
  <resources>
    <resource identifier="page" type="webcontent" adlcp:scormtype="sco" href="index.html">
      <file href="index.html"/>
    </resource>
  </resources>
</manifest>
"""


def _export_scorm(made: Sequence[Exercise], place: Path) -> None:
    """Write the page with its manifest, as one archive."""
    (exercise,) = made
    page = write_page(exercise)
    identifier = f"mecanique-{exercise.mechanism.name}-{_name(page)}"
    manifest = _MANIFEST.format(identifier=identifier, title=escape(exercise.title))
    place.parent.mkdir(parents=True, exist_ok=True)
    with write_whole(place) as file, ZipFile(file, "w", ZIP_DEFLATED) as archive:
        archive.writestr("imsmanifest.xml", manifest)
        archive.writestr("index.html", page)


def _name(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()[:12]


def _export_stack(made: Sequence[Exercise], place: Path) -> None:
    problem = problem_html(
        made[0], '<p><img src="@@PLUGINFILE@@/figure.svg" alt="The system"/></p>'
    )
    # each variant has its numbers; the text names the letters
    problem = re.sub(r"<p>Given: .*?</p>", "<p>Given: {@given@}.</p>", problem)
    figure = base64.b64encode(draw_figure(made[0]).encode()).decode()
    _write(place, write_stack(made, problem, figure))


# --- PrairieLearn

_ELEMENT = '''"""A field for equations, judged by mecanique."""

import html

import mecanique as mq
from mecanique.teaching import mark_answer


def _mark(data):
    mechanism = mq.textbook.load(data["params"]["system"], **data["params"]["values"])
    text = data["submitted_answers"].get("equation", "")
    return mark_answer(mechanism, text, data["params"]["ask"], data["params"]["form"])


def render(element_html, data):
    if data["panel"] == "answer":
        return f"<pre>{html.escape(data['correct_answers'].get('equation', ''))}</pre>"
    text = html.escape(data["submitted_answers"].get("equation", ""))
    said = data["format_errors"].get("equation", "")
    said = said or data["partial_scores"].get("equation", {}).get("feedback", "")
    said = f"<pre>{html.escape(said)}</pre>" if said else ""
    if data["panel"] == "submission":
        return f"<pre>{text}</pre>{said}"
    return f'<textarea name="equation" class="form-control" rows="4">{text}</textarea>{said}'


def parse(element_html, data):
    mark = _mark(data)
    if mark.outcome in ("unreadable", "missing"):
        data["format_errors"]["equation"] = mark.reason


def grade(element_html, data):
    mark = _mark(data)
    result = {"score": mark.points, "weight": 1, "feedback": mark.reason}
    data["partial_scores"]["equation"] = result
'''

_SERVER = """import random

VARIANTS = {variants}


def generate(data):
    variant = random.Random(data["variant_seed"]).choice(VARIANTS)
    data["params"].update(variant)
    data["correct_answers"]["equation"] = variant["answer"]
"""


def _export_prairielearn(made: Sequence[Exercise], place: Path) -> None:
    """Write a course's folders: the element, and the question with its variants."""
    exercise = made[0]
    name = f"mecanique-{exercise.mechanism.name}-{exercise.ask.replace(' ', '-')}"
    element, question = place / "elements" / "mq-equation", place / "questions" / name
    _write(element / "info.json", json.dumps({"controller": "mq-equation.py"}, indent=2))
    _write(element / "mq-equation.py", _ELEMENT)
    info = {
        "uuid": str(uuid.uuid5(uuid.NAMESPACE_URL, f"mecanique/{name}")),
        "title": exercise.title,
        "topic": "Analytical mechanics",
        "type": "v3",
    }
    figure = '<pl-figure file-name="figure.svg"></pl-figure>'
    problem = problem_html(exercise, figure)
    problem = re.sub(r"<p>Given: .*?</p>", "<p>Given: {{params.given}}.</p>", problem)
    text = f"<pl-question-panel>\n{problem}\n</pl-question-panel>\n<mq-equation></mq-equation>\n"
    variants = [
        {
            "system": variant.mechanism.name,
            "ask": variant.ask,
            "values": variant.mechanism.values,
            "form": variant.form,
            "answer": variant.answer,
            "given": variant.given,
        }
        for variant in made
    ]
    _write(question / "info.json", json.dumps(info, indent=2))
    _write(question / "question.html", text)
    _write(question / "server.py", _SERVER.format(variants=repr(variants)))
    _write(question / "clientFilesQuestion" / "figure.svg", draw_figure(exercise))


# --- nbgrader

_TESTS = """### BEGIN HIDDEN TESTS
import mecanique as mq
from mecanique.teaching import mark_answer

mark = mark_answer(mq.textbook.load({system!r}, **{values!r}), answer, {ask!r}, {form})
print(mark.outcome, mark.reason)
{points} * mark.points
### END HIDDEN TESTS"""
_ANSWER = '''# Assign your equations to the name answer, one a line.
### BEGIN SOLUTION
answer = r"""{answer}"""
### END SOLUTION'''


def _export_nbgrader(made: Sequence[Exercise], place: Path) -> None:
    """Write a notebook of nbgrader: the problem, a cell for the answer, and its hidden tests."""
    (exercise,) = made
    name, points = exercise.mechanism.name, 2
    figure = base64.b64encode(draw_figure(exercise).encode()).decode()
    problem = exercise.problem.replace("(figure.svg)", f"(data:image/svg+xml;base64,{figure})")
    values, form = exercise.mechanism.values, exercise.form
    tests = _TESTS.format(system=name, values=values, ask=exercise.ask, form=form, points=points)
    answer = _ANSWER.format(answer=exercise.answer)
    cells = [
        _cell("markdown", f"{name}-problem", problem, locked=True),
        _cell("code", f"{name}-answer", answer, solution=True),
        _cell("code", f"{name}-tests", tests, locked=True, grade=True, points=points),
    ]
    kernel = {"display_name": "Python 3", "language": "python", "name": "python3"}
    notebook = {
        "cells": cells,
        "metadata": {"kernelspec": kernel},
        "nbformat": 4,
        "nbformat_minor": 5,
    }
    _write(place, json.dumps(notebook, indent=1, ensure_ascii=False) + "\n")


def _cell(kind: str, name: str, source: str, **settings: Any) -> dict[str, Any]:
    graded = {"grade_id": name, "locked": False, "grade": False, "solution": False, "task": False}
    cell: dict[str, Any] = {
        "cell_type": kind,
        "id": _name(name),
        "metadata": {"nbgrader": {"schema_version": 3, **graded, **settings}},
        "source": source.splitlines(keepends=True),
    }
    if kind == "code":
        cell |= {"execution_count": None, "outputs": []}
    return cell


_COURSES: dict[str, Callable[[Sequence[Exercise], Path], None]] = {
    "page": _export_page,
    "scorm": _export_scorm,
    "stack": _export_stack,
    "prairielearn": _export_prairielearn,
    "nbgrader": _export_nbgrader,
}

COURSES = tuple(_COURSES)
"""Formats of learning platforms that an exercise can be written in."""
