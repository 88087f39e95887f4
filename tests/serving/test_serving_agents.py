"""The server for agents, asked by the official client, and the bounds of its tools."""

from __future__ import annotations

import asyncio
import json
import os
import sys
import time
from collections.abc import Coroutine
from concurrent.futures import ThreadPoolExecutor
from importlib.util import find_spec
from pathlib import Path
from typing import Any, TypeVar

import pytest

import mecanique as mq
from mecanique.checking.budget import SECONDS
from mecanique.serving import agents as tools
from mecanique.serving.agents import make_server

sys.path.insert(0, str(Path(__file__).parent))

import transcripts

pytestmark = pytest.mark.skipif(find_spec("mcp") is None, reason="needs the package mcp")

ROD = "rigid_bar_pendulum"

QUESTIONS = [
    {"id": "1", "system": ROD, "points": 2},
    {"id": "2", "system": ROD, "ask": "frequency"},
]
ANSWERS = {
    "anna": {"1": "q'' + 3 g/(2 l) sin q = 0", "2": "sqrt(3 g/(2 l))"},
    "ben": {"1": "q'' - 3 g/(2 l) sin q = 0", "2": "I do not know"},
}

T = TypeVar("T")


async def converse() -> dict[str, Any]:
    """Ask every tool once, in process."""
    from mcp import Client

    found: dict[str, Any] = {}
    async with Client(make_server()) as client:
        listed = await client.list_tools()
        found["tools"] = {tool.name: tool for tool in listed.tools}
        for name, arguments in (
            ("list_systems", {"tag": "pendulum"}),
            ("describe", {"system": ROD}),
            ("derive", {"system": ROD}),
            ("check", {"system": ROD, "formula": "m l^2/12 q'' + m g l/2 sin q = 0"}),
            ("verify_urdf", {"urdf": mq.write_urdf(mq.textbook.load(ROD)), "samples": 3}),
            ("simulate", {"system": ROD, "duration": 0.5, "instants": 3}),
            ("exercise", {"system": ROD, "ask": "frequency", "seed": 3}),
            ("equilibria", {"system": ROD, "parameters": {"l": 2.0}}),
            ("linearize", {"system": ROD, "at": {"q": 0.0}}),
            ("grade", {"questions": QUESTIONS, "answers": ANSWERS, "step": 0.25}),
            ("describe", {"system": "pendulm"}),
            ("check", {"system": ROD, "formula": "q'' = 0", "parameter": {"l": 2.0}}),
        ):
            key = name if name not in found else f"{name} refused"
            found[key] = await client.call_tool(name, arguments)
    return found


def run_apart(answer: Coroutine[Any, Any, T]) -> T:
    """Run in a thread of its own: tests of pages leave a loop running in this one."""
    with ThreadPoolExecutor(1) as pool:
        return pool.submit(asyncio.run, answer).result()


def text_of(result: Any) -> str:
    return " ".join(part.text for part in result.content)


def test_the_official_client_can_ask_every_tool() -> None:
    found = run_apart(converse())
    assert set(found["tools"]) == {tool.__name__ for tool in tools.TOOLS}
    schema = found["tools"]["check"].input_schema
    assert set(schema["required"]) == {"system", "formula"}
    assert "q'' + 3 g sin(q)/(2 l) = 0" in text_of(found["derive"])
    verdict = json.loads(text_of(found["check"]))
    assert verdict["outcome"] == "wrong"
    assert "about its center" in verdict["causes"][0]["text"]
    assert json.loads(text_of(found["verify_urdf"]))["verdict"]["agrees"]
    made = json.loads(text_of(found["exercise"]))
    assert "sqrt(3 g/(2 l))" in made["answer"]
    assert "figure" in made["problem"]
    for tool in found["tools"].values():
        assert tool.annotations.read_only_hint
        assert tool.annotations.idempotent_hint
    motion = json.loads(text_of(found["simulate"]))
    assert motion["t"] == [0.0, 0.25, 0.5]
    assert ROD in text_of(found["list_systems"])
    resting = found["equilibria"].structured_content["result"]
    assert [one["stable"] for one in resting] == [True, False]
    assert resting[0]["frequencies"] == pytest.approx([(1.5 * 9.81 / 2.0) ** 0.5], rel=1e-12)
    small = json.loads(text_of(found["linearize"]))
    assert small["K"][0][0] / small["M"][0][0] == pytest.approx(1.5 * 9.81, rel=1e-12)
    grades = json.loads(text_of(found["grade"]))
    assert grades["totals"] == {"anna": 3.0, "ben": 0.0}
    assert "sign" in grades["marks"][2]["reason"]
    assert grades["marks"][3]["outcome"] == "unreadable"
    assert found["check refused"].is_error
    assert "parameter" in text_of(found["check refused"])
    assert found["describe refused"].is_error
    assert "did you mean" in text_of(found["describe refused"])


@pytest.mark.slow
def test_it_serves_over_standard_input_and_output() -> None:
    from mcp import Client, StdioServerParameters

    async def ask() -> str:
        command = StdioServerParameters(
            command=sys.executable, args=["-m", "mecanique", "agents"], env=dict(os.environ)
        )
        async with Client(command) as client:
            found = await client.call_tool("derive", {"system": ROD})
            return text_of(found)

    assert "q''" in run_apart(ask())


@pytest.mark.parametrize(
    ("tool", "arguments", "message"),
    [
        (tools.verify_urdf, {"urdf": "/etc/passwd"}, "begins with <"),
        (tools.verify_urdf, {"urdf": "<" * 600_000}, "at most 500,000"),
        (tools.verify_urdf, {"urdf": "<robot/>", "samples": 1000}, "samples from 1 to 100"),
        (tools.simulate, {"system": ROD, "duration": 1e6}, "duration up to 60"),
        (tools.simulate, {"system": ROD, "instants": 10**6}, "instants from 2 to 500"),
        (tools.check, {"system": ROD, "formula": "q" * 30_000}, "at most 20,000"),
        (tools.equilibria, {"system": "squeezer", "parameters": {"m": 1.0}}, "parameter 'm'"),
        (tools.list_systems, {"tag": "pendulums"}, "tag 'pendulums'"),
        (
            tools.grade,
            {"questions": [{"id": "1", "system": ROD, "point": 2}], "answers": {"a": {}}},
            "unknown field 'point'",
        ),
        (
            tools.grade,
            {"questions": QUESTIONS, "answers": {key: {} for key in map(str, range(101))}},
            "200",
        ),
    ],
)
def test_work_is_bounded(tool: Any, arguments: dict[str, Any], message: str) -> None:
    with pytest.raises(mq.MecaniqueError, match=message):
        tool(**arguments)


@pytest.mark.parametrize(
    "formula",
    ["d/dt " * 14 + "(sin(t) cos(t) exp(t)) = 0", "q" + " " * 3000 + "(t", "d" * 19_999],
)
def test_a_hostile_formula_is_answered_within_the_clock_of_a_judgement(formula: str) -> None:
    tools.check(ROD, "q = 0")  # derives the right answer, which is not counted
    begun = time.process_time()
    with pytest.raises(mq.FormulaError):
        tools.check(ROD, formula)
    assert time.process_time() - begun < 2 * SECONDS


def test_a_long_comparison_is_stopped(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tools, "_MOST_SECONDS", -1.0)
    text = mq.write_urdf(mq.textbook.load(ROD))
    with pytest.raises(mq.InputError, match=r"the comparison takes more than .* fewer samples"):
        tools.verify_urdf(text)


def test_values_and_seeds_are_taken_by_check() -> None:
    found = tools.check(ROD, "T = 2.316 s", "frequency", parameters={"l": 2.0}, seed=4)
    assert found["outcome"] == "right except for form"
    assert tools.check(ROD, "T = 2.316 s", "frequency")["outcome"] == "wrong"


def test_equations_of_a_chain_are_derived_for_a_number_of_links() -> None:
    two = tools.derive("n_link_pendulum", parameters={"n": 2})
    assert "q2''" in two
    assert "q3''" not in two
    with pytest.raises(mq.UnknownNameError, match="unknown parameter 'L'"):
        tools.derive(ROD, parameters={"L": 2.0})


def test_a_urdf_that_cannot_be_read_has_findings_and_no_verdict() -> None:
    found = tools.verify_urdf("<robot name='r'><link></robot>")
    assert found["verdict"] is None
    assert found["findings"]


def test_the_class_of_the_transcript_is_graded_as_shown() -> None:
    """After a change: python tests/serving/transcripts.py."""
    shown = transcripts.PAGE.read_text(encoding="utf-8")
    graded = transcripts.grade_class()
    assert "ben   4 of 8" in graded
    assert f"```text\n{graded}\n```" in shown


@pytest.mark.slow
def test_the_transcript_of_the_server_is_what_it_answers() -> None:
    """After a change: python tests/serving/transcripts.py."""
    served = run_apart(transcripts.ask_server())
    assert f"```text\n{served}\n```" in transcripts.PAGE.read_text(encoding="utf-8")
