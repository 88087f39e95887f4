"""Exercises: a problem with its figure and numbers, and the solution with its steps, verified."""

from __future__ import annotations

import inspect
import math
import random
from dataclasses import dataclass, replace
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, final

from mecanique.checking.check import Checker
from mecanique.derivation import derive
from mecanique.derivation.document import Document
from mecanique.derivation.printing.equations import expression
from mecanique.derivation.symbolic.lagrange import Lagrange
from mecanique.errors import (
    ClosureError,
    DerivationError,
    InputError,
    MechanismError,
    UnknownNameError,
)
from mecanique.figure.draw import picture
from mecanique.figure.setting import posture
from mecanique.files import write_whole
from mecanique.model.coordinates import Coordinates
from mecanique.model.expression import coordinate
from mecanique.model.joints import Revolute
from mecanique.model.mechanism import Mechanism
from mecanique.model.parameters import Parameter
from mecanique.motion.linear.linearize import linearize
from mecanique.textbook.catalogue import entry

if TYPE_CHECKING:
    from mecanique.checking.verdict import Check


ASKED = (
    "equation of motion",
    "kinetic energy",
    "potential energy",
    "Lagrangian",
    "mass matrix",
    "frequency",
)
"""What an exercise may ask for."""

_TASKS = {
    "equation of motion": "Derive the {equations} of motion in the {q}.",
    "kinetic energy": "Write the kinetic energy T in the {q} and {rates}.",
    "potential energy": "Write the potential energy V in the {q}.",
    "Lagrangian": "Write Lagrange's function L = T − V in the {q} and {rates}.",
    "mass matrix": "Write the mass matrix M for the {q}{order}.",
    "frequency": "Find the natural angular frequenc{plural} of small motions about {place}.",
}
"""The question in words."""

_LAST = {
    "kinetic energy": "Kinetic energy",
    "potential energy": "Potential energy",
    "Lagrangian": "Potential energy",
    "mass matrix": "Kinetic energy",
}
"""The last step of a derivation that an answer needs."""

_FROM_T = """
   The entry of the mass matrix for two coordinates is the second derivative of T by their rates:
   M_ij = ∂²T/∂q_i' ∂q_j', for T is half of the sum of M_ij q_i' q_j'."""

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

    @property
    def rounded(self) -> bool:
        """Whether its answer is in numbers, which are rounded."""
        return not self.check.right

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
    note = ""
    if turned and ask != "frequency":
        mechanism, note = _turn(mechanism, draw)
    if ask == "frequency":
        answer, steps, task = _ask_frequency(mechanism)
    else:
        answer, steps = _answer(mechanism, ask)
        task = _word_task(ask, mechanism.coordinates.names)
    verdict = Checker(mechanism).check(answer, ask)
    rounded = ask == "frequency" and verdict.outcome == "right except for form"
    if not (verdict.right or rounded):
        raise InputError(
            f"no exercise about the {ask} of {system!r}: {verdict.form or 'it is not determined'}"
        )
    statement = inspect.cleandoc(
        import_module(f"mecanique.textbook.systems.{system}").__doc__ or ""
    )
    statement = statement.partition("\n")[2].strip()
    given = _write_data(mechanism)
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
        ]
    )
    return Exercise(
        title=card.title,
        mechanism=mechanism,
        ask=ask,
        problem=f"{problem}\n",
        solution=f"{solution}\n",
        answer=answer,
        check=verdict,
        given=given,
    )


def _word_task(ask: str, names: tuple[str, ...]) -> str:
    """Return the question in words."""
    several, listed = len(names) > 1, ", ".join(names)
    return _TASKS[ask].format(
        q=f"coordinates {listed}" if several else f"coordinate {listed}",
        equations="equations" if several else "equation",
        rates="their rates" if several else "its rate",
        order=", in this order" if several else "",
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


def _write_data(mechanism: Mechanism) -> str:
    return ", ".join(
        f"{p.symbol} = {p.value:g}{f' {p.unit}' if p.unit != '1' else ''}"
        + (f" ({p.meaning})" if p.meaning else "")
        for p in mechanism.parameters
    )


def _answer(mechanism: Mechanism, ask: str) -> tuple[str, str]:
    """Return the answer and its steps."""
    equations = derive(mechanism)
    try:
        steps = equations.text(steps=True) if equations.derivation else ""
    except DerivationError as error:
        raise InputError(f"no exercise about {mechanism.name!r}: {error}") from None
    if ask == "equation of motion":
        return equations.text(), steps
    steps = _cut(equations.document, _LAST[ask])
    if ask == "mass matrix":
        steps += _FROM_T
        rows = []
        for row in equations.derivation.M:
            entries = ", ".join(expression(entry).text() for entry in row)
            rows.append(f"[{entries}]")
        return f"[{', '.join(rows)}]", steps
    lagrange = Lagrange(mechanism)
    chosen = {
        "kinetic energy": ("T", lagrange.T),
        "potential energy": ("V", lagrange.V),
        "Lagrangian": ("L", lagrange.T - lagrange.V),
    }[ask]
    return f"{chosen[0]} = {expression(chosen[1]).text()}", steps


def _cut(document: Document, last: str) -> str:
    """Return the steps of a derivation up to the one with a title."""
    stages = document.derivation.stages
    titles = [stage.title for stage in stages]
    kept = stages[: titles.index(last) + 1] if last in titles else stages
    derivation = replace(document.derivation, stages=kept, assumptions=())
    text = replace(document, derivation=derivation).text(steps=True)
    return text.partition(f"\n\n{len(kept) + 1}. Equations of motion")[0]


def _ask_frequency(mechanism: Mechanism) -> tuple[str, str, str]:
    """Return answer, steps and question: in letters of one frequency at zero, else in numbers."""
    try:
        small = linearize(mechanism)
        letters = small.symbolic
    except (ClosureError, DerivationError, InputError) as error:
        raise InputError(f"no exercise about the frequency: {error}") from None
    if not small.stable or small.C.any() or not small.frequencies.any():
        raise InputError(
            f"no exercise about the frequency of {mechanism.name!r}: expected an undamped "
            "mechanism that swings about a stable equilibrium"
        )
    place = ", ".join(f"{n} = {x:.4g}" for n, x in zip(mechanism.coordinates, small.q, strict=True))
    several = len(small.frequencies) > 1
    named = [
        f"omega{k if several else ''} = {omega:.4g} rad/s"
        for k, omega in enumerate(small.frequencies, 1)
    ]
    task = _TASKS["frequency"].format(plural="ies" if several else "y", place=place)
    answer = "\n".join(named)
    if letters.square is not None and not small.q.any():
        answer = f"omega = sqrt({expression(letters.square).text()})"
    else:
        task = f"{task[:-1]}, for the numbers given, to four digits."
    said = f"With the numbers given: {', '.join(named)}"
    lines = ("Equations of motion:", derive(mechanism).text(), "", letters.text(), "", said)
    return answer, "\n".join(lines), task
