"""The benchmark: tasks by seed, judged without a key, which pays nothing for nothing."""

from __future__ import annotations

import json
from functools import lru_cache
from pathlib import Path

import pytest
from click.testing import CliRunner

import mecanique as mq
from mecanique.cli import app
from mecanique.teaching import Task, make_exercise, make_tasks, score_answers

NUMBER = 8
ROLLING = "rolling_disk/equation of motion/7"
CART = "cart_pole/momentum/7"


@pytest.fixture(scope="module")
def tasks() -> list[Task]:
    return list(make_tasks(NUMBER, seed=5))


@lru_cache
def solve(name: str) -> str:
    """Return the answer of the package itself."""
    system, kind, seed = name.split("/")
    return make_exercise(system, kind, int(seed)).answer


def test_a_seed_makes_the_same_tasks(tasks: list[Task]) -> None:
    assert list(make_tasks(2, seed=5)) == tasks[:2]
    assert [task.name for task in make_tasks(2, seed=6)] != [task.name for task in tasks[:2]]
    assert len({task.name for task in tasks}) == NUMBER


def test_a_task_holds_no_answer(tasks: list[Task]) -> None:
    for task in tasks:
        assert solve(task.name) not in task.prompt
        assert "figure.svg" not in task.prompt
        assert "one equation or value per line" in task.prompt


def test_the_package_itself_gets_all_points(tasks: list[Task]) -> None:
    names = [*(task.name for task in tasks), ROLLING, CART]
    score = score_answers(names, {name: solve(name) for name in names})
    assert score.mean == 1
    assert str(score).startswith(f"100.0% of {NUMBER + 2} tasks\n")


@pytest.mark.parametrize(
    "answer",
    ["", "0 = 0", "0", "7", "1 = 1\n0 = 0", "T = T\nV = V\nE = E\nH = H\np = p\nomega = omega"],
)
def test_what_says_nothing_gets_nothing(tasks: list[Task], answer: str) -> None:
    names = [*(task.name for task in tasks), ROLLING, CART]
    assert score_answers(names, dict.fromkeys(names, answer)).mean == 0


def test_a_copy_of_the_task_gets_nothing(tasks: list[Task]) -> None:
    prompts = {task.name: task.prompt for task in tasks}
    assert score_answers(prompts, prompts).mean == 0


def test_foreign_answers_are_refused() -> None:
    with pytest.raises(mq.InputError, match="belongs to none of the tasks: 'crane/energy/1'"):
        score_answers([CART], {"crane/energy/1": "0"})
    with pytest.raises(mq.InputError, match="expected a task's name such as cart_pole/energy/7"):
        score_answers(["cart_pole"], {})
    with pytest.raises(mq.InputError, match="expected at least one task"):
        score_answers([], {})


def test_tasks_and_answers_are_lines_of_json(tmp_path: Path) -> None:
    file, answers = tmp_path / "tasks.jsonl", tmp_path / "answers.jsonl"
    written = CliRunner().invoke(app, ["benchmark", str(file), "--number", "2", "--seed", "5"])
    assert written.exit_code == 0, written.output
    names = [json.loads(line)["id"] for line in file.read_text(encoding="utf-8").splitlines()]
    answers.write_text(json.dumps({"id": names[0], "answer": solve(names[0])}), encoding="utf-8")
    judged = CliRunner().invoke(app, ["benchmark", str(file), str(answers)])
    assert "50.0% of 2 tasks" in judged.output


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("nothing", "in line 1 of answers.jsonl"),
        ('{"id": "a"}', 'expected {"id": …, "answer": …} in line 1'),
        ('{"id": "a", "answer": "0"}\n{"id": "a", "answer": "1"}', "task 'a' stands twice"),
    ],
)
def test_a_broken_file_is_told(tmp_path: Path, text: str, message: str) -> None:
    file, answers = tmp_path / "tasks.jsonl", tmp_path / "answers.jsonl"
    file.write_text(json.dumps({"id": CART, "prompt": "?"}), encoding="utf-8")
    answers.write_text(text, encoding="utf-8")
    told = CliRunner().invoke(app, ["benchmark", str(file), str(answers)])
    assert told.exit_code == 2
    assert message in " ".join(told.output.split())
