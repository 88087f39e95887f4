"""How good `check` is: right answers rejected, wrong ones accepted, causes found, and how fast.

python tests/benchmarks/bench_check.py [--right 80] [--wrong 80] [--fuzz 100000] [--show 10]
"""

from __future__ import annotations

import argparse
import random
import sys
import time
from collections import Counter

import numpy as np
from check_answers import EXPECTED, SYSTEMS, Answer, problem, right_answers, wrong_answers

import mecanique as mq


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--right", type=int, default=80, help="right answers a system")
    parser.add_argument("--wrong", type=int, default=80, help="wrong answers a system")
    parser.add_argument("--fuzz", type=int, default=0, help="texts for the parser")
    parser.add_argument("--show", type=int, default=5, help="failures shown")
    chosen = parser.parse_args()
    if chosen.right:
        rewrite(chosen.right, chosen.show)
    if chosen.wrong:
        mistake(chosen.wrong, chosen.show)
    if chosen.fuzz:
        fuzz(chosen.fuzz)


def timed(answer: Answer) -> tuple[mq.Check, float]:
    """Return the verdict on an answer, and the CPU time it took [s]."""
    mechanism = problem(answer.system).mechanism
    began = time.process_time()
    found = mq.check(mechanism, answer.text, let=answer.let)
    return found, time.process_time() - began


def rewrite(per_system: int, show: int) -> None:
    """Count right answers that are rejected."""
    taken, rejected, hows = [], 0, Counter[str]()
    for answer in right_answers(per_system):
        found, seconds = timed(answer)
        taken.append(seconds)
        hows[answer.how] += 1
        if not found.right:
            rejected += 1
            if rejected <= show:
                print(f"REJECTED {answer.system} {answer.how} {answer.let}\n{answer.text[:400]}")
                print(f"   {str(found)[:700]}")
    print(f"{len(taken)} right answers on {len(SYSTEMS)} systems: {rejected} rejected")
    print(f"  forms: {dict(hows)}")
    report("  CPU time", taken)


def mistake(per_system: int, show: int) -> None:
    """Count wrong answers that are accepted, and causes that are found."""
    taken: list[float] = []
    accepted = shown = 0
    count, first, told, listed = (Counter[str]() for _ in range(4))
    for answer in wrong_answers(per_system):
        found, seconds = timed(answer)
        taken.append(seconds)
        kind = answer.mistake
        count[kind] += 1
        if found.right or (found.outcome != "wrong" and kind != "linearized"):
            accepted += found.right
        kinds = [cause.kind for cause in found.causes]
        first[kind] += bool(set(kinds[:1]) & EXPECTED[kind])
        words = str(found)
        said = {cause.kind for cause in found.causes if f": {cause.text}" in words}
        told[kind] += bool(said & EXPECTED[kind])
        named = bool(set(kinds) & EXPECTED[kind])
        listed[kind] += named
        if not named and shown < show:
            shown += 1
            print(f"NOT NAMED {kind} {answer.system}\n{answer.text[:600]}\n   {str(found)[:900]}")
    total = sum(count.values())
    print(f"{total} wrong answers on {len(SYSTEMS)} systems: {accepted} accepted as right")
    for kind in count:
        print(
            f"  {kind:15s} {count[kind]:5d}  first {first[kind] / count[kind]:.3f}  "
            f"told {told[kind] / count[kind]:.3f}  listed {listed[kind] / count[kind]:.3f}"
        )
    for words, some in (
        ("first", first),
        ("first, or told as giving the same formula", told),
        ("listed", listed),
    ):
        print(f"  all: {words} {sum(some.values()) / total:.4f}")
    report("  CPU time", taken)


def report(what: str, seconds: list[float]) -> None:
    """Print how long answers took."""
    ms = np.array(seconds) * 1e3
    print(
        f"{what}: median {np.median(ms):.1f} ms, 95 % {np.percentile(ms, 95):.1f} ms, "
        f"99 % {np.percentile(ms, 99):.1f} ms, longest {ms.max():.0f} ms"
    )


def fuzz(count: int) -> None:
    """Give the parser texts without sense; only errors of formulas may come, and soon."""
    draw = random.Random(7)
    mechanism = mq.textbook.load("double_pendulum")
    seeds = [answer.text for answer in right_answers(3)]
    words = ("sin", "cos", "frac", "dot", "ddot", "m1", "l1", "q1'", "q2''", "Matrix", ".diff(t)")
    signs = [*words, *"()[]{}^\\+-*/=,;&\n02.√²θ$%_'\u0308\u2081 "]
    longest, kinds = 0.0, Counter[str]()
    for number in range(count):
        if number % 2:
            text = "".join(draw.choice(signs) for _ in range(draw.randint(1, 60)))
        else:
            chars = list(draw.choice(seeds)[:600])
            for _ in range(draw.randint(1, 8)):
                place = draw.randrange(len(chars))
                chars[place] = draw.choice([*signs, chr(draw.randrange(32, 0x3000))])
            text = "".join(chars)
        began = time.process_time()
        try:
            kinds[mq.check(mechanism, text).outcome] += 1
        except mq.FormulaError:
            kinds["refused"] += 1
        except Exception as error:
            kinds[type(error).__name__] += 1
            print(f"CRASH {error!r}\n{text!r}", file=sys.stderr)
        longest = max(longest, time.process_time() - began)
    print(f"{count} texts: {dict(kinds)}, longest {longest:.2f} s")


if __name__ == "__main__":
    main()
