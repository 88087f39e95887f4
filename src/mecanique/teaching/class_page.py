"""The results of a class as a page: questions, frequent mistakes, and each student's marks."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from html import escape

from mecanique.teaching.marks import RULE, Grades
from mecanique.wording import say_count

_STYLE = """body { font: 16px/1.4 system-ui, sans-serif; margin: 2em auto; max-width: 60em; }
table { border-collapse: collapse; margin: 1em 0; }
th, td { border-bottom: 1px solid #ccc; padding: 0.3em 0.8em; text-align: left; }
td.number { text-align: right; white-space: nowrap; font-variant-numeric: tabular-nums; }
pre { margin: 0.2em 0 0.8em; white-space: pre-wrap; }
summary { cursor: pointer; }
@media print { details { break-inside: avoid; } }"""


def write_class_page(grades: Grades) -> str:
    """Return the results of a class as an HTML page without scripts."""
    sheet, totals = grades.sheet, grades.totals
    mean = sum(totals.values()) / len(totals) if totals else 0.0
    parts = [
        f"<h1>{escape(sheet.title)}</h1>",
        f"<p>{say_count(len(totals), 'student')}, {mean:.3g} of {sheet.points:g} points on "
        "average.</p>",
        "<h2>Questions</h2>",
        _table(("Question", "Asked", "Mean", "", "Outcomes"), _list_questions(grades)),
    ]
    if grades.frequent:
        mistakes = ((_cell(q), _cell(m), _number(n)) for q, m, n in grades.frequent)
        parts.append("<h2>Frequent mistakes</h2>")
        parts.append(_table(("Question", "Mistake", "Students"), mistakes))
    names = [question.name for question in sheet.questions]
    parts.append("<h2>Students</h2>")
    parts.append(_table(("Student", *names, "Points"), _list_students(grades)))
    parts += ["<h2>Reasons</h2>", *_explain_marks(grades)]
    parts.append(f"<p>{escape(RULE)}</p>")
    policy = "default-src 'none'; style-src 'unsafe-inline'"
    return (
        '<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        f'<meta http-equiv="Content-Security-Policy" content="{policy}">\n'
        f"<title>{escape(sheet.title)}</title>\n<style>\n{_STYLE}\n</style>\n</head>\n<body>\n"
        + "\n".join(parts)
        + "\n</body>\n</html>\n"
    )


def _list_questions(grades: Grades) -> Iterable[Sequence[str]]:
    for question in grades.sheet.questions:
        mean = grades.by_question[question.name]
        outcomes = Counter(m.outcome for m in grades.marks if m.question == question.name)
        said = ", ".join(f"{outcome}: {count}" for outcome, count in outcomes.most_common())
        meter = f'<td><meter value="{mean:.4g}" max="{question.points:g}"></meter></td>'
        asked = f"{question.ask} of {question.system}"
        points = f'<td class="number">{mean:.3g} of {question.points:g}</td>'
        yield _cell(question.name), _cell(asked), points, meter, _cell(said)


def _list_students(grades: Grades) -> Iterable[Sequence[str]]:
    for student, total in grades.totals.items():
        points = (_number(mark.points) for mark in grades.marks if mark.student == student)
        yield _cell(student), *points, _number(total)


def _explain_marks(grades: Grades) -> Iterable[str]:
    """Yield why each student lost points, to be opened."""
    for student in grades.totals:
        lost = [mark for mark in grades.marks if mark.student == student and mark.reason]
        if lost:
            reasons = "".join(
                f"<p>{escape(mark.question)}: {escape(mark.outcome)}</p>"
                f"<pre>{escape(mark.reason)}</pre>"
                for mark in lost
            )
            yield f"<details><summary>{escape(student)}</summary>{reasons}</details>"


def _table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = [f"<tr>{''.join(f'<th>{escape(name)}</th>' for name in head)}</tr>"]
    lines += [f"<tr>{''.join(cells)}</tr>" for cells in rows]
    return "<table>\n" + "\n".join(lines) + "\n</table>"


def _cell(text: str) -> str:
    return f"<td>{escape(text)}</td>"


def _number(value: float) -> str:
    return f'<td class="number">{value:g}</td>'
