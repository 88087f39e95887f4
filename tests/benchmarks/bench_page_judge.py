"""How often the judge of a page agrees with Python's, on answers to exercises and slips in them.

    python tests/benchmarks/bench_page_judge.py [--number 2000] [--show]

The answers are those of `check_answers.py` and exercises, each also with a slip in a term, cut off,
as Mathematica or NumPy write them, and tautologies. A page leaves what it cannot judge to the
teacher; what it does judge must be what Python says.
"""

from __future__ import annotations

import argparse
import json
import random
import re
import subprocess
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from time import process_time

import check_answers

import mecanique as mq
from mecanique.teaching import make_exercise
from mecanique.teaching.question import ASKED, describe_question

JUDGE = Path(__file__).parents[1] / "teaching" / "javascript" / "judge_answers.js"
NOTHING = ("0 = 0", "7", "1 = 2", "see page 3", "", "T = T", "V = V", "L = L + 1", "omega = omega")


def vary(text: str, draw: random.Random, coordinates: tuple[str, ...]) -> Iterator[str]:
    """Yield an answer, and what slips, haste and other notations make of it."""
    yield text
    numbers = list(re.finditer(r"(?<![\w^.])\d+(?![\w.])", text))
    if numbers:
        chosen = draw.choice(numbers)
        yield f"{text[: chosen.start()]}{int(chosen[0]) + 1}{text[chosen.end() :]}"
    signs = [k for k, sign in enumerate(text) if sign in "+-" and text[k - 1 : k] == " "]
    if signs:
        k = draw.choice(signs)
        yield f"{text[:k]}{'-' if text[k] == '+' else '+'}{text[k + 1 :]}"
    if "sin" in text or "cos" in text:
        yield re.sub(r"\b(sin|cos)\b", lambda at: {"sin": "cos", "cos": "sin"}[at[1]], text)
    yield text[: draw.randrange(1, len(text))]
    yield text.replace(" = ", " = 2 (").replace("\n", ")\n") + ")"
    yield text.replace("^2", "²").replace(" - ", " − ").replace("'", "′")
    names = "|".join(sorted(coordinates, key=len, reverse=True))
    yield re.sub(
        rf"(?<!\w)({names})('*)(?![\w'])",
        lambda at: at[1] + {"": "", "'": "_dot", "''": "_ddot"}.get(at[2], at[2]),
        re.sub(r"\b(sin|cos|sqrt)\(", r"np.\1(", text),
    ).replace("^", "**")
    squared = "\n".join(f"({a})^2 = ({b})^2" for a, _, b in map(_cut, text.splitlines()) if b)
    yield squared or f"({text})^2"
    lines = text.splitlines()
    yield "\n".join([*lines, lines[0]])


def _cut(line: str) -> tuple[str, str, str]:
    return line.partition(" = ")


def list_answers(seed: int) -> Iterator[tuple[mq.Mechanism, str, str]]:
    """Yield answers to exercises and equations of motion, with their system and question."""
    draw = random.Random(seed)
    for system in mq.textbook.names():
        for ask in ASKED:
            try:
                exercise = make_exercise(system, ask, seed)
            except mq.MecaniqueError:
                continue
            mechanism = exercise.mechanism
            for text in (*vary(exercise.answer, draw, mechanism.coordinates.names), *NOTHING):
                yield mechanism, ask, text
    systems = check_answers.SYSTEMS
    for answer in (
        *check_answers.right_answers(40, seed, systems),
        *check_answers.wrong_answers(40, seed, systems),
    ):
        if not answer.let:
            yield mq.textbook.load(answer.system), "equation of motion", answer.text


def judge_by_page(question: dict[str, object], answers: list[str]) -> list[dict[str, object]]:
    """Return the verdicts of the page's script."""
    data = json.dumps({"question": question, "answers": answers})
    run = subprocess.run(
        ["node", str(JUDGE)], input=data, capture_output=True, encoding="utf-8", check=True
    )
    verdicts: list[dict[str, object]] = json.loads(run.stdout)
    return verdicts


def judge_by_python(mechanism: mq.Mechanism, ask: str, text: str) -> str:
    """Return the outcome of `mecanique.check`."""
    try:
        return mq.check(mechanism, text, ask).outcome
    except mq.FormulaError:
        return "refused"


def main(number: int, seed: int, *, show: bool) -> None:
    """Print the table."""
    start = process_time()
    groups: dict[tuple[mq.Mechanism, str], list[str]] = {}
    chosen = list(list_answers(seed))
    random.Random(seed).shuffle(chosen)
    table: Counter[tuple[str, str]] = Counter()
    for mechanism, ask, text in chosen:
        groups.setdefault((mechanism, ask), []).append(text)
    for (mechanism, ask), answers in groups.items():
        if table.total() >= number:
            break
        try:
            question = describe_question(mechanism, ask)
        except mq.InputError:
            continue
        if show:
            print(f"{table.total()}: {mechanism.name}, {ask}", flush=True)
        for text, verdict in zip(answers, judge_by_page(question, answers), strict=True):
            by_python, by_page = judge_by_python(mechanism, ask, text), str(verdict["outcome"])
            table[by_python, by_page] += 1
            if show and by_page not in ("teacher", by_python):
                print(f"{mechanism.name} | {ask} | {text!r}\n  {by_python}, page: {verdict}")
    differ = sum(n for (ours, page), n in table.items() if page not in ("teacher", ours))
    left = sum(n for (_, page), n in table.items() if page == "teacher")
    judged = table.total() - left
    print(f"{table.total()} answers in {process_time() - start:.0f} s: the page judges {judged}")
    print(f"  it differs from Python in {differ}, and leaves {left} to the teacher")
    for (ours, page), count in sorted(table.items()):
        print(f"  {ours:24}{page:24}{count}")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--number", type=int, default=2000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--show", action="store_true")
    given = parser.parse_args()
    main(given.number, given.seed, show=given.show)
