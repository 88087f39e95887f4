"""Inject an error of a millionth into every mass, center, inertia and length, and look for it.

Run it by hand: python tests/benchmarks/bench_injections.py [NAME …]
without names over all textbook systems and all robots of example-robot-data. An error is found if a
row of the comparison exceeds what `verify` allows there; it is hidden if it exceeds the tolerance,
but not what rounding may make: there must be none. What is lighter beside that which moves with it
is looked for again with `verify(…, tolerance=1e-12)`. The rest is printed with the largest relative
difference that it makes of any quantity; it is 0 where the equations do not contain the number: the
mass of what is fixed to the ground, the place of a frame without mass, or of a hinge on its axis, a
loop's frame on body a, which only decides where the loop closes. Robots float, so that the base
counts as well.
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
from mecanique.model.states import States
from mecanique.model.units import characteristic_length
from mecanique.threads import one_thread_for_loops
from mecanique.verification.conditioning import rounding
from mecanique.verification.rows import TOLERANCE, Values, evaluate, rows_of
from mecanique.verification.states.random import random_states

sys.path.insert(0, str(Path(__file__).parents[1] / "verification"))
from verification_injections import heavy, parts, with_body, with_joint

ERROR = 1e-6
"""Relative error of a mass, a center, an inertia or a length."""

FINE = 1e-12
"""The tolerance with which light parts are looked for."""

ABSENT = 1e-13
"""What differs by less does so by rounding."""

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
    fine: int = 0
    hidden: int = 0
    absent: int = 0


def copies(mechanism: mq.Mechanism) -> Iterator[Wrong]:
    """Yield a copy for every number that is not zero."""
    length = characteristic_length(mechanism)
    for body in heavy(mechanism):
        mass, center, inertia = parts(mechanism, body)
        for what, factors in (
            ("mass", (1 + ERROR, 1, 1)),
            ("center", (1, 1 + ERROR, 1)),
            ("inertia", (1, 1, 1 + ERROR)),
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
        if (origin := _longer(mechanism, joint.origin)) is not None:
            yield Wrong(f"origin of {joint.name}", with_joint(mechanism, joint.name, origin=origin))
    for loop in mechanism.loops:
        for field in ("frame_a", "frame_b"):
            if (frame := _longer(mechanism, getattr(loop, field))) is not None:
                moved: dict[str, Any] = {field: frame}
                changed_loop = replace(loop, **moved)
                loops = tuple(changed_loop if x is loop else x for x in mechanism.loops)
                yield Wrong(f"{field} of {loop.name}", replace(mechanism, loops=loops))


def _longer(mechanism: mq.Mechanism, place: mq.Placement) -> mq.Placement | None:
    xyz: Any = tuple(mechanism.evaluate(x) * (1 + ERROR) for x in place.xyz)
    reach = NOTHING * characteristic_length(mechanism)
    return replace(place, xyz=xyz) if max(map(abs, xyz)) > reach else None


@one_thread_for_loops
def inject(name: str, mechanism: mq.Mechanism) -> Count:
    """Inject every error into one mechanism."""
    count = Count(name)
    states = random_states(mechanism, SAMPLES, 0)
    ours = evaluate(mq.derive(mechanism), states)
    bound = rounding(mechanism, states, ours)
    for wrong in copies(mechanism):
        count.copies += 1
        if _found(_inertial(wrong.mechanism, states), ours, states, mechanism, bound):
            count.found += 1
            continue
        theirs = _values(wrong.mechanism, states)
        strict = max(row.worst for row in rows_of(PAIR, ours, theirs, states, mechanism))
        if _found(theirs, ours, states, mechanism, bound):
            count.found += 1
        elif strict > TOLERANCE:
            count.hidden += 1
            print(f"  HIDDEN: {wrong.what}: {strict:.1e}")
        elif _found(theirs, ours, states, mechanism, bound, FINE):
            count.fine += 1
        else:
            count.absent += strict < ABSENT
            print(f"  not found: {wrong.what}: differs by {strict:.1e}")
    return count


def _values(mechanism: mq.Mechanism, states: States) -> Values:
    return evaluate(mq.derive(mechanism), replace(states, mechanism=mechanism))


def _inertial(mechanism: mq.Mechanism, states: States) -> Values:
    """Return what is fast to compute and contains almost every number."""
    fast, there = Recursion(mechanism), replace(states, mechanism=mechanism)
    return {"mass matrix": fast.mass_matrix(there), "bias": fast.bias(there)}


def _found(
    theirs: Values,
    ours: Values,
    states: States,
    mechanism: mq.Mechanism,
    bound: Values,
    tolerance: float = TOLERANCE,
) -> bool:
    """Return whether a comparison with this tolerance disagrees."""
    rows = rows_of(PAIR, theirs, ours, states, mechanism, rounding=bound, tolerance=tolerance)
    return any(row.worst > max(tolerance, row.rounding) for row in rows)


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
    """Return the number of errors that rounding hides."""
    begin, total = time.perf_counter(), Count("all")
    for name, mechanism in mechanisms(list(names)):
        try:
            count = inject(name, mechanism)
        except MecaniqueError as error:
            print(f"{name}: {str(error).splitlines()[0]}")
            continue
        print(_line(count), flush=True)
        for field in ("copies", "found", "fine", "hidden", "absent"):
            setattr(total, field, getattr(total, field) + getattr(count, field))
    print(_line(total))
    print(f"{time.perf_counter() - begin:.0f} s")
    return total.hidden


def _line(count: Count) -> str:
    return (
        f"{count.name:32} {count.found:5} of {count.copies:5} found, {count.fine:3} more with the "
        f"tolerance {FINE:.0e}; {count.hidden} hidden, {count.absent} not contained"
    )


if __name__ == "__main__":
    raise SystemExit(min(1, main(*sys.argv[1:])))
