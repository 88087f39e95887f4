"""Exercises exported to learning platforms, run as these run them."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import sys
from collections import Counter
from pathlib import Path
from typing import Any
from zipfile import ZipFile

import pytest
from click.testing import CliRunner

import mecanique as mq
from mecanique.cli import app
from mecanique.teaching import export_exercise, make_exercise
from mecanique.teaching.question import describe_question

sys.path.insert(0, str(Path(__file__).parents[1] / "benchmarks"))
from check_answers import right_answers, wrong_answers

JUDGE = Path(__file__).parent / "javascript" / "judge_answers.js"
CART = "(M + m) x'' + m l cos q q'' - m l sin q q'^2 + c x' = F"
POLE = "cos q x'' + l q'' + g sin q = 0"
needs_node = pytest.mark.skipif(shutil.which("node") is None, reason="needs Node")

SYSTEMS = ("rigid_bar_pendulum", "cart_pole", "elastic_pendulum", "crane", "bead_on_hoop")
MORE = (
    # what the package reads in a way of its own
    ("rigid_bar_pendulum", "equation of motion", "q_tt + 3 g/(2 l) sin q = 0"),
    (
        "two_blocks",
        "equation of motion",
        "1. m1 q1'' = k2 (q2 - q1) - k1 q1\n2. m2 q2'' = F - k2 (q2 - q1)",
    ),
    (
        "two_blocks",
        "equation of motion",
        "m1 q1'' = k2 (q2 - q1) - k1 q1 (1)\nm2 q2'' = F - k2 (q2 - q1) (2)",
    ),
    (
        "base_excited_mass",
        "equation of motion",
        "m (u'' + x_base'') = -k u - c u', x_base = X sin(W t)",
    ),
    ("coupled_pendulums", "frequency", "ω0² = g/l; ω1 = ω0; ω2² = ω0² + 2 k a²/(m l²)"),
    ("rigid_bar_pendulum", "equation of motion", "q'' + 3 g/(2 l) q = 0"),
    # linearized, or without its centripetal term
    ("particle_on_circle_x", "equation of motion", "m R^2 x''/(R^2 - x^2) = 0"),
    # with the potential of a force that is the same everywhere
    ("cart_pole", "potential energy", "V = -m g l cos q - F x"),
    ("cart_pole", "potential energy", "V = -m g l cos q + F x"),
    ("two_blocks", "equation of motion", "m1 q1'' = k2 (q2 - q1) - k1 q1 or q2'' = F/m2"),
    ("rigid_bar_pendulum", "equation of motion", "0 = 0"),
    ("rigid_bar_pendulum", "equation of motion", "sin(q) (q'' + 3 g/(2 l) sin q) = 0"),
    ("rigid_bar_pendulum", "equation of motion", "q'' + 3 g/(2 l) sin q + 1e-9 q' sqrt(g/l) = 0"),
    ("rigid_bar_pendulum", "equation of motion", "(q'' + 3 g/(2 l) sin q)^2 = 0"),
    ("rigid_bar_pendulum", "equation of motion", "q'' = -14.715 sin q"),
    ("rigid_bar_pendulum", "equation of motion", "q'' = -(3g/2l) sin q"),
    ("rigid_bar_pendulum", "equation of motion", r"\ddot q + \frac{3g}{2\ell} \sin q = 0"),
    ("rigid_bar_pendulum", "equation of motion", "mgl/2 sin q = -ml²/3 q̈"),
    ("rigid_bar_pendulum", "kinetic energy", "T = m l^2 q'^2/6"),
    ("rigid_bar_pendulum", "kinetic energy", "T = m l^2 q'^2/24"),
    ("rigid_bar_pendulum", "kinetic energy", "T = T"),
    ("rigid_bar_pendulum", "kinetic energy", "T^2 = (m l^2 q'^2/6)^2"),
    ("rigid_bar_pendulum", "kinetic energy", "m l² q̇²/6"),
    ("rigid_bar_pendulum", "potential energy", "V = m g l/2 (1 - cos q)"),
    ("rigid_bar_pendulum", "potential energy", "V = m g l/2 cos q"),
    ("rigid_bar_pendulum", "Lagrangian", "L = m l^2 q'^2/6 + m g l/2 cos q"),
    ("rigid_bar_pendulum", "frequency", "omega = sqrt(3 g/(2 l))"),
    ("rigid_bar_pendulum", "frequency", "T = 2 pi sqrt(2 l/(3 g))"),
    ("rigid_bar_pendulum", "frequency", "f = sqrt(3 g/(2 l))"),
    ("rigid_bar_pendulum", "frequency", "omega = omega"),
    ("coupled_pendulums", "frequency", "omega = sqrt(g/l)"),
    ("coupled_pendulums", "frequency", "sqrt(g/l); sqrt(g/l + 2 k a^2/(m l^2))"),
)


def judge_in_javascript(question: dict[str, Any], answers: list[str]) -> list[dict[str, Any]]:
    done = subprocess.run(
        ["node", str(JUDGE)],
        input=json.dumps({"question": question, "answers": answers}),
        capture_output=True,
        encoding="utf-8",
        check=True,
    )
    verdicts: list[dict[str, Any]] = json.loads(done.stdout)
    return verdicts


def compare(per_system: int, systems: tuple[str, ...], seed: int) -> Counter[tuple[str, str]]:
    """Count the outcomes of both judges on many answers."""
    answers: dict[tuple[str, str], list[str]] = {}
    made = [
        *right_answers(per_system, seed, systems),
        *wrong_answers(per_system, seed + 1, systems),
    ]
    for one in made:
        if not one.let:
            answers.setdefault((one.system, "equation of motion"), []).append(one.text)
    for system, ask, text in MORE:
        answers.setdefault((system, ask), []).append(text)
    table: Counter[tuple[str, str]] = Counter()
    for (system, ask), texts in answers.items():
        mechanism = mq.textbook.load(system)
        verdicts = judge_in_javascript(describe_question(mechanism, ask), texts)
        for text, verdict in zip(texts, verdicts, strict=True):
            try:
                own = mq.check(mechanism, text, ask).outcome
            except mq.FormulaError:
                own = "refused"  # type: ignore[assignment]
            table[own, verdict["outcome"]] += 1
            assert verdict["outcome"] in (own, "teacher"), (system, text, own, verdict)
    return table


@needs_node
def test_the_page_judges_as_python_does() -> None:
    table = compare(12, SYSTEMS, 21)
    left = sum(count for (_, outcome), count in table.items() if outcome == "teacher")
    assert left <= 0.2 * table.total(), table
    assert {"right", "wrong", "incomplete", "right except for form"} <= {pair[1] for pair in table}


def test_slips_of_a_potential_without_a_value_at_zero_are_listed_without_a_warning() -> None:
    assert describe_question(mq.textbook.load("kepler_orbit"), "equation of motion")["slips"]


def test_no_state_of_a_question_is_out_of_reach() -> None:
    question = describe_question(mq.textbook.load("particle_on_circle_x"), "potential energy")
    assert json.dumps(question, allow_nan=False)


@needs_node
def test_a_frequency_of_zero_has_no_period_on_the_page() -> None:
    furuta = mq.textbook.load("furuta_pendulum")
    question = describe_question(furuta, "frequency")
    assert json.dumps(question, allow_nan=False)
    answers = ["omega = 0", "omega_1 = 0"]
    verdicts = judge_in_javascript(question, answers)
    assert [verdict["outcome"] for verdict in verdicts] == ["incomplete", "incomplete"]
    assert [mq.check(furuta, text, "frequency").outcome for text in answers] == [
        verdict["outcome"] for verdict in verdicts
    ]


@pytest.mark.slow
@needs_node
def test_the_page_judges_more_answers_as_python_does() -> None:
    systems = (*SYSTEMS, "double_pendulum", "two_blocks", "kepler_orbit", "spherical_pendulum")
    assert compare(12, systems, 31).total() >= 200


def submit(text: str) -> dict[str, Any]:
    """Return PrairieLearn's data of a submission."""
    return {
        "panel": "question",
        "variant_seed": 7,
        "params": {},
        "correct_answers": {},
        "submitted_answers": {"equation": text},
        "format_errors": {},
        "partial_scores": {},
        "score": 0,
        "feedback": {},
    }


@pytest.fixture
def course(tmp_path: Path) -> Path:
    return export_exercise("cart_pole", "prairielearn", tmp_path, seeds=range(4))


def run(file: Path) -> dict[str, Any]:
    names: dict[str, Any] = {}
    exec(file.read_text(encoding="utf-8"), names)
    return names


@pytest.mark.parametrize(
    ("text", "score", "words"),
    [
        (f"{POLE}\n{CART}", 1.0, ""),
        (POLE, 0.5, "1 of 2 equations missing"),
        (f"{CART}\n{POLE.replace('+ g', '- g')}", 0.5, "sign of the potential of gravity"),
    ],
)
def test_prairielearn_grades(course: Path, text: str, score: float, words: str) -> None:
    question = course / "questions" / "mecanique-cart_pole-equation-of-motion"
    server = run(question / "server.py")
    element = run(course / "elements" / "mq-equation" / "mq-equation.py")
    data = submit(text)
    server["generate"](data)
    assert "M = " in data["params"]["given"]
    element["parse"]("<mq-equation>", data)
    assert not data["format_errors"]
    element["grade"]("<mq-equation>", data)
    given = data["partial_scores"]["equation"]
    assert given["score"] == score
    assert given["weight"] == 1
    assert words in given["feedback"]
    shown = element["render"]("<mq-equation>", data)
    assert '<textarea name="equation"' in shown
    assert words in shown
    page = (question / "question.html").read_text(encoding="utf-8")
    assert "{{params.given}}" in page
    assert (question / "clientFilesQuestion" / "figure.svg").exists()


def test_prairielearn_says_what_cannot_be_read(course: Path) -> None:
    element = run(course / "elements" / "mq-equation" / "mq-equation.py")
    data = submit("(M + m x'' = <b>F")
    data["params"] = {"system": "cart_pole", "ask": "equation of motion", "values": {}, "form": 0.5}
    element["parse"]("<mq-equation>", data)
    assert "'<' has no meaning here" in data["format_errors"]["equation"]
    assert "<b>" not in element["render"]("<mq-equation>", data)


@pytest.mark.parametrize(
    ("answer", "points"), [(f"{CART}\n{POLE}", 2.0), (CART, 1.0), ("0 = 0", 0.0), ("", 0.0)]
)
def test_a_notebook_of_nbgrader_gives_points(answer: str, points: float, tmp_path: Path) -> None:
    path = export_exercise("cart_pole", "nbgrader", tmp_path / "cart.ipynb")
    notebook = json.loads(path.read_text(encoding="utf-8"))
    problem, solution, tests = notebook["cells"]
    assert "data:image/svg+xml;base64," in "".join(problem["source"])
    assert solution["metadata"]["nbgrader"]["solution"] is True
    settings = tests["metadata"]["nbgrader"]
    assert (settings["grade"], settings["locked"], settings["points"]) == (True, True, 2)
    own: dict[str, Any] = {}
    exec("".join(solution["source"]), own)
    assert mq.check(mq.textbook.load("cart_pole"), own["answer"]).right
    # the last line is the cell's output, which nbgrader takes for the points
    body = re.sub(r"\n### END HIDDEN TESTS$", "", "".join(tests["source"]))
    statements, _, last = body.rpartition("\n")
    names: dict[str, Any] = {"answer": answer}
    exec(statements, names)
    assert eval(last, names) == points


def test_courses_judge_numbers_by_those_of_the_variant(tmp_path: Path) -> None:
    made = make_exercise("elastic_pendulum", "frequency", seed=4)
    path = export_exercise("elastic_pendulum", "nbgrader", tmp_path / "e.ipynb", "frequency", (4,))
    tests = "".join(json.loads(path.read_text(encoding="utf-8"))["cells"][2]["source"])
    statements, _, last = re.sub(r"\n### END HIDDEN TESTS$", "", tests).rpartition("\n")
    for answer, points in ((made.answer, 2.0), ("omega1 = 2.712\nomega2 = 5.425", 0.0)):
        names: dict[str, Any] = {"answer": answer}
        exec(statements, names)
        assert eval(last, names) == points
    export_exercise("elastic_pendulum", "prairielearn", tmp_path, "frequency", (4,))
    element = run(tmp_path / "elements" / "mq-equation" / "mq-equation.py")
    data = submit(made.answer)
    run(tmp_path / "questions" / "mecanique-elastic_pendulum-frequency" / "server.py")["generate"](
        data
    )
    element["grade"]("<mq-equation>", data)
    assert data["partial_scores"]["equation"]["score"] == 1.0


def test_an_archive_for_scorm_holds_what_its_manifest_names(tmp_path: Path) -> None:
    path = export_exercise("simple_pendulum", "scorm", tmp_path / "p.zip", "frequency", seeds=(3,))
    with ZipFile(path) as archive:
        assert sorted(archive.namelist()) == ["imsmanifest.xml", "index.html"]
        manifest = archive.read("imsmanifest.xml").decode()
        page = archive.read("index.html").decode()
    assert 'adlcp:scormtype="sco" href="index.html"' in manifest
    assert "<schemaversion>1.2</schemaversion>" in manifest
    assert not re.search(r"""(?:src|href)=["'](?!#)""", page)


@pytest.mark.parametrize(
    ("system", "course", "ask", "seeds", "words"),
    [
        ("cart_pole", "moodle", "equation of motion", (0,), "kind of course"),
        ("cart_pole", "page", "mass matrix", (0,), "no page judges a mass matrix by itself"),
        ("four_bar_linkage", "page", "equation of motion", (0,), "it has loops"),
        ("elastic_pendulum", "page", "frequency", (0,), "it is asked for in numbers"),
        ("elastic_pendulum", "prairielearn", "frequency", (0, 1), "expected one seed for prairie"),
        ("cart_pole", "scorm", "equation of motion", (0, 1), "one seed for scorm, got 2"),
    ],
)
def test_what_cannot_be_exported_is_refused(
    system: str, course: str, ask: str, seeds: tuple[int, ...], words: str, tmp_path: Path
) -> None:
    with pytest.raises(mq.MecaniqueError, match=words):
        export_exercise(system, course, tmp_path / "out", ask, seeds)


def test_the_command_line_writes_for_courses(tmp_path: Path) -> None:
    words = ["exercise", "cart_pole", "--for", "stack", "--variants", "3", "--seed", "5"]
    done = CliRunner().invoke(app, [*words, "-o", str(tmp_path / "cart.xml")])
    assert done.exit_code == 0, done.output
    assert (tmp_path / "cart.xml").read_text(encoding="utf-8").count("<deployedseed>") == 3
    refused = CliRunner().invoke(app, words)
    assert refused.exit_code == 2
    assert "--for stack needs --output" in refused.output
