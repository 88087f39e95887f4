"""Call every public callable with wrong arguments, and count what is not refused in words.

python tests/benchmarks/fuzz_arguments.py [--seconds 2] [--only simulate]

Each argument of a sound call is replaced by each of the wrong ones. What must not come of it is any
exception but the documented ones: `MecaniqueError`, and Python's own TypeError for a wrong number
or name of arguments; nor numbers that are none."""

from __future__ import annotations

import argparse
import inspect
import os
import signal
import sys
import tempfile
import warnings
from collections import Counter
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

import mecanique as mq

WRONG = {
    "str": "x",
    "number": 3,
    "negative": -1.5,
    "None": None,
    "list": [1, "a"],
    "dict": {"a": object()},
    "object": object(),
    "nan": float("nan"),
    "huge": 1e308,
    "long": 10**400,
    "array": np.zeros((2, 3)),
    "bytes": b"x",
    "class": dict,
}
"""Wrong arguments by name; some are right in some places."""

SKIPPED = {"inspect", "view", "view_online"}
"""What opens pages or runs long."""


def sample_arguments() -> dict[str, Any]:
    """Return a sound argument for each parameter that is named so, or annotated so."""
    mechanism = mq.textbook.load("simple_pendulum")
    equations = mq.derive(mechanism)
    motion = mq.simulate(mechanism, q=[0.3], duration=0.2)
    return {
        "Mechanism": mechanism,
        "Mechanism | str | os.PathLike[str]": mechanism,
        "Motion": motion,
        "Motion | Mechanism": motion,
        "Equations": equations,
        "Linearization": mq.linearize(mechanism),
        "Given": [0.1],
        "np.ndarray": np.array([0.1]),
        "Array": np.array([0.1]),
        "float": 1.0,
        "int": 2,
        "str": "q",
        "bool": True,
        "Scalar": 1.5,
        "Point": ("a", (0.0, 0.0, 0.0)),
        "Vector": (0.0, 0.0, 1.0),
        "Placement": mq.Placement(),
        "tuple[str, ...]": ("q",),
        "Sequence[str]": ("q",),
        "Sequence[Scalar]": (1.0, 2.0),
        "Sequence[Vector]": ((0.0, 0.0, 1.0),),
        "tuple[Body, ...]": mechanism.bodies,
        "tuple[Joint, ...]": mechanism.joints,
        "float | np.ndarray": 0.0,
        "Iterable[float]": [0.1, 0.2],
        "Iterable[str]": ["q"],
    }


def list_owners(samples: dict[str, Any]) -> Iterator[Any]:
    """Yield an object of each class whose methods are called."""
    mechanism = samples["Mechanism"]
    yield from (samples[name] for name in ("Mechanism", "Motion", "Equations", "Linearization"))
    yield mq.Reference(mechanism)
    yield from (mechanism.bodies[1], mechanism.bodies[1].visuals[0], mechanism.joints[0])
    yield from (mechanism.parameters[0], mq.rod(1.0, 2.0), mq.Wrench(np.eye(3)[0], np.eye(3)[1]))
    yield mq.verify(mechanism, samples=2)
    yield mq.check(mechanism, "q'' + g/l sin q = 0")
    yield samples["Equations"].solved()
    yield mq.generate(samples["Equations"], "python")
    yield mq.simulate_many(mechanism, q={"q": [0.1, 0.2]}, duration=0.1)
    yield mq.routh(mq.textbook.load("spherical_pendulum"))
    yield samples["Motion"].audit()


def find_nan(value: Any) -> bool:
    """Return whether there is a NaN among numbers that are returned."""
    if isinstance(value, (tuple, list)):
        return any(find_nan(entry) for entry in value)
    if isinstance(value, dict):
        return any(find_nan(entry) for entry in value.values())
    if isinstance(value, (float, np.ndarray, np.generic)):
        numbers = np.asarray(value)
        return numbers.dtype.kind in "fc" and bool(np.isnan(numbers).any())
    return False


def list_calls(only: str) -> Iterator[tuple[str, Callable[..., Any], list[str], dict[str, Any]]]:
    """Yield name, callable, its parameters, and the arguments of a sound call."""
    samples = sample_arguments()
    doors: dict[str, Any] = {name: getattr(mq, name) for name in mq.__all__ if name not in SKIPPED}
    for owner in list_owners(samples):
        for name, member in inspect.getmembers(owner, inspect.ismethod):
            if not name.startswith("_"):
                doors[f"{type(owner).__name__}.{name}"] = member
    for name, door in doors.items():
        if only not in name or not callable(door):
            continue
        try:
            parameters = inspect.signature(door).parameters.values()
        except ValueError:  # exceptions have no signature
            continue
        known = {p.name: samples.get(str(p.annotation)) for p in parameters}
        needed = {
            p.name: known[p.name]
            for p in parameters
            if p.default is p.empty
            and p.kind is not p.VAR_POSITIONAL
            and p.kind is not p.VAR_KEYWORD
        }
        names = [p.name for p in parameters if p.kind not in (p.VAR_POSITIONAL, p.VAR_KEYWORD)]
        if all(value is not None for value in needed.values()):
            yield name, door, names, needed


def call(door: Callable[..., Any], given: dict[str, Any]) -> Any:
    """Return what comes of a call with arguments by name, by place where that is the only way."""
    parameters = inspect.signature(door).parameters.values()
    placed = [
        given.pop(p.name) for p in parameters if p.kind is p.POSITIONAL_ONLY and p.name in given
    ]
    return door(*placed, **given)


def stop(*_: object) -> None:
    """End a call that takes too long."""
    raise TimeoutError("no end")


def main() -> int:
    """Make the calls and print the figures; the exit code says whether one failed."""
    words = argparse.ArgumentParser(description=__doc__)
    words.add_argument("--seconds", type=float, default=2.0, help="longest time of a call")
    words.add_argument("--only", default="", help="part of the names of what is called")
    given = words.parse_args()
    warnings.simplefilter("ignore")
    os.chdir(tempfile.mkdtemp(prefix="fuzz_arguments"))  # some calls write files
    signal.signal(signal.SIGALRM, stop)
    counts: Counter[str] = Counter()
    faults: Counter[str] = Counter()
    for name, door, names, needed in list_calls(given.only):
        for parameter in names:
            for label, wrong in WRONG.items():
                if parameter == "progress" and callable(wrong):
                    continue  # what a user's function raises stays as it is
                signal.setitimer(signal.ITIMER_REAL, given.seconds)
                try:
                    answer = call(door, {**needed, parameter: wrong})
                    counts["taken"] += 1
                    if label != "nan" and find_nan(answer):
                        raise ArithmeticError("silent NaN")
                except mq.MecaniqueError:
                    counts["refused"] += 1
                except Exception as error:
                    counts["failed"] += 1
                    said = str(error).splitlines()[0][:90] if str(error) else ""
                    faults[f"{name}({parameter}): {type(error).__name__}: {said}"] += 1
                    print(
                        f"{name}({parameter}={label}): {type(error).__name__}: {said}",
                        file=sys.stderr,
                    )
                finally:
                    signal.setitimer(signal.ITIMER_REAL, 0.0)
    print(dict(counts))
    for fault, number in faults.most_common(40):
        print(number, fault)
    return int(bool(faults))


if __name__ == "__main__":
    sys.exit(main())
