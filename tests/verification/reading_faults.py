"""Faults of reading: a text altered as a reader could mistake it."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import Any, Literal

import numpy as np
import pytest

import mecanique as mq
from mecanique.verification.engines import ENGINES, read_by
from mecanique.verification.verdict import OURS, EngineReading, dissenters_among

Change = Callable[[list[float]], list[float]]
Root = Literal["fixed", "floating"]


def _scaled(factor: float) -> Change:
    return lambda values: [factor * value for value in values]


def _entry(index: int, factor: float) -> Change:
    return lambda values: [factor * x if k == index else x for k, x in enumerate(values)]


FAULTS: dict[str, tuple[str, str, Change]] = {
    "mass in grams": ("mass", "value", _scaled(1000.0)),
    "mass of another link": ("mass", "value", _scaled(1.07)),
    "moment doubled": ("inertia", "ixx", _scaled(2.0)),
    "moment lost": ("inertia", "izz", _scaled(0.5)),
    "place in millimeters": ("origin", "xyz", _scaled(0.001)),
    "place mirrored": ("origin", "xyz", _entry(1, -1.0)),
    "place turned": ("origin", "xyz", lambda values: [values[1], values[0], values[2]]),
    "angles in degrees": ("origin", "rpy", _scaled(np.pi / 180)),
    "axis turned": ("axis", "xyz", lambda values: [values[1], values[2], values[0]]),
    "angles backwards": ("origin", "rpy", lambda values: values[::-1]),
}
"""What a reader mistakes, by element and attribute."""

ROBOTS = ("ur5_robot", "panda", "solo12", "double_pendulum")
PACKAGES = {"pinocchio": "pin", "mujoco": "mujoco", "drake": "drake", "exudyn": "exudyn"}


def alter(text: str, fault: str, random: np.random.Generator) -> str | None:
    """Return a text with the fault at an element drawn by chance; None if it changes nothing."""
    tag, attribute, change = FAULTS[fault]
    pattern = re.compile(rf'(<{tag}\b[^>]*?\b{attribute}=")([^"]+)(")')
    places = []
    for match in pattern.finditer(text):
        values = [float(word) for word in match[2].split()]
        if not np.allclose(values, change(values), rtol=1e-3, atol=0.0):
            places.append((match, change(values)))
    if not places:
        return None
    match, values = places[int(random.integers(len(places)))]
    numbers = " ".join(map(repr, values))
    return text[: match.start(2)] + numbers + text[match.end(2) :]


@contextmanager
def misread(culprit: str, right: str, wrong: str, root: Root) -> Iterator[mq.Mechanism]:
    """Let one source read a text wrongly, and give the mechanism whose readings are compared."""

    def reader(name: str) -> Any:
        return lambda _, *given: read[name]((wrong if name == culprit else right).encode(), *given)

    read = {name: engine.read for name, engine in ENGINES.items()}
    with pytest.MonkeyPatch.context() as patch:
        for name, engine in ENGINES.items():
            patch.setitem(ENGINES, name, replace(engine, read=reader(name)))
        text = wrong if culprit == OURS else right
        yield mq.read_urdf(text, root=root) if "<robot" in text else mq.read(text)


def blame(
    culprit: str,
    first: int,
    fault: str,
    engines: Sequence[str],
    seed: int,
    root: Root = "fixed",
) -> tuple[str, tuple[str, ...], tuple[EngineReading, ...]]:
    """Return a robot, who is blamed for a fault in it, and the readings.

    The robots are tried from the given one on, until the fault has an effect.
    """
    random = np.random.default_rng(seed)
    # Drake holds links that are called "world", as the root of ur5_robot is
    robots = ROBOTS if root == "fixed" else ROBOTS[1:]
    for k in range(20):  # a link before the first joint moves nothing
        robot = robots[(first + k) % len(robots)]
        right = Path(mq.robot(robot)).read_text(encoding="utf-8")
        wrong = alter(right, fault, random)
        if wrong is None:
            continue
        with misread(culprit, right, wrong, root) as mechanism:
            readings = read_by(mechanism, engines, seed)
        if any(reading.differs for reading in readings):
            break
    return robot, name_dissenters(readings), readings


def name_dissenters(readings: Sequence[EngineReading]) -> tuple[str, ...]:
    """Return the names by which the sources that stand alone are asked."""
    names = {engine.title: name for name, engine in ENGINES.items()}
    return tuple(names.get(who.split()[0], who) for who in dissenters_among(readings))
