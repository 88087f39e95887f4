"""Questions for STACK: their XML, and what Maxima makes of their trees."""

from __future__ import annotations

import re
import shutil
import subprocess
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest

import mecanique as mq
from mecanique.teaching import export_exercise

maxima = pytest.mark.skipif(shutil.which("maxima") is None, reason="needs Maxima")

# of STACK's own Maxima code, what the variables use
STUBS = """texput(a, b) := 0$ rand(x) := first(x)$"""


def read_question(path: Path) -> ET.Element:
    question = ET.parse(path).getroot().find("question")
    assert question is not None
    assert question.get("type") == "stack"
    return question


def text_of(question: ET.Element, tag: str) -> str:
    return question.findtext(f".//{tag}/text") or ""


def run_tree(question: ET.Element, answers: list[str], folder: Path) -> tuple[float, list[str]]:
    """Return the score and the feedback that the tree gives, evaluated by Maxima."""
    nodes = {node.findtext("name"): node for node in question.iter("node")}
    tests = [f"is(equal({n.findtext('sans')}, {n.findtext('tans')}))" for n in nodes.values()]
    given = [f"ans{k}: {answer}$" for k, answer in enumerate(answers, 1)]
    code = [STUBS, text_of(question, "questionvariables"), *given]
    code += [text_of(question, "feedbackvariables"), *(f'print("NODE", {t})$' for t in tests)]
    file = folder / "tree.mac"
    file.write_text("\n".join(code).replace(";", "$"), encoding="utf-8")
    done = subprocess.run(
        ["maxima", "--very-quiet", "--batch", str(file)],
        capture_output=True,
        encoding="utf-8",
        timeout=300,
        check=True,
    )
    found = re.findall(r"^NODE (true|false)", done.stdout, re.M)
    assert len(found) == len(nodes), done.stdout
    outcomes = dict(zip(nodes, found, strict=True))
    score, said, at = 0.0, [], "0"
    while at != "-1":
        branch, node = outcomes[at], nodes[at]
        value = float(node.findtext(f"{branch}score") or 0)
        score = value if node.findtext(f"{branch}scoremode") == "=" else score + value
        said.append(node.findtext(f"{branch}feedback/text") or "")
        at = node.findtext(f"{branch}nextnode") or "-1"
    return score, [part for part in said if part]


PENDULUM = (
    ("m*l^2/3*ddq + m*g*l/2*sin(q) = 0", 1.0, ""),
    ("ddq = -3*g/(2*l)*sin(q)", 1.0, ""),
    ("ddq = -3*g/l*sin(q/2)*cos(q/2)", 1.0, ""),
    ("m*l^2/3*ddq - m*g*l/2*sin(q) = 0", 0.0, "the sign of the force of gravity is wrong"),
    ("m*l^2/4*ddq + m*g*l/2*sin(q) = 0", 0.0, "inertia of 'rod' about its own center"),
    ("ddq = 0", 0.0, "gravity is missing"),
    ("0 = 0", 0.0, ""),
    ("ddq = ddq", 0.0, ""),
    ("(ddq + 3*g/(2*l)*sin(q))^2 = 0", 0.0, ""),
)
CART = "(M + m)*ddx + m*l*cos(q)*ddq - m*l*sin(q)*dq^2 + c*dx = F"
POLE = "cos(q)*ddx + l*ddq + g*sin(q) = 0"


@maxima
@pytest.mark.parametrize(("answer", "score", "said"), PENDULUM)
def test_maxima_judges_a_pendulum(answer: str, score: float, said: str, tmp_path: Path) -> None:
    path = export_exercise("rigid_bar_pendulum", "stack", tmp_path / "q.xml", seeds=range(3))
    found = run_tree(read_question(path), [answer], tmp_path)
    assert found[0] == score
    assert said in " ".join(found[1])


@maxima
@pytest.mark.parametrize(
    ("answers", "score", "said"),
    [
        ([CART, POLE], 1.0, ""),
        ([POLE, CART], 1.0, ""),
        ([CART, CART], 0.5, "1 of 2 independent"),
        ([CART, POLE.replace("+ g", "- g")], 0.5, "1 of 2 independent"),
        (["0 = 0", "ddx = ddx"], 0.0, ""),
        ([CART.replace("+ c*dx", ""), POLE], 0.5, "is missing"),
    ],
)
def test_maxima_counts_independent_equations(
    answers: list[str], score: float, said: str, tmp_path: Path
) -> None:
    path = export_exercise("cart_pole", "stack", tmp_path / "q.xml")
    found = run_tree(read_question(path), answers, tmp_path)
    assert found[0] == score
    assert said in " ".join(found[1])


def test_a_question_holds_its_figure_variants_and_tests(tmp_path: Path) -> None:
    path = export_exercise("cart_pole", "stack", tmp_path / "q.xml", seeds=range(4))
    question = read_question(path)
    assert "@@PLUGINFILE@@/figure.svg" in text_of(question, "questiontext")
    figure = question.find("questiontext/file")
    assert figure is not None
    assert (figure.get("name"), figure.get("encoding")) == ("figure.svg", "base64")
    assert len(question.findall("deployedseed")) == 4
    assert [field.findtext("name") for field in question.iter("input")] == ["ans1", "ans2"]
    assert "[[input:ans1]] [[validation:ans1]]" in text_of(question, "questiontext")
    assert text_of(question, "questionvariables").count("M = ") == 4
    nodes = [node.findtext("name") for node in question.iter("node")]
    assert nodes == [str(k) for k in range(len(nodes))]
    for node in question.iter("node"):
        for branch in ("true", "false"):
            assert node.findtext(f"{branch}nextnode") in ("-1", *map(str, nodes))
    assert len(question.findall("qtest")) == len(nodes) - 1


@pytest.mark.parametrize(
    ("system", "ask", "words"),
    [
        ("cart_pole", "kinetic energy", "about the kinetic energy"),
        ("four_bar_linkage", "equation of motion", "without loops"),
        ("n_link_pendulum", "equation of motion", "at most 3 coordinates"),
    ],
)
def test_what_stack_cannot_judge_is_refused(
    system: str, ask: str, words: str, tmp_path: Path
) -> None:
    with pytest.raises(mq.InputError, match=words):
        export_exercise(system, "stack", tmp_path / "q.xml", ask)
