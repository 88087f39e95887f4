"""Exercises: a problem with its figure and numbers, and the solution with its steps, verified."""

from __future__ import annotations

import math
import random
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, final

from mecanique.checking.check import Checker
from mecanique.errors import InputError, MechanismError, UnknownNameError
from mecanique.figure.draw import picture
from mecanique.figure.setting import posture
from mecanique.files import write_whole
from mecanique.model import Coordinates, Mechanism, Parameter, Revolute, coordinate
from mecanique.teaching.answers import KINDS, Solver
from mecanique.textbook.catalogue import entry

if TYPE_CHECKING:
    from mecanique.checking.verdict import Check


ASKED = tuple(KINDS)
"""What an exercise may ask for."""

_FORM = 0.5
_SPREAD = (0.5, 2.0)
"""Parameters vary within these multiples of the catalogue's values."""


@final
@dataclass(frozen=True)
class Exercise:
    """A problem and its solution."""

    title: str  # of the system
    mechanism: Mechanism  # with the numbers of this variant
    ask: str  # what is asked for
    problem: str  # the text, in Markdown
    solution: str  # with its steps, in Markdown
    answer: str  # the result, as `mecanique.check` reads it
    check: Check  # the verdict on the answer
    given: str = ""  # the numbers of this variant, with their units
    # from 1 to 5, by the steps to its answer, its degrees of freedom, couplings and constraints
    difficulty: int = 1

    @property
    def rounded(self) -> bool:
        """Whether its answer is in numbers, which are rounded."""
        return not self.check.right

    @property
    def form(self) -> float:
        """The part of the points for an answer that is right except for form."""
        return 1.0 if self.rounded else _FORM

    def write(self, folder: Path | str) -> tuple[Path, ...]:
        """Write problem.md, figure.svg and solution.md into a folder, which is made if need be."""
        place = Path(folder)
        place.mkdir(parents=True, exist_ok=True)
        # at zero a linkage may be stretched, so that it is drawn where its motion starts
        start = entry(self.mechanism.name).start if self.mechanism.constrained else {}
        position = posture(self.mechanism, start).tolist()
        figure = picture(self.mechanism, path=place / "figure.svg", q=position)
        paths = [place / "problem.md", figure, place / "solution.md"]
        for path, text in ((paths[0], self.problem), (paths[2], self.solution)):
            with write_whole(path) as file:
                file.write(text.encode())
        return tuple(paths)


def make_exercise(
    system: str, ask: str = "equation of motion", seed: int = 0, *, turned: bool = True
) -> Exercise:
    """Make a variant of a textbook system an exercise: other numbers, or another coordinate."""
    # turned: an angle may be counted the other way round
    # the answer is checked at random states before it is handed out
    if ask not in ASKED:
        raise UnknownNameError("question of an exercise", ask, ASKED)
    card = entry(system)
    draw = random.Random(f"{system} {ask} {seed}")
    numbers = {p.symbol: _vary(p, draw) for p in card.parameters}
    try:
        mechanism = card.mechanism(**numbers)
    except MechanismError:
        # moments of inertia that no body has together; the catalogue's are those of one
        mechanism = card.mechanism()
    kind, note = KINDS[ask], ""
    if turned and (kind.ask or ask) != "frequency":
        mechanism, note = _turn(mechanism, draw)
    solver = Solver(mechanism)
    answer, steps, what, more = solver.ask(ask)
    task = _word_task(kind.task, mechanism.coordinates.names, what, more)
    asked = (kind.ask or ask) + kind.of.format(what=what)
    verdict = Checker(mechanism).check(answer, asked)
    rounded = bool(more) and verdict.outcome == "right except for form"
    if not (verdict.right or rounded):
        raise InputError(
            f"no exercise about the {ask} of {system!r}: {verdict.form or 'it is not determined'}"
        )
    statement = card.statement.partition("\n")[2].strip()
    given = ", ".join(
        f"{p.symbol} = {p.value:g}{f' {p.unit}' if p.unit != '1' else ''}"
        + (f" ({p.meaning})" if p.meaning else "")
        for p in mechanism.parameters
    )
    problem = "\n\n".join(
        part
        for part in (
            f"# {card.title}",
            statement,
            note,
            "![The system](figure.svg)",
            f"Given: {given}." if given else "",
            f"**{task}**",
        )
        if part
    )
    solution = "\n\n".join(
        [
            f"# {card.title}: solution",
            f"```text\n{steps}\n```",
            f"Result:\n\n```text\n{answer}\n```",
            f"Checked: {verdict.summary}{f': {verdict.form}' if verdict.form else ''}.",
            f"Difficulty: {solver.rate_difficulty(ask)} of 5.",
        ]
    )
    return Exercise(
        title=card.title,
        mechanism=mechanism,
        ask=asked,
        problem=f"{problem}\n",
        solution=f"{solution}\n",
        answer=answer,
        check=verdict,
        given=given,
        difficulty=solver.rate_difficulty(ask),
    )


def _word_task(task: str, names: tuple[str, ...], what: str, note: str) -> str:
    """Return the question in words."""
    several, listed = len(names) > 1, ", ".join(names)
    return task.format(
        q=f"coordinates {listed}" if several else f"coordinate {listed}",
        equations="equations" if several else "equation",
        momenta="momenta" if several else "momentum",
        frequencies="frequencies" if several else "frequency",
        periods="periods" if several else "period",
        accelerations="accelerations" if several else "acceleration",
        rates="their rates" if several else "its rate",
        order=", in this order" if several else "",
        what=what,
        note=note,
    )


def _vary(parameter: Parameter, draw: random.Random) -> float:
    """Return a number with two digits near the catalogue's."""
    if parameter.unit == "m/s²" or not parameter.value or parameter.unit in ("1", "rad"):
        return parameter.value
    value = parameter.value * draw.uniform(*_SPREAD)
    digits = 1 - math.floor(math.log10(abs(value)))
    return round(value, digits)


def _turn(mechanism: Mechanism, draw: random.Random) -> tuple[Mechanism, str]:
    """Return the mechanism with one angle counted the other way round, or as it is."""
    if mechanism.coordinates.driven or mechanism.constrained or draw.random() < 1 / 2:
        return mechanism, ""
    angles = [j.coordinate for j in mechanism.joints if isinstance(j, Revolute)]
    angles = [name for name in angles if name not in mechanism.coordinates.limits]
    if not angles or "psi" in (*mechanism.coordinates, *mechanism.values):
        return mechanism, ""
    chosen = draw.choice(angles)
    names = tuple("psi" if name == chosen else name for name in mechanism.coordinates)
    limits = mechanism.coordinates.limits
    turned = Coordinates(names, {chosen: -coordinate("psi")}, limits)
    note = (
        f"In this variant the angle psi = −{chosen} is the coordinate: it is counted the other "
        f"way round than {chosen} above."
    )
    return replace(mechanism, coordinates=turned), note
