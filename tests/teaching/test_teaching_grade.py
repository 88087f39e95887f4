"""Sheets graded: points by equation, reasons, and every refusal."""

from __future__ import annotations

import csv
import io
import json
import os
import re
from pathlib import Path
from xml.etree import ElementTree

import pytest
from click.testing import CliRunner

import mecanique as mq
from mecanique.cli import app
from mecanique.teaching import grade, write_class_page
from mecanique.teaching.marks import mark_answer

SHEET = """
title = "Sheet 1"

[[question]]
id = "1a"
system = "rigid_bar_pendulum"
points = 2
form = 0.5
let = ["J = m l^2/3"]

[[question]]
id = "1b"
system = "rigid_bar_pendulum"
ask = "frequency"
points = 1

[[question]]
id = "2"
system = "cart_pole"
points = 4
"""
CART = "(M + m) x'' + l m cos(q) q'' - l m sin(q) q'^2 + c x' = F"
POLE = "cos(q) x'' + l q'' + g sin(q) = 0"


@pytest.fixture
def course(tmp_path: Path) -> Path:
    (tmp_path / "sheet.toml").write_text(SHEET, encoding="utf-8")
    answers = {
        "anna": {
            "1a.txt": "J q'' + m g l/2 sin q = 0",
            "1b.tex": r"\omega = \sqrt{\frac{3 g}{2 l}}",
            "2.txt": f"{POLE}\n{CART}",
        },
        "ben": {
            "1a.txt": "J q'' + m g l/2 q = 0",
            "1b.txt": "sqrt(2 g/(3 l))",
            "2.txt": f"{CART}\n{POLE.replace('+ g', '- g')}",
        },
        "cleo": {"1a.txt": "J q'' + (m g", "2.txt": CART},
    }
    for student, texts in answers.items():
        folder = tmp_path / "answers" / student
        folder.mkdir(parents=True)
        for name, text in texts.items():
            (folder / name).write_text(text, encoding="utf-8")
    return tmp_path


def test_points_go_by_independent_right_equations(course: Path) -> None:
    for name, text in (("dora", "1 = 2\n" + "0 = 0\n" * 6), ("eli", f"{POLE}\n{POLE}\n1 = 2")):
        folder = course / "answers" / name
        folder.mkdir()
        (folder / "2.txt").write_text(text, encoding="utf-8")
    totals = grade(course / "sheet.toml", course / "answers").totals
    assert totals["dora"] == 0.0
    assert totals["eli"] == pytest.approx(4 / 3, abs=1e-4)


@pytest.mark.parametrize(
    ("system", "ask", "text", "points"),
    [
        # a line that is repeated counts once, and so does what is missing
        ("coupled_pendulums", "frequency", "omega^2 = g/l\nomega = sqrt(g/l)", 0.5),
        ("simple_pendulum", "equilibrium", "q = 0\nq = 0\nq = 0\nq = 1", 0.25),
        ("simple_pendulum", "potential energy", "1 = 2\n0 = 0\nV = m g l (1 - cos q)", 1 / 3),
        ("simple_pendulum", "potential energy", "1 = 2\n0 = 0", 0.0),
        ("two_link_arm", "equilibrium force", "tau2 = m2 g l2 cos(q1 + q2)/2", 0.5),
        ("simple_pendulum", "Hamilton's equations", "q' = p/(m l^2)\nq' = p/(m l^2)", 0.5),
        # the same motion backwards is no other; fast and slow precession are two
        ("spherical_pendulum", "steady motion", "phi' = sqrt(g/(l cos(theta)))", 1.0),
        (
            *("heavy_top", "steady motion"),
            "phi' = (-r^2 psi' + sqrt(r^4 psi'^2 + 5 g h (r^2 - 4 h^2) cos theta))"
            "/((r^2 - 4 h^2) cos theta)",
            0.5,
        ),
        ("two_blocks", "mass matrix", "[[m1, 0], [0, 2 m2]]", 0.75),
    ],
)
def test_points_of_quantities_go_by_what_is_asked(
    system: str, ask: str, text: str, points: float
) -> None:
    mark = mark_answer(mq.textbook.load(system), text, ask)
    assert mark.points == pytest.approx(points, abs=1e-4)


def test_points_go_by_equation_and_reasons_are_given(course: Path) -> None:
    found = grade(course / "sheet.toml", course / "answers")
    assert found.totals == {"anna": 7.0, "ben": 3.0, "cleo": 2.0}
    marks = {(mark.student, mark.question): mark for mark in found.marks}
    assert marks["ben", "1a"].outcome == "right except for form"
    assert marks["ben", "1a"].points == 1.0
    assert marks["ben", "1a"].reason == "linearized"
    assert marks["ben", "1b"].points == 0.0
    assert marks["ben", "2"].reason.startswith("equation 2: the sign of")
    assert marks["cleo", "1a"].outcome == "unreadable"
    assert "( is not closed" in marks["cleo", "1a"].reason
    assert marks["cleo", "1b"].reason == "no answer"
    assert marks["cleo", "2"].reason == "1 of 2 equations missing"
    assert "anna  7 of 7" in str(found)


def test_a_table_for_each_student_and_a_json_sheet_will_do(tmp_path: Path) -> None:
    question = {"id": "1", "system": "rigid_bar_pendulum", "parameters": {"l": 2.0}}
    (tmp_path / "sheet.json").write_text(json.dumps({"question": [question]}), encoding="utf-8")
    (tmp_path / "answers").mkdir()
    (tmp_path / "answers" / "dora.toml").write_text(
        "1 = \"q'' + 3*9.81 sin(q)/4\"\n", encoding="utf-8"
    )
    found = grade(tmp_path / "sheet.json", tmp_path / "answers")
    assert found.totals == {"dora": 1.0}
    assert found.marks[0].outcome == "right except for form"


def test_the_csv_is_a_table_that_no_spreadsheet_executes(course: Path) -> None:
    (course / "answers" / "=cmd").mkdir()
    result = CliRunner().invoke(
        app,
        [
            "grade",
            str(course / "sheet.toml"),
            str(course / "answers"),
            "--csv",
            str(course / "marks.csv"),
        ],
    )
    assert result.exit_code == 0, result.output
    rows = list(csv.reader(io.StringIO((course / "marks.csv").read_text(encoding="utf-8"))))
    assert rows[0] == ["student", "question", "points", "of", "outcome", "reason"]
    assert len(rows) == 1 + 4 * 3
    assert rows[1][0] == "'=cmd"
    assert ["anna", "2", "4", "4", "right", ""] in rows


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("title = 3 4", "cannot be read"),
        ("title = 'x'", "at least one"),
        ("question = [1]", "expected tables"),
        ("[[question]]\nsystem = 'x'", "expected id"),
        ("[[question]]\nid = '1'\nsystem = 'x'\npiont = 3", "unknown field 'piont'"),
        ("[[question]]\nid = '1'\nsystem = 'x'\npoints = -1", "expected points from 0"),
        ("[[question]]\nid = '1'\nsystem = 'x'\nlet = 'J'", "expected let"),
        ("[[question]]\nid = '1'\nsystem = 'x'\nparameters = 3", "expected parameters"),
        ("[[question]]\nid = '1'\nsystem = 'x'\n" * 2, "stands twice"),
        ("[[question]]\nid = '1'\nsystem = 'pendulm'", "unknown system"),
    ],
)
def test_a_sheet_that_cannot_be_used_is_refused(tmp_path: Path, text: str, message: str) -> None:
    (tmp_path / "sheet.toml").write_text(text, encoding="utf-8")
    (tmp_path / "answers" / "anna").mkdir(parents=True)
    with pytest.raises(mq.InputError, match=message):
        grade(tmp_path / "sheet.toml", tmp_path / "answers")


def test_a_folder_without_answers_is_refused(course: Path) -> None:
    with pytest.raises(mq.InputError, match="expected a folder of answers"):
        grade(course / "sheet.toml", course / "none")
    (course / "empty").mkdir()
    with pytest.raises(mq.InputError, match="for each student"):
        grade(course / "sheet.toml", course / "empty")


PENDULUM = """
[[question]]
id = "1a"
system = "rigid_bar_pendulum"
"""
RIGHT = "2*l*q'' + 3*g*sin(q) = 0"


def hand_in(folder: Path, student: str, text: str = RIGHT) -> Path:
    place = folder / student
    place.mkdir()
    (place / "1a.txt").write_text(text, encoding="utf-8")
    return place


def test_no_answer_stops_those_of_the_others(tmp_path: Path) -> None:
    answers = tmp_path / "answers"
    answers.mkdir()
    (tmp_path / "sheet.toml").write_text(PENDULUM, encoding="utf-8")
    hand_in(answers, "anna")
    (answers / "broken.toml").write_text("1a = 'x", encoding="utf-8")
    (answers / "deep.json").write_text("[" * 100_000, encoding="utf-8")
    (answers / "deep2.toml").write_text("a = " + "[" * 100_000, encoding="utf-8")
    (answers / "twice.json").write_text('{"1a": "q", "1a": "p"}', encoding="utf-8")
    (answers / "half.json").write_text('{"1a": "\\ud800"}', encoding="utf-8")
    (answers / "listed.json").write_text('{"1a": ["q"]}', encoding="utf-8")
    (answers / "latin.toml").write_bytes(b"1a = '\xe9'")
    (answers / "folder").mkdir()
    (answers / "folder" / "1a.txt").mkdir()
    os.mkfifo(answers / "pipe.toml")
    (answers / "inside").mkdir()
    os.mkfifo(answers / "inside" / "1a.txt")
    (answers / "zero").mkdir()
    (answers / "zero" / "1a.txt").symlink_to("/dev/zero")
    (answers / "linked.toml").symlink_to("/dev/zero")
    (answers / "shortcut").symlink_to(answers / "anna")
    hand_in(answers, "both")
    (answers / "both.json").write_text("{}", encoding="utf-8")
    (hand_in(answers, "two") / "1a.tex").write_text(RIGHT, encoding="utf-8")
    (answers / "long").mkdir()
    (answers / "long" / "1a.txt").write_text("q" * 100_000, encoding="utf-8")
    hand_in(answers, "null", "q\0'' = 0")
    hand_in(answers, "utf8bom", "\ufeff" + RIGHT)
    hand_in(answers, "\r=1+1")
    hand_in(answers, "＝1+1")
    os.mkdir(os.fsencode(answers) + b"/j\xfcrg")

    grades = grade(tmp_path / "sheet.toml", answers)

    reasons = {mark.student: mark.reason for mark in grades.marks}
    expected = {
        "broken": "broken.toml cannot be read: ",
        "deep": "deep.json cannot be read: it is nested too deeply",
        "deep2": "deep2.toml cannot be read: it is nested too deeply",
        "twice": "twice.json cannot be read: '1a' stands twice",
        "listed": "expected a text in listed.json, got a list",
        "latin": "latin.toml cannot be read: it is not UTF-8",
        "folder": "1a.txt is a folder, not a file",
        "pipe": "pipe.toml is no regular file",
        "inside": "1a.txt is no regular file",
        "zero": "1a.txt is a link; links are not followed",
        "linked": "linked.toml is a link; links are not followed",
        "shortcut": "shortcut is a link; links are not followed",
        "both": "expected one of both, both.json, got them all",
        "two": "expected one of 1a.tex, 1a.txt, got them all",
        "long": "1a.txt is longer than 80,000 bytes",
        r"j\xfcrg": "no answer",
    }
    for student, reason in expected.items():
        assert reasons[student].startswith(reason), (student, reasons[student])
    right = {student for student, points in grades.totals.items() if points}
    assert right == {"anna", "utf8bom", "＝1+1", r"\x0d=1+1"}
    outcomes = {mark.student: mark.outcome for mark in grades.marks}
    assert {outcomes[student] for student in expected} == {"unreadable", "missing"}
    assert {outcomes["null"], outcomes["half"]} == {"unreadable"}

    table = grades.to_csv().encode().decode()
    assert not any(c in table for c in "\0\r")
    rows = list(csv.reader(io.StringIO(table)))
    assert len(rows) == 1 + len(reasons)
    assert "'＝1+1" in {row[0] for row in rows}
    str(grades).encode()


@pytest.mark.parametrize("cell", ["=1", "+1", "-1", "@x", " =1", "\t1", "＝1", "＋1", "－1", "＠x"])
def test_what_a_spreadsheet_would_compute_is_disarmed(cell: str, tmp_path: Path) -> None:
    answers = tmp_path / "answers"
    (tmp_path / "sheet.toml").write_text(PENDULUM, encoding="utf-8")
    (answers / cell).mkdir(parents=True)
    table = grade(tmp_path / "sheet.toml", answers).to_csv()
    assert f"\n'{cell}," in table


def test_no_file_stops_the_sheet_itself_in_silence(tmp_path: Path) -> None:
    (tmp_path / "answers").mkdir()
    os.mkfifo(tmp_path / "sheet.toml")
    with pytest.raises(mq.InputError, match=r"sheet\.toml is no regular file"):
        grade(tmp_path / "sheet.toml", tmp_path / "answers")


def test_files_of_old_editors_are_graded(course: Path) -> None:
    formula = "m l²/3 q'' + ½ m g l sin q = 0"
    for name, encoding in (("dora", "utf-16"), ("emil", "cp1252"), ("finn", "utf-8-sig")):
        folder = course / "answers" / name
        folder.mkdir()
        (folder / "1a.txt").write_bytes(formula.encode(encoding))
    word = course / "answers" / "gabi"
    word.mkdir()
    (word / "1a.txt").write_text("J q” + m g l/2 sin q = 0", encoding="utf-8")
    marks = {
        mark.student: mark for mark in grade(course / "sheet.toml", course / "answers").marks[::3]
    }
    assert [marks[name].outcome for name in ("dora", "emil", "finn", "gabi")] == ["right"] * 4


def test_points_are_rounded_to_a_step_and_the_rule_is_stated(course: Path) -> None:
    sheet = course / "sheet.toml"
    sheet.write_text(
        "step = 0.25\n" + SHEET.replace("points = 4", "points = 4.3"), encoding="utf-8"
    )
    grades = grade(sheet, course / "answers")
    halves = [mark.points for mark in grades.marks if mark.question == "2"]
    assert halves == [4.3, 2.25, 2.25]
    assert grades.by_question["2"] == pytest.approx(8.8 / 3, rel=1e-12, abs=0.0)
    assert str(grades).splitlines()[-1].startswith("A right answer gets all points")
    sheet.write_text("step = 2\n" + SHEET, encoding="utf-8")
    with pytest.raises(mq.InputError, match="expected step from 0 to 1"):
        grade(sheet, course / "answers")


def test_frequent_mistakes_and_feedback_in_the_students_words(course: Path) -> None:
    for name in ("dora", "emil"):
        folder = course / "answers" / name
        folder.mkdir()
        (folder / "1a.txt").write_text("m l^2/12 q'' + m g l/2 sin q = 0", encoding="utf-8")
        (folder / "1b.txt").write_text("sqrt(K/J)", encoding="utf-8")
    grades = grade(course / "sheet.toml", course / "answers")
    question, reason, count = grades.frequent[0]
    assert (question, count) == ("1a", 2)
    assert "Steiner's term is missing" in reason
    assert f"1a: {reason} (2 students)" in str(grades)
    unread = [mark.reason for mark in grades.marks if mark.student == "dora"][1]
    assert "unknown letter" in unread
    assert "--let" not in unread


@pytest.mark.parametrize(
    ("name", "data", "outcome", "reason"),
    [
        ("1A.TXT", b"J q'' + m g l/2 sin q = 0", "right", ""),
        ("1a.txt", "J q'' + m g l/2 sin q = 0".encode("utf-32"), "right", ""),
        ("1a.txt", "L\xf6sung: J q'' + m g l/2 sin q = 0".encode("latin-1"), "right", ""),
        ("1a.txt", "J q'' + m g l/2 sin q = 0".encode("utf-16-le"), "right", ""),
        ("1a.txt", b"J q'' = \0\x01\x02", "unreadable", "is no text; save it as UTF-8"),
        ("1a.docx", b"PK\x03\x04", "unreadable", "expected a text (.txt, .tex, .mml, .md), got"),
        ("1a.pdf", b"%PDF-1.4", "unreadable", "got 1a.pdf"),
    ],
)
def test_files_as_students_name_and_save_them_are_read_or_explained(
    course: Path, name: str, data: bytes, outcome: str, reason: str
) -> None:
    folder = course / "answers" / "dora"
    folder.mkdir()
    (folder / name).write_bytes(data)
    (course / "answers" / "__MACOSX").mkdir()
    (course / "answers" / ".git").mkdir()
    grades = grade(course / "sheet.toml", course / "answers")
    assert set(grades.totals) == {"anna", "ben", "cleo", "dora"}
    (mark,) = [m for m in grades.marks if (m.student, m.question) == ("dora", "1a")]
    assert mark.outcome == outcome
    assert reason in mark.reason


def test_frequent_mistakes_keep_their_words(tmp_path: Path) -> None:
    (tmp_path / "sheet.toml").write_text(
        '[[question]]\nid = "1"\nsystem = "simple_pendulum"\nask = "frequency"\n', encoding="utf-8"
    )
    for student in ("anna", "ben"):
        (tmp_path / "answers" / student).mkdir(parents=True)
        text = tmp_path / "answers" / student / "1.txt"
        text.write_text("f = sqrt(g/l)", encoding="utf-8")
    grades = grade(tmp_path / "sheet.toml", tmp_path / "answers")
    reason = "a factor 2 pi is missing or surplus: omega = 2 pi f = 2 pi/T"
    assert grades.frequent == (("1", reason, 2),)


def test_the_results_of_a_class_are_a_page(course: Path) -> None:
    sheet, answers = course / "sheet.toml", course / "answers"
    twin = answers / "<b>dan"
    twin.mkdir()
    for path in (answers / "ben").iterdir():
        (twin / path.name).write_bytes(path.read_bytes())
    page = course / "results.html"
    result = CliRunner().invoke(app, ["grade", str(sheet), str(answers), "--html", str(page)])
    assert result.exit_code == 0
    assert "Wrote" in result.output
    grades, text = grade(sheet, answers), page.read_text(encoding="utf-8")
    assert text == write_class_page(grades)
    root = ElementTree.fromstring(re.sub(r"<!doctype html>\n|<meta [^>]*>", "", text))
    questions, mistakes, students = root.iter("table")
    rows = {row[0].text: [cell.text or "" for cell in row] for row in students.iter("tr")}
    for student, total in grades.totals.items():
        assert float(rows[student][-1]) == total
        assert sum(map(float, rows[student][1:-1])) == pytest.approx(total, abs=1e-9)
    meters = [float(meter.get("value", "nan")) for meter in questions.iter("meter")]
    assert meters == pytest.approx(list(grades.by_question.values()), abs=1e-4)
    shown = [tuple(cell.text for cell in row) for row in mistakes.iter("tr")][1:]
    assert shown == [(name, reason, str(count)) for name, reason, count in grades.frequent]
    opened = {summary.text for summary in root.iter("summary")}
    assert opened == {mark.student for mark in grades.marks if mark.reason}
    assert "<script" not in text
