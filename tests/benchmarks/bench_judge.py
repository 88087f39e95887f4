"""How a list of answers fares: those of textbooks, with slips of students, incomplete, and attacks.

    python tests/benchmarks/bench_judge.py [seen|blind|fresh|all] [--show]

Each line of the files beside this one names a system, what is asked, an answer, the outcome,
and a pattern that the first cause of a wrong one must match. The blind part was written with the
seen one and is only run after what it measures is finished; the fresh one, of wrong answers alone,
was written after both had been used.
"""

from __future__ import annotations

import re
import sys
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from time import process_time
from typing import NamedTuple

import mecanique as mq

FOLDER = Path(__file__).parent / "judge"
OUTCOMES = {"form": "right except for form"}


class Answer(NamedTuple):
    """An answer, and what a judge must say about it."""

    system: str
    ask: str
    text: str
    outcome: str
    cause: str


def read(part: str) -> Iterator[Answer]:
    """Yield the answers of a part."""
    for line in (FOLDER / f"answers_{part}.txt").read_text(encoding="utf-8").splitlines():
        if line and not line.startswith("#"):
            system, ask, text, outcome, cause = (field.strip() for field in line.split(" | ", 4))
            yield Answer(system, ask, text.replace(" ;; ", "\n"), outcome, cause)


def judge(answer: Answer) -> tuple[str, str]:
    """Return the outcome, and the first cause in words."""
    try:
        verdict = mq.check(mq.textbook.load(answer.system), answer.text, answer.ask)
    except mq.MecaniqueError as error:
        return "refused", str(error)
    causes = [f"{cause.kind}: {cause.text}" for cause in verdict.causes]
    return verdict.outcome, causes[0] if causes else verdict.form


def main(part: str = "all", show: str = "") -> None:
    """Print the table."""
    parts = ("seen", "blind", "fresh") if part == "all" else (part,)
    for name in parts:
        outcomes: Counter[tuple[str, str]] = Counter()
        asked = named = 0
        start = process_time()
        for answer in read(name):
            outcome, said = judge(answer)
            wanted = OUTCOMES.get(answer.outcome, answer.outcome)
            outcomes[wanted, outcome] += 1
            explained = True
            if wanted == "wrong" and answer.cause:
                asked += 1
                explained = outcome == "wrong" and bool(re.search(answer.cause, said))
                named += explained
            if show and (outcome != wanted or not explained):
                print(f"{answer.system} | {answer.ask} | {answer.text!r}\n  {outcome}: {said}")
        print(f"{name}: {outcomes.total()} answers in {process_time() - start:.0f} s")
        for (wanted, outcome), count in sorted(outcomes.items()):
            print(f"  {wanted:24}{outcome:24}{count}")
        print(f"  first cause names the slip: {named} of {asked}")


if __name__ == "__main__":
    main(*sys.argv[1:])
