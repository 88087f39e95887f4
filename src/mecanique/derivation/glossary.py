"""State what every symbol of a derivation means, and in which unit its equations are."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import chain
from typing import final

from mecanique.derivation.coordinates import CoordinateWords
from mecanique.derivation.printing.equations import expression, root
from mecanique.derivation.printing.expressions import to_sympy
from mecanique.derivation.printing.writers import Equation, Expression
from mecanique.derivation.scalars.series import FOLLOWER, Kind, Series
from mecanique.derivation.symbolic.derivation import (
    DISTANCE,
    INDEPENDENT,
    Derivation,
    Ending,
    Left,
    lefts_of,
)
from mecanique.derivation.symbolic.kinematics import RELATIONS, follow
from mecanique.model.mechanism import Mechanism
from mecanique.model.mechanism.homogeneity import dimensions_of
from mecanique.model.units import (
    Dimension,
    Dimensions,
    HomogeneityError,
    divide,
    read_unit,
    say_unit,
)
from mecanique.wording import enumerate_words

UNIT_AT_END = re.compile(r"\[([^\]]*)\]$")
"""The unit in brackets at the end of a symbol's meaning."""


def find_units(derivation: Derivation, equation: Equation) -> tuple[Dimension | None, ...]:
    """Return the dimension of each term; None where a plain number stands for a quantity."""
    # the mechanism's own letters, then a, roots and multipliers
    algebra = derivation.algebra
    stated = dimensions_of(algebra.mechanism)
    known = {**stated.states, **stated.declared}
    for velocity in algebra.velocities:
        if velocity in known:
            known[f"{velocity}'"] = divide(known[velocity], read_unit("s"))
    for name, sentence in derivation.unknowns.items():
        if unit := UNIT_AT_END.search(sentence):
            known[name] = read_unit(unit[1])
    for index, atom in algebra.ring.atoms.items():
        its = Dimensions(known, {}).of(to_sympy(atom.argument))
        if atom.named and atom.function == "sqrt" and its is not None:
            known[algebra.ring.generators[index].name] = tuple(Fraction(x) / 2 for x in its)
    dimensions = Dimensions(known, {})
    units: list[Dimension | None] = []
    for term in (*equation.left.terms, *equation.right.terms):
        try:
            units.append(dimensions.of(term.sympy()))
        except HomogeneityError:  # a plain number stands for a quantity with a unit
            units.append(None)
    return tuple(units)


def unit_of(derivation: Derivation, equation: Equation) -> str:
    """Return the unit of the terms of an equation, that of most terms if they differ."""
    # They differ where plain numbers stand for quantities with a unit
    known = [its for its in find_units(derivation, equation) if its is not None]
    return say_unit(Counter(known).most_common(1)[0][0]) if known else ""


_FOUND = {
    "T": ("kinetic energy", "J"),
    "V": ("potential energy", "J"),
    "V_eff": ("effective potential", "J"),
    "E": ("total energy, T + V", "J"),
    "h": ("Jacobi's integral", "J"),
    "D": ("Rayleigh's dissipation function", "W"),
    "R": ("Routh's function", "J"),
}
"""The meaning and unit of each letter without an index that a step may have on its left side."""

_WHICH = re.compile(
    r"(.*\b(?:along|about) |.*, |virtual displacement (?:of|that belongs to the velocity) )"
    r"(-?\w+)( of .*| component in .*|: small, .*)"
)
"""What several components, or the displacements of several coordinates, mean alike."""

_TOLD = {DISTANCE, INDEPENDENT}
"""Meanings that the steps state themselves."""


@final
@dataclass(frozen=True)
class Meaning:
    """The meaning of a symbol, or of several components of one quantity."""

    names: tuple[str, ...]
    sentence: str
    # the value, if the symbol is an abbreviation or follows from others
    definition: Expression | None = None
    told: bool = False  # whether the steps themselves explain it where it first stands


def meanings(
    derivation: Derivation, endings: Sequence[Ending] = (), *, steps: bool = True
) -> tuple[Meaning, ...]:
    """Return the meaning of every printed symbol, in the order of the list of symbols."""
    algebra = derivation.algebra
    ring, mechanism = algebra.ring, algebra.mechanism
    used = _collect_kinds(derivation, steps=steps)
    led = any(stage.title == RELATIONS for stage in derivation.stages)
    followers = [*_explain_followers(derivation, used, led=led)]
    if steps and led:
        followers = [replace(entry, definition=None) for entry in followers]
    signals = [*_explain_signals(derivation, used)]
    for entry in [*followers, *signals]:
        stated = entry.definition.letters if entry.definition is not None else ()
        used |= {name: Kind.PARAMETER for name in stated if name not in used}
    words = CoordinateWords(mechanism).sentences()
    entries = [*(Meaning((name,), sentence) for name, sentence in words), *followers]
    for parameter in mechanism.parameters:
        if parameter.symbol in used:
            sentence = _add_unit(parameter.meaning or "parameter", parameter.unit)
            entries.append(Meaning((parameter.symbol,), sentence))
    entries += signals
    for index, atom in ring.atoms.items():
        name = ring.generators[index].name
        if atom.named and atom.function != FOLLOWER and used.get(name) is Kind.ATOM:
            sentence = derivation.lengths.get(name, "root")
            entries.append(Meaning((name,), sentence, root(atom.argument)))
    together: dict[tuple[str, str], dict[str, str]] = {}
    new = {name: meant for ending in endings for name, meant in ending.unknowns.items()}
    explained = {name for ending in endings if ending.sections for name in ending.unknowns}
    for name, sentence in {**derivation.unknowns, **new}.items():
        if name in used or steps or name in new:
            parts = _WHICH.fullmatch(sentence)
            head, which, tail = parts.groups() if parts else (sentence, "", "")
            together.setdefault((head, tail), {})[name] = which
    for (head, tail), named in together.items():
        if len(named) > 1:
            head = head.replace("displacement ", "displacements ")
            tail = tail.replace(" component ", " components ")
        told = steps and (head in _TOLD or not explained.isdisjoint(named))
        which = enumerate_words([*dict.fromkeys(named.values())])
        entries.append(Meaning((*named,), f"{head}{which}{tail}", told=told))
    lefts = [
        *(_collect_lefts(derivation) if steps else ()),
        *lefts_of(chain(*(ending.lines for ending in endings))),
    ]
    known = {name for entry in entries for name in entry.names}
    entries += _explain_steps(derivation, lefts, known, steps=steps)
    if "t" in used:
        entries.append(Meaning(("t",), "time [s]"))
    return tuple(entries)


def clashes(derivation: Derivation, *, steps: bool, matrices: bool) -> Iterator[str]:
    """Yield a warning for each letter with two meanings."""
    mechanism = derivation.algebra.mechanism
    stated = {parameter.symbol: parameter.meaning for parameter in mechanism.parameters}
    stated |= {signal.symbol: signal.meaning for signal in mechanism.inputs}
    used = _collect_kinds(derivation, steps=steps)
    other: dict[str, str] = {}
    if steps:
        lefts = {left.symbol for left in _collect_lefts(derivation)}
        other |= {letter: _FOUND[letter][0] for letter in lefts if letter in _FOUND}
    if matrices:
        other |= {"M": "matrix of masses", "C": "matrix of dampings", "K": "stiffness matrix"}
        other |= {"f": "column of forces"}
    for letter, meaning in other.items():
        if letter in stated and letter in used:
            yield (
                f"Beware: {letter} stands for the {stated[letter] or 'parameter'}; alone on the "
                f"left of a step, in a derivative or before a column it is the {meaning}."
            )


def _collect_lefts(derivation: Derivation) -> list[Left]:
    """The quantities on the left sides of the steps, in order."""
    return [*lefts_of(line for stage in derivation.stages for line in stage.results)]


def _collect_kinds(derivation: Derivation, *, steps: bool) -> dict[str, Kind]:
    """Collect the kind of every printed symbol, by its name."""
    shown = [*derivation.rows, *(tie.demand for tie in derivation.ties)]
    for stage in derivation.stages if steps else ():
        for result in stage.results:
            shown.append(result.right)
            if isinstance(result.left, Series):
                shown.append(result.left)
    shown += [assumption.positive for assumption in derivation.assumptions if steps]
    kinds = {g.name: g.kind for series in shown for g in series.generators()}
    sides = [side for line in derivation.written or () for side in (line.left, line.right)]
    return {name: Kind.PARAMETER for side in sides for name in side.letters} | kinds


def _explain_followers(
    derivation: Derivation, used: dict[str, Kind], *, led: bool
) -> Iterator[Meaning]:
    """Yield the joint coordinates that the map gives, but unused sums of coordinates alone."""
    algebra = derivation.algebra
    of_joint = CoordinateWords(algebra.mechanism).of_joints
    for name, value in follow(algebra):
        if led or name in used or value.kinds != {Kind.COORDINATE}:
            yield Meaning((name,), of_joint.get(name, "joint coordinate"), expression(value))


def _explain_signals(derivation: Derivation, used: dict[str, Kind]) -> Iterator[Meaning]:
    """Yield the inputs, each with its expression if that contains letters."""
    algebra = derivation.algebra
    for signal in algebra.mechanism.inputs:
        if signal.symbol in used:
            law = expression(algebra.series(signal.signal)) if signal.symbols else None
            sentence = _add_unit(signal.meaning or "function of time", signal.unit)
            yield Meaning((signal.symbol,), sentence, law)


def _explain_steps(
    derivation: Derivation, lefts: Sequence[Left], known: set[str], *, steps: bool
) -> Iterator[Meaning]:
    """Yield the meanings of left sides, which steps explain themselves."""
    names = [*dict.fromkeys(left.symbol for left in lefts)]
    names = [name for name in names if name.rstrip("'") not in known]
    if any(left.turning for left in lefts):
        sentence = "angular velocity [rad/s] and velocity [m/s] of the body, in its own axes"
        yield Meaning(("ω", "v"), sentence)
    if steps:
        yield Meaning(tuple(names), "", told=True)
        return
    rates = _find_rates(derivation.algebra.mechanism)
    for name in names:
        letter, _, coordinate = name.partition("_")
        what, unit = _FOUND.get(name, (f"momentum of {coordinate}", ""))
        if letter == "p" and coordinate in rates:
            unit = say_unit(divide(read_unit("J"), rates[coordinate]))
        yield Meaning((name,), _add_unit(what, unit))


def _find_rates(mechanism: Mechanism) -> dict[str, Dimension]:
    """Find the dimension of each coordinate's rate and of each quasi-velocity."""
    known, second = dimensions_of(mechanism).states, read_unit("s")
    rates = {name: divide(known[name], second) for name in mechanism.coordinates if name in known}
    return rates | {name: known[name] for name in mechanism.velocities if name in known}


def _add_unit(meaning: str, unit: str) -> str:
    return meaning if unit in ("", "1") else f"{meaning} [{unit}]"
