"""State what every symbol of a derivation means, and in which unit its equations are."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import chain
from typing import final

from mecanique.derivation.printing.equations import expression, root
from mecanique.derivation.printing.expressions import to_sympy
from mecanique.derivation.printing.writers import Equation, Expression
from mecanique.derivation.scalars.series import FOLLOWER, Kind, Series
from mecanique.derivation.symbolic.derivation import (
    Derivation,
    Ending,
    Left,
    Tie,
    lefts_of,
)
from mecanique.derivation.tolerances import ALIGNED
from mecanique.model.expression import symbols_in
from mecanique.model.joint_base import UNITS, Single
from mecanique.model.joints import Joint, Planar, Universal
from mecanique.model.mechanism import Mechanism
from mecanique.model.mechanism.homogeneity import dimensions_of
from mecanique.model.mechanism_units import units
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
    dimensions = _collect_dimensions(derivation)
    found: list[Dimension | None] = []
    for term in (*equation.left.terms, *equation.right.terms):
        try:
            found.append(dimensions.of(term.sympy()))
        except HomogeneityError:  # a plain number stands for a quantity with a unit
            found.append(None)
    return tuple(found)


def unit_of(derivation: Derivation, equation: Equation) -> str:
    """Return the unit of the terms of an equation, that of most terms if they differ."""
    # They differ where plain numbers stand for quantities with a unit
    known = [its for its in find_units(derivation, equation) if its is not None]
    return say_unit(Counter(known).most_common(1)[0][0]) if known else ""


def _collect_dimensions(derivation: Derivation) -> Dimensions:
    """Return the dimensions of all letters: the mechanism's own, a, roots and multipliers."""
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
    return Dimensions(known, {})


_PARTS = ("x component", "y component", "z component", "scalar part")

_FOUND = {
    "T": ("kinetic energy", "J"),
    "V": ("potential energy", "J"),
    "V_eff": ("effective potential", "J"),
    "E": ("total energy, T + V", "J"),
    "h": ("Jacobi's integral", "J"),
    "D": ("Rayleigh's dissipation function", "W"),
    "R": ("Routh's function", "J"),
    "r": ("position of the center of mass", "m"),
    "v": ("velocity of the center of mass", "m/s"),
    "a": ("acceleration of the center of mass", "m/s²"),
    "m": ("mass", "kg"),
    "c": ("center of mass in its own frame", "m"),
    "I": ("moments of inertia about the center of mass", "kg·m²"),
    "H": ("angular momentum", "kg·m²/s"),
    "omega": ("angular velocity", "rad/s"),
    "Omega": ("angular velocity of the axes", "rad/s"),
    "F": ("force", "N"),
    "C": ("couple", "N·m"),
    "f": ("inertia force per length", "N/m"),
    "s": ("distance from the end to the point where the inertia forces act", "m"),
    "δr": ("virtual displacement of the point of action", "m"),
    "δφ": ("virtual rotation", "rad"),
    "δW": ("virtual work", "J"),
    "Phi": ("left side of the constraint Φ = 0", ""),
    "psi": ("left side of the velocity constraint ψ = 0", ""),
}
"""The meaning and unit of each letter that a step may have on its left side."""

_OF_COORDINATE = {
    "Q": (
        "generalized forces of drives and loads, each for the coordinate it is named after",
        "generalized force of drives and loads for {}",
        "W",
    ),
    "p": ("momenta, each of the coordinate it is named after", "momentum of {}", "J"),
    "δW": (
        "virtual work in the displacement of the coordinate it is named after",
        "virtual work in the displacement of {}",
        "",
    ),
}
"""Quantities that belong to coordinates: what several and one of them, of the coordinate {}, are
called, and the unit of their product with the velocity."""

_ACTS = {
    "F_weight": "weight of {}",
    "δr_weight": "virtual displacement of the center of mass of {}",
    "δW_weight": "virtual work of the weight of {}",
    "F_inertia": "resultant of the inertia forces of {}",
    "C_inertia": "couple of the inertia forces of {}",
    "δr_inertia": "virtual displacement of the point where the inertia forces of {} act",
    "δφ_inertia": "virtual rotation of {}",
    "δW_inertia": "virtual work of the inertia forces of {}",
    "δW_couple_inertia": "virtual work of the couple of the inertia forces of {}",
    "δW_couple": "virtual work of the couple of {}",
    "δW_R": "virtual work of the reaction in {}",
    "s": "distance from the end of {} to the point where its inertia forces act",
}
"""The meaning of quantities whose names begin so; {} stands for the owner named by the rest."""


@final
@dataclass(frozen=True)
class Meaning:
    """The meaning of a symbol, or of several components of one quantity."""

    names: tuple[str, ...]
    sentence: str
    # the value, if the symbol is an abbreviation or follows from others
    definition: Expression | None = None


def meanings(
    derivation: Derivation, endings: Sequence[Ending] = (), *, steps: bool = True
) -> tuple[Meaning, ...]:
    """Return the meaning of every printed symbol, in the order of the list of symbols."""
    algebra = derivation.algebra
    ring, mechanism = algebra.ring, algebra.mechanism
    used = _collect_kinds(derivation, steps=steps)
    followers = [*_explain_followers(derivation)]
    signals = [*_explain_signals(derivation, used)]
    for entry in [*followers, *signals]:
        stated = entry.definition.letters if entry.definition is not None else ()
        used |= {name: Kind.PARAMETER for name in stated if name not in used}
    entries = [*explain_coordinates(mechanism), *followers]
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
    together: dict[str, list[str]] = {}
    new = {name: meant for ending in endings for name, meant in ending.unknowns.items()}
    for name, sentence in {**derivation.unknowns, **new}.items():
        if name in used or steps or name in new:
            together.setdefault(sentence, []).append(name)
    entries += [Meaning(tuple(names), sentence) for sentence, names in together.items()]
    lefts = [
        *(_collect_lefts(derivation) if steps else ()),
        *lefts_of(chain(*(ending.lines for ending in endings))),
    ]
    known = {name for entry in entries for name in entry.names}
    entries += _explain_steps(derivation, lefts, known)
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
    return {g.name: g.kind for series in shown for g in series.generators()}


def explain_coordinates(mechanism: Mechanism) -> Iterator[Meaning]:
    """Yield the meanings of a mechanism's coordinates, and of velocities that are no rates."""
    # followers among them are no coordinates of the mechanism
    of_joint = dict(pair for joint in mechanism.joints for pair in _explain_joint(joint, mechanism))
    unit = units(mechanism)
    driven = mechanism.coordinates.driven.items()
    for name in mechanism.coordinates:
        follow = [joint for joint, law in driven if name in symbols_in(law)]
        sets = f" that sets {enumerate_words(follow)}" if follow else ""
        yield Meaning(
            (name,), of_joint.get(name) or _add_unit(f"generalized coordinate{sets}", unit[name])
        )
    for joint in mechanism.joints:
        if not joint.quaternion:
            continue
        for velocity in joint.velocities:
            linear = velocity in joint.linear_velocities
            what, of_unit = ("velocity", "m/s") if linear else ("angular velocity", "rad/s")
            of = f"the {what} of {_name_child(joint, mechanism)}, in its own axes [{of_unit}]"
            yield Meaning((velocity,), f"{velocity[-1]} component of {of}")


def _explain_followers(derivation: Derivation) -> Iterator[Meaning]:
    """Yield the joint coordinates that the coordinate map gives, each with its expression."""
    algebra = derivation.algebra
    mechanism = algebra.mechanism
    of_joint = dict(pair for joint in mechanism.joints for pair in _explain_joint(joint, mechanism))
    named = {
        algebra.ring.generators[index].name: atom.argument
        for index, atom in algebra.ring.atoms.items()
        if atom.function == FOLLOWER
    }
    for name in mechanism.coordinates.driven:
        value = named.get(name) or algebra.lift(algebra.values[name])
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
    derivation: Derivation, lefts: Sequence[Left], known: set[str]
) -> Iterator[Meaning]:
    """Yield the meanings of the left sides of steps, components of one quantity together."""
    mechanism = derivation.algebra.mechanism
    owners = [part.name for part in (*mechanism.bodies, *mechanism.joints, *mechanism.forces)]
    owners += [tie.name for tie in derivation.ties]
    rates = _find_rates(mechanism)
    demands = {f"{tie.letter}_{tie.name}": _find_unit(tie) for tie in derivation.ties}
    groups: dict[str, list[str]] = {}
    for left in lefts:
        name = left.symbol
        if name.rstrip("'") not in known:
            if left.component:
                sentence = _explain_component(left, rates)
            else:
                sentence = _explain(left, owners, demands)
            if name not in groups.setdefault(sentence, []):
                groups[sentence].append(name)
    if any(left.turning for left in lefts):
        sentence = "angular velocity [rad/s] and velocity [m/s] of the body, in its own axes"
        yield Meaning(("ω", "v"), sentence)
    for sentence, names in groups.items():
        if len(names) == 1:
            _, _, coordinate = names[0].partition("_")
            for plural, singular, _ in _OF_COORDINATE.values():
                sentence = sentence.replace(plural, singular.format(coordinate))
        yield Meaning(tuple(names), sentence)


def _find_rates(mechanism: Mechanism) -> dict[str, Dimension]:
    """Find the dimension of each coordinate's rate and of each quasi-velocity."""
    known, second = dimensions_of(mechanism).states, read_unit("s")
    rates = {name: divide(known[name], second) for name in mechanism.coordinates if name in known}
    return rates | {name: known[name] for name in mechanism.velocities if name in known}


def _find_unit(tie: Tie) -> str:
    """The unit of Φ or ψ: times its multiplier, Φ is a work and ψ a power."""
    stated = UNIT_AT_END.search(tie.meaning)
    if stated is None:
        return ""
    return say_unit(divide(read_unit("W" if tie.of_velocities else "J"), read_unit(stated[1])))


def _explain_component(left: Left, rates: Mapping[str, Dimension]) -> str:
    """Explain a momentum, a generalized force or a virtual work that belongs to one coordinate."""
    what, _, product = _OF_COORDINATE[left.quantity]
    if not product:
        return f"{what} [J]"
    rate = rates.get(left.by)
    return what if rate is None else f"{what} [{say_unit(divide(read_unit(product), rate))}]"


def _explain(left: Left, owners: Iterable[str], demands: Mapping[str, str]) -> str:
    """Explain a quantity of a step by its letter and the body, joint or force it belongs to."""
    base, _, rest = left.quantity.partition("_")
    if left.quantity in _FOUND:
        base, rest = left.quantity, ""
    what, unit = _FOUND[base]
    if rest:
        what = f"{what} of {{}}"
    known = [*owners]
    for words in sorted(_ACTS, key=len, reverse=True):
        if left.quantity.startswith(f"{words}_") and rest not in known:
            what, rest = _ACTS[words], left.quantity.removeprefix(f"{words}_")
            break
    owner = _find_owner(rest, known) or rest
    other = _find_owner(rest.removeprefix(f"{owner}_"), known) if rest != owner else ""
    return _add_unit(
        what.format(f"{owner} on {other}" if other else owner), demands.get(left.quantity, unit)
    )


def _find_owner(name: str, owners: Iterable[str]) -> str:
    """Return the longest owner that a name begins with, "" if there is none."""
    held = [owner for owner in owners if name == owner or name.startswith(f"{owner}_")]
    return max(held, key=len, default="")


def _explain_joint(joint: Joint, mechanism: Mechanism) -> Iterator[tuple[str, str]]:
    """Yield name and meaning of each coordinate of a joint."""
    names = [name for name in joint.coordinates if name not in joint.followers]
    match joint:
        case Single() if joint.turns:
            sentences = [f"angle of the {_name_joint(joint)}, about {_say_axis(joint)} [rad]"]
        case Single() if position := _say_position(joint, mechanism):
            sentences = [position]
        case Single():
            sentences = [f"displacement in the {_name_joint(joint)}, along {_say_axis(joint)} [m]"]
        case Planar():
            sentences = [
                f"displacement of {joint.child} along {_say_direction(axis, joint)} [m]"
                for axis in joint.directions
            ]
            sentences.append(f"angle of {joint.child} about {_say_axis(joint)} [rad]")
        case Universal():
            sentences = [
                f"angle of the Cardan joint {joint.name} about {axis} [rad]"
                for axis in ("x", "the turned y")
            ]
        case _:
            linear = zip("xyz", joint.linear_coordinates, strict=False)
            moved = _name_child(joint, mechanism)
            sentences = [f"{axis} coordinate of {moved} [m]" for axis, _ in linear]
            parts = zip(_PARTS, joint.quaternion, strict=False)
            sentences += [f"{part} of the unit quaternion of {joint.child}" for part, _ in parts]
    yield from zip(names, sentences, strict=True)
    kinds = dict(zip(joint.coordinates, joint.kinds, strict=True))
    for name in joint.followers:
        yield name, f"dependent coordinate of joint {joint.name} [{UNITS[kinds[name]]}]"


def _say_position(slide: Single, mechanism: Mechanism) -> str:
    """Say the position of what massless carriers on slides lead, "" if none leads this slide."""
    bodies = {body.name: body for body in mechanism.bodies}
    leads = {joint.child: joint for joint in mechanism.joints}
    first, led, others = slide, slide.child, list[Joint]()
    while not mechanism.evaluate(bodies[led].mass):
        beyond = [joint for joint in mechanism.joints if joint.parent == led]
        if len(beyond) != 1:
            return ""
        others += beyond
        led = beyond[0].child
    while first.parent in leads:
        above = leads[first.parent]
        turned = any(map(mechanism.evaluate, first.origin.rpy))
        carries = not mechanism.evaluate(bodies[above.child].mass)
        if turned or not (isinstance(above, Single) and not above.turns and carries):
            return ""
        others.append(above)
        first = above
    places = [x for joint in (slide, *others) for x in joint.origin.xyz]
    slides = [joint for joint in others if isinstance(joint, Single) and not joint.turns]
    along = any(a * b for other in slides for a, b in zip(slide.axis, other.axis, strict=True))
    if not others or along or any(map(mechanism.evaluate, places)):
        return ""
    centered = not any(map(mechanism.evaluate, bodies[led].center))
    axis = _say_direction(slide.axis, first)
    return f"position of the {'center' if centered else 'origin'} of {led} along {axis} [m]"


def _name_child(joint: Joint, mechanism: Mechanism) -> str:
    """Name what a joint moves, and relative to what if that is not the ground."""
    relative = "" if joint.parent == mechanism.ground else f" relative to {joint.parent}"
    return f"{joint.child}{relative}"


def _name_joint(joint: Single) -> str:
    """Name a joint by its kind and name, once where they are the same word."""
    return joint.noun if joint.name == joint.noun else f"{joint.noun} {joint.name}"


def _say_axis(joint: Single | Planar) -> str:
    return _say_direction(joint.axis, joint)


def _say_direction(axis: tuple[float, float, float], joint: Joint | Single) -> str:
    """Put an axis in words, e.g. −y of ground, or of the joint's frame if that is turned."""
    turned = any(not isinstance(angle, float) or angle for angle in joint.origin.rpy)
    of = f"the frame of joint {joint.name}" if turned else joint.parent
    for name, component in zip("xyz", axis, strict=True):
        if abs(component) > 1 - ALIGNED:
            return f"{'-' if component < 0 else ''}{name} of {of}"
    return f"({', '.join(f'{component:.6g}' for component in axis)}) of {of}"


def _add_unit(meaning: str, unit: str) -> str:
    return meaning if unit in ("", "1") else f"{meaning} [{unit}]"
