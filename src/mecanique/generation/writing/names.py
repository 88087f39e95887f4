"""Name the results of a recursion, and explain them."""

from __future__ import annotations

from collections.abc import Collection, Iterator

from mecanique.derivation.mechanics.recursion import Recursion
from mecanique.model.mechanism import Mechanism
from mecanique.model.units import units
from mecanique.program.tape import Tape
from mecanique.program.traced import Traced, value_of

_MEANINGS = {
    "w": "angular velocity of {} [rad/s]",
    "alpha": "angular acceleration of {} [rad/s²]",
    "a": "acceleration of the origin of {} minus that of free fall [m/s²]",
    "F": "force that accelerates {} and all bodies beyond [N]",
    "N": "moment that accelerates {} and all bodies beyond, about its origin [N·m]",
}


def spell(name: str) -> str:
    """Spell the name of a part as a subscript."""
    return "".join(sign if sign.isalnum() else "_" for sign in name)


def name_results(recursion: Recursion) -> dict[int, str]:
    """Return the names of the components of the links' vectors, by place on the tape."""
    names: dict[int, str] = {}
    for letter, vectors in recursion.found.items():
        for body, vector in zip(_bodies(recursion), vectors, strict=True):
            for axis, component in zip("xyz", vector, strict=True):
                known = isinstance(component, Traced)
                place = value_of(component) if known else None
                inner = isinstance(place, int) and recursion.letters.tape.operations[place]
                if isinstance(place, int) and inner and inner[0] != "input":
                    names.setdefault(place, f"{letter}_{spell(body)}_{axis}")
    return names


def name_functions(tape: Tape, taken: dict[int, str]) -> dict[int, str]:
    """Return the names of sines and cosines of coordinates, s_q1 and c_q1."""
    names: dict[int, str] = {}
    for place, (kind, values, _) in enumerate(tape.operations):
        if kind in ("sin", "cos") and place not in taken:
            (inner,) = values
            operation = tape.operations[inner] if isinstance(inner, int) else ("", (), "")
            if operation[0] == "input":
                names[place] = f"{kind[0]}_{operation[2]}"
    return names


def explain_letters(
    mechanism: Mechanism, used: Collection[str]
) -> Iterator[tuple[tuple[str, ...], str]]:
    """Yield the meanings of a mechanism's coordinates, velocities and parameters."""
    known = units(mechanism)
    for name in (*mechanism.coordinates, *mechanism.velocities):
        kind = "coordinate" if name in mechanism.coordinates.names else "generalized velocity"
        unit = known.get(name, "")
        yield (name,), f"{kind} [{unit}]" if unit not in ("", "1") else kind
    for parameter in mechanism.parameters:
        if parameter.symbol in used:
            unit = "" if parameter.unit == "1" else f" [{parameter.unit}]"
            yield (parameter.symbol,), f"{parameter.meaning or 'parameter'}{unit}"
    for signal in mechanism.inputs:
        if signal.symbol in used:
            yield (signal.symbol,), signal.meaning or "input"


def explain_results(
    recursion: Recursion, defined: set[str]
) -> Iterator[tuple[tuple[str, ...], str]]:
    """Yield the meanings of the named vectors with a component in the list."""
    for body in _bodies(recursion):
        for letter, sentence in _MEANINGS.items():
            every = [f"{letter}_{spell(body)}_{axis}" for axis in "xyz"]
            parts = tuple(name for name in every if name in defined)
            if parts:
                yield parts, sentence.format(body)
    for name in sorted(defined):
        if name.startswith(("s_", "c_")):
            yield (name,), f"{'sine' if name[0] == 's' else 'cosine'} of {name[2:]}"


def explain_force(mechanism: Mechanism, row: str) -> str:
    """Explain the multiplier of a row, e.g. a force of a contact, with its direction.

    Args:
        mechanism: the mechanism with the constraint.
        row: "contact: motion it prevents", "loop: motion it closes", or a velocity constraint's
            name.
    """
    name, _, motion = row.partition(": ")
    for contact in mechanism.contacts:
        if contact.name == name:
            return contact.forces_of[motion].format(f"of {contact.on} on {contact.body} in {name}")
    if motion:
        return f"multiplier of loop {name}, {motion}"
    return f"multiplier of velocity constraint {name}"


def _bodies(recursion: Recursion) -> list[str]:
    """Return the body after which each moving link is named."""
    first: dict[int, str] = {}
    for body, seat in recursion.seats.items():
        first.setdefault(seat.place, body)
    return [first.get(place, f"link{place + 1}") for place in range(len(recursion.links))]
