"""Inject an error of a millionth into every mass, center, inertia and length, and look for it.

Run it by hand: python tests/benchmarks/bench_injections.py [NAME …]
without names over all textbook systems and all robots of example-robot-data. An error is found if a
row of the comparison exceeds what `verify` allows there by default. What is not found is injected
`LARGER` times as large: the same part of the difference that this makes is what the error itself
adds to exact equations. Either nothing exceeds rounding even so, as the equations do not contain
the number: the mass of what is fixed to the ground, the place of a frame without mass, or of a
hinge on its axis, a loop's frame on body a, which only decides where the loop closes. Or the error
is below rounding, and is printed with the largest part of the bound that it reaches; there is none
that reaches it and is not found. Robots float, so that the base counts as well.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

import mecanique as mq
from mecanique.derivation.numeric.recursion import Recursion
from mecanique.errors import MecaniqueError
from mecanique.model.mechanism_units import characteristic_length
from mecanique.model.states import States
from mecanique.threads import one_thread_for_loops
from mecanique.verification.rounding import entry_rounding, rounding
from mecanique.verification.rows import Values, evaluate, rows_of
from mecanique.verification.states import random_states
from mecanique.verification.verdict import Row

sys.path.insert(0, str(Path(__file__).parents[1] / "verification"))
from verification_injections import heavy, parts, with_body, with_joint

ERROR = 1e-6
"""Relative error of a mass, a center, an inertia or a length."""

LARGER = 1e5
"""How much larger the error is made that shows what a number adds to exact equations."""

PAIR = ("with the error", "without")

NOTHING = 1e-12
"""Lengths and inertias that are this part of the mechanism's own, or less, are zero."""

SAMPLES = 3


@dataclass(frozen=True)
class Wrong:
    """A copy of a mechanism with one number changed."""

    what: str
    mechanism: mq.Mechanism


@dataclass
class Count:
    """What became of the copies of one mechanism."""

    name: str
    copies: int = 0
    found: int = 0
    below: int = 0
    hidden: int = 0
    absent: int = 0


def copies(mechanism: mq.Mechanism, error: float = ERROR) -> Iterator[Wrong]:
    """Yield a copy for every number that is not zero."""
    length = characteristic_length(mechanism)
    for body in heavy(mechanism):
        mass, center, inertia = parts(mechanism, body)
        for what, factors in (
            ("mass", (1 + error, 1, 1)),
            ("center", (1, 1 + error, 1)),
            ("inertia", (1, 1, 1 + error)),
        ):
            if what == "center" and np.abs(center).max() <= NOTHING * length:
                continue
            if what == "inertia" and np.abs(inertia).max() <= NOTHING * mass * length**2:
                continue
            changed = (mass * factors[0], center * factors[1], inertia * factors[2])
            try:
                yield Wrong(f"{what} of {body.name}", with_body(mechanism, body.name, *changed))
            except MecaniqueError:
                continue
    for joint in mechanism.joints:
        if (origin := _longer(mechanism, joint.origin, error)) is not None:
            yield Wrong(f"origin of {joint.name}", with_joint(mechanism, joint.name, origin=origin))
    for loop in mechanism.loops:
        for field in ("frame_a", "frame_b"):
            if (frame := _longer(mechanism, getattr(loop, field), error)) is not None:
                moved: dict[str, Any] = {field: frame}
                changed_loop = replace(loop, **moved)
                loops = tuple(changed_loop if x is loop else x for x in mechanism.loops)
                yield Wrong(f"{field} of {loop.name}", replace(mechanism, loops=loops))


def _longer(mechanism: mq.Mechanism, place: mq.Placement, error: float) -> mq.Placement | None:
    xyz: Any = tuple(mechanism.evaluate(x) * (1 + error) for x in place.xyz)
    reach = NOTHING * characteristic_length(mechanism)
    return replace(place, xyz=xyz) if max(map(abs, xyz)) > reach else None


@one_thread_for_loops
def inject(name: str, mechanism: mq.Mechanism) -> Count:
    """Inject every error into one mechanism."""
    count, missed = Count(name), set[str]()
    states = random_states(mechanism, SAMPLES, 0)
    judge = Judge(mechanism, states)
    for wrong in copies(mechanism):
        count.copies += 1
        if judge.finds(judge.inertial(wrong)) or judge.finds(judge.all(wrong)):
            count.found += 1
        else:
            missed.add(wrong.what)
    for wrong in copies(mechanism, LARGER * ERROR) if missed else ():
        if wrong.what not in missed:
            continue
        missed.remove(wrong.what)
        rows = judge.rows(judge.all(wrong))
        where = max(rows, key=part_of)
        part, adds = part_of(where) / LARGER, where.worst / LARGER
        if all(row.agrees for row in rows):
            count.absent += 1
            continue
        count.below += part < 1
        count.hidden += part >= 1
        print(
            f"  {'below rounding' if part < 1 else 'HIDDEN'}: {wrong.what}: adds {adds:.0e}, "
            f"{part:.1e} of what is allowed, of {where.quantity} {' '.join(where.entry)}"
        )
    count.below += len(missed)
    for what in sorted(missed):
        print(f"  no larger error is possible: {what}")
    return count


def part_of(row: Row) -> float:
    """Return how much of what is allowed a difference is."""
    return row.worst / row.allowed if row.allowed else (np.inf if row.worst else 0.0)


class Judge:
    """What is right at some states, and what a comparison with it allows by default."""

    def __init__(self, mechanism: mq.Mechanism, states: States) -> None:
        self.mechanism, self.states = mechanism, states
        self.right = evaluate(mq.derive(mechanism), states)
        self.bound = rounding(mechanism, states, self.right)
        self.entries = entry_rounding(mechanism, states)

    def rows(self, theirs: Values) -> tuple[Row, ...]:
        """Compare another source with what is right."""
        return rows_of(
            PAIR,
            theirs,
            self.right,
            self.states,
            self.mechanism,
            rounding=self.bound,
            entries=self.entries,
            tolerance=None,
        )

    def finds(self, theirs: Values) -> bool:
        """Return whether another source disagrees."""
        return not all(row.agrees for row in self.rows(theirs))

    def all(self, wrong: Wrong) -> Values:
        """Return everything that a wrong copy says."""
        return evaluate(mq.derive(wrong.mechanism), self._there(wrong))

    def inertial(self, wrong: Wrong) -> Values:
        """Return what is fast to compute and contains almost every number."""
        fast, there = Recursion(wrong.mechanism), self._there(wrong)
        return {"mass matrix": fast.mass_matrix(there), "bias": fast.bias(there)}

    def _there(self, wrong: Wrong) -> States:
        return replace(self.states, mechanism=wrong.mechanism)


def mechanisms(names: list[str]) -> Iterator[tuple[str, mq.Mechanism]]:
    """Yield the mechanisms by name, robots floating."""
    for name in names or (*mq.textbook.names(), *mq.robots()):
        if name in mq.textbook.names():
            yield name, mq.textbook.load(name)
            continue
        path = Path(name) if Path(name).is_file() else mq.robot(name)
        try:
            yield name, mq.read_urdf(path, root="floating")
        except MecaniqueError as error:
            print(f"{name}: refused: {str(error).splitlines()[0]}")


def main(*names: str) -> int:
    """Return the number of errors that are neither found nor below rounding."""
    begin, total = time.perf_counter(), Count("all")
    for name, mechanism in mechanisms(list(names)):
        try:
            count = inject(name, mechanism)
        except MecaniqueError as error:
            print(f"{name}: {str(error).splitlines()[0]}")
            continue
        print(_line(count), flush=True)
        for field in ("copies", "found", "below", "hidden", "absent"):
            setattr(total, field, getattr(total, field) + getattr(count, field))
    print(_line(total))
    print(f"{time.perf_counter() - begin:.0f} s")
    return total.hidden


def _line(count: Count) -> str:
    return (
        f"{count.name:32} {count.found:5} of {count.copies:5} found, {count.below:3} below "
        f"rounding, {count.hidden} hidden, {count.absent} not contained"
    )


if __name__ == "__main__":
    raise SystemExit(min(1, main(*sys.argv[1:])))
